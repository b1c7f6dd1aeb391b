//! The equilibrium of a shaft in its bearings.

use super::Spindle;
use super::set::Set;
use super::solution::{SpindleSolution, condensed};
use crate::float::Real;
use crate::frame::{refer, units};
use crate::growth::Growth;
use crate::linalg::norm;
use crate::motion::{Full, Motion};
use crate::mounting::{Point, Speed};
use crate::ring::Row;
use crate::solver::{Settings, State, Task, are_finite, input};
use crate::status::{Quantity, Status};

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
    pub(super) balls: [[M::Ball<T>; N]; R],
    internal: T,
    /// Speed, growth and references of every row in the last solve.
    pub(super) points: [Point<T>; R],
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
            state: State::COLD,
            balls: [[M::Ball::default(); N]; R],
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
        let task = self.task(&load, speed, growth, settings.tolerance)?;
        let limit = settings.max_iterations.max(1);
        let mut budget = limit;
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
        let outcome = self.state.solve::<_, M::Rule>(&mut set, &task, &mut budget);
        self.state.refuse(&set, &task, &outcome)?;
        let u = self.state.displacement(spindle.plane);
        let error = self.state.errors(&set, &outcome, &u);
        let displacement = spindle.displacement(&u);
        if !are_finite(&displacement) {
            self.state = State::COLD;
            return Err(Status::Diverged { residual: T::ONE });
        }
        let k = self.state.stiffness(|v| set.stiffening(v));
        Ok(SpindleSolution {
            status: outcome.status(),
            iterations: limit - budget,
            error,
            displacement,
            load,
            speed,
            k: condensed(&k),
            slide: if D == 6 {
                u[5] * spindle.unit().length
            } else {
                T::ZERO
            },
            solver: self,
        })
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
        if !task.is_loaded() {
            return Err(Status::Unloaded);
        }
        let mut grown = [Growth::NONE; R];
        for ((grown, growth), row) in grown.iter_mut().zip(growth).zip(&spindle.rows) {
            input::omega(row.constants, speed, M::AT_SPEED)?;
            *grown = input::growth(row.constants, growth)?;
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
        Ok(task)
    }
}
