//! One solver, for `cargo reports` and `cargo check-firmware`: entry points that an emulator calls one at a time,
//! each with its input and its output at fixed symbols.
//!
//! Precision, ball count and scene are the build's to say (`MEASURED_PRECISION`, `MEASURED_BALLS`,
//! `MEASURED_SCENE`), so that a program has one solver, inlined as it would be in a firmware. It is
//! linked as a firmware is, but never started: who measures calls the entry points by their symbols.
//!
//! Where `PROVED` is set, its panic handler calls a function that does not exist, so that it links only without
//! panics.

#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

// For the interrupt vectors, which the linker script asks for.
#[cfg(target_os = "none")]
extern crate stm32f4;

#[cfg(target_os = "none")]
#[allow(
    unsafe_code,
    reason = "symbols that a debugger finds, in memory that it writes"
)]
mod measured {
    use core::hint::black_box;
    use core::mem::MaybeUninit;
    use probes::{
        Answer, Axial, Balls, Clamped, Displacement, Loads, Passed, Question, RigidPreload, Ring,
        Scene, Shaft, Sprung, for_every_scene,
    };
    use spindle_bearing::{Bearing, Centrifugal, Full, Static};
    use spindle_bearing::{Design, FreeContact, InnerRaceControl, Material, OuterRaceControl};

    struct Choice<const I: usize>;
    trait Precision {
        type T: spindle_bearing::Real;
    }
    impl Precision for Choice<0> {
        type T = f32;
    }
    impl Precision for Choice<1> {
        type T = f64;
    }
    trait Chosen {
        type Scene: Scene<T, BALLS>;
    }

    macro_rules! scenes {
        ($($number:literal $name:literal: $scene:ty;
            $attitude:expr, $without:literal, $double:literal, $parts:tt;)*) => {
            $(impl Chosen for Choice<$number> {
                type Scene = $scene;
            })*
            const fn number(name: &[u8]) -> usize {
                $(if same(name, $name.as_bytes()) {
                    return $number;
                })*
                panic!("MEASURED_SCENE is the name of no scene")
            }
        };
    }
    for_every_scene!(scenes);

    const fn same(a: &[u8], b: &[u8]) -> bool {
        let mut i = 0;
        while i < a.len() && i < b.len() && a[i] == b[i] {
            i += 1;
        }
        i == a.len() && i == b.len()
    }

