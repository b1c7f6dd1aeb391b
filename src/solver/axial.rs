//! The equilibrium under a purely axial load: all balls are alike, and one is solved for.

use crate::ball::at_rest::{AxialRest, Centres};
use crate::ball::contact::Point;
use crate::ball::kinematics::{Motion, RacewayControlFree};
use crate::ball::report::{BallState, Kinetics};
use crate::bearing::{Azimuth, Bearing, Constants};
use crate::linalg::add;
use crate::real::Real;
use crate::rows::{BearingRef, Layout};
use crate::solver::problem::{
    Given, OperatingPoint, Problem, Settings, check_tolerance, given_in_units, inertia,
    speed_and_growth,
};
use crate::solver::warm_start::WarmStart;
use crate::status::{ErrorEstimate, Status};
use core::fmt;
use core::marker::PhantomData;

/// A solver for one bearing under a purely axial load, tilts and radial displacements being zero: the memory of one solve for the
/// next.
///
/// At rest it is a closed form; at speed the same loop as in [`Solver`](super::Solver), with one ball for all.
///
/// ```
/// use spindle_bearing::{AxialSolver, Bearing, Design, Settings, Speed, Static};
/// const BEARING: Bearing<f32, 16> = Bearing::<f32, 16>::const_new(&Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians()));
/// let settings = Settings::default();
/// let mut at_rest = AxialSolver::<f32, Static>::of();
/// let k_rest = at_rest.solve(&BEARING, 300.0, Speed::REST, &settings)?.stiffness();
/// let mut at_speed = AxialSolver::new();
/// let k_speed = at_speed.solve(&BEARING, 300.0, Speed::rpm(20_000.0), &settings)?.stiffness();
/// assert!(k_speed < k_rest);
/// # Ok::<(), spindle_bearing::Status<f32>>(())
/// ```
#[derive(Debug, Clone)]
pub struct AxialSolver<T: Real, M: Motion = RacewayControlFree> {
    /// Of a bearing with one ball, which carries its share of the load.
    last: WarmStart<T, 1, 1, 1, 0>,
    motion: PhantomData<M>,
    /// Root of the last solution at rest, 0 without one, and the grooves' centres there.
    root: T,
    centres: Centres<T>,
}

impl<T: Real> AxialSolver<T> {
    /// A solver for bearings at speed, with all inertia loads, raceway-control-free.
    pub const fn new() -> Self {
        Self::of()
    }
}

impl<T: Real, M: Motion> Default for AxialSolver<T, M> {
    /// [`AxialSolver::of`].
    fn default() -> Self {
        Self::of()
    }
}

impl<T: Real, M: Motion> AxialSolver<T, M> {
    /// A solver for the motion that its type names.
    pub const fn of() -> Self {
        Self {
            last: WarmStart::COLD,
            motion: PhantomData,
            root: T::ZERO,
            centres: Centres {
                axial: T::ZERO,
                excess: T::ZERO,
            },
        }
    }

    /// Has the next solve start from nothing.
    pub fn reset(&mut self) {
        self.last.reset();
        self.root = T::ZERO;
    }

