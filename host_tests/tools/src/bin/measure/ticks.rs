//! The shipped monitor's chain, tick by tick: bytes in, doubts, a warm solve, judgement, life, bytes out.
//!
//! Input is a part of the recorded cycle under faults, then loads of passing teeth, at the pace of the port.
//! The constants of `CycleCost` are made of it: the cost of an iteration, and of a tick besides iterations. The
//! firmware works out how many iterations fit.

use crate::image::Image;
use crate::machine::Machine;
use crate::table::{markdown, thousands};
use crate::timing::Core;
use anyhow::{Context, Result, ensure};
use host_tests::campaign::report::{Spread, name};
use host_tests::dispatch::Precision;
use host_tests::milling_cycle::record_of;
use rayon::prelude::*;
use spindle_bearing::monitor::Past;
use spindle_bearing::monitor::tick::{CycleCost, NoCycles, NoWatchdog, TickSettings};
use spindle_bearing::record::LoadRecord;
use std::collections::VecDeque;
use std::path::Path;
use tools::report::Figures;
use tools::stream::{self, ROOM, Tick, faults, faults::Spoiler, records};

/// The part of the recorded cycle, s, and the seed of its faults: what CI runs on the emulated board.
const SECONDS: f64 = 10.0;
const SEED: u64 = 1;
/// Ticks of passing teeth after that.
const TEETH: u32 = 4000;
/// Bytes of `MEASURED_INPUT` and `MEASURED_OUTPUT`.
const INPUT: usize = 1024;
const OUTPUT: usize = 8192;

/// A board, and the host's own build of its chain.
macro_rules! board {
    ($board:ident, $core:ident, $precision:ident, $real:ty, $hz:literal, $single:ident, $pair:ident) => {
        #[path = "."]
        mod $board {
            use super::{Board, Context, Core, NoCycles, NoWatchdog, Past, Tick};
            use host_tests::dispatch::Precision as Name;
            use spindle_bearing::monitor::tick::CycleCost;
            pub type Precision = $real;
            pub const CORE_HZ: u32 = $hz;
            pub const COST: [CycleCost; 2] = [
                CycleCost::$single.with_an_iteration_more(CORE_HZ / 1000),
                CycleCost::$pair.with_an_iteration_more(CORE_HZ / 1000),
            ];
            #[path = "../../../../../examples/firmware/chain.rs"]
            pub mod chain;
            #[path = "../../../../../examples/firmware/monitor_settings.rs"]
            pub mod monitor_settings;
            #[path = "../../../../../examples/firmware/monitored.rs"]
            pub mod monitored;

            pub const BOARD: Board = Board {
                core: Core::$core,
                precision: Name::$precision,
                settings: &monitor_settings::MONITOR.tick,
                cost: [CycleCost::$single, CycleCost::$pair][(monitored::ROWS > 1) as usize],
                constant: [stringify!($single), stringify!($pair)][(monitored::ROWS > 1) as usize],
                start: || {
                    let mut chain = chain::Chain::new(&Past::NONE);
                    let prepared = chain.prepare().ok();
                    prepared.context("the host has no equilibrium to start from")?;
                    let period = u64::from(monitor_settings::MONITOR.tick.period_us);
                    let mut time_us = 0;
                    Ok(Box::new(move |tick: &Tick| {
                        for byte in &tick.bytes {
                            chain.push(*byte, false);
                        }
                        chain.tick(time_us, &mut NoCycles, &mut NoWatchdog);
                        time_us += period;
                        (0..tick.room).map_while(|_| chain.next_byte()).collect()
                    }))
                },
            };
        }
    };
}
board!(
    f405,
    M4f,
    F32,
    f32,
    168_000_000,
    CORTEX_M4F_SINGLE,
    CORTEX_M4F
);
board!(h743, M7, F64, f64, 400_000_000, CORTEX_M7_SINGLE, CORTEX_M7);
const BOARDS: [Board; 2] = [f405::BOARD, h743::BOARD];

/// Telemetry of a chain, tick by tick.
type Telemetry = Box<dyn FnMut(&Tick) -> Vec<u8>>;

/// A board whose chain is measured.
struct Board {
    core: Core,
    precision: Precision,
    /// One iteration more than the firmware allows is measured.
    settings: &'static TickSettings,
    /// The firmware's constant for the monitored rows, and its name.
    cost: CycleCost,
    constant: &'static str,
    /// Starts the host's build.
    start: fn() -> Result<Telemetry>,
}

