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
use crate::kinematics::{Attitude, BallMotion, NEAREST_POLE};
use crate::spring::{Spring, Square, Stretch};

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
    /// Newton step of `X` at a fixed ring, along the inner contact's normal and tangent.
    pub step: Pair<T>,
    /// Its derivative by `A`, likewise.
    pub slope: Square<T>,
    /// What moves the ball, by the force on it: the negative inverse of its tangent, likewise.
    pub mobility: Square<T>,
    /// Centrifugal force.
    pub fling: T,
    /// Derivatives by the logarithm of the speed load: of the ball's position (along the inner contact's
    /// normal and tangent), and of what it hands to the ring.
    pub step_by_speed: Pair<T>,
    pub force_by_speed: Pair<T>,
    pub couple_by_speed: T,
    /// What the ring knows of the ball between linearisations, and its last look at that.
    pub spring: Spring<T>,
    pub stretch: Stretch<T>,
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

/// How many times what is negligible beside the bearing's load a ball's force must be to count.
pub const COUNTS: f64 = 1e3;

/// A quotient that is rarely wanted: as a division it would be made always, and mostly thrown away.
#[cold]
#[inline(never)]
fn quotient<T: Real>(a: T, b: T) -> T {
    a / b
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
        let (mut friction, mut inner_friction) = (T::ZERO, T::ZERO);
        if A::FRICTION {
            friction = T::of(0.4) * speed_load * m.mu.value * m.nu.value;
            inner_friction = m.share * friction;
        }
        let loads = Loads {
            centrifugal: speed_load * m.mu.value * m.mu.value,
            friction,
            inner_friction,
            outer_friction: friction - inner_friction,
        };
        (m, loads)
    }

    /// Contacts and loads, without the linearisation.
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
            inner,
            outer,
            loads,
        }
    }

    /// Linearises the ball at the ring's offset `a`, keeps its Newton step and the step's slope, and
    /// returns what it hands to the ring, and how far the ball was from its own equilibrium: unbalanced
    /// force over its contact forces (or what is `negligible` beside the bearing's load), plus lag over
    /// deformation. A ball further off than `bad` has its Newton step and nothing else. `speed_load` is
    /// `m dm omega^2 / 2`; if `law` is set, the ball's law is worked out, too. A ring that
    /// cannot tilt, with fewer than 5 freedoms `D`, takes no notice of the couple.
    ///
    /// Vectors and matrices are worked out along the inner contact's normal and tangent, where half of
    /// the derivatives are single numbers, and turned to the bearing's directions in the end.
    #[inline(always)]
    pub fn linearise<A: Attitude, const D: usize>(
        &mut self,
        c: &Constants<T>,
        speed_load: T,
        negligible: T,
        a: Pair<T>,
        bad: T,
        law: bool,
    ) -> (Share<T>, T) {
        let (mut inner, mut outer) = self.contacts(c, a);
        inner.lead_by(self.inner_lead.q, c.ki);
        outer.lead_by(self.outer_lead.q, c.ko);
        self.inner_lead.remember(&inner);
        self.outer_lead.remember(&outer);
        let (m, l) = Self::loads::<A>(c, speed_load, &inner, &outer);
        let (ti, to, fc) = (l.inner_friction, l.outer_friction, l.centrifugal);
        let (si, ci) = (inner.sin, inner.cos);
        let (sd, cd) = (m.sin_d, m.cos_d);
        let (ri, ro) = (inner.inverse_radius, outer.inverse_radius);
        // Along n_i and t_i: n_o = (cos d, -sin d), t_o = (sin d, cos d), e_r = (cos ai, -sin ai).
        let inertia = |ti: T, to: T, fc: T| -> Pair<T> {
            if A::FRICTION {
                [fc * ci - to * sd, ti - to * cd - fc * si]
            } else {
                [fc * ci, -(fc * si)]
            }
        };

        // Slopes of Fc and of the friction by the angles; columns of r by normal and tangential motion at
        // each contact.
        let two = T::ONE + T::ONE;
        let fc_mu = two * speed_load * m.mu.value;
        let g = T::of(0.4) * speed_load;
        let (g_mu, g_nu) = (g * m.nu.value, g * m.mu.value);
        let g_ai = g_mu * m.mu.by_inner_angle + g_nu * m.nu.by_inner_angle;
        let g_ao = g_mu * m.mu.by_outer_angle + g_nu * m.nu.by_outer_angle;
        let (ti_ai, ti_ao) = (m.share * g_ai, m.share * g_ao);
        let by_ai = inertia(ti_ai, g_ai - ti_ai, fc_mu * m.mu.by_inner_angle);
        let by_ao = inertia(ti_ao, g_ao - ti_ao, fc_mu * m.mu.by_outer_angle);
        let mut r_di = [inner.slope, T::ZERO];
        let mut r_do = [-(outer.slope * cd), outer.slope * sd];
        let r_wi = [ri * (by_ai[0] - ti), ri * (by_ai[1] + inner.q)];
        let (mut turn_no, mut turn_to) = (by_ao[0] - outer.q * sd, by_ao[1] - outer.q * cd);
        if A::FRICTION {
            turn_no += to * cd;
            turn_to -= to * sd;
        }
        let r_wo = [ro * turn_no, ro * turn_to];
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

        // The unbalanced force; forces that lead are extrapolated to the geometry.
        let loads = inertia(ti, to, fc);
        // The large parts are taken apart before they are turned: sines and cosines of differences have
        // lost digits.
        let (no, so) = (outer.normal(), outer.tangent());
        let (mut axial, mut radial) = (T::ZERO, fc);
        if A::FRICTION {
            axial = ti * ci - to * so[0];
            radial = fc - ti * si - to * so[1];
        }
        let unbalanced = [
            inner.q * si - outer.q * no[0] + axial,
            inner.q * ci - outer.q * no[1] + radial,
        ];
        let residual = [
            unbalanced[0] * si + unbalanced[1] * ci + (inner.lag * r_di[0] + outer.lag * r_do[0]),
            unbalanced[0] * ci - unbalanced[1] * si + (inner.lag * r_di[1] + outer.lag * r_do[1]),
        ];

        // Here and not in the end, so that what it takes need not be kept in registers.
        let unbalanced = residual[0].abs() + residual[1].abs();
        let least = T::of(COUNTS) * negligible;
        let mut imbalance = if outer.q < least {
            quotient(unbalanced, least)
        } else {
            unbalanced * m.per_forces
        };
        let lag = inner.lag.abs() + outer.lag.abs();
        if lag > T::ZERO {
            imbalance += quotient(lag, outer.delta.at_least(T::TINY));
        }
        // Two contacts that do not oppose each other hold no ball: at 180 degrees the cage speed has a
        // pole, and next to it, from 150 degrees on, there are equilibria that are of the equations only.
        // A ball off the inner race is not held there by what the pole makes of its centrifugal force.
        if cd < T::of(-0.866)
            && (inner.q > T::ZERO || (cd < T::of(NEAREST_POLE - 1.0) && outer.q >= least))
        {
            imbalance = T::ONE;
        }

        // r_V and r_X - r_V = R, then the Newton step -R^-1 r, and its slope Y = -R^-1 r_V.
        let r_v = [[r_di[0], r_wi[0]], [r_di[1], r_wi[1]]];
        let row = |i: usize| {
            [
                r_do[i] * cd + r_wo[i] * sd - r_v[i][0],
                r_wo[i] * cd - r_do[i] * sd - r_v[i][1],
            ]
        };
        let matrix = [row(0), row(1)];
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
        let step = [
            dot(minus_inverse[0], residual),
            dot(minus_inverse[1], residual),
        ];
        self.step = step;
        // Forces that do not count say nothing of a ball that has far to go, and a long step along the race
        // leads off it.
        if outer.q < least {
            imbalance += step[0].abs() + step[1].abs();
        }
        if imbalance > bad {
            return (Share::NONE, imbalance);
        }
        // At a higher speed all inertia loads grow alike.
        let step_by_speed = [dot(minus_inverse[0], loads), dot(minus_inverse[1], loads)];
        let y = multiply(&minus_inverse, &r_v);
        self.step_by_speed = step_by_speed;
        (self.slope, self.mobility) = (y, minus_inverse);
        self.fling = fc;
        let rest = [[T::ONE - y[0][0], -y[0][1]], [-y[1][0], T::ONE - y[1][1]]];

        // Force on the ring: elastic part by V, friction part along t_i by V and X.
        let (mut by_x, mut couple_slope, mut turn_n) = ([T::ZERO; 2], [T::ZERO; 2], T::ZERO);
        if A::FRICTION {
            let ti_v = [ti_di, ti_ai * ri];
            let ti_wo = ti_ao * ro;
            let ti_x = [ti_do * cd + ti_wo * sd, ti_wo * cd - ti_do * sd];
            by_x = sub(ti_x, ti_v);
            couple_slope = [
                ti_v[0] * rest[0][0] + ti_v[1] * rest[1][0] + ti_x[0] * y[0][0] + ti_x[1] * y[1][0],
                ti_v[0] * rest[0][1] + ti_v[1] * rest[1][1] + ti_x[0] * y[0][1] + ti_x[1] * y[1][1],
            ];
            turn_n = ti * ri;
        }
        let turn_t = inner.q * ri;
        let local = [
            [
                inner.slope * rest[0][0] - turn_n * rest[1][0],
                inner.slope * rest[0][1] - turn_n * rest[1][1],
            ],
            [
                couple_slope[0] + turn_t * rest[1][0],
                couple_slope[1] + turn_t * rest[1][1],
            ],
        ];
        // From n_i and t_i to the axial and the radial direction.
        let turned = |v: Pair<T>| [v[0] * si + v[1] * ci, v[0] * ci - v[1] * si];
        let rows = [turned(local[0]), turned(local[1])];
        let columns = [
            turned([rows[0][0], rows[1][0]]),
            turned([rows[0][1], rows[1][1]]),
        ];
        let stiffness = [
            [columns[0][0], columns[1][0]],
            [columns[0][1], columns[1][1]],
        ];

        // What the ring will see once the ball has made its step.
        let moved = |step: Pair<T>, friction: T| {
            turned([
                turn_n * step[1] - inner.slope * step[0],
                friction - turn_t * step[1],
            ])
        };
        let friction = if A::FRICTION {
            ti + ti_di * inner.lag + ti_do * outer.lag + dot(by_x, step)
        } else {
            T::ZERO
        };
        let held = inner.q + inner.slope * inner.lag;
        let force = add(moved(step, friction), [held * si, held * ci]);
        let mut friction_by_speed = T::ZERO;
        if A::FRICTION {
            friction_by_speed = ti + dot(by_x, step_by_speed);
            if D == 5 {
                self.couple_by_speed = c.friction_arm * friction_by_speed;
            }
        }
        self.force_by_speed = moved(step_by_speed, friction_by_speed);
        let mut share = Share {
            force,
            stiffness,
            ..Share::NONE
        };
        if A::FRICTION && D == 5 {
            share.couple = c.friction_arm * friction;
            share.couple_slope = scale(c.friction_arm, turned(couple_slope));
        }
        if law {
            self.learn(c, inner, outer, l, share);
        }
        (share, imbalance)
    }

    /// Works out the law that agrees with the linearisation. By value: what is referred to would be kept in
    /// memory even where no law is wanted.
    #[inline(never)]
    fn learn(
        &mut self,
        c: &Constants<T>,
        inner: Contact<T>,
        outer: Contact<T>,
        l: Loads<T>,
        share: Share<T>,
    ) {
        self.stretch = Stretch::none();
        self.spring = if inner.q > T::ZERO {
            let carried = add(
                scale(inner.q, inner.normal()),
                scale(l.inner_friction, inner.tangent()),
            );
            Spring::of(
                c,
                &inner,
                &outer,
                carried,
                share.force,
                &share.stiffness,
                l.centrifugal,
            )
        } else {
            let gap = inner.delta - self.step[0];
            let across = dot(inner.normal(), outer.tangent());
            let climbs = c.ki * c.outer * across * across;
            let gives = climbs / l.centrifugal.at_least(T::TINY);
            Spring::open(
                inner.normal(),
                c.ki,
                gives.at_most(T::ONE / T::EPSILON),
                gap,
                T::of(0.5) * inner.inverse_radius,
            )
        };
    }

    /// How the contacts move when the ring makes `da`, in the ball's own directions: the inner one along and
    /// across itself; the outer one, likewise; and the outer one's direction.
    #[inline(always)]
    pub fn motions(&self, da: Pair<T>) -> (Pair<T>, Pair<T>, Pair<T>) {
        let step = self.stepped(da);
        let outer = self.inward(self.outer_lead.normal);
        (
            sub(da, step),
            [dot(outer, step), outer[0] * step[1] - outer[1] * step[0]],
            outer,
        )
    }

    /// A vector of the ball's own directions, n_i and t_i of its last linearisation, in the axial and
    /// the radial one.
    #[inline(always)]
    pub fn outward(&self, v: Pair<T>) -> Pair<T> {
        let [s, c] = self.inner_lead.normal;
        [v[0] * s + v[1] * c, v[0] * c - v[1] * s]
    }

    /// The reverse: the matrix is its own inverse.
    #[inline(always)]
    pub fn inward(&self, v: Pair<T>) -> Pair<T> {
        self.outward(v)
    }

    /// The ball's step, in its own directions, when the ring makes `da`, in the same.
    #[inline(always)]
    pub fn stepped(&self, da: Pair<T>) -> Pair<T> {
        [
            self.step[0] + dot(self.slope[0], da),
            self.step[1] + dot(self.slope[1], da),
        ]
    }
}
