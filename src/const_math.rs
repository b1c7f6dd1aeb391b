//! Elementary functions that the compiler can evaluate.
//!
//! A design is turned into solver constants by `const fn`s, so that firmware carries numbers and
//! not the code that made them. `core` has no such functions for `const` yet. Those in `f64` are good to
//! about one unit in the last place, and give the same bits at compile time and at run time.

/// Square root of a finite, non-negative number, by Newton's method.
///
/// The first guess halves the exponent, with an error below 4 %. Three steps would do; two more cost nothing here.
pub(crate) const fn sqrt(x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let mut y = f64::from_bits((x.to_bits() >> 1) + 0x1ff7_a3be_a91d_9b1b);
    let mut i = 0;
    while i < 5 {
        y = 0.5 * (y + x / y);
        i += 1;
    }
    y
}

macro_rules! exact_sqrt {
    ($name:ident, $t:ident, $bits:ident, $wide:ident) => {
        /// Square root of a number's magnitude, correctly rounded by integers: the hardware's own bits.
        pub(crate) const fn $name(x: $t) -> $t {
            const FRACTION: u32 = $t::MANTISSA_DIGITS - 1;
            const BIAS: u32 = $t::MAX_EXP as u32 - 1;
            const UP: $t = (1_u64 << 60) as $t;
            const DOWN: $t = 1.0 / (1_u64 << 30) as $t;
            let x = x.abs();
            if !(x > 0.0 && x.is_finite()) {
                return x;
            }
            if x < $t::MIN_POSITIVE {
                return $name(x * UP) * DOWN;
            }
            let exponent = (x.to_bits() >> FRACTION) as u32;
            let digits = x.to_bits() & ((1 << FRACTION) - 1) | (1 << FRACTION);
            // An even power of two is left, and the root has a digit more than the result. It is never half way between two results:
            // the square of a root that ends in 1 ends in 1.
            let odd = (exponent + BIAS) % 2;
            let root = ((digits as $wide) << (FRACTION + 2 + odd)).isqrt() as $bits;
            let half = (exponent + BIAS - odd) / 2;
            root.div_ceil(2) as $t * $t::from_bits(((half - FRACTION) as $bits) << FRACTION)
        }
    };
}

exact_sqrt!(sqrt_f32, f32, u32, u64);
exact_sqrt!(sqrt_f64, f64, u64, u128);

/// Cube root of a finite, non-negative number, likewise.
pub(crate) const fn cbrt(x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let mut y = f64::from_bits(x.to_bits() / 3 + 0x2a9f_7893_782d_a1ce);
    let mut i = 0;
    while i < 6 {
        y = (2.0 * y + x / (y * y)) / 3.0;
        i += 1;
    }
    y
}

/// Sine and cosine of an angle of at most about an eighth of a turn, by their series.
const fn sin_cos_small(x: f64) -> (f64, f64) {
    let x2 = x * x;
    let (mut s, mut c) = (1.0, 1.0);
    // Innermost term first: 1 - x2/(2*3) * (1 - x2/(4*5) * (...)).
    let mut n = 20.0;
    while n >= 2.0 {
        s = 1.0 - x2 / (n * (n + 1.0)) * s;
        c = 1.0 - x2 / ((n - 1.0) * n) * c;
        n -= 2.0;
    }
    (x * s, c)
}

