//! Small faults of a spindle, and by how much each lets the probes see more of a usual cut: for naming faults by the ratios.

use super::{DynSolver, Parts, closed, growths};
use crate::designs::DesignFileError;
use crate::loads::LoadRow;
use crate::monitors::Sensors;
use crate::plan::{BuildError, Plan};
use crate::probes::{MOST_PROBES, Probe};
use crate::spindles::SpindleFile;
use spindle_bearing::{FreeContact, Preload, Settings, Speed};
use spindle_monitor::response::Fault;
use std::array::from_fn;
use std::f64::consts::PI;

/// Part by which a fault changes what it is about: small.
const SMALL: f64 = 0.05;

/// Each fault with the change of the displacement at each probe, parts of 1, by the usual cut of the file's monitor; none
/// without such a cut, or without probes.
///
/// # Errors
///
/// The spindle cannot be built, or has no equilibrium under that cut; a probe does not see the cut.
pub fn changes(file: &SpindleFile) -> Result<Vec<(Fault, Vec<f64>)>, DesignFileError> {
    if file.probes.is_empty() || file.sensors.cut == [0.0; 5] {
        return Ok(Vec::new());
    }
    let explained = |error: BuildError| file.explain(&error);
    // Closures stay as they were mounted.
    let plan = closed(&file.plan).map_err(explained)?;
    let sound = Seen::of(file, &plan).map_err(explained)?;
    for (probe, by) in file.probes.iter().zip(&sound.displacements) {
        let Probe { name, accuracy, .. } = probe;
        if by.abs() < *accuracy {
            return Err(explained(BuildError::Spindle(format!(
                "the cut of [monitor.cut] moves the probe {name:?} by {by:.3} um, less than its accuracy of {accuracy} um: give the loads of \
                 a usual cut"
            ))));
        }
    }
    let faults = faults(&plan, &sound.closures);
    let changes = faults.into_iter().map(|(fault, plan)| {
        let seen = Seen::of(file, &plan).map_err(explained)?;
        let pairs = seen.displacements.iter().zip(&sound.displacements);
        Ok((fault, pairs.map(|(is, was)| is / was - 1.0).collect()))
    });
    changes.collect()
}

/// The spindle with each fault.
fn faults(plan: &Plan, closures: &[f64]) -> Vec<(Fault, Plan)> {
    let mut faults = Vec::new();
    for sign in [-1.0, 1.0] {
        let part = 1.0 + sign * SMALL;
        let mut pressed = plan.clone();
        for force in [&mut pressed.spring].into_iter().flatten() {
            *force *= part;
        }
        for row in &mut pressed.rows {
            match &mut row.preload {
                Preload::Force(force) => *force *= part,
                // A force goes with its power of 3/2.
                Preload::Closure(closure) => *closure *= 1.0 + sign * SMALL / 1.5,
                _ => {}
            }
        }
        faults.push((Fault::Preload, pressed));
        let mut inclined = plan.clone();
        for (row, closure) in inclined.rows.iter_mut().zip(closures) {
            if !matches!(row.preload, Preload::Spring) {
                row.preload = Preload::Closure(*closure);
            }
            row.design.free_contact = match row.design.free_contact {
                FreeContact::Angle(angle) => FreeContact::Angle(angle * part),
                // The angle grows with the square root of the clearance.
                FreeContact::DiametralClearance(clearance) => {
                    FreeContact::DiametralClearance(clearance * part * part)
                }
            };
        }
        faults.push((Fault::ContactAngle, inclined));
    }
    let supports = plan.shaft.as_ref().map_or(0, |shaft| shaft.supports.len());
    for row in 0..supports {
        for freedom in 0..3 {
            let mut soft = plan.clone();
            let support = soft.shaft.as_mut().map(|shaft| &mut shaft.supports[row]);
            let stiffness = support.map(|of| match freedom {
                0 => &mut of.axial,
                1 => &mut of.radial,
                _ => &mut of.tilting,
            });
            if let Some(stiffness) = stiffness.filter(|stiffness| stiffness.is_finite()) {
                *stiffness *= 1.0 - SMALL;
                faults.push((Fault::Support(row as u8), soft));
            }
        }
    }
    faults
}

/// A spindle under the cut.
struct Seen {
    /// Displacement by the cut at each probe, um.
    displacements: Vec<f64>,
    /// Axial closure of each row, m.
    closures: Vec<f64>,
}

impl Seen {
    fn of(file: &SpindleFile, plan: &Plan) -> Result<Self, BuildError> {
        let parts = Parts::of(plan)?;
        let spindle = parts.spindle(plan)?;
        let Sensors { idle, cut, .. } = &file.sensors;
        let speed = f64::from(file.sensors.cut_speed);
        let mut solver = DynSolver::<f64>::new();
        let mut displacement = |share: f64| {
            let question = file.question(&LoadRow {
                time_s: 0.0,
                load: from_fn(|i| f64::from(idle[i]) + share * f64::from(cut[i])),
                speed_rpm: speed * 30.0 / PI,
                temperatures: file.heat.map(|heat| [heat.reference; 2]),
                probes: [None; MOST_PROBES],
            });
            let at = Speed::rad_per_s(speed).with_growth(growths(&question.growth));
            let solution = solver.solve(&spindle, question.load, at, &Settings::DEFAULT);
            let solution = solution.map_err(|status| {
                BuildError::Spindle(format!(
                    "the cut of [monitor.cut] has no equilibrium ({status}): give the loads of a usual cut"
                ))
            })?;
            let sees = |probe: &Probe| {
                probe.sees(&solution.displacement_at(probe.position - plan.loaded_at()))
            };
            Ok(file.probes.iter().map(sees).collect::<Vec<f64>>())
        };
        let (idle, cut) = (displacement(0.0)?, displacement(1.0)?);
        let pairs = cut.iter().zip(&idle);
        Ok(Self {
            displacements: pairs.map(|(cut, idle)| cut - idle).collect(),
            closures: spindle.closures().collect(),
        })
    }
}
