//! Scenes and designs that must not compile, and what the compiler says to them.
//!
//! Every program in `ui` is compiled twice: as it is, where it must be refused with the lines that it
//! begins with (`//~`), and with `--cfg good`, where it must pass, so that it is refused for nothing
//! else. Only the library's own words are compared: the compiler's change from release to release, which
//! rules out a comparison with its whole output.

use rayon::prelude::*;
use serde::Deserialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

#[derive(Deserialize)]
struct Message {
    target: Option<Target>,
    filenames: Option<Vec<PathBuf>>,
}

#[derive(Deserialize)]
struct Target {
    name: String,
}

/// The library, compiled for programs to link.
fn library(folder: &Path) -> PathBuf {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args(["build", "-p", "spindle-bearing", "--lib", "--offline"])
        .arg("--message-format=json")
        .arg("--target-dir")
        .arg(folder)
        .current_dir(ROOT)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "the library does not build:\n{said}"
    );
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .filter_map(|line| serde_json::from_str::<Message>(line).ok())
        .filter(|m| {
            m.target
                .as_ref()
                .is_some_and(|t| t.name == "spindle_bearing")
        })
        .filter_map(|m| m.filenames)
        .flatten()
        .find(|file| file.extension().is_some_and(|e| e == "rlib"))
        .expect("cargo does not say where the library is")
}

/// Compiles a program; what the compiler says if it refuses.
fn compile(program: &Path, library: &Path, folder: &Path, good: bool) -> Result<(), String> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let mut command = Command::new(rustc);
    command
        .args(["--edition", "2024", "--crate-type", "lib"])
        .args(["--emit", "metadata", "--check-cfg", "cfg(good)"])
        .arg("--out-dir")
        .arg(folder)
        .arg("-L")
        .arg(library.with_file_name("deps"))
        .arg("--extern")
        .arg(format!("spindle_bearing={}", library.display()))
        .arg(program);
    if good {
        command.args(["--cfg", "good"]);
    }
    let output = command.output().unwrap();
    if output.status.success() {
        return Ok(());
    }
    Err(String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Text without its line breaks, which depend on the width that the compiler prints for.
fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What is not as it should be about a program.
fn complaints(program: &Path, library: &Path, folder: &Path) -> Vec<String> {
    let name = program.file_stem().unwrap().to_string_lossy();
    let text = fs::read_to_string(program).unwrap();
    let expected: Vec<String> = text
        .lines()
        .map_while(|line| line.strip_prefix("//~ "))
        .map(flat)
        .collect();
    assert!(!expected.is_empty(), "{name} expects nothing");
    let mut complaints = Vec::new();
    // Each into a folder of its own, since they run at the same time.
    let outputs = ["good", "bad"].map(|kind| folder.join(format!("{name}-{kind}")));
    for output in &outputs {
        fs::create_dir_all(output).unwrap();
    }
    if let Err(said) = compile(program, library, &outputs[0], true) {
        complaints.push(format!("{name}: refused even where it is good:\n{said}"));
    }
    match compile(program, library, &outputs[1], false) {
        Ok(()) => complaints.push(format!("{name}: compiles")),
        Err(said) => {
            let said_flat = flat(&said);
            for line in expected.iter().filter(|line| !said_flat.contains(*line)) {
                complaints.push(format!("{name}: {line:?} is not in\n{said}"));
            }
        }
    }
    complaints
}

#[test]
fn what_makes_no_sense_does_not_compile_and_is_told_why() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("compile_fail");
    let library = library(&folder);
    let mut programs: Vec<PathBuf> = fs::read_dir(Path::new(ROOT).join("host_tests/ui"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .collect();
    programs.sort();
    assert!(programs.len() >= 10, "{} programs", programs.len());
    let complaints: Vec<String> = programs
        .par_iter()
        .flat_map_iter(|program| complaints(program, &library, &folder))
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}