    /// The equilibrium at a speed, under the axial load `Fx` (N), or where [`Given`] says the axial displacement (m), from the last
    /// solution if that is near.
    ///
    /// A negative load presses the balls on the other side of the grooves. `at` is a [`Speed`](crate::Speed), or one with the growth
    /// of rings and balls.
    ///
    /// # Errors
    ///
    /// A [`Status`] that names why there is no answer.
    #[inline(always)]
    pub fn solve<'s, const N: usize>(
        &'s mut self,
        bearing: &'s Bearing<T, N>,
        load: impl Into<Given<T>>,
        at: impl Into<OperatingPoint<T, 1>>,
        settings: &Settings<T>,
    ) -> Result<AxialSolution<'s, T, M>, Status<T>> {
        self.run(
            bearing.layout().rows[0].bearing,
            load.into(),
            &at.into(),
            settings,
        )
    }

    #[inline(always)]
    fn run<'s>(
        &'s mut self,
        bearing: BearingRef<'s, T>,
        asked: Given<T>,
        at: &OperatingPoint<T, 1>,
        settings: &Settings<T>,
    ) -> Result<AxialSolution<'s, T, M>, Status<T>> {
        let c = bearing.c;
        check_tolerance(settings.tolerance)?;
        let problem = Problem::new(settings.tolerance);
        let given = given_in_units(c, 0, c.balls, asked)?;
        let [growth] = &at.growth;
        let (omega, growth) = speed_and_growth(c, at.speed, M::AT_SPEED, growth)?;
        let size = match given {
            Given::Load(load) => load.abs().at_least(c.preload),
            Given::Displacement(_) => T::ZERO,
        };
        if matches!(given, Given::Load(_)) && !(size > T::TINY.sqrt_abs()) {
            return Err(Status::Unloaded);
        }
        if self.last.fingerprint != c.fingerprint {
            (self.last.fingerprint, self.root) = (c.fingerprint, T::ZERO);
            if M::AT_SPEED {
                self.last.reset();
            }
        }
        let s = if M::AT_SPEED {
            inertia(c, omega, c.balls, size)
        } else {
            T::ZERO
        };
        if M::AT_SPEED && s > T::ZERO {
            let grown = self.last.rows[0]
                .point
                .set(c, s, size, growth, self.last.state.u[0]);
            return self.at_speed(bearing, asked, given, grown, problem, settings);
        }
        self.last.rows[0].point = Point::new(c, s, size, growth);
        if M::AT_SPEED {
            // Without its references, the last solution at speed is no start, however this solve ends.
            self.last.state.s = T::ZERO;
        }
        self.at_rest(bearing, asked, given, settings)
    }

    /// Newton's method on the root of one ball's deformation.
    #[inline(always)]
    fn at_rest<'s>(
        &'s mut self,
        bearing: BearingRef<'s, T>,
        asked: Given<T>,
        given: Given<T>,
        settings: &Settings<T>,
    ) -> Result<AxialSolution<'s, T, M>, Status<T>> {
        let c = bearing.c;
        let balls = AxialRest::new(c, &self.last.rows[0].point.growth);
        let (mut iterations, mut left) = (0, T::ZERO);
        let (centres, contact, dx) = match given {
            Given::Displacement(dx) => {
                let centres = balls.centres_at(dx);
                (centres, balls.contact(&centres), dx)
            }
            // Balls that carry without a load hold the ring in the middle.
            Given::Load(load) if !(load.abs() > T::TINY.sqrt_abs()) => {
                let growth = self.last.rows[0].point.growth.axial;
                let centres = balls.centres_at(-growth);
                let contact = balls.contact(&centres);
                if !(contact.q > T::ZERO) {
                    return Err(Status::Unloaded);
                }
                (centres, contact, -growth)
            }
            Given::Load(load) => {
                let q = load.abs() / c.balls;
                // Newton's steps leave what is of second order.
                let limit = settings.max_iterations.max(1);
                let from = if self.root > T::ZERO {
                    self.root
                } else {
                    T::HUGE
                };
                let found = balls.root(from, q, T::EPSILON, limit);
                self.root = found.root;
                if !found.small {
                    return Err(Status::IterationLimit);
                }
                (iterations, left) = (found.iterations, found.left);
                let mut centres = found.centres;
                let dx = balls.displacement(&centres, load < T::ZERO);
                if load < T::ZERO {
                    centres.axial = -centres.axial;
                }
                (centres, found.contact, dx)
            }
        };
        self.centres = centres;
        let [slope, ..] = contact.tangent();
        self.last.state.sum.k[0][0] = slope;
        let error = T::of(6.0) * (T::EPSILON + left);
        Ok(AxialSolution {
            status: Status::Converged,
            iterations,
            error: ErrorEstimate {
                displacement: error + balls.rounding(dx),
                force: error,
                stiffness: error,
            },
            displacement: asked.displacement_or(dx * c.length),
            load: asked.load_or(contact.q * contact.n[0] * (c.force * c.balls)),
            bearing,
            solver: self,
        })
    }

    /// The loop of any bearing, for one with a single ball.
    fn at_speed<'s>(
        &'s mut self,
        bearing: BearingRef<'s, T>,
        asked: Given<T>,
        given: Given<T>,
        grown: T,
        mut problem: Problem<T, 1>,
        settings: &Settings<T>,
    ) -> Result<AxialSolution<'s, T, M>, Status<T>> {
        let c = bearing.c;
        let one = Constants {
            balls: T::ONE,
            ..*c
        };
        match given {
            Given::Load(load) => {
                problem.load[0] = load / c.balls;
                problem.load_scale = problem.load[0].abs().at_least(c.preload / c.balls);
            }
            Given::Displacement(dx) => (problem.prescribed[0], problem.is_free) = (Some(dx), false),
        }
        self.last
            .state
            .turn_to(&problem, self.last.rows[0].point.s, grown);
        let layout = Layout::alone(&one, first(bearing.azimuths));
        let mut more = || true;
        let most = settings.max_iterations;
        let reached = self
            .last
            .run::<M::Rule, _>(&layout, &problem, most, &mut more)?;
        let state = &self.last.state;
        Ok(AxialSolution {
            status: state.attempt.termination.status(),
            iterations: reached.iterations,
            error: state.errors(&reached.u, self.last.rows[0].point.s, false),
            displacement: asked.displacement_or(reached.u[0] * c.length),
            load: asked.load_or(reached.load[0] * c.force * c.balls),
            bearing,
            solver: self,
        })
    }
}

