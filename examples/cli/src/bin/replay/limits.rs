//! `cargo replay --limits`: alarms that the board's monitor would raise over a recording, in its order.

use crate::Args;
use anyhow::{Context, Result, anyhow, ensure};
use cli::replay::{ReplayError, Summary, Table};
use cli::stream::per_tick::PerTick;
use cli::stream::{ROOM, TEMPERATURES};
use spindle_file::monitors::{self, AlarmLevels};
use spindle_file::mounting::{MOST_JOINTS, Parts, board};
use spindle_file::plan::{BuildError, MOST_BALLS, MOST_ROWS};
use spindle_file::spindles::SpindleFile;
use spindle_monitor::enumset::EnumSet;
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::{FramedLoads, LoadSource};
use spindle_monitor::tick::{Core, NoCycles, NoWatchdog};
use spindle_monitor::{Alarm, Marks, Monitor, Readings};
use std::io::{self, Write};

/// Boards by name.
pub const BOARDS: [(&str, &str, Core); 2] = [
    ("f405", "STM32F405", Core::STM32F405),
    ("h743", "STM32H743", Core::STM32H743),
];

/// A monitor of any spindle.
type DynMonitor = Monitor<MOST_ROWS, MOST_BALLS, 12, 6, MOST_JOINTS>;

/// Makes the monitor of a file on a board. It stays until the program ends, as the board's does.
fn monitor_of(file: &SpindleFile, core: Core) -> Result<Box<DynMonitor>> {
    let plan = board::plan(file, Some(core))?;
    let explained = |error: BuildError| file.explain(&error);
    let parts: &'static Parts<f32> = Box::leak(Box::new(Parts::of(&plan).map_err(explained)?));
    let spindle = parts.spindle(&plan).map_err(explained)?;
    let settings = Box::leak(Box::new(board::settings(file, &core)));
    Ok(Box::new(Monitor::new(
        Box::leak(Box::new(spindle)),
        settings,
    )))
}

/// Runs the monitor over the recording, and writes the alarms to standard output.
pub fn run(args: &Args) -> Result<Summary> {
    let file = args.file()?;
    let mut monitor = monitor_of(&file, args.board)?;
    let of = &file.monitor;
    let prepared = monitor.prepare(of.idle.map(|x| x as f32));
    prepared.map_err(|status| anyhow!("the idling spindle has no equilibrium: {status}"))?;
    let (rows, recording) = args.input(&file)?;
    let recording = recording.context("--limits needs a recording")?;
    let name = || recording.lock().expect("a reader").file().to_owned();
    let mut ticks = PerTick::new(rows, of.period_us);
    let mut source = FramedLoads::new();
    let mut standing = EnumSet::<Alarm>::new();
    let mut doubts = [0_u64; Marks::variant_count() as usize];
    let output = |error| ReplayError::Output(Table::Results, error);
    let mut out = io::BufWriter::new(io::stdout());
    writeln!(out, "time_s,alarm,event,value,limit,unit").map_err(output)?;
    while let Some(tick) = ticks.next() {
        let tick = tick.map_err(|error| anyhow!("{}: {error}", name()))?;
        let number = tick.record.sequence;
        let time_us = u64::from(number) * u64::from(of.period_us);
        source.take(Ok(tick.record));
        let is_turn = (number as usize).is_multiple_of(TEMPERATURES);
        let readings = Readings {
            loads: source.sample(time_us),
            speed: None,
            temperatures: tick.temperatures.filter(|_| is_turn),
        };
        let outcome = monitor.tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
        // The link takes the telemetry that it has room for.
        (0..ROOM)
            .map_while(|_| monitor.outbox().next_byte())
            .count();
        for mark in outcome.marks.iter() {
            doubts[mark as usize] += 1;
        }
        for change in &outcome.changes {
            let alarm = change.alarm;
            monitor.acknowledge(time_us, alarm);
            let level = monitor.judgement().alarm(alarm).level().value;
            let AlarmLevels { limit, clear, .. } = of.alarms[alarm as usize];
            let (event, limit) = match change.change {
                AlarmChange::Raised if standing.insert(alarm) => ("raised", limit),
                AlarmChange::Raised => ("worse", limit),
                _ => {
                    standing.remove(alarm);
                    ("cleared", clear)
                }
            };
            let [value, limit] = [f64::from(level), limit].map(|x| monitors::level(alarm, x));
            let (unit, _) = alarm.unit();
            let time = ((ticks.start() * 1e6).round() + time_us as f64) / 1e6;
            writeln!(out, "{time},{alarm},{event},{value},{limit},{unit}").map_err(output)?;
        }
    }
    out.flush().map_err(output)?;
    let recording = recording.lock().expect("a reader");
    for line in recording.account().lines() {
        eprintln!("replay: {line}");
    }
    ensure!(
        recording.counts().read > 0,
        "{}: there is no row to read",
        recording.file()
    );
    if let Some(line) = ticks.account() {
        eprintln!("replay: {}: {line}", recording.file());
    }
    let doubts = Marks::all()
        .iter()
        .zip(doubts)
        .filter(|(_, ticks)| *ticks > 0);
    let doubts: Vec<_> = doubts
        .map(|(mark, ticks)| format!("{} {ticks}", mark.name()))
        .collect();
    if !doubts.is_empty() {
        eprintln!("replay: ticks with doubts: {}", doubts.join(", "));
    }
    Ok(Summary::default())
}
