//! The beat of the monitor: a fixed rate, a deadline in cycles, and a watchdog that only a finished tick
//! feeds.
//!
//! A solve goes on for as long as a tick has time for one more row of balls ([`SolveTime`]); the next tick takes it up there. A
//! tick that takes longer all the same is counted, and so are ticks that never began because of it. Every counter is
//! good for more than a century at any rate.

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

/// Cost of a tick's parts on a core, in its cycles, by the balls of the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CycleCost {
    /// A tick without a solve: bytes in, doubts, alarms, life, telemetry, bytes out.
    pub tick: u32,
    /// A ball in the dearest pass over its row.
    pub ball_row: u32,
    /// The step of the shaft that follows a pass over all rows.
    pub step: u32,
    /// A ball of any row in that step.
    pub ball_step: u32,
    /// The square of the number of rows in that step, besides: a shaft holds them to each other.
    pub rows_step: u32,
    /// An equilibrium that is opened in a tick, to look at it.
    pub open: u32,
    /// A ball where levels and life are taken of an equilibrium.
    pub ball_look: u32,
    /// A ball where a report is taken of an equilibrium.
    pub ball_report: u32,
    /// A probe, in any tick ([`CycleCost::with_probes`]).
    pub probe: u32,
    /// A ball where slopes at the probes are taken of an equilibrium.
    pub ball_slopes: u32,
    /// A load step at the probes, over the product of their number and that of the states.
    pub filter: u32,
}

/// The core of a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Core {
    /// Name of the chip.
    pub chip: &'static str,
    /// Frequency, Hz.
    pub hz: u32,
    /// Cost of a tick's parts.
    pub cost: CycleCost,
}

/// The cost of a tick's parts for one spindle, cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SpindleCost {
    /// The dearest pass over a row.
    pub row: u32,
    /// The step of the shaft that follows a pass over all rows.
    pub step: u32,
    /// An equilibrium that is opened in a tick, to look at it.
    pub open: u32,
    /// Levels and life of a row in it.
    pub look: u32,
    /// A report of an equilibrium.
    pub report: u32,
    /// Slopes at the probes of an equilibrium.
    pub slopes: u32,
    /// A load step at the probes.
    pub filter: u32,
}

impl CycleCost {
    /// The cost of the ticks of a spindle with so many probes, besides.
    #[must_use]
    pub const fn with_probes(self, probes: usize) -> Self {
        if probes == 0 {
            return self;
        }
        let (probes, states) = (probes as u32, 2 + 8 * probes as u32);
        Self {
            tick: self.tick.saturating_add(self.probe.saturating_mul(probes)),
            filter: self.filter.saturating_mul(probes * states),
            ..self
        }
    }

    /// The cost for a spindle of so many rows, with so many balls in all, and at most so many in a row.
    pub const fn of(&self, rows: u32, all: u32, most: u32) -> SpindleCost {
        let square = rows.saturating_mul(rows);
        let step = self.step.saturating_add(self.ball_step.saturating_mul(all));
        SpindleCost {
            row: self.ball_row.saturating_mul(most),
            step: step.saturating_add(self.rows_step.saturating_mul(square)),
            open: self.open,
            look: self.ball_look.saturating_mul(most),
            report: self.ball_report.saturating_mul(all),
            slopes: step.saturating_add(self.ball_slopes.saturating_mul(all)),
            filter: self.filter,
        }
    }
}

/// The time that a tick has for its solve.
///
/// After each row the counter of the core is asked whether the dearest pass over the next row still fits, with the step that
/// follows the last row of a pass. A counter that stands still, as on an emulator, is replaced by the cost of the parts so far:
/// never less than a counter would show.
#[derive(Debug)]
pub struct SolveTime<'c, C> {
    counter: &'c mut C,
    began: u32,
    /// Cycles for the solve, and those spent.
    most: u32,
    spent: u32,
    cost: SpindleCost,
    /// Rows in this tick, rows of the spindle, and rows of this pass that are left.
    rows: u16,
    all: u16,
    left: u16,
    looked: bool,
}

