//! The fallback: continuation in `omega^2` from the solution at rest.
//!
//! Proved: at rest the equilibrium minimises a convex function, and so does a ball whose inertia loads are frozen.
//! Not proved: inertia has no potential, so that the branch from rest may end or turn back before the speed is
//! reached. The continuation then says that it found no equilibrium, not that there is none.

use super::State;
use super::newton::{End, Outcome, Task};
use super::start::at_rest;
use crate::ball::Ball;
use crate::float::Real;
use crate::kinematics::Rule;
use crate::mounting::{Point, Regime};
use crate::place::place;
use crate::ring::Row;
use crate::tuning;

/// Follows the branch of equilibria from rest to the speed of `p`, in steps of `omega^2` that grow while they succeed.
#[inline(never)]
pub(super) fn continuation<T: Real, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    row: &mut Row<'_, T, Ball<T>>,
    task: &Task<T, D>,
    p: &Point<T>,
    budget: &mut u16,
) -> Outcome<T> {
    let rough = task.rough();
    at_rest::<T, _, R, D>(state, row, &rough, p, budget);
    let mut s = T::ZERO;
    let mut step = (T::of(tuning::LIGHT) * task.size / row.c.balls).at_most(p.s);
    let (mut u, mut v) = (state.u, state.v);
    // Whether the balls are at the last solution.
    let mut follows = false;
    while *budget > 0 {
        let next = (s + step).at_most(p.s);
        let there = Point {
            s: next,
            regime: Regime::Speed,
            ..*p
        };
        let mut ds = T::ZERO;
        if follows {
            ds = next / s - T::ONE;
            state.predict(row, task, ds, true);
        } else {
            for ball in row.balls.iter_mut() {
                place::<T, R>(ball, row.c, &there);
            }
        }
        let last = next >= p.s;
        let mut some = (*budget).min(tuning::WARM);
        *budget -= some;
        let outcome =
            state.newton::<_, R>(row, if last { task } else { &rough }, &there, ds, &mut some);
        *budget += some;
        if outcome.end.is_solved() {
            if last {
                return outcome;
            }
            (s, u, v) = (next, state.u, state.v);
            step = T::of(3.0) * step;
            follows = true;
        } else {
            step = T::of(0.25) * step;
            if step < T::of(1e-3) * (s + T::of(0.01) * p.s) {
                break;
            }
            state.put_back(row, &there, u, v);
            follows = false;
        }
    }
    Outcome {
        end: if *budget > 0 {
            End::Lost
        } else {
            End::Unfinished
        },
        ..Outcome::NONE
    }
}
