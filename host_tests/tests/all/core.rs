//! The core that is to take the place of today's (`spindle_bearing::next`): solved cases, and laws.

use host_tests::campaign::families::{Family, Trial};
use host_tests::cases::{self, B218, B7005C, SKF6205, SolvedCase, rad_per_s};
use host_tests::compare::{Ball, Equilibrium, Errors};
use host_tests::dispatch::{Attitude, Precision};
use host_tests::tolerances::allowed_at;
use rayon::prelude::*;
use spindle_bearing::next::{
    Bearing, Centrifugal, Full, Given, Growth, Motion, Settings, Snapshot, Solver, Speed, Static,
};
use spindle_bearing::{
    BallState, Design, InnerRaceControl, OuterRaceControl, RacewayControlFree, Real, Status,
};
use std::array::from_fn;

/// Loads, or displacements, and all else that a bearing is solved at, in doubles.
#[derive(Debug, Clone, Copy)]
struct Question {
    given: [Given<f64>; 5],
    omega: f64,
    growth: Growth<f64>,
}

impl Question {
    fn load(load: [f64; 5], omega: f64) -> Self {
        Self {
            given: load.map(Given::Load),
            omega,
            growth: Growth::NONE,
        }
    }

    fn displacement(u: [f64; 5], omega: f64) -> Self {
        Self {
            given: u.map(Given::Displacement),
            ..Self::load(u, omega)
        }
    }
}

/// A solution in doubles.
#[derive(Debug, Clone, PartialEq)]
struct Found {
    u: [f64; 5],
    load: [f64; 5],
    k: [[f64; 5]; 5],
    balls: Vec<BallState<f64>>,
    /// Estimated errors of displacement, force and stiffness.
    estimate: [f64; 3],
}

impl Found {
    fn of<T: Real, const N: usize>(s: &Snapshot<T, N, 5>) -> Self {
        let wide = |b: &BallState<T>| BallState {
            azimuth: b.azimuth.to_f64(),
            alpha_i: b.alpha_i.to_f64(),
            alpha_o: b.alpha_o.to_f64(),
            q_i: b.q_i.to_f64(),
            q_o: b.q_o.to_f64(),
            delta_i: b.delta_i.to_f64(),
            delta_o: b.delta_o.to_f64(),
            centrifugal_force: b.centrifugal_force.to_f64(),
            gyroscopic_moment: b.gyroscopic_moment.to_f64(),
        };
        Self {
            u: s.displacement.map(T::to_f64),
            load: s.load.map(T::to_f64),
            k: s.stiffness.map(|row| row.map(T::to_f64)),
            balls: s.balls.iter().map(wide).collect(),
            estimate: [s.error.displacement, s.error.force, s.error.stiffness].map(T::to_f64),
        }
    }

    fn equilibrium(&self) -> Equilibrium {
        Equilibrium {
            displacement: self.u,
            stiffness: self.k,
            balls: self.balls.iter().map(Ball::from).collect(),
        }
    }

    fn is_finite(&self) -> bool {
        let balls = self.balls.iter().flat_map(|b| {
            [
                b.alpha_i,
                b.alpha_o,
                b.q_i,
                b.q_o,
                b.delta_i,
                b.delta_o,
                b.centrifugal_force,
                b.gyroscopic_moment,
            ]
        });
        let k = self.k.iter().flatten().copied();
        self.u
            .into_iter()
            .chain(self.load)
            .chain(k)
            .chain(balls)
            .all(f64::is_finite)
    }
}

/// A solver of any precision, ball count and motion.
trait AnySolver {
    fn ask(&mut self, question: &Question) -> Result<Found, String>;
}

impl<T: Real, const N: usize, M: Motion> AnySolver for Solver<'static, T, N, M, 5> {
    fn ask(&mut self, q: &Question) -> Result<Found, String> {
        let given = q.given.map(|given| match given {
            Given::Load(x) => Given::Load(T::of(x)),
            Given::Displacement(x) => Given::Displacement(T::of(x)),
        });
        let growth = Growth {
            axial: T::of(q.growth.axial),
            radial: T::of(q.growth.radial),
            ball: T::of(q.growth.ball),
        };
        let speed = Speed::rad_per_s(T::of(q.omega));
        match self.solve_at(&given, speed, &growth, &Settings::default()) {
            Ok(solution) => Ok(Found::of(&solution.snapshot())),
            Err(status) => Err(status.name().to_owned()),
        }
    }
}

