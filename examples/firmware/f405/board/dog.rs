//! Registers of the watchdogs: the independent one, and the window watchdog beside it.

#![allow(
    unsafe_code,
    reason = "registers without an owner, fields without ranges"
)]

use super::clock::{CORE_HZ, Clock, INTERNAL_HZ};
use super::pac::{IWDG, WWDG};
use super::within;
use crate::MONITOR;
use spindle_firmware::dog::{self, COUNTS, FED_EVERY_US, TOO_EARLY_US};

// The registers of `IWDG`.
spindle_firmware::start_watchdog!(0x4000_3000);

/// Looks at its status before it counts as idle: some ms at least, where an update takes 0.3 ms.
const PATIENCE: u32 = 200_000;

/// Cycles of the bus in a count of the window watchdog: 4096 by 8.
const CYCLES: u32 = 4096 * 8;
/// The count that it starts from.
const FULL: u8 = 0x7f;

/// A solve is left where the time of a tick is over: on any clock, the longest tick ends well before the window does.
const fn ends_in_time(core_hz: u32, bus_hz: u32) -> bool {
    let tick_us = MONITOR.tick.deadline_cycles / (core_hz / 1_000_000);
    let window_us = 64 * (CYCLES / (bus_hz / 1_000_000));
    FED_EVERY_US + 2 * tick_us < window_us
}
const _: () = assert!(
    ends_in_time(CORE_HZ, CORE_HZ / 4) && ends_in_time(INTERNAL_HZ, INTERNAL_HZ),
    "a tick may last longer than the window watchdog waits"
);

/// Feeds the independent watchdog while the board starts.
pub fn feed_at_start() {
    dog::feed_at_start::<Watchdogs>();
}

/// Both watchdogs.
///
/// The window watchdog is on the clock of the peripheral bus, and therefore says nothing of that clock. Its limits
/// are as wide as they can be: 64 counts of 0.78 ms, of 2.05 ms on the internal oscillator.
pub struct Watchdogs {
    iwdg: IWDG,
    window: WWDG,
    /// Counts after a feeding that are too early for the next one.
    too_early: u8,
    /// The window is watched.
    is_tight: bool,
}

impl Watchdogs {
    /// The window is not watched yet, its clock is on.
    pub fn new(iwdg: IWDG, window: WWDG, clock: &Clock) -> Self {
        // USART2, which sends the log, is on the same bus.
        let counts = clock.log_hz / 1_000_000 * TOO_EARLY_US / CYCLES;
        Self {
            iwdg,
            window,
            too_early: counts.min(63) as u8,
            is_tight: false,
        }
    }
}

impl dog::Watchdogs for Watchdogs {
    fn feed_independent() {
        // SAFETY: it is always there; a write of this key feeds it, whoever writes.
        unsafe { &*IWDG::ptr() }.kr().write(|w| w.key().feed());
    }

    fn tighten(&mut self) {
        let idle = || within(PATIENCE, || self.iwdg.sr().read().bits() == 0);
        idle();
        self.iwdg.kr().write(|w| w.key().unlock());
        self.iwdg.pr().write(|w| w.pr().divide_by32());
        // SAFETY: within the register's twelve bits.
        self.iwdg.rlr().write(|w| unsafe { w.bits(COUNTS) });
        idle();
        let first = FULL.saturating_sub(self.too_early);
        // SAFETY: seven bits.
        self.window
            .cfr()
            .write(|w| unsafe { w.wdgtb().div8().w().bits(first) });
        self.is_tight = true;
        // SAFETY: likewise.
        self.window
            .cr()
            .write(|w| unsafe { w.wdga().enabled().t().bits(FULL) });
    }

    fn feed(&mut self) {
        if self.is_tight {
            // SAFETY: seven bits.
            self.window
                .cr()
                .write(|w| unsafe { w.wdga().enabled().t().bits(FULL) });
        }
        self.iwdg.kr().write(|w| w.key().feed());
    }
}
