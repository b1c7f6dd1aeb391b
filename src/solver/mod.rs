//! The equilibrium of a bearing under given loads.
//!
//! One solve (`solve`), in the order of its steps: `problem` checks the input and turns it into the solver's units. Next to the last
//! solution (`warm_start`), the ring and the balls are predicted from it. Elsewhere a start puts them where the axial load
//! alone would (`start`). The loop (`newton`) condenses every ball, and steps the ring until the step no longer changes the
//! stiffness (`state` has the estimate). The result is a [`Solution`].
//!
//! Under a purely axial load, `axial` takes the same steps with a single ball, which carries its part of the load.

pub mod axial;
mod newton;
pub mod problem;
pub mod solution;
mod solve;
mod start;
pub mod state;
pub mod warm_start;

use crate::ball::kinematics::{Motion, RacewayControlFree};
use crate::bearing::Bearing;
use crate::real::Real;
use crate::solver::problem::{Loading, OperatingPoint, Problem, Settings};
use crate::solver::solution::Solution;
use crate::solver::warm_start::WarmStart;
use crate::status::Status;
use core::marker::PhantomData;

/// A solver for one bearing: the memory of one solve for the next, and nothing else.
///
/// `M` is how the balls move, `D` the number of freedoms of the inner ring: 5, or 3 where the tilts are locked. The bearing is
/// handed to each solve. A solver that has solved another bearing starts cold.
///
/// ```
/// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed};
/// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// static BEARING: Bearing<f32, 16> = Bearing::<f32, 16>::const_new(&DESIGN);
/// let mut solver = Solver::new();
/// let load = [1000.0, 200.0, 0.0, 0.0, 3.0];
/// let solution = solver.solve(&BEARING, load, Speed::rpm(20_000.0), &Settings::default())?;
/// let k = solution.stiffness();
/// assert!(k[1][1] > k[2][2] && k[2][2] > k[0][0]);
/// # Ok::<(), spindle_bearing::Status<f32>>(())
/// ```
///
/// In firmware it lies in a static, all of its bits zero (`.bss`), in any cell that the application has:
///
/// ```
/// # mod static_cell { pub struct ConstStaticCell<T>(std::sync::Mutex<T>); impl<T> ConstStaticCell<T> { pub const fn new(x: T) -> Self { Self(std::sync::Mutex::new(x)) } } }
/// # use static_cell::ConstStaticCell;
/// # use spindle_bearing::Solver;
/// static SOLVER: ConstStaticCell<Solver<f32, 16>> = ConstStaticCell::new(Solver::new());
/// ```
#[derive(Debug, Clone)]
pub struct Solver<T: Real, const N: usize, M: Motion = RacewayControlFree, const D: usize = 5> {
    last: WarmStart<T, 1, N, D, 0>,
    motion: PhantomData<M>,
}

impl<T: Real, const N: usize> Solver<T, N> {
    /// A solver for bearings at speed, with all inertia loads and five freedoms, raceway-control-free.
    pub const fn new() -> Self {
        Self::of()
    }
}

impl<T: Real, const N: usize, M: Motion, const D: usize> Default for Solver<T, N, M, D> {
    /// [`Solver::of`].
    fn default() -> Self {
        Self::of()
    }
}

impl<T: Real, const N: usize, M: Motion, const D: usize> Solver<T, N, M, D> {
    /// A solver for the motion and the number of freedoms that its types name: 3 or 5. Other numbers do not compile.
    pub const fn of() -> Self {
        const {
            assert!(
                D == 3 || D == 5,
                "the inner ring has 3 freedoms (tilts locked) or 5; one, along the axis, is that of `AxialSolver`"
            )
        };
        Self {
            last: WarmStart::COLD,
            motion: PhantomData,
        }
    }

    /// Has the next solve start from nothing.
    pub fn reset(&mut self) {
        self.last.reset();
    }

