//! Settles a ball near its equilibrium, from where its own Newton steps do not lead there. The ring stays where it is.
//!
//! With inertia loads frozen, the ball's energy `2/5 Ki delta_i^(5/2) + 2/5 Ko delta_o^(5/2) - P.X` is convex, and
//! Newton's method descends on it. The loads are worked out again at every step.

use crate::ball::contact::Point;
use crate::ball::kinematics::Rule;
use crate::ball::report::Kinetics;
use crate::bearing::Constants;
use crate::linalg::{Matrix2, Pair, add, dot, scale, sub};
use crate::real::Real;
use crate::tuning;

/// Where a ball is under the centrifugal force `fc` alone.
///
/// On the outer race, if it does not reach the inner one there. Else it is at the apex of the triangle of both
/// contacts' lengths, or on the line between the grooves' centres.
fn chain<T: Real>(c: &Constants<T>, p: &Point<T>, a: Pair<T>, fc: T) -> Pair<T> {
    let root = fc.cbrt_or_zero();
    let off = [T::ZERO, p.lo + root * root];
    let to_inner = sub(a, off);
    if dot(to_inner, to_inner) <= p.li * p.li {
        return off;
    }
    let length = dot(a, a).at_least(T::TINY).sqrt_abs();
    let e = scale(T::ONE / length, a);
    let (mut d_i, mut d_o) = (T::ZERO, root * root);
    let mut x = off;
    for _ in 0..3 {
        let (ro, ri) = (p.lo + d_o, p.li + d_i);
        if length >= ro + ri {
            // Taut: both contacts share the rest of the length.
            let beyond = length - p.lo - p.li;
            let ro = p.lo + (c.outer_share * beyond).at_least(d_o.at_most(beyond));
            return scale(ro, e);
        }
        let along = T::of(0.5) * (length + (ro - ri) * (ro + ri) / length);
        let height = (ro * ro - along * along).at_least(T::ZERO).sqrt_abs();
        // Bent outwards, where the centrifugal force pulls.
        let side = if e[0] < T::ZERO { -height } else { height };
        x = add(scale(along, e), scale(side, [-e[1], e[0]]));
        let no = scale(T::ONE / ro, x);
        let ni = scale(T::ONE / ri, sub(a, x));
        let sd = (ni[0] * no[1] - ni[1] * no[0]).abs().at_least(T::of(1e-3));
        let (qi, qo) = (fc * no[0].abs() / sd, fc * ni[0].abs() / sd);
        let (wi, wo) = ((qi / c.ki).cbrt_or_zero(), qo.cbrt_or_zero());
        d_i = wi * wi;
        d_o = wo * wo;
    }
    x
}

/// Steps for a ball that settles alone, in a start.
pub const ALONE: u16 = 48;

/// Settles the ball next to its equilibrium, from where it is or from the chain, whichever has less energy.
///
/// Its offset was `kept`, and the groove's centre is at the offset `groove`. It takes of the steps that are `left`; without one, it
/// stays on its way.
#[inline(never)]
pub fn settle<T: Real, R: Rule>(
    c: &Constants<T>,
    p: &Point<T>,
    groove: Pair<T>,
    kept: Pair<T>,
    left: &mut u16,
) -> Pair<T> {
    let half = T::of(0.5) * (T::ONE - c.tau * c.n0[1]);
    let fc = p.s * half * half;
    // Without the ball's own position, which may be lost to it.
    let a = add(p.centres.vector, groove);
    let x = chain(c, p, a, fc);
    let here = Kinetics::by_call::<R>(c, p, groove, kept);
    let mut at = sub(x, p.outer.vector);
    let mut kinetics = Kinetics::by_call::<R>(c, p, groove, at);
    let energy_here = here.energy() - fc * (p.outer.vector[1] + kept[1]);
    let energy = kinetics.energy() - fc * x[1];
    if energy_here < energy && here.loads().iter().all(|x| x.is_finite()) {
        (at, kinetics) = (kept, here);
    }
    while *left > 0 {
        let loads = kinetics.loads();
        let (f, m) = kinetics.forces();
        let r = add(f, loads);
        let force = kinetics.inner.q.at_least(kinetics.outer.q);
        let mut step = bounded(&m, r, T::of(0.1) * p.lo);
        // A ball that swings against the inner race is out of balance, however small the force that swings it.
        let gap = -kinetics.inner.delta;
        let closes = gap >= T::ZERO && dot(step, kinetics.inner.n) < -gap;
        let least = T::of(tuning::SETTLED * tuning::SETTLED) * force * force;
        if dot(r, r) <= least && !closes {
            break;
        }
        // Shortened until the force along the step no longer turns round.
        let (from, before) = (at, dot(r, step));
        for _ in 0..4 {
            at = add(from, step);
            kinetics = Kinetics::by_call::<R>(c, p, groove, at);
            *left = left.saturating_sub(1);
            if dot(add(kinetics.forces().0, loads), step) >= -before {
                break;
            }
            step = scale(T::of(0.4), step);
        }
    }
    at
}

/// The step `m^-1 r`, no longer than `most`. Where a contact gives no hold, the ball moves no further than it would by
/// the other.
fn bounded<T: Real>(m: &Matrix2<T>, r: Pair<T>, most: T) -> Pair<T> {
    let weak = T::of(1e-3) * (m[0][0] + m[1][1]) + T::TINY;
    let (m00, m11) = (m[0][0] + weak, m[1][1] + weak);
    let inverse = T::ONE / (m00 * m11 - m[0][1] * m[1][0]).at_least(T::TINY);
    let step = [
        inverse * (m11 * r[0] - m[0][1] * r[1]),
        inverse * (m00 * r[1] - m[1][0] * r[0]),
    ];
    let length = dot(step, step).sqrt_abs();
    if length > most {
        scale(most / length, step)
    } else {
        step
    }
}
