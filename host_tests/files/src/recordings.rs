//! Recorded loads: forces, moments and speed as tables of measuring programs, data loggers and spreadsheets have them.
//!
//! The project's own recordings begin with the header `time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm`, columns in any order;
//! `t_inner_c,t_outer_c` besides, for spindles. Of others, a preamble is skipped, names and units are understood by the
//! tables of [`told`](crate::told) and [`units`](crate::units), and a user says the rest. Fields are separated by commas,
//! semicolons or tabs; decimal commas are understood where they do not separate fields. Blank lines and lines that begin with
//! `#`, `%` or `;` are skipped.
//!
//! The file is read as a stream, so that a pipe of any length works. Every number is passed on as it stands, `nan` and `inf`
//! too: whether a row can be solved is for the solver to say. A row that cannot be read is an error of that row: the rows
//! after it are still there to be read.
//!
//! Each line is one record, so that a quotation mark left open costs one row, not the rest of the file. The csv crate reads
//! lines with quotation marks; a reader of its own for every line would take two fifths of a replay.

use crate::preamble::{self, Line, is_empty, number, split};
use crate::told::{Heading, Quantity, Told};
use crate::units::{Dimension, Unit, celsius};
use std::collections::VecDeque;
use std::fmt::{self, Write as _};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::Path;

/// The columns of the project's own files, in the order in which they are written. Temperatures may lack.
const OWN: [Quantity; 9] = [
    Quantity::Time,
    Quantity::Fx,
    Quantity::Fy,
    Quantity::Fz,
    Quantity::My,
    Quantity::Mz,
    Quantity::Speed,
    Quantity::TInner,
    Quantity::TOuter,
];

/// Columns without temperatures.
const COLUMNS: usize = 7;

const DECIMAL_COMMAS: &str = "decimals take a point where commas separate the fields; for decimal commas, \
     separate fields by semicolons, in the header too";

/// Length beyond which a line is no row of numbers. Without a bound, a stray binary file would be read into memory before
/// the complaint.
const LONGEST_LINE: u64 = 16 * 1024;

/// Lines in which the first row of numbers is looked for.
const LONGEST_PREAMBLE: usize = 200;

/// Measured values of one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadRow {
    /// Time, s.
    pub time_s: f64,
    /// Load on the inner ring `(Fx, Fy, Fz, My, Mz)`, N and N m.
    pub load: [f64; 5],
    /// Shaft speed, revolutions per minute.
    pub speed_rpm: f64,
    /// Temperatures of the inner and of the outer side, degrees Celsius, if the file has them.
    pub temperatures: Option<[f64; 2]>,
}

impl LoadRow {
    /// Shaft speed `omega`, rad/s.
    pub fn omega(&self) -> f64 {
        self.speed_rpm * std::f64::consts::PI / 30.0
    }
}

/// Writes rows as a file of recorded loads.
///
/// # Errors
///
/// Errors of the output.
pub fn write_csv(rows: &[LoadRow], out: &mut impl Write) -> io::Result<()> {
    let warm = rows.iter().any(|row| row.temperatures.is_some());
    let columns = if warm { OWN.len() } else { COLUMNS };
    let names = OWN[..columns].iter().map(|quantity| quantity.column());
    writeln!(out, "{}", names.collect::<Vec<_>>().join(","))?;
    for row in rows {
        let [fx, fy, fz, my, mz] = row.load;
        write!(
            out,
            "{},{fx},{fy},{fz},{my},{mz},{}",
            row.time_s, row.speed_rpm
        )?;
        if let Some([inner, outer]) = row.temperatures {
            write!(out, ",{inner},{outer}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// A row that cannot be read.
#[derive(Debug, Clone, PartialEq)]
pub struct BadRow {
    /// The place, why not, and the remedy.
    pub fault: String,
    /// Its readable numbers, in the order of the columns; none where the line has another number of fields.
    pub numbers: [Option<f64>; OWN.len()],
}

/// Error of a file of recorded loads.
#[derive(Debug)]
pub enum LoadsError {
    /// The operating system refused to open or to read the file.
    Unreadable {
        /// Name of the file.
        file: String,
        /// Its reason.
        source: io::Error,
    },
    /// The file is no recording of loads: the place, why not, and the remedy.
    Malformed(String),
    /// Quantities have no column; the options that would say where they are.
    Unknown(String, String),
    /// One row is at fault; the rows after it can be read.
    Row(Box<BadRow>),
}

impl fmt::Display for LoadsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { file, source } => write!(f, "{file}: cannot be read: {source}"),
            Self::Malformed(fault) => f.write_str(fault),
            Self::Unknown(fault, options) => write!(f, "{fault}{options}"),
            Self::Row(row) => f.write_str(&row.fault),
        }
    }
}

impl std::error::Error for LoadsError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Unreadable { source, .. } => Some(source),
            _ => None,
        }
    }
}

