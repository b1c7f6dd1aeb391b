//! The monitor's tests in one program, so that they overlap.

mod alarm_times;
mod cutting;
mod estimator;
mod life;
mod life_between;
mod log;
mod monitor;
mod retained;
mod self_check;
mod shipped;
mod spindle;
