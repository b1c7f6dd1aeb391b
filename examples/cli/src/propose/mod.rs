//! Proposals of descriptions: the one module that guesses.
//!
//! A proposal may be wrong without harm: somebody looks at it before anything is solved. Where the file leaves something
//! open, or says two things, the proposal has a `"?"`.

mod heading;
mod sheet;

use crate::fault::LoadsError;
use crate::import::{Import, OPEN, Wanted};
use crate::lines::{Line, Lines, shown, text};
use crate::quantities::{LOADS, OWN, Quantity};
use crate::recordings::{Loads, is_clock, open};
use crate::units::{Dimension, Unit};
use heading::Heading;
use sheet::{Sheet, has_thousands, is_value};
use spindle_file::loads::LoadRow;
use std::collections::VecDeque;
use std::io::{Cursor, Read};
use std::path::Path;

/// Lines that are looked at: a preamble of 200, and rows below it.
const HEAD: usize = 400;

/// Last lines that are looked at.
const TAIL: usize = 40;

/// Words that say how axes lie.
const AXES: [&str; 8] = [
    "axial",
    "thrust",
    "-hand",
    "handed",
    "händig",
    "coordinate",
    "koordinate",
    "spindle axis",
];

/// Words of the preamble after which numbers may be no figures in their unit; and those about the speed.
const SCALES: [&str; 6] = ["scale", "scaling", "factor", "faktor", "gain", "multipl"];
const RATIOS: [&str; 9] = [
    "belt",
    "gear",
    "ratio",
    "pole",
    "riemen",
    "getriebe",
    "übersetz",
    "umrichter",
    "converter",
];

/// Columns that may have a part of a time.
const PARTS_OF_TIME: [&str; 7] = ["ms", "msec", "us", "date", "datum", "data", "fecha"];

/// A proposal.
#[derive(Debug)]
pub struct Proposal {
    /// The description, as text.
    pub description: String,
    /// First and last rows as they would be read, and all that is open.
    pub report: String,
}

/// Looks at a file, `-` being standard input, and proposes how to read it.
///
/// # Errors
///
/// A file that cannot be opened, or has no row of numbers.
pub fn propose(path: impl AsRef<Path>) -> Result<Proposal, LoadsError> {
    of_lines(open(path.as_ref())?.0)
}

/// Proposes how to read an input that messages call `file`.
///
/// # Errors
///
/// An input that fails, or has no row of numbers.
pub fn of_input(file: &str, input: Box<dyn Read + Send>) -> Result<Proposal, LoadsError> {
    of_lines(Lines::new(file, input))
}

fn of_lines(mut lines: Lines) -> Result<Proposal, LoadsError> {
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
    let texts = head.iter().chain(&tail).map(|line| line.text.as_slice());
    let seen = texts.collect::<Vec<_>>().concat();
    let Some(sheet) = Sheet::new(head, tail.into()) else {
        let has_returns = seen.split(|byte| *byte == b'\r').count() > 2
            && seen.split(|byte| *byte == b'\n').count() < 3;
        let message = match seen.is_empty() {
            true => "the file is empty".to_owned(),
            _ if has_returns => "lines end with CR alone; end them with LF or CR LF".to_owned(),
            false => format!("there is no row of numbers in {HEAD} lines"),
        };
        return Err(lines.malformed(1, message));
    };
    let guesses = sheet.guesses();
    let description = sheet.description(&lines.file, &guesses);
    let report = report(&description, &guesses, seen);
    Ok(Proposal {
        description,
        report,
    })
}

/// A line of a description.
#[derive(Debug, Clone)]
struct Guess {
    quantity: Quantity,
    /// Its value as TOML, with `?` for the unit that is open.
    entry: String,
    /// The unit to look at rows with.
    unit: &'static str,
    /// Why something is open, and what may be written.
    why: String,
    column: Option<usize>,
}

