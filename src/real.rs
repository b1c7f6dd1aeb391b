//! The one float trait: the solver's needs of `f32` and `f64`, and nothing else.

use crate::bearing::{Bearing, mix};
use crate::design::{Design, DesignError};
use core::fmt::{Debug, Display, LowerExp};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use core::str::FromStr;

/// `defmt::Format` where the feature is on, nothing where it is off.
#[cfg(feature = "defmt")]
pub trait Print: defmt::Format {}
#[cfg(feature = "defmt")]
impl<T: defmt::Format> Print for T {}
/// `defmt::Format` where the feature is on, nothing where it is off.
#[cfg(not(feature = "defmt"))]
pub trait Print {}
#[cfg(not(feature = "defmt"))]
impl<T> Print for T {}

/// The working precision: `f32` or `f64`. Sealed, and without a method: `use spindle_bearing::*` adds none to numbers.
pub trait Real: Float + Send + Sync {}

impl Real for f32 {}
impl Real for f64 {}

/// Arithmetic of the working precision.
///
/// Everything that depends on the hardware is behind this trait. Sums and products are never fused,
/// so that a host and a target give the same bits.
pub trait Float:
    Copy
    + Debug
    + Display
    + LowerExp
    + FromStr
    + Into<f64>
    + Default
    + Print
    + PartialEq
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + 'static
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Distance from 1 to the next number.
    const EPSILON: Self;
    /// Rounding error of a deformation, in the solver's unit of length: ten operations on numbers near 1.
    const ROUNDING: Self;
    /// Smallest normal number.
    const TINY: Self;
    /// One over [`Float::TINY`].
    const HUGE: Self;
    /// Larger than all numbers.
    const INFINITY: Self;
    /// Default of [`Settings::tolerance`](crate::Settings::tolerance).
    const TOLERANCE: Self;
    /// Tolerance of [`Settings::TICK`](crate::Settings::TICK).
    const TICK: Self;
    /// One revolution per minute, rad/s.
    const RPM: Self;
    /// Constants of [`Limits`](crate::Limits).
    const STATIC_PRESSURE: Self;
    const FATIGUE_PRESSURE: Self;
    const LUBRICATED_FRICTION: Self;
    /// Added and subtracted again, it rounds to multiples of 1/256.
    const GRID: Self;
    /// Deformation of an inner contact that is next to nothing, in the solver's unit of length.
    ///
    /// So small that it makes no difference, and not so small that products of its powers vanish.
    const NOTHING: Self;
    /// Deformation of an outer contact that is next to nothing.
    const LEAST: Self;

    /// Rounds to an integer; saturates.
    fn to_i32(self) -> i32;
    /// Rounds an integer to this precision.
    fn from_i32(i: i32) -> Self;
    /// Rounds a double to this precision. Only ever called with constants, so that no double
    /// arithmetic is left in the code of a single-precision solver.
    fn of(x: f64) -> Self;
    /// Takes a measured number.
    fn from_f32(x: f32) -> Self;
    /// Rounds to single precision (for reports).
    fn to_f32(self) -> f32;
    /// Widens to a double (for reports and errors).
    fn to_f64(self) -> f64;
    /// Square root of the magnitude; the hardware's own where there is one.
    fn sqrt_abs(self) -> Self;
    /// Cube root of a normal positive number; 0 of anything smaller.
    fn cbrt_or_zero(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Angle of the vector `(x, self)`, rad.
    fn atan2(self, x: Self) -> Self;
    /// Power of a positive number.
    fn powf(self, exponent: Self) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// The fingerprint of a bearing or spindle with this number mixed into it.
    fn mix(self, fingerprint: u32) -> u32;

    /// This number, or `other` if that is larger; an `if`, which is half the price of `fmaxf`.
    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        if other > self { other } else { self }
    }

    /// This number, or `other` if that is smaller.
    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// A bearing of so many balls in this precision.
    fn bearing<const N: usize>(
        design: &Design,
        balls: usize,
    ) -> Result<Bearing<Self, N>, DesignError>;
}

