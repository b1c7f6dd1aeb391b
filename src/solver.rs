//! The equilibrium under given loads, and the bearing's own law under given displacements.
//!
//! One damped Newton on the arrow-shaped system; at rest, where balls have no unknowns, the `rest` module's
//! part of it. Each sweep linearises every ball, which eliminates
//! its own unknowns, and sums what the balls hand to the ring. Far from the solution the ring then looks
//! for the load's balance among the balls' laws (the `spring` module), which agree with the
//! linearisation in value and slope; near it, and after a warm start, it makes Newton's step. The tangent
//! of the last sweep, corrected to first order by what that step changes of both contacts' stiffness and
//! direction, is the stiffness.
//!
//! Why it ends:
//!
//! - With inertia and friction forces frozen, the equilibrium minimises a convex function of ring and
//!   ball positions jointly: contact energies are convex and increasing functions of distances, and
//!   the groove centres move affinely with the ring. Every position of the ring has one equilibrium of
//!   each ball, and with the balls eliminated what is left is convex in the ring's displacement. It
//!   grows without bound in every direction in which three or more balls resist, so that it has a
//!   minimum, and one only.
//! - The ring's own iteration works on the sum of the balls' laws, each of which is the derivative of
//!   a convex potential. A step is the solution of a system whose matrix is made positive definite
//!   where it is not (Levenberg 1944), hence a descent direction, and is halved until the slope along
//!   it has not turned over by more than half: such an iteration cannot be trapped short of the
//!   minimum. It costs no linearisation of a ball. Halvings are four at most, so that a direction softer by
//!   orders of magnitude can still send it round in a circle; the next start is for that, and the balance
//!   of forces at the end tells.
//! - Inertia loads change with the step; a step that made the balance worse bounds the next one to half of its
//!   length, unless rounding made it: then a ball did.
//! - A ball whose force changes by more than a factor is placed anew by what holds it, and a ball that
//!   is badly off by itself repeats its own Newton step a few times within the sweep.
//!
//! The speed-dependent part is a perturbation that the exact tangent takes in. Where it is not small
//! (contact angles near 90 degrees), there need not be an equilibrium, and the bound on sweeps ends
//! the search.
//!
//! Starts are tried in order, within the caller's bound on sweeps: the last solution, moved by its
//! tangent, its sensitivity to speed and the second-order part of both (contacts stiffen, lines of centres
//! turn) to the new load and speed, if that is near; the axisymmetric state; the same with more preload, in
//! short steps. A start that has not led to a solution after some sweeps, or from which a ball was lost
//! for good, makes room for the next.
//!
//! An answer certifies itself. The last step changes the stiffness by an amount that is known ball by ball,
//! and the stiffness is corrected for it. What the correction does not know is the error of the stiffness:
//! a part of the change that grows with the step, with the share of inertia in the ball's forces, and with the
//! part of the step that rounding may have made. Displacements and forces are one
//! Newton step further, where the change enters as a factor. What rounding leaves comes on top: a displacement
//! in the direction in which the ring gives way most, and what that changes of the stiffness of contacts
//! that carry little. A ball whose contacts no longer oppose each other (150 degrees
//! apart), or that is off the inner race where they would be opposite, is no answer: there the cage speed has a
//! pole, and the equations have roots of no bearing.

use crate::axial::Spring;
use crate::ball::{Ball, COUNTS, Pass, Share};
use crate::conditions::{Conditions, Loads, constrain, held, hold, missing};
use crate::constants::{Azimuth, Bearing, Constants};
use crate::contact::{Pair, add, dot, scale};
use crate::float::Real;
use crate::freedoms::{All, BallStore, FreedomSet, Freedoms};
use crate::kinematics::NEAREST_POLE;
use crate::outputs::{Balls, Outputs, PerBall};
use crate::ring::{self, Definite, Factors, Sums, Tangent, TangentSums, shift};
use crate::scene::{Change, Drive, Full, Motion, Position, Turning, curvature_centre, free_ball};
use crate::status::{Quantity, Status};
use core::marker::PhantomData;

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

/// State of one ball, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct BallState<T> {
    /// Azimuth `phi`, rad from +y towards +z.
    pub azimuth: T,
    /// Inner contact angle, rad.
    pub alpha_i: T,
    /// Outer contact angle, rad.
    pub alpha_o: T,
    /// Inner contact force, N; 0 if the ball is off the inner race.
    pub q_i: T,
    /// Outer contact force, N.
    pub q_o: T,
    /// Deformation of the inner contact, m; negative where there is a gap.
    pub delta_i: T,
    /// Deformation of the outer contact, m.
    pub delta_o: T,
    /// Centrifugal force `Fc`, N.
    pub centrifugal_force: T,
    /// Gyroscopic moment `Mg`, N m.
    pub gyroscopic_moment: T,
}

/// Estimated errors of a solution, relative.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ErrorEstimate<T> {
    /// Of displacements: of the largest component, tilts taken at the pitch radius.
    pub displacement: T,
    /// Of contact forces: of the largest.
    pub force: T,
    /// Of the stiffness: an element's error over the root of the two diagonal elements.
    pub stiffness: T,
}

/// An equilibrium, SI units; forces and displacements refer to the bearing centre. Vectors have as many
/// components as the scene has freedoms, in the order given here.
pub struct Solution<
    's,
    T: Real,
    const N: usize,
    M: Motion,
    F: FreedomSet = All,
    B: Conditions<F> = Loads,
    O: Outputs = Balls,
> {
    /// How the solve ended: `Converged`, `PrecisionLimit`, `SweepLimit` or `Unseated`.
    pub status: Status<T>,
    /// Sweeps over the balls.
    pub sweeps: u16,
    /// Ball passes beyond one a ball and sweep: of balls that were badly off by themselves, and at rest of all.
    pub repeats: u16,
    /// Load less the balls' forces in the last sweep, relative to the load (moments over `Rp`).
    pub residual: T,
    /// How far the figures below can be off.
    pub error: ErrorEstimate<T>,
    /// Displacements `dx, dy, dz` (m), `ty, tz` (rad) of the inner ring.
    pub displacement: F::Vector<T>,
    /// Forces `Fx, Fy, Fz` (N) and moments `My, Mz` (N m) that hold the balls' forces on the ring;
    /// where the displacement was given, this is the reaction.
    pub load: F::Vector<T>,
    /// Stiffness: derivative of the forces (rows) by the displacements (columns) at constant speed, of
    /// the freedoms that are free, with the others held. Not symmetric at speed.
    pub stiffness: O::Stiffness<B::Stiffness<T>>,
    solver: O::Balls<&'s Solver<'s, T, N, M, F, B, O>>,
}

impl<T, const N: usize, M, F, B, O> core::fmt::Debug for Solution<'_, T, N, M, F, B, O>
where
    T: Real,
    M: Motion,
    F: FreedomSet,
    B: Conditions<F>,
    O: Outputs,
{
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Solution")
            .field("status", &self.status)
            .field("sweeps", &self.sweeps)
            .field("repeats", &self.repeats)
            .field("residual", &self.residual)
            .field("error", &self.error)
            .field("displacement", &self.displacement)
            .field("load", &self.load)
            .field("stiffness", &self.stiffness)
            .finish_non_exhaustive()
    }
}

