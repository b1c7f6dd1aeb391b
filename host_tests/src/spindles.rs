//! Spindles whose rows, ball counts and precision are known at run time only. A bearing is a spindle with one row.

use crate::dispatch::{
    Attitude, Mount, Precision, mount, narrowed, wide, widened, widened_frequencies, widened_motion,
};
use files::plan::{BuildError, MOST_BALLS, Plan, Question};
use spindle_bearing::{
    BallKinematics, BallState, Frequencies, Full, Growth, InnerRaceControl, LimitSet, Limits,
    Motion, Mounted, OuterRaceControl, Preload, RacewayControlFree, Real, Settings, ShaftEnd,
    Speed, Spindle, SpindleSolution, SpindleSolver, Static, Status,
};
use std::array::from_fn;

/// How the balls move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Balls {
    /// At rest, in closed form.
    Static,
    /// At speed.
    Moving(Attitude),
}

/// An equilibrium, widened to double.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// How the solve ended, in a word.
    pub status: &'static str,
    /// Iterations.
    pub iterations: u16,
    /// Displacement of the shaft at `x = 0`.
    pub displacement: [f64; 5],
    /// Stiffness there.
    pub stiffness: [[f64; 5]; 5],
    /// Compliance at the point that was asked for.
    pub compliance_at: [[f64; 5]; 5],
    /// Stiffness there.
    pub stiffness_at: [[f64; 5]; 5],
    /// Closure that the spring makes, m.
    pub spring_closure: f64,
    /// The rows.
    pub rows: Vec<RowAnswer>,
    /// Estimated errors of displacement, force and stiffness.
    pub error: [f64; 3],
}

/// Load, stiffness and balls of a row.
#[derive(Debug, Clone, PartialEq)]
pub struct RowAnswer {
    /// Force on its inner ring, in its own frame.
    pub force: [f64; 5],
    /// Preload, N.
    pub preload: f64,
    /// Limits that it has passed.
    pub limits: LimitSet,
    /// It carries nothing in its direction.
    pub lifted_off: bool,
    /// Stiffness of the row alone.
    pub stiffness: [[f64; 5]; 5],
    /// States of the balls.
    pub balls: Vec<BallState<f64>>,
    /// How they turn, and how their contacts are pressed.
    pub motions: Vec<BallKinematics<f64>>,
    /// Frequencies at which damage is heard.
    pub frequencies: Frequencies<f64>,
}

/// A solver for a spindle.
pub trait AnySpindleSolver {
    /// Solves; `end` is the point at which stiffness and compliance are wanted besides `x = 0`.
    ///
    /// # Errors
    ///
    /// Why there is no answer.
    fn solve(&mut self, question: &Question, end: &ShaftEnd<f64>) -> Result<Answer, Status<f32>>;

    /// Holds the next solves against these limits instead of the default ones.
    fn set_limits(&mut self, limits: &Limits<f64>);

    /// Makes the next solves stop at this tolerance, or after this many iterations.
    fn set_settings(&mut self, tolerance: f64, max_iterations: u16);

    /// Makes the next solve a cold one.
    fn reset(&mut self);

    /// Solves for a load at `x = 0`, N and N m, at a speed in rad/s.
    ///
    /// # Errors
    ///
    /// Why there is no answer.
    fn load(&mut self, load: [f64; 5], omega: f64) -> Result<Answer, Status<f32>> {
        let question = Question {
            load,
            omega,
            growth: Vec::new(),
        };
        self.solve(&question, &ShaftEnd::rigid(0.0))
    }
}

/// Builds a spindle, and hands a cold solver for it to `f`.
///
/// # Errors
///
/// Why it cannot be built.
pub fn with_solver<O>(
    plan: &Plan,
    balls: Balls,
    precision: Precision,
    f: impl FnOnce(&mut dyn AnySpindleSolver) -> O,
) -> Result<O, BuildError> {
    let (mut f, mut outcome) = (Some(f), None);
    let mut hand = |solver: &mut dyn AnySpindleSolver| outcome = f.take().map(|f| f(solver));
    match precision {
        Precision::F32 => with::<f32>(plan, balls, &mut hand)?,
        Precision::F64 => with::<f64>(plan, balls, &mut hand)?,
    }
    Ok(outcome.expect("a solver was handed over"))
}

/// Takes a solver, whoever asked for it: without the type of a closure, a solver is compiled once.
type Hand<'h> = &'h mut dyn FnMut(&mut dyn AnySpindleSolver);

fn with<T: Real>(plan: &Plan, balls: Balls, hand: Hand<'_>) -> Result<(), BuildError> {
    let bearings = plan.rows.iter().enumerate();
    let bearings: Vec<Box<dyn Mount<T>>> = bearings
        .map(|(i, row)| mount(&row.design, row.balls).map_err(|e| BuildError::Design(i, e)))
        .collect::<Result<_, _>>()?;
    let mounted = plan.rows.iter().zip(&bearings).map(|(row, bearing)| {
        let preload = match row.preload {
            Preload::Closure(e) => Preload::Closure(T::of(e)),
            Preload::Force(force) => Preload::Force(T::of(force)),
            _ => Preload::Spring,
        };
        bearing.mounted(row.position, row.facing).with(preload)
    });
    let mounted: Vec<_> = mounted.collect();
    match mounted.len() {
        1 => of_rows::<T, 1>(plan, &mounted, balls, hand),
        2 => of_rows::<T, 2>(plan, &mounted, balls, hand),
        3 => of_rows::<T, 3>(plan, &mounted, balls, hand),
        4 => of_rows::<T, 4>(plan, &mounted, balls, hand),
        5 => of_rows::<T, 5>(plan, &mounted, balls, hand),
        6 => of_rows::<T, 6>(plan, &mounted, balls, hand),
        7 => of_rows::<T, 7>(plan, &mounted, balls, hand),
        8 => of_rows::<T, 8>(plan, &mounted, balls, hand),
        rows => Err(BuildError::Rows(rows)),
    }
}

