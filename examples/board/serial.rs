//! USART1: received bytes into a queue by interrupt, sent bytes one at a time.
//!
//! Sending waits with interrupts on, so that nothing is lost meanwhile. It does without the
//! transmitter's interrupt and without DMA, neither of which every emulator has.

#![allow(unsafe_code, reason = "registers shared with an interrupt handler")]

use super::{pac, within};
use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};
use critical_section::Mutex;
use heapless::spsc::{Consumer, Producer, Queue};
use pac::{GPIOA, Interrupt, NVIC, RCC, USART1, interrupt};

/// Baud rate, 8N1. From 84 MHz and from 16 MHz alike it is met within 1 %.
pub const BAUD: u32 = 460_800;

/// Bytes that wait for the solver: some 50 records, and far more than come in while one is solved.
const QUEUE_LENGTH: usize = 2048;

/// Looks at the transmitter before a byte is given up: many times the time of a byte on the wire.
const PATIENCE: u32 = 100_000;

/// The queue's writing end, on its way to the interrupt handler.
static HANDOVER: Mutex<RefCell<Option<Producer<'static, u8>>>> = Mutex::new(RefCell::new(None));

/// Bytes that the hardware or the queue had no room for.
static LOST: AtomicU32 = AtomicU32::new(0);

/// The receiving side of the port.
pub struct Receiver {
    queue: Consumer<'static, u8>,
}

/// Starts the port on PA9 and PA10; `None` if it was started before.
pub fn start(usart: USART1, rcc: &RCC, gpioa: &GPIOA, clock_hz: u32) -> Option<Receiver> {
    let queue = cortex_m::singleton!(: Queue<u8, QUEUE_LENGTH> = Queue::new())?;
    let (producer, consumer) = queue.split();
    critical_section::with(|cs| HANDOVER.borrow_ref_mut(cs).replace(producer));

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
    Some(Receiver { queue: consumer })
}

impl Receiver {
    /// The next byte; sleeps until there is one.
    pub fn wait_for_byte(&mut self) -> u8 {
        loop {
            if let Some(byte) = self.queue.dequeue() {
                return byte;
            }
            // With interrupts held back, one that comes between the look and the sleep still ends
            // the sleep, and is served right after.
            critical_section::with(|_| {
                if !self.queue.ready() {
                    cortex_m::asm::wfi();
                }
            });
        }
    }

    /// Bytes lost since the start, because they came faster than they were taken.
    pub fn lost(&self) -> u32 {
        LOST.load(Ordering::Relaxed)
    }
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
    static mut QUEUE: Option<Producer<'static, u8>> = None;

    let usart = registers();
    // Reading the data after the status clears both the byte and the overrun.
    let status = usart.sr().read();
    let byte = usart.dr().read().dr().bits() as u8;
    if QUEUE.is_none() {
        *QUEUE = critical_section::with(|cs| HANDOVER.borrow_ref_mut(cs).take());
    }
    let mut lost = u32::from(status.ore().bit_is_set());
    if status.rxne().bit_is_set() {
        let kept = QUEUE
            .as_mut()
            .is_some_and(|queue| queue.enqueue(byte).is_ok());
        lost += u32::from(!kept);
    }
    if lost > 0 {
        LOST.fetch_add(lost, Ordering::Relaxed);
    }
}
