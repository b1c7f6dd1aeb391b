//! Solvers whose precision, ball count and motion are known at run time, and their solutions in doubles.

use host_tests::compare::{Ball, Equilibrium, worse};
use host_tests::dispatch::{Attitude, Precision, widened};
use proptest::strategy::Strategy;
use spindle_bearing::{
    AxialSolver, Bearing, Centrifugal, Full, Given, Growth, Motion, Settings, Snapshot, Solver,
    Speed, Static,
};
use spindle_bearing::{BallState, Design, InnerRaceControl, OuterRaceControl, Real, Status};
use std::array::from_fn;

pub const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F64];

/// A load without any symmetry, for the B7005C.
pub const SKEW: [f64; 5] = [1000.0, 200.0, -80.0, 0.7, 3.0];
/// A load that the balls opposite to it do not carry at 40,000 rpm, for the B7005C.
pub const LIFTING: [f64; 5] = [60.0, 110.0, 30.0, 0.0, 0.2];
/// A growth without any symmetry, for the B7005C.
pub const GROWN: Growth<f64> = Growth {
    axial: 1e-6,
    radial: 4e-6,
    ball: -5e-7,
};

/// Loads of the B7005C from light to heavy, with radial parts and moments.
pub fn loads() -> impl Strategy<Value = [f64; 5]> {
    (
        1.0..3.3f64,
        -1.0..1.0f64,
        -1.0..1.0f64,
        -3e-3..3e-3f64,
        -3e-3..3e-3f64,
    )
        .prop_map(|(size, fy, fz, my, mz)| [1.0, fy, fz, my, mz].map(|x| x * 10f64.powf(size)))
}

/// How the balls move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Balls {
    Static,
    Centrifugal,
    /// With all inertia loads, and no race in control.
    Free,
    /// The same under outer race control.
    Outer,
    /// The same under inner race control.
    Inner,
}

impl From<Attitude> for Balls {
    fn from(attitude: Attitude) -> Self {
        match attitude {
            Attitude::Raceless => Self::Free,
            Attitude::Outer => Self::Outer,
            Attitude::Inner => Self::Inner,
        }
    }
}

/// Loads, or displacements, and all else that a bearing is solved at.
#[derive(Debug, Clone, Copy)]
pub struct Question {
    pub given: [Given<f64>; 5],
    /// Speed, rad/s.
    pub omega: f64,
    pub growth: Growth<f64>,
}

impl Question {
    pub fn load(load: [f64; 5], omega: f64) -> Self {
        Self {
            given: load.map(Given::Load),
            omega,
            growth: Growth::NONE,
        }
    }

    pub fn displacement(u: [f64; 5], omega: f64) -> Self {
        Self {
            given: u.map(Given::Displacement),
            ..Self::load(u, omega)
        }
    }
}

/// What is given, in the precision of a solver.
pub fn narrow<T: Real>(given: Given<f64>) -> Given<T> {
    match given {
        Given::Load(x) => Given::Load(T::of(x)),
        Given::Displacement(x) => Given::Displacement(T::of(x)),
    }
}

fn grown<T: Real>(growth: Growth<f64>) -> Growth<T> {
    Growth {
        axial: T::of(growth.axial),
        radial: T::of(growth.radial),
        ball: T::of(growth.ball),
    }
}

/// The speed of a question. Balls at rest are asked at rest, unless the speed is absurd: which speeds they refuse is for a
/// test of its own.
pub fn turning<T: Real, M: Motion>(omega: f64) -> Speed<T> {
    if !M::AT_SPEED && omega.abs() < 1e5 {
        Speed::REST
    } else {
        Speed::rad_per_s(T::of(omega))
    }
}

/// A solution in doubles.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    pub status: Status<f32>,
    pub u: [f64; 5],
    pub load: [f64; 5],
    pub k: [[f64; 5]; 5],
    pub balls: Vec<BallState<f64>>,
    /// Estimated errors of displacement, force and stiffness.
    pub estimate: [f64; 3],
}

