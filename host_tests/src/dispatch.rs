//! From ball count, precision and attitude rule known at run time to the solver, which wants them
//! at compile time.
//!
//! The solver is generic over the ball count and owns no memory; a host program that reads the
//! bearing from a file needs one compiled for every ball count. Only thin wrappers are: what is
//! long in the solver does not depend on the ball count.

use spindle_bearing::{
    BallMotion, BallState, ContactPatch, Design, DesignError, ErrorEstimate, Frequencies,
    InnerRaceControl, LimitSet, Limits, OuterRaceControl, RacewayControlFree, Real, Status,
};
use spindle_bearing::{Bearing, Full, Motion, Settings, Solver, Speed, Static};
use std::fmt;
use std::ops::RangeInclusive;

/// Ball counts that a solver is compiled for.
pub const BALL_COUNTS: RangeInclusive<usize> = 3..=64;

/// The working precision of a solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// Single precision, as the firmware computes
    F32,
    /// Double precision
    F64,
}

impl Precision {
    /// `value`, a number of this precision, with as few digits as read back to exactly that number
    /// in this precision.
    pub fn show(self, value: f64) -> Shown {
        Shown {
            value,
            precision: self,
        }
    }
}

/// A number about to be printed: see [`Precision::show`].
#[derive(Debug, Clone, Copy)]
pub struct Shown {
    value: f64,
    precision: Precision,
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Rust's own formatting of floats is the shortest that reads back; only where to switch to
        // an exponent is ours to say.
        let size = self.value.abs();
        let plain = self.value == 0.0 || !size.is_finite() || (1e-4..1e16).contains(&size);
        match (self.precision, plain) {
            (Precision::F32, true) => write!(f, "{}", self.value as f32),
            (Precision::F32, false) => write!(f, "{:e}", self.value as f32),
            (Precision::F64, true) => write!(f, "{}", self.value),
            (Precision::F64, false) => write!(f, "{:e}", self.value),
        }
    }
}

/// The rule for the axis about which a ball turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Attitude {
    /// Raceway-control-free: from d'Alembert's principle, no race presumed to be in control
    Raceless,
    /// Outer race control: no spin at the outer race
    Outer,
    /// Inner race control: no spin at the inner race; not for loads that lift balls off it
    Inner,
}

/// What a solve gave, widened to double, which is exact.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// How the solve ended, in a word.
    pub status: &'static str,
    /// The figures; or, if there are none, a sentence that says why.
    pub figures: Result<Figures, String>,
}

/// An equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Iterations, those of starts included.
    pub iterations: u16,
    /// Displacement of the inner ring `(dx, dy, dz, ty, tz)`, m and rad.
    pub displacement: [f64; 5],
    /// Stiffness, N and N m per m and rad; rows are forces, columns displacements.
    pub stiffness: [[f64; 5]; 5],
    /// Physical limits that are passed.
    pub limits: LimitSet,
    /// The solver's own estimate of its errors of displacement, force and stiffness, measured as in
    /// [`compare`](crate::compare); none of figures that come from elsewhere.
    pub error: Option<[f64; 3]>,
}

/// What the balls of a row do.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Details {
    /// Where they are, and their forces.
    pub balls: Vec<BallState<f64>>,
    /// How they turn, and how their contacts are pressed.
    pub motions: Vec<BallMotion<f64>>,
    /// Frequencies at which damage is heard.
    pub frequencies: Frequencies<f64>,
}

