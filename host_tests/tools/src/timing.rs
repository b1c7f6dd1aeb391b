//! Cycles of the modelled cores: every number of the model is in this file.
//!
//! *Modelled* means instruction counts turned into cycles by published timings, without wait states
//! of the flash memory and without interrupts: good to about 15 %, and not calibrated on silicon.
//!
//! Cortex-M4F, from the instruction tables of Arm's "Cortex-M4 Technical Reference Manual" (r0p1,
//! sections 3.3 and 7.2.3): costs by instruction; loads and stores in a row overlap; the result of an FPU
//! operation that the next instruction uses costs one cycle more; a taken branch refills the
//! pipeline, which takes one to three cycles.
//!
//! Cortex-M7, for which Arm publishes no such table: two instructions a cycle in order as far as
//! operands and units allow, with the latencies and units of LLVM's scheduling model
//! (`llvm/lib/Target/ARM/ARMScheduleM7.td`, contributed with Arm's numbers). Branches count as predicted,
//! memory as tightly coupled.

use clap::ValueEnum;

/// A core to model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, ValueEnum)]
pub enum Core {
    /// Cortex-M4F: singles in hardware, doubles in software
    M4f,
    /// Cortex-M7 with the FPU for doubles
    M7,
}

impl Core {
    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::M4f => "Cortex-M4F",
            Self::M7 => "Cortex-M7",
        }
    }

    /// What rustc calls it.
    pub const fn processor(self) -> &'static str {
        match self {
            Self::M4f => "cortex-m4",
            Self::M7 => "cortex-m7",
        }
    }
}

/// Kinds of instructions that cost the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Class {
    /// FPU: sums, comparisons, conversions, signs.
    FpAdd,
    /// FPU: products.
    FpMul,
    /// FPU: products that are added.
    FpMac,
    /// FPU: quotients.
    FpDiv,
    /// FPU: square roots.
    FpSqrt,
    /// FPU: moves between registers, constants, flags.
    FpMove,
    /// FPU: a load.
    FpLoad,
    /// FPU: a store.
    FpStore,
    /// FPU: several registers from or to memory.
    FpMultiple,
    /// A load.
    Load,
    /// A store at a fixed offset.
    Store,
    /// A store at an offset in a register.
    StoreIndexed,
    /// Several registers from or to memory.
    Multiple,
    /// Integer arithmetic and moves.
    Integer,
    /// Integer products that are added.
    IntegerMac,
    /// Integer quotients.
    IntegerDiv,
    /// Branches and calls.
    Branch,
}

impl Class {
    /// All of them, in the order of tables.
    pub const ALL: [Self; 17] = [
        Self::FpAdd,
        Self::FpMul,
        Self::FpMac,
        Self::FpDiv,
        Self::FpSqrt,
        Self::FpMove,
        Self::FpLoad,
        Self::FpStore,
        Self::FpMultiple,
        Self::Load,
        Self::Store,
        Self::StoreIndexed,
        Self::Multiple,
        Self::Integer,
        Self::IntegerMac,
        Self::IntegerDiv,
        Self::Branch,
    ];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FpAdd => "vadd, vsub, vcmp, vcvt, vneg, vabs",
            Self::FpMul => "vmul",
            Self::FpMac => "vmla, vfma",
            Self::FpDiv => "vdiv",
            Self::FpSqrt => "vsqrt",
            Self::FpMove => "vmov, vmrs",
            Self::FpLoad => "vldr",
            Self::FpStore => "vstr",
            Self::FpMultiple => "vldm, vstm, vpush, vpop",
            Self::Load => "ldr",
            Self::Store => "str",
            Self::StoreIndexed => "str, indexed",
            Self::Multiple => "ldm, stm, ldrd, strd, push, pop",
            Self::Integer => "integer",
            Self::IntegerMac => "mla",
            Self::IntegerDiv => "sdiv, udiv",
            Self::Branch => "branch, call",
        }
    }

    const fn is_single_access(self) -> bool {
        matches!(
            self,
            Self::FpLoad | Self::FpStore | Self::Load | Self::Store | Self::StoreIndexed
        )
    }

    const fn is_fp_arithmetic(self) -> bool {
        matches!(
            self,
            Self::FpAdd | Self::FpMul | Self::FpMac | Self::FpDiv | Self::FpSqrt
        )
    }
}

