//! Number types of the textbook formulas, and dual numbers for exact derivatives.

use crate::double_double::Dd;
use core::array::from_fn;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// Number type of the textbook formulas.
pub(crate) trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A constant.
    fn of(x: Dd) -> Self;
    /// The value, rounded.
    fn value(self) -> f64;
    /// Square root of a number that is not negative.
    fn sqrt(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
}

impl Scalar for f64 {
    fn of(x: Dd) -> f64 {
        x.value()
    }
    fn value(self) -> f64 {
        self
    }
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    fn sin_cos(self) -> (f64, f64) {
        f64::sin_cos(self)
    }
}

impl Scalar for Dd {
    fn of(x: Dd) -> Dd {
        x
    }
    fn value(self) -> f64 {
        Dd::value(self)
    }
    fn sqrt(self) -> Dd {
        Dd::sqrt(self)
    }
    fn sin_cos(self) -> (Dd, Dd) {
        Dd::sin_cos(self)
    }
}

/// Value and derivatives with respect to the four unknowns of a ball.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dual {
    pub(crate) v: f64,
    pub(crate) d: [f64; 4],
}

impl Dual {
    pub(super) fn unknown(v: f64, k: usize) -> Dual {
        let mut d = [0.0; 4];
        d[k] = 1.0;
        Dual { v, d }
    }
    fn chain(self, v: f64, slope: f64) -> Dual {
        Dual {
            v,
            d: self.d.map(|d| slope * d),
        }
    }
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, o: Dual) -> Dual {
        Dual {
            v: self.v + o.v,
            d: from_fn(|k| self.d[k] + o.d[k]),
        }
    }
}
impl Sub for Dual {
    type Output = Dual;
    fn sub(self, o: Dual) -> Dual {
        Dual {
            v: self.v - o.v,
            d: from_fn(|k| self.d[k] - o.d[k]),
        }
    }
}
#[expect(
    clippy::suspicious_arithmetic_impl,
    reason = "the product rule is a sum"
)]
impl Mul for Dual {
    type Output = Dual;
    fn mul(self, o: Dual) -> Dual {
        Dual {
            v: self.v * o.v,
            d: from_fn(|k| self.d[k] * o.v + self.v * o.d[k]),
        }
    }
}
impl Div for Dual {
    type Output = Dual;
    fn div(self, o: Dual) -> Dual {
        let r = 1.0 / o.v;
        let q = self.v * r;
        Dual {
            v: q,
            d: from_fn(|k| (self.d[k] - q * o.d[k]) * r),
        }
    }
}
impl Neg for Dual {
    type Output = Dual;
    fn neg(self) -> Dual {
        self.chain(-self.v, -1.0)
    }
}
impl Scalar for Dual {
    fn of(x: Dd) -> Dual {
        Dual {
            v: x.value(),
            d: [0.0; 4],
        }
    }
    fn value(self) -> f64 {
        self.v
    }
    fn sqrt(self) -> Dual {
        let r = self.v.sqrt();
        self.chain(r, 0.5 / r)
    }
    fn sin_cos(self) -> (Dual, Dual) {
        let (s, c) = self.v.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }
}
