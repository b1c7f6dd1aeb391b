//! Everything that fits a monitor to one spindle, in one place, for the compiler to check.

use crate::alarms::{Alarm, Rhythm, Threshold};
use crate::command::MOST_PROBES;
use crate::plausibility::PlausibilitySettings;
use crate::preload::PreloadLaw;
use crate::revolutions;
use crate::temperature::TemperatureSettings;
use crate::tick::{CycleCost, TickSettings};
use crate::watch::SECOND_US;
use core::f64::consts::PI;
use core::fmt;
use spindle_bearing::{Design, Expansion, Growth, LifeRating, Limits, Settings};

/// How often telemetry goes out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TelemetrySettings {
    /// Time between estimates, us.
    pub estimate_us: u32,
    /// Time between pictures of all balls, us.
    pub balls_us: u32,
    /// Time between health reports, us.
    pub health_us: u32,
    /// Time after which an alarm that stands is sent again, us.
    pub standing_us: u32,
}

/// Data of a row that the monitor needs besides its solver's.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RowSettings {
    /// The contacts' dynamic load ratings.
    pub rating: LifeRating,
    /// Growth of the cold bearing at rest, besides that of its preload.
    pub growth: Growth<f32>,
    /// Growth per K of the inner and of the outer side.
    pub heat: [Growth<f32>; 2],
    /// Growth per square of the speed, (rad/s)^2.
    pub rotation: Growth<f32>,
}

impl RowSettings {
    /// A bearing of `balls` balls, with the load rating of [`Design::dynamic_load_rating`]. It does not grow.
    ///
    /// Where the maker's `C` is known, [`RowSettings::of`] takes it: the formula is 5 % to 8 % high, and the life by it up to
    /// 25 % long.
    pub const fn new(design: &Design, balls: usize) -> Self {
        let dynamic = design.dynamic_load_rating(balls);
        Self::of(LifeRating::<f32>::new(design, balls, dynamic))
    }

    /// A bearing whose contacts have these dynamic load ratings. It does not grow.
    pub const fn of(rating: LifeRating<f32>) -> Self {
        Self {
            rating,
            growth: Growth::NONE,
            heat: [Growth::NONE; 2],
            rotation: Growth::NONE,
        }
    }

    /// Lets the row grow with the temperatures of both sides: [`Growth::by_temperatures`].
    /// `reach` is as for [`Growth::by_length`].
    #[must_use]
    pub const fn with_heat(self, design: &Design, expansion: &Expansion, reach: f64) -> Self {
        let inner = Growth::by_temperatures(design, expansion, reach, [1.0, 0.0]);
        let outer = Growth::by_temperatures(design, expansion, reach, [0.0, 1.0]);
        let heat = [inner.to_f32(), outer.to_f32()];
        Self { heat, ..self }
    }

    /// Lets the row grow with the speed on a hollow shaft, whose bore has this diameter (m). A bore that reaches the groove
    /// is refused by [`MonitorSettings::check`].
    #[must_use]
    pub const fn with_rotation(self, design: &Design, bore_diameter: f64) -> Self {
        let rotation = Growth::by_rotation(design, bore_diameter, 1.0).to_f32();
        Self { rotation, ..self }
    }
}

/// Where on the shaft loads are measured and stiffness is wanted: positions along the axis of the
/// [`Spindle`](spindle_bearing::Spindle).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftSettings {
    /// The point that the measured moments are about, m: the flange, or the nose.
    pub loads_at: f32,
    /// The point to which displacement and stiffness belong, m.
    pub nose: f32,
    /// Flexibility of a rigid shaft's own end there: displacement of each freedom (m, rad) per its force (N) or moment (N m).
    pub flexibility: [f32; 5],
}

