//! Flash in memory that fails as real ones do: by a power cut at any byte, worn cells, and erases that fail.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use std::collections::BTreeSet;
use std::ops::Range;

/// Power that it takes to erase a sector, in bytes written.
pub const ERASE: usize = 64;

/// Content of a sector after an erase that fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Leftover {
    /// The content of before.
    Everything,
    /// Some bits of each byte.
    #[default]
    SomeBits,
    /// The first half of the content; the other one is blank.
    FirstHalf,
    /// Blank, although the erase failed.
    Nothing,
}

impl Leftover {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Everything,
        Self::SomeBits,
        Self::FirstHalf,
        Self::Nothing,
    ];
}

/// A flash of sectors, written in units of `UNIT` bytes. Units of 32 bytes and more have error correction: one that
/// was written only in part cannot be read until it is erased.
#[derive(Debug, Clone, Default)]
pub struct FailingFlash<const UNIT: usize, const SECTOR: usize> {
    /// Content.
    pub bytes: Vec<u8>,
    /// Bytes that are written before the power goes, the last of them in part; to erase a sector takes that of
    /// [`ERASE`]. Nothing works at 0.
    pub power: Option<usize>,
    /// Units that cannot be read.
    pub unreadable: BTreeSet<usize>,
    /// Places that do not hold what is written there.
    pub worn: BTreeSet<usize>,
    /// Sectors whose erase fails.
    pub stuck: BTreeSet<usize>,
    /// Content of a sector after an erase that fails, by the power or as stuck.
    pub leftover: Leftover,
    /// Complete erases of each sector.
    pub erased: Vec<u32>,
    /// Erases that failed.
    pub failed_erases: u32,
    /// Bytes written.
    pub written: usize,
}

impl<const UNIT: usize, const SECTOR: usize> FailingFlash<UNIT, SECTOR> {
    /// A blank flash.
    pub fn new(sectors: usize) -> Self {
        Self {
            bytes: vec![0xff; sectors * SECTOR],
            erased: vec![0; sectors],
            ..Self::default()
        }
    }

    /// With so much power left; `None` for any amount.
    #[must_use]
    pub fn powered(mut self, power: Option<usize>) -> Self {
        self.power = power;
        self
    }

    /// Uses power for so many bytes; whether it lasted.
    fn lasts(&mut self, bytes: usize) -> bool {
        self.power = self.power.map(|left| left.saturating_sub(bytes));
        self.power != Some(0)
    }

    fn erase_sector(&mut self, sector: usize) -> Result<(), NorFlashErrorKind> {
        let range = sector * SECTOR..(sector + 1) * SECTOR;
        if self.lasts(ERASE) && !self.stuck.contains(&sector) {
            self.blank(range);
            self.erased[sector] += 1;
            return Ok(());
        }
        self.failed_erases += 1;
        match self.leftover {
            Leftover::Everything => {}
            Leftover::SomeBits => {
                for (i, byte) in self.bytes[range].iter_mut().enumerate() {
                    *byte |= (i as u8).wrapping_mul(73);
                }
            }
            Leftover::FirstHalf => self.blank(range.start + SECTOR / 2..range.end),
            Leftover::Nothing => self.blank(range),
        }
        Err(NorFlashErrorKind::Other)
    }

    fn blank(&mut self, range: Range<usize>) {
        self.bytes[range.clone()].fill(0xff);
        self.unreadable.retain(|at| !range.contains(at));
    }
}

impl<const UNIT: usize, const SECTOR: usize> ErrorType for FailingFlash<UNIT, SECTOR> {
    type Error = NorFlashErrorKind;
}

impl<const UNIT: usize, const SECTOR: usize> ReadNorFlash for FailingFlash<UNIT, SECTOR> {
    const READ_SIZE: usize = UNIT;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        let range = offset as usize..offset as usize + bytes.len();
        if self.power == Some(0) || self.unreadable.range(range.clone()).next().is_some() {
            return Err(NorFlashErrorKind::Other);
        }
        bytes.copy_from_slice(&self.bytes[range]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const UNIT: usize, const SECTOR: usize> NorFlash for FailingFlash<UNIT, SECTOR> {
    const WRITE_SIZE: usize = UNIT;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        if self.power == Some(0) {
            return Err(NorFlashErrorKind::Other);
        }
        (from as usize / SECTOR..to as usize / SECTOR)
            .try_for_each(|sector| self.erase_sector(sector))
    }

    /// # Panics
    ///
    /// If a unit is not blank: only an erase sets bits.
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        if self.power == Some(0) {
            return Err(NorFlashErrorKind::Other);
        }
        for (at, byte) in (offset as usize..).zip(bytes) {
            assert_eq!(self.bytes[at], 0xff, "{at} is written twice");
            if !self.lasts(1) {
                // Half of the bits of this byte.
                self.bytes[at] &= byte | 0xa5;
                if UNIT >= 32 {
                    self.unreadable.insert(at - at % UNIT);
                }
                return Err(NorFlashErrorKind::Other);
            }
            self.bytes[at] = byte | if self.worn.contains(&at) { 0x10 } else { 0 };
            self.written += 1;
        }
        Ok(())
    }
}
