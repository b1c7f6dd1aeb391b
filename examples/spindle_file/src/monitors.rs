//! The monitor of a spindle file: `[monitor]`, all of which may be left out.
//!
//! `docs/monitor_keys.md` has every key with its unit, default and meaning. Ranges, rates and speed follow from the bearings
//! ([`largest_loads`], [`LOAD_RATE`], [`largest_speed`]). The overload is the larger amount of the range: what is beyond it has no
//! estimate, but an alarm. The accuracy is 1 % of that, a good sensor's.
//!
//! The rest are the values that the shipped firmware has. Levels that count as limits (`Limits` of the library) are those of the
//! alarms.

use crate::calibration;
use crate::designs::DesignFile;
use crate::doubts::Doubts;
use crate::reading::{DesignFileError, Key, Place, Reading, short};
use serde::Deserialize;
use spindle_monitor::Alarm;
use spindle_monitor::settings::{LOAD_RATE, largest_loads, largest_speed};
use std::f64::consts::PI;
use std::ops::{Range, RangeInclusive};
use toml::Spanned;

/// A monitor with every value settled, SI units.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MonitorFile {
    /// Period of a tick, us.
    pub period_us: u32,
    /// Loads `Fx, Fy, Fz` (N), `My, Mz` (N m) of the idling spindle, to start from. No bridge can tell them from its zero.
    pub idle: [f64; 5],
    /// Bounds of plausible loads and speeds.
    pub plausible: Plausible,
    /// Largest amount of each load that the spindle may carry, N, N m.
    pub overload: [f64; 5],
    /// Accuracy of each measured load, N, N m; 0 for exact.
    pub accuracy: [f64; 5],
    /// Levels of alarms, in the order of their numbers.
    pub alarms: [AlarmLevels; 15],
    /// Bounds of temperatures: in use if the spindle has `[heat]`, where the reference is.
    pub temperatures: Temperatures,
    /// The tachometer, beside bridges.
    pub tachometer: Tachometer,
    /// Loads come from bridges at the board; else they come as records.
    pub bridges: Option<Bridges>,
    /// Samples of a tare of the bridges.
    pub tare_samples: u32,
    /// How often telemetry goes out.
    pub telemetry: Telemetry,
    /// Loads (N, N m) and speed (rad/s) of a usual cut, by which the faults that probes see are told apart; no loads for none.
    pub cut: ([f64; 5], f64),
}

/// Bounds of plausible loads and speeds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Plausible {
    /// Lowest and highest of each load, N, N m.
    pub load: [[f64; 2]; 5],
    /// Fastest change of each load, N/s, N m/s.
    pub load_rate: [f64; 5],
    /// Equal loads in a row that are stuck; 0 for never.
    pub stuck_after: u32,
    /// Time without a sample that is one without loads, us.
    pub missing_after_us: u32,
    /// Age beyond which an estimate is no longer fresh, us.
    pub fresh_us: u32,
    /// Largest residual of redundant bridges, counts; infinite for any.
    pub residual: f64,
    /// Highest speed in either direction, rad/s.
    pub speed: f64,
    /// Fastest change of speed, rad/s^2.
    pub speed_rate: f64,
    /// Greatest deceleration of the shaft, rad/s^2: the tachometer's, too.
    pub deceleration: f64,
    /// Equal speeds in a row that are stuck; 0 for never.
    pub speed_stuck_after: u32,
    /// By how much two sources of speed may differ, rad/s, and as a part of the speed.
    pub speed_difference: [f64; 2],
}

/// Levels of an alarm, in its unit: Pa, rad, s, a part of 1 or a number.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AlarmLevels {
    /// Name of the alarm, as in the file.
    pub name: &'static str,
    /// The condition begins.
    pub limit: f64,
    /// It ends.
    pub clear: f64,
    /// So much of its time must add up, us.
    pub hold_us: u32,
    /// It is not waited for; infinite for never.
    pub at_once: f64,
    /// An acknowledged alarm that has grown by so much is raised again; infinite for never.
    pub worse: f64,
}

/// A level of an alarm as files and tables have it: in the unit of [`Alarm::unit`], in six digits.
pub fn level(alarm: Alarm, value: f64) -> f64 {
    short(value / alarm.unit().1)
}

/// A level of an alarm against its limit, in words.
pub fn against(alarm: Alarm, value: f32, limit: f32) -> String {
    let [value, limit] = [value, limit].map(|x| level(alarm, x.into()));
    let words = format!("{value} of {limit} {}", alarm.unit().0);
    words.trim_end().to_owned()
}

/// Bounds of plausible temperatures, and their substitutes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Temperatures {
    /// Lowest and highest, degrees Celsius.
    pub range: [f64; 2],
    /// By how much both sides may differ, K.
    pub difference: f64,
    /// Fastest change of a side, K/s.
    pub rate: f64,
    /// Change that needs no time, K.
    pub noise: f64,
    /// Time without a good value after which a side is no longer measured, us.
    pub missing_after_us: u32,
    /// Time for which the last good value is held, us.
    pub hold_us: u32,
    /// Of the warm spindle, inner and outer side, degrees Celsius.
    pub warm: [f64; 2],
}

