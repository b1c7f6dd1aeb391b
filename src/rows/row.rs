//! A row: how it sits on the shaft, and the forces and slopes of its balls, summed over the azimuth.
//!
//! Order of freedoms: axial, radial y, radial z, tilt about y, tilt about z, radial displacements and moments referred to
//! the groove plane. A solver has the first `D` of them: 1, 3 or 5.

use crate::ball::Ball;
use crate::ball::condensed::Condensed;
use crate::ball::contact::Point;
use crate::ball::kinematics::Rule;
use crate::ball::settle::{ALONE, settle};
use crate::bearing::{Azimuth, Constants};
use crate::linalg::{Matrix, Pair, add, moved, refer, refer_stiffness};
use crate::real::Real;
use crate::tuning;

/// Force of the balls on the ring, its slopes by the ring's displacement and by the relative change of `omega^2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sum<T, const D: usize> {
    pub force: [T; D],
    pub by_speed: [T; D],
    pub k: Matrix<T, D>,
}

impl<T: Real, const D: usize> Sum<T, D> {
    pub const NONE: Self = Self {
        force: [T::ZERO; D],
        by_speed: [T::ZERO; D],
        k: [[T::ZERO; D]; D],
    };

    /// Refers it to a point that is nearer to the origin by `distance`.
    #[inline(always)]
    pub fn refer(&mut self, distance: T) {
        refer(distance, &mut self.force);
        refer(distance, &mut self.by_speed);
        refer_stiffness(distance, &mut self.k);
    }
}

/// Shift of the inner groove's centre at an azimuth due to a displacement of the ring.
#[inline(always)]
pub fn shift<T: Real>(u: &[T; 5], at: &Azimuth<T>) -> Pair<T> {
    let radial = u[1] * at.cos + u[2] * at.sin;
    [u[0] + (u[3] * at.sin - u[4] * at.cos), radial]
}

/// Offset of the inner groove's centre at an azimuth from the row's reference, the ring's offset being `v`.
#[inline(always)]
pub fn groove<T: Real>(p: &Point<T>, v: &[T; 5], at: &Azimuth<T>) -> Pair<T> {
    add(p.low, shift(v, at))
}

impl<T: Real, const D: usize> Sum<T, D> {
    /// Adds the forces of two balls that are opposite to each other, the first at the azimuth `at`; or of one ball and
    /// none; what they change with the speed, if `at_speed`. What two opposite balls have in common cancels exactly in radial
    /// forces and moments.
    #[inline(always)]
    fn add_forces(&mut self, a: &Condensed<T>, b: &Condensed<T>, at: &Azimuth<T>, at_speed: bool) {
        let (c, s) = (at.cos, at.sin);
        let (f, by) = (&mut self.force, &mut self.by_speed);
        let axial = a.force[0] + b.force[0];
        let radial = a.force[1] - b.force[1];
        let (y, z) = (radial * c, radial * s);
        f[0] += axial;
        if D >= 3 {
            f[1] += y;
            f[2] += z;
        }
        if at_speed {
            let axial = a.force_by_speed[0] + b.force_by_speed[0];
            let radial = a.force_by_speed[1] - b.force_by_speed[1];
            let (y, z) = (radial * c, radial * s);
            by[0] += axial;
            if D >= 3 {
                by[1] += y;
                by[2] += z;
            }
        }
        if D == 5 {
            let moment = a.moment - b.moment;
            let by_speed = a.moment_by_speed - b.moment_by_speed;
            let (y, z) = (moment * s, moment * c);
            f[3] += y;
            f[4] -= z;
            if at_speed {
                let (y, z) = (by_speed * s, by_speed * c);
                by[3] += y;
                by[4] -= z;
            }
        }
    }

