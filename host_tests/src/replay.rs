//! Recorded loads and speed in, displacements and stiffness out, as tables. `cargo replay` is around it.

use crate::dispatch::{AnySolver, Precision};
use crate::loads::{Fault, LoadRow, LoadsError};
use spindle_bearing::{BallState, LimitSet};
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Write};

/// Names of the five freedoms in column names.
const FREEDOMS: [&str; 5] = ["x", "y", "z", "ty", "tz"];

/// Header of the file of rows.
const ROW_HEADER: &str = "time_s,row,fx_n,fy_n,fz_n,my_nm,mz_nm,preload_n,least_q_i_n";

/// Columns of the file of ball states, after those that say when and in which row.
const BALL_COLUMNS: &str = "ball,azimuth_rad,alpha_i_rad,alpha_o_rad,q_i_n,q_o_n,fc_n,mg_nm";
/// Number of figures of a ball.
const BALL_FIGURES: usize = 7;

/// Status of a row of the recording that cannot be read.
pub const REFUSED_INPUT: &str = "refused-input";

/// Header of the results; with the stiffness at the nose, if there is one.
fn header(nose: bool) -> String {
    let mut header = "time_s,status,iterations,dx_m,dy_m,dz_m,ty_rad,tz_rad".to_owned();
    for place in ["k", "k_nose"].iter().take(if nose { 2 } else { 1 }) {
        for row in FREEDOMS {
            for column in FREEDOMS {
                header.push_str(&format!(",{place}_{row}_{column}"));
            }
        }
    }
    header.push_str(",limits");
    header
}

/// What is replayed: one bearing, or a spindle.
pub trait Replayed {
    /// Number of balls of each row.
    fn balls(&self) -> Vec<usize>;

    /// Whether it is a spindle, whose rows the tables number.
    fn is_spindle(&self) -> bool;

    /// Whether the stiffness at the nose is wanted.
    fn has_nose(&self) -> bool;

    /// Precision.
    fn precision(&self) -> Precision;

    /// Makes the next solve a cold one.
    fn reset(&mut self);

    /// Solves for a row of the recording, with what the rows of balls carry if that is wanted.
    ///
    /// # Errors
    ///
    /// The status of a solve without an answer, and a sentence that says why.
    fn solve(&mut self, row: &LoadRow, details: bool) -> Result<Solved, (&'static str, String)>;
}

/// An equilibrium of what is replayed.
#[derive(Debug, Clone)]
pub struct Solved {
    /// How the solve ended.
    pub status: &'static str,
    /// Iterations.
    pub iterations: u16,
    /// Displacement.
    pub displacement: [f64; 5],
    /// Stiffness.
    pub stiffness: [[f64; 5]; 5],
    /// Stiffness at the nose.
    pub stiffness_at_nose: Option<[[f64; 5]; 5]>,
    /// Limits that are passed.
    pub limits: LimitSet,
    /// The rows of balls.
    pub rows: Vec<SolvedRow>,
}

/// What a row of balls carries.
#[derive(Debug, Clone)]
pub struct SolvedRow {
    /// Force on its inner ring, in its own frame.
    pub force: [f64; 5],
    /// Preload, N.
    pub preload: f64,
    /// States of the balls.
    pub balls: Vec<BallState<f64>>,
}

/// Where the tables go.
pub struct Outputs<'o> {
    /// The results.
    pub results: &'o mut dyn Write,
    /// What each row of a spindle carries.
    pub rows: Option<&'o mut dyn Write>,
    /// What each ball carries.
    pub balls: Option<&'o mut dyn Write>,
}

impl<'o> Outputs<'o> {
    /// The results alone.
    pub fn of(results: &'o mut dyn Write) -> Self {
        Self {
            results,
            rows: None,
            balls: None,
        }
    }
}

/// One bearing.
pub struct OneBearing<'s>(pub &'s mut dyn AnySolver);

