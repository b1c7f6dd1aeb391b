//! How balls turn, how their contacts are pressed, and the frequencies that follow.

use super::limits::groove;
use super::solves::{LIFTING, SKEW};
use judge::cases::{B218, B7005C};
use solvers::dispatch::Attitude;
use spindle_bearing::{
    Arrangement, BallKinematics, Bearing, Design, Frequencies, HertzContact, InnerRaceControl,
    Motion, OuterRaceControl, Preload, Race, RacewayControlFree, Settings, Solver, Speed, Spindle,
    SpindleSolver,
};
use spindle_file::plan::MOST_BALLS;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

const OMEGA: f64 = 1200.0;

/// The loaded balls of a bearing turn as the model's page says, and their contacts are Hertz's.
fn judge<M: Motion>(design: &Design, load: [f64; 5], omega: f64, rule: Attitude) {
    let bearing = Bearing::<f64, MOST_BALLS>::with_balls(design, 16).unwrap();
    let mut solver = Solver::<f64, MOST_BALLS, M>::of();
    let settings = Settings::default();
    let solution = solver
        .solve(&bearing, load, Speed::rad_per_s(omega), &settings)
        .unwrap();
    let [inner, outer] = [Race::Inner, Race::Outer].map(|race| groove(design, race).1);
    let tau = design.ball_diameter / design.pitch_diameter;
    let mut compared = 0;
    for ((ball, motion), cage) in solution
        .balls()
        .zip(solution.kinematics())
        .zip(solution.cage_speeds())
    {
        if ball.q_i <= 0.0 {
            assert_eq!(motion.inner, Default::default());
            continue;
        }
        compared += 1;
        let (ai, ao) = (ball.alpha_i, ball.alpha_o);
        let (a, c) = (1.0 + tau * ao.cos(), 1.0 - tau * ai.cos());
        let tan = match rule {
            Attitude::Outer => ao.sin() / (ao.cos() + tau),
            Attitude::Inner => ai.sin() / (ai.cos() - tau),
            Attitude::Raceless => {
                let friction = |q: f64, contact: &HertzContact| {
                    q * contact.semi_major * q.cbrt() * contact.elliptic_e
                };
                let share = friction(ball.q_i, &inner) / friction(ball.q_o, &outer);
                let s = a / c;
                (share * (s + 1.0) * ai.sin() + 2.0 * ao.sin())
                    / (share * (s + 1.0) * ai.cos()
                        + 2.0 * (ao.cos() + tau)
                        + share * tau * ((ai - ao).cos() - s))
            }
        };
        let b = tan.atan();
        let nb = a * (ai - b).cos() + c * (ao - b).cos();
        let close = |found: f64, truth: f64, scale: f64| {
            let off = (found - truth).abs();
            assert!(off <= 1e-11 * scale.abs(), "{rule:?}: {found} {truth}");
        };
        close(motion.attitude, b, 1.0);
        close(motion.cage_speed, omega * c * (ao - b).cos() / nb, omega);
        assert_eq!(motion.cage_speed, cage);
        close(motion.rotation, omega * a * c / (tau * nb), omega / tau);
        // Angular speed of the ball against either race, along the normal and in the tangent plane, at a speed of 1.
        let (orbit, own) = (c * (ao - b).cos() / nb, a * c / (tau * nb));
        for (patch, contact, q, alpha, ring) in [
            (&motion.inner, &inner, ball.q_i, ai, 1.0 - orbit),
            (&motion.outer, &outer, ball.q_o, ao, -orbit),
        ] {
            let against = [ring + own * b.cos(), -own * b.sin()];
            let spin = against[0] * alpha.sin() + against[1] * alpha.cos();
            let roll = against[0] * alpha.cos() - against[1] * alpha.sin();
            close(patch.spin_to_roll, (spin / roll).abs(), 1.0);
            for (found, hertz) in [
                (patch.peak_pressure, contact.peak_pressure(q)),
                (patch.semi_major, contact.semi_major * q.cbrt()),
                (patch.semi_minor, contact.semi_minor * q.cbrt()),
            ] {
                close(found, hertz, hertz);
            }
        }
    }
    assert!(compared >= 8, "{compared}");

    let frequencies = solution.frequencies();
    let turns = omega / TAU;
    assert!((frequencies.inner_race + frequencies.outer_race - 16.0 * turns).abs() < 1e-9 * turns);
    assert!((frequencies.outer_race - 16.0 * frequencies.cage).abs() < 1e-9 * turns);
}

