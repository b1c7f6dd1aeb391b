//! Flash and memory that a solver takes.

use crate::bench::Bench;
use anyhow::Result;
use tools::graph::Graph;

/// Bytes.
pub struct Memory {
    /// Code and constants that a solve reaches, by symbol, the largest first.
    pub symbols: Vec<(u64, String)>,
    /// The solver.
    pub state: u32,
    /// The bearing's constants, which may lie in flash.
    pub constants: u32,
}

impl Memory {
    /// Of the program on a bench.
    pub fn of(bench: &Bench) -> Result<Self> {
        let graph = Graph::read(&bench.image.elf)?;
        let size = |wanted: &str| -> u64 {
            let reach = graph.reach(|name| name == wanted);
            let own = reach.symbols().filter(|(.., name)| *name == wanted);
            own.map(|(_, size, _)| size).sum()
        };
        // What copies question and answer is not the solver's.
        let around = size("measured_nothing");
        let reach = graph.reach(|name| name == "measured_solve");
        let mut symbols: Vec<(u64, String)> = reach
            .symbols()
            .filter(|(at, size, _)| *size > 0 && *at < 0x2000_0000)
            .map(|(_, size, name)| match name {
                "measured_solve" => (size.saturating_sub(around), name.to_owned()),
                _ => (size, name.to_owned()),
            })
            .collect();
        symbols.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
        let [state, constants] = bench.sizes()?;
        Ok(Self {
            symbols,
            state,
            constants,
        })
    }

    /// All of the flash.
    pub fn flash(&self) -> u64 {
        self.symbols.iter().map(|(size, _)| size).sum()
    }
}
