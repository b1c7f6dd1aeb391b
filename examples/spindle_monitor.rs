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
//! `cargo emulate` runs it without a board. On a board with an 8 MHz crystal:
//! `cargo run --release --target thumbv7em-none-eabihf --features defmt,record --example
//! spindle_monitor`.

#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod monitored;

#[cfg(target_os = "none")]
use spindle_bearing::{
    Settings,
    estimate::{Estimate, Refusal},
    record::LoadRecord,
};

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use monitored::{BEARING, Monitor, settings};
    use spindle_bearing::record::{FrameReader, MESSAGE_LENGTH};

    let Some((clock, mut receiver)) = board::start() else {
        unreachable!("main runs once, and takes the peripherals once");
    };
    let Some(solver) = cortex_m::singleton!(: Monitor = Monitor::new(&BEARING)) else {
        unreachable!("main runs once, and makes one solver");
    };
    let settings = settings();
    let mut frames = FrameReader::<MESSAGE_LENGTH>::new();
    let mut corrupt: u32 = 0;
    let mut lost = 0;
    defmt::info!(
        "ready: core at {=u32} MHz, clock {}, {=u32} baud",
        clock.core_hz / 1_000_000,
        clock.source,
        board::BAUD
    );
    loop {
        match frames.push(receiver.wait_for_byte()) {
            None => {}
            Some(Ok(record)) => match estimate(solver, &record, &settings) {
                Ok(estimate) => defmt::info!("{}", estimate),
                Err(refusal) => defmt::warn!("{}", refusal),
            },
            Some(Err(error)) => {
                corrupt = corrupt.wrapping_add(1);
                defmt::warn!("corrupt frame {=u32}: {=str}", corrupt, error.name());
            }
        }
        if receiver.lost() != lost {
            lost = receiver.lost();
            defmt::warn!("receiver lost {=u32} bytes", lost);
        }
    }
}

/// All that is to be proved free of panics, kept apart from `main`, which has some:
/// `cargo check-firmware` looks at what it calls.
#[cfg(target_os = "none")]
#[inline(never)]
fn estimate(
    solver: &mut monitored::Monitor,
    record: &LoadRecord,
    settings: &Settings<f32>,
) -> Result<Estimate, Refusal> {
    Estimate::of(solver, record, settings, &monitored::LIMITS)
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This is firmware for an STM32F405. `cargo emulate` runs it on an emulated one; on a board:\n\
         cargo run --release --target thumbv7em-none-eabihf --features defmt,record --example spindle_monitor"
    );
}
