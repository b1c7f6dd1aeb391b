//! How a ball moves: cage speed and attitude, and the inertia loads that follow.
//!
//! Let `A = 1 + tau cos ao`, `c = 1 - tau cos ai`, `d = ai - ao`, `q = 1 / (1 + cos d)`. With the share
//! `eta = C / (C + 1)` of the inner contact (`C` as in the model), all three attitude rules reduce to polynomials:
//!
//! - cage speed `omega_m = mu omega`, centrifugal force `Fc = s mu^2`, `s = m dm omega^2 / 2`
//! - gyroscopic couple `2 Mg / D = 0.4 s mu nu`
//!
//! | rule | `mu` | `nu` |
//! | --- | --- | --- |
//! | outer race control | `c q` | `mu sin ao` |
//! | inner race control | `1 - A q` | `A q sin ai` |
//! | raceway-control-free | `c q - L sin d q` | `mu sin ao + L cos ao` |
//!
//! with `L = eta/2 (tau sin ao + (1 + c + A) sin d q)`.
//! Rule: Ding (2001); Wang, Hong, Zhang, Zhu, Mech. Mach. Theory 82 (2014).

use crate::linalg::{Pair, scale};
use crate::real::Real;
use core::fmt;
use core::marker::PhantomData;

/// Directions of the contacts, and how they share.
#[derive(Debug, Clone, Copy)]
pub struct Contacts<T> {
    /// Sine and cosine of the contact angles, inner and outer.
    pub inner: Pair<T>,
    pub outer: Pair<T>,
    /// Sine of the angle between the contacts, `ai - ao`.
    pub sin_d: T,
    /// One over one plus its cosine.
    pub q: T,
    /// Share `eta` of the inner contact in the friction work, and the outer one's.
    pub eta: T,
    pub rest: T,
    /// `Qi / (Qi + Qo)`, and the outer one's.
    pub sigma: T,
    pub sigma_rest: T,
    /// The inner contact carries.
    pub closed: bool,
}

/// A value's slopes by the angles of the inner and the outer contact, and by `ln(delta_i / delta_o)`.
pub type Slopes<T> = [T; 3];

/// Speeds of a ball and the split of the friction, relative to the shaft speed.
#[derive(Debug, Clone, Copy)]
pub struct Speeds<T> {
    pub mu: T,
    pub mu_by: Slopes<T>,
    pub nu: T,
    /// Slopes of `nu - mu sin ao`, `sin ao` taken out as a factor.
    pub nu_by: Slopes<T>,
    /// Share of the inner contact in the friction, the outer one's, and the slope of the former by
    /// `ln(delta_i / delta_o)` over itself.
    pub share: T,
    pub share_rest: T,
    pub share_by: T,
}

/// Rule for the attitude of the balls' spin axis, as the ball pass needs it.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not an attitude rule",
    label = "not an attitude rule",
    note = "choose `RacewayControlFree`, `OuterRaceControl` or `InnerRaceControl`"
)]
pub trait Rule: Copy + Send + 'static {
    /// Balls have inertia.
    const INERTIA: bool = true;
    /// Friction carries a gyroscopic moment.
    const FRICTION: bool = true;
    /// The attitude depends on the contact forces.
    const COUPLED: bool = false;
    fn speeds<T: Real>(tau: T, g: &Contacts<T>) -> Speeds<T>;
}

/// Raceway-control-free (d'Alembert): the attitude follows from both contacts' share in the
/// friction work. The default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RacewayControlFree;

/// Outer race control: no spin on the outer race, which carries the whole gyroscopic moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OuterRaceControl;

/// Inner race control: no spin on the inner race; both races share the gyroscopic moment evenly.
///
/// A ball without inner contact takes outer control's rule. That is a jump, so this rule is not for
/// scenes that unload balls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InnerRaceControl;

impl Rule for OuterRaceControl {
    #[inline(always)]
    fn speeds<T: Real>(tau: T, g: &Contacts<T>) -> Speeds<T> {
        let [si, ci] = g.inner;
        let [so, co] = g.outer;
        let c = T::ONE - tau * ci;
        let mu = c * g.q;
        let w = mu * g.sin_d * g.q;
        Speeds {
            mu,
            mu_by: [w + tau * si * g.q, -w, T::ZERO],
            nu: mu * so,
            nu_by: [T::ZERO, mu * co, T::ZERO],
            share: T::ZERO,
            share_rest: T::ONE,
            share_by: T::ZERO,
        }
    }
}

impl Rule for InnerRaceControl {
    #[inline(always)]
    fn speeds<T: Real>(tau: T, g: &Contacts<T>) -> Speeds<T> {
        if !g.closed {
            return OuterRaceControl::speeds(tau, g);
        }
        let [si, ci] = g.inner;
        let [so, co] = g.outer;
        let t = g.sin_d * g.q;
        let aq = (T::ONE + tau * co) * g.q;
        let mu = T::ONE - aq;
        let mu_i = -(aq * t);
        let mu_o = tau * so * g.q - mu_i;
        let half = T::of(0.5);
        Speeds {
            mu,
            mu_by: [mu_i, mu_o, T::ZERO],
            nu: aq * si,
            nu_by: [aq * (ci + si * t) - so * mu_i, -(si + so) * mu_o, T::ZERO],
            share: half,
            share_rest: half,
            share_by: T::ZERO,
        }
    }
}

impl Rule for RacewayControlFree {
    const COUPLED: bool = true;

