//! The probes of a monitor: from readings to the estimated preload, and back to the growth of the rows that the solves take.

use crate::alarms::{Alarm, Threshold};
use crate::blocks::{Blocks, Look};
use crate::command::MOST_PROBES;
use crate::estimator::{Constants, Estimate, Estimator, Kept, State, Step};
use crate::judgement::{AlarmState, Changes, Judgement, Level, Levels};
use crate::pairs::{Pairs, TickReadings};
use crate::preload::{PreloadBy, PreloadLaw, exp};
use crate::settings::ResponseSettings;
use crate::telemetry::{ProbeReport, ProbesReport};
use crate::tracker::Solved;
use core::array::from_fn;
use spindle_bearing::sqrt_f32;

/// Revolutions per minute in a radian per second.
const RPM: f32 = 60.0 / core::f32::consts::TAU;
/// Ticks from one look at slopes to the next: some four in the shortest block.
const LOOK_TICKS: u64 = 12;

/// A day, us.
const DAY_US: u64 = 86_400_000_000;

/// Probes of a monitor, and what they tell of its spindle.
#[derive(Debug)]
pub struct Probes<const P: usize> {
    settings: &'static ResponseSettings<P>,
    limits: [Threshold; 3],
    pairs: Pairs<P>,
    blocks: Blocks<P>,
    estimator: Estimator<P>,
    /// Measured in the tick that comes, um; no numbers where nothing was.
    measured: [f32; P],
    /// A load step that is still to be taken.
    step: Option<Step<P>>,
    /// The tick in which the solves were told another preload or angle, and that of the last look.
    told: u64,
    looked: u64,
    /// Commissioning does not end before this time, us.
    not_before_us: u64,
    /// The estimates that a store is to keep, and since when, us.
    kept: Option<Kept>,
    kept_us: u64,
    /// Closure that the solves were told, besides the file's, and its slope by ln preload, m.
    closure: [f32; 2],
}

impl<const P: usize> Probes<P> {
    /// Probes that are read once in a tick of this period, us.
    pub fn new(
        settings: &'static ResponseSettings<P>,
        thresholds: &[Threshold; Alarm::COUNT],
        period_us: u32,
    ) -> Self {
        Self::with_constants(settings, thresholds, period_us, &Constants::USUAL)
    }

    /// [`Probes::new`] with other constants of the estimator.
    pub fn with_constants(
        settings: &'static ResponseSettings<P>,
        thresholds: &[Threshold; Alarm::COUNT],
        period_us: u32,
        constants: &'static Constants,
    ) -> Self {
        const { assert!(P <= MOST_PROBES, "there are four probes at most") };
        let limits = [
            Alarm::PreloadChange,
            Alarm::StiffnessLoss,
            Alarm::StiffnessGain,
        ];
        let mut probes = Self {
            settings,
            limits: limits.map(|alarm| thresholds[alarm as usize]),
            pairs: Pairs::default(),
            blocks: Blocks::new(settings, 1e6 / period_us as f32),
            estimator: Estimator::new(settings, constants),
            measured: [f32::NAN; P],
            step: None,
            told: 0,
            looked: 0,
            not_before_us: 0,
            kept: None,
            kept_us: 0,
            closure: [0.0; 2],
        };
        probes.tell(0);
        probes
    }

    /// The estimates.
    pub const fn estimator(&self) -> &Estimator<P> {
        &self.estimator
    }

    /// Notes the displacements (um) that the probes measured with the loads of the next tick; none of a probe that gave no value.
    pub fn note(&mut self, measured: [Option<f32>; P]) {
        self.measured = measured.map(|um| um.unwrap_or(f32::NAN));
    }

    /// Begins from the prior: a new bearing, or a host's order. Commissioning does not end before this time, us.
    pub fn forget(&mut self, tick: u64, not_before_us: u64) {
        self.estimator = Estimator::new(self.settings, self.estimator.constants());
        (self.not_before_us, self.kept) = (not_before_us, None);
        self.tell(tick);
    }

