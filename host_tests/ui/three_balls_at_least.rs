//~ this bearing cannot be built: ball count N must be 3 to 1000
use spindle_bearing::{Bearing, Design};

#[cfg(good)]
const BALLS: usize = 3;
#[cfg(not(good))]
const BALLS: usize = 2;

const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 0.26);
pub static BEARING: Bearing<f32, BALLS> = Bearing::<f32, BALLS>::checked(&DESIGN);
