//! Input without an answer: what is said to it, and that the solver survives it.

use super::solves::{Balls, PRECISIONS, Question, SKEW, solver, turning};
use host_tests::cases::{B218, B7005C, rad_per_s};
use host_tests::dispatch::Precision;
use proptest::prelude::*;
use spindle_bearing::{
    Arrangement, AxialSolver, Bearing, Facing, Full, Given, Motion, Mounted, Settings, Solver,
    Speed, Spindle, SpindleSolver, Static,
};
use spindle_bearing::{
    Design, FreeContact, InnerRaceControl, OuterRaceControl, Quantity, Real, Status,
};
use std::f64::consts::PI;

const SPEED: f64 = 1000.0;

type Input = (Quantity, fn(&mut Question, f64));

/// Every number of a question.
const INPUTS: [Input; 14] = [
    (Quantity::Fx, |q, x| q.given[0] = Given::Load(x)),
    (Quantity::Fy, |q, x| q.given[1] = Given::Load(x)),
    (Quantity::Fz, |q, x| q.given[2] = Given::Load(x)),
    (Quantity::My, |q, x| q.given[3] = Given::Load(x)),
    (Quantity::Mz, |q, x| q.given[4] = Given::Load(x)),
    (Quantity::Dx, |q, x| q.given[0] = Given::Displacement(x)),
    (Quantity::Dy, |q, x| q.given[1] = Given::Displacement(x)),
    (Quantity::Dz, |q, x| q.given[2] = Given::Displacement(x)),
    (Quantity::Ty, |q, x| q.given[3] = Given::Displacement(x)),
    (Quantity::Tz, |q, x| q.given[4] = Given::Displacement(x)),
    (Quantity::Speed, |q, x| q.omega = x),
    (Quantity::AxialGrowth, |q, x| q.growth.axial = x),
    (Quantity::RadialGrowth, |q, x| q.growth.radial = x),
    (Quantity::BallGrowth, |q, x| q.growth.ball = x),
];

/// What solvers at rest and at speed, in both precisions, say to a question.
fn answers(question: &Question) -> impl Iterator<Item = Option<Status<f32>>> {
    let solvers = [Balls::Static, Balls::Free]
        .into_iter()
        .flat_map(|balls| PRECISIONS.map(|precision| (balls, precision)));
    solvers.map(|(balls, precision)| solver(&B7005C, 16, precision, balls).ask(question).err())
}

// ---------------------------------------------------------------------------------------------
// Loads, displacements, speeds, growth

#[test]
fn input_that_is_not_finite_is_named() {
    for (expected, set) in INPUTS {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut question = Question::load(SKEW, SPEED);
            set(&mut question, bad);
            for answer in answers(&question) {
                match answer {
                    Some(Status::NotFinite { quantity, value }) => {
                        assert_eq!(quantity, expected);
                        assert_eq!(value.to_bits(), (bad as f32).to_bits());
                    }
                    other => panic!("{expected} = {bad}: {other:?}"),
                }
            }
        }
    }
}

#[test]
fn absurd_input_is_out_of_range() {
    for (expected, set) in INPUTS {
        for bad in [1e30, -1e30] {
            let mut question = Question::load(SKEW, SPEED);
            set(&mut question, bad);
            for answer in answers(&question) {
                match answer {
                    Some(Status::OutOfRange {
                        quantity,
                        value,
                        limit,
                    }) => {
                        assert_eq!(quantity, expected);
                        assert_eq!(value, bad as f32);
                        assert!(limit.is_finite() && value.abs() > limit);
                    }
                    other => panic!("{expected} = {bad}: {other:?}"),
                }
            }
        }
    }
}

#[test]
fn balls_at_rest_refuse_a_speed() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let axial = Mounted::<f64, 16>::new(&bearing, 0.0, Facing::PlusX);
    let spindle = Spindle::new(Arrangement::ByRows, [axial]).unwrap();
    for omega in [1e-3, -4000.0] {
        let (speed, settings) = (Speed::rad_per_s(omega), Settings::default());
        let mut one = Solver::<f64, 16, Static>::of(&bearing);
        let mut all = AxialSolver::<f64, 16, Static>::of(&bearing);
        let mut shaft = SpindleSolver::<f64, 1, 16, Static>::of(spindle);
        for refused in [
            one.solve(SKEW, speed, &settings).err(),
            all.solve(SKEW[0], speed, &settings).err(),
            shaft.solve(SKEW, speed, &settings).err(),
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
        for answer in answers(&Question::load([0.0; 5], omega)) {
            assert_eq!(answer, Some(Status::Unloaded));
        }
    }
}

