//! The firmware's twin: the same library on this machine, with the constants of the same spindle's file.
//!
//! `twin run` answers ticks, as the emulated board does. `twin seal [PROGRAM ...] ELF [...]` is cargo's way from a firmware to a
//! board: it writes the firmware with its seal beside it, as `.sealed`, and calls the program with that copy in the place of
//! the firmware. Without a program, only the copy is made. It says what the spindle takes of the board.

mod budget;
mod run;
mod seal;

use anyhow::{Context, Result, bail};
use std::fs;
use std::io;
use std::process::{Command, ExitCode};

fn main() -> Result<ExitCode> {
    let mut arguments = std::env::args().skip(1);
    match arguments.next().as_deref() {
        Some("run") => {
            run::run(io::stdin().lock(), io::stdout().lock()).map(|()| ExitCode::SUCCESS)
        }
        Some("seal") => seal(arguments.collect()),
        _ => bail!("`cargo emulate` and cargo's runner start this program"),
    }
}

fn seal(mut command: Vec<String>) -> Result<ExitCode> {
    let is_elf = |path: &String| fs::read(path).is_ok_and(|file| file.starts_with(b"\x7fELF"));
    let at = command.iter().position(is_elf);
    let at = at.context("there is no firmware among the arguments")?;
    let path = format!("{}.sealed", command[at]);
    let elf = fs::read(&command[at])?;
    let sealed = seal::sealed(&elf).with_context(|| format!("cannot seal {}", command[at]))?;
    eprintln!("{}", budget::budget(&elf)?);
    fs::write(&path, sealed).with_context(|| format!("cannot write {path}"))?;
    if at == 0 {
        println!("{path}");
        return Ok(ExitCode::SUCCESS);
    }
    command[at] = path;
    let program = &command[0];
    let status = Command::new(program).args(&command[1..]).status();
    let status = status.with_context(|| format!("cannot run {program}"))?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}
