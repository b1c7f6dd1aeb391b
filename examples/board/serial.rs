//! USART1: received bytes into a queue by interrupt, sent bytes one at a time.
//!
//! Sending waits with interrupts on, so that nothing is lost meanwhile. It does without the
//! transmitter's interrupt and without DMA, neither of which every emulator has.

#![allow(unsafe_code, reason = "registers shared with an interrupt handler")]

use super::receiver::{Receiver, Sender};
use super::{pac, within};
use pac::{GPIOA, Interrupt, NVIC, RCC, USART1, interrupt};

/// Baud rate, 8N1. From 84 MHz and from 16 MHz alike it is met within 1 %.
pub const BAUD: u32 = 460_800;

/// Looks at the transmitter before a byte is given up: many times the time of a byte on the wire.
const PATIENCE: u32 = 100_000;

/// Starts the port on PA9 and PA10; `None` if it was started before.
pub fn start(usart: USART1, rcc: &RCC, gpioa: &GPIOA, clock_hz: u32) -> Option<Receiver> {
    let receiver = Receiver::new()?;
    rcc.ahb1enr().modify(|_, w| w.gpioaen().enabled());
    rcc.apb2enr().modify(|_, w| w.usart1en().enabled());
    // Read back, since a clock takes two cycles to arrive.
    let _ = rcc.apb2enr().read();
    gpioa.afrh().modify(|_, w| w.afrh9().af7().afrh10().af7());
    // An open input must not look like an endless break.
    gpioa.pupdr().modify(|_, w| w.pupdr10().pull_up());
    gpioa
        .moder()
        .modify(|_, w| w.moder9().alternate().moder10().alternate());

    let divisor = (clock_hz + BAUD / 2) / BAUD;
    // SAFETY: mantissa and fraction side by side are sixteenths of the divisor by 16, that is,
    // the divisor itself; at 84 MHz it is 182.
    usart.brr().write(|w| unsafe { w.bits(divisor as u16) });
    usart.cr1().write(|w| {
        w.ue().enabled().te().enabled().re().enabled();
        w.rxneie().enabled()
    });
    // SAFETY: the handler shares nothing with the main program but the queue and an atomic.
    unsafe { NVIC::unmask(Interrupt::USART1) };
    Some(receiver)
}

/// The port's registers, for the two who share them.
fn registers() -> &'static pac::usart1::RegisterBlock {
    // SAFETY: they are always there, and every access is volatile. After `start` has given up its
    // ownership, the interrupt handler only reads status and data, the main program only reads
    // the status and writes data.
    unsafe { &*USART1::ptr() }
}

/// Sends a byte, or drops it if the transmitter is stuck.
pub fn send(byte: u8) {
    let usart = registers();
    if within(PATIENCE, || usart.sr().read().txe().bit_is_set()) {
        usart.dr().write(|w| w.dr().set(byte.into()));
    }
}

/// Waits until the last byte has left.
pub fn flush() {
    within(PATIENCE, || registers().sr().read().tc().bit_is_set());
}

#[interrupt]
fn USART1() {
    static mut SENDER: Sender = Sender::new();

    let usart = registers();
    // Reading the data after the status clears both the byte and the overrun.
    let status = usart.sr().read();
    let byte = usart.dr().read().dr().bits() as u8;
    let byte = status.rxne().bit_is_set().then_some(byte);
    SENDER.push(byte, status.ore().bit_is_set());
}
