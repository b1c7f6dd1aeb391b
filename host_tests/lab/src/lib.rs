//! The scenes that are measured and proved. One table serves the images beside this file, and the programs that
//! build the images and look at them.

#![cfg_attr(not(feature = "campaign"), no_std)]

#[cfg(all(target_os = "none", feature = "bench"))]
extern crate self as lab;

#[cfg(feature = "campaign")]
pub mod bar;
#[cfg(feature = "programs")]
pub mod images;
#[cfg(all(target_os = "none", feature = "bench"))]
pub mod on_board;
#[cfg(feature = "programs")]
pub mod report;
pub mod solves;
#[cfg(feature = "programs")]
pub mod workload;

use core::fmt::{self, Write};
use core::hint::black_box;
use core::marker::PhantomData;
use spindle_bearing::{
    Arrangement, AxialSolver, Bearing, Design, Facing, Given, Growth, Limit, Limits, Material,
    Motion, Mounted, Preload, RacewayControlFree, Real, Section, Settings, Shaft, Solver, Speed,
    Spindle, SpindleSolver, Support,
};

/// Hands the table to a macro: `for_every_scene!(of_mine)`.
///
/// A row has a number, a name, the freedoms and the [`Scene`]. It says which part of the full scene is left out or added, and
/// which parts must not be in the image. The caller has these names in scope.
///
/// No scene has the way from a design to constants.
#[macro_export]
#[rustfmt::skip]
macro_rules! for_every_scene {
    ($with:ident) => {
        $with! {
            0 "axial-static" 1: Axial<Static>;
                "speed, radial displacements, tilts",
                [Spindle, Elastic, Speed, Friction, RaceControl, RacewayControlFree, Iteration, Radial, Tilts, Balls, Limits];
            1 "axial-full" 1: Axial<RacewayControlFree>;
                "radial displacements, tilts",
                [Spindle, Elastic, RaceControl, Radial, Tilts, Balls, Limits];
            2 "translations-full" 3: Ring<RacewayControlFree>;
                "tilts",
                [Spindle, Elastic, RaceControl, Tilts, Balls, Limits];
            3 "static" 5: Ring<Static>;
                "speed",
                [Spindle, Elastic, Speed, Friction, RaceControl, RacewayControlFree, Balls, Limits];
            4 "centrifugal" 5: Ring<Centrifugal>;
                "friction",
                [Spindle, Elastic, Friction, RaceControl, Balls, Limits];
            5 "outer" 5: Ring<OuterRaceControl>;
                "free attitude: outer race control",
                [Spindle, Elastic, RacewayControlFree, Balls, Limits];
            6 "inner" 5: Ring<InnerRaceControl>;
                "free attitude: inner race control",
                [Spindle, Elastic, RacewayControlFree, Balls, Limits];
            7 "displacement" 5: Ring<RacewayControlFree, { lab::DISPLACEMENT }>;
                "stiffness asked for",
                [Spindle, Elastic, RaceControl, Stiffness, Balls, Limits];
            8 "balls" 5: Ring<RacewayControlFree, { lab::BALLS }>;
                "nothing; states of balls besides",
                [Spindle, Elastic, RaceControl, Limits];
            9 "limits" 5: Ring<RacewayControlFree, { lab::LIMITS }>;
                "nothing; limits besides",
                [Spindle, Elastic, RaceControl];
            10 "pair" 5: Clamped<2>;
                "nothing; two bearings, back to back",
                [Elastic, RaceControl, Balls, Limits];
            11 "sprung-pair" 5: Sprung<2>;
                "nothing; two bearings, one under a spring",
                [Elastic, RaceControl, Balls, Limits];
            12 "four-rows" 5: Clamped<4>;
                "nothing; two pairs, back to back",
                [Elastic, RaceControl, Balls, Limits];
            13 "elastic-pair" 5: Elastic<2>;
                "nothing; two bearings on an elastic shaft, whose supports give way",
                [RaceControl, Balls, Limits];
            14 "elastic-four-rows" 5: Elastic<4>;
                "nothing; two pairs on an elastic shaft, whose supports give way",
                [RaceControl, Balls, Limits];
            15 "elastic-pair-nose" 5: Elastic<2, { lab::NOSE }>;
                "nothing; that elastic pair, asked for the compliance at its nose",
                [RaceControl, Balls, Limits];
            16 "full" 5: Ring<RacewayControlFree>;
                "nothing",
                [Spindle, Elastic, RaceControl, Balls, Limits];
        }
    };
}

