//! Recorded loads: forces, moments and speed as tables, row by row.
//!
//! A recording has a first line such as `time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm`, in any order; `t_inner_c,t_outer_c`
//! besides, for spindles with `[heat]`, and `probe_NAME_um` for their probes, whose fields may be empty. Without `time_s`, rows are
//! counted. Fields are separated by commas, semicolons or tabs, as the first line is; decimals by points. Other columns are
//! ignored, unless they look like one of these in another unit: such a file is refused, and so is any other.
//!
//! It is read to the letter: a line is a row, refused, or skipped, and all of them are counted. Every number is passed on
//! as it stands, `nan` and `inf` too: whether a row can be solved is for the solver to say. A time is a number.
//!
//! The csv crate reads lines with quotation marks; a reader of its own for every line would take two fifths of a replay.

use crate::fault::{BadRow, LoadsError, STDIN};
use crate::lines::{Lines, listed, shown, split, unreadable};
use crate::quantities::{LOADS, OWN, due};
use crate::times::Times;
use spindle_file::loads::{LoadRow, celsius};
use spindle_file::probes::MOST_PROBES;
use std::borrow::Cow;
use std::cmp::Reverse;
use std::fmt;
use std::fs::File;
use std::io::{self, Read, Write};
use std::mem::take;
use std::ops::RangeInclusive;
use std::path::Path;

/// Numbers of a record in the order of [`OWN`]; temperatures that it does not have are not numbers.
pub fn numbers(row: &LoadRow) -> [f64; OWN.len()] {
    let [fx, fy, fz, my, mz] = row.load;
    let [inner, outer] = row.temperatures.unwrap_or([f64::NAN; 2]);
    [row.time_s, fx, fy, fz, my, mz, row.speed_rpm, inner, outer]
}

/// Writes rows as a file of recorded loads.
///
/// # Errors
///
/// Errors of the output.
pub fn write_csv(rows: &[LoadRow], out: &mut impl Write) -> io::Result<()> {
    let warm = rows.iter().any(|row| row.temperatures.is_some());
    let columns = if warm { OWN.len() } else { LOADS };
    let names = OWN[..columns].iter().map(|quantity| quantity.column);
    writeln!(out, "{}", names.collect::<Vec<_>>().join(","))?;
    for row in rows {
        let columns = if row.temperatures.is_some() {
            OWN.len()
        } else {
            LOADS
        };
        let numbers = numbers(row);
        let numbers = numbers[..columns].iter().map(f64::to_string);
        writeln!(out, "{}", numbers.collect::<Vec<_>>().join(","))?;
    }
    Ok(())
}

/// Times that a record may have, s: beyond, a double does not tell seconds apart.
const TIMES: RangeInclusive<f64> = -1e15..=1e15;

/// Names at fault that a message has.
const MOST_FAULTS: usize = 10;

/// The time of a row, s; of one that cannot be read, if that can.
fn time_of(row: &mut Result<LoadRow, LoadsError>) -> Option<&mut f64> {
    match row {
        Ok(row) => Some(&mut row.time_s),
        Err(LoadsError::Row(bad)) => bad.numbers[0].as_mut(),
        Err(_) => None,
    }
}

/// Divides the time to the next record among records of one time; says in a line how many there were.
pub fn sharing_times(rows: Vec<LoadRow>) -> (Vec<LoadRow>, Option<String>) {
    let (mut rows, mut times) = (
        rows.into_iter(),
        Times::of(|row: &mut LoadRow| Some(&mut row.time_s)),
    );
    let shared = std::iter::from_fn(|| times.next(|| rows.next())).collect();
    (shared, times.account())
}

/// The part of a recording that a replay takes.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// Quantities that are needed, of [`OWN`].
    pub needed: [bool; OWN.len()],
    /// One record of so many is read.
    pub every: usize,
    /// Names of the probes whose readings are wanted, as far as the recording has them.
    pub probes: Vec<String>,
    /// Records of one time share the time to the next one: for all that weighs records by their time.
    pub shares_times: bool,
}

impl Default for Wanted {
    fn default() -> Self {
        let mut needed = [true; OWN.len()];
        // Without times, rows are counted.
        needed[0] = false;
        needed[LOADS..].fill(false);
        Self {
            needed,
            every: 1,
            probes: Vec::new(),
            shares_times: false,
        }
    }
}

