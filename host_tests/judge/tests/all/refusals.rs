//! Input without an answer: what is said to it, and that the solver survives it.

use super::solves::{
    Answer, AnySolver, Balls, PRECISIONS, Question, SKEW, ask, ring_solver, solver,
};
use judge::campaign;
use judge::campaign::families::{Family, Trial};
use judge::cases::{B218, B7005C, rad_per_s};
use solvers::dispatch::Precision;
use solvers::{Choices, with_solver};
use spindle_bearing::{
    Arrangement, AxialSolver, Bearing, Design, Facing, FreeContact, Growth, Motion, Preload,
    Quantity, RacewayControlFree, Settings, Solver, Speed, Spindle, SpindleSolver, Static, Status,
};
use spindle_file::mounting::{DynSolver, Parts};
use spindle_file::plan::{MOST_BALLS, Plan, Row};
use std::f64::consts::PI;

/// A number of a question: its name, how many freedoms a ring needs to be asked it, and where it goes.
type Input = (Quantity, usize, fn(&mut Question, f64));

/// Every number of a question.
const INPUTS: [Input; 14] = [
    (Quantity::Fx, 1, |q, x| q.load[0] = x),
    (Quantity::Fy, 3, |q, x| q.load[1] = x),
    (Quantity::Fz, 3, |q, x| q.load[2] = x),
    (Quantity::My, 5, |q, x| q.load[3] = x),
    (Quantity::Mz, 5, |q, x| q.load[4] = x),
    (Quantity::Dx, 1, |q, x| q.held[0] = Some(x)),
    (Quantity::Dy, 3, |q, x| q.held[1] = Some(x)),
    (Quantity::Dz, 3, |q, x| q.held[2] = Some(x)),
    (Quantity::Ty, 5, |q, x| q.held[3] = Some(x)),
    (Quantity::Tz, 5, |q, x| q.held[4] = Some(x)),
    (Quantity::Speed, 1, |q, x| q.omega = x),
    (Quantity::AxialGrowth, 1, |q, x| q.growth[0].axial = x),
    (Quantity::RadialGrowth, 1, |q, x| q.growth[0].radial = x),
    (Quantity::BallGrowth, 1, |q, x| q.growth[0].ball = x),
];

/// An ordinary question, but for one number.
fn with(set: fn(&mut Question, f64), x: f64) -> Question {
    let mut question = Question::load(SKEW, rad_per_s(10_000.0)).grown(Growth::NONE);
    set(&mut question, x);
    question
}

/// Answers at rest and at speed, in both precisions, of all rings with so many freedoms or more.
fn answers(freedoms: usize, question: &Question) -> Vec<Result<Answer, Status<f32>>> {
    let mut answers = Vec::new();
    for freedoms in [1, 3, 5].into_iter().filter(|of| *of >= freedoms) {
        for balls in [Balls::Static, Balls::Free] {
            for precision in PRECISIONS {
                let mut solver = ring_solver(&B7005C, 16, precision, balls, freedoms);
                answers.push(solver.solve(question));
            }
        }
    }
    answers
}

#[test]
fn input_that_is_not_finite_or_absurd_is_named() {
    for (expected, freedoms, set) in INPUTS {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e30, -1e30] {
            for answer in answers(freedoms, &with(set, bad)) {
                let (quantity, value) = match answer {
                    Err(Status::NotFinite { quantity, value }) if !bad.is_finite() => {
                        (quantity, value)
                    }
                    Err(Status::OutOfRange {
                        quantity,
                        value,
                        limit,
                    }) if bad.is_finite() => {
                        assert!(limit.is_finite() && value.abs() > limit);
                        (quantity, value)
                    }
                    other => panic!("{expected} = {bad}: {other:?}"),
                };
                assert_eq!(quantity, expected);
                assert_eq!(value.to_bits(), (bad as f32).to_bits());
            }
        }
    }
}

