//! Wires at port C: those that put a board into lock-step, PC0 to ground, and PC1 to PC2; service, PC6 to 3.3 V; and two
//! outputs for the machine's controller.
//!
//! No single short puts a board into lock-step.

use spindle_monitor::Outputs;

/// Pull of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pull {
    /// None.
    None,
    /// To the supply.
    Up,
    /// To ground.
    Down,
}

/// Pins of a port, by their numbers.
pub trait Pins {
    /// Makes a pin an input.
    fn input(&self, pin: u8, pull: Pull);

    /// Drives a pin high or low.
    fn drive(&self, pin: u8, high: bool);

    /// Whether a pin is high.
    fn is_high(&self, pin: u8) -> bool;
}

/// Whether PC0 reads low against a pull-up. On an emulated board, which has no pins, every input is low.
pub fn is_grounded(port: &impl Pins, core_hz: u32) -> bool {
    port.input(0, Pull::Up);
    settle(core_hz);
    !port.is_high(0)
}

/// Whether PC1 follows PC2 up and down, against its own pull. Drives PC2, and lets go of it again.
pub fn is_wired(port: &impl Pins, core_hz: u32) -> bool {
    let follows = [true, false, true, false].into_iter().all(|high| {
        port.input(1, if high { Pull::Down } else { Pull::Up });
        port.drive(2, high);
        settle(core_hz);
        port.is_high(1) == high
    });
    port.input(2, Pull::None);
    follows
}

/// Wires to the machine: PC6, in service; PC7 and PC8, to its controller.
pub struct Wires<P>(P);

impl<P: Pins> Wires<P> {
    /// Pulls PC6 down. PC7 and PC8 are inputs until the first tick has ended, as they are in a reset.
    pub fn start(port: P) -> Self {
        port.input(6, Pull::Down);
        Self(port)
    }

    /// Whether PC6 is high: somebody at the machine is in service. Open, and on an emulated board, it is low.
    pub fn is_in_service(&self) -> bool {
        self.0.is_high(6)
    }

    /// Drives PC7 high if no alarm stands, and PC8 if the spindle is monitored.
    pub fn put_out(&self, outputs: &Outputs) {
        self.0.drive(7, outputs.no_alarm);
        self.0.drive(8, outputs.monitored);
    }
}

/// A pull takes a few microseconds to charge a pin: 100 us.
fn settle(core_hz: u32) {
    cortex_m::asm::delay(core_hz / 10_000);
}
