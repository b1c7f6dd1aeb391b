//! Recorded loads and speed of a spindle in, its displacements, stiffness and rows out, as tables.

use crate::dispatch::Precision;
use crate::loads::{LoadRow, LoadsError};
use crate::replay::{FREEDOMS, ReplayError, Summary, write_ball};
use crate::spindle_file::SpindleFile;
use crate::spindles::{Answer, AnySpindleSolver};
use spindle_bearing::{LimitSet, ShaftEnd};
use std::io::{self, Write};

/// Header of the file of rows.
pub const ROW_HEADER: &str = "time_s,row,fx_n,fy_n,fz_n,my_nm,mz_nm,preload_n,least_q_i_n";

/// Header of the file of ball states.
pub const BALL_HEADER: &str =
    "time_s,row,ball,azimuth_rad,alpha_i_rad,alpha_o_rad,q_i_n,q_o_n,fc_n,mg_nm";

/// Header of the results; with the stiffness at the nose, if there is one.
pub fn header(nose: bool) -> String {
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

/// Where the tables go.
pub struct Outputs<'o> {
    /// The results.
    pub results: &'o mut dyn Write,
    /// What each row carries.
    pub rows: Option<&'o mut dyn Write>,
    /// What each ball carries.
    pub balls: Option<&'o mut dyn Write>,
}

/// Solves one row of loads after the other and writes the results as CSV. With `cold` every one is solved from scratch.
///
/// # Errors
///
/// A malformed recording, or an output that fails.
pub fn replay(
    file: &SpindleFile,
    solver: &mut dyn AnySpindleSolver,
    precision: Precision,
    loads: impl Iterator<Item = Result<LoadRow, LoadsError>>,
    cold: bool,
    out: &mut Outputs<'_>,
) -> Result<Summary, ReplayError> {
    let mut summary = Summary::default();
    let end = file.nose.unwrap_or(ShaftEnd::rigid(0.0));
    let nose = file.nose.is_some();
    writeln!(out.results, "{}", header(nose)).map_err(ReplayError::Results)?;
    if let Some(rows) = &mut out.rows {
        writeln!(rows, "{ROW_HEADER}").map_err(ReplayError::Rows)?;
    }
    if let Some(balls) = &mut out.balls {
        writeln!(balls, "{BALL_HEADER}").map_err(ReplayError::Balls)?;
    }
    for row in loads {
        let row = row.map_err(ReplayError::Loads)?;
        if cold {
            solver.reset();
        }
        let answer = solver.solve(&file.question(&row), &end);
        let time = Precision::F64.show(row.time_s);
        match &answer {
            Ok(answer) => write!(
                out.results,
                "{time},{},{}",
                answer.status, answer.iterations
            )
            .and_then(|()| write_figures(out.results, answer, nose, precision)),
            Err(status) => {
                let empty = 1 + FREEDOMS.len() + 25 * if nose { 2 } else { 1 } + 1;
                writeln!(out.results, "{time},{}{:,<empty$}", status.name(), "")
            }
        }
        .map_err(ReplayError::Results)?;
        if let Some(rows) = &mut out.rows {
            write_rows(rows, file, row.time_s, answer.as_ref().ok(), precision)
                .map_err(ReplayError::Rows)?;
        }
        if let Some(balls) = &mut out.balls {
            write_balls(balls, file, row.time_s, answer.as_ref().ok(), precision)
                .map_err(ReplayError::Balls)?;
        }
        let refusal = answer
            .err()
            .map(|status| (status.name(), status.to_string()));
        summary.count(row.time_s, refusal);
    }
    out.results.flush().map_err(ReplayError::Results)?;
    if let Some(rows) = &mut out.rows {
        rows.flush().map_err(ReplayError::Rows)?;
    }
    if let Some(balls) = &mut out.balls {
        balls.flush().map_err(ReplayError::Balls)?;
    }
    Ok(summary)
}

fn write_figures(
    out: &mut dyn Write,
    answer: &Answer,
    nose: bool,
    precision: Precision,
) -> io::Result<()> {
    let there = answer.stiffness_at.iter().take(if nose { 5 } else { 0 });
    let stiffness = answer.stiffness.iter().chain(there).flatten();
    for &figure in answer.displacement.iter().chain(stiffness) {
        write!(out, ",{}", precision.show(figure))?;
    }
    let limits = answer.rows.iter().map(|row| row.limits);
    writeln!(
        out,
        ",{}",
        limits.fold(LimitSet::default(), LimitSet::union)
    )
}

fn write_rows(
    out: &mut dyn Write,
    file: &SpindleFile,
    time: f64,
    answer: Option<&Answer>,
    precision: Precision,
) -> io::Result<()> {
    let time = Precision::F64.show(time);
    let Some(answer) = answer else {
        for number in 0..file.plan.rows.len() {
            writeln!(out, "{time},{number},,,,,,,")?;
        }
        return Ok(());
    };
    for (number, row) in answer.rows.iter().enumerate() {
        write!(out, "{time},{number}")?;
        let least = row
            .balls
            .iter()
            .map(|ball| ball.q_i)
            .fold(f64::INFINITY, f64::min);
        for figure in row.force.into_iter().chain([row.preload, least]) {
            write!(out, ",{}", precision.show(figure))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn write_balls(
    out: &mut dyn Write,
    file: &SpindleFile,
    time: f64,
    answer: Option<&Answer>,
    precision: Precision,
) -> io::Result<()> {
    let time = Precision::F64.show(time);
    for (number, row) in file.plan.rows.iter().enumerate() {
        for ball in 0..row.balls {
            write!(out, "{time},{number},{ball}")?;
            match answer {
                Some(answer) => write_ball(out, &answer.rows[number].balls[ball], precision)?,
                None => writeln!(out, ",,,,,,,")?,
            }
        }
    }
    Ok(())
}
