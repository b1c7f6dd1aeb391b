//! The firmware of a spindle's monitor, but for the chip.
//!
//! Boards and the host's programs have the chain in common: the host holds an emulated board against it. The feature `program`
//! adds what only a board has, for any Cortex-M: a chip implements `board::Board`.

#![no_std]

#[cfg(feature = "program")]
pub mod application;
#[cfg(feature = "program")]
pub mod beat;
#[cfg(feature = "program")]
pub mod board;
pub mod bridges;
pub mod bus;
pub mod chain;
#[cfg(feature = "program")]
pub mod dog;
#[cfg(feature = "program")]
mod faults;
pub mod flash;
#[cfg(all(feature = "program", not(feature = "rtt")))]
pub mod log;
#[cfg(feature = "program")]
mod memory;
pub mod receiver;
#[cfg(feature = "rtt")]
pub mod rtt;
#[cfg(feature = "rtt")]
pub use rtt as log;
#[cfg(feature = "program")]
mod self_check;
#[cfg(feature = "program")]
pub mod sensors;
pub mod spindle;
#[cfg(feature = "program")]
pub mod strap;
pub mod tachometer;

#[cfg(test)]
extern crate std;
