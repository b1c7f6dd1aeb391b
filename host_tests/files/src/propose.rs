//! Proposals of descriptions: the one module that guesses.
//!
//! A proposal may be wrong without harm: somebody looks at it before anything is solved. Where the file leaves something
//! open, or says two things, the proposal has a `"?"`.

use crate::fault::LoadsError;
use crate::import::{Import, OPEN, Wanted};
use crate::lines::{Line, Lines, SEPARATORS, number, shown, text};
use crate::quantities::{OWN, QUANTITIES, Quantity};
use crate::recordings::{LoadRow, Loads, is_clock, open};
use crate::units::{Dimension, Unit};
use std::collections::VecDeque;
use std::fmt::Write;
use std::io::{Cursor, Read};
use std::path::Path;

/// Lines that are looked at: a preamble of 200, and rows below it.
const HEAD: usize = 400;

/// Last lines that are looked at.
const TAIL: usize = 40;

/// Lines between a header and its first row: units, types, channels.
const BETWEEN: usize = 15;

/// A proposal.
#[derive(Debug)]
pub struct Proposal {
    /// The description, as text.
    pub description: String,
    /// First and last rows as they would be read, and what is open.
    pub report: String,
}

/// Looks at a file, `-` being standard input, and proposes how to read it.
///
/// # Errors
///
/// A file that cannot be opened, or has no row of numbers.
pub fn propose(path: impl AsRef<Path>) -> Result<Proposal, LoadsError> {
    let (file, input, _) = open(path.as_ref())?;
    of_input(&file, input)
}

/// Proposes how to read an input that messages call `file`.
///
/// # Errors
///
/// An input that fails, or has no row of numbers.
pub fn of_input(file: &str, input: Box<dyn Read + Send>) -> Result<Proposal, LoadsError> {
    let mut lines = Lines::new(file, input);
    let (mut head, mut tail, mut line) = (Vec::new(), VecDeque::new(), Line::default());
    while lines.next(&mut line)? {
        if head.len() < HEAD {
            head.push(line.clone());
            continue;
        }
        if tail.len() == TAIL {
            tail.pop_front();
        }
        tail.push_back(line.clone());
    }
    if head.is_empty() {
        return Err(lines.malformed(1, "the file is empty"));
    }
    let seen: Vec<u8> = head
        .iter()
        .chain(&tail)
        .flat_map(|line| line.text.clone())
        .collect();
    let sheet = Sheet::new(joined(head), tail.into());
    let Some(sheet) = sheet else {
        let is_mac = seen.iter().filter(|byte| **byte == b'\r').count() > 2
            && !seen[..seen.len() - 1].contains(&b'\n');
        let message = match is_mac {
            true => "lines end with CR alone; end them with LF or CR LF".to_owned(),
            false => format!("there is no row of numbers in {HEAD} lines"),
        };
        return Err(lines.malformed(1, message));
    };
    let guesses = sheet.guesses();
    let description = sheet.description(file, &guesses, false);
    let report = sheet.report(file, &guesses, seen);
    Ok(Proposal {
        description,
        report,
    })
}

/// Lines of which one that has an open quotation mark goes on below.
fn joined(lines: Vec<Line>) -> Vec<Line> {
    let mut all: Vec<Line> = Vec::new();
    let mut lines = lines.into_iter().peekable();
    while let Some(mut line) = lines.next() {
        let mut more = 0;
        while line.is_open() && more < BETWEEN && lines.peek().is_some() {
            line.text
                .extend(lines.next().into_iter().flat_map(|next| next.text));
            more += 1;
        }
        all.push(line);
    }
    all
}

/// A number with any decimals, also one that a unit stands behind, or a clock time.
fn is_value(field: &str) -> bool {
    let is_number = |field: &str| number(field, b'.').is_some() || number(field, b',').is_some();
    let behind = |(before, unit): (&str, &str)| {
        is_number(before) && Unit::named(unit).is_some_and(|unit| unit.dimension == Dimension::Time)
    };
    is_number(field)
        || has_thousands(field)
        || field.split_once(' ').is_some_and(behind)
        || is_clock(field)
}