#[test]
fn a_tolerance_that_is_none_is_named_and_one_of_0_ends_by_rounding() {
    let row = |position, facing| Row {
        position,
        facing,
        preload: Preload::Force(200.0),
        ..Plan::alone(&B7005C, 16).rows[0].clone()
    };
    let pair = Plan::of(vec![row(0.0, Facing::PlusX), row(0.1, Facing::MinusX)]);
    let statuses = |precision, tolerance: f64, omega| {
        let choices = Choices {
            tolerance: Some(tolerance),
            ..Choices::default()
        };
        let ask = |solver: &mut dyn AnySolver| {
            solver.choose(&choices);
            solver.load(SKEW, omega).map(|found| found.status)
        };
        let set = with_solver(&pair, Balls::Free, precision, ask).unwrap();
        let [one, axial] = [5, 1].map(|freedoms| {
            ask(&mut *ring_solver(
                &B7005C,
                16,
                precision,
                Balls::Free,
                freedoms,
            ))
        });
        [one, set, axial]
    };
    for precision in PRECISIONS {
        for omega in [0.0, rad_per_s(10_000.0)] {
            for bad in [f64::NAN, f64::INFINITY, -1e-3] {
                for status in statuses(precision, bad, omega) {
                    let (quantity, value) = match status {
                        Err(Status::NotFinite { quantity, value }) => (quantity, value),
                        Err(Status::OutOfRange {
                            quantity, value, ..
                        }) => (quantity, value),
                        other => panic!("{bad}: {other:?}"),
                    };
                    assert_eq!(quantity, Quantity::Tolerance);
                    assert_eq!(value.to_bits(), (bad as f32).to_bits());
                }
            }
            for tolerance in [0.0, 1e-20] {
                let [one, set, _] = statuses(precision, tolerance, omega);
                let by_rounding = [Ok(Status::PrecisionLimit); 2];
                assert_eq!([one, set], by_rounding, "{tolerance} at {omega}");
            }
        }
    }
}

/// A 608 with a clearance of 8 um.
#[test]
fn the_advice_to_a_ring_that_is_free_to_move_helps() {
    let design = Design {
        free_contact: FreeContact::DiametralClearance(8e-6),
        ..Design::angular_contact(3.969e-3, 15e-3, 0.0)
    };
    let bearing = Bearing::<f64, 16>::with_balls(&design, 7).unwrap();
    let settings = Settings::default();
    for rpm in [0.0, 10_000.0] {
        let speed = Speed::rpm(rpm);
        let under = |load| {
            let mut solver = Solver::new();
            solver.solve(&bearing, load, speed, &settings).map(|_| ())
        };
        // On one ball, and between two.
        for (y, z, helps_to_hold) in [(10.0, 0.0, false), (10.0, 3.0, true)] {
            let advice = under([0.0, y, z, 0.0, 0.0]).unwrap_err().to_string();
            assert!(advice.contains("preload it by an axial load or by a row that faces it"));
            assert_eq!(advice.contains("hold the tilts"), helps_to_hold, "{advice}");
            let mut held = ring_solver(&design, 7, Precision::F64, Balls::Free, 3);
            let held = held.load([0.0, y, z, 0.0, 0.0], rad_per_s(rpm));
            assert_eq!(held.is_ok(), helps_to_hold);
            assert_eq!(under([5.0, y, z, 0.0, 0.0]), Ok(()));
            let preload = Preload::Force(10.0);
            let pair = Spindle::pair(Arrangement::BackToBack, &bearing, 0.03, preload).unwrap();
            let mut faced = SpindleSolver::new();
            assert!(
                faced
                    .solve(&pair, [0.0, y, z, 0.0, 0.0], speed, &settings)
                    .is_ok()
            );
        }
    }
}

/// Input that cannot be is named before the missing load, by a set as by a bearing.
#[test]
fn a_speed_that_is_no_number_is_named_without_a_load_too() {
    let question = Question::load([0.0; 5], f64::NAN);
    let plan = Plan::alone(&B7005C, 16);
    for refused in [
        solver(&B7005C, 16, Precision::F64, Balls::Free).solve(&question),
        ask(&plan, Balls::Free, Precision::F64, &question),
    ] {
        let quantity = Quantity::Speed;
        let is_speed = |s| matches!(s, Status::NotFinite { quantity: q, .. } if q == quantity);
        assert!(refused.is_err_and(is_speed));
    }
}

