//! Faults, when they come, and what they do to the stream. A seed and a recording give one schedule.

use super::records::Recording;
use crate::random::Random;
use spindle_monitor::record::{DELIMITER, FRAME_LENGTH, LoadRecord, encode};

/// Everything that comes in a tick.
struct Line<'r> {
    record: LoadRecord,
    /// Degrees Celsius, of the inner side and of the outer one.
    temperatures: Option<[f32; 2]>,
    /// Number of times that the record's frame arrives.
    times: u64,
    is_corrupt: bool,
    /// The link takes no telemetry.
    is_shut: bool,
    random: &'r mut Random,
}

/// The effect of a fault on a tick; the record is from the fault's first tick.
type Spoil = fn(&mut Line<'_>, &LoadRecord);

/// Each fault: its name, its shortest and longest duration in ticks, and what it does.
const FAULTS: [(&str, [u64; 2], Spoil); 13] = [
    ("frames dropped", [5, 40], |line, _| {
        line.times = below(line.random, 2);
    }),
    ("frames corrupt", [1, 10], |line, _| line.is_corrupt = true),
    ("frames repeated", [1, 5], |line, _| line.times = 2),
    ("no frames", [60, 300], |line, _| line.times = 0),
    ("load not a number", [1, 30], |line, _| {
        line.record.fz = f32::NAN;
    }),
    // Beyond what the spindle carries.
    ("load out of range", [1, 150], |line, _| {
        line.record.fx = 3e4;
    }),
    ("load spike", [1, 2], |line, _| line.record.fy += 2e3),
    ("channel stuck", [120, 250], |line, first| {
        line.record.mz = first.mz;
    }),
    // No fault of the sensor.
    ("load step", [50, 200], |line, _| line.record.fy += 300.0),
    (SPEED_LOST, [20, 200], |line, _| {
        line.record.speed_rpm = f32::NAN;
    }),
    ("telemetry link shut", [300, 900], |line, _| {
        line.is_shut = true;
    }),
    ("temperature lost", [200, 400], |line, _| {
        line.temperatures = line.temperatures.map(|[_, outer]| [f32::NAN, outer]);
    }),
    ("temperature spike", [100, 200], |line, _| {
        line.temperatures = line
            .temperatures
            .map(|[inner, outer]| [inner, outer + 60.0]);
    }),
];

/// The fault that waits for full speed.
const SPEED_LOST: &str = "speed lost at full speed";

/// Names of the faults.
pub fn names() -> [&'static str; FAULTS.len()] {
    FAULTS.map(|(name, ..)| name)
}

/// A fault from one tick until another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Episode {
    fault: usize,
    /// Its first tick.
    from: usize,
    /// The tick after its last.
    until: usize,
}

impl Episode {
    /// Name of the fault.
    pub fn name(&self) -> &'static str {
        FAULTS[self.fault].0
    }
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
    let mut kinds: Vec<usize> = Vec::new();
    let slots = (LEAD..).step_by(SLOT);
    for at in slots.take_while(|at| at + SLOT <= records.len()) {
        if kinds.is_empty() {
            kinds.extend(0..FAULTS.len());
            for i in (1..kinds.len()).rev() {
                kinds.swap(i, below(&mut random, i as u64 + 1) as usize);
            }
        }
        let full_speed = highest > 0.0 && records[at].speed_rpm >= 0.95 * highest;
        // A loss of the speed waits for full speed, and is then the first fault.
        let is_lost = |kind: &usize| FAULTS[*kind].0 == SPEED_LOST;
        let lost = kinds.iter().position(|kind| full_speed && is_lost(kind));
        let Some(index) = lost.or_else(|| kinds.iter().position(|kind| !is_lost(kind))) else {
            // Full speed may never come again.
            kinds.clear();
            continue;
        };
        let fault = kinds.remove(index);
        let [least, most] = FAULTS[fault].1;
        let length = least + below(&mut random, most - least + 1);
        let from = at + below(&mut random, 40) as usize;
        episodes.push(Episode {
            fault,
            from,
            until: from + length as usize,
        });
    }
    episodes
}

/// Records and sensors of one tick.
pub struct Spoilt {
    /// Frames of the record.
    pub bytes: Vec<u8>,
    /// Temperatures of both sides, degrees Celsius.
    pub temperatures: Option<[f32; 2]>,
    /// The link takes no telemetry.
    pub is_shut: bool,
}

/// Spoils a recording.
pub struct Spoiler {
    /// The faults, in their order.
    pub episodes: Vec<Episode>,
    random: Random,
    damaged: usize,
}

impl Spoiler {
    /// With these faults.
    pub fn new(seed: u64, episodes: Vec<Episode>) -> Self {
        Self {
            episodes,
            random: Random::seeded(!seed),
            damaged: 0,
        }
    }

    /// The next tick with its faults; `None` after the last record.
    pub fn spoil(&mut self, tick: usize, recording: &Recording) -> Option<Spoilt> {
        let mut line = Line {
            record: *recording.records.get(tick)?,
            temperatures: recording.temperatures.get(tick).copied(),
            times: 1,
            is_corrupt: false,
            is_shut: false,
            random: &mut self.random,
        };
        let now = |episode: &&Episode| (episode.from..episode.until).contains(&tick);
        for episode in self.episodes.iter().filter(now) {
            FAULTS[episode.fault].2(&mut line, &recording.records[episode.from]);
        }
        let frame = if line.is_corrupt {
            self.damaged += 1;
            damage(&line.record, self.damaged)
        } else {
            encode(&line.record).to_vec()
        };
        Some(Spoilt {
            bytes: frame.repeat(line.times as usize),
            temperatures: line.temperatures,
            is_shut: line.is_shut,
        })
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
    use spindle_monitor::record::{FrameReader, MESSAGE_LENGTH};

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
        for name in names() {
            assert!(episodes.iter().any(|e| e.name() == name), "{name}");
        }
        assert_eq!(episodes, schedule(1, &records));
        assert_ne!(episodes, schedule(2, &records));
        let mut standing = records;
        standing
            .iter_mut()
            .for_each(|record| record.speed_rpm = 0.0);
        let lost = |e: &Episode| e.name() == SPEED_LOST;
        assert!(!schedule(1, &standing).iter().any(lost));
    }
}
