//! 400 MHz from the clock at the oscillator's pins, or from the internal one where that cannot be had.
//!
//! 400 MHz is what every revision of the chip reaches; 480 MHz takes revision V and another core supply.

use super::CORE;
use crate::board::within;
use crate::stm32::clock::Clock;
use crate::stm32::pac::{FLASH, PWR, RCC};

/// Frequency at the oscillator's pins, Hz: a whole, even number of MHz.
const EXTERNAL_HZ: u32 = 8_000_000;
/// Whether a clock comes in there, as from the debugger of a Nucleo board, or a crystal is there.
const EXTERNAL_IS_CLOCK: bool = true;
/// Frequency of the internal oscillator, Hz.
const INTERNAL_HZ: u32 = 64_000_000;
/// Frequency of the core when it runs from the PLL, Hz.
const CORE_HZ: u32 = CORE.hz;
/// Frequency that the PLL compares at, Hz: the lower end of its range of 2 MHz to 4 MHz.
const COMPARED_HZ: u32 = 2_000_000;
/// The PLL's oscillator runs at twice the core's frequency: 800 MHz, of 192 MHz to 836 MHz.
const PLL_N: u16 = (2 * CORE_HZ / COMPARED_HZ) as u16;
/// Flash wait states for a bus at 185 MHz to 210 MHz and core supply scale 1, and the programming delay
/// that goes with them.
const WAIT_STATES: u8 = 2;
const PROGRAMMING_DELAY: u8 = 2;

/// Looks at a ready flag before an oscillator counts as dead: some 20 ms at 64 MHz.
/// A crystal takes 2 ms and the PLL 0.2 ms.
const PATIENCE: u32 = 100_000;

/// Goes as fast as the hardware lets it. Expects the chip as a reset leaves it: on the internal
/// oscillator, with the core supply scaled for slow clocks.
pub fn start(rcc: &RCC, pwr: &PWR, flash: &FLASH) -> Clock {
    let is_external = external(rcc);
    if supply(pwr) && pll(rcc, is_external) && wait_states(flash) && switch(rcc) {
        return Clock {
            source: if is_external {
                "External"
            } else {
                "InternalOscillator"
            },
            core_hz: CORE_HZ,
            usart_hz: CORE_HZ / 4,
            log_hz: CORE_HZ / 4,
            timer_hz: CORE_HZ / 2,
        };
    }
    rcc.cfgr().reset();
    within(PATIENCE, || rcc.cfgr().read().sws().is_hsi());
    rcc.d1cfgr().reset();
    rcc.d2cfgr().reset();
    rcc.d3cfgr().reset();
    rcc.cr().modify(|_, w| w.pll1on().off().hseon().off());
    Clock::internal(INTERNAL_HZ)
}

fn external(rcc: &RCC) -> bool {
    rcc.cr().modify(|_, w| w.hsebyp().bit(EXTERNAL_IS_CLOCK));
    rcc.cr().modify(|_, w| w.hseon().on());
    let ready = within(PATIENCE, || rcc.cr().read().hserdy().is_ready());
    if !ready {
        rcc.cr().modify(|_, w| w.hseon().off());
    }
    ready
}

/// Says that the internal regulator feeds the core. This can be said once after power comes on, and
/// must be before the supply is raised to the scale for this frequency.
#[allow(
    unsafe_code,
    reason = "the register description does not know the scales"
)]
fn supply(pwr: &PWR) -> bool {
    pwr.cr3()
        .modify(|_, w| w.scuen().set_bit().ldoen().set_bit().bypass().clear_bit());
    if !within(PATIENCE, || pwr.csr1().read().actvosrdy().bit_is_set()) {
        return false;
    }
    // SAFETY: 3 is scale 1.
    pwr.d3cr().modify(|_, w| unsafe { w.vos().bits(3) });
    within(PATIENCE, || pwr.d3cr().read().vosrdy().bit_is_set())
}

#[allow(
    unsafe_code,
    reason = "the register description does not know the ranges of all factors"
)]
fn pll(rcc: &RCC, is_external: bool) -> bool {
    const {
        assert!(EXTERNAL_HZ.is_multiple_of(COMPARED_HZ) && EXTERNAL_HZ / COMPARED_HZ <= 63);
        assert!(INTERNAL_HZ.is_multiple_of(COMPARED_HZ) && INTERNAL_HZ / COMPARED_HZ <= 63);
        assert!(PLL_N >= 4 && PLL_N <= 512);
    };
    rcc.pllckselr().modify(|_, w| {
        let divisor = if is_external {
            w.pllsrc().hse();
            EXTERNAL_HZ / COMPARED_HZ
        } else {
            w.pllsrc().hsi();
            INTERNAL_HZ / COMPARED_HZ
        };
        // SAFETY: in range, by the assertions above.
        unsafe { w.divm1().bits(divisor as u8) }
    });
    rcc.pllcfgr().modify(|_, w| {
        w.pll1vcosel().wide_vco().pll1rge().range2();
        w.pll1fracen().reset().divp1en().enabled()
    });
    rcc.pll1divr().modify(|_, w| {
        // SAFETY: in range, by the assertions above; the register holds one less.
        unsafe { w.divn1().bits(PLL_N - 1) };
        w.divp1().div2()
    });
    rcc.cr().modify(|_, w| w.pll1on().on());
    within(PATIENCE, || rcc.cr().read().pll1rdy().bit_is_set())
}

/// Slows the flash down, before its bus is sped up.
#[allow(
    unsafe_code,
    reason = "the register description does not know the wait states"
)]
fn wait_states(flash: &FLASH) -> bool {
    // SAFETY: both are in the range of their fields.
    flash.acr().write(|w| unsafe {
        w.latency().bits(WAIT_STATES);
        w.wrhighfreq().bits(PROGRAMMING_DELAY)
    });
    within(PATIENCE, || {
        flash.acr().read().latency().bits() == WAIT_STATES
    })
}

fn switch(rcc: &RCC) -> bool {
    // The buses take at most 200 MHz (AXI, AHB) and 100 MHz (the four APB).
    rcc.d1cfgr()
        .modify(|_, w| w.d1cpre().div1().hpre().div2().d1ppre().div2());
    rcc.d2cfgr()
        .modify(|_, w| w.d2ppre1().div2().d2ppre2().div2());
    rcc.d3cfgr().modify(|_, w| w.d3ppre().div2());
    rcc.cfgr().modify(|_, w| w.sw().pll1());
    within(PATIENCE, || rcc.cfgr().read().sws().is_pll1())
}
