//! Figures that must not get worse unnoticed: instructions and flash of a few fixed solves.

use crate::bench::Bench;
use crate::host::Limit;
use crate::image::{Image, Motion, name};
use crate::memory::Memory;
use crate::milling::{self, Ticks};
use crate::plan::{OTHERS, USUAL, bar};
use crate::scenes;
use crate::ticks;
use crate::workload::{self, EVERYDAY_BALLS, State, Work};
use anyhow::{Context, Result, bail};
use host_tests::dispatch::Precision;
use std::path::Path;
use tools::report::{self, FIGURES, Figures};
use tools::timing::Core;

/// Growth that is let pass.
const LEEWAY: f64 = 0.02;
/// Mixed cases whose instructions are summed up, besides the everyday one.
const CASES: u64 = 12;

/// Ticks of the milling cycle whose instructions are summed up, and the second of it where they begin.
const MILLING: (usize, usize) = (3, 200);

/// Scenes besides those that are measured anyway.
const SCENES: [&str; 5] = [
    "axial-static",
    "axial-full",
    "translations-full",
    "pair",
    "sprung-pair",
];

fn measure(root: &Path) -> Result<Figures> {
    let mut programs = vec![
        (Core::M4f, Precision::F32, USUAL.name()),
        (Core::M7, Precision::F64, USUAL.name()),
    ];
    let others = OTHERS.map(Motion::name);
    programs.extend(others.map(|motion| (Core::M4f, Precision::F32, motion)));
    programs.extend(SCENES.map(|scene| (Core::M4f, Precision::F32, scene)));
    let progress = bar(programs.len() as u64)?;
    progress.set_message("fixed solves");
    let mut figures = Figures::new();
    for (core, precision, scene) in programs {
        let of = format!("{}, {}, {scene}", core.name(), name(precision));
        let image = Image::of_scene(root, core, precision, EVERYDAY_BALLS, scene)?;
        let mut bench = Bench::new(image, core, precision)?;
        let mut mixed = [0; 2];
        let turns = scene != Motion::Static.name();
        let works = (0..CASES).map(|seed| Work::mixed(seed, EVERYDAY_BALLS, turns));
        for (number, work) in [Work::everyday()].into_iter().chain(works).enumerate() {
            bench.bearing(&work.design)?;
            let states: [State; 2] = scenes::scene(scene)
                .and_then(|scene| scene.states(&work, None))
                .context("a scene that is not there, or needs a preload")?;
            for (i, state) in states.into_iter().enumerate() {
                let question = workload::question(state, precision, Limit::Default);
                let instructions = bench.solve(&question)?.instructions;
                if number == 0 {
                    let start = ["cold", "warm"][i];
                    figures.insert(
                        format!("{of}: instructions, everyday, {start}"),
                        instructions,
                    );
                } else {
                    mixed[i] += instructions;
                }
            }
        }
        for (start, sum) in ["cold", "warm"].into_iter().zip(mixed) {
            figures.insert(format!("{of}: instructions, {CASES} mixed, {start}"), sum);
        }
        if (core, precision, scene) == (milling::CORE, milling::PRECISION, USUAL.name()) {
            let (from, count) = MILLING;
            let states = workload::milling(from, count)?;
            let ticks = Ticks::measure(&mut bench, None, &states, Limit::Default)?;
            figures.insert(
                format!("{of}: instructions, milling cycle, warm ticks of {count}"),
                ticks.instructions,
            );
        }
        let memory = Memory::of(&bench)?;
        figures.insert(format!("{of}: flash"), memory.flash());
        figures.insert(format!("{of}: state"), memory.state.into());
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(figures)
}

/// Takes the figures as they are now.
pub fn accept(root: &Path) -> Result<()> {
    let mut figures = measure(root)?;
    figures.extend(ticks::accept(root)?);
    write(root, &figures)?;
    println!("{FIGURES}: {} figures; commit it", figures.len());
    Ok(())
}

/// Takes these figures in the place of those of the same names.
pub fn replace(root: &Path, some: Figures) -> Result<()> {
    let mut figures = report::figures(root)?;
    figures.extend(some);
    write(root, &figures)
}

fn write(root: &Path, figures: &Figures) -> Result<()> {
    let path = root.join(FIGURES);
    let text = serde_json::to_string_pretty(&figures)? + "\n";
    std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// Fails if a figure has grown by more than the leeway.
pub fn check(root: &Path) -> Result<()> {
    let accepted = report::figures(root)?;
    let mut figures = measure(root)?;
    figures.extend(ticks::check(root, LEEWAY)?);
    let mut grown = Vec::new();
    let mut shrunk = false;
    for (what, now) in &figures {
        let Some(before) = accepted.get(what) else {
            grown.push(format!("{what}: {now}, and no figure to hold it to"));
            continue;
        };
        let change = *now as f64 / *before as f64 - 1.0;
        println!("{what}: {now} ({:+.2} %)", 100.0 * change);
        shrunk |= change < -LEEWAY;
        if change > LEEWAY {
            grown.push(format!(
                "{what}: {now}, was {before} ({:+.1} %)",
                100.0 * change
            ));
        }
    }
    if let Some(gone) = accepted.keys().find(|what| !figures.contains_key(*what)) {
        grown.push(format!("{gone}: not measured any more"));
    }
    if !grown.is_empty() {
        bail!(
            "more than {:.0} % worse than {FIGURES}:\n       {}\n       `cargo reports profile` shows where it \
             goes. If it is worth it, take the new figures with `cargo reports --accept` and commit them",
            100.0 * LEEWAY,
            grown.join("\n       ")
        );
    }
    if shrunk {
        println!("better than {FIGURES}: `cargo reports --accept` holds on to it");
    }
    Ok(())
}
