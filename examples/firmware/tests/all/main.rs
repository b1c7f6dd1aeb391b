//! Tests of the boards' library with the monitor: sensors, the port, the flash, the spindle of the file.

mod flash;
mod identity;
mod receiver;
mod sensors;
#[allow(dead_code, reason = "the monitor's tests have uses for all of it")]
#[path = "../../../monitor/tests/all/spindle.rs"]
mod spindle;