/// How the balls move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Balls {
    AtRest,
    AtSpeed(Attitude),
}

fn leaked<T: Real, const N: usize>(bearing: Bearing<T, N>, balls: Balls) -> Box<dyn AnySolver> {
    let bearing: &'static Bearing<T, N> = Box::leak(Box::new(bearing));
    match balls {
        Balls::AtRest => Box::new(Solver::<T, N, Static>::of(bearing)),
        Balls::AtSpeed(Attitude::Raceless) => {
            Box::new(Solver::<T, N, Full<RacewayControlFree>>::of(bearing))
        }
        Balls::AtSpeed(Attitude::Outer) => {
            Box::new(Solver::<T, N, Full<OuterRaceControl>>::of(bearing))
        }
        Balls::AtSpeed(Attitude::Inner) => {
            Box::new(Solver::<T, N, Full<InnerRaceControl>>::of(bearing))
        }
    }
}

macro_rules! solvers {
    ($($n:literal)*) => {
        /// A solver for a bearing of `n` balls, which lives as long as the test.
        fn solver(design: &Design, n: usize, precision: Precision, balls: Balls) -> Box<dyn AnySolver> {
            match (n, precision) {
                $(($n, Precision::F32) => leaked(Bearing::<f32, $n>::new(design).unwrap(), balls),
                ($n, Precision::F64) => leaked(Bearing::<f64, $n>::new(design).unwrap(), balls),)*
                _ => panic!("{n} balls are not among those of the tests"),
            }
        }
    };
}

solvers! { 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 }

const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F64];

/// Error of a vector with moments or tilts, over its largest component; `arm` turns the one into the other.
fn vector_error(found: [f64; 5], truth: [f64; 5], arm: f64) -> f64 {
    let unit = [1.0, 1.0, 1.0, arm, arm];
    let largest = (0..5)
        .map(|i| (truth[i] * unit[i]).abs())
        .fold(0.0, f64::max);
    (0..5)
        .map(|i| ((found[i] - truth[i]) * unit[i]).abs() / largest)
        .fold(0.0, f64::max)
}

fn assert_solved(solved: &SolvedCase, balls: Balls, precision: Precision) {
    let SolvedCase { case, truth, .. } = solved;
    let mut solver = solver(&case.design, case.balls, precision, balls);
    let found = solver
        .ask(&Question::load(case.load, case.omega))
        .unwrap_or_else(|status| panic!("{}, {precision:?}: {status}", case.name));
    let radius = case.pitch_radius();
    let errors = found
        .equilibrium()
        .errors(truth, case.design.ball_diameter, radius);
    let largest = truth.largest_displacement(radius) / case.design.centre_distance();
    let allowed = allowed_at(precision, largest);
    assert!(
        errors.within(allowed),
        "{}, {balls:?}, {precision:?}: {errors}",
        case.name
    );
}

#[test]
fn every_solved_case_is_solved_in_both_precisions() {
    for solved in cases::public() {
        for precision in PRECISIONS {
            assert_solved(&solved, Balls::AtSpeed(solved.case.attitude), precision);
            if solved.case.omega == 0.0 {
                assert_solved(&solved, Balls::AtRest, precision);
            }
        }
    }
}

