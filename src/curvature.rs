//! Second-order terms of a ball's contacts: what its linearisation leaves out along a motion.
//!
//! A contact's end moves by `v`, along and across it. Beyond the tangent, the force is
//! `p = (Q' v1 (v1/delta)/4 + g v2^2, 2 g v1 v2)` with `g = (Q' - Q/R) / (2 R)`. The tangent changes by
//! `[[Q' v1/(2 delta), 2 g v2], [2 g v2, 2 g v1]]`.

use super::ball::Ball;
use super::constants::Azimuth;
use super::linalg::{Pair, add, dot, scale, sub, times, turn};
use super::motion::{Body, Share};
use super::ring::{Row, Sum, shift};
use crate::float::Real;

/// What the second-order terms of one contact are made of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Curvature<T> {
    /// `Q'`, `Q/R`, `1/delta` and `1/R`.
    pub slope: T,
    pub across: T,
    pub per_delta: T,
    pub per_r: T,
}

impl<T: Real> Curvature<T> {
    #[inline(always)]
    fn g(&self) -> T {
        T::of(0.5) * (self.slope - self.across) * self.per_r
    }

    /// Force beyond the tangent. The relative change of the deformation is bounded: beyond, the series of the 3/2 law
    /// is worse than its tangent.
    #[inline(always)]
    pub fn force(&self, v: Pair<T>) -> Pair<T> {
        let half = T::of(0.5);
        let mut relative = v[0] * self.per_delta;
        if relative.abs() > half {
            relative = if relative > half { half } else { -half };
        }
        let gv = self.g() * v[1];
        [
            T::of(0.25) * self.slope * v[0] * relative + gv * v[1],
            (gv + gv) * v[0],
        ]
    }

    /// Change of the tangent. The stiffness grows with the root of the deformation.
    #[inline(always)]
    pub fn stiffening(&self, v: Pair<T>) -> [T; 3] {
        let relative = v[0] * self.per_delta;
        let g = self.g();
        let g2 = g + g;
        let growth = if relative.abs() < T::of(0.1) {
            relative * (T::of(0.5) - relative * (T::of(0.125) - T::of(0.0625) * relative))
        } else {
            (T::ONE + relative).at_least(T::ZERO).sqrt() - T::ONE
        };
        [self.slope * growth, g2 * v[1], g2 * v[0]]
    }
}

impl<T: Real> Ball<T> {
    #[inline(always)]
    fn curvatures(&self) -> (Curvature<T>, Curvature<T>) {
        let l = &self.local;
        (
            Curvature {
                slope: l.hn,
                across: l.kap,
                per_delta: l.per_di,
                per_r: l.per_ri,
            },
            Curvature {
                slope: l.ho,
                across: l.kap_o,
                per_delta: l.per_do,
                per_r: l.per_ro,
            },
        )
    }

    /// From the directions of the inner contact to those of the outer one.
    #[inline(always)]
    fn outer_of(&self, v: Pair<T>) -> Pair<T> {
        let l = &self.local;
        [v[0] * l.cd - v[1] * l.sd, v[0] * l.sd + v[1] * l.cd]
    }

    /// Motions of the inner contact and of the ball, along and across the inner contact.
    ///
    /// The groove's centre moves to `a`, and `omega^2` changes by `ds`.
    #[inline(always)]
    fn motions(&self, a: Pair<T>, ds: T) -> (Pair<T>, Pair<T>) {
        let da = sub(a, self.a);
        let dx = add(add(self.z, times(&self.d, da)), scale(ds, self.xs));
        (sub(turn(self.n, da), dx), dx)
    }

    /// Adds the second order of the ball's motion to `a` to its step; returns what that adds to the force on the ring.
    #[inline(always)]
    pub fn bend(&mut self, a: Pair<T>, ds: T) -> Pair<T> {
        let l = &self.local;
        let (v, dx) = self.motions(a, ds);
        let (inner, outer) = self.curvatures();
        let p = inner.force(v);
        let [on, ot] = outer.force(self.outer_of(dx));
        let beyond = [p[0] - on * l.cd - ot * l.sd, p[1] + on * l.sd - ot * l.cd];
        let x2 = times(&l.j, beyond);
        let force = [p[0] - l.hn * x2[0] + l.th * x2[1], p[1] - l.kap * x2[1]];
        self.z = add(self.z, x2);
        turn(self.n, force)
    }

    /// Change of the condensed stiffness along the motion to `a`: elements `aa`, `ar`, `rr`. Of the friction forces, only
    /// the contacts' part is in it.
    #[inline(always)]
    pub fn stiffening(&self, a: Pair<T>) -> [T; 3] {
        let (v, dx) = self.motions(a, T::ZERO);
        let (inner, outer) = self.curvatures();
        let ([s, c], d) = (self.n, &self.d);
        // How the inner contact and the ball move with the groove's centre, axially and radially.
        let (xa, xr) = ([d[0][0], d[1][0]], [d[0][1], d[1][1]]);
        let (va, vr) = (sub([s, c], xa), sub([c, -s], xr));
        let i = forms(inner.stiffening(v), va, vr);
        let o = forms(
            outer.stiffening(self.outer_of(dx)),
            self.outer_of(xa),
            self.outer_of(xr),
        );
        [i[0] + o[0], i[1] + o[1], i[2] + o[2]]
    }
}