/// Sine and cosine of `numerator / denominator` turns, exact at the quarters.
pub(crate) const fn sin_cos_turns(numerator: u32, denominator: u32) -> (f64, f64) {
    // Nearest quarter, and the rest beyond it, in eighths of a turn at most.
    let n = (numerator % denominator) as i64;
    let d = denominator as i64;
    let quarter = (8 * n + d) / (2 * d);
    let rest = 4 * n - quarter * d;
    let (s, c) = sin_cos_small(core::f64::consts::FRAC_PI_2 * (rest as f64) / (d as f64));
    match quarter % 4 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Sine and cosine of an angle of at most a few turns, rad.
pub(crate) const fn sin_cos(x: f64) -> (f64, f64) {
    // The quarter turn in two parts, so that its multiples subtract without loss.
    const QUARTER_HIGH: f64 = 1.570_796_326_734_125_6;
    const QUARTER_LOW: f64 = 6.077_100_506_506_192e-11;
    let turns = x / core::f64::consts::FRAC_PI_2;
    let quarter = (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i64;
    let rest = (x - quarter as f64 * QUARTER_HIGH) - quarter as f64 * QUARTER_LOW;
    let (s, c) = sin_cos_small(rest);
    match quarter.rem_euclid(4) {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Natural logarithm of a finite, positive number; anything smaller counts as the smallest one.
pub(crate) const fn ln(x: f64) -> f64 {
    let mut x = if x > f64::MIN_POSITIVE {
        x
    } else {
        f64::MIN_POSITIVE
    };
    let mut exponent = 0;
    // To within a root of 2 of 1; a thousand halvings at most.
    while x > core::f64::consts::SQRT_2 {
        x *= 0.5;
        exponent += 1;
    }
    while x < core::f64::consts::FRAC_1_SQRT_2 {
        x *= 2.0;
        exponent -= 1;
    }
    // 2 artanh s = 2 (s + s^3/3 + ...), s below 0.172.
    let s = (x - 1.0) / (x + 1.0);
    let mut sum = 0.0;
    let mut n = 25;
    while n > 0 {
        sum = sum * s * s + 1.0 / n as f64;
        n -= 2;
    }
    2.0 * s * sum + exponent as f64 * core::f64::consts::LN_2
}

/// `x` to the power of `y` for a finite, positive `x` and a result that doubles can hold.
pub(crate) const fn pow(x: f64, y: f64) -> f64 {
    let exponent = y * ln(x);
    let halves = exponent / core::f64::consts::LN_2;
    let whole = (halves + if halves < 0.0 { -0.5 } else { 0.5 }) as i32;
    let rest = exponent - whole as f64 * core::f64::consts::LN_2;
    let mut sum = 1.0;
    let mut n = 18;
    while n > 0 {
        sum = 1.0 + sum * rest / n as f64;
        n -= 1;
    }
    let mut i = 0;
    while i < whole && i < 1024 {
        sum *= 2.0;
        i += 1;
    }
    while i > whole && i > -1024 {
        sum *= 0.5;
        i -= 1;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elementary_functions_agree_with_the_standard_library() {
        for i in 1..2000 {
            let x = f64::from(i) * 0.37e-3 * f64::from(i);
            assert!((sqrt(x) / x.sqrt() - 1.0).abs() < 3e-16, "sqrt {x}");
            assert!((cbrt(x) / x.cbrt() - 1.0).abs() < 5e-16, "cbrt {x}");
            let a = f64::from(i) * 6.3e-3 - 6.3;
            let (s, c) = sin_cos(a);
            assert!((s - a.sin()).abs() < 3e-16, "sin {a}");
            assert!((c - a.cos()).abs() < 3e-16, "cos {a}");
        }
        for exponent in -300..300 {
            let x = 1.7 * 10f64.powi(exponent);
            assert!((sqrt(x) / x.sqrt() - 1.0).abs() < 3e-16, "sqrt {x}");
            assert!((cbrt(x) / x.cbrt() - 1.0).abs() < 5e-16, "cbrt {x}");
        }
    }

    #[test]
    fn exact_roots_have_the_hardwares_bits() {
        for i in 0..2_000_000_u64 {
            let bits = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let (x, y) = (f32::from_bits((bits >> 32) as u32), f64::from_bits(bits));
            if !x.is_nan() {
                assert_eq!(sqrt_f32(x).to_bits(), x.abs().sqrt().to_bits(), "{x}");
            }
            if !y.is_nan() {
                assert_eq!(sqrt_f64(y).to_bits(), y.abs().sqrt().to_bits(), "{y}");
            }
        }
        // Squares and their neighbours.
        for i in 1..4096_u32 {
            let (x, y) = (f64::from(i * i), f64::from(i) * f64::from(1 << 14 | i));
            for y in [x.next_down(), x, x.next_up(), (y * y).next_down(), y * y] {
                assert_eq!(sqrt_f64(y).to_bits(), y.sqrt().to_bits(), "{y}");
                assert_eq!(sqrt_f32(y as f32).to_bits(), (y as f32).sqrt().to_bits());
            }
        }
        for x in [0.0, 1e-45, f32::MIN_POSITIVE, f32::MAX, f32::INFINITY] {
            assert_eq!(sqrt_f32(x), x.sqrt());
        }
        for x in [0.0, 5e-324, f64::MIN_POSITIVE, f64::MAX, f64::INFINITY] {
            assert_eq!(sqrt_f64(x), x.sqrt());
        }
    }

    #[test]
    fn powers_agree_with_the_standard_library() {
        for i in 1..3000 {
            let x = f64::from(i) * 1.7e-3 * f64::from(i);
            for y in [0.41, -0.3, 10.0 / 3.0, 1.8, -1.0, 0.0] {
                assert!((pow(x, y) / x.powf(y) - 1.0).abs() < 2e-14, "{x}^{y}");
            }
            assert!(
                (ln(x) - x.ln()).abs() < 1e-15 * (1.0 + 2.0 * x.ln().abs()),
                "ln {x}"
            );
        }
    }

    #[test]
    fn fractions_of_a_turn_are_exact_at_the_quarters() {
        assert_eq!(sin_cos_turns(4, 16), (1.0, 0.0));
        assert_eq!(sin_cos_turns(8, 16), (0.0, -1.0));
        assert_eq!(sin_cos_turns(12, 16), (-1.0, 0.0));
        for n in 1..65u32 {
            for j in 0..n {
                let a = core::f64::consts::TAU * f64::from(j) / f64::from(n);
                let (s, c) = sin_cos_turns(j, n);
                // `a` itself carries the rounding of two products.
                let bound = 2.0 * a * f64::EPSILON + 3e-16;
                assert!((s - a.sin()).abs() < bound && (c - a.cos()).abs() < bound);
            }
        }
    }
}
