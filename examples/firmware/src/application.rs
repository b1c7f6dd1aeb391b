//! The monitor's application, the same on every board: loads and speed in, alarms and telemetry out.

use crate::beat::{self, Cycles};
use crate::board::{Board, Started};
use crate::chain::{self, Chain, Sensors, SpindleMonitor, SpindleProbes};
use crate::dog::{Dog, feed_at_start};
use crate::flash::{Cells, Flash, Pace};
use crate::memory;
use crate::receiver::BAUD;
use crate::self_check::{KnownSolver, SelfCheck};
use crate::spindle::{BALLS, BRIDGES, IDENTITY, PERIOD_US, PROBES, ROWS};
use core::mem::MaybeUninit;
use spindle_monitor::board::ResetCause;
use spindle_monitor::retained::WriteError;
use spindle_monitor::tick::{Watchdog, Widened};
use spindle_monitor::{Outcome, Past, Store};

/// A board's chain.
type BoardChain<S> = Chain<&'static mut SpindleMonitor, S>;

/// Takes the board, and never gives it back.
pub fn run<B: Board>(mut board: Started<B>) -> ! {
    const {
        assert!(
            B::MONITOR.tick.has_time(ROWS, BALLS)
                && (PROBES == 0 || B::MONITOR.tick.has_time_for_probes(ROWS, BALLS)),
            "a tick has no time for a part of a solve: give a longer period_ms under [monitor], or fewer balls or probes"
        );
    }
    defmt::info!(
        "ready: core at {=u32} MHz, clock {=str}, {=u32} baud, ticks by {=str}",
        board.core_hz / 1_000_000,
        board.clock,
        BAUD,
        if board.lock_step {
            "the port"
        } else {
            "the timer"
        }
    );
    defmt::info!("started by {=str}", board.reset.name());
    if memory::take_overrun() {
        defmt::error!("the stack was used up before this start");
    }
    if board.report.brown_out == Some(0) {
        defmt::warn!(
            "brown-out reset is off: the chip runs on where the supply is too low for its flash"
        );
    }
    feed_at_start::<B::Watchdogs>();
    let (keeper, past) = Keeper::start(board.cells.take(), board.reset, board.core_hz);
    let Some(place) = cortex_m::singleton!(: MaybeUninit<SpindleMonitor> = MaybeUninit::uninit())
    else {
        unreachable!("main runs once, and makes one monitor");
    };
    // Without probes, the linker leaves them out.
    let probes = if PROBES != 0 {
        cortex_m::singleton!(: SpindleProbes = chain::probes(B::MONITOR))
    } else {
        None
    };
    let monitor = chain::make(place, probes, &past, B::MONITOR);
    // The compiler leaves out what is not chosen.
    if BRIDGES
        && !board.lock_step
        && let Some(sensors) = board.sensors.take()
    {
        with(&mut Chain::with(sensors, monitor), board, keeper)
    } else {
        with(&mut Chain::new(monitor), board, keeper)
    }
}

/// Keeps life, alarms and estimates over a power cycle, where the board has a memory for them.
struct Keeper<C> {
    store: Option<Store<Flash<C>>>,
    pace: Pace,
    /// Failures that the log knows of.
    told: u32,
}

impl<C: Cells> Keeper<C> {
    /// Reads what was kept. May take some seconds, if there is something to erase.
    fn start(cells: Option<C>, cause: ResetCause, core_hz: u32) -> (Self, Past) {
        let (store, past) = match cells {
            None => {
                defmt::warn!("no flash to write: life and alarms are lost with the power");
                (None, Past::without_memory(cause))
            }
            Some(cells) => {
                let (store, past) = recall(cells, cause);
                let report = store.report();
                defmt::info!(
                    "start {=u32}, over the power cycle: life and alarms {=str}, estimates {=str}, {=u16} damaged records",
                    past.start.boots,
                    report.recovery.name(),
                    report.estimates.name(),
                    report.damaged
                );
                (Some(store), past)
            }
        };
        let mut keeper = Self {
            store,
            pace: Pace::new(core_hz),
            told: 0,
        };
        keeper.tell();
        (keeper, past)
    }

    /// After a tick.
    fn look<S: Sensors>(&mut self, chain: &mut BoardChain<S>) {
        if let Some(store) = &mut self.store {
            chain.retain(store);
            if self.pace.is_overdue() {
                self.step();
            }
        }
    }

    /// Between ticks, so many cycles before the next one. Whether there was something to do.
    fn step_within(&mut self, left: u32) -> bool {
        self.pace.has_time(left) && self.step()
    }

    fn step(&mut self) -> bool {
        let stepped = self.store.as_mut().is_some_and(keep);
        if stepped {
            self.tell();
        }
        stepped
    }

    fn tell(&mut self) {
        let Some(store) = &self.store else {
            return;
        };
        let failed = store.report().failed;
        if failed != self.told {
            self.told = failed;
            let why = store.error().map_or("", WriteError::name);
            defmt::error!("{=u32} copies of records not kept: {=str}", failed, why);
        }
    }
}

