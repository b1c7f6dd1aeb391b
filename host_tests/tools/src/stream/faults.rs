//! Faults, when they come, and what they do to the stream. A seed and a recording give one schedule.

use host_tests::cases::Random;
use spindle_bearing::record::{DELIMITER, FRAME_LENGTH, LoadRecord, encode};
use std::fmt;

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fault {
    /// Frames are lost, about every other one.
    Dropped,
    /// Frames are damaged on their way.
    Corrupt,
    /// Frames come twice.
    Repeated,
    /// Nothing comes at all.
    Silence,
    /// A load is not a number.
    NotANumber,
    /// A load is beyond what the spindle carries.
    OutOfRange,
    /// A load jumps and comes back.
    Spike,
    /// A channel gives one and the same value.
    Stuck,
    /// A load steps, and stays: no fault of the sensor.
    Step,
    /// The speed is lost at full speed.
    SpeedLost,
    /// The telemetry's link takes no bytes.
    LinkShut,
    /// The sensor of the inner side's temperature fails.
    TemperatureLost,
    /// The outer side's temperature jumps and comes back.
    TemperatureSpike,
}

/// Each fault, its name, and its shortest and longest duration in ticks.
const FAULTS: [(Fault, &str, [u64; 2]); 13] = [
    (Fault::Dropped, "frames dropped", [5, 40]),
    (Fault::Corrupt, "frames corrupt", [1, 10]),
    (Fault::Repeated, "frames repeated", [1, 5]),
    (Fault::Silence, "no frames", [60, 300]),
    (Fault::NotANumber, "load not a number", [1, 30]),
    (Fault::OutOfRange, "load out of range", [1, 150]),
    (Fault::Spike, "load spike", [1, 2]),
    (Fault::Stuck, "channel stuck", [120, 250]),
    (Fault::Step, "load step", [50, 200]),
    (Fault::SpeedLost, "speed lost at full speed", [20, 200]),
    (Fault::LinkShut, "telemetry link shut", [300, 900]),
    (Fault::TemperatureLost, "temperature lost", [200, 400]),
    (Fault::TemperatureSpike, "temperature spike", [100, 200]),
];

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(FAULTS[*self as usize].1)
    }
}

/// A fault from one tick until another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Episode {
    /// What goes wrong.
    pub fault: Fault,
    /// Its first tick.
    pub from: usize,
    /// The tick after its last.
    pub until: usize,
}

/// A whole number below `n`.
fn below(random: &mut Random, n: u64) -> u64 {
    random.bits() % n
}

/// Ticks for each fault, the calm after it included.
const SLOT: usize = 450;
/// Ticks before the first fault.
const LEAD: usize = 500;

/// The faults of a run: all kinds in a shuffled order, again and again.
pub fn schedule(seed: u64, records: &[LoadRecord]) -> Vec<Episode> {
    let mut random = Random::seeded(seed);
    let highest = records.iter().map(|r| r.speed_rpm).fold(0.0, f32::max);
    let mut episodes = Vec::new();
    let mut kinds: Vec<(Fault, &str, [u64; 2])> = Vec::new();
    let mut at = LEAD;
    while at + SLOT <= records.len() {
        if kinds.is_empty() {
            kinds.extend(FAULTS);
            for i in (1..kinds.len()).rev() {
                kinds.swap(i, below(&mut random, i as u64 + 1) as usize);
            }
        }
        let full_speed = highest > 0.0 && records[at].speed_rpm >= 0.95 * highest;
        // A loss of the speed waits for full speed, and is then the first fault.
        let is_lost = |(kind, ..): &(Fault, &str, [u64; 2])| *kind == Fault::SpeedLost;
        let lost = kinds.iter().position(|kind| full_speed && is_lost(kind));
        let index = lost.or_else(|| kinds.iter().position(|kind| !is_lost(kind)));
        if let Some(index) = index {
            let (fault, _, [least, most]) = kinds.remove(index);
            let length = least + below(&mut random, most - least + 1);
            let from = at + below(&mut random, 40) as usize;
            episodes.push(Episode {
                fault,
                from,
                until: from + length as usize,
            });
        } else {
            // Full speed may never come again.
            kinds.clear();
        }
        at += SLOT;
    }
    episodes
}

/// Bytes of a tick, and whether the link takes any.
pub struct Spoilt {
    /// What goes over the line.
    pub bytes: Vec<u8>,
    /// The link is shut.
    pub shut: bool,
}

/// Spoils the frame of a record.
pub struct Spoiler {
    episodes: Vec<Episode>,
    random: Random,
    /// What a stuck channel is stuck at.
    stuck: Option<f32>,
    damaged: usize,
}

