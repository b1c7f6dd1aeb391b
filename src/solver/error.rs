//! How far a step changes what it was worked out from.

use super::State;
use super::newton::Outcome;
use crate::body::Body;
use crate::float::Real;
use crate::linalg::{Matrix, norm};
use crate::ring::{Row, in_full, shift};
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

impl<T: Real, B: Body<T>> Row<'_, T, B> {
    /// Change of the stiffness `k` if the ring makes the step `du`, and the balls follow.
    ///
    /// Every ball's part changes with the relative change of its deformations, and with the turn of its normals.
    pub fn estimate<const D: usize>(&self, du: &[T; D], k: &Matrix<T, D>) -> Estimate<T> {
        let (sums, most, [lost, largest_force, cos]) = self.changes(&in_full(du));
        // The largest quotient, with one division.
        let (mut change, mut element) = (T::ZERO, T::ONE);
        for i in 0..D {
            let diagonal = k[i][i].abs().at_least(T::TINY);
            if sums[i] * element > change * diagonal {
                (change, element) = (sums[i], diagonal);
            }
        }
        let largest = change / element;
        Estimate {
            k: T::of(3.0) * largest,
            most,
            force: lost / largest_force,
            largest: largest_force,
            cos,
        }
    }

    /// Changes of the stiffness's diagonal if the ring makes the step `du`, the largest relative one of a
    /// ball, and its square as it counts in the balls' forces; the largest of these, and the least cosine between contacts.
    #[inline(never)]
    fn changes(&self, du: &[T; 5]) -> ([T; 5], T, [T; 3]) {
        let mut sums = [T::ZERO; 5];
        let (mut most, mut lost, mut largest, mut cos) = (T::ZERO, T::ZERO, T::TINY, T::ONE);
        let mut azimuths = self.azimuths.iter();
        for ball in self.balls.iter() {
            let Some(at) = azimuths.next() else { break };
            let change = ball.change(self.c, shift(du, at));
            let turn = change.turn + change.turn;
            let (cc, ss) = (at.cos * at.cos, at.sin * at.sin);
            let relative = change.depth + turn;
            most = most.at_least(relative);
            cos = cos.at_most(change.cos);
            let [axial, radial] = ball.share().force;
            let force = axial.abs() + radial.abs();
            largest = largest.at_least(force);
            lost = lost.at_least(relative * relative * force + change.off);
            let mixed = turn * change.h[1];
            let (axial, radial) = (change.depth * change.h[0], change.depth * change.h[2]);
            let (axial, radial) = (axial + mixed, radial + mixed);
            let (yy, zz) = (radial * cc, radial * ss);
            sums[1] += yy;
            sums[2] += zz;
            let (yy, zz) = (axial * ss, axial * cc);
            sums[3] += yy;
            sums[4] += zz;
        }
        sums[0] = sums[3] + sums[4];
        (sums, most, [lost, largest, cos])
    }
}

/// What rounding does to the force of a ball, relative to it: a deformation is rounded at about a unit of length,
/// whatever it is.
pub(super) fn rounding<T: Real>(force: T) -> T {
    let root = force.cbrt();
    let deformation = (root * root).at_least(T::EPSILON);
    T::of(10.0) * T::EPSILON * (T::ONE + T::ONE / deformation)
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
    let rounding = rounding(outcome.estimate.largest);
    let moved = T::EPSILON * (T::of(4.0) + forces * state.factors.compliance());
    let step = margin * outcome.step * outcome.estimate.most;
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
