//! Input of the monitor's port in a run of a recording: displacements at the probes and a record a tick, and temperatures
//! ten times a second.
//!
//! Faults spoil it if wanted. Now and then comes a command of the operator's.

pub mod faults;
pub mod per_tick;
pub mod records;

use crate::telemetry::decoder::Decoder;
use crate::telemetry::operator::Operator;
use crate::telemetry::state::State;
use anyhow::Result;
use faults::Spoiler;
use records::Recording;
use spindle_monitor::Alarm;
use spindle_monitor::command::{self, Command, MOST_PROBES, ORDER_EVERY};

/// Bytes that the link takes in a tick: 921,600 baud for a millisecond.
pub const ROOM: u16 = 92;
/// Ticks from one message of temperatures to the next.
pub const TEMPERATURES: usize = 100;
/// Ticks between two looks of the operator, who then acknowledges what there is.
const LOOK: usize = 2000;
/// Ticks before the end of the last look: an order for every alarm is carried out in them.
const LAST: usize = Alarm::COUNT * ORDER_EVERY as usize + 2;

/// A tick: bytes in before it, bytes out after it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tick {
    /// Bytes that come in before it.
    pub bytes: Vec<u8>,
    /// Bytes of telemetry that the link takes after it.
    pub room: u16,
}

/// The run of a recording, spoilt.
///
/// `board` runs a tick and returns its telemetry, which the operator reads. All waiting telemetry is sent in the last tick.
///
/// # Errors
///
/// `board` failed.
pub fn ticks(
    recording: &Recording,
    spoiler: &mut Spoiler,
    mut board: impl FnMut(&Tick) -> Result<Vec<u8>>,
) -> Result<Vec<Tick>> {
    let ticks = recording.records.len();
    let (mut state, mut decoder) = (State::default(), Decoder::new());
    let mut operator = Operator::new(Vec::new());
    let mut run = Vec::with_capacity(ticks);
    for tick in 0..ticks {
        if tick % LOOK == LOOK - 1 || tick + LAST == ticks {
            operator.acknowledge(&state);
        }
        operator.follow(&state)?;
        let mut bytes = std::mem::take(operator.get_mut());
        let spoilt = spoiler.spoil(tick, recording);
        let probes = recording.probes.get(tick).copied();
        let is_seen = |probes: &[f32; MOST_PROBES]| probes.iter().any(|um| um.is_finite());
        if let Some(probes) = probes.filter(is_seen) {
            bytes.extend(command::encode(Command::Probes(probes)));
        }
        if let Some(spoilt) = &spoilt {
            bytes.extend(&spoilt.bytes);
            let temperatures = spoilt.temperatures.filter(|_| tick % TEMPERATURES == 0);
            if let Some(temperatures) = temperatures {
                bytes.extend(command::encode(Command::Temperatures(temperatures)));
            }
        }
        let room = match spoilt {
            _ if tick + 1 == ticks => u16::MAX,
            Some(spoilt) if spoilt.is_shut => 0,
            _ => ROOM,
        };
        let tick = Tick { bytes, room };
        for byte in board(&tick)? {
            if let Some(event) = decoder.push(byte) {
                state.note(&event, decoder.tally());
            }
        }
        run.push(tick);
    }
    Ok(run)
}
