//! Recorded loads: forces, moments and speed as tables, row by row.
//!
//! A recording in the project's own columns has a first line such as `time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm`, in any
//! order, with further columns that are ignored; `t_inner_c,t_outer_c` besides, for spindles with `[heat]`, and `probe_NAME_um` for
//! their probes, whose fields may be empty. Without `time_s`, rows are counted. Any other table needs a [description](crate::import).
//!
//! Both are read to the letter: a line is a row, refused, or skipped, and all of them are counted. Every number is passed on
//! as it stands, `nan` and `inf` too: whether a row can be solved is for the solver to say. A time is a number.
//!
//! The csv crate reads lines with quotation marks; a reader of its own for every line would take two fifths of a replay.

use crate::fault::{BadRow, LoadsError, STDIN};
use crate::import::{Import, Name, ProbeColumn, Source, Wanted};
use crate::lines::{Line, Lines, listed, number, shown, split, text};
use crate::quantities::{LOADS, OWN, Quantity};
use crate::times::Times;
use crate::units::{Dimension, Unit};
use jiff::civil::{Date, DateTime, Time};
use spindle_file::loads::{LoadRow, celsius};
use spindle_file::probes::MOST_PROBES;
use std::collections::VecDeque;
use std::fmt;
use std::fs::File;
use std::io::{self, Read, Write};
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
    let names = OWN[..columns].iter().map(|quantity| quantity.column());
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

/// Before the first row.
const NO_RANGES: [(f64, f64); OWN.len()] = [(f64::INFINITY, f64::NEG_INFINITY); OWN.len()];

/// Blank lines in which the first row of the project's own columns is looked for.
const MOST_BLANKS: usize = 20;

/// Lines of a preamble that are known again in the middle of a file.
const LONGEST_PREAMBLE: u64 = 400;

/// The time of a row, s; of one that cannot be read, if that can.
fn time_of(row: &mut Result<LoadRow, LoadsError>) -> Option<&mut f64> {
    match row {
        Ok(row) => Some(&mut row.time_s),
        Err(LoadsError::Row(bad)) => bad.numbers[0].as_mut(),
        Err(_) => None,
    }
}

/// Opens a file, `-` being standard input: its lines, and how many bytes there are if it is a plain file.
pub(crate) fn open(path: &Path) -> Result<(Lines, Option<u64>), LoadsError> {
    if path.as_os_str() == "-" {
        return Ok((Lines::new(STDIN, Box::new(io::stdin())), None));
    }
    let file = path.display().to_string();
    let opened = File::open(path).and_then(|opened| Ok((opened.metadata()?, opened)));
    match opened {
        Ok((data, opened)) => {
            let bytes = data.is_file().then_some(data.len());
            Ok((Lines::new(&file, Box::new(opened)), bytes))
        }
        Err(source) => Err(LoadsError::Unreadable { file, source }),
    }
}

/// Opens a file of recorded loads, `-` being standard input, and finds its columns: by a description, or its own.
///
/// # Errors
///
/// A file that cannot be opened, or is not as described; a quantity that is needed and nowhere.
pub fn read(
    path_or_dash: impl AsRef<Path>,
    import: Option<&Import>,
    wanted: &Wanted,
) -> Result<Loads, LoadsError> {
    let (lines, total_bytes) = open(path_or_dash.as_ref())?;
    let loads = Loads::of(lines, import, wanted)?;
    Ok(Loads {
        total_bytes,
        ..loads
    })
}

/// The rows of a file of recorded loads, read one at a time. Ends after the first error that is not one of a row.
pub struct Loads {
    lines: Lines,
    line: Line,
    /// Lines that were read to know the file.
    ahead: VecDeque<Line>,
    layout: Layout,
    /// Lines above the header.
    preamble: Vec<Vec<u8>>,
    /// Lines of the header, of units and so on; the first is that of the names.
    header: Vec<Vec<u8>>,
    part: Part,
    /// Lines of the header that have come again in a row.
    again: usize,
    /// The first line that begins another file, and the first above the rows that reads as one.
    told: [Option<String>; 2],
    clock: Clock,
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

/// The part of a file that a line stands in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    /// Below the header.
    Own,
    /// Below another file's header; the header ends it.
    Other,
    /// Among lines that no preamble of this file has: its units may be others, and the header does not end it.
    Strange,
}

