//! The monitor's telemetry on the host: from bytes to lines of JSON, to the state of the spindle, and to a live view of it.
//!
//! | module | does |
//! | --- | --- |
//! | [`decoder`] | bytes to frames; counts damaged and missing ones |
//! | [`json`] | frames to lines of JSON, and lines to bytes again |
//! | [`state`] | the state of the spindle by the frames so far |
//! | [`health`], [`findings`] | health of the monitor, and what its probes have found, in words |
//! | [`operator`] | commands to the board |
//! | [`frames`] | frames to test with |
//! | [`simulated`] | telemetry of a recording, by the monitor of any spindle on this machine |
//! | `source` | bytes of a port, a recording or standard input |
//! | `session` | bytes to lines of JSON, to the state and to orders |
//! | `view` | the state of the spindle, drawn in a terminal |
//! | `picture` | a terminal's content as SVG |

pub mod decoder;
pub mod findings;
pub mod frames;
pub mod health;
pub mod json;
pub mod operator;
#[cfg(feature = "board")]
pub mod picture;
#[cfg(feature = "board")]
pub mod session;
#[cfg(feature = "solver")]
pub mod simulated;
#[cfg(feature = "board")]
pub mod source;
pub mod state;
#[cfg(feature = "board")]
pub mod view;
