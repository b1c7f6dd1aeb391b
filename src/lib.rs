#![doc = include_str!("../README.md")]
#![no_std]

#[cfg(test)]
extern crate std;

mod axial;
mod ball;
mod conditions;
mod constants;
mod contact;
mod design;
mod elementary;
mod float;
mod freedoms;
mod hertz;
mod kinematics;
mod limits;
mod outputs;
mod ring;
mod scene;
mod solver;
mod spring;
#[allow(unsafe_code, reason = "an instruction that has no safe name")]
mod sqrt;
mod status;
mod turning;

#[doc(hidden)]
pub mod next;

#[cfg(feature = "record")]
pub mod estimate;
#[cfg(feature = "record")]
pub mod framing;
#[cfg(feature = "monitor")]
pub mod monitor;
#[cfg(feature = "record")]
pub mod record;

pub use conditions::{Condition, Conditions, Displacement, ImposedTilt, Load, Loads, RigidPreload};
pub use constants::Bearing;
pub use design::{Design, DesignError, FreeContact, Material};
pub use float::Real;
pub use freedoms::{All, Axial, BallStore, FreedomSet, Freedoms, Translations};
pub use hertz::{HertzContact, elliptic_integrals};
pub use kinematics::{Attitude, InnerRaceControl, OuterRaceControl, RacewayControlFree};
pub use limits::{Exceedance, Exceedances, Extreme, Extremes, Limit, LimitSet, Limits, Race};
pub use outputs::{Balls, Displacements, NotPutOut, Outputs, PerBall, Stiffness};
pub use scene::{Centrifugal, Full, Motion, NoAttitude, Static};
pub use solver::{BallState, ErrorEstimate, Settings, Solution, Solver};
pub use status::{Quantity, Status};
