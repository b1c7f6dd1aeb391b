//! A ball: linearised where it is, and condensed into a force and a stiffness for the ring.
//!
//! `V = A - X` and `X` are the vectors along the inner and the outer contact, `n` and `t` the contacts' normals and
//! tangents. The ball's residual is
//!
//! `r = Qi ni + Ti ti - Qo no - To to + Fc er`.
//!
//! The pass works along the normal and tangent of the inner contact, where half of the derivatives are single numbers.
//! `B = dr/dV` and `M = -dr/dX` (at fixed `A`) give the Newton step `z = M^-1 r` and its slope by the groove's centre
//! `D = M^-1 B`. The ring sees the force `f = Qi ni + Ti ti` after that step, and the slope `H = df/dA` along it.
//!
//! At rest the grooves' centres and the ball's are collinear, and both contacts in series are one between the grooves'
//! centres: `Q = Kn (|A| - L0)^(3/2)`.
//!
//! Positions are a reference, whose deformations are known to twice the working precision, plus a small offset:
//! `|X|^2 - lo^2 = e + (2 Xr + x).x`, so that a deformation keeps the digits that a difference of lengths would lose.

pub mod at_rest;
pub mod condensed;
pub mod contact;
pub mod kinematics;
pub mod report;
pub mod settle;

use crate::ball::condensed::{Change, Condensed, condensed_of, grazing};
use crate::ball::contact::{Contact, Curvature, Point, forms};
use crate::ball::kinematics::{Contacts, Rule};
use crate::ball::report::Kinetics;
use crate::ball::settle::settle;
use crate::bearing::Constants;
use crate::linalg::{
    Matrix2, Pair, add, dot, dots, product2, scale, sub, times, times_transposed, turn,
};
use crate::real::Real;
use crate::tuning;

/// Steps of settling that cost as much as a Newton step of the ball.
const OWN: u16 = 2;

/// A ball where it was linearised last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball<T> {
    /// Offset from the row's reference along the outer contact, and offset of the groove's centre.
    pub x: Pair<T>,
    pub a: Pair<T>,
    /// Normal of the inner contact there.
    pub n: Pair<T>,
    /// Newton step along normal and tangent, its slope by the groove's axial and radial position, and its slope by the
    /// relative change of `omega^2`.
    pub z: Pair<T>,
    pub d: Matrix2<T>,
    pub xs: Pair<T>,
    pub local: Local<T>,
    /// Force and slopes that it hands to the ring.
    pub condensed: Condensed<T>,
}

/// The contacts where the ball was linearised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Local<T> {
    /// Deformation of the inner contact, negative across a gap; of both in series, at rest.
    pub delta: T,
    /// One over deformations and over the lengths.
    pub per_di: T,
    pub per_do: T,
    pub per_ri: T,
    pub per_ro: T,
    /// Sine and cosine of the angle between the contacts.
    pub sd: T,
    pub cd: T,
    /// Slopes `dQ / d delta` of the contact forces, their quotients by the lengths, and `Ti / Ri`.
    pub hn: T,
    pub ho: T,
    pub kap: T,
    pub kap_o: T,
    pub th: T,
}

impl<T: Real> Local<T> {
    /// No contact.
    const NONE: Self = Self {
        delta: T::ZERO,
        per_di: T::ZERO,
        per_do: T::ZERO,
        per_ri: T::ZERO,
        per_ro: T::ZERO,
        sd: T::ZERO,
        cd: T::ZERO,
        hn: T::ZERO,
        ho: T::ZERO,
        kap: T::ZERO,
        kap_o: T::ZERO,
        th: T::ZERO,
    };
}

/// Balance of a linearised ball: squares of the unbalanced force and of the contact forces.
#[derive(Debug, Clone, Copy)]
pub struct Balance<T> {
    residual: T,
    inner: T,
    outer: T,
}

impl<T: Real> Balance<T> {
    /// The unbalanced force is at most this part of the larger contact force.
    #[inline(always)]
    pub fn is_within(&self, part: f64) -> bool {
        let least = T::of(1.0 / (part * part)) * self.residual;
        least <= self.outer || least <= self.inner
    }

    /// The unbalanced force is of at most this square.
    #[inline(always)]
    pub fn is_below(&self, square: T) -> bool {
        self.residual <= square
    }
}