impl<T, const N: usize, const D: usize, M, B, O> Solution<'_, T, N, M, Freedoms<D>, B, O>
where
    T: Real,
    M: Motion,
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// States of the balls, in the order of their azimuths; of the first one, where it stands for all.
    pub fn balls(&self) -> impl ExactSizeIterator<Item = BallState<T>> + '_
    where
        O: PerBall,
    {
        let solver = O::solver(&self.solver);
        let c = &solver.bearing.constants;
        let state = &solver.state;
        let balls = solver.balls.as_ref().iter();
        balls.zip(&solver.bearing.azimuths).map(move |(ball, at)| {
            let a = shift(&state.position.offset, at);
            let pass = M::observe(c, state.speed_load, ball, a);
            BallState {
                azimuth: at.sin.atan2(at.cos),
                alpha_i: pass.inner.sin.atan2(pass.inner.cos),
                alpha_o: pass.outer.sin.atan2(pass.outer.cos),
                q_i: pass.inner.q * c.force,
                q_o: pass.outer.q * c.force,
                delta_i: pass.inner.delta * c.length,
                delta_o: pass.outer.delta * c.length,
                centrifugal_force: pass.loads.centrifugal * c.force,
                gyroscopic_moment: pass.loads.friction * c.force * c.ball_radius,
            }
        })
    }

    /// The bearing's constants, and the contacts and loads of every ball in their units.
    pub(crate) fn passes(&self) -> (&Constants<T>, impl Iterator<Item = Pass<T>> + '_)
    where
        O: PerBall,
    {
        let solver = O::solver(&self.solver);
        let c = &solver.bearing.constants;
        let state = &solver.state;
        let balls = solver.balls.as_ref().iter().zip(&solver.bearing.azimuths);
        let passes = balls.map(move |(ball, at)| {
            let a = shift(&state.position.offset, at);
            M::observe(c, state.speed_load, ball, a)
        });
        (c, passes)
    }

    /// Forces on the inner race alone, N, in the order of the balls: what a monitor looks at, without
    /// the cost of contact angles.
    pub fn inner_forces(&self) -> impl ExactSizeIterator<Item = T> + '_
    where
        O: PerBall,
    {
        let solver = O::solver(&self.solver);
        let c = &solver.bearing.constants;
        let state = &solver.state;
        let balls = solver.balls.as_ref().iter();
        balls.zip(&solver.bearing.azimuths).map(move |(ball, at)| {
            let a = shift(&state.position.offset, at);
            M::observe(c, state.speed_load, ball, a).inner.q * c.force
        })
    }
}

#[cfg(feature = "nalgebra")]
impl<T, const N: usize, const D: usize, M, B, O> Solution<'_, T, N, M, Freedoms<D>, B, O>
where
    T: Real + nalgebra::Scalar,
    M: Motion,
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// The displacement as a vector of `nalgebra`.
    pub fn displacement_vector(&self) -> nalgebra::SVector<T, D> {
        nalgebra::SVector::from(self.displacement)
    }

    /// The stiffness as a matrix of `nalgebra`.
    pub fn stiffness_matrix<const K: usize>(&self) -> nalgebra::SMatrix<T, K, K>
    where
        O: Outputs<Stiffness<B::Stiffness<T>> = [[T; K]; K]>,
    {
        nalgebra::SMatrix::from_fn(|i, j| self.stiffness[i][j])
    }
}

#[cfg(feature = "defmt")]
impl<T, const N: usize, M, F, B, O> defmt::Format for Solution<'_, T, N, M, F, B, O>
where
    T: Real,
    M: Motion,
    F: FreedomSet,
    B: Conditions<F>,
    O: Outputs,
{
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "{} after {} sweeps, residual {}, errors {}; displacement {}, load {}, stiffness {}",
            self.status,
            self.sweeps,
            self.residual,
            self.error,
            self.displacement,
            self.load,
            self.stiffness
        );
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
#[derive(Debug, Clone)]
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

/// What is given: the load on the ring, or its displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Given<T, const D: usize> {
    Load([T; D]),
    Displacement([T; D]),
}

/// What is to be solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Task<T, const D: usize> {
    pub given: Given<T, D>,
    /// Displacements of held freedoms.
    pub wanted: [T; D],
    pub speed_load: T,
    pub tolerance: T,
}

/// How sweeps ended.
pub struct Outcome<T> {
    pub status: Status<T>,
    pub sweeps: u16,
    pub repeats: u16,
    pub residual: T,
    /// Relative change of the stiffness by the last step, what of that the corrected tangent does not know,
    /// and the step's length.
    pub change: T,
    pub remainder: T,
    pub step: T,
    /// The balls' hardening in the last step, as in [`Change`].
    pub hardening: T,
    /// How far the worst ball was from its own equilibrium before that step.
    pub imbalance: T,
    /// Last sweeps in a row whose tangent left a direction undetermined.
    singular: u8,
    /// How far the ring gives way where it is weakest to a unit of load, as the last step saw it.
    weakest: T,
    /// The same to what rounding leaves of the balance.
    slack: T,
    /// What rounding may hide of the balance where it ends a solve, relative to the load.
    pub unknown: T,
}

impl<T: Real> Outcome<T> {
    fn new() -> Self {
        Self {
            status: Status::SweepLimit,
            sweeps: 0,
            repeats: 0,
            residual: T::ONE,
            change: T::ONE,
            remainder: T::ONE,
            step: T::ONE,
            hardening: T::ZERO,
            imbalance: T::ONE,
            singular: 0,
            weakest: T::ZERO,
            slack: T::ZERO,
            unknown: T::EPSILON,
        }
    }

    /// Notes how the tangent resists where it does so least.
    #[inline(always)]
    pub fn weaken(&mut self, weakness: &Weakness<T>) {
        self.weakest = weakness.flexibility;
        self.singular = if weakness.singular {
            self.singular.saturating_add(1)
        } else {
            0
        };
    }

    /// Whether every ball is as near to its own equilibrium as the tolerance wants: its step leaves the
    /// square of its imbalance.
    #[inline(always)]
    fn is_settled(&self, tolerance: T) -> bool {
        self.imbalance * self.imbalance <= T::of(0.1) * tolerance.or_larger(T::EPSILON)
    }

    /// Whether the last step is so short that linearisations hold.
    #[inline(always)]
    fn is_short(&self) -> bool {
        self.step <= T::of(thresholds::SHORT_STEP)
    }

