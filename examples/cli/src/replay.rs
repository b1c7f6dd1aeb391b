//! Recorded loads and speed in, displacements and stiffness out, as tables. `cargo replay` is around it.

use crate::fault::{BadRow, LoadsError};
use crate::lifetime::{Lifetime, Record};
use rayon::ThreadPool;
use rayon::prelude::*;
use solvers::dispatch::Precision;
use solvers::{Answer, AnySolver, AtEnd, Choices, RowAnswer, parts};
use spindle_bearing::{Design, Frequencies, LifeRating, RatingLife, Speed};
use spindle_file::loads::LoadRow;
use spindle_file::noses::Nose;
use spindle_file::spindles::SpindleFile;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::{self, Write as _};
use std::io::{self, Write};
use std::slice::IterMut;

/// Names of the five freedoms in column names.
const FREEDOMS: [&str; 5] = ["x", "y", "z", "ty", "tz"];

/// Names of the five columns of a matrix's diagonal.
fn of_diagonal(matrix: &str) -> Vec<String> {
    let names = FREEDOMS.iter().map(|i| format!("{matrix}_{i}_{i}"));
    names.collect()
}

/// Names of the 25 columns of a matrix.
fn of_pairs(matrix: &str) -> Vec<String> {
    let pairs = (0..25).map(|i| (FREEDOMS[i / 5], FREEDOMS[i % 5]));
    pairs.map(|(i, j)| format!("{matrix}_{i}_{j}")).collect()
}

fn texts(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}

/// Columns of a displacement.
const MOTION: [&str; 5] = ["dx_m", "dy_m", "dz_m", "ty_rad", "tz_rad"];

/// Status of a row of the recording that cannot be read.
pub const REFUSED_INPUT: &str = "refused-input";

/// Records of a block, which begins cold. Half of it: twice the cold solves, which are one in so many now.
const BLOCK: usize = 500;
/// Blocks that are read ahead, for every thread: with fewer, threads wait longer for the last of them.
const AHEAD: usize = 4;

/// A table that a replay writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Table {
    /// Displacement and stiffness, a line for every row of the recording.
    Results,
    /// Load, preload, least contact force, stiffness and motion of every row of a spindle.
    Rows,
    /// Displacement and compliance of every nose.
    Noses,
    /// State of every ball.
    Balls,
    /// Frequencies at which damage of every row is heard.
    Frequencies,
}

