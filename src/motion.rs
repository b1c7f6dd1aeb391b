//! How the balls move, chosen by type.

use super::ball::Ball;
use super::body::{Body, Change, Share};
use super::constants::Constants;
use super::kinematics::{Frictionless, Rule};
use super::linalg::Pair;
use super::mounting::Point;
use super::place;
use super::pose::Pose;
use super::static_ball::StaticBall;
use super::tuning;
use crate::float::Real;
use core::marker::PhantomData;

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
    const AT_SPEED: bool = <Self::Ball<f32> as Body<f32>>::AT_SPEED;
}

/// The bearing at rest: its solvers refuse any speed but [`Speed::REST`](crate::Speed::REST).
///
/// See [`AxialSolver`](crate::AxialSolver) for an example.
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
}

impl<A: Rule> Motion for Centrifugal<A> {
    type Ball<T: Real> = Ball<T>;
    type Rule = Frictionless<A>;
}

impl<A: Rule> Motion for Full<A> {
    type Ball<T: Real> = Ball<T>;
    type Rule = A;
}

/// Steps of placing a ball that its own step costs as much as.
const OWN: u16 = 2;

impl<T: Real> Body<T> for Ball<T> {
    const AT_SPEED: bool = true;

    fn start(&mut self, a: Pair<T>) {
        Ball::start(self, a);
    }

    fn place<R: Rule>(&mut self, c: &Constants<T>, p: &mut Point<T>) {
        let mut left = place::ALONE;
        place::place::<T, R>(self, c, p, &mut left);
        self.x = p.move_outer(c, self.x);
    }

    #[inline(always)]
    fn condense<R: Rule>(
        &mut self,
        c: &Constants<T>,
        p: &Point<T>,
        a: Pair<T>,
        ds: T,
        left: &mut u16,
    ) -> bool {
        self.advance(a, ds);
        if !p.is_at_speed() {
            self.condense_held(c, p);
            return true;
        }
        // Its own Newton step first, where that is likely to do; then it is placed.
        let mut tries = 0;
        loop {
            let balance = self.linearise::<R>(c, p);
            if balance.is_within(tuning::PLACE) || balance.is_below(p.negligible) {
                return true;
            }
            if tries == 2 || *left == 0 {
                return false;
            }
            if tries == 0 {
                self.advance(a, T::ZERO);
                *left = left.saturating_sub(OWN);
            } else {
                place::place::<T, R>(self, c, p, left);
            }
            tries += 1;
        }
    }

    #[inline(always)]
    fn share(&self) -> &Share<T> {
        &self.share
    }

    #[inline(always)]
    fn change(&self, c: &Constants<T>, p: &Point<T>, da: Pair<T>) -> Change<T> {
        self.change_by(c, p, da)
    }

    #[inline(always)]
    fn stiffening(&self, a: Pair<T>) -> [T; 3] {
        Ball::stiffening(self, a)
    }

    // In line, so that whoever looks at a ball has what it looks at in registers.
    #[inline(always)]
    fn pose<R: Rule>(&self, c: &Constants<T>, p: &Point<T>, a: Pair<T>) -> Pose<T> {
        if p.is_at_speed() {
            self.pose_for::<R>(c, p, a)
        } else {
            Pose::at_rest(c, &Self::in_series(c, p, a))
        }
    }

    fn apart(&self) -> Pair<T> {
        [self.local.sd, self.local.cd]
    }
}
