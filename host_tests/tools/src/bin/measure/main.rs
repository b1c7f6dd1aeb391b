//! The part of `cargo reports` that needs the emulator: see `cargo reports --help`.

#![allow(
    clippy::duplicate_mod,
    reason = "the monitor's chain, once for each precision"
)]

mod bench;
mod decode;
mod gate;
mod image;
mod machine;
mod page;
mod scenes;
mod sweep;
mod table;
mod ticks;
mod timing;
mod workload;

use anyhow::Result;
use clap::Parser;
use tools::cross;
use tools::report::{Arguments, Command};

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let root = tools::root();
    cross::add_target(root)?;
    if arguments.check {
        gate::check(root)
    } else if arguments.accept {
        gate::accept(root)
    } else if let Some(Command::Monitor) = arguments.command {
        gate::accept_monitor(root)
    } else {
        gate::write(root, &page::write(root)?)
    }
}
