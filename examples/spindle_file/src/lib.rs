//! A spindle's file: designs, rows, shaft, loads, probes and settings of its monitor, as people type them; spindles whose sizes
//! are known at run time.

pub mod calibration;
pub mod catalogue;
pub mod designs;
#[cfg(feature = "solvers")]
pub mod dispatch;
mod doubts;
mod identity;
pub mod loads;
pub mod monitors;
pub mod mounting;
pub mod noses;
pub mod plan;
pub mod probes;
pub mod reading;
mod shafts;
#[cfg(feature = "solvers")]
pub mod solvers;
pub mod spindles;
