//! Spindles whose rows, ball counts and precision are known at run time only. A bearing is a spindle with one row; what of
//! questions and answers does not depend on that is for solvers of bearings, too.
//!
//! A program that reads any spindle, and tells the stiffness at its nose over the speed:
//!
//! ```
//! use solvers::{Balls, dispatch::Precision, with_solver};
//! use spindle_file::{loads::LoadRow, spindles::SpindleFile};
//!
//! let file = SpindleFile::read("../spindles/milling_spindle.toml")?;
//! let solved = with_solver(&file.plan, Balls::Free, Precision::F64, |solver| {
//!     for speed_rpm in [0.0, 5e3, 10e3, 15e3] {
//!         let loads = LoadRow { speed_rpm, load: [0.0, 300.0, 0.0, 0.0, 0.0], ..LoadRow::default() };
//!         // The points that are asked for are the file's noses.
//!         match solver.solve(&file.question(&loads)) {
//!             Ok(answer) => println!("{speed_rpm} 1/min: {:.0} N/um", 1e-6 / answer.at[0].compliance[1][1]),
//!             Err(status) => println!("{speed_rpm} 1/min: {status}"),
//!         }
//!     }
//! });
//! solved.map_err(|error| file.explain(&error))?;
//! # Ok::<(), spindle_file::reading::DesignFileError>(())
//! ```

pub mod dispatch;

use crate::dispatch::{
    Attitude, Precision, narrowed, wide, widened, widened_frequencies, widened_motion,
};
use spindle_bearing::{
    BallKinematics, BallState, Centrifugal, ErrorEstimate, Frequencies, Given, InnerRaceControl,
    Limit, LimitSet, Limits, Motion, OuterRaceControl, RacewayControlFree, Real, RowSolution,
    Settings, Speed, SpindleSolution, Static, Status,
};
use spindle_file::mounting::{DynSolver, DynSpindle, MOST_JOINTS, Parts, closed, growths};
use spindle_file::plan::{BuildError, MOST_BALLS, MOST_ROWS, Plan, Question, ShaftEnd};
use std::array::from_fn;

/// How the balls move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Balls {
    /// Balls at rest: the speed counts for frequencies alone.
    Static,
    /// At speed under centrifugal force alone.
    Centrifugal,
    /// At speed under centrifugal force and outer race control: of bearings alone.
    CentrifugalOuter,
    /// At speed with all inertia loads, raceway-control-free.
    Free,
    /// At speed with all inertia loads, under outer race control.
    Outer,
    /// At speed with all inertia loads, under inner race control.
    Inner,
}

impl Balls {
    /// The rule for the axis about which a ball turns, where that matters.
    pub fn rule(self) -> Attitude {
        match self {
            Self::Centrifugal | Self::Free => Attitude::Raceless,
            Self::Static | Self::CentrifugalOuter | Self::Outer => Attitude::Outer,
            Self::Inner => Attitude::Inner,
        }
    }
}

impl From<Attitude> for Balls {
    fn from(attitude: Attitude) -> Self {
        match attitude {
            Attitude::Raceless => Self::Free,
            Attitude::Outer => Self::Outer,
            Attitude::Inner => Self::Inner,
        }
    }
}

/// Word of [`Answer::passed`] for a row that has lifted off.
pub const LIFT_OFF: &str = "lift-off";

/// An equilibrium, widened to double.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// How the solve ended.
    pub status: Status<f32>,
    /// Iterations.
    pub iterations: u16,
    /// Displacement of the shaft at `x = 0`.
    pub displacement: [f64; 5],
    /// Stiffness there.
    pub stiffness: [[f64; 5]; 5],
    /// Load where loads act: reactions where displacements are given.
    pub load: [f64; 5],
    /// The points that were asked for.
    pub at: Vec<AtEnd>,
    /// Closure that the spring makes, m.
    pub spring_closure: f64,
    /// The rows.
    pub rows: Vec<RowAnswer>,
    /// Estimated errors of displacement, force and stiffness.
    pub error: [f64; 3],
}

impl Answer {
    /// Names of the limits that any row has passed, and `lift-off` where one has lifted off.
    pub fn passed(&self) -> Vec<&'static str> {
        let limits = self.rows.iter().map(|row| row.limits);
        let limits = limits.fold(LimitSet::default(), LimitSet::union);
        let lifted_off = self.rows.iter().any(|row| row.lifted_off);
        let lifted_off = lifted_off.then_some(LIFT_OFF);
        limits.iter().map(Limit::name).chain(lifted_off).collect()
    }
}

