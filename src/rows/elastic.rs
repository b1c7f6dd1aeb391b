//! An elastic shaft on elastic supports, as a chain of springs.
//!
//! The shaft has no mass: each side of its centre, the point between the rows that is nearest to `x = 0`, is a chain of rows that
//! hang on each other, the outermost first. A piece of shaft between two rows is springs at its far end: a force there shifts it
//! and turns it with that, by the piece's lean, and a moment turns it further. At the piece's elastic centre, the springs of a
//! slender shaft would cancel the digits of single precision. A support is three springs at its row's centre. The rows' forces and
//! slopes are folded along the chain towards the shaft's centre: rows add up, and springs in series soften what is beyond them. The
//! balance of the shaft is then one in the motion of its section there, and its stiffness is exact. A step of that motion unfolds
//! along the chain to a motion of each row.
//!
//! All in the units of the shaft: forces, stiffness and motions of a row about its centre, distances over `Rp`.

use crate::linalg::{moved, product, refer, vector};
use crate::real::Real;
use crate::rows::row::Sum;

/// A row on an elastic shaft, its support, and the shaft from there to the next row towards its centre.
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
    /// This piece of shaft.
    pub piece: Piece<T>,
    /// There is no row from here to the shaft's centre.
    pub is_last: bool,
}

/// The piece of a shaft between two points.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Piece<T> {
    /// How far its far end is beyond the near one, in `+x`.
    pub length: T,
    /// Turn of the far end with its shift, under a force there.
    pub lean: T,
    /// Flexibility at the far end: by a force, with that turn; by a moment, besides that turn and its shift.
    pub flexibility: [T; 5],
}

impl<T: Real> Piece<T> {
    /// No piece.
    pub const NONE: Self = Self {
        length: T::ZERO,
        lean: T::ZERO,
        flexibility: [T::ZERO; 5],
    };

    /// Not rigid.
    fn is_elastic(&self) -> bool {
        self.flexibility[0] > T::ZERO
    }

    /// Deflection of the far end about the near one, under a load at the far end.
    #[inline(never)]
    pub fn deflection<const D: usize>(&self, load: &[T; D]) -> [T; D] {
        let mut u = *load;
        lean(self.lean, &mut u);
        let mut springs = self.flexibility.iter();
        u = u.map(|force| springs.next().map_or(T::ZERO, |by| *by * force));
        turned(self.lean, &u)
    }
}

/// Counts the turns of a force, in place, beyond the turns that go with a shift, by `lean`.
#[inline(always)]
fn lean<T: Real, const D: usize>(lean: T, force: &mut [T; D]) {
    force[1] += lean * force[4];
    force[2] -= lean * force[3];
}

/// Refers a force, in place, from the far end of a piece and by its lean to the near end.
#[inline(always)]
fn to_near_end<T: Real, const D: usize>(piece: &Piece<T>, force: &mut [T; D]) {
    lean(-piece.lean, force);
    refer(piece.length, force);
}

/// A motion with all of its turns, from one with the turns beyond those of its shift.
#[inline(always)]
fn turned<T: Real, const D: usize>(lean: T, u: &[T; D]) -> [T; D] {
    let mut u = *u;
    u[4] += lean * u[1];
    u[3] -= lean * u[2];
    u
}

/// A row's part of the fold, and what holds the shaft bent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deflection<T, const D: usize> {
    /// Changes of force of the row behind its support, and of all rows from here outwards behind the piece of shaft, at its far end
    /// and by its lean.
    behind_support: Sum<T, D>,
    behind_piece: Sum<T, D>,
    /// Force of the row that bends the shaft, and its change by the last step.
    force: [T; D],
    force_step: [T; D],
    /// Forces of all rows from here outwards that bend the piece, at that end and by that lean, and their change by the last step.
    carried: [T; D],
    carried_step: [T; D],
    /// Deflection of the row, and the one where the balls were condensed last.
    pub now: [T; 5],
    before: [T; 5],
    /// Motion of the row since.
    pub moved: [T; 5],
}

impl<T: Real, const D: usize> Deflection<T, D> {
    /// Of a straight shaft without load.
    pub const NONE: Self = Self {
        behind_support: Sum::NONE,
        behind_piece: Sum::NONE,
        force: [T::ZERO; D],
        force_step: [T::ZERO; D],
        carried: [T::ZERO; D],
        carried_step: [T::ZERO; D],
        now: [T::ZERO; 5],
        before: [T::ZERO; 5],
        moved: [T::ZERO; 5],
    };
}

