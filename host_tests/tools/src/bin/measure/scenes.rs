//! One solver for each scene: what leaving something out saves.
//!
//! Every scene solves the same cases, restricted to its freedoms: the loads that it has no freedom for
//! are dropped, at rest the speed, too. Under rigid preload the axial displacement is the one that the
//! full scene finds for the cold case.

use crate::bench::{self, Bench};
use crate::host::{Host, Limit};
use crate::image::{Image, name};
use crate::memory::Memory;
use crate::plan::bar;
use crate::rows::{Row, Rows, Start};
use crate::workload::{EVERYDAY_BALLS, State, Work, question};
use anyhow::{Context, Result, bail};
use host_tests::campaign::report::Spread;
use host_tests::dispatch::{Attitude, Precision};
use probes::{
    Axial, Balls, Clamped, Displacement, Loads, Numbers, Passed, Question, RigidPreload, Ring,
    Shaft, Sprung, for_every_scene,
};
use rayon::prelude::*;
use spindle_bearing::{Centrifugal, Full, Static};
use spindle_bearing::{InnerRaceControl, OuterRaceControl};
use std::path::Path;
use tools::timing::Core;

/// The core that scenes are compared on.
pub const CORE: Core = Core::M4f;
/// Cases in doubles, which that core works out in software.
pub const DOUBLE_CASES: usize = 50;
/// Ball counts that cycles over rows are measured for, besides the everyday one.
pub const OTHER_BALLS: [usize; 2] = [8, 24];
/// Scenes for cycles over rows.
pub const ROWS: [(&str, usize); 3] = [(tools::report::FULL, 1), ("pair", 2), ("four-rows", 4)];
/// Cases whose stack is looked at.
const STACKS: usize = 20;

/// The host's answers to a cold solve and to a warm one after it, as far as there are any.
type Answers = [Option<Answer>; 2];

/// An answer of the host.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Answer {
    displacement: [f64; 5],
    stiffness: [[f64; 5]; 5],
    iterations: u32,
}

/// How the host solves two states of a case, one after the other.
type Solves = fn(&Work, [State; 2]) -> Result<Answers>;

/// A scene of the table in `host_tests/probes`.
#[derive(Debug, Clone, Copy)]
pub struct Scene {
    /// What the image's build calls it.
    pub name: &'static str,
    /// What it leaves out of the full one, or has in its place.
    pub without: &'static str,
    /// The rule of attitude; none at rest.
    pub attitude: Option<Attitude>,
    /// Measured in doubles, too.
    pub double: bool,
    freedoms: usize,
    preloaded: bool,
    single: Solves,
    /// The same with the ball counts of [`OTHER_BALLS`].
    other_balls: [Solves; 2],
    /// The same in doubles.
    doubles: Solves,
}

macro_rules! scenes {
    ($($number:literal $name:literal: $scene:ty;
        $attitude:expr, $without:literal, $double:literal, $parts:tt;)*) => {
        /// All, the full one last.
        pub const SCENES: &[Scene] = &[$(Scene {
            name: $name,
            without: $without,
            attitude: $attitude,
            double: $double,
            freedoms: <$scene as probes::Scene<f32, EVERYDAY_BALLS>>::FREEDOMS,
            preloaded: <$scene as probes::Scene<f32, EVERYDAY_BALLS>>::PRELOADED,
            single: answers::<f32, $scene, EVERYDAY_BALLS>,
            other_balls: [
                answers::<f32, $scene, { OTHER_BALLS[0] }>,
                answers::<f32, $scene, { OTHER_BALLS[1] }>,
            ],
            doubles: answers::<f64, $scene, EVERYDAY_BALLS>,
        }),*];
    };
}

const FREE: Option<Attitude> = Some(Attitude::Raceless);

for_every_scene!(scenes);

/// Solves one state after the other.
fn answers<T: Host, S: probes::Scene<T, N>, const N: usize>(
    work: &Work,
    states: [State; 2],
) -> Result<Answers> {
    let (tolerance, max_iterations) = (T::TOLERANCE, 100);
    let bearing = T::built::<N>(&work.design)?;
    let mut solver = S::solver(&bearing, &work.design).context("no such solver")?;
    let wide = |x: &[T]| x.iter().map(|x| x.to_f64()).collect::<Vec<_>>();
    Ok(states.map(|(load, omega)| {
        let question = Question {
            values: S::vector(load.map(T::of)),
            omega: T::of(omega),
            tolerance,
            max_iterations,
        };
        let answer = S::solve(&mut solver, &question).ok()?;
        Some(Answer {
            displacement: bench::padded(&wide(answer.displacement.numbers())),
            stiffness: bench::square(&wide(answer.stiffness.numbers())),
            iterations: answer.iterations,
        })
    }))
}

