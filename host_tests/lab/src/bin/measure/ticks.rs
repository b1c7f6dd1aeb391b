//! The shipped monitor's chain, tick by tick: bytes in, doubts, a warm solve, judgement, life, bytes out.
//!
//! Input is a part of the recorded cycle under faults, then loads of passing teeth, at the pace of the port. The firmware asks
//! the counter of cycles how many rows its solve may pass; the emulated core has one. The constants of `CycleCost` cover the
//! dearest of these passes, and a tick besides them.

use crate::image::Image;
use crate::machine::Machine;
use crate::table::{markdown, thousands};
use crate::timing::Core;
use addr2line::Loader;
use anyhow::{Context, Result, anyhow, bail, ensure};
use cli::milling_cycle::record_of;
use cli::stream::{self, ROOM, Tick, faults, faults::Spoiler, records};
use cli::telemetry::simulated::MONITOR as F405;
use judge::campaign::report::Spread;
use lab::report::Figures;
use rayon::prelude::*;
use solvers::dispatch::Precision;
use spindle_firmware::chain::{self, Chain};
use spindle_firmware::spindle::{BALLS, PERIOD_US, ROWS, SPINDLE, monitor_settings};
use spindle_monitor::Past;
use spindle_monitor::record::LoadRecord;
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::tick::{self, CycleCounter, NoWatchdog, Ticker};
use std::collections::VecDeque;
use std::path::Path;

/// The part of the recorded cycle, s, and the seed of its faults: what CI runs on the emulated board.
const SECONDS: f64 = 10.0;
const SEED: u64 = 1;
/// Ticks of passing teeth after that.
const TEETH: u32 = 4000;
/// Bytes of `MEASURED_INPUT` and `MEASURED_OUTPUT`.
const INPUT: usize = 1024;
const OUTPUT: usize = 8192;

static H743: MonitorSettings<ROWS> = monitor_settings(&tick::Core::STM32H743);
const BOARDS: [Board; 2] = [
    Board {
        core: Core::M4f,
        settings: &F405,
        constant: "CORTEX_M4F",
    },
    Board {
        core: Core::M7,
        settings: &H743,
        constant: "CORTEX_M7",
    },
];

/// A counter that shows what another one has shown; 0 without one.
struct Looks<'a>(std::slice::Iter<'a, u32>);

impl CycleCounter for Looks<'_> {
    fn cycles(&mut self) -> u32 {
        self.0.next().copied().unwrap_or_default()
    }
}

/// Telemetry of a chain, tick by tick, with the looks at the counter of cycles.
type Telemetry = Box<dyn FnMut(&Tick, &[u32]) -> Vec<u8>>;

/// A board whose chain is measured.
struct Board {
    core: Core,
    settings: &'static MonitorSettings<ROWS>,
    /// Name of the firmware's constant.
    constant: &'static str,
}

/// The monitor's methods that look at the counter: those of a solve's time, and the type that has the others.
const ASKERS: [&str; 7] = [
    "has_a_row_more",
    "has_a_look",
    "has_a_report",
    "has_a_solve",
    "has_slopes",
    "has_a_step",
    "Ticker",
];

/// The one of [`ASKERS`] that the instruction at an address is of, be it inlined.
fn asker(lines: &Loader, address: u32) -> Result<&'static str> {
    let frames = lines.find_frames(address.into());
    let mut frames = frames.map_err(|error| anyhow!("{error}"))?;
    while let Some(frame) = frames.next()? {
        let function = frame.function.context("code without a name")?;
        let name = function.raw_name()?;
        if let Some(asker) = ASKERS.into_iter().find(|asker| name.contains(asker)) {
            return Ok(asker);
        }
    }
    bail!("nobody known looks at the counter of cycles at {address:#x}")
}

/// The cost of a tick.
#[derive(Debug, Clone, Copy, Default)]
struct Cost {
    cycles: u64,
    /// Rows that its solve has passed, and cycles of all passes.
    rows: u32,
    passes: u32,
    /// Cycles of the dearest pass over a row: of the first ones, with the step before it, and of others.
    dearest: [u32; 2],
    /// A pass ended with the last of its rows, so that a step followed.
    stepped: bool,
    /// Figures were taken of an equilibrium.
    ended: bool,
}

