//! Shared parts of the programs around the judge.

pub mod arguments;
pub mod bar;
#[cfg(feature = "full")]
pub mod chart;
pub mod cross;
#[cfg(feature = "full")]
pub mod drawing;
#[cfg(feature = "board")]
pub mod emulator;
pub mod output;
pub mod report;
pub mod stream;
#[cfg(feature = "board")]
pub mod telemetry;
#[cfg(feature = "full")]
pub mod workload;

use std::path::Path;
use std::process::Command;

/// The project's root.
pub fn root() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here)
}

/// The commit that is checked out, in short.
pub fn commit() -> String {
    let mut git = Command::new("git");
    let git = git.args(["rev-parse", "--short", "HEAD"]);
    cross::output(git.current_dir(root())).unwrap_or_else(|| "unknown".to_owned())
}
