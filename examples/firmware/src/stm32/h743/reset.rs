//! The cause of the chip's last reset.

use crate::stm32::pac::RCC;
use spindle_monitor::board::ResetCause;

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
