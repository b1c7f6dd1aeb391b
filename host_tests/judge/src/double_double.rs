//! Double-double arithmetic: an unevaluated sum of two f64, about 31 digits.
//!
//! It goes as far as the reference build needs it (Dekker 1971; Hida, Li and Bailey, "Library for double-double arithmetic",
//! 2007).

use core::ops::{Add, Div, Mul, Neg, Sub};

/// The unevaluated sum `hi + lo` with `|lo| <= ulp(hi) / 2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dd {
    pub(crate) hi: f64,
    pub(crate) lo: f64,
}

/// Error-free sum, any order of magnitudes.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let t = s - a;
    (s, (a - (s - t)) + (b - t))
}

/// Error-free sum for `|a| >= |b|`.
fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    (s, b - (s - a))
}

/// Error-free product.
fn two_prod(a: f64, b: f64) -> (f64, f64) {
    let p = a * b;
    (p, a.mul_add(b, -p))
}

impl Dd {
    /// Nought.
    pub const ZERO: Dd = Dd { hi: 0.0, lo: 0.0 };
    /// One.
    pub const ONE: Dd = Dd { hi: 1.0, lo: 0.0 };
    /// Pi, to 31 digits.
    pub const PI: Dd = Dd {
        hi: core::f64::consts::PI,
        lo: 1.224_646_799_147_353_2e-16,
    };

    /// A number that f64 holds.
    pub const fn of(x: f64) -> Dd {
        Dd { hi: x, lo: 0.0 }
    }

    /// `1 / n` for a small whole number.
    const fn over(n: u32) -> Dd {
        let n = n as f64;
        let hi = 1.0 / n;
        // `n hi` is within an ulp of 1, and takes few enough bits for two halves to be exact.
        let top = f64::from_bits(hi.to_bits() & !0x07ff_ffff);
        let rest = (1.0 - n * top) - n * (hi - top);
        Dd { hi, lo: rest / n }
    }

    /// The nearest f64.
    pub fn value(self) -> f64 {
        self.hi + self.lo
    }

    /// Exact scaling: `s` is a power of two.
    pub fn ldexp(self, s: f64) -> Dd {
        Dd {
            hi: self.hi * s,
            lo: self.lo * s,
        }
    }

    /// The f64 root with one Newton step whose residual is formed exactly.
    pub fn sqrt(self) -> Dd {
        if self.hi <= 0.0 {
            return Dd::ZERO;
        }
        let r = self.hi.sqrt();
        let (p, e) = two_prod(r, r);
        let rest = (self - Dd { hi: p, lo: e }).hi;
        let (hi, lo) = quick_two_sum(r, rest / (2.0 * r));
        Dd { hi, lo }
    }

    /// Cube root: Newton from the f64 root.
    pub fn cbrt(self) -> Dd {
        let r = Dd::of(self.hi.cbrt());
        let slope = 3.0 * r.hi * r.hi;
        let rest = self - r * r * r;
        r + Dd::of(rest.value() / slope)
    }

    /// Sine and cosine of `|x| <= pi`: Taylor series of `x / 64`, then six doublings of
    /// `(sin, 1 - cos)`, the pair that does not cancel.
    pub fn sin_cos(self) -> (Dd, Dd) {
        let r = self.ldexp(1.0 / 64.0);
        let r2 = r * r;
        // Terms past `WIDE` weigh less than 1e-16 of the sum, so f64 carries them.
        let (mut s, mut v) = (1.0, 1.0);
        for k in (WIDE + 1..=TERMS).rev() {
            let n = (2 * k) as f64;
            s = 1.0 - r2.hi * s / (n * (n + 1.0));
            v = 1.0 - r2.hi * v / ((n + 1.0) * (n + 2.0));
        }
        let (mut s, mut v) = (Dd::of(s), Dd::of(v));
        for [sine, versine] in TAYLOR.iter().rev() {
            s = Dd::ONE - r2 * s * *sine;
            v = Dd::ONE - r2 * v * *versine;
        }
        let mut s = r * s;
        let mut v = (r2 * v).ldexp(0.5);
        for _ in 0..6 {
            let c = Dd::ONE - v;
            let s2 = (s * s).ldexp(2.0);
            s = (s * c).ldexp(2.0);
            v = s2;
        }
        (s, Dd::ONE - v)
    }
}

/// `(pi / 64)^(2k) / (2k)! < 1e-33` for `k > 8`.
const TERMS: usize = 8;
/// Leading Taylor terms that need all digits.
const WIDE: usize = 4;
/// `1 / (n (n + 1))` and `1 / ((n + 1) (n + 2))` for `n = 2, 4, ...`: what a term adds to the
/// factorials of the sine and of the versine. Quotients would take most of the time.
const TAYLOR: [[Dd; 2]; WIDE] = [
    [Dd::over(6), Dd::over(12)],
    [Dd::over(20), Dd::over(30)],
    [Dd::over(42), Dd::over(56)],
    [Dd::over(72), Dd::over(90)],
];

impl Add for Dd {
    type Output = Dd;
    fn add(self, o: Dd) -> Dd {
        let (s, e) = two_sum(self.hi, o.hi);
        let (t, f) = two_sum(self.lo, o.lo);
        let (s, e) = quick_two_sum(s, e + t);
        let (hi, lo) = quick_two_sum(s, e + f);
        Dd { hi, lo }
    }
}

impl Neg for Dd {
    type Output = Dd;
    fn neg(self) -> Dd {
        Dd {
            hi: -self.hi,
            lo: -self.lo,
        }
    }
}

impl Sub for Dd {
    type Output = Dd;
    fn sub(self, o: Dd) -> Dd {
        self + -o
    }
}

impl Mul for Dd {
    type Output = Dd;
    fn mul(self, o: Dd) -> Dd {
        let (p, e) = two_prod(self.hi, o.hi);
        let (hi, lo) = quick_two_sum(p, e + (self.hi * o.lo + self.lo * o.hi));
        Dd { hi, lo }
    }
}

impl Div for Dd {
    type Output = Dd;
    fn div(self, o: Dd) -> Dd {
        let q1 = self.hi / o.hi;
        let r = self - o * Dd::of(q1);
        let q2 = r.hi / o.hi;
        let r = r - o * Dd::of(q2);
        let (s, e) = quick_two_sum(q1, q2);
        Dd { hi: s, lo: e } + Dd::of(r.hi / o.hi)
    }
}
