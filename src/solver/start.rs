//! Where a solve starts that has no solution next to it.

use super::State;
use super::fallback::continuation;
use super::newton::{Outcome, Task};
use crate::axial::AxialRest;
use crate::ball::Ball;
use crate::body::Body;
use crate::constants::{Constants, L0};
use crate::float::Real;
use crate::frame::plane_of;
use crate::kinematics::Rule;
use crate::linalg::{Pair, scale};
use crate::mounting::{Point, Regime};
use crate::place::place;
use crate::ring::{Row, in_full};
use crate::tuning;

/// The axial load and so much preload that radial load and moment do not unload balls at first sight, and its side.
fn pressing<T: Real, const D: usize>(load: &[T; D]) -> (T, T) {
    let mut pressing = load[0].abs();
    if D >= 3 {
        pressing += T::of(0.5) * (load[1] * load[1] + load[2] * load[2]).sqrt();
    }
    if D == 5 {
        pressing += (load[3] * load[3] + load[4] * load[4]).sqrt();
    }
    let side = if load[0] < T::ZERO { -T::ONE } else { T::ONE };
    (pressing, side)
}

/// Axial displacement of the bearing at rest whose balls carry `q` axially each.
fn pressed<T: Real>(c: &Constants<T>, p: &Point<T>, q: T, side: T) -> T {
    let balls = AxialRest::new(c, p);
    let loaded = balls.root(T::ONE / T::TINY, q, T::of(1e-6), 24);
    balls.displacement(&loaded.centres, side < T::ZERO)
}

/// Centre of a ball of the unloaded bearing.
fn unloaded<T: Real>(c: &Constants<T>) -> Pair<T> {
    scale(c.lo, c.n0)
}

/// Every start in the order in which the regime has them, then the fallback.
pub(super) fn at_speed<T: Real, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    row: &mut Row<'_, T, Ball<T>>,
    task: &Task<T, D>,
    p: &Point<T>,
    budget: &mut u16,
) -> Outcome<T> {
    if p.regime == Regime::Rest {
        return at_rest::<T, _, R, D>(state, row, task, p, budget);
    }
    let (inertia, size) = (p.s * row.c.balls, task.size);
    let order = if inertia < T::of(tuning::LIGHT) * size {
        [Start::Rest, Start::Axisymmetric, Start::OuterRace]
    } else if inertia > T::of(tuning::HEAVY) * size {
        [Start::OuterRace, Start::Axisymmetric, Start::Rest]
    } else {
        [Start::Axisymmetric, Start::Rest, Start::OuterRace]
    };
    for start in order {
        let mut some = (*budget).min(tuning::ATTEMPT);
        *budget -= some;
        match start {
            Start::Rest => from_rest::<T, R, D>(state, row, task, p, &mut some),
            Start::Axisymmetric => axisymmetric::<T, R, D>(state, row, task, p),
            Start::OuterRace => from_outer_race::<T, R, D>(state, row, task, p, &mut some),
        }
        let outcome = state.newton::<_, R>(row, task, p, T::ZERO, &mut some);
        *budget += some;
        if outcome.end.is_solved() || *budget == 0 {
            return outcome;
        }
    }
    continuation::<T, R, D>(state, row, task, p, budget)
}

/// Where a solve at speed may start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Start {
    Rest,
    Axisymmetric,
    OuterRace,
}

/// Newton's method on the bearing at rest: one attempt, since the problem is convex.
#[inline(never)]
pub(super) fn at_rest<T: Real, B: Body<T>, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    row: &mut Row<'_, T, B>,
    task: &Task<T, D>,
    p: &Point<T>,
    budget: &mut u16,
) -> Outcome<T> {
    let (pressing, side) = pressing(&task.load);
    let p = p.with(Regime::Rest);
    let dx = pressed(row.c, &p, pressing / row.c.balls, side);
    state.put(row, &p, from_given(row.c, task, dx), unloaded(row.c));
    state.newton::<B, R>(row, task, &p, T::ZERO, budget)
}

/// The axial displacement `dx`, and what is given.
fn from_given<T: Real, const D: usize>(c: &Constants<T>, task: &Task<T, D>, dx: T) -> [T; D] {
    let mut u = [T::ZERO; D];
    u[0] = dx;
    for (u, held) in u.iter_mut().zip(task.held) {
        *u = held.unwrap_or(*u);
    }
    plane_of(c, &u)
}

