//! Memory of a solver: the start of its next solve, and the source of results.

use crate::ball::Ball;
use crate::ball::contact::Point;
use crate::ball::kinematics::{Motion, Rule, Speed};
use crate::linalg::{Matrix, add_to, moved, product, refer, refer_stiffness, vector};
use crate::real::Real;
use crate::results::Balls;
use crate::shaft::elastic::{Bend, Joint, add, fold};
use crate::shaft::row::{Sum, stiffness_change, sum_up};
use crate::shaft::{Layout, Mount};
use crate::solver::state::{ErrorEstimate, State, Termination, are_finite, rounding};
use core::marker::PhantomData;

/// Position and balls after the last solve of a shaft in `R` rows of at most `N` balls, with `D` freedoms.
#[derive(Debug, Clone, Copy)]
pub struct WarmStart<T: Real, const R: usize, const N: usize, const D: usize, const E: usize> {
    pub state: State<T, D>,
    pub balls: [[Ball<T>; N]; R],
    /// Speed, growth and references of every row.
    pub points: [Point<T>; R],
    /// Axial force by which rows of either facing hold each other.
    pub preload: T,
    /// Speed of the shaft, rad/s.
    pub omega: T,
    /// Fingerprint of the bearings and shaft that were solved last.
    pub fingerprint: u32,
    /// Elastic state of each row: forces and deflection.
    pub bends: [Bend<T, D>; E],
}

/// Displacement of the shaft's centre, load that the rows carry there, and iterations so far.
pub struct Reached<T, const D: usize> {
    pub u: [T; D],
    pub load: [T; D],
    pub iterations: u16,
    /// How far the figures of an elastic shaft can be off.
    pub error: Option<ErrorEstimate<T>>,
}

impl<T: Real, const R: usize, const N: usize, const D: usize, const E: usize>
    WarmStart<T, R, N, D, E>
{
    /// Of a solver that has not solved yet.
    pub const COLD: Self = Self {
        state: State::COLD,
        balls: [[Ball::NONE; N]; R],
        points: [Point::NONE; R],
        preload: T::ZERO,
        omega: T::ZERO,
        fingerprint: 0,
        bends: [Bend::NONE; E],
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

    /// How far the figures of an elastic shaft at the displacement `u` can be off.
    #[inline(never)]
    fn errors<const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET, E>,
        u: &[T; D],
    ) -> ErrorEstimate<T> {
        let mut error = self.state.errors(u, self.points[0].s * layout.ball_count);
        // A row's motion is a difference of the shaft's and its deflection.
        let mut offset = T::ZERO;
        for u in self.bends.iter().flat_map(|bend| &bend.deflection) {
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
            error: (E > 0).then(|| self.errors(layout, &u)),
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
        let inertia = self.points[0].s * layout.ball_count;
        let is_finite = self.state.errors(&reached.u, inertia).is_finite()
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
            return self.stiffness_towards::<A, SET>(layout, &layout.joints);
        }
        let mut change = Sum::NONE;
        let rows = layout.bearings.iter().zip(&layout.mounts);
        for ((row, mount), (p, balls)) in rows.zip(self.points.iter().zip(&self.balls)) {
            let balls = balls.get(..row.azimuths.len()).unwrap_or_default();
            let v = mount.motion::<D, SET>(&self.state.v);
            if SET {
                let mut own = stiffness_change::<T, A, 5>(p, balls, row.azimuths, &v);
                mount.assemble(&mut own, &mut change);
            } else {
                change = stiffness_change::<T, A, D>(p, balls, row.azimuths, &v);
                refer_stiffness(layout.plane, &mut change.k);
            }
        }
        add_to(&mut k, &change.k);
        k
    }

    /// Stiffness about the point of an elastic shaft that these joints lead to, after the last step.
    #[inline(never)]
    pub fn stiffness_towards<A: Rule, const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET, E>,
        joints: &[Joint<T>; E],
    ) -> Matrix<T, D> {
        let mut add_row = |joint: &Joint<T>, sum: &mut Sum<T, D>| {
            let (row, mount) = (joint.row, layout.mounts.get(joint.row));
            let (balls, p, bearing) = (
                self.balls.get(row),
                self.points.get(row),
                layout.bearings.get(row),
            );
            let (Some(mount), Some(balls), Some(p), Some(bearing)) = (mount, balls, p, bearing)
            else {
                return;
            };
            let azimuths = bearing.azimuths;
            let balls = balls.get(..azimuths.len()).unwrap_or_default();
            let mut own = Sum::<T, 5>::NONE;
            sum_up::<T, A, 5>(balls, azimuths, &mut own);
            if self.state.stale {
                let v = self.motion::<SET>(mount, row);
                own.add(&stiffness_change::<T, A, 5>(p, balls, azimuths, &v));
            }
            mount.assemble(&mut own, sum);
        };
        let mut sum = Sum::NONE;
        fold(joints, &mut [], &mut add_row, &mut sum);
        sum.k
    }

    /// Offset of a row's groove plane from its reference position.
    #[inline(always)]
    fn motion<const SET: bool>(&self, mount: &Mount<T>, row: usize) -> [T; 5] {
        let mut v = mount.motion::<D, SET>(&self.state.v);
        if let Some(bend) = self.bends.get(row) {
            add(&mut v, T::ONE, &mount.of_centre(&bend.deflection));
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
        let row = &layout.bearings[i];
        Balls {
            c: row.c,
            p: &self.points[i],
            azimuths: row.azimuths,
            balls: self.balls[i].get(..row.azimuths.len()).unwrap_or_default(),
            v: self.motion::<SET>(&layout.mounts[i], i),
            speed: Speed::rad_per_s(self.omega),
            motion: PhantomData,
        }
    }
}
