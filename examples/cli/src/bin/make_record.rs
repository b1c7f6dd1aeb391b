//! Writes a synthetic recording of `examples/cli/records`, or the file named by the last argument.

use anyhow::{Context, bail};
use cli::milling_cycle::{self, Place};
use cli::recordings::write_csv;
use cli::truth::Truth;
use cli::warm_up;
use spindle_file::spindles::SpindleFile;

/// The spindle with probes, and how it is used: ground for 220 N, its file saying 250, it loses a fifth of that after 80 s.
const PROBED: &str = "examples/spindle_file/spindles/probed_pair.toml";
const LOSS: Truth = Truth {
    preload: [220.0, 176.0],
    change: 80.0,
    ..Truth::SOUND
};
/// Its recording, s.
const SECONDS: f64 = 120.0;

fn main() -> anyhow::Result<()> {
    let mut args = std::env::args().skip(1).peekable();
    let mut is = |option: &str| args.next_if(|arg| arg == option).is_some();
    let (warming, at_nose, at_probes) = (is("--warm-up"), is("--nose"), is("--probes"));
    let usual = match (warming, at_nose, at_probes) {
        (true, ..) => Some(warm_up::RECORD),
        (_, true, _) => Some(milling_cycle::NOSE_RECORD),
        (.., true) => None,
        _ => Some(milling_cycle::RECORD),
    };
    let path = args.next().or(usual.map(str::to_owned));
    let path = path.filter(|path| !path.starts_with('-') && args.next().is_none());
    let Some(path) = path else {
        bail!(
            "usage: make_record [--warm-up | --nose] [FILE.csv], or make_record --probes FILE.csv"
        );
    };
    let mut text = Vec::new();
    let what = if at_probes {
        let file = SpindleFile::read(cli::root().join(PROBED))?;
        text = LOSS.recording(&file, SECONDS)?.into_bytes();
        "spindle that loses preload"
    } else if warming {
        write_csv(&warm_up::warm_up(), &mut text)?;
        "spindle that warms up"
    } else {
        let place = if at_nose { Place::Nose } else { Place::Bearing };
        write_csv(&milling_cycle::recorded(place), &mut text)?;
        "milling cycle"
    };
    let rows = text.iter().filter(|byte| **byte == b'\n').count() - 1;
    std::fs::write(&path, text).with_context(|| format!("cannot write {path}"))?;
    println!("{path}: {rows} rows of a synthetic {what}");
    Ok(())
}
