//! Displacements given in the place of loads, and the reactions to them.

use super::solves::{
    Balls, PRECISIONS, Question, SKEW, apart, forces, lengths, loads, solver, vector_error,
};
use host_tests::cases::{B7005C, rad_per_s};
use host_tests::dispatch::Precision;
use proptest::prelude::*;
use spindle_bearing::{Quantity, Status};
use std::array::from_fn;

#[test]
fn given_displacements_are_met_and_their_reactions_hold_the_ring() {
    for precision in PRECISIONS {
        let mut solver = solver(&B7005C, 16, precision, Balls::Free);
        let free = solver.load(SKEW, 2094.0);
        for bits in 1..32u8 {
            let held = from_fn(|i| bits >> i & 1 == 1);
            let found = solver.solve(&Question::mixed(held, free.u, SKEW, 2094.0));
            let [of_u, of_load] = match precision {
                Precision::F32 => [1e-5, 3e-4],
                Precision::F64 => [1e-12, 1e-11],
            };
            let u = vector_error(found.u, free.u, lengths(&B7005C));
            let load = vector_error(found.load, SKEW, forces(&B7005C));
            assert!(u < of_u && load < of_load, "{held:?}: {u:e}, {load:e}");
        }
    }
}

#[test]
fn a_ring_that_nothing_touches_is_indeterminate() {
    // Between the two sides of the grooves.
    let axially = [true, false, false, false, false];
    let question = Question::mixed(axially, [-20e-6; 5], [0.0; 5], 0.0);
    for precision in PRECISIONS {
        let answer = solver(&B7005C, 16, precision, Balls::Static).ask(&question);
        assert_eq!(
            answer.err(),
            Some(Status::Indeterminate {
                loaded_balls: 0,
                free: Quantity::Dy
            })
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..Default::default() })]

    #[test]
    fn reactions_to_the_displacements_of_a_solution_are_its_load(
        load in loads(), rpm in 0.0..40_000.0f64,
    ) {
        let mut solver = solver(&B7005C, 16, Precision::F64, Balls::Free);
        let found = solver.load(load, rad_per_s(rpm));
        let back = solver.solve(&Question::displacement(found.u, rad_per_s(rpm)));
        prop_assert!(vector_error(back.load, load, forces(&B7005C)) < 1e-9);
        let e = apart(&B7005C, &back, &found);
        prop_assert!(e < 1e-8, "{e:.1e}");
    }
}
