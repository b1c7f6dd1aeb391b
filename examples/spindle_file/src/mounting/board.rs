//! The spindle and its monitor as a board has them: of a spindle's file, for the firmware's build and for hosts.

use super::{DynSolver, Parts, closed, growths};
use crate::designs::DesignFileError;
use crate::plan::{BuildError, ElasticShaft, MOST_ROWS, Plan};
use crate::spindles::SpindleFile;
use spindle_bearing::{Growth, LifeRating, Settings, Speed, Static, Support};
use spindle_monitor::tick::{Core, TickSettings};
use spindle_monitor::{MonitorSettings, RowSettings, ShaftSettings};
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
    let idle = file.sensors.idle.map(f64::from);
    let solved = solver.solve(&spindle, idle, at, &Settings::DEFAULT);
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
    let settings = file.settings(&core.unwrap_or(Core::STM32F405));
    if let Err(wrong) = settings.check() {
        return error(wrong.to_string());
    }
    let (rows, most) = (counts.len(), counts.into_iter().max().unwrap_or_default());
    if let Some(Core { chip, .. }) = core
        && !(settings.tick.has_time(rows, most.into())
            && (file.probes.is_empty() || settings.tick.has_time_for_probes(rows, most.into())))
    {
        return error(format!(
            "a tick of {} ms on the {chip} has no time for parts of a solve with {rows} rows of {most} balls, or of its probes: \
             give a longer `period_ms` in [monitor], or fewer probes",
            f64::from(settings.tick.period_us) / 1e3
        ));
    }
    Ok(())
}

impl SpindleFile {
    /// Settings of its monitor on this core. Beyond its rows, they are those of the last one.
    pub fn settings(&self, core: &Core) -> MonitorSettings<MOST_ROWS> {
        let (growths, ratings) = (self.growths(), self.ratings());
        let nose = self.noses.first().map(|nose| nose.end);
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
                loads_at: self.loaded_at() as f32,
                nose: nose.map_or(0.0, |nose| nose.position) as f32,
                flexibility: nose.map_or([0.0; 5], |nose| nose.flexibility.map(|x| x as f32)),
            },
            tick: TickSettings::new(
                self.monitor.tick.period_us,
                core.hz,
                core.cost.with_probes(self.probes.len()),
            ),
            ..self.monitor
        }
    }
}