impl Table {
    const fn name(self) -> &'static str {
        match self {
            Self::Results => "results",
            Self::Rows => "rows of the spindle",
            Self::Noses => "noses",
            Self::Balls => "ball states",
            Self::Frequencies => "frequencies",
        }
    }

    /// Its columns; with reactions where displacements are `held`.
    fn columns(self, file: &SpindleFile, held: bool) -> Vec<Column> {
        let mut columns = Vec::new();
        let mut add = |names: &[&str], figure: Figure, needs: u8| {
            columns.extend(names.iter().enumerate().map(|(index, name)| Column {
                name: (*name).to_owned(),
                figure,
                index,
                needs,
            }));
        };
        add(&["time_s"], Figure::Copy(0), 0);
        match self {
            Self::Results => {}
            Self::Noses => add(&["nose"], Figure::Nose, 0),
            _ if file.is_bearing => {}
            _ => add(&["row"], Figure::Row, 0),
        }
        match self {
            Self::Results => {
                add(&["status"], Figure::Status, 0);
                add(&["iterations"], Figure::Iterations, 0);
                add(
                    &MOTION,
                    Figure::Answer(|answer, i| answer.displacement[i]),
                    0,
                );
                add(
                    &texts(&of_pairs("k")),
                    Figure::Answer(|answer, i| answer.stiffness[i / 5][i % 5]),
                    0,
                );
                if file.nose().is_some() {
                    // It is the first nose.
                    let stiffness = Figure::AtNose(|at, i| 1.0 / at.compliance[i][i]);
                    add(&texts(&of_diagonal("k_nose")), stiffness, parts::AT);
                }
                add(&["limits"], Figure::Limits, parts::LIMITS);
                let names = ["fx_n", "fy_n", "fz_n", "my_nm", "mz_nm", "speed_rpm"];
                add(&names, Figure::Copy(1), 0);
                add(&["l10_mrev", "l10_h"], Figure::Life, parts::BALLS);
                if file.heat.is_some() {
                    add(&["t_inner_c", "t_outer_c"], Figure::Copy(7), 0);
                }
                if held {
                    let names = [
                        "reaction_fx_n",
                        "reaction_fy_n",
                        "reaction_fz_n",
                        "reaction_my_nm",
                        "reaction_mz_nm",
                    ];
                    add(&names, Figure::Answer(|answer, i| answer.load[i]), 0);
                }
            }
            Self::Rows => {
                let names = ["fx_n", "fy_n", "fz_n", "my_nm", "mz_nm"];
                add(&names, Figure::OfRow(|row, i, _| row.force[i]), 0);
                add(&["preload_n"], Figure::OfRow(|row, _, _| row.preload), 0);
                let least = |row: &RowAnswer, _, _| {
                    let forces = row.balls.iter().map(|ball| ball.q_i);
                    forces.fold(f64::INFINITY, f64::min)
                };
                add(&["least_q_i_n"], Figure::OfRow(least), parts::BALLS);
                let stiffness = Figure::OfRow(|row, i, _| row.stiffness_on_shaft[i / 5][i % 5]);
                add(&texts(&of_pairs("k_row")), stiffness, 0);
                add(&MOTION, Figure::OfRow(|row, i, _| row.displacement[i]), 0);
                let closure = Figure::OfRow(|row, _, _| 1e6 * row.closure);
                add(&["closure_um"], closure, 0);
                add(&["l10_mrev", "l10_h"], Figure::RowLife, parts::BALLS);
            }
            Self::Noses => {
                add(
                    &MOTION,
                    Figure::AtNose(|at, i| at.displacement[i]),
                    parts::AT,
                );
                let compliance = Figure::AtNose(|at, i| at.compliance[i / 5][i % 5]);
                add(&texts(&of_pairs("c")), compliance, parts::AT);
                let error = Figure::AtNose(|at, i| at.compliance_error[i]);
                let names = [
                    "c_error_x",
                    "c_error_y",
                    "c_error_z",
                    "c_error_ty",
                    "c_error_tz",
                ];
                add(&names, error, parts::AT);
            }
            Self::Balls => {
                add(&["ball"], Figure::Ball, 0);
                for (name, of) in BALLS {
                    add(&[name], Figure::OfRow(of), parts::BALLS | parts::MOTIONS);
                }
            }
            Self::Frequencies => {
                let all = |row: &RowAnswer, i: usize, _| {
                    let found = &row.frequencies;
                    [found.cage, found.outer_race, found.inner_race, found.ball][i]
                };
                let names = ["cage_hz", "outer_race_hz", "inner_race_hz", "ball_hz"];
                add(&names, Figure::OfRow(all), parts::FREQUENCIES);
            }
        }
        columns
    }
}

/// A figure of a ball.
type OfRow = fn(&RowAnswer, usize, usize) -> f64;

/// Figures of a ball, by its row and its number.
#[rustfmt::skip]
const BALLS: [(&str, OfRow); 17] = [
    ("azimuth_rad", |row, _, ball| row.balls[ball].azimuth),
    ("alpha_i_rad", |row, _, ball| row.balls[ball].alpha_i),
    ("alpha_o_rad", |row, _, ball| row.balls[ball].alpha_o),
    ("q_i_n", |row, _, ball| row.balls[ball].q_i),
    ("q_o_n", |row, _, ball| row.balls[ball].q_o),
    ("fc_n", |row, _, ball| row.balls[ball].centrifugal_force),
    ("mg_nm", |row, _, ball| row.balls[ball].gyroscopic_moment),
    ("p_i_pa", |row, _, ball| row.motions[ball].inner.peak_pressure),
    ("p_o_pa", |row, _, ball| row.motions[ball].outer.peak_pressure),
    ("a_i_m", |row, _, ball| row.motions[ball].inner.semi_major),
    ("b_i_m", |row, _, ball| row.motions[ball].inner.semi_minor),
    ("a_o_m", |row, _, ball| row.motions[ball].outer.semi_major),
    ("b_o_m", |row, _, ball| row.motions[ball].outer.semi_minor),
    ("cage_rad_s", |row, _, ball| row.motions[ball].cage_speed),
    ("attitude_rad", |row, _, ball| row.motions[ball].attitude),
    ("spin_roll_i", |row, _, ball| row.motions[ball].inner.spin_to_roll),
    ("spin_roll_o", |row, _, ball| row.motions[ball].outer.spin_to_roll),
];

