//! A ball as the ring sees it between two linearisations: a nonlinear spring.
//!
//! Newton's method takes a ball's force for linear in the ring's displacement. What makes it fail, or
//! slow, is mostly one thing: along one direction the force is that of a Hertz contact, which grows
//! with `s^(3/2)` and ends where the contact opens. That law is known. So each sweep hands the ring,
//! beside the linear force `f + H d`, the law along the stiffest direction of `H`, matched to it in
//! value and slope, and the ring balances the load against the laws: an iteration over a few numbers
//! per ball, without a square of `N` or a single contact angle in it.
//!
//! Three parts make up the law, the elongation `s` as a function of the force `Q = R z^3`:
//!
//! - the two Hertz contacts in series, `s = S1 (z^2 - 1)`;
//! - the centrifugal force bends the line inner groove - ball - outer groove, and tension straightens
//!   it: a chain of two links `li`, `lo` under a tension `Q` and a force `Fc sin a` across is
//!   shorter than straight by `h (Fc sin a)^2 / (2 (Q + r)^2)` with `h = li lo / L0` and
//!   `r = Fc cos a li / L0`, hence `s = S2 (1 - ((1 + r) / (z^3 + r))^2)` with `r` over `R`. That is for a
//!   small bend. Of any other, geometry has what is left until both contacts are in line: that is `S2` then,
//!   and `r` what makes the slope the same, so that a ball that is far off the line gives way as linearly as it
//!   does while it climbs the outer race;
//! - a shift `t` across the direction elongates the spring by `t^2 / 2` over the radius of curvature,
//!   which is what `H` says across the direction.
//!
//! All three are convex potentials of `d`.
//!
//! A ball off the inner race gives way on the outer one, too, once it is touched: to push it by `s` along the
//! contact takes `k s`, `k = Fc / (lo sin^2 d)`, beside what the contact takes, in series (nearly:
//! `1 / Q = 1 / (K s^(3/2)) + 1 / (k s)`). And where the ring draws both contacts in line, the ball resists as at
//! rest, whatever it did before.

use crate::constants::Constants;
use crate::contact::{Contact, Pair, add, dot, length, scale, sub};
use crate::float::Real;

/// 2x2 matrix, by rows.
pub type Square<T> = [Pair<T>; 2];

/// The law of one ball.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spring<T> {
    /// Direction of the force.
    pub normal: Pair<T>,
    /// Direction of the shift that changes it: the same as `normal`, but for friction and inertia.
    sense: Pair<T>,
    /// Force `R` at `z = 1`; 0 of a ball without inner contact.
    reference: T,
    /// `S1`; of a ball without inner contact, the constant `K` of the law
    /// `Q = K s^(3/2) / (1 + s^(1/2) K / k)`.
    hertz: T,
    /// `S2`; of a ball without inner contact, `K / k`.
    bend: T,
    /// `1 / (1 + r / R)`
    per_sum: T,
    /// Elongation at `d = 0` beyond that of the reference.
    elongation: T,
    /// Half the curvature across the direction.
    half_curvature: T,
    /// The linear law along the direction: force at `d = 0` beyond `R`, and slope.
    extra: T,
    slope: T,
    /// What the ball's own step changes of the force, relative, where `R` is the force after it.
    settling: T,
    /// What the linear law changes of the contact's force at `d = 0`.
    change: Pair<T>,
    stiffness: Square<T>,
}

/// What a shift makes of a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reaction<T> {
    /// Force, and its slope along the direction.
    pub force: T,
    pub slope: T,
    /// Force beyond the reference.
    excess: T,
    /// Shift along and across.
    along: T,
    across: T,
}

