//! How an equilibrium changes with the closures of rows or the force of a spring: exact, by its tangent.

use crate::ball::kinematics::Motion;
use crate::linalg::{Factors, moved, product, refer, vector};
use crate::real::Real;
use crate::rows::Placed;
use crate::rows::elastic::{Deflection, fold, unfold};
use crate::rows::row::Sum;
use crate::solver::problem::units;
use crate::spindle::Spindle;
use crate::spindle::solution::SpindleSolution;
use core::array::from_fn;

/// How an equilibrium changes, per metre of closure or per newton of the spring, while loads, speed and growth stay:
/// [`SpindleSolution::by_closures`], [`SpindleSolution::by_spring`].
#[derive(Debug, Clone, Copy)]
pub struct SpindleChange<
    's,
    T: Real,
    const R: usize,
    const N: usize,
    const D: usize = 5,
    const E: usize = 0,
> {
    spindle: &'s Spindle<'s, T, R, N, D, E>,
    /// Motion of the spindle's centre, SI.
    u: [T; 5],
    /// Forces that bend the shaft, in the solver's units, by a change of `1 / per`.
    deflections: [Deflection<T, D>; E],
    per: T,
    forces: [[T; 5]; R],
    preloads: [T; R],
}

impl<T: Real, const R: usize, const N: usize, const D: usize, const E: usize>
    SpindleChange<'_, T, R, N, D, E>
{
    /// Displacements `dx, dy, dz`, `ty, tz` of the shaft at the position `x` (m): m, rad per m or per N.
    pub fn displacement_at(&self, x: T) -> [T; 5] {
        let (spindle, rigid) = (self.spindle, moved(x - self.spindle.centre, &self.u));
        let unit = spindle.layout.rows[0].bearing.c;
        let bent = spindle.deflection_by_rows(x, &self.deflections);
        vector(|i| rigid[i] + self.per * bent[i] * units(unit, i).1)
    }

    /// Forces and moments of the shaft on each row's inner ring, in the row's own frame as [`RowSolution::force`]: N, N m per m or
    /// per N.
    ///
    /// [`RowSolution::force`]: crate::RowSolution::force
    pub fn forces(&self) -> impl ExactSizeIterator<Item = [T; 5]> + '_ {
        self.forces.into_iter().take(self.spindle.layout.count())
    }

    /// Preload of each row, as [`RowSolution::preload`](crate::RowSolution::preload): N per m or per N.
    pub fn preloads(&self) -> impl ExactSizeIterator<Item = T> + '_ {
        self.preloads.into_iter().take(self.spindle.layout.count())
    }
}

