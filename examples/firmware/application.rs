//! The monitor's application, the same on every board: loads and speed in, alarms and telemetry out. The
//! board is `super::board`, the spindle `super::monitored` and `super::monitor_settings`, and all that needs no
//! hardware `super::chain`.

use super::board::{self, Board, Cycles, Dog, Measured, Memory};
use super::chain::{Chain, Sensors};
use super::monitor_settings::{BRIDGES, IDENTITY, MONITOR};
use super::self_check::SelfCheck;
use spindle_monitor::board::ResetCause;
use spindle_monitor::retained::WriteError;
use spindle_monitor::tick::{Watchdog, Widened};
use spindle_monitor::{Outcome, Past, Store};

/// Takes the board, and never gives it back.
pub fn run() -> ! {
    let Some(mut board) = board::start() else {
        unreachable!("main runs once, and takes the peripherals once");
    };
    defmt::info!(
        "ready: core at {=u32} MHz, clock {}, {=u32} baud, ticks by {=str}",
        board.clock.core_hz / 1_000_000,
        board.clock.source,
        board::BAUD,
        if board.lock_step {
            "the port"
        } else {
            "the timer"
        }
    );
    defmt::info!("started by {=str}", board.reset.name());
    if board.report.brown_out == Some(0) {
        defmt::warn!(
            "brown-out reset is off: the chip runs on where the supply is too low for its flash"
        );
    }
    board::feed_at_start();
    let (keeper, past) = Keeper::start(board.memory.take(), board.reset, board.clock.core_hz);
    // The compiler leaves out what is not chosen.
    if BRIDGES && let Some(sensors) = board.sensors.take() {
        let chain = cortex_m::singleton!(: Chain<Measured> = Chain::with(sensors, &past));
        with(chain, board, keeper)
    } else {
        let chain = cortex_m::singleton!(: Chain = Chain::new(&past));
        with(chain, board, keeper)
    }
}

/// Keeps life and alarms over a power cycle, where the board has a memory for them.
struct Keeper {
    store: Option<Store<Memory>>,
    /// Cycles of the core that a step may take.
    step: u32,
    /// Ticks since there was time for one.
    waited: u16,
    /// Failures that the log knows of.
    told: u32,
}

/// Time for a step, us: to write a unit takes 100 us at worst, to make a record and its checksum some thousand
/// instructions.
const STEP_US: u32 = 300;
/// A core that is always late takes the time for a step after so many ticks.
const PATIENCE: u16 = 1000;

impl Keeper {
    /// Reads what was kept. May take some seconds, if there is something to erase.
    fn start(memory: Option<Memory>, cause: ResetCause, core_hz: u32) -> (Self, Past) {
        let (store, past) = match memory {
            None => {
                defmt::warn!("no flash to write: life and alarms are lost with the power");
                (None, Past::without_memory(cause))
            }
            Some(memory) => {
                let (store, past) = recall(memory, cause);
                let report = store.report();
                defmt::info!(
                    "start {=u32}, life and alarms over the power cycle: {=str}, {=u16} damaged records",
                    past.start.boots,
                    report.recovery.name(),
                    report.damaged
                );
                (Some(store), past)
            }
        };
        let step = core_hz / 1_000_000 * STEP_US;
        let mut keeper = Self {
            store,
            step,
            waited: 0,
            told: 0,
        };
        keeper.tell();
        (keeper, past)
    }

    /// After a tick.
    fn look<S: Sensors>(&mut self, chain: &mut Chain<S>) {
        if let Some(store) = &mut self.store {
            chain.retain(store);
            self.waited = self.waited.saturating_add(1);
            if self.waited >= PATIENCE {
                self.step();
            }
        }
    }

    /// Between ticks, so many cycles before the next one. Whether there was something to do.
    fn step_within(&mut self, left: u32) -> bool {
        left > self.step && self.step()
    }

