//! Firmware for an STM32H743, laid out for a NUCLEO-H743ZI2: the application of `spindle_firmware`.
//!
//! Records and commands come in, and telemetry goes out, over USART3 (PD9 and PD8). That board leads it to
//! its USB plug. The log goes out over USART2 (PD5). 460,800 baud, 8N1. PC0
//! to ground and PC1 to PC2: lock-step. `cargo flash-h743` builds it and brings it onto the board.

#![no_std]
#![no_main]

#[path = "../firmware/application.rs"]
mod application;
mod board;
#[path = "../firmware/chain.rs"]
mod chain;
#[path = "../firmware/monitor_settings.rs"]
mod monitor_settings;
#[path = "../firmware/monitored.rs"]
mod monitored;
#[path = "../firmware/self_check.rs"]
mod self_check;

use spindle_monitor::tick::CycleCost;

/// The core's frequency, and the cost of a tick there.
const CORE_HZ: u32 = 400_000_000;
const COST: CycleCost = CycleCost::CORTEX_M7;

#[cortex_m_rt::entry]
fn main() -> ! {
    application::run()
}
