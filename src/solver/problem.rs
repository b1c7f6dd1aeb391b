//! The problem of one solve: loads or displacements, speed, growth, and how long it may take. Checked, and turned into the
//! solver's units.

use crate::ball::kinematics::Speed;
use crate::bearing::Constants;
use crate::growth::Growth;
use crate::linalg::{Matrix, matrix, moved, refer, vector};
use crate::real::Real;
use crate::rows::elastic::Piece;
use crate::rows::row::Sum;
use crate::rows::{Layout, Rows};
use crate::status::{Quantity, Status};
use crate::tuning;

/// Iteration limit and convergence tolerance.
///
/// The default is for a solve that may take its time, [`Settings::TICK`] for a tick of firmware.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings<T> {
    /// Most iterations, at least 1. An iteration condenses every ball once.
    ///
    /// One problem is finished over any number of calls. Loads that change by half their size and more at every call need so
    /// many iterations in each: 3 in single precision, at the default tolerance as at that of [`Settings::TICK`], and 5 in
    /// double. With fewer, a solver may chase them for thousands of calls without an answer.
    pub max_iterations: u16,
    /// Largest change of the stiffness along the last step, relative to its diagonal. Displacements and contact forces
    /// are then good to less. At 0, rounding ends a solve: [`Status::PrecisionLimit`]. A negative one is refused.
    pub tolerance: T,
}

impl<T: Real> Settings<T> {
    /// A tick of firmware: three iterations at most, a tolerance of 1e-3.
    ///
    /// Where such a solve converges, the stiffness is good to 5e-3, the tolerance times the estimate's margin of 5.
    /// [`ErrorEstimate::stiffness`](crate::ErrorEstimate::stiffness) states that much at most, besides rounding. A Cortex-M4F at
    /// 168 MHz has time for three iterations in a tick of 1 ms that monitors a pair.
    ///
    /// A solve from nothing mostly takes more iterations: it ends as [`Status::IterationLimit`], and the next call goes on.
    /// [`Solver::unfinished`](crate::Solver::unfinished) has what a tick without an answer has reached.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed};
    ///
    /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
    /// let (mut solver, speed) = (Solver::new(), Speed::rpm(20_000.0));
    /// solver.solve(&BEARING, [500.0, 100.0, 0.0, 0.0, 1.0], speed, &Settings::default())?;
    /// // A tick later.
    /// let solution = solver.solve(&BEARING, [502.0, 104.0, 0.0, 0.0, 1.0], speed, &Settings::TICK)?;
    /// assert!(solution.error.stiffness <= 5e-3);
    /// # Ok::<(), spindle_bearing::Status<f32>>(())
    /// ```
    pub const TICK: Self = Self {
        max_iterations: 3,
        tolerance: T::TICK,
    };

    /// 100 iterations; a tolerance of 2e-5 in single and 3e-13 in double precision.
    pub const DEFAULT: Self = Self {
        max_iterations: 2 * tuning::ATTEMPT,
        tolerance: T::TOLERANCE,
    };
}

impl<T: Real> Default for Settings<T> {
    /// [`Settings::DEFAULT`].
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A load or a displacement that is given of a freedom of the inner ring.
///
/// ```
/// use spindle_bearing::{Bearing, Design, Given, Settings, Solver, Speed};
///
/// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// static BEARING: Bearing<f64, 15> = Bearing::<f64, 15>::const_new(&DESIGN);
/// let mut solver = Solver::new();
/// // Pressed together by 10 um, without tilt; a radial load of 50 N.
/// let given = [
///     Given::Displacement(10e-6),
///     Given::Load(50.0),
///     Given::Load(0.0),
///     Given::Displacement(0.0),
///     Given::Displacement(0.0),
/// ];
/// let solution = solver.solve(&BEARING, given, Speed::rpm(10_000.0), &Settings::default())?;
/// assert!(solution.load[0] > 100.0);
/// # Ok::<(), spindle_bearing::Status<f64>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Given<T> {
    /// Its load, N or N m; the displacement is solved for.
    Load(T),
    /// Its displacement, m or rad; the load is the reaction.
    Displacement(T),
}

impl<T> Given<T> {
    /// The load that was given, or else the reaction.
    #[inline(always)]
    pub(crate) fn load_or(self, found: T) -> T {
        match self {
            Self::Load(given) => given,
            Self::Displacement(_) => found,
        }
    }

