//! An STM32F405 as the monitor needs it: a clock, a serial port, a log, and a way out of a panic.

mod clock;
mod log;
mod serial;

pub use clock::Clock;
pub use serial::{BAUD, Receiver};

use core::panic::PanicInfo;
use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};
use stm32f4::stm32f405 as pac;

/// Starts clock and serial port; `None` if they were started before.
pub fn start() -> Option<(Clock, Receiver)> {
    let p = pac::Peripherals::take()?;
    let clock = clock::start(&p.RCC, &p.FLASH);
    let receiver = serial::start(p.USART1, &p.RCC, &p.GPIOA, clock.usart_hz)?;
    Some((clock, receiver))
}

/// Whether a condition comes true within `tries` looks at it. Every wait for hardware goes through
/// here, so that hardware that is broken, or not there in an emulator, cannot stop the program.
fn within(tries: u32, mut condition: impl FnMut() -> bool) -> bool {
    (0..tries).any(|_| condition())
}

/// A monitor without its operator: say what happened, and start again.
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
