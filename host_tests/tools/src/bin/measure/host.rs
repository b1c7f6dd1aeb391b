//! What the host's build of the solver answers, and how far that is from the reference build.
//!
//! The library gives the same bits on every core that rounds as IEEE 754 says, so errors are told here
//! once for all cores, and every answer of a core is compared with the host's bit by bit.

use crate::image::Motion;
use crate::rows::Start;
use crate::workload::Work;
use anyhow::{Result, anyhow};
use host_tests::cases;
use host_tests::compare::{Ball, Equilibrium};
use host_tests::dispatch::{self, AnySolver, Attitude, Precision};
use host_tests::reference::Reference;
use rayon::prelude::*;
use spindle_bearing::{BallState, Real};

/// When a solve stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// At the precision's default tolerance.
    Default,
    /// There, or after so many sweeps.
    Sweeps(u16),
    /// At this tolerance.
    Tolerance(f64),
}

impl Limit {
    /// Tolerance and largest number of sweeps.
    pub fn settings(self, precision: Precision) -> (f64, u16) {
        let default = match precision {
            Precision::F32 => f32::TOLERANCE.into(),
            Precision::F64 => f64::TOLERANCE,
        };
        match self {
            Self::Default => (default, 100),
            Self::Sweeps(most) => (default, most),
            Self::Tolerance(tolerance) => (tolerance, 100),
        }
    }

    /// A metric's name with the limit behind it.
    pub fn metric(self, of: &str) -> String {
        match self {
            Self::Default => of.to_owned(),
            Self::Sweeps(1) => format!("{of}, at most 1 sweep"),
            Self::Sweeps(most) => format!("{of}, at most {most} sweeps"),
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
    /// Sweeps.
    pub sweeps: u16,
    /// Converged, or as good as the precision allows.
    pub solved: bool,
    /// Errors of displacement, force and stiffness, if the reference build knows the equilibrium.
    pub errors: Option<[f64; 3]>,
    /// It is another equilibrium than the one that double precision found, and is compared with that.
    pub other: bool,
}

/// Error of the displacement beyond which an answer that counts as solved may be one of another
/// equilibrium: at speed there may be several.
const FAR: f64 = 1e-3;

/// The equilibria of a case, cold and a tick later, as far as they are known.
pub type Truth = [Option<Equilibrium>; 2];

fn solver<'b>(bearing: &'b dyn dispatch::AnyBearing, motion: Motion) -> Box<dyn AnySolver + 'b> {
    match motion {
        Motion::AtSpeed(attitude) => bearing.solver(attitude),
        Motion::Static => bearing.static_solver(),
    }
}

fn solved(status: &str) -> bool {
    matches!(status, "converged" | "precision-limit")
}

fn bearing(
    work: &Work,
    balls: usize,
    precision: Precision,
) -> Result<Box<dyn dispatch::AnyBearing>> {
    dispatch::bearing(&work.design, balls, precision)
        .map_err(|e| anyhow!("the solver refuses a design of its own cases: {e}"))
}

/// The reference build's equilibria, to 1e-13 and better, each found from the solver's in doubles.
pub fn truths(works: &[Work], motion: Motion, balls: usize) -> Result<Vec<Truth>> {
    works
        .par_iter()
        .map(|work| {
            let reference = cases::reference(&work.design, balls);
            let built = bearing(work, balls, Precision::F64)?;
            let mut solver = solver(&*built, motion);
            Ok([work.cold, work.warm].map(|(load, omega)| {
                let mut states: Vec<BallState<f64>> = Vec::new();
                let answer = solver.solve_with_balls(load, omega, Some(&mut states));
                let figures = answer.figures.ok().filter(|_| solved(answer.status))?;
                near(
                    &reference,
                    work,
                    motion,
                    (load, omega),
                    figures.displacement,
                    &states,
                )
            }))
        })
        .collect()
}

/// The reference build's equilibrium next to an answer.
fn near(
    reference: &Reference,
    work: &Work,
    motion: Motion,
    (load, omega): ([f64; 5], f64),
    displacement: [f64; 5],
    balls: &[BallState<f64>],
) -> Option<Equilibrium> {
    let rule = match motion {
        Motion::AtSpeed(attitude) => attitude,
        Motion::Static => Attitude::Raceless,
    };
    let lo = (work.design.outer_groove_factor - 0.5) * work.design.ball_diameter;
    let centres: Vec<(f64, f64)> = balls
        .iter()
        .map(|ball| {
            let (sin, cos) = ball.alpha_o.sin_cos();
            ((lo + ball.delta_o) * sin, (lo + ball.delta_o) * cos)
        })
        .collect();
    let truth = reference.polish_near(load, omega, rule.into(), displacement, &centres);
    truth.ok().map(|truth| Equilibrium::from(&truth))
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
            let built = bearing(work, balls, precision)?;
            let mut solver = solver(&*built, motion);
            Ok(tasks
                .iter()
                .map(|task| sample(&mut *solver, work, motion, truth, *task))
                .collect())
        })
        .collect::<Result<_>>()?;
    Ok((0..tasks.len())
        .map(|task| by_case.iter().map(|case| case[task].clone()).collect())
        .collect())
}

fn sample(
    solver: &mut dyn AnySolver,
    work: &Work,
    motion: Motion,
    truth: &Truth,
    (start, limit): Task,
) -> Option<Sample> {
    let precision = solver.precision();
    let set = |solver: &mut dyn AnySolver, limit: Limit| {
        let (tolerance, sweeps) = limit.settings(precision);
        solver.set_settings(tolerance, sweeps);
    };
    solver.forget();
    let ((load, omega), truth) = match start {
        Start::Cold => (work.cold, &truth[0]),
        Start::Warm => {
            set(solver, Limit::Default);
            if !solved(solver.solve(work.cold.0, work.cold.1).status) {
                return None;
            }
            (work.warm, &truth[1])
        }
    };
    set(solver, limit);
    let mut balls = Vec::new();
    let answer = solver.solve_with_balls(load, omega, Some(&mut balls));
    let figures = answer.figures.ok()?;
    let found = Equilibrium {
        displacement: figures.displacement,
        stiffness: figures.stiffness,
        balls: balls.iter().map(Ball::from).collect(),
    };
    let errors = |truth: &Equilibrium| {
        let design = &work.design;
        let e = found.errors(truth, design.ball_diameter, 0.5 * design.pitch_diameter);
        [e.displacement, e.force, e.stiffness]
    };
    let mut sample = Sample {
        displacement: figures.displacement,
        stiffness: figures.stiffness,
        sweeps: figures.sweeps,
        solved: solved(answer.status),
        errors: truth.as_ref().map(errors),
        other: false,
    };
    if sample.solved && sample.errors.is_some_and(|e| e[0] > FAR) {
        let reference = cases::reference(&work.design, balls.len());
        let state = (load, omega);
        let own = near(
            &reference,
            work,
            motion,
            state,
            figures.displacement,
            &balls,
        );
        if let Some(own) = own.map(|own| errors(&own)).filter(|own| own[0] <= FAR) {
            sample.errors = Some(own);
            sample.other = true;
        }
    }
    Some(sample)
}
