//! The scenes that are measured and proved, in one table for the images beside this file and for the programs that
//! build them and look at them; and how each of them is solved.

#![no_std]

use core::hint::black_box;
use core::marker::PhantomData;
use spindle_bearing::{
    Arrangement, AxialSolver, Bearing, Design, Facing, Given, Growth, Motion, Mounted, Preload,
    RingVector, Settings, Solution, Solver, Speed, Spindle, SpindleSolver,
};
use spindle_bearing::{ErrorEstimate, Limits, Real, Status};

/// Hands the table to a macro: `for_every_scene!(of_mine)`.
///
/// A row begins with a number, a name and the [`Scene`]. The rule of attitude follows, `None` at rest; then what the
/// scene leaves out of the full one, or has besides. A flag says whether the scene is measured in doubles, too. The last
/// list has the parts that must not be in the scene's image. Whoever asks has these names in scope.
///
/// No scene has the way from a design to constants.
#[macro_export]
#[rustfmt::skip]
macro_rules! for_every_scene {
    ($with:ident) => {
        $with! {
            0 "axial-static": Axial<Static>;
                None, "speed, radial displacements, tilts", true,
                [Spindle, Speed, Friction, RaceControl, RacewayControlFree, Iteration, Radial, Tilts, Balls, Limits];
            1 "axial-full": Axial<Full>;
                FREE, "radial displacements, tilts", false,
                [Spindle, RaceControl, Radial, Tilts, Balls, Limits];
            2 "translations-static": Ring<Static, 3>;
                None, "speed, tilts", false,
                [Spindle, Speed, Friction, RaceControl, RacewayControlFree, Tilts, Balls, Limits];
            3 "translations-full": Ring<Full, 3>;
                FREE, "tilts", true,
                [Spindle, RaceControl, Tilts, Balls, Limits];
            4 "static": Ring<Static, 5>;
                None, "speed", true,
                [Spindle, Speed, Friction, RaceControl, RacewayControlFree, Balls, Limits];
            5 "centrifugal": Ring<Centrifugal, 5>;
                FREE, "friction", false,
                [Spindle, Friction, RaceControl, Balls, Limits];
            6 "outer": Ring<Full<OuterRaceControl>, 5>;
                Some(Attitude::Outer), "free attitude: outer race control", false,
                [Spindle, RacewayControlFree, Balls, Limits];
            7 "inner": Ring<Full<InnerRaceControl>, 5>;
                Some(Attitude::Inner), "free attitude: inner race control", false,
                [Spindle, RacewayControlFree, Balls, Limits];
            8 "displacement": Ring<Full, 5, Loads, Displacement>;
                FREE, "stiffness asked for", false,
                [Spindle, RaceControl, Stiffness, Balls, Limits];
            9 "preloaded": Ring<Full, 5, RigidPreload>;
                FREE, "axial load: displacement given", false,
                [Spindle, RaceControl, Balls, Limits];
            10 "balls": Ring<Full, 5, Loads, Balls>;
                FREE, "nothing; states of balls besides", false,
                [Spindle, RaceControl, Limits];
            11 "limits": Ring<Full, 5, Loads, Passed>;
                FREE, "nothing; limits besides", false,
                [Spindle, RaceControl];
            12 "pair": Shaft<Full, Clamped, 2, 5>;
                FREE, "one bearing: two of them, back to back", false,
                [RaceControl, Balls, Limits];
            13 "sprung-pair": Shaft<Full, Sprung, 2, 6>;
                FREE, "one bearing: two of them, one under a spring", false,
                [RaceControl, Balls, Limits];
            14 "four-rows": Shaft<Full, Clamped, 4, 5>;
                FREE, "one bearing: two pairs of them, back to back", false,
                [RaceControl, Balls, Limits];
            15 "full": Ring<Full, 5>;
                FREE, "nothing", true,
                [Spindle, RaceControl, Balls, Limits];
        }
    };
}

/// What to solve, SI units.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Question<T, V> {
    /// Loads, or the displacement where that is given.
    pub values: V,
    /// Speed of the shaft, rad/s.
    pub omega: T,
    /// Tolerance of the stiffness.
    pub tolerance: T,
    /// Most iterations.
    pub max_iterations: u32,
}

impl<T: Real, V> Question<T, V> {
    #[inline(always)]
    fn settings(&self) -> Settings<T> {
        Settings {
            max_iterations: self.max_iterations as u16,
            tolerance: self.tolerance,
        }
    }

