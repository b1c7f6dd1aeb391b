//! One bearing under one load: displacement, stiffness, balls, life.
//!
//! ```sh
//! cargo run --example stiffness
//! ```

mod bearings;

use bearings::{BALLS, S6014C};
use spindle_bearing::{Bearing, LifeRating, Limits, Settings, Solver, Speed, Status};

/// Its constants, worked out by the compiler.
static BEARING: Bearing<f64, BALLS> = Bearing::<f64, BALLS>::const_new(&S6014C);
/// The catalogue's load rating is better, where there is one.
const RATING: LifeRating<f64> =
    LifeRating::<f64>::new(&S6014C, BALLS, S6014C.dynamic_load_rating(BALLS));

fn main() -> Result<(), Status<f64>> {
    let mut solver = Solver::new();
    let load = [700.0, 300.0, 0.0, 0.0, 5.0]; // Fx, Fy, Fz in N, My, Mz in N m
    let solution = solver.solve(&BEARING, load, Speed::rpm(10_000.0), &Settings::default())?;

    let [dx, dy, dz, ty, tz] = solution.displacement;
    println!(
        "displacement {:.3} {:.3} {:.3} um, {:.2} {:.2} urad",
        1e6 * dx,
        1e6 * dy,
        1e6 * dz,
        1e6 * ty,
        1e6 * tz
    );

    println!("\nstiffness dF/du, N/m, N/rad, N m/m, N m/rad");
    for row in solution.stiffness() {
        println!("{}", row.map(|k| format!("{k:12.4e}")).concat());
    }

    println!("\nball  alpha_i  alpha_o    Q_i    Q_o  pressure  spin-to-roll");
    println!("          deg      deg      N      N       MPa");
    for (j, (ball, motion)) in solution.balls().zip(solution.kinematics()).enumerate() {
        println!(
            "{j:4} {:8.2} {:8.2} {:6.1} {:6.1} {:9.0} {:13.4}",
            ball.alpha_i.to_degrees(),
            ball.alpha_o.to_degrees(),
            ball.q_i,
            ball.q_o,
            1e-6 * motion.inner.peak_pressure,
            motion.inner.spin_to_roll
        );
    }

    let heard = solution.frequencies();
    println!(
        "\nfrequencies: cage {:.1}, outer race {:.1}, inner race {:.1}, ball {:.1} Hz",
        heard.cage, heard.outer_race, heard.inner_race, heard.ball
    );
    let life = solution.rating_life(&RATING);
    println!(
        "rating life: {:.0} million revolutions, {:.0} h",
        life.million_revolutions, life.hours
    );
    let margins = solution.margins(&Limits::default());
    if !margins.passed().is_empty() {
        println!("{margins}");
    }
    Ok(())
}
