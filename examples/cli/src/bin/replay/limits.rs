//! `cargo replay --limits`: alarms that the board's monitor would raise over a recording, in its order, and ratios at the probes.

use crate::arguments::Args;
use anyhow::{Context, Result, anyhow, ensure};
use cli::replay::{ReplayError, Summary, Table};
use cli::stream::per_tick::PerTick;
use cli::stream::{ROOM, TEMPERATURES};
use spindle_file::monitors::level;
use spindle_file::mounting::{MOST_JOINTS, Parts, board};
use spindle_file::plan::{BuildError, MOST_BALLS, MOST_ROWS};
use spindle_file::spindles::SpindleFile;
use spindle_monitor::alarms::Threshold;
use spindle_monitor::command::{AnswerCode, Request};
use spindle_monitor::enumset::EnumSet;
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::{FramedLoads, LoadSource};
use spindle_monitor::telemetry::{FrameReader, Payload, ProbesReport};
use spindle_monitor::tick::{Core, NoCycles, NoWatchdog};
use spindle_monitor::{Alarm, Marks, Monitor, MonitorSettings, Order, Readings, ResponseSettings};
use std::array::from_fn;
use std::io::{self, Write};

/// A monitor of any spindle with `P` probes.
type DynMonitor<const P: usize> = Monitor<MOST_ROWS, MOST_BALLS, 12, 6, MOST_JOINTS, P>;

/// Makes the monitor of a file on a board. It stays until the program ends, as the board's does.
fn monitor_of<const P: usize>(
    file: &SpindleFile,
    core: Core,
    settings: MonitorSettings<MOST_ROWS>,
) -> Result<Box<DynMonitor<P>>> {
    let plan = board::plan(file, Some(core))?;
    let explained = |error: BuildError| file.explain(&error);
    let parts: &'static Parts<f32> = Box::leak(Box::new(Parts::of(&plan).map_err(explained)?));
    let spindle = parts.spindle(&plan).map_err(explained)?;
    let probes = Box::leak(Box::new(ResponseSettings {
        probes: from_fn(|i| file.probes[i].settings()),
    }));
    Ok(Box::new(Monitor::with_probes(
        Box::leak(Box::new(spindle)),
        Box::leak(Box::new(settings)),
        probes,
    )))
}

/// Runs the monitor over the recording, and writes the alarms to standard output.
pub fn run(args: &Args) -> Result<Summary> {
    let file = args.file()?;
    match file.probes.len() {
        0 => follow::<0>(args, &file),
        1 => follow::<1>(args, &file),
        2 => follow::<2>(args, &file),
        3 => follow::<3>(args, &file),
        _ => follow::<4>(args, &file),
    }
}

/// State and ratio of each probe.
fn ratios(file: &SpindleFile, report: &ProbesReport) -> Vec<String> {
    let probes = file.probes.iter().zip(&report.probes);
    let lines = probes.map(|(probe, report)| {
        let ratio = report.ratio.map(|ratio| 100.0 * ratio.value);
        let ratio = ratio.map_or(String::new(), |percent| format!("{percent:.4}"));
        format!("probe {},{},{ratio},,%", probe.name, report.state.name())
    });
    lines.collect()
}

fn follow<const P: usize>(args: &Args, file: &SpindleFile) -> Result<Summary> {
    let settings = file.settings(&args.board);
    let mut monitor = monitor_of::<P>(file, args.board, settings)?;
    let period_us = settings.tick.period_us;
    let prepared = monitor.prepare(file.sensors.idle);
    prepared.map_err(|status| anyhow!("the idling spindle has no equilibrium: {status}"))?;
    let (rows, recording) = args.input(file)?;
    let recording = recording.context("--limits needs a recording")?;
    let name = || recording.lock().expect("a reader").file().to_owned();
    let mut ticks = PerTick::new(rows, period_us);
    let (mut source, mut frames) = (FramedLoads::new(), FrameReader::new());
    let mut told = Vec::<String>::new();
    let mut commission = args.response.commission.map(|[_, to]| to);
    ensure!(
        commission.is_none() || P > 0,
        "--commission is for probes, and {} has no [[probe]]",
        args.design().display()
    );
    let mut standing = EnumSet::<Alarm>::new();
    let mut doubts = [0_u64; Marks::variant_count() as usize];
    let output = |error| ReplayError::Output(Table::Results, error);
    let mut out = io::BufWriter::new(io::stdout());
    writeln!(out, "time_s,alarm,event,value,limit,unit").map_err(output)?;
    while let Some(tick) = ticks.next() {
        let tick = tick.map_err(|error| anyhow!("{}: {error}", name()))?;
        let number = tick.record.sequence;
        let time_us = u64::from(number) * u64::from(period_us);
        source.take(Ok(tick.record));
        let is_turn = (number as usize).is_multiple_of(TEMPERATURES);
        let readings = Readings {
            loads: source.sample(time_us),
            speed: None,
            temperatures: tick.temperatures.filter(|_| is_turn),
        };
        monitor.note_displacements(from_fn(|i| tick.probes[i]));
        let at = |us: u64| ((ticks.start() * 1e6).round() + us as f64) / 1e6;
        if commission.is_some_and(|to| at(time_us) >= to) {
            commission = None;
            let order = Order::Commission;
            monitor.ask(&Request { number: 0, order }, true);
        }
        let outcome = monitor.tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
        // The link takes the telemetry that it has room for.
        for byte in (0..ROOM).map_while(|_| monitor.outbox().next_byte()) {
            let Some(Ok(frame)) = frames.push(byte) else {
                continue;
            };
            match &frame.payload {
                Payload::Probes(report) => {
                    let ratios = ratios(file, report);
                    for line in ratios.iter().filter(|line| !told.contains(line)) {
                        writeln!(out, "{},{line}", at(frame.time_us)).map_err(output)?;
                    }
                    told = ratios;
                }
                Payload::Answer(answer) if answer.outcome != AnswerCode::Done => eprintln!(
                    "replay: at {} s, the probes have no reference: {}; widen --commission",
                    at(frame.time_us),
                    answer.outcome.name()
                ),
                _ => {}
            }
        }
        for mark in outcome.marks.iter() {
            doubts[mark as usize] += 1;
        }
        for change in &outcome.changes {
            let alarm = change.alarm;
            monitor.acknowledge(time_us, alarm);
            let value = monitor.judgement().alarm(alarm).level().value;
            let Threshold { raise, clear, .. } = settings.alarms[alarm as usize];
            let (event, limit) = match change.change {
                AlarmChange::Raised if standing.insert(alarm) => ("raised", raise),
                AlarmChange::Raised => ("worse", raise),
                _ => {
                    standing.remove(alarm);
                    ("cleared", clear)
                }
            };
            let [value, limit] = [value, limit].map(|x| level(alarm, x.into()));
            let (unit, _) = alarm.unit();
            let time = at(time_us);
            writeln!(out, "{time},{alarm},{event},{value},{limit},{unit}").map_err(output)?;
        }
    }
    out.flush().map_err(output)?;
    if let Some(to) = commission {
        eprintln!(
            "replay: the recording ends before {to} s: the probes have no reference; give --commission an earlier end"
        );
    }
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
