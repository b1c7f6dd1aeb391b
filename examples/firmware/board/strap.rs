//! The wires that put a board into lock-step: PC0 to ground, and PC1 to PC2. No single short does that. And the one that
//! lets a bearing be replaced: PC6 to 3.3 V.

use super::pac::GPIOC;

/// Whether PC0 reads low against a pull-up. On an emulated board, which has no pins, every input is low.
pub fn is_grounded(gpioc: &GPIOC, core_hz: u32) -> bool {
    gpioc.moder().modify(|_, w| w.moder0().input());
    gpioc.pupdr().modify(|_, w| w.pupdr0().pull_up());
    settle(core_hz);
    gpioc.idr().read().idr0().bit_is_clear()
}

/// Whether PC1 follows PC2 up and down, against its own pull. Drives PC2, and lets go of it again.
pub fn is_wired(gpioc: &GPIOC, core_hz: u32) -> bool {
    gpioc.moder().modify(|_, w| w.moder1().input());
    let follows = [true, false, true, false].into_iter().all(|high| {
        gpioc.pupdr().modify(|_, w| {
            if high {
                w.pupdr1().pull_down()
            } else {
                w.pupdr1().pull_up()
            }
        });
        gpioc.bsrr().write(|w| {
            if high {
                w.bs2().set_bit()
            } else {
                w.br2().set_bit()
            }
        });
        gpioc.moder().modify(|_, w| w.moder2().output());
        settle(core_hz);
        gpioc.idr().read().idr1().bit_is_set() == high
    });
    gpioc.moder().modify(|_, w| w.moder2().input());
    follows
}

/// PC6, high in service. Open, and on an emulated board, it is low.
pub struct Service(GPIOC);

impl Service {
    /// Pulls it down.
    pub fn start(gpioc: GPIOC) -> Self {
        gpioc.moder().modify(|_, w| w.moder6().input());
        gpioc.pupdr().modify(|_, w| w.pupdr6().pull_down());
        Self(gpioc)
    }

    /// Whether it is high.
    pub fn is_on(&self) -> bool {
        self.0.idr().read().idr6().bit_is_set()
    }
}

/// A pull takes a few microseconds to charge a pin: 100 us.
fn settle(core_hz: u32) {
    cortex_m::asm::delay(core_hz / 10_000);
}