impl<C: CycleCounter> SolveTime<'_, C> {
    /// Rows that were passed.
    pub const fn rows(&self) -> u16 {
        self.rows
    }

    const fn has(&self, cycles: u32) -> bool {
        self.spent.saturating_add(cycles) <= self.most
    }

    /// Whether there is time for this part, which is then spent.
    const fn spend(&mut self, cycles: u32) -> bool {
        let has = self.has(cycles);
        if has {
            self.spent = self.spent.saturating_add(cycles);
        }
        has
    }

    fn count(&mut self) {
        let counted = self.counter.cycles().wrapping_sub(self.began);
        // Fits by `has_time`. The first part always runs: a later tick would have no more time.
        if counted > 0 && (self.rows > 0 || self.looked) {
            self.spent = counted;
        }
    }

    /// Whether there is time to take levels and life of a row, which then goes on.
    pub fn has_a_look(&mut self) -> bool {
        let open = if self.looked { 0 } else { self.cost.open };
        self.looks(self.cost.look.saturating_add(open))
    }

    /// Whether there is time to take a report of an equilibrium, which then goes on.
    pub fn has_a_report(&mut self) -> bool {
        self.looks(self.cost.report)
    }

    /// Whether there is time to take slopes of an equilibrium, which then goes on.
    pub fn has_slopes(&mut self) -> bool {
        self.looks(self.cost.slopes)
    }

    /// Whether there is time to take a load step, which then goes on.
    pub fn has_a_step(&mut self) -> bool {
        self.looks(self.cost.filter)
    }

    fn looks(&mut self, cycles: u32) -> bool {
        self.count();
        let has = self.spend(cycles);
        self.looked |= has;
        has
    }

    /// Whether a solve may begin: its prediction is a step.
    pub fn has_a_solve(&mut self) -> bool {
        self.count();
        let SpindleCost { row, step, .. } = self.cost;
        let last = if self.all == 1 { step } else { 0 };
        self.has(step.saturating_add(row).saturating_add(last)) && self.spend(step)
    }

    /// A row was passed; whether another one fits.
    pub fn has_a_row_more(&mut self) -> bool {
        let SpindleCost { row, step, .. } = self.cost;
        self.rows = self.rows.saturating_add(1);
        self.left = self.left.saturating_sub(1);
        self.spent = self.spent.saturating_add(row);
        self.count();
        if self.left == 0 {
            self.left = self.all;
            self.spent = self.spent.saturating_add(step);
        }
        let last = if self.left == 1 { step } else { 0 };
        self.has(row.saturating_add(last))
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
    /// Cycles within which a tick must finish, with the bytes that come in and go out.
    pub deadline_cycles: u32,
    /// Cost of a tick.
    pub cost: CycleCost,
}

impl TickSettings {
    /// Ticks with this period (us), all of which is theirs, on a core of this frequency with these costs.
    pub const fn new(period_us: u32, core_hz: u32, cost: CycleCost) -> Self {
        Self {
            period_us,
            deadline_cycles: core_hz / 1_000_000 * period_us,
            cost,
        }
    }

    /// Whether a tick has the time for each part of a solve, on a spindle of so many rows of so many balls: for the compiler to ask.
    pub const fn has_time(&self, rows: usize, balls: usize) -> bool {
        let SpindleCost {
            row,
            step,
            open,
            look,
            report,
            ..
        } = self
            .cost
            .of(rows as u32, (rows * balls) as u32, balls as u32);
        let left = self.deadline_cycles.saturating_sub(self.cost.tick);
        let solve = step.saturating_add(row);
        // The only row is the last one, too.
        let solve = if rows == 1 {
            solve.saturating_add(step)
        } else {
            solve
        };
        solve <= left && open.saturating_add(look) <= left && report <= left
    }

    /// Whether a tick has the time for slopes of the probes of such a spindle, too, and for a load step besides the row of a solve.
    pub const fn has_time_for_probes(&self, rows: usize, balls: usize) -> bool {
        let SpindleCost {
            row,
            step,
            slopes,
            filter,
            ..
        } = self
            .cost
            .of(rows as u32, (rows * balls) as u32, balls as u32);
        let left = self.deadline_cycles.saturating_sub(self.cost.tick);
        let solve = step.saturating_add(row);
        slopes <= left && filter.saturating_add(solve) <= left
    }
}

/// Counts ticks and holds them against their deadline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ticker {
    period_us: u32,
    deadline_cycles: u32,
    /// Cycles that a tick leaves for its solve, and the cost of its parts.
    most: u32,
    cost: SpindleCost,
    /// Rows of the spindle.
    rows: u16,
    began_cycles: u32,
    last_us: Option<u64>,
    ticks: u64,
    overruns: u64,
    missed: u64,
    most_cycles: u32,
}

