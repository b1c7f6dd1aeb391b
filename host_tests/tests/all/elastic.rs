//! Spindles with an elastic shaft on elastic supports.

use super::solves::{self, vector_error};
use host_tests::cases::{SolvedElastic, elastic};
use host_tests::compare::{stiffness_error, worse};
use host_tests::dispatch::Precision;
use host_tests::spindles::{Answer, Balls, with_solver};
use rayon::prelude::*;
use spindle_bearing::ShaftEnd;

/// Errors of an answer: displacements, forces of rows, contact forces, stiffness, flexibility of the nose.
fn errors(found: &Answer, case: &SolvedElastic) -> [f64; 5] {
    let set = &case.set;
    let design = &set.plan.rows[0].design;
    let (lengths, forces) = (solves::lengths(design), solves::forces(design));
    let at = |found, truth| vector_error(found, truth, lengths);
    let mut errors = [0.0; 5];
    errors[0] = worse(
        at(found.displacement, set.displacement),
        at(found.displacement_at, case.at_nose.displacement),
    );
    let of_rows = set.rows.iter().map(|row| solves::size(row.load, forces));
    let of_rows = of_rows.fold(0.0, worse);
    let balls = set.rows.iter().flat_map(|r| r.balls.iter().map(|b| b[3]));
    let of_balls = balls.fold(0.0, worse);
    for (found, truth) in found.rows.iter().zip(&set.rows) {
        errors[0] = worse(errors[0], at(found.displacement, truth.displacement));
        let off = std::array::from_fn(|i| found.force[i] - truth.load[i]);
        errors[1] = worse(errors[1], solves::size(off, forces) / of_rows);
        for (ball, truth) in found.balls.iter().zip(&truth.balls) {
            let [_, _, q_i, q_o] = *truth;
            let off = (ball.q_i - q_i).abs().max((ball.q_o - q_o).abs());
            errors[2] = worse(errors[2], off / of_balls);
        }
    }
    errors[3] = stiffness_error(&found.stiffness, &set.stiffness);
    errors[4] = stiffness_error(&found.compliance_at, &case.at_nose.flexibility);
    errors
}

#[test]
fn solved_elastic_sets_are_solved_in_both_precisions() {
    let bounds = [
        (Precision::F64, [1e-9, 1e-9, 1e-9, 1e-8, 1e-8]),
        (Precision::F32, [1e-5, 1e-4, 1e-4, 1e-3, 1e-3]),
    ];
    elastic().par_iter().for_each(|case| {
        for (precision, bounds) in bounds {
            let end = ShaftEnd::rigid(case.nose);
            let balls = Balls::Moving(case.set.attitude);
            let found = with_solver(&case.plan(), balls, precision, |solver| {
                solver.solve(&case.set.question, &end)
            });
            let name = &case.set.name;
            let found = found.unwrap_or_else(|e| panic!("{name}: {e}"));
            let found = found.unwrap_or_else(|e| panic!("{name} {precision:?}: {e}"));
            let errors = errors(&found, case);
            let within = errors.iter().zip(bounds).all(|(e, bound)| *e <= bound);
            assert!(within, "{name} {precision:?}: {errors:?}");
        }
    });
}
