//! The bearing of the examples.

use core::f64::consts::PI;
use spindle_bearing::{Design, FreeContact, Material};

/// Balls of [`S6014C`].
pub const BALLS: usize = 21;

/// GMN S 6014 C, 70 x 110 x 20 mm: balls, diameters and contact angle as in the maker's catalogue (4000 0813 EN). Groove factors
/// are assumed, the shoulders are not known.
pub const S6014C: Design = Design {
    ball_diameter: 11.906e-3,
    pitch_diameter: 90e-3,
    inner_groove_factor: 0.515,
    outer_groove_factor: 0.525,
    free_contact: FreeContact::Angle(15.0 * PI / 180.0),
    inner_shoulder_angle: Design::HIGHEST_SHOULDER,
    outer_shoulder_angle: Design::HIGHEST_SHOULDER,
    first_ball: 0.0,
    ring: Material::STEEL,
    ball: Material::STEEL,
};
