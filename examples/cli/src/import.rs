//! Descriptions of recordings: where each quantity is, and in which unit, as a TOML file.
//!
//! ```toml
//! header_line = 13           # the line with the names; none if left out: columns are numbers
//! first_row = 15             # the first line with numbers
//! separator = "tab"          # tab, comma, semicolon, blank
//! decimal = ","              # or a point, if left out
//! comment = "#"              # lines below the header that begin with it are skipped; the header is read without it
//! short_rows = true          # rows may end early, but not before a column that is read
//!
//! axes = { x = "Fz", y = "-Fx", z = "-Fy" }   # if left out, the recording's axes are the bearing's
//!
//! [columns]                  # of the recording's own axes; "?" is refused until somebody writes what it is
//! time = { column = "Zeit [s]", unit = "s" }  # or { rate_hz = 10000 }; unit = "clock" for dates and clock times
//! fx = { column = "Fx [kN]", unit = "kN" }
//! fy = { column = 3, unit = "N", factor = -1.02 }   # the factor multiplies what the unit says
//! fz = { column = "Fz", unit = "?" }
//! mx = { value = 0, unit = "Nm" }
//! my = "?"
//! speed = { column = "n [Hz]", unit = "Hz", factor = 0.5 }
//! probe.nose = { column = "s1 [V]", unit = "um", factor = 25 }   # a [[probe]] of the spindle; um, nm, mm or m
//! ```

use crate::lines::SEPARATORS;
use crate::quantities::{LOADS, OWN, QUANTITIES, Quantity};
use crate::units::{Dimension, LENGTHS, Unit, plain};
use serde::Deserialize;
use spindle_file::reading::{DesignFileError, Key, Place, Reading, read_text};
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

/// Mark of an open point.
pub const OPEN: &str = "?";

/// A description, with its open points.
#[derive(Debug, Clone)]
pub struct Import {
    /// Name of its file.
    pub file: String,
    pub(crate) header_line: Option<u64>,
    pub(crate) first_row: u64,
    pub(crate) separator: u8,
    pub(crate) decimal: u8,
    pub(crate) comment: Option<String>,
    pub(crate) short_rows: bool,
    /// The recording's axis and its sign for each axis of the bearing.
    axes: [(usize, f64); 3],
    columns: [Entry; QUANTITIES],
    probes: Vec<ProbeColumn>,
    /// Open points besides columns.
    open: Vec<&'static str>,
}

/// Lines from the header to the first row, at most.
const FARTHEST: u64 = 400;

/// The bearing's own axes.
const AXES: [(usize, f64); 3] = [(0, 1.0), (1, 1.0), (2, 1.0)];

/// Entry of a quantity.
#[derive(Debug, Clone, PartialEq)]
enum Entry {
    Absent,
    Open(&'static str),
    Value(f64),
    Rate(f64),
    Column(Column),
}

/// A column that holds a quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Which one it is.
    pub name: Name,
    /// Its unit; none of clock times.
    pub unit: Option<Unit>,
    /// Factor of its numbers.
    pub factor: f64,
}

/// The column of a probe.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ProbeColumn {
    /// Name of the probe.
    pub probe: String,
    /// Which column it is.
    pub name: Name,
    /// Factor of its numbers to um.
    pub factor: f64,
}

/// A column's name, or its number from 1.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Name {
    /// The name in the header.
    Text(String),
    /// The number.
    Number(usize),
}

/// Where the numbers of a quantity come from.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) enum Source {
    /// Nowhere: nobody needs it.
    #[default]
    None,
    /// A constant.
    Given(f64),
    /// Rows are counted: so many a second.
    Rate(f64),
    Column(Column),
}

/// Quantities that a replay needs, and constants in their place.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// Quantities that are constant, by option.
    pub given: [Option<f64>; OWN.len()],
    /// Quantities that are needed, of [`OWN`].
    pub needed: [bool; OWN.len()],
    /// One record of so many is read.
    pub every: usize,
    /// Names of the probes whose readings are wanted, as far as the recording has them.
    pub probes: Vec<String>,
    /// Records of one time share the time to the next one: for all that weighs records by their time.
    pub shares_times: bool,
}

