//! Where limits are passed, to the last bit; in both precisions; and the words for them.

use super::limits::{NOTHING, close, contacts, groove, scenes, shoulder, solve};
use judge::cases::{B218, B7005C, rad_per_s};
use judge::tolerances::allowed;
use solvers::dispatch::Precision;
use spindle_bearing::{Centrifugal, Motion, RacewayControlFree, Static};
use spindle_bearing::{Design, InnerRaceControl, Limit, Limits, Margins, OuterRaceControl, Real};

/// The number between `off` and `on` at which a limit is first passed, to the last bits.
fn threshold(
    (mut off, mut on): (f64, f64),
    (limit, allowed): (Limit, f64),
    margins: impl Fn(f64) -> Margins<f64>,
) -> f64 {
    let passed = |at| margins(at).passed().contains(limit);
    assert!(!passed(off) && passed(on), "{limit:?}");
    for _ in 0..48 {
        let middle = 0.5 * (off + on);
        if passed(middle) {
            on = middle;
        } else {
            off = middle;
        }
    }
    let value = margins(on).get(limit).unwrap().value;
    assert!(value > allowed && value - allowed < 1e-9 * allowed.max(1e-3));
    on
}

#[test]
fn a_limit_is_passed_where_its_value_reaches_what_is_allowed() {
    let limits = Limits {
        peak_pressure: 2e9,
        friction: 0.02,
    };
    let design = Design {
        inner_shoulder_angle: 21f64.to_radians(),
        outer_shoulder_angle: 20f64.to_radians(),
        ..B7005C
    };
    let solved = |axial| {
        let scene = ([axial, 0.0, 0.0, 0.0, 0.0], rad_per_s(100.0));
        solve::<f64, RacewayControlFree>(&design, scene, &limits).unwrap()
    };
    let pushed = |axial| solved(axial).0;
    let range = (100.0, 10_000.0);
    let at = threshold(range, (Limit::PeakPressure, 2e9), pushed);
    let pressures =
        contacts(&solved(at).1[0]).map(|(race, _, q, _)| groove(&design, race).1.peak_pressure(q));
    assert!(close(pressures[0].max(pressures[1]), 2e9, 1e-9));

    let at = threshold(range, (Limit::Shoulder, 0.0), pushed);
    let excess =
        contacts(&solved(at).1[0]).map(|(race, alpha, ..)| alpha - shoulder(&design, race));
    assert!(excess[0].max(excess[1]).abs() < 1e-9);

    let truncated = threshold((10.0, 10_000.0), (Limit::Truncation, 0.0), pushed);
    assert!(truncated < at);

    threshold((10.0, 1000.0), (Limit::Friction, 0.02), |rpm| {
        let scene = ([200.0, 0.0, 0.0, 0.0, 0.0], rad_per_s(rpm));
        solve::<f64, RacewayControlFree>(&B218, scene, &limits)
            .unwrap()
            .0
    });
}

#[test]
fn limits_that_are_infinite_or_no_numbers_are_never_passed() {
    for value in [f64::INFINITY, f64::NAN] {
        let limits = Limits {
            peak_pressure: value,
            friction: value,
        };
        for scene in scenes(8, 20) {
            if let Some((margins, _)) = solve::<f64, RacewayControlFree>(&B7005C, scene, &limits) {
                let passed = margins.passed();
                assert!(!passed.contains(Limit::PeakPressure) && !passed.contains(Limit::Friction));
            }
        }
    }
}

// ---------------------------------------------------------------------------------------------
// Precision

