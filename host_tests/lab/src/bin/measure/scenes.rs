//! The scenes, solved on emulated cores and on the host, whose answers must be equal to the last bit.

use crate::bench::{Answer, Bench};
use crate::image::Image;
use crate::machine::Count;
use crate::parts;
use crate::timing::Core;
use crate::unwanted::Unwanted;
use anyhow::{Context, Result, ensure};
use judge::campaign::report::{Spread, name};
use lab::report::Figures;
use lab::solves::{BALLS, STARTS, Work};
use lab::{Axial, Clamped, Elastic, Ring, Sprung};
use rayon::prelude::*;
use solvers::dispatch::Precision;
use spindle_bearing::{Bearing, Centrifugal, RacewayControlFree, Real, Settings, Static};
use spindle_bearing::{InnerRaceControl, OuterRaceControl};
use std::collections::BTreeMap;
use std::path::Path;

/// Cases whose stack is measured.
const STACKS: usize = 20;

/// Answers by tolerance, cold and warm; none where there is no solution.
type Answers = Vec<[Option<Answer>; 2]>;

/// A scene of the table in `host_tests/lab`.
pub struct Scene {
    /// Its name.
    pub name: &'static str,
    /// The parts that it leaves out of the full scene, or has besides.
    pub without: &'static str,
    freedoms: usize,
    at_speed: bool,
    /// The host's build in single and in double precision.
    host: [Solver; 2],
}

/// Answers to a case at these tolerances.
type Solver = fn(&Work, &[f64]) -> Result<Answers>;

macro_rules! scenes {
    ($($number:literal $name:literal $freedoms:literal: $scene:ty; $without:literal, $parts:tt;)*) => {
        /// All, the full one last.
        pub const SCENES: &[Scene] = &[$(Scene {
            name: $name,
            without: $without,
            freedoms: $freedoms,
            at_speed: <$scene as lab::Scene<f32, BALLS, $freedoms>>::AT_SPEED,
            host: [answers::<f32, $scene, $freedoms>, answers::<f64, $scene, $freedoms>],
        }),*];
    };
}
lab::for_every_scene!(scenes);

/// The host's answers: cold, and warm after a cold solve at the first tolerance.
fn answers<T: Real, S: lab::Scene<T, BALLS, D>, const D: usize>(
    work: &Work,
    tolerances: &[f64],
) -> Result<Answers> {
    let bearing = Bearing::<T, BALLS>::of(&work.design)?;
    let question = |start: usize, tolerance: f64| work.question::<T, S, D>(start, T::of(tolerance));
    let told = |answer: lab::Answer<T, D>| {
        let numbers = answer
            .displacement
            .iter()
            .chain(answer.stiffness.as_flattened());
        Answer::new(numbers.map(|number| number.to_f64()), answer.iterations)
    };
    let solver = || S::solver(&bearing, &work.design).context("no such solver");
    tolerances
        .iter()
        .map(|tolerance| {
            let cold = S::solve(&mut solver()?, &question(0, *tolerance));
            let mut solver = solver()?;
            let warm = S::solve(&mut solver, &question(0, tolerances[0]))
                .and_then(|_| S::solve(&mut solver, &question(1, *tolerance)));
            Ok([cold, warm].map(|answer| answer.map(told)))
        })
        .collect()
}

/// A scene on a core.
pub struct Program {
    /// The core.
    pub core: Core,
    /// Working precision.
    pub precision: Precision,
    /// The scene.
    pub scene: &'static Scene,
    /// Tolerances, the default one first, then a tick's.
    pub tolerances: Vec<f64>,
}

/// A solve on the core.
pub struct Solve {
    /// Number of the case.
    pub case: usize,
    /// Its counts.
    pub count: Count,
    /// The answer, if there is a solution.
    pub answer: Option<Answer>,
}

/// The figures of a program.
pub struct Measured {
    /// The program.
    pub program: Program,
    /// Solves by tolerance, cold and warm; a warm one follows a solution.
    pub solves: Vec<[Vec<Solve>; 2]>,
    /// Bytes of flash, state and worst stack.
    pub bytes: [u64; 3],
}

/// The figure of a warm solve to the tolerance of a tick.
pub const TICK: &str = "warm tick, cycles, median";

/// Names of the bytes.
pub const BYTES: [&str; 3] = ["flash", "state", "stack"];

/// The scene that all others are compared with.
pub const FULL: &Scene = &SCENES[SCENES.len() - 1];

/// The gate's programs: all scenes on the smaller core, and the full one on the larger.
pub fn programs() -> Vec<Program> {
    let scenes = SCENES.iter();
    scenes
        .map(|scene| Program::new(Core::M4f, Precision::F32, scene))
        .chain([Program::new(Core::M7, Precision::F64, FULL)])
        .collect()
}

