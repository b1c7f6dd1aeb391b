//! Solvers of bearings whose precision, ball count, motion and freedoms are known at run time.

use judge::compare::{Equilibrium, Errors, stiffness_error, worse};
use proptest::strategy::Strategy;
use solvers::dispatch::{Precision, narrowed, widened};
pub use solvers::{Answer, AnySolver, Balls};
use solvers::{Choices, RowAnswer, given, in_doubles, with_solver};
use spindle_bearing::{
    AxialSolver, BallState, Bearing, Centrifugal, Design, ErrorEstimate, Growth, InnerRaceControl,
    Motion, OuterRaceControl, RacewayControlFree, Real, Solver, Speed, Static, Status,
};
use spindle_file::mounting::growths;
pub use spindle_file::plan::Question;
use spindle_file::plan::{MOST_BALLS, Plan};
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

/// A vector of forces or displacements of a bearing or a set that is mirrored along its axis.
pub fn mirrored([x, y, z, ty, tz]: [f64; 5]) -> [f64; 5] {
    [-x, y, z, -ty, -tz]
}

/// Largest error of an answer whose mirrored one is `other`: of displacement, stiffness, contact forces and frequencies.
pub fn off_mirror(one: &Answer, other: &Answer, design: &Design) -> f64 {
    let u = mirrored(other.displacement);
    let signs = mirrored([1.0; 5]);
    let k = from_fn(|i| mirrored(other.stiffness[i]).map(|k| signs[i] * k));
    let of_shaft = worse(
        vector_error(u, one.displacement, lengths(design)),
        stiffness_error(&k, &one.stiffness),
    );
    one.rows
        .iter()
        .zip(&other.rows)
        .fold(of_shaft, |off, (a, b)| {
            let largest = a.balls.iter().map(|ball| ball.q_o).fold(0.0, f64::max);
            let forces = a.balls.iter().zip(&b.balls);
            let forces = forces.flat_map(|(a, b)| [a.q_i - b.q_i, a.q_o - b.q_o]);
            let off = forces.fold(off, |off, force| worse(off, force.abs() / largest));
            let (a, b) = (&a.frequencies, &b.frequencies);
            let both = [(a.cage, b.cage), (a.outer_race, b.outer_race)];
            let moved = both.into_iter().filter(|(a, b)| a != b);
            moved.fold(off, |off, (a, b)| worse(off, (a / b - 1.0).abs()))
        })
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

/// Errors of displacement, force and stiffness that two answers together say they have.
pub fn stated(one: &Answer, other: &Answer) -> [f64; 3] {
    from_fn(|i| one.error[i] + other.error[i])
}

/// A solver, and a bearing of so many balls that lives as long as the test.
#[derive(Clone)]
struct Asked<T: 'static, S> {
    bearing: &'static Bearing<T, MOST_BALLS>,
    count: usize,
    solver: S,
    choices: Choices,
}

/// Balls at rest are asked at rest, unless the speed is absurd: a test of its own says which speeds they refuse.
fn speed<T: Real, M: Motion>(question: &Question) -> Speed<T> {
    match !M::AT_SPEED && question.omega.abs() < 1e5 {
        true => Speed::REST,
        false => Speed::rad_per_s(T::of(question.omega)),
    }
}

/// The answer of a ring. Freedoms that it does not have are zero, and of stiffness 1.
fn answer<T: Real, const D: usize>(
    (status, iterations): (Status<T>, u16),
    [u, load]: [[T; D]; 2],
    k: [[T; D]; D],
    error: &ErrorEstimate<T>,
    balls: Vec<BallState<f64>>,
) -> Answer {
    let vector = |of: [T; D]| from_fn(|i| of.get(i).map_or(0.0, |x| x.to_f64()));
    let element = |i: usize, j: usize| match i.max(j) < D {
        true => k[i][j].to_f64(),
        false => f64::from(u8::from(i == j)),
    };
    Answer {
        status: narrowed(status),
        iterations,
        displacement: vector(u),
        stiffness: from_fn(|i| from_fn(|j| element(i, j))),
        load: vector(load),
        at: Vec::new(),
        spring_closure: 0.0,
        rows: vec![RowAnswer {
            force: vector(load),
            balls,
            ..RowAnswer::default()
        }],
        error: in_doubles(error),
    }
}

impl<T: Real, M: Motion, const D: usize> AnySolver for Asked<T, Solver<T, MOST_BALLS, M, D>> {
    fn solve(&mut self, question: &Question) -> Result<Answer, Status<f32>> {
        let at = speed::<T, M>(question).with_growth(growths(&question.growth));
        let (given, settings) = (given::<T, D>(question), self.choices.settings());
        let solved = self.solver.solve(self.bearing, given, at, &settings);
        let s = solved.map_err(narrowed)?;
        let balls = s.balls().map(|ball| widened(&ball)).collect();
        let (ended, vectors) = ((s.status, s.iterations), [s.displacement, s.load]);
        Ok(answer(ended, vectors, s.stiffness(), &s.error, balls))
    }

    fn choose(&mut self, choices: &Choices) {
        self.choices = *choices;
    }

    fn reset(&mut self) {
        self.solver.reset();
    }