/// The tachometer's pulses.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tachometer {
    /// Pulses of a revolution.
    pub pulses_per_revolution: u32,
    /// Above this speed pulses are counted, rad/s.
    pub count_above: f64,
    /// Below this speed their period is taken, rad/s.
    pub period_below: f64,
    /// Time over which pulses are counted, us.
    pub gate_us: u32,
    /// Time without a pulse that is a standstill, us.
    pub standstill_us: u32,
}

/// Five to eight strain bridges.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bridges {
    /// Counts by loads, bridge by bridge: counts per N or N m.
    pub counts: Vec<[f64; 5]>,
    /// Loads by counts, bridge by bridge: N or N m per count, the least squares of `counts`.
    pub loads: Vec<[f64; 5]>,
}

/// Times between frames of telemetry, us.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[expect(missing_docs, reason = "each is of the frames of its name")]
pub struct Telemetry {
    pub estimate_us: u32,
    pub balls_us: u32,
    pub health_us: u32,
    /// Of an alarm that stands.
    pub standing_us: u32,
}

type Said = Key<f64>;
type Range2 = Key<[f64; 2]>;

#[rustfmt::skip]
mod keys {
    use super::{Deserialize, Key, Range2, Said};

    #[derive(Deserialize, Default)] #[serde(default, deny_unknown_fields)]
    pub(crate) struct MonitorKeys {
        pub period_ms: Said, pub loads: Key<String>, pub idle: LoadKeys, pub plausible: PlausibleKeys, pub overload: LoadKeys,
        pub accuracy: LoadKeys, pub alarm: AlarmsKeys, pub temperatures: TemperatureKeys, pub tachometer: TachometerKeys,
        pub bridges: BridgeKeys, pub telemetry: TelemetryKeys, pub cut: CutKeys,
    }
    #[derive(Deserialize, Default)] #[serde(default, deny_unknown_fields)]
    pub(crate) struct LoadKeys { pub fx_n: Said, pub fy_n: Said, pub fz_n: Said, pub my_nm: Said, pub mz_nm: Said }
    #[derive(Deserialize, Default)] #[serde(default, deny_unknown_fields)]
    pub(crate) struct PlausibleKeys {
        pub fx_n: Range2, pub fy_n: Range2, pub fz_n: Range2, pub my_nm: Range2, pub mz_nm: Range2,
        pub fx_n_per_ms: Said, pub fy_n_per_ms: Said, pub fz_n_per_ms: Said, pub my_nm_per_ms: Said, pub mz_nm_per_ms: Said,
        pub stuck_after: Said, pub missing_ms: Said, pub fresh_ms: Said, pub residual_counts: Said,
        pub speed_rpm: Said, pub speed_rpm_per_ms: Said, pub deceleration_rpm_per_s: Said, pub speed_stuck_after: Said,
        pub speed_difference_rpm: Said, pub speed_difference_percent: Said,
    }
    #[derive(Deserialize, Default)] #[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
    pub(crate) struct AlarmsKeys {
        pub peak_pressure: AlarmKeys, pub contact_angle: AlarmKeys, pub slip: AlarmKeys, pub unloaded_balls: AlarmKeys,
        pub preload_growth: AlarmKeys, pub preload_loss: AlarmKeys, pub overload: AlarmKeys, pub stiffness_loss: AlarmKeys,
        pub stiffness_gain: AlarmKeys, pub life_used: AlarmKeys, pub sensor: AlarmKeys, pub probe: AlarmKeys,
        pub temperature: AlarmKeys, pub availability: AlarmKeys, pub deadline: AlarmKeys,
    }
    #[derive(Deserialize, Default)] #[serde(default, deny_unknown_fields)]
    pub(crate) struct AlarmKeys { pub limit: Said, pub clear: Said, pub hold_ms: Said, pub at_once: Said }
    #[derive(Deserialize, Default)] #[serde(default, deny_unknown_fields)]
    pub(crate) struct TemperatureKeys {
        pub range_c: Range2, pub difference_k: Said, pub rate_k_per_s: Said, pub noise_k: Said, pub missing_ms: Said,
        pub hold_ms: Said, pub warm_c: Range2,
    }
    #[derive(Deserialize, Default)] #[serde(default, deny_unknown_fields)]
    pub(crate) struct TachometerKeys {
        pub pulses_per_revolution: Said, pub count_above_rpm: Said, pub period_below_rpm: Said, pub gate_ms: Said,
        pub standstill_ms: Said,
    }
    #[derive(Deserialize, Default)] #[serde(default, deny_unknown_fields)]
    pub(crate) struct BridgeKeys { pub counts: Key<Vec<[f64; 5]>>, pub tare_samples: Said }
    #[derive(Deserialize, Default)] #[serde(default, deny_unknown_fields)]
    pub(crate) struct CutKeys {
        pub fx_n: Said, pub fy_n: Said, pub fz_n: Said, pub my_nm: Said, pub mz_nm: Said, pub speed_rpm: Said,
    }
    #[derive(Deserialize, Default)] #[serde(default, deny_unknown_fields)]
    pub(crate) struct TelemetryKeys { pub estimate_ms: Said, pub balls_ms: Said, pub health_ms: Said, pub standing_ms: Said }
}
use keys::AlarmKeys;
pub(crate) use keys::MonitorKeys;

