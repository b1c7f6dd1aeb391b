//! The bench of an STM32H743, for `cargo bench-h743`: clock, caches and log are those of the firmware.

#![no_std]
#![no_main]

mod board;

use spindle_firmware::spindle::{ROWS, monitor_settings};
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::tick::Core;

/// The monitor's settings, which the board's start asks for.
static MONITOR: MonitorSettings<ROWS> = monitor_settings(&Core::STM32H743);

#[cortex_m_rt::entry]
fn main() -> ! {
    let Some(board) = board::start() else {
        unreachable!("main runs once, and takes the peripherals once");
    };
    lab::on_board::run(board)
}
