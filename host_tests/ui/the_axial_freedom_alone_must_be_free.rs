//~ the displacement of every freedom is given, so that there is nothing to solve
use spindle_bearing::*;

#[cfg(good)]
type Given = (Load,);
#[cfg(not(good))]
type Given = (Displacement,);

pub fn solver(bearing: &Bearing<f32, 16>) -> Solver<'_, f32, 16, Full, Axial, Given> {
    Solver::new(bearing)
}