/// The figures of a column.
#[derive(Clone, Copy)]
enum Figure {
    Status,
    Iterations,
    Limits,
    Row,
    Nose,
    Ball,
    /// A number of the recording from this one on, never rounded to the solver's precision: time identifies the row.
    Copy(usize),
    /// Million revolutions or hours of all rows, in single precision; empty if there is no end of it.
    Life,
    /// Million revolutions or hours of one row, likewise.
    RowLife,
    /// A number of the answer, in the precision of the solve, by the column's index.
    Answer(fn(&Answer, usize) -> f64),
    /// A number at a nose, by the column's index.
    AtNose(fn(&AtEnd, usize) -> f64),
    /// A number of a row, by the column's index and the ball.
    OfRow(OfRow),
}

/// A column of a table, with its index among those of the same figure.
struct Column {
    name: String,
    figure: Figure,
    index: usize,
    /// The [`parts`] of an answer that it shows.
    needs: u8,
}

/// The record, the row or the nose, and the ball of a line.
struct Line<'l> {
    given: &'l [Option<f64>; 9],
    answer: Result<&'l Answer, &'static str>,
    /// Weights of the rows for the life, if that is wanted.
    weights: Option<&'l [f64]>,
    omega: f64,
    noses: &'l [Nose],
    row: usize,
    ball: usize,
}

/// The columns of these names: in full, or without marks and unit where that is one column, such as `kxx` and `dx`.
fn select(columns: Vec<Column>, names: &[String]) -> Result<Vec<Column>, String> {
    let plain = |name: &str| name.trim().replace('_', "").to_lowercase();
    let mut columns: Vec<Option<Column>> = columns.into_iter().map(Some).collect();
    let all: Vec<String> = columns
        .iter()
        .flatten()
        .map(|column| column.name.clone())
        .collect();
    let mut selected = Vec::new();
    for name in names {
        let short = |one: &String| {
            one.rsplit_once('_')
                .map_or("", |(short, _)| short)
                .to_owned()
        };
        let ways: [&dyn Fn(&String) -> bool; 3] = [
            &|one| one == name,
            &|one| plain(one) == plain(name),
            &|one| plain(&short(one)) == plain(name),
        ];
        let found = ways.iter().find_map(|is| {
            let mut found = (0..all.len()).filter(|i| is(&all[*i]));
            found.next().filter(|_| found.next().is_none())
        });
        let column =
            found.ok_or_else(|| format!("no column {name}: there are {}", all.join(", ")))?;
        selected.push(
            columns[column]
                .take()
                .ok_or_else(|| format!("{name} is given twice"))?,
        );
    }
    Ok(selected)
}

/// A table that is wanted, and which of its columns; all if none are named.
pub type Wanted<'w> = (Table, &'w [String]);

/// A table that is wanted, and where it goes.
pub type Output<'o> = (Table, Box<dyn Write + Send + 'o>);

/// How a recording is replayed.
pub struct Job<'j> {
    /// The spindle.
    pub file: &'j SpindleFile,
    /// The solver's precision.
    pub precision: Precision,
    /// Solve every row from scratch.
    pub cold: bool,
    /// The balls are at rest.
    pub at_rest: bool,
    /// Columns of the results; all if there are none.
    pub select: Vec<String>,
    /// Limits, tolerance and iterations.
    pub choices: Choices,
    /// Displacements at `x = 0` that are given in the place of loads, m and rad.
    pub held: [Option<f64>; 5],
    /// A record counts until the next one, however long the logger paused.
    pub holds_pauses: bool,
    /// Sums over the whole recording.
    pub lifetime: Option<&'j mut Lifetime>,
}

/// Reason why a replay stopped.
#[derive(Debug)]
pub enum ReplayError {
    /// The recording is at fault.
    Loads(LoadsError),
    /// The selected columns are.
    Select(String),
    /// A table cannot be written.
    Output(Table, io::Error),
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Loads(error) => error.fmt(f),
            Self::Select(error) => write!(f, "--select: {error}"),
            Self::Output(table, error) => {
                write!(f, "the {} cannot be written: {error}", table.name())
            }
        }
    }
}

impl std::error::Error for ReplayError {}

/// How a replay went.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Summary {
    /// Rows replayed.
    pub rows: u64,
    /// Rows without an answer, by status.
    pub refused: BTreeMap<&'static str, u64>,
    /// Time of the first row that the solver has no answer to, and why.
    pub first_refusal: Option<(f64, String)>,
    /// Fault of the first row that cannot be read.
    pub first_fault: Option<String>,
}