#[test]
fn grown_bearings_of_solved_sets_have_their_loads_and_displacements() {
    let mut worst = Errors::default();
    for row in cases::rows_of_sets() {
        let balls = Balls::AtSpeed(row.case.attitude);
        let mut solver = solver(&row.case.design, row.case.balls, Precision::F64, balls);
        let [axial, radial, ball] = row.growth;
        let growth = Growth {
            axial,
            radial,
            ball,
        };
        let mut ask = |question: Question| {
            solver
                .ask(&Question { growth, ..question })
                .unwrap_or_else(|status| panic!("{}: {status}", row.case.name))
        };
        let (load, u) = (row.case.load, row.displacement);
        let omega = row.case.omega;
        let by_load = ask(Question::load(load, omega));
        let by_displacement = ask(Question::displacement(u, omega));
        let arm = row.case.pitch_radius();
        worst.displacement = worst.displacement.max(vector_error(by_load.u, u, arm));
        let force = vector_error(by_displacement.load, load, 1.0 / arm);
        worst.force = worst.force.max(force);
        for found in [&by_load, &by_displacement] {
            let largest = row.balls.iter().map(|b| b[3]).fold(0.0, f64::max);
            for (found, truth) in found.balls.iter().zip(&row.balls) {
                for (a, b) in [(found.q_i, truth[2]), (found.q_o, truth[3])] {
                    worst.force = worst.force.max((a - b).abs() / largest);
                }
                if truth[2] > 0.0 {
                    worst.contact_angle = worst.contact_angle.max((found.alpha_i - truth[0]).abs());
                }
            }
        }
    }
    assert!(
        worst.displacement < 1e-9,
        "displacement: {:e}",
        worst.displacement
    );
    assert!(worst.force < 1e-10, "force: {:e}", worst.force);
    assert!(
        worst.contact_angle < 1e-10,
        "angle: {:e}",
        worst.contact_angle
    );
}

/// A load without any symmetry, for the B7005C.
const SKEW: [f64; 5] = [1000.0, 200.0, -80.0, 0.7, 3.0];

/// How far the tangent is from the slope of the load-displacement relation, over the diagonal.
fn tangent_error(
    design: &Design,
    balls: Balls,
    load: [f64; 5],
    omega: f64,
    growth: Growth<f64>,
) -> f64 {
    let ask = |question: Question| {
        solver(design, 16, Precision::F64, balls)
            .ask(&Question { growth, ..question })
            .unwrap()
    };
    let at = ask(Question::load(load, omega));
    let mut worst: f64 = 0.0;
    for j in 0..5 {
        let h = 2e-5 * design.centre_distance()
            / if j < 3 {
                1.0
            } else {
                0.5 * design.pitch_diameter
            };
        let moved = |by: f64| {
            let mut u = at.u;
            u[j] += by;
            ask(Question::displacement(u, omega)).load
        };
        // Of fourth order.
        let [a, b, c, d] = [2.0 * h, h, -h, -2.0 * h].map(moved);
        for i in 0..5 {
            let slope = (8.0 * (b[i] - c[i]) - (a[i] - d[i])) / (12.0 * h);
            let unit = (at.k[i][i] * at.k[j][j]).sqrt();
            worst = worst.max((at.k[i][j] - slope).abs() / unit);
        }
    }
    worst
}

#[test]
fn the_tangent_is_the_slope_of_the_load_displacement_relation() {
    let rpm = rad_per_s(20_000.0);
    let growth = Growth {
        axial: 1e-6,
        radial: 4e-6,
        ball: -5e-7,
    };
    for (balls, omega) in [
        (Balls::AtRest, 0.0),
        (Balls::AtSpeed(Attitude::Raceless), rpm),
        (Balls::AtSpeed(Attitude::Outer), rpm),
        (Balls::AtSpeed(Attitude::Inner), rpm),
    ] {
        for growth in [Growth::NONE, growth] {
            let error = tangent_error(&B7005C, balls, SKEW, omega, growth);
            assert!(error < 2e-8, "{balls:?}, {growth:?}: {error:e}");
        }
    }
    let heavy = [17_800.0, 4_000.0, -900.0, 20.0, 80.0];
    let balls = Balls::AtSpeed(Attitude::Raceless);
    let error = tangent_error(&B218, balls, heavy, rad_per_s(10_000.0), Growth::NONE);
    assert!(error < 2e-8, "218: {error:e}");
}

#[test]
fn turning_the_load_by_90_degrees_turns_the_solution() {
    let balls = Balls::AtSpeed(Attitude::Raceless);
    let ask = |load| {
        solver(&B7005C, 16, Precision::F64, balls)
            .ask(&Question::load(load, 2094.0))
            .unwrap()
    };
    let [fx, fy, fz, my, mz] = SKEW;
    let (at, turned) = (ask(SKEW), ask([fx, -fz, fy, -mz, my]));
    let [dx, dy, dz, ty, tz] = at.u;
    let error = vector_error(
        turned.u,
        [dx, -dz, dy, -tz, ty],
        0.5 * B7005C.pitch_diameter,
    );
    assert!(error < 1e-13, "{error:e}");
    for (a, b) in [(0, 0), (1, 2), (2, 1), (3, 4), (4, 3)] {
        let (k, swapped) = (at.k[a][a], turned.k[b][b]);
        assert!((k - swapped).abs() < 1e-12 * k, "{a}: {k:e}, {swapped:e}");
    }
}

