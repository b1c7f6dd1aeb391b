//! What a solution says of itself.

use super::solves::SKEW;
use host_tests::cases::B7005C;
use spindle_bearing::{Bearing, Settings, Solver, Speed, Static};

#[test]
fn a_snapshot_is_what_the_solution_says() {
    let bearing = Bearing::<f32, 16>::new(&B7005C).unwrap();
    let mut solver = Solver::new(&bearing);
    let load = SKEW.map(|x| x as f32);
    let settings = Settings::default();
    for rpm in [0.0, 20_000.0, 20_100.0] {
        let speed = Speed::rpm(rpm);
        let solution = solver.solve(load, speed, &settings).unwrap();
        let copy = solution.snapshot();
        assert_eq!(copy.status, solution.status);
        assert_eq!(copy.iterations, solution.iterations);
        assert_eq!(copy.error, solution.error);
        assert_eq!(copy.displacement, solution.displacement);
        assert_eq!((copy.load, copy.speed), (load, speed));
        assert_eq!((solution.load, solution.speed), (load, speed));
        assert_eq!(copy.stiffness, solution.stiffness());
        assert!(solution.balls().eq(copy.balls));
        assert!(solution.cage_speeds().eq(copy.cage_speeds));
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
        // Without inertia: rolling on both races.
        let mut solver = Solver::<f64, 16, Static>::of(&bearing);
        let solution = solver.solve(SKEW, speed, &settings).unwrap();
        for (ball, cage_speed) in solution.balls().zip(solution.cage_speeds()) {
            let expected = 0.5 * omega * (1.0 - d / dm * ball.alpha_i.cos());
            assert!((cage_speed / expected - 1.0).abs() < 1e-12);
        }
    }
}
