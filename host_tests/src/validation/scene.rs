//! Bearings under load, solved in both precisions and by the reference build.

use super::Progress;
use crate::cases::{self, rad_per_s};
use crate::compare::{Ball, Equilibrium, worse};
use crate::dispatch::{self, Attitude, Precision};
use crate::tolerances::{allowed, allowed_at};
use anyhow::{Context, anyhow};
use rayon::prelude::*;
use spindle_bearing::{BallState, Design};

/// A bearing, a load, a speed.
#[derive(Debug, Clone)]
pub struct Scene {
    /// What error messages call the bearing.
    pub name: &'static str,
    /// The bearing.
    pub design: Design,
    /// Ball count.
    pub balls: usize,
    /// Rule for the attitude.
    pub attitude: Attitude,
    /// `Fx, Fy, Fz, My, Mz`, N and N m.
    pub load: [f64; 5],
    /// Shaft speed, rpm.
    pub rpm: f64,
}

/// The double-precision solution of a scene.
#[derive(Debug, Clone)]
pub struct Solved {
    /// The scene.
    pub scene: Scene,
    /// `dx, dy, dz, ty, tz`, m and rad.
    pub u: [f64; 5],
    /// Stiffness, SI; rows are forces.
    pub k: [[f64; 5]; 5],
    /// The balls.
    pub balls: Vec<BallState<f64>>,
    /// The worst error, over what `tolerances` allows it, of double and of single precision against
    /// the reference build.
    pub against_reference: [f64; 2],
}

impl Scene {
    fn solve_in(&self, precision: Precision) -> anyhow::Result<(Equilibrium, Vec<BallState<f64>>)> {
        let bearing = dispatch::bearing(&self.design, self.balls, precision)
            .map_err(|e| anyhow!("{e}"))
            .with_context(|| format!("{} cannot be built", self.name))?;
        let mut balls = Vec::new();
        let answer = bearing.solver(self.attitude).solve_with_balls(
            self.load,
            rad_per_s(self.rpm),
            Some(&mut balls),
        );
        let figures = answer.figures.map_err(|why| anyhow!("{why}"))?;
        let equilibrium = Equilibrium {
            displacement: figures.displacement,
            stiffness: figures.stiffness,
            balls: balls.iter().map(Ball::from).collect(),
        };
        Ok((equilibrium, balls))
    }

    /// Solves it in double precision, and holds that and the single-precision solution against
    /// the reference build's.
    ///
    /// # Errors
    ///
    /// One of the three has no solution; the message names the scene.
    pub fn solve(&self) -> anyhow::Result<Solved> {
        self.judged().with_context(|| {
            format!(
                "{} under {:?} (N, N m) at {} rpm, {:?}: this point of the page has no answer any \
                 more; `cargo test truth` tells whether the solver is to blame",
                self.name, self.load, self.rpm, self.attitude
            )
        })
    }

    fn judged(&self) -> anyhow::Result<Solved> {
        let (found, balls) = self.solve_in(Precision::F64)?;
        let (narrow, _) = self.solve_in(Precision::F32).context("single precision")?;
        let truth = cases::reference(&self.design, self.balls)
            .search(self.load, rad_per_s(self.rpm), self.attitude.into())
            .context("reference build")?;
        let truth = Equilibrium::from(&truth);
        let pitch_radius = 0.5 * self.design.pitch_diameter;
        let largest = truth.largest_displacement(pitch_radius) / self.design.centre_distance();
        let share = |found: &Equilibrium, allowed: crate::compare::Errors| {
            let e = found.errors(&truth, self.design.ball_diameter, pitch_radius);
            [
                e.displacement / allowed.displacement,
                e.contact_angle / allowed.contact_angle,
                e.force / allowed.force,
                e.stiffness / allowed.stiffness,
            ]
            .into_iter()
            .fold(0.0, worse)
        };
        Ok(Solved {
            scene: self.clone(),
            u: found.displacement,
            k: found.stiffness,
            against_reference: [
                share(&found, allowed(Precision::F64)),
                share(&narrow, allowed_at(Precision::F32, largest)),
            ],
            balls,
        })
    }
}

impl Solved {
    /// Shaft speed, rad/s.
    pub fn omega(&self) -> f64 {
        rad_per_s(self.scene.rpm)
    }
}

/// Solves all of them, on every core.
///
/// # Errors
///
/// The first scene without a solution.
pub fn solve_all(scenes: Vec<Scene>, progress: &dyn Progress) -> anyhow::Result<Vec<Solved>> {
    progress.expect(scenes.len());
    scenes
        .into_par_iter()
        .map(|scene| {
            let solved = scene.solve();
            progress.done(1);
            solved
        })
        .collect()
}

/// The sample points of an axis: `from` to `to` in `steps` even steps.
pub fn evenly(from: f64, to: f64, steps: usize) -> Vec<f64> {
    (0..=steps)
        .map(|i| from + (to - from) * i as f64 / steps as f64)
        .collect()
}
