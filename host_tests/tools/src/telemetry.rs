//! The monitor's telemetry at a terminal: where bytes come from, and a live view of what they say.
//!
//! | module | does |
//! | --- | --- |
//! | [`source`] | bytes of a port, a recording or standard input |
//! | [`session`] | what is done with them |
//! | [`view`] | the state of the spindle, drawn in a terminal |
//! | [`picture`] | a terminal's content as SVG |

pub mod picture;
pub mod session;
pub mod source;
pub mod view;
