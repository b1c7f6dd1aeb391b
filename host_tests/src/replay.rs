//! Recorded loads and speed in, displacements and stiffness out, as tables. `cargo replay` is around it.

use crate::dispatch::Precision;
use crate::loads::{Fault, LoadRow, LoadsError};
use crate::spindle_file::SpindleFile;
use crate::spindles::{Answer, AnySpindleSolver, RowAnswer};
use spindle_bearing::{BallMotion, BallState, LifeRating, LimitSet, RatingLife, ShaftEnd, Speed};
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Write};

/// Names of the five freedoms in column names.
const FREEDOMS: [&str; 5] = ["x", "y", "z", "ty", "tz"];

/// Columns that end the results: loads and speed, as the recording has them; rating life, million revolutions and hours.
const LAST_COLUMNS: &str = "fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,l10_mrev,l10_h";

/// Status of a row of the recording that cannot be read.
pub const REFUSED_INPUT: &str = "refused-input";

/// A table besides the results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Load, preload and least contact force of every row of a spindle.
    Rows,
    /// State of every ball.
    Balls,
    /// Frequencies at which damage of every row is heard.
    Frequencies,
}

impl Detail {
    /// Columns after the time, the row and the ball.
    fn columns(self) -> &'static str {
        match self {
            Self::Rows => "fx_n,fy_n,fz_n,my_nm,mz_nm,preload_n,least_q_i_n",
            Self::Balls => {
                "azimuth_rad,alpha_i_rad,alpha_o_rad,q_i_n,q_o_n,fc_n,mg_nm,\
                 p_i_pa,p_o_pa,a_i_m,b_i_m,a_o_m,b_o_m,cage_rad_s,attitude_rad,spin_roll_i,spin_roll_o"
            }
            Self::Frequencies => "cage_hz,outer_race_hz,inner_race_hz,ball_hz",
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Rows => "rows of the spindle",
            Self::Balls => "ball states",
            Self::Frequencies => "frequencies",
        }
    }

    /// Figures of a row of balls, line by line.
    fn figures(self, row: &RowAnswer) -> Vec<Vec<f64>> {
        match self {
            Self::Rows => {
                let forces = row.balls.iter().map(|ball| ball.q_i);
                let least = forces.fold(f64::INFINITY, f64::min);
                vec![[&row.force[..], &[row.preload, least]].concat()]
            }
            Self::Balls => {
                let balls = row.balls.iter().zip(&row.motions);
                balls
                    .map(|(ball, motion)| ball_figures(ball, motion).to_vec())
                    .collect()
            }
            Self::Frequencies => {
                let found = &row.frequencies;
                vec![vec![
                    found.cage,
                    found.outer_race,
                    found.inner_race,
                    found.ball,
                ]]
            }
        }
    }
}

/// Tables besides the results, and where they go.
pub type Details<'o> = Vec<(Detail, Box<dyn Write + 'o>)>;

/// Where the tables go.
pub struct Outputs<'o> {
    /// The results.
    pub results: &'o mut dyn Write,
    /// Other tables that are wanted.
    pub details: Details<'o>,
}

impl Outputs<'_> {
    fn write(&mut self, results: &str, text: impl Fn(Detail) -> String) -> Result<(), ReplayError> {
        let written = self.results.write_all(results.as_bytes());
        written.map_err(ReplayError::Results)?;
        for (detail, out) in &mut self.details {
            let written = out.write_all(text(*detail).as_bytes());
            written.map_err(|error| ReplayError::Detail(*detail, error))?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), ReplayError> {
        self.results.flush().map_err(ReplayError::Results)?;
        for (detail, out) in &mut self.details {
            let flushed = out.flush();
            flushed.map_err(|error| ReplayError::Detail(*detail, error))?;
        }
        Ok(())
    }
}

