//! Firmware for an STM32H743, laid out for a NUCLEO-H743ZI2: the application of `spindle_monitor` with
//! its solver in double precision.
//!
//! The records come in, and the log goes out, over USART3 (PD9 and PD8), which that board leads to its
//! USB plug; 460,800 baud, 8N1. `cargo flash-h743` builds it and brings it onto the board.

#![no_std]
#![no_main]

#[path = "../application.rs"]
mod application;
mod board;
#[path = "../monitored.rs"]
mod monitored;

/// What the solver works in: this core has a unit for double precision.
type Precision = f64;

#[cortex_m_rt::entry]
fn main() -> ! {
    application::run()
}
