//! The monitored spindle: one place for the firmware and for the host program that
//! checks it.

use core::f64::consts::PI;
use spindle_bearing::{
    Arrangement, Bearing, Design, ElasticSpindle, Facing, FreeContact, Material, Mounted, Preload,
    Section, Shaft, Spindle, Support,
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

/// Preload, N: of the pair by its spacers, as its rings are ground; of a single bearing by springs, as a part of its measured
/// load.
pub const PRELOAD: f64 = if ROWS == 1 { 420.0 } else { 250.0 };

/// Diameter of the hollow shaft's bore, m.
pub const BORE: f64 = 0.01;

/// A shaft of 25 mm, hollow, with a nose of 32 mm.
static SHAFT: Shaft<f32, 2> = Shaft::<f32, 2>::const_new(
    &[
        Section {
            from: 0.0,
            to: 0.022,
            outer: 0.032,
            inner: BORE,
        },
        Section {
            from: 0.022,
            to: 0.16,
            outer: 0.025,
            inner: BORE,
        },
    ],
    &Material::STEEL,
);

/// The housing at each row. **To be replaced by your spindle's**, measured or by finite elements: these are made up.
const SUPPORT: Support<f32> = Support {
    axial: 400e6,
    radial: 300e6,
    tilting: f32::INFINITY,
};

/// The bearings on the elastic shaft, in their housing.
pub static SPINDLE: ElasticSpindle<'static, f32, ROWS, BALLS> = {
    let (arrangement, preload) = match ROWS {
        1 => (Arrangement::ByRows, Preload::Closure(0.0)),
        _ => (Arrangement::BackToBack, Preload::Force(PRELOAD as f32)),
    };
    let mut rows = [Mounted::new(&BEARING, 0.0, Facing::PlusX); ROWS];
    let mut row = 0;
    while row < ROWS {
        let mounted = Mounted::new(&BEARING, POSITIONS[row] as f32, FACINGS[row]);
        rows[row] = mounted.with(preload);
        row += 1;
    }
    Spindle::<f32, ROWS, BALLS>::const_new(arrangement, rows).const_elastic(&SHAFT, [SUPPORT; ROWS])
};
