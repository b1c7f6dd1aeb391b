//! A recording as the board receives it: a record of loads and speed a tick, and temperatures at times.

use anyhow::{Result, bail};
use files::import::{Import, Wanted};
use files::recordings::{self, LoadRow};
use spindle_monitor::record::LoadRecord;

/// Input of a run.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    /// Loads and speed, a record a tick.
    pub records: Vec<LoadRecord>,
    /// Temperatures of the inner and of the outer side at every tick, degrees Celsius; empty if there are none.
    pub temperatures: Vec<[f32; 2]>,
}

/// Longest run: a day of ticks takes some gigabytes of frames.
const LONGEST: f64 = 3600.0;

/// Reads the first `seconds` of a recording, or all of it. It puts a record onto every tick of
/// `period_us`, on the straight line between the rows around it.
pub fn read(
    path: &str,
    import: Option<&Import>,
    seconds: Option<f64>,
    period_us: u32,
) -> Result<Recording> {
    let mut rows: Vec<LoadRow> = Vec::new();
    for row in recordings::read(path, import, &Wanted::default())? {
        let row = row?;
        let start = rows.first().map_or(row.time_s, |first| first.time_s);
        let time = row.time_s - start;
        if !(0.0..=LONGEST).contains(&time) {
            bail!(
                "{path}: time_s is {}, but must lie within {LONGEST} s from the first one",
                row.time_s
            );
        }
        if rows.last().is_some_and(|last| last.time_s >= row.time_s) {
            bail!("{path}: time_s is {}, but must rise", row.time_s);
        }
        rows.push(row);
        if seconds.is_some_and(|limit| time >= limit) {
            break;
        }
    }
    let Some(first) = rows.first() else {
        bail!("{path} holds no records");
    };
    let start = first.time_s;
    let end = rows.last().map_or(0.0, |last| last.time_s - start);
    let end = seconds.map_or(end, |limit| limit.min(end));
    let mut recording = Recording::default();
    let mut row = 0;
    for sequence in 0_u32.. {
        let us = u64::from(sequence) * u64::from(period_us);
        let time = us as f64 * 1e-6;
        // In whole microseconds, so that a row that falls onto a tick is that tick's.
        let at = |row: &LoadRow| ((row.time_s - start) * 1e6).round();
        let now = us as f64;
        if sequence > 0 && time >= end {
            break;
        }
        while rows.get(row + 1).is_some_and(|next| at(next) <= now) {
            row += 1;
        }
        let before = &rows[row];
        let after = rows.get(row + 1).unwrap_or(before);
        let span = at(after) - at(before);
        let part = if span > 0.0 {
            (now - at(before)) / span
        } else {
            0.0
        };
        let between = |from: f64, to: f64| (from + part * (to - from)) as f32;
        let load = |i: usize| between(before.load[i], after.load[i]);
        if let (Some(from), Some(to)) = (before.temperatures, after.temperatures) {
            let temperatures = [0, 1].map(|side| between(from[side], to[side]));
            recording.temperatures.push(temperatures);
        }
        recording.records.push(LoadRecord {
            sequence,
            time_ms: (us / 1000) as u32,
            fx: load(0),
            fy: load(1),
            fz: load(2),
            my: load(3),
            mz: load(4),
            speed_rpm: between(before.speed_rpm, after.speed_rpm),
        });
    }
    Ok(recording)
}

#[cfg(test)]
mod tests {
    use super::*;
    use host_tests::milling_cycle::RECORD;

    #[test]
    fn every_tick_has_a_record_and_every_row_its_own() {
        // Two ticks a row.
        let records = read(RECORD, None, Some(0.5), 500).unwrap().records;
        assert_eq!(records.len(), 1000);
        let rows: Vec<_> = recordings::read(RECORD, None, &Wanted::default())
            .unwrap()
            .take(500)
            .collect();
        for (i, row) in rows.into_iter().enumerate() {
            let (row, record) = (row.unwrap(), &records[2 * i]);
            assert_eq!(record.load(), row.load.map(|x| x as f32));
            assert_eq!((record.sequence, record.time_ms), (2 * i as u32, i as u32));
        }
        let middle = (records[0].fx + records[2].fx) / 2.0;
        assert!((records[1].fx - middle).abs() < 1e-4);
    }
}