impl Cost {
    /// Of a tick with these looks at the counter by these askers, the first one at its begin. So many rows were passed `before` it.
    /// The ticker grants figures at a look as it did in the tick.
    fn of(cycles: u64, looks: &[u32], askers: &[&str], ticker: &Ticker, before: u32) -> Self {
        let mut cost = Self {
            cycles,
            ..Self::default()
        };
        let mut shown = Looks(looks[1..].iter());
        let mut time = ticker.solve_time(&mut shown, (before % ROWS as u32) as u16);
        for (asker, pair) in askers[2..].iter().zip(looks[1..].windows(2)) {
            match *asker {
                "has_a_solve" => _ = time.has_a_solve(),
                "has_a_look" => cost.ended |= time.has_a_look(),
                "has_a_report" => cost.ended |= time.has_a_report(),
                "has_a_row_more" => {
                    let pass = pair[1] - pair[0];
                    let is_first = (before + cost.rows).is_multiple_of(ROWS as u32);
                    let most = &mut cost.dearest[usize::from(!is_first)];
                    *most = (*most).max(pass);
                    cost.passes += pass;
                    cost.rows += 1;
                    time.has_a_row_more();
                }
                _ => {}
            }
        }
        cost.stepped = cost.rows > 0 && (before + cost.rows).is_multiple_of(ROWS as u32);
        cost
    }
}

/// The costs of a board's ticks.
pub struct Costs {
    board: &'static Board,
    all: Vec<Cost>,
}

impl Board {
    fn name(&self) -> String {
        format!("{}, f32, monitor", self.core.name())
    }

    /// Cycles of a period.
    fn period(&self) -> u32 {
        self.settings.tick.deadline_cycles
    }

    /// Starts the host's own build of its chain.
    fn start(&self) -> Result<Telemetry> {
        let probes = Box::leak(Box::new(chain::probes(self.settings)));
        let monitor = chain::monitor(probes, &Past::default(), self.settings);
        let mut chain = Chain::new(Box::new(monitor));
        let prepared = chain.prepare().ok();
        prepared.context("the host has no equilibrium to start from")?;
        let mut time_us = 0;
        Ok(Box::new(move |tick: &Tick, looks: &[u32]| {
            for byte in &tick.bytes {
                chain.push(*byte, false);
            }
            chain.tick(time_us, &mut Looks(looks.iter()), &mut NoWatchdog);
            time_us += u64::from(PERIOD_US);
            (0..tick.room).map_while(|_| chain.next_byte()).collect()
        }))
    }

    /// Fails if the telemetry of the core is not the host's to the last bit.
    fn measure(&'static self, image: &Image, ticks: &[Tick]) -> Result<Costs> {
        let mut host = self.start()?;
        let mut machine = Machine::new(self.core, image)?;
        let (prepared, _) = machine.call(image.symbol("measured_prepare")?)?;
        ensure!(prepared == 1, "the core has no equilibrium to start from");
        let entry = image.symbol("measured_tick")?;
        let input = image.symbol("MEASURED_INPUT")?;
        let output = image.symbol("MEASURED_OUTPUT")?;
        let words = image.symbol("MEASURED_TICK")?;
        machine.count_at(image.symbol("MEASURED_CYCLES")?)?;
        let lines = image.program.lines()?;
        let ticker = Ticker::new(&self.settings.tick, SPINDLE.ball_counts());
        let (mut all, mut passed) = (Vec::with_capacity(ticks.len()), 0);
        for (number, tick) in ticks.iter().enumerate() {
            ensure!(
                tick.bytes.len() <= INPUT && usize::from(tick.room) <= OUTPUT,
                "tick {number} has more bytes than the measured program has room for"
            );
            machine.write(input, &tick.bytes)?;
            let asked = [tick.bytes.len() as u32, tick.room.into(), 0];
            machine.write(words, &asked.map(u32::to_le_bytes).concat())?;
            let (_, count) = machine.call(entry)?;
            let sent = machine.word(words + 8)? as usize;
            let looks = machine.looks();
            ensure!(
                machine.read(output, sent)? == host(tick, looks),
                "tick {number}: the core's telemetry is not the host's"
            );
            let askers = machine.lookers().iter().map(|at| asker(&lines, *at));
            let askers = askers.collect::<Result<Vec<_>>>()?;
            let cost = Cost::of(count.cycles, looks, &askers, &ticker, passed);
            passed += cost.rows;
            all.push(cost);
        }
        Ok(Costs { board: self, all })
    }
}