/// Opens a file of recorded loads, `-` being standard input, and finds its columns.
///
/// # Errors
///
/// A file that cannot be opened, or is no recording; a quantity that is needed and nowhere.
pub fn read(path_or_dash: impl AsRef<Path>, wanted: &Wanted) -> Result<Loads, LoadsError> {
    let path = path_or_dash.as_ref();
    if path.as_os_str() == "-" {
        return Loads::from_reader(STDIN, Box::new(io::stdin()), wanted);
    }
    let name = path.display().to_string();
    let opened = File::open(path).and_then(|opened| Ok((opened.metadata()?, opened)));
    let (data, opened) = opened.map_err(|error| unreadable(&name, &error))?;
    let loads = Loads::from_reader(&name, Box::new(opened), wanted)?;
    Ok(Loads {
        total_bytes: data.is_file().then_some(data.len()),
        ..loads
    })
}

/// The rows of a file of recorded loads, read one at a time. Ends after the first error that is not one of a row.
pub struct Loads {
    lines: Lines,
    /// The line is the first below the header, and not yet a row.
    is_ahead: bool,
    header: Vec<u8>,
    layout: Layout,
    total_bytes: Option<u64>,
    every: usize,
    ended: bool,
    counts: Counts,
    /// Least and largest number of each quantity.
    ranges: [(f64, f64); OWN.len()],
    /// Times of the first and the last row.
    times: Option<(f64, f64)>,
    /// Records of one time, if they share it.
    shared: Option<Times<Result<LoadRow, LoadsError>>>,
}

/// Lines below the header.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rows that were read.
    pub read: u64,
    /// Rows that cannot be read.
    pub refused: u64,
    /// Blank lines, and the header again.
    pub skipped: u64,
}

/// Columns of a recording.
#[derive(Debug, Default)]
struct Layout {
    separator: u8,
    names: Vec<String>,
    /// The quantity in each field, by its number in [`OWN`]; probes have the numbers behind.
    of_field: Vec<Option<usize>>,
    /// Names of the columns that are read: those of [`OWN`], and of the probes that are wanted.
    columns: Vec<String>,
}

impl Loads {
    /// Reads from `input`; messages call it `name`.
    ///
    /// # Errors
    ///
    /// A file that is no recording, a quantity that is needed and nowhere, or an input that fails.
    pub fn from_reader(
        name: &str,
        input: Box<dyn Read + Send>,
        wanted: &Wanted,
    ) -> Result<Self, LoadsError> {
        let mut lines = Lines::new(name, input);
        if !lines.next()? {
            return Err(lines.malformed(1, "the file is empty"));
        }
        let mut loads = Self {
            layout: Layout::of(&lines, wanted)?,
            header: lines.text.trim_ascii().to_vec(),
            lines,
            is_ahead: false,
            total_bytes: None,
            every: wanted.every,
            ended: false,
            counts: Counts::default(),
            ranges: [(f64::INFINITY, f64::NEG_INFINITY); OWN.len()],
            times: None,
            shared: wanted.shares_times.then(|| Times::of(time_of)),
        };
        loads.is_ahead = loads.next_line()?;
        let (layout, text) = (&loads.layout, &loads.lines.text);
        if loads.is_ahead
            && let Ok(first) = std::str::from_utf8(text)
            && let Some((field, why)) = layout.strange(first)
        {
            let remedy = wanted.remedy(name, layout.separator);
            let fault = loads.fault(field, layout.of_field[field - 1], why);
            return Err(LoadsError::Malformed(fault + &remedy));
        }
        Ok(loads)
    }

    /// Bytes taken from the input so far.
    pub fn bytes_read(&self) -> u64 {
        self.lines.bytes
    }

    /// Size of the input, if it is a plain file.
    pub fn total_bytes(&self) -> Option<u64> {
        self.total_bytes
    }

    /// Lines so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Whether there are temperatures.
    pub fn has_temperatures(&self) -> bool {
        (LOADS..OWN.len()).any(|i| self.layout.has(i))
    }

    /// Whether there is a column for each of the wanted probes.
    pub fn has_probes(&self) -> impl Iterator<Item = bool> {
        (OWN.len()..self.layout.columns.len()).map(|i| self.layout.has(i))
    }

    /// The name of the file, as messages give it.
    pub fn file(&self) -> &str {
        &self.lines.file
    }

    /// Names of the columns that are not read; none if there are none.
    pub fn ignored_columns(&self) -> Option<String> {
        let names = self.layout.names.iter().zip(&self.layout.of_field);
        let ignored = names.filter(|(name, of)| of.is_none() && !name.is_empty());
        let names: Vec<String> = ignored.map(|(name, _)| name.clone()).collect();
        (!names.is_empty()).then(|| listed(&names, 12))
    }