/// The axial displacement that the full scene finds in doubles for the cold case, a number of single precision as loads
/// are.
fn full_displacement(work: &Work) -> Result<Option<f64>> {
    let [cold, _] = answers::<f64, Ring<Full, 5>, EVERYDAY_BALLS>(work, [work.cold, work.warm])?;
    Ok(cold.map(|answer| f64::from(answer.displacement[0] as f32)))
}

impl Scene {
    /// The axial displacement of a case, if the scene is given one.
    pub fn preload(&self, work: &Work) -> Result<Option<f64>> {
        if self.preloaded {
            full_displacement(work)
        } else {
            Ok(None)
        }
    }

    /// The states of a case that it solves; none without the preload that it needs.
    pub fn states(&self, work: &Work, preload: Option<f64>) -> Option<[State; 2]> {
        let first = if self.preloaded { Some(preload?) } else { None };
        Some([work.cold, work.warm].map(|(mut load, omega)| {
            load[self.freedoms..].fill(0.0);
            load[0] = first.unwrap_or(load[0]);
            (load, if self.attitude.is_some() { omega } else { 0.0 })
        }))
    }

    /// A figure of it that is still without a name.
    fn row(&self, precision: Precision, balls: usize, start: Option<Start>) -> Row {
        Row {
            core: CORE.name(),
            precision: name(precision),
            scene: self.name,
            attitude: self
                .attitude
                .map(|a| crate::image::Motion::AtSpeed(a).name()),
            balls,
            start: start.map(Start::name),
            metric: String::new(),
            stat: "value",
            value: f64::NAN,
            unit: "1",
        }
    }

    /// A figure of it; NaN if there is none.
    pub fn figure(
        &self,
        rows: &Rows,
        precision: Precision,
        start: Option<Start>,
        metric: &str,
        stat: &str,
    ) -> f64 {
        self.figure_with(EVERYDAY_BALLS, rows, precision, start, metric, stat)
    }

    /// The same with another ball count.
    pub fn figure_with(
        &self,
        balls: usize,
        rows: &Rows,
        precision: Precision,
        start: Option<Start>,
        metric: &str,
        stat: &str,
    ) -> f64 {
        let wanted = self.row(precision, balls, start);
        rows.all()
            .iter()
            .find(|r| {
                (r.core, r.precision, r.scene, r.balls, r.start)
                    == (
                        wanted.core,
                        wanted.precision,
                        wanted.scene,
                        balls,
                        wanted.start,
                    )
                    && r.metric == metric
                    && r.stat == stat
            })
            .map_or(f64::NAN, |r| r.value)
    }
}

/// The scene of a name.
pub fn scene(name: &str) -> Option<&'static Scene> {
    SCENES.iter().find(|scene| scene.name == name)
}

/// Measures all of them.
pub fn run(root: &Path, works: &[Work]) -> Result<Rows> {
    let preloads = works
        .par_iter()
        .map(full_displacement)
        .collect::<Result<Vec<_>>>()?;
    let wanted: Vec<_> = SCENES
        .iter()
        .filter(|scene| scene.double)
        .map(|scene| (scene, Precision::F64, EVERYDAY_BALLS))
        .chain(ROWS.iter().flat_map(|(name, _)| {
            let scene = scene(name).into_iter();
            scene.flat_map(|scene| OTHER_BALLS.map(|balls| (scene, Precision::F32, balls)))
        }))
        .chain(
            SCENES
                .iter()
                .map(|scene| (scene, Precision::F32, EVERYDAY_BALLS)),
        )
        .collect();
    let progress = bar(wanted.len() as u64)?;
    let mut images = Vec::new();
    for (scene, precision, balls) in wanted {
        progress.set_message(format!("building {}, {}", scene.name, name(precision)));
        let image = Image::of_scene(root, CORE, precision, balls, scene.name)?;
        images.push((scene, precision, balls, image));
        progress.inc(1);
    }
    progress.finish_and_clear();
    let progress = bar(images.len() as u64)?;
    progress.set_message("scenes on an emulated core");
    let measured: Vec<Rows> = images
        .into_par_iter()
        .with_max_len(1)
        .map(|(scene, precision, balls, image)| {
            let cases = match precision {
                Precision::F32 => works.len(),
                Precision::F64 => works.len().min(DOUBLE_CASES),
            };
            let other = |case| Work::mixed(case, balls, scene.attitude.is_some());
            let others: Vec<Work> = (0..cases as u64).map(other).collect();
            let works = if balls == EVERYDAY_BALLS {
                &works[..cases]
            } else {
                &others
            };
            let rows = measure(scene, precision, balls, image, works, &preloads)
                .with_context(|| format!("the scene {}, {}", scene.name, name(precision)));
            progress.inc(1);
            rows
        })
        .collect::<Result<_>>()?;
    progress.finish_and_clear();
    let mut rows = Rows::default();
    for of in measured {
        rows.append(of);
    }
    Ok(rows)
}

