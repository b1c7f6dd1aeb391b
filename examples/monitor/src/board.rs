//! Report of the board on itself: why it started, and whether memory and arithmetic are sound.
//!
//! The library only carries the report: the firmware finds out. A monitor without a board has
//! [`BoardReport::NONE`].

use serde::{Deserialize, Serialize};

/// Cause of the chip's last reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ResetCause {
    /// The supply was switched on.
    PowerOn,
    /// The supply fell below the brown-out level.
    BrownOut,
    /// The reset pin was pulled low from outside.
    Pin,
    /// The independent watchdog was not fed in time, or too early where it has a window.
    Watchdog,
    /// The window watchdog was fed too early or too late.
    WindowWatchdog,
    /// The firmware, after a panic or a fault, or a debugger.
    Software,
    /// A low-power mode was entered against the option bytes.
    LowPower,
    /// The chip does not say.
    #[default]
    Unknown,
}

impl ResetCause {
    /// All of them, in the order of the format.
    pub const ALL: [Self; 8] = [
        Self::PowerOn,
        Self::BrownOut,
        Self::Pin,
        Self::Watchdog,
        Self::WindowWatchdog,
        Self::Software,
        Self::LowPower,
        Self::Unknown,
    ];

    /// Causes that explain others come first. Every reset of the chip pulls the pin, and power that
    /// comes on was below the brown-out level. A flag that the firmware failed to clear says less than a watchdog.
    const TELLING_FIRST: [Self; 7] = [
        Self::WindowWatchdog,
        Self::Watchdog,
        Self::LowPower,
        Self::Software,
        Self::PowerOn,
        Self::BrownOut,
        Self::Pin,
    ];

    /// The cause among flags of the chip, of which several may be set.
    pub fn among(is_set: impl Fn(Self) -> bool) -> Self {
        let mut causes = Self::TELLING_FIRST.into_iter();
        causes.find(|cause| is_set(*cause)).unwrap_or_default()
    }

    /// Short name in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PowerOn => "power-on",
            Self::BrownOut => "brown-out",
            Self::Pin => "pin",
            Self::Watchdog => "watchdog",
            Self::WindowWatchdog => "window-watchdog",
            Self::Software => "software",
            Self::LowPower => "low-power",
            Self::Unknown => "unknown",
        }
    }
}

/// How a self-check ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Check {
    /// It has not been made yet.
    #[default]
    NotYet,
    /// There is nothing to check against.
    Unchecked,
    /// As it should be, every time so far.
    Passed,
    /// Not as it should be, at least once. Stays until the next start.
    Failed,
}

impl Check {
    /// All of them, in the order of the format.
    pub const ALL: [Self; 4] = [Self::NotYet, Self::Unchecked, Self::Passed, Self::Failed];

    /// Short name in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotYet => "not-yet",
            Self::Unchecked => "unchecked",
            Self::Passed => "passed",
            Self::Failed => "failed",
        }
    }

    /// With another result. One that failed stays so.
    #[must_use]
    pub const fn and(self, passed: bool) -> Self {
        match self {
            Self::Failed => Self::Failed,
            _ if passed => Self::Passed,
            _ => Self::Failed,
        }
    }
}

/// Report of the board on itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BoardReport {
    /// A solve whose answer is known to the last bit.
    pub known_answer: Check,
    /// Code and constants in flash, against their checksum.
    pub image: Check,
    /// Stack that was never used since the start, bytes; `None` where nobody has measured it.
    pub unused_stack: Option<u32>,
    /// Brown-out level of the option bytes, 0 for off to 3 for the highest; `None` where there is none to read.
    pub brown_out: Option<u8>,
}

impl BoardReport {
    /// Without a board.
    pub const NONE: Self = Self {
        known_answer: Check::NotYet,
        image: Check::NotYet,
        unused_stack: None,
        brown_out: None,
    };

    /// Whether a self-check has failed.
    pub fn is_broken(&self) -> bool {
        [self.known_answer, self.image].contains(&Check::Failed)
    }

    /// Whether another report says something else besides the stack, which is measured again and again.
    pub(crate) fn differs(&self, other: &Self) -> bool {
        let unused_stack = self.unused_stack;
        *self
            != Self {
                unused_stack,
                ..*other
            }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the chips set their flags: reference manuals RM0090, 7.3.21, and RM0433, table 56.
    #[test]
    fn the_cause_of_a_reset_is_found_behind_the_flags_that_it_brings_along() {
        use ResetCause::{BrownOut, LowPower, Pin, PowerOn, Software, Watchdog, WindowWatchdog};
        for (set, cause) in [
            (&[PowerOn, Pin, BrownOut][..], PowerOn),
            (&[Pin, BrownOut], BrownOut),
            (&[Pin], Pin),
            (&[Pin, Watchdog], Watchdog),
            (&[Pin, WindowWatchdog], WindowWatchdog),
            (&[Pin, Software], Software),
            (&[Pin, LowPower], LowPower),
            // A watchdog before the flags of the power-on were cleared.
            (&[PowerOn, Pin, BrownOut, Watchdog], Watchdog),
            (&[], ResetCause::Unknown),
        ] {
            let found = ResetCause::among(|cause| set.contains(&cause));
            assert_eq!(found, cause, "{set:?}");
        }
    }

    #[test]
    fn a_check_that_failed_once_has_failed() {
        assert_eq!(Check::NotYet.and(true), Check::Passed);
        assert_eq!(Check::Passed.and(true), Check::Passed);
        assert_eq!(Check::Passed.and(false), Check::Failed);
        assert_eq!(Check::Failed.and(true), Check::Failed);
    }

    #[test]
    fn a_stack_that_grows_makes_no_other_report() {
        let report = BoardReport {
            unused_stack: Some(1000),
            ..BoardReport::NONE
        };
        assert!(!report.differs(&BoardReport::NONE));
        let report = BoardReport {
            image: Check::Failed,
            ..report
        };
        assert!(report.differs(&BoardReport::NONE));
        assert!(report.is_broken());
    }
}
