//! The judge's tests in one program, so that they overlap. `scenes` is a program by itself: it takes as long to
//! compile as all of these.

mod campaign;
mod compile_fail;
mod core;
mod double_double;
mod frames;
mod laws;
mod limits;
mod malformed;
mod monitor;
mod recordings;
mod refusals;
mod retained;
mod statement;
mod telemetry;
mod truth;
mod validation;
