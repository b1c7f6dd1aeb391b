//! The part of `cargo reports` that needs the emulator: see `cargo reports --help`.

mod bench;
mod clock;
mod decode;
mod host;
mod image;
mod machine;
mod memory;
mod plan;
mod profile;
mod rows;
mod target;
mod terminal;
mod workload;

use anyhow::{Context, Result};
use clap::Parser;
use host_tests::cross;
use host_tests::report::{Arguments, Command};
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .context("the project has no root folder")?;
    cross::add_target(root)?;
    if let Some(Command::Profile(choice)) = &arguments.command {
        return terminal::profile(root, choice);
    }
    let (mut rows, works, truths) = plan::run(root, arguments.cases)?;
    let t = std::time::Instant::now();
    let clock = clock::run(&works, &truths)?;
    eprintln!("clock {:?}", t.elapsed());
    rows.append(clock);
    if let Some(path) = &arguments.json {
        let text = serde_json::to_string_pretty(rows.all())?;
        std::fs::write(path, text + "\n")
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}
