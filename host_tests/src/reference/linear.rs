//! Linear algebra: dense systems, factored as they stand.

use core::array::from_fn;

/// Solves `a x = b` for the `m` columns of `b` in place; row-scaled partial pivoting.
pub(super) fn dense_solve(a: &mut [f64], b: &mut [f64], m: usize) -> Option<()> {
    let n = b.len() / m;
    for r in 0..n {
        let big = a[r * n..(r + 1) * n]
            .iter()
            .fold(0.0_f64, |s, x| s.max(x.abs()));
        if !(big > 0.0 && big.is_finite()) {
            return None;
        }
        a[r * n..(r + 1) * n].iter_mut().for_each(|x| *x /= big);
        b[r * m..(r + 1) * m].iter_mut().for_each(|x| *x /= big);
    }
    for c in 0..n {
        let p = (c..n).max_by(|&i, &j| a[i * n + c].abs().total_cmp(&a[j * n + c].abs()))?;
        if !(a[p * n + c].abs() > 0.0 && a[p * n + c].is_finite()) {
            return None;
        }
        if p != c {
            for k in 0..n {
                a.swap(p * n + k, c * n + k);
            }
            for k in 0..m {
                b.swap(p * m + k, c * m + k);
            }
        }
        for r in c + 1..n {
            let f = a[r * n + c] / a[c * n + c];
            if f != 0.0 {
                for k in c + 1..n {
                    a[r * n + k] -= f * a[c * n + k];
                }
                for k in 0..m {
                    b[r * m + k] -= f * b[c * m + k];
                }
            }
        }
    }
    for c in (0..n).rev() {
        for k in 0..m {
            let mut x = b[c * m + k];
            for j in c + 1..n {
                x -= a[c * n + j] * b[j * m + k];
            }
            b[c * m + k] = x / a[c * n + c];
        }
    }
    b.iter().all(|x| x.is_finite()).then_some(())
}

/// Small fixed-size form of [`dense_solve`].
pub(crate) fn small_solve<const N: usize, const M: usize>(
    mut a: [[f64; N]; N],
    mut b: [[f64; M]; N],
) -> Option<[[f64; M]; N]> {
    dense_solve(a.as_flattened_mut(), b.as_flattened_mut(), M)?;
    Some(b)
}

/// Solves `k du = rhs` for the free freedoms, the others stay; tilts scaled to lengths.
pub(crate) fn masked_solve(
    k: &[[f64; 5]; 5],
    rhs: &[f64; 5],
    free: &[bool; 5],
    unit: &[f64; 5],
) -> Option<[f64; 5]> {
    let a: [[f64; 5]; 5] = from_fn(|r| {
        from_fn(|c| {
            if free[r] && free[c] {
                k[r][c] / (unit[r] * unit[c])
            } else {
                f64::from(r == c)
            }
        })
    });
    let b: [[f64; 1]; 5] = from_fn(|r| [if free[r] { rhs[r] / unit[r] } else { 0.0 }]);
    let x = small_solve(a, b)?;
    Some(from_fn(|r| x[r][0] / unit[r]))
}
