//! The monitor's beat: SysTick, and the core's cycle counter. They are the same on every Cortex-M.

use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{DCB, DWT, SYST};
use cortex_m_rt::exception;
use spindle_monitor::tick::CycleCounter;

/// Ticks of the timer; wraps.
static TICKS: AtomicU32 = AtomicU32::new(0);

#[exception]
fn SysTick() {
    // No other writer, and no read-modify-write that could be lost.
    TICKS.store(
        TICKS.load(Ordering::Relaxed).wrapping_add(1),
        Ordering::Relaxed,
    );
}

/// Ticks of the timer so far, modulo 2^32.
pub fn ticks() -> u32 {
    TICKS.load(Ordering::Relaxed)
}

/// Cycles of the core until the timer's next tick.
pub fn left() -> u32 {
    SYST::get_current()
}

/// Starts the timer.
pub fn start_timer(mut syst: SYST, core_hz: u32, period_us: u32) {
    let cycles = (core_hz / 1_000_000).saturating_mul(period_us);
    syst.set_clock_source(SystClkSource::Core);
    syst.set_reload(cycles.saturating_sub(1));
    syst.clear_current();
    syst.enable_counter();
    syst.enable_interrupt();
}

/// The core's cycles. An emulator without the counter shows 0.
pub struct Cycles(());

impl Cycles {
    /// Starts the counter.
    pub fn start(dcb: &mut DCB, dwt: &mut DWT) -> Self {
        dcb.enable_trace();
        DWT::unlock();
        dwt.enable_cycle_counter();
        Self(())
    }
}

impl CycleCounter for Cycles {
    fn cycles(&mut self) -> u32 {
        DWT::cycle_count()
    }
}