/// A number: its key, its default in the file's unit (none if it follows from others), bounds, where it is read from, and what
/// it sets.
type Number = (
    &'static str,
    Option<f64>,
    Bounds,
    fn(&MonitorKeys) -> &Said,
    fn(&mut MonitorFile, f64),
);

#[derive(Clone, Copy, PartialEq)]
enum Bounds {
    /// Milliseconds from this to those that microseconds of 32 bits reach.
    Time(f64),
    /// Whole, from this to 16 bits.
    Count(f64),
    From(f64, f64),
}
use Bounds::{Count, From, Time};

const POSITIVE: Bounds = From(1e-6, 1e12);

fn us(ms: f64) -> u32 {
    (ms * 1e3).round() as u32
}

fn rad(rpm: f64) -> f64 {
    rpm * PI / 30.0
}

#[rustfmt::skip]
const NUMBERS: [Number; 52] = [
    ("period_ms", Some(1.0), From(1.0, 10.0), |k| &k.period_ms, |m, x| m.period_us = us(x)),
    ("idle.fx_n", Some(0.0), From(-1e9, 1e9), |k| &k.idle.fx_n, |m, x| m.idle[0] = x),
    ("idle.fy_n", Some(0.0), From(-1e9, 1e9), |k| &k.idle.fy_n, |m, x| m.idle[1] = x),
    ("idle.fz_n", Some(0.0), From(-1e9, 1e9), |k| &k.idle.fz_n, |m, x| m.idle[2] = x),
    ("idle.my_nm", Some(0.0), From(-1e9, 1e9), |k| &k.idle.my_nm, |m, x| m.idle[3] = x),
    ("idle.mz_nm", Some(0.0), From(-1e9, 1e9), |k| &k.idle.mz_nm, |m, x| m.idle[4] = x),
    ("plausible.fx_n_per_ms", None, POSITIVE, |k| &k.plausible.fx_n_per_ms, |m, x| m.plausible.load_rate[0] = x * 1e3),
    ("plausible.fy_n_per_ms", None, POSITIVE, |k| &k.plausible.fy_n_per_ms, |m, x| m.plausible.load_rate[1] = x * 1e3),
    ("plausible.fz_n_per_ms", None, POSITIVE, |k| &k.plausible.fz_n_per_ms, |m, x| m.plausible.load_rate[2] = x * 1e3),
    ("plausible.my_nm_per_ms", None, POSITIVE, |k| &k.plausible.my_nm_per_ms, |m, x| m.plausible.load_rate[3] = x * 1e3),
    ("plausible.mz_nm_per_ms", None, POSITIVE, |k| &k.plausible.mz_nm_per_ms, |m, x| m.plausible.load_rate[4] = x * 1e3),
    ("overload.fx_n", None, POSITIVE, |k| &k.overload.fx_n, |m, x| m.overload[0] = x),
    ("overload.fy_n", None, POSITIVE, |k| &k.overload.fy_n, |m, x| m.overload[1] = x),
    ("overload.fz_n", None, POSITIVE, |k| &k.overload.fz_n, |m, x| m.overload[2] = x),
    ("overload.my_nm", None, POSITIVE, |k| &k.overload.my_nm, |m, x| m.overload[3] = x),
    ("overload.mz_nm", None, POSITIVE, |k| &k.overload.mz_nm, |m, x| m.overload[4] = x),
    ("accuracy.fx_n", None, From(0.0, 1e9), |k| &k.accuracy.fx_n, |m, x| m.accuracy[0] = x),
    ("accuracy.fy_n", None, From(0.0, 1e9), |k| &k.accuracy.fy_n, |m, x| m.accuracy[1] = x),
    ("accuracy.fz_n", None, From(0.0, 1e9), |k| &k.accuracy.fz_n, |m, x| m.accuracy[2] = x),
    ("accuracy.my_nm", None, From(0.0, 1e9), |k| &k.accuracy.my_nm, |m, x| m.accuracy[3] = x),
    ("accuracy.mz_nm", None, From(0.0, 1e9), |k| &k.accuracy.mz_nm, |m, x| m.accuracy[4] = x),
    ("plausible.stuck_after", Some(100.0), Count(0.0), |k| &k.plausible.stuck_after, |m, x| m.plausible.stuck_after = x as u32),
    ("plausible.missing_ms", Some(50.0), Time(1.0), |k| &k.plausible.missing_ms, |m, x| m.plausible.missing_after_us = us(x)),
    ("plausible.fresh_ms", Some(20.0), Time(1.0), |k| &k.plausible.fresh_ms, |m, x| m.plausible.fresh_us = us(x)),
    ("plausible.residual_counts", None, POSITIVE, |k| &k.plausible.residual_counts, |m, x| m.plausible.residual = x),
    ("plausible.speed_rpm", None, From(1.0, 1e6), |k| &k.plausible.speed_rpm, |m, x| m.plausible.speed = rad(x)),
    ("plausible.speed_rpm_per_ms", Some(191.0), POSITIVE, |k| &k.plausible.speed_rpm_per_ms, |m, x| m.plausible.speed_rate = rad(x) * 1e3),
    ("plausible.deceleration_rpm_per_s", Some(38_200.0), POSITIVE, |k| &k.plausible.deceleration_rpm_per_s, |m, x| m.plausible.deceleration = rad(x)),
    ("plausible.speed_stuck_after", None, Count(0.0), |k| &k.plausible.speed_stuck_after, |m, x| m.plausible.speed_stuck_after = x as u32),
    ("plausible.speed_difference_rpm", Some(95.5), From(0.0, 1e6), |k| &k.plausible.speed_difference_rpm, |m, x| m.plausible.speed_difference[0] = rad(x)),
    ("plausible.speed_difference_percent", Some(2.0), From(0.0, 100.0), |k| &k.plausible.speed_difference_percent, |m, x| m.plausible.speed_difference[1] = x / 100.0),
    ("temperatures.difference_k", Some(40.0), POSITIVE, |k| &k.temperatures.difference_k, |m, x| m.temperatures.difference = x),
    ("temperatures.rate_k_per_s", Some(1.0), POSITIVE, |k| &k.temperatures.rate_k_per_s, |m, x| m.temperatures.rate = x),
    ("temperatures.noise_k", Some(1.0), From(0.0, 1e3), |k| &k.temperatures.noise_k, |m, x| m.temperatures.noise = x),
    ("temperatures.missing_ms", Some(2000.0), Time(1.0), |k| &k.temperatures.missing_ms, |m, x| m.temperatures.missing_after_us = us(x)),
    ("temperatures.hold_ms", Some(60_000.0), Time(1.0), |k| &k.temperatures.hold_ms, |m, x| m.temperatures.hold_us = us(x)),
    ("tachometer.pulses_per_revolution", Some(4.0), Count(1.0), |k| &k.tachometer.pulses_per_revolution, |m, x| m.tachometer.pulses_per_revolution = x as u32),
    ("tachometer.count_above_rpm", Some(3820.0), POSITIVE, |k| &k.tachometer.count_above_rpm, |m, x| m.tachometer.count_above = rad(x)),
    ("tachometer.period_below_rpm", Some(2865.0), POSITIVE, |k| &k.tachometer.period_below_rpm, |m, x| m.tachometer.period_below = rad(x)),
    ("tachometer.gate_ms", Some(5.0), Time(1e-3), |k| &k.tachometer.gate_ms, |m, x| m.tachometer.gate_us = us(x)),
    ("tachometer.standstill_ms", Some(500.0), Time(1.0), |k| &k.tachometer.standstill_ms, |m, x| m.tachometer.standstill_us = us(x)),
    ("bridges.tare_samples", Some(1000.0), Count(1.0), |k| &k.bridges.tare_samples, |m, x| m.tare_samples = x as u32),
    ("cut.fx_n", Some(0.0), From(-1e9, 1e9), |k| &k.cut.fx_n, |m, x| m.cut.0[0] = x),
    ("cut.fy_n", Some(0.0), From(-1e9, 1e9), |k| &k.cut.fy_n, |m, x| m.cut.0[1] = x),
    ("cut.fz_n", Some(0.0), From(-1e9, 1e9), |k| &k.cut.fz_n, |m, x| m.cut.0[2] = x),
    ("cut.my_nm", Some(0.0), From(-1e9, 1e9), |k| &k.cut.my_nm, |m, x| m.cut.0[3] = x),
    ("cut.mz_nm", Some(0.0), From(-1e9, 1e9), |k| &k.cut.mz_nm, |m, x| m.cut.0[4] = x),
    ("cut.speed_rpm", Some(0.0), From(-1e6, 1e6), |k| &k.cut.speed_rpm, |m, x| m.cut.1 = rad(x)),
    ("telemetry.estimate_ms", Some(20.0), Time(1e-3), |k| &k.telemetry.estimate_ms, |m, x| m.telemetry.estimate_us = us(x)),
    ("telemetry.balls_ms", None, Time(1e-3), |k| &k.telemetry.balls_ms, |m, x| m.telemetry.balls_us = us(x)),
    ("telemetry.health_ms", Some(1000.0), Time(1e-3), |k| &k.telemetry.health_ms, |m, x| m.telemetry.health_us = us(x)),
    ("telemetry.standing_ms", Some(10_000.0), Time(1e-3), |k| &k.telemetry.standing_ms, |m, x| m.telemetry.standing_us = us(x)),
];

