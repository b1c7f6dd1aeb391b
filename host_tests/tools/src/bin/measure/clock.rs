//! Times on this machine: the solver, the reference build and the study's scheme in one run, over the
//! same cases.

use crate::host::{Host, Truth};
use crate::plan::{self, bar};
use crate::rows::{Row, Rows};
use crate::workload::Work;
use anyhow::Result;
use host_tests::cases;
use host_tests::compare::stiffness_error;
use host_tests::dispatch::Attitude;
use host_tests::reference;
use host_tests::study::{self, StudySettings};
use spindle_bearing::{Settings, Solver, Speed};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Ball count.
const BALLS: usize = 16;
/// Shortest time that is measured, and how often.
const SPAN: Duration = Duration::from_micros(300);
const ROUNDS: usize = 3;

/// Seconds of one call, the shortest of a few rounds.
fn seconds(mut call: impl FnMut()) -> f64 {
    let mut calls = 1_u32;
    loop {
        let start = Instant::now();
        for _ in 0..calls {
            call();
        }
        if start.elapsed() >= SPAN {
            break;
        }
        calls *= 2;
    }
    (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            for _ in 0..calls {
                call();
            }
            start.elapsed().as_secs_f64() / f64::from(calls)
        })
        .fold(f64::INFINITY, f64::min)
}

/// Seconds of a cold solve and of a warm one, and the iterations of both; none if there is no answer.
fn solver<T: Host>(work: &Work) -> Result<Option<[(f64, f64); 2]>> {
    let bearing = T::built::<BALLS>(&work.design)?;
    let mut solver = Solver::new(&bearing);
    let settings = Settings::default();
    let [cold, warm] = [work.cold, work.warm]
        .map(|(load, omega)| (load.map(T::of), Speed::rad_per_s(T::of(omega))));
    let mut ask = |(load, speed): ([T; 5], Speed<T>), cold: bool| {
        if cold {
            solver.reset();
        }
        let solution = solver.solve(black_box(load), black_box(speed), &settings);
        let solution = black_box(solution).ok()?;
        black_box(solution.stiffness());
        Some(f64::from(solution.iterations))
    };
    let (Some(cold_count), Some(warm_count)) = (ask(cold, true), ask(warm, false)) else {
        return Ok(None);
    };
    let cold_time = seconds(|| {
        ask(cold, true);
    });
    // To and fro: both are warm ticks of the same size.
    let warm_time = seconds(|| {
        ask(cold, false);
        ask(warm, false);
    }) / 2.0;
    Ok(Some([(cold_time, cold_count), (warm_time, warm_count)]))
}

/// What somebody needs for the cases.
#[derive(Default)]
struct Column {
    who: &'static str,
    start: &'static str,
    times: Vec<f64>,
    ratios: Vec<f64>,
    /// Time of the reference build over ours.
    gains: Vec<f64>,
    passes: Vec<f64>,
    errors: Vec<f64>,
    failures: usize,
}

/// Measures, and tells the figures.
pub fn run(works: &[Work], truths: &[Truth]) -> Result<Rows> {
    let progress = bar(works.len() as u64)?;
    progress.set_message("times on this machine");
    let column = |who, start| Column {
        who,
        start,
        ..Column::default()
    };
    let mut columns = [
        column("f64", "cold"),
        column("f64", "warm"),
        column("f32", "cold"),
        column("f32", "warm"),
        column("reference build", "cold"),
        column("study's scheme", "cold"),
        column("nested Newton", "cold"),
    ];
    for (work, truth) in works.iter().zip(truths) {
        progress.inc(1);
        let (load, omega) = work.cold;
        let (Some(double), Some(single), [Some(truth), _]) =
            (solver::<f64>(work)?, solver::<f32>(work)?, truth)
        else {
            continue;
        };
        let ours = double[0].0;
        let mut note = |column: usize, time: f64, passes: f64| {
            columns[column].times.push(time);
            columns[column].ratios.push(time / ours);
            columns[column].passes.push(passes);
        };
        for (i, (time, iterations)) in double.into_iter().chain(single).enumerate() {
            note(i, time, iterations);
        }
        let reference = cases::reference(&work.design, BALLS);
        let rule: reference::Attitude = Attitude::Raceless.into();
        let start = Instant::now();
        match reference.solve(load, omega, rule) {
            Ok(solution) => {
                let time = start.elapsed().as_secs_f64();
                columns[4].times.push(time);
                columns[4].ratios.push(time / ours);
                for (column, (ours, _)) in columns.iter_mut().zip(double.into_iter().chain(single))
                {
                    column.gains.push(time / ours);
                }
                columns[4]
                    .errors
                    .push(stiffness_error(&solution.k, &truth.stiffness));
            }
            Err(_) => columns[4].failures += 1,
        }
        for (column, settings) in [(5, StudySettings::STUDY), (6, StudySettings::PLAIN)] {
            let start = Instant::now();
            let outcome = study::solve(&reference, load, omega, rule, &settings);
            let time = start.elapsed().as_secs_f64();
            let column = &mut columns[column];
            match outcome {
                Ok(outcome) if outcome.converged => {
                    column.times.push(time);
                    column.ratios.push(time / ours);
                    column
                        .passes
                        .push(outcome.ball_evaluations as f64 / BALLS as f64);
                    column
                        .errors
                        .push(stiffness_error(&outcome.k, &truth.stiffness));
                }
                _ => column.failures += 1,
            }
        }
    }
    progress.finish_and_clear();
    let mut rows = Rows::default();
    for column in &columns {
        column.rows(&mut rows);
    }
    Ok(rows)
}

impl Column {
    fn rows(&self, rows: &mut Rows) {
        let mut add = |metric: &str, values: &[f64], unit: &'static str| {
            let mut values = values.to_vec();
            values.sort_unstable_by(f64::total_cmp);
            for (stat, share) in [
                ("5 %", 0.05),
                ("median", 0.5),
                ("95 %", 0.95),
                ("99 %", 0.99),
            ] {
                let rank = (share * values.len() as f64).ceil() as usize;
                let Some(value) = values.get(rank.saturating_sub(1)) else {
                    continue;
                };
                rows.push(self.row(metric, stat, *value, unit));
            }
        };
        add("time", &self.times, "s");
        add("time over f64 cold", &self.ratios, "1");
        add("time of the reference build", &self.gains, "1");
        add("passes a ball", &self.passes, "1");
        add("stiffness error", &self.errors, "1");
        rows.push(self.row("answers", "value", self.times.len() as f64, "1"));
        rows.push(self.row("no answer", "value", self.failures as f64, "1"));
    }

    fn row(&self, metric: &str, stat: &'static str, value: f64, unit: &'static str) -> Row {
        Row {
            core: "host",
            precision: self.who,
            scene: "at speed",
            attitude: Some(plan::USUAL.name()),
            balls: BALLS,
            start: Some(self.start),
            metric: metric.to_owned(),
            stat,
            value,
            unit,
        }
    }
}
