//! Where a recording's table begins: its header, the line of its units, and what the lines above say of the units.

use crate::told::{Heading, Quantity, Told};
use crate::units::{Dimension, Unit};

/// Separators of a line's fields: those that stand in numbers and sentences, too, last.
const SEPARATORS: [u8; 3] = [b'\t', b';', b','];

/// A line of the file, and its number.
#[derive(Debug, Default)]
pub struct Line {
    pub number: u64,
    pub text: Vec<u8>,
}

/// The header of a recording.
#[derive(Debug, Default)]
pub struct Header {
    /// Number of its line; of the first row where there is no header.
    pub line: u64,
    pub separator: u8,
    /// Its fields; numbers from 1 where there is no header.
    pub headings: Vec<Heading>,
    /// Lines up to the first row.
    pub length: usize,
}

/// Hands the fields of a line to `take`, and returns their number; the error is the field at fault, and its fault.
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
        for field in line.split(|byte| *byte == separator) {
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
    if record.iter().any(|field| field.contains(&b'\n')) {
        let open = "a quotation mark is opened but not closed on this line";
        return Err((record.len(), open));
    }
    let is_blank = |rest: csv::ByteRecord| rest.iter().all(|field| field.trim_ascii().is_empty());
    if !records.all(is_blank) {
        return Err((record.len(), MIDDLE));
    }
    for (i, field) in record.iter().enumerate() {
        take(i, field.trim_ascii());
    }
    Ok(record.len())
}

/// A number, and the mark before its decimals; a comma is one.
pub fn number(text: &str) -> Option<(f64, Option<char>)> {
    let mark = text.chars().find(|c| matches!(c, ',' | '.'));
    if let Ok(number) = text.parse() {
        return Some((number, mark));
    }
    // Data loggers set a blank after the sign, spreadsheets of some countries the minus of typesetting.
    let plain = text.replacen('\u{2212}', "-", 1).replacen(',', ".", 1);
    let plain = match plain.split_at_checked(1) {
        Some((sign @ ("+" | "-"), digits)) if digits.starts_with(' ') => {
            format!("{sign}0{}", digits.trim_start())
        }
        _ => plain,
    };
    Some((plain.parse().ok()?, mark))
}

/// A line that says nothing: blank, or a comment.
pub fn is_empty(line: &[u8], separator: u8) -> bool {
    match line.trim_ascii_start() {
        [] | [b'#' | b'%', ..] => true,
        [b';', ..] => separator != b';',
        _ => false,
    }
}

impl Line {
    /// Its fields as text; none where they cannot be told apart.
    fn fields(&self, separator: u8) -> Vec<String> {
        let mut fields = Vec::new();
        let text = |field: &[u8]| String::from_utf8_lossy(field).into_owned();
        let _ = split(&self.text, separator, |_, field| fields.push(text(field)));
        fields
    }

    /// The separator that shows most of what `counts` counts, and how much that is.
    fn best(&self, counts: impl Fn(&[String]) -> usize) -> (usize, u8) {
        let all = SEPARATORS.into_iter().rev();
        let all = all.map(|separator| (counts(&self.fields(separator)), separator));
        all.max_by_key(|(count, _)| *count).unwrap_or_default()
    }

    /// The separator of a row of numbers, if this is one: it begins with a number, and half of it are numbers.
    pub fn of_row(&self) -> Option<u8> {
        let (count, separator) = self.best(|fields| {
            let filled = fields.iter().filter(|field| !field.is_empty());
            let are: Vec<bool> = filled.map(|field| number(field).is_some()).collect();
            let count = are.iter().filter(|is| **is).count();
            let is_row = are.first() == Some(&true) && 2 * count >= are.len();
            if is_row { count } else { 0 }
        });
        (count > 1 && !is_empty(&self.text, separator)).then_some(separator)
    }
}

/// Whether fields are units: half of those that are filled, and none is a number.
fn are_units(fields: &[String]) -> bool {
    let filled: Vec<_> = fields.iter().filter(|field| !field.is_empty()).collect();
    let units = filled.iter().filter(|field| Unit::named(field).is_some());
    let units = units.count();
    units > 0 && 2 * units >= filled.len() && filled.iter().all(|field| number(field).is_none())
}

