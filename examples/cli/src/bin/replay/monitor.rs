//! The board's monitor over a recording: `cargo replay --limits` and `--response`.

use crate::arguments::Args;
use crate::output::unwritable;
use anyhow::{Context, Result, bail, ensure};
use cli::limits::Watch;
use cli::output::{NewFile, place};
use cli::recordings::Loads;
use cli::replay::Summary;
use spindle_file::spindles::SpindleFile;
use std::io::{self, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard};

fn lock(recording: &Arc<Mutex<Loads>>) -> MutexGuard<'_, Loads> {
    recording.lock().expect("a reader")
}

fn watch<'w>(args: &Args, file: &'w SpindleFile, recording: &'w str) -> Watch<'w> {
    Watch {
        file,
        board: args.board,
        commission: args.response.commission,
        recording,
    }
}

/// Writes the alarms to standard output.
pub fn limits(args: &Args) -> Result<Summary> {
    let file = args.file()?;
    let (rows, recording) = args.input(&file)?;
    let recording = recording.context("--limits needs a recording")?;
    let name = lock(&recording).file().to_owned();
    let mut out = io::BufWriter::new(io::stdout());
    let seen = cli::limits::limits(&watch(args, &file, &name), rows, &mut out)?;
    let recording = lock(&recording);
    for line in recording.account().lines() {
        eprintln!("replay: {line}");
    }
    ensure!(
        recording.counts().read > 0,
        "{name}: there is no row to read"
    );
    if let Some(line) = seen.ticks {
        eprintln!("replay: {name}: {line}");
    }
    if let Some(line) = seen.doubts {
        eprintln!("replay: {line}");
    }
    Ok(Summary::default())
}

/// Writes the measured preload and the gains of the probes to a file.
pub fn response(args: &Args, path: &Path) -> Result<Summary> {
    let file = args.file()?;
    let out = place(path).map_err(|error| unwritable(path, &error))?;
    let loads = args.loads.as_deref().unwrap_or(Path::new(""));
    for input in [loads, args.design()].into_iter().chain(file.files()) {
        if place(input).is_ok_and(|input| input == out) {
            bail!(
                "--response would overwrite its own input {}; name another file",
                path.display()
            );
        }
    }
    let (rows, recording) = args.input(&file)?;
    let recording = recording.context("--response needs a recording")?;
    let name = lock(&recording).file().to_owned();
    let has = lock(&recording).has_probes().any(|has| has);
    if let (false, Some(probe)) = (has, file.probes.first()) {
        bail!(
            "{name}: there is no column probe_{}_um; add one for each [[probe]]",
            probe.name
        );
    }
    let mut out = NewFile::create(path).map_err(|error| unwritable(path, &error))?;
    let write = |text: &str| {
        let written = out.write_all(text.as_bytes());
        written.map_err(|error| unwritable(path, &error))
    };
    let tell = |line: &str| eprintln!("replay: {line}");
    let watch = watch(args, &file, &name);
    let summary = cli::response::response(&watch, rows, write, tell)?;
    for line in lock(&recording).account().lines() {
        eprintln!("replay: {line}");
    }
    out.finish().map_err(|error| unwritable(path, &error))?;
    Ok(summary)
}
