//! Registers of the independent watchdog, which has a window of its own.

#![allow(
    unsafe_code,
    reason = "registers without an owner, fields without ranges"
)]

use crate::dog::{self, COUNTS, TOO_EARLY_US};
use crate::stm32::iwdg;
use crate::stm32::pac::IWDG;

/// Address of the registers of `IWDG`.
pub const IWDG_ADDRESS: u32 = 0x5800_4800;

/// The watchdog. Its oscillator is good to 10 %, so that its window also holds the core's clock against another one.
pub struct Watchdogs(pub IWDG);

impl dog::Watchdogs for Watchdogs {
    fn feed_independent() {
        iwdg::feed();
    }

    fn tighten(&mut self) {
        const FIRST: u16 = COUNTS - (TOO_EARLY_US / 1000) as u16;
        iwdg::tighten(&self.0);
        // SAFETY: within the register's twelve bits. It is open, and this write feeds the watchdog, too.
        self.0.winr().write(|w| unsafe { w.bits(FIRST) });
    }

    fn feed(&mut self) {
        iwdg::feed();
    }
}
