//! Where a solve starts decides how long it takes, not where it ends.

use super::solves::{
    Balls, LIFTING, PRECISIONS, Question, SKEW, apart, cold, lengths, loads, solver, stated,
    vector_error,
};
use host_tests::cases::{B7005C, rad_per_s};
use host_tests::dispatch::Precision;
use proptest::prelude::*;
use spindle_bearing::Status;
use spindle_bearing::{Bearing, Settings, Solver, Speed};

#[test]
fn solutions_do_not_depend_on_history() {
    let omega = rad_per_s(20_000.0);
    let mut solver = solver(&B7005C, 16, Precision::F64, Balls::Free);
    let first = solver.load(SKEW, omega);
    let detours: [([f64; 5], f64); 5] = [
        (SKEW.map(|x| -x), omega),
        (SKEW.map(|x| 1e-3 * x), 2.0 * omega),
        ([1.0, -2000.0, 0.0, 0.0, 0.0], 0.0),
        ([5000.0, 0.0, 0.0, 0.0, 30.0], omega),
        ([0.0; 5], 0.0),
    ];
    for (load, speed) in detours {
        // Whether there is an answer to the detour is of no interest here.
        let _ = solver.ask(&Question::load(load, speed));
        let again = solver.load(SKEW, omega);
        let e = apart(&B7005C, &again, &first);
        assert!(e < 1e-11, "after {load:?}: {e:.1e}");
    }
    solver.reset();
    assert_eq!(solver.load(SKEW, omega), first);
}

#[test]
fn a_second_solve_of_the_same_load_stays_where_it_is() {
    let omega = rad_per_s(20_000.0);
    let mut solver = solver(&B7005C, 16, Precision::F64, Balls::Free);
    let cold = solver.load(SKEW, omega);
    let warm = solver.load(SKEW, omega);
    assert_eq!(warm.status, Status::Converged);
    assert!(apart(&B7005C, &cold, &warm) < 1e-11);
}

#[test]
fn a_warm_solve_is_the_cold_one_to_the_errors_that_both_state() {
    for precision in PRECISIONS {
        let mut warm = solver(&B7005C, 16, precision, Balls::Free);
        for step in 0..60 {
            let phase = 0.1 * f64::from(step);
            let load = [
                1000.0 + 200.0 * phase.sin(),
                200.0 * phase.cos(),
                -80.0,
                0.7,
                3.0 * phase.sin(),
            ];
            let omega = 2094.0 + 10.0 * phase;
            let warm = warm.load(load, omega);
            let cold = solver(&B7005C, 16, precision, Balls::Free).load(load, omega);
            let u = vector_error(warm.u, cold.u, lengths(&B7005C));
            let k = (0..5)
                .map(|i| (warm.k[i][i] / cold.k[i][i] - 1.0).abs())
                .fold(0.0, f64::max);
            let [of_u, _, of_k] = stated(&warm.estimate, &cold.estimate);
            assert!(
                u <= of_u && k <= of_k,
                "{step}, {precision:?}: {u:e}, {k:e}"
            );
        }
    }
}

#[test]
fn a_solve_that_ends_at_the_iteration_limit_is_gone_on_with_by_the_next_one() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let scenes = [40_000.0, 100.0, 0.0].map(|rpm| [SKEW, LIFTING].map(|load| (load, rpm)));
    for (load, rpm) in scenes.into_iter().flatten() {
        let truth = cold(&B7005C, 16, Balls::Free, load, rad_per_s(rpm));
        for max_iterations in 1..8 {
            let settings = Settings {
                max_iterations,
                ..Settings::default()
            };
            let mut solver = Solver::new(&bearing);
            let solved =
                (0..100).find_map(|_| match solver.solve(load, Speed::rpm(rpm), &settings) {
                    Ok(solution) => {
                        assert!(solution.iterations <= max_iterations);
                        Some(solution.displacement)
                    }
                    Err(status) => {
                        assert_eq!(status, Status::IterationLimit);
                        None
                    }
                });
            let what = format!("{load:?} at {rpm} rpm, {max_iterations} iterations a solve");
            let u = solved.unwrap_or_else(|| panic!("{what}: never solved"));
            let e = vector_error(u, truth.u, lengths(&B7005C));
            assert!(e < 1e-11, "{what}: {e:.1e}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..Default::default() })]

    #[test]
    fn a_warm_start_ends_where_a_cold_start_does(
        one in loads(), other in loads(), rpm in 0.0..40_000.0f64, step in 0.0..1.0f64,
    ) {
        let mut solver = solver(&B7005C, 16, Precision::F64, Balls::Free);
        solver.load(one, rad_per_s(rpm));
        // From near by to anywhere.
        let load = std::array::from_fn(|i| one[i] + step * step * (other[i] - one[i]));
        let omega = rad_per_s(rpm * (1.0 - 0.3 * step));
        let warm = solver.load(load, omega);
        let e = apart(&B7005C, &warm, &cold(&B7005C, 16, Balls::Free, load, omega));
        prop_assert!(e < 1e-9, "{e:.1e}");
    }

    #[test]
    fn a_start_from_a_standstill_ends_where_a_cold_start_does(
        load in loads(), rpm in 0.0..40_000.0f64, more in 0.9..1.1f64,
    ) {
        // At a standstill, balls off their races have dropped out.
        let mut solver = solver(&B7005C, 16, Precision::F64, Balls::Free);
        solver.load(load, 0.0);
        let load = load.map(|load| more * load);
        let warm = solver.load(load, rad_per_s(rpm));
        let e = apart(&B7005C, &warm, &cold(&B7005C, 16, Balls::Free, load, rad_per_s(rpm)));
        prop_assert!(e < 1e-9, "{e:.1e}");
    }
}
