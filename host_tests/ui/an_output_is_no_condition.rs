//~ does not say what is given of each freedom of
use spindle_bearing::*;

#[cfg(good)]
type Scene<'b> = Solver<'b, f32, 16, Full, All, Loads, Displacements>;
#[cfg(not(good))]
type Scene<'b> = Solver<'b, f32, 16, Full, All, Displacements>;

pub fn solver(bearing: &Bearing<f32, 16>) -> Scene<'_> {
    Solver::new(bearing)
}
