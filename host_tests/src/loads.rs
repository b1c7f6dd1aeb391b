//! Recorded loads: the CSV file of measured forces, moments and speed.
//!
//! Header `time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm`, columns in any order, one row an instant; `t_inner_c,t_outer_c`
//! besides, for spindles. Other columns are ignored. The header may be separated by commas, semicolons or tabs; with
//! the latter two, decimal commas are understood. Blank lines and lines that begin with `#` are skipped.
//! The file is read as a stream, so that a pipe of any length works. Every number is passed on as it
//! stands, `nan` and `inf` too: whether a row can be solved is for the solver to say. A row that cannot be read is an
//! error of that row: the rows after it are still there to be read.
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

/// Their units.
const UNITS: [&str; MOST] = ["s", "N", "N", "N", "N m", "N m", "rpm", "deg C", "deg C"];

/// What their names are without the unit, in other people's files.
const STEMS: [&[&str]; MOST] = [
    &["time", "t"],
    &["fx", "forcex", "xforce", "loadx"],
    &["fy", "forcey", "yforce", "loady"],
    &["fz", "forcez", "zforce", "loadz"],
    &["my", "momenty", "torquey", "mty"],
    &["mz", "momentz", "torquez", "mtz"],
    &[
        "speed",
        "spindlespeed",
        "rotationalspeed",
        "n",
        "omega",
        "rpm",
        "krpm",
    ],
    &["tinner", "innertemperature", "temperatureinner"],
    &["touter", "outertemperature", "temperatureouter"],
];

/// Units that they have there, letters and digits alone; or none.
const OTHER_UNITS: [&str; 29] = [
    "", "s", "sec", "seconds", "ms", "us", "min", "h", "n", "dan", "kn", "lbf", "nm", "nmm", "ncm",
    "knm", "lbft", "rpm", "krpm", "rps", "hz", "rads", "1min", "min1", "umin", "k", "c", "f",
    "degc",
];

/// What may separate the fields of a line; decimal commas go with the latter two.
const SEPARATORS: [u8; 3] = [b',', b';', b'\t'];

const DECIMAL_COMMAS: &str = "decimals take a point where commas separate the fields; for decimal commas, \
     separate fields by semicolons, in the header too";

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

/// A place in a file that is not as it must be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Name of the file.
    pub file: String,
    /// Line, counted from 1, blank lines and comments included.
    pub line: u64,
    /// Column, that is field of the line, counted from 1.
    pub column: usize,
    /// Name of that column, where it has one.
    pub name: Option<&'static str>,
    /// What is wrong with it, and what would be right.
    pub message: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            file,
            line,
            column,
            name,
            message,
        } = self;
        write!(f, "{file}: line {line}, column {column}")?;
        if let Some(name) = name {
            write!(f, " ({name})")?;
        }
        write!(f, ": {message}")
    }
}

/// A row that cannot be read.
#[derive(Debug, Clone, PartialEq)]
pub struct BadRow {
    /// Why not.
    pub fault: Fault,
    /// What can be read of it, in the order of [`COLUMNS`]; nothing where its number of fields is wrong.
    pub numbers: [Option<f64>; COLUMNS.len()],
}

