//! Linear algebra: small dense systems.

use super::number::Scalar;
use crate::double_double::Dd;
use core::array::from_fn;

/// Solves `a x = b` for the columns of `b`; row-scaled partial pivoting.
pub(crate) fn small_solve<const N: usize, const M: usize>(
    mut a: [[f64; N]; N],
    mut b: [[f64; M]; N],
) -> Option<[[f64; M]; N]> {
    let is_pivot = |x: f64| x > 0.0 && x.is_finite();
    for (a, b) in a.iter_mut().zip(&mut b) {
        let big = a.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
        if !is_pivot(big) {
            return None;
        }
        *a = a.map(|x| x / big);
        *b = b.map(|x| x / big);
    }
    for c in 0..N {
        let p = (c..N).max_by(|&i, &j| a[i][c].abs().total_cmp(&a[j][c].abs()))?;
        a.swap(p, c);
        b.swap(p, c);
        if !is_pivot(a[c][c].abs()) {
            return None;
        }
        for r in c + 1..N {
            let f = a[r][c] / a[c][c];
            a[r] = from_fn(|k| {
                if k > c {
                    a[r][k] - f * a[c][k]
                } else {
                    a[r][k]
                }
            });
            b[r] = from_fn(|k| b[r][k] - f * b[c][k]);
        }
    }
    for c in (0..N).rev() {
        let above = |k: usize| (c + 1..N).fold(b[c][k], |x, j| x - a[c][j] * b[j][k]);
        b[c] = from_fn(|k| above(k) / a[c][c]);
    }
    let finite = b.as_flattened().iter().all(|x| x.is_finite());
    finite.then_some(b)
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

/// Solves `a x = b` for lines `[a | b]` of any number of columns; row-scaled partial pivoting.
pub(super) fn dense_solve<T: Scalar>(mut lines: Vec<Vec<T>>) -> Option<Vec<Vec<T>>> {
    let n = lines.len();
    let size = |x: &T| x.value().abs();
    for line in &mut lines {
        let big = T::of(Dd::of(line[..n].iter().map(size).fold(0.0, f64::max)));
        line.iter_mut().for_each(|x| *x = *x / big);
    }
    for c in 0..n {
        let p = (c..n).max_by(|i, j| size(&lines[*i][c]).total_cmp(&size(&lines[*j][c])))?;
        lines.swap(p, c);
        let (above, below) = lines.split_at_mut(c + 1);
        let pivot = &above[c][c..];
        // Also false of what is not a number.
        if !(size(&pivot[0]) > 0.0) {
            return None;
        }
        for line in below {
            if line[c].value() == 0.0 {
                continue;
            }
            let factor = line[c] / pivot[0];
            let rest = line[c..].iter_mut().zip(pivot);
            rest.for_each(|(x, y)| *x = *x - factor * *y);
        }
    }
    for c in (0..n).rev() {
        let (above, below) = lines.split_at_mut(c + 1);
        let (a, x) = above[c].split_at_mut(n);
        for (k, x) in x.iter_mut().enumerate() {
            let known = (c + 1..n).map(|j| a[j] * below[j - c - 1][n + k]);
            *x = (known.fold(*x, |x, known| x - known)) / a[c];
        }
    }
    let is_finite = |x: &T| x.value().is_finite();
    let finite = lines.iter().all(|line| line[n..].iter().all(is_finite));
    finite.then(|| {
        lines
            .into_iter()
            .map(|mut line| line.split_off(n))
            .collect()
    })
}
