//! One ball for all: the equilibrium under a purely axial load.

use super::solves::{
    AnySolver, Balls, GROWN, PRECISIONS, Question, errors, ring_solver, rounded, solver, stated,
};
use arbitrary::Unstructured;
use judge::cases::{self, B218, B7005C, SKF6205, SolvedCase, rad_per_s};
use judge::compare::Equilibrium;
use judge::laws::common::{
    Answer, Scale, design, growth, inspect, refused, settings, settings_in, several, signed,
    unharmed,
};
use judge::tolerances::allowed_at;
use proptest::prelude::*;
use solvers::dispatch::Precision;
use spindle_bearing::{
    AxialSolver, Bearing, Centrifugal, Design, FreeContact, Given, Growth, InnerRaceControl,
    Motion, OuterRaceControl, RacewayControlFree, Real, Settings, Speed, Static, Status,
};

/// A solver of one ball for all.
fn axial_solver(
    design: &Design,
    n: usize,
    precision: Precision,
    balls: Balls,
) -> Box<dyn AnySolver> {
    ring_solver(design, n, precision, balls, 1)
}

fn axial(load: f64, omega: f64) -> Question {
    Question::load([load, 0.0, 0.0, 0.0, 0.0], omega)
}

#[test]
fn solved_cases_that_are_purely_axial_are_solved_with_one_ball() {
    let mut count = 0;
    for SolvedCase { case, truth, .. } in cases::public() {
        if case.load[1..] != [0.0; 4] {
            continue;
        }
        count += 1;
        for precision in PRECISIONS {
            let mut motions = vec![case.attitude.into()];
            if case.omega == 0.0 {
                motions.push(Balls::Static);
            }
            for balls in motions {
                let found = axial_solver(&case.design, case.balls, precision, balls)
                    .load(case.load, case.omega)
                    .unwrap();
                let errors = errors(&found, &case.design, &truth, 1);
                let largest = truth.largest_displacement(case.pitch_radius());
                let allowed = allowed_at(precision, largest / case.design.centre_distance());
                assert!(errors.within(allowed), "{}: {errors}", case.name);
            }
        }
    }
    assert!(count >= 15, "{count} cases");
}

#[test]
fn one_ball_for_all_is_the_bearing_of_five_freedoms_under_an_axial_load() {
    let pressed = Growth {
        axial: -2e-6,
        radial: 14e-6,
        ball: 3e-7,
    };
    for (design, n, load, rpm) in [
        (&B7005C, 16, 1000.0, 20_000.0),
        (&B7005C, 16, 120.0, 6_000.0),
        (&B218, 16, 17_800.0, 10_000.0),
        (&SKF6205, 8, 300.0, 8_000.0),
    ] {
        for balls in [Balls::Static, Balls::Free, Balls::Outer, Balls::Inner] {
            for growth in [Growth::NONE, GROWN, pressed] {
                for (load, rpm) in [(load, 0.0), (load, rpm), (-load, rpm)] {
                    let question = axial(load, rad_per_s(rpm)).grown(growth);
                    for precision in PRECISIONS {
                        assert_one_ball_does((design, n), balls, precision, load, &question);
                    }
                }
            }
        }
    }
}

fn assert_one_ball_does(
    (design, n): (&Design, usize),
    balls: Balls,
    precision: Precision,
    load: f64,
    question: &Question,
) {
    let truth = solver(design, n, Precision::F64, balls).answer(question);
    let mut solver = axial_solver(design, n, precision, balls);
    let found = solver.answer(question);
    assert_eq!(found.load[0], load);
    assert_eq!(
        found.rows[0].balls[0].azimuth,
        truth.rows[0].balls[0].azimuth
    );
    let errors = errors(&found, design, &Equilibrium::from(&truth), 1);
    // Displacements cannot be better than growth in single precision.
    let (growth, moved) = (question.growth[0], truth.displacement[0].abs());
    let size = [growth.axial, growth.radial, growth.ball]
        .iter()
        .fold(moved, |size, g| size.max(g.abs()));
    let length = design.centre_distance();
    let mut allowed = allowed_at(precision, moved / length);
    allowed.displacement *= size / moved;
    if precision == Precision::F64 {
        // Both are off.
        allowed.contact_angle *= 3.0;
        allowed.force *= 3.0;
        allowed.stiffness *= 3.0;
    }
    let what = format!("{n} balls, {balls:?}, {precision:?}, {question:?}");
    assert!(errors.within(allowed), "{what}: {errors}");
    // The reaction to that displacement is that load.
    let mut reverse = question.clone();
    reverse.held[0] = Some(found.displacement[0]);
    let back = solver.answer(&reverse);
    let resolved = match precision {
        Precision::F32 => 6e-8,
        Precision::F64 => 1e-16,
    };
    let sum = size.max(2.0 * length * truth.rows[0].balls[0].alpha_i.sin().abs());
    let allowed = 1e-11 + 20.0 * resolved * (1.0 + found.stiffness[0][0] * sum / load.abs());
    let off = (back.load[0] / load - 1.0).abs();
    assert!(
        back.displacement == found.displacement && off < allowed,
        "{what}: {off:e}"
    );
}