impl Sheet {
    /// The units that a line of units says, by column: the line above the rows that fits most quantities by their names.
    fn line_of_units(&self) -> Vec<String> {
        let fits = |fields: &[String]| {
            let is_unit = |(field, heading): &(&String, &Heading)| {
                let unit = Unit::named(field);
                unit.is_some() && Quantity::ALL.iter().any(|one| heading.means(*one, unit))
            };
            fields.iter().zip(&self.headings).filter(is_unit).count()
        };
        // LabVIEW and Yokogawa say which line it is.
        let is_told = |fields: &[String]| {
            let first = fields
                .first()
                .map_or(String::new(), |field| field.to_lowercase());
            ["y_unit_label", "vunit"].contains(&first.as_str())
        };
        let lines = self.preamble().map(|line| line.fields(self.separator.1));
        let mut units = lines
            .max_by_key(|fields| (fits(fields), is_told(fields)))
            .unwrap_or_default();
        if fits(&units) < 2 && !is_told(&units) {
            units.clear();
        }
        let is_label = |unit: &str| {
            ["unit", "einheit"]
                .iter()
                .any(|word| unit.to_lowercase().contains(word))
        };
        for unit in &mut units {
            if is_label(unit) || ["-", "1"].contains(&unit.as_str()) {
                unit.clear();
            }
        }
        units
    }

    /// The unit of a dimension that the preamble says, and the counts of it, as ATI's sensors write them: `Force Units: N,
    /// Counts per Unit Force: 1000000`.
    fn said_above(&self, dimension: Dimension) -> Option<(Unit, Option<f64>)> {
        let name = match dimension {
            Dimension::Force => "force",
            Dimension::Moment => "torque",
            _ => return None,
        };
        let behind = |phrase: &str| {
            let found = self.preamble().filter_map(|line| {
                let line = text(&line.text).to_lowercase();
                let (_, value) = line.split_once(phrase)?;
                let value = value.trim_start_matches(['s', '"', ':', '=', ',', ';', '\t', ' ']);
                let value = value.split([',', ';', '\t', '"', '\r', '\n']).next()?;
                Some(value.trim().to_owned())
            });
            found.last()
        };
        let unit = Unit::named(&behind(&format!("{name} unit"))?)?;
        let counts = behind(&format!("counts per unit {name}"));
        let counts = counts.or_else(|| behind(&format!("counts per {name}")));
        let counts = counts.and_then(|counts| counts.parse().ok());
        (unit.dimension == dimension).then_some((unit, counts))
    }

    /// The unit of a column, or why it is open. `line` is the line of units' one.
    fn unit(&self, number: usize, quantity: Quantity, line: Option<&str>) -> Result<Unit, String> {
        let dimension = quantity.dimension();
        let named = |name: &str| Unit::named(name).filter(|unit| unit.dimension == dimension);
        let heading = &self.headings[number];
        match (heading.unit.as_deref(), line) {
            (Some(name), Some(line)) => {
                let both = named(name).filter(|unit| named(line) == Some(*unit));
                return both.ok_or_else(|| format!("its name says {name:?}, a line {line:?}"));
            }
            (Some(unit), None) | (None, Some(unit)) => {
                return named(unit).ok_or_else(|| format!("the file says {unit:?}"));
            }
            (None, None) => {}
        }
        if quantity == Quantity::Time {
            let behind = self
                .column(number)
                .next()
                .and_then(|field| field.split_once(' '));
            let is_labview = self
                .above
                .first()
                .is_some_and(|line| line.text.starts_with(b"LabVIEW Measurement"));
            let of_labview = (is_labview && heading.stem == "xvalue").then(|| Unit::of(dimension));
            let behind = behind.and_then(|(_, unit)| named(unit));
            return behind
                .or(of_labview)
                .ok_or_else(|| "the file says no unit".to_owned());
        }
        let (unit, counts) = self.said_above(dimension).ok_or("the file says no unit")?;
        // Counts are whole: one number with decimals, and all columns of the dimension are in the unit.
        let all = || {
            Quantity::ALL
                .into_iter()
                .filter(|one| one.dimension() == dimension)
        };
        let alike = (0..self.headings.len())
            .filter(|i| all().any(|one| self.headings[*i].means(one, Some(unit))));
        let are_whole = !alike
            .flat_map(|i| self.column(i))
            .any(|field| field.contains(['.', ',']));
        match counts.filter(|_| are_whole) {
            None => Ok(unit),
            Some(counts) => {
                let unit = unit.name();
                Err(format!(
                    "{unit}, or counts, which take factor = {}",
                    1.0 / counts
                ))
            }
        }
    }

