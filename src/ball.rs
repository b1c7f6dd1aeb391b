//! One ball: its equilibrium between the two grooves, linearised exactly, and what it hands to the
//! ring.
//!
//! A ball sees the ring only through the position `A` of the inner groove's curvature centre. Its
//! own unknown is the position `X` of its centre. With the loads of the contacts as functions of
//! `V = A - X` (inner) and `X` (outer),
//!
//! ```text
//! f(V, X) = Qi n_i + Ti t_i                       force on the ring
//! r(V, X) = f - Qo n_o - To t_o + Fc e_r          force on the ball, 0 in equilibrium
//! ```
//!
//! one Newton step eliminates `X`: `dX = x0 + Y dA`, and the ring sees `f + f_X x0` and the
//! tangent `H = f_V (1 - Y) + f_X Y`. At equilibrium `x0 = 0` and `H` is the exact stiffness of
//! this ball, the derivatives of inertia loads, attitude and friction shares included.

use crate::constants::Constants;
use crate::contact::{Contact, Lead, Pair, Reference, add, dot, scale, sub};
use crate::float::Real;
use crate::kinematics::{Attitude, BallMotion};
use crate::spring::{Spring, Square};

/// What one ball hands to the ring for the present displacement, elimination done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share<T> {
    /// Force on the ring, axial and radial.
    pub force: Pair<T>,
    /// Friction moment about the inner groove's centre, over the lever arm `Rp`.
    pub couple: T,
    /// Tangent of the force by `A`.
    pub stiffness: Square<T>,
    /// Tangent of the couple by `A`.
    pub couple_slope: Pair<T>,
}

impl<T: Real> Share<T> {
    /// A ball that carries nothing.
    pub const NONE: Self = Self {
        force: [T::ZERO; 2],
        couple: T::ZERO,
        stiffness: [[T::ZERO; 2]; 2],
        couple_slope: [T::ZERO; 2],
    };
}

/// A ball at speed: its position, and its last linearisation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ball<T> {
    /// References of `X` and of `V = A - X`; they add up to `A` at the ring's reference.
    pub outer: Reference<T>,
    pub inner: Reference<T>,
    /// `A.A - 1` there, which is twice the squeeze of a ball at rest.
    pub excess: T,
    /// Offset of `X` from its reference.
    pub x: Pair<T>,
    /// Newton step of `X` at a fixed ring.
    pub step: Pair<T>,
    /// Its derivative by `A`.
    pub slope: Square<T>,
    /// Stiffness along the inner contact's normal, and its derivative by the contact's force.
    pub stiff: T,
    pub stiffening: T,
    /// Change of the force on the ring by a change of speed.
    pub carried: Pair<T>,
    /// Centrifugal force.
    pub fling: T,
    /// Derivatives by the speed load: of the ball's position, and of what it hands to the ring.
    pub step_by_speed: Pair<T>,
    pub force_by_speed: Pair<T>,
    pub couple_by_speed: T,
    /// What the ring knows of the ball between linearisations.
    pub spring: Spring<T>,
    /// Forces of the inner and the outer contact, as unknowns of their own.
    pub inner_lead: Lead<T>,
    pub outer_lead: Lead<T>,
}

/// Inertia loads and friction of a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loads<T> {
    /// Centrifugal force.
    pub centrifugal: T,
    /// Sum of both friction forces, `2 Mg / D`.
    pub friction: T,
    /// Friction force at the inner contact.
    pub inner_friction: T,
    /// Friction force at the outer contact.
    pub outer_friction: T,
}

/// State of a ball at one position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pass<T> {
    pub inner: Contact<T>,
    pub outer: Contact<T>,
    pub loads: Loads<T>,
    /// Unbalanced force on the ball.
    pub residual: Pair<T>,
}

/// `a (x) b` added to a matrix.
#[inline(always)]
fn add_outer<T: Real>(m: &mut Square<T>, a: Pair<T>, b: Pair<T>) {
    for i in 0..2 {
        for j in 0..2 {
            m[i][j] += a[i] * b[j];
        }
    }
}

