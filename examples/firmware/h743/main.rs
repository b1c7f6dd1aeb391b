//! Firmware for an STM32H743, laid out for a NUCLEO-H743ZI2: the application of `spindle_firmware`.
//!
//! Records and commands come in, and telemetry goes out, over USART3 (PD9 and PD8). That board leads it to
//! its USB plug. The log goes out over USART2 (PD5). 921,600 baud, 8N1. PC0
//! to ground and PC1 to PC2: lock-step. `cargo flash-h743` builds it and brings it onto the board.

#![no_std]
#![no_main]

mod board;

use spindle_firmware::application;
use spindle_firmware::spindle::ROWS;
use spindle_firmware::spindle::monitor_settings;
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::tick::Core;

/// The monitor's settings on this core.
static MONITOR: MonitorSettings<ROWS> = monitor_settings(&Core::STM32H743);

#[cortex_m_rt::entry]
fn main() -> ! {
    let Some(board) = board::start() else {
        unreachable!("main runs once, and takes the peripherals once");
    };
    application::run(board)
}