/// The cost of a tick.
#[derive(Debug, Clone, Copy)]
struct Cost {
    cycles: u64,
    iterations: u32,
}

/// The costs of a board's ticks.
pub struct Costs {
    board: &'static Board,
    all: Vec<Cost>,
}

impl Board {
    fn name(&self) -> String {
        format!("{}, {}, monitor", self.core.name(), name(self.precision))
    }

    /// Cycles of a period.
    fn period(&self) -> u32 {
        self.settings.deadline_cycles
    }

    /// Fails if the telemetry of the core is not the host's to the last bit.
    fn measure(&'static self, image: &Image, ticks: &[Tick]) -> Result<Costs> {
        let mut host = (self.start)()?;
        let mut machine = Machine::new(self.core, image)?;
        let (prepared, _) = machine.call(image.symbol("measured_prepare")?)?;
        ensure!(prepared == 1, "the core has no equilibrium to start from");
        let entry = image.symbol("measured_tick")?;
        let input = image.symbol("MEASURED_INPUT")?;
        let output = image.symbol("MEASURED_OUTPUT")?;
        let words = image.symbol("MEASURED_TICK")?;
        let mut all = Vec::with_capacity(ticks.len());
        for (number, tick) in ticks.iter().enumerate() {
            ensure!(
                tick.bytes.len() <= INPUT && usize::from(tick.room) <= OUTPUT,
                "tick {number} has more bytes than the measured program has room for"
            );
            machine.write(input, &tick.bytes)?;
            let asked = [tick.bytes.len() as u32, tick.room.into(), 0, 0];
            machine.write(words, &asked.map(u32::to_le_bytes).concat())?;
            let (_, count) = machine.call(entry)?;
            let sent = machine.word(words + 8)? as usize;
            ensure!(
                machine.read(output, sent)? == host(tick),
                "tick {number}: the core's telemetry is not the host's"
            );
            all.push(Cost {
                cycles: count.cycles,
                iterations: machine.word(words + 12)?,
            });
        }
        Ok(Costs { board: self, all })
    }
}

impl Costs {
    /// Solves within a bound on iterations; what starts from nothing may pass it.
    fn within(&self, iterations: u16) -> impl Iterator<Item = &Cost> {
        let warm = 1..=u32::from(iterations);
        let all = self.all.iter();
        all.filter(move |cost| warm.contains(&cost.iterations))
    }

    /// The constant that the board should have. The solves are those within the iterations of the measurement, one more than
    /// the firmware's.
    fn constant(&self) -> CycleCost {
        let warm = self.within(self.board.settings.max_iterations());
        let warm: Vec<[f64; 2]> = warm
            .map(|cost| [cost.iterations.into(), cost.cycles as f64])
            .collect();
        let [x, y] = [0, 1].map(|i| {
            let sum: f64 = warm.iter().map(|point| point[i]).sum();
            sum / warm.len().max(1) as f64
        });
        // The slope of the line through all cycles over their iterations.
        let products: f64 = warm.iter().map(|[n, cycles]| (n - x) * (cycles - y)).sum();
        let squares: f64 = warm.iter().map(|[n, _]| (n - x) * (n - x)).sum();
        // Where all have as many iterations, there is no line: those are dear then.
        let iteration = if squares > 0.0 {
            products / squares
        } else {
            y / x.max(1.0)
        }
        .ceil();
        let besides = warm.iter().map(|[n, cycles]| cycles - n * iteration);
        let mut besides: Vec<f64> = besides.collect();
        besides.sort_unstable_by(f64::total_cmp);
        let most = besides.len().saturating_sub(1 + besides.len() / RARE);
        CycleCost {
            fixed: besides.get(most).map_or(0, |cycles| cycles.ceil() as u32),
            iteration: iteration as u32,
        }
    }

    /// Cycles of a tick with a solve within the firmware's iterations.
    fn spread(&self) -> Spread {
        let allowed = self.within(self.board.cost.iterations_within(self.board.period()));
        Spread::of(allowed.map(|cost| cost.cycles as f64))
    }

    fn figures(&self) -> [(String, u64); 5] {
        let CycleCost { fixed, iteration } = self.constant();
        let spread = self.spread();
        [
            (FIXED, fixed.into()),
            (ITERATION, iteration.into()),
            (MEDIAN, spread.median as u64),
            (MOST, spread.most as u64),
            (WORST, spread.worst as u64),
        ]
        .map(|(metric, cycles)| (format!("{}: {metric}", self.board.name()), cycles))
    }
}