/// Opens a file of recorded loads, `-` being standard input, and finds its columns.
///
/// # Errors
///
/// A file that cannot be opened, or without a column of a quantity that is needed.
pub fn read(path_or_dash: impl AsRef<Path>, told: Told) -> Result<Loads, LoadsError> {
    let path = path_or_dash.as_ref();
    if path.as_os_str() == "-" {
        return Loads::from_reader("standard input", Box::new(io::stdin()), told);
    }
    let name = path.display().to_string();
    let unreadable = |source| LoadsError::Unreadable {
        file: name.clone(),
        source,
    };
    let file = File::open(path).map_err(unreadable)?;
    let metadata = file.metadata().map_err(unreadable)?;
    let mut loads = Loads::from_reader(&name, Box::new(file), told)?;
    loads.total_bytes = metadata.is_file().then_some(metadata.len());
    Ok(loads)
}

/// Where the numbers of a quantity come from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    /// Nowhere: a temperature that nobody needs.
    None,
    /// The same for all rows.
    Given(f64),
    /// Rows are counted.
    Count,
    /// A field, its unit, whether the file says the unit, and its sign.
    Field(usize, Unit, bool, f64),
}

/// A quantity of the recording that is not known, the bearing's, and fields that may be it.
type Unknown = (Quantity, Quantity, Vec<(usize, f64)>);

/// The rows of a file of recorded loads, read one at a time. Ends after the first error that is not one of a row.
pub struct Loads {
    file: String,
    input: BufReader<Box<dyn Read>>,
    told: Told,
    /// Lines that were read in search of the header.
    ahead: VecDeque<Line>,
    line: Line,
    headings: Vec<Heading>,
    sources: [Source; OWN.len()],
    /// The quantity in each field.
    of_field: Vec<Option<usize>>,
    separator: u8,
    /// The mark before decimals that the file has had first, where commas do not separate fields.
    decimal: Option<char>,
    lines: u64,
    rows: u64,
    bytes: u64,
    total_bytes: Option<u64>,
    ended: bool,
    /// Least and largest number of each quantity.
    ranges: [(f64, f64); OWN.len()],
}

impl Loads {
    /// Reads from `input`; messages call it `name`.
    ///
    /// # Errors
    ///
    /// No column of a quantity that is needed, or an input that fails.
    pub fn from_reader(name: &str, input: Box<dyn Read>, told: Told) -> Result<Self, LoadsError> {
        let mut loads = Self {
            file: name.to_owned(),
            input: BufReader::with_capacity(64 * 1024, input),
            told,
            ahead: VecDeque::new(),
            line: Line::default(),
            headings: Vec::new(),
            sources: [Source::None; OWN.len()],
            of_field: Vec::new(),
            separator: b',',
            decimal: None,
            lines: 0,
            rows: 0,
            bytes: 0,
            total_bytes: None,
            ended: false,
            ranges: [(f64::INFINITY, f64::NEG_INFINITY); OWN.len()],
        };
        loads.open()?;
        Ok(loads)
    }

    /// Bytes taken from the input so far.
    pub fn bytes_read(&self) -> u64 {
        self.bytes
    }

    /// Whether there are columns of temperatures.
    pub fn has_temperatures(&self) -> bool {
        self.sources[COLUMNS..]
            .iter()
            .all(|source| *source != Source::None)
    }

    /// The name of the file, as messages give it.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Names of the columns that are not read.
    pub fn ignored_columns(&self) -> Vec<String> {
        let headings = self.headings.iter().zip(&self.of_field);
        let ignored = headings.filter(|(heading, of)| of.is_none() && !heading.text.is_empty());
        ignored
            .map(|(heading, _)| shortened(heading.text.as_bytes()))
            .collect()
    }