/// An instruction, as far as its timing goes.
#[derive(Debug, Clone, Copy)]
pub struct Timed {
    /// Its class.
    pub class: Class,
    /// Registers that it moves from or to memory, in words.
    pub words: u32,
    /// It works on doubles.
    pub double: bool,
    /// Registers that it reads and writes: r0 to r15, the flags, the FPU's flags, and from bit 32
    /// on s0 to s31.
    pub reads: u64,
    /// See there.
    pub writes: u64,
}

/// Cycles that a taken branch costs more than one that is not.
pub const fn taken(core: Core) -> u32 {
    match core {
        // One to three.
        Core::M4f => 2,
        Core::M7 => 1,
    }
}

/// Cycles of every instruction of a block without branches into or out of it.
pub fn cycles(core: Core, block: &[Timed]) -> Vec<u32> {
    match core {
        Core::M4f => in_turn(block),
        Core::M7 => paired(block),
    }
}

/// The Cortex-M4F: one after the other.
fn in_turn(block: &[Timed]) -> Vec<u32> {
    let mut last: Option<&Timed> = None;
    let mut all = Vec::with_capacity(block.len());
    for op in block {
        let behind_access = last.is_some_and(|l| l.class.is_single_access());
        let cycles = match op.class {
            Class::FpAdd | Class::FpMul | Class::FpMove => 1,
            Class::FpMac => 3,
            Class::FpDiv | Class::FpSqrt => 14,
            Class::FpLoad | Class::FpStore | Class::Load | Class::StoreIndexed => {
                op.words + u32::from(!behind_access)
            }
            Class::Store => 1,
            Class::FpMultiple | Class::Multiple => 1 + op.words,
            Class::Integer => 1,
            Class::IntegerMac => 2,
            // 2 to 12.
            Class::IntegerDiv => 7,
            Class::Branch => 1,
        };
        let waits = last.is_some_and(|l| l.class.is_fp_arithmetic() && l.writes & op.reads != 0);
        all.push(cycles + u32::from(waits));
        last = Some(op);
    }
    all
}

