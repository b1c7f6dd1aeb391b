//! Where a solver is: the shaft's position, the balls' sum there, the attempt that led there, and the errors of it.

use crate::bearing::L0;
use crate::linalg::{Factors, moved, norm, vector};
use crate::real::Real;
use crate::rows::row::{Estimate, Sum};
use crate::rows::{Pass, Rows};
use crate::solver::problem::Problem;
use crate::status::{ErrorEstimate, Status};
use crate::tuning;

/// Position of the shaft and sum of its balls, kept between solves, in the units of the constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<T, const D: usize> {
    /// Reference position of the groove plane, along the axis, and the offset of the ring from it.
    pub u: [T; D],
    pub v: [T; D],
    /// Offset where the balls were condensed last, and what they handed over, referred to the shaft's centre.
    pub at: [T; D],
    pub sum: Sum<T, D>,
    /// Factors of the tangent; `plain` if it was undamped, and no displacement prescribed.
    pub factors: Factors<T, D>,
    pub plain: bool,
    /// The stiffness has yet to follow the last step.
    pub stale: bool,
    /// Load of the last solve, its size with reactions, and inertia `m dm omega^2 / 2`.
    pub load: [T; D],
    pub load_scale: T,
    pub s: T,
    /// Displacements that were given to it; none of them counts if it was free.
    pub prescribed: [Option<T>; D],
    pub is_free: bool,
    /// Load that was asked for, about the point that it was asked for at, and fingerprint of loads that had a position.
    pub asked: [T; D],
    pub placed: u32,
    /// A pivot of the undamped tangent is no more than rounding: nothing holds the shaft in some direction.
    pub weak: bool,
    /// The last attempt, and how it ended.
    pub attempt: Attempt<T, D>,
}

impl<T: Real, const D: usize> State<T, D> {
    /// Of a solver without history: all bits are zero, so that a static is in `.bss`.
    pub const COLD: Self = Self {
        u: [T::ZERO; D],
        v: [T::ZERO; D],
        at: [T::ZERO; D],
        sum: Sum::NONE,
        factors: Factors::NONE,
        plain: false,
        stale: false,
        load: [T::ZERO; D],
        load_scale: T::ZERO,
        s: T::ZERO,
        prescribed: [None; D],
        is_free: false,
        asked: [T::ZERO; D],
        placed: 0,
        weak: false,
        attempt: Attempt::NONE,
    };

    /// Turns to the next problem, at its inertia and change of the growth.
    ///
    /// A solution is a start where the growth differs by no more than a unit of length, about a deformation. An unfinished
    /// attempt at another problem goes on as one without a start, from where the shaft is: a pass that was left begins again, and a
    /// start is given up.
    pub fn turn_to(&mut self, problem: &Problem<T, D>, s: T, grown: T) {
        if !(grown <= T::ONE) {
            self.load_scale = T::ZERO;
        }
        if self.attempt.termination == Termination::Unfinished
            && (grown > T::ZERO || s != self.s || !self.was(problem))
        {
            (self.attempt.started, self.attempt.control.last.work) = (false, T::ZERO);
            // Loads at other places deflect an elastic shaft before the next pass.
            self.attempt.back &= problem.placed == self.placed;
            if self.attempt.pass.starts {
                self.load_scale = T::ZERO;
            }
            self.attempt.pass = Pass::NONE;
        }
    }

    /// Whether the last solve had these loads and displacements.
    fn was(&self, problem: &Problem<T, D>) -> bool {
        problem.load == self.asked
            && problem.is_free == self.is_free
            && problem.placed == self.placed
            && (self.is_free || problem.prescribed == self.prescribed)
    }

    /// Displacement of the centre.
    pub fn displacement(&self, plane: T) -> [T; D] {
        moved(-plane, &vector(|i| self.u[i] + self.v[i]))
    }
}

/// How the loop ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Termination {
    /// A figure is not a number, or the attempt has had its iterations and led to no equilibrium. None has begun yet.
    Lost,
    /// The last step changes the stiffness by less than the tolerance.
    Converged,
    /// Rounding is larger than the tolerance.
    Rounded,
    /// The balls leave the ring free to move in some direction.
    Singular,
    /// The time was up.
    Unfinished,
}

impl Termination {
    /// There is an answer.
    pub const fn is_solved(self) -> bool {
        matches!(self, Self::Converged | Self::Rounded)
    }

    /// The status of a solution, or of what an unfinished attempt has reached.
    pub const fn status<T>(self) -> Status<T> {
        match self {
            Self::Rounded => Status::PrecisionLimit,
            Self::Unfinished => Status::IterationLimit,
            _ => Status::Converged,
        }
    }
}

