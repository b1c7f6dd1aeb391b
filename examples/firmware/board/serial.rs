//! Two serial ports. USART1 is the monitor's: received bytes into a queue by interrupt, sent bytes one at a
//! time. USART2 sends the log.
//!
//! Sending does without the transmitter's interrupt and without DMA, neither of which every emulator has.

#![allow(unsafe_code, reason = "registers shared with an interrupt handler")]

use super::clock::Clock;
use super::{pac, within};
use pac::{GPIOA, Interrupt, NVIC, RCC, USART1, USART2, interrupt};
use spindle_firmware::log;
use spindle_firmware::receiver::{Receiver, Sender};

/// Baud rate of both, 8N1. From 84 and 42 MHz it is met within 1 %, from 16 MHz to 2.1 %.
pub const BAUD: u32 = 921_600;

/// Looks at the transmitter before a byte is given up: many times the time of a byte on the wire.
const PATIENCE: u32 = 100_000;

/// Starts the ports on PA9, PA10 and PA2; `None` if they were started before. In lock-step there is no
/// interrupt: bytes are fetched by [`received`].
pub fn start(
    ports: (USART1, USART2),
    rcc: &RCC,
    gpioa: &GPIOA,
    clock: &Clock,
    lock_step: bool,
) -> Option<Receiver> {
    let receiver = Receiver::new()?;
    rcc.ahb1enr().modify(|_, w| w.gpioaen().enabled());
    rcc.apb2enr().modify(|_, w| w.usart1en().enabled());
    rcc.apb1enr().modify(|_, w| w.usart2en().enabled());
    // Read back, since a clock takes two cycles to arrive.
    let _ = rcc.apb1enr().read();
    gpioa.afrl().modify(|_, w| w.afrl2().af7());
    gpioa.afrh().modify(|_, w| w.afrh9().af7().afrh10().af7());
    // An open input must not look like an endless break.
    gpioa.pupdr().modify(|_, w| w.pupdr10().pull_up());
    gpioa.moder().modify(|_, w| {
        w.moder2().alternate();
        w.moder9().alternate().moder10().alternate()
    });

    let divisor = |hz: u32| ((hz + BAUD / 2) / BAUD) as u16;
    let (usart, of_log) = ports;
    // SAFETY: mantissa and fraction side by side are sixteenths of the divisor by 16, that is,
    // the divisor itself; at 84 MHz it is 182.
    usart
        .brr()
        .write(|w| unsafe { w.bits(divisor(clock.usart_hz)) });
    // SAFETY: likewise, 91 at 42 MHz.
    of_log
        .brr()
        .write(|w| unsafe { w.bits(divisor(clock.log_hz)) });
    of_log.cr1().write(|w| w.ue().enabled().te().enabled());
    usart.cr1().write(|w| {
        w.ue().enabled().te().enabled().re().enabled();
        w.rxneie().bit(!lock_step)
    });
    if !lock_step {
        // SAFETY: the handler shares nothing with the main program but the queue and an atomic.
        unsafe { NVIC::unmask(Interrupt::USART1) };
    }
    log::start(log_byte, flush_log);
    Some(receiver)
}

/// The port's registers, for the two who share them.
fn registers() -> &'static pac::usart1::RegisterBlock {
    // SAFETY: they are always there, and every access is volatile. After `start` has given up its
    // ownership, only one of the two reads the data: the interrupt handler or, in lock-step, the main
    // program. Otherwise, the main program reads the status and writes data.
    unsafe { &*USART1::ptr() }
}

/// The log's registers.
fn log_registers() -> &'static pac::usart1::RegisterBlock {
    // SAFETY: they are always there, every access is volatile, and only the main program has any.
    unsafe { &*USART2::ptr() }
}

/// In lock-step, the byte that has come in, if there is one.
pub fn received() -> Option<u8> {
    let usart = registers();
    let there = usart.sr().read().rxne().bit_is_set();
    there.then(|| usart.dr().read().dr().bits() as u8)
}

/// Whether the monitor's port takes a byte now.
pub fn is_free() -> bool {
    registers().sr().read().txe().bit_is_set()
}

/// Sends a byte over the monitor's port, or drops it if the transmitter is stuck.
pub fn send(byte: u8) {
    if within(PATIENCE, is_free) {
        registers().dr().write(|w| w.dr().set(byte.into()));
    }
}

/// Sends a byte of the log, or drops it if the transmitter is stuck.
fn log_byte(byte: u8) {
    let usart = log_registers();
    if within(PATIENCE, || usart.sr().read().txe().bit_is_set()) {
        usart.dr().write(|w| w.dr().set(byte.into()));
    }
}

/// Waits until the last byte of the log has left.
fn flush_log() {
    within(PATIENCE, || log_registers().sr().read().tc().bit_is_set());
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
