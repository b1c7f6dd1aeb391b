//! The limits that a solution reports, held against what its balls say and against Hertz.

use host_tests::cases::{B218, B7005C, Random, SKF6205, rad_per_s};
use spindle_bearing::{
    BallState, Design, Exceedance, Exceedances, FreeContact, HertzContact, InnerRaceControl, Limit,
    Limits, Material, OuterRaceControl, Race, Real,
};
use spindle_bearing::{Bearing, Centrifugal, Full, Motion, Settings, Solver, Speed, Static};

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
        let mut part = |share: f64| {
            if r.chance(0.6) {
                size * r.between(-share, share)
            } else {
                0.0
            }
        };
        let load = [0.0, part(1.0), part(1.0), part(0.01), part(0.01)];
        let axial = size * r.between(-0.5, 1.0);
        let omega = if r.chance(0.2) {
            0.0
        } else {
            rad_per_s(r.between(0.0, 40_000.0))
        };
        ([axial, load[1], load[2], load[3], load[4]], omega)
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

// ---------------------------------------------------------------------------------------------
// Values

#[test]
fn peak_pressure_is_that_of_hertz() {
    for_every_motion(&|solve| {
        for design in [B7005C, HYBRID, B218] {
            for scene in scenes(1, 60) {
                let Some((passed, balls)) = solve(&design, scene, &NOTHING) else {
                    continue;
                };
                let found = passed.get(Limit::PeakPressure).unwrap();
                let pressure = |race, q: f64| groove(&design, race).1.peak_pressure(q);
                let largest = balls
                    .iter()
                    .flat_map(contacts)
                    .map(|(race, _, q, _)| pressure(race, q))
                    .fold(0.0, f64::max);
                assert!(close(found.value, largest, 1e-11), "{scene:?}: {found}");
                let (_, _, q, _) = contacts(&balls[usize::from(found.ball)])
                    .into_iter()
                    .find(|contact| contact.0 == found.race)
                    .unwrap();
                assert!(close(found.value, pressure(found.race, q), 1e-11));
                let loaded = balls.iter().filter(|b| b.q_i > 0.0 || b.q_o > 0.0);
                assert_eq!(usize::from(found.balls), loaded.count());
            }
        }
    });
}

#[test]
fn friction_demand_is_the_models_share_of_the_gyroscopic_moment() {
    type Shares = fn(&BallState<f64>) -> [f64; 2];
    let free: Shares = |b| [b.q_i, b.q_o].map(|q| 2.0 * q / (b.q_i + b.q_o));
    let outer: Shares = |_| [0.0, 2.0];
    let inner: Shares = |b| {
        if b.q_i > 0.0 { [1.0, 1.0] } else { [0.0, 2.0] }
    };
    fn check<M: Motion>(shares: Shares) {
        for design in [B7005C, HYBRID, B218] {
            for scene in scenes(2, 80) {
                let Some((passed, balls)) = solve::<f64, M>(&design, scene, &NOTHING) else {
                    continue;
                };
                let demand = |b: &BallState<f64>| {
                    let t = shares(b).map(|s| s * b.gyroscopic_moment.abs() / design.ball_diameter);
                    let ratio = |t: f64, q: f64| if q > 0.0 { t / q } else { 0.0 };
                    ratio(t[0], b.q_i).max(ratio(t[1], b.q_o))
                };
                let largest = balls.iter().map(demand).fold(0.0, f64::max);
                match passed.get(Limit::Friction) {
                    Some(found) => {
                        assert!(close(found.value, largest, 1e-11), "{scene:?}: {found}");
                        assert!(scene.1 > 0.0);
                        let count = balls.iter().filter(|b| demand(b) > 0.0).count();
                        assert_eq!(usize::from(found.balls), count);
                    }
                    None => assert_eq!(largest, 0.0),
                }
            }
        }
    }
    check::<Full>(free);
    check::<Outer>(outer);
    check::<Inner>(inner);
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
            let off = balls.iter().filter(|ball| ball.q_i <= 0.0).count();
            assert_eq!(usize::from(extremes.off.0), off);
            assert!(
                extremes
                    .off
                    .1
                    .is_none_or(|ball| balls[usize::from(ball)].q_i <= 0.0)
            );
            let past = |(race, angle, force, _): (Race, f64, f64, f64)| {
                let angle = if matches!(design.free_contact, FreeContact::DiametralClearance(_)) {
                    angle.abs()
                } else {
                    angle
                };
                (force > 0.0).then(|| angle - shoulder(&design, race))
            };
            let most = balls.iter().flat_map(contacts).filter_map(past);
            let most = most.fold(f64::NEG_INFINITY, f64::max);
            if let Some(nearest) = extremes.shoulder {
                assert!((nearest.value - most).abs() < 1e-12, "{nearest:?} {most}");
                compared += 1;
            }
        }
    }
    assert!(compared > 150, "{compared}");
}

