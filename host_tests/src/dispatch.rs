//! From ball count, precision and attitude rule known at run time to the solver, which wants them
//! at compile time.
//!
//! The solver is generic over the ball count and owns no memory. A host program that reads the bearing from a file has one
//! bearing compiled for every count, and solvers for the largest one alone: a row may have fewer balls than its spindle.

use spindle_bearing::{
    Arrangement, BallMotion, BallState, Bearing, ContactPatch, Design, DesignError, ErrorEstimate,
    Facing, Frequencies, Full, InnerRaceControl, LimitSet, Limits, Motion, Mounted,
    OuterRaceControl, Quantity, RacewayControlFree, Real, Settings, Speed, Spindle, SpindleSolver,
    Static,
};
use std::fmt;
use std::ops::RangeInclusive;

/// Largest number of balls of a row.
pub const MOST_BALLS: usize = 64;

/// Ball counts that there is a bearing for.
pub const BALL_COUNTS: RangeInclusive<usize> = 3..=MOST_BALLS;

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
    Ok(match precision {
        Precision::F32 => Box::new(Alone(mount::<f32>(design, balls)?, precision)),
        Precision::F64 => Box::new(Alone(mount::<f64>(design, balls)?, precision)),
    })
}

/// A bearing of any ball count.
pub trait Mount<T: Real> {
    /// Its ball count.
    fn ball_count(&self) -> usize;

    /// The bearing on a shaft: clamped, with its rings just touching.
    fn mounted(&self, position: f64, facing: Facing) -> Mounted<'_, T, MOST_BALLS>;
}

impl<T: Real, const N: usize> Mount<T> for Bearing<T, N> {
    fn ball_count(&self) -> usize {
        N
    }

    fn mounted(&self, position: f64, facing: Facing) -> Mounted<'_, T, MOST_BALLS> {
        Mounted::new(self, T::of(position), facing)
    }
}

macro_rules! mounts {
    ($t:ident, $design:expr, $balls:expr, $($n:literal)*) => {
        match $balls {
            $($n => Ok(Box::new(Bearing::<$t, $n>::build($design)?) as Box<dyn Mount<$t>>),)*
            balls => Err(DesignError {
                quantity: Quantity::BallCount,
                value: balls as f64,
                least: *BALL_COUNTS.start() as f64,
                most: MOST_BALLS as f64,
            }),
        }
    };
}

/// Builds a bearing that can be mounted.
///
/// # Errors
///
/// As for [`bearing`].
pub fn mount<T: Real>(design: &Design, balls: usize) -> Result<Box<dyn Mount<T>>, DesignError> {
    mounts!(
        T, design, balls,
        3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34
        35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64
    )
}

/// A bearing as the only row of a shaft, which has the bits of a plain solver.
struct Alone<T>(Box<dyn Mount<T>>, Precision);

impl<T: Real> AnyBearing for Alone<T> {
    fn solver(&self, attitude: Attitude) -> Box<dyn AnySolver + '_> {
        match attitude {
            Attitude::Raceless => Counted::<T, Full<RacewayControlFree>>::boxed(self),
            Attitude::Outer => Counted::<T, Full<OuterRaceControl>>::boxed(self),
            Attitude::Inner => Counted::<T, Full<InnerRaceControl>>::boxed(self),
        }
    }

    fn static_solver(&self) -> Box<dyn AnySolver + '_> {
        Counted::<T, Static>::boxed(self)
    }
}

struct Counted<'b, T: Real, M: Motion> {
    precision: Precision,
    balls: usize,
    solver: SpindleSolver<'b, T, 1, MOST_BALLS, M>,
    settings: Settings<T>,
    limits: Limits<T>,
}

impl<'b, T: Real, M: Motion> Counted<'b, T, M> {
    fn boxed(bearing: &'b Alone<T>) -> Box<dyn AnySolver + 'b> {
        let row = bearing.0.mounted(0.0, Facing::PlusX);
        let spindle = Spindle::new(Arrangement::ByRows, [row]).expect("a clamped row");
        Box::new(Self {
            precision: bearing.1,
            balls: bearing.0.ball_count(),
            solver: SpindleSolver::of(spindle),
            settings: Settings::default(),
            limits: Limits::default(),
        })
    }
}

impl<T: Real, M: Motion> AnySolver for Counted<'_, T, M> {
    fn ball_count(&self) -> usize {
        self.balls
    }

    fn precision(&self) -> Precision {
        self.precision
    }

    fn solve_for(&mut self, load: [f64; 5], omega: f64, wanted: Wanted<'_>) -> Answer {
        let speed = Speed::rad_per_s(T::of(omega));
        let solved = self.solver.solve(load.map(T::of), speed, &self.settings);
        match solved {
            Ok(solution) => {
                let row = solution.rows().next().expect("a row");
                match wanted {
                    Wanted::Figures => {}
                    Wanted::Balls(balls) => *balls = row.balls().map(|b| widened(&b)).collect(),
                    Wanted::Details(details) => {
                        details.balls = row.balls().map(|b| widened(&b)).collect();
                        details.motions = row.motions().map(|m| widened_motion(&m)).collect();
                        details.frequencies = widened_frequencies(&row.frequencies());
                    }
                }
                let ErrorEstimate {
                    displacement,
                    force,
                    stiffness,
                } = solution.error;
                let figures = Figures {
                    iterations: solution.iterations,
                    displacement: solution.displacement.map(T::to_f64),
                    stiffness: wide(&solution.stiffness()),
                    limits: row.limits(&self.limits),
                    error: Some([displacement, force, stiffness].map(T::to_f64)),
                };
                Answer {
                    status: solution.status.name(),
                    figures: Ok(figures),
                }
            }
            Err(status) => Answer {
                status: status.name(),
                figures: Err(status.to_string()),
            },
        }
    }

    fn reset(&mut self) {
        self.solver.reset();
    }

    fn set_limits(&mut self, limits: &Limits<f64>) {
        self.limits = narrowed(limits);
    }

    fn set_settings(&mut self, tolerance: f64, max_iterations: u16) {
        self.settings = Settings {
            tolerance: T::of(tolerance),
            max_iterations,
        };
    }
}

/// Limits in a solver's precision.
pub fn narrowed<T: Real>(limits: &Limits<f64>) -> Limits<T> {
    Limits {
        peak_pressure: T::of(limits.peak_pressure),
        friction: T::of(limits.friction),
    }
}

/// A matrix in doubles.
pub fn wide<T: Real>(m: &[[T; 5]; 5]) -> [[f64; 5]; 5] {
    m.map(|row| row.map(T::to_f64))
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
