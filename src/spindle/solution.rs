//! Solution of a spindle.

use crate::ball::kinematics::{Motion, RacewayControlFree, Speed};
use crate::linalg::{Factors, Matrix, add_to, matrix, moved, norm, refer_stiffness, vector};
use crate::real::Real;
use crate::results::Balls;
use crate::results::life::{LifeRating, RatingLife};
use crate::results::margins::Limits;
use crate::results::snapshot::Snapshot;
use crate::results::summary::RowSummary;
use crate::rows::elastic::soften;
use crate::rows::row::Sum;
use crate::solver::problem::{ShaftLoad, radius, stiffness_out, units};
use crate::solver::warm_start::{Reached, WarmStart};
use crate::spindle::Spindle;
use crate::spindle::arrangement::Facing;
use crate::spindle::elastic::any::piece;
use crate::status::{ErrorEstimate, Status};
use core::array::from_fn;
use core::fmt;
use core::marker::PhantomData;
use core::ops::Deref;

/// An equilibrium of a spindle, SI units; loads and displacements refer to the shaft at `x = 0`.
///
/// See [`Spindle`](crate::Spindle) for an example.
pub struct SpindleSolution<
    's,
    T: Real,
    const R: usize,
    const N: usize,
    M: Motion = RacewayControlFree,
    const D: usize = 5,
    const E: usize = 0,
> {
    /// How the solve ended: `Converged`, `PrecisionLimit`, or `IterationLimit` of
    /// [`SpindleSolver::unfinished`](crate::SpindleSolver::unfinished).
    pub status: Status<T>,
    /// Iterations, those after a start included. An iteration condenses every ball once.
    pub iterations: u16,
    /// How far the figures below can be off.
    pub error: ErrorEstimate<T>,
    /// Displacements `dx, dy, dz` (m), `ty, tz` (rad) of the shaft.
    pub displacement: [T; 5],
    /// Forces `Fx, Fy, Fz` (N) and moments `My, Mz` (N m) on the shaft.
    pub load: [T; 5],
    /// Speed of the shaft.
    pub speed: Speed<T>,
    /// Displacement of the spindle's centre.
    u: [T; 5],
    /// Error of that displacement, of an elastic shaft, in the solver's unit of length.
    pub(super) off: T,
    /// Motion of the sleeve, m.
    slide: T,
    /// Loads that have a position; none, where they act at `x = 0`.
    placed: &'s [ShaftLoad<T>],
    pub(super) spindle: &'s Spindle<'s, T, R, N, D, E>,
    pub(super) last: &'s WarmStart<T, R, N, D, E>,
    motion: PhantomData<M>,
}