impl<T: Real> Ball<T> {
    /// Before the first solve.
    pub const NONE: Self = Self {
        x: [T::ZERO; 2],
        a: [T::ZERO; 2],
        n: [T::ZERO; 2],
        z: [T::ZERO; 2],
        d: [[T::ZERO; 2]; 2],
        xs: [T::ZERO; 2],
        local: Local::NONE,
        condensed: Condensed::NONE,
    };

    /// Has the ball follow the groove's centre to `a`, and a relative change `ds` of `omega^2`.
    #[inline(always)]
    pub fn advance(&mut self, a: Pair<T>, ds: T) {
        let da = sub(a, self.a);
        let own = add(self.z, scale(ds, self.xs));
        let step = add(own, times(&self.d, da));
        self.x = add(self.x, turn(self.n, step));
        self.a = a;
    }

    /// Starts at the offset `x`, with the groove's centre at `a`.
    // By a call: in a loop over balls, it is unrolled to 1.5 kB.
    #[inline(never)]
    pub fn start(&mut self, x: Pair<T>, a: Pair<T>) {
        (self.x, self.a) = (x, a);
        self.freeze();
    }

    /// Has the ball stay where it is until it is linearised again.
    pub fn freeze(&mut self) {
        self.n = [T::ZERO, T::ONE];
        self.z = [T::ZERO; 2];
        self.d = [[T::ZERO; 2]; 2];
        self.xs = [T::ZERO; 2];
    }

    /// At rest: both contacts in series, the groove's centre at `a`.
    #[inline(always)]
    pub fn in_series(c: &Constants<T>, p: &Point<T>, a: Pair<T>) -> Contact<T> {
        Contact::at(&p.centres, a, p.lo + p.li, c.kn)
    }

    /// Condenses the ball at rest, in closed form.
    #[inline(always)]
    fn condense_at_rest<R: Rule>(&mut self, c: &Constants<T>, p: &Point<T>) {
        let contact = Self::in_series(c, p, self.a);
        self.condensed = condensed_of(&contact);
        if R::INERTIA {
            self.freeze();
        }
        self.n = contact.n;
        // One contact between the ring and the outer race.
        self.local = Local {
            delta: contact.delta,
            per_di: T::ONE / contact.delta.at_least(T::NOTHING),
            per_ri: contact.per_r,
            cd: T::ONE,
            hn: contact.slope,
            kap: contact.across,
            ..Local::NONE
        };
    }

    /// Follows the groove's centre to `a` and a relative change `ds` of `omega^2`, and condenses the ball there; whether it
    /// is near its balance.
    ///
    /// A ball far from its balance takes of the steps that are `left` in this pass, and goes on in the next one.
    #[inline(always)]
    pub fn condense<R: Rule>(
        &mut self,
        c: &Constants<T>,
        p: &Point<T>,
        a: Pair<T>,
        ds: T,
        left: &mut u16,
    ) -> bool {
        if !R::INERTIA {
            self.a = a;
            self.condense_at_rest::<R>(c, p);
            return true;
        }
        self.advance(a, ds);
        if !p.is_at_speed() {
            self.stop::<R>(c, p);
            return true;
        }
        // A Newton step of its own first, which mostly does; then it is settled.
        let mut tries = 0;
        loop {
            let balance = self.linearise::<R>(c, p);
            if balance.is_within(tuning::SETTLE) || balance.is_below(p.negligible) {
                return true;
            }
            if tries == 2 || *left == 0 {
                return false;
            }
            if tries == 0 {
                self.advance(a, T::ZERO);
                *left = left.saturating_sub(OWN);
            } else {
                self.x = settle::<T, R>(c, p, a, self.x, left);
                self.z = [T::ZERO; 2];
            }
            tries += 1;
        }
    }

    /// [`Self::condense_at_rest`], by a call.
    #[inline(never)]
    fn stop<R: Rule>(&mut self, c: &Constants<T>, p: &Point<T>) {
        self.condense_at_rest::<R>(c, p);
    }

    /// The ball when the groove's centre is at `a`.
    // In line: callers keep the result in registers.
    #[inline(always)]
    pub fn kinetics<R: Rule>(&self, c: &Constants<T>, p: &Point<T>, a: Pair<T>) -> Kinetics<T> {
        if R::INERTIA && p.is_at_speed() {
            let step = add(self.z, times(&self.d, sub(a, self.a)));
            let x = add(self.x, turn(self.n, step));
            Kinetics::at_speed::<R>(c, p, a, x)
        } else {
            Kinetics::at_rest(c, &Self::in_series(c, p, a))
        }
    }