    fn copy(&self) -> Box<dyn AnySolver + '_> {
        Box::new(self.clone())
    }
}

impl<T: Real, M: Motion> AnySolver for Asked<T, AxialSolver<T, M>> {
    fn solve(&mut self, question: &Question) -> Result<Answer, Status<f32>> {
        let at = speed::<T, M>(question).with_growth(growths(&question.growth));
        let ([given], settings) = (given::<T, 1>(question), self.choices.settings());
        let solved = self.solver.solve(self.bearing, given, at, &settings);
        let s = solved.map_err(narrowed)?;
        let mut balls = vec![widened(&s.ball()); self.count];
        for (j, ball) in balls.iter_mut().enumerate() {
            ball.azimuth += TAU * j as f64 / self.count as f64;
        }
        let (ended, vectors) = ((s.status, s.iterations), [[s.displacement], [s.load]]);
        Ok(answer(ended, vectors, [[s.stiffness()]], &s.error, balls))
    }

    fn choose(&mut self, choices: &Choices) {
        self.choices = *choices;
    }

    fn reset(&mut self) {
        self.solver.reset();
    }

    fn copy(&self) -> Box<dyn AnySolver + '_> {
        Box::new(self.clone())
    }
}

fn of_motion<T: Real, M: Motion>(
    design: &Design,
    count: usize,
    freedoms: usize,
) -> Box<dyn AnySolver> {
    let bearing = Box::leak(Box::new(Bearing::with_balls(design, count).unwrap()));
    fn asked<T, S>(
        bearing: &'static Bearing<T, MOST_BALLS>,
        count: usize,
        solver: S,
    ) -> Box<Asked<T, S>> {
        Box::new(Asked {
            bearing,
            count,
            solver,
            choices: Choices::default(),
        })
    }
    match freedoms {
        1 => asked(bearing, count, AxialSolver::<T, M>::of()),
        3 => asked(bearing, count, Solver::<T, MOST_BALLS, M, 3>::of()),
        5 => asked(bearing, count, Solver::<T, MOST_BALLS, M, 5>::of()),
        _ => panic!("no ring has {freedoms} freedoms"),
    }
}

fn of_precision<T: Real>(
    design: &Design,
    n: usize,
    balls: Balls,
    freedoms: usize,
) -> Box<dyn AnySolver> {
    let of = match balls {
        Balls::Static => of_motion::<T, Static>,
        Balls::Centrifugal => of_motion::<T, Centrifugal>,
        Balls::CentrifugalOuter => of_motion::<T, Centrifugal<OuterRaceControl>>,
        Balls::Free => of_motion::<T, RacewayControlFree>,
        Balls::Outer => of_motion::<T, OuterRaceControl>,
        Balls::Inner => of_motion::<T, InnerRaceControl>,
    };
    of(design, n, freedoms)
}

/// A solver for a ring of 1, 3 or 5 freedoms.
pub fn ring_solver(
    design: &Design,
    n: usize,
    precision: Precision,
    balls: Balls,
    freedoms: usize,
) -> Box<dyn AnySolver> {
    match precision {
        Precision::F32 => of_precision::<f32>(design, n, balls, freedoms),
        Precision::F64 => of_precision::<f64>(design, n, balls, freedoms),
    }
}

/// The answer of a spindle from nothing.
pub fn ask(
    plan: &Plan,
    balls: Balls,
    precision: Precision,
    question: &Question,
) -> Result<Answer, Status<f32>> {
    let asked = with_solver(plan, balls, precision, |solver| solver.solve(question));
    asked.unwrap_or_else(|e| panic!("{e}"))
}

/// The answer of a spindle from nothing, if it can be built and has one.
pub fn found(
    plan: &Plan,
    balls: Balls,
    precision: Precision,
    question: &Question,
) -> Option<Answer> {
    let asked = with_solver(plan, balls, precision, |solver| solver.solve(question));
    asked.ok()?.ok()
}

/// A solver of five freedoms.
pub fn solver(design: &Design, n: usize, precision: Precision, balls: Balls) -> Box<dyn AnySolver> {
    ring_solver(design, n, precision, balls, 5)
}

/// Distance from `truth` in the first freedoms, which the ring has.
pub fn errors(found: &Answer, design: &Design, truth: &Equilibrium, freedoms: usize) -> Errors {
    let mut whole = Equilibrium::from(found);
    for (i, row) in whole.stiffness.iter_mut().enumerate() {
        for (j, element) in row.iter_mut().enumerate() {
            if i.max(j) >= freedoms {
                *element = truth.stiffness[i][j];
            }
        }
    }
    whole.errors(truth, design)
}

/// A solution in double precision from nothing.
pub fn cold(design: &Design, n: usize, balls: Balls, load: [f64; 5], omega: f64) -> Answer {
    solver(design, n, Precision::F64, balls).answer(&Question::load(load, omega))
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

/// Largest difference of two solutions, by the measures of `judge::compare`.
pub fn apart(design: &Design, a: &Answer, b: &Answer) -> f64 {
    let e = errors(a, design, &Equilibrium::from(b), 5);
    [e.displacement, e.contact_angle, e.force, e.stiffness]
        .into_iter()
        .fold(0.0, worse)
}
