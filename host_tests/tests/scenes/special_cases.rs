//! Scenes that are special cases of others.

use crate::solvers::{Found, Working, solver};
use host_tests::cases::{B218, B7005C, SKF6205};
use host_tests::compare::{stiffness_error, worse};
use host_tests::dispatch::Precision;
use host_tests::tolerances::{allowed, allowed_at};
use spindle_bearing::{AxialSolver, Bearing, Centrifugal, Full, Given, Motion, Solver, Static};
use spindle_bearing::{Design, InnerRaceControl, OuterRaceControl, Status};
use std::array::from_fn;
use std::fmt::Write;

/// Largest difference of two answers by the measures of the tables, over what is allowed.
fn apart(a: &Found, b: &Found, design: &Design, precision: Precision) -> f64 {
    let lever = 0.5 * design.pitch_diameter;
    let unit = |i: usize| if i < 3 { 1.0 } else { lever };
    let size = |v: &[f64]| {
        let sizes = v.iter().enumerate().map(|(i, x)| x.abs() * unit(i));
        sizes.fold(0.0, f64::max)
    };
    let bounds = allowed_at(precision, size(&b.u) / design.centre_distance());
    let mut worst = 0.0;
    for (i, (a, b_)) in a.u.iter().zip(&b.u).enumerate() {
        let error = (a - b_).abs() * unit(i) / size(&b.u);
        worst = worse(worst, error / bounds.displacement);
    }
    let largest = b.balls.iter().fold(0.0, |m, x| f64::max(m, x.q_o));
    for (a, b) in a.balls.iter().zip(&b.balls) {
        worst = worse(worst, (a.q_i - b.q_i).abs() / largest / bounds.force);
        worst = worse(worst, (a.q_o - b.q_o).abs() / largest / bounds.force);
    }
    let padded = |k: &[Vec<f64>]| -> [[f64; 5]; 5] {
        from_fn(|i| {
            from_fn(|j| {
                let element = k.get(i).and_then(|row| row.get(j)).copied();
                element.unwrap_or(f64::from(u8::from(i == j)))
            })
        })
    };
    let rows = a.k.len().min(b.k.len());
    let part = |k: &[Vec<f64>]| -> Vec<Vec<f64>> {
        k[..rows].iter().map(|row| row[..rows].to_vec()).collect()
    };
    let error = stiffness_error(&padded(&part(&a.k)), &padded(&part(&b.k)));
    worse(worst, error / bounds.stiffness)
}

