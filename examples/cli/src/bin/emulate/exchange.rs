//! The run itself: the board's bytes, held against the bytes of the host's build of the same monitor.

use crate::plan::Plan;
use crate::rows;
use anyhow::{Result, bail};
use cli::emulator::{AGAIN, Board, Firmware, Log, MACHINE};
use cli::telemetry::decoder::{Decoder, Event};
use spindle_monitor::telemetry::{Frame, Payload};
use std::io::{self, Write};
use std::sync::mpsc::SyncSender;
use std::time::Duration;

/// Where a copy of the board's bytes goes.
pub type Tee = SyncSender<io::Result<Vec<u8>>>;

/// Frames and log that came from the board.
pub struct Answer {
    /// Frames of the telemetry.
    pub frames: Vec<Frame>,
    /// Lines of the log.
    pub log: Vec<String>,
    /// Bytes of the board's stack that were never used.
    pub unused_stack: u64,
}

/// The newest figure of the stack in a log.
///
/// # Errors
///
/// All of the stack was used, or the log has no figure.
fn unused_stack(log: &[String]) -> Result<u64> {
    let figure = |line: &String| {
        let (bytes, _) = line.split_once(" bytes of stack not used so far")?;
        bytes.parse().ok()
    };
    match log.iter().rev().find_map(figure) {
        Some(0) => bail!("the board has used up its stack: what lies beyond it may be damaged"),
        Some(bytes) => Ok(bytes),
        None => bail!("the board does not say how much of its stack is left"),
    }
}

/// Fails if the board has said that something is wrong.
fn refuse(log: &[String]) -> Result<()> {
    let unwanted = |line: &&String| {
        line.ends_with(AGAIN)
            || line.starts_with("receiver lost")
            || line.starts_with("no equilibrium")
    };
    match log.iter().find(unwanted) {
        Some(line) => bail!("the board says: {line}"),
        None => Ok(()),
    }
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

/// Runs the plan, prints some hundred estimates, and fails at the first byte that is not the host's.
///
/// With a `tee`, it prints nothing. It returns `None` once nobody reads the copy.
pub fn run(plan: &Plan, firmware: &Firmware, tee: Option<Tee>) -> Result<Option<Answer>> {
    let table = firmware.messages()?;
    let mut log = Log::new(&table);
    let mut board = Board::start(firmware)?;
    // A port that is not open yet takes no bytes.
    board.wait_for_line(&mut log, "")?;
    board.send(&plan.input);
    let mut out: Box<dyn Write> = match tee {
        Some(_) => Box::new(io::sink()),
        None => Box::new(io::stdout()),
    };
    writeln!(out, "{MACHINE} {}\n\n{}", log.lines[0], rows::HEADER)?;
    // An estimate is sent every twenty ticks.
    let every = plan.ending.health.ticks.div_ceil(20 * 100) as usize;
    let mut received: Vec<u8> = Vec::with_capacity(plan.expected.len());
    let mut decoder = Decoder::new();
    let (mut estimates, mut shown) = (0, 1);
    while received.len() < plan.expected.len() {
        let bytes = board.bytes()?;
        board.read_log(&mut log)?;
        let from = received.len();
        received.extend(&bytes);
        refuse(&log.lines)?;
        if plan.expected.get(from..received.len()) != Some(&bytes[..]) {
            bail!("{}", difference(&plan.expected, &received, &log.lines));
        }
        for line in &log.lines[shown..] {
            writeln!(out, "log: {line}")?;
        }
        shown = log.lines.len();
        for event in decoder.push_all(&bytes) {
            if let Event::Frame { frame, .. } = event
                && let Payload::Estimate(report) = &frame.payload
            {
                if estimates % every == 0 {
                    writeln!(out, "{}", rows::row(frame.time_us, report))?;
                }
                estimates += 1;
            }
        }
        if tee.as_ref().is_some_and(|tee| tee.send(Ok(bytes)).is_err()) {
            return Ok(None);
        }
    }
    // The last lines are still on their way to the log.
    std::thread::sleep(Duration::from_millis(100));
    board.read_log(&mut log)?;
    refuse(&log.lines)?;
    Ok(Some(Answer {
        frames: frames(&received),
        unused_stack: unused_stack(&log.lines)?,
        log: log.lines,
    }))
}

/// Bytes of a stack that the firmware's start runs over, and that its first lines of log do not.
const SHORT: u32 = 4096;

/// Fails unless a board whose stack is too short says so, and says it again at its next start.
pub fn overrun(firmware: &Firmware) -> Result<()> {
    let short = firmware.with_stack(SHORT)?;
    let table = short.messages()?;
    let mut log = Log::new(&table);
    let mut board = Board::start(&short)?;
    board.wait_for_line(&mut log, "the stack is used up")?;
    board.wait_for_line(&mut log, "the stack was used up before this start")
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
    use spindle_monitor::framing;
    use spindle_monitor::telemetry::{FRAME_LENGTH, HealthReport, VERSION};

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
    fn a_stack_that_was_used_up_is_an_error_and_no_figure() {
        let log = |lines: &[&str]| {
            unused_stack(&lines.iter().map(|line| (*line).into()).collect::<Vec<_>>())
        };
        let said = [
            "ready",
            "8000 bytes of stack not used so far",
            "5120 bytes of stack not used so far",
        ];
        assert_eq!(log(&said).unwrap(), 5120);
        let used_up = log(&[
            "8000 bytes of stack not used so far",
            "0 bytes of stack not used so far",
        ]);
        assert!(
            used_up
                .unwrap_err()
                .to_string()
                .contains("used up its stack")
        );
        assert!(log(&["ready"]).is_err());
        let again = ["ready".to_owned(), format!("the stack is used up, {AGAIN}")];
        assert!(
            refuse(&again)
                .unwrap_err()
                .to_string()
                .contains("the stack is used up")
        );
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