/// A row: two numbers or more, at least half of its fields; or a number alone.
fn is_row(fields: &[String]) -> bool {
    let filled = fields.iter().filter(|field| !field.is_empty()).count();
    let values = fields.iter().filter(|field| is_value(field)).count();
    values > 0 && 2 * values >= filled && (values > 1 || values == filled)
}

/// Numbers of channels: 0, 1, 2 or 1, 2, 3 and so on.
fn counts_columns(fields: &[String]) -> bool {
    let numbers: Vec<usize> = fields
        .iter()
        .filter_map(|field| field.parse().ok())
        .collect();
    let first = numbers.first().copied().unwrap_or(9);
    numbers.len() > 2 && first < 2 && numbers.iter().enumerate().all(|(i, one)| *one == first + i)
}

/// Names without unit, marks and blanks, `?` being an axis or a side; and one that needs a unit to be understood.
const fn names(dimension: Dimension) -> (&'static str, &'static str) {
    match dimension {
        Dimension::Time => (
            "time abstime abstimes reltime relativetime elapsedtime timestamp datetime xvalue tstamp zeit messzeit zeitstempel \
             temps tempo tiempo hora čas",
            "t",
        ),
        Dimension::Force => (
            "f? force? ?force forcef? kraft? kraftf? fuerza? forza? effort? síla? sila?",
            "",
        ),
        Dimension::Moment => (
            "m? moment? ?moment momentm? torque? ?torque drehmoment? momento? coppia?",
            "t?",
        ),
        Dimension::Speed => (
            "speed rpm spindlespeed shaftspeed rotationalspeed drehzahl spindeldrehzahl vitesse velocidad velocità giri otáčky",
            "n",
        ),
        Dimension::Temperature => ("t? temp? temperature? temperatur?", ""),
    }
}

/// A column's name, split into quantity and unit.
#[derive(Debug, Clone)]
struct Heading {
    text: String,
    stem: String,
    words: Vec<String>,
    /// The unit as the name has it, if it has one.
    unit: Option<String>,
}

impl Heading {
    /// `Fx [N]`, `Force X (kN)`, `t / s`, `Zeit in s`, `n 1/min`, `fx_n`.
    fn new(text: &str) -> Self {
        let line = text.replace(['\n', '\r'], " ");
        let mut brackets = [('[', ']'), ('(', ')'), ('{', '}')].into_iter();
        let brackets = brackets.find_map(|(open, close)| {
            let (before, rest) = line.split_once(open)?;
            let (unit, after) = rest.split_once(close)?;
            Some((format!("{before}{after}"), unit))
        });
        let split = brackets.or_else(|| {
            if let Some((stem, unit)) = line.rsplit_once(" in ") {
                return Some((stem.to_owned(), unit));
            }
            // The longest unit at the end.
            let marks = line.match_indices([' ', '/', ',', '_']);
            let mut parts = marks.map(|(at, mark)| (&line[..at], &line[at + mark.len()..]));
            let (stem, unit) =
                parts.find(|(stem, unit)| !stem.is_empty() && Unit::named(unit).is_some())?;
            Some((stem.to_owned(), unit))
        });
        let (stem, unit) = split.unwrap_or((line.clone(), ""));
        let stem = stem.to_lowercase();
        let words = stem.split(|c: char| !c.is_alphanumeric());
        let words: Vec<String> = words.map(str::to_owned).collect();
        let unit = unit.trim();
        let is_speed = stem == "rpm" && unit.is_empty();
        Self {
            text: text.to_owned(),
            stem: words.concat(),
            words,
            unit: match is_speed {
                true => Some("rpm".to_owned()),
                false => (!unit.is_empty()).then(|| unit.to_owned()),
            },
        }
    }

    /// The unit that the name says.
    fn said(&self) -> Option<Unit> {
        self.unit.as_deref().and_then(Unit::named)
    }