impl Replayed for OneBearing<'_> {
    fn balls(&self) -> Vec<usize> {
        vec![self.0.ball_count()]
    }

    fn is_spindle(&self) -> bool {
        false
    }

    fn has_nose(&self) -> bool {
        false
    }

    fn precision(&self) -> Precision {
        self.0.precision()
    }

    fn reset(&mut self) {
        self.0.reset();
    }

    fn solve(&mut self, row: &LoadRow, details: bool) -> Result<Solved, (&'static str, String)> {
        let mut balls = Vec::new();
        let wanted = details.then_some(&mut balls);
        let answer = self.0.solve_with_balls(row.load, row.omega(), wanted);
        let figures = answer.figures.map_err(|why| (answer.status, why))?;
        Ok(Solved {
            status: answer.status,
            iterations: figures.iterations,
            displacement: figures.displacement,
            stiffness: figures.stiffness,
            stiffness_at_nose: None,
            limits: figures.limits,
            rows: vec![SolvedRow {
                force: row.load,
                preload: 0.0,
                balls,
            }],
        })
    }
}

/// What stopped a replay.
#[derive(Debug)]
pub enum ReplayError {
    /// The recording is at fault.
    Loads(LoadsError),
    /// The results cannot be written.
    Results(io::Error),
    /// The ball states cannot be written.
    Balls(io::Error),
    /// The rows of a spindle cannot be written.
    Rows(io::Error),
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Loads(error) => error.fmt(f),
            Self::Results(error) => write!(f, "the results cannot be written: {error}"),
            Self::Balls(error) => write!(f, "the ball states cannot be written: {error}"),
            Self::Rows(error) => write!(f, "the rows of the spindle cannot be written: {error}"),
        }
    }
}

impl std::error::Error for ReplayError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Loads(error) => Some(error),
            Self::Results(error) | Self::Balls(error) | Self::Rows(error) => Some(error),
        }
    }
}

/// How a replay went.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Summary {
    /// Rows replayed.
    pub rows: u64,
    /// Rows without an answer, by status.
    pub refused: BTreeMap<&'static str, u64>,
    /// Time of the first row that the solver has no answer to, and why.
    pub first_refusal: Option<(f64, String)>,
    /// What is wrong with the first row that cannot be read.
    pub first_fault: Option<Fault>,
}

impl Summary {
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
        let solver = self.first_refusal.as_ref();
        let firsts = solver.map(|(time, why)| format!("at {time} s: {why}"));
        let firsts = firsts
            .into_iter()
            .chain(self.first_fault.as_ref().map(Fault::to_string));
        for (i, first) in firsts.enumerate() {
            let first_of = if i == 0 {
                " (the first "
            } else {
                "; the first that cannot be read: "
            };
            write!(f, "{first_of}{first}")?;
        }
        f.write_str(if total == 0 { "" } else { ")" })
    }
}

/// Solves row after row and writes the tables as CSV. With `cold` every row is solved from scratch.
///
/// Rows are written as they are solved: after an error, those before it have been. A row of the recording that cannot
/// be read has the status [`REFUSED_INPUT`].
///
/// # Errors
///
/// A recording that ends in a fault, or an output that fails.
pub fn replay(
    solver: &mut dyn Replayed,
    rows: impl Iterator<Item = Result<LoadRow, LoadsError>>,
    cold: bool,
    out: &mut Outputs<'_>,
) -> Result<Summary, ReplayError> {
    let mut summary = Summary::default();
    let mut tables = Tables {
        counts: solver.balls(),
        spindle: solver.is_spindle(),
        nose: solver.has_nose(),
        precision: solver.precision(),
        out,
    };
    tables.headers()?;
    let details = tables.out.rows.is_some() || tables.out.balls.is_some();
    for row in rows {
        summary.rows += 1;
        let (time, answer) = match row {
            Ok(row) => {
                if cold {
                    solver.reset();
                }
                let answer = solver.solve(&row, details);
                let answer = answer.map_err(|(status, why)| {
                    summary.first_refusal.get_or_insert((row.time_s, why));
                    status
                });
                (Some(row.time_s), answer)
            }
            Err(LoadsError::Row(row)) => {
                let [time, ..] = row.numbers;
                summary.first_fault.get_or_insert(row.fault);
                (time, Err(REFUSED_INPUT))
            }
            Err(error) => return Err(ReplayError::Loads(error)),
        };
        if let Err(status) = &answer {
            *summary.refused.entry(status).or_default() += 1;
        }
        // Time is never rounded to the solver's precision: it identifies the row.
        let time = time.map(|time| Precision::F64.show(time).to_string());
        tables.row(&time.unwrap_or_default(), &answer)?;
    }
    tables.flush()?;
    Ok(summary)
}

