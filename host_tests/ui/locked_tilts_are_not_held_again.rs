//~ does not say what is given of each freedom of
//~ only `All` has tilts to hold
use spindle_bearing::*;

#[cfg(good)]
type Given = Loads;
#[cfg(not(good))]
type Given = ImposedTilt;

pub fn solver(bearing: &Bearing<f32, 16>) -> Solver<'_, f32, 16, Full, Translations, Given> {
    Solver::new(bearing)
}
