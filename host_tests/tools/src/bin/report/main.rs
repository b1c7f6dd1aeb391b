//! `cargo reports`: see `cargo reports --help`.
//!
//! The measurement needs an emulator that takes a C compiler, cmake and libclang to build. This
//! program needs nothing of that: it sees to the tools, then has cargo build and run the one that
//! measures.

mod validation;

use anyhow::{Context, Result};
use clap::Parser;
use std::path::Path;
use std::process::{Command as Process, ExitCode};
use tools::cross::{self, Missing, output};
use tools::report::{Arguments, Command};

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = match &arguments.command {
        // A few solves, for which the profile of the tests is fast enough, and built already.
        None if arguments.check => measure("dev"),
        None | Some(Command::Profile(_) | Command::Monitor) => measure("host"),
        Some(Command::Validation { check }) => validation::run(*check).map(|()| ExitCode::SUCCESS),
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
fn measure(profile: &str) -> Result<ExitCode> {
    let root = tools::root();
    for missing in missing() {
        cross::install(&missing)?;
    }
    let status = cross::cargo()
        .args(["run", "--quiet", "--profile", profile, "-p", "tools"])
        .args(["--features", "emulator", "--bin", "measure", "--"])
        .args(std::env::args_os().skip(1))
        .current_dir(root)
        .status()
        .context("cannot run cargo")?;
    Ok(if status.success() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// What the emulator's build wants and is not here.
fn missing() -> Vec<Missing<'static>> {
    let mut all = Vec::new();
    if output(Process::new("cmake").arg("--version")).is_none() {
        all.push(Missing {
            what: "cmake",
            debian: &["cmake"],
            elsewhere: "Fedora: dnf install cmake; Arch: pacman -S cmake; macOS: brew install cmake",
        });
    }
    if cfg!(target_os = "linux") && !has_libclang() {
        all.push(Missing {
            what: "libclang",
            debian: &["libclang-dev"],
            elsewhere: "Fedora: dnf install clang-devel; Arch: pacman -S clang; anywhere, if it is \
                        there: set LIBCLANG_PATH to its folder",
        });
    }
    all
}

/// Whether the library is where it is usually looked for.
fn has_libclang() -> bool {
    let is_library = |path: &Path| {
        path.file_name()
            .is_some_and(|name| name.to_string_lossy().starts_with("libclang.so"))
            || path.file_name().is_some_and(|name| {
                let name = name.to_string_lossy();
                name.starts_with("libclang-") && name.contains(".so") && !name.contains("cpp")
            })
    };
    let holds = |folder: &Path| {
        std::fs::read_dir(folder)
            .is_ok_and(|entries| entries.flatten().any(|e| is_library(&e.path())))
    };
    if std::env::var_os("LIBCLANG_PATH").is_some() {
        return true;
    }
    if output(Process::new("llvm-config").arg("--libdir")).is_some_and(|d| holds(Path::new(&d))) {
        return true;
    }
    ["/usr/lib", "/usr/lib64", "/usr/local/lib"]
        .iter()
        .any(|root| {
            let root = Path::new(root);
            let below = std::fs::read_dir(root).into_iter().flatten().flatten();
            holds(root)
                || below
                    .map(|entry| entry.path())
                    .any(|folder| holds(&folder) || holds(&folder.join("lib")))
        })
}
