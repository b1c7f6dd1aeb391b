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
    use probes::for_every_scene;
    use spindle_bearing::{
        All, Balls, Bearing, Centrifugal, Conditions, Design, Displacements, FreeContact,
        FreedomSet, Freedoms, Full, InnerRaceControl, Loads, Material, Motion, OuterRaceControl,
        Outputs, RigidPreload, Settings, Solver, Static, Status, Stiffness,
    };

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
    trait Scene {
        type Motion: Motion;
        type Freedoms: FreedomSet;
        type Given: Conditions<Self::Freedoms>;
        type Output: Outputs;
    }

    macro_rules! scenes {
        ($($number:literal $name:literal: $motion:ty, $freedoms:literal, $given:ty, $output:ty;
            $attitude:expr, $without:literal, $double:literal, $parts:tt;)*) => {
            $(impl Scene for Choice<$number> {
                type Motion = $motion;
                type Freedoms = Freedoms<$freedoms>;
                type Given = $given;
                type Output = $output;
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

    /// The whole solver with states of balls, by what decides on their attitude.
    macro_rules! with_balls {
        ($($number:literal: $motion:ty;)*) => {
            $(impl Scene for Choice<$number> {
                type Motion = $motion;
                type Freedoms = All;
                type Given = Loads;
                type Output = Balls;
            })*
        };
    }
    with_balls! {
        100: Full;
        101: Full<OuterRaceControl>;
        102: Full<InnerRaceControl>;
        103: Static;
    }

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
        b"" | b"raceless" => 100,
        b"outer" => 101,
        b"inner" => 102,
        b"static" => 103,
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
    type Chosen = Choice<SCENE>;
    type Set = <Chosen as Scene>::Freedoms;
    type Given = <Chosen as Scene>::Given;
    type Output = <Chosen as Scene>::Output;
    type Measured = Solver<'static, T, BALLS, <Chosen as Scene>::Motion, Set, Given, Output>;
    /// One value for each freedom.
    type Vector = <Set as FreedomSet>::Vector<T>;
    /// As many rows and columns as there are free freedoms; nothing if it is not put out.
    type Matrix = <Output as Outputs>::Stiffness<<Given as Conditions<Set>>::Stiffness<T>>;

    /// What to build: ball and pitch diameter, groove factors, free contact angle, azimuth of the first
    /// ball; modulus, Poisson's ratio and density of the rings and of the balls.
    #[unsafe(no_mangle)]
    static mut MEASURED_DESIGN: [f64; 12] = [0.0; 12];

    /// What to solve.
    #[derive(Clone, Copy)]
    #[repr(C)]
    struct Question {
        values: Vector,
        speed: T,
        tolerance: T,
        max_sweeps: u32,
    }
    #[unsafe(no_mangle)]
    static mut MEASURED_QUESTION: MaybeUninit<Question> = MaybeUninit::zeroed();

    /// What came of it.
    #[derive(Clone, Copy)]
    #[repr(C)]
    struct Answer {
        displacement: Vector,
        stiffness: Matrix,
        error: [T; 3],
        /// 0 if there is no answer, else 1, 2, 3: converged, precision limit, sweep limit.
        status: u32,
        sweeps: u32,
        repeats: u32,
    }
    #[unsafe(no_mangle)]
    static mut MEASURED_ANSWER: MaybeUninit<Answer> = MaybeUninit::zeroed();
    /// For an answer to no question.
    #[unsafe(no_mangle)]
    static mut MEASURED_BLANK: MaybeUninit<Answer> = MaybeUninit::zeroed();

    /// Bytes of a solver, of the bearing that it borrows, of a number, and of the answer's displacement
    /// and stiffness.
    #[unsafe(no_mangle)]
    static MEASURED_SIZES: [u32; 5] = [
        size_of::<Measured>() as u32,
        size_of::<Bearing<T, BALLS>>() as u32,
        size_of::<T>() as u32,
        size_of::<Vector>() as u32,
        size_of::<Matrix>() as u32,
    ];

    static mut BEARING: MaybeUninit<Bearing<T, BALLS>> = MaybeUninit::uninit();
    static mut SOLVER: MaybeUninit<Measured> = MaybeUninit::uninit();

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
            let Ok(bearing) = Bearing::<T, BALLS>::build(&design) else {
                return 0;
            };
            let built = (&raw mut BEARING).cast::<Bearing<T, BALLS>>();
            built.write(bearing);
            (&raw mut SOLVER)
                .cast::<Measured>()
                .write(Solver::new(&*built));
            1
        }
    }

    /// Makes the next solve a cold one.
    ///
    /// # Safety
    ///
    /// As for [`measured_build`].
    #[unsafe(no_mangle)]
    unsafe extern "C" fn measured_forget() {
        // SAFETY: the solver was built.
        unsafe { &mut *(&raw mut SOLVER).cast::<Measured>() }.forget();
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
            let solver = &mut *(&raw mut SOLVER).cast::<Measured>();
            let question = (&raw const MEASURED_QUESTION).read_volatile().assume_init();
            let settings = Settings {
                tolerance: question.tolerance,
                max_sweeps: question.max_sweeps as u16,
            };
            let answer = match solver.solve(question.values, question.speed, &settings) {
                Ok(solution) => Answer {
                    displacement: solution.displacement,
                    stiffness: solution.stiffness,
                    error: [
                        solution.error.displacement,
                        solution.error.force,
                        solution.error.stiffness,
                    ],
                    status: match solution.status {
                        Status::Converged => 1,
                        Status::PrecisionLimit => 2,
                        _ => 3,
                    },
                    sweeps: u32::from(solution.sweeps),
                    repeats: u32::from(solution.repeats),
                },
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
            let answer = black_box(MaybeUninit::<Answer>::uninit());
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
                [measured_nothing, measured_solve, measured_forget];
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
