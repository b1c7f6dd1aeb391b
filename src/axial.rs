//! One ball at rest under its share of a pure axial load: a spring in closed form.
//!
//! The centres of the grooves are `1 + w^2` apart, `w^2` being the deformation of both contacts, and
//! `A1` along the axis: `A1^2 = sin^2 alpha0 + w^2 (w^2 + 2)`. The force is `w^3`, its axial part
//! `w^3 A1 / (1 + w^2)`, which is convex in `w` but for the smallest loads, so that Newton's method
//! comes down from above.

use crate::contact::Reference;
use crate::float::Real;

/// The ball at one deformation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring<T> {
    root: T,
    /// `A1`
    pub axial: T,
    /// `1 / (1 + w^2)`
    per_length: T,
}

impl<T: Real> Spring<T> {
    /// At the root `w` of the deformation; `s0` is the sine of the free contact angle.
    #[inline(always)]
    pub fn at(s0: T, w: T) -> Self {
        let square = w * w;
        Self {
            root: w,
            axial: (s0 * s0 + square * (square + T::ONE + T::ONE)).sqrt(),
            per_length: T::ONE / (T::ONE + square),
        }
    }

    /// The root of the deformation at the axial displacement `x`; 1, which is above all, if the ball is
    /// not loaded there.
    #[inline(always)]
    pub fn root_at(s0: T, x: T) -> T {
        let stretch = x * (s0 + s0 + x);
        let root = (stretch / (T::ONE + (T::ONE + stretch).sqrt())).sqrt();
        if stretch > T::ZERO { root } else { T::ONE }
    }

    /// Axial force.
    #[inline(always)]
    pub fn force(&self) -> T {
        self.root * self.root * self.root * self.axial * self.per_length
    }

    /// How much less of the root Newton's method wants for the axial force `q`.
    #[inline(always)]
    pub fn step(&self, q: T) -> T {
        // Numerator and denominator times the sine of the contact angle, which saves a division.
        let sine = self.axial * self.per_length;
        let w2 = self.root * self.root;
        let value = (w2 * self.root * sine - q) * sine;
        let square = sine * sine;
        let slope =
            T::of(3.0) * w2 * square + (w2 * w2 + w2 * w2) * (T::ONE - square) * self.per_length;
        value / slope.at_least(T::TINY)
    }

    /// Axial displacement, on the side of the free contact angle or (`reversed`) on the other.
    #[inline(always)]
    pub fn displacement(&self, s0: T, reversed: bool) -> T {
        let both = self.axial + s0;
        if reversed {
            -both
        } else {
            // A difference of squares instead of a difference.
            self.stretch() / both.at_least(T::TINY)
        }
    }

    /// Slope of the axial force by the axial displacement.
    #[inline(always)]
    pub fn stiffness(&self) -> T {
        let sine = self.axial * self.per_length;
        let square = sine * sine;
        let across = self.root * self.root * self.per_length * (T::ONE - square);
        self.root * (T::of(1.5) * square + across)
    }

    /// The inner groove's curvature centre as seen from the outer one's, `c0` being the cosine of the
    /// free contact angle.
    #[inline(always)]
    pub fn centres(&self, c0: T, reversed: bool) -> Reference<T> {
        Reference {
            vector: [if reversed { -self.axial } else { self.axial }, c0],
            excess: self.stretch(),
        }
    }

    /// Square of the centres' distance less that in the unloaded bearing.
    #[inline(always)]
    fn stretch(&self) -> T {
        let square = self.root * self.root;
        square * (square + T::ONE + T::ONE)
    }
}
