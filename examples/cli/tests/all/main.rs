//! The programs' tests in one program.

mod limits;
mod malformed;
mod plot;
mod replay;
mod response;
mod sensitivity;
mod spindles;
mod times;
mod view;
