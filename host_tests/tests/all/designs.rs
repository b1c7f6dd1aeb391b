//! Designs that cannot be built, and their errors.

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

/// A number of a design, and whether it may be zero.
type Field = (Quantity, bool, fn(&mut Design, f64));

/// Every number of a design.
#[rustfmt::skip]
const FIELDS: [Field; 14] = [
    (Quantity::BallDiameter, false, |d, x| d.ball_diameter = x),
    (Quantity::PitchDiameter, false, |d, x| d.pitch_diameter = x),
    (Quantity::InnerGrooveFactor, false, |d, x| d.inner_groove_factor = x),
    (Quantity::OuterGrooveFactor, false, |d, x| d.outer_groove_factor = x),
    (Quantity::ContactAngle, true, |d, x| d.free_contact = FreeContact::Angle(x)),
    (Quantity::DiametralClearance, true, |d, x| d.free_contact = FreeContact::DiametralClearance(x)),
    (Quantity::InnerShoulderAngle, false, |d, x| d.inner_shoulder_angle = x),
    (Quantity::OuterShoulderAngle, false, |d, x| d.outer_shoulder_angle = x),
    (Quantity::FirstBall, true, |d, x| d.first_ball = x),
    (Quantity::RingYoungsModulus, false, |d, x| d.ring.youngs_modulus = x),
    (Quantity::RingPoissonsRatio, true, |d, x| d.ring.poissons_ratio = x),
    (Quantity::BallYoungsModulus, false, |d, x| d.ball.youngs_modulus = x),
    (Quantity::BallPoissonsRatio, true, |d, x| d.ball.poissons_ratio = x),
    (Quantity::BallDensity, false, |d, x| d.ball.density = x),
];

#[test]
fn a_number_of_a_design_that_is_none_or_a_zero_that_means_nothing_is_refused_by_its_name() {
    for (quantity, may_be_zero, set) in FIELDS {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = refusal(|design| set(design, bad));
            assert_eq!(error.quantity, quantity, "{bad}: {error}");
            assert!(!error.value.is_finite(), "{error}");
        }
        if may_be_zero {
            let mut design = B7005C;
            set(&mut design, 0.0);
            assert!(Bearing::<f64, 16>::new(&design).is_ok(), "{quantity}");
        } else {
            let error = refusal(|design| set(design, 0.0));
            assert_eq!((error.quantity, error.value), (quantity, 0.0), "{error}");
        }
    }
}

#[test]
fn a_clearance_that_presses_the_balls_too_far_or_is_beyond_the_grooves_is_refused() {
    for clearance in [-5e-4, 2.0 * B7005C.centre_distance()] {
        let error = refusal(|d| d.free_contact = FreeContact::DiametralClearance(clearance));
        let expected = (Quantity::DiametralClearance, clearance);
        assert_eq!((error.quantity, error.value), expected);
        let told = error.to_string();
        assert!(told.contains("clearance"), "{told}");
        assert!(told.contains(&clearance.to_string()), "{told}");
    }
}

#[test]
fn lengths_in_millimetres_are_told_to_be_metres() {
    let error = refusal(|d| (d.ball_diameter, d.pitch_diameter) = (6.35, 36.0));
    assert_eq!(error.quantity, Quantity::BallDiameter);
    assert!(error.to_string().contains("metres"), "{error}");
    assert!(error.reason().contains("metres"), "{}", error.reason());
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
        assert_eq!(
            (error.quantity, error.value),
            (Quantity::InnerGrooveFactor, factor)
        );
        let error = refusal(|d| d.outer_groove_factor = factor);
        assert_eq!(
            (error.quantity, error.value),
            (Quantity::OuterGrooveFactor, factor)
        );
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
