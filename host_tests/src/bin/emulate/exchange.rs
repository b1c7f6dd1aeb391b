//! Records out, answers back, and the comparison.

use crate::emulator::{self, Board};
use crate::firmware::Firmware;
use crate::monitored::{BEARING, LIMITS, Monitor, settings};
use crate::report::{HEADER, Report};
use crate::toolchain::Emulator;
use anyhow::{Context, Result, bail};
use indicatif::{ProgressBar, ProgressStyle};
use spindle_bearing::estimate::Estimate;
use spindle_bearing::record::{
    DELIMITER, FRAME_LENGTH, FrameReader, LoadRecord, MESSAGE_LENGTH, encode,
};
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// Frames under way at once: enough to keep the board busy, and few enough to fit its queue.
const WINDOW: usize = 8;

/// What to run.
pub struct Plan {
    /// The records, in order.
    pub records: Vec<LoadRecord>,
    /// A damaged frame after every so many records, 0 for none.
    pub corrupt: usize,
    /// Show every so many records.
    pub every: usize,
    /// Longest wait for an answer.
    pub patience: Duration,
}

/// What the board has to say next.
enum Answer {
    /// The report of this record, as the host has it.
    Report(Report),
    /// That a frame was damaged.
    Corrupt(String),
}

/// Frames in the order in which they are sent, each with the answer it must get.
struct Feed<'p> {
    plan: &'p Plan,
    monitor: Monitor,
    next: usize,
    damaged: usize,
    /// A damaged frame is due before the next record.
    due: bool,
}

impl Feed<'_> {
    fn next(&mut self) -> Result<Option<(Vec<u8>, Answer)>> {
        if self.due {
            self.due = false;
            self.damaged += 1;
            let frame = damage(&self.plan.records[self.next - 1], self.damaged);
            let mut reader = FrameReader::<MESSAGE_LENGTH>::new();
            let error = frame.iter().find_map(|byte| reader.push(*byte));
            let Some(Err(error)) = error else {
                bail!("a frame that was damaged on purpose passes for a whole one");
            };
            let line = format!("corrupt frame {}: {}", self.damaged, error.name());
            return Ok(Some((frame, Answer::Corrupt(line))));
        }
        let Some(record) = self.plan.records.get(self.next) else {
            return Ok(None);
        };
        self.next += 1;
        self.due = self.next.is_multiple_of(self.plan.corrupt);
        let report = match Estimate::of(&mut self.monitor, record, &settings(), &LIMITS) {
            Ok(estimate) => Report::of(&estimate),
            Err(refusal) => Report::of(&refusal),
        };
        let report = report.context("the host cannot print its own report")?;
        Ok(Some((encode(record).to_vec(), Answer::Report(report))))
    }
}

/// A frame that went wrong on its way, in one of three ways.
fn damage(record: &LoadRecord, way: usize) -> Vec<u8> {
    let mut frame = encode(record).to_vec();
    let middle = frame.len() / 2;
    match way % 3 {
        // One bit turned over, though not into a delimiter.
        0 => frame[middle] ^= if frame[middle] == 1 { 2 } else { 1 },
        // Bytes missing.
        1 => drop(frame.drain(middle..frame.len() - 1)),
        // The delimiter missing, many times over.
        _ => {
            frame = [0x55; 3 * FRAME_LENGTH].to_vec();
            frame.push(DELIMITER);
        }
    }
    frame
}

