//! Laws of statics that a solved spindle obeys.

use spindle_bearing::{Facing, Motion, Real, SpindleSolution};

/// Facing of a row, whether it slides, and its pitch diameter.
pub type Place = (Facing, bool, f64);

/// Rows carry the load, and those in a sleeve its spring, as well as the contact forces are said to be known.
pub fn assert_balances<
    T: Real,
    const R: usize,
    const N: usize,
    M: Motion,
    const D: usize,
    const E: usize,
>(
    rows: &[Place],
    spring: T,
    s: &SpindleSolution<'_, T, R, N, M, D, E>,
) {
    let (mut left, mut sliding) = (s.load.map(T::to_f64), spring.to_f64());
    let (mut pressed, mut largest, mut arm) = (0, 0.0, 0.0);
    for (row, &(facing, slides, pitch)) in s.rows().zip(rows) {
        let (x, sign) = (row.position.to_f64(), facing.sign::<f64>());
        let [fx, fy, fz, my, mz] = row.force.map(T::to_f64);
        let on_shaft = [sign * fx, fy, fz, sign * my - x * fz, sign * mz + x * fy];
        for (left, force) in left.iter_mut().zip(on_shaft) {
            *left -= force;
        }
        sliding -= if slides { fx } else { 0.0 };
        arm = x.abs().max(pitch).max(arm);
        for ball in row.balls() {
            largest = ball.q_i.to_f64().max(largest);
            pressed += usize::from(ball.q_i > T::ZERO);
        }
    }
    let known = s.error.force.to_f64() * largest * pressed as f64;
    let moment = known * arm;
    for (left, known) in left.into_iter().zip([known, known, known, moment, moment]) {
        assert!(left.abs() <= known, "{left:e} of {known:e} in {s:?}");
    }
    let known = if D == 6 { known } else { f64::INFINITY };
    assert!(sliding.abs() <= known, "{sliding:e} of {known:e} in {s:?}");
}

/// At rest, the stiffness has a potential, as well as it is said to be known.
pub fn assert_symmetric<
    T: Real,
    const R: usize,
    const N: usize,
    M: Motion,
    const D: usize,
    const E: usize,
>(
    s: &SpindleSolution<'_, T, R, N, M, D, E>,
) {
    let k = s.stiffness().map(|row| row.map(T::to_f64));
    for i in 0..5 {
        for j in 0..i {
            let off = (k[i][j] - k[j][i]).abs();
            let known = s.error.stiffness.to_f64() * (k[i][i] * k[j][j]).abs().sqrt();
            assert!(off <= known, "{i} {j}: {off:e} of {known:e} in {s:?}");
        }
    }
}
