//! The equilibrium under given loads, and the bearing's own law under given displacements.
//!
//! One damped Newton on the arrow-shaped system. `iteration` is what it works on and what every search has in
//! common, `rest` the search where balls have no unknowns, `speed` the one where they have; `course` decides how
//! a search goes on and says how good its answer is, by the table of `thresholds`.
//!
//! Why it ends: with inertia and friction forces frozen, the equilibrium minimises a convex function of ring and
//! ball positions jointly: contact energies are convex and increasing functions of distances, and the groove
//! centres move affinely with the ring. Every position of the ring has one equilibrium of each ball, and with the
//! balls eliminated what is left is convex in the ring's displacement. It grows without bound in every direction
//! in which three or more balls resist, so that it has a minimum, and one only. The speed-dependent part is a
//! perturbation that the exact tangent takes in. Where it is not small (contact angles near 90 degrees), there
//! need not be an equilibrium, and the bound on sweeps ends the search.
//!
//! Starts are tried in order, within the caller's bound on sweeps: the last solution, moved to the new load and
//! speed, if that is near; the state that an axial load would make, or, where the load is nearly radial, the ring
//! that faces it; the solution at a standstill, where inertia does not outweigh the load, and instead of that state
//! where it is next to nothing; the state that an axial load would make with more preload, in short steps. A ball
//! that its own steps have lost is put where the ring's position alone has it; a start that has not led to a
//! solution after some sweeps, or that loses a ball for all that, makes room for the next.
//!
//! A ball whose contacts no longer oppose each other (150 degrees apart), or that is off the inner race where
//! they would be opposite, is no answer: there the cage speed has a pole, and the equations have roots of no
//! bearing.

mod course;
mod iteration;
mod rest;
mod solution;
mod speed;
mod thresholds;

use crate::axial::Spring;
use crate::conditions::{Conditions, Loads, missing};
use crate::constants::{Azimuth, Bearing, Constants};
use crate::float::Real;
use crate::freedoms::{All, BallStore, FreedomSet, Freedoms};
use crate::outputs::{Balls, Outputs};
use crate::ring::{self, Factors, Position, Tangent, dot5, norm, span};
use crate::scene::{Full, Motion};
use crate::status::{Quantity, Status};
use core::marker::PhantomData;

use course::growth;
pub use course::{Attempt, Outcome};
use iteration::Given;
pub use iteration::{Iteration, Task};
pub use rest::Still;
pub use solution::{BallState, ErrorEstimate, Solution};

/// How hard to try.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings<T> {
    /// Most sweeps over the balls, at least 1. At rest a sweep is up to 16 passes, each of which is worked out in
    /// closed form.
    pub max_sweeps: u16,
    /// Largest expected error of the stiffness, relative to its diagonal, for a solve to count as
    /// converged; the estimate that goes with the solution has a margin on it. Displacements and contact
    /// forces are then good to less than that.
    pub tolerance: T,
}

impl<T: Real> Default for Settings<T> {
    /// 100 sweeps; a tolerance of 2e-5 in single and 3e-13 in double precision.
    fn default() -> Self {
        Self {
            max_sweeps: 100,
            tolerance: T::TOLERANCE,
        }
    }
}

