//! A hundred thousand damaged streams, into the board and into the host.

use super::telemetry::{cycle, decoded, frames_of};
use cli::random::Random;
use cli::telemetry::decoder::{Decoder, Event};
use cli::telemetry::state::State;
use mock::rig::{IDLE, Rig, SETTINGS, SPEED};
use rayon::prelude::*;
use spindle_monitor::command::{self, Command, Order, PortReader, Received, Request};
use spindle_monitor::loads::{FramedLoads, LoadSource};
use spindle_monitor::record::{self, LoadRecord};
use spindle_monitor::{Alarm, Readings};
use std::collections::HashSet;

const STREAMS: u64 = 100_000;
/// Streams one after the other into the same board or host.
const IN_A_ROW: u64 = 1000;

/// Damages a piece of a stream as lines, gateways and strangers do.
fn mutate(random: &mut Random, bytes: &mut Vec<u8>) {
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            return;
        }
        let (a, b) = (random.below(bytes.len()), random.below(bytes.len()));
        let (from, to) = (a.min(b), a.max(b));
        match random.below(7) {
            0 => bytes[from] ^= 1 << random.below(8),
            1 => bytes[from] = random.bits() as u8,
            2 => bytes.insert(from, random.bits() as u8),
            3 => drop(bytes.remove(from)),
            4 => drop(bytes.drain(from..to)),
            5 => {
                let again = bytes[from..to].to_vec();
                bytes.splice(to..to, again);
            }
            _ => bytes[from..to].reverse(),
        }
    }
}

/// A board behind a port.
struct Board {
    rig: Rig,
    port: PortReader,
    source: FramedLoads,
    sequence: u32,
    /// Loads of the records that were sent.
    sent: Vec<[u32; 5]>,
}

impl Board {
    fn new() -> Self {
        Self {
            rig: Rig::running(&SETTINGS),
            port: PortReader::new(),
            source: FramedLoads::new(),
            sequence: 0,
            sent: Vec::new(),
        }
    }

    /// The record of a tick to come, of the idling spindle or, this often, of any bits.
    fn record(&mut self, random: &mut Random, wild: f64, ahead_ms: u64) -> Vec<u8> {
        self.sequence += 1;
        let wild = random.chance(wild);
        let [fx, fy, fz, my, mz] = IDLE.map(|load| {
            if wild && random.chance(0.3) {
                f32::from_bits(random.bits() as u32)
            } else {
                load * (1.0 + random.between(0.0, 1e-3) as f32)
            }
        });
        let record = LoadRecord {
            sequence: self.sequence,
            time_ms: (self.rig.time_us / 1000 + ahead_ms) as u32,
            speed_rpm: SPEED * 30.0 / core::f32::consts::PI,
            fx,
            fy,
            fz,
            my,
            mz,
        };
        self.sent.push(record.load().map(f32::to_bits));
        record::encode(&record).to_vec()
    }

    /// A second of sound records; whether the last one is solved in its tick.
    fn idle(&mut self, random: &mut Random) -> bool {
        let mut fresh = false;
        for _ in 0..1000 {
            let bytes = self.record(random, 0.0, 0);
            fresh = self.tick(&bytes);
        }
        fresh
    }

    fn order(random: &mut Random) -> Vec<u8> {
        let order = match random.below(2) {
            0 => Order::ReplaceBearing,
            _ => Order::Acknowledge {
                alarm: Alarm::ALL[random.below(Alarm::COUNT)],
                start: 0,
                raised: random.below(3) as u32,
            },
        };
        command::encode(Command::Ask(Request { number: 1, order })).to_vec()
    }

    /// A tick with these bytes before it; whether its estimate is fresh and nothing is doubted.
    fn tick(&mut self, bytes: &[u8]) -> bool {
        for byte in bytes {
            match self.port.push(*byte) {
                Some(Ok(Received::Record(record))) => self.source.take(Ok(record)),
                Some(Ok(Received::Command(Command::Ask(request)))) => {
                    self.rig.monitor.ask(&request, true);
                }
                Some(Ok(Received::Command(
                    Command::Tick(_) | Command::Temperatures(_) | Command::Probes(_),
                )))
                | None => {}
                Some(Err(error)) => self.source.take(Err(error)),
            }
        }
        let before = self.source.counts();
        let loads = self.source.sample(self.rig.time_us);
        let after = self.source.counts();
        assert!(before.received == after.received && before.corrupt == after.corrupt);
        assert!(before.lost <= after.lost && before.disordered <= after.disordered);
        let outcome = self.rig.tick(&Readings {
            loads,
            speed: None,
            temperatures: None,
        });
        outcome.marks.is_empty() && outcome.age == Some(0)
    }
}

/// The rig holds the laws of every tick: ticks go on, nothing doubted is solved, every estimate has its marks, frames are
/// whole.
#[test]
fn a_hundred_thousand_damaged_streams_to_the_board_break_no_law() {
    (0..STREAMS / IN_A_ROW).into_par_iter().for_each(|seed| {
        let mut random = Random::seeded(seed);
        let mut board = Board::new();
        board.idle(&mut random);
        board.rig.host.estimates.clear();
        for _ in 0..IN_A_ROW {
            let mut bytes = Vec::new();
            for ms in 0..6 {
                if random.chance(0.1) {
                    bytes.extend(Board::order(&mut random));
                }
                bytes.extend(board.record(&mut random, 0.1, ms));
            }
            mutate(&mut random, &mut bytes);
            for piece in bytes.chunks(34) {
                board.tick(piece);
            }
        }
        // What is sound again is solved again.
        assert!(board.idle(&mut random), "board {seed}");
        board.rig.no_alarm_is_lost();
        // No estimate of a load that was never sent.
        let sent: HashSet<_> = board.sent.into_iter().collect();
        let estimates = &board.rig.host.estimates;
        assert!(estimates.len() > 100);
        for (_, report) in estimates {
            let load = report.load.map(f32::to_bits);
            assert!(sent.contains(&load), "board {seed}: {report:?}");
        }
    });
}

/// Every frame that a host receives is one that the board has sent; counts do not go back.
#[test]
fn a_hundred_thousand_damaged_streams_to_the_host_make_up_no_frame() {
    let (_, bytes) = cycle(2.0);
    let (events, _) = decoded(&bytes);
    let sent = frames_of(&events);
    (0..STREAMS / IN_A_ROW).into_par_iter().for_each(|seed| {
        let mut random = Random::seeded(seed);
        let (mut decoder, mut state) = (Decoder::new(), State::default());
        for _ in 0..IN_A_ROW {
            let from = random.below(bytes.len() - 600);
            let mut piece = bytes[from..from + 600].to_vec();
            mutate(&mut random, &mut piece);
            let before = decoder.tally();
            for byte in piece {
                let Some(event) = decoder.push(byte) else {
                    continue;
                };
                state.note(&event, decoder.tally());
                if let Event::Frame { frame, .. } = &event {
                    assert_eq!(sent[frame.sequence as usize], frame);
                }
            }
            let after = decoder.tally();
            assert!(before.frames <= after.frames && before.damaged <= after.damaged);
            assert!(before.lost <= after.lost && before.restarts <= after.restarts);
        }
    });
}
