//! Temperatures of the shaft's side and of the housing's side, by which rings and balls grow and preload changes.
//!
//! They come more seldom than loads, and a sensor that fails must not stop the estimates. So no doubt about a
//! temperature keeps a sample from being solved.
//!
//! | a side's temperature | value in use |
//! | --- | --- |
//! | is measured | the last good value ([`TemperatureSource::Measured`]) |
//! | has not been measured for [`TemperatureSettings::missing_after_us`] | the last good value ([`TemperatureSource::Held`]) |
//! | has not been for [`TemperatureSettings::hold_us`] | the warm spindle's ([`TemperatureSource::Assumed`]) |
//!
//! The value in use changes by [`TemperatureSettings::rate`] at most: no estimate jumps when a sensor fails or comes
//! back. A good value is in its range and near the other side's, and has not changed faster than that rate since the
//! last good one. [`Alarm::Temperature`](crate::Alarm::Temperature) tells how long a side has had none.
//!
//! - **The first one.** Two values in a row begin that agree within [`TemperatureSettings::noise`]. They are as far apart as the side takes
//!   to change by that noise, or as [`TemperatureSettings::missing_after_us`]: a sensor that starts wrong may repeat itself at once.
//! - **Stuck.** A sensor that repeats its value while the other side's good values move by 5 K has no good value until it gives another
//!   one.

use crate::plausibility::seconds;
use serde::{Deserialize, Serialize};

/// Bounds of plausible temperatures, and their substitutes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TemperatureSettings {
    /// Temperature at which the spindle has its preload and its free contact angles, degrees Celsius.
    pub reference: f32,
    /// Lowest and highest, degrees Celsius.
    pub range: [f32; 2],
    /// By how much both sides may differ, K.
    pub difference: f32,
    /// Fastest change of a side, K/s.
    pub rate: f32,
    /// Change that needs no time, K: the sensors' steps and noise.
    pub noise: f32,
    /// Time without a good value after which a side is no longer measured, us.
    pub missing_after_us: u32,
    /// Time without a good value for which the last one is held, us.
    pub hold_us: u32,
    /// Of the warm spindle, inner and outer side, degrees Celsius: assumed after that.
    pub warm: [f32; 2],
}

impl TemperatureSettings {
    /// A start for a machine tool's spindle that was built at 20 degrees Celsius.
    pub const SPINDLE: Self = Self {
        reference: 20.0,
        range: [-20.0, 120.0],
        difference: 40.0,
        rate: 1.0,
        noise: 1.0,
        missing_after_us: 2_000_000,
        hold_us: 60_000_000,
        warm: [40.0, 35.0],
    };

    /// Whether a temperature is in the range.
    pub const fn has(&self, temperature: f32) -> bool {
        let [low, high] = self.range;
        low <= temperature && temperature <= high
    }
}

/// Where a side's temperature comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TemperatureSource {
    /// Temperatures are not in use: the spindle counts as cold.
    #[default]
    Unused,
    /// It is measured.
    Measured,
    /// It is not measured any more, and held.
    Held,
    /// It has not been measured for long: the warm spindle's is assumed.
    Assumed,
}

impl TemperatureSource {
    /// All of them, in the order of the format.
    pub const ALL: [Self; 4] = [Self::Unused, Self::Measured, Self::Held, Self::Assumed];

    /// Short name in lower case, as tables print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unused => "unused",
            Self::Measured => "measured",
            Self::Held => "held",
            Self::Assumed => "assumed",
        }
    }
}

/// Span of the other side's temperature, K, over which a sensor that works gives more than one value: five steps of 1 K, the coarsest
/// in use. A cooled housing stays within a step for some K of its shaft.
const STUCK: f32 = 5.0;

/// No span.
const NONE: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

/// One side.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Side {
    used: f32,
    /// The last good value, and when it was.
    good: Option<(f32, u64)>,
    /// Before there is one: the value that others must agree with, and when it was.
    first: Option<(f32, u64)>,
    /// The last value, and the lowest and the highest good value of the other side while it repeats.
    value: f32,
    beside: [f32; 2],
    source: TemperatureSource,
}

