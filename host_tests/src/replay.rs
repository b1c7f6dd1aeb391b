//! Recorded loads and speed in, displacements and stiffness out, as tables. `cargo replay` is around it.

use crate::dispatch::{AnySolver, Details, Precision, Wanted};
use crate::loads::{COLUMNS, Fault, LoadRow, LoadsError};
use spindle_bearing::{BallMotion, BallState, LifeRating, LimitSet, RatingLife, Speed};
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Write};

/// Names of the five freedoms in column names.
const FREEDOMS: [&str; 5] = ["x", "y", "z", "ty", "tz"];

/// Header of the file of rows.
const ROW_HEADER: &str = "time_s,row,fx_n,fy_n,fz_n,my_nm,mz_nm,preload_n,least_q_i_n";

/// Columns of the file of ball states, after those that say when and in which row.
const BALL_COLUMNS: &str = "ball,azimuth_rad,alpha_i_rad,alpha_o_rad,q_i_n,q_o_n,fc_n,mg_nm,\
     p_i_pa,p_o_pa,a_i_m,b_i_m,a_o_m,b_o_m,cage_rad_s,attitude_rad,spin_roll_i,spin_roll_o";
/// Number of figures of a ball.
const BALL_FIGURES: usize = 17;

/// Columns of the file of frequencies, likewise.
const FREQUENCY_COLUMNS: &str = "cage_hz,outer_race_hz,inner_race_hz,ball_hz";

/// Columns that follow: loads and speed, as the recording has them.
const ECHO_COLUMNS: &str = "fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm";
/// Columns that end the results: rating life, million revolutions and hours.
const LIFE_COLUMNS: &str = "l10_mrev,l10_h";

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
    header + ",limits," + ECHO_COLUMNS + "," + LIFE_COLUMNS
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

    /// Load ratings of the rows; none without a rating life.
    fn ratings(&self) -> Vec<LifeRating<f64>>;

    /// Makes the next solve a cold one.
    fn reset(&mut self);

    /// Solves for a row of the recording, with forces on the balls, and with what the rows of balls carry if that is wanted.
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
    /// What its balls do.
    pub details: Details,
}

/// Where the tables go.
pub struct Outputs<'o> {
    /// The results.
    pub results: &'o mut dyn Write,
    /// What each row of a spindle carries.
    pub rows: Option<&'o mut dyn Write>,
    /// What each ball carries.
    pub balls: Option<&'o mut dyn Write>,
    /// At what frequencies damage of each row is heard.
    pub frequencies: Option<&'o mut dyn Write>,
}

impl<'o> Outputs<'o> {
    /// The results alone.
    pub fn of(results: &'o mut dyn Write) -> Self {
        Self {
            results,
            rows: None,
            balls: None,
            frequencies: None,
        }
    }
}

/// One bearing.
pub struct OneBearing<'s> {
    /// Its solver.
    pub solver: &'s mut dyn AnySolver,
    /// Its load rating, if its life is wanted.
    pub rating: Option<LifeRating<f64>>,
}

impl Replayed for OneBearing<'_> {
    fn balls(&self) -> Vec<usize> {
        vec![self.solver.ball_count()]
    }

    fn is_spindle(&self) -> bool {
        false
    }

    fn has_nose(&self) -> bool {
        false
    }

    fn precision(&self) -> Precision {
        self.solver.precision()
    }

    fn ratings(&self) -> Vec<LifeRating<f64>> {
        self.rating.into_iter().collect()
    }

    fn reset(&mut self) {
        self.solver.reset();
    }

    fn solve(&mut self, row: &LoadRow, details: bool) -> Result<Solved, (&'static str, String)> {
        let mut found = Details::default();
        let wanted = if details {
            Wanted::Details(&mut found)
        } else {
            Wanted::Balls(&mut found.balls)
        };
        let answer = self.solver.solve_for(row.load, row.omega(), wanted);
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
                details: found,
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
    /// The frequencies cannot be written.
    Frequencies(io::Error),
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Loads(error) => error.fmt(f),
            Self::Results(error) => write!(f, "the results cannot be written: {error}"),
            Self::Balls(error) => write!(f, "the ball states cannot be written: {error}"),
            Self::Rows(error) => write!(f, "the rows of the spindle cannot be written: {error}"),
            Self::Frequencies(error) => write!(f, "the frequencies cannot be written: {error}"),
        }
    }
}

