//! The tools' tests in one program.

#[path = "../../../tests/all/frames.rs"]
mod frames;
#[path = "../../../tests/all/malformed.rs"]
mod malformed;
mod plot;
mod replay;
mod spindles;
mod view;
