//! From sensor to alarm: what a spindle's board does around the solver.

pub mod judgement;
pub mod life;
pub mod loads;
pub mod plausibility;
pub mod speed;
pub mod telemetry;
pub mod tick;
