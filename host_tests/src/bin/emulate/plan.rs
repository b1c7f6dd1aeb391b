//! A run: what goes over the port, tick by tick, and what the host's own build of the same monitor makes of
//! it.

use crate::chain::{self, Chain, Command};
use crate::faults::{Episode, Spoiler};
use crate::monitor_settings::MONITOR;
use anyhow::{Result, ensure};
use spindle_bearing::monitor::loads::FrameCounts;
use spindle_bearing::monitor::telemetry::HealthReport;
use spindle_bearing::monitor::tick::{CycleCounter, NoWatchdog};
use spindle_bearing::monitor::{Alarm, Mark};
use spindle_bearing::record::LoadRecord;

/// Bytes that the link takes in a tick: those of 460,800 baud in a millisecond.
const ROOM: u16 = 46;
/// Ticks between two looks of the operator, who then acknowledges what there is.
const LOOK: usize = 2000;
/// Ticks in which the baseline is learnt.
const LEARNING: usize = 2000;

/// A run.
pub struct Plan {
    /// Bytes for the board.
    pub input: Vec<u8>,
    /// What it must answer, to the bit.
    pub expected: Vec<u8>,
    /// Ticks with each mark, in the order of [`Mark::ALL`].
    pub marks: [u64; Mark::ALL.len()],
    /// What came over the port.
    pub counts: FrameCounts,
    /// Faults.
    pub episodes: Vec<Episode>,
    /// Counters at the end.
    pub health: HealthReport,
}

/// A core that counts no cycles, as that of the emulator.
struct NoCycles;

impl CycleCounter for NoCycles {
    fn cycles(&mut self) -> u32 {
        0
    }
}

/// Makes the run of these records, spoilt.
pub fn plan(records: &[LoadRecord], mut spoiler: Spoiler) -> Result<Plan> {
    let period = MONITOR.tick.period_us;
    // The last tick is one with a health report, so that the board's own counters are the last word.
    let per_report = (MONITOR.telemetry.health_us / period).max(1) as usize;
    let ticks = records.len().div_ceil(per_report) * per_report + 1;
    let mut input = Vec::new();
    let mut expected = Vec::new();
    let mut marks = [0; Mark::ALL.len()];
    let mut chain = Chain::new();
    let prepared = chain.prepare();
    ensure!(prepared.is_ok(), "no equilibrium to start from");
    let (mut done, mut told) = (0, 0);
    for tick in 0..ticks {
        if tick == 0 || tick == LEARNING {
            input.extend(chain::encode(Command::Learn(tick == 0)));
        }
        let mut shut = false;
        if let Some(record) = records.get(tick) {
            let spoilt = spoiler.spoil(tick, record);
            input.extend(spoilt.bytes);
            shut = spoilt.shut;
        }
        let last = tick + 1 == ticks;
        if tick % LOOK == LOOK - 1 || tick + 2 == ticks {
            for alarm in Alarm::ALL {
                input.extend(chain::encode(Command::Acknowledge(alarm)));
            }
        }
        let room = match (last, shut) {
            (true, _) => u16::MAX,
            (_, true) => 0,
            _ => ROOM,
        };
        input.extend(chain::encode(Command::Tick(room)));

        for byte in &input[told..] {
            let Some(room) = chain.push(*byte) else {
                continue;
            };
            let time_us = done * u64::from(period);
            let outcome = chain.tick(time_us, &mut NoCycles, &mut NoWatchdog);
            done += 1;
            for mark in outcome.marks.iter() {
                marks[mark as usize] += 1;
            }
            let bytes = (0..room).map_while(|_| chain.next_byte());
            expected.extend(bytes);
        }
        told = input.len();
    }
    Ok(Plan {
        input,
        expected,
        marks,
        counts: chain.counts(),
        episodes: spoiler.episodes().to_vec(),
        health: chain.health(),
    })
}
