//! The independent watchdog's window (see `super::dog`), and the cause of the chip's last reset.

use super::clock::Clock;
use super::dog::{COUNTS, TOO_EARLY_US};
use super::pac::{IWDG, RCC};
use spindle_monitor::board::ResetCause;

/// Where the registers of the independent watchdog are.
pub const IWDG_ADDRESS: u32 = 0x5800_4800;

/// The window of the independent watchdog itself. Its oscillator is good to 10 %, so that it also holds the core's
/// clock against another one.
pub struct Window;

impl Window {
    /// Opens the window; too early, to feed the watchdog is a reset from now on.
    #[allow(unsafe_code, reason = "a field without a range")]
    pub fn start(&self, iwdg: &IWDG, _: &Clock) {
        const FIRST: u16 = COUNTS - (TOO_EARLY_US / 1000) as u16;
        // SAFETY: within the register's twelve bits. It is open, and this write feeds the watchdog, too.
        iwdg.winr().write(|w| unsafe { w.bits(FIRST) });
    }

    /// There is no other watchdog to feed.
    pub const fn feed(&self) {}
}

/// Cause of the chip's last reset. Clears it, so that the next reset is told from this one.
pub fn cause(rcc: &RCC) -> ResetCause {
    let flags = rcc.rsr().read();
    rcc.rsr().modify(|_, w| w.rmvf().reset());
    rcc.rsr().modify(|_, w| w.rmvf().not_activated());
    ResetCause::among(|cause| match cause {
        ResetCause::PowerOn => flags.porrstf().is_reset_occurred(),
        ResetCause::BrownOut => flags.borrstf().is_reset_occurred(),
        ResetCause::Pin => flags.pinrstf().is_reset_occurred(),
        ResetCause::Watchdog => flags.iwdg1rstf().is_reset_occurred(),
        ResetCause::WindowWatchdog => flags.wwdg1rstf().is_reset_occurred(),
        ResetCause::Software => flags.sftrstf().is_reset_occurred(),
        ResetCause::LowPower => flags.lpwrrstf().is_reset_occurred(),
        ResetCause::Unknown => false,
    })
}
