//! The alarms, one entry each: number, name, unit, usual levels, and what they are levels of.
//!
//! A new alarm is an entry here, with the next number; its level, where a tick knows it; and a test. Thresholds by default, keys of a
//! spindle's file and their page follow from the entry.

use core::f64::consts::PI;
use core::fmt;
use enumset::EnumSetType;
use serde::{Deserialize, Serialize};

/// A unit of levels in files and tables, empty for a ratio or a number; and its size in the unit of the wire.
type Unit = (&'static str, f64);

const GPA: Unit = ("GPa", 1e9);
const DEG: Unit = ("deg", PI / 180.0);
const SECOND: Unit = ("s", 1.0);
const PERCENT: Unit = ("%", 1e-2);
const PLAIN: Unit = ("", 1.0);

/// When the levels of an alarm come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rhythm {
    /// With each estimate.
    Estimate,
    /// With each sample, which is missing after a time.
    Sample,
    /// With each tick or each second.
    Tick,
    /// With each block of the probes' readings.
    Block,
}
use Rhythm::{Block, Estimate, Sample, Tick};

/// Levels of an alarm by default, in its unit of files.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UsualLevels {
    /// The condition begins.
    pub limit: f64,
    /// It ends.
    pub clear: f64,
    /// Level that raises the alarm at once; none for never.
    pub at_once: Option<f64>,
    /// Time of the condition that must add up, ms.
    pub hold_ms: u32,
}

macro_rules! alarms {
    ($(
        #[doc = $meaning:literal]
        $alarm:ident = $number:literal, $name:literal, $unit:ident $of:literal,
        $limit:literal, $clear:literal, $at_once:expr, $hold_ms:literal, $again:literal, $rhythm:ident;
    )+) => {
        /// Alarms, with their numbers on the wire, from the most serious one to those of the monitor itself; then those of the probes.
        #[derive(Debug, EnumSetType, Serialize, Deserialize)]
        #[enumset(repr = "u16")]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub enum Alarm {
            $(#[doc = $meaning] #[serde(rename = $name)] $alarm = $number,)+
        }

        impl Alarm {
            /// All alarms, in the order of their numbers.
            pub const ALL: [Self; Self::COUNT] = [$(Self::$alarm),+];

            /// How many there are.
            pub const COUNT: usize = [$($number),+].len();

            /// Short name in lower case, as tables print it.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$alarm => $name),+ }
            }

            /// Unit of its levels in files and tables, empty for a ratio or a number; and that unit in the one of the wire.
            pub const fn unit(self) -> (&'static str, f64) {
                match self { $(Self::$alarm => $unit),+ }
            }

            /// Meaning of its levels in a file, with their unit.
            pub const fn level_of(self) -> &'static str {
                match self { $(Self::$alarm => $of),+ }
            }

            /// Its levels by default.
            pub const fn usual(self) -> UsualLevels {
                match self {
                    $(Self::$alarm => UsualLevels {
                        limit: $limit, clear: $clear, at_once: $at_once, hold_ms: $hold_ms,
                    }),+
                }
            }

            /// Whether it is raised again, once acknowledged, where its level grows.
            const fn again(self) -> bool {
                match self { $(Self::$alarm => $again),+ }
            }

            /// When its levels come.
            pub(crate) const fn rhythm(self) -> Rhythm {
                match self { $(Self::$alarm => $rhythm),+ }
            }
        }
    };
}

