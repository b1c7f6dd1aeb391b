//! An STM32F405 as the monitor needs it: a clock, a serial port, a log, and a way out of a panic.

mod clock;
mod faults;
mod log;
mod receiver;
mod serial;

pub use clock::Clock;
pub use receiver::Receiver;
pub use serial::BAUD;

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
