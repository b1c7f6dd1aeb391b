//! Balls at speed from one linearisation to the next: where they are put, their own steps, how they follow the
//! ring, and what that changes of their tangents.

use crate::ball::{Ball, Share};
use crate::constants::{Constants, Split};
use crate::contact::{Lead, Pair, Pull, Reference, add, dot, length, scale, sub};
use crate::float::Real;
use crate::kinematics::Attitude;
use crate::ring::Change;
use crate::scene::sealed;
use crate::spring::{Reaction, Spring, Square, tension};

/// What drives the balls of one sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive<T> {
    /// Centrifugal force at a cage speed equal to the shaft's, `m dm omega^2 / 2`.
    pub speed_load: T,
    /// A force so small that the working precision cannot tell it beside the bearing's load.
    pub negligible: T,
}

/// What a step changes of a ball's tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiffening<T> {
    /// Axial, mixed and radial element.
    pub tangent: [T; 3],
    /// How much of that is not known, relative to it.
    pub unknown: T,
    /// As in [`Change`].
    pub hardening: T,
}

impl<T: Real> Change<T> {
    /// A contact that reacted as `reaction`, and whose normal turned by `turn`.
    #[inline(always)]
    fn of(step: T, normal: Pair<T>, spring: &Spring<T>, reaction: &Reaction<T>, turn: T) -> Self {
        let slope = spring.slope_change(reaction);
        let larger = spring.larger_slope(reaction);
        // An element of a contact across it grows with the square of the turn.
        let mixed = normal[0] * normal[1];
        let turned = larger * turn.abs() * ((mixed + mixed).abs() + turn.abs());
        let stiffness = [
            slope * normal[0] * normal[0] + turned,
            slope * normal[1] * normal[1] + turned,
        ];
        Self {
            step,
            stiffness,
            remainder: stiffness,
            hardening: T::ZERO,
        }
    }
}

/// Radial position and centrifugal force of a ball that only the outer race holds, the inner
/// groove's centre being at `centre`.
#[inline(never)]
pub fn free_ball<T: Real>(c: &Constants<T>, speed_load: T, centre: Pair<T>) -> (T, T) {
    let v = [centre[0], centre[1] - c.outer];
    let cosine = v[1] / length(v);
    let mu = (T::ONE - c.tau * cosine) / (T::ONE + cosine).at_least(T::of(0.01));
    let force = speed_load * mu * mu;
    let root = (force / c.ko).cbrt();
    (c.outer + root * root, force)
}

impl<T: Real> Ball<T> {
    /// The inner groove's curvature centre at the ring's offset `a`.
    #[inline(always)]
    fn centre(&self, a: Pair<T>) -> Pair<T> {
        add(add(self.outer.vector, self.inner.vector), a)
    }

    /// How far the centres are apart beyond their distance in the unloaded bearing, to first order.
    #[inline(always)]
    fn squeeze(&self, a: Pair<T>) -> T {
        let twice = add(self.centre(a), self.centre([T::ZERO; 2]));
        T::of(0.5) * (self.excess + dot(twice, a))
    }

    /// Puts the ball at `at`, under the contact forces `inner` and `outer`.
    #[inline(always)]
    fn put(&mut self, at: Pair<T>, inner: T, outer: T) {
        self.x = sub(at, self.outer.vector);
        self.inner_lead.q = inner;
        self.outer_lead.q = outer;
    }

    /// Puts a lost ball where it belongs without further knowledge, and returns how it `was`; or, where that has led
    /// nowhere either, back to how it was, which tells what it was lost to. Out of line, since hardly any ball is
    /// lost.
    #[cold]
    #[inline(never)]
    fn put_anew(
        &mut self,
        c: &Constants<T>,
        drive: &Drive<T>,
        a: Pair<T>,
        was: Option<(Pair<T>, T, T)>,
    ) -> Option<(Pair<T>, T, T)> {
        if let Some(was) = was {
            (self.x, self.inner_lead.q, self.outer_lead.q) = was;
            return None;
        }
        let was = (self.x, self.inner_lead.q, self.outer_lead.q);
        place(c, drive.speed_load, self, self.centre(a), self.squeeze(a));
        Some(was)
    }

