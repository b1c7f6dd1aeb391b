//! Library of the programs: recordings, replays, telemetry on the host, tables and pictures.
//!
//! | modules | do |
//! | --- | --- |
//! | [`recordings`], [`quantities`], [`fault`], [`times`] | recorded loads, row by row |
//! | [`milling_cycle`], [`warm_up`], [`truth`], [`random`] | synthetic recordings |
//! | [`replay`], [`options`], [`lifetime`], [`sensitivity`] | recorded loads through the solver |
//! | [`limits`], [`response`] | recorded loads through the board's monitor |
//! | [`board`] | the board's monitor of any spindle on this machine |
//! | [`telemetry`] | the monitor's telemetry: decoded, simulated, viewed |
//! | [`stream`] | recordings as a board receives them, with and without faults |

#[cfg(feature = "programs")]
pub mod arguments;
#[cfg(feature = "solver")]
pub mod board;
#[cfg(feature = "full")]
pub mod chart;
#[cfg(feature = "programs")]
pub mod cross;
#[cfg(feature = "full")]
pub mod drawing;
#[cfg(feature = "board")]
pub mod emulator;
pub mod fault;
#[cfg(feature = "solver")]
pub mod lifetime;
#[cfg(feature = "solver")]
pub mod limits;
mod lines;
pub mod milling_cycle;
#[cfg(feature = "solver")]
pub mod options;
#[cfg(feature = "programs")]
pub mod output;
pub mod quantities;
pub mod random;
pub mod recordings;
#[cfg(feature = "solver")]
pub mod replay;
#[cfg(feature = "solver")]
pub mod response;
#[cfg(feature = "solver")]
pub mod sensitivity;
pub mod stream;
pub mod telemetry;
pub mod times;
#[cfg(feature = "solver")]
pub mod truth;
pub mod warm_up;

use std::path::Path;
#[cfg(feature = "programs")]
use std::process::Command;

/// The project's root.
pub fn root() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().nth(2).unwrap_or(here)
}

/// The commit that is checked out, in short.
#[cfg(feature = "programs")]
pub fn commit() -> String {
    let mut git = Command::new("git");
    let git = git.args(["rev-parse", "--short", "HEAD"]);
    cross::output(git.current_dir(root())).unwrap_or_else(|| "unknown".to_owned())
}
