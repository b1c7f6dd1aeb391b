//! Rating life that has been used up, from the forces on the balls.
//!
//! # Rating
//!
//! The basic dynamic radial load rating of a single-row ball bearing, in N with `D` in mm (ISO 281:2007
//! with the factors of ISO/TR 1281-1; `D` up to 25.4 mm):
//!
//! ```text
//! Cr = bm fc (cos a)^0.7 Z^(2/3) D^1.8            bm = 1.3
//! fc = 0.41 A lambda (2 fi/(2 fi - 1))^0.41 g^0.3 (1 - g)^1.39 / (1 + g)^(1/3)
//!      (1 + [1.04 S]^(10/3))^(-3/10)              A = 98.0665, lambda = 0.95
//! S  = ((1 - g)/(1 + g))^1.72 (fi (2 fo - 1) / (fo (2 fi - 1)))^0.41
//! g  = D cos a / dm
//! ```
//!
//! and those of one contact of the rotating inner and the stationary outer ring (ISO/TS 16281:2008, point
//! contact):
//!
//! ```text
//! Qci = Cr / (0.407 Z (cos a)^0.7) (1 + [1.044 S]^(10/3))^(3/10)
//! Qce = Cr / (0.389 Z (cos a)^0.7) (1 + [1.044 S]^(-10/3))^(3/10)
//! ```
//!
//! `a` is the nominal contact angle, 0 for a bearing that is given by its clearance.
//!
//! # Life
//!
//! Every point of the inner race sees all balls in turn, a point of the outer race always the same one's
//! azimuth (ISO/TS 16281):
//!
//! ```text
//! qei = (sum Qij^3 / Z)^(1/3)                     qee = (sum Qej^(10/3) / Z)^(3/10)
//! L10 = [(qei/Qci)^(10/3) + (qee/Qce)^(10/3)]^(-9/10)      million revolutions
//! ```
//!
//! What is used up adds up by revolutions (Palmgren 1924, Miner 1945): `sum dn / (1e6 L10)`, 1 when
//! a tenth of such bearings are expected to have failed. Lubrication, contamination and the fatigue
//! limit (`a_ISO`) are left out: at the clean, light loads of a spindle they lengthen life, in bad grease they
//! shorten it, and nothing on the board measures them.
//!
//! # Without an estimate
//!
//! Forces on the balls grow no faster than all five loads together do: the contact angle opens, and more balls carry. So
//! `s` times the loads use up `s^3` times the life at most; twice the loads of B7005C use up 4.9 to 7.9 times as much
//! (`host_tests/tests/all/life.rs`). Where only range or rate speak against a sample, the loads are scaled into the
//! range and solved there, for the life alone. Where a solve has not ended, the last loads are scaled to the measured ones. Smaller
//! measured loads, or none that can be believed, leave the rate as it was. [`Life::estimated`] has what was counted so.
//!
//! An increment is some 1e-13, and there are 86 million of them in a day: in single precision the sum would
//! stop growing. [`ExactSum`] adds them up as whole numbers, without any rounding.

use crate::design::{Design, FreeContact};
use crate::elementary::{cbrt, pow, sin_cos};
use crate::float::Real;

/// Sum of non-negative numbers that rounds nothing down to `2^-FRACTION`, and stops at its largest value,
/// `2^(128 - FRACTION)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ExactSum<const FRACTION: u32>(u128);

impl<const FRACTION: u32> ExactSum<FRACTION> {
    /// Nothing yet.
    pub const ZERO: Self = Self(0);

    /// The sum that [`ExactSum::bits`] has given: to go on after a power cycle.
    pub const fn from_bits(bits: u128) -> Self {
        Self(bits)
    }

    /// The sum in units of `2^-FRACTION`.
    pub const fn bits(self) -> u128 {
        self.0
    }

    /// Adds a number. One that is negative, or none, adds nothing; an infinite one makes the largest sum.
    pub const fn add(&mut self, x: f32) {
        if !(x > 0.0) {
            return;
        }
        let bits = x.to_bits();
        let exponent = bits >> 23;
        let fraction = bits & 0x7f_ffff;
        // x = mantissa 2^(exponent - 150); subnormal numbers share the smallest exponent.
        let (mantissa, exponent) = if exponent == 0 {
            (fraction, 1)
        } else {
            (fraction | 0x80_0000, exponent)
        };
        let left = exponent as i32 - 150 + FRACTION as i32;
        let wide = mantissa as u128;
        let added = if left >= 104 {
            u128::MAX
        } else if left >= 0 {
            wide << left
        } else if left > -24 {
            wide >> -left
        } else {
            0
        };
        self.0 = self.0.saturating_add(added);
    }