#[inline(always)]
fn multiply<T: Real>(a: &Square<T>, b: &Square<T>) -> Square<T> {
    let mut m = [[T::ZERO; 2]; 2];
    for i in 0..2 {
        for j in 0..2 {
            m[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j];
        }
    }
    m
}

impl<T: Real> Ball<T> {
    /// Contacts for the ring's offset `a` from its reference.
    #[inline(always)]
    fn contacts(&self, c: &Constants<T>, a: Pair<T>) -> (Contact<T>, Contact<T>) {
        let y = sub(a, self.x);
        (
            Contact::at(&self.inner, y, c.inner, c.ki),
            Contact::at(&self.outer, self.x, c.outer, c.ko),
        )
    }

    #[inline(always)]
    fn loads<A: Attitude>(
        c: &Constants<T>,
        speed_load: T,
        inner: &Contact<T>,
        outer: &Contact<T>,
    ) -> (BallMotion<T>, Loads<T>) {
        let m = A::motion(c, inner, outer);
        let friction = T::of(0.4) * speed_load * m.mu.value * m.nu.value;
        let inner_friction = m.share * friction;
        let loads = Loads {
            centrifugal: speed_load * m.mu.value * m.mu.value,
            friction,
            inner_friction,
            outer_friction: friction - inner_friction,
        };
        (m, loads)
    }

    #[inline(always)]
    fn residual(inner: &Contact<T>, outer: &Contact<T>, l: &Loads<T>) -> Pair<T> {
        let f = add(
            scale(inner.q, inner.normal()),
            scale(l.inner_friction, inner.tangent()),
        );
        let g = add(
            scale(outer.q, outer.normal()),
            scale(l.outer_friction, outer.tangent()),
        );
        [f[0] - g[0], f[1] - g[1] + l.centrifugal]
    }

    /// Contacts, loads and unbalanced force, without the linearisation.
    #[inline]
    pub fn observe<A: Attitude>(&self, c: &Constants<T>, speed_load: T, a: Pair<T>) -> Pass<T> {
        let (mut inner, mut outer) = self.contacts(c, a);
        // A ball without forces has dropped out; rounding may still see it touch.
        if self.outer_lead.q <= T::ZERO {
            inner.q = T::ZERO;
            outer.q = T::ZERO;
        }
        let (_, loads) = Self::loads::<A>(c, speed_load, &inner, &outer);
        Pass {
            residual: Self::residual(&inner, &outer, &loads),
            inner,
            outer,
            loads,
        }
    }

