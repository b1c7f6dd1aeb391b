//~ struct takes 0 generic arguments
use spindle_bearing::OuterRaceControl;
use spindle_bearing::{Bearing, Full, Solver, Static};

#[cfg(good)]
type Motion = Full<OuterRaceControl>;
#[cfg(not(good))]
type Motion = Static<OuterRaceControl>;

pub fn solver(bearing: &Bearing<f32, 16>) -> Solver<'_, f32, 16, Motion> {
    Solver::of(bearing)
}
