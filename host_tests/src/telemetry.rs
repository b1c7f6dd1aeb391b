//! The monitor's telemetry on the host: from bytes to lines of JSON, and to the state of the spindle.
//!
//! | module | does |
//! | --- | --- |
//! | [`decoder`] | bytes to frames; counts damaged and missing ones |
//! | [`json`] | frames to lines of JSON, and lines to bytes again |
//! | [`state`] | the state of the spindle by the frames so far |
//! | [`operator`] | commands to the board |
//! | [`frames`] | frames to test with |
//! | [`simulated`] | telemetry of a recording, by the shipped monitor on this machine |

pub mod decoder;
pub mod frames;
pub mod json;
pub mod operator;
pub mod simulated;
pub mod state;
