//! Where a recording's table begins: its header, the line of its units, and what the lines above say of the units.

use crate::told::{Heading, Quantity, Told};
use crate::units::{Dimension, Unit};
use std::fmt::Write;

/// Separators of a line's fields: those that stand in numbers and sentences, too, last. Blanks separate by any number.
const SEPARATORS: [u8; 4] = [b'\t', b';', b',', b' '];

/// Units of quantities that are not read, in a line of units.
const OTHER_UNITS: [&str; 16] = [
    "v", "mv", "a", "ma", "w", "kw", "bar", "deg", "mm", "um", "m", "g", "mps2", "%", "-", "1",
];

/// First words of lines about the columns that stand below the names.
const LABELS: [&str; 12] = [
    "blocksize",
    "vunit",
    "samplerate",
    "hresolution",
    "hoffset",
    "hunit",
    "phaseshift",
    "date",
    "displayblocksize",
    "displaypointno",
    "float64",
    "double",
];

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

/// A line that says nothing: nothing but separators, or a comment.
pub fn is_empty(line: &[u8], separator: u8) -> bool {
    match line.trim_ascii_start() {
        [b'#' | b'%', ..] => true,
        [b';', ..] if separator != b';' => true,
        line => line.iter().all(|byte| b",;\" \t\r\n\x1a".contains(byte)),
    }
}

/// Text of a field: UTF-8, or what Windows writes in the west.
pub fn text(field: &[u8]) -> String {
    match std::str::from_utf8(field) {
        Ok(text) => text.to_owned(),
        Err(_) => field.iter().map(|byte| char::from(*byte)).collect(),
    }
}

impl Line {
    /// Its fields as text; none where they cannot be told apart.
    fn fields(&self, separator: u8) -> Vec<String> {
        let mut fields = Vec::new();
        let _ = split(&self.text, separator, |_, field| fields.push(text(field)));
        fields
    }

    /// The largest count over all separators, and the separator.
    fn most(&self, count: impl Fn(&[String]) -> usize) -> (usize, u8) {
        let all = SEPARATORS.into_iter().rev();
        let all = all.map(|separator| (count(&self.fields(separator)), separator));
        all.max_by_key(|(count, _)| *count).unwrap_or_default()
    }

    /// The separator of a row of numbers, if this is one: it begins with a number, and half of it are numbers.
    pub fn of_row(&self) -> Option<u8> {
        let (count, separator) = self.most(|fields| {
            let filled = fields.iter().filter(|field| !field.is_empty());
            let are: Vec<bool> = filled.map(|field| number(field).is_some()).collect();
            let count = are.iter().filter(|is| **is).count();
            let is_row = are.first() == Some(&true) && 2 * count >= are.len();
            if is_row { count } else { 0 }
        });
        (count > 1 && !self.is_empty()).then_some(separator)
    }

    /// It says nothing, whatever separates its fields: several semicolons are no comment.
    fn is_empty(&self) -> bool {
        let semicolons = self.text.iter().filter(|byte| **byte == b';').count();
        is_empty(&self.text, if semicolons > 1 { b';' } else { b',' })
    }

    /// The comment without its mark.
    fn uncommented(&self) -> Self {
        let is_mark = |byte: &u8| b"#%; \t".contains(byte);
        let text = self.text.iter().copied().skip_while(is_mark);
        Self {
            number: self.number,
            text: text.collect(),
        }
    }

    /// Number of fields that name a quantity, and the separator that shows most of them.
    pub fn named(&self, told: &Told) -> (usize, u8) {
        self.most(|fields| {
            let is_named = |text: &&String| {
                let heading = Heading::new(text);
                told.names(text) || Quantity::ALL.iter().any(|one| heading.means(*one))
            };
            fields.iter().filter(is_named).count()
        })
    }

    /// It has units: half of the fields at least, and none is a number.
    fn has_units(&self, separator: u8) -> bool {
        let fields = self.fields(separator);
        let filled: Vec<&String> = fields.iter().filter(|field| !field.is_empty()).collect();
        let is_other = |field: &str| OTHER_UNITS.contains(&field.to_lowercase().as_str());
        let known = filled
            .iter()
            .filter(|field| Unit::named(field).is_some())
            .count();
        let other = filled.iter().filter(|field| is_other(field)).count();
        let are_words = filled
            .iter()
            .all(|field| is_other(field) || number(field).is_none());
        known > 0 && 2 * (known + other) >= filled.len() && are_words
    }

    /// Its first word is one of these, letters alone.
    fn begins_with(&self, labels: &[&str]) -> bool {
        let letters = self.text.iter().skip_while(|byte| **byte == b'"');
        let letters = letters.take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_');
        let word: Vec<u8> = letters
            .filter(|byte| **byte != b'_')
            .map(u8::to_ascii_lowercase)
            .collect();
        labels.iter().any(|label| label.as_bytes() == word)
    }
}

