//! Solvers of every scene: the ring's freedoms, what is given of each, and how the balls move.

use host_tests::dispatch::{Attitude, Precision, widened};
use host_tests::reference::Reference;
use spindle_bearing::{
    AxialSolver, Bearing, Centrifugal, Full, Given, Growth, Motion, Settings, Solver, Speed, Static,
};
use spindle_bearing::{
    BallState, InnerRaceControl, OuterRaceControl, RacewayControlFree, Real, Status,
};
use std::array::from_fn;

/// What the tables and the tests need of a precision.
pub trait Working: Real {
    const PRECISION: Precision;
}
impl Working for f32 {
    const PRECISION: Precision = Precision::F32;
}
impl Working for f64 {
    const PRECISION: Precision = Precision::F64;
}

/// What the reference build has to leave out to be restricted as a motion is.
pub trait Restricted: Motion {
    const NAME: &'static str;
    const RULE: Attitude;
    fn reference(whole: &Reference) -> Reference;
    fn speed(omega: f64) -> f64 {
        omega
    }
}
impl Restricted for Static {
    const NAME: &'static str = "static";
    const RULE: Attitude = Attitude::Outer;
    fn reference(whole: &Reference) -> Reference {
        whole.clone()
    }
    fn speed(_: f64) -> f64 {
        0.0
    }
}
impl Restricted for Centrifugal<RacewayControlFree> {
    const NAME: &'static str = "centrifugal, race control free";
    const RULE: Attitude = Attitude::Raceless;
    fn reference(whole: &Reference) -> Reference {
        whole.clone().without_gyroscopic_moment()
    }
}
impl Restricted for Full<RacewayControlFree> {
    const NAME: &'static str = "full, race control free";
    const RULE: Attitude = Attitude::Raceless;
    fn reference(whole: &Reference) -> Reference {
        whole.clone()
    }
}
impl Restricted for Full<OuterRaceControl> {
    const NAME: &'static str = "full, outer race control";
    const RULE: Attitude = Attitude::Outer;
    fn reference(whole: &Reference) -> Reference {
        whole.clone()
    }
}
impl Restricted for Full<InnerRaceControl> {
    const NAME: &'static str = "full, inner race control";
    const RULE: Attitude = Attitude::Inner;
    fn reference(whole: &Reference) -> Reference {
        whole.clone()
    }
}

/// An answer in doubles, of as many freedoms as the ring has.
#[derive(Debug, Clone)]
pub struct Found {
    pub u: Vec<f64>,
    pub load: Vec<f64>,
    pub k: Vec<Vec<f64>>,
    /// All balls, or the one that stands for all.
    pub balls: Vec<BallState<f64>>,
    /// The solver's own estimate of its errors of displacement, force and stiffness.
    pub estimate: [f64; 3],
}

fn narrow<T: Real>(given: Given<f64>) -> Given<T> {
    match given {
        Given::Load(x) => Given::Load(T::of(x)),
        Given::Displacement(x) => Given::Displacement(T::of(x)),
    }
}

fn in_doubles<T: Real>(values: &[T]) -> Vec<f64> {
    values.iter().map(|x| x.to_f64()).collect()
}

/// A solver whose precision, ball count, motion and freedoms are known at run time.
pub trait AnySolver {
    /// Answers for as many given values as the ring has freedoms.
    fn ask(&mut self, given: &[Given<f64>], omega: f64) -> Result<Found, Status<f32>>;
}

/// Balls at rest are asked at rest, unless the speed is absurd.
fn turning<T: Real, M: Motion>(omega: f64) -> Speed<T> {
    if !M::AT_SPEED && omega.abs() < 1e5 {
        Speed::REST
    } else {
        Speed::rad_per_s(T::of(omega))
    }
}

impl<T: Real, const N: usize, M: Motion, const D: usize> AnySolver for Solver<'_, T, N, M, D> {
    fn ask(&mut self, given: &[Given<f64>], omega: f64) -> Result<Found, Status<f32>> {
        assert_eq!(given.len(), D);
        let given = from_fn(|i| narrow(given[i]));
        let speed = turning::<T, M>(omega);
        let s = self
            .solve_at(&given, speed, &Growth::NONE, &Settings::default())
            .map_err(Status::to_f32)?;
        Ok(Found {
            u: in_doubles(&s.displacement),
            load: in_doubles(&s.load),
            k: s.stiffness().iter().map(|row| in_doubles(row)).collect(),
            balls: s.balls().map(|ball| widened(&ball)).collect(),
            estimate: [s.error.displacement, s.error.force, s.error.stiffness].map(T::to_f64),
        })
    }
}

impl<T: Real, const N: usize, M: Motion> AnySolver for AxialSolver<'_, T, N, M> {
    fn ask(&mut self, given: &[Given<f64>], omega: f64) -> Result<Found, Status<f32>> {
        let &[given] = given else {
            panic!("{given:?} for one freedom");
        };
        let speed = turning::<T, M>(omega);
        let s = self
            .solve_at(narrow(given), speed, &Growth::NONE, &Settings::default())
            .map_err(Status::to_f32)?;
        Ok(Found {
            u: vec![s.displacement.to_f64()],
            load: vec![s.load.to_f64()],
            k: vec![vec![s.stiffness().to_f64()]],
            balls: vec![widened(&s.ball())],
            estimate: [s.error.displacement, s.error.force, s.error.stiffness].map(T::to_f64),
        })
    }
}

/// A solver without history for a ring of 1, 3 or 5 freedoms.
pub fn solver<T: Real, const N: usize, M: Motion>(
    bearing: &Bearing<T, N>,
    freedoms: usize,
) -> Box<dyn AnySolver + '_> {
    match freedoms {
        1 => Box::new(AxialSolver::<T, N, M>::of(bearing)),
        3 => Box::new(Solver::<T, N, M, 3>::of(bearing)),
        5 => Box::new(Solver::<T, N, M, 5>::of(bearing)),
        _ => panic!("no ring has {freedoms} freedoms"),
    }
}
