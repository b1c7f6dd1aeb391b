//! The beat of the monitor: a fixed rate, a deadline in cycles, and a watchdog that only a finished tick
//! feeds.
//!
//! The iterations that a solve may take follow from the deadline and from an iteration's cost on the
//! core at hand ([`CycleCost`]). A tick that takes longer all the same is counted, and so
//! are ticks that never began because of it. Nothing here allocates or waits, and every counter is good
//! for more than a century at any rate.

/// A free-running counter of the core's cycles, such as `DWT_CYCCNT`. It may wrap.
pub trait CycleCounter {
    /// Cycles so far, modulo 2^32.
    fn cycles(&mut self) -> u32;
}

/// No counter: for hosts and tests. No tick takes any cycle.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoCycles;

impl CycleCounter for NoCycles {
    fn cycles(&mut self) -> u32 {
        0
    }
}

/// Watchdog, which resets the board unless it is fed in time.
pub trait Watchdog {
    /// Called at the end of every tick that finished, and nowhere else.
    fn feed(&mut self);
}

/// No watchdog: for hosts and tests.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoWatchdog;

impl Watchdog for NoWatchdog {
    fn feed(&mut self) {}
}

/// Cost of a tick on a core, in its cycles. With a solve of `n` iterations, all ticks but one in a
/// thousand take `fixed + n iteration` at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CycleCost {
    /// Everything but iterations: bytes in, doubts, prediction or start of a solve and balls that it has to place, limits,
    /// judgement, life, telemetry, bytes out.
    pub fixed: u32,
    /// An iteration.
    pub iteration: u32,
}

impl CycleCost {
    /// Iterations that fit into a deadline; at least 1, since less is no solve.
    pub const fn iterations_within(&self, deadline: u32) -> u16 {
        if self.iteration == 0 {
            return u16::MAX;
        }
        let iterations = self.left(deadline) / self.iteration;
        if iterations == 0 {
            1
        } else if iterations > u16::MAX as u32 {
            u16::MAX
        } else {
            iterations as u16
        }
    }

    /// Cycles that a deadline leaves for iterations.
    const fn left(&self, deadline: u32) -> u32 {
        deadline.saturating_sub(self.fixed)
    }

    /// Cost with iterations so cheap that one more of them fits into a deadline. With it, the first
    /// iteration that does not fit can be measured.
    #[must_use]
    pub const fn with_an_iteration_more(self, deadline: u32) -> Self {
        Self {
            iteration: self.left(deadline) / (self.iterations_within(deadline) as u32 + 1),
            ..self
        }
    }
}

/// Widens a counter of 32 bits or fewer to 64 bits. It must be read more often than it wraps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Widened {
    mask: u32,
    last: u32,
    total: u64,
}

impl Widened {
    /// A counter of so many bits, 1 to 32, that shows `now`; counted on from 0.
    pub const fn new(bits: u8, now: u32) -> Self {
        let bits = if bits == 0 { 1 } else { bits };
        let mask = if bits >= 32 {
            u32::MAX
        } else {
            (1 << bits) - 1
        };
        Self {
            mask,
            last: now & mask,
            total: 0,
        }
    }

    /// Counts since the start, the counter showing `now`.
    pub const fn at(&mut self, now: u32) -> u64 {
        let step = now.wrapping_sub(self.last) & self.mask;
        self.last = now & self.mask;
        self.total = self.total.saturating_add(step as u64);
        self.total
    }

    /// How far `other` is ahead of `now` (behind, if negative), in counts: the nearer of the two ways
    /// around.
    pub const fn ahead(&self, other: u32, now: u32) -> i32 {
        let unused = self.mask.leading_zeros();
        // The sign bit of the narrow difference becomes the wide one's.
        ((other.wrapping_sub(now) << unused) as i32) >> unused
    }
}

/// Rate, deadline and cost of ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TickSettings {
    /// Time between ticks, us.
    pub period_us: u32,
    /// A solve is made at every so many ticks.
    pub solve_every: u16,
    /// Cycles within which a tick must finish.
    pub deadline_cycles: u32,
    /// Cost of a tick.
    pub cost: CycleCost,
    /// Iterations of a solve that starts from nothing: the first one, and the one after a solve gone
    /// astray. It may pass the deadline, which is counted, and must end before the watchdog does.
    pub cold_iterations: u16,
}

impl TickSettings {
    /// Most iterations of a solve in a tick.
    pub const fn max_iterations(&self) -> u16 {
        self.cost.iterations_within(self.deadline_cycles)
    }

    /// Cycles that all ticks with a solve of that many iterations but one in a thousand take at most.
    pub const fn most_cycles(&self) -> u64 {
        let CycleCost { fixed, iteration } = self.cost;
        fixed as u64 + self.max_iterations() as u64 * iteration as u64
    }
}

/// Counts ticks and holds them against their deadline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ticker {
    period_us: u32,
    deadline_cycles: u32,
    began_cycles: u32,
    last_us: Option<u64>,
    ticks: u64,
    overruns: u64,
    missed: u64,
    most_cycles: u32,
}

impl Ticker {
    /// Before the first tick.
    pub const fn new(settings: &TickSettings) -> Self {
        Self {
            period_us: settings.period_us,
            deadline_cycles: settings.deadline_cycles,
            began_cycles: 0,
            last_us: None,
            ticks: 0,
            overruns: 0,
            missed: 0,
            most_cycles: 0,
        }
    }

