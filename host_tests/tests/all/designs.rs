//! Designs that cannot be built: what is said to them.

use host_tests::cases::B7005C;
use spindle_bearing::Bearing;
use spindle_bearing::{Design, DesignError, FreeContact, Quantity};
use std::f64::consts::PI;

fn refusal(change: impl FnOnce(&mut Design)) -> DesignError {
    let mut design = B7005C;
    change(&mut design);
    let double = Bearing::<f64, 16>::new(&design);
    let single = Bearing::<f32, 16>::new(&design);
    let (Err(double), Err(single)) = (double, single) else {
        panic!("built: {design:?}");
    };
    assert_eq!(double.quantity, single.quantity);
    double
}

type Field = (Quantity, fn(&mut Design, f64));

/// Every number of a design. The flag says whether it may be zero.
const FIELDS: [(Field, bool); 14] = [
    ((Quantity::BallDiameter, |d, x| d.ball_diameter = x), false),
    (
        (Quantity::PitchDiameter, |d, x| d.pitch_diameter = x),
        false,
    ),
    (
        (Quantity::InnerGrooveFactor, |d, x| {
            d.inner_groove_factor = x
        }),
        false,
    ),
    (
        (Quantity::OuterGrooveFactor, |d, x| {
            d.outer_groove_factor = x
        }),
        false,
    ),
    (
        (Quantity::ContactAngle, |d, x| {
            d.free_contact = FreeContact::Angle(x)
        }),
        true,
    ),
    (
        (Quantity::DiametralClearance, |d, x| {
            d.free_contact = FreeContact::DiametralClearance(x);
        }),
        true,
    ),
    (
        (Quantity::InnerShoulderAngle, |d, x| {
            d.inner_shoulder_angle = x
        }),
        false,
    ),
    (
        (Quantity::OuterShoulderAngle, |d, x| {
            d.outer_shoulder_angle = x
        }),
        false,
    ),
    ((Quantity::FirstBall, |d, x| d.first_ball = x), true),
    (
        (Quantity::RingYoungsModulus, |d, x| {
            d.ring.youngs_modulus = x
        }),
        false,
    ),
    (
        (Quantity::RingPoissonsRatio, |d, x| {
            d.ring.poissons_ratio = x
        }),
        true,
    ),
    (
        (Quantity::BallYoungsModulus, |d, x| {
            d.ball.youngs_modulus = x
        }),
        false,
    ),
    (
        (Quantity::BallPoissonsRatio, |d, x| {
            d.ball.poissons_ratio = x
        }),
        true,
    ),
    ((Quantity::BallDensity, |d, x| d.ball.density = x), false),
];

#[test]
fn a_design_with_a_number_that_is_none_is_refused_by_its_name() {
    for ((quantity, set), _) in FIELDS {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = refusal(|design| set(design, bad));
            assert_eq!(error.quantity, quantity, "{bad}: {error}");
            assert!(!error.value.is_finite(), "{error}");
        }
    }
}

#[test]
fn a_design_with_a_zero_is_refused_where_it_means_nothing() {
    for ((quantity, set), may_be_zero) in FIELDS {
        let mut design = B7005C;
        set(&mut design, 0.0);
        match Bearing::<f64, 16>::new(&design) {
            Ok(_) => assert!(may_be_zero, "{quantity} = 0 was accepted"),
            Err(error) => {
                assert!(!may_be_zero, "{error}");
                assert_eq!(error.quantity, quantity, "{error}");
                assert_eq!(error.value, 0.0);
            }
        }
    }
}

#[test]
fn a_clearance_that_presses_the_balls_too_far_is_refused() {
    let error = refusal(|d| d.free_contact = FreeContact::DiametralClearance(-5e-4));
    assert_eq!(error.quantity, Quantity::DiametralClearance);
    assert_eq!(error.value, -5e-4);
    let message = error.to_string();
    assert!(
        message.contains("clearance") && message.contains("-0.0005"),
        "{message}"
    );
}

#[test]
fn lengths_in_millimetres_are_told_to_be_metres() {
    let error = refusal(|d| (d.ball_diameter, d.pitch_diameter) = (6.35, 36.0));
    assert_eq!(error.quantity, Quantity::BallDiameter);
    assert!(error.to_string().contains("metres"), "{error}");
    assert!(error.reason().contains("metres"), "{}", error.reason());
}

#[test]
fn a_clearance_beyond_the_grooves_is_refused() {
    let error = refusal(|d| {
        d.free_contact = FreeContact::DiametralClearance(2.0 * d.centre_distance());
    });
    assert_eq!(error.quantity, Quantity::DiametralClearance);
}

#[test]
fn balls_do_not_overlap() {
    // Sixteen balls touch at D = dm sin(pi / 16).
    let touching = B7005C.pitch_diameter * (PI / 16.0).sin();
    let error = refusal(|d| d.ball_diameter = 1.001 * touching);
    assert_eq!(error.quantity, Quantity::BallDiameter);
    assert!((error.most / touching - 1.0).abs() < 1e-12, "{error}");
    let just_so = Design {
        ball_diameter: 0.999 * touching,
        ..B7005C
    };
    assert!(Bearing::<f64, 16>::new(&just_so).is_ok());
}

#[test]
fn a_groove_no_wider_than_the_ball_is_refused() {
    for factor in [0.5, 0.49, 0.0, -0.52] {
        let error = refusal(|d| d.inner_groove_factor = factor);
        assert_eq!(error.quantity, Quantity::InnerGrooveFactor);
        assert_eq!(error.value, factor);
        let error = refusal(|d| d.outer_groove_factor = factor);
        assert_eq!(error.quantity, Quantity::OuterGrooveFactor);
        assert_eq!(error.value, factor);
    }
}

#[test]
fn a_shoulder_below_the_unloaded_balls_or_in_degrees_is_refused() {
    let FreeContact::Angle(free) = B7005C.free_contact else {
        unreachable!()
    };
    for angle in [0.99 * free, -free, 1.01 * Design::HIGHEST_SHOULDER, 48.0] {
        let error = refusal(|d| d.inner_shoulder_angle = angle);
        assert_eq!(error.quantity, Quantity::InnerShoulderAngle);
        let error = refusal(|d| d.outer_shoulder_angle = angle);
        assert_eq!(error.quantity, Quantity::OuterShoulderAngle);
        assert_eq!((error.value, error.least), (angle, free));
    }
}

#[test]
fn two_balls_are_no_bearing() {
    let error = Bearing::<f64, 2>::new(&B7005C).unwrap_err();
    assert_eq!(error.quantity, Quantity::BallCount);
    assert_eq!((error.value, error.least), (2.0, 3.0));
}
