//! Who calls whom in a linked program, read from the relocations that `--emit-relocs` keeps.
//!
//! A relocation is where one symbol mentions another: a call, a jump, or an address taken. So everything that can run
//! is reachable here, except functions whose address comes from outside.

use crate::frame::Frame;
use anyhow::{Context, Result, bail};
use object::{
    Object, ObjectSection, ObjectSymbol, RelocationFlags, RelocationTarget, SectionFlags,
    SectionIndex, SectionKind, SymbolKind, elf,
};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Symbols by their addresses, and the addresses that each of them mentions.
#[derive(Debug, Default)]
pub struct Graph {
    symbols: BTreeMap<u64, Symbol>,
}

#[derive(Debug, Default)]
struct Symbol {
    name: String,
    size: u64,
    /// Addresses that it mentions, and the place of their first mention.
    mentions: BTreeMap<u64, u64>,
    /// Those that it calls, or jumps to.
    calls: BTreeSet<u64>,
    /// Those of functions that it hands on.
    pointers: BTreeSet<u64>,
    /// Bytes of stack of one that is code.
    frame: Option<Frame>,
}

impl Graph {
    /// Reads a program linked with `--emit-relocs`.
    pub fn read(elf: &[u8]) -> Result<Self> {
        let file = object::File::parse(elf)?;
        let loaded: Vec<_> = file
            .sections()
            .filter(|section| {
                matches!(section.flags(), SectionFlags::Elf { sh_flags }
                    if sh_flags & u64::from(elf::SHF_ALLOC) != 0)
            })
            .collect();
        let is_loaded = |index: Option<SectionIndex>| {
            index.is_some_and(|index| loaded.iter().any(|s| s.index() == index))
        };
        // A Thumb function's address is odd.
        let even = |address: u64| address & !1;

        let mut graph = Self::default();
        let mut marks = BTreeMap::new();
        for symbol in file.symbols() {
            let name = symbol.name()?;
            if !is_loaded(symbol.section_index()) {
                continue;
            }
            // `$t` and the like tell code from data.
            if name.starts_with('$') {
                marks.insert(symbol.address(), name.starts_with("$t"));
            } else if !name.is_empty() && symbol.kind() != SymbolKind::Section {
                graph.add(even(symbol.address()), symbol.size(), name);
            }
        }
        for section in loaded.iter().filter(|of| of.kind() == SectionKind::Text) {
            graph.read_frames(section.address(), section.data()?, &marks)?;
        }
        let mut relocations = 0;
        for section in &loaded {
            let data = section.data()?;
            for (address, relocation) in section.relocations() {
                let RelocationFlags::Elf { r_type } = relocation.flags() else {
                    bail!("not an ELF file");
                };
                let RelocationTarget::Symbol(index) = relocation.target() else {
                    continue;
                };
                let target = file.symbol_by_index(index)?;
                if r_type == elf::R_ARM_NONE || !is_loaded(target.section_index()) {
                    continue;
                }
                relocations += 1;
                let is_call = matches!(
                    r_type,
                    elf::R_ARM_THM_PC22 | elf::R_ARM_THM_JUMP24 | elf::R_ARM_THM_JUMP19
                );
                let to = if target.kind() != SymbolKind::Section {
                    target.address()
                } else if r_type == elf::R_ARM_ABS32 {
                    let offset = (address - section.address()) as usize;
                    let word = data.get(offset..).and_then(<[u8]>::first_chunk);
                    u32::from_le_bytes(*word.context("a relocation outside its section")?).into()
                } else {
                    bail!("the relocation at {address:#x} is of a kind ({r_type}) not known here");
                };
                graph.mention(address, even(to), is_call)?;
            }
        }
        if relocations == 0 {
            bail!("the program was linked without --emit-relocs");
        }
        Ok(graph)
    }

    /// Adds a symbol. Of several at one address the longest gives the name.
    fn add(&mut self, address: u64, size: u64, name: &str) {
        let symbol = self.symbols.entry(address).or_default();
        if symbol.name.is_empty() || size > symbol.size {
            symbol.size = size;
            symbol.name = format!("{:#}", rustc_demangle::demangle(name));
        }
    }