    /// Adds the slopes of two opposite balls' forces.
    #[inline(always)]
    pub fn add_slopes(&mut self, a: &Condensed<T>, b: &Condensed<T>, at: &Azimuth<T>) {
        let (c, s) = (at.cos, at.sin);
        let (cc, cs, ss) = (c * c, c * s, s * s);
        let k = &mut self.k;
        let ([aa, ar], [bb, br]) = (a.h[0], b.h[0]);
        k[0][0] += aa + bb;
        if D >= 3 {
            let ar = ar - br;
            let (y, z) = (ar * c, ar * s);
            k[0][1] += y;
            k[0][2] += z;
        }
        if D == 5 {
            let aa = aa - bb;
            let (y, z) = (aa * s, aa * c);
            k[0][3] += y;
            k[0][4] -= z;
        }
        if D >= 3 {
            let ([aa, ar], [bb, br]) = (a.h[1], b.h[1]);
            let (ra, rr) = (aa - bb, ar + br);
            let (y, z) = (ra * c, ra * s);
            k[1][0] += y;
            k[2][0] += z;
            let (yy, yz, zz) = (rr * cc, rr * cs, rr * ss);
            k[1][1] += yy;
            k[1][2] += yz;
            k[2][2] += zz;
            if D == 5 {
                let ra = aa + bb;
                let (yy, yz, zz) = (ra * cs, ra * cc, ra * ss);
                k[1][3] += yy;
                k[1][4] -= yz;
                k[2][3] += zz;
            }
        }
        if D == 5 {
            let ([aa, ar], [bb, br]) = (a.hm, b.hm);
            let (ma, mr) = (aa - bb, ar + br);
            let (y, z) = (ma * s, ma * c);
            k[3][0] += y;
            k[4][0] -= z;
            let (yy, yz, zz) = (mr * cs, mr * ss, mr * cc);
            k[3][1] += yy;
            k[3][2] += yz;
            k[4][1] -= zz;
            let ma = aa + bb;
            let (yy, yz, zz) = (ma * ss, ma * cs, ma * cc);
            k[3][3] += yy;
            k[3][4] -= yz;
            k[4][4] += zz;
        }
    }

    /// Fills in the elements that follow from others.
    #[inline(always)]
    pub fn finish(&mut self) {
        let k = &mut self.k;
        if D >= 3 {
            k[2][1] = k[1][2];
        }
        if D == 5 {
            k[2][4] = -k[1][3];
            k[4][2] = -k[3][1];
            k[4][3] = k[3][4];
        }
    }
}

/// How a row sits on the shaft.
///
/// Shaft and row have frames and units of their own; the shaft has the units of its first row. A row that faces
/// against the axis is mirrored. Its motion is `r P v` with the shaft's motion `v` of the groove plane, the force on the shaft
/// `phi P^T F`:
///
/// `P v = (s vx + e, vy + l vtz, vz - l vty, s m vty, s m vtz)`
///
/// with the motion `e` of the row's sleeve towards its balls, if that slides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount<T> {
    /// `s`: 1, or -1 for a row that faces against the axis.
    pub facing: T,
    /// `r` and `phi`: the shaft's unit of length over the row's, the row's unit of force over the shaft's.
    pub length: T,
    pub force: T,
    /// `l`: the row's groove plane beyond the shaft's, over the shaft's `Rp`.
    pub lever: T,
    /// The row's groove plane beyond the shaft's centre, on an elastic shaft beyond the row's own, in the row's own direction and
    /// over its own `Rp`.
    pub reach: T,
    /// `m`: `Rp` of the row over the shaft's.
    pub arm: T,
    /// Inertia `m dm omega^2 / 2` of a ball over a ball's in the first row, each in its row's unit of force.
    pub inertia: T,
    /// Closure, in the row's unit of length.
    pub closure: T,
    /// The row's sleeve slides under a spring.
    pub sliding: bool,
}

impl<T: Real> Mount<T> {
    /// Of a bearing alone.
    pub const PLAIN: Self = Self {
        facing: T::ONE,
        length: T::ONE,
        force: T::ONE,
        lever: T::ZERO,
        reach: T::ZERO,
        arm: T::ONE,
        inertia: T::ONE,
        closure: T::ZERO,
        sliding: false,
    };

