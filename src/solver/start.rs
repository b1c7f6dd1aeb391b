//! Cold start: the shaft under the axial load alone.

use crate::ball::contact::{Point, to_grid};
use crate::bearing::{Constants, L0};
use crate::linalg::{moved, vector};
use crate::real::Real;
use crate::rows::elastic::Deflection;
use crate::rows::row::Row;
use crate::rows::{Group, Rows};
use crate::solver::problem::Problem;
use crate::solver::state::State;

/// Halvings of the range of an angle, to 2e-5 of it.
const BISECTIONS: u8 = 16;

/// Force of the spring on the sliding rows.
fn spring<T: Real, const D: usize>(problem: &Problem<T, D>) -> T {
    if D == 6 { problem.load[5] } else { T::ZERO }
}

/// Axial load that presses a group of rows in a start: magnitude, and side in the rows' own frame.
struct Pressing<T> {
    force: T,
    side: T,
}

impl<T: Real> Pressing<T> {
    /// Of fixed rows: the axial load less the sliding rows' part. Where fixed rows all face one way, half the radial load and the
    /// moment are added, so that no ball is unloaded at first.
    #[inline(never)]
    fn of<const R: usize, const SET: bool, const E: usize, const D: usize>(
        rows: &Rows<'_, T, R, SET, E, D>,
        fixed: &Row<'_, T>,
        problem: &Problem<T, D>,
    ) -> Self {
        let load = &problem.load;
        let mut own = fixed.mount.facing * load[0];
        if let Some(sliding) = rows.layout.sliding.and_then(|group| rows.first_of(&group)) {
            own -= fixed.mount.facing * sliding.mount.facing * spring(problem);
        }
        let side = if own < T::ZERO { -T::ONE } else { T::ONE };
        let mut force = own.abs();
        if rows.layout.has_sleeve::<D>() || rows.layout.fixed.opposed {
            return Self { force, side };
        }
        if D >= 3 {
            force += T::of(0.5) * (load[1] * load[1] + load[2] * load[2]).sqrt_abs();
        }
        if D >= 5 {
            force += (load[3] * load[3] + load[4] * load[4]).sqrt_abs();
        }
        Self { force, side }
    }

    /// Axial displacement of the rows that carry this at their speed, in their own frame.
    fn displacement(&self, row: &Row<'_, T>, group: &Group<T>) -> T {
        // Of none, the contacts have no direction.
        let q = (self.force / (group.balls * row.mount.force)).at_least(T::EPSILON);
        let [axial, _] = row.c.n0.map(|n| T::of(L0) * n);
        self.side * distance(row.c, row.p, q) - axial - row.p.growth.axial
    }
}

/// Axial distance of the grooves' centres under the axial force `q` of a ball, friction left out.
///
/// The inner contact angle is the one unknown, by the tangent of its half. Forces follow from it, deformations from
/// those. The radial distance that both contacts span falls as the angle grows, so that bisection finds it.
#[inline(never)]
fn distance<T: Real>(c: &Constants<T>, p: &Point<T>, q: T) -> T {
    let one = T::ONE;
    let radial = T::of(L0) * c.n0[1] + p.growth.radial;
    let (mut axial, mut low, mut high) = (T::ZERO, T::ZERO, one);
    // Square of the cage speed over the shaft's, which follows the angle.
    let mut cage = T::of(0.2);
    for _ in 0..BISECTIONS {
        let t = T::of(0.5) * (low + high);
        let per = one / (one + t * t);
        let (sin, cos) = ((t + t) * per, (one - t * t) * per);
        let inner = q / sin;
        let outwards = inner * cos + p.s * cage;
        let outer = (q * q + outwards * outwards).at_least(T::TINY).sqrt_abs();
        let together = (outwards * cos + q * sin) / outer;
        let mu = (one - c.tau * cos) / (one + together).at_least(T::of(0.1));
        cage = mu * mu;
        let deformed = |q: T| {
            let root = q.cbrt_or_zero();
            root * root
        };
        let ri = p.li + deformed(inner / c.ki);
        let across = (p.lo + deformed(outer)) / outer;
        axial = across * q + ri * sin;
        if across * outwards + ri * cos > radial {
            low = t;
        } else {
            high = t;
        }
    }
    axial
}

/// Displacement of the groove plane: as given, and else such that fixed and sliding rows carry the axial load and the
/// spring. Rows that hold each other stay where they are.
#[inline(never)]
fn displaced<T: Real, const R: usize, const SET: bool, const E: usize, const D: usize>(
    rows: &Rows<'_, T, R, SET, E, D>,
    problem: &Problem<T, D>,
) -> [T; D] {
    // A displacement of the shaft from one of a row.
    let shifted = |row: &Row<'_, T>, group: &Group<T>, pressed: Pressing<T>| {
        (pressed.displacement(row, group) - row.mount.closure) / row.mount.length
    };
    let mut u = [T::ZERO; D];
    let fixed = &rows.layout.fixed;
    if !fixed.opposed
        && let Some(holding) = rows.first_of(fixed)
    {
        let pressed = Pressing::of(rows, holding, problem);
        u[0] = holding.mount.facing * shifted(holding, fixed, pressed);
    }
    if D == 6
        && let Some(group) = &rows.layout.sliding
        && let Some(sliding) = rows.first_of(group)
    {
        let (force, side) = (spring(problem), T::ONE);
        u[5] = shifted(sliding, group, Pressing { force, side }) - sliding.mount.facing * u[0];
    }
    // Beyond an overhang, the first steps lead to them.
    let held = problem
        .prescribed
        .iter()
        .take(if problem.overhang::<E>().is_some() {
            1
        } else {
            D
        });
    for (u, held) in u.iter_mut().zip(held) {
        *u = held.unwrap_or(*u);
    }
    moved(rows.layout.plane, &u)
}

/// Puts the shaft where the axial load alone would. The first pass puts the balls there, all balls of a row alike.
#[inline(never)]
pub(super) fn start<T: Real, const R: usize, const SET: bool, const E: usize, const D: usize>(
    state: &mut State<T, D>,
    rows: &mut Rows<'_, T, R, SET, E, D>,
    problem: &Problem<T, D>,
) {
    let u = displaced(rows, problem);
    // Offsets count from the axial part.
    state.u = vector(|i| if i % 5 == 0 { to_grid(u[i]) } else { T::ZERO });
    state.v = vector(|i| u[i] - state.u[i]);
    for deflection in rows.deflections() {
        *deflection = Deflection::NONE;
    }
    rows.each(&state.u, |row, u| {
        row.p.start(row.c, u[0] + row.mount.closure)
    });
    let layout = rows.layout;
    for joint in layout.joints() {
        if let Some(deflection) = rows.deflections().get_mut(joint.row) {
            deflection.straighten(&joint.constant);
        }
    }
    state.attempt.pass.starts = true;
}
