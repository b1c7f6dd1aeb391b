//! The watchdogs: the independent one, on an oscillator of its own, and a window in which it is to be fed.
//!
//! They run from the first instruction on, and nothing stops them again.
//!
//! | while | reset after | fed |
//! | --- | --- | --- |
//! | the board starts | 8 s, 5 s to 16 s with the oscillator's tolerance | after every step, and while a sector is erased |
//! | ticks run | 1 s; on the STM32F405 50 ms, too | every 16 ms by a tick that finished, and not within 8 ms |
//! | lock-step | as at the start | while it waits for bytes, and by every tick |

use crate::beat::ticks;
use crate::spindle::PERIOD_US;
use core::sync::atomic::{AtomicBool, Ordering};
use spindle_monitor::tick::Watchdog;

/// The window is watched: it is no longer the start.
static WATCHED: AtomicBool = AtomicBool::new(false);

/// Time between two feedings, us.
pub const FED_EVERY_US: u32 = 16_000;
/// The least that is allowed, us. A tick that comes after a late one may be early by a period.
pub const TOO_EARLY_US: u32 = FED_EVERY_US / 2;
/// Ticks between two feedings. One is not enough: the first may come at once.
const FED_EVERY: u32 = {
    let ticks = FED_EVERY_US / PERIOD_US;
    if ticks < 2 { 2 } else { ticks }
};
const _: () = assert!(
    PERIOD_US <= 10_000,
    "two ticks of more are no shorter than the window"
);

/// Counts of the independent watchdog while ticks run, 1 ms each: 32 kHz by 32.
pub const COUNTS: u16 = 1000;

/// The watchdogs of a board.
pub trait Watchdogs {
    /// Feeds the independent one alone, whoever has it.
    fn feed_independent();

    /// Watches the window: reset after [`COUNTS`], and of a feeding within [`TOO_EARLY_US`].
    fn tighten(&mut self);

    /// Feeds those that run.
    fn feed(&mut self);
}

/// Feeds the independent watchdog while the board starts; later on it does nothing.
pub fn feed_at_start<W: Watchdogs>() {
    if !WATCHED.load(Ordering::Relaxed) {
        W::feed_independent();
    }
}

/// Feeds the watchdogs.
pub struct Dog<W> {
    watchdogs: W,
    /// The timer's tick of the last feeding; none in lock-step.
    fed: Option<u32>,
}

impl<W: Watchdogs> Dog<W> {
    /// For lock-step, where a tick comes when the other side asks for it: the independent watchdog goes on as at the
    /// start.
    pub const fn patient(watchdogs: W) -> Self {
        Self {
            watchdogs,
            fed: None,
        }
    }

    /// For ticks by the timer, which has just been started.
    pub fn strict(mut watchdogs: W) -> Self {
        watchdogs.tighten();
        WATCHED.store(true, Ordering::Relaxed);
        Self {
            watchdogs,
            fed: Some(ticks()),
        }
    }
}

impl<W: Watchdogs> Watchdog for Dog<W> {
    fn feed(&mut self) {
        if let Some(fed) = &mut self.fed {
            let now = ticks();
            if now.wrapping_sub(*fed) < FED_EVERY {
                return;
            }
            *fed = now;
        }
        self.watchdogs.feed();
    }
}
