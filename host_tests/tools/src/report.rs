//! Command line of `cargo reports`, which the program that starts the measurement shares with the one that measures.

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};
use std::collections::BTreeMap;
use std::path::Path;

/// Measures the solver's cycles, memory and errors; writes docs/report.md, its picture and README's table
#[derive(Debug, Parser)]
#[command(name = "cargo reports")]
pub struct Arguments {
    /// Instead, fails if a figure is 2 % worse than the committed one, or README's table is 2 % off
    #[arg(long, conflicts_with = "accept")]
    pub check: bool,
    /// Instead, takes the figures and README's table as they are now
    #[arg(long)]
    pub accept: bool,
    /// Something else than the page
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// Something else than the page.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Measures the monitor's ticks alone; writes their figures, and the constants of the deadline
    Monitor,
    /// Known results reproduced: writes docs/validation.md and its pictures
    Validation {
        /// Instead, fails if a number or a word of the committed page is not as made now
        #[arg(long)]
        check: bool,
    },
}

/// Place of the figures that must not get worse unnoticed, from the project's root.
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
