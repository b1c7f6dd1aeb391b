//! Pins and timer of strain bridges and tachometer.
//!
//! | pin | line |
//! | --- | --- |
//! | PA5, PA6, PA7 | SCLK, DOUT, DIN of the converter |
//! | PA4 | CS |
//! | PB0 | DRDY |
//! | PB1 | SYNC/RESET |
//! | PA0 | pulses of the tachometer, rising edges |

#![allow(unsafe_code, reason = "registers without an owner")]

use super::MONITOR;
use super::chip::{CORE, spi};
use super::pac::{GPIOA, GPIOB, Interrupt, NVIC, TIM2, interrupt};
use crate::sensors::{Measured, Wiring, edge};
use crate::spindle::TACHOMETER;

/// The wiring.
const WIRING: Wiring = Wiring {
    exchange: spi::exchange,
    drdy,
    reset,
    select,
    now,
    core_mhz: CORE.hz / 1_000_000,
};

/// Starts pins and timer, and with them the sensors. Their clocks are on already; the timer counts at `timer_hz`.
pub fn start(gpioa: &GPIOA, gpiob: &GPIOB, tim2: &TIM2, timer_hz: u32) -> Measured {
    gpioa.afrl().modify(|_, w| {
        w.afr(0).af1();
        w.afr(5).af5().afr(6).af5().afr(7).af5()
    });
    gpioa.bsrr().write(|w| w.bs4().set_bit());
    gpioa.pupdr().modify(|_, w| w.pupdr0().pull_down());
    gpioa.moder().modify(|_, w| {
        w.moder0().alternate().moder4().output();
        w.moder5()
            .alternate()
            .moder6()
            .alternate()
            .moder7()
            .alternate()
    });
    gpiob.bsrr().write(|w| w.bs1().set_bit());
    // Without a converter, there is never a conversion.
    gpiob.pupdr().modify(|_, w| w.pupdr0().pull_up());
    gpiob
        .moder()
        .modify(|_, w| w.moder0().input().moder1().output());

    let divisor = timer_hz / TACHOMETER.timer_hz;
    // SAFETY: the register holds one less than the divisor, which is some hundred at most.
    tim2.psc()
        .write(|w| unsafe { w.psc().bits(divisor.saturating_sub(1) as u16) });
    // The divisor counts from the next overflow on: this makes one.
    tim2.egr().write(|w| w.ug().set_bit());
    // An edge must last: eight looks at the timer's clock by 8.
    tim2.ccmr1_input()
        .write(|w| w.cc1s().ti1().ic1f().fdts_div8_n8());
    tim2.ccer().write(|w| w.cc1e().set_bit());
    tim2.dier().write(|w| w.cc1ie().set_bit());
    tim2.cr1().write(|w| w.cen().set_bit());
    // SAFETY: the handler shares nothing with the main program but what is behind a mutex.
    unsafe { NVIC::unmask(Interrupt::TIM2) };
    Measured::start(&WIRING, MONITOR.plausibility.stuck_after)
}

// Functions by themselves, so that `cargo check-firmware` finds them.

#[inline(never)]
fn drdy() -> bool {
    // SAFETY: reading a port's pins changes nothing.
    let port = unsafe { &*GPIOB::ptr() };
    port.idr().read().idr0().bit_is_set()
}

#[inline(never)]
fn select(high: bool) {
    // SAFETY: a write of this register changes the pins that it names, and nobody else names this one.
    let port = unsafe { &*GPIOA::ptr() };
    port.bsrr().write(|w| w.bs4().bit(high).br4().bit(!high));
}

#[inline(never)]
fn reset(high: bool) {
    // SAFETY: as above.
    let port = unsafe { &*GPIOB::ptr() };
    port.bsrr().write(|w| w.bs1().bit(high).br1().bit(!high));
}

#[inline(never)]
fn now() -> u32 {
    // SAFETY: reading the timer's count changes nothing.
    unsafe { &*TIM2::ptr() }.cnt().read().bits()
}

#[interrupt]
fn TIM2() {
    // SAFETY: reading the capture is what tells the timer that it was seen; nobody else reads it.
    edge(unsafe { &*TIM2::ptr() }.ccr1().read().bits());
}