/// The figure that README shows.
pub const MEDIAN: &str = "cycles of a tick with a warm solve, median";
const MOST: &str = "cycles of a tick with a warm solve, 99 %";
const WORST: &str = "cycles of a tick with a warm solve, worst";
const ITERATION: &str = "cycles of an iteration";
const FIXED: &str = "cycles of a tick but for iterations, of all but one in a thousand";
/// One tick in so many may cost more than the constants say.
const RARE: usize = 1000;

/// Records that follow these: each tooth presses the shaft with a half-sine. There are two loads and three rates, with
/// and without pauses. A pair is loaded at the nose of the shaft, a single bearing at its centre.
fn teeth(before: &[LoadRecord]) -> Vec<LoadRecord> {
    const CUTS: [(f64, f64, f64); 8] = [
        (125.0, 1000.0, 1.0),
        (125.0, 1000.0, 0.5),
        (200.0, 1000.0, 1.0),
        (200.0, 1000.0, 0.5),
        (400.0, 1000.0, 1.0),
        (400.0, 1000.0, 0.5),
        (200.0, 500.0, 0.5),
        (400.0, 500.0, 0.5),
    ];
    let Some(last) = before.last() else {
        return Vec::new();
    };
    let (held, part, arm) = match f405::monitored::ROWS {
        1 => (420.0, 1.0, 0.0),
        _ => (0.0, 0.55, -0.05),
    };
    let record = |tick: u32| {
        let cut = tick as usize * CUTS.len() / TEETH as usize;
        let (per_second, amplitude, in_cut) = CUTS[cut];
        // A little off the rate of the ticks, which thereby meet every part of the half-sine.
        let phase = (per_second * 1.0007e-3 * f64::from(tick))
            .fract()
            .min(in_cut);
        let tooth = part * amplitude * (std::f64::consts::PI * phase / in_cut).sin();
        // No channel is stuck.
        let noise = (f64::from(tick) * 0.618_034).fract();
        let small = |part: f64| (noise * part) as f32;
        LoadRecord {
            sequence: last.sequence + 1 + tick,
            time_ms: last.time_ms + 1 + tick,
            fx: held + small(0.4),
            fy: (0.99 * tooth) as f32 + small(1.0),
            fz: small(1.0),
            my: small(0.01),
            mz: (arm * tooth) as f32 + small(0.02),
            speed_rpm: last.speed_rpm,
        }
    };
    (0..TEETH).map(record).collect()
}

/// The stream at the pace of the port, which brings no more bytes in a tick than it takes away.
fn paced(ticks: Vec<Tick>) -> Vec<Tick> {
    let mut line = VecDeque::new();
    let pace = |tick: Tick| {
        line.extend(tick.bytes);
        let arrived = line.len().min(ROOM.into());
        Tick {
            bytes: line.drain(..arrived).collect(),
            room: tick.room.min(ROOM),
        }
    };
    ticks.into_iter().map(pace).collect()
}

/// Measures all boards.
pub fn measure(root: &Path) -> Result<Vec<Costs>> {
    let settings = &f405::monitor_settings::MONITOR;
    let record = record_of(f405::monitored::ROWS);
    let mut recording = records::read(record, Some(SECONDS), settings.tick.period_us)?;
    let episodes = faults::schedule(SEED, &recording.records);
    let mut spoiler = Spoiler::new(SEED, episodes);
    let teeth = teeth(&recording.records);
    recording.records.extend(teeth);
    if let Some(last) = recording.temperatures.last() {
        recording
            .temperatures
            .resize(recording.records.len(), *last);
    }
    let mut board = (f405::BOARD.start)()?;
    let ticks = stream::ticks(&recording, &mut spoiler, settings, |tick| Ok(board(tick)))?;
    let ticks = paced(ticks);
    let images = BOARDS
        .iter()
        .map(|board| Image::build(root, board.core, "measured_chain", board.precision, None))
        .collect::<Result<Vec<_>>>()?;
    eprintln!("the monitor on emulated cores, {} ticks", ticks.len());
    BOARDS
        .par_iter()
        .zip(&images)
        .map(|(board, image)| board.measure(image, &ticks).with_context(|| board.name()))
        .collect()
}

/// The figures of all boards.
pub fn figures(measured: &[Costs]) -> Figures {
    measured.iter().flat_map(Costs::figures).collect()
}

