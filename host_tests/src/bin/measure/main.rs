//! The part of `cargo reports` that needs the emulator: see `cargo reports --help`.

mod bench;
mod decode;
mod image;
mod machine;
mod profile;
mod terminal;
mod workload;

use clap::Parser;
use host_tests::report::{Arguments, Command};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = match &arguments.command {
        Some(Command::Profile(choice)) => terminal::profile(choice),
        None => terminal::profile(&Default::default()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
