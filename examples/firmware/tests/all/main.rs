//! Tests of the boards' library with the monitor: sensors, the port, the flash, the spindle of the file.

mod flash;
mod identity;
mod receiver;
mod sensors;
#[path = "../../../monitor/tests/all/spindle.rs"]
mod spindle;
