//! Campaign of measured preloads.
//!
//! Does the monitor find the preload of a spindle that is not its file's, and its changes? Load cells, probes, supports and temperatures are
//! not the file's either.

pub mod blocks;
pub mod constants;
pub mod page;
pub mod spindles;
pub mod ticks;

use crate::progress::Progress;
use cli::random::Random;
use rayon::prelude::*;
use spindle_monitor::alarms::Alarm;
use spindle_monitor::estimator::{Constants, State};
use spindle_monitor::telemetry::ProbesReport;
use spindles::{Drawn, Filed, Kind, PROBES, Tables, Used};

/// Noise of a sample, um; runout, um; drift, um/s; samples in a second.
const NOISE: f64 = 0.2;
const RUNOUT: f64 = 3.0;
const DRIFT: f64 = 5.0 / 3600.0;
const RATE: f64 = 1000.0;
/// Steps of a cut: in and out, four times.
const STEPS: usize = 8;

/// Steps that have one cut, where that is asked for.
const ONE_CUT: usize = 300;

/// Alarms that are watched.
pub const WATCHED: [Alarm; 4] = [
    Alarm::PreloadChange,
    Alarm::StiffnessLoss,
    Alarm::StiffnessGain,
    Alarm::Probe,
];

/// What is, or what changes at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum What {
    /// Nothing.
    Nothing,
    /// Nothing, but the first 300 steps are of one cut.
    OneCut,
    /// Preload, to this part of it.
    Preload(f64),
    /// The closure of the front row is gone.
    RowGone,
    /// The front support is softer, to this part of it.
    Front(f64),
    /// Gains of the probes, by these parts.
    Gains([f64; PROBES]),
    /// Gains of all load cells, by this part.
    Cells(f64),
    /// The inner side's temperature is off by so much more, K.
    Kelvin(f64),
    /// A probe is not right.
    Probe(usize, Fault),
}

/// What is wrong with a probe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// It says mm for um.
    Millimetres,
    /// Its sign is the other one.
    Sign,
    /// It repeats its value.
    Frozen,
    /// It says the end of its range.
    OverRange,
    /// It says nothing.
    CutOff,
    /// Coolant hits it once a second.
    Coolant,
}

impl What {
    /// Whether it is so from the start.
    pub fn is_always(self) -> bool {
        use Fault::{Coolant, Millimetres, Sign};
        matches!(
            self,
            Self::Nothing | Self::OneCut | Self::Probe(_, Millimetres | Sign | Coolant)
        )
    }

    /// Whether the cut of a step is a new one.
    fn is_mixed(self, step: usize) -> bool {
        self != Self::OneCut || step == 0 || step >= ONE_CUT
    }
}

/// A row of a table.
#[derive(Debug, Clone)]
pub struct Row {
    /// What it is called.
    pub name: String,
    /// The spindle.
    pub kind: Kind,
    /// What changes.
    pub what: What,
    /// The load cells are right.
    pub cells_right: bool,
    /// Only this probe has readings.
    pub only: Option<usize>,
}