    /// How a solve ends with the last sweep, if the forces are in balance and it does. `rounded_part` is the
    /// part of the step that rounding may have made, `largest` the largest displacement.
    #[inline(always)]
    pub fn ending(
        &self,
        course: &Course<T>,
        rounding: &Rounding<T>,
        rounded_part: T,
        tolerance: T,
        largest: T,
    ) -> Option<Status<T>> {
        let singular = self.singular > 0;
        let ten = T::of(10.0);
        let near = self.change <= ten * tolerance;
        let settled = self.is_settled(tolerance);
        // The corrected tangent is better than the change. Forces are good to the change's square,
        // displacements to the change times the step.
        let corrected = !singular
            && T::of(4.0) * self.remainder <= tolerance
            && ten * self.change * self.change <= tolerance
            && ten * self.change * self.step <= tolerance * largest;
        let converged = settled && (corrected || self.change <= tolerance);
        // Under light loads deformations have few digits, and the balance tells that it is as good as
        // rounding allows.
        let rounded =
            self.residual <= rounding.balance && self.remainder < T::of(thresholds::UNKNOWN);
        // Rounding ends the solve where the change no longer shrinks, or near the tolerance where it has
        // made most of the step; a pause of one sweep far from the tolerance is not that yet.
        let exhausted = (self.change <= T::EPSILON.sqrt() || rounded)
            && self.imbalance < T::of(thresholds::AT_ODDS)
            && (course.stalled >= if near && settled { 1 } else { 3 }
                || (near && settled && rounded_part > T::of(0.5)))
            && self.sweeps > 1;
        // A ring that rocks on two balls does not stiffen them, which says nothing of where it comes to rest.
        if !(self.is_short() || singular) {
            return None;
        }
        if converged {
            Some(Status::Converged)
        } else {
            exhausted.then_some(Status::PrecisionLimit)
        }
    }

    /// Whether the next sweep takes the balls' laws. Short steps need none, unless they lead nowhere: a ball
    /// about to open is not linear. A bearing that gives way in some direction can be in balance and yet far
    /// from the solution.
    #[inline(always)]
    fn needs_laws(&self, course: &Course<T>, tolerance: T) -> bool {
        self.residual > T::of(thresholds::NEEDS_LAWS)
            || !self.is_short()
            || (course.stuck && !self.is_settled(tolerance))
    }

    /// Errors of a solution whose largest displacement is `largest`; `inertia` is about the share that inertia
    /// has in the balls' forces. The numbers are regressions on the campaign's cases, of single and double
    /// precision together: quantiles of 99.9 % of the error's logarithm.
    fn error(&self, largest: T, inertia: T, growth: T) -> ErrorEstimate<T> {
        // Rounding of what the solver works out, and of the bearing's constants, which are worked out in
        // doubles: at speed there are more of them.
        let rounding = |own: f64, constants: f64, at_speed: f64| {
            T::EPSILON * T::of(own)
                + T::of(constants * f64::EPSILON)
                + T::of(at_speed * f64::EPSILON) * inertia
        };
        // Where the ring gives way to what rounding leaves of the balance, deformations go with it, and
        // with them the stiffness of contacts that carry little.
        let gives = self.slack * growth;
        // Where that moves the ring by a hundredth of its way, or contacts by many deformations, or a step that
        // rounding stops changes the stiffness by a hundredth, nothing is known of the displacement.
        let per_largest = T::ONE / largest.or_larger(T::TINY);
        let slack = self.slack * per_largest;
        let unknown = T::of(1e4);
        // What a Newton step leaves is of second order.
        let own = self.imbalance * self.imbalance;
        let squared = self.change * self.change;
        let step = self.step * per_largest;
        let (displacement, force, stiffness) = match self.status {
            // The change is summed over the balls, and an element sees some of them only.
            Status::Converged => (
                T::of(4.0) * self.change * step,
                T::of(0.4) * self.remainder + T::of(4.0) * squared + T::of(5e-3) * gives,
                T::of(3.6) * self.remainder + T::of(0.22) * self.change,
            ),
            // Steps that rounding stops can be a small part of the way, and change the stiffness on it.
            _ => (
                T::of(32.0) * step + unknown * squared,
                self.change + self.residual + T::of(4.0) * self.slack + T::of(5e-4) * gives,
                T::of(12.0) * self.remainder + T::of(2.0) * self.change,
            ),
        };
        ErrorEstimate {
            displacement: rounding(3.0, 27.0, 98.0)
                + T::of(3.7) * slack
                + unknown * slack * slack
                + T::of(2e-3) * gives * gives
                + displacement,
            force: rounding(10.0, 12.0, 360.0) + T::of(6.0) * own + force,
            stiffness: rounding(2.4, 28.0, 300.0)
                + T::of(0.022) * gives
                + T::of(300.0) * own
                + stiffness,
        }
    }
}

/// How a tangent resists where it does so least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weakness<T> {
    /// A direction is undetermined.
    pub singular: bool,
    /// Flexibility along the direction of the smallest pivot.
    flexibility: T,
}

impl<T: Real> Weakness<T> {
    /// Nothing gives way.
    pub const NONE: Self = Self {
        singular: false,
        flexibility: T::ZERO,
    };
}

/// What decides how a start goes on. Steps of the ring are in units of `L0`, residuals relative to the load;
/// numbers with two digits are those of their neighbourhood with which the campaign's cases went best.
pub mod thresholds {
    /// Longest step of the ring.
    pub const LONGEST_STEP: f64 = 0.3;
    /// Longest step over which linearisations hold: after a longer one there is another sweep.
    pub const SHORT_STEP: f64 = 0.035;
    /// Step that rounding may have made, at most, in roundings of `L0`.
    pub const ROUNDED_STEP: f64 = 100.0;
    /// Residual beyond which the next sweep takes laws; and that of a sweep without them beyond which it is
    /// repeated with them.
    pub const NEEDS_LAWS: f64 = 0.055;
    pub const MISSES_LAWS: f64 = 0.1;
    /// Imbalance of a ball beyond which its law and its linearisation do not agree, and rounding alone does
    /// not end a solve.
    pub const AT_ODDS: f64 = 0.03;
    /// Residual over the last one: below it steps may grow, and above it a sweep led nowhere.
    pub const WENT_WELL: f64 = 0.42;
    pub const LED_NOWHERE: f64 = 0.5;
    /// Residual over the last one, at most, and residual in tolerances, at least, of a sweep that another is
    /// sure to follow.
    pub const GOES_ON: (f64, f64) = (0.3, 100.0);
    /// Change of the stiffness over the last one above which a sweep made no progress.
    pub const NO_PROGRESS: f64 = 0.25;
    /// What rounding may have left unknown of the stiffness where the balance alone ends a solve.
    pub const UNKNOWN: f64 = 0.035;
    /// Residual of an answer, at most.
    pub const BALANCED: f64 = 1e-3;
    /// Part of the load that the laws' balance may leave of it, and the steps it takes for that, at most.
    pub const LAWS_LEAVE: f64 = 0.045;
    pub const LAWS_STEPS: u8 = 12;
    /// Unbalanced load, of all of it, so small that laws are linear over the step.
    pub const LINEAR: f64 = 1e-3;
    /// Offset from a reference, or step of a ball, that would cost digits of the deformations.
    pub const FAR_FROM_REFERENCE: f64 = 2e-3;
    /// Sweeps in a row that a ball may be lost in, for all its own steps, before the start is.
    pub const LOST: u8 = 3;

