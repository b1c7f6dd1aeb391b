//! Learning the baseline: aside, so that the one in use goes on judging until the new one can take its place.

use super::baseline::{BANDS, Baseline, BaselineSettings};
use serde::{Deserialize, Serialize};

/// Where the learning of the baseline stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Learning {
    /// Nothing was learnt since the start.
    #[default]
    Off,
    /// A baseline is being learnt, the one in use being kept.
    Running,
    /// The last learnt baseline is in use.
    Taken,
    /// Too few estimates were learnt last for any band of speed: the old baseline is kept.
    TooLittle,
    /// The last learnt baseline shows a loss or a gain worth an alarm: the old baseline is kept.
    /// Another bearing has to be told of ([`Monitor::replace_bearing`](super::Monitor::replace_bearing)).
    Implausible,
}

impl Learning {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Off,
        Self::Running,
        Self::Taken,
        Self::TooLittle,
        Self::Implausible,
    ];

    /// Short name in lower case, as tables print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Running => "running",
            Self::Taken => "taken",
            Self::TooLittle => "too-little",
            Self::Implausible => "implausible",
        }
    }
}

/// The learning of the baseline, and how far it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LearningReport {
    /// Where it stands.
    pub state: Learning,
    /// Bands of speed that have enough estimates of the idling spindle, in what is being learnt or was learnt last.
    pub bands: u8,
}

impl Baseline {
    /// Bands with enough estimates.
    pub(super) fn bands(&self, settings: &BaselineSettings) -> u8 {
        let enough = |count: &&u32| **count >= settings.least_estimates.max(1);
        self.estimates.iter().filter(enough).count() as u8
    }

    /// Takes over the bands of `newer` that have enough estimates. None is taken if a band has lost or
    /// gained `most` (part of 1) of the stiffness: a loss cannot be learnt away.
    pub(super) fn take_over(
        &mut self,
        newer: &Self,
        most: f32,
        settings: &BaselineSettings,
    ) -> Learning {
        if newer.bands(settings) == 0 {
            return Learning::TooLittle;
        }
        let enough = |count: u32| count >= settings.least_estimates.max(1);
        let mut next = *self;
        for band in 0..BANDS {
            let (Some(old), Some(new)) = (self.stiffness.get(band), newer.stiffness.get(band))
            else {
                continue;
            };
            let counts = (self.estimates.get(band), newer.estimates.get(band));
            let (Some(known), Some(count)) = counts else {
                continue;
            };
            if !enough(*count) {
                continue;
            }
            let near = |(old, new): (&f32, &f32)| {
                let (less, more) = if new < old { (new, old) } else { (old, new) };
                *less > (1.0 - most) * more
            };
            if enough(*known) && !old.iter().zip(new).all(near) {
                return Learning::Implausible;
            }
            if let (Some(k), Some(n)) = (next.stiffness.get_mut(band), next.estimates.get_mut(band))
            {
                (*k, *n) = (*new, *count);
            }
        }
        *self = next;
        Learning::Taken
    }
}
