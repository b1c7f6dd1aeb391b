//! The search at speed, where every ball has an equilibrium of its own.
//!
//! Each sweep linearises every ball, which eliminates its own unknowns, and sums what the balls hand to the ring.
//! Far from the solution the ring then looks for the load's balance among the balls' laws (the `spring` module),
//! which agree with the linearisation in value and slope; near it, and after a warm start, it makes Newton's
//! step. The tangent of the last sweep, corrected to first order by what that step changes of both contacts'
//! stiffness and direction, is the stiffness. Where rounding ends a solve, that step can be too long for the
//! correction of a contact about to open, and another sweep takes the tangent after it.
//!
//! - The ring's own iteration works on the sum of the balls' laws, each of which is the derivative of a convex
//!   potential. A step is the solution of a system whose matrix is made positive definite where it is not
//!   (Levenberg 1944), hence a descent direction, and is halved until the slope along it has not turned over by
//!   more than half: such an iteration cannot be trapped short of the minimum. It costs no linearisation of a
//!   ball. Halvings are four at most, so that a direction softer by orders of magnitude can still send it round
//!   in a circle; the next start is for that, and the balance of forces at the end tells.
//! - Inertia loads change with the step; a step that made the balance worse bounds the next one to half of its
//!   length, unless rounding made it: then a ball did.
//! - A ball whose force changes by more than a factor is placed anew by what holds it, and a ball that is badly
//!   off by itself repeats its own Newton step a few times within the sweep.
//!
//! A warm solve starts where the last solution's tangent, its sensitivity to speed and the second-order part of
//! both (contacts stiffen, lines of centres turn) see it under the new load and speed; one from nothing at the
//! axisymmetric state, or where the ring faces a load that is nearly radial.

use super::course::{Attempt, Course, Outcome, Rounding, Weakness, relative};
use super::iteration::{Given, Iteration, Task};
use super::thresholds;
use crate::ball::{Ball, Share};
use crate::conditions::{Conditions, held, hold};
use crate::constants::Azimuth;
use crate::contact::{add, scale};
use crate::float::Real;
use crate::freedoms::{BallStore, Freedoms};
use crate::outputs::Outputs;
use crate::ring::{
    self, Change, Position, Sums, Tangent, TangentSums, curvature_centre, dot5, norm, shift, side,
    span,
};
use crate::status::Status;
use crate::turning::{Drive, Turning, free_ball};

/// Copies a ball. As a function by itself, since the compiler then knows that these are two, and copies
/// memory straight away; one after the other, since it would copy many of them field by field.
#[inline(never)]
fn copy<B: Copy>(from: &B, to: &mut B) {
    *to = *from;
}

