//! A run by ticks of the whole monitor.

use crate::preload::spindles::{Cut, PROBES, SPEEDS, Used, normal};
use crate::preload::{DRIFT, Fault, Found, NOISE, RATE, RUNOUT, Row, STEPS, What};
use cli::board::{DynMonitor, monitor_of};
use cli::random::Random;
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::LoadSample;
use spindle_monitor::tick::{Core, NoCycles, NoWatchdog};
use spindle_monitor::{Marks, Readings};
use std::array::from_fn;
use std::f64::consts::TAU;

/// Ticks that a load takes to come or to go, and a speed to change.
const RAMP: f64 = 10.0;
const RUN_UP: usize = 500;
/// Least and most ticks of an engagement, or of idling.
const HELD: [f64; 2] = [300.0, 900.0];
/// Steps from commissioning to a change, or until reports are judged.
const BEFORE: usize = 100;
/// Time without temperatures of a sound spindle, s.
const LOST: std::ops::Range<u64> = 480..540;
/// Noise of the load cells, N; of the moments, N m.
const CELLS: [f64; 5] = [1.0, 1.0, 1.0, 0.05, 0.05];
/// Blows of coolant, um, and ticks of each.
const BLOWS: [f64; 2] = [20.0, 80.0];
const BLOWN: [f64; 2] = [10.0, 60.0];

/// A spindle and its monitor.
struct Machine<'m, 'u> {
    used: &'m mut Used<'u>,
    row: &'m Row,
    random: Random,
    monitor: Box<DynMonitor<PROBES>>,
    tick: u64,
    last: u64,
    /// Speed, rpm, and turns.
    rpm: f64,
    turns: f64,
    /// The part of the cut's loads that acts.
    part: f64,
    /// A blow of coolant: how far, when it begins and for how many ticks.
    blow: (f64, u64, u64),
    /// What the probes have said last.
    said: [Option<f32>; PROBES],
    /// Steps, and gains of the probes, at the change.
    changed: Option<usize>,
    gains: [f64; PROBES],
    found: Found,
}

/// Runs a row for so many seconds.
pub fn run(used: &mut Used, row: &Row, random: Random, seconds: u64) -> Found {
    let mut settings = used.filed.file.settings(&Core::STM32F405);
    // A solve ends in its tick, and loads may repeat themselves.
    settings.tick.deadline_cycles = u32::MAX;
    settings.plausibility.stuck_after = 0;
    settings.plausibility.speed_stuck_after = 0;
    let monitor = monitor_of(&used.filed.file, None, settings);
    let mut machine = Machine {
        used,
        row,
        random,
        monitor: monitor.unwrap_or_else(|error| panic!("{error}")),
        tick: 0,
        last: seconds * RATE as u64,
        rpm: 0.0,
        turns: 0.0,
        part: 0.0,
        blow: (0.0, 0, 0),
        said: [None; PROBES],
        changed: None,
        gains: [1.0; PROBES],
        found: Found::default(),
    };
    let mut cut = Cut::of(&mut machine.random);
    while machine.tick < machine.last {
        if row.what.is_mixed(machine.steps()) {
            cut = Cut::of(&mut machine.random);
        }
        let from = machine.rpm;
        for i in 1..=RUN_UP {
            machine.rpm = from + (SPEEDS[cut.speed] - from) * i as f64 / RUN_UP as f64;
            machine.tick(cut, [0.0; PROBES], 0.0);
        }
        let per_load = machine.used.measured(cut);
        for step in 0..=STEPS {
            for _ in 0..machine.random.between(HELD[0], HELD[1]) as usize {
                machine.tick(cut, per_load, (step % 2) as f64);
            }
        }
        machine.used.wander(&mut machine.random, 0.6 * STEPS as f64);
    }
    if let Some(report) = machine.monitor.probes_report() {
        let found = &mut machine.found;
        found.finish(&report);
        let change = report.change.unwrap_or_default();
        let [value, error] = [change.value, change.error].map(f64::from);
        let gains = [0, 1].map(|i| f64::from(report.probes[i].gain.value) / machine.gains[i] - 1.0);
        found.end = [value.ln_1p(), error / (1.0 + value), gains[0], gains[1]];
    }
    machine.found
}