/// A solver for one bearing: borrows its constants and owns the state that warm-starts the next
/// solve.
///
/// ```
/// use spindle_bearing::{Bearing, Design, FreeContact, Material, Settings, Solver};
/// let design = Design {
///     ball_diameter: 6.35e-3, pitch_diameter: 36e-3,
///     inner_groove_factor: 0.515, outer_groove_factor: 0.525,
///     free_contact: FreeContact::Angle(15f64.to_radians()), first_ball: 0.0,
///     inner_shoulder_angle: Design::HIGHEST_SHOULDER, outer_shoulder_angle: Design::HIGHEST_SHOULDER,
///     ring: Material::STEEL, ball: Material::STEEL,
/// };
/// let bearing = Bearing::<f32, 16>::new(&design)?;
/// let mut solver = Solver::<f32, 16>::new(&bearing);
/// let speed = 20_000.0 * core::f32::consts::PI / 30.0;
/// let solution = solver.solve([1000.0, 200.0, 0.0, 0.0, 3.0], speed, &Settings::default())?;
/// let [k_x, k_y, k_z] = core::array::from_fn(|i| solution.stiffness[i][i]);
/// assert!(k_y > k_z && k_z > k_x);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// The scene is a matter of types: how the balls move ([`Static`](crate::Static),
/// [`Centrifugal`](crate::Centrifugal) or [`Full`]), the ring's freedoms ([`Axial`](crate::Axial),
/// [`Translations`](crate::Translations) or [`All`]), what is given of each ([`Loads`], or a tuple of
/// [`Load`](crate::Load) and [`Displacement`](crate::Displacement)), and what comes out
/// ([`Displacements`](crate::Displacements), [`Stiffness`](crate::Stiffness) or [`Balls`]).
///
/// ```
/// # use spindle_bearing::{Bearing, Design, FreeContact, Material, Settings};
/// use spindle_bearing::{OuterRaceControl, Full, RigidPreload, All, Solver};
/// # let design = Design {
/// #     ball_diameter: 6.35e-3, pitch_diameter: 36e-3,
/// #     inner_groove_factor: 0.515, outer_groove_factor: 0.525,
/// #     free_contact: FreeContact::Angle(15f64.to_radians()), first_ball: 0.0,
/// #     inner_shoulder_angle: Design::HIGHEST_SHOULDER, outer_shoulder_angle: Design::HIGHEST_SHOULDER,
/// #     ring: Material::STEEL, ball: Material::STEEL,
/// # };
/// let bearing = Bearing::<f64, 16>::new(&design)?;
/// let mut solver = Solver::<f64, 16, Full<OuterRaceControl>, All, RigidPreload>::new(&bearing);
/// // dx in m, then Fy, Fz in N, My, Mz in N m.
/// let solution = solver.solve([12e-6, 200.0, 0.0, 0.0, 0.0], 2000.0, &Settings::default())?;
/// let [preload, ..] = solution.load;
/// let stiffness: [[f64; 4]; 4] = solution.stiffness;
/// assert!(preload > 100.0 && stiffness[0][0] > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Solver<
    'b,
    T: Real,
    const N: usize,
    M: Motion = Full,
    F: FreedomSet = All,
    B: Conditions<F> = Loads,
    O: Outputs = Balls,
> {
    bearing: &'b Bearing<T, N>,
    state: F::State<T>,
    balls: F::Balls<M::Ball<T>, N>,
    scene: PhantomData<(B, O)>,
}

/// What is kept between solves besides the balls, in the units of the constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<T, const D: usize> {
    pub position: Position<T, D>,
    pub tangent: Tangent<T, D>,
    pub force: [T; D],
    /// Mean radial force and moment of the balls.
    pub mean: [T; 2],
    speed_load: T,
    /// Load of the last solve, 0 of held freedoms.
    load: [T; D],
    /// Its norm, reactions included; 0 as long as there is no solution to start from.
    size: T,
}

impl<T: Real, const D: usize> State<T, D> {
    const COLD: Self = Self {
        position: Position::UNLOADED,
        tangent: [[T::ZERO; D]; D],
        force: [T::ZERO; D],
        mean: [T::ZERO; 2],
        speed_load: T::ZERO,
        load: [T::ZERO; D],
        size: T::ZERO,
    };
}

#[inline(never)]
fn finite<T: Real>(values: &[T]) -> bool {
    values.iter().all(|x| x.is_finite())
}

// Not derived: that would clone balls field by field, through a copy on the stack.
impl<T, const N: usize, const D: usize, M, B, O> Clone for Solver<'_, T, N, M, Freedoms<D>, B, O>
where
    T: Real,
    M: Motion,
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    fn clone(&self) -> Self {
        Self { ..*self }
    }

    fn clone_from(&mut self, source: &Self) {
        self.bearing = source.bearing;
        self.state = source.state;
        self.balls = source.balls;
    }
}

