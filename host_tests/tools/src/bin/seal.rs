//! `seal ELF...`: cargo's way from a firmware to a board. Writes the firmware with its seal beside it, and hands that to
//! the program that flashes it.

use anyhow::{Context, Result, bail};
use clap::Parser;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, ExitCode};
use tools::seal::sealed;

/// Writes what a firmware's self-checks expect into a copy of it, and calls a program with that copy.
///
/// The last argument is the firmware; the copy is beside it, as `.sealed`.
#[derive(Parser, Debug)]
#[command(name = "seal")]
struct Arguments {
    /// The program and its arguments, the firmware among them; without a program, only the copy is made
    #[arg(required = true, trailing_var_arg = true, allow_hyphen_values = true)]
    command: Vec<String>,
}

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// The first argument that is a file of an ELF program.
fn firmware(arguments: &[String]) -> Option<(usize, Vec<u8>)> {
    let read = |path: &String| fs::read(path).ok().filter(|of| of.starts_with(b"\x7fELF"));
    let mut files = arguments.iter().map(read).enumerate();
    files.find_map(|(i, file)| Some((i, file?)))
}

fn run(Arguments { mut command }: Arguments) -> Result<ExitCode> {
    let Some((at, elf)) = firmware(&command) else {
        bail!("there is no firmware among the arguments");
    };
    let mut path = PathBuf::from(&command[at]).into_os_string();
    path.push(".sealed");
    let of = || format!("{}", path.display());
    let sealed = sealed(&elf).with_context(|| format!("cannot seal {}", command[at]))?;
    fs::write(&path, sealed).with_context(|| format!("cannot write {}", of()))?;
    if at == 0 {
        println!("{}", of());
        return Ok(ExitCode::SUCCESS);
    }
    command[at] = of();
    let program = command.remove(0);
    let status = Command::new(&program)
        .args(&command)
        .status()
        .with_context(|| format!("cannot run {program}"))?;
    Ok(match status.code().map(u8::try_from) {
        Some(Ok(code)) => ExitCode::from(code),
        _ => ExitCode::FAILURE,
    })
}