    /// Whether it names a quantity, `unit` being the one that is said of it.
    fn means(&self, quantity: Quantity, unit: Option<Unit>) -> bool {
        let dimension = quantity.dimension();
        if unit.is_some_and(|unit| unit.dimension != dimension) {
            return false;
        }
        let axis = match dimension {
            Dimension::Force | Dimension::Moment => &quantity.name()[1..],
            Dimension::Temperature => &quantity.name()[2..],
            _ => "",
        };
        let (always, by_unit) = names(dimension);
        let by_unit = if unit.is_some() { by_unit } else { "" };
        let is_name = |stem: &str| {
            let names = always.split(' ').chain(by_unit.split(' '));
            let mut names = names.filter(|name| !name.is_empty());
            names.any(|name| match name.split_once('?') {
                None => name == stem,
                Some((before, after)) => {
                    let middle = stem.strip_prefix(before);
                    middle.and_then(|rest| rest.strip_suffix(after)) == Some(axis)
                }
            })
        };
        // A word of the name is enough for an axis, and where the unit fits.
        let has_axis = matches!(dimension, Dimension::Force | Dimension::Moment);
        let mut words = self.words.iter();
        is_name(&self.stem) || (has_axis || unit.is_some()) && words.any(|word| is_name(word))
    }
}

/// A table in a file.
struct Sheet {
    separator: u8,
    separator_name: &'static str,
    /// Lines above the first row.
    above: Vec<Line>,
    /// Number in these of the header.
    header: Option<usize>,
    first_row: u64,
    headings: Vec<Heading>,
    /// Fields of the rows that are looked at.
    rows: Vec<Vec<String>>,
    comment: Option<&'static str>,
    short_rows: Option<bool>,
    /// Rows have more fields than the header has names.
    is_shifted: bool,
}

/// What is proposed of a quantity.
#[derive(Debug, Clone)]
enum Guess {
    Absent,
    /// Nobody knows, and why.
    Open(String),
    Rate(f64),
    /// A column from 0, its unit, and why that is open.
    Column(usize, Option<String>, String),
}