/// Displacement, stiffness and compliance of a point on the shaft.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AtEnd {
    /// Displacement of the shaft.
    pub displacement: [f64; 5],
    /// Estimated relative error of the displacement.
    pub displacement_error: f64,
    /// Stiffness, each column with all other displacements held: one over the compliance is what a force alone meets.
    pub stiffness: [[f64; 5]; 5],
    /// Compliance.
    pub compliance: [[f64; 5]; 5],
    /// Estimated relative errors of the compliance's diagonal.
    pub compliance_error: [f64; 5],
}

/// Load, stiffness and balls of a row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RowAnswer {
    /// Force on its inner ring, in its own frame.
    pub force: [f64; 5],
    /// Preload, N.
    pub preload: f64,
    /// Closure as ground, m; 0 if it slides under a spring.
    pub closure: f64,
    /// Limits that it has passed.
    pub limits: LimitSet,
    /// It carries nothing in its direction.
    pub lifted_off: bool,
    /// Stiffness of the row alone.
    pub stiffness: [[f64; 5]; 5],
    /// Stiffness between shaft and housing at the row, in the shaft's frame.
    pub stiffness_on_shaft: [[f64; 5]; 5],
    /// Displacement of the shaft there.
    pub displacement: [f64; 5],
    /// States of the balls.
    pub balls: Vec<BallState<f64>>,
    /// How they turn, and how their contacts are pressed.
    pub motions: Vec<BallKinematics<f64>>,
    /// Frequencies at which damage is heard.
    pub frequencies: Frequencies<f64>,
}

/// Parts of an answer that take time, and that not everybody wants: bits of a sum.
pub mod parts {
    /// Stiffness and compliance at the points that are asked for, besides their displacement.
    pub const AT: u8 = 1;
    /// Limits of the rows.
    pub const LIMITS: u8 = 2;
    /// States of the balls.
    pub const BALLS: u8 = 4;
    /// How they turn, and how their contacts are pressed.
    pub const MOTIONS: u8 = 8;
    /// Frequencies of the rows.
    pub const FREQUENCIES: u8 = 16;
    /// All of them.
    pub const ALL: u8 = AT | LIMITS | BALLS | MOTIONS | FREQUENCIES;
}

/// Settings of a solver, and what it works out.
#[derive(Debug, Clone, Copy)]
pub struct Choices {
    /// Limits of the rows.
    pub limits: Limits<f64>,
    /// Largest change of the stiffness along the last step; none for the library's default.
    pub tolerance: Option<f64>,
    /// Most iterations.
    pub max_iterations: u16,
    /// Parts of an answer that are worked out: a sum of [`parts`].
    pub parts: u8,
}

impl Default for Choices {
    fn default() -> Self {
        Self {
            limits: Limits::DEFAULT,
            tolerance: None,
            max_iterations: Settings::<f64>::DEFAULT.max_iterations,
            parts: parts::ALL,
        }
    }
}

impl Choices {
    /// The settings in a precision.
    pub fn settings<T: Real>(&self) -> Settings<T> {
        let tolerance = self.tolerance.map(T::of);
        Settings {
            tolerance: tolerance.unwrap_or(Settings::<T>::DEFAULT.tolerance),
            max_iterations: self.max_iterations,
        }
    }
}

/// Loads, or displacements, of the first `D` freedoms.
pub fn given<T: Real, const D: usize>(question: &Question) -> [Given<T>; D] {
    from_fn(|i| match question.held[i] {
        Some(u) => Given::Displacement(T::of(u)),
        None => Given::Load(T::of(question.load[i])),
    })
}

/// Estimated errors of displacement, force and stiffness in doubles.
pub fn in_doubles<T: Real>(error: &ErrorEstimate<T>) -> [f64; 3] {
    [error.displacement, error.force, error.stiffness].map(T::to_f64)
}

/// A solver for a spindle or a bearing.
pub trait AnySolver: Send {
    /// Solves.
    ///
    /// # Errors
    ///
    /// Why there is no answer.
    fn solve(&mut self, question: &Question) -> Result<Answer, Status<f32>>;

    /// Makes the next solves so.
    fn choose(&mut self, choices: &Choices);

    /// Makes the next solve a cold one.
    fn reset(&mut self);

