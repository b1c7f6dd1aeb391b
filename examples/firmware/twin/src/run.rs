//! Ticks of the host's own build of the monitor.

use anyhow::{Result, ensure};
use spindle_firmware::chain::{self, Chain};
use spindle_firmware::spindle::{ROWS, monitor_settings};
use spindle_monitor::board::Check;
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::tick::{Core, NoCycles, NoWatchdog};
use spindle_monitor::{BoardReport, Marks, Past};
use std::io::{Read, Write};
use twin::{Ending, receive, send};

/// Settings of the STM32F405's monitor.
static MONITOR: MonitorSettings<ROWS> = monitor_settings(&Core::STM32F405);

/// Answers each message of `input`, the bytes for a board until the command of a tick, with the bytes that the board must send.
///
/// # Errors
///
/// The spindle has no equilibrium to start from, or nobody reads.
pub fn run(mut input: impl Read, mut output: impl Write) -> Result<()> {
    let mut marks = [0; Marks::variant_count() as usize];
    let probes = Box::leak(Box::new(chain::probes(&MONITOR)));
    let monitor = chain::monitor(probes, &Past::default(), &MONITOR);
    let mut chain = Chain::new(Box::new(monitor));
    ensure!(
        chain.prepare().is_ok(),
        "the idling spindle has no equilibrium to start from"
    );
    // Self-checks of a sound emulated board: there is no cause of a reset, and in lock-step no stack is measured.
    chain.set_board(BoardReport {
        known_answer: Check::Passed,
        image: Check::Passed,
        ..BoardReport::NONE
    });
    let mut time_us = 0;
    while let Some(bytes) = receive(&mut input)? {
        let mut answer = Vec::new();
        for byte in bytes {
            let Some(room) = chain.push(byte, false) else {
                continue;
            };
            let outcome = chain.tick(time_us, &mut NoCycles, &mut NoWatchdog);
            time_us += u64::from(MONITOR.tick.period_us);
            for mark in outcome.marks.iter() {
                marks[mark as usize] += 1;
            }
            answer.extend((0..room).map_while(|_| chain.next_byte()));
        }
        send(&mut output, &answer)?;
    }
    let ending = Ending {
        marks,
        counts: chain.counts(),
        health: chain.health(),
    };
    Ok(send(
        &mut output,
        &postcard::to_extend(&ending, Vec::new())?,
    )?)
}
