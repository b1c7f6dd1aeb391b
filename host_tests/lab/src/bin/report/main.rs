//! `cargo reports`: see `cargo reports --help`.
//!
//! The measurement needs an emulator that takes a C compiler, cmake and libclang to build. This
//! program needs nothing of that: it sees to the tools, then has cargo build and run `measure`.

mod validation;

use anyhow::{Context, Result, ensure};
use clap::{Parser, Subcommand};
use cli::cross::{self, Missing, output};
use std::process::Command;

/// Measures the solver's cycles, memory and errors; writes docs/report.md, its picture and README's table
#[derive(Debug, Parser)]
#[command(name = "cargo reports")]
struct Arguments {
    /// Instead, fails if a figure is 2 % off the committed one, or README's table is not of the committed ones
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
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if let Some(Page::Validation { check }) = arguments.page {
        return validation::run(check);
    }
    // The page has times of optimised code on the host. The tests have built the other profile.
    let (profile, task) = match (arguments.check, arguments.accept) {
        (true, _) => ("dev", "check"),
        (_, true) => ("dev", "accept"),
        _ => ("host", "page"),
    };
    if !has_cmake() || !has_libclang() {
        cross::install(&Missing {
            what: "cmake or libclang",
            debian: &["cmake", "libclang-dev"],
            elsewhere: "Fedora: dnf install cmake clang-devel; Arch: pacman -S cmake clang; macOS: brew install cmake; anywhere, \
                        if libclang is there: set LIBCLANG_PATH to its folder",
        })?;
    }
    let status = cross::cargo()
        .args(["run", "--quiet", "--profile", profile, "-p", "lab"])
        .args(["--features", "emulator", "--bin", "measure", "--", task])
        .current_dir(cli::root())
        .status()
        .context("cannot run cargo")?;
    ensure!(status.success(), "the measurement has failed");
    Ok(())
}

fn has_cmake() -> bool {
    output(Command::new("cmake").arg("--version")).is_some()
}

/// Also where nothing tells: the build then says by itself that it is missing.
fn has_libclang() -> bool {
    let libraries = output(Command::new("/sbin/ldconfig").arg("-p"));
    let libraries = libraries.map(|libraries| libraries.replace("libclang-cpp", ""));
    std::env::var_os("LIBCLANG_PATH").is_some()
        || libraries.is_none_or(|all| all.contains("libclang.so") || all.contains("libclang-"))
}
