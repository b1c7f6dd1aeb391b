//! The shipped monitor's chain, tick by tick: bytes in, doubts, a warm solve, judgement, life, bytes out.
//!
//! Input is a part of the recorded cycle under faults, then loads of passing teeth, at the pace of the port.
//! The constants of `CycleCost` are made of it: what an iteration costs, and what a tick costs besides iterations. The
//! firmware works out how many iterations fit.

use crate::image::{Image, name};
use crate::machine::Machine;
use crate::profile::Profiler;
use crate::rows::{Row, Rows, Start};
use crate::terminal::thousands;
use anyhow::{Context, Result, bail, ensure};
use host_tests::campaign::report::{Spread, table};
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
use tools::timing::Core;

/// The part of the recorded cycle, s, and the seed of its faults: what CI runs on the emulated board.
const SECONDS: f64 = 10.0;
const SEED: u64 = 1;
/// Ticks of passing teeth after that.
const TEETH: u32 = 4000;
/// Bytes of `MEASURED_INPUT` and `MEASURED_OUTPUT`.
const INPUT: usize = 1024;
const OUTPUT: usize = 8192;
/// Where the constants are.
const CONSTANTS: &str = "src/monitor/cost.rs";
/// The functions whose cycles are the solve's: the first calls the second, if it is called.
const SOLVE: [&str; 2] = ["SpindleSolver::solve", "SpindleSolver::solve_at"];

/// The host's own build of what is measured.
#[path = "."]
mod f405 {
    use spindle_bearing::monitor::tick::CycleCost;
    pub type Precision = f32;
    pub const CORE_HZ: u32 = 168_000_000;
    pub const COST: [CycleCost; 2] = [
        CycleCost::CORTEX_M4F_SINGLE.with_an_iteration_more(CORE_HZ / 1000),
        CycleCost::CORTEX_M4F.with_an_iteration_more(CORE_HZ / 1000),
    ];
    #[path = "../../../../../examples/firmware/chain.rs"]
    pub mod chain;
    #[path = "../../../../../examples/firmware/monitor_settings.rs"]
    pub mod monitor_settings;
    #[path = "../../../../../examples/firmware/monitored.rs"]
    pub mod monitored;
}

/// The same for the other board.
#[path = "."]
mod h743 {
    use spindle_bearing::monitor::tick::CycleCost;
    pub type Precision = f64;
    pub const CORE_HZ: u32 = 400_000_000;
    pub const COST: [CycleCost; 2] = [
        CycleCost::CORTEX_M7_SINGLE.with_an_iteration_more(CORE_HZ / 1000),
        CycleCost::CORTEX_M7.with_an_iteration_more(CORE_HZ / 1000),
    ];
    #[path = "../../../../../examples/firmware/chain.rs"]
    pub mod chain;
    #[path = "../../../../../examples/firmware/monitor_settings.rs"]
    pub mod monitor_settings;
    #[path = "../../../../../examples/firmware/monitored.rs"]
    mod monitored;
}

/// A board whose chain is measured.
struct Board {
    core: Core,
    precision: Precision,
    core_hz: u32,
    /// By which it is measured, with one iteration more than the firmware allows.
    settings: &'static TickSettings,
    /// The firmware's constant, and its name.
    cost: CycleCost,
    constant: &'static str,
    host: fn(&[Tick]) -> Result<Vec<Vec<u8>>>,
}

/// All constants with what is said of them: those of the monitored rows are measured, the others stay.
const ALL: [(&str, CycleCost, &str); 4] = [
    (
        "CORTEX_M4F",
        CycleCost::CORTEX_M4F,
        "Cortex-M4F, single precision, two rows of 16 balls, raceway control free: modelled.",
    ),
    (
        "CORTEX_M7",
        CycleCost::CORTEX_M7,
        "Cortex-M7, double precision, likewise.",
    ),
    (
        "CORTEX_M4F_SINGLE",
        CycleCost::CORTEX_M4F_SINGLE,
        "The first with a single row of 16 balls: `SPINDLE_ROWS=1 cargo reports monitor` has measured it.",
    ),
    (
        "CORTEX_M7_SINGLE",
        CycleCost::CORTEX_M7_SINGLE,
        "The second, likewise.",
    ),
];

