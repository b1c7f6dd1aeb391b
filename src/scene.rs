//! What a solve computes, chosen by types: what a scene does not need is not compiled.
//!
//! [`Static`] is the bearing at rest: every ball is one spring in closed form, without unknowns of
//! its own. [`AtSpeed`] adds centrifugal force, gyroscopic moment and friction under a rule for the
//! balls' attitude.

use crate::ball::{Ball, Loads, Pass, Share};
use crate::constants::{Azimuth, Constants, Split};
use crate::contact::{Contact, Lead, Pair, Pull, Reference, add, dot, length, scale, sub};
use crate::float::Real;
use crate::kinematics::{Attitude, RacewayControlFree};
use crate::ring::Five;
use core::marker::PhantomData;

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Static {}
    impl<A> Sealed for super::AtSpeed<A> {}
}

/// The bearing at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Static;

/// The bearing at speed, its balls' attitude by the rule `A`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AtSpeed<A = RacewayControlFree>(PhantomData<A>);

/// Position of the ring: a coarse reference, exactly known to every ball, and an offset.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Position<T> {
    pub reference: Five<T>,
    pub offset: Five<T>,
}

impl<T: Real> Position<T> {
    /// Their sum.
    #[inline]
    pub fn total(&self) -> Five<T> {
        let mut total = self.reference;
        for (sum, offset) in total.iter_mut().zip(&self.offset) {
            *sum += *offset;
        }
        total
    }

    /// Moves the reference next to the position.
    #[inline]
    pub fn rebase(&mut self) {
        for (reference, offset) in self.reference.iter_mut().zip(&mut self.offset) {
            let new = (*reference + *offset).coarse();
            *offset += *reference - new;
            *reference = new;
        }
    }
}

/// What drives the balls of one sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive<T> {
    /// Centrifugal force at a cage speed equal to the shaft's, `m dm omega^2 / 2`.
    pub speed_load: T,
    /// A force so small that the working precision cannot tell it beside the bearing's load.
    pub negligible: T,
    /// Depth from which a free ball counts as caught again by the inner race.
    pub catch: T,
}

impl<T: Real> Drive<T> {
    /// Force of a ball that is caught.
    #[inline(always)]
    fn faint(&self) -> T {
        self.catch * self.catch.sqrt()
    }
}

/// How far from its equilibrium a linearised ball was.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Check<T> {
    /// Unbalanced force over the ball's largest force, plus lag over deformation.
    pub imbalance: T,
    /// Unbalanced force.
    pub unbalanced: T,
    /// Largest force on the ball.
    pub largest: T,
    /// Largest lag of a contact.
    pub lag: T,
    /// Deformation of the inner contact (at rest: of both).
    pub delta: T,
}

/// How the balls move: [`Static`] or [`AtSpeed`]. Sealed.
pub trait Motion: sealed::Sealed + 'static {
    /// What is remembered of a ball.
    #[doc(hidden)]
    type Ball<T: Real>: Copy + core::fmt::Debug + Default + PartialEq;
    /// The shaft turns.
    const AT_SPEED: bool;

    /// Places a ball without any knowledge of its last position.
    #[doc(hidden)]
    fn place<T: Real>(c: &Constants<T>, speed_load: T, ball: &mut Self::Ball<T>, centre: Pair<T>);
    /// Refers a ball to a ring reference at which the inner groove's centre is at `coarse + fine`.
    #[doc(hidden)]
    fn rebase<T: Real>(c: &Constants<T>, ball: &mut Self::Ball<T>, coarse: Pair<T>, fine: Pair<T>);
    /// Linearises the ball at the ring's offset `a`.
    #[doc(hidden)]
    fn linearise<T: Real>(
        c: &Constants<T>,
        drive: &Drive<T>,
        ball: &mut Self::Ball<T>,
        a: Pair<T>,
    ) -> (Share<T>, Check<T>);
    /// Forgets the Newton step of a ball that has made it, but not its slope.
    #[doc(hidden)]
    fn rest<T: Real>(ball: &mut Self::Ball<T>);
    /// Follows a step `da` of the ring from its offset `a`; returns the ball's own step.
    #[doc(hidden)]
    fn follow<T: Real>(
        c: &Constants<T>,
        drive: &Drive<T>,
        ball: &mut Self::Ball<T>,
        a: Pair<T>,
        da: Pair<T>,
    ) -> T;
    /// State of the ball for reports.
    #[doc(hidden)]
    fn observe<T: Real>(
        c: &Constants<T>,
        speed_load: T,
        ball: &Self::Ball<T>,
        a: Pair<T>,
    ) -> Pass<T>;
}

