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
//! | balls | [`Balls`] of a solution: [`BallState`], [`BallKinematics`], [`Frequencies`] |
//! | physical limits | [`Limits`], [`Margins`]; a row at a glance: [`RowSummary`] |
//! | rating life | [`LifeRating`], [`RatingLife`] |
//! | how the balls move: at rest, under centrifugal force, with all inertia loads | [`Motion`]: [`Static`], [`Centrifugal`], and [`RacewayControlFree`], [`OuterRaceControl`] or [`InnerRaceControl`] |
//!
//! Inside, imports go down these layers. `CONTRIBUTING.md` of the repository draws them and says where a first change goes.
//!
//! | layer | has |
//! | --- | --- |
//! | `matrices` | stiffness for `nalgebra` |
//! | `spindle` | bearings on a shaft, as a user builds them |
//! | `solver` | public solvers, problem, Newton's loop, starts, what one solve leaves for the next |
//! | `results` | what a solved row shows: summary, margins, life, frequencies |
//! | `rows` | rows on their mounts: their motion, sum of forces and stiffness |
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
#[cfg(feature = "nalgebra")]
mod matrices;
mod real;
mod results;
mod rows;
#[cfg(feature = "serde")]
mod serialize;
mod solver;
mod spindle;
#[allow(unsafe_code, reason = "an instruction that has no safe name")]
mod sqrt;
mod status;
mod tuning;

pub use ball::kinematics::{
    Centrifugal, InnerRaceControl, Motion, OuterRaceControl, RacewayControlFree, Speed, Static,
};
pub use ball::report::{BallKinematics, BallState, ContactPatch};
pub use bearing::Bearing;
pub use design::{Design, DesignError, FreeContact, Material};
pub use growth::{Expansion, Growth};
pub use hertz::{HertzContact, elliptic_integrals};
pub use real::Real;
pub use results::Balls;
pub use results::frequencies::Frequencies;
pub use results::life::{LifeRating, RatingLife};
pub use results::margins::{Limit, LimitSet, Limits, Margin, Margins, Race};
pub use results::snapshot::{RowSnapshot, Snapshot};
pub use results::summary::RowSummary;
pub use solver::Solver;
pub use solver::axial::{AxialSolution, AxialSolver};
pub use solver::problem::{Given, Loading, OperatingPoint, Settings, ShaftLoad};
pub use solver::solution::Solution;
pub use spindle::arrangement::{Arrangement, Facing};
pub use spindle::elastic::ElasticSpindle;
pub use spindle::error::SpindleError;
pub use spindle::sections::{Section, Shaft, ShaftError, Support};
pub use spindle::solution::{RowSolution, SpindleSolution, compliance};
pub use spindle::solver::SpindleSolver;
pub use spindle::{Mounted, Preload, Spindle, SprungSpindle};
pub use sqrt::sqrt_f32;
pub use status::{ErrorEstimate, Quantity, Status};

// In signatures.
#[cfg(feature = "nalgebra")]
pub use {matrices::matrix, nalgebra};

/// Public data is `Format`; designs, settings and results are `Serialize` and `Deserialize`, as Cargo.toml promises: that compiles.
#[cfg(all(test, feature = "defmt", feature = "serde"))]
#[rustfmt::skip]
mod data {
    use crate::*;

    const fn format<T: defmt::Format>() {}
    const fn both<T: defmt::Format + serde::Serialize + serde::de::DeserializeOwned>() {}

    const _: () = {
        both::<(Design, DesignError, FreeContact, Material, Expansion, HertzContact)>();
        both::<(Growth<f32>, Speed<f32>, Settings<f32>, Given<f32>, Quantity, Status<f32>)>();
        both::<(BallState<f32>, BallKinematics<f32>, ContactPatch<f32>, Frequencies<f32>, ErrorEstimate<f32>)>();
        both::<(Limits<f32>, Limit, LimitSet, Margin<f32>, Margins<f32>, Race)>();
        both::<(LifeRating<f32>, RatingLife<f32>, RowSummary<f32>)>();
        both::<(Arrangement, Facing, Preload<f32>, SpindleError<f32>)>();
        both::<(Section, ShaftError, ShaftLoad<f32>, Support<f32>)>();
        both::<(Snapshot<f32, 2, 40>, RowSnapshot<f32, 40>)>();
        format::<OperatingPoint<f32, 2>>();
        format::<(Bearing<f32, 16>, Mounted<'_, f32, 16>, Spindle<'_, f32, 2, 16>)>();
        format::<(Shaft<f32, 1>, ElasticSpindle<'_, f32, 2, 16>)>();
        format::<AxialSolution<'_, f32>>();
        format::<(Solution<'_, f32, 16>, RowSolution<'_, f32>, SpindleSolution<'_, f32, 2, 16>)>();
        format::<(RacewayControlFree, OuterRaceControl, InnerRaceControl)>();
    };
}
