//! The table in a file: its separator, header, rows, and the lines above.

use super::heading::Heading;
use crate::lines::{Line, SEPARATORS, number};
use crate::quantities::Quantity;
use crate::recordings::is_clock;
use crate::units::{Dimension, Unit};

/// Lines between a header and its first row: units, types, channels.
const BETWEEN: usize = 15;

/// Marks of comments.
const MARKS: [&str; 4] = ["#", "%", "//", ";"];

/// A table in a file.
pub struct Sheet {
    pub separator: (&'static str, u8),
    /// Lines above the first row.
    pub above: Vec<Line>,
    /// Number in these of the header.
    pub header: Option<usize>,
    pub first_row: u64,
    /// Names of the columns; empty ones where there is no header.
    pub headings: Vec<Heading>,
    /// Fields of the rows that are looked at.
    pub rows: Vec<Vec<String>>,
    pub comment: Option<&'static str>,
    /// Rows lack their last columns, and whether these are surely ignored.
    pub short_rows: Option<bool>,
    /// Names and fields of the rows do not fit together: there is no header.
    pub is_shifted: bool,
}

/// Lines with their fields.
struct Split {
    separator: u8,
    lines: Vec<(Line, Vec<String>)>,
    /// Rows count columns: no line says their numbers.
    are_counts: bool,
    /// Rows begin with words.
    have_words: bool,
}

impl Split {
    fn new(lines: &[Line], separator: u8) -> Self {
        let lines = lines
            .iter()
            .map(|line| (line.clone(), line.fields(separator)));
        let mut split = Self {
            separator,
            lines: lines.collect(),
            are_counts: false,
            have_words: false,
        };
        let rows = || split.lines.iter().filter(|(_, fields)| is_row(fields));
        let are_counts = rows().all(|(_, fields)| counts_columns(fields));
        let have_words = rows()
            .next_back()
            .is_some_and(|(_, fields)| begins_with_word(fields));
        (split.are_counts, split.have_words) = (are_counts, have_words);
        split
    }

    /// Numbers in rows.
    fn values(&self) -> usize {
        let rows = self.lines.iter().filter(|(_, fields)| is_row(fields));
        rows.map(|(_, fields)| fields.iter().filter(|field| is_value(field)).count())
            .sum()
    }

    /// A row of the recording: no label of units or types, no numbers of channels.
    fn is_record(&self, fields: &[String]) -> bool {
        is_row(fields)
            && (self.are_counts || !counts_columns(fields))
            && (self.have_words || !begins_with_word(fields))
    }

    fn record_below(&self, at: usize) -> Option<usize> {
        let mut below = at + 1..self.lines.len().min(at + BETWEEN);
        below.find(|i| self.is_record(&self.lines[*i].1))
    }

    /// The mark of a comment that the line begins with.
    fn mark(&self, line: &Line) -> Option<&'static str> {
        let text = line.text.trim_ascii_start();
        let mut marks = MARKS
            .into_iter()
            .filter(|mark| mark.as_bytes() != [self.separator]);
        marks.find(|mark| text.starts_with(mark.as_bytes()))
    }

    /// Names of a line, without the mark of a comment and empty ones at the end.
    fn headings(&self, at: usize) -> Vec<Heading> {
        let mut line = self.lines[at].0.clone();
        if let Some(mark) = self.mark(&line) {
            line.text = line.text.trim_ascii_start()[mark.len()..].to_vec();
        }
        let names = line.fields(self.separator);
        names[..filled(&names)]
            .iter()
            .map(|name| Heading::new(name))
            .collect()
    }

    /// Number of quantities that a line names.
    fn named(&self, at: usize) -> usize {
        let headings = self.headings(at);
        let is_named = |one: &&Quantity| headings.iter().any(|name| name.means(**one, name.said()));
        Quantity::ALL.iter().filter(is_named).count()
    }

    /// The line that names most quantities, and the first record below. Of several that name as much, the last above that.
    fn header(&self) -> Option<(usize, usize)> {
        let may_be = |at: &usize| {
            let (line, fields) = &self.lines[*at];
            !is_row(fields) && !line.is_blank()
        };
        let lines = (0..self.lines.len()).filter(may_be);
        let lines = lines.filter_map(|at| Some((self.named(at), at, self.record_below(at)?)));
        let lines: Vec<_> = lines.filter(|(named, ..)| *named > 0).collect();
        let most = lines.iter().map(|(named, ..)| *named).max()?;
        let mut best = lines.iter().filter(|(named, ..)| *named == most);
        let &(_, first, record) = best.next()?;
        let last = best.take_while(|(_, at, _)| *at < record).last();
        Some((last.map_or(first, |(_, at, _)| *at), record))
    }

    /// The first record, of which many have as many fields, and the line of words above it, if there is one.
    fn unnamed(&self) -> Option<(Option<usize>, usize)> {
        let records = || {
            self.lines
                .iter()
                .filter(|(_, fields)| self.is_record(fields))
        };
        let width = records().next_back()?.1.len();
        let is_first =
            |(_, fields): &(Line, Vec<String>)| self.is_record(fields) && fields.len() == width;
        let record = self.lines.iter().position(is_first)?;
        let above = (0..record).rev().find(|i| !self.lines[*i].0.is_blank());
        let header = above.filter(|at| {
            let fields = &self.lines[*at].1;
            let words = fields
                .iter()
                .filter(|field| !field.is_empty() && !is_value(field));
            fields.len() == width && 2 * words.count() > width
        });
        Some((header, record))
    }
}

