//! A ball at rest, in closed form.
//!
//! The grooves' centres and the ball's are collinear. Both contacts in series are one contact between the grooves'
//! centres, `Q = Kn (|A| - L0)^(3/2)`.

use super::body::{Body, Change, Share, change_of, share_of};
use super::constants::Constants;
use super::contact::Contact;
use super::curvature::{Curvature, forms};
use super::kinematics::Rule;
use super::linalg::{Pair, sub, turn};
use super::mounting::Point;
use super::pose::Pose;
use crate::float::Real;

/// What is remembered of a ball at rest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StaticBall<T> {
    /// Offset of the inner groove's centre, where the ball was condensed.
    pub a: Pair<T>,
    n: Pair<T>,
    delta: T,
    slope: T,
    across: T,
    per_r: T,
    share: Share<T>,
}

impl<T: Real> StaticBall<T> {
    /// The contacts in series.
    #[inline(always)]
    pub fn contact(&self, c: &Constants<T>, p: &Point<T>) -> Contact<T> {
        Contact::at(&p.centres, self.a, p.lo + p.li, c.kn)
    }

    /// Its second order, where the ball was condensed.
    #[inline(always)]
    fn curvature(&self) -> Curvature<T> {
        Curvature {
            slope: self.slope,
            across: self.across,
            per_delta: T::ONE / self.delta.at_least(T::NOTHING),
            per_r: self.per_r,
        }
    }
}

impl<T: Real> Body<T> for StaticBall<T> {
    const AT_SPEED: bool = false;

    fn start(&mut self, _: Pair<T>) {}

    fn place<R: Rule>(&mut self, _: &Constants<T>, _: &mut Point<T>) {}

    #[inline(always)]
    fn condense<R: Rule>(
        &mut self,
        c: &Constants<T>,
        p: &Point<T>,
        a: Pair<T>,
        _: T,
        _: &mut u16,
    ) -> bool {
        self.a = a;
        let contact = self.contact(c, p);
        self.share = share_of(&contact);
        (self.n, self.delta) = (contact.n, contact.delta);
        (self.slope, self.across, self.per_r) = (contact.slope, contact.across, contact.per_r);
        true
    }

    #[inline(always)]
    fn change(&self, c: &Constants<T>, p: &Point<T>, da: Pair<T>) -> Change<T> {
        let v = turn(self.n, da);
        change_of(v, self.delta, self.per_r, &self.share, c.kn, p.rounding)
    }

    #[inline(always)]
    fn share(&self) -> &Share<T> {
        &self.share
    }

    #[inline(always)]
    fn stiffening(&self, a: Pair<T>) -> [T; 3] {
        let v = turn(self.n, sub(a, self.a));
        let [s, c] = self.n;
        let m = self.curvature().stiffening(v);
        forms(m, [s, c], [c, -s])
    }

    fn pose<R: Rule>(&self, c: &Constants<T>, p: &Point<T>, a: Pair<T>) -> Pose<T> {
        let ball = Self { a, ..*self };
        Pose::at_rest(c, &ball.contact(c, p))
    }

    fn apart(&self) -> Pair<T> {
        [T::ZERO, T::ONE]
    }
}
