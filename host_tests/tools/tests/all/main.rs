//! The tools' tests in one program.

#[path = "../../../tests/all/frames.rs"]
mod frames;
mod limits;
mod malformed;
mod plot;
mod replay;
mod spindles;
mod view;
