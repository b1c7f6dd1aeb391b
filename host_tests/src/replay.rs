//! Recorded loads and speed in, displacements and stiffness out, as tables. `cargo replay` is around it.

use crate::dispatch::{Answer, AnySolver, Precision};
use crate::loads::{LoadRow, LoadsError};
use spindle_bearing::BallState;
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Write};

/// Names of the five freedoms in column names.
pub(crate) const FREEDOMS: [&str; 5] = ["x", "y", "z", "ty", "tz"];

/// Header of the file of ball states.
const BALL_HEADER: &str = "time_s,ball,azimuth_rad,alpha_i_rad,alpha_o_rad,q_i_n,q_o_n,fc_n,mg_nm";

/// Header of the results.
fn header() -> String {
    let mut header = "time_s,status,iterations,dx_m,dy_m,dz_m,ty_rad,tz_rad".to_owned();
    for row in FREEDOMS {
        for column in FREEDOMS {
            header.push_str(&format!(",k_{row}_{column}"));
        }
    }
    header.push_str(",limits");
    header
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
    /// Time of the first row without an answer, and why it has none.
    pub first_refusal: Option<(f64, String)>,
}

impl Summary {
    /// Counts a row of loads, which has an answer or a status and a sentence instead.
    pub(crate) fn count(&mut self, time: f64, refusal: Option<(&'static str, String)>) {
        self.rows += 1;
        if let Some((status, why)) = refusal {
            *self.refused.entry(status).or_default() += 1;
            self.first_refusal.get_or_insert((time, why));
        }
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
        if let Some((time, why)) = &self.first_refusal {
            write!(f, " (the first at {time} s: {why})")?;
        }
        Ok(())
    }
}

/// Solves row after row and writes the results as CSV, those of the balls to `balls` if it is given.
/// With `cold` every row is solved from scratch.
///
/// Rows are written as they are solved: after an error, those before it have been.
///
/// # Errors
///
/// A malformed recording, or an output that fails.
pub fn replay(
    solver: &mut dyn AnySolver,
    rows: impl Iterator<Item = Result<LoadRow, LoadsError>>,
    cold: bool,
    results: &mut dyn Write,
    mut balls: Option<&mut dyn Write>,
) -> Result<Summary, ReplayError> {
    let mut summary = Summary::default();
    let mut states = Vec::with_capacity(solver.ball_count());
    writeln!(results, "{}", header()).map_err(ReplayError::Results)?;
    if let Some(out) = &mut balls {
        writeln!(out, "{BALL_HEADER}").map_err(ReplayError::Balls)?;
    }
    for row in rows {
        let row = row.map_err(ReplayError::Loads)?;
        if cold {
            solver.reset();
        }
        let wanted = balls.is_some().then_some(&mut states);
        let answer = solver.solve_with_balls(row.load, row.omega(), wanted);
        let precision = solver.precision();
        write_result(results, row.time_s, &answer, precision).map_err(ReplayError::Results)?;
        if let Some(out) = &mut balls {
            if answer.figures.is_ok() {
                write_balls(out, row.time_s, &states, precision)
            } else {
                write_no_balls(out, row.time_s, solver.ball_count())
            }
            .map_err(ReplayError::Balls)?;
        }
        let refusal = answer.figures.err().map(|why| (answer.status, why));
        summary.count(row.time_s, refusal);
    }
    results.flush().map_err(ReplayError::Results)?;
    if let Some(out) = &mut balls {
        out.flush().map_err(ReplayError::Balls)?;
    }
    Ok(summary)
}

fn write_result(
    out: &mut dyn Write,
    time: f64,
    answer: &Answer,
    precision: Precision,
) -> io::Result<()> {
    // Time is never rounded to the solver's precision: it identifies the row.
    write!(out, "{},{},", Precision::F64.show(time), answer.status)?;
    match &answer.figures {
        Ok(figures) => {
            write!(out, "{}", figures.iterations)?;
            let stiffness = figures.stiffness.iter().flatten();
            for &figure in figures.displacement.iter().chain(stiffness) {
                write!(out, ",{}", precision.show(figure))?;
            }
            write!(out, ",{}", figures.limits)?;
        }
        Err(_) => {
            let figures = FREEDOMS.len() * (1 + FREEDOMS.len()) + 1;
            write!(out, "{:,<figures$}", "")?;
        }
    }
    writeln!(out)
}

fn write_balls(
    out: &mut dyn Write,
    time: f64,
    balls: &[BallState<f64>],
    precision: Precision,
) -> io::Result<()> {
    for (number, ball) in balls.iter().enumerate() {
        write!(out, "{},{number}", Precision::F64.show(time))?;
        write_ball(out, ball, precision)?;
    }
    Ok(())
}

/// The figures of a ball, and the line's end.
pub(crate) fn write_ball(
    out: &mut dyn Write,
    ball: &BallState<f64>,
    precision: Precision,
) -> io::Result<()> {
    for figure in [
        ball.azimuth,
        ball.alpha_i,
        ball.alpha_o,
        ball.q_i,
        ball.q_o,
        ball.centrifugal_force,
        ball.gyroscopic_moment,
    ] {
        write!(out, ",{}", precision.show(figure))?;
    }
    writeln!(out)
}

fn write_no_balls(out: &mut dyn Write, time: f64, count: usize) -> io::Result<()> {
    for number in 0..count {
        writeln!(out, "{},{number},,,,,,,", Precision::F64.show(time))?;
    }
    Ok(())
}
