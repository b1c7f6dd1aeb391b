//! How a search goes: where it starts, when the next start is worth more, when it ends, and how good the answer
//! is.
//!
//! An answer certifies itself. The last step changes the stiffness by an amount that is known ball by ball, and
//! the stiffness is corrected for it. What the correction does not know is the error of the stiffness: a part of
//! the change that grows with the step, with the share of inertia in the ball's forces, and with the part of the
//! step that rounding may have made. Displacements and forces are one Newton step further, where the change
//! enters as a factor. What rounding leaves comes on top: a displacement in the direction in which the ring gives
//! way most, and what that changes of the stiffness of contacts that carry little.

use super::ErrorEstimate;
use super::thresholds::{self, LONGEST_STEP};
use crate::contact::Pair;
use crate::float::Real;
use crate::ring::Tangent;
use crate::status::Status;

/// Where a solve starts, in the order in which starts are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attempt {
    /// From the last solution.
    Warm,
    /// From the axisymmetric state.
    Cold,
    /// From the solution at a standstill. Where inertia is next to nothing, balls that carry nothing else are
    /// caught between the races by forces so small that any step of the ring throws them out: the ring had better
    /// have found its place before.
    Standstill,
    /// From the axisymmetric state with more preload.
    Preloaded,
}

impl Attempt {
    pub const AT_SPEED: &[Self] = &[Self::Warm, Self::Cold, Self::Standstill, Self::Preloaded];
    pub const AT_REST: &[Self] = &[Self::Warm, Self::Cold, Self::Preloaded];

    /// Sweeps after which the next start is worth more than going on. From a start that is any good
    /// most solves take fewer than 10.
    pub const fn sweeps(self) -> u16 {
        match self {
            Self::Warm => 10,
            Self::Cold | Self::Standstill => 40,
            Self::Preloaded => u16::MAX,
        }
    }

    /// Preload of a start from nothing, in units of what keeps balls loaded at first sight.
    pub const fn preload(self) -> f64 {
        match self {
            Self::Warm | Self::Cold | Self::Standstill => 1.0,
            Self::Preloaded => 4.0,
        }
    }

    /// Whether a start from nothing may have the ring face a radial load.
    pub const fn faces(self) -> bool {
        match self {
            Self::Warm | Self::Cold | Self::Standstill => true,
            Self::Preloaded => false,
        }
    }

    /// Length of the first step at most, in units of `L0`; it grows while steps succeed. Where the first
    /// start led nowhere, short steps keep balls on the branch of the equilibrium on which both races hold
    /// them.
    const fn first_step(self) -> f64 {
        match self {
            Self::Warm | Self::Cold | Self::Standstill => LONGEST_STEP,
            Self::Preloaded => 0.06,
        }
    }
}

/// What rounding leaves, relative to the load: of the balance at most, and of it what makes steps. Balls round
/// their forces, which are centrifugal ones where the load is light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rounding<T> {
    pub balance: T,
    pub step: T,
}

impl<T: Real> Rounding<T> {
    #[inline(always)]
    pub fn of(speed_load: T, size: T) -> Self {
        let inertia = T::of(2.0) * speed_load / size.at_least(T::TINY);
        Self {
            balance: T::EPSILON * (T::of(256.0) + inertia),
            step: T::EPSILON * (T::of(4.0) + inertia),
        }
    }
}

/// How a start has gone so far, and what that means for the next sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course<T> {
    /// Longest step of the ring.
    pub radius: T,
    /// Balls hand over their laws.
    pub laws: bool,
    last_residual: T,
    /// The last step led nowhere.
    stuck: bool,
    /// Sweeps in a row without progress of the stiffness.
    stalled: u8,
    /// Sweeps in a row in which a ball was lost.
    lost: u8,
    /// What rounding may leave unknown of the stiffness.
    unknown: T,
    /// Of the last damping.
    pub rung: u8,
}

impl<T: Real> Course<T> {
    #[inline(always)]
    pub fn new(attempt: Attempt) -> Self {
        Self {
            radius: T::of(attempt.first_step()),
            laws: attempt != Attempt::Warm,
            last_residual: T::ONE / T::EPSILON,
            stuck: false,
            stalled: 0,
            lost: 0,
            unknown: T::of(thresholds::UNKNOWN),
            rung: 0,
        }
    }

    /// Judges what the last `step` led to: a residual, which is `enough` for an answer. Returns whether another
    /// sweep is sure to follow if there may be one, since no answer can be the tangent that this one leaves.
    #[inline(always)]
    pub fn judge(&mut self, residual: T, step: T, enough: T) -> bool {
        let last = self.last_residual;
        // Where rounding made the step, a ball made the balance worse; and under so small a bound any step would
        // pass for the last one.
        let moved = step > T::of(thresholds::ROUNDED_STEP) * T::EPSILON;
        if moved && residual > T::ONE.at_least(last + last) {
            self.radius = T::of(0.5) * step;
        } else if residual < T::of(thresholds::WENT_WELL) * last {
            self.radius = T::of(LONGEST_STEP).at_most(self.radius.at_least(step + step));
        }
        self.stuck = residual > T::of(thresholds::LED_NOWHERE) * last;
        self.last_residual = residual;
        !self.laws && residual > enough && residual < T::of(thresholds::GOES_ON.0) * last
    }

