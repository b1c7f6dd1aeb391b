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

use crate::columns::{self, Field, LOADS, OWN, Source};
use crate::preamble::{self, Line, is_empty, listed, number, shortened, shown, split, text};
use crate::told::{Heading, Quantity, Told};
use crate::units::{Dimension, Unit, celsius};
use std::collections::VecDeque;
use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::Path;

const DECIMAL_COMMAS: &str = "; decimals take a point where commas separate the fields; for decimal commas, \
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
    let columns = if warm { OWN.len() } else { LOADS };
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

/// The rows of a file of recorded loads, read one at a time. Ends after the first error that is not one of a row.
pub struct Loads {
    file: String,
    input: BufReader<Box<dyn Read + Send>>,
    told: Told,
    /// Lines that were read in search of the header.
    ahead: VecDeque<Line>,
    line: Line,
    headings: Vec<Heading>,
    sources: [Source; OWN.len()],
    /// The quantity in each field, by its number in [`OWN`].
    of_field: Vec<Option<(usize, Field)>>,
    separator: u8,
    /// The mark before decimals that the file has had first.
    decimal: Option<char>,
    /// All numbers with that mark have three digits behind it and at most three before: it may be one of thousands.
    may_be_thousands: bool,
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
    pub fn from_reader(
        name: &str,
        input: Box<dyn Read + Send>,
        told: Told,
    ) -> Result<Self, LoadsError> {
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
            may_be_thousands: false,
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
        self.sources[LOADS..]
            .iter()
            .all(|source| *source != Source::None)
    }

    /// The name of the file, as messages give it.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Names of the columns that are not read; none if there are none.
    pub fn ignored_columns(&self) -> Option<String> {
        let headings = self.headings.iter().zip(&self.of_field);
        let ignored = headings.filter(|(heading, of)| of.is_none() && !heading.text.is_empty());
        let names: Vec<String> = ignored.map(|(heading, _)| heading.text.clone()).collect();
        (!names.is_empty()).then(|| listed(&names))
    }

    /// Size of the input, if it is a plain file.
    pub fn total_bytes(&self) -> Option<u64> {
        self.total_bytes
    }