    /// The whole part.
    pub const fn whole(self) -> u64 {
        let whole = self.0 >> FRACTION;
        if whole > u64::MAX as u128 {
            u64::MAX
        } else {
            whole as u64
        }
    }

    /// The sum, rounded.
    pub fn value(self) -> f32 {
        // The highest 32 bits that are in use, and where they stand.
        let shift = (128 - self.0.leading_zeros()).saturating_sub(32);
        let mut value = (self.0 >> shift) as u32 as f32;
        let mut exponent = shift as i32 - FRACTION as i32;
        while exponent > 0 {
            value *= 2.0;
            exponent -= 1;
        }
        while exponent < 0 {
            value *= 0.5;
            exponent += 1;
        }
        value
    }
}

/// Ratings of a bearing, worked out by the compiler from its design.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LifeRating {
    /// `Qci`, N: the inner contact's dynamic load rating.
    pub inner: f32,
    /// `Qce`, N: the outer contact's.
    pub outer: f32,
}

/// Nominal `cos a` and `g`, and `S`.
const fn geometry(design: &Design) -> (f64, f64, f64) {
    let cos = match design.free_contact {
        FreeContact::Angle(angle) => sin_cos(angle).1,
        FreeContact::DiametralClearance(_) => 1.0,
    };
    let g = design.ball_diameter * cos / design.pitch_diameter;
    let (fi, fo) = (design.inner_groove_factor, design.outer_groove_factor);
    let osculation = fi * (2.0 * fo - 1.0) / (fo * (2.0 * fi - 1.0));
    let s = pow((1.0 - g) / (1.0 + g), 1.72) * pow(osculation, 0.41);
    (cos, g, s)
}

impl LifeRating {
    /// Basic dynamic radial load rating `Cr` of a single-row bearing of `balls` balls, N. See the
    /// module for the formula; a maker's catalogue may say some per cent more for better steel.
    pub const fn basic_dynamic_load_rating(design: &Design, balls: usize) -> f64 {
        let (cos, g, s) = geometry(design);
        let fi = design.inner_groove_factor;
        let z = balls as f64;
        let fc = 0.41
            * 98.0665
            * 0.95
            * pow(2.0 * fi / (2.0 * fi - 1.0), 0.41)
            * pow(g, 0.3)
            * pow(1.0 - g, 1.39)
            / cbrt(1.0 + g)
            * pow(1.0 + pow(1.04 * s, 10.0 / 3.0), -0.3);
        let d = design.ball_diameter * 1e3;
        1.3 * fc * pow(cos, 0.7) * cbrt(z * z) * pow(d, 1.8)
    }

    /// Ratings of the contacts for a bearing of this rating `Cr` (N), from the catalogue or from
    /// [`LifeRating::basic_dynamic_load_rating`].
    pub const fn new(design: &Design, balls: usize, dynamic_load_rating: f64) -> Self {
        let (cos, _, s) = geometry(design);
        let per_ball = dynamic_load_rating / (balls as f64 * pow(cos, 0.7));
        let ratio = pow(1.044 * s, 10.0 / 3.0);
        Self {
            inner: (per_ball / 0.407 * pow(1.0 + ratio, 0.3)) as f32,
            outer: (per_ball / 0.389 * pow(1.0 + 1.0 / ratio, 0.3)) as f32,
        }
    }

    /// `1 / L10` under these inner and outer contact forces (N), per million revolutions.
    pub fn damage(&self, forces: impl Iterator<Item = (f32, f32)>) -> f32 {
        damage_of_weight(self.weight_of(forces))
    }

    /// [`LifeRating::weight`] of these forces.
    pub(super) fn weight_of(&self, forces: impl Iterator<Item = (f32, f32)>) -> f32 {
        let (mut inner, mut outer, mut balls) = (0.0_f32, 0.0_f32, 0.0_f32);
        for (q_i, q_o) in forces {
            let (i, o) = (0.0_f32.at_least(q_i), 0.0_f32.at_least(q_o));
            inner += i * i * i;
            outer += o * o * o * Real::cbrt(o);
            balls += 1.0;
        }
        self.weight(1.0, inner, outer, balls)
    }

