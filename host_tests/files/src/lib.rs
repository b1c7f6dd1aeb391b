//! What reads files: bearings and spindles as people type them, recordings as programs write them.

pub mod catalogue;
mod columns;
pub mod designs;
pub mod noses;
pub mod plan;
mod preamble;
pub mod recordings;
mod shafts;
pub mod spindles;
pub mod told;
pub mod units;
