//! Solvers whose precision, ball count, motion and freedoms are known at run time, and their solutions in doubles.

use host_tests::compare::{Ball, Equilibrium, Errors, worse};
use host_tests::dispatch::{Attitude, Precision, narrowed, widened};
use proptest::strategy::Strategy;
use spindle_bearing::{
    AxialSolver, BallState, Bearing, Centrifugal, Design, ErrorEstimate, Given, Growth,
    InnerRaceControl, Motion, OuterRaceControl, RacewayControlFree, Real, Settings, Solver, Speed,
    Static, Status,
};
use std::array::from_fn;
use std::f64::consts::TAU;

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
    let (radial, moment) = (-1.0..1.0f64, -3e-3..3e-3f64);
    (1.0..3.3f64, radial.clone(), radial, moment.clone(), moment)
        .prop_map(|(size, fy, fz, my, mz)| [1.0, fy, fz, my, mz].map(|x| x * 10f64.powf(size)))
}

/// A number as a solver of this precision sees it.
pub fn rounded(precision: Precision, x: f64) -> f64 {
    match precision {
        Precision::F32 => f64::from(x as f32),
        Precision::F64 => x,
    }
}

/// Distance of 1 to the next number.
pub fn epsilon(precision: Precision) -> f64 {
    match precision {
        Precision::F32 => f32::EPSILON.into(),
        Precision::F64 => f64::EPSILON,
    }
}

/// How the balls move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Balls {
    Static,
    Centrifugal,
    /// Under centrifugal force and outer race control.
    CentrifugalOuter,
    /// With all inertia loads, and no race in control.
    Free,
    /// With all inertia loads, under outer race control.
    Outer,
    /// With all inertia loads, under inner race control.
    Inner,
}

impl Balls {
    /// The rule for the axis about which a ball turns, where that matters.
    pub fn rule(self) -> Attitude {
        match self {
            Self::Centrifugal | Self::Free => Attitude::Raceless,
            Self::Static | Self::CentrifugalOuter | Self::Outer => Attitude::Outer,
            Self::Inner => Attitude::Inner,
        }
    }
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

/// Loads, or displacements, and all else that a bearing is solved at. A ring of fewer freedoms takes the first ones.
#[derive(Debug, Clone, Copy)]
pub struct Question {
    pub given: [Given<f64>; 5],
    /// Speed, rad/s.
    pub omega: f64,
    pub growth: Growth<f64>,
}

impl Question {
    pub fn load(load: [f64; 5], omega: f64) -> Self {
        Self::mixed([false; 5], load, load, omega)
    }

    pub fn displacement(u: [f64; 5], omega: f64) -> Self {
        Self::mixed([true; 5], u, u, omega)
    }

    pub fn axial(load: f64, omega: f64) -> Self {
        Self::load([load, 0.0, 0.0, 0.0, 0.0], omega)
    }

    /// The `load`, but for the displacements `u` of freedoms that are `held`.
    pub fn mixed(held: [bool; 5], u: [f64; 5], load: [f64; 5], omega: f64) -> Self {
        let given = |i| match held[i] {
            true => Given::Displacement(u[i]),
            false => Given::Load(load[i]),
        };
        Self {
            given: from_fn(given),
            omega,
            growth: Growth::NONE,
        }
    }

    pub fn grown(self, growth: Growth<f64>) -> Self {
        Self { growth, ..self }
    }

    /// One given quantity, in the precision of a solver.
    fn narrow<T: Real>(&self, freedom: usize) -> Given<T> {
        match self.given[freedom] {
            Given::Load(x) => Given::Load(T::of(x)),
            Given::Displacement(x) => Given::Displacement(T::of(x)),
        }
    }

    fn growth<T: Real>(&self) -> Growth<T> {
        let Growth {
            axial,
            radial,
            ball,
        } = self.growth;
        Growth {
            axial: T::of(axial),
            radial: T::of(radial),
            ball: T::of(ball),
        }
    }