    /// A line that leaves open in which unit the numbers of a quantity are.
    fn scale(&self, quantity: Quantity) -> Option<String> {
        let is_speed = quantity == Quantity::Speed;
        let says = |line: &&Line| {
            let text = text(&line.text).to_lowercase();
            let says = |words: &[&str]| words.iter().any(|word| text.contains(word));
            says(&SCALES) || is_speed && says(&RATIOS)
        };
        let line = self.preamble().find(says)?;
        Some(format!(
            "line {} {}",
            line.number,
            shown(text(&line.text).trim())
        ))
    }

    /// Where each quantity may be.
    fn guesses(&self) -> Vec<Guess> {
        let units = self.line_of_units();
        let line = |i: usize| {
            units
                .get(i)
                .map(String::as_str)
                .filter(|unit| !unit.is_empty())
        };
        let guesses = Quantity::ALL.into_iter().filter_map(|quantity| {
            let means = |i: &usize| {
                let heading = &self.headings[*i];
                let said = heading.unit.as_deref().or(line(*i)).and_then(Unit::named);
                let above = || self.said_above(quantity.dimension()).map(|(unit, _)| unit);
                heading.means(quantity, said.or_else(above))
            };
            let columns: Vec<usize> = (0..self.headings.len()).filter(means).collect();
            let open = |why: String| Guess {
                quantity,
                entry: format!("{OPEN:?}"),
                unit: "",
                why,
                column: None,
            };
            let is_needed = OWN[..LOADS].contains(&quantity);
            Some(match columns[..] {
                _ if self.is_shifted && is_needed => open(
                    "names and fields of the rows do not fit; { column = 3, unit = ... }, counted from 1".to_owned(),
                ),
                [one] => self.guess(one, quantity, line(one)).unwrap_or_else(open),
                [] if quantity == Quantity::Time => open(self.no_times()),
                [] if is_needed => {
                    open("in no column by its name; { column = 3, unit = ... }, or { value = 0, unit = ... }".to_owned())
                }
                [] => return None,
                ref several => {
                    let all = several
                        .iter()
                        .map(|i| format!("{} {}", i + 1, shown(&self.headings[*i].text)));
                    open(format!(
                        "one of the columns {}",
                        all.collect::<Vec<_>>().join(", ")
                    ))
                }
            })
        });
        guesses.collect()
    }

    /// A quantity in a column, or why that is open.
    fn guess(
        &self,
        number: usize,
        quantity: Quantity,
        line: Option<&str>,
    ) -> Result<Guess, String> {
        let fields: Vec<&str> = self.column(number).collect();
        let most = |is: &dyn Fn(&str) -> bool| {
            2 * fields.iter().filter(|field| is(field)).count() > fields.len()
        };
        let first = fields.first().copied().unwrap_or("nothing");
        if !is_value(first) && !most(&is_value) {
            return Err(format!("column {} has {}", number + 1, shown(first)));
        }
        let is_clock = quantity == Quantity::Time && most(&is_clock);
        let has_parts = || {
            self.headings
                .iter()
                .any(|heading| PARTS_OF_TIME.contains(&heading.stem.as_str()))
        };
        let (unit, why) = if is_clock && has_parts() && !first.contains('-') {
            (OPEN, "other columns may have a part of it".to_owned())
        } else if is_clock {
            ("clock", String::new())
        } else {
            match (self.unit(number, quantity, line), self.scale(quantity)) {
                (Err(why), _) => (OPEN, why),
                (Ok(unit), Some(scale)) => (
                    OPEN,
                    format!("{} by its name, but see {scale}", unit.name()),
                ),
                (Ok(unit), None) => (unit.name(), String::new()),
            }
        };
        let name = &self.headings[number].text;
        let is_unique = self.headings.iter().filter(|one| one.text == *name).count() == 1;
        let column = match self.header {
            Some(_) if is_unique && !name.is_empty() => quoted(name),
            _ => (number + 1).to_string(),
        };
        Ok(Guess {
            quantity,
            entry: format!("{{ column = {column}, unit = {unit:?} }}"),
            unit: if is_clock {
                "clock"
            } else {
                Unit::of(quantity.dimension()).name()
            },
            why,
            column: Some(number),
        })
    }