/// Finds the header among the lines up to the first row of numbers, which is the last line if there is one.
///
/// It is the line that names most quantities, the last of them; where none does, the line above the numbers, or above a line
/// of units. None if there are no lines but comments.
pub fn find(lines: &[Line], told: &Told) -> Option<Header> {
    let row = lines.last().and_then(Line::of_row);
    let data = lines.len() - usize::from(row.is_some());
    let by_row = row.unwrap_or(b',');
    let mut above: Vec<usize> = (0..data).filter(|i| !lines[*i].is_empty()).collect();
    let named = |i: &usize| lines[*i].named(told).0;
    let most = above
        .iter()
        .copied()
        .max_by_key(named)
        .filter(|i| named(i) > 0);
    let commented = |i: &usize| lines[*i].uncommented().named(told).0 > 1;
    let comment = (0..data).rev().find(|i| most.is_none() && commented(i));
    let is_units = |i: &usize| lines[*i].has_units(by_row);
    let header = most.or(comment).or_else(|| match above.pop()? {
        last if is_units(&last) => above.pop().or(Some(last)),
        last => Some(last),
    });
    let Some(header) = header else {
        // No names: columns are called by their numbers.
        let line = lines.last().filter(|_| row.is_some())?;
        let numbers = 1..=line.fields(by_row).len();
        return Some(Header {
            line: line.number,
            separator: by_row,
            headings: numbers.map(|i| Heading::new(&i.to_string())).collect(),
            length: data,
        });
    };
    let line = lines[header].uncommented();
    let line = if comment.is_some() {
        &line
    } else {
        &lines[header]
    };
    let separator = match line.named(told) {
        (0, _) => by_row,
        (_, separator) => separator,
    };
    let mut header_of = Header {
        line: line.number,
        separator,
        headings: line
            .fields(separator)
            .iter()
            .map(|text| Heading::new(text))
            .collect(),
        length: header + 1,
    };
    // Lines about the columns; units stand below the names, just above, or in the preamble of LabVIEW.
    let is_about = |i: &usize| {
        lines[*i].has_units(separator) || lines[*i].begins_with(&LABELS) || lines[*i].is_empty()
    };
    let about: Vec<usize> = (header + 1..data).take_while(is_about).collect();
    let units = |i: &usize| lines[*i].has_units(separator) || lines[*i].begins_with(&["vunit"]);
    let before = (0..header).rev().find(|i| !lines[*i].is_empty());
    let labels = (0..header).find(|i| lines[*i].begins_with(&["yunitlabel"]));
    let units = about
        .iter()
        .copied()
        .find(units)
        .or(before.filter(units))
        .or(labels);
    if let Some(units) = units {
        let is_label = lines[units].begins_with(&["yunitlabel", "vunit"]);
        let fields = lines[units].fields(separator).into_iter();
        for (heading, unit) in header_of
            .headings
            .iter_mut()
            .zip(fields)
            .skip(usize::from(is_label))
        {
            heading.add_unit(&unit);
        }
    }
    header_of.length = about.last().copied().unwrap_or(header) + 1;
    let first = lines[header_of.length..]
        .iter()
        .find(|line| !line.is_empty());
    let first = first.map_or(Vec::new(), |line| line.fields(separator));
    for dimension in [Dimension::Force, Dimension::Moment] {
        let (unit, counts) = said_above(&lines[..header], dimension);
        for (i, heading) in header_of.headings.iter_mut().enumerate() {
            // Counts are whole; numbers with decimals are in the unit already.
            let is_whole = first
                .get(i)
                .is_some_and(|field| !field.contains(['.', ',']));
            let counted = unit
                .unwrap_or(Unit::of(dimension))
                .counted(counts.unwrap_or(1.0));
            match counts {
                Some(_) if is_whole => heading.assume(counted),
                _ => unit.into_iter().for_each(|unit| heading.assume(unit)),
            }
        }
    }
    Some(header_of)
}

/// The unit of a dimension that the preamble says, and the counts of that, as ATI's sensors write it: `Force Units: N, Counts
/// per Unit Force: 1000000`.
fn said_above(preamble: &[Line], dimension: Dimension) -> (Option<Unit>, Option<f64>) {
    let name = if dimension == Dimension::Force {
        "force"
    } else {
        "torque"
    };
    let (mut unit, mut counts) = (None, None);
    for line in preamble {
        let line = text(&line.text).to_lowercase();
        let behind = |phrase: &str| {
            let (before, value) = line.split_once(phrase)?;
            let is_start = !before.ends_with(char::is_alphanumeric);
            let value = value.trim_start_matches(['s', '"', ':', '=', ',', ';', '\t', ' ']);
            is_start.then(|| value.to_owned())
        };
        if let Some(value) = behind(&format!("{name} unit")) {
            let end = value
                .find([',', ';', '\t', '"', '\r', '\n'])
                .unwrap_or(value.len());
            let found = Unit::named(&value[..end]);
            unit = found.filter(|unit| unit.dimension == dimension).or(unit);
        }
        let phrases = [
            format!("counts per unit {name}"),
            format!("counts per {name}"),
        ];
        if let Some(value) = phrases.iter().find_map(|phrase| behind(phrase)) {
            let digits = value
                .chars()
                .take_while(|c| c.is_ascii_digit() || ",.".contains(*c));
            let digits: String = digits.filter(|c| *c != ',').collect();
            counts = digits.parse().ok().filter(|count| *count > 0.0).or(counts);
        }
    }
    (unit, counts)
}

/// Characters of a field that messages show.
const SHOWN: usize = 40;

/// A field as messages show it: between quotation marks, readable, and short even if the field is not.
pub fn shown(field: &[u8]) -> String {
    format!("{:?}", shortened(field))
}

/// The first characters of a field.
pub fn shortened(field: &[u8]) -> String {
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
    let quoted = names.iter().take(MOST).map(|name| shown(name.as_bytes()));
    let mut list = quoted.collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        let _ = write!(list, " and {} more", names.len() - MOST);
    }
    list
}
