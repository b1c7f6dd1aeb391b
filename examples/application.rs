//! The monitor's application, the same on every board: measured loads and speed in, stiffness and
//! contact forces out. The board is `super::board`, the bearing `super::monitored`.

use super::monitored::{self, BEARING, Monitor, settings};
use super::{Precision, board};
use spindle_bearing::Settings;
use spindle_bearing::estimate::{Estimate, Refusal};
use spindle_bearing::record::{FrameReader, LoadRecord, MESSAGE_LENGTH};

/// Takes the board, and never gives it back.
pub fn run() -> ! {
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

/// All that is to be proved free of panics, kept apart from `run`, which has some:
/// `cargo check-firmware` looks at what it calls.
#[inline(never)]
fn estimate(
    solver: &mut Monitor,
    record: &LoadRecord,
    settings: &Settings<Precision>,
) -> Result<Estimate, Refusal> {
    Estimate::of(solver, record, settings, &monitored::LIMITS)
}
