//~ this bearing cannot be built: inner groove factor fi must be 0.501 to 0.7
use spindle_bearing::{Bearing, Design};

const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 0.26);

#[cfg(good)]
pub static BEARING: Bearing<f64, 16> = Bearing::<f64, 16>::checked(&DESIGN);
#[cfg(not(good))]
pub static BEARING: Bearing<f64, 16> = Bearing::<f64, 16>::checked(&Design {
    inner_groove_factor: 0.5,
    ..DESIGN
});
