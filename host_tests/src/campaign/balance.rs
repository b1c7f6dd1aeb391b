//! Forces and places of an answer's balls: whether they balance, without another solver.

use super::families::{Tick, Trial};
use crate::compare::worse;
use crate::dispatch::Attitude;
use spindle_bearing::{BallState, Design};

/// Forces that count as part of a load or of a ball's forces, of all forces about: what rounding moves is far less.
const ABOUT: f64 = 1e-3;

/// The largest residual of the ring and of any ball, over the load and over the ball's largest force.
pub fn residual(trial: &Trial, tick: &Tick, balls: &[BallState<f64>]) -> f64 {
    let design = &trial.case.design;
    let about = balls.iter().fold(0.0, |m, b| worse(m, b.q_i.max(b.q_o)));
    let mut force = [0.0; 5];
    let mut most = 0.0;
    for (ball, station) in balls.iter().zip(&trial.reference.stations) {
        let [ti, to] = friction(ball, trial.case.attitude, design.ball_diameter);
        let (si, ci) = ball.alpha_i.sin_cos();
        let (so, co) = ball.alpha_o.sin_cos();
        let fa = ball.q_i * si + ti * ci;
        let fr = ball.q_i * ci - ti * si;
        let mt = design.inner_groove_factor * design.ball_diameter * ti;
        station.collect(&[fa, fr, mt], &mut force);
        let axial = fa - ball.q_o * so - to * co;
        let radial = fr - ball.q_o * co + to * so + ball.centrifugal_force;
        let size = ball.q_i.max(ball.q_o).max(ball.centrifugal_force) + ABOUT * about;
        if size > 0.0 {
            most = worse(most, axial.hypot(radial) / size);
        }
    }
    let lever = trial.case.pitch_radius();
    let unit = [1.0, 1.0, 1.0, lever, lever];
    let norm = |of: &dyn Fn(usize) -> f64| {
        (0..5)
            .map(|i| (of(i) / unit[i]).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let load = norm(&|i| tick.load[i]);
    let ring = norm(&|i| force[i] - tick.load[i]);
    worse(most, ring / (load + ABOUT * about * balls.len() as f64))
}

/// Friction forces at the inner and at the outer contact, N.
pub fn friction(ball: &BallState<f64>, attitude: Attitude, diameter: f64) -> [f64; 2] {
    let shares = match attitude {
        Attitude::Inner if ball.q_i > 0.0 => [1.0, 1.0],
        Attitude::Inner | Attitude::Outer => [0.0, 2.0],
        Attitude::Raceless => {
            let total = ball.q_i + ball.q_o;
            if total > 0.0 {
                [2.0 * ball.q_i / total, 2.0 * ball.q_o / total]
            } else {
                [0.0; 2]
            }
        }
    };
    shares.map(|share| share * ball.gyroscopic_moment / diameter)
}

/// The balls' centres, axial and radial from the outer groove's centre.
pub fn centres(design: &Design, balls: &[BallState<f64>]) -> Vec<(f64, f64)> {
    let lo = (design.outer_groove_factor - 0.5) * design.ball_diameter;
    let centre = |ball: &BallState<f64>| {
        let (sin, cos) = ball.alpha_o.sin_cos();
        ((lo + ball.delta_o) * sin, (lo + ball.delta_o) * cos)
    };
    balls.iter().map(centre).collect()
}
