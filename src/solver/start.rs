//! Where a solve starts that has no solution next to it.

use super::State;
use super::fallback::continuation;
use super::newton::{End, Outcome, Task};
use crate::axial::AxialRest;
use crate::body::Body;
use crate::constants::{Constants, L0};
use crate::float::Real;
use crate::frame::plane_of;
use crate::kinematics::Rule;
use crate::linalg::{Pair, scale};
use crate::mounting::{Point, Regime};
use crate::rows::{Rows, Stance};
use crate::tuning;

/// What a spring presses the sliding rows with.
fn spring<T: Real, const D: usize>(task: &Task<T, D>) -> T {
    if D == 6 { task.load[5] } else { T::ZERO }
}

/// The axial load that holds some rows in a start, in their own frame, and its side.
struct Pressing<T> {
    force: T,
    side: T,
}

impl<T: Real> Pressing<T> {
    /// Of fixed rows: the axial load less what the sliding ones carry. Rows that do not hold each other have so
    /// much more that radial load and moment do not unload balls at first sight.
    #[inline(never)]
    fn of<S: Rows<T, D>, const D: usize>(rows: &S, task: &Task<T, D>) -> Self {
        let load = &task.load;
        let fixed = rows.fixed();
        let mut own = fixed.seat.facing * load[0];
        if let Some(sliding) = rows.sliding() {
            own -= fixed.seat.facing * sliding.seat.facing * spring(task);
        }
        let side = if own < T::ZERO { -T::ONE } else { T::ONE };
        let mut force = own.abs();
        if D == 6 || fixed.opposed {
            return Self { force, side };
        }
        if D >= 3 {
            force += T::of(0.5) * (load[1] * load[1] + load[2] * load[2]).sqrt();
        }
        if D == 5 {
            force += (load[3] * load[3] + load[4] * load[4]).sqrt();
        }
        Self { force, side }
    }

    /// Axial displacement of the rows at rest that carry this.
    #[inline(never)]
    fn displacement(&self, rows: &Stance<'_, T>) -> T {
        let q = self.force / (rows.balls * rows.seat.force);
        let balls = AxialRest::new(rows.c, &rows.p);
        let loaded = balls.root(T::ONE / T::TINY, q, T::of(1e-6), 24);
        balls.displacement(&loaded.centres, self.side < T::ZERO)
    }
}

/// Displacement of the groove plane: what is given, and else such that fixed and sliding rows are displaced axially by so
/// much in their own frames. Rows that hold each other stay where they are.
#[inline(never)]
fn displaced<T: Real, S: Rows<T, D>, const D: usize>(
    rows: &S,
    task: &Task<T, D>,
    [fixed, sliding]: [T; 2],
) -> [T; D] {
    // A displacement of the shaft from one of a row.
    let shaft = |rows: &Stance<'_, T>, own: T| (own - rows.seat.closure) / rows.seat.length;
    let mut u = [T::ZERO; D];
    let holding = rows.fixed();
    if !holding.opposed {
        u[0] = holding.seat.facing * shaft(&holding, fixed);
    }
    if D == 6
        && let Some(pressed) = rows.sliding()
    {
        u[5] = shaft(&pressed, sliding) - pressed.seat.facing * u[0];
    }
    for (u, held) in u.iter_mut().zip(task.held) {
        *u = held.unwrap_or(*u);
    }
    plane_of(rows.plane(), &u)
}

