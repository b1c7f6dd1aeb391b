//! Cycles of the modelled cores: every number of the model is in this file.
//!
//! *Modelled* means instruction counts turned into cycles by published timings, without wait states
//! of the flash memory and without interrupts. It is good to about 15 %, and not calibrated on silicon.
//!
//! Cortex-M4F, from the instruction tables of Arm's "Cortex-M4 Technical Reference Manual" (r0p1,
//! sections 3.3 and 7.2.3): costs by instruction. Loads and stores in a row overlap. The result of an FPU
//! operation that the next instruction uses costs one cycle more. A taken branch refills the
//! pipeline, which takes one to three cycles.
//!
//! Cortex-M7, for which Arm publishes no such table: two instructions a cycle in order as far as
//! operands and units allow. Latencies and units are from LLVM's scheduling model
//! (`llvm/lib/Target/ARM/ARMScheduleM7.td`, contributed with Arm's numbers). Branches count as predicted,
//! memory as tightly coupled.

/// A core to model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Core {
    /// Cortex-M4F: singles in hardware, doubles in software.
    M4f,
    /// Cortex-M7 with the FPU for doubles.
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

    /// The processor to compile for, where it is not the one of the project's configuration.
    pub const fn processor(self) -> Option<&'static str> {
        match self {
            Self::M4f => None,
            Self::M7 => Some("cortex-m7"),
        }
    }

    /// Cycles that a taken branch costs more than one that is not.
    pub const fn taken(self) -> u64 {
        match self {
            // One to three.
            Self::M4f => 2,
            Self::M7 => 1,
        }
    }

    /// Cycles of a block without branches into or out of it.
    pub fn cycles(self, block: &[Timed]) -> u64 {
        match self {
            Self::M4f => in_turn(block).into(),
            Self::M7 => paired(block).into(),
        }
    }
}

/// Kinds of instructions that cost the same; `decode.rs` has their names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    FpAdd,
    FpMul,
    FpMac,
    FpDiv,
    FpSqrt,
    FpMove,
    FpLoad,
    FpStore,
    FpMultiple,
    Load,
    Store,
    StoreIndexed,
    Multiple,
    /// Branches, too.
    Integer,
    IntegerMac,
    IntegerDiv,
}

impl Class {
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
    /// Registers that it reads, a bit each: r0 to r15, the flags, the FPU's flags, and from bit 32
    /// on s0 to s31.
    pub reads: u64,
    /// Registers that it writes, by the same bits.
    pub writes: u64,
}

/// The Cortex-M4F: one instruction after the other.
fn in_turn(block: &[Timed]) -> u32 {
    let mut last: Option<&Timed> = None;
    let mut sum = 0;
    for op in block {
        let behind_access = last.is_some_and(|l| l.class.is_single_access());
        let waits = last.is_some_and(|l| l.class.is_fp_arithmetic() && l.writes & op.reads != 0);
        sum += u32::from(waits);
        sum += match op.class {
            Class::FpAdd | Class::FpMul | Class::FpMove => 1,
            Class::Store | Class::Integer => 1,
            Class::FpMac => 3,
            Class::FpDiv | Class::FpSqrt => 14,
            Class::FpLoad | Class::FpStore | Class::Load | Class::StoreIndexed => {
                op.words + u32::from(!behind_access)
            }
            Class::FpMultiple | Class::Multiple => 1 + op.words,
            Class::IntegerMac => 2,
            // 2 to 12.
            Class::IntegerDiv => 7,
        };
        last = Some(op);
    }
    sum
}

/// Latency of an instruction's result on the Cortex-M7, and cycles for which its unit takes no other instruction.
const fn latency(op: &Timed) -> (u32, u32) {
    match (op.class, op.double) {
        (Class::FpAdd | Class::FpMul, false) => (3, 1),
        (Class::FpAdd, true) => (4, 2),
        (Class::FpMul, true) => (7, 5),
        (Class::FpMac, false) => (6, 1),
        (Class::FpMac, true) => (11, 6),
        (Class::FpDiv | Class::FpSqrt, false) => (16, 14),
        (Class::FpDiv | Class::FpSqrt, true) => (30, 28),
        (Class::FpMove, _) => (3, 1),
        (Class::FpLoad, true) | (Class::Load | Class::IntegerMac, _) => (2, 1),
        (Class::FpMultiple | Class::Multiple, _) => (1, op.words.div_ceil(2)),
        (Class::IntegerDiv, _) => (7, 7),
        _ => (1, 1),
    }
}

