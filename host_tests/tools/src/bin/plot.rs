//! `cargo plot`: see `cargo plot --help`.

use std::io;
use std::process::ExitCode;

fn main() -> ExitCode {
    let status = tools::plot::run(
        std::env::args_os(),
        io::stdin(),
        io::stdout().lock(),
        io::stderr(),
    );
    ExitCode::from(status)
}
