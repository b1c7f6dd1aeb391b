//! Solves that are stopped: the states that they have reached, and how the next one goes on from there.

use super::solves::SKEW;
use host_tests::cases::B7005C;
use host_tests::compare::stiffness_error;
use host_tests::milling_cycle::{Place, recorded};
use host_tests::telemetry::simulated::monitored;
use rayon::prelude::*;
use spindle_bearing::{Bearing, Given, Growth, Settings, Solver, Speed, SpindleSolver, Status};
use std::f64::consts::{PI, TAU};

/// A tick of one bearing: whether it was solved, and the errors of its stiffness, true and as stated.
struct Tick {
    solved: bool,
    error: f64,
    stated: f64,
}

/// Two seconds of a cut, one solver, at most so many iterations a tick: S 6005 C at 20,000 rpm, teeth at 133 Hz.
fn cut(max_iterations: u16) -> Vec<Tick> {
    let (single, double) = (
        Bearing::<f32, 15>::new(&B7005C).unwrap(),
        Bearing::<f64, 15>::new(&B7005C).unwrap(),
    );
    let (mut solver, mut judge) = (Solver::new(&single), Solver::new(&double));
    let settings = Settings {
        max_iterations,
        ..Settings::TICK
    };
    (0..2000)
        .map(|tick| {
            let (sin, cos) = (TAU * 133.0 * f64::from(tick) / 1000.0).sin_cos();
            let load = [400.0 + 300.0 * sin, 100.0 + 200.0 * cos, 0.0, 0.0, 0.0];
            let truth = judge.solve(load, Speed::rpm(20_000.0), &Settings::default());
            let truth = truth.unwrap().stiffness();
            let load = load.map(|x| x as f32);
            let (status, k, error) = match solver.solve(load, Speed::rpm(20_000.0), &settings) {
                Ok(found) => (found.status, found.stiffness(), found.error),
                Err(status) => {
                    let found = solver.unfinished().unwrap();
                    assert_eq!(found.status, status);
                    (status, found.stiffness(), found.error)
                }
            };
            Tick {
                solved: status != Status::IterationLimit,
                error: stiffness_error(&k.map(|row| row.map(f64::from)), &truth),
                stated: f64::from(error.stiffness),
            }
        })
        .collect()
}

/// Longest time, in ticks, since one that is good.
fn longest(ticks: impl IntoIterator<Item = bool>) -> usize {
    let (mut age, mut longest) = (0, 0);
    for good in ticks {
        age = if good { 0 } else { age + 1 };
        longest = longest.max(age);
    }
    longest
}

/// The table in docs/firmware.md.
#[test]
fn a_tick_without_an_answer_has_a_stiffness_within_the_error_that_it_states() {
    // Iterations; ticks that are solved, %; median of the true error of the others; longest age of one stated good to 1 %, ms.
    for (iterations, solved, median, age) in [
        (2, 28.0, 2e-3, 4),
        (3, 62.0, 2.2e-3, 2),
        (4, 76.0, 3e-4, 1),
        (5, 100.0, 0.0, 0),
    ] {
        let ticks = cut(iterations);
        let percent = |count: usize| 100.0 * count as f64 / ticks.len() as f64;
        let covered = ticks
            .iter()
            .filter(|tick| tick.error <= tick.stated)
            .count();
        assert!(percent(covered) >= 99.9, "{iterations}: {covered}");
        let is_solved = percent(ticks.iter().filter(|tick| tick.solved).count());
        assert!(
            (is_solved - solved).abs() < 1.0,
            "{iterations}: {is_solved}"
        );
        // Once the first solve, from nothing, is done.
        let good = ticks
            .iter()
            .skip(20)
            .map(|tick| tick.stated <= 1e-2 && tick.error <= tick.stated);
        assert_eq!(longest(good), age, "{iterations}");
        let open = ticks.iter().filter(|tick| !tick.solved);
        let middle = |mut of: Vec<f64>| {
            of.sort_by(f64::total_cmp);
            of.get(of.len() / 2).copied().unwrap_or(0.0)
        };
        let ratio = middle(open.clone().map(|tick| tick.stated / tick.error).collect());
        assert!(ratio < 30.0, "{iterations}: {ratio}");
        let error = middle(open.map(|tick| tick.error).collect());
        assert!(error <= median, "{iterations}: {error:e}");
    }
}

