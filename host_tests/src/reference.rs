//! Reference build: the full `4 N + 5` equations of a ball bearing at speed, written the textbook way.
//!
//! Unknowns are the five ring displacements and, per ball, both contact angles and both contact
//! deformations. Every formula is written once, generic over the number type: f64 for values, dual
//! numbers for the exact Jacobian, double-double for the residual. Newton runs in two stages. The
//! first, in f64 and damped, keeps the ball centres as what is stepped so that geometry always
//! closes. The second refines all `4 N + 5` unknowns, held as double-double, until the
//! residual vanishes to about 20 digits: a deformation is 1e-3 to 1e-7 of the lengths it is the
//! difference of, and f64 alone would lose that many digits.
//!
//! Physics: Jones (1960) and Harris, "Rolling Bearing Analysis"; the raceway-control-free attitude is
//! that of Ding (2001) and of Wang et al., Mech. Mach. Theory 82 (2014).
//! It is slow, allocates, and is meant for judging other solvers.

use super::double_double::Dd;
use core::array::from_fn;
use core::fmt;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// Rule for the attitude of a ball's rotation axis and for the shares of its gyroscopic friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attitude {
    /// Raceway-control-free, by d'Alembert's principle (Ding 2001; Wang et al. 2014).
    Raceless,
    /// Outer race control (Jones 1960).
    Outer,
    /// Inner race control (Jones 1960). A ball without inner contact follows outer control.
    Inner,
}

/// Elastic constants and density of a ring or of the balls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus in Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poissons_ratio: f64,
    /// Density in kg/m^3; only that of the balls is used.
    pub density: f64,
}

/// Design of one angular contact ball bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bearing {
    /// Number of balls.
    pub balls: usize,
    /// Ball diameter `D` in m.
    pub ball_diameter: f64,
    /// Pitch diameter `dm` in m.
    pub pitch_diameter: f64,
    /// Inner groove radius over ball diameter.
    pub inner_groove_factor: f64,
    /// Outer groove radius over ball diameter.
    pub outer_groove_factor: f64,
    /// Cosine of the free contact angle. The pair is scaled to length one in double-double.
    pub cos_alpha0: f64,
    /// Sine of the free contact angle.
    pub sin_alpha0: f64,
    /// Azimuth of ball 0 in rad, from +y towards +z.
    pub first_ball: f64,
    /// Rings.
    pub ring: Material,
    /// Balls.
    pub ball: Material,
}

/// State of one ball in equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BallState {
    /// Azimuth in rad.
    pub azimuth: f64,
    /// Inner contact angle in rad.
    pub alpha_i: f64,
    /// Outer contact angle in rad.
    pub alpha_o: f64,
    /// Inner contact force in N.
    pub q_i: f64,
    /// Outer contact force in N.
    pub q_o: f64,
    /// Inner contact deformation in m, negative without contact.
    pub delta_i: f64,
    /// Outer contact deformation in m, negative without contact.
    pub delta_o: f64,
    /// Centrifugal force in N.
    pub fc: f64,
    /// Gyroscopic moment in N m.
    pub mg: f64,
}

/// Equilibrium under a load.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Ring displacements `dx, dy, dz` in m and `ty, tz` in rad.
    pub u: [f64; 5],
    /// Stiffness `dF/du`, rows are forces (N, N m); always of all five freedoms.
    pub k: [[f64; 5]; 5],
    /// The balls.
    pub balls: Vec<BallState>,
    /// Largest remaining imbalance over the largest force, load or contact.
    pub residual: f64,
    /// Newton steps over the whole system, both stages.
    pub iterations: usize,
    /// Inner Hertz constant in N/m^1.5.
    pub ki: f64,
    /// Outer Hertz constant in N/m^1.5.
    pub ko: f64,
}

/// Forces, stiffness and balls at prescribed displacements.
#[derive(Debug, Clone, PartialEq)]
pub struct Law {
    /// Load on the inner ring that holds it there: `Fx, Fy, Fz` in N, `My, Mz` in N m.
    pub force: [f64; 5],
    /// Stiffness `dF/du`, rows are forces.
    pub k: [[f64; 5]; 5],
    /// The balls.
    pub balls: Vec<BallState>,
}

/// How a solve ended without a solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Failure {
    /// An input is not finite or out of range; says which.
    Input(&'static str),
    /// No equilibrium was found for this ball.
    Ball {
        /// Index of the ball.
        index: usize,
    },
    /// A Newton matrix could not be inverted.
    Singular,
    /// Newton stopped short.
    Stalled {
        /// Relative imbalance where it stopped.
        residual: f64,
        /// Newton steps taken.
        iterations: usize,
    },
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Input(what) => write!(f, "invalid input: {what}"),
            Failure::Ball { index } => write!(f, "no equilibrium found for ball {index}"),
            Failure::Singular => write!(f, "singular Newton matrix"),
            Failure::Stalled {
                residual,
                iterations,
            } => write!(
                f,
                "Newton stopped at relative imbalance {residual:e} after {iterations} steps"
            ),
        }
    }
}

impl core::error::Error for Failure {}

// ---------------------------------------------------------------------------------------------
// Number types

/// What the textbook formulas need of a number.
pub(crate) trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A constant.
    fn of(x: Dd) -> Self;
    /// The value, rounded.
    fn value(self) -> f64;
    /// Square root of a number that is not negative.
    fn sqrt(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
}

impl Scalar for f64 {
    fn of(x: Dd) -> f64 {
        x.value()
    }
    fn value(self) -> f64 {
        self
    }
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    fn sin_cos(self) -> (f64, f64) {
        f64::sin_cos(self)
    }
}

impl Scalar for Dd {
    fn of(x: Dd) -> Dd {
        x
    }
    fn value(self) -> f64 {
        Dd::value(self)
    }
    fn sqrt(self) -> Dd {
        Dd::sqrt(self)
    }
    fn sin_cos(self) -> (Dd, Dd) {
        Dd::sin_cos(self)
    }
}

/// Value and derivatives with respect to the four unknowns of a ball.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dual {
    pub(crate) v: f64,
    pub(crate) d: [f64; 4],
}

impl Dual {
    fn unknown(v: f64, k: usize) -> Dual {
        let mut d = [0.0; 4];
        d[k] = 1.0;
        Dual { v, d }
    }
    fn chain(self, v: f64, slope: f64) -> Dual {
        Dual {
            v,
            d: self.d.map(|d| slope * d),
        }
    }
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, o: Dual) -> Dual {
        Dual {
            v: self.v + o.v,
            d: from_fn(|k| self.d[k] + o.d[k]),
        }
    }
}
impl Sub for Dual {
    type Output = Dual;
    fn sub(self, o: Dual) -> Dual {
        Dual {
            v: self.v - o.v,
            d: from_fn(|k| self.d[k] - o.d[k]),
        }
    }
}
#[expect(
    clippy::suspicious_arithmetic_impl,
    reason = "the product rule is a sum"
)]
impl Mul for Dual {
    type Output = Dual;
    fn mul(self, o: Dual) -> Dual {
        Dual {
            v: self.v * o.v,
            d: from_fn(|k| self.d[k] * o.v + self.v * o.d[k]),
        }
    }
}
impl Div for Dual {
    type Output = Dual;
    fn div(self, o: Dual) -> Dual {
        let r = 1.0 / o.v;
        let q = self.v * r;
        Dual {
            v: q,
            d: from_fn(|k| (self.d[k] - q * o.d[k]) * r),
        }
    }
}
impl Neg for Dual {
    type Output = Dual;
    fn neg(self) -> Dual {
        self.chain(-self.v, -1.0)
    }
}
impl Scalar for Dual {
    fn of(x: Dd) -> Dual {
        Dual {
            v: x.value(),
            d: [0.0; 4],
        }
    }
    fn value(self) -> f64 {
        self.v
    }
    fn sqrt(self) -> Dual {
        let r = self.v.sqrt();
        self.chain(r, 0.5 / r)
    }
    fn sin_cos(self) -> (Dual, Dual) {
        let (s, c) = self.v.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }
}

// ---------------------------------------------------------------------------------------------
// Linear algebra

