//! Vectors and matrices of two, and the system of the ring's freedoms.
//!
//! A tilt about a point moves one further along the axis sideways: `dy' = dy + p tz`, `dz' = dz - p ty` at the distance `p`. A force
//! with moments about the second point has `My - p Fz` and `Mz + p Fy` about the first. Distances are over `Rp` where tilts are.
//!
//! Products come first, then their sums: an FPU like the Cortex-M4's waits where a result is used at once, and the
//! compiler keeps this order.

use crate::real::Real;

/// A vector in the axial-radial plane of a ball.
pub type Pair<T> = [T; 2];
/// 2x2 matrix, by rows.
pub type Matrix2<T> = [Pair<T>; 2];
/// Matrix over the freedoms, by rows (force) and columns (displacement).
pub type Matrix<T, const D: usize> = [[T; D]; D];

/// A vector by its elements. In `core::array::from_fn`, a profile that inlines less checks every index.
#[inline(always)]
pub fn vector<T: Real, const D: usize>(element: impl Fn(usize) -> T) -> [T; D] {
    let mut v = [T::ZERO; D];
    for i in 0..D {
        v[i] = element(i);
    }
    v
}

/// A matrix by its elements, row and column.
#[inline(always)]
pub fn matrix<T: Real, const D: usize>(element: impl Fn(usize, usize) -> T) -> Matrix<T, D> {
    let mut m = [[T::ZERO; D]; D];
    for i in 0..D {
        for j in 0..D {
            m[i][j] = element(i, j);
        }
    }
    m
}

#[inline(always)]
pub fn dot<T: Real>(a: Pair<T>, b: Pair<T>) -> T {
    a[0] * b[0] + a[1] * b[1]
}

/// `a.b` and `c.d`.
#[inline(always)]
pub fn dots<T: Real>([a, b]: [Pair<T>; 2], [c, d]: [Pair<T>; 2]) -> Pair<T> {
    let (p, q) = (a[0] * b[0], a[1] * b[1]);
    let (r, s) = (c[0] * d[0], c[1] * d[1]);
    [p + q, r + s]
}

#[inline(always)]
pub fn add<T: Real>(a: Pair<T>, b: Pair<T>) -> Pair<T> {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
pub fn sub<T: Real>(a: Pair<T>, b: Pair<T>) -> Pair<T> {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline(always)]
pub fn scale<T: Real>(a: T, v: Pair<T>) -> Pair<T> {
    [a * v[0], a * v[1]]
}

/// `m v`.
#[inline(always)]
pub fn times<T: Real>(m: &Matrix2<T>, v: Pair<T>) -> Pair<T> {
    let (a, b) = (m[0][0] * v[0], m[0][1] * v[1]);
    let (c, d) = (m[1][0] * v[0], m[1][1] * v[1]);
    [a + b, c + d]
}

/// `m^T v`.
#[inline(always)]
pub fn times_transposed<T: Real>(m: &Matrix2<T>, v: Pair<T>) -> Pair<T> {
    let (a, b) = (m[0][0] * v[0], m[1][0] * v[1]);
    let (c, d) = (m[0][1] * v[0], m[1][1] * v[1]);
    [a + b, c + d]
}

/// `a b`, a column after the other.
#[inline(always)]
pub fn product2<T: Real>(a: &Matrix2<T>, b: &Matrix2<T>) -> Matrix2<T> {
    let p = times(a, [b[0][0], b[1][0]]);
    let q = times(a, [b[0][1], b[1][1]]);
    [[p[0], q[0]], [p[1], q[1]]]
}

/// From axial and radial components to those along a contact's normal `n = (sin, cos)` and tangent
/// `(cos, -sin)`, or back: the matrix is its own inverse.
#[inline(always)]
pub fn turn<T: Real>(n: Pair<T>, v: Pair<T>) -> Pair<T> {
    let (a, b) = (v[0] * n[0], v[1] * n[1]);
    let (c, d) = (v[0] * n[1], v[1] * n[0]);
    [a + b, c - d]
}

/// Adds the matrix `b` to `a`.
#[inline(always)]
pub fn add_to<T: Real, const D: usize>(a: &mut Matrix<T, D>, b: &Matrix<T, D>) {
    for (a, b) in a.iter_mut().zip(b) {
        for (a, b) in a.iter_mut().zip(b) {
            *a += *b;
        }
    }
}

/// Product of two vectors over the freedoms.
#[inline(always)]
pub fn product<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> T {
    let mut sum = T::ZERO;
    for i in 0..D {
        sum += a[i] * b[i];
    }
    sum
}

/// The displacement of a point that is further along the axis by the `distance` from the one displaced by `u`.
#[inline(always)]
pub fn moved<T: Real, const D: usize>(distance: T, u: &[T; D]) -> [T; D] {
    let mut u = *u;
    if D >= 5 {
        u[1] += distance * u[4];
        u[2] -= distance * u[3];
    }
    u
}

/// Refers a force, in place, to a point that is nearer to the origin by `distance`.
#[inline(always)]
pub fn refer<T: Real, const D: usize>(distance: T, force: &mut [T; D]) {
    if D >= 5 {
        force[4] += distance * force[1];
        force[3] -= distance * force[2];
    }
}

/// Refers a stiffness, in place, to a point that is nearer to the origin by `distance`.
#[inline(always)]
pub fn refer_stiffness<T: Real, const D: usize>(distance: T, k: &mut Matrix<T, D>) {
    if D >= 5 {
        for row in k.iter_mut() {
            let (y, z) = (row[1], row[2]);
            row[4] += distance * y;
            row[3] -= distance * z;
        }
        for j in 0..D {
            let (y, z) = (k[1][j], k[2][j]);
            k[4][j] += distance * y;
            k[3][j] -= distance * z;
        }
    }
}

/// Length of a vector over the freedoms.
#[inline(never)]
pub fn norm<T: Real, const D: usize>(a: &[T; D]) -> T {
    product(a, a).sqrt_abs()
}

/// Lower and upper factor of a matrix, in one; the pivots inverted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factors<T, const D: usize> {
    lu: Matrix<T, D>,
    /// Least pivot over the diagonal element that it came of; not positive where the matrix is not
    /// positive definite.
    pub least: T,
}

