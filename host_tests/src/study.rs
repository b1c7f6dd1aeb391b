//! The source study's scheme, as a baseline: nested Newton iterations with fixed step factors.
//!
//! The outer iteration moves the five ring displacements by `h2` of the Newton correction; before each
//! of its steps an inner iteration moves the four unknowns of every ball by `h1` of theirs until they
//! settle. Both start from rest and stop when the full correction falls below the tolerance. A fixed
//! factor `h` makes Newton's convergence linear, at `1 - h` a step; factors of one give
//! plain nested Newton.

use super::reference::{Attitude, BallState, Failure, Reference, masked_solve};
use core::array::from_fn;

/// Step factors and limits of the scheme.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StudySettings {
    /// Step factor of the inner iteration, on the unknowns of a ball.
    pub h1: f64,
    /// Step factor of the outer iteration, on the displacements of the ring.
    pub h2: f64,
    /// Correction below which an iteration has settled, in m; angles count as arcs.
    pub tolerance_m: f64,
    /// Limit of either iteration.
    pub max_iterations: usize,
}

impl StudySettings {
    /// The study's own numbers: factors 0.1, 1e-9 mm, 10,000 iterations.
    pub const STUDY: StudySettings = StudySettings {
        h1: 0.1,
        h2: 0.1,
        tolerance_m: 1e-12,
        max_iterations: 10_000,
    };

    /// The same without step factors.
    pub const PLAIN: StudySettings = StudySettings {
        h1: 1.0,
        h2: 1.0,
        ..StudySettings::STUDY
    };
}

/// Where the scheme ended, and what it cost.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyOutcome {
    /// Ring displacements in m and rad.
    pub u: [f64; 5],
    /// Stiffness `dF/du` at the last outer step, N and N m over m and rad.
    pub k: [[f64; 5]; 5],
    /// The balls.
    pub balls: Vec<BallState>,
    /// Whether both iterations settled within their limits.
    pub converged: bool,
    /// Steps of the outer iteration.
    pub outer_iterations: usize,
    /// Evaluations of one ball's equations with their derivatives, over all balls.
    pub ball_evaluations: usize,
}

/// Solves for equilibrium under `load` (N, N m) at `omega` in rad/s.
///
/// # Errors
/// [`Failure::Input`] if load or speed is not finite; an iteration that does not settle is no
/// error but ends with `converged` false.
pub fn solve(
    reference: &Reference,
    load: [f64; 5],
    omega: f64,
    attitude: Attitude,
    settings: &StudySettings,
) -> Result<StudyOutcome, Failure> {
    let mut u = reference.static_guess(load)?;
    if !omega.is_finite() {
        return Err(Failure::Input("omega"));
    }
    let n = reference.balls();
    let lever = reference.pitch_radius();
    let unit = [1.0, 1.0, 1.0, lever, lever];
    let mut balls: Vec<[f64; 4]> = (0..n)
        .map(|j| reference.start_of_ball(&reference.inner_centre(j, &u), omega, attitude))
        .collect();
    let mut k = [[0.0; 5]; 5];
    let mut evaluations = 0;
    let mut steps = 0;
    let mut converged = false;
    'outer: while steps < settings.max_iterations {
        steps += 1;
        let mut force = [0.0; 5];
        k = [[0.0; 5]; 5];
        for (j, w) in balls.iter_mut().enumerate() {
            let centre = reference.inner_centre(j, &u);
            if omega == 0.0 {
                // At rest a ball has a closed form and may be off both races.
                *w = reference.unknowns(&reference.resting(&centre), &centre);
            }
            let mut settled = false;
            for _ in 0..settings.max_iterations {
                evaluations += 1;
                let lin = reference.linearise(w, &centre, omega, attitude);
                let [c0, c1] = lin.terms.closure.map(|t| t.v);
                let [b0, b1] = lin.terms.balance.map(|t| t.v);
                let Some((dw, g)) = lin.solve([c0, c1, b0, b1]) else {
                    break 'outer;
                };
                if omega == 0.0 || reference.arc(&dw) < settings.tolerance_m {
                    let station = &reference.stations[j];
                    station.collect(&lin.terms.ring.map(|t| t.v), &mut force);
                    lin.add_stiffness(&mut k, &g, station);
                    settled = true;
                    break;
                }
                for (w, dw) in w.iter_mut().zip(dw) {
                    *w += settings.h1 * dw;
                }
            }
            if !settled {
                break 'outer;
            }
        }
        let rest = from_fn(|i| load[i] - force[i]);
        let Some(du) = masked_solve(&k, &rest, &[true; 5], &unit) else {
            break;
        };
        let size = du
            .iter()
            .zip(unit)
            .fold(0.0_f64, |s, (d, unit)| s.max((d * unit).abs()));
        if size < settings.tolerance_m {
            converged = true;
            break;
        }
        for (u, du) in u.iter_mut().zip(du) {
            *u += settings.h2 * du;
        }
    }
    Ok(StudyOutcome {
        balls: reference.report_plain(&balls, omega, attitude),
        u,
        k,
        converged,
        outer_iterations: steps,
        ball_evaluations: evaluations,
    })
}
