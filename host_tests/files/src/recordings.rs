//! Recorded loads: the CSV file of measured forces, moments and speed.
//!
//! Header `time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm`, columns in any order, one row an instant; `t_inner_c,t_outer_c`
//! besides, for spindles. Other columns are ignored. The header may be separated by commas, semicolons or tabs; with
//! semicolons and tabs, decimal commas are understood. Blank lines and lines that begin with `#` are skipped.
//! The file is read as a stream, so that a pipe of any length works. Every number is passed on as it
//! stands, `nan` and `inf` too: whether a row can be solved is for the solver to say. A row that cannot be read is an
//! error of that row: the rows after it are still there to be read.
//!
//! The file is taken line by line, each line one CSV record. That gives up line breaks inside quoted
//! fields, which no number needs, and keeps the line number in messages right under all
//! circumstances.

use csv::ByteRecord;
use std::fmt;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Write};

/// The columns of the file, in the order in which it is written. The last two are temperatures of the inner and of the outer
/// side, which the file may lack.
const NAMES: [&str; MOST] = [
    "time_s",
    "fx_n",
    "fy_n",
    "fz_n",
    "my_nm",
    "mz_nm",
    "speed_rpm",
    "t_inner_c",
    "t_outer_c",
];

/// Columns that the file must have.
const COLUMNS: usize = 7;

/// Most columns.
const MOST: usize = 9;

/// Their units.
const UNITS: [&str; MOST] = ["s", "N", "N", "N", "N m", "N m", "rpm", "deg C", "deg C"];

/// Separators of a line's fields; decimal commas go with semicolons and tabs.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];

const DECIMAL_COMMAS: &str = "decimals take a point where commas separate the fields; for decimal commas, \
     separate fields by semicolons, in the header too";

/// Length beyond which a line is no row of seven numbers. Without a bound, a stray binary file would
/// be read into memory before the complaint.
const LONGEST_LINE: u64 = 16 * 1024;

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
    let columns = if warm { MOST } else { COLUMNS };
    writeln!(out, "{}", NAMES[..columns].join(","))?;
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

/// A place in a file that is not as it must be, its fault, and the remedy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault(String);

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A row that cannot be read.
#[derive(Debug, Clone, PartialEq)]
pub struct BadRow {
    /// Why not.
    pub fault: Fault,
    /// Its readable numbers, in the order of the columns; none where the line has another number of fields.
    pub numbers: [Option<f64>; COLUMNS],
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
    /// The file is no recording of loads.
    Malformed(Fault),
    /// One row is at fault; the rows after it can be read.
    Row(Box<BadRow>),
}

impl fmt::Display for LoadsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { file, source } => write!(f, "{file}: cannot be read: {source}"),
            Self::Malformed(fault) => fault.fmt(f),
            Self::Row(row) => row.fault.fmt(f),
        }
    }
}

impl std::error::Error for LoadsError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Unreadable { source, .. } => Some(source),
            Self::Malformed(_) | Self::Row(_) => None,
        }
    }
}

/// Opens a file of recorded loads, `-` being standard input, and checks its header.
///
/// # Errors
///
/// A file that cannot be opened, or a header that lacks one of the seven columns.
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

/// The rows of a file of recorded loads, read one at a time. Ends after the first error that is not one of a row.
pub struct Loads {
    file: String,
    input: BufReader<Box<dyn Read>>,
    /// The field that holds each column; temperatures may be missing.
    field_of: [Option<usize>; MOST],
    /// Number of columns, ignored ones included.
    columns: usize,
    /// Names of the columns that are not ours.
    ignored: Vec<String>,
    separator: u8,
    /// The mark before decimals that the file has had first, where commas do not separate fields.
    decimal: Option<char>,
    lines: u64,
    bytes: u64,
    total_bytes: Option<u64>,
    ended: bool,
    line: Vec<u8>,
}

impl fmt::Debug for Loads {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Loads")
            .field("file", &self.file)
            .field("lines", &self.lines)
            .finish_non_exhaustive()
    }
}

/// Splits a line; the error is the column at fault and its fault.
fn split(line: &[u8], separator: u8) -> Result<ByteRecord, (usize, &'static str)> {
    let mut records = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(separator)
        .buffer_capacity(line.len())
        .from_reader(line)
        .into_byte_records()
        .map_while(Result::ok);
    let mut record = records.next().unwrap_or_default();
    let count = record.len();
    if record
        .iter()
        .next_back()
        .is_some_and(|last| last.ends_with(b"\n"))
    {
        let message = "a quotation mark is opened but not closed on this line";
        return Err((count, message));
    }
    let is_blank = |record: ByteRecord| record.iter().all(|field| field.trim_ascii().is_empty());
    if !records.all(is_blank) {
        let message = "a carriage return in the middle of the line; end lines with LF or CR LF";
        return Err((count, message));
    }
    record.trim();
    Ok(record)
}

