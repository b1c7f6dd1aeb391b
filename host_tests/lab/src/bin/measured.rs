//! One solver, for `cargo reports`. An emulator calls its entry points one at a time,
//! each with its input and its output at fixed symbols.
//!
//! The build says the precision (`MEASURED_PRECISION`) and the scene (`MEASURED_SCENE`), so that a program has one
//! solver, inlined as it would be in a firmware. The program is linked as a firmware is, but never started: the
//! emulator calls the entry points by their symbols.
//!
//! The program links only without panics.

#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

lab::image!(measured::keep);

#[cfg(target_os = "none")]
#[allow(
    unsafe_code,
    reason = "symbols that a debugger finds, in memory that it writes"
)]
mod measured {
    use core::hint::black_box;
    use core::mem::MaybeUninit;
    use lab::solves::BALLS;
    use lab::{Answer, Axial, Clamped, Elastic, Precision, Question, Ring, Scene, Sprung};
    use spindle_bearing::{Bearing, Centrifugal, RacewayControlFree, Static};
    use spindle_bearing::{Design, FreeContact, InnerRaceControl, Material, OuterRaceControl};

    struct Choice<const I: usize>;

    trait Chosen {
        const FREEDOMS: usize;
        type Scene;
    }

    macro_rules! scenes {
        ($($number:literal $name:literal $freedoms:literal: $scene:ty; $without:literal, $parts:tt;)*) => {
            $(impl Chosen for Choice<$number> {
                const FREEDOMS: usize = $freedoms;
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
    lab::for_every_scene!(scenes);

    const fn same(a: &[u8], b: &[u8]) -> bool {
        let mut i = 0;
        while i < a.len() && i < b.len() && a[i] == b[i] {
            i += 1;
        }
        i == a.len() && i == b.len()
    }

    type Chose = Choice<
        {
            number(match option_env!("MEASURED_SCENE") {
                None => b"full",
                Some(name) => name.as_bytes(),
            })
        },
    >;
    const D: usize = <Chose as Chosen>::FREEDOMS;
    type Measured = <Chose as Chosen>::Scene;
    type Solver = <Measured as Scene<Precision, BALLS, D>>::Solver<'static>;

    /// The design: ball and pitch diameter, groove factors, free contact angle, azimuth of the first ball.
    /// Then modulus, Poisson's ratio and density of the rings and of the balls.
    #[unsafe(no_mangle)]
    static mut MEASURED_DESIGN: [f64; 12] = [0.0; 12];

    #[unsafe(no_mangle)]
    static mut MEASURED_QUESTION: MaybeUninit<Question<Precision, D>> = MaybeUninit::zeroed();

    #[unsafe(no_mangle)]
    static mut MEASURED_ANSWER: MaybeUninit<Answer<Precision, D>> = MaybeUninit::zeroed();

    /// Bytes of a solver.
    #[unsafe(no_mangle)]
    static MEASURED_STATE: u32 = size_of::<Solver>() as u32;

    static mut BEARING: MaybeUninit<Bearing<Precision, BALLS>> = MaybeUninit::uninit();
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
            let Ok(bearing) = Bearing::<Precision, BALLS>::new(&design) else {
                return 0;
            };
            let built = (&raw mut BEARING).cast::<Bearing<Precision, BALLS>>();
            built.write(bearing);
            let Some(solver) = Measured::solver(&*built, &design) else {
                return 0;
            };
            (&raw mut SOLVER).cast::<Solver>().write(solver);
            1
        }
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
            let to = (&raw mut MEASURED_ANSWER).cast::<Answer<Precision, D>>();
            match Measured::solve(solver, &question) {
                Some(answer) => to.write_volatile(answer),
                None => (&raw mut (*to).solved).write_volatile(0),
            }
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
            let answer = black_box(MaybeUninit::<Answer<Precision, D>>::uninit());
            (&raw mut MEASURED_ANSWER).write_volatile(answer);
        }
    }

    /// Takes the addresses of the entry points, so that the linker keeps them, each a function by itself.
    pub fn keep() {
        let entries: [unsafe extern "C" fn(); 2] = [measured_nothing, measured_solve];
        black_box(entries);
        black_box(measured_build as unsafe extern "C" fn() -> u32);
        black_box(&raw const MEASURED_STATE);
    }
}
