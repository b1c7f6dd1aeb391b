//! How a ball moves: cage speed, spin and attitude, and the inertia loads that follow.
//!
//! With `a = 1 + tau cos ao`, `c = 1 - tau cos ai`, `d = ai - ao` and the share
//! `eta = C / (C + 1)` of the inner contact (`C` as in the model: the contacts' `Q a E`), all three
//! attitude rules reduce to polynomials and one division:
//!
//! - cage speed `omega_m = mu omega`, `mu = M / (1 + cos d)`
//! - centrifugal force `Fc = m dm omega^2 mu^2 / 2`
//! - gyroscopic couple `2 Mg / D = 0.4 (m dm omega^2 / 2) mu nu`, `nu = P / (1 + cos d)`
//!
//! | rule | `M` | `P` |
//! | --- | --- | --- |
//! | outer race control | `c` | `c sin ao` |
//! | inner race control | `1 + cos d - a` | `a sin ai` |
//! | raceway-control-free | `(1-eta) c + eta/2 ((1+c) cos d + 1 - a)` | `(1-eta) c sin ao + eta/2 (a+c) sin ai` |
//!
//! Derivation: insert the rule's `tan b = p/q` into `omega_m` and `omega_R`. For the free rule
//! `q cos ao + p sin ao = a d'` and `q cos ai + p sin ai = c d''`, and `d' + d''` is
//! `2 (1 + cos d)(W + Z)` for `C = W/Z`, so that the sum `Nb` cancels.
//! Rule: Ding (2001); Wang, Hong, Zhang, Zhu, Mech. Mach. Theory 82 (2014).

use crate::constants::Constants;
use crate::contact::Contact;
use crate::float::Real;

pub(crate) mod sealed {
    pub trait Sealed {}
}

/// Rule for the attitude of the balls' spin axis and for how the two contacts share the friction
/// that carries the gyroscopic moment. A type, so that a firmware contains one rule only.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not an attitude rule",
    label = "not an attitude rule",
    note = "choose `RacewayControlFree`, `OuterRaceControl` or `InnerRaceControl`"
)]
pub trait Attitude: sealed::Sealed + Copy + 'static {
    /// Short name, as settings files and tables print it.
    const NAME: &'static str;
    /// The loads of the contacts enter the rule.
    #[doc(hidden)]
    const COUPLED: bool;
    /// Friction carries a gyroscopic moment.
    #[doc(hidden)]
    const FRICTION: bool = true;

    #[doc(hidden)]
    fn motion<T: Real>(c: &Constants<T>, inner: &Contact<T>, outer: &Contact<T>) -> BallMotion<T>;
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

/// A value with its slopes by the contact angles, the inner and the outer, and by `eta`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sloped<T> {
    pub value: T,
    pub by_inner_angle: T,
    pub by_outer_angle: T,
    pub by_eta: T,
}

/// Speeds of a ball and the split of the friction, relative to the shaft speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BallMotion<T> {
    pub mu: Sloped<T>,
    pub nu: Sloped<T>,
    /// Slopes of `eta` by the deformations, inner and outer.
    pub eta_by_inner: T,
    pub eta_by_outer: T,
    /// Share of the inner contact in the friction, with its slopes by the deformations.
    pub share: T,
    pub share_by_inner: T,
    pub share_by_outer: T,
    /// Sine and cosine of the angle between the contacts, `ai - ao`.
    pub sin_d: T,
    pub cos_d: T,
    /// One over the sum of both contact forces.
    pub per_forces: T,
}

/// Least `1 + cos d` that speeds are worked out for: where the contacts are opposite, the cage speed has a
/// pole. On the way to an equilibrium the bound keeps the numbers finite; what it changes is none.
pub const NEAREST_POLE: f64 = 0.01;

/// Angles between the contacts, common to all rules.
struct Angles<T> {
    a: T,
    c: T,
    cos_d: T,
    sin_d: T,
    /// `1 / (1 + cos d)`
    inverse: T,
    /// `1 / (Qi + Qo)`
    per_forces: T,
    tau: T,
}

impl<T: Real> Angles<T> {
    #[inline(always)]
    fn of(k: &Constants<T>, inner: &Contact<T>, outer: &Contact<T>) -> Self {
        let cos_d = inner.cos * outer.cos + inner.sin * outer.sin;
        let apart = (T::ONE + cos_d).at_least(T::of(NEAREST_POLE));
        let forces = (inner.q + outer.q).at_least(T::of(1e-30));
        // One division for both.
        let inverse = T::ONE / (apart * forces);
        Self {
            a: T::ONE + k.tau * outer.cos,
            c: T::ONE - k.tau * inner.cos,
            cos_d,
            sin_d: inner.sin * outer.cos - inner.cos * outer.sin,
            inverse: inverse * forces,
            per_forces: inverse * apart,
            tau: k.tau,
        }
    }

