//! The option bytes' brown-out level, below which the chip is held in reset.

use super::dog::feed_at_start;
use super::pac::FLASH;
use super::within;

/// The highest: reset below 2.7 V, give or take 0.1 V.
pub const HIGHEST: u8 = 3;

/// Looks at the busy flag before programming counts as failed: some 4 s at least, in which two sectors could be erased.
const PATIENCE: u32 = 200_000_000;

/// The level, 0 for off to 3.
pub fn level(flash: &FLASH) -> Option<u8> {
    Some(flash.optsr_cur().read().bor_lev().bits())
}

/// Programs the highest level, and nothing else; whether that went well. The chip takes it over at the next power-on.
#[allow(unsafe_code, reason = "keys, and a field without names")]
pub fn set(flash: &FLASH) -> bool {
    let idle = || {
        within(PATIENCE, || {
            feed_at_start();
            flash.optsr_cur().read().opt_busy().bit_is_clear()
        })
    };
    // SAFETY: the two words that unlock the option bytes.
    flash.optkeyr().write(|w| unsafe { w.bits(0x0819_2a3b) });
    // SAFETY: likewise.
    flash.optkeyr().write(|w| unsafe { w.bits(0x4c5d_6e7f) });
    let ready = flash.optcr().read().optlock().bit_is_clear() && idle();
    if ready {
        // SAFETY: two bits.
        flash
            .optsr_prg()
            .modify(|_, w| unsafe { w.bor_lev().bits(HIGHEST) });
        flash.optcr().modify(|_, w| w.optstart().set_bit());
    }
    let done = ready && idle();
    flash.optcr().modify(|_, w| w.optlock().set_bit());
    done && flash.optsr_cur().read().optchangeerr().bit_is_clear()
}
