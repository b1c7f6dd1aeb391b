//! Check that a firmware with one scene alone lacks the code that the scene leaves out.
//!
//! Functions are told by the debug information, which knows the inlined ones, too. Every instruction that
//! the solver reaches is asked for its functions and source lines. Physics that is a part of a function
//! stands in the library's source behind a constant of the scene, as in `if D == 5 {`. No instruction may
//! come from the lines of such a block.

use crate::program::Program;
use crate::unwanted::{Unwanted, clean};
use anyhow::{Context, Result, bail};
use lab::for_every_scene;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::ops::Range;
use std::path::Path;
use twin::graph::Reach;

/// Something that a scene, or the firmware of a spindle, may leave out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// Everything that belongs to a shaft that turns.
    Speed,
    /// Gyroscopic moment, friction and its couple.
    Friction,
    /// Rules of attitude other than that without race control.
    RaceControl,
    /// The rule without race control.
    RacewayControlFree,
    /// The loop of the ring, and the sums of its balls.
    Iteration,
    /// Radial displacements.
    Radial,
    /// Tilts.
    Tilts,
    /// Stiffness asked for.
    Stiffness,
    /// States of balls asked for.
    Balls,
    /// Limits asked for.
    Limits,
    /// Several bearings on one shaft.
    Spindle,
    /// An elastic shaft.
    Elastic,
    /// How constants come from a design.
    Design,
    /// A sleeve under a spring.
    Sleeve,
    /// Strain bridges and a tachometer.
    Bridges,
}

impl Part {
    const ALL: [Self; 13] = [
        Self::Speed,
        Self::Friction,
        Self::RaceControl,
        Self::RacewayControlFree,
        Self::Iteration,
        Self::Radial,
        Self::Tilts,
        Self::Stiffness,
        Self::Balls,
        Self::Limits,
        Self::Spindle,
        Self::Elastic,
        Self::Design,
    ];
    /// Parts that the file of a spindle decides on.
    const OF_FILES: [Self; 3] = [Self::Elastic, Self::Sleeve, Self::Bridges];

    /// Parts of the names of its functions and constants.
    fn names(self) -> &'static [&'static str] {
        match self {
            Self::Speed => &[
                "::linearise",
                "::kinetics_for",
                "::at_speed",
                "as spindle_bearing::ball::kinematics::Rule>::speeds",
                "spindle_bearing::ball::settle::",
                "atan",
            ],
            Self::Iteration => &[
                "spindle_bearing::rows::row::",
                "spindle_bearing::rows::Rows",
                "spindle_bearing::solver::newton::",
            ],
            Self::RaceControl => &["OuterRaceControl as", "InnerRaceControl as"],
            Self::RacewayControlFree => &["RacewayControlFree as"],
            Self::Stiffness => &[">::stiffness"],
            Self::Balls => &[">::balls"],
            Self::Limits => &["spindle_bearing::results::margins::"],
            Self::Spindle => &["spindle_bearing::spindle::", ">::assemble", ">::turned"],
            Self::Elastic => &[
                "spindle_bearing::rows::elastic::",
                "spindle_bearing::spindle::elastic::any::piece",
                "spindle_bearing::spindle::elastic::any::deflection",
            ],
            Self::Design => &[
                "spindle_bearing::hertz::",
                "spindle_bearing::const_math::",
                "spindle_bearing::design::",
            ],
            Self::Bridges => &["spindle_firmware::bridges::"],
            _ => &[],
        }
    }

    /// Whether a function, or a constant, of this name belongs to it.
    fn has(self, function: &str) -> bool {
        self.names().iter().any(|name| function.contains(name))
    }

    /// The conditions of the blocks that it is in.
    fn guards(self) -> &'static [&'static str] {
        match self {
            Self::Speed => &["M::AT_SPEED", "R::INERTIA"],
            Self::Friction => &["R::FRICTION"],
            Self::Radial => &["D >= 3"],
            Self::Tilts => &["D == 5", "D >= 5"],
            Self::Spindle => &["SET"],
            Self::Elastic => &["E > 0"],
            Self::Sleeve => &["D == 6"],
            _ => &[],
        }
    }
}

