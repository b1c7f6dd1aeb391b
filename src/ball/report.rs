//! Contacts and inertia loads of a ball at a given position, without slopes: for settling, and for results.

use crate::ball::contact::{Contact, Point};
use crate::ball::kinematics::{Contacts, Rule};
use crate::bearing::{Azimuth, Constants, Groove};
use crate::linalg::{Matrix2, Pair, add, dot, scale, sub};
use crate::real::Real;

/// State of one ball, SI units.
///
/// See [`Balls::kinematics`](crate::Balls::kinematics) for an example; [`Balls::balls`](crate::Balls::balls) gives these.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BallState<T> {
    /// Azimuth `phi`, rad from +y towards +z.
    pub azimuth: T,
    /// Inner contact angle, rad.
    pub alpha_i: T,
    /// Outer contact angle, rad.
    pub alpha_o: T,
    /// Inner contact force, N; 0 if the ball is off the inner race.
    pub q_i: T,
    /// Outer contact force, N.
    pub q_o: T,
    /// Deformation of the inner contact, m; negative where there is a gap.
    pub delta_i: T,
    /// Deformation of the outer contact, m.
    pub delta_o: T,
    /// Centrifugal force `Fc`, N.
    pub centrifugal_force: T,
    /// Gyroscopic moment `Mg`, N m.
    pub gyroscopic_moment: T,
}

/// Where a ball touches a race, SI units; all 0 where it does not.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct ContactPatch<T> {
    /// Peak pressure, Pa.
    pub peak_pressure: T,
    /// Semi-axis `a` of the contact ellipse, m, across the rolling direction.
    pub semi_major: T,
    /// Semi-axis `b` of the contact ellipse, m, along the rolling direction.
    pub semi_minor: T,
    /// Spin over rolling: magnitudes of the ball's angular speed against the race along the contact's normal, and in the
    /// tangent plane. Heat grows with it.
    pub spin_to_roll: T,
}

/// How a ball turns, and how its contacts are pressed, SI units.
///
/// See [`Balls::kinematics`](crate::Balls::kinematics) for an example.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BallKinematics<T> {
    /// Speed `omega_m` about the bearing's axis, rad/s: the cage speed.
    pub cage_speed: T,
    /// Speed `omega_R` of its own rotation, rad/s, seen from the cage.
    pub rotation: T,
    /// Attitude angle `b` of the axis of that rotation, rad from the bearing's axis.
    pub attitude: T,
    /// Where it touches the inner race.
    pub inner: ContactPatch<T>,
    /// Where it touches the outer race.
    pub outer: ContactPatch<T>,
}

/// Both contacts of a ball, and its inertia loads.
#[derive(Debug, Clone, Copy)]
pub struct Kinetics<T> {
    pub inner: Contact<T>,
    pub outer: Contact<T>,
    /// Centrifugal force, and gyroscopic couple `2 Mg / D`.
    pub centrifugal: T,
    pub couple: T,
    /// Friction forces at the inner and the outer contact.
    pub friction: Pair<T>,
    /// Cage speed over shaft speed; and that part of the ball's own rotation which is across the bearing's axis,
    /// `omega_R sin b tau`, over it.
    pub mu: T,
    nu: T,
}

impl<T: Real> Kinetics<T> {
    /// A ball at rest between both races: the two contacts share what `both` in series have.
    pub fn at_rest(c: &Constants<T>, both: &Contact<T>) -> Self {
        let part = |delta: T| Contact {
            delta,
            root: delta.at_least(T::ZERO).sqrt_abs(),
            ..*both
        };
        let outer = part(both.delta * c.outer_share);
        let inner = part(both.delta - outer.delta);
        // What all rules say where both contacts point one way.
        let mu = T::of(0.5) * (T::ONE - c.tau * both.n[1]);
        Self {
            inner,
            outer,
            centrifugal: T::ZERO,
            couple: T::ZERO,
            friction: [T::ZERO; 2],
            mu,
            nu: mu * both.n[0],
        }
    }

    /// [`Kinetics::at_speed`] by a call: in line, settling has three copies of it (+1.8 kB).
    #[inline(never)]
    pub fn by_call<R: Rule>(c: &Constants<T>, p: &Point<T>, a: Pair<T>, x: Pair<T>) -> Self {
        Self::at_speed::<R>(c, p, a, x)
    }

    /// A ball at speed: offset `x` of the ball from the row's reference, offset `a` of the groove's centre.
    #[inline(always)]
    pub fn at_speed<R: Rule>(c: &Constants<T>, p: &Point<T>, a: Pair<T>, x: Pair<T>) -> Self {
        let i = Contact::at(&p.inner, sub(a, x), p.li, c.ki);
        let o = Contact::at(&p.outer, x, p.lo, T::ONE);
        let (d_i, d_o) = (i.delta.at_least(T::ZERO), o.delta.at_least(T::LEAST));
        let (wi, wo) = (c.kw * d_i * d_i, d_o * d_o);
        let eta = wi / (wi + wo);
        let sigma = i.q / (i.q + o.q).at_least(T::TINY);
        let m = R::speeds(
            c.tau,
            &Contacts {
                inner: i.n,
                outer: o.n,
                sin_d: i.n[0] * o.n[1] - i.n[1] * o.n[0],
                q: T::ONE / (T::ONE + dot(i.n, o.n)).at_least(T::of(0.01)),
                eta,
                rest: T::ONE - eta,
                sigma,
                sigma_rest: T::ONE - sigma,
                closed: i.delta > T::NOTHING,
            },
        );
        let couple = if R::FRICTION {
            T::of(0.4) * p.s * m.mu * m.nu
        } else {
            T::ZERO
        };
        Self {
            inner: i,
            outer: o,
            centrifugal: p.s * m.mu * m.mu,
            couple,
            friction: [m.share * couple, m.share_rest * couple],
            mu: m.mu,
            nu: m.nu,
        }
    }

