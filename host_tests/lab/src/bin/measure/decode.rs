//! Instructions, as far as their timing goes.

use crate::capstone::{Capstone, Named};
use crate::timing::{Class, Timed};
use anyhow::{Context, Result, ensure};
use libloading::Library;

/// A disassembler that remembers nothing but its settings.
pub struct Decoder {
    capstone: Capstone,
}

/// The bit of a register, or bits of a pair, by its name.
fn bits(name: &str) -> u64 {
    let number = || name.get(1..).and_then(|n| n.parse::<u32>().ok());
    match name {
        "sb" => 1 << 9,
        "sl" => 1 << 10,
        "fp" => 1 << 11,
        "ip" => 1 << 12,
        "sp" => 1 << 13,
        "lr" => 1 << 14,
        "pc" => 1 << 15,
        "apsr" | "cpsr" | "apsr_nzcv" => 1 << 16,
        "fpscr" | "fpscr_nzcv" => 1 << 17,
        _ => match (name.as_bytes().first(), number()) {
            (Some(b'r'), Some(n)) if n < 16 => 1 << n,
            (Some(b's'), Some(n)) if n < 32 => 1 << (32 + n),
            (Some(b'd'), Some(n)) if n < 16 => 3 << (32 + 2 * n),
            _ => 0,
        },
    }
}

/// Bits of all registers in a text.
fn registers_in(text: &str) -> u64 {
    let names = text.split(|c: char| !c.is_alphanumeric() && c != '_');
    names.fold(0, |all, name| all | bits(name))
}

impl Decoder {
    /// One for Thumb as of an Armv7E-M.
    pub fn new(library: &'static Library) -> Result<Self> {
        let capstone = Capstone::new(library)?;
        Ok(Self { capstone })
    }

    /// Decodes a block.
    pub fn block(&self, code: &[u8], address: u32) -> Result<Vec<Timed>> {
        let instructions = self.capstone.block(code, address)?;
        let length: usize = instructions.iter().map(|i| i.size).sum();
        ensure!(
            length == code.len(),
            "the disassembler knows no instruction at {:#x}",
            address as usize + length
        );
        instructions.iter().map(timed).collect()
    }
}

fn timed(instruction: &Named) -> Result<Timed> {
    let mnemonic = instruction.mnemonic.as_str();
    let all = |names: &[String]| names.iter().fold(0, |all, name| all | bits(name));
    let (reads, writes) = (all(&instruction.reads), all(&instruction.writes));
    let (before, address) = instruction
        .operands
        .split_once('[')
        .unwrap_or((&instruction.operands, ""));
    let (address, behind) = address.split_once(']').unwrap_or((address, ""));
    let registers = registers_in(before) | registers_in(behind);
    let indexed = registers_in(address).count_ones() > 1;
    let class = class(mnemonic, indexed)
        .with_context(|| format!("no timing for `{mnemonic}`: add it to `CLASSES`"))?;
    let double = (registers >> 32).count_ones() > 1 && mnemonic.contains(".f64")
        || matches!(class, Class::FpLoad | Class::FpStore) && (registers >> 32).count_ones() == 2;
    let words = match class {
        Class::FpLoad | Class::FpStore => 1 + u32::from(double),
        Class::FpMultiple => (registers >> 32).count_ones(),
        Class::Multiple if mnemonic.starts_with("ldrd") || mnemonic.starts_with("strd") => 2,
        Class::Multiple => {
            let all = (registers & 0xFFFF).count_ones();
            // The address is one of them, but for push and pop.
            let address = mnemonic.starts_with("ldm") || mnemonic.starts_with("stm");
            all - u32::from(address)
        }
        _ => 1,
    };
    Ok(Timed {
        class,
        words,
        double,
        reads,
        writes,
    })
}

/// Beginnings of names, and the class; the first that fits counts.
#[rustfmt::skip]
const CLASSES: [(&[&str], Class); 14] = [
    (&["vadd", "vsub", "vcmp", "vcvt", "vneg", "vabs", "vsel", "vmaxnm", "vminnm", "vrint"], Class::FpAdd),
    (&["vmul", "vnmul"], Class::FpMul),
    (&["vmla", "vmls", "vfma", "vfms", "vnmla", "vnmls", "vfnma", "vfnms"], Class::FpMac),
    (&["vdiv"], Class::FpDiv),
    (&["vsqrt"], Class::FpSqrt),
    (&["vmov", "vmrs", "vmsr"], Class::FpMove),
    (&["vldr"], Class::FpLoad),
    (&["vstr"], Class::FpStore),
    (&["vldm", "vstm", "vpush", "vpop"], Class::FpMultiple),
    (&["ldm", "stm", "push", "pop", "ldrd", "strd"], Class::Multiple),
    (&["ldr"], Class::Load),
    (&["str"], Class::Store),
    (&["mla", "mls", "smla", "umla", "umaal"], Class::IntegerMac),
    (&["sdiv", "udiv"], Class::IntegerDiv),
];

/// The class of an instruction, by its name.
fn class(mnemonic: &str, indexed: bool) -> Option<Class> {
    let name = mnemonic.split('.').next().unwrap_or_default();
    let fits = |(names, _): &&(&[&str], Class)| names.iter().any(|start| name.starts_with(start));
    match CLASSES.iter().find(fits) {
        Some((_, Class::Store)) if indexed => Some(Class::StoreIndexed),
        Some((_, class)) => Some(*class),
        None if name.starts_with('v') => None,
        None => Some(Class::Integer),
    }
}