    /// Why times are open that are in no column.
    fn no_times(&self) -> String {
        let says = |line: &&Line| {
            let text = text(&line.text).to_lowercase();
            ["sampl", "abtast", "rate", "hz"]
                .iter()
                .any(|word| text.contains(word))
        };
        let said = self.preamble().find(says);
        let said = said.map_or(String::new(), |line| {
            format!("; line {} {}", line.number, shown(text(&line.text).trim()))
        });
        format!("in no column; {{ rate_hz = 1000 }}, or leave it out: rows are counted{said}")
    }

    /// Words above the rows that say how axes lie, unless that x is along the shaft.
    fn words_of_axes(&self, guesses: &[Guess]) -> Option<String> {
        let is_force = |guess: &Guess| {
            guess.column.is_some() && guess.quantity.dimension() == Dimension::Force
        };
        if !guesses.iter().any(is_force) {
            return None;
        }
        let says = |text: &str| AXES.iter().any(|word| text.to_lowercase().contains(word));
        let is_other =
            |heading: &&Heading| says(&heading.text) && !heading.means(Quantity::Fx, None);
        let in_names = self
            .headings
            .iter()
            .find(is_other)
            .map(|heading| shown(&heading.text));
        in_names.or_else(|| {
            let line = self.preamble().find(|line| says(&text(&line.text)))?;
            Some(format!(
                "in line {} {}",
                line.number,
                shown(text(&line.text).trim())
            ))
        })
    }

    /// The mark before decimals; none where it is open.
    fn decimal(&self, guesses: &[Guess]) -> Option<char> {
        let mut read: Vec<usize> = guesses.iter().filter_map(|guess| guess.column).collect();
        if read.is_empty() {
            read = (0..self.headings.len()).collect();
        }
        let fields = read.iter().flat_map(|number| self.column(*number));
        let fields: Vec<&str> = fields
            .filter(|field| is_value(field) && !is_clock(field))
            .collect();
        // The last mark of a number is none of thousands if another one is before it, or other digits than three behind.
        let decimals = |mark: char, other: char| {
            fields.iter().any(|field| {
                let is_last = field
                    .rfind([mark, other])
                    .is_some_and(|at| field[at..].starts_with(mark));
                is_last && (field.contains(other) || !has_thousands(field))
            })
        };
        let has = |mark: char| fields.iter().any(|field| field.contains(mark));
        match (decimals('.', ','), decimals(',', '.')) {
            (true, true) => None,
            (true, false) => Some('.'),
            (false, true) => Some(','),
            // Points between commas are decimals.
            _ if !has(',') && (self.separator.1 == b',' || !has('.')) => Some('.'),
            _ => None,
        }
    }

    fn description(&self, file: &str, guesses: &[Guess]) -> String {
        let mut lines = vec![format!(
            "# {}. Look at each line, and write for each \"?\" what the recording has.",
            file.replace(['\n', '\r'], " ")
        )];
        if let Some(header) = self.header {
            lines.push(format!("header_line = {}", self.above[header].number));
        }
        lines.push(format!("first_row = {}", self.first_row));
        lines.push(format!("separator = {:?}", self.separator.0));
        lines.push(match self.decimal(guesses) {
            Some(mark) => format!("decimal = \"{mark}\""),
            None => {
                "decimal = \"?\"   # \".\" or \",\": is it before decimals, or between thousands?"
                    .to_owned()
            }
        });
        lines.extend(self.comment.map(|mark| format!("comment = {mark:?}")));
        lines.extend(self.short_rows.map(|is_sure| {
            match is_sure {
                true => "short_rows = true".to_owned(),
                false => {
                    "short_rows = \"?\"   # true if the last names have no numbers; false refuses such rows"
                        .to_owned()
                }
            }
        }));
        lines.push(match self.words_of_axes(guesses) {
            Some(words) => format!("axes = \"?\"   # {{ x = \"Fx\", y = \"Fy\", z = \"Fz\" }} if x is along the shaft; the file says {words}"),
            None => "# If the recording's x is not along the shaft: axes = { x = \"Fz\", y = \"Fx\", z = \"Fy\" }".to_owned(),
        });
        lines.push("\n[columns]".to_owned());
        lines.extend(guesses.iter().map(|guess| {
            let why = guess.why.replace(['\n', '\r'], " ");
            let comment = if why.is_empty() {
                String::new()
            } else {
                format!("   # {why}")
            };
            format!("{} = {}{comment}", guess.quantity.name(), guess.entry)
        }));
        lines.join("\n") + "\n"
    }
}

