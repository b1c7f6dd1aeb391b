//! Telemetry without a board: the shipped monitor runs on this machine, fed with a recording.
//!
//! It is the monitor of the STM32F405 with its settings, tick by tick. What takes a board is left at zero: cycles and
//! overruns. The link takes all there is.

use crate::loads::LoadRow;
use monitor_settings::{IDLE, MONITOR};
use monitored::{BALLS, BEARING};
use spindle_bearing::monitor::loads::LoadSample;
use spindle_bearing::monitor::plausibility::Marks;
use spindle_bearing::monitor::tick::{CycleCost, CycleCounter, NoWatchdog};
use spindle_bearing::monitor::{Monitor, Readings};

#[path = "../../../examples/monitor_settings.rs"]
#[allow(dead_code, reason = "the firmware has more of them")]
pub mod monitor_settings;
#[path = "../../../examples/monitored.rs"]
mod monitored;

type Precision = f32;
const CORE_HZ: u32 = 168_000_000;
const COST: CycleCost = CycleCost::CORTEX_M4F;

/// No cycle is counted.
struct NoCycles;

impl CycleCounter for NoCycles {
    fn cycles(&mut self) -> u32 {
        0
    }
}

/// The bytes that the monitor sends while the rows of a recording come in at their times.
pub fn stream(rows: &[LoadRow]) -> Vec<u8> {
    let mut monitor: Monitor<BALLS> = Monitor::new(&BEARING, &MONITOR);
    // A start without a solution is one that the first ticks make up for.
    let _ = monitor.prepare(IDLE, 0.0);
    let period = u64::from(MONITOR.tick.period_us);
    let mut bytes = Vec::new();
    let (mut time_us, mut rows) = (0, rows.iter().peekable());
    while rows.peek().is_some() {
        let mut newest = None;
        while let Some(row) = rows.next_if(|row| row.time_s * 1e6 <= time_us as f64 + 0.5) {
            newest = Some(row);
        }
        let loads = newest.map(|row| LoadSample {
            time_us,
            load: row.load.map(|load| load as f32),
            speed: Some((row.speed_rpm * std::f64::consts::PI / 30.0) as f32),
            residual: 0.0,
            doubts: Marks::NONE,
        });
        let readings = Readings {
            loads: Ok(loads),
            speed: None,
        };
        monitor.tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
        bytes.extend(core::iter::from_fn(|| monitor.outbox().next_byte()));
        time_us += period;
    }
    bytes
}
