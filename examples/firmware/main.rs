//! Firmware for an STM32F405: measured loads and speed in, stiffness, alarms and rating life out.
//!
//! - USART1, 460,800 baud, 8N1: in (PA10), [`LoadRecord`](spindle_monitor::record::LoadRecord)s, framed as
//!   the `record` module says, and commands (`chain.rs`); out (PA9), frames of
//!   [`telemetry`](spindle_monitor::telemetry).
//! - USART2 (PA2), the same baud rate: a defmt log. `ready: ...` once, then alarms that change, and
//!   received bytes that were lost.
//! - PC0 to ground and PC1 to PC2: lock-step, as on an emulator. There is no timer then, and a tick is what the other
//!   side asks for.
//!
//! `cargo emulate` runs it without a board, `cargo flash-f405` brings it onto one with an 8 MHz crystal.
//! `firmware_h743` has the same for another board.

#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
mod application;
#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod chain;
#[cfg(target_os = "none")]
mod monitor_settings;
#[cfg(target_os = "none")]
mod monitored;
#[cfg(target_os = "none")]
mod self_check;

#[cfg(target_os = "none")]
use spindle_monitor::tick::CycleCost;

/// The core's frequency, and the cost of a tick there.
#[cfg(target_os = "none")]
const CORE_HZ: u32 = 168_000_000;
#[cfg(target_os = "none")]
const COST: CycleCost = CycleCost::CORTEX_M4F;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    application::run()
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This is firmware for an STM32F405. `cargo emulate` runs it on an emulated one, \
         `cargo flash-f405` on a board."
    );
}
