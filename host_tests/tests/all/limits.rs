//! The limits that a solution reports, held against what its balls say and against Hertz.

use host_tests::campaign::balance::friction;
use host_tests::cases::{B218, B7005C, Random, SKF6205, rad_per_s};
use host_tests::dispatch::Attitude;
use spindle_bearing::{
    BallState, Design, Exceedances, FreeContact, HertzContact, InnerRaceControl, Limit, Limits,
    Material, OuterRaceControl, Race, Real,
};
use spindle_bearing::{Bearing, Centrifugal, Full, Motion, Settings, Solver, Speed, Static};
use std::cell::Cell;

type Outer = Full<OuterRaceControl>;
type Inner = Full<InnerRaceControl>;

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
) -> Option<(Exceedances<T>, Vec<BallState<T>>)> {
    let bearing = Bearing::<T, 16>::build(design).unwrap();
    let mut solver = Solver::<T, 16, M>::of(&bearing);
    let limits = Limits {
        peak_pressure: T::of(limits.peak_pressure),
        friction: T::of(limits.friction),
    };
    let speed = Speed::rad_per_s(T::of(omega));
    let solution = solver
        .solve(load.map(T::of), speed, &Settings::default())
        .ok()?;
    Some((solution.exceedances(&limits), solution.balls().collect()))
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

type Seen = (Exceedances<f64>, Vec<BallState<f64>>);
type Solve<'s> = &'s dyn Fn(&Design, Scene, &Limits<f64>) -> Option<Seen>;

fn for_every_motion(check: &dyn Fn(Solve<'_>)) {
    check(&|d, s, l| solve::<f64, Static>(d, s, l));
    check(&|d, s, l| solve::<f64, Centrifugal>(d, s, l));
    check(&|d, s, l| solve::<f64, Full>(d, s, l));
    check(&|d, s, l| solve::<f64, Outer>(d, s, l));
    check(&|d, s, l| solve::<f64, Inner>(d, s, l));
}

#[test]
fn peak_pressure_is_that_of_hertz() {
    for_every_motion(&|solve| {
        for design in [B7005C, HYBRID, B218] {
            for scene in scenes(1, 60) {
                let Some((passed, balls)) = solve(&design, scene, &NOTHING) else {
                    continue;
                };
                let found = passed.get(Limit::PeakPressure).unwrap();
                let hertz = |(race, _, q, _)| (race, groove(&design, race).1.peak_pressure(q));
                let pressures = |ball: &BallState<f64>| contacts(ball).map(hertz);
                let largest = balls
                    .iter()
                    .flat_map(pressures)
                    .map(|(_, p)| p)
                    .fold(0.0, f64::max);
                assert!(close(found.value, largest, 1e-11), "{scene:?}: {found}");
                let [inner, outer] = pressures(&balls[usize::from(found.ball)]);
                let named = if found.race == Race::Inner {
                    inner
                } else {
                    outer
                };
                assert!(close(found.value, named.1, 1e-11));
                let loaded = balls.iter().filter(|b| b.q_i > 0.0 || b.q_o > 0.0);
                assert_eq!(usize::from(found.balls), loaded.count());
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
        (Attitude::Raceless, solve::<f64, Full>),
        (Attitude::Outer, solve::<f64, Outer>),
        (Attitude::Inner, solve::<f64, Inner>),
    ] {
        for design in [B7005C, HYBRID, B218] {
            for scene in scenes(2, 80) {
                let Some((passed, balls)) = solve(&design, scene, &NOTHING) else {
                    continue;
                };
                let demand = |b: &BallState<f64>| {
                    let [ti, to] = friction(b, motion, design.ball_diameter).map(f64::abs);
                    let ratio = |t: f64, q: f64| if q > 0.0 { t / q } else { 0.0 };
                    ratio(ti, b.q_i).max(ratio(to, b.q_o))
                };
                let largest = balls.iter().map(demand).fold(0.0, f64::max);
                match passed.get(Limit::Friction) {
                    Some(found) => {
                        assert!(close(found.value, largest, 1e-11), "{scene:?}: {found}");
                        assert!(scene.1 > 0.0 && largest > 0.0);
                        let count = balls.iter().filter(|b| demand(b) > 0.0).count();
                        assert_eq!(usize::from(found.balls), count);
                    }
                    None => assert_eq!(largest, 0.0),
                }
            }
        }
    }
}

/// Steeper than the shoulder by so much: a deep groove bearing has one on either side.
fn past_shoulder(design: &Design, race: Race, alpha: f64) -> f64 {
    let side = match design.free_contact {
        FreeContact::Angle(_) => alpha,
        FreeContact::DiametralClearance(_) => alpha.abs(),
    };
    side - shoulder(design, race)
}

#[test]
fn extremes_are_those_of_the_balls_and_of_limits_that_everything_passes() {
    let deep_groove = Design {
        free_contact: FreeContact::DiametralClearance(2e-5),
        ..B7005C
    };
    let mut compared = 0;
    for (seed, design) in (0..).zip([B7005C, HYBRID, deep_groove, B218]) {
        let bearing = Bearing::<f64, 16>::new(&design).unwrap();
        let mut solver = Solver::new(&bearing);
        for (load, omega) in scenes(seed, 60) {
            solver.reset();
            let speed = Speed::rad_per_s(omega);
            let Ok(solution) = solver.solve(load, speed, &Settings::default()) else {
                continue;
            };
            let extremes = solution.extremes();
            let passed = solution.exceedances(&NOTHING);
            for (extreme, limit) in [
                (extremes.pressure, Limit::PeakPressure),
                (extremes.friction, Limit::Friction),
            ] {
                let passed = passed.get(limit).map(|e| (e.value, e.ball, e.race));
                let extreme = extreme.filter(|e| e.value > 0.0);
                assert_eq!(extreme.map(|e| (e.value, e.ball, e.race)), passed);
            }
            let balls: Vec<_> = solution.balls().collect();
            let is_off = |ball: &BallState<f64>| ball.q_i <= 0.0;
            let (off, worst) = extremes.off;
            assert_eq!(usize::from(off), balls.iter().filter(|b| is_off(b)).count());
            assert!(worst.is_none_or(|ball| is_off(&balls[usize::from(ball)])));
            let pressed = balls
                .iter()
                .flat_map(contacts)
                .filter(|contact| contact.2 > 0.0);
            let past = pressed.map(|(race, alpha, ..)| past_shoulder(&design, race, alpha));
            if let Some(nearest) = extremes.shoulder {
                let most = past.fold(f64::NEG_INFINITY, f64::max);
                assert!((nearest.value - most).abs() < 1e-12, "{nearest:?} {most}");
                compared += 1;
            }
        }
    }
    assert!(compared > 150, "{compared}");
}

/// Balls past a limit, by how much each pressed contact is past it; `None` if one is too near the limit to tell.
fn count(
    balls: &[BallState<f64>],
    past: impl Fn(&BallState<f64>, Race, f64, f64) -> f64,
) -> Option<usize> {
    let mut count = 0;
    for ball in balls {
        let pressed = contacts(ball).into_iter().filter(|contact| contact.2 > 0.0);
        let excess: Vec<f64> = pressed
            .map(|(race, alpha, q, _)| past(ball, race, alpha, q))
            .collect();
        if excess.iter().any(|excess| excess.abs() < 1e-9) {
            return None;
        }
        count += usize::from(excess.iter().any(|excess| *excess > 0.0));
    }
    Some(count)
}

fn balls_past(found: &Exceedances<f64>, limit: Limit) -> usize {
    found.get(limit).map_or(0, |e| usize::from(e.balls))
}

#[test]
fn shoulders_are_passed_where_the_contact_angles_say() {
    let mut r = Random::seeded(4);
    let mut seen = [0; 3];
    for base in [B7005C, B218, SKF6205] {
        let symmetric = matches!(base.free_contact, FreeContact::DiametralClearance(_));
        let free = match base.free_contact {
            FreeContact::Angle(angle) => angle,
            FreeContact::DiametralClearance(_) => 0.0,
        };
        // Ball count is that of the others: the SKF6205 has room for 9 only.
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
            let Some((passed, balls)) = solve::<f64, Full>(&design, scene, &NOTHING) else {
                continue;
            };
            let half_width = |race, q: f64| {
                let (radius, hertz) = groove(&design, race);
                (hertz.semi_major * q.cbrt() / radius).min(1.0).asin()
            };
            let past = |race, alpha| past_shoulder(&design, race, alpha);
            let reversed = |alpha: f64| if symmetric { -alpha.abs() } else { -alpha };
            let expected = [
                count(&balls, |_, race, alpha, _| past(race, alpha)),
                count(&balls, |_, race, alpha, q| {
                    past(race, alpha) + half_width(race, q)
                }),
                count(&balls, |b, _, alpha, _| match b.q_i > 0.0 {
                    true => reversed(alpha),
                    false => -1.0,
                }),
            ];
            let limits = [Limit::Shoulder, Limit::Truncation, Limit::Reversal];
            for (i, limit) in limits.into_iter().enumerate() {
                let Some(expected) = expected[i] else {
                    continue;
                };
                assert_eq!(balls_past(&passed, limit), expected, "{limit} {scene:?}");
                seen[i] += usize::from(expected > 0);
                if let Some(e) = passed.get(limit) {
                    let [inner, outer] = contacts(&balls[usize::from(e.ball)]);
                    let (_, alpha, q, _) = if e.race == Race::Inner { inner } else { outer };
                    let side = if symmetric { alpha.signum() } else { 1.0 };
                    let edge = side * shoulder(&design, e.race);
                    let (value, allowed) = match limit {
                        Limit::Truncation => (alpha + side * half_width(e.race, q), edge),
                        Limit::Shoulder => (alpha, edge),
                        _ => (alpha, 0.0),
                    };
                    assert!((e.value - value).abs() < 1e-12, "{e} {value}");
                    assert_eq!(e.allowed, allowed);
                }
            }
            assert!(balls_past(&passed, Limit::Shoulder) <= balls_past(&passed, Limit::Truncation));
            assert!(!symmetric || passed.get(Limit::Reversal).is_none());
        }
    }
    assert!(seen.iter().all(|&n| n > 30), "{seen:?}");
}

#[test]
fn lost_contacts_are_those_without_a_force() {
    let some = Cell::new(0);
    for_every_motion(&|solve| {
        for scene in scenes(6, 100) {
            let Some((passed, balls)) = solve(&B7005C, scene, &NOTHING) else {
                continue;
            };
            let lost = || balls.iter().filter(|b| b.q_i <= 0.0);
            let count = balls_past(&passed, Limit::InnerContact);
            assert_eq!(count, lost().count(), "{scene:?}");
            if let Some(e) = passed.get(Limit::InnerContact) {
                some.set(some.get() + 1);
                let ball = &balls[usize::from(e.ball)];
                assert!(ball.q_i == 0.0 && e.race == Race::Inner);
                let gap = |b: &BallState<f64>| (-(b.delta_i + b.delta_o.min(0.0))).max(0.0);
                assert!(close(e.value, gap(ball), 1e-12));
                assert!(close(e.value, lost().map(gap).fold(0.0, f64::max), 1e-12));
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
        let nought = solve::<f64, Full>(&design, (load, 0.0), &Limits::default());
        if let (Some((rest, _)), Some((nought, _))) = (rest, nought) {
            let [a, b] = [rest, nought].map(|passed| {
                passed
                    .iter()
                    .map(|e| (e.limit, e.balls))
                    .collect::<Vec<_>>()
            });
            assert_eq!(a, b, "{load:?}");
        }
    }
}

#[test]
fn a_pull_reverses_an_angular_contact_bearing_and_not_a_deep_groove_one() {
    let pull = ([-400.0, 0.0, 0.0, 0.0, 0.0], rad_per_s(3000.0));
    let (passed, _) = solve::<f64, Full>(&B7005C, pull, &Limits::default()).unwrap();
    let e = passed.get(Limit::Reversal).unwrap();
    assert_eq!(e.balls, 16);
    assert!(e.value < 0.0 && e.allowed == 0.0);
    assert_eq!(passed.get(Limit::Shoulder), None);

    // A deep groove bearing passes its other shoulder as it would the one.
    let deep = Design {
        free_contact: FreeContact::DiametralClearance(10e-6),
        inner_shoulder_angle: 0.2,
        outer_shoulder_angle: 0.2,
        ..B7005C
    };
    let push = (pull.0.map(|f| -f), pull.1);
    let (pulled, _) = solve::<f64, Full>(&deep, pull, &Limits::default()).unwrap();
    let (pushed, _) = solve::<f64, Full>(&deep, push, &Limits::default()).unwrap();
    assert_eq!(pulled.limits(), pushed.limits());
    assert!(!pulled.limits().contains(Limit::Reversal));
    for limit in [Limit::Shoulder, Limit::Truncation] {
        let (a, b) = (pulled.get(limit).unwrap(), pushed.get(limit).unwrap());
        assert!(close(a.value, -b.value, 1e-9) && a.allowed == -b.allowed);
    }
}
