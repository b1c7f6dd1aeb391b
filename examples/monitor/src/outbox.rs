//! The queue in which telemetry waits for a link.
//!
//! The link takes bytes out of it whenever it can; alarms go first. Sequence numbers are given when a frame goes out: a gap in
//! them is a frame that the link lost. Frames dropped for want of room are counted by themselves
//! ([`HealthReport::frames_dropped`]).
//!
//! **No alarm is lost.** Changes queue in order. Should the link stay shut until even that queue is
//! full, alarms that no longer fit keep their latest state, which goes out when there is room. It has
//! the number of times that the alarm was raised and cleared so far: a receiver sees what happened
//! meanwhile. An alarm that stands is sent again at an interval, which makes up for frames that the
//! link itself loses.

use crate::alarms::Alarm;
use crate::command::Answer;
use crate::framing;
use crate::judgement::AlarmChange;
use crate::telemetry::{AlarmReport, FRAME_LENGTH, HealthReport, HelloReport, Payload, VERSION};
use heapless::{Deque, Vec};
use serde::Serialize;

/// Alarm reports that wait in order.
const ALARM_QUEUE: usize = 3 * Alarm::COUNT;

/// A payload and when it was.
#[derive(Debug, Clone, PartialEq)]
struct Waiting {
    time_us: u64,
    payload: Payload,
}

/// An alarm's latest state, which waits behind the queue.
#[derive(Debug, Clone, Copy)]
struct HeldBack {
    time_us: u64,
    report: AlarmReport,
    /// A change found the queue full: what comes later may not overtake it.
    change: bool,
}

/// Frames that wait for the link. `FRAMES` estimates and balls fit; two are few, twenty are a second
/// or so.
#[derive(Debug)]
pub struct Outbox<const FRAMES: usize> {
    alarms: Deque<(u64, AlarmReport), ALARM_QUEUE>,
    answer: Option<(u64, Answer)>,
    held_back: [Option<HeldBack>; Alarm::COUNT],
    health: Option<(u64, HealthReport)>,
    hello: Option<(u64, HelloReport)>,
    frames: Deque<Waiting, FRAMES>,
    sequence: u32,
    dropped: u64,
    /// The frame that is on its way, and how much of it is gone.
    current: Vec<u8, FRAME_LENGTH>,
    gone: usize,
}

impl<const FRAMES: usize> Default for Outbox<FRAMES> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const FRAMES: usize> Outbox<FRAMES> {
    /// An empty queue.
    pub const fn new() -> Self {
        Self {
            alarms: Deque::new(),
            answer: None,
            held_back: [None; Alarm::COUNT],
            health: None,
            hello: None,
            frames: Deque::new(),
            sequence: 0,
            dropped: 0,
            current: Vec::new(),
            gone: 0,
        }
    }

    /// Numbers frames from this one on.
    pub const fn number_from(&mut self, sequence: u32) {
        self.sequence = sequence;
    }

    /// Estimates and balls that were dropped so far.
    pub const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Whether there is nothing to send.
    pub fn is_empty(&self) -> bool {
        self.gone >= self.current.len()
            && self.alarms.is_empty()
            && self.answer.is_none()
            && self.held_back.iter().all(Option::is_none)
            && self.health.is_none()
            && self.hello.is_none()
            && self.frames.is_empty()
    }

    /// Whether an answer waits, which another one would replace.
    pub const fn has_answer(&self) -> bool {
        self.answer.is_some()
    }

    /// Queues a payload of this time. Payloads that give way for want of room are counted.
    pub fn post(&mut self, time_us: u64, payload: Payload) {
        match payload {
            Payload::Alarm(report) => self.post_alarm(time_us, report),
            Payload::Health(report) => self.health = Some((time_us, report)),
            Payload::Answer(answer) => self.answer = Some((time_us, answer)),
            Payload::Hello(report) => self.hello = Some((time_us, report)),
            payload @ (Payload::Estimate(_)
            | Payload::Rows(_)
            | Payload::Balls(_)
            | Payload::Probes(_)) => {
                // The newest one is worth most.
                if self.frames.is_full() && self.frames.pop_front().is_some() {
                    self.dropped = self.dropped.saturating_add(1);
                }
                if self.frames.push_back(Waiting { time_us, payload }).is_err() {
                    // Without any room at all.
                    self.dropped = self.dropped.saturating_add(1);
                }
            }
        }
    }