    /// The last symbol that starts at or before an address.
    fn at(&self, address: u64) -> Option<u64> {
        let (start, _) = self.symbols.range(..=address).next_back()?;
        Some(*start)
    }

    fn mention(&mut self, from: u64, to: u64, is_call: bool) -> Result<()> {
        let (symbol, target) = self
            .at(from)
            .zip(self.at(to))
            .context("code without a symbol")?;
        let is_function = target == to && self.symbols[&target].frame.is_some();
        let symbol = self.symbols.entry(symbol).or_default();
        symbol.mentions.entry(target).or_insert(from);
        if is_call {
            symbol.calls.insert(target);
        } else if is_function {
            symbol.pointers.insert(target);
        }
        Ok(())
    }

    /// Reads the frames of the functions in a section of code.
    fn read_frames(&mut self, from: u64, code: &[u8], marks: &BTreeMap<u64, bool>) -> Result<()> {
        for (at, symbol) in self.symbols.range_mut(from..from + code.len() as u64) {
            let mut frame = Frame::default();
            let (mut place, end) = (*at, at + symbol.size);
            while place < end {
                let is_code = marks.range(..=place).next_back().is_none_or(|(_, is)| *is);
                let next = marks
                    .range(place + 1..end)
                    .next()
                    .map_or(end, |(at, _)| *at);
                let part = (place - from) as usize..(next - from) as usize;
                if is_code {
                    frame.add(code.get(part).context("a function outside its section")?);
                }
                place = next;
            }
            symbol.frame = Some(frame);
        }
        Ok(())
    }

    /// Stack that the program takes at most, on the longest way of calls from its reset.
    ///
    /// An interrupt comes at its end. A call by pointer may lead to any function whose address is taken, but to none of them twice. Interrupts have one priority.
    ///
    /// # Errors
    ///
    /// There is no reset; a function's frame is not known.
    pub fn stack(&self) -> Result<Way<'_>> {
        let unknown = |of: &&Symbol| of.frame.is_some_and(|frame| frame.is_unknown);
        if let Some(Symbol { name, .. }) = self.symbols.values().find(unknown) {
            bail!("`{name}` takes stack by a number that is not known before it runs");
        }
        let is_vector = |symbol: &&Symbol| {
            ["__RESET_VECTOR", "__EXCEPTIONS", "__INTERRUPTS"].contains(&&*symbol.name)
        };
        let pointed: BTreeSet<u64> = self
            .symbols
            .values()
            .filter(|symbol| !is_vector(symbol))
            .flat_map(|symbol| symbol.pointers.iter().copied())
            .collect();
        let mut direct = Walk::new(self, 0);
        let (mut passed_on, mut last) = (0, 0);
        for at in pointed {
            let bytes = direct.below(at).0;
            if self.calls_by_pointer(at) {
                passed_on += bytes;
            } else {
                last = last.max(bytes);
            }
        }
        let mut walk = Walk::new(self, passed_on + last);
        let handlers = self.symbols.values().filter(is_vector);
        let handlers = handlers.flat_map(|vector| &vector.pointers);
        let reset = self.symbols.iter().find(|(_, of)| of.name == "Reset");
        let (reset, _) = reset.context("there is no reset: this is no firmware")?;
        let handlers = handlers.filter(|at| *at != reset);
        let handler = handlers.map(|at| walk.below(*at).0).max().unwrap_or(0);
        let (bytes, names) = walk.below(*reset);
        Ok(Way {
            bytes: bytes + EXCEPTION + handler,
            names,
        })
    }

    /// Whether a function, or one that it calls, calls by pointer.
    fn calls_by_pointer(&self, at: u64) -> bool {
        let (mut seen, mut queue) = (BTreeSet::from([at]), vec![at]);
        while let Some(at) = queue.pop() {
            let symbol = &self.symbols[&at];
            if symbol.frame.is_some_and(|frame| frame.calls_by_pointer) {
                return true;
            }
            queue.extend(symbol.calls.iter().filter(|to| seen.insert(**to)));
        }
        false
    }

    /// Symbols reachable from the roots that `is_root` picks by their names.
    pub fn reach(&self, is_root: impl Fn(&str) -> bool) -> Reach<'_> {
        let roots = self.symbols.iter().filter(|(_, s)| is_root(&s.name));
        let mut before: BTreeMap<_, _> = roots.map(|(at, _)| (*at, None)).collect();
        let mut queue: VecDeque<u64> = before.keys().copied().collect();
        let mut order = Vec::new();
        while let Some(from) = queue.pop_front() {
            order.push(from);
            for (to, place) in &self.symbols[&from].mentions {
                before.entry(*to).or_insert_with(|| {
                    queue.push_back(*to);
                    Some((from, *place))
                });
            }
        }
        Reach {
            graph: self,
            before,
            order,
        }
    }
}