/// An alarm, its levels in the unit of files (limit, clear, at once), its hold time (ms), where it is read from.
type OfAlarm = (Alarm, [f64; 3], f64, fn(&keys::AlarmsKeys) -> &AlarmKeys);

const NEVER: f64 = f64::INFINITY;

/// Keys of the five loads.
const LOADS: [&str; 5] = ["fx_n", "fy_n", "fz_n", "my_nm", "mz_nm"];

/// Usual ranges of loads over those by default, which are 6 % of the load rating `C` of all rows: from 0.012 % to 240 % of `C`.
const RANGES: [f64; 2] = [2e-3, 40.0];
/// Usual highest speeds over that by default, which is of fast spindles: from a rotary table's to the fastest of all.
const SPEEDS: [f64; 2] = [0.01, 3.0];
/// Usual limits of the peak pressure, GPa: from endurance without end to plastic deformation.
const PRESSURES: RangeInclusive<f64> = 0.5..=6.0;
/// Least usual limit in percent over that by default: parts of 1 are a hundredth of percents.
const LEAST_PERCENT: f64 = 0.05;
/// Largest usual limit in percent.
const MOST_PERCENT: f64 = 1e3;

/// In the order of their numbers.
#[rustfmt::skip]
const ALARMS: [OfAlarm; 15] = [
    (Alarm::PeakPressure, [2.0, 1.9, 2.5], 100.0, |k| &k.peak_pressure),
    (Alarm::ContactAngle, [0.0, -2.0, NEVER], 100.0, |k| &k.contact_angle),
    (Alarm::Slip, [0.06, 0.05, NEVER], 500.0, |k| &k.slip),
    (Alarm::UnloadedBalls, [0.5, 0.25, NEVER], 500.0, |k| &k.unloaded_balls),
    (Alarm::PreloadGrowth, [4.0, 3.5, NEVER], 1000.0, |k| &k.preload_growth),
    (Alarm::PreloadLoss, [80.0, 70.0, NEVER], 500.0, |k| &k.preload_loss),
    (Alarm::Overload, [100.0, 90.0, NEVER], 3.0, |k| &k.overload),
    (Alarm::LifeUsed, [80.0, 79.0, NEVER], 0.0, |k| &k.life_used),
    (Alarm::Sensor, [0.1, 0.05, NEVER], 0.0, |k| &k.sensor),
    (Alarm::Temperature, [5.0, 1.0, NEVER], 0.0, |k| &k.temperature),
    (Alarm::Availability, [10.0, 5.0, NEVER], 0.0, |k| &k.availability),
    (Alarm::Deadline, [10.0, 5.0, NEVER], 0.0, |k| &k.deadline),
    (Alarm::StiffnessLoss, [5.0, 4.0, NEVER], 0.0, |k| &k.stiffness_loss),
    (Alarm::StiffnessGain, [5.0, 4.0, NEVER], 0.0, |k| &k.stiffness_gain),
    (Alarm::Probe, [0.5, 0.25, NEVER], 0.0, |k| &k.probe),
];