impl<'b, T, const N: usize, const D: usize, M, B, O> Solver<'b, T, N, M, Freedoms<D>, B, O>
where
    T: Real,
    M: Motion,
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// A solver without history: its first solve starts from nothing.
    pub fn new(bearing: &'b Bearing<T, N>) -> Self {
        Self {
            bearing,
            state: State::COLD,
            balls: Freedoms::<D>::balls(M::Ball::default()),
            scene: PhantomData,
        }
    }

    /// Forgets the last state, so that the next solve starts from nothing.
    pub fn forget(&mut self) {
        self.state = State::COLD;
    }

    /// Solves the equilibrium of the inner ring under the load `[Fx, Fy, Fz, My, Mz]` (N, N m) at
    /// the shaft speed `speed` (rad/s), starting from the last solution if that is near. Of a freedom
    /// that is held, `values` has the displacement (m, rad) instead; of fewer freedoms, the first ones.
    ///
    /// The scene at rest ([`Static`](crate::Static)) takes no notice of the speed.
    ///
    /// # Errors
    ///
    /// A [`Status`] that names why there is no answer. Input that is refused leaves the solver as
    /// it was; a solve that failed makes the next one start from nothing.
    pub fn solve(
        &mut self,
        values: [T; D],
        speed: T,
        settings: &Settings<T>,
    ) -> Result<Solution<'_, T, N, M, Freedoms<D>, B, O>, Status<T>> {
        let answer = self.slices().solve(values, speed, settings)?;
        Ok(self.solution(answer))
    }

    /// The bearing's own law: forces of the balls on the inner ring, tangent, and states of the balls
    /// for the displacement `[dx, dy, dz, ty, tz]` (m, rad) of the ring at the shaft speed `speed`
    /// (rad/s). The solution's `load` is what holds them.
    ///
    /// # Errors
    ///
    /// As for [`Solver::solve`].
    pub fn law(
        &mut self,
        displacement: [T; D],
        speed: T,
        settings: &Settings<T>,
    ) -> Result<Solution<'_, T, N, M, Freedoms<D>, B, O>, Status<T>> {
        let answer = self.slices().law(displacement, speed, settings)?;
        Ok(self.solution(answer))
    }

    fn slices(&mut self) -> Slices<'_, T, M, B, O, D> {
        Slices {
            c: &self.bearing.constants,
            azimuths: &self.bearing.azimuths,
            state: &mut self.state,
            balls: self.balls.as_mut(),
            scene: PhantomData,
        }
    }

    /// What the scene selects from an answer.
    #[inline(always)]
    fn solution(&self, answer: Answer<T, D>) -> Solution<'_, T, N, M, Freedoms<D>, B, O> {
        Solution {
            status: answer.status,
            sweeps: answer.sweeps,
            repeats: answer.repeats,
            residual: answer.residual,
            error: answer.error,
            displacement: answer.displacement,
            load: answer.load,
            stiffness: O::stiffness(B::stiffness(&answer.stiffness)),
            solver: O::balls(self),
        }
    }

    fn view(&self) -> View<'_, T, M, D> {
        View {
            c: &self.bearing.constants,
            azimuths: &self.bearing.azimuths,
            state: &self.state,
            balls: self.balls.as_ref(),
        }
    }
}

/// An equilibrium in SI units, with the stiffness of all freedoms, held ones included.
struct Answer<T, const D: usize> {
    status: Status<T>,
    sweeps: u16,
    repeats: u16,
    residual: T,
    error: ErrorEstimate<T>,
    displacement: [T; D],
    load: [T; D],
    stiffness: Tangent<T, D>,
}

/// A solved bearing without the ball count in its type: constants, azimuths and what the last solve left.
pub struct View<'v, T: Real, M: Motion, const D: usize> {
    pub c: &'v Constants<T>,
    azimuths: &'v [Azimuth<T>],
    state: &'v State<T, D>,
    balls: &'v [M::Ball<T>],
}

/// A solver without the ball count in its type: bearings of all ball counts share one copy of its code.
struct Slices<'s, T: Real, M: Motion, B, O, const D: usize> {
    c: &'s Constants<T>,
    azimuths: &'s [Azimuth<T>],
    state: &'s mut State<T, D>,
    balls: &'s mut [M::Ball<T>],
    scene: PhantomData<(B, O)>,
}

