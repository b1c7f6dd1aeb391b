//! Registers of the brown-out level.

use crate::stm32::brown_out::HIGHEST;
use crate::stm32::pac::FLASH;

/// Looks at the busy flag before programming counts as failed: some 4 s at least, in which two sectors could be erased.
pub const PATIENCE: u32 = 200_000_000;

/// The level, 0 for off to 3.
pub fn level(flash: &FLASH) -> Option<u8> {
    Some(flash.optsr_cur().read().bor_lev().bits())
}

/// Whether nothing is being programmed.
pub fn is_idle(flash: &FLASH) -> bool {
    flash.optsr_cur().read().opt_busy().bit_is_clear()
}

/// Has the highest level programmed.
#[allow(unsafe_code, reason = "a field without names")]
pub fn program(flash: &FLASH) {
    // SAFETY: two bits.
    flash
        .optsr_prg()
        .modify(|_, w| unsafe { w.bor_lev().bits(HIGHEST) });
    flash.optcr().modify(|_, w| w.optstart().set_bit());
}

/// Whether the option bytes are not the programmed ones.
pub fn has_failed(flash: &FLASH) -> bool {
    flash.optsr_cur().read().optchangeerr().bit_is_set()
}
