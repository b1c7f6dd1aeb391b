//! Writes a synthetic recording of `examples/cli/records`, or the file named by the last argument.

use anyhow::{Context, bail};
use cli::milling_cycle::{self, Place};
use cli::recordings::write_csv;
use cli::warm_up;

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args().skip(1).peekable();
    let warming = args.next_if(|arg| arg == "--warm-up").is_some();
    let at_nose = !warming && args.next_if(|arg| arg == "--nose").is_some();
    let usual = match (warming, at_nose) {
        (true, _) => warm_up::RECORD,
        (_, true) => milling_cycle::NOSE_RECORD,
        _ => milling_cycle::RECORD,
    };
    let path = args.next().unwrap_or_else(|| usual.to_owned());
    if path.starts_with('-') || args.next().is_some() {
        bail!("usage: make_record [--warm-up | --nose] [FILE.csv]");
    }
    let (rows, what) = if warming {
        (warm_up::warm_up(), "spindle that warms up")
    } else {
        let place = if at_nose { Place::Nose } else { Place::Bearing };
        (milling_cycle::recorded(place), "milling cycle")
    };
    let mut text = Vec::new();
    write_csv(&rows, &mut text)?;
    std::fs::write(&path, text).with_context(|| format!("cannot write {path}"))?;
    println!("{path}: {} rows of a synthetic {what}", rows.len());
    Ok(())
}
