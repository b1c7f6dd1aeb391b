//! Firmware for an STM32F405: measured loads and speed in, stiffness, alarms and rating life out.
//!
//! - USART1, 921,600 baud, 8N1: in (PA10), [`LoadRecord`](spindle_monitor::record::LoadRecord)s, framed as
//!   the `record` module says, and commands (`chain.rs`); out (PA9), frames of
//!   [`telemetry`](spindle_monitor::telemetry).
//! - USART2 (PA2), the same baud rate: a defmt log. `ready: ...` once, then alarms that change, and
//!   received bytes that were lost.
//! - PC0 to ground and PC1 to PC2: lock-step, as on an emulator. There is no timer then, and a tick is what the other
//!   side asks for.
//!
//! `cargo emulate` runs it without a board, `cargo flash-f405` brings it onto one with an 8 MHz crystal.
//! `../h743` has the same for another board.

#![no_std]
#![no_main]

use spindle_firmware::{application, stm32};

#[cortex_m_rt::entry]
fn main() -> ! {
    application::run(stm32::start())
}
