//! Loads that people type: round, alone, symmetric; and bearings that know no left from right.

use super::solves::{Answer, Balls, PRECISIONS, Question, ask, mirrored, off_mirror};
use judge::cases::{B218, SKF6205, rad_per_s};
use judge::compare::stiffness_error;
use rayon::prelude::*;
use solvers::dispatch::Precision;
use solvers::with_solver;
use spindle_bearing::{Bearing, Design, FreeContact, Growth, Settings, Solver, Speed, Status};
use spindle_file::plan::Plan;

/// Eight balls, no clearance: what a newcomer tries first.
const EIGHT: Design = Design {
    inner_groove_factor: 0.52,
    outer_groove_factor: 0.52,
    ..Design::angular_contact(10e-3, 65e-3, 0.0)
};

/// A bearing of that shape with balls of another number and size.
fn straight(balls: usize, ball_diameter: f64, factor: f64) -> Design {
    let room = 1.2 / (std::f64::consts::PI / balls as f64).sin();
    Design {
        inner_groove_factor: factor,
        outer_groove_factor: factor,
        ..Design::angular_contact(ball_diameter, room.max(2.5) * ball_diameter, 0.0)
    }
}

const FREE: Balls = Balls::Free;

/// The answers of one solver to a sequence of loads at a speed, each from nothing or from the one before.
fn answers(
    (design, balls): (&Design, usize),
    precision: Precision,
    warm: bool,
    loads: &[[f64; 5]],
    rpm: f64,
) -> Vec<Result<Answer, Status<f32>>> {
    let found = with_solver(&Plan::alone(design, balls), FREE, precision, |solver| {
        let solve = |load: &[f64; 5]| {
            if !warm {
                solver.reset();
            }
            solver.load(*load, rad_per_s(rpm))
        };
        loads.iter().map(solve).collect()
    });
    found.unwrap()
}

fn radial(force: f64) -> [f64; 5] {
    [0.0, force, 0.0, 0.0, 0.0]
}

/// Where four divides the number of balls, a radial load alone has two balls touch without force. Their stiffness is one
/// of rounding, and nothing else depends on it. A little load across presses one of them.
#[test]
fn radial_loads_on_balls_without_clearance_have_the_stiffness_of_those_a_little_aside() {
    let found = answers((&EIGHT, 8), Precision::F64, false, &[radial(500.0)], 0.0)
        .remove(0)
        .unwrap();
    assert!((found.displacement[1] / 8.8287919e-6 - 1.0).abs() < 1e-8);
    assert!((found.stiffness[1][1] / 8.4949e7 - 1.0).abs() < 1e-5);
    let sizes = (0..40).map(|i| 10.0 + 127.9 * f64::from(i));
    let loads: Vec<[f64; 5]> = sizes.map(radial).collect();
    let aside: Vec<[f64; 5]> = loads
        .iter()
        .map(|f| [0.0, f[1], 1e-6 * f[1], 0.0, 0.0])
        .collect();
    for (balls, design) in [
        (8, EIGHT),
        (8, straight(8, 25e-3, 0.515)),
        (12, straight(12, 4e-3, 0.53)),
        (16, straight(16, 10e-3, 0.52)),
        (20, straight(20, 30e-3, 0.52)),
        (24, straight(24, 8e-3, 0.515)),
    ] {
        let truths = answers((&design, balls), Precision::F64, false, &aside, 0.0);
        for (precision, bound) in PRECISIONS.into_iter().zip([1e-4, 1e-6]) {
            for warm in [false, true] {
                let found = answers((&design, balls), precision, warm, &loads, 0.0);
                for (found, truth) in found.iter().zip(&truths) {
                    let (found, truth) = (found.as_ref().unwrap(), truth.as_ref().unwrap());
                    let u = (found.displacement[1] / truth.displacement[1] - 1.0).abs();
                    let k = (found.stiffness[1][1] / truth.stiffness[1][1] - 1.0).abs();
                    assert!(u < bound && k < bound, "{balls} balls: {u:e}, {k:e}");
                }
            }
        }
    }
}

/// Radial loads, moments and two equal components along the balls' symmetries are solved, at rest and
/// where the shaft hardly turns, but for one in a thousand.
#[test]
fn loads_along_the_symmetries_of_the_balls_are_solved() {
    let mut lost = 0;
    for balls in [8, 12, 16] {
        let design = straight(balls, 10e-3, 0.52);
        for precision in PRECISIONS {
            for (rpm, warm) in [(0.0, false), (0.0, true), (30.0, false), (1000.0, true)] {
                let loads: Vec<[f64; 5]> = (1..40)
                    .flat_map(|i| {
                        let (f, m) = (50.0 * f64::from(i), f64::from(i));
                        [
                            [0.0, 0.0, -f, 0.0, 0.0],
                            [0.0, f, f, 0.0, 0.0],
                            [0.0, 0.0, 0.0, m, 0.0],
                            [0.0, 0.0, 0.0, m, -m],
                        ]
                    })
                    .collect();
                let found = answers((&design, balls), precision, warm, &loads, rpm);
                lost += found.iter().filter(|found| found.is_err()).count();
            }
        }
    }
    // Of 3,744 solves.
    assert!(lost <= 2, "{lost}");
}