impl Sheet {
    fn new(head: Vec<Line>, tail: Vec<Line>) -> Option<Self> {
        let all = || head.iter().chain(&tail);
        // The separator that shows most numbers; blanks only where nothing else separates.
        let shows = |separator: u8| {
            let rows = all()
                .map(|line| line.fields(separator))
                .filter(|fields| is_row(fields));
            let values = rows.map(|fields| fields.iter().filter(|field| is_value(field)).count());
            values.sum::<usize>()
        };
        let best = SEPARATORS
            .iter()
            .rev()
            .max_by_key(|(_, byte)| shows(*byte))?;
        let (separator_name, separator) = *best;
        let fields: Vec<Vec<String>> = head.iter().map(|line| line.fields(separator)).collect();
        let rows = || {
            all()
                .map(|line| line.fields(separator))
                .filter(|fields| is_row(fields))
        };
        let last = rows().next_back()?;
        let are_counts = rows().all(|fields| counts_columns(&fields));
        // Words before numbers are labels of units and types, unless all rows have them.
        let first_of = |fields: &[String]| fields.first().cloned().unwrap_or_default();
        let of_last = first_of(&last);
        let has_words = !of_last.is_empty() && !is_value(&of_last);
        let is_first = |fields: &Vec<String>| {
            let first = first_of(fields);
            let is_label = !first.is_empty() && !is_value(&first);
            is_row(fields) && (are_counts || !counts_columns(fields)) && (has_words || !is_label)
        };
        let is_comment = |line: &Line| {
            let text = line.text.trim_ascii_start();
            let marks = ["#", "%", "//", ";", "'"].into_iter();
            let mut marks = marks.filter(|mark| separator != b';' || *mark != ";");
            marks.find(|mark| text.starts_with(mark.as_bytes()))
        };
        let headings = |at: usize| -> Vec<Heading> {
            let mut line = head[at].clone();
            if let Some(mark) = is_comment(&line) {
                let text = String::from_utf8_lossy(&line.text).into_owned();
                if !text.trim_start().starts_with('\'') {
                    line.text = line.text.trim_ascii_start()[mark.len()..].to_vec();
                }
            }
            let mut names = line.fields(separator);
            while names.last().is_some_and(String::is_empty) {
                names.pop();
            }
            names.iter().map(|name| Heading::new(name)).collect()
        };
        // Quantities that a line names.
        let named = |at: usize| {
            let headings = headings(at);
            let is_named = |one: &Quantity| {
                let mut all = headings.iter();
                all.any(|heading| heading.means(*one, heading.said()))
            };
            Quantity::ALL.iter().filter(|one| is_named(one)).count()
        };
        let row_below =
            |at: usize| (at + 1..(at + BETWEEN).min(head.len())).find(|i| is_first(&fields[*i]));
        let may_be_header =
            |at: &usize| !is_row(&fields[*at]) && !head[*at].is_blank() && row_below(*at).is_some();
        let counts: Vec<(usize, usize)> = (0..head.len())
            .filter(may_be_header)
            .map(|at| (at, named(at)))
            .collect();
        let most = counts.iter().map(|(_, count)| *count).max().unwrap_or(0);
        let first = counts.iter().find(|(_, count)| *count == most && most > 0);
        // Of several that name as much, the last above the first row.
        let header = first.and_then(|(at, _)| {
            let row = row_below(*at)?;
            let above = counts
                .iter()
                .filter(|(at, count)| *at < row && *count == most);
            above.last().map(|(at, _)| *at)
        });
        let first_row = match header {
            Some(at) => row_below(at)?,
            // The first of most rows of one length.
            None => {
                let is_like = |fields: &Vec<String>| is_first(fields) && fields.len() == last.len();
                (0..head.len()).find(|i| is_like(&fields[*i]))?
            }
        };
        let is_word = |field: &String| !field.is_empty() && !is_value(field);
        let unnamed = || {
            let above = (0..first_row).rev().find(|i| !head[*i].is_blank())?;
            let fields = &fields[above];
            let words = fields.iter().filter(|field| is_word(field)).count();
            (fields.len() == last.len() && 2 * words > fields.len()).then_some(above)
        };
        let mut header = header.or_else(unnamed);
        let below = head[first_row..].iter().chain(&tail);
        let rows: Vec<Vec<String>> = below
            .clone()
            .map(|line| line.fields(separator))
            .filter(is_first)
            .collect();
        let mut names = header.map_or(Vec::new(), headings);
        let filled = |row: &Vec<String>| {
            row.iter()
                .rposition(|field| !field.is_empty())
                .map_or(0, |last| last + 1)
        };
        // Blanks stand in names, too.
        let is_shifted = header.is_some()
            && match separator {
                b' ' => rows.iter().any(|row| filled(row) != names.len()),
                _ => rows.iter().all(|row| filled(row) > names.len()),
            };
        if is_shifted {
            header = None;
        }
        if header.is_none() {
            let width = rows.iter().map(filled).max().unwrap_or(0);
            names = (0..width).map(|_| Heading::new("")).collect();
        }
        // Rows that are short lack as many fields each; only a comment is surely the last.
        let (count, width) = (rows.iter().map(Vec::len).min().unwrap_or(0), names.len());
        let is_alike = rows
            .iter()
            .all(|row| row.len() == count || row.len() >= width);
        let short_rows = (count < width && is_alike).then(|| {
            let is_comment = ["comment", "kommentar"].contains(&names[count].stem.as_str());
            count + 1 == width && is_comment
        });
        let of_header = header.and_then(|at| is_comment(&head[at]));
        let comment = of_header.or_else(|| {
            let mut rest = below.filter(|line| !is_row(&line.fields(separator)));
            rest.find_map(is_comment)
        });
        let number = head[first_row].number;
        let mut above = head;
        above.truncate(first_row);
        Some(Self {
            separator,
            separator_name,
            above,
            header,
            first_row: number,
            headings: names,
            rows,
            comment,
            short_rows,
            is_shifted,
        })
    }

    /// Non-empty fields of a column.
    fn column(&self, number: usize) -> impl Iterator<Item = &str> {
        let fields = self.rows.iter().filter_map(move |row| row.get(number));
        fields.map(String::as_str).filter(|field| !field.is_empty())
    }

    /// The units that a line of units says, by column: the line above the rows that fits most quantities by their names.
    fn line_of_units(&self) -> Vec<String> {
        let fits = |fields: &Vec<String>| {
            let both = fields.iter().zip(&self.headings);
            let is_unit = |(field, heading): &(&String, &Heading)| {
                let unit = Unit::named(field);
                unit.is_some() && Quantity::ALL.iter().any(|one| heading.means(*one, unit))
            };
            both.filter(is_unit).count()
        };
        let lines = self.above.iter().enumerate();
        let lines = lines.filter(|(at, _)| Some(*at) != self.header);
        let lines = lines.map(|(_, line)| line.fields(self.separator));
        // LabVIEW and Yokogawa say which line it is.
        let is_told = |fields: &Vec<String>| {
            let first = fields
                .first()
                .map_or(String::new(), |field| field.to_lowercase());
            ["y_unit_label", "vunit"].contains(&first.as_str())
        };
        let best = lines.max_by_key(|fields| (fits(fields), is_told(fields)));
        let best = best.filter(|fields| fits(fields) > 1 || is_told(fields));
        best.unwrap_or_default()
    }