    /// Compares the change of the stiffness with the last one, of a sweep that was `balanced` as far as rounding
    /// allows. There, steps go to and fro as rounding has it, and with them the stiffness of contacts that carry
    /// next to nothing: to wait for one that happens to change little takes dozens of sweeps, and says nothing of
    /// the answer.
    #[inline(always)]
    pub fn compare(&mut self, change: T, last: T, balanced: bool) {
        if balanced {
            self.unknown = self.unknown * T::of(thresholds::UNKNOWN_GROWS);
        }
        self.stalled = if change > T::of(thresholds::NO_PROGRESS) * last {
            self.stalled.saturating_add(1)
        } else {
            0
        };
    }

    /// Whether the start leads nowhere: a ball that its own steps do not bring back is lost, and the start
    /// with it, unless it is the last one.
    #[inline(always)]
    pub fn is_hopeless(&mut self, imbalance: T, attempt: Attempt) -> bool {
        self.lost = if imbalance >= T::ONE {
            self.lost.saturating_add(1)
        } else {
            0
        };
        self.lost >= thresholds::LOST && attempt != Attempt::Preloaded
    }
}

/// How a tangent resists where it does so least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weakness<T> {
    /// A direction is undetermined.
    pub singular: bool,
    /// Flexibility along the direction of the smallest pivot.
    pub flexibility: T,
}

impl<T: Real> Weakness<T> {
    /// Nothing gives way.
    pub const NONE: Self = Self {
        singular: false,
        flexibility: T::ZERO,
    };
}

/// How sweeps ended.
pub struct Outcome<T> {
    pub status: Status<T>,
    pub sweeps: u16,
    pub repeats: u16,
    pub residual: T,
    /// Relative change of the stiffness by the last step, what of that the corrected tangent does not know,
    /// and the step's length.
    pub change: T,
    pub remainder: T,
    pub step: T,
    /// The balls' hardening in the last step, as in [`Change`].
    pub hardening: T,
    /// How far the worst ball was from its own equilibrium before that step.
    pub imbalance: T,
    /// Last sweeps in a row whose tangent left a direction undetermined.
    pub singular: u8,
    /// How far the ring gives way where it is weakest to a unit of load, as the last step saw it.
    pub weakest: T,
    /// The same to what rounding leaves of the balance.
    pub slack: T,
    /// What rounding may hide of the balance where it ends a solve, relative to the load.
    pub unknown: T,
}

impl<T: Real> Outcome<T> {
    pub fn new() -> Self {
        Self {
            status: Status::SweepLimit,
            sweeps: 0,
            repeats: 0,
            residual: T::ONE,
            change: T::ONE,
            remainder: T::ONE,
            step: T::ONE,
            hardening: T::ZERO,
            imbalance: T::ONE,
            singular: 0,
            weakest: T::ZERO,
            slack: T::ZERO,
            unknown: T::EPSILON,
        }
    }

    /// Notes how the tangent resists where it does so least.
    #[inline(always)]
    pub fn weaken(&mut self, weakness: &Weakness<T>) {
        self.weakest = weakness.flexibility;
        self.singular = if weakness.singular {
            self.singular.saturating_add(1)
        } else {
            0
        };
    }

    /// Whether every ball is as near to its own equilibrium as the tolerance wants: its step leaves the
    /// square of its imbalance.
    #[inline(always)]
    fn is_settled(&self, tolerance: T) -> bool {
        self.imbalance * self.imbalance <= T::of(0.1) * tolerance.at_least(T::EPSILON)
    }

    /// Whether the last step is so short that linearisations hold.
    #[inline(always)]
    fn is_short(&self) -> bool {
        self.step <= T::of(thresholds::SHORT_STEP)
    }

    /// How a solve ends with the last sweep, if the forces are in balance and it does. `rounded_part` is the
    /// part of the step that rounding may have made, `largest` the largest displacement.
    #[inline(always)]
    pub fn ending(
        &self,
        course: &Course<T>,
        rounding: &Rounding<T>,
        rounded_part: T,
        tolerance: T,
        largest: T,
    ) -> Option<Status<T>> {
        let singular = self.singular > 0;
        let ten = T::of(10.0);
        let near = self.change <= ten * tolerance;
        let settled = self.is_settled(tolerance);
        // The corrected tangent is better than the change. Forces are good to the change's square,
        // displacements to the change times the step.
        let corrected = !singular
            && T::of(4.0) * self.remainder <= tolerance
            && ten * self.change * self.change <= tolerance
            && ten * self.change * self.step <= tolerance * largest;
        let converged = settled && (corrected || self.change <= tolerance);
        // Under light loads deformations have few digits, and the balance tells that it is as good as
        // rounding allows.
        let rounded = self.residual <= rounding.balance && self.remainder < course.unknown;
        // Rounding ends the solve where the change no longer shrinks, or near the tolerance where it has
        // made most of the step; a pause of one sweep far from the tolerance is not that yet.
        let exhausted = (self.change <= T::EPSILON.sqrt() || rounded)
            && self.imbalance < T::of(thresholds::AT_ODDS)
            && (course.stalled >= if near && settled { 1 } else { 3 }
                || (near && settled && rounded_part > T::of(0.5)))
            && self.sweeps > 1;
        // A ring that rocks on two balls does not stiffen them, which says nothing of where it comes to rest.
        if !(self.is_short() || singular) {
            return None;
        }
        if converged {
            Some(Status::Converged)
        } else {
            exhausted.then_some(Status::PrecisionLimit)
        }
    }

