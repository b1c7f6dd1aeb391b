//! Commands of a host to the monitor, over the port of the load records.
//!
//! A command is a frame of [`framing`]. [`encode`] is the host's side. [`PortReader`] is the board's: it tells commands
//! from load records, which are for [`FramedLoads`](super::loads::FramedLoads), by their length. Commands are shorter
//! than any record.
//!
//! # Requests
//!
//! An operator sends an [`Order`] in a [`Request`]. The board answers every request with an
//! [`Answer`], and carries an order out once:
//!
//! - **Nonce.** A request has the number that the board tells in its telemetry, once a second and with every answer. It
//!   changes with every order, and from start to start where there is a memory. So a request that was recorded, or was
//!   long under way, is out of date.
//! - **Repeats.** A host that hears no answer sends the very request again. Where only the answer was lost, the board
//!   gives it again.
//! - **State of the spindle.** A bearing is replaced at a standstill. An acknowledgement names the occurrence that
//!   somebody has seen, and is none of a later one.
//!
//! # Who is trusted
//!
//! Whoever can send to the port can send load records, and so make up what the monitor sees; the port belongs inside the
//! machine. By itself, the nonce keeps out accidents: repeats, recordings, a tool that talks to the wrong board. Where
//! others share the link, a key of 16 bytes that board and host have in common
//! ([`Monitor::with_key`](super::Monitor::with_key)) authenticates orders, and nothing else. The tag is SipHash-2-4
//! (Aumasson and Bernstein 2012) of the request. A guess of its 64 bits is right once in 1.8e19. Load records stay
//! unauthenticated.

use super::judgement::Alarm;
use crate::framing::{self, CHECKSUM_LENGTH, FrameError, FrameReader};
use crate::record::{self, LoadRecord};
use core::hash::Hasher;
use heapless::Vec;
use serde::{Deserialize, Serialize};
use siphasher::sip::SipHasher24;

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
        /// How often it had been raised ([`AlarmReport::raised`](super::telemetry::AlarmReport::raised)).
        raised: u32,
    },
    /// The bearing was replaced by a new one of the same design: the life used is forgotten.
    ReplaceBearing,
}

/// An order on its way to the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Request {
    /// Number given by the sender, for the answer to name.
    pub number: u16,
    /// Nonce that the board told last.
    pub nonce: u32,
    /// Order to be carried out.
    pub order: Order,
    /// [`Request::tag`], or zeros to a board without a key.
    pub tag: [u8; 8],
}

/// The key that board and host have in common.
pub type Key = [u8; 16];

/// A key from its 32 hexadecimal digits; none if they are not that.
pub const fn key(digits: &str) -> Option<Key> {
    let digits = digits.as_bytes();
    if digits.len() != 32 {
        return None;
    }
    let mut key = [0; 16];
    let mut i = 0;
    while i < 32 {
        let value = match digits[i] {
            digit @ b'0'..=b'9' => digit - b'0',
            digit @ b'a'..=b'f' => digit - b'a' + 10,
            digit @ b'A'..=b'F' => digit - b'A' + 10,
            _ => return None,
        };
        key[i / 2] = key[i / 2] << 4 | value;
        i += 1;
    }
    Some(key)
}

impl Request {
    /// A request, authenticated if there is a key.
    pub fn new(number: u16, nonce: u32, order: Order, key: Option<&Key>) -> Self {
        let mut request = Self {
            number,
            nonce,
            order,
            tag: [0; 8],
        };
        if let Some(key) = key {
            request.tag = request.tag(key);
        }
        request
    }

    /// SipHash-2-4 of the request as it is sent, without its tag; little-endian.
    pub fn tag(&self, key: &Key) -> [u8; 8] {
        let mut bytes = [0; CONTENT_LENGTH];
        let content = (self.number, self.nonce, self.order);
        // The lengths below make room for every request.
        let written: &[u8] =
            postcard::to_slice(&content, &mut bytes).map_or(&[], |written| written);
        let mut hasher = SipHasher24::new_with_key(key);
        hasher.write(written);
        hasher.finish().to_le_bytes()
    }

    /// Whether the sender has the key.
    fn is_authentic(&self, key: &Key) -> bool {
        // All eight bytes in any case, so that the time tells nothing.
        let mut differ = 0;
        for (a, b) in self.tag.iter().zip(self.tag(key)) {
            differ |= a ^ b;
        }
        differ == 0
    }
}

/// Outcome of an order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnswerCode {
    /// Carried out.
    Done,
    /// The request has another nonce than the board's.
    OutOfDate,
    /// The request was made with another key, or with none.
    NotAuthentic,
    /// The shaft turns, or it is not known whether it does.
    NotAtStandstill,
    /// The alarm does not stand, or was raised again since.
    NoSuchOccurrence,
}

impl AnswerCode {
    /// All of them, in the order of the format.
    pub const ALL: [Self; 5] = [
        Self::Done,
        Self::OutOfDate,
        Self::NotAuthentic,
        Self::NotAtStandstill,
        Self::NoSuchOccurrence,
    ];

    /// Short name in lower case, as tables print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::OutOfDate => "out-of-date",
            Self::NotAuthentic => "not-authentic",
            Self::NotAtStandstill => "not-at-standstill",
            Self::NoSuchOccurrence => "no-such-occurrence",
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
    /// The board's nonce from now on.
    pub nonce: u32,
}

