//! The programs that are measured: built, and laid out in memory.

use anyhow::{Context, Result, bail};
use host_tests::dispatch::{Attitude, Precision};
use object::{Object, ObjectSegment, ObjectSymbol};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use tools::cross::{Build, Origin};
use tools::report::FULL;
use tools::timing::Core;

/// Which solver of the library.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// At speed, with a rule of attitude.
    AtSpeed(Attitude),
    /// At rest.
    Static,
}

impl Motion {
    /// The name of its scene.
    pub const fn name(self) -> &'static str {
        match self {
            Self::AtSpeed(Attitude::Raceless) => FULL,
            Self::AtSpeed(Attitude::Outer) => "outer",
            Self::AtSpeed(Attitude::Inner) => "inner",
            Self::Static => "static",
        }
    }
}

/// Name of a precision in tables and to the build.
pub const fn name(precision: Precision) -> &'static str {
    match precision {
        Precision::F32 => "f32",
        Precision::F64 => "f64",
    }
}

/// Which program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// Core it is compiled for.
    pub core: Core,
    /// Working precision.
    pub precision: Precision,
    /// Ball count.
    pub balls: usize,
    /// Scene and rule of attitude.
    pub motion: Motion,
}

/// A linked program.
pub struct Image {
    /// Where it lies, until the next one is built.
    pub path: PathBuf,
    /// The file.
    pub elf: Vec<u8>,
    /// What of it goes where.
    pub segments: Vec<(u32, Vec<u8>)>,
    symbols: HashMap<String, u32>,
}

impl Image {
    /// Builds it.
    pub fn build(root: &Path, variant: &Variant) -> Result<Self> {
        let Variant {
            core,
            precision,
            balls,
            motion,
        } = *variant;
        Self::of_scene(root, core, precision, balls, motion.name())
    }

    /// Builds the image with a scene.
    pub fn of_scene(
        root: &Path,
        core: Core,
        precision: Precision,
        balls: usize,
        scene: &str,
    ) -> Result<Self> {
        let balls = balls.to_string();
        let environment = [
            ("MEASURED_PRECISION", Some(name(precision))),
            ("MEASURED_BALLS", Some(&*balls)),
            ("MEASURED_SCENE", Some(scene)),
            ("PROVED", None),
        ];
        Self::of(root, core, "measured", &environment)
    }

    /// Builds an image for a core, with these environment variables.
    pub fn of(
        root: &Path,
        core: Core,
        program: &str,
        environment: &[(&str, Option<&str>)],
    ) -> Result<Self> {
        let build = Build {
            origin: Origin::Probes,
            program,
            link: &["--emit-relocs"],
            processor: (core != Core::M4f).then(|| core.processor()),
            environment,
            quiet: true,
        };
        let values: Vec<&str> = environment.iter().filter_map(|(_, value)| *value).collect();
        let built = build.run(root).with_context(|| {
            format!(
                "cannot build what to measure, {program} of {} for {}",
                values.join(", "),
                core.name()
            )
        })?;
        let elf =
            std::fs::read(&built).with_context(|| format!("cannot read {}", built.display()))?;
        // The next variant's build replaces it.
        let path = built.with_file_name(format!(
            "{program}-{}-{}",
            core.processor(),
            values.join("-")
        ));
        std::fs::write(&path, &elf).with_context(|| format!("cannot write {}", path.display()))?;
        let file = object::File::parse(&*elf)?;
        let mut segments = Vec::new();
        for segment in file.segments() {
            segments.push((u32::try_from(segment.address())?, segment.data()?.to_vec()));
        }
        let mut symbols = HashMap::new();
        for symbol in file.symbols() {
            if let Ok(name) = symbol.name()
                && name.starts_with("measured_") | name.starts_with("MEASURED_")
            {
                symbols.insert(name.to_owned(), symbol.address() as u32);
            }
        }
        Ok(Self {
            path,
            segments,
            symbols,
            elf,
        })
    }

    /// Address of a symbol.
    pub fn symbol(&self, name: &str) -> Result<u32> {
        match self.symbols.get(name) {
            Some(address) => Ok(*address),
            None => bail!("{} has no symbol {name}", self.path.display()),
        }
    }
}
