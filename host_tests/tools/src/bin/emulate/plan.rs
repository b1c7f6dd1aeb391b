//! A run: bytes over the port, tick by tick, and the answers of the host's own build of the same monitor.

use anyhow::{Result, ensure};
use host_tests::telemetry::simulated::MONITOR;
use spindle_firmware::chain::Chain;
use spindle_monitor::board::Check;
use spindle_monitor::command::{self, Command};
use spindle_monitor::loads::FrameCounts;
use spindle_monitor::telemetry::HealthReport;
use spindle_monitor::tick::{NoCycles, NoWatchdog};
use spindle_monitor::{BoardReport, Marks, Past};
use tools::stream::{
    self,
    faults::{Episode, Spoiler},
    records::Recording,
};

/// A run.
pub struct Plan {
    /// Bytes for the board.
    pub input: Vec<u8>,
    /// Bytes that the board must answer, to the bit.
    pub expected: Vec<u8>,
    /// Ticks with each mark, in the order of their bits.
    pub marks: [u64; Marks::variant_count() as usize],
    /// Counts of the records that came over the port.
    pub counts: FrameCounts,
    /// Faults.
    pub episodes: Vec<Episode>,
    /// Counters at the end.
    pub health: HealthReport,
}

/// Makes the run of a recording, spoilt.
pub fn plan(recording: &Recording, mut spoiler: Spoiler) -> Result<Plan> {
    let period = MONITOR.tick.period_us;
    let mut input = Vec::new();
    let mut expected = Vec::new();
    let mut marks = [0; Marks::variant_count() as usize];
    let mut chain = Chain::new(&Past::default(), &MONITOR);
    let prepared = chain.prepare();
    ensure!(prepared.is_ok(), "no equilibrium to start from");
    // Self-checks of a sound emulated board: there is no cause of a reset, and in lock-step no stack is measured.
    chain.set_board(BoardReport {
        known_answer: Check::Passed,
        image: Check::Passed,
        ..BoardReport::NONE
    });
    let (mut done, mut told) = (0, 0);
    stream::ticks(recording, &mut spoiler, &MONITOR, |tick| {
        input.extend(&tick.bytes);
        input.extend(command::encode(Command::Tick(tick.room)));
        let answered = expected.len();
        for byte in &input[told..] {
            let Some(room) = chain.push(*byte, false) else {
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
        Ok(expected[answered..].to_vec())
    })?;
    Ok(Plan {
        input,
        expected,
        marks,
        counts: chain.counts(),
        episodes: spoiler.episodes,
        health: chain.health(),
    })
}
