//! Equilibrium and stiffness of high-speed angular contact ball bearings: one, or several on a shaft.
//!
#![doc = include_str!("../docs/frame.svg")]
//!
#![doc = include_str!("../docs/crate.md")]
//!
//! | what | item |
//! | --- | --- |
//! | geometry and materials | [`Design`], [`Material`], [`FreeContact`] |
//! | a design's constants, made by the compiler | [`Bearing`] |
//! | one bearing | [`Solver`], [`Solution`]; under axial loads alone [`AxialSolver`] |
//! | several bearings on a shaft | [`Spindle`], [`SpindleSolver`], [`SpindleSolution`], [`RowSolution`] |
//! | speed, growth by heat, rotation and fits | [`Speed`], [`Growth`] |
//! | iterations and tolerance | [`Settings`]; in a tick of firmware [`Settings::TICK`] |
//! | how a solve ends | [`Status`] |
//! | balls | [`BallState`], [`BallKinematics`], [`Frequencies`] |
//! | physical limits | [`Limits`], [`Margins`]; a row at a glance: [`RowSummary`] |
//! | rating life | [`LifeRating`], [`RatingLife`] |
//! | how the balls move: at rest, under centrifugal force, with all inertia loads | [`Motion`]: [`Static`], [`Centrifugal`], [`Full`] |
//!
//! Inside, imports go down these layers. `CONTRIBUTING.md` draws them and says where a first change goes.
//!
//! | layer | has |
//! | --- | --- |
//! | `spindle` | bearings on a shaft, as a user builds them |
//! | `solver` | public solvers, problem, Newton's loop, starts, what one solve leaves for the next |
//! | `results` | what a solved row shows: summary, margins, life, frequencies |
//! | `shaft` | rows on their mounts: their motion, sum of forces and stiffness |
//! | `ball` | one ball for a given ring: contacts, kinematics, linearised and condensed |
//! | `real`, `linalg`, `growth` | numbers, vectors, matrices; growth of rings and balls |
//! | `bearing`, `design` | the constants of a design |

#![no_std]

#[cfg(test)]
extern crate std;

mod ball;
mod bearing;
mod const_math;
mod design;
mod growth;
mod hertz;
mod linalg;
mod real;
mod results;
mod shaft;
mod solver;
mod spindle;
#[allow(unsafe_code, reason = "an instruction that has no safe name")]
mod sqrt;
mod status;
mod tuning;

#[cfg(feature = "record")]
pub mod framing;
#[cfg(feature = "monitor")]
pub mod monitor;
#[cfg(feature = "record")]
pub mod record;

pub use ball::kinematics::{
    Centrifugal, Full, InnerRaceControl, Motion, OuterRaceControl, RacewayControlFree, Speed,
    Static,
};
pub use ball::report::{BallKinematics, BallState, ContactPatch};
pub use bearing::Bearing;
pub use design::{Design, DesignError, FreeContact, Material};
pub use growth::{Expansion, Growth};
pub use hertz::{HertzContact, elliptic_integrals};
pub use real::Real;
pub use results::frequencies::Frequencies;
pub use results::life::{LifeRating, RatingLife};
pub use results::margins::{Limit, LimitSet, Limits, Margin, Margins, Race};
pub use results::summary::RowSummary;
pub use solver::Solver;
pub use solver::axial::{AxialSolution, AxialSolver};
pub use solver::problem::{Given, RingVector, Settings};
pub use solver::solution::{Snapshot, Solution};
pub use solver::state::ErrorEstimate;
pub use spindle::arrangement::{Arrangement, Facing};
pub use spindle::error::SpindleError;
pub use spindle::solution::{RowSolution, ShaftEnd, SpindleSolution};
pub use spindle::solver::SpindleSolver;
pub use spindle::{Mounted, Preload, Spindle};
pub use status::{Quantity, Status};
