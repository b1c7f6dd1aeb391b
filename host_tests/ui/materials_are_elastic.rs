//~ this bearing cannot be built: Poisson's ratio nu of the rings must be 0 to 0.5
use spindle_bearing::{Bearing, Design, Material};

const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 0.26);

#[cfg(good)]
pub static BEARING: Bearing<f64, 9> = Bearing::<f64, 9>::checked(&DESIGN);
#[cfg(not(good))]
pub static BEARING: Bearing<f64, 9> = Bearing::<f64, 9>::checked(&Design {
    ring: Material { poissons_ratio: 0.6, ..Material::STEEL },
    ..DESIGN
});
