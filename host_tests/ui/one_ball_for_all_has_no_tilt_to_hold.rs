//~ does not say what is given of each freedom of
//~ only `All` has tilts to hold: where one ball stands for all, or the tilts are locked, there are none
use spindle_bearing::*;

#[cfg(good)]
type Ring = All;
#[cfg(not(good))]
type Ring = Axial;

type HeldTilt = (Load, Load, Load, Load, Displacement);

pub fn solver(bearing: &Bearing<f32, 16>) -> Solver<'_, f32, 16, Full, Ring, HeldTilt> {
    Solver::new(bearing)
}