    /// The displacement that was given, or else the one that was found.
    #[inline(always)]
    pub(crate) fn displacement_or(self, found: T) -> T {
        match self {
            Self::Displacement(given) => given,
            Self::Load(_) => found,
        }
    }
}

impl<T: Real> From<T> for Given<T> {
    fn from(load: T) -> Self {
        Self::Load(load)
    }
}

/// Loads of a solve, for `D` freedoms.
///
/// Loads `[T; D]`, or a load or a displacement of each freedom, `[Given<T>; D]`, at the bearing's centre or at `x = 0` of a
/// spindle's shaft. For five freedoms, [`ShaftLoad`](crate::ShaftLoad)s, each at its position.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no load for {D} freedoms",
    note = "give as many numbers as the solver has freedoms, or as many `Given`; or a slice of `ShaftLoad`, for five"
)]
pub trait Loading<'a, T: Real, const D: usize>: Copy {
    /// Displacements may be given.
    #[doc(hidden)]
    const GIVEN: bool = false;
    /// At `x = 0`.
    #[doc(hidden)]
    fn given(self) -> [Given<T>; D];
    /// Loads that have a position.
    #[doc(hidden)]
    #[inline(always)]
    fn placed(self) -> &'a [ShaftLoad<T>] {
        &[]
    }
}

impl<T: Real, const D: usize> Loading<'_, T, D> for [T; D] {
    #[inline(always)]
    fn given(self) -> [Given<T>; D] {
        self.map(Given::Load)
    }
}

impl<T: Real, const D: usize> Loading<'_, T, D> for [Given<T>; D] {
    const GIVEN: bool = true;

    #[inline(always)]
    fn given(self) -> [Given<T>; D] {
        self
    }
}

/// A load on the shaft: one of a solve, like the cutting force at the tool, or one that acts at all times, like the pull of a belt.
///
/// See [`SpindleSolver::solve`](crate::SpindleSolver::solve) and [`Spindle::with_loads`](crate::Spindle::with_loads) for examples.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ShaftLoad<T> {
    /// Where it acts, m.
    pub position: T,
    /// Forces `Fx, Fy, Fz` (N) and moments `My, Mz` (N m) there.
    pub load: [T; 5],
}

/// The sum of loads about the position `x`, m.
pub fn about<T: Real>(loads: &[ShaftLoad<T>], x: T) -> [T; 5] {
    let mut sum = [T::ZERO; 5];
    for at in loads {
        let mut load = at.load;
        refer(at.position - x, &mut load);
        sum = vector(|i| sum[i] + load[i]);
    }
    sum
}

impl<'a, T: Real> Loading<'a, T, 5> for &'a [ShaftLoad<T>] {
    #[inline(always)]
    fn given(self) -> [Given<T>; 5] {
        about(self, T::ZERO).map(Given::Load)
    }

    #[inline(always)]
    fn placed(self) -> &'a [ShaftLoad<T>] {
        self
    }
}

impl<'a, T: Real, const K: usize> Loading<'a, T, 5> for &'a [ShaftLoad<T>; K] {
    #[inline(always)]
    fn given(self) -> [Given<T>; 5] {
        self.as_slice().given()
    }

    #[inline(always)]
    fn placed(self) -> &'a [ShaftLoad<T>] {
        self
    }
}

/// Speed of the shaft, and growth of the rings and balls of `R` rows. A [`Speed`] alone is one without growth.
///
/// ```
/// use spindle_bearing::{Bearing, Design, Growth, Settings, Solver, Speed};
///
/// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
/// let growth = Growth { radial: 2e-6, ..Growth::NONE };
/// let warm = Speed::rpm(10_000.0).with_growth([growth]);
/// let mut solver = Solver::new();
/// let solution = solver.solve(&BEARING, [300.0, 0.0, 0.0, 0.0, 0.0], warm, &Settings::default())?;
/// # assert!(solution.displacement[0] != 0.0);
/// # Ok::<(), spindle_bearing::Status<f32>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OperatingPoint<T: Real, const R: usize> {
    /// Speed of the shaft.
    pub speed: Speed<T>,
    /// Growth of each row.
    pub growth: [Growth<T>; R],
}

impl<T: Real, const R: usize> From<Speed<T>> for OperatingPoint<T, R> {
    #[inline(always)]
    fn from(speed: Speed<T>) -> Self {
        speed.with_growth([Growth::NONE; R])
    }
}