impl Costs {
    /// Cycles besides the passes: of ticks without a step after the last row in which no solve ends, all but a tenth; of ticks in which
    /// one ends, all but a tenth, and all but a thousandth. Estimates are reported in fewer than a tenth of the ticks.
    fn besides(&self) -> [u64; 3] {
        let of = |ended: bool, one_in: usize| {
            let is_such = |cost: &&Cost| cost.ended == ended && (ended || !cost.stepped);
            let such = self.all.iter().filter(is_such);
            let besides = such.map(|cost| cost.cycles - u64::from(cost.passes));
            let mut besides: Vec<u64> = besides.collect();
            besides.sort_unstable();
            let most = besides.len().saturating_sub(1 + besides.len() / one_in);
            besides.get(most).copied().unwrap_or_default()
        };
        [of(false, 10), of(true, 10), of(true, 1000)]
    }

    /// Cycles of the dearest pass over a row: of the first ones, with the step before it, and of others.
    fn dearest(&self) -> [u64; 2] {
        [0, 1].map(|place| {
            let dearest = self.all.iter().map(|cost| u64::from(cost.dearest[place]));
            dearest.max().unwrap_or_default()
        })
    }

    /// Cycles of a tick.
    fn spread(&self) -> Spread {
        Spread::of(self.all.iter().map(|cost| cost.cycles as f64))
    }

    fn figures(&self) -> [(String, u64); 8] {
        let spread = self.spread();
        let [unfinished, ended, reported] = self.besides();
        let [first, row] = self.dearest();
        [
            (UNFINISHED, unfinished),
            (ENDED, ended),
            (REPORTED, reported),
            (FIRST, first),
            (ROW, row),
            (MEDIAN, spread.median as u64),
            (MOST, spread.most as u64),
            (WORST, spread.worst as u64),
        ]
        .map(|(metric, cycles)| (format!("{}: {metric}", self.board.name()), cycles))
    }
}

/// The figure that README shows.
pub const MEDIAN: &str = "cycles of a tick, median";
const MOST: &str = "cycles of a tick, 99 %";
const WORST: &str = "cycles of a tick, worst";
const ROW: &str = "cycles of the dearest pass over a row";
const FIRST: &str = "cycles of the dearest step and pass over the first row";
const UNFINISHED: &str = "cycles besides passes, no solve ends, 90 %";
const ENDED: &str = "cycles besides passes, a solve ends, 90 %";
const REPORTED: &str = "cycles besides passes, a solve ends, 99.9 %";
/// Part by which the constants of the firmware may be above the figures. They are not below. A tick in which no solve ends may be any
/// that the loads make, and the dearest step and the dearest row do not meet: their constants have no upper bound.
const ABOVE: f64 = 0.05;

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
    let (held, part, arm) = match ROWS {
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
    let record = record_of(ROWS);
    let mut recording = records::read(record, &[], Some(SECONDS), PERIOD_US)?;
    let episodes = faults::schedule(SEED, &recording.records);
    let mut spoiler = Spoiler::new(SEED, episodes);
    let teeth = teeth(&recording.records);
    recording.records.extend(teeth);
    if let Some(last) = recording.temperatures.last() {
        recording
            .temperatures
            .resize(recording.records.len(), *last);
    }
    let mut board = BOARDS[0].start()?;
    let ticks = stream::ticks(&recording, &mut spoiler, |tick| Ok(board(tick, &[])))?;
    let ticks = paced(ticks);
    let images = BOARDS
        .iter()
        .map(|board| Image::build(root, board.core, "measured_chain", Precision::F32, None))
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
        let (spread, period) = (costs.spread(), costs.board.period());
        let beyond = costs.all.iter().filter(|cost| cost.cycles > period.into());
        let rows = costs.all.iter().map(|cost| cost.rows).max();
        let mut line = vec![costs.board.name(), thousands(period.into())];
        let ticks = [spread.median, spread.most, spread.worst];
        line.extend(ticks.map(|cycles| thousands(cycles as u64)));
        line.extend(costs.besides().map(thousands));
        line.extend(costs.dearest().map(thousands));
        line.push(rows.unwrap_or_default().to_string());
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
         Cycles of the shipped firmware's chain (`examples/firmware/src/chain.rs`): bytes of the port, the passes of a solve, limits, \
         alarms, life, telemetry. The input is the first {SECONDS} s of the recorded cycle with the faults of \
         `cargo emulate --faults`, then {TEETH} ticks of passing teeth. Interrupts and the log are not counted. The telemetry of both \
         cores equals that of the host to the last bit.\n\n{}\n\
         *Besides* covers everything but the passes over rows of balls: in ticks in which no solve ends and no step follows the last row, 90 %; in ticks in which one \
         ends, 90 %, and 99.9 %, with reports. A tick begins another row only if the dearest one still fits into a period of 1 ms. A tick beyond the period lets the next one begin late, and is \
         counted as an overrun.\n\n",
        markdown(
            "board | period | median | 99 % | worst | besides: no end | an end | with a report | dearest first row | another row | most rows | beyond the period",
            &lines
        ),
    )
}