macro_rules! left_out {
    ($($number:literal $name:literal $freedoms:literal: $scene:ty; $without:literal, [$($part:ident),*];)*) => {
        /// The scenes, and the parts that each leaves out besides designs, which all do.
        const SCENES: &[(&str, &[Part])] = &[$(($name, &[$(Part::$part),*])),*];
    };
}
for_every_scene!(left_out);

/// Source lines of the solver that stand behind a condition, by file under `src`.
struct Guarded {
    /// The condition's line, and the block's.
    blocks: BTreeMap<String, Vec<(String, Range<u32>)>>,
}

impl Guarded {
    fn read(root: &Path) -> Result<Self> {
        let mut blocks = BTreeMap::new();
        let root = root.join("src");
        let mut folders = vec![root.clone()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder)? {
                let path = entry?.path();
                let name = path.strip_prefix(&root)?.to_string_lossy().into_owned();
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                let text = fs::read_to_string(&path)
                    .with_context(|| format!("cannot read {}", path.display()))?;
                blocks.insert(name, Self::blocks(&text));
            }
        }
        Ok(Self { blocks })
    }

    /// Blocks of `if`s that end on the line that they begin on, which is how they are formatted.
    fn blocks(text: &str) -> Vec<(String, Range<u32>)> {
        let lines: Vec<&str> = text.lines().collect();
        let indent = |line: &str| line.len() - line.trim_start().len();
        let mut found = Vec::new();
        for (i, line) in lines.iter().enumerate() {
            let opens = line.trim_end().ends_with('{');
            let is_if = line.trim_start().starts_with("if ") || line.contains("= if ");
            if !(opens && is_if) {
                continue;
            }
            let rest = lines[i + 1..].iter();
            let inside = rest
                .take_while(|l| l.trim().is_empty() || indent(l) > indent(line))
                .count();
            found.push((
                line.trim().to_owned(),
                i as u32 + 2..(i + 2 + inside) as u32,
            ));
        }
        found
    }

    /// The condition by which a part should not be at a line, if it should not.
    fn guard(&self, part: Part, file: &str, line: u32) -> Option<&str> {
        let blocks = self.blocks.get(file)?;
        let mut guards = blocks.iter().filter(|(_, lines)| lines.contains(&line));
        let guard = guards.find(|(condition, _)| {
            part.guards().iter().any(|guard| {
                condition
                    .find(guard)
                    .is_some_and(|at| !condition[..at].ends_with('!'))
                    && !condition.contains("||")
            })
        });
        guard.map(|(condition, _)| condition.as_str())
    }
}

/// Functions and source lines that a program's instructions come from.
struct Origins {
    functions: BTreeSet<String>,
    lines: BTreeSet<(String, u32)>,
}

impl Origins {
    /// Origins of the instructions reached in a program.
    fn of(program: &Program, reach: &Reach<'_>) -> Result<Self> {
        let loader = program.lines()?;
        let mut origins = Self {
            functions: BTreeSet::new(),
            lines: BTreeSet::new(),
        };
        for (start, size, name) in reach.symbols() {
            origins.functions.insert(name.to_owned());
            for address in (start..start + size).step_by(2) {
                let Ok(mut frames) = loader.find_frames(address) else {
                    continue;
                };
                while let Ok(Some(frame)) = frames.next() {
                    if let Some(Ok(name)) = frame.function.as_ref().map(|f| f.raw_name()) {
                        let name = format!("{:#}", rustc_demangle::demangle(&name));
                        origins.functions.insert(name);
                    }
                    let Some(place) = frame.location else {
                        continue;
                    };
                    if let (Some(file), Some(line)) = (place.file, place.line)
                        && let Some((folder, file)) = file.rsplit_once("/src/")
                        && !folder.contains("registry")
                        && !folder.contains("rustc")
                    {
                        origins.lines.insert((file.to_owned(), line));
                    }
                }
            }
        }
        Ok(origins)
    }

    /// Where a part is in the program, if it is.
    fn find(&self, part: Part, guarded: &Guarded) -> Option<String> {
        let function = self.functions.iter().find(|function| part.has(function));
        if let Some(function) = function {
            return Some(format!("there is `{function}`"));
        }
        self.lines.iter().find_map(|(file, line)| {
            let guard = guarded.guard(part, file, *line)?;
            Some(format!(
                "code of src/{file}:{line} is there, behind `{guard}`"
            ))
        })
    }
}

