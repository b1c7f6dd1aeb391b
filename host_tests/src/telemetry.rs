//! The monitor's telemetry on the host: from bytes to lines of JSON, and to what they say of the spindle.
//!
//! | module | does |
//! | --- | --- |
//! | [`decoder`] | bytes to frames; counts what was damaged and what is missing |
//! | [`json`] | frames to lines of JSON, and lines to bytes again |
//! | [`state`] | what the frames so far say of the spindle |
//! | [`operator`] | commands to the board |
//! | [`simulated`] | telemetry of a recording, by the shipped monitor on this machine |

pub mod decoder;
pub mod json;
pub mod operator;
pub mod simulated;
pub mod state;