    fn post_alarm(&mut self, time_us: u64, report: AlarmReport) {
        let Some(slot) = self.held_back.get_mut(report.alarm as usize) else {
            return;
        };
        let held = slot.is_some_and(|held| held.change);
        // A report that only says that the alarm stands must not take the room of changes.
        let change = report.change != AlarmChange::Standing;
        if change && !held && self.alarms.push_back((time_us, report)).is_ok() {
            // What says that it stands is out of date.
            *slot = None;
            return;
        }
        *slot = Some(HeldBack {
            time_us,
            report: AlarmReport {
                change: AlarmChange::Standing,
                ..report
            },
            change: change || held,
        });
    }

    /// Makes a frame of the payload that is worth the link most, and drops it from the queue.
    fn encode_next(&mut self) {
        if let Some((time_us, report)) = self.alarms.pop_front() {
            return self.encode(time_us, &Payload::Alarm(report));
        }
        if let Some(slot) = self.held_back.iter_mut().find(|slot| slot.is_some())
            && let Some(held) = slot.take()
        {
            return self.encode(held.time_us, &Payload::Alarm(held.report));
        }
        if let Some((time_us, answer)) = self.answer.take() {
            return self.encode(time_us, &Payload::Answer(answer));
        }
        if let Some((time_us, report)) = self.health.take() {
            return self.encode(time_us, &Payload::Health(report));
        }
        if let Some((time_us, report)) = self.hello.take() {
            return self.encode(time_us, &Payload::Hello(report));
        }
        if let Some(Waiting { time_us, payload }) = self.frames.front() {
            // Where it lies: a copy of a payload takes some hundred cycles.
            encode_numbered(self.sequence, *time_us, payload, &mut self.current);
            self.sequence = self.sequence.wrapping_add(1);
            self.frames.pop_front();
        }
    }

    fn encode(&mut self, time_us: u64, payload: &Payload) {
        encode_numbered(self.sequence, time_us, payload, &mut self.current);
        self.sequence = self.sequence.wrapping_add(1);
    }

    /// Makes sure that there are bytes on their way; false if there is nothing to send.
    fn fetch(&mut self) -> bool {
        if self.gone < self.current.len() {
            return true;
        }
        self.gone = 0;
        self.current.clear();
        self.encode_next();
        !self.current.is_empty()
    }

    /// The next byte for the link, if there is one.
    pub fn next_byte(&mut self) -> Option<u8> {
        if !self.fetch() {
            return None;
        }
        let byte = self.current.get(self.gone).copied();
        self.gone += 1;
        byte
    }

    /// Fills a buffer for the link, and returns how many bytes it has put there.
    pub fn fill(&mut self, buffer: &mut [u8]) -> usize {
        let mut filled = 0;
        while filled < buffer.len() && self.fetch() {
            let rest = self.current.get(self.gone..).unwrap_or_default();
            let room = buffer.get_mut(filled..).unwrap_or_default();
            let count = rest.len().min(room.len());
            for (to, from) in room.iter_mut().zip(rest) {
                *to = *from;
            }
            self.gone += count;
            filled += count;
        }
        filled
    }
}

/// A [`Frame`] whose payload lies elsewhere.
#[derive(Serialize)]
struct Numbered<'a> {
    version: u8,
    sequence: u32,
    time_us: u64,
    payload: &'a Payload,
}