/// Reason why a replay stopped.
#[derive(Debug)]
pub enum ReplayError {
    /// The recording is at fault.
    Loads(LoadsError),
    /// The results cannot be written.
    Results(io::Error),
    /// Another table cannot be written.
    Detail(Detail, io::Error),
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Loads(error) => error.fmt(f),
            Self::Results(error) => write!(f, "the results cannot be written: {error}"),
            Self::Detail(detail, error) => {
                write!(f, "the {} cannot be written: {error}", detail.name())
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

/// Solves row after row and writes the tables as CSV. With `cold` every row is solved from scratch.
///
/// Rows are written as they are solved: after an error, those before it have been. A row of the recording that cannot
/// be read has the status [`REFUSED_INPUT`].
///
/// # Errors
///
/// A recording that ends in a fault, or an output that fails.
pub fn replay(
    file: &SpindleFile,
    solver: &mut dyn AnySpindleSolver,
    precision: Precision,
    rows: impl Iterator<Item = Result<LoadRow, LoadsError>>,
    cold: bool,
    out: &mut Outputs<'_>,
) -> Result<Summary, ReplayError> {
    let mut summary = Summary::default();
    let tables = Tables {
        file,
        precision,
        ratings: file.ratings(),
    };
    out.write(&tables.header(), |detail| tables.detail_header(detail))?;
    let end = file.nose.unwrap_or(ShaftEnd::rigid(0.0));
    for row in rows {
        summary.rows += 1;
        let (given, answer) = match row {
            Ok(row) => {
                if cold {
                    solver.reset();
                }
                let answer = solver.solve(&file.question(&row), &end);
                let answer = answer.map_err(|status| {
                    let why = || (row.time_s, status.to_string());
                    summary.first_refusal.get_or_insert_with(why);
                    status.name()
                });
                let [fx, fy, fz, my, mz] = row.load;
                let given = [row.time_s, fx, fy, fz, my, mz, row.speed_rpm];
                (given.map(Some), answer)
            }
            Err(LoadsError::Row(row)) => {
                summary.first_fault.get_or_insert(row.fault);
                (row.numbers, Err(REFUSED_INPUT))
            }
            Err(error) => return Err(ReplayError::Loads(error)),
        };
        if let Err(status) = &answer {
            *summary.refused.entry(status).or_default() += 1;
        }
        // Never rounded to the solver's precision: time identifies the row, and loads are those of the recording.
        let given_text =
            given.map(|number| number.map_or(String::new(), |number| Precision::F64.show(number)));
        let (time, loads) = (&given_text[0], given_text[1..].join(","));
        let result = tables.result(time, &answer, &loads, given[6]);
        let answer = answer.ok();
        out.write(&result, |detail| {
            tables.detail(detail, time, answer.as_ref())
        })?;
    }
    out.flush()?;
    Ok(summary)
}

/// The text of the tables.
struct Tables<'t> {
    file: &'t SpindleFile,
    precision: Precision,
    ratings: Vec<LifeRating<f64>>,
}

impl Tables<'_> {
    fn header(&self) -> String {
        let mut text = "time_s,status,iterations,dx_m,dy_m,dz_m,ty_rad,tz_rad".to_owned();
        let nose = self.file.nose.map(|_| "k_nose");
        for place in ["k"].into_iter().chain(nose) {
            for row in FREEDOMS {
                text += &FREEDOMS
                    .map(|column| format!(",{place}_{row}_{column}"))
                    .concat();
            }
        }
        text + ",limits," + LAST_COLUMNS + "\n"
    }

    /// A row of the results.
    fn result(
        &self,
        time: &str,
        answer: &Result<Answer, &str>,
        loads: &str,
        speed_rpm: Option<f64>,
    ) -> String {
        let answer = match answer {
            Ok(answer) => answer,
            Err(status) => {
                let matrices = if self.file.nose.is_some() { 2 } else { 1 };
                let empty = ",".repeat(1 + 5 + matrices * 25 + 1);
                return format!("{time},{status}{empty},{loads},,\n");
            }
        };
        let mut text = format!("{time},{},{}", answer.status, answer.iterations);
        text += &self.figures(&answer.displacement);
        text += &self.figures(answer.stiffness.as_flattened());
        if self.file.nose.is_some() {
            text += &self.figures(answer.stiffness_at.as_flattened());
        }
        let limits = answer.rows.iter().map(|row| row.limits);
        let limits = limits.fold(LimitSet::default(), LimitSet::union);
        let weights = answer.rows.iter().zip(&self.ratings).map(|(row, rating)| {
            rating.weight_of(row.balls.iter().map(|ball| (ball.q_i, ball.q_o)))
        });
        let omega = Speed::rpm(speed_rpm.unwrap_or(0.0)).as_rad_per_s();
        let life = RatingLife::of_weight(weights.sum(), omega);
        let [revolutions, hours] =
            [life.million_revolutions, life.hours].map(|x| Precision::F32.show(x));
        text + &format!(",{limits},{loads},{revolutions},{hours}\n")
    }

    fn detail_header(&self, detail: Detail) -> String {
        let row = if self.file.is_bearing { "" } else { "row," };
        let ball = if detail == Detail::Balls { "ball," } else { "" };
        format!("time_s,{row}{ball}{}\n", detail.columns())
    }

    /// The lines of a table besides the results, for a row of the recording.
    fn detail(&self, detail: Detail, time: &str, answer: Option<&Answer>) -> String {
        let mut text = String::new();
        for (number, row) in self.file.plan.rows.iter().enumerate() {
            let found = answer.map(|answer| detail.figures(&answer.rows[number]));
            let is_of_balls = detail == Detail::Balls;
            for ball in 0..if is_of_balls { row.balls } else { 1 } {
                text += time;
                if !self.file.is_bearing {
                    text += &format!(",{number}");
                }
                if is_of_balls {
                    text += &format!(",{ball}");
                }
                text += &match &found {
                    Some(lines) => self.figures(&lines[ball]),
                    None => ",".repeat(detail.columns().split(',').count()),
                };
                text += "\n";
            }
        }
        text
    }

    /// These figures, a comma before each.
    fn figures(&self, figures: &[f64]) -> String {
        let shown = figures
            .iter()
            .map(|&figure| format!(",{}", self.precision.show(figure)));
        shown.collect()
    }
}

fn ball_figures(ball: &BallState<f64>, motion: &BallMotion<f64>) -> [f64; 17] {
    let (inner, outer) = (&motion.inner, &motion.outer);
    [
        ball.azimuth,
        ball.alpha_i,
        ball.alpha_o,
        ball.q_i,
        ball.q_o,
        ball.centrifugal_force,
        ball.gyroscopic_moment,
        inner.peak_pressure,
        outer.peak_pressure,
        inner.semi_major,
        inner.semi_minor,
        outer.semi_major,
        outer.semi_minor,
        motion.cage_speed,
        motion.attitude,
        inner.spin_to_roll,
        outer.spin_to_roll,
    ]
}