fn is_solver(name: &str) -> bool {
    name == "measured_solve"
}

/// Fails if a program of one scene has anything unwanted, or of a part that the scene leaves out. Returns the parts that it has.
pub fn prove(
    root: &Path,
    scene: &str,
    program: &Program,
    kinds: &[Unwanted],
) -> Result<BTreeSet<Part>> {
    let without = SCENES.iter().find(|(name, _)| *name == scene);
    let (_, without) = without.with_context(|| format!("no scene {scene}"))?;
    let reach = program.graph.reach(is_solver);
    // The code inlined into it makes it the solver.
    if !reach.names().any(is_solver) {
        bail!("this check is blind: there is no solver in {scene}");
    }
    clean(scene, program, &reach, kinds)?;
    let (guarded, origins) = (Guarded::read(root)?, Origins::of(program, &reach)?);
    if origins.lines.is_empty() {
        bail!("this check is blind: {scene} has no debug information");
    }
    let mut seen = BTreeSet::new();
    for part in Part::ALL {
        let left_out = without.contains(&part) || part == Part::Design;
        match origins.find(part, &guarded) {
            Some(place) if left_out => bail!("{scene} leaves out {part:?}, and yet {place}"),
            Some(_) => _ = seen.insert(part),
            None => {}
        }
    }
    Ok(seen)
}

/// Fails unless each part but the design is in one of the scenes: a search that finds a part nowhere proves nothing.
pub fn all_seen(seen: &BTreeSet<Part>) -> Result<()> {
    let mut parts = Part::ALL.into_iter();
    match parts.find(|part| *part != Part::Design && !seen.contains(part)) {
        Some(part) => bail!("this check is blind: it finds {part:?} nowhere"),
        None => Ok(()),
    }
}

/// Fails unless a part is found in a program that has it.
pub fn be_seen(root: &Path, program: &Program, part: Part) -> Result<()> {
    let origins = Origins::of(program, &program.reach_from_main())?;
    match origins.find(part, &Guarded::read(root)?) {
        Some(_) => Ok(()),
        None => bail!("this check is blind: it does not find {part:?}"),
    }
}

/// Fails unless the firmware of a spindle has these parts, and no other ones of its file.
pub fn has(
    what: &str,
    root: &Path,
    program: &Program,
    reach: &Reach<'_>,
    parts: &[Part],
) -> Result<()> {
    let (guarded, origins) = (Guarded::read(root)?, Origins::of(program, reach)?);
    for part in Part::OF_FILES {
        match (parts.contains(&part), origins.find(part, &guarded)) {
            (true, None) => bail!("{what} lacks {part:?}, or this check is blind"),
            (false, Some(place)) => bail!("{what} has no {part:?}, and yet {place}"),
            _ => {}
        }
    }
    println!("{what}: of {:?} it has {parts:?} alone", Part::OF_FILES);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_the_lines_that_are_indented_behind_its_condition() {
        let text = "fn f() {\n    if D == 5 {\n        a();\n\n        b();\n    } else {\n        c();\n    }\n}\n";
        let blocks = Guarded::blocks(text);
        assert_eq!(blocks, [("if D == 5 {".to_owned(), 3..6)]);
        let guarded = Guarded {
            blocks: [("f.rs".to_owned(), blocks)].into(),
        };
        assert!(guarded.guard(Part::Tilts, "f.rs", 3).is_some());
        assert!(guarded.guard(Part::Tilts, "f.rs", 7).is_none());
        assert!(guarded.guard(Part::Friction, "f.rs", 3).is_none());
        assert!(guarded.guard(Part::Tilts, "g.rs", 3).is_none());
    }

    #[test]
    fn a_negated_condition_guards_the_opposite() {
        let text = "    if !M::AT_SPEED {\n        a();\n    }\n";
        let guarded = Guarded {
            blocks: [("f.rs".to_owned(), Guarded::blocks(text))].into(),
        };
        assert!(guarded.guard(Part::Speed, "f.rs", 2).is_none());
    }
}