/// Loads from light to heavy, for a bearing of this size.
fn loads(design: &Design) -> impl Iterator<Item = [f64; 5]> {
    let size = 12e6 * 9.0 * design.ball_diameter.powi(2); // the capacity of 9 balls, roughly
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

const DESIGNS: [Design; 3] = [B7005C, B218, SKF6205];

/// The answer of a solver without history; the ring has as many freedoms as values are given.
fn cold<T: Working, M: Motion>(bearing: &Bearing<T, 9>, given: &[Given<f64>], omega: f64) -> Found {
    solver::<T, 9, M>(bearing, given.len())
        .ask(given, omega)
        .unwrap_or_else(|status: Status<f32>| panic!("{given:?} at {omega} rad/s: {status}"))
}

/// `loads`, but for a displacement that is given of the freedom `held`.
fn holding<const D: usize>(loads: [f64; D], held: usize, u: f64) -> [Given<f64>; D] {
    let mut given = loads.map(Given::Load);
    given[held] = Given::Displacement(u);
    given
}

/// What there is to complain of.
fn special_cases<T: Working, M: Motion>(omega: fn(&Design) -> f64) -> String {
    let mut report = String::new();
    for design in &DESIGNS {
        let bearing = Bearing::<T, 9>::build(design).unwrap();
        let omega = omega(design);
        let cold = |given: &[Given<f64>]| cold::<T, M>(&bearing, given, omega);
        let mut check = |name: &str, a: &Found, b: &Found, most: f64| {
            let by = apart(a, b, design, T::PRECISION);
            if !(by <= most) {
                let what = format!(
                    "{by:.1} times what is allowed, {:?} and {:?}",
                    a.load, b.load
                );
                writeln!(report, "{name}, {:?}: {what}", T::PRECISION).unwrap();
            }
        };
        for load in loads(design) {
            let [fx, fy, fz, ..] = load;
            let one = cold(&[fx].map(Given::Load));
            let three = cold(&[fx, 0.0, 0.0].map(Given::Load));
            let five = cold(&[fx, 0.0, 0.0, 0.0, 0.0].map(Given::Load));
            check("axial, translations", &one, &three, 1.0);
            check("axial, all", &one, &five, 1.0);
            let of_three = cold(&[fx, fy, fz].map(Given::Load));
            let mut locked = [fx, fy, fz, 0.0, 0.0].map(Given::Load);
            locked[3..].fill(Given::Displacement(0.0));
            let of_five = cold(&locked);
            check("translations, tilts held at 0", &of_three, &of_five, 1.0);
            assert_eq!(of_five.u[3..], [0.0; 2]);
            // What holds the axial displacement of a load is that load.
            let loaded = cold(&load.map(Given::Load));
            let held = cold(&holding(load, 0, loaded.u[0]));
            assert_eq!(held.u[0], loaded.u[0]);
            let without_k = |found: &Found| Found {
                k: Vec::new(),
                ..found.clone()
            };
            // A given displacement is many deformations, and rounded.
            let rounded = 100.0;
            check(
                "rigid preload, all",
                &without_k(&held),
                &without_k(&loaded),
                rounded,
            );
            for (i, row) in held.k.iter().enumerate() {
                for (j, k) in row.iter().enumerate() {
                    let scale = (loaded.k[i][i] * loaded.k[j][j]).abs().sqrt();
                    let error = (k - loaded.k[i][j]).abs() / scale;
                    let bound = 10.0 * allowed(T::PRECISION).stiffness;
                    assert!(error <= bound, "K {i} {j}: {error:e}");
                }
            }
            let error = (held.load[0] / load[0] - 1.0).abs();
            let bound = rounded * allowed(T::PRECISION).force;
            assert!(
                error < bound,
                "reaction {}, load {}: {error:e}",
                held.load[0],
                load[0]
            );
        }
    }
    report
}

fn pass(reports: &[String]) {
    let report = reports.concat();
    assert!(report.is_empty(), "\n{report}");
}

/// Slow enough for the lightest of the loads.
fn slow(design: &Design) -> f64 {
    2.0 / design.pitch_diameter
}

#[test]
fn special_cases_at_rest_are_the_same_scenes() {
    pass(&[
        special_cases::<f64, Static>(|_| 0.0),
        special_cases::<f32, Static>(|_| 0.0),
    ]);
}

#[test]
fn special_cases_at_speed_are_the_same_scenes() {
    pass(&[
        special_cases::<f64, Full>(slow),
        special_cases::<f32, Full>(slow),
        special_cases::<f64, Full<InnerRaceControl>>(slow),
        special_cases::<f64, Centrifugal>(slow),
        special_cases::<f32, Centrifugal<OuterRaceControl>>(slow),
    ]);
}

#[test]
fn motions_at_rest_are_the_static_scene() {
    fn check<T: Working, M: Motion>() {
        for design in &DESIGNS {
            let bearing = Bearing::<T, 9>::build(design).unwrap();
            for load in loads(design) {
                let load = load.map(Given::Load);
                let rest = cold::<T, Static>(&bearing, &load, 0.0);
                let still = cold::<T, M>(&bearing, &load, 0.0);
                let by = apart(&still, &rest, design, T::PRECISION);
                assert!(by <= 1.0, "{by} times what is allowed\n{still:?}\n{rest:?}");
            }
        }
    }
    check::<f64, Full>();
    check::<f32, Full>();
    check::<f64, Centrifugal>();
    check::<f32, Centrifugal<OuterRaceControl>>();
}

#[test]
fn one_ball_is_kept_where_one_stands_for_all() {
    type One = AxialSolver<'static, f32, 16>;
    type All = Solver<'static, f32, 16, Full, 3>;
    assert!(size_of::<One>() * 8 < size_of::<All>());
}