    /// Those of a search at rest.
    pub mod at_rest {
        /// Part of the load's balance at the beginning of a sweep that ends it, and its passes over the balls, at
        /// most.
        pub const LEFT: f64 = 0.02;
        pub const PASSES: u8 = 16;
        /// Sweeps in which deformations may lead.
        pub const LEADING: u16 = 8;
        /// Part of a deformation by which geometry differs from it, at most, to lead.
        pub const AGREES: f64 = 0.067;
        /// Part of the load that a contact may carry at once that a step closes.
        pub const CLOSES: f64 = 0.1;
        /// That contact's deformation over the ring's offset from its reference, from which on this serves as long
        /// as steps are long.
        pub const SERVES: f64 = 0.03;
        /// Force of each ball from which a step along the grooves counts little.
        pub const HEAVY: f64 = 0.01;
        /// Part of a heavier load that may be left unbalanced when it is lightened, and what is left of it then.
        pub const LIGHTENS_AT: f64 = 0.3;
        pub const LIGHTENED: f64 = 0.2;
        /// How many times larger the force along a step may be behind it, the other way round; and how often
        /// a step is halved for it.
        pub const TURNED: f64 = 20.0;
        pub const HALVED: u8 = 4;
        /// Residual over the last one below which a pass made progress, and residual in roundings below which
        /// that says nothing.
        pub const FALLS: f64 = 0.3;
        pub const NOISE: f64 = 8.0;
        /// Part of the load that a ball must carry to hold the ring.
        pub const NOTHING: f64 = 1e-12;
        /// Roundings of the balance that light contacts may hide.
        pub const HIDDEN: f64 = 128.0;
    }
}
use thresholds::LONGEST_STEP;

/// Where a solve starts, in the order in which starts are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attempt {
    /// From the last solution.
    Warm,
    /// From the axisymmetric state.
    Cold,
    /// From there with more preload.
    Preloaded,
}

impl Attempt {
    const ALL: [Self; 3] = [Self::Warm, Self::Cold, Self::Preloaded];

    /// Sweeps after which the next start is worth more than going on. From a start that is any good
    /// most solves take fewer than 10.
    const fn sweeps(self) -> u16 {
        match self {
            Self::Warm => 10,
            Self::Cold => 40,
            Self::Preloaded => u16::MAX,
        }
    }

    /// Preload of a start from nothing, in units of what keeps balls loaded at first sight.
    pub const fn preload(self) -> f64 {
        match self {
            Self::Warm | Self::Cold => 1.0,
            Self::Preloaded => 4.0,
        }
    }

    /// Length of the first step at most, in units of `L0`; it grows while steps succeed. Where the first
    /// start led nowhere, short steps keep balls on the branch of the equilibrium on which both races hold
    /// them.
    const fn first_step(self) -> f64 {
        match self {
            Self::Warm | Self::Cold => LONGEST_STEP,
            Self::Preloaded => 0.06,
        }
    }
}

/// What rounding leaves, relative to the load: of the balance at most, and of it what makes steps. Balls round
/// their forces, which are centrifugal ones where the load is light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rounding<T> {
    balance: T,
    pub step: T,
}

impl<T: Real> Rounding<T> {
    #[inline(always)]
    pub fn of(speed_load: T, size: T) -> Self {
        let inertia = T::of(2.0) * speed_load / size.or_larger(T::TINY);
        Self {
            balance: T::EPSILON * (T::of(256.0) + inertia),
            step: T::EPSILON * (T::of(4.0) + inertia),
        }
    }
}

/// How a start has gone so far, and what that means for the next sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course<T> {
    /// Longest step of the ring.
    radius: T,
    /// Balls hand over their laws.
    laws: bool,
    last_residual: T,
    /// The last step led nowhere.
    stuck: bool,
    /// Sweeps in a row without progress of the stiffness.
    stalled: u8,
    /// Sweeps in a row in which a ball was lost.
    lost: u8,
    /// Of the last damping.
    pub rung: u8,
}

impl<T: Real> Course<T> {
    #[inline(always)]
    pub fn new(attempt: Attempt) -> Self {
        Self {
            radius: T::of(attempt.first_step()),
            laws: attempt != Attempt::Warm,
            last_residual: T::ONE / T::EPSILON,
            stuck: false,
            stalled: 0,
            lost: 0,
            rung: 0,
        }
    }

    /// Judges what the last `step` led to: a residual, which is `enough` for an answer. Returns whether another
    /// sweep is sure to follow if there may be one, since no answer can be the tangent that this one leaves.
    #[inline(always)]
    fn judge(&mut self, residual: T, step: T, enough: T) -> bool {
        let last = self.last_residual;
        // Where rounding made the step, a ball made the balance worse; and under so small a bound any step would
        // pass for the last one.
        let moved = step > T::of(thresholds::ROUNDED_STEP) * T::EPSILON;
        if moved && residual > T::ONE.or_larger(last + last) {
            self.radius = T::of(0.5) * step;
        } else if residual < T::of(thresholds::WENT_WELL) * last {
            self.radius = T::of(LONGEST_STEP).or_smaller(self.radius.or_larger(step + step));
        }
        self.stuck = residual > T::of(thresholds::LED_NOWHERE) * last;
        self.last_residual = residual;
        !self.laws && residual > enough && residual < T::of(thresholds::GOES_ON.0) * last
    }

    /// Compares the change of the stiffness with the last one.
    #[inline(always)]
    pub fn compare(&mut self, change: T, last: T) {
        self.stalled = if change > T::of(thresholds::NO_PROGRESS) * last {
            self.stalled.saturating_add(1)
        } else {
            0
        };
    }

    /// Whether the start leads nowhere: a ball that its own steps do not bring back is lost, and the start
    /// with it, unless it is the last one.
    #[inline(always)]
    fn is_hopeless(&mut self, imbalance: T, attempt: Attempt) -> bool {
        self.lost = if imbalance >= T::ONE {
            self.lost.saturating_add(1)
        } else {
            0
        };
        self.lost >= thresholds::LOST && attempt != Attempt::Preloaded
    }
}

/// Relative change of the stiffness by a unit of deformation at the inner contacts, from the balls' hardening
/// as in [`Change`].
#[inline(always)]
fn growth<T: Real, const D: usize>(hardening: T, tangent: &Tangent<T, D>) -> T {
    if D < 3 {
        return T::ZERO;
    }
    // Balls' stiffnesses along their contacts add up to this.
    let sum = tangent[0][0] + tangent[1][1] + tangent[2][2];
    let growth = T::of(1.0 / 3.0) * hardening / sum.or_larger(T::TINY);
    growth.or_smaller(T::ONE / T::EPSILON)
}

/// A change of stiffness, axial and radial and summed over the balls, relative to the tangent.
#[inline(always)]
pub fn relative<T: Real, const D: usize>(change: &Pair<T>, tangent: &Tangent<T, D>) -> T {
    let mut part = change[0] / tangent[0][0].or_larger(T::TINY);
    if D >= 3 {
        let radial = tangent[1][1].or_smaller(tangent[2][2]);
        part = part.or_larger(change[1] / radial.or_larger(T::TINY));
    }
    // Not all that a step changes is summed: on the campaign's cases, half as much again makes the tolerance
    // hold.
    if part.is_finite() {
        T::of(1.5) * part
    } else {
        T::ONE
    }
}

#[inline(never)]
pub fn dot5<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> T {
    let mut sum = T::ZERO;
    for (x, y) in a.iter().zip(b) {
        sum += *x * *y;
    }
    sum
}

pub fn norm<T: Real, const D: usize>(f: &[T; D]) -> T {
    if D == 1 {
        return f[0].abs();
    }
    dot5(f, f).sqrt()
}

/// The side of the grooves on which an axial load presses the balls: 1 for that of the free contact angle.
pub fn side<T: Real, const D: usize>(load: &[T; D]) -> T {
    if load[0] < T::ZERO { -T::ONE } else { T::ONE }
}