/// Builds, proves and measures programs. One is built while others are measured.
pub fn run(root: &Path, programs: Vec<Program>, works: &[Work]) -> Result<Vec<Measured>> {
    let build = |program: Program| -> Result<_> {
        let (core, precision) = (program.core, program.precision);
        let scene = Some(program.scene.name);
        let image = Image::build(root, core, "measured", precision, scene)?;
        Ok((image, program))
    };
    let built = programs.into_iter().map(build).enumerate().par_bridge();
    let measured = built.map(|(number, built)| {
        let (image, program) = built?;
        let name = program.name();
        eprintln!("{name}");
        let kinds: &[Unwanted] = match program.precision {
            Precision::F32 => &Unwanted::ALL,
            Precision::F64 => &Unwanted::IN_DOUBLE,
        };
        let parts = parts::prove(root, program.scene.name, &image.program, kinds)?;
        Ok((
            number,
            (program.measure(image, works).context(name)?, parts),
        ))
    });
    let measured: Result<BTreeMap<_, _>> = measured.collect();
    let (measured, parts): (_, Vec<_>) = measured?.into_values().unzip();
    parts::all_seen(&parts.into_iter().flatten().collect())?;
    Ok(measured)
}

impl Program {
    /// A program at the default tolerance, and at a tick's.
    pub fn new(core: Core, precision: Precision, scene: &'static Scene) -> Self {
        let tolerance = match precision {
            Precision::F32 => Settings::<f32>::DEFAULT.tolerance.into(),
            Precision::F64 => Settings::<f64>::DEFAULT.tolerance,
        };
        Self {
            core,
            precision,
            scene,
            tolerances: vec![tolerance, Settings::<f64>::TICK.tolerance],
        }
    }

    /// Its name in figures.
    pub fn name(&self) -> String {
        format!(
            "{}, {}, {}",
            self.core.name(),
            name(self.precision),
            self.scene.name
        )
    }

    /// Fails if an answer of the core is not the host's to the last bit.
    fn measure(self, image: Image, works: &[Work]) -> Result<Measured> {
        let mut bench = Bench::new(image, self.core, self.precision, self.scene.freedoms)?;
        let host = self.scene.host[self.precision as usize];
        let default = self.tolerances[0];
        let mut solves: Vec<[Vec<Solve>; 2]> = Vec::new();
        solves.resize_with(self.tolerances.len(), Default::default);
        let mut stack = 0;
        for (case, work) in works.iter().enumerate() {
            let expected = host(work, &self.tolerances)?;
            bench.bearing(&work.design)?;
            // The memory before a cold solve, and before a warm one.
            let cold = bench.machine.memory()?;
            let states = [0, 1].map(|start| work.state(start, self.scene.at_speed));
            bench.solve(states[0], default)?;
            let memories = [cold, bench.machine.memory()?];
            // After a load without a solution, a warm solve would be another cold one.
            let starts = if expected[0][0].is_some() { 2 } else { 1 };
            for start in 0..starts {
                for (i, tolerance) in self.tolerances.iter().enumerate() {
                    bench.machine.restore(&memories[start])?;
                    let (answer, count) = bench.solve(states[start], *tolerance)?;
                    ensure!(
                        answer == expected[i][start],
                        "case {case}, {}, tolerance {tolerance:e}: the core's answer is not the host's.\n\
                         {answer:?}\n{:?}",
                        STARTS[start],
                        expected[i][start]
                    );
                    solves[i][start].push(Solve {
                        case,
                        count,
                        answer,
                    });
                }
                if case < STACKS {
                    bench.machine.restore(&memories[start])?;
                    stack = stack.max(bench.stack(states[start], default)?);
                }
            }
        }
        Ok(Measured {
            bytes: [bench.image.flash(), bench.state()?, stack],
            program: self,
            solves,
        })
    }
}

impl Measured {
    /// The figures that are held on to: of all solves at the default tolerance, and of a warm one in a tick.
    pub fn figures(&self) -> Figures {
        let name = self.program.name();
        let mut figures = Figures::new();
        figures.insert(
            format!("{name}: {TICK}"),
            cycles(&self.solves[1][1]).median as u64,
        );
        for (start, solves) in STARTS.iter().zip(&self.solves[0]) {
            let instructions = solves.iter().map(|solve| solve.count.instructions).sum();
            let unsolved = solves.len() - solved(solves).count();
            for (what, figure) in [
                ("cycles, median", cycles(solves).median as u64),
                ("instructions, all solves", instructions),
                ("without a solution", unsolved as u64),
            ] {
                figures.insert(format!("{name}: {start}, {what}"), figure);
            }
        }
        for (what, bytes) in BYTES.iter().zip(self.bytes) {
            figures.insert(format!("{name}: {what}"), bytes);
        }
        figures
    }
}

/// Cycles of the solves with a solution.
pub fn cycles(solves: &[Solve]) -> Spread {
    Spread::of(solved(solves).map(|(solve, _)| solve.count.cycles as f64))
}

/// The solves with a solution.
pub fn solved(solves: &[Solve]) -> impl Iterator<Item = (&Solve, &Answer)> {
    solves
        .iter()
        .filter_map(|solve| Some((solve, solve.answer.as_ref()?)))
}