/// `z - 1` for the elongation `s`, `S1 (z^2 - 1) + S2 (1 - ((1 + r) / (z^3 + r))^2) = s`, and the slope of
/// the left side there; -1 if that is larger even at `z = 0`. `per_sum` is `1 / (1 + r)`. Newton between
/// bounds, in differences from 1, so that small elongations keep their digits. Good to a part in some
/// hundreds: the law only leads the way.
#[inline(never)]
pub fn tension<T: Real>(s1: T, s2: T, per_sum: T, s: T) -> (T, T) {
    let one = T::ONE;
    let two = one + one;
    let at = |x: T| {
        let z = one + x;
        let g = x * (z * z + z + one) * per_sum;
        let inverse = one / (one + g).at_least(T::TINY);
        let bend = s2 * inverse * inverse;
        let growth = T::of(3.0) * z * z * per_sum;
        (
            s1 * x * (two + x) + bend * g * (two + g) - s,
            two * (s1 * z + bend * inverse * growth),
        )
    };
    // A thousandth of the cube root is a thousand-millionth of the force: open.
    let closed = T::of(-0.999);
    let (mut low, mut high) = (-one, T::of(1e4));
    // Newton's first step, from 0.
    let mut slope = two * s1 + T::of(6.0) * s2 * per_sum;
    let mut x = (s / slope.at_least(T::TINY)).at_least(T::of(-0.8));
    if x.abs() < T::of(1e-3) {
        return (x, slope);
    }
    for _ in 0..40 {
        let (value, rise) = at(x);
        slope = rise.at_least(T::TINY);
        if value > T::ZERO {
            high = x;
        } else {
            low = x;
        }
        let newton = x - value / slope;
        let done = (newton - x).abs() <= T::of(0.02) * newton.abs();
        x = if done || (newton > low && newton < high) {
            newton
        } else {
            T::of(0.5) * (low + high.at_most(T::of(4.0) * (low + one) + x))
        };
        if done || high < closed {
            break;
        }
    }
    if x < closed {
        x = -one;
    }
    (x, slope)
}

/// The last tension that was worked out of a law: an elongation, and what [`tension`] makes of it. Where the
/// ring has found its step, every ball follows by the law that was looked at last.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stretch<T> {
    elongation: T,
    result: (T, T),
}

impl<T: Real> Stretch<T> {
    /// Of a law that was not looked at yet: across an endless gap any contact is open.
    #[inline(always)]
    pub fn none() -> Self {
        Self {
            elongation: T::of(f64::NEG_INFINITY),
            result: (-T::ONE, T::ONE),
        }
    }
}

/// How far the inner groove's centre moves along `sense` until both contacts are in line.
#[inline(always)]
fn room<T: Real>(c: &Constants<T>, inner: &Contact<T>, outer: &Contact<T>, sense: Pair<T>) -> T {
    let (ni, no) = (inner.normal(), outer.normal());
    let along = c.inner * dot(ni, sense) + c.outer * dot(no, sense);
    // The square of the length in line, 1, less that of the distance of the centres.
    let apart = sub(ni, no);
    let less = c.inner * c.outer * dot(apart, apart);
    let root = (along * along + less).sqrt();
    if along > T::ZERO {
        less / (along + root)
    } else {
        root - along
    }
}

impl<T: Real> Spring<T> {
    /// A contact of the constant `k` across a gap, which is `-elongation`; `gives` is what the ball gives way
    /// behind it, `K / k`.
    #[inline(always)]
    pub fn open(normal: Pair<T>, k: T, gives: T, elongation: T, half_curvature: T) -> Self {
        Self {
            normal,
            sense: normal,
            hertz: k,
            bend: gives,
            elongation,
            half_curvature,
            ..Self::default()
        }
    }