/// An attempt at an equilibrium, from the last solution or from a start, over several calls if need be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attempt<T, const D: usize> {
    /// It began with a start.
    pub started: bool,
    /// Iterations so far.
    pub taken: u16,
    /// How it ended.
    pub termination: Termination,
    pub report: StepReport<T>,
    pub control: Control<T, D>,
    /// After the last pass, the step before it was taken back.
    pub back: bool,
    /// The next pass, or the one that has begun.
    pub pass: Pass<T>,
}

impl<T: Real, const D: usize> Attempt<T, D> {
    /// No attempt yet.
    pub const NONE: Self = Self {
        started: false,
        taken: 0,
        termination: Termination::Lost,
        report: StepReport {
            estimate: Estimate {
                k: T::ZERO,
                relative: T::ZERO,
                force: T::ZERO,
                largest: T::ZERO,
                cos: T::ZERO,
            },
            residual: T::ZERO,
            step: T::ZERO,
        },
        control: Control {
            radius: T::ZERO,
            least: T::ZERO,
            last: Step {
                du: [T::ZERO; D],
                work: T::ZERO,
                damped: false,
            },
        },
        back: false,
        pass: Pass::NONE,
    };

    /// Begins an attempt.
    pub fn begin(&mut self, started: bool) {
        (self.started, self.taken, self.back) = (started, 0, false);
        self.pass = Pass::NONE;
        self.termination = Termination::Lost;
        self.report = StepReport::NONE;
        self.control.radius = T::of(L0 * tuning::FIRST_RADIUS);
        self.control.least = T::of(tuning::DAMPING);
        self.control.last.work = T::ZERO;
    }

    /// The attempt has had its iterations: [`tuning::ATTEMPT`], or twice as many where the balance is near. One from the last
    /// solution, `taken` iterations long in this call, leaves as many for a start.
    pub fn is_used_up(&self, taken: u16) -> bool {
        let most = tuning::ATTEMPT;
        if self.taken <= most && taken <= most {
            return false;
        }
        self.taken >= 2 * most
            || (self.taken > most && self.report.residual > T::of(tuning::COARSE))
            || (!self.started && taken > most)
    }
}

/// Report of the last step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepReport<T> {
    pub estimate: Estimate<T>,
    /// Unbalanced force before the last step, over the load.
    pub residual: T,
    /// Length of the last step.
    pub step: T,
}

impl<T: Real> StepReport<T> {
    /// Residual that rounding of the balls' forces at the ring's offset `v` explains, that of each force capped at `most`.
    #[cold]
    #[inline(never)]
    pub fn rounding<const R: usize, const SET: bool, const E: usize, const D: usize>(
        &self,
        rows: &Rows<'_, T, R, SET, E, D>,
        problem: &Problem<T, D>,
        v: &[T; D],
        most: T,
    ) -> T {
        let largest = self.estimate.largest;
        let size = problem.load_scale.at_least(*rows.preload).at_least(largest);
        let forces = rows.layout.ball_count * largest / size;
        rounding(largest, v).at_most(most) * forces.at_least(T::ONE)
    }

    /// Before the first iteration.
    pub const NONE: Self = Self {
        estimate: Estimate {
            k: T::ONE,
            relative: T::ONE,
            force: T::ONE,
            largest: T::ONE,
            cos: T::ONE,
        },
        residual: T::ONE,
        step: T::ONE,
    };
}

/// A step of the ring, referred to the shaft's centre, and the work that the unbalanced force before it was to do: 0 where nothing
/// judges the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<T, const D: usize> {
    pub du: [T; D],
    pub work: T,
    pub damped: bool,
}

/// Step control: how long a step may be, and how strongly it is damped at least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control<T, const D: usize> {
    pub radius: T,
    pub least: T,
    pub last: Step<T, D>,
}

/// Rounding of the constants, which are worked out in double precision, by some thirty operations each.
const CONSTANTS: f64 = 64.0 * f64::EPSILON;

/// Rounding error of the force of a ball, relative to it: its deformation is a difference of numbers like the ring's offset `v`
/// from the reference, or of a unit of length.
#[inline(never)]
pub fn rounding<T: Real, const D: usize>(force: T, v: &[T; D]) -> T {
    let root = force.cbrt_or_zero();
    let deformation = (root * root).at_least(T::EPSILON);
    let offset = T::ONE + norm(v);
    T::ROUNDING * (T::ONE + offset / deformation)
}

