//! How far a step changes what it was worked out from.

use super::newton::{End, Outcome};
use super::{State, are_finite};
use crate::float::Real;
use crate::linalg::norm;
use crate::tuning;

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

impl<T: Real> ErrorEstimate<T> {
    /// Every figure is a number.
    pub(crate) fn is_finite(&self) -> bool {
        are_finite(&[self.displacement, self.force, self.stiffness])
    }
}

/// What the last step leaves unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate<T> {
    /// Change of the stiffness along the step, relative to its diagonal.
    pub k: T,
    /// Largest relative change of a ball's stiffness.
    pub most: T,
    /// What the step leaves of the balls' forces, of second order, relative to the largest.
    pub force: T,
    /// The largest force of a ball on the ring.
    pub largest: T,
    /// Least cosine of the angle between the contacts of a ball.
    pub cos: T,
}

impl<T: Real> Estimate<T> {
    /// Error of the stiffness that its correction along the step leaves: what is of second order, and a small part of the first.
    pub fn corrected(&self) -> T {
        self.k * (self.most + T::of(tuning::CORRECTED))
    }
}

/// Rounding error of the force of a ball, relative to it: its deformation is a difference of numbers like the ring's offset `v`
/// from the reference, or of a unit of length.
#[inline(never)]
pub(super) fn rounding<T: Real, const D: usize>(force: T, v: &[T; D]) -> T {
    let root = force.cbrt();
    let deformation = (root * root).at_least(T::EPSILON);
    let offset = T::ONE + norm(v);
    T::ROUNDING * (T::ONE + offset / deformation)
}

impl<T: Real, const D: usize> State<T, D> {
    /// How far the figures at the displacement `u` can be off: what the last step leaves, and what rounding does. `inertia` is
    /// that of all balls.
    pub(crate) fn errors(&self, u: &[T; D], inertia: T) -> ErrorEstimate<T> {
        let Outcome {
            end,
            estimate,
            step,
            ..
        } = self.attempt.outcome;
        let margin = T::of(tuning::MARGIN);
        let stiffness = match end {
            // The estimate is above what a long step changes by itself.
            End::Unfinished if self.correct => estimate.corrected(),
            // A ball is out of balance, or a correction makes the stiffness no better: nothing is known of it.
            End::Unfinished => estimate.k.at_least(T::ONE),
            _ => margin * estimate.k,
        };
        let rounding = rounding(estimate.largest, &self.at);
        // Where rounding ends a solve, the balance is known to that of the balls' forces, and the last step is not taken.
        let (unbalanced, untaken) = if end == End::Rounded {
            (rounding, step)
        } else {
            (T::EPSILON, T::ZERO)
        };
        let forces = self.size + inertia;
        let moved = T::of(4.0) * T::EPSILON + unbalanced * forces * self.factors.compliance();
        let step = untaken.at_least(margin * step * estimate.most);
        // Constants are worked out in double precision, by some thirty operations each.
        let constants = T::of(64.0 * f64::EPSILON);
        let rounding = rounding + constants;
        let displacement =
            constants + T::of(8.0) * T::EPSILON + (step + moved) / norm(u).at_least(T::TINY);
        ErrorEstimate {
            displacement,
            // Rounding of the ring's displacement, too, changes deformations.
            force: margin * estimate.force + rounding + rounding,
            stiffness: stiffness + rounding,
        }
    }
}