    /// How many records have shared a time, in one line; none if none have.
    pub fn shared(&self) -> Option<String> {
        self.shared.as_ref()?.account()
    }

    /// Counts of lines, and the first and last time and range of each quantity, in one line; records that share a time.
    pub fn account(&self) -> String {
        let Counts {
            read,
            refused,
            skipped,
        } = self.counts;
        let file = self.file();
        let mut text = String::new();
        if let Some(shared) = self.shared() {
            text += &format!("{file}: {shared}\n");
        }
        text += &format!("{file}: rows read {read}, refused {refused}; lines skipped {skipped}");
        let short = |x: f64| -> f64 { format!("{x:.8e}").parse().unwrap_or(x) };
        for (i, (own, (least, most))) in OWN.iter().zip(self.ranges).enumerate() {
            let (name, unit) = (own.name, own.unit);
            let (least, most) = (short(least), short(most));
            text += &match (i, self.times) {
                (0, Some((first, last))) => {
                    format!("; time {} to {} {unit}", short(first), short(last))
                }
                _ if !self.layout.has(i) => continue,
                _ if least < most => format!(", {name} {least} to {most} {unit}"),
                _ if least == most => format!(", {name} {least} {unit}"),
                _ => continue,
            };
        }
        text
    }

    /// A complaint of a field of the line, counted from 1; `of` is the column that it holds, if it is one of ours.
    fn fault(&self, field: usize, of: Option<usize>, message: impl fmt::Display) -> String {
        let (file, line) = (self.file(), self.lines.number);
        let name = of.map_or(String::new(), |of| {
            format!(" ({})", self.layout.columns[of])
        });
        format!("{file}: line {line}, column {field}{name}: {message}")
    }

    /// Goes to the next line that is neither blank nor the header again; `false` at the end of the file.
    fn next_line(&mut self) -> Result<bool, LoadsError> {
        while self.lines.next()? {
            if !self.lines.is_blank() && self.lines.text.trim_ascii() != self.header {
                return Ok(true);
            }
            self.counts.skipped += 1;
        }
        Ok(false)
    }

    /// The next row, or a refused one.
    fn row(&mut self) -> Option<Result<LoadRow, LoadsError>> {
        if !take(&mut self.is_ahead) {
            match self.next_line() {
                Ok(true) => {}
                Ok(false) => return None,
                Err(error) => return Some(Err(error)),
            }
        }
        let line = take(&mut self.lines.text);
        let read = self.read(&line);
        self.lines.text = line;
        match read {
            Ok(_) => self.counts.read += 1,
            Err(_) => self.counts.refused += 1,
        }
        Some(read)
    }

    /// A line as a row, or why it is none.
    fn read(&mut self, line: &[u8]) -> Result<LoadRow, LoadsError> {
        let layout = &self.layout;
        let (line, mut bad) = match std::str::from_utf8(line) {
            Ok(line) => (Cow::Borrowed(line), None),
            Err(error) => {
                let at = error.valid_up_to();
                let before = line[..at].iter();
                let i = before.filter(|byte| **byte == layout.separator).count();
                let of = layout.of_field.get(i).copied().flatten();
                (
                    String::from_utf8_lossy(line),
                    Some((i + 1, of, no_text(at))),
                )
            }
        };
        let rows = self.counts.read + self.counts.refused;
        let mut numbers = [None; OWN.len()];
        numbers[0] = Some(rows as f64).filter(|_| !layout.has(0));
        let mut probes = [None; MOST_PROBES];
        let (mut more, mut words, mut columns) = (false, 0, 0);
        let width = layout.of_field.len();
        let count = split(&line, layout.separator, |i, text| {
            more |= i >= width && !text.is_empty();
            let Some(Some(of)) = layout.of_field.get(i).copied() else {
                return;
            };
            columns += usize::from(of < OWN.len());
            let found = match of.checked_sub(OWN.len()) {
                Some(_) if text.is_empty() => Ok(()),
                Some(probe) => number(text).map(|x| probes[probe] = Some(x)),
                None => of_quantity(of, text).map(|x| numbers[of] = Some(x)),
            };
            if let Err(message) = found {
                words += usize::from(of < OWN.len() && !text.is_empty() && number(text).is_err());
                bad.get_or_insert((i + 1, Some(of), message));
            }
        });
        let lost = match count {
            Err((field, message)) => Some((field, None, message.to_owned())),
            Ok(count) if count < width => {
                let message = format!("the line ends after {count} of {width} fields");
                Some((count + 1, layout.of_field[count], message))
            }
            Ok(count) if more => {
                let message = format!("the line has {count} fields where the header has {width}");
                Some((width + 1, None, message))
            }
            Ok(_) => None,
        };
        let ours = (0..OWN.len()).filter(|of| layout.has(*of)).count();
        if words > 1 && words == columns && columns == ours {
            let message =
                "no column has a number: if another recording begins here, give it by itself";
            return Err(self.lines.malformed(1, message));
        }
        let is_lost = lost.is_some();
        // Where numbers are readable, the first bad one says more than a wrong count.
        if let Some((field, of, message)) = bad.or(lost) {
            return Err(LoadsError::Row(Box::new(BadRow {
                fault: self.fault(field, of, message),
                numbers: numbers.map(|number| number.filter(|_| !is_lost)),
            })));
        }
        for ((least, most), number) in self.ranges.iter_mut().zip(numbers) {
            let number = number.unwrap_or(f64::NAN);
            (*least, *most) = (least.min(number), most.max(number));
        }
        let [time, fx, fy, fz, my, mz, speed, inner, outer] = numbers;
        let is = Option::unwrap_or_default;
        let first = self.times.map_or(is(time), |(first, _)| first);
        self.times = Some((first, is(time)));
        Ok(LoadRow {
            time_s: is(time),
            load: [fx, fy, fz, my, mz].map(is),
            speed_rpm: is(speed),
            temperatures: inner.zip(outer).map(<[f64; 2]>::from),
            probes,
        })
    }
}

