//! Scenes and designs that must not compile, and what the compiler says to them.
//!
//! Every program in `ui` is compiled twice: as it is, where it must be refused with the lines that it
//! begins with (`//~`), and with `--cfg good`, where it must pass, so that it is refused for nothing
//! else. Only the library's own words are compared: the compiler's change from release to release, which
//! rules out a comparison with its whole output.

use rayon::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// The library, compiled for programs to link.
fn library(folder: &Path) -> PathBuf {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args([
            "build",
            "--quiet",
            "-p",
            "spindle-bearing",
            "--lib",
            "--offline",
        ])
        .arg("--target-dir")
        .arg(folder)
        .current_dir(ROOT)
        .status();
    assert!(status.unwrap().success(), "the library does not build");
    folder.join("debug/libspindle_bearing.rlib")
}

/// Compiles a program; what the compiler says if it refuses.
fn compile(program: &Path, library: &Path, flags: &[&str]) -> Result<(), String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let name = program.file_stem().unwrap().to_string_lossy();
    // Each has a place of its own, since they run at the same time.
    let output = library.with_file_name(format!("{name}-{}.rmeta", flags.len()));
    let output = Command::new(rustc)
        .args(["--edition", "2024", "--crate-type", "lib"])
        .args(["--emit", "metadata", "--check-cfg", "cfg(good)", "-o"])
        .arg(output)
        .arg("-L")
        .arg(library.with_file_name("deps"))
        .arg("--extern")
        .arg(format!("spindle_bearing={}", library.display()))
        .args(flags)
        .arg(program)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    output.status.success().then_some(()).ok_or(said)
}

/// Text without its line breaks, which depend on the width that the compiler prints for.
fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What is not as it should be about a program.
fn complaint(program: &Path, library: &Path) -> Option<String> {
    let name = program.display();
    if let Err(said) = compile(program, library, &["--cfg", "good"]) {
        return Some(format!("{name}: refused even where it is good:\n{said}"));
    }
    let Err(said) = compile(program, library, &[]) else {
        return Some(format!("{name}: compiles"));
    };
    let text = fs::read_to_string(program).unwrap();
    let mut expected = text
        .lines()
        .map_while(|line| line.strip_prefix("//~ "))
        .peekable();
    assert!(expected.peek().is_some(), "{name} expects nothing");
    let missing = expected.find(|line| !flat(&said).contains(&flat(line)))?;
    Some(format!("{name}: {missing:?} is not in\n{said}"))
}

#[test]
fn what_makes_no_sense_does_not_compile_and_is_told_why() {
    let library = library(&Path::new(env!("CARGO_TARGET_TMPDIR")).join("compile_fail"));
    let programs = fs::read_dir(Path::new(ROOT).join("host_tests/ui")).unwrap();
    let programs: Vec<PathBuf> = programs.map(|entry| entry.unwrap().path()).collect();
    assert!(programs.len() >= 10, "{} programs", programs.len());
    let complain = |program: &PathBuf| complaint(program, &library);
    let complaints: Vec<String> = programs.par_iter().filter_map(complain).collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}
