//! Hertz contact with exact elliptic integrals.

use super::number::Scalar;
use crate::double_double::Dd;

/// Constants of one contact, per design.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hertz {
    /// Load-deformation constant in N/m^1.5.
    pub(super) k: Dd,
    /// `a* E sqrt(2 / (d* S))`: semi-major axis times elliptic `E` is this times `sqrt(delta)`.
    pub(super) axis: Dd,
    /// Curvature sums along and across the rolling direction in 1/m, compliance in 1/Pa.
    curvature: [Dd; 2],
    pub(super) compliance: Dd,
}

/// Complete elliptic integrals `(K, E)` of parameter `1 - 1/kappa^2`, by the arithmetic-geometric mean.
fn elliptic<T: Scalar>(kappa: T) -> (T, T) {
    let [one, two, half] = [1.0, 2.0, 0.5].map(|x| T::of(Dd::of(x)));
    let mut a = one;
    let mut g = one / kappa;
    let mut weight = half;
    let mut sum = weight * (one - g * g);
    for _ in 0..9 {
        let c = (a - g) * half;
        let next = (a + g) * half;
        g = (a * g).sqrt();
        a = next;
        weight = weight * two;
        sum = sum + weight * c * c;
    }
    let k = T::of(Dd::PI) / (two * a);
    (k, k * (one - sum))
}

/// Curvature difference of an ellipse of contact of ellipticity `kappa`.
fn curvature_difference<T: Scalar>(kappa: T) -> T {
    let [one, two] = [1.0, 2.0].map(|x| T::of(Dd::of(x)));
    let (k, e) = elliptic(kappa);
    let k2 = kappa * kappa;
    ((k2 + one) * e - two * k) / ((k2 - one) * e)
}

impl Hertz {
    /// `rx`, `ry`: curvature sums along and across the rolling direction in 1/m; `c`: compliance in 1/Pa.
    pub(super) fn new(rx: Dd, ry: Dd, c: Dd) -> Option<Hertz> {
        let s = rx + ry;
        let fr = (rx - ry) / s;
        let excess = |kappa: Dd| curvature_difference(kappa) - fr;
        // Bisection in log kappa, then Newton in double-double with a differenced slope.
        let (mut low, mut high) = (1e-6_f64, 14.0_f64);
        if !(fr.hi > 0.0 && fr.hi < 1.0) {
            return None;
        }
        for _ in 0..60 {
            let mid = 0.5 * (low + high);
            if curvature_difference(mid.exp()) < fr.hi {
                low = mid;
            } else {
                high = mid;
            }
        }
        let mut kappa = Dd::of((0.5 * (low + high)).exp());
        for _ in 0..5 {
            let h = Dd::of(kappa.hi * 1e-10);
            let f = excess(kappa);
            kappa = kappa - f * h / (excess(kappa + h) - f);
        }
        let (k, e) = elliptic(kappa);
        Some(Hertz::of_ellipse(kappa, k, e, [rx, ry], c))
    }

    /// Constants of an ellipse of ellipticity `kappa` with these elliptic integrals.
    fn of_ellipse(kappa: Dd, k: Dd, e: Dd, [rx, ry]: [Dd; 2], c: Dd) -> Hertz {
        let s = rx + ry;
        let two = Dd::of(2.0);
        let k2e = kappa * kappa * e;
        let a_star = (two * k2e / Dd::PI).cbrt();
        let d_star = two * k / Dd::PI * (Dd::PI / (two * k2e)).cbrt();
        // delta = d* g^2 S / 2 with g^3 = 3 Q c / (2 S), solved for Q.
        let g_per_root = (two / (d_star * s)).sqrt();
        Hertz {
            k: two * s / (Dd::of(3.0) * c) * g_per_root * g_per_root * g_per_root,
            axis: a_star * e * g_per_root,
            curvature: [rx, ry],
            compliance: c,
        }
    }

    /// This contact with ellipticity and elliptic integrals by fits instead of their exact values: Brewe
    /// and Hamrock, J. Lubr. Technol. 99 (1977).
    pub(super) fn fitted(&self) -> Hertz {
        let [rx, ry] = self.curvature.map(Dd::value);
        let ratio = rx / ry;
        let kappa = 1.0339 * ratio.powf(0.636);
        let e = 1.0003 + 0.5968 / ratio;
        let k = 1.5277 + 0.6023 * ratio.ln();
        let [kappa, k, e] = [kappa, k, e].map(Dd::of);
        Hertz::of_ellipse(kappa, k, e, self.curvature, self.compliance)
    }

    /// Force at deformation `delta`, zero without contact.
    pub(super) fn force<T: Scalar>(&self, delta: T) -> T {
        if delta.value() > 0.0 {
            T::of(self.k) * delta * delta.sqrt()
        } else {
            T::of(Dd::ZERO)
        }
    }
}
