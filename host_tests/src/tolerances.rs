//! The errors that are allowed: one table, which tests and reports read.
//!
//! What an error is says [`compare`](crate::compare). The bounds are about three times what the solver
//! reaches over the solved cases in `cases/public.json` and over random ones of the same kind.

use crate::compare::Errors;
use crate::dispatch::Precision;

/// A quantity and how far it may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// What.
    pub quantity: &'static str,
    /// What its error is relative to, or its unit.
    pub measure: &'static str,
    /// Allowed in double precision.
    pub f64: f64,
    /// Allowed in single precision.
    pub f32: f64,
    /// Allowed of the reference build.
    pub reference: f64,
}

/// The table.
#[rustfmt::skip]
pub const TOLERANCES: [Row; 4] = [
    Row { quantity: "displacement", measure: "of the largest component", f64: 1e-11, f32: 1e-5, reference: 1e-14 },
    Row { quantity: "contact angle", measure: "rad", f64: 3e-14, f32: 1e-6, reference: 5e-15 },
    Row { quantity: "force", measure: "of the largest contact force", f64: 3e-14, f32: 5e-6, reference: 5e-15 },
    Row { quantity: "stiffness", measure: "of its diagonal", f64: 2e-12, f32: 5e-4, reference: 2e-14 },
];

fn column(of: impl Fn(&Row) -> f64) -> Errors {
    let [displacement, contact_angle, force, stiffness] = [0, 1, 2, 3].map(|i| of(&TOLERANCES[i]));
    Errors {
        displacement,
        contact_angle,
        force,
        stiffness,
    }
}

/// What the solver is allowed in a precision.
pub fn allowed(precision: Precision) -> Errors {
    match precision {
        Precision::F64 => column(|row| row.f64),
        Precision::F32 => column(|row| row.f32),
    }
}

/// What single precision resolves of a displacement, relative to `L0`: half a unit in the last place of 1.
///
/// A contact angle that is rounded in its last digit moves the ring by as much, however light the
/// load; on a B7005C it is 15 picometres.
pub const SINGLE_RESOLUTION: f64 = 6e-8;

/// What the solver is allowed in a precision for a displacement whose largest component is
/// `largest` times the distance `L0` of the groove centres.
pub fn allowed_at(precision: Precision, largest: f64) -> Errors {
    let mut errors = allowed(precision);
    if precision == Precision::F32 {
        errors.displacement = errors.displacement.max(SINGLE_RESOLUTION / largest);
    }
    errors
}

/// What the reference build is allowed.
pub fn allowed_of_reference() -> Errors {
    column(|row| row.reference)
}
