//! The last two sectors of this chip's flash, in its second bank.
//!
//! The core executes from the first bank, and goes on while the second one writes. Every 32 bytes have a code that
//! corrects errors. Where the power is lost while they are written, that code is wrong, and reading them is a bus
//! fault. [`Memory::read`] has the core ignore it, and asks the controller.

#![allow(unsafe_code, reason = "memory that the compiler takes for constant")]

use crate::board::within;
use crate::flash::{Cells, SECTOR};
use crate::stm32::cells::word;
use crate::stm32::iwdg::feed_at_start;
use crate::stm32::pac::{self, FLASH};
use core::arch::asm;
use cortex_m::peripheral::SCB;

/// The first of the two sectors, in its bank: `chip.x` holds its address against it.
const FIRST: u8 = 6;

/// Looks at the busy flags before a write counts as failed: 10 ms at least.
const PATIENCE: u32 = 500_000;
/// Looks at the busy flags before an erase counts as failed: 4 s at least.
const ERASE_PATIENCE: u32 = 200_000_000;

/// Bytes that have one code.
const WORD: usize = 32;
/// Ignores bus faults of reads where faults are masked (`SCB.CCR.BFHFNMIGN`). Ignored faults set the
/// flags below (`SCB.CFSR`, its part for the bus).
const IGNORE_BUS_FAULTS: u32 = 1 << 8;
const BUS_FAULTS: u32 = 0xff00;

/// The controller, its second bank unlocked.
pub struct Memory {
    flash: FLASH,
    scb: SCB,
}

/// Unlocks the second bank; `None` if that cannot be had.
pub fn start(flash: FLASH, scb: SCB) -> Option<Memory> {
    let bank = flash.bank2();
    if bank.cr().read().lock().bit_is_set() {
        // SAFETY: the two words that unlock it.
        bank.keyr().write(|w| unsafe { w.bits(0x4567_0123) });
        // SAFETY: likewise.
        bank.keyr().write(|w| unsafe { w.bits(0xcdef_89ab) });
    }
    let there = bank.cr().read().lock().bit_is_clear();
    there.then_some(Memory { flash, scb })
}

/// Writes the bank's command. Its lock is set where a command does not say that it is open.
fn command(
    flash: &FLASH,
    what: impl FnOnce(&mut pac::flash::bank::cr::W) -> &mut pac::flash::bank::cr::W,
) {
    flash.bank2().cr().write(|w| {
        // SAFETY: 3 is 64 bits at a time.
        what(unsafe { w.lock().clear_bit().psize().bits(3) })
    });
}

impl Memory {
    /// Waits for the end, and whether that was a good one. In between it does something else.
    fn ends(&self, patience: u32, meanwhile: impl Fn()) -> bool {
        let bank = self.flash.bank2();
        let idle = within(patience, || {
            meanwhile();
            let status = bank.sr().read();
            status.qw().bit_is_clear() && status.bsy().bit_is_clear()
        });
        let status = bank.sr().read();
        let errors = status.wrperr().bit_is_set()
            || status.pgserr().bit_is_set()
            || status.strberr().bit_is_set()
            || status.incerr().bit_is_set()
            || status.operr().bit_is_set();
        idle && !errors
    }

    /// Clears errors from before, which would keep the controller from work.
    fn clear(&self) {
        self.flash.bank2().ccr().write(|w| {
            w.clr_eop().set_bit().clr_wrperr().set_bit();
            w.clr_pgserr().set_bit().clr_strberr().set_bit();
            w.clr_incerr().set_bit().clr_operr().set_bit();
            w.clr_rdperr().set_bit().clr_rdserr().set_bit();
            w.clr_sneccerr().set_bit().clr_dbeccerr().set_bit()
        });
    }

    /// Drops the data of this part from the cache.
    fn forget_cached(&mut self, at: u32, length: u32) {
        let address = word(at) as usize;
        self.scb
            .clean_invalidate_dcache_by_address(address, length as usize);
    }
}

impl Cells for Memory {
    const UNIT: usize = WORD;

    fn read(&mut self, at: u32, unit: &mut [u8]) -> bool {
        self.clear();
        let from = word(at);
        let mut content = [0_u32; WORD / 4];
        // SAFETY: the register is changed back below, before anything else can fault.
        unsafe { self.scb.ccr.modify(|bits| bits | IGNORE_BUS_FAULTS) };
        // SAFETY: masks all faults and interrupts, for the time of eight reads.
        unsafe { asm!("cpsid f", "dsb", "isb", options(nostack, preserves_flags)) };
        for (i, to) in content.iter_mut().enumerate() {
            // SAFETY: within the two sectors, and a multiple of four.
            *to = unsafe { from.wrapping_add(i).read_volatile() };
        }
        // SAFETY: undoes the above, once the reads are over.
        unsafe { asm!("dsb", "cpsie f", "isb", options(nostack, preserves_flags)) };
        // SAFETY: likewise; writing ones clears the flags.
        unsafe {
            self.scb.ccr.modify(|bits| bits & !IGNORE_BUS_FAULTS);
            self.scb.cfsr.write(BUS_FAULTS);
        }
        for (to, from) in unit.chunks_exact_mut(4).zip(content) {
            to.copy_from_slice(&from.to_le_bytes());
        }
        let bank = self.flash.bank2();
        // The core may have looked ahead: only an error of this very word counts.
        let failed = u32::from(bank.far().read().fail_ecc_addr().bits());
        let here = (from as u32 & 0xf_ffff) / WORD as u32;
        !(bank.sr().read().dbeccerr().bit_is_set() && failed == here)
    }

    fn program(&mut self, at: u32, unit: &[u8]) -> bool {
        self.clear();
        let to = word(at);
        command(&self.flash, |w| w.pg().set_bit());
        cortex_m::asm::dsb();
        for (i, bytes) in unit.chunks_exact(4).enumerate() {
            let mut content = [0; 4];
            content.copy_from_slice(bytes);
            // SAFETY: within the two sectors; the linker has put nothing there, and the controller takes eight of
            // these for a word to write.
            unsafe {
                to.wrapping_add(i)
                    .write_volatile(u32::from_le_bytes(content));
            }
        }
        cortex_m::asm::dsb();
        let good = self.ends(PATIENCE, || {});
        command(&self.flash, |w| w);
        self.forget_cached(at, WORD as u32);
        good
    }

    fn erase(&mut self, sector: u32) -> bool {
        self.clear();
        let number = FIRST.saturating_add(sector as u8);
        let erase_command = |start: bool| {
            command(&self.flash, |w| {
                // SAFETY: sectors end at 7, and the caller has held this one against the capacity.
                let w = unsafe { w.snb().bits(number) };
                w.ser().set_bit().start().bit(start)
            });
        };
        erase_command(false);
        erase_command(true);
        cortex_m::asm::dsb();
        // The watchdog would not wait for the longest erasing and a slow look at it.
        let good = self.ends(ERASE_PATIENCE, feed_at_start);
        command(&self.flash, |w| w);
        self.forget_cached(sector * SECTOR, SECTOR);
        good
    }
}