/// The Cortex-M7: two instructions at a time, as far as operands and units allow.
fn paired(block: &[Timed]) -> u32 {
    // When each register can be read, and from when each unit is free.
    let mut ready = [0_u32; 64];
    let (mut fpu, mut divider, mut store, mut mac) = (0, 0, 0, 0);
    // The cycle of the last issue; slots, ports to the FPU's registers and loads that are taken in it.
    let (mut at, mut slots, mut ports, mut loads) = (0, 0, 0, 0);
    for op in block {
        let (latency, busy) = latency(op);
        let accesses_fpu = matches!(op.class, Class::FpLoad | Class::FpStore);
        let alone = matches!(
            op.class,
            Class::FpMultiple | Class::Multiple | Class::IntegerDiv
        ) || op.double && accesses_fpu;
        let on_fpu = accesses_fpu || op.class.is_fp_arithmetic() || op.class == Class::FpMove;
        let port = u32::from(on_fpu) * (1 + u32::from(op.double));
        let load = u32::from(matches!(op.class, Class::Load | Class::FpLoad));
        let mut start = at;
        for (register, ready) in ready.iter().enumerate() {
            if op.reads >> register & 1 != 0 {
                // The value of a store is needed late.
                let late = match op.class {
                    Class::FpStore if register >= 32 => 2,
                    Class::Store | Class::StoreIndexed => 1,
                    _ => 0,
                };
                start = start.max(ready.saturating_sub(late));
            }
        }
        start = start.max(match op.class {
            Class::FpAdd | Class::FpMul | Class::FpMac => fpu,
            Class::FpDiv | Class::FpSqrt => fpu.max(divider),
            Class::FpStore | Class::Store | Class::StoreIndexed => store,
            Class::IntegerMac => mac,
            _ => 0,
        });
        let fits = slots < 2 && !(alone && slots > 0) && ports + port <= 2 && loads + load <= 2;
        if start == at && !fits {
            start += 1;
        }
        if start > at {
            (slots, ports, loads) = (0, 0, 0);
        }
        match op.class {
            Class::FpAdd | Class::FpMul | Class::FpMac => fpu = start + busy,
            // Instructions that are independent of a quotient go on meanwhile.
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
        (at, slots, ports, loads) = (start, slots + 1, ports + port, loads + load);
        if alone {
            at += busy - 1;
            slots = 2;
        }
    }
    if block.is_empty() { 0 } else { at + 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An instruction on singles: its class, and the registers that it reads and writes.
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
        assert_eq!(Core::M4f.cycles(&[load; 4]), 2 + 1 + 1 + 1);
    }

    #[test]
    fn a_result_that_is_used_at_once_is_waited_for() {
        let product = op(Class::FpMul, S0, S1);
        let sum = op(Class::FpAdd, S1, S1);
        let other = op(Class::FpAdd, S0, S0);
        assert_eq!(Core::M4f.cycles(&[product, sum]), 1 + 2);
        assert_eq!(Core::M4f.cycles(&[product, other, sum]), 1 + 1 + 1);
        assert_eq!(Core::M7.cycles(&[product, sum]), 1 + 3);
    }

    #[test]
    fn several_registers_cost_one_more_than_their_number() {
        let mut push = op(Class::FpMultiple, R0, 0);
        push.words = 8;
        assert_eq!(Core::M4f.cycles(&[push]), 9);
    }

    #[test]
    fn the_larger_core_issues_two_independent_instructions_at_a_time() {
        let integer = |reads: u64, writes: u64| op(Class::Integer, 1 << reads, 1 << writes);
        assert_eq!(Core::M7.cycles(&[integer(1, 2), integer(3, 4)]), 1);
        assert_eq!(Core::M7.cycles(&[integer(1, 2), integer(2, 4)]), 2);
    }
}
