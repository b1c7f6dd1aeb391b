//! What the host's build of the solver answers, and how far that is from the reference build.
//!
//! The library gives the same bits on every core that rounds as IEEE 754 says, so errors are told here
//! once for all cores, and every answer of a core is compared with the host's bit by bit.

use crate::image::Motion;
use crate::rows::Start;
use crate::workload::{State, Work};
use anyhow::{Result, anyhow, bail};
use host_tests::cases;
use host_tests::compare::{Ball, Equilibrium, Race};
use host_tests::dispatch::{Attitude, Precision};
use rayon::prelude::*;
use spindle_bearing::{
    BallState, Design, InnerRaceControl, OuterRaceControl, RacewayControlFree, Real,
};
use spindle_bearing::{Bearing, Full, Settings, Solver, Speed, Static};

/// When a solve stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// At the precision's default tolerance.
    Default,
    /// At this tolerance.
    Tolerance(f64),
}

impl Limit {
    /// Tolerance and largest number of iterations.
    pub fn settings(self, precision: Precision) -> (f64, u16) {
        let tolerance = match self {
            Self::Default => match precision {
                Precision::F32 => f32::TOLERANCE.into(),
                Precision::F64 => f64::TOLERANCE,
            },
            Self::Tolerance(tolerance) => tolerance,
        };
        (tolerance, 100)
    }

    /// A metric's name with the limit behind it.
    pub fn metric(self, of: &str) -> String {
        match self {
            Self::Default => of.to_owned(),
            Self::Tolerance(tolerance) => format!("{of}, tolerance {tolerance:e}"),
        }
    }
}

/// What a solve starts from, and when it stops.
pub type Task = (Start, Limit);

/// An answer of the host.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Displacement, m and rad.
    pub displacement: [f64; 5],
    /// Stiffness, SI.
    pub stiffness: [[f64; 5]; 5],
    /// Iterations.
    pub iterations: u16,
    /// Errors of displacement, force and stiffness, if the reference build knows the equilibrium.
    pub errors: Option<[f64; 3]>,
    /// It is another equilibrium than the one that double precision found, and is compared with that.
    pub other: bool,
}

/// Error of the displacement beyond which an answer may be one of another equilibrium: at speed there may be several.
const FAR: f64 = 1e-3;

/// The equilibria of a case, cold and a tick later, as far as they are known.
pub type Truth = [Option<Equilibrium>; 2];

/// What a solver found, widened to double, which is exact.
pub struct Found {
    equilibrium: Equilibrium,
    /// Positions of the balls' centres, m.
    centres: Vec<(f64, f64)>,
    iterations: u16,
}

/// A precision in which a bearing's constants are worked out.
pub trait Host: Real {
    /// Of a design that stands for a case.
    fn built<const N: usize>(design: &Design) -> Result<Bearing<Self, N>>;
}

macro_rules! host {
    ($t:ident) => {
        impl Host for $t {
            fn built<const N: usize>(design: &Design) -> Result<Bearing<Self, N>> {
                Bearing::<$t, N>::new(design)
                    .map_err(|e| anyhow!("the solver refuses a design of its own cases: {e}"))
            }
        }
    };
}
host!(f32);
host!(f64);

/// A solver of any precision, ball count and motion.
pub trait AnySolver {
    /// Has the next solve start from nothing.
    fn reset(&mut self);
    /// Solves, within a tolerance and a number of iterations.
    fn solve(&mut self, state: State, limit: (f64, u16)) -> Option<Found>;
}

struct Hosted<'b, T: Real, const N: usize, M: spindle_bearing::Motion> {
    solver: Solver<'b, T, N, M>,
    /// From the outer groove's centre to an unloaded ball's, m.
    lo: f64,
}