impl<T, const D: usize, M, B, O> Slices<'_, T, M, B, O, D>
where
    T: Real,
    M: Motion,
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// As [`Solver::solve`].
    fn solve(
        &mut self,
        values: [T; D],
        speed: T,
        settings: &Settings<T>,
    ) -> Result<Answer<T, D>, Status<T>> {
        let c = self.c;
        check(&values, |i| self.range(i, B::HELD[i]))?;
        let speed_load = self.speed_load(speed)?;
        let (mut load, mut wanted) = (values, [T::ZERO; D]);
        if B::HOLDS {
            for (i, (load, wanted)) in load.iter_mut().zip(&mut wanted).enumerate() {
                if B::HELD[i] {
                    (*load, *wanted) = (T::ZERO, *load / ring::units::<T, D>(c, i).0);
                }
            }
        }
        let load = ring::load_in(c, &load);
        // Squares of smaller numbers are lost.
        if !B::HOLDS && !(norm(&load) > T::TINY.sqrt()) {
            return Err(Status::Unloaded);
        }
        if D == 1 && !M::AT_SPEED {
            return self.balance(load, settings);
        }

        let warm = self.is_near(&load, &wanted, speed_load);
        let task = Task {
            given: Given::Load(load),
            wanted,
            speed_load,
            tolerance: settings.tolerance,
        };
        let mut size = norm(&load);
        let until = settings.max_sweeps.max(1);
        let mut run = self.iteration();
        let mut outcome = Outcome::new();
        let attempts = if M::AT_SPEED {
            Attempt::AT_SPEED
        } else {
            Attempt::AT_REST
        };
        for &attempt in attempts {
            let standstill = |below: f64| {
                let inertia = ring::sharing::<T, D>(c) * speed_load;
                // A way there that the bound cuts off has nothing to show.
                let room = until - outcome.sweeps >= Attempt::Standstill.sweeps();
                let counts = speed_load > T::EPSILON * size;
                M::AT_SPEED && !B::HOLDS && room && counts && inertia < T::of(below) * size
            };
            let useless = match attempt {
                Attempt::Warm => !warm,
                Attempt::Cold => standstill(thresholds::LIGHT),
                Attempt::Standstill => !standstill(thresholds::HEAVY),
                Attempt::Preloaded => false,
            };
            if useless {
                continue;
            }
            M::seek(&mut run, &mut outcome, &task, attempt, until);
            let failed = matches!(outcome.status, Status::SweepLimit | Status::Diverged { .. });
            if !failed || outcome.sweeps >= until {
                break;
            }
        }
        if B::HOLDS {
            size = size.at_least(norm(&self.state.force));
        }
        self.conclude(outcome, load, size, speed_load, |i| {
            B::HELD[i].then(|| values[i])
        })
    }

    /// As [`Solver::law`].
    fn law(
        &mut self,
        displacement: [T; D],
        speed: T,
        settings: &Settings<T>,
    ) -> Result<Answer<T, D>, Status<T>> {
        let c = self.c;
        check(&displacement, |i| self.range(i, true))?;
        let speed_load = self.speed_load(speed)?;
        let u = ring::displacement_in(c, &displacement);
        let mut run = self.iteration();
        let task = Task {
            given: Given::Displacement(u),
            wanted: u,
            speed_load,
            tolerance: settings.tolerance,
        };
        let mut outcome = Outcome::new();
        M::seek(
            &mut run,
            &mut outcome,
            &task,
            Attempt::Cold,
            settings.max_sweeps,
        );
        let (factors, _) = Factors::of(&self.state.tangent, T::of(8.0) * T::EPSILON);
        outcome.weakest = factors.weakest();
        let mut load = self.state.force;
        let size = norm(&load);
        for (i, load) in load.iter_mut().enumerate() {
            if B::HELD[i] {
                *load = T::ZERO;
            }
        }
        self.conclude(outcome, load, size, speed_load, |_| None)
    }

    /// What a freedom's load or displacement is called, and the largest that is accepted.
    fn range(&self, freedom: usize, displacement: bool) -> (Quantity, T) {
        let c = self.c;
        let [of_load, of_displacement] = Quantity::OF_FREEDOM[freedom % 5];
        let (length, force) = if freedom < 3 {
            (c.length, c.force)
        } else {
            (c.tilt, c.moment)
        };
        if displacement {
            (of_displacement, length + length)
        } else {
            // Beyond N times the force that would press a ball by the whole groove distance, nothing
            // in the model holds.
            (of_load, force * c.balls)
        }
    }

    /// Checks the speed and turns it into `m dm omega^2 / 2`.
    fn speed_load(&self, speed: T) -> Result<T, Status<T>> {
        let c = self.c;
        // Where a ball's centrifugal force would press it by the whole groove distance.
        let limit = (T::of(4.0) / c.centrifugal).sqrt();
        check(&[speed], |_| (Quantity::Speed, limit))?;
        Ok(if M::AT_SPEED {
            c.centrifugal * speed * speed
        } else {
            T::ZERO
        })
    }

    /// Whether the last solution is a start worth having: load, displacement and speed not too far from
    /// its own.
    fn is_near(&self, load: &[T; D], wanted: &[T; D], speed_load: T) -> bool {
        let last = &*self.state;
        let mut change = *load;
        for (new, old) in change.iter_mut().zip(&last.load) {
            *new -= *old;
        }
        if B::HOLDS {
            let c = self.c;
            let by = missing::<T, B, D>(c, wanted, &last.position.total());
            for (change, row) in change.iter_mut().zip(&last.tangent) {
                *change = change.abs() + dot5(row, &by).abs();
            }
        }
        let half = T::of(0.5);
        (!B::HOLDS || last.size > T::ZERO)
            && norm(&change) <= half * last.size
            && (speed_load - last.speed_load).abs() <= half * last.speed_load + half * last.size
    }

    fn iteration(&mut self) -> Iteration<'_, T, M, B, O, D> {
        Iteration {
            c: self.c,
            azimuths: self.azimuths,
            state: self.state,
            balls: self.balls,
            alike: false,
            scene: PhantomData,
        }
    }

    fn forget(&mut self) {
        *self.state = State::COLD;
    }

    /// Keeps the state as the next solve's start, and makes the solution of it. `size` is that of the load
    /// with its reactions, `held` the displacement of a held freedom.
    fn conclude(
        &mut self,
        mut outcome: Outcome<T>,
        load: [T; D],
        size: T,
        speed_load: T,
        held: impl Fn(usize) -> Option<T>,
    ) -> Result<Answer<T, D>, Status<T>> {
        self.state.speed_load = speed_load;
        self.state.load = load;
        self.state.size = size;
        match outcome.status {
            Status::Converged | Status::PrecisionLimit => {}
            // Not for want of sweeps.
            Status::SweepLimit if outcome.singular > 3 => {
                let loaded_balls = self.iteration().loaded_balls(speed_load);
                self.forget();
                return Err(Status::Indeterminate { loaded_balls });
            }
            Status::SweepLimit => {
                self.state.load = [T::ZERO; D];
                self.state.size = T::ZERO;
                let residual = outcome.residual;
                if M::AT_SPEED
                    && let Some(why) = self.iteration().unseated(speed_load, size, residual)
                {
                    if let Status::Diverged { .. } = why {
                        self.forget();
                        return Err(why);
                    }
                    outcome.status = why;
                }
            }
            refusal => {
                self.forget();
                return Err(refusal);
            }
        }
        let c = self.c;
        let total = self.state.position.total();
        // What is left of the balance when rounding ends the solve is not only rounding of the load.
        let unbalanced = match outcome.status {
            Status::PrecisionLimit => outcome.unknown.at_least(outcome.residual),
            _ => T::EPSILON,
        };
        outcome.slack = (unbalanced * size * outcome.weakest).at_most(T::ONE);
        let inertia = ring::sharing::<T, D>(c) * speed_load;
        let forces = inertia + T::of(10.0) * size;
        let error = outcome.error(
            span(&total),
            inertia / forces.at_least(T::TINY),
            growth(outcome.hardening, &self.state.tangent),
        );
        let mut displacement = ring::displacement_out(c, &total);
        for (i, displacement) in displacement.iter_mut().enumerate() {
            *displacement = held(i).unwrap_or(*displacement);
        }
        let load = ring::load_out(c, &self.state.force);
        let stiffness = if O::STIFFNESS {
            ring::stiffness_out(c, &self.state.tangent)
        } else {
            [[T::ZERO; D]; D]
        };
        if !(finite(&displacement) && finite(&load) && finite(stiffness.as_flattened())) {
            self.forget();
            return Err(Status::Diverged {
                residual: outcome.residual,
            });
        }
        Ok(Answer {
            status: outcome.status,
            sweeps: outcome.sweeps,
            repeats: outcome.repeats,
            residual: outcome.residual,
            error,
            displacement,
            load,
            stiffness,
        })
    }

    /// Pure axial load at rest: one ball is one spring, and needs no linearised bearing.
    fn balance(&mut self, load: [T; D], settings: &Settings<T>) -> Result<Answer<T, D>, Status<T>> {
        let c = self.c;
        let s0 = c.n0[0].high + c.n0[0].low;
        let (q, reversed) = (load[0].abs(), load[0] < T::ZERO);
        let mut w = Spring::root_at(s0, self.state.position.total()[0]);
        let mut spring = Spring::at(s0, w);
        let (mut status, mut sweeps) = (Status::SweepLimit, 0);
        let step = loop {
            let least = T::of(0.1) * w;
            let next = (w - spring.step(q)).at_least(least).at_most(T::of(2.0));
            let step = next - w;
            w = next;
            spring = Spring::at(s0, w);
            sweeps += 1;
            // Newton's steps leave what is of second order.
            if step * step <= T::EPSILON * (w * w) {
                status = Status::Converged;
                break step;
            }
            if sweeps >= settings.max_sweeps {
                break step;
            }
        };
        let left = (step / w) * (step / w);
        let sign = if reversed { -T::ONE } else { T::ONE };
        let force = spring.force();
        self.state.position = Position::UNLOADED;
        self.state.position.reference[0] = spring.displacement(s0, reversed);
        M::rest(
            self.balls,
            spring.centres(c.n0[1].high + c.n0[1].low, reversed),
        );
        let error = T::of(6.0) * (T::EPSILON + left);
        let mut stiffness = [[T::ZERO; D]; D];
        if O::STIFFNESS {
            stiffness[0][0] = spring.stiffness();
        }
        let mut carried = load;
        carried[0] = sign * force;
        Ok(Answer {
            status,
            sweeps,
            repeats: 0,
            residual: (force - q).abs() / q,
            error: ErrorEstimate {
                displacement: error,
                force: error,
                stiffness: error,
            },
            displacement: ring::displacement_out(c, &self.state.position.reference),
            load: ring::load_out(c, &carried),
            stiffness: ring::stiffness_out(c, &stiffness),
        })
    }
}

