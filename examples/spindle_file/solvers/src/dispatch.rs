//! Precision and attitude rule known at run time, and figures of any precision in doubles.

use serde::Deserialize;
use spindle_bearing::{BallKinematics, BallState, ContactPatch, Frequencies, Real, Status};
use std::fmt::{self, Write};

/// The working precision of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// Single precision, as the firmware computes
    F32,
    /// Double precision
    F64,
}

impl Precision {
    /// Writes `value`, a number of this precision, with as few digits as read back to exactly that number.
    pub fn write(self, text: &mut String, value: f64) -> fmt::Result {
        // Rust's own formatting of floats is the shortest that reads back. An exponent starts where zeros would fill the text.
        let size = value.abs();
        let plain = value == 0.0 || !size.is_finite() || (1e-4..1e16).contains(&size);
        match (self, plain) {
            (Self::F32, true) => write!(text, "{}", value as f32),
            (Self::F32, false) => write!(text, "{:e}", value as f32),
            (Self::F64, true) => write!(text, "{value}"),
            (Self::F64, false) => write!(text, "{value:e}"),
        }
    }
}

/// The rule for the axis about which a ball turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Attitude {
    /// Raceway-control-free: from d'Alembert's principle, which does not assume race control
    #[default]
    Raceless,
    /// Outer race control: no spin at the outer race
    Outer,
    /// Inner race control: no spin at the inner race; not for loads that lift balls off it
    Inner,
}

/// A status in single precision.
pub fn narrowed<T: Real>(status: Status<T>) -> Status<f32> {
    match status {
        Status::Converged => Status::Converged,
        Status::PrecisionLimit => Status::PrecisionLimit,
        Status::IterationLimit => Status::IterationLimit,
        Status::Unseated { ball, apart } => Status::Unseated {
            ball,
            apart: apart.to_f32(),
        },
        Status::NotFinite { quantity, value } => Status::NotFinite {
            quantity,
            value: value.to_f32(),
        },
        Status::OutOfRange {
            quantity,
            value,
            limit,
        } => Status::OutOfRange {
            quantity,
            value: value.to_f32(),
            limit: limit.to_f32(),
        },
        Status::Unloaded => Status::Unloaded,
        Status::Indeterminate { loaded_balls, free } => {
            Status::Indeterminate { loaded_balls, free }
        }
        Status::Diverged { residual } => Status::Diverged {
            residual: residual.to_f32(),
        },
        other => unreachable!("{other}"),
    }
}

/// A matrix in doubles.
pub fn wide<T: Real>(m: &[[T; 5]; 5]) -> [[f64; 5]; 5] {
    m.map(|row| row.map(T::to_f64))
}

/// Copies figures in doubles: answers of the library may grow, and are not made elsewhere.
macro_rules! widened {
    ($from:expr, $to:expr, $($field:ident)*) => {{
        let (from, mut to) = ($from, $to);
        $(to.$field = from.$field.to_f64();)*
        to
    }};
}

/// A ball's state in doubles.
pub fn widened<T: Real>(ball: &BallState<T>) -> BallState<f64> {
    widened!(
        ball, BallState::default(), azimuth alpha_i alpha_o q_i q_o delta_i delta_o
        centrifugal_force gyroscopic_moment
    )
}

/// A ball's motion in doubles.
pub fn widened_motion<T: Real>(motion: &BallKinematics<T>) -> BallKinematics<f64> {
    let patch = |patch: &ContactPatch<T>| {
        widened!(
            patch, ContactPatch::default(), peak_pressure semi_major semi_minor spin_to_roll
        )
    };
    let mut wide = widened!(motion, BallKinematics::default(), cage_speed rotation attitude);
    (wide.inner, wide.outer) = (patch(&motion.inner), patch(&motion.outer));
    wide
}

/// Frequencies in doubles.
pub fn widened_frequencies<T: Real>(frequencies: &Frequencies<T>) -> Frequencies<f64> {
    widened!(frequencies, Frequencies::default(), cage outer_race inner_race ball)
}
