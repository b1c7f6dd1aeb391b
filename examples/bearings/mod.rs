//! The bearing of the examples.

use spindle_bearing::Design;

/// Balls of [`S6014C`].
pub const BALLS: usize = 21;

/// GMN S 6014 C, 70 x 110 x 20 mm: balls, diameters and contact angle of the maker's catalogue (4000 0813 EN).
pub const S6014C: Design = Design::angular_contact(11.906e-3, 90e-3, 15_f64.to_radians());