    /// A ball at speed whose contacts are `inner` and `outer`. `carried` is the force it hands to the
    /// ring as it is, `force` and `stiffness` the linear law; `fling` is `Fc`.
    #[inline(always)]
    pub fn of(
        c: &Constants<T>,
        inner: &Contact<T>,
        outer: &Contact<T>,
        carried: Pair<T>,
        force: Pair<T>,
        stiffness: &Square<T>,
        fling: T,
    ) -> Self {
        let half = T::of(0.5);
        let [[h00, h01], [h10, h11]] = *stiffness;
        // Singular vectors of the larger singular value.
        let p = half * (h00 * h00 + h10 * h10 - h01 * h01 - h11 * h11);
        let q = h00 * h01 + h10 * h11;
        let root = (p * p + q * q).sqrt();
        let sense = if p > T::ZERO {
            [p + root, q]
        } else {
            [q, root - p]
        };
        let mut unit = T::ONE / dot(sense, sense).at_least(T::TINY).sqrt();
        if dot(sense, inner.normal()) < T::ZERO {
            unit = -unit;
        }
        let sense = scale(unit, sense);
        let normal = [dot(stiffness[0], sense), dot(stiffness[1], sense)];
        let slope = dot(normal, normal).at_least(T::TINY).sqrt();
        let normal = scale(T::ONE / slope, normal);
        let across = (h00 * h11 - h01 * h10) / slope;

        let mut reference = (inner.q * dot(inner.normal(), normal)).at_least(inner.q * T::of(0.1));
        let change = sub(force, carried);
        let mut extra = dot(change, normal);
        // A ball next to its own equilibrium is there for the law: what it still has to move does not
        // elongate it.
        let mut settling = T::ZERO;
        if extra.abs() <= T::of(0.1) * reference {
            settling = extra.abs() / reference;
            reference += extra;
            extra = T::ZERO;
        }
        let three_halves = T::of(1.5);
        let flexibility = T::ONE / inner.slope + T::ONE / outer.slope;
        let bent = T::ONE / slope - flexibility;
        let (hertz, bend, per_sum) = if bent > T::ZERO {
            let along = fling * c.inner * normal[1].at_least(T::ZERO);
            let least = half * bent;
            let bend = (least * (reference + along)).at_least(room(c, inner, outer, sense));
            (
                three_halves * flexibility * reference,
                bend,
                least * reference / bend.at_least(T::TINY),
            )
        } else {
            (three_halves * reference / slope, T::ZERO, T::ONE)
        };
        Self {
            normal,
            sense,
            reference,
            hertz,
            bend,
            per_sum,
            elongation: extra / slope,
            // Inertia can make a ball unstable across; its contacts still are round.
            half_curvature: (half * across / reference)
                .at_least(T::of(0.25))
                .at_most(half * inner.inverse_radius),
            extra,
            settling,
            slope,
            change,
            stiffness: *stiffness,
        }
    }

    /// The ball carries on the inner race.
    #[inline(always)]
    pub fn carries(&self) -> bool {
        self.reference > T::ZERO
    }

    /// Force it started from.
    #[inline(always)]
    pub fn reference(&self) -> T {
        self.reference
    }

    /// Change of the slope from the linear law to the reaction `r`. The slope grows with no more than
    /// the cube of the force: that of a bent chain does.
    #[inline(always)]
    pub fn slope_change(&self, r: &Reaction<T>) -> T {
        (r.slope - self.slope).abs() + T::of(3.0) * self.settling * self.slope
    }

    /// The larger of the two slopes.
    #[inline(always)]
    pub fn larger_slope(&self, r: &Reaction<T>) -> T {
        r.slope.at_least(self.slope)
    }

