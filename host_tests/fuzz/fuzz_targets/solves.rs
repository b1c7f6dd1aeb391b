//! Any bearing, any settings, any sequence of loads, displacements and speeds: no panic, every figure
//! of an answer a number, no more sweeps than allowed, and a refusal does no harm.
#![no_main]

use arbitrary::{Arbitrary, Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use spindle_bearing::{
    Bearing, Design, FreeContact, Full, InnerRaceControl, Material, Motion, OuterRaceControl,
    RacewayControlFree, Real, Settings, Solution, Solver, Static, Status,
};
use std::f64::consts::PI;
use std::fmt::Debug;

/// Steps of one run: enough for warm starts, few enough for many runs.
const MOST_STEPS: usize = 8;
/// Bound on the bound on sweeps, so that no run is slow because it is told to be.
const MOST_SWEEPS: u16 = 400;

#[derive(Debug, Arbitrary)]
struct Run {
    balls: Balls,
    precision: Precision,
    scene: Scene,
    design: AnyDesign,
    settings: AnySettings,
    #[arbitrary(with = steps)]
    steps: Vec<Step>,
}

#[derive(Debug, Arbitrary)]
enum Balls {
    Three,
    Eight,
    Sixteen,
    ThirtyOne,
}

#[derive(Debug, Arbitrary)]
enum Precision {
    Single,
    Double,
}

#[derive(Debug, Arbitrary)]
enum Scene {
    Static,
    Free,
    Outer,
    Inner,
}

#[derive(Debug)]
struct AnyDesign(Design);

/// The default, or these.
#[derive(Debug)]
struct AnySettings(Option<Settings<f64>>);

/// Numbers relative to what the bearing can take.
#[derive(Debug)]
enum Step {
    Load([f64; 5], f64),
    /// The last load and speed times these: mostly a warm start.
    Nudge([f64; 5], f64),
    Displacement([f64; 5], f64),
    Forget,
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

/// The same, with all orders of magnitude alike.
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

fn five(u: &mut Unstructured, least: f64, most: f64) -> Result<[f64; 5]> {
    let mut five = [0.0; 5];
    for x in &mut five {
        *x = signed(u, least, most)?;
    }
    Ok(five)
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

impl<'a> Arbitrary<'a> for AnyDesign {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
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
        Ok(Self(design))
    }
}

impl<'a> Arbitrary<'a> for AnySettings {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
        Ok(Self(match u.arbitrary::<u8>()? {
            0..=191 => None,
            192.. => Some(Settings {
                max_sweeps: u.int_in_range(0..=MOST_SWEEPS)?,
                tolerance: signed(u, 1e-20, 1.0)?,
            }),
        }))
    }
}

fn steps(u: &mut Unstructured) -> Result<Vec<Step>> {
    u.arbitrary_iter()?.take(MOST_STEPS).collect()
}

impl<'a> Arbitrary<'a> for Step {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
        Ok(match u.int_in_range(0..=7)? {
            0..=3 => Self::Load(five(u, 1e-12, 10.0)?, signed(u, 1e-6, 3.0)?),
            4..=5 => Self::Nudge(five(u, 0.3, 3.0)?, signed(u, 0.3, 3.0)?),
            6 => Self::Displacement(five(u, 1e-9, 3.0)?, signed(u, 1e-6, 3.0)?),
            _ => Self::Forget,
        })
    }
}

fuzz_target!(|run: Run| {
    match run.balls {
        Balls::Three => with_balls::<3>(&run),
        Balls::Eight => with_balls::<8>(&run),
        Balls::Sixteen => with_balls::<16>(&run),
        Balls::ThirtyOne => with_balls::<31>(&run),
    }
});

fn with_balls<const N: usize>(run: &Run) {
    match run.precision {
        Precision::Single => in_precision::<f32, N>(run),
        Precision::Double => in_precision::<f64, N>(run),
    }
}

fn in_precision<T: Real, const N: usize>(run: &Run) {
    match Bearing::<T, N>::build(&run.design.0) {
        Err(error) => assert!(!(error.value >= error.least && error.value <= error.most)),
        Ok(bearing) => match run.scene {
            Scene::Static => solve::<T, N, Static>(run, &bearing),
            Scene::Free => solve::<T, N, Full<RacewayControlFree>>(run, &bearing),
            Scene::Outer => solve::<T, N, Full<OuterRaceControl>>(run, &bearing),
            Scene::Inner => solve::<T, N, Full<InnerRaceControl>>(run, &bearing),
        },
    }
}

/// What the bearing can take, to an order of magnitude.
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
        let (all, tilt) = (force * balls as f64, distance / radius);
        Self {
            load: [all, all, all, all * radius, all * radius],
            speed: (force / (mass * radius)).sqrt(),
            displacement: [distance, distance, distance, tilt, tilt],
        }
    }
}

