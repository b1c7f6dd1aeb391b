//! The programs that are measured: built, and laid out in memory.

use crate::timing::Core;
use addr2line::Loader;
use anyhow::{Context, Result, anyhow};
use cli::cross::Build;
use judge::campaign::report::name;
use lab::images::IMAGES;
use object::{Object, ObjectSegment, ObjectSymbol};
use spindle_file::dispatch::Precision;
use std::collections::HashMap;
use std::path::Path;
use twin::graph::Graph;

/// Where memory begins that is not flash.
const RAM: u64 = 0x2000_0000;

/// A linked program.
pub struct Image {
    /// Bytes of the memory, by address.
    pub segments: Vec<(u32, Vec<u8>)>,
    elf: Vec<u8>,
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
            link: &["--emit-relocs"],
            flags: &flags,
            environment: &[
                ("MEASURED_CORE", core.processor()),
                ("MEASURED_PRECISION", Some(name(precision))),
                ("MEASURED_SCENE", scene),
                ("PROVED", None),
            ],
            quiet: true,
            ..Build::default()
        };
        let path = build.run(root).with_context(|| {
            let scene = scene.unwrap_or_default();
            format!("cannot build {program} {scene} for {}", core.name())
        })?;
        // The next build replaces it.
        let elf =
            std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let file = object::File::parse(&*elf)?;
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
            elf,
        })
    }

    /// Address of a symbol.
    pub fn symbol(&self, name: &str) -> Result<u32> {
        let address = self.symbols.get(name);
        address
            .copied()
            .with_context(|| format!("the program has no symbol {name}"))
    }

    /// Its debug information.
    pub fn lines(&self) -> Result<Loader> {
        let file = tempfile::NamedTempFile::new()?;
        std::fs::write(&file, &self.elf)?;
        Loader::new(file.path()).map_err(|error| anyhow!("{error}"))
    }

    /// Bytes of code and constants that a solve reaches, less the copying of question and answer.
    pub fn flash(&self) -> Result<u64> {
        let graph = Graph::read(&self.elf)?;
        let flash = |entry: &str, counted: fn(&str) -> bool| -> u64 {
            let reach = graph.reach(|name| name == entry);
            let symbols = reach.symbols();
            let counted = symbols.filter(|(at, _, name)| *at < RAM && counted(name));
            counted.map(|(_, size, _)| size).sum()
        };
        let around = flash("measured_nothing", |name| name == "measured_nothing");
        Ok(flash("measured_solve", |_| true).saturating_sub(around))
    }
}
