//! Where a solve starts decides how long it takes, not where it ends.

use super::solves::{
    Balls, GROWN, LIFTING, PRECISIONS, Question, SKEW, apart, cold, errors, lengths, loads,
    ring_solver, solver, stated, vector_error,
};
use judge::cases::{B7005C, rad_per_s};
use judge::compare::{Equilibrium, stiffness_error};
use proptest::prelude::*;
use solvers::Choices;
use solvers::dispatch::Precision;
use spindle_bearing::{Bearing, Design, Growth, Settings, Solver, Speed, Status};

#[test]
fn a_warm_solve_is_the_cold_one_to_the_errors_that_both_state() {
    for (freedoms, balls, growth) in [
        (5, Balls::Free, Growth::NONE),
        (1, Balls::Free, GROWN),
        (1, Balls::Static, GROWN),
    ] {
        for precision in PRECISIONS {
            let fresh = || ring_solver(&B7005C, 16, precision, balls, freedoms);
            let mut warm = fresh();
            for step in 0..60 {
                let phase = 0.1 * f64::from(step);
                let (sin, cos) = phase.sin_cos();
                let load = match freedoms {
                    1 => [500.0 + 20.0 * sin, 0.0, 0.0, 0.0, 0.0],
                    _ => [1000.0 + 200.0 * sin, 200.0 * cos, -80.0, 0.7, 3.0 * sin],
                };
                let question = Question::load(load, 2094.0 + 10.0 * phase).grown(growth);
                let (warm, cold) = (warm.answer(&question), fresh().answer(&question));
                let errors = errors(&warm, &B7005C, &Equilibrium::from(&cold), freedoms);
                let [u, q, k] = stated(&warm, &cold);
                let off = [
                    errors.displacement / u,
                    errors.force / q,
                    errors.stiffness / k,
                ];
                assert!(off.iter().all(|off| *off <= 1.0), "{step}: {off:?}");
            }
        }
    }
}

/// A cut, tick by tick. The first solve, from nothing, takes more iterations than a tick has.
#[test]
fn a_tick_states_an_error_of_its_stiffness_that_is_true_and_at_most_5e_3() {
    let bearing = Bearing::<f32, 16>::new(&B7005C).unwrap();
    let mut solver = Solver::new();
    let mut settings = Settings::default();
    for tick in 0..200 {
        let phase = 0.2 * f64::from(tick);
        let (sin, cos) = phase.sin_cos();
        let load = [1000.0 + 200.0 * sin, 200.0 * cos, -80.0, 0.7, 3.0 * sin];
        let omega = 2094.0 + phase;
        let speed = Speed::rad_per_s(omega as f32);
        let solution = solver.solve(&bearing, load.map(|x| x as f32), speed, &settings);
        let solution = solution.unwrap_or_else(|status| panic!("{tick}: {status}"));
        let k = solution.stiffness().map(|row| row.map(f64::from));
        let off = stiffness_error(&k, &cold(&B7005C, 16, Balls::Free, load, omega).stiffness);
        let stated = f64::from(solution.error.stiffness);
        let is_good = off <= stated && stated <= 5e-3;
        assert!(is_good, "{tick}: {off:.1e}, {stated:.1e} stated");
        settings = Settings::TICK;
    }
}

#[test]
fn a_solve_that_ends_at_the_iteration_limit_is_gone_on_with_by_the_next_one() {
    let scenes = [40_000.0, 100.0, 0.0].map(|rpm| [SKEW, LIFTING].map(|load| (load, rpm)));
    for (load, rpm) in scenes.into_iter().flatten() {
        let omega = rad_per_s(rpm);
        let truth = cold(&B7005C, 16, Balls::Free, load, omega);
        for max_iterations in 1..8 {
            let mut solver = solver(&B7005C, 16, Precision::F64, Balls::Free);
            solver.choose(&Choices {
                max_iterations,
                ..Choices::default()
            });
            let solved = (0..100).find_map(|_| match solver.load(load, omega) {
                Ok(found) => {
                    assert!(found.iterations <= max_iterations);
                    Some(found.displacement)
                }
                Err(status) => {
                    assert_eq!(status, Status::IterationLimit);
                    None
                }
            });
            let what = format!("{load:?} at {rpm} rpm, {max_iterations} iterations a solve");
            let u = solved.unwrap_or_else(|| panic!("{what}: never solved"));
            let e = vector_error(u, truth.displacement, lengths(&B7005C));
            assert!(e < 1e-11, "{what}: {e:.1e}");
        }
    }
}

/// A cold solve of this load diverges. Its neighbours lead to it: a large radial load, a steep contact, next to no axial load.
#[test]
fn a_load_that_the_start_misses_is_answered_from_its_neighbours() {
    let design = Design {
        inner_groove_factor: 0.52,
        outer_groove_factor: 0.52,
        ..Design::angular_contact(9.525e-3, 46e-3, 40_f64.to_radians())
    };
    let bearing = Bearing::<f64, 16>::with_balls(&design, 12).unwrap();
    let mut solver = Solver::new();
    let mut solve = |fx| {
        let load = [fx, 500.0, 0.0, 0.0, -1.0];
        let found = solver.solve(&bearing, load, Speed::rpm(10_000.0), &Settings::default());
        found.map(|found| found.displacement)
    };
    let truth = [-130.789e-6, 100.431e-6, 0.0, 0.0, 3.40967e-3];
    let is_true = |u| vector_error(u, truth, lengths(&design)) < 1e-5;
    match solve(50.0) {
        Ok(u) => assert!(is_true(u), "cold: {u:?}"),
        Err(status) => assert!(matches!(status, Status::Diverged { .. }), "{status}"),
    }
    let found = (0..=65).map(|step| solve(700.0 - 10.0 * f64::from(step)));
    let u = found.map(Result::unwrap).last().unwrap();
    assert!(is_true(u), "{u:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..Default::default() })]

    #[test]
    fn a_warm_start_ends_where_a_cold_start_does(
        one in loads(), other in loads(), rpm in 0.0..40_000.0f64, step in 0.0..1.0f64,
    ) {
        let omega = rad_per_s(rpm * (1.0 - 0.3 * step));
        // From near by to anywhere.
        let load = std::array::from_fn(|i| one[i] + step * step * (other[i] - one[i]));
        let cold = cold(&B7005C, 16, Balls::Free, load, omega);
        // At a standstill, balls off their races have dropped out.
        let nearly = load.map(|load| load / (0.9 + 0.2 * step));
        for (from, speed) in [(one, rad_per_s(rpm)), (nearly, 0.0)] {
            let mut solver = solver(&B7005C, 16, Precision::F64, Balls::Free);
            solver.load(from, speed).unwrap();
            let e = apart(&B7005C, &solver.load(load, omega).unwrap(), &cold);
            prop_assert!(e < 1e-9, "{e:.1e}");
        }
    }
}