/// What is wanted of a solve besides its figures; it is filled if there is an answer.
pub enum Wanted<'w> {
    /// Nothing.
    Figures,
    /// The states of the balls.
    Balls(&'w mut Vec<BallState<f64>>),
    /// All that there is of them.
    Details(&'w mut Details),
}

/// A bearing whose ball count and precision are known at run time only.
pub trait AnyBearing {
    /// A cold solver for it.
    fn solver(&self, attitude: Attitude) -> Box<dyn AnySolver + '_>;

    /// A cold solver for the bearing at rest, in closed form for every ball.
    fn static_solver(&self) -> Box<dyn AnySolver + '_>;
}

/// A solver whose ball count, precision and attitude rule are known at run time only.
///
/// The scene of [`AnyBearing::solver`] is the bearing at speed, throughout: speed 0 is a speed like
/// any other, so that a recording runs through standstill without a change of solver.
pub trait AnySolver {
    /// Ball count.
    fn ball_count(&self) -> usize;

    /// Precision.
    fn precision(&self) -> Precision;

    /// Solves for a load `(Fx, Fy, Fz, My, Mz)`, N and N m, at a speed in rad/s, both rounded to the
    /// precision.
    fn solve_for(&mut self, load: [f64; 5], omega: f64, wanted: Wanted<'_>) -> Answer;

    /// Makes the next solve a cold one.
    fn reset(&mut self);

    /// Holds the next solves against these limits instead of the default ones.
    fn set_limits(&mut self, limits: &Limits<f64>);

    /// Makes the next solves stop at this tolerance, or after this many iterations.
    fn set_settings(&mut self, tolerance: f64, max_iterations: u16);

    /// Solves for a load `(Fx, Fy, Fz, My, Mz)`, N and N m, at a speed in rad/s, both rounded to the
    /// precision.
    fn solve(&mut self, load: [f64; 5], omega: f64) -> Answer {
        self.solve_for(load, omega, Wanted::Figures)
    }

    /// The same. If `balls` is given and there is an answer, it becomes the states of the balls.
    fn solve_with_balls(
        &mut self,
        load: [f64; 5],
        omega: f64,
        balls: Option<&mut Vec<BallState<f64>>>,
    ) -> Answer {
        self.solve_for(load, omega, balls.map_or(Wanted::Figures, Wanted::Balls))
    }
}

/// Builds a bearing.
///
/// # Errors
///
/// The first quantity of the design that is out of its range; the ball count, if it is not among
/// [`BALL_COUNTS`].
pub fn bearing(
    design: &Design,
    balls: usize,
    precision: Precision,
) -> Result<Box<dyn AnyBearing>, DesignError> {
    match precision {
        Precision::F32 => in_single(design, balls),
        Precision::F64 => in_double(design, balls),
    }
}

macro_rules! counted {
    ($name:ident, $t:ty, $($n:literal)*) => {
        fn $name(design: &Design, balls: usize) -> Result<Box<dyn AnyBearing>, DesignError> {
            match balls {
                $($n => Ok(Box::new(Bearing::<$t, $n>::new(design)?)),)*
                _ => Err(DesignError {
                    quantity: spindle_bearing::Quantity::BallCount,
                    value: balls as f64,
                    least: *BALL_COUNTS.start() as f64,
                    most: *BALL_COUNTS.end() as f64,
                }),
            }
        }
    };
    ($name:ident, $t:ty) => {
        counted! {
            $name, $t,
            3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34
            35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64
        }
    };
}

counted!(in_single, f32);
counted!(in_double, f64);

/// Adds to the solver's precisions the name they have here.
trait Host: Real {
    const PRECISION: Precision;
}

impl Host for f32 {
    const PRECISION: Precision = Precision::F32;
}

impl Host for f64 {
    const PRECISION: Precision = Precision::F64;
}

impl<T: Host, const N: usize> AnyBearing for Bearing<T, N> {
    fn solver(&self, attitude: Attitude) -> Box<dyn AnySolver + '_> {
        match attitude {
            Attitude::Raceless => Box::new(Counted::<T, N, Full<RacewayControlFree>>::new(self)),
            Attitude::Outer => Box::new(Counted::<T, N, Full<OuterRaceControl>>::new(self)),
            Attitude::Inner => Box::new(Counted::<T, N, Full<InnerRaceControl>>::new(self)),
        }
    }

    fn static_solver(&self) -> Box<dyn AnySolver + '_> {
        Box::new(Counted::<T, N, Static>::new(self))
    }
}

struct Counted<'b, T: Real, const N: usize, M: Motion> {
    solver: Solver<'b, T, N, M>,
    settings: Settings<T>,
    limits: Limits<T>,
}

impl<'b, T: Host, const N: usize, M: Motion> Counted<'b, T, N, M> {
    fn new(bearing: &'b Bearing<T, N>) -> Self {
        Self {
            solver: Solver::of(bearing),
            settings: Settings::default(),
            limits: Limits::default(),
        }
    }
}

