//! From a plan, whose sizes are known when a program runs, to a spindle of the library: one type for all plans.

pub mod board;
pub mod preload;

use crate::designs::short;
use crate::plan::{BuildError, MOST_BALLS, MOST_ROWS, MOST_SECTIONS, Part, Plan};
use spindle_bearing::{
    Bearing, Facing, Growth, Material, Mounted, Preload, Quantity, RacewayControlFree, Real,
    Section, Settings, Shaft, ShaftLoad, Speed, Spindle, SpindleError, SpindleSolver, Static,
    Support,
};
use std::array::from_fn;

const _: () = assert!(crate::probes::MOST_PROBES == spindle_monitor::command::MOST_PROBES);

/// A spindle of any plan: its rows, a sleeve if one slides, a shaft that bends or does not.
pub type DynSpindle<'p, T> = Spindle<'p, T, MOST_ROWS, MOST_BALLS, 6, MOST_JOINTS>;

/// Joints of a shaft that bends or does not: one more than rows.
pub const MOST_JOINTS: usize = MOST_ROWS + 1;

/// The solver of a [`DynSpindle`].
pub type DynSolver<T, M = RacewayControlFree> =
    SpindleSolver<T, MOST_ROWS, MOST_BALLS, M, 6, MOST_JOINTS>;

/// Parts that a spindle refers to. The library's loads act at `x = 0`: positions count from there.
pub struct Parts<T: Real> {
    bearings: Vec<Bearing<T, MOST_BALLS>>,
    shaft: Shaft<T, MOST_SECTIONS>,
    loads: Vec<ShaftLoad<T>>,
}

impl<T: Real> Parts<T> {
    /// The parts of a plan.
    ///
    /// # Errors
    ///
    /// A bearing or a shaft that cannot be built.
    pub fn of(plan: &Plan) -> Result<Self, BuildError> {
        let bearings = plan.rows.iter().enumerate().map(|(i, row)| {
            let bearing = Bearing::with_balls(&row.design, row.balls);
            bearing.map_err(|e| BuildError::Design(i, e))
        });
        let bearings = bearings.collect::<Result<_, _>>()?;
        let loaded_at = plan.loaded_at();
        let (sections, loads, material) = match &plan.shaft {
            Some(elastic) => (&elastic.sections[..], &elastic.loads[..], &elastic.material),
            None => (&[][..], &[][..], &Material::STEEL),
        };
        let sections = sections.iter().map(|section| Section {
            from: section.from - loaded_at,
            to: section.to - loaded_at,
            ..*section
        });
        let shaft = Shaft::new(&sections.collect::<Vec<_>>(), material);
        let loads = loads.iter().map(|at| ShaftLoad {
            position: T::of(at.position - loaded_at),
            load: at.load.map(T::of),
        });
        Ok(Self {
            bearings,
            shaft: shaft.map_err(|e| BuildError::Spindle(e.to_string()))?,
            loads: loads.collect(),
        })
    }

    /// The spindle of the plan that these are the parts of. Its `x = 0` is where loads act: [`Plan::loaded_at`].
    ///
    /// # Errors
    ///
    /// Why it cannot be built.
    pub fn spindle(&self, plan: &Plan) -> Result<DynSpindle<'_, T>, BuildError> {
        let loaded_at = plan.loaded_at();
        let mounted = plan.rows.iter().zip(&self.bearings).map(|(row, bearing)| {
            let preload = match row.preload {
                Preload::Closure(e) => Preload::Closure(T::of(e)),
                Preload::Force(force) => Preload::Force(T::of(force)),
                _ => Preload::Spring,
            };
            let position = T::of(row.position - loaded_at);
            Mounted::new(bearing, position, row.facing).with(preload)
        });
        let mounted: Vec<_> = mounted.collect();
        let supports = plan.shaft.iter().flat_map(|shaft| &shaft.supports);
        let supports = supports.map(|support| Support {
            axial: T::of(support.axial),
            radial: T::of(support.radial),
            tilting: T::of(support.tilting),
        });
        let spindle = Spindle::of_rows(
            plan.arrangement,
            &mounted,
            plan.spring.map(T::of),
            &self.shaft,
            &supports.collect::<Vec<_>>(),
        );
        let spindle = spindle.and_then(|spindle| spindle.with_loads(&self.loads));
        spindle.map_err(|error| refused(&error, loaded_at))
    }
}

/// Growth of at most `R` rows.
pub fn growths<T: Real, const R: usize>(growths: &[Growth<f64>]) -> [Growth<T>; R] {
    from_fn(|i| match growths.get(i) {
        Some(growth) => Growth {
            axial: T::of(growth.axial),
            radial: T::of(growth.radial),
            ball: T::of(growth.ball),
        },
        None => Growth::NONE,
    })
}