/// Position of the inner groove's curvature centre at the ring's reference: a part that is exact
/// (products of coarse numbers), and a small rest.
#[inline]
pub fn curvature_centre<T: Real>(
    c: &Constants<T>,
    u: &Five<T>,
    at: &Azimuth<T>,
) -> (Pair<T>, Pair<T>) {
    let (cos, sin) = (at.cos.coarse(), at.sin.coarse());
    (
        [
            c.n0[0].high + u[0] + u[3] * sin - u[4] * cos,
            c.n0[1].high + u[1] * cos + u[2] * sin,
        ],
        [
            c.n0[0].low + u[3] * at.sin_low - u[4] * at.cos_low,
            c.n0[1].low + u[1] * at.cos_low + u[2] * at.sin_low,
        ],
    )
}

/// The square of `L0`.
const fn one<T: Real>() -> Split<T> {
    Split {
        high: T::ONE,
        low: T::ZERO,
    }
}

/// A ball at rest: the inner groove's curvature centre as seen from the outer one's.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spring<T> {
    pub centres: Reference<T>,
    pub lead: Lead<T>,
}

impl Motion for Static {
    type Ball<T: Real> = Spring<T>;
    const AT_SPEED: bool = false;

    #[inline(always)]
    fn place<T: Real>(_: &Constants<T>, _: T, _: &mut Spring<T>, _: Pair<T>) {}

    #[inline(always)]
    fn rebase<T: Real>(_: &Constants<T>, ball: &mut Spring<T>, coarse: Pair<T>, fine: Pair<T>) {
        ball.centres = Reference::at(coarse, fine, one());
    }

    #[inline(never)]
    fn linearise<T: Real>(
        _: &Constants<T>,
        _: &Drive<T>,
        ball: &mut Spring<T>,
        a: Pair<T>,
    ) -> (Share<T>, Check<T>) {
        let k = Contact::at(&ball.centres, a, T::ONE, T::ONE).led_by(ball.lead.q, T::ONE);
        ball.lead.remember(&k);
        let check = Check {
            lag: k.lag.abs(),
            delta: k.delta,
            largest: k.q,
            ..Check::default()
        };
        if k.q <= T::ZERO {
            return (Share::NONE, check);
        }
        // H = dQ/d delta n n + Q/|A| t t.
        let across = k.q * k.inverse_radius;
        let twist = k.slope - across;
        let mixed = twist * k.sin * k.cos;
        let share = Share {
            force: scale(k.q + k.slope * k.lag, k.normal()),
            couple: T::ZERO,
            stiffness: [
                [across + twist * k.sin * k.sin, mixed],
                [mixed, across + twist * k.cos * k.cos],
            ],
            couple_slope: [T::ZERO; 2],
        };
        (share, check)
    }

    #[inline(always)]
    fn rest<T: Real>(ball: &mut Spring<T>) {
        ball.lead.rest();
    }

    #[inline(always)]
    fn follow<T: Real>(
        _: &Constants<T>,
        drive: &Drive<T>,
        ball: &mut Spring<T>,
        _: Pair<T>,
        da: Pair<T>,
    ) -> T {
        if ball.lead.q > T::ZERO
            && ball.lead.follow(da) == Pull::Lets
            && ball.lead.q < drive.faint()
        {
            ball.lead.q = T::ZERO;
        }
        T::ZERO
    }

    #[inline]
    fn observe<T: Real>(c: &Constants<T>, _: T, ball: &Spring<T>, a: Pair<T>) -> Pass<T> {
        let k = Contact::at(&ball.centres, a, T::ONE, T::ONE);
        let outer = Contact {
            delta: k.delta * c.outer_share,
            ..k
        };
        let inner = Contact {
            delta: k.delta - outer.delta,
            ..k
        };
        Pass {
            inner,
            outer,
            loads: Loads {
                centrifugal: T::ZERO,
                friction: T::ZERO,
                inner_friction: T::ZERO,
                outer_friction: T::ZERO,
            },
            residual: [T::ZERO; 2],
        }
    }
}

