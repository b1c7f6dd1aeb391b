//! The monitor's application, the same on every board: loads and speed in, alarms and telemetry out. The
//! board is `super::board`, the spindle `super::monitored` and `super::monitor_settings`, and all that needs no hardware `super::chain`.

use super::board::{self, Board, Cycles, Dog, Measured};
use super::chain::{Chain, Sensors};
use super::monitor_settings::{BRIDGES, MONITOR};
use spindle_bearing::monitor::Outcome;
use spindle_bearing::monitor::tick::{Watchdog, Widened};

/// Takes the board, and never gives it back.
pub fn run() -> ! {
    let Some(mut board) = board::start() else {
        unreachable!("main runs once, and takes the peripherals once");
    };
    // The compiler leaves out what is not chosen.
    if BRIDGES && let Some(sensors) = board.sensors.take() {
        let chain = cortex_m::singleton!(: Chain<Measured> = Chain::with(sensors));
        with(chain, board)
    } else {
        with(cortex_m::singleton!(: Chain = Chain::new()), board)
    }
}

/// Runs a chain.
fn with<S: Sensors>(chain: Option<&'static mut Chain<S>>, board: Board) -> ! {
    let Some(chain) = chain else {
        unreachable!("main runs once, and makes one monitor");
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
    if let Err(status) = chain.prepare() {
        defmt::warn!("no equilibrium to start from: {=str}", status.name());
    }
    if board.lock_step {
        in_lock_step(chain, board)
    } else {
        by_the_timer(chain, board)
    }
}

/// Ticks by the timer. Between them, bytes come in and go out.
fn by_the_timer<S: Sensors>(chain: &mut Chain<S>, mut board: Board) -> ! {
    board::start_timer(board.timer, board.clock.core_hz, MONITOR.tick.period_us);
    let mut dog = Dog::start(board.iwdg);
    let mut last = board::ticks();
    let mut clock = Widened::new(32, last);
    let mut lost = 0;
    loop {
        while let Some(byte) = board.receiver.byte() {
            take(chain, byte);
        }
        if board::is_free()
            && let Some(byte) = chain.next_byte()
        {
            board::send(byte);
        }
        let now = board::ticks();
        if now == last {
            continue;
        }
        last = now;
        let time_us = clock.at(now).saturating_mul(MONITOR.tick.period_us.into());
        let outcome = tick(chain, time_us, &mut board.cycles, &mut dog);
        tell(&outcome);
        if board.receiver.lost() != lost {
            lost = board.receiver.lost();
            defmt::warn!("receiver lost {=u32} bytes", lost);
        }
    }
}

/// Ticks as they are asked for: what the monitor does is then a matter of the bytes alone, and can be held
/// against another machine.
fn in_lock_step<S: Sensors>(chain: &mut Chain<S>, mut board: Board) -> ! {
    let mut dog = Dog::asleep();
    let mut time_us = 0_u64;
    loop {
        let Some(byte) = board::received() else {
            // An emulator gets no further while its registers are looked at.
            cortex_m::asm::delay(4000);
            continue;
        };
        let Some(room) = take(chain, byte) else {
            continue;
        };
        let outcome = tick(chain, time_us, &mut board.cycles, &mut dog);
        tell(&outcome);
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

// All that is to be proved free of panics, kept apart from `run`, which has some: `cargo check-firmware`
// looks at what these two call.

#[inline(never)]
fn take<S: Sensors>(chain: &mut Chain<S>, byte: u8) -> Option<u16> {
    chain.push(byte)
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