    /// The unit of a dimension that the preamble says, and the counts of it, as ATI's sensors write them: `Force Units: N,
    /// Counts per Unit Force: 1000000`.
    fn said_above(&self, dimension: Dimension) -> Option<(Unit, Option<f64>)> {
        let name = match dimension {
            Dimension::Force => "force",
            Dimension::Moment => "torque",
            _ => return None,
        };
        let (mut unit, mut counts) = (None, None);
        for line in &self.above {
            let line = String::from_utf8_lossy(&line.text).to_lowercase();
            let behind = |phrase: &str| {
                let (_, value) = line.split_once(phrase)?;
                let value = value.trim_start_matches(['s', '"', ':', '=', ',', ';', '\t', ' ']);
                let end = value.find([',', ';', '\t', '"', '\r', '\n']);
                Some(value[..end.unwrap_or(value.len())].trim().to_owned())
            };
            let found = behind(&format!("{name} unit")).and_then(|unit| Unit::named(&unit));
            unit = found.filter(|unit| unit.dimension == dimension).or(unit);
            let per = behind(&format!("counts per unit {name}"))
                .or_else(|| behind(&format!("counts per {name}")));
            counts = per.and_then(|per| per.parse().ok()).or(counts);
        }
        unit.map(|unit| (unit, counts))
    }

    /// The unit of a column, or why it is open.
    fn unit(
        &self,
        number: usize,
        quantity: Quantity,
        below: Option<&String>,
    ) -> (Option<String>, String) {
        let dimension = quantity.dimension();
        let named = |name: &str| Unit::named(name).filter(|unit| unit.dimension == dimension);
        let known = |unit: Unit| (Some(unit.name().to_owned()), String::new());
        let heading = &self.headings[number];
        let (name, line) = (heading.unit.as_deref(), below.map(String::as_str));
        let is_said = |unit: &&str| {
            let is_label = ["unit", "einheit"]
                .iter()
                .any(|word| unit.to_lowercase().contains(word));
            !unit.is_empty() && !["-", "1"].contains(unit) && !is_label
        };
        let line = line.filter(is_said);
        match (name, line) {
            (Some(name), Some(line)) => match (named(name), named(line)) {
                (Some(one), Some(other)) if one == other => return known(one),
                _ => return (None, format!("its name says {name:?}, a line {line:?}")),
            },
            (Some(unit), None) | (None, Some(unit)) => {
                return match named(unit) {
                    Some(unit) => known(unit),
                    None => (None, format!("the file says {unit:?}")),
                };
            }
            (None, None) => {}
        }
        if quantity == Quantity::Time {
            let behind = self
                .column(number)
                .next()
                .and_then(|field| field.split_once(' '));
            if let Some(unit) = behind.and_then(|(_, unit)| named(unit)) {
                return known(unit);
            }
            let is_labview = self
                .above
                .first()
                .is_some_and(|line| line.text.starts_with(b"LabVIEW Measurement"));
            if is_labview && heading.stem == "xvalue" {
                return known(Unit::of(dimension));
            }
        }
        let Some((unit, counts)) = self.said_above(dimension) else {
            return (None, "the file says no unit".to_owned());
        };
        // Counts are whole: one number with decimals, and all columns of the dimension are in the unit.
        let alike = (0..self.headings.len()).filter(|i| {
            let mut all = Quantity::ALL
                .iter()
                .filter(|one| one.dimension() == dimension);
            all.any(|one| self.headings[*i].means(*one, Some(unit)))
        });
        let mut fields = alike.flat_map(|i| self.column(i));
        match counts {
            Some(counts) if !fields.any(|field| field.contains(['.', ','])) => {
                let unit = unit.name();
                (
                    None,
                    format!(
                        "{unit}, or counts of which {counts} are 1 {unit}: factor = 1 / {counts}"
                    ),
                )
            }
            _ => known(unit),
        }
    }

