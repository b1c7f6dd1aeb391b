//! Registers of the independent watchdog.

#![allow(
    unsafe_code,
    reason = "registers without an owner, fields without ranges"
)]

use super::chip::dog::{IWDG_ADDRESS, Watchdogs};
use super::pac::IWDG;
use crate::board::within;
use crate::dog::{self, COUNTS};

// Starts it, before anything else. Before variables are initialised, only registers can be used. This starts the watchdog
// (0xcccc) and opens its prescaler (0x5555) to divide 32 kHz by 64 (4). It begins at 4095 counts, that is 8 s.
core::arch::global_asm!(
    ".pushsection .text.__pre_init, \"ax\", %progbits",
    ".global __pre_init",
    ".type __pre_init, %function",
    ".thumb_func",
    "__pre_init:",
    "movw r0, #({address} & 0xffff)",
    "movt r0, #({address} >> 16)",
    "movw r1, #0xcccc",
    "str r1, [r0]",
    "movw r1, #0x5555",
    "str r1, [r0]",
    "movs r1, #4",
    "str r1, [r0, #4]",
    "bx lr",
    ".size __pre_init, . - __pre_init",
    ".popsection",
    address = const IWDG_ADDRESS,
);

/// Looks at its status before it counts as idle: some ms at least, where an update takes 0.3 ms.
const PATIENCE: u32 = 200_000;

/// Feeds it while the board starts.
pub fn feed_at_start() {
    dog::feed_at_start::<Watchdogs>();
}

/// Feeds it, whoever has it.
pub fn feed() {
    // SAFETY: it is always there; a write of this key feeds it, whoever writes.
    unsafe { &*IWDG::ptr() }.kr().write(|w| w.key().feed());
}

/// Has it wait for [`COUNTS`] from now on.
pub fn tighten(iwdg: &IWDG) {
    let idle = || within(PATIENCE, || iwdg.sr().read().bits() == 0);
    idle();
    iwdg.kr().write(|w| w.key().unlock());
    iwdg.pr().write(|w| w.pr().divide_by32());
    // SAFETY: within the register's twelve bits.
    iwdg.rlr().write(|w| unsafe { w.bits(COUNTS) });
    idle();
}