impl Summary {
    /// Adds the rows that follow.
    fn add(&mut self, next: Self) {
        self.rows += next.rows;
        for (status, count) in next.refused {
            *self.refused.entry(status).or_default() += count;
        }
        self.first_refusal = self.first_refusal.take().or(next.first_refusal);
        self.first_fault = self.first_fault.take().or(next.first_fault);
    }

    /// Rows of the recording could be read, if it has any.
    pub fn any_row_read(&self) -> bool {
        self.rows == 0 || self.refused.get(REFUSED_INPUT) != Some(&self.rows)
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let total: u64 = self.refused.values().sum();
        let have = if total == 1 { "has" } else { "have" };
        write!(f, "{total} of {} rows {have} no answer", self.rows)?;
        for (i, (status, count)) in self.refused.iter().enumerate() {
            let separator = if i == 0 { ": " } else { ", " };
            write!(f, "{separator}{count} {status}")?;
        }
        let mut start = " (";
        if let Some((time, why)) = &self.first_refusal {
            write!(f, "{start}the first at {time} s: {why}")?;
            start = "; ";
        }
        if let Some(fault) = &self.first_fault {
            write!(f, "{start}the first that cannot be read: {fault}")?;
        }
        f.write_str(if total == 0 { "" } else { ")" })
    }
}

/// A table that is made.
struct Sheet {
    table: Table,
    columns: Vec<Column>,
}

/// Where the fields of a table go.
trait Fields {
    fn word(&mut self, word: &str);

    fn count(&mut self, count: usize);

    fn number(&mut self, x: f64, precision: Precision);

    /// A life, in single precision.
    fn life(&mut self, life: f64);

    fn empty(&mut self);

    fn end_line(&mut self) {}
}

/// CSV. Writing to a string does not fail.
impl Fields for String {
    fn word(&mut self, word: &str) {
        let _ = write!(self, "{word},");
    }

    fn count(&mut self, count: usize) {
        let _ = write!(self, "{count},");
    }

    fn number(&mut self, x: f64, precision: Precision) {
        let _ = precision.write(self, x);
        self.push(',');
    }

    fn life(&mut self, life: f64) {
        match life.is_finite() {
            true => self.number(life, Precision::F32),
            false => self.empty(),
        }
    }

    fn empty(&mut self) {
        self.push(',');
    }

    fn end_line(&mut self) {
        self.pop();
        self.push('\n');
    }
}

/// A block's part of a table in memory.
struct Part<'p> {
    numbers: IterMut<'p, f64>,
    words: Vec<String>,
}

impl Fields for Part<'_> {
    fn word(&mut self, word: &str) {
        self.words.push(word.to_owned());
    }

    fn count(&mut self, count: usize) {
        self.number(count as f64, Precision::F64);
    }

    fn number(&mut self, x: f64, _: Precision) {
        if let Some(place) = self.numbers.next() {
            *place = x;
        }
    }

    fn life(&mut self, life: f64) {
        self.number(f64::from(life as f32), Precision::F32);
    }

    fn empty(&mut self) {
        self.number(f64::NAN, Precision::F64);
    }
}

impl Column {
    fn is_word(&self) -> bool {
        matches!(self.figure, Figure::Status | Figure::Limits | Figure::Nose)
    }

    fn add(&self, to: &mut impl Fields, line: &Line<'_>, precision: Precision) {
        let index = self.index;
        match (self.figure, line.answer) {
            (Figure::OfRow(of), Ok(answer)) => {
                to.number(of(&answer.rows[line.row], index, line.ball), precision)
            }
            (Figure::Row, _) => to.count(line.row),
            (Figure::Nose, _) => to.word(&line.noses[line.row].name),
            (Figure::Ball, _) => to.count(line.ball),
            (Figure::Copy(first), _) => match line.given[first + index] {
                Some(x) => to.number(x, Precision::F64),
                None => to.empty(),
            },
            (Figure::Status, Err(status)) => to.word(status),
            (Figure::Limits, Err(_)) => to.word(""),
            (_, Err(_)) => to.empty(),
            (Figure::Status, Ok(answer)) => to.word(answer.status.name()),
            (Figure::Iterations, Ok(answer)) => to.count(answer.iterations.into()),
            (Figure::Limits, Ok(answer)) => to.word(&answer.passed().join(" ")),
            (Figure::Life, Ok(_)) => to.life(line.life(|weights| weights.iter().sum())[index]),
            (Figure::RowLife, Ok(_)) => to.life(line.life(|weights| weights[line.row])[index]),
            (Figure::Answer(of), Ok(answer)) => to.number(of(answer, index), precision),
            (Figure::AtNose(of), Ok(answer)) => {
                to.number(of(&answer.at[line.row], index), precision)
            }
        }
    }
}

