//! `cargo replay`: recorded loads and speed in, displacements and stiffness out.

mod arguments;
mod exit;
mod formats;
mod input;
mod monitor;
mod output;
mod table;

use anyhow::Result;
use arguments::Args;
use clap::Parser;
use cli::lifetime::Lifetime;
use cli::replay::{ReplayError, Summary, Table, replay};
use cli::sensitivity::sensitivity;
use solvers::with_solver;
use spindle_file::catalogue;
use std::io::{self, Write};
use std::process::ExitCode;

fn main() -> ExitCode {
    let args = Args::parse();
    if args.list {
        // Nobody reads a message about standard output that is closed.
        let _ = io::stdout().write_all(catalogue::list().as_bytes());
        return ExitCode::SUCCESS;
    }
    exit::status(
        match (&args.response.response, args.limits, args.sensitivity) {
            (Some(path), ..) => monitor::response(&args, path),
            (_, true, _) => monitor::limits(&args),
            (_, _, true) => changes(&args),
            _ => run(&args),
        },
    )
}

fn run(args: &Args) -> Result<Summary> {
    let file = args.file()?;
    args.check_outputs(&file)?;
    let options = args.options();
    let (balls, held) = options.checked(&file)?;
    let mut lifetime = args.summary.map(|_| Lifetime::default());
    let solved = with_solver(&file.plan, balls, options.precision, |solver| {
        let (rows, recording) = args.input(&file)?;
        let mut files = args.files(&file)?;
        let job = options.job(&file, held, args.select.clone(), lifetime.as_mut());
        let replayed = replay(job, solver, rows, args.outputs(&mut files));
        // Nobody reads on where an output has failed.
        let is_out = matches!(replayed, Err(ReplayError::Output(..)));
        if let Some(recording) = recording.filter(|_| !is_out) {
            input::account(&recording, replayed.is_ok())?;
        }
        let summary = replayed?;
        output::finish(files, &summary)?;
        anyhow::Ok(summary)
    });
    let summary = solved.map_err(|error| file.explain(&error))??;
    if let (Some(lifetime), Some(form)) = (lifetime, args.summary) {
        output::summarise(lifetime, form)?;
    }
    Ok(summary)
}

/// Writes the table of changes to standard output.
fn changes(args: &Args) -> Result<Summary> {
    let text = sensitivity(&args.file()?, args.state.0)?;
    let written = io::stdout().write_all(text.as_bytes());
    written.map_err(|error| ReplayError::Output(Table::Results, error))?;
    Ok(Summary::default())
}
