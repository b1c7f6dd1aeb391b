//! The bench of a board: cycles of every scene beside the modelled ones, hashes of its answers beside the host's.

use crate::solves::{CASES, KINDS, Solves, Work};
use core::fmt::{Arguments, Display, Formatter, Result};
use cortex_m::asm::semihosting_syscall;
use defmt::Display2Format;
use spindle_firmware::board::{Board, Started};
use spindle_firmware::dog::Watchdogs;
use spindle_firmware::log;
use spindle_monitor::tick::CycleCounter;
use table::{ROWS, WORKS};

/// The cases, and the scenes of this board.
#[allow(clippy::approx_constant, reason = "numbers as a program writes them")]
mod table {
    use super::Row;
    use crate::solves::{self, CASES, Work};
    use crate::{Axial, Clamped, Elastic, Ring, Sprung};
    use spindle_bearing::{Centrifugal, InnerRaceControl, OuterRaceControl};
    use spindle_bearing::{Design, FreeContact, Material, RacewayControlFree, Static};

    include!(env!(
        "BENCH_TABLE",
        "`cargo bench-f405` writes the table, then builds this"
    ));
}

/// A scene on this board.
struct Row {
    name: &'static str,
    run: fn(&[Work; CASES], &mut dyn FnMut() -> u32) -> [Solves; 3],
    /// The host's hash and the modelled median, cycles, of each kind of solve.
    expected: [(u32, Option<u32>); 3],
}

/// A number that may be missing.
struct Cell<T>(Option<T>);

impl<T: Display> Display for Cell<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match &self.0 {
            Some(number) => number.fmt(f),
            None => f.pad("-"),
        }
    }
}

fn print(line: Arguments<'_>) {
    defmt::println!("{}", Display2Format(&line));
    log::finish();
}

/// Runs every scene, prints the table, and ends the program: with an error where a hash is not the host's.
pub fn run<B: Board>(mut board: Started<B>) -> ! {
    let mhz = board.core_hz / 1_000_000;
    print(format_args!("core at {mhz} MHz, clock {}", board.clock));
    print(format_args!(
        "{:<24} {:<9} {:>8} {:>8} {:>8} {:>5}  {:<8} {}",
        "scene", "solve", "median", "worst", "modelled", "ratio", "hash", "host's"
    ));
    let mut now = || {
        B::Watchdogs::feed_independent();
        board.cycles.cycles()
    };
    let away = |ratio: f32| ratio.max(1.0 / ratio);
    let (mut worst, mut differ) = (None, 0);
    for row in ROWS {
        let all = (row.run)(&WORKS, &mut now);
        for ((kind, mut solves), (hash, modelled)) in KINDS.iter().zip(all).zip(row.expected) {
            let cycles = solves.cycles();
            let [median, most] = [0, 1].map(|i| Cell(cycles.map(|cycles| cycles[i])));
            let ratio = median.0.zip(modelled);
            let ratio = ratio.map(|(measured, modelled)| measured as f32 / modelled as f32);
            let both = [worst, ratio].into_iter().flatten();
            worst = both.max_by(|a, b| away(*a).total_cmp(&away(*b)));
            let equal = solves.hash == hash;
            differ += u32::from(!equal);
            print(format_args!(
                "{:<24} {kind:<9} {median:>8} {most:>8} {:>8} {:>5.2}  {:08x} {hash:08x} {}",
                row.name,
                Cell(modelled),
                Cell(ratio),
                solves.hash,
                if equal { "ok" } else { "DIFFERS" }
            ));
        }
    }
    print(format_args!(
        "worst ratio {:.2}; {differ} of {} hashes differ",
        Cell(worst),
        ROWS.len() * KINDS.len()
    ));
    // Calls of a debugger and of an emulator: 0x18 ends the program, 0x20026 as it should, 0x20023 with an error.
    let how = if differ == 0 { 0x20026 } else { 0x20023 };
    loop {
        #[allow(unsafe_code, reason = "a debugger is asked")]
        // SAFETY: this call reads no memory.
        unsafe {
            semihosting_syscall(0x18, how);
        }
    }
}
