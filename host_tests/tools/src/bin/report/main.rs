//! `cargo reports`: see `cargo reports --help`.
//!
//! The measurement needs an emulator that takes a C compiler, cmake and libclang to build. This
//! program needs nothing of that: it sees to the tools, then has cargo build and run the one that
//! measures.

mod validation;

use anyhow::{Context, Result};
use clap::Parser;
use std::process::{Command as Process, ExitCode};
use tools::cross::{self, Missing, output};
use tools::report::{Arguments, Command};

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    match arguments.command {
        Some(Command::Validation { check }) => validation::run(check).map(|()| ExitCode::SUCCESS),
        // Times on the host are those of optimised code.
        None if !arguments.check && !arguments.accept => measure("host"),
        // Built already for the tests, as far as it goes, and fast enough.
        None | Some(Command::Monitor) => measure("dev"),
    }
}

/// Builds and runs the program that measures, with the arguments of this one.
fn measure(profile: &str) -> Result<ExitCode> {
    for missing in missing() {
        cross::install(&missing)?;
    }
    let status = cross::cargo()
        .args(["run", "--quiet", "--profile", profile, "-p", "tools"])
        .args(["--features", "emulator", "--bin", "measure", "--"])
        .args(std::env::args_os().skip(1))
        .current_dir(tools::root())
        .status()
        .context("cannot run cargo")?;
    Ok(if status.success() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// Tools that the emulator's build takes and that are not here.
fn missing() -> Vec<Missing<'static>> {
    let mut all = Vec::new();
    if output(Process::new("cmake").arg("--version")).is_none() {
        all.push(Missing {
            what: "cmake",
            debian: &["cmake"],
            elsewhere: "Fedora: dnf install cmake; Arch: pacman -S cmake; macOS: brew install cmake",
        });
    }
    // Elsewhere the build says by itself that it is missing.
    let libraries = output(Process::new("/sbin/ldconfig").arg("-p"));
    let has_libclang = |libraries: String| {
        let libraries = libraries.replace("libclang-cpp", "");
        libraries.contains("libclang.so") || libraries.contains("libclang-")
    };
    let has_path = std::env::var_os("LIBCLANG_PATH").is_some();
    if !has_path && libraries.is_some_and(|libraries| !has_libclang(libraries)) {
        all.push(Missing {
            what: "libclang",
            debian: &["libclang-dev"],
            elsewhere: "Fedora: dnf install clang-devel; Arch: pacman -S clang; anywhere, if it is \
                        there: set LIBCLANG_PATH to its folder",
        });
    }
    all
}
