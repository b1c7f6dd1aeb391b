//! What a solve gives.

use super::Solver;
use crate::float::Real;
use crate::next::curvature::stiffen;
use crate::next::frame::stiffness_out;
use crate::next::linalg::Matrix;
use crate::next::motion::{Body, Motion, Point};
use crate::next::pose::Pose;
use crate::next::ring::{Sum, shift};
use crate::status::Status;

use crate::solver::{BallState, ErrorEstimate};

/// An equilibrium, SI units; loads and displacements refer to the bearing centre.
#[derive(Debug)]
pub struct Solution<'s, T: Real, const N: usize, M: Motion, const D: usize> {
    /// How the solve ended: `Converged` or `PrecisionLimit`.
    pub status: Status<T>,
    /// Iterations, those of starts included.
    pub iterations: u16,
    /// How far the figures below can be off.
    pub error: ErrorEstimate<T>,
    /// Displacements `dx, dy, dz` (m), `ty, tz` (rad) of the inner ring.
    pub displacement: [T; D],
    /// Forces `Fx, Fy, Fz` (N) and moments `My, Mz` (N m) on the inner ring; the reaction where a displacement was
    /// given.
    pub load: [T; D],
    pub(super) solver: &'s Solver<'s, T, N, M, D>,
    pub(super) point: Point<T>,
}

impl<T: Real, const N: usize, M: Motion, const D: usize> Solution<'_, T, N, M, D> {
    /// Stiffness `dF/du` (rows are forces, columns displacements; N, N m per m, rad) at constant speed: the exact
    /// tangent, which is not symmetric at speed. That of some freedoms with the others held is a part of it.
    pub fn stiffness(&self) -> Matrix<T, D> {
        let (c, state) = (&self.solver.bearing.constants, &self.solver.state);
        if !state.correct {
            return stiffness_out(c, &state.sum.k);
        }
        let mut change = Sum::NONE;
        let azimuths = &self.solver.bearing.azimuths;
        stiffen(&self.solver.balls, azimuths, &state.v, &mut change);
        change.refer(c);
        let mut k = state.sum.k;
        for (row, change) in k.iter_mut().zip(&change.k) {
            for (x, change) in row.iter_mut().zip(change) {
                *x += *change;
            }
        }
        stiffness_out(c, &k)
    }

    fn poses(&self) -> impl ExactSizeIterator<Item = Pose<T>> + '_ {
        let bearing = self.solver.bearing;
        let balls = self.solver.balls.iter().zip(&bearing.azimuths);
        balls.map(move |(ball, at)| {
            let a = shift(&self.solver.state.v, at);
            ball.pose::<M::Rule>(&bearing.constants, &self.point, a)
        })
    }

    /// States of the balls, in the order of their azimuths.
    pub fn balls(&self) -> impl ExactSizeIterator<Item = BallState<T>> + '_ {
        let bearing = self.solver.bearing;
        let c = &bearing.constants;
        self.poses().zip(&bearing.azimuths).map(move |(pose, at)| {
            let (inner, outer) = (&pose.inner, &pose.outer);
            BallState {
                azimuth: at.sin.atan2(at.cos),
                alpha_i: inner.n[0].atan2(inner.n[1]),
                alpha_o: outer.n[0].atan2(outer.n[1]),
                q_i: inner.q * c.force,
                q_o: outer.q * c.force,
                delta_i: inner.delta * c.length,
                delta_o: outer.delta * c.length,
                centrifugal_force: pose.centrifugal * c.force,
                gyroscopic_moment: pose.couple * (c.force * c.ball_radius),
            }
        })
    }

    /// Forces on the inner race alone, N, in the order of the balls: without the cost of contact angles.
    pub fn inner_forces(&self) -> impl ExactSizeIterator<Item = T> + '_ {
        let force = self.solver.bearing.constants.force;
        self.poses().map(move |pose| pose.inner.q * force)
    }

    /// A copy that borrows nothing.
    pub fn snapshot(&self) -> Snapshot<T, N, D> {
        let mut balls = self.balls();
        Snapshot {
            status: self.status,
            iterations: self.iterations,
            error: self.error,
            displacement: self.displacement,
            load: self.load,
            stiffness: self.stiffness(),
            balls: core::array::from_fn(|_| balls.next().unwrap_or_default()),
        }
    }
}

/// A [`Solution`] that borrows nothing, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Snapshot<T, const N: usize, const D: usize> {
    /// How the solve ended.
    pub status: Status<T>,
    /// Iterations, those of starts included.
    pub iterations: u16,
    /// How far the figures below can be off.
    pub error: ErrorEstimate<T>,
    /// Displacements `dx, dy, dz` (m), `ty, tz` (rad) of the inner ring.
    pub displacement: [T; D],
    /// Forces (N) and moments (N m) on the inner ring.
    pub load: [T; D],
    /// Stiffness `dF/du`, rows are forces.
    pub stiffness: Matrix<T, D>,
    /// States of the balls, in the order of their azimuths.
    pub balls: [BallState<T>; N],
}
