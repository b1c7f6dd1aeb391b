//! Alarms that the board's monitor would raise over a recording, in its order, and ratios at the probes.

use crate::board::monitor_of;
use crate::fault::LoadsError;
use crate::replay::{ReplayError, Table};
use crate::stream::per_tick::PerTick;
use crate::stream::{ROOM, TEMPERATURES};
use anyhow::{Result, anyhow, ensure};
use spindle_file::loads::LoadRow;
use spindle_file::monitors::level;
use spindle_file::spindles::SpindleFile;
use spindle_monitor::alarms::Threshold;
use spindle_monitor::enumset::EnumSet;
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::{FramedLoads, LoadSource};
use spindle_monitor::telemetry::{FrameReader, Payload, ProbesReport};
use spindle_monitor::tick::{Core, NoCycles, NoWatchdog};
use spindle_monitor::{Alarm, Marks, Readings};
use std::array::from_fn;
use std::io::Write;

/// Questions to the monitor of a board.
#[derive(Debug)]
pub struct Watch<'w> {
    /// The spindle.
    pub file: &'w SpindleFile,
    /// The board's core.
    pub board: Core,
    /// Learn from the first time on, and end commissioning at the second one at the earliest, s.
    pub commission: Option<[f64; 2]>,
    /// The recording, as messages call it.
    pub recording: &'w str,
}

/// Remarks of the monitor besides its alarms, in a line each.
#[derive(Debug)]
pub struct Seen {
    /// How the recording was brought to the rate of ticks.
    pub ticks: Option<String>,
    /// Ticks with doubts.
    pub doubts: Option<String>,
}

/// Runs the monitor over the recording, and writes the alarms as CSV.
///
/// # Errors
///
/// A spindle without such a monitor, a recording that it cannot follow, an output that fails.
pub fn limits(
    watch: &Watch<'_>,
    rows: impl Iterator<Item = Result<LoadRow, LoadsError>>,
    out: &mut impl Write,
) -> Result<Seen> {
    match watch.file.probes.len() {
        0 => follow::<0>(watch, rows, out),
        1 => follow::<1>(watch, rows, out),
        2 => follow::<2>(watch, rows, out),
        3 => follow::<3>(watch, rows, out),
        _ => follow::<4>(watch, rows, out),
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

fn follow<const P: usize>(
    watch: &Watch<'_>,
    rows: impl Iterator<Item = Result<LoadRow, LoadsError>>,
    out: &mut impl Write,
) -> Result<Seen> {
    let (file, name) = (watch.file, watch.recording);
    let settings = file.settings(&watch.board);
    let mut monitor = monitor_of::<P>(file, Some(watch.board), settings)?;
    let period_us = settings.tick.period_us;
    let mut ticks = PerTick::new(rows, period_us);
    let (mut source, mut frames) = (FramedLoads::new(), FrameReader::new());
    let mut told = Vec::<String>::new();
    let mut commission = watch.commission;
    if commission.is_some() {
        monitor.learn(u64::MAX);
    }
    ensure!(
        commission.is_none() || P > 0,
        "--commission is for probes, and {} has no [[probe]]",
        file.name
    );
    let mut standing = EnumSet::<Alarm>::new();
    let mut doubts = [0_u64; Marks::variant_count() as usize];
    let output = |error| ReplayError::Output(Table::Results, error);
    writeln!(out, "time_s,alarm,event,value,limit,unit").map_err(output)?;
    while let Some(tick) = ticks.next() {
        let tick = tick.map_err(|error| anyhow!("{name}: {error}"))?;
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
    let doubts = Marks::all()
        .iter()
        .zip(doubts)
        .filter(|(_, ticks)| *ticks > 0);
    let doubts: Vec<_> = doubts
        .map(|(mark, ticks)| format!("{} {ticks}", mark.name()))
        .collect();
    let doubts = (!doubts.is_empty()).then(|| format!("ticks with doubts: {}", doubts.join(", ")));
    let ticks = ticks.account();
    Ok(Seen { ticks, doubts })
}