/// Bytes that the core puts on the stack for an interrupt: 26 registers with those of the FPU, and four to align it.
const EXCEPTION: u64 = 4 * 26 + 4;

/// Longest ways of calls.
struct Walk<'g> {
    graph: &'g Graph,
    /// Stack below a call by pointer.
    by_pointer: u64,
    known: BTreeMap<u64, (u64, Vec<&'g str>)>,
    /// Functions on the way to where it is.
    way: Vec<u64>,
}

impl<'g> Walk<'g> {
    const fn new(graph: &'g Graph, by_pointer: u64) -> Self {
        Self {
            graph,
            by_pointer,
            known: BTreeMap::new(),
            way: Vec::new(),
        }
    }

    /// Bytes from this function on, and the functions on the longest way.
    fn below(&mut self, at: u64) -> (u64, Vec<&'g str>) {
        self.walk(at).0
    }

    /// Also how far up the way it was cut short, at a function that is on it already: a panic in the log, which is told
    /// of once.
    fn walk(&mut self, at: u64) -> ((u64, Vec<&'g str>), usize) {
        if let Some(known) = self.known.get(&at) {
            return (known.clone(), usize::MAX);
        }
        if let Some(above) = self.way.iter().position(|on_way| *on_way == at) {
            return (<_>::default(), above);
        }
        let here = self.way.len();
        self.way.push(at);
        let symbol = &self.graph.symbols[&at];
        let frame = symbol.frame.unwrap_or_default();
        let mut deepest = (0, Vec::new());
        if frame.calls_by_pointer {
            deepest = (self.by_pointer, vec!["a call by pointer"]);
        }
        let mut cut = usize::MAX;
        for to in &symbol.calls {
            let (below, above) = self.walk(*to);
            cut = cut.min(above);
            if below.0 > deepest.0 {
                deepest = below;
            }
        }
        self.way.pop();
        deepest.0 += frame.bytes;
        deepest.1.insert(0, &symbol.name);
        // One that was cut short is as long as this only behind that function.
        if cut >= here {
            self.known.insert(at, deepest.clone());
            cut = usize::MAX;
        }
        (deepest, cut)
    }
}

/// A way of calls.
#[derive(Debug, PartialEq, Eq)]
pub struct Way<'g> {
    /// Bytes of stack that it takes.
    pub bytes: u64,
    /// Functions on it.
    pub names: Vec<&'g str>,
}

/// Symbols reachable from some roots, the nearest first.
pub struct Reach<'g> {
    graph: &'g Graph,
    /// The symbol by which each was reached, and the place in it; none for roots.
    before: BTreeMap<u64, Option<(u64, u64)>>,
    order: Vec<u64>,
}

impl Reach<'_> {
    /// Names of the reachable symbols.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.order.iter().map(|at| &*self.graph.symbols[at].name)
    }

    /// Address, size in bytes and name of each reachable symbol.
    pub fn symbols(&self) -> impl Iterator<Item = (u64, u64, &str)> {
        self.order.iter().map(|at| {
            let symbol = &self.graph.symbols[at];
            (*at, symbol.size, &*symbol.name)
        })
    }

    /// The shortest way to the nearest symbol whose name is `wanted`, from a root on.
    pub fn path(&self, wanted: impl Fn(&str) -> bool) -> Option<Path<'_>> {
        let wanted = |at: &&u64| wanted(&self.graph.symbols[at].name);
        let end = *self.order.iter().find(wanted)?;
        let before = |at: &u64| self.before.get(at).copied().flatten();
        let mut names: Vec<_> =
            std::iter::successors(Some(end), |at| before(at).map(|(from, _)| from))
                .map(|at| &*self.graph.symbols[&at].name)
                .collect();
        names.reverse();
        Some(Path {
            names,
            last: before(&end).map(|(_, place)| place),
        })
    }
}