impl<T: Real, const N: usize, M: spindle_bearing::Motion> AnySolver for Hosted<'_, T, N, M> {
    fn reset(&mut self) {
        self.solver.reset();
    }

    fn solve(
        &mut self,
        (load, omega): State,
        (tolerance, max_iterations): (f64, u16),
    ) -> Option<Found> {
        let settings = Settings {
            max_iterations,
            tolerance: T::of(tolerance),
        };
        let speed = Speed::rad_per_s(T::of(omega));
        let solution = self.solver.solve(load.map(T::of), speed, &settings).ok()?;
        let lo = self.lo;
        let centre = |ball: &BallState<T>| {
            let (sin, cos) = ball.alpha_o.to_f64().sin_cos();
            let radius = lo + ball.delta_o.to_f64();
            (radius * sin, radius * cos)
        };
        let balls: Vec<_> = solution.balls().collect();
        Some(Found {
            equilibrium: Equilibrium {
                displacement: solution.displacement.map(T::to_f64),
                stiffness: solution.stiffness().map(|row| row.map(T::to_f64)),
                balls: balls.iter().map(ball).collect(),
            },
            centres: balls.iter().map(centre).collect(),
            iterations: solution.iterations,
        })
    }
}

fn ball<T: Real>(ball: &BallState<T>) -> Ball {
    let race = |angle: T, force: T| Race {
        angle: angle.to_f64(),
        force: force.to_f64(),
    };
    Ball {
        inner: race(ball.alpha_i, ball.q_i),
        outer: race(ball.alpha_o, ball.q_o),
        centrifugal_force: ball.centrifugal_force.to_f64(),
        gyroscopic_moment: ball.gyroscopic_moment.to_f64(),
    }
}

/// Hands a solver to a function.
fn with_solver<R>(
    design: &Design,
    balls: usize,
    precision: Precision,
    motion: Motion,
    with: impl FnOnce(&mut dyn AnySolver) -> R,
) -> Result<R> {
    macro_rules! choose {
        ($($t:ident $n:literal)*) => {
            match (precision, balls) {
                $((Precision::$t, $n) => hosted::<choose!(@ $t), $n, R>(design, motion, with),)*
                _ => bail!("no host's solver has {balls} balls"),
            }
        };
        (@ F32) => { f32 };
        (@ F64) => { f64 };
    }
    choose!(F32 7 F32 16 F32 30 F64 7 F64 16 F64 30)
}

fn hosted<T: Host, const N: usize, R>(
    design: &Design,
    motion: Motion,
    with: impl FnOnce(&mut dyn AnySolver) -> R,
) -> Result<R> {
    let bearing = T::built::<N>(design)?;
    let lo = (design.outer_groove_factor - 0.5) * design.ball_diameter;
    macro_rules! moving {
        ($motion:ty) => {
            with(&mut Hosted {
                solver: Solver::<T, N, $motion>::of(&bearing),
                lo,
            })
        };
    }
    Ok(match motion {
        Motion::AtSpeed(Attitude::Raceless) => moving!(Full<RacewayControlFree>),
        Motion::AtSpeed(Attitude::Outer) => moving!(Full<OuterRaceControl>),
        Motion::AtSpeed(Attitude::Inner) => moving!(Full<InnerRaceControl>),
        Motion::Static => moving!(Static),
    })
}

/// A bearing and how its balls move: what has equilibria.
#[derive(Debug, Clone, Copy)]
pub struct Ground<'w> {
    pub design: &'w Design,
    pub balls: usize,
    pub motion: Motion,
}

