//! The watchdogs: the independent one, on an oscillator of its own, and a window in which it is to be fed
//! (`super::reset`). They run from the first instruction on, and nothing stops them again.
//!
//! | while | reset after | fed |
//! | --- | --- | --- |
//! | the board starts | 8 s, 5 s to 16 s with the oscillator's tolerance | after every step, and while a sector is erased |
//! | ticks run | 1 s; on the STM32F405 50 ms, too | every 16 ms by a tick that finished, and not within 8 ms |
//! | lock-step | as at the start | while it waits for bytes, and by every tick |

#![allow(unsafe_code, reason = "a register without an owner")]

use super::beat::ticks;
use super::clock::Clock;
use super::pac::IWDG;
use super::reset::{IWDG_ADDRESS, Window};
use super::within;
use crate::monitor_settings::MONITOR;
use core::sync::atomic::{AtomicBool, Ordering};
use spindle_monitor::tick::Watchdog;

// Before variables are initialised, only registers can be used. This starts the independent watchdog (0xcccc) and
// opens its prescaler (0x5555) to divide 32 kHz by 64 (4). The watchdog begins at 4095 counts, that is 8 s.
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

/// The window is watched: it is no longer the start.
static WATCHED: AtomicBool = AtomicBool::new(false);

/// Time between two feedings, and the least that is allowed, us. A tick that comes after a late one may be early by
/// a period.
const FED_EVERY_US: u32 = 16_000;
pub const TOO_EARLY_US: u32 = FED_EVERY_US / 2;
/// Ticks between two feedings. One is not enough: the first may come at once.
const FED_EVERY: u32 = {
    let ticks = FED_EVERY_US / MONITOR.tick.period_us;
    if ticks < 2 { 2 } else { ticks }
};
const _: () = assert!(
    MONITOR.tick.period_us <= 10_000,
    "two ticks of more are no shorter than the window"
);

/// Counts of the independent watchdog while ticks run, 1 ms each: 32 kHz by 32.
pub const COUNTS: u16 = 1000;
/// Looks at its status before it counts as idle: some ms at least, where an update takes 0.3 ms.
const PATIENCE: u32 = 200_000;

/// Feeds the independent watchdog while the board starts; later on it does nothing.
pub fn feed_at_start() {
    if !WATCHED.load(Ordering::Relaxed) {
        // SAFETY: it is always there; a write of this key feeds it, whoever writes.
        unsafe { &*IWDG::ptr() }.kr().write(|w| w.key().feed());
    }
}

/// Feeds the watchdogs.
pub struct Dog {
    iwdg: IWDG,
    /// None in lock-step.
    window: Option<Window>,
    /// The timer's tick of the last feeding.
    fed: u32,
}

impl Dog {
    /// For lock-step, where a tick comes when the other side asks for it: the independent watchdog goes on as at the
    /// start.
    pub const fn patient(iwdg: IWDG) -> Self {
        Self {
            iwdg,
            window: None,
            fed: 0,
        }
    }

    /// For ticks by the timer, which has just been started.
    pub fn strict(iwdg: IWDG, window: Window, clock: &Clock) -> Self {
        let idle = || within(PATIENCE, || iwdg.sr().read().bits() == 0);
        idle();
        iwdg.kr().write(|w| w.key().unlock());
        iwdg.pr().write(|w| w.pr().divide_by32());
        // SAFETY: within the register's twelve bits.
        iwdg.rlr().write(|w| unsafe { w.bits(COUNTS) });
        idle();
        window.start(&iwdg, clock);
        WATCHED.store(true, Ordering::Relaxed);
        Self {
            iwdg,
            window: Some(window),
            fed: ticks(),
        }
    }
}

impl Watchdog for Dog {
    fn feed(&mut self) {
        if let Some(window) = &self.window {
            let now = ticks();
            if now.wrapping_sub(self.fed) < FED_EVERY {
                return;
            }
            self.fed = now;
            window.feed();
        }
        self.iwdg.kr().write(|w| w.key().feed());
    }
}