/// A way through the program.
#[derive(Debug, PartialEq, Eq)]
pub struct Path<'g> {
    /// The symbols on it.
    pub names: Vec<&'g str>,
    /// Where the last but one mentions the last.
    pub last: Option<u64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Symbols of 16 bytes each, by number, and who mentions whom.
    fn graph(names: &[&str], mentions: &[(u64, u64)]) -> Graph {
        let mut graph = Graph::default();
        for (i, name) in names.iter().enumerate() {
            graph.add(16 * i as u64, 16, name);
        }
        for (from, to) in mentions {
            graph.mention(16 * from + 6, 16 * to, true).unwrap();
        }
        graph
    }

    #[test]
    fn the_shortest_way_is_found_and_what_is_not_reachable_is_not() {
        let names = ["main", "solve", "step", "panic", "sqrtf"];
        let graph = graph(&names, &[(0, 1), (0, 3), (1, 2), (2, 1), (2, 3), (1, 4)]);
        let from = |root: &str| graph.reach(|name| name == root);
        let panic = |name: &str| name == "panic";
        let path = |root: &str| {
            let reach = from(root);
            let path = reach.path(panic)?;
            Some((path.names.join(" "), path.last))
        };
        assert_eq!(path("main"), Some(("main panic".into(), Some(6))));
        assert_eq!(path("solve"), Some(("solve step panic".into(), Some(38))));
        assert_eq!(path("panic"), Some(("panic".into(), None)));
        assert_eq!(path("sqrtf"), None);
        assert_eq!(from("nowhere").names().count(), 0);
        assert_eq!(from("step").names().count(), 4);
    }

    /// A main program of 100 B calls a solve of 1000 B, which calls by pointer one of 10 B and one of 30 B that does so, too; an
    /// interrupt takes 8 B. A panic in the log, which panics, is 200 B long.
    #[test]
    fn the_stack_is_that_of_the_longest_way_with_pointers_and_an_interrupt() {
        let names = [
            "Reset",
            "main",
            "solve",
            "first",
            "second",
            "log",
            "panic",
            "__INTERRUPTS",
            "timer",
        ];
        let mut graph = graph(&names, &[(0, 1), (1, 2), (1, 5), (5, 6), (6, 5)]);
        let frames = [0, 100, 1000, 10, 30, 50, 150, 0, 8];
        for ((symbol, bytes), i) in graph.symbols.values_mut().zip(frames).zip(0..) {
            symbol.frame = Some(Frame {
                bytes,
                calls_by_pointer: [2, 4].contains(&i),
                is_unknown: false,
            });
        }
        for (from, to) in [(1, 3), (2, 4), (7, 8)] {
            graph.mention(16 * from, 16 * to, false).unwrap();
        }
        let way = graph.stack().unwrap();
        assert_eq!(way.bytes, 100 + 1000 + 30 + 10 + 108 + 8);
        assert_eq!(way.names, ["Reset", "main", "solve", "a call by pointer"]);
        let at_log = 16 * 5;
        assert_eq!(Walk::new(&graph, 0).below(at_log).0, 200);
        // Never less, whatever was looked at before.
        let mut walk = Walk::new(&graph, 0);
        walk.below(16 * 6);
        assert!(walk.below(at_log).0 >= 200);
    }

    #[test]
    fn a_mangled_name_is_read_and_an_alias_yields_to_the_function() {
        let mut graph = Graph::default();
        graph.add(0, 0, "__stext");
        graph.add(0, 8, "_ZN4core9panicking9panic_fmt17h0123456789abcdefE");
        graph.add(0, 2, "short");
        let names: Vec<_> = graph.reach(|_| true).names().map(str::to_owned).collect();
        assert_eq!(names, ["core::panicking::panic_fmt"]);
    }
}