/// The Cortex-M7: two at a time, as far as operands and units allow. An instruction's cycles are those
/// by which it moves the end of what has issued; of a pair the second has none.
fn paired(block: &[Timed]) -> Vec<u32> {
    // When each register can be read, and from when each unit is free.
    let mut ready = [0_u32; 64];
    let (mut fpu, mut divider, mut store, mut mac) = (0, 0, 0, 0);
    let mut ports: Vec<(u32, u32)> = Vec::new();
    let mut loads: Vec<(u32, u32)> = Vec::new();
    let mut at = 0;
    let mut slots = 0;
    let mut all = Vec::with_capacity(block.len());
    for op in block {
        let double = op.double;
        // (latency of the result, cycles for which the unit takes no other)
        let (latency, busy) = match (op.class, double) {
            (Class::FpAdd, false) | (Class::FpMul, false) => (3, 1),
            (Class::FpAdd, true) => (4, 2),
            (Class::FpMul, true) => (7, 5),
            (Class::FpMac, false) => (6, 1),
            (Class::FpMac, true) => (11, 6),
            (Class::FpDiv | Class::FpSqrt, false) => (16, 14),
            (Class::FpDiv | Class::FpSqrt, true) => (30, 28),
            (Class::FpMove, _) => (3, 1),
            (Class::FpLoad, false) => (1, 1),
            (Class::FpLoad, true) => (2, 1),
            (Class::Load, _) => (2, 1),
            (Class::FpMultiple | Class::Multiple, _) => (1, op.words.div_ceil(2)),
            (Class::IntegerMac, _) => (2, 1),
            (Class::IntegerDiv, _) => (7, 7),
            _ => (1, 1),
        };
        let is_fp = matches!(
            op.class,
            Class::FpAdd
                | Class::FpMul
                | Class::FpMac
                | Class::FpDiv
                | Class::FpSqrt
                | Class::FpMove
                | Class::FpLoad
                | Class::FpStore
        );
        let alone = matches!(
            op.class,
            Class::FpMultiple | Class::Multiple | Class::IntegerDiv
        ) || double && matches!(op.class, Class::FpLoad | Class::FpStore);
        let mut start = at;
        for (register, ready) in ready.iter().enumerate() {
            if op.reads >> register & 1 != 0 {
                // The value of a store is needed late.
                let early = match op.class {
                    Class::FpStore if register >= 32 => 2,
                    Class::Store | Class::StoreIndexed => 1,
                    Class::FpMac => 0,
                    _ => 0,
                };
                start = start.max(ready.saturating_sub(early));
            }
        }
        match op.class {
            Class::FpAdd | Class::FpMul | Class::FpMac => start = start.max(fpu),
            Class::FpDiv | Class::FpSqrt => start = start.max(fpu).max(divider),
            Class::FpStore | Class::Store | Class::StoreIndexed => start = start.max(store),
            Class::IntegerMac => start = start.max(mac),
            _ => {}
        }
        // Two issue slots, two ports to the FPU's registers, two loads.
        loop {
            let used = |of: &[(u32, u32)]| {
                of.iter()
                    .filter(|(t, _)| *t == start)
                    .map(|(_, n)| n)
                    .sum::<u32>()
            };
            let here = if start == at { slots } else { 0 };
            let port = if is_fp { 1 + u32::from(double) } else { 0 };
            let load = u32::from(matches!(op.class, Class::Load | Class::FpLoad));
            let fits = here < 2
                && !(alone && here > 0)
                && used(&ports) + port <= 2
                && used(&loads) + load <= 2;
            if fits {
                ports.push((start, port));
                loads.push((start, load));
                break;
            }
            start += 1;
        }
        match op.class {
            Class::FpAdd | Class::FpMul | Class::FpMac => fpu = start + busy,
            // What is independent of a quotient goes on while it is worked out.
            Class::FpDiv | Class::FpSqrt => {
                fpu = start + 1;
                divider = start + busy;
            }
            Class::FpStore | Class::Store | Class::StoreIndexed => store = start + 1,
            Class::IntegerMac => mac = start + 1,
            _ => {}
        }
        for (register, ready) in ready.iter_mut().enumerate() {
            if op.writes >> register & 1 != 0 {
                *ready = start + latency;
            }
        }
        let before = if slots == 0 { at } else { at + 1 };
        slots = if start == at { slots + 1 } else { 1 };
        at = start;
        if alone {
            at += busy - 1;
            slots = 2;
        }
        all.push((at + 1).saturating_sub(before));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An instruction on singles: its class, what it reads and what it writes.
    fn op(class: Class, reads: u64, writes: u64) -> Timed {
        Timed {
            class,
            words: 1,
            double: false,
            reads,
            writes,
        }
    }

    const S0: u64 = 1 << 32;
    const S1: u64 = 1 << 33;
    const R0: u64 = 1;

    #[test]
    fn loads_in_a_row_overlap() {
        let load = op(Class::FpLoad, R0, S0);
        assert_eq!(cycles(Core::M4f, &[load; 4]), [2, 1, 1, 1]);
    }

    #[test]
    fn a_result_that_is_used_at_once_is_waited_for() {
        let product = op(Class::FpMul, S0, S1);
        let sum = op(Class::FpAdd, S1, S1);
        let other = op(Class::FpAdd, S0, S0);
        assert_eq!(cycles(Core::M4f, &[product, sum]), [1, 2]);
        assert_eq!(cycles(Core::M4f, &[product, other, sum]), [1, 1, 1]);
        assert_eq!(cycles(Core::M7, &[product, sum]), [1, 3]);
    }

    #[test]
    fn several_registers_cost_one_more_than_their_number() {
        let mut push = op(Class::FpMultiple, R0, 0);
        push.words = 8;
        assert_eq!(cycles(Core::M4f, &[push]), [9]);
    }

    #[test]
    fn the_larger_core_issues_two_at_a_time_where_nothing_stands_against_it() {
        let independent = [
            op(Class::Integer, 1 << 1, 1 << 2),
            op(Class::Integer, 1 << 3, 1 << 4),
        ];
        assert_eq!(cycles(Core::M7, &independent), [1, 0]);
        let dependent = [
            op(Class::Integer, 1 << 1, 1 << 2),
            op(Class::Integer, 1 << 2, 1 << 4),
        ];
        assert_eq!(cycles(Core::M7, &dependent), [1, 1]);
    }
}