impl<T: Real> Speed<T> {
    /// At this speed, with this growth of each row.
    #[inline(always)]
    pub const fn with_growth<const R: usize>(self, growth: [Growth<T>; R]) -> OperatingPoint<T, R> {
        OperatingPoint {
            speed: self,
            growth,
        }
    }
}

/// Load and prescribed displacements of a solve, in the units of the constants, referred to the shaft's centre.
#[derive(Debug, Clone, Copy)]
pub struct Problem<T, const D: usize> {
    /// Load; 0 of a freedom whose displacement is given.
    pub load: [T; D],
    /// Size of the load, or of the preload if that is larger.
    pub load_scale: T,
    /// The displacement that is given of some freedoms; 0 of a sleeve that is not there.
    pub prescribed: [Option<T>; D],
    /// No displacement is given.
    pub is_free: bool,
    /// The piece of an elastic shaft from where displacements are given to its centre.
    pub overhang: Option<Piece<T>>,
    /// Largest change of the stiffness along the last step.
    pub tolerance: T,
    /// Fingerprint of loads that have a position, and deflect an elastic shaft between its rows.
    pub placed: u32,
    /// Error of the balls' forces that is small enough, relative to the largest.
    pub enough: T,
    /// Unbalanced part of the load from which on a step is not the last one: it changes the stiffness by more than the
    /// tolerance.
    pub far: T,
}

/// Refuses a tolerance that is negative or no number.
pub fn check_tolerance<T: Real>(tolerance: T) -> Result<(), Status<T>> {
    if tolerance >= T::ZERO && tolerance.is_finite() {
        return Ok(());
    }
    check(Quantity::Tolerance, tolerance, T::ZERO)
}

impl<T: Real, const D: usize> Problem<T, D> {
    /// What is given in the user's units, about the point where it is given.
    pub fn given<const R: usize, const SET: bool, const E: usize>(
        layout: &Layout<'_, T, R, SET, E>,
        given: &[Given<T>; D],
        tolerance: T,
    ) -> Result<Self, Status<T>> {
        check_tolerance(tolerance)?;
        let mut problem = Self::new(tolerance);
        let unit = layout.rows[0].bearing.c;
        for (i, given) in given.iter().enumerate() {
            match given_in_units(unit, i, layout.ball_count, *given)? {
                Given::Load(load) => problem.load[i] = load,
                Given::Displacement(u) => {
                    (problem.prescribed[i], problem.is_free) = (Some(u), false)
                }
            }
        }
        if D == 6 && !layout.has_sleeve::<D>() {
            problem.prescribed[D - 1] = Some(T::ZERO);
        }
        Ok(problem)
    }

    /// Without a load yet.
    pub fn new(tolerance: T) -> Self {
        // Rounding ends a solve whose tolerance is below it: no balance is nearer.
        let least = tolerance.at_least(T::EPSILON);
        let far = T::of(tuning::FAR) * least;
        Self {
            load: [T::ZERO; D],
            load_scale: T::ZERO,
            prescribed: [None; D],
            is_free: true,
            overhang: None,
            placed: 0,
            tolerance,
            enough: T::of(tuning::FORCE) * least,
            far: if tolerance < T::of(0.5 * tuning::COARSE) {
                far.at_most(T::of(tuning::FAR_AT_MOST))
            } else {
                far
            },
        }
    }

    /// The overhang, which a rigid shaft (`E = 0`) has no code for.
    #[inline(always)]
    pub fn overhang<const E: usize>(&self) -> Option<&Piece<T>> {
        if E > 0 { self.overhang.as_ref() } else { None }
    }

    /// Takes a motion of the shaft's centre, and a force of the rows about it, to where displacements are given.
    #[inline(always)]
    pub fn given_motion<const E: usize>(&self, u: &mut [T; D], force: &mut [T; D]) {
        if let Some(piece) = self.overhang::<E>() {
            let bent = piece.deflection(force);
            *u = moved(-piece.length, &vector(|i| u[i] + bent[i]));
            refer(piece.length, force);
        }
    }

    /// The tangent where displacements are given, from that about the shaft's centre.
    #[inline(always)]
    pub fn tangent_given<const E: usize>(&self, k: &Matrix<T, D>) -> Matrix<T, D> {
        let Some(piece) = self.overhang::<E>() else {
            return *k;
        };
        let mut sum = Sum { k: *k, ..Sum::NONE };
        sum.end(piece);
        sum.k
    }