    /// It carries a force that makes a difference to the ring.
    // By a call: the loop over the balls is unrolled.
    #[inline(never)]
    pub fn carries(&self, p: &Point<T>) -> bool {
        let force = self.condensed.force;
        dot(force, force) > p.negligible
    }

    /// Sine and cosine of the angle `ai - ao` between the contacts.
    pub fn apart(&self) -> Pair<T> {
        [self.local.sd, self.local.cd]
    }

    /// How the contacts change if the groove's centre moves by `da` and the ball follows.
    #[inline(always)]
    pub fn change<R: Rule>(&self, c: &Constants<T>, p: &Point<T>, da: Pair<T>) -> Change<T> {
        let l = &self.local;
        let turned = turn(self.n, da);
        if !R::INERTIA {
            return self.change_at_rest(c, p, turned);
        }
        let dx = add(self.z, times(&self.d, da));
        let v = sub(turned, dx);
        // Normal and tangent of the outer contact are (cd, -sd) and (sd, cd).
        let [across, along] = turn([l.sd, l.cd], dx);
        if !(l.delta > p.rounding) {
            // It swings on the outer race, and sinks into it.
            let turn = across * l.per_ro;
            let beyond = T::of(0.5) * across * turn;
            let sunk = T::of(0.25) * along * (along * l.per_do);
            let inner = grazing(v[0], l.delta, c.ki, p.rounding);
            let turn = turn.abs();
            return Change {
                turn,
                relative: inner.relative + (turn + turn),
                off: (beyond + sunk) * l.ho + T::of(1.5) * beyond * beyond.sqrt_abs(),
                cos: l.cd,
                ..inner
            };
        }
        let h = &self.condensed.h;
        let (inner, outer) = (v[0] * l.per_di, along * l.per_do);
        let (turn_i, turn_o) = (v[1] * l.per_ri, across * l.per_ro);
        let depth = (inner.abs() + outer.abs()).at_most(T::ONE + T::ONE);
        let (depth, turn) = (T::of(0.5) * depth, turn_i.abs() + turn_o.abs());
        Change {
            depth,
            turn,
            relative: depth + (turn + turn),
            cos: l.cd,
            off: T::ZERO,
            h: [h[0][0].abs(), h[0][1].abs(), h[1][1].abs()],
        }
    }

    /// How the contacts in series change if the groove's centre moves by `v`, along and across them.
    #[inline(always)]
    fn change_at_rest(&self, c: &Constants<T>, p: &Point<T>, v: Pair<T>) -> Change<T> {
        let l = &self.local;
        if !(l.delta > p.rounding) {
            return grazing(v[0], l.delta, c.kn, p.rounding);
        }
        let h = &self.condensed.h;
        let depth = T::of(0.5) * (v[0] * l.per_di).abs().at_most(T::ONE);
        let turn = (v[1] * l.per_ri).abs();
        Change {
            depth,
            turn,
            relative: depth + (turn + turn),
            cos: T::ONE,
            off: T::ZERO,
            h: [h[0][0].abs(), h[0][1].abs(), h[1][1].abs()],
        }
    }

    /// Force of second order if the groove's centre moves by `da` and the ball follows: the contacts sink in by the turn of their
    /// normals, and their forces grow with the power 3/2. None of a ball off the inner race.
    #[inline(always)]
    pub fn second_order<R: Rule>(&self, p: &Point<T>, da: Pair<T>) -> T {
        let l = &self.local;
        if !(l.delta > p.rounding) {
            return T::ZERO;
        }
        let half = T::of(0.5);
        let v = turn(self.n, da);
        if !R::INERTIA {
            let depth = half * v[0] * l.per_di;
            return (half * v[1] * v[1] * l.per_ri + depth * depth * l.delta) * l.hn;
        }
        let dx = add(self.z, times(&self.d, da));
        let v = sub(v, dx);
        let [across, along] = turn([l.sd, l.cd], dx);
        let depth = half * ((v[0] * l.per_di).abs() + (along * l.per_do).abs());
        let (turn_i, turn_o) = (v[1] * l.per_ri, across * l.per_ro);
        let sunk = v[1] * turn_i * l.hn + across * turn_o * l.ho;
        half * sunk + depth * depth * l.hn * l.delta
    }

