//! Stiffness over the speed at a constant load, as a table and as a picture.
//!
//! ```sh
//! cargo run --example speed_sweep -- sweep.svg > sweep.csv
//! ```

mod bearings;

use bearings::{BALLS, S6014C};
use poloto::build;
use spindle_bearing::{Bearing, Settings, Solver, Speed};
use std::error::Error;

static BEARING: Bearing<f64, BALLS> = Bearing::<f64, BALLS>::checked(&S6014C);

/// N: the medium preload of the catalogue.
const AXIAL: f64 = 700.0;

fn main() -> Result<(), Box<dyn Error>> {
    // Each solve starts from the one before.
    let mut solver = Solver::new(&BEARING);
    let mut curves = [const { Vec::new() }; 2];
    println!("speed_rpm,axial_n_per_um,radial_n_per_um,tilting_knm_per_rad");
    for step in 0..=80 {
        let speed = 250.0 * f64::from(step);
        let load = [AXIAL, 0.0, 0.0, 0.0, 0.0];
        let solution = solver.solve(load, Speed::rpm(speed), &Settings::default())?;
        let k = solution.stiffness();
        let [axial, radial] = [1e-6 * k[0][0], 1e-6 * k[1][1]];
        println!("{speed},{axial:.3},{radial:.3},{:.4}", 1e-3 * k[3][3]);
        curves[0].push([speed, axial]);
        curves[1].push([speed, radial]);
    }

    let Some(picture) = std::env::args_os().nth(1) else {
        eprintln!("For a picture, name a file: cargo run --example speed_sweep -- sweep.svg");
        return Ok(());
    };
    let curves = poloto::plots!(
        build::plot("axial").line(&curves[0]),
        build::plot("radial").line(&curves[1]),
        // The vertical axis begins at nothing.
        build::markers([], [0.0])
    );
    let svg = poloto::frame_build()
        .data(curves)
        .build_and_label(("S 6014 C under 700 N", "speed, rpm", "stiffness, N/um"))
        .append_to(poloto::header().light_theme())
        .render_string()?;
    std::fs::write(&picture, svg)?;
    eprintln!("drawn: {}", picture.display());
    Ok(())
}