    #[inline(always)]
    fn speed(&self) -> Speed<T> {
        Speed::rad_per_s(self.omega)
    }
}

/// What came of it.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Answer<T, V, K> {
    /// Displacements.
    pub displacement: V,
    /// Stiffness, if it is asked for.
    pub stiffness: K,
    /// Errors of displacement, force and stiffness.
    pub error: [T; 3],
    /// 1 or 2: converged, precision limit.
    pub status: u32,
    /// Iterations.
    pub iterations: u32,
}

impl<T: Real, V, K> Answer<T, V, K> {
    #[inline(always)]
    fn new(
        displacement: V,
        stiffness: K,
        error: &ErrorEstimate<T>,
        status: &Status<T>,
        iterations: u16,
    ) -> Self {
        Self {
            displacement,
            stiffness,
            error: [error.displacement, error.force, error.stiffness],
            status: match status {
                Status::Converged => 1,
                _ => 2,
            },
            iterations: iterations.into(),
        }
    }
}

/// Numbers of a vector or matrix, row by row.
pub trait Numbers<T> {
    /// All of them.
    fn numbers(&self) -> &[T];
}

impl<T, const D: usize> Numbers<T> for [T; D] {
    fn numbers(&self) -> &[T] {
        self
    }
}

impl<T, const D: usize> Numbers<T> for [[T; D]; D] {
    fn numbers(&self) -> &[T] {
        self.as_flattened()
    }
}

/// A solver, and what is asked of it.
pub trait Scene<T: Real, const N: usize> {
    /// Freedoms of the ring.
    const FREEDOMS: usize;
    /// The axial displacement is given, and not the load.
    const PRELOADED: bool = false;
    /// One value for each freedom.
    type Vector: Copy + Numbers<T>;
    /// The stiffness; nothing if it is not asked for.
    type Matrix: Copy + Numbers<T>;
    /// The solver.
    type Solver<'b>
    where
        T: 'b;
    /// As many of these as there are freedoms.
    fn vector(values: [T; 5]) -> Self::Vector;
    /// One without history, unless the design allows none.
    fn solver<'b>(bearing: &'b Bearing<T, N>, design: &Design) -> Option<Self::Solver<'b>>;
    /// Has the next solve start from nothing.
    fn reset(solver: &mut Self::Solver<'_>);
    /// Solves.
    ///
    /// # Errors
    ///
    /// A status that names why there is no answer.
    fn solve(
        solver: &mut Self::Solver<'_>,
        question: &Question<T, Self::Vector>,
    ) -> Result<Answer<T, Self::Vector, Self::Matrix>, Status<T>>;
}

/// A ring with three or five freedoms: how its balls move, what is given and what is asked for.
pub struct Ring<M, const D: usize, G = Loads, O = Stiffness>(PhantomData<(M, G, O)>);

impl<T: Real, const N: usize, M: Motion, const D: usize, G: Condition, O: Output> Scene<T, N>
    for Ring<M, D, G, O>
where
    [T; D]: RingVector,
{
    const FREEDOMS: usize = D;
    const PRELOADED: bool = G::PRELOADED;
    type Vector = [T; D];
    type Matrix = O::Matrix<T, D>;
    type Solver<'b>
        = Solver<'b, T, N, M, D>
    where
        T: 'b;

    fn vector(values: [T; 5]) -> Self::Vector {
        core::array::from_fn(|i| values[i])
    }

    #[inline(always)]
    fn solver<'b>(bearing: &'b Bearing<T, N>, _: &Design) -> Option<Self::Solver<'b>> {
        Some(Solver::of(bearing))
    }

    #[inline(always)]
    fn reset(solver: &mut Self::Solver<'_>) {
        solver.reset();
    }

    #[inline(always)]
    fn solve(
        solver: &mut Self::Solver<'_>,
        question: &Question<T, Self::Vector>,
    ) -> Result<Answer<T, Self::Vector, Self::Matrix>, Status<T>> {
        let s = G::solve(solver, question)?;
        Ok(Answer::new(
            s.displacement,
            O::of(&s),
            &s.error,
            &s.status,
            s.iterations,
        ))
    }
}

/// One ball for all.
pub struct Axial<M>(PhantomData<M>);

