//! Where a bearing may run: speed across, axial load upwards, and which limit it passes there.
//!
//! ```sh
//! cargo run --example load_map > map.csv
//! ```
//!
//! The map goes to the terminal, the figures to the table.

mod bearings;

use bearings::{BALLS, S6014C};
use spindle_bearing::{Bearing, Limit, Limits, Settings, Solver, Speed};

static BEARING: Bearing<f64, BALLS> = Bearing::<f64, BALLS>::const_new(&S6014C);

/// N: of a light cut.
const RADIAL: f64 = 800.0;
/// For years of service.
const LIMITS: Limits<f64> = Limits {
    peak_pressure: 2e9,
    friction: 0.05,
};
/// Contact angle of the inner race above which a bearing of 15 degrees is overloaded, degrees.
const STEEPEST: f64 = 30.0;

fn main() {
    let mut solver = Solver::new();
    println!("speed_rpm,fx_n,peak_pressure_mpa,largest_alpha_i_deg,limits");
    eprintln!("axial load, N; {RADIAL} N radially");
    for load in (0..=20).rev() {
        let axial = 750.0 * f64::from(load) + 250.0;
        let mut line = String::new();
        for step in 0..=60 {
            line.push(cell(&mut solver, 400.0 * f64::from(step), axial));
        }
        eprintln!("{axial:6.0} |{line}");
    }
    eprintln!("       +{}", "---------+".repeat(6));
    eprintln!("        0    speed, 4,000 rpm between two marks    24,000");
    eprintln!(". runs well   p peak pressure above 2,000 MPa   u balls without contact");
    eprintln!(
        "a contact angle above {STEEPEST} degrees   f friction above 0.05   x no equilibrium"
    );
}

/// One point: a line of the table, and what is drawn for it.
fn cell(solver: &mut Solver<f64, BALLS>, speed: f64, axial: f64) -> char {
    let load = [axial, RADIAL, 0.0, 0.0, 0.0];
    let solution = match solver.solve(&BEARING, load, Speed::rpm(speed), &Settings::default()) {
        Ok(solution) => solution,
        Err(status) => {
            println!("{speed},{axial},,,{status}");
            return 'x';
        }
    };
    let margins = solution.margins(&LIMITS);
    let passed = margins.passed();
    let pressure = margins
        .get(Limit::PeakPressure)
        .map_or(0.0, |worst| worst.value);
    let carrying = solution.balls().filter(|ball| ball.q_i > 0.0);
    let steepest = carrying.fold(0.0, |most: f64, ball| most.max(ball.alpha_i.to_degrees()));
    println!(
        "{speed},{axial},{:.0},{steepest:.2},{passed}",
        1e-6 * pressure
    );
    if passed.contains(Limit::PeakPressure) {
        'p'
    } else if passed.contains(Limit::InnerContact) {
        'u'
    } else if steepest > STEEPEST {
        'a'
    } else if passed.contains(Limit::Friction) {
        'f'
    } else {
        '.'
    }
}