fn of_rows<T: Real, const R: usize>(
    plan: &Plan,
    mounted: &[Mounted<'_, T, MOST_BALLS>],
    balls: Balls,
    hand: Hand<'_>,
) -> Result<(), BuildError> {
    let rows: [Mounted<'_, T, MOST_BALLS>; R] = from_fn(|i| mounted[i]);
    let spindle = match plan.spring {
        Some(spring) => Spindle::sprung(plan.arrangement, rows, T::of(spring))
            .map(|spindle| of_motion(spindle, balls, hand)),
        None => Spindle::new(plan.arrangement, rows).map(|spindle| of_motion(spindle, balls, hand)),
    };
    spindle.map_err(|e| BuildError::Spindle(e.to_string()))
}

fn of_motion<T: Real, const R: usize, const D: usize>(
    spindle: Spindle<'_, T, R, MOST_BALLS, D>,
    balls: Balls,
    hand: Hand<'_>,
) {
    match balls {
        Balls::Static => hand_over::<T, R, Static, D>(spindle, hand),
        Balls::Moving(Attitude::Raceless) => {
            hand_over::<T, R, Full<RacewayControlFree>, D>(spindle, hand);
        }
        Balls::Moving(Attitude::Outer) => {
            hand_over::<T, R, Full<OuterRaceControl>, D>(spindle, hand);
        }
        Balls::Moving(Attitude::Inner) => {
            hand_over::<T, R, Full<InnerRaceControl>, D>(spindle, hand);
        }
    }
}

fn hand_over<T: Real, const R: usize, M: Motion, const D: usize>(
    spindle: Spindle<'_, T, R, MOST_BALLS, D>,
    hand: Hand<'_>,
) {
    let mut solver = Box::new(Counted {
        solver: SpindleSolver::<T, R, MOST_BALLS, M, D>::of(spindle),
        settings: Settings::default(),
        limits: Limits::default(),
    });
    hand(&mut *solver);
}

struct Counted<'s, T: Real, const R: usize, M: Motion, const D: usize> {
    solver: SpindleSolver<'s, T, R, MOST_BALLS, M, D>,
    settings: Settings<T>,
    limits: Limits<T>,
}

impl<T: Real, const R: usize, M: Motion, const D: usize> AnySpindleSolver
    for Counted<'_, T, R, M, D>
{
    fn solve(&mut self, question: &Question, end: &ShaftEnd<f64>) -> Result<Answer, Status<f32>> {
        let growth = from_fn(|i| match question.growth.get(i) {
            Some(growth) => Growth {
                axial: T::of(growth.axial),
                radial: T::of(growth.radial),
                ball: T::of(growth.ball),
            },
            None => Growth::NONE,
        });
        let speed = Speed::rad_per_s(T::of(question.omega));
        let end = ShaftEnd {
            position: T::of(end.position),
            flexibility: end.flexibility.map(|row| row.map(T::of)),
        };
        let limits = &self.limits;
        self.solver
            .solve_at(question.load.map(T::of), speed, &growth, &self.settings)
            .map(|solution| answer(&solution, &end, limits))
            .map_err(narrowed)
    }

    fn set_settings(&mut self, tolerance: f64, max_iterations: u16) {
        self.settings = Settings {
            tolerance: T::of(tolerance),
            max_iterations,
        };
    }

    fn set_limits(&mut self, limits: &Limits<f64>) {
        self.limits = Limits {
            peak_pressure: T::of(limits.peak_pressure),
            friction: T::of(limits.friction),
        };
    }

    fn reset(&mut self) {
        self.solver.reset();
    }
}

fn answer<T: Real, const R: usize, const N: usize, M: Motion, const D: usize>(
    solution: &SpindleSolution<'_, T, R, N, M, D>,
    end: &ShaftEnd<T>,
    limits: &Limits<T>,
) -> Answer {
    let error = &solution.error;
    Answer {
        status: solution.status.name(),
        iterations: solution.iterations,
        displacement: solution.displacement.map(T::to_f64),
        stiffness: wide(&solution.stiffness()),
        compliance_at: wide(&solution.compliance_at(end)),
        stiffness_at: wide(&solution.stiffness_at(end)),
        spring_closure: solution.spring_closure().to_f64(),
        rows: solution
            .rows()
            .map(|row| RowAnswer {
                force: row.force.map(T::to_f64),
                preload: row.preload().to_f64(),
                limits: row.limits(limits),
                lifted_off: row.is_lifted_off(),
                stiffness: wide(&row.stiffness()),
                balls: row.balls().map(|ball| widened(&ball)).collect(),
                motions: row
                    .kinematics()
                    .map(|motion| widened_motion(&motion))
                    .collect(),
                frequencies: widened_frequencies(&row.frequencies()),
            })
            .collect(),
        error: [error.displacement, error.force, error.stiffness].map(T::to_f64),
    }
}
