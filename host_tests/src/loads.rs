//! Recorded loads: the CSV file of measured forces, moments and speed.
//!
//! Header `time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm`, columns in any order, one row an instant; `t_inner_c,t_outer_c`
//! besides, for spindles.
//! The file is read as a stream, so that a pipe of any length works. Every number is passed on as it
//! stands, `nan` and `inf` too: whether a row can be solved is for the solver to say.
//!
//! The file is taken line by line, each line one CSV record. That gives up line breaks inside quoted
//! fields, which no number needs, and keeps the line number in messages right under all
//! circumstances.

use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Write};

/// The columns of the file, in the order in which the program that writes them should put them.
pub const COLUMNS: [&str; 7] = [
    "time_s",
    "fx_n",
    "fy_n",
    "fz_n",
    "my_nm",
    "mz_nm",
    "speed_rpm",
];

/// The columns of temperatures that the file may have besides: of the inner and of the outer side.
pub const TEMPERATURES: [&str; 2] = ["t_inner_c", "t_outer_c"];

/// Most columns.
const MOST: usize = COLUMNS.len() + TEMPERATURES.len();

/// The name of a column.
fn column_name(column: usize) -> Option<&'static str> {
    COLUMNS.iter().chain(&TEMPERATURES).nth(column).copied()
}

/// A line longer than this is no row of seven numbers; without a bound, a stray binary file would
/// be read into memory before the complaint.
const LONGEST_LINE: u64 = 16 * 1024;

/// What was measured at one instant.
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
/// Those of the output.
pub fn write_csv(rows: &[LoadRow], out: &mut impl Write) -> io::Result<()> {
    let mut columns = COLUMNS.to_vec();
    if rows.iter().any(|row| row.temperatures.is_some()) {
        columns.extend(TEMPERATURES);
    }
    writeln!(out, "{}", columns.join(","))?;
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

/// A file that cannot be read, or a place in it that is not as it must be.
#[derive(Debug)]
pub enum LoadsError {
    /// The operating system refused to open or to read the file.
    Unreadable {
        /// Name of the file.
        file: String,
        /// Its reason.
        source: io::Error,
    },
    /// The contents are at fault.
    Malformed {
        /// Name of the file.
        file: String,
        /// Line, counted from 1, blank lines included.
        line: u64,
        /// Column, that is field of the line, counted from 1.
        column: usize,
        /// Name of that column, where it has one.
        name: Option<&'static str>,
        /// What is wrong with it, and what would be right.
        message: String,
    },
}

impl fmt::Display for LoadsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { file, source } => write!(f, "{file}: cannot be read: {source}"),
            Self::Malformed {
                file,
                line,
                column,
                name,
                message,
            } => {
                write!(f, "{file}: line {line}, column {column}")?;
                if let Some(name) = name {
                    write!(f, " ({name})")?;
                }
                write!(f, ": {message}")
            }
        }
    }
}

impl std::error::Error for LoadsError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Unreadable { source, .. } => Some(source),
            Self::Malformed { .. } => None,
        }
    }
}

/// Opens a file of recorded loads, `-` being standard input, and checks its header.
///
/// # Errors
///
/// A file that cannot be opened, or a header without exactly the seven columns.
pub fn read(path_or_dash: &str) -> Result<Loads, LoadsError> {
    if path_or_dash == "-" {
        return Loads::from_reader("standard input", Box::new(io::stdin()));
    }
    let unreadable = |source| LoadsError::Unreadable {
        file: path_or_dash.to_owned(),
        source,
    };
    let file = File::open(path_or_dash).map_err(unreadable)?;
    let metadata = file.metadata().map_err(unreadable)?;
    let mut loads = Loads::from_reader(path_or_dash, Box::new(file))?;
    loads.total_bytes = metadata.is_file().then_some(metadata.len());
    Ok(loads)
}

