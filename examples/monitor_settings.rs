//! The monitor's settings on this spindle: one place for the firmware and for the host program that checks
//! it. Whoever includes it says how fast the core is.

use super::monitored::{BALLS, DESIGN};
use super::{CORE_HZ, COST};
use spindle_bearing::monitor::settings::MonitorSettings;

/// Loads of the idling spindle (N, N m), to start from: the preload.
pub const IDLE: [f32; 5] = [420.0, 0.0, 0.0, 0.0, 0.0];

/// Rate, doubts, alarms and telemetry. What is particular to this spindle is set here.
pub static MONITOR: MonitorSettings = {
    let mut settings = MonitorSettings::new(&DESIGN, BALLS);
    // Of this spindle's main bearing, in normal use.
    settings.plausibility.load = [
        [-500.0, 3e3],
        [-3e3, 3e3],
        [-3e3, 3e3],
        [-60.0, 60.0],
        [-60.0, 60.0],
    ];
    // All of a tick's time.
    settings.tick.deadline_cycles = CORE_HZ / 1_000_000 * settings.tick.period_us;
    settings.tick.cost = COST;
    // Half a thousandth is far below any threshold, and what a single sweep mostly reaches in a cut.
    settings.tolerance = 5e-4;
    settings
};
const _: () = match MONITOR.check() {
    Ok(()) => {}
    Err(error) => panic!("{}", error.field),
};