    /// Another solver, with its choices.
    fn copy(&self) -> Box<dyn AnySolver + '_>;

    /// Solves what must have an answer.
    ///
    /// # Panics
    ///
    /// If it has none.
    fn answer(&mut self, question: &Question) -> Answer {
        let answer = self.solve(question);
        answer.unwrap_or_else(|status| panic!("{question:?}: {status}"))
    }

    /// Solves for a load at `x = 0`, N and N m, at a speed in rad/s.
    ///
    /// # Errors
    ///
    /// Why there is no answer.
    fn load(&mut self, load: [f64; 5], omega: f64) -> Result<Answer, Status<f32>> {
        self.solve(&Question::load(load, omega).at(0.0))
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
    f: impl FnOnce(&mut dyn AnySolver) -> O,
) -> Result<O, BuildError> {
    let (mut f, mut output) = (Some(f), None);
    let mut once = |solver: &mut dyn AnySolver| output = f.take().map(|f| f(solver));
    hand_solver(plan, balls, precision, &mut once)?;
    Ok(output.expect("whoever is handed a solver returns"))
}

/// [`with_solver`], without a type of the caller's in it: all solvers are compiled here, once, and not in each crate that calls.
fn hand_solver(
    plan: &Plan,
    balls: Balls,
    precision: Precision,
    f: &mut dyn FnMut(&mut dyn AnySolver),
) -> Result<(), BuildError> {
    let plan = closed(plan)?;
    match precision {
        Precision::F32 => f(&mut *solver(&Parts::<f32>::of(&plan)?, &plan, balls)?),
        Precision::F64 => f(&mut *solver(&Parts::<f64>::of(&plan)?, &plan, balls)?),
    }
    Ok(())
}

/// A solver for this motion of the balls, of a plan and its parts.
fn solver<'p, T: Real>(
    parts: &'p Parts<T>,
    plan: &Plan,
    balls: Balls,
) -> Result<Box<dyn AnySolver + 'p>, BuildError> {
    let (spindle, loaded_at) = (parts.spindle(plan)?, plan.loaded_at());
    Ok(match balls {
        Balls::Static => Chosen::<T, Static>::boxed(spindle, loaded_at),
        Balls::Centrifugal => Chosen::<T, Centrifugal>::boxed(spindle, loaded_at),
        Balls::CentrifugalOuter => {
            Chosen::<T, Centrifugal<OuterRaceControl>>::boxed(spindle, loaded_at)
        }
        Balls::Free => Chosen::<T, RacewayControlFree>::boxed(spindle, loaded_at),
        Balls::Outer => Chosen::<T, OuterRaceControl>::boxed(spindle, loaded_at),
        Balls::Inner => Chosen::<T, InnerRaceControl>::boxed(spindle, loaded_at),
    })
}

#[derive(Clone)]
struct Chosen<'p, T: Real, M: Motion> {
    spindle: DynSpindle<'p, T>,
    solver: DynSolver<T, M>,
    choices: Choices,
    /// Closure of each row, m.
    closures: Vec<f64>,
    /// Position of the solver's `x = 0` in the plan, m.
    loaded_at: f64,
}

impl<'p, T: Real, M: Motion> Chosen<'p, T, M> {
    fn boxed(spindle: DynSpindle<'p, T>, loaded_at: f64) -> Box<dyn AnySolver + 'p> {
        let closures = spindle.closures().map(T::to_f64).collect();
        Box::new(Self {
            closures,
            spindle,
            solver: DynSolver::of(),
            choices: Choices::default(),
            loaded_at,
        })
    }
}

impl<T: Real, M: Motion> AnySolver for Chosen<'_, T, M> {
    fn solve(&mut self, question: &Question) -> Result<Answer, Status<f32>> {
        let settings = self.choices.settings();
        let omega = if M::AT_SPEED { question.omega } else { 0.0 };
        let at = Speed::rad_per_s(T::of(omega)).with_growth(growths(&question.growth));
        // The solver's axial displacement does not have the growth of the rows' middle.
        let mut moved = question.clone();
        moved.held[0] = moved.held[0].map(|u| u + question.middle_growth);
        let (spindle, solver) = (&self.spindle, &mut self.solver);
        let solved = match question.held {
            [None, None, None, None, None] => {
                solver.solve(spindle, question.load.map(T::of), at, &settings)
            }
            _ => solver.solve(spindle, given::<T, 5>(&moved), at, &settings),
        };
        let solution = solved.map_err(narrowed)?;
        let mut answer = answer(
            &solution,
            &question.ends,
            self.loaded_at,
            &self.choices,
            &self.closures,
        );
        let of_ends = answer.at.iter_mut().map(|at| &mut at.displacement);
        let of_rows = answer.rows.iter_mut().map(|row| &mut row.displacement);
        let all = [&mut answer.displacement].into_iter().chain(of_ends);
        for displacement in all.chain(of_rows) {
            displacement[0] -= question.middle_growth;
        }
        Ok(answer)
    }