    /// Leaves out what the supports of prescribed displacements take of a force about the shaft's centre.
    #[inline(always)]
    pub fn release<const E: usize>(&self, force: &mut [T; D]) {
        if let Some(piece) = self.overhang::<E>() {
            refer(piece.length, force);
        }
        for (force, held) in force.iter_mut().zip(&self.prescribed) {
            if held.is_some() {
                *force = T::ZERO;
            }
        }
        if let Some(piece) = self.overhang::<E>() {
            refer(-piece.length, force);
        }
    }

    /// Whether enough balls carry: one holds the ring in two directions, and one that touches without force in none.
    #[cold]
    #[inline(never)]
    pub fn is_held_by<const R: usize, const SET: bool, const E: usize>(
        &self,
        rows: &Rows<'_, T, R, SET, E, D>,
    ) -> bool {
        let mut free = 0;
        for held in &self.prescribed {
            free += u16::from(held.is_none());
        }
        2 * rows.loaded() >= free
    }
}

/// Refuses a value that is not finite, or larger in magnitude than `limit`.
pub fn check<T: Real>(quantity: Quantity, value: T, limit: T) -> Result<(), Status<T>> {
    if !value.is_finite() {
        return Err(Status::NotFinite { quantity, value });
    }
    if value.abs() > limit {
        return Err(Status::OutOfRange {
            quantity,
            value,
            limit,
        });
    }
    Ok(())
}

/// A given load or displacement, in units of force or length.
///
/// Beyond the force that would press all `balls` by the whole groove distance, nothing in the model holds.
#[inline(always)]
pub fn given_in_units<T: Real>(
    c: &Constants<T>,
    freedom: usize,
    balls: T,
    given: Given<T>,
) -> Result<Given<T>, Status<T>> {
    let (force, length) = units(c, freedom);
    let [of_load, of_displacement] = Quantity::OF_FREEDOM[freedom];
    match given {
        Given::Load(load) => {
            check(of_load, load, force * balls * T::of(512.0))?;
            Ok(Given::Load(load / force))
        }
        Given::Displacement(u) => {
            check(of_displacement, u, length * T::of(128.0))?;
            Ok(Given::Displacement(u / length))
        }
    }
}

/// Speed in rad/s, and growth in units of length.
///
/// The speed is at most the one where a ball's centrifugal force would press it by the whole groove distance, and 0 of balls
/// that are not `at_speed`. Growths are at most a quarter of the groove distance each.
pub fn speed_and_growth<T: Real>(
    c: &Constants<T>,
    speed: Speed<T>,
    at_speed: bool,
    growth: &Growth<T>,
) -> Result<(T, Growth<T>), Status<T>> {
    let limit = if at_speed {
        (T::of(2048.0) / c.inertia).sqrt_abs()
    } else {
        T::ZERO
    };
    let omega = speed.as_rad_per_s();
    check(Quantity::Speed, omega, limit)?;
    let lengths = [growth.axial, growth.radial, growth.ball];
    for (length, quantity) in lengths.into_iter().zip(Quantity::OF_GROWTH) {
        check(quantity, length, c.length * T::of(16.0))?;
    }
    let per = T::ONE / c.length;
    let growth = Growth {
        axial: growth.axial * per,
        radial: growth.radial * per,
        ball: growth.ball * per,
    };
    Ok((omega, growth))
}

/// Inertia `m dm omega^2 / 2`; 0 where the inertia of `ball_count` balls is below rounding of loads of the size `size`.
pub fn inertia<T: Real>(c: &Constants<T>, omega: T, ball_count: T, size: T) -> T {
    let s = c.inertia * omega * omega;
    if size > T::ZERO && s * ball_count < T::EPSILON * size {
        T::ZERO
    } else {
        s
    }
}

/// Units of force and displacement of a freedom, SI.
#[inline(always)]
pub fn units<T: Real>(c: &Constants<T>, freedom: usize) -> (T, T) {
    match freedom {
        3 | 4 => (c.moment, c.tilt),
        _ => (c.force, c.length),
    }
}

/// A stiffness in SI units.
pub fn stiffness_out<T: Real, const D: usize>(c: &Constants<T>, k: &Matrix<T, D>) -> Matrix<T, D> {
    let per = [T::ONE / c.length, T::ONE / c.tilt];
    matrix(|i, j| k[i][j] * (units(c, i).0 * per[usize::from(matches!(j, 3 | 4))]))
}

/// `Rp`, m.
pub fn radius<T: Real>(c: &Constants<T>) -> T {
    c.length / c.tilt
}