/// Those of the monitored rows.
const CONSTANTS_OF: [(&str, CycleCost); 2] = match f405::monitored::ROWS {
    1 => [(ALL[2].0, ALL[2].1), (ALL[3].0, ALL[3].1)],
    _ => [(ALL[0].0, ALL[0].1), (ALL[1].0, ALL[1].1)],
};

const BOARDS: [Board; 2] = [
    Board {
        core: Core::M4f,
        precision: Precision::F32,
        core_hz: f405::CORE_HZ,
        settings: &f405::monitor_settings::MONITOR.tick,
        cost: CONSTANTS_OF[0].1,
        constant: CONSTANTS_OF[0].0,
        host: f405_answers,
    },
    Board {
        core: Core::M7,
        precision: Precision::F64,
        core_hz: h743::CORE_HZ,
        settings: &h743::monitor_settings::MONITOR.tick,
        cost: CONSTANTS_OF[1].1,
        constant: CONSTANTS_OF[1].0,
        host: h743_answers,
    },
];

macro_rules! answers {
    ($start:ident, $name:ident, $board:ident) => {
        /// The host's build of the board, tick by tick.
        fn $start() -> Result<impl FnMut(&Tick) -> Vec<u8>> {
            let mut chain = $board::chain::Chain::new(&Past::NONE);
            ensure!(
                chain.prepare().is_ok(),
                "the host has no equilibrium to start from"
            );
            let period = u64::from($board::monitor_settings::MONITOR.tick.period_us);
            let mut number = 0;
            Ok(move |tick: &Tick| {
                for byte in &tick.bytes {
                    chain.push(*byte);
                }
                chain.tick(number * period, &mut NoCycles, &mut NoWatchdog);
                number += 1;
                (0..tick.room).map_while(|_| chain.next_byte()).collect()
            })
        }

        fn $name(ticks: &[Tick]) -> Result<Vec<Vec<u8>>> {
            let board = $start()?;
            Ok(ticks.iter().map(board).collect())
        }
    };
}
answers!(f405_board, f405_answers, f405);
answers!(h743_board, h743_answers, h743);

/// What a tick cost, cycles.
#[derive(Debug, Clone, Copy)]
struct Cost {
    all: u64,
    solve: u64,
    iterations: u32,
}

impl Cost {
    fn rest(&self) -> f64 {
        (self.all - self.solve) as f64
    }

    /// Cycles of the tick but for iterations of so many.
    fn besides(&self, iteration: f64) -> f64 {
        (self.all as f64 - f64::from(self.iterations) * iteration).max(0.0)
    }
}

/// The costs of a board's ticks.
struct Costs {
    board: &'static Board,
    all: Vec<Cost>,
}

impl Board {
    fn name(&self) -> String {
        format!("{}, {}", self.core.name(), name(self.precision))
    }

    fn measure(&'static self, image: &Image, ticks: &[Tick]) -> Result<Costs> {
        let expected = (self.host)(ticks)?;
        let mut machine = Machine::new(self.core, image)?;
        let mut profiler = Profiler::new(self.core, image)?;
        let prepared = machine.call(image.symbol("measured_prepare")?)?.0;
        ensure!(
            prepared == 1,
            "the core has no equilibrium to start from: {}",
            self.name()
        );
        let entry = image.symbol("measured_tick")?;
        let [input, output, words] = ["MEASURED_INPUT", "MEASURED_OUTPUT", "MEASURED_TICK"]
            .map(|symbol| image.symbol(symbol));
        let (input, output, words) = (input?, output?, words?);
        let mut all = Vec::with_capacity(ticks.len());
        for (number, (tick, expected)) in ticks.iter().zip(&expected).enumerate() {
            ensure!(
                tick.bytes.len() <= INPUT && usize::from(tick.room) <= OUTPUT,
                "tick {number} has more bytes than the measured program has room for"
            );
            machine.write(input, &tick.bytes)?;
            let told = [tick.bytes.len() as u32, tick.room.into(), 0, 0];
            machine.write(words, &told.map(u32::to_le_bytes).concat())?;
            let (_, counts) = machine.call(entry)?;
            let answer = machine.read(words, 16)?;
            let word = |i: usize| {
                let bytes = [0, 1, 2, 3].map(|j| answer[4 * i + j]);
                u32::from_le_bytes(bytes)
            };
            let (sent, iterations) = (word(2) as usize, word(3));
            if machine.read(output, sent)? != *expected {
                bail!(
                    "tick {number}, {}: the core's telemetry is not the host's",
                    self.name()
                );
            }
            let profile = profiler.profile(&machine, &counts)?;
            let of = |name: &str| profile.functions.get(name).map_or(0, |share| share.all);
            let solve = SOLVE.map(of).into_iter().fold(0, u64::max);
            ensure!(
                (iterations == 0) | (solve > 0),
                "tick {number} has {iterations} iterations, but no cycles of {}: is it called otherwise?",
                SOLVE[0]
            );
            all.push(Cost {
                all: machine.cycles(&counts),
                solve,
                iterations,
            });
        }
        Ok(Costs { board: self, all })
    }
}