/// Azimuth of the ball that stands for all.
fn first<T>(azimuths: &[Azimuth<T>]) -> &[Azimuth<T>] {
    azimuths.get(..1).unwrap_or_default()
}

/// An equilibrium under a purely axial load, SI units.
pub struct AxialSolution<'s, T: Real, M: Motion = RacewayControlFree> {
    /// How the solve ended: `Converged` or `PrecisionLimit`.
    pub status: Status<T>,
    /// Iterations, those after a start included. An iteration condenses one ball.
    pub iterations: u16,
    /// How far the figures below can be off.
    pub error: ErrorEstimate<T>,
    /// Axial displacement `dx` of the inner ring, m.
    pub displacement: T,
    /// Axial force `Fx` on the inner ring, N; the reaction where the displacement was given.
    pub load: T,
    bearing: BearingRef<'s, T>,
    solver: &'s AxialSolver<T, M>,
}

impl<T: Real, M: Motion> fmt::Debug for AxialSolution<'_, T, M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AxialSolution")
            .field("status", &self.status)
            .field("iterations", &self.iterations)
            .field("error", &self.error)
            .field("displacement", &self.displacement)
            .field("load", &self.load)
            .field("stiffness", &self.stiffness())
            .finish_non_exhaustive()
    }
}

#[cfg(feature = "defmt")]
impl<T: Real, M: Motion> defmt::Format for AxialSolution<'_, T, M> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "{} after {} iterations, errors {}; displacement {}, load {}, stiffness {}",
            self.status,
            self.iterations,
            self.error,
            self.displacement,
            self.load,
            self.stiffness()
        );
    }
}

impl<T: Real, M: Motion> AxialSolution<'_, T, M> {
    /// Axial stiffness `dFx/dx` at constant speed, N/m.
    pub fn stiffness(&self) -> T {
        let (c, last) = (self.bearing.c, &self.solver.last);
        let k = if M::AT_SPEED && last.rows[0].point.is_at_speed() {
            let layout = Layout::alone(c, first(self.bearing.azimuths));
            last.tangent::<M::Rule, _>(&layout)[0][0]
        } else {
            last.state.sum.k[0][0]
        };
        k * (c.force * c.balls / c.length)
    }

    /// State of the ball that stands for all, at the azimuth of the first one.
    pub fn ball(&self) -> BallState<T> {
        let (solver, p) = (self.solver, &self.solver.last.rows[0].point);
        let c = self.bearing.c;
        let kinetics = if M::AT_SPEED && p.is_at_speed() {
            let a = add(p.low, [solver.last.state.v[0], T::ZERO]);
            solver.last.rows[0].balls[0].kinetics::<M::Rule>(c, p, a)
        } else {
            Kinetics::at_rest(c, &AxialRest::new(c, &p.growth).contact(&solver.centres))
        };
        match self.bearing.azimuths.first() {
            Some(first) => kinetics.state(c, first),
            None => BallState::default(),
        }
    }
}
