//! Ways out of a panic, of a fault, and of an interrupt that nobody handles.
//!
//! A monitor is without its operator: say what happened, and start again. The next start reports a reset by software. A stack
//! that was used up is told again at the next start: the log may have been what used it up.

#![allow(
    unsafe_code,
    reason = "handlers of faults, and what the core has left on the stack"
)]

use crate::{log, memory};
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

// A stack that is used up has no room for a handler, which therefore begins where the stack does: nothing goes back from it.
// cortex-m-rt's own entry of the handler stays on the old stack.
core::arch::global_asm!(
    ".pushsection .HardFaultTrampoline, \"ax\", %progbits",
    ".global HardFault",
    ".type HardFault, %function",
    ".thumb_func",
    "HardFault:",
    "mov r0, sp",
    "ldr r1, =_stack_start",
    "mov sp, r1",
    "b {handler}",
    ".size HardFault, . - HardFault",
    ".popsection",
    handler = sym hard_fault,
);

/// A fault, whose frame is at the end of the stack, or would be if there were room for it.
extern "C" fn hard_fault(frame: *const ExceptionFrame) -> ! {
    if memory::is_beyond_the_stack(frame.addr()) {
        memory::note_overrun();
        start_again(|| defmt::error!("the stack is used up, starting again"))
    }
    // SAFETY: within the stack, where the core has put it.
    let at = unsafe { &*frame }.pc();
    start_again(|| defmt::error!("hard fault at {=u32:#x}, starting again", at))
}

#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    start_again(|| defmt::error!("interrupt {=i16} without a handler, starting again", number))
}
