//! An STM32 as the monitor needs it: clock, serial ports, flash, watchdogs and sensors.
//!
//! Here is what the STM32F405 and the STM32H743 have in common. Their folders have the rest, on registers that differ.

mod brown_out;
mod cells;
mod clock;
mod iwdg;
mod pins;
mod sensors;

#[cfg(feature = "f405")]
mod f405;
#[cfg(feature = "h743")]
mod h743;

#[cfg(feature = "f405")]
use {f405 as chip, stm32f4::stm32f405 as pac};
#[cfg(feature = "h743")]
use {h743 as chip, stm32h7::stm32h743 as pac};

use crate::board::{Board, Started};
use crate::receiver::BAUD;
use crate::spindle::{BALLS, ROWS, monitor_settings};
use chip::serial;
use spindle_monitor::settings::MonitorSettings;

/// The monitor's settings on this core.
static MONITOR: MonitorSettings<ROWS> = monitor_settings(&chip::CORE);

const _: () = assert!(
    MONITOR.fits_port(BAUD, BALLS),
    "the port is too slow for the telemetry"
);

/// The board.
pub struct Stm32;

impl Board for Stm32 {
    const MONITOR: &'static MonitorSettings<ROWS> = &MONITOR;

    type Cells = chip::cells::Memory;
    type Pins = pins::PortC;
    type Watchdogs = chip::dog::Watchdogs;

    fn received() -> Option<u8> {
        serial::received()
    }

    fn is_free() -> bool {
        serial::is_free()
    }

    fn send(byte: u8) {
        serial::send(byte);
    }
}

/// Starts everything but the timer.
pub fn start() -> Started<Stm32> {
    let (Some(chip), Some(core)) = (pac::Peripherals::take(), cortex_m::Peripherals::take()) else {
        unreachable!("main runs once, and takes the peripherals once");
    };
    chip::start(chip, core)
}