    /// The law after a shift `d` of the ring; `last` is its last tension.
    #[inline(always)]
    pub fn react(&self, d: Pair<T>, last: &mut Stretch<T>) -> Reaction<T> {
        let w = self.sense;
        let (along, across) = (dot(w, d), w[1] * d[0] - w[0] * d[1]);
        let s = self.elongation + along + self.half_curvature * across * across;
        let three_halves = T::of(1.5);
        let (mut force, mut slope, mut excess) = (T::ZERO, T::ZERO, -self.reference);
        if !self.carries() {
            let root = s.sqrt();
            if s > T::ZERO {
                let gives = T::ONE / (T::ONE + self.bend * root);
                let secant = self.hertz * root * gives;
                force = secant * s;
                slope = secant * gives * (three_halves + self.bend * root);
                excess = force;
            }
        } else if self.bend > T::ZERO {
            if s != last.elongation {
                *last = Stretch {
                    elongation: s,
                    result: tension(self.hertz, self.bend, self.per_sum, s),
                };
            }
            let (x, rise) = last.result;
            if x > -T::ONE {
                let z = T::ONE + x;
                let square = self.reference * z * z;
                force = square * z;
                slope = T::of(3.0) * square / rise;
                excess = self.reference * x * (z * z + z + T::ONE);
            }
        } else {
            let x = s / self.hertz;
            let y = T::ONE + x;
            let root = y.sqrt();
            if y > T::ZERO {
                force = self.reference * root * y;
                slope = three_halves * self.reference * root / self.hertz;
                // y^(3/2) - 1 without a difference.
                excess = self.reference * x * (y + root + T::ONE) / (root + T::ONE);
            }
        }
        Reaction {
            force,
            slope,
            excess,
            along,
            across,
        }
    }

    /// What force and stiffness are beyond the linear law after a shift `d`.
    #[inline(always)]
    pub fn beyond(&self, r: &Reaction<T>) -> (Pair<T>, Square<T>) {
        let (n, w) = (self.normal, self.sense);
        let (t, v) = ([n[1], -n[0]], [w[1], -w[0]]);
        let curvature = self.half_curvature + self.half_curvature;
        let bend = curvature * r.across;
        let normal = r.excess - self.extra - self.slope * r.along;
        let across = r.excess * bend;
        let mixed = r.slope * bend;
        let by_along = add(scale(r.slope - self.slope, n), scale(mixed, t));
        let by_across = add(
            scale(mixed, n),
            scale(mixed * bend + curvature * r.excess, t),
        );
        let row = |i: usize| add(scale(by_along[i], w), scale(by_across[i], v));
        (add(scale(normal, n), scale(across, t)), [row(0), row(1)])
    }

    /// The same for a ball that is squeezed by `squeeze` between contacts in line, the inner groove's centre being
    /// at `centre`: if what it resists with then is more than the reaction `r`.
    #[inline(always)]
    pub fn beyond_in_line(
        &self,
        r: &Reaction<T>,
        d: Pair<T>,
        squeeze: T,
        centre: Pair<T>,
    ) -> Option<(Pair<T>, Square<T>)> {
        let root = squeeze.sqrt();
        let q = root * squeeze;
        if !(q > r.force) {
            return None;
        }
        let n = scale(T::ONE / length(centre), centre);
        let [h0, h1] = self.stiffness;
        let linear = self.reference + self.extra;
        let force = [
            q * n[0] - (linear * self.normal[0] + dot(h0, d)),
            q * n[1] - (linear * self.normal[1] + dot(h1, d)),
        ];
        let twist = T::of(1.5) * root - q;
        let mixed = twist * n[0] * n[1];
        let stiffness = [
            [q + twist * n[0] * n[0] - h0[0], mixed - h0[1]],
            [mixed - h1[0], q + twist * n[1] * n[1] - h1[1]],
        ];
        Some((force, stiffness))
    }