    /// Size of the input, if it is a plain file.
    pub fn total_bytes(&self) -> Option<u64> {
        self.total_bytes
    }

    /// How the rows so far were understood, with the range of each quantity; none for a file with the project's own names.
    /// A question mark is behind a unit that the file does not say.
    pub fn assumed(&self) -> Option<String> {
        let is_own = |(quantity, source): (&Quantity, &Source)| match source {
            Source::None => true,
            Source::Field(i, ..) => self.headings[*i]
                .text
                .eq_ignore_ascii_case(quantity.column()),
            _ => false,
        };
        if OWN.iter().zip(&self.sources).all(is_own) {
            return None;
        }
        let mut parts = Vec::new();
        for (i, quantity) in OWN.into_iter().enumerate() {
            let (name, unit) = (quantity.name(), Unit::of(quantity.dimension()).name());
            let (least, most) = self.ranges[i];
            parts.push(match self.sources[i] {
                Source::None => continue,
                Source::Given(x) => format!("{name} {x} {unit}"),
                Source::Count => format!("{name} counts the rows"),
                Source::Field(field, _, is_said, sign) => {
                    let doubt = if is_said { "" } else { "?" };
                    let sign = if sign < 0.0 { "-" } else { "" };
                    let from = shortened(self.headings[field].text.as_bytes());
                    let range = if least < most {
                        format!("{least} to {most}")
                    } else {
                        format!("{most}")
                    };
                    format!("{name} {range} {unit}{doubt} ({sign}{from:?})")
                }
            });
        }
        Some(format!("{}: read as {}", self.file, parts.join(", ")))
    }

    /// A complaint of a field of the line, counted from 1; `quantity` is the one that it holds, if it is one of ours.
    fn fault(&self, field: usize, quantity: Option<usize>, message: impl fmt::Display) -> String {
        let (file, line) = (&self.file, self.line.number.max(1));
        let name = quantity.map_or(String::new(), |i| format!(" ({})", OWN[i].column()));
        format!("{file}: line {line}, column {field}{name}: {message}")
    }

    fn malformed(&self, message: impl fmt::Display) -> LoadsError {
        LoadsError::Malformed(self.fault(1, None, message))
    }

    /// Brings the next line of the file into `self.line`; `false` at its end.
    fn take_line(&mut self) -> Result<bool, LoadsError> {
        let line = &mut self.line.text;
        line.clear();
        let input = &mut self.input;
        let taken = input.take(LONGEST_LINE).read_until(b'\n', line);
        let taken = taken.map_err(|source| LoadsError::Unreadable {
            file: self.file.clone(),
            source,
        })?;
        if taken == 0 {
            return Ok(false);
        }
        self.lines += 1;
        self.line.number = self.lines;
        self.bytes += taken as u64;
        if self.lines == 1 {
            let zeros = line.iter().filter(|byte| **byte == 0).count();
            let is_wide = line.starts_with(b"\xFF\xFE") || line.starts_with(b"\xFE\xFF");
            if is_wide || line.len() > 3 && 3 * zeros > line.len() {
                return Err(self.malformed("the file is UTF-16 text; save it as CSV in UTF-8"));
            }
            if line.starts_with(b"\xEF\xBB\xBF") {
                line.drain(..3);
            }
        }
        if taken as u64 == LONGEST_LINE && line.last() != Some(&b'\n') {
            return Err(self.malformed(format!(
                "the line is longer than {LONGEST_LINE} bytes; is this a CSV file of loads?"
            )));
        }
        if line.last() != Some(&b'\n') {
            line.push(b'\n');
        }
        Ok(true)
    }

    /// Brings the next line that is neither blank nor a comment into `self.line`; `false` at the end of the file.
    fn next_line(&mut self) -> Result<bool, LoadsError> {
        loop {
            if let Some(line) = self.ahead.pop_front() {
                self.line = line;
            } else if !self.take_line()? {
                return Ok(false);
            }
            if !is_empty(&self.line.text, self.separator) {
                return Ok(true);
            }
        }
    }

