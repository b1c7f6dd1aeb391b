//! Commands of a host to the monitor, over the port of the load records.
//!
//! A command is a frame of [`framing`]. [`encode`] is the host's side. [`PortReader`] is the board's: it tells commands
//! from load records, which are for [`FramedLoads`](crate::loads::FramedLoads), by their length. Commands are shorter
//! than any record.
//!
//! # Requests
//!
//! An operator sends an [`Order`] in a [`Request`]. The board answers every request with an
//! [`Answer`]:
//!
//! - **Repeats.** A host that hears no answer sends the very request again. An order that is carried out twice does what it
//!   does once.
//! - **State of the spindle.** An acknowledgement says in which start, and how often, the alarm had been raised when somebody
//!   saw it. If it was raised again since, or the board has started again, the acknowledgement is refused. A board without a
//!   memory does not tell its starts apart. A bearing is replaced at a standstill, while an input of the board says that
//!   somebody is at the machine. While it does, somebody may say that the shaft stands, too, or that the probes' reference is
//!   that of now.
//! - **Share.** One order is carried out in [`ORDER_EVERY`] ticks, and only if the answer before it is gone: orders cannot
//!   starve the telemetry. Requests for which there is no room are as ones that were not heard.
//!
//! # Who is trusted
//!
//! Whoever can send to the port can send load records, and so make up what the monitor sees; the port belongs inside the
//! machine. So orders are not authenticated either. An acknowledgement ends no condition, and a life is not forgotten from
//! afar.

use crate::alarms::Alarm;
use crate::framing::{self, CHECKSUM_LENGTH, FrameError, FrameReader};
use crate::record::{self, LoadRecord};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Ticks in which one order is carried out. An answer has some 20 bytes, a twentieth of what a line of 921,600 baud takes
/// meanwhile.
pub const ORDER_EVERY: u64 = 4;

/// Most probes of a spindle.
pub const MOST_PROBES: usize = 4;

/// Message of a host besides loads.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Command {
    /// In lock-step only, as `cargo emulate` has it: a tick, in which the telemetry's link takes so many
    /// bytes.
    Tick(u16),
    /// An operator wants something.
    Ask(Request),
    /// Temperatures of the inner and of the outer side, degrees Celsius; no number from a sensor that fails.
    Temperatures([f32; 2]),
    /// Displacements that the probes measured with the loads of the record that follows, um; no number from a probe that
    /// gives none, and in places beyond the last probe.
    Probes([f32; MOST_PROBES]),
}

/// Order of an operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Order {
    /// Somebody has seen this occurrence of an alarm: it may clear.
    Acknowledge {
        /// The alarm.
        alarm: Alarm,
        /// Number of the start in which it was seen ([`AlarmReport::start`](crate::telemetry::AlarmReport::start)).
        start: u32,
        /// How often it had been raised ([`AlarmReport::raised`](crate::telemetry::AlarmReport::raised)).
        raised: u32,
    },
    /// The bearing was replaced by a new one of the same design: forget the life used, and the estimates of the probes.
    ReplaceBearing,
    /// The shaft stands still, though its speed was lost.
    ShaftStands,
    /// The spindle is as it should be: preload and gains of now are those of commissioning.
    Commission,
}

/// An order on its way to the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Request {
    /// Number given by the sender, for the answer to name.
    pub number: u16,
    /// Order to be carried out.
    pub order: Order,
}

/// Outcome of an order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnswerCode {
    /// Carried out.
    Done,
    /// The shaft turns, or it is not known whether it does.
    NotAtStandstill,
    /// The board's input for service was off.
    NotInService,
    /// The alarm was raised again since, or not so often yet, or in another start.
    NoSuchOccurrence,
    /// The probes are still learning, or there are none.
    Learning,
}

impl AnswerCode {
    /// All of them, in the order of the format.
    pub const ALL: [Self; 5] = [
        Self::Done,
        Self::NotAtStandstill,
        Self::NotInService,
        Self::NoSuchOccurrence,
        Self::Learning,
    ];

    /// Short name in lower case, as tables print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::NotAtStandstill => "not-at-standstill",
            Self::NotInService => "not-in-service",
            Self::NoSuchOccurrence => "no-such-occurrence",
            Self::Learning => "learning",
        }
    }
}

/// Answer of the board to a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answer {
    /// Number of the request.
    pub number: u16,
    /// Order of the request.
    pub order: Order,
    /// Outcome of the order.
    pub outcome: AnswerCode,
}

/// Longest command without its checksum: its variant, and the displacements.
const CONTENT_LENGTH: usize = 1 + MOST_PROBES * size_of::<f32>();

/// Length of its frame, delimiter included.
pub const COMMAND_LENGTH: usize = framing::frame_length(CONTENT_LENGTH + CHECKSUM_LENGTH);

/// The frame of a command.
pub fn encode(command: Command) -> Vec<u8, COMMAND_LENGTH> {
    // The lengths above make room for every command, as the tests see.
    framing::encode(&command).unwrap_or_default()
}

/// A frame that came over the port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Received {
    /// A command.
    Command(Command),
    /// Measured loads.
    Record(LoadRecord),
}

/// Takes the port's bytes apart, one by one, into commands and load records.
#[derive(Debug, Default)]
pub struct PortReader {
    reader: FrameReader<Received, { record::MESSAGE_LENGTH }>,
}

impl PortReader {
    /// At the start of a frame.
    pub const fn new() -> Self {
        Self {
            reader: FrameReader::new(),
        }
    }

    /// Takes the next byte; at the end of a frame returns its content.
    ///
    /// # Errors
    ///
    /// Why a frame was skipped; it counts as a load record ([`FramedLoads::take`](crate::loads::FramedLoads::take)).
    #[inline(always)]
    pub fn push(&mut self, byte: u8) -> Option<Result<Received, FrameError>> {
        self.reader.push_with(byte, |content| {
            if content.len() <= CONTENT_LENGTH {
                framing::decode(content).map(Received::Command)
            } else {
                framing::decode(content).map(Received::Record)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::framing::DELIMITER;
    use std::vec::Vec as Bytes;

    fn commands() -> Bytes<Command> {
        let ask = |order| {
            Command::Ask(Request {
                number: u16::MAX,
                order,
            })
        };
        let mut all: Bytes<_> = Alarm::ALL
            .map(|alarm| {
                ask(Order::Acknowledge {
                    alarm,
                    start: u32::MAX,
                    raised: u32::MAX,
                })
            })
            .into();
        all.push(ask(Order::ReplaceBearing));
        all.push(ask(Order::ShaftStands));
        all.push(ask(Order::Commission));
        all.push(Command::Probes([0.0, -0.0, f32::MAX, f32::INFINITY]));
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
    fn commands_and_records_come_apart_in_any_order_and_no_frame_is_lost() {
        let mut reader = PortReader::new();
        let (mut stream, mut sent) = (Bytes::new(), Bytes::new());
        for (sequence, command) in (0..).zip(commands()) {
            let frame = record::encode(&record(sequence));
            for _ in 0..sequence % 3 {
                stream.extend_from_slice(&frame);
                sent.push(Ok(Received::Record(record(sequence))));
            }
            stream.extend_from_slice(&frame[..4]);
            stream.push(DELIMITER);
            sent.push(Err(FrameError::Truncated));
            stream.extend_from_slice(&encode(command));
            sent.push(Ok(Received::Command(command)));
        }
        let read: Bytes<_> = stream.iter().filter_map(|b| reader.push(*b)).collect();
        assert_eq!(read, sent);
    }
}
