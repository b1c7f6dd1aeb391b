//! Rating life that has been used up, from the forces on the balls.
//!
//! [`LifeRating`](spindle_bearing::LifeRating) has the formulas of the rating life.
//!
//! # Life
//!
//! Used life adds up by revolutions (Palmgren 1924, Miner 1945): `sum dn / (1e6 L10)`, 1 when
//! a tenth of such bearings are expected to have failed. Lubrication, contamination and the fatigue
//! limit (`a_ISO`) are left out. At the clean, light loads of a spindle they lengthen life, in bad grease they
//! shorten it. Nothing on the board measures them.
//!
//! # Without an estimate
//!
//! Forces on the balls grow no faster than all five loads together do: the contact angle opens, and more balls carry. So
//! `s` times the loads use up `s^3` times the life at most. Twice the loads of B7005C use up 4.9 to 7.9 times as much
//! (`examples/monitor/tests/all/life.rs`). Where only range or rate speak against a sample, the loads are scaled into the
//! range and solved there, for the life alone. Where a sample is not solved, or not yet, the damage `d` per revolution follows from the
//! last one that was, `d_s`:
//!
//! ```text
//! d = k^3 (p^2 + x^2)^(3/2)        d^(2/3) = d_s^(2/3) + k^2 (x^2 - x_s^2)        k^2 x_s^2 <= d_s^(2/3)
//! ```
//!
//! `x^2` is the sum of squares of the loads in parts of their ranges' larger bounds, and `p` the part that the preload stands for. `p`
//! is that of the present, with temperature and speed, since `d_s` is. `k` is a matter of geometry: the mounted spindle tells it, at
//! rest and cold. There, an axial load `F` on two sides that press each other with `P` makes `P + F/2` of one and `P - F/2` of the
//! other. The mean cube of the balls' forces grows as `1 + 3 (F/(2 P))^2`, so that `p` is `sqrt(2) P` over the bound of `F`. A radial
//! load on a row that is pressed with `P` does alike: `1 + 6 (F tan(a)/P)^2` while all balls carry, with a contact angle `a` of 15 to 25
//! degrees.
//!
//! Loads beyond their ranges leave the preload next to nothing: there, `p` is 0, and the cube of the loads counts.
//!
//! Measured loads that cannot be believed leave the rate as it was. [`Life::estimated`] has the life counted so.
//!
//! An increment is some 1e-13, and there are 86 million of them in a day: in single precision the sum would
//! stop growing. `Sum` adds them up as whole numbers, and carries what is left over to the next.

use spindle_bearing::{cbrt_f32, sqrt_f32};

/// Sum of non-negative numbers in units of `2^-FRACTION`, without a drift by rounding. It stops at its largest value,
/// `2^(64 - FRACTION)`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sum<const FRACTION: u32> {
    units: u64,
    /// Part of a unit that is left over.
    rest: f32,
}

impl<const FRACTION: u32> Sum<FRACTION> {
    /// Nothing yet.
    const ZERO: Self = Self::from_units(0);
    const UNITS_OF_ONE: f32 = (1_u64 << FRACTION) as f32;

    /// The sum that [`Sum::units`] has given: to go on after a power cycle.
    const fn from_units(units: u64) -> Self {
        Self { units, rest: 0.0 }
    }

    /// The sum in whole units.
    const fn units(self) -> u64 {
        self.units
    }

    /// Adds a number. One that is negative, or none, adds nothing; an infinite one makes the largest sum.
    const fn add(&mut self, x: f32) {
        if !(x > 0.0) {
            return;
        }
        let all = x * Self::UNITS_OF_ONE + self.rest;
        // The cast saturates.
        let units = all as u64;
        self.rest = if units < u64::MAX {
            all - units as f32
        } else {
            0.0
        };
        self.units = self.units.saturating_add(units);
    }

    /// The whole part.
    const fn whole(self) -> u64 {
        self.units >> FRACTION
    }

    /// The sum, rounded.
    const fn value(self) -> f32 {
        self.units as f32 / Self::UNITS_OF_ONE
    }
}

/// Life used, up to 256 of it, in units that a tick of the lightest load passes.
type Used = Sum<56>;
/// Revolutions, those of a century at 60,000 rpm.
type Revolutions = Sum<22>;

/// Life that has been used up.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Life {
    used: Used,
    revolutions: Revolutions,
    doubtful: Revolutions,
    /// The part of `used` that was counted between samples that were solved, since the start.
    estimated: Used,
    /// `d_s`: damage per million revolutions under the last loads that were solved, and `x_s^2` of these.
    rate: f32,
    solved: f32,
    /// `x^2` of the measured loads; none if they cannot be believed.
    measured: Option<f32>,
    /// `k^2`.
    slope: f32,
}

/// Most that measured loads count over their range, or over the solved loads; beyond is no load.
pub(crate) const LARGEST_GROWTH: f32 = 10.0;

impl Life {
    /// A new bearing.
    pub const NEW: Self = Self {
        used: Sum::ZERO,
        revolutions: Sum::ZERO,
        doubtful: Sum::ZERO,
        estimated: Sum::ZERO,
        rate: 0.0,
        solved: 0.0,
        measured: None,
        slope: 0.0,
    };

    /// A new bearing, under the loads of now.
    pub const fn renewed(&self) -> Self {
        Self {
            used: Sum::ZERO,
            revolutions: Sum::ZERO,
            doubtful: Sum::ZERO,
            estimated: Sum::ZERO,
            ..*self
        }
    }

