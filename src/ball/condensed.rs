//! Force and slopes that a condensed ball hands to the ring, and how a step changes them.

use crate::ball::contact::Contact;
use crate::linalg::{Matrix2, Pair};
use crate::real::Real;

/// A condensed ball: its force on the ring, and the slopes of that force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condensed<T> {
    /// Axial and radial force, and moment over `Rp`.
    pub force: Pair<T>,
    pub moment: T,
    /// Their slopes by the groove's centre.
    pub h: Matrix2<T>,
    pub hm: Pair<T>,
    /// Their slopes by the relative change of `omega^2`.
    pub force_by_speed: Pair<T>,
    pub moment_by_speed: T,
}

impl<T: Real> Condensed<T> {
    /// No ball.
    pub const NONE: Self = Self {
        force: [T::ZERO; 2],
        moment: T::ZERO,
        h: [[T::ZERO; 2]; 2],
        hm: [T::ZERO; 2],
        force_by_speed: [T::ZERO; 2],
        moment_by_speed: T::ZERO,
    };
}

/// How a step changes a ball's contacts.
#[derive(Debug, Clone, Copy)]
pub struct Change<T> {
    /// Relative change of the stiffness by the deformations, and the turn of the normals, rad.
    pub depth: T,
    pub turn: T,
    /// Both together; 0 where rounding alone makes them.
    pub relative: T,
    /// Magnitudes of the elements `aa`, `ar`, `rr` of the ball's stiffness.
    pub h: [T; 3],
    /// Cosine of the angle between the contacts; 1 at rest.
    pub cos: T,
    /// Unbalanced force on a ball without inner contact after the step, of second order.
    pub off: T,
}

/// A ball on which `contact` alone acts.
#[inline(always)]
pub fn condensed_of<T: Real>(contact: &Contact<T>) -> Condensed<T> {
    let [aa, ar, rr] = contact.tangent();
    let force = [contact.q * contact.n[0], contact.q * contact.n[1]];
    Condensed {
        force,
        moment: force[0],
        h: [[aa, ar], [ar, rr]],
        hm: [aa, ar],
        ..Condensed::NONE
    }
}

/// How a step `v` changes a contact that is open by `-delta`, or closed by no more than rounding.
///
/// A closing contact counts with its deformation after the step, plus rounding. Where both deformation and step
/// are rounding, the contact touches without force, and no iteration tells more of it.
#[cold]
#[inline(never)]
pub fn grazing<T: Real>(v: T, delta: T, k: T, rounding: T) -> Change<T> {
    let depth = delta + v.at_least(T::ZERO) + rounding;
    // Ahead of the branch: see `sqrt`.
    let slope = T::of(1.5) * k * depth.sqrt_abs();
    let (relative, slope) = if depth > T::ZERO {
        (T::ONE, slope)
    } else {
        (T::ZERO, T::ZERO)
    };
    let touches = v.abs() <= rounding;
    Change {
        depth: relative,
        turn: T::ZERO,
        relative: if touches { T::ZERO } else { relative },
        cos: T::ONE,
        off: T::ZERO,
        h: [slope, T::ZERO, slope],
    }
}