impl Spoiler {
    /// With these faults.
    pub fn new(seed: u64, episodes: Vec<Episode>) -> Self {
        Self {
            episodes,
            random: Random::seeded(!seed),
            stuck: None,
            damaged: 0,
        }
    }

    /// The faults, in their order.
    pub fn episodes(&self) -> &[Episode] {
        &self.episodes
    }

    /// The faults of a tick.
    fn at(&self, tick: usize) -> Vec<Episode> {
        let now = |e: &&Episode| (e.from..e.until).contains(&tick);
        self.episodes.iter().filter(now).copied().collect()
    }

    /// What becomes of a tick's temperatures.
    pub fn spoil_temperatures(&self, tick: usize, [inner, outer]: [f32; 2]) -> [f32; 2] {
        let (mut inner, mut outer) = (inner, outer);
        for episode in self.at(tick) {
            match episode.fault {
                Fault::TemperatureLost => inner = f32::NAN,
                Fault::TemperatureSpike => outer += 60.0,
                _ => {}
            }
        }
        [inner, outer]
    }

    /// What becomes of a tick's record.
    pub fn spoil(&mut self, tick: usize, record: &LoadRecord) -> Spoilt {
        let mut record = *record;
        let (mut times, mut corrupt, mut shut) = (1, false, false);
        let mut stuck = None;
        for episode in self.at(tick) {
            match episode.fault {
                Fault::Dropped => times = below(&mut self.random, 2),
                Fault::Corrupt => corrupt = true,
                Fault::Repeated => times = 2,
                Fault::Silence => times = 0,
                Fault::NotANumber => record.fz = f32::NAN,
                Fault::OutOfRange => record.fx = 3e4,
                Fault::Spike => record.fy += 2e3,
                Fault::Stuck => stuck = Some(self.stuck.unwrap_or(record.mz)),
                Fault::Step => record.fy += 300.0,
                Fault::SpeedLost => record.speed_rpm = f32::NAN,
                Fault::LinkShut => shut = true,
                Fault::TemperatureLost | Fault::TemperatureSpike => {}
            }
        }
        self.stuck = stuck;
        record.mz = stuck.unwrap_or(record.mz);
        let frame = if corrupt {
            self.damaged += 1;
            damage(&record, self.damaged)
        } else {
            encode(&record).to_vec()
        };
        Spoilt {
            bytes: frame.repeat(times as usize),
            shut,
        }
    }
}

/// A frame that went wrong on its way, in one of three ways.
pub fn damage(record: &LoadRecord, way: usize) -> Vec<u8> {
    let mut frame = encode(record).to_vec();
    let middle = frame.len() / 2;
    match way % 3 {
        // One bit turned over, though not into a delimiter.
        0 => frame[middle] ^= if frame[middle] == 1 { 2 } else { 1 },
        // Bytes missing.
        1 => drop(frame.drain(middle..frame.len() - 1)),
        // The delimiter missing, many times over.
        _ => {
            frame = [0x55; 3 * FRAME_LENGTH].to_vec();
            frame.push(DELIMITER);
        }
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;
    use spindle_bearing::record::{FrameReader, MESSAGE_LENGTH};

    fn record(sequence: u32) -> LoadRecord {
        LoadRecord {
            sequence,
            time_ms: sequence,
            fx: 200.0 + sequence as f32,
            fy: 0.1 * sequence as f32,
            fz: 0.0,
            my: 0.0,
            mz: 0.0,
            speed_rpm: 12_000.0,
        }
    }

    #[test]
    fn every_damage_is_one_corrupt_frame() {
        for sequence in 0..300 {
            for way in 0..3 {
                let mut reader = FrameReader::<MESSAGE_LENGTH>::new();
                let results: Vec<_> = damage(&record(sequence), way)
                    .into_iter()
                    .filter_map(|byte| reader.push(byte))
                    .collect();
                assert!(matches!(results[..], [Err(_)]), "{way} {results:?}");
            }
        }
    }

    #[test]
    fn a_schedule_has_every_fault_and_is_that_of_its_seed() {
        let records: Vec<_> = (0..10_000).map(record).collect();
        let episodes = schedule(1, &records);
        for (fault, ..) in FAULTS {
            assert!(episodes.iter().any(|e| e.fault == fault), "{fault}");
        }
        assert_eq!(episodes, schedule(1, &records));
        assert_ne!(episodes, schedule(2, &records));
        let mut standing = records;
        standing
            .iter_mut()
            .for_each(|record| record.speed_rpm = 0.0);
        let lost = |e: &Episode| e.fault == Fault::SpeedLost;
        assert!(!schedule(1, &standing).iter().any(lost));
    }
}
