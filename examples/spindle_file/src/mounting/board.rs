//! The spindle and its monitor as a board has them: of a spindle's file, for the firmware's build and for hosts.

use super::{DynSolver, Parts, closed, growths};
use crate::designs::DesignFileError;
use crate::monitors::MonitorFile;
use crate::plan::{BuildError, ElasticShaft, MOST_ROWS, Plan};
use crate::spindles::SpindleFile;
use spindle_bearing::{Growth, LifeRating, Limits, Settings, Speed, Static, Support};
use spindle_monitor::judgement::{Threshold, Thresholds};
use spindle_monitor::plausibility::PlausibilitySettings;
use spindle_monitor::settings::TelemetrySettings;
use spindle_monitor::tick::{Core, TickSettings};
use spindle_monitor::{
    Alarm, MonitorSettings, RowSettings, ShaftSettings, TemperatureSettings, WatchSettings,
};
use std::array::from_fn;

/// The plan that a board has: a mounted preload as closures, constant loads on the shaft, and positions as in the file.
///
/// # Errors
///
/// Why it cannot be built in the board's precision, or not be monitored; why not in the ticks of this core, if there is one.
pub fn plan(file: &SpindleFile, core: Option<Core>) -> Result<Plan, DesignFileError> {
    let explained = |error: BuildError| file.explain(&error);
    let mut plan = closed(&file.plan).map_err(explained)?;
    // First as `cargo replay` builds it, which gives its messages.
    idle(file, &plan).map_err(explained)?;
    let constant = file.constant_loads();
    if plan.shaft.is_none() && !constant.is_empty() {
        // A shaft without sections is rigid, and takes them.
        plan.shaft = Some(ElasticShaft {
            loads: constant,
            ..ElasticShaft::of(Vec::new(), vec![Support::RIGID; plan.rows.len()])
        });
    }
    if let Some(shaft) = &mut plan.shaft {
        // The monitor's settings say where loads act.
        shaft.loaded_at = 0.0;
    }
    check(file, &plan, core).map_err(explained)?;
    Ok(plan)
}

/// Refuses a spindle that has no equilibrium when it idles, from which the monitor starts.
fn idle(file: &SpindleFile, plan: &Plan) -> Result<(), BuildError> {
    let parts = Parts::of(plan)?;
    let spindle = parts.spindle(plan)?;
    let growth: Vec<_> = file.growths().iter().map(|of| of[0]).collect();
    let at = Speed::rad_per_s(0.0).with_growth(growths(&growth));
    let mut solver = DynSolver::<f64, Static>::of();
    let solved = solver.solve(&spindle, file.monitor.idle, at, &Settings::DEFAULT);
    solved.map(|_| ()).map_err(|status| {
        BuildError::Spindle(format!(
            "the idling spindle, from which the monitor starts, has no equilibrium ({status}): give a preload, or the loads of \
             idling in [monitor.idle]"
        ))
    })
}

/// Refuses settings that are not in order, and a spindle whose solve takes more time than a tick of the core has.
fn check(file: &SpindleFile, plan: &Plan, core: Option<Core>) -> Result<(), BuildError> {
    let error = |text: String| Err(BuildError::Spindle(text));
    let parts = Parts::<f32>::of(plan)?;
    let counts: Vec<u16> = parts.spindle(plan)?.ball_counts().collect();
    let settings = settings(file, &core.unwrap_or(Core::STM32F405));
    if let Err(wrong) = settings.check() {
        return error(wrong.to_string());
    }
    let (rows, most) = (counts.len(), counts.into_iter().max().unwrap_or_default());
    if let Some(Core { chip, .. }) = core
        && !settings.tick.has_time(rows, most.into())
    {
        return error(format!(
            "a tick of {} ms on the {chip} has no time for parts of a solve with {rows} rows of {most} balls: give a longer `period_ms` \
             in [monitor]",
            settings.tick.period_us / 1000
        ));
    }
    Ok(())
}