/// Solves `a x = b` for the `m` columns of `b` in place; row-scaled partial pivoting.
fn dense_solve(a: &mut [f64], b: &mut [f64], m: usize) -> Option<()> {
    let n = b.len() / m;
    for r in 0..n {
        let big = a[r * n..(r + 1) * n]
            .iter()
            .fold(0.0_f64, |s, x| s.max(x.abs()));
        if !(big > 0.0 && big.is_finite()) {
            return None;
        }
        a[r * n..(r + 1) * n].iter_mut().for_each(|x| *x /= big);
        b[r * m..(r + 1) * m].iter_mut().for_each(|x| *x /= big);
    }
    for c in 0..n {
        let p = (c..n).max_by(|&i, &j| a[i * n + c].abs().total_cmp(&a[j * n + c].abs()))?;
        if !(a[p * n + c].abs() > 0.0 && a[p * n + c].is_finite()) {
            return None;
        }
        if p != c {
            for k in 0..n {
                a.swap(p * n + k, c * n + k);
            }
            for k in 0..m {
                b.swap(p * m + k, c * m + k);
            }
        }
        for r in c + 1..n {
            let f = a[r * n + c] / a[c * n + c];
            if f != 0.0 {
                for k in c + 1..n {
                    a[r * n + k] -= f * a[c * n + k];
                }
                for k in 0..m {
                    b[r * m + k] -= f * b[c * m + k];
                }
            }
        }
    }
    for c in (0..n).rev() {
        for k in 0..m {
            let mut x = b[c * m + k];
            for j in c + 1..n {
                x -= a[c * n + j] * b[j * m + k];
            }
            b[c * m + k] = x / a[c * n + c];
        }
    }
    b.iter().all(|x| x.is_finite()).then_some(())
}

/// Small fixed-size form of [`dense_solve`].
pub(crate) fn small_solve<const N: usize, const M: usize>(
    mut a: [[f64; N]; N],
    mut b: [[f64; M]; N],
) -> Option<[[f64; M]; N]> {
    dense_solve(a.as_flattened_mut(), b.as_flattened_mut(), M)?;
    Some(b)
}

// ---------------------------------------------------------------------------------------------
// Hertz contact

/// Constants of one contact, per design.
#[derive(Debug, Clone, Copy)]
struct Hertz {
    /// Load-deformation constant in N/m^1.5.
    k: Dd,
    /// `a* E sqrt(2 / (d* S))`: semi-major axis times elliptic `E` is this times `sqrt(delta)`.
    axis: Dd,
    /// Curvature sums along and across the rolling direction in 1/m, compliance in 1/Pa.
    curvature: [Dd; 2],
    compliance: Dd,
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
    fn new(rx: Dd, ry: Dd, c: Dd) -> Option<Hertz> {
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

    /// The same contact with ellipticity and elliptic integrals by the fits of Brewe and Hamrock, J. Lubr.
    /// Technol. 99 (1977), instead of their exact values.
    fn fitted(&self) -> Hertz {
        let [rx, ry] = self.curvature.map(Dd::value);
        let ratio = rx / ry;
        let kappa = 1.0339 * ratio.powf(0.636);
        let e = 1.0003 + 0.5968 / ratio;
        let k = 1.5277 + 0.6023 * ratio.ln();
        let [kappa, k, e] = [kappa, k, e].map(Dd::of);
        Hertz::of_ellipse(kappa, k, e, self.curvature, self.compliance)
    }

    /// Force at deformation `delta`, zero without contact.
    fn force<T: Scalar>(&self, delta: T) -> T {
        if delta.value() > 0.0 {
            T::of(self.k) * delta * delta.sqrt()
        } else {
            T::of(Dd::ZERO)
        }
    }
}

// ---------------------------------------------------------------------------------------------
// One ball

/// Everything the equations of one ball yield.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terms<T> {
    /// Axial and radial gap between the chain of vectors and the inner curvature centre, in m.
    pub(crate) closure: [T; 2],
    /// Axial and radial force imbalance of the ball in N.
    pub(crate) balance: [T; 2],
    /// Axial and radial force on the ring and friction moment: `fa, fr, mt`.
    pub(crate) ring: [T; 3],
    q: [T; 2],
    fc: T,
    mg: T,
}

/// Unknowns of a ball: `alpha_i, alpha_o, delta_i, delta_o`.
pub(crate) type Unknowns<T> = [T; 4];

/// A ball's equations linearised: values, and `d unknowns / d A` and `d ring / d A`.
pub(crate) struct Linear {
    /// Values and derivatives.
    pub(crate) terms: Terms<Dual>,
    /// Jacobian of `closure, balance`.
    pub(crate) jacobian: [[f64; 4]; 4],
}

impl Linear {
    /// Newton step of the unknowns for the residual `r`, and their derivative by `A1, A2`.
    pub(crate) fn solve(&self, r: [f64; 4]) -> Option<([f64; 4], [[f64; 2]; 4])> {
        // The closure rows contain -A, so dA enters them with a plus sign on the right.
        let rhs = from_fn(|k| [-r[k], f64::from(k == 0), f64::from(k == 1)]);
        let x = small_solve(self.jacobian, rhs)?;
        Some((x.map(|r| r[0]), x.map(|r| [r[1], r[2]])))
    }

    /// Derivative of `fa, fr, mt` along `x`, a change of the unknowns.
    pub(crate) fn ring_change(&self, x: &[f64; 4]) -> [f64; 3] {
        self.terms
            .ring
            .map(|t| t.d.iter().zip(x).map(|(a, b)| a * b).sum())
    }

    /// Adds this ball's share `lever^T (d ring / d A) lever` to the stiffness.
    pub(crate) fn add_stiffness(&self, k: &mut [[f64; 5]; 5], g: &[[f64; 2]; 4], st: &Station) {
        let by: [[f64; 3]; 2] = from_fn(|c| self.ring_change(&g.map(|row| row[c])));
        for c in 0..5 {
            let change = from_fn(|i| by[0][i] * st.lever[0][c] + by[1][i] * st.lever[1][c]);
            let mut column = [0.0; 5];
            st.collect(&change, &mut column);
            for (row, x) in k.iter_mut().zip(column) {
                row[c] += x;
            }
        }
    }
}

/// A ball's place in the ring.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Station {
    azimuth: f64,
    /// `A = A0 + lever u`: rows axial, radial, and (for forces only) the friction moment.
    pub(crate) lever: [[f64; 5]; 3],
}

impl Station {
    /// Adds `lever^T g` to the ring force.
    pub(crate) fn collect<T: Scalar>(&self, g: &[T; 3], force: &mut [T; 5]) {
        for (k, f) in force.iter_mut().enumerate() {
            for (row, g) in self.lever.iter().zip(g) {
                if row[k] != 0.0 {
                    *f = *f + T::of(Dd::of(row[k])) * *g;
                }
            }
        }
    }
    /// Change of `A` for a change of `u`.
    pub(crate) fn shift(&self, du: &[f64; 5]) -> [f64; 2] {
        from_fn(|i| (0..5).map(|k| self.lever[i][k] * du[k]).sum())
    }
}

/// A bearing prepared for solving: Hertz constants, lengths, ball places.
#[derive(Debug, Clone)]
pub struct Reference {
    inner: Hertz,
    outer: Hertz,
    /// Distances of the groove curvature centres from the ball centre, unloaded.
    li: Dd,
    lo: Dd,
    /// Inner curvature centre from the outer one, unloaded.
    a0: [Dd; 2],
    tau: Dd,
    diameter: Dd,
    pitch: Dd,
    inner_groove: Dd,
    mass: Dd,
    inertia: Dd,
    /// Derivatives leave out those of the inertia loads and of the friction forces.
    frozen: bool,
    pub(crate) stations: Vec<Station>,
}

/// State of the whole system in the f64 stage.
#[derive(Clone)]
struct Stage {
    u: [f64; 5],
    /// Ball centres from the outer curvature centre, axial and radial.
    x: Vec<[f64; 2]>,
}

/// A problem: what is applied, what is prescribed.
#[derive(Clone, Copy)]
struct Task {
    load: [f64; 5],
    omega: f64,
    attitude: Attitude,
    free: [bool; 5],
    dense: bool,
    /// Follows a solution in ever smaller steps before it gives up.
    thorough: bool,
}

/// Newton direction of the whole system.
struct Direction {
    du: [f64; 5],
    dw: Vec<[f64; 4]>,
}