/// A text in TOML, on one line.
fn quoted(text: &str) -> String {
    let mut quoted = String::new();
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            '\n' => quoted += "\\n",
            c if c.is_control() => quoted += &format!("\\u{:04X}", c as u32),
            c => quoted.push(c),
        }
    }
    format!("\"{quoted}\"")
}

/// First and last rows as they would be read, with units, and all that is open.
fn report(description: &str, guesses: &[Guess], seen: Vec<u8>) -> String {
    let is_read = |guess: &&Guess| guess.entry.starts_with('{') && guess.quantity != Quantity::Mx;
    let read: Vec<&Guess> = guesses.iter().filter(is_read).collect();
    let open: Vec<&str> = description
        .lines()
        .skip(1)
        .filter(|line| line.contains("\"?\""))
        .collect();
    // Rows are looked at with the project's units in the place of open ones.
    let mut assumed = description.to_owned();
    for line in &open {
        let guess = read
            .iter()
            .find(|guess| line.starts_with(&format!("{} = ", guess.quantity.name())));
        let known = guess.map_or(String::new(), |guess| {
            line.replace("\"?\"", &format!("{:?}", guess.unit))
        });
        assumed = assumed.replacen(line, &known, 1);
    }
    let wanted = Wanted {
        needed: OWN.map(|own| read.iter().any(|guess| guess.quantity == own)),
        ..Wanted::default()
    };
    let rows = || -> Result<(Vec<LoadRow>, String), String> {
        let import = Import::parse("the proposal", &assumed).map_err(|error| error.to_string())?;
        let input = Box::new(Cursor::new(seen));
        let loads = Loads::from_reader("the recording", input, Some(&import), &wanted);
        let mut loads = loads.map_err(|error| error.to_string())?;
        let rows: Vec<_> = loads.by_ref().filter_map(Result::ok).collect();
        let told = loads.told().map(|told| format!("{told}\n")).collect();
        let found = !rows.is_empty() && !read.is_empty();
        found
            .then_some((rows, told))
            .ok_or_else(|| "no row can be read as proposed".to_owned())
    };
    let line = |of: &dyn Fn(&Guess) -> String| {
        let fields = read.iter().map(|guess| format!("{:>14}", of(guess)));
        fields.collect::<String>() + "\n"
    };
    let mut text = match rows() {
        Err(fault) => fault + "\n",
        Ok((rows, told)) => {
            let names = line(&|guess| guess.quantity.name().to_owned());
            let units = line(&|guess| {
                let mark = if guess.entry.contains("\"?\"") {
                    "?"
                } else {
                    ""
                };
                format!("{}{mark}", Unit::of(guess.quantity.dimension()).name())
            });
            let last = rows.len().saturating_sub(2).max(3);
            let shown = rows.iter().take(3).chain(rows.iter().skip(last));
            let rows = shown.map(|row| {
                let numbers = crate::recordings::numbers(row);
                line(&|guess| {
                    let of = OWN.iter().position(|own| *own == guess.quantity);
                    let x = of.map_or(f64::NAN, |of| numbers[of]);
                    format!("{:.6e}", x).parse().unwrap_or(x).to_string()
                })
            });
            names + &units + &rows.collect::<String>() + &told
        }
    };
    match open[..] {
        [] => text += "nothing is open; look at names, units and axes all the same\n",
        _ => text += &format!("open:\n  {}\n", open.join("\n  ")),
    }
    text
}