    /// Where each quantity may be.
    fn guesses(&self) -> [Guess; QUANTITIES] {
        let units = self.line_of_units();
        Quantity::ALL.map(|quantity| {
            let means = |i: &usize| {
                let heading = &self.headings[*i];
                let said = heading.unit.as_ref().or(units.get(*i));
                let said = said.and_then(|unit| Unit::named(unit));
                let above = || self.said_above(quantity.dimension()).map(|(unit, _)| unit);
                heading.means(quantity, said.or_else(above))
            };
            let columns: Vec<usize> = (0..self.headings.len()).filter(means).collect();
            let is_needed = OWN[..7].contains(&quantity);
            match columns[..] {
                _ if self.is_shifted && is_needed => Guess::Open(
                    "rows have more fields than the header has names: count the columns from 1"
                        .to_owned(),
                ),
                [] if quantity == Quantity::Time => self.rate(),
                [] if is_needed => Guess::Open(
                    "in no column; { value = 0, unit = ... } if there is none".to_owned(),
                ),
                [] => Guess::Absent,
                [one] => self.guess(one, quantity, units.get(one)),
                ref several => {
                    let all = several
                        .iter()
                        .map(|i| format!("{} {}", i + 1, shown(&self.headings[*i].text)));
                    Guess::Open(format!(
                        "one of the columns {}",
                        all.collect::<Vec<_>>().join(", ")
                    ))
                }
            }
        })
    }

    fn guess(&self, number: usize, quantity: Quantity, below: Option<&String>) -> Guess {
        let fields: Vec<&str> = self.column(number).collect();
        let values = fields.iter().filter(|field| is_value(field)).count();
        let first = fields.first().copied().unwrap_or("nothing");
        if !is_value(first) && 2 * values <= fields.len() {
            return Guess::Open(format!("column {} has {}", number + 1, shown(first)));
        }
        let is_time = quantity == Quantity::Time;
        if is_time && 2 * fields.iter().filter(|field| is_clock(field)).count() > fields.len() {
            let is_part = |heading: &Heading| {
                ["ms", "msec", "us", "date", "datum", "data", "fecha"]
                    .contains(&heading.stem.as_str())
            };
            if self.headings.iter().any(is_part) && !fields[0].contains('-') {
                let part = "other columns may have a part of it".to_owned();
                return Guess::Column(number, None, part);
            }
            return Guess::Column(number, Some("clock".to_owned()), String::new());
        }
        let (unit, why) = self.unit(number, quantity, below);
        Guess::Column(number, unit, why)
    }

    /// The sampling rate that the preamble says, in the place of times.
    fn rate(&self) -> Guess {
        let rates = self.above.iter().filter_map(|line| {
            let text = String::from_utf8_lossy(&line.text).to_lowercase();
            let is_rate =
                ["sampl", "abtast"].iter().any(|word| text.contains(word)) && text.contains("hz");
            let numbers = text
                .split([':', ';', ',', '\t', ' ', '='])
                .filter_map(|word| word.trim().parse().ok());
            let numbers: Vec<f64> = numbers.filter(|rate: &f64| *rate > 0.0).collect();
            let is_scaled = text.contains("khz") || text.contains("mhz");
            (is_rate && !is_scaled && numbers.len() == 1).then(|| numbers[0])
        });
        match rates.collect::<Vec<_>>()[..] {
            [rate] => Guess::Rate(rate),
            _ => Guess::Open(
                "in no column; { rate_hz = 1000 }, or leave it out: rows are counted".to_owned(),
            ),
        }
    }

    /// Words above the rows that say how axes lie, unless that x is along the shaft.
    fn words_of_axes(&self, guesses: &[Guess]) -> Option<String> {
        let forces =
            [Quantity::Fx, Quantity::Fy, Quantity::Fz].map(|force| &guesses[force as usize]);
        if !forces
            .iter()
            .any(|force| matches!(force, Guess::Column(..)))
        {
            return None;
        }
        const WORDS: [&str; 8] = [
            "axial",
            "thrust",
            "-hand",
            "handed",
            "händig",
            "coordinate",
            "koordinate",
            "spindle axis",
        ];
        let says = |text: &str| WORDS.iter().any(|word| text.to_lowercase().contains(word));
        let is_other =
            |heading: &&Heading| says(&heading.text) && !heading.means(Quantity::Fx, None);
        let in_names = self
            .headings
            .iter()
            .find(is_other)
            .map(|heading| shown(&heading.text));
        in_names.or_else(|| {
            let above = self.above.iter().enumerate();
            let mut above = above.filter(|(at, _)| Some(*at) != self.header);
            let line = above.find(|(_, line)| says(&text(&line.text)))?.1;
            Some(format!(
                "in line {} {}",
                line.number,
                shown(text(&line.text).trim())
            ))
        })
    }