/// The section of the page.
pub fn section(measured: &[Costs]) -> String {
    let line = |costs: &Costs| {
        let (cost, spread, period) = (costs.constant(), costs.spread(), costs.board.period());
        let beyond = costs.all.iter().filter(|cost| cost.cycles > period.into());
        let mut line = vec![costs.board.name(), thousands(period.into())];
        let ticks = [spread.median, spread.most, spread.worst];
        line.extend(ticks.map(|cycles| thousands(cycles as u64)));
        line.extend([cost.fixed, cost.iteration].map(|cycles| thousands(cycles.into())));
        line.push(cost.iterations_within(period).to_string());
        line.push(format!(
            "{} of {}",
            beyond.count(),
            thousands(costs.all.len() as u64)
        ));
        line
    };
    let lines: Vec<Vec<String>> = measured.iter().map(line).collect();
    format!(
        "## A tick of the monitor\n\n\
         Cycles of the shipped firmware's chain (`examples/firmware/chain.rs`): bytes of the port, a warm solve, limits, alarms, \
         life, telemetry. The input is the first {SECONDS} s of the recorded cycle with the faults of `cargo emulate --faults`, \
         then {TEETH} ticks of passing teeth. Interrupts and the log are not counted. The telemetry of both cores equals that of \
         the host to the last bit.\n\n{}\n\
         *Fixed* covers everything but iterations in all ticks but one in a thousand. Fixed cycles and the allowed iterations \
         fit into a period of 1 ms. A tick beyond the period lets the next one begin late, and is counted as an overrun. \
         Beyond the period are solves from nothing, too, and solves with one iteration more than the firmware allows.\n\n",
        markdown(
            "board | period | median | 99 % | worst | fixed | an iteration | allowed | beyond the period",
            &lines
        ),
    )
}

/// Constants of the firmware's deadline that are not these figures.
pub fn other_constants(figures: &Figures) -> Vec<String> {
    let of_board = |board: &Board| {
        let said = [(FIXED, board.cost.fixed), (ITERATION, board.cost.iteration)];
        let said = said.map(|(metric, cycles)| (format!("{}: {metric}", board.name()), cycles));
        let others = said.into_iter().filter_map(|(what, cycles)| {
            let figure = *figures.get(&what)?;
            let constant = board.constant;
            let text = || format!("{what}: {figure}, and CycleCost::{constant} has {cycles}");
            (figure != u64::from(cycles)).then(text)
        });
        others.collect::<Vec<_>>()
    };
    BOARDS.iter().flat_map(of_board).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(all: &[(u64, u32)]) -> Costs {
        let cost = |&(cycles, iterations)| Cost { cycles, iterations };
        Costs {
            board: &BOARDS[0],
            all: all.iter().map(cost).collect(),
        }
    }

    #[test]
    fn no_measured_tick_but_rare_ones_takes_more_than_the_constants_say() {
        let most = u32::from(BOARDS[0].settings.max_iterations());
        let all: Vec<_> = (0..3000_u64)
            .map(|i| {
                let n = (1 + i % 3) as u32;
                (50 + 30 * u64::from(n) + i % 2, n)
            })
            .chain([(9000, most + 1), (400, 3), (130, 0)])
            .collect();
        let measured = costs(&all);
        let CycleCost { fixed, iteration } = measured.constant();
        assert!((29..=31).contains(&iteration), "{iteration}");
        let bound = |cost: &Cost| u64::from(fixed + cost.iterations * iteration);
        let beyond = measured
            .within(most as u16)
            .filter(|cost| cost.cycles > bound(cost));
        assert_eq!(beyond.count(), 1);
    }

    #[test]
    fn constants_that_are_not_the_figures_are_named() {
        let board = &BOARDS[0];
        let figures = |more: u64| {
            let name = format!("{}: {ITERATION}", board.name());
            Figures::from([(name, u64::from(board.cost.iteration) + more)])
        };
        assert!(other_constants(&figures(0)).is_empty());
        let named = other_constants(&figures(1));
        assert!(
            matches!(&*named, [text] if text.contains(board.constant)),
            "{named:?}"
        );
    }

    #[test]
    fn the_port_brings_no_more_than_it_can() {
        let tick = |bytes: u8| Tick {
            bytes: vec![bytes; bytes.into()],
            room: u16::MAX,
        };
        let paced = paced([100, 0, 1, 0].map(tick).into());
        let lengths: Vec<usize> = paced.iter().map(|t| t.bytes.len()).collect();
        assert_eq!(lengths, [46, 46, 9, 0]);
        assert!(paced.iter().all(|t| t.room == ROOM));
    }
}