    /// `(1 / L10)^(10/9)` of so many `balls`, per million revolutions: what adds up over the rows of a spindle. From the sum
    /// of the cubes of the inner contact forces, and from that of the outer ones to 10/3, forces in a `unit` (N).
    pub fn weight(&self, unit: f32, inner: f32, outer: f32, balls: f32) -> f32 {
        if !(balls > 0.0) {
            return 0.0;
        }
        let (i, o) = (unit / self.inner, unit / self.outer);
        let per_ball = 1.0 / balls;
        let inner = i * i * i * (inner * per_ball);
        let outer = o * o * o * Real::cbrt(o) * (outer * per_ball);
        // (mean of cubes)^(10/9).
        let inner = inner * Real::cbrt(Real::cbrt(inner));
        inner + outer
    }
}

/// `1 / L10`, per million revolutions, of the sum of [`LifeRating::weight`] over all rows.
pub fn damage_of_weight(weight: f32) -> f32 {
    if weight > 0.0 {
        libm::powf(weight, 0.9)
    } else {
        0.0
    }
}

/// Life that has been used up.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Life {
    used: ExactSum<96>,
    revolutions: ExactSum<64>,
    doubtful: ExactSum<64>,
    /// The part of `used` that was counted without an estimate of the tick, since the start.
    estimated: ExactSum<96>,
    /// Damage per million revolutions under the last loads that were solved, and the part of their range that these
    /// took.
    rate: f32,
    solved: f32,
    /// The part of their range that the measured loads take; 0 if they cannot be believed.
    measured: f32,
}

/// Measured loads count as so many times their range, and those that were solved, at most: what is farther off is no
/// load.
pub(super) const LARGEST_GROWTH: f32 = 10.0;

impl Life {
    /// A new bearing.
    pub const NEW: Self = Self {
        used: ExactSum::ZERO,
        revolutions: ExactSum::ZERO,
        doubtful: ExactSum::ZERO,
        estimated: ExactSum::ZERO,
        rate: 0.0,
        solved: 0.0,
        measured: 0.0,
    };

    /// A bearing that has this behind it ([`Life::kept`]).
    pub const fn resume(used: u128, revolutions: u128) -> Self {
        Self {
            used: ExactSum::from_bits(used),
            revolutions: ExactSum::from_bits(revolutions),
            ..Self::NEW
        }
    }

    /// Life used and revolutions, to be kept over a power cycle.
    pub const fn kept(&self) -> (u128, u128) {
        (self.used.bits(), self.revolutions.bits())
    }

    /// From now on, these forces act. `damage` as of [`LifeRating::damage`]; what is no number changes nothing.
    pub const fn set_damage(&mut self, damage: f32) {
        if damage.is_finite() {
            (self.rate, self.solved) = (damage, self.measured);
        }
    }

    /// The measured loads take this part of their range
    /// ([`PlausibilitySettings::part`](super::plausibility::PlausibilitySettings::part)); 0 if they cannot be believed.
    pub const fn measure(&mut self, part: f32) {
        self.measured = part;
    }

    /// The shaft has turned on at `speed` (rad/s) for `time` (s). `doubtful` if speed or forces are those of
    /// an older sample.
    pub fn turn(&mut self, speed: f32, time: f32, doubtful: bool) {
        let revolutions = speed.abs() * time * (0.5 * core::f32::consts::FRAC_1_PI);
        self.revolutions.add(revolutions);
        let used = revolutions * 1e-6 * self.rate;
        if !doubtful {
            self.used.add(used);
            return;
        }
        let growth = 1.0_f32
            .at_least(self.measured / self.solved)
            .at_most(LARGEST_GROWTH);
        let used = used * growth * growth * growth;
        self.used.add(used);
        self.estimated.add(used);
        self.doubtful.add(revolutions);
    }

    /// The part of [`Life::used`] that was counted without an estimate of the tick, since the start: an upper bound.
    pub fn estimated(&self) -> f32 {
        self.estimated.value()
    }

    /// Rating life used up, a part of 1.
    pub fn used(&self) -> f32 {
        self.used.value()
    }

    /// Revolutions of the shaft.
    pub const fn revolutions(&self) -> u64 {
        self.revolutions.whole()
    }

