//! What a solve computes, chosen by types: what a scene does not need is not compiled.
//!
//! [`Static`] is the bearing at rest: every ball is one spring in closed form, without unknowns of
//! its own. [`Centrifugal`] adds the centrifugal force, [`Full`] the gyroscopic moment and the friction
//! that carries it, too; both under a rule for the balls' attitude, which decides the cage speed.
//! `freedoms`, `conditions` and `outputs` are the other choices.

use crate::ball::{Ball, Loads, Pass};
use crate::conditions::Conditions;
use crate::constants::Constants;
use crate::contact::{Contact, Pair, Reference};
use crate::float::Real;
use crate::freedoms::{BallStore, Freedoms};
use crate::kinematics::{Attitude, BallMotion, RacewayControlFree};
use crate::outputs::Outputs;
use crate::solver::{Attempt, Iteration, Outcome, Still, Task};
use crate::turning::Turning;
use core::marker::PhantomData;

pub(crate) mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Static {}
    impl<A> Sealed for super::Centrifugal<A> {}
    impl<A> Sealed for super::Full<A> {}
}

/// Balls that do not turn have no attitude: what [`Static`] has in the place of a rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoAttitude;

/// The bearing at rest. It takes no attitude rule; `A` is there to say so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Static<A = NoAttitude>(PhantomData<A>);

/// The bearing at speed under centrifugal force alone, without gyroscopic moment and friction: good
/// where contact angles are small, and about a tenth cheaper. The rule `A` gives the cage speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Centrifugal<A = RacewayControlFree>(PhantomData<A>);

/// The bearing at speed with all inertia loads: centrifugal force, gyroscopic moment and the friction
/// that carries it; the balls' attitude by the rule `A`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Full<A = RacewayControlFree>(PhantomData<A>);

impl<A: Attitude> Turning for Full<A> {
    type Rule = A;
}

impl<A: Attitude> Turning for Centrifugal<A> {
    type Rule = Frictionless<A>;
}

/// The cage speed of a rule, without its gyroscopic moment.
#[derive(Debug, Clone, Copy)]
pub struct Frictionless<A>(PhantomData<A>);

impl<A: Attitude> crate::kinematics::sealed::Sealed for Frictionless<A> {}
impl<A: Attitude> Attitude for Frictionless<A> {
    const NAME: &'static str = A::NAME;
    const COUPLED: bool = A::COUPLED;
    const FRICTION: bool = false;

    #[inline(always)]
    fn motion<T: Real>(c: &Constants<T>, inner: &Contact<T>, outer: &Contact<T>) -> BallMotion<T> {
        A::motion(c, inner, outer)
    }
}

/// How the balls move: [`Static`], [`Centrifugal`] or [`Full`]. Sealed.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a motion of the balls",
    label = "not a motion",
    note = "a motion is `Static`, `Centrifugal<A>` or `Full<A>`",
    note = "`A` is an attitude rule: `RacewayControlFree`, `OuterRaceControl` or `InnerRaceControl`",
    note = "balls at rest have no attitude, so that `Static` takes no rule"
)]
pub trait Motion: sealed::Sealed + 'static {
    /// What is remembered of a ball.
    #[doc(hidden)]
    type Ball<T: Real>: Copy + core::fmt::Debug + Default + PartialEq;
    /// The shaft turns.
    const AT_SPEED: bool;

    /// Starts as an `attempt` does, and sweeps until converged, or until there were `until` sweeps.
    #[doc(hidden)]
    fn seek<T: Real, B, O, const D: usize>(
        run: &mut Iteration<'_, T, Self, B, O, D>,
        outcome: &mut Outcome<T>,
        task: &Task<T, D>,
        attempt: Attempt,
        until: u16,
    ) where
        Self: Sized,
        Freedoms<D>: BallStore,
        B: Conditions<Freedoms<D>>,
        O: Outputs;
    /// Puts balls that are at rest where their grooves' centres are.
    #[doc(hidden)]
    fn rest<T: Real>(_balls: &mut [Self::Ball<T>], _centres: Reference<T>) {}
    /// State of the ball for reports.
    #[doc(hidden)]
    fn observe<T: Real>(
        c: &Constants<T>,
        speed_load: T,
        ball: &Self::Ball<T>,
        a: Pair<T>,
    ) -> Pass<T>;
}

impl Motion for Static {
    type Ball<T: Real> = Still<T>;
    const AT_SPEED: bool = false;

    #[inline(always)]
    fn seek<T: Real, B, O, const D: usize>(
        run: &mut Iteration<'_, T, Self, B, O, D>,
        outcome: &mut Outcome<T>,
        task: &Task<T, D>,
        attempt: Attempt,
        until: u16,
    ) where
        Freedoms<D>: BallStore,
        B: Conditions<Freedoms<D>>,
        O: Outputs,
    {
        run.equilibrate(outcome, task, attempt, until);
    }

    #[inline(always)]
    fn rest<T: Real>(balls: &mut [Still<T>], centres: Reference<T>) {
        for ball in balls {
            ball.centres = centres;
        }
    }

    #[inline]
    fn observe<T: Real>(c: &Constants<T>, _: T, ball: &Still<T>, a: Pair<T>) -> Pass<T> {
        let k = Contact::at(&ball.centres, a, T::ONE, T::ONE);
        let outer = Contact {
            delta: k.delta * c.outer_share,
            ..k
        };
        let inner = Contact {
            delta: k.delta - outer.delta,
            ..k
        };
        Pass {
            inner,
            outer,
            loads: Loads {
                centrifugal: T::ZERO,
                friction: T::ZERO,
                inner_friction: T::ZERO,
                outer_friction: T::ZERO,
            },
        }
    }
}

impl<S: Turning> Motion for S {
    type Ball<T: Real> = Ball<T>;
    const AT_SPEED: bool = true;

    #[inline(always)]
    fn seek<T: Real, B, O, const D: usize>(
        run: &mut Iteration<'_, T, Self, B, O, D>,
        outcome: &mut Outcome<T>,
        task: &Task<T, D>,
        attempt: Attempt,
        until: u16,
    ) where
        Freedoms<D>: BallStore,
        B: Conditions<Freedoms<D>>,
        O: Outputs,
    {
        run.seek(outcome, task, attempt, until);
    }

    #[inline]
    fn observe<T: Real>(c: &Constants<T>, speed_load: T, ball: &Ball<T>, a: Pair<T>) -> Pass<T> {
        ball.observe::<S::Rule>(c, speed_load, a)
    }
}
