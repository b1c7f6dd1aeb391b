#![doc = include_str!("../README.md")]
#![no_std]
#![deny(unsafe_code)]
#![warn(missing_docs)]
// A negated comparison is also true of what is not a number, and matrix code reads best by index.
#![allow(clippy::neg_cmp_op_on_partial_ord, clippy::needless_range_loop)]

#[cfg(test)]
extern crate std;

#[forbid(unsafe_code)]
mod axial;
#[forbid(unsafe_code)]
mod ball;
#[forbid(unsafe_code)]
mod conditions;
#[forbid(unsafe_code)]
mod constants;
#[forbid(unsafe_code)]
mod contact;
#[forbid(unsafe_code)]
mod design;
#[forbid(unsafe_code)]
mod elementary;
#[forbid(unsafe_code)]
mod float;
#[forbid(unsafe_code)]
mod freedoms;
#[forbid(unsafe_code)]
mod hertz;
#[forbid(unsafe_code)]
mod kinematics;
#[forbid(unsafe_code)]
mod limits;
#[forbid(unsafe_code)]
mod outputs;
#[forbid(unsafe_code)]
mod ring;
#[forbid(unsafe_code)]
mod scene;
#[forbid(unsafe_code)]
mod solver;
#[forbid(unsafe_code)]
mod spring;
#[allow(unsafe_code)]
mod sqrt;
#[forbid(unsafe_code)]
mod status;
#[forbid(unsafe_code)]
mod turning;

#[cfg(feature = "record")]
#[forbid(unsafe_code)]
pub mod estimate;
#[cfg(feature = "record")]
#[forbid(unsafe_code)]
pub mod framing;
#[cfg(feature = "monitor")]
#[forbid(unsafe_code)]
pub mod monitor;
#[cfg(feature = "record")]
#[forbid(unsafe_code)]
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