/// All rows.
fn rows() -> Vec<Row> {
    let row = |kind: Kind, name: &str, what: What| Row {
        name: name.to_owned(),
        kind,
        what,
        cells_right: false,
        only: None,
    };
    let mut rows = Kind::ALL
        .map(|kind| row(kind, "sound", What::Nothing))
        .to_vec();
    for kind in [Kind::Shipped, Kind::Elastic] {
        rows.push(Row {
            cells_right: true,
            ..row(kind, "sound, load cells right", What::Nothing)
        });
        for (probe, name) in ["axial probe alone", "radial probe alone"]
            .iter()
            .enumerate()
        {
            rows.push(Row {
                only: Some(probe),
                ..row(kind, name, What::Nothing)
            });
        }
        for (name, what) in [
            ("one cut for 300 steps", What::OneCut),
            ("20 % lost", What::Preload(0.8)),
            ("40 % lost", What::Preload(0.6)),
            ("70 % more", What::Preload(1.7)),
            ("closure of the front row gone", What::RowGone),
            ("front support a third softer", What::Front(2.0 / 3.0)),
            ("radial probe +10 %", What::Gains([1.0, 1.1])),
            ("radial probe +5 %", What::Gains([1.0, 1.05])),
            ("axial probe +10 %", What::Gains([1.1, 1.0])),
            ("axial probe +5 %", What::Gains([1.05, 1.0])),
            ("load cells +5 %", What::Cells(1.05)),
        ] {
            rows.push(row(kind, name, what));
        }
    }
    rows.push(row(Kind::FaceToFace, "40 % lost", What::Preload(0.6)));
    rows.push(row(
        Kind::FaceToFace,
        "inner side 1 K off",
        What::Kelvin(1.0),
    ));
    for (probe, name) in ["axial", "radial"].iter().enumerate() {
        for (fault, said) in [
            (Fault::Millimetres, "in mm"),
            (Fault::Sign, "of the wrong sign"),
            (Fault::Coolant, "in coolant"),
            (Fault::Frozen, "frozen"),
            (Fault::OverRange, "over range"),
            (Fault::CutOff, "cut off"),
        ] {
            let name = format!("{name} probe {said}");
            rows.push(row(Kind::Shipped, &name, What::Probe(probe, fault)));
        }
    }
    rows
}

/// What a run has found.
#[derive(Debug, Clone, Default)]
pub struct Found {
    /// Steps until commissioning.
    pub commissioned: Option<usize>,
    /// Steps after the change, or after commissioning, until each alarm.
    pub alarms: [Option<usize>; WATCHED.len()],
    /// How often each was raised, before the change too.
    pub raised: [usize; WATCHED.len()],
    /// How often `probe` was, before commissioning.
    pub early: usize,
    /// Reports that are judged.
    pub reports: usize,
    /// Those that are `ok`; with a preload beyond three of its standard errors.
    pub ok: usize,
    /// Those that are `ok` with a preload that is off by more than three of its standard errors.
    pub wrong: usize,
    /// Those that are `unexplained`.
    pub unexplained: usize,
    /// Sum of the squared errors of ln preload.
    pub squares: f64,
    /// Reports whose preload is within two standard errors.
    pub within: usize,
    /// Sum of the standard errors of ln preload.
    pub stated: f64,
    /// At the end: change of ln preload, its standard error, changes of the gains.
    pub end: [f64; 2 + PROBES],
    /// States at the end: of the spindle, of each probe.
    pub states: [State; 1 + PROBES],
}

impl Found {
    /// An alarm is raised, so many steps after what is waited for, or before commissioning.
    fn raise(&mut self, alarm: Alarm, after: Option<usize>) {
        if let Some(i) = WATCHED.iter().position(|watched| *watched == alarm) {
            self.raised[i] += 1;
            self.early += usize::from(alarm == Alarm::Probe && after.is_none());
            self.alarms[i] = self.alarms[i].or(after);
        }
    }

    /// Judges a report by the preload that there is, N.
    fn judge(&mut self, report: &ProbesReport, truth: f64) {
        let is_ok = report.state == State::Ok;
        self.reports += 1;
        self.ok += usize::from(is_ok);
        self.unexplained += usize::from(report.state == State::Unexplained);
        if let Some(preload) = report.preload {
            let [value, error] = [preload.value, preload.error].map(f64::from);
            let off = (value - truth).abs();
            self.squares += (value / truth).ln().powi(2);
            self.stated += error / value;
            self.within += usize::from(off < 2.0 * error);
            self.wrong += usize::from(is_ok && off > 3.0 * error);
        }
    }

    /// Takes the report at the end.
    fn finish(&mut self, report: &ProbesReport) {
        self.states[0] = report.state;
        for (state, probe) in self.states[1..].iter_mut().zip(&report.probes) {
            *state = probe.state;
        }
    }
}

