//! Availability: the share of ticks with a fresh estimate, in the last second and minute.

use super::plausibility::seconds;

/// Ticks, and ticks with a fresh estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Span {
    ticks: u32,
    fresh: u32,
}

impl Span {
    /// Part of 1; all of nothing.
    fn share(self) -> f32 {
        if self.ticks == 0 {
            return 1.0;
        }
        self.fresh as f32 / self.ticks as f32
    }

    const fn add(&mut self, other: Self) {
        self.ticks = self.ticks.saturating_add(other.ticks);
        self.fresh = self.fresh.saturating_add(other.fresh);
    }
}

/// Spans that a minute is made of, of ten seconds each.
const SPANS: usize = 6;

/// The last second, and the last minute to ten seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Availability {
    /// The second that runs, and when it began; how many of the present ten seconds are over.
    second: Span,
    began_us: u64,
    over: u8,
    last: Span,
    spans: [Span; SPANS],
    /// Ticks that did not begin, as of the last tick.
    missed: u64,
}

impl Availability {
    /// Before the first tick.
    pub const NEW: Self = Self {
        second: Span { ticks: 0, fresh: 0 },
        began_us: 0,
        over: 0,
        last: Span { ticks: 0, fresh: 0 },
        spans: [Span { ticks: 0, fresh: 0 }; SPANS],
        missed: 0,
    };

    /// Counts a tick, with a fresh estimate or without one, and the ticks before it that did not begin (`missed` since the
    /// start). At the end of a second, returns the share of its ticks that had none.
    pub fn count(&mut self, time_us: u64, fresh: bool, missed: u64) -> Option<f32> {
        let left_out = missed.saturating_sub(self.missed).min(u32::MAX.into()) as u32;
        self.missed = missed;
        self.second.add(Span {
            ticks: left_out.saturating_add(1),
            fresh: fresh.into(),
        });
        if seconds(self.began_us, time_us) < 1.0 {
            return None;
        }
        self.began_us = time_us;
        self.last = self.second;
        self.second = Span::default();
        if self.over == 10 {
            self.over = 0;
            self.spans.rotate_right(1);
            self.spans[0] = Span::default();
        }
        self.over += 1;
        self.spans[0].add(self.last);
        Some(1.0 - self.last.share())
    }

    /// Shares in the last second and in the last minute, parts of 1.
    pub fn shares(&self) -> [f32; 2] {
        let mut minute = self.second;
        for span in self.spans {
            minute.add(span);
        }
        [self.last.share(), minute.share()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_second_and_the_last_minute_are_told_apart() {
        let mut seen = Availability::NEW;
        let mut time = 0;
        let mut run = |seen: &mut Availability, seconds: u64, every: u64, missed: u64| {
            for _ in 0..seconds * 1000 {
                time += 1000;
                seen.count(time, time / 1000 % every == 0, missed);
            }
        };
        run(&mut seen, 100, 1, 0);
        assert_eq!(seen.shares(), [1.0, 1.0]);
        run(&mut seen, 6, 2, 0);
        let [second, minute] = seen.shares();
        assert!((second - 0.5).abs() < 2e-3 && (0.94..0.96).contains(&minute));
        // What did not begin counts.
        run(&mut seen, 1, 1, 1000);
        let [second, _] = seen.shares();
        assert!((second - 0.5).abs() < 2e-3);
        run(&mut seen, 70, 1, 1000);
        assert_eq!(seen.shares(), [1.0, 1.0]);
    }
}
