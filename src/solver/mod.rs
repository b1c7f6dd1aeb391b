//! The equilibrium of a bearing under given loads.
//!
//! One solve, in the order of its steps: [`Solver::solve_at`] checks the input and turns it into the solver's units.
//! Next to the last solution, the ring and the balls are predicted from it. Elsewhere a start puts them where the axial
//! load alone would (`start`). The loop (`newton`) condenses every ball into what it hands to the ring. It steps the ring
//! until the step no longer changes the stiffness (`error`). The result is a [`Solution`].
//!
//! Under a purely axial load, [`AxialSolver`] takes the same steps with a single ball, which carries its part of the
//! load.

mod axial;
pub(crate) mod error;
pub(crate) mod input;
mod newton;
mod solution;
mod start;
mod view;
mod warm_start;

use crate::constants::Bearing;
use crate::float::Real;
use crate::frame::{displacement_out, force_out, moved};
use crate::growth::Growth;
use crate::kinematics::Rule;
use crate::linalg::{Factors, norm};
use crate::motion::{Full, Motion};
use crate::mounting::Speed;
use crate::ring::{Sum, UNSEATED};
use crate::shaft::{Layout, Shaft};
use crate::status::{Quantity, Status};
use crate::tuning;
use core::array::from_fn;
use core::marker::PhantomData;

pub use axial::{AxialSolution, AxialSolver};
pub use error::ErrorEstimate;
use newton::Attempt;
pub(crate) use newton::Time;
use newton::{End, Task};
pub use solution::{Snapshot, Solution};
use start::start;
pub(crate) use view::View;
pub(crate) use warm_start::{Reached, WarmStart};

/// Iteration limit and convergence tolerance.
///
/// The default is for a solve that may take its time, [`Settings::TICK`] for a tick of firmware.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings<T> {
    /// Most iterations, at least 1. An iteration condenses every ball once.
    pub max_iterations: u16,
    /// Largest change of the stiffness along the last step, relative to its diagonal. Displacements and contact forces
    /// are then good to less.
    pub tolerance: T,
}

impl<T: Real> Settings<T> {
    /// A tick of firmware: three iterations at most, a tolerance of 1e-3.
    ///
    /// Where such a solve converges, the stiffness is good to 5e-3, the tolerance times the estimate's margin of 5.
    /// [`ErrorEstimate::stiffness`] states that much at most, besides rounding. A Cortex-M4F at 168 MHz has time for three
    /// iterations in a tick of 1 ms that monitors a pair.
    ///
    /// A solve from nothing mostly takes more iterations: it ends as [`Status::IterationLimit`], and the next call goes on.
    /// [`Solver::unfinished`] has what a tick without an answer has reached.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed};
    ///
    /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::checked(&DESIGN);
    /// let (mut solver, speed) = (Solver::new(&BEARING), Speed::rpm(20_000.0));
    /// solver.solve([500.0, 100.0, 0.0, 0.0, 1.0], speed, &Settings::default())?;
    /// // A tick later.
    /// let solution = solver.solve([502.0, 104.0, 0.0, 0.0, 1.0], speed, &Settings::TICK)?;
    /// assert!(solution.error.stiffness <= 5e-3);
    /// # Ok::<(), spindle_bearing::Status<f32>>(())
    /// ```
    pub const TICK: Self = Self {
        max_iterations: 3,
        tolerance: T::TICK,
    };
}

impl<T: Real> Default for Settings<T> {
    /// 100 iterations; a tolerance of 2e-5 in single and 3e-13 in double
    /// precision.
    fn default() -> Self {
        Self {
            max_iterations: 2 * tuning::ATTEMPT,
            tolerance: T::TOLERANCE,
        }
    }
}

/// Loads or displacements of the freedoms that the inner ring has in a [`Solver`]: 3 or 5 numbers.
#[diagnostic::on_unimplemented(
    message = "the inner ring has 3 freedoms (tilts locked) or 5, which `{Self}` does not fit",
    note = "one freedom, along the axis, is that of `AxialSolver`"
)]
pub trait RingVector {}

impl<T: Real> RingVector for [T; 3] {}
impl<T: Real> RingVector for [T; 5] {}

/// A load or a displacement that is given of a freedom of the inner ring.
///
/// ```
/// use spindle_bearing::{Bearing, Design, Given, Growth, Settings, Solver, Speed};
///
/// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// static BEARING: Bearing<f64, 15> = Bearing::<f64, 15>::checked(&DESIGN);
/// let mut solver = Solver::new(&BEARING);
/// // Pressed together by 10 um, without tilt; a radial load of 50 N.
/// let given = [
///     Given::Displacement(10e-6),
///     Given::Load(50.0),
///     Given::Load(0.0),
///     Given::Displacement(0.0),
///     Given::Displacement(0.0),
/// ];
/// let solution = solver.solve_at(&given, Speed::rpm(10_000.0), &Growth::NONE, &Settings::default())?;
/// assert!(solution.load[0] > 100.0);
/// # Ok::<(), spindle_bearing::Status<f64>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Given<T> {
    /// Its load, N or N m; the displacement is solved for.
    Load(T),
    /// Its displacement, m or rad; the load is the reaction.
    Displacement(T),
}

