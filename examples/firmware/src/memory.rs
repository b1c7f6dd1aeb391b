//! The board's own memory as self-checks see it: the image in flash, its seal, and the stack.

#![allow(
    unsafe_code,
    reason = "symbols of the linker, and memory that has another owner"
)]

use core::mem::MaybeUninit;
use core::slice::from_raw_parts;
use cortex_m_rt::STACK_PAINT_VALUE;
use spindle_monitor::self_check::{PARTS, Seal};

/// Seal of the image, which the project's tool `seal` finds by this name in the linked program and
/// writes. It is not covered by the image's checksum.
#[unsafe(no_mangle)]
static IMAGE_SEAL: [u32; 4] = Seal::Open.words();

// By `link.x` of cortex-m-rt and `chip.x`.
unsafe extern "C" {
    static __vector_table: u8;
    static __etext: u8;
    static __srodata: u8;
    static __erodata: u8;
    static __sidata: u8;
    static __sdata: u8;
    static __edata: u8;
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Note of an overrun of the stack. A reset leaves it as it is; after the power was off, it has any value.
#[unsafe(link_section = ".uninit.overrun")]
static mut OVERRUN: MaybeUninit<[u32; 2]> = MaybeUninit::uninit();
/// The note: unlikely words, the second one the first one's complement.
const NOTE: [u32; 2] = [0x5ac0_ffee, !0x5ac0_ffee];

/// Whether an address is below all of the stack.
pub fn is_beyond_the_stack(address: usize) -> bool {
    address < (&raw const _stack_end).addr()
}

/// Notes for the next start that the stack was used up.
pub fn note_overrun() {
    // SAFETY: nobody else writes it, and every bit pattern is a value.
    unsafe { (&raw mut OVERRUN).cast::<[u32; 2]>().write_volatile(NOTE) };
}

/// Whether the stack was used up before this start. Forgets it.
pub fn take_overrun() -> bool {
    let note = (&raw mut OVERRUN).cast::<[u32; 2]>();
    // SAFETY: as above. Memory that the compiler knows nothing of.
    let was = unsafe { note.read_volatile() } == NOTE;
    // SAFETY: likewise.
    unsafe { note.write_volatile([0; 2]) };
    was
}

/// The seal as it is in flash.
pub fn seal() -> Seal {
    // SAFETY: a static of this program; the compiler must not take its words for what they were when it was linked.
    Seal::read(unsafe { (&raw const IMAGE_SEAL).read_volatile() })
}

/// Vectors and code, constants before and after the seal, and initial values of variables.
pub fn image() -> [&'static [u8]; PARTS] {
    let between = |from: *const u8, to: *const u8| {
        let length = to.addr().saturating_sub(from.addr());
        // SAFETY: flash that the linker has filled, and that nobody writes.
        unsafe { from_raw_parts(from, length) }
    };
    let seal = &raw const IMAGE_SEAL;
    let variables = (&raw const __edata).addr() - (&raw const __sdata).addr();
    [
        between(&raw const __vector_table, &raw const __etext),
        between(&raw const __srodata, seal.cast()),
        between(seal.wrapping_add(1).cast(), &raw const __erodata),
        between(
            &raw const __sidata,
            (&raw const __sidata).wrapping_add(variables),
        ),
    ]
}

/// Measures how much of the stack was never used, from its far end on.
#[derive(Default)]
pub struct Stack {
    /// Words that are as they were painted before the program began.
    painted: u32,
}

impl Stack {
    /// Looks at so many more words. At the end, bytes that were never used; the next step begins again.
    pub fn step(&mut self, words: u32) -> Option<u32> {
        let end = &raw const _stack_end;
        for _ in 0..words {
            let at = end.wrapping_add(self.painted as usize);
            // SAFETY: words of the RAM that are aligned, read but not relied on.
            let is_painted =
                at < &raw const _stack_start && unsafe { at.read_volatile() } == STACK_PAINT_VALUE;
            if !is_painted {
                let bytes = self.painted * size_of::<u32>() as u32;
                self.painted = 0;
                return Some(bytes);
            }
            self.painted += 1;
        }
        None
    }
}
