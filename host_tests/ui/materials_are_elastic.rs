//~ this bearing cannot be built: Poisson's ratio nu of the rings must be 0 to 0.5
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
pub static BEARING: Bearing<f64, 9> = Bearing::<f64, 9>::checked(&DESIGN);
#[cfg(not(good))]
pub static BEARING: Bearing<f64, 9> = Bearing::<f64, 9>::checked(&Design {
    ring: Material { poissons_ratio: 0.6, ..Material::STEEL },
    ..DESIGN
});
