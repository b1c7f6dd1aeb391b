//! The equilibrium of a bearing under given loads.
//!
//! One solve, in the order of its steps: `problem` checks the input and turns it into the solver's units. Next to the last
//! solution (`warm_start`), the ring and the balls are predicted from it. Elsewhere a start puts them where the axial load
//! alone would (`start`). The loop (`newton`) condenses every ball, and steps the ring until the step no longer changes the
//! stiffness (`state` has the estimate). The result is a [`Solution`].
//!
//! Under a purely axial load, `axial` takes the same steps with a single ball, which carries its part of the load.

pub mod axial;
mod newton;
pub mod problem;
pub mod solution;
mod start;
pub mod state;
pub mod warm_start;

use crate::ball::kinematics::{Full, Motion, Speed};
use crate::bearing::Bearing;
use crate::growth::Growth;
use crate::real::Real;
use crate::solver::problem::{Given, RingVector, Settings};
use crate::solver::solution::Solution;
use crate::solver::warm_start::WarmStart;
use crate::status::Status;
use core::marker::PhantomData;

/// A solver for one bearing: borrows its constants, and owns the state that the next solve starts from.
///
/// `M` is how the balls move, `D` the number of freedoms of the inner ring: 5, or 3 where the tilts are locked.
///
/// ```
/// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed};
/// const BEARING: Bearing<f32, 16> = Bearing::<f32, 16>::const_new(&Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians()));
/// let mut solver = Solver::new(&BEARING);
/// let load = [1000.0, 200.0, 0.0, 0.0, 3.0];
/// let solution = solver.solve(load, Speed::rpm(20_000.0), &Settings::default())?;
/// let k = solution.stiffness();
/// assert!(k[1][1] > k[2][2] && k[2][2] > k[0][0]);
/// # Ok::<(), spindle_bearing::Status<f32>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Solver<'b, T: Real, const N: usize, M: Motion = Full, const D: usize = 5> {
    pub(crate) bearing: &'b Bearing<T, N>,
    pub(crate) last: WarmStart<T, 1, N, D, 0>,
    pub(crate) motion: PhantomData<M>,
}

impl<'b, T: Real, const N: usize> Solver<'b, T, N> {
    /// A solver for the bearing at speed, with all inertia loads, five freedoms and no race in control.
    pub const fn new(bearing: &'b Bearing<T, N>) -> Self {
        Self::of(bearing)
    }
}

impl<'b, T: Real, const N: usize, M: Motion, const D: usize> Solver<'b, T, N, M, D> {
    /// A solver for the motion and the number of freedoms that its types name.
    pub const fn of(bearing: &'b Bearing<T, N>) -> Self
    where
        [T; D]: RingVector,
    {
        Self {
            bearing,
            last: WarmStart::COLD,
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
    /// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
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
        let layout = self.bearing.layout();
        let growth = core::array::from_ref(growth);
        let tolerance = settings.tolerance;
        let problem =
            self.last
                .problem::<M, _>(&layout, given, |_| (), speed, growth, tolerance)?;
        let most = settings.max_iterations;
        let reached = self
            .last
            .run::<M::Rule, _>(&layout, &problem, most, &mut more_time)?;
        let mut solution = Solution::new(self.bearing, &self.last, &reached);
        for (i, given) in given.iter().enumerate() {
            solution.load[i] = given.load_or(solution.load[i]);
            solution.displacement[i] = given.displacement_or(solution.displacement[i]);
        }
        Ok(solution)
    }

    /// The state that a solve had reached when it ended as [`Status::IterationLimit`], marked with this status. None after any
    /// other end, where figures are not finite, and where an attempt was given up without time for a start; the next solve begins
    /// one. Input that is refused changes nothing.
    ///
    /// [`Solution::load`] is the load that the balls carry there. The error estimate holds for the load of the solve; where that
    /// of the stiffness is 1 or more, nothing is known of it.
    pub fn unfinished(&self) -> Option<Solution<'_, T, N, M, D>> {
        let reached = self.last.unfinished::<M::Rule, _>(&self.bearing.layout())?;
        Some(Solution::new(self.bearing, &self.last, &reached))
    }
}
