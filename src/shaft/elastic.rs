//! An elastic shaft on elastic supports, as a chain of springs.
//!
//! The shaft has no mass: each side of `x = 0` is a chain of rows that hang on each other, the outermost first. A piece of
//! shaft between two rows is three springs at its elastic centre, where a force turns nothing and a moment shifts nothing. A
//! support is three springs at its row's centre. The rows' forces and slopes are folded along the chain towards `x = 0`: rows add
//! up, and springs in series soften what is beyond them. The balance of the shaft is then one in the motion of its section at
//! `x = 0`, and its stiffness there is exact. A step of that motion unfolds along the chain to a motion of each row.
//!
//! All in the units of the shaft: forces, stiffness and motions of a row about its centre, distances over `Rp`.

use crate::linalg::{moved, product, refer};
use crate::real::Real;
use crate::shaft::row::Sum;

/// A row on an elastic shaft, its support, and the shaft from there to the next row towards `x = 0`.
///
/// Flexibilities are those of the five freedoms.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Joint<T> {
    /// Number of the row.
    pub row: usize,
    /// Position of its centre, m.
    pub position: T,
    /// Flexibility of the support.
    pub support: [T; 5],
    /// Deflection that constant loads on the shaft give the row.
    pub constant: [T; 5],
    /// How far the row is beyond the elastic centre of the shaft's piece, and that beyond the next row or `x = 0`, in `+x`.
    pub beyond: [T; 2],
    /// Flexibility of this piece of shaft.
    pub shaft: [T; 5],
    /// There is no row from here to `x = 0`.
    pub is_last: bool,
}

/// A row's part of the fold, and what holds the shaft bent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend<T, const D: usize> {
    /// Changes of force of the row behind its support, and of all rows from here outwards behind the piece of shaft, at its
    /// elastic centre.
    held: Sum<T, D>,
    outer: Sum<T, D>,
    /// Force of the row that bends the shaft, and its change by the last step.
    force: [T; D],
    force_step: [T; D],
    /// These forces of all rows from here outwards, at the elastic centre.
    bending: [T; D],
    /// Deflection of the row, and where the balls were condensed last.
    pub deflection: [T; 5],
    before: [T; 5],
    /// Motion of the row since.
    pub moved: [T; 5],
}

impl<T: Real, const D: usize> Bend<T, D> {
    /// Of a straight shaft without load.
    pub const NONE: Self = Self {
        held: Sum::NONE,
        outer: Sum::NONE,
        force: [T::ZERO; D],
        force_step: [T::ZERO; D],
        bending: [T::ZERO; D],
        deflection: [T::ZERO; 5],
        before: [T::ZERO; 5],
        moved: [T::ZERO; 5],
    };
}

/// Puts the joints into the order of the chain that leads to the position `x`, m: those below it, then those above, the outermost
/// first.
#[inline(never)]
pub fn order<T: Real>(joints: &mut [Joint<T>], x: T) {
    let is_before = |a: T, b: T| match (a < x, b < x) {
        (true, true) => a < b,
        (false, false) => a > b,
        (is_below, _) => is_below,
    };
    let mut rest = joints;
    while let Some((first, others)) = rest.split_first_mut() {
        for other in others.iter_mut() {
            if is_before(other.position, first.position) {
                core::mem::swap(first, other);
            }
        }
        rest = others;
    }
}

/// Forces and slopes by the motion of the springs' near end, from those by the motion of their far end.
#[inline(never)]
pub fn soften<T: Real, const D: usize>(sum: &mut Sum<T, D>, springs: &[T; 5]) {
    for (i, flexibility) in springs.iter().enumerate() {
        if !(*flexibility > T::ZERO) {
            continue;
        }
        // A row that pushes harder the further it moves could take more than all of a spring.
        let per = T::ONE / (T::ONE + *flexibility * sum.k[i][i]).at_least(T::EPSILON);
        let taken = *flexibility * per;
        let (k, force, by_speed) = (sum.k[i], sum.force[i], sum.by_speed[i]);
        let forces = sum.force.iter_mut().zip(&mut sum.by_speed);
        for (j, (row, (f, s))) in sum.k.iter_mut().zip(forces).enumerate() {
            if j == i {
                continue;
            }
            let column = row[i];
            let part = taken * column;
            for (k, of_spring) in row.iter_mut().zip(&k) {
                let product = part * *of_spring;
                *k -= product;
            }
            row[i] = per * column;
            *f -= part * force;
            *s -= part * by_speed;
        }
        sum.k[i] = k.map(|k| per * k);
        (sum.force[i], sum.by_speed[i]) = (per * force, per * by_speed);
    }
}

