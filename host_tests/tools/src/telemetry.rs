//! The monitor's telemetry at a terminal: where bytes come from, and a live view of what they say.
//!
//! | module | does |
//! | --- | --- |
//! | [`source`] | bytes of a port, a file or standard input |
//! | [`view`] | the state of the spindle, drawn in a terminal |
//! | [`picture`] | a terminal's content as SVG |

pub mod picture;
mod shaft;
pub mod source;
pub mod view;