// Number on the wire, name, unit, meaning of the level in a file; by default: limit, clear, at once, hold time in ms; whether it is raised
// again where its level grows: a time without a measurement grows by itself; when its levels come.
alarms! {
    /// Peak contact pressure, Pa.
    PeakPressure = 0, "peak-pressure", GPA "GPa", 2.0, 1.9, Some(2.5), 100, true, Estimate;
    /// A contact near or past the edge of its shoulder: contact angle less the shoulder's, rad.
    ContactAngle = 1, "contact-angle", DEG "degrees beyond the shoulder's", 0.0, -2.0, None, 100, true, Estimate;
    /// Gross slip is to be suspected: friction force that the gyroscopic moment calls for over contact force.
    Slip = 2, "slip", PLAIN "friction over contact force", 0.06, 0.05, None, 500, true, Estimate;
    /// Balls off the inner race: their number.
    UnloadedBalls = 3, "unloaded-balls", PLAIN "balls", 0.5, 0.25, None, 500, true, Estimate;
    /// Preload that has grown: in the row with the most, over the mounted preload.
    PreloadGrowth = 4, "preload-growth", PLAIN "times the mounted preload", 4.0, 3.5, None, 1000, true, Estimate;
    /// Preload that is lost: in the row with the least, as a part of 1 of the mounted preload.
    PreloadLoss = 5, "preload-loss", PERCENT "% of the mounted preload", 80.0, 70.0, None, 500, true, Estimate;
    /// Measured loads, doubted or not, over the loads allowed: the largest of five parts of 1.
    Overload = 6, "overload", PERCENT "% of `[monitor.overload]`", 100.0, 90.0, None, 3, true, Sample;
    /// Rating life used up, part of 1.
    LifeUsed = 7, "life-used", PERCENT "% of the rating life", 80.0, 79.0, None, 0, true, Tick;
    /// Samples have been doubted for a time: seconds since the last good one.
    Sensor = 8, "sensor", SECOND "s since a good sample", 0.1, 0.05, None, 0, false, Tick;
    /// A temperature has not been measured for a time: seconds since the last good one.
    Temperature = 9, "temperature", SECOND "s since a good temperature", 5.0, 1.0, None, 0, false, Tick;
    /// The monitor is blind: ticks of a second without a fresh estimate, part of 1.
    Availability = 10, "availability", PERCENT "% of ticks without a fresh estimate", 10.0, 5.0, None, 0, true, Tick;
    /// Ticks miss their deadline: how many within the last second or two.
    Deadline = 11, "deadline", PLAIN "ticks missed in two seconds", 10.0, 5.0, None, 0, true, Tick;
    /// A probe sees more motion than at commissioning, which the preload does not explain: change of its gain, part of 1.
    StiffnessLoss = 12, "stiffness-loss", PERCENT "% more motion at a probe than preload explains", 5.0, 4.0, None, 0, true, Block;
    /// A probe sees less motion than at commissioning, which the preload does not explain.
    StiffnessGain = 13, "stiffness-gain", PERCENT "% less motion at a probe than preload explains", 5.0, 4.0, None, 0, true, Block;
    /// A probe does not follow the loads: 1, else 0.
    Probe = 14, "probe", PLAIN "1 for a probe that does not follow the loads, else 0", 0.5, 0.25, None, 0, true, Block;
    /// The preload has changed since commissioning, in either direction: part of 1.
    PreloadChange = 15, "preload-change", PERCENT "% of change of the preload since commissioning", 15.0, 10.0, None, 0, true, Block;
}

impl Alarm {
    /// Its threshold with these levels, in its unit of files: the limit, the level that clears it and the one that is not waited for,
    /// if there is one. The condition must have stood for `hold_us`.
    ///
    /// Acknowledged, it is raised again where its level has grown by a quarter of the limit, or by as much as it needs to clear, if that is
    /// more.
    pub const fn threshold(
        self,
        limit: f64,
        clear: f64,
        at_once: Option<f64>,
        hold_us: u32,
    ) -> Threshold {
        let (_, size) = self.unit();
        let [limit, clear] = [limit * size, clear * size];
        let worse = (0.25 * limit).max(limit - clear);
        Threshold {
            raise: limit as f32,
            clear: clear as f32,
            hold_us,
            at_once: match at_once {
                Some(level) => Some((level * size) as f32),
                None => None,
            },
            worse: if self.again() {
                Some(worse as f32)
            } else {
                None
            },
        }
    }

    /// Thresholds of all alarms by default, in the order of their numbers.
    pub(crate) const fn usual_thresholds() -> [Threshold; Self::COUNT] {
        let mut all = [Self::PeakPressure.threshold(0.0, 0.0, None, 0); Self::COUNT];
        let mut i = 0;
        while i < Self::COUNT {
            let UsualLevels {
                limit,
                clear,
                at_once,
                hold_ms,
            } = Self::ALL[i].usual();
            all[i] = Self::ALL[i].threshold(limit, clear, at_once, hold_ms * 1000);
            i += 1;
        }
        all
    }
}

impl fmt::Display for Alarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// When an alarm is raised, and when its condition is gone.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Threshold {
    /// The condition begins at this level.
    pub raise: f32,
    /// The condition ends at this level, below `raise`.
    pub clear: f32,
    /// So much of its time must add up, us.
    pub hold_us: u32,
    /// This level raises the alarm at once; none for never.
    pub at_once: Option<f32>,
    /// An acknowledged alarm is raised again where its level has grown by this since; none for never.
    pub worse: Option<f32>,
}

impl Threshold {
    /// `clear` below `raise`, `at_once` not below, and `worse` positive; all of them numbers.
    pub(crate) const fn is_sound(&self) -> bool {
        let Self {
            raise,
            clear,
            at_once,
            worse,
            ..
        } = *self;
        raise.is_finite()
            && clear.is_finite()
            && clear < raise
            && match at_once {
                Some(level) => level.is_finite() && level >= raise,
                None => true,
            }
            && match worse {
                Some(step) => step.is_finite() && step > 0.0,
                None => true,
            }
    }

    /// Whether this level raises the alarm at once.
    pub(crate) fn is_at_once(&self, level: f32) -> bool {
        self.at_once.is_some_and(|at_once| level >= at_once)
    }
}
