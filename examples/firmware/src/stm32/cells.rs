//! The two sectors of the flash for what is kept over a power cycle.

#![allow(unsafe_code, reason = "memory that the compiler takes for constant")]

use crate::flash::{SECTOR, SECTORS};

unsafe extern "C" {
    /// Where they begin, by the chip's `chip.x`: that of the other chip does not link.
    #[cfg_attr(feature = "f405", link_name = "_retained_f405")]
    #[cfg_attr(feature = "h743", link_name = "_retained_h743")]
    static RETAINED: [u32; (SECTORS * SECTOR) as usize / 4];
}

/// The address of a word of 32 bits.
pub fn word(at: u32) -> *mut u32 {
    // The caller has held it against the capacity.
    (&raw const RETAINED)
        .cast::<u32>()
        .cast_mut()
        .wrapping_byte_add(at as usize)
}