impl Costs {
    /// Solves within a bound on iterations; what starts from nothing may pass it.
    fn within(&self, iterations: u16) -> impl Iterator<Item = &Cost> + Clone {
        let most = u32::from(iterations);
        self.all
            .iter()
            .filter(move |cost| cost.iterations > 0 && cost.iterations <= most)
    }

    /// Solves within the iterations of the measurement, one more than the firmware's.
    fn warm(&self) -> impl Iterator<Item = &Cost> {
        self.within(self.board.settings.max_iterations())
    }

    /// Solves within those of the firmware.
    fn allowed(&self) -> impl Iterator<Item = &Cost> {
        let deadline = self.board.settings.deadline_cycles;
        self.within(self.board.cost.iterations_within(deadline))
    }

    /// What the constant of the board should be.
    fn constant(&self) -> CycleCost {
        let iteration = self.iteration().ceil();
        let mut besides: Vec<f64> = self.warm().map(|cost| cost.besides(iteration)).collect();
        besides.sort_unstable_by(f64::total_cmp);
        let most = besides.len().saturating_sub(1 + besides.len() / RARE);
        CycleCost {
            fixed: besides.get(most).map_or(0, |cycles| cycles.ceil() as u32),
            iteration: iteration as u32,
        }
    }

    /// Cycles of an iteration: the slope of the line through all ticks' cycles over their iterations.
    fn iteration(&self) -> f64 {
        let points = || {
            self.warm()
                .map(|cost| (f64::from(cost.iterations), cost.all as f64))
        };
        let count = points().count().max(1) as f64;
        let mean = |of: fn((f64, f64)) -> f64| points().map(of).sum::<f64>() / count;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let (mut sxx, mut sxy) = (0.0, 0.0);
        for (n, cycles) in points() {
            sxx += (n - x) * (n - x);
            sxy += (n - x) * (cycles - y);
        }
        // Where all have as many iterations, there is no line: those are dear then.
        if sxx > 0.0 { sxy / sxx } else { y / x.max(1.0) }
    }

    fn rows(&self, rows: &mut Rows) {
        let board = self.board;
        let row = |metric: &str, start: Option<Start>, stat, value, unit| Row {
            core: board.core.name(),
            precision: name(board.precision),
            scene: "monitor",
            attitude: Some(crate::plan::USUAL.name()),
            balls: 16,
            start: start.map(Start::name),
            metric: metric.to_owned(),
            stat,
            value,
            unit,
        };
        let warm = Some(Start::Warm);
        let mut spreads = Vec::new();
        let mut spread = |metric, start, values: Vec<f64>| {
            if values.is_empty() {
                return;
            }
            let spread = Spread::of(values.into_iter());
            for (stat, value) in [
                ("median", spread.median),
                ("99 %", spread.most),
                ("worst", spread.worst),
            ] {
                spreads.push(row(metric, start, stat, value, "cycles"));
            }
        };
        spread(TICK, warm, self.allowed().map(|c| c.all as f64).collect());
        spread(REST, None, self.all.iter().map(Cost::rest).collect());
        let CycleCost { fixed, iteration } = self.constant();
        let besides = |cost: &Cost| cost.besides(iteration.into());
        spread(BESIDES, warm, self.warm().map(besides).collect());
        for row in spreads {
            rows.push(row);
        }
        for (metric, cycles) in [(FIXED, fixed), (ITERATION, iteration)] {
            rows.push(row(metric, warm, "value", cycles.into(), "cycles"));
        }
        let deadline = u64::from(board.settings.deadline_cycles);
        let beyond = self.all.iter().filter(|cost| cost.all > deadline).count();
        for (metric, count) in [
            (TICKS, self.all.len()),
            (SOLVED, self.allowed().count()),
            (BEYOND, beyond),
        ] {
            rows.push(row(metric, None, "value", count as f64, "1"));
        }
    }
}