/// A campaign.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// Runs of each row.
    pub runs: u64,
    /// Seed of the draws. A run has the same spindle in all rows.
    pub seed: u64,
    /// The rows.
    pub rows: Vec<Row>,
    /// Constants of the estimator, with which all rows are run.
    pub constants: Vec<&'static Constants>,
}

/// A way to run a row: of a spindle in use, with these constants, by these numbers.
type Way<'w> = &'w (dyn Fn(&mut Used, &Row, &'static Constants, Random) -> Found + Sync);

impl Campaign {
    /// All rows, with the constants in use.
    pub fn new(runs: u64, seed: u64) -> Self {
        Self {
            runs,
            seed,
            rows: rows(),
            constants: vec![&Constants::USUAL],
        }
    }

    /// By load steps, as blocks make them: of each constants, of each row, all runs.
    pub fn by_blocks(&self, progress: &dyn Progress) -> Vec<Vec<(Row, Vec<Found>)>> {
        let rows = self
            .rows
            .iter()
            .filter(|row| !matches!(row.what, What::Probe(..)));
        // Rows of one spindle share its tables.
        let shares = |a: &Row, b: &Row| (a.kind, a.cells_right) == (b.kind, b.cells_right);
        self.run(rows.collect(), shares, &blocks::run, progress)
    }

    /// By ticks of the whole monitor, for so many seconds, whose constants are those in use.
    pub fn by_ticks(&self, seconds: u64, progress: &dyn Progress) -> Vec<(Row, Vec<Found>)> {
        let run = |used: &mut Used, row: &Row, _: &'static Constants, random: Random| {
            ticks::run(used, row, random, seconds)
        };
        // Without one of its probes a monitor raises an alarm.
        let rows = self.rows.iter().filter(|row| row.only.is_none());
        self.run(rows.collect(), |_, _| false, &run, progress)
            .remove(0)
    }

    fn run(
        &self,
        rows: Vec<&Row>,
        shares: fn(&Row, &Row) -> bool,
        way: Way,
        progress: &dyn Progress,
    ) -> Vec<Vec<(Row, Vec<Found>)>> {
        progress.expect(rows.len() * self.constants.len() * self.runs as usize);
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            match groups.iter_mut().find(|group| shares(rows[group[0]], row)) {
                Some(group) => group.push(i),
                None => groups.push(vec![i]),
            }
        }
        let files = Kind::ALL.map(Filed::of);
        let of_draw = |(group, index): (&Vec<usize>, u64)| {
            let first = rows[group[0]];
            let filed = files.iter().find(|filed| filed.kind == first.kind);
            let filed = filed.expect("all files are there");
            let mut random = Random::seeded(self.seed ^ (index << 20));
            let mut drawn = Drawn::of(&mut random);
            if first.cells_right {
                drawn.set_cells_right();
            }
            let mut tables = Tables::of(filed, &drawn);
            let mut founds = Vec::new();
            for (of, constants) in self.constants.iter().enumerate() {
                for &row in group {
                    let mut used = Used::new(filed, &drawn, &mut tables);
                    founds.push((
                        of,
                        row,
                        way(&mut used, rows[row], constants, random.clone()),
                    ));
                    progress.done(1);
                }
            }
            founds
        };
        let draws: Vec<_> = groups
            .iter()
            .flat_map(|group| (0..self.runs).map(move |index| (group, index)))
            .collect();
        let founds: Vec<_> = draws.into_par_iter().flat_map_iter(of_draw).collect();
        let mut all: Vec<Vec<(Row, Vec<Found>)>> = self
            .constants
            .iter()
            .map(|_| {
                rows.iter()
                    .map(|row| (Row::clone(row), Vec::new()))
                    .collect()
            })
            .collect();
        for (of, row, found) in founds {
            all[of][row].1.push(found);
        }
        all
    }
}
