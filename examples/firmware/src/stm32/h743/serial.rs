//! Two serial ports, as on the other board. USART3 is the monitor's: received bytes into a ring by
//! interrupt, sent bytes one at a time. USART2 sends the log.
//!
//! The handler is in the first bank of the flash. The core goes on reading there while the second bank, with the kept data, is
//! written or erased. So the handler meets every byte, and no DMA shares memory with the data cache.

#![allow(unsafe_code, reason = "registers shared with an interrupt handler")]

use crate::board::within;
use crate::log;
use crate::receiver::{BAUD, PLACES, Receiver, Ring};
use crate::stm32::clock::Clock;
use crate::stm32::pac::{self, GPIOD, Interrupt, NVIC, RCC, USART2, USART3, interrupt};
use core::sync::atomic::{AtomicUsize, Ordering};

/// Received bytes, and the place that is written next.
static RING: Ring = Ring::zeroed();
static WRITES: AtomicUsize = AtomicUsize::new(0);

/// Looks at the transmitter before a byte is given up: many times the time of a byte on the wire.
const PATIENCE: u32 = 100_000;

/// Starts the ports on PD8, PD9 and PD5. In lock-step there is no interrupt: bytes are fetched by [`received`].
pub fn start(
    (usart, of_log): (USART3, USART2),
    rcc: &RCC,
    gpiod: &GPIOD,
    clock: &Clock,
    lock_step: bool,
) -> Receiver {
    let receiver = Receiver::new(&RING, (|| WRITES.load(Ordering::Relaxed)) as fn() -> usize);
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

    // From 100 MHz and from 64 MHz alike the rate is met within 0.1 %.
    let divisor = |hz: u32| (hz + BAUD / 2) / BAUD;
    // SAFETY: with sixteenfold oversampling the register is the divisor; at 100 MHz it is 217.
    usart
        .brr()
        .write(|w| unsafe { w.bits(divisor(clock.usart_hz)) });
    // SAFETY: likewise.
    of_log
        .brr()
        .write(|w| unsafe { w.bits(divisor(clock.log_hz)) });
    of_log.cr1().write(|w| w.ue().enabled().te().enabled());
    usart.cr1().write(|w| {
        w.ue().enabled().te().enabled().re().enabled();
        w.rxneie().bit(!lock_step)
    });
    if !lock_step {
        // SAFETY: the handler shares nothing with the main program but atomics.
        unsafe { NVIC::unmask(Interrupt::USART3) };
    }
    log::start(log_byte, flush_log);
    receiver
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
    let usart = registers();
    let status = usart.isr().read();
    if status.rxne().bit_is_set() {
        // No other writer, and no read-modify-write that could be lost.
        let at = WRITES.load(Ordering::Relaxed);
        RING.put(at, usart.rdr().read().rdr().bits() as u8);
        WRITES.store(at.wrapping_add(1) % PLACES, Ordering::Relaxed);
    }
    if status.ore().bit_is_set() {
        // Until it is cleared, it calls this handler again and again.
        usart.icr().write(|w| w.orecf().clear());
        RING.note_overrun();
    }
}
