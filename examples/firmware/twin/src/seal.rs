//! Writes two checksums into a linked firmware, for its self-checks: its image's, and the known answer's. The answer is
//! computed by this machine's build of the same source.

use anyhow::{Context, Result, bail, ensure};
use object::elf::PT_LOAD;
use object::read::elf::ProgramHeader;
use object::{Endianness, Object, ObjectSymbol};
use spindle_bearing::SpindleSolver;
use spindle_firmware::spindle::{KNOWN_LOAD, SPINDLE};
use spindle_monitor::self_check::{Checksum, KnownAnswer, Seal};

/// The symbol of the seal.
const SYMBOL: &str = "IMAGE_SEAL";

/// The checksum of the answer that is known.
fn answer() -> u32 {
    let mut solver = SpindleSolver::of();
    let mut known = KnownAnswer::new(&SPINDLE, KNOWN_LOAD, &mut solver);
    loop {
        if let Some(sum) = known.step() {
            return sum;
        }
    }
}

/// A firmware with its seal, of one without.
///
/// # Errors
///
/// It is no such firmware, or it has its seal already.
pub fn sealed(elf: &[u8]) -> Result<Vec<u8>> {
    let file = object::File::parse(elf).context("this is no ELF file")?;
    let object::File::Elf32(of) = &file else {
        bail!("this is no ELF file for a microcontroller");
    };
    let symbol = |name: &str| {
        let mut symbols = file.symbols();
        let symbol = symbols.find(|symbol| symbol.name() == Ok(name));
        symbol
            .map(|symbol| symbol.address())
            .with_context(|| format!("there is no {name}: this is no firmware of the monitor"))
    };
    // Where a byte of the flash is in the file.
    let place = |address: u64| {
        let end = Endianness::Little;
        let mut parts = of.elf_program_headers().iter();
        let place = parts.find_map(|part| {
            let from = u64::from(part.p_paddr(end));
            let within = address.checked_sub(from)?;
            let is_loaded = part.p_type(end) == PT_LOAD && within < part.p_filesz(end).into();
            is_loaded.then(|| (u64::from(part.p_offset(end)) + within) as usize)
        });
        place.with_context(|| format!("nothing is loaded at {address:#x}"))
    };
    let seal = symbol(SYMBOL)?;
    let length = size_of_val(&Seal::Damaged.words());
    let at = place(seal)?;
    let old = elf.get(at..at + length).context("the file is cut off")?;
    let mut words = [0; 4];
    for (word, bytes) in words.iter_mut().zip(old.chunks_exact(4)) {
        *word = u32::from_le_bytes(bytes.try_into()?);
    }
    let answer = match Seal::read(words) {
        Seal::Open => answer(),
        Seal::Closed { .. } | Seal::Damaged => bail!("it has a seal already"),
    };
    let mut sum = Checksum::default();
    let (data, end) = (symbol("__sdata")?, symbol("__edata")?);
    let initial = symbol("__sidata")?;
    for (from, to) in [
        (symbol("__vector_table")?, symbol("__etext")?),
        (symbol("__srodata")?, seal),
        (seal + length as u64, symbol("__erodata")?),
        (initial, initial + end.saturating_sub(data)),
    ] {
        ensure!(from <= to, "its parts are not where they should be");
        for address in from..to {
            let byte = elf.get(place(address)?).context("the file is cut off")?;
            sum.add(std::slice::from_ref(byte));
        }
    }
    let image = sum.finish();
    let mut bytes = elf.to_vec();
    let new = Seal::Closed { image, answer }.words();
    for (to, word) in bytes[at..].chunks_exact_mut(4).zip(new) {
        to.copy_from_slice(&word.to_le_bytes());
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_firmware_is_refused_by_name() {
        let refused = |bytes: &[u8]| format!("{:#}", sealed(bytes).unwrap_err());
        assert!(refused(b"no program").contains("no ELF file"));
        let own = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        assert!(refused(&own).contains("microcontroller"));
    }
}
