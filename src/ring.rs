//! The ring: forces and tangents of all balls summed over the azimuth, and the system of its freedoms.
//!
//! Order of freedoms: axial, radial y, radial z, tilt about y, tilt about z; lengths, radial
//! displacements and moments as in the units of the constants, i.e. referred to the groove plane. A
//! scene has the first `D` of them: 1, 3 or 5. What the others need, `D` being a constant, is not
//! compiled.

use crate::ball::Share;
use crate::constants::{Azimuth, Constants};
use crate::contact::{Pair, add};
use crate::float::Real;

/// Matrix over the freedoms, by rows (force) and columns (displacement).
pub type Tangent<T, const D: usize> = [[T; D]; D];

/// How many balls share the load: all, or the one that stands for all.
#[inline(always)]
pub fn sharing<T: Real, const D: usize>(c: &Constants<T>) -> T {
    if D == 1 { T::ONE } else { c.balls }
}

/// Position of the ring: a coarse reference, exactly known to every ball, and an offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position<T, const D: usize> {
    pub reference: [T; D],
    pub offset: [T; D],
}

impl<T: Real, const D: usize> Position<T, D> {
    /// Of the unloaded bearing.
    pub const UNLOADED: Self = Self {
        reference: [T::ZERO; D],
        offset: [T::ZERO; D],
    };

    /// Their sum.
    #[inline]
    pub fn total(&self) -> [T; D] {
        let mut total = self.reference;
        for (sum, offset) in total.iter_mut().zip(&self.offset) {
            *sum += *offset;
        }
        total
    }

    /// Moves the reference next to the position.
    #[inline]
    pub fn rebase(&mut self) {
        for (reference, offset) in self.reference.iter_mut().zip(&mut self.offset) {
            let new = (*reference + *offset).coarse();
            *offset += *reference - new;
            *reference = new;
        }
    }
}

/// Position of the inner groove's curvature centre at the ring's reference: a part that is exact
/// (products of coarse numbers), and a small rest.
#[inline]
pub fn curvature_centre<T: Real, const D: usize>(
    c: &Constants<T>,
    u: &[T; D],
    at: &Azimuth<T>,
) -> (Pair<T>, Pair<T>) {
    let (cos, sin) = (at.cos.coarse(), at.sin.coarse());
    let mut high = [c.n0[0].high + u[0], c.n0[1].high];
    let mut low = [c.n0[0].low, c.n0[1].low];
    if D >= 3 {
        high[1] = high[1] + u[1] * cos + u[2] * sin;
        low[1] = low[1] + u[1] * at.cos_low + u[2] * at.sin_low;
    }
    if D == 5 {
        high[0] = high[0] + u[3] * sin - u[4] * cos;
        low[0] = low[0] + u[3] * at.sin_low - u[4] * at.cos_low;
    }
    (high, low)
}

/// Shift of the inner groove's centre at an azimuth due to a ring displacement.
#[inline(always)]
pub fn shift<T: Real, const D: usize>(u: &[T; D], at: &Azimuth<T>) -> Pair<T> {
    let axial = if D == 5 {
        u[0] + u[3] * at.sin - u[4] * at.cos
    } else {
        u[0]
    };
    let radial = if D >= 3 {
        u[1] * at.cos + u[2] * at.sin
    } else {
        T::ZERO
    };
    [axial, radial]
}

#[inline(never)]
pub fn dot5<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> T {
    let mut sum = T::ZERO;
    for (x, y) in a.iter().zip(b) {
        sum += *x * *y;
    }
    sum
}

pub fn norm<T: Real, const D: usize>(f: &[T; D]) -> T {
    if D == 1 {
        return f[0].abs();
    }
    dot5(f, f).sqrt()
}

/// A bound on how far a displacement of the ring shifts any groove centre.
pub fn span<T: Real, const D: usize>(u: &[T; D]) -> T {
    let mut axial = u[0].abs();
    if D == 5 {
        axial += (u[3] * u[3] + u[4] * u[4]).sqrt();
    }
    if D >= 3 {
        return axial.at_least((u[1] * u[1] + u[2] * u[2]).sqrt());
    }
    axial
}

