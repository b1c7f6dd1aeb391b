//! Names of columns as people write them: quantity and unit.

use crate::quantities::Quantity;
use crate::units::{Dimension, Unit};

/// Names without unit, marks and blanks, `?` being an axis or a side; and one that needs a unit to be understood.
const fn names(dimension: Dimension) -> (&'static str, &'static str) {
    match dimension {
        Dimension::Time => (
            "time abstime abstimes reltime relativetime elapsedtime timestamp datetime xvalue tstamp zeit messzeit zeitstempel \
             temps tempo tiempo hora čas",
            "t",
        ),
        Dimension::Force => (
            "f? force? ?force forcef? kraft? kraftf? fuerza? forza? effort? síla? sila?",
            "",
        ),
        Dimension::Moment => (
            "m? moment? ?moment momentm? torque? ?torque drehmoment? momento? coppia?",
            "t?",
        ),
        Dimension::Speed => (
            "speed rpm spindlespeed shaftspeed rotationalspeed drehzahl spindeldrehzahl vitesse velocidad velocità giri otáčky",
            "n",
        ),
        Dimension::Temperature => ("t? temp? temperature? temperatur?", ""),
    }
}

/// A column's name, split into quantity and unit.
#[derive(Debug, Clone)]
pub struct Heading {
    pub text: String,
    /// Small letters and digits of the name without its unit, together and word by word.
    pub stem: String,
    words: Vec<String>,
    /// The unit as the name has it, if it has one.
    pub unit: Option<String>,
}

impl Heading {
    /// `Fx [N]`, `Force X (kN)`, `t / s`, `Zeit in s`, `n 1/min`, `fx_n`.
    pub fn new(text: &str) -> Self {
        let line = text.replace(['\n', '\r'], " ");
        let mut brackets = [('[', ']'), ('(', ')'), ('{', '}')].into_iter();
        let brackets = brackets.find_map(|(open, close)| {
            let (before, rest) = line.split_once(open)?;
            let (unit, after) = rest.split_once(close)?;
            Some((format!("{before}{after}"), unit))
        });
        let split = brackets.or_else(|| {
            if let Some((stem, unit)) = line.rsplit_once(" in ") {
                return Some((stem.to_owned(), unit));
            }
            // The longest unit at the end.
            let marks = line.match_indices([' ', '/', ',', '_']);
            let mut parts = marks.map(|(at, mark)| (&line[..at], &line[at + mark.len()..]));
            let (stem, unit) =
                parts.find(|(stem, unit)| !stem.is_empty() && Unit::named(unit).is_some())?;
            Some((stem.to_owned(), unit))
        });
        let (stem, unit) = split.unwrap_or((line.clone(), ""));
        let stem = stem.to_lowercase();
        let words = stem.split(|c: char| !c.is_alphanumeric());
        let words: Vec<String> = words.map(str::to_owned).collect();
        let unit = unit.trim();
        let is_speed = stem == "rpm" && unit.is_empty();
        Self {
            text: text.to_owned(),
            stem: words.concat(),
            words,
            unit: match is_speed {
                true => Some("rpm".to_owned()),
                false => (!unit.is_empty()).then(|| unit.to_owned()),
            },
        }
    }

    /// The unit that the name says.
    pub fn said(&self) -> Option<Unit> {
        self.unit.as_deref().and_then(Unit::named)
    }

    /// Whether it names a quantity, `unit` being the one that is said of it.
    pub fn means(&self, quantity: Quantity, unit: Option<Unit>) -> bool {
        let dimension = quantity.dimension();
        if unit.is_some_and(|unit| unit.dimension != dimension) {
            return false;
        }
        let axis = match dimension {
            Dimension::Force | Dimension::Moment => &quantity.name()[1..],
            Dimension::Temperature => &quantity.name()[2..],
            _ => "",
        };
        let (always, by_unit) = names(dimension);
        let by_unit = if unit.is_some() { by_unit } else { "" };
        let is_name = |stem: &str| {
            let names = always.split(' ').chain(by_unit.split(' '));
            let mut names = names.filter(|name| !name.is_empty());
            names.any(|name| match name.split_once('?') {
                None => name == stem,
                Some((before, after)) => {
                    let middle = stem.strip_prefix(before);
                    middle.and_then(|rest| rest.strip_suffix(after)) == Some(axis)
                }
            })
        };
        // A word of the name is enough for an axis, and where the unit fits.
        let has_axis = matches!(dimension, Dimension::Force | Dimension::Moment);
        let mut words = self.words.iter();
        is_name(&self.stem) || (has_axis || unit.is_some()) && words.any(|word| is_name(word))
    }
}