impl<T> Given<T> {
    /// The load that was given, or else the reaction.
    #[inline(always)]
    fn load_or(self, found: T) -> T {
        match self {
            Self::Load(given) => given,
            Self::Displacement(_) => found,
        }
    }

    /// The displacement that was given, or else the one that was found.
    #[inline(always)]
    fn displacement_or(self, found: T) -> T {
        match self {
            Self::Displacement(given) => given,
            Self::Load(_) => found,
        }
    }
}

/// What is kept between solves besides the balls, in the units of the constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<T, const D: usize> {
    /// Reference position of the groove plane, along the axis, and the offset of the ring from it.
    pub u: [T; D],
    pub v: [T; D],
    /// Offset where the balls were condensed last, and what they handed over, referred to the bearing centre.
    pub at: [T; D],
    pub sum: Sum<T, D>,
    /// Factors of the tangent, and whether they are those of the undamped tangent of free loads.
    pub factors: Factors<T, D>,
    pub plain: bool,
    /// The stiffness has yet to follow the last step.
    pub correct: bool,
    /// Load of the last solve, its size with reactions, and inertia `m dm omega^2 / 2`.
    load: [T; D],
    pub(crate) size: T,
    s: T,
    /// A pivot of the undamped tangent is no more than rounding: nothing holds the shaft in some direction.
    weak: bool,
    /// The last attempt, and how it ended.
    pub(crate) attempt: Attempt<T, D>,
}

impl<T: Real, const D: usize> State<T, D> {
    /// Of a solver without history.
    pub const COLD: Self = Self {
        u: [T::ZERO; D],
        v: [T::ZERO; D],
        at: [T::ZERO; D],
        sum: Sum::NONE,
        factors: Factors::NONE,
        plain: false,
        correct: false,
        load: [T::ZERO; D],
        size: T::ZERO,
        s: T::ZERO,
        weak: false,
        attempt: Attempt::NONE,
    };

    /// Displacement of the centre.
    pub(crate) fn displacement(&self, plane: T) -> [T; D] {
        moved(-plane, &from_fn(|i| self.u[i] + self.v[i]))
    }

    /// One solve: from the last solution or an unfinished attempt, if that is near, or from a start.
    fn solve<A: Rule, const R: usize, const SET: bool>(
        &mut self,
        shaft: &mut Shaft<'_, T, R, SET>,
        task: &Task<T, D>,
        time: &mut Time<'_>,
    ) -> End {
        let s = shaft.s;
        let mut end = End::Lost;
        if self.is_near(shaft, task) {
            if self.attempt.outcome.end != End::Unfinished {
                self.attempt.begin(false);
            }
            let ds = if s > T::ZERO {
                s / self.s - T::ONE
            } else {
                T::ZERO
            };
            self.predict(shaft.layout.plane, task, ds);
            end = self.newton::<A, R, SET>(shaft, task, ds, time);
        } else {
            self.attempt.begin(false);
        }
        let mut is_over = end.is_solved() || end == End::Unfinished || self.attempt.started;
        if !is_over && !time.is_up {
            is_over = true;
            self.attempt.begin(true);
            start::<T, A, R, SET, D>(self, shaft, task);
            end = self.newton::<A, R, SET>(shaft, task, T::ZERO, time);
        }
        self.attempt.outcome.end = end;
        self.load = task.load;
        self.s = s;
        if is_over {
            let size = task.size.at_least(norm(&self.sum.force));
            self.size = size.at_least(*shaft.internal);
            return end;
        }
        // There was no time for a start: the next solve has one.
        self.size = T::ZERO;
        End::Unfinished
    }

    /// Whether the last solve ended so near that the next one may start there. Rows that hold each other stay pressed under
    /// any load.
    fn is_near<const R: usize, const SET: bool>(
        &self,
        shaft: &Shaft<'_, T, R, SET>,
        task: &Task<T, D>,
    ) -> bool {
        let half = T::of(0.5);
        let (s, balls) = (shaft.s, shaft.layout.weight);
        let at = self.displacement(shaft.layout.plane);
        let change: [T; D] = from_fn(|i| match task.held[i] {
            None => task.load[i] - self.load[i],
            Some(u) => self.sum.k[i][i] * (u - at[i]),
        });
        let smaller = if task.is_free {
            self.size.at_most(task.size.at_least(*shaft.internal))
        } else {
            self.size
        };
        self.size > T::ZERO
            && (shaft.layout.fixed.opposed || norm(&change) <= smaller)
            && (s - self.s).abs() * balls <= half * (self.s * balls + self.size)
            && (s > T::ZERO) == (self.s > T::ZERO)
    }

