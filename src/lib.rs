#![doc = include_str!("../README.md")]
#![no_std]
#![deny(unsafe_code)]
#![warn(missing_docs)]
// A negated comparison is also true of what is not a number, and matrix code reads best by index.
#![allow(clippy::neg_cmp_op_on_partial_ord, clippy::needless_range_loop)]

#[cfg(test)]
extern crate std;

mod ball;
mod constants;
mod contact;
mod design;
mod elementary;
mod float;
mod hertz;
mod kinematics;
mod ring;
mod scene;
mod solver;
#[allow(unsafe_code)]
mod sqrt;
mod status;

#[cfg(feature = "record")]
pub mod estimate;
#[cfg(feature = "record")]
pub mod record;

pub use constants::Bearing;
pub use design::{Design, DesignError, FreeContact, Material};
pub use float::Real;
pub use hertz::{HertzContact, elliptic_integrals};
pub use kinematics::{Attitude, InnerRaceControl, OuterRaceControl, RacewayControlFree};
pub use scene::{AtSpeed, Motion, Static};
pub use solver::{BallState, Settings, Solution, Solver};
pub use status::{Quantity, Status};
