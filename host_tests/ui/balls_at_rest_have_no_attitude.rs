//~ is not a motion of the balls
//~ balls at rest have no attitude, so that `Static` takes no rule
use spindle_bearing::*;

#[cfg(good)]
type Motion = Static;
#[cfg(not(good))]
type Motion = Static<OuterRaceControl>;

pub fn solver(bearing: &Bearing<f32, 16>) -> Solver<'_, f32, 16, Motion> {
    Solver::new(bearing)
}
