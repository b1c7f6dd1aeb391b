//! What a host says to the monitor besides loads: one command, one frame of
//! [`framing`], over the port that load records come in by.
//!
//! [`encode`] is the host's side. [`Sorter`] is the board's: it takes commands out of the stream and hands
//! on the rest, which is for [`FramedLoads`](super::loads::FramedLoads). Commands are told from load records
//! by their length: they are shorter than any record, so that none is held back for long.

use super::judgement::Alarm;
use crate::framing::{self, CHECKSUM_LENGTH, DELIMITER, FrameReader};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// What a host says besides loads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Command {
    /// Somebody has seen this alarm: it may clear.
    Acknowledge(Alarm),
    /// From now on (or no longer), learn the baseline of the stiffness.
    Learn(bool),
    /// In lock-step only, as `cargo emulate` has it: a tick, in which the telemetry's link takes so many
    /// bytes.
    Tick(u16),
    /// The bearing was replaced by a new one of the same design: baseline and life used are forgotten.
    ReplaceBearing,
}

/// Longest message of a command, checksum included: variant, and a varint of 16 bits.
const MESSAGE_LENGTH: usize = 1 + 3 + CHECKSUM_LENGTH;

/// Length of its frame, delimiter included.
pub const COMMAND_LENGTH: usize = framing::frame_length(MESSAGE_LENGTH);

/// The frame of a command.
pub fn encode(command: Command) -> Vec<u8, COMMAND_LENGTH> {
    // The lengths above make room for every command, as the tests see.
    framing::encode(&command).unwrap_or_default()
}

/// Tells commands from load records.
#[derive(Debug)]
pub struct Sorter {
    reader: FrameReader<Command, MESSAGE_LENGTH>,
    /// The frame so far, as long as it may be a command.
    held: Vec<u8, COMMAND_LENGTH>,
    /// It is too long for one.
    record: bool,
}

impl Default for Sorter {
    fn default() -> Self {
        Self::new()
    }
}

impl Sorter {
    /// At the start of a frame.
    pub const fn new() -> Self {
        Self {
            reader: FrameReader::new(),
            held: Vec::new(),
            record: false,
        }
    }

    /// Takes a byte; returns a command that it completes, and hands on the bytes of what is none, damaged
    /// frames included.
    pub fn push(&mut self, byte: u8, mut hand_on: impl FnMut(u8)) -> Option<Command> {
        // The reader has given up on a record; its delimiter is the next that matters to it.
        if self.record && byte != DELIMITER {
            hand_on(byte);
            return None;
        }
        let command = self.reader.push(byte).and_then(Result::ok);
        if command.is_none() {
            let kept = !self.record && self.held.push(byte).is_ok();
            if !kept || byte == DELIMITER {
                self.held.iter().copied().for_each(&mut hand_on);
                self.held.clear();
            }
            if !kept {
                hand_on(byte);
            }
            self.record = byte != DELIMITER && !kept;
        } else {
            self.held.clear();
            self.record = false;
        }
        command
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{self, LoadRecord};
    use std::vec::Vec as Bytes;

    fn commands() -> Bytes<Command> {
        let mut all: Bytes<_> = Alarm::ALL.map(Command::Acknowledge).into();
        all.extend([Command::Learn(true), Command::Learn(false)]);
        all.push(Command::ReplaceBearing);
        all.extend([0, 1, 127, 128, 46, u16::MAX].map(Command::Tick));
        all
    }

    fn record(sequence: u32) -> LoadRecord {
        LoadRecord {
            sequence,
            time_ms: sequence,
            fx: 250.0,
            fy: 0.0,
            fz: -0.0,
            my: 1.5e-3,
            mz: 0.0,
            speed_rpm: 0.0,
        }
    }

    #[test]
    fn every_command_has_a_frame_and_the_shortest_record_a_longer_one() {
        let longest = commands().into_iter().map(|c| encode(c).len()).max();
        assert_eq!(longest, Some(COMMAND_LENGTH));
        assert!(commands().into_iter().all(|c| !encode(c).is_empty()));
        assert!(record::encode(&record(0)).len() > COMMAND_LENGTH);
    }

    #[test]
    fn commands_and_records_come_apart_in_any_order_and_no_byte_is_lost() {
        let mut sorter = Sorter::new();
        let (mut found, mut rest) = (Bytes::new(), Bytes::new());
        let (mut sent, mut records) = (Bytes::new(), Bytes::new());
        let mut stream = Bytes::new();
        for (sequence, command) in (0..).zip(commands()) {
            let frame = record::encode(&record(sequence));
            for _ in 0..sequence % 3 {
                stream.extend_from_slice(&frame);
                records.extend_from_slice(&frame);
            }
            // A damaged frame is the load source's to count.
            let mut damaged = frame.to_vec();
            damaged.truncate(4);
            damaged.push(DELIMITER);
            stream.extend_from_slice(&damaged);
            records.extend_from_slice(&damaged);
            stream.extend_from_slice(&encode(command));
            sent.push(command);
        }
        for byte in stream {
            found.extend(sorter.push(byte, |byte| rest.push(byte)));
        }
        assert_eq!(found, sent);
        assert_eq!(rest, records);
    }
}
