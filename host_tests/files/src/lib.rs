//! What reads files: bearings and spindles as people type them, recordings as programs write them.

pub mod catalogue;
pub mod designs;
pub mod plan;
pub mod recordings;
pub mod spindles;
