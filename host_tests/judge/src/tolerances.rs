//! Errors that are allowed: of the quantities of [`compare`](crate::compare), which says their units.
//!
//! The bounds are about three times the solver's errors over the solved cases in `cases/public.json` and
//! over random ones of the same kind.

use crate::compare::Errors;
use solvers::dispatch::Precision;

const fn errors(displacement: f64, contact_angle: f64, force: f64, stiffness: f64) -> Errors {
    Errors {
        displacement,
        contact_angle,
        force,
        stiffness,
    }
}

/// Errors allowed of the solver in a precision.
pub const fn allowed(precision: Precision) -> Errors {
    match precision {
        Precision::F64 => errors(1e-11, 3e-14, 1e-13, 2e-12),
        Precision::F32 => errors(1e-5, 1e-6, 3e-5, 5e-4),
    }
}

/// Errors allowed of the reference build.
pub const OF_REFERENCE: Errors = errors(1e-14, 5e-15, 5e-15, 2e-14);

/// Resolution of a displacement in single precision, relative to `L0`: half a unit in the last place of 1.
///
/// A contact angle that is rounded in its last digit moves the ring by as much, however light the
/// load. On a B7005C this is 15 picometres.
const SINGLE_RESOLUTION: f64 = 6e-8;

/// Errors allowed of the solver in a precision for a displacement whose largest component is
/// `largest` times the distance `L0` of the groove centres.
pub fn allowed_at(precision: Precision, largest: f64) -> Errors {
    let mut errors = allowed(precision);
    if precision == Precision::F32 {
        errors.displacement = errors.displacement.max(SINGLE_RESOLUTION / largest);
    }
    errors
}
