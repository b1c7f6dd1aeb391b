//! Designs that cannot be built, and their errors.

use judge::cases::B7005C;
use spindle_bearing::{
    Bearing, Design, DesignError, Expansion, FreeContact, Growth, HertzContact, LifeRating,
    Material, Quantity, Section, Shaft, elliptic_integrals,
};
use std::f64::consts::PI;
use std::sync::mpsc::channel;
use std::time::Duration;

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

/// Numbers that a design does not expect: of either sign, of no value, and from the least to the largest.
fn odd_numbers() -> Vec<f64> {
    let sizes = [
        0.0,
        f64::from_bits(1),
        f64::MIN_POSITIVE,
        1e-300,
        1e-9,
        0.4999,
        0.5,
        f64::from_bits(0.5_f64.to_bits() + 1),
        1.0,
        1.5,
        PI,
        1e9,
        1e300,
        f64::MAX,
        f64::INFINITY,
        f64::NAN,
    ];
    sizes.into_iter().flat_map(|x| [x, -x]).collect()
}

/// Asks a design that need not be sound for all that is worked out of it.
fn ask_everything(design: &Design) {
    let is_sound = design.check(16).is_ok();
    assert_eq!(is_sound, Bearing::<f64, 16>::new(design).is_ok());
    assert_eq!(is_sound, Bearing::<f32, 16>::new(design).is_ok());
    for balls in [0, 1, 16, usize::MAX] {
        let c = design.dynamic_load_rating(balls);
        assert!(c.is_finite() && c >= 0.0, "{balls} {design:?}: {c}");
        assert!(c > 0.0 || balls == 0 || !is_sound, "{balls} {design:?}");
        for c in [c, 0.0, -1.0, f64::NAN, 14e3] {
            let rating = LifeRating::<f64>::new(design, balls, c);
            let both = [rating.inner, rating.outer];
            assert!(
                both.iter().all(|q| *q >= 0.0),
                "{balls} {design:?} {both:?}"
            );
            let rated = c > 0.0 && balls > 0 && is_sound;
            assert!(!rated || both.iter().all(|q| *q > 0.0 && q.is_finite()));
            for forces in [[0.0, 0.0], [0.0, 10.0], [1e5, 1e5], [1e200, 1e200]] {
                let weight = rating.weight_of([forces, [0.0; 2]].map(|[i, o]| (i, o)).into_iter());
                assert!(weight >= 0.0, "{design:?} {both:?} {forces:?}");
                // A contact that is rated for nothing lives for no time.
                let is_used_up = forces[1] > 0.0 && both == [0.0; 2];
                assert!(!is_used_up || weight == f64::INFINITY, "{design:?}");
            }
        }
    }
    let expansion = &Expansion::STEEL;
    let growths = [
        Growth::by_temperatures(design, expansion, 0.1, [1.0, 2.0]),
        Growth::by_rotation(design, 0.02, 1000.0),
        Growth::by_fit(design, 0.025, 0.01, 1e-5),
    ];
    let is_finite = |growth: &Growth<f64>| growth.radial.is_finite();
    assert!(!is_sound || growths[..1].iter().all(is_finite));
}

/// All that the compiler works out of a design ends, whatever that is: firmware builds with it.
#[test]
fn what_follows_from_a_design_ends_for_any_numbers() {
    let (done, end) = channel();
    std::thread::spawn(move || {
        let odd = odd_numbers();
        for (_, _, set) in FIELDS {
            for x in &odd {
                let mut design = B7005C;
                set(&mut design, *x);
                ask_everything(&design);
                for (_, _, set) in FIELDS {
                    let mut worse = design;
                    set(&mut worse, odd[(x.to_bits() >> 52) as usize % odd.len()]);
                    ask_everything(&worse);
                }
            }
        }
        for x in &odd {
            elliptic_integrals(*x);
            for y in &odd {
                for (rolling, across) in [(*x, *y), (*x, 100.0), (300.0, *y)] {
                    HertzContact::new(rolling, across, 1e-11).peak_pressure(*x);
                }
                let section = Section {
                    from: *x,
                    to: *y,
                    outer: 0.03,
                    inner: *x,
                };
                let material = Material {
                    poissons_ratio: *y,
                    ..Material::STEEL
                };
                let _ = Shaft::<f64, 1>::new(&[section], &material);
            }
        }
        done.send(()).unwrap();
    });
    let ended = end.recv_timeout(Duration::from_secs(60));
    assert!(ended.is_ok(), "no end within a minute: {ended:?}");
}
