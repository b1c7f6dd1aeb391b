//! Where limits are passed, to the last bit; in both precisions; and the words for them.

use super::limits::{NOTHING, close, contacts, groove, scenes, shoulder, solve};
use host_tests::cases::{B218, B7005C, rad_per_s};
use host_tests::dispatch::Precision;
use host_tests::tolerances::allowed;
use spindle_bearing::{Centrifugal, Full, Motion, Static};
use spindle_bearing::{
    Design, Exceedance, InnerRaceControl, Limit, Limits, OuterRaceControl, Real,
};

/// The number between `off` and `on` at which a limit is first passed, to the last bits.
fn threshold(mut off: f64, mut on: f64, passed: impl Fn(f64) -> Option<Exceedance<f64>>) -> f64 {
    let (first, last) = (passed(off), passed(on));
    assert!(first.is_none() && last.is_some(), "{first:?} {last:?}");
    for _ in 0..48 {
        let middle = 0.5 * (off + on);
        if passed(middle).is_some() {
            on = middle;
        } else {
            off = middle;
        }
    }
    let e = passed(on).unwrap();
    assert!(close(e.value, e.allowed, 1e-9), "{e}");
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
    let pushed = |limit, axial| {
        let scene = ([axial, 0.0, 0.0, 0.0, 0.0], rad_per_s(100.0));
        let (passed, balls) = solve::<f64, Full>(&design, scene, &limits).unwrap();
        (passed.get(limit), balls)
    };
    let at = threshold(100.0, 10_000.0, |x| pushed(Limit::PeakPressure, x).0);
    let (_, balls) = pushed(Limit::PeakPressure, at);
    let pressures =
        contacts(&balls[0]).map(|(race, _, q, _)| groove(&design, race).1.peak_pressure(q));
    assert!(close(pressures[0].max(pressures[1]), 2e9, 1e-9));

    let at = threshold(100.0, 10_000.0, |x| pushed(Limit::Shoulder, x).0);
    let (_, balls) = pushed(Limit::Shoulder, at);
    let excess = contacts(&balls[0]).map(|(race, alpha, ..)| alpha - shoulder(&design, race));
    assert!(excess[0].max(excess[1]).abs() < 1e-9);

    let truncated = threshold(10.0, 10_000.0, |x| pushed(Limit::Truncation, x).0);
    assert!(truncated < at);

    let spun = |rpm| {
        let scene = ([200.0, 0.0, 0.0, 0.0, 0.0], rad_per_s(rpm));
        let (passed, _) = solve::<f64, Full>(&B218, scene, &limits).unwrap();
        passed.get(Limit::Friction)
    };
    threshold(10.0, 1000.0, spun);
}

#[test]
fn limits_that_are_infinite_or_no_numbers_are_never_passed() {
    for value in [f64::INFINITY, f64::NAN] {
        let limits = Limits {
            peak_pressure: value,
            friction: value,
        };
        for scene in scenes(8, 20) {
            if let Some((passed, _)) = solve::<f64, Full>(&B7005C, scene, &limits) {
                assert_eq!(passed.get(Limit::PeakPressure), None);
                assert_eq!(passed.get(Limit::Friction), None);
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
        let double = solve::<f64, Full>(&design, scene, &limits);
        let single = solve::<f32, Full>(&design, scene, &limits);
        let (Some((double, _)), Some((single, _))) = (double, single) else {
            continue;
        };
        for limit in Limit::ALL {
            // Of a value and of the angle, the worst of several equal balls included.
            let near = |value: f64, allowed: f64| match limit {
                Limit::PeakPressure => close(value, allowed, 1e-5),
                Limit::Friction => close(value, allowed, 1e-3),
                Limit::InnerContact => value < 1e-9,
                _ => (value - allowed).abs() < 64.0 * f64::from(f32::EPSILON),
            };
            match (double.get(limit), single.get(limit)) {
                (None, None) => {}
                (Some(a), Some(b)) => {
                    let b = f64::from(b.value);
                    let good = match limit {
                        // Forces are good to `errors.force` of the largest, and pressure has a third
                        // of their relative error.
                        Limit::PeakPressure => close(a.value, b, errors.force + 1e-6),
                        Limit::Friction => close(a.value, b, 1e-3),
                        Limit::InnerContact => (a.value - b).abs() < 1e-9,
                        _ => (a.value - b).abs() < errors.contact_angle + 1e-6,
                    };
                    assert!(good, "{scene:?}: {a} and {b}");
                    compared += 1;
                }
                (Some(a), None) => assert!(near(a.value, a.allowed), "{scene:?}: {a}"),
                (None, Some(b)) => {
                    assert!(near(b.value.into(), b.allowed.into()), "{scene:?}: {b}");
                }
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
                    let Some((passed, _)) = solve::<T, M>(&B7005C, scene, &NOTHING) else {
                        continue;
                    };
                    for e in passed.iter() {
                        assert!(
                            e.value.is_finite() && e.allowed.is_finite(),
                            "{scene:?}: {e}"
                        );
                        assert!(e.balls > 0 && e.balls <= 16 && e.ball < 16);
                    }
                }
            }
        }
    }
    check::<f32, Static>();
    check::<f32, Centrifugal>();
    check::<f32, Full>();
    check::<f32, Full<OuterRaceControl>>();
    check::<f32, Full<InnerRaceControl>>();
    check::<f64, Full>();
    check::<f64, Full<InnerRaceControl>>();
}

// ---------------------------------------------------------------------------------------------
// Words

#[test]
fn names_and_sentences() {
    let calm = ([300.0, 20.0, 0.0, 0.0, 0.0], rad_per_s(3000.0));
    let (passed, _) = solve::<f64, Full>(&B7005C, calm, &Limits::default()).unwrap();
    assert!(passed.is_empty() && passed.limits().is_empty());
    assert_eq!(
        (passed.to_string(), format!("{passed:?}")),
        (String::new(), "[]".to_owned())
    );

    let hard = ([60.0, 110.0, 30.0, 0.0, 0.2], rad_per_s(40_000.0));
    let limits = Limits {
        peak_pressure: 5e8,
        ..Limits::default()
    };
    let (passed, _) = solve::<f64, Full>(&B7005C, hard, &limits).unwrap();
    let set = passed.limits();
    assert!(
        set.contains(Limit::PeakPressure) && set.contains(Limit::InnerContact),
        "{passed}"
    );
    assert!(!set.contains(Limit::Friction));
    assert!(set.to_string().starts_with("peak-pressure "), "{set}");
    assert!(format!("{set:?}").starts_with("[PeakPressure, "), "{set:?}");
    let bits = set.iter().map(|limit| 1 << limit as u8).sum::<u8>();
    assert_eq!(set.bits(), bits);

    let text = passed.to_string();
    let expected = " Pa at ball 1's outer race, above 5.000e8 (16 balls); ball ";
    assert!(
        text.starts_with("peak pressure ") && text.contains(expected),
        "{text}"
    );
    assert!(text.contains(" off the inner race by "), "{text}");
}