/// The error, of a part of the file and in its unit.
fn refused<T: Real>(error: &SpindleError<T>, loaded_at: f64) -> BuildError {
    let millimetres = |x: T| short(1e3 * x.to_f64());
    let (part, message) = match *error {
        SpindleError::Row {
            row,
            quantity: Quantity::RowDistance,
            value,
            least,
            ..
        } => {
            let [distance, least] = [value, least].map(millimetres);
            let message = format!(
                "row {row}: another row is {distance} mm away, nearer than half a ball's diameter, {least} mm: check the \
                 positions"
            );
            (Part::Position(row), message)
        }
        SpindleError::Row {
            row,
            quantity: Quantity::RowPosition,
            value,
            most,
            ..
        } => {
            let said = millimetres(value + T::of(loaded_at));
            let [limit, loaded_at] = [millimetres(most), short(1e3 * loaded_at)];
            let message = format!(
                "row {row}: `position_mm` is {said}, but must lie within {limit} mm of x = {loaded_at}, where loads act"
            );
            (Part::Position(row), message)
        }
        SpindleError::Row { row, quantity, .. } => {
            let part = match quantity {
                Quantity::Closure => Part::Closure(row),
                Quantity::SpringForce => Part::Spring,
                _ => Part::Preload,
            };
            (part, error.to_string())
        }
        SpindleError::NotArranged { row, .. } | SpindleError::Unopposed { row } => {
            let message = format!("{error}; rows count from 0");
            (Part::Facing(row), message)
        }
        SpindleError::NoSpring { row } => {
            let message = format!(
                "row {row} slides, but there is no spring: add [spring] with `force_n`, or remove `spring`"
            );
            (Part::Slides(row), message)
        }
        SpindleError::NothingSlides => {
            let message = "there is a spring, but no row slides: say `spring = true` in a row, or remove [spring]";
            (Part::Spring, message.to_owned())
        }
        SpindleError::Load { load, quantity, .. } => {
            let forces = [Quantity::Fx, Quantity::Fy, Quantity::Fz];
            let axis = forces.iter().position(|of| *of == quantity);
            let part = axis.map_or(Part::LoadPosition(load), |axis| Part::LoadForce(load, axis));
            (part, error.to_string())
        }
        SpindleError::NotHeld => (Part::Slides(0), error.to_string()),
        SpindleError::NoRow => return BuildError::Rows(0),
        SpindleError::TooManyRows { rows, .. } => return BuildError::Rows(rows),
        ref other => return BuildError::Spindle(other.to_string()),
    };
    BuildError::Part(part, message)
}

/// The plan with the closure of all rows that gives its mounted preload, if it has one.
///
/// # Errors
///
/// Why it cannot be built; no closure gives that preload.
pub fn closed(plan: &Plan) -> Result<Plan, BuildError> {
    let Some((force, growth)) = &plan.mounted_preload else {
        return Ok(plan.clone());
    };
    let held_by = |preload| {
        let mut plan = Plan {
            mounted_preload: None,
            ..plan.clone()
        };
        plan.rows.iter_mut().for_each(|row| row.preload = preload);
        plan
    };
    let mut ground = held_by(Preload::Force(*force));
    if let Some(shaft) = &mut ground.shaft {
        shaft.loads.clear();
    }
    let parts = Parts::of(&ground)?;
    let closure = closure_of(&parts.spindle(&ground)?, *force, growth);
    // A spring has its force whatever the closure.
    match closure.filter(|_| plan.spring.is_none()) {
        Some(closure) => Ok(held_by(Preload::Closure(closure))),
        None => {
            let message = format!(
                "`mounted_preload_n`: no closure of these rows gives {force} N between them"
            );
            Err(BuildError::Part(Part::Preload, message))
        }
    }
}

/// The closure of all rows that gives this force between the rows that face `+x` and the others, with such growths. The rows of the
/// spindle are ground for that force.
fn closure_of(spindle: &DynSpindle<'_, f64>, force: f64, growth: &[Growth<f64>]) -> Option<f64> {
    let ground: Vec<f64> = spindle.closures().collect();
    let mut press = Press::of(spindle);
    let mut preload = |closure: f64| {
        let more = |row: usize| ground.get(row).map_or(0.0, |ground| closure - ground);
        press.force(growth, more)
    };
    // The closure as ground is of the size that is looked for.
    let step = *ground.first()?;
    let (mut low, mut high) = (0.0, step);
    while preload(high) < force && high < 1e3 * step {
        (low, high) = (high, 2.0 * high);
    }
    while preload(low) > force && low > -1e3 * step {
        (low, high) = (2.0 * low - step, low);
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match preload(middle) < force {
            true => low = middle,
            false => high = middle,
        }
    }
    ((preload(high) / force - 1.0).abs() < 1e-6).then_some(high)
}

/// Rows that press each other at rest.
struct Press<'s> {
    spindle: &'s DynSpindle<'s, f64>,
    solver: DynSolver<f64, Static>,
}

impl<'s> Press<'s> {
    fn of(spindle: &'s DynSpindle<'s, f64>) -> Self {
        Self {
            spindle,
            solver: DynSolver::of(),
        }
    }

    /// Force between the rows that face `+x` and the others, N, where each row is closed by so much more, m. Rows that do not touch have none.
    fn force(&mut self, growth: &[Growth<f64>], more: impl Fn(usize) -> f64) -> f64 {
        let mut grown = growths(growth);
        // More closure is an axial growth.
        for (row, grown) in grown.iter_mut().enumerate() {
            grown.axial += more(row);
        }
        self.solver.reset();
        let at = Speed::rad_per_s(0.0).with_growth(grown);
        match self
            .solver
            .solve(self.spindle, [0.0; 5], at, &Settings::DEFAULT)
        {
            Ok(solution) => {
                let rows = solution.rows().zip(self.spindle.facings());
                let ahead = rows.filter(|(_, facing)| *facing == Facing::PlusX);
                ahead.map(|(row, _)| row.preload()).sum()
            }
            Err(_) => 0.0,
        }
    }
}