impl Machine<'_, '_> {
    /// Load steps that the monitor has counted.
    fn steps(&self) -> usize {
        self.monitor
            .probes_report()
            .map_or(0, |report| report.steps as usize)
    }

    /// A tick, with the loads of the cut on their way to this part of them.
    fn tick(&mut self, cut: Cut, per_load: [f64; PROBES], to: f64) {
        self.tick += 1;
        self.turns += self.rpm / 60.0 / RATE;
        self.part += (to - self.part).clamp(-1.0 / RAMP, 1.0 / RAMP);
        let load = self.used.load(cut);
        let load = from_fn(|i| (self.part * load[i] + CELLS[i] * normal(&mut self.random)) as f32);
        let seconds = self.tick / RATE as u64;
        let is_lost = self.row.what == What::Nothing && LOST.contains(&seconds);
        let reference = self
            .used
            .filed
            .file
            .heat
            .as_ref()
            .map(|heat| [heat.reference as f32; 2]);
        let time_us = self.tick * (1e6 / RATE) as u64;
        let readings = Readings {
            loads: Ok(Some(LoadSample {
                time_us,
                load,
                speed: Some((self.rpm / 60.0 * TAU) as f32),
                residual: 0.0,
                doubts: Marks::new(),
            })),
            speed: None,
            temperatures: reference.filter(|_| !is_lost),
        };
        self.said = from_fn(|i| self.says(i, per_load[i]));
        self.monitor.note_displacements(self.said);
        let outcome = self
            .monitor
            .tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
        for change in &outcome.changes {
            if change.change == AlarmChange::Raised {
                let from = self.changed.or(self.found.commissioned);
                let after = from.map(|from| self.steps() - from);
                self.found.raise(change.alarm, after);
            }
            self.monitor.acknowledge(time_us, change.alarm);
        }
        while self.monitor.outbox().next_byte().is_some() {}
        if self.found.commissioned.is_none() && self.monitor.is_commissioned() {
            self.found.commissioned = Some(self.steps());
        }
        if self.tick.is_multiple_of(RATE as u64) {
            self.second();
        }
    }

    /// What a probe says of the motion by the loads of the cut.
    fn says(&mut self, probe: usize, per_load: f64) -> Option<f32> {
        let angle = TAU * self.turns;
        let hours = self.tick as f64 / RATE;
        let motion = self.part * per_load
            + DRIFT * hours
            + RUNOUT * (angle.sin() + 0.3 * (2.0 * angle).cos())
            + NOISE * normal(&mut self.random);
        let motion = motion as f32;
        let fault = match self.row.what {
            What::Probe(of, fault)
                if of == probe && (self.row.what.is_always() || self.changed.is_some()) =>
            {
                fault
            }
            _ => return Some(motion),
        };
        match fault {
            Fault::Millimetres => Some(1e-3 * motion),
            Fault::Sign => Some(-motion),
            Fault::Frozen => self.said[probe],
            Fault::OverRange => Some(1e3),
            Fault::CutOff => None,
            Fault::Coolant => {
                let (far, from, long) = self.blow;
                if self.tick >= from + long {
                    let random = &mut self.random;
                    let far = random.between(BLOWS[0], BLOWS[1])
                        * if random.chance(0.5) { 1.0 } else { -1.0 };
                    let wait = random.between(0.0, 2.0 * RATE) as u64;
                    self.blow = (
                        far,
                        self.tick + wait,
                        random.between(BLOWN[0], BLOWN[1]) as u64,
                    );
                }
                Some(if self.tick >= from {
                    motion + far as f32
                } else {
                    motion
                })
            }
        }
    }

    /// Once a second: a change that is due, and a judged report.
    fn second(&mut self) {
        let Some(report) = self.monitor.probes_report() else {
            return;
        };
        let what = self.row.what;
        let at = self.found.commissioned.unwrap_or(usize::MAX - BEFORE);
        let is_late = self.tick >= self.last / 2 && matches!(what, What::Probe(..));
        let is_due = report.steps as usize >= at + BEFORE || is_late;
        if is_due && self.changed.is_none() {
            self.changed = Some(report.steps as usize);
            self.gains = from_fn(|i| report.probes[i].gain.value.into());
            if !what.is_always() {
                self.used.change(what);
                self.found.alarms = Default::default();
            }
        }
        if self.changed.is_some() {
            self.found.judge(&report, self.used.preload());
        }
    }
}