const TICK: &str = "cycles of a tick with a warm solve";
const REST: &str = "cycles of a tick but for its solve";
const BESIDES: &str = "cycles of a tick but for iterations";
const FIXED: &str = "cycles of a tick but for iterations, of all but one in a thousand";
/// That one.
const RARE: usize = 1000;
const ITERATION: &str = "cycles of an iteration";
const TICKS: &str = "ticks";
const SOLVED: &str = "ticks with a warm solve";
const BEYOND: &str = "ticks beyond the deadline";

/// Records after these ones: teeth that press the shaft with a half-sine each, of two loads and at three rates, one
/// after the other or with a pause in between. A pair feels them through the nose, a single bearing itself.
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

fn measure(root: &Path) -> Result<Vec<Costs>> {
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
    let mut board = f405_board()?;
    let ticks = stream::ticks(&recording, &mut spoiler, settings, |tick| Ok(board(tick)))?;
    let ticks = paced(ticks);
    let images = BOARDS
        .iter()
        .map(|board| {
            let environment = [("MEASURED_PRECISION", Some(name(board.precision)))];
            Image::of(root, board.core, "measured_chain", &environment)
        })
        .collect::<Result<Vec<_>>>()?;
    eprintln!("the monitor on emulated cores, {} ticks", ticks.len());
    BOARDS
        .par_iter()
        .zip(&images)
        .map(|(board, image)| board.measure(image, &ticks))
        .collect()
}

/// Measures all boards.
pub fn run(root: &Path) -> Result<Rows> {
    Ok(rows(&measure(root)?))
}

fn rows(measured: &[Costs]) -> Rows {
    let mut rows = Rows::default();
    for costs in measured {
        costs.rows(&mut rows);
    }
    rows
}

fn figure(rows: &Rows, board: &Board, metric: &str, stat: &str) -> f64 {
    let wanted = (board.core.name(), name(board.precision), "monitor");
    rows.all()
        .iter()
        .find(|r| (r.core, r.precision, r.scene) == wanted && r.metric == metric && r.stat == stat)
        .map_or(f64::NAN, |r| r.value)
}

/// Cycles of a tick with a warm solve on the F405, the median.
pub fn median(rows: &Rows) -> f64 {
    figure(rows, &BOARDS[0], TICK, "median")
}

