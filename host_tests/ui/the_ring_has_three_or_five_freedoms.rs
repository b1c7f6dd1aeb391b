//~ the inner ring has 3 freedoms (tilts locked) or 5, which `[f32; 2]` does not fit
//~ one freedom, along the axis, is that of `AxialSolver`
use spindle_bearing::{Bearing, Full, Solver};

#[cfg(good)]
const FREEDOMS: usize = 3;
#[cfg(not(good))]
const FREEDOMS: usize = 2;

pub fn solver(bearing: &Bearing<f32, 16>) -> Solver<'_, f32, 16, Full, FREEDOMS> {
    Solver::of(bearing)
}