impl Found {
    fn of<T: Real, const N: usize>(s: &Snapshot<T, N, 5>) -> Self {
        Self {
            status: s.status.to_f32(),
            u: s.displacement.map(T::to_f64),
            load: s.load.map(T::to_f64),
            k: s.stiffness.map(|row| row.map(T::to_f64)),
            balls: s.balls.iter().map(widened).collect(),
            estimate: [s.error.displacement, s.error.force, s.error.stiffness].map(T::to_f64),
        }
    }

    pub fn equilibrium(&self) -> Equilibrium {
        Equilibrium {
            displacement: self.u,
            stiffness: self.k,
            balls: self.balls.iter().map(Ball::from).collect(),
        }
    }

    pub fn largest_force(&self) -> f64 {
        self.equilibrium().largest_force()
    }

    pub fn unloaded_balls(&self) -> usize {
        self.equilibrium().unloaded_balls()
    }
}

/// A solver of five freedoms, of any precision, ball count and motion.
pub trait AnySolver {
    fn ask(&mut self, question: &Question) -> Result<Found, Status<f32>>;

    fn reset(&mut self);

    /// Answers what must have an answer.
    fn solve(&mut self, question: &Question) -> Found {
        self.ask(question)
            .unwrap_or_else(|status| panic!("{question:?}: {status}"))
    }

    fn load(&mut self, load: [f64; 5], omega: f64) -> Found {
        self.solve(&Question::load(load, omega))
    }

    fn displacement(&mut self, u: [f64; 5], omega: f64) -> Found {
        self.solve(&Question::displacement(u, omega))
    }
}

impl<T: Real, const N: usize, M: Motion> AnySolver for Solver<'static, T, N, M> {
    fn ask(&mut self, q: &Question) -> Result<Found, Status<f32>> {
        let given = q.given.map(narrow);
        let speed = turning::<T, M>(q.omega);
        self.solve_at(&given, speed, &grown(q.growth), &Settings::default())
            .map(|solution| Found::of(&solution.snapshot()))
            .map_err(Status::to_f32)
    }

    fn reset(&mut self) {
        Solver::reset(self);
    }
}

/// An axial solution in doubles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundAxial {
    pub u: f64,
    pub load: f64,
    pub k: f64,
    pub ball: BallState<f64>,
    /// Estimated errors of displacement, force and stiffness.
    pub estimate: [f64; 3],
}

/// An axial solver of any precision, ball count and motion.
pub trait AnyAxialSolver {
    fn ask(
        &mut self,
        given: Given<f64>,
        omega: f64,
        growth: Growth<f64>,
    ) -> Result<FoundAxial, Status<f32>>;

    /// Answers what must have an answer.
    fn solve(&mut self, given: Given<f64>, omega: f64, growth: Growth<f64>) -> FoundAxial {
        self.ask(given, omega, growth)
            .unwrap_or_else(|status| panic!("{given:?} at {omega} rad/s, {growth:?}: {status}"))
    }
}

impl<T: Real, const N: usize, M: Motion> AnyAxialSolver for AxialSolver<'static, T, N, M> {
    fn ask(
        &mut self,
        given: Given<f64>,
        omega: f64,
        growth: Growth<f64>,
    ) -> Result<FoundAxial, Status<f32>> {
        let speed = turning::<T, M>(omega);
        self.solve_at(narrow(given), speed, &grown(growth), &Settings::default())
            .map(|s| FoundAxial {
                u: s.displacement.to_f64(),
                load: s.load.to_f64(),
                k: s.stiffness().to_f64(),
                ball: widened(&s.ball()),
                estimate: [s.error.displacement, s.error.force, s.error.stiffness].map(T::to_f64),
            })
            .map_err(Status::to_f32)
    }
}

/// A bearing that lives as long as the test.
fn kept<T: Real, const N: usize>(design: &Design) -> &'static Bearing<T, N> {
    Box::leak(Box::new(Bearing::build(design).unwrap()))
}