    /// Balls at rest are asked at rest, unless the speed is absurd: a test of its own says which speeds they refuse.
    fn speed<T: Real, M: Motion>(&self) -> Speed<T> {
        if !M::AT_SPEED && self.omega.abs() < 1e5 {
            Speed::REST
        } else {
            Speed::rad_per_s(T::of(self.omega))
        }
    }
}

/// A solution in doubles. Freedoms that the ring does not have are zero, and of stiffness 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    pub status: Status<f32>,
    pub freedoms: usize,
    pub u: [f64; 5],
    pub load: [f64; 5],
    pub k: [[f64; 5]; 5],
    pub balls: Vec<BallState<f64>>,
    /// Estimated errors of displacement, force and stiffness.
    pub estimate: [f64; 3],
}

fn identity() -> [[f64; 5]; 5] {
    from_fn(|i| from_fn(|j| f64::from(u8::from(i == j))))
}

fn in_doubles<T: Real>(values: &[T]) -> [f64; 5] {
    from_fn(|i| values.get(i).map_or(0.0, |x| x.to_f64()))
}

fn errors_in_doubles<T: Real>(error: &ErrorEstimate<T>) -> [f64; 3] {
    [error.displacement, error.force, error.stiffness].map(T::to_f64)
}

impl Found {
    pub fn equilibrium(&self) -> Equilibrium {
        Equilibrium {
            displacement: self.u,
            stiffness: self.k,
            balls: self.balls.iter().map(Ball::from).collect(),
        }
    }

    /// Distance from `truth` in the freedoms that the ring has.
    pub fn errors(&self, design: &Design, truth: &Equilibrium) -> Errors {
        let mut whole = self.equilibrium();
        for (i, row) in whole.stiffness.iter_mut().enumerate() {
            for (j, element) in row.iter_mut().enumerate() {
                if i.max(j) >= self.freedoms {
                    *element = truth.stiffness[i][j];
                }
            }
        }
        whole.errors(truth, design.ball_diameter, 0.5 * design.pitch_diameter)
    }

    pub fn largest_force(&self) -> f64 {
        self.equilibrium().largest_force()
    }

    pub fn unloaded_balls(&self) -> usize {
        self.equilibrium().unloaded_balls()
    }

    /// Errors of displacement, force and stiffness that this solution and another one together say they have.
    pub fn stated(&self, other: &Self) -> [f64; 3] {
        from_fn(|i| self.estimate[i] + other.estimate[i])
    }
}

/// A solver of any precision, ball count, motion and number of freedoms.
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
}

/// A solver and its bearing.
struct Asked<T: 'static, const N: usize, S>(&'static Bearing<T, N>, S);

impl<T: Real, const N: usize, M: Motion, const D: usize> AnySolver
    for Asked<T, N, Solver<T, N, M, D>>
{
    fn ask(&mut self, q: &Question) -> Result<Found, Status<f32>> {
        let given: [_; D] = from_fn(|i| q.narrow(i));
        let at = q.speed::<T, M>().with_growth([q.growth()]);
        let s = self
            .1
            .solve(self.0, given, at, &Settings::default())
            .map_err(narrowed)?;
        let mut k = identity();
        for (wide, row) in k.iter_mut().zip(s.stiffness()) {
            *wide = in_doubles(&row);
        }
        Ok(Found {
            status: narrowed(s.status),
            freedoms: D,
            u: in_doubles(&s.displacement),
            load: in_doubles(&s.load),
            k,
            balls: s.balls().map(|ball| widened(&ball)).collect(),
            estimate: errors_in_doubles(&s.error),
        })
    }

    fn reset(&mut self) {
        self.1.reset();
    }
}

impl<T: Real, const N: usize, M: Motion> AnySolver for Asked<T, N, AxialSolver<T, M>> {
    fn ask(&mut self, q: &Question) -> Result<Found, Status<f32>> {
        let at = q.speed::<T, M>().with_growth([q.growth()]);
        let s = self
            .1
            .solve(self.0, q.narrow::<T>(0), at, &Settings::default())
            .map_err(narrowed)?;
        let mut k = identity();
        k[0][0] = s.stiffness().to_f64();
        let first = widened(&s.ball());
        let ball = |j| {
            let mut ball = first;
            ball.azimuth += TAU * j as f64 / N as f64;
            ball
        };
        Ok(Found {
            status: narrowed(s.status),
            freedoms: 1,
            u: in_doubles(&[s.displacement]),
            load: in_doubles(&[s.load]),
            k,
            balls: (0..N).map(ball).collect(),
            estimate: errors_in_doubles(&s.error),
        })
    }