/// The side of the grooves on which an axial load presses the balls: 1 for that of the free contact angle.
pub fn side<T: Real, const D: usize>(load: &[T; D]) -> T {
    if load[0] < T::ZERO { -T::ONE } else { T::ONE }
}

/// Adds one ball's force and couple to those on the ring.
#[inline(always)]
pub fn spread<T: Real, const D: usize>(
    sum: &mut [T; D],
    at: &Azimuth<T>,
    force: Pair<T>,
    couple: T,
) {
    let [fa, fr] = force;
    sum[0] += fa;
    if D >= 3 {
        sum[1] += fr * at.cos;
        sum[2] += fr * at.sin;
    }
    if D == 5 {
        let moment = fa - couple;
        sum[3] += moment * at.sin;
        sum[4] -= moment * at.cos;
    }
}

/// What a step of ring and balls changes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Change<T> {
    /// Largest step of a ball.
    pub step: T,
    /// Change of stiffness, axial and radial, summed over the balls.
    pub stiffness: Pair<T>,
    /// The part of it that a correction of the tangent does not know.
    pub remainder: Pair<T>,
    /// `Q'^2 / Q` of the inner contacts, summed over the balls: three times the growth of their stiffness with
    /// their deformation. Not known of a ball at speed that follows its law, whose step is hardly ever the
    /// last.
    pub hardening: T,
}

impl<T: Real> Change<T> {
    /// Adds another ball's.
    #[inline(always)]
    pub fn merge(&mut self, other: Self) {
        self.step = self.step.at_least(other.step);
        self.stiffness = add(self.stiffness, other.stiffness);
        self.remainder = add(self.remainder, other.remainder);
        self.hardening += other.hardening;
    }
}

/// Sums over the azimuth. The tangent needs 21 of them: each element of a ball's `H` is weighted by
/// 1, the cosine and sine, or their products, and the tilts use the same sums as axial and radial
/// motion. Without tilts 8 are left, of axial motion alone 1. Where all tangents are `symmetric` (at rest),
/// those of [`TangentSums`] do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sums<T, const D: usize> {
    force: [T; D],
    /// Radial force and moment that all balls may have in common, and what they have beyond.
    common: Pair<T>,
    beyond: Pair<T>,
    axial_axial: [T; 3],
    axial_radial: [T; 2],
    radial_axial: [T; 5],
    radial_radial: [T; 3],
    moment_axial: [T; 5],
    moment_radial: [T; 3],
    symmetric: TangentSums<T, D>,
}

impl<T: Real, const D: usize> Sums<T, D> {
    /// No balls yet. Radial force and moment are counted from `common`, about the mean of the
    /// balls: cosines and sines add up to 0 over the azimuth, but rounded ones do not quite, and what
    /// is left of a common force would tilt the ring, in single precision by more than a light
    /// load shifts it.
    pub fn about(common: Pair<T>) -> Self {
        Self {
            force: [T::ZERO; D],
            common,
            beyond: [T::ZERO; 2],
            axial_axial: [T::ZERO; 3],
            axial_radial: [T::ZERO; 2],
            radial_axial: [T::ZERO; 5],
            radial_radial: [T::ZERO; 3],
            moment_axial: [T::ZERO; 5],
            moment_radial: [T::ZERO; 3],
            symmetric: TangentSums::new(),
        }
    }