    /// Linearises the ball where it is, and condenses it.
    ///
    /// The order of the statements counts on a Cortex-M4F, since the compiler keeps it: few values that wait for their
    /// use (no spills), few results that are used at once, results stored where they are final. Another order costs up
    /// to 30 cycles a ball: measure.
    #[inline(always)]
    pub fn linearise<R: Rule>(&mut self, c: &Constants<T>, p: &Point<T>) -> Balance<T> {
        let one = T::ONE;
        // Vectors and squares; one division for both contacts' quotients.
        let y = sub(self.a, self.x);
        let v = add(p.inner.vector, y);
        let xv = add(p.outer.vector, self.x);
        let [ri2, ro2] = dots([v, v], [xv, xv]);
        let (vv, xx) = (add(v, p.inner.vector), add(xv, p.outer.vector));
        let [ei, eo] = dots([vv, y], [xx, self.x]);
        let (ri, ro) = ((ri2 + T::TINY).sqrt_abs(), (ro2 + T::TINY).sqrt_abs());
        let (ei, eo) = (p.inner.excess + ei, p.outer.excess + eo);
        let (si_, so_) = (ri + p.li, ro + p.lo);
        let (ii, oo) = (ri * si_, ro * so_);
        let (ei, eo) = (ri * ei, ro * eo);
        let inverse = one / (ii * oo);
        let (per_i, per_o) = (inverse * oo, inverse * ii);
        let (per_ri, per_ro) = (per_i * si_, per_o * so_);
        let (geometric, do_) = (per_i * ei, per_o * eo);
        let [si, ci] = scale(per_ri, v);
        let [so, co] = scale(per_ro, xv);
        let n = [si, ci];
        let closed = geometric > T::NOTHING;
        let (di, ki) = if closed {
            (geometric, c.ki)
        } else {
            (T::NOTHING, T::ZERO)
        };
        let do_ = do_.at_least(T::LEAST);
        let [cd, sd] = turn([so, co], n);
        let (zi, zo) = (ki * di.sqrt_abs(), do_.sqrt_abs());

        // One division for six quotients.
        let kwi = c.kw * di;
        let apart = (one + cd).at_least(T::of(0.01));
        let (qi, qo) = (zi * di, zo * do_);
        let (wi, wo) = (kwi * di, do_ * do_);
        let forces = qi + qo;
        let work = wi + wo;
        let depths = di * do_;
        let apart_work = apart * work;
        let left = apart_work * forces;
        let inverse = one / (left * depths);
        let (per_left, per_depths) = (inverse * depths, inverse * left);
        let (per_di, per_do) = (per_depths * do_, per_depths * di);
        let (per_forces, shared) = (per_left * apart_work, per_left * forces);
        let (q, per_work) = (shared * work, shared * apart);
        let l = &mut self.local;
        (l.delta, l.per_di, l.per_do) = (geometric, per_di, per_do);
        (l.per_ri, l.per_ro, l.sd, l.cd) = (per_ri, per_ro, sd, cd);
        let g = Contacts {
            inner: n,
            outer: [so, co],
            sin_d: sd,
            q,
            eta: wi * per_work,
            rest: wo * per_work,
            sigma: qi * per_forces,
            sigma_rest: qo * per_forces,
            closed,
        };
        let m = R::speeds(c.tau, &g);

        // Inertia loads along normal and tangent of the inner contact, and the friction on it.
        let s_mu = p.s * m.mu;
        let fc = s_mu * m.mu;
        let two_s_mu = s_mu + s_mu;
        let er = [ci, -si];
        let mut loads = scale(fc, er);
        let (mut ti, mut to) = (T::ZERO, T::ZERO);
        let (mut by_mu, mut by_nu, mut f) = (T::ZERO, T::ZERO, [T::ZERO; 2]);
        if R::FRICTION {
            by_nu = T::of(0.4) * s_mu;
            by_mu = T::of(0.4) * p.s * m.nu + by_nu * so;
            f = [-(m.share_rest * sd), m.share - m.share_rest * cd];
            let couple = by_nu * m.nu;
            ti = m.share * couple;
            to = couple - ti;
            loads = add(loads, scale(couple, f));
        }
        // Their slopes by the angles of the contacts and by `ln(di / do)`.
        let slopes = |i: usize| {
            let fc = two_s_mu * m.mu_by[i];
            let couple = by_mu * m.mu_by[i] + by_nu * m.nu_by[i];
            if R::FRICTION {
                (add(scale(couple, f), scale(fc, er)), m.share * couple)
            } else {
                (scale(fc, er), T::ZERO)
            }
        };
        let (mut by_l, mut ti_l) = slopes(2);
        if R::FRICTION && R::COUPLED {
            let slope = ti * m.share_by;
            by_l = add(by_l, [slope * sd, slope + slope * cd]);
            ti_l += slope;
        }
        let (by_i, ti_i) = slopes(0);
        let (by_o, ti_o) = slopes(1);

        // Normal and tangent of the outer contact are (cd, -sd) and (sd, cd).
        let (hn, ho) = (T::of(1.5) * zi, T::of(1.5) * zo);
        let (kap, th) = (qi * per_ri, ti * per_ri);
        let l = &mut self.local;
        (l.hn, l.ho, l.kap, l.kap_o, l.th) = (hn, ho, kap, qo * per_ro, th);
        let (qo_s, qo_c) = (qo * sd, qo * cd);
        let r = add([qi - qo_c, qo_s], loads);
        let (by_di, by_do) = (scale(per_di, by_l), scale(per_do, by_l));
        let by_ri = scale(per_ri, by_i);
        let b = [[hn + by_di[0], by_ri[0] - th], [by_di[1], kap + by_ri[1]]];
        let along = add(scale(ho, [cd, -sd]), by_do);
        let across = sub([qo_s, qo_c], scale(to, [cd, -sd]));
        let across = scale(per_ro, sub(across, by_o));
        // Slopes of the friction on the inner contact: by the groove's motion, and by the ball's.
        let t_by = [per_di * ti_l, per_ri * ti_i];
        let (tl, tt) = (per_do * ti_l, per_ro * ti_o);
        let k = sub(scale(tt, [sd, cd]), scale(tl, [cd, -sd]));
        let k = sub(k, t_by);
        let t_by = turn(n, t_by);

        // M, its inverse, and the ball's steps.
        let outer = [
            turn([cd, sd], [along[0], across[0]]),
            turn([cd, sd], [along[1], across[1]]),
        ];
        let m = [
            [b[0][0] + outer[0][0], b[0][1] - outer[0][1]],
            [b[1][0] + outer[1][0], b[1][1] - outer[1][1]],
        ];
        let b = [turn(n, b[0]), turn(n, b[1])];
        let (down, up) = (m[0][0] * m[1][1], m[0][1] * m[1][0]);
        let determinant = down - up;
        let inverse = one
            / if determinant.abs() > T::TINY {
                determinant
            } else {
                one
            };
        let j = [
            [inverse * m[1][1], -(inverse * m[0][1])],
            [-(inverse * m[1][0]), inverse * m[0][0]],
        ];
        let z = times(&j, r);
        let xs = times(&j, loads);
        let d = product2(&j, &b);
        self.z = z;
        self.xs = xs;
        self.d = d;

        // Force on the ring after the step.
        let friction = ti + dot(k, z);
        let normal = qi - hn * z[0] + th * z[1];
        let force = turn(n, [normal, friction - kap * z[1]]);
        let moment = force[0] - c.friction_arm * friction;

        // Slope of the force by the groove's axial and radial position.
        let t_by = add(t_by, times_transposed(&d, k));
        let e = [
            [si - d[0][0], ci - d[0][1]],
            [ci - d[1][0], -(si + d[1][1])],
        ];
        let normal = times_transposed(&e, [hn, -th]);
        let tangential = add(scale(kap, e[1]), t_by);
        let arm = c.friction_arm;
        let [aa, ra] = turn(n, [normal[0], tangential[0]]);
        let [ar, rr] = turn(n, [normal[1], tangential[1]]);
        self.condensed.h = [[aa, ar], [ra, rr]];
        self.condensed.hm = sub([aa, ar], scale(arm, t_by));

        // Slope of the force by the speed.
        let friction = ti + dot(k, xs);
        let normal = th * xs[1] - hn * xs[0];
        let force_by_speed = turn(n, [normal, friction - kap * xs[1]]);
        let moment_by_speed = force_by_speed[0] - c.friction_arm * friction;
        let (residual, inner, outer) = (dot(r, r), qi * qi, qo * qo);
        self.n = n;
        self.condensed.force = force;
        self.condensed.moment = moment;
        self.condensed.force_by_speed = force_by_speed;
        self.condensed.moment_by_speed = moment_by_speed;
        Balance {
            residual,
            inner,
            outer,
        }
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

    /// Components along the inner contact's normal and tangent, turned to the outer contact's.
    #[inline(always)]
    fn outer_of(&self, v: Pair<T>) -> Pair<T> {
        let l = &self.local;
        [v[0] * l.cd - v[1] * l.sd, v[0] * l.sd + v[1] * l.cd]
    }

    /// Change of the condensed stiffness along the motion to `a`: elements `aa`, `ar`, `rr`. Of the friction forces, only
    /// the contacts' part is in it.
    #[inline(always)]
    pub fn stiffness_change<R: Rule>(&self, a: Pair<T>) -> [T; 3] {
        // Motions of the ball and of the inner contact, along and across that.
        let da = sub(a, self.a);
        if !R::INERTIA {
            let (inner, _) = self.curvatures();
            let [s, c] = self.n;
            return forms(inner.stiffness_change(turn(self.n, da)), [s, c], [c, -s]);
        }
        // Off the inner race, a ball hands nothing to the ring, though its own place still depends on the groove's.
        if !(self.local.delta > T::NOTHING) {
            return [T::ZERO; 3];
        }
        let dx = add(self.z, times(&self.d, da));
        let v = sub(turn(self.n, da), dx);
        let (inner, outer) = self.curvatures();
        let ([s, c], d) = (self.n, &self.d);
        // How the inner contact and the ball move with the groove's centre, axially and radially.
        let (xa, xr) = ([d[0][0], d[1][0]], [d[0][1], d[1][1]]);
        let (va, vr) = (sub([s, c], xa), sub([c, -s], xr));
        let i = forms(inner.stiffness_change(v), va, vr);
        let o = forms(
            outer.stiffness_change(self.outer_of(dx)),
            self.outer_of(xa),
            self.outer_of(xr),
        );
        [i[0] + o[0], i[1] + o[1], i[2] + o[2]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ball::kinematics::RacewayControlFree;
    use crate::bearing::Bearing;
    use crate::growth::Growth;
    use crate::{Design, FreeContact, Material};

    const SPINDLE: Bearing<f64, 16> = Bearing::<f64, 16>::const_new(&Design {
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
        let mut p = Point::new(c, c.inertia * 523.6 * 523.6, 0.0, Growth::NONE);
        p.start(c, 1.0);
        assert!(p.is_at_speed());
        let mut ball = Ball::NONE;
        ball.start([0.0; 2], p.low);
        ball.x = settle::<f64, RacewayControlFree>(c, &p, ball.a, ball.x, &mut 48);
        at(&mut ball, &p, p.low);
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
    fn a_ball_off_the_inner_race_has_no_stiffness_that_changes() {
        let (mut ball, p) = settled();
        let (c, off) = (&SPINDLE.constants, add(p.low, [-3.0, -6.0]));
        ball.start([0.0; 2], off);
        ball.x = settle::<f64, RacewayControlFree>(c, &p, off, ball.x, &mut 48);
        at(&mut ball, &p, off);
        assert!(ball.local.delta < 0.0, "{}", ball.local.delta);
        for step in [[1e-3, 0.0], [0.0, -1e-3], [1e-2, -1e-2]] {
            let a = add(off, step);
            let mut moved = ball;
            at(&mut moved, &p, a);
            assert_eq!(moved.condensed.h, [[0.0; 2]; 2]);
            let foreseen = ball.stiffness_change::<RacewayControlFree>(a);
            assert_eq!(foreseen, [0.0; 3], "{step:?}");
        }
    }

    #[test]
    fn the_stiffening_is_the_change_of_the_stiffness_but_for_what_friction_changes() {
        let (ball, p) = settled();
        for a in [[1e-4, 0.0], [0.0, 1e-4], [1e-4, -1e-4]] {
            let a = add(p.low, a);
            let [aa, ar, rr] = ball.stiffness_change::<RacewayControlFree>(a);
            let mut moved = ball;
            at(&mut moved, &p, a);
            let (h, before) = (moved.condensed.h, ball.condensed.h);
            for (i, j, foreseen) in [(0, 0, aa), (0, 1, ar), (1, 0, ar), (1, 1, rr)] {
                let change = h[i][j] - before[i][j];
                let off = (foreseen - change).abs();
                assert!(off < 0.01 * change.abs(), "{a:?}: {foreseen:e}, {change:e}");
            }
        }
    }
}
