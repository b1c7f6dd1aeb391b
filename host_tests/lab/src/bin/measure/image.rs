//! The programs that are measured: built, and laid out in memory.

use crate::program::{Program, RAM, RELOCATIONS};
use crate::timing::Core;
use anyhow::{Context, Result};
use cli::cross::Build;
use judge::campaign::report::name;
use lab::images::IMAGES;
use object::{Object, ObjectSegment, ObjectSymbol};
use solvers::dispatch::Precision;
use std::collections::HashMap;
use std::path::Path;

/// A program in memory.
pub struct Image {
    /// Bytes of the memory, by address.
    pub segments: Vec<(u32, Vec<u8>)>,
    /// The program.
    pub program: Program,
    symbols: HashMap<String, u32>,
}

impl Image {
    /// Builds a program of `host_tests/lab`.
    pub fn build(
        root: &Path,
        core: Core,
        program: &str,
        precision: Precision,
        scene: Option<&str>,
    ) -> Result<Self> {
        // These take the place of the configuration's flags, so that the linker scripts are named again.
        let flags = core.processor().map(|processor| {
            [
                format!("-Ctarget-cpu={processor}"),
                "-Clink-arg=-Tlink.x".to_owned(),
                "-Clink-arg=-Lexamples/firmware/f405".to_owned(),
                "-Clink-arg=-Tdefmt.x".to_owned(),
            ]
        });
        let flags: Vec<&str> = flags.iter().flatten().map(String::as_str).collect();
        let build = Build {
            package: IMAGES,
            program,
            link: &[RELOCATIONS],
            flags: &flags,
            environment: &[
                ("MEASURED_CORE", core.processor()),
                ("MEASURED_PRECISION", Some(name(precision))),
                ("MEASURED_SCENE", scene),
            ],
            quiet: true,
            ..Build::default()
        };
        let program = Program::build(&build, root).with_context(|| {
            let scene = scene.unwrap_or_default();
            format!("cannot build {program} {scene} for {}", core.name())
        })?;
        let file = object::File::parse(&*program.elf)?;
        let mut segments = Vec::new();
        for segment in file.segments() {
            segments.push((u32::try_from(segment.address())?, segment.data()?.to_vec()));
        }
        let symbols = file
            .symbols()
            .filter_map(|symbol| Some((symbol.name().ok()?.to_owned(), symbol.address() as u32)))
            .collect();
        Ok(Self {
            segments,
            symbols,
            program,
        })
    }

    /// Address of a symbol.
    pub fn symbol(&self, name: &str) -> Result<u32> {
        let address = self.symbols.get(name);
        address
            .copied()
            .with_context(|| format!("the program has no symbol {name}"))
    }

    /// Bytes of code and constants that a solve reaches, less the copying of question and answer.
    pub fn flash(&self) -> u64 {
        let flash = |entry: &str, counted: fn(&str) -> bool| -> u64 {
            let reach = self.program.graph.reach(|name| name == entry);
            let symbols = reach.symbols();
            let counted = symbols.filter(|(at, _, name)| *at < RAM && counted(name));
            counted.map(|(_, size, _)| size).sum()
        };
        let around = flash("measured_nothing", |name| name == "measured_nothing");
        flash("measured_solve", |_| true).saturating_sub(around)
    }
}
