//! A shaft on a pair of bearings back to back: how preload and stiffness change with speed.
//!
//! ```sh
//! cargo run --example spindle
//! ```

mod bearings;

use bearings::{BALLS, S6014C};
use spindle_bearing::{Arrangement, Bearing, Growth, Preload, Settings, Speed};
use spindle_bearing::{Spindle, SpindleSolver};
use std::error::Error;

static BEARING: Bearing<f64, BALLS> = Bearing::<f64, BALLS>::const_new(&S6014C);

/// Distance between the centres of the two bearings, m.
const DISTANCE: f64 = 0.1;
/// Mounting preload, N: the light one of the catalogue.
const PRELOAD: f64 = 240.0;
/// Bore of the hollow shaft, m.
const BORE: f64 = 0.03;
/// Position of the nose, m: 60 mm in front of the first bearing's centre.
const NOSE: f64 = -0.06;

fn main() -> Result<(), Box<dyn Error>> {
    let preload = Preload::Force(PRELOAD);
    let pair = Spindle::pair(Arrangement::BackToBack, &BEARING, DISTANCE, preload)?;
    let mut solver = SpindleSolver::new();
    let load = [0.0, 200.0, 0.0, 0.0, 0.0]; // on the shaft at x = 0

    println!("  rpm  preload    axial   radial     nose");
    println!("             N     N/um     N/um     N/um");
    for thousands in (0..=16).step_by(2) {
        let speed = Speed::rpm(1e3 * f64::from(thousands));
        // The inner rings widen as the shaft turns.
        let growth = Growth::by_rotation(&S6014C, BORE, speed.as_rad_per_s());
        let at = speed.with_growth([growth; 2]);
        let solution = solver.solve(&pair, load, at, &Settings::default())?;
        let k = solution.stiffness();
        let nose = solution.compliance_at(NOSE);
        let preload = solution.rows().map(|row| row.preload()).next();
        println!(
            "{:5} {:8.0} {:8.1} {:8.1} {:8.1}",
            1000 * thousands,
            preload.unwrap_or_default(),
            1e-6 * k[0][0],
            1e-6 * k[1][1],
            1e-6 / nose[1][1]
        );
    }
    Ok(())
}
