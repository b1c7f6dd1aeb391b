//! An STM32H743 as the monitor needs it: a clock, a serial port, a log, and a way out of a panic. What
//! does not depend on the chip is the other board's.

mod clock;
#[path = "../../board/faults.rs"]
mod faults;
#[path = "../../board/log.rs"]
mod log;
#[path = "../../board/receiver.rs"]
mod receiver;
mod serial;

pub use clock::Clock;
pub use receiver::Receiver;
pub use serial::BAUD;

use stm32h7::stm32h743 as pac;

/// Starts caches, clock and serial port; `None` if they were started before.
pub fn start() -> Option<(Clock, Receiver)> {
    let p = pac::Peripherals::take()?;
    let mut core = cortex_m::Peripherals::take()?;
    // Flash is several cycles away from this core. Nothing here uses DMA, which the data cache would
    // have to be told of.
    core.SCB.enable_icache();
    core.SCB.enable_dcache(&mut core.CPUID);
    let clock = clock::start(&p.RCC, &p.PWR, &p.FLASH);
    let receiver = serial::start(p.USART3, &p.RCC, &p.GPIOD, clock.usart_hz)?;
    Some((clock, receiver))
}

/// Whether a condition comes true within `tries` looks at it. Every wait for hardware goes through
/// here, so that hardware that is broken cannot stop the program.
fn within(tries: u32, mut condition: impl FnMut() -> bool) -> bool {
    (0..tries).any(|_| condition())
}
