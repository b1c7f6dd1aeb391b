//! Scenes that are special cases of others.

use crate::solves::{Balls, Found, Question, lengths, ring_solver, size, vector_error};
use host_tests::cases::{B218, B7005C, SKF6205};
use host_tests::dispatch::Precision::{self, F32, F64};
use host_tests::tolerances::{allowed, allowed_at};
use spindle_bearing::{AxialSolver, Design, Full, Solver};

/// Fails if two answers differ by more than what the table allows, times `most`.
fn assert_alike(
    what: &str,
    a: &Found,
    b: &Found,
    design: &Design,
    precision: Precision,
    most: f64,
) {
    let freedoms = a.freedoms.min(b.freedoms);
    let [a, b] = [a, b].map(|found| {
        let mut contacts = found.clone();
        contacts.freedoms = freedoms;
        for ball in &mut contacts.balls {
            (ball.centrifugal_force, ball.gyroscopic_moment) = (0.0, 0.0);
        }
        contacts
    });
    let largest = size(b.u, lengths(design)) / design.centre_distance();
    let mut bounds = allowed_at(precision, largest).times(most);
    bounds.contact_angle = f64::INFINITY;
    let errors = a.errors(design, &b.equilibrium());
    assert!(errors.within(bounds), "{what}, {precision:?}: {errors}");
}

/// Loads from light to heavy, for a bearing of this size.
fn loads(design: &Design) -> impl Iterator<Item = [f64; 5]> {
    let size = 12e6 * 16.0 * design.ball_diameter.powi(2); // the capacity of 16 balls, roughly
    let lever = 0.5 * design.pitch_diameter;
    [1e-4, 1e-3, 1e-2, 1e-1].into_iter().flat_map(move |part| {
        let f = part * size;
        [
            [f, 0.3 * f, -0.1 * f, 0.02 * f * lever, -0.03 * f * lever],
            [f, 0.0, 0.2 * f, 0.01 * f * lever, 0.0],
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

/// Every special case against the scene that it is one of, at a speed that is slow enough for the lightest of the loads.
fn assert_special_cases(balls: Balls, precision: Precision) {
    for design in &DESIGNS {
        let omega = match balls {
            Balls::Static => 0.0,
            _ => 2.0 / design.pitch_diameter,
        };
        let cold = |freedoms, question| {
            ring_solver(design, 16, precision, balls, freedoms).solve(&question)
        };
        let alike = |what: &str, a: &Found, b: &Found| {
            assert_alike(what, a, b, design, precision, 1.0);
        };
        for load in loads(design) {
            let axial = Question::axial(load[0], omega);
            let [one, three, five] = [1, 3, 5].map(|freedoms| cold(freedoms, axial));
            alike("axial, translations", &one, &three);
            alike("axial, all", &one, &five);
            let of_three = cold(3, Question::load(load, omega));
            let tilts = [false, false, false, true, true];
            let of_five = cold(5, Question::mixed(tilts, [0.0; 5], load, omega));
            alike("translations, tilts held at 0", &of_three, &of_five);
            assert_eq!(of_five.u[3..], [0.0; 2]);
            let off = vector_error(of_three.u, of_five.u, [1.0; 5]);
            assert!(precision == F32 || off < 1e-13, "{off:e}");
            // The reaction to the axial displacement of a load is the load.
            let loaded = cold(5, Question::load(load, omega));
            let axially = [true, false, false, false, false];
            let mut held = cold(5, Question::mixed(axially, loaded.u, load, omega));
            assert_eq!(held.u[0], loaded.u[0]);
            for (i, row) in held.k.iter().enumerate() {
                for (j, k) in row.iter().enumerate() {
                    let scale = (loaded.k[i][i] * loaded.k[j][j]).abs().sqrt();
                    let error = (k - loaded.k[i][j]).abs() / scale;
                    let bound = 10.0 * allowed(precision).stiffness;
                    assert!(error <= bound, "K {i} {j}: {error:e}");
                }
            }
            // A given displacement is many deformations, and rounded.
            let rounded = 100.0;
            held.k = loaded.k;
            assert_alike(
                "rigid preload, all",
                &held,
                &loaded,
                design,
                precision,
                rounded,
            );
            let error = (held.load[0] / load[0] - 1.0).abs();
            assert!(error < rounded * allowed(precision).force, "{error:e}");
        }
    }
}

#[test]
fn special_cases_at_rest_are_the_same_scenes() {
    for precision in [F32, F64] {
        assert_special_cases(Balls::Static, precision);
    }
}

#[test]
fn special_cases_at_speed_are_the_same_scenes() {
    assert_special_cases(Balls::Free, F64);
    assert_special_cases(Balls::Free, F32);
    assert_special_cases(Balls::Inner, F64);
    assert_special_cases(Balls::Centrifugal, F64);
    assert_special_cases(Balls::CentrifugalOuter, F32);
}

#[test]
fn motions_at_rest_are_the_static_scene() {
    for (balls, precision) in [
        (Balls::Free, F64),
        (Balls::Free, F32),
        (Balls::Centrifugal, F64),
        (Balls::CentrifugalOuter, F32),
    ] {
        for design in &DESIGNS {
            for load in loads(design) {
                let question = Question::load(load, 0.0);
                let [still, rest] = [balls, Balls::Static]
                    .map(|balls| ring_solver(design, 16, precision, balls, 5).solve(&question));
                assert_alike("at rest", &still, &rest, design, precision, 1.0);
            }
        }
    }
}

#[test]
fn one_ball_is_kept_where_one_stands_for_all() {
    type One = AxialSolver<'static, f32, 16>;
    type All = Solver<'static, f32, 16, Full, 3>;
    assert!(size_of::<One>() * 8 < size_of::<All>());
}
