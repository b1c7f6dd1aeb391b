//! Writes a synthetic recording of `host_tests/records`, or the file named by the last argument.

use anyhow::{Context, bail};
use host_tests::{milling_cycle, warm_up};

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args().skip(1).peekable();
    let warming = args.next_if(|arg| arg == "--warm-up").is_some();
    let usual = if warming {
        warm_up::RECORD
    } else {
        milling_cycle::RECORD
    };
    let path = args.next().unwrap_or_else(|| usual.to_owned());
    if path.starts_with('-') || args.next().is_some() {
        bail!("usage: make_record [--warm-up] [FILE.csv]");
    }
    let mut text = Vec::new();
    let (rows, what) = if warming {
        let rows = warm_up::warm_up();
        warm_up::write_csv(&rows, &mut text)?;
        (rows.len(), "spindle that warms up")
    } else {
        let rows = milling_cycle::milling_cycle();
        milling_cycle::write_csv(&rows, &mut text)?;
        (rows.len(), "milling cycle")
    };
    std::fs::write(&path, text).with_context(|| format!("cannot write {path}"))?;
    println!("{path}: {rows} rows of a synthetic {what}");
    Ok(())
}