impl<T: Real, const N: usize, M: Motion> Scene<T, N> for Axial<M> {
    const FREEDOMS: usize = 1;
    type Vector = [T; 1];
    type Matrix = [[T; 1]; 1];
    type Solver<'b>
        = AxialSolver<'b, T, N, M>
    where
        T: 'b;

    fn vector(values: [T; 5]) -> Self::Vector {
        [values[0]]
    }

    #[inline(always)]
    fn solver<'b>(bearing: &'b Bearing<T, N>, _: &Design) -> Option<Self::Solver<'b>> {
        Some(AxialSolver::of(bearing))
    }

    #[inline(always)]
    fn reset(solver: &mut Self::Solver<'_>) {
        solver.reset();
    }

    #[inline(always)]
    fn solve(
        solver: &mut Self::Solver<'_>,
        question: &Question<T, Self::Vector>,
    ) -> Result<Answer<T, Self::Vector, Self::Matrix>, Status<T>> {
        let s = solver.solve(question.values[0], question.speed(), &question.settings())?;
        Ok(Answer::new(
            [s.displacement],
            [[s.stiffness()]],
            &s.error,
            &s.status,
            s.iterations,
        ))
    }
}

/// `R` such bearings on one shaft, back to back, held as `H` says; `D` freedoms.
pub struct Shaft<M, H, const R: usize, const D: usize>(PhantomData<(M, H)>);

/// What holds the bearings of a shaft.
pub trait Holding<const R: usize, const D: usize> {
    /// The shaft in its bearings, unless the design allows none.
    fn spindle<'b, T: Real, const N: usize>(
        bearing: &'b Bearing<T, N>,
        design: &Design,
    ) -> Option<Spindle<'b, T, R, N, D>>;
}

/// The rows, two of a side next to each other, and the distance of the groove centres.
fn rows<'b, T: Real, const R: usize, const N: usize>(
    bearing: &'b Bearing<T, N>,
    design: &Design,
    preload: impl Fn(usize, T) -> Preload<T>,
) -> [Mounted<'b, T, N>; R] {
    let grooves = design.inner_groove_factor + design.outer_groove_factor - 1.0;
    let distance = T::of(grooves * design.ball_diameter);
    core::array::from_fn(|i| {
        let facing = if i < R / 2 {
            Facing::PlusX
        } else {
            Facing::MinusX
        };
        let position = T::of(0.3 * design.pitch_diameter * i as f64);
        Mounted::new(bearing, position, facing).with(preload(i, distance))
    })
}

/// Clamped by a fiftieth of the distance of the groove centres each.
pub struct Clamped;

impl<const R: usize> Holding<R, 5> for Clamped {
    fn spindle<'b, T: Real, const N: usize>(
        bearing: &'b Bearing<T, N>,
        design: &Design,
    ) -> Option<Spindle<'b, T, R, N, 5>> {
        let rows = rows(bearing, design, |_, distance| {
            Preload::Closure(T::of(0.02) * distance)
        });
        Spindle::new(Arrangement::BackToBack, rows).ok()
    }
}

/// The rear half in a sleeve, whose spring has 0.3 N for each ball and square millimetre of its diameter.
pub struct Sprung;

impl<const R: usize> Holding<R, 6> for Sprung {
    fn spindle<'b, T: Real, const N: usize>(
        bearing: &'b Bearing<T, N>,
        design: &Design,
    ) -> Option<Spindle<'b, T, R, N, 6>> {
        let rows = rows(bearing, design, |i, _| {
            if i < R / 2 {
                Preload::Closure(T::ZERO)
            } else {
                Preload::Spring
            }
        });
        let area = N as f64 * design.ball_diameter * design.ball_diameter;
        Spindle::sprung(Arrangement::BackToBack, rows, T::of(0.3e6 * area)).ok()
    }
}

impl<T: Real, const N: usize, M: Motion, H: Holding<R, D>, const R: usize, const D: usize>
    Scene<T, N> for Shaft<M, H, R, D>
{
    const FREEDOMS: usize = 5;
    type Vector = [T; 5];
    type Matrix = [[T; 5]; 5];
    type Solver<'b>
        = SpindleSolver<'b, T, R, N, M, D>
    where
        T: 'b;

    fn vector(values: [T; 5]) -> Self::Vector {
        values
    }

    #[inline(always)]
    fn solver<'b>(bearing: &'b Bearing<T, N>, design: &Design) -> Option<Self::Solver<'b>> {
        Some(SpindleSolver::of(H::spindle(bearing, design)?))
    }

    #[inline(always)]
    fn reset(solver: &mut Self::Solver<'_>) {
        solver.reset();
    }

    #[inline(always)]
    fn solve(
        solver: &mut Self::Solver<'_>,
        question: &Question<T, Self::Vector>,
    ) -> Result<Answer<T, Self::Vector, Self::Matrix>, Status<T>> {
        let s = solver.solve(question.values, question.speed(), &question.settings())?;
        Ok(Answer::new(
            s.displacement,
            s.stiffness(),
            &s.error,
            &s.status,
            s.iterations,
        ))
    }
}