/// The rows of a file of recorded loads, read one at a time. Ends after the first error.
pub struct Loads {
    file: String,
    input: BufReader<Box<dyn Read>>,
    /// For each of [`COLUMNS`] and [`TEMPERATURES`], the field that holds it; temperatures may be missing.
    field_of: [Option<usize>; MOST],
    /// Number of columns.
    columns: usize,
    lines: u64,
    bytes: u64,
    total_bytes: Option<u64>,
    ended: bool,
    record: Record,
}

impl fmt::Debug for Loads {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Loads")
            .field("file", &self.file)
            .field("lines", &self.lines)
            .finish_non_exhaustive()
    }
}

/// The fields of one line.
#[derive(Default)]
struct Record {
    line: Vec<u8>,
    text: Vec<u8>,
    ends: Vec<usize>,
    count: usize,
}

impl Record {
    fn field(&self, i: usize) -> &[u8] {
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        self.text[start..self.ends[i]].trim_ascii()
    }

    /// Splits the line; the error is the column at fault and what is wrong.
    fn split(&mut self) -> Result<(), (usize, String)> {
        if self.line.last() != Some(&b'\n') {
            self.line.push(b'\n');
        }
        self.text.resize(self.line.len(), 0);
        self.ends.resize(self.line.len(), 0);
        let (result, used, _, fields) =
            csv_core::Reader::new().read_record(&self.line, &mut self.text, &mut self.ends);
        self.count = fields;
        if !matches!(result, csv_core::ReadRecordResult::Record) {
            return Err((
                fields + 1,
                "a quotation mark is opened but not closed on this line".to_owned(),
            ));
        }
        if !self.line[used..].trim_ascii().is_empty() {
            return Err((
                fields,
                "a carriage return in the middle of the line; end lines with LF or CR LF"
                    .to_owned(),
            ));
        }
        Ok(())
    }
}

impl Loads {
    /// Reads from `input`; messages call it `name`.
    ///
    /// # Errors
    ///
    /// A header without exactly the seven columns, or an input that fails.
    pub fn from_reader(name: &str, input: Box<dyn Read>) -> Result<Self, LoadsError> {
        let mut loads = Self {
            file: name.to_owned(),
            input: BufReader::with_capacity(64 * 1024, input),
            field_of: [None; MOST],
            columns: 0,
            lines: 0,
            bytes: 0,
            total_bytes: None,
            ended: false,
            record: Record::default(),
        };
        loads.header()?;
        Ok(loads)
    }

    /// Bytes taken from the input so far.
    pub fn bytes_read(&self) -> u64 {
        self.bytes
    }

    /// Whether there are columns of temperatures.
    pub fn has_temperatures(&self) -> bool {
        self.columns == MOST
    }

    /// Size of the input, if it is a plain file.
    pub fn total_bytes(&self) -> Option<u64> {
        self.total_bytes
    }

    fn malformed(
        &self,
        column: usize,
        name: Option<&'static str>,
        message: impl Into<String>,
    ) -> LoadsError {
        LoadsError::Malformed {
            file: self.file.clone(),
            line: self.lines.max(1),
            column,
            name,
            message: message.into(),
        }
    }

    /// Brings the next line that is not blank into `self.record`; `false` at the end of the file.
    fn next_record(&mut self) -> Result<bool, LoadsError> {
        loop {
            self.record.line.clear();
            let taken = (&mut self.input)
                .take(LONGEST_LINE)
                .read_until(b'\n', &mut self.record.line)
                .map_err(|source| LoadsError::Unreadable {
                    file: self.file.clone(),
                    source,
                })?;
            if taken == 0 {
                return Ok(false);
            }
            self.lines += 1;
            self.bytes += taken as u64;
            if taken as u64 == LONGEST_LINE && self.record.line.last() != Some(&b'\n') {
                let message = format!(
                    "the line is longer than {LONGEST_LINE} bytes; is this a CSV file of loads?"
                );
                return Err(self.malformed(1, None, message));
            }
            if self.record.line.trim_ascii().is_empty() {
                continue;
            }
            if let Err((column, message)) = self.record.split() {
                return Err(self.malformed(column, None, message));
            }
            return Ok(true);
        }
    }

