//! docs/report.md with its picture, and README's table.

use crate::scenes::{self, BYTES, Measured, TICK};
use crate::sweep;
use crate::table::{markdown, thousands};
use crate::ticks;
use anyhow::{Context, Result};
use cli::chart;
use lab::report::Figures;
use lab::solves::{BALLS, CASES, STARTS};
use lab::workload;
use std::fs;
use std::path::Path;

/// Measures everything; writes the page and its picture. Returns the figures of the gate.
pub fn write(root: &Path) -> Result<Figures> {
    let works = workload::all();
    let truths = sweep::truths(&works)?;
    let measured = scenes::run(root, sweep::programs(), &works)?;
    let ticks = ticks::measure(root)?;
    let all: Figures = measured.iter().flat_map(Measured::figures).collect();
    let text = format!(
        "<!-- Made by `cargo reports` from commit {}; the seeds of the cases are 0 to {}. -->\n\n\
         # Error against run time\n\n\
         Cycles are **modelled, +-15 %, no wait states**. Instructions are counted exactly on an emulated core. Each has \
         the cycles of `host_tests/lab/src/bin/measure/timing.rs`, which names its sources. Nothing was calibrated on \
         silicon. Arm does not publish the timings of the Cortex-M7, so that its model is the coarser one.\n\n\
         The cases are {CASES} random bearings under random loads and speeds. A warm solve follows a solve with every \
         load 1 % and the speed 0.5 % larger or smaller. The call around a solve is not counted. An error is that of the \
         stiffness, over its diagonal, against the reference build. Every answer of an emulated core equals that of the \
         host to the last bit.\n\n\
         ![Error of the stiffness over cycles](report.svg)\n\n\
         {BALLS} balls, five freedoms, raceway control free. Cycles are medians. Errors are medians, and 99 % of the \
         cases. The first line of a core is for the default tolerance, the second for that of a tick \
         (`Settings::TICK`).\n\n{}\n\
         Take `f32` on a Cortex-M4F, which works out doubles in software. A Cortex-M7 has both: `f64` for solutions that \
         are differentiated or summed up, `f32` where cycles count.\n\n\
         ## Scenes\n\n\
         A firmware with one scene alone has nothing of the parts that the scene leaves out. There are {BALLS} balls a \
         row. A scene drops the loads for which it has no freedom. Cycles are medians: of a warm solve to the tolerance of \
         a tick, then of solves to the default tolerance. Flash is the code and the constants that a solve reaches, without \
         the bearing's constants. State is the solver with its balls. The last column counts loads without a solution, of \
         {CASES}.\n\n{}\n{}",
        cli::commit(),
        CASES - 1,
        sweep::tolerances(&measured, &truths),
        scene_table(&measured, &all)?,
        ticks::section(&ticks),
    );
    let docs = root.join("docs");
    let text = text.replace("\n\n\n", "\n\n");
    fs::write(docs.join("report.md"), text.trim_end().to_owned() + "\n").context("report.md")?;
    let picture = chart::svg(&sweep::chart(&measured, &truths))?;
    fs::write(docs.join("report.svg"), picture).context("report.svg")?;
    println!("docs/report.md and docs/report.svg are written");
    // The gate's programs are the first ones.
    let gate = measured.iter().take(scenes::programs().len());
    let mut figures: Figures = gate.flat_map(Measured::figures).collect();
    figures.extend(ticks::figures(&ticks));
    Ok(figures)
}

/// A figure of a program.
fn figure(figures: &Figures, program: &str, what: &str) -> Result<u64> {
    let name = format!("{program}: {what}");
    let figure = figures.get(&name).copied();
    figure.with_context(|| format!("`{name}` is not measured"))
}

fn scene_table(measured: &[Measured], figures: &Figures) -> Result<String> {
    let [warm, cold] = [STARTS[1], STARTS[0]].map(|start| format!("{start}, cycles, median"));
    let columns: Vec<&str> = BYTES
        .into_iter()
        .chain([TICK, &warm, &cold, "cold, without a solution"])
        .collect();
    let line = |measured: &Measured| {
        let program = measured.program.name();
        let numbers = columns.iter().map(|what| {
            let figure = figure(figures, &program, what)?;
            Ok(thousands(figure))
        });
        let mut line = vec![program.clone(), measured.program.scene.without.to_owned()];
        line.extend(numbers.collect::<Result<Vec<_>>>()?);
        Ok(line)
    };
    let lines = measured.iter().map(line).collect::<Result<Vec<_>>>()?;
    Ok(markdown(
        "core, precision, scene | without | flash / B | state / B | stack / B | a tick | warm | cold | unsolved",
        &lines,
    ))
}

/// README as it is, and with the table of these figures.
pub fn readme(root: &Path, figures: &Figures) -> Result<[String; 2]> {
    const MARKS: [&str; 2] = ["<!-- report: begin -->\n\n", "\n<!-- report: end -->"];
    let text = fs::read_to_string(root.join("README.md")).context("README.md")?;
    let (before, rest) = text
        .split_once(MARKS[0])
        .context("README has no place for the table")?;
    let (_, after) = rest
        .split_once(MARKS[1])
        .context("README's table has no end")?;
    let table = readme_table(figures)?;
    let made = [before, MARKS[0], table.trim_end(), "\n", MARKS[1], after].concat();
    Ok([text, made])
}

fn readme_table(figures: &Figures) -> Result<String> {
    const WARM: &str = "warm, cycles, median";
    let rows = [
        ("one bearing, `Settings::TICK`", "full", TICK),
        ("one bearing, by default", "full", WARM),
        ("a pair, `Settings::TICK`", "pair", TICK),
        ("a pair, by default", "pair", WARM),
        ("four rows, `Settings::TICK`", "four-rows", TICK),
        ("four rows, by default", "four-rows", WARM),
        (
            "a pair on an elastic shaft and supports, `Settings::TICK`",
            "elastic-pair",
            TICK,
        ),
        (
            "that pair with its compliance at the nose, `Settings::TICK`",
            "elastic-pair-nose",
            TICK,
        ),
        (
            "four rows on a shaft and supports, `Settings::TICK`",
            "elastic-four-rows",
            TICK,
        ),
        ("a tick of the monitor of a pair", "monitor", ticks::MEDIAN),
    ];
    let row = |(what, scene, median): (&str, &str, &str)| {
        let program = format!("Cortex-M4F, f32, {scene}");
        let cycles = figure(figures, &program, median)?;
        let time = format!("{:.3} ms", cycles as f64 / 168e3);
        let mut line = vec![what.to_owned(), thousands(cycles), time];
        for what in BYTES {
            line.push(if median == ticks::MEDIAN {
                String::new()
            } else {
                thousands(figure(figures, &program, what)?)
            });
        }
        Ok(line)
    };
    let lines = rows.into_iter().map(row).collect::<Result<Vec<_>>>()?;
    Ok(markdown(
        "warm | cycles | at 168 MHz | flash / B | state / B | stack / B",
        &lines,
    ))
}
