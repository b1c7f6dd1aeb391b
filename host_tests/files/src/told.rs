//! Quantities of a recording: their names in people's files, and what a user says of them.

use crate::units::{Dimension, Unit};

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

    /// Its dimension.
    pub const fn dimension(self) -> Dimension {
        self.facts().2
    }

    /// The one of this name on a command line.
    ///
    /// # Errors
    ///
    /// No quantity has this name.
    pub fn named(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|one| one.name() == name.trim());
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("{name:?} is none of {names}")
        })
    }
}

/// Names without unit, marks and blanks, `?` being an axis or a side; and one that needs a unit to be understood.
const fn names(dimension: Dimension) -> (&'static str, &'static str) {
    match dimension {
        Dimension::Time => (
            "time abstime abstimes reltime relativetime elapsedtime timestamp xvalue zeit messzeit temps tempo tiempo",
            "t",
        ),
        Dimension::Force => ("f? force? ?force forcef? kraft? kraftf?", ""),
        Dimension::Moment => (
            "m? moment? ?moment momentm? torque? ?torque drehmoment?",
            "t?",
        ),
        Dimension::Speed => (
            "speed rpm spindlespeed shaftspeed rotationalspeed drehzahl spindeldrehzahl",
            "n",
        ),
        Dimension::Temperature => ("t?", ""),
    }
}

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
    /// `Fx [N]`, `Force X (kN)`, `t / s`, `Zeit in s`, `n 1/min`, `fx_n`.
    pub fn new(text: &str) -> Self {
        let mut brackets = [('[', ']'), ('(', ')')].into_iter();
        let brackets = brackets.find_map(|(open, close)| {
            let (before, rest) = text.split_once(open)?;
            let (unit, after) = rest.split_once(close)?;
            Some((format!("{before}{after}"), unit))
        });
        let split = brackets.or_else(|| {
            if let Some((stem, unit)) = text.rsplit_once(" in ") {
                return Some((stem.to_owned(), unit));
            }
            // The longest unit at the end.
            let marks = text.match_indices([' ', '/', ',', '_']);
            let mut parts = marks.map(|(at, mark)| (&text[..at], &text[at + mark.len()..]));
            let (stem, unit) =
                parts.find(|(stem, unit)| !stem.is_empty() && Unit::named(unit).is_some())?;
            Some((stem.to_owned(), unit))
        });
        let (stem, unit) = split.unwrap_or((text.to_owned(), ""));
        let letters = stem.chars().filter(|c| c.is_alphanumeric());
        let mut heading = Self {
            text: text.to_owned(),
            stem: letters.collect::<String>().to_lowercase(),
            unit_name: None,
            unit: None,
        };
        heading.add_unit(unit.trim());
        heading
    }

    /// Takes the unit that another line has, if there is none in the name.
    pub fn add_unit(&mut self, name: &str) {
        if self.unit_name.is_none() && !name.is_empty() {
            self.unit = Unit::named(name);
            self.unit_name = Some(name.to_owned());
        }
    }

    /// Takes a unit that the preamble has, if it has none, or counts, and is a quantity of that dimension.
    pub fn assume(&mut self, unit: Unit) {
        let name = self.unit_name.as_deref().unwrap_or("counts");
        let assumed = Self {
            unit: Some(unit),
            unit_name: None,
            ..self.clone()
        };
        let is_meant = Quantity::ALL.iter().any(|one| assumed.means(*one));
        if name.eq_ignore_ascii_case("counts") && is_meant {
            *self = assumed;
        }
    }

    /// The name of a unit that is none.
    pub fn strange_unit(&self) -> Option<&str> {
        self.unit_name.as_deref().filter(|_| self.unit.is_none())
    }

    /// Whether it means a quantity, by its name and its unit.
    pub fn means(&self, quantity: Quantity) -> bool {
        let fits = self.unit.map(|unit| unit.dimension == quantity.dimension());
        fits != Some(false)
            && (self.is_called(quantity, false) || fits.is_some() && self.is_called(quantity, true))
    }

    /// Whether its name is one of a quantity's; with `short`, the one that needs a unit to be understood.
    pub fn is_called(&self, quantity: Quantity, short: bool) -> bool {
        let axis = match quantity.dimension() {
            Dimension::Force | Dimension::Moment => &quantity.name()[1..],
            Dimension::Temperature => &quantity.name()[2..],
            _ => "",
        };
        let (names, by_unit) = names(quantity.dimension());
        let mut names = if short { by_unit } else { names }.split(' ');
        !self.stem.is_empty()
            && names.any(|name| match name.split_once('?') {
                None => name == self.stem,
                Some((before, after)) => {
                    let middle = self
                        .stem
                        .strip_prefix(before)
                        .and_then(|rest| rest.strip_suffix(after));
                    middle.is_some_and(|middle| middle == axis.replace('_', ""))
                }
            })
    }

    /// Whether its unit is one of the quantity's, or its name, which alone says too little.
    pub fn may_be(&self, quantity: Quantity) -> bool {
        match self.unit {
            Some(unit) => unit.dimension == quantity.dimension(),
            None => self.strange_unit().is_none() && self.is_called(quantity, true),
        }
    }
}

/// Options of a user about a recording, besides the names of its columns.
#[derive(Debug, Clone)]
pub struct Told {
    /// The columns of quantities, by name or by number; `-` is no column. A minus before the name turns the sign, a factor may
    /// stand behind it.
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
                let axis = |name: &str| ["x", "y", "z"].iter().position(|axis| *axis == name);
                let own = axis(&own.trim().to_lowercase())?;
                Some((own, (axis(name.strip_prefix('f').unwrap_or(name))?, sign)))
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

    /// A column's name without sign and factor, and these: `-Fy*1000`.
    pub fn split(name: &str) -> (&str, f64) {
        let (sign, name) = match name.strip_prefix('-') {
            Some(name) => (-1.0, name),
            None => (1.0, name),
        };
        let times = name.rsplit_once('*').and_then(|(name, factor)| {
            let factor: f64 = factor.trim().parse().ok()?;
            Some((name.trim_end(), sign * factor))
        });
        times.unwrap_or((name, sign))
    }

    /// Whether a column of this name is told of.
    pub fn names(&self, text: &str) -> bool {
        let mut columns = self.columns.iter();
        columns.any(|(_, name)| {
            [name, Self::split(name).0]
                .iter()
                .any(|one| one.eq_ignore_ascii_case(text))
        })
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
}
