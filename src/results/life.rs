//! Rating life of a bearing from the forces on its balls.

use crate::const_math::{cbrt, pow, sin_cos};
use crate::design::{Design, FreeContact};
use crate::real::Real;
use core::f64::consts::PI;

/// Dynamic load ratings of the contacts of a bearing, N: what [`Balls::rating_life`](crate::Balls::rating_life) takes.
///
/// ISO/TS 16281:2008, point contact, inner ring turning, with `S` as for [`Design::dynamic_load_rating`]:
///
/// ```text
/// Qci = C / (0.407 Z (cos a)^0.7) (1 + [1.044 S]^(10/3))^(3/10)
/// Qce = C / (0.389 Z (cos a)^0.7) (1 + [1.044 S]^(-10/3))^(3/10)
/// ```
///
/// Every point of the inner race sees all balls in turn, a point of the outer race always the force at its own azimuth:
///
/// ```text
/// qei = (sum Qij^3 / Z)^(1/3)                     qee = (sum Qej^(10/3) / Z)^(3/10)
/// L10 = [(qei/Qci)^(10/3) + (qee/Qce)^(10/3)]^(-9/10)      million revolutions
/// ```
///
/// Over the rows of a spindle the terms in brackets add up. A tenth of all such sets then have a first failure of any row within
/// `L10`. Lubrication, contamination and the fatigue limit (`a_ISO`) are left out.
///
/// ```
/// use spindle_bearing::{Bearing, Design, LifeRating, Settings, Solver, Speed};
///
/// const B7005C: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// static BEARING: Bearing<f64, 16> = Bearing::<f64, 16>::const_new(&B7005C);
/// // The catalogue's C, say 13,700 N. Without one: `B7005C.dynamic_load_rating(16)`.
/// const RATING: LifeRating<f64> = LifeRating::<f64>::new(&B7005C, 16, 13_700.0);
///
/// let mut solver = Solver::new();
/// let (load, speed) = ([400.0, 300.0, 0.0, 0.0, 0.0], Speed::rpm(12_000.0));
/// let life = solver.solve(&BEARING, load, speed, &Settings::default())?.rating_life(&RATING);
/// println!("L10 = {:.0} million revolutions, L10h = {:.0} h", life.million_revolutions, life.hours);
/// assert!((life.hours * 60.0 * 0.012 / life.million_revolutions - 1.0).abs() < 1e-12);
/// # Ok::<(), spindle_bearing::Status<f64>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LifeRating<T = f32> {
    /// `Qci`, N: the inner contact's dynamic load rating.
    pub inner: T,
    /// `Qce`, N: the outer contact's.
    pub outer: T,
}

/// Basic rating life under a constant load at a constant speed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "T: crate::serialize::Written",
        deserialize = "T: crate::serialize::Read<'de>"
    ))
)]
#[non_exhaustive]
pub struct RatingLife<T> {
    /// `L10`, million revolutions; infinite without forces.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub million_revolutions: T,
    /// `L10h`, hours at the speed of the solution; infinite at rest.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub hours: T,
}

/// Nominal `cos a` and `g`, and `S`; none of a design that is out of its ranges.
const fn geometry(design: &Design) -> Option<(f64, f64, f64)> {
    if design.check_form().is_err() {
        return None;
    }
    let cos = match design.free_contact {
        FreeContact::Angle(angle) => sin_cos(angle).1,
        FreeContact::DiametralClearance(_) => 1.0,
    };
    let g = design.ball_diameter * cos / design.pitch_diameter;
    let (fi, fo) = (design.inner_groove_factor, design.outer_groove_factor);
    let osculation = fi * (2.0 * fo - 1.0) / (fo * (2.0 * fi - 1.0));
    let s = pow((1.0 - g) / (1.0 + g), 1.72) * pow(osculation, 0.41);
    Some((cos, g, s))
}

