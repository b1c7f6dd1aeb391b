//! What runs on the host: programs around the solver, and the tests that judge it.

pub mod campaign;
pub mod cases;
pub mod compare;
pub mod cross;
pub mod design_file;
pub mod dispatch;
pub mod double_double;
pub mod graph;
pub mod loads;
pub mod milling_cycle;
pub mod reference;
pub mod replay;
pub mod report;
pub mod stream;
pub mod study;
pub mod telemetry;
pub mod timing;
pub mod tolerances;
pub mod validation;