/// What is given of the ring's freedoms.
pub trait Condition {
    /// The axial displacement is.
    const PRELOADED: bool;
    /// Solves for it.
    ///
    /// # Errors
    ///
    /// A status that names why there is no answer.
    fn solve<'s, T: Real, const N: usize, M: Motion, const D: usize>(
        solver: &'s mut Solver<'_, T, N, M, D>,
        question: &Question<T, [T; D]>,
    ) -> Result<Solution<'s, T, N, M, D>, Status<T>>;
}

/// All loads.
pub struct Loads;

impl Condition for Loads {
    const PRELOADED: bool = false;

    #[inline(always)]
    fn solve<'s, T: Real, const N: usize, M: Motion, const D: usize>(
        solver: &'s mut Solver<'_, T, N, M, D>,
        question: &Question<T, [T; D]>,
    ) -> Result<Solution<'s, T, N, M, D>, Status<T>> {
        solver.solve(question.values, question.speed(), &question.settings())
    }
}

/// The axial displacement, and the other loads.
pub struct RigidPreload;

impl Condition for RigidPreload {
    const PRELOADED: bool = true;

    #[inline(always)]
    fn solve<'s, T: Real, const N: usize, M: Motion, const D: usize>(
        solver: &'s mut Solver<'_, T, N, M, D>,
        question: &Question<T, [T; D]>,
    ) -> Result<Solution<'s, T, N, M, D>, Status<T>> {
        let mut given = question.values.map(Given::Load);
        given[0] = Given::Displacement(question.values[0]);
        let (speed, settings) = (question.speed(), question.settings());
        solver.solve_at(&given, speed, &Growth::NONE, &settings)
    }
}

/// What is asked of a solution besides the displacement.
pub trait Output {
    /// The stiffness, or nothing.
    type Matrix<T: Real, const D: usize>: Copy + Numbers<T>;
    /// Asks for it.
    fn of<T: Real, const N: usize, M: Motion, const D: usize>(
        solution: &Solution<'_, T, N, M, D>,
    ) -> Self::Matrix<T, D>;
}

/// Nothing.
pub struct Displacement;

impl Output for Displacement {
    type Matrix<T: Real, const D: usize> = [T; 0];

    #[inline(always)]
    fn of<T: Real, const N: usize, M: Motion, const D: usize>(
        _: &Solution<'_, T, N, M, D>,
    ) -> Self::Matrix<T, D> {
        []
    }
}

/// The stiffness.
pub struct Stiffness;

impl Output for Stiffness {
    type Matrix<T: Real, const D: usize> = [[T; D]; D];

    #[inline(always)]
    fn of<T: Real, const N: usize, M: Motion, const D: usize>(
        solution: &Solution<'_, T, N, M, D>,
    ) -> Self::Matrix<T, D> {
        solution.stiffness()
    }
}

/// Stiffness and states of balls.
pub struct Balls;

impl Output for Balls {
    type Matrix<T: Real, const D: usize> = [[T; D]; D];

    #[inline(always)]
    fn of<T: Real, const N: usize, M: Motion, const D: usize>(
        solution: &Solution<'_, T, N, M, D>,
    ) -> Self::Matrix<T, D> {
        for ball in solution.balls() {
            black_box(&ball);
        }
        solution.stiffness()
    }
}

/// Stiffness and limits that are passed.
pub struct Passed;

impl Output for Passed {
    type Matrix<T: Real, const D: usize> = [[T; D]; D];

    #[inline(always)]
    fn of<T: Real, const N: usize, M: Motion, const D: usize>(
        solution: &Solution<'_, T, N, M, D>,
    ) -> Self::Matrix<T, D> {
        black_box(&solution.exceedances(&Limits::default()));
        solution.stiffness()
    }
}
