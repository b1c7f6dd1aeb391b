//~ this bearing cannot be built: diametral clearance Pd must be
use spindle_bearing::{Bearing, Design, FreeContact};

const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 0.26);

#[cfg(good)]
pub static BEARING: Bearing<f32, 16> = Bearing::<f32, 16>::checked(&DESIGN);
#[cfg(not(good))]
pub static BEARING: Bearing<f32, 16> = Bearing::<f32, 16>::checked(&Design {
    free_contact: FreeContact::DiametralClearance(1e-3),
    ..DESIGN
});
