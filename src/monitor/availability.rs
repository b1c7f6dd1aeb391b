//! Availability: the share of ticks with a fresh estimate, in the last second.

use super::plausibility::seconds;

/// Ticks of the second that runs, and the share of the last one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Availability {
    /// Ticks, those with a fresh estimate, and when the second began.
    ticks: u32,
    fresh: u32,
    began_us: u64,
    last: f32,
    /// Ticks that did not begin, as of the last tick.
    missed: u64,
}

impl Availability {
    /// Before the first tick.
    pub const NEW: Self = Self {
        ticks: 0,
        fresh: 0,
        began_us: 0,
        last: 1.0,
        missed: 0,
    };

    /// Counts a tick, with a fresh estimate or without one, and the ticks before it that did not begin (`missed` since the
    /// start). At the end of a second, returns the share of its ticks that had none.
    pub fn count(&mut self, time_us: u64, fresh: bool, missed: u64) -> Option<f32> {
        let left_out = missed.saturating_sub(self.missed).min(u32::MAX.into()) as u32;
        self.missed = missed;
        self.ticks = self.ticks.saturating_add(left_out).saturating_add(1);
        self.fresh = self.fresh.saturating_add(fresh.into());
        if seconds(self.began_us, time_us) < 1.0 {
            return None;
        }
        self.began_us = time_us;
        self.last = self.fresh as f32 / self.ticks as f32;
        (self.ticks, self.fresh) = (0, 0);
        Some(1.0 - self.last)
    }

    /// Share in the last second, a part of 1.
    pub const fn share(&self) -> f32 {
        self.last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_that_of_the_last_second_with_ticks_that_did_not_begin() {
        let mut seen = Availability::NEW;
        let mut time = 0;
        let mut share = |every: u64, missed: u64| {
            for _ in 0..2000 {
                time += 1000;
                seen.count(time, time / 1000 % every == 0, missed);
            }
            seen.share()
        };
        assert_eq!(share(1, 0), 1.0);
        assert!((share(2, 0) - 0.5).abs() < 2e-3);
        assert_eq!(share(1, 0), 1.0);
        let mut seen = Availability::NEW;
        for ms in 1..=1000 {
            seen.count(1000 * ms, true, 2 * ms);
        }
        assert!((seen.share() - 1.0 / 3.0).abs() < 1e-6);
    }
}
