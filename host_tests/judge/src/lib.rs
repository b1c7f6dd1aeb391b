//! The judge: a second implementation of the solver's task, cases with known answers, laws of any answer, and what a comparison
//! with them allows. `../../README.md` says which part judges what.

pub mod campaign;
pub mod cases;
pub mod compare;
pub mod double_double;
pub mod laws;
pub mod preload;
pub mod progress;
pub mod reference;
pub mod tolerances;
pub mod validation;