/// Number of fields that name a quantity.
fn named(fields: &[String], told: &Told) -> usize {
    let is_named = |text: &&String| {
        told.names(text)
            || Quantity::ALL
                .iter()
                .any(|one| Heading::new(text).means(*one))
    };
    fields.iter().filter(is_named).count()
}

/// Finds the header among the lines up to the first row of numbers, which is the last line if there is one.
///
/// It stands above the numbers, or above a line of units; else it is the line that names most quantities: the rows below are
/// then no numbers. None if there are no lines but comments.
pub fn find(lines: &[Line], told: &Told) -> Option<Header> {
    let row = lines.last().and_then(Line::of_row);
    let (data, by_row) = (
        lines.len() - usize::from(row.is_some()),
        row.unwrap_or(b','),
    );
    let above = || (0..data).rev().filter(|i| !is_empty(&lines[*i].text, 0));
    let Some(last) = above().next() else {
        let line = lines.last().filter(|_| row.is_some())?;
        let fields = line.fields(by_row).len();
        return Some(Header {
            line: line.number,
            separator: by_row,
            headings: (1..=fields).map(|i| Heading::new(&i.to_string())).collect(),
            length: data,
        });
    };
    let count = |i: usize| lines[i].best(|fields| named(fields, told));
    let units = |i: usize, separator| are_units(&lines[i].fields(separator));
    let before = above().nth(1).filter(|_| units(last, by_row));
    let nearest = before.unwrap_or(last);
    let header = match above().max_by_key(|i| count(*i).0) {
        Some(most) if count(nearest).0 == 0 && count(most).0 > 0 => most,
        _ => nearest,
    };
    let separator = match count(header) {
        (0, _) => by_row,
        (_, separator) => separator,
    };
    let mut headings: Vec<Heading> = lines[header]
        .fields(separator)
        .iter()
        .map(|text| Heading::new(text))
        .collect();
    let below = (header + 1..data).find(|i| !is_empty(&lines[*i].text, 0));
    let below = below.filter(|i| units(*i, separator));
    // LabVIEW has the units in the preamble.
    let labels = (0..header).find(|i| lines[*i].text.starts_with(b"Y_Unit_Label"));
    if let Some(units) = below.or(labels) {
        for (heading, unit) in headings.iter_mut().zip(lines[units].fields(separator)) {
            let is_unit = unit != "Y_Unit_Label" && !unit.is_empty();
            heading.add_unit(is_unit.then_some(unit));
        }
    }
    for dimension in [Dimension::Force, Dimension::Moment] {
        if let Some(unit) = counted(&lines[..header], dimension) {
            for heading in &mut headings {
                heading.count(unit);
            }
        }
    }
    Some(Header {
        line: lines[header].number,
        separator,
        headings,
        length: below.unwrap_or(header) + 1,
    })
}

/// The unit of counts, as ATI's sensors write it: `Force Units: N, Counts per Unit Force: 1000000`.
fn counted(preamble: &[Line], dimension: Dimension) -> Option<Unit> {
    let [name, other] = match dimension {
        Dimension::Force => ["force", "force"],
        _ => ["torque", "moment"],
    };
    let (mut unit, mut counts) = (Unit::of(dimension), None);
    for line in preamble {
        let text = String::from_utf8_lossy(&line.text).to_lowercase();
        let parts: Vec<&str> = text
            .split([',', ';', '\t', ':', '='])
            .map(str::trim)
            .collect();
        for pair in parts.windows(2) {
            let [key, value] = [pair[0], pair[1]].map(|text| text.trim_matches('"'));
            if !(key.contains(name) || key.contains(other)) {
                continue;
            }
            if key.contains("counts") {
                counts = value.parse().ok().filter(|count| *count > 0.0).or(counts);
            } else if key.contains("unit") {
                unit = Unit::named(value)
                    .filter(|unit| unit.dimension == dimension)
                    .unwrap_or(unit);
            }
        }
    }
    counts.map(|count: f64| unit.counted(count))
}