    /// True for a ball that is off both races and too slow for its centrifugal force to count: it drops
    /// out, as at rest.
    #[inline]
    fn drops_out(&mut self, c: &Constants<T>, drive: &Drive<T>, a: Pair<T>) -> bool {
        if drive.speed_load <= drive.negligible {
            let centre = self.centre(a);
            let squeeze = self.squeeze(a);
            if squeeze <= T::ZERO {
                // It sees its gap, or a step could close it unnoticed.
                let normal = scale(T::ONE / length(centre), centre);
                *self = Self {
                    outer: self.outer,
                    inner: self.inner,
                    excess: self.excess,
                    x: sub(scale(c.outer, normal), self.outer.vector),
                    spring: Spring::open(normal, T::ONE, T::ZERO, squeeze, T::of(0.5)),
                    inner_lead: Lead::open(normal, squeeze),
                    ..Self::default()
                };
                return true;
            }
            if self.inner_lead.q <= T::ZERO {
                place(c, T::ZERO, self, centre, squeeze);
            }
        } else if self.outer_lead.q <= T::ZERO {
            // Dropped out at a standstill: without forces it would have no cage speed, and stay so.
            place(c, drive.speed_load, self, self.centre(a), self.squeeze(a));
        }
        false
    }
}

/// Deformation of a contact under the force `q`.
#[inline(always)]
fn depth<T: Real>(q: T, k: T) -> T {
    let root = (q / k).cbrt();
    root * root
}

/// Starts for a ball, by what holds it: out on the outer race, off the inner one; squeezed on the line
/// of the two curvature centres, as at rest; near that line, as a chain that centrifugal force bends
/// (see the `spring` module); or, where the grooves leave it room, pressed by centrifugal force into
/// the corner between them.
#[inline(never)]
fn place<T: Real>(
    c: &Constants<T>,
    speed_load: T,
    ball: &mut Ball<T>,
    centre: Pair<T>,
    squeeze: T,
) {
    let [a1, a2] = centre;
    let squared = dot(centre, centre).at_least(T::TINY);
    let distance = squared.sqrt();
    let (free, fc) = free_ball(c, speed_load, centre);
    let v = [a1, a2 - free];
    if fc > T::ZERO && dot(v, v) <= c.inner * c.inner {
        ball.put([T::ZERO, free], T::ZERO, fc);
    } else if !(fc > T::ZERO) {
        let squeeze = squeeze.at_least(T::ZERO);
        let along = (c.outer + squeeze * c.outer_share) / distance;
        let q = squeeze * squeeze.sqrt();
        ball.put(scale(along, centre), q, q);
    } else {
        let a = scale(T::ONE / distance, centre);
        let h = c.inner * c.outer;
        let (across, along) = (fc * a[0], fc * a[1].at_least(T::ZERO));
        let slack = T::of(0.5) * h * across * across;
        let r = along * c.inner;
        // From a force of the right order, where the chain has the elongation `start`.
        let order = r + squeeze * squeeze.at_least(T::ZERO).sqrt();
        let (hertz, bend) = (depth(order, T::ONE), slack / ((order + r) * (order + r)));
        let start = hertz - bend + depth(along, c.ko);
        let per_sum = T::ONE / (T::ONE + r / order);
        let (z, _) = tension(hertz, bend, per_sum, squeeze - start);
        let z = T::ONE + z;
        let q = order * z * z * z;
        let y = across * h / (q + r).at_least(T::TINY);
        if z > T::ZERO && y.abs() < T::of(0.25) * c.inner.at_most(c.outer) {
            let reach = c.outer + depth(q + along, c.ko) - T::of(0.5) * y * y / c.outer;
            let at = [a[0] * reach - a[1] * y, a[1] * reach + a[0] * y];
            ball.put(at, q, q + along);
            return;
        }
        let (mut outer, mut inner) = (c.outer, c.inner);
        for pass in 0..2 {
            let along = T::of(0.5) * (T::ONE + (outer * outer - inner * inner) / squared);
            let across = (outer * outer / squared - along * along)
                .at_least(T::ZERO)
                .sqrt();
            let across = if a1 < T::ZERO { -across } else { across };
            let at = [a1 * along - a2 * across, a2 * along + a1 * across];
            // Triangle of forces: Qi sin(ai - ao) = Fc sin ao, Qo sin(ai - ao) = Fc sin ai.
            let (si, ci) = ((a1 - at[0]) / inner, (a2 - at[1]) / inner);
            let (so, co) = (at[0] / outer, at[1] / outer);
            let unit = fc / (si * co - ci * so).abs().at_least(T::of(1e-3));
            let (qi, qo) = (unit * so.abs(), unit * si.abs());
            if pass == 1 {
                ball.put(at, qi, qo);
            }
            outer = c.outer + depth(qo, c.ko);
            inner = c.inner + depth(qi, c.ki);
        }
    }
}

