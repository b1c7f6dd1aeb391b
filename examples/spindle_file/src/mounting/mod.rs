//! From rows, ball counts and a shaft known at run time to a spindle, which wants their numbers at compile time.
//!
//! A host program that reads the bearing from a file has one bearing compiled for every ball count. Spindles are for the
//! largest alone: a row may have fewer balls.

pub mod board;
pub mod faults;

use crate::designs::short;
use crate::plan::{BALL_COUNTS, BuildError, MOST_BALLS, MOST_SECTIONS, Part, Plan};
use spindle_bearing::{
    Bearing, Design, DesignError, Facing, Growth, Mounted, Preload, Quantity, Real, Section,
    Settings, Shaft, ShaftLoad, Speed, Spindle, SpindleError, SpindleSolver, Static, Support,
};
use std::array::from_fn;

const _: () = assert!(crate::probes::MOST_PROBES == spindle_monitor::command::MOST_PROBES);

/// A bearing of any ball count.
pub trait Mount<T: Real> {
    /// The bearing on a shaft: clamped, with its rings just touching.
    fn mounted(&self, position: f64, facing: Facing) -> Mounted<'_, T, MOST_BALLS>;
}

impl<T: Real, const N: usize> Mount<T> for Bearing<T, N> {
    fn mounted(&self, position: f64, facing: Facing) -> Mounted<'_, T, MOST_BALLS> {
        Mounted::new(self, T::of(position), facing)
    }
}

macro_rules! mounts {
    ($t:ident, $design:expr, $balls:expr, $($n:literal)*) => {
        match $balls {
            $($n => Ok(Box::new(Bearing::<$t, $n>::of($design)?) as Box<dyn Mount<$t>>),)*
            balls => Err(DesignError {
                quantity: Quantity::BallCount,
                value: balls as f64,
                least: *BALL_COUNTS.start() as f64,
                most: MOST_BALLS as f64,
            }),
        }
    };
}

/// Builds a bearing that can be mounted.
///
/// # Errors
///
/// The first quantity of the design that is out of its range; the ball count, if it is not among
/// [`BALL_COUNTS`].
pub fn mount<T: Real>(design: &Design, balls: usize) -> Result<Box<dyn Mount<T>>, DesignError> {
    mounts!(
        T, design, balls,
        3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34
        35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64
    )
}

/// Takes a spindle of any size, made of parts that live for `'p`.
pub trait Visitor<'p, T: Real> {
    /// Takes it. Its `x = 0` is at the position `loaded_at` (m) of the plan.
    ///
    /// # Errors
    ///
    /// Whatever the visitor cannot do with it.
    fn visit<const R: usize, const D: usize, const E: usize>(
        self,
        spindle: Spindle<'p, T, R, MOST_BALLS, D, E>,
        loaded_at: f64,
    ) -> Result<(), BuildError>;
}

/// Builds a spindle, and hands it over.
///
/// # Errors
///
/// Why it cannot be built; the visitor's error.
pub fn visit<T: Real>(plan: &Plan, visitor: impl for<'p> Visitor<'p, T>) -> Result<(), BuildError> {
    Parts::of(plan)?.visit(plan, visitor)
}

/// Parts that a spindle refers to. The library's loads act at `x = 0`: positions count from there.
pub struct Parts<T: Real> {
    bearings: Vec<Box<dyn Mount<T>>>,
    shaft: Option<Shaft<T, MOST_SECTIONS>>,
    loads: Vec<ShaftLoad<T>>,
}

impl<T: Real> Parts<T> {
    /// The parts of a plan.
    ///
    /// # Errors
    ///
    /// A bearing or a shaft that cannot be built.
    pub fn of(plan: &Plan) -> Result<Self, BuildError> {
        let bearings = plan.rows.iter().enumerate();
        let bearings = bearings
            .map(|(i, row)| mount(&row.design, row.balls).map_err(|e| BuildError::Design(i, e)));
        let mut parts = Self {
            bearings: bearings.collect::<Result<_, _>>()?,
            shaft: None,
            loads: Vec::new(),
        };
        if let Some(elastic) = &plan.shaft {
            let loaded_at = elastic.loaded_at;
            let sections = elastic.sections.iter().map(|section| Section {
                from: section.from - loaded_at,
                to: section.to - loaded_at,
                ..*section
            });
            let sections: Vec<_> = sections.collect();
            let shaft = Shaft::new(&sections, &elastic.material);
            parts.shaft = Some(shaft.map_err(|e| BuildError::Spindle(e.to_string()))?);
            let loads = elastic.loads.iter().map(|at| ShaftLoad {
                position: T::of(at.position - loaded_at),
                load: at.load.map(T::of),
            });
            parts.loads = loads.collect();
        }
        Ok(parts)
    }

