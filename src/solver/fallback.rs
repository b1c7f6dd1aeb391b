//! The fallback: continuation in `omega^2` from the solution at rest.
//!
//! Proved: at rest the equilibrium minimises a convex function, and so does a ball whose inertia loads are frozen.
//! Not proved: inertia has no potential, so that the branch from rest may end or turn back before the speed is
//! reached. The continuation then says that it found no equilibrium, not that there is none.

use super::State;
use super::newton::{End, Outcome, Task};
use super::start::at_rest;
use crate::body::Body;
use crate::float::Real;
use crate::kinematics::Rule;
use crate::mounting::Regime;
use crate::rows::Rows;
use crate::tuning;

/// Follows the branch of equilibria from rest to the speed of the rows, in steps of `omega^2` that grow while they
/// succeed.
#[inline(never)]
pub(super) fn continuation<T: Real, S: Rows<T, D>, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    rows: &mut S,
    task: &Task<T, D>,
    budget: &mut u16,
) -> Outcome<T> {
    let whole = rows.inertia();
    let rough = task.rough();
    at_rest::<T, S, R, D>(state, rows, &rough, budget);
    let mut s = T::ZERO;
    let mut step = (T::of(tuning::LIGHT) * task.size / rows.weight()).at_most(whole);
    let (mut u, mut v) = (state.u, state.v);
    // Whether the balls are at the last solution.
    let mut follows = false;
    while *budget > 0 {
        let next = (s + step).at_most(whole);
        rows.take_for(Regime::Speed, next);
        let mut ds = T::ZERO;
        if follows {
            ds = next / s - T::ONE;
            state.predict(rows.plane(), task, ds);
        } else {
            rows.each(&[T::ZERO; D], |row, _, _| {
                for ball in row.balls.iter_mut() {
                    ball.place::<R>(row.c, &row.p);
                }
            });
        }
        let last = next >= whole;
        let mut some = (*budget).min(tuning::WARM);
        *budget -= some;
        let outcome = state.newton::<S, R>(rows, if last { task } else { &rough }, ds, &mut some);
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
            if step < T::of(1e-3) * (s + T::of(0.01) * whole) {
                break;
            }
            state.put_back(rows, u, v);
            follows = false;
        }
    }
    rows.take_for(Regime::Speed, whole);
    Outcome {
        end: End::Lost,
        ..Outcome::NONE
    }
}