impl<T: Host, const N: usize, M: Motion> AnySolver for Counted<'_, T, N, M> {
    fn ball_count(&self) -> usize {
        N
    }

    fn precision(&self) -> Precision {
        T::PRECISION
    }

    fn solve_for(&mut self, load: [f64; 5], omega: f64, wanted: Wanted<'_>) -> Answer {
        let speed = Speed::rad_per_s(T::of(omega));
        let solved = self.solver.solve(rounded(load), speed, &self.settings);
        match solved {
            Ok(solution) => {
                match wanted {
                    Wanted::Figures => {}
                    Wanted::Balls(balls) => keep(balls, solution.balls()),
                    Wanted::Details(details) => {
                        keep(&mut details.balls, solution.balls());
                        keep_motions(&mut details.motions, solution.motions());
                        details.frequencies = widened_frequencies(&solution.frequencies());
                    }
                }
                let figures = Figures {
                    iterations: solution.iterations,
                    limits: solution.exceedances(&self.limits).limits(),
                    ..figures(
                        &solution.displacement,
                        &solution.stiffness(),
                        &solution.error,
                    )
                };
                Answer {
                    status: solution.status.name(),
                    figures: Ok(figures),
                }
            }
            Err(status) => refusal(&status),
        }
    }

    fn reset(&mut self) {
        self.solver.reset();
    }

    fn set_limits(&mut self, limits: &Limits<f64>) {
        self.limits = Limits {
            peak_pressure: T::of(limits.peak_pressure),
            friction: T::of(limits.friction),
        };
    }

    fn set_settings(&mut self, tolerance: f64, max_iterations: u16) {
        self.settings = Settings {
            tolerance: T::of(tolerance),
            max_iterations,
        };
    }
}

// Functions without the ball count: what they call, closures included, is compiled once for each precision.

fn rounded<T: Real>(load: [f64; 5]) -> [T; 5] {
    load.map(T::of)
}

/// The numbers of an equilibrium; no count, and no limits passed.
#[inline(never)]
fn figures<T: Real>(
    displacement: &[T; 5],
    stiffness: &[[T; 5]; 5],
    error: &ErrorEstimate<T>,
) -> Figures {
    Figures {
        iterations: 0,
        displacement: displacement.map(T::to_f64),
        stiffness: stiffness.map(|row| row.map(T::to_f64)),
        limits: LimitSet::default(),
        error: Some([error.displacement, error.force, error.stiffness].map(T::to_f64)),
    }
}

fn keep<T: Real>(kept: &mut Vec<BallState<f64>>, balls: impl Iterator<Item = BallState<T>>) {
    kept.clear();
    kept.extend(balls.map(|ball| widened(&ball)));
}

fn keep_motions<T: Real>(
    kept: &mut Vec<BallMotion<f64>>,
    motions: impl Iterator<Item = BallMotion<T>>,
) {
    kept.clear();
    kept.extend(motions.map(|motion| widened_motion(&motion)));
}

fn refusal<T: Real>(status: &Status<T>) -> Answer {
    Answer {
        status: status.name(),
        figures: Err(status.to_string()),
    }
}

/// A ball's state in doubles.
pub fn widened<T: Real>(ball: &BallState<T>) -> BallState<f64> {
    BallState {
        azimuth: ball.azimuth.to_f64(),
        alpha_i: ball.alpha_i.to_f64(),
        alpha_o: ball.alpha_o.to_f64(),
        q_i: ball.q_i.to_f64(),
        q_o: ball.q_o.to_f64(),
        delta_i: ball.delta_i.to_f64(),
        delta_o: ball.delta_o.to_f64(),
        centrifugal_force: ball.centrifugal_force.to_f64(),
        gyroscopic_moment: ball.gyroscopic_moment.to_f64(),
    }
}

/// A ball's motion in doubles.
pub fn widened_motion<T: Real>(motion: &BallMotion<T>) -> BallMotion<f64> {
    let patch = |patch: &ContactPatch<T>| ContactPatch {
        peak_pressure: patch.peak_pressure.to_f64(),
        semi_major: patch.semi_major.to_f64(),
        semi_minor: patch.semi_minor.to_f64(),
        spin_to_roll: patch.spin_to_roll.to_f64(),
    };
    BallMotion {
        cage_speed: motion.cage_speed.to_f64(),
        rotation: motion.rotation.to_f64(),
        attitude: motion.attitude.to_f64(),
        inner: patch(&motion.inner),
        outer: patch(&motion.outer),
    }
}

/// Frequencies in doubles.
pub fn widened_frequencies<T: Real>(frequencies: &Frequencies<T>) -> Frequencies<f64> {
    Frequencies {
        cage: frequencies.cage.to_f64(),
        outer_race: frequencies.outer_race.to_f64(),
        inner_race: frequencies.inner_race.to_f64(),
        ball: frequencies.ball.to_f64(),
    }
}
