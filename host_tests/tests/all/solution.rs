//! What a solution says of itself.

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
    for rpm in [0.0, 20_000.0, 20_100.0] {
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
        let half_m_dm = B7005C.ball.density * PI * d.powi(3) / 12.0 * B7005C.pitch_diameter;
        for (ball, cage_speed) in copy.balls.iter().zip(copy.cage_speeds) {
            let expected = (ball.centrifugal_force / half_m_dm).sqrt();
            assert!((cage_speed - expected).abs() <= 1e-12 * expected, "{rpm}");
        }
        assert!(solution.inner_forces().eq(copy.balls.map(|ball| ball.q_i)));
    }
}

#[test]
fn cage_speeds_are_those_of_the_centrifugal_forces() {
    let (d, dm) = (B7005C.ball_diameter, B7005C.pitch_diameter);
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let settings = Settings::default();
    let half_m_dm = B7005C.ball.density * std::f64::consts::PI * d.powi(3) / 12.0 * dm;
    for omega in [2094.0, -2094.0] {
        let speed = Speed::rad_per_s(omega);
        let mut solver = Solver::new(&bearing);
        let solution = solver.solve(SKEW, speed, &settings).unwrap();
        for (ball, cage_speed) in solution.balls().zip(solution.cage_speeds()) {
            let expected = (ball.centrifugal_force / half_m_dm).sqrt().copysign(omega);
            assert!((cage_speed / expected - 1.0).abs() < 1e-12);
        }
        // So slow that inertia makes no difference: rolling on both races.
        let slow = Speed::rad_per_s(1e-9 * omega);
        let solution = solver.solve(SKEW, slow, &settings).unwrap();
        for (ball, cage_speed) in solution.balls().zip(solution.cage_speeds()) {
            let expected = 0.5e-9 * omega * (1.0 - d / dm * ball.alpha_i.cos());
            assert!((cage_speed / expected - 1.0).abs() < 1e-12);
        }
    }
}