impl Sheet {
    /// Finds the table among the first lines and the last lines of a file.
    pub fn new(head: Vec<Line>, tail: Vec<Line>) -> Option<Self> {
        let head = joined(head);
        let length = head.len();
        let all = [head, tail].concat();
        // The separator that shows most numbers; blanks only where nothing else separates.
        let splits = SEPARATORS
            .iter()
            .rev()
            .map(|one| (one, Split::new(&all, one.1)));
        let (separator, split) = splits.max_by_key(|(_, split)| split.values())?;
        let header = split
            .header()
            .map(|(header, record)| (Some(header), record));
        let (mut header, record) = header.or_else(|| split.unnamed())?;
        if record >= length {
            return None;
        }
        let below = &split.lines[record..];
        let records = below.iter().filter(|(_, fields)| split.is_record(fields));
        let rows: Vec<Vec<String>> = records.map(|(_, fields)| fields.clone()).collect();
        let mut headings = header.map_or(Vec::new(), |at| split.headings(at));
        let width = headings.len();
        // Blanks stand in names, too.
        let is_shifted = header.is_some()
            && match split.separator {
                b' ' => rows.iter().any(|row| filled(row) != width),
                _ => rows.iter().all(|row| filled(row) > width),
            };
        if is_shifted {
            header = None;
        }
        if header.is_none() {
            let width = rows.iter().map(|row| filled(row)).max()?;
            headings = vec![Heading::new(""); width];
        }
        let of_header = header.and_then(|at| split.mark(&split.lines[at].0));
        let others = below.iter().filter(|(_, fields)| !is_row(fields));
        let comment = of_header.or_else(|| others.filter_map(|(line, _)| split.mark(line)).next());
        Some(Self {
            separator: *separator,
            above: split.lines[..record]
                .iter()
                .map(|(line, _)| line.clone())
                .collect(),
            header,
            first_row: split.lines[record].0.number,
            short_rows: short_rows(&headings, &rows),
            headings,
            rows,
            comment,
            is_shifted,
        })
    }

    /// Non-empty fields of a column.
    pub fn column(&self, number: usize) -> impl Iterator<Item = &str> {
        let fields = self.rows.iter().filter_map(move |row| row.get(number));
        fields.map(String::as_str).filter(|field| !field.is_empty())
    }

    /// Lines above the rows, but for the header.
    pub fn preamble(&self) -> impl Iterator<Item = &Line> {
        let lines = self.above.iter().enumerate();
        lines
            .filter(|(at, _)| Some(*at) != self.header)
            .map(|(_, line)| line)
    }
}

/// Whether rows lack as many fields each, if they lack some; a comment is surely the last.
fn short_rows(headings: &[Heading], rows: &[Vec<String>]) -> Option<bool> {
    let (count, width) = (rows.iter().map(Vec::len).min()?, headings.len());
    let is_alike = rows
        .iter()
        .all(|row| row.len() == count || row.len() >= width);
    (count < width && is_alike).then(|| {
        let is_comment = ["comment", "kommentar"].contains(&headings[count].stem.as_str());
        count + 1 == width && is_comment
    })
}

/// Lines of which one that has an open quotation mark goes on below, up to where it is closed.
fn joined(lines: Vec<Line>) -> Vec<Line> {
    let mut all: Vec<Line> = Vec::new();
    let mut rest = &lines[..];
    while let [first, below @ ..] = rest {
        let mut line = first.clone();
        let mut used = 0;
        while line.is_open() && used < BETWEEN.min(below.len()) {
            line.text.extend(&below[used].text);
            used += 1;
        }
        let is_closed = !line.is_open();
        all.push(if is_closed { line } else { first.clone() });
        rest = &below[if is_closed { used } else { 0 }..];
    }
    all
}

/// Number of fields up to the last that has something.
fn filled(fields: &[String]) -> usize {
    let last = fields.iter().rposition(|field| !field.is_empty());
    last.map_or(0, |last| last + 1)
}

/// A number with any decimals, also one that a unit of time stands behind, or a clock time.
pub fn is_value(field: &str) -> bool {
    let is_number = |field: &str| number(field, b'.').is_some() || number(field, b',').is_some();
    let behind = |(before, unit): (&str, &str)| {
        is_number(before) && Unit::named(unit).is_some_and(|unit| unit.dimension == Dimension::Time)
    };
    let has_unit = || field.split_once(' ').is_some_and(behind);
    is_number(field) || has_thousands(field) || has_unit() || is_clock(field)
}

/// Whether the mark of a number may be one of thousands: one to three digits before it, three behind.
pub fn has_thousands(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-', '\u{2212}', ' ']);
    let mut parts = digits.split([',', '.']);
    let are_digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    let before = parts.next().unwrap_or_default();
    let is_short = (1..=3).contains(&before.len()) && before != "0" && are_digits(before);
    is_short && parts.all(|part| part.len() == 3 && are_digits(part))
}

/// A row: two numbers or more, at least half of its fields; or a number alone.
fn is_row(fields: &[String]) -> bool {
    let filled = fields.iter().filter(|field| !field.is_empty()).count();
    let values = fields.iter().filter(|field| is_value(field)).count();
    values > 0 && 2 * values >= filled && (values > 1 || values == filled)
}

fn begins_with_word(fields: &[String]) -> bool {
    let first = fields.first().filter(|first| !first.is_empty());
    first.is_some_and(|first| !is_value(first))
}

/// Numbers of channels, and nothing else but a label: 0, 1, 2 or 1, 2, 3 and so on.
fn counts_columns(fields: &[String]) -> bool {
    let filled = fields.iter().filter(|field| !field.is_empty()).count();
    let numbers = fields.iter().filter_map(|field| field.parse().ok());
    let numbers: Vec<usize> = numbers.collect();
    let first = numbers.first().copied().unwrap_or(9);
    numbers.len() > 2
        && numbers.len() + 1 >= filled
        && first < 2
        && numbers.iter().enumerate().all(|(i, one)| *one == first + i)
}
