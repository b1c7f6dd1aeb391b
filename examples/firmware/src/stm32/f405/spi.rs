//! SPI1 as the converter of the strain bridges wants it: mode 1, byte by byte.

#![allow(unsafe_code, reason = "registers without an owner")]

use crate::board::within;
use crate::stm32::pac::SPI1;

/// Looks at the bus before a byte is given up: many times the time of a byte.
const PATIENCE: u32 = 10_000;

/// Starts it: 84 MHz by 8, of the 25 MHz that the converter takes.
pub fn start(spi: &SPI1) {
    spi.cr1().write(|w| {
        w.mstr().master().br().div8().cpol().idle_low();
        w.cpha().second_edge().ssm().enabled();
        w.ssi().slave_not_selected().spe().enabled()
    });
}

/// Sends a byte and returns the one that comes in meanwhile; none if the bus is dead.
#[inline(never)]
pub fn exchange(byte: u8) -> Option<u8> {
    // SAFETY: it is always there, every access is volatile, and only the main program has any.
    let spi = unsafe { &*SPI1::ptr() };
    let mut ready = within(PATIENCE, || spi.sr().read().txe().bit_is_set());
    spi.dr8().write(|w| w.dr().set(byte));
    ready &= within(PATIENCE, || spi.sr().read().rxne().bit_is_set());
    ready.then(|| spi.dr8().read().dr().bits())
}