    /// Revolutions at a doubtful speed or under doubtful loads.
    pub const fn doubtful_revolutions(&self) -> u64 {
        self.doubtful.whole()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::Material;

    const fn bearing(
        ball_diameter: f64,
        pitch_diameter: f64,
        factors: [f64; 2],
        free_contact: FreeContact,
    ) -> Design {
        Design {
            ball_diameter,
            pitch_diameter,
            inner_groove_factor: factors[0],
            outer_groove_factor: factors[1],
            free_contact,
            inner_shoulder_angle: Design::HIGHEST_SHOULDER,
            outer_shoulder_angle: Design::HIGHEST_SHOULDER,
            first_ball: 0.0,
            ring: Material::STEEL,
            ball: Material::STEEL,
        }
    }

    /// 9 balls of 5/16 inch.
    const B6205: Design = bearing(
        7.938e-3,
        39.04e-3,
        [0.52, 0.52],
        FreeContact::DiametralClearance(10e-6),
    );

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
            let design = bearing(
                1e-3,
                1e-3 / g,
                [0.52, 0.52],
                FreeContact::DiametralClearance(0.0),
            );
            let rating = LifeRating::basic_dynamic_load_rating(&design, 1) / 1.3;
            assert!((rating / fc - 1.0).abs() < 2e-3, "{g}: {rating}, not {fc}");
        }
    }

    #[test]
    fn ratings_are_those_of_catalogues_within_a_few_per_cent() {
        // 6205: 14.0 kN in most catalogues; 7205 with 40 degrees, 13 balls of 7.938 mm on 39 mm: 14.8 kN.
        let b7205 = bearing(
            7.938e-3,
            39e-3,
            [0.52, 0.52],
            FreeContact::Angle(40.0 * core::f64::consts::PI / 180.0),
        );
        for (design, balls, catalogue) in [(B6205, 9, 14.0e3), (b7205, 13, 14.8e3)] {
            let rating = LifeRating::basic_dynamic_load_rating(&design, balls);
            assert!((rating / catalogue - 1.0).abs() < 0.06, "{rating}");
        }
    }

    /// ISO 281 by itself: under a radial load that half of the balls carry, `L10 = (Cr/Fr)^3`, which the sum
    /// over the balls must give, too.
    #[test]
    fn a_half_loaded_bearing_has_the_life_of_iso_281() {
        let balls = 720;
        let rating = LifeRating::basic_dynamic_load_rating(&B6205, balls);
        let life = LifeRating::new(&B6205, balls, rating);
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
        let damage = life.damage(
            forces
                .iter()
                .map(|q| (q * load / carried, q * load / carried)),
        );
        assert!((damage * 1000.0 - 1.0).abs() < 0.03, "{}", 1.0 / damage);
    }

    #[test]
    fn damage_grows_with_the_cube_of_the_forces() {
        let life = LifeRating::new(&B6205, 9, 14e3);
        let forces = [100.0_f32, 250.0, 0.0, 40.0];
        let of = |by: f32| life.damage(forces.iter().map(|q| (by * q, by * q + 1e-3)));
        assert!((of(2.0) / of(1.0) / 8.0 - 1.0).abs() < 1e-3);
        assert_eq!(life.damage(core::iter::empty()), 0.0);
        assert_eq!(life.damage([(0.0, 0.0)].into_iter()), 0.0);
    }

    #[test]
    fn a_sum_rounds_nothing_and_neither_overflows_nor_takes_nonsense() {
        let mut sum = ExactSum::<96>::ZERO;
        let step = 3.1e-13_f32;
        for _ in 0..1_000_000 {
            sum.add(step);
        }
        assert_eq!(
            sum.bits(),
            1_000_000 * {
                let mut one = ExactSum::<96>::ZERO;
                one.add(step);
                one.bits()
            }
        );
        assert!((f64::from(sum.value()) / (1e6 * f64::from(step)) - 1.0).abs() < 1e-7);
        for nonsense in [f32::NAN, -1.0, -0.0, 0.0, f32::NEG_INFINITY] {
            let before = sum;
            sum.add(nonsense);
            assert_eq!(sum, before);
        }
        for (x, whole) in [(1.0_f32, 1), (1e9, 1_000_000_000), (0.999_999_9, 0)] {
            let mut sum = ExactSum::<64>::ZERO;
            sum.add(x);
            assert_eq!(sum.whole(), whole);
            assert_eq!(sum.value(), x);
        }
        sum.add(f32::INFINITY);
        assert_eq!(sum.bits(), u128::MAX);
        sum.add(1.0);
        assert_eq!(sum.bits(), u128::MAX);
    }

    /// A century at 60,000 rpm.
    #[test]
    fn after_a_century_a_tick_still_counts() {
        let mut life = Life::resume(0, 3_155_760_000_000_u128 << 64);
        life.set_damage(1e-6);
        let (used, _) = life.kept();
        life.turn(6283.0, 1e-3, false);
        assert!(life.kept().0 > used);
        assert_eq!(life.revolutions(), 3_155_760_000_000);
        life.turn(6283.2, 1e-3, true);
        assert_eq!(life.revolutions(), 3_155_760_000_001);
        assert_eq!(life.doubtful_revolutions(), 1);
    }
}