impl Wanted {
    /// How a recording is made of another file.
    fn remedy(&self, file: &str, separator: u8) -> String {
        let due = (0..OWN.len()).filter(|i| *i == 0 || self.needed[*i]);
        let due: Vec<&str> = due.map(|i| OWN[i].column).collect();
        let columns: Vec<String> = due
            .iter()
            .map(|name| format!("{name:?}: df[\"?\"]"))
            .collect();
        let (due, columns) = (due.join(","), columns.join(", "));
        let file = if file == STDIN { "other.csv" } else { file };
        let how = match separator {
            b'\t' => ", sep=\"\\t\", decimal=\",\"",
            b';' => ", sep=\";\", decimal=\",\"",
            _ => "",
        };
        format!(
            "\nType the header {due} above your columns in a spreadsheet, and save them as CSV. Or in Python, after \
             `import pandas`:\n  \
             df = pandas.read_csv({file:?}{how})  # or as in docs/recordings.md\n  \
             df = pandas.DataFrame({{{columns}}})  # such as 1000 * df[\"Fx / kN\"], or a constant\n  \
             df.to_csv(\"loads.csv\", index=False)"
        )
    }
}

impl Layout {
    /// Finds the columns of a header, or says why this is another file.
    fn of(lines: &Lines, wanted: &Wanted) -> Result<Self, LoadsError> {
        let text = std::str::from_utf8(&lines.text);
        let line = match text.map(|text| (text, text.find('\0'))) {
            Ok((text, None)) => text,
            other => {
                let at = other.map_or_else(|error| Some(error.valid_up_to()), |(_, at)| at);
                let what = no_text(at.unwrap_or_default()) + &wanted.remedy(&lines.file, b',');
                return Err(lines.malformed(1, what));
            }
        };
        let own = OWN.iter().map(|own| own.column.to_owned());
        let probes = wanted.probes.iter();
        let probes = probes.map(|probe| format!("probe_{probe}_um"));
        let columns: Vec<String> = own.chain(probes).collect();
        let mut layouts = [b',', b';', b'\t'].map(|separator| {
            let mut names = Vec::new();
            let split = split(line, separator, |_, name| names.push(name.to_owned()));
            let used = names.iter().rposition(|name| !name.is_empty());
            names.truncate(used.map_or(0, |last| last + 1));
            (split, separator, names)
        });
        // Of a file without names of ours, that which makes most names.
        layouts.sort_by_key(|(_, _, names)| {
            let ours = names.iter().filter(|name| columns.contains(name));
            Reverse((ours.count(), names.len()))
        });
        let [(split, separator, names), ..] = layouts;
        split.map_err(|(field, message)| lines.malformed(field, message))?;
        let place = |name: &String| columns.iter().position(|column| column == name);
        let layout = Self {
            separator,
            of_field: names.iter().map(place).collect(),
            names,
            columns,
        };
        let mut faults = layout.faults(wanted).into_iter().take(MOST_FAULTS);
        let Some((field, first)) = faults.next() else {
            return Ok(layout);
        };
        let more = faults.map(|(field, fault)| format!("\n  column {field}: {fault}"));
        let remedy = wanted.remedy(&lines.file, separator);
        Err(lines.malformed(field, first + &more.collect::<String>() + &remedy))
    }

