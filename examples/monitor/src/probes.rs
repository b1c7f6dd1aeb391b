//! Measured and computed displacement at the probes, tick by tick.

use crate::alarms::Alarm;
use crate::alarms::Threshold;
use crate::command::MOST_PROBES;
use crate::judgement::{Level, Levels};
use crate::pairs::{Pairs, TickReadings};
use crate::response::Response;
use crate::retained::References;
use crate::settings::ResponseSettings;
use crate::telemetry::ProbesReport;
use crate::tracker::Solved;
use core::array::from_fn;

/// Revolutions per minute in a radian per second.
const RPM: f32 = 60.0 / core::f32::consts::TAU;

/// Probes of a monitor.
#[derive(Debug)]
pub(crate) struct Probes<const P: usize> {
    settings: &'static ResponseSettings<P>,
    pub(crate) pairs: Pairs<P>,
    pub(crate) response: Response<P>,
    /// Measured in the tick that comes, um.
    pub(crate) measured: [Option<f32>; P],
}

impl<const P: usize> Probes<P> {
    /// Probes that are read once in a tick of this period, us.
    pub(crate) fn new(
        settings: &'static ResponseSettings<P>,
        thresholds: &[Threshold; Alarm::COUNT],
        period_us: u32,
    ) -> Self {
        const { assert!(P <= MOST_PROBES, "there are four probes at most") };
        let accuracies = settings.probes.each_ref().map(|probe| probe.accuracy);
        let limits = [Alarm::StiffnessLoss, Alarm::StiffnessGain];
        let limits = limits.map(|alarm| thresholds[alarm as usize].raise);
        Self {
            settings,
            pairs: Pairs::default(),
            response: Response::new(accuracies, 1e6 / period_us as f32, limits),
            measured: [None; P],
        }
    }

    /// Displacement at each probe in an equilibrium, um.
    pub(crate) fn computed<const R: usize, const N: usize, const D: usize, const E: usize>(
        &self,
        solution: &Solved<'_, R, N, D, E>,
    ) -> [f32; P] {
        // Probes side by side see one displacement: on an elastic shaft it takes 2,700 cycles of a Cortex-M4F.
        let (mut position, mut displacement) = (f32::NAN, [0.0; 5]);
        self.settings.probes.each_ref().map(|probe| {
            if probe.position != position {
                position = probe.position;
                displacement = solution.displacement_at(position);
            }
            let along = displacement.iter().zip(probe.direction);
            1e6 * along.map(|(u, e)| u * e).sum::<f32>()
        })
    }

    /// Ends a tick: its speed (rad/s) and its loads, if they are believed. The last tick of a block has levels.
    pub(crate) fn tick(
        &mut self,
        tick: u64,
        speed: Option<f32>,
        load: Option<[f32; 5]>,
        levels: &mut Levels,
    ) {
        let readings = TickReadings {
            rpm: speed.map(|speed| RPM * speed),
            load,
            measured: core::mem::replace(&mut self.measured, [None; P]),
        };
        if self.pairs.tick(tick, readings, &mut self.response) {
            let changes = self.response.changes();
            let lost = changes.map(|change| change.map_or(0.0, |change| change.max(0.0)));
            let gained = changes.map(|change| change.map_or(0.0, |change| (-change).max(0.0)));
            let at_fault = changes.map(|change| f32::from(u8::from(change.is_none())));
            levels.set(Alarm::StiffnessLoss, largest(lost));
            levels.set(Alarm::StiffnessGain, largest(gained));
            levels.set(Alarm::Probe, largest(at_fault));
        }
    }

    /// Report for the telemetry.
    pub(crate) fn report(&self) -> ProbesReport {
        ProbesReport {
            aliased: self.response.is_aliased(),
            probes: self.response.reports().into_iter().collect(),
        }
    }

    /// Goes on with the references of an earlier start.
    pub(crate) fn set_past(&mut self, references: &References) {
        self.response
            .set_references(from_fn(|i| *references.get(i)?));
    }

    /// References to be kept.
    pub(crate) fn references(&self) -> References {
        let ratios = self.response.references();
        from_fn(|i| *ratios.get(i)?)
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