/// The board's side: carries each order out once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Desk {
    key: Option<Key>,
    nonce: u32,
    last: Option<(Request, AnswerCode)>,
}

impl Desk {
    pub(super) const NEW: Self = Self {
        key: None,
        nonce: 0,
        last: None,
    };

    /// Desk with another key.
    pub(super) const fn with_key(self, key: Option<Key>) -> Self {
        Self { key, ..self }
    }

    /// Desk after so many starts. No start reaches the nonces of the next: that takes 65,536 orders.
    pub(super) const fn after_starts(self, boots: u32) -> Self {
        let nonce = boots << 16;
        Self { nonce, ..self }
    }

    pub(super) const fn nonce(&self) -> u32 {
        self.nonce
    }

    /// The answer to a request; has the order carried out if the request is authentic, of now, and none that was
    /// answered.
    pub(super) fn answer(
        &mut self,
        request: &Request,
        carry_out: impl FnOnce(Order) -> AnswerCode,
    ) -> Answer {
        let authentic = self
            .key
            .as_ref()
            .is_none_or(|key| request.is_authentic(key));
        let outcome = match &self.last {
            _ if !authentic => AnswerCode::NotAuthentic,
            Some((last, outcome)) if last == request => *outcome,
            _ if request.nonce != self.nonce => AnswerCode::OutOfDate,
            _ => {
                let outcome = carry_out(request.order);
                self.last = Some((*request, outcome));
                self.nonce = self.nonce.wrapping_add(1);
                outcome
            }
        };
        Answer {
            number: request.number,
            order: request.order,
            outcome,
            nonce: self.nonce,
        }
    }
}

/// Longest command without its checksum: two variants, number and nonce, an alarm and its occurrence, and the tag.
const CONTENT_LENGTH: usize = 2 + 3 + 5 + 1 + 5 + 8;

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
    /// Why a frame was skipped; it counts as a load record ([`FramedLoads::take`](super::loads::FramedLoads::take)).
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
            let tag = [u8::MAX; 8];
            Command::Ask(Request {
                number: u16::MAX,
                nonce: u32::MAX,
                order,
                tag,
            })
        };
        let mut all: Bytes<_> = Alarm::ALL
            .map(|alarm| {
                ask(Order::Acknowledge {
                    alarm,
                    raised: u32::MAX,
                })
            })
            .into();
        all.push(ask(Order::ReplaceBearing));
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

    const SLIP: Order = Order::Acknowledge {
        alarm: Alarm::Slip,
        raised: 1,
    };

    /// An order that is carried out leaves a mark in a count.
    fn answer(desk: &mut Desk, count: &mut u32, request: Request) -> (AnswerCode, u32) {
        let answer = desk.answer(&request, |_| {
            *count += 1;
            AnswerCode::Done
        });
        assert_eq!(
            (answer.number, answer.order),
            (request.number, request.order)
        );
        (answer.outcome, answer.nonce)
    }

    #[test]
    fn an_order_is_carried_out_once_however_often_its_request_comes() {
        let mut desk = Desk {
            nonce: u32::MAX,
            ..Desk::NEW
        };
        let mut count = 0;
        let first = Request::new(1, u32::MAX, Order::ReplaceBearing, None);
        for _ in 0..3 {
            assert_eq!(answer(&mut desk, &mut count, first), (AnswerCode::Done, 0));
        }
        assert_eq!(count, 1);
        let second = Request::new(2, 0, SLIP, None);
        assert_eq!(answer(&mut desk, &mut count, second), (AnswerCode::Done, 1));
        // Recorded, and played again.
        assert_eq!(
            answer(&mut desk, &mut count, first),
            (AnswerCode::OutOfDate, 1)
        );
        assert_eq!(count, 2);
    }

    #[test]
    fn an_order_of_another_start_is_out_of_date() {
        let mut count = 0;
        let first = Request::new(
            1,
            Desk::NEW.after_starts(1).nonce(),
            Order::ReplaceBearing,
            None,
        );
        for boots in [2, 3, u32::MAX] {
            let mut desk = Desk::NEW.after_starts(boots);
            assert_eq!(
                answer(&mut desk, &mut count, first).0,
                AnswerCode::OutOfDate
            );
        }
        assert_eq!(count, 0);
    }

    #[test]
    fn without_the_key_no_order_is_carried_out() {
        let key: Key = core::array::from_fn(|i| i as u8);
        let other = [7; 16];
        let mut desk = Desk {
            nonce: 5,
            ..Desk::NEW.with_key(Some(key))
        };
        let mut count = 0;
        for stranger in [None, Some(&other)] {
            let request = Request::new(1, 5, Order::ReplaceBearing, stranger);
            let refused = (AnswerCode::NotAuthentic, 5);
            assert_eq!(answer(&mut desk, &mut count, request), refused);
        }
        let good = Request::new(1, 5, Order::ReplaceBearing, Some(&key));
        for bit in 0..64 {
            let mut bent = good;
            bent.tag[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(
                answer(&mut desk, &mut count, bent).0,
                AnswerCode::NotAuthentic
            );
        }
        // The tag belongs to this order alone.
        let other = Request {
            order: SLIP,
            ..good
        };
        assert_eq!(
            answer(&mut desk, &mut count, other).0,
            AnswerCode::NotAuthentic
        );
        assert_eq!(count, 0);
        assert_eq!(answer(&mut desk, &mut count, good), (AnswerCode::Done, 6));
    }
}
