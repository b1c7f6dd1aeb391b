//! How far a step changes what it was worked out from.

use super::State;
use super::newton::Outcome;
use crate::float::Real;
use crate::next::linalg::{Matrix, norm};
use crate::next::motion::Body;
use crate::next::ring::{Row, in_full, shift};
use crate::next::tuning;
use crate::solver::ErrorEstimate;

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
}

impl<T: Real, B: Body<T>> Row<'_, T, B> {
    /// Change of the stiffness `k` if the ring makes the step `du`, and the balls follow: of every ball's share by the
    /// relative change of its deformations and by the turn of its normals.
    pub fn estimate<const D: usize>(&self, du: &[T; D], k: &Matrix<T, D>) -> Estimate<T> {
        let (sums, most, [lost, largest_force]) = self.changes(&in_full(du));
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
            k: largest + largest,
            most,
            force: lost / largest_force,
            largest: largest_force,
        }
    }

    /// Changes of the stiffness's diagonal if the ring makes the step `du`, the largest relative one of a
    /// ball, and its square as it counts in the balls' forces.
    #[inline(never)]
    fn changes(&self, du: &[T; 5]) -> ([T; 5], T, [T; 2]) {
        let mut sums = [T::ZERO; 5];
        let (mut most, mut lost, mut largest) = (T::ZERO, T::ZERO, T::TINY);
        let mut azimuths = self.azimuths.iter();
        for ball in self.balls.iter() {
            let Some(at) = azimuths.next() else { break };
            let change = ball.change(self.c, shift(du, at));
            let turn = change.turn + change.turn;
            let (cc, ss) = (at.cos * at.cos, at.sin * at.sin);
            let relative = change.depth + turn;
            most = most.at_least(relative);
            let [axial, radial] = ball.share().force;
            let force = axial.abs() + radial.abs();
            largest = largest.at_least(force);
            lost = lost.at_least(relative * relative * force);
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
        (sums, most, [lost, largest])
    }
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
    // A deformation is rounded at about a unit of length, whatever it is.
    let root = outcome.estimate.largest.cbrt();
    let rounding = T::EPSILON * (T::of(10.0) + T::of(10.0) / (root * root).at_least(T::EPSILON));
    let moved = T::of(4.0) * T::EPSILON * (T::ONE + forces * state.factors.compliance());
    let step = margin * outcome.step * outcome.estimate.most;
    let displacement = (step + moved) / norm(u).at_least(T::TINY);
    ErrorEstimate {
        displacement,
        force: margin * outcome.estimate.force + rounding,
        stiffness: margin * outcome.estimate.k + rounding,
    }
}
