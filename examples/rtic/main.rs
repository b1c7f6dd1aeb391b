//! Two bearings back to back, followed in an application for RTIC 2.
//!
//! The compiler makes the pair and the solver, all of whose bits are zero. A constant load is in the place of a measured one.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("for a board: cargo build --release --target thumbv7em-none-eabihf -p rtic_pair");
}

#[cfg(target_os = "none")]
#[rtic::app(device = stm32f4::stm32f405)]
mod app {
    use cortex_m::peripheral::syst::SystClkSource;
    use defmt_rtt as _;
    use spindle_bearing::nalgebra::SMatrix;
    use spindle_bearing::{Arrangement, Bearing, Design, Facing, Limit, Limits, Mounted, Preload};
    use spindle_bearing::{
        Settings, Speed, Spindle, SpindleSolution, SpindleSolver, Status, matrix,
    };

    const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
    const SPEED: Speed<f32> = Speed::rpm(20_000.0);
    const LIMITS: Limits<f32> = Limits {
        peak_pressure: 2e9,
        ..Limits::DEFAULT
    };
    const PRELOAD: Preload<f32> = Preload::Force(200.0);
    static PAIR: Spindle<f32, 2, 15> = Spindle::<f32, 2, 15>::const_new(
        Arrangement::BackToBack,
        [
            Mounted::new(&BEARING, 0.0, Facing::PlusX).with(PRELOAD),
            Mounted::new(&BEARING, 0.1, Facing::MinusX).with(PRELOAD),
        ],
    );
    type Solver = SpindleSolver<f32, 2, 15>;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        solver: &'static mut Solver,
        /// Ticks since the last good estimate.
        age: u32,
    }

    #[init(local = [memory: Solver = Solver::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let solver = cx.local.memory;
        // The first solve has no solution to start from, and takes its time.
        let _ = solver
            .solve(&PAIR, [0.0; 5], SPEED, &Settings::DEFAULT)
            .is_ok();
        // A tick of 5 ms of the 16 MHz that the core starts with: a solve and its margins take some 3.5 ms. A board's clock of
        // 168 MHz has the time for a tick of 1 ms.
        let mut timer = cx.core.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(80_000 - 1);
        timer.enable_counter();
        timer.enable_interrupt();
        (Shared {}, Local { solver, age: 0 })
    }

    /// Stiffness, how far it can be off, and whether a contact is pressed too hard.
    fn estimate(solution: &SpindleSolution<'_, f32, 2, 15>) -> (SMatrix<f32, 5, 5>, f32, bool) {
        let mut rows = solution.rows();
        let pressed = rows.any(|row| row.margins(&LIMITS).passed().contains(Limit::PeakPressure));
        (
            matrix(&solution.stiffness()),
            solution.error.stiffness,
            pressed,
        )
    }

    #[task(binds = SysTick, local = [solver, age])]
    fn tick(cx: tick::Context) {
        let tick::LocalResources { solver, age, .. } = cx.local;
        let load = [0.0, 150.0, 0.0, 0.0, 0.0];
        let found = match solver
            .solve(&PAIR, load, SPEED, &Settings::TICK)
            .map(|s| estimate(&s))
        {
            // The state that this tick has reached; the next one goes on from there.
            Err(Status::IterationLimit) => solver.unfinished(&PAIR).map(|s| estimate(&s)),
            found => found.inspect_err(|status| defmt::warn!("{}", status)).ok(),
        };
        *age = age.saturating_add(1);
        // An unfinished state may say no more than that.
        if let Some((stiffness, _, pressed)) = found.filter(|(_, error, _)| *error < 1e-2) {
            *age = 0;
            defmt::info!("{} N/m", stiffness[(1, 1)]);
            if pressed {
                defmt::error!("a contact is above 2 GPa");
            }
        }
        if *age == 100 {
            defmt::error!("the stiffness is 100 ticks old");
        }
    }
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        cortex_m::asm::bkpt();
    }
}
