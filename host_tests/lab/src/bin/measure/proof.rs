//! `cargo check-firmware`: proof on linked programs for a microcontroller. Solver and monitor have no
//! panic, no double precision, no formatting and no allocation, and the solver no square root in software.
//!
//! - `bare_solver` and `bare_monitor` have a panic handler that does not link. They must link, the solver
//!   in single precision and in double.
//! - `any_profile` is the same with a bearing and a spindle, under profiles that other firmware has.
//! - In all of them, and in the firmware as shipped, the solver's calls are followed through the
//!   relocations. For code that must not be there, the way to it is printed.
//! - Images of the scenes are proved where they are measured, each by itself.
//! - All are first shown a program that has it: a check that finds nothing there is blind.

use crate::parts::{self, Part};
use crate::program::{Program, RELOCATIONS};
use crate::unwanted::{Unwanted, clean, find};
use anyhow::{Result, bail};
use cli::cross::{Build, F405};
use lab::images::{BARE, BARE_FLAGS, H743, IMAGES};
use std::path::Path;
use twin::graph::Reach;

/// Function that the panic handlers of the bare programs call, and nobody defines.
const MISSING: &str = "the_solver_can_panic";

/// Proves all of them but the scenes.
pub fn check(root: &Path) -> Result<()> {
    be_seen_to_fail(root, &SOLVER)?;
    bare(root, &SOLVER, None, &Unwanted::ALL)?;
    let whole = bare(root, &SOLVER, Some("double"), &Unwanted::IN_DOUBLE)?;
    parts::be_seen(root, &whole, Part::Design)?;
    bare(root, &MONITOR, None, &Unwanted::BUT_ROOTS)?;
    be_seen_to_fail(root, &ANY_PROFILE[0])?;
    for image in &ANY_PROFILE {
        bare(root, image, None, &Unwanted::BUT_ROOTS)?;
    }
    let kinds = &Unwanted::BUT_ROOTS;
    for spindle in &SPINDLES {
        shipped(root, (F405, "spindle_firmware"), spindle, kinds)?;
    }
    let kinds = &Unwanted::IN_DOUBLE;
    for spindle in &SPINDLES[..2] {
        shipped(root, (H743, "spindle_firmware_h743"), spindle, kinds)?;
    }
    Ok(())
}

/// Files of spindles, the shipped one without a name, and the parts that their firmware has of those in [`Part::OF_FILES`].
const SPINDLES: [(Option<&str>, &[Part]); 5] = [
    (None, &[Part::Elastic]),
    (
        Some("examples/spindle_file/spindles/bridges.toml"),
        &[Part::Elastic, Part::Bridges],
    ),
    (
        Some("examples/spindle_file/spindles/7014c_back_to_back.toml"),
        &[],
    ),
    (
        Some("examples/spindle_file/spindles/milling_spindle.toml"),
        &[Part::Sleeve],
    ),
    (
        Some("examples/spindle_file/spindles/probed_pair.toml"),
        &[Part::Elastic],
    ),
];

/// A program without a panic handler.
struct Image {
    package: &'static [&'static str],
    flags: &'static [&'static str],
    program: &'static str,
    /// Settings of its profile, if it is not the project's.
    profile: &'static [&'static str],
}

impl Image {
    const fn new(program: &'static str) -> Self {
        Self {
            package: IMAGES,
            flags: &[],
            program,
            profile: &[],
        }
    }

    const fn under(profile: &'static [&'static str]) -> Self {
        Self {
            package: BARE,
            flags: BARE_FLAGS,
            program: "any_profile",
            profile,
        }
    }
}

const SOLVER: Image = Image::new("bare_solver");
const MONITOR: Image = Image::new("bare_monitor");
/// Under cargo's own profile, with less optimisation, and as small programs, the last one as templates of RTIC have it.
const ANY_PROFILE: [Image; 4] = [
    Image::under(&["lto=false", "codegen-units=16"]),
    Image::under(&["opt-level=2", "lto=false", "codegen-units=16"]),
    Image::under(&["opt-level='s'", "lto=false", "codegen-units=16"]),
    Image::under(&["opt-level='s'"]),
];

/// Builds a bare program; where `lenient`, with a definition of the function that must not be called.
fn build_bare(root: &Path, image: &Image, variant: Option<&str>, lenient: bool) -> Result<Program> {
    let definition = format!("--defsym={MISSING}=0");
    let link = [RELOCATIONS, &definition];
    let build = Build {
        package: image.package,
        flags: image.flags,
        program: image.program,
        profile: image.profile,
        link: if lenient { &link } else { &link[..1] },
        environment: &[("BARE_SOLVER", variant)],
        quiet: true,
        ..Build::default()
    };
    Program::build(&build, root)
}