/// Everything that fits a monitor to one spindle with `R` rows of balls.
///
/// ```
/// use spindle_monitor::settings::MonitorSettings;
/// use spindle_bearing::Design;
/// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// static SETTINGS: MonitorSettings = MonitorSettings::new(&DESIGN, 16);
/// // A setting that is out of order does not compile.
/// const _: () = match SETTINGS.check() {
///     Ok(()) => {}
///     Err(error) => panic!("{}", error.field),
/// };
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MonitorSettings<const R: usize = 1> {
    /// Settings of the rows, in their order.
    pub rows: [RowSettings; R],
    /// Where loads are measured and stiffness is wanted.
    pub shaft: ShaftSettings,
    /// Settings of temperatures; none if they are not measured: the rows grow with the speed alone.
    pub temperatures: Option<TemperatureSettings>,
    /// Rate and deadline.
    pub tick: TickSettings,
    /// Largest estimated error of the stiffness that counts as solved, relative.
    pub tolerance: f32,
    /// Accuracy of the measured loads, N, N m: by how much each may be off. A load with 0 adds nothing to the displacement's error.
    pub accuracy: [f32; 5],
    /// Bounds of plausible loads and speeds.
    pub plausibility: PlausibilitySettings,
    /// Largest amount of each load that the spindle may carry, N, N m.
    pub overload: [f32; 5],
    /// When alarms are raised, in the order of [`Alarm`].
    pub alarms: [Threshold; Alarm::COUNT],
    /// How often telemetry goes out.
    pub telemetry: TelemetrySettings,
}

/// A probe that sees the shaft against the housing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ProbeSettings {
    /// Position along the axis, m.
    pub position: f32,
    /// Unit vector of the displacement that it sees, in the shaft's frame.
    pub direction: [f32; 3],
    /// Accuracy of a reading, um.
    pub accuracy: f32,
    /// Displacement that it sees by a newton of each load, moments as forces at 50 mm, where loads are measured: the root of the sum of their
    /// squares, um/N.
    pub compliance: f32,
}

impl ProbeSettings {
    /// Whether it sees the shaft move along its axis.
    pub(crate) const fn is_axial(&self) -> bool {
        let [_, y, z] = self.direction;
        y == 0.0 && z == 0.0
    }

    /// The directions along and across a probe that is turned by an angle, rad, within some tenths.
    pub(crate) fn directions(&self, angle: f32) -> [[f32; 3]; 2] {
        let [x, y, z] = self.direction;
        // By half of the angle: its tangent.
        let half = 0.5 * angle + angle * angle * angle / 24.0;
        let per = 1.0 / (1.0 + half * half);
        let [cos, sin] = [(1.0 - half * half) * per, 2.0 * half * per];
        let [along_y, along_z] = [cos * y - sin * z, cos * z + sin * y];
        [[x, along_y, along_z], [0.0, -along_z, along_y]]
    }
}

/// Settings of the estimates by `P` probes ([`crate::estimator`]).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ResponseSettings<const P: usize> {
    /// The probes.
    pub probes: [ProbeSettings; P],
    /// The preload of the spindle; none where no rows oppose each other.
    pub preload: Option<PreloadLaw>,
    /// Accuracy of the difference of both sides' temperatures since commissioning, K; 0 where they are not measured.
    pub heat: f32,
    /// Accuracy of a load step, part of it.
    pub load_error: f32,
    /// Accuracy of a probe's gain, part of it.
    pub gain: f32,
}

impl ResponseSettings<0> {
    /// No probes.
    pub const NONE: Self = Self {
        probes: [],
        preload: None,
        heat: 0.0,
        load_error: 0.02,
        gain: 0.1,
    };
}