impl Default for Wanted {
    fn default() -> Self {
        let mut needed = [true; OWN.len()];
        // Without times, rows are counted.
        needed[0] = false;
        needed[LOADS..].fill(false);
        Self {
            given: [None; OWN.len()],
            needed,
            every: 1,
            probes: Vec::new(),
            shares_times: false,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ImportKeys {
    header_line: Key<u64>,
    first_row: Key<u64>,
    separator: Key<String>,
    decimal: Key<Or<Decimal>>,
    comment: Key<String>,
    short_rows: Key<Or<bool>>,
    axes: Key<Or<AxesKeys>>,
    #[serde(default)]
    columns: ColumnsKeys,
}

/// A value, or `"?"`.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "decimal is \".\" or \",\", short_rows true or false, axes { x = \"Fz\", y = \"Fx\", z = \"Fy\" }; or \"?\""
)]
enum Or<T> {
    Said(T),
    Open(Mark),
}

#[derive(Deserialize)]
enum Mark {
    #[serde(rename = "?")]
    Open,
}

#[derive(Deserialize, Clone, Copy)]
enum Decimal {
    #[serde(rename = ".")]
    Point = b'.' as isize,
    #[serde(rename = ",")]
    Comma = b',' as isize,
}

/// The value of a key, unless it is open.
fn said<T>(name: &'static str, key: Key<Or<T>>, open: &mut Vec<&'static str>) -> Option<T> {
    match key?.into_inner() {
        Or::Said(value) => Some(value),
        Or::Open(Mark::Open) => {
            open.push(name);
            None
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AxesKeys {
    x: String,
    y: String,
    z: String,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct ColumnsKeys {
    time: Key<Said>,
    fx: Key<Said>,
    fy: Key<Said>,
    fz: Key<Said>,
    mx: Key<Said>,
    my: Key<Said>,
    mz: Key<Said>,
    speed: Key<Said>,
    t_inner: Key<Said>,
    t_outer: Key<Said>,
    #[serde(default)]
    probe: BTreeMap<String, Spanned<ColumnKeys>>,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "{ column = \"a name\" or a number, unit = \"N\", factor = 1 }, { value = 0, unit = \"N\" }, for a time { rate_hz = 1000 }, or \"?\""
)]
enum Said {
    Open(String),
    Column(ColumnKeys),
    Value(ValueKeys),
    Rate(RateKeys),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ColumnKeys {
    column: Name,
    unit: String,
    factor: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ValueKeys {
    value: f64,
    unit: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RateKeys {
    rate_hz: f64,
}

impl Import {
    /// The project's own columns, of which a file has these, and columns of these probes.
    pub(crate) fn own(has: [bool; OWN.len()], probes: &[&String]) -> Self {
        let mut columns = [const { Entry::Absent }; QUANTITIES];
        for (own, _) in OWN.into_iter().zip(has).filter(|(_, has)| *has) {
            columns[own as usize] = Entry::Column(Column {
                name: Name::Text(own.column().to_owned()),
                unit: Some(Unit::of(own.dimension())),
                factor: 1.0,
            });
        }
        Self {
            file: "the project's own columns".to_owned(),
            header_line: Some(1),
            first_row: 2,
            separator: b',',
            decimal: b'.',
            comment: None,
            short_rows: false,
            axes: AXES,
            columns,
            probes: probes.iter().map(|probe| ProbeColumn::own(probe)).collect(),
            open: Vec::new(),
        }
    }

    /// Reads a description from a file.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or is no description; the place in it where it goes wrong.
    pub fn read(path: &Path) -> Result<Self, DesignFileError> {
        let (file, text) = read_text(path)?;
        Self::parse(&file, &text)
    }

    /// Reads a description from the text of a file that messages call `file`.
    ///
    /// # Errors
    ///
    /// A text that is no description; the place in it where it goes wrong.
    pub fn parse(file: &str, text: &str) -> Result<Self, DesignFileError> {
        let r = Reading { file, text };
        let keys: ImportKeys = r.keys(r.table()?)?;
        let fault = |span, message: String| Err(r.error(r.place(span), message));
        let mut open = Vec::new();
        let Some(first_row) = keys.first_row else {
            return Err(r.missing(None, "first_row", "2"));
        };
        let header_line = keys.header_line.map(Spanned::into_inner);
        if *first_row.get_ref() <= header_line.unwrap_or(0) {
            let message = "`first_row` is the number of a line below the header, from 1";
            return fault(first_row.span(), message.to_owned());
        }
        if first_row.get_ref() - header_line.unwrap_or(0) > FARTHEST {
            let message = format!("`first_row` is {FARTHEST} lines below the header at most");
            return fault(first_row.span(), message);
        }
        if header_line == Some(0) {
            return Err(r.error(Place::TOP, "`header_line` counts from 1"));
        }
        let Some(separator) = keys.separator else {
            return Err(r.missing(None, "separator", "\"comma\""));
        };
        let named = |(name, _): &&(&str, u8)| name == separator.get_ref();
        let separator = match SEPARATORS.iter().find(named) {
            Some((_, byte)) => *byte,
            None => {
                let message = "`separator` is one of tab, comma, semicolon, blank";
                return fault(separator.span(), message.to_owned());
            }
        };
        let decimal = said("`decimal`", keys.decimal, &mut open).unwrap_or(Decimal::Point);
        let short_rows = said("`short_rows`", keys.short_rows, &mut open).unwrap_or(false);
        let comment = keys.comment.filter(|text| !text.get_ref().is_empty());
        if let Some(mark) = &comment {
            let begins = |c: char| {
                c.is_ascii_digit() || "+-.,\"\t ".contains(c) || c == char::from(separator)
            };
            if mark.get_ref().starts_with(begins) {
                let message = "`comment` begins as a number or a field does";
                return fault(mark.span(), message.to_owned());
            }
        }
        let place = keys.axes.as_ref().map_or(0..0, Spanned::span);
        let axes = match said("`axes`", keys.axes, &mut open) {
            Some(axes) => turned([&axes.x, &axes.y, &axes.z]),
            None => Ok(AXES),
        };
        let axes = axes.map_err(|message| r.error(r.place(place), message))?;
        let of = keys.columns;
        let entries = [
            of.time, of.fx, of.fy, of.fz, of.mx, of.my, of.mz, of.speed, of.t_inner, of.t_outer,
        ];
        let probes = of.probe.into_iter().map(|(probe, said)| {
            let place = r.place(said.span());
            let column = said.into_inner().of_probe(probe);
            column.map_err(|message| r.error(place, message))
        });
        let probes = probes.collect::<Result<_, _>>()?;
        let mut columns = [const { Entry::Absent }; QUANTITIES];
        for (quantity, said) in Quantity::ALL.into_iter().zip(entries) {
            if let Some(said) = said {
                let place = said.span();
                match said.into_inner().entry(quantity) {
                    Ok(entry) => columns[quantity as usize] = entry,
                    Err(message) => return fault(place, message),
                }
            }
        }
        Ok(Self {
            file: file.to_owned(),
            header_line,
            first_row: first_row.into_inner(),
            separator,
            decimal: decimal as u8,
            comment: comment.map(Spanned::into_inner),
            short_rows,
            axes,
            columns,
            probes,
            open,
        })
    }

    /// Columns of the probes that are wanted, in their order.
    pub(crate) fn probes(&self, wanted: &[String]) -> Vec<Option<ProbeColumn>> {
        let column = |name: &String| {
            self.probes
                .iter()
                .find(|column| column.probe == *name)
                .cloned()
        };
        wanted.iter().map(column).collect()
    }

    /// Whether a quantity is in a column.
    pub(crate) fn has(&self, quantity: Quantity) -> bool {
        matches!(self.columns[quantity as usize], Entry::Column(_))
    }

    /// Where each quantity comes from; or all that nobody has said.
    pub(crate) fn sources(&self, wanted: &Wanted) -> Result<[Source; OWN.len()], String> {
        let mut open: Vec<String> = self.open.iter().map(|key| (*key).to_owned()).collect();
        let mut lacking = Vec::new();
        let sources = std::array::from_fn(|i| {
            let own = OWN[i];
            if let Some(value) = wanted.given[i] {
                return Source::Given(value);
            }
            let (recorded, sign) = self.recorded(own);
            match &self.columns[recorded as usize] {
                Entry::Absent if own == Quantity::Time => Source::Rate(1.0),
                Entry::Value(value) => Source::Given(sign * value),
                Entry::Rate(rate) => Source::Rate(*rate),
                // All that is described is read, but for temperatures of a spindle that takes none.
                Entry::Column(column) if wanted.needed[i] || i < LOADS => Source::Column(Column {
                    factor: sign * column.factor,
                    ..column.clone()
                }),
                Entry::Open(part) if wanted.needed[i] || own == Quantity::Time => {
                    open.push(format!("{part}`{}`", recorded.name()));
                    Source::None
                }
                Entry::Absent if wanted.needed[i] => {
                    lacking.push((recorded.name(), own.name()));
                    Source::None
                }
                _ => Source::None,
            }
        });
        let mut faults = Vec::new();
        if !open.is_empty() {
            faults.push(format!(
                "{} open: write for each \"?\" what the recording has",
                match &open[..] {
                    [one] => format!("{one} is"),
                    more => format!("{} are", more.join(", ")),
                }
            ));
        }
        for (key, option) in lacking {
            faults.push(format!(
                "[columns] lacks `{key}`: add it, or give --{option}"
            ));
        }
        match faults.is_empty() {
            true => Ok(sources),
            false => Err(format!("{}: {}", self.file, faults.join("; "))),
        }
    }

    /// The recorded quantity that a bearing's is, and its sign.
    fn recorded(&self, own: Quantity) -> (Quantity, f64) {
        let first = match own.dimension() {
            Dimension::Force => Quantity::Fx,
            Dimension::Moment => Quantity::Mx,
            _ => return (own, 1.0),
        } as usize;
        let (axis, sign) = self.axes[own as usize - first];
        (Quantity::ALL[first + axis], sign)
    }
}

impl ProbeColumn {
    /// The column of a probe among the project's own.
    pub fn own(probe: &str) -> Self {
        Self {
            probe: probe.to_owned(),
            name: Name::Text(format!("probe_{probe}_um")),
            factor: 1.0,
        }
    }
}

impl ColumnKeys {
    fn of_probe(self, probe: String) -> Result<ProbeColumn, String> {
        let unit = plain(&self.unit);
        let found = LENGTHS
            .iter()
            .find(|(name, _)| unit.as_deref() == Some(*name));
        let (_, micrometres) = found.ok_or_else(|| {
            let names = LENGTHS.map(|(name, _)| name).join(", ");
            format!(
                "`probe.{probe}`: {:?} is none of the units {names}; others take a factor",
                self.unit
            )
        })?;
        Ok(ProbeColumn {
            probe,
            name: self.column,
            factor: micrometres * self.factor.unwrap_or(1.0),
        })
    }
}

impl Said {
    fn entry(self, quantity: Quantity) -> Result<Entry, String> {
        let name = quantity.name();
        let dimension = quantity.dimension();
        let unit = |unit: &str| match Unit::named(unit) {
            Some(found) if found.dimension == dimension => Ok(found),
            _ => {
                let clock = if quantity == Quantity::Time {
                    ", clock"
                } else {
                    ""
                };
                let units = Unit::names(dimension);
                Err(format!(
                    "{unit:?} is none of the units {units}{clock}; others take a factor"
                ))
            }
        };
        Ok(match self {
            Self::Open(text) if text == OPEN => Entry::Open(""),
            Self::Open(text) => {
                return Err(format!(
                    "`{name}` is {text:?}: a column is {{ column = {text:?}, unit = ... }}"
                ));
            }
            Self::Column(ColumnKeys { column, unit, .. })
                if unit == OPEN || column == Name::Text(OPEN.to_owned()) =>
            {
                Entry::Open(if unit == OPEN { "the unit of " } else { "" })
            }
            Self::Column(keys) => {
                let is_clock = quantity == Quantity::Time && keys.unit == "clock";
                Entry::Column(Column {
                    name: keys.column,
                    unit: if is_clock {
                        None
                    } else {
                        Some(unit(&keys.unit)?)
                    },
                    factor: keys.factor.unwrap_or(1.0),
                })
            }
            Self::Value(_) if quantity == Quantity::Time => {
                return Err("a time is a column or { rate_hz = 1000 }".to_owned());
            }
            Self::Value(keys) => Entry::Value(unit(&keys.unit)?.read(keys.value)),
            Self::Rate(keys) if quantity == Quantity::Time && keys.rate_hz > 0.0 => {
                Entry::Rate(keys.rate_hz)
            }
            Self::Rate(_) => return Err("`rate_hz` is a positive number, of `time`".to_owned()),
        })
    }
}

/// The recording's axis and its sign for each axis of the bearing, such as `["Fz", "-Fx", "-Fy"]`.
fn turned(forces: [&str; 3]) -> Result<[(usize, f64); 3], &'static str> {
    let mut axes = [(0, 0.0); 3];
    for (axis, force) in axes.iter_mut().zip(forces) {
        let (sign, name) = match force.strip_prefix('-') {
            Some(name) => (-1.0, name),
            None => (1.0, force),
        };
        let forces = ["fx", "fy", "fz"];
        let found = forces.iter().position(|one| *one == name.to_lowercase());
        let found = found.ok_or("an axis is one of Fx, Fy, Fz, or -Fx and so on")?;
        *axis = (found, sign);
    }
    let [(x, a), (y, b), (z, c)] = axes;
    if x == y || y == z || z == x {
        return Err("each of Fx, Fy, Fz must be there once");
    }
    let hand = if (x + 1) % 3 == y { 1.0 } else { -1.0 };
    if a * b * c * hand < 0.0 {
        return Err(
            "these axes are left-handed: turn the sign of one, and give the recording's column a factor of -1 if it is so",
        );
    }
    Ok(axes)
}
