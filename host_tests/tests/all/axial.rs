//! One ball for all: the equilibrium under a purely axial load.

use super::solves::{
    BALL_COUNTS, Balls, FoundAxial, GROWN, PRECISIONS, Question, axial_solver, solver, stated,
    turning,
};
use host_tests::cases::{self, B218, B7005C, SKF6205, SolvedCase, rad_per_s};
use host_tests::compare::{Ball, Equilibrium};
use host_tests::dispatch::Precision;
use host_tests::tolerances::allowed_at;
use spindle_bearing::{AxialSolver, Bearing, Given, Growth, Settings, Speed, Static};
use spindle_bearing::{Design, FreeContact, Quantity, Status};

/// The equilibrium of all balls, of which the axial solver has one; other stiffness than the axial one is `truth`'s.
fn all_alike(found: &FoundAxial, truth: &Equilibrium) -> Equilibrium {
    let mut stiffness = truth.stiffness;
    stiffness[0][0] = found.k;
    Equilibrium {
        displacement: [found.u, 0.0, 0.0, 0.0, 0.0],
        stiffness,
        balls: vec![Ball::from(&found.ball); truth.balls.len()],
    }
}

#[test]
fn solved_cases_that_are_purely_axial_are_solved_with_one_ball() {
    let mut count = 0;
    for SolvedCase { case, truth, .. } in cases::public() {
        if case.load[1..] != [0.0; 4] || !BALL_COUNTS.contains(&case.balls) {
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
                    .ask(Given::Load(case.load[0]), case.omega, Growth::NONE)
                    .unwrap_or_else(|status| panic!("{}, {precision:?}: {status}", case.name));
                let radius = case.pitch_radius();
                let errors =
                    all_alike(&found, &truth).errors(&truth, case.design.ball_diameter, radius);
                let largest = truth.largest_displacement(radius) / case.design.centre_distance();
                let allowed = allowed_at(precision, largest);
                assert!(
                    errors.within(allowed),
                    "{}, {}, {balls:?}, {precision:?}: {errors}",
                    case.name,
                    case.omega
                );
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
    let motions = [Balls::Static, Balls::Free, Balls::Outer, Balls::Inner];
    for (design, n, load, rpm) in [
        (&B7005C, 16, 1000.0, 20_000.0),
        (&B7005C, 16, 120.0, 6_000.0),
        (&B218, 16, 17_800.0, 10_000.0),
        (&SKF6205, 9, 300.0, 8_000.0),
    ] {
        for (balls, growth, precision) in motions.into_iter().flat_map(|balls| {
            [Growth::NONE, GROWN, pressed]
                .into_iter()
                .flat_map(move |g| PRECISIONS.map(|precision| (balls, g, precision)))
        }) {
            for (load, omega) in [(load, 0.0), (load, rad_per_s(rpm)), (-load, rad_per_s(rpm))] {
                let what = format!(
                    "{n} balls, {load} N, {omega} rad/s, {balls:?}, {growth:?}, {precision:?}"
                );
                let question = Question {
                    growth,
                    ..Question::load([load, 0.0, 0.0, 0.0, 0.0], omega)
                };
                let truth = solver(design, n, Precision::F64, balls)
                    .ask(&question)
                    .unwrap_or_else(|status| panic!("{what}: {status}"));
                let mut solver = axial_solver(design, n, precision, balls);
                let found = solver
                    .ask(Given::Load(load), omega, growth)
                    .unwrap_or_else(|status| panic!("{what}: {status}, one ball"));
                assert_eq!(found.load, load);
                assert_eq!(found.ball.azimuth, truth.balls[0].azimuth);
                let truth = truth.equilibrium();
                let radius = 0.5 * design.pitch_diameter;
                let errors = all_alike(&found, &truth).errors(&truth, design.ball_diameter, radius);
                let length = design.centre_distance();
                // Displacements cannot be better than growth in single precision.
                let size = [growth.axial, growth.radial, growth.ball]
                    .iter()
                    .fold(truth.displacement[0].abs(), |size, g| size.max(g.abs()));
                let mut allowed = allowed_at(precision, truth.displacement[0].abs() / length);
                allowed.displacement *= size / truth.displacement[0].abs();
                if precision == Precision::F64 {
                    // Both are off.
                    allowed.contact_angle *= 3.0;
                    allowed.force *= 3.0;
                    allowed.stiffness *= 3.0;
                }
                assert!(errors.within(allowed), "{what}: {errors}");
                // The reaction to that displacement is that load.
                let back = solver
                    .ask(Given::Displacement(found.u), omega, growth)
                    .unwrap_or_else(|status| panic!("{what}: {status}, displacement"));
                let resolved = if precision == Precision::F64 {
                    1e-16
                } else {
                    6e-8
                };
                let sum = size.max(2.0 * length * truth.balls[0].inner.angle.sin().abs());
                let allowed = 1e-11 + 20.0 * resolved * (1.0 + found.k * sum / load.abs());
                let off = (back.load / load - 1.0).abs();
                assert!(
                    back.u == found.u && off < allowed,
                    "{what}: {off:e}, {allowed:e}"
                );
            }
        }
    }
}

#[test]
fn a_warm_axial_solve_is_the_cold_one_to_the_errors_that_both_state() {
    for balls in [Balls::Static, Balls::Free] {
        for precision in PRECISIONS {
            let mut warm = axial_solver(&B7005C, 16, precision, balls);
            for step in 0..60 {
                let phase = 0.1 * f64::from(step);
                let load = Given::Load(500.0 + 20.0 * phase.sin());
                let omega = 2094.0 + 10.0 * phase;
                let warm = warm.solve(load, omega, GROWN);
                let cold = axial_solver(&B7005C, 16, precision, balls).solve(load, omega, GROWN);
                let [u, q, k] = [
                    (warm.u, cold.u),
                    (warm.ball.q_i, cold.ball.q_i),
                    (warm.k, cold.k),
                ]
                .map(|(a, b)| (a / b - 1.0).abs());
                let [of_u, of_q, of_k] = stated(&warm.estimate, &cold.estimate);
                assert!(
                    u <= of_u && q <= of_q && k <= of_k,
                    "{step}, {balls:?}, {precision:?}: {u:e}, {q:e}, {k:e}"
                );
            }
        }
    }
}

#[test]
fn axial_loads_of_any_size_are_solved_at_rest() {
    for growth in [0.0, 1e-6, 8e-6, 20e-6, -15e-6].map(|radial| Growth {
        radial,
        ..Growth::NONE
    }) {
        for precision in PRECISIONS {
            let mut solver = axial_solver(&SKF6205, 9, precision, Balls::Static);
            let mut last = None;
            for step in -28..19 {
                let load = 10f64.powf(0.25 * f64::from(step));
                let mut ask = |load| solver.solve(Given::Load(load), 0.0, growth);
                let (found, turned) = (ask(load), ask(-load));
                let ball = &found.ball;
                let force = 9.0 * ball.q_i * ball.alpha_i.sin();
                let single = precision == Precision::F32;
                let allowed = if single { 1e-5 } else { 1e-13 };
                assert!(
                    (force / load - 1.0).abs() < allowed,
                    "{load} N, {growth:?}, {precision:?}: {force}"
                );
                assert!(found.k > 0.0, "{found:?}");
                assert!((turned.k / found.k - 1.0).abs() < allowed, "{turned:?}");
                assert!((turned.ball.q_i / ball.q_i - 1.0).abs() < allowed);
                assert!(last.is_none_or(|last| found.u >= last), "{found:?}");
                last = Some(found.u);
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
                let Err(status) = solver.ask(Given::Load(load), rad_per_s(rpm), Growth::NONE)
                else {
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
                let usual = (Given::Load(1e3), 2094.0, Growth::NONE);
                let found = solver.solve(usual.0, usual.1, usual.2);
                let fresh = axial_solver(&B7005C, 16, precision, Balls::Free)
                    .solve(usual.0, usual.1, usual.2);
                let off = (found.k / fresh.k - 1.0).abs();
                let [.., of_k] = stated(&found.estimate, &fresh.estimate);
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
                let found = solver.solve(Given::Displacement(0.0), 0.0, Growth::NONE);
                assert!(
                    found.estimate.iter().all(|error| *error >= 0.0),
                    "{free} rad, {balls:?}, {precision:?}: {found:?}"
                );
            }
        }
    }
}

/// What axial solvers at rest and at speed say to the same.
fn refusal(given: Given<f32>, speed: Speed<f32>, growth: Growth<f32>) -> Option<Status<f32>> {
    let bearing = Bearing::<f32, 16>::new(&B7005C).unwrap();
    let settings = Settings::default();
    let mut at_rest = AxialSolver::<f32, 16, Static>::of(&bearing);
    let mut at_speed = AxialSolver::new(&bearing);
    let at = turning::<f32, Static>(speed.as_rad_per_s().into());
    let rest = at_rest.solve_at(given, at, &growth, &settings).err();
    let other = at_speed.solve_at(given, speed, &growth, &settings).err();
    let named = |status: &Option<Status<f32>>| match status {
        Some(Status::OutOfRange { quantity, .. }) => format!("{quantity} is out of range"),
        other => format!("{other:?}"),
    };
    assert_eq!(named(&rest), named(&other));
    other
}

#[test]
fn axial_input_that_is_no_number_or_out_of_range_is_refused_by_its_name() {
    let (load, speed) = (Given::Load(1000.0), Speed::rpm(20_000.0));
    for bad in [f32::NAN, f32::INFINITY, -1e9] {
        let of_growth = |set: fn(&mut Growth<f32>, f32)| {
            let mut growth = Growth::NONE;
            set(&mut growth, bad);
            refusal(load, speed, growth)
        };
        for (quantity, refused) in [
            (Quantity::Fx, refusal(Given::Load(bad), speed, Growth::NONE)),
            (
                Quantity::Dx,
                refusal(Given::Displacement(bad), speed, Growth::NONE),
            ),
            (
                Quantity::Speed,
                refusal(load, Speed::rad_per_s(bad), Growth::NONE),
            ),
            (Quantity::AxialGrowth, of_growth(|g, x| g.axial = x)),
            (Quantity::RadialGrowth, of_growth(|g, x| g.radial = x)),
            (Quantity::BallGrowth, of_growth(|g, x| g.ball = x)),
        ] {
            let (named, value) = match refused {
                Some(Status::NotFinite { quantity, value }) => {
                    assert!(!bad.is_finite());
                    (quantity, value)
                }
                Some(Status::OutOfRange {
                    quantity,
                    value,
                    limit,
                }) => {
                    assert!(bad.is_finite() && value.abs() > limit);
                    (quantity, value)
                }
                other => panic!("{quantity} = {bad}: {other:?}"),
            };
            assert_eq!((named, value.to_bits()), (quantity, bad.to_bits()));
        }
    }
    assert_eq!(
        refusal(Given::Load(0.0), speed, Growth::NONE),
        Some(Status::Unloaded)
    );
    assert_eq!(refusal(load, speed, Growth::NONE), None);
}