/// A condition, the keys that may break it, and its words.
type Contradiction = (
    fn(&MonitorFile) -> bool,
    fn(&MonitorKeys) -> [Option<Range<usize>>; 2],
    &'static str,
);

#[rustfmt::skip]
const CONTRADICTIONS: [Contradiction; 8] = [
    (|m| m.plausible.missing_after_us >= m.period_us, |k| [span(&k.plausible.missing_ms), span(&k.period_ms)],
        "`missing_ms` must be `period_ms` at least"),
    (|m| m.plausible.fresh_us >= m.period_us, |k| [span(&k.plausible.fresh_ms), span(&k.period_ms)],
        "`fresh_ms` must be `period_ms` at least"),
    (|m| m.plausible.stuck_after != 1, |k| [span(&k.plausible.stuck_after), None],
        "`stuck_after` must be 0, for never, or at least 2"),
    (|m| m.plausible.speed_stuck_after != 1, |k| [span(&k.plausible.speed_stuck_after), None],
        "`speed_stuck_after` must be 0, for never, or at least 2"),
    (|m| m.plausible.speed_difference != [0.0; 2],
        |k| [span(&k.plausible.speed_difference_rpm), span(&k.plausible.speed_difference_percent)],
        "`speed_difference_rpm` and `speed_difference_percent` must not both be 0"),
    (|m| m.temperatures.warm.into_iter().all(|side| m.temperatures.has(side)),
        |k| [span(&k.temperatures.warm_c), span(&k.temperatures.range_c)], "`warm_c` must be within `range_c`"),
    (|m| m.temperatures.hold_us >= m.temperatures.missing_after_us,
        |k| [span(&k.temperatures.hold_ms), span(&k.temperatures.missing_ms)], "`hold_ms` must be `missing_ms` at least"),
    (|m| m.tachometer.period_below < m.tachometer.count_above,
        |k| [span(&k.tachometer.period_below_rpm), span(&k.tachometer.count_above_rpm)],
        "`period_below_rpm` must be below `count_above_rpm`"),
];