impl<T: Real, const N: usize> Bearing<T, N> {
    /// [`Bearing::new`] for code that is generic over the precision; no `const fn`.
    ///
    /// # Errors
    ///
    /// The first quantity of the design that is out of its range.
    pub fn of(design: &Design) -> Result<Self, DesignError> {
        T::bearing(design, N)
    }

    /// A bearing of so many balls, at most `N`: for programs that learn the number when they run.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design};
    ///
    /// let design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// assert!(Bearing::<f64, 20>::with_balls(&design, 15).is_ok());
    /// let error = Bearing::<f64, 20>::with_balls(&design, 21);
    /// assert_eq!(error.map_err(|error| error.most), Err(20.0));
    /// ```
    ///
    /// # Errors
    ///
    /// The first quantity that is out of its range.
    pub fn with_balls(design: &Design, balls: usize) -> Result<Self, DesignError> {
        T::bearing(design, balls)
    }
}

macro_rules! real {
    ($t:ident, $tolerance:expr, $sqrt:path, $third:expr, $halley:expr, $atan2:path, $pow:path, $grid:expr, $nothing:expr, $least:expr) => {
        impl Float for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = $t::EPSILON;
            const ROUNDING: Self = 10.0 * $t::EPSILON;
            const TINY: Self = $t::MIN_POSITIVE;
            const HUGE: Self = 1.0 / $t::MIN_POSITIVE;
            const INFINITY: Self = $t::INFINITY;
            const TOLERANCE: Self = $tolerance;
            const TICK: Self = 1e-3;
            const RPM: Self = (core::f64::consts::PI / 30.0) as $t;
            const STATIC_PRESSURE: Self = 4.2e9;
            const FATIGUE_PRESSURE: Self = 1.5e9;
            const LUBRICATED_FRICTION: Self = 0.06;
            const GRID: Self = $grid;
            const NOTHING: Self = $nothing;
            const LEAST: Self = $least;
            #[inline(always)]
            fn to_i32(self) -> i32 {
                self as i32
            }
            #[inline(always)]
            fn from_i32(i: i32) -> Self {
                i as $t
            }
            #[inline(always)]
            fn of(x: f64) -> Self {
                x as $t
            }
            #[inline(always)]
            fn from_f32(x: f32) -> Self {
                x as $t
            }
            #[inline(always)]
            fn to_f32(self) -> f32 {
                self as f32
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn sqrt_abs(self) -> Self {
                $sqrt(self)
            }
            #[inline(never)]
            fn cbrt_or_zero(self) -> Self {
                if !(self >= Self::TINY) {
                    return 0.0;
                }
                // A third of the exponent is good to 4 %; each step of Halley's cubes the error.
                let mut y = Self::from_bits(self.to_bits() / 3 + $third);
                for _ in 0..$halley {
                    let cube = y * y * y;
                    y = y * (cube + self + self) / (cube + cube + self);
                }
                y
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $t::abs(self)
            }
            #[inline]
            fn atan2(self, x: Self) -> Self {
                $atan2(self, x)
            }
            #[inline]
            fn powf(self, exponent: Self) -> Self {
                $pow(self, exponent)
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }
            #[inline]
            fn mix(self, fingerprint: u32) -> u32 {
                mix(fingerprint, self.to_bits().into())
            }
            fn bearing<const N: usize>(
                design: &Design,
                balls: usize,
            ) -> Result<Bearing<Self, N>, DesignError> {
                Bearing::<$t, N>::made(design, balls)
            }
        }
    };
}

/// Cube root of a normal positive single; 0 of anything smaller.
#[inline(always)]
pub fn cbrt_f32(x: f32) -> f32 {
    x.cbrt_or_zero()
}

// 1.5 * 2^(mantissa bits - n) rounds to multiples of 2^-n: n = 8 and 9, 8 and 26.
real!(
    f32,
    2e-5,
    crate::sqrt::sqrt_f32,
    0x2a51_37a0,
    2,
    libm::atan2f,
    libm::powf,
    49152.0,
    1e-10,
    1e-6
);
real!(
    f64,
    3e-13,
    crate::sqrt::sqrt_f64,
    0x2a9f_7893_782d_a1ce,
    3,
    libm::atan2,
    libm::pow,
    26_388_279_066_624.0,
    1e-30,
    1e-20
);