/// The parts that every image has: an entry that calls `run` for ever, and a panic handler that links only where
/// nothing is `proved`.
#[macro_export]
macro_rules! image {
    ($run:path) => {
        // For the interrupt vectors, which the linker script asks for.
        #[cfg(all(target_os = "none", feature = "monitor"))]
        use stm32f4 as _;

        #[cfg(target_os = "none")]
        #[panic_handler]
        #[allow(unsafe_code, reason = "the function is declared, and there is none")]
        fn panic(_: &core::panic::PanicInfo) -> ! {
            unsafe extern "C" {
                safe fn the_solver_can_panic() -> !;
            }
            the_solver_can_panic()
        }

        #[cfg(target_os = "none")]
        #[cortex_m_rt::entry]
        fn main() -> ! {
            loop {
                $run();
            }
        }

        #[cfg(not(target_os = "none"))]
        fn main() {
            println!("This is for a microcontroller: see host_tests/README.md.");
        }
    };
}

/// Whether the build asks for double precision: `MEASURED_PRECISION` is `f32`, `f64` or not set.
const DOUBLE: bool = match option_env!("MEASURED_PRECISION") {
    None => false,
    Some(name) => match name.as_bytes() {
        b"f32" => false,
        b"f64" => true,
        _ => panic!("MEASURED_PRECISION is f32 or f64"),
    },
};

/// The precision that the build asks for.
pub type Precision = <Choice<DOUBLE> as Chosen>::Real;

/// Double precision, or single.
pub struct Choice<const DOUBLE: bool>;

/// The type of a precision.
pub trait Chosen {
    /// Its numbers.
    type Real: Real;
}

impl Chosen for Choice<false> {
    type Real = f32;
}

impl Chosen for Choice<true> {
    type Real = f64;
}

/// The load, the speed and the tolerance of a solve, SI units.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Question<T, const D: usize> {
    /// Loads.
    pub load: [T; D],
    /// Speed of the shaft, rad/s.
    pub omega: T,
    /// Tolerance of the stiffness.
    pub tolerance: T,
}

/// Most iterations of a solve.
const MOST_ITERATIONS: u16 = 100;

impl<T: Real, const D: usize> Question<T, D> {
    #[inline(always)]
    fn terms(&self) -> (Speed<T>, Settings<T>) {
        let settings = Settings {
            max_iterations: MOST_ITERATIONS,
            tolerance: self.tolerance,
        };
        (Speed::rad_per_s(self.omega), settings)
    }
}

/// The solution.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Answer<T, const D: usize> {
    /// Displacements.
    pub displacement: [T; D],
    /// Stiffness; zeros if it is not asked for.
    pub stiffness: [[T; D]; D],
    /// Iterations.
    pub iterations: u32,
    /// 1; 0 where there is no solution.
    pub solved: u32,
}

impl<T, const D: usize> Answer<T, D> {
    #[inline(always)]
    fn new(displacement: [T; D], stiffness: [[T; D]; D], iterations: u16) -> Self {
        Self {
            displacement,
            stiffness,
            iterations: iterations.into(),
            solved: 1,
        }
    }
}

/// A solver for `D` freedoms, and the numbers that are asked of it.
pub trait Scene<T: Real, const N: usize, const D: usize> {
    /// The shaft turns.
    const AT_SPEED: bool = true;
    /// The solver.
    type Solver<'b>
    where
        T: 'b;
    /// A cold one, unless the design allows none.
    fn solver<'b>(bearing: &'b Bearing<T, N>, design: &Design) -> Option<Self::Solver<'b>>;
    /// Solves, if there is a solution.
    fn solve(solver: &mut Self::Solver<'_>, question: &Question<T, D>) -> Option<Answer<T, D>>;
}

/// Asked of a ring: the displacement alone.
pub const DISPLACEMENT: u8 = 0;
/// Asked of a ring: displacement and stiffness.
pub const STIFFNESS: u8 = 1;
/// Asked of a ring: states of the balls besides.
pub const BALLS: u8 = 2;
/// Asked of a ring: limits that are passed, besides.
pub const LIMITS: u8 = 3;
/// Asked of a spindle: the compliance at its nose, in the place of the stiffness.
pub const NOSE: u8 = 4;

/// The nose, 30 mm in front of the point where loads act, m.
const NOSE_AT: f64 = -0.03;

/// A bearing with three or five freedoms: how its balls move, and the numbers that are asked for.
pub struct Ring<M, const ASKED: u8 = STIFFNESS>(PhantomData<M>);