#[test]
fn balls_at_rest_refuse_a_speed() {
    let plan = Plan::alone(&B7005C, 16);
    let parts = Parts::<f64>::of(&plan).unwrap();
    let spindle = parts.spindle(&plan).unwrap();
    let bearing = Bearing::<f64, MOST_BALLS>::with_balls(&B7005C, 16).unwrap();
    for omega in [1e-3, -4000.0] {
        let (speed, settings) = (Speed::rad_per_s(omega), Settings::default());
        let mut one = Solver::<f64, MOST_BALLS, Static>::of();
        let mut all = AxialSolver::<f64, Static>::of();
        let mut shaft = DynSolver::<f64, Static>::of();
        for refused in [
            one.solve(&bearing, SKEW, speed, &settings).err(),
            all.solve(&bearing, SKEW[0], speed, &settings).err(),
            shaft.solve(&spindle, SKEW, speed, &settings).err(),
        ] {
            let quantity = Quantity::Speed;
            let expected = Status::OutOfRange {
                quantity,
                value: omega,
                limit: 0.0,
            };
            assert_eq!(refused, Some(expected));
        }
    }
}

#[test]
fn an_unloaded_bearing_has_no_position() {
    for omega in [0.0, rad_per_s(20_000.0)] {
        for answer in answers(1, &Question::load([0.0; 5], omega)) {
            assert_eq!(answer.err(), Some(Status::Unloaded));
        }
    }
}

#[test]
fn a_ring_on_one_or_two_balls_is_indeterminate() {
    // Three balls with clearance, under a radial load in the plane of the groove centres. The first
    // ball carries alone if it lies in the direction of the load, two of them if the load points
    // between them. Nothing holds the ring in the other directions.
    fn assert_indeterminate<M: Motion>(first_ball: f64, expected: u16) {
        let design = Design {
            free_contact: FreeContact::DiametralClearance(20e-6),
            first_ball,
            ..B7005C
        };
        let bearing = Bearing::<f64, MOST_BALLS>::with_balls(&design, 3).unwrap();
        let mut solver = Solver::<f64, MOST_BALLS, M>::of();
        let load = [0.0, 50.0, 0.0, 0.0, 0.0];
        match solver.solve(&bearing, load, Speed::REST, &Settings::default()) {
            Err(Status::Indeterminate { loaded_balls, .. }) if loaded_balls == expected => {}
            other => panic!("on {expected}: {other:?}"),
        }
    }
    assert_indeterminate::<Static>(0.0, 1);
    assert_indeterminate::<Static>(PI / 3.0, 2);
    assert_indeterminate::<RacewayControlFree>(0.0, 1);
    assert_indeterminate::<RacewayControlFree>(PI / 3.0, 2);
}

#[test]
fn a_refusal_says_what_and_how_much() {
    use Quantity::{BallGrowth, Dx, Fx, Mz, RadialGrowth, Speed};
    for (quantity, bad, start) in [
        (Fx, f64::NAN, "axial load Fx (N) is NaN"),
        (Mz, f64::INFINITY, "tilting moment Mz (N m) is inf"),
        (Mz, -1e30, "tilting moment Mz (N m) is -1e30, beyond the "),
        (Dx, 1.0, "axial displacement dx (m) is 1e0, beyond the "),
        (Speed, 1e30, "speed omega (rad/s) is 1e30, beyond the "),
        (RadialGrowth, 1.0, "radial growth gr (m) is 1e0, beyond "),
        (
            BallGrowth,
            1.0,
            "growth of the ball diameter gD (m) is 1e0, ",
        ),
    ] {
        let mut inputs = INPUTS.into_iter();
        let (.., set) = inputs.find(|input| input.0 == quantity).unwrap();
        let refused = solver(&B7005C, 16, Precision::F64, Balls::Free).solve(&with(set, bad));
        let told = refused.unwrap_err().to_string();
        assert!(told.starts_with(start), "{told}");
    }
    assert!(Status::<f32>::Unloaded.to_string().contains("no load"));
}