    /// The row's motion when the shaft makes the motion `v`.
    #[inline(always)]
    pub fn motion<const D: usize, const SET: bool>(&self, v: &[T; D]) -> [T; 5] {
        if SET { self.turned(v) } else { in_full(v) }
    }

    #[inline(never)]
    fn turned<const D: usize>(&self, v: &[T; D]) -> [T; 5] {
        let mut own = in_full(v);
        if D == 6 && self.sliding {
            own[0] += self.facing * v[5];
        }
        if D >= 5 {
            own[1] += self.lever * own[4];
            own[2] -= self.lever * own[3];
        }
        self.own(own)
    }

    /// A motion of the row's groove plane in its own direction and units.
    #[inline(always)]
    fn own(&self, mut u: [T; 5]) -> [T; 5] {
        let r = self.length;
        u[0] = r * (self.facing * u[0]);
        u[1] = r * u[1];
        u[2] = r * u[2];
        let turn = r * (self.facing * self.arm);
        u[3] = turn * u[3];
        u[4] = turn * u[4];
        u
    }

    /// The row's motion when its centre makes the motion `u` on an elastic shaft.
    #[inline(never)]
    pub fn of_centre(&self, u: &[T; 5]) -> [T; 5] {
        self.own(moved(self.facing * self.arm * self.reach, u))
    }

    /// Adds the motion of its centre on a deflected shaft to the row's. By a call, which spares 1 kB of unrolled loops.
    #[inline(never)]
    pub fn deflect(&self, own: &mut [T; 5], centre: &[T; 5]) {
        for (own, u) in own.iter_mut().zip(self.of_centre(centre)) {
            *own += u;
        }
    }

    /// Adds the row's forces and slopes, at its groove plane, to the shaft's about its centre.
    #[inline(never)]
    pub fn assemble<const D: usize>(&self, own: &mut Sum<T, 5>, sum: &mut Sum<T, D>) {
        let turn = self.facing * self.arm;
        let mirror = [self.facing, T::ONE, T::ONE, turn, turn];
        let slides = D == 6 && self.sliding;
        own.refer(self.reach);
        let forces = [
            (&own.force, &mut sum.force),
            (&own.by_speed, &mut sum.by_speed),
        ];
        for (own, sum) in forces {
            for i in 0..5 {
                sum[i] += self.force * (mirror[i] * own[i]);
            }
            if slides {
                sum[5] += self.force * own[0];
            }
        }
        let (own, k) = (&own.k, &mut sum.k);
        let unit = self.force * self.length;
        for i in 0..5 {
            for j in 0..5 {
                k[i][j] += unit * (mirror[i] * mirror[j] * own[i][j]);
            }
        }
        if slides {
            for i in 0..5 {
                k[i][5] += unit * (mirror[i] * own[i][0]);
                k[5][i] += unit * (mirror[i] * own[0][i]);
            }
            k[5][5] += unit * own[0][0];
        }
    }
}

/// A displacement with all five freedoms; the others are 0.
#[inline(always)]
pub fn in_full<T: Real, const D: usize>(v: &[T; D]) -> [T; 5] {
    let mut full = [T::ZERO; 5];
    for (full, v) in full.iter_mut().zip(v) {
        *full = *v;
    }
    full
}

/// Cosine of the largest angle between a ball's contacts, 150 degrees: the cage speed has its pole at 180.
pub const UNSEATED: f64 = -0.866;

/// One row of balls: a bearing at a point of speed and growth.
pub struct Row<'s, T> {
    pub c: &'s Constants<T>,
    pub mount: &'s Mount<T>,
    pub p: &'s mut Point<T>,
    pub azimuths: &'s [Azimuth<T>],
    pub balls: &'s mut [Ball<T>],
}