    fn reset(&mut self) {
        self.1.reset();
    }
}

fn of_motion<T: Real, const N: usize, M: Motion>(
    bearing: &'static Bearing<T, N>,
    freedoms: usize,
) -> Box<dyn AnySolver> {
    match freedoms {
        1 => Box::new(Asked(bearing, AxialSolver::<T, M>::of())),
        3 => Box::new(Asked(bearing, Solver::<T, N, M, 3>::of())),
        5 => Box::new(Asked(bearing, Solver::<T, N, M, 5>::of())),
        _ => panic!("no ring has {freedoms} freedoms"),
    }
}

/// A solver for a bearing that lives as long as the test.
fn of_count<T: Real, const N: usize>(
    design: &Design,
    balls: Balls,
    freedoms: usize,
) -> Box<dyn AnySolver> {
    let bearing = Box::leak(Box::new(Bearing::<T, N>::of(design).unwrap()));
    match balls {
        Balls::Static => of_motion::<T, N, Static>(bearing, freedoms),
        Balls::Centrifugal => of_motion::<T, N, Centrifugal>(bearing, freedoms),
        Balls::CentrifugalOuter => {
            of_motion::<T, N, Centrifugal<OuterRaceControl>>(bearing, freedoms)
        }
        Balls::Free => of_motion::<T, N, RacewayControlFree>(bearing, freedoms),
        Balls::Outer => of_motion::<T, N, OuterRaceControl>(bearing, freedoms),
        Balls::Inner => of_motion::<T, N, InnerRaceControl>(bearing, freedoms),
    }
}

/// Ball counts that there are solvers for: each takes its time to compile.
pub const BALL_COUNTS: [usize; 4] = [5, 8, 16, 33];

/// A solver for a ring of 1, 3 or 5 freedoms.
pub fn ring_solver(
    design: &Design,
    n: usize,
    precision: Precision,
    balls: Balls,
    freedoms: usize,
) -> Box<dyn AnySolver> {
    match (n, precision) {
        (5, Precision::F32) => of_count::<f32, 5>(design, balls, freedoms),
        (5, Precision::F64) => of_count::<f64, 5>(design, balls, freedoms),
        (8, Precision::F32) => of_count::<f32, 8>(design, balls, freedoms),
        (8, Precision::F64) => of_count::<f64, 8>(design, balls, freedoms),
        (16, Precision::F32) => of_count::<f32, 16>(design, balls, freedoms),
        (16, Precision::F64) => of_count::<f64, 16>(design, balls, freedoms),
        (33, Precision::F32) => of_count::<f32, 33>(design, balls, freedoms),
        (33, Precision::F64) => of_count::<f64, 33>(design, balls, freedoms),
        _ => panic!("no solver for {n} balls"),
    }
}

/// A solver of five freedoms.
pub fn solver(design: &Design, n: usize, precision: Precision, balls: Balls) -> Box<dyn AnySolver> {
    ring_solver(design, n, precision, balls, 5)
}

/// A solver of one ball for all.
pub fn axial_solver(
    design: &Design,
    n: usize,
    precision: Precision,
    balls: Balls,
) -> Box<dyn AnySolver> {
    ring_solver(design, n, precision, balls, 1)
}

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

/// Largest component of a vector, each in its `unit`.
pub fn size(vector: [f64; 5], unit: [f64; 5]) -> f64 {
    (0..5).fold(0.0, |m, i| worse(m, (vector[i] * unit[i]).abs()))
}

/// Error of a vector over its largest component, each in its `unit`.
pub fn vector_error(found: [f64; 5], truth: [f64; 5], unit: [f64; 5]) -> f64 {
    size(from_fn(|i| found[i] - truth[i]), unit) / size(truth, unit)
}

/// Largest difference of two solutions, by the measures of `host_tests::compare`.
pub fn apart(design: &Design, a: &Found, b: &Found) -> f64 {
    let e = a.errors(design, &b.equilibrium());
    [e.displacement, e.contact_angle, e.force, e.stiffness]
        .into_iter()
        .fold(0.0, worse)
}