/// Fails unless a program with a panic, a double and a formatted number in it fails to link, and all are found.
fn be_seen_to_fail(root: &Path, image: &Image) -> Result<()> {
    let spoiled = Some("spoiled");
    match build_bare(root, image, spoiled, false) {
        Ok(_) => bail!("this check is blind: a program that can panic links"),
        Err(error) if is_missing(&error) => {}
        Err(error) => return Err(error.context(format!("{} does not build", image.program))),
    }
    let program = build_bare(root, image, spoiled, true)?;
    for kind in [Unwanted::Panic, Unwanted::Double, Unwanted::Formatting] {
        if find(&program.reach_from_main(), kind).is_none() {
            bail!(
                "this check is blind: it does not see that a program {}",
                kind.verb()
            );
        }
    }
    println!("a program with a panic, a double and a formatted number in it: refused");
    Ok(())
}

fn is_missing(error: &anyhow::Error) -> bool {
    error
        .to_string()
        .contains(&format!("undefined symbol: {MISSING}"))
}

/// Checks the solver, or the monitor, by itself.
fn bare(root: &Path, image: &Image, variant: Option<&str>, kinds: &[Unwanted]) -> Result<Program> {
    let name = image.program;
    let precision = variant.unwrap_or("single");
    let mut what = format!("{name} in {precision} precision");
    if !image.profile.is_empty() {
        what += &format!(" with {}", image.profile.join(", "));
    }
    let (program, links) = match build_bare(root, image, variant, false) {
        Ok(program) => (program, true),
        Err(error) if is_missing(&error) => (build_bare(root, image, variant, true)?, false),
        Err(error) => return Err(error.context(format!("{name} does not build"))),
    };
    refuse(&what, &program, &program.reach_from_main(), kinds)?;
    if !links {
        bail!("{what} can panic: it does not link for want of `{MISSING}`");
    }
    Ok(program)
}

/// Checks the monitor's firmware for a board and a spindle.
fn shipped(
    folder: &Path,
    (package, program): (&[&str], &str),
    &(spindle, parts): &(Option<&str>, &[Part]),
    kinds: &[Unwanted],
) -> Result<()> {
    let build = Build {
        package,
        program,
        link: &[RELOCATIONS],
        environment: &[("SPINDLE", spindle)],
        ..Build::default()
    };
    let program = Program::build(&build, folder)?;
    if find(&program.reach_from_main(), Unwanted::Panic).is_none() {
        bail!("this check is blind: it does not see the panics of the firmware's main");
    }
    let mut roots = ["recall", "take", "tick", "keep", "check_step"]
        .map(|function| format!("spindle_firmware::application::{function}"))
        .to_vec();
    if parts.contains(&Part::Bridges) {
        // Functions of the board that a tick calls by pointers, which no relocation follows.
        let chip = if package == H743 { "h743" } else { "f405" };
        let functions = ["drdy", "reset", "select", "now"];
        roots.extend(functions.map(|name| format!("spindle_firmware::stm32::sensors::{name}")));
        roots.push(format!("spindle_firmware::stm32::{chip}::spi::exchange"));
    }
    let is_root = |name: &str| {
        let is = |root: &String| {
            let rest = name.strip_prefix(root.as_str());
            // A generic one has its parameters behind it.
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with("::<"))
        };
        roots.iter().any(is) || is_library(name)
    };
    let reach = program.graph.reach(is_root);
    for root in &roots {
        if !reach.names().any(|name| name.starts_with(root.as_str())) {
            bail!("there is no {root} in the firmware to check");
        }
    }
    let root = roots.join(", ");
    let with = spindle.map_or(String::new(), |spindle| format!(" of {spindle}"));
    let what = format!("{root} in the firmware{with}");
    refuse(&what, &program, &reach, kinds)?;
    parts::has(&what, folder, &program, &reach, parts)
}

/// The library's own code, less what prints its types for a log.
fn is_library(name: &str) -> bool {
    let path = name.trim_start_matches('<');
    path.starts_with("spindle_bearing::") && !name.contains("defmt")
}

/// As [`clean`], of a program that must have functions of the library to look at.
fn refuse(what: &str, program: &Program, reach: &Reach<'_>, kinds: &[Unwanted]) -> Result<()> {
    if !reach.names().any(is_library) {
        bail!("this check is blind: there is no solver in {what}");
    }
    clean(what, program, reach, kinds)
}
