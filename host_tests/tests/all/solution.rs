//! A solution's snapshot against the reference build.

use super::solves::SKEW;
use host_tests::cases::{B7005C, reference};
use host_tests::compare::{Ball, Equilibrium};
use host_tests::dispatch::{Attitude, Precision};
use host_tests::tolerances::allowed;
use spindle_bearing::{Bearing, Settings, Solver, Speed};
use std::f64::consts::PI;

#[test]
fn a_snapshot_is_what_the_reference_build_says() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let mut solver = Solver::new(&bearing);
    let reference = reference(&B7005C, 16);
    for rpm in [0.0, 20_000.0, -20_100.0] {
        let speed = Speed::rpm(rpm);
        let solution = solver.solve(SKEW, speed, &Settings::default()).unwrap();
        let copy = solution.snapshot();
        let attitude = Attitude::Raceless.into();
        let truth = reference.solve(SKEW, speed.as_rad_per_s(), attitude);
        let found = Equilibrium {
            displacement: copy.displacement,
            stiffness: copy.stiffness,
            balls: copy.balls.iter().map(Ball::from).collect(),
        };
        let (d, radius) = (B7005C.ball_diameter, 0.5 * B7005C.pitch_diameter);
        let errors = found.errors(&Equilibrium::from(&truth.unwrap()), d, radius);
        assert!(errors.within(allowed(Precision::F64)), "{rpm}: {errors}");
        assert_eq!((copy.load, copy.speed), (SKEW, speed));
        assert!(solution.inner_forces().eq(copy.balls.map(|ball| ball.q_i)));
        // Cage speeds fit the centrifugal forces.
        let half_m_dm = B7005C.ball.density * PI * d.powi(3) / 12.0 * B7005C.pitch_diameter;
        assert!(solution.cage_speeds().eq(copy.cage_speeds));
        for (ball, cage_speed) in copy.balls.iter().zip(copy.cage_speeds) {
            let expected = (ball.centrifugal_force / half_m_dm).sqrt().copysign(rpm);
            assert!(
                (cage_speed - expected).abs() <= 1e-12 * expected.abs(),
                "{rpm}"
            );
        }
    }
}

/// Forces are rows, which a symmetric stiffness would not show.
#[test]
fn a_matrix_of_nalgebra_makes_of_a_displacement_the_forces_that_the_stiffness_makes() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let mut solver = Solver::new(&bearing);
    let speed = Speed::rpm(20_000.0);
    let solution = solver.solve(SKEW, speed, &Settings::default()).unwrap();
    let copy = solution.snapshot();
    let (k, u) = (copy.stiffness, copy.displacement);
    for force in [
        solution.stiffness_matrix() * solution.displacement_vector(),
        copy.stiffness_matrix() * copy.displacement_vector(),
    ] {
        for i in 0..5 {
            let parts = [0, 1, 2, 3, 4].map(|j| k[i][j] * u[j]);
            let (sum, size) = (
                parts.iter().sum::<f64>(),
                parts.map(f64::abs).iter().sum::<f64>(),
            );
            assert!((force[i] - sum).abs() <= 1e-14 * size, "{i}: {force}");
        }
    }
}