    /// The mark before decimals, or that it is open.
    fn decimal(&self, guesses: &[Guess]) -> &'static str {
        let read = guesses.iter().filter_map(|guess| match guess {
            Guess::Column(number, unit, _) if unit.as_deref() != Some("clock") => Some(*number),
            _ => None,
        });
        let mut read: Vec<usize> = read.collect();
        if read.is_empty() {
            read = (0..self.headings.len()).collect();
        }
        let fields = read
            .iter()
            .flat_map(|number| self.column(*number))
            .filter(|field| is_value(field));
        // Of each mark: whether there is one that is no mark of thousands, or there is one at all.
        let (mut decimals, mut marks) = ([false; 2], [false; 2]);
        for field in fields.filter(|field| !is_clock(field)) {
            let last = field
                .rfind([',', '.'])
                .map(|at| usize::from(field[at..].starts_with(',')));
            for (i, mark) in ['.', ','].into_iter().enumerate() {
                marks[i] |= field.contains(mark);
                let is_last = last == Some(i);
                decimals[i] |= is_last
                    && (field.contains(if i == 0 { ',' } else { '.' }) || !has_thousands(field));
            }
        }
        match (decimals, marks) {
            ([true, true], _) => OPEN,
            ([true, false], _) | (_, [false, false]) => ".",
            ([false, true], _) => ",",
            // Points between commas are decimals.
            (_, [true, false]) if self.separator == b',' => ".",
            _ => OPEN,
        }
    }

    /// The description; with `assumed` units in the place of open ones, and without open quantities.
    fn description(&self, file: &str, guesses: &[Guess], assumed: bool) -> String {
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let mut text = format!("# {}", file.replace(['\n', '\r'], " "));
        if !assumed {
            text += ". Look at each line, and write for each \"?\" what the recording has.";
        }
        text.push('\n');
        let mut add = |line: String| {
            text += &line;
            text.push('\n');
        };
        if let Some(header) = self.header {
            add(format!("header_line = {}", self.above[header].number));
        }
        add(format!("first_row = {}", self.first_row));
        add(format!("separator = \"{}\"", self.separator_name));
        let decimal = match self.decimal(guesses) {
            OPEN if assumed => ".",
            OPEN => {
                "?\"   # \".\" or \",\": three digits stand behind each: decimals, or thousands"
            }
            known => known,
        };
        add(match decimal.contains('#') {
            true => format!("decimal = \"{decimal}"),
            false => format!("decimal = \"{decimal}\""),
        });
        if let Some(comment) = self.comment {
            add(format!("comment = {}", quoted(comment)));
        }
        match self.short_rows {
            Some(true) => add("short_rows = true".to_owned()),
            Some(false) if !assumed => {
                add("short_rows = \"?\"   # true if rows lack the last names; the rows are refused otherwise".to_owned());
            }
            _ => {}
        }
        if let Some(words) = self.words_of_axes(guesses).filter(|_| !assumed) {
            add(format!(
                "axes = \"?\"   # {{ x = \"Fx\", y = \"Fy\", z = \"Fz\" }} if x is along the shaft; the file says {words}"
            ));
        } else if !assumed {
            add("# If the recording's x is not along the shaft: axes = { x = \"Fz\", y = \"Fx\", z = \"Fy\" }".to_owned());
        }
        add("\n[columns]".to_owned());
        for (quantity, guess) in Quantity::ALL.into_iter().zip(guesses) {
            let name = quantity.name();
            match guess {
                Guess::Absent => {}
                Guess::Open(_) if assumed => {}
                Guess::Open(why) => add(format!("{name} = \"?\"   # {why}")),
                Guess::Rate(rate) => add(format!("{name} = {{ rate_hz = {rate} }}")),
                Guess::Column(number, unit, why) => {
                    let column = &self.headings[*number].text;
                    let same = self
                        .headings
                        .iter()
                        .filter(|one| one.text == *column)
                        .count();
                    let column = match self.header {
                        Some(_) if same == 1 && !column.is_empty() => quoted(column),
                        _ => (number + 1).to_string(),
                    };
                    let is_open = unit.is_none() && !assumed;
                    let clock = self.column(*number).next().is_some_and(is_clock);
                    let unit = match unit {
                        Some(unit) => unit,
                        None if !assumed => OPEN,
                        None if clock => "clock",
                        None => Unit::of(quantity.dimension()).name(),
                    };
                    let why = if is_open {
                        format!("   # {}", why.replace(['\n', '\r'], " "))
                    } else {
                        String::new()
                    };
                    add(format!(
                        "{name} = {{ column = {column}, unit = \"{unit}\" }}{why}"
                    ));
                }
            }
        }
        text
    }

    /// First and last rows as they would be read, with units, and the number of open points.
    fn report(&self, file: &str, guesses: &[Guess], seen: Vec<u8>) -> String {
        let mut wanted = Wanted::default();
        let mut has = [false; OWN.len()];
        for (i, own) in OWN.into_iter().enumerate() {
            has[i] = matches!(guesses[own as usize], Guess::Column(..) | Guess::Rate(_));
        }
        wanted.needed = has;
        let description = self.description(file, guesses, true);
        let read = || -> Result<Vec<LoadRow>, String> {
            let import = Import::parse(file, &description).map_err(|error| error.to_string())?;
            let input = Box::new(Cursor::new(seen));
            let loads = Loads::from_reader(file, input, Some(&import), &wanted);
            let loads = loads.map_err(|error| error.to_string())?;
            Ok(loads.filter_map(Result::ok).collect())
        };
        let mut text = String::new();
        let shown: Vec<usize> = (0..OWN.len()).filter(|i| has[*i]).collect();
        let mut line = |of: &dyn Fn(usize) -> String| {
            for i in &shown {
                let _ = write!(text, "{:>14}", of(*i));
            }
            text.push('\n');
        };
        match read() {
            Err(fault) => text = format!("as proposed, no row can be read: {fault}\n"),
            Ok(rows) if rows.is_empty() || shown.is_empty() => {
                text = "as proposed, no row can be read\n".to_owned();
            }
            Ok(rows) => {
                line(&|i| OWN[i].name().to_owned());
                line(&|i| {
                    let unit = Unit::of(OWN[i].dimension()).name();
                    let guess = &guesses[OWN[i] as usize];
                    let mark = if matches!(guess, Guess::Column(_, None, _)) {
                        "?"
                    } else {
                        ""
                    };
                    format!("{unit}{mark}")
                });
                let last = rows.len().saturating_sub(2).max(3);
                let first = rows.iter().take(3);
                for row in first.chain(rows.iter().skip(last)) {
                    let [fx, fy, fz, my, mz] = row.load;
                    let [inner, outer] = row.temperatures.unwrap_or([f64::NAN; 2]);
                    let all = [row.time_s, fx, fy, fz, my, mz, row.speed_rpm, inner, outer];
                    line(&|i| format!("{}", format!("{:.6e}", all[i]).parse().unwrap_or(all[i])));
                }
            }
        }
        let proposal = self.description(file, guesses, false);
        let open = proposal
            .lines()
            .filter(|line| !line.starts_with('#') && line.contains("\"?\""));
        let open: Vec<&str> = open.collect();
        match open.len() {
            0 => text += "nothing is open; look at names, units and axes all the same\n",
            _ => {
                text += "open:\n";
                for line in open {
                    let _ = writeln!(text, "  {line}");
                }
            }
        }
        text
    }
}

/// Whether the mark of a number may be one of thousands: one to three digits before it, three behind.
fn has_thousands(text: &str) -> bool {
    let digits = text.trim_start_matches(['+', '-', '\u{2212}', ' ']);
    let mut parts = digits.split([',', '.']);
    let are_digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    let before = parts.next().is_some_and(|before| {
        (1..=3).contains(&before.len()) && before != "0" && are_digits(before)
    });
    before && parts.all(|part| part.len() == 3 && are_digits(part))
}
