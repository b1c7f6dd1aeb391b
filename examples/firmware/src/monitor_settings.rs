//! The monitor's settings on this spindle: one place for the firmware and for the host program that checks
//! it.

use crate::bridges::Calibration;
use crate::monitored::{BALLS, BORE, DESIGN, FACINGS, POSITIONS, PRELOAD, ROWS};
use crate::tachometer::SpeedSettings;
use spindle_bearing::{Expansion, Facing, Settings};
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::tick::CycleCost;
use spindle_monitor::{Identity, TemperatureSettings};

/// Loads of the idling spindle (N, N m), to start from: none on a pair, the springs' preload on a single bearing.
pub const IDLE: [f32; 5] = match ROWS {
    1 => [PRELOAD as f32, 0.0, 0.0, 0.0, 0.0],
    _ => [0.0; 5],
};

/// The maker's basic dynamic load rating `C` of a bearing, N, if that is known. The formula that stands in for it is 5 % to
/// 8 % high, and the life by it up to 25 % long.
const LOAD_RATING: Option<f64> = None;

/// Preload of the mounted pair, cold and at rest, N: the housing gives way. A test holds it against the spindle.
const MOUNTED_PRELOAD: f32 = 225.0;
/// Of shaft, housing, rings and balls.
const EXPANSION: Expansion = Expansion::STEEL;

/// Period of a tick, us.
pub const PERIOD_US: u32 = 1000;

/// Rate, doubts, alarms and telemetry on a core of this frequency, with these costs of a tick. What is particular to this
/// spindle is set here. For a constant: settings out of order do not compile.
///
/// # Panics
///
/// The settings are out of order, or a tick has no time to solve.
pub const fn monitor_settings(core_hz: u32, cost: CycleCost) -> MonitorSettings<ROWS> {
    let mut settings = MonitorSettings::new(&DESIGN, BALLS);
    if ROWS == 1 {
        of_a_bearing(&mut settings);
    } else {
        of_a_pair(&mut settings);
    }
    if let Some(rating) = LOAD_RATING {
        let mut row = 0;
        while row < ROWS {
            settings.rows[row] = settings.rows[row].with_rating(&DESIGN, BALLS, rating);
            row += 1;
        }
    }
    // Records may come from a tachometer, too.
    settings.plausibility.deceleration = TACHOMETER.deceleration;
    if BRIDGES {
        // A tachometer's speed is measured, and is never quite the same for ten seconds.
        settings.plausibility.speed_stuck_after = 10_000;
    }
    // All of a tick's time.
    settings.tick.period_us = PERIOD_US;
    settings.tick.deadline_cycles = core_hz / 1_000_000 * PERIOD_US;
    settings.tick.cost = cost;
    // That of a tick: the stated error of the stiffness is 5e-3 at most.
    settings.tolerance = Settings::<f32>::TICK.tolerance;
    assert!(settings.tick.has_time(ROWS, BALLS));
    match settings.check() {
        Ok(()) => settings,
        Err(error) => panic!("{}", error.field),
    }
}

/// Loads at the nose, and what heat and speed make of the rows.
const fn of_a_pair(settings: &mut MonitorSettings<ROWS>) {
    let middle = 0.5 * (POSITIONS[0] + POSITIONS[ROWS - 1]);
    let mut row = 0;
    while row < ROWS {
        let ahead = POSITIONS[row] - middle;
        let reach = match FACINGS[row] {
            Facing::PlusX => ahead,
            Facing::MinusX => -ahead,
        };
        settings.rows[row] = settings.rows[row]
            .with_heat(&DESIGN, &EXPANSION, reach)
            .with_rotation(&DESIGN, BORE);
        row += 1;
    }
    settings.temperatures = Some(TemperatureSettings::SPINDLE);
    settings.watch.preload = MOUNTED_PRELOAD;
    // In normal use. A cutter 50 mm in front of the nose makes moments.
    settings.plausibility.load = [
        [-1700.0, 1700.0],
        [-1700.0, 1700.0],
        [-1700.0, 1700.0],
        [-85.0, 85.0],
        [-85.0, 85.0],
    ];
    // A tooth of 550 N that is there from one tick to the next, and a fifth more.
    settings.plausibility.load_rate = [6.6e5, 6.6e5, 6.6e5, 3.3e4, 3.3e4];
    // What is beyond that range has no estimate, but an alarm.
    settings.watch.overload = [1700.0, 1700.0, 1700.0, 85.0, 85.0];
}

