//! Reasons to doubt a sample, and the watch for values that do not change.

use core::fmt;
use serde::{Deserialize, Serialize};

/// One reason to doubt a sample, by its bit in [`Marks`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Mark {
    /// A load is not a number: the calibration is broken, or the sender.
    NotFinite,
    /// A load is beyond what the sensors, or the spindle, can carry.
    Range,
    /// A load changed faster than it can.
    Rate,
    /// A channel has given the same value for so long that it must be stuck.
    Stuck,
    /// A converter is at its rail.
    Saturated,
    /// No sample has come for too long.
    Missing,
    /// Channels that must agree do not.
    Disagreement,
    /// The bus, or the device on it, reported an error.
    Bus,
    /// A frame was damaged, and the sample it held is lost.
    Corrupt,
    /// A sample came out of its order, or twice.
    Order,
    /// The front end has no tare.
    Untared,
    /// The temperature is beyond what its compensation was made for, or not known.
    Temperature,
    /// No speed: the signal is lost, or its source fails.
    SpeedMissing,
    /// Speed beyond what the spindle does.
    SpeedRange,
    /// Speed changed faster than the spindle can.
    SpeedRate,
    /// Two sources of speed do not agree.
    SpeedDisagreement,
    /// The last sample that was solved has no equilibrium.
    Unsolved,
    /// There is no estimate yet.
    NoEstimate,
    /// A record came much later than others do.
    Late,
    /// The speed has been one and the same for so long that it must be stuck.
    SpeedStuck,
}

impl Mark {
    /// All marks, in the order of their bits from the lowest.
    pub const ALL: [Self; 20] = [
        Self::NotFinite,
        Self::Range,
        Self::Rate,
        Self::Stuck,
        Self::Saturated,
        Self::Missing,
        Self::Disagreement,
        Self::Bus,
        Self::Corrupt,
        Self::Order,
        Self::Untared,
        Self::Temperature,
        Self::SpeedMissing,
        Self::SpeedRange,
        Self::SpeedRate,
        Self::SpeedDisagreement,
        Self::Unsolved,
        Self::NoEstimate,
        Self::Late,
        Self::SpeedStuck,
    ];

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
#[derive(Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Marks(u32);

impl Marks {
    /// No doubt.
    pub const NONE: Self = Self(0);

    /// One bit for each mark, in the order of [`Mark::ALL`] from the lowest.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Whether there is no doubt.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether this one is in it.
    pub const fn contains(self, mark: Mark) -> bool {
        self.0 & (1 << mark as u32) != 0
    }

    /// This set with one mark more.
    #[must_use]
    pub const fn with(self, mark: Mark) -> Self {
        Self(self.0 | (1 << mark as u32))
    }

    /// Whether there is nothing in it that is not in the other set.
    pub const fn is_within(self, other: Self) -> bool {
        self.0 & !other.0 == 0
    }

    /// Marks in either set.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Adds a mark if `doubted`.
    pub const fn mark_if(&mut self, doubted: bool, mark: Mark) {
        if doubted {
            *self = self.with(mark);
        }
    }

    /// The marks in it, in the order of [`Mark::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Mark> {
        Mark::ALL
            .into_iter()
            .filter(move |mark| self.contains(*mark))
    }
}

impl From<Mark> for Marks {
    fn from(mark: Mark) -> Self {
        Self::NONE.with(mark)
    }
}

impl fmt::Debug for Marks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

/// Names, a blank between two of them.
impl fmt::Display for Marks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, mark) in self.iter().enumerate() {
            f.write_str(if i == 0 { "" } else { " " })?;
            f.write_str(mark.name())?;
        }
        Ok(())
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Marks {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "[");
        for (i, mark) in self.iter().enumerate() {
            if i > 0 {
                defmt::write!(f, ", ");
            }
            defmt::write!(f, "{=str}", mark.name());
        }
        defmt::write!(f, "]");
    }
}

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