    /// The equilibrium at a speed, under loads or where some displacements are given in their place.
    ///
    /// `loads` are `[Fx, Fy, Fz, My, Mz]` (N, N m), or a [`Given`](crate::Given) each; with locked tilts, the first three. For five
    /// freedoms, [`ShaftLoad`](crate::ShaftLoad)s, too.
    /// `at` is a [`Speed`](crate::Speed), or one with the growth of rings and balls. The solve starts from the last solution if
    /// that is near. After [`Status::IterationLimit`] it goes on from where the last one ended, if load and speed are near. With all
    /// displacements given, [`Solution::load`] is the bearing's load-displacement relation.
    ///
    /// # Errors
    ///
    /// A [`Status`] that names why there is no answer.
    pub fn solve<'s>(
        &'s mut self,
        bearing: &'s Bearing<T, N>,
        loads: impl Loading<'s, T, D>,
        at: impl Into<OperatingPoint<T, 1>>,
        settings: &Settings<T>,
    ) -> Result<Solution<'s, T, N, M, D>, Status<T>> {
        self.solve_while(bearing, loads, at, settings, || true)
    }

    /// [`Solver::solve`] for as long as there is `more_time`, which is asked after every row of balls, and for
    /// [`Settings::max_iterations`] at most.
    ///
    /// A solve that is stopped is [`Status::IterationLimit`]. [`Solver::unfinished`] has the state that it reached, and the next
    /// solve goes on from there towards its own load. For the same load and speed, it has the bits of a solve that is not stopped.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed, Status};
    ///
    /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
    /// let (mut solver, speed) = (Solver::new(), Speed::rpm(20_000.0));
    /// let load = [500.0, 100.0, 0.0, 0.0, 1.0];
    /// // On a board: a timer that runs out.
    /// let mut left = 4;
    /// let more_time = || {
    ///     left -= 1;
    ///     left > 0
    /// };
    /// let stopped = solver.solve_while(&BEARING, load, speed, &Settings::default(), more_time);
    /// assert!(stopped.is_err_and(|status| status == Status::IterationLimit));
    /// let reached = solver.unfinished(&BEARING).ok_or("nothing yet")?;
    /// assert!(reached.status == Status::IterationLimit && reached.error.stiffness < 0.5);
    /// assert!(solver.solve(&BEARING, load, speed, &Settings::default()).is_ok());
    /// # Ok::<(), &str>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As for [`Solver::solve`].
    pub fn solve_while<'s>(
        &'s mut self,
        bearing: &'s Bearing<T, N>,
        loads: impl Loading<'s, T, D>,
        at: impl Into<OperatingPoint<T, 1>>,
        settings: &Settings<T>,
        mut more_time: impl FnMut() -> bool,
    ) -> Result<Solution<'s, T, N, M, D>, Status<T>> {
        let layout = bearing.layout();
        let given = loads.given();
        let mut problem = Problem::given(&layout, &given, settings.tolerance)?;
        self.last
            .prepare::<M, _>(&layout, &mut problem, &at.into())?;
        let most = settings.max_iterations;
        let reached = self
            .last
            .run::<M::Rule, _>(&layout, &problem, most, &mut more_time)?;
        let mut solution = Solution::new(bearing, &self.last, &reached);
        for (i, given) in given.iter().enumerate() {
            solution.load[i] = given.load_or(solution.load[i]);
            solution.displacement[i] = given.displacement_or(solution.displacement[i]);
        }
        Ok(solution)
    }

    /// The state that a solve had reached when it ended as [`Status::IterationLimit`], marked with this status. Input that is
    /// refused changes nothing.
    ///
    /// `None` after any other end. Also between two rows of a pass, where a figure is not finite, and where no time was left for a
    /// start, which the next solve begins.
    ///
    /// [`Solution::load`] is the load that the balls carry there. The error estimate holds for the load of the solve; where all
    /// of its figures are 1 or more, nothing is known of the state.
    pub fn unfinished<'s>(
        &'s self,
        bearing: &'s Bearing<T, N>,
    ) -> Option<Solution<'s, T, N, M, D>> {
        let reached = self.last.unfinished::<M::Rule, _>(&bearing.layout())?;
        Some(Solution::new(bearing, &self.last, &reached))
    }
}