#[test]
fn given_displacements_are_met_and_their_reactions_hold_the_ring() {
    let balls = Balls::AtSpeed(Attitude::Raceless);
    for precision in PRECISIONS {
        let mut solver = solver(&B7005C, 16, precision, balls);
        let free = solver.ask(&Question::load(SKEW, 2094.0)).unwrap();
        for held in 1..32u8 {
            let given = from_fn(|i| {
                if held >> i & 1 == 1 {
                    Given::Displacement(free.u[i])
                } else {
                    Given::Load(SKEW[i])
                }
            });
            let question = Question {
                given,
                ..Question::load(SKEW, 2094.0)
            };
            let found = solver.ask(&question).unwrap();
            let single = precision == Precision::F32;
            let allowed = if single { [1e-5, 3e-4] } else { [1e-12, 1e-11] };
            let arm = 0.5 * B7005C.pitch_diameter;
            let u = vector_error(found.u, free.u, arm);
            let load = vector_error(found.load, SKEW, 1.0 / arm);
            assert!(
                u < allowed[0] && load < allowed[1],
                "{held:#b}, {precision:?}: {u:e}, {load:e}"
            );
        }
    }
}

#[test]
fn locked_tilts_are_tilts_that_are_held_at_zero() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let speed = Speed::rpm(20_000.0);
    let settings = Settings::default();
    let mut locked = Solver::<f64, 16, Full, 3>::of(&bearing);
    let locked = locked
        .solve([1000.0, 200.0, -80.0], speed, &settings)
        .unwrap()
        .snapshot();
    let mut given = [1000.0, 200.0, -80.0, 0.0, 0.0].map(Given::Load);
    given[3] = Given::Displacement(0.0);
    given[4] = Given::Displacement(0.0);
    let mut held = Solver::new(&bearing);
    let held = held
        .solve_at(&given, speed, &Growth::NONE, &settings)
        .unwrap()
        .snapshot();
    for i in 0..3 {
        let error = (locked.displacement[i] - held.displacement[i]).abs();
        assert!(error < 1e-13 * held.displacement[0].abs(), "{i}: {error:e}");
        for j in 0..3 {
            let error = (locked.stiffness[i][j] - held.stiffness[i][j]).abs();
            assert!(error < 1e-11 * held.stiffness[1][1], "{i}, {j}: {error:e}");
        }
    }
}

#[test]
fn centrifugal_force_alone_leaves_contacts_without_friction() {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let mut solver = Solver::<f64, 16, Centrifugal>::of(&bearing);
    let solution = solver
        .solve(SKEW, Speed::rpm(20_000.0), &Settings::default())
        .unwrap();
    for ball in solution.balls() {
        assert_eq!(ball.gyroscopic_moment, 0.0);
        // Axial balance of the ball, radial with the centrifugal force.
        let axial = ball.q_i * ball.alpha_i.sin() - ball.q_o * ball.alpha_o.sin();
        let radial =
            ball.q_i * ball.alpha_i.cos() - ball.q_o * ball.alpha_o.cos() + ball.centrifugal_force;
        assert!(
            axial.abs().max(radial.abs()) < 1e-12 * ball.q_o,
            "{axial:e}, {radial:e}"
        );
    }
}

#[test]
fn growth_of_nothing_changes_no_bit() {
    let balls = Balls::AtSpeed(Attitude::Raceless);
    let [mut without, mut with] = [0; 2].map(|_| solver(&B7005C, 16, Precision::F32, balls));
    for step in 0..20 {
        let load = SKEW.map(|f| f * (1.0 + 0.01 * f64::from(step)));
        let question = Question::load(load, 2094.0);
        let zero = Growth {
            axial: -0.0,
            ..Growth::NONE
        };
        let grown = Question {
            growth: zero,
            ..question
        };
        assert_eq!(without.ask(&question), with.ask(&grown));
    }
}

