//! The monitored spindle: one place for the firmware and for the host program that
//! checks it. Whoever includes it says in which precision the solver works.

use super::Precision;
use core::f64::consts::PI;
use spindle_bearing::{Bearing, Design, FreeContact, Material, Real, Spindle};

/// Rows of balls.
pub const ROWS: usize = 1;

/// Balls of a row.
pub const BALLS: usize = 16;

/// A B7005C of steel, SI units.
pub const DESIGN: Design = Design {
    ball_diameter: 6.35e-3,
    pitch_diameter: 36e-3,
    inner_groove_factor: 0.515,
    outer_groove_factor: 0.525,
    free_contact: FreeContact::Angle(15.0 * PI / 180.0),
    inner_shoulder_angle: 48.0 * PI / 180.0,
    outer_shoulder_angle: 47.5 * PI / 180.0,
    first_ball: 0.0,
    ring: Material::STEEL,
    ball: Material::STEEL,
};

/// Its constants, worked out by the compiler.
pub static BEARING: Bearing<Precision, BALLS> = Bearing::<Precision, BALLS>::checked(&DESIGN);

/// The bearings on their shaft.
pub fn spindle<T: Real>(bearing: &'static Bearing<T, BALLS>) -> Spindle<'static, T, ROWS, BALLS> {
    Spindle::single(bearing)
}