impl Line<'_> {
    /// Basic rating life, million revolutions and hours, of this weight of the rows.
    fn life(&self, weight: impl Fn(&[f64]) -> f64) -> [f64; 2] {
        let weight = weight(self.weights.unwrap_or_default());
        let life = RatingLife::of_weight(weight, self.omega);
        [life.million_revolutions, life.hours]
    }
}

impl Sheet {
    fn of(job: &Job<'_>, (table, names): Wanted<'_>) -> Result<Self, ReplayError> {
        let mut columns = table.columns(job.file, job.held != [None; 5]);
        if !names.is_empty() {
            columns = select(columns, names).map_err(ReplayError::Select)?;
        }
        Ok(Self { table, columns })
    }

    fn title(&self) -> Vec<&str> {
        self.columns
            .iter()
            .map(|column| column.name.as_str())
            .collect()
    }

    /// Lines that each record has.
    fn lines(&self, file: &SpindleFile) -> usize {
        match self.table {
            Table::Results => 1,
            Table::Noses => file.noses.len(),
            Table::Balls => file.plan.rows.iter().map(|row| row.balls).sum(),
            Table::Rows | Table::Frequencies => file.plan.rows.len(),
        }
    }

    /// Adds the lines of a record.
    fn add(&self, to: &mut impl Fields, mut line: Line<'_>, replay: &Replay<'_>) {
        let rows = &replay.file.plan.rows;
        let count = match self.table {
            Table::Results => 1,
            Table::Noses => line.noses.len(),
            _ => rows.len(),
        };
        for row in 0..count {
            let balls = match self.table {
                Table::Balls => rows[row].balls,
                _ => 1,
            };
            for ball in 0..balls {
                (line.row, line.ball) = (row, ball);
                for column in &self.columns {
                    column.add(to, &line, replay.precision);
                }
                to.end_line();
            }
        }
    }
}

/// A record of a block, or a row that cannot be read.
type Read = Result<LoadRow, Box<BadRow>>;

/// A block of the recording, solved.
struct Solved<F> {
    /// Lines of every table.
    tables: Vec<F>,
    summary: Summary,
    records: Vec<Record>,
    /// Records without an answer, counted from the block's first, and why.
    refusals: Vec<(usize, String)>,
}

impl<F> Solved<F> {
    fn of(tables: Vec<F>) -> Self {
        Self {
            tables,
            summary: Summary::default(),
            records: Vec::new(),
            refusals: Vec::new(),
        }
    }
}

/// Solves a recording and writes the tables as CSV.
///
/// The recording is cut into blocks of so many records. Each begins cold, and as many are solved side by side as there are
/// threads: the tables are the same for any number of them. After an error, rows before it have been written. A row of the
/// recording that cannot be read has the status [`REFUSED_INPUT`].
///
/// # Errors
///
/// A recording that ends in a fault, columns that there are not, or an output that fails.
pub fn replay(
    mut job: Job<'_>,
    solver: &mut dyn AnySolver,
    rows: impl Iterator<Item = Result<LoadRow, LoadsError>> + Send,
    outputs: Vec<Output<'_>>,
) -> Result<Summary, ReplayError> {
    let lifetime = job.lifetime.take();
    let tables = outputs.iter().map(|(table, _)| match table {
        Table::Results => (*table, &job.select[..]),
        _ => (*table, &[][..]),
    });
    let replay = Replay::of(&job, tables, lifetime.is_some(), solver)?;
    let titles = replay
        .sheets
        .iter()
        .map(|sheet| sheet.title().join(",") + "\n");
    let mut solved = vec![Solved::of(titles.collect())];
    let mut written = Written {
        outs: outputs,
        summary: Summary::default(),
        lifetime,
    };

    let mut solvers: Vec<_> = (0..AHEAD * rayon::current_num_threads())
        .map(|_| solver.copy())
        .collect();
    let most = solvers.len();
    let mut reader = Reader {
        rows: rows.fuse(),
        fault: None,
    };
    let mut read = reader.blocks(most);
    if let Some(lifetime) = written.lifetime.as_mut().filter(|_| !job.holds_pauses) {
        let rows = read.iter().flatten().flatten();
        lifetime.end_at_pauses(rows.map(|row| row.time_s));
    }
    while !read.is_empty() {
        let before = std::mem::take(&mut solved);
        let (next, blocks) = rayon::join(
            || written.add(before).map(|()| reader.blocks(most)),
            || {
                let blocks = solvers.par_iter_mut().zip(&read).with_max_len(1);
                let blocks = blocks.map(|(solver, block)| {
                    let rows = block.iter().map(|row| row.as_ref().map_err(|bad| &**bad));
                    replay.solve(
                        &mut **solver,
                        rows,
                        vec![String::new(); replay.sheets.len()],
                    )
                });
                blocks.collect()
            },
        );
        (read, solved) = (next?, blocks);
    }
    written.add(solved)?;
    for (table, out) in &mut written.outs {
        let flushed = out.flush();
        flushed.map_err(|error| ReplayError::Output(*table, error))?;
    }
    match reader.fault {
        Some(fault) => Err(ReplayError::Loads(fault)),
        None => Ok(written.summary),
    }
}