/// Passing teeth, ramps and the recorded cycle on the monitored pair, at 1 kHz.
#[test]
fn no_estimate_of_a_pair_that_cuts_is_older_than_3_ms() {
    let teeth = [50.0, 125.0, 200.0, 400.0]
        .into_iter()
        .flat_map(|per_second| {
            [200.0, 500.0, 1000.0]
                .into_iter()
                .flat_map(move |amplitude| {
                    [1.0, 0.5].map(|in_cut| -> Vec<[f64; 6]> {
                        let force = |tick: u32| {
                            let phase: f64 = (per_second * 1.0007e-3 * f64::from(tick)).fract();
                            let y = 0.55 * amplitude * (PI * phase.min(in_cut) / in_cut).sin();
                            [0.0, y, 0.0, 0.0, -0.05 * y, 1500.0]
                        };
                        (0..3000).map(force).collect()
                    })
                })
        });
    // From idling to 2,500 N more and back, in each direction.
    let ramps = [50.0, 100.0, 200.0].into_iter().flat_map(|rate| {
        const FORCE: f64 = 2500.0;
        const PAUSE: f64 = 20.3;
        [
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
            [0.0, 0.6, 0.8],
        ]
        .map(|along| -> Vec<[f64; 6]> {
            let rise = FORCE / rate;
            let force = |tick: u32| {
                let at = f64::from(tick) % (2.0 * (rise + PAUSE));
                let up = (at - PAUSE).clamp(0.0, rise);
                let down = (at - 2.0 * PAUSE - rise).clamp(0.0, rise);
                let [x, y, z] = along.map(|part| 0.55 * part * rate * (up - down));
                [x, y, z, 0.05 * z, -0.05 * y, 1500.0]
            };
            (0..3000).map(force).collect()
        })
    });
    let cycle = recorded(Place::Nose).into_iter().map(|row| {
        let [x, y, z, my, mz] = row.load;
        [x, y, z, my, mz, row.omega()]
    });
    let cuts: Vec<Vec<[f64; 6]>> = teeth.chain(ramps).chain([cycle.collect()]).collect();
    let bearing: &'static Bearing<f32, 16> = Box::leak(Box::new(
        Bearing::<f32, 16>::new(&monitored::DESIGN).unwrap(),
    ));
    let ages: Vec<usize> = cuts
        .par_iter()
        .map(|cut| {
            let mut solver = SpindleSolver::new(monitored::spindle(bearing).unwrap());
            let mut settings = Settings::default();
            longest(cut.iter().map(|tick| {
                let [x, y, z, my, mz, omega] = tick.map(|x| x as f32);
                let solved = solver.solve([x, y, z, my, mz], Speed::rad_per_s(omega), &settings);
                settings = Settings::TICK;
                solved.is_ok()
            }))
        })
        .collect();
    assert!(ages.iter().all(|age| *age <= 3), "{ages:?}");
}

#[test]
fn a_solve_in_parts_has_the_bits_of_one_in_a_piece() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    for (load, rpm) in [
        (SKEW, 20_000.0),
        ([200.0, 30.0, 0.0, 0.0, 0.0], 40_000.0),
        (SKEW, 0.0),
    ] {
        let (given, speed) = (load.map(Given::Load), Speed::rpm(rpm));
        let whole = Solver::new(&bearing)
            .solve(load, speed, &Settings::default())
            .unwrap()
            .snapshot();
        let mut solver = Solver::new(&bearing);
        let found = (1..100).find_map(|passes| {
            let settings = Settings::default();
            let mut left = passes;
            // Of one pass, of two, and so on.
            let more_time = || {
                left -= 1;
                left > 0
            };
            let solved = solver.solve_while(&given, speed, &Growth::NONE, &settings, more_time);
            solved.ok().map(|solution| solution.snapshot())
        });
        let found = found.unwrap();
        assert_eq!(found.displacement, whole.displacement);
        assert_eq!(found.stiffness, whole.stiffness);
    }
}