#[test]
fn axial_loads_of_any_size_are_solved_at_rest() {
    for radial in [0.0, 1e-6, 8e-6, 20e-6, -15e-6] {
        for (precision, allowed) in PRECISIONS.into_iter().zip([1e-5, 1e-13]) {
            let mut solver = axial_solver(&SKF6205, 8, precision, Balls::Static);
            let mut ask = |load| {
                let question = axial(load, 0.0);
                solver.answer(&question.grown(Growth {
                    radial,
                    ..Growth::NONE
                }))
            };
            let mut last = f64::NEG_INFINITY;
            for step in -28..19 {
                let load = 10f64.powf(0.25 * f64::from(step));
                let (found, turned) = (ask(load), ask(-load));
                let ball = &found.rows[0].balls[0];
                let force = 8.0 * ball.q_i * ball.alpha_i.sin();
                for (a, b) in [
                    (force, load),
                    (turned.stiffness[0][0], found.stiffness[0][0]),
                    (turned.rows[0].balls[0].q_i, ball.q_i),
                ] {
                    assert!((a / b - 1.0).abs() < allowed, "{load} N: {a} {b}");
                }
                assert!(
                    found.stiffness[0][0] > 0.0 && found.displacement[0] >= last,
                    "{found:?}"
                );
                last = found.displacement[0];
            }
        }
    }
}

#[test]
fn a_ball_that_no_load_holds_against_its_inertia_is_refused_by_name() {
    for precision in PRECISIONS {
        for load in [1e-3, 1.0, 10.0, 100.0, 1e3, 1e4] {
            for rpm in [1e3, 1e4, 3e4, 1e5, 2e5] {
                let mut solver = axial_solver(&B7005C, 16, precision, Balls::Free);
                let Err(status) = solver.solve(&axial(load, rad_per_s(rpm))) else {
                    continue;
                };
                let of_the_solve = matches!(
                    status,
                    Status::Unseated { .. }
                        | Status::Diverged { .. }
                        | Status::IterationLimit
                        | Status::Indeterminate { .. }
                );
                assert!(of_the_solve, "{load} N, {rpm} rpm: {status}");
                // The next solve does not suffer.
                let usual = axial(1e3, 2094.0);
                let found = solver.answer(&usual);
                let fresh = axial_solver(&B7005C, 16, precision, Balls::Free).answer(&usual);
                let off = (found.stiffness[0][0] / fresh.stiffness[0][0] - 1.0).abs();
                let [.., of_k] = stated(&found, &fresh);
                assert!(off <= of_k, "{off:e}");
            }
        }
    }
}

#[test]
fn errors_are_numbers_where_the_ring_is_not_moved() {
    for free in [0.0, 0.3] {
        let design = Design {
            free_contact: FreeContact::Angle(free),
            ..B7005C
        };
        for balls in [Balls::Static, Balls::Free] {
            for precision in PRECISIONS {
                let mut solver = axial_solver(&design, 16, precision, balls);
                let found =
                    solver.answer(&Question::load([0.0; 5], 0.0).holding([true; 5], [0.0; 5]));
                let errors = found.error;
                assert!(errors.iter().all(|error| *error >= 0.0), "{errors:?}");
            }
        }
    }
}

/// The displacement of a ring that radial growth moves by as much as the load does is a small difference of both. Of each
/// hundred, one true error may be larger than stated.
#[test]
fn errors_stated_at_rest_cover_what_rounding_of_growth_adds_to_a_small_displacement() {
    for growth in [[5e-6, 0.0], [0.0, 5e-6], [-3e-6, 4e-6]] {
        let [along, radial] = growth.map(|x| rounded(Precision::F32, x));
        let [mut single, mut double] =
            PRECISIONS.map(|precision| axial_solver(&B7005C, 16, precision, Balls::Static));
        let larger = (0..400).filter(|&i| {
            let load = rounded(Precision::F32, 0.1 * 10f64.powf(f64::from(i) / 100.0));
            let question = axial(load, 0.0).grown(Growth {
                axial: along,
                radial,
                ball: 0.0,
            });
            let [found, truth] = [&mut single, &mut double].map(|solver| solver.answer(&question));
            (found.displacement[0] / truth.displacement[0] - 1.0).abs() > found.error[0]
        });
        let larger = larger.count();
        assert!(larger <= 4, "{growth:?}: {larger}");
    }
}

