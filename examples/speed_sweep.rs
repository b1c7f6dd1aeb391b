//! Stiffness over the speed at a constant load, as a table.
//!
//! ```sh
//! cargo run --example speed_sweep > sweep.csv
//! ```

mod bearings;

use bearings::{BALLS, S6014C};
use spindle_bearing::{Bearing, Settings, Solver, Speed, Status};

static BEARING: Bearing<f64, BALLS> = Bearing::<f64, BALLS>::const_new(&S6014C);

/// N: the medium preload of the catalogue.
const AXIAL: f64 = 700.0;

fn main() -> Result<(), Status<f64>> {
    // Each solve starts from the one before.
    let mut solver = Solver::new();
    println!("speed_rpm,axial_n_per_um,radial_n_per_um,tilting_knm_per_rad");
    for step in 0..=80 {
        let speed = 250.0 * f64::from(step);
        let load = [AXIAL, 0.0, 0.0, 0.0, 0.0];
        let solution = solver.solve(&BEARING, load, Speed::rpm(speed), &Settings::default())?;
        let k = solution.stiffness();
        let [axial, radial, tilting] = [1e-6 * k[0][0], 1e-6 * k[1][1], 1e-3 * k[3][3]];
        println!("{speed},{axial:.3},{radial:.3},{tilting:.4}");
    }
    Ok(())
}