    /// The spindle is as it should be; whether it is commissioned.
    pub(crate) fn commission(&mut self) -> bool {
        let is_commissioned = self.estimator.commission();
        if is_commissioned {
            self.kept = self.estimator.kept();
        }
        is_commissioned
    }

    /// Closure of a row, besides the file's, by the preload that is estimated, m.
    pub(crate) fn closure(&self, row: usize) -> f32 {
        let clamps = |law: &PreloadLaw| law.clamps(row);
        let is_clamped = self.settings.preload.as_ref().is_some_and(clamps);
        if is_clamped { self.closure[0] } else { 0.0 }
    }

    /// Lets the solves that begin from now on have the preload and the angles that are estimated.
    #[inline(never)]
    fn tell(&mut self, tick: u64) {
        self.told = tick;
        let fed = self.estimator.fed_preload();
        let law = self.settings.preload.as_ref();
        self.closure = law.map_or([0.0; 2], |law| law.closure(fed));
        self.pairs.forget();
        self.blocks.forget();
    }

    /// Whether a solve of a sample of this tick has the preload and the angles of now.
    const fn is_told(&self, tick: u64) -> bool {
        tick > self.told
    }

    /// Goes on with the estimates of an earlier start.
    pub(crate) fn restore(&mut self, kept: Option<&Kept>) {
        if let Some(kept) = kept {
            self.estimator.restore(kept);
            self.kept = Some(*kept);
            self.tell(0);
        }
    }

    /// The estimates that a store is to keep.
    pub(crate) fn kept(&self) -> Option<Kept> {
        self.kept
    }

    /// Has a store keep new estimates where one is due: once commissioned, where an alarm of them has changed, and once a day.
    pub(crate) fn keep(&mut self, time_us: u64, changes: &Changes) {
        const OURS: [Alarm; 3] = [
            Alarm::PreloadChange,
            Alarm::StiffnessLoss,
            Alarm::StiffnessGain,
        ];
        let has_changed = changes.iter().any(|change| OURS.contains(&change.alarm));
        let is_new = self.kept.is_none() && self.estimator.is_commissioned();
        if has_changed || is_new || time_us.saturating_sub(self.kept_us) >= DAY_US {
            (self.kept, self.kept_us) = (self.estimator.kept(), time_us);
        }
    }

    /// Displacement at each probe in an equilibrium, um.
    pub(crate) fn computed<const R: usize, const N: usize, const D: usize, const E: usize>(
        &self,
        solution: &Solved<'_, R, N, D, E>,
    ) -> [f32; P] {
        self.seen(|position| solution.displacement_at(position))
            .map(|[along, _]| along)
    }

    /// Motion along and across each probe, um, of the shaft's displacement at a position.
    #[inline(never)]
    fn seen(&self, displacement_at: impl Fn(f32) -> [f32; 5]) -> [[f32; 2]; P] {
        // Probes side by side see one displacement: on an elastic shaft it takes 2,700 cycles of a Cortex-M4F.
        let (mut position, mut displacement) = (f32::NAN, [0.0; 5]);
        from_fn(|i| {
            let probe = &self.settings.probes[i];
            if probe.position != position {
                position = probe.position;
                displacement = displacement_at(position);
            }
            let angle = self.estimator.fed_angle(i);
            probe.directions(angle).map(|direction| {
                let along = displacement.iter().zip(direction);
                1e6 * along.map(|(u, e)| u * e).sum::<f32>()
            })
        })
    }

    /// Takes the displacements that a solve gives for a sample.
    pub(crate) fn solved(&mut self, tick: u64, load: &[f32; 5], computed: [f32; P]) {
        if self.is_told(tick) {
            self.pairs.solved(tick, load, computed);
        }
    }

    /// Whether slopes are due of a solve of this tick.
    pub(crate) const fn wants_look(&self, tick: u64) -> bool {
        self.is_told(tick) && tick >= self.looked + LOOK_TICKS
    }

