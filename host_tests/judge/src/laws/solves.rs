//! Any bearing, any settings, any sequence of loads, displacements, speeds and growths.
//!
//! No panic, every figure of an answer a number, no more iterations than allowed, and a refusal does no harm.

use crate::laws::common::{
    Answer, Asked, Ends, Scale, design, growth, inspect, refused, run_of, settings, settings_in,
    several, signed, unharmed,
};
use arbitrary::{Arbitrary, Result, Unstructured};
use spindle_bearing::{
    AxialSolver, Bearing, Centrifugal, Design, Given, Growth, InnerRaceControl, Motion,
    OuterRaceControl, RacewayControlFree, Real, Settings, Solver, Speed, Static,
};
use std::array::from_fn;
use std::fmt::Debug;

/// Steps of one run: enough for warm starts, few enough for many runs.
const MOST_STEPS: usize = 8;

/// A bearing, and what is asked of it.
#[derive(Debug)]
pub struct Run {
    /// Numbers of the ball count, the precision, the motion and the freedoms of the ring.
    scene: [u8; 4],
    design: Design,
    /// The default, or these.
    settings: Option<Settings<f64>>,
    steps: Vec<Step>,
}

impl Arbitrary<'_> for Run {
    fn arbitrary(u: &mut Unstructured) -> Result<Self> {
        Ok(Self {
            scene: u.arbitrary()?,
            design: design(u)?,
            settings: settings(u)?,
            steps: steps(u)?,
        })
    }
}

/// Numbers relative to what the bearing can take.
#[derive(Debug)]
enum Step {
    /// Loads, or displacements, and a speed.
    Solve([Given<f64>; 5], f64),
    /// The last loads, displacements and speed times these: mostly a warm start.
    Nudge([f64; 5], f64),
    /// Axial and radial growth of the rings, growth of the balls: for the solves to come.
    Grow([f64; 3]),
    Reset,
}

/// Mostly a load.
fn given(u: &mut Unstructured) -> Result<Given<f64>> {
    Ok(match u.ratio(3, 4)? {
        true => Given::Load(signed(u, 1e-12, 10.0)?),
        false => Given::Displacement(signed(u, 1e-9, 3.0)?),
    })
}

fn steps(u: &mut Unstructured) -> Result<Vec<Step>> {
    let mut steps = Vec::new();
    while steps.len() < MOST_STEPS && !u.is_empty() {
        steps.push(match u.int_in_range(0..=7)? {
            0..=3 => Step::Solve(several(|_| given(u))?, signed(u, 1e-6, 3.0)?),
            4..=5 => Step::Nudge(several(|_| signed(u, 0.3, 3.0))?, signed(u, 0.3, 3.0)?),
            6 => Step::Grow(several(|_| signed(u, 1e-6, 0.3))?),
            _ => Step::Reset,
        });
    }
    Ok(steps)
}

/// Runs a kept input as its target does; how its solves ended.
pub fn replay(input: &[u8]) -> Ends {
    check(&run_of(input))
}

/// Runs it; how its solves ended. A law that is broken is a panic.
pub fn check(run: &Run) -> Ends {
    match run.scene[0] % 3 {
        0 => with_balls::<3>(run),
        1 => with_balls::<16>(run),
        _ => with_balls::<31>(run),
    }
}

fn with_balls<const N: usize>(run: &Run) -> Ends {
    match run.scene[1] % 2 {
        0 => in_precision::<f32, N>(run),
        _ => in_precision::<f64, N>(run),
    }
}

fn in_precision<T: Real, const N: usize>(run: &Run) -> Ends {
    match Bearing::<T, N>::of(&run.design) {
        Err(error) => refused(&error),
        Ok(bearing) => match run.scene[2] % 5 {
            0 => with_ring::<T, N, Static>(run, &bearing),
            1 => with_ring::<T, N, Centrifugal>(run, &bearing),
            2 => with_ring::<T, N, RacewayControlFree>(run, &bearing),
            3 => with_ring::<T, N, OuterRaceControl>(run, &bearing),
            _ => with_ring::<T, N, InnerRaceControl>(run, &bearing),
        },
    }
}

fn with_ring<T: Real, const N: usize, M: Motion + Copy + Debug>(
    run: &Run,
    bearing: &Bearing<T, N>,
) -> Ends {
    match run.scene[3] % 3 {
        0 => {
            let fresh = AxialSolver::<T, M>::of;
            let ask = |solver: &mut _, q: &_, settings: &_| ask_axial(bearing, solver, q, settings);
            solve(run, N, fresh, AxialSolver::reset, ask)
        }
        1 => {
            let fresh = Solver::<T, N, M, 3>::of;
            let ask = |solver: &mut _, q: &_, settings: &_| ask(bearing, solver, q, settings);
            solve(run, N, fresh, Solver::reset, ask)
        }
        _ => {
            let fresh = Solver::<T, N, M, 5>::of;
            let ask = |solver: &mut _, q: &_, settings: &_| ask(bearing, solver, q, settings);
            solve(run, N, fresh, Solver::reset, ask)
        }
    }
}

