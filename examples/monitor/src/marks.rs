//! Reasons to doubt a sample, and the watch for values that do not change.

use core::fmt;
use enumset::{EnumSet, EnumSetType};

/// One reason to doubt a sample, with the number of its bit in [`Marks`], on the wire, too.
#[derive(Debug, EnumSetType)]
#[enumset(repr = "u32")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Mark {
    /// A load is not a number: the calibration is broken, or the sender.
    NotFinite = 0,
    /// A load is beyond what the sensors, or the spindle, can carry.
    Range = 1,
    /// A load changed faster than it can.
    Rate = 2,
    /// A channel has given the same value for so long that it must be stuck.
    Stuck = 3,
    /// A converter is at its rail.
    Saturated = 4,
    /// No sample has come for too long.
    Missing = 5,
    /// Channels that must agree do not.
    Disagreement = 6,
    /// The bus, or the device on it, reported an error.
    Bus = 7,
    /// A frame was damaged, and the sample it held is lost.
    Corrupt = 8,
    /// A sample came out of its order, or twice.
    Order = 9,
    /// The front end has no tare.
    Untared = 10,
    /// The temperature is beyond what its compensation was made for, or not known.
    Temperature = 11,
    /// No speed: the signal is lost, or its source fails.
    SpeedMissing = 12,
    /// Speed beyond what the spindle does.
    SpeedRange = 13,
    /// Speed changed faster than the spindle can.
    SpeedRate = 14,
    /// Two sources of speed do not agree.
    SpeedDisagreement = 15,
    /// The last sample that was solved has no equilibrium.
    Unsolved = 16,
    /// There is no estimate yet.
    NoEstimate = 17,
    /// A record came much later than others do.
    Late = 18,
    /// The speed has been one and the same for so long that it must be stuck.
    SpeedStuck = 19,
}

impl Mark {
    /// Short name in lower case, as tables print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "not-finite",
            Self::Range => "range",
            Self::Rate => "rate",
            Self::Stuck => "stuck",
            Self::Saturated => "saturated",
            Self::Missing => "missing",
            Self::Disagreement => "disagreement",
            Self::Bus => "bus",
            Self::Corrupt => "corrupt",
            Self::Order => "order",
            Self::Untared => "untared",
            Self::Temperature => "temperature",
            Self::SpeedMissing => "speed-missing",
            Self::SpeedRange => "speed-range",
            Self::SpeedRate => "speed-rate",
            Self::SpeedDisagreement => "speed-disagreement",
            Self::Unsolved => "unsolved",
            Self::NoEstimate => "no-estimate",
            Self::Late => "late",
            Self::SpeedStuck => "speed-stuck",
        }
    }
}

impl fmt::Display for Mark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A set of marks, one bit each.
pub type Marks = EnumSet<Mark>;

/// Watches `K` channels for values that do not change any more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StuckWatch<const K: usize> {
    after: u16,
    last: [i32; K],
    same: [u16; K],
}

impl<const K: usize> StuckWatch<K> {
    /// A channel that gives one and the same value `after` times is stuck; 0 and 1 mean never.
    pub const fn new(after: u16) -> Self {
        Self {
            after,
            last: [0; K],
            same: [0; K],
        }
    }

    /// Takes the next values; whether a channel is stuck.
    pub fn watch(&mut self, values: [i32; K]) -> bool {
        let mut stuck = false;
        for ((value, last), same) in values.iter().zip(&mut self.last).zip(&mut self.same) {
            *same = if value == last && *same > 0 {
                same.saturating_add(1)
            } else {
                1
            };
            *last = *value;
            stuck |= self.after > 1 && *same >= self.after;
        }
        stuck
    }
}
