//! A recording as the board receives it: a record of loads and speed a tick, and temperatures at times.

use super::per_tick::PerTick;
use anyhow::{Result, anyhow, ensure};
use files::import::{Import, Wanted};
use files::recordings;
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

/// Reads the first `seconds` of a recording, or all of it, at the rate of ticks of `period_us`.
pub fn read(
    path: &str,
    import: Option<&Import>,
    seconds: Option<f64>,
    period_us: u32,
) -> Result<Recording> {
    let rows = recordings::read(path, import, &Wanted::default())?;
    let mut ticks = PerTick::new(rows, period_us);
    let mut recording = Recording::default();
    let most = seconds.unwrap_or(LONGEST) * 1e6 / f64::from(period_us);
    for tick in ticks.by_ref() {
        if recording.records.len() as f64 >= most {
            ensure!(
                seconds.is_some(),
                "{path} is longer than {LONGEST} s: cut it, or say --seconds"
            );
            break;
        }
        let tick = tick.map_err(|error| anyhow!("{path}: {error}"))?;
        recording.records.push(tick.record);
        recording.temperatures.extend(tick.temperatures);
    }
    ensure!(!recording.records.is_empty(), "{path} holds no records");
    if let Some(account) = ticks.account() {
        eprintln!("{account}");
    }
    Ok(recording)
}