/// The settings of the monitor of a file, on this core. Beyond its rows, they are those of the last one.
pub fn settings(file: &SpindleFile, core: &Core) -> MonitorSettings<MOST_ROWS> {
    let MonitorFile {
        period_us,
        plausible,
        overload,
        accuracy,
        alarms,
        temperatures: t,
        telemetry,
        ..
    } = &file.monitor;
    let (growths, ratings) = (file.growths(), file.ratings());
    let nose = file.noses.first().map(|nose| nose.end);
    let levels = |alarm: Alarm| &alarms[alarm as usize];
    let threshold = |alarm| {
        let of = levels(alarm);
        Threshold {
            raise: of.limit as f32,
            clear: of.clear as f32,
            hold_us: of.hold_us,
            at_once: of.at_once as f32,
            worse: of.worse as f32,
        }
    };
    // The reader's bounds are those of 16 bits.
    let count = |x: u32| u16::try_from(x).unwrap_or(u16::MAX);
    MonitorSettings {
        rows: from_fn(|i| {
            let i = i.min(growths.len() - 1);
            let LifeRating { inner, outer } = ratings[i];
            let [growth, warm_inner, warm_outer, rotation] = growths[i].map(Growth::to_f32);
            RowSettings {
                rating: LifeRating {
                    inner: inner as f32,
                    outer: outer as f32,
                },
                growth,
                heat: [warm_inner, warm_outer],
                rotation,
            }
        }),
        shaft: ShaftSettings {
            loads_at: file.loaded_at() as f32,
            nose: nose.map_or(0.0, |nose| nose.position) as f32,
            flexibility: narrow(nose.map_or([0.0; 5], |nose| nose.flexibility)),
        },
        temperatures: file.heat.map(|heat| TemperatureSettings {
            reference: heat.reference as f32,
            range: narrow(t.range),
            difference: t.difference as f32,
            rate: t.rate as f32,
            noise: t.noise as f32,
            missing_after_us: t.missing_after_us,
            hold_us: t.hold_us,
            warm: narrow(t.warm),
        }),
        tick: TickSettings::new(
            *period_us,
            core.hz,
            core.cost.with_probes(file.probes.len()),
        ),
        tolerance: Settings::<f32>::TICK.tolerance,
        accuracy: narrow(*accuracy),
        plausibility: PlausibilitySettings {
            load: plausible.load.map(narrow),
            load_rate: narrow(plausible.load_rate),
            stuck_after: count(plausible.stuck_after),
            missing_after_us: plausible.missing_after_us,
            fresh_us: plausible.fresh_us,
            residual: plausible.residual as f32,
            speed: plausible.speed as f32,
            speed_rate: plausible.speed_rate as f32,
            deceleration: plausible.deceleration as f32,
            speed_stuck_after: count(plausible.speed_stuck_after),
            speed_difference: narrow(plausible.speed_difference),
        },
        watch: WatchSettings {
            overload: narrow(*overload),
            limits: Limits {
                peak_pressure: levels(Alarm::PeakPressure).limit as f32,
                friction: levels(Alarm::Slip).limit as f32,
            },
        },
        alarms: Thresholds {
            peak_pressure: threshold(Alarm::PeakPressure),
            contact_angle: threshold(Alarm::ContactAngle),
            slip: threshold(Alarm::Slip),
            unloaded_balls: threshold(Alarm::UnloadedBalls),
            preload_growth: threshold(Alarm::PreloadGrowth),
            preload_loss: threshold(Alarm::PreloadLoss),
            overload: threshold(Alarm::Overload),
            life_used: threshold(Alarm::LifeUsed),
            sensor: threshold(Alarm::Sensor),
            temperature: threshold(Alarm::Temperature),
            availability: threshold(Alarm::Availability),
            deadline: threshold(Alarm::Deadline),
            stiffness_loss: threshold(Alarm::StiffnessLoss),
            stiffness_gain: threshold(Alarm::StiffnessGain),
            probe: threshold(Alarm::Probe),
        },
        telemetry: TelemetrySettings {
            estimate_us: telemetry.estimate_us,
            balls_us: telemetry.balls_us,
            health_us: telemetry.health_us,
            standing_us: telemetry.standing_us,
        },
    }
}

fn narrow<const N: usize>(all: [f64; N]) -> [f32; N] {
    all.map(|x| x as f32)
}
