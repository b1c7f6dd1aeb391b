//! Two serial ports. USART1 is the monitor's: received bytes into a ring by DMA, sent bytes one at a time. USART2 sends
//! the log.
//!
//! An interrupt handler would be in the flash, which the core cannot read while the log of kept data is written: the port
//! has room for one byte, of 10.9 us, and the core stands still for 16 us to 100 us. DMA2 reaches the port and the SRAM
//! without the flash. Sending waits for the port alone.
//!
//! In lock-step, bytes are fetched one by one, since an emulator has no such DMA.

#![allow(unsafe_code, reason = "registers shared with the DMA controller")]

use crate::board::within;
use crate::log;
use crate::receiver::{BAUD, PLACES, Receiver, Ring};
use crate::stm32::clock::Clock;
use crate::stm32::pac::{self, DMA2, GPIOA, RCC, USART1, USART2};
use core::sync::atomic::{AtomicBool, Ordering};

/// Received bytes. In the RAM of `chip.x`, which DMA2 reaches, and not in the CCM.
static RING: Ring = Ring::zeroed();

/// Stream of DMA2 that has the receiver of USART1, at its channel 4 (RM0090, table 43).
const STREAM: usize = 2;
const CHANNEL: u8 = 4;

/// Looks at the transmitter before a byte is given up: many times the time of a byte on the wire.
const PATIENCE: u32 = 100_000;

/// Starts the ports on PA9, PA10 and PA2. In lock-step the receiver gets nothing: bytes are fetched by [`received`].
pub fn start(
    (usart, of_log, dma): (USART1, USART2, DMA2),
    rcc: &RCC,
    gpioa: &GPIOA,
    clock: &Clock,
    lock_step: bool,
) -> Receiver {
    let receiver = Receiver::new(&RING, writes as fn() -> usize);
    rcc.ahb1enr()
        .modify(|_, w| w.gpioaen().enabled().dma2en().enabled());
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

    // From 84 and 42 MHz the rate is met within 1 %, from 16 MHz to 2.1 %.
    let divisor = |hz: u32| ((hz + BAUD / 2) / BAUD) as u16;
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
    if !lock_step {
        fill_ring(&dma, &usart);
    }
    usart
        .cr1()
        .write(|w| w.ue().enabled().te().enabled().re().enabled());
    log::start(log_byte, flush_log);
    receiver
}

/// Has the controller write each received byte to the next place, round and round.
fn fill_ring(dma: &DMA2, usart: &USART1) {
    let stream = dma.st(STREAM);
    let from = usart.dr().as_ptr();
    // SAFETY: the address of the data register.
    stream.par().write(|w| unsafe { w.bits(from as u32) });
    let to = RING.address();
    // SAFETY: a static of so many half-words. What the controller writes there, the program reads as an atomic.
    stream.m0ar().write(|w| unsafe { w.bits(to as u32) });
    stream.ndtr().write(|w| w.ndt().set(PLACES as u16));
    stream.cr().write(|w| {
        w.circ().enabled().dir().peripheral_to_memory();
        w.psize().bits16().msize().bits16().minc().incremented();
        // Nothing else uses the controller.
        w.pl().very_high().chsel().set(CHANNEL).en().enabled()
    });
    usart.cr3().write(|w| w.dmar().enabled());
}

/// Place of the ring that the controller writes next.
fn writes() -> usize {
    // SAFETY: it is always there, and this is read alone.
    let dma = unsafe { &*DMA2::ptr() };
    let left = dma.st(STREAM).ndtr().read().ndt().bits();
    PLACES.wrapping_sub(left.into()) % PLACES
}

/// The port's registers.
fn registers() -> &'static pac::usart1::RegisterBlock {
    // SAFETY: they are always there, and every access is volatile. After `start` has given up its
    // ownership, only one reads the data: the DMA controller or, in lock-step, the main program. Otherwise, the main
    // program reads the status and writes data.
    unsafe { &*USART1::ptr() }
}

/// Status of the port. An overrun, which says that DMA has failed, is counted: once, until the next byte has cleared it.
fn status() -> pac::usart1::sr::R {
    static IS_OVERRUN: AtomicBool = AtomicBool::new(false);

    let status = registers().sr().read();
    let overrun = status.ore().bit_is_set();
    if overrun && !IS_OVERRUN.load(Ordering::Relaxed) {
        RING.note_overrun();
    }
    IS_OVERRUN.store(overrun, Ordering::Relaxed);
    status
}

/// The log's registers.
fn log_registers() -> &'static pac::usart1::RegisterBlock {
    // SAFETY: they are always there, every access is volatile, and only the main program has any.
    unsafe { &*USART2::ptr() }
}

/// In lock-step, the byte that has come in, if there is one.
pub fn received() -> Option<u8> {
    let there = status().rxne().bit_is_set();
    there.then(|| registers().dr().read().dr().bits() as u8)
}

/// Whether the monitor's port takes a byte now.
pub fn is_free() -> bool {
    status().txe().bit_is_set()
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