impl<T: Real, M: Turning, B, O, const D: usize> Iteration<'_, T, M, B, O, D>
where
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// Starts as an `attempt` does, and sweeps until converged, or until there were as many sweeps as the
    /// attempt is worth, and `until` at most.
    #[inline(always)]
    pub fn seek(
        &mut self,
        outcome: &mut Outcome<T>,
        task: &Task<T, D>,
        attempt: Attempt,
        until: u16,
    ) {
        let Task {
            given,
            wanted,
            speed_load,
            ..
        } = task;
        let worth = outcome.sweeps.saturating_add(attempt.sweeps());
        match (given, attempt) {
            (Given::Displacement(u), _) => {
                self.place(u, *speed_load);
                return self.run(outcome, task, attempt, until);
            }
            (Given::Load(load), Attempt::Warm) => self.predict(load, wanted, *speed_load),
            // Each with its constant in line, which leaves warm solves more registers.
            (Given::Load(load), Attempt::Cold) => {
                self.start(load, wanted, *speed_load, Attempt::Cold);
            }
            (Given::Load(load), Attempt::Preloaded) => {
                self.start(load, wanted, *speed_load, Attempt::Preloaded);
            }
            (Given::Load(load), Attempt::Standstill) => {
                let still = Task {
                    speed_load: T::ZERO,
                    tolerance: T::of(thresholds::STANDSTILL),
                    ..*task
                };
                self.start(load, wanted, T::ZERO, Attempt::Standstill);
                self.run(outcome, &still, attempt, worth.min(until) - 1);
                // Balls that have dropped out there take their places in the first sweep of what follows.
                return self.run(outcome, task, attempt, worth.min(until));
            }
        }
        self.run(outcome, task, attempt, worth.min(until));
    }

    /// Sweeps until converged, or until there were `until` of them.
    fn run(&mut self, outcome: &mut Outcome<T>, task: &Task<T, D>, attempt: Attempt, until: u16) {
        let Task {
            given,
            speed_load,
            tolerance,
            ..
        } = *task;
        let given = &given;
        let applied = match given {
            Given::Load(load) => norm(load),
            Given::Displacement(_) => T::ZERO,
        };
        let mut size = applied;
        let drive = Drive {
            speed_load,
            negligible: T::EPSILON * size,
        };
        let rounding = Rounding::of(speed_load, size);
        let mut course = Course::new(attempt);
        outcome.status = Status::SweepLimit;
        // Nothing to compare the first sweep with.
        (outcome.change, outcome.step) = (T::ONE, T::ZERO);
        let mut ended = false;
        loop {
            let (repeats, imbalance) = self.sweep(&drive, course.laws);
            outcome.sweeps += 1;
            outcome.repeats = outcome.repeats.saturating_add(repeats);
            if ended {
                return;
            }
            if B::HOLDS {
                size = size.at_least(norm(&self.state.force)).at_least(T::TINY);
            }

            let (mut du, mut weakness, mut far) = ([T::ZERO; D], Weakness::NONE, false);
            let follows = outcome.sweeps < until;
            if let Given::Load(load) = given {
                let mut b = *load;
                for (b, force) in b.iter_mut().zip(&self.state.force) {
                    *b -= *force;
                }
                let (none, mut own) = ([T::ZERO; D], [[T::ZERO; D]; D]);
                let mut tangent =
                    held::<T, B, D>(self.c, &none, &mut b, &self.state.tangent, &mut own);
                // Balls next to their own equilibrium have laws that agree with the linearisation here.
                if course.laws && imbalance > T::of(thresholds::AT_ODDS) {
                    self.unbalanced(load, &none, &mut b, &mut own);
                    tangent = &own;
                }
                outcome.residual = norm(&b) / size;
                if !course.laws && outcome.residual > T::of(thresholds::MISSES_LAWS) && follows {
                    course.laws = true;
                    continue;
                }
                let enough = rounding
                    .balance
                    .at_least(T::of(thresholds::GOES_ON.1) * tolerance);
                far = course.judge(outcome.residual, outcome.step, enough) && follows;
                (du, weakness) = if course.laws {
                    let tangent = *tangent;
                    self.step(load, b, tangent, course.radius, &mut course.rung)
                } else {
                    self.descent(&b, tangent, &du, course.radius, true, &mut course.rung)
                };
                if !course.laws && span(&du) > T::of(thresholds::SHORT_STEP) && follows {
                    course.laws = true;
                    continue;
                }
            } else {
                outcome.residual = T::ZERO;
            }
            outcome.weaken(&weakness);
            // The part of the step that rounding may have made.
            let unbalanced = match given {
                Given::Load(_) => outcome.residual,
                Given::Displacement(_) => imbalance,
            };
            let rounded_part = rounding.step / unbalanced.at_least(rounding.step);
            let moved = if course.laws {
                self.follow(&drive, &du)
            } else {
                // As far as rounding made the step, the states before and after it are equally good.
                self.advance(&du, (!far).then_some(T::ONE - T::of(0.5) * rounded_part))
            };
            outcome.step = span(&du);
            outcome.imbalance = imbalance;
            if !(outcome.step + outcome.residual).is_finite() {
                outcome.status = Status::Diverged {
                    residual: outcome.residual,
                };
                return;
            }
            let last = outcome.change;
            (outcome.change, outcome.remainder) = (T::ONE, T::ONE);
            if !far {
                outcome.change = relative(&moved.stiffness, &self.state.tangent);
                outcome.remainder =
                    relative(&moved.remainder, &self.state.tangent) + outcome.change * rounded_part;
            }
            outcome.hardening = moved.hardening;
            course.compare(outcome.change, last, outcome.residual <= rounding.balance);
            // Progress of held scenes is measured by the largest forces seen; what is left must be small beside
            // the forces as they are.
            let scale = if B::HOLDS {
                applied.at_least(norm(&self.state.force))
            } else {
                size
            };
            let balanced = outcome.residual * size <= T::of(thresholds::BALANCED) * scale;
            let largest = span(&self.state.position.total());
            let ending = outcome.ending(&course, &rounding, rounded_part, tolerance, largest);
            if let (true, Some(status)) = (balanced, ending) {
                // The forces, too, are those after the step.
                for (force, row) in self.state.force.iter_mut().zip(&self.state.tangent) {
                    *force += dot5(row, &du);
                }
                outcome.status = if weakness.singular {
                    Status::Indeterminate {
                        loaded_balls: self.loaded_balls(speed_load),
                    }
                } else {
                    status
                };
                // A step that is all rounding leads nowhere better.
                let real = outcome.residual > T::of(thresholds::ALL_ROUNDING) * rounding.step;
                ended = outcome.status == Status::PrecisionLimit && real && follows;
                if !ended {
                    return;
                }
                // The next sweep leaves nothing to correct.
                outcome.remainder = T::ZERO;
            } else if !follows || course.is_hopeless(imbalance, attempt) {
                return;
            }
            course.laws = !ended && outcome.needs_laws(&course, tolerance);
            // Offsets this large would cost digits of the deformations.
            let far = T::of(thresholds::FAR_FROM_REFERENCE);
            if span(&self.state.position.offset) > far || !(moved.step <= far) || repeats > 0 {
                self.rebase();
            }
        }
    }

    /// Linearises all balls at the present position; returns how many steps of their own they made, and
    /// the largest imbalance that is left.
    fn sweep(&mut self, drive: &Drive<T>, laws: bool) -> (u16, T) {
        let mut sums = Sums::about(self.state.mean);
        let mut total: u16 = 0;
        let mut worst = T::ZERO;
        let mut share = Share::NONE;
        let mut known = false;
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let a = shift(&self.state.position.offset, at);
            if !known {
                let (imbalance, repeats);
                (share, imbalance, repeats) = M::settled::<T, D>(
                    self.c,
                    drive,
                    ball,
                    a,
                    (T::of(0.01), thresholds::OWN_STEPS),
                    laws,
                    Some(thresholds::STEPS_ANEW),
                );
                worst = worst.at_least(imbalance);
                total = total.saturating_add(repeats);
            }
            sums.add(at, &share, false);
            known = self.alike;
        }
        if let (true, [first, others @ ..]) = (self.alike, &mut *self.balls) {
            for other in others {
                copy(first, other);
            }
        }
        self.alike = false;
        self.state.force = sums.force();
        self.state.mean = sums.mean(ring::sharing::<T, D>(self.c));
        self.state.tangent = sums.tangent(false);
        (total, worst)
    }

    /// Moves the ring by `du` and every ball with it, by its linearisation, and, where no sweep is sure to
    /// follow, the tangent with them: by `correction` of what the step changes of it.
    fn advance(&mut self, du: &[T; D], correction: Option<T>) -> Change<T> {
        let mut all = Change::<T>::default();
        let mut sums = TangentSums::<T, D>::new();
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let da = shift(du, at);
            if correction.is_some() {
                let more = M::stiffening(self.c, ball, da);
                let sizes = [more.tangent[0].abs(), more.tangent[2].abs()];
                all.stiffness = add(all.stiffness, sizes);
                all.remainder = add(all.remainder, scale(more.unknown, sizes));
                all.hardening += more.hardening;
                if O::STIFFNESS {
                    sums.add(at, &more.tangent);
                }
            }
            all.step = all.step.at_least(M::advance(ball, da));
        }
        if let (true, Some(part)) = (O::STIFFNESS, correction) {
            for (row, more) in self.state.tangent.iter_mut().zip(&sums.tangent()) {
                for (element, more) in row.iter_mut().zip(more) {
                    *element += part * *more;
                }
            }
        }
        for (offset, step) in self.state.position.offset.iter_mut().zip(du) {
            *offset += *step;
        }
        all
    }

    /// Moves the ring by `du` and every ball with it, by its law.
    fn follow(&mut self, drive: &Drive<T>, du: &[T; D]) -> Change<T> {
        let mut all = Change::<T>::default();
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let a = shift(&self.state.position.offset, at);
            all.merge(M::follow(self.c, drive, ball, a, shift(du, at)));
        }
        for (offset, step) in self.state.position.offset.iter_mut().zip(du) {
            *offset += *step;
        }
        all
    }

    /// Moves all references next to the present position.
    fn rebase(&mut self) {
        self.state.position.rebase();
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let (coarse, fine) = curvature_centre(self.c, &self.state.position.reference, at);
            M::rebase(self.c, ball, coarse, fine);
        }
    }

    /// Puts the ring at `u`, and every ball where it belongs without further knowledge.
    fn place(&mut self, u: &[T; D], speed_load: T) {
        self.state.position = Position {
            reference: [T::ZERO; D],
            offset: *u,
        };
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let a = shift(u, at);
            *ball = Ball::<T>::default();
            let centre = [self.c.n0[0].high + a[0], self.c.n0[1].high + a[1]];
            M::place(self.c, speed_load, ball, centre);
        }
        self.rebase();
    }

    /// A start from nothing: the axisymmetric state at speed in which balls are pressed as at rest. Where freedoms
    /// are held, these start where they are `wanted`, and every ball where it belongs without further knowledge; so
    /// does a ring that faces its load.
    fn start(&mut self, load: &[T; D], wanted: &[T; D], speed_load: T, attempt: Attempt) {
        let c = self.c;
        if let Some(u) = self.facing(load, attempt) {
            self.state.mean = [T::ZERO; 2];
            return self.place(&u, speed_load);
        }
        let (q, x) = self.pressed(load, T::of(attempt.preload()));
        let (sign, balls) = (side(load), ring::sharing::<T, D>(c));
        if B::HOLDS {
            self.state.mean = [T::ZERO; 2];
            return self.place(&self.displaced(x, wanted), speed_load);
        }

        // One ball stands for all.
        let drive = Drive {
            speed_load,
            negligible: T::EPSILON * q * balls,
        };
        let mut position = Position::UNLOADED;
        position.offset[0] = x;
        position.rebase();
        let top = Azimuth {
            cos: T::ONE,
            sin: T::ZERO,
            cos_low: T::ZERO,
            sin_low: T::ZERO,
        };
        let (coarse, fine) = curvature_centre(c, &position.reference, &top);
        let mut ball = Ball::<T>::default();
        let mut offset = position.offset[0];
        let centre = [coarse[0] + fine[0] + offset, coarse[1] + fine[1]];
        M::place(c, speed_load, &mut ball, centre);
        M::rebase(c, &mut ball, coarse, fine);
        // The ball alone on the outer race, just touched by the inner one, bounds the
        // equilibrium from the one side, the ball at rest from the other.
        let (free, _) = free_ball(c, speed_load, centre);
        let reach = c.inner * c.inner - (centre[1] - free) * (centre[1] - free);
        let touch = sign * reach.at_least(T::ZERO).sqrt() - coarse[0] - fine[0];
        let (mut low, mut high) = if sign > T::ZERO {
            (touch, offset)
        } else {
            (offset, touch)
        };
        let bracket = low < high && reach > T::ZERO;
        for _ in 0..20 {
            let centre = [coarse[0] + fine[0] + offset, coarse[1] + fine[1]];
            M::place(c, speed_load, &mut ball, centre);
            let (share, _, _) = M::settled::<T, D>(
                c,
                &drive,
                &mut ball,
                [offset, T::ZERO],
                (T::of(0.02), 5),
                false,
                None,
            );
            self.state.mean = [share.force[1], share.force[0] - share.couple];
            let b = sign * q - share.force[0];
            if b.abs() < T::of(0.1) * q {
                break;
            }
            if b > T::ZERO {
                low = offset;
            } else {
                high = offset;
            }
            let step = b / share.stiffness[0][0].at_least(T::of(1e-6));
            let mut new = offset + step.at_most(T::of(0.2)).at_least(T::of(-0.2));
            if bracket && !(new > low && new < high) {
                new = T::of(0.5) * (low + high);
            }
            offset = new;
        }
        position.offset[0] = offset;
        position.rebase();
        let (coarse, fine) = curvature_centre(c, &position.reference, &top);
        M::rebase(c, &mut ball, coarse, fine);
        self.state.position = position;
        // The others follow in the first sweep.
        if let Some(first) = self.balls.first_mut() {
            copy(&ball, first);
        }
        self.alike = true;
    }

    /// Moves a solved bearing to where its last linearisation, and what of the second order matters,
    /// see it under a new load at a new speed.
    fn predict(&mut self, load: &[T; D], wanted: &[T; D], speed_load: T) {
        let faster = if self.state.speed_load > T::ZERO {
            speed_load / self.state.speed_load - T::ONE
        } else {
            T::ZERO
        };
        let mut sums = [T::ZERO; D];
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let share = M::accelerate(ball, faster);
            ring::spread(&mut sums, at, share.force, share.couple);
        }
        let mut b = *load;
        for i in 0..D {
            b[i] -= self.state.load[i] + sums[i];
        }
        let du = self.extrapolation(b, wanted, |c, ball, da| M::second_order(c, ball, da));
        self.advance(&du, None);
    }

    /// What the balls' laws see after a step `du`: load less their forces, put in `b`, and the tangent there.
    fn unbalanced(
        &mut self,
        load: &[T; D],
        du: &[T; D],
        b: &mut [T; D],
        tangent: &mut Tangent<T, D>,
    ) {
        let mut beyond = Sums::about([T::ZERO; 2]);
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let a = shift(&self.state.position.offset, at);
            let (force, stiffness) = M::beyond(ball, a, shift(du, at));
            beyond.add(
                at,
                &Share {
                    force,
                    stiffness,
                    ..Share::NONE
                },
                false,
            );
        }
        let force = beyond.force();
        *tangent = beyond.tangent(false);
        for i in 0..D {
            b[i] = load[i] - (self.state.force[i] + force[i]);
            for j in 0..D {
                let linear = self.state.tangent[i][j];
                b[i] -= linear * du[j];
                tangent[i][j] += linear;
            }
        }
        hold::<T, B, D>(self.c, &[T::ZERO; D], b, tangent);
    }

    /// The step of the ring to where the balls' laws balance the load, no longer than `longest`, from
    /// the unbalanced load `b` and the tangent before it; and how that tangent resists where it does so
    /// least. By itself, so that sweeps of warm solves have the registers.
    #[inline(never)]
    fn step(
        &mut self,
        load: &[T; D],
        mut b: [T; D],
        mut tangent: Tangent<T, D>,
        longest: T,
        rung: &mut u8,
    ) -> ([T; D], Weakness<T>) {
        let first = norm(&b);
        let small = T::of(thresholds::LINEAR) * norm(load);
        let mut du = [T::ZERO; D];
        let mut weakness = Weakness::NONE;
        for pass in 0..thresholds::LAWS_STEPS {
            let (d, of_pass) = self.descent(&b, &tangent, &du, longest, first <= small, rung);
            if pass == 0 {
                weakness = of_pass;
            }
            if first <= small {
                // The laws are linear over so short a step.
                return (d, weakness);
            }
            let slope = dot5(&b, &d);
            let (from, mut fraction) = (du, T::ONE);
            loop {
                for ((to, from), part) in du.iter_mut().zip(&from).zip(&d) {
                    *to = *from + fraction * *part;
                }
                self.unbalanced(load, &du, &mut b, &mut tangent);
                if dot5(&b, &d) >= T::of(-0.5) * slope || fraction < T::of(0.1) {
                    break;
                }
                fraction = fraction * T::of(0.5);
            }
            if !(norm(&b) > T::of(thresholds::LAWS_LEAVE) * first) {
                break;
            }
        }
        (du, weakness)
    }
}