    fn choose(&mut self, choices: &Choices) {
        self.choices = *choices;
    }

    fn reset(&mut self) {
        self.solver.reset();
    }

    fn copy(&self) -> Box<dyn AnySolver + '_> {
        Box::new(self.clone())
    }
}

fn answer<T: Real, M: Motion>(
    solution: &SpindleSolution<'_, T, MOST_ROWS, MOST_BALLS, M, 6, MOST_JOINTS>,
    ends: &[ShaftEnd],
    loaded_at: f64,
    choices: &Choices,
    closures: &[f64],
) -> Answer {
    let error = &solution.error;
    let at = ends.iter().map(|end| {
        let x = T::of(end.position - loaded_at);
        let displacement = solution.displacement_at(x).map(T::to_f64);
        if choices.parts & parts::AT == 0 {
            return AtEnd {
                displacement,
                ..AtEnd::default()
            };
        }
        let mut compliance = wide(&solution.compliance_at(x));
        let mut compliance_error = solution.compliance_error_at(x).map(T::to_f64);
        let mut stiffness = wide(&solution.stiffness_at(x));
        for (i, by) in end.flexibility.into_iter().enumerate() {
            compliance_error[i] *= compliance[i][i] / (compliance[i][i] + by);
            compliance[i][i] += by;
            // A spring in series.
            let (k, taken) = (stiffness, by / (1.0 + by * stiffness[i][i]));
            stiffness = from_fn(|r| from_fn(|c| k[r][c] - k[r][i] * taken * k[i][c]));
        }
        AtEnd {
            displacement,
            displacement_error: solution.displacement_error_at(x).to_f64(),
            stiffness,
            compliance,
            compliance_error,
        }
    });
    let origin = T::of(0.0 - loaded_at);
    let displacement = match loaded_at {
        0.0 => solution.displacement,
        _ => solution.displacement_at(origin),
    };
    let rows = solution.rows().zip(closures).map(|(row, closure)| {
        let displacement = solution.displacement_at(row.position);
        row_answer(&row, displacement, *closure, choices)
    });
    Answer {
        status: narrowed(solution.status),
        iterations: solution.iterations,
        displacement: displacement.map(T::to_f64),
        stiffness: wide(&solution.stiffness_at(origin)),
        load: solution.load.map(T::to_f64),
        at: at.collect(),
        spring_closure: solution.spring_closure().to_f64(),
        rows: rows.collect(),
        error: in_doubles(error),
    }
}

fn row_answer<T: Real, M: Motion>(
    row: &RowSolution<'_, T, M>,
    displacement: [T; 5],
    closure: f64,
    choices: &Choices,
) -> RowAnswer {
    let wants = |part: u8| choices.parts & part != 0;
    let limits = Limits {
        peak_pressure: T::of(choices.limits.peak_pressure),
        friction: T::of(choices.limits.friction),
    };
    RowAnswer {
        closure,
        force: row.force.map(T::to_f64),
        preload: row.preload().to_f64(),
        limits: match wants(parts::LIMITS) {
            true => row.margins(&limits).passed(),
            false => LimitSet::default(),
        },
        lifted_off: row.is_lifted_off(),
        stiffness: wide(&row.stiffness()),
        stiffness_on_shaft: wide(&row.stiffness_on_shaft()),
        displacement: displacement.map(T::to_f64),
        balls: match wants(parts::BALLS) {
            true => row.balls().map(|ball| widened(&ball)).collect(),
            false => Vec::new(),
        },
        motions: match wants(parts::MOTIONS) {
            true => row.kinematics().map(|m| widened_motion(&m)).collect(),
            false => Vec::new(),
        },
        frequencies: match wants(parts::FREQUENCIES) {
            true => widened_frequencies(&row.frequencies()),
            false => Frequencies::default(),
        },
    }
}