#[test]
fn a_bearing_at_rest_or_under_centrifugal_force_alone_calls_for_no_friction() {
    for (load, omega) in scenes(3, 40) {
        let at = (load, omega);
        let found = [
            solve::<f64, Static>(&B7005C, at, &NOTHING),
            solve::<f64, Centrifugal>(&B7005C, at, &NOTHING),
            solve::<f64, Full>(&B7005C, (load, 0.0), &NOTHING),
        ];
        for (passed, _) in found.into_iter().flatten() {
            assert_eq!(passed.get(Limit::Friction), None, "{load:?} at {omega}");
        }
    }
}

// ---------------------------------------------------------------------------------------------
// Places

/// Balls past a limit, judged by their angles; `None` if one is too near the limit to tell.
fn count(
    balls: &[BallState<f64>],
    mut past: impl FnMut(&BallState<f64>, Race, f64, f64) -> f64,
) -> Option<usize> {
    let mut count = 0;
    for ball in balls {
        let mut any = false;
        for (race, alpha, q, delta) in contacts(ball) {
            if q > 0.0 {
                let excess = past(ball, race, alpha, delta);
                if excess.abs() < 1e-9 {
                    return None;
                }
                any |= excess > 0.0;
            }
        }
        count += usize::from(any);
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
            let side = |alpha: f64| if symmetric { alpha.abs() } else { alpha };
            let past = |race, alpha| side(alpha) - shoulder(&design, race);
            let half_width = |race, q: f64| {
                let (radius, hertz) = groove(&design, race);
                (hertz.semi_major * q.cbrt() / radius).min(1.0).asin()
            };
            let q = |b: &BallState<f64>, race| if race == Race::Inner { b.q_i } else { b.q_o };

            let expected = [
                count(&balls, |_, race, alpha, _| past(race, alpha)),
                count(&balls, |b, race, alpha, _| {
                    past(race, alpha) + half_width(race, q(b, race))
                }),
                count(
                    &balls,
                    |b, _, alpha, _| {
                        if b.q_i > 0.0 { -side(alpha) } else { -1.0 }
                    },
                ),
            ];
            for (i, limit) in [Limit::Shoulder, Limit::Truncation, Limit::Reversal]
                .into_iter()
                .enumerate()
            {
                let Some(expected) = expected[i] else {
                    continue;
                };
                assert_eq!(balls_past(&passed, limit), expected, "{limit} {scene:?}");
                seen[i] += usize::from(expected > 0);
                if let Some(e) = passed.get(limit) {
                    let ball = &balls[usize::from(e.ball)];
                    let alpha = contacts(ball)
                        .into_iter()
                        .find(|contact| contact.0 == e.race)
                        .unwrap()
                        .1;
                    let other = if symmetric { alpha.signum() } else { 1.0 };
                    let (value, limit_angle) = match limit {
                        Limit::Truncation => (
                            alpha + other * half_width(e.race, q(ball, e.race)),
                            other * shoulder(&design, e.race),
                        ),
                        Limit::Shoulder => (alpha, other * shoulder(&design, e.race)),
                        _ => (alpha, 0.0),
                    };
                    assert!((e.value - value).abs() < 1e-12, "{e} {value}");
                    assert_eq!(e.allowed, limit_angle);
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
    let mut some = 0;
    for_every_motion(&|solve| {
        for scene in scenes(6, 100) {
            let Some((passed, balls)) = solve(&B7005C, scene, &NOTHING) else {
                continue;
            };
            let lost = balls.iter().filter(|b| b.q_i <= 0.0).count();
            assert_eq!(balls_past(&passed, Limit::InnerContact), lost, "{scene:?}");
            if let Some(e) = passed.get(Limit::InnerContact) {
                let ball = &balls[usize::from(e.ball)];
                assert!(ball.q_i == 0.0 && e.race == Race::Inner);
                let gap = |b: &BallState<f64>| (-(b.delta_i + b.delta_o.min(0.0))).max(0.0);
                let off = balls.iter().filter(|b| b.q_i <= 0.0);
                assert!(close(e.value, gap(ball), 1e-12));
                assert!(close(e.value, off.map(gap).fold(0.0, f64::max), 1e-12));
            }
        }
    });
    for scene in scenes(6, 100) {
        let lost = solve::<f64, Full>(&B7005C, scene, &NOTHING)
            .is_some_and(|(passed, _)| passed.get(Limit::InnerContact).is_some());
        some += usize::from(lost);
    }
    assert!(some > 20, "{some}");
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
            let short = |e: Exceedance<f64>| (e.limit, e.balls);
            let (a, b): (Vec<_>, Vec<_>) = (
                rest.iter().map(short).collect(),
                nought.iter().map(short).collect(),
            );
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
