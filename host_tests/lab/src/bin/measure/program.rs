//! A linked program: its bytes, its calls, and the lines of source behind its instructions.

use addr2line::Loader;
use anyhow::{Context, Result, anyhow};
use cli::cross::Build;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use tempfile::NamedTempFile;
use twin::graph::{Graph, Reach};

/// Keeps the relocations, by which calls are followed.
pub const RELOCATIONS: &str = "--emit-relocs";
/// Where memory begins that is not flash.
pub const RAM: u64 = 0x2000_0000;

/// A linked program. The next build replaces cargo's file, so that this one is a copy.
pub struct Program {
    /// The file.
    pub elf: Vec<u8>,
    /// Its calls.
    pub graph: Graph,
    copy: NamedTempFile,
}

impl Program {
    /// Builds it.
    pub fn build(build: &Build<'_>, root: &Path) -> Result<Self> {
        let path = build.run(root)?;
        let elf =
            std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let graph =
            Graph::read(&elf).with_context(|| format!("cannot make out {}", path.display()))?;
        let copy = NamedTempFile::new()?;
        std::fs::write(&copy, &elf)?;
        Ok(Self { elf, graph, copy })
    }

    /// Its debug information.
    pub fn lines(&self) -> Result<Loader> {
        Loader::new(self.copy.path()).map_err(|error| anyhow!("no debug information: {error}"))
    }

    /// All that `main` reaches.
    pub fn reach_from_main(&self) -> Reach<'_> {
        self.graph.reach(|name| name == "main")
    }

    /// The lines of source behind an address, from the innermost inlined function outwards.
    pub fn lines_of(&self, address: u64) -> Result<String, Box<dyn Error>> {
        let loader = self.lines()?;
        let mut frames = loader.find_frames(address)?;
        let mut lines = String::new();
        while let Some(frame) = frames.next()? {
            if let Some(place) = frame.location {
                let (file, line) = (place.file.unwrap_or("?"), place.line.unwrap_or(0));
                write!(lines, "\n       at {file}:{line}")?;
            }
        }
        Ok(lines)
    }
}
