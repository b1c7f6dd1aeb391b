//! Lines of a text file, their fields and numbers.

use crate::fault::LoadsError;
use std::fmt::Write;
use std::io::{BufRead, BufReader, Read};

/// Length beyond which a line is no row of numbers. Without a bound, a stray binary file would be read into memory before
/// the complaint.
const LONGEST_LINE: u64 = 16 * 1024;

/// Separators of fields by their names in a description. Blanks separate by any number.
pub const SEPARATORS: [(&str, u8); 4] = [
    ("tab", b'\t'),
    ("semicolon", b';'),
    ("comma", b','),
    ("blank", b' '),
];

/// First bytes of files that are no text, what they are, and how to get a table of them.
const NO_TEXT: [(&[u8], &str); 6] = [
    (
        b"PK\x03\x04",
        "an Excel workbook or another zip archive: save its sheet as CSV",
    ),
    (
        b"\xD0\xCF\x11\xE0",
        "an old Excel workbook: save its sheet as CSV",
    ),
    (
        b"TDSm",
        "a TDMS file of LabVIEW: export it as text from DIAdem, or by Excel's TDM importer",
    ),
    (
        b"MATLAB ",
        "a MAT-file of MATLAB: write the table by writetable(T, 'loads.csv')",
    ),
    (
        b"\x89HDF",
        "an HDF5 or MAT-file: write its table as CSV, in MATLAB by writetable(T, 'loads.csv')",
    ),
    (
        b"\x1F\x8B",
        "compressed: unpack it by gunzip, into a pipe to `-` if it is large",
    ),
];

/// A line of the file, and its number from 1.
#[derive(Debug, Clone, Default)]
pub struct Line {
    pub number: u64,
    pub text: Vec<u8>,
}

impl Line {
    /// Its fields as text; none where they cannot be told apart. A name may go over several lines.
    pub fn fields(&self, separator: u8) -> Vec<String> {
        let mut fields = Vec::new();
        let take = |_, field: &[u8]| fields.push(text(field).replace("\r\n", "\n"));
        match split(&self.text, separator, take) {
            Ok(_) => fields,
            Err(_) => Vec::new(),
        }
    }

    /// It has nothing but separators.
    pub fn is_blank(&self) -> bool {
        let mut bytes = self.text.iter();
        bytes.all(|byte| b",;\" \t\r\n\x1a".contains(byte))
    }

    /// A field begins with a quotation mark that is not closed: the line goes on below.
    pub fn is_open(&self) -> bool {
        let (mut is_open, mut before) = (false, b',');
        for byte in &self.text {
            if *byte == b'"' {
                is_open = !is_open && b",;\t \n\"".contains(&before);
            }
            before = *byte;
        }
        is_open
    }
}

/// The lines of a file as a stream, so that a pipe of any length works.
pub struct Lines {
    pub file: String,
    input: BufReader<Box<dyn Read + Send>>,
    number: u64,
    pub bytes: u64,
    /// The first line is that of a universal file.
    may_be_universal: bool,
}

impl Lines {
    pub fn new(file: &str, input: Box<dyn Read + Send>) -> Self {
        Self {
            file: file.to_owned(),
            input: BufReader::with_capacity(64 * 1024, input),
            number: 0,
            bytes: 0,
            may_be_universal: false,
        }
    }

    /// Error of the line of this number.
    pub fn malformed(&self, number: u64, message: impl std::fmt::Display) -> LoadsError {
        let number = number.max(1);
        LoadsError::Malformed(format!("{}: line {number}, column 1: {message}", self.file))
    }

    /// Brings the next line of the file, with a line feed at its end; `false` after the last.
    pub fn next(&mut self, line: &mut Line) -> Result<bool, LoadsError> {
        let text = &mut line.text;
        text.clear();
        let taken = (&mut self.input)
            .take(LONGEST_LINE)
            .read_until(b'\n', text)
            .map_err(|source| LoadsError::Unreadable {
                file: self.file.clone(),
                source,
            })?;
        if taken == 0 {
            return Ok(false);
        }
        self.number += 1;
        line.number = self.number;
        self.bytes += taken as u64;
        if self.number <= 2 {
            self.check(text)?;
        }
        if taken as u64 == LONGEST_LINE && text.last() != Some(&b'\n') {
            let message =
                format!("the line is longer than {LONGEST_LINE} bytes; is this a table of loads?");
            return Err(self.malformed(self.number, message));
        }
        if text.last() != Some(&b'\n') {
            text.push(b'\n');
        }
        Ok(true)
    }