#[test]
fn a_warm_solve_is_the_cold_one_to_the_errors_that_both_state() {
    let balls = Balls::AtSpeed(Attitude::Raceless);
    for precision in PRECISIONS {
        let mut warm = solver(&B7005C, 16, precision, balls);
        for step in 0..60 {
            let phase = 0.1 * f64::from(step);
            let load = [
                1000.0 + 200.0 * phase.sin(),
                200.0 * phase.cos(),
                -80.0,
                0.7,
                3.0 * phase.sin(),
            ];
            let question = Question::load(load, 2094.0 + 10.0 * phase);
            let warm = warm.ask(&question).unwrap();
            let cold = solver(&B7005C, 16, precision, balls)
                .ask(&question)
                .unwrap();
            let arm = 0.5 * B7005C.pitch_diameter;
            let u = vector_error(warm.u, cold.u, arm);
            let k = (0..5)
                .map(|i| (warm.k[i][i] / cold.k[i][i] - 1.0).abs())
                .fold(0.0, f64::max);
            let [stated_u, _, stated_k] = from_fn(|i| warm.estimate[i] + cold.estimate[i]);
            assert!(
                u <= stated_u && k <= stated_k,
                "{step}, {precision:?}: {u:e}, {k:e}"
            );
        }
    }
}

#[test]
fn the_same_bearing_at_speed_zero_is_the_one_at_rest() {
    for (design, n) in [(&B7005C, 16), (&SKF6205, 9)] {
        let load = [500.0, 300.0, -100.0, 0.5, 1.0];
        let question = Question::load(load, 0.0);
        let rest = solver(design, n, Precision::F64, Balls::AtRest).ask(&question);
        let speed = Balls::AtSpeed(Attitude::Raceless);
        let speed = solver(design, n, Precision::F64, speed).ask(&question);
        let (rest, speed) = (rest.unwrap(), speed.unwrap());
        let error = vector_error(rest.u, speed.u, 0.5 * design.pitch_diameter);
        assert!(error < 1e-12, "{error:e}");
    }
}

#[test]
fn whatever_the_input_an_answer_is_finite_and_a_refusal_has_a_name() {
    for family in Family::ALL {
        (0..80).into_par_iter().for_each(|index| {
            let trial = Trial::new(7, family, index);
            let case = &trial.case;
            if !(3..=30).contains(&case.balls) {
                return;
            }
            for precision in PRECISIONS {
                let balls = Balls::AtSpeed(case.attitude);
                let mut solver = solver(&case.design, case.balls, precision, balls);
                for tick in &trial.ticks {
                    if let Ok(found) = solver.ask(&Question::load(tick.load, tick.omega)) {
                        assert!(found.is_finite(), "{}, {precision:?}: {found:?}", case.name);
                    }
                }
            }
        });
    }
}

#[test]
fn input_out_of_range_is_refused_by_its_name() {
    let bearing = Bearing::<f32, 16>::new(&B7005C).unwrap();
    let mut solver = Solver::new(&bearing);
    let settings = Settings::default();
    let speed = Speed::rpm(20_000.0);
    let mut refusal = |load: [f32; 5], speed, growth| {
        let given = load.map(Given::Load);
        let refused = solver.solve_at(&given, speed, &growth, &settings).err();
        refused.map_or_else(String::new, |status| status.to_string())
    };
    let good = [1000.0, 200.0, 0.0, 0.0, 3.0];
    let told = refusal([f32::NAN, 0.0, 0.0, 0.0, 0.0], speed, Growth::NONE);
    assert_eq!(told, "axial load Fx (N) is NaN");
    let told = refusal([0.0, 0.0, 0.0, 0.0, f32::INFINITY], speed, Growth::NONE);
    assert_eq!(told, "tilting moment Mz (N m) is inf");
    assert!(refusal(good, Speed::rpm(1e9), Growth::NONE).starts_with("speed omega (rad/s) is"));
    let growth = Growth {
        ball: 1.0,
        ..Growth::NONE
    };
    assert!(refusal(good, speed, growth).starts_with("growth of the ball diameter gD (m) is"));
    let told = refusal([0.0; 5], speed, Growth::NONE);
    assert_eq!(told, Status::<f32>::Unloaded.to_string());
    assert_eq!(refusal(good, speed, Growth::NONE), "");
}