    /// Adds one ball.
    #[inline(always)]
    pub fn add(&mut self, at: &Azimuth<T>, ball: &Share<T>, symmetric: bool) {
        let (c, s) = (at.cos, at.sin);
        let [fa, fr] = ball.force;
        let [[aa, ar], [ra, rr]] = ball.stiffness;
        self.force[0] += fa;
        if D >= 3 {
            let fr = fr - self.common[0];
            self.beyond[0] += fr;
            self.force[1] += fr * c;
            self.force[2] += fr * s;
        }
        if D == 5 {
            let moment = fa - ball.couple - self.common[1];
            self.beyond[1] += moment;
            self.force[3] += moment * s;
            self.force[4] -= moment * c;
        }
        if symmetric {
            self.symmetric.add(at, &[aa, ar, rr]);
            return;
        }
        self.axial_axial[0] += aa;
        if D >= 3 {
            self.axial_radial[0] += ar * c;
            self.axial_radial[1] += ar * s;
            let (ra_c, ra_s) = (ra * c, ra * s);
            self.radial_axial[0] += ra_c;
            self.radial_axial[1] += ra_s;
            let (rr_c, rr_s) = (rr * c, rr * s);
            self.radial_radial[0] += rr_c * c;
            self.radial_radial[1] += rr_c * s;
            self.radial_radial[2] += rr_s * s;
            if D == 5 {
                let ma = aa - ball.couple_slope[0];
                let mr = ar - ball.couple_slope[1];
                self.axial_axial[1] += aa * c;
                self.axial_axial[2] += aa * s;
                self.radial_axial[2] += ra_c * c;
                self.radial_axial[3] += ra_c * s;
                self.radial_axial[4] += ra_s * s;
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
        }
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
    pub fn force(&self) -> [T; D] {
        self.force
    }

    /// The tangent.
    #[inline]
    pub fn tangent(&self, symmetric: bool) -> Tangent<T, D> {
        if symmetric {
            return self.symmetric.tangent();
        }
        let [aa, aa_c, aa_s] = self.axial_axial;
        let [ar_c, ar_s] = self.axial_radial;
        let [ra_c, ra_s, ra_cc, ra_cs, ra_ss] = self.radial_axial;
        let [rr_cc, rr_cs, rr_ss] = self.radial_radial;
        let [ma_c, ma_s, ma_cc, ma_cs, ma_ss] = self.moment_axial;
        let [mr_cc, mr_cs, mr_ss] = self.moment_radial;
        first(&[
            [aa, ar_c, ar_s, aa_s, -aa_c],
            [ra_c, rr_cc, rr_cs, ra_cs, -ra_cc],
            [ra_s, rr_cs, rr_ss, ra_ss, -ra_cs],
            [ma_s, mr_cs, mr_ss, ma_ss, -ma_cs],
            [-ma_c, -mr_cc, -mr_cs, -ma_cs, ma_cc],
        ])
    }
}

/// Sums over the azimuth of symmetric tangents that come without a couple, so that moments follow axial
/// forces: 14 of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentSums<T, const D: usize> {
    axial: [T; 6],
    mixed: [T; 5],
    radial: [T; 3],
}

impl<T: Real, const D: usize> TangentSums<T, D> {
    /// No balls yet.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            axial: [T::ZERO; 6],
            mixed: [T::ZERO; 5],
            radial: [T::ZERO; 3],
        }
    }

    /// Adds one ball: the axial element of its tangent, the mixed one and the radial one.
    #[inline(always)]
    pub fn add(&mut self, at: &Azimuth<T>, [axial, mixed, radial]: &[T; 3]) {
        let (c, s) = (at.cos, at.sin);
        let weighted = |x: T| {
            let (by_c, by_s) = (x * c, x * s);
            [by_c, by_s, by_c * c, by_c * s, by_s * s]
        };
        let add = |sums: &mut [T], more: &[T]| {
            for (sum, more) in sums.iter_mut().zip(more) {
                *sum += *more;
            }
        };
        self.axial[0] += *axial;
        if D >= 3 {
            let needed = if D == 5 { 5 } else { 2 };
            add(&mut self.mixed[..needed], &weighted(*mixed));
            add(&mut self.radial, &weighted(*radial)[2..]);
        }
        if D == 5 {
            add(&mut self.axial[1..], &weighted(*axial));
        }
    }

    /// The tangent.
    #[inline(always)]
    pub fn tangent(&self) -> Tangent<T, D> {
        let [aa, aa_c, aa_s, aa_cc, aa_cs, aa_ss] = self.axial;
        let [ar_c, ar_s, ar_cc, ar_cs, ar_ss] = self.mixed;
        let [rr_cc, rr_cs, rr_ss] = self.radial;
        first(&[
            [aa, ar_c, ar_s, aa_s, -aa_c],
            [ar_c, rr_cc, rr_cs, ar_cs, -ar_cc],
            [ar_s, rr_cs, rr_ss, ar_ss, -ar_cs],
            [aa_s, ar_cs, ar_ss, aa_ss, -aa_cs],
            [-aa_c, -ar_cc, -ar_cs, -aa_cs, aa_cc],
        ])
    }
}

