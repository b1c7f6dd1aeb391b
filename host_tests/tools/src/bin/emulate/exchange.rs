//! The run itself: what the board sends, held against what the host's build of the same monitor sends.

use crate::emulator::{self, Board, Log};
use crate::firmware::Firmware;
use crate::plan::Plan;
use crate::rows;
use crate::toolchain::Emulator;
use anyhow::{Result, bail};
use host_tests::telemetry::decoder::{Decoder, Event};
use spindle_bearing::monitor::telemetry::{Frame, Payload};
use std::io::{self, Write};
use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};

/// How to run.
pub struct Manner {
    /// Print every so many estimates, 0 for nothing at all.
    pub every: usize,
    /// Longest silence of the board.
    pub patience: Duration,
    /// Where else the board's bytes go.
    pub tee: Option<SyncSender<io::Result<Vec<u8>>>>,
}

/// What came from the board.
pub struct Answer {
    /// Frames of the telemetry.
    pub frames: Vec<Frame>,
    /// Lines of the log.
    pub log: Vec<String>,
    /// How long it took.
    pub took: Duration,
}

fn frames(bytes: &[u8]) -> Vec<Frame> {
    let mut decoder = Decoder::new();
    let events = decoder.push_all(bytes);
    events
        .filter_map(|event| match event {
            Event::Frame { frame, .. } => Some(frame),
            Event::Damaged(_) => None,
        })
        .collect()
}

/// Runs the plan, prints estimates, and fails at the first byte that is not the host's. `None` if who was to
/// have the bytes, too, has gone.
pub fn run(
    plan: &Plan,
    manner: &Manner,
    firmware: &Firmware,
    emulator: &Emulator,
) -> Result<Option<Answer>> {
    let table = emulator::table(firmware)?;
    let mut log = Log::new(&table);
    let started = Instant::now();
    let mut board = Board::start(emulator, firmware, manner.patience)?;
    // A port that is not open yet takes no bytes.
    board.wait_for_log(&mut log)?;
    board.send(plan.input.clone());
    let mut out = io::stdout();
    let quiet = manner.every == 0;
    if !quiet {
        writeln!(out, "{} {}", emulator.machine, log.lines[0])?;
        writeln!(out, "\n{}", rows::HEADER)?;
    }
    let mut received: Vec<u8> = Vec::with_capacity(plan.expected.len());
    let mut decoder = Decoder::new();
    let mut estimates = 0;
    let mut shown = 1;
    while received.len() < plan.expected.len() {
        let bytes = board.bytes()?;
        board.read_log(&mut log)?;
        let from = received.len();
        received.extend(&bytes);
        let expected = plan.expected.get(from..received.len());
        if expected != Some(&bytes[..]) {
            board.read_log(&mut log)?;
            bail!("{}", difference(&plan.expected, &received, &log.lines));
        }
        if let Some(tee) = &manner.tee
            && tee.send(Ok(bytes.clone())).is_err()
        {
            // Nobody looks any more.
            return Ok(None);
        }
        if quiet {
            continue;
        }
        for line in &log.lines[shown..] {
            writeln!(out, "log: {line}")?;
        }
        shown = log.lines.len();
        for event in decoder.push_all(&bytes) {
            if let Event::Frame { frame, .. } = event
                && let Payload::Estimate(report) = &frame.payload
            {
                if estimates % manner.every == 0 {
                    writeln!(out, "{}", rows::row(frame.time_us, report))?;
                }
                estimates += 1;
            }
        }
    }
    let took = started.elapsed();
    // What is still on its way to the log.
    std::thread::sleep(Duration::from_millis(100));
    board.read_log(&mut log)?;
    let unwanted = |line: &&String| {
        line.ends_with("starting again")
            || line.starts_with("receiver lost")
            || line.starts_with("no equilibrium")
    };
    if let Some(line) = log.lines.iter().find(unwanted) {
        bail!("the board says: {line}");
    }
    Ok(Some(Answer {
        frames: frames(&received),
        log: log.lines,
        took,
    }))
}

/// The first frame in which the board and the host differ.
fn difference(expected: &[u8], received: &[u8], log: &[String]) -> String {
    let (host, board) = (frames(expected), frames(received));
    let said = log.last().map_or("nothing", |line| line);
    let Some((host, board)) = host.iter().zip(&board).find(|(a, b)| a != b) else {
        return format!(
            "the board's telemetry is not the host's, though the frames agree so far: bytes were \
             damaged or added; it said last: {said}"
        );
    };
    let (host_text, board_text) = (format!("{host:?}"), format!("{board:?}"));
    let differ = host_text
        .split(", ")
        .zip(board_text.split(", "))
        .find(|(a, b)| a != b);
    let (a, b) = differ.unwrap_or(("?", "?"));
    format!(
        "frame {} at {:.3} s: the board has `{b}`, the host `{a}`. Host and target must compute alike: \
         look for fused or reordered floating point, and for functions that one of them takes from its \
         C library. The board said last: {said}",
        host.sequence,
        host.time_us as f64 * 1e-6
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use spindle_bearing::framing;
    use spindle_bearing::monitor::telemetry::{FRAME_LENGTH, HealthReport, VERSION};

    fn stream(ticks: [u64; 3]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (sequence, ticks) in (0..).zip(ticks) {
            let frame = Frame {
                version: VERSION,
                sequence,
                time_us: 1_000_000 * u64::from(sequence),
                payload: Payload::Health(HealthReport {
                    ticks,
                    ..HealthReport::default()
                }),
            };
            bytes.extend(framing::encode::<_, FRAME_LENGTH>(&frame).unwrap());
        }
        bytes
    }

    #[test]
    fn a_difference_is_named_by_frame_and_field() {
        let text = difference(&stream([1, 2, 3]), &stream([1, 5, 3]), &[]);
        assert!(text.starts_with("frame 1 at 1.000 s: "), "{text}");
        assert!(
            text.contains("ticks: 5") && text.contains("ticks: 2"),
            "{text}"
        );
    }
}
