//! Any bearing, any settings, any sequence of loads, displacements, speeds and growths. There is no panic, every
//! figure of an answer is a number, iterations keep to their limit, and a refusal does no harm.
#![no_main]

use arbitrary::{Arbitrary, Error, Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use spindle_bearing::{
    AxialSolver, BallState, Bearing, Centrifugal, Design, ErrorEstimate, FreeContact, Full, Given,
    Growth, InnerRaceControl, Material, Motion, OuterRaceControl, Real, RingVector, Settings,
    Solver, Speed, Static, Status,
};
use std::array::from_fn;
use std::f64::consts::PI;
use std::fmt::Debug;

/// Steps of one run: enough for warm starts, few enough for many runs.
const MOST_STEPS: usize = 8;
/// Bound on the iteration limit, so that no run is slow because it is told to be.
const MOST_ITERATIONS: u16 = 400;

#[derive(Debug, Arbitrary)]
struct Run {
    /// Numbers of the ball count, the precision, the motion and the freedoms of the ring.
    scene: [u8; 4],
    #[arbitrary(with = design)]
    design: Design,
    /// The default, or these.
    #[arbitrary(with = settings)]
    settings: Option<Settings<f64>>,
    #[arbitrary(with = steps)]
    steps: Vec<Step>,
}

/// Numbers relative to the bearing's scale.
#[derive(Debug)]
enum Step {
    /// Loads, or displacements, and a speed.
    Solve([Given<f64>; 5], f64),
    /// The last loads, displacements and speed times these: mostly a warm start.
    Nudge([f64; 5], f64),
    /// Axial and radial growth of the rings, growth of the balls: for the solves to come.
    Grow([f64; 3]),
    Reset,
}

/// Mostly a number of the range, sometimes an end of it, now and then any number at all.
fn number(u: &mut Unstructured, least: f64, most: f64) -> Result<f64> {
    Ok(match u.arbitrary::<u8>()? {
        0..=223 => least + (most - least) * f64::from(u.arbitrary::<u16>()?) / 65535.0,
        224..=235 => least,
        236..=247 => most,
        248..=251 => f32::from_bits(u.arbitrary()?).into(),
        252.. => f64::from_bits(u.arbitrary()?),
    })
}

/// A number with all orders of magnitude alike.
fn magnitude(u: &mut Unstructured, least: f64, most: f64) -> Result<f64> {
    Ok(10f64.powf(number(u, least.log10(), most.log10())?))
}

/// Of either sign, or nothing, or any number at all.
fn signed(u: &mut Unstructured, least: f64, most: f64) -> Result<f64> {
    Ok(match u.arbitrary::<u8>()? {
        0..=79 => 0.0,
        80..=119 => -magnitude(u, least, most)?,
        120..=247 => magnitude(u, least, most)?,
        248.. => f64::from_bits(u.arbitrary()?),
    })
}

fn material(u: &mut Unstructured) -> Result<Material> {
    Ok(match u.arbitrary::<u8>()? {
        0..=127 => Material::STEEL,
        128..=191 => Material::SILICON_NITRIDE,
        192.. => Material {
            youngs_modulus: magnitude(u, 1e6, 1e13)?,
            poissons_ratio: number(u, 0.0, 0.5)?,
            density: magnitude(u, 1.0, 1e5)?,
        },
    })
}

fn design(u: &mut Unstructured) -> Result<Design> {
    let mut design = Design {
        ball_diameter: magnitude(u, 1e-5, 10.0)?,
        pitch_diameter: magnitude(u, 1.01, 1e4)?,
        inner_groove_factor: number(u, 0.501, 0.7)?,
        outer_groove_factor: number(u, 0.501, 0.7)?,
        free_contact: FreeContact::Angle(number(u, 0.0, 1.4)?),
        inner_shoulder_angle: number(u, 1.4, 1.6)?,
        outer_shoulder_angle: number(u, 1.4, 1.6)?,
        first_ball: number(u, -7.0, 7.0)?,
        ring: material(u)?,
        ball: material(u)?,
    };
    design.pitch_diameter *= design.ball_diameter;
    if u.arbitrary()? {
        let clearance = number(u, 0.0, 1.66)? * design.centre_distance();
        design.free_contact = FreeContact::DiametralClearance(clearance);
    }
    Ok(design)
}

fn settings(u: &mut Unstructured) -> Result<Option<Settings<f64>>> {
    let settings = Settings {
        max_iterations: u.int_in_range(0..=MOST_ITERATIONS)?,
        tolerance: signed(u, 1e-20, 1.0)?,
    };
    Ok(u.ratio(1, 4)?.then_some(settings))
}

/// Mostly a load.
fn given(u: &mut Unstructured) -> Result<Given<f64>> {
    Ok(match u.ratio(3, 4)? {
        true => Given::Load(signed(u, 1e-12, 10.0)?),
        false => Given::Displacement(signed(u, 1e-9, 3.0)?),
    })
}

fn several<T, const K: usize>(one: impl FnMut(usize) -> Result<T>) -> Result<[T; K]> {
    let several: Result<Vec<T>> = (0..K).map(one).collect();
    several?.try_into().map_err(|_| Error::IncorrectFormat)
}

fn steps(u: &mut Unstructured) -> Result<Vec<Step>> {
    let mut steps = Vec::new();
    while steps.len() < MOST_STEPS && !u.is_empty() {
        steps.push(match u.int_in_range(0..=7)? {
            0..=3 => Step::Solve(several(|_| given(u))?, signed(u, 1e-6, 3.0)?),
            4..=5 => Step::Nudge(several(|_| signed(u, 0.3, 3.0))?, signed(u, 0.3, 3.0)?),
            6 => Step::Grow(several(|_| signed(u, 1e-6, 0.3))?),
            _ => Step::Reset,
        });
    }
    Ok(steps)
}

fuzz_target!(|run: Run| {
    match run.scene[0] % 4 {
        0 => with_balls::<3>(&run),
        1 => with_balls::<8>(&run),
        2 => with_balls::<16>(&run),
        _ => with_balls::<31>(&run),
    }
});

fn with_balls<const N: usize>(run: &Run) {
    match run.scene[1] % 2 {
        0 => in_precision::<f32, N>(run),
        _ => in_precision::<f64, N>(run),
    }
}

fn in_precision<T: Real, const N: usize>(run: &Run) {
    match T::bearing::<N>(&run.design) {
        Err(error) => assert!(!(error.value >= error.least && error.value <= error.most)),
        Ok(bearing) => match run.scene[2] % 5 {
            0 => with_ring::<T, N, Static>(run, &bearing),
            1 => with_ring::<T, N, Centrifugal>(run, &bearing),
            2 => with_ring::<T, N, Full>(run, &bearing),
            3 => with_ring::<T, N, Full<OuterRaceControl>>(run, &bearing),
            _ => with_ring::<T, N, Full<InnerRaceControl>>(run, &bearing),
        },
    }
}

fn with_ring<T: Real, const N: usize, M: Motion + Copy + Debug>(
    run: &Run,
    bearing: &Bearing<T, N>,
) {
    match run.scene[3] % 3 {
        0 => {
            let fresh = || AxialSolver::<T, N, M>::of(bearing);
            solve(run, N, fresh, AxialSolver::reset, ask_axial);
        }
        1 => {
            let fresh = || Solver::<T, N, M, 3>::of(bearing);
            solve(run, N, fresh, Solver::reset, ask);
        }
        _ => {
            let fresh = || Solver::<T, N, M, 5>::of(bearing);
            solve(run, N, fresh, Solver::reset, ask);
        }
    }
}

/// Question to a solver.
#[derive(Debug, Clone, Copy)]
struct Question<T> {
    /// Of five freedoms; a ring with fewer has the first ones.
    given: [Given<T>; 5],
    omega: T,
    growth: Growth<T>,
}

/// Every figure of an answer.
#[derive(Debug)]
struct Answer<T> {
    status: Status<T>,
    iterations: u16,
    error: ErrorEstimate<T>,
    figures: Vec<T>,
    balls: Vec<BallState<T>>,
}

type Asked<T> = std::result::Result<Answer<T>, Status<T>>;

/// Asks a solver of a ring with 3 or 5 freedoms.
fn ask<T: Real, const N: usize, M: Motion, const D: usize>(
    solver: &mut Solver<'_, T, N, M, D>,
    question: &Question<T>,
    settings: &Settings<T>,
) -> Asked<T>
where
    [T; D]: RingVector,
{
    let given = from_fn(|i| question.given[i]);
    let speed = Speed::rad_per_s(question.omega);
    let s = solver.solve_at(&given, speed, &question.growth, settings)?;
    assert!(s.inner_forces().eq(s.balls().map(|ball| ball.q_i)));
    let figures = s.stiffness().into_iter().flatten();
    let figures = figures.chain(s.displacement).chain(s.load);
    Ok(Answer {
        status: s.status,
        iterations: s.iterations,
        error: s.error,
        figures: figures.chain(s.cage_speeds()).collect(),
        balls: s.balls().collect(),
    })
}

/// Asks a solver of a ring with one freedom.
fn ask_axial<T: Real, const N: usize, M: Motion>(
    solver: &mut AxialSolver<'_, T, N, M>,
    question: &Question<T>,
    settings: &Settings<T>,
) -> Asked<T> {
    let speed = Speed::rad_per_s(question.omega);
    let s = solver.solve_at(question.given[0], speed, &question.growth, settings)?;
    Ok(Answer {
        status: s.status,
        iterations: s.iterations,
        error: s.error,
        figures: vec![s.stiffness(), s.displacement, s.load],
        balls: vec![s.ball()],
    })
}

/// Load, speed and displacement that the bearing can take, to an order of magnitude.
struct Scale {
    load: [f64; 5],
    speed: f64,
    displacement: [f64; 5],
}

impl Scale {
    fn of(design: &Design, balls: usize) -> Self {
        let diameter = design.ball_diameter;
        let radius = design.pitch_diameter / 2.0;
        let distance = design.centre_distance();
        let softer = design.ring.youngs_modulus.min(design.ball.youngs_modulus);
        let force = softer * diameter.sqrt() * distance.powf(1.5);
        let mass = design.ball.density * PI / 6.0 * diameter.powi(3);
        let lengths = [1.0, 1.0, 1.0, radius, radius];
        Self {
            load: lengths.map(|length| force * balls as f64 * length),
            speed: (force / (mass * radius)).sqrt(),
            displacement: lengths.map(|length| distance / length),
        }
    }

    fn given<T: Real>(&self, i: usize, given: Given<f64>) -> Given<T> {
        match given {
            Given::Load(x) => Given::Load(T::of(x * self.load[i])),
            Given::Displacement(x) => Given::Displacement(T::of(x * self.displacement[i])),
        }
    }
}

fn times<T: Real>(given: Given<T>, factor: f64) -> Given<T> {
    match given {
        Given::Load(x) => Given::Load(x * T::of(factor)),
        Given::Displacement(x) => Given::Displacement(x * T::of(factor)),
    }
}

fn solve<T: Real, S: Copy>(
    run: &Run,
    balls: usize,
    fresh: impl Fn() -> S,
    reset: impl Fn(&mut S),
    ask: impl Fn(&mut S, &Question<T>, &Settings<T>) -> Asked<T>,
) {
    let scale = Scale::of(&run.design, balls);
    let settings = run.settings.map_or_else(Settings::default, |s| Settings {
        max_iterations: s.max_iterations,
        tolerance: T::of(s.tolerance),
    });
    let most = settings.max_iterations.max(1);
    // What a solver that was not harmed is asked: something near, so that it would start from what it remembers.
    let probe = |mut solver: S, near: &Question<T>| {
        let question = Question {
            given: near.given.map(|given| times(given, 0.9)),
            ..*near
        };
        format!("{:?}", ask(&mut solver, &question, &Settings::default()))
    };
    let mut solver = fresh();
    let light = [1e-4, 1e-5, 0.0, 1e-6, 0.0];
    let light = from_fn(|i| scale.given(i, Given::Load(light[i])));
    let mut question = Question {
        given: light,
        omega: T::ZERO,
        growth: Growth::NONE,
    };
    // The last question that was not refused for what it is.
    let mut tried = question;
    for step in &run.steps {
        let before = solver;
        match step {
            Step::Reset => {
                reset(&mut solver);
                continue;
            }
            Step::Grow(lengths) => {
                let [axial, radial, ball] = lengths.map(|x| T::of(x * scale.displacement[0]));
                question.growth = Growth {
                    axial,
                    radial,
                    ball,
                };
                continue;
            }
            Step::Solve(given, omega) => {
                question.given = from_fn(|i| scale.given(i, given[i]));
                question.omega = T::of(omega * scale.speed);
            }
            Step::Nudge(factors, factor) => {
                question.given = from_fn(|i| times(question.given[i], factors[i]));
                question.omega = question.omega * T::of(*factor);
            }
        }
        let ended = inspect(ask(&mut solver, &question, &settings), most);
        match ended {
            Status::NotFinite { value, .. } => assert!(!value.is_finite()),
            Status::OutOfRange { value, limit, .. } => {
                assert!(value.is_finite() && value.abs() > limit);
            }
            _ => {}
        }
        let of_input = matches!(
            ended,
            Status::NotFinite { .. } | Status::OutOfRange { .. } | Status::Unloaded
        );
        if of_input {
            let (after, before) = (probe(solver, &tried), probe(before, &tried));
            assert_eq!(
                after, before,
                "{ended:?} did not leave the solver as it was"
            );
            continue;
        }
        tried = question;
        if matches!(
            ended,
            Status::Diverged { .. } | Status::Indeterminate { .. } | Status::Unseated { .. }
        ) {
            let (after, fresh) = (probe(solver, &tried), probe(fresh(), &tried));
            assert_eq!(after, fresh, "{ended:?} left something behind");
        }
    }
}

/// Looks at every figure of an answer; returns how the solve ended.
fn inspect<T: Real>(answer: Asked<T>, most_iterations: u16) -> Status<T> {
    let is_good = |status| matches!(status, Status::Converged | Status::PrecisionLimit);
    let answer = match answer {
        Ok(answer) => answer,
        Err(status) => {
            assert!(!is_good(status), "{status:?}");
            return status;
        }
    };
    assert!(is_good(answer.status) && answer.iterations <= most_iterations);
    let error = &answer.error;
    for estimate in [error.displacement, error.force, error.stiffness] {
        assert!(estimate >= T::ZERO, "{error:?}");
    }
    let of_balls = answer.balls.iter().flat_map(|ball| {
        assert!(ball.q_i >= T::ZERO && ball.q_o >= T::ZERO, "{ball:?}");
        let (angles, inertia) = (
            [ball.azimuth, ball.alpha_i, ball.alpha_o],
            [ball.centrifugal_force, ball.gyroscopic_moment],
        );
        let contacts = [ball.q_i, ball.q_o, ball.delta_i, ball.delta_o];
        angles.into_iter().chain(contacts).chain(inertia)
    });
    let mut figures = answer.figures.iter().copied().chain(of_balls);
    assert!(figures.all(|x| x.is_finite()), "{answer:?}");
    answer.status
}
