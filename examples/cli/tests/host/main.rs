//! Tests of recordings, of the host's decoder and of both with the monitor, without the programs.

mod cycle;
mod day;
mod nose;
mod recordings;
mod response;
mod telemetry;
