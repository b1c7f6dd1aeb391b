//! Where the cycles go: by part of the solver and by function, inlined ones included.
//!
//! Every instruction's functions are known from the debug information, and the calls that led to it
//! from the emulator, so that nothing has to be kept from being inlined.

use crate::image::Image;
use crate::machine::{Counts, Machine};
use addr2line::Loader;
use anyhow::{Result, anyhow};
use host_tests::timing::{self, Class, Core};
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

/// A part of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Part {
    /// The cold start, or the step ahead of a warm one.
    Start,
    /// Every ball linearised, its own unknowns eliminated.
    BallPass,
    /// What the balls hand to the ring, summed up.
    Assembly,
    /// The system for the ring.
    Ring,
    /// The load's balance among the balls' laws.
    Laws,
    /// The balls moved along with the ring, and their references.
    Moving,
    /// Checks, scaling, results.
    Rest,
}

impl Part {
    /// All of them, in the order of a solve.
    pub const ALL: [Self; 7] = [
        Self::Start,
        Self::BallPass,
        Self::Assembly,
        Self::Ring,
        Self::Laws,
        Self::Moving,
        Self::Rest,
    ];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::BallPass => "ball pass",
            Self::Assembly => "assembly",
            Self::Ring => "5x5",
            Self::Laws => "laws between sweeps",
            Self::Moving => "moving the balls",
            Self::Rest => "rest",
        }
    }

    /// It happens once in a solve rather than once in a sweep.
    pub const fn is_once(self) -> bool {
        matches!(self, Self::Start | Self::Rest)
    }
}

/// What belongs to which part: the first row whose functions are all on the way to an instruction.
#[rustfmt::skip]
const PARTS: [(&[&str], Part); 14] = [
    (&["Iteration::start"], Part::Start),
    (&["Iteration::predict"], Part::Start),
    (&["Iteration::place"], Part::Start),
    (&["Factors::of"], Part::Ring),
    (&["Factors::solve"], Part::Ring),
    (&["Iteration::descent"], Part::Ring),
    (&["Iteration::unbalanced"], Part::Laws),
    (&["Iteration::step"], Part::Laws),
    (&["Iteration::sweep", "Sums::add"], Part::Assembly),
    (&["Iteration::sweep", "Sums::force"], Part::Assembly),
    (&["Iteration::sweep", "Sums::tangent"], Part::Assembly),
    (&["Iteration::sweep"], Part::BallPass),
    (&["Iteration::follow"], Part::Moving),
    (&["Iteration::rebase"], Part::Moving),
];

/// Modules and functions that only help: what they cost is their callers'.
const HELPERS: [&str; 10] = [
    "float::",
    "sqrt::",
    "contact::add",
    "solver::dot5",
    "solver::norm",
    "contact::scale",
    "contact::sub",
    "contact::dot",
    "ring::shift",
    "solver::span",
];

/// Functions from the outermost to the innermost.
type Names = Rc<[Rc<str>]>;

/// A function's share of something counted.
#[derive(Debug, Clone, Copy, Default)]
pub struct Share {
    /// Cycles of its own, and of helpers.
    pub own: u64,
    /// Cycles with those of everything it calls.
    pub all: u64,
}

/// What counts come to.
#[derive(Debug, Clone, Default)]
pub struct Profile {
    /// Cycles by part.
    pub parts: BTreeMap<Part, u64>,
    /// Instructions and cycles by class.
    pub classes: BTreeMap<Class, (u64, u64)>,
    /// Cycles by function.
    pub functions: BTreeMap<String, Share>,
}

impl Profile {
    /// Cycles of everything.
    pub fn cycles(&self) -> u64 {
        self.parts.values().sum()
    }

    /// Cycles of what happens in every sweep.
    pub fn sweeping(&self) -> u64 {
        let parts = self.parts.iter().filter(|(part, _)| !part.is_once());
        parts.map(|(_, cycles)| cycles).sum()
    }

    /// Adds another's counts.
    pub fn add(&mut self, other: &Self) {
        for (part, cycles) in &other.parts {
            *self.parts.entry(*part).or_default() += cycles;
        }
        for (class, (instructions, cycles)) in &other.classes {
            let sum = self.classes.entry(*class).or_default();
            sum.0 += instructions;
            sum.1 += cycles;
        }
        for (name, share) in &other.functions {
            let sum = self.functions.entry(name.clone()).or_default();
            sum.own += share.own;
            sum.all += share.all;
        }
    }
}

/// Tells the functions of a program's instructions.
pub struct Profiler {
    loader: Loader,
    core: Core,
    frames: HashMap<u32, Names>,
    paths: HashMap<usize, Names>,
}

impl Profiler {
    /// For a program.
    pub fn new(core: Core, image: &Image) -> Result<Self> {
        let loader = Loader::new(&image.path)
            .map_err(|e| anyhow!("no debug information in {}: {e}", image.path.display()))?;
        Ok(Self {
            loader,
            core,
            frames: HashMap::new(),
            paths: HashMap::new(),
        })
    }