impl<const P: usize> ResponseSettings<P> {
    /// Whether the settings are in order: for the compiler to ask.
    ///
    /// # Errors
    ///
    /// The first field that is out of order, and its condition.
    pub const fn check(&self) -> Result<(), SettingsError> {
        let (mut positions, mut directions, mut accuracies, mut compliances) =
            (true, true, true, true);
        let mut i = 0;
        while i < P {
            let probe = &self.probes[i];
            let [x, y, z] = probe.direction;
            let square = x * x + y * y + z * z;
            positions &= probe.position.is_finite();
            directions &= square > 0.999 && square < 1.001;
            accuracies &= positive(probe.accuracy);
            compliances &= amount(probe.compliance);
            i += 1;
        }
        let law = match &self.preload {
            Some(law) => law.is_sound(),
            None => true,
        };
        #[rustfmt::skip]
        let demands = [
            (P <= MOST_PROBES, "probes", "four at most"),
            (positions, "probes.position", "a number of metres"),
            (directions, "probes.direction", "a unit vector"),
            (accuracies, "probes.accuracy", "positive"),
            (compliances, "probes.compliance", "numbers, not below 0"),
            (law, "preload", "a positive force, and finite closures that rise"),
            (amount(self.heat), "heat", "a number, not below 0"),
            (amount(self.load_error), "load_error", "a number, not below 0"),
            (positive(self.gain), "gain", "positive"),
        ];
        first_broken(&demands)
    }
}

/// A setting that is out of order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SettingsError {
    /// Path of the field, as in code.
    pub field: &'static str,
    /// Condition on the field, in words that follow "must be".
    pub must: &'static str,
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} must be {}", self.field, self.must)
    }
}

impl core::error::Error for SettingsError {}

/// Ticks in which an estimate is due after another one: a solve under passing teeth takes 9 at most, and a sample that it keeps
/// waiting as many again; and two of a sender that is slower than ticks.
const ESTIMATE_TICKS: u32 = 20;

/// Above 0, and a number.
const fn positive(x: f32) -> bool {
    x > 0.0 && x.is_finite()
}

/// A number, and not below 0.
const fn amount(x: f32) -> bool {
    x >= 0.0 && x.is_finite()
}

/// Low, then high, both of them numbers.
const fn is_range([low, high]: [f32; 2]) -> bool {
    low < high && low.is_finite() && high.is_finite()
}

const fn all_finite(all: &[f32]) -> bool {
    let (mut are, mut i) = (true, 0);
    while i < all.len() {
        are &= all[i].is_finite();
        i += 1;
    }
    are
}

const fn is_finite(growth: &Growth<f32>) -> bool {
    all_finite(&[growth.axial, growth.radial, growth.ball])
}

/// The first demand that does not hold: its field, and its condition.
const fn first_broken(demands: &[(bool, &'static str, &'static str)]) -> Result<(), SettingsError> {
    let mut i = 0;
    while i < demands.len() {
        let (holds, field, must) = demands[i];
        if !holds {
            return Err(SettingsError { field, must });
        }
        i += 1;
    }
    Ok(())
}

/// Largest plausible forces `Fx, Fy, Fz` (N) and moments `My, Mz` (N m) of a spindle, by the sum of its rows' basic dynamic load
/// ratings `C` (N) and their mean pitch diameter `dm` (m).
///
/// Forces are 6 % of the sum: `L10` of 4,600 million revolutions under such a load, shared by the rows. Moments are that force on
/// an arm of `1.4 dm`, a cutter in front of the nose.
const fn largest_loads(ratings: f64, pitch_diameter: f64) -> [f64; 5] {
    let force = 0.06 * ratings;
    let moment = force * 1.4 * pitch_diameter;
    [force, force, force, moment, moment]
}

/// Fastest change of a load in a second, over half of its range: a tooth of a third of that half in a tick, and a fifth more.
const LOAD_RATE: f64 = 400.0;

/// Highest plausible speed (rad/s) of a spindle with this largest pitch diameter `dm` (m): `n dm = 1.8e6 mm/min`, of fast spindles
/// with oil and air.
const fn largest_speed(pitch_diameter: f64) -> f64 {
    rad_per_s(1.8e6 / (1e3 * pitch_diameter))
}

const fn rad_per_s(rpm: f64) -> f64 {
    rpm * PI / 30.0
}

impl<const R: usize> MonitorSettings<R> {
    /// Settings to start from, for bearings of `balls` balls, all of one design, on a machine tool's spindle: those of
    /// [`MonitorSettings::of`], with the load ratings of [`RowSettings::new`].
    pub const fn new(design: &Design, balls: usize) -> Self {
        let bearing = [design.dynamic_load_rating(balls), design.pitch_diameter];
        Self::of([RowSettings::new(design, balls); R], &[bearing; R])
    }