/// How far fixed and sliding rows are displaced by what presses them, in their own frames.
fn each_by<T: Real, S: Rows<T, D>, const D: usize>(
    rows: &S,
    task: &Task<T, D>,
    displacement: impl Fn(&Stance<'_, T>, &Pressing<T>) -> T,
) -> [T; 2] {
    let sliding = rows.sliding().map_or(T::ZERO, |rows| {
        let spring = Pressing {
            force: spring(task),
            side: T::ONE,
        };
        displacement(&rows, &spring)
    });
    [
        displacement(&rows.fixed(), &Pressing::of(rows, task)),
        sliding,
    ]
}

/// Displacement of the groove plane of rows at rest.
#[inline(never)]
fn pressed<T: Real, S: Rows<T, D>, const D: usize>(rows: &S, task: &Task<T, D>) -> [T; D] {
    let own = each_by(rows, task, |rows, pressing| pressing.displacement(rows));
    displaced(rows, task, own)
}

/// Centre of a ball of the unloaded bearing.
fn unloaded<T: Real>(c: &Constants<T>, _: &Point<T>) -> Pair<T> {
    scale(c.lo, c.n0)
}

/// Every start in the order in which the regime has them, then the fallback.
pub(super) fn at_speed<T: Real, S: Rows<T, D>, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    rows: &mut S,
    task: &Task<T, D>,
    budget: &mut u16,
) -> Outcome<T> {
    let (inertia, size) = (rows.inertia() * rows.weight(), task.size);
    let order = if inertia < T::of(tuning::LIGHT) * size {
        [Start::Rest, Start::Axisymmetric, Start::OuterRace]
    } else if inertia > T::of(tuning::HEAVY) * size {
        [Start::OuterRace, Start::Axisymmetric, Start::Rest]
    } else {
        [Start::Axisymmetric, Start::Rest, Start::OuterRace]
    };
    let mut outcome = Outcome::NONE;
    let [.., last] = order;
    for start in order {
        let mut some = (*budget).min(tuning::ATTEMPT);
        let whole = some == tuning::ATTEMPT;
        *budget -= some;
        match start {
            Start::Rest => from_rest::<T, S, R, D>(state, rows, task, &mut some),
            Start::Axisymmetric => axisymmetric::<T, S, R, D>(state, rows, task),
            Start::OuterRace => from_outer_race::<T, S, R, D>(state, rows, task, &mut some),
        }
        outcome = state.newton::<S, R>(rows, task, T::ZERO, &mut some);
        *budget += some;
        let found = outcome.end.is_solved() || outcome.end == End::Singular;
        if found || (*budget == 0 && !(whole && start == last)) {
            return outcome;
        }
    }
    if *budget > 0 {
        outcome = continuation::<T, S, R, D>(state, rows, task, budget);
    }
    // Every start has had its iterations: no equilibrium was found.
    if outcome.end == End::Unfinished {
        outcome.end = End::Lost;
    }
    outcome
}

/// Where a solve at speed may start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Start {
    Rest,
    Axisymmetric,
    OuterRace,
}

/// Newton's method on the shaft at rest: one attempt, since the problem is convex.
#[inline(never)]
pub(super) fn at_rest<T: Real, S: Rows<T, D>, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    rows: &mut S,
    task: &Task<T, D>,
    budget: &mut u16,
) -> Outcome<T> {
    let (regime, s) = (rows.regime(), rows.inertia());
    rows.take_for(Regime::Rest, s);
    let u = pressed(rows, task);
    state.put(rows, u, unloaded);
    let outcome = state.newton::<S, R>(rows, task, T::ZERO, budget);
    rows.take_for(regime, s);
    outcome
}

/// The solution at rest, roughly, and the balls placed there.
#[inline(never)]
fn from_rest<T: Real, S: Rows<T, D>, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    rows: &mut S,
    task: &Task<T, D>,
    budget: &mut u16,
) {
    at_rest::<T, S, R, D>(state, rows, &task.rough(), budget);
    rows.each(&state.v, |row, _, _| {
        for ball in row.balls.iter_mut() {
            ball.take_up::<R>(row.c, &row.p);
        }
    });
}

