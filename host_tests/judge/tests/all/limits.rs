//! The margins that a solution reports, held against what its balls say and against Hertz.

use cli::random::Random;
use judge::campaign::balance::friction;
use judge::cases::{B218, B7005C, SKF6205, rad_per_s};
use solvers::dispatch::Attitude;
use spindle_bearing::{
    BallState, Bearing, Design, FreeContact, HertzContact, InnerRaceControl, Limit, Limits,
    Margins, Material, OuterRaceControl, Race, Real,
};
use spindle_bearing::{Centrifugal, Motion, RacewayControlFree, Settings, Solver, Speed, Static};
use spindle_file::plan::MOST_BALLS;
use std::cell::Cell;
use std::f64::consts::FRAC_PI_2;

type Outer = OuterRaceControl;
type Inner = InnerRaceControl;

/// Limits that everything passes.
pub const NOTHING: Limits<f64> = Limits {
    peak_pressure: 0.0,
    friction: 0.0,
};

const HYBRID: Design = Design {
    ball: Material::SILICON_NITRIDE,
    ..B7005C
};

/// A load and a speed, rad/s.
pub type Scene = ([f64; 5], f64);

/// Solves from nothing; `None` if there is no equilibrium.
pub fn solve<T: Real, M: Motion>(
    design: &Design,
    (load, omega): Scene,
    limits: &Limits<f64>,
) -> Option<(Margins<T>, Vec<BallState<T>>)> {
    let bearing = Bearing::<T, MOST_BALLS>::with_balls(design, 16).unwrap();
    let mut solver = Solver::<T, MOST_BALLS, M>::of();
    let limits = Limits {
        peak_pressure: T::of(limits.peak_pressure),
        friction: T::of(limits.friction),
    };
    let speed = Speed::rad_per_s(T::of(omega));
    let solution = solver
        .solve(&bearing, load.map(T::of), speed, &Settings::default())
        .ok()?;
    Some((solution.margins(&limits), solution.balls().collect()))
}

/// Loads of every kind, from next to nothing to the static rating of the small bearings, at rest and
/// at speed.
pub fn scenes(seed: u64, count: usize) -> Vec<Scene> {
    let mut r = Random::seeded(seed);
    let scene = |_| {
        let size = 10f64.powf(r.between(0.5, 4.0));
        let mut part = |share: f64| match r.chance(0.6) {
            true => size * r.between(-share, share),
            false => 0.0,
        };
        let [fy, fz, my, mz] = [1.0, 1.0, 0.01, 0.01].map(&mut part);
        let axial = size * r.between(-0.5, 1.0);
        let omega = match r.chance(0.2) {
            true => 0.0,
            false => rad_per_s(r.between(0.0, 40_000.0)),
        };
        ([axial, fy, fz, my, mz], omega)
    };
    (0..count).map(scene).collect()
}

pub fn contacts(ball: &BallState<f64>) -> [(Race, f64, f64, f64); 2] {
    [
        (Race::Inner, ball.alpha_i, ball.q_i, ball.delta_i),
        (Race::Outer, ball.alpha_o, ball.q_o, ball.delta_o),
    ]
}

/// Groove radius and Hertzian contact of a race, from the design alone.
pub fn groove(design: &Design, race: Race) -> (f64, HertzContact) {
    let (d, dm) = (design.ball_diameter, design.pitch_diameter);
    let cos0 = match design.free_contact {
        FreeContact::Angle(angle) => angle.cos(),
        FreeContact::DiametralClearance(pd) => 1.0 - pd / (2.0 * design.centre_distance()),
    };
    let gamma = d * cos0 / dm;
    let (factor, gamma) = match race {
        Race::Inner => (design.inner_groove_factor, gamma),
        Race::Outer => (design.outer_groove_factor, -gamma),
    };
    let compliance = |m: &Material| (1.0 - m.poissons_ratio * m.poissons_ratio) / m.youngs_modulus;
    // Ball and race across and along the groove: 2/D and 2/(dm/cos0 -+ D), 2/D and -1/(f D).
    let hertz = HertzContact::new(
        4.0 / d + 2.0 * gamma / (d * (1.0 - gamma)) - 2.0 / d,
        4.0 / d - 1.0 / (factor * d) - 2.0 / d,
        compliance(&design.ring) + compliance(&design.ball),
    );
    (factor * d, hertz)
}

pub fn shoulder(design: &Design, race: Race) -> f64 {
    match race {
        Race::Inner => design.inner_shoulder_angle,
        Race::Outer => design.outer_shoulder_angle,
    }
}

pub fn close(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * a.abs().max(b.abs())
}

type Seen = (Margins<f64>, Vec<BallState<f64>>);
type Solve<'s> = &'s dyn Fn(&Design, Scene, &Limits<f64>) -> Option<Seen>;

