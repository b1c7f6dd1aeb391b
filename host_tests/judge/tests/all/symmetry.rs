//! Symmetries of the bearing: turned and mirrored loads have turned and mirrored solutions.

use super::solves::{Balls, LIFTING, SKEW, cold, lengths, loads, solver, vector_error};
use judge::cases::{B7005C, SKF6205, rad_per_s};
use judge::compare::stiffness_error;
use proptest::prelude::*;
use solvers::dispatch::Precision;
use spindle_bearing::Design;
use std::array::from_fn;
use std::f64::consts::TAU;

/// A force or displacement vector turned about the axis.
fn turned(f: [f64; 5], (sin, cos): (f64, f64)) -> [f64; 5] {
    [
        f[0],
        cos * f[1] - sin * f[2],
        sin * f[1] + cos * f[2],
        cos * f[3] - sin * f[4],
        sin * f[3] + cos * f[4],
    ]
}

/// A stiffness turned about the axis: rows and columns like vectors.
fn turned_stiffness(k: [[f64; 5]; 5], turn: (f64, f64)) -> [[f64; 5]; 5] {
    let transposed = |k: [[f64; 5]; 5]| -> [[f64; 5]; 5] { from_fn(|i| from_fn(|j| k[j][i])) };
    let rows = k.map(|row| turned(row, turn));
    transposed(transposed(rows).map(|column| turned(column, turn)))
}

/// Errors of displacement and stiffness under the turned load.
fn errors_of_turned(
    (design, n): (&Design, usize),
    balls: Balls,
    load: [f64; 5],
    rpm: f64,
    turn: (f64, f64),
) -> [f64; 2] {
    let omega = rad_per_s(rpm);
    let one = cold(design, n, balls, load, omega);
    let other = cold(design, n, balls, turned(load, turn), omega);
    [
        vector_error(
            other.displacement,
            turned(one.displacement, turn),
            lengths(design),
        ),
        stiffness_error(&other.stiffness, &turned_stiffness(one.stiffness, turn)),
    ]
}

#[test]
fn turning_the_load_by_90_degrees_turns_the_answer() {
    for (balls, load, rpm) in [
        (Balls::Free, SKEW, 0.0),
        (Balls::Free, SKEW, 5_000.0),
        (Balls::Free, SKEW, 20_000.0),
        (Balls::Free, SKEW, 40_000.0),
        (Balls::Outer, SKEW, 20_000.0),
        (Balls::Inner, SKEW, 20_000.0),
        (Balls::Centrifugal, SKEW, 20_000.0),
        (Balls::Static, SKEW, 0.0),
        (Balls::Free, LIFTING, 40_000.0),
    ] {
        let [u, k] = errors_of_turned((&B7005C, 16), balls, load, rpm, (1.0, 0.0));
        assert!(u < 1e-13 && k < 1e-12, "{balls:?}, {rpm} rpm: {u:e}, {k:e}");
    }
}

#[test]
fn the_sense_of_rotation_does_not_matter() {
    let omega = rad_per_s(20_000.0);
    let [forth, back] = [omega, -omega].map(|omega| cold(&B7005C, 16, Balls::Free, SKEW, omega));
    assert_eq!(forth, back);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..Default::default() })]

    #[test]
    fn turning_the_load_by_a_pitch_turns_the_answer(
        load in loads(), rpm in 0.0..40_000.0f64, pitches in 1..8u8,
    ) {
        let turn = (TAU * f64::from(pitches) / 8.0).sin_cos();
        let half = load.map(|x| 0.5 * x);
        let [u, k] = errors_of_turned((&SKF6205, 8), Balls::Free, half, 0.5 * rpm, turn);
        prop_assert!(u < 1e-9 && k < 1e-9, "{u:.1e}, {k:.1e}");
    }

    #[test]
    fn mirroring_the_load_mirrors_the_answer(load in loads(), rpm in 0.0..40_000.0f64) {
        const MIRROR: [f64; 5] = [1.0, 1.0, -1.0, -1.0, 1.0];
        let mirrored = |f: [f64; 5]| -> [f64; 5] { from_fn(|i| f[i] * MIRROR[i]) };
        let mut solver = solver(&B7005C, 16, Precision::F64, Balls::Free);
        let mut cold = |load| {
            solver.reset();
            solver.load(load, rad_per_s(rpm)).unwrap()
        };
        let (one, other) = (cold(load), cold(mirrored(load)));
        prop_assert!(vector_error(other.displacement, mirrored(one.displacement), lengths(&B7005C)) < 1e-9);
        let mut k = one.stiffness.map(mirrored);
        for (row, sign) in k.iter_mut().zip(MIRROR) {
            *row = row.map(|x| x * sign);
        }
        prop_assert!(stiffness_error(&other.stiffness, &k) < 1e-9);
    }
}