    fn has(&self, of: usize) -> bool {
        self.of_field.contains(&Some(of))
    }

    /// All that is wrong with the names, with the column of each.
    fn faults(&self, wanted: &Wanted) -> Vec<(usize, String)> {
        let mut faults = Vec::new();
        let lacking = (0..OWN.len()).filter(|i| wanted.needed[*i] && !self.has(*i));
        let lacking: Vec<&str> = lacking.map(|i| OWN[i].column).collect();
        if !lacking.is_empty() {
            let names = match &self.names[..] {
                [] => "the line is blank".to_owned(),
                names => format!("the names are {}", listed(names, 5)),
            };
            faults.push((1, format!("{names}: there is no {}", lacking.join(", "))));
        }
        for (i, name) in self.names.iter().enumerate() {
            let fault = match due(name) {
                _ if name.is_empty() => continue,
                _ if self.names[..i].contains(name) => {
                    format!(
                        "{} is the name of another column, too: rename one",
                        shown(name)
                    )
                }
                Some((column, what)) if !self.names.contains(&column) => {
                    format!("`{}`: {what}", shown(name).trim_matches('"'))
                }
                _ => continue,
            };
            faults.push((i + 1, fault));
        }
        faults
    }

    /// The field of the first row that says that this is another file, and why.
    fn strange(&self, line: &str) -> Option<(usize, String)> {
        let mut found = None;
        let _ = split(line, self.separator, |i, field| {
            let why = match self.of_field.get(i) {
                Some(Some(of)) if *of < OWN.len() && !field.is_empty() => number(field).err(),
                Some(None) if !self.has(0) && may_be_time(field) => {
                    let field = shown(field);
                    Some(format!("{field} is a time, and there is no time_s"))
                }
                _ => None,
            };
            found = found.take().or(why.map(|why| (i + 1, why)));
        });
        found
    }
}

/// Complaint of a line with a byte at `at` that is no text.
fn no_text(at: usize) -> String {
    format!(
        "byte {} of the line is no UTF-8 text: save the file as UTF-8 (pandas reads with encoding=\"cp1252\")",
        at + 1
    )
}

/// The number in a field of this quantity, or the field's fault.
fn of_quantity(of: usize, text: &str) -> Result<f64, String> {
    if text.is_empty() {
        return Err("the field is empty; a number is needed".to_owned());
    }
    let value = number(text)?;
    match of {
        0 if !TIMES.contains(&value) => {
            let [first, last] = [TIMES.start(), TIMES.end()];
            let text = shown(text);
            Err(format!(
                "{text} is no time; give seconds from {first:e} to {last:e}"
            ))
        }
        LOADS.. => celsius(value),
        _ => Ok(value),
    }
}

/// A number with a decimal point, to the letter.
fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| {
        let mut digits = text.chars();
        let are_digits =
            digits.all(|c| c.is_ascii_digit() || "+-,.'\u{2019}\u{a0}\u{202f} ".contains(c));
        let hint = match are_digits {
            true => " with a decimal point: decimal commas and thousands separators are not read",
            false => "",
        };
        format!("{} is not a number{hint}", shown(text))
    })
}

/// Whether a field may be a date or a clock time in any form.
fn may_be_time(field: &str) -> bool {
    let parts = field.split([':', '-', '/', '.']);
    let numbers = parts.filter(|part| part.parse::<u32>().is_ok()).count();
    numbers > 2 || numbers > 1 && field.contains(':')
}

impl Iterator for Loads {
    type Item = Result<LoadRow, LoadsError>;

    fn next(&mut self) -> Option<Self::Item> {
        let Some(mut shared) = self.shared.take() else {
            return self.every_row();
        };
        let row = shared.next(|| self.every_row());
        self.shared = Some(shared);
        row
    }
}

impl Loads {
    /// The next row of those that are wanted.
    fn every_row(&mut self) -> Option<Result<LoadRow, LoadsError>> {
        if self.ended {
            return None;
        }
        let passed = match self.counts.read + self.counts.refused {
            0 => 1,
            _ => self.every,
        };
        let mut row = self.row();
        for _ in 1..passed {
            if let Some(Ok(_) | Err(LoadsError::Row(_))) = row {
                row = self.row();
            }
        }
        self.ended = !matches!(row, Some(Ok(_) | Err(LoadsError::Row(_))));
        row
    }
}
