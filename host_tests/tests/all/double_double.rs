//! Double-double arithmetic, which the reference build refines its solutions in.

use host_tests::double_double::Dd;

fn near(a: Dd, b: Dd, scale: f64) {
    assert!((a - b).value().abs() <= 2e-30 * scale, "{a:?} {b:?}");
}

#[test]
fn roots_and_quotients_invert_products() {
    for k in 1..200 {
        let x = Dd::of(f64::from(k)) / Dd::of(7.3);
        near(x.sqrt() * x.sqrt(), x, x.value());
        let c = x.cbrt();
        near(c * c * c, x, 10.0 * x.value());
        near(x / c * c, x, x.value());
    }
}

#[test]
fn sine_and_cosine_of_known_angles() {
    let half = Dd::of(0.5);
    let (s, c) = (Dd::PI / Dd::of(6.0)).sin_cos();
    near(s, half, 1.0);
    near(c, Dd::of(0.75).sqrt(), 1.0);
    let (s, c) = (Dd::PI / Dd::of(4.0)).sin_cos();
    near(s, half.sqrt(), 1.0);
    near(c, half.sqrt(), 1.0);
    let (s, c) = Dd::PI.sin_cos();
    near(s, Dd::ZERO, 4.0);
    near(c, -Dd::ONE, 4.0);
    near(s * s + c * c, Dd::ONE, 1.0);
    for k in -30..=30 {
        let x = Dd::of(f64::from(k) * 0.1) / Dd::of(1.0 / 1.03);
        let (s, c) = x.sin_cos();
        near(s * s + c * c, Dd::ONE, 2.0);
        let (s2, c2) = (x + x).ldexp(0.5).sin_cos();
        near(s2, s, 1.0);
        near(c2, c, 1.0);
        // Addition theorem ties the angles together.
        let (sa, ca) = (x.ldexp(0.5) + Dd::of(0.01)).sin_cos();
        let (sb, cb) = (x.ldexp(0.5) - Dd::of(0.01)).sin_cos();
        near(sa * cb + ca * sb, s, 4.0);
        near(ca * cb - sa * sb, c, 4.0);
    }
}