    /// Takes slopes of a solve.
    #[inline(never)]
    pub(crate) fn look<const R: usize, const N: usize, const D: usize, const E: usize>(
        &mut self,
        tick: u64,
        solution: &Solved<'_, R, N, D, E>,
    ) {
        self.looked = tick;
        let across = self.seen(|position| solution.displacement_at(position));
        let by_preload = match self.settings.preload {
            Some(PreloadLaw {
                by: PreloadBy::Closure { rows, .. },
                ..
            }) => {
                let closes = from_fn(|row| {
                    if rows >> row & 1 == 1 {
                        self.closure[1]
                    } else {
                        0.0
                    }
                });
                let change = solution.by_closures(closes);
                self.seen(|position| change.displacement_at(position))
            }
            Some(law) => {
                let per_ln = law.newtons(self.estimator.fed_preload());
                let change = solution.by_spring();
                self.seen(|position| change.displacement_at(position))
                    .map(|both| both.map(|u| per_ln * u))
            }
            None => [[0.0; 2]; P],
        };
        self.blocks.look(&from_fn(|i| Look {
            across: across[i][1],
            by_preload: by_preload[i][0],
        }));
    }

    /// Ends a tick: its speed (rad/s) and its loads, if they are believed. The last tick of a block has levels.
    #[inline(never)]
    pub(crate) fn tick(
        &mut self,
        tick: u64,
        speed: Option<f32>,
        load: Option<[f32; 5]>,
        levels: &mut Levels,
    ) {
        let readings = TickReadings {
            rpm: speed.map_or(f32::NAN, |speed| RPM * speed),
            load: load.unwrap_or([f32::NAN; 5]),
            measured: core::mem::replace(&mut self.measured, [f32::NAN; P]),
        };
        if let Some(step) = self.pairs.tick(tick, readings, &mut self.blocks) {
            self.step = step.or(self.step);
            self.levels(levels);
        }
    }

    /// Whether a load step waits.
    pub(crate) const fn has_step(&self) -> bool {
        self.step.is_some()
    }

    /// Takes the load step that waits.
    #[inline(never)]
    pub(crate) fn take_step(&mut self, time_us: u64, tick: u64) {
        let Some(step) = self.step.take() else { return };
        self.estimator.take(&step, time_us >= self.not_before_us);
        if self.estimator.feed() {
            self.tell(tick);
        }
    }

    /// Takes a load step and its levels at once, as where a block ends and no solve is due.
    pub fn step(&mut self, time_us: u64, step: Step<P>, levels: &mut Levels) {
        self.step = Some(step);
        self.take_step(time_us, 0);
        self.levels(levels);
    }

    #[inline(never)]
    fn levels(&self, levels: &mut Levels) {
        let is_at_fault = |i: usize| f32::from(u8::from(self.is_at_fault(i)));
        levels.set(Alarm::Probe, largest::<P>(from_fn(is_at_fault)));
        if !self.estimator.is_commissioned() {
            return;
        }
        if self.settings.preload.is_some()
            && let Some(level) = self.known(0, self.change(), self.estimator.constants().errors[0])
        {
            levels.set_value(Alarm::PreloadChange, level);
        }
        for (limit, alarm, sign) in [
            (1, Alarm::StiffnessLoss, 1.0),
            (2, Alarm::StiffnessGain, -1.0),
        ] {
            let change = |i: usize| {
                let Estimate { value, error } = self.estimator.gain_change(i);
                let change = Estimate {
                    value: (sign * value).max(0.0),
                    error,
                };
                let known = self.known(limit, change, self.estimator.constants().errors[1]);
                known.unwrap_or(0.0)
            };
            levels.set(alarm, largest::<P>(from_fn(change)));
        }
    }

    /// The amount of a change as a level of its alarm: none if it is beyond the level that clears the alarm, but within so many errors.
    fn known(&self, limit: usize, change: Estimate, errors: f32) -> Option<f32> {
        let level = change.value.abs();
        let is_known = level > errors * change.error || level <= self.limits[limit].clear;
        is_known.then_some(level)
    }

