//! What a search at rest and one at speed have in common: the state they work on, the ring's steps, and a look at
//! what they have found.

use super::State;
use super::course::{Attempt, Weakness};
use super::thresholds;
use crate::axial::Spring;
use crate::ball::{COUNTS, Pass};
use crate::conditions::{Conditions, constrain, held, hold, missing};
use crate::constants::{Azimuth, Constants};
use crate::contact::{Pair, dot};
use crate::float::Real;
use crate::freedoms::{BallStore, Freedoms};
use crate::kinematics::NEAREST_POLE;
use crate::outputs::Outputs;
use crate::ring::{self, Definite, Factors, Tangent, norm, shift, side, span};
use crate::scene::Motion;
use crate::status::Status;
use core::marker::PhantomData;

/// What is given: the load on the ring, or its displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Given<T, const D: usize> {
    Load([T; D]),
    Displacement([T; D]),
}

/// What is to be solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Task<T, const D: usize> {
    pub given: Given<T, D>,
    /// Displacements of held freedoms.
    pub wanted: [T; D],
    pub speed_load: T,
    pub tolerance: T,
}

/// One bearing's iteration: constants, azimuths, and the state it works on.
pub struct Iteration<'i, T: Real, M: Motion, B, O, const D: usize> {
    pub c: &'i Constants<T>,
    pub azimuths: &'i [Azimuth<T>],
    pub state: &'i mut State<T, D>,
    pub balls: &'i mut [M::Ball<T>],
    /// All balls are in the same state, so that one is worked out for all.
    pub alike: bool,
    pub scene: PhantomData<(B, O)>,
}