impl Design {
    /// Basic dynamic radial load rating `Cr` of a single-row bearing of `balls` balls, N, by the formula of ISO 281.
    ///
    /// Prefer a maker's catalogue where it gives `C`. With the close grooves of spindle bearings the formula is
    /// 5 % to 8 % high, and a life by it up to 25 % long. ISO 281:2007 with the factors of ISO/TR 1281-1, `D` in mm and up to
    /// 25.4 mm:
    ///
    /// ```text
    /// Cr = bm fc (cos a)^0.7 Z^(2/3) D^1.8            bm = 1.3
    /// fc = 0.41 A lambda (2 fi/(2 fi - 1))^0.41 g^0.3 (1 - g)^1.39 / (1 + g)^(1/3)
    ///      (1 + [1.04 S]^(10/3))^(-3/10)              A = 98.0665, lambda = 0.95
    /// S  = ((1 - g)/(1 + g))^1.72 (fi (2 fo - 1) / (fo (2 fi - 1)))^0.41
    /// g  = D cos a / dm
    /// ```
    ///
    /// `a` is the nominal contact angle, 0 for a bearing that is given by its clearance. A design whose balls or grooves
    /// [`Design::check`] refuses carries nothing: its rating is 0.
    pub const fn dynamic_load_rating(&self, balls: usize) -> f64 {
        let Some((cos, g, s)) = geometry(self) else {
            return 0.0;
        };
        let fi = self.inner_groove_factor;
        let z = balls as f64;
        let fc = 0.41
            * 98.0665
            * 0.95
            * pow(2.0 * fi / (2.0 * fi - 1.0), 0.41)
            * pow(g, 0.3)
            * pow(1.0 - g, 1.39)
            / cbrt(1.0 + g)
            * pow(1.0 + pow(1.04 * s, 10.0 / 3.0), -0.3);
        let d = self.ball_diameter * 1e3;
        1.3 * fc * pow(cos, 0.7) * cbrt(z * z) * pow(d, 1.8)
    }
}

/// `Qci` and `Qce`.
const fn contacts(design: &Design, balls: usize, dynamic_load_rating: f64) -> [f64; 2] {
    let Some((cos, _, s)) = geometry(design) else {
        return [0.0; 2];
    };
    if !(balls > 0 && dynamic_load_rating > 0.0) {
        return [0.0; 2];
    }
    let per_ball = dynamic_load_rating / (balls as f64 * pow(cos, 0.7));
    let ratio = pow(1.044 * s, 10.0 / 3.0);
    [
        per_ball / 0.407 * pow(1.0 + ratio, 0.3),
        per_ball / 0.389 * pow(1.0 + 1.0 / ratio, 0.3),
    ]
}

macro_rules! in_precision {
    ($t:ident) => {
        impl LifeRating<$t> {
            /// Ratings of the contacts for a bearing of this basic dynamic load rating `C` (N), from the maker's catalogue or
            /// from [`Design::dynamic_load_rating`]; 0 without a ball, without a positive `C`, and for a design that has none.
            pub const fn new(design: &Design, balls: usize, dynamic_load_rating: f64) -> Self {
                let [inner, outer] = contacts(design, balls, dynamic_load_rating);
                Self {
                    inner: inner as $t,
                    outer: outer as $t,
                }
            }
        }
    };
}
in_precision!(f32);
in_precision!(f64);

impl<T: Real> LifeRating<T> {
    /// [`LifeRating::weight`] of these inner and outer contact forces, N.
    pub fn weight_of(&self, forces: impl Iterator<Item = (T, T)>) -> T {
        let (mut inner, mut outer, mut balls) = (T::ZERO, T::ZERO, T::ZERO);
        for (q_i, q_o) in forces {
            let (i, o) = (T::ZERO.at_least(q_i), T::ZERO.at_least(q_o));
            inner += i * i * i;
            outer += o * o * o * o.cbrt_or_zero();
            balls += T::ONE;
        }
        self.weight(T::ONE, inner, outer, balls)
    }

    /// `(1 / L10)^(10/9)` of so many `balls`, per million revolutions: it adds up over a spindle's rows.
    /// `inner` is the sum of the inner contact forces cubed, `outer` of the outer forces to 10/3, in a `unit` (N). Infinite
    /// under a force, where a contact is rated for nothing.
    pub fn weight(&self, unit: T, inner: T, outer: T, balls: T) -> T {
        if !(balls > T::ZERO && inner + outer > T::ZERO) {
            return T::ZERO;
        }
        let (i, o) = (unit / self.inner, unit / self.outer);
        let per_ball = T::ONE / balls;
        let inner = i * i * i * (inner * per_ball);
        let outer = o * o * o * o.cbrt_or_zero() * (outer * per_ball);
        // (mean of cubes)^(10/9).
        let inner = inner * inner.cbrt_or_zero().cbrt_or_zero();
        let weight = inner + outer;
        // Of a contact that is rated for nothing, or more than the precision holds.
        if weight.is_finite() {
            weight
        } else {
            T::INFINITY
        }
    }
}

/// `1 / L10`, per million revolutions, of the sum of [`LifeRating::weight`] over all rows.
pub fn damage_of_weight<T: Real>(weight: T) -> T {
    if weight > T::ZERO {
        weight.powf(T::of(0.9))
    } else {
        T::ZERO
    }
}