    /// Inertia loads on the ball, friction included, axial and radial.
    pub fn loads(&self) -> Pair<T> {
        let ([si, ci], [so, co]) = (self.inner.n, self.outer.n);
        let [ti, to] = self.friction;
        sub(
            add([T::ZERO, self.centrifugal], scale(ti, [ci, -si])),
            scale(to, [co, -so]),
        )
    }

    /// Contact forces on the ball, and minus their slope by its position.
    pub fn forces(&self) -> (Pair<T>, Matrix2<T>) {
        let (i, o) = (&self.inner, &self.outer);
        let f = sub(scale(i.q, i.n), scale(o.q, o.n));
        let ([iaa, iar, irr], [oaa, oar, orr]) = (i.tangent(), o.tangent());
        let mixed = iar + oar;
        (f, [[iaa + oaa, mixed], [mixed, irr + orr]])
    }

    /// The ball at the azimuth `at`, in SI units.
    pub fn state(&self, c: &Constants<T>, at: &Azimuth<T>) -> BallState<T> {
        let (inner, outer) = (&self.inner, &self.outer);
        BallState {
            azimuth: at.sin.atan2(at.cos),
            alpha_i: inner.n[0].atan2(inner.n[1]),
            alpha_o: outer.n[0].atan2(outer.n[1]),
            q_i: inner.q * c.force,
            q_o: outer.q * c.force,
            delta_i: inner.delta * c.length,
            delta_o: outer.delta * c.length,
            centrifugal_force: self.centrifugal * c.force,
            gyroscopic_moment: self.couple * (c.force * c.ball_radius),
        }
    }

    /// The ball's rotation along the bearing's axis, over the shaft speed, times tau. With that across, the ball rolls on the race
    /// whose contact is more radial.
    #[inline(always)]
    fn along(&self, c: &Constants<T>) -> T {
        let ([si, ci], [so, co]) = (self.inner.n, self.outer.n);
        if co >= ci {
            (self.mu * (T::ONE + c.tau * co) - self.nu * so) / co.at_least(T::of(1e-3))
        } else {
            ((T::ONE - self.mu) * (T::ONE - c.tau * ci) - self.nu * si) / ci.at_least(T::of(1e-3))
        }
    }

    /// Magnitude of the ball's rotation, over the shaft speed, times tau.
    #[inline(always)]
    pub fn rotation(&self, c: &Constants<T>) -> T {
        let along = self.along(c);
        (along * along + self.nu * self.nu).sqrt_abs()
    }

    /// How the ball turns on a shaft with the speed `omega`, rad/s, and how its contacts are pressed, in SI units.
    pub fn turning(&self, c: &Constants<T>, omega: T) -> BallKinematics<T> {
        let ([si, ci], [so, co]) = (self.inner.n, self.outer.n);
        let (along, across) = (self.along(c), self.nu);
        let (orbit_i, orbit_o) = (c.tau * (T::ONE - self.mu), -(c.tau * self.mu));
        let spin_to_roll = |orbit: T, [sin, cos]: Pair<T>| {
            let spin = orbit * sin + (along * sin - across * cos);
            let roll = orbit * cos + (along * cos + across * sin);
            spin.abs() / roll.abs().at_least(T::TINY)
        };
        let patch = |contact: &Contact<T>, groove: &Groove<T>, spin_to_roll: T| {
            if !(contact.delta > T::ZERO) {
                return ContactPatch::default();
            }
            let (peak_pressure, semi_major) = (
                groove.pressure * contact.root,
                groove.semi_major * contact.root,
            );
            let area = contact.q * c.force * T::of(1.5 / core::f64::consts::PI) / peak_pressure;
            ContactPatch {
                peak_pressure,
                semi_major,
                semi_minor: area / semi_major,
                spin_to_roll,
            }
        };
        BallKinematics {
            cage_speed: self.mu * omega,
            rotation: self.rotation(c) * (omega.abs() / c.tau),
            attitude: across.atan2(along),
            inner: patch(&self.inner, &c.grooves[0], spin_to_roll(orbit_i, [si, ci])),
            outer: patch(&self.outer, &c.grooves[1], spin_to_roll(orbit_o, [so, co])),
        }
    }

    /// Energy of the contacts.
    pub fn energy(&self) -> T {
        let two_fifths = T::of(0.4);
        let (i, o) = (&self.inner, &self.outer);
        two_fifths * (i.q * i.delta.at_least(T::ZERO) + o.q * o.delta.at_least(T::ZERO))
    }
}
