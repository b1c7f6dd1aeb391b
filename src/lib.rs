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
//! | several bearings on a shaft | [`Spindle`] of [`Mounted`] rows, [`SpindleSolver`], [`SpindleSolution`], [`RowSolution`] |
//! | preload | [`Preload`]; a set under a spring: [`SprungSpindle`] |
//! | elastic shaft and supports | [`Shaft`] of [`Section`]s, [`Support`], [`ElasticSpindle`], [`ShaftLoad`] |
//! | speed, growth by heat, rotation and fits | [`Speed`], [`Growth`] |
//! | iterations and tolerance | [`Settings`]; in a tick of firmware [`Settings::TICK`] |
//! | how a solve ends | [`Status`] |
//! | balls | [`Balls`] of a solution: [`BallState`], [`BallKinematics`], [`Frequencies`] |
//! | physical limits | [`Limits`], [`Margins`]; a row at a glance: [`RowSummary`] |
//! | rating life | [`LifeRating`], [`RatingLife`] |
//! | how the balls move: at rest, under centrifugal force, with all inertia loads | [`Motion`]: [`Static`], [`Centrifugal`], and [`RacewayControlFree`], [`OuterRaceControl`] or [`InnerRaceControl`] |
//!
//! # In firmware
//!
//! The radial stiffness at the nose of a pair on an elastic shaft, in every tick. The compiler makes bearings, shaft and pair.
//!
//! ```
//! #![no_std]
//! # /*
//! #![no_main]
//! use panic_halt as _;
//! # */
//! # extern crate std;
//! use spindle_bearing::{Arrangement, Bearing, Design, ElasticSpindle, Facing, Material, Mounted, Preload};
//! use spindle_bearing::{RacewayControlFree, Section, Settings, Shaft, Speed, Spindle, SpindleSolver, Support};
//! # /*
//! use static_cell::ConstStaticCell;
//! # */
//!
//! const S6005C: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
//! static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&S6005C);
//! const ROWS: [Mounted<f32, 15>; 2] = [
//!     Mounted::new(&BEARING, 0.0, Facing::PlusX).with(Preload::Force(200.0)),
//!     Mounted::new(&BEARING, 0.1, Facing::MinusX).with(Preload::Force(200.0)),
//! ];
//! // Solid, 25 mm thick, from the nose to the second row.
//! const SOLID: Section = Section { from: -0.03, to: 0.1, outer: 0.025, inner: 0.0 };
//! static SHAFT: Shaft<f32, 1> = Shaft::<f32, 1>::const_new(&[SOLID], &Material::STEEL);
//! const HOUSING: Support<f32> = Support { radial: 4e8, ..Support::RIGID };
//! static PAIR: ElasticSpindle<f32, 2, 15> =
//!     Spindle::<f32, 2, 15>::const_new(Arrangement::BackToBack, ROWS).const_elastic(&SHAFT, [HOUSING; 2]);
//!
//! type Solver = SpindleSolver<f32, 2, 15, RacewayControlFree, 5, 2>;
//! # /*
//! static SOLVER: ConstStaticCell<Solver> = ConstStaticCell::new(Solver::new());
//!
//! #[cortex_m_rt::entry]
//! fn main() -> ! {
//!     let solver = SOLVER.take();
//! # */
//! # fn main() {
//! #   let (mut ticks, solver) = (0, &mut Solver::new());
//!     let speed = Speed::rpm(20_000.0);
//!     // From nothing, a solve takes longer than a tick: once, before ticks begin.
//!     let _ = solver.solve(&PAIR, [0.0; 5], speed, &Settings::DEFAULT).is_ok();
//!     loop {
//!         let load = measured(); // in the board's next tick
//!         match solver.solve(&PAIR, load, speed, &Settings::TICK) {
//!             Ok(solution) => show(1.0 / solution.compliance_at(-0.03)[1][1]),
//!             Err(status) => tell(status.name()),
//!         }
//! #       ticks += 1;
//! #       if ticks == 3 { break; }
//!     }
//! }
//! # fn measured() -> [f32; 5] { [0.0, 100.0, 0.0, 0.0, 0.0] }
//! # fn show(radial: f32) { assert!((1e7..6e7).contains(&radial)); }
//! # fn tell(status: &str) { panic!("{status}"); }
//! ```

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
pub use real::{Real, cbrt_f32};
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
pub use spindle::change::SpindleChange;
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

#[cfg(all(doc, not(doctest)))]
#[doc = include_str!("../docs/guide.md")]
pub mod guide {}

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
