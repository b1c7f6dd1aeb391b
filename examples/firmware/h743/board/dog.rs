//! Registers of the independent watchdog, which has a window of its own.

#![allow(
    unsafe_code,
    reason = "registers without an owner, fields without ranges"
)]

use super::pac::IWDG;
use super::within;
use spindle_firmware::dog::{self, COUNTS, TOO_EARLY_US};

// The registers of `IWDG`.
spindle_firmware::start_watchdog!(0x5800_4800);

/// Looks at its status before it counts as idle: some ms at least, where an update takes 0.3 ms.
const PATIENCE: u32 = 200_000;

/// Feeds the independent watchdog while the board starts.
pub fn feed_at_start() {
    dog::feed_at_start::<Watchdogs>();
}

/// The watchdog. Its oscillator is good to 10 %, so that its window also holds the core's clock against another one.
pub struct Watchdogs(pub IWDG);

impl dog::Watchdogs for Watchdogs {
    fn feed_independent() {
        // SAFETY: it is always there; a write of this key feeds it, whoever writes.
        unsafe { &*IWDG::ptr() }.kr().write(|w| w.key().feed());
    }

    fn tighten(&mut self) {
        const FIRST: u16 = COUNTS - (TOO_EARLY_US / 1000) as u16;
        let idle = || within(PATIENCE, || self.0.sr().read().bits() == 0);
        idle();
        self.0.kr().write(|w| w.key().unlock());
        self.0.pr().write(|w| w.pr().divide_by32());
        // SAFETY: within the register's twelve bits.
        self.0.rlr().write(|w| unsafe { w.bits(COUNTS) });
        idle();
        // SAFETY: likewise. It is open, and this write feeds the watchdog, too.
        self.0.winr().write(|w| unsafe { w.bits(FIRST) });
    }

    fn feed(&mut self) {
        self.0.kr().write(|w| w.key().feed());
    }
}