/// The rows and columns that there are.
#[inline(always)]
fn first<T: Real, const D: usize>(all: &Tangent<T, 5>) -> Tangent<T, D> {
    let mut tangent = [[T::ZERO; D]; D];
    for (row, of_all) in tangent.iter_mut().zip(all) {
        for (element, of_all) in row.iter_mut().zip(of_all) {
            *element = *of_all;
        }
    }
    tangent
}

/// Units of a freedom's displacement and force, SI.
#[inline(always)]
pub fn units<T: Real, const D: usize>(c: &Constants<T>, freedom: usize) -> (T, T) {
    if freedom >= 3 {
        (c.tilt, c.moment)
    } else if D == 1 {
        (c.length, c.force * c.balls)
    } else {
        (c.length, c.force)
    }
}

/// Displacement in the bearing's own coordinates, SI, from that of the groove plane.
#[inline]
pub fn displacement_out<T: Real, const D: usize>(c: &Constants<T>, u: &[T; D]) -> [T; D] {
    let mut out = *u;
    if D == 5 {
        out[1] -= c.plane * u[4];
        out[2] += c.plane * u[3];
    }
    for (i, x) in out.iter_mut().enumerate() {
        *x = *x * units::<T, D>(c, i).0;
    }
    out
}

/// The inverse of [`displacement_out`].
#[inline]
pub fn displacement_in<T: Real, const D: usize>(c: &Constants<T>, u: &[T; D]) -> [T; D] {
    let mut v = *u;
    for (i, x) in v.iter_mut().enumerate() {
        *x = *x / units::<T, D>(c, i).0;
    }
    if D == 5 {
        v[1] += c.plane * v[4];
        v[2] -= c.plane * v[3];
    }
    v
}

/// Load on the groove plane from the load on the bearing centre, SI: a radial force acts there with
/// the lever arm of the plane.
#[inline]
pub fn load_in<T: Real, const D: usize>(c: &Constants<T>, load: &[T; D]) -> [T; D] {
    let mut f = *load;
    for (i, x) in f.iter_mut().enumerate() {
        *x = *x / units::<T, D>(c, i).1;
    }
    if D == 5 {
        f[3] += c.plane * f[2];
        f[4] -= c.plane * f[1];
    }
    f
}

/// The inverse of [`load_in`].
#[inline]
pub fn load_out<T: Real, const D: usize>(c: &Constants<T>, f: &[T; D]) -> [T; D] {
    let mut out = *f;
    if D == 5 {
        out[3] -= c.plane * f[2];
        out[4] += c.plane * f[1];
    }
    for (i, x) in out.iter_mut().enumerate() {
        *x = *x * units::<T, D>(c, i).1;
    }
    out
}

