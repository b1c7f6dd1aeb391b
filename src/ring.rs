//! The ring: forces and tangents of all balls summed over the azimuth, and the 5x5 system.
//!
//! Order of freedoms: axial, radial y, radial z, tilt about y, tilt about z; lengths, radial
//! displacements and moments as in the units of the constants, i.e. referred to the groove plane.

use crate::ball::Share;
use crate::constants::{Azimuth, Constants};
use crate::contact::Pair;
use crate::float::Real;

/// Vector over the five freedoms.
pub type Five<T> = [T; 5];
/// Matrix over the five freedoms, by rows (force) and columns (displacement).
pub type Tangent<T> = [[T; 5]; 5];

/// Shift of the inner groove's centre at an azimuth due to a ring displacement.
#[inline(always)]
pub fn shift<T: Real>(u: &Five<T>, at: &Azimuth<T>) -> Pair<T> {
    [
        u[0] + u[3] * at.sin - u[4] * at.cos,
        u[1] * at.cos + u[2] * at.sin,
    ]
}

/// Adds one ball's force and couple to those on the ring.
#[inline(always)]
pub fn spread<T: Real>(sum: &mut Five<T>, at: &Azimuth<T>, force: Pair<T>, couple: T) {
    let [fa, fr] = force;
    let moment = fa - couple;
    sum[0] += fa;
    sum[1] += fr * at.cos;
    sum[2] += fr * at.sin;
    sum[3] += moment * at.sin;
    sum[4] -= moment * at.cos;
}

/// Sums over the azimuth. The tangent needs 21 of them: each element of a ball's `H` is weighted by
/// 1, the cosine and sine, or their products, and the tilts use the same sums as axial and radial
/// motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sums<T> {
    force: Five<T>,
    /// Radial force and moment that all balls may have in common, and what they have beyond.
    common: Pair<T>,
    beyond: Pair<T>,
    axial_axial: [T; 3],
    axial_radial: [T; 2],
    radial_axial: [T; 5],
    radial_radial: [T; 3],
    moment_axial: [T; 5],
    moment_radial: [T; 3],
}

impl<T: Real> Sums<T> {
    /// No balls yet. Radial force and moment are counted from `common`, about the mean of the
    /// balls: cosines and sines add up to 0 over the azimuth, but rounded ones do not quite, and what
    /// is left of a common force would tilt the ring, in single precision by more than a light
    /// load shifts it.
    pub fn about(common: Pair<T>) -> Self {
        Self {
            force: [T::ZERO; 5],
            common,
            beyond: [T::ZERO; 2],
            axial_axial: [T::ZERO; 3],
            axial_radial: [T::ZERO; 2],
            radial_axial: [T::ZERO; 5],
            radial_radial: [T::ZERO; 3],
            moment_axial: [T::ZERO; 5],
            moment_radial: [T::ZERO; 3],
        }
    }

    /// Adds one ball.
    #[inline(always)]
    pub fn add(&mut self, at: &Azimuth<T>, ball: &Share<T>) {
        let (c, s) = (at.cos, at.sin);
        let [fa, fr] = ball.force;
        let moment = fa - ball.couple;
        let (fr, moment) = (fr - self.common[0], moment - self.common[1]);
        self.beyond[0] += fr;
        self.beyond[1] += moment;
        self.force[0] += fa;
        self.force[1] += fr * c;
        self.force[2] += fr * s;
        self.force[3] += moment * s;
        self.force[4] -= moment * c;
        let [[aa, ar], [ra, rr]] = ball.stiffness;
        let ma = aa - ball.couple_slope[0];
        let mr = ar - ball.couple_slope[1];
        self.axial_axial[0] += aa;
        self.axial_axial[1] += aa * c;
        self.axial_axial[2] += aa * s;
        self.axial_radial[0] += ar * c;
        self.axial_radial[1] += ar * s;
        let (ra_c, ra_s) = (ra * c, ra * s);
        self.radial_axial[0] += ra_c;
        self.radial_axial[1] += ra_s;
        self.radial_axial[2] += ra_c * c;
        self.radial_axial[3] += ra_c * s;
        self.radial_axial[4] += ra_s * s;
        let (rr_c, rr_s) = (rr * c, rr * s);
        self.radial_radial[0] += rr_c * c;
        self.radial_radial[1] += rr_c * s;
        self.radial_radial[2] += rr_s * s;
        let (ma_c, ma_s) = (ma * c, ma * s);
        self.moment_axial[0] += ma_c;
        self.moment_axial[1] += ma_s;
        self.moment_axial[2] += ma_c * c;
        self.moment_axial[3] += ma_c * s;
        self.moment_axial[4] += ma_s * s;
        let (mr_c, mr_s) = (mr * c, mr * s);
        self.moment_radial[0] += mr_c * c;
        self.moment_radial[1] += mr_c * s;
        self.moment_radial[2] += mr_s * s;
    }

