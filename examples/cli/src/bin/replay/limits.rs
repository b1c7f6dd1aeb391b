//! `cargo replay --limits`: alarms that the board's monitor would raise over a recording, in its order.

use crate::Args;
use anyhow::{Context, Result, anyhow, ensure};
use cli::replay::{ReplayError, Summary, Table};
use cli::stream::per_tick::PerTick;
use cli::stream::{ROOM, TEMPERATURES};
use spindle_bearing::{Spindle, Status};
use spindle_file::monitors::{self, AlarmLevels};
use spindle_file::mounting::{Parts, Visitor, board};
use spindle_file::plan::{BuildError, MOST_BALLS};
use spindle_file::spindles::SpindleFile;
use spindle_monitor::enumset::EnumSet;
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::{FramedLoads, LoadSource};
use spindle_monitor::tick::{Core, NoCycles, NoWatchdog};
use spindle_monitor::{Alarm, Marks, Monitor, Outcome, Readings};
use std::io::{self, Write};

/// A monitor of any spindle.
trait AnyMonitor {
    /// Solves the idling spindle.
    fn prepare(&mut self, idle: [f32; 5]) -> Result<(), Status<f32>>;

    /// A tick, after which the link takes the telemetry that it has room for.
    fn tick(&mut self, time_us: u64, readings: &Readings) -> Outcome;

    /// Acknowledges an alarm; its level.
    fn acknowledge(&mut self, time_us: u64, alarm: Alarm) -> f32;
}

impl<const R: usize, const F: usize, const D: usize, const E: usize> AnyMonitor
    for Monitor<R, MOST_BALLS, F, D, E>
{
    fn prepare(&mut self, idle: [f32; 5]) -> Result<(), Status<f32>> {
        self.prepare(idle)
    }

    fn tick(&mut self, time_us: u64, readings: &Readings) -> Outcome {
        let outcome = self.tick(time_us, readings, &mut NoCycles, &mut NoWatchdog);
        (0..ROOM).map_while(|_| self.outbox().next_byte()).count();
        outcome
    }

    fn acknowledge(&mut self, time_us: u64, alarm: Alarm) -> f32 {
        self.acknowledge(time_us, alarm);
        self.judgement().alarm(alarm).level().value
    }
}

/// Boards by name.
pub const BOARDS: [(&str, &str, Core); 2] = [
    ("f405", "STM32F405", Core::STM32F405),
    ("h743", "STM32H743", Core::STM32H743),
];

/// Makes the monitor of a file on a board. It stays until the program ends, as the board's does.
struct Make<'m> {
    file: &'m SpindleFile,
    core: Core,
    monitor: &'m mut Option<Box<dyn AnyMonitor>>,
}

impl Visitor<'static, f32> for Make<'_> {
    fn visit<const R: usize, const D: usize, const E: usize>(
        self,
        spindle: Spindle<'static, f32, R, MOST_BALLS, D, E>,
        _: f64,
    ) -> Result<(), BuildError> {
        let settings = board::settings::<R>(self.file, &self.core);
        let (spindle, settings) = (Box::leak(Box::new(spindle)), Box::leak(Box::new(settings)));
        let monitor: Monitor<R, MOST_BALLS, 12, D, E> = Monitor::new(spindle, settings);
        *self.monitor = Some(Box::new(monitor));
        Ok(())
    }
}

fn monitor_of(file: &SpindleFile, core: Core) -> Result<Box<dyn AnyMonitor>> {
    let plan = board::plan(file, Some(core))?;
    let mut monitor = None;
    let make = Make {
        file,
        core,
        monitor: &mut monitor,
    };
    let parts = Parts::of(&plan).map(|parts| &*Box::leak(Box::new(parts)));
    let made = parts.and_then(|parts| parts.visit(&plan, make));
    made.map_err(|error| file.explain(&error))?;
    monitor.context("no monitor was made")
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
        let outcome = monitor.tick(time_us, &readings);
        for mark in outcome.marks.iter() {
            doubts[mark as usize] += 1;
        }
        for change in &outcome.changes {
            let alarm = change.alarm;
            let level = monitor.acknowledge(time_us, alarm);
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