/// A question to a solver.
#[derive(Debug, Clone, Copy)]
struct Question<T> {
    /// Of five freedoms; a ring with fewer has the first ones.
    given: [Given<T>; 5],
    omega: T,
    growth: Growth<T>,
}

/// Asks a solver of a ring with 3 or 5 freedoms.
fn ask<T: Real, const N: usize, M: Motion, const D: usize>(
    bearing: &Bearing<T, N>,
    solver: &mut Solver<T, N, M, D>,
    question: &Question<T>,
    settings: &Settings<T>,
) -> Asked<T> {
    let given: [Given<T>; D] = from_fn(|i| question.given[i]);
    let at = Speed::rad_per_s(question.omega).with_growth([question.growth]);
    let s = solver.solve(bearing, given, at, settings)?;
    assert!(s.inner_forces().eq(s.balls().map(|ball| ball.q_i)));
    let figures = s.stiffness().into_iter().flatten();
    let figures = figures.chain(s.displacement).chain(s.load);
    Ok(Answer {
        status: s.status,
        iterations: s.iterations,
        error: s.error,
        figures: figures.chain(s.cage_speeds()).collect(),
        balls: s.balls().collect(),
    })
}

/// Asks a solver of a ring with one freedom.
fn ask_axial<T: Real, const N: usize, M: Motion>(
    bearing: &Bearing<T, N>,
    solver: &mut AxialSolver<T, M>,
    question: &Question<T>,
    settings: &Settings<T>,
) -> Asked<T> {
    let at = Speed::rad_per_s(question.omega).with_growth([question.growth]);
    let s = solver.solve(bearing, question.given[0], at, settings)?;
    Ok(Answer {
        status: s.status,
        iterations: s.iterations,
        error: s.error,
        figures: vec![s.stiffness(), s.displacement, s.load],
        balls: vec![s.ball()],
    })
}

fn scaled<T: Real>(scale: &Scale, i: usize, given: Given<f64>) -> Given<T> {
    match given {
        Given::Load(x) => Given::Load(T::of(x * scale.load[i])),
        Given::Displacement(x) => Given::Displacement(T::of(x * scale.displacement[i])),
    }
}

fn times<T: Real>(given: Given<T>, factor: f64) -> Given<T> {
    match given {
        Given::Load(x) => Given::Load(x * T::of(factor)),
        Given::Displacement(x) => Given::Displacement(x * T::of(factor)),
    }
}

fn solve<T: Real, S: Clone>(
    run: &Run,
    balls: usize,
    fresh: impl Fn() -> S,
    reset: impl Fn(&mut S),
    ask: impl Fn(&mut S, &Question<T>, &Settings<T>) -> Asked<T>,
) -> Ends {
    let scale = Scale::of(&run.design, balls);
    let settings = settings_in(run.settings);
    // Something near, so that a solver would start from what it remembers.
    let probe = |solver: &S, near: &Question<T>| {
        let question = Question {
            given: near.given.map(|given| times(given, 0.9)),
            ..*near
        };
        format!(
            "{:?}",
            ask(&mut solver.clone(), &question, &Settings::default())
        )
    };
    let (mut solver, mut ends) = (fresh(), Ends::new());
    let light = [1e-4, 1e-5, 0.0, 1e-6, 0.0];
    let mut question = Question {
        given: from_fn(|i| scaled(&scale, i, Given::Load(light[i]))),
        omega: T::ZERO,
        growth: Growth::NONE,
    };
    // The last question that was not refused for what it is.
    let mut tried = question;
    for step in &run.steps {
        let before = solver.clone();
        match step {
            Step::Reset => {
                reset(&mut solver);
                continue;
            }
            Step::Grow(lengths) => {
                question.growth = growth(lengths.map(|x| x * scale.displacement[0]));
                continue;
            }
            Step::Solve(given, omega) => {
                question.given = from_fn(|i| scaled(&scale, i, given[i]));
                question.omega = T::of(omega * scale.speed);
            }
            Step::Nudge(factors, factor) => {
                question.given = from_fn(|i| times(question.given[i], factors[i]));
                question.omega = question.omega * T::of(*factor);
            }
        }
        let most = settings.max_iterations.max(1);
        let ended = inspect(ask(&mut solver, &question, &settings), most);
        ends.insert(ended.name());
        tried = unharmed(&ended, [&solver, &before, &fresh()], tried, question, probe);
    }
    ends
}