    /// Finds the header, and where each quantity is.
    fn open(&mut self) -> Result<(), LoadsError> {
        let mut is_row = false;
        while !is_row && self.ahead.len() < LONGEST_PREAMBLE && self.take_line()? {
            let line = std::mem::take(&mut self.line);
            is_row = line.of_row().is_some();
            self.ahead.push_back(line);
        }
        let Some(header) = preamble::find(self.ahead.make_contiguous(), &self.told) else {
            self.line.number = self.lines;
            let own = OWN.map(Quantity::column)[..COLUMNS].join(",");
            return Err(self.malformed(format!(
                "the file is empty; it must begin with the header {own}"
            )));
        };
        self.line = self
            .ahead
            .drain(..header.length)
            .next_back()
            .unwrap_or_default();
        self.line.number = header.line;
        self.separator = header.separator;
        self.headings = header.headings;
        if let Err((field, fault)) = split(&self.line.text, self.separator, |_, _| ()) {
            return Err(LoadsError::Malformed(self.fault(field, None, fault)));
        }
        self.find_sources()
    }

    /// The field of a quantity, or the fields that may be.
    fn fields_of(&self, quantity: Quantity) -> Result<Vec<(usize, f64)>, LoadsError> {
        let places = |is: &dyn Fn(&Heading) -> bool| -> Vec<(usize, f64)> {
            let headings = self.headings.iter().enumerate();
            headings
                .filter(|(_, heading)| is(heading))
                .map(|(i, _)| (i, 1.0))
                .collect()
        };
        let named = |name: &str| places(&|heading| heading.text.eq_ignore_ascii_case(name));
        let mut told = self.told.columns.iter();
        let Some((_, name)) = told.find(|(one, _)| *one == quantity) else {
            let own = named(quantity.column());
            return Ok(if own.is_empty() {
                places(&|heading| heading.means(quantity))
            } else {
                own
            });
        };
        if name == "-" {
            return Ok(Vec::new());
        }
        let found = named(name);
        if !found.is_empty() {
            return Ok(found);
        }
        let (sign, bare) = match name.strip_prefix('-') {
            Some(bare) => (-1.0, bare),
            None => (1.0, &**name),
        };
        let mut found = named(bare);
        let numbered = bare
            .parse()
            .ok()
            .filter(|i| (1..=self.headings.len()).contains(i));
        found.extend(numbered.filter(|_| found.is_empty()).map(|i| (i - 1, 1.0)));
        if found.is_empty() {
            let all: Vec<_> = self
                .headings
                .iter()
                .map(|heading| heading.text.clone())
                .collect();
            return Err(self.malformed(format!(
                "no column is called {bare:?}: there are {}",
                listed(&all)
            )));
        }
        Ok(found.into_iter().map(|(i, _)| (i, sign)).collect())
    }

    /// Finds where each quantity comes from; what is not known is asked for at once.
    fn find_sources(&mut self) -> Result<(), LoadsError> {
        let (mut unknown, mut faults) = (Vec::new(), Vec::new());
        for (i, quantity) in OWN.into_iter().enumerate() {
            if let Some(value) = self.told.given[quantity as usize] {
                self.sources[i] = Source::Given(value);
                continue;
            }
            let (recorded, turn) = self.told.recorded(quantity);
            let fields = self.fields_of(recorded)?;
            let is_needed = i < COLUMNS || self.told.heat;
            self.sources[i] = match fields[..] {
                [(field, sign)] => {
                    let heading = &self.headings[field];
                    let dimension = quantity.dimension();
                    let unit = heading.unit.unwrap_or(Unit::of(dimension));
                    if heading.strange_unit().is_some() || unit.dimension != dimension {
                        let strange = heading.strange_unit().unwrap_or(unit.name());
                        let units = Unit::names(dimension);
                        faults.push(format!(
                            "{:?} has the unit {strange}, which is none of {units}",
                            heading.text
                        ));
                    }
                    if dimension == Dimension::Moment && self.told.is_mirrored() {
                        faults.push(format!(
                            "the axes are mirrored, which leaves the sign of {} open: turn one of them, or give the moments",
                            quantity.name()
                        ));
                    }
                    Source::Field(field, unit, heading.unit.is_some(), sign * turn)
                }
                [] if quantity == Quantity::Time && !self.may_have_time() => Source::Count,
                [] if !is_needed => Source::None,
                _ => {
                    unknown.push((recorded, quantity, fields));
                    Source::None
                }
            };
        }
        let missing = |i: usize| self.sources[i] == Source::None;
        let [inner, outer] = [COLUMNS, COLUMNS + 1];
        if !self.told.heat && missing(inner) != missing(outer) {
            // Temperatures are those of both sides.
            let other = OWN[if missing(inner) { inner } else { outer }];
            unknown.push((other, other, Vec::new()));
        }
        self.of_field = vec![None; self.headings.len()];
        for (i, source) in self.sources.iter().enumerate() {
            if let Source::Field(field, ..) = source
                && let Some(other) = self.of_field[*field].replace(i)
            {
                let [one, other] = [OWN[other], OWN[i]].map(Quantity::name);
                faults.push(format!(
                    "{:?} is {one} and {other}",
                    self.headings[*field].text
                ));
            }
        }
        if !faults.is_empty() {
            return Err(self.malformed(faults.join("; ")));
        }
        if unknown.is_empty() {
            Ok(())
        } else {
            Err(self.ask(&unknown))
        }
    }