impl<T: Real, const N: usize, M: Motion, const D: usize, const ASKED: u8> Scene<T, N, D>
    for Ring<M, ASKED>
{
    const AT_SPEED: bool = M::AT_SPEED;
    type Solver<'b>
        = (&'b Bearing<T, N>, Solver<T, N, M, D>)
    where
        T: 'b;

    #[inline(always)]
    fn solver<'b>(bearing: &'b Bearing<T, N>, _: &Design) -> Option<Self::Solver<'b>> {
        Some((bearing, Solver::of()))
    }

    #[inline(always)]
    fn solve(
        (bearing, solver): &mut Self::Solver<'_>,
        question: &Question<T, D>,
    ) -> Option<Answer<T, D>> {
        let (speed, settings) = question.terms();
        let s = solver
            .solve(bearing, question.load, speed, &settings)
            .ok()?;
        match ASKED {
            BALLS => {
                for ball in s.balls() {
                    black_box(&ball);
                }
            }
            LIMITS => {
                black_box(&s.margins(&Limits::default()));
            }
            _ => {}
        }
        let stiffness = match ASKED {
            DISPLACEMENT => [[T::ZERO; D]; D],
            _ => s.stiffness(),
        };
        Some(Answer::new(s.displacement, stiffness, s.iterations))
    }
}

/// A bearing under axial load: one ball stands for all.
pub struct Axial<M>(PhantomData<M>);

impl<T: Real, const N: usize, M: Motion> Scene<T, N, 1> for Axial<M> {
    const AT_SPEED: bool = M::AT_SPEED;
    type Solver<'b>
        = (&'b Bearing<T, N>, AxialSolver<T, M>)
    where
        T: 'b;

    #[inline(always)]
    fn solver<'b>(bearing: &'b Bearing<T, N>, _: &Design) -> Option<Self::Solver<'b>> {
        Some((bearing, AxialSolver::of()))
    }

    #[inline(always)]
    fn solve(
        (bearing, solver): &mut Self::Solver<'_>,
        question: &Question<T, 1>,
    ) -> Option<Answer<T, 1>> {
        let (speed, settings) = question.terms();
        let s = solver
            .solve(bearing, question.load[0], speed, &settings)
            .ok()?;
        Some(Answer::new(
            [s.displacement],
            [[s.stiffness()]],
            s.iterations,
        ))
    }
}

/// The rows of a shaft, half of them on each side, and the distance of the groove centres.
#[inline(always)]
fn rows<'b, T: Real, const R: usize, const N: usize>(
    bearing: &'b Bearing<T, N>,
    design: &Design,
    first: f64,
    preload: impl Fn(Facing, T) -> Preload<T>,
) -> [Mounted<'b, T, N>; R] {
    let grooves = design.inner_groove_factor + design.outer_groove_factor - 1.0;
    let distance = T::of(grooves * design.ball_diameter);
    core::array::from_fn(|i| {
        let facing = if i < R / 2 {
            Facing::PlusX
        } else {
            Facing::MinusX
        };
        let position = T::of(0.3 * design.pitch_diameter * (first + i as f64));
        Mounted::new(bearing, position, facing).with(preload(facing, distance))
    })
}

/// A spindle and its solver.
type OnBoard<'b, T, const R: usize, const N: usize, const F: usize, const E: usize> = (
    Spindle<'b, T, R, N, F, E>,
    SpindleSolver<T, R, N, RacewayControlFree, F, E>,
);

#[inline(always)]
fn solve_shaft<T: Real, const R: usize, const N: usize, const F: usize, const E: usize>(
    (spindle, solver): &mut OnBoard<'_, T, R, N, F, E>,
    question: &Question<T, 5>,
    asked: u8,
) -> Option<Answer<T, 5>> {
    let (speed, settings) = question.terms();
    let s = solver
        .solve(spindle, question.load, speed, &settings)
        .ok()?;
    let stiffness = match asked {
        NOSE => s.compliance_at(T::of(NOSE_AT)),
        _ => s.stiffness(),
    };
    Some(Answer::new(s.displacement, stiffness, s.iterations))
}

/// `R` bearings on one shaft, back to back, each clamped by a fiftieth of the distance of the groove centres.
pub struct Clamped<const R: usize>;

impl<T: Real, const N: usize, const R: usize> Scene<T, N, 5> for Clamped<R> {
    type Solver<'b>
        = OnBoard<'b, T, R, N, 5, 0>
    where
        T: 'b;

    #[inline(always)]
    fn solver<'b>(bearing: &'b Bearing<T, N>, design: &Design) -> Option<Self::Solver<'b>> {
        let rows = rows(bearing, design, 0.0, |_, distance| {
            Preload::Closure(T::of(0.02) * distance)
        });
        let spindle = Spindle::new(Arrangement::BackToBack, rows).ok()?;
        Some((spindle, SpindleSolver::of()))
    }

    #[inline(always)]
    fn solve(solver: &mut Self::Solver<'_>, question: &Question<T, 5>) -> Option<Answer<T, 5>> {
        solve_shaft(solver, question, STIFFNESS)
    }
}

/// The rows of [`Clamped`] on a hollow steel shaft, from two distances in front of them on, each on an elastic support.
pub struct Elastic<const R: usize, const ASKED: u8 = STIFFNESS>;

