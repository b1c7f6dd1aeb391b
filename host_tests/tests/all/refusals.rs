//! Input without an answer: what is said to it, and that the solver survives it.

use host_tests::cases::{B218, B7005C, rad_per_s};
use proptest::prelude::*;
use spindle_bearing::{
    Bearing, Design, DesignError, FreeContact, Full, InnerRaceControl, Motion, OuterRaceControl,
    Quantity, RacewayControlFree, Real, Settings, Solver, Static, Status,
};
use std::f64::consts::PI;

type Free = Full<RacewayControlFree>;

const LOAD: [f64; 5] = [1000.0, 200.0, -80.0, 0.7, 3.0];

const QUANTITIES: [Quantity; 5] = [
    Quantity::Fx,
    Quantity::Fy,
    Quantity::Fz,
    Quantity::My,
    Quantity::Mz,
];

const DISPLACEMENTS: [Quantity; 5] = [
    Quantity::Dx,
    Quantity::Dy,
    Quantity::Dz,
    Quantity::Ty,
    Quantity::Tz,
];

fn build<T: Real, const N: usize>(design: &Design) -> Bearing<T, N> {
    Bearing::build(design).unwrap()
}

/// What a fresh solver says to a load.
fn answer<T: Real, M: Motion>(load: [f64; 5], omega: f64) -> Result<(), Status<T>> {
    let bearing = build::<T, 16>(&B7005C);
    let mut solver = Solver::<T, 16, M>::new(&bearing);
    solver
        .solve(load.map(T::of), T::of(omega), &Settings::default())
        .map(drop)
}

// ---------------------------------------------------------------------------------------------
// Loads and speeds

#[test]
fn a_load_or_speed_that_is_not_finite_is_named() {
    fn check<T: Real, M: Motion>() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for (i, expected) in QUANTITIES.into_iter().enumerate() {
                let mut load = LOAD;
                load[i] = bad;
                match answer::<T, M>(load, 1000.0) {
                    Err(Status::NotFinite { quantity, value }) => {
                        assert_eq!(quantity, expected);
                        assert!(!value.is_finite());
                    }
                    other => panic!("{expected} = {bad}: {other:?}"),
                }
            }
            match answer::<T, M>(LOAD, bad) {
                Err(Status::NotFinite { quantity, value }) => {
                    assert_eq!(quantity, Quantity::Speed);
                    assert!(!value.is_finite());
                }
                other => panic!("speed = {bad}: {other:?}"),
            }
        }
    }
    check::<f64, Free>();
    check::<f32, Free>();
    check::<f64, Static>();
    check::<f32, Static>();
}

#[test]
fn an_absurd_load_or_speed_is_out_of_range() {
    fn check<T: Real, M: Motion>() {
        for bad in [1e30, -1e30] {
            for (i, expected) in QUANTITIES.into_iter().enumerate() {
                let mut load = LOAD;
                load[i] = bad;
                match answer::<T, M>(load, 1000.0) {
                    Err(Status::OutOfRange {
                        quantity,
                        value,
                        limit,
                    }) => {
                        assert_eq!(quantity, expected);
                        assert_eq!(value, T::of(bad));
                        assert!(limit.is_finite() && value.abs() > limit);
                    }
                    other => panic!("{expected} = {bad}: {other:?}"),
                }
            }
            match answer::<T, M>(LOAD, bad) {
                Err(Status::OutOfRange { quantity, .. }) => assert_eq!(quantity, Quantity::Speed),
                other => panic!("speed = {bad}: {other:?}"),
            }
        }
    }
    check::<f64, Free>();
    check::<f32, Free>();
    check::<f64, Static>();
    check::<f32, Static>();
}