/// Runs the plan, prints the estimates, and fails at the first answer that is not the host's.
pub fn run(plan: &Plan, firmware: &Firmware, emulator: &Emulator) -> Result<()> {
    let table = emulator::table(firmware)?;
    let mut board = Board::start(emulator, firmware, &table, plan.patience)?;
    let ready = board.line()?;
    if !ready.starts_with("ready") {
        bail!("instead of being ready, {}", explain(&ready));
    }
    let total = plan.records.len();
    let mut out = std::io::stdout();
    writeln!(out, "{} {ready}", emulator.machine)?;
    writeln!(out, "{total} records, one row for every {}", plan.every)?;
    writeln!(out, "\n{HEADER}")?;
    let bar = if std::io::stderr().is_terminal() {
        let style = ProgressStyle::with_template("{bar:40} {pos}/{len} records, {eta} to go")?;
        ProgressBar::new(total as u64).with_style(style)
    } else {
        ProgressBar::hidden()
    };

    let started = Instant::now();
    let mut feed = Feed {
        plan,
        monitor: Monitor::new(&BEARING),
        next: 0,
        damaged: 0,
        due: false,
    };
    let mut under_way = VecDeque::with_capacity(WINDOW);
    let mut refused = 0;
    let mut limits = Limits::default();
    loop {
        while under_way.len() < WINDOW {
            let Some((frame, answer)) = feed.next()? else {
                break;
            };
            board.send(&frame)?;
            under_way.push_back(answer);
        }
        let Some(expected) = under_way.pop_front() else {
            break;
        };
        let line = board.line()?;
        match expected {
            Answer::Corrupt(text) if line == text => bar.suspend(|| writeln!(out, "{line}"))?,
            Answer::Corrupt(text) => {
                bail!(
                    "`{text}` was due, since a frame was damaged; {}",
                    explain(&line)
                )
            }
            Answer::Report(host) => {
                let index = bar.position() as usize;
                let report = check(&line, &host)?;
                refused += usize::from(report.kind != "Estimate");
                limits.note(&report);
                if index.is_multiple_of(plan.every) || report.get("status") != "Converged" {
                    bar.suspend(|| writeln!(out, "{}", report.row()))?;
                }
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();

    let seconds = started.elapsed().as_secs_f64();
    writeln!(
        out,
        "\n{total} records answered in {seconds:.1} s, {refused} of them with a refusal; \
         {} damaged frames named and skipped",
        feed.damaged
    )?;
    writeln!(
        out,
        "every answer equals the host's f32 result to the last bit"
    )?;
    writeln!(out, "{limits}")?;
    writeln!(out, "firmware: {}", firmware.memory)?;
    Ok(())
}

/// Reports that name limits.
#[derive(Default)]
struct Limits(BTreeMap<String, u32>);

impl Limits {
    fn note(&mut self, report: &Report) {
        for limit in report.limits() {
            *self.0.entry(limit.to_owned()).or_default() += 1;
        }
    }
}

impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("records past a limit: ")?;
        if self.0.is_empty() {
            f.write_str("none")?;
        }
        for (i, (limit, count)) in self.0.iter().enumerate() {
            let separator = if i == 0 { "" } else { ", " };
            write!(f, "{separator}{limit} {count}")?;
        }
        Ok(())
    }
}

/// What to make of a line that was not expected.
fn explain(line: &str) -> String {
    let hint = if line.starts_with("ready") {
        "; it has started again, after a fault that it could not tell of"
    } else if line.ends_with("starting again") {
        "; the place in the source is where to look"
    } else if line.starts_with("receiver lost") {
        "; its queue is too short for the frames under way"
    } else {
        ""
    };
    format!("the board says: {line}{hint}")
}

/// The board's report, if it is the one the host has.
fn check(line: &str, host: &Report) -> Result<Report> {
    let sequence = host.get("sequence");
    let Some(report) = Report::parse(line) else {
        bail!("instead of answering record {sequence}, {}", explain(line));
    };
    if report.get("sequence") != sequence {
        bail!(
            "record {sequence} was lost: the board answers record {}",
            report.get("sequence")
        );
    }
    if let Some(difference) = report.difference(host) {
        bail!(
            "record {sequence} at {} ms: {difference}. Host and target must compute alike: look for \
             fused or reordered floating point, and for functions that one of them takes from its C \
             library",
            host.get("time_ms")
        );
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_damage_is_one_corrupt_frame() {
        for sequence in 0..300 {
            let record = LoadRecord {
                sequence,
                time_ms: 10 * sequence,
                fx: 200.0 + sequence as f32,
                fy: 0.1 * sequence as f32,
                fz: 0.0,
                my: 0.0,
                mz: 0.0,
                speed_rpm: 12_000.0,
            };
            for way in 0..3 {
                let mut reader = FrameReader::<MESSAGE_LENGTH>::new();
                let results: Vec<_> = damage(&record, way)
                    .into_iter()
                    .filter_map(|byte| reader.push(byte))
                    .collect();
                assert!(matches!(results[..], [Err(_)]), "{way} {results:?}");
            }
        }
    }
}