/// Where the last of these stands.
fn last<const N: usize>(r: Reading<'_>, said: [Option<Range<usize>>; N]) -> Place {
    let last = said.into_iter().flatten().max_by_key(|span| span.start);
    last.map_or(Place::TOP, |span| r.place(span))
}

fn span<T>(key: &Key<T>) -> Option<Range<usize>> {
    key.as_ref().map(Spanned::span)
}

/// A number within its bounds.
fn bounded(
    r: Reading<'_>,
    key: &str,
    said: &Spanned<f64>,
    bounds: Bounds,
) -> Result<f64, DesignFileError> {
    let (value, whole) = (*said.get_ref(), matches!(bounds, Count(_)));
    let (least, most) = match bounds {
        Time(least) => (least, 4e6),
        Count(least) => (least, 65_535.0),
        From(least, most) => (least, most),
    };
    if (least..=most).contains(&value) && !(whole && value.fract() != 0.0) {
        return Ok(value);
    }
    let be = if whole { "be a whole number" } else { "lie" };
    let message = format!("`{key}` is {value}, but must {be} between {least} and {most}");
    Err(r.error(r.place(said.span()), message))
}

/// Takes a range that is said: low, then high.
fn range_of(r: Reading<'_>, said: &Range2, range: &mut [f64; 2]) -> Result<(), DesignFileError> {
    let Some(said) = said else { return Ok(()) };
    *range = *said.get_ref();
    let [low, high] = *range;
    if low.abs().max(high.abs()) > 1e12 {
        let message =
            format!("the range is from {low} to {high}, but must lie between -1e12 and 1e12");
        return Err(r.error(r.place(said.span()), message));
    }
    if low < high {
        return Ok(());
    }
    let message = format!("the range is from {low} to {high}; give the lowest value first");
    Err(r.error(r.place(said.span()), message))
}

impl Temperatures {
    fn has(&self, temperature: f64) -> bool {
        let [low, high] = self.range;
        low <= temperature && temperature <= high
    }
}

impl AlarmKeys {
    /// Levels of an alarm. If the limit alone is said, the others go with it.
    fn read(&self, r: Reading<'_>, alarm: &OfAlarm) -> Result<AlarmLevels, DesignFileError> {
        let (alarm, [limit, clear, at_once], hold_ms, _) = *alarm;
        let (name, (_, size)) = (alarm.name(), alarm.unit());
        let value = |key: &str, said: &Said, otherwise: f64, bounds| match said {
            Some(said) => bounded(r, &format!("alarm.{name}.{key}"), said, bounds),
            None => Ok(otherwise),
        };
        let (usual, any) = (limit, From(-1e12, 1e12));
        // The usual limit of the contact angle is 0: its other levels keep their distance.
        let is_offset = usual == 0.0;
        let limit = value(
            "limit",
            &self.limit,
            usual,
            if is_offset { any } else { POSITIVE },
        )?;
        let along = |level: f64| match is_offset {
            true => level + limit,
            false => level * (limit / usual),
        };
        let clear = value("clear", &self.clear, along(clear), any)?;
        let at_once = value("at_once", &self.at_once, along(at_once), any)?;
        let hold_ms = value("hold_ms", &self.hold_ms, hold_ms, Time(0.0))?;
        let [limit_si, clear_si, at_once_si] = [limit, clear, at_once].map(|level| level * size);
        // A time without a measurement grows by itself.
        let grows = ["sensor", "temperature"].contains(&name);
        let step = (0.25 * limit_si).max(limit_si - clear_si);
        let levels = AlarmLevels {
            name,
            limit: limit_si,
            clear: clear_si,
            hold_us: us(hold_ms),
            at_once: at_once_si,
            worse: if grows { NEVER } else { step },
        };
        let [of_limit, of_clear, of_once] = [&self.limit, &self.clear, &self.at_once].map(span);
        let (place, told) = match (clear < limit, at_once >= limit) {
            (false, _) => ([of_limit, of_clear], "`clear` must be below `limit`"),
            (_, false) => ([of_limit, of_once], "`at_once` must be `limit` at least"),
            (true, true) => return Ok(levels),
        };
        Err(r.error(last(r, place), format!("the alarm {name}: {told}")))
    }
}