    fn frames(&mut self, address: u32) -> Result<Names> {
        if let Some(known) = self.frames.get(&address) {
            return Ok(known.clone());
        }
        let mut names: Vec<Rc<str>> = Vec::new();
        let mut frames = self
            .loader
            .find_frames(address.into())
            .map_err(|e| anyhow!("no functions at {address:#x}: {e}"))?;
        while let Some(frame) = frames
            .next()
            .map_err(|e| anyhow!("no functions at {address:#x}: {e}"))?
        {
            if let Some(function) = frame.function {
                names.push(plain(&function.demangle()?).into());
            }
        }
        if names.is_empty()
            && let Some(symbol) = self.loader.find_symbol(address.into())
        {
            names.push(plain(symbol).into());
        }
        names.reverse();
        let names: Names = names.into();
        self.frames.insert(address, names.clone());
        Ok(names)
    }

    /// Functions on the way to a called function, up to the call.
    fn path(&mut self, machine: &Machine, node: usize) -> Result<Names> {
        if let Some(known) = self.paths.get(&node) {
            return Ok(known.clone());
        }
        let names: Names = match machine.nodes()[node].caller {
            None => Rc::new([]),
            Some((caller, call)) => {
                let mut names = self.path(machine, caller)?.to_vec();
                names.extend(self.frames(call)?.iter().cloned());
                names.into()
            }
        };
        self.paths.insert(node, names.clone());
        Ok(names)
    }

    /// What these counts come to.
    pub fn profile(&mut self, machine: &Machine, counts: &Counts) -> Result<Profile> {
        let mut profile = Profile::default();
        // Per function on the way, once for every way.
        let mut ways: HashMap<(usize, u32), u64> = HashMap::new();
        let taken = u64::from(timing::taken(self.core));
        for ((node, block), runs) in counts {
            let block = &machine.blocks()[*block];
            let last = block.instructions.len().saturating_sub(1);
            for (i, (address, cycles, class)) in block.instructions.iter().enumerate() {
                let mut all = runs.all * u64::from(*cycles);
                if i == last {
                    all += runs.taken * taken;
                }
                let of_class = profile.classes.entry(*class).or_default();
                of_class.0 += runs.all;
                of_class.1 += all;
                *ways.entry((*node, *address)).or_default() += all;
            }
        }
        for ((node, address), cycles) in ways {
            let mut names = self.path(machine, node)?.to_vec();
            names.extend(self.frames(address)?.iter().cloned());
            *profile.parts.entry(part(&names)).or_default() += cycles;
            let mut seen: Vec<&str> = Vec::new();
            for name in names.iter().filter(|name| is_counted(name)) {
                let name = short(name);
                if !seen.contains(&name) {
                    seen.push(name);
                    profile.functions.entry(name.to_owned()).or_default().all += cycles;
                }
            }
            let own = names.iter().rev().find(|name| is_counted(name));
            let own = own.map_or("(around it)", |name| short(name));
            profile.functions.entry(own.to_owned()).or_default().own += cycles;
        }
        Ok(profile)
    }
}

fn is_counted(name: &str) -> bool {
    name.strip_prefix("spindle_bearing::")
        .is_some_and(|name| !HELPERS.iter().any(|helper| name.starts_with(helper)))
}

/// A name without crate and module.
fn short(name: &str) -> &str {
    let name = name.strip_prefix("spindle_bearing::").unwrap_or(name);
    name.split_once("::").map_or(name, |(_, name)| name)
}

fn part(names: &[Rc<str>]) -> Part {
    let has = |wanted: &&str| names.iter().any(|name| short(name) == *wanted);
    PARTS
        .iter()
        .find(|(all, _)| all.iter().all(has))
        .map_or(Part::Rest, |(_, part)| *part)
}

/// A demangled name without generic arguments, closures and disambiguators; of a trait's method the
/// type's.
fn plain(name: &str) -> String {
    let name = format!("{:#}", rustc_demangle::demangle(name));
    let name = match name
        .strip_prefix('<')
        .and_then(|rest| rest.split_once(" as "))
    {
        Some((implementor, rest)) if implementor.starts_with("spindle_bearing::") => {
            // The method is behind the bracket that closes the type.
            let method = rest.rsplit_once(">::").map_or("", |(_, method)| method);
            format!("{implementor}::{method}")
        }
        _ => name,
    };
    let mut depth = 0;
    let mut out = String::new();
    for c in name.chars() {
        match c {
            '<' => depth += 1,
            '>' => depth -= 1,
            _ if depth == 0 => out.push(c),
            _ => {}
        }
    }
    let parts: Vec<&str> = out
        .split("::")
        .filter(|part| !part.is_empty() && !part.starts_with('{') && !is_hash(part))
        .collect();
    parts.join("::")
}

fn is_hash(part: &str) -> bool {
    part.len() == 17 && part.starts_with('h') && part[1..].chars().all(|c| c.is_ascii_hexdigit())
}
