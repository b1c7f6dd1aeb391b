//! The board's monitor of a file, on the host.

use anyhow::{Result, anyhow};
use spindle_file::mounting::{MOST_JOINTS, Parts, board, preload};
use spindle_file::plan::{BuildError, MOST_BALLS, MOST_ROWS};
use spindle_file::spindles::SpindleFile;
use spindle_monitor::tick::Core;
use spindle_monitor::{Monitor, MonitorSettings, Probes};

/// A monitor of any spindle with `P` probes.
pub type DynMonitor<const P: usize> = Monitor<MOST_ROWS, MOST_BALLS, 12, 6, MOST_JOINTS, P>;

/// Makes the monitor of a file, which has solved its first equilibrium: on a board with this core, or on one without deadlines. It stays
/// until the program ends, as the board's does.
///
/// # Errors
///
/// Why the file has no such monitor.
pub fn monitor_of<const P: usize>(
    file: &SpindleFile,
    core: Option<Core>,
    settings: MonitorSettings<MOST_ROWS>,
) -> Result<Box<DynMonitor<P>>> {
    let plan = board::plan(file, core)?;
    let explained = |error: BuildError| file.explain(&error);
    let parts: &'static Parts<f32> = Box::leak(Box::new(Parts::of(&plan).map_err(explained)?));
    let spindle = Box::leak(Box::new(parts.spindle(&plan).map_err(explained)?));
    let response = Box::leak(Box::new(preload::response::<P>(file)?));
    let settings = Box::leak(Box::new(settings));
    let probes = Probes::new(response, &settings.alarms, settings.tick.period_us);
    let probes = Box::leak(Box::new(probes));
    let mut monitor = Box::new(Monitor::with_probes(spindle, settings, probes));
    let prepared = monitor.prepare(file.sensors.idle);
    prepared.map_err(|status| anyhow!("the idling spindle has no equilibrium: {status}"))?;
    Ok(monitor)
}