/// Radial position and centrifugal force of a ball that only the outer race holds, the inner
/// groove's centre being at `centre`.
#[inline]
fn free_ball<T: Real>(c: &Constants<T>, speed_load: T, centre: Pair<T>) -> (T, T) {
    let v = [centre[0], centre[1] - c.outer];
    let cosine = v[1] / length(v);
    let mu = (T::ONE - c.tau * cosine) / (T::ONE + cosine).or_larger(T::of(0.01));
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

    /// The state before a sweep can be so far from any that fits the ring's new position that
    /// Newton steps would take long to forget it: such a ball starts anew. True for a ball that
    /// is off both races and too slow for its centrifugal force to count: it drops out, as at rest.
    #[inline]
    fn revise(&mut self, c: &Constants<T>, drive: &Drive<T>, a: Pair<T>) -> bool {
        let centre = self.centre(a);
        let squeeze = self.squeeze(a);
        let q = self.inner_lead.q;
        if drive.speed_load <= drive.negligible {
            if squeeze <= T::ZERO {
                *self = Self {
                    outer: self.outer,
                    inner: self.inner,
                    excess: self.excess,
                    x: sub(scale(c.outer / length(centre), centre), self.outer.vector),
                    ..Self::default()
                };
                return true;
            }
            if q <= T::ZERO {
                place(c, T::ZERO, self, centre, squeeze);
            }
        } else if q <= T::ZERO {
            let v = add(self.inner.vector, sub(a, self.x));
            let reach = c.inner + drive.catch;
            if dot(v, v) > reach * reach {
                place(c, drive.speed_load, self, centre, squeeze);
            }
        } else {
            let far = T::of(30.0);
            let squeezed = if squeeze > T::ZERO {
                squeeze * squeeze.sqrt()
            } else {
                T::ZERO
            };
            let flung = drive.speed_load * T::of(0.2);
            if (q * far < squeezed && squeezed > far * flung) || q > far * (squeezed + flung) {
                place(c, drive.speed_load, self, centre, squeeze);
            }
        }
        false
    }
}

/// Three starts for a ball, by what holds it: out on the outer race, off the inner one; squeezed on
/// the line of the two curvature centres, as at rest; or, where the grooves leave it room, pressed by
/// centrifugal force into the corner between two rigid grooves.
#[inline(never)]
fn place<T: Real>(
    c: &Constants<T>,
    speed_load: T,
    ball: &mut Ball<T>,
    centre: Pair<T>,
    squeeze: T,
) {
    let [a1, a2] = centre;
    let squared = dot(centre, centre).or_larger(T::TINY);
    let distance = squared.sqrt();
    let (free, fc) = free_ball(c, speed_load, centre);
    let v = [a1, a2 - free];
    if fc > T::ZERO && dot(v, v) <= c.inner * c.inner {
        ball.put([T::ZERO, free], T::ZERO, fc);
    } else if squeeze > T::ZERO || fc <= T::ZERO {
        let squeeze = squeeze.or_larger(T::ZERO);
        let along = (c.outer + squeeze * c.outer_share) / distance;
        let q = squeeze * squeeze.sqrt();
        ball.put(scale(along, centre), q, q + fc);
    } else {
        let along = T::of(0.5) * (T::ONE + (c.outer - c.inner) / squared);
        let across = (c.outer * c.outer / squared - along * along)
            .or_larger(T::ZERO)
            .sqrt();
        let across = if a1 < T::ZERO { -across } else { across };
        let at = [a1 * along - a2 * across, a2 * along + a1 * across];
        // Triangle of forces: Qi sin(ai - ao) = Fc sin ao, Qo sin(ai - ao) = Fc sin ai.
        let (si, ci) = ((a1 - at[0]) / c.inner, (a2 - at[1]) / c.inner);
        let (so, co) = (at[0] / c.outer, at[1] / c.outer);
        let unit = fc / (si * co - ci * so).abs().or_larger(T::of(1e-3));
        ball.put(at, unit * so.abs(), unit * si.abs());
    }
}