fn for_every_motion(check: &dyn Fn(Solve<'_>)) {
    check(&|d, s, l| solve::<f64, Static>(d, s, l));
    check(&|d, s, l| solve::<f64, Centrifugal>(d, s, l));
    check(&|d, s, l| solve::<f64, RacewayControlFree>(d, s, l));
    check(&|d, s, l| solve::<f64, Outer>(d, s, l));
    check(&|d, s, l| solve::<f64, Inner>(d, s, l));
}

/// Largest value of the contacts that carry, `NONE` if there is none. The margin has it, and so has the contact that it
/// names.
fn worst(
    (margins, balls): &Seen,
    limit: Limit,
    near: impl Fn(f64, f64) -> bool,
    value: impl Fn(&BallState<f64>, Race, f64, f64) -> f64,
) -> f64 {
    let values = |ball: &BallState<f64>| {
        contacts(ball).map(|(race, alpha, q, _)| match q > 0.0 {
            true => value(ball, race, alpha, q),
            false => NONE,
        })
    };
    let most = balls.iter().flat_map(values).fold(NONE, f64::max);
    match margins.get(limit) {
        None => assert_eq!(most, NONE, "{limit:?}"),
        Some(found) => {
            let named = values(&balls[usize::from(found.ball)])[found.race as usize];
            assert!(near(found.value, most), "{found:?} {most}");
            assert!(near(found.value, named), "{found:?} {named}");
        }
    }
    most
}

const NONE: f64 = f64::NEG_INFINITY;

#[test]
fn peak_pressure_is_that_of_hertz() {
    for_every_motion(&|solve| {
        for design in [B7005C, HYBRID, B218] {
            for scene in scenes(1, 60) {
                let Some(seen) = solve(&design, scene, &NOTHING) else {
                    continue;
                };
                let near = |a, b| close(a, b, 1e-11);
                worst(&seen, Limit::PeakPressure, near, |_, race, _, q| {
                    groove(&design, race).1.peak_pressure(q)
                });
                assert!(seen.0.passed().contains(Limit::PeakPressure));
            }
        }
    });
}

#[test]
fn friction_demand_is_the_models_share_of_the_gyroscopic_moment() {
    for (motion, solve) in [
        // Without a gyroscopic moment, nothing calls for friction.
        (Attitude::Outer, solve::<f64, Static> as fn(&_, _, &_) -> _),
        (Attitude::Raceless, solve::<f64, Centrifugal>),
        (Attitude::Raceless, solve::<f64, RacewayControlFree>),
        (Attitude::Outer, solve::<f64, Outer>),
        (Attitude::Inner, solve::<f64, Inner>),
    ] {
        for design in [B7005C, HYBRID, B218] {
            for scene in scenes(2, 80) {
                let Some(seen) = solve(&design, scene, &NOTHING) else {
                    continue;
                };
                let near = |a, b| close(a, b, 1e-11);
                let largest = worst(&seen, Limit::Friction, near, |b, race, _, q| {
                    friction(b, motion, design.ball_diameter)[race as usize].abs() / q
                });
                assert_eq!(seen.0.passed().contains(Limit::Friction), largest > 0.0);
                assert!(largest == 0.0 || scene.1 > 0.0);
            }
        }
    }
}

#[test]
fn shoulders_are_passed_where_the_contact_angles_say() {
    let mut r = Random::seeded(4);
    let mut seen = [0; 3];
    for base in [B7005C, HYBRID, B218, SKF6205] {
        let symmetric = matches!(base.free_contact, FreeContact::DiametralClearance(_));
        let free = match base.free_contact {
            FreeContact::Angle(angle) => angle,
            FreeContact::DiametralClearance(_) => 0.0,
        };
        // Ball count as for the others: the SKF6205 has room for 9 only.
        let base = Design {
            pitch_diameter: base.pitch_diameter.max(6.0 * base.ball_diameter),
            ..base
        };
        for scene in scenes(5, 150) {
            let design = Design {
                inner_shoulder_angle: r.between(free, Design::HIGHEST_SHOULDER.min(free + 0.5)),
                outer_shoulder_angle: r.between(free, Design::HIGHEST_SHOULDER.min(free + 0.5)),
                ..base
            };
            let Some(found) = solve::<f64, RacewayControlFree>(&design, scene, &NOTHING) else {
                continue;
            };
            // Steeper than the shoulder by so much; farther than a quarter turn on the other side counts for nothing.
            let past = |race, alpha: f64| {
                let side = if symmetric { alpha.abs() } else { alpha };
                let past = side - shoulder(&design, race);
                let counts = side > 0.0 || past > -FRAC_PI_2;
                if counts { past } else { NONE }
            };
            let half_axis = |race, q: f64| {
                let (radius, hertz) = groove(&design, race);
                (hertz.semi_major * q.cbrt(), radius)
            };
            let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
            let steepest = worst(&found, Limit::Shoulder, near, |_, race, alpha, _| {
                past(race, alpha)
            });
            let near_length = |a: f64, b: f64| (a - b).abs() < 1e-14;
            worst(
                &found,
                Limit::Truncation,
                near_length,
                |_, race, alpha, q| {
                    let (half, radius) = half_axis(race, q);
                    match past(race, alpha) {
                        past if past > FRAC_PI_2 => half + radius * (2.0 - past.sin()),
                        past if past > NONE => half + radius * past.sin(),
                        _ => NONE,
                    }
                },
            );
            let ends = found.1.iter().flat_map(contacts).filter(|k| k.2 > 0.0);
            let ends = ends.map(|(race, alpha, q, _)| {
                let (half, radius) = half_axis(race, q);
                past(race, alpha) + (half / radius).min(1.0).asin()
            });
            let farthest = ends.fold(NONE, f64::max);
            let reversed = worst(&found, Limit::Reversal, near, |ball, _, alpha, _| {
                let reversed = !symmetric && ball.q_i > 0.0 && alpha < -64.0 * f64::EPSILON;
                if reversed { -alpha.sin() } else { NONE }
            });
            for (i, (limit, value)) in [
                (Limit::Shoulder, steepest),
                (Limit::Truncation, farthest),
                (Limit::Reversal, reversed),
            ]
            .into_iter()
            .enumerate()
            {
                let passed = found.0.passed().contains(limit);
                // Too near the limit to tell.
                if value.abs() > 1e-9 {
                    assert_eq!(passed, value > 0.0, "{limit:?} {scene:?}");
                }
                seen[i] += usize::from(passed);
            }
            let [past, truncated] =
                [Limit::Shoulder, Limit::Truncation].map(|limit| found.0.passed().contains(limit));
            assert!(truncated || !past, "{scene:?}");
        }
    }
    assert!(seen.iter().all(|&n| n > 30), "{seen:?}");
}

#[test]
fn lost_contacts_are_those_without_a_force() {
    let some = Cell::new(0);
    for_every_motion(&|solve| {
        for scene in scenes(6, 100) {
            let Some((margins, balls)) = solve(&B7005C, scene, &NOTHING) else {
                continue;
            };
            let lost = || balls.iter().filter(|b| b.q_i <= 0.0);
            assert_eq!(usize::from(margins.unloaded), lost().count(), "{scene:?}");
            let passed = margins.passed().contains(Limit::InnerContact);
            assert_eq!(passed, margins.unloaded > 0);
            assert_eq!(passed, margins.get(Limit::InnerContact).is_some());
            if let Some(margin) = margins.get(Limit::InnerContact) {
                some.set(some.get() + 1);
                let ball = &balls[usize::from(margin.ball)];
                assert!(ball.q_i == 0.0 && margin.race == Race::Inner);
                let gap = |b: &BallState<f64>| (-(b.delta_i + b.delta_o.min(0.0))).max(0.0);
                assert!(close(margin.value, gap(ball), 1e-12));
                let largest = lost().map(gap).fold(0.0, f64::max);
                assert!(close(margin.value, largest, 1e-12));
            }
        }
    });
    assert!(some.get() > 100, "{some:?}");
}

#[test]
fn rest_and_speed_nought_pass_the_same_limits() {
    let design = Design {
        inner_shoulder_angle: 18f64.to_radians(),
        outer_shoulder_angle: 17f64.to_radians(),
        ..B7005C
    };
    for (load, _) in scenes(7, 60) {
        let rest = solve::<f64, Static>(&design, (load, 0.0), &Limits::default());
        let nought = solve::<f64, RacewayControlFree>(&design, (load, 0.0), &Limits::default());
        if let (Some((rest, _)), Some((nought, _))) = (rest, nought) {
            let [a, b] = [rest, nought].map(|margins| (margins.passed(), margins.unloaded));
            assert_eq!(a, b, "{load:?}");
        }
    }
}

#[test]
fn a_pull_reverses_an_angular_contact_bearing_and_not_a_deep_groove_one() {
    let pull = ([-400.0, 0.0, 0.0, 0.0, 0.0], rad_per_s(3000.0));
    let (margins, _) = solve::<f64, RacewayControlFree>(&B7005C, pull, &Limits::default()).unwrap();
    assert!(margins.passed().contains(Limit::Reversal));
    assert!(!margins.passed().contains(Limit::Shoulder));

    // A deep groove bearing passes its other shoulder as it would the one.
    let deep = Design {
        free_contact: FreeContact::DiametralClearance(10e-6),
        inner_shoulder_angle: 0.2,
        outer_shoulder_angle: 0.2,
        ..B7005C
    };
    let push = (pull.0.map(|f| -f), pull.1);
    let (pulled, _) = solve::<f64, RacewayControlFree>(&deep, pull, &Limits::default()).unwrap();
    let (pushed, _) = solve::<f64, RacewayControlFree>(&deep, push, &Limits::default()).unwrap();
    assert_eq!(pulled.passed(), pushed.passed());
    assert_eq!(pulled.get(Limit::Reversal), None);
    for limit in [Limit::Shoulder, Limit::Truncation] {
        let (a, b) = (pulled.get(limit).unwrap(), pushed.get(limit).unwrap());
        assert!(a.value > 0.0 && close(a.value, b.value, 1e-9));
    }
}