impl Reference {
    /// Prepares a bearing.
    ///
    /// # Errors
    /// [`Failure::Input`] names the parameter that is out of range.
    pub fn new(b: &Bearing) -> Result<Reference, Failure> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let need = |ok: bool, what| {
            if ok {
                Ok(())
            } else {
                Err(Failure::Input(what))
            }
        };
        need(b.balls > 0, "balls")?;
        need(positive(b.ball_diameter), "ball_diameter")?;
        need(
            positive(b.pitch_diameter) && b.pitch_diameter > b.ball_diameter,
            "pitch_diameter",
        )?;
        need(
            positive(b.inner_groove_factor) && b.inner_groove_factor > 0.5,
            "inner_groove_factor",
        )?;
        need(
            positive(b.outer_groove_factor) && b.outer_groove_factor > 0.5,
            "outer_groove_factor",
        )?;
        need(positive(b.cos_alpha0), "cos_alpha0")?;
        need(b.sin_alpha0.is_finite(), "sin_alpha0")?;
        need(b.first_ball.is_finite(), "first_ball")?;
        for m in [b.ring, b.ball] {
            need(positive(m.youngs_modulus), "youngs_modulus")?;
            need(m.poissons_ratio.abs() < 1.0, "poissons_ratio")?;
        }
        need(positive(b.ball.density), "density")?;

        let one = Dd::ONE;
        let (two, half) = (Dd::of(2.0), Dd::of(0.5));
        let d = Dd::of(b.ball_diameter);
        let dm = Dd::of(b.pitch_diameter);
        let (fi, fo) = (Dd::of(b.inner_groove_factor), Dd::of(b.outer_groove_factor));
        let (c, s) = (Dd::of(b.cos_alpha0), Dd::of(b.sin_alpha0));
        let norm = (c * c + s * s).sqrt();
        let (c, s) = (c / norm, s / norm);
        let (li, lo) = ((fi - half) * d, (fo - half) * d);
        let l0 = li + lo;

        let soft = |m: &Material| {
            let nu = Dd::of(m.poissons_ratio);
            (one - nu * nu) / Dd::of(m.youngs_modulus)
        };
        let compliance = soft(&b.ball) + soft(&b.ring);
        let gamma = d * c / dm;
        let rx_i = two / d + two * gamma / (d * (one - gamma));
        let rx_o = two / d - two * gamma / (d * (one + gamma));
        let contact = |rx: Dd, f: Dd| {
            Hertz::new(rx, two / d - one / (f * d), compliance)
                .ok_or(Failure::Input("groove factor"))
        };