/// Constants of the firmware's deadline that are below these figures, or far above them.
pub fn other_constants(figures: &Figures) -> Vec<String> {
    let (rows, balls) = (ROWS as u32, BALLS as u32);
    let of_board = |board: &Board| {
        let tick = board.settings.tick.cost.tick;
        let cost = board.settings.tick.cost.of(rows, rows * balls, balls);
        let ended = tick + cost.step + cost.open + rows * cost.look;
        let said = [
            (UNFINISHED, tick),
            (ENDED, ended),
            (REPORTED, ended + cost.report),
            (FIRST, cost.step + cost.row),
            (ROW, cost.row),
        ];
        let said = said.map(|(metric, cycles)| (format!("{}: {metric}", board.name()), cycles));
        let others = said.into_iter().filter_map(|(what, cycles)| {
            let figure = *figures.get(&what)?;
            let is_any = what.ends_with(UNFINISHED) || what.ends_with(FIRST);
            let most = figure as f64 * (1.0 + ABOVE);
            let fits = u64::from(cycles) >= figure && (is_any || f64::from(cycles) <= most);
            let constant = board.constant;
            let text = || format!("{what}: {figure}, and CycleCost::{constant} has {cycles}");
            (!fits).then(text)
        });
        others.collect::<Vec<_>>()
    };
    BOARDS.iter().flat_map(of_board).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_between_looks_at_the_counter() {
        let ticker = Ticker::new(&F405.tick, SPINDLE.ball_counts());
        let [first, row] = ["Ticker", "has_a_row_more"];
        let askers = [
            first,
            first,
            "has_a_solve",
            row,
            row,
            row,
            "has_a_look",
            first,
        ];
        // A pair, whose next row is the second one. Figures are taken of its equilibrium, or no time is left for them.
        for (look, ended) in [(320, true), (150_000, false)] {
            let looks = [10, 90, 100, 150, 250, 300, look, 160_000];
            let cost = Cost::of(1000, &looks, &askers, &ticker, 1);
            assert_eq!((cost.dearest, cost.passes), ([100, 50], 200));
            assert_eq!((cost.rows, cost.ended), (3, ended));
        }
        let cost = Cost::of(500, &[10, 100, 400], &[first; 3], &ticker, 0);
        assert_eq!((cost.dearest, cost.passes), ([0; 2], 0));
    }

    #[test]
    fn constants_that_do_not_fit_the_figures_are_named() {
        let board = &BOARDS[0];
        let row = u64::from(
            board
                .settings
                .tick
                .cost
                .of(ROWS as u32, (ROWS * BALLS) as u32, BALLS as u32)
                .row,
        );
        let figures = |row: u64| Figures::from([(format!("{}: {ROW}", board.name()), row)]);
        assert!(other_constants(&figures(row)).is_empty());
        for other in [row + 1, row / 2] {
            let named = other_constants(&figures(other));
            assert!(
                matches!(&*named, [text] if text.contains(board.constant)),
                "{named:?}"
            );
        }
    }
}
