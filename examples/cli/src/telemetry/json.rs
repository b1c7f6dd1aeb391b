//! Frames as lines of JSON, one object a line, and these lines as the bytes of a stream again.
//!
//! A line has the fields of [`Frame`] under their names. Numbers keep every bit; one that is not finite is `null`. A
//! damaged piece of the stream is a line of its own, `{"damaged": "frame checksum wrong"}`.

use super::decoder::{Event, Gap};
use anyhow::Result;
use serde::Serialize;
use spindle_monitor::telemetry::{Frame, Payload, encode};
use spindle_monitor::{Alarm, Mark};
use std::io::Write;

/// A line.
#[derive(Serialize)]
#[serde(untagged)]
enum Line<'a> {
    Frame {
        #[serde(flatten)]
        frame: &'a Frame,
        /// Gap before the frame, if there is one.
        #[serde(skip_serializing_if = "Option::is_none")]
        gap: Option<Gap>,
        /// Names of the bits that are set in `marks`, `limits` and `alarms`.
        #[serde(skip_serializing_if = "Vec::is_empty")]
        names: Vec<&'static str>,
    },
    Damaged {
        damaged: &'static str,
    },
}

/// Writes the line of an event.
///
/// # Errors
///
/// The line cannot be written.
pub fn write(out: &mut impl Write, event: &Event) -> Result<()> {
    let line = match event {
        Event::Damaged(error) => Line::Damaged {
            damaged: error.name(),
        },
        Event::Frame { frame, gap } => Line::Frame {
            frame,
            gap: (*gap != Gap::None).then_some(*gap),
            names: names(&frame.payload),
        },
    };
    serde_json::to_writer(&mut *out, &line)?;
    Ok(writeln!(out)?)
}

fn names(payload: &Payload) -> Vec<&'static str> {
    match payload {
        Payload::Estimate(report) => {
            let marks = report.marks.iter().map(Mark::name);
            marks.chain(report.passed()).collect()
        }
        Payload::Health(report) => report.marks.iter().map(Mark::name).collect(),
        Payload::Hello(report) => report.start.alarms.iter().map(Alarm::name).collect(),
        _ => Vec::new(),
    }
}

/// Bytes that are no frame.
const DAMAGED: [u8; 2] = [2, 0];

/// The bytes of a line's frame. Any other line is a damaged piece, as is a frame with a `null` for a number.
pub fn bytes(line: &str) -> Vec<u8> {
    match serde_json::from_str(line) {
        Ok(frame) => encode(&frame).to_vec(),
        Err(_) => DAMAGED.to_vec(),
    }
}
