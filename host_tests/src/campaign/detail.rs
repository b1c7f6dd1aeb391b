//! One case in full, to look into.

use super::families::Trial;
use super::judge::{JudgedTick, PRECISIONS, Record, Verdict, follow, judge, search};
use crate::dispatch::Precision;
use crate::reference::Solution;
use std::fmt::{self, Write};

/// A case: what is given, what both precisions and the reference build make of it.
pub fn in_full(trial: &Trial) -> String {
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = write(&mut text, trial);
    text
}

fn write(text: &mut String, trial: &Trial) -> fmt::Result {
    let case = &trial.case;
    writeln!(
        text,
        "{}: {} balls, attitude {:?}, scene {:?}\n{:#?}",
        case.name, case.balls, case.attitude, trial.scene, case.design
    )?;
    if let Some(u) = &trial.known {
        writeln!(
            text,
            "made from the displacement {}",
            numbers(u, Precision::F64)
        )?;
    }
    let mut judged = judge(trial);
    follow(trial, &mut judged);
    for mut solve in judged.ticks {
        let mut open: Vec<&mut Record> = solve
            .records
            .iter_mut()
            .filter(|r| r.verdict == Verdict::Undecided)
            .collect();
        let found = search(trial, &mut open);
        write_solve(text, trial, &solve)?;
        if let Some(truth) = found {
            writeln!(text, "\nthe reference build's own search")?;
            write_truth(text, &truth)?;
        }
    }
    Ok(())
}

fn write_solve(text: &mut String, trial: &Trial, solve: &JudgedTick) -> fmt::Result {
    let number = solve.records[0].tick;
    let tick = &trial.ticks[number];
    writeln!(
        text,
        "\nsolve {number}: load {}; speed {:e} rad/s",
        numbers(&tick.load, Precision::F64),
        tick.omega
    )?;
    for p in [0, 1] {
        let (answer, record, precision) = (&solve.answers[p], &solve.records[p], PRECISIONS[p]);
        writeln!(
            text,
            "\n{precision:?}: {}, {:?}",
            answer.status, record.verdict
        )?;
        match &answer.figures {
            Ok(figures) => {
                writeln!(text, "  iterations {}", figures.iterations)?;
                if let Some(errors) = &record.errors {
                    writeln!(text, "  errors of u, Q, K: {}", few_digits(errors))?;
                }
                if let Some(estimate) = &record.estimate {
                    writeln!(text, "  estimated: {}", few_digits(estimate))?;
                }
                if let Some(residual) = record.residual {
                    writeln!(text, "  residual {residual:.1e}")?;
                }
                if let Some(branch) = record.branch {
                    writeln!(text, "  branch {branch:?}")?;
                }
                write_figures(text, &figures.displacement, &figures.stiffness, precision)?;
                for b in &answer.balls {
                    let angles = [b.azimuth, b.alpha_i, b.alpha_o];
                    let rest = [
                        b.q_i,
                        b.q_o,
                        b.delta_i,
                        b.delta_o,
                        b.centrifugal_force,
                        b.gyroscopic_moment,
                    ];
                    write_ball(text, angles, rest)?;
                }
            }
            Err(why) => writeln!(text, "  {why}")?,
        }
        if let Some(truth) = &solve.truths[p] {
            writeln!(text, "\ntruth of {precision:?}")?;
            write_truth(text, truth)?;
        }
    }
    Ok(())
}

fn write_truth(text: &mut String, truth: &Solution) -> fmt::Result {
    writeln!(text, "  residual {:.1e}", truth.residual)?;
    write_figures(text, &truth.u, &truth.k, Precision::F64)?;
    for b in &truth.balls {
        let angles = [b.azimuth, b.alpha_i, b.alpha_o];
        write_ball(
            text,
            angles,
            [b.q_i, b.q_o, b.delta_i, b.delta_o, b.fc, b.mg],
        )?;
    }
    Ok(())
}

fn few_digits(values: &[f64]) -> String {
    values.iter().map(|x| format!("{x:.1e} ")).collect()
}

fn numbers(values: &[f64], precision: Precision) -> String {
    let shown: Vec<String> = values
        .iter()
        .map(|x| precision.show(*x).to_string())
        .collect();
    shown.join(", ")
}

fn write_figures(
    text: &mut String,
    u: &[f64; 5],
    k: &[[f64; 5]; 5],
    precision: Precision,
) -> fmt::Result {
    writeln!(text, "  u: {}", numbers(u, precision))?;
    for row in k {
        let row = row.map(|x| format!("{x:14.6e}"));
        writeln!(text, "  K: {}", row.join(" "))?;
    }
    Ok(())
}

fn write_ball(text: &mut String, angles: [f64; 3], rest: [f64; 6]) -> fmt::Result {
    let [at, inner, outer] = angles.map(f64::to_degrees);
    let [qi, qo, di, d_o, fc, mg] = rest;
    writeln!(
        text,
        "  at {at:8.3} deg: angles {inner:9.4} {outer:9.4} deg, Q {qi:11.4e} {qo:11.4e} N, \
         depths {di:11.4e} {d_o:11.4e} m, Fc {fc:10.3e} N, Mg {mg:10.3e} N m"
    )
}