impl<T: Real> Row<'_, T> {
    /// Has every ball follow the ring to `v` and a relative change `ds` of `omega^2`, and condenses it there; whether all
    /// are near their balance.
    // By a call: in the shaft's loop, a warm tick of a pair takes 1.1 % more cycles.
    #[inline(never)]
    pub fn follow<R: Rule>(&mut self, v: &[T; 5], ds: T) -> bool {
        let mut near = true;
        let mut left = tuning::SETTLING * self.balls.len() as u16 / 2;
        let mut azimuths = self.azimuths.iter();
        for ball in self.balls.iter_mut() {
            let Some(at) = azimuths.next() else { break };
            let a = groove(self.p, v, at);
            near &= ball.condense::<R>(self.c, self.p, a, ds, &mut left);
        }
        near
    }

    /// Has every ball start as the first one does, near its balance at the ring's offset `v`.
    #[inline(never)]
    pub fn start<R: Rule>(&mut self, v: &[T; 5]) {
        let Some(first) = self.azimuths.first() else {
            return;
        };
        let (mut x, a) = ([T::ZERO; 2], groove(self.p, v, first));
        if R::INERTIA && self.p.is_at_speed() {
            let mut left = ALONE;
            x = settle::<T, R>(self.c, self.p, a, x, &mut left);
            x = self.p.move_outer(self.c, x);
        }
        for ball in self.balls.iter_mut() {
            ball.start(x, a);
        }
    }

    /// Number of balls that carry.
    #[inline(never)]
    pub fn loaded(&self) -> u16 {
        let loaded = self.balls.iter().filter(|ball| ball.carries(self.p));
        loaded.count() as u16
    }

    /// The ball whose contacts are furthest apart, if the cosine of that angle is below `limit`, and the angle, rad. Balls
    /// without force count only where they are [`UNSEATED`].
    #[cold]
    #[inline(never)]
    pub fn furthest<R: Rule>(&self, limit: T) -> Option<(u16, T)> {
        if !R::INERTIA {
            return None;
        }
        let (mut furthest, mut least) = (None, limit);
        for (ball, number) in self.balls.iter().zip(0..) {
            let [sin, cos] = ball.apart();
            if (ball.carries(self.p) || cos < T::of(UNSEATED)) && cos < least {
                least = cos;
                furthest = Some((number, sin));
            }
        }
        furthest.map(|(number, sin)| (number, sin.abs().atan2(least)))
    }

    /// Changes of the stiffness's diagonal if the ring makes the step `du`, and the balls follow.
    ///
    /// Every ball's part changes with the relative change of its deformations, and with the turn of its normals.
    #[inline(never)]
    pub fn changes<R: Rule>(&self, du: &[T; 5]) -> ([T; 5], Estimate<T>) {
        let (mut sums, mut all) = ([T::ZERO; 5], Estimate::<T>::NONE);
        let mut azimuths = self.azimuths.iter();
        for ball in self.balls.iter() {
            let Some(at) = azimuths.next() else { break };
            let change = ball.change::<R>(self.c, self.p, shift(du, at));
            let turn = change.turn + change.turn;
            let (cc, ss) = (at.cos * at.cos, at.sin * at.sin);
            all.relative = all.relative.at_least(change.relative);
            all.cos = all.cos.at_most(change.cos);
            let [axial, radial] = ball.condensed.force;
            let force = axial.abs() + radial.abs();
            all.largest = all.largest.at_least(force);
            let second_order = change.relative * change.relative * force;
            all.force = all.force.at_least(second_order + change.off);
            let mixed = turn * change.h[1];
            let (axial, radial) = (change.depth * change.h[0], change.depth * change.h[2]);
            let (axial, radial) = (axial + mixed, radial + mixed);
            let (yy, zz) = (radial * cc, radial * ss);
            sums[1] += yy;
            sums[2] += zz;
            let (yy, zz) = (axial * ss, axial * cc);
            sums[3] += yy;
            sums[4] += zz;
        }
        sums[0] = sums[3] + sums[4];
        (sums, all)
    }

    /// Largest force of second order on a ball if the ring makes the step `du`: see [`Ball::second_order`].
    #[cold]
    pub fn second_order<R: Rule>(&self, du: &[T; 5]) -> T {
        let (mut largest, mut azimuths) = (T::ZERO, self.azimuths.iter());
        for ball in self.balls.iter() {
            let Some(at) = azimuths.next() else { break };
            largest = largest.at_least(ball.second_order::<R>(self.p, shift(du, at)));
        }
        largest
    }
}

