//! Where the cycles go: by part of the solver and by function, inlined ones included.
//!
//! Every instruction's functions are known from the debug information, and the calls that led to it
//! from the emulator, so that nothing has to be kept from being inlined.

use crate::image::Image;
use crate::machine::{Counts, Machine};
use addr2line::Loader;
use anyhow::{Result, anyhow};
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;
use tools::timing::{self, Class, Core};

/// A part of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Part {
    /// The cold start, or the prediction of a warm one.
    Start,
    /// Every ball condensed.
    BallPass,
    /// What the balls hand to the ring, summed up.
    Assembly,
    /// The ring's step, control, and the error estimate.
    Ring,
    /// References moved, and the second order of the balls' motion.
    Moving,
    /// Checks, scaling, results.
    Rest,
}

impl Part {
    /// All of them, in the order of a solve.
    pub const ALL: [Self; 6] = [
        Self::Start,
        Self::BallPass,
        Self::Assembly,
        Self::Ring,
        Self::Moving,
        Self::Rest,
    ];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::BallPass => "ball pass",
            Self::Assembly => "assembly",
            Self::Ring => "5x5 and control",
            Self::Moving => "moving the balls",
            Self::Rest => "rest",
        }
    }

    /// It happens once in a solve rather than once in an iteration.
    pub const fn is_once(self) -> bool {
        matches!(self, Self::Start | Self::Rest)
    }
}

/// What belongs to which part: the first row whose functions are all on the way to an instruction.
#[rustfmt::skip]
const PARTS: [(&[&str], Part); 7] = [
    (&["State::newton", "Row::condense_balls"], Part::BallPass),
    (&["State::newton", "Row::sum"], Part::Assembly),
    (&["State::newton", "State::anchor"], Part::Moving),
    (&["State::newton", "Row::follow"], Part::Moving),
    (&["State::newton", "State::bend"], Part::Moving),
    (&["State::newton"], Part::Ring),
    (&["State::solve"], Part::Start),
];

/// Modules that only help: what their functions cost is the callers'.
const HELPERS: [&str; 3] = ["float::", "sqrt::", "linalg::"];
/// But for these.
const COUNTED: &str = "linalg::Factors";

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

    /// Cycles of what happens in every iteration.
    pub fn iterating(&self) -> u64 {
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
    ways: HashMap<Vec<Rc<str>>, Rc<Way>>,
    names: Vec<String>,
    costs: HashMap<(usize, usize), Vec<Item>>,
}

/// Where an instruction belongs.
#[derive(PartialEq, Eq)]
struct Way {
    part: Part,
    /// The function itself, and all on the way to it.
    own: usize,
    all: Vec<usize>,
}