    /// A bearing that has this behind it ([`Life::kept`]).
    pub const fn resume(used: u64, revolutions: u64) -> Self {
        Self {
            used: Sum::from_units(used),
            revolutions: Sum::from_units(revolutions),
            ..Self::NEW
        }
    }

    /// Life used and revolutions, to be kept over a power cycle.
    pub const fn kept(&self) -> (u64, u64) {
        (self.used.units(), self.revolutions.units())
    }

    /// From now on, these forces act. `damage` is `1 / L10`, per million revolutions, of [`LifeRating`](spindle_bearing::LifeRating), under loads
    /// of this `x^2` ([`Life::measure`]). A damage that is not a finite number changes nothing.
    pub const fn set_damage(&mut self, damage: f32, square: f32) {
        if damage.is_finite() {
            (self.rate, self.solved) = (damage, square);
        }
    }

    /// The forces of the mounted spindle: cold, at rest, under idling loads of this `x^2`. Its rows are pressed with a force of this
    /// part of its range, squared.
    pub fn mount(&mut self, damage: f32, square: f32, pressed: f32) {
        self.set_damage(damage, square);
        let slope = two_thirds(damage) / (2.0 * pressed);
        // Without a force there is nothing to tell it from.
        self.slope = if slope.is_finite() { slope } else { 0.0 };
    }

    /// The measured loads have this `x^2`
    /// ([`PlausibilitySettings::square`](crate::plausibility::PlausibilitySettings::square)); none if they cannot be believed.
    pub const fn measure(&mut self, square: Option<f32>) {
        self.measured = square;
    }

    /// The shaft has turned on at `speed` (rad/s) for `time` (s). The forces are `estimated` if they are those of an older sample; speed
    /// or loads may be `doubtful`.
    pub fn turn(&mut self, speed: f32, time: f32, estimated: bool, doubtful: bool) {
        let revolutions = speed.abs() * time * (0.5 * core::f32::consts::FRAC_1_PI);
        self.revolutions.add(revolutions);
        if doubtful {
            self.doubtful.add(revolutions);
        }
        let mut rate = self.rate;
        if estimated && let Some(measured) = self.measured {
            let all = two_thirds(rate);
            // `k^2` if all of it is the loads', which is the most.
            let most = all / self.solved;
            // Loads beyond their ranges leave the preload next to nothing.
            let slope = if measured > 1.0 {
                most
            } else {
                self.slope.min(most)
            };
            let grown = (all + slope * (measured - self.solved)).max(0.0);
            let grown = grown.min(LARGEST_GROWTH * LARGEST_GROWTH * all);
            rate = grown * sqrt_f32(grown);
        }
        let used = revolutions * 1e-6 * rate;
        self.used.add(used);
        if estimated {
            self.estimated.add(used);
        }
    }

    /// The part of [`Life::used`] that was counted between samples that were solved, since the start.
    pub const fn estimated(&self) -> f32 {
        self.estimated.value()
    }

    /// Rating life used up, a part of 1.
    pub const fn used(&self) -> f32 {
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

/// `damage^(2/3)`.
fn two_thirds(damage: f32) -> f32 {
    let root = cbrt_f32(damage);
    root * root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_does_not_drift_and_neither_overflows_nor_takes_nonsense() {
        // Of a unit, some, and thousands.
        for step in [1e-18_f32, 3.1e-16, 3.1e-13] {
            let mut sum = Used::ZERO;
            for _ in 0..1_000_000 {
                sum.add(step);
            }
            let exact = 1e6 * f64::from(step) * f64::from(Used::UNITS_OF_ONE);
            let error = (sum.units() as f64 - exact).abs();
            assert!(error < 1.0 + 1e-6 * exact, "{step}: {error} of {exact}");
        }
        let mut sum = Used::ZERO;
        for nonsense in [f32::NAN, -1.0, -0.0, 0.0, f32::NEG_INFINITY] {
            sum.add(nonsense);
            assert_eq!(sum, Used::ZERO);
        }
        for (x, whole) in [(1.0_f32, 1), (1e9, 1_000_000_000), (0.999_999_9, 0)] {
            let mut sum = Revolutions::ZERO;
            sum.add(x);
            assert_eq!(sum.whole(), whole);
            assert!((sum.value() / x - 1.0).abs() < 1e-6);
        }
        for x in [f32::INFINITY, 1.0] {
            sum.add(x);
            assert_eq!(sum.units(), u64::MAX);
        }
    }

    /// The estimate of before stands until the next one.
    #[test]
    fn a_new_bearing_without_an_estimate_yet_uses_life() {
        let mut old = Life::NEW;
        old.set_damage(1e-3, 0.0);
        old.turn(1000.0, 1.0, false, false);
        let mut new = old.renewed();
        assert_eq!((new.used(), new.revolutions()), (0.0, 0));
        new.turn(1000.0, 1.0, true, true);
        assert_eq!((new.used(), new.estimated()), (old.used(), old.used()));
    }

    /// A century at 60,000 rpm.
    #[test]
    fn after_a_century_a_tick_still_counts() {
        let mut life = Life::resume(0, 3_155_760_000_000 << 22);
        life.set_damage(1e-6, 0.0);
        let (used, _) = life.kept();
        life.turn(6283.0, 1e-3, false, false);
        assert!(life.kept().0 > used);
        assert_eq!(life.revolutions(), 3_155_760_000_000);
        life.turn(6283.2, 1e-3, true, true);
        assert_eq!(life.revolutions(), 3_155_760_000_001);
        assert_eq!(life.doubtful_revolutions(), 1);
    }
}