/// Both sides, the inner one first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Temperatures {
    sides: [Side; 2],
    began_us: Option<u64>,
    last_us: u64,
}

impl Temperatures {
    /// The spindle as it was built.
    pub(crate) const fn new(settings: Option<&TemperatureSettings>) -> Self {
        let (used, source) = match settings {
            Some(settings) => (settings.reference, TemperatureSource::Held),
            None => (0.0, TemperatureSource::Unused),
        };
        let side = Side {
            used,
            good: None,
            first: None,
            value: f32::NAN,
            beside: NONE,
            source,
        };
        Self {
            sides: [side; 2],
            began_us: None,
            last_us: 0,
        }
    }

    /// Takes a tick's temperatures, degrees Celsius, if there are new ones; a failing sensor gives no number.
    pub(crate) fn judge(
        &mut self,
        time_us: u64,
        reading: Option<[f32; 2]>,
        settings: &TemperatureSettings,
    ) {
        let began_us = *self.began_us.get_or_insert(time_us);
        let most = settings.rate * seconds(self.last_us, time_us).min(1.0);
        self.last_us = time_us;
        if let Some([inner, outer]) = reading {
            let [beside_outer, beside_inner] = self.sides.map(|side| side.good);
            let [a, b] = &mut self.sides;
            let stuck = [
                a.is_stuck(inner, beside_inner),
                b.is_stuck(outer, beside_outer),
            ];
            // Of sides too far apart, nobody knows which one is wrong, unless one is stuck.
            let apart = (inner - outer).abs() > settings.difference && stuck == [false; 2];
            for ((side, value), stuck) in self.sides.iter_mut().zip([inner, outer]).zip(stuck) {
                if !apart && !stuck {
                    side.take(time_us, value, settings);
                }
            }
        }
        for (side, warm) in self.sides.iter_mut().zip(&settings.warm) {
            side.follow(time_us, began_us, *warm, most, settings);
        }
    }

    /// Temperatures in use, degrees Celsius.
    pub(crate) fn used(&self) -> [f32; 2] {
        self.sides.map(|side| side.used)
    }

    /// Where these temperatures come from.
    pub(crate) fn sources(&self) -> [TemperatureSource; 2] {
        self.sides.map(|side| side.source)
    }

    /// Whether both are measured, or not in use.
    pub(crate) fn are_measured(&self) -> bool {
        use TemperatureSource::{Measured, Unused};
        self.sides
            .iter()
            .all(|side| matches!(side.source, Measured | Unused))
    }

    /// Time since both sides had a good value, s.
    pub(crate) fn age(&self, time_us: u64) -> f32 {
        let since = |side: &Side| side.since(self.began_us.unwrap_or(time_us));
        let oldest = self.sides.iter().map(since).min();
        seconds(oldest.unwrap_or(time_us), time_us)
    }
}

impl Side {
    /// When it had a good value last.
    fn since(&self, began_us: u64) -> u64 {
        self.good.map_or(began_us, |(_, then)| then)
    }

    /// Whether this value repeats the last one although the other side, whose last good value this is, has moved since.
    fn is_stuck(&mut self, value: f32, beside: Option<(f32, u64)>) -> bool {
        if value != self.value {
            (self.value, self.beside) = (value, NONE);
        }
        if let Some((beside, _)) = beside {
            let [low, high] = self.beside;
            self.beside = [low.min(beside), high.max(beside)];
        }
        let [low, high] = self.beside;
        high - low >= STUCK
    }

