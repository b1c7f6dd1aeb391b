#![doc = include_str!("../README.md")]
#![no_std]

#[cfg(test)]
extern crate std;

mod axial;
mod ball;
mod body;
mod constants;
mod contact;
mod curvature;
mod design;
mod elementary;
mod float;
mod frame;
mod frequencies;
mod growth;
mod hertz;
mod kinematics;
mod limits;
mod linalg;
mod motion;
mod mounting;
mod place;
mod pose;
mod rating;
mod ring;
mod rows;
mod solver;
mod spindle;
#[allow(unsafe_code, reason = "an instruction that has no safe name")]
mod sqrt;
mod static_ball;
mod status;
mod tuning;

#[cfg(feature = "record")]
pub mod estimate;
#[cfg(feature = "record")]
pub mod framing;
#[cfg(feature = "monitor")]
pub mod monitor;
#[cfg(feature = "record")]
pub mod record;

pub use constants::Bearing;
pub use design::{Design, DesignError, FreeContact, Material};
pub use float::Real;
pub use frequencies::Frequencies;
pub use growth::{Expansion, Growth};
pub use hertz::{HertzContact, elliptic_integrals};
pub use kinematics::{InnerRaceControl, OuterRaceControl, RacewayControlFree};
pub use limits::{Exceedance, Exceedances, Extreme, Extremes, Limit, LimitSet, Limits, Race};
pub use motion::{Centrifugal, Full, Motion, Static};
pub use mounting::Speed;
pub use pose::{BallMotion, BallState, ContactPatch};
pub use rating::{LifeRating, RatingLife};
pub use solver::{
    AxialSolution, AxialSolver, ErrorEstimate, Given, RingVector, Settings, Snapshot, Solution,
    Solver,
};
pub use spindle::{
    Arrangement, Facing, Mounted, Preload, RowSolution, ShaftEnd, Spindle, SpindleError,
    SpindleSolution, SpindleSolver,
};
pub use status::{Quantity, Status};
