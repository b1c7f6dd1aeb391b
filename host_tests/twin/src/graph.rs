//! Who calls whom in a linked program, read from the relocations that `--emit-relocs` keeps.
//!
//! A relocation is where one symbol mentions another: a call, a jump, or an address taken. So everything that can run
//! is reachable here, except functions whose address comes from outside.

use anyhow::{Context, Result, bail};
use object::{
    Object, ObjectSection, ObjectSymbol, RelocationFlags, RelocationTarget, SectionFlags,
    SectionIndex, SymbolKind, elf,
};
use std::collections::{BTreeMap, VecDeque};

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
        for symbol in file.symbols() {
            let name = symbol.name()?;
            // `$t` and the like tell code from data.
            let is_mark = name.is_empty() || name.starts_with('$');
            if !is_mark && symbol.kind() != SymbolKind::Section && is_loaded(symbol.section_index())
            {
                graph.add(even(symbol.address()), symbol.size(), name);
            }
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
                let to = if target.kind() != SymbolKind::Section {
                    target.address()
                } else if r_type == elf::R_ARM_ABS32 {
                    let offset = (address - section.address()) as usize;
                    let word = data.get(offset..).and_then(<[u8]>::first_chunk);
                    u32::from_le_bytes(*word.context("a relocation outside its section")?).into()
                } else {
                    bail!("the relocation at {address:#x} is of a kind ({r_type}) not known here");
                };
                graph.mention(address, even(to))?;
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

    fn mention(&mut self, from: u64, to: u64) -> Result<()> {
        let (symbol, to) = self
            .at(from)
            .zip(self.at(to))
            .context("code without a symbol")?;
        let mentions = &mut self.symbols.entry(symbol).or_default().mentions;
        mentions.entry(to).or_insert(from);
        Ok(())
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
            graph.mention(16 * from + 6, 16 * to).unwrap();
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
