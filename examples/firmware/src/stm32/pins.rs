//! Port C: its pins are straps.

use super::pac::GPIOC;
use crate::strap::{Pins, Pull};

/// The port, its clock on.
pub struct PortC(pub GPIOC);

impl Pins for PortC {
    fn input(&self, pin: u8, pull: Pull) {
        self.0.moder().modify(|_, w| w.moder(pin).input());
        self.0.pupdr().modify(|_, w| match pull {
            Pull::None => w.pupdr(pin).floating(),
            Pull::Up => w.pupdr(pin).pull_up(),
            Pull::Down => w.pupdr(pin).pull_down(),
        });
    }

    fn drive(&self, pin: u8, high: bool) {
        self.0.bsrr().write(|w| {
            if high {
                w.bs(pin).set_bit()
            } else {
                w.br(pin).set_bit()
            }
        });
        self.0.moder().modify(|_, w| w.moder(pin).output());
    }

    fn is_high(&self, pin: u8) -> bool {
        self.0.idr().read().idr(pin).bit_is_set()
    }
}
