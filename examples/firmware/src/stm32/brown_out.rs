//! The option bytes' brown-out level, below which the chip is held in reset.

use super::chip::brown_out::{PATIENCE, has_failed, is_idle, program};
use super::iwdg::feed_at_start;
use super::pac::FLASH;
use crate::board::{SET_BROWN_OUT, within};

/// The highest: reset below 2.7 V, give or take 0.1 V.
pub const HIGHEST: u8 = 3;

/// Sets the highest level, if this is wanted and the level is another one. The chip takes it over at the next power-on.
pub fn raise_brown_out(flash: &FLASH, level: Option<u8>) {
    if SET_BROWN_OUT && level.is_some_and(|of| of < HIGHEST) {
        if set(flash) {
            defmt::warn!("brown-out level set to the highest, from the next power-on on");
        } else {
            defmt::error!("the brown-out level cannot be set");
        }
    }
}

/// Programs the highest level, and nothing else; whether that went well.
#[allow(unsafe_code, reason = "keys")]
fn set(flash: &FLASH) -> bool {
    let idle = || {
        within(PATIENCE, || {
            feed_at_start();
            is_idle(flash)
        })
    };
    // SAFETY: the two words that unlock the option bytes.
    flash.optkeyr().write(|w| unsafe { w.bits(0x0819_2a3b) });
    // SAFETY: likewise.
    flash.optkeyr().write(|w| unsafe { w.bits(0x4c5d_6e7f) });
    let ready = flash.optcr().read().optlock().bit_is_clear() && idle();
    if ready {
        program(flash);
    }
    let done = ready && idle();
    flash.optcr().modify(|_, w| w.optlock().set_bit());
    done && !has_failed(flash)
}