/// Forces and slopes by the motion of the springs' near end, from those by the motion of their far end.
#[inline(never)]
pub fn soften<T: Real, const D: usize>(sum: &mut Sum<T, D>, springs: &[T; 5]) {
    for (i, flexibility) in springs.iter().enumerate() {
        if !(*flexibility > T::ZERO) {
            continue;
        }
        // Behind a soft spring, a negative stiffness may turn its sign.
        let whole = T::ONE + *flexibility * sum.k[i][i];
        let per = T::ONE
            / if whole.abs() > T::EPSILON {
                whole
            } else {
                T::EPSILON
            };
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

/// Adds the forces and slopes of the row with this number, about its centre, to a sum.
pub type AddRow<'a, T, const D: usize> = &'a mut dyn FnMut(usize, &mut Sum<T, D>);

/// Folds the rows' forces and slopes to the point of the shaft that the chain leads to.
///
/// Forces are those after the next step if that point does not move. Without `deflections`, only slopes have a meaning.
#[inline(never)]
pub fn fold<T: Real, const D: usize>(
    joints: &[Joint<T>],
    deflections: &mut [Deflection<T, D>],
    add_row: AddRow<'_, T, D>,
    sum: &mut Sum<T, D>,
) {
    *sum = Sum::NONE;
    let mut scratch = Deflection::NONE;
    let (mut side, mut carried) = (Sum::NONE, [T::ZERO; D]);
    for joint in joints {
        let deflection = deflections.get_mut(joint.row).unwrap_or(&mut scratch);
        deflection.behind_support = Sum::NONE;
        add_row(joint.row, &mut deflection.behind_support);
        add(&mut deflection.force, T::ONE, &deflection.force_step);
        add(&mut deflection.carried, T::ONE, &deflection.carried_step);
        add(
            &mut deflection.behind_support.force,
            -T::ONE,
            &deflection.force,
        );
        add(&mut carried, T::ONE, &deflection.force);
        soften(&mut deflection.behind_support, &joint.support);
        side.add(&deflection.behind_support);
        let piece = &joint.piece;
        if piece.is_elastic() {
            side.lean(piece.lean);
            lean(piece.lean, &mut carried);
            // Rounding makes the rows' forces differ a little from the force that bends the piece. Behind a soft piece, this little is much.
            side.force = vector(|i| side.force[i] + (carried[i] - deflection.carried[i]));
            soften(&mut side, &piece.flexibility);
            (deflection.behind_piece, carried) = (side, deflection.carried);
        }
        side.move_by(piece);
        to_near_end(piece, &mut carried);
        if joint.is_last {
            sum.add(&side);
            add(&mut sum.force, T::ONE, &carried);
            (side, carried) = (Sum::NONE, [T::ZERO; D]);
        }
    }
}

/// Adds `part` of `b` to `a`.
#[inline(always)]
fn add<T: Real, const D: usize>(a: &mut [T; D], part: T, b: &[T; D]) {
    for (a, b) in a.iter_mut().zip(b) {
        let product = part * *b;
        *a += product;
    }
}

/// Adds `b` to `a`, by a call: where it is seldom done, which spares unrolled loops.
#[inline(never)]
fn add_by_call<T: Real, const D: usize>(a: &mut [T; D], b: &[T; D]) {
    add(a, T::ONE, b);
}

/// Moves the rows along the chain by the step `du` of the section at the shaft's centre, and a relative change `ds` of `omega^2`.
#[inline(never)]
pub fn unfold<T: Real, const D: usize>(
    joints: &[Joint<T>],
    deflections: &mut [Deflection<T, D>],
    slide: &dyn Fn(usize) -> T,
    du: &[T; D],
    ds: T,
) {
    let (mut u, mut bent) = (*du, [T::ZERO; 5]);
    for joint in joints.iter().rev() {
        let Some(deflection) = deflections.get_mut(joint.row) else {
            return;
        };
        if joint.is_last {
            (u, bent) = (*du, [T::ZERO; 5]);
        }
        let piece = &joint.piece;
        (u, bent) = (moved(piece.length, &u), moved(piece.length, &bent));
        if piece.is_elastic() {
            (u, bent) = (turned(-piece.lean, &u), turned(-piece.lean, &bent));
            deflection.carried_step = deflection.behind_piece.after(&u, ds);
            for (i, flexibility) in piece.flexibility.iter().enumerate() {
                let step = deflection.carried_step[i];
                u[i] -= *flexibility * step;
                bent[i] -= *flexibility * (deflection.carried[i] + step);
            }
            (u, bent) = (turned(piece.lean, &u), turned(piece.lean, &bent));
        }
        deflection.force_step = deflection.behind_support.after(&u, ds);
        deflection.before = deflection.now;
        for (i, flexibility) in joint.support.iter().enumerate() {
            deflection.moved[i] = u[i] - *flexibility * deflection.force_step[i];
            let given = *flexibility * deflection.force(i);
            deflection.now[i] = (joint.constant[i] + bent[i]) - given;
        }
        deflection.moved[0] += slide(joint.row);
    }
}

/// Forces of the rows that bend the shaft as it is bent, with the rows' positions.
pub fn forces<'a, T: Real, const D: usize>(
    joints: &'a [Joint<T>],
    deflections: &'a [Deflection<T, D>],
) -> impl Iterator<Item = (T, [T; D])> + 'a {
    let mut beyond = [T::ZERO; D];
    joints.iter().filter_map(move |joint| {
        let (deflection, piece) = (deflections.get(joint.row)?, &joint.piece);
        let mut all = vector(|i| beyond[i] + deflection.force(i));
        if piece.is_elastic() {
            all = vector(|i| deflection.carried[i] + deflection.carried_step[i]);
            lean(-piece.lean, &mut all);
        }
        let force = vector(|i| all[i] - beyond[i]);
        refer(piece.length, &mut all);
        beyond = if joint.is_last { [T::ZERO; D] } else { all };
        Some((joint.position, force))
    })
}