/// Hollow, 50 mm thick.
const SECTION: Section = Section {
    from: -1.0,
    to: 1.0,
    outer: 0.05,
    inner: 0.02,
};
static SHAFT: (Shaft<f32, 1>, Shaft<f64, 1>) = (
    Shaft::<f32, 1>::const_new(&[SECTION], &Material::STEEL),
    Shaft::<f64, 1>::const_new(&[SECTION], &Material::STEEL),
);

/// A precision that there is a shaft in.
pub trait OnShaft: Real {
    /// The shaft.
    fn shaft() -> &'static Shaft<Self, 1>;
}

impl OnShaft for f32 {
    fn shaft() -> &'static Shaft<Self, 1> {
        &SHAFT.0
    }
}

impl OnShaft for f64 {
    fn shaft() -> &'static Shaft<Self, 1> {
        &SHAFT.1
    }
}

impl<T: OnShaft, const N: usize, const R: usize, const ASKED: u8> Scene<T, N, 5>
    for Elastic<R, ASKED>
{
    type Solver<'b>
        = OnBoard<'b, T, R, N, 5, R>
    where
        T: 'b;

    #[inline(always)]
    fn solver<'b>(bearing: &'b Bearing<T, N>, design: &Design) -> Option<Self::Solver<'b>> {
        let rows = rows(bearing, design, 2.0, |_, distance| {
            Preload::Closure(T::of(0.02) * distance)
        });
        let spindle = Spindle::new(Arrangement::BackToBack, rows).ok()?;
        let housing = Support {
            axial: T::of(5e8),
            radial: T::of(5e8),
            tilting: T::of(1e6),
        };
        let spindle = spindle.elastic(T::shaft(), [housing; R]).ok()?;
        Some((spindle, SpindleSolver::of()))
    }

    #[inline(always)]
    fn solve(solver: &mut Self::Solver<'_>, question: &Question<T, 5>) -> Option<Answer<T, 5>> {
        solve_shaft(solver, question, ASKED)
    }
}

/// `R` bearings, the rear half in a sleeve, whose spring has 0.3 N for each ball and square millimetre of its diameter.
pub struct Sprung<const R: usize>;

impl<T: Real, const N: usize, const R: usize> Scene<T, N, 5> for Sprung<R> {
    type Solver<'b>
        = OnBoard<'b, T, R, N, 6, 0>
    where
        T: 'b;

    #[inline(always)]
    fn solver<'b>(bearing: &'b Bearing<T, N>, design: &Design) -> Option<Self::Solver<'b>> {
        let rows = rows(bearing, design, 0.0, |facing, _| match facing {
            Facing::PlusX => Preload::Closure(T::ZERO),
            Facing::MinusX => Preload::Spring,
        });
        let force = 0.3e6 * N as f64 * design.ball_diameter * design.ball_diameter;
        let spindle = Spindle::sprung(Arrangement::BackToBack, rows, T::of(force)).ok()?;
        Some((spindle, SpindleSolver::of()))
    }

    #[inline(always)]
    fn solve(solver: &mut Self::Solver<'_>, question: &Question<T, 5>) -> Option<Answer<T, 5>> {
        solve_shaft(solver, question, STIFFNESS)
    }
}

/// Code that must not be there: the check has to find it.
pub fn spoiled() {
    struct Unread;
    impl Write for Unread {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            black_box(text);
            Ok(())
        }
    }
    let numbers = black_box([1.0_f64; 4]);
    black_box(numbers[black_box(3)] * 3.0);
    black_box(write!(Unread, "{}", black_box(1_u32)).is_ok());
}

/// Whatever a firmware calls of a bearing, on input that the compiler does not know.
pub fn ring<T: Real, const N: usize, M: Motion, const D: usize>(bearing: &Bearing<T, N>) {
    let mut solver = Solver::<T, N, M, D>::of();
    while black_box(true) {
        let (load, speed) = black_box(([T::ONE; D], Speed::rad_per_s(T::ONE)));
        let settings = black_box(Settings::default());
        let solution = if black_box(true) {
            solver.solve(bearing, load, speed, &settings)
        } else {
            let given = black_box([Given::Displacement(T::ONE); D]);
            let at = black_box(speed.with_growth([Growth::NONE]));
            solver.solve(bearing, given, at, &settings)
        };
        match solution {
            Ok(solution) => {
                for (ball, force) in solution.balls().zip(solution.inner_forces()) {
                    black_box((ball, force));
                }
                for speed in solution.cage_speeds() {
                    black_box(speed);
                }
                let margins = solution.margins(&Limits::default());
                black_box(margins.passed().iter().count());
                black_box(margins.get(Limit::Shoulder));
                black_box(solution.stiffness());
                black_box(solution.snapshot());
                for ball in solution.kinematics() {
                    black_box(ball);
                }
                black_box(solution.frequencies());
                black_box(solution);
            }
            Err(status) => {
                black_box(status);
            }
        }
        if black_box(true) {
            solver.reset();
        }
    }
}
