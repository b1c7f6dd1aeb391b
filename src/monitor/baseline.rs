//! Stiffness of the good spindle, and when a later stiffness may be held against it.

use serde::{Deserialize, Serialize};

/// Bands of speed.
pub const BANDS: usize = 16;

/// When stiffness is compared, and how the baseline is learnt.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BaselineSettings {
    /// Width of a band of speed, rad/s. The last of the [`BANDS`] is open to above.
    pub band_width: f32,
    /// Lowest and highest axial load `Fx` of an idling spindle, N: what preload and tool make of it.
    pub idle_axial: [f32; 2],
    /// Largest radial load of an idling spindle, N.
    pub idle_radial: f32,
    /// Largest tilting moment of an idling spindle, N m.
    pub idle_moment: f32,
    /// Estimates that a band's mean takes to count.
    pub least_estimates: u32,
}

impl BaselineSettings {
    /// Whether these are loads of an idling spindle.
    pub fn idles(&self, [fx, fy, fz, my, mz]: &[f32; 5]) -> bool {
        let [low, high] = self.idle_axial;
        let square = |x: f32| x * x;
        *fx >= low
            && *fx <= high
            && fy * fy + fz * fz <= square(self.idle_radial)
            && my * my + mz * mz <= square(self.idle_moment)
    }
}

/// Stiffness of the good spindle, idling, by bands of speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Baseline {
    /// Mean diagonal of the stiffness in each band, N/m and N m/rad.
    pub stiffness: [[f32; 5]; BANDS],
    /// Estimates that the mean is of.
    pub estimates: [u32; BANDS],
}

impl Baseline {
    /// Nothing learnt.
    pub const EMPTY: Self = Self {
        stiffness: [[0.0; 5]; BANDS],
        estimates: [0; BANDS],
    };

    /// The band of a speed, if the spindle idles.
    fn band(settings: &BaselineSettings, load: &[f32; 5], speed: f32) -> Option<usize> {
        if !settings.idles(load) {
            return None;
        }
        // The cast saturates.
        let band = (speed.abs() / settings.band_width) as usize;
        Some(band.min(BANDS - 1))
    }

    /// Takes an estimate into the mean of its band, if the spindle idles.
    pub fn learn(
        &mut self,
        settings: &BaselineSettings,
        load: &[f32; 5],
        speed: f32,
        stiffness: &[f32; 5],
    ) {
        let Some(band) = Self::band(settings, load, speed) else {
            return;
        };
        if !stiffness.iter().all(|k| k.is_finite() && *k > 0.0) {
            return;
        }
        let (Some(mean), Some(count)) =
            (self.stiffness.get_mut(band), self.estimates.get_mut(band))
        else {
            return;
        };
        *count = count.saturating_add(1);
        // Beyond this many the mean forgets slowly instead of rounding new ones away.
        let weight = 1.0 / (*count).min(100_000) as f32;
        for (mean, k) in mean.iter_mut().zip(stiffness) {
            *mean += (k - *mean) * weight;
        }
    }

    /// Stiffness over the baseline, element by element; none if the spindle does not idle, or its band is
    /// not known.
    pub fn ratio(
        &self,
        settings: &BaselineSettings,
        load: &[f32; 5],
        speed: f32,
        stiffness: &[f32; 5],
    ) -> Option<[f32; 5]> {
        let band = Self::band(settings, load, speed)?;
        let (mean, count) = (self.stiffness.get(band)?, self.estimates.get(band)?);
        if *count < settings.least_estimates.max(1) {
            return None;
        }
        let mut ratio = *stiffness;
        for (k, mean) in ratio.iter_mut().zip(mean) {
            *k /= mean;
        }
        ratio.iter().all(|r| r.is_finite()).then_some(ratio)
    }
}