impl<T: Real, const D: usize> Factors<T, D> {
    /// Of no matrix.
    pub const NONE: Self = Self {
        lu: [[T::ZERO; D]; D],
        least: T::ZERO,
    };

    /// Takes the factors of `k` with `shift` added to its diagonal, without pivoting.
    #[inline(never)]
    pub fn factor(&mut self, k: &Matrix<T, D>, shift: T) {
        self.lu = *k;
        let lu = &mut self.lu;
        for i in 0..D {
            lu[i][i] += shift;
        }
        // The least pivot as a quotient, with one division.
        let (mut least, mut element) = (T::ONE, T::ONE);
        for i in 0..D {
            let pivot = lu[i][i];
            let diagonal = (k[i][i].abs() + shift).at_least(T::TINY);
            if !(pivot * element >= least * diagonal) {
                (least, element) = (pivot, diagonal);
            }
            // A pivot of nothing is replaced: who asks looks at `least` first.
            let inverse = T::ONE / if pivot.abs() > T::TINY { pivot } else { T::ONE };
            lu[i][i] = inverse;
            for j in i + 1..D {
                lu[j][i] = lu[j][i] * inverse;
            }
            for j in i + 1..D {
                for l in i + 1..D {
                    let product = lu[j][i] * lu[i][l];
                    lu[j][l] -= product;
                }
            }
        }
        self.least = least / element;
    }

    /// Whether a pivot may be nothing but the rounding of the products taken off it, one for each pivot before. The last one does not
    /// count if that freedom `is_missing`.
    #[inline(always)]
    pub fn is_weak(&self, is_missing: bool) -> bool {
        let [all, fewer] = [D - 1, D.saturating_sub(2)].map(|before| T::of(before as f64));
        let before = if is_missing { fewer } else { all };
        !(self.least > before * T::EPSILON)
    }

    /// Largest inverse pivot: about the compliance in the direction in which the matrix resists least.
    pub fn compliance(&self) -> T {
        let mut largest = T::ZERO;
        for i in 0..D {
            largest = largest.at_least(self.lu[i][i].abs());
        }
        largest
    }

    /// Solves for the right-hand side `b`.
    #[inline(never)]
    pub fn back_substitute(&self, b: &[T; D]) -> [T; D] {
        let mut x = *b;
        for i in 0..D {
            for j in 0..i {
                let product = self.lu[i][j] * x[j];
                x[i] -= product;
            }
        }
        for i in (0..D).rev() {
            for j in i + 1..D {
                let product = self.lu[i][j] * x[j];
                x[i] -= product;
            }
            x[i] = x[i] * self.lu[i][i];
        }
        x
    }
}
