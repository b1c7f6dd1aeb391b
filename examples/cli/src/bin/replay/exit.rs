//! Exit status of `cargo replay`.

use anyhow::Result;
use cli::replay::{ReplayError, Summary};
use std::io::ErrorKind;
use std::process::ExitCode;

/// Says how a replay has ended.
pub fn status(done: Result<Summary>) -> ExitCode {
    match done {
        Ok(summary) => {
            if !summary.refused.is_empty() {
                eprintln!("replay: {summary}");
            }
            if summary.any_row_read() {
                ExitCode::SUCCESS
            } else {
                ExitCode::from(2)
            }
        }
        Err(error) => {
            let status = match error.downcast_ref() {
                // A reader that has seen enough (`| head`) is no failure.
                Some(ReplayError::Output(_, reason)) if reason.kind() == ErrorKind::BrokenPipe => {
                    return ExitCode::SUCCESS;
                }
                Some(ReplayError::Output(..)) => 1,
                _ => 2,
            };
            eprintln!("replay: {error}");
            ExitCode::from(status)
        }
    }
}
