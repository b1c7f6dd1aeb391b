//! 168 MHz from the crystal, or from the internal oscillator where that cannot be had; its 16 MHz where the PLL does not start.

use super::CORE;
use crate::board::within;
use crate::stm32::clock::Clock;
use crate::stm32::pac::{FLASH, RCC};

/// Frequency of the board's crystal, Hz: a whole number of MHz.
const CRYSTAL_HZ: u32 = 8_000_000;
/// Frequency of the internal oscillator, Hz.
pub const INTERNAL_HZ: u32 = 16_000_000;
/// Frequency of the core when it runs from the PLL, Hz: the most the chip allows.
pub const CORE_HZ: u32 = CORE.hz;

/// Frequency that the PLL compares at, Hz: it jitters least of what it accepts.
const COMPARED_HZ: u32 = 2_000_000;
/// Its oscillator runs at twice the core's frequency,
const PLL_N: u16 = (2 * CORE_HZ / COMPARED_HZ) as u16;
/// and leaves 48 MHz for the peripherals that need them.
const PLL_Q: u8 = (2 * CORE_HZ / 48_000_000) as u8;
/// Flash wait states at this frequency and 2.7 V to 3.6 V.
const WAIT_STATES: u8 = 5;

/// Looks at a ready flag before an oscillator counts as dead: some 50 ms at 16 MHz.
/// A crystal takes 2 ms and the PLL 0.3 ms.
const PATIENCE: u32 = 100_000;

/// Goes as fast as the hardware lets it. Expects the chip as a reset leaves it: on the internal
/// oscillator, with the core supply scaled for 168 MHz.
pub fn start(rcc: &RCC, flash: &FLASH) -> Clock {
    let (source, from_hz) = if crystal(rcc) {
        ("Crystal", CRYSTAL_HZ)
    } else {
        ("InternalOscillator", INTERNAL_HZ)
    };
    if pll(rcc, from_hz) && wait_states(flash) && switch(rcc) {
        return Clock {
            source,
            core_hz: CORE_HZ,
            usart_hz: CORE_HZ / 2,
            log_hz: CORE_HZ / 4,
            timer_hz: CORE_HZ / 2,
        };
    }
    rcc.cfgr().reset();
    within(PATIENCE, || rcc.cfgr().read().sws().is_hsi());
    rcc.cr().modify(|_, w| w.pllon().off().hseon().off());
    Clock::internal(INTERNAL_HZ)
}

fn crystal(rcc: &RCC) -> bool {
    rcc.cr().modify(|_, w| w.hseon().on());
    within(PATIENCE, || rcc.cr().read().hserdy().is_ready())
}

#[allow(
    unsafe_code,
    reason = "the register description does not know the ranges of the factors"
)]
fn pll(rcc: &RCC, from_hz: u32) -> bool {
    const {
        assert!(CRYSTAL_HZ / COMPARED_HZ >= 2 && CRYSTAL_HZ / COMPARED_HZ <= 63);
        assert!(INTERNAL_HZ / COMPARED_HZ >= 2 && PLL_N >= 50 && PLL_N <= 432);
    };
    let pll_m = (from_hz / COMPARED_HZ) as u8;
    rcc.pllcfgr().write(|w| {
        let source = w.pllsrc().bit(from_hz == CRYSTAL_HZ);
        source.pllp().div2();
        // SAFETY: in range, by the assertions above.
        unsafe {
            source
                .pllm()
                .bits(pll_m)
                .plln()
                .bits(PLL_N)
                .pllq()
                .bits(PLL_Q)
        }
    });
    rcc.cr().modify(|_, w| w.pllon().on());
    within(PATIENCE, || rcc.cr().read().pllrdy().is_ready())
}

/// Slows the flash down, before the core is sped up.
fn wait_states(flash: &FLASH) -> bool {
    flash.acr().modify(|_, w| {
        w.latency()
            .ws5()
            .prften()
            .enabled()
            .icen()
            .enabled()
            .dcen()
            .enabled()
    });
    within(PATIENCE, || {
        flash.acr().read().latency().bits() == WAIT_STATES
    })
}

fn switch(rcc: &RCC) -> bool {
    // The peripheral buses take at most 42 and 84 MHz.
    rcc.cfgr()
        .modify(|_, w| w.hpre().div1().ppre1().div4().ppre2().div2());
    rcc.cfgr().modify(|_, w| w.sw().pll());
    within(PATIENCE, || rcc.cfgr().read().sws().is_pll())
}