    /// Whether a column without a name that is known has a time's unit.
    fn may_have_time(&self) -> bool {
        let told = self.told.columns.iter();
        let is_time = |heading: &Heading| {
            heading
                .unit
                .is_some_and(|unit| unit.dimension == Dimension::Time)
        };
        told.clone()
            .all(|(quantity, _)| *quantity != Quantity::Time)
            && self.headings.iter().any(is_time)
    }

    /// Asks for quantities: none or several columns may be theirs.
    fn ask(&self, unknown: &[Unknown]) -> LoadsError {
        let text = |i: usize| self.headings[i].text.as_str();
        let is_known = |heading: &Heading| Quantity::ALL.iter().any(|one| heading.means(*one));
        let others = (0..self.headings.len()).filter(|i| {
            !self.told.names(text(*i)) && !text(*i).is_empty() && !is_known(&self.headings[*i])
        });
        let others: Vec<usize> = others.collect();
        let (mut next, mut columns, mut values, mut parts) =
            (others.iter(), Vec::new(), Vec::new(), Vec::new());
        for (quantity, own, fields) in unknown {
            let may_be: Vec<String> = fields
                .iter()
                .map(|(i, _)| format!("{:?}", text(*i)))
                .collect();
            parts.push(match may_be[..] {
                [] => format!("{} is in no column", quantity.name()),
                _ => format!("{} may be {}", quantity.name(), may_be.join(" or ")),
            });
            let likely = |i: &&usize| {
                self.headings[**i]
                    .unit
                    .is_none_or(|unit| unit.dimension == quantity.dimension())
            };
            let column = fields
                .first()
                .map(|(i, _)| *i)
                .or_else(|| next.find(likely).copied());
            match column {
                Some(i) => columns.push((*quantity, text(i))),
                None => values.push(*own),
            }
        }
        let mut message = parts.join(", ");
        if !others.is_empty() {
            let others: Vec<_> = others.iter().map(|i| text(*i).to_owned()).collect();
            let _ = write!(message, "; columns that say nothing: {}", listed(&others));
        }
        message += ". Say where each is, or its value, such as";
        let fault = self.fault(1, None, message);
        LoadsError::Unknown(fault, Told::options(&columns, &values))
    }

    /// The number in a field, or the field's fault.
    fn number(&mut self, field: &[u8], unit: &Unit) -> Result<f64, String> {
        if field.is_empty() {
            return Err("the field is empty; a number is needed".to_owned());
        }
        let text = std::str::from_utf8(field).unwrap_or_default();
        let Some((value, mark)) = number(text) else {
            let marks = text
                .matches([',', '.', '\'', '\u{a0}', '\u{202f}', ' '])
                .count();
            let hint = match text
                .chars()
                .all(|c| c.is_ascii_digit() || "+-,.' \u{a0}\u{202f}".contains(c))
            {
                true if marks > 0 => ": it has thousands separators; write it without",
                _ if text.contains(':') => {
                    "; a clock's time is left out by --columns time=-, and rows are counted"
                }
                _ => "",
            };
            return Err(format!("{} is not a number{hint}", quoted(field)));
        };
        if let Some(mark) = mark
            && (mark != '.' || self.separator != b',' || self.decimal.is_some())
            && mark != *self.decimal.get_or_insert(mark)
        {
            // A comma may then be one of thousands.
            let [has, above] = match mark {
                ',' => ["a comma", "points"],
                _ => ["a point", "commas"],
            };
            let field = quoted(field);
            return Err(format!(
                "{field} has {has} where numbers above have decimal {above}; write all decimals one way"
            ));
        }
        let value = unit.read(value);
        if unit.dimension == Dimension::Temperature {
            celsius(value)
        } else {
            Ok(value)
        }
    }

