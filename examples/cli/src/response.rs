//! The board's monitor over a recording, and second by second what it says of preload and probes.

use crate::board::{DynMonitor, monitor_of};
use crate::fault::LoadsError;
use crate::limits::Watch;
use crate::replay::{REFUSED_INPUT, Summary};
use crate::telemetry::findings;
use anyhow::{Result, bail, ensure};
use spindle_file::loads::LoadRow;
use spindle_file::reading::short;
use spindle_file::spindles::SpindleFile;
use spindle_monitor::estimator::Constants;
use spindle_monitor::loads::LoadSample;
use spindle_monitor::revolutions::is_aliased;
use spindle_monitor::telemetry::ProbesReport;
use spindle_monitor::tick::{NoCycles, NoWatchdog};
use spindle_monitor::{Marks, Readings};
use std::array::from_fn;

/// Rows from whose times the step of a recording is taken.
const FIRST: usize = 10_000;
/// Shortest and longest step, s.
const STEPS: [f64; 2] = [1e-4, 1.0];
/// Usual rates of loggers within a decade.
const RATES: [f32; 10] = [1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0];

/// Runs the monitor over the recording. Lines of the table are written, and findings told.
///
/// # Errors
///
/// No probes, a recording that cannot be read or has no row, a window outside of it, an output that fails.
pub fn response(
    watch: &Watch<'_>,
    rows: impl Iterator<Item = Result<LoadRow, LoadsError>>,
    write: impl FnMut(&str) -> Result<()>,
    tell: impl FnMut(&str),
) -> Result<Summary> {
    match watch.file.probes.len() {
        0 => bail!(
            "--response: {} has no [[probe]]; add one with name, position_mm and direction",
            watch.file.name
        ),
        1 => follow::<1>(watch, rows, write, tell),
        2 => follow::<2>(watch, rows, write, tell),
        3 => follow::<3>(watch, rows, write, tell),
        _ => follow::<4>(watch, rows, write, tell),
    }
}

fn follow<const P: usize>(
    watch: &Watch<'_>,
    rows: impl Iterator<Item = Result<LoadRow, LoadsError>>,
    mut write: impl FnMut(&str) -> Result<()>,
    mut tell: impl FnMut(&str),
) -> Result<Summary> {
    let mut summary = Summary::default();
    let mut rows = rows.fuse();
    let mut next = |summary: &mut Summary| loop {
        let row = rows.next();
        summary.rows += u64::from(row.is_some());
        match row {
            None => return Ok(None),
            Some(Ok(row)) => return Ok(Some(row)),
            Some(Err(LoadsError::Row(bad))) => {
                summary.first_fault.get_or_insert(bad.fault);
                *summary.refused.entry(REFUSED_INPUT).or_default() += 1;
            }
            Some(Err(fault)) => return Err(fault),
        }
    };
    let mut first = Vec::new();
    while first.len() < FIRST
        && let Some(row) = next(&mut summary)?
    {
        first.push(row);
    }
    let mut history = History::<P>::new(watch, &first)?;
    let mut text = history.header();
    for row in first {
        history.take(&row, &mut summary, &mut text, &mut tell);
    }
    while let Some(row) = next(&mut summary)? {
        history.take(&row, &mut summary, &mut text, &mut tell);
        if text.len() > 1 << 16 {
            write(&text)?;
            text.clear();
        }
    }
    ensure!(
        summary.rows > 0,
        "{}: there is no row below the header",
        watch.recording
    );
    history.finish(watch.recording, &mut tell)?;
    write(&text)?;
    Ok(summary)
}

/// The monitor of a spindle with `P` probes, and its recording so far.
struct History<'h, const P: usize> {
    file: &'h SpindleFile,
    monitor: Box<DynMonitor<P>>,
    /// Order to commission from and to these times, s, which has begun.
    window: Option<[f64; 2]>,
    has_begun: bool,
    /// Step of the recording, and times of its first and last row and of the next line, s.
    step: f64,
    begin: f64,
    last: f64,
    next: f64,
    rpm: f64,
    /// What was said already.
    told_aliased: bool,
    told_found: bool,
}