        let mass = Dd::of(b.ball.density) * Dd::PI * d * d * d / Dd::of(6.0);
        let rp = (dm * half + li * c).value();
        let zp = (li * s).value();
        let stations = (0..b.balls)
            .map(|j| {
                let turn = two * Dd::PI * Dd::of(j as f64) / Dd::of(b.balls as f64);
                // The double-double series wants |x| <= pi, hence the half turn and the remainder.
                let first = b.first_ball.rem_euclid(core::f64::consts::TAU);
                let (sf, cf) = if b.first_ball.abs() <= 3.0 {
                    Dd::of(b.first_ball).sin_cos()
                } else {
                    (Dd::of(first) - Dd::PI).sin_cos()
                };
                let sign = Dd::of(if b.first_ball.abs() <= 3.0 { -1.0 } else { 1.0 });
                let (st, ct) = (turn - Dd::PI).sin_cos();
                let (sn, cs) = (sign * (sf * ct + cf * st), sign * (cf * ct - sf * st));
                let (sn, cs) = (sn.value(), cs.value());
                Station {
                    azimuth: (Dd::of(b.first_ball) + turn).value(),
                    lever: [
                        [1.0, 0.0, 0.0, rp * sn, -rp * cs],
                        [0.0, cs, sn, -zp * sn, zp * cs],
                        [0.0, 0.0, 0.0, -sn, cs],
                    ],
                }
            })
            .collect();
        Ok(Reference {
            inner: contact(rx_i, fi)?,
            outer: contact(rx_o, fo)?,
            li,
            lo,
            a0: [l0 * s, l0 * c],
            tau: d / dm,
            diameter: d,
            pitch: dm,
            inner_groove: fi * d,
            mass,
            inertia: mass * d * d / Dd::of(10.0),
            frozen: false,
            stations,
        })
    }

    /// The bearing as a program sees it that gives the gyroscopic moment the wrong sign; for showing
    /// what that does. `Mg` of its balls is negative.
    #[must_use]
    pub fn with_gyroscopic_moment_reversed(mut self) -> Reference {
        self.inertia = -self.inertia;
        self
    }

    /// The bearing under centrifugal force alone: no gyroscopic moment, hence no friction.
    #[must_use]
    pub fn without_gyroscopic_moment(mut self) -> Reference {
        self.inertia = Dd::ZERO;
        self
    }

    /// The bearing as a program sees it that leaves the friction moment `mt` out of the ring's balance;
    /// for showing what that does.
    #[must_use]
    pub fn without_friction_moment(mut self) -> Reference {
        self.inner_groove = Dd::ZERO;
        self
    }

    /// The bearing as a program sees it that takes its contact constants from the fits of Brewe and
    /// Hamrock (1977); for showing what they do.
    #[must_use]
    pub fn with_fitted_contacts(mut self) -> Reference {
        self.inner = self.inner.fitted();
        self.outer = self.outer.fitted();
        self
    }

    /// The stiffness at an equilibrium without the derivatives of centrifugal forces, gyroscopic
    /// moments and friction shares; for showing what leaving them out does.
    ///
    /// # Errors
    /// [`Failure::Singular`] if a ball's equations cannot be inverted.
    pub fn frozen_stiffness(
        &self,
        balls: &[BallState],
        omega: f64,
        attitude: Attitude,
    ) -> Result<[[f64; 5]; 5], Failure> {
        let frozen = Reference {
            frozen: true,
            ..self.clone()
        };
        let linear: Vec<Linear> = balls
            .iter()
            .map(|b| {
                let w = [b.alpha_i, b.alpha_o, b.delta_i, b.delta_o];
                frozen.linearise(&w, &[0.0; 2], omega, attitude)
            })
            .collect();
        frozen.stiffness(&linear, false).ok_or(Failure::Singular)
    }

    /// Number of balls.
    pub fn balls(&self) -> usize {
        self.stations.len()
    }

    /// Inner and outer Hertz constants in N/m^1.5.
    pub fn hertz_constants(&self) -> (f64, f64) {
        (self.inner.k.value(), self.outer.k.value())
    }

    /// Position in m (axial, radial) of ball `j`'s inner curvature centre, from the outer one.
    pub(crate) fn inner_centre<T: Scalar>(&self, j: usize, u: &[T; 5]) -> [T; 2] {
        from_fn(|i| {
            let row = &self.stations[j].lever[i];
            let mut a = T::of(Dd::ZERO);
            for (l, u) in row.iter().zip(u) {
                if *l != 0.0 {
                    a = a + T::of(Dd::of(*l)) * *u;
                }
            }
            T::of(self.a0[i]) + a
        })
    }

    /// Centrifugal force and gyroscopic moment, and the friction shares `lambda_i, lambda_o`.
    #[expect(clippy::too_many_arguments)]
    fn motion<T: Scalar>(
        &self,
        (si, ci): (T, T),
        (so, co): (T, T),
        di: T,
        d_o: T,
        qi: T,
        qo: T,
        omega: f64,
        attitude: Attitude,
    ) -> (T, T, [T; 2]) {
        let zero = T::of(Dd::ZERO);
        let one = T::of(Dd::ONE);
        let two = T::of(Dd::of(2.0));
        let tau = T::of(self.tau);
        let omega = T::of(Dd::of(omega));
        let a = one + tau * co;
        let c = one - tau * ci;
        let touching = di.value() > 0.0;
        // Inner control presumes inner contact.
        let attitude = match attitude {
            Attitude::Inner if !touching => Attitude::Outer,
            other => other,
        };
        // tan b = num / den
        let (num, den, shares) = match attitude {
            Attitude::Raceless => {
                let s = a / c;
                let ratio = if touching {
                    qi * T::of(self.inner.axis) * di.sqrt()
                        / (qo * T::of(self.outer.axis) * d_o.sqrt())
                } else {
                    zero
                };
                let cos_between = ci * co + si * so;
                let total = qi + qo;
                (
                    ratio * (s + one) * si + two * so,
                    ratio * (s + one) * ci + two * (co + tau) + ratio * tau * (cos_between - s),
                    [two * qi / total, two * qo / total],
                )
            }
            Attitude::Outer => (so, co + tau, [zero, two]),
            Attitude::Inner => (si, ci - tau, [one, one]),
        };
        let h = (num * num + den * den).sqrt();
        let (sin_b, cos_b) = (num / h, den / h);
        let cos_ib = ci * cos_b + si * sin_b;
        let cos_ob = co * cos_b + so * sin_b;
        let nb = a * cos_ib + c * cos_ob;
        let orbital = omega * c * cos_ob / nb;
        let rotation = omega * a * c / (tau * nb);
        let half = T::of(Dd::of(0.5));
        let fc = T::of(self.mass) * T::of(self.pitch) * orbital * orbital * half;
        let mg = T::of(self.inertia) * rotation * orbital * sin_b;
        (fc, mg, shares)
    }

    /// The equations of one ball whose inner curvature centre is at `centre`.
    pub(crate) fn evaluate<T: Scalar>(
        &self,
        w: &Unknowns<T>,
        centre: &[T; 2],
        omega: f64,
        attitude: Attitude,
    ) -> Terms<T> {
        let [ai, ao, di, d_o] = *w;
        let (si, ci) = ai.sin_cos();
        let (so, co) = ao.sin_cos();
        let ri = T::of(self.li) + di;
        let ro = T::of(self.lo) + d_o;
        let closure = [ro * so + ri * si - centre[0], ro * co + ri * ci - centre[1]];
        let qi = self.inner.force(di);
        let qo = self.outer.force(d_o);
        let zero = T::of(Dd::ZERO);
        let (mut fc, mut mg, mut shares) = (zero, zero, [zero, zero]);
        if omega != 0.0 {
            (fc, mg, shares) = self.motion((si, ci), (so, co), di, d_o, qi, qo, omega, attitude);
            if self.frozen {
                let constant = |x: T| T::of(Dd::of(x.value()));
                (fc, mg, shares) = (constant(fc), constant(mg), shares.map(constant));
            }
        } else if di.value() <= 0.0 && d_o.value() <= 0.0 {
            // At rest and off both races nothing holds the ball; any rule that fixes it will do.
            let stiff = T::of(self.outer.k * self.lo.sqrt());
            return Terms {
                closure,
                balance: [stiff * T::of(self.lo) * (ai - ao), stiff * (di - d_o)],
                ring: [zero; 3],
                q: [zero; 2],
                fc,
                mg,
            };
        }
        let [ti, to] = shares.map(|share| share * mg / T::of(self.diameter));
        let fa = qi * si + ti * ci;
        let fr = qi * ci - ti * si;
        Terms {
            closure,
            balance: [fa - qo * so - to * co, fr - qo * co + to * so + fc],
            ring: [fa, fr, T::of(self.inner_groove) * ti],
            q: [qi, qo],
            fc,
            mg,
        }
    }

    /// Values and exact derivatives of one ball's equations.
    pub(crate) fn linearise(
        &self,
        w: &Unknowns<f64>,
        centre: &[f64; 2],
        omega: f64,
        attitude: Attitude,
    ) -> Linear {
        let dual = from_fn(|k| Dual::unknown(w[k], k));
        let centre = centre.map(|a| Dual { v: a, d: [0.0; 4] });
        let terms = self.evaluate(&dual, &centre, omega, attitude);
        let [c0, c1] = terms.closure;
        let [b0, b1] = terms.balance;
        Linear {
            jacobian: [c0.d, c1.d, b0.d, b1.d],
            terms,
        }
    }

    /// Angles and deformations of a ball centred at `x`; closes the geometry by construction.
    pub(crate) fn unknowns(&self, x: &[f64; 2], centre: &[f64; 2]) -> Unknowns<f64> {
        let to = [centre[0] - x[0], centre[1] - x[1]];
        [
            to[0].atan2(to[1]),
            x[0].atan2(x[1]),
            to[0].hypot(to[1]) - self.li.hi,
            x[0].hypot(x[1]) - self.lo.hi,
        ]
    }

    /// Linear change of the ball centre that belongs to a change of its unknowns.
    pub(crate) fn centre_change(&self, w: &Unknowns<f64>, dw: &[f64; 4]) -> [f64; 2] {
        let (s, c) = w[1].sin_cos();
        let turn = (self.lo.hi + w[3]) * dw[1];
        [dw[3] * s + turn * c, dw[3] * c - turn * s]
    }

    /// Centre of a ball at rest between the races, in closed form.
    pub(crate) fn resting(&self, centre: &[f64; 2]) -> [f64; 2] {
        let length = centre[0].hypot(centre[1]);
        let delta = length - (self.li + self.lo).hi;
        // Springs in series share delta like K^(-2/3); without contact any share will do.
        let share = if delta > 0.0 {
            1.0 / (1.0 + (self.outer.k.hi / self.inner.k.hi).powf(2.0 / 3.0))
        } else {
            0.5
        };
        let r = (self.lo.hi + share * delta) / length;
        [centre[0] * r, centre[1] * r]
    }

    /// Centre of a ball held by the outer race alone.
    fn flung(&self, centre: &[f64; 2], omega: f64, attitude: Attitude) -> [f64; 2] {
        let mut x = [0.0, self.lo.hi * (1.0 + 1e-9)];
        for _ in 0..3 {
            let mut w = self.unknowns(&x, centre);
            w[2] = -1.0;
            let fc = self.evaluate(&w, centre, omega, attitude).fc;
            x[1] = self.lo.hi + (fc / self.outer.k.hi).powf(2.0 / 3.0);
        }
        x
    }

    /// Centre of a ball thrown into the wedge between the races, where the circles on which it touches
    /// one race each cross, a little further out by what its centrifugal force presses in.
    fn wedged(&self, centre: &[f64; 2], flung: &[f64; 2]) -> [f64; 2] {
        let length = centre[0].hypot(centre[1]);
        let press = flung[1] - self.lo.hi;
        let (ro, ri) = (self.lo.hi + press, self.li.hi + press);
        let along = (length * length + ro * ro - ri * ri) / (2.0 * length);
        let across = (ro * ro - along * along).max(0.0).sqrt();
        let (ea, er) = (centre[0] / length, centre[1] / length);
        let side = across.copysign(ea);
        [along * ea - side * er, along * er + side * ea]
    }

    /// Newton on one ball's centre from `x`.
    fn ball_newton(
        &self,
        mut x: [f64; 2],
        centre: &[f64; 2],
        omega: f64,
        attitude: Attitude,
    ) -> Option<[f64; 2]> {
        let length = self.lo.hi + self.li.hi;
        let mut w = self.unknowns(&x, centre);
        if w[3] <= 0.0 {
            return None;
        }
        for _ in 0..80 {
            let lin = self.linearise(&w, centre, omega, attitude);
            let t = &lin.terms;
            let scale = t.q[0].v.max(t.q[1].v).max(t.fc.v);
            let size = t.balance[0].v.hypot(t.balance[1].v) / scale;
            // What rounding of the deformations alone leaves.
            let noise = 4.0 * f64::EPSILON * (1.0 + length / w[3].max(w[2]));
            if size <= noise {
                return Some(x);
            }
            let (dw, _) = lin.solve([0.0, 0.0, t.balance[0].v, t.balance[1].v])?;
            let dx = self.centre_change(&w, &dw);
            let mut step = 1.0_f64;
            loop {
                let trial = [x[0] + step * dx[0], x[1] + step * dx[1]];
                let wt = self.unknowns(&trial, centre);
                if wt[3] > 0.05 * w[3] {
                    let t = self.evaluate(&wt, centre, omega, attitude);
                    let new = t.balance[0].hypot(t.balance[1]) / scale;
                    if new <= (1.0 - 1e-4 * step) * size {
                        (x, w) = (trial, wt);
                        break;
                    }
                }
                step *= 0.5;
                if step < 1e-7 {
                    return (size < 1e3 * noise).then_some(x);
                }
            }
        }
        None
    }

    /// Equilibrium of one ball for a given place of the inner curvature centre.
    fn ball_at(
        &self,
        centre: &[f64; 2],
        omega: f64,
        attitude: Attitude,
        guess: Option<[f64; 2]>,
    ) -> Option<[f64; 2]> {
        if omega == 0.0 {
            return Some(self.resting(centre));
        }
        let flung = self.flung(centre, omega, attitude);
        let close = |x: [f64; 2]| self.ball_newton(x, centre, omega, attitude);
        // A lightly loaded ball may have two equilibria: pressed outward, or dragged slowly by the inner
        // race with next to no centrifugal force. From a cold start the former is meant.
        let pressed = |x: [f64; 2]| x[0].hypot(x[1]);
        let from_rest = || {
            let x = close(self.resting(centre))?;
            if attitude == Attitude::Inner || pressed(x) >= pressed(flung) {
                return Some(x);
            }
            // Outer control has only the pressed one, which makes it a start.
            let outer = [flung, self.wedged(centre, &flung), x]
                .into_iter()
                .find_map(|x| self.ball_newton(x, centre, omega, Attitude::Outer));
            [Some(flung), outer]
                .into_iter()
                .flatten()
                .filter_map(close)
                .chain([x])
                .max_by(|a, b| pressed(*a).total_cmp(&pressed(*b)))
        };
        if let Some(x) = guess {
            // Warm: a ball that has to jump makes the caller take a shorter step instead.
            return close(x)
                .or_else(|| close(flung))
                .or_else(|| close(self.resting(centre)));
        }
        from_rest()
            .or_else(|| close(flung))
            .or_else(|| close(self.wedged(centre, &flung)))
            .or_else(|| {
                // Continuation in speed, from nearly at rest.
                let mut x = self.resting(centre);
                for k in 1..=40 {
                    let part = omega * f64::from(k) / 40.0;
                    x = self.ball_newton(x, centre, part, attitude).or_else(|| {
                        let start = self.flung(centre, part, attitude);
                        self.ball_newton(start, centre, part, attitude).or_else(|| {
                            let start = self.wedged(centre, &start);
                            self.ball_newton(start, centre, part, attitude)
                        })
                    })?;
                }
                Some(x)
            })
    }

    /// Places all balls for given displacements.
    fn place(
        &self,
        u: &[f64; 5],
        task: &Task,
        x: &mut [[f64; 2]],
        warm: bool,
    ) -> Result<(), Failure> {
        for (j, x) in x.iter_mut().enumerate() {
            let centre = self.inner_centre(j, u);
            *x = self
                .ball_at(&centre, task.omega, task.attitude, warm.then_some(*x))
                .ok_or(Failure::Ball { index: j })?;
        }
        Ok(())
    }

    // -----------------------------------------------------------------------------------------
    // The whole system

    /// Newton direction for residuals `ball[j]` (4 each) and `ring` (target minus force), by
    /// eliminating the balls one by one or, if `task.dense`, from the full matrix.
    fn direction(
        &self,
        lin: &[Linear],
        ball: &[[f64; 4]],
        ring: &[f64; 5],
        task: &Task,
        damping: f64,
    ) -> Option<Direction> {
        let lever = 0.5 * self.pitch.hi;
        let unit = [1.0, 1.0, 1.0, lever, lever];
        if task.dense {
            return self.dense_direction(lin, ball, ring, &task.free);
        }
        let mut k = [[0.0; 5]; 5];
        let mut rhs = *ring;
        let mut parts = Vec::with_capacity(lin.len());
        for ((lin, r), st) in lin.iter().zip(ball).zip(&self.stations) {
            let (p, g) = lin.solve(*r)?;
            lin.add_stiffness(&mut k, &g, st);
            let mut lost = [0.0; 5];
            st.collect(&lin.ring_change(&p), &mut lost);
            for (r, l) in rhs.iter_mut().zip(lost) {
                *r -= l;
            }
            parts.push((p, g));
        }
        if damping > 0.0 {
            let stiff = (0..3).fold(0.0_f64, |s, i| s.max(k[i][i].abs()));
            for i in 0..5 {
                k[i][i] += damping * stiff * unit[i] * unit[i];
            }
        }
        let du = masked_solve(&k, &rhs, &task.free, &unit)?;
        let dw = parts
            .iter()
            .zip(&self.stations)
            .map(|((p, g), st)| {
                let da = st.shift(&du);
                from_fn(|i| p[i] + g[i][0] * da[0] + g[i][1] * da[1])
            })
            .collect();
        Some(Direction { du, dw })
    }

    /// The `4 N + 5` matrix, factored as it stands.
    fn dense_direction(
        &self,
        lin: &[Linear],
        ball: &[[f64; 4]],
        ring: &[f64; 5],
        free: &[bool; 5],
    ) -> Option<Direction> {
        let balls = lin.len();
        let n = 4 * balls + 5;
        let mut a = vec![0.0; n * n];
        let mut b = vec![0.0; n];
        for (j, (lin, st)) in lin.iter().zip(&self.stations).enumerate() {
            for i in 0..4 {
                b[4 * j + i] = -ball[j][i];
                for c in 0..4 {
                    a[(4 * j + i) * n + 4 * j + c] = lin.jacobian[i][c];
                }
            }
            for i in 0..2 {
                for c in 0..5 {
                    a[(4 * j + i) * n + 4 * balls + c] = -st.lever[i][c];
                }
            }
            for r in 0..5 {
                for c in 0..4 {
                    a[(4 * balls + r) * n + 4 * j + c] = (0..3)
                        .map(|i| st.lever[i][r] * lin.terms.ring[i].d[c])
                        .sum();
                }
            }
        }
        for r in 0..5 {
            let row = 4 * balls + r;
            b[row] = ring[r];
            if !free[r] {
                a[row * n..(row + 1) * n].fill(0.0);
                a[row * n + row] = 1.0;
                b[row] = 0.0;
            }
        }
        dense_solve(&mut a, &mut b, 1)?;
        Some(Direction {
            du: from_fn(|k| b[4 * balls + k]),
            dw: (0..balls).map(|j| from_fn(|i| b[4 * j + i])).collect(),
        })
    }

    /// `K = -F_w R_w^-1 R_u`: eliminated ball by ball or, if `dense`, from all `4 N` equations at once.
    fn stiffness(&self, lin: &[Linear], dense: bool) -> Option<[[f64; 5]; 5]> {
        let mut k = [[0.0; 5]; 5];
        if !dense {
            for (lin, st) in lin.iter().zip(&self.stations) {
                let (_, g) = lin.solve([0.0; 4])?;
                lin.add_stiffness(&mut k, &g, st);
            }
            return Some(k);
        }
        let n = 4 * lin.len();
        let mut a = vec![0.0; n * n];
        let mut b = vec![0.0; n * 5];
        for (j, (lin, st)) in lin.iter().zip(&self.stations).enumerate() {
            for i in 0..4 {
                for c in 0..4 {
                    a[(4 * j + i) * n + 4 * j + c] = lin.jacobian[i][c];
                }
            }
            for i in 0..2 {
                for c in 0..5 {
                    b[(4 * j + i) * 5 + c] = st.lever[i][c];
                }
            }
        }
        dense_solve(&mut a, &mut b, 5)?;
        for (j, (lin, st)) in lin.iter().zip(&self.stations).enumerate() {
            for c in 0..5 {
                let dw = from_fn(|i| b[(4 * j + i) * 5 + c]);
                let mut column = [0.0; 5];
                st.collect(&lin.ring_change(&dw), &mut column);
                for r in 0..5 {
                    k[r][c] += column[r];
                }
            }
        }
        Some(k)
    }

    /// Linearises all balls at a stage; also the ring force and the largest force about.
    fn survey(&self, s: &Stage, task: &Task) -> (Vec<Linear>, Vec<Unknowns<f64>>, [f64; 5], f64) {
        let mut force = [0.0; 5];
        let mut big = 0.0_f64;
        let mut lin = Vec::with_capacity(s.x.len());
        let mut ws = Vec::with_capacity(s.x.len());
        for (j, x) in s.x.iter().enumerate() {
            let centre = self.inner_centre(j, &s.u);
            let w = self.unknowns(x, &centre);
            let l = self.linearise(&w, &centre, task.omega, task.attitude);
            self.stations[j].collect(&l.terms.ring.map(|t| t.v), &mut force);
            big = big.max(l.terms.q[0].v).max(l.terms.q[1].v);
            lin.push(l);
            ws.push(w);
        }
        (lin, ws, force, big)
    }

    /// Norm of all imbalances in units of `scale`; infinite where a turning ball is off the outer race.
    fn imbalance(&self, s: &Stage, task: &Task, scale: f64) -> f64 {
        let mut force = [0.0; 5];
        let mut sum = 0.0;
        for (j, x) in s.x.iter().enumerate() {
            let centre = self.inner_centre(j, &s.u);
            let w = self.unknowns(x, &centre);
            if task.omega != 0.0 && w[3] <= 0.0 {
                return f64::INFINITY;
            }
            let t = self.evaluate(&w, &centre, task.omega, task.attitude);
            self.stations[j].collect(&t.ring, &mut force);
            sum += t.balance.iter().map(|b| (b / scale).powi(2)).sum::<f64>();
        }
        (sum + self.ring_size(&force, task, scale).powi(2)).sqrt()
    }

    /// Norm of the ring's imbalance in units of `scale`, moments over the pitch radius.
    fn ring_size(&self, force: &[f64; 5], task: &Task, scale: f64) -> f64 {
        let lever = 0.5 * self.pitch.hi;
        let mut sum = 0.0;
        for (k, (f, load)) in force.iter().zip(&task.load).enumerate() {
            if task.free[k] {
                let unit = if k < 3 { 1.0 } else { lever };
                sum += ((f - load) / unit / scale).powi(2);
            }
        }
        sum.sqrt()
    }

    /// Magnitude of the load as a force.
    fn load_size(&self, task: &Task) -> f64 {
        let lever = 0.5 * self.pitch.hi;
        (0..5).fold(0.0_f64, |s, k| {
            let unit = if k < 3 { 1.0 } else { lever };
            s.max((task.load[k] / unit).abs())
        })
    }

    /// Damped Newton on all balls and the ring together; leaves `s` near enough for [`Self::refine`].
    fn newton(
        &self,
        s: &mut Stage,
        task: &Task,
        limit: usize,
        steps: &mut usize,
    ) -> Result<(), Failure> {
        let length = self.lo.hi + self.li.hi;
        let mut residual = f64::INFINITY;
        for _ in 0..limit {
            if task.omega == 0.0 {
                // At rest the ball has a closed form.
                for (j, x) in s.x.iter_mut().enumerate() {
                    *x = self.resting(&self.inner_centre(j, &s.u));
                }
            }
            let (lin, ws, force, big) = self.survey(s, task);
            let scale = big.max(self.load_size(task));
            let size = self.imbalance(s, task, scale);
            let thin = (scale / self.inner.k.hi.max(self.outer.k.hi)).powf(2.0 / 3.0);
            let noise = 1e-15 * (1.0 + length / thin) * (s.x.len() as f64);
            if size <= noise || size < 1e-7 && size > 0.1 * residual {
                return Ok(());
            }
            residual = size;
            let ball: Vec<[f64; 4]> = lin
                .iter()
                .map(|l| [0.0, 0.0, l.terms.balance[0].v, l.terms.balance[1].v])
                .collect();
            let ring = from_fn(|k| task.load[k] - force[k]);
            let dir = self
                .direction(&lin, &ball, &ring, task, 0.0)
                .ok_or(Failure::Singular)?;
            let dx: Vec<[f64; 2]> = ws
                .iter()
                .zip(&dir.dw)
                .map(|(w, dw)| self.centre_change(w, dw))
                .collect();
            *steps += 1;
            let mut step = 1.0_f64;
            loop {
                let mut trial = Stage {
                    u: from_fn(|k| s.u[k] + step * dir.du[k]),
                    x: s.x
                        .iter()
                        .zip(&dx)
                        .map(|(x, d)| [x[0] + step * d[0], x[1] + step * d[1]])
                        .collect(),
                };
                if task.omega == 0.0 {
                    for (j, x) in trial.x.iter_mut().enumerate() {
                        *x = self.resting(&self.inner_centre(j, &trial.u));
                    }
                }
                if self.imbalance(&trial, task, scale) <= (1.0 - 1e-4 * step) * size {
                    *s = trial;
                    break;
                }
                step *= 0.5;
                if step < 1e-6 {
                    if size < 1e-7 {
                        return Ok(());
                    }
                    return Err(Failure::Stalled {
                        residual: size,
                        iterations: *steps,
                    });
                }
            }
        }
        Err(Failure::Stalled {
            residual,
            iterations: *steps,
        })
    }

    /// Newton on the ring with every ball in equilibrium throughout, damped like Levenberg's method:
    /// slower than [`Self::newton`], much harder to lose.
    fn nested(&self, s: &mut Stage, task: &Task, limit: usize) -> Result<(), Failure> {
        self.place(&s.u, task, &mut s.x, true)
            .or_else(|_| self.place(&s.u, task, &mut s.x, false))?;
        let mut damping = 0.0_f64;
        let mut last = f64::INFINITY;
        for _ in 0..limit {
            let (lin, _, force, big) = self.survey(s, task);
            let scale = self.load_size(task).max(1e-3 * big);
            let size = self.ring_size(&force, task, scale);
            last = size;
            if size < 1e-5 {
                return Ok(());
            }
            let ball = vec![[0.0; 4]; lin.len()];
            let ring = from_fn(|k| task.load[k] - force[k]);
            loop {
                let soft = Task {
                    dense: false,
                    ..*task
                };
                let better = self
                    .direction(&lin, &ball, &ring, &soft, damping)
                    .and_then(|dir| {
                        let mut trial = s.clone();
                        for k in 0..5 {
                            trial.u[k] += dir.du[k];
                        }
                        self.place(&trial.u, task, &mut trial.x, true).ok()?;
                        let (_, _, force, _) = self.survey(&trial, task);
                        (self.ring_size(&force, task, scale) < (1.0 - 1e-4) * size).then_some(trial)
                    });
                if let Some(trial) = better {
                    *s = trial;
                    damping = if damping < 1e-9 { 0.0 } else { damping * 0.1 };
                    break;
                }
                damping = (damping * 8.0).max(1e-7);
                if damping > 1e4 {
                    return Err(Failure::Stalled {
                        residual: size,
                        iterations: limit,
                    });
                }
            }
        }
        Err(Failure::Stalled {
            residual: last,
            iterations: limit,
        })
    }

    /// Follows the solution from `from` to `to` in growing and shrinking steps.
    fn follow(&self, s: &mut Stage, from: &Task, to: &Task) -> Result<(), Failure> {
        let mut done = 0.0_f64;
        let mut stride = 1.0_f64;
        let (least, most, limit) = if to.thorough {
            (1e-4, usize::MAX, 40)
        } else {
            (0.01, 16, 25)
        };
        let mut steps = 0;
        while done < 1.0 {
            steps += 1;
            let goal = (done + stride).min(1.0);
            let blend = |a: f64, b: f64| if goal < 1.0 { a + goal * (b - a) } else { b };
            let task = Task {
                load: from_fn(|k| blend(from.load[k], to.load[k])),
                // The inertia loads go with the square of the speed.
                omega: blend(from.omega.powi(2), to.omega.powi(2))
                    .sqrt()
                    .copysign(to.omega),
                ..*to
            };
            let mut trial = s.clone();
            match self.nested(&mut trial, &task, limit) {
                Ok(()) => {
                    *s = trial;
                    done = goal;
                    stride *= 2.0;
                }
                Err(e) => {
                    stride *= 0.25;
                    if stride < least || steps > most {
                        return Err(e);
                    }
                }
            }
        }
        Ok(())
    }

    /// Axial force at a purely axial displacement.
    fn axial_force(&self, dx: f64, task: &Task) -> Option<f64> {
        let u = [dx, 0.0, 0.0, 0.0, 0.0];
        let centre = self.inner_centre(0, &u);
        let x = self.ball_at(&centre, task.omega, task.attitude, None)?;
        let w = self.unknowns(&x, &centre);
        let t = self.evaluate(&w, &centre, task.omega, task.attitude);
        Some(self.stations.len() as f64 * t.ring[0])
    }

    /// A start with all balls loaded alike by the axial force `fx`.
    fn preloaded(&self, fx: f64, task: &Task) -> Result<Stage, Failure> {
        let length = (self.li + self.lo).hi;
        let (mut low, mut high) = (-self.a0[0].hi - 0.5 * length, length - self.a0[0].hi);
        for _ in 0..50 {
            let mid = 0.5 * (low + high);
            // A ball that finds no equilibrium is squeezed too hard.
            if self.axial_force(mid, task).is_none_or(|f| f > fx) {
                high = mid;
            } else {
                low = mid;
            }
        }
        let u = [0.5 * (low + high), 0.0, 0.0, 0.0, 0.0];
        let mut x = vec![[0.0, 0.0]; self.stations.len()];
        self.place(&u, task, &mut x, false)?;
        Ok(Stage { u, x })
    }

    /// Second stage: Newton on all `4 N + 5` unknowns with residual and unknowns in double-double.
    fn refine(&self, s: &Stage, task: &Task, steps: &mut usize) -> Result<Solution, Failure> {
        let n = self.stations.len();
        let lever = 0.5 * self.pitch.hi;
        let mut u = s.u.map(Dd::of);
        let mut ws: Vec<Unknowns<Dd>> = (0..n)
            .map(|j| {
                let centre = self.inner_centre(j, &s.u);
                self.unknowns(&s.x[j], &centre).map(Dd::of)
            })
            .collect();
        let mut best = f64::INFINITY;
        for round in 0..12 {
            let mut force = [Dd::ZERO; 5];
            let mut ball = Vec::with_capacity(n);
            let mut terms = Vec::with_capacity(n);
            let mut big = self.load_size(task);
            for (j, w) in ws.iter().enumerate() {
                let centre = self.inner_centre(j, &u);
                let t = self.evaluate(w, &centre, task.omega, task.attitude);
                self.stations[j].collect(&t.ring, &mut force);
                big = big.max(t.q[0].hi).max(t.q[1].hi);
                let [c0, c1] = t.closure;
                let [b0, b1] = t.balance;
                ball.push([c0, c1, b0, b1].map(Dd::value));
                terms.push(t);
            }
            let mut ring = [0.0; 5];
            let mut size = 0.0_f64;
            for k in 0..5 {
                if task.free[k] {
                    ring[k] = (Dd::of(task.load[k]) - force[k]).value();
                    let unit = if k < 3 { 1.0 } else { lever };
                    size = size.max((ring[k] / unit / big).abs());
                }
            }
            let thin = (big / self.outer.k.hi).powf(2.0 / 3.0);
            for r in &ball {
                size = size.max((r[0] / thin).abs()).max((r[1] / thin).abs());
                size = size.max((r[2] / big).abs()).max((r[3] / big).abs());
            }
            if !size.is_finite() {
                break;
            }
            let lin: Vec<Linear> = ws
                .iter()
                .map(|w| self.linearise(&w.map(Dd::value), &[0.0; 2], task.omega, task.attitude))
                .collect();
            let stuck = size >= 0.1 * best;
            if size <= 1e-20 || stuck && size <= 1e-15 {
                let k = self.stiffness(&lin, task.dense).ok_or(Failure::Singular)?;
                return Ok(Solution {
                    u: u.map(Dd::value),
                    k,
                    balls: self.report(&ws, &terms),
                    residual: size,
                    iterations: *steps,
                    ki: self.inner.k.value(),
                    ko: self.outer.k.value(),
                });
            }
            if stuck && round > 3 {
                break;
            }
            best = best.min(size);
            let dir = self
                .direction(&lin, &ball, &ring, task, 0.0)
                .ok_or(Failure::Singular)?;
            *steps += 1;
            for (u, du) in u.iter_mut().zip(dir.du) {
                *u = *u + Dd::of(du);
            }
            for (w, dw) in ws.iter_mut().zip(&dir.dw) {
                for (w, dw) in w.iter_mut().zip(dw) {
                    *w = *w + Dd::of(*dw);
                }
            }
        }
        Err(Failure::Stalled {
            residual: best,
            iterations: *steps,
        })
    }

    /// Half the pitch diameter in m, the length that makes tilts comparable.
    pub(crate) fn pitch_radius(&self) -> f64 {
        0.5 * self.pitch.hi
    }

    /// Displacements at rest under an axial force that keeps every ball loaded.
    pub(crate) fn static_guess(&self, load: [f64; 5]) -> Result<[f64; 5], Failure> {
        check(&load, 0.0, &[0.0; 5])?;
        let task = Task {
            load,
            omega: 0.0,
            attitude: Attitude::Outer,
            free: [true; 5],
            dense: false,
            thorough: true,
        };
        Ok(self.preloaded(self.preload(&load, 1.0), &task)?.u)
    }

    /// An axial force at least `factor` times the radial load and tilting moments.
    fn preload(&self, load: &[f64; 5], factor: f64) -> f64 {
        let [fx, fy, fz, my, mz] = *load;
        let least = 1e-9 * self.inner.k.hi * self.li.hi.powf(1.5);
        let other = fy.hypot(fz) + my.hypot(mz) / self.pitch_radius();
        fx.max(factor * other).max(least)
    }

    /// A first guess of one ball's unknowns: as at rest, or on the outer race if that is out of touch.
    pub(crate) fn start_of_ball(
        &self,
        centre: &[f64; 2],
        omega: f64,
        attitude: Attitude,
    ) -> Unknowns<f64> {
        let w = self.unknowns(&self.resting(centre), centre);
        if omega == 0.0 || w[3] > 0.0 {
            return w;
        }
        self.unknowns(&self.flung(centre, omega, attitude), centre)
    }

    /// Largest of a ball's corrections as a length in m.
    pub(crate) fn arc(&self, dw: &[f64; 4]) -> f64 {
        let arcs = [dw[0] * self.li.hi, dw[1] * self.lo.hi, dw[2], dw[3]];
        arcs.iter().fold(0.0, |s, x| {
            if x.is_finite() {
                s.max(x.abs())
            } else {
                f64::INFINITY
            }
        })
    }

    /// States of balls whose unknowns are known to f64 only.
    pub(crate) fn report_plain(
        &self,
        ws: &[Unknowns<f64>],
        omega: f64,
        attitude: Attitude,
    ) -> Vec<BallState> {
        let wide: Vec<_> = ws.iter().map(|w| w.map(Dd::of)).collect();
        let terms: Vec<_> = wide
            .iter()
            .map(|w| self.evaluate(w, &[Dd::ZERO; 2], omega, attitude))
            .collect();
        self.report(&wide, &terms)
    }

    fn report(&self, ws: &[Unknowns<Dd>], terms: &[Terms<Dd>]) -> Vec<BallState> {
        let row = |((w, t), st): ((&Unknowns<Dd>, &Terms<Dd>), &Station)| BallState {
            azimuth: st.azimuth,
            alpha_i: w[0].value(),
            alpha_o: w[1].value(),
            q_i: t.q[0].value(),
            q_o: t.q[1].value(),
            delta_i: w[2].value(),
            delta_o: w[3].value(),
            fc: t.fc.value(),
            mg: t.mg.value(),
        };
        ws.iter().zip(terms).zip(&self.stations).map(row).collect()
    }

    /// Equilibrium under `load` at `omega` rad/s from a cold start, with the full matrix.
    ///
    /// # Errors
    /// See [`Failure`].
    pub fn solve(
        &self,
        load: [f64; 5],
        omega: f64,
        attitude: Attitude,
    ) -> Result<Solution, Failure> {
        self.solve_with(load, omega, attitude, [true; 5], [0.0; 5])
    }

    /// Like [`Self::solve`]; a freedom that is not `free` keeps the displacement `held` (m, rad) and its
    /// load is ignored. The stiffness is still that of all five.
    ///
    /// # Errors
    /// See [`Failure`].
    pub fn solve_with(
        &self,
        load: [f64; 5],
        omega: f64,
        attitude: Attitude,
        free: [bool; 5],
        held: [f64; 5],
    ) -> Result<Solution, Failure> {
        self.solve_held(load, omega, attitude, free, held, true)
    }

    /// Like [`Self::solve`], but sooner done with a load that has no equilibrium, or one that is hard
    /// to find.
    ///
    /// # Errors
    /// See [`Failure`].
    pub fn search(
        &self,
        load: [f64; 5],
        omega: f64,
        attitude: Attitude,
    ) -> Result<Solution, Failure> {
        self.search_with(load, omega, attitude, [true; 5], [0.0; 5])
    }

    /// Like [`Self::search`], with freedoms held as by [`Self::solve_with`].
    ///
    /// # Errors
    /// See [`Failure`].
    pub fn search_with(
        &self,
        load: [f64; 5],
        omega: f64,
        attitude: Attitude,
        free: [bool; 5],
        held: [f64; 5],
    ) -> Result<Solution, Failure> {
        self.solve_held(load, omega, attitude, free, held, false)
    }

    /// A cold start under what is given, from the full matrix and with all patience or without either.
    fn solve_held(
        &self,
        load: [f64; 5],
        omega: f64,
        attitude: Attitude,
        free: [bool; 5],
        held: [f64; 5],
        thorough: bool,
    ) -> Result<Solution, Failure> {
        check(&load, omega, &held)?;
        let task = Task {
            load: from_fn(|k| if free[k] { load[k] } else { 0.0 }),
            omega,
            attitude,
            free,
            dense: thorough,
            thorough,
        };
        self.cold(&task, &held)
    }

    /// A cold start, by one method after another.
    fn cold(&self, task: &Task, held: &[f64; 5]) -> Result<Solution, Failure> {
        let hold = |s: &mut Stage| {
            for (u, (free, held)) in s.u.iter_mut().zip(task.free.iter().zip(held)) {
                if !free {
                    *u = *held;
                }
            }
        };
        let mut steps = 0;
        let finish = |mut s: Stage, steps: &mut usize| {
            self.newton(&mut s, task, 60, steps)?;
            self.refine(&s, task, steps)
        };
        let mut outcome = Err(Failure::Singular);
        // Plain Newton from a preload that keeps every ball loaded, then with balls in equilibrium
        // throughout, then along the load, then along the speed; each from milder to heavier preload.
        for method in 0..4 {
            for factor in [1.0, 4.0] {
                let preload = self.preload(&task.load, factor);
                let start = Task {
                    load: [preload, 0.0, 0.0, 0.0, 0.0],
                    omega: if method == 3 { 0.0 } else { task.omega },
                    ..*task
                };
                let Ok(mut s) = self.preloaded(preload, &start) else {
                    continue;
                };
                hold(&mut s);
                outcome = match method {
                    0 => Ok(()),
                    1 => self.nested(&mut s, task, 60),
                    2 => self.follow(&mut s, &start, task),
                    _ => {
                        let rest = Task {
                            omega: 0.0,
                            ..*task
                        };
                        self.follow(&mut s, &start, &rest)
                            .and_then(|()| self.follow(&mut s, &rest, task))
                    }
                }
                .and_then(|()| finish(s, &mut steps));
                if outcome.is_ok() {
                    return outcome;
                }
            }
        }
        outcome
    }

    /// Newton from a given start, without continuation, eliminating the balls one by one: the fast
    /// way to judge a solution of another program. `centres` holds each ball's centre
    /// `(X1, X2)` in m, axial and radial from the outer groove's curvature centre.
    ///
    /// # Errors
    /// See [`Failure`].
    pub fn polish(
        &self,
        load: [f64; 5],
        omega: f64,
        attitude: Attitude,
        u0: [f64; 5],
        centres: &[(f64, f64)],
    ) -> Result<Solution, Failure> {
        self.polish_with(load, omega, attitude, u0, centres, [true; 5])
    }

    /// Like [`Self::polish`], but gives up unless the start is near an equilibrium.
    ///
    /// # Errors
    /// See [`Failure`].
    pub fn polish_near(
        &self,
        load: [f64; 5],
        omega: f64,
        attitude: Attitude,
        u0: [f64; 5],
        centres: &[(f64, f64)],
    ) -> Result<Solution, Failure> {
        check(&load, omega, &u0)?;
        if centres.len() != self.stations.len() {
            return Err(Failure::Input("number of ball centres"));
        }
        let task = Task {
            load,
            omega,
            attitude,
            free: [true; 5],
            dense: false,
            thorough: false,
        };
        let mut s = Stage {
            u: u0,
            x: centres.iter().map(|&(a, r)| [a, r]).collect(),
        };
        let mut steps = 0;
        self.newton(&mut s, &task, 12, &mut steps)?;
        self.refine(&s, &task, &mut steps)
    }

    /// Like [`Self::polish`]; a freedom that is not `free` keeps its displacement of `u0`.
    ///
    /// # Errors
    /// See [`Failure`].
    pub fn polish_with(
        &self,
        load: [f64; 5],
        omega: f64,
        attitude: Attitude,
        u0: [f64; 5],
        centres: &[(f64, f64)],
        free: [bool; 5],
    ) -> Result<Solution, Failure> {
        check(&load, omega, &u0)?;
        if centres.len() != self.stations.len() {
            return Err(Failure::Input("number of ball centres"));
        }
        let task = Task {
            load: from_fn(|k| if free[k] { load[k] } else { 0.0 }),
            omega,
            attitude,
            free,
            dense: false,
            thorough: true,
        };
        let mut s = Stage {
            u: u0,
            x: centres.iter().map(|&(a, r)| [a, r]).collect(),
        };
        let mut steps = 0;
        let start = s.clone();
        self.newton(&mut s, &task, 40, &mut steps)
            .and_then(|()| self.refine(&s, &task, &mut steps))
            .or_else(|_| {
                // The centres did not belong to the displacements; give every ball its place first.
                let mut s = start;
                self.nested(&mut s, &task, 40)?;
                self.newton(&mut s, &task, 40, &mut steps)?;
                self.refine(&s, &task, &mut steps)
            })
    }

    /// Like [`Self::law`], in f64 throughout and without the stiffness: the force on the ring and the
    /// inner deformation of every ball, good for constructing cases. `centres` of balls, if there are
    /// as many as balls, are where it starts, and become those it finds.
    ///
    /// # Errors
    /// [`Failure::Ball`] if a ball finds no equilibrium.
    pub fn rough_law(
        &self,
        u: [f64; 5],
        omega: f64,
        attitude: Attitude,
        centres: &mut Vec<[f64; 2]>,
    ) -> Result<([f64; 5], Vec<f64>), Failure> {
        check(&[0.0; 5], omega, &u)?;
        let known = centres.len() == self.stations.len();
        let mut found = Vec::with_capacity(self.stations.len());
        let mut depths = Vec::with_capacity(self.stations.len());
        let mut force = [0.0; 5];
        for (index, station) in self.stations.iter().enumerate() {
            let centre = self.inner_centre(index, &u);
            let guess = known.then(|| centres[index]);
            let x = self
                .ball_at(&centre, omega, attitude, guess)
                .ok_or(Failure::Ball { index })?;
            let w = self.unknowns(&x, &centre);
            let terms = self.evaluate(&w, &centre, omega, attitude);
            station.collect(&terms.ring, &mut force);
            found.push(x);
            depths.push(w[2]);
        }
        *centres = found;
        Ok((force, depths))
    }

    /// Inner deformation of ball `index` alone at the displacements `u`, in f64.
    ///
    /// # Errors
    /// [`Failure::Ball`] if it finds no equilibrium.
    pub fn depth(
        &self,
        index: usize,
        u: [f64; 5],
        omega: f64,
        attitude: Attitude,
    ) -> Result<f64, Failure> {
        check(&[0.0; 5], omega, &u)?;
        let centre = self.inner_centre(index, &u);
        let x = self
            .ball_at(&centre, omega, attitude, None)
            .ok_or(Failure::Ball { index })?;
        Ok(self.unknowns(&x, &centre)[2])
    }

    /// Forces and stiffness at the displacements `u`.
    ///
    /// # Errors
    /// [`Failure::Ball`] if a ball finds no equilibrium.
    pub fn law(&self, u: [f64; 5], omega: f64, attitude: Attitude) -> Result<Law, Failure> {
        check(&[0.0; 5], omega, &u)?;
        let task = Task {
            load: [0.0; 5],
            omega,
            attitude,
            free: [false; 5],
            dense: false,
            thorough: true,
        };
        let mut s = Stage {
            u,
            x: vec![[0.0, 0.0]; self.stations.len()],
        };
        self.place(&u, &task, &mut s.x, false)?;
        let sol = self.refine(&s, &task, &mut 0)?;
        let mut force = [0.0; 5];
        for (b, st) in sol.balls.iter().zip(&self.stations) {
            let w = [b.alpha_i, b.alpha_o, b.delta_i, b.delta_o];
            let t = self.evaluate(&w, &[0.0; 2], omega, attitude);
            st.collect(&t.ring, &mut force);
        }
        Ok(Law {
            force,
            k: sol.k,
            balls: sol.balls,
        })
    }
}

/// Solves `k du = rhs` for the free freedoms, the others stay; tilts scaled to lengths.
pub(crate) fn masked_solve(
    k: &[[f64; 5]; 5],
    rhs: &[f64; 5],
    free: &[bool; 5],
    unit: &[f64; 5],
) -> Option<[f64; 5]> {
    let a: [[f64; 5]; 5] = from_fn(|r| {
        from_fn(|c| {
            if free[r] && free[c] {
                k[r][c] / (unit[r] * unit[c])
            } else {
                f64::from(r == c)
            }
        })
    });
    let b: [[f64; 1]; 5] = from_fn(|r| [if free[r] { rhs[r] / unit[r] } else { 0.0 }]);
    let x = small_solve(a, b)?;
    Some(from_fn(|r| x[r][0] / unit[r]))
}

fn check(load: &[f64; 5], omega: f64, u: &[f64; 5]) -> Result<(), Failure> {
    if !load.iter().all(|x| x.is_finite()) {
        return Err(Failure::Input("load"));
    }
    if !omega.is_finite() {
        return Err(Failure::Input("omega"));
    }
    if !u.iter().all(|x| x.is_finite()) {
        return Err(Failure::Input("displacement"));
    }
    Ok(())
}
