//! The judge's tests in one program, so that they overlap. `scenes` is a program by itself, so that both compile at the
//! same time.

mod axial;
mod balance;
mod campaign;
mod catalogue;
mod compile_fail;
mod cutting;
mod cycle;
mod designs;
mod double_double;
mod edges;
mod frames;
mod given;
mod growth;
mod gyroscope;
mod hostile;
mod life;
mod limits;
mod monitor;
mod motions;
mod precision;
mod recordings;
mod refusals;
mod retained;
mod self_check;
mod solution;
mod solves;
mod spindles;
mod starts;
mod symmetry;
mod tangent;
mod telemetry;
mod thresholds;
mod truth;
mod validation;