/// A symmetric bearing does not know from which side it is loaded: displacement, stiffness, forces,
/// frequencies of the mirrored load are the mirrored ones.
#[test]
fn a_symmetric_bearing_has_the_mirrored_answer_to_the_mirrored_load() {
    let clearance = |pd: f64| Design {
        free_contact: FreeContact::DiametralClearance(pd),
        ..SKF6205
    };
    let designs = [
        (SKF6205, 9),
        (clearance(40e-6), 9),
        (clearance(-5e-6), 9),
        (EIGHT, 8),
    ];
    let loads = [
        [1000.0, 1000.0, 0.0, 0.0, 0.0],
        [100.0, 1000.0, 0.0, 0.0, 0.0],
        [300.0, 200.0, -150.0, 1.0, 2.0],
        [500.0, 0.0, 0.0, 0.0, 0.0],
        [20.0, 300.0, 100.0, -0.5, 0.3],
    ];
    for (precision, bound) in PRECISIONS.into_iter().zip([1e-5, 1e-10]) {
        for (design, balls) in &designs {
            let solve = |load, rpm| {
                answers((design, *balls), precision, false, &[load], rpm)
                    .remove(0)
                    .unwrap()
            };
            for load in loads {
                for rpm in [0.0, 6000.0, 20_000.0] {
                    let (one, other) = (solve(load, rpm), solve(mirrored(load), rpm));
                    let off = off_mirror(&one, &other, design);
                    assert!(off <= bound, "{precision:?}, {load:?} at {rpm}: {off:e}");
                }
            }
        }
    }
}

/// A radial load moves a symmetric bearing in its own direction alone.
#[test]
fn a_radial_load_alone_tilts_no_symmetric_bearing() {
    for rpm in [0.0, 6000.0] {
        let found = answers((&SKF6205, 9), Precision::F64, false, &[radial(1000.0)], rpm)
            .remove(0)
            .unwrap();
        let [dx, dy, _, ty, tz] = found.displacement;
        let pitch_radius = 0.5 * SKF6205.pitch_diameter;
        let tilt = pitch_radius * ty.abs().max(tz.abs());
        assert!(dx.abs().max(tilt) < 1e-12 * dy, "{:?}", found.displacement);
    }
}

/// A clearance of -5 um is a growth of 2.5 um without clearance.
#[test]
fn a_negative_clearance_is_a_growth_without_clearance() {
    let with = |pd: f64| Design {
        inner_groove_factor: 0.52,
        outer_groove_factor: 0.53,
        free_contact: FreeContact::DiametralClearance(pd),
        ..Design::angular_contact(11.5e-3, 43.5e-3, 0.0)
    };
    let settings = Settings::default();
    let pressed = Bearing::<f64, 16>::with_balls(&with(-5e-6), 7).unwrap();
    let grown = Bearing::<f64, 16>::with_balls(&with(0.0), 7).unwrap();
    let growth = Growth {
        radial: 2.5e-6,
        ..Growth::NONE
    };
    for (load, rpm) in [
        (radial(1000.0), 0.0),
        ([400.0, 300.0, 0.0, 1.0, 0.0], 9000.0),
    ] {
        let speed = Speed::rpm(rpm);
        let mut solver = Solver::new();
        let one = solver.solve(&pressed, load, speed, &settings).unwrap();
        let mut solver = Solver::new();
        let at = speed.with_growth([growth]);
        let other = solver.solve(&grown, load, at, &settings).unwrap();
        let largest = other.displacement[1].abs();
        for (a, b) in one.displacement.iter().zip(other.displacement) {
            assert!((a - b).abs() < 1e-11 * largest, "{a} {b}");
        }
        assert!(stiffness_error(&one.stiffness(), &other.stiffness()) < 1e-11);
    }
    // Balls that are pressed without a load hold the ring in the middle.
    let mut solver = Solver::new();
    let middle = solver
        .solve(&pressed, [0.0; 5], Speed::REST, &settings)
        .unwrap();
    assert!(middle.displacement.iter().all(|u| u.abs() < 1e-18));
    assert!(middle.stiffness()[1][1] > 8e7);
}

/// A row that nothing holds along its axis or against a tilt is told so, or that no equilibrium was found. It is never
/// told that more iterations would do. With enough axial load, the radial load is solved.
#[test]
fn a_ring_that_is_free_is_told_so_and_an_axial_load_holds_it() {
    let steep = Design {
        free_contact: FreeContact::Angle(30f64.to_radians()),
        ..straight(8, 30e-3, 0.52)
    };
    let b25 = Design::angular_contact(6.35e-3, 36e-3, 25f64.to_radians());
    let forces = (0..20).map(|i| 10f64.powf(1.0 + 0.14 * f64::from(i)));
    let asked: Vec<(f64, f64)> = forces
        .flat_map(|force| [0.0, 1000.0, 12_000.0].map(|rpm| (force, rpm)))
        .collect();
    for precision in PRECISIONS {
        let mut refused = 0;
        for (design, balls) in [(B218, 16), (b25, 16), (steep, 8)] {
            let is_refused = |&&(force, rpm): &&(f64, f64)| {
                let plan = Plan::alone(&design, balls);
                let solve = |axial: f64| {
                    let load = [axial, force, 0.0, 0.0, 0.0];
                    ask(
                        &plan,
                        FREE,
                        precision,
                        &Question::load(load, rad_per_s(rpm)),
                    )
                };
                let Err(status) = solve(0.0) else {
                    return false;
                };
                let place = format!("{precision:?}, {force} N at {rpm} rpm: {status}");
                let statuses = ["indeterminate", "diverged", "unseated"];
                assert!(statuses.contains(&status.name()), "{place}");
                assert!(status.to_string().contains("axial load"), "{place}");
                let is_held = (1..8).any(|n| solve(force * 4f64.powi(n)).is_ok());
                assert!(is_held, "{place}");
                true
            };
            refused += asked.par_iter().filter(is_refused).count();
        }
        assert!(refused > 20, "{refused}");
    }
}
