//! Solution of a bearing.

use crate::ball::kinematics::{Full, Motion, Speed};
use crate::ball::report::{BallKinematics, BallState};
use crate::bearing::Bearing;
use crate::linalg::vector;
use crate::real::Real;
use crate::results::View;
use crate::results::frequencies::Frequencies;
use crate::results::life::{LifeRating, RatingLife};
use crate::results::margins::{Limits, Margins};
#[cfg(feature = "serde")]
use crate::results::serialize;
use crate::results::summary::RowSummary;
use crate::solver::problem::{stiffness_out, units};
use crate::solver::state::ErrorEstimate;
use crate::solver::warm_start::{Reached, WarmStart};
use crate::status::Status;
use core::fmt;
use core::marker::PhantomData;

/// An equilibrium, SI units; loads and displacements refer to the bearing centre.
///
/// See [`Solver`](crate::Solver) for an example, and [`Solution::kinematics`] for the balls.
pub struct Solution<'s, T: Real, const N: usize, M: Motion = Full, const D: usize = 5> {
    /// How the solve ended: `Converged`, `PrecisionLimit`, or `IterationLimit` of
    /// [`Solver::unfinished`](crate::Solver::unfinished).
    pub status: Status<T>,
    /// Iterations, those of starts included.
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
    last: &'s WarmStart<T, 1, N, D>,
    motion: PhantomData<M>,
}

impl<'s, T: Real, const N: usize, M: Motion, const D: usize> Solution<'s, T, N, M, D> {
    /// The solution where `last` stands, which is at `reached` in the solver's units.
    pub(super) fn new(
        bearing: &'s Bearing<T, N>,
        last: &'s WarmStart<T, 1, N, D>,
        reached: &Reached<T, D>,
    ) -> Self {
        let c = &bearing.constants;
        Self {
            status: last.state.attempt.termination.status(),
            iterations: reached.iterations,
            error: last.state.errors(&reached.u, last.points[0].s * c.balls),
            displacement: vector(|i| reached.u[i] * units(c, i).1),
            load: vector(|i| reached.load[i] * units(c, i).0),
            speed: last.speed,
            bearing,
            last,
            motion: PhantomData,
        }
    }

    /// Stiffness `dF/du` (rows are forces, columns displacements; N, N m per m, rad) at constant speed: the exact
    /// tangent, which is not symmetric at speed. That of some freedoms with the others held is a part of it.
    pub fn stiffness(&self) -> [[T; D]; D] {
        let k = self.last.tangent::<M::Rule, _>(&self.bearing.layout());
        stiffness_out(&self.bearing.constants, &k)
    }

