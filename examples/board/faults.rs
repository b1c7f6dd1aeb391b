//! Ways out of a panic and of a fault. A monitor is without its operator: say what happened, and start
//! again.

use super::log;
use core::panic::PanicInfo;
use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    // A panic inside the log itself has no way to tell.
    if log::is_free() {
        let (file, line) = info
            .location()
            .map_or(("?", 0), |place| (place.file(), place.line()));
        let what = info.message().as_str().unwrap_or("panic");
        defmt::error!(
            "panic at {=str}:{=u32}: {=str}, starting again",
            file,
            line,
            what
        );
        defmt::flush();
    }
    SCB::sys_reset()
}

#[exception]
#[allow(unsafe_code, reason = "a fault handler is declared unsafe")]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    if log::is_free() {
        defmt::error!("hard fault at {=u32:#x}, starting again", frame.pc());
        defmt::flush();
    }
    SCB::sys_reset()
}
