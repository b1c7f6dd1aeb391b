//! The firmware, built by cargo and sealed.

use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};
use tools::cross::{Build, TARGET};
use tools::seal::sealed;

/// A firmware ready to run.
pub struct Firmware {
    /// Where its ELF lies.
    pub path: PathBuf,
    /// The ELF.
    pub elf: Vec<u8>,
}

/// Builds the firmware of the project in `root`, and seals it.
pub fn build(root: &Path) -> Result<Firmware> {
    eprintln!("building the firmware for {TARGET}; the first time takes about a minute");
    let built = Build {
        program: "spindle_monitor",
        ..Build::default()
    }
    .run(root)?;
    let elf = fs::read(&built).with_context(|| format!("cannot read {}", built.display()))?;
    let (elf, path) = (sealed(&elf)?, built.with_extension("sealed"));
    fs::write(&path, &elf).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(Firmware { path, elf })
}
