//! Solution of a bearing.

use crate::ball::kinematics::{Motion, RacewayControlFree, Speed};
use crate::bearing::Bearing;
use crate::linalg::vector;
use crate::real::Real;
use crate::results::Balls;
use crate::results::life::LifeRating;
use crate::results::margins::Limits;
use crate::results::snapshot::Snapshot;
use crate::results::summary::RowSummary;
use crate::solver::problem::{stiffness_out, units};
use crate::solver::warm_start::{Reached, WarmStart};
use crate::status::{ErrorEstimate, Status};
use core::fmt;
use core::ops::Deref;

/// An equilibrium, SI units; loads and displacements refer to the bearing centre.
///
/// See [`Solver`](crate::Solver) for an example, and [`Balls::kinematics`] for the balls.
pub struct Solution<'s, T: Real, const N: usize, M: Motion = RacewayControlFree, const D: usize = 5>
{
    /// How the solve ended: `Converged`, `PrecisionLimit`, or `IterationLimit` of
    /// [`Solver::unfinished`](crate::Solver::unfinished).
    pub status: Status<T>,
    /// Iterations, those after a start included.
    pub iterations: u16,
    /// How far the figures below can be off.
    pub error: ErrorEstimate<T>,
    /// Displacements `dx, dy, dz` (m), `ty, tz` (rad) of the inner ring.
    pub displacement: [T; D],
    /// Forces `Fx, Fy, Fz` (N) and moments `My, Mz` (N m) on the inner ring; the reaction where a displacement was
    /// given.
    pub load: [T; D],
    /// Speed of the shaft.
    pub speed: Speed<T>,
    bearing: &'s Bearing<T, N>,
    last: &'s WarmStart<T, 1, N, D, 0>,
    row: Balls<'s, T, M>,
}

impl<'s, T: Real, const N: usize, M: Motion, const D: usize> Solution<'s, T, N, M, D> {
    /// The solution where `last` stands, which is at `reached` in the solver's units.
    pub(super) fn new(
        bearing: &'s Bearing<T, N>,
        last: &'s WarmStart<T, 1, N, D, 0>,
        reached: &Reached<T, D>,
    ) -> Self {
        let c = &bearing.constants;
        Self {
            status: last.state.attempt.termination.status(),
            iterations: reached.iterations,
            error: last.errors_of_state(&bearing.layout(), &reached.u),
            displacement: vector(|i| reached.u[i] * units(c, i).1),
            load: vector(|i| reached.load[i] * units(c, i).0),
            speed: Speed::rad_per_s(last.omega),
            bearing,
            last,
            row: last.row(&bearing.layout(), 0),
        }
    }

    /// Stiffness `dF/du` (rows are forces, columns displacements; N, N m per m, rad) at constant speed: the exact
    /// tangent, which is not symmetric at speed. That of some freedoms with the others held is a part of it.
    pub fn stiffness(&self) -> [[T; D]; D] {
        let k = self.last.tangent::<M::Rule, _>(&self.bearing.layout());
        stiffness_out(&self.bearing.constants, &k)
    }

    /// The row at a glance: largest contact forces and pressures, contact angles, margins and life.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design, LifeRating, Limits, Settings, Solver, Speed};
    /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// let (bearing, rating) = (Bearing::<f64, 16>::new(&DESIGN)?, LifeRating::<f64>::new(&DESIGN, 16, 13_700.0));
    /// let mut solver = Solver::new();
    /// let (load, speed) = ([300.0, 50.0, 0.0, 0.0, 0.0], Speed::rpm(12_000.0));
    /// let summary = solver.solve(&bearing, load, speed, &Settings::default())?.summary(&Limits::default(), &rating);
    /// println!("{:.0} to {:.0} N on the inner race", summary.inner_force[0], summary.inner_force[1]);
    /// assert!((summary.force[0] - 300.0).abs() < 1e-6 && summary.margins.unloaded == 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn summary(&self, limits: &Limits<T>, rating: &LifeRating<T>) -> RowSummary<T> {
        let mut row = [RowSummary::of(self, limits, rating)];
        RowSummary::share(&mut row, &[T::ZERO]);
        let [row] = row;
        row
    }

    /// A copy that borrows nothing.
    pub fn snapshot(&self) -> Snapshot<T, 1, N, D> {
        self.copy()
    }

    /// A copy with the first `K` balls.
    fn copy<const K: usize>(&self) -> Snapshot<T, 1, K, D> {
        let (_, force) = self.last.row_force(&self.bearing.layout(), 0, &self.row);
        Snapshot {
            status: self.status,
            iterations: self.iterations,
            error: self.error,
            displacement: self.displacement,
            load: self.load,
            speed: self.speed,
            stiffness: self.stiffness(),
            spring_closure: T::ZERO,
            rows: [self.row.copy(force, T::ZERO)],
        }
    }
}

/// A bearing is a row of balls.
impl<'s, T: Real, const N: usize, M: Motion, const D: usize> Deref for Solution<'s, T, N, M, D> {
    type Target = Balls<'s, T, M>;

    fn deref(&self) -> &Self::Target {
        &self.row
    }
}

impl<T: Real, const N: usize, M: Motion, const D: usize> fmt::Debug for Solution<'_, T, N, M, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.snapshot().fmt(f)
    }
}

/// Without the balls, whose arrays are empty.
#[cfg(feature = "defmt")]
impl<T: Real, const N: usize, M: Motion, const D: usize> defmt::Format
    for Solution<'_, T, N, M, D>
{
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{}", self.copy::<0>());
    }
}
