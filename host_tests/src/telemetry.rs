//! The monitor's telemetry on the host: from bytes to a table, and to what they say of the spindle.
//!
//! | module | does |
//! | --- | --- |
//! | [`decoder`] | bytes to frames; counts what was damaged and what is missing |
//! | [`table`] | frames to CSV, and back |
//! | [`operator`] | commands to the board |
//! | [`state`] | what the frames so far say of the spindle |
//! | [`simulated`] | telemetry of a recording, by the shipped monitor on this machine |

pub mod decoder;
pub mod operator;
pub mod simulated;
pub mod state;
pub mod table;
