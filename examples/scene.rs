//! A firmware with one scene and nothing else, as `cargo check-firmware` wants it: it looks whether
//! anything is in there that the scene leaves out.
//!
//! Which scene is the build's to say (`SCENE`), and which precision (`SCENE_PRECISION`, `f32` or
//! `f64`). Its panic handler calls a function that does not exist, so that it links only without panics.

#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

#[cfg(target_os = "none")]
#[allow(dead_code, reason = "the monitor's, too")]
mod monitored;
/// That of the smaller core.
#[cfg(target_os = "none")]
type Precision = f32;
// For the interrupt vectors, which the linker script asks for.
#[cfg(target_os = "none")]
extern crate stm32f4;

#[cfg(target_os = "none")]
mod scene {
    use super::monitored::{BALLS, DESIGN};
    use core::hint::black_box;
    use spindle_bearing::{
        All, Axial, BallStore, Bearing, Centrifugal, Conditions, Displacements, Freedoms, Full,
        Loads, Motion, OuterRaceControl, Outputs, Real, RigidPreload, Settings, Solver, Static,
        Stiffness, Translations,
    };

    #[panic_handler]
    #[allow(unsafe_code, reason = "the function is declared, and there is none")]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        unsafe extern "C" {
            safe fn the_solver_can_panic() -> !;
        }
        the_solver_can_panic()
    }

    struct Choice<const I: usize>;
    trait Precision: Real {
        const BEARING: &'static Bearing<Self, BALLS>;
    }
    impl Precision for f32 {
        const BEARING: &'static Bearing<f32, BALLS> = {
            static BEARING: Bearing<f32, BALLS> = Bearing::<f32, BALLS>::checked(&DESIGN);
            &BEARING
        };
    }
    impl Precision for f64 {
        const BEARING: &'static Bearing<f64, BALLS> = {
            static BEARING: Bearing<f64, BALLS> = Bearing::<f64, BALLS>::checked(&DESIGN);
            &BEARING
        };
    }
    trait Scene {
        fn run<T: Precision>();
    }

    macro_rules! scenes {
        ($($number:literal $name:literal: $motion:ty, $freedoms:ty, $given:ty, $output:ty;)*) => {
            $(impl Scene for Choice<$number> {
                fn run<T: Precision>() {
                    solve::<T, _, $motion, $given, $output, _>(Solver::<
                        T, BALLS, $motion, $freedoms, $given, $output,
                    >::new(T::BEARING));
                }
            })*
            const fn number(name: &str) -> usize {
                $(if same(name.as_bytes(), $name.as_bytes()) {
                    return $number;
                })*
                panic!("SCENE is the name of no scene")
            }
        };
    }
    scenes! {
        0 "axial-static": Static, Axial, Loads, Stiffness;
        1 "axial-centrifugal": Centrifugal, Axial, Loads, Stiffness;
        2 "axial-full": Full, Axial, Loads, Stiffness;
        3 "translations-static": Static, Translations, Loads, Stiffness;
        4 "translations-full": Full, Translations, Loads, Stiffness;
        5 "all-static": Static, All, Loads, Stiffness;
        6 "all-centrifugal": Centrifugal, All, Loads, Stiffness;
        7 "all-outer": Full<OuterRaceControl>, All, Loads, Stiffness;
        8 "all-full": Full, All, Loads, Stiffness;
        9 "all-displacements": Full, All, Loads, Displacements;
        10 "all-preloaded": Full, All, RigidPreload, Stiffness;
    }

    const fn same(a: &[u8], b: &[u8]) -> bool {
        let mut i = 0;
        while i < a.len() && i < b.len() && a[i] == b[i] {
            i += 1;
        }
        i == a.len() && i == b.len()
    }

    const SCENE: usize = number(match option_env!("SCENE") {
        Some(name) => name,
        None => "all-full",
    });
    const DOUBLE: bool = match option_env!("SCENE_PRECISION") {
        Some(name) => same(name.as_bytes(), b"f64"),
        None => false,
    };
    trait Chosen {
        type T: Precision;
    }
    impl Chosen for Choice<0> {
        type T = f32;
    }
    impl Chosen for Choice<1> {
        type T = f64;
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        loop {
            <Choice<SCENE> as Scene>::run::<<Choice<{ DOUBLE as usize }> as Chosen>::T>();
        }
    }

    fn solve<T, const D: usize, M, B, O, const N: usize>(
        mut solver: Solver<'_, T, N, M, Freedoms<D>, B, O>,
    ) where
        T: Real,
        M: Motion,
        Freedoms<D>: BallStore,
        B: Conditions<Freedoms<D>>,
        O: Outputs,
    {
        while black_box(true) {
            let settings = black_box(Settings::default());
            solve_once(
                &mut solver,
                black_box([T::ONE; D]),
                black_box(T::ONE),
                &settings,
            );
        }
    }

    /// By itself, so that its size is the solver's.
    #[inline(never)]
    fn solve_once<T, const D: usize, M, B, O, const N: usize>(
        solver: &mut Solver<'_, T, N, M, Freedoms<D>, B, O>,
        values: [T; D],
        speed: T,
        settings: &Settings<T>,
    ) where
        T: Real,
        M: Motion,
        Freedoms<D>: BallStore,
        B: Conditions<Freedoms<D>>,
        O: Outputs,
    {
        match solver.solve(values, speed, settings) {
            Ok(solution) => {
                black_box((
                    solution.status,
                    solution.displacement,
                    solution.load,
                    solution.stiffness,
                ));
            }
            Err(status) => {
                black_box(status);
            }
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This is for `cargo check-firmware`, which looks at what is in it.");
}
