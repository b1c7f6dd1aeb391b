//! Firmware for an STM32F405: measured loads and speed in, stiffness and contact forces out.
//!
//! In: [`LoadRecord`](spindle_bearing::record::LoadRecord)s, framed as the `record` module says, on
//! USART1 (PA10), 460,800 baud, 8N1. Out: one defmt line per record on the same USART (PA9).
//!
//! | line | when |
//! | --- | --- |
//! | `ready: ...` | once, when records may come |
//! | `Estimate { ... }` | a record was solved; `limits` names the physical limits that it passes |
//! | `Refusal { ... }` | a record has no equilibrium; its status says why |
//! | `corrupt frame N: ...` | a frame was damaged; N counts them |
//! | `receiver lost N bytes` | records came faster than they could be taken; N is the sum so far |
//!
//! `cargo emulate` runs it without a board, `cargo flash-f405` brings it onto one with an 8 MHz crystal.
//! `h743` beside this file has the same for another board.

#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
mod application;
#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod monitored;

/// What the solver works in: this core has no double precision.
#[cfg(target_os = "none")]
type Precision = f32;

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
