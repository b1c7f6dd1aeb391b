//! The part of `cargo reports` that needs the emulator: see `cargo reports --help`.

#![allow(
    clippy::duplicate_mod,
    reason = "the monitor's chain, once for each precision"
)]

mod bench;
mod clock;
mod decode;
mod figures;
mod gate;
mod host;
mod image;
mod machine;
mod memory;
mod milling;
mod page;
mod plan;
mod profile;
mod rows;
mod scenes;
mod target;
mod terminal;
mod ticks;
mod workload;

use anyhow::{Context, Result};
use clap::Parser;
use std::path::Path;
use std::process::ExitCode;
use tools::cross;
use tools::report::{Arguments, Command};

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    let root = tools::root();
    cross::add_target(root)?;
    if let Some(Command::Profile(choice)) = &arguments.command {
        return terminal::profile(root, choice);
    }
    if let Some(Command::Monitor) = &arguments.command {
        return ticks::alone(root);
    }
    if arguments.check {
        return gate::check(root);
    }
    if arguments.accept {
        return gate::accept(root);
    }
    let cases = arguments.cases as usize;
    let (mut rows, works, truths) = plan::run(root, cases)?;
    rows.append(scenes::run(root, &works)?);
    rows.append(milling::run(root)?);
    rows.append(ticks::run(root)?);
    rows.append(clock::run(&works, &truths)?);
    if let Some(path) = &arguments.json {
        let text = serde_json::to_string_pretty(rows.all())?;
        write(path, &(text + "\n"))?;
    }
    let docs = root.join("docs");
    figures::draw(&docs, &rows)?;
    write(&docs.join("report.md"), &page::page(&rows, cases))?;
    write(&docs.join("report_host.md"), &page::host_page(&rows))?;
    into_readme(&root.join("README.md"), &page::readme_table(&rows))?;
    println!(
        "{}\ndocs/report.md and its figures are written",
        page::main_table(&rows)
    );
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<()> {
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// Puts a table where the README wants it, if it does.
fn into_readme(path: &Path, table: &str) -> Result<()> {
    const MARKS: [&str; 2] = ["<!-- report: begin -->\n", "<!-- report: end -->"];
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let Some((before, rest)) = text.split_once(MARKS[0]) else {
        return Ok(());
    };
    let Some((_, after)) = rest.split_once(MARKS[1]) else {
        anyhow::bail!("{}: `{}` is missing", path.display(), MARKS[1]);
    };
    write(
        path,
        &format!(
            "{before}{}\n{}\n\n{}{after}",
            MARKS[0],
            table.trim_end(),
            MARKS[1]
        ),
    )
}