    /// Builds the spindle of the plan that these are the parts of, and hands it over.
    ///
    /// # Errors
    ///
    /// Why it cannot be built; the visitor's error.
    pub fn visit<'p>(
        &'p self,
        plan: &Plan,
        visitor: impl Visitor<'p, T>,
    ) -> Result<(), BuildError> {
        let loaded_at = plan.loaded_at();
        let mounted = plan.rows.iter().zip(&self.bearings).map(|(row, bearing)| {
            let preload = match row.preload {
                Preload::Closure(e) => Preload::Closure(T::of(e)),
                Preload::Force(force) => Preload::Force(T::of(force)),
                _ => Preload::Spring,
            };
            let position = row.position - loaded_at;
            bearing.mounted(position, row.facing).with(preload)
        });
        let mounted: Vec<_> = mounted.collect();
        match mounted.len() {
            1 => self.of_rows::<1>(plan, &mounted, visitor),
            2 => self.of_rows::<2>(plan, &mounted, visitor),
            3 => self.of_rows::<3>(plan, &mounted, visitor),
            4 => self.of_rows::<4>(plan, &mounted, visitor),
            5 => self.of_rows::<5>(plan, &mounted, visitor),
            6 => self.of_rows::<6>(plan, &mounted, visitor),
            7 => self.of_rows::<7>(plan, &mounted, visitor),
            8 => self.of_rows::<8>(plan, &mounted, visitor),
            rows => Err(BuildError::Rows(rows)),
        }
    }

    fn of_rows<'p, const R: usize>(
        &'p self,
        plan: &Plan,
        mounted: &[Mounted<'p, T, MOST_BALLS>],
        visitor: impl Visitor<'p, T>,
    ) -> Result<(), BuildError> {
        let rows: [Mounted<'p, T, MOST_BALLS>; R] = from_fn(|i| mounted[i]);
        let made = match plan.spring {
            Some(spring) => Spindle::sprung(plan.arrangement, rows, T::of(spring)).map(|spindle| {
                if const { R > 1 } {
                    self.on_shaft(spindle, plan, visitor)
                } else {
                    unreachable!("a spring holds a row against another one")
                }
            }),
            None => Spindle::new(plan.arrangement, rows)
                .map(|spindle| self.on_shaft(spindle, plan, visitor)),
        };
        made.map_err(|error| refused(&error, plan.loaded_at()))?
    }

    fn on_shaft<'p, const R: usize, const D: usize>(
        &'p self,
        spindle: Spindle<'p, T, R, MOST_BALLS, D>,
        plan: &Plan,
        visitor: impl Visitor<'p, T>,
    ) -> Result<(), BuildError> {
        let Some((elastic, shaft)) = plan.shaft.as_ref().zip(self.shaft.as_ref()) else {
            return visitor.visit(spindle, 0.0);
        };
        let supports = from_fn(|i| {
            let support = elastic.supports.get(i).unwrap_or(&Support::RIGID);
            Support {
                axial: T::of(support.axial),
                radial: T::of(support.radial),
                tilting: T::of(support.tilting),
            }
        });
        let spindle = spindle.elastic(shaft, supports);
        let spindle = spindle.and_then(|spindle| spindle.with_loads(&self.loads));
        let spindle = spindle.map_err(|e| refused(&e, elastic.loaded_at))?;
        visitor.visit(spindle, elastic.loaded_at)
    }
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
        ref other => return BuildError::Spindle(other.to_string()),
    };
    BuildError::Part(part, message)
}

/// The plan with the closure of all rows that gives its mounted preload; none if it has no such preload.
///
/// # Errors
///
/// Why it cannot be built; no closure gives that preload.
pub fn closed(plan: &Plan) -> Result<Option<Plan>, BuildError> {
    let Some((force, growth)) = &plan.mounted_preload else {
        return Ok(None);
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
    let mut closure = None;
    let at = MountedPreload {
        force: *force,
        growth,
        closure: &mut closure,
    };
    visit(&ground, at)?;
    match closure {
        Some(closure) => Ok(Some(held_by(Preload::Closure(closure)))),
        None => {
            let message = format!(
                "`mounted_preload_n`: no closure of these rows gives {force} N between them"
            );
            Err(BuildError::Part(Part::Preload, message))
        }
    }
}

/// Looks for the closure of all rows that gives this force between the rows that face `+x` and the others. The rows of the
/// spindle are ground for that force.
struct MountedPreload<'p> {
    force: f64,
    growth: &'p [Growth<f64>],
    closure: &'p mut Option<f64>,
}

impl MountedPreload<'_> {
    fn closure_of<const R: usize, const D: usize, const E: usize>(
        &self,
        spindle: &Spindle<'_, f64, R, MOST_BALLS, D, E>,
    ) -> Option<f64> {
        let (force, ground) = (self.force, spindle.closures());
        let mut solver = SpindleSolver::<f64, R, MOST_BALLS, Static, D, E>::of();
        let mut preload = |closure: f64| {
            // More closure is an axial growth. Rows that do not touch have no answer, and no preload.
            let grown = from_fn(|i| Growth {
                axial: self.growth[i].axial + (closure - ground[i]),
                ..self.growth[i]
            });
            solver.reset();
            let at = Speed::rad_per_s(0.0).with_growth(grown);
            match solver.solve(spindle, [0.0; 5], at, &Settings::default()) {
                Ok(solution) => {
                    let rows = solution.rows().zip(spindle.facings());
                    let ahead = rows.filter(|(_, facing)| *facing == Facing::PlusX);
                    ahead.map(|(row, _)| row.preload()).sum::<f64>()
                }
                Err(_) => 0.0,
            }
        };
        // The closure as ground is of the size that is looked for.
        let step = ground[0];
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
}

impl<'p> Visitor<'p, f64> for MountedPreload<'_> {
    fn visit<const R: usize, const D: usize, const E: usize>(
        self,
        spindle: Spindle<'p, f64, R, MOST_BALLS, D, E>,
        _: f64,
    ) -> Result<(), BuildError> {
        // A spring has its force whatever the closure.
        if const { D == 5 } {
            *self.closure = self.closure_of(&spindle);
        }
        Ok(())
    }
}
