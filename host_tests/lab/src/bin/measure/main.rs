//! The part of `cargo reports` that needs the emulator: see `cargo reports --help`.

mod bench;
mod capstone;
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
mod unicorn;
mod wheels;

use anyhow::{Result, bail};

fn main() -> Result<()> {
    let root = cli::root();
    cli::cross::add_target(root)?;
    let task = std::env::args().nth(1);
    match task.as_deref() {
        Some("check") => gate::check(root),
        Some("accept") => gate::write(root, &gate::measure(root)?),
        Some("page") => gate::write(root, &page::write(root)?),
        _ => bail!("`cargo reports` starts this program"),
    }
}
