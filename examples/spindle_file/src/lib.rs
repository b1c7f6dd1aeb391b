//! A spindle's file: designs, rows, shaft, loads, probes and settings of its monitor, as people type them.

pub mod calibration;
pub mod catalogue;
pub mod designs;
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
pub mod spindles;
