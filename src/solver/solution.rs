//! What a solve gives.

use super::{Solver, View};
use crate::ball::Pass;
use crate::conditions::{Conditions, Loads};
use crate::float::Real;
use crate::freedoms::{All, BallStore, FreedomSet, Freedoms};
use crate::outputs::{Balls, Outputs, PerBall};
use crate::ring::shift;
use crate::scene::Motion;
use crate::status::Status;

/// State of one ball, SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct BallState<T> {
    /// Azimuth `phi`, rad from +y towards +z.
    pub azimuth: T,
    /// Inner contact angle, rad.
    pub alpha_i: T,
    /// Outer contact angle, rad.
    pub alpha_o: T,
    /// Inner contact force, N; 0 if the ball is off the inner race.
    pub q_i: T,
    /// Outer contact force, N.
    pub q_o: T,
    /// Deformation of the inner contact, m; negative where there is a gap.
    pub delta_i: T,
    /// Deformation of the outer contact, m.
    pub delta_o: T,
    /// Centrifugal force `Fc`, N.
    pub centrifugal_force: T,
    /// Gyroscopic moment `Mg`, N m.
    pub gyroscopic_moment: T,
}

/// Estimated errors of a solution, relative.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ErrorEstimate<T> {
    /// Of displacements: of the largest component, tilts taken at the pitch radius.
    pub displacement: T,
    /// Of contact forces: of the largest.
    pub force: T,
    /// Of the stiffness: an element's error over the root of the two diagonal elements.
    pub stiffness: T,
}

/// An equilibrium, SI units; forces and displacements refer to the bearing centre. Vectors have as many
/// components as the scene has freedoms, in the order given here.
pub struct Solution<
    's,
    T: Real,
    const N: usize,
    M: Motion,
    F: FreedomSet = All,
    B: Conditions<F> = Loads,
    O: Outputs = Balls,
> {
    /// How the solve ended: `Converged`, `PrecisionLimit`, `SweepLimit` or `Unseated`.
    pub status: Status<T>,
    /// Sweeps over the balls.
    pub sweeps: u16,
    /// Ball passes beyond one a ball and sweep: of balls that were badly off by themselves, and at rest of all.
    pub repeats: u16,
    /// Load less the balls' forces before the ring's last step, relative to the load (moments over `Rp`).
    pub residual: T,
    /// How far the figures below can be off.
    pub error: ErrorEstimate<T>,
    /// Displacements `dx, dy, dz` (m), `ty, tz` (rad) of the inner ring.
    pub displacement: F::Vector<T>,
    /// Forces `Fx, Fy, Fz` (N) and moments `My, Mz` (N m) that hold the balls' forces on the ring;
    /// where the displacement was given, this is the reaction.
    pub load: F::Vector<T>,
    /// Stiffness: derivative of the forces (rows) by the displacements (columns) at constant speed, of
    /// the freedoms that are free, with the others held. Not symmetric at speed.
    pub stiffness: O::Stiffness<B::Stiffness<T>>,
    pub(super) solver: O::Balls<&'s Solver<'s, T, N, M, F, B, O>>,
}

impl<T, const N: usize, M, F, B, O> core::fmt::Debug for Solution<'_, T, N, M, F, B, O>
where
    T: Real,
    M: Motion,
    F: FreedomSet,
    B: Conditions<F>,
    O: Outputs,
{
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Solution")
            .field("status", &self.status)
            .field("sweeps", &self.sweeps)
            .field("repeats", &self.repeats)
            .field("residual", &self.residual)
            .field("error", &self.error)
            .field("displacement", &self.displacement)
            .field("load", &self.load)
            .field("stiffness", &self.stiffness)
            .finish_non_exhaustive()
    }
}

impl<T, const N: usize, const D: usize, M, B, O> Solution<'_, T, N, M, Freedoms<D>, B, O>
where
    T: Real,
    M: Motion,
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// States of the balls, in the order of their azimuths; of the first one, where it stands for all.
    pub fn balls(&self) -> impl ExactSizeIterator<Item = BallState<T>> + '_
    where
        O: PerBall,
    {
        self.view().states()
    }

    /// The bearing and its balls.
    pub(crate) fn view(&self) -> View<'_, T, M, D>
    where
        O: PerBall,
    {
        O::solver(&self.solver).view()
    }

    /// Forces on the inner race alone, N, in the order of the balls: what a monitor looks at, without
    /// the cost of contact angles.
    pub fn inner_forces(&self) -> impl ExactSizeIterator<Item = T> + '_
    where
        O: PerBall,
    {
        self.view().inner_forces()
    }
}

impl<'v, T: Real, M: Motion, const D: usize> View<'v, T, M, D> {
    /// As [`Solution::balls`].
    fn states(self) -> impl ExactSizeIterator<Item = BallState<T>> + 'v {
        let Self { c, azimuths, .. } = self;
        let passes = self.passes().zip(azimuths);
        passes.map(move |(pass, at)| BallState {
            azimuth: at.sin.atan2(at.cos),
            alpha_i: pass.inner.sin.atan2(pass.inner.cos),
            alpha_o: pass.outer.sin.atan2(pass.outer.cos),
            q_i: pass.inner.q * c.force,
            q_o: pass.outer.q * c.force,
            delta_i: pass.inner.delta * c.length,
            delta_o: pass.outer.delta * c.length,
            centrifugal_force: pass.loads.centrifugal * c.force,
            gyroscopic_moment: pass.loads.friction * c.force * c.ball_radius,
        })
    }

    /// Contacts and loads of every ball in the units of the constants.
    pub(crate) fn passes(self) -> impl ExactSizeIterator<Item = Pass<T>> + 'v {
        let Self { c, state, .. } = self;
        let balls = self.balls.iter().zip(self.azimuths);
        balls.map(move |(ball, at)| {
            let a = shift(&state.position.offset, at);
            M::observe(c, state.speed_load, ball, a)
        })
    }

    /// As [`Solution::inner_forces`].
    fn inner_forces(self) -> impl ExactSizeIterator<Item = T> + 'v {
        let c = self.c;
        self.passes().map(move |pass| pass.inner.q * c.force)
    }
}

#[cfg(feature = "nalgebra")]
impl<T, const N: usize, const D: usize, M, B, O> Solution<'_, T, N, M, Freedoms<D>, B, O>
where
    T: Real + nalgebra::Scalar,
    M: Motion,
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// The displacement as a vector of `nalgebra`.
    pub fn displacement_vector(&self) -> nalgebra::SVector<T, D> {
        nalgebra::SVector::from(self.displacement)
    }

    /// The stiffness as a matrix of `nalgebra`.
    pub fn stiffness_matrix<const K: usize>(&self) -> nalgebra::SMatrix<T, K, K>
    where
        O: Outputs<Stiffness<B::Stiffness<T>> = [[T; K]; K]>,
    {
        nalgebra::SMatrix::from_fn(|i, j| self.stiffness[i][j])
    }
}

#[cfg(feature = "defmt")]
impl<T, const N: usize, M, F, B, O> defmt::Format for Solution<'_, T, N, M, F, B, O>
where
    T: Real,
    M: Motion,
    F: FreedomSet,
    B: Conditions<F>,
    O: Outputs,
{
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "{} after {} sweeps, residual {}, errors {}; displacement {}, load {}, stiffness {}",
            self.status,
            self.sweeps,
            self.residual,
            self.error,
            self.displacement,
            self.load,
            self.stiffness
        );
    }
}