impl MonitorFile {
    /// The monitor of rows of these bearings, nothing of which is said.
    pub(crate) fn of(designs: &[DesignFile]) -> Self {
        let mut monitor = Self::default();
        let of_all = |of: fn(&DesignFile) -> f64| designs.iter().map(of);
        let pitches = || of_all(|one| one.design.pitch_diameter);
        let most = largest_loads(
            of_all(DesignFile::dynamic_rating).sum(),
            pitches().sum::<f64>() / designs.len() as f64,
        );
        monitor.plausible.load = most.map(|most| [-most, most]);
        monitor.plausible.speed = largest_speed(pitches().fold(0.0, f64::max));
        monitor.plausible.residual = NEVER;
        monitor.telemetry.balls_us = us(100.0 * designs.len().max(2) as f64);
        monitor.follow();
        for (_, default, _, _, set) in NUMBERS {
            if let Some(default) = default {
                set(&mut monitor, default);
            }
        }
        let r = Reading { file: "", text: "" };
        for (levels, alarm) in monitor.alarms.iter_mut().zip(&ALARMS) {
            *levels = AlarmKeys::default().read(r, alarm).unwrap_or_default();
        }
        monitor.temperatures.range = [-20.0, 120.0];
        monitor.temperatures.warm = [40.0, 35.0];
        monitor
    }

    /// What follows from the ranges of loads.
    fn follow(&mut self) {
        let ranges = self.plausible.load;
        self.plausible.load_rate = ranges.map(|[low, high]| LOAD_RATE * 0.5 * (high - low));
        self.overload = ranges.map(|[low, high]| high.abs().max(low.abs()));
        self.accuracy = self.overload.map(|most| 0.01 * most);
    }
}

impl MonitorKeys {
    /// The monitor of a spindle with rows of these bearings; `reference` is the temperature of its `[heat]`.
    pub fn read(
        self,
        r: Reading<'_>,
        designs: &[DesignFile],
        reference: Option<(f64, Place)>,
        doubts: &mut Doubts<'_>,
    ) -> Result<MonitorFile, DesignFileError> {
        let mut monitor = MonitorFile::of(designs);
        let p = &self.plausible;
        let said = [&p.fx_n, &p.fy_n, &p.fz_n, &p.my_nm, &p.mz_nm];
        for (range, said) in monitor.plausible.load.iter_mut().zip(said) {
            range_of(r, said, range)?;
        }
        monitor.follow();
        self.bridges(r, &mut monitor)?;
        for (key, _, bounds, number, set) in NUMBERS {
            if let Some(said) = number(&self) {
                set(&mut monitor, bounded(r, key, said, bounds)?);
            }
        }
        for (levels, alarm) in monitor.alarms.iter_mut().zip(&ALARMS) {
            *levels = alarm.3(&self.alarm).read(r, alarm)?;
        }
        range_of(
            r,
            &self.temperatures.range_c,
            &mut monitor.temperatures.range,
        )?;
        if let Some(warm) = &self.temperatures.warm_c {
            monitor.temperatures.warm = *warm.get_ref();
        }
        self.contradictions(r, &monitor, reference)?;
        self.doubt(r, designs, &monitor, doubts);
        Ok(monitor)
    }

    /// Doubts ranges and levels in other units, and ranges that the file's own cut leaves.
    fn doubt(
        &self,
        r: Reading<'_>,
        designs: &[DesignFile],
        m: &MonitorFile,
        doubts: &mut Doubts<'_>,
    ) {
        let usual = MonitorFile::of(designs).plausible;
        let (p, cut) = (&self.plausible, &self.cut);
        let ranges = [&p.fx_n, &p.fy_n, &p.fz_n, &p.my_nm, &p.mz_nm];
        let cuts = [&cut.fx_n, &cut.fy_n, &cut.fz_n, &cut.my_nm, &cut.mz_nm];
        for (i, key) in LOADS.into_iter().enumerate() {
            let ([low, high], most) = (m.plausible.load[i], m.overload[i]);
            if let Some(said) = ranges[i] {
                let [least, most] = RANGES.map(|part| part * usual.load[i][1]);
                let key = format!("plausible.{key}");
                let value = if high > -low { high } else { low };
                let question = if i < 3 {
                    "is it in N?"
                } else {
                    "is it in N m?"
                };
                doubts.unusual(r.place(said.span()), (&key, value), least..=most, question);
            }
            let Some(said) = cuts[i] else { continue };
            let value = *said.get_ref();
            let leaves = if !(low..=high).contains(&value) {
                let [low, high] = [low, high].map(short);
                format!("is plausible from {low} to {high}: records of it are not believed")
            } else if value.abs() > most {
                format!("is an overload above {}: it raises the alarm", short(most))
            } else {
                continue;
            };
            let message = format!(
                "`cut.{key}` is {value}, and `{key}` {leaves}; is one of them in another unit?"
            );
            doubts.tell(r.place(said.span()), message);
        }
        if let Some(said) = &p.speed_rpm {
            let (place, value) = (r.place(said.span()), *said.get_ref());
            let [least, most] = SPEEDS.map(|part| (part * usual.speed * 30.0 / PI).round());
            doubts.unusual(
                place,
                ("plausible.speed_rpm", value),
                least..=most,
                "is it in rpm?",
            );
        }
        if let Some(said) = &cut.speed_rpm {
            // By default it is that of fast spindles: the fastest ones are twice as fast.
            let most = m.plausible.speed * if p.speed_rpm.is_some() { 1.0 } else { 2.0 };
            let (value, most) = (*said.get_ref(), most * 30.0 / PI);
            if value.abs() > most {
                let message = format!(
                    "`cut.speed_rpm` is {value}, and `plausible.speed_rpm` {}: records of it are not believed; is one of them in another \
                     unit?",
                    short(most)
                );
                doubts.tell(r.place(said.span()), message);
            }
        }
        for alarm in &ALARMS {
            let (alarm, [limit, ..], _, keys) = *alarm;
            let (name, (unit, _)) = (alarm.name(), alarm.unit());
            let usual = match (alarm, unit) {
                (_, "GPa") => PRESSURES,
                (_, "%") => LEAST_PERCENT * limit..=MOST_PERCENT,
                (Alarm::Slip, _) => 0.0..=1.0,
                _ => continue,
            };
            if let Some(said) = &keys(&self.alarm).limit {
                let key = format!("alarm.{name}.limit");
                let unit = if unit.is_empty() { "a part of 1" } else { unit };
                doubts.unusual(
                    r.place(said.span()),
                    (&key, *said.get_ref()),
                    usual,
                    &format!("is it in {unit}?"),
                );
            }
        }
    }

