//! The monitor's telemetry at a terminal: sources of bytes, and a live view of the spindle's state.
//!
//! | module | does |
//! | --- | --- |
//! | [`source`] | bytes of a port, a recording or standard input |
//! | [`session`] | bytes to lines of JSON, to the state and to orders |
//! | [`view`] | the state of the spindle, drawn in a terminal |
//! | [`picture`] | a terminal's content as SVG |

pub mod picture;
pub mod session;
pub mod source;
pub mod view;
