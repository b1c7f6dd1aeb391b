//! The monitored spindle: one place for the firmware and for the host program that
//! checks it.

use core::f64::consts::PI;
use spindle_bearing::{
    Arrangement, Bearing, Design, Facing, FreeContact, Material, Mounted, Preload, Spindle,
    SpindleError,
};

/// Rows of balls: two bearings back to back, or a single one. Set it here, or build with `SPINDLE_ROWS=1` in the
/// environment.
pub const ROWS: usize = match option_env!("SPINDLE_ROWS") {
    None => 2,
    Some(rows) => match rows.as_bytes() {
        b"1" => 1,
        b"2" => 2,
        _ => panic!("SPINDLE_ROWS is 1 or 2"),
    },
};

/// Balls of a row.
pub const BALLS: usize = 16;

/// A B7005C of steel, SI units.
pub const DESIGN: Design = Design {
    ball_diameter: 6.35e-3,
    pitch_diameter: 36e-3,
    inner_groove_factor: 0.515,
    outer_groove_factor: 0.525,
    free_contact: FreeContact::Angle(15.0 * PI / 180.0),
    inner_shoulder_angle: 48.0 * PI / 180.0,
    outer_shoulder_angle: 47.5 * PI / 180.0,
    first_ball: 0.0,
    ring: Material::STEEL,
    ball: Material::STEEL,
};

/// Its constants, worked out by the compiler.
pub static BEARING: Bearing<f32, BALLS> = Bearing::<f32, BALLS>::const_new(&DESIGN);

/// Positions of the rows on the shaft, m: the nose is at 0. A single bearing is at 0, where its loads act.
pub const POSITIONS: [f64; ROWS] = if ROWS == 1 {
    [0.0; ROWS]
} else {
    let mut positions = [0.03; ROWS];
    positions[ROWS - 1] = 0.13;
    positions
};

/// Facings of the rows: a pair is back to back.
pub const FACINGS: [Facing; ROWS] = {
    let mut facings = [Facing::PlusX; ROWS];
    if ROWS > 1 {
        facings[ROWS - 1] = Facing::MinusX;
    }
    facings
};

/// Preload, N: of the pair by its spacers; of a single bearing by springs, as a part of its measured load.
pub const PRELOAD: f64 = if ROWS == 1 { 420.0 } else { 250.0 };

/// The bearings on their shaft.
///
/// # Errors
///
/// Rows that are not arranged as they are said to be.
#[allow(dead_code, reason = "not of those who want the bearing alone")]
pub fn spindle() -> Result<Spindle<'static, f32, ROWS, BALLS>, SpindleError<f32>> {
    let (arrangement, preload) = match ROWS {
        1 => (Arrangement::ByRows, Preload::Closure(0.0)),
        _ => (Arrangement::BackToBack, Preload::Force(PRELOAD as f32)),
    };
    let mounted = |i| Mounted::new(&BEARING, POSITIONS[i] as f32, FACINGS[i]).with(preload);
    Spindle::new(arrangement, core::array::from_fn(mounted))
}