impl<A: Attitude> Motion for AtSpeed<A> {
    type Ball<T: Real> = Ball<T>;
    const AT_SPEED: bool = true;

    #[inline(always)]
    fn place<T: Real>(c: &Constants<T>, speed_load: T, ball: &mut Ball<T>, centre: Pair<T>) {
        place(c, speed_load, ball, centre, length(centre) - T::ONE);
    }

    #[inline]
    fn rebase<T: Real>(c: &Constants<T>, ball: &mut Ball<T>, coarse: Pair<T>, fine: Pair<T>) {
        let old = ball.outer.vector;
        let new = [(old[0] + ball.x[0]).fine(), (old[1] + ball.x[1]).fine()];
        ball.x = add(ball.x, sub(old, new));
        ball.outer = Reference::at(new, [T::ZERO; 2], c.outer_squared);
        ball.inner = Reference::at(sub(coarse, new), fine, c.inner_squared);
        ball.excess = Reference::at(coarse, fine, one()).excess;
    }

    #[inline(never)]
    fn linearise<T: Real>(
        c: &Constants<T>,
        drive: &Drive<T>,
        ball: &mut Ball<T>,
        a: Pair<T>,
    ) -> (Share<T>, Check<T>) {
        if ball.revise(c, drive, a) {
            return (Share::NONE, Check::default());
        }
        let (share, pass) = ball.linearise::<A>(c, drive.speed_load, a);
        let largest = pass
            .outer
            .q
            .or_larger(pass.inner.q)
            .or_larger(pass.loads.centrifugal);
        let unbalanced = pass.residual[0].abs() + pass.residual[1].abs();
        let lag = pass.inner.lag.abs() + pass.outer.lag.abs();
        let scale = largest.or_larger(drive.negligible * T::of(1e3));
        let check = Check {
            imbalance: unbalanced / scale.or_larger(T::TINY)
                + lag / pass.outer.delta.or_larger(T::TINY),
            unbalanced,
            largest,
            lag,
            delta: pass.inner.delta,
        };
        (share, check)
    }

    #[inline(always)]
    fn rest<T: Real>(ball: &mut Ball<T>) {
        ball.step = [T::ZERO; 2];
        ball.inner_lead.rest();
        ball.outer_lead.rest();
    }

    #[inline]
    fn follow<T: Real>(
        c: &Constants<T>,
        drive: &Drive<T>,
        ball: &mut Ball<T>,
        a: Pair<T>,
        da: Pair<T>,
    ) -> T {
        let mut dx = [
            ball.step[0] + dot(ball.slope[0], da),
            ball.step[1] + dot(ball.slope[1], da),
        ];
        let step = dx[0].abs() + dx[1].abs();
        if !step.is_finite() {
            let a = add(a, da);
            place(c, drive.speed_load, ball, ball.centre(a), ball.squeeze(a));
            return T::ONE;
        }
        let cap = T::of(0.3);
        if step > cap {
            dx = scale(cap / step, dx);
        }
        ball.x = add(ball.x, dx);
        if ball.outer_lead.q > T::ZERO {
            ball.outer_lead.follow(dx);
        }
        if ball.inner_lead.q > T::ZERO
            && ball.inner_lead.follow(sub(da, dx)) == Pull::Lets
            && drive.speed_load > drive.negligible
        {
            // Off the inner race if the outer one holds it clear, or if next to nothing is left
            // of the force.
            let centre = ball.centre(add(a, da));
            let (free, fc) = free_ball(c, drive.speed_load, centre);
            let v = [centre[0], centre[1] - free];
            if dot(v, v) <= c.inner * c.inner {
                ball.put([T::ZERO, free], T::ZERO, fc);
            } else if ball.inner_lead.q < drive.faint() {
                ball.inner_lead.q = T::ZERO;
            }
        }
        step
    }

    #[inline]
    fn observe<T: Real>(c: &Constants<T>, speed_load: T, ball: &Ball<T>, a: Pair<T>) -> Pass<T> {
        ball.observe::<A>(c, speed_load, a)
    }
}