/// Form of a table of records in memory.
#[derive(Debug)]
pub struct Form {
    /// Names of its columns, and whether they have words.
    pub columns: Vec<(String, bool)>,
    /// Lines that each record has.
    pub lines: usize,
}

impl Form {
    /// Columns of numbers.
    pub fn width(&self) -> usize {
        let numbers = self.columns.iter().filter(|(_, is_word)| !is_word);
        numbers.count()
    }
}

/// Forms of the tables that a job makes.
///
/// # Errors
///
/// Columns that there are not.
pub fn forms(job: &Job<'_>, tables: &[Wanted<'_>]) -> Result<Vec<Form>, ReplayError> {
    let forms = tables.iter().map(|wanted| {
        let sheet = Sheet::of(job, *wanted)?;
        let columns = sheet.columns.iter();
        let columns = columns.map(|column| (column.name.clone(), column.is_word()));
        Ok(Form {
            columns: columns.collect(),
            lines: sheet.lines(job.file),
        })
    });
    forms.collect()
}

/// Fields of words of records in memory, by table, line by line.
pub type Words = Vec<Vec<String>>;

/// Why records have no answer, by their number.
pub type Refusals = Vec<(usize, String)>;

/// Solves records in memory, in the blocks of [`replay`], and so with its bits, on the threads of `pool`.
///
/// Each of the tables has its fields of numbers put into `numbers`, line by line; those of records without an answer are not numbers.
/// After each few blocks, `go_on` is told on this thread how many records are solved. `None` if it has said no.
///
/// # Errors
///
/// As of [`replay`].
pub fn fill(
    mut job: Job<'_>,
    solver: &mut dyn AnySolver,
    rows: &[LoadRow],
    (tables, numbers): (&[Wanted<'_>], Vec<&mut [f64]>),
    (pool, mut go_on): (&ThreadPool, impl FnMut(usize) -> bool),
) -> Result<Option<(Words, Refusals)>, ReplayError> {
    let mut lifetime = job.lifetime.take();
    let replay = Replay::of(&job, tables.iter().copied(), lifetime.is_some(), solver)?;
    if let Some(lifetime) = lifetime.as_mut().filter(|_| !job.holds_pauses) {
        lifetime.end_at_pauses(rows.iter().map(|row| row.time_s));
    }
    let (mut refusals, mut words) = (Vec::new(), vec![Vec::new(); tables.len()]);
    let parts = numbers.into_iter().map(|numbers| {
        let size = numbers.len() / rows.len().max(1);
        numbers.chunks_mut((BLOCK * size).max(1))
    });
    let mut parts: Vec<_> = parts.collect();
    let mut solvers: Vec<_> = (0..AHEAD * pool.current_num_threads())
        .map(|_| solver.copy())
        .collect();
    let mut done = 0;
    for batch in rows.chunks(BLOCK * solvers.len()) {
        let blocks = batch.chunks(BLOCK).map(|block| {
            let parts = parts.iter_mut().map(|part| Part {
                numbers: part.next().unwrap_or_default().iter_mut(),
                words: Vec::new(),
            });
            (block, parts.collect())
        });
        let blocks: Vec<(&[LoadRow], Vec<Part<'_>>)> = blocks.collect();
        let solved: Vec<Solved<Part<'_>>> = pool.install(|| {
            let blocks = solvers.par_iter_mut().zip(blocks).with_max_len(1);
            let solved = blocks.map(|(solver, (block, parts))| {
                replay.solve(&mut **solver, block.iter().map(Ok), parts)
            });
            solved.collect()
        });
        for block in solved {
            for (all, part) in words.iter_mut().zip(block.tables) {
                all.extend(part.words);
            }
            let refused = block.refusals.into_iter();
            refusals.extend(refused.map(|(record, why)| (done + record, why)));
            done += block.summary.rows as usize;
            if let Some(lifetime) = &mut lifetime {
                block.records.into_iter().for_each(|one| lifetime.add(one));
            }
        }
        if !go_on(done) {
            return Ok(None);
        }
    }
    Ok(Some((words, refusals)))
}

/// A recording, in blocks.
struct Reader<I> {
    rows: I,
    /// Fault that it ends in.
    fault: Option<LoadsError>,
}

impl<I: Iterator<Item = Result<LoadRow, LoadsError>>> Reader<I> {
    /// The next blocks, fewer than `most` at the end.
    fn blocks(&mut self, most: usize) -> Vec<Vec<Read>> {
        let blocks = (0..most).map(|_| self.block());
        blocks.take_while(|block| !block.is_empty()).collect()
    }

    fn block(&mut self) -> Vec<Read> {
        let mut block = Vec::with_capacity(BLOCK);
        while block.len() < BLOCK && self.fault.is_none() {
            match self.rows.next() {
                Some(Ok(row)) => block.push(Ok(row)),
                Some(Err(LoadsError::Row(row))) => block.push(Err(row)),
                Some(Err(fault)) => self.fault = Some(fault),
                None => break,
            }
        }
        block
    }
}

/// The tables as far as they are written, and sums over the recording up to there.
struct Written<'w> {
    outs: Vec<Output<'w>>,
    summary: Summary,
    lifetime: Option<&'w mut Lifetime>,
}

