//! How the balls move, chosen by type, and what every motion hands to the ring.

use super::ball::Ball;
use super::constants::Constants;
use super::kinematics::{Frictionless, Rule};
use super::linalg::{Matrix2, Pair};
use super::place::place;
use super::pose::Pose;
use super::ring::Row;
use super::solver::{Outcome, State, Task, at_rest, cold_at_speed};
use super::static_ball::StaticBall;
use super::tuning;
use crate::float::Real;
use core::fmt::Debug;
use core::marker::PhantomData;

/// Speed and growth that a row is solved at, in the units of the constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<T> {
    /// `m dm omega^2 / 2`.
    pub s: T,
    /// Square of a force on a ball that makes no difference to the ring.
    pub negligible: T,
    /// What the balls are taken for.
    pub regime: Regime,
    /// Lengths `lo` and `li`, growth of the ball included, and what growth adds to `-lo^2`, `-li^2` and `-L0^2`.
    pub lo: T,
    pub li: T,
    pub lo_excess: T,
    pub li_excess: T,
    pub l0_excess: T,
    /// Growth of the inner groove's centre against the outer one's, axial and radial.
    pub growth: Pair<T>,
}

/// What the balls are taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regime {
    /// At rest: both contacts in series.
    Rest,
    /// In equilibrium with their inertia.
    Speed,
    /// Held where centrifugal force alone presses them on the outer race.
    Outer,
}

impl<T: Real> Point<T> {
    /// Without growth.
    pub fn cold(c: &Constants<T>, s: T) -> Self {
        Self {
            s,
            negligible: T::ZERO,
            regime: if s > T::ZERO {
                Regime::Speed
            } else {
                Regime::Rest
            },
            lo: c.lo,
            li: c.li,
            lo_excess: T::ZERO,
            li_excess: T::ZERO,
            l0_excess: T::ZERO,
            growth: [T::ZERO; 2],
        }
    }

    /// The same at another regime.
    pub fn with(self, regime: Regime) -> Self {
        Self { regime, ..self }
    }
}

/// What a condensed ball hands to the ring.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Share<T> {
    /// Axial and radial force, and moment over `Rp`.
    pub force: Pair<T>,
    pub moment: T,
    /// Their slopes by the groove's centre.
    pub h: Matrix2<T>,
    pub hm: Pair<T>,
    /// Their slopes by the relative change of `omega^2`.
    pub force_by_speed: Pair<T>,
    pub moment_by_speed: T,
}

impl<T: Real> Share<T> {
    /// No ball.
    pub const NONE: Self = Self {
        force: [T::ZERO; 2],
        moment: T::ZERO,
        h: [[T::ZERO; 2]; 2],
        hm: [T::ZERO; 2],
        force_by_speed: [T::ZERO; 2],
        moment_by_speed: T::ZERO,
    };

    /// Magnitudes of the elements `aa`, `ar`, `rr` of the stiffness.
    #[inline(always)]
    pub fn magnitudes(&self) -> [T; 3] {
        [self.h[0][0].abs(), self.h[0][1].abs(), self.h[1][1].abs()]
    }
}

/// How a step changes a ball's contacts.
#[derive(Debug, Clone, Copy)]
pub struct Change<T> {
    /// Relative change of the stiffness by the deformations, and the turn of the normals, rad.
    pub depth: T,
    pub turn: T,
    /// Magnitudes of the elements `aa`, `ar`, `rr` of the ball's stiffness.
    pub h: [T; 3],
    /// Cosine of the angle between the contacts of a ball that carries; else 1.
    pub cos: T,
    /// What the step leaves of the force on a ball without inner contact, of second order.
    pub off: T,
}

/// A ball, as the ring sees it.
pub trait Body<T: Real>: Copy + Debug + Default + PartialEq {
    /// Inertia may drive it out of its groove.
    const AT_SPEED: bool;

    /// Puts the centre of a ball without history at `x`, from the outer groove's centre.
    fn start_at(&mut self, x: Pair<T>);

    /// Follows the groove's centre to `a` and a relative change `ds` of `omega^2`.
    fn follow(&mut self, a: Pair<T>, ds: T);

    /// Moves references next to where the ball is.
    ///
    /// The ring's reference position has the inner groove's centre at `high + low`; the present one is at `a` from there.
    fn anchor(&mut self, c: &Constants<T>, p: &Point<T>, high: Pair<T>, low: Pair<T>, a: Pair<T>);

    /// Follows the groove's centre to `a` and a relative change `ds` of `omega^2`, and condenses the ball there; whether it
    /// is near its balance.
    fn condense<R: Rule>(&mut self, c: &Constants<T>, p: &Point<T>, a: Pair<T>, ds: T) -> bool;

    /// What it hands to the ring where it was condensed.
    fn share(&self) -> &Share<T>;

    /// Adds the second order of the ball's motion to `a` and of `ds` to its step; returns the force that this adds.
    fn bend(&mut self, a: Pair<T>, ds: T) -> Pair<T>;

    /// Change of the stiffness along the motion to `a`: elements `aa`, `ar`, `rr`.
    fn stiffening(&self, a: Pair<T>) -> [T; 3];

    /// The ball when the groove's centre is at `a`.
    fn pose<R: Rule>(&self, c: &Constants<T>, p: &Point<T>, a: Pair<T>) -> Pose<T>;

    /// The inner contact carries.
    fn carries(&self) -> bool;

    /// Sine and cosine of the angle `ai - ao` between the contacts.
    fn apart(&self) -> Pair<T>;

