//! One ball against one groove: direction, deformation and force of the contact.
//!
//! A position is stored as a reference, whose contact deformation is known to twice the working
//! precision, plus a small offset. The deformation `|X| - lo`, a difference of nearly equal lengths,
//! then comes out of small quantities alone:
//! `|X| - lo = (e + (2 Xr + x).x) / (|X| + lo)` with `X = Xr + x`, `e = Xr.Xr - lo^2`,
//! so that single precision keeps six digits of it where the plain difference keeps three.
//!
//! Far from the solution the contact force is an unknown of its own, which *leads* the geometry: the
//! deformation belongs to the force, and what the geometry says beyond that, the lag, is taken out
//! by the next Newton step. This is the `4N + 5` system of the literature. It matters because a step
//! of the ring along a ball's groove changes the distance of the centres by the square of the step,
//! which is often much more than the deformation: with geometry leading, forces would explode.

use crate::constants::Split;
use crate::float::Real;

/// A vector in the axial-radial plane of a ball.
pub type Pair<T> = [T; 2];

#[inline(always)]
pub fn dot<T: Real>(a: Pair<T>, b: Pair<T>) -> T {
    a[0] * b[0] + a[1] * b[1]
}

#[inline(always)]
pub fn add<T: Real>(a: Pair<T>, b: Pair<T>) -> Pair<T> {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
pub fn sub<T: Real>(a: Pair<T>, b: Pair<T>) -> Pair<T> {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline(always)]
pub fn scale<T: Real>(a: T, v: Pair<T>) -> Pair<T> {
    [a * v[0], a * v[1]]
}

#[inline(always)]
pub fn length<T: Real>(v: Pair<T>) -> T {
    dot(v, v).at_least(T::TINY).sqrt()
}

/// Reference of a vector from one curvature centre to another.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reference<T> {
    /// The vector.
    pub vector: Pair<T>,
    /// Its squared length less that of the undeformed contact.
    pub excess: T,
}

impl<T: Real> Reference<T> {
    /// The reference `high + low` for a contact of undeformed length `length`, where `high` is a
    /// multiple of the fine grid and `low` small.
    ///
    /// On the way to `e`, each of the products that cancel is exact: `high` is a coarse part, whose
    /// square has few enough digits, and a part so small that its product with the coarse part has.
    #[inline]
    pub fn at(high: Pair<T>, low: Pair<T>, length_squared: Split<T>) -> Self {
        let coarse = [high[0].coarse(), high[1].coarse()];
        let low_high = [low[0].fine(), low[1].fine()];
        let rest = sub(low, low_high);
        let middle = add(sub(high, coarse), low_high);
        let twice = add(coarse, coarse);
        let leading = (dot(coarse, coarse) - length_squared.high) + dot(twice, middle);
        let trailing = dot(middle, middle) + dot(twice, rest) - length_squared.low;
        Self {
            vector: add(high, low),
            excess: leading + trailing,
        }
    }
}

/// State of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Contact<T> {
    /// Sine and cosine of the contact angle.
    pub sin: T,
    pub cos: T,
    /// One over the distance of the centres.
    pub inverse_radius: T,
    /// Deformation; negative where there is a gap.
    pub delta: T,
    /// Contact force, 0 across a gap.
    pub q: T,
    /// Its slope `dQ/d delta`.
    pub slope: T,
    /// Deformation by geometry less `delta`: 0 unless the force leads.
    pub lag: T,
}

impl<T: Real> Contact<T> {
    /// Contact of undeformed length `length` and load-deflection constant `k`, at `offset` from
    /// its reference; geometry leads.
    #[inline(always)]
    pub fn at(reference: &Reference<T>, offset: Pair<T>, length: T, k: T) -> Self {
        let mut contact = Self::between(reference, offset, length);
        contact.press(k);
        contact
    }

    /// The same as yet without its force.
    #[inline(always)]
    pub fn between(reference: &Reference<T>, offset: Pair<T>, length: T) -> Self {
        let v = add(reference.vector, offset);
        // Total: a ball on the curvature centre itself gets a direction and a radius.
        let radius = dot(v, v).at_least(T::TINY).sqrt();
        let inverse_radius = T::ONE / radius;
        let twice = add(add(reference.vector, reference.vector), offset);
        let delta = (reference.excess + dot(twice, offset)) / (radius + length);
        Self {
            sin: v[0] * inverse_radius,
            cos: v[1] * inverse_radius,
            inverse_radius,
            delta,
            q: T::ZERO,
            slope: T::ZERO,
            lag: T::ZERO,
        }
    }

    /// Gives the contact the force that belongs to its deformation.
    #[inline(always)]
    pub fn press(&mut self, k: T) {
        let root = k * self.delta.sqrt();
        if self.delta > T::ZERO {
            self.q = root * self.delta;
            self.slope = T::of(1.5) * root;
        }
    }

    /// Has the force `lead` lead, if that is positive and not near what geometry says.
    #[inline(always)]
    pub fn lead_by(&mut self, lead: T, k: T) {
        if lead > T::ZERO && (self.q - lead).abs() > T::of(0.1) * lead {
            let root = (lead / k).cbrt();
            let delta = root * root;
            self.lag = self.delta - delta;
            self.delta = delta;
            self.q = lead;
            self.slope = T::of(1.5) * k * root;
        }
    }

    /// Deformation by geometry.
    #[inline(always)]
    pub fn geometric_delta(&self) -> T {
        self.delta + self.lag
    }