/// Stiffness at the bearing centre, SI, from the tangent at the groove plane.
#[inline]
pub fn stiffness_out<T: Real, const D: usize>(
    c: &Constants<T>,
    tangent: &Tangent<T, D>,
) -> Tangent<T, D> {
    let mut k = *tangent;
    if D == 5 {
        // Columns: a tilt of the bearing centre moves the groove plane sideways.
        for row in &mut k {
            row[3] -= c.plane * row[2];
            row[4] += c.plane * row[1];
        }
        for j in 0..D {
            k[3][j] -= c.plane * k[2][j];
            k[4][j] += c.plane * k[1][j];
        }
    }
    let (_, force) = units::<T, D>(c, 0);
    let per_length = force / c.length;
    let by_tilt = force / c.tilt;
    let moment = c.moment / c.length;
    let moment_by_tilt = c.moment / c.tilt;
    for (i, row) in k.iter_mut().enumerate() {
        for (j, element) in row.iter_mut().enumerate() {
            *element = *element
                * match (i < 3, j < 3) {
                    (true, true) => per_length,
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
pub struct Factors<T, const D: usize> {
    lu: Tangent<T, D>,
    inverse_pivot: [T; D],
}

impl<T: Real, const D: usize> Factors<T, D> {
    /// Factorises. A pivot smaller than `least` of its diagonal element is replaced by that element,
    /// so that the step stays bounded, and reported.
    #[inline(always)]
    pub fn of(tangent: &Tangent<T, D>, least: T) -> (Self, Definite) {
        Self::damped(tangent, T::ZERO, least)
    }

    /// The same, with `damping` on the diagonal.
    #[inline]
    pub fn damped(tangent: &Tangent<T, D>, damping: T, least: T) -> (Self, Definite) {
        let mut lu = *tangent;
        for (i, row) in lu.iter_mut().enumerate() {
            row[i] += damping;
        }
        let mut inverse_pivot = [T::ZERO; D];
        let mut definite = Definite::Positive;
        for k in 0..D {
            let diagonal = (tangent[k][k] + damping).abs();
            let pivot = lu[k][k];
            if !(pivot.abs() > least * diagonal) || !(pivot.abs() > T::TINY) {
                if definite == Definite::Positive {
                    definite = Definite::Semi;
                }
                lu[k][k] = diagonal.at_least(T::EPSILON);
            } else if pivot < T::ZERO {
                definite = Definite::No;
            }
            let inverse = T::ONE / lu[k][k];
            inverse_pivot[k] = inverse;
            for i in k + 1..D {
                let factor = lu[i][k] * inverse;
                lu[i][k] = factor;
                for j in k + 1..D {
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
            largest = largest.at_least(inverse.abs());
        }
        largest
    }

    /// Solves `K x = b`.
    #[inline]
    pub fn solve(&self, b: &[T; D]) -> [T; D] {
        let mut x = *b;
        for i in 1..D {
            for j in 0..i {
                let known = x[j];
                x[i] -= self.lu[i][j] * known;
            }
        }
        for i in (0..D).rev() {
            for j in i + 1..D {
                let known = x[j];
                x[i] -= self.lu[i][j] * known;
            }
            x[i] = x[i] * self.inverse_pivot[i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symmetric_sums_are_the_sums_of_symmetric_tangents() {
        let mut all = [(); 2].map(|()| Sums::<f64, 5>::about([0.3, -0.2]));
        for j in 0..7 {
            let phi = 0.1 + f64::from(j) * core::f64::consts::TAU / 7.0;
            let at = Azimuth {
                cos: phi.cos(),
                sin: phi.sin(),
                cos_low: 0.0,
                sin_low: 0.0,
            };
            let j = f64::from(j);
            let ball = Share {
                force: [1.0 + j, 2.0 - 0.3 * j],
                stiffness: [[3.0 + j * j, 0.7 - j], [0.7 - j, 1.0 + 2.0 * j]],
                ..Share::NONE
            };
            for (sums, symmetric) in all.iter_mut().zip([false, true]) {
                sums.add(&at, &ball, symmetric);
            }
        }
        let [general, symmetric] = all;
        assert_eq!(general.force(), symmetric.force());
        assert_eq!(general.mean(7.0), symmetric.mean(7.0));
        let tangent = symmetric.tangent(true);
        assert_eq!(general.tangent(false), tangent);
        for i in 0..5 {
            for j in 0..5 {
                assert_eq!(tangent[i][j], tangent[j][i]);
            }
        }
    }
}
