//! The reference build of spindles, which judges the sets of the campaign, on solved cases.

use host_tests::cases::{SolvedElasticRow, SolvedRow, SolvedSet, elastic, reference_spindle, sets};
use host_tests::compare::{Ball, Equilibrium, Errors};
use host_tests::reference::spindle::Question;

/// Solves a set cold, and compares. Files of elastic sets have no inertia loads.
fn assert_solved<R>(set: &SolvedSet<R>, balls: impl Iterator<Item = [f64; 6]>, has_inertia: bool) {
    let question = Question {
        load: set.question.load,
        held: [None; 5],
        omega: set.question.omega,
        attitude: set.attitude.into(),
    };
    let found = reference_spindle(&set.plan, &set.question.growth).search(&question);
    let mut found = found.unwrap_or_else(|e| panic!("{}: {e}", set.name));
    if !has_inertia {
        for ball in &mut found.balls {
            (ball.centrifugal_force, ball.gyroscopic_moment) = (0.0, 0.0);
        }
    }
    let truth = Equilibrium {
        displacement: set.displacement,
        stiffness: set.stiffness,
        balls: balls.map(Ball::from).collect(),
    };
    let design = &set.plan.rows[0].design;
    let radius = 0.5 * design.pitch_diameter;
    let mut errors = found.errors(&truth, design.ball_diameter, radius);
    // An unloaded set has no displacement.
    let size = truth.largest_displacement(radius);
    errors.displacement *= size / size.max(1e-9);
    let bounds = Errors {
        displacement: 1e-10,
        contact_angle: 1e-11,
        force: 1e-11,
        stiffness: 1e-10,
    };
    assert!(errors.within(bounds), "{}: {errors}", set.name);
}

#[test]
fn solved_sets_are_solved() {
    for set in sets() {
        let balls = set
            .rows
            .iter()
            .flat_map(|row: &SolvedRow| row.balls.clone());
        assert_solved(&set, balls, true);
    }
    for case in elastic() {
        let rows = case.set.rows.iter();
        let balls = rows.flat_map(|row: &SolvedElasticRow| row.balls.clone());
        let balls = balls.map(|[ai, ao, qi, qo]| [ai, ao, qi, qo, 0.0, 0.0]);
        assert_solved(&case.set, balls, false);
    }
}
