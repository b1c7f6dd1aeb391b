//! The core that is to take the place of today's (`spindle_bearing::next`): solved cases, and laws.

use super::limits::scenes;
use host_tests::campaign::families::{Family, Trial};
use host_tests::cases::{self, B218, B7005C, SKF6205, SolvedCase, rad_per_s};
use host_tests::compare::{Ball, Equilibrium, Errors};
use host_tests::dispatch::{Attitude, Precision};
use host_tests::tolerances::allowed_at;
use rayon::prelude::*;
use spindle_bearing::next::{
    AxialSolver, Bearing, Centrifugal, Full, Given, Growth, Motion, Settings, Snapshot, Solver,
    Speed, Static,
};
use spindle_bearing::{
    BallState, Design, Exceedances, Extreme, Extremes, InnerRaceControl, Limit, LimitSet, Limits,
    OuterRaceControl, Race, RacewayControlFree, Real, Status,
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

/// A ball's state in doubles.
fn wide<T: Real>(b: &BallState<T>) -> BallState<f64> {
    BallState {
        azimuth: b.azimuth.to_f64(),
        alpha_i: b.alpha_i.to_f64(),
        alpha_o: b.alpha_o.to_f64(),
        q_i: b.q_i.to_f64(),
        q_o: b.q_o.to_f64(),
        delta_i: b.delta_i.to_f64(),
        delta_o: b.delta_o.to_f64(),
        centrifugal_force: b.centrifugal_force.to_f64(),
        gyroscopic_moment: b.gyroscopic_moment.to_f64(),
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

/// What is given, in the precision of a solver.
fn narrow<T: Real>(given: Given<f64>) -> Given<T> {
    match given {
        Given::Load(x) => Given::Load(T::of(x)),
        Given::Displacement(x) => Given::Displacement(T::of(x)),
    }
}

/// Growth in the precision of a solver.
fn grown<T: Real>(growth: Growth<f64>) -> Growth<T> {
    Growth {
        axial: T::of(growth.axial),
        radial: T::of(growth.radial),
        ball: T::of(growth.ball),
    }
}

/// A solver of any precision, ball count and motion.
trait AnySolver {
    fn ask(&mut self, question: &Question) -> Result<Found, String>;
}

impl<T: Real, const N: usize, M: Motion> AnySolver for Solver<'static, T, N, M, 5> {
    fn ask(&mut self, q: &Question) -> Result<Found, String> {
        let given = q.given.map(narrow);
        let growth = grown(q.growth);
        let speed = Speed::rad_per_s(T::of(q.omega));
        match self.solve_at(&given, speed, &growth, &Settings::default()) {
            Ok(solution) => Ok(Found::of(&solution.snapshot())),
            Err(status) => Err(status.name().to_owned()),
        }
    }
}

/// An axial solution in doubles, as one of five freedoms without what is zero.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FoundAxial {
    u: f64,
    load: f64,
    k: f64,
    ball: BallState<f64>,
    /// Estimated errors of displacement, force and stiffness.
    estimate: [f64; 3],
    iterations: u16,
}

/// An axial solver of any precision, ball count and motion.
trait AnyAxialSolver {
    fn ask(
        &mut self,
        given: Given<f64>,
        omega: f64,
        growth: Growth<f64>,
    ) -> Result<FoundAxial, String>;
}

impl<T: Real, const N: usize, M: Motion> AnyAxialSolver for AxialSolver<'static, T, N, M> {
    fn ask(
        &mut self,
        given: Given<f64>,
        omega: f64,
        growth: Growth<f64>,
    ) -> Result<FoundAxial, String> {
        let speed = Speed::rad_per_s(T::of(omega));
        let settings = Settings::default();
        match self.solve_at(narrow(given), speed, &grown(growth), &settings) {
            Ok(s) => Ok(FoundAxial {
                u: s.displacement.to_f64(),
                load: s.load.to_f64(),
                k: s.stiffness().to_f64(),
                ball: wide(&s.ball()),
                estimate: [s.error.displacement, s.error.force, s.error.stiffness].map(T::to_f64),
                iterations: s.iterations,
            }),
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

fn leaked_axial<T: Real, const N: usize>(
    bearing: Bearing<T, N>,
    balls: Balls,
) -> Box<dyn AnyAxialSolver> {
    let bearing: &'static Bearing<T, N> = Box::leak(Box::new(bearing));
    match balls {
        Balls::AtRest => Box::new(AxialSolver::<T, N, Static>::of(bearing)),
        Balls::AtSpeed(Attitude::Raceless) => {
            Box::new(AxialSolver::<T, N, Full<RacewayControlFree>>::of(bearing))
        }
        Balls::AtSpeed(Attitude::Outer) => {
            Box::new(AxialSolver::<T, N, Full<OuterRaceControl>>::of(bearing))
        }
        Balls::AtSpeed(Attitude::Inner) => {
            Box::new(AxialSolver::<T, N, Full<InnerRaceControl>>::of(bearing))
        }
    }
}

/// An axial solver for a bearing of 9, 16 or 20 balls, which lives as long as the test.
fn axial_solver(
    design: &Design,
    n: usize,
    precision: Precision,
    balls: Balls,
) -> Box<dyn AnyAxialSolver> {
    macro_rules! of {
        ($t:ident, $n:literal) => {
            leaked_axial(Bearing::<$t, $n>::new(design).unwrap(), balls)
        };
    }
    match (n, precision) {
        (9, Precision::F32) => of!(f32, 9),
        (9, Precision::F64) => of!(f64, 9),
        (16, Precision::F32) => of!(f32, 16),
        (16, Precision::F64) => of!(f64, 16),
        (20, Precision::F32) => of!(f32, 20),
        (20, Precision::F64) => of!(f64, 20),
        _ => panic!("{n} balls are not among those of the axial tests"),
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
fn a_bearing_that_warms_up_is_followed() {
    for balls in [Balls::AtRest, Balls::AtSpeed(Attitude::Raceless)] {
        let mut warm = solver(&B7005C, 16, Precision::F64, balls);
        for step in 0..40 {
            // Up to three times as much as balls deform, and a jump back.
            let share = f64::from(step % 30) / 30.0;
            let growth = Growth {
                axial: 2e-6 * share,
                radial: 9e-6 * share,
                ball: 1e-6 * share,
            };
            let question = Question {
                growth,
                ..Question::load(SKEW, 2094.0)
            };
            let found = warm.ask(&question).unwrap();
            let cold = solver(&B7005C, 16, Precision::F64, balls)
                .ask(&question)
                .unwrap();
            let u = vector_error(found.u, cold.u, 0.5 * B7005C.pitch_diameter);
            let k = (found.k[1][1] / cold.k[1][1] - 1.0).abs();
            assert!(u < 1e-11 && k < 1e-11, "{step}, {balls:?}: {u:e}, {k:e}");
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
fn forces_of_an_answer_balance_the_load_where_the_ring_hardly_resists() {
    let solved = (0..1000)
        .into_par_iter()
        .filter(|&index| {
            let trial = Trial::new(11, Family::DeepGroove, index);
            let (case, tick) = (&trial.case, &trial.ticks[0]);
            if !(3..=30).contains(&case.balls) {
                return false;
            }
            let mut solver = solver(&case.design, case.balls, Precision::F32, Balls::AtRest);
            let Ok(found) = solver.ask(&Question::load(tick.load, 0.0)) else {
                return false;
            };
            let sum = found.balls.iter().fold([0.0; 3], |[x, y, z], b| {
                let (axial, radial) = (b.q_i * b.alpha_i.sin(), b.q_i * b.alpha_i.cos());
                let (sin, cos) = b.azimuth.sin_cos();
                [x + axial, y + radial * cos, z + radial * sin]
            });
            let largest = found.balls.iter().map(|b| b.q_i).fold(0.0, f64::max);
            for (sum, load) in sum.iter().zip(tick.load) {
                let off = (sum - load).abs();
                assert!(off < 1e-3 * largest, "{}: {sum} of {load} N", case.name);
            }
            true
        })
        .count();
    assert!(solved > 400, "{solved}");
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

/// The equilibrium of all balls, of which the axial solver has one; other stiffness than the axial one is `truth`'s.
fn all_alike(found: &FoundAxial, truth: &Equilibrium) -> Equilibrium {
    let mut stiffness = truth.stiffness;
    stiffness[0][0] = found.k;
    Equilibrium {
        displacement: [found.u, 0.0, 0.0, 0.0, 0.0],
        stiffness,
        balls: vec![Ball::from(&found.ball); truth.balls.len()],
    }
}

#[test]
fn solved_cases_that_are_purely_axial_are_solved_with_one_ball() {
    let mut count = 0;
    for SolvedCase { case, truth, .. } in cases::public() {
        if case.load[1..] != [0.0; 4] || ![9, 16, 20].contains(&case.balls) {
            continue;
        }
        count += 1;
        for precision in PRECISIONS {
            let mut motions = vec![Balls::AtSpeed(case.attitude)];
            if case.omega == 0.0 {
                motions.push(Balls::AtRest);
            }
            for balls in motions {
                let found = axial_solver(&case.design, case.balls, precision, balls)
                    .ask(Given::Load(case.load[0]), case.omega, Growth::NONE)
                    .unwrap_or_else(|status| panic!("{}, {precision:?}: {status}", case.name));
                let radius = case.pitch_radius();
                let errors =
                    all_alike(&found, &truth).errors(&truth, case.design.ball_diameter, radius);
                let largest = truth.largest_displacement(radius) / case.design.centre_distance();
                let allowed = allowed_at(precision, largest);
                assert!(
                    errors.within(allowed),
                    "{}, {}, {balls:?}, {precision:?}: {errors}",
                    case.name,
                    case.omega
                );
            }
        }
    }
    assert!(count >= 15, "{count} cases");
}

const GROWN: Growth<f64> = Growth {
    axial: 1e-6,
    radial: 4e-6,
    ball: -5e-7,
};

#[test]
fn one_ball_for_all_is_the_bearing_of_five_freedoms_under_an_axial_load() {
    let pressed = Growth {
        axial: -2e-6,
        radial: 14e-6,
        ball: 3e-7,
    };
    let motions = [
        Balls::AtRest,
        Balls::AtSpeed(Attitude::Raceless),
        Balls::AtSpeed(Attitude::Outer),
        Balls::AtSpeed(Attitude::Inner),
    ];
    for (design, n, load, rpm) in [
        (&B7005C, 16, 1000.0, 20_000.0),
        (&B7005C, 16, 120.0, 6_000.0),
        (&B218, 16, 17_800.0, 10_000.0),
        (&SKF6205, 9, 300.0, 8_000.0),
    ] {
        for (balls, growth, precision) in motions.into_iter().flat_map(|balls| {
            [Growth::NONE, GROWN, pressed]
                .into_iter()
                .flat_map(move |g| PRECISIONS.map(|precision| (balls, g, precision)))
        }) {
            for (load, omega) in [(load, 0.0), (load, rad_per_s(rpm)), (-load, rad_per_s(rpm))] {
                let what = format!(
                    "{n} balls, {load} N, {omega} rad/s, {balls:?}, {growth:?}, {precision:?}"
                );
                let question = Question {
                    growth,
                    ..Question::load([load, 0.0, 0.0, 0.0, 0.0], omega)
                };
                let truth = solver(design, n, Precision::F64, balls)
                    .ask(&question)
                    .unwrap_or_else(|status| panic!("{what}: {status}"));
                let mut solver = axial_solver(design, n, precision, balls);
                let found = solver
                    .ask(Given::Load(load), omega, growth)
                    .unwrap_or_else(|status| panic!("{what}: {status}, one ball"));
                assert_eq!(found.load, load);
                assert_eq!(found.ball.azimuth, truth.balls[0].azimuth);
                let truth = truth.equilibrium();
                let radius = 0.5 * design.pitch_diameter;
                let errors = all_alike(&found, &truth).errors(&truth, design.ball_diameter, radius);
                let length = design.centre_distance();
                // Displacements cannot be better than growth in single precision.
                let size = [growth.axial, growth.radial, growth.ball]
                    .iter()
                    .fold(truth.displacement[0].abs(), |size, g| size.max(g.abs()));
                let mut allowed = allowed_at(precision, truth.displacement[0].abs() / length);
                allowed.displacement *= size / truth.displacement[0].abs();
                if precision == Precision::F64 {
                    // Both are off.
                    allowed.contact_angle *= 3.0;
                    allowed.force *= 3.0;
                    allowed.stiffness *= 3.0;
                }
                assert!(errors.within(allowed), "{what}: {errors}");
                // The reaction to that displacement is that load.
                let back = solver
                    .ask(Given::Displacement(found.u), omega, growth)
                    .unwrap_or_else(|status| panic!("{what}: {status}, displacement"));
                let resolved = if precision == Precision::F64 {
                    1e-16
                } else {
                    6e-8
                };
                let sum = size.max(2.0 * length * truth.balls[0].inner.angle.sin().abs());
                let allowed = 1e-11 + 20.0 * resolved * (1.0 + found.k * sum / load.abs());
                let off = (back.load / load - 1.0).abs();
                assert!(
                    back.u == found.u && off < allowed,
                    "{what}: {off:e}, {allowed:e}"
                );
            }
        }
    }
}

#[test]
fn a_warm_axial_solve_is_the_cold_one_to_the_errors_that_both_state() {
    for balls in [Balls::AtRest, Balls::AtSpeed(Attitude::Raceless)] {
        for precision in PRECISIONS {
            let mut warm = axial_solver(&B7005C, 16, precision, balls);
            let mut iterations = [0, 0];
            for step in 0..60 {
                let phase = 0.1 * f64::from(step);
                let load = Given::Load(500.0 + 20.0 * phase.sin());
                let omega = 2094.0 + 10.0 * phase;
                let warm = warm.ask(load, omega, GROWN).unwrap();
                let cold = axial_solver(&B7005C, 16, precision, balls)
                    .ask(load, omega, GROWN)
                    .unwrap();
                iterations[0] += warm.iterations;
                iterations[1] += cold.iterations;
                let [u, q, k] = [
                    (warm.u, cold.u),
                    (warm.ball.q_i, cold.ball.q_i),
                    (warm.k, cold.k),
                ]
                .map(|(a, b)| (a / b - 1.0).abs());
                let stated: [f64; 3] = from_fn(|i| warm.estimate[i] + cold.estimate[i]);
                assert!(
                    u <= stated[0] && q <= stated[1] && k <= stated[2],
                    "{step}, {balls:?}, {precision:?}: {u:e}, {q:e}, {k:e}, {stated:?}"
                );
            }
            assert!(
                2 * iterations[0] < iterations[1],
                "{balls:?}, {precision:?}: {iterations:?}"
            );
        }
    }
}

#[test]
fn axial_loads_of_any_size_are_solved_at_rest() {
    for growth in [0.0, 1e-6, 8e-6, 20e-6, -15e-6].map(|radial| Growth {
        radial,
        ..Growth::NONE
    }) {
        for precision in PRECISIONS {
            let mut solver = axial_solver(&SKF6205, 9, precision, Balls::AtRest);
            let mut last = None;
            for step in -28..19 {
                let load = 10f64.powf(0.25 * f64::from(step));
                let mut ask = |load| solver.ask(Given::Load(load), 0.0, growth).unwrap();
                let (found, turned) = (ask(load), ask(-load));
                let ball = &found.ball;
                let force = 9.0 * ball.q_i * ball.alpha_i.sin();
                let single = precision == Precision::F32;
                let allowed = if single { 1e-5 } else { 1e-13 };
                assert!(
                    (force / load - 1.0).abs() < allowed,
                    "{load} N, {growth:?}, {precision:?}: {force}"
                );
                assert!(found.k > 0.0 && found.iterations <= 40, "{found:?}");
                assert!((turned.k / found.k - 1.0).abs() < allowed, "{turned:?}");
                assert!((turned.ball.q_i / ball.q_i - 1.0).abs() < allowed);
                assert!(last.is_none_or(|last| found.u >= last), "{found:?}");
                last = Some(found.u);
            }
        }
    }
}

#[test]
fn a_ball_that_no_load_holds_against_its_inertia_is_refused_by_name() {
    for precision in PRECISIONS {
        let balls = Balls::AtSpeed(Attitude::Raceless);
        for load in [1e-3, 1.0, 10.0, 100.0, 1e3, 1e4] {
            for rpm in [1e3, 1e4, 3e4, 1e5, 2e5] {
                let mut solver = axial_solver(&B7005C, 16, precision, balls);
                let Err(status) = solver.ask(Given::Load(load), rad_per_s(rpm), Growth::NONE)
                else {
                    continue;
                };
                assert!(
                    ["unseated", "diverged", "sweep-limit", "indeterminate"]
                        .contains(&status.as_str()),
                    "{load} N, {rpm} rpm: {status}"
                );
                // The next solve does not suffer.
                let found = solver.ask(Given::Load(1e3), 2094.0, Growth::NONE).unwrap();
                let fresh = axial_solver(&B7005C, 16, precision, balls)
                    .ask(Given::Load(1e3), 2094.0, Growth::NONE)
                    .unwrap();
                let off = (found.k / fresh.k - 1.0).abs();
                assert!(off <= found.estimate[2] + fresh.estimate[2], "{off:e}");
            }
        }
    }
}

#[test]
fn axial_input_out_of_range_is_refused_by_its_name() {
    let bearing = Bearing::<f32, 16>::new(&B7005C).unwrap();
    let settings = Settings::default();
    let speed = Speed::rpm(20_000.0);
    let mut at_rest = AxialSolver::<f32, 16, Static>::of(&bearing);
    let mut at_speed = AxialSolver::new(&bearing);
    let mut refusals = |given, speed, growth| {
        let rest = at_rest.solve_at(given, speed, &growth, &settings).err();
        let other = at_speed.solve_at(given, speed, &growth, &settings).err();
        let told = |status: Option<Status<f32>>| status.map_or(String::new(), |s| s.to_string());
        let (rest, other) = (told(rest), told(other));
        assert_eq!(rest, other);
        rest
    };
    let load = Given::Load(1000.0);
    let told = refusals(Given::Load(f32::NAN), speed, Growth::NONE);
    assert_eq!(told, "axial load Fx (N) is NaN");
    let told = refusals(Given::Load(-1e9), speed, Growth::NONE);
    assert!(
        told.starts_with("axial load Fx (N) is -1e9, beyond"),
        "{told}"
    );
    let told = refusals(Given::Displacement(1.0), speed, Growth::NONE);
    assert!(
        told.starts_with("axial displacement dx (m) is 1e0"),
        "{told}"
    );
    let told = refusals(load, Speed::rpm(1e9), Growth::NONE);
    assert!(told.starts_with("speed omega (rad/s) is"), "{told}");
    let told = refusals(load, Speed::rpm(f32::NAN), Growth::NONE);
    assert_eq!(told, "speed omega (rad/s) is NaN");
    let growth = Growth {
        radial: 1.0,
        ..Growth::NONE
    };
    let told = refusals(load, speed, growth);
    assert!(told.starts_with("radial growth gr (m) is"), "{told}");
    let told = refusals(Given::Load(0.0), speed, Growth::NONE);
    assert_eq!(told, Status::<f32>::Unloaded.to_string());
    assert_eq!(refusals(load, speed, Growth::NONE), "");
}

/// What a solution says of the limits, and the balls that it says it of.
struct Seen {
    balls: Vec<BallState<f64>>,
    passed: [Exceedances<f64>; 2],
    extremes: Extremes<f64>,
}

/// Limits that every contact passes but for friction that is rounding, and the default ones.
fn two_limits() -> [Limits<f64>; 2] {
    let nothing = Limits {
        peak_pressure: 0.0,
        friction: 1e-9,
    };
    [nothing, Limits::default()]
}

/// By the core in use.
fn seen_today<M: spindle_bearing::Motion>(
    design: &Design,
    load: [f64; 5],
    omega: f64,
) -> Option<Seen> {
    let bearing = spindle_bearing::Bearing::<f64, 16>::new(design).unwrap();
    let mut solver = spindle_bearing::Solver::<f64, 16, M>::new(&bearing);
    let settings = spindle_bearing::Settings::default();
    let solution = solver.solve(load, omega, &settings).ok()?;
    matches!(solution.status, Status::Converged | Status::PrecisionLimit).then(|| Seen {
        balls: solution.balls().collect(),
        passed: two_limits().map(|limits| solution.exceedances(&limits)),
        extremes: solution.extremes(),
    })
}

/// By this core.
fn seen<M: Motion>(design: &Design, load: [f64; 5], omega: f64) -> Option<Seen> {
    let bearing = Bearing::<f64, 16>::new(design).unwrap();
    let mut solver = Solver::<f64, 16, M>::of(&bearing);
    let speed = Speed::rad_per_s(omega);
    let solution = solver.solve(load, speed, &Settings::default()).ok()?;
    Some(Seen {
        balls: solution.balls().collect(),
        passed: two_limits().map(|limits| solution.exceedances(&limits)),
        extremes: solution.extremes(),
    })
}

/// To 1e-9, relative; of lengths and angles near zero, to that of a micrometre and of a radian.
fn is_same(limit: Limit, a: f64, b: f64) -> bool {
    let unit = match limit {
        Limit::PeakPressure | Limit::Friction => 0.0,
        Limit::InnerContact => 1e-6,
        _ => 1.0,
    };
    (a - b).abs() <= 1e-9 * a.abs().max(unit)
}

/// Whether two contacts are the same, or as bad as each other in what a limit is about: those of equal balls, of both
/// races at rest, or of balls that are all radial.
fn is_as_bad(limit: Limit, balls: &[BallState<f64>], a: &Extreme<f64>, b: &Extreme<f64>) -> bool {
    let of = |extreme: &Extreme<f64>| {
        let ball = &balls[usize::from(extreme.ball)];
        match (limit, extreme.race) {
            // The free rule shares friction as the forces are: its ratio is the same on both races.
            (Limit::Friction, _) => (ball.alpha_o, ball.q_o),
            (_, Race::Inner) => (ball.alpha_i, ball.q_i),
            (_, Race::Outer) => (ball.alpha_o, ball.q_o),
        }
    };
    let ((angle, force), (other_angle, other_force)) = (of(a), of(b));
    let (angle, force) = (
        (angle.abs() - other_angle.abs()).abs() < 1e-9,
        (force - other_force).abs() <= 1e-9 * force,
    );
    (a.ball, a.race) == (b.ball, b.race)
        || match limit {
            Limit::PeakPressure => force,
            Limit::Shoulder | Limit::Reversal => angle,
            _ => angle && force,
        }
}

/// Holds what this core says of the limits against what today's says; `None` without two solutions of one equilibrium.
fn same_limits(today: Option<Seen>, found: Option<Seen>, name: &str) -> Option<LimitSet> {
    let (today, found) = (today?, found?);
    let forces =
        |seen: &Seen| -> Vec<f64> { seen.balls.iter().flat_map(|b| [b.q_i, b.q_o]).collect() };
    let (a, b) = (forces(&today), forces(&found));
    let largest = a.iter().copied().fold(0.0, f64::max);
    // A ball off the inner race can have more than one place on the outer one.
    if a.iter()
        .zip(&b)
        .any(|(a, b)| (a - b).abs() > 1e-9 * largest)
    {
        return None;
    }
    let same = |limit, a: Option<Extreme<f64>>, b: Option<Extreme<f64>>| match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            is_same(limit, a.value, b.value) && is_as_bad(limit, &today.balls, &a, &b)
        }
        _ => false,
    };
    for (passed, found) in today.passed.iter().zip(&found.passed) {
        for limit in Limit::ALL {
            let (a, b) = (passed.get(limit), found.get(limit));
            let extreme = |e: spindle_bearing::Exceedance<f64>| Extreme {
                value: e.value,
                ball: e.ball,
                race: e.race,
            };
            let counts = a.map(|e| (e.balls, e.allowed)) == b.map(|e| (e.balls, e.allowed));
            assert!(
                counts && same(limit, a.map(extreme), b.map(extreme)),
                "{name}: {a:?} and {b:?}"
            );
        }
    }
    let (a, b) = (&today.extremes, &found.extremes);
    let all = same(Limit::PeakPressure, a.pressure, b.pressure)
        && same(Limit::Shoulder, a.shoulder, b.shoulder)
        && same(Limit::Friction, a.friction, b.friction)
        && a.off.0 == b.off.0;
    assert!(all, "{name}: {a:?} and {b:?}");
    Some(found.passed[0].limits())
}

#[test]
fn limits_that_are_passed_are_those_of_todays_core() {
    let mut compared = 0;
    for SolvedCase { case, .. } in cases::public() {
        if case.balls != 16 {
            continue;
        }
        let (design, load, omega) = (&case.design, case.load, case.omega);
        let (today, found) = match case.attitude {
            Attitude::Raceless => (
                seen_today::<spindle_bearing::Full>(design, load, omega),
                seen::<Full>(design, load, omega),
            ),
            Attitude::Outer => (
                seen_today::<spindle_bearing::Full<OuterRaceControl>>(design, load, omega),
                seen::<Full<OuterRaceControl>>(design, load, omega),
            ),
            Attitude::Inner => (
                seen_today::<spindle_bearing::Full<InnerRaceControl>>(design, load, omega),
                seen::<Full<InnerRaceControl>>(design, load, omega),
            ),
        };
        compared += usize::from(same_limits(today, found, &case.name).is_some());
    }
    assert!(compared >= 12, "{compared}");
}

#[test]
fn limits_under_loads_of_every_kind_are_those_of_todays_core() {
    let narrow = |(design, shoulder): (Design, f64)| Design {
        // Balls as the others have.
        pitch_diameter: design.pitch_diameter.max(6.0 * design.ball_diameter),
        inner_shoulder_angle: shoulder,
        outer_shoulder_angle: shoulder - 0.05,
        ..design
    };
    let (mut asked, mut compared, mut passed) = (0, 0, [0; Limit::ALL.len()]);
    for design in [(B7005C, 0.4), (B218, 0.85), (SKF6205, 0.4)].map(narrow) {
        for (load, omega) in scenes(4, 60) {
            let name = format!("{load:?} at {omega}");
            let pairs = [
                (
                    seen_today::<spindle_bearing::Static>(&design, load, omega),
                    seen::<Static>(&design, load, omega),
                ),
                (
                    seen_today::<spindle_bearing::Centrifugal>(&design, load, omega),
                    seen::<Centrifugal>(&design, load, omega),
                ),
                (
                    seen_today::<spindle_bearing::Full>(&design, load, omega),
                    seen::<Full>(&design, load, omega),
                ),
            ];
            for (today, found) in pairs {
                asked += 1;
                if let Some(limits) = same_limits(today, found, &name) {
                    compared += 1;
                    for (sum, limit) in passed.iter_mut().zip(Limit::ALL) {
                        *sum += usize::from(limits.contains(limit));
                    }
                }
            }
        }
    }
    assert!(10 * compared > 9 * asked, "{compared} of {asked}");
    assert!(passed.iter().all(|&n| n > 20), "{passed:?}");
}

#[test]
fn a_snapshot_is_what_the_solution_says() {
    let bearing = Bearing::<f32, 16>::new(&B7005C).unwrap();
    let mut solver = Solver::new(&bearing);
    let load = SKEW.map(|x| x as f32);
    let settings = Settings::default();
    for rpm in [0.0, 20_000.0, 20_100.0] {
        let speed = Speed::rpm(rpm);
        let solution = solver.solve(load, speed, &settings).unwrap();
        let copy = solution.snapshot();
        assert_eq!(copy.status, solution.status);
        assert_eq!(copy.iterations, solution.iterations);
        assert_eq!(copy.error, solution.error);
        assert_eq!(copy.displacement, solution.displacement);
        assert_eq!((copy.load, copy.speed), (load, speed));
        assert_eq!((solution.load, solution.speed), (load, speed));
        assert_eq!(copy.stiffness, solution.stiffness());
        assert!(solution.balls().eq(copy.balls));
        assert!(solution.cage_speeds().eq(copy.cage_speeds));
        assert!(solution.inner_forces().eq(copy.balls.map(|ball| ball.q_i)));
    }
}

#[test]
fn cage_speeds_are_those_of_the_centrifugal_forces() {
    let (d, dm) = (B7005C.ball_diameter, B7005C.pitch_diameter);
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let settings = Settings::default();
    let half_m_dm = B7005C.ball.density * std::f64::consts::PI * d.powi(3) / 12.0 * dm;
    for omega in [2094.0, -2094.0] {
        let speed = Speed::rad_per_s(omega);
        let mut solver = Solver::new(&bearing);
        let solution = solver.solve(SKEW, speed, &settings).unwrap();
        for (ball, cage_speed) in solution.balls().zip(solution.cage_speeds()) {
            let expected = (ball.centrifugal_force / half_m_dm).sqrt().copysign(omega);
            assert!((cage_speed / expected - 1.0).abs() < 1e-12);
        }
        // Without inertia: rolling on both races.
        let mut solver = Solver::<f64, 16, Static>::of(&bearing);
        let solution = solver.solve(SKEW, speed, &settings).unwrap();
        for (ball, cage_speed) in solution.balls().zip(solution.cage_speeds()) {
            let expected = 0.5 * omega * (1.0 - d / dm * ball.alpha_i.cos());
            assert!((cage_speed / expected - 1.0).abs() < 1e-12);
        }
    }
}