impl<'s, T: Real, const R: usize, const N: usize, M: Motion, const D: usize, const E: usize>
    SpindleSolution<'s, T, R, N, M, D, E>
{
    /// The solution where `last` stands, which is at `reached` in the solver's units, under the `load`.
    pub(super) fn new(
        spindle: &'s Spindle<'s, T, R, N, D, E>,
        last: &'s WarmStart<T, R, N, D, E>,
        reached: &Reached<T, D>,
        load: [T; 5],
        placed: &'s [ShaftLoad<T>],
    ) -> Self {
        let Spindle { layout, centre, .. } = spindle;
        let unit = layout.rows[0].bearing.c;
        let u = vector(|i| reached.u[i] * units(unit, i).1);
        let slide = if D == 6 {
            reached.u[5] * unit.length
        } else {
            T::ZERO
        };
        let (error, off) = match &reached.error {
            Some(error) if layout.bends() => (*error, error.displacement * norm(&reached.u)),
            _ => (last.errors_of_state(layout, &reached.u), T::ZERO),
        };
        let mut solution = Self {
            status: last.state.attempt.termination.status(),
            iterations: reached.iterations,
            error,
            displacement: moved(-*centre, &u),
            load,
            speed: Speed::rad_per_s(last.omega),
            u,
            off,
            slide,
            placed,
            spindle,
            last,
            motion: PhantomData,
        };
        if layout.bends() && *centre != T::ZERO {
            (solution.displacement, solution.error.displacement) = solution.displaced(T::ZERO);
        }
        solution
    }

    /// Stiffness `dF/du` (rows are forces, columns displacements; N, N m per m, rad) of the shaft at `x = 0` and at
    /// constant speed: the exact tangent, which is not symmetric at speed. A spring keeps its force.
    pub fn stiffness(&self) -> [[T; 5]; 5] {
        self.stiffness_at(T::ZERO)
    }

    /// The stiffness at the position `x` (m) of the shaft.
    #[inline(always)]
    pub fn stiffness_at(&self, x: T) -> [[T; 5]; 5] {
        let (k, near) = self.near(x);
        let unit = self.spindle.layout.rows[0].bearing.c;
        if self.spindle.layout.bends() {
            let mut sum = Sum { k, ..Sum::NONE };
            sum.end(&piece(self.spindle.shaft.sections, unit, x, near));
            return stiffness_out(unit, &sum.k);
        }
        let mut k = stiffness_out(unit, &k);
        refer_stiffness(near - x, &mut k);
        k
    }

    /// Stiffness at the support nearest to `x`, and that position (m), in the solver's units.
    #[inline(always)]
    fn near(&self, x: T) -> (Matrix<T, 5>, T) {
        let (layout, centre) = (&self.spindle.layout, self.spindle.centre);
        let held = |k: &Matrix<T, D>| held(k, layout.has_sleeve::<D>());
        if !layout.bends() {
            return (held(&self.last.tangent::<M::Rule, _>(layout)), centre);
        }
        let near = self.spindle.between_rows(x);
        let k = if near == centre {
            self.last.tangent::<M::Rule, _>(layout)
        } else {
            let joints = self.spindle.joints_towards(near);
            let joints = layout.of_joints(&joints);
            self.last.stiffness_towards::<M::Rule, _>(layout, joints)
        };
        (held(&k), near)
    }

    /// Flexibility of an elastic shaft at its end `x`, beyond the point `near`, m; SI.
    fn flexibility(&self, near: T, x: T) -> Matrix<T, 5> {
        let unit = self.spindle.layout.rows[0].bearing.c;
        let piece = piece(self.spindle.shaft.sections, unit, near, x);
        let columns: Matrix<T, 5> = matrix(|j, i| {
            if i == j {
                T::ONE / units(unit, j).0
            } else {
                T::ZERO
            }
        });
        let columns = columns.map(|load| piece.deflection(&load));
        matrix(|i, j| columns[j][i] * units(unit, i).1)
    }

    /// Compliance at the position `x` (m) of the shaft: displacements (m, rad) per force (N) and moment (N m) that act there,
    /// rows are displacements. One over its diagonal is the stiffness that a force alone meets.
    pub fn compliance_at(&self, x: T) -> [[T; 5]; 5] {
        let (k, near) = self.near(x);
        self.compliance_by(&compliance(&k), near, x)
    }

    /// The compliance at the position `x`, by that of the rows about the point `near`, m.
    fn compliance_by(&self, inverse: &Matrix<T, 5>, near: T, x: T) -> [[T; 5]; 5] {
        let unit = self.spindle.layout.rows[0].bearing.c;
        let d = x - near;
        let of = [unit.length, unit.tilt];
        let per = [T::ONE / unit.force, T::ONE / unit.moment];
        let mut c: Matrix<T, 5> =
            matrix(|i, j| inverse[i][j] * (of[usize::from(i >= 3)] * per[usize::from(j >= 3)]));
        // Displacements at the point, of forces at the point.
        for row in &mut c {
            row[1] += d * row[4];
            row[2] -= d * row[3];
        }
        let (y, z) = (c[4].map(|c| d * c), c[3].map(|c| d * c));
        for j in 0..5 {
            c[1][j] += y[j];
            c[2][j] -= z[j];
        }
        if self.spindle.layout.bends() {
            add_to(&mut c, &self.flexibility(near, x));
        }
        c
    }

    /// Relative errors, estimated, of the diagonal of [`SpindleSolution::compliance_at`].
    ///
    /// They follow from that of the stiffness `K` where rows begin to hold the shaft, and the displacements `C` by forces there:
    /// `sum of abs(C_ij) K_jj^(1/2)`, squared, over the diagonal.
    pub fn compliance_error_at(&self, x: T) -> [T; 5] {
        self.compliance_with_error_at(x).1
    }

    /// [`SpindleSolution::compliance_at`] and [`SpindleSolution::compliance_error_at`], in little more time than the first takes.
    pub fn compliance_with_error_at(&self, x: T) -> ([[T; 5]; 5], [T; 5]) {
        let unit = self.spindle.layout.rows[0].bearing.c;
        let (k, near) = self.near(x);
        let (inverse, lever) = (compliance(&k), (x - near) / radius(unit));
        let c = self.compliance_by(&inverse, near, x);
        let rounding = T::of(8.0) * T::EPSILON;
        let mut sums = [T::ZERO; 5];
        for j in 0..5 {
            let by_force = moved(lever, &vector::<T, 5>(|i| inverse[i][j]));
            sums = vector(|i| sums[i] + by_force[i].abs() * k[j][j].abs().sqrt_abs());
        }
        let errors = vector(|i| {
            let (force, length) = units(unit, i);
            let error = (self.error.stiffness + rounding) * sums[i] * sums[i];
            error * (length / force) / c[i][i].abs() + rounding
        });
        (c, errors)
    }

    /// Displacements `dx, dy, dz` (m), `ty, tz` (rad) of the shaft at the position `x` (m).
    pub fn displacement_at(&self, x: T) -> [T; 5] {
        if !self.spindle.layout.bends() {
            return moved(x, &self.displacement);
        }
        self.displaced(x).0
    }

    /// Relative error, estimated, of [`SpindleSolution::displacement_at`]: of the largest component, tilts taken at the pitch radius.
    pub fn displacement_error_at(&self, x: T) -> T {
        self.displaced(x).1
    }

    /// Displacement at the position `x` (m), and its error.
    fn displaced(&self, x: T) -> ([T; 5], T) {
        let Spindle { layout, centre, .. } = self.spindle;
        let (unit, beyond, deflections) = (
            layout.rows[0].bearing.c,
            x - *centre,
            &self.last.deflections,
        );
        let at_origin = [ShaftLoad {
            position: T::ZERO,
            load: self.load,
        }];
        let loads = if self.placed.is_empty() {
            &at_origin
        } else {
            self.placed
        };
        let (deflection, bent) = self.spindle.deflection_at(x, loads, deflections);
        let rigid = moved(beyond, &self.u);
        let u = vector(|i| rigid[i] + deflection[i] * units(unit, i).1);
        let in_units = |u: &[T; 5]| norm(&vector::<T, 5>(|i| u[i] / units(unit, i).1));
        let lever = T::ONE + beyond.abs() / radius(unit);
        let rounding = T::of(8.0) * T::EPSILON * (lever * in_units(&self.u) + bent);
        let off = if layout.bends() {
            self.off
        } else {
            self.error.displacement * in_units(&self.u)
        };
        let error = (lever * off + rounding) / in_units(&u).at_least(T::TINY);
        (u, error)
    }

    /// Rating life of the set under this load at this speed, each row with its own rating: see [`LifeRating`].
    pub fn rating_life(&self, ratings: &[LifeRating<T>; R]) -> RatingLife<T> {
        let mut weight = T::ZERO;
        let rows = self.spindle.layout.count();
        for (i, rating) in ratings.iter().take(rows).enumerate() {
            weight += rating.weight_of(self.view(i).contact_forces());
        }
        RatingLife::of_weight(weight, self.speed.as_rad_per_s())
    }

    /// The rows at a glance, in their order, each with its own rating: largest contact forces and pressures, contact angles,
    /// preload, share of the load, margins and life.
    pub fn summary(
        &self,
        limits: &Limits<T>,
        ratings: &[LifeRating<T>; R],
    ) -> impl ExactSizeIterator<Item = RowSummary<T>> + use<T, R, N, M, D, E> {
        let mut rows: [_; R] = from_fn(|i| self.row_summary(i, limits, &ratings[i.min(R - 1)]));
        let count = self.spindle.layout.count();
        self.share(rows.get_mut(..count).unwrap_or_default());
        rows.into_iter().take(count)
    }

    /// One row at a glance, the last one beyond it: without preload and share of the load, which [`share`](Self::share) takes of
    /// all rows. For firmware that looks at a row in a tick.
    pub fn row_summary(
        &self,
        row: usize,
        limits: &Limits<T>,
        rating: &LifeRating<T>,
    ) -> RowSummary<T> {
        let last = self.spindle.layout.count().saturating_sub(1);
        RowSummary::of(&self.view(row.min(last)), limits, rating)
    }

    /// Gives rows at a glance their preload and their share of the load.
    pub fn share(&self, rows: &mut [RowSummary<T>]) {
        let axial = vector(|i| rows.get(i).map_or(T::ZERO, |row| row.force[0]));
        RowSummary::share(rows, &self.preloads(&axial));
    }

    /// By how much the sleeve has moved the rows in it towards their balls, m: the closure that the spring makes. 0
    /// without a spring.
    pub fn spring_closure(&self) -> T {
        self.slide
    }

    /// The rows, in their order.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = RowSolution<'_, T, M>> + '_ {
        let rows = self.solved_rows().into_iter();
        rows.take(self.spindle.layout.count())
    }

    fn solved_rows(&self) -> [RowSolution<'_, T, M>; R] {
        let mut rows: [RowSolution<'_, T, M>; R] = from_fn(|i| self.row(i));
        let axial = rows.each_ref().map(|row| row.force[0]);
        for (row, preload) in rows.iter_mut().zip(self.preloads(&axial)) {
            row.preload = preload;
        }
        rows
    }

    /// A copy that borrows nothing.
    pub fn snapshot(&self) -> Snapshot<T, R, N> {
        self.copy()
    }

    /// A copy with the first `K` balls of every row.
    fn copy<const K: usize>(&self) -> Snapshot<T, R, K> {
        Snapshot {
            status: self.status,
            iterations: self.iterations,
            error: self.error,
            displacement: self.displacement,
            load: self.load,
            speed: self.speed,
            stiffness: self.stiffness(),
            spring_closure: self.slide,
            rows: self
                .solved_rows()
                .map(|row| row.view.copy(row.force, row.preload)),
        }
    }

    /// Preload of each row: the axial force that both sides have in common, shared out like the rows' forces.
    fn preloads(&self, axial: &[T; R]) -> [T; R] {
        let side = |i: usize| usize::from(self.spindle.layout.rows[i].mount.facing < T::ZERO);
        let mut sides = [T::ZERO; 2];
        for i in 0..R {
            sides[side(i)] += axial[i];
        }
        let common = sides[0].at_most(sides[1]).at_least(T::ZERO);
        vector(|i| {
            let all = sides[side(i)].at_least(common).at_least(T::TINY);
            axial[i] * (common / all)
        })
    }

    /// Changes of the preloads by those of the forces.
    pub(super) fn preload_changes(&self, forces: &[[T; 5]; R]) -> [T; R] {
        let axial: [T; R] = from_fn(|i| self.row(i).force[0]);
        let side = |i: usize| usize::from(self.spindle.layout.rows[i].mount.facing < T::ZERO);
        let (mut sides, mut changes) = ([T::ZERO; 2], [T::ZERO; 2]);
        for i in 0..self.spindle.layout.count() {
            sides[side(i)] += axial[i];
            changes[side(i)] += forces[i][0];
        }
        let weaker = usize::from(sides[1] < sides[0]);
        if !(sides[weaker] > T::ZERO) {
            return [T::ZERO; R];
        }
        vector(|i| {
            let (all, change) = (sides[side(i)], changes[side(i)]);
            let part = sides[weaker] / all;
            part * forces[i][0] + axial[i] * (changes[weaker] - part * change) / all
        })
    }

    /// The balls of a row.
    #[inline(always)]
    pub(crate) fn view(&self, i: usize) -> Balls<'_, T, M> {
        self.last.row(&self.spindle.layout, i)
    }

    /// A row, its preload left out.
    fn row(&self, i: usize) -> RowSolution<'_, T, M> {
        // As in `WarmStart::row`.
        let i = i.min(R - 1);
        let (spindle, view) = (self.spindle, self.view(i));
        let (sum, force) = self.last.row_force(&spindle.layout, i, &view);
        RowSolution {
            position: spindle.layout.rows[i].position,
            force,
            facing: Facing::of(spindle.layout.rows[i].mount.facing),
            preload: T::ZERO,
            support: spindle.support_of(i),
            view,
            sum,
            stale: self.last.state.stale,
        }
    }
}

