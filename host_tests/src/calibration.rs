//! Calibration of strain bridges: from the counts that each load makes alone to the loads that fit counts best.

use anyhow::{Result, ensure};

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
pub fn loads(counts: &[[f64; 5]]) -> Result<Loads> {
    ensure!(
        counts.iter().flatten().all(|count| count.is_finite()),
        "a count is not a number"
    );
    let product = |i: usize, j: usize| counts.iter().map(|of| of[i] * of[j]).sum::<f64>();
    let scale: [f64; 5] = std::array::from_fn(|i| product(i, i).sqrt());
    // Of columns of length 1.
    let normal = std::array::from_fn(|i| {
        std::array::from_fn(|j| match i == j {
            true => 1.0,
            false => product(i, j) / (scale[i] * scale[j]),
        })
    });
    let inverse = inverse(normal);
    // The norm of the pseudo-inverse is the trace of the inverse normal matrix, that of the columns the root of 5.
    let trace: f64 = (0..5).map(|i| inverse[i][i]).sum();
    let condition = (trace / 5.0).sqrt();
    ensure!(
        condition < WORST,
        "these bridges do not tell five loads apart"
    );
    let by_bridge = counts.iter().map(|of| {
        let load = |i: usize| {
            (0..5)
                .map(|j| inverse[i][j] * of[j] / scale[j])
                .sum::<f64>()
        };
        std::array::from_fn(|i| load(i) / scale[i])
    });
    Ok(Loads {
        by_bridge: by_bridge.collect(),
        condition,
    })
}

/// The inverse of a positive definite matrix, by Gauss and Jordan; no numbers of a singular one.
fn inverse(mut a: [[f64; 5]; 5]) -> [[f64; 5]; 5] {
    for pivot in 0..5 {
        let factor = 1.0 / a[pivot][pivot];
        a[pivot][pivot] = 1.0;
        a[pivot] = a[pivot].map(|x| x * factor);
        let row = a[pivot];
        for i in (0..5).filter(|i| *i != pivot) {
            let factor = std::mem::take(&mut a[i][pivot]);
            for (x, by) in a[i].iter_mut().zip(row) {
                *x -= factor * by;
            }
        }
    }
    a
}