    /// A tick begins. Returns the time since the last one began, us; 0 for the first, and at most a
    /// second.
    pub fn begin(&mut self, time_us: u64, counter: &mut impl CycleCounter) -> u32 {
        self.began_cycles = counter.cycles();
        let since = self
            .last_us
            .map_or(0, |last| time_us.saturating_sub(last).min(u64::MAX / 2));
        self.last_us = Some(time_us);
        let period = u64::from(self.period_us.max(1));
        // More than half a period late is a tick that was left out.
        let late = since + period / 2;
        // 64-bit division is none of the core's: not for a tick that is in time.
        let beats = if late < period {
            0
        } else if late < 2 * period {
            1
        } else {
            late / period
        };
        self.missed = self.missed.saturating_add(beats.saturating_sub(1));
        since.min(1_000_000) as u32
    }

    /// A tick is done: counts it, feeds the watchdog, and returns whether it took longer than its
    /// deadline.
    pub fn finish(
        &mut self,
        counter: &mut impl CycleCounter,
        watchdog: &mut impl Watchdog,
    ) -> bool {
        let cycles = counter.cycles().wrapping_sub(self.began_cycles);
        let overrun = cycles > self.deadline_cycles;
        self.ticks = self.ticks.saturating_add(1);
        self.overruns = self.overruns.saturating_add(overrun.into());
        self.most_cycles = self.most_cycles.max(cycles);
        watchdog.feed();
        overrun
    }

    /// Ticks that finished.
    pub const fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Ticks that took longer than their deadline.
    pub const fn overruns(&self) -> u64 {
        self.overruns
    }

    /// Ticks that did not begin when they should have.
    pub const fn missed(&self) -> u64 {
        self.missed
    }

    /// Cycles of the longest tick.
    pub const fn most_cycles(&self) -> u32 {
        self.most_cycles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Steps(std::vec::Vec<u32>);
    impl CycleCounter for Steps {
        fn cycles(&mut self) -> u32 {
            self.0.remove(0)
        }
    }

    struct Fed(u32);
    impl Watchdog for Fed {
        fn feed(&mut self) {
            self.0 += 1;
        }
    }

    const SETTINGS: TickSettings = TickSettings {
        period_us: 1000,
        solve_every: 1,
        deadline_cycles: 168_000,
        cost: CycleCost::CORTEX_M4F,
        cold_iterations: 45,
    };

    #[test]
    fn the_bound_on_iterations_is_what_fits_and_never_zero() {
        let cost = CycleCost {
            fixed: 1000,
            iteration: 100,
        };
        for (deadline, iterations) in [
            (0, 1),
            (1099, 1),
            (1199, 1),
            (1200, 2),
            (u32::MAX, u16::MAX),
        ] {
            assert_eq!(cost.iterations_within(deadline), iterations, "{deadline}");
        }
        let mut cost = CycleCost::CORTEX_M4F;
        for iterations in cost.iterations_within(168_000) + 1..15 {
            cost = cost.with_an_iteration_more(168_000);
            assert_eq!(cost.fixed, CycleCost::CORTEX_M4F.fixed);
            assert_eq!(cost.iterations_within(168_000), iterations);
        }
        let free = CycleCost {
            fixed: 0,
            iteration: 0,
        };
        assert_eq!(free.iterations_within(0), u16::MAX);
    }

    #[test]
    fn a_tick_across_the_wrap_of_the_counter_is_as_long_as_any() {
        let mut ticker = Ticker::new(&SETTINGS);
        let mut counter = Steps(std::vec![u32::MAX - 99, 100, 5, 168_005, 5, 168_006]);
        let mut dog = Fed(0);
        let mut overruns = std::vec![];
        for i in 0..3 {
            ticker.begin(i * 1000, &mut counter);
            overruns.push(ticker.finish(&mut counter, &mut dog));
        }
        assert_eq!(overruns, [false, false, true]);
        assert_eq!((ticker.ticks(), ticker.overruns(), dog.0), (3, 1, 3));
        assert_eq!(ticker.most_cycles(), 168_001);
    }

    #[test]
    fn ticks_that_were_left_out_are_counted() {
        let mut ticker = Ticker::new(&SETTINGS);
        let mut time = 0;
        for step in [0, 1000, 1400, 600, 3000, 1000, 1600] {
            time += step;
            ticker.begin(time, &mut Steps(std::vec![0]));
        }
        // 3000 is two too few, 1600 one.
        assert_eq!(ticker.missed(), 3);
        // A clock that goes back, or leaps, neither panics nor makes life of nothing.
        assert_eq!(ticker.begin(0, &mut Steps(std::vec![0])), 0);
        assert_eq!(ticker.begin(u64::MAX, &mut Steps(std::vec![0])), 1_000_000);
    }

    #[test]
    fn a_narrow_counter_is_followed_across_its_wraps() {
        for bits in [1, 8, 16, 24, 31, 32] {
            let mask = (u64::from(u32::MAX) >> (32 - bits)) as u32;
            let mut widened = Widened::new(bits, 0xdead_beef);
            let (mut truth, mut shown) = (0_u64, 0xdead_beef_u32 & mask);
            for i in 0..1000_u32 {
                let step = i.wrapping_mul(0x9E37_79B9) & mask;
                truth += u64::from(step);
                shown = shown.wrapping_add(step) & mask;
                assert_eq!(widened.at(shown), truth, "{bits} bits");
            }
        }
        let sixteen = Widened::new(16, 0);
        assert_eq!(sixteen.ahead(2, 0xffff), 3);
        assert_eq!(sixteen.ahead(0xffff, 2), -3);
        assert_eq!(Widened::new(32, 0).ahead(0, u32::MAX), 1);
    }
}
