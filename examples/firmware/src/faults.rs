//! Ways out of a panic, of a fault, and of an interrupt that nobody handles.
//!
//! A monitor is without its operator: say what happened, and start again. The next start reports a reset by software.

use crate::log;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};

/// Says what happened, if there is a way, and starts again.
fn start_again(tell: impl FnOnce()) -> ! {
    static TELLING: AtomicBool = AtomicBool::new(false);
    cortex_m::interrupt::disable();
    // A failure inside the log, or while another one is told, has no way to tell.
    if log::is_free() && !TELLING.swap(true, Ordering::Relaxed) {
        tell();
        log::finish();
    }
    SCB::sys_reset()
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    start_again(|| {
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
    })
}

#[exception]
#[allow(unsafe_code, reason = "a fault handler is declared unsafe")]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    start_again(|| defmt::error!("hard fault at {=u32:#x}, starting again", frame.pc()))
}

#[exception]
#[allow(unsafe_code, reason = "so is that of everything else")]
unsafe fn DefaultHandler(number: i16) -> ! {
    start_again(|| defmt::error!("interrupt {=i16} without a handler, starting again", number))
}