#[test]
fn single_precision_sees_what_double_precision_sees() {
    let errors = allowed(Precision::F32);
    let design = Design {
        inner_shoulder_angle: 19f64.to_radians(),
        outer_shoulder_angle: 18f64.to_radians(),
        ..B7005C
    };
    let limits = Limits {
        peak_pressure: 1.5e9,
        friction: 0.02,
    };
    let mut compared = 0;
    for scene in scenes(9, 300) {
        let double = solve::<f64, RacewayControlFree>(&design, scene, &limits);
        let single = solve::<f32, RacewayControlFree>(&design, scene, &limits);
        let (Some((double, _)), Some((single, _))) = (double, single) else {
            continue;
        };
        // Radius of the closest groove.
        let radius = 0.5 * design.ball_diameter;
        for limit in Limit::ALL {
            let allowed = match limit {
                Limit::PeakPressure => limits.peak_pressure,
                Limit::Friction => limits.friction,
                _ => 0.0,
            };
            // Of a value and of the angle, the worst of several equal balls included.
            let near = |value: f64| match limit {
                Limit::PeakPressure => close(value, allowed, 1e-5),
                Limit::Friction => close(value, allowed, 1e-2),
                Limit::InnerContact => value < 1e-9,
                // A length: of that angle, at no more than the groove's radius.
                Limit::Truncation => value < 64.0 * f64::from(f32::EPSILON) * radius,
                _ => value < 64.0 * f64::from(f32::EPSILON),
            };
            let (a, b) = (double.get(limit), single.get(limit));
            let (a, b) = (a.map(|a| a.value), b.map(|b| f64::from(b.value)));
            let passed = [double.passed(), single.passed()].map(|set| set.contains(limit));
            match (a, b, passed) {
                (_, _, [false, false]) => {}
                (Some(a), Some(b), [true, true]) => {
                    let angle = errors.contact_angle + 1e-6;
                    let good = match limit {
                        // Forces are good to `errors.force` of the largest, and pressure has a third
                        // of their relative error.
                        Limit::PeakPressure => close(a, b, errors.force + 1e-6),
                        // Error of a ball with a hundredth of the largest force.
                        Limit::Friction => close(a, b, 1e-2),
                        Limit::InnerContact => (a - b).abs() < 1e-9,
                        Limit::Truncation => (a - b).abs() < angle * radius,
                        _ => (a - b).abs() < angle,
                    };
                    assert!(good, "{scene:?}: {limit:?} {a} and {b}");
                    compared += 1;
                }
                (Some(a), _, [true, _]) => assert!(near(a), "{scene:?}: {limit:?} {a}"),
                (_, Some(b), _) => assert!(near(b), "{scene:?}: {limit:?} {b}"),
                _ => unreachable!(),
            }
        }
    }
    assert!(compared > 300, "{compared}");
}

#[test]
fn every_value_is_a_number() {
    fn check<T: Real, M: Motion>() {
        for (load, omega) in scenes(10, 100) {
            for factor in [1e-6, 1.0, 1e3] {
                for speed in [1.0, 5.0] {
                    let scene = (load.map(|f| factor * f), speed * omega);
                    let Some((margins, _)) = solve::<T, M>(&B7005C, scene, &NOTHING) else {
                        continue;
                    };
                    for margin in Limit::ALL.into_iter().filter_map(|l| margins.get(l)) {
                        assert!(margin.value.is_finite(), "{scene:?}: {margin:?}");
                        assert!(margin.ball < 16 && margins.unloaded <= 16);
                    }
                }
            }
        }
    }
    check::<f32, Static>();
    check::<f32, Centrifugal>();
    check::<f32, RacewayControlFree>();
    check::<f32, OuterRaceControl>();
    check::<f32, InnerRaceControl>();
    check::<f64, RacewayControlFree>();
    check::<f64, InnerRaceControl>();
}

// ---------------------------------------------------------------------------------------------
// Words

#[test]
fn names_and_sentences() {
    let calm = ([300.0, 20.0, 0.0, 0.0, 0.0], rad_per_s(3000.0));
    let (margins, _) = solve::<f64, RacewayControlFree>(&B7005C, calm, &Limits::default()).unwrap();
    assert!(margins.passed().is_empty());
    assert_eq!(margins.to_string(), "");

    let hard = ([60.0, 110.0, 30.0, 0.0, 0.2], rad_per_s(40_000.0));
    let limits = Limits {
        peak_pressure: 5e8,
        ..Limits::default()
    };
    let (margins, _) = solve::<f64, RacewayControlFree>(&B7005C, hard, &limits).unwrap();
    let set = margins.passed();
    assert!(
        set.contains(Limit::PeakPressure) && set.contains(Limit::InnerContact),
        "{set}"
    );
    assert!(!set.contains(Limit::Friction));
    assert!(set.to_string().starts_with("peak-pressure "), "{set}");
    assert!(format!("{set:?}").starts_with("[PeakPressure, "), "{set:?}");
    let bits = set.iter().map(|limit| 1 << limit as u8).sum::<u8>();
    assert_eq!(set.bits(), bits);

    let text = margins.to_string();
    let expected = " Pa at ball 1's outer race, above 5.000e8; ";
    assert!(
        text.starts_with("peak pressure ") && text.contains(expected),
        "{text}"
    );
    assert!(
        text.ends_with(" m at ball 13's inner race (1 ball unloaded)"),
        "{text}"
    );
}
