//! A recording as the board receives it: a record of loads and speed a tick, and temperatures at times.

use super::per_tick::PerTick;
use crate::recordings::{self, Wanted};
use anyhow::{Result, anyhow, ensure};
use spindle_file::probes::Probe;
use spindle_monitor::command::MOST_PROBES;
use spindle_monitor::record::LoadRecord;

/// Input of a run.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    /// Loads and speed, a record a tick.
    pub records: Vec<LoadRecord>,
    /// Temperatures of the inner and of the outer side at every tick, degrees Celsius; empty if there are none.
    pub temperatures: Vec<[f32; 2]>,
    /// Displacements at the probes at every tick, um; no numbers where there are none.
    pub probes: Vec<[f32; MOST_PROBES]>,
}

/// Longest run: a day of ticks takes some gigabytes of frames.
const LONGEST: f64 = 3600.0;

/// Reads the first `seconds` of a recording, or all of it, at the rate of ticks of `period_us`, with these probes.
pub fn read(
    path: &str,
    probes: &[Probe],
    seconds: Option<f64>,
    period_us: u32,
) -> Result<Recording> {
    let wanted = Wanted {
        probes: probes.iter().map(|probe| probe.name.clone()).collect(),
        shares_times: true,
        ..Wanted::default()
    };
    let mut rows = recordings::read(path, &wanted)?;
    for (probe, _) in probes.iter().zip(rows.has_probes()).filter(|(_, has)| !has) {
        eprintln!("{path}: there is no column probe_{}_um", probe.name);
    }
    let mut ticks = PerTick::new(rows.by_ref(), period_us);
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
        recording
            .probes
            .push(tick.probes.map(|um| um.unwrap_or(f32::NAN)));
    }
    ensure!(!recording.records.is_empty(), "{path} holds no records");
    if let Some(account) = ticks.account() {
        eprintln!("{account}");
    }
    if let Some(shared) = rows.shared() {
        eprintln!("{path}: {shared}");
    }
    Ok(recording)
}