    /// Direction of the contact force.
    #[inline(always)]
    pub fn normal(&self) -> Pair<T> {
        [self.sin, self.cos]
    }

    /// The direction in which the contact angle grows.
    #[inline(always)]
    pub fn tangent(&self) -> Pair<T> {
        [self.cos, -self.sin]
    }
}

/// The force of a contact between two linearisations.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lead<T> {
    /// The force; 0 lets geometry lead.
    pub q: T,
    /// What the last linearisation made of it: the force extrapolated to the geometry, its slope,
    /// its direction, and the deformation by geometry.
    linear: T,
    pub slope: T,
    pub normal: Pair<T>,
    delta: T,
}

/// What a step makes of a leading force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pull {
    /// The contact carries.
    Holds,
    /// The contact is about to open.
    Lets,
}

impl<T: Real> Lead<T> {
    /// A contact without force, across the gap `-delta`.
    #[inline(always)]
    pub fn open(normal: Pair<T>, delta: T) -> Self {
        Self {
            normal,
            delta,
            ..Self::default()
        }
    }

    /// Remembers a linearised contact.
    #[inline(always)]
    pub fn remember(&mut self, contact: &Contact<T>) {
        self.q = contact.q;
        self.linear = contact.q + contact.slope * contact.lag;
        self.slope = contact.slope;
        self.normal = contact.normal();
        self.delta = contact.geometric_delta();
    }

    /// Follows the contact's motion `d`. A force never falls below a tenth at once: the 3/2 law
    /// seen from a large force points below zero long before the contact opens.
    #[inline(always)]
    pub fn follow(&mut self, d: Pair<T>) -> Pull {
        self.follow_by(dot(self.normal, d))
    }

    /// Deformation by geometry after a motion `by` along the normal.
    #[inline(always)]
    pub fn reach(&self, by: T) -> T {
        self.delta + by
    }

    /// Change of the force by a motion `by` along the normal.
    #[inline(always)]
    pub fn growth(&self, by: T) -> T {
        self.linear - self.q + self.slope * by
    }

    /// Whether the contact opens by a motion `by` along the normal.
    #[inline(always)]
    pub fn lets_go(&self, by: T) -> bool {
        self.linear + self.slope * by < T::of(0.1) * self.q && self.delta + by < T::ZERO
    }

    /// How the contact's stiffness changes when its centres, one over `per_length` apart, move by `v`, along
    /// the contact and across it: the element along it, the mixed one, and the one across. The stiffness
    /// grows with the root of the deformation, of which a third of `dQ/Q` is the linear part; a turn
    /// mixes `k` along the contact with `Q / R` across. `per_force` is `1 / Q`.
    #[inline(always)]
    pub fn stiffening(&self, v: Pair<T>, per_length: T, per_force: T) -> [T; 3] {
        let turn = (self.slope - self.q * per_length) * per_length;
        let e = T::of(2.0 / 3.0) * self.growth(v[0]) * per_force;
        let factor = if e.abs() < T::of(0.1) {
            // Without the difference that loses digits.
            e * (T::of(0.5) - e * (T::of(0.125) - T::of(0.0625) * e))
        } else {
            (T::ONE + e).at_least(T::ZERO).sqrt() - T::ONE
        };
        [self.slope * factor, turn * v[1], turn * v[0]]
    }

    /// As [`Lead::follow`], for a motion `by` along the normal.
    #[inline(always)]
    pub fn follow_by(&mut self, by: T) -> Pull {
        let lets_go = self.lets_go(by);
        let q = self.linear + self.slope * by;
        self.q = (T::of(0.1) * self.q).at_least(q);
        if lets_go { Pull::Lets } else { Pull::Holds }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stiffening_is_the_derivative_of_the_contacts_tangent() {
        let (length, k) = (0.4, 1.3);
        let (n, t) = ([0.6, 0.8], [0.8, -0.6]);
        let vector = scale(length + 0.007, n);
        let reference = Reference {
            vector,
            excess: dot(vector, vector) - length * length,
        };
        // Along `n` and `t`: the tangent is that of a spring that turns with its ends.
        let tangent = |offset: Pair<f64>| {
            let contact = Contact::at(&reference, offset, length, k);
            let across = contact.q * contact.inverse_radius;
            let element = |a: Pair<f64>, b: Pair<f64>| {
                contact.slope * dot(contact.normal(), a) * dot(contact.normal(), b)
                    + across * dot(contact.tangent(), a) * dot(contact.tangent(), b)
            };
            [element(n, n), element(n, t), element(t, t)]
        };
        let contact = Contact::at(&reference, [0.0; 2], length, k);
        let mut lead = Lead::default();
        lead.remember(&contact);
        for v in [[1.0, 0.0], [0.0, 1.0], [-0.7, 0.4]] {
            let v = scale(1e-6, v);
            let offset = add(scale(v[0], n), scale(v[1], t));
            let (after, before) = (tangent(offset), tangent(scale(-1.0, offset)));
            let change = |v| lead.stiffening(v, contact.inverse_radius, 1.0 / contact.q);
            let (more, less) = (change(v), change(scale(-1.0, v)));
            for i in 0..3 {
                let (found, expected) = (more[i] - less[i], after[i] - before[i]);
                assert!(
                    (found - expected).abs() < 1e-5 * 1e-6 * contact.slope,
                    "{v:?}, element {i}: {found} for {expected}"
                );
            }
        }
    }
}