    /// Whether the next sweep takes the balls' laws. Short steps need none, unless they lead nowhere: a ball
    /// about to open is not linear. A bearing that gives way in some direction can be in balance and yet far
    /// from the solution.
    #[inline(always)]
    pub fn needs_laws(&self, course: &Course<T>, tolerance: T) -> bool {
        self.residual > T::of(thresholds::NEEDS_LAWS)
            || !self.is_short()
            || (course.stuck && !self.is_settled(tolerance))
    }

    /// Errors of a solution whose largest displacement is `largest`; `inertia` is about the share that inertia
    /// has in the balls' forces. The numbers are regressions on the campaign's cases, of single and double
    /// precision together: quantiles of 99.9 % of the error's logarithm.
    pub fn error(&self, largest: T, inertia: T, growth: T) -> ErrorEstimate<T> {
        // Rounding of what the solver works out, and of the bearing's constants, which are worked out in
        // doubles: at speed there are more of them.
        let rounding = |own: f64, constants: f64, at_speed: f64| {
            T::EPSILON * T::of(own)
                + T::of(constants * f64::EPSILON)
                + T::of(at_speed * f64::EPSILON) * inertia
        };
        // Where the ring gives way to what rounding leaves of the balance, deformations go with it, and
        // with them the stiffness of contacts that carry little.
        let gives = self.slack * growth;
        // Where that moves the ring by a hundredth of its way, or contacts by many deformations, or a step that
        // rounding stops changes the stiffness by a hundredth, nothing is known of the displacement.
        let per_largest = T::ONE / largest.at_least(T::TINY);
        let slack = self.slack * per_largest;
        let unknown = T::of(1e4);
        // What a Newton step leaves is of second order.
        let own = self.imbalance * self.imbalance;
        let squared = self.change * self.change;
        let step = self.step * per_largest;
        let (displacement, force, stiffness) = match self.status {
            // The change is summed over the balls, and an element sees some of them only.
            Status::Converged => (
                T::of(4.0) * self.change * step,
                T::of(0.4) * self.remainder + T::of(4.0) * squared + T::of(5e-3) * gives,
                T::of(3.6) * self.remainder + T::of(0.22) * self.change,
            ),
            // Steps that rounding stops can be a small part of the way, and change the stiffness on it.
            _ => (
                T::of(32.0) * step + unknown * squared,
                self.change + self.residual + T::of(4.0) * self.slack + T::of(5e-4) * gives,
                T::of(12.0) * self.remainder + T::of(2.0) * self.change,
            ),
        };
        ErrorEstimate {
            displacement: rounding(3.0, 27.0, 98.0)
                + T::of(3.7) * slack
                + unknown * slack * slack
                + T::of(2e-3) * gives * gives
                + displacement,
            force: rounding(10.0, 12.0, 360.0) + T::of(6.0) * own + force,
            stiffness: rounding(2.4, 33.0, 370.0)
                + T::of(0.022) * gives
                + T::of(300.0) * own
                + stiffness,
        }
    }
}

/// Relative change of the stiffness by a unit of deformation at the inner contacts, from the balls' hardening
/// as in [`Change`].
#[inline(always)]
pub fn growth<T: Real, const D: usize>(hardening: T, tangent: &Tangent<T, D>) -> T {
    if D < 3 {
        return T::ZERO;
    }
    // Balls' stiffnesses along their contacts add up to this.
    let sum = tangent[0][0] + tangent[1][1] + tangent[2][2];
    let growth = T::of(1.0 / 3.0) * hardening / sum.at_least(T::TINY);
    growth.at_most(T::ONE / T::EPSILON)
}

/// A change of stiffness, axial and radial and summed over the balls, relative to the tangent.
#[inline(always)]
pub fn relative<T: Real, const D: usize>(change: &Pair<T>, tangent: &Tangent<T, D>) -> T {
    let mut part = change[0] / tangent[0][0].at_least(T::TINY);
    if D >= 3 {
        let radial = tangent[1][1].at_most(tangent[2][2]);
        part = part.at_least(change[1] / radial.at_least(T::TINY));
    }
    // Not all that a step changes is summed: on the campaign's cases, half as much again makes the tolerance
    // hold.
    if part.is_finite() {
        T::of(1.5) * part
    } else {
        T::ONE
    }
}
