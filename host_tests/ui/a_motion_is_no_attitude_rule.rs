//~ is not an attitude rule
//~ choose `RacewayControlFree`, `OuterRaceControl` or `InnerRaceControl`
use spindle_bearing::InnerRaceControl;
use spindle_bearing::{Bearing, Centrifugal, Solver, Static};

#[cfg(good)]
type Rule = InnerRaceControl;
#[cfg(not(good))]
type Rule = Static;

pub fn solver(bearing: &Bearing<f32, 16>) -> Solver<'_, f32, 16, Centrifugal<Rule>> {
    Solver::of(bearing)
}
