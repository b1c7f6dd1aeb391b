//! The bench of an STM32F405, for `cargo bench-f405`: clock, flash and log are those of the firmware.

#![no_std]
#![no_main]

#[path = "../../../../examples/firmware/f405/board/mod.rs"]
mod board;

use spindle_firmware::spindle::{ROWS, monitor_settings};
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::tick::Core;

/// The monitor's settings, which the board's start asks for.
static MONITOR: MonitorSettings<ROWS> = monitor_settings(&Core::STM32F405);

#[cortex_m_rt::entry]
fn main() -> ! {
    let Some(board) = board::start() else {
        unreachable!("main runs once, and takes the peripherals once");
    };
    lab::on_board::run(board)
}