    #[inline(always)]
    fn speeds<T: Real>(tau: T, g: &Contacts<T>) -> Speeds<T> {
        let [so, co] = g.outer;
        let q = g.q;
        // In the order of the fewest waits for a result.
        let [tsi, tci] = scale(tau, g.inner);
        let [tso, tco] = scale(tau, g.outer);
        let t = g.sin_d * q;
        let (c, beyond) = (T::ONE - tci, T::ONE + tco);
        let h = T::of(0.5) * g.eta;
        let a = c + beyond;
        let (cq, si_q) = (c * q, tsi * q);
        let (aq, at) = (a * q, a * t);
        let (si_t, so_t, cqt) = (tsi * t, tso * t, cq * t);
        let la = tso + at;
        let la_i = aq + si_t;
        let la_o = tco - aq - so_t;
        let l = h * la;
        let (hi, ho) = (h * la_i, h * la_o);
        let (lt, lq, lp) = (l * t, l * q, l * g.rest);
        let (mu, w, le) = (cq - lt, cqt - lq, lp + lp);
        let (ti, to) = (t * hi, t * ho);
        let (mu_so, l_co, l_so) = (mu * so, co * l, so * l);
        let mu_ho = mu + ho;
        Speeds {
            mu,
            mu_by: [w + si_q - ti, -(w + to), -(t * le)],
            nu: mu_so + l_co,
            nu_by: [co * hi, co * mu_ho - l_so, co * le],
            share: g.sigma,
            share_rest: g.sigma_rest,
            share_by: T::of(1.5) * g.sigma_rest,
        }
    }
}

/// No attitude: the balls are at rest.
#[derive(Debug, Clone, Copy)]
pub struct AtRest;

impl Rule for AtRest {
    const INERTIA: bool = false;

    fn speeds<T: Real>(tau: T, g: &Contacts<T>) -> Speeds<T> {
        OuterRaceControl::speeds(tau, g)
    }
}

/// The cage speed of a rule, without its gyroscopic moment.
#[derive(Debug, Clone, Copy)]
pub struct Frictionless<R>(PhantomData<R>);

impl<R: Rule> Rule for Frictionless<R> {
    const FRICTION: bool = false;
    const COUPLED: bool = R::COUPLED;

    #[inline(always)]
    fn speeds<T: Real>(tau: T, g: &Contacts<T>) -> Speeds<T> {
        R::speeds(tau, g)
    }
}

/// How the balls move: [`Static`], [`Centrifugal`], or with all inertia loads and an attitude rule, [`RacewayControlFree`],
/// [`OuterRaceControl`] or [`InnerRaceControl`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a motion of the balls",
    label = "not a motion",
    note = "a motion is `Static`, `Centrifugal<A>`, or an attitude rule `A` alone"
)]
pub trait Motion: Copy + Send + 'static {
    /// The rule of their attitude.
    type Rule: Rule;
    /// The shaft turns.
    const AT_SPEED: bool = <Self::Rule as Rule>::INERTIA;
}

/// The bearing at rest: its solvers refuse any speed but [`Speed::REST`](crate::Speed::REST).
///
/// See [`AxialSolver`](crate::AxialSolver) for an example.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Static;

/// The bearing at speed under centrifugal force alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Centrifugal<A = RacewayControlFree>(PhantomData<A>);

impl Motion for Static {
    type Rule = AtRest;
}

impl<A: Rule> Motion for Centrifugal<A> {
    type Rule = Frictionless<A>;
}

impl Motion for RacewayControlFree {
    type Rule = Self;
}

impl Motion for OuterRaceControl {
    type Rule = Self;
}

impl Motion for InnerRaceControl {
    type Rule = Self;
}

/// Speed of the shaft.
///
/// ```
/// use spindle_bearing::Speed;
/// const SPEED: Speed<f64> = Speed::rpm(20_000.0);
/// assert!((SPEED.as_rad_per_s() - 2094.395).abs() < 1e-3);
/// ```
#[derive(Clone, Copy)]
pub struct Speed<T> {
    /// As it was given, and its unit in rad/s: a generic `const fn` cannot multiply.
    value: T,
    unit: T,
}

impl<T: Real> Speed<T> {
    /// At rest.
    pub const REST: Self = Self::rad_per_s(T::ZERO);

    /// Revolutions per minute.
    #[inline]
    pub const fn rpm(rpm: T) -> Self {
        Self {
            value: rpm,
            unit: T::RPM,
        }
    }

    /// Angular speed `omega`, rad/s.
    #[inline]
    pub const fn rad_per_s(omega: T) -> Self {
        Self {
            value: omega,
            unit: T::ONE,
        }
    }

    /// Angular speed `omega`, rad/s.
    #[inline]
    pub fn as_rad_per_s(self) -> T {
        self.value * self.unit
    }
}

impl<T: Real> PartialEq for Speed<T> {
    fn eq(&self, other: &Self) -> bool {
        self.as_rad_per_s() == other.as_rad_per_s()
    }
}

impl<T: Real> fmt::Debug for Speed<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} rad/s", self.as_rad_per_s())
    }
}

#[cfg(feature = "defmt")]
impl<T: Real> defmt::Format for Speed<T> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{} rad/s", self.as_rad_per_s());
    }
}

/// A number, rad/s.
#[cfg(feature = "serde")]
impl<T: Real + serde::Serialize> serde::Serialize for Speed<T> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.as_rad_per_s().serialize(serializer)
    }
}

/// A number, rad/s.
#[cfg(feature = "serde")]
impl<'de, T: Real + serde::Deserialize<'de>> serde::Deserialize<'de> for Speed<T> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::deserialize(deserializer).map(Self::rad_per_s)
    }
}
