//! SPI1 as on the other board: mode 1, byte by byte.

#![allow(unsafe_code, reason = "registers without an owner")]

use crate::board::within;
use crate::stm32::pac::SPI1;

/// Looks at the bus before a byte is given up: many times the time of a byte.
const PATIENCE: u32 = 10_000;

/// Starts it, on the internal oscillator, which always runs: 64 MHz by 8, of the 25 MHz that the converter
/// takes.
pub fn start(spi: &SPI1) {
    // SAFETY: eight bits less one.
    spi.cfg1()
        .write(|w| unsafe { w.dsize().bits(7) }.mbr().div8());
    spi.cfg2().write(|w| {
        w.master().master().cpol().idle_low().cpha().second_edge();
        w.ssm().enabled()
    });
    // Selected from within, or it would take itself for one of two masters.
    spi.cr1().write(|w| w.ssi().slave_not_selected());
    spi.cr1().modify(|_, w| w.spe().enabled());
    spi.cr1().modify(|_, w| w.cstart().started());
}

/// Sends a byte and returns the one that comes in meanwhile; none if the bus is dead.
#[inline(never)]
pub fn exchange(byte: u8) -> Option<u8> {
    // SAFETY: it is always there, every access is volatile, and only the main program has any.
    let spi = unsafe { &*SPI1::ptr() };
    let mut ready = within(PATIENCE, || spi.sr().read().txp().bit_is_set());
    spi.txdr8().write(|w| w.txdr().set(byte));
    ready &= within(PATIENCE, || spi.sr().read().rxp().bit_is_set());
    ready.then(|| spi.rxdr8().read().rxdr().bits())
}