    /// Change of the contact's force by a shift `d`, and the shift that would have made it if the ball
    /// were linear: what moves the ball itself.
    #[inline(always)]
    pub fn follow(&self, d: Pair<T>, r: &Reaction<T>) -> (Pair<T>, Pair<T>) {
        let (beyond, _) = self.beyond(r);
        let linear = [dot(self.stiffness[0], d), dot(self.stiffness[1], d)];
        let change = add(add(self.change, linear), beyond);
        if !self.carries() {
            return (change, d);
        }
        let w = self.sense;
        let along = (r.excess - self.extra - self.slope * r.along) / self.slope;
        let turn = (r.excess / self.reference)
            .at_most(T::ONE)
            .at_least(-T::ONE);
        let across = r.across * turn;
        (
            change,
            add(d, add(scale(along, w), scale(across, [w[1], -w[0]]))),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn bent() -> Spring<f64> {
        Spring {
            normal: [0.6, 0.8],
            sense: [0.6, 0.8],
            reference: 2e-3,
            hertz: 0.016,
            bend: 0.01,
            per_sum: 1.0 / 1.3,
            elongation: 0.0,
            half_curvature: 0.4,
            extra: 0.0,
            slope: 3.0 * 2e-3 / (2.0 * 0.016 + 6.0 * 0.01 / 1.3),
            ..Spring::default()
        }
    }

    #[test]
    fn the_law_agrees_with_the_linear_one_in_value_and_slope() {
        let spring = bent();
        let r = spring.react([0.0, 0.0], &mut Stretch::none());
        assert!((r.force / spring.reference - 1.0).abs() < 1e-14);
        assert!((r.slope / spring.slope - 1.0).abs() < 1e-14);
        let (f, h) = spring.beyond(&r);
        assert!(f.iter().all(|x| x.abs() < 1e-17), "{f:?}");
        assert!(h.iter().flatten().all(|x| x.abs() < 1e-15), "{h:?}");
    }

    #[test]
    fn the_tangent_beyond_the_linear_law_is_the_derivative_of_the_force() {
        let spring = bent();
        let step = 1e-7;
        for d in [[0.0, 0.0], [3e-3, -2e-3], [-4e-3, 1e-2], [0.02, 0.01]] {
            let (_, h) = spring.beyond(&spring.react(d, &mut Stretch::none()));
            for j in 0..2 {
                let force = |sign: f64| {
                    let mut d = d;
                    d[j] += sign * step;
                    spring.beyond(&spring.react(d, &mut Stretch::none())).0
                };
                let (more, less) = (force(1.0), force(-1.0));
                for i in 0..2 {
                    let slope = (more[i] - less[i]) / (2.0 * step);
                    // As far as the law's own equation is solved.
                    let allowed = 1e-2 * spring.slope;
                    assert!(
                        (h[i][j] - slope).abs() < allowed,
                        "{d:?}: {} {slope}",
                        h[i][j]
                    );
                }
            }
        }
    }

    #[test]
    fn the_force_never_falls_with_the_elongation_and_never_is_negative() {
        let spring = bent();
        let forces: Vec<f64> = (-400..=400)
            .map(|i| f64::from(i) * 1e-3)
            .map(|s| spring.react([0.6 * s, 0.8 * s], &mut Stretch::none()).force)
            .collect();
        assert!(forces.windows(2).all(|w| w[1] >= w[0]));
        assert!(forces[0] >= 0.0 && forces[800] > forces[400]);
    }

    #[test]
    fn a_law_that_was_looked_at_reacts_as_one_that_was_not() {
        let spring = bent();
        let mut last = Stretch::none();
        for d in [0.0, 3e-2, 3e-2, -0.2, 3e-2, -10.0, -10.0, 0.0] {
            let again = spring.react([0.6 * d, 0.8 * d], &mut last);
            let fresh = spring.react([0.6 * d, 0.8 * d], &mut Stretch::none());
            assert_eq!(again, fresh, "{d}");
        }
    }

    #[test]
    fn the_tension_solves_its_equation_to_a_part_in_two_hundred() {
        for (s1, s2, r, s) in [
            (1.0, 1e-3, 0.2, 0.5),
            (1.0, 1e-3, 0.2, -0.02),
            (1e-4, 3.0, 1e3, 2e-6),
            (0.5, 0.0, 0.0, 0.1),
        ] {
            let (x, slope) = tension(s1, s2, 1.0 / (1.0 + r), s);
            let z: f64 = 1.0 + x;
            let bent: f64 = (1.0 + r) / (z * z * z + r);
            let left = s1 * (z * z - 1.0) + s2 * (1.0 - bent * bent);
            assert!(
                (left - s).abs() < 5e-3 * s.abs(),
                "{s1} {s2} {r} {s}: {left}"
            );
            assert!(slope > 0.0);
        }
        assert_eq!(tension(1.0, 1e-3, 1.0 / 1.2, -2.0).0, -1.0);
    }
}
