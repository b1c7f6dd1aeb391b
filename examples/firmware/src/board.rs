//! A board, as the application wants it.

use crate::beat::Cycles;
use crate::dog::Watchdogs;
use crate::flash::Cells;
use crate::receiver::Receiver;
use crate::sensors::Measured;
use crate::spindle::ROWS;
use crate::strap::{Pins, Wires};
use cortex_m::peripheral::SYST;
use spindle_monitor::board::{BoardReport, ResetCause};
use spindle_monitor::settings::MonitorSettings;

/// Whether the firmware programs the highest brown-out level into the chip's option bytes.
///
/// They stay so whatever is flashed later. Set it here, or build with `SPINDLE_BROWN_OUT=set` in the environment.
pub const SET_BROWN_OUT: bool = option_env!("SPINDLE_BROWN_OUT").is_some();

/// A kind of board: its constants, and what its chip does.
pub trait Board: Sized {
    /// The monitor's settings on this core.
    const MONITOR: &'static MonitorSettings<ROWS>;

    /// Flash for what is kept over a power cycle.
    type Cells: Cells;
    /// Pins of the straps.
    type Pins: Pins;
    /// Watchdogs.
    type Watchdogs: Watchdogs;

    /// In lock-step, the byte that has come in, if there is one.
    fn received() -> Option<u8>;

    /// Whether the port takes a byte now.
    fn is_free() -> bool;

    /// Sends a byte over the port, or drops it if the transmitter is stuck.
    fn send(byte: u8);
}

/// A board, all of it started but the timer.
pub struct Started<B: Board> {
    /// Source of the clock that was reached.
    pub clock: &'static str,
    /// Frequency of the core, Hz.
    pub core_hz: u32,
    /// Receiver of the bytes that come in over the port.
    pub receiver: Receiver,
    /// Counts cycles.
    pub cycles: Cycles,
    /// The watchdogs: the independent one runs, the window is not watched yet.
    pub watchdogs: B::Watchdogs,
    /// The timer: not started yet.
    pub timer: SYST,
    /// Ticks are asked for over the port ([`strap`](crate::strap)), or the board is an emulated one.
    pub lock_step: bool,
    /// Wires to the machine.
    pub wires: Wires<B::Pins>,
    /// Report of the board on itself: its brown-out level.
    pub report: BoardReport,
    /// Why it started.
    pub reset: ResetCause,
    /// Strain bridges and tachometer, if they are chosen.
    pub sensors: Option<Measured>,
    /// Flash for what is kept over a power cycle; none on an emulated board.
    pub cells: Option<B::Cells>,
}

/// Whether a condition comes true within `tries` looks at it.
///
/// Every wait for hardware goes through here, so that hardware that is broken, or not there in an emulator, cannot stop the
/// program.
pub fn within(tries: u32, mut condition: impl FnMut() -> bool) -> bool {
    (0..tries).any(|_| condition())
}