    /// A numerator over `1 + cos d`, with its slopes.
    #[inline(always)]
    fn ratio(&self, value: T, by_inner: T, by_outer: T, by_eta: T) -> Sloped<T> {
        let quotient = value * self.inverse;
        let turn = quotient * self.sin_d;
        Sloped {
            value: quotient,
            by_inner_angle: (by_inner + turn) * self.inverse,
            by_outer_angle: (by_outer - turn) * self.inverse,
            by_eta: by_eta * self.inverse,
        }
    }

    #[inline(always)]
    fn outer_control(&self, inner: &Contact<T>, outer: &Contact<T>) -> BallMotion<T> {
        let c_slope = self.tau * inner.sin;
        BallMotion {
            mu: self.ratio(self.c, c_slope, T::ZERO, T::ZERO),
            nu: self.ratio(
                self.c * outer.sin,
                c_slope * outer.sin,
                self.c * outer.cos,
                T::ZERO,
            ),
            eta_by_inner: T::ZERO,
            eta_by_outer: T::ZERO,
            share: T::ZERO,
            share_by_inner: T::ZERO,
            share_by_outer: T::ZERO,
            sin_d: self.sin_d,
            cos_d: self.cos_d,
            per_forces: self.per_forces,
        }
    }
}

impl sealed::Sealed for OuterRaceControl {}
impl Attitude for OuterRaceControl {
    const NAME: &'static str = "outer";
    const COUPLED: bool = false;

    #[inline(always)]
    fn motion<T: Real>(k: &Constants<T>, inner: &Contact<T>, outer: &Contact<T>) -> BallMotion<T> {
        Angles::of(k, inner, outer).outer_control(inner, outer)
    }
}

impl sealed::Sealed for InnerRaceControl {}
impl Attitude for InnerRaceControl {
    const NAME: &'static str = "inner";
    const COUPLED: bool = false;

    #[inline(always)]
    fn motion<T: Real>(k: &Constants<T>, inner: &Contact<T>, outer: &Contact<T>) -> BallMotion<T> {
        let g = Angles::of(k, inner, outer);
        if inner.q <= T::ZERO {
            return g.outer_control(inner, outer);
        }
        let a_slope = -(g.tau * outer.sin);
        BallMotion {
            mu: g.ratio(T::ONE + g.cos_d - g.a, -g.sin_d, g.sin_d - a_slope, T::ZERO),
            nu: g.ratio(
                g.a * inner.sin,
                g.a * inner.cos,
                a_slope * inner.sin,
                T::ZERO,
            ),
            eta_by_inner: T::ZERO,
            eta_by_outer: T::ZERO,
            share: T::of(0.5),
            share_by_inner: T::ZERO,
            share_by_outer: T::ZERO,
            sin_d: g.sin_d,
            cos_d: g.cos_d,
            per_forces: g.per_forces,
        }
    }
}

impl sealed::Sealed for RacewayControlFree {}
impl Attitude for RacewayControlFree {
    const NAME: &'static str = "raceless";
    const COUPLED: bool = true;

    #[inline(always)]
    fn motion<T: Real>(k: &Constants<T>, inner: &Contact<T>, outer: &Contact<T>) -> BallMotion<T> {
        let g = Angles::of(k, inner, outer);
        let half = T::of(0.5);

        // eta = W / (W + Z), W = C-ratio delta_i^2, Z = delta_o^2; 0 where the inner contact is open.
        let di = inner.delta.at_least(T::ZERO);
        let d_o = outer.delta.at_least(T::ZERO);
        let w = k.moment_ratio * di;
        let inverse = T::ONE / (w * di + d_o * d_o).at_least(T::TINY);
        let (w, z) = (w * inverse, d_o * inverse);
        let eta = w * di;
        let rest = z * d_o;
        let both = half * eta;

        let c_slope = g.tau * inner.sin;
        let a_slope = g.tau * outer.sin;
        let free_m = (T::ONE + g.c) * g.cos_d + T::ONE - g.a;
        let turn = (T::ONE + g.c) * g.sin_d;
        let mu = g.ratio(
            rest * g.c + both * free_m,
            rest * c_slope + both * (c_slope * g.cos_d - turn),
            both * (turn + a_slope),
            half * free_m - g.c,
        );
        let (c_sin, sum_sin) = (g.c * outer.sin, (g.a + g.c) * inner.sin);
        let nu = g.ratio(
            rest * c_sin + both * sum_sin,
            rest * (c_slope * outer.sin) + both * (c_slope * inner.sin + (g.a + g.c) * inner.cos),
            rest * (g.c * outer.cos) - both * (a_slope * inner.sin),
            half * sum_sin - c_sin,
        );

        let forces = g.per_forces;
        let share = inner.q * forces;
        let two = T::ONE + T::ONE;
        BallMotion {
            mu,
            nu,
            eta_by_inner: two * w * rest,
            eta_by_outer: -(two * z * eta),
            share,
            share_by_inner: inner.slope * forces * (T::ONE - share),
            share_by_outer: -(outer.slope * forces * share),
            sin_d: g.sin_d,
            cos_d: g.cos_d,
            per_forces: forces,
        }
    }
}
