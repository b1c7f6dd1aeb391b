//! The equilibrium of a shaft in its bearings.

use super::Spindle;
use super::set::Set;
use super::solution::{SpindleSolution, condensed};
use crate::ball::Ball;
use crate::float::Real;
use crate::frame::{force_out, refer, units};
use crate::growth::Growth;
use crate::linalg::{Matrix, norm};
use crate::motion::{Full, Motion};
use crate::mounting::{Point, Speed};
use crate::ring::{Row, stiffening};
use crate::solver::{End, Settings, State, Task, Time, are_finite, input};
use crate::status::{Quantity, Status};
use core::array::from_fn;
use core::marker::PhantomData;

/// A solver for one spindle: owns it, borrows the bearings' constants, and keeps the state that the next solve starts from.
///
/// `M` is how the balls move, as for [`Solver`](crate::Solver). `D` is that of the spindle. See [`Spindle`] for an example.
#[derive(Debug, Clone, Copy)]
pub struct SpindleSolver<
    'b,
    T: Real,
    const R: usize,
    const N: usize,
    M: Motion = Full,
    const D: usize = 5,
> {
    pub(super) spindle: Spindle<'b, T, R, N, D>,
    pub(super) state: State<T, D>,
    pub(super) balls: [[Ball<T>; N]; R],
    motion: PhantomData<M>,
    internal: T,
    /// Speed, growth and references of every row in the last solve.
    pub(super) points: [Point<T>; R],
    speed: Speed<T>,
}

impl<'b, T: Real, const R: usize, const N: usize, const D: usize>
    SpindleSolver<'b, T, R, N, Full, D>
{
    /// A solver for the spindle at speed, with all inertia loads and no race in control.
    pub fn new(spindle: Spindle<'b, T, R, N, D>) -> Self {
        Self::of(spindle)
    }
}

