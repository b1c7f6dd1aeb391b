//~ the displacement of every freedom is given, so that there is nothing to solve
//~ `Solver::law` gives forces and tangent for displacements
use spindle_bearing::*;

#[cfg(good)]
type Last = Load;
#[cfg(not(good))]
type Last = Displacement;

type Given = (Displacement, Displacement, Last);

pub fn solver(bearing: &Bearing<f32, 16>) -> Solver<'_, f32, 16, Static, Translations, Given> {
    Solver::new(bearing)
}