/// The solution at rest, roughly, and the balls placed there.
#[inline(never)]
fn from_rest<T: Real, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    row: &mut Row<'_, T, Ball<T>>,
    task: &Task<T, D>,
    p: &Point<T>,
    budget: &mut u16,
) {
    at_rest::<T, _, R, D>(state, row, &task.rough(), p, budget);
    take_up::<T, R>(row, p);
}

/// Puts balls that were condensed at rest where the speed of `p` has them.
///
/// Those that carry stay in line with both grooves' centres, which is near where their inertia is small.
pub(super) fn take_up<T: Real, R: Rule>(row: &mut Row<'_, T, Ball<T>>, p: &Point<T>) {
    for ball in row.balls.iter_mut() {
        if ball.local.delta > T::ZERO {
            let outer = p.lo + row.c.outer_share * ball.local.delta;
            ball.put(scale(outer, ball.n));
            ball.move_own_references(row.c, p);
        } else {
            place::<T, R>(ball, row.c, p);
        }
    }
}

/// The axisymmetric state at speed: the first ball stands for all, and Newton's method moves the ring along the axis.
///
/// This is also where [`AxialSolver`](super::AxialSolver) starts, whose loop is that of every solve.
#[inline(never)]
fn axisymmetric<T: Real, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    row: &mut Row<'_, T, Ball<T>>,
    task: &Task<T, D>,
    p: &Point<T>,
) {
    let c = row.c;
    let (pressing, side) = pressing(&task.load);
    let q = side * pressing / c.balls;
    let longest = T::of(L0 * tuning::FIRST_RADIUS);
    let u = from_given(c, task, pressed(c, p, q.abs(), side));
    let Some(first) = row.balls.first_mut() else {
        return;
    };
    let mut one = Row {
        c,
        azimuths: row.azimuths.get(..1).unwrap_or_default(),
        balls: core::slice::from_mut(first),
    };
    state.put(&mut one, p, u, unloaded(c));
    for ball in one.balls.iter_mut() {
        place::<T, R>(ball, c, p);
    }
    let mut fits = false;
    if task.held[0].is_none() {
        for _ in 0..20 {
            let near = one.condense_balls::<R>(p, &in_full(&state.v), T::ZERO);
            let Some(ball) = one.balls.first() else {
                return;
            };
            let missing = q - ball.share.force[0];
            if missing.abs() <= T::of(tuning::ROUGH) * q.abs() {
                fits = near;
                break;
            }
            let step = missing / ball.share.h[0][0].at_least(T::TINY);
            let step = step.at_least(-longest).at_most(longest);
            state.v[0] += step;
        }
    }
    if let Some((first, others)) = row.balls.split_first_mut() {
        for ball in others {
            ball.clone_from(first);
        }
    }
    state.anchor(row, p);
    // All balls are as the first is: that saves the first pass of the loop.
    state.condensed = fits && task.is_free();
}

/// Balls that centrifugal force alone holds on the outer race, and the ring that they carry.
#[inline(never)]
fn from_outer_race<T: Real, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    row: &mut Row<'_, T, Ball<T>>,
    task: &Task<T, D>,
    p: &Point<T>,
    budget: &mut u16,
) {
    let c = row.c;
    let (pressing, side) = pressing(&task.load);
    // Cage speed and place of a ball there whose inner contact is about to close.
    let height = T::of(L0) * c.n0[1];
    let mut radial = p.lo;
    for _ in 0..4 {
        let cos = ((height - radial) / p.li).at_least(T::of(-0.9));
        let mu = (T::ONE - c.tau * cos) / (T::ONE + cos);
        let root = (p.s * mu * mu).cbrt();
        radial = p.lo + root * root;
    }
    let root = (pressing / (c.balls * c.ki)).cbrt();
    let (across, long) = (height - radial, p.li + root * root);
    let along = (long * long - across * across).at_least(T::ZERO).sqrt();
    let dx = side * along - T::of(L0) * c.n0[0];
    let p = p.with(Regime::Outer);
    state.put(row, &p, from_given(c, task, dx), [T::ZERO, radial]);
    state.newton::<_, R>(row, &task.rough(), &p, T::ZERO, budget);
}
