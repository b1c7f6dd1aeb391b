//! The option bytes' brown-out level, below which the chip is held in reset.

use super::dog::feed_at_start;
use super::pac::FLASH;
use super::within;

/// The highest: reset below 2.7 V, give or take 0.1 V.
pub const HIGHEST: u8 = 3;

/// Looks at the busy flag before programming counts as failed: some 100 ms at least, of which it takes 20 ms.
const PATIENCE: u32 = 4_000_000;

/// The level, 0 for off to 3; none on an emulator, whose registers are not locked after a reset.
pub fn level(flash: &FLASH) -> Option<u8> {
    let options = flash.optcr().read();
    options
        .optlock()
        .is_locked()
        .then(|| HIGHEST - options.bor_lev().bits())
}

/// Programs the highest level, and nothing else; whether that went well. The chip takes it over at the next power-on.
#[allow(unsafe_code, reason = "keys")]
pub fn set(flash: &FLASH) -> bool {
    let idle = || {
        within(PATIENCE, || {
            feed_at_start();
            flash.sr().read().bsy().is_not_busy()
        })
    };
    // SAFETY: the two words that unlock the option bytes.
    flash.optkeyr().write(|w| unsafe { w.bits(0x0819_2a3b) });
    // SAFETY: likewise.
    flash.optkeyr().write(|w| unsafe { w.bits(0x4c5d_6e7f) });
    let ready = flash.optcr().read().optlock().is_unlocked() && idle();
    if ready {
        flash.optcr().modify(|_, w| w.bor_lev().bor_level3());
        flash.optcr().modify(|_, w| w.optstrt().set_());
    }
    let done = ready && idle();
    flash.optcr().modify(|_, w| w.optlock().set_());
    done
}