impl<'h, const P: usize> History<'h, P> {
    fn new(watch: &Watch<'h>, first: &[LoadRow]) -> Result<Self> {
        let file = watch.file;
        let times = first.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
        let mut steps: Vec<f64> = times.filter(|step| *step > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        let step = steps.get(steps.len() / 2).copied().unwrap_or(STEPS[1]);
        let step = step.clamp(STEPS[0], STEPS[1]);
        let mut settings = file.settings(&watch.board);
        // A recording has a row a tick, and a solve ends in its tick; channels are believed though they repeat themselves.
        settings.tick.period_us = (1e6 * step).round() as u32;
        settings.tick.deadline_cycles = u32::MAX;
        settings.plausibility.stuck_after = 0;
        settings.plausibility.speed_stuck_after = 0;
        let mut monitor = monitor_of::<P>(file, None, settings)?;
        let window = watch.commission;
        if window.is_some() {
            monitor.learn(u64::MAX);
        }
        let begin = first.first().map_or(0.0, |row| row.time_s);
        Ok(Self {
            file,
            monitor,
            window,
            has_begun: false,
            step,
            begin,
            last: begin,
            next: begin.floor() + 1.0,
            rpm: 0.0,
            told_aliased: false,
            told_found: false,
        })
    }

    fn header(&self) -> String {
        let of_probe = |name: &str| format!(",gain_{name},gain_error_{name},state_{name}");
        let probes = self.file.probes.iter().map(|probe| of_probe(&probe.name));
        let spindle =
            "time_s,state,preload_n,preload_error_n,change_percent,change_error_percent,steps";
        format!("{spindle}{}\n", probes.collect::<String>())
    }

    /// Time of the monitor, us.
    fn time_us(&self, time: f64) -> u64 {
        (1e6 * (time - self.begin)).round() as u64
    }

    fn take(
        &mut self,
        row: &LoadRow,
        summary: &mut Summary,
        text: &mut String,
        tell: &mut impl FnMut(&str),
    ) {
        let time = row.time_s;
        if let Some([from, to]) = self.window
            && time >= from
            && !self.has_begun
        {
            self.has_begun = true;
            self.monitor.learn(self.time_us(to.max(self.begin)));
        }
        let time_us = self.time_us(time);
        let readings = Readings {
            loads: Ok(Some(LoadSample {
                time_us,
                load: row.load.map(|load| load as f32),
                speed: Some(row.omega() as f32),
                residual: 0.0,
                doubts: Marks::new(),
            })),
            speed: None,
            temperatures: row.temperatures.map(|both| both.map(|t| t as f32)),
        };
        let measured = from_fn(|i| row.probes[i].map(|um| um as f32));
        self.monitor.note_displacements(measured);
        let refusals = self.monitor.health().refusals;
        let outcome = self
            .monitor
            .tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
        if self.monitor.health().refusals > refusals {
            *summary.refused.entry("no-equilibrium").or_default() += 1;
        }
        for change in &outcome.changes {
            self.monitor.acknowledge(time_us, change.alarm);
        }
        while self.monitor.outbox().next_byte().is_some() {}
        (self.last, self.rpm) = (time, row.speed_rpm);
        self.tell(time, tell);
        while time + 1.5 * self.step >= self.next {
            if let Some(report) = self.monitor.probes_report() {
                text.push_str(&line(self.next, &report));
            }
            // Pauses of the logger have no lines.
            self.next = (self.next + 1.0).max(time.floor());
        }
    }

    /// Says once that the speed has no blocks, and once that commissioning has ended.
    fn tell(&mut self, time: f64, tell: &mut impl FnMut(&str)) {
        let rate = (1.0 / self.step) as f32;
        if !self.told_aliased && is_aliased(self.rpm as f32, rate) {
            self.told_aliased = true;
            let (rpm, rate) = (self.rpm, short(rate.into()));
            let other = other_rate(rpm as f32, rate as f32);
            let other = other.map_or(String::new(), |other| format!(": {other} Hz does not"));
            tell(&format!(
                "at {rate} Hz, {rpm} rpm stands still{other}; such times do not count"
            ));
        }
        if !self.told_found
            && self.monitor.is_commissioned()
            && let Some(report) = self.monitor.probes_report()
        {
            self.told_found = true;
            self.found(&format!("commissioned at {time} s"), &report, tell);
        }
    }

    /// Says what was found of preload and probes.
    fn found(&self, when: &str, report: &ProbesReport, tell: &mut impl FnMut(&str)) {
        if let Some(preload) = report.preload {
            let [value, error] = [preload.value, preload.error].map(|x| short(f64::from(x)));
            tell(&format!("{when}: preload {value:.0} +- {error:.0} N"));
        } else {
            tell(&format!(
                "{when}: no rows oppose each other, and none has a preload"
            ));
        }
        for (probe, report) in self.file.probes.iter().zip(&report.probes) {
            tell(&format!(
                "probe {}: {}",
                probe.name,
                findings::raw_ratio(report)
            ));
        }
    }

    /// Says what commissioning has lacked.
    fn finish(&self, name: &str, tell: &mut impl FnMut(&str)) -> Result<()> {
        if let Some([from, to]) = self.window {
            let end = self.last;
            ensure!(
                self.has_begun && to >= self.begin,
                "{name}: the recording is from {} to {end} s, and --commission {from}:{to} outside of it",
                self.begin
            );
        }
        let Some(report) = self.monitor.probes_report() else {
            return Ok(());
        };
        if self.told_found {
            return Ok(());
        }
        self.found("at the end, not commissioned", &report, tell);
        let Constants { steps, .. } = Constants::USUAL;
        match findings::steps_to_go(&report) {
            0 => {}
            to_go => tell(&format!(
                "the recording ends {to_go} steps before commissioning, which takes {steps}"
            )),
        }
        if let Some(lacking) = findings::lacking(&report) {
            tell(&lacking);
        }
        if let Some([_, to]) = self.window.filter(|[_, to]| *to > self.last) {
            tell(&format!(
                "the recording ends before {to} s, until when --commission lasts"
            ));
        }
        Ok(())
    }
}

/// The next usual rate, Hz, at which this speed has blocks.
fn other_rate(rpm: f32, rate: f32) -> Option<f32> {
    let decade = 10_f32.powf(rate.log10().floor());
    let rates = RATES
        .iter()
        .chain(&[10.0, 12.5, 16.0, 20.0])
        .map(|of| of * decade);
    rates
        .filter(|other| *other > rate)
        .find(|other| !is_aliased(rpm, *other))
}

/// A line of the file.
fn line(time: f64, report: &ProbesReport) -> String {
    let number = |x: Option<f32>| x.map_or(String::new(), |x| short(x.into()).to_string());
    let percent = |x: f32| 100.0 * x;
    let (preload, change) = (report.preload, report.change);
    let mut line = format!(
        "{time},{},{},{},{},{},{}",
        report.state.name(),
        number(preload.map(|of| of.value)),
        number(preload.map(|of| of.error)),
        number(change.map(|of| percent(of.value))),
        number(change.map(|of| percent(of.error))),
        report.steps
    );
    for probe in &report.probes {
        let [gain, error] = [probe.gain.value, probe.gain.error].map(|x| number(Some(x)));
        line += &format!(",{gain},{error},{}", probe.state.name());
    }
    line.push('\n');
    line
}
