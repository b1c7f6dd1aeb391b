//! The firmware of a spindle's monitor, but for the chip.
//!
//! Boards and the host's programs have the chain in common: the host holds an emulated board against it. The feature `program`
//! adds what only a board has, for any Cortex-M: a chip implements `board::Board`. The features `f405` and `h743` do so for one
//! chip each.

#![no_std]

// A linker would take the interrupt vectors of either.
#[cfg(all(feature = "f405", feature = "h743"))]
compile_error!("a program is for one chip: choose the feature f405 or h743");

#[cfg(feature = "program")]
pub mod application;
#[cfg(feature = "program")]
mod beat;
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
mod sensors;
pub mod spindle;
#[cfg(any(feature = "f405", feature = "h743"))]
pub mod stm32;
#[cfg(feature = "program")]
mod strap;
pub mod tachometer;

#[cfg(test)]
extern crate std;
