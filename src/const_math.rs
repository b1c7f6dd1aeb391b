//! Elementary functions that the compiler can evaluate.
//!
//! A design is turned into solver constants by `const fn`s, so that firmware carries numbers and
//! not the code that made them. `core` has no such functions for `const` yet. Those in `f64` are good to
//! about one unit in the last place, and give the same bits at compile time and at run time.
//!
//! Each of them ends for any bits, after a number of steps that does not depend on them. NaN gives NaN.

/// Square root by Newton's method, 0 below the smallest normal number.
///
/// The first guess halves the exponent, with an error below 4 %. Three steps would do; two more cost nothing here.
pub(crate) const fn sqrt(x: f64) -> f64 {
    if x < f64::MIN_POSITIVE {
        return 0.0;
    }
    if x == f64::INFINITY {
        return x;
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

/// Cube root, likewise.
pub(crate) const fn cbrt(x: f64) -> f64 {
    if x < f64::MIN_POSITIVE {
        return 0.0;
    }
    if x == f64::INFINITY {
        return x;
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

/// Sine and cosine of an angle, rad; NaN from a million on.
pub(crate) const fn sin_cos(x: f64) -> (f64, f64) {
    // The quarter turn in two parts, so that its multiples subtract without loss: the first one's 33 bits leave 20 for the multiple.
    const QUARTER_HIGH: f64 = 1.570_796_326_734_125_6;
    const QUARTER_LOW: f64 = 6.077_100_506_506_192e-11;
    if !(x.abs() < 1e6) {
        return (f64::NAN, f64::NAN);
    }
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

/// Power of two, `exponent` from -1022 to 1023.
const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// Natural logarithm; anything below the smallest normal number counts as that.
pub(crate) const fn ln(x: f64) -> f64 {
    if x.is_nan() || x == f64::INFINITY {
        return x;
    }
    let x = if x > f64::MIN_POSITIVE {
        x
    } else {
        f64::MIN_POSITIVE
    };
    let mut exponent = (x.to_bits() >> 52) as i32 - 1023;
    let fraction = x.to_bits() & ((1 << 52) - 1);
    let mut x = f64::from_bits(fraction | 1.0_f64.to_bits());
    // To within a root of 2 of 1.
    if x > core::f64::consts::SQRT_2 {
        x *= 0.5;
        exponent += 1;
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

/// `x` to the power of `y`, `x` as in [`ln`]: 0 or infinite beyond what doubles hold.
pub(crate) const fn pow(x: f64, y: f64) -> f64 {
    // Beyond all doubles' exponents, while two factors hold their power.
    const MOST: f64 = 1100.0;
    if x.is_nan() || y.is_nan() {
        return f64::NAN;
    }
    if x == 1.0 || y == 0.0 {
        return 1.0;
    }
    let exponent = y * ln(x);
    let halves = exponent / core::f64::consts::LN_2;
    if halves > MOST {
        return f64::INFINITY;
    }
    if halves < -MOST {
        return 0.0;
    }
    let whole = (halves + if halves < 0.0 { -0.5 } else { 0.5 }) as i32;
    let rest = exponent - whole as f64 * core::f64::consts::LN_2;
    let mut sum = 1.0;
    let mut n = 18;
    while n > 0 {
        sum = 1.0 + sum * rest / n as f64;
        n -= 1;
    }
    sum * power_of_two(whole / 2) * power_of_two(whole - whole / 2)
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

    /// Bits of every kind: signs, exponents from end to end, fractions of few and of many digits, and numbers of no value.
    fn any_bits() -> impl Iterator<Item = f64> {
        let fractions = [0, 1, 0x5_5555_5555_5555, 0xf_ffff_ffff_ffff];
        let ends = (0..4).chain(2043..2048);
        let exponents = ends.chain((4..2043).step_by(17)).chain(1020..1027);
        exponents.flat_map(move |exponent: u64| {
            fractions.into_iter().flat_map(move |fraction| {
                [0, 1].map(|sign: u64| f64::from_bits(sign << 63 | exponent << 52 | fraction))
            })
        })
    }

    #[test]
    fn elementary_functions_end_for_any_bits_with_the_standard_librarys_result() {
        // Where the result may lie: as far from the standard one as by rounding, and nothing is NaN that need not be.
        let agrees = |found: f64, right: f64, ulps: f64| {
            found == right
                || found.is_nan() && right.is_nan()
                || (found - right).abs() <= ulps * f64::EPSILON * right.abs() + f64::MIN_POSITIVE
        };
        for x in any_bits() {
            let least = f64::MIN_POSITIVE;
            let (or_zero, normal) = match x < least {
                true => (0.0, least),
                false => (x, x),
            };
            assert!(agrees(sqrt(x), or_zero.sqrt(), 2.0), "sqrt {x:e}");
            assert!(agrees(cbrt(x), or_zero.cbrt(), 3.0), "cbrt {x:e}");
            assert!(agrees(ln(x), normal.ln(), 8.0), "ln {x:e}");
            let (s, c) = sin_cos(x);
            assert!(
                s.is_nan() && c.is_nan() || s.abs() <= 1.0 && c.abs() <= 1.0,
                "{x:e}"
            );
            for y in any_bits().step_by(5) {
                let right = match x.is_nan() || y.is_nan() {
                    true => f64::NAN,
                    false => normal.powf(y),
                };
                let found = pow(x, y);
                // The exponent's rounding, of at most 1100 halves.
                assert!(
                    agrees(found, right, 3000.0),
                    "{x:e}^{y:e}: {found:e}, not {right:e}"
                );
            }
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