/// The section of the page.
pub fn section(rows: &Rows) -> String {
    let mut lines = Vec::new();
    let mut budgets = Vec::new();
    for board in &BOARDS {
        for (what, metric) in [
            ("all but the solve", REST),
            ("all but iterations", BESIDES),
            ("a tick with a warm solve", TICK),
        ] {
            let mut line = vec![format!("{}: {what}", board.name())];
            line.extend(["median", "99 %", "worst"].map(|stat| {
                let cycles = figure(rows, board, metric, stat);
                let budget = f64::from(board.settings.deadline_cycles);
                format!("{} ({:.1} %)", thousands(cycles), 100.0 * cycles / budget)
            }));
            lines.push(line);
        }
        // As the constants are to be, not as they were when this was compiled.
        let [fixed, iteration] =
            [FIXED, ITERATION].map(|metric| figure(rows, board, metric, "value").ceil() as u32);
        let settings = TickSettings {
            cost: CycleCost { fixed, iteration },
            ..*board.settings
        };
        let (budget, iterations) = (settings.deadline_cycles, settings.max_iterations());
        let most = settings.most_cycles();
        let count = |metric| thousands(figure(rows, board, metric, "value"));
        budgets.push(vec![
            format!("{}, {} MHz", board.name(), board.core_hz / 1_000_000),
            thousands(budget.into()),
            thousands(fixed.into()),
            thousands(iteration.into()),
            iterations.to_string(),
            thousands(most as f64),
            thousands(f64::from(budget) - most as f64),
            count(TICKS),
            count(SOLVED),
            count(BEYOND),
        ]);
    }
    format!(
        "{}## A tick of the monitor\n\nThe chain of the shipped firmware (`examples/firmware/chain.rs`) over the first \
         {SECONDS} s of the recorded cycle, with the faults of `cargo emulate --seconds {SECONDS} --faults`, \
         and over {TEETH} ticks of passing teeth: \
         bytes of the port sorted and decoded, doubts, a warm solve, limits, judgement, life, telemetry \
         encoded and taken byte by byte. Cycles modelled as above, in brackets the part of a period of 1 ms; \
         interrupts, the log and waiting for the port are not in it. All telemetry of the emulated cores was \
         the host's to the last bit.\n\n{}\n\
         The firmware allows as many iterations as fit. Below, *an iteration* is what a tick takes more for one more of them, \
         and *all but iterations* is what all ticks but one in a thousand take besides. Both together, so many times, are within \
         the period. The rare tick that takes longer lets the next one begin late, and is counted as an overrun; so is a solve \
         from nothing, after one that went astray. *Beyond the period* counts all of these, and solves of one iteration more \
         than the firmware allows, which are measured too.\n\n{}\n\
         `cargo reports monitor` makes this section and the constants of `CycleCost` again.\n\n{}\n",
        MARKS[0],
        table(&["cycles", "median", "99 %", "worst"], &lines),
        table(
            &[
                "board",
                "period",
                "all but iterations",
                "an iteration",
                "iterations allowed",
                "together",
                "margin",
                "ticks",
                "with a warm solve",
                "beyond the period"
            ],
            &budgets
        ),
        MARKS[1],
    )
}

/// Around the section.
const MARKS: [&str; 2] = ["<!-- monitor: begin -->\n\n", "<!-- monitor: end -->\n"];

/// Figures that are held on to.
fn figures(measured: &[Costs]) -> Figures {
    let rows = rows(measured);
    let mut figures = Figures::new();
    for board in &BOARDS {
        let spread = ["median", "99 %", "worst"];
        let spreads = [TICK, REST, BESIDES].map(|metric| spread.map(|stat| (metric, stat)));
        let values = [FIXED, ITERATION].map(|metric| (metric, "value"));
        for (metric, stat) in spreads.into_iter().flatten().chain(values) {
            let value = figure(&rows, board, metric, stat).ceil() as u64;
            let name = match stat {
                "value" => format!("{}, monitor: {metric}", board.name()),
                _ => format!("{}, monitor: {metric}, {stat}", board.name()),
            };
            figures.insert(name, value);
        }
    }
    figures
}

/// Fails where the firmware's constants promise less than is measured.
fn hold(measured: &[Costs], leeway: f64) -> Result<()> {
    let grown: Vec<String> = measured
        .iter()
        .flat_map(|costs| {
            let (is, said) = (costs.constant(), costs.board.cost);
            [
                ("fixed", is.fixed, said.fixed),
                ("iteration", is.iteration, said.iteration),
            ]
            .into_iter()
            .filter(move |(_, is, said)| f64::from(*is) > f64::from(*said) * (1.0 + leeway))
            .map(|(field, is, said)| {
                format!(
                    "CycleCost::{}.{field} is {said}, measured {is}",
                    costs.board.constant
                )
            })
        })
        .collect();
    if !grown.is_empty() {
        bail!(
            "the deadline rests on constants that are too small:\n       {}\n       `cargo reports monitor` \
             writes {CONSTANTS} again; commit it if it is worth it",
            grown.join("\n       ")
        );
    }
    Ok(())
}

/// What the gate is to know: figures, after the constants have been held against them.
pub fn check(root: &Path, leeway: f64) -> Result<Figures> {
    let measured = measure(root)?;
    hold(&measured, leeway)?;
    Ok(figures(&measured))
}

/// Takes constants as they are measured; returns the figures.
pub fn accept(root: &Path) -> Result<Figures> {
    let measured = measure(root)?;
    write_constants(root, &measured)?;
    Ok(figures(&measured))
}

