//! The speed, and the growth of rings and balls in the solver's units: what a bearing is solved at, besides its load.

use super::constants::{Constants, L0};
use super::contact::rounding;
use super::growth::Growth;
use super::linalg::Pair;
use crate::float::Real;

/// Speed of the shaft.
///
/// ```
/// use spindle_bearing::Speed;
/// let speed = Speed::rpm(20_000.0_f64);
/// assert!((speed.as_rad_per_s() - 2094.395).abs() < 1e-3);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Speed<T>(T);

impl<T: Real> Speed<T> {
    /// At rest.
    pub const REST: Self = Self(T::ZERO);

    /// Revolutions per minute.
    #[inline]
    pub fn rpm(rpm: T) -> Self {
        Self(rpm * T::of(core::f64::consts::PI / 30.0))
    }

    /// Angular speed `omega`, rad/s.
    #[inline]
    pub const fn rad_per_s(omega: T) -> Self {
        Self(omega)
    }

    /// Angular speed `omega`, rad/s.
    #[inline]
    pub const fn as_rad_per_s(self) -> T {
        self.0
    }
}

/// Speed and growth that a row is solved at, in the units of the constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point<T> {
    /// `m dm omega^2 / 2`.
    pub s: T,
    /// Square of a force on a ball that makes no difference to the ring.
    pub negligible: T,
    /// Rounding error of a deformation under the ball's share of the load.
    pub rounding: T,
    /// Lengths `lo` and `li`, growth of the ball included, and what growth adds to `-lo^2`, `-li^2` and `-L0^2`.
    pub lo: T,
    pub li: T,
    pub lo_excess: T,
    pub li_excess: T,
    pub l0_excess: T,
    /// Growth of the inner groove's centre against the outer one's, axial and radial.
    pub growth: Pair<T>,
}

impl<T: Real> Point<T> {
    /// The point of `s = m dm omega^2 / 2` and a growth, in units of length, for a ring under a load of the size `size`.
    pub fn new(c: &Constants<T>, s: T, size: T, growth: &Growth<T>) -> Self {
        let g = growth.ball;
        let half = T::of(0.5) * g;
        let excess = |length: T, less: T| less * (length + length - less);
        Self {
            s,
            negligible: (T::EPSILON * size) * (T::EPSILON * size),
            rounding: rounding::<T>() * (T::ONE + size / c.balls),
            lo: c.lo - half,
            li: c.li - half,
            lo_excess: excess(c.lo, half),
            li_excess: excess(c.li, half),
            l0_excess: excess(T::of(L0), g),
            growth: [growth.axial, growth.radial],
        }
    }

    /// The balls have inertia that makes a difference.
    #[inline(always)]
    pub fn is_at_speed(&self) -> bool {
        self.s > T::ZERO
    }
}