#[test]
fn the_law_names_a_displacement_that_is_not_finite_or_out_of_range() {
    let bearing = build::<f64, 16>(&B7005C);
    let mut solver = Solver::<f64, 16, Free>::new(&bearing);
    let settings = Settings::default();
    for (i, expected) in DISPLACEMENTS.into_iter().enumerate() {
        for bad in [f64::NAN, f64::INFINITY, 1e30] {
            let mut u = [10e-6, 0.0, 0.0, 0.0, 0.0];
            u[i] = bad;
            match solver.law(u, 1000.0, &settings).map(|s| s.status) {
                Err(Status::NotFinite { quantity, .. }) if !bad.is_finite() => {
                    assert_eq!(quantity, expected);
                }
                Err(Status::OutOfRange { quantity, .. }) if bad.is_finite() => {
                    assert_eq!(quantity, expected);
                }
                other => panic!("{expected} = {bad}: {other:?}"),
            }
        }
    }
    match solver.law([0.0; 5], f64::NAN, &settings).map(|s| s.status) {
        Err(Status::NotFinite { quantity, .. }) => assert_eq!(quantity, Quantity::Speed),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_unloaded_bearing_has_no_position() {
    for omega in [0.0, rad_per_s(20_000.0)] {
        assert_eq!(answer::<f64, Free>([0.0; 5], omega), Err(Status::Unloaded));
        assert_eq!(answer::<f32, Free>([0.0; 5], omega), Err(Status::Unloaded));
        assert_eq!(
            answer::<f64, Static>([0.0; 5], omega),
            Err(Status::Unloaded)
        );
        assert_eq!(
            answer::<f32, Static>([0.0; 5], omega),
            Err(Status::Unloaded)
        );
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
        let cosine = 1.0 - clearance / (2.0 * design.centre_distance());
        let li = (design.inner_groove_factor - 0.5) * design.ball_diameter;
        let plane = li * (1.0 - cosine * cosine).sqrt();
        let bearing = build::<f64, 3>(&design);
        let mut solver = Solver::<f64, 3, M>::new(&bearing);
        let load = [0.0, 50.0, 0.0, 0.0, 50.0 * plane];
        let answer = solver.solve(load, 0.0, &Settings::default());
        match answer.map(|s| (s.status, s.displacement, s.stiffness)) {
            Err(Status::Indeterminate { loaded_balls }) if loaded_balls == expected => {
                String::new()
            }
            other => format!("on {expected}: {other:?}\n"),
        }
    }
    let complaints = [
        check::<Static>(0.0, 1),
        check::<Static>(PI / 3.0, 2),
        check::<Free>(0.0, 1),
        check::<Free>(PI / 3.0, 2),
    ]
    .concat();
    assert!(complaints.is_empty(), "\n{complaints}");
}

#[test]
fn a_refusal_says_what_and_how_much() {
    let text = |load, omega| answer::<f64, Free>(load, omega).unwrap_err().to_string();
    let message = text([1.0, f64::NAN, 0.0, 0.0, 0.0], 0.0);
    assert!(
        message.contains("Fy") && message.contains("NaN"),
        "{message}"
    );
    let message = text([1.0, 0.0, 0.0, 0.0, -1e30], 0.0);
    assert!(
        message.contains("Mz") && message.contains("-1e30"),
        "{message}"
    );
    let message = text(LOAD, 1e30);
    assert!(
        message.contains("speed") && message.contains("1e30"),
        "{message}"
    );
    assert!(text([0.0; 5], 0.0).contains("no load"));
}

#[test]
fn a_ball_that_speed_drives_out_of_its_groove_is_named_and_preload_puts_it_back() {
    let bearing = build::<f64, 16>(&B218);
    let mut solver = Solver::<_, 16, Free>::new(&bearing);
    let settings = Settings::default();
    let solution = solver.solve([10.0, 500.0, 0.0, 0.0, 0.0], 2500.0, &settings);
    let status = solution.unwrap().status;
    let Status::Unseated { ball, apart } = status else {
        panic!("{status}");
    };
    // The radial load presses ball 0, at +y; ball 8 is opposite.
    assert_eq!(ball, 8);
    assert!(apart > PI / 2.0 && apart < PI, "{apart}");
    assert!(status.to_string().contains("ball 8"));
    let solution = solver.solve([20_000.0, 500.0, 0.0, 0.0, 0.0], 2500.0, &settings);
    let solution = solution.unwrap();
    assert_eq!(solution.status, Status::Converged);
    for ball in solution.balls() {
        assert!((ball.alpha_i - ball.alpha_o).abs() < PI / 2.0);
    }
}

#[test]
fn a_refusal_leaves_the_solver_as_it_was() {
    let bearing = build::<f64, 16>(&B7005C);
    let settings = Settings::default();
    let omega = rad_per_s(20_000.0);
    let mut refused = Solver::<f64, 16, Free>::new(&bearing);
    let mut control = Solver::<f64, 16, Free>::new(&bearing);
    let near = LOAD.map(|x| 1.02 * x);
    let mut nan = LOAD;
    nan[3] = f64::NAN;
    let mut absurd = LOAD;
    absurd[0] = 1e30;
    let refusals = [
        (nan, omega),
        (absurd, omega),
        (LOAD, f64::NAN),
        (LOAD, 1e30),
        ([0.0; 5], omega),
    ];
    let mut forth = false;
    for (load, speed) in refusals {
        forth = !forth;
        let usual = if forth { LOAD } else { near };
        for solver in [&mut refused, &mut control] {
            assert!(solver.solve(usual, omega, &settings).is_ok());
        }
        assert!(refused.solve(load, speed, &settings).is_err());
        let next = if forth { near } else { LOAD };
        let a = refused.solve(next, omega, &settings).unwrap();
        let b = control.solve(next, omega, &settings).unwrap();
        assert_eq!(a.sweeps, b.sweeps, "after {load:?} at {speed}");
        assert_eq!(a.displacement, b.displacement, "after {load:?} at {speed}");
        assert_eq!(a.stiffness, b.stiffness, "after {load:?} at {speed}");
        assert!(a.balls().eq(b.balls()));
    }
}

// ---------------------------------------------------------------------------------------------
// Designs

fn refusal(change: impl FnOnce(&mut Design)) -> DesignError {
    let mut design = B7005C;
    change(&mut design);
    let double = Bearing::<f64, 16>::build(&design);
    let single = Bearing::<f32, 16>::build(&design);
    let (Err(double), Err(single)) = (double, single) else {
        panic!("built: {design:?}");
    };
    assert_eq!(double.quantity, single.quantity);
    double
}

type Field = (Quantity, fn(&mut Design, f64));

/// Every number of a design. The flag says whether it may be zero.
const FIELDS: [(Field, bool); 14] = [
    ((Quantity::BallDiameter, |d, x| d.ball_diameter = x), false),
    (
        (Quantity::PitchDiameter, |d, x| d.pitch_diameter = x),
        false,
    ),
    (
        (Quantity::InnerGrooveFactor, |d, x| {
            d.inner_groove_factor = x
        }),
        false,
    ),
    (
        (Quantity::OuterGrooveFactor, |d, x| {
            d.outer_groove_factor = x
        }),
        false,
    ),
    (
        (Quantity::ContactAngle, |d, x| {
            d.free_contact = FreeContact::Angle(x)
        }),
        true,
    ),
    (
        (Quantity::DiametralClearance, |d, x| {
            d.free_contact = FreeContact::DiametralClearance(x);
        }),
        true,
    ),
    (
        (Quantity::InnerShoulderAngle, |d, x| {
            d.inner_shoulder_angle = x
        }),
        false,
    ),
    (
        (Quantity::OuterShoulderAngle, |d, x| {
            d.outer_shoulder_angle = x
        }),
        false,
    ),
    ((Quantity::FirstBall, |d, x| d.first_ball = x), true),
    (
        (Quantity::RingYoungsModulus, |d, x| {
            d.ring.youngs_modulus = x
        }),
        false,
    ),
    (
        (Quantity::RingPoissonsRatio, |d, x| {
            d.ring.poissons_ratio = x
        }),
        true,
    ),
    (
        (Quantity::BallYoungsModulus, |d, x| {
            d.ball.youngs_modulus = x
        }),
        false,
    ),
    (
        (Quantity::BallPoissonsRatio, |d, x| {
            d.ball.poissons_ratio = x
        }),
        true,
    ),
    ((Quantity::BallDensity, |d, x| d.ball.density = x), false),
];

#[test]
fn a_design_with_a_number_that_is_none_is_refused_by_its_name() {
    for ((quantity, set), _) in FIELDS {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = refusal(|design| set(design, bad));
            assert_eq!(error.quantity, quantity, "{bad}: {error}");
            assert!(!error.value.is_finite(), "{error}");
        }
    }
}

#[test]
fn a_design_with_a_zero_is_refused_where_it_means_nothing() {
    for ((quantity, set), may_be_zero) in FIELDS {
        let mut design = B7005C;
        set(&mut design, 0.0);
        match Bearing::<f64, 16>::build(&design) {
            Ok(_) => assert!(may_be_zero, "{quantity} = 0 was accepted"),
            Err(error) => {
                assert!(!may_be_zero, "{error}");
                assert_eq!(error.quantity, quantity, "{error}");
                assert_eq!(error.value, 0.0);
            }
        }
    }
}

#[test]
fn a_negative_clearance_closes_the_bearing() {
    let error = refusal(|d| d.free_contact = FreeContact::DiametralClearance(-5e-6));
    assert_eq!(error.quantity, Quantity::DiametralClearance);
    assert_eq!(error.value, -5e-6);
    let message = error.to_string();
    assert!(
        message.contains("clearance") && message.contains("-0.000005"),
        "{message}"
    );
}

#[test]
fn a_clearance_beyond_the_grooves_is_refused() {
    let error = refusal(|d| {
        d.free_contact = FreeContact::DiametralClearance(2.0 * d.centre_distance());
    });
    assert_eq!(error.quantity, Quantity::DiametralClearance);
}

#[test]
fn balls_do_not_overlap() {
    // Sixteen balls touch at D = dm sin(pi / 16).
    let touching = B7005C.pitch_diameter * (PI / 16.0).sin();
    let error = refusal(|d| d.ball_diameter = 1.001 * touching);
    assert_eq!(error.quantity, Quantity::BallDiameter);
    assert!((error.most / touching - 1.0).abs() < 1e-12, "{error}");
    let just_so = Design {
        ball_diameter: 0.999 * touching,
        ..B7005C
    };
    assert!(Bearing::<f64, 16>::build(&just_so).is_ok());
}

#[test]
fn a_groove_no_wider_than_the_ball_is_refused() {
    for factor in [0.5, 0.49, 0.0, -0.52] {
        let error = refusal(|d| d.inner_groove_factor = factor);
        assert_eq!(error.quantity, Quantity::InnerGrooveFactor);
        assert_eq!(error.value, factor);
        let error = refusal(|d| d.outer_groove_factor = factor);
        assert_eq!(error.quantity, Quantity::OuterGrooveFactor);
        assert_eq!(error.value, factor);
    }
}

#[test]
fn a_shoulder_below_the_unloaded_balls_or_in_degrees_is_refused() {
    let FreeContact::Angle(free) = B7005C.free_contact else {
        unreachable!()
    };
    for angle in [0.99 * free, -free, 1.01 * Design::HIGHEST_SHOULDER, 48.0] {
        let error = refusal(|d| d.inner_shoulder_angle = angle);
        assert_eq!(error.quantity, Quantity::InnerShoulderAngle);
        let error = refusal(|d| d.outer_shoulder_angle = angle);
        assert_eq!(error.quantity, Quantity::OuterShoulderAngle);
        assert_eq!((error.value, error.least), (angle, free));
    }
}

#[test]
fn two_balls_are_no_bearing() {
    let error = Bearing::<f64, 2>::build(&B7005C).unwrap_err();
    assert_eq!(error.quantity, Quantity::BallCount);
    assert_eq!((error.value, error.least), (2.0, 3.0));
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
    let mut solver = Solver::<T, 16, M>::new(bearing);
    if let Ok(s) = solver.solve(load.map(T::of), T::of(omega), &Settings::default()) {
        assert!(s.residual.is_finite(), "{load:?} at {omega}: residual");
        let solved = s.displacement.iter().chain(&s.load);
        for x in solved.chain(s.stiffness.as_flattened()) {
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
    let usual = solver.solve(LOAD.map(T::of), T::of(100.0), &Settings::default());
    match usual.map(|s| s.status) {
        Ok(Status::Converged | Status::PrecisionLimit) => {}
        other => panic!("after {load:?} at {omega}: {other:?}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..Default::default() })]

    #[test]
    fn no_answer_contains_what_is_not_a_number_whatever_comes_in(
        load in proptest::array::uniform5(any_number()), omega in any_number(),
    ) {
        let (single, double) = (build::<f32, 16>(&B7005C), build::<f64, 16>(&B7005C));
        assert_sound::<f32, Free>(&single, load, omega);
        assert_sound::<f64, Free>(&double, load, omega);
        assert_sound::<f32, Static>(&single, load, omega);
    }

    #[test]
    fn no_answer_contains_what_is_not_a_number_whatever_is_plausible(
        load in plausible_load(), rpm in prop_oneof![Just(0.0), 0.0..100_000.0f64],
    ) {
        let omega = rad_per_s(rpm);
        let (single, double) = (build::<f32, 16>(&B7005C), build::<f64, 16>(&B7005C));
        assert_sound::<f32, Free>(&single, load, omega);
        assert_sound::<f32, Full<OuterRaceControl>>(&single, load, omega);
        assert_sound::<f32, Full<InnerRaceControl>>(&single, load, omega);
        assert_sound::<f64, Free>(&double, load, omega);
        assert_sound::<f64, Static>(&double, load, omega);
    }
}