/// What is wrong with a file of recorded loads.
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
    /// For each of [`COLUMNS`] and [`TEMPERATURES`], the field that holds it; temperatures may be missing.
    field_of: [Option<usize>; MOST],
    /// Number of columns, ignored ones included.
    columns: usize,
    /// Names of the columns that are not ours.
    ignored: Vec<String>,
    separator: u8,
    /// The mark before decimals that the file has had first, where commas do not separate fields.
    decimal: Option<u8>,
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
    fn split(&mut self, separator: u8) -> Result<(), (usize, String)> {
        if self.line.last() != Some(&b'\n') {
            self.line.push(b'\n');
        }
        self.text.resize(self.line.len(), 0);
        self.ends.resize(self.line.len(), 0);
        let mut reader = csv_core::ReaderBuilder::new().delimiter(separator).build();
        let (result, used, _, fields) =
            reader.read_record(&self.line, &mut self.text, &mut self.ends);
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

    fn fault(
        &self,
        column: usize,
        name: Option<&'static str>,
        message: impl Into<String>,
    ) -> Fault {
        Fault {
            file: self.file.clone(),
            line: self.lines.max(1),
            column,
            name,
            message: message.into(),
        }
    }

    fn malformed(
        &self,
        column: usize,
        name: Option<&'static str>,
        message: impl Into<String>,
    ) -> LoadsError {
        LoadsError::Malformed(self.fault(column, name, message))
    }

    /// The error of a row of which nothing can be read.
    fn bad_row(&self, column: usize, name: Option<&'static str>, message: String) -> LoadsError {
        LoadsError::Row(Box::new(BadRow {
            fault: self.fault(column, name, message),
            numbers: [None; COLUMNS.len()],
        }))
    }

    /// Brings the next line that is neither blank nor a comment into `self.record`; `false` at the end of the file.
    fn next_line(&mut self) -> Result<bool, LoadsError> {
        loop {
            let line = &mut self.record.line;
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
            let text = line.trim_ascii_start();
            if !text.is_empty() && text[0] != b'#' {
                return Ok(true);
            }
        }
    }

    fn header(&mut self) -> Result<(), LoadsError> {
        let wanted = COLUMNS.join(",");
        if !self.next_line()? {
            return Err(self.malformed(
                1,
                None,
                format!("the file is empty; it must begin with the header {wanted}"),
            ));
        }
        // The separator that shows most of the columns; a comma if it is not for that to say.
        let mut most = 0;
        for separator in SEPARATORS {
            if self.record.split(separator).is_err() {
                continue;
            }
            let fields = 0..self.record.count;
            let ours = fields.filter(|&i| column_of(self.record.field(i)).is_some());
            let ours = ours.count();
            if ours > most {
                most = ours;
                self.separator = separator;
            }
        }
        if let Err((column, message)) = self.record.split(self.separator) {
            return Err(self.malformed(column, None, message));
        }
        if most == 0 {
            let first = quoted(self.record.field(0));
            let message = format!(
                "{first} is none of the columns of the header {wanted}, with which the file must begin"
            );
            return Err(self.malformed(1, None, message));
        }
        let mut found = [None; MOST];
        let mut others = Vec::new();
        for i in 0..self.record.count {
            let Some(column) = column_of(self.record.field(i)) else {
                others.push(i);
                continue;
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
            let meant = |i: &usize| means(self.record.field(*i), column);
            if let Some(&i) = others.iter().find(|i| meant(i)) {
                let name = column_name(column).unwrap_or_default();
                let message = format!(
                    "{} is not the column {name}, which is missing; rename it, and convert its numbers \
                     if they have another unit than {}",
                    quoted(self.record.field(i)),
                    UNITS[column],
                );
                return Err(self.malformed(i + 1, None, message));
            }
            let message = if temperatures.contains(&column) {
                "the header lacks this column; temperatures are those of both sides".to_owned()
            } else {
                format!("the header lacks this column; it must hold {wanted}, in any order")
            };
            return Err(self.malformed(self.record.count + 1, column_name(column), message));
        }
        let others = others.into_iter().map(|i| self.record.field(i));
        self.ignored = others
            .filter(|name| !name.is_empty())
            .map(shortened)
            .collect();
        self.field_of = found;
        self.columns = self.record.count;
        Ok(())
    }

    /// Name of the column in field `i`.
    fn name_of(&self, i: usize) -> Option<&'static str> {
        let column = self.field_of.iter().position(|&field| field == Some(i))?;
        column_name(column)
    }

    /// The number in a field; or what is wrong with it.
    fn number(&mut self, field: usize) -> Result<f64, String> {
        let text = self.record.field(field);
        if text.is_empty() {
            return Err("the field is empty; a number is needed".to_owned());
        }
        let not_a_number = || format!("{} is not a number", quoted(text));
        let read = |text: &str| text.parse::<f64>().map_err(|_| not_a_number());
        let written = std::str::from_utf8(text).map_err(|_| not_a_number())?;
        let mark = match (written.contains(','), written.contains('.')) {
            (false, false) => return read(written),
            (true, true) => None,
            (true, false) => Some(b','),
            (false, true) => Some(b'.'),
        };
        if self.separator == b',' {
            return read(written).map_err(|message| match mark {
                Some(b'.') => message,
                _ => format!("{message}; {DECIMAL_COMMAS}"),
            });
        }
        let value = if mark == Some(b',') {
            written.replacen(',', ".", 1).parse()
        } else {
            written.parse()
        };
        let value = value.map_err(|_| not_a_number())?;
        if mark != Some(*self.decimal.get_or_insert(mark.unwrap_or_default())) {
            // A comma may then be one of thousands.
            return Err(format!(
                "{} has {}; write all decimals one way",
                quoted(text),
                if mark == Some(b',') {
                    "a comma where numbers above have decimal points"
                } else {
                    "a point where numbers above have decimal commas"
                }
            ));
        }
        Ok(value)
    }

    fn row(&mut self) -> Result<Option<LoadRow>, LoadsError> {
        if !self.next_line()? {
            return Ok(None);
        }
        if let Err((column, message)) = self.record.split(self.separator) {
            return Err(self.bad_row(column, None, message));
        }
        let (count, wanted) = (self.record.count, self.columns);
        // Where numbers are readable, the first bad one says more than a wrong count.
        let mut numbers = [None; MOST];
        let mut bad = None;
        for i in 0..count.min(wanted) {
            let Some(column) = self.field_of.iter().position(|&field| field == Some(i)) else {
                continue;
            };
            match self.number(i) {
                Ok(number) => numbers[column] = Some(number),
                Err(message) => {
                    bad.get_or_insert_with(|| (i + 1, column_name(column), message));
                }
            }
        }
        if let Some((column, name, message)) = bad {
            let mut error = self.bad_row(column, name, message);
            if let (LoadsError::Row(row), true) = (&mut error, count == wanted) {
                let [time, fx, fy, fz, my, mz, speed, _, _] = numbers;
                row.numbers = [time, fx, fy, fz, my, mz, speed];
            }
            return Err(error);
        }
        if count < wanted {
            return Err(self.bad_row(
                count + 1,
                self.name_of(count),
                format!("the line ends after {count} of {wanted} fields"),
            ));
        }
        if count > wanted {
            let mut message = format!("the line has {count} fields where the header has {wanted}");
            if self.separator == b',' {
                message = format!("{message}; {DECIMAL_COMMAS}");
            }
            return Err(self.bad_row(wanted + 1, None, message));
        }
        let [time_s, fx, fy, fz, my, mz, speed_rpm, inner, outer] =
            numbers.map(Option::unwrap_or_default);
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
    let named = |name: &str| name.as_bytes().eq_ignore_ascii_case(field);
    (0..MOST).find(|&column| column_name(column).is_some_and(named))
}

/// Whether a name that is not `column`'s seems to be meant for it: it has another unit, none, or one letter wrong.
fn means(field: &[u8], column: usize) -> bool {
    let letters: String = String::from_utf8_lossy(field)
        .chars()
        .take(SHOWN)
        .filter(|c| c.is_alphanumeric())
        .collect::<String>()
        .to_lowercase();
    let names = STEMS[column].iter();
    let mut rests = names.filter_map(|stem| letters.strip_prefix(stem));
    let name = column_name(column).unwrap_or_default().replace('_', "");
    rests.any(|rest| OTHER_UNITS.contains(&rest)) || one_off(&letters, &name)
}

/// Whether two words become the same when each has one letter less, or one of them has.
fn one_off(a: &str, b: &str) -> bool {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let common = a.iter().zip(&b).take_while(|(a, b)| a == b).count();
    let (a, b) = (&a[common..], &b[common..]);
    let less = |word: &[char]| word.get(1..).unwrap_or_default().to_vec();
    less(a) == less(b) || less(a) == b || a == less(b)
}