/// The symmetric matrix `m` of elements along, mixed and across, as a form of two vectors: `a.m a`, `a.m b`, `b.m b`.
#[inline(always)]
pub fn forms<T: Real>(m: [T; 3], a: Pair<T>, b: Pair<T>) -> [T; 3] {
    let (ma, mb) = (
        [m[0] * a[0] + m[1] * a[1], m[1] * a[0] + m[2] * a[1]],
        [m[0] * b[0] + m[1] * b[1], m[1] * b[0] + m[2] * b[1]],
    );
    [dot(ma, a), dot(ma, b), dot(mb, b)]
}

impl<T: Real, B: Body<T>> Row<'_, T, B> {
    /// Adds the second order of the ring's motion to `v` and of `ds` to the balls' steps; returns the force it adds.
    #[inline(never)]
    pub fn bend<const D: usize>(&mut self, v: &[T; D], ds: T) -> [T; D] {
        let mut force = [T::ZERO; D];
        let mut azimuths = self.azimuths.iter();
        for ball in self.balls.iter_mut() {
            let Some(at) = azimuths.next() else { break };
            let [axial, radial] = ball.bend(shift(v, at), ds);
            force[0] += axial;
            if D >= 3 {
                force[1] += radial * at.cos;
                force[2] += radial * at.sin;
            }
            if D == 5 {
                force[3] += axial * at.sin;
                force[4] -= axial * at.cos;
            }
        }
        force
    }
}

/// Adds the change of the stiffness along the ring's motion to `v`.
#[inline(never)]
pub fn stiffen<T: Real, B: Body<T>, const D: usize>(
    balls: &[B],
    azimuths: &[Azimuth<T>],
    v: &[T; D],
    sum: &mut Sum<T, D>,
) {
    let mut azimuths = azimuths.iter();
    for ball in balls {
        let Some(at) = azimuths.next() else { break };
        let [aa, ar, rr] = ball.stiffening(shift(v, at));
        let share = Share {
            h: [[aa, ar], [ar, rr]],
            hm: [aa, ar],
            ..Share::NONE
        };
        sum.add_slopes(&share, &Share::NONE, at);
    }
    sum.finish();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::Bearing;
    use crate::kinematics::RacewayControlFree;
    use crate::motion::{Point, Regime};
    use crate::mounting::Growth;
    use crate::place::place;
    use crate::{Design, FreeContact, Material};

    const SPINDLE: Bearing<f64, 16> = Bearing::<f64, 16>::checked(&Design {
        ball_diameter: 6.35e-3,
        pitch_diameter: 36e-3,
        inner_groove_factor: 0.515,
        outer_groove_factor: 0.525,
        free_contact: FreeContact::Angle(0.2618),
        first_ball: 0.0,
        inner_shoulder_angle: Design::HIGHEST_SHOULDER,
        outer_shoulder_angle: Design::HIGHEST_SHOULDER,
        ring: Material::STEEL,
        ball: Material::STEEL,
    });

    /// A ball in equilibrium at 5,000 rpm, the ring pressed by one unit.
    fn settled() -> (Ball<f64>, Point<f64>) {
        let c = &SPINDLE.constants;
        let p = Point::new(c, c.inertia * 523.6 * 523.6, 0.0, &Growth::NONE);
        assert_eq!(p.regime, Regime::Speed);
        let mut ball = Ball::default();
        ball.outer.vector = [c.lo * c.n0[0], c.lo * c.n0[1]];
        ball.move_references(c, &p, [c.centre[0] + 1.0, c.centre[1]], c.centre_low);
        place::<f64, RacewayControlFree>(&mut ball, c, &p);
        at(&mut ball, &p, [0.0; 2]);
        (ball, p)
    }

    /// Has the ball find its equilibrium for the groove's centre at `a`.
    fn at(ball: &mut Ball<f64>, p: &Point<f64>, a: Pair<f64>) {
        for _ in 0..10 {
            ball.advance(a, 0.0);
            ball.linearise::<RacewayControlFree>(&SPINDLE.constants, p);
        }
    }

    #[test]
    fn the_stiffening_is_the_change_of_the_stiffness_but_for_what_friction_changes() {
        let (ball, p) = settled();
        for a in [[1e-4, 0.0], [0.0, 1e-4], [1e-4, -1e-4]] {
            let [aa, ar, rr] = ball.stiffening(a);
            let mut moved = ball;
            at(&mut moved, &p, a);
            let (h, before) = (moved.share.h, ball.share.h);
            for (i, j, foreseen) in [(0, 0, aa), (0, 1, ar), (1, 0, ar), (1, 1, rr)] {
                let change = h[i][j] - before[i][j];
                let off = (foreseen - change).abs();
                assert!(off < 0.01 * change.abs(), "{a:?}: {foreseen:e}, {change:e}");
            }
        }
    }

    #[test]
    fn the_second_order_foresees_force_and_place_to_a_tenth_of_what_the_first_misses() {
        let (ball, p) = settled();
        for a in [[4e-3, 0.0], [0.0, 4e-3], [-3e-3, 2e-3]] {
            let mut moved = ball;
            at(&mut moved, &p, a);
            let (h, f) = (ball.share.h, ball.share.force);
            let first = add(f, times(&h, a));
            let mut bent = ball;
            let second = add(first, bent.bend(a, 0.0));
            let mut straight = ball;
            straight.advance(a, 0.0);
            bent.advance(a, 0.0);
            let size = |v: Pair<f64>| dot(v, v).sqrt();
            let force = moved.share.force;
            assert!(
                size(sub(second, force)) < 0.1 * size(sub(first, force)),
                "{a:?}"
            );
            assert!(
                size(sub(bent.x, moved.x)) < 0.1 * size(sub(straight.x, moved.x)),
                "{a:?}"
            );
        }
    }
}
