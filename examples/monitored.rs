//! The bearing on the monitored spindle: one place for the firmware and for the host program that
//! checks it. Whoever includes it says in which precision the solver works, and how
//! fast.

use super::{CORE_HZ, COST, Precision};
use core::f64::consts::PI;
use spindle_bearing::monitor::settings::MonitorSettings;
use spindle_bearing::{Bearing, Design, FreeContact, Material};

/// Ball count.
pub const BALLS: usize = 16;

/// A B7005C of steel, SI units.
pub const DESIGN: Design = Design {
    ball_diameter: 6.35e-3,
    pitch_diameter: 36e-3,
    inner_groove_factor: 0.515,
    outer_groove_factor: 0.525,
    free_contact: FreeContact::Angle(15.0 * PI / 180.0),
    inner_shoulder_angle: 48.0 * PI / 180.0,
    outer_shoulder_angle: 47.5 * PI / 180.0,
    first_ball: 0.0,
    ring: Material::STEEL,
    ball: Material::STEEL,
};

/// Its constants, worked out by the compiler.
pub static BEARING: Bearing<Precision, BALLS> = Bearing::<Precision, BALLS>::checked(&DESIGN);

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