    fn take(&mut self, time_us: u64, value: f32, settings: &TemperatureSettings) {
        if !settings.has(value) {
            return;
        }
        match self.good {
            Some((last, then)) => {
                let allowed = settings.noise + settings.rate * seconds(then, time_us);
                if (value - last).abs() > allowed {
                    return;
                }
            }
            None => {
                let agrees = |(first, _): &(f32, u64)| (value - first).abs() <= settings.noise;
                let first = self.first.filter(agrees);
                self.first = first.or(Some((value, time_us)));
                let Some((_, since)) = first else {
                    return;
                };
                if settings.rate * seconds(since, time_us) < settings.noise
                    && time_us.saturating_sub(since) < settings.missing_after_us.into()
                {
                    return;
                }
                // There is nothing yet that could jump.
                self.used = value;
            }
        }
        self.good = Some((value, time_us));
    }

    /// Moves the temperature in use towards the one it should be, by `most`.
    fn follow(
        &mut self,
        time_us: u64,
        began_us: u64,
        warm: f32,
        most: f32,
        settings: &TemperatureSettings,
    ) {
        let silent = time_us.saturating_sub(self.since(began_us));
        let held = self.good.map_or(self.used, |(value, _)| value);
        let wanted;
        (self.source, wanted) = if silent > settings.hold_us.into() {
            (TemperatureSource::Assumed, warm)
        } else if silent > settings.missing_after_us.into() || self.good.is_none() {
            (TemperatureSource::Held, held)
        } else {
            (TemperatureSource::Measured, held)
        };
        let change = wanted - self.used;
        self.used += change.max(-most).min(most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: TemperatureSettings = TemperatureSettings::SPINDLE;
    const SECOND: u64 = 1_000_000;

    /// The temperatures after `reading` a second, from one time to another, s.
    fn run(t: &mut Temperatures, from: u64, to: u64, reading: Option<[f32; 2]>) {
        for second in from..to {
            t.judge(second * SECOND, reading, &SETTINGS);
        }
    }

    #[test]
    fn what_is_measured_is_used() {
        let mut t = Temperatures::new(Some(&SETTINGS));
        run(&mut t, 0, 1, Some([24.0, 22.0]));
        assert_eq!(t.used(), [SETTINGS.reference; 2]);
        run(&mut t, 1, 2, Some([24.5, 22.0]));
        assert_eq!(t.used(), [24.5, 22.0]);
        run(&mut t, 2, 5, Some([25.5, 22.5]));
        assert_eq!(t.used(), [25.5, 22.5]);
        assert_eq!(t.sources(), [TemperatureSource::Measured; 2]);
        assert_eq!(t.age(4 * SECOND), 0.0);
    }

    #[test]
    fn a_sensor_that_fails_is_held_then_assumed_and_never_makes_a_jump() {
        let mut t = Temperatures::new(Some(&SETTINGS));
        run(&mut t, 0, 10, Some([50.0, 45.0]));
        let broken = Some([f32::NAN, 45.0]);
        run(&mut t, 10, 15, broken);
        assert_eq!(t.used(), [50.0, 45.0]);
        assert_eq!(
            t.sources(),
            [TemperatureSource::Held, TemperatureSource::Measured]
        );
        assert!((t.age(14 * SECOND) - 5.0).abs() < 1e-3);
        let mut last = t.used()[0];
        for second in 15..100 {
            run(&mut t, second, second + 1, broken);
            let now = t.used()[0];
            assert!((now - last).abs() <= SETTINGS.rate * 1.001, "{second}");
            last = now;
        }
        assert_eq!(t.used(), [SETTINGS.warm[0], 45.0]);
        assert_eq!(t.sources()[0], TemperatureSource::Assumed);
        // It comes back.
        run(&mut t, 100, 101, Some([60.0, 45.0]));
        assert!((t.used()[0] - 41.0).abs() < 1e-3);
        run(&mut t, 101, 125, Some([60.0, 45.0]));
        assert_eq!(t.used(), [60.0, 45.0]);
    }

    #[test]
    fn what_cannot_be_is_not_believed() {
        let good = [30.0, 28.0];
        for wrong in [
            [30.0, 1e9],
            [f32::INFINITY, 28.0],
            [130.0, 125.0],
            [-60.0, -60.0],
            // Too far apart, and too fast.
            [75.0, 28.0],
            [45.0, 43.0],
        ] {
            let mut t = Temperatures::new(Some(&SETTINGS));
            run(&mut t, 0, 5, Some(good));
            run(&mut t, 5, 6, Some(wrong));
            let [inner, outer] = t.used();
            assert!(
                (inner - 30.0).abs() <= 1.0 && (outer - 28.0).abs() <= 1.0,
                "{wrong:?}"
            );
            run(&mut t, 6, 10, Some(good));
            assert_eq!(t.used(), good);
        }
    }

    /// Wrong for a tenth of a second, whether it is read once or in each tick.
    #[test]
    fn a_first_reading_that_is_wrong_is_not_believed() {
        for every_us in [1000, 100_000] {
            let mut t = Temperatures::new(Some(&SETTINGS));
            let mut worst = SETTINGS.reference;
            for time_us in (0..5 * SECOND).step_by(every_us) {
                let is_wrong = time_us < SECOND / 10;
                let reading = if is_wrong {
                    [100.0, 65.0]
                } else {
                    [24.0, 22.0]
                };
                t.judge(time_us, Some(reading), &SETTINGS);
                worst = t.used().into_iter().fold(worst, f32::max);
            }
            assert_eq!((t.used(), worst), ([24.0, 22.0], 24.0));
            assert_eq!(t.sources(), [TemperatureSource::Measured; 2]);
        }
    }

    #[test]
    fn a_sensor_that_repeats_itself_while_the_other_side_warms_up_is_stuck() {
        for stuck in [0, 1] {
            let mut t = Temperatures::new(Some(&SETTINGS));
            let mut told = None;
            for second in 0..120_u64 {
                // Sensors with steps of 1 K, on sides that warm up by 0.1 K/s.
                let warm = (20.0 + 0.1 * second as f32 + 0.5) as u32 as f32;
                let mut reading = [warm; 2];
                reading[stuck] = 20.0;
                t.judge(second * SECOND, Some(reading), &SETTINGS);
                let others = t.sources()[1 - stuck];
                assert!(second < 2 || others == TemperatureSource::Measured);
                if t.age(second * SECOND) > 0.0 && second > 2 {
                    told.get_or_insert(second);
                }
            }
            // The other side reads 25 from 45 s on, which is 5 K more, and is known a reading later.
            assert_eq!(told, Some(46), "{stuck}");
            assert_eq!(t.sources()[stuck], TemperatureSource::Assumed);
            // It comes back.
            run(&mut t, 120, 150, Some([32.0; 2]));
            assert_eq!(t.used(), [32.0; 2]);
        }
    }

    /// Ten hours: noise of 0.4 K about halves, in steps of 1 K, on either side or on one.
    #[test]
    fn a_constant_temperature_is_no_stuck_sensor() {
        let noise = |second: u64| (second.wrapping_mul(0x9E37_79B9) % 1000) as f32 * 0.8e-3 - 0.4;
        for noisy in [[1.0, 1.0], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0]] {
            let mut t = Temperatures::new(Some(&SETTINGS));
            for second in 0..36_000 {
                let [inner, outer] = noisy.map(|part: f32| part * noise(second));
                let reading = [35.5 + inner, 30.5 + outer].map(|t| (t + 0.5) as u32 as f32);
                t.judge(second * SECOND, Some(reading), &SETTINGS);
                assert!(t.age(second * SECOND) < 3.0, "{second} {noisy:?}");
            }
        }
    }

    #[test]
    fn without_any_sensor_the_spindle_is_taken_for_warm() {
        let mut t = Temperatures::new(Some(&SETTINGS));
        run(&mut t, 0, 100, None);
        assert_eq!(t.used(), SETTINGS.warm);
        assert_eq!(t.sources(), [TemperatureSource::Assumed; 2]);
        assert!((t.age(99 * SECOND) - 99.0).abs() < 1e-3);
    }
}
