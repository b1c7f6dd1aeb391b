//! Firmware for an STM32H743, laid out for a NUCLEO-H743ZI2: the application of `spindle_firmware`.
//!
//! Records and commands come in, and telemetry goes out, over USART3 (PD9 and PD8). That board leads it to
//! its USB plug. The log goes out over USART2 (PD5). 921,600 baud, 8N1. PC0
//! to ground and PC1 to PC2: lock-step. `cargo flash-h743` builds it and brings it onto the board.

#![no_std]
#![no_main]

use spindle_firmware::{application, stm32};

#[cortex_m_rt::entry]
fn main() -> ! {
    application::run(stm32::start())
}
