//! The equilibrium of a bearing under given loads.
//!
//! One solve, in the order of its steps: [`Solver::solve_at`] checks the input and turns it into the solver's units.
//! Next to the last solution, the ring and the balls are predicted from it; elsewhere a start by regime puts them
//! roughly where they belong (`start`). The loop (`newton`) condenses every ball into what it hands to the ring, and
//! steps the ring until the step no longer changes the stiffness (`error`). A solve that does not end so falls back on
//! continuation from rest (`fallback`). What came of it is a [`Solution`].

mod error;
mod fallback;
mod newton;
mod solution;
mod start;

use super::constants::{Bearing, Constants};
use super::frame::{centre_of, displacement_out, force_out, units};
use super::linalg::norm;
use super::motion::{Body, Full, Motion, Point};
use super::mounting::{Growth, Speed};
use super::ring::{Row, Sum};
use crate::float::Real;
use crate::status::{Quantity, Status};
use core::array::from_fn;

use newton::End;
pub(crate) use newton::{Outcome, Task};
pub use solution::{Snapshot, Solution};
pub(crate) use start::{cold_at_rest, cold_at_speed};

/// Iteration limit and convergence tolerance.
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

impl<T: Real> Default for Settings<T> {
    /// 100 iterations; a tolerance of 2e-5 in single and 3e-13 in double precision.
    fn default() -> Self {
        Self {
            max_iterations: 100,
            tolerance: T::TOLERANCE,
        }
    }
}

/// What is given of a freedom of the inner ring.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Given<T> {
    /// Its load, N or N m; the displacement is solved for.
    Load(T),
    /// Its displacement, m or rad; the load is the reaction.
    Displacement(T),
}

/// What is kept between solves besides the balls, in the units of the constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<T, const D: usize> {
    /// Reference position of the groove plane, multiples of 1/256, and the offset of the ring from it.
    pub u: [T; D],
    pub v: [T; D],
    /// Offset where the balls were condensed last, and what they handed over, referred to the bearing centre.
    pub at: [T; D],
    pub sum: Sum<T, D>,
    /// The stiffness has yet to follow the last step.
    pub correct: bool,
    /// Load of the last solve, its size with reactions, inertia `m dm omega^2 / 2`, and growth.
    load: [T; D],
    size: T,
    s: T,
    growth: Growth<T>,
}

impl<T: Real, const D: usize> State<T, D> {
    /// Of a solver without history.
    pub const COLD: Self = Self {
        u: [T::ZERO; D],
        v: [T::ZERO; D],
        at: [T::ZERO; D],
        sum: Sum::NONE,
        correct: false,
        load: [T::ZERO; D],
        size: T::ZERO,
        s: T::ZERO,
        growth: Growth::NONE,
    };

    /// Displacement of the bearing centre.
    fn displacement(&self, c: &Constants<T>) -> [T; D] {
        centre_of(c, &from_fn(|i| self.u[i] + self.v[i]))
    }
}

/// A solver for one bearing: borrows its constants, and owns the state that the next solve starts from.
///
/// `M` is how the balls move, `D` the number of freedoms of the inner ring: 5, or 3 where the tilts are locked.
///
/// ```
/// use spindle_bearing::next::{Bearing, Settings, Solver, Speed};
/// use spindle_bearing::{Design, FreeContact, Material};
/// const BEARING: Bearing<f32, 16> = Bearing::<f32, 16>::checked(&Design {
///     ball_diameter: 6.35e-3, pitch_diameter: 36e-3,
///     inner_groove_factor: 0.515, outer_groove_factor: 0.525,
///     free_contact: FreeContact::Angle(0.2618), first_ball: 0.0,
///     inner_shoulder_angle: Design::HIGHEST_SHOULDER, outer_shoulder_angle: Design::HIGHEST_SHOULDER,
///     ring: Material::STEEL, ball: Material::STEEL,
/// });
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
    state: State<T, D>,
    balls: [M::Ball<T>; N],
}

