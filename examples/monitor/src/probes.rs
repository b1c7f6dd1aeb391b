//! Measured and computed displacement at the probes, tick by tick.

use crate::pairs::{Pairs, TickReadings};
use crate::response::Response;
use crate::settings::{ProbeSettings, ResponseSettings};

/// Revolutions per minute in a radian per second.
const RPM: f32 = 60.0 / core::f32::consts::TAU;

/// Probes of a monitor.
#[derive(Debug)]
pub(crate) struct Probes<const P: usize> {
    settings: &'static ResponseSettings<P>,
    pairs: Pairs<P>,
    pub(crate) response: Response<P>,
    /// Measured in the tick that comes, um.
    pub(crate) measured: [Option<f32>; P],
}

impl<const P: usize> Probes<P> {
    /// Probes that are read once in a tick of this period, us.
    pub(crate) fn new(settings: &'static ResponseSettings<P>, period_us: u32) -> Self {
        let accuracies = settings.probes.each_ref().map(|probe| probe.accuracy);
        Self {
            settings,
            pairs: Pairs::default(),
            response: Response::new(accuracies, 1e6 / period_us as f32, settings.limit),
            measured: [None; P],
        }
    }

    /// Takes the equilibrium of a tick's loads: the displacement (m, rad) of the shaft at each position (m).
    pub(crate) fn see(
        &mut self,
        tick: u64,
        load: &[f32; 5],
        displacement: impl Fn(f32) -> [f32; 5],
    ) {
        let seen = |probe: &ProbeSettings| {
            let along = displacement(probe.position).into_iter();
            1e6 * along.zip(probe.direction).map(|(u, e)| u * e).sum::<f32>()
        };
        let computed = self.settings.probes.each_ref().map(seen);
        self.pairs.solved(tick, load, computed);
    }

    /// Ends a tick: its speed (rad/s) and its loads, if they are believed.
    pub(crate) fn tick(&mut self, tick: u64, speed: Option<f32>, load: Option<[f32; 5]>) {
        let readings = TickReadings {
            rpm: speed.map(|speed| RPM * speed),
            load,
            measured: core::mem::replace(&mut self.measured, [None; P]),
        };
        self.pairs.tick(tick, readings, &mut self.response);
    }
}
