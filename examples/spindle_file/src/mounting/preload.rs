//! The law of a spindle's preload, and settings of its probes, for the monitor's estimates.

use super::{DynSolver, Parts, Press, closed, growths};
use crate::designs::DesignFileError;
use crate::plan::{BuildError, Plan};
use crate::spindles::SpindleFile;
use spindle_bearing::{Facing, Growth, Preload, Settings, Speed, Static};
use spindle_monitor::blocks::PER_ARM;
use spindle_monitor::preload::{NODES, POWERS, PreloadBy, PreloadLaw};
use spindle_monitor::{ProbeSettings, ResponseSettings};
use std::array::from_fn;

/// Solves in which a closure is found.
const MOST_SOLVES: usize = 60;
/// A change of closure that shows a slope, m.
const SMALL: f64 = 1e-8;
/// A change of temperature that shows a slope, K.
const KELVIN: f64 = 1.0;

/// Settings of the estimates by the first `P` probes of a file.
///
/// # Errors
///
/// The spindle cannot be built, or has no equilibrium at rest.
pub fn response<const P: usize>(
    file: &SpindleFile,
) -> Result<ResponseSettings<P>, DesignFileError> {
    let explained = |error: BuildError| file.explain(&error);
    let compliances = compliances(file).map_err(explained)?;
    let sensors = &file.sensors;
    Ok(ResponseSettings {
        probes: from_fn(|i| {
            let probe = &file.probes[i];
            ProbeSettings {
                position: probe.position as f32,
                direction: probe.direction.map(|e| e as f32),
                accuracy: probe.accuracy as f32,
                compliance: compliances[i],
            }
        }),
        preload: law(file).map_err(explained)?,
        heat: file.heat.map_or(0.0, |heat| heat.accuracy as f32),
        load_error: sensors.load_error,
        gain: sensors.gain,
    })
}

/// Displacement at each probe by a newton of each load, a moment as a force at 50 mm, where loads are measured: the root of the sum of their
/// squares, um/N. Of the idling spindle at rest.
fn compliances(file: &SpindleFile) -> Result<Vec<f32>, BuildError> {
    let plan = closed(&file.plan)?;
    let parts = Parts::<f64>::of(&plan)?;
    let spindle = parts.spindle(&plan)?;
    let growth: Vec<_> = file.growths().iter().map(|of| of[0]).collect();
    let at = Speed::rad_per_s(0.0).with_growth(growths(&growth));
    let mut solver = DynSolver::<f64, Static>::of();
    let idle = file.sensors.idle.map(f64::from);
    let solution = solver.solve(&spindle, idle, at, &Settings::DEFAULT);
    let solution = solution.map_err(|status| {
        BuildError::Spindle(format!("the idling spindle has no equilibrium: {status}"))
    })?;
    let of_probe = |probe: &crate::probes::Probe| {
        let place = probe.position - plan.loaded_at();
        let c = solution.compliance_at(place);
        let sees = |load: usize| -> f64 {
            let along = probe.direction.iter().zip(&c);
            along.map(|(e, row)| e * row[load]).sum()
        };
        // A force where loads are measured has a moment about the probe.
        let arm = -place;
        let [x, y, z, my, mz] = from_fn(sees);
        let [y, z] = [y + arm * mz, z - arm * my];
        let [my, mz] = [my, mz].map(|c| c / f64::from(PER_ARM));
        (1e6 * (x * x + y * y + z * z + my * my + mz * mz).sqrt()) as f32
    };
    Ok(file.probes.iter().map(of_probe).collect())
}