impl<'s, T: Real, const R: usize, const N: usize, M: Motion, const D: usize, const E: usize>
    SpindleSolution<'s, T, R, N, M, D, E>
{
    /// How the equilibrium changes with closures of the rows in these proportions, which press the balls harder: per metre of a
    /// closure of 1. A row has 0 if its own closure stays. Rows that slide give way to a closure that all of them have.
    ///
    /// `[1.0; R]` is a closure that all rows share. A spacer between two rows closes each by half of what is ground off.
    ///
    /// ```
    /// use spindle_bearing::{Arrangement, Bearing, Design, Facing, Mounted, Preload, Settings, Speed, Spindle, SpindleSolver};
    /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// let bearing = Bearing::<f64, 16>::new(&DESIGN)?;
    /// let row = |x, facing| Mounted::new(&bearing, x, facing).with(Preload::Force(250.0));
    /// let pair = Spindle::new(Arrangement::BackToBack, [row(0.0, Facing::PlusX), row(0.05, Facing::MinusX)])?;
    /// let mut solver = SpindleSolver::<f64, 2, 16>::new();
    /// let solution = solver.solve(&pair, [100.0, 50.0, 0.0, 0.0, 0.0], Speed::rpm(9000.0), &Settings::default())?;
    /// let change = solution.by_closures([1.0, 0.0]);
    /// // A micrometre at the front row: newtons of preload, and micrometres at the nose.
    /// let [preload, _] = [0, 1].map(|row| 1e-6 * change.preloads().nth(row).unwrap_or_default());
    /// let [axial, ..] = change.displacement_at(-0.03);
    /// assert!(preload > 10.0 && axial < 0.0 && axial > -1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn by_closures(&self, closures: [T; R]) -> SpindleChange<'s, T, R, N, D, E> {
        let rows = &self.spindle.layout.rows;
        let closures = vector(|i| closures[i] * rows[i].mount.length);
        self.change(&closures, T::ZERO, T::ONE / rows[0].bearing.c.length)
    }

    /// How the equilibrium changes with the force of the spring; not at all without one.
    pub fn by_spring(&self) -> SpindleChange<'s, T, R, N, D, E> {
        let layout = &self.spindle.layout;
        let is_sprung = D == 6 && layout.sliding.is_some();
        let force = if is_sprung { T::ONE } else { T::ZERO };
        let per = T::ONE / layout.rows[0].bearing.c.force;
        self.change(&[T::ZERO; R], force, per)
    }

    /// The change by these closures, in units of the rows, and this force of the spring; all of it times `per`.
    #[inline(never)]
    fn change(&self, closures: &[T; R], spring: T, per: T) -> SpindleChange<'s, T, R, N, D, E> {
        let (spindle, last) = (self.spindle, self.last);
        let layout = &spindle.layout;
        let of_row = |number: usize| {
            let own = last.slopes::<M::Rule, true>(layout, number, true);
            // The balls see a closure as an axial motion of their ring.
            let closure = closures[number.min(R - 1)];
            let force = own.k.map(|k| closure * k[0]);
            Sum { force, ..own }
        };
        let (mut sum, mut deflections) = (Sum::<T, D>::NONE, [Deflection::NONE; E]);
        let mut add_row = |number: usize, sum: &mut Sum<T, D>| {
            if let Some(Placed { mount, .. }) = layout.rows.get(number) {
                mount.assemble(&mut of_row(number), sum);
            }
        };
        if layout.bends() {
            let deflections = layout.of_joints_mut(&mut deflections);
            fold(layout.joints(), deflections, &mut add_row, &mut sum);
        } else {
            (0..layout.count()).for_each(|number| add_row(number, &mut sum));
        }
        if D == 6 && !layout.has_sleeve::<D>() {
            sum.k[D - 1][D - 1] = sum.k[0][0];
        }
        let mut force = sum.force.map(|force| -force);
        if D == 6 {
            force[D - 1] += spring;
        }
        let mut factors = Factors::NONE;
        factors.factor(&sum.k, T::ZERO);
        let du = factors.back_substitute(&force);
        if layout.bends() {
            let slide = |row: usize| match layout.rows.get(row) {
                Some(row) if D == 6 && row.mount.sliding => row.mount.facing * du[D - 1],
                _ => T::ZERO,
            };
            let deflections = layout.of_joints_mut(&mut deflections);
            unfold(layout.joints(), deflections, &slide, &du, T::ZERO);
        }
        let plane = moved(layout.plane, &du);
        let forces: [[T; 5]; R] = from_fn(|i| {
            let Placed { bearing, mount, .. } = &layout.rows[i];
            let own = of_row(i);
            let du = match layout.of_joints(&deflections).get(i) {
                Some(deflection) => mount.of_centre(&deflection.moved),
                None => mount.motion::<D, true>(&plane),
            };
            let mut force: [T; 5] = vector(|j| own.force[j] + product(&own.k[j], &du));
            refer(bearing.c.plane, &mut force);
            vector(|j| per * force[j] * units(bearing.c, j).0)
        });
        let unit = layout.rows[0].bearing.c;
        SpindleChange {
            spindle,
            u: vector(|i| per * du[i] * units(unit, i).1),
            deflections,
            per,
            forces,
            preloads: self.preload_changes(&forces),
        }
    }
}