    /// Linearises the ball at the ring's offset `a`, keeps its Newton step and the step's slope, and
    /// returns what it hands to the ring. `speed_load` is `m dm omega^2 / 2`.
    #[inline]
    pub fn linearise<A: Attitude>(
        &mut self,
        c: &Constants<T>,
        speed_load: T,
        a: Pair<T>,
        law: bool,
    ) -> (Share<T>, Pass<T>) {
        let (inner, outer) = self.contacts(c, a);
        let inner = inner.led_by(self.inner_lead.q, c.ki);
        let outer = outer.led_by(self.outer_lead.q, c.ko);
        self.inner_lead.remember(&inner);
        self.outer_lead.remember(&outer);
        let (m, l) = Self::loads::<A>(c, speed_load, &inner, &outer);
        let mut residual = Self::residual(&inner, &outer, &l);
        let two = T::ONE + T::ONE;
        // Slopes of Fc and of the friction by the angles and by eta.
        let fc_mu = two * speed_load * m.mu.value;
        let g = T::of(0.4) * speed_load;
        let (g_mu, g_nu) = (g * m.nu.value, g * m.mu.value);
        let fc_ai = fc_mu * m.mu.by_inner_angle;
        let fc_ao = fc_mu * m.mu.by_outer_angle;
        let g_ai = g_mu * m.mu.by_inner_angle + g_nu * m.nu.by_inner_angle;
        let g_ao = g_mu * m.mu.by_outer_angle + g_nu * m.nu.by_outer_angle;
        let ti_ai = m.share * g_ai;
        let ti_ao = m.share * g_ao;
        let (to_ai, to_ao) = (g_ai - ti_ai, g_ao - ti_ao);

        // Columns of r by the four local coordinates: normal and tangential motion at each contact.
        let (ni, ti) = (inner.normal(), inner.tangent());
        let (no, to) = (outer.normal(), outer.tangent());
        let ri = inner.inverse_radius;
        let ro = outer.inverse_radius;
        let inertia = |ti_by: T, to_by: T, fc_by: T| -> Pair<T> {
            [
                ti_by * ti[0] - to_by * to[0],
                ti_by * ti[1] - to_by * to[1] + fc_by,
            ]
        };
        let mut r_di = scale(inner.slope, ni);
        let mut r_do = scale(-outer.slope, no);
        let r_wi = scale(
            ri,
            add(
                inertia(ti_ai, to_ai, fc_ai),
                sub(scale(inner.q, ti), scale(l.inner_friction, ni)),
            ),
        );
        let r_wo = scale(
            ro,
            sub(
                inertia(ti_ao, to_ao, fc_ao),
                sub(scale(outer.q, to), scale(l.outer_friction, no)),
            ),
        );
        let (mut ti_di, mut ti_do) = (T::ZERO, T::ZERO);
        if A::COUPLED {
            let fc_eta = fc_mu * m.mu.by_eta;
            let g_eta = g_mu * m.mu.by_eta + g_nu * m.nu.by_eta;
            let ti_eta = m.share * g_eta;
            let to_eta = g_eta - ti_eta;
            let shift_i = l.friction * m.share_by_inner;
            let shift_o = l.friction * m.share_by_outer;
            ti_di = ti_eta * m.eta_by_inner + shift_i;
            ti_do = ti_eta * m.eta_by_outer + shift_o;
            r_di = add(
                r_di,
                inertia(
                    ti_di,
                    to_eta * m.eta_by_inner - shift_i,
                    fc_eta * m.eta_by_inner,
                ),
            );
            r_do = add(
                r_do,
                inertia(
                    ti_do,
                    to_eta * m.eta_by_outer - shift_o,
                    fc_eta * m.eta_by_outer,
                ),
            );
        }

        // Forces that lead are extrapolated to the geometry.
        residual = add(
            residual,
            add(scale(inner.lag, r_di), scale(outer.lag, r_do)),
        );

        // r_V and r_X, then the Newton step -R^-1 r with R = r_X - r_V, and its slope -R^-1 r_V.
        let mut r_v = [[T::ZERO; 2]; 2];
        add_outer(&mut r_v, r_di, ni);
        add_outer(&mut r_v, r_wi, ti);
        let mut matrix = [[-r_v[0][0], -r_v[0][1]], [-r_v[1][0], -r_v[1][1]]];
        add_outer(&mut matrix, r_do, no);
        add_outer(&mut matrix, r_wo, to);
        let determinant = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
        // A ball off both races (at rest) drops out: no force, no step.
        let inverse = if determinant.abs() > T::TINY {
            T::ONE / determinant
        } else {
            T::ZERO
        };
        let minus_inverse = [
            [-(matrix[1][1] * inverse), matrix[0][1] * inverse],
            [matrix[1][0] * inverse, -(matrix[0][0] * inverse)],
        ];
        self.step = [
            dot(minus_inverse[0], residual),
            dot(minus_inverse[1], residual),
        ];
        let y = multiply(&minus_inverse, &r_v);
        self.slope = y;

        // Force on the ring: elastic part by V, friction part along t_i by V and X.
        let ti_v = add(scale(ti_di, ni), scale(ti_ai * ri, ti));
        let ti_x = add(scale(ti_do, no), scale(ti_ao * ro, to));
        let by_x = sub(ti_x, ti_v);
        let rest = [[T::ONE - y[0][0], -y[0][1]], [-y[1][0], T::ONE - y[1][1]]];
        let couple_slope = [
            ti_v[0] * rest[0][0] + ti_v[1] * rest[1][0] + ti_x[0] * y[0][0] + ti_x[1] * y[1][0],
            ti_v[0] * rest[0][1] + ti_v[1] * rest[1][1] + ti_x[0] * y[0][1] + ti_x[1] * y[1][1],
        ];
        let turn = scale(ri, sub(scale(inner.q, ti), scale(l.inner_friction, ni)));
        let mut elastic = [[T::ZERO; 2]; 2];
        add_outer(&mut elastic, scale(inner.slope, ni), ni);
        add_outer(&mut elastic, turn, ti);
        let mut stiffness = multiply(&elastic, &rest);
        add_outer(&mut stiffness, ti, couple_slope);

        // What the ring will see once the ball has made its step.
        let friction_step = dot(by_x, self.step);
        let force_step = [
            dot(elastic[0], self.step) - ti[0] * friction_step,
            dot(elastic[1], self.step) - ti[1] * friction_step,
        ];
        let friction = l.inner_friction + ti_di * inner.lag + ti_do * outer.lag;
        let force = add(
            scale(inner.q + inner.slope * inner.lag, ni),
            scale(friction, ti),
        );
        let force = sub(force, force_step);
        self.fling = l.centrifugal;
        // At a higher speed all inertia loads grow alike.
        let per_load = if speed_load > T::ZERO {
            T::ONE / speed_load
        } else {
            T::ZERO
        };
        let by_speed = scale(
            per_load,
            inertia(l.inner_friction, l.outer_friction, l.centrifugal),
        );
        self.step_by_speed = [
            dot(minus_inverse[0], by_speed),
            dot(minus_inverse[1], by_speed),
        ];
        let friction_by_speed = l.inner_friction * per_load + dot(by_x, self.step_by_speed);
        self.couple_by_speed = c.friction_arm * friction_by_speed;
        self.force_by_speed = [
            ti[0] * friction_by_speed - dot(elastic[0], self.step_by_speed),
            ti[1] * friction_by_speed - dot(elastic[1], self.step_by_speed),
        ];
        if inner.q > T::ZERO {
            // 1/3 Q of a Hertz contact's stiffness, 3 Q of a bent chain's.
            let half = T::of(0.5);
            self.stiff = dot(ni, [dot(stiffness[0], ni), dot(stiffness[1], ni)]);
            let sin_d = ni[0] * no[1] - ni[1] * no[0];
            let bent = self.stiff * sin_d * sin_d * half;
            let per = T::ONE / (inner.q * (inner.q + outer.q));
            self.stiffening = self.stiff
                * (T::of(1.0 / 3.0) * (inner.q + outer.q)
                    + T::of(3.0) * bent)
                * per;
        }
        if !law {
            return (
                Share {
                    force,
                    couple: c.friction_arm * (friction + friction_step),
                    stiffness,
                    couple_slope: scale(c.friction_arm, couple_slope),
                },
                Pass {
                    inner,
                    outer,
                    loads: l,
                    residual,
                },
            );
        }
        self.spring = if inner.q > T::ZERO {
            let carried = add(scale(inner.q, ni), scale(l.inner_friction, ti));
            let along = l.centrifugal * c.inner;
            Spring::of(&inner, &outer, carried, force, &stiffness, along)
        } else {
            let gap = inner.delta - dot(ni, self.step);
            Spring::open(ni, c.ki, gap, T::of(0.5) * ri)
        };
        (
            Share {
                force,
                couple: c.friction_arm * (friction + friction_step),
                stiffness,
                couple_slope: scale(c.friction_arm, couple_slope),
            },
            Pass {
                inner,
                outer,
                loads: l,
                residual,
            },
        )
    }
}
