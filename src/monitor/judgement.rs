//! Alarms.

use core::fmt;
use serde::{Deserialize, Serialize};

/// What there is to warn of, the most serious first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Alarm {
    /// Peak contact pressure, Pa.
    PeakPressure,
    /// A contact near or past the edge of its shoulder: contact angle less the shoulder's, rad.
    ContactAngle,
    /// Gross slip is to be suspected: friction force that the gyroscopic moment calls for over contact
    /// force.
    Slip,
    /// Balls off the inner race: their number.
    UnloadedBalls,
    /// Stiffness lost against the baseline: part of 1, of the element that has lost most.
    StiffnessLoss,
    /// Stiffness that sinks slowly: the loss to be expected at the end of the time that the trend is
    /// looked ahead, part of 1.
    PreloadLoss,
    /// Rating life used up, part of 1.
    LifeUsed,
    /// Samples have been doubted for a time: seconds since the last good one.
    Sensor,
    /// The estimate is old: seconds since the sample it belongs to.
    StaleEstimate,
    /// Ticks miss their deadline: cycles of the worst of them.
    Deadline,
}

impl Alarm {
    /// How many there are.
    pub const COUNT: usize = 10;

    /// All alarms, the most serious first.
    pub const ALL: [Self; Self::COUNT] = [
        Self::PeakPressure,
        Self::ContactAngle,
        Self::Slip,
        Self::UnloadedBalls,
        Self::StiffnessLoss,
        Self::PreloadLoss,
        Self::LifeUsed,
        Self::Sensor,
        Self::StaleEstimate,
        Self::Deadline,
    ];

    /// Short name in lower case, as tables print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PeakPressure => "peak-pressure",
            Self::ContactAngle => "contact-angle",
            Self::Slip => "slip",
            Self::UnloadedBalls => "unloaded-balls",
            Self::StiffnessLoss => "stiffness-loss",
            Self::PreloadLoss => "preload-loss",
            Self::LifeUsed => "life-used",
            Self::Sensor => "sensor",
            Self::StaleEstimate => "stale-estimate",
            Self::Deadline => "deadline",
        }
    }

    /// Unit of what is watched; empty for a ratio or a number.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::PeakPressure => "Pa",
            Self::ContactAngle => "rad",
            Self::Slip
            | Self::UnloadedBalls
            | Self::StiffnessLoss
            | Self::PreloadLoss
            | Self::LifeUsed => "",
            Self::Sensor | Self::StaleEstimate => "s",
            Self::Deadline => "cycles",
        }
    }
}

impl fmt::Display for Alarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Where an alarm stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AlarmState {
    /// No condition, nothing to acknowledge.
    #[default]
    Clear,
    /// The condition is there, but not yet for its hold time.
    Pending,
    /// The condition stands, and nobody has acknowledged it.
    Raised,
    /// The condition stands, and somebody knows.
    Acknowledged,
    /// The condition is gone, but nobody has acknowledged it.
    Latched,
}

impl AlarmState {
    /// Short name in lower case, as tables print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clear => "clear",
            Self::Pending => "pending",
            Self::Raised => "raised",
            Self::Acknowledged => "acknowledged",
            Self::Latched => "latched",
        }
    }
}
