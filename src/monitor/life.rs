//! Rating life that has been used up, from the forces on the balls.
//!
//! [`LifeRating`](crate::LifeRating) has the formulas of the rating life.
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
//! (`host_tests/tests/all/life.rs`). Where only range or rate speak against a sample, the loads are scaled into the
//! range and solved there, for the life alone. Where a solve has not ended, the last loads are scaled to the measured ones. Smaller
//! measured loads, or none that can be believed, leave the rate as it was. [`Life::estimated`] has the life counted so.
//!
//! An increment is some 1e-13, and there are 86 million of them in a day: in single precision the sum would
//! stop growing. [`ExactSum`] adds them up as whole numbers, without any rounding.

use crate::real::Float;

/// Sum of non-negative numbers that rounds nothing down to `2^-FRACTION`. It stops at its largest value,
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

/// Most that measured loads count over their range, or over the solved loads; beyond is no load.
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

    /// From now on, these forces act. `damage` is `1 / L10`, per million revolutions, of [`LifeRating`](crate::LifeRating); what
    /// is no number changes nothing.
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

    /// The shaft has turned on at `speed` (rad/s) for `time` (s). It is `doubtful` if speed or
    /// forces are an older sample's.
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
