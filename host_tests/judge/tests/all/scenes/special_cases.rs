//! Scenes that are special cases of others.

use crate::solves::{Balls, Question, errors, lengths, ring_solver, size, vector_error};
use ::judge::cases::{B218, B7005C, SKF6205};
use ::judge::compare::Equilibrium;
use ::judge::tolerances::allowed_at;
use solvers::dispatch::Precision::{F32, F64};
use spindle_bearing::{AxialSolver, Design, RacewayControlFree, Solver};

/// Loads from light to heavy, for a bearing of this size.
fn loads(design: &Design) -> impl Iterator<Item = [f64; 5]> {
    let size = 12e6 * 16.0 * design.ball_diameter.powi(2); // the capacity of 16 balls, roughly
    let lever = 0.5 * design.pitch_diameter;
    [1e-4, 1e-3, 1e-2, 1e-1].into_iter().flat_map(move |part| {
        let f = part * size;
        [
            [f, 0.3 * f, -0.1 * f, 0.02 * f * lever, -0.03 * f * lever],
            [f, 0.0, 0.0, 0.0, 0.0],
            [-f, 0.2 * f, 0.0, 0.0, 0.02 * f * lever],
        ]
    })
}

/// The last is a deep groove bearing with room for 16 balls.
const DESIGNS: [Design; 3] = [
    B7005C,
    B218,
    Design {
        pitch_diameter: 48e-3,
        ..SKF6205
    },
];

/// Speeds are slow enough for the lightest of the loads.
#[test]
fn three_freedoms_are_five_whose_tilts_are_held_at_nought() {
    let scenes = [
        (Balls::Static, F32),
        (Balls::Static, F64),
        (Balls::Free, F32),
        (Balls::Free, F64),
        (Balls::Inner, F64),
        (Balls::Centrifugal, F64),
        (Balls::CentrifugalOuter, F32),
    ];
    let tilts = [false, false, false, true, true];
    for (balls, precision) in scenes {
        for design in &DESIGNS {
            for load in loads(design) {
                let omega = 2.0 / design.pitch_diameter;
                let cold = |freedoms, question| {
                    ring_solver(design, 16, precision, balls, freedoms).answer(&question)
                };
                let three = cold(3, Question::load(load, omega));
                let five = cold(5, Question::load(load, omega).holding(tilts, [0.0; 5]));
                assert_eq!(five.displacement[3..], [0.0; 2]);
                let off = vector_error(three.displacement, five.displacement, [1.0; 5]);
                assert!(precision == F32 || off < 1e-13, "{off:e}");
                let largest = size(five.displacement, lengths(design)) / design.centre_distance();
                let mut bounds = allowed_at(precision, largest);
                bounds.contact_angle = f64::INFINITY;
                let errors = errors(&three, design, &Equilibrium::from(&five), 3);
                assert!(errors.within(bounds), "{balls:?}, {precision:?}: {errors}");
            }
        }
    }
}

#[test]
fn one_ball_is_kept_where_one_stands_for_all() {
    type One = AxialSolver<f32>;
    type All = Solver<f32, 16, RacewayControlFree, 3>;
    assert!(size_of::<One>() * 6 < size_of::<All>());
}
