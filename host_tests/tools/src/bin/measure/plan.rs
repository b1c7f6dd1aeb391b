//! Which solvers are measured on what.

use crate::host::{self, Limit, Sample, Task, Truth};
use crate::image::{Image, Motion, Variant, name};
use crate::rows::{At, Rows, Start};
use crate::target;
use crate::workload::Work;
use anyhow::{Context, Result};
use host_tests::dispatch::{Attitude, Precision};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use std::path::Path;
use tools::timing::Core;

/// Tolerances, for error over cycles; those below a precision's default are left out.
pub const TOLERANCES: [f64; 7] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12];
/// Ball counts.
pub const BALLS: [usize; 3] = [7, 16, 30];
/// The solver that all others are compared with.
pub const USUAL: Motion = Motion::AtSpeed(Attitude::Raceless);
/// Cores and precisions, in the order of tables.
pub const CORES: [(Core, Precision); 4] = [
    (Core::M4f, Precision::F32),
    (Core::M4f, Precision::F64),
    (Core::M7, Precision::F32),
    (Core::M7, Precision::F64),
];
/// The other scenes and rules, measured on one core each in its own precision.
pub const OTHERS: [Motion; 3] = [
    Motion::AtSpeed(Attitude::Outer),
    Motion::AtSpeed(Attitude::Inner),
    Motion::Static,
];

/// Whether a solver is measured: all cores and ball counts as usual, the other scenes where the
/// precision is the core's own.
fn is_measured(variant: &Variant) -> bool {
    variant.motion == USUAL
        || variant.balls == 16
            && matches!(
                (variant.core, variant.precision),
                (Core::M4f, Precision::F32) | (Core::M7, Precision::F64)
            )
}

/// A bearing and a scene: what has the same cases and equilibria.
struct Ground {
    motion: Motion,
    balls: usize,
    works: Vec<Work>,
    truths: Vec<Truth>,
    asked: Vec<Asked>,
}

/// The tasks of a precision, and the host's answers by task and case.
struct Asked {
    precision: Precision,
    tasks: Vec<Task>,
    samples: Vec<Vec<Option<Sample>>>,
}

/// What is asked of a solver.
fn tasks(motion: Motion, balls: usize, precision: Precision) -> Vec<Task> {
    let mut tasks = vec![(Start::Cold, Limit::Default), (Start::Warm, Limit::Default)];
    if motion == USUAL && balls == 16 {
        for start in Start::ALL {
            let least = Limit::Default.settings(precision).0;
            let tolerances = TOLERANCES.iter().filter(|t| **t > least);
            tasks.extend(tolerances.map(|t| (start, Limit::Tolerance(*t))));
        }
    }
    tasks
}

impl Ground {
    fn new(motion: Motion, balls: usize, cases: usize) -> Result<Self> {
        let works: Vec<Work> = (0..cases as u64)
            .map(|seed| Work::mixed(seed, balls, motion != Motion::Static))
            .collect();
        let truths = host::truths(&works, motion, balls)?;
        let asked = [Precision::F32, Precision::F64]
            .into_iter()
            .map(|precision| {
                let tasks = tasks(motion, balls, precision);
                let samples = host::samples(&works, &truths, precision, motion, balls, &tasks)?;
                Ok(Asked {
                    precision,
                    tasks,
                    samples,
                })
            })
            .collect::<Result<_>>()?;
        Ok(Self {
            motion,
            balls,
            works,
            truths,
            asked,
        })
    }

    /// Errors and iterations, which are the same on every core.
    fn rows(&self) -> Rows {
        let mut rows = Rows::default();
        for asked in &self.asked {
            for ((start, limit), samples) in asked.tasks.iter().zip(&asked.samples) {
                let at = At {
                    core: None,
                    precision: asked.precision,
                    motion: self.motion,
                    balls: self.balls,
                    start: Some(*start),
                };
                let found = || samples.iter().flatten();
                for (i, what) in ["displacement", "force", "stiffness"].iter().enumerate() {
                    let errors: Vec<f64> = found().filter_map(|s| Some(s.errors?[i])).collect();
                    rows.spread(&at, &limit.metric(&format!("{what} error")), &errors, "1");
                }
                let iterations: Vec<f64> = found().map(|s| s.iterations.into()).collect();
                rows.spread(&at, &limit.metric("iterations"), &iterations, "1");
                if *limit == Limit::Default {
                    let mut count = |metric: &str, count: usize| {
                        rows.add(&at, metric, "value", count as f64, "1");
                    };
                    count("cases", samples.len());
                    count("answers solved", found().count());
                    count(
                        "answers compared",
                        found().filter(|s| s.errors.is_some()).count(),
                    );
                    count(
                        "answers of another equilibrium",
                        found().filter(|s| s.other).count(),
                    );
                }
            }
        }
        rows
    }
}

/// A bar that says what is going on.
pub fn bar(length: u64) -> Result<ProgressBar> {
    Ok(
        ProgressBar::new(length).with_style(ProgressStyle::with_template(
            "{bar:40} {pos} of {len}, {msg}, {eta} left",
        )?),
    )
}

/// Measures everything on the modelled cores.
pub fn run(root: &Path, cases: usize) -> Result<(Rows, Vec<Work>, Vec<Truth>)> {
    let mut grounds = vec![(USUAL, 16), (USUAL, 7), (USUAL, 30)];
    grounds.extend(OTHERS.map(|motion| (motion, 16)));

    let progress = bar(grounds.len() as u64)?;
    progress.set_message("equilibria of the reference build");
    let mut all = Vec::new();
    let mut rows = Rows::default();
    for (motion, balls) in grounds {
        let ground = Ground::new(motion, balls, cases)?;
        rows.append(ground.rows());
        all.push(ground);
        progress.inc(1);
    }
    progress.finish_and_clear();

    let variants: Vec<Variant> = all
        .iter()
        .flat_map(|ground| {
            CORES.map(|(core, precision)| Variant {
                core,
                precision,
                balls: ground.balls,
                motion: ground.motion,
            })
        })
        .filter(is_measured)
        .collect();
    let progress = bar(variants.len() as u64)?;
    let mut images = Vec::new();
    for variant in &variants {
        progress.set_message(format!(
            "building for {}, {}",
            variant.core.name(),
            name(variant.precision)
        ));
        images.push((*variant, Image::build(root, variant)?));
        progress.inc(1);
    }
    progress.finish_and_clear();

    // Doubles in software take longest: first, so that nothing waits for them at the end.
    images.sort_by_key(|(v, _)| {
        (
            v.core != Core::M4f || v.precision != Precision::F64,
            v.balls != 16,
        )
    });
    let progress = bar((images.len() * cases) as u64)?;
    progress.set_message("bearings on emulated cores");
    let measured: Vec<Rows> = images
        .into_par_iter()
        .with_max_len(1)
        .map(|(variant, image)| {
            let ground = all
                .iter()
                .find(|g| g.motion == variant.motion && g.balls == variant.balls)
                .context("a solver without cases")?;
            let asked = ground
                .asked
                .iter()
                .find(|asked| asked.precision == variant.precision)
                .context("a precision without answers")?;
            target::measure(
                image,
                variant,
                &ground.works,
                &asked.tasks,
                &asked.samples,
                &progress,
            )
        })
        .collect::<Result<_>>()?;
    progress.finish_and_clear();
    for of in measured {
        rows.append(of);
    }
    let usual = all.swap_remove(0);
    Ok((rows, usual.works, usual.truths))
}
