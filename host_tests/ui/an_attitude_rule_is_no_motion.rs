//~ is not a motion of the balls
//~ a motion is `Static`, `Centrifugal<A>` or `Full<A>`, with an attitude rule `A`
use spindle_bearing::OuterRaceControl;
use spindle_bearing::{AxialSolver, Bearing, Full};

#[cfg(good)]
type Motion = Full<OuterRaceControl>;
#[cfg(not(good))]
type Motion = OuterRaceControl;

pub fn solver(bearing: &Bearing<f32, 16>) -> AxialSolver<'_, f32, 16, Motion> {
    AxialSolver::of(bearing)
}
