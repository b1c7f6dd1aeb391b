//! `seal [PROGRAM ...] ELF [...]`: cargo's way from a firmware to a board. Writes the firmware with its seal beside it, as
//! `.sealed`, and calls the program with that copy in the place of the firmware. Without a program, only the copy is made.

use anyhow::{Context, Result};
use std::fs;
use std::process::{Command, ExitCode};
use tools::seal::sealed;

fn main() -> Result<ExitCode> {
    let mut command: Vec<String> = std::env::args().skip(1).collect();
    let is_elf = |path: &String| fs::read(path).is_ok_and(|file| file.starts_with(b"\x7fELF"));
    let at = command.iter().position(is_elf);
    let at = at.context("there is no firmware among the arguments")?;
    let path = format!("{}.sealed", command[at]);
    let sealed = sealed(&fs::read(&command[at])?);
    let sealed = sealed.with_context(|| format!("cannot seal {}", command[at]))?;
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
