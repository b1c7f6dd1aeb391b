//! The textbook's equations: balance of a ball, and of the ring on its balls.

use super::families::{Tick, Trial};
use crate::compare::worse;
use solvers::dispatch::Attitude;
use spindle_bearing::{BallState, Design, FreeContact};
use std::array::from_fn;

/// Forces that count as part of a load or of a ball's forces, of all forces about: what rounding moves is far less.
const ABOUT: f64 = 1e-3;

/// The largest residual of the ring and of any ball, over the load and over the ball's largest force.
pub fn residual(trial: &Trial, tick: &Tick, balls: &[BallState<f64>]) -> f64 {
    let (design, rule) = (&trial.case.design, trial.case.attitude);
    let about = balls.iter().fold(0.0, |m, b| worse(m, b.q_i.max(b.q_o)));
    let most = balls.iter().fold(0.0, |most, ball| {
        let (_, [axial, radial]) = forces(design, rule, ball);
        let size = ball.q_i.max(ball.q_o).max(ball.centrifugal_force) + ABOUT * about;
        match size > 0.0 {
            true => worse(most, axial.hypot(radial) / size),
            false => most,
        }
    });
    let lever = trial.case.pitch_radius();
    let norm = |[fx, fy, fz, my, mz]: [f64; 5]| {
        let parts = [fx, fy, fz, my / lever, mz / lever];
        parts.iter().map(|part| part * part).sum::<f64>().sqrt()
    };
    let force = carried(design, rule, balls);
    let ring = norm(from_fn(|i| force[i] - tick.load[i]));
    worse(
        most,
        ring / (norm(tick.load) + ABOUT * about * balls.len() as f64),
    )
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

/// Sine and cosine of the angle at which an unloaded ball just touches both races.
fn free_angle(design: &Design) -> (f64, f64) {
    match design.free_contact {
        FreeContact::Angle(angle) => angle.sin_cos(),
        FreeContact::DiametralClearance(clearance) => (
            0.0,
            1.0 - clearance.max(0.0) / (2.0 * design.centre_distance()),
        ),
    }
}

/// Distances of the inner and of the outer groove's centre from the centre of an unloaded ball.
fn groove_centres(design: &Design) -> [f64; 2] {
    [design.inner_groove_factor, design.outer_groove_factor]
        .map(|f| (f - 0.5) * design.ball_diameter)
}

/// Radius and axial place of the inner groove's centre.
fn inner_centre(design: &Design) -> [f64; 2] {
    let ([li, _], (sin0, cos0)) = (groove_centres(design), free_angle(design));
    [0.5 * design.pitch_diameter + li * cos0, li * sin0]
}

/// A ball's forces on the inner ring, axial and radial, its friction moment there, and the rest of its own balance.
fn forces(design: &Design, rule: Attitude, ball: &BallState<f64>) -> ([f64; 3], [f64; 2]) {
    let [ti, to] = friction(ball, rule, design.ball_diameter);
    let ((si, ci), (so, co)) = (ball.alpha_i.sin_cos(), ball.alpha_o.sin_cos());
    let (axial, radial) = (ball.q_i * si + ti * ci, ball.q_i * ci - ti * si);
    let left = [
        axial - ball.q_o * so - to * co,
        radial - ball.q_o * co + to * so + ball.centrifugal_force,
    ];
    let moment = design.inner_groove_factor * design.ball_diameter * ti;
    ([axial, radial, moment], left)
}

/// Force and moment of all balls on the inner ring.
pub fn carried(design: &Design, rule: Attitude, balls: &[BallState<f64>]) -> [f64; 5] {
    let [rp, zp] = inner_centre(design);
    let mut sum = [0.0; 5];
    for ball in balls {
        let ([axial, radial, of_friction], _) = forces(design, rule, ball);
        let (sin, cos) = ball.azimuth.sin_cos();
        let moment = rp * axial - zp * radial - of_friction;
        let parts = [
            axial,
            radial * cos,
            radial * sin,
            moment * sin,
            -moment * cos,
        ];
        for (sum, part) in sum.iter_mut().zip(parts) {
            *sum += part;
        }
    }
    sum
}

/// Residual force of the ball that is worst off, N.
pub fn unbalanced(design: &Design, rule: Attitude, balls: &[BallState<f64>]) -> f64 {
    balls.iter().fold(0.0, |most, ball| {
        let (_, [axial, radial]) = forces(design, rule, ball);
        worse(most, axial.hypot(radial))
    })
}
