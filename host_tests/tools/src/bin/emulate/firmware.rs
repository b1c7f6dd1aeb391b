//! The firmware: built by cargo, measured by its ELF.

use anyhow::{Context, Result, bail};
use object::{Object, ObjectSection, SectionFlags, SectionKind, elf};
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use tools::cross::{Build, TARGET};
use tools::seal::sealed;

/// The example that it is.
const PROGRAM: &str = "spindle_monitor";

/// A firmware ready to run.
pub struct Firmware {
    /// Where its ELF lies.
    pub path: PathBuf,
    /// The ELF.
    pub elf: Vec<u8>,
    /// The memory it takes.
    pub memory: Memory,
}

/// Memory taken and there, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// Code, constants, and initial values of variables.
    pub flash: u64,
    /// Flash of the chip.
    pub flash_size: u64,
    /// Variables; the stack takes from the rest.
    pub ram: u64,
    /// RAM of the chip.
    pub ram_size: u64,
}

impl fmt::Display for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |part: u64, whole: u64| 100.0 * part as f64 / whole as f64;
        write!(
            f,
            "{} bytes of flash ({:.1} % of {} KiB), {} bytes of RAM besides the stack ({:.1} % of {} KiB)",
            self.flash,
            percent(self.flash, self.flash_size),
            self.flash_size / 1024,
            self.ram,
            percent(self.ram, self.ram_size),
            self.ram_size / 1024,
        )
    }
}

/// Builds the firmware of the project in `root`, and seals it.
pub fn build(root: &Path) -> Result<Firmware> {
    let built = root
        .join("target")
        .join(TARGET)
        .join("release/examples")
        .join(PROGRAM);
    let first = if built.is_file() {
        ""
    } else {
        "; the first time takes about a minute"
    };
    eprintln!("building the firmware for {TARGET}{first}");
    let path = Build {
        program: PROGRAM,
        ..Build::default()
    }
    .run(root)?;
    let elf = fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let script = root.join("memory.x");
    let script =
        fs::read_to_string(&script).with_context(|| format!("cannot read {}", script.display()))?;
    let memory = measure(&elf, &script)?;
    let (elf, path) = (sealed(&elf)?, path.with_extension("sealed"));
    fs::write(&path, &elf).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(Firmware { path, elf, memory })
}

/// Start and length of a region of the linker script `memory.x`.
fn region(script: &str, name: &str) -> Option<(u64, u64)> {
    let line = script.lines().find(|line| {
        line.split_once(':')
            .is_some_and(|(left, _)| left.split_whitespace().next() == Some(name))
    })?;
    let value = |key: &str| {
        let (_, rest) = line.split_once(key)?;
        let text = rest.trim_start().strip_prefix('=')?.trim_start();
        let end = text
            .find(|c: char| !c.is_ascii_alphanumeric())
            .unwrap_or(text.len());
        number(&text[..end])
    };
    Some((value("ORIGIN")?, value("LENGTH")?))
}

/// A number as linkers write it: `0x08000000`, `1024K`, `1M`.
fn number(text: &str) -> Option<u64> {
    if let Some(digits) = text.strip_prefix("0x") {
        return u64::from_str_radix(digits, 16).ok();
    }
    let (digits, unit) = match text.strip_suffix('K') {
        Some(digits) => (digits, 1024),
        None => text
            .strip_suffix('M')
            .map_or((text, 1), |digits| (digits, 1024 * 1024)),
    };
    digits.parse::<u64>().ok()?.checked_mul(unit)
}

fn measure(elf: &[u8], script: &str) -> Result<Memory> {
    let find = |name| region(script, name).with_context(|| format!("memory.x has no {name}"));
    let (flash_start, flash_size) = find("FLASH")?;
    let (ram_start, ram_size) = find("RAM")?;
    let (mut flash, mut ram) = (0, 0);
    for section in object::File::parse(elf)?.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else {
            bail!("the firmware is no ELF file");
        };
        if sh_flags & u64::from(elf::SHF_ALLOC) == 0 {
            continue;
        }
        let within = |start: u64, size: u64| (start..start + size).contains(&section.address());
        if within(flash_start, flash_size) {
            flash += section.size();
        } else if within(ram_start, ram_size) {
            ram += section.size();
            // Initial values are kept in flash as well.
            if section.kind() != SectionKind::UninitializedData {
                flash += section.size();
            }
        }
    }
    Ok(Memory {
        flash,
        flash_size,
        ram,
        ram_size,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_are_read_as_the_linker_reads_them() {
        let script = "MEMORY\n{\n  FLASH (rx) : ORIGIN = 0x08000000, LENGTH = 1M\n\
                      RAM : ORIGIN=0x20000000 , LENGTH = 128K /* no CCM */\n}\n";
        assert_eq!(region(script, "FLASH"), Some((0x0800_0000, 1 << 20)));
        assert_eq!(region(script, "RAM"), Some((0x2000_0000, 128 * 1024)));
        assert_eq!(region(script, "CCM"), None);
    }
}
