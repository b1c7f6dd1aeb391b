//! Quantities of a recording: their names in people's files, and what a user says of them.

use crate::units::{Dimension, Unit};
use std::fmt::Write;

/// A quantity of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Time, s.
    Time,
    /// Axial force, N.
    Fx,
    /// Radial force, N.
    Fy,
    /// Radial force, N.
    Fz,
    /// Moment about the shaft, N m: only of use where axes are turned.
    Mx,
    /// Tilting moment, N m.
    My,
    /// Tilting moment, N m.
    Mz,
    /// Shaft speed, rpm.
    Speed,
    /// Temperature of the inner side, degrees Celsius.
    TInner,
    /// Temperature of the outer side, degrees Celsius.
    TOuter,
}

/// Number of quantities.
pub const QUANTITIES: usize = Quantity::ALL.len();

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Time,
        Self::Fx,
        Self::Fy,
        Self::Fz,
        Self::Mx,
        Self::My,
        Self::Mz,
        Self::Speed,
        Self::TInner,
        Self::TOuter,
    ];

    /// Its name on a command line, its column in the project's own recordings, what it measures.
    const fn facts(self) -> (&'static str, &'static str, Dimension) {
        match self {
            Self::Time => ("time", "time_s", Dimension::Time),
            Self::Fx => ("fx", "fx_n", Dimension::Force),
            Self::Fy => ("fy", "fy_n", Dimension::Force),
            Self::Fz => ("fz", "fz_n", Dimension::Force),
            Self::Mx => ("mx", "mx_nm", Dimension::Moment),
            Self::My => ("my", "my_nm", Dimension::Moment),
            Self::Mz => ("mz", "mz_nm", Dimension::Moment),
            Self::Speed => ("speed", "speed_rpm", Dimension::Speed),
            Self::TInner => ("t_inner", "t_inner_c", Dimension::Temperature),
            Self::TOuter => ("t_outer", "t_outer_c", Dimension::Temperature),
        }
    }

    /// As a command line has it.
    pub const fn name(self) -> &'static str {
        self.facts().0
    }

    /// The column of the project's own recordings.
    pub const fn column(self) -> &'static str {
        self.facts().1
    }

    /// What it measures.
    pub const fn dimension(self) -> Dimension {
        self.facts().2
    }

    /// The one of this name on a command line.
    ///
    /// # Errors
    ///
    /// There is none.
    pub fn named(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|one| one.name() == name.trim());
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("{name:?} is none of {names}")
        })
    }
}

/// Names without unit, marks and blanks, by dimension, `?` being an axis or a side. Of the last ones the unit must tell what they are.
#[rustfmt::skip]
const NAMES: [(&str, &str); 5] = [
    ("time abstime abstimes reltime relativetime elapsedtime timestamp xvalue zeit messzeit temps tempo tiempo", "t"),
    ("f? force? ?force forcef? kraft? kraftf?", ""),
    ("m? moment? ?moment momentm? torque? ?torque drehmoment?", "t?"),
    ("speed rpm spindlespeed shaftspeed rotationalspeed drehzahl spindeldrehzahl", "n"),
    ("t?", ""),
];

/// A column's name, split into quantity and unit.
#[derive(Debug, Clone)]
pub struct Heading {
    /// As the file has it.
    pub text: String,
    stem: String,
    /// The unit's name, if there is one.
    unit_name: Option<String>,
    /// The unit, if it is known.
    pub unit: Option<Unit>,
}

impl Heading {
    /// `Fx [N]`, `Force X (kN)`, `t / s`, `Zeit in s`, `fx_n`.
    pub fn new(text: &str) -> Self {
        let mut brackets = [('[', ']'), ('(', ')')].into_iter();
        let brackets =
            brackets.find_map(|(open, close)| text.strip_suffix(close)?.rsplit_once(open));
        let split = brackets.or_else(|| {
            let marks = [" in ", "/", ",", "_", " "].into_iter();
            let mut parts = marks.filter_map(|mark| text.rsplit_once(mark));
            parts.find(|(stem, unit)| !stem.is_empty() && Unit::named(unit).is_some())
        });
        let (stem, unit) = split.unwrap_or((text, ""));
        let letters = stem.chars().filter(|c| c.is_alphanumeric());
        let mut heading = Self {
            text: text.to_owned(),
            stem: letters.collect::<String>().to_lowercase(),
            unit_name: None,
            unit: None,
        };
        heading.add_unit(Some(unit.trim().to_owned()).filter(|unit| !unit.is_empty()));
        heading
    }

    /// Takes the unit that another line has, if its own name has none.
    pub fn add_unit(&mut self, name: Option<String>) {
        if self.unit_name.is_none() {
            self.unit = name.as_deref().and_then(Unit::named);
            self.unit_name = name;
        }
    }

    /// Takes the unit of counts, if it has counts or a quantity without a unit.
    pub fn count(&mut self, unit: Unit) {
        let name = self.unit_name.as_deref().unwrap_or("counts");
        let counts = Self {
            unit: Some(unit),
            unit_name: None,
            ..self.clone()
        };
        if name.eq_ignore_ascii_case("counts") && Quantity::ALL.iter().any(|one| counts.means(*one))
        {
            *self = counts;
        }
    }

    /// The name of a unit that is none.
    pub fn strange_unit(&self) -> Option<&str> {
        self.unit_name.as_deref().filter(|_| self.unit.is_none())
    }

