//~ is not a set of freedoms of the inner ring
//~ choose `Axial` (1), `Translations` (3) or `All` (5)
use spindle_bearing::*;

#[cfg(good)]
type Ring = Freedoms<3>;
#[cfg(not(good))]
type Ring = Freedoms<2>;

pub fn solver(bearing: &Bearing<f32, 16>) -> Solver<'_, f32, 16, Full, Ring> {
    Solver::new(bearing)
}