/// The stiffness of the shaft's five freedoms, with the force of a spring held if the shaft `is_sprung`.
fn held<T: Real, const D: usize>(k: &Matrix<T, D>, is_sprung: bool) -> Matrix<T, 5> {
    if D == 6 && is_sprung {
        matrix(|i, j| k[i][j] - k[i][5] * k[5][j] / k[5][5])
    } else {
        matrix(|i, j| k[i][j])
    }
}

/// Compliance of a stiffness: its inverse.
pub fn compliance<T: Real>(k: &Matrix<T, 5>) -> Matrix<T, 5> {
    let mut factors = Factors::NONE;
    factors.factor(k, T::ZERO);
    let units: Matrix<T, 5> = matrix(|i, j| if i == j { T::ONE } else { T::ZERO });
    let columns = units.map(|unit| factors.back_substitute(&unit));
    matrix(|i, j| columns[j][i])
}

impl<T: Real, const R: usize, const N: usize, M: Motion, const D: usize, const E: usize> fmt::Debug
    for SpindleSolution<'_, T, R, N, M, D, E>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.snapshot().fmt(f)
    }
}

/// Without the balls, whose arrays are empty.
#[cfg(feature = "defmt")]
impl<T: Real, const R: usize, const N: usize, M: Motion, const D: usize, const E: usize>
    defmt::Format for SpindleSolution<'_, T, R, N, M, D, E>
{
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{}", self.copy::<0>());
    }
}