#[test]
fn balls_turn_and_touch_as_the_model_says() {
    for (design, load) in [
        (&B7005C, SKEW),
        (&B218, SKEW.map(|load| 15.0 * load)),
        (&B7005C, LIFTING),
    ] {
        judge::<RacewayControlFree>(design, load, OMEGA, Attitude::Raceless);
        judge::<OuterRaceControl>(design, load, OMEGA, Attitude::Outer);
        if load[0] > 100.0 {
            judge::<InnerRaceControl>(design, load, OMEGA, Attitude::Inner);
        }
    }
}

/// At rest, under an axial load, the frequencies of a slow shaft are the textbook's for the contact angle under load.
#[test]
fn a_slow_bearing_has_the_frequencies_of_the_textbook() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let mut solver = Solver::new();
    let speed = Speed::rad_per_s(1e-6);
    let settings = Settings::default();
    let solution = solver
        .solve(&bearing, [500.0, 0.0, 0.0, 0.0, 0.0], speed, &settings)
        .unwrap();
    let cos = solution.balls().next().unwrap().alpha_i.cos();
    let ratio = B7005C.ball_diameter / B7005C.pitch_diameter * cos;
    let turns = 1e-6 / (2.0 * PI);
    let found = solution.frequencies();
    for (found, textbook) in [
        (found.cage, 0.5 * turns * (1.0 - ratio)),
        (found.outer_race, 8.0 * turns * (1.0 - ratio)),
        (found.inner_race, 8.0 * turns * (1.0 + ratio)),
    ] {
        assert!((found / textbook - 1.0).abs() < 1e-12, "{found} {textbook}");
    }
    // The textbook's ball does not spin; this one turns about the axis that its contacts leave it.
    let ball = 0.5 * turns / (B7005C.ball_diameter / B7005C.pitch_diameter) * (1.0 - ratio * ratio);
    assert!((found.ball / ball - 1.0).abs() < 0.01, "{ball}");
}

/// Frequencies are means of `all` balls that the inner race touches, so many, or of all if it touches none.
fn assert_means(all: Vec<BallKinematics<f64>>, touching: Range<usize>, found: Frequencies<f64>) {
    let mut meant = all.clone();
    meant.retain(|ball| ball.inner.peak_pressure > 0.0);
    assert!(touching.contains(&meant.len()), "{}", meant.len());
    if meant.is_empty() {
        meant = all;
    }
    let hertz = 1.0 / (TAU * meant.len() as f64);
    let cage: f64 = meant.iter().map(|ball| ball.cage_speed).sum();
    let rotation: f64 = meant.iter().map(|ball| ball.rotation).sum();
    for (found, mean) in [(found.cage, cage * hertz), (found.ball, rotation * hertz)] {
        assert!((found / mean - 1.0).abs() < 1e-12, "{found} {mean}");
    }
}

/// A ball that only the outer race touches turns otherwise than a loaded one.
#[test]
fn frequencies_are_means_of_the_balls_that_the_inner_race_touches_or_of_all_if_it_touches_none() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let (settings, speed) = (Settings::default(), Speed::rpm(40_000.0));
    let mut solver = Solver::new();
    let lifting = solver.solve(&bearing, LIFTING, speed, &settings).unwrap();
    assert_means(lifting.kinematics().collect(), 1..16, lifting.frequencies());

    let held = Preload::Force(50.0);
    let pair = Spindle::pair(Arrangement::BackToBack, &bearing, 0.1, held).unwrap();
    let mut solver = SpindleSolver::new();
    let pushed = solver
        .solve(&pair, [2000.0, 0.0, 0.0, 0.0, 0.0], speed, &settings)
        .unwrap();
    let lifted_off = pushed.rows().last().unwrap();
    assert_means(
        lifted_off.kinematics().collect(),
        0..1,
        lifted_off.frequencies(),
    );
}