    fn step(&mut self) -> bool {
        self.waited = 0;
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
fn with<S: Sensors>(chain: Option<&'static mut Chain<S>>, mut board: Board, keeper: Keeper) -> ! {
    let Some(chain) = chain else {
        unreachable!("main runs once, and makes one monitor");
    };
    board::feed_at_start();
    if let Err(status) = chain.prepare() {
        defmt::warn!("no equilibrium to start from: {=str}", status.name());
    }
    let core_hz = board.clock.core_hz;
    let started = SelfCheck::start(board.report, board.lock_step, core_hz, &mut board.cycles);
    let Some(checks) = cortex_m::singleton!(: SelfCheck = started) else {
        unreachable!("main runs once, and checks one board");
    };
    chain.set_board(checks.report());
    board::feed_at_start();
    if board.lock_step {
        in_lock_step(chain, board, keeper, checks)
    } else {
        by_the_timer(chain, board, keeper, checks)
    }
}

/// Ticks by the timer. Between them, bytes come in and go out.
fn by_the_timer<S: Sensors>(
    chain: &mut Chain<S>,
    mut board: Board,
    mut keeper: Keeper,
    checks: &mut SelfCheck,
) -> ! {
    board::start_timer(board.timer, board.clock.core_hz, MONITOR.tick.period_us);
    let mut dog = Dog::strict(board.iwdg, board.window, &board.clock);
    let mut last = board::ticks();
    let mut clock = Widened::new(32, last);
    let mut lost = 0;
    loop {
        while let Some(byte) = board.receiver.byte() {
            take(chain, byte, board.service.is_on());
        }
        if board::is_free()
            && let Some(byte) = chain.next_byte()
        {
            board::send(byte);
        }
        // First, so that after a tick that comes in between it is not the time until the next one.
        let left = board::left();
        let now = board::ticks();
        if now == last {
            if !keeper.step_within(left) {
                check(checks, left, chain);
            }
            continue;
        }
        last = now;
        let time_us = clock.at(now).saturating_mul(MONITOR.tick.period_us.into());
        let outcome = tick(chain, time_us, &mut board.cycles, &mut dog);
        tell(&outcome);
        keeper.look(chain);
        checks.ticked();
        if board.receiver.lost() != lost {
            lost = board.receiver.lost();
            defmt::warn!("receiver lost {=u32} bytes", lost);
        }
    }
}

/// Ticks as they are asked for: the monitor's work is then a matter of the bytes alone, and can be held
/// against another machine.
fn in_lock_step<S: Sensors>(
    chain: &mut Chain<S>,
    mut board: Board,
    mut keeper: Keeper,
    checks: &mut SelfCheck,
) -> ! {
    let mut dog = Dog::patient(board.iwdg);
    let mut time_us = 0_u64;
    loop {
        let Some(byte) = board::received() else {
            dog.feed();
            keeper.step();
            check(checks, u32::MAX, chain);
            // An emulator gets no further while its registers are looked at.
            cortex_m::asm::delay(4000);
            continue;
        };
        let Some(room) = take(chain, byte, board.service.is_on()) else {
            continue;
        };
        let outcome = tick(chain, time_us, &mut board.cycles, &mut dog);
        tell(&outcome);
        keeper.look(chain);
        checks.ticked();
        time_us = time_us.saturating_add(MONITOR.tick.period_us.into());
        for _ in 0..room {
            let Some(byte) = chain.next_byte() else {
                break;
            };
            board::send(byte);
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
fn check<S: Sensors>(checks: &mut SelfCheck, left: u32, chain: &mut Chain<S>) {
    let before = checks.report();
    if check_step(checks, left) {
        checks.tell(before);
        chain.set_board(checks.report());
    }
}

// All that is to be proved free of panics, kept apart from `run`, which has some: `cargo check-firmware`
// looks at what these call.

#[inline(never)]
fn recall(memory: Memory, cause: ResetCause) -> (Store<Memory>, Past) {
    Store::open(memory, IDENTITY, cause)
}

#[inline(never)]
fn keep(store: &mut Store<Memory>) -> bool {
    store.step()
}

#[inline(never)]
fn check_step(checks: &mut SelfCheck, left: u32) -> bool {
    checks.step_within(left)
}

#[inline(never)]
fn take<S: Sensors>(chain: &mut Chain<S>, byte: u8, service: bool) -> Option<u16> {
    chain.push(byte, service)
}

#[inline(never)]
fn tick<S: Sensors>(
    chain: &mut Chain<S>,
    time_us: u64,
    cycles: &mut Cycles,
    watchdog: &mut impl Watchdog,
) -> Outcome {
    chain.tick(time_us, cycles, watchdog)
}