/// Makes section, constants and the monitor's figures again.
pub fn alone(root: &Path) -> Result<()> {
    let measured = measure(root)?;
    let section = section(&rows(&measured));
    println!("{section}");
    write_constants(root, &measured)?;
    if f405::monitored::ROWS == 1 {
        // The page and the gate are about the shipped pair.
        return Ok(());
    }
    crate::gate::replace(root, figures(&measured))?;
    let path = root.join("docs/report.md");
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let text = match (text.split_once(MARKS[0]), text.split_once(MARKS[1])) {
        (Some((before, _)), Some((_, after))) => {
            format!("{before}{section}{}", after.trim_start())
        }
        // A page from before there was a section: at the end.
        _ => format!("{}\n\n{section}", text.trim_end()),
    };
    std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    println!("written: {}, {CONSTANTS}", path.display());
    for costs in &measured {
        let [before, now] = [costs.board.cost, costs.constant()]
            .map(|cost| cost.iterations_within(costs.board.settings.deadline_cycles));
        if now != before {
            println!(
                "{}: {now} iterations are allowed from now on, {before} so far: measure once more",
                costs.board.name()
            );
        }
    }
    Ok(())
}

/// Fails where not even one iteration fits: firmware with such constants does not compile, and could then not
/// be measured again.
fn fits(measured: &[Costs]) -> Result<()> {
    for costs in measured {
        let (is, board) = (costs.constant(), costs.board);
        let (most, period) = (is.fixed + is.iteration, board.settings.deadline_cycles);
        ensure!(
            most <= period,
            "a tick does not fit, {}: {} + {} = {most} cycles of {period}. {CONSTANTS} is left as it is",
            board.name(),
            is.fixed,
            is.iteration
        );
    }
    Ok(())
}

fn write_constants(root: &Path, measured: &[Costs]) -> Result<()> {
    fits(measured)?;
    let mut text =
        "//! What a tick costs on cores that were measured. Made by `cargo reports monitor`; \
                    `docs/report.md` has the\n//! whole of it.\n\nuse super::tick::CycleCost;\n\n\
                    impl CycleCost {\n"
            .to_owned();
    for (name, kept, about) in ALL {
        let measured = measured.iter().find(|costs| costs.board.constant == name);
        let CycleCost { fixed, iteration } = measured.map_or(kept, Costs::constant);
        text += &format!(
            "    /// {about}\n    pub const {name}: Self = Self {{\n        fixed: {},\n        \
             iteration: {},\n    }};\n",
            grouped(fixed),
            grouped(iteration)
        );
    }
    text += "}\n";
    let path = root.join(CONSTANTS);
    std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
}

/// As Rust groups digits.
fn grouped(number: u32) -> String {
    thousands(number.into()).replace(',', "_")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn costs(all: &[(u64, u64, u32)]) -> Costs {
        let cost = |&(all, solve, iterations)| Cost {
            all,
            solve,
            iterations,
        };
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
                (50 + 30 * u64::from(n) + i % 2, 30 * u64::from(n), n)
            })
            .chain([(9000, 8980, most + 1), (400, 390, 3), (130, 0, 0)])
            .collect();
        let measured = costs(&all);
        let CycleCost { fixed, iteration } = measured.constant();
        assert!((29..=31).contains(&iteration), "{iteration}");
        let bound = |cost: &Cost| u64::from(fixed + cost.iterations * iteration);
        let beyond = measured.warm().filter(|cost| cost.all > bound(cost));
        assert_eq!(beyond.count(), 1);
    }

    #[test]
    fn constants_that_promise_too_little_are_named() {
        let said = BOARDS[0].cost;
        let of = |part: f64| {
            let scaled = |cycles: u32| (f64::from(cycles) * part) as u64;
            let solve = |n: u32| u64::from(n) * scaled(said.iteration);
            let cost = |n: u32| (scaled(said.fixed) + solve(n), solve(n), n);
            hold(&[costs(&[cost(1), cost(2)])], 0.02)
        };
        assert!(of(1.019).is_ok());
        let text = of(1.03).unwrap_err().to_string();
        for field in ["fixed", "iteration"] {
            assert!(text.contains(&format!("CORTEX_M4F.{field}")), "{text}");
        }
        assert!(text.contains("cargo reports monitor"), "{text}");
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