/// The law of its preload; none where no rows oppose each other.
fn law(file: &SpindleFile) -> Result<Option<PreloadLaw>, BuildError> {
    let plan = &file.plan;
    if let Some(force) = plan.spring {
        let force = force as f32;
        return Ok(Some(PreloadLaw {
            force,
            by: PreloadBy::Spring,
        }));
    }
    let faces = |facing: Facing| plan.rows.iter().any(|row| row.facing == facing);
    if !faces(Facing::PlusX) || !faces(Facing::MinusX) {
        return Ok(None);
    }
    // A force that rows are ground for is theirs on rigid seats.
    let ground = plan.rows.iter().find_map(|row| match row.preload {
        Preload::Force(force) if plan.mounted_preload.is_none() => Some(force),
        _ => None,
    });
    let mut alone = Plan {
        mounted_preload: None,
        ..closed(plan)?
    };
    let growth = file.growths();
    let mut fixed: Vec<Growth<f64>> = growth.iter().map(|of| of[0]).collect();
    if ground.is_some() {
        alone.shaft = None;
        fixed.fill(Growth::NONE);
    }
    if let Some(shaft) = &mut alone.shaft {
        shaft.loads.clear();
    }
    let parts = Parts::<f64>::of(&alone)?;
    let spindle = parts.spindle(&alone)?;
    let mut press = Press::of(&spindle);
    let mut pressed = |growth: &[Growth<f64>], closure: f64| press.force(growth, |_| closure);
    let sum = pressed(&fixed, 0.0);
    let slope = (pressed(&fixed, SMALL) - pressed(&fixed, -SMALL)) / (2.0 * SMALL);
    // Rows that do not press each other at rest have no preload to be a part of.
    if sum <= 0.0 || slope <= 0.0 {
        return Ok(None);
    }
    let [least, step] = POWERS.map(f64::from);
    let scale = sum / slope;
    let mut closures = [0.0; NODES];
    for i in 0..NODES {
        let wanted = sum * (least + step * i as f64).powf(1.5);
        let near = if i == 0 { 0.0 } else { closures[i - 1] };
        closures[i] = match closure_of(|closure| pressed(&fixed, closure), wanted, near, scale) {
            Some(closure) => closure,
            // More than the rows can bear: closure is almost a straight line over the power.
            None if i > 1 => 2.0 * closures[i - 1] - closures[i - 2],
            None => return Ok(None),
        };
    }
    let mut heat = [0.0; 2];
    for (side, by) in heat.iter_mut().enumerate() {
        let warm = |kelvin: f64| -> Vec<_> {
            let of_rows = fixed.iter().zip(&growth);
            of_rows
                .map(|(fixed, of)| *fixed + of[1 + side] * kelvin)
                .collect()
        };
        let change = pressed(&warm(KELVIN), 0.0) - pressed(&warm(-KELVIN), 0.0);
        *by = (change / (2.0 * KELVIN) / slope) as f32;
    }
    let clamped = plan.rows.iter().enumerate();
    let clamped = clamped.filter(|(_, row)| !matches!(row.preload, Preload::Spring));
    Ok(Some(PreloadLaw {
        force: ground.unwrap_or(sum) as f32,
        by: PreloadBy::Closure {
            rows: clamped.fold(0, |rows, (i, _)| rows | 1 << i),
            closures: closures.map(|closure| closure as f32),
            heat,
        },
    }))
}

/// The closure whose force is this one, near another one and on this scale, by halving an interval.
fn closure_of(
    mut force: impl FnMut(f64) -> f64,
    wanted: f64,
    near: f64,
    scale: f64,
) -> Option<f64> {
    let (mut low, mut high) = (near, near);
    for _ in 0..MOST_SOLVES {
        if force(low) < wanted {
            break;
        }
        low -= 0.3 * scale;
    }
    for _ in 0..MOST_SOLVES {
        if force(high) > wanted {
            break;
        }
        high += 0.3 * scale;
    }
    for _ in 0..MOST_SOLVES {
        let middle = 0.5 * (low + high);
        match force(middle) < wanted {
            true => low = middle,
            false => high = middle,
        }
        if high - low < 1e-6 * scale {
            break;
        }
    }
    ((force(high) / wanted - 1.0).abs() < 1e-3).then_some(high)
}