#[inline(never)]
fn encode_numbered(sequence: u32, time_us: u64, payload: &Payload, to: &mut Vec<u8, FRAME_LENGTH>) {
    let frame = Numbered {
        version: VERSION,
        sequence,
        time_us,
        payload,
    };
    // The lengths above make room for every frame; the tests see to it.
    framing::encode_into(&frame, to);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judgement::AlarmState;
    use crate::telemetry::{EstimateReport, Frame, FrameReader, Read};
    use std::vec::Vec as Bytes;

    fn estimate(iterations: u16) -> Payload {
        Payload::Estimate(EstimateReport {
            iterations,
            ..EstimateReport::NONE
        })
    }

    fn alarm(alarm: Alarm, change: AlarmChange, raised: u32) -> Payload {
        Payload::Alarm(AlarmReport {
            alarm,
            change,
            state: AlarmState::Raised,
            value: 1.0,
            limit: 1.0,
            place: None,
            start: 0,
            raised,
            cleared: 0,
        })
    }

    fn read(bytes: &[u8]) -> Bytes<Read> {
        let mut reader = FrameReader::new();
        bytes.iter().filter_map(|b| reader.push(*b)).collect()
    }

    fn drain<const F: usize>(outbox: &mut Outbox<F>) -> Bytes<Frame> {
        let bytes: Bytes<u8> = core::iter::from_fn(|| outbox.next_byte()).collect();
        read(&bytes).into_iter().map(Result::unwrap).collect()
    }

    #[test]
    fn a_slow_link_loses_the_oldest_estimates_and_counts_them() {
        let mut outbox = Outbox::<4>::new();
        for iterations in 0..10 {
            outbox.post(u64::from(iterations), estimate(iterations));
        }
        assert_eq!(outbox.dropped(), 6);
        let frames = drain(&mut outbox);
        let times: Bytes<u64> = frames.iter().map(|f| f.time_us).collect();
        assert_eq!(times, [6, 7, 8, 9]);
        let numbers: Bytes<u32> = frames.iter().map(|f| f.sequence).collect();
        assert_eq!(numbers, [0, 1, 2, 3]);
        assert!(outbox.is_empty());
    }

    #[test]
    fn alarms_overtake_estimates_and_are_never_dropped() {
        let mut outbox = Outbox::<2>::new();
        for i in 0..100 {
            outbox.post(i, estimate(0));
            let change = if i % 2 == 0 {
                AlarmChange::Raised
            } else {
                AlarmChange::Cleared
            };
            outbox.post(i, alarm(Alarm::Slip, change, i as u32 / 2 + 1));
            outbox.post(i, alarm(Alarm::Sensor, AlarmChange::Standing, 7));
        }
        assert_eq!(outbox.dropped(), 98);
        let frames = drain(&mut outbox);
        let of = |which: Alarm| -> Bytes<AlarmReport> {
            let reports = frames.iter().filter_map(|frame| match &frame.payload {
                Payload::Alarm(report) if report.alarm == which => Some(*report),
                _ => None,
            });
            reports.collect()
        };
        let slip = of(Alarm::Slip);
        assert_eq!(slip.len(), ALARM_QUEUE + 1);
        let (last, first) = slip.split_last().unwrap();
        for (i, report) in first.iter().enumerate() {
            assert_eq!(report.raised as usize, i / 2 + 1);
            assert_ne!(report.change, AlarmChange::Standing);
        }
        // What no longer fitted is there as a count.
        assert_eq!((last.raised, last.change), (50, AlarmChange::Standing));
        let sensor = of(Alarm::Sensor);
        assert_eq!(sensor.len(), 1);
        assert!(matches!(
            frames.last().unwrap().payload,
            Payload::Estimate(_)
        ));
    }

    #[test]
    fn a_buffer_of_any_size_carries_the_same_bytes() {
        let post = |outbox: &mut Outbox<8>| {
            outbox.number_from(u32::MAX);
            for i in 0..3 {
                outbox.post(i, estimate(3));
                outbox.post(i, estimate(4));
            }
            outbox.post(9, Payload::Health(HealthReport::default()));
        };
        let mut byte_by_byte = Outbox::<8>::new();
        post(&mut byte_by_byte);
        let expected: Bytes<u8> = core::iter::from_fn(|| byte_by_byte.next_byte()).collect();
        for size in [1, 7, 64, 4096] {
            let mut outbox = Outbox::<8>::new();
            post(&mut outbox);
            let (mut buffer, mut bytes) = (std::vec![0; size], Bytes::<u8>::new());
            loop {
                let filled = outbox.fill(&mut buffer);
                if filled == 0 {
                    break;
                }
                bytes.extend(&buffer[..filled]);
            }
            assert_eq!(bytes, expected);
        }
        let numbers: Bytes<u32> = read(&expected)
            .into_iter()
            .map(|frame| frame.unwrap().sequence)
            .collect();
        assert_eq!(numbers, [u32::MAX, 0, 1, 2, 3, 4, 5]);
    }
}