#[test]
fn a_ring_on_one_or_two_balls_is_indeterminate() {
    // Three balls with clearance, under a radial load in the plane of the groove centres: the first
    // ball carries alone if it lies in the direction of the load, two of them if the load points
    // between them; nothing holds the ring in the other directions.
    fn check<M: Motion>(first_ball: f64, expected: u16) -> String {
        let clearance = 20e-6;
        let design = Design {
            free_contact: FreeContact::DiametralClearance(clearance),
            first_ball,
            ..B7005C
        };
        let bearing = Bearing::<f64, 3>::new(&design).unwrap();
        let mut solver = Solver::<f64, 3, M>::of(&bearing);
        let load = [0.0, 50.0, 0.0, 0.0, 0.0];
        match solver.solve(load, Speed::REST, &Settings::default()) {
            Err(Status::Indeterminate { loaded_balls, .. }) if loaded_balls == expected => {
                String::new()
            }
            other => format!("on {expected}: {other:?}\n"),
        }
    }
    let complaints = [
        check::<Static>(0.0, 1),
        check::<Static>(PI / 3.0, 2),
        check::<Full>(0.0, 1),
        check::<Full>(PI / 3.0, 2),
    ]
    .concat();
    assert!(complaints.is_empty(), "\n{complaints}");
}

#[test]
fn a_refusal_says_what_and_how_much() {
    let text = |set: &dyn Fn(&mut Question)| {
        let mut question = Question::load(SKEW, SPEED);
        set(&mut question);
        let refused = solver(&B7005C, 16, Precision::F64, Balls::Free).ask(&question);
        refused.unwrap_err().to_string()
    };
    let told = text(&|q| q.given[0] = Given::Load(f64::NAN));
    assert_eq!(told, "axial load Fx (N) is NaN");
    let told = text(&|q| q.given[4] = Given::Load(f64::INFINITY));
    assert_eq!(told, "tilting moment Mz (N m) is inf");
    for (told, start) in [
        (
            text(&|q| q.given[4] = Given::Load(-1e30)),
            "tilting moment Mz (N m) is -1e30, beyond the ",
        ),
        (
            text(&|q| q.given[0] = Given::Displacement(1.0)),
            "axial displacement dx (m) is 1e0, beyond the ",
        ),
        (
            text(&|q| q.omega = 1e30),
            "speed omega (rad/s) is 1e30, beyond the ",
        ),
        (
            text(&|q| q.growth.radial = 1.0),
            "radial growth gr (m) is 1e0, beyond the ",
        ),
        (
            text(&|q| q.growth.ball = 1.0),
            "growth of the ball diameter gD (m) is 1e0, beyond the ",
        ),
    ] {
        assert!(told.starts_with(start), "{told}");
    }
    let told = text(&|q| q.given = [Given::Load(0.0); 5]);
    assert!(told.contains("no load"), "{told}");
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
            match solver.ask(&Question::load(load, omega)).unwrap_err() {
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
    assert!(solver.ask(&Question::load(load, omega)).is_err());
    load[0] = 20_000.0;
    let found = solver.load(load, omega);
    assert_eq!(found.status, Status::Converged);
    for ball in &found.balls {
        assert!((ball.alpha_i - ball.alpha_o).abs() < PI / 2.0);
    }
}

#[test]
fn a_refusal_leaves_the_solver_as_it_was() {
    let omega = rad_per_s(20_000.0);
    let mut refusals: Vec<Question> = INPUTS
        .into_iter()
        .flat_map(|(_, set)| {
            [f64::NAN, 1e30].map(|bad| {
                let mut question = Question::load(SKEW, omega);
                set(&mut question, bad);
                question
            })
        })
        .collect();
    refusals.push(Question::load([0.0; 5], omega));
    for balls in [Balls::Static, Balls::Free] {
        let [mut refused, mut control] = [0; 2].map(|_| solver(&B7005C, 16, Precision::F64, balls));
        let (mut usual, mut next) = (SKEW, SKEW.map(|x| 1.02 * x));
        for question in &refusals {
            for solver in [&mut refused, &mut control] {
                solver.load(usual, omega);
            }
            assert!(refused.ask(question).is_err());
            let [a, b] = [&mut refused, &mut control].map(|solver| solver.load(next, omega));
            assert_eq!(a, b, "after {question:?}");
            std::mem::swap(&mut usual, &mut next);
        }
    }
}

// ---------------------------------------------------------------------------------------------
// Whatever comes in

/// Numbers of every size and sign, also those that are none.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => any::<f64>(),
        4 => (-12.0..9.0f64, any::<bool>()).prop_map(|(e, negative)| {
            let x = 10f64.powf(e);
            if negative { -x } else { x }
        }),
        1 => Just(0.0),
    ]
}

