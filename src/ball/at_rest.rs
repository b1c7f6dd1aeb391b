//! The balls at rest under a purely axial load, in closed form: one stands for all.
//!
//! The grooves' centres are `A1` apart along the axis and `A2` across. `d` is the deformation of both contacts, and
//! `R = L0 - gD`:
//!
//! `|A|^2 = R^2 + d (2 R + d)`, `F / N = Kn d^(3/2) A1 / |A|`
//!
//! `e = R^2 - A2^2` is `A1^2` where contact begins. Where it is negative,
//! growth or a negative clearance presses the balls before the ring moves. The unknown is the root `w` of the ring's part:
//!
//! `A1^2 = max(e, 0) + w^2`, `d (2 R + d) = max(-e, 0) + w^2`.
//!
//! Neither sum cancels, and the force grows with `w` at first with the power 3, 4 or 1, so that Newton's method from
//! above comes down on the solution.

use crate::ball::contact::{Contact, excess};
use crate::bearing::{Constants, L0};
use crate::growth::Growth;
use crate::real::Real;

/// From the outer to the inner groove's centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Centres<T> {
    /// `A1`.
    pub axial: T,
    /// `|A|^2 - R^2`.
    pub excess: T,
}

/// The balls at rest under a load.
#[derive(Debug, Clone, Copy)]
pub struct Loaded<T> {
    pub root: T,
    pub centres: Centres<T>,
    pub contact: Contact<T>,
    /// The last step was as small as asked for.
    pub small: bool,
    /// Square of the last step over the root's: the error that Newton's method leaves.
    pub left: T,
    pub iterations: u16,
}

/// Figures of the balls at rest that do not change as the ring moves along its axis.
#[derive(Debug, Clone, Copy)]
pub struct AxialRest<T> {
    /// `R` and `Kn`.
    length: T,
    kn: T,
    /// `A2`.
    radial: T,
    /// Positive parts of `e` and of `-e`.
    gap: T,
    preload: T,
    /// `A1` without displacement and growth, and the axial growth `gx`.
    free: T,
    growth: T,
    /// The square of the former, less `e`.
    change: T,
}

impl<T: Real> AxialRest<T> {
    /// With rings and balls that have grown, in units of length.
    #[inline(always)]
    pub fn new(c: &Constants<T>, growth: &Growth<T>) -> Self {
        let [axial, radial] = c.n0.map(|n| T::of(L0) * n);
        let (gx, gr) = (growth.axial, growth.radial);
        let change = excess(T::of(L0), growth.ball) + gr * (radial + radial + gr) - c.play;
        let half = T::of(0.5) * growth.ball;
        let e = axial * axial - change;
        Self {
            length: (c.lo - half) + (c.li - half),
            kn: c.kn,
            radial: radial + gr,
            gap: e.at_least(T::ZERO),
            preload: (-e).at_least(T::ZERO),
            free: axial,
            growth: gx,
            change,
        }
    }

    /// The grooves' centres at a root, on the side of a positive displacement.
    #[inline(always)]
    pub fn centres(&self, root: T) -> Centres<T> {
        let square = root * root;
        Centres {
            axial: (self.gap + square).sqrt_abs(),
            excess: self.preload + square,
        }
    }

    /// The grooves' centres at an axial displacement.
    pub fn centres_at(&self, dx: T) -> Centres<T> {
        let x = dx + self.growth;
        Centres {
            axial: self.free + x,
            excess: x * (self.free + self.free + x) + self.change,
        }
    }

    /// Both contacts in series.
    #[inline(always)]
    pub fn contact(&self, at: &Centres<T>) -> Contact<T> {
        Contact::along([at.axial, self.radial], at.excess, self.length, self.kn)
    }

    /// Newton's method on the root for the axial force `q` of a ball, from the root `from` or from above the solution.
    ///
    /// The last step squared is at most `part` times the root squared, unless `limit` iterations were too few.
    #[inline(always)]
    pub fn root(&self, from: T, q: T, part: T, limit: u16) -> Loaded<T> {
        // There, d exceeds 1 + q / Kn, and the sine of the contact angle 1/3.
        let above = (T::of(8.0 * L0) * (T::ONE + q / self.kn)).sqrt_abs();
        let mut root = from.at_most(above);
        let (mut step, mut iterations) = (root, 0);
        loop {
            let centres = self.centres(root);
            let contact = self.contact(&centres);
            let square = step * step;
            let small = square <= part * (root * root);
            if small || iterations >= limit {
                return Loaded {
                    root,
                    centres,
                    contact,
                    small,
                    left: square / (root * root),
                    iterations,
                };
            }
            let [slope, ..] = contact.tangent();
            let missing = q - contact.q * contact.n[0];
            let next = root + missing * centres.axial / (slope * root);
            let next = next.at_least(T::of(0.1) * root).at_most(above);
            step = next - root;
            root = next;
            iterations += 1;
        }
    }

    /// Axial displacement with the centres on the side of a positive displacement, or (`reversed`) on the other.
    #[inline(always)]
    pub fn displacement(&self, at: &Centres<T>, reversed: bool) -> T {
        let both = at.axial + self.free;
        let moved = if reversed {
            -both
        } else if self.free > T::ZERO {
            // A difference of squares instead of a difference.
            (at.excess - self.change) / both
        } else {
            both
        };
        moved - self.growth
    }

    /// Largest relative error of a displacement `dx` by rounding of what growth adds.
    pub fn rounding(&self, dx: T) -> T {
        // Without a constant in `A1`, the displacement is no small difference of squares.
        let both = self.free.at_least(dx.abs());
        let change = if self.free > T::ZERO {
            self.change.abs() / both
        } else {
            T::ZERO
        };
        let change = change + self.growth.abs();
        T::of(4.0) * T::EPSILON * change / dx.abs().at_least(T::TINY)
    }
}
