//! Deformation and force of a contact, without the cancellation of `|X| - lo`.
//!
//! A vector along a contact is a reference, whose square is known exactly, plus a small offset:
//! `|X|^2 - lo^2 = e + (2 Xr + x).x`, and `delta = (|X|^2 - lo^2) / (|X| + lo)`. Single precision keeps six digits of
//! the deformation where the plain difference of lengths keeps three.

use crate::bearing::{Constants, L0, Squared};
use crate::growth::Growth;
use crate::linalg::{Pair, add, dot, scale, sub};
use crate::real::Real;

/// Reference of the vector along a contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reference<T> {
    /// Multiples of 1/256.
    pub vector: Pair<T>,
    /// Its squared length less the square of the undeformed contact's length.
    pub excess: T,
}

impl<T: Real> Reference<T> {
    /// None yet.
    pub const NONE: Self = Self {
        vector: [T::ZERO; 2],
        excess: T::ZERO,
    };

    /// Exact but for one rounding: the square is an integer in units of 2^-16. `growth` is what growth adds.
    #[inline(always)]
    pub fn at(vector: Pair<T>, undeformed: &Squared<T>, growth: T) -> Self {
        let [a, r] = vector.map(|x| (x * T::of(256.0)).to_i32());
        let square = a.wrapping_mul(a).wrapping_add(r.wrapping_mul(r));
        let leading = T::from_i32(square.wrapping_sub(undeformed.whole));
        Self {
            vector,
            excess: leading * T::of(1.0 / 65_536.0) - undeformed.rest + growth,
        }
    }
}

/// `x` rounded to a multiple of 1/256.
#[inline(always)]
pub fn to_grid<T: Real>(x: T) -> T {
    (x + T::GRID) - T::GRID
}

/// A contact, or two in series.
#[derive(Debug, Clone, Copy)]
pub struct Contact<T> {
    /// Sine and cosine of the contact angle.
    pub n: Pair<T>,
    /// Deformation; negative across a gap.
    pub delta: T,
    /// Root of the deformation, 0 across a gap.
    pub root: T,
    /// Force, 0 across a gap, its slope by the deformation, and its quotient by the distance of the centres.
    pub q: T,
    pub slope: T,
    pub across: T,
    /// One over the distance of the centres.
    pub per_r: T,
}

impl<T: Real> Contact<T> {
    /// The contact of undeformed length `length` and load-deflection constant `k`, at `offset` from its reference.
    #[inline(always)]
    pub fn at(reference: &Reference<T>, offset: Pair<T>, length: T, k: T) -> Self {
        let v = add(reference.vector, offset);
        let excess = reference.excess + dot(add(v, reference.vector), offset);
        Self::along(v, excess, length, k)
    }

    /// The contact along the vector `v`, whose squared length exceeds the undeformed contact's by `excess`.
    #[inline(always)]
    pub fn along(v: Pair<T>, excess: T, length: T, k: T) -> Self {
        let r = dot(v, v).at_least(T::TINY).sqrt_abs();
        let both = r + length;
        let inverse = T::ONE / (r * both);
        let (delta, per_r) = (inverse * r * excess, inverse * both);
        let depth = delta.at_least(T::ZERO);
        let root = depth.sqrt_abs();
        let stiffness = k * root;
        let q = stiffness * depth;
        Self {
            n: scale(per_r, v),
            delta,
            root,
            q,
            slope: T::of(1.5) * stiffness,
            across: q * per_r,
            per_r,
        }
    }

    /// Slope of the force vector by the motion of its end, axial and radial: elements `aa`, `ar`, `rr`.
    #[inline(always)]
    pub fn tangent(&self) -> [T; 3] {
        let [s, c] = self.n;
        let beyond = self.slope - self.across;
        let (bs, bc) = (beyond * s, beyond * c);
        [self.across + bs * s, bs * c, self.across + bc * c]
    }
}

/// Factors of the second-order terms of one contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Curvature<T> {
    /// `Q'`, `Q/R`, `1/delta` and `1/R`.
    pub slope: T,
    pub across: T,
    pub per_delta: T,
    pub per_r: T,
}

impl<T: Real> Curvature<T> {
    /// Change of the tangent along a motion of the contact's end by `v`, along and across it:
    /// `[[Q' v1/(2 delta), 2 g v2], [2 g v2, 2 g v1]]` with `g = (Q' - Q/R) / (2 R)`. The stiffness grows with the root of the
    /// deformation.
    #[inline(always)]
    pub fn stiffness_change(&self, v: Pair<T>) -> [T; 3] {
        let relative = v[0] * self.per_delta;
        let g2 = (self.slope - self.across) * self.per_r;
        let growth = if relative.abs() < T::of(0.1) {
            relative * (T::of(0.5) - relative * (T::of(0.125) - T::of(0.0625) * relative))
        } else {
            (T::ONE + relative).at_least(T::ZERO).sqrt_abs() - T::ONE
        };
        [self.slope * growth, g2 * v[1], g2 * v[0]]
    }
}

/// The symmetric matrix `m` of elements along, mixed and across, as a form of two vectors: `a.m a`, `a.m b`, `b.m b`.
#[inline(always)]
pub fn forms<T: Real>(m: [T; 3], a: Pair<T>, b: Pair<T>) -> [T; 3] {
    let (ma, mb) = (
        [m[0] * a[0] + m[1] * a[1], m[1] * a[0] + m[2] * a[1]],
        [m[0] * b[0] + m[1] * b[1], m[1] * b[0] + m[2] * b[1]],
    );
    [dot(ma, a), dot(ma, b), dot(mb, b)]
}

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
    /// Before the first solve.
    pub const NONE: Self = Self {
        s: T::ZERO,
        negligible: T::ZERO,
        rounding: T::ZERO,
        lo: T::ZERO,
        li: T::ZERO,
        growth: Growth::NONE,
        outer: Reference::NONE,
        inner: Reference::NONE,
        centres: Reference::NONE,
        low: [T::ZERO; 2],
    };

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
            ..Self::NONE
        }
    }

    /// [`Point::new`] with the references that there were, the ring's reference position being `axial`. Change of the growth.
    pub fn set(&mut self, c: &Constants<T>, s: T, size: T, growth: Growth<T>, axial: T) -> T {
        let (centres, outer) = (self.centres.vector, self.outer.vector);
        let grown = (growth.axial - self.growth.axial).abs()
            + (growth.radial - self.growth.radial).abs()
            + (growth.ball - self.growth.ball).abs();
        *self = Self::new(c, s, size, growth);
        self.refer(c, axial, centres, outer);
        grown
    }

    /// Has offsets count from where the ring is displaced by `axial`, and the balls are taut between the grooves' centres.
    pub fn start(&mut self, c: &Constants<T>, axial: T) {
        // Integers hold the square of no longer vectors.
        let far = T::of(1.5 * L0);
        let near = axial.at_most(far).at_least(-far);
        let centres = [c.centre[0] + near, c.centre[1]].map(to_grid);
        let length = dot(centres, centres).at_least(T::ONE).sqrt_abs();
        self.refer(
            c,
            axial,
            centres,
            scale(c.lo / length, centres).map(to_grid),
        );
    }

    /// Moves the outer reference next to the offset `x` of the balls; their offset from there.
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
