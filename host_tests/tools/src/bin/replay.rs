//! `cargo replay`: see `cargo replay --help`.

use std::io;
use std::process::ExitCode;

fn main() -> ExitCode {
    let status = tools::replay::run(
        std::env::args_os(),
        io::stdin(),
        io::stdout().lock(),
        io::stderr(),
    );
    ExitCode::from(status)
}
