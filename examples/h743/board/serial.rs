//! USART3: received bytes into a queue by interrupt, sent bytes one at a time, as on the other board.

#![allow(unsafe_code, reason = "registers shared with an interrupt handler")]

use super::receiver::{Receiver, Sender};
use super::{pac, within};
use pac::{GPIOD, Interrupt, NVIC, RCC, USART3, interrupt};

/// Baud rate, 8N1. From 100 MHz and from 64 MHz alike it is met within 0.1 %.
pub const BAUD: u32 = 460_800;

/// Looks at the transmitter before a byte is given up: many times the time of a byte on the wire.
const PATIENCE: u32 = 100_000;

/// Starts the port on PD8 and PD9; `None` if it was started before.
pub fn start(usart: USART3, rcc: &RCC, gpiod: &GPIOD, clock_hz: u32) -> Option<Receiver> {
    let receiver = Receiver::new()?;
    rcc.ahb4enr().modify(|_, w| w.gpioden().enabled());
    rcc.apb1lenr().modify(|_, w| w.usart3en().enabled());
    // Read back, since a clock takes two cycles to arrive.
    let _ = rcc.apb1lenr().read();
    gpiod.afrh().modify(|_, w| w.afr8().af7().afr9().af7());
    // An open input must not look like an endless break.
    gpiod.pupdr().modify(|_, w| w.pupdr9().pull_up());
    gpiod
        .moder()
        .modify(|_, w| w.moder8().alternate().moder9().alternate());

    let divisor = (clock_hz + BAUD / 2) / BAUD;
    // SAFETY: with sixteenfold oversampling the register is the divisor; at 100 MHz it is 217.
    usart.brr().write(|w| unsafe { w.bits(divisor) });
    usart.cr1().write(|w| {
        w.ue().enabled().te().enabled().re().enabled();
        w.rxneie().enabled()
    });
    // SAFETY: the handler shares nothing with the main program but the queue and an atomic.
    unsafe { NVIC::unmask(Interrupt::USART3) };
    Some(receiver)
}

/// The port's registers, for the two who share them.
fn registers() -> &'static pac::usart3::RegisterBlock {
    // SAFETY: they are always there, and every access is volatile. After `start` has given up its
    // ownership, the interrupt handler only reads status and data and clears the overrun, the main
    // program only reads the status and writes data.
    unsafe { &*USART3::ptr() }
}

/// Sends a byte, or drops it if the transmitter is stuck.
pub fn send(byte: u8) {
    let usart = registers();
    if within(PATIENCE, || usart.isr().read().txe().bit_is_set()) {
        usart.tdr().write(|w| w.tdr().set(byte.into()));
    }
}

/// Waits until the last byte has left.
pub fn flush() {
    within(PATIENCE, || registers().isr().read().tc().bit_is_set());
}

#[interrupt]
fn USART3() {
    static mut SENDER: Sender = Sender::new();

    let usart = registers();
    let status = usart.isr().read();
    let byte = status
        .rxne()
        .bit_is_set()
        .then(|| usart.rdr().read().rdr().bits() as u8);
    let overrun = status.ore().bit_is_set();
    if overrun {
        // Until it is cleared, it calls this handler again and again.
        usart.icr().write(|w| w.orecf().clear());
    }
    SENDER.push(byte, overrun);
}