/// Instructions of a block that belong to the same place.
struct Item {
    class: Class,
    instructions: u64,
    cycles: u64,
    way: Rc<Way>,
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
            ways: HashMap::new(),
            names: Vec::new(),
            costs: HashMap::new(),
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
        let taken = u64::from(timing::taken(self.core));
        let mut profile = Profile::default();
        let mut shares: Vec<Share> = Vec::new();
        for (place, runs) in counts {
            if !self.costs.contains_key(place) {
                let cost = self.cost(machine, *place)?;
                self.costs.insert(*place, cost);
            }
            shares.resize(self.names.len(), Share::default());
            for (i, item) in self.costs[place].iter().enumerate() {
                // The branch is the last one.
                let extra = if i == 0 { runs.taken * taken } else { 0 };
                let cycles = runs.all * item.cycles + extra;
                let of_class = profile.classes.entry(item.class).or_default();
                of_class.0 += runs.all * item.instructions;
                of_class.1 += cycles;
                *profile.parts.entry(item.way.part).or_default() += cycles;
                shares[item.way.own].own += cycles;
                for function in &item.way.all {
                    shares[*function].all += cycles;
                }
            }
        }
        for (name, share) in self.names.iter().zip(shares) {
            if share.all + share.own > 0 {
                profile.functions.insert(name.clone(), share);
            }
        }
        Ok(profile)
    }

    /// What one run of a block under a calling function costs, its last instruction first.
    fn cost(&mut self, machine: &Machine, (node, block): (usize, usize)) -> Result<Vec<Item>> {
        let mut items: Vec<Item> = Vec::new();
        let instructions = &machine.blocks()[block].instructions;
        for (address, cycles, class) in instructions.iter().rev() {
            let way = self.way(machine, node, *address)?;
            let same = items
                .iter_mut()
                .find(|i| i.class == *class && *i.way == *way);
            match same {
                Some(item) => {
                    item.instructions += 1;
                    item.cycles += u64::from(*cycles);
                }
                None => items.push(Item {
                    class: *class,
                    instructions: 1,
                    cycles: u64::from(*cycles),
                    way,
                }),
            }
        }
        Ok(items)
    }

    fn way(&mut self, machine: &Machine, node: usize, address: u32) -> Result<Rc<Way>> {
        let mut names = self.path(machine, node)?.to_vec();
        names.extend(self.frames(address)?.iter().cloned());
        if let Some(known) = self.ways.get(&names) {
            return Ok(known.clone());
        }
        let mut all: Vec<usize> = Vec::new();
        for name in names.iter().filter(|name| is_counted(name)) {
            let id = self.id(short(name));
            if !all.contains(&id) {
                all.push(id);
            }
        }
        let own = names.iter().rev().find(|name| is_counted(name)).cloned();
        let own = self.id(own.as_deref().map_or("(around it)", short));
        let way = Rc::new(Way {
            part: part(&names),
            own,
            all,
        });
        self.ways.insert(names, way.clone());
        Ok(way)
    }

    fn id(&mut self, name: &str) -> usize {
        let known = self.names.iter().position(|n| n == name);
        known.unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        })
    }
}

fn is_counted(name: &str) -> bool {
    let of_module = |module: &&str| name.contains(&format!("::{module}"));
    name.starts_with("spindle_bearing::") && (of_module(&COUNTED) || !HELPERS.iter().any(of_module))
}

/// A name without crate and modules.
fn short(name: &str) -> &str {
    let mut rest = name;
    while let Some((module, inside)) = rest.split_once("::")
        && !module.starts_with(char::is_uppercase)
    {
        rest = inside;
    }
    rest
}

fn part(names: &[Rc<str>]) -> Part {
    let has = |wanted: &&str| names.iter().any(|name| short(name) == *wanted);
    PARTS
        .iter()
        .find(|(all, _)| all.iter().all(has))
        .map_or(Part::Rest, |(_, part)| *part)
}

/// A demangled name without generic arguments, closures and disambiguators; of a trait's method, or of one in
/// another module than its type, the type's.
fn plain(name: &str) -> String {
    let name = format!("{:#}", rustc_demangle::demangle(name));
    let of_trait = name
        .strip_prefix('<')
        .and_then(|rest| rest.split_once(" as "));
    let elsewhere = name
        .split_once("::<impl ")
        .map(|(_, rest)| rest)
        .filter(|rest| !rest.contains(" for "))
        .and_then(|rest| rest.split_once('<'));
    let name = match of_trait.or(elsewhere) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lose_what_does_not_tell_functions_apart() {
        for (name, expected) in [
            ("spindle_bearing::a::b::State<T,_>::step", "State::step"),
            (
                "spindle_bearing::a::c::<impl spindle_bearing::a::b::State<T,_>>::step",
                "State::step",
            ),
            (
                "<spindle_bearing::a::Full<A> as spindle_bearing::a::Motion>::cold",
                "Full::cold",
            ),
            (
                "spindle_bearing::a::Ball<T>::place::{{closure}}::h0123456789abcdef",
                "Ball::place",
            ),
        ] {
            assert_eq!(short(&plain(name)), expected);
        }
    }

    #[test]
    fn what_helpers_cost_is_their_callers() {
        for (name, counted) in [
            ("spindle_bearing::float::Real::abs", false),
            ("spindle_bearing::a::linalg::dot", false),
            ("spindle_bearing::a::linalg::Factors::of", true),
            ("spindle_bearing::a::Ball::place", true),
            ("core::iter::next", false),
        ] {
            assert_eq!(is_counted(name), counted, "{name}");
        }
    }
}