    /// Change of the preload since commissioning, part of 1, with the error by the temperatures.
    #[inline(never)]
    fn change(&self) -> Estimate {
        let Estimate { value, error } = self.estimator.preload_change();
        let [error, heat] = [error, self.by_heat()];
        let ratio = exp(value);
        Estimate {
            value: ratio - 1.0,
            error: ratio * sqrt_f32(error * error + heat * heat),
        }
    }

    /// Error of ln preload by the temperatures' accuracy.
    fn by_heat(&self) -> f32 {
        let law = self.settings.preload.as_ref();
        let per_kelvin = law.map_or(0.0, |law| law.per_kelvin(self.estimator.preload().value));
        self.settings.heat * per_kelvin
    }

    fn is_at_fault(&self, probe: usize) -> bool {
        self.estimator.is_at_fault(probe) || self.blocks.is_stuck(probe)
    }

    /// Report for the telemetry.
    #[inline(never)]
    pub fn report(&self, alarms: &Judgement) -> ProbesReport {
        let stands = |alarm: Alarm| {
            let state = alarms.alarm(alarm).state();
            matches!(state, AlarmState::Raised | AlarmState::Acknowledged)
        };
        let commissioned = self.estimator.is_commissioned();
        let probes: [ProbeReport; P] = from_fn(|i| {
            let Estimate { value, error } = self.estimator.gain_change(i);
            let is_beyond = |limit: usize, alarm: Alarm, change: f32| {
                let Threshold { raise, clear, .. } = self.limits[limit];
                let least = if stands(alarm) { clear } else { raise };
                change > least && change > self.estimator.constants().errors[1] * error
            };
            ProbeReport {
                state: if self.is_at_fault(i) {
                    State::Probe
                } else if !commissioned || self.estimator.is_learning(i) {
                    State::Learning
                } else if is_beyond(1, Alarm::StiffnessLoss, value) {
                    State::StiffnessLoss
                } else if is_beyond(2, Alarm::StiffnessGain, -value) {
                    State::StiffnessGain
                } else {
                    State::Ok
                },
                gain: self.estimator.gain(i),
                ratio: self.estimator.ratio(i),
            }
        });
        let has = |state: State| probes.iter().any(|probe| probe.state == state);
        let change = self.change();
        let law = self.settings.preload.as_ref();
        let is_unknown =
            self.estimator.constants().errors[0] * change.error >= self.limits[0].raise;
        let state = if probes.iter().all(|probe| probe.state == State::Probe) {
            State::Probe
        } else if stands(Alarm::PreloadChange) {
            if change.value < 0.0 {
                State::PreloadLoss
            } else {
                State::PreloadGrowth
            }
        } else if has(State::StiffnessLoss) {
            State::StiffnessLoss
        } else if has(State::StiffnessGain) {
            State::StiffnessGain
        } else if self.estimator.is_unexplained() {
            State::Unexplained
        } else if !commissioned {
            State::Learning
        } else if law.is_some() && is_unknown {
            State::Unknown
        } else {
            State::Ok
        };
        ProbesReport {
            state,
            preload: law.map(|law| {
                let Estimate { value, error } = self.estimator.preload();
                let (force, heat) = (law.newtons(value), self.by_heat());
                Estimate {
                    value: force,
                    error: force * sqrt_f32(error * error + heat * heat),
                }
            }),
            change: law.filter(|_| commissioned).map(|_| change),
            steps: self.estimator.steps(),
            aliased: self.blocks.is_aliased(),
            probes: probes.into_iter().collect(),
        }
    }
}

/// The largest level, and its probe.
fn largest<const P: usize>(levels: [f32; P]) -> Level {
    let mut worst = Level::of(0.0);
    for (probe, value) in (0..).zip(levels) {
        if value > worst.value {
            worst = Level {
                value,
                place: Some(probe),
            };
        }
    }
    worst
}