    fn header(&mut self) -> Result<(), LoadsError> {
        let wanted = COLUMNS.join(",");
        if !self.next_record()? {
            return Err(self.malformed(
                1,
                None,
                format!("the file is empty; it must begin with the header {wanted}"),
            ));
        }
        let mut found = [None; MOST];
        for i in 0..self.record.count {
            let field = self.record.field(i);
            let Some(column) =
                (0..MOST).find(|&column| column_name(column).map(str::as_bytes) == Some(field))
            else {
                return Err(self.malformed(
                    i + 1,
                    None,
                    format!(
                        "{} is none of the columns of the header {wanted}",
                        quoted(field)
                    ),
                ));
            };
            if let Some(first) = found[column].replace(i) {
                return Err(self.malformed(
                    i + 1,
                    column_name(column),
                    format!("the header has this column already as column {}", first + 1),
                ));
            }
        }
        let temperatures = COLUMNS.len()..MOST;
        let warm = temperatures.clone().any(|column| found[column].is_some());
        for (column, field) in found.iter().enumerate() {
            if field.is_some() || (temperatures.contains(&column) && !warm) {
                continue;
            }
            let message = if temperatures.contains(&column) {
                "the header lacks this column; temperatures are those of both sides".to_owned()
            } else {
                format!("the header lacks this column; it must hold {wanted}, in any order")
            };
            return Err(self.malformed(self.record.count + 1, column_name(column), message));
        }
        self.field_of = found;
        self.columns = self.record.count;
        Ok(())
    }

    /// Name of the column in field `i`.
    fn name_of(&self, i: usize) -> Option<&'static str> {
        let column = self.field_of.iter().position(|&field| field == Some(i))?;
        column_name(column)
    }

    fn row(&mut self) -> Result<Option<LoadRow>, LoadsError> {
        if !self.next_record()? {
            return Ok(None);
        }
        let count = self.record.count;
        // Where numbers are readable, the first bad one says more than a wrong count.
        let mut numbers = [0.0; MOST];
        let wanted = self.columns;
        for (i, number) in numbers.iter_mut().enumerate().take(count.min(wanted)) {
            let field = self.record.field(i);
            *number = std::str::from_utf8(field)
                .ok()
                .and_then(|text| text.parse().ok())
                .ok_or_else(|| {
                    let message = if field.is_empty() {
                        "the field is empty; a number is needed".to_owned()
                    } else {
                        format!("{} is not a number", quoted(field))
                    };
                    self.malformed(i + 1, self.name_of(i), message)
                })?;
        }
        if count < wanted {
            return Err(self.malformed(
                count + 1,
                self.name_of(count),
                format!("the line ends after {count} of {wanted} numbers"),
            ));
        }
        if count > wanted {
            return Err(self.malformed(
                wanted + 1,
                None,
                format!(
                    "the line has {count} fields where the header has {wanted} (decimals take a point, \
                     not a comma)"
                ),
            ));
        }
        let [time_s, fx, fy, fz, my, mz, speed_rpm, inner, outer] = self
            .field_of
            .map(|field| field.map_or(0.0, |field| numbers[field]));
        Ok(Some(LoadRow {
            time_s,
            load: [fx, fy, fz, my, mz],
            speed_rpm,
            temperatures: self.has_temperatures().then_some([inner, outer]),
        }))
    }
}

impl Iterator for Loads {
    type Item = Result<LoadRow, LoadsError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let row = self.row().transpose();
        self.ended = !matches!(row, Some(Ok(_)));
        row
    }
}

/// A field as messages show it: readable, and short even if the field is not.
fn quoted(field: &[u8]) -> String {
    const SHOWN: usize = 40;
    let text = String::from_utf8_lossy(field);
    let mut shown: String = text.chars().take(SHOWN).collect();
    if text.chars().count() > SHOWN {
        shown.push_str("...");
    }
    format!("{shown:?}")
}