/// Adds a row's forces and slopes about its centre to a sum of none.
pub type AddRow<'a, T, const D: usize> = &'a mut dyn FnMut(&Joint<T>, &mut Sum<T, D>);

/// Folds the rows' forces and slopes to the point of the shaft that the chain leads to.
///
/// Forces are those that the balance after the next step has, at no motion of that point. Where there are no `bends`, slopes alone
/// mean something.
#[inline(never)]
pub fn fold<T: Real, const D: usize>(
    joints: &[Joint<T>],
    bends: &mut [Bend<T, D>],
    add_row: AddRow<'_, T, D>,
    sum: &mut Sum<T, D>,
) {
    *sum = Sum::NONE;
    let mut scratch = Bend::NONE;
    let (mut side, mut bending) = (Sum::NONE, [T::ZERO; D]);
    for joint in joints {
        let bend = bends.get_mut(joint.row).unwrap_or(&mut scratch);
        bend.held = Sum::NONE;
        add_row(joint, &mut bend.held);
        add(&mut bend.force, T::ONE, &bend.force_step);
        add(&mut bend.held.force, -T::ONE, &bend.force);
        add(&mut bending, T::ONE, &bend.force);
        soften(&mut bend.held, &joint.support);
        side.add(&bend.held);
        let [row, centre] = joint.beyond;
        side.move_by(row);
        refer(row, &mut bending);
        soften(&mut side, &joint.shaft);
        (bend.outer, bend.bending) = (side, bending);
        side.move_by(centre);
        refer(centre, &mut bending);
        if joint.is_last {
            sum.add(&side);
            add(&mut sum.force, T::ONE, &bending);
            (side, bending) = (Sum::NONE, [T::ZERO; D]);
        }
    }
}

/// Adds `part` of `b` to `a`. By a call, which spares 2 kB of unrolled loops.
#[inline(never)]
pub fn add<T: Real, const D: usize>(a: &mut [T; D], part: T, b: &[T; D]) {
    for (a, b) in a.iter_mut().zip(b) {
        let product = part * *b;
        *a += product;
    }
}

/// [`product`] by a call.
#[inline(never)]
fn dot<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> T {
    product(a, b)
}

/// Moves the rows along the chain by the step `du` of the section at `x = 0`, and a relative change `ds` of `omega^2`.
#[inline(never)]
pub fn unfold<T: Real, const D: usize>(
    joints: &[Joint<T>],
    bends: &mut [Bend<T, D>],
    slide: &dyn Fn(usize) -> T,
    du: &[T; D],
    ds: T,
) {
    let (mut u, mut deflection) = (*du, [T::ZERO; 5]);
    for joint in joints.iter().rev() {
        let Some(bend) = bends.get_mut(joint.row) else {
            return;
        };
        if joint.is_last {
            (u, deflection) = (*du, [T::ZERO; 5]);
        }
        let [row, centre] = joint.beyond;
        (u, deflection) = (moved(centre, &u), moved(centre, &deflection));
        let change = bend.outer.after(&u, ds);
        for (i, flexibility) in joint.shaft.iter().enumerate() {
            u[i] -= *flexibility * change[i];
            deflection[i] -= *flexibility * (bend.bending[i] + change[i]);
        }
        (u, deflection) = (moved(row, &u), moved(row, &deflection));
        bend.force_step = bend.held.after(&u, ds);
        bend.before = bend.deflection;
        for (i, flexibility) in joint.support.iter().enumerate() {
            bend.moved[i] = u[i] - *flexibility * bend.force_step[i];
            let given = *flexibility * bend.force(i);
            bend.deflection[i] = (joint.constant[i] + deflection[i]) - given;
        }
        bend.moved[0] += slide(joint.row);
    }
}