    /// How the contacts change if the groove's centre moves by `da` and the ball follows.
    fn change(&self, c: &Constants<T>, da: Pair<T>) -> Change<T>;
}

/// How the balls move: [`Static`], [`Centrifugal`] or [`Full`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a motion of the balls",
    label = "not a motion",
    note = "a motion is `Static`, `Centrifugal<A>` or `Full<A>`, with an attitude rule `A`"
)]
pub trait Motion: 'static {
    /// What is remembered of a ball.
    type Ball<T: Real>: Body<T>;
    /// The rule of their attitude.
    type Rule: Rule;
    /// The shaft turns.
    const AT_SPEED: bool;

    /// Solves without a solution nearby.
    #[doc(hidden)]
    fn cold<T: Real, const D: usize>(
        state: &mut State<T, D>,
        row: &mut Row<'_, T, Self::Ball<T>>,
        task: &Task<T, D>,
        p: &Point<T>,
        budget: &mut u16,
    ) -> Outcome<T>;
}

/// The bearing at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Static;

/// The bearing at speed under centrifugal force alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Centrifugal<A = crate::kinematics::RacewayControlFree>(PhantomData<A>);

/// The bearing at speed with all inertia loads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Full<A = crate::kinematics::RacewayControlFree>(PhantomData<A>);

impl Motion for Static {
    type Ball<T: Real> = StaticBall<T>;
    type Rule = crate::kinematics::OuterRaceControl;
    const AT_SPEED: bool = false;

    fn cold<T: Real, const D: usize>(
        state: &mut State<T, D>,
        row: &mut Row<'_, T, Self::Ball<T>>,
        task: &Task<T, D>,
        p: &Point<T>,
        budget: &mut u16,
    ) -> Outcome<T> {
        at_rest::<T, _, Self::Rule, D>(state, row, task, p, budget)
    }
}

impl<A: Rule> Motion for Centrifugal<A> {
    type Ball<T: Real> = Ball<T>;
    type Rule = Frictionless<A>;
    const AT_SPEED: bool = true;

    fn cold<T: Real, const D: usize>(
        state: &mut State<T, D>,
        row: &mut Row<'_, T, Self::Ball<T>>,
        task: &Task<T, D>,
        p: &Point<T>,
        budget: &mut u16,
    ) -> Outcome<T> {
        cold_at_speed::<T, Self::Rule, D>(state, row, task, p, budget)
    }
}

impl<A: Rule> Motion for Full<A> {
    type Ball<T: Real> = Ball<T>;
    type Rule = A;
    const AT_SPEED: bool = true;

    fn cold<T: Real, const D: usize>(
        state: &mut State<T, D>,
        row: &mut Row<'_, T, Self::Ball<T>>,
        task: &Task<T, D>,
        p: &Point<T>,
        budget: &mut u16,
    ) -> Outcome<T> {
        cold_at_speed::<T, Self::Rule, D>(state, row, task, p, budget)
    }
}

impl<T: Real> Body<T> for Ball<T> {
    const AT_SPEED: bool = true;

    fn start_at(&mut self, x: Pair<T>) {
        self.outer.vector = [T::ZERO; 2];
        self.x = x;
        self.hold();
    }

    fn follow(&mut self, a: Pair<T>, ds: T) {
        self.advance(a, ds);
        self.z = [T::ZERO; 2];
        self.xs = [T::ZERO; 2];
    }

    fn anchor(&mut self, c: &Constants<T>, p: &Point<T>, high: Pair<T>, low: Pair<T>, a: Pair<T>) {
        self.move_references(c, p, high, low);
        self.a = a;
    }

    #[inline(always)]
    fn condense<R: Rule>(&mut self, c: &Constants<T>, p: &Point<T>, a: Pair<T>, ds: T) -> bool {
        self.advance(a, ds);
        if p.regime != Regime::Speed {
            self.condense_held(c, p);
            return true;
        }
        // Its own Newton step first, where that is likely to do; then it is placed, twice at most.
        let mut tries = 0;
        loop {
            let balance = self.linearise::<R>(c, p);
            if balance.is_within(tuning::PLACE) || balance.is_below(p.negligible) {
                return true;
            }
            if tries == 2 {
                return false;
            }
            if tries == 0 {
                self.advance(a, T::ZERO);
            } else {
                place::<T, R>(self, c, p);
            }
            tries += 1;
        }
    }

    #[inline(always)]
    fn share(&self) -> &Share<T> {
        &self.share
    }

    #[inline(always)]
    fn change(&self, c: &Constants<T>, da: Pair<T>) -> Change<T> {
        self.change_by(c, da)
    }

    #[inline(always)]
    fn bend(&mut self, a: Pair<T>, ds: T) -> Pair<T> {
        Ball::bend(self, a, ds)
    }

    #[inline(always)]
    fn stiffening(&self, a: Pair<T>) -> [T; 3] {
        Ball::stiffening(self, a)
    }

    fn pose<R: Rule>(&self, c: &Constants<T>, p: &Point<T>, a: Pair<T>) -> Pose<T> {
        let mut ball = *self;
        ball.advance(a, T::ZERO);
        match p.regime {
            Regime::Rest => Pose::at_rest(c, &ball.only_contact(c, p)),
            _ => Pose::at_speed::<R>(&ball, c, p),
        }
    }

    fn carries(&self) -> bool {
        self.local.delta > T::ZERO
    }

    fn apart(&self) -> Pair<T> {
        [self.local.sd, self.local.cd]
    }
}
