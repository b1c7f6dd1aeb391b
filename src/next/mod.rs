//! The solver core that is to take the place of the one above it.
//!
//! Data flows one way: `constants` (a design in the solver's units), `contact`, `kinematics`, `ball` (and `static_ball`,
//! `place`, `pose`, `curvature`), `motion`, `axial`, `ring`, `frame`, `solver`.

pub(crate) mod axial;
pub(crate) mod ball;
pub(crate) mod constants;
pub(crate) mod contact;
pub(crate) mod curvature;
pub(crate) mod frame;
pub(crate) mod kinematics;
pub(crate) mod linalg;
pub(crate) mod motion;
mod mounting;
pub(crate) mod place;
pub(crate) mod pose;
pub(crate) mod ring;
pub(crate) mod solver;
pub(crate) mod static_ball;
pub(crate) mod tuning;

pub use constants::Bearing;
pub use motion::{Centrifugal, Full, Motion, Static};
pub use mounting::{Growth, Speed};
pub use solver::{
    AxialSolution, AxialSolver, Given, RingVector, Settings, Snapshot, Solution, Solver,
};
