//! Memory of a solver: the start of its next solve, and the source of results.

use crate::ball::Ball;
use crate::ball::contact::Point;
use crate::ball::kinematics::{Motion, Rule, Speed};
use crate::linalg::{Matrix, add_to, moved, product, refer, refer_stiffness, vector};
use crate::real::Real;
use crate::results::Balls;
use crate::rows::elastic::{Deflection, Joint, fold};
use crate::rows::row::{Sum, stiffness_change, sum_up};
use crate::rows::{BearingRef, Layout, Placed};
use crate::solver::problem::units;
use crate::solver::state::{State, Termination, are_finite, rounding};
use crate::status::ErrorEstimate;
use core::marker::PhantomData;

/// Position and balls after the last solve of a shaft in `R` rows of at most `N` balls, with `D` freedoms.
#[derive(Debug, Clone, Copy)]
pub struct WarmStart<T: Real, const R: usize, const N: usize, const D: usize, const E: usize> {
    pub state: State<T, D>,
    pub rows: [RowState<T, N>; R],
    /// Axial force by which rows of either facing hold each other.
    pub preload: T,
    /// Speed of the shaft, rad/s.
    pub omega: T,
    /// Fingerprint of the bearings and shaft that were solved last.
    pub fingerprint: u32,
    /// Elastic state of each row: forces and deflection.
    pub deflections: [Deflection<T, D>; E],
}

/// A row after a solve: its balls, and their speed, growth and references.
#[derive(Debug, Clone, Copy)]
pub struct RowState<T: Real, const N: usize> {
    pub point: Point<T>,
    pub balls: [Ball<T>; N],
}

/// Displacement of the shaft's centre, load that the rows carry there, and iterations so far.
pub struct Reached<T, const D: usize> {
    pub u: [T; D],
    pub load: [T; D],
    pub iterations: u16,
    /// How far the figures of an elastic shaft can be off.
    pub error: Option<ErrorEstimate<T>>,
}

impl<T: Real, const N: usize> RowState<T, N> {
    /// The balls that this bearing uses.
    #[inline(always)]
    pub fn used(&self, bearing: &BearingRef<'_, T>) -> &[Ball<T>] {
        self.balls.get(..bearing.azimuths.len()).unwrap_or_default()
    }

    /// [`stiffness_change`] of its balls.
    #[inline(always)]
    fn stiffness_change<A: Rule, const D: usize>(
        &self,
        bearing: &BearingRef<'_, T>,
        v: &[T; 5],
    ) -> Sum<T, D> {
        stiffness_change::<T, A, D>(&self.point, self.used(bearing), bearing.azimuths, v)
    }
}