impl Written<'_> {
    fn add(&mut self, blocks: Vec<Solved<String>>) -> Result<(), ReplayError> {
        for block in blocks {
            for ((table, out), text) in self.outs.iter_mut().zip(&block.tables) {
                let written = out.write_all(text.as_bytes());
                written.map_err(|error| ReplayError::Output(*table, error))?;
            }
            self.summary.add(block.summary);
            if let Some(lifetime) = &mut self.lifetime {
                block.records.into_iter().for_each(|one| lifetime.add(one));
            }
        }
        Ok(())
    }
}

/// How blocks are solved.
struct Replay<'r> {
    file: &'r SpindleFile,
    held: [Option<f64>; 5],
    precision: Precision,
    cold: bool,
    /// Frequencies are those of balls that roll as they were solved at rest.
    by_angles: bool,
    /// Sums over the recording are wanted.
    is_summed: bool,
    /// Lives are wanted.
    is_weighed: bool,
    ratings: Vec<LifeRating<f64>>,
    sheets: Vec<Sheet>,
}

impl<'r> Replay<'r> {
    /// How a job makes these tables, and sums if it `is_summed`: the solver is told what to work out.
    fn of<'t>(
        job: &Job<'r>,
        tables: impl Iterator<Item = Wanted<'t>>,
        is_summed: bool,
        solver: &mut dyn AnySolver,
    ) -> Result<Self, ReplayError> {
        let sheets = tables.map(|wanted| Sheet::of(job, wanted));
        let sheets = sheets.collect::<Result<Vec<_>, _>>()?;
        let columns = || sheets.iter().flat_map(|sheet: &Sheet| &sheet.columns);
        let mut wanted = columns().fold(0, |all, column| all | column.needs);
        if is_summed {
            wanted |= parts::LIMITS | parts::BALLS | parts::MOTIONS;
        }
        let by_angles = job.at_rest && wanted & parts::FREQUENCIES != 0;
        wanted |= if by_angles { parts::BALLS } else { 0 };
        solver.choose(&Choices {
            parts: wanted,
            ..job.choices
        });
        let has_life =
            columns().any(|column| matches!(column.figure, Figure::Life | Figure::RowLife));
        Ok(Self {
            file: job.file,
            held: job.held,
            precision: job.precision,
            cold: job.cold,
            by_angles,
            is_summed,
            is_weighed: is_summed || has_life,
            ratings: job.file.ratings(),
            sheets,
        })
    }

    /// Solves a block, from a cold start on.
    fn solve<'b, F: Fields>(
        &self,
        solver: &mut dyn AnySolver,
        block: impl Iterator<Item = Result<&'b LoadRow, &'b BadRow>>,
        tables: Vec<F>,
    ) -> Solved<F> {
        let mut solved = Solved::of(tables);
        solver.reset();
        for row in block {
            if self.cold {
                solver.reset();
            }
            self.add(solver, row, &mut solved);
        }
        solved
    }

    /// Solves a record, and adds its lines.
    fn add<F: Fields>(
        &self,
        solver: &mut dyn AnySolver,
        row: Result<&LoadRow, &BadRow>,
        solved: &mut Solved<F>,
    ) {
        let (file, summary) = (self.file, &mut solved.summary);
        summary.rows += 1;
        let (given, mut answer) = match row {
            Ok(row) => {
                let mut question = file.question(row);
                question.held = self.held;
                let answer = solver.solve(&question);
                let answer = answer.map_err(|status| {
                    let why = status.to_string();
                    let first = || (row.time_s, why.clone());
                    summary.first_refusal.get_or_insert_with(first);
                    solved.refusals.push((summary.rows as usize - 1, why));
                    status.name()
                });
                let [fx, fy, fz, my, mz] = row.load;
                let [inner, outer] = row.temperatures.map_or([None; 2], |both| both.map(Some));
                let given = [row.time_s, fx, fy, fz, my, mz, row.speed_rpm].map(Some);
                let [time, fx, fy, fz, my, mz, speed] = given;
                ([time, fx, fy, fz, my, mz, speed, inner, outer], answer)
            }
            Err(row) => {
                let fault = || row.fault.clone();
                summary.first_fault.get_or_insert_with(fault);
                (row.numbers, Err(REFUSED_INPUT))
            }
        };
        if let Err(status) = &answer {
            *summary.refused.entry(status).or_default() += 1;
        }
        let omega = Speed::rpm(given[6].unwrap_or(0.0)).as_rad_per_s();
        if let (Ok(answer), true) = (&mut answer, self.by_angles) {
            for (row, of) in answer.rows.iter_mut().zip(&file.plan.rows) {
                row.frequencies = at_rest(&of.design, row, omega);
            }
        }
        let answer = answer.as_ref().map_err(|status| *status);
        let weighed = answer.ok().filter(|_| self.is_weighed);
        let weighed = weighed.map(|answer| (answer, weights(answer, &self.ratings)));
        let weighed = weighed
            .as_ref()
            .map(|(answer, weights)| (*answer, &weights[..]));
        if self.is_summed {
            let record = Record::new(given[0], omega, weighed);
            solved.records.push(record);
        }
        for (sheet, table) in self.sheets.iter().zip(&mut solved.tables) {
            let line = Line {
                given: &given,
                answer,
                weights: weighed.map(|(_, weights)| weights),
                omega,
                noses: &file.noses,
                row: 0,
                ball: 0,
            };
            sheet.add(table, line, self);
        }
    }
}

