//! `cargo replay --limits`: alarms that the board's monitor would raise over a recording, in its order, and ratios at the probes.

use crate::arguments::Args;
use anyhow::{Context, Result, anyhow, ensure};
use cli::board::monitor_of;
use cli::replay::{ReplayError, Summary, Table};
use cli::stream::per_tick::PerTick;
use cli::stream::{ROOM, TEMPERATURES};
use spindle_file::monitors::level;
use spindle_file::spindles::SpindleFile;
use spindle_monitor::alarms::Threshold;
use spindle_monitor::enumset::EnumSet;
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::{FramedLoads, LoadSource};
use spindle_monitor::telemetry::{FrameReader, Payload, ProbesReport};
use spindle_monitor::tick::{NoCycles, NoWatchdog};
use spindle_monitor::{Alarm, Marks, Readings};
use std::array::from_fn;
use std::io::{self, Write};

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

/// State of the spindle with its preload, N, and of each probe with its gain.
fn estimates(file: &SpindleFile, report: &ProbesReport) -> Vec<String> {
    let preload = report
        .preload
        .map_or(String::new(), |preload| format!("{:.0}", preload.value));
    let spindle = format!("preload,{},{preload},,N", report.state.name());
    let probes = file
        .probes
        .iter()
        .zip(&report.probes)
        .map(|(probe, report)| {
            let percent = 100.0 * report.gain.value;
            format!(
                "probe {},{},{percent:.1},,%",
                probe.name,
                report.state.name()
            )
        });
    [spindle].into_iter().chain(probes).collect()
}

fn follow<const P: usize>(args: &Args, file: &SpindleFile) -> Result<Summary> {
    let settings = file.settings(&args.board);
    let mut monitor = monitor_of::<P>(file, Some(args.board), settings)?;
    let period_us = settings.tick.period_us;
    let (rows, recording) = args.input(file)?;
    let recording = recording.context("--limits needs a recording")?;
    let name = || recording.lock().expect("a reader").file().to_owned();
    let mut ticks = PerTick::new(rows, period_us);
    let (mut source, mut frames) = (FramedLoads::new(), FrameReader::new());
    let mut told = Vec::<String>::new();
    let mut commission = args.response.commission;
    if commission.is_some() {
        monitor.learn(u64::MAX);
    }
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
        if let Some([_, to]) = commission.filter(|[from, _]| at(time_us) >= *from) {
            commission = None;
            monitor.learn(((to - ticks.start()).max(0.0) * 1e6) as u64);
        }
        let outcome = monitor.tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
        // The link takes the telemetry that it has room for.
        for byte in (0..ROOM).map_while(|_| monitor.outbox().next_byte()) {
            let Some(Ok(frame)) = frames.push(byte) else {
                continue;
            };
            let Payload::Probes(report) = &frame.payload else {
                continue;
            };
            let estimates = estimates(file, report);
            for line in estimates.iter().filter(|line| !told.contains(line)) {
                writeln!(out, "{},{line}", at(frame.time_us)).map_err(output)?;
            }
            told = estimates;
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
    ensure!(
        commission.is_none(),
        "the recording ends before --commission begins"
    );
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