/// The tables that are being written.
struct Tables<'t, 'o> {
    /// Number of balls of each row.
    counts: Vec<usize>,
    spindle: bool,
    nose: bool,
    precision: Precision,
    out: &'t mut Outputs<'o>,
}

impl Tables<'_, '_> {
    fn headers(&mut self) -> Result<(), ReplayError> {
        writeln!(self.out.results, "{}", header(self.nose)).map_err(ReplayError::Results)?;
        if let Some(rows) = &mut self.out.rows {
            writeln!(rows, "{ROW_HEADER}").map_err(ReplayError::Rows)?;
        }
        let row = if self.spindle { "row," } else { "" };
        if let Some(balls) = &mut self.out.balls {
            writeln!(balls, "time_s,{row}{BALL_COLUMNS}").map_err(ReplayError::Balls)?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), ReplayError> {
        self.out.results.flush().map_err(ReplayError::Results)?;
        if let Some(rows) = &mut self.out.rows {
            rows.flush().map_err(ReplayError::Rows)?;
        }
        if let Some(balls) = &mut self.out.balls {
            balls.flush().map_err(ReplayError::Balls)?;
        }
        Ok(())
    }

    /// What there is to write of a row of the recording.
    fn row(&mut self, time: &str, answer: &Result<Solved, &str>) -> Result<(), ReplayError> {
        self.result(time, answer).map_err(ReplayError::Results)?;
        let solved = answer.as_ref().ok();
        self.rows(time, solved).map_err(ReplayError::Rows)?;
        self.balls(time, solved).map_err(ReplayError::Balls)
    }

    fn result(&mut self, time: &str, answer: &Result<Solved, &str>) -> io::Result<()> {
        let out = &mut self.out.results;
        match answer {
            Ok(solved) => {
                write!(out, "{time},{},{}", solved.status, solved.iterations)?;
                let matrices = [Some(solved.stiffness), solved.stiffness_at_nose];
                let stiffness = matrices.into_iter().flatten().flatten().flatten();
                for figure in solved.displacement.into_iter().chain(stiffness) {
                    write!(out, ",{}", self.precision.show(figure))?;
                }
                writeln!(out, ",{}", solved.limits)
            }
            Err(status) => {
                let matrices = if self.nose { 2 } else { 1 };
                let empty = 1 + FREEDOMS.len() + matrices * FREEDOMS.len().pow(2) + 1;
                writeln!(out, "{time},{status}{:,<empty$}", "")
            }
        }
    }

    fn rows(&mut self, time: &str, solved: Option<&Solved>) -> io::Result<()> {
        let Some(out) = &mut self.out.rows else {
            return Ok(());
        };
        for number in 0..self.counts.len() {
            write!(out, "{time},{number}")?;
            let Some(row) = solved.and_then(|solved| solved.rows.get(number)) else {
                writeln!(out, ",,,,,,,")?;
                continue;
            };
            let forces = row.balls.iter().map(|ball| ball.q_i);
            let least = forces.fold(f64::INFINITY, f64::min);
            for figure in row.force.into_iter().chain([row.preload, least]) {
                write!(out, ",{}", self.precision.show(figure))?;
            }
            writeln!(out)?;
        }
        Ok(())
    }

    fn balls(&mut self, time: &str, solved: Option<&Solved>) -> io::Result<()> {
        let Some(out) = &mut self.out.balls else {
            return Ok(());
        };
        for (number, &count) in self.counts.iter().enumerate() {
            for ball in 0..count {
                write!(out, "{time}")?;
                if self.spindle {
                    write!(out, ",{number}")?;
                }
                write!(out, ",{ball}")?;
                let row = solved.and_then(|solved| solved.rows.get(number));
                match row.and_then(|row| row.balls.get(ball)) {
                    Some(state) => {
                        for figure in ball_figures(state) {
                            write!(out, ",{}", self.precision.show(figure))?;
                        }
                    }
                    None => write!(out, "{:,<1$}", "", BALL_FIGURES)?,
                }
                writeln!(out)?;
            }
        }
        Ok(())
    }
}

fn ball_figures(ball: &BallState<f64>) -> [f64; BALL_FIGURES] {
    [
        ball.azimuth,
        ball.alpha_i,
        ball.alpha_o,
        ball.q_i,
        ball.q_o,
        ball.centrifugal_force,
        ball.gyroscopic_moment,
    ]
}
