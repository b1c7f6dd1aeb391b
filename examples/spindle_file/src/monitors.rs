//! The monitor of a spindle file: `[monitor]`, all of which may be left out.
//!
//! `KEYS` has a line for each number. `docs/monitor_keys.md` is made of it. What is not said is as [`MonitorSettings::of`] has it
//! for the file's bearings.

use crate::calibration;
use crate::designs::DesignFile;
use crate::doubts::Doubts;
use crate::plan::MOST_ROWS;
use crate::reading::{DesignFileError, Place, Reading, short};
use serde::de::DeserializeOwned;
use spindle_monitor::alarms::Threshold;
use spindle_monitor::{Alarm, MonitorSettings, RowSettings, TemperatureSettings};
use std::f64::consts::PI;
use std::ops::RangeInclusive;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// Settings of a file's monitor. Rows, shaft and core are added where all of the file is known.
pub(crate) type Settings = MonitorSettings<MOST_ROWS>;

/// Settings of a board's sensors.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensors {
    /// Loads `Fx, Fy, Fz` (N), `My, Mz` (N m) of the idling spindle, to start from. No bridge can tell them from its zero.
    pub idle: [f32; 5],
    /// The tachometer, beside bridges.
    pub tachometer: Tachometer,
    /// Loads come from bridges at the board; else they come as records.
    pub bridges: Option<Bridges>,
    /// Samples of a tare of the bridges.
    pub tare_samples: u16,
    /// Accuracy of a load step for the probes, part of it.
    pub load_error: f32,
    /// Accuracy of a probe's gain, part of 1.
    pub gain: f32,
}

/// The tachometer's pulses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tachometer {
    /// Pulses of a revolution.
    pub pulses_per_revolution: u16,
    /// Above this speed pulses are counted, rad/s.
    pub count_above: f32,
    /// Below this speed their period is taken, rad/s.
    pub period_below: f32,
    /// Time over which pulses are counted, us.
    pub gate_us: u32,
    /// Time without a pulse that is a standstill, us.
    pub standstill_us: u32,
}

/// Five to eight strain bridges.
#[derive(Debug, Clone, PartialEq)]
pub struct Bridges {
    /// Counts by loads, bridge by bridge: counts per N or N m.
    pub counts: Vec<[f64; 5]>,
    /// Loads by counts, bridge by bridge: N or N m per count, the least squares of `counts`.
    pub loads: Vec<[f64; 5]>,
}

