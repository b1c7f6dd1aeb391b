//! The study's own solver, and what its step factors cost.

use super::around::Tilt;
use super::statement::{Measure, Statement, Verdict, shown};
use super::{Block, Chapter, Progress, Table};
use crate::cases::{self, B7005C, rad_per_s};
use crate::compare::worse;
use crate::reference::Attitude;
use crate::study::{self, StudyOutcome, StudySettings};
use anyhow::Context;
use rayon::prelude::*;
use std::time::Instant;

const SPEEDS: [f64; 3] = [5_000.0, 10_000.0, 20_000.0];
const CASES: [(Tilt, f64); 4] = [
    (Tilt::Mz, 3.0),
    (Tilt::Mz, -3.0),
    (Tilt::My, 3.0),
    (Tilt::Both, 3.0),
];

struct Run {
    tilt: Tilt,
    moment: f64,
    rpm: f64,
    study: StudyOutcome,
    plain: StudyOutcome,
    /// Largest distance of the study's translations from the reference build's, m.
    off: f64,
}

fn run(tilt: Tilt, moment: f64, rpm: f64) -> anyhow::Result<Run> {
    let reference = cases::reference(&B7005C, 16);
    let (load, omega) = (tilt.load(moment), rad_per_s(rpm));
    let solve = |settings| study::solve(&reference, load, omega, Attitude::Raceless, settings);
    let truth = reference
        .search(load, omega, Attitude::Raceless)
        .with_context(|| format!("no equilibrium under {load:?} at {rpm} rpm to compare with"))?;
    let study = solve(&StudySettings::STUDY)?;
    let off = (0..3).fold(0.0, |m, i| worse(m, (study.u[i] - truth.u[i]).abs()));
    Ok(Run {
        tilt,
        moment,
        rpm,
        plain: solve(&StudySettings::PLAIN)?,
        study,
        off,
    })
}

/// The chapter.
///
/// # Errors
///
/// A load without an equilibrium.
pub fn chapter(progress: &dyn Progress) -> anyhow::Result<Chapter> {
    let points: Vec<_> = CASES
        .iter()
        .flat_map(|&(t, m)| SPEEDS.map(|rpm| (t, m, rpm)))
        .collect();
    progress.expect(points.len());
    let runs: Vec<Run> = points
        .into_par_iter()
        .map(|(tilt, moment, rpm)| {
            let run = run(tilt, moment, rpm);
            progress.done(1);
            run
        })
        .collect::<Result<_, _>>()?;

    let settled = |of: fn(&Run) -> &StudyOutcome| runs.iter().filter(|r| of(r).converged).count();
    let ratio = |r: &Run| r.study.ball_evaluations as f64 / r.plain.ball_evaluations as f64;
    let least = runs.iter().map(ratio).fold(f64::INFINITY, f64::min);
    let most = runs.iter().map(ratio).fold(0.0, f64::max);
    let steps = |of: fn(&Run) -> &StudyOutcome| {
        let steps = runs.iter().map(|r| of(r).outer_iterations);
        (
            steps.clone().min().unwrap_or(0) as f64,
            steps.max().unwrap_or(0) as f64,
        )
    };
    let (study_least, study_most) = steps(|r| &r.study);
    let (_, plain_most) = steps(|r| &r.plain);
    let off = runs.iter().fold(0.0, |m, r| worse(m, r.off));

    let rows = runs.iter().map(|r| {
        vec![
            format!("{} = {:+} N m", r.tilt.symbol(), r.moment),
            shown(r.rpm),
            r.study.outer_iterations.to_string(),
            r.study.ball_evaluations.to_string(),
            r.plain.outer_iterations.to_string(),
            r.plain.ball_evaluations.to_string(),
            shown(ratio(r)),
        ]
    });
    let table = Table {
        caption: "Steps of the outer iteration and evaluations of a ball's equations with their \
                  derivatives, with the study's step factors and without."
            .to_owned(),
        head: [
            "load",
            "rpm",
            "steps, h = 0.1",
            "evaluations",
            "steps, h = 1",
            "evaluations",
            "ratio of evaluations",
        ]
        .map(str::to_owned)
        .into(),
        rows: rows.collect(),
    };
    // The best of a few, so that other work on the machine does not count.
    let seconds = (0..3).map(|_| {
        let start = Instant::now();
        let outcome = study::solve(
            &cases::reference(&B7005C, 16),
            CASES[0].0.load(CASES[0].1),
            rad_per_s(SPEEDS[2]),
            Attitude::Raceless,
            &StudySettings::STUDY,
        );
        outcome.map(|_| start.elapsed().as_secs_f64())
    });
    let seconds = seconds.collect::<Result<Vec<f64>, _>>()?;
    let seconds = seconds.into_iter().fold(f64::INFINITY, f64::min);
    let count = runs.len();
    Ok(Chapter {
        title: "The study's solver",
        blocks: vec![
            Block::Text(
                "Nested Newton iterations with fixed step factors `h1 = h2` = 0.1, a tolerance of 1e-9 mm on a \
                 correction and at most 10,000 iterations, programmed after the study's description \
                 (`host_tests/src/study.rs`); then the same with step factors of 1, that is, without. \
                 Evaluations are counted rather than time, which depends on machine and programming. Both \
                 start from the ring's displacement at rest under axial load."
                    .to_owned(),
            ),
            Block::Table(table),
            Block::Statements(vec![
                Statement::of(
                    "item 7",
                    "The scheme with its step factors converges on the B7005C's loads, within its limit \
                     of 10,000 iterations, to the equilibria of the reference build.",
                    vec![
                        Measure::count("converged", settled(|r| &r.study), count),
                        Measure::rounding("largest distance of a translation", 1e9 * off, "nm", 0.02),
                        Measure::within("fewest steps", study_least, "", 100.0, 10_000.0),
                        Measure::within("most", study_most, "", 100.0, 10_000.0),
                    ],
                ),
                Statement::of(
                    "item 7",
                    "A solve takes less than 2 s.",
                    vec![Measure::rounding("`Mz` = 3 N m, 20,000 rpm, on the machine that tests this", seconds, "s", 2.0)],
                ),
                Statement::of(
                    "item 7",
                    "It is 10 times faster with the step factors than without.",
                    vec![
                        Measure::count("loads on which plain nested Newton converges", settled(|r| &r.plain), count),
                        Measure::within("most steps without factors", plain_most, "", 2.0, 20.0),
                        Measure::above("evaluations with factors over those without, least", least, "", 10.0),
                        Measure::above("largest", most, "", least),
                    ],
                )
                .but(
                    Verdict::DoesNotHold,
                    "On these loads plain Newton converges, too, and the factors make it slower by the \
                     ratio of evaluations: a factor `h` leaves `1 - h` of the error at each step, where \
                     Newton's own step squares it. From a worse start than this one plain Newton may fail; that was not tried.",
                ),
            ]),
        ],
    })
}
