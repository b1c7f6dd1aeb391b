//! Elastic contact of ball and groove (Hertz 1881), exact.
//!
//! Complete elliptic integrals, and the ellipticity by root finding. The fits of Brewe and Hamrock (1977) are off by up
//! to 2.4 % in the load-deflection constant.
//!
//! Everything is a `const fn` of doubles: it runs in the compiler for a design known there.

use crate::const_math::{cbrt, sqrt};
use crate::design::Material;
use core::f64::consts::PI;

/// Complete elliptic integrals of the first and second kind, `K(m)` and `E(m)`, for `0 <= m < 1`.
///
/// By the arithmetic-geometric mean (Abramowitz and Stegun 17.6).
pub const fn elliptic_integrals(m: f64) -> (f64, f64) {
    let mut a = 1.0;
    let mut b = sqrt(1.0 - m);
    let mut power = 0.5;
    let mut sum = power * m;
    let mut i = 0;
    // Quadratic convergence: from any m representable below 1, 7 steps reach the last digit.
    while i < 8 {
        let c = 0.5 * (a - b);
        let g = sqrt(a * b);
        a = 0.5 * (a + b);
        b = g;
        power *= 2.0;
        sum += power * c * c;
        i += 1;
    }
    let k = PI / (2.0 * a);
    (k, k * (1.0 - sum))
}

/// The contact between a ball and the groove of one ring.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct HertzContact {
    /// `K` of `Q = K delta^(3/2)`, N/m^1.5.
    pub load_deflection: f64,
    /// Ellipticity `kappa`, semi-major over semi-minor axis of the contact.
    pub ellipticity: f64,
    /// Complete elliptic integral of the second kind `E(1 - 1/kappa^2)`.
    pub elliptic_e: f64,
    /// `a / Q^(1/3)`, semi-major axis over the cube root of the load, m/N^(1/3).
    pub semi_major: f64,
    /// `b / Q^(1/3)`, semi-minor axis likewise.
    pub semi_minor: f64,
}

/// Curvature difference `Fr` of an ellipse of ellipticity `kappa`, with its `K` and `E`.
const fn curvature_difference(kappa: f64) -> (f64, f64, f64) {
    let k2 = kappa * kappa;
    let (k, e) = elliptic_integrals(1.0 - 1.0 / k2);
    (((k2 + 1.0) * e - 2.0 * k) / ((k2 - 1.0) * e), k, e)
}

impl HertzContact {
    /// Contact of two bodies with the relative curvatures `rolling > across > 0`, 1/m.
    ///
    /// Each is the sum over both bodies. The compliance is `c = (1-nub^2)/Eb + (1-nu^2)/E`, 1/Pa.
    pub const fn new(rolling: f64, across: f64, compliance: f64) -> Self {
        let sum = rolling + across;
        let target = (rolling - across) / sum;
        // Fr falls with 1/kappa: false position between 1e-6 and 1, with a bisection every eighth
        // step as insurance. Illinois: an end that stays twice counts half.
        let (mut low, mut high) = (1e-6, 0.999_999);
        let mut f_low = curvature_difference(1.0 / low).0 - target;
        let mut f_high = curvature_difference(1.0 / high).0 - target;
        let mut side = 0;
        let mut i = 0;
        while i < 100 && high - low > 1e-16 * high {
            let x = if i % 8 == 7 {
                0.5 * (low + high)
            } else {
                (low * f_high - high * f_low) / (f_high - f_low)
            };
            let f = curvature_difference(1.0 / x).0 - target;
            if f > 0.0 {
                low = x;
                f_low = f;
                if side == -1 {
                    f_high *= 0.5;
                }
                side = -1;
            } else if f < 0.0 {
                high = x;
                f_high = f;
                if side == 1 {
                    f_low *= 0.5;
                }
                side = 1;
            } else {
                low = x;
                high = x;
            }
            i += 1;
        }
        let kappa = 2.0 / (low + high);
        let (_, k, e) = curvature_difference(kappa);
        let k2 = kappa * kappa;
        let a = cbrt(2.0 * k2 * e / PI);
        let b = cbrt(2.0 * e / (PI * kappa));
        let d = 2.0 * k / PI * cbrt(PI / (2.0 * k2 * e));
        // delta = d* g^2 S/2 with g = (3 Q c / (2 S))^(1/3), hence K = Q / delta^(3/2).
        let half = d * sum / 2.0;
        let g = cbrt(3.0 * compliance / (2.0 * sum));
        Self {
            load_deflection: 2.0 * sum / (3.0 * compliance * half * sqrt(half)),
            ellipticity: kappa,
            elliptic_e: e,
            semi_major: a * g,
            semi_minor: b * g,
        }
    }

    /// Contact of a ball of diameter `diameter` (m) with a groove of radius `groove_factor`
    /// diameters. `gamma = D cos(alpha0)/dm`, with a minus sign for the outer ring.
    pub(crate) const fn of_groove(
        diameter: f64,
        gamma: f64,
        groove_factor: f64,
        ring: &Material,
        ball: &Material,
    ) -> Self {
        let rolling = 2.0 / (diameter * (1.0 - gamma));
        let across = (2.0 - 1.0 / groove_factor) / diameter;
        Self::new(rolling, across, ring.compliance() + ball.compliance())
    }

    /// Largest pressure in the contact under the load `q` (N), Pa: `3 Q / (2 pi a b)`.
    pub const fn peak_pressure(&self, q: f64) -> f64 {
        1.5 * cbrt(q) / (PI * self.semi_major * self.semi_minor)
    }
}