/// Drives balls of the 218 out of their grooves: it hardly presses them.
const DRIVEN_OUT: ([f64; 5], f64) = ([10.0, 500.0, 0.0, 0.0, 0.0], 2500.0);

/// The solver runs out of iterations there more often than a ball is named.
#[test]
fn a_load_under_which_speed_drives_a_ball_out_of_its_groove_has_no_answer() {
    let (load, omega) = DRIVEN_OUT;
    for precision in PRECISIONS {
        let mut solver = solver(&B218, 16, precision, Balls::Free);
        // Each goes on where the one before ran out of iterations.
        for _ in 0..6 {
            match solver.solve(&Question::load(load, omega)).unwrap_err() {
                Status::Unseated { ball, apart } => {
                    // The radial load presses ball 0, at +y; ball 8 is opposite.
                    assert_eq!(ball, 8);
                    let apart = f64::from(apart);
                    assert!(apart > PI / 2.0 && apart < PI, "{apart}");
                }
                Status::IterationLimit | Status::Diverged { .. } | Status::Indeterminate { .. } => {
                }
                other => panic!("{precision:?}: {other}"),
            }
        }
    }
}

#[test]
fn preload_keeps_balls_in_their_grooves() {
    let mut solver = solver(&B218, 16, Precision::F64, Balls::Free);
    let (mut load, omega) = DRIVEN_OUT;
    assert!(solver.solve(&Question::load(load, omega)).is_err());
    load[0] = 20_000.0;
    let found = solver.load(load, omega).unwrap();
    assert_eq!(found.status, Status::Converged);
    for ball in &found.rows[0].balls {
        assert!((ball.alpha_i - ball.alpha_o).abs() < PI / 2.0);
    }
}

#[test]
fn a_refusal_leaves_the_solver_as_it_was() {
    let omega = rad_per_s(20_000.0);
    let bad = INPUTS.into_iter().map(|(_, _, set)| set);
    let mut refusals: Vec<Question> = bad
        .flat_map(|set| [f64::NAN, 1e30].map(|bad| with(set, bad)))
        .collect();
    refusals.push(Question::load([0.0; 5], omega));
    for balls in [Balls::Static, Balls::Free] {
        let [mut refused, mut control] = [0; 2].map(|_| solver(&B7005C, 16, Precision::F64, balls));
        let (mut usual, mut next) = (SKEW, SKEW.map(|x| 1.02 * x));
        for question in &refusals {
            for solver in [&mut refused, &mut control] {
                solver.load(usual, omega).unwrap();
            }
            assert!(refused.solve(question).is_err());
            let [a, b] =
                [&mut refused, &mut control].map(|solver| solver.load(next, omega).unwrap());
            assert_eq!(a, b, "after {question:?}");
            std::mem::swap(&mut usual, &mut next);
        }
    }
}

/// The campaign judges the answers to any bits. Whatever comes of them, the next solve has its answer.
#[test]
fn a_solver_works_on_after_any_bits() {
    for balls in [Balls::Static, Balls::Free, Balls::Outer, Balls::Inner] {
        for precision in PRECISIONS {
            let mut solver = solver(&B7005C, 16, precision, balls);
            for index in 0..400 {
                let wild = Trial::new(campaign::Plan::SEED, Family::AnyBits, index).case;
                if let Ok(found) = solver.solve(&Question::load(wild.load, wild.omega)) {
                    let figures = found.displacement.iter().chain(&found.load);
                    assert!(
                        figures
                            .chain(found.stiffness.as_flattened())
                            .all(|x| x.is_finite())
                    );
                    assert!(
                        found.rows[0]
                            .balls
                            .iter()
                            .all(|b| b.q_i >= 0.0 && b.q_o >= 0.0)
                    );
                }
                solver.load(SKEW, 100.0).unwrap();
            }
        }
    }
}
