//! The cause of the chip's last reset.

use crate::stm32::pac::RCC;
use spindle_monitor::board::ResetCause;

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