impl Sensors {
    pub(crate) const USUAL: Self = Self {
        idle: [0.0; 5],
        tachometer: Tachometer {
            pulses_per_revolution: 4,
            count_above: (3820.0 * RPM) as f32,
            period_below: (2865.0 * RPM) as f32,
            gate_us: 5000,
            standstill_us: 500_000,
        },
        bridges: None,
        tare_samples: 1000,
        load_error: 0.02,
        gain: 0.1,
    };
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

/// Where the value of a key goes, in SI units.
enum Target<'m> {
    Number(&'m mut f32),
    /// None for any.
    Bound(&'m mut Option<f32>),
    /// Microseconds.
    Time(&'m mut u32),
    Count(&'m mut u16),
    Pair(&'m mut [f32; 2]),
    /// Lowest and highest.
    Ends(&'m mut [f32; 2]),
    /// The plausible range of this load.
    Range(&'m mut Settings, usize),
    /// Read by `Said::bridges`.
    Bridges,
}
use Target::{Bound, Count, Ends, Number, Pair, Range, Time};

/// A unit in files, and its size in the unit of the settings. `{N}` is N or N m, by the load.
type Unit = (&'static str, f64);

const RPM: f64 = PI / 30.0;
const MS: Unit = ("ms", 1e3);
const LOAD: Unit = ("{N}", 1.0);
const LOAD_RATE: Unit = ("{N}/ms", 1e3);
const SPEED: Unit = ("rpm", RPM);
const KELVIN: Unit = ("K", 1.0);
const PLAIN: Unit = ("", 1.0);

/// Least and largest value, in the unit of the file.
type Bounds = [f64; 2];

const POSITIVE: Bounds = [1e-6, 1e12];
const AMOUNT: Bounds = [0.0, 1e9];
const ANY: Bounds = [-1e9, 1e9];
/// Milliseconds that microseconds of 32 bits reach.
const TIME: Bounds = [1.0, 4e6];
const SHORT_TIME: Bounds = [1e-3, 4e6];
/// Of errors of sensors, %.
const PERCENTS: Bounds = [0.1, 50.0];
/// Of a number of things.
const COUNT: Bounds = [0.0, 65_535.0];
const SOME: Bounds = [1.0, 65_535.0];

/// A key of `[monitor]`: path, unit, bounds, where it goes, default, meaning. `{load}` in the path stands for each of five loads, which
/// the function counts. The default is in words where it follows from the spindle; else it is a value of the settings.
struct Key(
    &'static str,
    Unit,
    Bounds,
    for<'m> fn(&'m mut Settings, &'m mut Sensors, usize) -> Target<'m>,
    &'static str,
    &'static str,
);

fn temperatures(settings: &mut Settings) -> &mut TemperatureSettings {
    let usual = TemperatureSettings::SPINDLE;
    settings.temperatures.get_or_insert(usual)
}

/// In the order in which they count: rates and overload follow from ranges, and are set after them.
#[rustfmt::skip]
const KEYS: [Key; 37] = [
    Key("period_ms", MS, [1.0, 10.0], |m, _, _| Time(&mut m.tick.period_us), "", "period of a tick, 1 to 10"),
    Key("loads", PLAIN, ANY, |_, _, _| Target::Bridges, "`\"records\"`", "`\"records\"` come over the port; `\"bridges\"` are at the board, with a tachometer"),
    Key("idle.{load}", LOAD, ANY, |_, s, i| Number(&mut s.idle[i]), "", "{name}, within its plausible range"),
    Key("plausible.{load}", LOAD, [-1e12, 1e12], |m, _, i| Range(m, i), "± 6 % of the sum of the rows' `C`{arm}", "lowest and highest {name}"),
    Key("plausible.{load}_per_ms", LOAD_RATE, POSITIVE, |m, _, i| Number(&mut m.plausibility.load_rate[i]), "0.4 of half the range of `{load}`", "fastest change of the {name}"),
    Key("plausible.stuck_after", PLAIN, COUNT, |m, _, _| Count(&mut m.plausibility.stuck_after), "", "equal samples in a row that mean a stuck channel; 0 for never"),
    Key("plausible.missing_ms", MS, TIME, |m, _, _| Time(&mut m.plausibility.missing_after_us), "", "time without a sample after which loads are missing; a tick at least"),
    Key("plausible.fresh_ms", MS, TIME, |m, _, _| Time(&mut m.plausibility.fresh_us), "", "age beyond which an estimate is no longer fresh; a tick at least"),
    Key("plausible.residual_counts", ("counts", 1.0), POSITIVE, |m, _, _| Bound(&mut m.plausibility.residual), "any", "largest disagreement of more than five bridges"),
    Key("plausible.speed_rpm", SPEED, [1.0, 1e6], |m, _, _| Number(&mut m.plausibility.speed), "`n dm` = 1.8e6 mm/min, of the largest `dm`", "highest speed in either direction"),
    Key("plausible.speed_rpm_per_ms", ("rpm/ms", 1e3 * RPM), POSITIVE, |m, _, _| Number(&mut m.plausibility.speed_rate), "", "fastest change of speed, from tick to tick"),
    Key("plausible.deceleration_rpm_per_s", ("rpm/s", RPM), POSITIVE, |m, _, _| Number(&mut m.plausibility.deceleration), "", "greatest deceleration by the brake, and more; a faster stop is a lost signal"),
    Key("plausible.speed_stuck_after", PLAIN, COUNT, |m, _, _| Count(&mut m.plausibility.speed_stuck_after), "never with records, 10,000 with bridges", "equal speeds in a row, other than 0, that mean a stuck signal; 0 for never"),
    Key("plausible.speed_difference_rpm", SPEED, [0.0, 1e6], |m, _, _| Number(&mut m.plausibility.speed_difference[0]), "", "how much two sources of speed may differ"),
    Key("plausible.speed_difference_percent", ("%", 1e-2), [0.0, 100.0], |m, _, _| Number(&mut m.plausibility.speed_difference[1]), "", "besides, as a part of the speed"),
    Key("overload.{load}", LOAD, POSITIVE, |m, _, i| Number(&mut m.overload[i]), "the larger amount of its plausible range", "largest {name} that the spindle may carry"),
    Key("accuracy.{load}", LOAD, AMOUNT, |m, _, i| Number(&mut m.accuracy[i]), "1 % of the larger amount of its plausible range", "error of the {name}"),
    Key("temperatures.range_c", ("°C", 1.0), [-1e12, 1e12], |m, _, _| Ends(&mut temperatures(m).range), "", "lowest and highest"),
    Key("temperatures.difference_k", KELVIN, POSITIVE, |m, _, _| Number(&mut temperatures(m).difference), "", "how much both sides may differ"),
    Key("temperatures.rate_k_per_s", ("K/s", 1.0), POSITIVE, |m, _, _| Number(&mut temperatures(m).rate), "", "fastest change of a side"),
    Key("temperatures.noise_k", KELVIN, [0.0, 1e3], |m, _, _| Number(&mut temperatures(m).noise), "", "change that needs no time: steps and noise of the sensors"),
    Key("temperatures.missing_ms", MS, TIME, |m, _, _| Time(&mut temperatures(m).missing_after_us), "", "time without a good value after which a side is not measured any more"),
    Key("temperatures.hold_ms", MS, TIME, |m, _, _| Time(&mut temperatures(m).hold_us), "", "time for which the last good value is held; `missing_ms` at least"),
    Key("temperatures.warm_c", ("°C", 1.0), [-1e12, 1e12], |m, _, _| Pair(&mut temperatures(m).warm), "", "inner and outer side of the warm spindle, assumed after that"),
    Key("tachometer.pulses_per_revolution", PLAIN, SOME, |_, s, _| Count(&mut s.tachometer.pulses_per_revolution), "", "pulses of a revolution"),
    Key("tachometer.count_above_rpm", SPEED, POSITIVE, |_, s, _| Number(&mut s.tachometer.count_above), "", "above this speed, pulses are counted"),
    Key("tachometer.period_below_rpm", SPEED, POSITIVE, |_, s, _| Number(&mut s.tachometer.period_below), "", "below this speed, their period is taken; less than `count_above_rpm`"),
    Key("tachometer.gate_ms", MS, SHORT_TIME, |_, s, _| Time(&mut s.tachometer.gate_us), "", "time over which pulses are counted"),
    Key("tachometer.standstill_ms", MS, TIME, |_, s, _| Time(&mut s.tachometer.standstill_us), "", "time without a pulse that is a standstill"),
    Key("bridges.counts", ("counts per N, N m", 1.0), ANY, |_, _, _| Target::Bridges, "must be there", "a row of five for each of 5 to 8 bridges: counts by each load alone (`cargo calibrate`)"),
    Key("bridges.tare_samples", PLAIN, SOME, |_, s, _| Count(&mut s.tare_samples), "", "samples of a tare"),
    Key("probes.load_error_percent", ("%", 1e-2), PERCENTS, |_, s, _| Number(&mut s.load_error), "", "error of a load step in any direction, part of it: gains and cross-talk of the load cells"),
    Key("probes.gain_percent", ("%", 1e-2), PERCENTS, |_, s, _| Number(&mut s.gain), "", "error of a probe's gain"),
    Key("telemetry.estimate_ms", MS, SHORT_TIME, |m, _, _| Time(&mut m.telemetry.estimate_us), "", "time between estimates"),
    Key("telemetry.balls_ms", MS, SHORT_TIME, |m, _, _| Time(&mut m.telemetry.balls_us), "100 a row, 200 at least", "time between pictures of all balls"),
    Key("telemetry.health_ms", MS, SHORT_TIME, |m, _, _| Time(&mut m.telemetry.health_us), "", "time between reports of health"),
    Key("telemetry.standing_ms", MS, SHORT_TIME, |m, _, _| Time(&mut m.telemetry.standing_us), "", "time after which an alarm that stands is sent again"),
];

/// Keys of the five loads, their names, their units, and the arm on which a cutter's force makes a moment.
const LOADS: [(&str, &str, &str, &str); 5] = [
    ("fx_n", "axial force", "N", ""),
    ("fy_n", "radial force", "N", ""),
    ("fz_n", "radial force", "N", ""),
    (
        "my_nm",
        "moment about y",
        "N m",
        " times 1.4 times the mean `dm`",
    ),
    (
        "mz_nm",
        "moment about z",
        "N m",
        " times 1.4 times the mean `dm`",
    ),
];

/// Keys of each alarm, `alarm.NAME.KEY`, with their meanings.
pub const OF_ALARM: [(&str, &str); 4] = [
    ("limit", "level at which the condition begins"),
    ("clear", "level at which it ends, below `limit`"),
    ("hold_ms", "time of the condition that must add up"),
    ("at_once", "level that is not waited for, `limit` at least"),
];

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

/// A condition, the keys that may break it, and its words.
type Contradiction = (
    fn(&Settings, &Sensors) -> bool,
    [&'static str; 2],
    &'static str,
);

#[rustfmt::skip]
const CONTRADICTIONS: [Contradiction; 8] = [
    (|m, _| m.plausibility.missing_after_us >= m.tick.period_us, ["plausible.missing_ms", "period_ms"],
        "`missing_ms` must be `period_ms` at least"),
    (|m, _| m.plausibility.fresh_us >= m.tick.period_us, ["plausible.fresh_ms", "period_ms"],
        "`fresh_ms` must be `period_ms` at least"),
    (|m, _| m.plausibility.stuck_after != 1, ["plausible.stuck_after"; 2],
        "`stuck_after` must be 0, for never, or at least 2"),
    (|m, _| m.plausibility.speed_stuck_after != 1, ["plausible.speed_stuck_after"; 2],
        "`speed_stuck_after` must be 0, for never, or at least 2"),
    (|m, _| m.plausibility.speed_difference != [0.0; 2], ["plausible.speed_difference_rpm", "plausible.speed_difference_percent"],
        "`speed_difference_rpm` and `speed_difference_percent` must not both be 0"),
    (|m, _| m.temperatures.is_none_or(|t| t.warm.into_iter().all(|side| t.has(side))), ["temperatures.warm_c", "temperatures.range_c"],
        "`warm_c` must be within `range_c`"),
    (|m, _| m.temperatures.is_none_or(|t| t.hold_us >= t.missing_after_us), ["temperatures.hold_ms", "temperatures.missing_ms"],
        "`hold_ms` must be `missing_ms` at least"),
    (|_, s| s.tachometer.period_below < s.tachometer.count_above, ["tachometer.period_below_rpm", "tachometer.count_above_rpm"],
        "`period_below_rpm` must be below `count_above_rpm`"),
];

impl Key {
    /// Loads that it stands for; one that is none where it is about no load.
    fn loads(&self) -> impl Iterator<Item = usize> {
        0..if self.0.contains("{load}") { 5 } else { 1 }
    }

    /// Text about it for this load.
    fn text(&self, text: &str, load: usize) -> String {
        let (key, name, unit, arm) = LOADS[load];
        text.replace("{load}", key)
            .replace("{name}", name)
            .replace("{N}", unit)
            .replace("{arm}", arm)
    }

    /// Takes its value where it is said.
    fn take(
        &self,
        said: &Said<'_, '_>,
        (settings, sensors): (&mut Settings, &mut Sensors),
        load: usize,
    ) -> Result<(), DesignFileError> {
        let Self(path, (_, size), bounds, target, ..) = self;
        let path = self.text(path, load);
        let Some(value) = said.value(&path) else {
            return Ok(());
        };
        let number = |is_whole| said.bounded(&path, value, *bounds, is_whole);
        match target(settings, sensors, load) {
            Number(of) => *of = (number(false)? * size) as f32,
            Bound(of) => *of = Some((number(false)? * size) as f32),
            Time(of) => *of = (number(false)? * size).round() as u32,
            Count(of) => *of = number(true)? as u16,
            Pair(of) => *of = said.array(value)?.map(|x| x as f32),
            Ends(of) => *of = said.range(value, *bounds)?.map(|x| x as f32),
            Range(of, load) => of.set_range(load, said.range(value, *bounds)?),
            Target::Bridges => {}
        }
        Ok(())
    }

    /// Its row of the page.
    fn row(&self, load: usize) -> KeyRow {
        let Self(path, (unit, size), _, target, default, meaning) = self;
        let (mut settings, mut sensors) = (Settings::of(no_rows(), &[]), Sensors::USUAL);
        let value = |x: f64| format!("`{}`", short(x / size));
        let default = match target(&mut settings, &mut sensors, load) {
            _ if !default.is_empty() => self.text(default, load),
            Number(of) => value((*of).into()),
            Time(of) => value((*of).into()),
            Count(of) => value((*of).into()),
            Pair(of) | Ends(of) => format!("`{of:?}`").replace(".0", ""),
            Bound(_) | Range(..) | Target::Bridges => String::new(),
        };
        let path = self.text(path, load);
        let (table, name) = path.rsplit_once('.').unwrap_or(("", &path));
        KeyRow {
            path: (table.to_owned(), name.to_owned()),
            unit: self.text(unit, load),
            default,
            meaning: self.text(meaning, load),
        }
    }
}

/// Rows of a file whose rows are not known yet.
fn no_rows() -> [RowSettings; MOST_ROWS] {
    const NONE: RowSettings = RowSettings::of(spindle_bearing::LifeRating {
        inner: 1.0,
        outer: 1.0,
    });
    [NONE; MOST_ROWS]
}

/// Settings of rows of these bearings, nothing of which is said.
pub(crate) fn usual(designs: &[DesignFile]) -> Settings {
    let of = |of: &DesignFile| [of.dynamic_rating(), of.design.pitch_diameter];
    let bearings: Vec<_> = designs.iter().map(of).collect();
    Settings::of(no_rows(), &bearings)
}

/// A row of the page of keys.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyRow {
    /// Its table, such as `plausible`, empty for `[monitor]` itself; and its name there.
    pub path: (String, String),
    /// Its unit, empty for none.
    pub unit: String,
    /// Its default: in words, or in code.
    pub default: String,
    /// Its meaning.
    pub meaning: String,
}

/// Every key but those of alarms, in the order of the reader.
pub fn keys() -> Vec<KeyRow> {
    let of_key = |key: &'static Key| key.loads().map(|load| key.row(load));
    KEYS.iter().flat_map(of_key).collect()
}

/// Paths of all keys.
fn paths() -> Vec<String> {
    let of_key = |key: &'static Key| key.loads().map(|load| key.text(key.0, load));
    let of_alarm = |alarm: Alarm| OF_ALARM.map(|(key, _)| format!("alarm.{alarm}.{key}"));
    let all = KEYS.iter().flat_map(of_key);
    all.chain(Alarm::ALL.into_iter().flat_map(of_alarm))
        .collect()
}

/// The keys of `[monitor]` that a file gives.
struct Said<'t, 'v> {
    r: Reading<'t>,
    table: &'v DeTable<'t>,
}

impl<'t, 'v> Said<'t, 'v> {
    fn value(&self, path: &str) -> Option<&'v Spanned<DeValue<'t>>> {
        let mut path = path.split('.');
        let first = self.table.get(path.next()?)?;
        path.try_fold(first, |value, key| value.get_ref().get(key))
    }

    /// A number that is said.
    fn number(&self, path: &str) -> Result<Option<f64>, DesignFileError> {
        self.value(path).map(|value| self.read(value)).transpose()
    }

    /// Where the last of these stands.
    fn place(&self, paths: [&str; 2]) -> Place {
        let said = paths.into_iter().filter_map(|path| self.value(path));
        let last = said.map(Spanned::span).max_by_key(|span| span.start);
        last.map_or(Place::TOP, |span| self.r.place(span))
    }

    fn error(&self, paths: [&str; 2], message: impl Into<String>) -> DesignFileError {
        self.r.error(self.place(paths), message)
    }

    fn read<T: DeserializeOwned>(
        &self,
        value: &Spanned<DeValue<'t>>,
    ) -> Result<T, DesignFileError> {
        let value = ValueDeserializer::from(value.clone());
        T::deserialize(value).map_err(|error| self.r.refused(&error))
    }

    /// As many numbers.
    fn array<const N: usize>(
        &self,
        value: &Spanned<DeValue<'t>>,
    ) -> Result<[f64; N], DesignFileError> {
        let all: Vec<f64> = self.read(value)?;
        let count = all.len();
        all.try_into().map_err(|_| {
            let message = format!("invalid length {count}, expected an array of length {N}");
            self.r.error(self.r.place(value.span()), message)
        })
    }

    /// The lowest value within these bounds, and the highest one.
    fn range(
        &self,
        value: &Spanned<DeValue<'t>>,
        [least, most]: Bounds,
    ) -> Result<[f64; 2], DesignFileError> {
        let [low, high] = self.array(value)?;
        let message = if low < least || high > most {
            format!(
                "the range is from {low:e} to {high:e}, but must lie between {least:e} and {most:e}"
            )
        } else if (low as f32) < high as f32 {
            return Ok([low, high]);
        } else {
            format!("the range is from {low} to {high}; give the lowest value first")
        };
        Err(self.r.error(self.r.place(value.span()), message))
    }

    /// A number within its bounds.
    fn bounded(
        &self,
        key: &str,
        value: &Spanned<DeValue<'t>>,
        [least, most]: Bounds,
        is_whole: bool,
    ) -> Result<f64, DesignFileError> {
        let number: f64 = self.read(value)?;
        if (least..=most).contains(&number) && !(is_whole && number.fract() != 0.0) {
            return Ok(number);
        }
        let be = if is_whole { "be a whole number" } else { "lie" };
        let message = format!("`{key}` is {number}, but must {be} between {least} and {most}");
        Err(self.r.error(self.r.place(value.span()), message))
    }

    /// Refuses a key under `above` that the reader does not have.
    fn known(
        &self,
        table: &DeTable<'t>,
        above: &str,
        paths: &[String],
    ) -> Result<(), DesignFileError> {
        for (key, value) in table {
            let path = format!("{above}{}", key.get_ref());
            let place = |span| self.r.place(span);
            // A dot in quotes is part of a name.
            let is_name = !key.get_ref().contains('.');
            if is_name && paths.contains(&path) {
                continue;
            }
            let below = format!("{path}.");
            if !is_name || !paths.iter().any(|known| known.starts_with(&below)) {
                let mut names: Vec<String> = Vec::new();
                for known in paths.iter().filter_map(|known| known.strip_prefix(above)) {
                    let name = known.split('.').next().unwrap_or(known);
                    let name = format!("`{name}`");
                    if !names.contains(&name) {
                        names.push(name);
                    }
                }
                let message = format!(
                    "unknown field `{}`, expected one of {}",
                    key.get_ref(),
                    names.join(", ")
                );
                return Err(self.r.refusal(place(key.span()), &message));
            }
            let Some(table) = value.get_ref().as_table() else {
                let message = format!("`{}` is a table of keys", key.get_ref());
                return Err(self.r.error(place(value.span()), message));
            };
            self.known(table, &below, paths)?;
        }
        Ok(())
    }

    /// The threshold of an alarm. If the limit alone is said, the others go with it.
    fn threshold(&self, alarm: Alarm) -> Result<Threshold, DesignFileError> {
        let path = |key: &str| format!("alarm.{alarm}.{key}");
        let number = |key: &str, bounds| {
            let path = path(key);
            let value = self.value(&path);
            value
                .map(|value| self.bounded(&path, value, bounds, false))
                .transpose()
        };
        let (usual, any) = (alarm.usual(), [-1e12, 1e12]);
        // The usual limit of the contact angle is 0: its other levels keep their distance.
        let is_offset = usual.limit == 0.0;
        let bounds = if is_offset { [-90.0, 90.0] } else { POSITIVE };
        let limit = number("limit", bounds)?.unwrap_or(usual.limit);
        let along = |level: f64| match is_offset {
            true => level + limit,
            false => level * (limit / usual.limit),
        };
        let clear = number("clear", any)?.unwrap_or_else(|| along(usual.clear));
        let at_once = number("at_once", any)?.or(usual.at_once.map(along));
        let hold_ms = number("hold_ms", [0.0, TIME[1]])?.unwrap_or(usual.hold_ms.into());
        let threshold = alarm.threshold(limit, clear, at_once, (1e3 * hold_ms).round() as u32);
        let is_once_above = threshold.at_once.is_none_or(|at| at >= threshold.raise);
        let [of_limit, of_clear, of_once] = ["limit", "clear", "at_once"].map(path);
        let (other, told) = match (threshold.clear < threshold.raise, is_once_above) {
            (false, _) => (of_clear, "`clear` must be below `limit`"),
            (_, false) => (of_once, "`at_once` must be `limit` at least"),
            (true, true) => return Ok(threshold),
        };
        let message = format!("the alarm {alarm}: {told}");
        Err(self.error([&of_limit, &other], message))
    }

    /// Where loads come from.
    fn bridges(
        &self,
        settings: &mut Settings,
        sensors: &mut Sensors,
    ) -> Result<(), DesignFileError> {
        let keys = ["bridges.counts", "bridges.tare_samples"];
        let [counts, samples] = keys.map(|path| self.value(path));
        let by_bridge = |counts: &Spanned<DeValue<'t>>| match counts.get_ref().as_array() {
            Some(bridges) => bridges.iter().map(|bridge| self.array(bridge)).collect(),
            None => self.read::<Vec<[f64; 5]>>(counts),
        };
        let counts = counts.map(by_bridge).transpose()?;
        let loads = self.value("loads");
        let loads = loads.map(|loads| self.read::<String>(loads)).transpose()?;
        let counts = match (loads.as_deref(), counts) {
            (Some("bridges"), Some(counts)) => counts,
            (Some("bridges"), None) => {
                let message = "[monitor.bridges] lacks `counts`: of each bridge, by each load alone, per N or N m";
                return Err(self.error(["loads"; 2], message));
            }
            (Some("records") | None, counts) if counts.is_some() || samples.is_some() => {
                let message = "[monitor.bridges] is for `loads = \"bridges\"`; add that to [monitor], or remove this";
                return Err(self.error(keys, message));
            }
            (Some("records") | None, _) => return Ok(()),
            (Some(other), _) => {
                let message = format!("{other:?} is none of \"records\", \"bridges\"");
                return Err(self.error(["loads"; 2], message));
            }
        };
        if !(5..=8).contains(&counts.len()) {
            let message = format!(
                "`counts` is of {} bridges, but must be of 5 to 8",
                counts.len()
            );
            return Err(self.error(keys, message));
        }
        let loads = calibration::loads(&counts).map_err(|told| self.error(keys, told))?;
        sensors.bridges = Some(Bridges {
            counts,
            loads: loads.by_bridge,
        });
        // A tachometer's speed is measured, and is never quite equal for ten seconds.
        settings.plausibility.speed_stuck_after = 10_000;
        Ok(())
    }

    /// Refuses values that contradict each other.
    fn contradictions(
        &self,
        settings: &Settings,
        sensors: &Sensors,
        reference: Option<(f64, Place)>,
    ) -> Result<(), DesignFileError> {
        let loads = LOADS.map(|(load, ..)| format!("plausible.{load}"));
        for ((range, (load, ..)), (idle, [low, high])) in loads
            .iter()
            .zip(LOADS)
            .zip(sensors.idle.into_iter().zip(settings.plausibility.load))
        {
            let of_idle = format!("idle.{load}");
            // Ranges by default are none where the design is none.
            let is_said = [&of_idle, range].map(|path| self.value(path).is_some());
            if is_said.contains(&true) && (idle < low || idle > high) {
                let message = "the `idle` load must be within its plausible range";
                return Err(self.error([&of_idle, range], message));
            }
        }
        for (holds, paths, told) in CONTRADICTIONS {
            if !holds(settings, sensors) {
                return Err(self.error(paths, told));
            }
        }
        match (reference, self.value("temperatures")) {
            (Some((reference, place)), _)
                if settings
                    .temperatures
                    .is_some_and(|t| !t.has(reference as f32)) =>
            {
                let message = "`reference_c` must be within `range_c` of [monitor.temperatures]";
                Err(self.r.error(place, message))
            }
            (None, Some(said)) => {
                let message =
                    "[monitor.temperatures] is for a spindle with [heat]; add that, or remove this";
                let keys = said.get_ref().as_table().into_iter().flatten();
                let first = keys.map(|(_, value)| value.span());
                let first = first
                    .min_by_key(|span| span.start)
                    .unwrap_or_else(|| said.span());
                Err(self.r.error(self.r.place(first), message))
            }
            _ => Ok(()),
        }
    }

    /// Doubts ranges and levels in other units.
    fn doubt(
        &self,
        designs: &[DesignFile],
        settings: &Settings,
        doubts: &mut Doubts<'_>,
    ) -> Result<(), DesignFileError> {
        let usual = usual(designs).plausibility;
        for (i, (key, _, unit, _)) in LOADS.into_iter().enumerate() {
            let [low, high] = settings.plausibility.load[i].map(|x| short(x.into()));
            let range = format!("plausible.{key}");
            if self.value(&range).is_some() {
                let usual = RANGES.map(|part| part * f64::from(usual.load[i][1]));
                let value = if high >= -low { high } else { low };
                let question = format!("is it in {unit}?");
                doubts.unusual(
                    self.place([&range; 2]),
                    (&range, value),
                    usual[0]..=usual[1],
                    &question,
                );
            }
        }
        if let Some(value) = self.number("plausible.speed_rpm")? {
            let [least, most] =
                SPEEDS.map(|part| (part * f64::from(usual.speed) * 30.0 / PI).round());
            doubts.unusual(
                self.place(["plausible.speed_rpm"; 2]),
                ("plausible.speed_rpm", value),
                least..=most,
                "is it in rpm?",
            );
        }
        for alarm in Alarm::ALL {
            let (unit, _) = alarm.unit();
            let usual = match (alarm, unit) {
                (_, "GPa") => PRESSURES,
                (_, "%") => LEAST_PERCENT * alarm.usual().limit..=MOST_PERCENT,
                (Alarm::Slip, _) => 0.0..=1.0,
                _ => continue,
            };
            let path = format!("alarm.{alarm}.limit");
            if let Some(value) = self.number(&path)? {
                let unit = if unit.is_empty() { "a part of 1" } else { unit };
                let question = format!("is it in {unit}?");
                doubts.unusual(self.place([&path; 2]), (&path, value), usual, &question);
            }
        }
        Ok(())
    }
}

/// Reads `[monitor]` of a spindle with rows of these bearings; `reference` is the temperature of its `[heat]`.
pub(crate) fn read(
    r: Reading<'_>,
    table: Option<&Spanned<DeValue<'_>>>,
    designs: &[DesignFile],
    reference: Option<(f64, Place)>,
    doubts: &mut Doubts<'_>,
) -> Result<(Settings, Sensors), DesignFileError> {
    let (mut settings, mut sensors) = (usual(designs), Sensors::USUAL);
    let none = DeTable::new();
    let table = match table {
        Some(value) => value
            .get_ref()
            .as_table()
            .ok_or_else(|| r.error(r.place(value.span()), "`monitor` is a table of keys"))?,
        None => &none,
    };
    let said = Said { r, table };
    said.known(table, "", &paths())?;
    said.bridges(&mut settings, &mut sensors)?;
    temperatures(&mut settings);
    for key in &KEYS {
        for load in key.loads() {
            key.take(&said, (&mut settings, &mut sensors), load)?;
        }
    }
    for alarm in Alarm::ALL {
        settings.alarms[alarm as usize] = said.threshold(alarm)?;
    }
    said.contradictions(&settings, &sensors, reference)?;
    said.doubt(designs, &settings, doubts)?;
    settings.temperatures = reference.map(|(reference, _)| TemperatureSettings {
        reference: reference as f32,
        ..*temperatures(&mut settings)
    });
    Ok((settings, sensors))
}
