//! Registers of the watchdogs: the independent one, and the window watchdog beside it.

#![allow(
    unsafe_code,
    reason = "registers without an owner, fields without ranges"
)]

use super::clock::{CORE_HZ, INTERNAL_HZ};
use crate::dog::{self, FED_EVERY_US, TOO_EARLY_US};
use crate::stm32::MONITOR;
use crate::stm32::clock::Clock;
use crate::stm32::iwdg;
use crate::stm32::pac::{IWDG, WWDG};

/// Address of the registers of `IWDG`.
pub const IWDG_ADDRESS: u32 = 0x4000_3000;

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
        iwdg::feed();
    }

    fn tighten(&mut self) {
        iwdg::tighten(&self.iwdg);
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
        iwdg::feed();
    }
}
