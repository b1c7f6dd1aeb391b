//! A recording at the rate of ticks: held where it is slower, the newest record of each tick where it is faster.

use crate::fault::LoadsError;
use anyhow::{Result, bail, ensure};
use spindle_file::loads::LoadRow;
use spindle_monitor::command::MOST_PROBES;
use spindle_monitor::record::LoadRecord;

/// Longest time that a record is held, s.
const LONGEST: f64 = 3600.0;

/// The input of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TickInput {
    /// Loads and speed; the time counts from the first record.
    pub record: LoadRecord,
    /// Temperatures of the inner and of the outer side, degrees Celsius.
    pub temperatures: Option<[f32; 2]>,
    /// Displacements at the probes, um; none where the record of the tick before is held.
    pub probes: [Option<f32>; MOST_PROBES],
}

/// The ticks of a recording, in order. Rows that cannot be read are left out.
pub struct PerTick<I> {
    rows: I,
    period_us: u32,
    tick: u32,
    /// Time of the first row, s.
    start: Option<f64>,
    newest: Option<LoadRow>,
    /// The row after it.
    ahead: Option<LoadRow>,
    /// Ticks that hold the record of the tick before.
    held: u64,
    /// Records that a newer one of their tick replaced.
    passed_over: u64,
}

impl<I: Iterator<Item = Result<LoadRow, LoadsError>>> PerTick<I> {
    /// Ticks of this period, us.
    pub fn new(rows: I, period_us: u32) -> Self {
        Self {
            rows,
            period_us,
            tick: 0,
            start: None,
            newest: None,
            ahead: None,
            held: 0,
            passed_over: 0,
        }
    }

    /// Time of the first row, s; 0 before it is read.
    pub fn start(&self) -> f64 {
        self.start.unwrap_or_default()
    }

    /// How the recording was brought to the rate of ticks, in one line; none if each tick has had its own record.
    pub fn account(&self) -> Option<String> {
        let (held, passed_over) = (self.held, self.passed_over);
        (held + passed_over > 0).then(|| {
            format!(
                "{} ticks of {} ms: {held} hold the record of the tick before; {passed_over} records gave way to a newer one of \
                 their tick",
                self.tick,
                f64::from(self.period_us) / 1e3,
            )
        })
    }

    /// Reads the next row; none at the end.
    fn read(&mut self) -> Result<Option<LoadRow>> {
        let row = loop {
            match self.rows.next() {
                None => return Ok(None),
                Some(Err(LoadsError::Row(_))) => {}
                Some(row) => break row?,
            }
        };
        let last = self.newest.map_or(row.time_s, |last| last.time_s);
        ensure!(
            row.time_s >= last,
            "time_s is {} after {last}, but must not fall: cut the recording there",
            row.time_s
        );
        ensure!(
            row.time_s - last <= LONGEST,
            "time_s is {} after {last}, and a record is held for {LONGEST} s at most: cut the recording there",
            row.time_s
        );
        Ok(Some(row))
    }

    /// Goes to this time, us: how many rows there are until then.
    fn go_to(&mut self, us: u64) -> Result<u64> {
        let mut rows = 0;
        loop {
            if let Some(row) = self.ahead {
                // In whole microseconds, so that a row that falls onto a tick is that tick's.
                if ((row.time_s - self.start()) * 1e6).round() > us as f64 {
                    return Ok(rows);
                }
                (self.newest, rows) = (self.ahead.take(), rows + 1);
            }
            self.ahead = self.read()?;
            match self.ahead {
                None => return Ok(rows),
                Some(row) => self.start.get_or_insert(row.time_s),
            };
        }
    }

    fn advance(&mut self) -> Result<Option<TickInput>> {
        let us = u64::from(self.tick) * u64::from(self.period_us);
        let rows = self.go_to(us)?;
        let Some(row) = self.newest.filter(|_| rows > 0 || self.ahead.is_some()) else {
            return Ok(None);
        };
        self.held += u64::from(rows == 0);
        self.passed_over += rows.saturating_sub(1);
        let [fx, fy, fz, my, mz] = row.load.map(|x| x as f32);
        let record = LoadRecord {
            sequence: self.tick,
            time_ms: (us / 1000) as u32,
            fx,
            fy,
            fz,
            my,
            mz,
            speed_rpm: row.speed_rpm as f32,
        };
        let Some(next) = self.tick.checked_add(1) else {
            bail!("the recording is longer than {} ticks: cut it", u32::MAX);
        };
        self.tick = next;
        Ok(Some(TickInput {
            record,
            temperatures: row.temperatures.map(|read| read.map(|t| t as f32)),
            probes: row
                .probes
                .map(|read| read.filter(|_| rows > 0).map(|um| um as f32)),
        }))
    }
}

impl<I: Iterator<Item = Result<LoadRow, LoadsError>>> Iterator for PerTick<I> {
    type Item = Result<TickInput>;

    fn next(&mut self) -> Option<Self::Item> {
        self.advance().transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::BadRow;
    use crate::quantities::OWN;

    /// Times of the rows, s, and the time of the row that each tick of 1 ms has, ms.
    fn ticks(times: &[f64]) -> (Result<Vec<f32>>, Option<String>) {
        let rows = times.iter().map(|time_s| match time_s.is_infinite() {
            true => Err(LoadsError::Row(Box::new(BadRow {
                fault: String::new(),
                numbers: [None; OWN.len()],
            }))),
            false => Ok(LoadRow {
                time_s: *time_s,
                load: [(1e3 * time_s).round(), 0.0, 0.0, 0.0, 0.0],
                speed_rpm: 0.0,
                temperatures: None,
                probes: [None; 4],
            }),
        });
        let mut ticks = PerTick::new(rows, 1000);
        let forces = ticks.by_ref().map(|tick| Ok(tick?.record.fx)).collect();
        (forces, ticks.account())
    }

    #[test]
    fn each_tick_has_the_newest_record() {
        let (own, line) = ticks(&[0.0, 0.001, 0.002]);
        assert_eq!((own.unwrap(), line), (vec![0.0, 1.0, 2.0], None));
        let (held, line) = ticks(&[5.0, 5.003, f64::INFINITY, 5.004]);
        assert_eq!(held.unwrap(), [5000.0, 5000.0, 5000.0, 5003.0, 5004.0]);
        assert!(line.unwrap().starts_with("5 ticks of 1 ms: 2 hold "));
        let (passed, line) = ticks(&[0.0, 0.0002, 0.0006, 0.001, 0.0014, 0.0018, 0.002]);
        assert_eq!(passed.unwrap(), [0.0, 1.0, 2.0]);
        assert!(line.unwrap().contains("; 4 records gave way"));
        assert!(ticks(&[]).0.unwrap().is_empty());
        for (times, told) in [
            ([0.0, -1.0], "must not fall"),
            ([0.0, f64::NAN], "must not fall"),
            ([0.0, 1e30], "held for 3600 s at most"),
        ] {
            let error = ticks(&times).0.unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }
}