impl std::error::Error for ReplayError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Loads(error) => Some(error),
            Self::Results(error)
            | Self::Balls(error)
            | Self::Rows(error)
            | Self::Frequencies(error) => Some(error),
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
        ratings: solver.ratings(),
        out,
    };
    tables.headers()?;
    let outputs = &tables.out;
    let details =
        outputs.rows.is_some() || outputs.balls.is_some() || outputs.frequencies.is_some();
    for row in rows {
        summary.rows += 1;
        let (given, answer) = match row {
            Ok(row) => {
                if cold {
                    solver.reset();
                }
                let answer = solver.solve(&row, details);
                let answer = answer.map_err(|(status, why)| {
                    summary.first_refusal.get_or_insert((row.time_s, why));
                    status
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
        tables.row(&given, &answer)?;
    }
    tables.flush()?;
    Ok(summary)
}

/// Rating life of the rows together at a speed in rpm.
fn life(
    rows: &[SolvedRow],
    ratings: &[LifeRating<f64>],
    speed_rpm: Option<f64>,
) -> Option<RatingLife<f64>> {
    if ratings.len() != rows.len() {
        return None;
    }
    let weight = |(row, rating): (&SolvedRow, &LifeRating<f64>)| {
        rating.weight_of(row.details.balls.iter().map(|ball| (ball.q_i, ball.q_o)))
    };
    let together = rows.iter().zip(ratings).map(weight).sum();
    let speed = Speed::rpm(speed_rpm?);
    Some(RatingLife::of_weight(together, speed.as_rad_per_s()))
}

/// The tables that are being written.
struct Tables<'t, 'o> {
    /// Number of balls of each row.
    counts: Vec<usize>,
    spindle: bool,
    nose: bool,
    precision: Precision,
    ratings: Vec<LifeRating<f64>>,
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
        if let Some(out) = &mut self.out.frequencies {
            writeln!(out, "time_s,{row}{FREQUENCY_COLUMNS}").map_err(ReplayError::Frequencies)?;
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
        if let Some(frequencies) = &mut self.out.frequencies {
            frequencies.flush().map_err(ReplayError::Frequencies)?;
        }
        Ok(())
    }

    /// What there is to write of a row of the recording, of which this could be read.
    fn row(
        &mut self,
        given: &[Option<f64>; COLUMNS.len()],
        answer: &Result<Solved, &str>,
    ) -> Result<(), ReplayError> {
        // Never rounded to the solver's precision: time identifies the row, and loads are those of the recording.
        let copied = given.map(|number| match number {
            Some(number) => Precision::F64.show(number).to_string(),
            None => String::new(),
        });
        let [time, loads @ ..] = &copied;
        self.result(time, answer, &loads.join(","), given[6])
            .map_err(ReplayError::Results)?;
        let solved = answer.as_ref().ok();
        self.rows(time, solved).map_err(ReplayError::Rows)?;
        self.balls(time, solved).map_err(ReplayError::Balls)?;
        self.frequencies(time, solved)
            .map_err(ReplayError::Frequencies)
    }

    fn result(
        &mut self,
        time: &str,
        answer: &Result<Solved, &str>,
        loads: &str,
        speed: Option<f64>,
    ) -> io::Result<()> {
        let out = &mut self.out.results;
        match answer {
            Ok(solved) => {
                write!(out, "{time},{},{}", solved.status, solved.iterations)?;
                let matrices = [Some(solved.stiffness), solved.stiffness_at_nose];
                let stiffness = matrices.into_iter().flatten().flatten().flatten();
                for figure in solved.displacement.into_iter().chain(stiffness) {
                    write!(out, ",{}", self.precision.show(figure))?;
                }
                write!(out, ",{},{loads}", solved.limits)?;
                match life(&solved.rows, &self.ratings, speed) {
                    Some(life) => {
                        let figures = [life.million_revolutions, life.hours];
                        let [revolutions, hours] = figures.map(|x| Precision::F32.show(x));
                        writeln!(out, ",{revolutions},{hours}")
                    }
                    None => writeln!(out, ",,"),
                }
            }
            Err(status) => {
                let matrices = if self.nose { 2 } else { 1 };
                let empty = 1 + FREEDOMS.len() + matrices * FREEDOMS.len().pow(2) + 1;
                writeln!(out, "{time},{status}{:,<empty$},{loads},,", "")
            }
        }
    }

    fn rows(&mut self, time: &str, solved: Option<&Solved>) -> io::Result<()> {
        let Some(out) = &mut self.out.rows else {
            return Ok(());
        };
        for number in 0..self.counts.len() {
            write!(out, "{time},{number}")?;
            let figures = solved.and_then(|solved| {
                let row = solved.rows.get(number)?;
                let forces = row.details.balls.iter().map(|ball| ball.q_i);
                let least = forces.fold(f64::INFINITY, f64::min);
                let [fx, fy, fz, my, mz] = row.force;
                Some([fx, fy, fz, my, mz, row.preload, least])
            });
            write_figures(out, figures.as_ref(), self.precision)?;
        }
        Ok(())
    }

    /// Start of a line of a table of rows or balls: the time, and the row of a spindle.
    fn start(&self, time: &str, number: usize) -> String {
        if self.spindle {
            format!("{time},{number}")
        } else {
            time.to_owned()
        }
    }

    fn balls(&mut self, time: &str, solved: Option<&Solved>) -> io::Result<()> {
        for (number, &count) in self.counts.iter().enumerate() {
            let start = self.start(time, number);
            let Some(out) = &mut self.out.balls else {
                return Ok(());
            };
            let row = solved.and_then(|solved| solved.rows.get(number));
            let details = row.map(|row| &row.details);
            for ball in 0..count {
                write!(out, "{start},{ball}")?;
                let figures = details.and_then(|details| {
                    let state = details.balls.get(ball)?;
                    Some(ball_figures(state, details.motions.get(ball)?))
                });
                write_figures(out, figures.as_ref(), self.precision)?;
            }
        }
        Ok(())
    }

    fn frequencies(&mut self, time: &str, solved: Option<&Solved>) -> io::Result<()> {
        for number in 0..self.counts.len() {
            let start = self.start(time, number);
            let Some(out) = &mut self.out.frequencies else {
                return Ok(());
            };
            write!(out, "{start}")?;
            let row = solved.and_then(|solved| solved.rows.get(number));
            let figures = row.map(|row| {
                let found = &row.details.frequencies;
                [found.cage, found.outer_race, found.inner_race, found.ball]
            });
            write_figures(out, figures.as_ref(), self.precision)?;
        }
        Ok(())
    }
}

/// These figures, or as many empty fields, and the line's end.
fn write_figures<const N: usize>(
    out: &mut dyn Write,
    figures: Option<&[f64; N]>,
    precision: Precision,
) -> io::Result<()> {
    match figures {
        Some(figures) => {
            for &figure in figures {
                write!(out, ",{}", precision.show(figure))?;
            }
        }
        None => write!(out, "{:,<N$}", "")?,
    }
    writeln!(out)
}

fn ball_figures(ball: &BallState<f64>, motion: &BallMotion<f64>) -> [f64; BALL_FIGURES] {
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
