//! A solution that borrows nothing.

use crate::ball::kinematics::Speed;
use crate::ball::report::BallState;
use crate::real::Real;
use crate::status::{ErrorEstimate, Status};

/// A [`Solution`](crate::Solution) or [`SpindleSolution`](crate::SpindleSolution) that borrows nothing, SI units.
///
/// `R` rows of at most `N` balls, `D` freedoms. A bearing alone has one row.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "T: crate::serialize::Written",
        deserialize = "T: crate::serialize::Read<'de>"
    ))
)]
#[non_exhaustive]
pub struct Snapshot<T: Real, const R: usize, const N: usize, const D: usize = 5> {
    /// How the solve ended.
    pub status: Status<T>,
    /// Iterations, those after a start included.
    pub iterations: u16,
    /// How far the figures below can be off.
    pub error: ErrorEstimate<T>,
    /// Displacements `dx, dy, dz` (m), `ty, tz` (rad) of the inner ring, or of the shaft at `x = 0`.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::array"))]
    pub displacement: [T; D],
    /// Forces (N) and moments (N m) there.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::array"))]
    pub load: [T; D],
    /// Speed of the shaft.
    pub speed: Speed<T>,
    /// Stiffness `dF/du` there, rows are forces.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::rows"))]
    pub stiffness: [[T; D]; D],
    /// Closure that a spring makes, m; 0 without a spring.
    pub spring_closure: T,
    /// The rows, in their order; beyond those of a spindle that has fewer than `R`, rows without balls.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::array"))]
    pub rows: [RowSnapshot<T, N>; R],
}

/// A row of a [`Snapshot`], in its own frame, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "T: crate::serialize::Written",
        deserialize = "T: crate::serialize::Read<'de>"
    ))
)]
#[non_exhaustive]
pub struct RowSnapshot<T: Real, const N: usize> {
    /// Forces (N) and moments (N m) of the shaft on its inner ring, about its centre.
    pub force: [T; 5],
    /// Part of its axial force that is preload, N.
    pub preload: T,
    /// Number of its balls: beyond them, the arrays below are 0.
    pub ball_count: usize,
    /// States of the balls, in the order of their azimuths.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::array"))]
    pub balls: [BallState<T>; N],
    /// Cage speed `omega_m` of every ball, rad/s: see [`Balls::cage_speeds`](crate::Balls::cage_speeds).
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::array"))]
    pub cage_speeds: [T; N],
}