impl Ticker {
    /// Before the first tick, of a spindle with so many balls in its rows.
    pub fn new(settings: &TickSettings, balls: impl IntoIterator<Item = u16>) -> Self {
        let (mut rows, mut all, mut most) = (0_u16, 0_u32, 0);
        for count in balls {
            (rows, all, most) = (rows + 1, all + u32::from(count), most.max(count));
        }
        let TickSettings {
            period_us,
            deadline_cycles,
            cost,
        } = settings;
        Self {
            period_us: *period_us,
            deadline_cycles: *deadline_cycles,
            most: deadline_cycles.saturating_sub(cost.tick),
            cost: cost.of(rows.into(), all, most.into()),
            rows,
            began_cycles: 0,
            last_us: None,
            ticks: 0,
            overruns: 0,
            missed: 0,
            most_cycles: 0,
        }
    }

    /// The time for a solve that has passed so many rows, from now on.
    pub fn solve_time<'c, C: CycleCounter>(
        &self,
        counter: &'c mut C,
        passed: u16,
    ) -> SolveTime<'c, C> {
        SolveTime {
            began: counter.cycles(),
            counter,
            most: self.most,
            spent: 0,
            cost: self.cost,
            rows: 0,
            all: self.rows,
            left: self.rows - passed % self.rows.max(1),
            looked: false,
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
        deadline_cycles: 168_000,
        cost: CycleCost {
            rows_step: 0,
            open: 0,
            tick: 10_000,
            ball_row: 1500,
            step: 6000,
            ball_step: 250,
            ball_look: 800,
            ball_report: 1000,
            probe: 0,
            ball_slopes: 500,
            filter: 740,
        },
    };

    /// Two rows of 16 balls: a tick has 158,000 cycles, a row 24,000 of them, a step 14,000, a look 25,600, a report 32,000.
    #[test]
    fn a_row_begins_only_if_it_ends_in_time_with_the_step_behind_it() {
        let rows = |counts: &[u32], passed: u16| {
            let mut counter = Steps(counts.to_vec());
            let ticker = Ticker::new(&SETTINGS, [16, 16]);
            let mut time = ticker.solve_time(&mut counter, passed);
            while time.has_a_row_more() {}
            time.rows()
        };
        // The counter stands still: by the model. Five rows and two steps take 148,000.
        assert_eq!(rows(&[7; 9], 0), 5);
        assert_eq!(rows(&[7; 9], 1), 4);
        // Cheap rows, up to one that would be the last of its pass.
        let cheap = [0, 20_000, 40_000, 60_000, 80_000, 120_001];
        assert_eq!(rows(&cheap, 0), 5);
        // A dear one, across the wrap.
        let from = u32::MAX - 50_000;
        let dear = [92_000, 120_001].map(|cycles| from.wrapping_add(cycles));
        assert_eq!(rows(&[&[from], &dear[..]].concat(), 0), 2);
        assert!(SETTINGS.has_time(2, 16) && !SETTINGS.has_time(2, 80));
    }

    #[test]
    fn figures_taken_of_an_equilibrium_leave_less_for_the_next_solve() {
        let mut counter = Steps(std::vec![7; 9]);
        let mut time = Ticker::new(&SETTINGS, [16, 16]).solve_time(&mut counter, 0);
        assert!(time.has_a_look() && time.has_a_report() && time.has_a_solve());
        // 25,600 and 32,000 and 14,000 are spent: three rows and a step more.
        while time.has_a_row_more() {}
        assert_eq!(time.rows(), 3);
        assert!(!time.has_a_report() && !time.has_a_solve());
    }

    #[test]
    fn a_part_that_just_fits_begins_a_tick_whatever_the_counter_shows() {
        // A report of 158 balls takes all that a tick leaves.
        let ticker = Ticker::new(&SETTINGS, [79, 79]);
        let mut counter = Steps(std::vec![7, 2000]);
        assert!(ticker.solve_time(&mut counter, 0).has_a_report());
        let mut counter = Steps(std::vec![7, 2000, 3000]);
        let mut time = ticker.solve_time(&mut counter, 0);
        assert!(time.has_a_look() && !time.has_a_report());
    }

    #[test]
    fn a_tick_across_the_wrap_of_the_counter_is_as_long_as_any() {
        let mut ticker = Ticker::new(&SETTINGS, [16, 16]);
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
        let mut ticker = Ticker::new(&SETTINGS, [16, 16]);
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