    fn row(&mut self) -> Result<Option<LoadRow>, LoadsError> {
        if !self.next_line()? {
            return Ok(None);
        }
        let mut numbers = self.sources.map(|source| match source {
            Source::Given(value) => Some(value),
            Source::Count => Some(self.rows as f64),
            _ => None,
        });
        self.rows += 1;
        let line = std::mem::take(&mut self.line.text);
        let (mut bad, mut more) = (None, None);
        let wanted = self.headings.len();
        let count = split(&line, self.separator, |i, field| {
            if i >= wanted && !field.is_empty() {
                more.get_or_insert(i);
            }
            let Some(Some(column)) = self.of_field.get(i).copied() else {
                return;
            };
            let Source::Field(_, unit, _, sign) = self.sources[column] else {
                return;
            };
            match self.number(field, &unit) {
                Ok(number) => numbers[column] = Some(sign * number),
                Err(message) => drop(bad.get_or_insert((i + 1, Some(column), message))),
            }
        });
        let needed = self
            .of_field
            .iter()
            .rposition(Option::is_some)
            .map_or(0, |last| last + 1);
        let lost = match count {
            Err((field, message)) => Some((field, None, message.to_owned())),
            // Where numbers are readable, the first bad one says more than a wrong count.
            Ok(count) if count < needed => {
                let message = format!("the line ends after {count} of {wanted} fields");
                Some((count + 1, self.of_field[count], message))
            }
            Ok(count) => more.map(|_| {
                let hint = if self.separator == b',' {
                    DECIMAL_COMMAS
                } else {
                    ""
                };
                let semicolon = if hint.is_empty() { "" } else { "; " };
                let message = format!(
                    "the line has {count} fields where the header has {wanted}{semicolon}{hint}"
                );
                (wanted + 1, None, message)
            }),
        };
        self.line.text = line;
        let is_lost = lost.is_some();
        if let Some((field, column, message)) = bad.or(lost) {
            let kept = |i: usize| numbers[i].filter(|_| !is_lost);
            return Err(LoadsError::Row(Box::new(BadRow {
                fault: self.fault(field, column, message),
                numbers: std::array::from_fn(kept),
            })));
        }
        for ((least, most), number) in self.ranges.iter_mut().zip(numbers) {
            let number = number.unwrap_or(f64::NAN);
            (*least, *most) = (least.min(number), most.max(number));
        }
        let [time, fx, fy, fz, my, mz, speed, inner, outer] = numbers;
        let is = Option::unwrap_or_default;
        Ok(Some(LoadRow {
            time_s: is(time),
            load: [fx, fy, fz, my, mz].map(is),
            speed_rpm: is(speed),
            temperatures: inner.zip(outer).map(<[f64; 2]>::from),
        }))
    }
}

impl Iterator for Loads {
    type Item = Result<LoadRow, LoadsError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let passed = if self.rows == 0 { 1 } else { self.told.every };
        let mut row = self.row().transpose();
        for _ in 1..passed {
            if let Some(Ok(_) | Err(LoadsError::Row(_))) = row {
                row = self.row().transpose();
            }
        }
        self.ended = !matches!(row, Some(Ok(_) | Err(LoadsError::Row(_))));
        row
    }
}

/// Characters of a field that messages show.
const SHOWN: usize = 40;

/// A field as messages show it: readable, and short even if the field is not.
fn quoted(field: &[u8]) -> String {
    format!("{:?}", shortened(field))
}

fn shortened(field: &[u8]) -> String {
    let text = String::from_utf8_lossy(field);
    let mut shown: String = text.chars().take(SHOWN).collect();
    if text.chars().count() > SHOWN {
        shown.push_str("...");
    }
    shown
}

/// The first of these names, and the number of the others.
pub fn listed(names: &[String]) -> String {
    const MOST: usize = 12;
    let quoted = names
        .iter()
        .take(MOST)
        .map(|name| self::quoted(name.as_bytes()));
    let mut list = quoted.collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        let _ = write!(list, " and {} more", names.len() - MOST);
    }
    list
}