/// Change of the stiffness's diagonal at the shaft's centre by changes of the rows', which are about the rows' centres.
#[inline(never)]
pub fn diagonal<T: Real, const D: usize>(
    joints: &[Joint<T>],
    deflections: &[Deflection<T, D>],
    rows: &[[T; D]],
) -> [T; D] {
    let (mut all, mut side) = ([T::ZERO; D], [T::ZERO; D]);
    for joint in joints {
        let (Some(deflection), Some(row)) = (deflections.get(joint.row), rows.get(joint.row))
        else {
            break;
        };
        let mut change = *row;
        deflection
            .behind_support
            .soften_change(&joint.support, &mut change);
        add_by_call(&mut side, &change);
        let piece = &joint.piece;
        if piece.is_elastic() {
            lean_diagonal(piece.lean, &mut side);
            deflection
                .behind_piece
                .soften_change(&piece.flexibility, &mut side);
            lean_diagonal(piece.lean, &mut side);
        }
        refer_diagonal(piece.length, &mut side);
        if joint.is_last {
            add_by_call(&mut all, &side);
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

/// A diagonal's change with turns beyond the turns of a shift, or back.
#[inline(never)]
fn lean_diagonal<T: Real, const D: usize>(lean: T, k: &mut [T; D]) {
    let square = lean * lean;
    k[1] += square * k[4];
    k[2] += square * k[3];
}

impl<T: Real, const D: usize> Sum<T, D> {
    /// [`lean`] of forces and slopes.
    #[inline(never)]
    fn lean(&mut self, by: T) {
        lean(by, &mut self.force);
        lean(by, &mut self.by_speed);
        for row in &mut self.k {
            lean(by, row);
        }
        for j in 0..D {
            let (y, z) = (self.k[4][j], self.k[3][j]);
            self.k[1][j] += by * y;
            self.k[2][j] -= by * z;
        }
    }

    /// Refers it to the near end of a piece of shaft at whose far end it holds.
    pub fn end(&mut self, piece: &Piece<T>) {
        self.lean(piece.lean);
        soften(self, &piece.flexibility);
        self.move_by(piece);
    }

    #[inline(never)]
    pub fn add(&mut self, other: &Self) {
        add(&mut self.force, T::ONE, &other.force);
        add(&mut self.by_speed, T::ONE, &other.by_speed);
        for (k, other) in self.k.iter_mut().zip(&other.k) {
            add(k, T::ONE, other);
        }
    }

    /// [`to_near_end`] of forces and slopes.
    #[inline(never)]
    fn move_by(&mut self, piece: &Piece<T>) {
        to_near_end(piece, &mut self.force);
        to_near_end(piece, &mut self.by_speed);
        for row in &mut self.k {
            to_near_end(piece, row);
        }
        for j in 0..D {
            let mut column = vector(|i| self.k[i][j]);
            to_near_end::<T, D>(piece, &mut column);
            for i in 1..5 {
                self.k[i][j] = column[i];
            }
        }
    }

    /// Forces after the motion `u` and a relative change `ds` of `omega^2`.
    #[inline(never)]
    fn after(&self, u: &[T; D], ds: T) -> [T; D] {
        let mut force = self.force;
        let slopes = self.k.iter().zip(&self.by_speed);
        for (force, (k, by_speed)) in force.iter_mut().zip(slopes) {
            *force += product(k, u) + ds * *by_speed;
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
    for (j, ((part, k), spring)) in parts.iter_mut().zip(k).zip(springs).enumerate() {
        // Not `parts[i]`, which a profile that inlines less checks.
        let own = if j == i { T::ONE } else { T::ZERO };
        *part = *k * *spring - own;
    }
    product(&parts.map(|part| part * part), far)
}

impl<T: Real, const D: usize> Deflection<T, D> {
    /// Takes the deflection by constant loads alone, from a straight shaft.
    #[inline(never)]
    pub fn straighten(&mut self, constant: &[T; 5]) {
        add(&mut self.now, T::ONE, constant);
        add(&mut self.before, T::ONE, constant);
    }

    /// Goes back to where the balls were condensed.
    #[inline(never)]
    pub fn stay(&mut self) {
        self.now = self.before;
        self.end_step();
    }

    /// Takes no more of the last step than its deflection, which the balls have followed.
    #[inline(never)]
    pub fn end_step(&mut self) {
        (self.force_step, self.carried_step) = ([T::ZERO; D], [T::ZERO; D]);
        self.moved = [T::ZERO; 5];
    }

    /// Force of the row on its support after the last step.
    fn force(&self, i: usize) -> T {
        self.force[i] + self.force_step[i]
    }
}