    /// Freedom in which the tangent resists least: the largest component after two inverse iterations.
    #[cold]
    #[inline(never)]
    fn freest(&mut self, task: &Task<T, D>) -> Quantity {
        let largest = self.stiffest().at_least(T::EPSILON);
        self.factor(task, T::EPSILON.sqrt() * largest);
        let free = |motion: [T; D]| {
            from_fn(|i| match task.held[i] {
                None => largest * motion[i],
                Some(_) => T::ZERO,
            })
        };
        let motion = self.factors.solve(&free([T::ONE; D]));
        let motion = free(self.factors.solve(&free(motion)));
        let mut freest = 0;
        for i in 1..D.min(5) {
            if motion[i].abs() > motion[freest].abs() {
                freest = i;
            }
        }
        Quantity::OF_FREEDOM[freest][1]
    }

    /// Why there is no solution, if there is none.
    fn refuse<A: Rule, const R: usize, const SET: bool>(
        &mut self,
        shaft: &Shaft<'_, T, R, SET>,
        task: &Task<T, D>,
        end: End,
    ) -> Result<(), Status<T>> {
        let outcome = self.attempt.outcome;
        let is_solved = end.is_solved();
        if is_solved && outcome.estimate.cos >= T::of(UNSEATED) {
            return Ok(());
        }
        // Contacts more than 90 degrees apart do not hold a ball: that is why. An unfinished step says nothing of it.
        let limit = if is_solved { T::of(UNSEATED) } else { T::ZERO };
        let driven_out = shaft.furthest_apart::<A>(limit);
        let status = match (end, driven_out) {
            (End::Singular, _) => Status::Indeterminate {
                loaded_balls: shaft.loaded(),
                free: self.freest(task),
            },
            (End::Unfinished, _) => Status::IterationLimit,
            (_, Some((ball, apart))) => Status::Unseated { ball, apart },
            _ => Status::Diverged {
                residual: outcome.residual,
            },
        };
        if end != End::Unfinished {
            *self = Self::COLD;
        }
        Err(status)
    }
}

/// Whether every figure is a finite number.
#[inline(never)]
pub(crate) fn are_finite<T: Real>(figures: &[T]) -> bool {
    let mut zero = T::ZERO;
    for x in figures {
        zero += T::ZERO * *x;
    }
    zero == T::ZERO
}

/// A solver for one bearing: borrows its constants, and owns the state that the next solve starts from.
///
/// `M` is how the balls move, `D` the number of freedoms of the inner ring: 5, or 3 where the tilts are locked.
///
/// ```
/// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed};
/// const BEARING: Bearing<f32, 16> = Bearing::<f32, 16>::checked(&Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians()));
/// let mut solver = Solver::new(&BEARING);
/// let load = [1000.0, 200.0, 0.0, 0.0, 3.0];
/// let solution = solver.solve(load, Speed::rpm(20_000.0), &Settings::default())?;
/// let k = solution.stiffness();
/// assert!(k[1][1] > k[2][2] && k[2][2] > k[0][0]);
/// # Ok::<(), spindle_bearing::Status<f32>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Solver<'b, T: Real, const N: usize, M: Motion = Full, const D: usize = 5> {
    bearing: &'b Bearing<T, N>,
    pub(crate) last: WarmStart<T, 1, N, D>,
    motion: PhantomData<M>,
}

impl<'b, T: Real, const N: usize> Solver<'b, T, N> {
    /// A solver for the bearing at speed, with all inertia loads, five freedoms and no race in control.
    pub fn new(bearing: &'b Bearing<T, N>) -> Self {
        Self::of(bearing)
    }
}

