//! The window watchdog, beside the independent one (`super::dog`), and the cause of the last reset.

use super::clock::Clock;
use super::dog::TOO_EARLY_US;
use super::pac::{IWDG, RCC, WWDG};
use spindle_monitor::board::ResetCause;

/// Where the registers of the independent watchdog are.
pub const IWDG_ADDRESS: u32 = 0x4000_3000;

/// The window watchdog, on the clock of the peripheral bus, which therefore says nothing of that clock. Its limits
/// are as wide as they can be: 64 counts of 0.78 ms, of 2.05 ms on the internal oscillator.
pub struct Window(WWDG);

/// Cycles of the bus in a count: 4096 by 8.
const CYCLES: u32 = 4096 * 8;
/// The count that the watchdog starts from.
const FULL: u8 = 0x7f;

impl Window {
    /// Not started yet; its clock is on.
    pub const fn new(wwdg: WWDG) -> Self {
        Self(wwdg)
    }

    /// Starts it.
    #[allow(unsafe_code, reason = "a field without a range")]
    pub fn start(&self, _: &IWDG, clock: &Clock) {
        // USART2, which sends the log, is on the same bus.
        let counts = clock.log_hz / 1_000_000 * TOO_EARLY_US / CYCLES;
        let first = FULL.saturating_sub(counts.min(63) as u8);
        // SAFETY: seven bits.
        self.0
            .cfr()
            .write(|w| unsafe { w.wdgtb().div8().w().bits(first) });
        // SAFETY: likewise.
        self.0
            .cr()
            .write(|w| unsafe { w.wdga().enabled().t().bits(FULL) });
    }

    /// Feeds it; too early, that is a reset.
    #[allow(unsafe_code, reason = "a field without a range")]
    pub fn feed(&self) {
        // SAFETY: seven bits.
        self.0
            .cr()
            .write(|w| unsafe { w.wdga().enabled().t().bits(FULL) });
    }
}

/// Cause of the chip's last reset. Clears it, so that the next reset is told from this one.
pub fn cause(rcc: &RCC) -> ResetCause {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().clear());
    ResetCause::among(|cause| match cause {
        ResetCause::PowerOn => flags.porrstf().is_reset(),
        ResetCause::BrownOut => flags.borrstf().is_reset(),
        ResetCause::Pin => flags.padrstf().is_reset(),
        ResetCause::Watchdog => flags.wdgrstf().is_reset(),
        ResetCause::WindowWatchdog => flags.wwdgrstf().is_reset(),
        ResetCause::Software => flags.sftrstf().is_reset(),
        ResetCause::LowPower => flags.lpwrrstf().is_reset(),
        ResetCause::Unknown => false,
    })
}
