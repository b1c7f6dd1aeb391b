//! From the bearing centre, to which loads, displacements and stiffness refer, to the plane of the inner groove centres.
//!
//! A tilt about the bearing centre moves that plane sideways, `dy' = dy + p tz`, `dz' = dz - p ty` with the distance `p`.
//! Displacements of the plane move a groove centre by one product each. A force with the moments `My`, `Mz` about a point
//! of the plane has `My - p Fz` and `Mz + p Fy` about the bearing centre. Distances along the axis are over `Rp`.

use crate::bearing::Constants;
use crate::linalg::Matrix;
use crate::real::Real;

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

/// Refers a force on the groove plane to the bearing centre.
#[inline(always)]
pub fn refer<T: Real, const D: usize>(plane: T, force: &mut [T; D]) {
    if D >= 5 {
        force[4] += plane * force[1];
        force[3] -= plane * force[2];
    }
}

/// Refers a stiffness at the groove plane to the bearing centre.
#[inline(always)]
pub fn refer_stiffness<T: Real, const D: usize>(plane: T, k: &mut Matrix<T, D>) {
    if D >= 5 {
        for row in k.iter_mut() {
            let (y, z) = (row[1], row[2]);
            row[4] += plane * y;
            row[3] -= plane * z;
        }
        for j in 0..D {
            let (y, z) = (k[1][j], k[2][j]);
            k[4][j] += plane * y;
            k[3][j] -= plane * z;
        }
    }
}

/// Units of force and displacement of a freedom, SI.
#[inline(always)]
pub fn units<T: Real>(c: &Constants<T>, freedom: usize) -> (T, T) {
    match freedom {
        3 | 4 => (c.moment, c.tilt),
        _ => (c.force, c.length),
    }
}

/// A displacement in SI units.
pub fn displacement_out<T: Real, const D: usize>(c: &Constants<T>, u: &[T; D]) -> [T; D] {
    core::array::from_fn(|i| u[i] * units(c, i).1)
}

/// A force in SI units.
pub fn force_out<T: Real, const D: usize>(c: &Constants<T>, f: &[T; D]) -> [T; D] {
    core::array::from_fn(|i| f[i] * units(c, i).0)
}

/// A stiffness in SI units.
pub fn stiffness_out<T: Real, const D: usize>(c: &Constants<T>, k: &Matrix<T, D>) -> Matrix<T, D> {
    let per = [T::ONE / c.length, T::ONE / c.tilt];
    core::array::from_fn(|i| {
        let force = units(c, i).0;
        core::array::from_fn(|j| k[i][j] * (force * per[usize::from(matches!(j, 3 | 4))]))
    })
}