    /// Where loads come from.
    fn bridges(&self, r: Reading<'_>, monitor: &mut MonitorFile) -> Result<(), DesignFileError> {
        let loads = self.loads.as_ref();
        let loads = loads.map(|loads| (&**loads.get_ref(), r.place(loads.span())));
        let (counts, samples) = (&self.bridges.counts, &self.bridges.tare_samples);
        let place = last(r, [span(counts), span(samples)]);
        let counts = match (loads, counts) {
            (Some(("bridges", _)), Some(counts)) => counts.get_ref(),
            (Some(("bridges", place)), None) => {
                let message = "[monitor.bridges] lacks `counts`: of each bridge, by each load alone, per N or N m";
                return Err(r.error(place, message));
            }
            (Some(("records", _)) | None, _) if counts.is_some() || samples.is_some() => {
                let message = "[monitor.bridges] is for `loads = \"bridges\"`; add that to [monitor], or remove this";
                return Err(r.error(place, message));
            }
            (Some(("records", _)) | None, _) => return Ok(()),
            (Some((other, place)), _) => {
                let message = format!("{other:?} is none of \"records\", \"bridges\"");
                return Err(r.error(place, message));
            }
        };
        if !(5..=8).contains(&counts.len()) {
            let message = format!(
                "`counts` is of {} bridges, but must be of 5 to 8",
                counts.len()
            );
            return Err(r.error(place, message));
        }
        let loads = calibration::loads(counts).map_err(|told| r.error(place, told))?;
        monitor.bridges = Some(Bridges {
            counts: counts.clone(),
            loads: loads.by_bridge,
        });
        // A tachometer's speed is measured, and is never quite equal for ten seconds.
        monitor.plausible.speed_stuck_after = 10_000;
        Ok(())
    }

    /// Whether what is said goes together.
    fn contradictions(
        &self,
        r: Reading<'_>,
        monitor: &MonitorFile,
        reference: Option<(f64, Place)>,
    ) -> Result<(), DesignFileError> {
        let (p, t, idle) = (&self.plausible, &self.temperatures, &self.idle);
        let idle = [&idle.fx_n, &idle.fy_n, &idle.fz_n, &idle.my_nm, &idle.mz_nm];
        let ranges = [&p.fx_n, &p.fy_n, &p.fz_n, &p.my_nm, &p.mz_nm];
        for (((idle, range), load), [low, high]) in idle
            .into_iter()
            .zip(ranges)
            .zip(monitor.idle)
            .zip(monitor.plausible.load)
        {
            // Ranges by default are none where the design is none.
            if (idle.is_some() || range.is_some()) && (load < low || load > high) {
                let place = last(r, [span(idle), span(range)]);
                return Err(r.error(place, "the `idle` load must be within its plausible range"));
            }
        }
        for (holds, said, told) in CONTRADICTIONS {
            if !holds(monitor) {
                return Err(r.error(last(r, said(self)), told));
            }
        }
        let of_heat = |(key, ..): &&Number| key.starts_with("temperatures.");
        let numbers = NUMBERS
            .iter()
            .filter(of_heat)
            .map(|number| span(number.3(self)));
        let said = numbers
            .chain([span(&t.range_c), span(&t.warm_c)])
            .flatten()
            .next();
        match (reference, said) {
            (Some((reference, place)), _) if !monitor.temperatures.has(reference) => Err(r.error(
                place,
                "`reference_c` must be within `range_c` of [monitor.temperatures]",
            )),
            (None, Some(said)) => {
                let message =
                    "[monitor.temperatures] is for a spindle with [heat]; add that, or remove this";
                Err(r.error(r.place(said), message))
            }
            _ => Ok(()),
        }
    }
}