impl<'b, T: Real, const N: usize, M: Motion, const D: usize> Solver<'b, T, N, M, D> {
    /// A solver for the motion and the number of freedoms that its types name.
    pub fn of(bearing: &'b Bearing<T, N>) -> Self
    where
        [T; D]: RingVector,
    {
        Self {
            bearing,
            last: WarmStart::new(&Layout::alone(bearing)),
            motion: PhantomData,
        }
    }

    /// Has the next solve start from nothing.
    pub fn reset(&mut self) {
        self.last.reset();
    }

    /// The equilibrium under the load `[Fx, Fy, Fz, My, Mz]` (N, N m) at a speed.
    ///
    /// With locked tilts the load has no moments. The solve starts from the last solution if that is near. After
    /// [`Status::IterationLimit`] it goes on from where the last one ended, if load and speed are near.
    ///
    /// # Errors
    ///
    /// A [`Status`] that names why there is no answer.
    pub fn solve(
        &mut self,
        load: [T; D],
        speed: Speed<T>,
        settings: &Settings<T>,
    ) -> Result<Solution<'_, T, N, M, D>, Status<T>> {
        self.solve_while(
            &load.map(Given::Load),
            speed,
            &Growth::NONE,
            settings,
            || true,
        )
    }

    /// The equilibrium where some displacements are given in the place of loads, and rings and balls have grown.
    ///
    /// With all displacements given, [`Solution::load`] is the bearing's load-displacement relation.
    ///
    /// # Errors
    ///
    /// As for [`Solver::solve`].
    pub fn solve_at(
        &mut self,
        given: &[Given<T>; D],
        speed: Speed<T>,
        growth: &Growth<T>,
        settings: &Settings<T>,
    ) -> Result<Solution<'_, T, N, M, D>, Status<T>> {
        self.solve_while(given, speed, growth, settings, || true)
    }

    /// [`Solver::solve_at`] for as long as there is `more_time`, which is asked after every iteration, and for
    /// [`Settings::max_iterations`] at most.
    ///
    /// A solve that is stopped is [`Status::IterationLimit`]. [`Solver::unfinished`] has what it has reached, and the next solve
    /// goes on from there towards its own load.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design, Given, Growth, Settings, Solver, Speed, Status};
    ///
    /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::checked(&DESIGN);
    /// let (mut solver, speed) = (Solver::new(&BEARING), Speed::rpm(20_000.0));
    /// let given = [500.0, 100.0, 0.0, 0.0, 1.0].map(Given::Load);
    /// // On a board: a timer that runs out.
    /// let mut left = 4;
    /// let more_time = || {
    ///     left -= 1;
    ///     left > 0
    /// };
    /// let stopped = solver.solve_while(&given, speed, &Growth::NONE, &Settings::default(), more_time);
    /// assert!(stopped.is_err_and(|status| status == Status::IterationLimit));
    /// let reached = solver.unfinished().ok_or("nothing yet")?;
    /// assert!(reached.status == Status::IterationLimit && reached.error.stiffness < 0.5);
    /// assert!(solver.solve_at(&given, speed, &Growth::NONE, &Settings::default()).is_ok());
    /// # Ok::<(), &str>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As for [`Solver::solve`].
    pub fn solve_while(
        &mut self,
        given: &[Given<T>; D],
        speed: Speed<T>,
        growth: &Growth<T>,
        settings: &Settings<T>,
        mut more_time: impl FnMut() -> bool,
    ) -> Result<Solution<'_, T, N, M, D>, Status<T>> {
        let layout = Layout::alone(self.bearing);
        let growth = core::array::from_ref(growth);
        let tolerance = settings.tolerance;
        let task = self
            .last
            .task::<M, _>(&layout, given, |_| (), speed, growth, tolerance)?;
        let mut time = Time::new(settings.max_iterations, &mut more_time);
        let reached = self.last.solve::<M::Rule, _>(&layout, &task, &mut time)?;
        let mut solution = self.solution(&reached);
        for (i, given) in given.iter().enumerate() {
            match *given {
                Given::Load(load) => solution.load[i] = load,
                Given::Displacement(u) => solution.displacement[i] = u,
            }
        }
        Ok(solution)
    }

    /// The state that a solve had reached when it ended as [`Status::IterationLimit`], marked with this status. None after any
    /// other end, and where figures are not finite; input that is refused changes nothing.
    ///
    /// [`Solution::load`] is the load that the balls carry there. The error estimate holds for the load of the solve; where that
    /// of the stiffness is 1 or more, nothing is known of it. The table of a cut is in `docs/firmware.md`.
    pub fn unfinished(&self) -> Option<Solution<'_, T, N, M, D>> {
        let reached = self
            .last
            .unfinished::<M::Rule, _>(&Layout::alone(self.bearing))?;
        Some(self.solution(&reached))
    }

    fn solution(&self, reached: &Reached<T, D>) -> Solution<'_, T, N, M, D> {
        let (c, state) = (&self.bearing.constants, &self.last.state);
        Solution {
            status: state.attempt.outcome.end.status(),
            iterations: reached.iterations,
            error: state.errors(&reached.u, self.last.points[0].s * c.balls),
            displacement: displacement_out(c, &reached.u),
            load: force_out(c, &reached.load),
            speed: self.last.speed,
            solver: self,
        }
    }
}