impl<T: Real, const D: usize> State<T, D> {
    /// How far the figures at the displacement `u` can be off: what the last step leaves, and what rounding does. `inertia` is
    /// that of all balls; a shaft that `is_sprung` has a sleeve.
    pub fn errors(&self, u: &[T; D], inertia: T, is_sprung: bool) -> ErrorEstimate<T> {
        let Attempt {
            termination,
            report,
            ..
        } = &self.attempt;
        let (termination, estimate, step) = (*termination, report.estimate, report.step);
        if termination == Termination::Unfinished {
            return self.errors_so_far(u, inertia, is_sprung);
        }
        let margin = T::of(tuning::MARGIN);
        let rounding = rounding(estimate.largest, &self.at);
        // Where rounding ends a solve, the balance is as good as the balls' forces, and the last step is not taken.
        let (unbalanced, untaken) = if termination == Termination::Rounded {
            (rounding, step)
        } else {
            (T::EPSILON, T::ZERO)
        };
        let forces = self.load_scale + inertia;
        let moved = T::of(4.0) * T::EPSILON + unbalanced * forces * self.factors.compliance();
        let step = untaken.at_least(margin * step * estimate.relative);
        let rounding = rounding + T::of(CONSTANTS);
        ErrorEstimate {
            displacement: T::of(CONSTANTS)
                + T::of(8.0) * T::EPSILON
                + (step + moved) / norm(u).at_least(T::TINY),
            // Rounding of the ring's displacement, too, changes deformations.
            force: margin * estimate.force + rounding + rounding,
            // The margin covers rounding where the last step changes it by more. With a sleeve's, it is a difference.
            stiffness: (margin * estimate.k).at_least(if is_sprung {
                rounding + rounding
            } else {
                rounding
            }),
        }
    }

    /// Errors of an unfinished solve, 1 or more each where nothing is known: a ball is out of balance, the last step was no Newton
    /// step, or its correction makes the stiffness no better.
    #[cold]
    #[inline(never)]
    fn errors_so_far(&self, u: &[T; D], inertia: T, is_sprung: bool) -> ErrorEstimate<T> {
        let (one, margin) = (T::ONE, T::of(tuning::MARGIN));
        let StepReport {
            estimate,
            residual,
            step,
        } = self.attempt.report;
        // Errors include the sleeve; scale them to the shaft's stiffness.
        let scale = if D == 6 && is_sprung {
            self.without_sleeve()
        } else {
            one
        };
        let left = scale * estimate.corrected();
        // Steps to come shrink by the relative change of a ball's stiffness at most, as a geometric series does: a state is known
        // where that change is below 1, and half of it leaves less than the stiffness itself.
        let is_known = self.stale
            && estimate.relative < one
            && left.at_least(scale * estimate.force) < one - T::of(0.5) * estimate.relative;
        // The whole of it is stated, more where the load was unbalanced by much of its size.
        let (ahead, least) = if is_known {
            let ahead = (one + T::of(0.5) * residual) / (one - estimate.relative);
            (ahead, T::ZERO)
        } else {
            (one, margin * scale * estimate.k.at_least(one))
        };
        let stiffness = if is_known {
            // Below 1, from which on nothing is known.
            (ahead * left.at_least(scale * estimate.force)).at_most(T::of(0.99))
        } else {
            least
        };
        let force = margin * ahead * estimate.force;
        // Errors of two balls add up; far off, of all balls.
        let forces = if is_known {
            estimate.largest + estimate.largest
        } else {
            self.load_scale + inertia
        };
        let unbalanced = force * forces + T::EPSILON * self.load_scale;
        let moved = T::of(4.0) * T::EPSILON + unbalanced * self.factors.compliance();
        let step = margin * ahead * step * estimate.relative;
        let rounding = rounding(estimate.largest, &self.at) + T::of(CONSTANTS);
        let displacement =
            T::of(CONSTANTS) + T::of(8.0) * T::EPSILON + (step + moved) / norm(u).at_least(T::TINY);
        ErrorEstimate {
            displacement: displacement.at_least(least),
            force: (force + rounding + rounding).at_least(least),
            stiffness: stiffness + rounding,
        }
    }
}

impl<T: Real, const D: usize> State<T, D> {
    /// Error of the shaft's stiffness with the spring's force held over that of the whole, each relative to its diagonal: it
    /// is the difference `K_ij - K_i5 K_5j / K_55`.
    fn without_sleeve(&self) -> T {
        let k = &self.sum.k;
        let sleeve = k[D - 1][D - 1].abs().at_least(T::TINY);
        let mut largest = T::ONE;
        for i in 0..D - 1 {
            let (whole, part) = (k[i][i], k[i][D - 1] * (k[D - 1][i] / sleeve));
            let left = (whole - part).abs().at_least(T::EPSILON * whole.abs());
            largest = largest.at_least((whole.abs() + part.abs()) / left.at_least(T::TINY));
        }
        largest
    }
}

/// Whether every figure is a finite number.
#[inline(never)]
pub fn are_finite<T: Real>(figures: &[T]) -> bool {
    let mut zero = T::ZERO;
    for x in figures {
        zero += T::ZERO * *x;
    }
    zero == T::ZERO
}
