//! Bytes to frames. Damage is counted by its kind, and missing frames by the gaps in the sequence
//! numbers.

use serde::Serialize;
use spindle_monitor::framing::FrameError;
use spindle_monitor::telemetry::{Frame, FrameReader};
use std::fmt;

/// An undamaged frame, or a damaged piece.
// Events are handed on one at a time.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// An undamaged frame.
    Frame {
        /// The frame.
        frame: Frame,
        /// Gap between it and the frame before.
        gap: Gap,
    },
    /// A piece of the stream that is no frame.
    Damaged(FrameError),
}

/// Gap between two undamaged frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gap {
    /// Nothing; also before the first frame, since a receiver may join at any time.
    None,
    /// So many frames that did not arrive, or not undamaged.
    Lost(u32),
    /// The number went back, once: an old frame again, or the first of a sender that has started again.
    Behind,
    /// The numbers went back and go on from there: the sender has started again, with the frame before this one.
    Restart,
}

/// Counts since the start of the stream.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Bytes.
    pub bytes: u64,
    /// Undamaged frames.
    pub frames: u64,
    /// Frames missing between them, damaged ones included.
    pub lost: u64,
    /// Pieces that are no frame.
    pub damaged: u64,
    /// Of these, undamaged frames of another version or another protocol.
    pub foreign: u64,
    /// Frames whose number went back.
    pub behind: u64,
    /// New starts of the sender.
    pub restarts: u64,
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} frames in {} bytes, {} lost, {} damaged pieces",
            self.frames, self.bytes, self.lost, self.damaged
        )?;
        if self.foreign > 0 {
            write!(f, " ({} of another version or protocol)", self.foreign)?;
        }
        if self.behind > self.restarts {
            write!(f, ", {} old frames again", self.behind - self.restarts)?;
        }
        if self.restarts > 0 {
            write!(f, ", {} restarts of the sender", self.restarts)?;
        }
        Ok(())
    }
}

/// So many numbers at most lie between the first two frames of a new start.
const IN_STEP: u32 = 1000;

/// Takes a stream apart.
#[derive(Debug, Default)]
pub struct Decoder {
    reader: FrameReader,
    expected: Option<u32>,
    /// Next number of a sender whose first frame of a new start was the one that went back.
    after_first: Option<u32>,
    tally: Tally,
}

impl Decoder {
    /// A decoder at the start of a stream, or anywhere in it.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next byte.
    pub fn push(&mut self, byte: u8) -> Option<Event> {
        self.tally.bytes += 1;
        match self.reader.push(byte)? {
            Ok(frame) => {
                let gap = self.gap_before(frame.sequence);
                let next = Some(frame.sequence.wrapping_add(1));
                (self.expected, self.after_first) = match gap {
                    Gap::Behind => (self.expected, next),
                    _ => (next, None),
                };
                self.tally.frames += 1;
                match gap {
                    Gap::None => {}
                    Gap::Behind => self.tally.behind += 1,
                    Gap::Lost(count) => self.tally.lost += u64::from(count),
                    Gap::Restart => self.tally.restarts += 1,
                }
                Some(Event::Frame { frame, gap })
            }
            Err(error) => {
                self.tally.damaged += 1;
                self.tally.foreign += u64::from(error == FrameError::Content);
                Some(Event::Damaged(error))
            }
        }
    }

    fn gap_before(&self, sequence: u32) -> Gap {
        let Some(expected) = self.expected else {
            return Gap::None;
        };
        match sequence.wrapping_sub(expected) {
            0 => Gap::None,
            // Half of all numbers lie ahead; at a thousand frames a second they take 24 days.
            count @ 1..=0x7fff_ffff => Gap::Lost(count),
            _ if self
                .after_first
                .is_some_and(|next| sequence.wrapping_sub(next) < IN_STEP) =>
            {
                Gap::Restart
            }
            _ => Gap::Behind,
        }
    }

    /// Takes some bytes.
    pub fn push_all<'d>(&'d mut self, bytes: &'d [u8]) -> impl Iterator<Item = Event> + 'd {
        bytes.iter().filter_map(|byte| self.push(*byte))
    }

    /// Counts so far.
    pub const fn tally(&self) -> Tally {
        self.tally
    }
}
