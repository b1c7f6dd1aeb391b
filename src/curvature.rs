//! Second-order terms of a ball's contacts, which its linearisation leaves out along a motion.
//!
//! A contact's end moves by `v`, along and across it. The tangent changes by
//! `[[Q' v1/(2 delta), 2 g v2], [2 g v2, 2 g v1]]` with `g = (Q' - Q/R) / (2 R)`.

use super::linalg::{Pair, dot};
use crate::float::Real;

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
    /// Change of the tangent. The stiffness grows with the root of the deformation.
    #[inline(always)]
    pub fn stiffening(&self, v: Pair<T>) -> [T; 3] {
        let relative = v[0] * self.per_delta;
        let g2 = (self.slope - self.across) * self.per_r;
        let growth = if relative.abs() < T::of(0.1) {
            relative * (T::of(0.5) - relative * (T::of(0.125) - T::of(0.0625) * relative))
        } else {
            (T::ONE + relative).at_least(T::ZERO).sqrt() - T::ONE
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
