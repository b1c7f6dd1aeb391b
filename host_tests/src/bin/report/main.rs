//! `cargo reports`: see `cargo reports --help`.
//!
//! The measurement needs an emulator that takes a C compiler, cmake and libclang to build. This
//! program needs nothing of that: it sees to the tools, then has cargo build and run the one that
//! measures.

use anyhow::{Context, Result};
use clap::Parser;
use host_tests::cross;
use host_tests::report::{Arguments, Command};
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = match &arguments.command {
        None | Some(Command::Profile(_)) => measure(),
    };
    match result {
        Ok(status) => status,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Builds and runs the program that measures, with the arguments of this one.
fn measure() -> Result<ExitCode> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .context("the project has no root folder")?;
    let status = cross::cargo()
        .args(["run", "--quiet", "--profile", "host", "-p", "host_tests"])
        .args(["--features", "emulator", "--bin", "measure", "--"])
        .args(std::env::args_os().skip(1))
        .current_dir(root)
        .status()
        .context("cannot run cargo")?;
    Ok(match status.code() {
        Some(0) => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    })
}
