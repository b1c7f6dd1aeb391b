//! The last two sectors of this chip's flash.
//!
//! There is one bank, from which the core executes, too. While a word is written the core may stand still for
//! 16 us, 100 us at worst; while a sector is erased, for 1 s to 2 s.

#![allow(unsafe_code, reason = "memory that the compiler takes for constant")]

use crate::board::within;
use crate::flash::Cells;
use crate::stm32::cells::word;
use crate::stm32::iwdg::feed_at_start;
use crate::stm32::pac::{self, FLASH};

/// The first of the two sectors: `chip.x` holds its address against it.
const FIRST: u8 = 10;

/// Looks at the busy flag before a write counts as failed: 10 ms at least.
const PATIENCE: u32 = 200_000;
/// Looks before an erase counts as failed: 4 s at least, the core's caches holding this loop.
const ERASE_PATIENCE: u32 = 80_000_000;

/// The controller, unlocked.
pub struct Memory(FLASH);

/// Unlocks the controller; `None` if there is none, as on an emulator.
pub fn start(flash: FLASH) -> Option<Memory> {
    if flash.cr().read().lock().is_locked() {
        flash.keyr().write(|w| w.key().set(0x4567_0123));
        flash.keyr().write(|w| w.key().set(0xcdef_89ab));
    }
    // Words of 32 bits, for which a supply of 2.7 V is enough.
    command(&flash, |w| w);
    let control = flash.cr().read();
    let there = control.lock().is_unlocked() && control.psize().is_psize32();
    there.then_some(Memory(flash))
}

/// Writes the controller's command. Its lock is set where a command does not say that it is open.
fn command(flash: &FLASH, what: impl FnOnce(&mut pac::flash::cr::W) -> &mut pac::flash::cr::W) {
    flash
        .cr()
        .write(|w| what(w.lock().unlocked().psize().psize32()));
}

impl Memory {
    /// Waits for the end, and whether that was a good one. In between it does something else.
    fn ends(&self, patience: u32, meanwhile: impl Fn()) -> bool {
        let idle = within(patience, || {
            meanwhile();
            self.0.sr().read().bsy().is_not_busy()
        });
        let status = self.0.sr().read();
        let errors = status.wrperr().is_active()
            || status.pgaerr().is_active()
            || status.pgperr().is_active()
            || status.pgserr().is_active();
        idle && !errors
    }

    /// Clears errors from before.
    fn clear(&self) {
        self.0.sr().write(|w| {
            w.eop().clear().operr().clear().wrperr().clear();
            w.pgaerr().clear().pgperr().clear().pgserr().clear()
        });
    }

    /// Drops the data of these sectors from the cache.
    fn forget_cached(&self) {
        let acr = self.0.acr();
        let on = acr.read().dcen().is_enabled();
        acr.modify(|_, w| w.dcen().disabled());
        acr.modify(|_, w| w.dcrst().reset());
        acr.modify(|_, w| w.dcrst().no_reset());
        acr.modify(|_, w| w.dcen().bit(on));
    }
}

impl Cells for Memory {
    const UNIT: usize = 4;

    fn read(&mut self, at: u32, unit: &mut [u8]) -> bool {
        // SAFETY: within the two sectors, and a multiple of four.
        let content = unsafe { word(at).read_volatile() };
        unit.copy_from_slice(&content.to_le_bytes());
        true
    }

    fn program(&mut self, at: u32, unit: &[u8]) -> bool {
        let Ok(bytes) = <[u8; 4]>::try_from(unit) else {
            return false;
        };
        self.clear();
        command(&self.0, |w| w.pg().program());
        // SAFETY: as above; the linker has put nothing there, and the controller takes it for a word to write.
        unsafe { word(at).write_volatile(u32::from_le_bytes(bytes)) };
        cortex_m::asm::dsb();
        let good = self.ends(PATIENCE, || {});
        command(&self.0, |w| w);
        self.forget_cached();
        good
    }

    fn erase(&mut self, sector: u32) -> bool {
        self.clear();
        let number = FIRST.saturating_add(sector as u8);
        let erase_command = |start: bool| {
            command(&self.0, |w| {
                // SAFETY: sectors end at 11, and the caller has held this one against the capacity.
                let w = unsafe { w.snb().bits(number) };
                w.ser().sector_erase().strt().bit(start)
            });
        };
        erase_command(false);
        erase_command(true);
        cortex_m::asm::dsb();
        // The watchdog would not wait for the longest erasing and a slow look at it.
        let good = self.ends(ERASE_PATIENCE, feed_at_start);
        command(&self.0, |w| w);
        self.forget_cached();
        good
    }
}