/// The rule of a shaft that turns, and whether its balls need friction.
// Whoever misses `Motion` is told so in terms of this trait, which nearly all motions have it from.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a motion of the balls",
    label = "not a motion",
    note = "a motion is `Static`, `Centrifugal<A>` or `Full<A>`",
    note = "`A` is an attitude rule: `RacewayControlFree`, `OuterRaceControl` or `InnerRaceControl`",
    note = "balls at rest have no attitude, so that `Static` takes no rule"
)]
pub trait Turning: sealed::Sealed + Sized + 'static {
    type Rule: Attitude;

    /// Places a ball without any knowledge of its last position.
    #[doc(hidden)]
    #[inline(always)]
    fn place<T: Real>(c: &Constants<T>, speed_load: T, ball: &mut Ball<T>, centre: Pair<T>) {
        place(c, speed_load, ball, centre, length(centre) - T::ONE);
    }

    /// Refers a ball to a ring reference at which the inner groove's centre is at `coarse + fine`.
    #[doc(hidden)]
    #[inline(never)]
    fn rebase<T: Real>(c: &Constants<T>, ball: &mut Ball<T>, coarse: Pair<T>, fine: Pair<T>) {
        let old = ball.outer.vector;
        let new = [(old[0] + ball.x[0]).fine(), (old[1] + ball.x[1]).fine()];
        ball.x = add(ball.x, sub(old, new));
        ball.outer = Reference::at(new, [T::ZERO; 2], c.outer_squared);
        ball.inner = Reference::at(sub(coarse, new), fine, c.inner_squared);
        ball.excess = Reference::at(coarse, fine, Split::ONE).excess;
    }

    /// Linearises the ball at the ring's offset `a`. The second value is how far it was from its own
    /// equilibrium: unbalanced force over the largest, plus lag over deformation. If that is more than
    /// `bad`, nothing is worked out but the ball's own step; otherwise, with `law`, its law is, too.
    #[doc(hidden)]
    #[inline(never)]
    fn linearise<T: Real, const D: usize>(
        c: &Constants<T>,
        drive: &Drive<T>,
        ball: &mut Ball<T>,
        a: Pair<T>,
        bad: T,
        law: bool,
    ) -> (Share<T>, T) {
        if ball.drops_out(c, drive, a) {
            return (Share::NONE, T::ZERO);
        }
        ball.linearise::<Self::Rule, D>(c, drive.speed_load, drive.negligible, a, bad, law)
    }

    /// Linearises the ball; beyond the imbalance `bad` it makes its own step first, `most` times at most.
    /// Returns how often it did, too. Such steps have no bound, and forces that have lost touch with the geometry do
    /// not come back to it: a ball that they have lost is put where it belongs without further knowledge,
    /// makes `anew` steps from there, and is left as it was where that leads nowhere either.
    #[doc(hidden)]
    #[inline(always)]
    fn settled<T: Real, const D: usize>(
        c: &Constants<T>,
        drive: &Drive<T>,
        ball: &mut Ball<T>,
        a: Pair<T>,
        (bad, most): (T, u16),
        law: bool,
        mut anew: Option<u16>,
    ) -> (Share<T>, T, u16) {
        let (mut repeats, mut until, mut was) = (0, most, None);
        loop {
            let bad = if repeats == until {
                T::of(f64::INFINITY)
            } else {
                bad
            };
            let (share, imbalance) = Self::linearise::<T, D>(c, drive, ball, a, bad, law);
            if imbalance > bad {
                Self::settle(ball);
                repeats += 1;
            } else if let (Some(more), false) = (anew, imbalance < T::ONE) {
                was = ball.put_anew(c, drive, a, was);
                anew = was.and(Some(0));
                until = repeats + more;
            } else {
                return (share, imbalance, repeats);
            }
        }
    }

    /// What the law of the last linearisation has beyond the linear force and tangent when the ring steps by
    /// `da` from its offset `a`.
    #[doc(hidden)]
    #[inline(always)]
    fn beyond<T: Real>(ball: &mut Ball<T>, a: Pair<T>, da: Pair<T>) -> (Pair<T>, Square<T>) {
        let reaction = ball.spring.react(da, &mut ball.stretch);
        // What the outer contact has given way already is not the ring's to squeeze. Two numbers are compared, not
        // their difference with 0, for the sake of its square root: see `sqrt`.
        let to = add(a, da);
        let (drawn, given) = (ball.squeeze(to), ball.outer_lead.reach(T::ZERO));
        if drawn > given {
            let centre = ball.centre(to);
            if let Some(in_line) = ball
                .spring
                .beyond_in_line(&reaction, da, drawn - given, centre)
            {
                return in_line;
            }
        }
        ball.spring.beyond(&reaction)
    }

    /// Makes the ball's own Newton step, the ring at rest.
    #[doc(hidden)]
    #[inline]
    fn settle<T: Real>(ball: &mut Ball<T>) {
        let mut dx = ball.outward(ball.step);
        let size = dx[0].abs() + dx[1].abs();
        let longest = T::of(0.3);
        if !(size < longest) {
            dx = if size.is_finite() {
                scale(longest / size, dx)
            } else {
                [T::ZERO; 2]
            };
        }
        ball.x = add(ball.x, dx);
        // Forces that grow faster than this have lost touch with the geometry.
        let most = T::of(4.0) * ball.outer_lead.q.at_least(ball.inner_lead.q);
        if ball.outer_lead.q > T::ZERO {
            ball.outer_lead.follow(dx);
            ball.outer_lead.q = ball.outer_lead.q.at_most(most);
        }
        if ball.inner_lead.q > T::ZERO {
            let pull = ball.inner_lead.follow(sub([T::ZERO; 2], dx));
            let next_to_nothing = T::of(1e-3) * ball.outer_lead.q;
            ball.inner_lead.q = if pull == Pull::Lets && ball.inner_lead.q < next_to_nothing {
                T::ZERO
            } else {
                ball.inner_lead.q.at_most(most)
            };
        }
    }

    /// Forgets the Newton step of a ball that has made it, and takes one that follows a relative change
    /// of the speed load instead; returns the change of what it hands to the ring (as [`Share`], without
    /// stiffness).
    #[doc(hidden)]
    #[inline(always)]
    fn accelerate<T: Real>(ball: &mut Ball<T>, by: T) -> Share<T> {
        ball.step = scale(by, ball.step_by_speed);
        let force = scale(by, ball.force_by_speed);
        Share {
            force,
            couple: by * ball.couple_by_speed,
            ..Share::NONE
        }
    }

    /// What the ball's force has beyond the linear one, to second order, after it was accelerated and
    /// the ring stepped by `da`.
    #[doc(hidden)]
    #[inline(always)]
    fn second_order<T: Real>(c: &Constants<T>, ball: &mut Ball<T>, da: Pair<T>) -> Pair<T> {
        let (qi, qo) = (ball.inner_lead.q, ball.outer_lead.q);
        if !(qi > T::ZERO) {
            return [T::ZERO; 2];
        }
        let (v, w, [cd, sd]) = ball.motions(ball.inward(da));
        let per_both = T::ONE / (qi * qo).at_least(T::TINY);
        // Half of the change of stiffness by the motion, times the motion.
        let half = T::of(0.5);
        let beyond = |[along, mixed, _]: [T; 3], v: Pair<T>| {
            [half * (along * v[0] + mixed * v[1]), mixed * v[0]]
        };
        let inner = beyond(ball.inner_lead.stiffening(v, c.per_inner, per_both * qo), v);
        let outer = beyond(ball.outer_lead.stiffening(w, c.per_outer, per_both * qi), w);
        let on_ball = sub(
            inner,
            [cd * outer[0] - sd * outer[1], sd * outer[0] + cd * outer[1]],
        );
        let [m, y] = [&ball.mobility, &ball.slope];
        ball.step = add(ball.step, [dot(m[0], on_ball), dot(m[1], on_ball)]);
        ball.outward([
            inner[0] - y[0][0] * on_ball[0] - y[1][0] * on_ball[1],
            inner[1] - y[0][1] * on_ball[0] - y[1][1] * on_ball[1],
        ])
    }

    /// What a step `da` of the ring, and the ball's own, will change of the ball's tangent, as long as
    /// linearisations hold.
    #[doc(hidden)]
    #[inline]
    fn stiffening<T: Real>(c: &Constants<T>, ball: &Ball<T>, da: Pair<T>) -> Stiffening<T> {
        let (v, w, [cd, sd]) = ball.motions(ball.inward(da));
        let (inner, outer) = (&ball.inner_lead, &ball.outer_lead);
        let [n0, n1] = inner.normal;
        let abrupt = if !(inner.q > T::ZERO) {
            let closed = inner.reach(v[0]).at_least(T::ZERO);
            Some(T::of(1.5) * c.ki * closed.sqrt())
        } else if inner.lets_go(v[0]) {
            Some(-inner.slope)
        } else {
            None
        };
        if let Some(slope) = abrupt {
            let [along, across] = scale(slope, inner.normal);
            let mixed = along * n1;
            return Stiffening {
                tangent: [along * n0, mixed, across * n1],
                unknown: T::ONE,
                hardening: T::ZERO,
            };
        }
        // The ball settles where energy is least, so that its own change of place does not count to first
        // order: a contact's change, at what the ring's motion is at the contact.
        let y = &ball.slope;
        let per_both = T::ONE / (inner.q * outer.q).at_least(T::TINY);
        let (per_i, per_o) = (per_both * outer.q, per_both * inner.q);
        let turned = |[along, mixed, across]: [T; 3], n: Pair<T>, t: Pair<T>| {
            let by_n = add(scale(along, n), scale(mixed, t));
            let by_t = add(scale(mixed, n), scale(across, t));
            [
                by_n[0] * n[0] + by_t[0] * t[0],
                by_n[0] * n[1] + by_t[0] * t[1],
                by_n[1] * n[1] + by_t[1] * t[1],
            ]
        };
        let of_inner = turned(
            inner.stiffening(v, c.per_inner, per_i),
            [T::ONE - y[0][0], -y[0][1]],
            [-y[1][0], T::ONE - y[1][1]],
        );
        let of_outer = turned(
            outer.stiffening(w, c.per_outer, per_o),
            add(scale(cd, y[0]), scale(sd, y[1])),
            sub(scale(cd, y[1]), scale(sd, y[0])),
        );
        let s: [T; 3] = core::array::from_fn(|i| of_inner[i] + of_outer[i]);
        let product = n0 * n1;
        let mixed = (s[0] - s[2]) * product + s[1] * (n1 * n1 - n0 * n0);
        let twice = (s[1] + s[1]) * product;
        let tangent = [
            s[0] * n0 * n0 + twice + s[2] * n1 * n1,
            mixed,
            s[0] * n1 * n1 - twice + s[2] * n0 * n0,
        ];
        // Not known: what is of second order in the forces, and how inertia and friction change. The
        // factors make the estimate cover the campaign's errors.
        let forces = (inner.growth(v[0]) * per_i).abs() + (outer.growth(w[0]) * per_o).abs();
        let unknown = T::of(0.02) + T::of(0.4) * forces + T::of(0.04) * ball.fling * per_i;
        Stiffening {
            tangent,
            unknown: unknown.at_most(T::ONE),
            hardening: inner.slope * inner.slope * per_i,
        }
    }

    /// Follows a step `da` of the ring that is so short that linearisations hold. Returns the ball's
    /// step.
    #[doc(hidden)]
    #[inline]
    fn advance<T: Real>(ball: &mut Ball<T>, da: Pair<T>) -> T {
        let da = ball.inward(da);
        let local = ball.stepped(da);
        let dx = ball.outward(local);
        ball.x = add(ball.x, dx);
        ball.outer_lead.follow(dx);
        if ball.inner_lead.q > T::ZERO && ball.inner_lead.follow_by(da[0] - local[0]) == Pull::Lets
        {
            ball.inner_lead.q = T::ZERO;
        }
        dx[0].abs() + dx[1].abs()
    }

    /// Follows a step `da` of the ring from its offset `a` by the ball's law.
    #[doc(hidden)]
    #[inline]
    fn follow<T: Real>(
        c: &Constants<T>,
        drive: &Drive<T>,
        ball: &mut Ball<T>,
        a: Pair<T>,
        da: Pair<T>,
    ) -> Change<T> {
        let reaction = ball.spring.react(da, &mut ball.stretch);
        let (force, effective) = ball.spring.follow(da, &reaction);
        let dx = ball.outward(ball.stepped(ball.inward(effective)));
        let step = dx[0].abs() + dx[1].abs();
        let normal = ball.inner_lead.normal;
        let v = sub(da, dx);
        let turn = (normal[1] * v[0] - normal[0] * v[1]) / c.inner;
        let mut change = Change::of(step, normal, &ball.spring, &reaction, turn);

        // A ball whose force changes a lot, and matters beside the centrifugal one, is not where its
        // tangent says.
        let (old, new) = (ball.spring.reference(), reaction.force);
        let to = add(a, da);
        let squeeze = ball.squeeze(to).at_least(T::ZERO);
        let squeezed = squeeze * squeeze.sqrt();
        let much = T::of(4.0);
        let fling = T::of(0.3) * ball.fling;
        let far = !(step < T::of(0.1))
            || new > much * old
            || new * much < old
            || squeezed > much * (new + fling);
        let matters = old > fling || new > fling || squeezed > fling;
        if !step.is_finite() || (far && matters) {
            place(c, drive.speed_load, ball, ball.centre(to), ball.squeeze(to));
            // Far from its reference.
            change.step = T::ONE;
            return change;
        }

        ball.x = add(ball.x, dx);
        let least = T::of(0.1);
        let outer = &mut ball.outer_lead;
        if outer.q > T::ZERO {
            outer.q = (outer.q + dot(outer.normal, force)).at_least(least * outer.q);
        }
        let inner = &mut ball.inner_lead;
        if inner.q > T::ZERO {
            inner.q = if new > T::ZERO {
                (inner.q + dot(inner.normal, force)).at_least(least * new)
            } else {
                T::ZERO
            };
        }
        change
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::constants::Azimuth;
    use crate::ring::curvature_centre;
    use crate::spring::Stretch;
    use crate::{Bearing, Design, FreeContact, Full, Material, Motion};

    const AT_REST: Drive<f64> = Drive {
        speed_load: 0.0,
        negligible: 0.0,
    };

    /// A B7005C.
    pub fn spindle<T: Real>() -> Bearing<T, 16> {
        let design = Design {
            ball_diameter: 6.35e-3,
            pitch_diameter: 36e-3,
            inner_groove_factor: 0.515,
            outer_groove_factor: 0.525,
            free_contact: FreeContact::Angle(15f64.to_radians()),
            first_ball: 0.0,
            inner_shoulder_angle: Design::HIGHEST_SHOULDER,
            outer_shoulder_angle: Design::HIGHEST_SHOULDER,
            ring: Material::STEEL,
            ball: Material::STEEL,
        };
        Bearing::build(&design).expect("a B7005C can be built")
    }

    #[test]
    fn a_ball_that_dropped_out_sees_a_step_close_its_gap() {
        let bearing = spindle();
        let c = &bearing.constants;
        let (coarse, fine) = curvature_centre(c, &[0.0; 5], &bearing.azimuths[0]);
        let mut ball = Ball::<f64>::default();
        <Full>::rebase(c, &mut ball, coarse, fine);
        let (share, _) =
            <Full>::linearise::<f64, 5>(c, &AT_REST, &mut ball, [-0.01, 0.0], 0.0, true);
        assert_eq!(share, Share::NONE);
        let closed = <Full>::stiffening(c, &ball, [0.02, 0.0]);
        assert!(closed.tangent[0] > 0.0 && closed.tangent[2] > 0.0 && closed.unknown == 1.0);
        let open = <Full>::stiffening(c, &ball, [-0.02, 0.0]);
        assert_eq!(open.tangent, [0.0; 3]);
        // Under the law alone: the contact of the bearing at rest.
        let at = add(add(coarse, fine), [0.01, 0.0]);
        let squeeze = length(at) - 1.0;
        let still = squeeze * squeeze.sqrt();
        let of_ball = ball.spring.react([0.02, 0.0], &mut Stretch::none()).force;
        assert!(of_ball > 0.0 && (of_ball / still - 1.0).abs() < 1e-2);
    }

    #[test]
    fn a_ball_that_dropped_out_at_a_standstill_is_flung_out_at_speed() {
        let bearing = spindle();
        let c = &bearing.constants;
        let (coarse, fine) = curvature_centre(c, &[0.0; 5], &bearing.azimuths[0]);
        let mut ball = Ball::<f64>::default();
        <Full>::rebase(c, &mut ball, coarse, fine);
        let a = [-0.2, 0.0];
        for speed_load in [0.0, 1e-6] {
            let drive = Drive {
                speed_load,
                negligible: 1e-12,
            };
            for _ in 0..6 {
                <Full>::linearise::<f64, 5>(c, &drive, &mut ball, a, 0.0, false);
                <Full>::settle(&mut ball);
            }
            let pass = <Full>::observe(c, speed_load, &ball, a);
            assert_eq!(pass.inner.q, 0.0);
            let missed = (pass.outer.q - pass.loads.centrifugal).abs();
            assert!(missed <= 1e-9 * speed_load, "{pass:?}");
            assert_eq!(pass.loads.centrifugal > 0.0, speed_load > 0.0);
        }
    }

    #[test]
    fn a_ball_that_its_own_steps_have_lost_comes_back_to_the_ring() {
        let bearing = spindle();
        let c = &bearing.constants;
        let (coarse, fine) = curvature_centre(c, &[0.0; 5], &bearing.azimuths[0]);
        let drive = Drive {
            speed_load: 1e-3,
            negligible: 1e-12,
        };
        let a = [0.01, 0.0];
        let mut placed = Ball::<f64>::default();
        <Full>::rebase(c, &mut placed, coarse, fine);
        <Full>::place(c, drive.speed_load, &mut placed, add(add(coarse, fine), a));
        let mut lost = placed;
        lost.x = add(lost.x, [0.4, -0.3]);
        (lost.inner_lead.q, lost.outer_lead.q) = (1e20, 1e20);
        let settled = |mut ball: Ball<f64>, anew| {
            <Full>::settled::<f64, 5>(c, &drive, &mut ball, a, (1e-9, 12), false, anew)
        };
        let (_, imbalance, _) = settled(lost, None);
        assert!(imbalance >= 1.0, "it is not lost: {imbalance:e}");
        let (share, _, repeats) = settled(lost, Some(12));
        let (expected, _, own) = settled(placed, None);
        assert_eq!((share, repeats), (expected, 12 + own));
        assert!(expected.force[0] > 0.0);
    }

    /// A ball in its own equilibrium with the inner groove's centre at `centre`, its law worked out; the ring's offset
    /// there; and the force on the ring.
    fn at_equilibrium(
        c: &Constants<f64>,
        at: &Azimuth<f64>,
        drive: &Drive<f64>,
        centre: Pair<f64>,
    ) -> (Ball<f64>, Pair<f64>, Pair<f64>) {
        let (coarse, fine) = curvature_centre(c, &[0.0; 5], at);
        let mut ball = Ball::default();
        <Full>::rebase(c, &mut ball, coarse, fine);
        <Full>::place(c, drive.speed_load, &mut ball, centre);
        let a = sub(centre, add(coarse, fine));
        let (share, imbalance, _) =
            <Full>::settled::<f64, 5>(c, drive, &mut ball, a, (1e-9, 40), true, None);
        assert!(imbalance < 1e-9, "{centre:?}: {imbalance:e}");
        (ball, a, share.force)
    }

    /// Force on the ring that the law of a ball at `from` says of it at `to`, and the force that it is.
    fn by_law_and_by_ball(from: Pair<f64>, to: Pair<f64>) -> (f64, f64) {
        let bearing = spindle();
        let (c, at) = (&bearing.constants, &bearing.azimuths[0]);
        let drive = Drive {
            speed_load: 1e-3,
            negligible: 1e-12,
        };
        let (mut ball, a, force) = at_equilibrium(c, at, &drive, from);
        let da = sub(to, from);
        let (beyond, _) = <Full>::beyond(&mut ball, a, da);
        let (h, _) = <Full>::linearise::<f64, 5>(c, &drive, &mut ball, a, 1.0, false);
        let linear = h.stiffness.map(|row| dot(row, da));
        let (_, _, expected) = at_equilibrium(c, at, &drive, to);
        (length(add(add(force, linear), beyond)), length(expected))
    }

    #[test]
    fn a_ball_far_off_the_line_gives_way_as_its_law_says() {
        // Its contacts are next to 90 degrees apart, and it carries a hundredth of its centrifugal force.
        for step in [0.01, 0.02, 0.03] {
            let (by_law, by_ball) = by_law_and_by_ball([0.38, 0.66], [0.38 + step, 0.66]);
            assert!(
                (by_law / by_ball - 1.0).abs() < 0.25,
                "{step}: {by_law} for {by_ball}"
            );
        }
    }

    #[test]
    fn a_ball_off_the_inner_race_gives_way_once_it_is_touched() {
        for step in [0.02, 0.04, 0.1] {
            let (by_law, by_ball) = by_law_and_by_ball([0.365, 0.66], [0.365 + step, 0.66]);
            assert!(
                by_law > 0.5 * by_ball && by_law < 2.0 * by_ball,
                "{step}: {by_law} for {by_ball}"
            );
        }
    }

    #[test]
    fn a_ball_that_the_ring_draws_in_line_is_squeezed_as_at_rest() {
        let to = scale(1.02, [0.6, 0.8]);
        for from in [[0.36, 0.66], [0.45, 0.66]] {
            let (by_law, by_ball) = by_law_and_by_ball(from, to);
            assert!(
                by_law > 0.5 * by_ball && by_law < 2.0 * by_ball,
                "{from:?}: {by_law} for {by_ball}"
            );
        }
    }

    #[test]
    fn a_ball_off_the_inner_race_is_not_held_at_the_pole_of_its_cage_speed() {
        let bearing = spindle();
        let c = &bearing.constants;
        let (coarse, fine) = curvature_centre(c, &[0.0; 5], &bearing.azimuths[0]);
        // The inner groove's centre is between the outer one's and the ball that is flung out.
        let [axial, radial] = add(coarse, fine);
        let a = [1e-3 - axial, 0.4 - radial];
        let imbalance = |negligible: f64| {
            let drive = Drive {
                speed_load: 1e-6,
                negligible,
            };
            let mut ball = Ball::<f64>::default();
            <Full>::rebase(c, &mut ball, coarse, fine);
            <Full>::place(c, drive.speed_load, &mut ball, add(add(coarse, fine), a));
            <Full>::settled::<f64, 5>(c, &drive, &mut ball, a, (0.01, 8), false, None).1
        };
        assert!(imbalance(1e-12) >= 1.0);
        // Unless its force makes no difference.
        assert!(imbalance(1.0) < 0.01);
    }

    #[test]
    fn the_hardening_is_three_times_the_growth_of_an_inner_contacts_slope() {
        let bearing = spindle();
        let c = &bearing.constants;
        let (coarse, fine) = curvature_centre(c, &[0.0; 5], &bearing.azimuths[0]);
        let a = [0.01, 0.0];
        let mut ball = Ball::<f64>::default();
        <Full>::rebase(c, &mut ball, coarse, fine);
        let centre = add(add(coarse, fine), a);
        <Full>::place(c, 0.0, &mut ball, centre);
        <Full>::rebase(c, &mut ball, coarse, fine);
        for _ in 0..4 {
            <Full>::linearise::<f64, 5>(c, &AT_REST, &mut ball, a, 0.0, false);
            <Full>::settle(&mut ball);
        }
        <Full>::linearise::<f64, 5>(c, &AT_REST, &mut ball, a, 1.0, false);
        let pass = <Full>::observe(c, 0.0, &ball, a);
        let slope = |delta: f64| 1.5 * c.ki * delta.sqrt();
        let (delta, step) = (pass.inner.delta, 1e-4 * pass.inner.delta);
        let growth = (slope(delta + step) - slope(delta - step)) / (2.0 * step);
        let of_ball = <Full>::stiffening(c, &ball, [0.0; 2]).hardening;
        assert!((of_ball / (3.0 * growth) - 1.0).abs() < 1e-6, "{of_ball}");
    }
}