/// Refuses the first value that is not finite, or larger in magnitude than `range` says.
fn check<T: Real, const L: usize>(
    values: &[T; L],
    range: impl Fn(usize) -> (Quantity, T),
) -> Result<(), Status<T>> {
    for (i, value) in values.iter().enumerate() {
        let (value, (quantity, limit)) = (*value, range(i));
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
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::turning::tests::spindle;

    #[test]
    fn a_solver_that_takes_over_another_goes_on_as_that_one_would() {
        let bearing = spindle();
        let settings = Settings::default();
        let mut solver = Solver::<f32, 16>::new(&bearing);
        solver
            .solve([900.0, 180.0, -40.0, 1.0, 2.5], 2000.0, &settings)
            .unwrap();
        let mut behind = Solver::<f32, 16>::new(&bearing);
        behind
            .solve([300.0, -60.0, 90.0, -0.5, 0.0], 700.0, &settings)
            .unwrap();
        behind.clone_from(&solver);
        let mut copy = solver.clone();
        // One sweep, which the start decides.
        let settings = Settings {
            max_sweeps: 1,
            ..settings
        };
        let [next, taken, copied] = [&mut solver, &mut behind, &mut copy].map(|solver| {
            let solution = solver.solve([910.0, 178.0, -41.0, 1.0, 2.6], 2010.0, &settings);
            let solution = solution.unwrap();
            assert_eq!((solution.status, solution.sweeps), (Status::Converged, 1));
            (solution.displacement, solution.stiffness)
        });
        assert_eq!(next, taken);
        assert_eq!(next, copied);
    }

    #[test]
    fn a_ball_lost_beyond_all_numbers_is_no_figure() {
        let bearing = spindle();
        let mut solver = Solver::<f32, 16>::new(&bearing);
        solver
            .solve(
                [900.0, 180.0, -40.0, 1.0, 2.5],
                2000.0,
                &Settings::default(),
            )
            .unwrap();
        let concluded = |solver: &mut Solver<'_, f32, 16>| {
            let (size, speed_load) = (solver.state.size, solver.state.speed_load);
            let mut slices = solver.slices();
            let answer = slices.conclude(Outcome::new(), [0.0; 5], size, speed_load, |_| None)?;
            let solution = solver.solution(answer);
            Ok(solution.balls().all(|ball| ball.delta_o.is_finite()))
        };
        assert_eq!(concluded(&mut solver.clone()), Ok(true));
        // Its distance squared overflows.
        solver.balls[3].x = [1e25, 0.0];
        let residual = Outcome::<f32>::new().residual;
        assert_eq!(concluded(&mut solver), Err(Status::Diverged { residual }));
        assert_eq!(solver.state.size, 0.0, "a start for the next solve");
    }
}
