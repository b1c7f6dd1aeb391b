//~ this bearing cannot be built: ball diameter D must be
use spindle_bearing::Bearing;
use spindle_bearing::{Design, FreeContact, Material};

const DESIGN: Design = Design {
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
};

#[cfg(good)]
pub static BEARING: Bearing<f32, 16> = Bearing::<f32, 16>::checked(&DESIGN);
#[cfg(not(good))]
pub static BEARING: Bearing<f32, 16> = Bearing::<f32, 16>::checked(&Design {
    ball_diameter: 7.1e-3,
    ..DESIGN
});
