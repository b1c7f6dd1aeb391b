//! The solver and nothing else, as `cargo check-firmware` wants it: whatever a firmware calls of the
//! library, on input that the compiler does not know.
//!
//! Its panic handler calls a function that does not exist. So the program links only if the compiler
//! has proved every panic out of it, and that it links at all is the proof.

#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

lab::image!(bare::run);

#[cfg(target_os = "none")]
mod bare {
    use core::hint::black_box;
    use lab::{ring, spoiled};
    use spindle_bearing::{
        AxialSolver, Bearing, Centrifugal, Given, Growth, Motion, RacewayControlFree, Settings,
        Speed, Static,
    };
    use spindle_bearing::{InnerRaceControl, OuterRaceControl, Real, elliptic_integrals};
    use spindle_firmware::spindle::{BEARING_0, DESIGN_0};

    pub fn run() {
        // The check builds all of these, the last one to see itself fail.
        match option_env!("BARE_SOLVER") {
            None => single(),
            Some("double") => double(),
            Some(_) => spoiled(),
        }
    }

    /// Functions that firmware in single precision uses, for a design that the compiler works out.
    fn single() {
        every_scene(&BEARING_0);
    }

    /// Double precision, and bearings of designs that only turn up at run time.
    fn double() {
        let design = black_box(DESIGN_0);
        if let Ok(bearing) = Bearing::<f32, 16>::new(&design) {
            every_scene(&bearing);
        }
        if let Ok(bearing) = Bearing::<f64, 16>::new(&design) {
            every_scene(&bearing);
        }
        black_box(elliptic_integrals(black_box(0.5)));
    }

    fn every_scene<T: Real, const N: usize>(bearing: &Bearing<T, N>) {
        motion::<T, N, Static>(bearing);
        motion::<T, N, Centrifugal>(bearing);
        motion::<T, N, RacewayControlFree>(bearing);
        motion::<T, N, OuterRaceControl>(bearing);
        motion::<T, N, InnerRaceControl>(bearing);
    }

    fn motion<T: Real, const N: usize, M: Motion>(bearing: &Bearing<T, N>) {
        ring::<T, N, M, 5>(bearing);
        ring::<T, N, M, 3>(bearing);
        axial::<T, N, M>(bearing);
    }

    fn axial<T: Real, const N: usize, M: Motion>(bearing: &Bearing<T, N>) {
        let mut solver = AxialSolver::<T, M>::of();
        while black_box(true) {
            let (load, speed) = black_box((T::ONE, Speed::rad_per_s(T::ONE)));
            let settings = black_box(Settings::default());
            let solution = if black_box(true) {
                solver.solve(bearing, load, speed, &settings)
            } else {
                let given = black_box(Given::Displacement(T::ONE));
                let at = black_box(speed.with_growth([Growth::NONE]));
                solver.solve(bearing, given, at, &settings)
            };
            match solution {
                Ok(solution) => {
                    black_box(solution.ball());
                    black_box(solution.stiffness());
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
}