fn scaled<T: Real>(values: &[f64; 5], scale: &[f64; 5]) -> [T; 5] {
    std::array::from_fn(|i| T::of(values[i] * scale[i]))
}

fn solve<T: Real, const N: usize, M: Motion + Debug>(run: &Run, bearing: &Bearing<T, N>) {
    let scale = Scale::of(&run.design.0, N);
    let settings = run.settings.0.map_or_else(Settings::default, |s| Settings {
        max_sweeps: s.max_sweeps,
        tolerance: T::of(s.tolerance),
    });
    let most = settings.max_sweeps.max(1);
    // What a solver that was not harmed is asked: a load near another, so that it would start from
    // what it remembers of that.
    let probe = |solver: &Solver<T, N, M>, near: &([T; 5], T)| {
        let (mut solver, settings) = (solver.clone(), Settings::default());
        let load = near.0.map(|x| x * T::of(0.9));
        format!("{:?}", solver.solve(load, near.1, &settings))
    };
    let mut solver = Solver::<T, N, M>::new(bearing);
    let (mut load, mut speed) = ([T::ZERO; 5], T::ZERO);
    // The last load and speed that were not refused for what they are.
    let mut tried = (scaled(&[1e-4, 1e-5, 0.0, 1e-6, 0.0], &scale.load), T::ZERO);
    for step in &run.steps {
        let before = solver.clone();
        let ended = match step {
            Step::Forget => {
                solver.forget();
                continue;
            }
            Step::Displacement(displacement, omega) => {
                let displacement = scaled(displacement, &scale.displacement);
                let speed = T::of(omega * scale.speed);
                inspect(solver.law(displacement, speed, &settings), most)
            }
            Step::Load(new, omega) => {
                load = scaled(new, &scale.load);
                speed = T::of(omega * scale.speed);
                inspect(solver.solve(load, speed, &settings), most)
            }
            Step::Nudge(factors, factor) => {
                load = std::array::from_fn(|i| load[i] * T::of(factors[i]));
                speed = speed * T::of(*factor);
                inspect(solver.solve(load, speed, &settings), most)
            }
        };
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
            let (after, before) = (probe(&solver, &tried), probe(&before, &tried));
            assert_eq!(
                after, before,
                "{ended:?} did not leave the solver as it was"
            );
            continue;
        }
        if !matches!(step, Step::Displacement(..)) {
            tried = (load, speed);
        }
        if matches!(
            ended,
            Status::Diverged { .. } | Status::Indeterminate { .. }
        ) {
            let (after, fresh) = (probe(&solver, &tried), probe(&Solver::new(bearing), &tried));
            assert_eq!(after, fresh, "{ended:?} left something behind");
        }
    }
}

/// Looks at every figure of an answer; returns how the solve ended.
fn inspect<T: Real, const N: usize, M: Motion>(
    answer: std::result::Result<Solution<'_, T, N, M>, Status<T>>,
    most_sweeps: u16,
) -> Status<T> {
    let solution = match answer {
        Ok(solution) => solution,
        Err(status) => {
            assert!(
                !matches!(
                    status,
                    Status::Converged | Status::PrecisionLimit | Status::SweepLimit
                ),
                "{status:?} without an answer"
            );
            return status;
        }
    };
    let status = solution.status;
    assert!(
        matches!(
            status,
            Status::Converged | Status::PrecisionLimit | Status::SweepLimit
        ),
        "an answer to {status:?}"
    );
    assert!((1..=most_sweeps).contains(&solution.sweeps));
    let numbers = |values: &[T]| values.iter().all(|x| x.is_finite());
    assert!(numbers(&[solution.residual]), "residual");
    assert!(numbers(&solution.displacement), "displacement");
    assert!(numbers(&solution.load), "load");
    assert!(numbers(&solution.stiffness.concat()), "stiffness");
    let (balls, forces) = (solution.balls(), solution.inner_forces());
    assert_eq!((balls.len(), forces.len()), (N, N));
    for (ball, force) in balls.zip(forces) {
        assert!(
            numbers(&[
                ball.azimuth,
                ball.alpha_i,
                ball.alpha_o,
                ball.q_i,
                ball.q_o,
                ball.delta_i,
                ball.delta_o,
                ball.centrifugal_force,
                ball.gyroscopic_moment,
            ]),
            "{status:?}, {ball:?}"
        );
        assert!(ball.q_i >= T::ZERO && ball.q_o >= T::ZERO, "{ball:?}");
        assert!(ball.q_i == force);
    }
    status
}
