//! Command line of `cargo reports`, which the program that starts the measurement and the one that
//! does it share.

use crate::arguments::precision;
use crate::timing::Core;
use anyhow::{Context, Result};
use clap::{Args, Parser, Subcommand};
use host_tests::dispatch::Precision;
use probes::for_every_scene;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Measures the solver's cycles, memory and errors, and writes docs/report.md with its figures
#[derive(Debug, Parser)]
#[command(name = "cargo reports")]
pub struct Arguments {
    /// Mixed cases for every point
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    pub cases: u32,
    /// Writes every figure to this file, too, as a list of rows
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Instead, fails if a few fixed solves take 2 % more instructions or flash than the committed
    /// figures say
    #[arg(long, conflicts_with_all = ["json", "accept"])]
    pub check: bool,
    /// Instead, takes the figures of these solves as they are now
    #[arg(long, conflicts_with = "json")]
    pub accept: bool,
    /// Something else than the page
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// What else there is.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Prints where the cycles of one solver go, part by part and function by function
    Profile(Choice),
    /// Measures the monitor's ticks alone, and writes what rests on that: the section of docs/report.md, its
    /// figures, and the constants of the deadline
    Monitor,
    /// Known results reproduced: writes docs/validation.md and its pictures
    Validation {
        /// Instead, fails if a number or a word of the committed page is not as made now
        #[arg(long)]
        check: bool,
    },
}

/// A solver.
#[derive(Debug, Clone, Args)]
pub struct Choice {
    /// The core
    #[arg(long, value_enum, default_value = "m4f")]
    pub core: Core,
    /// The precision
    #[arg(long, value_parser = precision(), default_value = "f32")]
    pub precision: Precision,
    /// The ball count, 3 to 99
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u8).range(3..=99))]
    pub balls: u8,
    /// The scene
    #[arg(long, value_parser = SCENES, default_value = FULL)]
    pub scene: String,
    /// Mixed cases to solve, cold and then warm
    #[arg(long, default_value_t = 200)]
    pub cases: u32,
}

impl Default for Choice {
    fn default() -> Self {
        Self {
            core: Core::M4f,
            precision: Precision::F32,
            balls: 16,
            scene: FULL.to_owned(),
            cases: 200,
        }
    }
}

macro_rules! names {
    ($($number:literal $name:literal: $scene:ty;
        $attitude:expr, $without:literal, $double:literal, $parts:tt;)*) => {
        /// Names of the scenes that are measured.
        pub const SCENES: [&str; [$($number),*].len()] = [$($name),*];
    };
}
for_every_scene!(names);

/// The scene that all others are compared with: all inertia loads, no race in control, five freedoms.
pub const FULL: &str = "full";

/// Where the figures are that must not get worse unnoticed, from the project's root.
pub const FIGURES: &str = "docs/report_figures.json";

/// Figures by name.
pub type Figures = BTreeMap<String, u64>;

/// The committed figures.
///
/// # Errors
///
/// They are not there, or something else is.
pub fn figures(root: &Path) -> Result<Figures> {
    let path = root.join(FIGURES);
    let text = std::fs::read_to_string(&path).with_context(|| {
        format!(
            "cannot read {}; `cargo reports --accept` writes it",
            path.display()
        )
    })?;
    serde_json::from_str(&text).with_context(|| format!("{FIGURES} is not a list of figures"))
}
