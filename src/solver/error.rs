//! How far a step changes what it was worked out from.

use super::State;
use super::newton::{End, Outcome};
use crate::contact;
use crate::float::Real;
use crate::linalg::{Matrix, norm};
use crate::ring::Changes;
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
    /// Of a step that makes these changes of the stiffness `k`.
    #[inline(always)]
    pub fn of<const D: usize>(changes: &Changes<T, D>, k: &Matrix<T, D>) -> Self {
        // The largest quotient, with one division.
        let (mut change, mut element) = (T::ZERO, T::ONE);
        for i in 0..D {
            let diagonal = k[i][i].abs().at_least(T::TINY);
            if changes.k[i] * element > change * diagonal {
                (change, element) = (changes.k[i], diagonal);
            }
        }
        let largest = change / element;
        Self {
            k: T::of(3.0) * largest,
            most: changes.most,
            force: changes.lost / changes.largest,
            largest: changes.largest,
            cos: changes.cos,
        }
    }
}

/// Rounding error of the force of a ball, relative to it: its deformation is a difference of numbers like the ring's offset `v`
/// from the reference, or of a unit of length.
#[inline(never)]
pub(super) fn rounding<T: Real, const D: usize>(force: T, v: &[T; D]) -> T {
    let root = force.cbrt();
    let deformation = (root * root).at_least(T::EPSILON);
    let offset = T::ONE + norm(v);
    contact::rounding::<T>() * (T::ONE + offset / deformation)
}

/// How far the figures of a solution can be off: what the last step leaves, and what rounding does. `u` is the
/// displacement, `forces` about the sum of all contact forces.
pub(super) fn errors<T: Real, const D: usize>(
    outcome: &Outcome<T>,
    state: &State<T, D>,
    u: &[T; D],
    forces: T,
) -> ErrorEstimate<T> {
    let margin = T::of(tuning::MARGIN);
    let rounding = rounding(outcome.estimate.largest, &state.at);
    // Where rounding ends a solve, the balance is known to that of the balls' forces, and the last step is not taken.
    let (unbalanced, untaken) = if outcome.end == End::Rounded {
        (rounding, outcome.step)
    } else {
        (T::EPSILON, T::ZERO)
    };
    let moved = T::of(4.0) * T::EPSILON + unbalanced * forces * state.factors.compliance();
    let step = untaken.at_least(margin * outcome.step * outcome.estimate.most);
    // Constants are worked out in double precision, by some thirty operations each.
    let constants = T::of(64.0 * f64::EPSILON);
    let rounding = rounding + constants;
    let displacement =
        constants + T::of(8.0) * T::EPSILON + (step + moved) / norm(u).at_least(T::TINY);
    ErrorEstimate {
        displacement,
        // Rounding of the ring's displacement, too, changes deformations.
        force: margin * outcome.estimate.force + rounding + rounding,
        stiffness: margin * outcome.estimate.k + rounding,
    }
}