/// A row of a solved spindle, in its own frame: x points where an axial load presses its balls. SI units.
///
/// See [`Spindle`](crate::Spindle) for an example.
pub struct RowSolution<'s, T: Real, M: Motion = RacewayControlFree> {
    /// Position of its centre on the shaft, m.
    pub position: T,
    /// Forces (N) and moments (N m) of the shaft on its inner ring, about its centre.
    pub force: [T; 5],
    facing: Facing,
    preload: T,
    /// Flexibility of its support, SI.
    support: [T; 5],
    view: Balls<'s, T, M>,
    sum: Sum<T, 5>,
    stale: bool,
}

impl<T: Real, M: Motion> RowSolution<'_, T, M> {
    /// Part of its axial force that is preload, N: the rows of either facing press each other with so much, besides the
    /// load. 0 once one side has lifted off; of rows that all face one way, none is preloaded.
    pub fn preload(&self) -> T {
        self.preload
    }

    /// The row has lifted off: its balls carry no axial force in its direction.
    pub fn is_lifted_off(&self) -> bool {
        !(self.force[0] > T::ZERO)
    }

    /// Stiffness of the row alone, about its centre: `dF/du` (rows are forces; N, N m per m, rad).
    pub fn stiffness(&self) -> [[T; 5]; 5] {
        let mut sum = self.sum;
        if self.stale {
            add_to(&mut sum.k, &self.view.stiffness_change());
        }
        refer_stiffness(self.view.c.plane, &mut sum.k);
        stiffness_out(self.view.c, &sum.k)
    }

    /// Stiffness between the shaft and the housing at the row, in the shaft's frame and about the row's centre: that of the row, and
    /// its support in series. A sleeve is held.
    pub fn stiffness_on_shaft(&self) -> [[T; 5]; 5] {
        let s = self.facing.sign::<T>();
        let mirror = [s, T::ONE, T::ONE, s, s];
        let k = self.stiffness();
        let mut sum = Sum {
            k: matrix(|i, j| mirror[i] * mirror[j] * k[i][j]),
            ..Sum::NONE
        };
        soften(&mut sum, &self.support);
        sum.k
    }
}

/// A row has balls.
impl<'s, T: Real, M: Motion> Deref for RowSolution<'s, T, M> {
    type Target = Balls<'s, T, M>;

    fn deref(&self) -> &Self::Target {
        &self.view
    }
}

/// Without the balls, whose arrays are empty.
impl<T: Real, M: Motion> fmt::Debug for RowSolution<'_, T, M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.view.copy::<0>(self.force, self.preload).fmt(f)
    }
}

/// Without the balls, whose arrays are empty.
#[cfg(feature = "defmt")]
impl<T: Real, M: Motion> defmt::Format for RowSolution<'_, T, M> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{}", self.view.copy::<0>(self.force, self.preload));
    }
}