impl<'b, T: Real, const R: usize, const N: usize, M: Motion, const D: usize>
    SpindleSolver<'b, T, R, N, M, D>
{
    /// A solver for the motion that its type names.
    pub fn of(spindle: Spindle<'b, T, R, N, D>) -> Self {
        Self {
            spindle,
            speed: Speed::REST,
            state: State::COLD,
            balls: [[Ball::default(); N]; R],
            motion: PhantomData,
            internal: T::ZERO,
            points: spindle
                .rows
                .map(|row| Point::new(row.constants, T::ZERO, T::ZERO, Growth::NONE)),
        }
    }

    /// Has the next solve start from nothing.
    pub fn reset(&mut self) {
        self.state = State::COLD;
    }

    /// The equilibrium under the load `[Fx, Fy, Fz, My, Mz]` (N, N m) on the shaft at `x = 0`, at a speed, cold.
    ///
    /// The solve starts from the last solution if that is near. After [`Status::IterationLimit`] it goes on from where the
    /// last one ended, if load and speed are near.
    ///
    /// # Errors
    ///
    /// A [`Status`] that names why there is no answer. Balls are counted on from row to row.
    pub fn solve(
        &mut self,
        load: [T; 5],
        speed: Speed<T>,
        settings: &Settings<T>,
    ) -> Result<SpindleSolution<'_, T, R, N, M, D>, Status<T>> {
        self.solve_at(load, speed, &[Growth::NONE; R], settings)
    }

    /// The equilibrium where the rings and balls of each row have grown.
    ///
    /// # Errors
    ///
    /// As for [`SpindleSolver::solve`].
    pub fn solve_at(
        &mut self,
        load: [T; 5],
        speed: Speed<T>,
        growth: &[Growth<T>; R],
        settings: &Settings<T>,
    ) -> Result<SpindleSolution<'_, T, R, N, M, D>, Status<T>> {
        self.solve_while(load, speed, growth, settings, || true)
    }

    /// [`SpindleSolver::solve_at`] for as long as there is `more_time`, as [`Solver::solve_while`](crate::Solver::solve_while).
    ///
    /// # Errors
    ///
    /// As for [`SpindleSolver::solve`].
    pub fn solve_while(
        &mut self,
        load: [T; 5],
        speed: Speed<T>,
        growth: &[Growth<T>; R],
        settings: &Settings<T>,
        mut more_time: impl FnMut() -> bool,
    ) -> Result<SpindleSolution<'_, T, R, N, M, D>, Status<T>> {
        let task = self.task(&load, speed, growth, settings.tolerance)?;
        let mut time = Time::new(settings.max_iterations, &mut more_time);
        let spindle = &self.spindle;
        let (mut mounted, mut balls) = (spindle.rows.iter(), self.balls.iter_mut());
        let mut rows = self
            .points
            .each_mut()
            .map(|p| match (mounted.next(), balls.next()) {
                (Some(row), Some(balls)) => Row {
                    c: row.constants,
                    p,
                    azimuths: row.azimuths,
                    balls: balls.get_mut(..row.azimuths.len()).unwrap_or_default(),
                },
                _ => Row {
                    c: spindle.unit(),
                    p,
                    azimuths: &[],
                    balls: &mut [],
                },
            });
        let mut set = Set {
            rows: &mut rows,
            seats: &spindle.seats,
            internal: &mut self.internal,
            fixed: spindle.fixed,
            sliding: spindle.sliding,
            plane: spindle.plane,
            weight: spindle.weight,
        };
        let end = self.state.solve::<_, M::Rule>(&mut set, &task, &mut time);
        let iterations = time.taken;
        self.state.refuse::<_, M::Rule>(&set, &task, end)?;
        if !are_finite(&self.displacement()) {
            self.state = State::COLD;
            return Err(Status::Diverged { residual: T::ONE });
        }
        Ok(self.solution(iterations, load))
    }

    /// The state that a solve had reached when it ended as [`Status::IterationLimit`]: as
    /// [`Solver::unfinished`](crate::Solver::unfinished).
    pub fn unfinished(&self) -> Option<SpindleSolution<'_, T, R, N, M, D>> {
        let attempt = &self.state.attempt;
        if attempt.outcome.end != End::Unfinished {
            return None;
        }
        let spindle = &self.spindle;
        let force = self.state.force(spindle.plane);
        let mut load = force_out(spindle.unit(), &from_fn(|i| force[i]));
        refer(spindle.centre, &mut load);
        let solution = self.solution(attempt.taken, load);
        let is_finite = solution.error.is_finite()
            && are_finite(&solution.displacement)
            && are_finite(&solution.load)
            && solution.k.iter().all(|row| are_finite(row));
        is_finite.then_some(solution)
    }

    /// Displacement of the shaft at `x = 0`, SI.
    fn displacement(&self) -> [T; 5] {
        let u = self.state.displacement(self.spindle.plane);
        self.spindle.displacement(&u)
    }

    /// Where the state is.
    fn solution(&self, iterations: u16, load: [T; 5]) -> SpindleSolution<'_, T, R, N, M, D> {
        let (spindle, state) = (&self.spindle, &self.state);
        let u = state.displacement(spindle.plane);
        let inertia = self.points.first().map_or(T::ZERO, |point| point.s) * spindle.weight;
        SpindleSolution {
            status: state.attempt.outcome.end.status(),
            iterations,
            error: state.errors(&u, inertia),
            displacement: self.displacement(),
            load,
            speed: self.speed,
            k: condensed(&state.stiffness(|v| self.stiffening(v))),
            slide: if D == 6 {
                u[5] * spindle.unit().length
            } else {
                T::ZERO
            },
            solver: self,
        }
    }

    /// Change of the stiffness along the motion to `v` from where the balls were condensed, referred to the centre.
    fn stiffening(&self, v: &[T; D]) -> Matrix<T, D> {
        let mut change = [[T::ZERO; D]; D];
        let rows = self.spindle.rows.iter().zip(&self.spindle.seats);
        for ((row, seat), (point, balls)) in rows.zip(self.points.iter().zip(&self.balls)) {
            let balls = balls.get(..row.azimuths.len()).unwrap_or_default();
            let mut own = stiffening::<T, M::Rule, 5>(point, balls, row.azimuths, &seat.motion(v));
            seat.add_stiffness(&mut change, &mut own.k);
        }
        change
    }

    /// Checks the input, and turns it into the solver's units. Takes note of the growth.
    fn task(
        &mut self,
        load: &[T; 5],
        speed: Speed<T>,
        growth: &[Growth<T>; R],
        tolerance: T,
    ) -> Result<Task<T, D>, Status<T>> {
        let spindle = &self.spindle;
        let unit = spindle.unit();
        let mut task = Task {
            load: [T::ZERO; D],
            size: T::ZERO,
            held: [None; D],
            tolerance,
        };
        for (i, load) in load.iter().enumerate() {
            let [quantity, _] = Quantity::OF_FREEDOM[i];
            task.load[i] = input::load(quantity, units(unit, i).0, spindle.weight, *load)?;
        }
        // From x = 0 to the centre.
        refer(-spindle.centre * unit.tilt / unit.length, &mut task.load);
        if D == 6 {
            task.load[5] = spindle.spring / unit.force;
        }
        task.size = norm(&task.load).at_least(spindle.held);
        let mut grown = [Growth::NONE; R];
        for ((grown, growth), row) in grown.iter_mut().zip(growth).zip(&spindle.rows) {
            input::omega(row.constants, speed, M::AT_SPEED)?;
            *grown = input::growth(row.constants, growth)?;
        }
        if !task.is_loaded() {
            return Err(Status::Unloaded);
        }
        let s = if M::AT_SPEED {
            let omega = speed.as_rad_per_s();
            input::inertia(unit, omega, spindle.weight, task.size)
        } else {
            T::ZERO
        };
        let rows = spindle.rows.iter().zip(&spindle.seats);
        for ((row, seat), (point, growth)) in rows.zip(self.points.iter_mut().zip(grown)) {
            self.state.grow(&point.growth, &growth);
            let size = task.size / seat.force;
            let axial = seat.axial(&self.state.u);
            point.set(row.constants, s * seat.inertia, size, growth, axial);
        }
        self.speed = speed;
        Ok(task)
    }
}
