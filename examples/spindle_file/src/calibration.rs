//! Calibration of strain bridges: from the counts that each load makes alone to the loads that fit counts best.

use std::array::from_fn;

/// Largest condition of bridges that tell five loads apart: noise of a count is amplified as much.
const WORST: f64 = 1000.0;

/// Loads by counts, and their condition.
#[derive(Debug, Clone, PartialEq)]
pub struct Loads {
    /// The five loads that a count of each bridge stands for, N and N m.
    pub by_bridge: Vec<[f64; 5]>,
    /// Condition of the counts, loads taken in units that make equal counts: norms of Frobenius, 1 at best.
    pub condition: f64,
}

/// The least squares of `counts` (rows the bridges; counts per N or N m of `Fx, Fy, Fz, My, Mz`).
///
/// # Errors
///
/// A number that is none, or bridges that do not tell five loads apart.
pub fn loads(counts: &[[f64; 5]]) -> Result<Loads, &'static str> {
    if !counts.iter().flatten().all(|count| count.is_finite()) {
        return Err("a count is not a number");
    }
    let product = |i: usize, j: usize| counts.iter().map(|of| of[i] * of[j]).sum::<f64>();
    let scale: [f64; 5] = from_fn(|i| product(i, i).sqrt());
    // Of columns of length 1.
    let normal: [[f64; 5]; 5] = from_fn(|i| from_fn(|j| product(i, j) / (scale[i] * scale[j])));
    let alike = "these bridges do not tell five loads apart";
    let inverse = inverse(normal).ok_or(alike)?;
    // The norm of the pseudo-inverse is the trace of the inverse normal matrix, that of the columns the root of 5.
    let trace: f64 = (0..5).map(|i| inverse[i][i]).sum();
    let condition = (trace / 5.0).sqrt();
    if !(condition < WORST) {
        return Err(alike);
    }
    let by_bridge = counts.iter().map(|of| {
        let load = |i: usize| {
            (0..5)
                .map(|j| inverse[i][j] * of[j] / scale[j])
                .sum::<f64>()
        };
        from_fn(|i| load(i) / scale[i])
    });
    Ok(Loads {
        by_bridge: by_bridge.collect(),
        condition,
    })
}

/// The inverse of a symmetric matrix that is positive definite, by elimination along its diagonal.
fn inverse(mut a: [[f64; 5]; 5]) -> Option<[[f64; 5]; 5]> {
    let mut b: [[f64; 5]; 5] = from_fn(|i| from_fn(|j| f64::from(i == j)));
    for c in 0..5 {
        let pivot = a[c][c];
        if !(pivot > 0.0) {
            return None;
        }
        (a[c], b[c]) = (a[c].map(|x| x / pivot), b[c].map(|x| x / pivot));
        for r in (0..5).filter(|r| *r != c) {
            let f = a[r][c];
            a[r] = from_fn(|k| a[r][k] - f * a[c][k]);
            b[r] = from_fn(|k| b[r][k] - f * b[c][k]);
        }
    }
    Some(b)
}