fn five<T: Real, const N: usize>(design: &Design, balls: Balls) -> Box<dyn AnySolver> {
    let bearing = kept::<T, N>(design);
    match balls {
        Balls::Static => Box::new(Solver::<T, N, Static>::of(bearing)),
        Balls::Centrifugal => Box::new(Solver::<T, N, Centrifugal>::of(bearing)),
        Balls::Free => Box::new(Solver::new(bearing)),
        Balls::Outer => Box::new(Solver::<T, N, Full<OuterRaceControl>>::of(bearing)),
        Balls::Inner => Box::new(Solver::<T, N, Full<InnerRaceControl>>::of(bearing)),
    }
}

fn one<T: Real, const N: usize>(design: &Design, balls: Balls) -> Box<dyn AnyAxialSolver> {
    let bearing = kept::<T, N>(design);
    match balls {
        Balls::Static => Box::new(AxialSolver::<T, N, Static>::of(bearing)),
        Balls::Centrifugal => Box::new(AxialSolver::<T, N, Centrifugal>::of(bearing)),
        Balls::Free => Box::new(AxialSolver::new(bearing)),
        Balls::Outer => Box::new(AxialSolver::<T, N, Full<OuterRaceControl>>::of(bearing)),
        Balls::Inner => Box::new(AxialSolver::<T, N, Full<InnerRaceControl>>::of(bearing)),
    }
}

macro_rules! solvers {
    ($($n:literal)*) => {
        /// Ball counts that there are solvers for.
        pub const BALL_COUNTS: &[usize] = &[$($n),*];

        /// A solver of five freedoms.
        pub fn solver(
            design: &Design, n: usize, precision: Precision, balls: Balls,
        ) -> Box<dyn AnySolver> {
            match (n, precision) {
                $(($n, Precision::F32) => five::<f32, $n>(design, balls),
                ($n, Precision::F64) => five::<f64, $n>(design, balls),)*
                _ => panic!("no solver for {n} balls"),
            }
        }

        /// A solver of one ball for all.
        pub fn axial_solver(
            design: &Design, n: usize, precision: Precision, balls: Balls,
        ) -> Box<dyn AnyAxialSolver> {
            match (n, precision) {
                $(($n, Precision::F32) => one::<f32, $n>(design, balls),
                ($n, Precision::F64) => one::<f64, $n>(design, balls),)*
                _ => panic!("no solver for {n} balls"),
            }
        }
    };
}

solvers! { 9 16 19 20 }

/// A solution in double precision from nothing.
pub fn cold(design: &Design, n: usize, balls: Balls, load: [f64; 5], omega: f64) -> Found {
    solver(design, n, Precision::F64, balls).load(load, omega)
}

/// Lengths per displacement: tilts are taken at the pitch radius.
pub fn lengths(design: &Design) -> [f64; 5] {
    let r = 0.5 * design.pitch_diameter;
    [1.0, 1.0, 1.0, r, r]
}

/// Forces per load: moments are taken at the pitch radius.
pub fn forces(design: &Design) -> [f64; 5] {
    lengths(design).map(|x| 1.0 / x)
}

/// Error of a vector over its largest component, each in its `unit`.
pub fn vector_error(found: [f64; 5], truth: [f64; 5], unit: [f64; 5]) -> f64 {
    let size = (0..5).fold(0.0, |m, i| worse(m, (truth[i] * unit[i]).abs()));
    (0..5).fold(0.0, |m, i| {
        worse(m, ((found[i] - truth[i]) * unit[i]).abs() / size)
    })
}

/// Largest difference of two solutions, by the measures of `host_tests::compare`.
pub fn apart(design: &Design, a: &Found, b: &Found) -> f64 {
    let (a, b) = (a.equilibrium(), b.equilibrium());
    let e = a.errors(&b, design.ball_diameter, 0.5 * design.pitch_diameter);
    [e.displacement, e.contact_angle, e.force, e.stiffness]
        .into_iter()
        .fold(0.0, worse)
}

/// Errors that two solutions together say they have.
pub fn stated(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    from_fn(|i| a[i] + b[i])
}