    /// Settings to start from, which those of a spindle's file are by default: by the basic dynamic load rating `C` (N) and the pitch
    /// diameter `dm` (m) of each bearing on the shaft.
    ///
    /// Loads are sampled at 1 kHz and solved at every tick on a Cortex-M4F at 168 MHz, thresholds are on the safe side. Ranges, rates
    /// and overload follow from the bearings: narrow them to your spindle's.
    pub const fn of(rows: [RowSettings; R], bearings: &[[f64; 2]]) -> Self {
        let (mut ratings, mut pitches, mut largest) = (0.0, 0.0, 0.0_f64);
        let mut i = 0;
        while i < bearings.len() {
            let [rating, pitch] = bearings[i];
            (ratings, pitches, largest) = (ratings + rating, pitches + pitch, largest.max(pitch));
            i += 1;
        }
        let mut settings = Self {
            rows,
            shaft: ShaftSettings {
                loads_at: 0.0,
                nose: 0.0,
                flexibility: [0.0; 5],
            },
            temperatures: None,
            tick: TickSettings {
                period_us: 1000,
                deadline_cycles: 168_000,
                cost: CycleCost::CORTEX_M4F,
            },
            tolerance: Settings::<f32>::TICK.tolerance,
            accuracy: [0.0; 5],
            plausibility: PlausibilitySettings {
                load: [[0.0; 2]; 5],
                load_rate: [0.0; 5],
                stuck_after: 100,
                missing_after_us: 50_000,
                fresh_us: 20_000,
                residual: None,
                speed: largest_speed(largest) as f32,
                speed_rate: (1e3 * rad_per_s(191.0)) as f32,
                deceleration: rad_per_s(38_200.0) as f32,
                speed_stuck_after: 0,
                speed_difference: [rad_per_s(95.5) as f32, 0.02],
            },
            overload: [0.0; 5],
            alarms: Alarm::usual_thresholds(),
            telemetry: TelemetrySettings {
                estimate_us: 20_000,
                balls_us: 100_000
                    * if bearings.len() < 2 {
                        2
                    } else {
                        bearings.len() as u32
                    },
                health_us: 1_000_000,
                standing_us: 10_000_000,
            },
        };
        let most = largest_loads(ratings, pitches / bearings.len() as f64);
        let mut i = 0;
        while i < 5 {
            settings.set_range(i, [-most[i], most[i]]);
            i += 1;
        }
        settings
    }

    /// Sets the plausible range of a load, N or N m, and what follows from it: the fastest change, the overload (the larger amount of
    /// the range: what is beyond it has no estimate, but an alarm), and the accuracy (1 % of that, a good sensor's).
    pub const fn set_range(&mut self, load: usize, [low, high]: [f64; 2]) {
        let most = low.abs().max(high.abs());
        self.plausibility.load[load] = [low as f32, high as f32];
        self.plausibility.load_rate[load] = (LOAD_RATE * 0.5 * (high - low)) as f32;
        self.overload[load] = most as f32;
        self.accuracy[load] = (0.01 * most) as f32;
    }

    /// Limits of contacts that estimates report when they are passed: those of the alarms.
    pub const fn limits(&self) -> Limits<f32> {
        Limits {
            peak_pressure: self.alarms[Alarm::PeakPressure as usize].raise,
            friction: self.alarms[Alarm::Slip as usize].raise,
        }
    }

    /// Time in which a level of an alarm is followed by the next one, us, at most: for so long it stands.
    pub const fn due_us(&self, alarm: Alarm) -> u32 {
        match alarm.rhythm() {
            Rhythm::Estimate => self.tick.period_us.saturating_mul(ESTIMATE_TICKS),
            Rhythm::Sample => self.plausibility.missing_after_us,
            Rhythm::Tick => SECOND_US,
            Rhythm::Block => revolutions::longest_us(self.tick.period_us),
        }
    }