    /// How the rows so far were understood, with the range of each quantity; none for a file with the project's own names whose
    /// marks before three digits are clear. A question mark is behind a unit that the file does not say.
    pub fn assumed(&self) -> Option<String> {
        let is_own = |(quantity, source): (&Quantity, &Source)| match source {
            Source::None => true,
            Source::Field(field) => {
                let text = &self.headings[field.number].text;
                text.eq_ignore_ascii_case(quantity.column())
            }
            _ => false,
        };
        let is_clear = OWN.iter().zip(&self.sources).all(is_own) && !self.may_be_thousands;
        let is_read = self.ranges.iter().any(|(least, _)| least.is_finite());
        if is_clear || !is_read {
            return None;
        }
        let parts = OWN.into_iter().zip(self.sources).zip(self.ranges);
        let parts = parts.filter_map(|((quantity, source), (least, most))| {
            let (name, unit) = (quantity.name(), Unit::of(quantity.dimension()).name());
            match source {
                Source::None => None,
                Source::Given(x) => Some(format!("{name} {x} {unit}")),
                Source::Count => Some(format!("{name} counts the rows")),
                Source::Field(field) => {
                    let doubt = if field.is_said { "" } else { "?" };
                    let from = shortened(self.headings[field.number].text.as_bytes());
                    let range = if least < most {
                        format!("{least} to {most}")
                    } else {
                        format!("{most}")
                    };
                    let factor = match field.factor {
                        1.0 => String::new(),
                        -1.0 => "-".to_owned(),
                        factor => format!("{factor} * "),
                    };
                    Some(format!("{name} {range} {unit}{doubt} ({factor}{from:?})"))
                }
            }
        });
        let parts: Vec<String> = parts.collect();
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
        if self.rows == 0 {
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
        // A row of numbers may be one of the preamble: names are above the first of the recording.
        let (mut first, mut is_named) = (None, false);
        while self.ahead.len() < LONGEST_PREAMBLE && self.take_line()? {
            let line = std::mem::take(&mut self.line);
            let is_row = line.of_row().is_some();
            is_named |= !is_row && line.named(&self.told).0 > 0;
            self.ahead.push_back(line);
            if is_row && (is_named || first.is_none()) {
                first = Some(self.ahead.len());
            }
            if is_row && is_named {
                break;
            }
        }
        if first.is_none() && self.ahead.len() == LONGEST_PREAMBLE {
            return Err(self.malformed(format!(
                "there is no row of numbers in {LONGEST_PREAMBLE} lines"
            )));
        }
        let above = &self.ahead.make_contiguous()[..first.unwrap_or(self.lines as usize)];
        let Some(header) = preamble::find(above, &self.told) else {
            self.line.number = self.lines;
            let own = OWN.map(Quantity::column)[..LOADS].join(",");
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
        let found = columns::find(&self.headings, &self.told);
        self.sources = found.map_err(|unclear| {
            let fault = self.fault(1, None, unclear.message);
            match unclear.options.is_empty() {
                true => LoadsError::Malformed(fault),
                false => LoadsError::Unknown(fault, unclear.options),
            }
        })?;
        self.of_field = vec![None; self.headings.len()];
        for (i, source) in self.sources.iter().enumerate() {
            if let Source::Field(field) = source {
                self.of_field[field.number] = Some((i, *field));
            }
        }
        Ok(())
    }

    /// The number in a field, or the field's fault.
    fn number(&mut self, bytes: &[u8], column: usize, field: &Field) -> Result<f64, String> {
        let remedy = match OWN[column] {
            Quantity::Time => "; --columns time=- leaves the time out, and counts the rows",
            _ => "",
        };
        if bytes.is_empty() {
            return Err(format!("the field is empty; a number is needed{remedy}"));
        }
        let written;
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text,
            Err(_) => {
                written = text(bytes);
                &written
            }
        };
        let Some((value, mark)) = number(text) else {
            let marks = [',', '.', '\'', '’', '\u{a0}', '\u{202f}', ' '];
            let are_digits = text
                .chars()
                .all(|c| c.is_ascii_digit() || "+-".contains(c) || marks.contains(&c));
            let hint = match remedy {
                "" if are_digits && text.contains(marks) => {
                    ": it has thousands separators; write it without"
                }
                remedy => remedy,
            };
            return Err(format!("{} is not a number{hint}", shown(bytes)));
        };
        if let Some(mark) = mark {
            let is_first = self.decimal.is_none();
            if mark != *self.decimal.get_or_insert(mark) {
                // A comma may then be one of thousands.
                let [has, above] = match mark {
                    ',' => ["a comma", "points"],
                    _ => ["a point", "commas"],
                };
                let field = shown(bytes);
                return Err(format!(
                    "{field} has {has} where numbers above have decimal {above}; write all decimals one way"
                ));
            }
            // A point between commas is no mark of thousands.
            if is_first {
                self.may_be_thousands = mark == ',' || self.separator != b',';
            }
            self.may_be_thousands &= has_thousands(text);
        }
        let value = field.factor * field.unit.read(value);
        if field.unit.dimension == Dimension::Temperature {
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
        let count = split(&line, self.separator, |i, bytes| {
            if i >= wanted && !bytes.is_empty() {
                more.get_or_insert(i);
            }
            if let Some(Some((column, field))) = self.of_field.get(i).copied() {
                match self.number(bytes, column, &field) {
                    Ok(number) => numbers[column] = Some(number),
                    Err(message) => drop(bad.get_or_insert((i + 1, Some(column), message))),
                }
            }
        });
        self.line.text = line;
        let needed = self
            .of_field
            .iter()
            .rposition(Option::is_some)
            .map_or(0, |last| last + 1);
        let lost = match count {
            Err((field, message)) => Some((field, None, message.to_owned())),
            Ok(count) if count < needed => {
                let message = format!("the line ends after {count} of {wanted} fields");
                Some((
                    count + 1,
                    self.of_field[count].map(|(column, _)| column),
                    message,
                ))
            }
            Ok(count) => more.map(|_| {
                let hint = if self.separator == b',' {
                    DECIMAL_COMMAS
                } else {
                    ""
                };
                let message =
                    format!("the line has {count} fields where the header has {wanted}{hint}");
                (wanted + 1, None, message)
            }),
        };
        let is_lost = lost.is_some();
        // Where numbers are readable, the first bad one says more than a wrong count.
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

/// Whether the mark of a number may be one of thousands: one to three digits before it, three behind.
fn has_thousands(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-', '\u{2212}', ' ']);
    let parts = digits.split_once([',', '.']);
    let are_digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    parts.is_some_and(|(before, behind)| {
        (1..=3).contains(&before.len())
            && before != "0"
            && behind.len() == 3
            && are_digits(before)
            && are_digits(behind)
    })
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