/// Runs a chain.
fn with<B: Board, S: Sensors>(
    chain: &mut BoardChain<S>,
    mut board: Started<B>,
    keeper: Keeper<B::Cells>,
) -> ! {
    feed_at_start::<B::Watchdogs>();
    if let Err(status) = chain.prepare() {
        defmt::warn!("no equilibrium to start from: {=str}", status.name());
    }
    let (lock_step, core_hz) = (board.lock_step, board.core_hz);
    let Some(solver) = cortex_m::singleton!(: KnownSolver = KnownSolver::of()) else {
        unreachable!("main runs once, and checks one board");
    };
    let checks = &mut SelfCheck::start::<B::Watchdogs>(
        board.report,
        solver,
        lock_step,
        core_hz,
        &mut board.cycles,
    );
    chain.set_board(checks.report());
    feed_at_start::<B::Watchdogs>();
    if lock_step {
        in_lock_step(chain, board, keeper, checks)
    } else {
        by_the_timer(chain, board, keeper, checks)
    }
}

/// Ticks by the timer. Between them, bytes come in and go out.
fn by_the_timer<B: Board, S: Sensors>(
    chain: &mut BoardChain<S>,
    mut board: Started<B>,
    mut keeper: Keeper<B::Cells>,
    checks: &mut SelfCheck<'_>,
) -> ! {
    beat::start_timer(board.timer, board.core_hz, PERIOD_US);
    let mut dog = Dog::strict(board.watchdogs);
    let mut last = beat::ticks();
    let mut clock = Widened::new(32, last);
    let mut lost = 0;
    loop {
        while let Some(byte) = board.receiver.byte() {
            take(chain, byte, board.wires.is_in_service());
        }
        if B::is_free()
            && let Some(byte) = chain.next_byte()
        {
            B::send(byte);
        }
        // First, so that after a tick that comes in between it is not the time until the next one.
        let left = beat::left();
        let now = beat::ticks();
        if now == last {
            if !keeper.step_within(left) {
                check(checks, left, chain);
            }
            continue;
        }
        last = now;
        let time_us = clock.at(now).saturating_mul(PERIOD_US.into());
        let outcome = tick(chain, time_us, &mut board.cycles, &mut dog);
        board.wires.put_out(&outcome.outputs);
        tell(&outcome);
        keeper.look(chain);
        checks.ticked();
        if board.receiver.lost() != lost {
            lost = board.receiver.lost();
            defmt::warn!("receiver lost {=u32} bytes at least", lost);
        }
    }
}

/// Ticks as they are asked for: the monitor's work is then a matter of the bytes alone, and can be held
/// against another machine.
fn in_lock_step<B: Board, S: Sensors>(
    chain: &mut BoardChain<S>,
    mut board: Started<B>,
    mut keeper: Keeper<B::Cells>,
    checks: &mut SelfCheck<'_>,
) -> ! {
    let mut dog = Dog::patient(board.watchdogs);
    let mut time_us = 0_u64;
    loop {
        let Some(byte) = B::received() else {
            dog.feed();
            keeper.step();
            check(checks, u32::MAX, chain);
            // An emulator gets no further while its registers are looked at.
            cortex_m::asm::delay(4000);
            continue;
        };
        let Some(room) = take(chain, byte, board.wires.is_in_service()) else {
            continue;
        };
        let outcome = tick(chain, time_us, &mut board.cycles, &mut dog);
        board.wires.put_out(&outcome.outputs);
        tell(&outcome);
        keeper.look(chain);
        checks.ticked();
        time_us = time_us.saturating_add(PERIOD_US.into());
        for _ in 0..room {
            let Some(byte) = chain.next_byte() else {
                break;
            };
            B::send(byte);
        }
    }
}

/// Alarms go into the log, too.
fn tell(outcome: &Outcome) {
    for change in &outcome.changes {
        defmt::warn!("alarm {=str}: {}", change.alarm.name(), change.change);
    }
}

/// A step of the self-checks between ticks, if there is time for one.
fn check<S: Sensors>(checks: &mut SelfCheck<'_>, left: u32, chain: &mut BoardChain<S>) {
    let before = checks.report();
    if check_step(checks, left) {
        checks.tell(before);
        chain.set_board(checks.report());
    }
}

// All that is to be proved free of panics, kept apart from `run`, which has some: `cargo check-firmware`
// looks at what these call.

#[inline(never)]
fn recall<C: Cells>(cells: C, cause: ResetCause) -> (Store<Flash<C>>, Past) {
    Store::open(Flash(cells), IDENTITY, cause)
}

#[inline(never)]
fn keep<C: Cells>(store: &mut Store<Flash<C>>) -> bool {
    store.step()
}

#[inline(never)]
fn check_step(checks: &mut SelfCheck<'_>, left: u32) -> bool {
    checks.step_within(left)
}

#[inline(never)]
fn take<S: Sensors>(chain: &mut BoardChain<S>, byte: u8, service: bool) -> Option<u16> {
    chain.push(byte, service)
}

#[inline(never)]
fn tick<S: Sensors>(
    chain: &mut BoardChain<S>,
    time_us: u64,
    cycles: &mut Cycles,
    watchdog: &mut impl Watchdog,
) -> Outcome {
    chain.tick(time_us, cycles, watchdog)
}