impl<T: Real> RatingLife<T> {
    /// Of the sum of [`LifeRating::weight`] over all rows, at `omega` (rad/s).
    pub fn of_weight(weight: T, omega: T) -> Self {
        let million_revolutions = T::ONE / damage_of_weight(weight);
        // 1e6 revolutions of 2 pi rad, in hours of 3600 s.
        let hours = if omega.abs() > T::ZERO {
            million_revolutions * (T::of(2e6 * PI / 3600.0) / omega.abs())
        } else {
            T::INFINITY
        };
        Self {
            million_revolutions,
            hours,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With groove factors of 0.52.
    const fn bearing(ball_diameter: f64, pitch_diameter: f64, angle: f64) -> Design {
        Design {
            inner_groove_factor: 0.52,
            outer_groove_factor: 0.52,
            ..Design::angular_contact(ball_diameter, pitch_diameter, angle)
        }
    }

    /// 9 balls of 5/16 inch.
    const B6205: Design = Design {
        free_contact: FreeContact::DiametralClearance(10e-6),
        ..bearing(7.938e-3, 39.04e-3, 0.0)
    };

    #[test]
    fn fc_is_that_of_the_table_in_iso_281() {
        // D cos a / dm and fc for radial and angular contact groove ball bearings, fi = fo = 0.52.
        for (g, fc) in [
            (0.05, 46.7),
            (0.10, 55.5),
            (0.14, 58.8),
            (0.20, 59.9),
            (0.30, 56.0),
        ] {
            let rating = bearing(1e-3, 1e-3 / g, 0.0).dynamic_load_rating(1) / 1.3;
            assert!((rating / fc - 1.0).abs() < 2e-3, "{g}: {rating}, not {fc}");
        }
    }

    #[test]
    fn ratings_are_those_of_catalogues_within_a_few_per_cent() {
        // 6205: 14.0 kN in most catalogues; 7205 with 40 degrees, 13 balls of 7.938 mm on 39 mm: 14.8 kN.
        let b7205 = bearing(7.938e-3, 39e-3, 40_f64.to_radians());
        for (design, balls, catalogue) in [(B6205, 9, 14.0e3), (b7205, 13, 14.8e3)] {
            let rating = design.dynamic_load_rating(balls);
            assert!((rating / catalogue - 1.0).abs() < 0.06, "{rating}");
        }
    }

    /// ISO 281 by itself: under a radial load that half of the balls carry, `L10 = (Cr/Fr)^3`, which the sum
    /// over the balls must give, too.
    #[test]
    fn a_half_loaded_bearing_has_the_life_of_iso_281() {
        let balls = 720;
        let rating = B6205.dynamic_load_rating(balls);
        let life = LifeRating::<f32>::new(&B6205, balls, rating);
        let forces: std::vec::Vec<f32> = (0..balls)
            .map(|j| {
                let cos = (core::f32::consts::TAU * j as f32 / balls as f32).cos();
                cos.max(0.0).powf(1.5)
            })
            .collect();
        let carried: f32 = forces
            .iter()
            .enumerate()
            .map(|(j, q)| q * (core::f32::consts::TAU * j as f32 / balls as f32).cos())
            .sum();
        let load = 0.1 * rating as f32;
        let forces = forces.iter().map(|q| q * load / carried);
        let damage = damage_of_weight(life.weight_of(forces.map(|q| (q, q))));
        assert!((damage * 1000.0 - 1.0).abs() < 0.03, "{}", 1.0 / damage);
    }

    /// `Qce / Qci = 0.407 / (0.389 1.044 S)`: a life hardly shows it.
    #[test]
    fn the_contacts_are_rated_by_s_to_each_other() {
        let life = LifeRating::<f64>::new(&B6205, 9, 14e3);
        let g = B6205.ball_diameter / B6205.pitch_diameter;
        let s = ((1.0 - g) / (1.0 + g)).powf(1.72);
        let ratio = life.outer / life.inner * (0.389 / 0.407 * 1.044 * s);
        assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
    }

    #[test]
    fn damage_grows_with_the_cube_of_the_forces() {
        let life = LifeRating::<f32>::new(&B6205, 9, 14e3);
        let forces = [100.0_f32, 250.0, 0.0, 40.0];
        let of = |by: f32| {
            let forces = forces.iter().map(|q| (by * q, by * q + 1e-3));
            damage_of_weight(life.weight_of(forces))
        };
        assert!((of(2.0) / of(1.0) / 8.0 - 1.0).abs() < 1e-3);
        assert_eq!(life.weight_of(core::iter::empty()), 0.0);
        assert_eq!(life.weight_of([(0.0, 0.0)].into_iter()), 0.0);
        assert_eq!(damage_of_weight(0.0_f32), 0.0);
    }
}