/// Copies a ball. As a function by itself, since the compiler then knows that these are two, and copies
/// memory straight away; one after the other, since it would copy many of them field by field.
#[inline(never)]
fn copy<B: Copy>(from: &B, to: &mut B) {
    *to = *from;
}

#[inline(never)]
fn finite<T: Real>(values: &[T]) -> bool {
    values.iter().all(|x| x.is_finite())
}

/// A bound on how far a displacement of the ring shifts any groove centre.
pub fn span<T: Real, const D: usize>(u: &[T; D]) -> T {
    let mut axial = u[0].abs();
    if D == 5 {
        axial += (u[3] * u[3] + u[4] * u[4]).sqrt();
    }
    if D >= 3 {
        return axial.or_larger((u[1] * u[1] + u[2] * u[2]).sqrt());
    }
    axial
}

/// One bearing's iteration: constants, azimuths, and the state it works on.
pub struct Iteration<'i, T: Real, M: Motion, B, O, const D: usize> {
    pub c: &'i Constants<T>,
    pub azimuths: &'i [Azimuth<T>],
    pub state: &'i mut State<T, D>,
    pub balls: &'i mut [M::Ball<T>],
    /// All balls are in the same state, so that one is worked out for all.
    alike: bool,
    scene: PhantomData<(B, O)>,
}

impl<T: Real, M: Turning, B, O, const D: usize> Iteration<'_, T, M, B, O, D>
where
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// Linearises all balls at the present position; returns how many steps of their own they made, and
    /// the largest imbalance that is left.
    fn sweep(&mut self, drive: &Drive<T>, laws: bool) -> (u16, T) {
        let mut sums = Sums::about(self.state.mean);
        let mut total: u16 = 0;
        let mut worst = T::ZERO;
        let mut share = Share::NONE;
        let mut known = false;
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let a = shift(&self.state.position.offset, at);
            if !known {
                let (imbalance, repeats);
                (share, imbalance, repeats) =
                    M::settled::<T, D>(self.c, drive, ball, a, (T::of(0.01), 8), laws);
                worst = worst.or_larger(imbalance);
                total = total.saturating_add(repeats);
            }
            sums.add(at, &share, false);
            known = self.alike;
        }
        if let (true, [first, others @ ..]) = (self.alike, &mut *self.balls) {
            for other in others {
                copy(first, other);
            }
        }
        self.alike = false;
        self.state.force = sums.force();
        self.state.mean = sums.mean(ring::sharing::<T, D>(self.c));
        self.state.tangent = sums.tangent(false);
        (total, worst)
    }

    /// Moves the ring by `du` and every ball with it, by its linearisation, and, where no sweep is sure to
    /// follow, the tangent with them: by `correction` of what the step changes of it.
    fn advance(&mut self, du: &[T; D], correction: Option<T>) -> Change<T> {
        let mut all = Change::<T>::default();
        let mut sums = TangentSums::<T, D>::new();
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let da = shift(du, at);
            if correction.is_some() {
                let more = M::stiffening(self.c, ball, da);
                let sizes = [more.tangent[0].abs(), more.tangent[2].abs()];
                all.stiffness = add(all.stiffness, sizes);
                all.remainder = add(all.remainder, scale(more.unknown, sizes));
                all.hardening += more.hardening;
                if O::STIFFNESS {
                    sums.add(at, &more.tangent);
                }
            }
            all.step = all.step.or_larger(M::advance(ball, da));
        }
        if let (true, Some(part)) = (O::STIFFNESS, correction) {
            for (row, more) in self.state.tangent.iter_mut().zip(&sums.tangent()) {
                for (element, more) in row.iter_mut().zip(more) {
                    *element += part * *more;
                }
            }
        }
        for (offset, step) in self.state.position.offset.iter_mut().zip(du) {
            *offset += *step;
        }
        all
    }

    /// Moves the ring by `du` and every ball with it, by its law.
    fn follow(&mut self, drive: &Drive<T>, du: &[T; D]) -> Change<T> {
        let mut all = Change::<T>::default();
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let a = shift(&self.state.position.offset, at);
            all.merge(M::follow(self.c, drive, ball, a, shift(du, at)));
        }
        for (offset, step) in self.state.position.offset.iter_mut().zip(du) {
            *offset += *step;
        }
        all
    }

    /// Moves all references next to the present position.
    fn rebase(&mut self) {
        self.state.position.rebase();
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let (coarse, fine) = curvature_centre(self.c, &self.state.position.reference, at);
            M::rebase(self.c, ball, coarse, fine);
        }
    }

    /// Puts the ring at `u`, and every ball where it belongs without further knowledge.
    fn place(&mut self, u: &[T; D], speed_load: T) {
        self.state.position = Position {
            reference: [T::ZERO; D],
            offset: *u,
        };
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let a = shift(u, at);
            *ball = Ball::<T>::default();
            let centre = [self.c.n0[0].high + a[0], self.c.n0[1].high + a[1]];
            M::place(self.c, speed_load, ball, centre);
        }
        self.rebase();
    }

    /// A start from nothing: the axisymmetric state at speed in which balls are pressed as at rest. Where freedoms
    /// are held, these start where they are `wanted`, and every ball where it belongs without further knowledge.
    fn start(&mut self, load: &[T; D], wanted: &[T; D], speed_load: T, preload: T) {
        let c = self.c;
        let (q, x) = self.pressed(load, preload);
        let (sign, balls) = (side(load), ring::sharing::<T, D>(c));
        if B::HOLDS {
            self.state.mean = [T::ZERO; 2];
            self.place(&self.displaced(x, wanted), speed_load);
            return;
        }

        // One ball stands for all.
        let drive = Drive {
            speed_load,
            negligible: T::EPSILON * q * balls,
        };
        let mut position = Position::UNLOADED;
        position.offset[0] = x;
        position.rebase();
        let top = Azimuth {
            cos: T::ONE,
            sin: T::ZERO,
            cos_low: T::ZERO,
            sin_low: T::ZERO,
        };
        let (coarse, fine) = curvature_centre(c, &position.reference, &top);
        let mut ball = Ball::<T>::default();
        let mut offset = position.offset[0];
        let centre = [coarse[0] + fine[0] + offset, coarse[1] + fine[1]];
        M::place(c, speed_load, &mut ball, centre);
        M::rebase(c, &mut ball, coarse, fine);
        // The ball alone on the outer race, just touched by the inner one, bounds the
        // equilibrium from the one side, the ball at rest from the other.
        let (free, _) = free_ball(c, speed_load, centre);
        let reach = c.inner * c.inner - (centre[1] - free) * (centre[1] - free);
        let touch = sign * reach.or_larger(T::ZERO).sqrt() - coarse[0] - fine[0];
        let (mut low, mut high) = if sign > T::ZERO {
            (touch, offset)
        } else {
            (offset, touch)
        };
        let bracket = low < high && reach > T::ZERO;
        for _ in 0..20 {
            let centre = [coarse[0] + fine[0] + offset, coarse[1] + fine[1]];
            M::place(c, speed_load, &mut ball, centre);
            let (share, _, _) = M::settled::<T, D>(
                c,
                &drive,
                &mut ball,
                [offset, T::ZERO],
                (T::of(0.02), 5),
                false,
            );
            self.state.mean = [share.force[1], share.force[0] - share.couple];
            let b = sign * q - share.force[0];
            if b.abs() < T::of(0.1) * q {
                break;
            }
            if b > T::ZERO {
                low = offset;
            } else {
                high = offset;
            }
            let step = b / share.stiffness[0][0].or_larger(T::of(1e-6));
            let mut new = offset + step.or_smaller(T::of(0.2)).or_larger(T::of(-0.2));
            if bracket && !(new > low && new < high) {
                new = T::of(0.5) * (low + high);
            }
            offset = new;
        }
        position.offset[0] = offset;
        position.rebase();
        let (coarse, fine) = curvature_centre(c, &position.reference, &top);
        M::rebase(c, &mut ball, coarse, fine);
        self.state.position = position;
        // The others follow in the first sweep.
        if let Some(first) = self.balls.first_mut() {
            copy(&ball, first);
        }
        self.alike = true;
    }

    /// Moves a solved bearing to where its last linearisation, and what of the second order matters,
    /// see it under a new load at a new speed.
    fn predict(&mut self, load: &[T; D], wanted: &[T; D], speed_load: T) {
        let faster = if self.state.speed_load > T::ZERO {
            speed_load / self.state.speed_load - T::ONE
        } else {
            T::ZERO
        };
        let mut sums = [T::ZERO; D];
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let share = M::accelerate(ball, faster);
            ring::spread(&mut sums, at, share.force, share.couple);
        }
        let mut b = *load;
        for i in 0..D {
            b[i] -= self.state.load[i] + sums[i];
        }
        let du = self.extrapolation(b, wanted, |c, ball, da| M::second_order(c, ball, da));
        self.advance(&du, None);
    }

    /// What the balls' laws see after a step `du`: load less their forces, put in `b`, and the tangent there.
    fn unbalanced(
        &mut self,
        load: &[T; D],
        du: &[T; D],
        b: &mut [T; D],
        tangent: &mut Tangent<T, D>,
    ) {
        let mut beyond = Sums::about([T::ZERO; 2]);
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let (force, stiffness) = M::beyond(ball, shift(du, at));
            beyond.add(
                at,
                &Share {
                    force,
                    stiffness,
                    ..Share::NONE
                },
                false,
            );
        }
        let force = beyond.force();
        *tangent = beyond.tangent(false);
        for i in 0..D {
            b[i] = load[i] - (self.state.force[i] + force[i]);
            for j in 0..D {
                let linear = self.state.tangent[i][j];
                b[i] -= linear * du[j];
                tangent[i][j] += linear;
            }
        }
        hold::<T, B, D>(self.c, &[T::ZERO; D], b, tangent);
    }

    /// The step of the ring to where the balls' laws balance the load, no longer than `longest`, from
    /// the unbalanced load `b` and the tangent before it; and how that tangent resists where it does so
    /// least. By itself, so that sweeps of warm solves have the registers.
    #[inline(never)]
    fn step(
        &mut self,
        load: &[T; D],
        mut b: [T; D],
        mut tangent: Tangent<T, D>,
        longest: T,
        rung: &mut u8,
    ) -> ([T; D], Weakness<T>) {
        let first = norm(&b);
        let small = T::of(thresholds::LINEAR) * norm(load);
        let mut du = [T::ZERO; D];
        let mut weakness = Weakness::NONE;
        for pass in 0..thresholds::LAWS_STEPS {
            let (d, of_pass) = self.descent(&b, &tangent, &du, longest, first <= small, rung);
            if pass == 0 {
                weakness = of_pass;
            }
            if first <= small {
                // The laws are linear over so short a step.
                return (d, weakness);
            }
            let slope = dot5(&b, &d);
            let (from, mut fraction) = (du, T::ONE);
            loop {
                for ((to, from), part) in du.iter_mut().zip(&from).zip(&d) {
                    *to = *from + fraction * *part;
                }
                self.unbalanced(load, &du, &mut b, &mut tangent);
                if dot5(&b, &d) >= T::of(-0.5) * slope || fraction < T::of(0.1) {
                    break;
                }
                fraction = fraction * T::of(0.5);
            }
            if !(norm(&b) > T::of(thresholds::LAWS_LEAVE) * first) {
                break;
            }
        }
        (du, weakness)
    }
}