    /// Looks at the first two lines, whether the file is text at all.
    fn check(&mut self, text: &mut Vec<u8>) -> Result<(), LoadsError> {
        let trimmed = text.trim_ascii();
        let word = trimmed
            .split(|byte| *byte == b' ')
            .next()
            .unwrap_or_default();
        let word = word.strip_suffix(b"b").unwrap_or(word);
        let digits = word.iter().all(u8::is_ascii_digit) && !word.is_empty();
        let universal = self.may_be_universal && digits;
        let first = self.number == 1;
        self.may_be_universal = first && trimmed == b"-1";
        let mut known = NO_TEXT.iter();
        let known = known.find(|(start, _)| first && text.starts_with(start));
        let zeros = text.iter().filter(|byte| **byte == 0).count();
        let is_wide = first && (text.starts_with(b"\xFF\xFE") || text.starts_with(b"\xFE\xFF"));
        let message = if let Some((_, known)) = known {
            format!("the file is {known}")
        } else if universal {
            "the file is a universal file (UFF): export the time histories as CSV from the program that wrote it".to_owned()
        } else if is_wide || text.len() > 3 && 3 * zeros > text.len() {
            "the file is UTF-16 text; save it as CSV in UTF-8".to_owned()
        } else {
            if first && text.starts_with(b"\xEF\xBB\xBF") {
                text.drain(..3);
            }
            return Ok(());
        };
        Err(self.malformed(self.number, message))
    }
}

/// Hands the fields of a line, with their numbers, to `take`. Returns how many there are, or the field at fault and its fault.
pub fn split(
    line: &[u8],
    separator: u8,
    mut take: impl FnMut(usize, &[u8]),
) -> Result<usize, (usize, &'static str)> {
    const MIDDLE: &str = "a carriage return in the middle of the line; end lines with LF or CR LF";
    if !line.contains(&b'"') {
        let line = line.strip_suffix(b"\n").unwrap_or(line);
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let mut count = 0;
        let by_blanks = separator == b' ';
        for field in line.split(|byte| *byte == separator || by_blanks && *byte == b'\t') {
            if by_blanks && field.trim_ascii().is_empty() {
                continue;
            }
            count += 1;
            if field.contains(&b'\r') {
                return Err((count, MIDDLE));
            }
            take(count - 1, field.trim_ascii());
        }
        return Ok(count);
    }
    let mut records = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(separator)
        .buffer_capacity(line.len())
        .from_reader(line)
        .into_byte_records()
        .map_while(Result::ok);
    let record = records.next().unwrap_or_default();
    let end = record.iter().next_back().unwrap_or_default();
    if end.ends_with(b"\n") {
        let open = "a quotation mark is opened but not closed on this line";
        return Err((record.len(), open));
    }
    let is_blank = |rest: csv::ByteRecord| rest.iter().all(|field| field.trim_ascii().is_empty());
    if !records.all(is_blank) {
        return Err((record.len(), MIDDLE));
    }
    let mut count = 0;
    for field in record.iter() {
        if separator != b' ' || !field.trim_ascii().is_empty() {
            take(count, field.trim_ascii());
            count += 1;
        }
    }
    Ok(count)
}

/// A number with these decimals, to the letter: no mark of thousands. A blank may stand behind the sign, which may be the
/// minus of typesetting.
pub fn number(text: &str, decimal: u8) -> Option<f64> {
    let is_comma = decimal == b',';
    if is_comma && text.contains('.') || !is_comma && text.contains(',') {
        return None;
    }
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    let plain = text.replacen('\u{2212}', "-", 1).replacen(',', ".", 1);
    match plain.split_at_checked(1) {
        Some((sign @ ("+" | "-"), digits)) if digits.starts_with(' ') => {
            let digits = digits.trim_start();
            let is_signed = digits.starts_with(['+', '-']);
            let number = format!("{sign}{digits}").parse().ok();
            number.filter(|_| !is_signed)
        }
        _ => plain.parse().ok(),
    }
}

/// Text of a field: UTF-8, or what Windows writes in the west.
pub fn text(field: &[u8]) -> String {
    match std::str::from_utf8(field) {
        Ok(text) => text.to_owned(),
        Err(_) => field.iter().map(|byte| char::from(*byte)).collect(),
    }
}

/// Characters of a field that messages show.
const SHOWN: usize = 40;

/// A field as messages show it: between quotation marks, readable, and short even if the field is not.
pub fn shown(field: &str) -> String {
    let mut shown: String = field.chars().take(SHOWN).collect();
    if field.chars().count() > SHOWN {
        shown.push_str("...");
    }
    format!("{shown:?}")
}

/// The first of these names, and the number of the others.
pub fn listed(names: &[String]) -> String {
    const MOST: usize = 12;
    let quoted = names.iter().take(MOST).map(|name| shown(name));
    let mut list = quoted.collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        let _ = write!(list, " and {} more", names.len() - MOST);
    }
    list
}
