//! The monitor's telemetry on the host: from the bytes of a serial port, a file or an emulator to a
//! table, and to a live view in the terminal.
//!
//! | module | does |
//! | --- | --- |
//! | [`source`] | bytes of a port, a file or standard input |
//! | [`decoder`] | bytes to frames; counts what was damaged and what is missing |
//! | [`table`] | frames to CSV, and back |
//! | [`operator`] | commands to the board |
//! | [`state`] | what the frames so far say of the spindle |
//! | [`view`] | that, drawn in a terminal |
//! | [`picture`] | a terminal's content as SVG |
//! | [`simulated`] | telemetry of a recording, made by the host's own solver |

pub mod decoder;
pub mod operator;
pub mod picture;
pub mod simulated;
pub mod source;
pub mod state;
pub mod table;
pub mod view;