impl<T: Real, M: Motion, B, O, const D: usize> Iteration<'_, T, M, B, O, D>
where
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// What each ball carries under the axial load and so much preload that radial load and moment do not unload
    /// balls at first sight, and the axial displacement that belongs to it at rest. From above, Newton on a 3/2
    /// law does not overshoot. `preload` multiplies all of it.
    pub fn pressed(&self, load: &[T; D], preload: T) -> (T, T) {
        let c = self.c;
        let mut pressing = load[0].abs();
        if D >= 3 {
            pressing += T::of(0.5) * (load[1] * load[1] + load[2] * load[2]).sqrt();
        }
        if D == 5 {
            pressing += (load[3] * load[3] + load[4] * load[4]).sqrt();
        }
        let q = preload * pressing / ring::sharing::<T, D>(c);
        let (s0, mut w) = (c.n0[0].high, T::ONE);
        for _ in 0..24 {
            let step = Spring::at(s0, w).step(q);
            w = (w - step).or_larger(T::of(0.1) * w);
            if step.abs() <= T::of(0.01) * w {
                break;
            }
        }
        (q, side(load) * Spring::at(s0, w).axial - s0)
    }

    /// The step to where the last tangent sees the ring under a load that is larger by `b`, and what each ball's
    /// force does `beyond` that tangent on the way there takes back.
    #[inline(always)]
    pub fn extrapolation(
        &mut self,
        mut b: [T; D],
        wanted: &[T; D],
        beyond: impl Fn(&Constants<T>, &mut M::Ball<T>, Pair<T>) -> Pair<T>,
    ) -> [T; D] {
        let mut own = [[T::ZERO; D]; D];
        let by = missing::<T, B, D>(self.c, wanted, &self.state.position.total());
        let tangent = held::<T, B, D>(self.c, &by, &mut b, &self.state.tangent, &mut own);
        let (factors, _) = Factors::of(tangent, T::of(8.0) * T::EPSILON);
        let mut du = factors.solve(&b);
        let mut sums = [T::ZERO; D];
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let force = beyond(self.c, ball, shift(&du, at));
            ring::spread(&mut sums, at, force, T::ZERO);
        }
        hold::<T, B, D>(self.c, &[T::ZERO; D], &mut sums, &mut own);
        for (step, back) in du.iter_mut().zip(&factors.solve(&sums)) {
            *step -= *back;
        }
        constrain::<T, B, D>(self.c, &by, &mut du);
        du
    }

    /// The axial displacement `x`, and what held freedoms are `wanted` to have.
    pub fn displaced(&self, x: T, wanted: &[T; D]) -> [T; D] {
        let mut u = [T::ZERO; D];
        u[0] = x;
        let missing = missing::<T, B, D>(self.c, wanted, &u);
        let mut step = [T::ZERO; D];
        constrain::<T, B, D>(self.c, &missing, &mut step);
        for (u, step) in u.iter_mut().zip(&step) {
            *u += *step;
        }
        u
    }

    /// One Newton step from `du`, shortened where it would lead further than `longest` and turned
    /// downhill where the tangent is not positive definite: by adding to its diagonal. Close to the
    /// solution (`close`) an indefinite tangent is taken as it is. Of a ladder of such dampings it takes
    /// the first that does; those above it mostly do, too, so that the search begins next to the last
    /// one's `rung`.
    #[inline(always)]
    pub fn descent(
        &self,
        b: &[T; D],
        tangent: &Tangent<T, D>,
        du: &[T; D],
        longest: T,
        close: bool,
        rung: &mut u8,
    ) -> ([T; D], Weakness<T>) {
        // Higher than the step bound can need.
        const HIGHEST: u8 = 13;
        let on = |rung: u8| self.damped(b, tangent, du, longest, close, rung);
        let (mut d, weakness, mut holds) = on(0);
        if holds {
            return (d, weakness);
        }
        let mut at = (*rung).saturating_sub(2).max(1);
        (d, _, holds) = on(at);
        if holds {
            while at > 1
                && let (lower, _, true) = on(at - 1)
            {
                d = lower;
                at -= 1;
            }
        }
        while !holds && at < HIGHEST {
            at += 1;
            (d, _, holds) = on(at);
        }
        *rung = at;
        (d, weakness)
    }

    /// The Newton step from `du` under the damping of a rung, none at 0 and four times as much on each as
    /// on the last; what the damped tangent has of weak directions, and whether the step leads downhill and no
    /// further than `longest`.
    #[inline(never)]
    fn damped(
        &self,
        b: &[T; D],
        tangent: &Tangent<T, D>,
        du: &[T; D],
        longest: T,
        close: bool,
        rung: u8,
    ) -> ([T; D], Weakness<T>, bool) {
        let mut damping = T::ZERO;
        if rung > 0 {
            damping = T::of(1e-4) * norm(b) / longest;
            for _ in 1..rung {
                damping = damping * T::of(4.0);
            }
        }
        let (factors, definite) = Factors::damped(tangent, damping, T::of(8.0) * T::EPSILON);
        let mut d = factors.solve(b);
        constrain::<T, B, D>(self.c, &[T::ZERO; D], &mut d);
        let mut to = *du;
        for (sum, part) in to.iter_mut().zip(&d) {
            *sum += *part;
        }
        let downhill = definite == Definite::Positive || (close && definite == Definite::No);
        let weakness = Weakness {
            singular: definite == Definite::Semi,
            flexibility: factors.weakest(),
        };
        (d, weakness, downhill && span(&to) <= longest)
    }
}

