//! The monitor's chain, as `cargo reports` wants it: an emulator calls an entry point tick by tick,
//! with the bytes of the port at fixed symbols. See `measured.rs`, which has the solver alone.
//!
//! `MEASURED_CORE` of `cortex-m7` makes it the STM32H743's chain, and otherwise the STM32F405's.

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
    use spindle_firmware::chain::{self, Chain, SpindleMonitor, SpindleProbes};
    use spindle_firmware::spindle::{PERIOD_US, monitor_settings};
    use spindle_firmware::spindle::{PROBES, ROWS};
    use spindle_monitor::Past;
    use spindle_monitor::settings::MonitorSettings;
    use spindle_monitor::tick::{Core, CycleCounter, NoWatchdog};

    const IS_M7: bool = option_env!("MEASURED_CORE").is_some();
    static MONITOR: MonitorSettings<ROWS> = if IS_M7 {
        monitor_settings(&Core::STM32H743)
    } else {
        monitor_settings(&Core::STM32F405)
    };

    /// Bytes that come in before a tick, at most.
    const INPUT: usize = 1024;
    /// Bytes that go out after it, at most.
    const OUTPUT: usize = 8192;

    #[unsafe(no_mangle)]
    static mut MEASURED_INPUT: [u8; INPUT] = [0; INPUT];
    #[unsafe(no_mangle)]
    static mut MEASURED_OUTPUT: [u8; OUTPUT] = [0; OUTPUT];
    /// Bytes that come in, bytes that the link takes, and the result: bytes that went out.
    #[unsafe(no_mangle)]
    static mut MEASURED_TICK: [u32; 3] = [0; 3];

    static mut MADE: MaybeUninit<SpindleMonitor> = MaybeUninit::uninit();
    static mut SEEN: MaybeUninit<SpindleProbes> = MaybeUninit::uninit();
    static mut CHAIN: MaybeUninit<Chain<&'static mut SpindleMonitor>> = MaybeUninit::uninit();
    static mut TIME_US: u64 = 0;

    /// The core's counter of cycles, a register that the emulator moves on whenever it is read.
    #[unsafe(no_mangle)]
    static mut MEASURED_CYCLES: u32 = 0;

    struct Cycles;

    impl CycleCounter for Cycles {
        fn cycles(&mut self) -> u32 {
            // SAFETY: nobody else looks at it meanwhile.
            unsafe { (&raw const MEASURED_CYCLES).read_volatile() }
        }
    }

    /// Builds the chain and solves a first equilibrium; 1 if there is one.
    ///
    /// # Safety
    ///
    /// Of both entry points: one thread, this one first.
    #[unsafe(no_mangle)]
    unsafe extern "C" fn measured_prepare() -> u32 {
        // SAFETY: one thread, and no reference to it is left from before.
        let chain = unsafe {
            let (made, seen, built) = (&raw mut MADE, &raw mut SEEN, &raw mut CHAIN);
            let probes = (PROBES != 0).then(|| (*seen).write(chain::probes(&MONITOR)));
            let monitor = chain::make(&mut *made, probes, &Past::default(), &MONITOR);
            (*built).write(Chain::new(monitor))
        };
        u32::from(chain.prepare().is_ok())
    }

    /// Does a period of the firmware's timer: bytes in, a tick, bytes out.
    ///
    /// # Safety
    ///
    /// As for [`measured_prepare`].
    #[unsafe(no_mangle)]
    unsafe extern "C" fn measured_tick() {
        // SAFETY: the chain was built, nobody else looks at any of this meanwhile, and every bit pattern
        // is one of theirs.
        let (chain, input, output, tick, time_us) = unsafe {
            let built = &raw mut CHAIN;
            (
                (*built).assume_init_mut(),
                &*(&raw const MEASURED_INPUT).cast::<[u8; INPUT]>(),
                &mut *(&raw mut MEASURED_OUTPUT).cast::<[u8; OUTPUT]>(),
                &mut *(&raw mut MEASURED_TICK).cast::<[u32; 3]>(),
                &mut *(&raw mut TIME_US).cast::<u64>(),
            )
        };
        let [length, room, ..] = *black_box(&mut *tick);
        for byte in black_box(input).iter().take(length as usize) {
            let _ = chain.push(*byte, false);
        }
        chain.tick(*time_us, &mut Cycles, &mut NoWatchdog);
        *time_us = time_us.saturating_add(PERIOD_US.into());
        let mut sent = 0;
        for to in black_box(&mut *output).iter_mut().take(room as usize) {
            let Some(byte) = chain.next_byte() else {
                break;
            };
            *to = byte;
            sent += 1;
        }
        *black_box(tick) = [length, room, sent];
    }

    /// Takes the addresses of the entry points, so that the linker keeps them, each a function by itself.
    pub fn keep() {
        black_box(measured_tick as unsafe extern "C" fn());
        black_box(measured_prepare as unsafe extern "C" fn() -> u32);
    }
}
