//! Telemetry without a board: the shipped monitor runs on this machine, fed with a recording.
//!
//! It is the monitor of the STM32F405 with its settings, tick by tick. What takes a board is left at zero: cycles and
//! overruns. The link takes all there is.

use spindle_file::loads::LoadRow;
use spindle_firmware::spindle::{BALLS, FREEDOMS, IDLE, JOINTS, ROWS, SPINDLE, monitor_settings};
use spindle_monitor::Marks;
use spindle_monitor::loads::LoadSample;
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::tick::{Core, NoCycles, NoWatchdog};
use spindle_monitor::{Monitor, Readings};

/// Settings of the STM32F405's monitor.
pub static MONITOR: MonitorSettings<ROWS> = monitor_settings(&Core::STM32F405);

/// One revolution per minute.
const RAD_PER_S: f32 = std::f32::consts::PI / 30.0;

/// The bytes that the monitor sends while it samples a recording in every tick, in a straight line between two rows.
pub fn stream(rows: &[LoadRow]) -> Vec<u8> {
    let mut monitor: Monitor<ROWS, BALLS, 12, FREEDOMS, JOINTS> = Monitor::new(&SPINDLE, &MONITOR);
    // A start without a solution is one that the first ticks make up for.
    let _ = monitor.prepare(IDLE);
    let mut bytes = Vec::new();
    let mut time_us = 0;
    for (from, to) in rows.iter().zip(rows.iter().skip(1)) {
        while (time_us as f64) < to.time_s * 1e6 {
            let part = (time_us as f64 * 1e-6 - from.time_s) / (to.time_s - from.time_s);
            let between = |from: f64, to: f64| (from + part * (to - from)) as f32;
            let sample = LoadSample {
                time_us,
                load: core::array::from_fn(|i| between(from.load[i], to.load[i])),
                speed: Some(RAD_PER_S * between(from.speed_rpm, to.speed_rpm)),
                residual: 0.0,
                doubts: Marks::new(),
            };
            let readings = Readings {
                loads: Ok(Some(sample)),
                speed: None,
                temperatures: from.temperatures.map(|read| read.map(|t| t as f32)),
            };
            monitor.tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
            bytes.extend(core::iter::from_fn(|| monitor.outbox().next_byte()));
            time_us += u64::from(MONITOR.tick.period_us);
        }
    }
    bytes
}
