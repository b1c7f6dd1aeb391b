//! Telemetry without a board: the monitor of a spindle runs on this machine, fed with a recording.
//!
//! It is the monitor of the STM32F405 with its settings, tick by tick. What takes a board is left at zero: cycles and
//! overruns. The link takes all there is.

use crate::board::monitor_of;
use crate::fault::LoadsError;
use crate::stream::per_tick::PerTick;
use anyhow::Result;
use spindle_file::loads::LoadRow;
use spindle_file::spindles::SpindleFile;
use spindle_firmware::spindle::{ROWS, monitor_settings};
use spindle_monitor::loads::LoadSample;
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::tick::{Core, NoCycles, NoWatchdog};
use spindle_monitor::{Marks, Readings};
use std::array::from_fn;

/// Settings of the STM32F405's monitor of the shipped spindle.
pub static MONITOR: MonitorSettings<ROWS> = monitor_settings(&Core::STM32F405);

/// The bytes that the monitor of a spindle sends while it samples a recording in every tick.
///
/// # Errors
///
/// The spindle has no such monitor, or the recording cannot be read.
pub fn stream(
    file: &SpindleFile,
    rows: impl Iterator<Item = Result<LoadRow, LoadsError>>,
) -> Result<Vec<u8>> {
    match file.probes.len() {
        0 => sent::<0>(file, rows),
        1 => sent::<1>(file, rows),
        2 => sent::<2>(file, rows),
        3 => sent::<3>(file, rows),
        _ => sent::<4>(file, rows),
    }
}

fn sent<const P: usize>(
    file: &SpindleFile,
    rows: impl Iterator<Item = Result<LoadRow, LoadsError>>,
) -> Result<Vec<u8>> {
    let settings = file.settings(&Core::STM32F405);
    let mut monitor = monitor_of::<P>(file, Some(Core::STM32F405), settings)?;
    let mut bytes = Vec::new();
    for tick in PerTick::new(rows, settings.tick.period_us) {
        let tick = tick?;
        let time_us = u64::from(tick.record.sequence) * u64::from(settings.tick.period_us);
        let sample = LoadSample {
            time_us,
            load: tick.record.load(),
            speed: Some(tick.record.omega()),
            residual: 0.0,
            doubts: Marks::new(),
        };
        let readings = Readings {
            loads: Ok(Some(sample)),
            speed: None,
            temperatures: tick.temperatures,
        };
        monitor.note_displacements(from_fn(|i| tick.probes[i]));
        monitor.tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
        bytes.extend(core::iter::from_fn(|| monitor.outbox().next_byte()));
    }
    Ok(bytes)
}