    /// Whether the settings are in order: for the compiler to ask.
    ///
    /// # Errors
    ///
    /// The first field that is out of order, and its condition.
    pub const fn check(&self) -> Result<(), SettingsError> {
        let (mut ratings, mut growths, mut i) = (true, true, 0);
        while i < R {
            let RowSettings {
                rating,
                growth,
                heat: [inner, outer],
                rotation,
            } = &self.rows[i];
            ratings &= positive(rating.inner) && positive(rating.outer);
            growths &=
                is_finite(growth) && is_finite(inner) && is_finite(outer) && is_finite(rotation);
            i += 1;
        }
        let (shaft, p, t, s) = (&self.shaft, &self.plausibility, &self.tick, &self.telemetry);
        let (mut flexibility, mut loads, mut rates) = (true, true, true);
        let (mut accuracy, mut overload, mut i) = (true, true, 0);
        while i < 5 {
            flexibility &= amount(shaft.flexibility[i]);
            loads &= is_range(p.load[i]);
            rates &= positive(p.load_rate[i]);
            accuracy &= amount(self.accuracy[i]);
            overload &= positive(self.overload[i]);
            i += 1;
        }
        let (mut alarms, mut i) = (true, 0);
        while i < Alarm::COUNT {
            alarms &= self.alarms[i].is_sound();
            i += 1;
        }
        let heat = match self.temperatures {
            Some(temperatures) => temperatures,
            None => TemperatureSettings::SPINDLE,
        };
        let [inner, outer] = heat.warm;
        let [absolute, relative] = p.speed_difference;
        let residual = match p.residual {
            Some(residual) => positive(residual),
            None => true,
        };
        let intervals = s.estimate_us > 0 && s.balls_us > 0 && s.health_us > 0 && s.standing_us > 0;
        #[rustfmt::skip]
        let demands = [
            (ratings, "rows.rating", "positive"),
            (growths, "rows.growth, rows.heat, rows.rotation", "numbers"),
            (all_finite(&[shaft.loads_at, shaft.nose]), "shaft", "positions that are numbers"),
            (flexibility, "shaft.flexibility", "numbers, not below 0"),
            (is_range(heat.range), "temperatures.range", "numbers: low, then high"),
            (heat.has(heat.reference), "temperatures.reference", "within the range"),
            (heat.has(inner) && heat.has(outer), "temperatures.warm", "within the range"),
            (positive(heat.rate) && positive(heat.difference), "temperatures.rate, temperatures.difference", "positive"),
            (amount(heat.noise), "temperatures.noise", "a number, not below 0"),
            (heat.hold_us >= heat.missing_after_us, "temperatures.hold_us", "at least missing_after_us"),
            (t.period_us >= 1000 && t.period_us <= 10_000, "tick.period_us", "from 1,000 to 10,000"),
            (t.deadline_cycles > t.cost.tick, "tick.deadline_cycles", "more than a tick without a solve takes"),
            (self.tolerance >= f32::EPSILON && self.tolerance <= 1e-2, "tolerance", "from the precision to 1e-2"),
            (accuracy, "accuracy", "numbers, not below 0"),
            (loads, "plausibility.load", "numbers: low, then high"),
            (rates, "plausibility.load_rate", "positive"),
            (p.stuck_after != 1, "plausibility.stuck_after", "0 or at least 2"),
            (p.speed_stuck_after != 1, "plausibility.speed_stuck_after", "0 or at least 2"),
            (p.missing_after_us >= t.period_us, "plausibility.missing_after_us", "at least a tick"),
            (p.fresh_us >= t.period_us, "plausibility.fresh_us", "at least a tick"),
            (residual, "plausibility.residual", "positive"),
            (positive(p.speed), "plausibility.speed", "positive"),
            (positive(p.speed_rate), "plausibility.speed_rate", "positive"),
            (positive(p.deceleration), "plausibility.deceleration", "positive"),
            (amount(absolute) && amount(relative) && absolute + relative > 0.0, "plausibility.speed_difference", "numbers, not below 0, and not both 0"),
            (overload, "overload", "positive"),
            (alarms, "alarms", "numbers, each to clear below that to raise, at_once not below, worse positive"),
            (intervals, "telemetry", "intervals of at least 1 us"),
        ];
        first_broken(&demands)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preload::{NODES, PreloadBy};
    use spindle_bearing::{FreeContact, Material};

    const DESIGN: Design = Design {
        ball_diameter: 6.35e-3,
        pitch_diameter: 36e-3,
        inner_groove_factor: 0.515,
        outer_groove_factor: 0.525,
        free_contact: FreeContact::Angle(15.0 * core::f64::consts::PI / 180.0),
        inner_shoulder_angle: 0.84,
        outer_shoulder_angle: 0.83,
        first_ball: 0.0,
        ring: Material::STEEL,
        ball: Material::STEEL,
    };

    #[test]
    fn a_setting_that_is_out_of_order_is_named() {
        let good = MonitorSettings::<1>::new(&DESIGN, 16);
        assert_eq!(good.check(), Ok(()));
        type Spoil = fn(&mut MonitorSettings);
        let spoils: [(Spoil, &str); 11] = [
            (|s| s.tick.period_us = 0, "tick.period_us"),
            (
                |s| s.tick.deadline_cycles = s.tick.cost.tick,
                "tick.deadline_cycles",
            ),
            (|s| s.tolerance = f32::NAN, "tolerance"),
            (
                |s| s.plausibility.load[3] = [1.0, f32::NAN],
                "plausibility.load",
            ),
            (
                |s| s.plausibility.residual = Some(f32::NAN),
                "plausibility.residual",
            ),
            (
                |s| s.alarms[Alarm::Deadline as usize].clear = 99.0,
                "alarms",
            ),
            (|s| s.rows[0].rating.outer = f32::INFINITY, "rows.rating"),
            (|s| s.telemetry.health_us = 0, "telemetry"),
            (|s| s.accuracy[4] = f32::NAN, "accuracy"),
            (
                |s| s.rows[0].heat[1].radial = f32::INFINITY,
                "rows.growth, rows.heat, rows.rotation",
            ),
            (
                |s| {
                    s.temperatures = Some(TemperatureSettings {
                        warm: [40.0, 300.0],
                        ..TemperatureSettings::SPINDLE
                    });
                },
                "temperatures.warm",
            ),
        ];
        for (spoil, field) in spoils {
            let mut settings = good;
            spoil(&mut settings);
            assert_eq!(settings.check().unwrap_err().field, field);
        }
    }

    #[test]
    fn a_probe_that_is_out_of_order_is_named() {
        let good = ResponseSettings {
            probes: [ProbeSettings {
                position: -0.01,
                direction: [0.0, 0.6, -0.8],
                accuracy: 0.2,
                compliance: 0.03,
            }],
            preload: Some(PreloadLaw {
                force: 250.0,
                by: PreloadBy::Spring,
            }),
            heat: 0.3,
            load_error: 0.02,
            gain: 0.1,
        };
        assert_eq!(good.check(), Ok(()));
        assert_eq!(ResponseSettings::NONE.check(), Ok(()));
        type Spoil = fn(&mut ResponseSettings<1>);
        let spoils: [(Spoil, &str); 8] = [
            (|s| s.probes[0].position = f32::NAN, "probes.position"),
            (|s| s.probes[0].direction = [0.0; 3], "probes.direction"),
            (|s| s.probes[0].accuracy = 0.0, "probes.accuracy"),
            (|s| s.probes[0].compliance = f32::NAN, "probes.compliance"),
            (
                |s| {
                    s.preload = Some(PreloadLaw {
                        force: 250.0,
                        by: PreloadBy::Closure {
                            rows: 3,
                            closures: [0.0; NODES],
                            heat: [0.0; 2],
                        },
                    });
                },
                "preload",
            ),
            (|s| s.heat = f32::INFINITY, "heat"),
            (|s| s.load_error = -1.0, "load_error"),
            (|s| s.gain = 0.0, "gain"),
        ];
        for (spoil, field) in spoils {
            let mut settings = good;
            spoil(&mut settings);
            assert_eq!(settings.check().unwrap_err().field, field);
        }
    }
}
