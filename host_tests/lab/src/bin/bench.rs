//! `cargo bench-f405`, `cargo bench-h743`, `cargo bench-emulated`: every scene of `cargo reports` on a board. The board prints its
//! cycles beside the modelled ones, and hashes of its answers beside those of this machine.

use anyhow::{Context, Result, ensure};
use clap::{Parser, ValueEnum};
use cli::cross::{self, Build};
use cli::emulator::{self, Firmware, Log};
use lab::images::{BENCH_H743, IMAGES};
use lab::report::{self, Figures};
use lab::solves::{self, CASES, KINDS, Solves, Work};
use lab::workload;
use lab::{Axial, Clamped, Elastic, Ring, Sprung};
use spindle_bearing::{
    Centrifugal, InnerRaceControl, OuterRaceControl, RacewayControlFree, Static,
};
use std::fs;
use std::path::Path;
use std::process::{Command, ExitStatus};

/// Times every scene on a board by the core's counter, and compares its answers with this machine's, bit for bit
#[derive(Debug, Parser)]
#[command(
    name = "bench",
    after_help = "Exit status: 0 if every hash is the host's, otherwise 1"
)]
struct Arguments {
    /// The board
    board: Board,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Board {
    /// An STM32F405, by probe-rs
    F405,
    /// An STM32H743, by probe-rs
    H743,
    /// An emulated STM32F405, which has no counter
    Emulated,
}

/// End of the names of modelled medians.
const MEDIAN: &str = ", cycles, median";

/// A solver of a scene in a precision.
struct Scene {
    /// As the report has it: `f32, full`.
    name: String,
    /// Precision, scene and freedoms in Rust.
    types: String,
    run: fn(&[Work; CASES], &mut dyn FnMut() -> u32) -> [Solves; 3],
}

macro_rules! scenes {
    ($($number:literal $name:literal $freedoms:literal: $scene:ty; $without:literal, $parts:tt;)*) => {
        /// All scenes in single precision.
        fn scenes() -> Vec<Scene> {
            vec![$(scene!(f32, $name, $scene, $freedoms)),*]
        }
    };
}

macro_rules! scene {
    ($precision:ty, $name:literal, $scene:ty, $freedoms:literal) => {
        Scene {
            name: format!("{}, {}", stringify!($precision), $name),
            types: stringify!($precision, $scene, $freedoms).to_owned(),
            run: solves::run::<$precision, $scene, $freedoms>,
        }
    };
}
lab::for_every_scene!(scenes);

impl Board {
    /// Its core, as the report names it.
    const fn core(self) -> &'static str {
        match self {
            Self::F405 | Self::Emulated => "Cortex-M4F",
            Self::H743 => "Cortex-M7",
        }
    }

    /// The scenes that it runs: in double precision one, where the core has it.
    fn scenes(self) -> Vec<Scene> {
        let mut scenes = scenes();
        if self == Self::H743 {
            scenes.push(scene!(f64, "full", Ring<RacewayControlFree>, 5));
        }
        scenes
    }

    /// Names of the figures of each kind of solve.
    fn figures(self, scene: &Scene) -> [String; 3] {
        KINDS.map(|kind| format!("{}, {}: {kind}{MEDIAN}", self.core(), scene.name))
    }

    /// The cases, and the scenes with the numbers that the board compares, in Rust.
    fn table(self, figures: &Figures) -> String {
        let works = workload::all();
        let rows = self.scenes().into_iter().map(|scene| {
            let hashes = (scene.run)(&works, &mut || 0).map(|solves| solves.hash);
            let modelled = self.figures(&scene).map(|name| figures.get(&name).copied());
            let expected: Vec<_> = hashes.into_iter().zip(modelled).collect();
            let Scene { name, types, .. } = scene;
            format!(
                "Row {{ name: {name:?}, run: solves::run::<{types}>, expected: {expected:?} }},\n"
            )
        });
        let rows: String = rows.collect();
        format!(
            "pub static WORKS: [Work; CASES] = {{ use FreeContact::*; {works:?} }};\n\
             pub static ROWS: &[Row] = &[\n{rows}];\n"
        )
    }
}

fn main() -> Result<()> {
    let Arguments { board } = Arguments::parse();
    let root = cli::root();
    cross::add_target(root)?;
    let table = root.join("target/bench_table.rs");
    fs::write(&table, board.table(&report::figures(root)?))
        .with_context(|| format!("cannot write {}", table.display()))?;
    let (package, program, features) = match board {
        Board::F405 => (IMAGES, "bench_f405", "f405,spindle_firmware/rtt"),
        Board::H743 => (BENCH_H743, "bench_h743", "spindle_firmware/rtt"),
        Board::Emulated => (IMAGES, "bench_f405", "f405"),
    };
    let table = table.display().to_string();
    let image = Build {
        package,
        program,
        features,
        environment: &[("BENCH_TABLE", Some(&table))],
        ..Build::default()
    }
    .run(root)?;
    let status = match board {
        Board::F405 => probe("STM32F405RGTx", &image),
        Board::H743 => probe("STM32H743ZITx", &image),
        Board::Emulated => emulate(&Firmware::read(image)?),
    }?;
    ensure!(
        status.success(),
        "an answer is not this machine's, or the board did not come to the end"
    );
    Ok(())
}

fn probe(chip: &str, image: &Path) -> Result<ExitStatus> {
    let mut command = Command::new("probe-rs");
    let status = command.args(["run", "--chip", chip]).arg(image).status();
    status.context("probe-rs does not run: `cargo install probe-rs-tools --locked` brings it")
}

fn emulate(image: &Firmware) -> Result<ExitStatus> {
    emulator::find()?;
    let messages = image.messages()?;
    emulator::Board::start(image)?.print_log(Log::new(&messages))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_modelled_median_is_beside_a_measured_one() {
        let figures = report::figures(cli::root()).unwrap();
        let modelled = figures.keys().filter(|key| key.ends_with(MEDIAN));
        let boards = [Board::F405, Board::H743];
        let measured = boards.iter().flat_map(|board| {
            let scenes = board.scenes().into_iter();
            scenes.flat_map(|scene| board.figures(&scene))
        });
        let measured: BTreeSet<String> = measured.collect();
        let missing: Vec<_> = modelled
            .clone()
            .filter(|key| !measured.contains(*key))
            .collect();
        assert_eq!(missing, [""; 0]);
        assert!(modelled.count() > 48);
    }

    #[test]
    fn cycles_are_without_the_looks_at_the_counter_and_a_hash_tells_one_load() {
        let scene = &scenes()[0];
        let works = workload::all();
        // From look to look it counts two more: two beyond the look before.
        let mut looks = 0;
        let counted = (scene.run)(&works, &mut || {
            looks += 1;
            looks * looks
        });
        let still = (scene.run)(&works, &mut || 0);
        let mut other = works;
        for (load, _) in &mut other[CASES - 1].states {
            load[0] *= 1.0 + 1e-6;
        }
        let other = (scene.run)(&other, &mut || 0);
        for ((mut counted, mut still), other) in counted.into_iter().zip(still).zip(other) {
            assert_eq!(counted.cycles(), Some([2, 2]));
            assert_eq!(still.cycles(), None);
            assert_eq!(counted.hash, still.hash);
            assert_ne!(other.hash, still.hash);
        }
    }
}
