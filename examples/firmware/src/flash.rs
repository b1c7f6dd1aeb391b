//! Two sectors of the board's flash that the linker fills with nothing, for data kept over a power cycle.
//!
//! Without any hardware, so that it is tested on the host; the registers are in the boards' `cells.rs`.

use crate::spindle::PERIOD_US;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// Length of a sector, bytes: a large one on both chips.
pub const SECTOR: u32 = 128 * 1024;
/// Sectors.
pub const SECTORS: u32 = 2;

/// The flash's cells. Places are bytes from the first of the sectors on, and begin a unit.
/// All functions return whether it went well.
pub trait Cells {
    /// Bytes that are read or written at once.
    const UNIT: usize;

    /// Reads a unit.
    fn read(&mut self, at: u32, unit: &mut [u8]) -> bool;

    /// Writes a unit that is blank.
    fn program(&mut self, at: u32, unit: &[u8]) -> bool;

    /// Blanks a sector.
    fn erase(&mut self, sector: u32) -> bool;
}

/// The sectors as a whole.
pub struct Flash<C>(pub C);

/// Time for a step of writing, us: a unit takes 100 us at worst, a new record and its checksum some thousand instructions.
const STEP_US: u32 = 300;
/// Time after which a core that is always late takes the time for a step, us. The 40 words of a record's two copies on an
/// STM32F405 take 0.4 s then: within the second that it may take, of which half goes to the look at new data.
const PATIENCE_US: u32 = 10_000;

/// Times at which the flash is written: between ticks, where there is time.
pub struct Pace {
    /// Cycles of the core that a step may take.
    step: u32,
    /// Time since there was time for a step, us.
    waited_us: u32,
}

impl Pace {
    /// At the start, on a core of this frequency.
    pub const fn new(core_hz: u32) -> Self {
        Self {
            step: core_hz / 1_000_000 * STEP_US,
            waited_us: 0,
        }
    }

    /// Whether so many cycles before the next tick there is time for a step, which is then made.
    pub const fn has_time(&mut self, left: u32) -> bool {
        let has = left > self.step;
        if has {
            self.waited_us = 0;
        }
        has
    }

    /// A tick is done. Whether a step is to be made, though there was no time for one for long.
    pub const fn is_overdue(&mut self) -> bool {
        self.waited_us = self.waited_us.saturating_add(PERIOD_US);
        let is = self.waited_us >= PATIENCE_US;
        if is {
            self.waited_us = 0;
        }
        is
    }
}

impl<C> ErrorType for Flash<C> {
    type Error = NorFlashErrorKind;
}

const fn well(done: bool) -> Result<(), NorFlashErrorKind> {
    if done {
        Ok(())
    } else {
        Err(NorFlashErrorKind::Other)
    }
}

impl<C: Cells> ReadNorFlash for Flash<C> {
    const READ_SIZE: usize = C::UNIT;

    // Inlined, it costs 960 B on the STM32F405 and 2660 B on the STM32H743.
    #[inline(never)]
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        let units = bytes.chunks_exact_mut(C::UNIT);
        for (at, unit) in (offset..).step_by(C::UNIT).zip(units) {
            well(self.0.read(at, unit))?;
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        (SECTORS * SECTOR) as usize
    }
}

impl<C: Cells> NorFlash for Flash<C> {
    const WRITE_SIZE: usize = C::UNIT;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        for sector in from / SECTOR..to / SECTOR {
            well(self.0.erase(sector))?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        let units = bytes.chunks_exact(C::UNIT);
        for (at, unit) in (offset..).step_by(C::UNIT).zip(units) {
            well(self.0.program(at, unit))?;
        }
        Ok(())
    }
}