/// Change of the stiffness's diagonal at `x = 0` by changes of the rows', which are about the rows' centres.
#[inline(never)]
pub fn diagonal<T: Real, const D: usize>(
    joints: &[Joint<T>],
    bends: &[Bend<T, D>],
    rows: &[[T; D]],
) -> [T; D] {
    let (mut all, mut side) = ([T::ZERO; D], [T::ZERO; D]);
    for joint in joints {
        let (Some(bend), Some(row)) = (bends.get(joint.row), rows.get(joint.row)) else {
            break;
        };
        let mut change = *row;
        bend.held.soften_change(&joint.support, &mut change);
        add(&mut side, T::ONE, &change);
        refer_diagonal(joint.beyond[0], &mut side);
        bend.outer.soften_change(&joint.shaft, &mut side);
        refer_diagonal(joint.beyond[1], &mut side);
        if joint.is_last {
            add(&mut all, T::ONE, &side);
            side = [T::ZERO; D];
        }
    }
    all
}

/// Refers a diagonal's change to a point that is nearer to the origin by `distance`.
#[inline(never)]
fn refer_diagonal<T: Real, const D: usize>(distance: T, k: &mut [T; D]) {
    let square = distance * distance;
    k[4] += square * k[1];
    k[3] += square * k[2];
}

impl<T: Real, const D: usize> Sum<T, D> {
    #[inline(never)]
    pub fn add(&mut self, other: &Self) {
        add(&mut self.force, T::ONE, &other.force);
        add(&mut self.by_speed, T::ONE, &other.by_speed);
        for (k, other) in self.k.iter_mut().zip(&other.k) {
            add(k, T::ONE, other);
        }
    }

    /// [`Sum::refer`] by a call.
    #[inline(never)]
    fn move_by(&mut self, distance: T) {
        self.refer(distance);
    }

    /// Forces after the motion `u` and a relative change `ds` of `omega^2`.
    #[inline(never)]
    fn after(&self, u: &[T; D], ds: T) -> [T; D] {
        let mut force = self.force;
        let slopes = self.k.iter().zip(&self.by_speed);
        for (force, (k, by_speed)) in force.iter_mut().zip(slopes) {
            *force += dot(k, u) + ds * *by_speed;
        }
        force
    }

    /// Softens a change of the diagonal as the springs have softened these slopes.
    #[inline(never)]
    fn soften_change(&self, springs: &[T; 5], change: &mut [T; D]) {
        let far = *change;
        for (i, (near, k)) in change.iter_mut().zip(&self.k).enumerate() {
            *near = softened(i, k, springs, &far);
        }
    }
}

/// Change of the diagonal's element `i` behind springs, from that beyond them; `k` is the row of the slopes behind them.
#[inline(never)]
fn softened<T: Real, const D: usize>(i: usize, k: &[T; D], springs: &[T; 5], far: &[T; D]) -> T {
    let mut parts = [T::ZERO; D];
    parts[i] = -T::ONE;
    for ((part, k), spring) in parts.iter_mut().zip(k).zip(springs) {
        let taken = *k * *spring;
        *part += taken;
    }
    dot(&parts.map(|part| part * part), far)
}

impl<T: Real, const D: usize> Bend<T, D> {
    /// Bends by constant loads alone, from straight.
    pub fn straighten(&mut self, constant: &[T; 5]) {
        add(&mut self.deflection, T::ONE, constant);
        add(&mut self.before, T::ONE, constant);
    }

    /// Goes back to where the balls were condensed.
    #[inline(never)]
    pub fn stay(&mut self) {
        self.deflection = self.before;
        self.end_step();
    }

    /// Takes no more of the last step than its deflection, which the balls have followed.
    #[inline(never)]
    pub fn end_step(&mut self) {
        (self.force_step, self.moved) = ([T::ZERO; D], [T::ZERO; 5]);
    }

    /// Force of the row on the shaft after the last step.
    pub fn force(&self, i: usize) -> T {
        self.force[i] + self.force_step[i]
    }
}
