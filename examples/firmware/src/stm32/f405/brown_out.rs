//! Registers of the brown-out level.

use crate::stm32::brown_out::HIGHEST;
use crate::stm32::pac::FLASH;

/// Looks at the busy flag before programming counts as failed: some 100 ms at least, of which it takes 20 ms.
pub const PATIENCE: u32 = 4_000_000;

/// The level, 0 for off to 3; none on an emulator, whose registers are not locked after a reset.
pub fn level(flash: &FLASH) -> Option<u8> {
    let options = flash.optcr().read();
    options
        .optlock()
        .is_locked()
        .then(|| HIGHEST - options.bor_lev().bits())
}

/// Whether nothing is being programmed.
pub fn is_idle(flash: &FLASH) -> bool {
    flash.sr().read().bsy().is_not_busy()
}

/// Has the highest level programmed.
pub fn program(flash: &FLASH) {
    flash.optcr().modify(|_, w| w.bor_lev().bor_level3());
    flash.optcr().modify(|_, w| w.optstrt().set_());
}

/// Whether the option bytes are not the programmed ones: this chip does not say.
pub const fn has_failed(_: &FLASH) -> bool {
    false
}