    /// Mean radial force and moment of `balls` balls.
    #[inline(always)]
    pub fn mean(&self, balls: T) -> Pair<T> {
        [
            self.common[0] + self.beyond[0] / balls,
            self.common[1] + self.beyond[1] / balls,
        ]
    }

    /// Force of the balls on the ring.
    #[inline(always)]
    pub fn force(&self) -> Five<T> {
        self.force
    }

    /// The 5x5 tangent.
    #[inline]
    pub fn tangent(&self) -> Tangent<T> {
        let [aa, aa_c, aa_s] = self.axial_axial;
        let [ar_c, ar_s] = self.axial_radial;
        let [ra_c, ra_s, ra_cc, ra_cs, ra_ss] = self.radial_axial;
        let [rr_cc, rr_cs, rr_ss] = self.radial_radial;
        let [ma_c, ma_s, ma_cc, ma_cs, ma_ss] = self.moment_axial;
        let [mr_cc, mr_cs, mr_ss] = self.moment_radial;
        [
            [aa, ar_c, ar_s, aa_s, -aa_c],
            [ra_c, rr_cc, rr_cs, ra_cs, -ra_cc],
            [ra_s, rr_cs, rr_ss, ra_ss, -ra_cs],
            [ma_s, mr_cs, mr_ss, ma_ss, -ma_cs],
            [-ma_c, -mr_cc, -mr_cs, -ma_cs, ma_cc],
        ]
    }
}

/// Displacement in the bearing's own coordinates, SI, from that of the groove plane.
#[inline]
pub fn displacement_out<T: Real>(c: &Constants<T>, u: &Five<T>) -> Five<T> {
    let [dx, vy, vz, ty, tz] = *u;
    [
        dx * c.length,
        (vy - c.plane * tz) * c.length,
        (vz + c.plane * ty) * c.length,
        ty * c.tilt,
        tz * c.tilt,
    ]
}

/// The inverse of [`displacement_out`].
#[inline]
pub fn displacement_in<T: Real>(c: &Constants<T>, u: &Five<T>) -> Five<T> {
    let (ty, tz) = (u[3] / c.tilt, u[4] / c.tilt);
    [
        u[0] / c.length,
        u[1] / c.length + c.plane * tz,
        u[2] / c.length - c.plane * ty,
        ty,
        tz,
    ]
}

/// Load on the groove plane from the load on the bearing centre, SI: a radial force acts there with
/// the lever arm of the plane.
#[inline]
pub fn load_in<T: Real>(c: &Constants<T>, load: &Five<T>) -> Five<T> {
    let (fy, fz) = (load[1] / c.force, load[2] / c.force);
    [
        load[0] / c.force,
        fy,
        fz,
        load[3] / c.moment + c.plane * fz,
        load[4] / c.moment - c.plane * fy,
    ]
}