impl<T: Real, M: Turning, B, O, const D: usize> Iteration<'_, T, M, B, O, D>
where
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// Starts as an `attempt` does, and sweeps until converged, or until there were as many sweeps as the
    /// attempt is worth, and `until` at most.
    #[inline(always)]
    pub fn seek(
        &mut self,
        outcome: &mut Outcome<T>,
        task: &Task<T, D>,
        attempt: Attempt,
        until: u16,
    ) {
        let Task {
            given,
            wanted,
            speed_load,
            ..
        } = task;
        let worth = outcome.sweeps.saturating_add(attempt.sweeps());
        match (given, attempt) {
            (Given::Displacement(u), _) => {
                self.place(u, *speed_load);
                return self.run(outcome, task, attempt, until);
            }
            (Given::Load(load), Attempt::Warm) => self.predict(load, wanted, *speed_load),
            // Each with its constant in line, which leaves warm solves more registers.
            (Given::Load(load), Attempt::Cold) => {
                let preload = T::of(Attempt::Cold.preload());
                self.start(load, wanted, *speed_load, preload);
            }
            (Given::Load(load), Attempt::Preloaded) => {
                let preload = T::of(Attempt::Preloaded.preload());
                self.start(load, wanted, *speed_load, preload);
            }
        }
        self.run(outcome, task, attempt, worth.min(until));
    }

    /// Sweeps until converged, or until there were `until` of them.
    fn run(&mut self, outcome: &mut Outcome<T>, task: &Task<T, D>, attempt: Attempt, until: u16) {
        let Task {
            given,
            speed_load,
            tolerance,
            ..
        } = *task;
        let given = &given;
        let applied = match given {
            Given::Load(load) => norm(load),
            Given::Displacement(_) => T::ZERO,
        };
        let mut size = applied;
        let drive = Drive {
            speed_load,
            negligible: T::EPSILON * size,
        };
        let rounding = Rounding::of(speed_load, size);
        let mut course = Course::new(attempt);
        outcome.status = Status::SweepLimit;
        // Nothing to compare the first sweep with.
        (outcome.change, outcome.step) = (T::ONE, T::ZERO);
        loop {
            let (repeats, imbalance) = self.sweep(&drive, course.laws);
            outcome.sweeps += 1;
            outcome.repeats = outcome.repeats.saturating_add(repeats);
            if B::HOLDS {
                size = size.or_larger(norm(&self.state.force)).or_larger(T::TINY);
            }

            let (mut du, mut weakness, mut far) = ([T::ZERO; D], Weakness::NONE, false);
            if let Given::Load(load) = given {
                let mut b = *load;
                for (b, force) in b.iter_mut().zip(&self.state.force) {
                    *b -= *force;
                }
                let (none, mut own) = ([T::ZERO; D], [[T::ZERO; D]; D]);
                let mut tangent =
                    held::<T, B, D>(self.c, &none, &mut b, &self.state.tangent, &mut own);
                // Balls next to their own equilibrium have laws that agree with the linearisation here.
                if course.laws && imbalance > T::of(thresholds::AT_ODDS) {
                    self.unbalanced(load, &none, &mut b, &mut own);
                    tangent = &own;
                }
                outcome.residual = norm(&b) / size;
                let follows = outcome.sweeps < until;
                if !course.laws && outcome.residual > T::of(thresholds::MISSES_LAWS) && follows {
                    course.laws = true;
                    continue;
                }
                let enough = rounding
                    .balance
                    .or_larger(T::of(thresholds::GOES_ON.1) * tolerance);
                far = course.judge(outcome.residual, outcome.step, enough) && follows;
                (du, weakness) = if course.laws {
                    let tangent = *tangent;
                    self.step(load, b, tangent, course.radius, &mut course.rung)
                } else {
                    self.descent(&b, tangent, &du, course.radius, true, &mut course.rung)
                };
            } else {
                outcome.residual = T::ZERO;
            }
            outcome.weaken(&weakness);
            // The part of the step that rounding may have made.
            let unbalanced = match given {
                Given::Load(_) => outcome.residual,
                Given::Displacement(_) => imbalance,
            };
            let rounded_part = rounding.step / unbalanced.or_larger(rounding.step);
            let moved = if course.laws {
                self.follow(&drive, &du)
            } else {
                // As far as rounding made the step, the states before and after it are equally good.
                self.advance(&du, (!far).then_some(T::ONE - T::of(0.5) * rounded_part))
            };
            outcome.step = span(&du);
            outcome.imbalance = imbalance;
            if !(outcome.step + outcome.residual).is_finite() {
                outcome.status = Status::Diverged {
                    residual: outcome.residual,
                };
                return;
            }
            let last = outcome.change;
            (outcome.change, outcome.remainder) = (T::ONE, T::ONE);
            if !far {
                outcome.change = relative(&moved.stiffness, &self.state.tangent);
                outcome.remainder =
                    relative(&moved.remainder, &self.state.tangent) + outcome.change * rounded_part;
            }
            outcome.hardening = moved.hardening;
            course.compare(outcome.change, last);
            // Progress of held scenes is measured by the largest forces seen; what is left must be small beside
            // the forces as they are.
            let scale = if B::HOLDS {
                applied.or_larger(norm(&self.state.force))
            } else {
                size
            };
            let balanced = outcome.residual * size <= T::of(thresholds::BALANCED) * scale;
            let largest = span(&self.state.position.total());
            let ending = outcome.ending(&course, &rounding, rounded_part, tolerance, largest);
            if let (true, Some(status)) = (balanced, ending) {
                // The forces, too, are those after the step.
                for (force, row) in self.state.force.iter_mut().zip(&self.state.tangent) {
                    *force += dot5(row, &du);
                }
                outcome.status = if weakness.singular {
                    Status::Indeterminate {
                        loaded_balls: self.loaded_balls(speed_load),
                    }
                } else {
                    status
                };
                return;
            }
            if outcome.sweeps >= until || course.is_hopeless(imbalance, attempt) {
                return;
            }
            course.laws = outcome.needs_laws(&course, tolerance);
            // Offsets this large would cost digits of the deformations.
            let far = T::of(thresholds::FAR_FROM_REFERENCE);
            if span(&self.state.position.offset) > far || !(moved.step <= far) || repeats > 0 {
                self.rebase();
            }
        }
    }
}