/// Estimated errors after a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate<T> {
    /// Change of the stiffness along the step, relative to its diagonal.
    pub k: T,
    /// Largest relative change of a ball's stiffness.
    pub relative: T,
    /// Error of the balls' forces, of second order, relative to the largest.
    pub force: T,
    /// The largest force of a ball on the ring.
    pub largest: T,
    /// Least cosine of the angle between the contacts of a ball.
    pub cos: T,
}

impl<T: Real> Estimate<T> {
    /// Of no ball.
    pub const NONE: Self = Self {
        k: T::ZERO,
        relative: T::ZERO,
        force: T::ZERO,
        largest: T::TINY,
        cos: T::ONE,
    };

    /// Error of the stiffness that its correction along the step leaves: what is of second order, and a small part of the first.
    pub fn corrected(&self) -> T {
        self.k * (self.relative + T::of(tuning::CORRECTED))
    }
}

/// Change of the stiffness along the ring's motion to `v`, referred to the groove plane. Opposite balls together where
/// there are any.
#[inline(never)]
pub fn stiffness_change<T: Real, R: Rule, const D: usize>(
    p: &Point<T>,
    balls: &[Ball<T>],
    azimuths: &[Azimuth<T>],
    v: &[T; 5],
) -> Sum<T, D> {
    let mut sum = Sum::NONE;
    let change = |(ball, at): (&Ball<T>, &Azimuth<T>)| {
        let [aa, ar, rr] = ball.stiffness_change::<R>(groove(p, v, at));
        Condensed {
            h: [[aa, ar], [ar, rr]],
            hm: [aa, ar],
            ..Condensed::NONE
        }
    };
    let n = balls.len();
    let alone = if n.is_multiple_of(2) { n / 2 } else { n };
    let (first, second) = balls.split_at(alone);
    let mut second = second.iter().zip(azimuths.iter().skip(alone));
    for (ball, at) in first.iter().zip(azimuths) {
        let opposite = second.next().map_or(Condensed::NONE, change);
        sum.add_slopes(&change((ball, at)), &opposite, at);
    }
    sum.finish();
    sum
}

/// Condensed balls with the azimuth: opposite balls together where there are any, else every ball and `none`.
#[inline(always)]
fn opposite_pairs<'a, T: Real>(
    balls: &'a [Ball<T>],
    azimuths: &'a [Azimuth<T>],
    none: &'a Condensed<T>,
) -> impl Iterator<Item = (&'a Condensed<T>, &'a Condensed<T>, &'a Azimuth<T>)> {
    let n = balls.len();
    let alone = if n.is_multiple_of(2) { n / 2 } else { n };
    let (first, second) = balls.split_at(alone);
    let (mut first, mut second) = (first.iter(), second.iter());
    let mut azimuths = azimuths.iter();
    // Not `zip`, which the compiler unrolls (+1.2 kB).
    core::iter::from_fn(move || {
        let (ball, at) = (first.next()?, azimuths.next()?);
        Some((
            &ball.condensed,
            second.next().map_or(none, |ball| &ball.condensed),
            at,
        ))
    })
}

/// Sums what the balls hand to the ring, referred to the groove plane. Forces and slopes in loops of their own, whose sums
/// stay in registers.
#[inline(never)]
pub fn sum_up<T: Real, R: Rule, const D: usize>(
    balls: &[Ball<T>],
    azimuths: &[Azimuth<T>],
    sum: &mut Sum<T, D>,
) {
    let none = Condensed::NONE;
    let mut part = Sum::NONE;
    for (a, b, at) in opposite_pairs(balls, azimuths, &none) {
        part.add_forces(a, b, at, R::INERTIA);
    }
    (sum.force, sum.by_speed) = (part.force, part.by_speed);
    for (a, b, at) in opposite_pairs(balls, azimuths, &none) {
        part.add_slopes(a, b, at);
    }
    part.finish();
    sum.k = part.k;
}