    /// The row of balls.
    #[inline(always)]
    pub(crate) fn view(&self) -> View<'_, T, M::Rule> {
        self.last.view::<M::Rule, _>(&self.bearing.layout(), 0)
    }

    /// States of the balls, in the order of their azimuths.
    pub fn balls(&self) -> impl ExactSizeIterator<Item = BallState<T>> + '_ {
        self.view().states()
    }

    /// Forces on the inner race alone, N, in the order of the balls: without the cost of contact angles.
    pub fn inner_forces(&self) -> impl ExactSizeIterator<Item = T> + '_ {
        self.view().contact_forces().map(|(inner, _)| inner)
    }

    /// Cage speed `omega_m` of every ball about the bearing's axis, rad/s, in the order of the balls.
    ///
    /// The contact angles of a loaded bearing differ, and with them the speeds: the cage turns at about their mean. A
    /// ball without contact has the speed that its contact angles would give it.
    pub fn cage_speeds(&self) -> impl ExactSizeIterator<Item = T> + '_ {
        self.view().cage_speeds()
    }

    /// How every ball turns, and how its contacts are pressed, in the order of the balls.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed};
    /// let bearing = Bearing::<f64, 16>::new(&Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians()))?;
    /// let mut solver = Solver::new(&bearing);
    /// let (load, speed) = ([300.0, 50.0, 0.0, 0.0, 0.0], Speed::rpm(12_000.0));
    /// let solution = solver.solve(load, speed, &Settings::default())?;
    /// for ball in solution.kinematics() {
    ///     println!("{:.2} GPa, {:.0} rad/s", ball.inner.peak_pressure / 1e9, ball.rotation);
    /// }
    /// let frequencies = solution.frequencies();
    /// println!("a damaged outer race hums at {:.0} Hz", frequencies.outer_race);
    /// assert!((frequencies.outer_race + frequencies.inner_race - 16.0 * 200.0).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn kinematics(&self) -> impl ExactSizeIterator<Item = BallKinematics<T>> + '_ {
        self.view().kinematics()
    }

    /// Frequencies at which damaged parts of the bearing are heard: see [`Solution::kinematics`].
    pub fn frequencies(&self) -> Frequencies<T> {
        self.view().frequencies()
    }

    /// Rating life under this load at this speed: see [`LifeRating`].
    pub fn rating_life(&self, rating: &LifeRating<T>) -> RatingLife<T> {
        let weight = rating.weight_of(self.view().contact_forces());
        RatingLife::of_weight(weight, self.speed.as_rad_per_s())
    }

    /// How near this equilibrium is to its limits, and which limits are passed: the given ones, and the grooves' own.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed};
    /// use spindle_bearing::{Limit, Limits};
    /// let bearing = Bearing::<f64, 16>::new(&Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians()))?;
    /// let mut solver = Solver::new(&bearing);
    /// let (load, speed) = ([6000.0, 0.0, 0.0, 0.0, 0.0], Speed::rad_per_s(2000.0));
    /// let solution = solver.solve(load, speed, &Settings::default())?;
    /// let limits = Limits { peak_pressure: 2e9, ..Limits::default() };
    /// let margins = solution.margins(&limits);
    /// // For the worst contact of each limit that is passed, a sentence.
    /// println!("{margins}");
    /// assert!(margins.passed().contains(Limit::PeakPressure) && margins.unloaded == 0);
    /// assert!(margins.get(Limit::PeakPressure).is_some_and(|worst| worst.value > 2e9));
    /// assert!(margins.get(Limit::Shoulder).is_some_and(|worst| worst.value < 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn margins(&self, limits: &Limits<T>) -> Margins<T> {
        self.view().margins(limits)
    }

    /// The row at a glance: largest contact forces and pressures, contact angles, margins and life.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design, LifeRating, Limits, Settings, Solver, Speed};
    /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// let (bearing, rating) = (Bearing::<f64, 16>::new(&DESIGN)?, LifeRating::<f64>::new(&DESIGN, 16, 13_700.0));
    /// let mut solver = Solver::new(&bearing);
    /// let (load, speed) = ([300.0, 50.0, 0.0, 0.0, 0.0], Speed::rpm(12_000.0));
    /// let summary = solver.solve(load, speed, &Settings::default())?.summary(&Limits::default(), &rating);
    /// println!("{:.0} to {:.0} N on the inner race", summary.inner_force[0], summary.inner_force[1]);
    /// assert!((summary.force[0] - 300.0).abs() < 1e-6 && summary.margins.unloaded == 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn summary(&self, limits: &Limits<T>, rating: &LifeRating<T>) -> RowSummary<T> {
        let mut row = [RowSummary::of(&self.view(), limits, rating)];
        RowSummary::share(&mut row, &[T::ZERO]);
        let [row] = row;
        row
    }

    /// A copy that borrows nothing.
    pub fn snapshot(&self) -> Snapshot<T, N, D> {
        self.copy()
    }

    /// A copy with the first `K` balls.
    fn copy<const K: usize>(&self) -> Snapshot<T, K, D> {
        let (balls, cage_speeds) = self.view().copy();
        Snapshot {
            status: self.status,
            iterations: self.iterations,
            error: self.error,
            displacement: self.displacement,
            load: self.load,
            speed: self.speed,
            stiffness: self.stiffness(),
            balls,
            cage_speeds,
        }
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

/// A [`Solution`] that borrows nothing, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(bound = "T: serde::Serialize")
)]
#[non_exhaustive]
pub struct Snapshot<T: Real, const N: usize, const D: usize> {
    /// How the solve ended.
    pub status: Status<T>,
    /// Iterations, those of starts included.
    pub iterations: u16,
    /// How far the figures below can be off.
    pub error: ErrorEstimate<T>,
    /// Displacements `dx, dy, dz` (m), `ty, tz` (rad) of the inner ring.
    #[cfg_attr(feature = "serde", serde(serialize_with = "serialize::array"))]
    pub displacement: [T; D],
    /// Forces (N) and moments (N m) on the inner ring.
    #[cfg_attr(feature = "serde", serde(serialize_with = "serialize::array"))]
    pub load: [T; D],
    /// Speed of the shaft.
    pub speed: Speed<T>,
    /// Stiffness `dF/du`, rows are forces.
    #[cfg_attr(feature = "serde", serde(serialize_with = "serialize::rows"))]
    pub stiffness: [[T; D]; D],
    /// States of the balls, in the order of their azimuths.
    #[cfg_attr(feature = "serde", serde(serialize_with = "serialize::array"))]
    pub balls: [BallState<T>; N],
    /// Cage speed `omega_m` of every ball, rad/s: see [`Solution::cage_speeds`].
    #[cfg_attr(feature = "serde", serde(serialize_with = "serialize::array"))]
    pub cage_speeds: [T; N],
}