    /// Whether it means a quantity, by its name and its unit.
    pub fn means(&self, quantity: Quantity) -> bool {
        let dimension = quantity.dimension();
        let (names, by_unit) = NAMES[dimension as usize];
        let fits = self.unit.map(|unit| unit.dimension == dimension);
        let axis = match dimension {
            Dimension::Force | Dimension::Moment => &quantity.name()[1..],
            Dimension::Temperature => &quantity.name()[2..],
            _ => "",
        };
        let is = |name: &str| name.replace('?', axis) == self.stem;
        fits != Some(false) && (names.split(' ').any(is) || fits.is_some() && is(by_unit))
    }
}

/// What a user says of a recording besides what its columns do.
#[derive(Debug, Clone)]
pub struct Told {
    /// The columns of quantities, by name or by number; `-` is no column. A minus before the name turns the sign.
    pub columns: Vec<(Quantity, String)>,
    /// The recording's axis and its sign for each axis of the bearing.
    pub axes: [(usize, f64); 3],
    /// Quantities that are constant.
    pub given: [Option<f64>; QUANTITIES],
    /// One record of so many is read.
    pub every: usize,
    /// Temperatures are needed.
    pub heat: bool,
}

impl Default for Told {
    fn default() -> Self {
        Self {
            columns: Vec::new(),
            axes: [0, 1, 2].map(|axis| (axis, 1.0)),
            given: [None; QUANTITIES],
            every: 1,
            heat: false,
        }
    }
}

impl Told {
    /// Adds columns such as `time=Zeit [s],fx=Fy`.
    pub fn add_columns(&mut self, text: &str) -> Result<(), String> {
        let mut columns: Vec<(Quantity, String)> = Vec::new();
        for part in text.split(',') {
            let pair = part.split_once('=');
            let pair = pair.map(|(key, name)| (Quantity::named(key), name));
            match (pair, columns.last_mut()) {
                (Some((Ok(quantity), name)), _) => columns.push((quantity, name.to_owned())),
                // A comma of a column's name.
                (None, Some((_, name))) => *name += &format!(",{part}"),
                (Some((Err(error), _)), _) => return Err(error),
                (None, None) => {
                    return Err("columns are QUANTITY=NAME, such as fx=\"Force X\"".to_owned());
                }
            }
        }
        for (quantity, name) in columns {
            if self.columns.iter().any(|(other, _)| *other == quantity) {
                return Err(format!("{} is given twice", quantity.name()));
            }
            let name = name.trim();
            let name = name
                .strip_prefix('"')
                .and_then(|name| name.strip_suffix('"'))
                .unwrap_or(name);
            self.columns.push((quantity, name.to_owned()));
        }
        Ok(())
    }

    /// Takes axes such as `x=Fz,y=-Fx,z=Fy`.
    pub fn set_axes(&mut self, text: &str) -> Result<(), String> {
        let mut found = [None; 3];
        for part in text.split(',') {
            let read = || {
                let (own, other) = part.trim().split_once('=')?;
                let other = other.trim().to_lowercase();
                let (sign, name) = match other.strip_prefix('-') {
                    Some(name) => (-1.0, name),
                    None => (1.0, other.strip_prefix('+').unwrap_or(&other)),
                };
                let axis = ["x", "y", "z"].into_iter();
                let own = axis
                    .clone()
                    .position(|axis| axis == own.trim().to_lowercase())?;
                let name = name.strip_prefix('f').unwrap_or(name);
                Some((own, (axis.clone().position(|axis| axis == name)?, sign)))
            };
            let (own, other) = read().ok_or("axes are x=Fz,y=-Fx,z=Fy: each axis of the bearing's frame, and the recording's force along it")?;
            if found[own].replace(other).is_some() {
                return Err(format!("an axis is given twice: {part}"));
            }
        }
        let axes = found.map(|axis| axis.unwrap_or((3, 0.0)));
        if (0..3).any(|axis| !axes.iter().any(|one| one.0 == axis)) {
            return Err("each of x, y, z and of Fx, Fy, Fz must be there once".to_owned());
        }
        self.axes = axes;
        Ok(())
    }

    /// Whether a column of this name is told of.
    pub fn names(&self, text: &str) -> bool {
        let mut columns = self.columns.iter();
        columns.any(|(_, name)| name.trim_start_matches('-').eq_ignore_ascii_case(text))
    }

    /// The recorded quantity that a bearing's is, and its sign.
    pub fn recorded(&self, quantity: Quantity) -> (Quantity, f64) {
        let own = quantity as usize;
        match quantity.dimension() {
            Dimension::Force | Dimension::Moment => {
                let first = if own < Quantity::Mx as usize {
                    Quantity::Fx
                } else {
                    Quantity::Mx
                };
                let (axis, sign) = self.axes[own - first as usize];
                (Quantity::ALL[first as usize + axis], sign)
            }
            _ => (quantity, 1.0),
        }
    }

    /// Axes of a mirrored frame: what its moments mean depends on how they were worked out.
    pub fn is_mirrored(&self) -> bool {
        let [(x, a), (y, b), (_, c)] = self.axes;
        let cyclic = (x + 1) % 3 == y;
        a * b * c * if cyclic { 1.0 } else { -1.0 } < 0.0
    }

    /// The options that a quantity's column, or its value, is given by.
    pub fn options(columns: &[(Quantity, &str)], values: &[Quantity]) -> String {
        let mut text = String::new();
        for (i, (quantity, name)) in columns.iter().enumerate() {
            let start = if i == 0 { " --columns " } else { "," };
            let name = name.replace('\\', "\\\\").replace('"', "\\\"");
            let name = name.replace('$', "\\$").replace('`', "\\`");
            let _ = write!(text, "{start}{}=\"{name}\"", quantity.name());
        }
        for quantity in values {
            let value = match quantity.dimension() {
                Dimension::Speed => "12000",
                Dimension::Temperature => "25",
                _ => "0",
            };
            let _ = write!(text, " --{} {value}", quantity.name());
        }
        text
    }
}