/// Lines below the header.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rows that were read.
    pub read: u64,
    /// Rows that cannot be read.
    pub refused: u64,
    /// Comments, blank lines, and the header's lines again.
    pub skipped: u64,
}

/// How the lines of a recording are read.
#[derive(Debug, Default)]
struct Layout {
    separator: u8,
    decimal: u8,
    comment: Option<String>,
    short_rows: bool,
    sources: [Source; OWN.len()],
    /// Columns of the probes that are wanted.
    probes: Vec<Option<ProbeColumn>>,
    /// Names of the columns; none where the file has no header.
    names: Vec<String>,
    /// Fields of a row; 0 until the first row says it.
    width: usize,
    /// The quantity in each field, by its number in [`OWN`]; probes have the numbers behind.
    of_field: Vec<Option<usize>>,
}

impl Loads {
    /// Reads from `input`; messages call it `name`.
    ///
    /// # Errors
    ///
    /// A file that is not as described, a quantity that is needed and nowhere, or an input that fails.
    pub fn from_reader(
        name: &str,
        input: Box<dyn Read + Send>,
        import: Option<&Import>,
        wanted: &Wanted,
    ) -> Result<Self, LoadsError> {
        Self::of(Lines::new(name, input), import, wanted)
    }

    fn of(lines: Lines, import: Option<&Import>, wanted: &Wanted) -> Result<Self, LoadsError> {
        let mut loads = Self {
            lines,
            line: Line::default(),
            ahead: VecDeque::new(),
            layout: Layout::default(),
            preamble: Vec::new(),
            header: Vec::new(),
            part: Part::Own,
            again: 0,
            told: [None, None],
            clock: Clock::default(),
            total_bytes: None,
            every: wanted.every,
            ended: false,
            counts: Counts::default(),
            ranges: NO_RANGES,
            times: None,
            shared: wanted.shares_times.then(|| Times::of(time_of)),
        };
        match import {
            Some(import) => loads.follow(import, wanted)?,
            None => {
                let own = loads.own(wanted)?;
                // All that a recording has in its own columns is read.
                let wanted = Wanted {
                    needed: OWN.map(|quantity| own.has(quantity)),
                    ..wanted.clone()
                };
                loads.follow(&own, &wanted)?;
            }
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

    /// Whether there are temperatures in the project's own columns.
    pub fn has_temperatures(&self) -> bool {
        let mut names = self.layout.names.iter();
        names.any(|name| OWN[LOADS..].iter().any(|side| name == side.column()))
    }

    /// Whether there is a column for each of the wanted probes.
    pub fn has_probes(&self) -> impl Iterator<Item = bool> {
        self.layout.probes.iter().map(Option::is_some)
    }

    /// The name of the file, as messages give it.
    pub fn file(&self) -> &str {
        &self.lines.file
    }

    /// Names of the columns that are not read; none if there are none.
    pub fn ignored_columns(&self) -> Option<String> {
        let layout = &self.layout;
        let names = layout.names.iter().zip(&layout.of_field);
        let ignored = names.filter(|(name, of)| of.is_none() && !name.is_empty());
        let names: Vec<String> = ignored.map(|(name, _)| name.clone()).collect();
        (!names.is_empty()).then(|| listed(&names))
    }

    /// Lines that are not as described: the first that begins another file, the first above the rows that reads as one.
    pub fn told(&self) -> impl Iterator<Item = &str> {
        self.told.iter().flatten().map(String::as_str)
    }

    /// How many records have shared a time, in one line; none if none have.
    pub fn shared(&self) -> Option<String> {
        self.shared.as_ref()?.account()
    }

    /// Counts of lines, and the first and last time and range of each quantity, in one line; the headers of other files.
    pub fn account(&self) -> String {
        let Counts {
            read,
            refused,
            skipped,
        } = self.counts;
        let file = self.file();
        let mut text = String::new();
        for told in self.told() {
            text += &format!("{file}: {told}\n");
        }
        if let Some(shared) = self.shared() {
            text += &format!("{file}: {shared}\n");
        }
        text += &format!("{file}: rows read {read}, refused {refused}; lines skipped {skipped}");
        let ranges = OWN.into_iter().zip(self.ranges).zip(&self.layout.sources);
        let short = |x: f64| -> f64 { format!("{x:.8e}").parse().unwrap_or(x) };
        for ((quantity, (least, most)), source) in ranges {
            let (least, most) = (short(least), short(most));
            let (name, unit) = (quantity.name(), Unit::of(quantity.dimension()).name());
            text += &match (quantity, self.times) {
                _ if *source == Source::None => continue,
                (Quantity::Time, Some((first, last))) => {
                    format!("; time {} to {} {unit}", short(first), short(last))
                }
                _ if least < most => format!(", {name} {least} to {most} {unit}"),
                _ if least == most => format!(", {name} {least} {unit}"),
                _ => continue,
            };
        }
        text
    }

    /// A complaint of a field of the line, counted from 1; `quantity` is the one that it holds, if it is one of ours.
    fn fault(&self, field: usize, quantity: Option<usize>, message: impl fmt::Display) -> String {
        let (file, line) = (self.file(), self.line.number);
        let name = quantity.map_or(String::new(), |i| match OWN.get(i) {
            Some(own) => format!(" ({})", own.column()),
            None => format!(" ({})", self.layout.key(i)),
        });
        format!("{file}: line {line}, column {field}{name}: {message}")
    }

    fn foreign(&self, why: String) -> LoadsError {
        let file = self.file().to_owned();
        LoadsError::Foreign { file, why }
    }

    /// The project's own columns that a file has: names on the first line, numbers with points below.
    fn own(&mut self, wanted: &Wanted) -> Result<Import, LoadsError> {
        let mut line = Line::default();
        while self.ahead.len() < MOST_BLANKS && self.lines.next(&mut line)? {
            let is_below = line.number > 1 && !line.is_blank();
            self.ahead.push_back(std::mem::take(&mut line));
            if is_below {
                break;
            }
        }
        let Some(first) = self.ahead.front() else {
            return Err(self.lines.malformed(1, "the file is empty"));
        };
        let names = first.fields(b',');
        let has = OWN.map(|own| names.iter().any(|name| name == own.column()));
        // A time or a speed alone is anybody's.
        if !has[1..6].contains(&true) {
            let own = OWN[..LOADS].iter().map(|own| own.column());
            let own: Vec<_> = own.collect();
            return Err(self.foreign(format!("line 1 has none of the columns {}", own.join(","))));
        }
        let second = self.ahead.back().filter(|line| line.number > 1);
        let fields = second.map_or(Vec::new(), |line| line.fields(b','));
        for (name, field) in names.iter().zip(&fields) {
            let is_own = OWN.iter().any(|own| name == own.column());
            let field = Some(field).filter(|field| !field.is_empty());
            if let Some(field) = field.filter(|field| is_own && number(field, b'.').is_none()) {
                let field = shown(field);
                return Err(
                    self.foreign(format!("below {name}, {field} is no number with a point"))
                );
            }
            if let Some(field) = field.filter(|field| !is_own && !has[0] && may_be_time(field)) {
                let field = shown(field);
                return Err(self.foreign(format!("there is no time_s, but {field} is a time")));
            }
        }
        let lacks = |i: &usize| wanted.needed[*i] && wanted.given[*i].is_none() && !has[*i];
        let lacking = (0..OWN.len()).filter(lacks).map(|i| {
            let (column, name) = (OWN[i].column(), OWN[i].name());
            format!("no column {column}: add it, or give --{name}")
        });
        let lacking: Vec<_> = lacking.collect();
        match lacking.is_empty() {
            true => {
                let probes = wanted.probes.iter();
                let has_probe = |probe: &&String| {
                    let own = ProbeColumn::own(probe);
                    names
                        .iter()
                        .any(|name| Name::Text(name.clone()) == own.name)
                };
                Ok(Import::own(
                    has,
                    &probes.filter(has_probe).collect::<Vec<_>>(),
                ))
            }
            false => Err(self.lines.malformed(1, lacking.join("; "))),
        }
    }

    /// Goes to the first row of a file that is described.
    fn follow(&mut self, import: &Import, wanted: &Wanted) -> Result<(), LoadsError> {
        self.layout = Layout {
            separator: import.separator,
            decimal: import.decimal,
            comment: import.comment.clone(),
            short_rows: import.short_rows,
            sources: import.sources(wanted).map_err(LoadsError::Malformed)?,
            probes: import.probes(&wanted.probes),
            ..Layout::default()
        };
        let mut names = Line::default();
        let mut row = 1;
        while row < import.first_row {
            if !self.next_line()? {
                let (file, row) = (&import.file, import.first_row);
                return Err(self.foreign(format!(
                    "it ends above line {row}, where {file} has the first row"
                )));
            }
            row = self.line.number + 1;
            let text = self.line.text.trim_ascii().to_vec();
            match import.header_line.filter(|at| *at <= self.line.number) {
                None if self.line.number <= LONGEST_PREAMBLE => self.preamble.push(text),
                None => {}
                Some(at) => {
                    // A name may go over several lines.
                    if self.line.number == at || names.is_open() {
                        names.text.extend_from_slice(&self.line.text);
                    }
                    self.header.push(text);
                }
            }
        }
        let Some(at) = import.header_line else {
            return Ok(());
        };
        if names.is_open() {
            names.text = [&self.header[0][..], b"\n"].concat();
        }
        if let Some(mark) = &import.comment
            && let Some(rest) = names.text.trim_ascii_start().strip_prefix(mark.as_bytes())
        {
            names.text = rest.to_vec();
        }
        self.layout.set_names(names.fields(import.separator));
        if let Err(why) = self.layout.place() {
            let why = format!("line {at} has {why} of {}: it is another file", import.file);
            return Err(self.foreign(why));
        }
        for (i, line) in self.header.clone().iter().enumerate().skip(1) {
            if self.read(line).is_ok() {
                let line = at + i as u64;
                let message =
                    format!("line {line}, above `first_row`, reads as a row, and is none");
                self.told[1].get_or_insert(message);
            }
        }
        (self.ranges, self.times, self.clock, self.part) =
            (NO_RANGES, None, Clock::default(), Part::Own);
        self.told[0] = None;
        Ok(())
    }

    /// Brings the next line into `self.line`; `false` at the end of the file.
    fn next_line(&mut self) -> Result<bool, LoadsError> {
        match self.ahead.pop_front() {
            Some(line) => self.line = line,
            None => return self.lines.next(&mut self.line),
        }
        Ok(true)
    }

    /// The next line that is a row, or a refused one.
    fn row(&mut self) -> Option<Result<LoadRow, LoadsError>> {
        loop {
            match self.next_line() {
                Ok(true) => {}
                Ok(false) => return None,
                Err(error) => return Some(Err(error)),
            }
            if self.says_nothing() || self.is_header_again() {
                self.counts.skipped += 1;
                continue;
            }
            let line = std::mem::take(&mut self.line.text);
            let read = self.read(&line);
            self.line.text = line;
            let bad = match read {
                Ok(row) => {
                    self.counts.read += 1;
                    return Some(Ok(row));
                }
                Err(bad) => bad,
            };
            if self.part == Part::Own && self.header.iter().any(|one| self.is_line(one)) {
                self.counts.skipped += 1;
                continue;
            }
            self.counts.refused += 1;
            return Some(Err(LoadsError::Row(bad)));
        }
    }

    /// Whether the line is blank or a comment.
    fn says_nothing(&self) -> bool {
        let mark = self.layout.comment.as_ref();
        let text = self.line.text.trim_ascii_start();
        mark.is_some_and(|mark| text.starts_with(mark.as_bytes())) || self.line.is_blank()
    }

    fn is_line(&self, line: &[u8]) -> bool {
        self.line.text.trim_ascii() == line
    }

    /// Whether the line is the header's first one again, or one of its others behind that. The first one ends another file.
    fn is_header_again(&mut self) -> bool {
        if self.header.first().is_some_and(|first| self.is_line(first)) {
            self.again = 1;
            if self.part == Part::Other {
                self.part = Part::Own;
            }
            return true;
        }
        let next = self.header.get(self.again).filter(|_| self.again > 0);
        let is_next = next.is_some_and(|next| self.is_line(next));
        self.again = if is_next { self.again + 1 } else { 0 };
        is_next
    }

    /// A line as a row, or why it is none.
    fn read(&mut self, line: &[u8]) -> Result<LoadRow, Box<BadRow>> {
        let refused = |fault| {
            let numbers = [None; OWN.len()];
            Box::new(BadRow { fault, numbers })
        };
        let learns = self.layout.width == 0;
        if learns {
            // Without a header, the first row that is read says how many fields there are.
            let text = line.to_vec();
            let fields = Line { number: 0, text }.fields(self.layout.separator);
            self.layout.set_names(fields);
            if let Err(why) = self.layout.place() {
                self.layout.set_names(Vec::new());
                return Err(refused(self.fault(1, None, format!("the line has {why}"))));
            }
        }
        let clock = self.clock;
        let rows = self.counts.read + self.counts.refused;
        let mut numbers = [None; OWN.len()];
        for (number, source) in numbers.iter_mut().zip(&self.layout.sources) {
            *number = match source {
                Source::Given(value) => Some(*value),
                Source::Rate(rate) => Some(rows as f64 / rate),
                _ => None,
            };
        }
        let (mut bad, mut more, mut words, mut columns) = (None, false, 0, 0);
        let (layout, time) = (&self.layout, &mut self.clock);
        let mut probes = [None; MOST_PROBES];
        let width = layout.width;
        let count = split(line, layout.separator, |i, bytes| {
            more |= i >= width && !bytes.is_empty();
            let Some(Some(of)) = layout.of_field.get(i).copied() else {
                return;
            };
            if let Some(reading) = of.checked_sub(OWN.len()).map(|i| &mut probes[i]) {
                match layout.reading(bytes, of) {
                    Ok(read) => *reading = read,
                    Err(message) => {
                        bad.get_or_insert((i + 1, Some(of), message));
                    }
                }
                return;
            }
            columns += 1;
            match layout.number(bytes, of, time) {
                Ok(number) => numbers[of] = Some(number),
                Err(message) => {
                    words += usize::from(is_word(bytes));
                    bad.get_or_insert((i + 1, Some(of), message));
                }
            }
        });
        let last = layout.of_field.iter().rposition(Option::is_some);
        let needed = if layout.short_rows {
            last.map_or(0, |last| last + 1)
        } else {
            width
        };
        let lost = match count {
            Err((field, message)) => Some((field, None, message.to_owned())),
            Ok(count) if count < needed => {
                let of = layout.of_field.get(count).copied().flatten();
                let message = format!("the line ends after {count} of {width} fields");
                Some((count + 1, of, message))
            }
            Ok(count) if more => {
                let whose = if layout.names.is_empty() {
                    "first row"
                } else {
                    "header"
                };
                let message = format!("the line has {count} fields where the {whose} has {width}");
                Some((width + 1, None, message))
            }
            Ok(_) => None,
        };
        let described = layout.of_field.iter().flatten();
        let described = described.filter(|of| **of < OWN.len()).count();
        let is_header = words == described && columns == described && described > 0;
        // A word in the only column that is read may be a sensor's.
        if is_header && (described > 1 || !has_number(line, layout.separator)) {
            self.begin_part(line);
        }
        if self.part != Part::Own {
            if bad.is_none() && lost.is_none() {
                self.part = Part::Other;
            }
            self.clock = clock;
            let message = "the line belongs to another file";
            return Err(refused(self.fault(1, None, message)));
        }
        let is_lost = lost.is_some();
        // Where numbers are readable, the first bad one says more than a wrong count.
        if let Some((field, of, message)) = bad.or(lost) {
            self.clock = clock;
            if learns {
                self.layout.set_names(Vec::new());
            }
            return Err(Box::new(BadRow {
                fault: self.fault(field, of, message),
                numbers: numbers.map(|number| number.filter(|_| !is_lost)),
            }));
        }
        for ((least, most), number) in self.ranges.iter_mut().zip(numbers) {
            let number = number.unwrap_or(f64::NAN);
            (*least, *most) = (least.min(number), most.max(number));
        }
        let [time, fx, fy, fz, my, mz, speed, inner, outer] = numbers;
        let is = Option::unwrap_or_default;
        let first = self.times.map_or(is(time), |(first, _)| first);
        self.times = Some((first, is(time))).filter(|_| first.is_finite());
        Ok(LoadRow {
            time_s: is(time),
            load: [fx, fy, fz, my, mz].map(is),
            speed_rpm: is(speed),
            temperatures: inner.zip(outer).map(<[f64; 2]>::from),
            probes,
        })
    }

    /// A line with a word in every column that is read begins another file, unless it is one of the header's.
    fn begin_part(&mut self, line: &[u8]) {
        let line = line.trim_ascii();
        if self.header.iter().any(|one| line == one) {
            return;
        }
        self.part = match self.preamble.iter().any(|one| line == one) {
            true => self.part.max(Part::Other),
            false => Part::Strange,
        };
        let ours = self.header.first().map_or(String::new(), |one| text(one));
        let (number, other, ours) = (self.line.number, shown(&text(line)), shown(&ours));
        self.told[0].get_or_insert_with(|| {
            format!("line {number} begins another file, {other}, not {ours}: its rows are refused until that comes again")
        });
    }
}

impl Layout {
    /// Takes the names of the columns, without empty ones behind the last.
    fn set_names(&mut self, mut names: Vec<String>) {
        let last = names.iter().rposition(|name| !name.is_empty());
        if let Some(last) = last {
            names.truncate(last + 1);
        }
        self.width = names.len();
        self.names = names;
        self.of_field.clear();
    }

    /// Finds the field of each quantity, or says which column there is not.
    fn place(&mut self) -> Result<(), String> {
        self.of_field = vec![None; self.width];
        let quantities = self.sources.iter().map(|source| match source {
            Source::Column(column) => Some(&column.name),
            _ => None,
        });
        let probes = self.probes.iter();
        let probes = probes.map(|probe| probe.as_ref().map(|column| &column.name));
        for (of, name) in quantities.chain(probes).enumerate() {
            let Some(name) = name else { continue };
            let field = self.field(name)?;
            if let Some(other) = self.of_field[field].replace(of) {
                let (one, other) = (self.key(of), self.key(other));
                return Err(format!("one column for {other} and {one},"));
            }
        }
        Ok(())
    }

    /// Key of a quantity or a probe in a description.
    fn key(&self, of: usize) -> String {
        match (OWN.get(of), self.probes.get(of.wrapping_sub(OWN.len()))) {
            (Some(own), _) => own.name().to_owned(),
            (_, Some(Some(column))) => format!("probe.{}", column.probe),
            _ => String::new(),
        }
    }

    /// The field of a column.
    fn field(&self, name: &Name) -> Result<usize, String> {
        match name {
            Name::Number(number) if (1..=self.width).contains(number) => Ok(number - 1),
            Name::Number(number) => Err(format!(
                "{} columns, and not the column {number}",
                self.width
            )),
            Name::Text(name) => {
                let mut fields = (0..self.width).filter(|i| self.names[*i] == *name);
                match (fields.next(), fields.next()) {
                    (Some(field), None) => Ok(field),
                    (Some(_), Some(_)) => Err(format!(
                        "two columns {}: their numbers are wanted instead",
                        shown(name)
                    )),
                    (None, _) => {
                        let names = listed(&self.names);
                        Err(format!(
                            "the columns {names}, and not the column {}",
                            shown(name)
                        ))
                    }
                }
            }
        }
    }

    /// The reading of a probe, um; none of an empty field.
    fn reading(&self, bytes: &[u8], of: usize) -> Result<Option<f64>, String> {
        let column = self.probes[of - OWN.len()].as_ref();
        let text = text(bytes);
        let text = text.trim_matches('"');
        if text.is_empty() {
            return Ok(None);
        }
        let value = number(text, self.decimal);
        let value = value.ok_or_else(|| format!("{} is not a number", shown(text)))?;
        Ok(column.map(|column| column.factor * value))
    }

    /// The number in a field, or the field's fault.
    fn number(&self, bytes: &[u8], of: usize, clock: &mut Clock) -> Result<f64, String> {
        let Source::Column(column) = &self.sources[of] else {
            return Err(String::new());
        };
        if bytes.is_empty() {
            return Err("the field is empty; a number is needed".to_owned());
        }
        let written;
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text,
            Err(_) => {
                written = text(bytes);
                &written
            }
        };
        // A blank before a quotation mark leaves it in the field.
        let text = text
            .strip_prefix('"')
            .and_then(|text| text.strip_suffix('"'))
            .unwrap_or(text);
        let Some(unit) = column.unit else {
            let time = clock.read(text);
            return time
                .ok_or_else(|| format!("{} is no date and time, and no hh:mm:ss", shown(text)));
        };
        let behind = |text: &str| {
            // A time may have its unit behind it.
            let (text, name) = text.split_once(' ').filter(|_| OWN[of] == Quantity::Time)?;
            number(text, self.decimal).filter(|_| Unit::named(name) == Some(unit))
        };
        let Some(value) = number(text, self.decimal).or_else(|| behind(text)) else {
            let are_digits = text
                .chars()
                .all(|c| c.is_ascii_digit() || "+-,.'\u{2019}\u{a0}\u{202f} ".contains(c));
            let hint = match self.decimal {
                b',' if are_digits => " with a decimal comma and without thousands separators",
                _ if are_digits => " with a decimal point and without thousands separators",
                _ => "",
            };
            return Err(format!("{} is not a number{hint}", shown(text)));
        };
        let value = column.factor * unit.read(value);
        match unit.dimension {
            Dimension::Temperature => celsius(value),
            Dimension::Time if !TIMES.contains(&value) => {
                let (text, [first, last]) = (shown(text), [TIMES.start(), TIMES.end()]);
                Err(format!(
                    "{text} is no time; give seconds from {first:e} to {last:e}"
                ))
            }
            _ => Ok(value),
        }
    }
}

/// Clock times as seconds since the midnight before the first row.
#[derive(Debug, Clone, Copy, Default)]
struct Clock {
    first: Option<Date>,
    last: f64,
    /// Seconds of the days that have passed, where times have no date.
    days: f64,
}

impl Clock {
    fn read(&mut self, text: &str) -> Option<f64> {
        let of_day = |time: Time| {
            let whole = time.duration_since(Time::midnight());
            whole.as_secs_f64()
        };
        if let Some(time) = as_time(text) {
            let time = of_day(time);
            // Half a day back is the next day.
            if self.days + time < self.last - 43_200.0 {
                self.days += 86_400.0;
            }
            self.last = self.days + time;
            return Some(self.last);
        }
        let moment = as_date(text)?;
        let first = *self.first.get_or_insert(moment.date());
        let days = moment.date().duration_since(first).as_secs_f64();
        Some(days + of_day(moment.time()))
    }
}

/// A time of day, `16:39:25.617` or with a comma.
fn as_time(text: &str) -> Option<Time> {
    let is_clock = text.contains(':') && !text.contains(['-', 'T', ' ']);
    let hour = if text.find(':') == Some(1) { "0" } else { "" };
    let text = format!("{hour}{}", text.replace(',', "."));
    text.parse().ok().filter(|_| is_clock)
}

/// A date and time by ISO 8601, or as Germany writes it.
fn as_date(text: &str) -> Option<DateTime> {
    if !text.contains(':') {
        return None;
    }
    let text = text.replace(',', ".");
    let in_zone = || text.parse::<jiff::Timestamp>().ok();
    let of_utc = || in_zone().map(|time| jiff::tz::Offset::UTC.to_datetime(time));
    let german = || DateTime::strptime("%d.%m.%Y %H:%M:%S%.f", &text).ok();
    let slashed = || DateTime::strptime("%Y/%m/%d %H:%M:%S%.f", &text).ok();
    // A time with its zone is a time without one, too: its zone is read first.
    let plain = || text.parse().ok();
    of_utc().or_else(plain).or_else(german).or_else(slashed)
}

/// Whether a field may be a date or a clock time in any form.
fn may_be_time(field: &str) -> bool {
    let is_digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    let is_clock = |(before, behind): (&str, &str)| {
        is_digit(before.chars().next_back()) && is_digit(behind.chars().next())
    };
    let is_date = |mark: char| {
        let date = field.split(' ').next().unwrap_or_default();
        let parts: Vec<&str> = date.split(mark).collect();
        let numbers = parts
            .iter()
            .filter(|part| part.parse::<u32>().is_ok())
            .count();
        parts.len() == 3 && numbers > 1
    };
    field.split_once(':').is_some_and(is_clock) || ['-', '/', '.'].into_iter().any(is_date)
}

/// A word, as names and units are: nothing that begins as a number, but `1/min`.
fn is_word(field: &[u8]) -> bool {
    let text = text(field);
    let begins = text.starts_with(|c: char| c.is_ascii_digit() || "+-.,".contains(c));
    let has_letters = text.contains(char::is_alphabetic);
    has_letters && (!begins || Unit::named(&text).is_some()) && number(&text, b'.').is_none()
}

fn has_number(line: &[u8], separator: u8) -> bool {
    let mut found = false;
    let _ = split(line, separator, |_, field| {
        found |= number(&text(field), b'.').is_some()
    });
    found
}

/// Whether a field is a time of day, or a date with it.
pub(crate) fn is_clock(field: &str) -> bool {
    as_time(field).is_some() || as_date(field).is_some()
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