/// Loads on the bearing itself.
const fn of_a_bearing(settings: &mut MonitorSettings<ROWS>) {
    settings.plausibility.load = [
        [-500.0, 3e3],
        [-3e3, 3e3],
        [-3e3, 3e3],
        [-60.0, 60.0],
        [-60.0, 60.0],
    ];
    // A tooth of 1,000 N that is there from one tick to the next, and a fifth more.
    settings.plausibility.load_rate = [1.2e6, 1.2e6, 1.2e6, 2e4, 2e4];
    settings.watch.overload = [3e3, 3e3, 3e3, 60.0, 60.0];
}

/// Whose life and alarms are kept over a power cycle: another spindle does not take them.
pub const IDENTITY: Identity = {
    let first = Identity::new(&DESIGN, BALLS);
    if ROWS == 1 {
        first
    } else {
        first.mounted(&POSITIONS, &FACINGS, PRELOAD)
    }
};

/// Whether loads and speed come from strain bridges and a tachometer at the board, not as records over
/// the port. Set it here, or build with `SPINDLE_SENSORS=bridges` in the environment.
pub const BRIDGES: bool = option_env!("SPINDLE_SENSORS").is_some();

/// Whether the firmware programs the highest brown-out level into the chip's option bytes.
///
/// They stay so whatever is flashed later. Set it here, or build with `SPINDLE_BROWN_OUT=set` in the environment.
pub const SET_BROWN_OUT: bool = option_env!("SPINDLE_BROWN_OUT").is_some();

/// Six bridges, by `cargo calibrate`: **to be replaced by your spindle's**.
/// These are of bridges that each see one load, the sixth one all forces (`host_tests/bridges.csv`). Condition 1.04.
pub const CALIBRATION: Calibration<6> = {
    let mut calibration = Calibration::new(
        [
            [
                1.653_846_1e-3,
                -3.461_538_6e-4,
                -3.461_538_6e-4,
                0.0,
                0.0,
                5.769_231e-4,
            ],
            [
                -3.461_538_6e-4,
                1.653_846_1e-3,
                -3.461_538_6e-4,
                0.0,
                0.0,
                5.769_231e-4,
            ],
            [
                -3.461_538_6e-4,
                -3.461_538_6e-4,
                1.653_846_1e-3,
                0.0,
                0.0,
                5.769_231e-4,
            ],
            [0.0, 0.0, 0.0, 5e-5, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 5e-5, 0.0],
        ],
        [
            [500.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 500.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 500.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 2e4, 0.0],
            [0.0, 0.0, 0.0, 0.0, 2e4],
            [300.0, 300.0, 300.0, 0.0, 0.0],
        ],
    );
    // The springs' preload, which no bridge can tell from its zero.
    calibration.standing = IDLE;
    calibration
};
const _: () = assert!(CALIBRATION.check().is_ok());

/// Samples of a tare.
pub const TARE_SAMPLES: u16 = 1000;

/// The tachometer's pulses, at a timer of 1 MHz.
pub const TACHOMETER: SpeedSettings = SpeedSettings {
    pulses_per_revolution: 4,
    timer_hz: 1_000_000,
    timer_bits: 32,
    counter_bits: 32,
    count_above: 400.0,
    period_below: 300.0,
    gate_us: 5000,
    standstill_us: 500_000,
    deceleration: 4000.0,
};