impl<T: Real, M: Motion, B, O, const D: usize> Iteration<'_, T, M, B, O, D>
where
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    fn loaded_balls(&self, speed_load: T) -> u16 {
        let mut count = 0;
        for (ball, at) in self.balls.iter().zip(self.azimuths) {
            let a = shift(&self.state.position.offset, at);
            let pass = M::observe(self.c, speed_load, ball, a);
            count += u16::from(pass.inner.q > T::ZERO);
        }
        count
    }

    /// The carrying ball whose contacts are furthest apart, if those are past opposing each other; or one off
    /// the inner race whose centrifugal force, at the pole of the cage speed, counts beside the load's norm
    /// `size`.
    fn unseated(&self, speed_load: T, size: T) -> Option<Status<T>> {
        let least_force = T::of(COUNTS) * T::EPSILON * size;
        let (mut least, mut worst) = (T::ZERO, None);
        for (index, (ball, at)) in (0..).zip(self.balls.iter().zip(self.azimuths)) {
            let a = shift(&self.state.position.offset, at);
            let Pass { inner, outer, .. } = M::observe(self.c, speed_load, ball, a);
            let opposed = dot(inner.normal(), outer.normal());
            let at_pole = outer.q > least_force && opposed < T::of(NEAREST_POLE - 1.0);
            if (inner.q > T::ZERO || at_pole) && opposed < least {
                let across = dot(inner.normal(), outer.tangent());
                let apart = across.abs().atan2(opposed);
                (least, worst) = (opposed, Some(Status::Unseated { ball: index, apart }));
            }
        }
        worst
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
        let c = &self.bearing.constants;
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
        let mut run = self.iteration();
        let mut outcome = Outcome::new();
        for attempt in Attempt::ALL {
            if attempt == Attempt::Warm && !warm {
                continue;
            }
            M::seek(
                &mut run,
                &mut outcome,
                &task,
                attempt,
                settings.max_sweeps.max(1),
            );
            let failed = matches!(outcome.status, Status::SweepLimit | Status::Diverged { .. });
            if !failed || outcome.sweeps >= settings.max_sweeps {
                break;
            }
        }
        let mut size = norm(&load);
        if B::HOLDS {
            size = size.or_larger(norm(&self.state.force));
        }
        self.conclude(outcome, load, size, speed_load, |i| {
            B::HELD[i].then(|| values[i])
        })
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
        let c = &self.bearing.constants;
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
        let c = &self.bearing.constants;
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
        let c = &self.bearing.constants;
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
        let last = &self.state;
        let mut change = *load;
        for (new, old) in change.iter_mut().zip(&last.load) {
            *new -= *old;
        }
        if B::HOLDS {
            let c = &self.bearing.constants;
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

    pub(crate) fn iteration(&mut self) -> Iteration<'_, T, M, B, O, D> {
        Iteration {
            c: &self.bearing.constants,
            azimuths: &self.bearing.azimuths,
            state: &mut self.state,
            balls: self.balls.as_mut(),
            alike: false,
            scene: PhantomData,
        }
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
    ) -> Result<Solution<'_, T, N, M, Freedoms<D>, B, O>, Status<T>> {
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
                if M::AT_SPEED
                    && let Some(unseated) = self.iteration().unseated(speed_load, size)
                {
                    outcome.status = unseated;
                }
            }
            refusal => {
                self.forget();
                return Err(refusal);
            }
        }
        let c = &self.bearing.constants;
        let total = self.state.position.total();
        // What is left of the balance when rounding ends the solve is not only rounding of the load.
        let unbalanced = match outcome.status {
            Status::PrecisionLimit => outcome.unknown.or_larger(outcome.residual),
            _ => T::EPSILON,
        };
        outcome.slack = (unbalanced * size * outcome.weakest).or_smaller(T::ONE);
        let inertia = ring::sharing::<T, D>(c) * speed_load;
        let forces = inertia + T::of(10.0) * size;
        let error = outcome.error(
            span(&total),
            inertia / forces.or_larger(T::TINY),
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
        Ok(Solution {
            status: outcome.status,
            sweeps: outcome.sweeps,
            repeats: outcome.repeats,
            residual: outcome.residual,
            error,
            displacement,
            load,
            stiffness: O::stiffness(B::stiffness(&stiffness)),
            solver: O::balls(self),
        })
    }

    /// Pure axial load at rest: one ball is one spring, and needs no linearised bearing.
    fn balance(
        &mut self,
        load: [T; D],
        settings: &Settings<T>,
    ) -> Result<Solution<'_, T, N, M, Freedoms<D>, B, O>, Status<T>> {
        let c = &self.bearing.constants;
        let s0 = c.n0[0].high + c.n0[0].low;
        let (q, reversed) = (load[0].abs(), load[0] < T::ZERO);
        let mut w = Spring::root_at(s0, self.state.position.total()[0]);
        let mut spring = Spring::at(s0, w);
        let (mut status, mut sweeps) = (Status::SweepLimit, 0);
        let step = loop {
            let least = T::of(0.1) * w;
            let next = (w - spring.step(q)).or_larger(least).or_smaller(T::of(2.0));
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
            self.balls.as_mut(),
            spring.centres(c.n0[1].high + c.n0[1].low, reversed),
        );
        let error = T::of(6.0) * (T::EPSILON + left);
        let mut stiffness = [[T::ZERO; D]; D];
        if O::STIFFNESS {
            stiffness[0][0] = spring.stiffness();
        }
        let mut carried = load;
        carried[0] = sign * force;
        Ok(Solution {
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
            stiffness: O::stiffness(B::stiffness(&ring::stiffness_out(c, &stiffness))),
            solver: O::balls(self),
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