/// One; fails if an answer of it is not the host's to the last bit.
fn measure(
    scene: &Scene,
    precision: Precision,
    balls: usize,
    image: Image,
    works: &[Work],
    preloads: &[Option<f64>],
) -> Result<Rows> {
    let host = match precision {
        Precision::F32 => match OTHER_BALLS.iter().position(|other| *other == balls) {
            Some(other) => scene.other_balls[other],
            None => scene.single,
        },
        Precision::F64 => scene.doubles,
    };
    let mut bench = Bench::new(image, CORE, precision)?;
    let mut cycles = [Vec::new(), Vec::new()];
    let mut instructions = [Vec::new(), Vec::new()];
    let mut iterations = [Vec::new(), Vec::new()];
    let mut stack = 0;
    for (case, (work, preload)) in works.iter().zip(preloads).enumerate() {
        let Some(states) = scene.states(work, *preload) else {
            continue;
        };
        bench.bearing(&work.design)?;
        let expected = host(work, states)?;
        for (i, (state, expected)) in states.into_iter().zip(expected).enumerate() {
            // A tick after what has no answer would be another cold solve.
            let Some(expected) = expected else {
                break;
            };
            let solve = bench.solve(&question(state, precision, Limit::Default))?;
            let answer = Answer {
                displacement: solve.answer.displacement,
                stiffness: solve.answer.stiffness,
                iterations: solve.answer.iterations,
            };
            if !same(&answer, &expected) {
                bail!(
                    "case {case}, {}: the core's answer is not the host's.\n{answer:?}\n{expected:?}",
                    Start::ALL[i].name()
                );
            }
            cycles[i].push(solve.cycles as f64);
            instructions[i].push(solve.instructions as f64);
            iterations[i].push(f64::from(answer.iterations));
        }
        if case < STACKS {
            bench.reset()?;
            for state in states {
                stack = stack.max(bench.stack(&question(state, precision, Limit::Default))?);
            }
        }
    }

    let mut rows = Rows::default();
    for (i, start) in Start::ALL.into_iter().enumerate() {
        for (metric, values, unit) in [
            ("cycles", &cycles[i], "cycles"),
            ("instructions", &instructions[i], "instructions"),
            ("iterations", &iterations[i], "1"),
        ] {
            if values.is_empty() {
                continue;
            }
            let spread = Spread::of(values.iter().copied());
            for (stat, value) in [
                ("median", spread.median),
                ("99 %", spread.most),
                ("worst", spread.worst),
            ] {
                rows.push(Row {
                    metric: metric.to_owned(),
                    stat,
                    value,
                    unit,
                    ..scene.row(precision, balls, Some(start))
                });
            }
        }
        rows.push(Row {
            metric: "answers solved".to_owned(),
            value: cycles[i].len() as f64,
            ..scene.row(precision, balls, Some(start))
        });
    }
    let memory = Memory::of(&bench)?;
    let mut bytes = |metric: String, value: f64| {
        rows.push(Row {
            metric,
            value,
            unit: "bytes",
            ..scene.row(precision, balls, None)
        });
    };
    bytes("flash".to_owned(), memory.flash() as f64);
    bytes("state".to_owned(), memory.state.into());
    bytes("worst stack".to_owned(), stack.into());
    for (size, symbol) in &memory.symbols {
        bytes(format!("flash of {symbol}"), *size as f64);
    }
    Ok(rows)
}

fn same(a: &Answer, b: &Answer) -> bool {
    let bits = |x: &[f64; 5]| x.map(f64::to_bits);
    bits(&a.displacement) == bits(&b.displacement)
        && a.stiffness.map(|row| bits(&row)) == b.stiffness.map(|row| bits(&row))
        && a.iterations == b.iterations
}
