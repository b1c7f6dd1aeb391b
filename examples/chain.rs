//! The monitor's chain, from the bytes of the port to those of the telemetry, without any hardware: the
//! same on every board, and on the host, which holds the emulated board against it.
//!
//! Two kinds of frames come in over one port: load records, and now and then a [`Command`]. Commands are
//! shorter than any record.

use super::Precision;
use super::monitor_settings::{IDLE, MONITOR};
use super::monitored::{BALLS, BEARING};
use heapless::Vec;
use serde::{Deserialize, Serialize};
use spindle_bearing::Full;
use spindle_bearing::framing::{self, CHECKSUM_LENGTH, DELIMITER, FrameReader};
use spindle_bearing::monitor::loads::{FrameCounts, FramedLoads, LoadSource};
use spindle_bearing::monitor::telemetry::{HealthReport, StatusCode};
use spindle_bearing::monitor::tick::{CycleCounter, Watchdog};
use spindle_bearing::monitor::{Alarm, Monitor, Outcome, Readings};

/// What a host says besides loads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Command {
    /// Somebody has seen this alarm.
    Acknowledge(Alarm),
    /// From now on (or no longer), learn the baseline.
    Learn(bool),
    /// In lock-step only: a tick, in which the telemetry's link takes so many bytes.
    Tick(u16),
}

/// Longest message of a command, checksum included: variant, and a varint of 16 bits.
const MESSAGE_LENGTH: usize = 1 + 3 + CHECKSUM_LENGTH;

/// Length of its frame, delimiter included.
pub const COMMAND_LENGTH: usize = framing::frame_length(MESSAGE_LENGTH);

/// The frame of a command.
#[allow(dead_code, reason = "the host's side")]
pub fn encode(command: Command) -> Vec<u8, COMMAND_LENGTH> {
    // The lengths above make room for every command.
    framing::encode(&command).unwrap_or_default()
}

/// Tells commands from load records.
struct Sorter {
    reader: FrameReader<Command, MESSAGE_LENGTH>,
    /// The frame so far, as long as it may be a command.
    held: Vec<u8, COMMAND_LENGTH>,
    /// It is too long for one.
    record: bool,
}

impl Sorter {
    const fn new() -> Self {
        Self {
            reader: FrameReader::new(),
            held: Vec::new(),
            record: false,
        }
    }

    /// Takes a byte; returns a command that it completes, and hands on what is none.
    fn push(&mut self, byte: u8, mut hand_on: impl FnMut(u8)) -> Option<Command> {
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

/// Estimates and pictures of balls that wait for a slow link.
const FRAMES: usize = 12;

/// The monitor with its source of loads.
pub struct Chain {
    monitor: Monitor<BALLS, Full, FRAMES, Precision>,
    loads: FramedLoads,
    sorter: Sorter,
    time_us: u64,
}

impl Chain {
    /// At the beginning.
    pub fn new() -> Self {
        Self {
            monitor: Monitor::new(&BEARING, &MONITOR),
            loads: FramedLoads::new(),
            sorter: Sorter::new(),
            time_us: 0,
        }
    }

    /// Solves a first equilibrium to start from, that of the idling spindle.
    ///
    /// # Errors
    ///
    /// How that solve ended; the monitor goes on without it.
    pub fn prepare(&mut self) -> Result<(), StatusCode> {
        self.monitor.prepare(IDLE, 0.0)
    }

    /// Takes a byte of the port. Returns how many bytes the link takes if it is a tick that is asked for.
    pub fn push(&mut self, byte: u8) -> Option<u16> {
        let loads = &mut self.loads;
        match self.sorter.push(byte, |byte| loads.push(byte))? {
            Command::Tick(room) => return Some(room),
            Command::Acknowledge(alarm) => self.monitor.acknowledge(self.time_us, alarm),
            Command::Learn(true) => self.monitor.judgement().start_learning(),
            Command::Learn(false) => self.monitor.judgement().stop_learning(),
        }
        None
    }

    /// A tick at this time.
    pub fn tick(
        &mut self,
        time_us: u64,
        counter: &mut impl CycleCounter,
        watchdog: &mut impl Watchdog,
    ) -> Outcome {
        self.time_us = time_us;
        let readings = Readings {
            loads: self.loads.sample(time_us),
            // The records carry it.
            speed: None,
        };
        self.monitor.tick(time_us, &readings, counter, watchdog)
    }

    /// The next byte for the telemetry's link.
    pub fn next_byte(&mut self) -> Option<u8> {
        self.monitor.outbox().next_byte()
    }

    /// Counters of the monitor.
    #[allow(dead_code, reason = "the host's side")]
    pub fn health(&self) -> HealthReport {
        self.monitor.health()
    }

    /// What came over the port.
    #[allow(dead_code, reason = "the host's side")]
    pub const fn counts(&self) -> FrameCounts {
        self.loads.counts()
    }
}
