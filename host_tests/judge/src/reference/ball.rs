//! One ball: its equations, and its equilibrium for a given place of the inner curvature centre.

use super::Reference;
use super::linear::small_solve;
use super::number::{Dual, Scalar};
use crate::double_double::Dd;
use core::array::from_fn;
use solvers::dispatch::Attitude;

/// Everything the equations of one ball yield.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terms<T> {
    /// Axial and radial gap between the chain of vectors and the inner curvature centre, in m.
    pub(crate) closure: [T; 2],
    /// Axial and radial force imbalance of the ball in N.
    pub(crate) balance: [T; 2],
    /// Axial and radial force on the ring and friction moment: `fa, fr, mt`.
    pub(crate) ring: [T; 3],
    pub(super) q: [T; 2],
    pub(super) fc: T,
    pub(super) mg: T,
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
    pub(super) azimuth: f64,
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

impl Reference {
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
    pub(super) fn flung(&self, centre: &[f64; 2], omega: f64, attitude: Attitude) -> [f64; 2] {
        let mut x = [0.0, self.lo.hi * (1.0 + 1e-9)];
        for _ in 0..3 {
            let mut w = self.unknowns(&x, centre);
            w[2] = -1.0;
            let fc = self.evaluate(&w, centre, omega, attitude).fc;
            x[1] = self.lo.hi + (fc / self.outer.k.hi).powf(2.0 / 3.0);
        }
        x
    }

    /// Centre of a ball thrown into the wedge between the races. The circles on which it touches one
    /// race each cross there, a little further out as its centrifugal force presses it in.
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
    pub(super) fn ball_newton(
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
    pub(super) fn ball_at(
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
}
