//! The judge: a second implementation of the solver's task, cases with known answers, and what a comparison with
//! them allows. `../README.md` says which part judges what.

pub mod campaign;
pub mod cases;
pub mod compare;
pub mod dispatch;
pub mod double_double;
pub mod lifetime;
pub mod milling_cycle;
pub mod progress;
pub mod reference;
pub mod replay;
pub mod spindles;
pub mod telemetry;
pub mod tolerances;
pub mod validation;
pub mod warm_up;