/// Weights of the rows for the rating life of the set.
fn weights(answer: &Answer, ratings: &[LifeRating<f64>]) -> Vec<f64> {
    let rows = answer.rows.iter().zip(ratings);
    let weights = rows
        .map(|(row, rating)| rating.weight_of(row.balls.iter().map(|ball| (ball.q_i, ball.q_o))));
    weights.collect()
}

/// Frequencies of a row whose balls were solved at rest: the balls roll with their contact angles, inner and outer ones being
/// equal without inertia.
fn at_rest(design: &Design, row: &RowAnswer, omega: f64) -> Frequencies<f64> {
    let held: Vec<_> = row.balls.iter().filter(|ball| ball.q_i > 0.0).collect();
    let mean = |of: &dyn Fn(f64) -> f64| {
        let sum: f64 = held.iter().map(|ball| of(ball.alpha_i.cos())).sum();
        sum / held.len().max(1) as f64
    };
    let (tau, count) = (
        design.ball_diameter / design.pitch_diameter,
        row.balls.len() as f64,
    );
    let turns = omega / TAU;
    let mut found = Frequencies::default();
    found.cage = turns * mean(&|cos| 0.5 * (1.0 - tau * cos));
    found.ball = turns * mean(&|cos| 0.5 / tau * (1.0 - (tau * cos).powi(2)));
    found.outer_race = count * found.cage.abs();
    found.inner_race = count * (turns - found.cage).abs();
    found
}