/// The axisymmetric state at speed: the first ball of a row stands for all, and Newton's method moves the shaft along the
/// axis.
///
/// This is also where [`AxialSolver`](super::AxialSolver) starts, whose loop is that of every solve.
#[inline(never)]
fn axisymmetric<T: Real, S: Rows<T, D>, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    rows: &mut S,
    task: &Task<T, D>,
) {
    let pressing = Pressing::of(rows, task);
    let fixed = rows.fixed();
    let (along, opposed) = (fixed.seat.facing, fixed.opposed);
    let (facing, sliding) = match rows.sliding() {
        Some(rows) => (rows.seat.facing, rows.balls),
        None => (T::ONE, T::ONE),
    };
    // A ball's mean part: of the fixed rows along the shaft, and of the sliding ones in their own frame, which do not feel
    // the shaft.
    let balls = [fixed.balls, sliding];
    let wanted = [
        along * pressing.side * pressing.force / balls[0],
        spring(task) / balls[1],
    ];
    let longest = T::of(L0 * tuning::FIRST_RADIUS);
    let u = pressed(rows, task);
    state.put(rows, u, unloaded);
    rows.each(&state.v, |row, _, _| {
        if let Some(first) = row.balls.first_mut() {
            first.place::<R>(row.c, &row.p);
        }
    });
    let mut fits = false;
    if task.held[0].is_none() {
        for _ in 0..20 {
            let (mut near, mut force, mut slope) = (true, [T::ZERO; 2], [T::ZERO; 2]);
            rows.each(&state.v, |row, seat, v| {
                let mut one = row.first();
                near &= one.condense_balls::<R>(v, T::ZERO);
                let Some(first) = one.balls.first() else {
                    return;
                };
                let share = first.share();
                let group = usize::from(seat.sliding);
                let part = seat.force * (one.c.balls / balls[group]);
                let along = if seat.sliding { T::ONE } else { seat.facing };
                force[group] += part * (along * share.force[0]);
                slope[group] += part * (seat.length * share.h[0][0]);
            });
            let missing = [wanted[0] - force[0], wanted[1] - force[1]];
            let is_small = |i: usize| missing[i].abs() <= T::of(tuning::ROUGH) * wanted[i].abs();
            if (opposed || is_small(0)) && is_small(1) {
                fits = near && !opposed;
                break;
            }
            let step = |i: usize| {
                let step = missing[i] / slope[i].at_least(T::TINY);
                step.at_least(-longest).at_most(longest)
            };
            let dx = step(0);
            state.v[0] += dx;
            if D == 6 {
                state.v[5] += step(1) - facing * dx;
            }
        }
    }
    copy_first(rows);
    state.anchor(rows);
    // All balls are as the first is: that saves the first pass of the loop.
    state.condensed = fits && task.is_free();
}

/// Has all balls of a row be as its first one is.
// By a call: a copy of a ball is long.
#[inline(never)]
fn copy_first<T: Real, S: Rows<T, D>, const D: usize>(rows: &mut S) {
    rows.each(&[T::ZERO; D], |row, _, _| {
        if let Some((first, others)) = row.balls.split_first_mut() {
            for ball in others {
                ball.clone_from(first);
            }
        }
    });
}

/// Place of a ball that centrifugal force alone holds on the outer race, whose inner contact is about to close: radial.
#[inline(never)]
fn held_outside<T: Real>(c: &Constants<T>, p: &Point<T>) -> T {
    let height = T::of(L0) * c.n0[1];
    let mut radial = p.lo;
    for _ in 0..4 {
        let cos = ((height - radial) / p.li).at_least(T::of(-0.9));
        let mu = (T::ONE - c.tau * cos) / (T::ONE + cos);
        let root = (p.s * mu * mu).cbrt();
        radial = p.lo + root * root;
    }
    radial
}

/// Balls that centrifugal force alone holds on the outer race, and the ring that they carry.
#[inline(never)]
fn from_outer_race<T: Real, S: Rows<T, D>, R: Rule, const D: usize>(
    state: &mut State<T, D>,
    rows: &mut S,
    task: &Task<T, D>,
    budget: &mut u16,
) {
    let own = each_by(rows, task, |rows, pressing| {
        let c = rows.c;
        let root = (pressing.force / (rows.balls * rows.seat.force * c.ki)).cbrt();
        let across = T::of(L0) * c.n0[1] - held_outside(c, &rows.p);
        let long = rows.p.li + root * root;
        let along = (long * long - across * across).at_least(T::ZERO).sqrt();
        pressing.side * along - T::of(L0) * c.n0[0]
    });
    let u = displaced(rows, task, own);
    let (regime, s) = (rows.regime(), rows.inertia());
    rows.take_for(Regime::Outer, s);
    state.put(rows, u, |c, p| [T::ZERO, held_outside(c, p)]);
    state.newton::<S, R>(rows, &task.rough(), T::ZERO, budget);
    rows.take_for(regime, s);
}
