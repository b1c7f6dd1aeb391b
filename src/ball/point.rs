//! Speed and growth that a row is solved at, and the references of its contacts.

use crate::ball::contact::{Reference, to_grid};
use crate::bearing::{Constants, L0, Squared};
use crate::growth::Growth;
use crate::linalg::{Pair, add, dot, scale, sub};
use crate::real::Real;

/// Speed and growth that a row is solved at, and where its offsets count from, in the units of the constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<T> {
    /// `m dm omega^2 / 2`.
    pub s: T,
    /// Square of a force on a ball that makes no difference to the ring.
    pub negligible: T,
    /// Rounding error of a deformation under the ball's share of the load.
    pub rounding: T,
    /// Lengths `lo` and `li`, growth of the ball included.
    pub lo: T,
    pub li: T,
    pub growth: Growth<T>,
    /// References along the outer and the inner contact, and between the grooves' centres.
    pub outer: Reference<T>,
    pub inner: Reference<T>,
    pub centres: Reference<T>,
    /// From there to the inner groove's centre when the ring is in its reference position.
    pub low: Pair<T>,
}

impl<T: Real> Point<T> {
    /// The point of `s = m dm omega^2 / 2` and a growth, in units of length, for a ring under a load of the size `size`,
    /// without references.
    pub fn new(c: &Constants<T>, s: T, size: T, growth: Growth<T>) -> Self {
        let half = T::of(0.5) * growth.ball;
        Self {
            s,
            negligible: (T::EPSILON * size) * (T::EPSILON * size),
            rounding: T::ROUNDING * (T::ONE + size / c.balls),
            lo: c.lo - half,
            li: c.li - half,
            growth,
            outer: Reference::NONE,
            inner: Reference::NONE,
            centres: Reference::NONE,
            low: [T::ZERO; 2],
        }
    }

    /// [`Point::new`] with the references that there were, the ring's reference position being `axial`. Whether a solution at
    /// the last growth is a start for the next one: it differs by no more than a unit of length, about a deformation.
    pub fn set(&mut self, c: &Constants<T>, s: T, size: T, growth: Growth<T>, axial: T) -> bool {
        let (centres, outer) = (self.centres.vector, self.outer.vector);
        let grown = (growth.axial - self.growth.axial).abs()
            + (growth.radial - self.growth.radial).abs()
            + (growth.ball - self.growth.ball).abs();
        *self = Self::new(c, s, size, growth);
        self.refer(c, axial, centres, outer);
        grown <= T::ONE
    }

    /// Has offsets count from where the ring is displaced by `axial`, and the balls are taut between the grooves' centres.
    pub fn start(&mut self, c: &Constants<T>, axial: T) {
        // Integers hold the square of no longer vectors.
        let far = T::of(1.5 * L0);
        let near = axial.at_most(far).at_least(-far);
        let centres = [c.centre[0] + near, c.centre[1]].map(to_grid);
        let length = dot(centres, centres).at_least(T::ONE).sqrt();
        self.refer(
            c,
            axial,
            centres,
            scale(c.lo / length, centres).map(to_grid),
        );
    }

    /// Has the offset `x` of the balls count from next to where it is; what is left of it.
    pub fn move_outer(&mut self, c: &Constants<T>, x: Pair<T>) -> Pair<T> {
        let was = self.outer.vector;
        self.outer.vector = add(was, x).map(to_grid);
        self.measure(c);
        add(sub(was, self.outer.vector), x)
    }

    #[inline(never)]
    fn refer(&mut self, c: &Constants<T>, axial: T, centres: Pair<T>, outer: Pair<T>) {
        (self.centres.vector, self.outer.vector) = (centres, outer);
        let beyond = sub(c.centre, centres);
        let growth = [self.growth.axial, self.growth.radial];
        self.low = add([beyond[0] + axial, beyond[1]], add(c.centre_low, growth));
        self.measure(c);
    }

    /// Squares of the references' vectors.
    #[inline(never)]
    fn measure(&mut self, c: &Constants<T>) {
        let (centres, outer) = (self.centres.vector, self.outer.vector);
        let half = T::of(0.5) * self.growth.ball;
        self.outer = Reference::at(outer, &c.lo_squared, excess(c.lo, half));
        self.inner = Reference::at(sub(centres, outer), &c.li_squared, excess(c.li, half));
        let l0_squared = Squared {
            whole: (L0 * L0 * 65_536.0) as i32,
            rest: T::ZERO,
        };
        let growth = excess(T::of(L0), self.growth.ball);
        self.centres = Reference::at(centres, &l0_squared, growth);
    }

    /// The balls have inertia that makes a difference.
    #[inline(always)]
    pub fn is_at_speed(&self) -> bool {
        self.s > T::ZERO
    }
}

/// The square of a length, less that of one shorter by `less`.
pub fn excess<T: Real>(length: T, less: T) -> T {
    less * (length + length - less)
}
