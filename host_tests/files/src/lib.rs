//! What reads files: bearings and spindles as people type them, recordings as programs write them.

pub mod calibration;
pub mod catalogue;
pub mod designs;
mod doubts;
pub mod fault;
mod identity;
pub mod import;
mod lines;
pub mod monitors;
pub mod noses;
pub mod plan;
pub mod probes;
pub mod propose;
pub mod quantities;
mod reading;
pub mod recordings;
mod shafts;
pub mod spindles;
pub mod times;
pub mod units;