impl<T: Real, M: Motion, B, O, const D: usize> Iteration<'_, T, M, B, O, D>
where
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// What each ball carries under the axial load and so much preload that radial load and moment do not unload
    /// balls at first sight, and the axial displacement that belongs to it at rest. From above, Newton on a 3/2
    /// law does not overshoot. `preload` multiplies all of it.
    pub fn pressed(&self, load: &[T; D], preload: T) -> (T, T) {
        let c = self.c;
        let mut pressing = load[0].abs();
        if D >= 3 {
            pressing += T::of(0.5) * (load[1] * load[1] + load[2] * load[2]).sqrt();
        }
        if D == 5 {
            pressing += (load[3] * load[3] + load[4] * load[4]).sqrt();
        }
        let q = preload * pressing / ring::sharing::<T, D>(c);
        let (s0, mut w) = (c.n0[0].high, T::ONE);
        for _ in 0..24 {
            let step = Spring::at(s0, w).step(q);
            w = (w - step).at_least(T::of(0.1) * w);
            if step.abs() <= T::of(0.01) * w {
                break;
            }
        }
        (q, side(load) * Spring::at(s0, w).axial - s0)
    }

    /// The step to where the last tangent sees the ring under a load that is larger by `b`, and what each ball's
    /// force does `beyond` that tangent on the way there takes back.
    #[inline(always)]
    pub fn extrapolation(
        &mut self,
        mut b: [T; D],
        wanted: &[T; D],
        beyond: impl Fn(&Constants<T>, &mut M::Ball<T>, Pair<T>) -> Pair<T>,
    ) -> [T; D] {
        let mut own = [[T::ZERO; D]; D];
        let by = missing::<T, B, D>(self.c, wanted, &self.state.position.total());
        let tangent = held::<T, B, D>(self.c, &by, &mut b, &self.state.tangent, &mut own);
        let (factors, _) = Factors::of(tangent, T::of(8.0) * T::EPSILON);
        let mut du = factors.solve(&b);
        let mut sums = [T::ZERO; D];
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let force = beyond(self.c, ball, shift(&du, at));
            ring::spread(&mut sums, at, force, T::ZERO);
        }
        hold::<T, B, D>(self.c, &[T::ZERO; D], &mut sums, &mut own);
        for (step, back) in du.iter_mut().zip(&factors.solve(&sums)) {
            *step -= *back;
        }
        constrain::<T, B, D>(self.c, &by, &mut du);
        du
    }

    /// Where the ring is, about, under a load that is nearly radial: it gives way along its axis until the contact
    /// angles are those of the load, far below the free one, so that only balls on the loaded side carry. The ball
    /// that faces the load is then in line with it. Nothing where the axial load presses all balls, as
    /// [`Iteration::pressed`] has it, and where those on the other side would have no room under the inner ring.
    pub fn facing(&self, load: &[T; D], attempt: Attempt) -> Option<[T; D]> {
        if D < 3 || B::HOLDS || !attempt.faces() {
            return None;
        }
        let c = self.c;
        let [s0, c0] = [c.n0[0].high, c.n0[1].high];
        let radial = (load[1] * load[1] + load[2] * load[2]).sqrt();
        let mut pressing = load[0].abs();
        if D == 5 {
            pressing += (load[3] * load[3] + load[4] * load[4]).sqrt();
        }
        if !(pressing * c0 < radial * s0) {
            return None;
        }
        let size = (load[0] * load[0] + radial * radial).sqrt();
        let q = T::of(thresholds::STRIBECK) * size / ring::sharing::<T, D>(c);
        let root = q.cbrt();
        let per_load = (T::ONE + root * root) / size;
        let offset = per_load * radial - c0;
        if c0 - offset < c.outer {
            return None;
        }
        let mut u = [T::ZERO; D];
        u[0] = per_load * load[0] - s0;
        u[1] = offset * load[1] / radial;
        u[2] = offset * load[2] / radial;
        Some(u)
    }

    /// The axial displacement `x`, and what held freedoms are `wanted` to have.
    pub fn displaced(&self, x: T, wanted: &[T; D]) -> [T; D] {
        let mut u = [T::ZERO; D];
        u[0] = x;
        let missing = missing::<T, B, D>(self.c, wanted, &u);
        let mut step = [T::ZERO; D];
        constrain::<T, B, D>(self.c, &missing, &mut step);
        for (u, step) in u.iter_mut().zip(&step) {
            *u += *step;
        }
        u
    }

    /// One Newton step from `du`, shortened where it would lead further than `longest` and turned
    /// downhill where the tangent is not positive definite: by adding to its diagonal. Close to the
    /// solution (`close`) an indefinite tangent is taken as it is. Of a ladder of such dampings it takes
    /// the first that does; those above it mostly do, too, so that the search begins next to the last
    /// one's `rung`.
    #[inline(always)]
    pub fn descent(
        &self,
        b: &[T; D],
        tangent: &Tangent<T, D>,
        du: &[T; D],
        longest: T,
        close: bool,
        rung: &mut u8,
    ) -> ([T; D], Weakness<T>) {
        // Higher than the step bound can need.
        const HIGHEST: u8 = 13;
        let on = |rung: u8| self.damped(b, tangent, du, longest, close, rung);
        let (mut d, weakness, mut holds) = on(0);
        if holds {
            return (d, weakness);
        }
        let mut at = (*rung).saturating_sub(2).max(1);
        (d, _, holds) = on(at);
        if holds {
            while at > 1
                && let (lower, _, true) = on(at - 1)
            {
                d = lower;
                at -= 1;
            }
        }
        while !holds && at < HIGHEST {
            at += 1;
            (d, _, holds) = on(at);
        }
        *rung = at;
        (d, weakness)
    }

    /// The Newton step from `du` under the damping of a rung, none at 0 and four times as much on each as
    /// on the last; what the damped tangent has of weak directions, and whether the step leads downhill and no
    /// further than `longest`.
    #[inline(never)]
    fn damped(
        &self,
        b: &[T; D],
        tangent: &Tangent<T, D>,
        du: &[T; D],
        longest: T,
        close: bool,
        rung: u8,
    ) -> ([T; D], Weakness<T>, bool) {
        let mut damping = T::ZERO;
        if rung > 0 {
            damping = T::of(1e-4) * norm(b) / longest;
            for _ in 1..rung {
                damping = damping * T::of(4.0);
            }
        }
        let (factors, definite) = Factors::damped(tangent, damping, T::of(8.0) * T::EPSILON);
        let mut d = factors.solve(b);
        constrain::<T, B, D>(self.c, &[T::ZERO; D], &mut d);
        let mut to = *du;
        for (sum, part) in to.iter_mut().zip(&d) {
            *sum += *part;
        }
        let downhill = definite == Definite::Positive || (close && definite == Definite::No);
        let weakness = Weakness {
            singular: definite == Definite::Semi,
            flexibility: factors.weakest(),
        };
        (d, weakness, downhill && span(&to) <= longest)
    }

    pub fn loaded_balls(&self, speed_load: T) -> u16 {
        let mut count = 0;
        for (ball, at) in self.balls.iter().zip(self.azimuths) {
            let a = shift(&self.state.position.offset, at);
            let pass = M::observe(self.c, speed_load, ball, a);
            count += u16::from(pass.inner.q > T::ZERO);
        }
        count
    }

    /// The carrying ball whose contacts are furthest apart, if those are past opposing each other; or one off
    /// the inner race whose centrifugal force, at the pole of the cage speed, counts beside the load's norm
    /// `size`. Where a ball is lost so far out that its figures are no numbers, the search went astray, and has
    /// diverged with this `residual`.
    pub fn unseated(&self, speed_load: T, size: T, residual: T) -> Option<Status<T>> {
        let least_force = T::of(COUNTS) * T::EPSILON * size;
        let (mut least, mut worst) = (T::ZERO, None);
        for (index, (ball, at)) in (0..).zip(self.balls.iter().zip(self.azimuths)) {
            let a = shift(&self.state.position.offset, at);
            let Pass {
                inner,
                outer,
                loads,
            } = M::observe(self.c, speed_load, ball, a);
            let forces = inner.q + outer.q + loads.centrifugal + loads.friction.abs();
            if !((inner.delta + outer.delta + forces) * self.c.force).is_finite() {
                return Some(Status::Diverged { residual });
            }
            let opposed = dot(inner.normal(), outer.normal());
            let at_pole = outer.q > least_force && opposed < T::of(NEAREST_POLE - 1.0);
            if (inner.q > T::ZERO || at_pole) && opposed < least {
                let across = dot(inner.normal(), outer.tangent());
                let apart = across.abs().atan2(opposed);
                (least, worst) = (opposed, Some(Status::Unseated { ball: index, apart }));
            }
        }
        worst
    }
}