impl Loads {
    /// Reads from `input`; messages call it `name`.
    ///
    /// # Errors
    ///
    /// A header that lacks one of the seven columns, or an input that fails.
    pub fn from_reader(name: &str, input: Box<dyn Read>) -> Result<Self, LoadsError> {
        let mut loads = Self {
            file: name.to_owned(),
            input: BufReader::with_capacity(64 * 1024, input),
            field_of: [None; MOST],
            columns: 0,
            ignored: Vec::new(),
            separator: b',',
            decimal: None,
            lines: 0,
            bytes: 0,
            total_bytes: None,
            ended: false,
            line: Vec::new(),
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
        self.field_of[MOST - 1].is_some()
    }

    /// The name of the file, as messages give it.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Names of the columns that are not read.
    pub fn ignored_columns(&self) -> &[String] {
        &self.ignored
    }

    /// Size of the input, if it is a plain file.
    pub fn total_bytes(&self) -> Option<u64> {
        self.total_bytes
    }

    /// A complaint of a field of the line, counted from 1; `column` is the one that it holds, if it is one of ours.
    fn fault(&self, field: usize, column: Option<usize>, message: impl fmt::Display) -> Fault {
        let (file, line) = (&self.file, self.lines.max(1));
        let name = column.map_or(String::new(), |column| format!(" ({})", NAMES[column]));
        Fault(format!(
            "{file}: line {line}, column {field}{name}: {message}"
        ))
    }

    fn malformed(
        &self,
        field: usize,
        column: Option<usize>,
        message: impl fmt::Display,
    ) -> LoadsError {
        LoadsError::Malformed(self.fault(field, column, message))
    }

    /// Brings the next line that is neither blank nor a comment into `self.line`; `false` at the end of the file.
    fn next_line(&mut self) -> Result<bool, LoadsError> {
        loop {
            let line = &mut self.line;
            line.clear();
            let taken = (&mut self.input)
                .take(LONGEST_LINE)
                .read_until(b'\n', line)
                .map_err(|source| LoadsError::Unreadable {
                    file: self.file.clone(),
                    source,
                })?;
            if taken == 0 {
                return Ok(false);
            }
            self.lines += 1;
            self.bytes += taken as u64;
            if self.lines == 1 {
                if line.starts_with(b"\xFF\xFE") || line.starts_with(b"\xFE\xFF") {
                    let message = "the file is UTF-16 text; save it as CSV in UTF-8";
                    return Err(self.malformed(1, None, message));
                }
                if line.starts_with(b"\xEF\xBB\xBF") {
                    line.drain(..3);
                }
            }
            if taken as u64 == LONGEST_LINE && line.last() != Some(&b'\n') {
                let message = format!(
                    "the line is longer than {LONGEST_LINE} bytes; is this a CSV file of loads?"
                );
                return Err(self.malformed(1, None, message));
            }
            if line.last() != Some(&b'\n') {
                line.push(b'\n');
            }
            let text = line.trim_ascii_start();
            if !text.is_empty() && text[0] != b'#' {
                return Ok(true);
            }
        }
    }

    fn header(&mut self) -> Result<(), LoadsError> {
        let wanted = NAMES[..COLUMNS].join(",");
        if !self.next_line()? {
            return Err(self.malformed(
                1,
                None,
                format!("the file is empty; it must begin with the header {wanted}"),
            ));
        }
        // The separator that shows most of the columns; a comma if none shows any.
        let ours = |separator: &u8| {
            let fields = split(&self.line, *separator);
            fields.map_or(0, |fields| fields.iter().filter_map(column_of).count())
        };
        let separators = SEPARATORS.into_iter().rev();
        self.separator = separators.max_by_key(ours).unwrap_or(b',');
        let fields = split(&self.line, self.separator);
        let fields = fields.map_err(|(column, message)| self.malformed(column, None, message))?;
        if fields.iter().all(|field| column_of(field).is_none()) {
            let message = format!(
                "{} is none of the columns of the header {wanted}, with which the file must begin",
                quoted(&fields[0])
            );
            return Err(self.malformed(1, None, message));
        }
        for (i, field) in fields.iter().enumerate() {
            if let Some(column) = column_of(field)
                && let Some(first) = self.field_of[column].replace(i)
            {
                let message = format!("the header has this column already as column {}", first + 1);
                return Err(self.malformed(i + 1, Some(column), message));
            }
        }
        let others = fields.iter().enumerate();
        let others: Vec<_> = others
            .filter(|(_, name)| column_of(name).is_none())
            .collect();
        let temperatures = COLUMNS..MOST;
        let warm = self.field_of[temperatures.clone()]
            .iter()
            .any(Option::is_some);
        for column in (0..MOST).filter(|column| self.field_of[*column].is_none()) {
            if temperatures.contains(&column) && !warm {
                continue;
            }
            if let Some((i, other)) = others.iter().find(|(_, other)| means(other, column)) {
                let message = format!(
                    "{} is not the column {}, which is missing; rename it, and convert its numbers \
                     if they have another unit than {}",
                    quoted(other),
                    NAMES[column],
                    UNITS[column],
                );
                return Err(self.malformed(i + 1, None, message));
            }
            let message = if temperatures.contains(&column) {
                "the header lacks this column; temperatures are those of both sides".to_owned()
            } else {
                format!("the header lacks this column; it must hold {wanted}, in any order")
            };
            return Err(self.malformed(fields.len() + 1, Some(column), message));
        }
        let named = others.iter().filter(|(_, name)| !name.is_empty());
        self.ignored = named.map(|(_, name)| shortened(name)).collect();
        self.columns = fields.len();
        Ok(())
    }

    /// The column in field `i`.
    fn column_in(&self, i: usize) -> Option<usize> {
        self.field_of.iter().position(|&field| field == Some(i))
    }

    /// The number in a field, or the field's fault.
    fn number(&mut self, field: &[u8]) -> Result<f64, String> {
        if field.is_empty() {
            return Err("the field is empty; a number is needed".to_owned());
        }
        let text = std::str::from_utf8(field).unwrap_or_default();
        let mark = text.chars().find(|c| [',', '.'].contains(c));
        let by_commas = self.separator == b',';
        let value = match mark {
            Some(',') if !by_commas => text.replacen(',', ".", 1).parse(),
            _ => text.parse(),
        };
        let Ok(value) = value else {
            let message = format!("{} is not a number", quoted(field));
            let hint = by_commas && text.contains(',');
            return Err(match hint {
                true => format!("{message}; {DECIMAL_COMMAS}"),
                false => message,
            });
        };
        let Some(mark) = mark.filter(|_| !by_commas) else {
            return Ok(value);
        };
        if mark == *self.decimal.get_or_insert(mark) {
            return Ok(value);
        }
        // A comma may then be one of thousands.
        let [has, above] = match mark {
            ',' => ["a comma", "points"],
            _ => ["a point", "commas"],
        };
        Err(format!(
            "{} has {has} where numbers above have decimal {above}; write all decimals one way",
            quoted(field)
        ))
    }

    fn row(&mut self) -> Result<Option<LoadRow>, LoadsError> {
        if !self.next_line()? {
            return Ok(None);
        }
        let mut numbers = [None; MOST];
        let mut bad = None;
        let fields = split(&self.line, self.separator).unwrap_or_else(|(column, message)| {
            bad = Some((column, None, message.to_owned()));
            ByteRecord::new()
        });
        // Where numbers are readable, the first bad one says more than a wrong count.
        let (count, wanted) = (fields.len(), self.columns);
        for (i, field) in fields.iter().enumerate().take(wanted) {
            let Some(column) = self.column_in(i) else {
                continue;
            };
            match self.number(field) {
                Ok(number) => numbers[column] = Some(number),
                Err(message) => drop(bad.get_or_insert((i + 1, Some(column), message))),
            }
        }
        if count != wanted {
            numbers = [None; MOST];
            bad.get_or_insert_with(|| {
                if count < wanted {
                    let message = format!("the line ends after {count} of {wanted} fields");
                    return (count + 1, self.column_in(count), message);
                }
                let message = format!("the line has {count} fields where the header has {wanted}");
                let message = match self.separator {
                    b',' => format!("{message}; {DECIMAL_COMMAS}"),
                    _ => message,
                };
                (wanted + 1, None, message)
            });
        }
        let [time, fx, fy, fz, my, mz, speed, inner, outer] = numbers;
        if let Some((column, name, message)) = bad {
            return Err(LoadsError::Row(Box::new(BadRow {
                fault: self.fault(column, name, message),
                numbers: [time, fx, fy, fz, my, mz, speed],
            })));
        }
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
        let row = self.row().transpose();
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

/// The column of this name, in capitals or not.
fn column_of(field: &[u8]) -> Option<usize> {
    let named = |name: &&str| name.as_bytes().eq_ignore_ascii_case(field);
    NAMES.iter().position(named)
}

/// Whether a name that is not `column`'s seems to be meant for it. It has another unit, none, or one
/// letter wrong, or is the unit alone.
fn means(field: &[u8], column: usize) -> bool {
    let letters = shortened(field).to_lowercase();
    let letters = letters.replace(|c: char| !c.is_alphanumeric(), "");
    let (stem, unit) = NAMES[column].rsplit_once('_').unwrap_or_default();
    let stem = stem.replace('_', "");
    letters.starts_with(&stem)
        || letters.len() > 2 && letters == unit
        || strsim::damerau_levenshtein(&letters, &(stem + unit)) <= 1
}