/// The inverse of [`load_in`].
#[inline]
pub fn load_out<T: Real>(c: &Constants<T>, f: &Five<T>) -> Five<T> {
    [
        f[0] * c.force,
        f[1] * c.force,
        f[2] * c.force,
        (f[3] - c.plane * f[2]) * c.moment,
        (f[4] + c.plane * f[1]) * c.moment,
    ]
}

/// Stiffness at the bearing centre, SI, from the tangent at the groove plane.
#[inline]
pub fn stiffness_out<T: Real>(c: &Constants<T>, tangent: &Tangent<T>) -> Tangent<T> {
    let mut k = *tangent;
    // Columns: a tilt of the bearing centre moves the groove plane sideways.
    for row in &mut k {
        row[3] -= c.plane * row[2];
        row[4] += c.plane * row[1];
    }
    for j in 0..5 {
        k[3][j] -= c.plane * k[2][j];
        k[4][j] += c.plane * k[1][j];
    }
    let force = c.force / c.length;
    let by_tilt = c.force / c.tilt;
    let moment = c.moment / c.length;
    let moment_by_tilt = c.moment / c.tilt;
    for (i, row) in k.iter_mut().enumerate() {
        for (j, element) in row.iter_mut().enumerate() {
            *element = *element
                * match (i < 3, j < 3) {
                    (true, true) => force,
                    (true, false) => by_tilt,
                    (false, true) => moment,
                    (false, false) => moment_by_tilt,
                };
        }
    }
    k
}

/// Whether a tangent resists every displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Definite {
    /// It does.
    Positive,
    /// Some displacement meets no resistance.
    Semi,
    /// Some displacement is driven on.
    No,
}

/// `L U` factors of a tangent, without pivoting: apart from friction, which is small, a tangent is
/// symmetric and positive definite, and its rows are scaled alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factors<T> {
    lu: Tangent<T>,
    inverse_pivot: Five<T>,
}

impl<T: Real> Factors<T> {
    /// Factorises. A pivot smaller than `least` of its diagonal element is replaced by that element,
    /// so that the step stays bounded, and reported.
    #[inline]
    pub fn of(tangent: &Tangent<T>, least: T) -> (Self, Definite) {
        let mut lu = *tangent;
        let mut inverse_pivot = [T::ZERO; 5];
        let mut definite = Definite::Positive;
        for k in 0..5 {
            let diagonal = tangent[k][k].abs();
            let pivot = lu[k][k];
            if !(pivot.abs() > least * diagonal) || !(pivot.abs() > T::TINY) {
                if definite == Definite::Positive {
                    definite = Definite::Semi;
                }
                lu[k][k] = diagonal.or_larger(T::EPSILON);
            } else if pivot < T::ZERO {
                definite = Definite::No;
            }
            let inverse = T::ONE / lu[k][k];
            inverse_pivot[k] = inverse;
            for i in k + 1..5 {
                let factor = lu[i][k] * inverse;
                lu[i][k] = factor;
                for j in k + 1..5 {
                    let above = lu[k][j];
                    lu[i][j] -= factor * above;
                }
            }
        }
        (Self { lu, inverse_pivot }, definite)
    }

    /// Flexibility along the direction of the smallest pivot.
    #[inline]
    pub fn weakest(&self) -> T {
        let mut largest = T::ZERO;
        for inverse in &self.inverse_pivot {
            largest = largest.or_larger(inverse.abs());
        }
        largest
    }

    /// Solves `K x = b`.
    #[inline]
    pub fn solve(&self, b: &Five<T>) -> Five<T> {
        let mut x = *b;
        for i in 1..5 {
            for j in 0..i {
                let known = x[j];
                x[i] -= self.lu[i][j] * known;
            }
        }
        for i in (0..5).rev() {
            for j in i + 1..5 {
                let known = x[j];
                x[i] -= self.lu[i][j] * known;
            }
            x[i] = x[i] * self.inverse_pivot[i];
        }
        x
    }
}