/// A solve at rest that ends without an answer leaves no start for the next one at speed: its references are gone.
#[test]
fn a_solve_at_speed_after_a_failed_one_at_rest_is_a_cold_one() {
    let bearing = Bearing::<f32, 16>::new(&B7005C).unwrap();
    let speed = Speed::rpm(20_000.0);
    let (mut solver, mut cold) = (AxialSolver::new(), AxialSolver::new());
    solver
        .solve(&bearing, 300.0, speed, &Settings::default())
        .unwrap();
    let one = Settings {
        max_iterations: 1,
        ..Settings::default()
    };
    assert!(solver.solve(&bearing, 250.0, Speed::REST, &one).is_err());
    let found = solver
        .solve(&bearing, 300.0, speed, &Settings::default())
        .unwrap();
    let (iterations, k) = (found.iterations, found.stiffness());
    let truth = cold
        .solve(&bearing, 300.0, speed, &Settings::default())
        .unwrap();
    assert_eq!((iterations, k), (truth.iterations, truth.stiffness()));
}

/// Any bearing, settings and sequence of loads or displacements: an answer in numbers, or a refusal that does no harm.
fn run<T: Real, M: Motion + Copy>(bits: &[u8]) -> arbitrary::Result<()> {
    let u = &mut Unstructured::new(bits);
    let design = design(u)?;
    let settings: Settings<T> = settings_in(settings(u)?);
    let bearing = match Bearing::<T, 16>::of(&design) {
        Ok(bearing) => bearing,
        Err(error) => {
            refused(&error);
            return Ok(());
        }
    };
    let scale = Scale::of(&design, 16);
    let ask = |solver: &mut AxialSolver<T, M>, asked: &(Given<T>, T, Growth<T>), settings: &_| {
        let (given, omega, growth) = *asked;
        let at = Speed::rad_per_s(omega).with_growth([growth]);
        let found = solver.solve(&bearing, given, at, settings)?;
        Ok(Answer {
            status: found.status,
            iterations: found.iterations,
            error: found.error,
            figures: vec![found.stiffness(), found.displacement, found.load],
            balls: vec![found.ball()],
        })
    };
    let probe = |solver: &AxialSolver<T, M>, near: &(Given<T>, T, Growth<T>)| {
        let found = ask(&mut solver.clone(), near, &Settings::default());
        format!("{found:?}")
    };
    let fresh = AxialSolver::<T, M>::of();
    let mut solver = fresh.clone();
    let light = Given::Load(T::of(1e-4 * scale.load[0]));
    let mut tried = (light, T::ZERO, Growth::NONE);
    while !u.is_empty() {
        let given = match u.ratio(3, 4)? {
            true => Given::Load(T::of(signed(u, 1e-12, 10.0)? * scale.load[0])),
            false => Given::Displacement(T::of(signed(u, 1e-9, 3.0)? * scale.displacement[0])),
        };
        let lengths = several(|_| signed(u, 1e-6, 0.3))?;
        let grown = growth(lengths.map(|x| x * scale.displacement[0]));
        let omega = T::of(signed(u, 1e-6, 3.0)? * scale.speed);
        let asked = (given, omega, grown);
        let before = solver.clone();
        let most = settings.max_iterations.max(1);
        let ended = inspect(ask(&mut solver, &asked, &settings), most);
        tried = unharmed(&ended, [&solver, &before, &fresh], tried, asked, probe);
    }
    Ok(())
}

proptest! {
    #[test]
    fn any_bits_end_in_numbers_or_in_a_refusal_that_does_no_harm(bits in prop::collection::vec(any::<u8>(), 100..400)) {
        // Bits that end within a number are a shorter run.
        for each in [run::<f32, Static>, run::<f32, Centrifugal>, run::<f32, RacewayControlFree>] {
            let _ = each(&bits);
        }
        for each in [run::<f32, OuterRaceControl>, run::<f32, InnerRaceControl>, run::<f64, RacewayControlFree>] {
            let _ = each(&bits);
        }
    }
}
