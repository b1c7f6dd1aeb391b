//! Error of estimates by the accuracy of their loads.
//!
//! Now and then the loads of an estimate are solved once more, with one of them off by its accuracy
//! ([`MonitorSettings::accuracy`](crate::settings::MonitorSettings::accuracy)). The changes add up over the loads: each may be
//! off by its accuracy in either direction.

use crate::telemetry::EstimateReport;
use core::array::from_fn;

/// Time from one load to the next, us: all five within a second.
pub(crate) const ACCURACY_US: u32 = 200_000;

/// Changes of the nose's translations (m) and of the largest contact force (N), and relative ones of the stiffness at the nose.
type Changes = [f32; 9];

/// Changes of an estimate by each load's accuracy.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sensitivity {
    /// None before the first, and where the loads had no equilibrium.
    by_load: [Option<Changes>; 5],
    /// The load that was last.
    last: usize,
}

impl Sensitivity {
    /// The next load that has an accuracy, and its accuracy.
    pub(crate) fn next(&mut self, accuracy: &[f32; 5]) -> Option<(usize, f32)> {
        let known = accuracy.iter().copied().enumerate();
        let mut known = known.filter(|(_, accuracy)| *accuracy > 0.0);
        let first = known.clone().next()?;
        let next = known.find(|(load, _)| *load > self.last).unwrap_or(first);
        self.last = next.0;
        Some(next)
    }

    /// Takes the estimate with this load off, beside the one without.
    pub(crate) fn take(&mut self, load: usize, at: &EstimateReport, off: &EstimateReport) {
        let [x, y, z, ..] = from_fn::<f32, 5, _>(|i| off.displacement[i] - at.displacement[i]);
        let [kx, ky, kz, kty, ktz] = from_fn(|i| off.stiffness[i] / at.stiffness[i] - 1.0);
        let force = off.largest_force - at.largest_force;
        let changes = [x, y, z, force, kx, ky, kz, kty, ktz].map(f32::abs);
        if let Some(place) = self.by_load.get_mut(load) {
            let before = place.unwrap_or(changes);
            // Teeth come and go: no less than half of it counts once more.
            *place = Some(from_fn(|i| changes[i].max(0.5 * before[i])));
        }
    }

    /// With this load off, there is no equilibrium.
    pub(crate) fn lose(&mut self, load: usize) {
        if let Some(place) = self.by_load.get_mut(load) {
            *place = None;
        }
    }

    /// Relative errors of displacement, contact forces and stiffness of an estimate by these accuracies: at most 1, where nothing
    /// is known.
    pub(crate) fn errors(&self, report: &EstimateReport, accuracy: &[f32; 5]) -> [f32; 3] {
        let mut sums = [0.0; 9];
        for (changes, accuracy) in self.by_load.iter().zip(accuracy) {
            if !(*accuracy > 0.0) {
                continue;
            }
            let Some(changes) = changes else {
                return [1.0; 3];
            };
            sums = from_fn(|i| sums[i] + changes[i]);
        }
        let largest = |numbers: &[f32]| numbers.iter().fold(0.0, |most: f32, x| most.max(x.abs()));
        let [x, y, z, force, stiffness @ ..] = sums;
        let [ux, uy, uz, ..] = report.displacement;
        let errors = [
            largest(&[x, y, z]) / largest(&[ux, uy, uz]).max(f32::MIN_POSITIVE),
            force / report.largest_force.max(f32::MIN_POSITIVE),
            largest(&stiffness),
        ];
        errors.map(|error| error.min(1.0))
    }
}
