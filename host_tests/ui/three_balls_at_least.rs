//~ this bearing cannot be built: ball count N must be 3 to 1000
use spindle_bearing::Bearing;
use spindle_bearing::{Design, FreeContact, Material};

#[cfg(good)]
const BALLS: usize = 3;
#[cfg(not(good))]
const BALLS: usize = 2;

pub static BEARING: Bearing<f32, BALLS> = Bearing::<f32, BALLS>::checked(&Design {
    ball_diameter: 6.35e-3,
    pitch_diameter: 36e-3,
    inner_groove_factor: 0.515,
    outer_groove_factor: 0.525,
    free_contact: FreeContact::Angle(0.26),
    inner_shoulder_angle: Design::HIGHEST_SHOULDER,
    outer_shoulder_angle: Design::HIGHEST_SHOULDER,
    first_ball: 0.0,
    ring: Material::STEEL,
    ball: Material::STEEL,
});
