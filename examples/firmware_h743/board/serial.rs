//! Two serial ports, as on the other board. USART3 is the monitor's: received bytes into a queue by
//! interrupt, sent bytes one at a time. USART2 sends the log.

#![allow(unsafe_code, reason = "registers shared with an interrupt handler")]

use super::clock::Clock;
use super::{pac, within};
use pac::{GPIOD, Interrupt, NVIC, RCC, USART2, USART3, interrupt};
use spindle_firmware::log;
use spindle_firmware::receiver::{Receiver, Sender};

/// Baud rate of both, 8N1. From 100 MHz and from 64 MHz alike it is met within 0.1 %.
pub const BAUD: u32 = 921_600;

/// Looks at the transmitter before a byte is given up: many times the time of a byte on the wire.
const PATIENCE: u32 = 100_000;

/// Starts the ports on PD8, PD9 and PD5; `None` if they were started before. In lock-step there is no
/// interrupt: bytes are fetched by [`received`].
pub fn start(
    ports: (USART3, USART2),
    rcc: &RCC,
    gpiod: &GPIOD,
    clock: &Clock,
    lock_step: bool,
) -> Option<Receiver> {
    let receiver = Receiver::new()?;
    rcc.ahb4enr().modify(|_, w| w.gpioden().enabled());
    rcc.apb1lenr()
        .modify(|_, w| w.usart3en().enabled().usart2en().enabled());
    // Read back, since a clock takes two cycles to arrive.
    let _ = rcc.apb1lenr().read();
    gpiod.afrl().modify(|_, w| w.afr5().af7());
    gpiod.afrh().modify(|_, w| w.afr8().af7().afr9().af7());
    // An open input must not look like an endless break.
    gpiod.pupdr().modify(|_, w| w.pupdr9().pull_up());
    gpiod.moder().modify(|_, w| {
        w.moder5().alternate();
        w.moder8().alternate().moder9().alternate()
    });

    let divisor = (clock.usart_hz + BAUD / 2) / BAUD;
    let (usart, of_log) = ports;
    // SAFETY: with sixteenfold oversampling the register is the divisor; at 100 MHz it is 217.
    usart.brr().write(|w| unsafe { w.bits(divisor) });
    // SAFETY: likewise.
    of_log.brr().write(|w| unsafe { w.bits(divisor) });
    of_log.cr1().write(|w| w.ue().enabled().te().enabled());
    usart.cr1().write(|w| {
        w.ue().enabled().te().enabled().re().enabled();
        w.rxneie().bit(!lock_step)
    });
    if !lock_step {
        // SAFETY: the handler shares nothing with the main program but the queue and an atomic.
        unsafe { NVIC::unmask(Interrupt::USART3) };
    }
    log::start(log_byte, flush_log);
    Some(receiver)
}

/// The port's registers, for the two who share them.
fn registers() -> &'static pac::usart3::RegisterBlock {
    // SAFETY: they are always there, and every access is volatile. After `start` has given up its
    // ownership, only one of the two reads data and clears the overrun: the interrupt handler or, in
    // lock-step, the main program. Otherwise, the main program reads the status and writes data.
    unsafe { &*USART3::ptr() }
}

/// The log's registers.
fn log_registers() -> &'static pac::usart2::RegisterBlock {
    // SAFETY: they are always there, every access is volatile, and only the main program has any.
    unsafe { &*USART2::ptr() }
}

/// In lock-step, the byte that has come in, if there is one.
pub fn received() -> Option<u8> {
    let usart = registers();
    let there = usart.isr().read().rxne().bit_is_set();
    there.then(|| usart.rdr().read().rdr().bits() as u8)
}

/// Whether the monitor's port takes a byte now.
pub fn is_free() -> bool {
    registers().isr().read().txe().bit_is_set()
}

/// Sends a byte over the monitor's port, or drops it if the transmitter is stuck.
pub fn send(byte: u8) {
    if within(PATIENCE, is_free) {
        registers().tdr().write(|w| w.tdr().set(byte.into()));
    }
}

/// Sends a byte of the log, or drops it if the transmitter is stuck.
fn log_byte(byte: u8) {
    let usart = log_registers();
    if within(PATIENCE, || usart.isr().read().txe().bit_is_set()) {
        usart.tdr().write(|w| w.tdr().set(byte.into()));
    }
}

/// Waits until the last byte of the log has left.
fn flush_log() {
    within(PATIENCE, || log_registers().isr().read().tc().bit_is_set());
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
