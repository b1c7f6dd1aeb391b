//! Lines of a text file, and their fields.

use crate::fault::LoadsError;
use std::fmt::{Display, Write};
use std::io::{self, BufRead, BufReader, Read};

/// Length beyond which a line is no row of numbers. Without a bound, a stray binary file would be read into memory before
/// the complaint.
const LONGEST_LINE: u64 = 16 * 1024;

/// Error of a file that the operating system refused to open or to read.
pub fn unreadable(file: &str, error: &io::Error) -> LoadsError {
    LoadsError::Malformed(format!("{file}: cannot be read: {error}"))
}

/// The lines of a file as a stream, so that a pipe of any length works.
pub struct Lines {
    pub file: String,
    input: BufReader<Box<dyn Read + Send>>,
    /// The line, without its line feed, and its number from 1.
    pub text: Vec<u8>,
    pub number: u64,
    pub bytes: u64,
}

impl Lines {
    pub fn new(file: &str, input: Box<dyn Read + Send>) -> Self {
        Self {
            file: file.to_owned(),
            input: BufReader::with_capacity(64 * 1024, input),
            text: Vec::new(),
            number: 0,
            bytes: 0,
        }
    }

    /// Error of a field of the line, counted from 1, which ends the reading.
    pub fn malformed(&self, field: usize, message: impl Display) -> LoadsError {
        let (file, line) = (&self.file, self.number.max(1));
        LoadsError::Malformed(format!("{file}: line {line}, column {field}: {message}"))
    }

    /// Brings the next line of the file; `false` after the last.
    pub fn next(&mut self) -> Result<bool, LoadsError> {
        self.text.clear();
        let taken = (&mut self.input)
            .take(LONGEST_LINE)
            .read_until(b'\n', &mut self.text)
            .map_err(|error| unreadable(&self.file, &error))?;
        if taken == 0 {
            return Ok(false);
        }
        self.number += 1;
        self.bytes += taken as u64;
        if self.text.last() == Some(&b'\n') {
            self.text.pop();
        } else if taken as u64 == LONGEST_LINE {
            let message =
                format!("the line is longer than {LONGEST_LINE} bytes; is this a table of loads?");
            return Err(self.malformed(1, message));
        }
        if self.number == 1 && self.text.starts_with(b"\xEF\xBB\xBF") {
            self.text.drain(..3);
        }
        Ok(true)
    }

    /// The line has nothing but separators.
    pub fn is_blank(&self) -> bool {
        let mut bytes = self.text.iter();
        bytes.all(|byte| b",;\" \t\r\x1a".contains(byte))
    }
}

/// Hands the fields of a line, with their numbers, to `take`. Returns how many there are, or the field at fault and its fault.
pub fn split(
    line: &str,
    separator: u8,
    mut take: impl FnMut(usize, &str),
) -> Result<usize, (usize, &'static str)> {
    let line = line.strip_suffix('\r').unwrap_or(line);
    let mut count = 0;
    if let Some(at) = line.find('\r') {
        let before = line[..at].bytes().filter(|byte| *byte == separator);
        let middle = "a carriage return in the middle of the line; end lines with LF or CR LF";
        return Err((1 + before.count(), middle));
    }
    if !line.contains('"') {
        for field in line.split(char::from(separator)) {
            take(count, field.trim_ascii());
            count += 1;
        }
        return Ok(count);
    }
    // A quotation mark that is not closed takes the line feed into the last field.
    let line = format!("{line}\n");
    let mut reader = csv::ReaderBuilder::new();
    let reader = reader
        .has_headers(false)
        .flexible(true)
        .delimiter(separator);
    let mut records = reader.from_reader(line.as_bytes()).into_records();
    let record = records.next().and_then(Result::ok).unwrap_or_default();
    let mut ends = record.iter().rev();
    if ends.next().is_some_and(|end| end.ends_with('\n')) {
        let open = "a quotation mark is opened but not closed on this line";
        return Err((record.len(), open));
    }
    for field in &record {
        take(count, field.trim_ascii());
        count += 1;
    }
    Ok(count)
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

/// The first `most` of these names, and the number of the others.
pub fn listed(names: &[String], most: usize) -> String {
    let quoted = names.iter().take(most).map(|name| shown(name));
    let mut list = quoted.collect::<Vec<_>>().join(", ");
    if names.len() > most {
        let _ = write!(list, " and {} more", names.len() - most);
    }
    list
}