/// Loads of ordinary size in any direction, with some of them missing.
fn plausible_load() -> impl Strategy<Value = [f64; 5]> {
    (
        proptest::array::uniform5(-1.0..1.0f64),
        proptest::array::uniform5(any::<bool>()),
        -3.0..5.0f64,
    )
        .prop_map(|(direction, missing, size)| {
            let unit = [1.0, 1.0, 1.0, 0.018, 0.018];
            std::array::from_fn(|i| {
                let x = direction[i] * unit[i] * 10f64.powf(size);
                if missing[i] { 0.0 } else { x }
            })
        })
}

fn assert_sound<T: Real, M: Motion>(bearing: &Bearing<T, 16>, load: [f64; 5], omega: f64) {
    let mut solver = Solver::<T, 16, M>::of(bearing);
    let (speed, settings) = (turning::<T, M>(omega), Settings::default());
    if let Ok(s) = solver.solve(load.map(T::of), speed, &settings) {
        let stiffness = s.stiffness();
        let solved = s.displacement.iter().chain(&s.load);
        for x in solved.chain(stiffness.as_flattened()) {
            assert!(
                x.is_finite(),
                "{load:?} at {omega}: {:?} {:?}",
                s.status,
                s.displacement
            );
        }
        for b in s.balls() {
            for x in [
                b.alpha_i,
                b.alpha_o,
                b.q_i,
                b.q_o,
                b.delta_i,
                b.delta_o,
                b.centrifugal_force,
                b.gyroscopic_moment,
            ] {
                assert!(x.is_finite(), "{load:?} at {omega}: {b:?}");
            }
            assert!(
                b.q_i >= T::ZERO && b.q_o >= T::ZERO,
                "{load:?} at {omega}: {b:?}"
            );
        }
    }
    // And it works on.
    let speed = turning::<T, M>(100.0);
    let usual = solver.solve(SKEW.map(T::of), speed, &settings);
    assert!(usual.is_ok(), "after {load:?} at {omega}: {usual:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..Default::default() })]

    #[test]
    fn no_answer_contains_what_is_not_a_number_whatever_comes_in(
        load in proptest::array::uniform5(any_number()), omega in any_number(),
    ) {
        let (single, double) = (
            Bearing::<f32, 16>::new(&B7005C).unwrap(), Bearing::<f64, 16>::new(&B7005C).unwrap(),
        );
        assert_sound::<f32, Full>(&single, load, omega);
        assert_sound::<f64, Full>(&double, load, omega);
        assert_sound::<f32, Static>(&single, load, omega);
    }

    #[test]
    fn no_answer_contains_what_is_not_a_number_whatever_is_plausible(
        load in plausible_load(), rpm in prop_oneof![Just(0.0), 0.0..100_000.0f64],
    ) {
        let omega = rad_per_s(rpm);
        let (single, double) = (
            Bearing::<f32, 16>::new(&B7005C).unwrap(), Bearing::<f64, 16>::new(&B7005C).unwrap(),
        );
        assert_sound::<f32, Full>(&single, load, omega);
        assert_sound::<f32, Full<OuterRaceControl>>(&single, load, omega);
        assert_sound::<f32, Full<InnerRaceControl>>(&single, load, omega);
        assert_sound::<f64, Full>(&double, load, omega);
        assert_sound::<f64, Static>(&double, load, omega);
    }
}