    const fn text(value: Option<&'static str>) -> &'static [u8] {
        match value {
            Some(text) => text.as_bytes(),
            None => b"",
        }
    }
    const PRECISION: usize = match text(option_env!("MEASURED_PRECISION")) {
        b"" | b"f32" => 0,
        b"f64" => 1,
        _ => panic!("MEASURED_PRECISION is f32 or f64"),
    };
    const SCENE: usize = match text(option_env!("MEASURED_SCENE")) {
        b"" => number(b"full"),
        name => number(name),
    };
    const BALLS: usize = match text(option_env!("MEASURED_BALLS")) {
        [] => 16,
        [ones @ b'0'..=b'9'] => (*ones - b'0') as usize,
        [tens @ b'0'..=b'9', ones @ b'0'..=b'9'] => {
            (*tens - b'0') as usize * 10 + (*ones - b'0') as usize
        }
        _ => panic!("MEASURED_BALLS is a number of balls below 100"),
    };

    type T = <Choice<PRECISION> as Precision>::T;
    type Measured = <Choice<SCENE> as Chosen>::Scene;
    type Vector = <Measured as Scene<T, BALLS>>::Vector;
    type Matrix = <Measured as Scene<T, BALLS>>::Matrix;
    type Solver = <Measured as Scene<T, BALLS>>::Solver<'static>;
    type Asked = Question<T, Vector>;
    type Told = Answer<T, Vector, Matrix>;

    /// What to build: ball and pitch diameter, groove factors, free contact angle, azimuth of the first
    /// ball; modulus, Poisson's ratio and density of the rings and of the balls.
    #[unsafe(no_mangle)]
    static mut MEASURED_DESIGN: [f64; 12] = [0.0; 12];

    /// What to solve.
    #[unsafe(no_mangle)]
    static mut MEASURED_QUESTION: MaybeUninit<Asked> = MaybeUninit::zeroed();

    /// What came of it.
    #[unsafe(no_mangle)]
    static mut MEASURED_ANSWER: MaybeUninit<Told> = MaybeUninit::zeroed();
    /// For an answer to no question.
    #[unsafe(no_mangle)]
    static mut MEASURED_BLANK: MaybeUninit<Told> = MaybeUninit::zeroed();

    /// Bytes of a solver, of the bearing that it borrows, of a number, and of the answer's displacement
    /// and stiffness.
    #[unsafe(no_mangle)]
    static MEASURED_SIZES: [u32; 5] = [
        size_of::<Solver>() as u32,
        size_of::<Bearing<T, BALLS>>() as u32,
        size_of::<T>() as u32,
        size_of::<Vector>() as u32,
        size_of::<Matrix>() as u32,
    ];

    static mut BEARING: MaybeUninit<Bearing<T, BALLS>> = MaybeUninit::uninit();
    static mut SOLVER: MaybeUninit<Solver> = MaybeUninit::uninit();

    /// Builds the bearing and a cold solver; 1 if the design is in order.
    ///
    /// # Safety
    ///
    /// Of all entry points: one thread, this one first.
    #[unsafe(no_mangle)]
    unsafe extern "C" fn measured_build() -> u32 {
        // SAFETY: one thread, and no reference to any of it is left from before.
        unsafe {
            let d = (&raw const MEASURED_DESIGN).read_volatile();
            let material = |m: &[f64]| Material {
                youngs_modulus: m[0],
                poissons_ratio: m[1],
                density: m[2],
            };
            let design = Design {
                ball_diameter: d[0],
                pitch_diameter: d[1],
                inner_groove_factor: d[2],
                outer_groove_factor: d[3],
                free_contact: FreeContact::Angle(d[4]),
                inner_shoulder_angle: Design::HIGHEST_SHOULDER,
                outer_shoulder_angle: Design::HIGHEST_SHOULDER,
                first_ball: d[5],
                ring: material(&d[6..9]),
                ball: material(&d[9..12]),
            };
            let Ok(bearing) = Bearing::<T, BALLS>::new(&design) else {
                return 0;
            };
            let built = (&raw mut BEARING).cast::<Bearing<T, BALLS>>();
            built.write(bearing);
            let Some(solver) = Measured::solver(&*built, &design) else {
                return 0;
            };
            (&raw mut SOLVER).cast::<Solver>().write(solver);
            1
        }
    }

    /// Makes the next solve a cold one.
    ///
    /// # Safety
    ///
    /// As for [`measured_build`].
    #[unsafe(no_mangle)]
    unsafe extern "C" fn measured_reset() {
        // SAFETY: the solver was built.
        Measured::reset(unsafe { &mut *(&raw mut SOLVER).cast::<Solver>() });
    }

    /// Solves.
    ///
    /// # Safety
    ///
    /// As for [`measured_build`].
    #[unsafe(no_mangle)]
    unsafe extern "C" fn measured_solve() {
        // SAFETY: the solver was built, and every bit pattern is a question.
        unsafe {
            // Firmware may have it anywhere: where it is known to lie, its address is spelled out in every function.
            let solver = &mut *black_box((&raw mut SOLVER).cast::<Solver>());
            let question = (&raw const MEASURED_QUESTION).read_volatile().assume_init();
            let answer = match Measured::solve(solver, &question) {
                Ok(answer) => answer,
                Err(_) => {
                    let mut none = (&raw const MEASURED_BLANK).read_volatile().assume_init();
                    none.status = 0;
                    none
                }
            };
            (&raw mut MEASURED_ANSWER).write_volatile(MaybeUninit::new(answer));
        }
    }

    /// Everything that `measured_solve` does but solve: reads the question and copies an answer that is
    /// somewhere in memory.
    ///
    /// # Safety
    ///
    /// As for [`measured_build`].
    #[unsafe(no_mangle)]
    unsafe extern "C" fn measured_nothing() {
        // SAFETY: the question is there, and nobody looks into this answer.
        unsafe {
            let _ = (&raw const MEASURED_QUESTION).read_volatile();
            let answer = black_box(MaybeUninit::<Told>::uninit());
            (&raw mut MEASURED_ANSWER).write_volatile(answer);
        }
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        unsafe extern "C" {
            safe fn the_solver_can_panic() -> !;
        }
        if option_env!("PROVED").is_some() {
            the_solver_can_panic()
        }
        loop {}
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        loop {
            // Takes their addresses, so that the linker keeps them, each a function by itself.
            let entries: [unsafe extern "C" fn(); 3] =
                [measured_nothing, measured_solve, measured_reset];
            black_box(entries);
            black_box(measured_build as unsafe extern "C" fn() -> u32);
            black_box(&raw const MEASURED_SIZES);
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This is for a microcontroller: `cargo reports` calls what is in it on an emulated one."
    );
}