impl Ground<'_> {
    /// The reference build's equilibrium next to an answer, to 1e-13 and better.
    fn near(&self, (load, omega): State, found: &Found) -> Option<Equilibrium> {
        let rule = match self.motion {
            Motion::AtSpeed(attitude) => attitude,
            Motion::Static => Attitude::Raceless,
        };
        let reference = cases::reference(self.design, self.balls);
        let u = found.equilibrium.displacement;
        let truth = reference.polish_near(load, omega, rule.into(), u, &found.centres);
        truth.ok().map(|truth| Equilibrium::from(&truth))
    }

    /// How far an answer is from the truth.
    fn judged(&self, state: State, found: &Found, truth: Option<&Equilibrium>) -> Sample {
        let equilibrium = &found.equilibrium;
        let errors = |truth: &Equilibrium| {
            let (d, dm) = (self.design.ball_diameter, self.design.pitch_diameter);
            let e = equilibrium.errors(truth, d, 0.5 * dm);
            [e.displacement, e.force, e.stiffness]
        };
        let mut sample = Sample {
            displacement: equilibrium.displacement,
            stiffness: equilibrium.stiffness,
            iterations: found.iterations,
            errors: truth.map(errors),
            other: false,
        };
        if sample.errors.is_some_and(|e| e[0] > FAR) {
            let own = self.near(state, found).map(|own| errors(&own));
            if let Some(own) = own.filter(|own| own[0] <= FAR) {
                sample.errors = Some(own);
                sample.other = true;
            }
        }
        sample
    }

    fn with<R>(
        &self,
        precision: Precision,
        with: impl FnOnce(&mut dyn AnySolver) -> R,
    ) -> Result<R> {
        with_solver(self.design, self.balls, precision, self.motion, with)
    }
}

/// The reference build's equilibria, each found from the solver's in doubles.
pub fn truths(works: &[Work], motion: Motion, balls: usize) -> Result<Vec<Truth>> {
    let default = Limit::Default.settings(Precision::F64);
    works
        .par_iter()
        .map(|work| {
            let ground = Ground {
                design: &work.design,
                balls,
                motion,
            };
            ground.with(Precision::F64, |solver| {
                [work.cold, work.warm].map(|state| {
                    let found = solver.solve(state, default)?;
                    ground.near(state, &found)
                })
            })
        })
        .collect()
}

/// The host's answers to every task, by task and case; none where there is no answer.
pub fn samples(
    works: &[Work],
    truths: &[Truth],
    precision: Precision,
    motion: Motion,
    balls: usize,
    tasks: &[Task],
) -> Result<Vec<Vec<Option<Sample>>>> {
    let by_case: Vec<Vec<Option<Sample>>> = works
        .par_iter()
        .zip(truths)
        .map(|(work, truth)| {
            let ground = Ground {
                design: &work.design,
                balls,
                motion,
            };
            ground.with(precision, |solver| {
                let sample = |(start, limit): &Task| {
                    let (state, truth) = match start {
                        Start::Cold => (work.cold, &truth[0]),
                        Start::Warm => (work.warm, &truth[1]),
                    };
                    solver.reset();
                    if *start == Start::Warm {
                        solver.solve(work.cold, Limit::Default.settings(precision))?;
                    }
                    let found = solver.solve(state, limit.settings(precision))?;
                    Some(ground.judged(state, &found, truth.as_ref()))
                };
                tasks.iter().map(sample).collect()
            })
        })
        .collect::<Result<_>>()?;
    Ok((0..tasks.len())
        .map(|task| by_case.iter().map(|case| case[task].clone()).collect())
        .collect())
}

/// The host's answers to one state after the other, each from the last; the errors of every `each`th.
pub fn in_turn(
    ground: Ground<'_>,
    states: &[State],
    limit: Limit,
    each: usize,
) -> Result<Vec<Option<Sample>>> {
    let precision = Precision::F32;
    let found: Vec<Option<Found>> = ground.with(precision, |solver| {
        let settings = limit.settings(precision);
        states
            .iter()
            .map(|state| solver.solve(*state, settings))
            .collect()
    })?;
    Ok(found
        .into_par_iter()
        .zip(states)
        .enumerate()
        .map(|(i, (found, state))| {
            let found = found?;
            let truth = if i % each == 0 {
                ground.near(*state, &found)
            } else {
                None
            };
            Some(ground.judged(*state, &found, truth.as_ref()))
        })
        .collect())
}