impl<T: Real, const R: usize, const N: usize, const D: usize, const E: usize>
    WarmStart<T, R, N, D, E>
{
    /// Of a solver that has not solved yet.
    pub const COLD: Self = Self {
        state: State::COLD,
        rows: [RowState {
            point: Point::NONE,
            balls: [Ball::NONE; N],
        }; R],
        preload: T::ZERO,
        omega: T::ZERO,
        fingerprint: 0,
        deflections: [Deflection::NONE; E],
    };

    /// Has the next solve start from nothing.
    pub fn reset(&mut self) {
        self.state = State::COLD;
    }

    /// Turns to the bearings and shaft of this fingerprint: from nothing, if they are others.
    #[inline(always)]
    pub fn turn_to(&mut self, fingerprint: u32) {
        if fingerprint != self.fingerprint {
            self.fingerprint = fingerprint;
            self.reset();
        }
    }

    /// Refers what the balls handed over to a point that is nearer to the origin by `distance`, over `Rp`.
    pub fn refer(&mut self, distance: T) {
        if distance == T::ZERO {
            return;
        }
        let State { sum, load, .. } = &mut self.state;
        for force in [&mut sum.force, &mut sum.by_speed, load] {
            refer(distance, force);
        }
        refer_stiffness(distance, &mut sum.k);
        self.state.attempt.control.last.work = T::ZERO;
    }

    /// [`State::errors`] of these rows.
    pub fn errors_of_state<const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET, E>,
        u: &[T; D],
    ) -> ErrorEstimate<T> {
        let inertia = self.rows[0].point.s * layout.ball_count;
        self.state.errors(u, inertia, layout.has_sleeve::<D>())
    }

    /// How far the figures of an elastic shaft at the displacement `u` can be off.
    #[inline(never)]
    fn errors<const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET, E>,
        u: &[T; D],
    ) -> ErrorEstimate<T> {
        let mut error = self.errors_of_state(layout, u);
        // A row's motion is a difference of the shaft's and its deflection.
        let mut offset = T::ZERO;
        let deflections = layout.of_joints(&self.deflections).iter();
        for u in deflections.flat_map(|deflection| &deflection.now) {
            offset = offset.at_least(u.abs());
        }
        let rounding = rounding(self.state.attempt.report.estimate.largest, &[offset]);
        error.force += rounding + rounding;
        error.stiffness += rounding;
        error
    }

    #[inline(always)]
    pub fn reached<const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET, E>,
        iterations: u16,
    ) -> Reached<T, D> {
        let State { v, at, sum, .. } = &self.state;
        let du = moved(-layout.plane, &vector(|i| v[i] - at[i]));
        let u = self.state.displacement(layout.plane);
        Reached {
            u,
            error: layout.bends().then(|| self.errors(layout, &u)),
            load: vector(|i| sum.force[i] + product(&sum.k[i], &du)),
            iterations,
        }
    }

    /// Where a solve was that ended without an answer for want of time, if all figures are finite.
    pub fn unfinished<A: Rule, const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET, E>,
    ) -> Option<Reached<T, D>> {
        let attempt = &self.state.attempt;
        if attempt.termination != Termination::Unfinished
            || attempt.pass.is_open()
            || self.fingerprint != layout.fingerprint
        {
            return None;
        }
        let reached = self.reached(layout, attempt.taken);
        let errors = self.errors_of_state(layout, &reached.u);
        let is_finite = are_finite(&[errors.displacement, errors.force, errors.stiffness])
            && are_finite(&reached.u)
            && are_finite(&reached.load)
            && self
                .tangent::<A, SET>(layout)
                .iter()
                .all(|row| are_finite(row));
        is_finite.then_some(reached)
    }

    /// The stiffness about the shaft's centre, after the last step.
    pub fn tangent<A: Rule, const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET, E>,
    ) -> Matrix<T, D> {
        let mut k = self.state.sum.k;
        if !self.state.stale {
            return k;
        }
        if E > 0 {
            return self.stiffness_towards::<A, SET>(layout, layout.joints());
        }
        let mut change = Sum::NONE;
        for (Placed { bearing, mount, .. }, row) in layout.rows().iter().zip(&self.rows) {
            let v = mount.motion::<D, SET>(&self.state.v);
            if SET {
                let mut own = row.stiffness_change::<A, 5>(bearing, &v);
                mount.assemble(&mut own, &mut change);
            } else {
                change = row.stiffness_change::<A, D>(bearing, &v);
                refer_stiffness(layout.plane, &mut change.k);
            }
        }
        add_to(&mut k, &change.k);
        k
    }

    /// Stiffness about the point that these joints of a shaft that may bend lead to, about its centre without joints, after the last
    /// step.
    #[inline(never)]
    pub fn stiffness_towards<A: Rule, const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET, E>,
        joints: &[Joint<T>],
    ) -> Matrix<T, D> {
        let bends = !joints.is_empty();
        let mut add_row = |number: usize, sum: &mut Sum<T, D>| {
            let Some(placed) = layout.rows.get(number) else {
                return;
            };
            let mut own = self.slopes::<A, SET>(layout, number, bends);
            placed.mount.assemble(&mut own, sum);
        };
        let mut sum = Sum::NONE;
        if bends {
            fold(joints, &mut [], &mut add_row, &mut sum);
            return sum.k;
        }
        for row in 0..layout.count() {
            add_row(row, &mut sum);
        }
        add_to(&mut sum.k, &self.state.sum.k);
        sum.k
    }

    /// Slopes of a row in its own frame, about its groove plane, after the last step; their change by that step alone if not `in_full`.
    #[inline(always)]
    pub fn slopes<A: Rule, const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET, E>,
        number: usize,
        in_full: bool,
    ) -> Sum<T, 5> {
        let mut own = Sum::NONE;
        let (Some(placed), Some(row)) = (layout.rows.get(number), self.rows.get(number)) else {
            return own;
        };
        let bearing = &placed.bearing;
        if in_full {
            sum_up::<T, A, 5>(row.used(bearing), bearing.azimuths, &mut own);
        }
        if self.state.stale {
            let v = self.motion::<SET>(layout, number);
            own.add(&row.stiffness_change::<A, 5>(bearing, &v));
        }
        own
    }

    /// Offset of a row's groove plane from its reference position.
    #[inline(always)]
    fn motion<const SET: bool>(&self, layout: &Layout<'_, T, R, SET, E>, row: usize) -> [T; 5] {
        let mount = &layout.rows[row.min(R - 1)].mount;
        let mut v = mount.motion::<D, SET>(&self.state.v);
        if let Some(deflection) = layout.of_joints(&self.deflections).get(row) {
            mount.deflect(&mut v, &deflection.now);
        }
        v
    }

    /// The balls of a row.
    #[inline(always)]
    pub fn row<'s, M: Motion, const SET: bool>(
        &'s self,
        layout: &Layout<'s, T, R, SET, E>,
        i: usize,
    ) -> Balls<'s, T, M> {
        // The compiler sees the range, even where it does not inline this.
        let i = i.min(R - 1);
        let (Placed { bearing, .. }, row) = (&layout.rows[i], &self.rows[i]);
        Balls {
            c: bearing.c,
            p: &row.point,
            azimuths: bearing.azimuths,
            balls: row.used(bearing),
            v: self.motion::<SET>(layout, i),
            speed: Speed::rad_per_s(self.omega),
            motion: PhantomData,
        }
    }

    /// Sum of a row's balls where they were condensed; and the force on its inner ring after the last step, about its centre, SI.
    pub fn row_force<M: Motion, const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET, E>,
        i: usize,
        row: &Balls<'_, T, M>,
    ) -> (Sum<T, 5>, [T; 5]) {
        let (mount, c) = (&layout.rows[i.min(R - 1)].mount, row.c);
        let mut sum = Sum::NONE;
        sum_up::<T, M::Rule, 5>(row.balls, row.azimuths, &mut sum);
        let du = match layout.of_joints(&self.deflections).get(i) {
            Some(deflection) => mount.of_centre(&deflection.moved),
            None => mount.motion::<D, SET>(&vector(|i| self.state.v[i] - self.state.at[i])),
        };
        let mut force: [T; 5] = vector(|i| sum.force[i] + product(&sum.k[i], &du));
        refer(c.plane, &mut force);
        (sum, vector(|i| force[i] * units(c, i).0))
    }
}