impl<'b, T: Real, const N: usize> Solver<'b, T, N> {
    /// A solver for the bearing at speed, with all inertia loads, five freedoms and no race in control.
    pub fn new(bearing: &'b Bearing<T, N>) -> Self {
        Self::of(bearing)
    }
}

impl<'b, T: Real, const N: usize, M: Motion, const D: usize> Solver<'b, T, N, M, D> {
    /// A solver for the scene that its types name.
    pub fn of(bearing: &'b Bearing<T, N>) -> Self {
        const {
            assert!(
                D == 3 || D == 5,
                "the inner ring has 3 freedoms (tilts locked) or 5"
            );
        }
        Self {
            bearing,
            state: State::COLD,
            balls: [M::Ball::default(); N],
        }
    }

    /// Has the next solve start from nothing.
    pub fn reset(&mut self) {
        self.state = State::COLD;
    }

    /// The equilibrium under the load `[Fx, Fy, Fz, My, Mz]` (N, N m; without moments, if the tilts are locked) at a
    /// speed, from the last solution if that is near. A solve that did not finish is near, too: the next one goes on
    /// from where it ended.
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
        self.solve_at(&load.map(Given::Load), speed, &Growth::NONE, settings)
    }

    /// The same where some displacements are given in the place of loads, and rings and balls have grown. With all
    /// displacements given, [`Solution::load`] is the bearing's load-displacement relation.
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
        let (task, p) = self.task(given, speed, growth, settings.tolerance)?;
        let limit = settings.max_iterations.max(1);
        let mut budget = limit;
        let near = self.is_near(&task, &p);
        let c = &self.bearing.constants;
        let (state, mut row) = (
            &mut self.state,
            Row {
                c,
                azimuths: &self.bearing.azimuths,
                balls: &mut self.balls,
            },
        );
        let mut outcome = Outcome::NONE;
        if near {
            let ds = if p.s > T::ZERO {
                p.s / state.s - T::ONE
            } else {
                T::ZERO
            };
            let curved = task.tolerance < T::of(super::tuning::CURVED);
            state.predict(&mut row, &task, ds, curved);
            let mut some = budget.min(super::tuning::WARM);
            budget -= some;
            outcome = state.newton::<_, M::Rule>(&mut row, &task, &p, ds, &mut some);
            budget += some;
        }
        if !outcome.end.is_solved() && budget > 0 {
            outcome = M::cold(state, &mut row, &task, &p, &mut budget);
        }
        state.load = task.load;
        state.size = norm(&task.load).or_larger(norm(&state.sum.force));
        state.s = p.s;
        self.conclude(given, &task, &p, outcome, limit - budget)
    }

    /// Checks the input, and turns it into the solver's units.
    fn task(
        &mut self,
        given: &[Given<T>; D],
        speed: Speed<T>,
        growth: &Growth<T>,
        tolerance: T,
    ) -> Result<(Task<T, D>, Point<T>), Status<T>> {
        let c = &self.bearing.constants;
        let mut task = Task {
            load: [T::ZERO; D],
            held: [None; D],
            tolerance,
        };
        for (i, given) in given.iter().enumerate() {
            let (force, length) = units(c, i);
            let [of_load, of_displacement] = Quantity::OF_FREEDOM[i];
            match *given {
                // Beyond N times the force that would press a ball by the whole groove distance, nothing in the model
                // holds.
                Given::Load(load) => {
                    check(of_load, load, force * c.balls * T::of(512.0))?;
                    task.load[i] = load / force;
                }
                Given::Displacement(u) => {
                    check(of_displacement, u, length * T::of(128.0))?;
                    task.held[i] = Some(u / length);
                }
            }
        }
        // Where a ball's centrifugal force would press it by the whole groove distance.
        let omega = speed.as_rad_per_s();
        check(Quantity::Speed, omega, (T::of(2048.0) / c.inertia).sqrt())?;
        let lengths = [growth.axial, growth.radial, growth.ball];
        for (length, quantity) in lengths.into_iter().zip(Quantity::OF_GROWTH) {
            check(quantity, length, c.length * T::of(16.0))?;
        }
        let size = norm(&task.load);
        let loaded = size > T::TINY.sqrt() || task.held.iter().any(Option::is_some);
        if !loaded {
            return Err(Status::Unloaded);
        }
        let mut s = if M::AT_SPEED {
            c.inertia * omega * omega
        } else {
            T::ZERO
        };
        // Inertia that changes no figure of a loaded ring.
        if size > T::ZERO && s * c.balls < T::EPSILON * size {
            s = T::ZERO;
        }
        let per = T::ONE / c.length;
        let growth = Growth {
            axial: growth.axial * per,
            radial: growth.radial * per,
            ball: growth.ball * per,
        };
        let p = Point::new(c, s, &growth);
        if growth != self.state.growth {
            self.state.growth = growth;
            self.state.size = T::ZERO;
        }
        Ok((task, p))
    }

    /// Whether the last solve ended so near that the next one may start there.
    fn is_near(&self, task: &Task<T, D>, p: &Point<T>) -> bool {
        let last = &self.state;
        let half = T::of(0.5);
        let at = last.displacement(&self.bearing.constants);
        let change: [T; D] = from_fn(|i| match task.held[i] {
            None => task.load[i] - last.load[i],
            Some(u) => last.sum.k[i][i] * (u - at[i]),
        });
        last.size > T::ZERO
            && norm(&change) <= half * last.size
            && (p.s - last.s).abs() * self.bearing.constants.balls
                <= half * (last.s * self.bearing.constants.balls + last.size)
            && (p.s > T::ZERO) == (last.s > T::ZERO)
    }

    /// The solution, or why there is none.
    fn conclude(
        &mut self,
        given: &[Given<T>; D],
        task: &Task<T, D>,
        p: &Point<T>,
        outcome: Outcome<T>,
        iterations: u16,
    ) -> Result<Solution<'_, T, N, M, D>, Status<T>> {
        let residual = outcome.residual;
        let status = match outcome.end {
            End::Converged => Status::Converged,
            End::Rounded => Status::PrecisionLimit,
            End::Singular => {
                let loaded = self.balls.iter().filter(|ball| ball.carries()).count();
                self.reset();
                return Err(Status::Indeterminate {
                    loaded_balls: loaded as u16,
                });
            }
            End::Unfinished => return Err(Status::SweepLimit),
            End::Lost => {
                self.reset();
                return Err(Status::Diverged { residual });
            }
        };
        for (ball, number) in self.balls.iter().zip(0..) {
            if let Some(apart) = ball.unseated() {
                self.reset();
                return Err(Status::Unseated {
                    ball: number,
                    apart,
                });
            }
        }
        let c = &self.bearing.constants;
        let u = self.state.displacement(c);
        let displacement = displacement_out(c, &u);
        // What the tangent says of the force after the last step.
        let force: [T; D] = from_fn(|i| match task.held[i] {
            None => task.load[i],
            Some(_) => self.state.sum.force[i],
        });
        let load = force_out(c, &force);
        let finite = displacement.iter().chain(&load).all(|x| x.is_finite())
            && self
                .state
                .sum
                .k
                .as_flattened()
                .iter()
                .all(|x| x.is_finite());
        if !finite {
            self.reset();
            return Err(Status::Diverged { residual: T::ONE });
        }
        let displacement = from_fn(|i| match given[i] {
            Given::Displacement(u) => u,
            Given::Load(_) => displacement[i],
        });
        let load = from_fn(|i| match given[i] {
            Given::Load(load) => load,
            Given::Displacement(_) => load[i],
        });
        let error = error::errors(&outcome, &u, self.state.size + p.s * c.balls);
        Ok(Solution {
            status,
            iterations,
            error,
            displacement,
            load,
            solver: self,
            point: *p,
        })
    }
}

/// Refuses a value that is not finite, or larger in magnitude than `limit`.
fn check<T: Real>(quantity: Quantity, value: T, limit: T) -> Result<(), Status<T>> {
    if !value.is_finite() {
        return Err(Status::NotFinite { quantity, value });
    }
    if value.abs() > limit {
        return Err(Status::OutOfRange {
            quantity,
            value,
            limit,
        });
    }
    Ok(())
}
