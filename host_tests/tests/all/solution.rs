//! Snapshots and summaries of a solution.

use super::solves::SKEW;
use host_tests::cases::{B7005C, reference};
use host_tests::compare::{Ball, Equilibrium};
use host_tests::dispatch::{Attitude, Precision};
use host_tests::tolerances::allowed;
use spindle_bearing::{
    Arrangement, Bearing, LifeRating, Limits, Preload, Settings, Solver, Speed, Spindle,
    SpindleSolver,
};
use std::f64::consts::PI;
use std::mem::MaybeUninit;

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

/// A summary has the figures that the solution's other methods give ball by ball.
#[test]
fn a_summary_is_what_the_balls_of_each_row_say() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let rating = LifeRating::<f64>::new(&B7005C, 16, 13_700.0);
    let (arrangement, preload) = (Arrangement::BackToBack, Preload::Force(200.0));
    let pair = Spindle::pair(arrangement, &bearing, 0.1, preload).unwrap();
    let mut solver = SpindleSolver::new(pair);
    let (load, limits) = ([100.0, 300.0, -50.0, 0.0, 2.0], Limits::default());
    let solution = solver.solve(load, Speed::rpm(20_000.0), &Settings::default());
    let solution = solution.unwrap();
    let rows = solution.summary(&limits, &[rating; 2]);
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b.abs(), "{a:e}, {b:e}");
    let range = |numbers: &mut dyn Iterator<Item = f64>| {
        numbers.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| {
            [x.min(least), x.max(most)]
        })
    };
    let (mut life_rate, mut shares) = (0.0, [0.0; 2]);
    for (found, row) in rows.iter().zip(solution.rows()) {
        for i in 0..3 {
            near(found.force[i], row.force[i]);
        }
        near(found.preload, row.preload());
        let figures = [
            (
                found.inner_force,
                range(&mut row.balls().map(|ball| ball.q_i)),
            ),
            (
                found.outer_force,
                range(&mut row.balls().map(|ball| ball.q_o)),
            ),
            (
                found.inner_angle,
                range(&mut row.balls().map(|ball| ball.alpha_i)),
            ),
            (
                found.outer_angle,
                range(&mut row.balls().map(|ball| ball.alpha_o)),
            ),
        ];
        for (found, expected) in figures {
            near(found[0], expected[0]);
            near(found[1], expected[1]);
        }
        let [_, inner] = range(&mut row.kinematics().map(|ball| ball.inner.peak_pressure));
        let [_, outer] = range(&mut row.kinematics().map(|ball| ball.outer.peak_pressure));
        near(found.peak_pressure[0], inner);
        near(found.peak_pressure[1], outer);
        assert_eq!(found.margins, row.margins(&limits));
        life_rate += found.life_rate;
        shares = [0, 1].map(|i| shares[i] + found.load_share[i]);
    }
    near(shares[0], 1.0);
    near(shares[1], 1.0);
    assert!(rows[0].load_share[1] > 0.5);
    let life = solution.rating_life(&[rating; 2]);
    near(life_rate.powf(-0.9), life.million_revolutions);
}

/// A solver that is made in its place is the one that `new` makes.
#[test]
fn a_solver_made_in_its_place_solves_like_any_other() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let (arrangement, preload) = (Arrangement::BackToBack, Preload::Force(200.0));
    let pair = Spindle::pair(arrangement, &bearing, 0.1, preload).unwrap();
    let (speed, settings) = (Speed::rpm(20_000.0), Settings::default());
    let mut place = MaybeUninit::<SpindleSolver<'_, f64, 2, 16>>::uninit();
    let made = SpindleSolver::new_in(pair, &mut place);
    let mut other = SpindleSolver::new(pair);
    for load in [SKEW, [100.0, 300.0, -50.0, 0.0, 2.0]] {
        let [a, b] = [&mut *made, &mut other].map(|solver| {
            let solution = solver.solve(load, speed, &settings).unwrap();
            solution.snapshot()
        });
        assert_eq!(a, b);
    }
}
