//! `cargo reports`, `cargo check-firmware`: see `cargo reports --help`.

mod bench;
mod capstone;
mod decode;
mod gate;
mod image;
mod machine;
mod page;
mod parts;
mod program;
mod proof;
mod scenes;
mod sweep;
mod table;
mod ticks;
mod timing;
mod unicorn;
mod unwanted;
mod validation;
mod wheels;

use anyhow::Result;
use clap::{Parser, Subcommand};

/// Measures the solver's cycles, memory and errors; writes docs/report.md, its picture and README's table
#[derive(Debug, Parser)]
#[command(name = "cargo reports")]
struct Arguments {
    /// Instead, fails if a figure is 0.5 % off the committed one, or README's table is not of the committed ones
    #[arg(long, conflicts_with = "accept")]
    check: bool,
    /// Instead, takes the figures and README's table as they are now
    #[arg(long)]
    accept: bool,
    /// Something else than the page
    #[command(subcommand)]
    page: Option<Page>,
}

#[derive(Debug, Subcommand)]
enum Page {
    /// Known results reproduced: writes docs/validation.md and its pictures
    Validation {
        /// Instead, fails if a number or a word of the committed page is not as made now
        #[arg(long)]
        check: bool,
    },
    /// Proves that firmware has no panic, no double precision, no formatting and no allocation
    Firmware,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let root = cli::root();
    if let Some(Page::Validation { check }) = arguments.page {
        return validation::run(check);
    }
    cli::cross::add_target(root)?;
    match arguments.page {
        Some(_) => proof::check(root),
        None if arguments.check => gate::check(root),
        None if arguments.accept => gate::write(root, &gate::measure(root)?),
        None => gate::write(root, &page::write(root)?),
    }
}
