//! Recorded loads and speed in, displacements and stiffness out, as tables. `cargo replay` is around it.

use crate::dispatch::Precision;
use crate::spindles::{Answer, AnySpindleSolver, RowAnswer};
use files::recordings::{Fault, LoadRow, LoadsError};
use files::spindles::SpindleFile;
use spindle_bearing::{LifeRating, LimitSet, RatingLife, ShaftEnd, Speed};
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Write};

/// Names of the five freedoms in column names.
const FREEDOMS: [&str; 5] = ["x", "y", "z", "ty", "tz"];

/// Status of a row of the recording that cannot be read.
pub const REFUSED_INPUT: &str = "refused-input";

/// A table that a replay writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Table {
    /// Displacement and stiffness, a line for every row of the recording.
    Results,
    /// Load, preload and least contact force of every row of a spindle.
    Rows,
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
            Self::Balls => "ball states",
            Self::Frequencies => "frequencies",
        }
    }

    fn header(self, file: &SpindleFile) -> String {
        let row = if file.is_bearing { "" } else { "row," };
        match self {
            Self::Results => {
                let mut text = "time_s,status,iterations,dx_m,dy_m,dz_m,ty_rad,tz_rad,".to_owned();
                let nose = file.nose.map(|_| "k_nose");
                for place in ["k"].into_iter().chain(nose) {
                    for row in FREEDOMS {
                        text += &FREEDOMS.map(|to| format!("{place}_{row}_{to},")).concat();
                    }
                }
                text + "limits,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,l10_mrev,l10_h"
            }
            Self::Rows => {
                format!("time_s,{row}fx_n,fy_n,fz_n,my_nm,mz_nm,preload_n,least_q_i_n")
            }
            Self::Balls => format!(
                "time_s,{row}ball,azimuth_rad,alpha_i_rad,alpha_o_rad,q_i_n,q_o_n,fc_n,mg_nm,\
                 p_i_pa,p_o_pa,a_i_m,b_i_m,a_o_m,b_o_m,cage_rad_s,attitude_rad,spin_roll_i,spin_roll_o"
            ),
            Self::Frequencies => {
                format!("time_s,{row}cage_hz,outer_race_hz,inner_race_hz,ball_hz")
            }
        }
    }

    /// Figures of a row of balls, or of one of its balls.
    fn figures(self, row: &RowAnswer, ball: usize) -> Vec<f64> {
        match self {
            Self::Results => Vec::new(),
            Self::Rows => {
                let forces = row.balls.iter().map(|ball| ball.q_i);
                let least = forces.fold(f64::INFINITY, f64::min);
                [&row.force[..], &[row.preload, least]].concat()
            }
            Self::Balls => {
                let (ball, motion) = (&row.balls[ball], &row.motions[ball]);
                let (inner, outer) = (&motion.inner, &motion.outer);
                vec![
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
            Self::Frequencies => {
                let found = &row.frequencies;
                vec![found.cage, found.outer_race, found.inner_race, found.ball]
            }
        }
    }
}

/// Tables that are wanted, and where they go.
pub type Outputs<'o> = Vec<(Table, Box<dyn Write + 'o>)>;

/// Reason why a replay stopped.
#[derive(Debug)]
pub enum ReplayError {
    /// The recording is at fault.
    Loads(LoadsError),
    /// A table cannot be written.
    Output(Table, io::Error),
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Loads(error) => error.fmt(f),
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
    mut outputs: Outputs<'_>,
) -> Result<Summary, ReplayError> {
    let mut summary = Summary::default();
    let text = Text {
        file,
        precision,
        ratings: file.ratings(),
    };
    let write = |(table, out): &mut (Table, Box<dyn Write + '_>), line: String| {
        writeln!(out, "{line}").map_err(|error| ReplayError::Output(*table, error))
    };
    for output in &mut outputs {
        write(output, output.0.header(file))?;
    }
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
        for output in &mut outputs {
            let lines = match output.0 {
                Table::Results => vec![text.result(&given, &answer)],
                table => text.details(table, &given, answer.as_ref().ok()),
            };
            for line in lines {
                write(output, line.join(","))?;
            }
        }
    }
    for (table, out) in &mut outputs {
        let flushed = out.flush();
        flushed.map_err(|error| ReplayError::Output(*table, error))?;
    }
    Ok(summary)
}

/// A number of the recording, never rounded to the solver's precision: time identifies the row.
fn copied(number: &Option<f64>) -> String {
    number.map_or(String::new(), |number| Precision::F64.show(number))
}

/// Answers as lines of the tables.
struct Text<'t> {
    file: &'t SpindleFile,
    precision: Precision,
    ratings: Vec<LifeRating<f64>>,
}

impl Text<'_> {
    /// The line of the results for time, loads and speed of a row of the recording.
    fn result(&self, given: &[Option<f64>; 7], answer: &Result<Answer, &str>) -> Vec<String> {
        let mut line = vec![copied(&given[0])];
        let mut life = [String::new(), String::new()];
        match answer {
            Ok(answer) => {
                line.extend([answer.status.to_owned(), answer.iterations.to_string()]);
                line.extend(self.figures(&answer.displacement));
                line.extend(self.figures(answer.stiffness.as_flattened()));
                if self.file.nose.is_some() {
                    line.extend(self.figures(answer.stiffness_at.as_flattened()));
                }
                let limits = answer.rows.iter().map(|row| row.limits);
                let limits = limits.fold(LimitSet::default(), LimitSet::union);
                line.push(limits.to_string());
                let weights = answer.rows.iter().zip(&self.ratings).map(|(row, rating)| {
                    rating.weight_of(row.balls.iter().map(|ball| (ball.q_i, ball.q_o)))
                });
                let omega = Speed::rpm(given[6].unwrap_or(0.0)).as_rad_per_s();
                let found = RatingLife::of_weight(weights.sum(), omega);
                life = [found.million_revolutions, found.hours].map(|x| Precision::F32.show(x));
            }
            Err(status) => {
                line.push((*status).to_owned());
                let figures = if self.file.nose.is_some() { 57 } else { 32 };
                line.resize(line.len() + figures, String::new());
            }
        }
        line.extend(given[1..].iter().map(copied));
        line.extend(life);
        line
    }

    /// The lines of a table besides the results, for a row of the recording.
    fn details(
        &self,
        table: Table,
        given: &[Option<f64>; 7],
        answer: Option<&Answer>,
    ) -> Vec<Vec<String>> {
        let columns = table.header(self.file).split(',').count();
        let mut lines = Vec::new();
        for (number, row) in self.file.plan.rows.iter().enumerate() {
            let is_of_balls = table == Table::Balls;
            for ball in 0..if is_of_balls { row.balls } else { 1 } {
                let mut line = vec![copied(&given[0])];
                line.extend((!self.file.is_bearing).then(|| number.to_string()));
                line.extend(is_of_balls.then(|| ball.to_string()));
                if let Some(answer) = answer {
                    line.extend(self.figures(&table.figures(&answer.rows[number], ball)));
                }
                line.resize(columns, String::new());
                lines.push(line);
            }
        }
        lines
    }

    fn figures(&self, figures: &[f64]) -> Vec<String> {
        let figures = figures.iter();
        figures.map(|figure| self.precision.show(*figure)).collect()
    }
}
