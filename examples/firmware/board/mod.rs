//! An STM32F405 as the monitor needs it: a clock, a beat, serial ports, a log, and a way out of a panic.

mod beat;
mod brown_out;
mod bus;
mod cells;
mod clock;
mod dog;
mod faults;
mod flash;
#[cfg_attr(feature = "rtt", path = "rtt.rs")]
mod log;
mod memory;
mod receiver;
mod reset;
mod sensors;
#[cfg_attr(feature = "rtt", allow(dead_code, reason = "the log's port"))]
mod serial;
mod spi;
mod strap;

pub use beat::{Cycles, left, start_timer, ticks};
pub use clock::Clock;
pub use dog::{Dog, feed_at_start};
pub use memory::{Stack, image, seal};
pub use receiver::Receiver;
pub use sensors::Measured;
pub use serial::{BAUD, is_free, received, send};
pub use strap::Service;

/// Flash for what is kept over a power cycle.
pub type Memory = flash::Flash<cells::Memory>;

use crate::monitor_settings::{BRIDGES, SET_BROWN_OUT};
use cortex_m::peripheral::SYST;
use spindle_monitor::board::{BoardReport, ResetCause};
use stm32f4::stm32f405 as pac;

/// The board once it is started.
pub struct Board {
    /// The clock that was reached.
    pub clock: Clock,
    /// Receiver of the bytes that come in over the port.
    pub receiver: Receiver,
    /// Counts cycles.
    pub cycles: Cycles,
    /// The independent watchdog, which runs.
    pub iwdg: pac::IWDG,
    /// The window to feed it in: not watched yet.
    pub window: reset::Window,
    /// The timer: not started yet.
    pub timer: SYST,
    /// PC0 is wired to ground and PC1 to PC2, or the board is an emulated one: ticks are asked for over the port.
    pub lock_step: bool,
    /// Input by which somebody at the machine lets a bearing be replaced.
    pub service: Service,
    /// Report of the board on itself: why it started, and its brown-out level.
    pub report: BoardReport,
    /// Why it started.
    pub reset: ResetCause,
    /// Strain bridges and tachometer, if they are chosen.
    pub sensors: Option<Measured>,
    /// Flash for what is kept over a power cycle; none on an emulated board.
    pub memory: Option<Memory>,
}

/// Starts everything but the timer; `None` if it was started before.
pub fn start() -> Option<Board> {
    let p = pac::Peripherals::take()?;
    let mut core = cortex_m::Peripherals::take()?;
    let reset = reset::cause(&p.RCC);
    let report = BoardReport {
        brown_out: brown_out::level(&p.FLASH),
        ..BoardReport::NONE
    };
    // Not while a debugger holds the core.
    p.DBGMCU
        .apb1_fz()
        .modify(|_, w| w.dbg_iwdg_stop().set_bit().dbg_wwdg_stop().set_bit());
    p.RCC.apb1enr().modify(|_, w| w.wwdgen().enabled());
    let clock = clock::start(&p.RCC, &p.FLASH);
    let cycles = Cycles::start(&mut core.DCB, &mut core.DWT);
    p.RCC.ahb1enr().modify(|_, w| w.gpiocen().enabled());
    let _ = p.RCC.ahb1enr().read();
    // An emulated board has no number of a chip.
    let is_emulated = p.DBGMCU.idcode().read().bits() == 0;
    let lock_step = strap::is_grounded(&p.GPIOC, clock.core_hz)
        && (is_emulated || strap::is_wired(&p.GPIOC, clock.core_hz));
    let receiver = serial::start((p.USART1, p.USART2), &p.RCC, &p.GPIOA, &clock, lock_step)?;
    if SET_BROWN_OUT && report.brown_out.is_some_and(|of| of < brown_out::HIGHEST) {
        if brown_out::set(&p.FLASH) {
            defmt::warn!("brown-out level set to the highest, from the next power-on on");
        } else {
            defmt::error!("the brown-out level cannot be set");
        }
    }
    let sensors = BRIDGES.then(|| {
        p.RCC.ahb1enr().modify(|_, w| w.gpioben().enabled());
        p.RCC.apb1enr().modify(|_, w| w.tim2en().enabled());
        p.RCC.apb2enr().modify(|_, w| w.spi1en().enabled());
        let _ = p.RCC.apb2enr().read();
        spi::start(p.SPI1);
        sensors::start(p.GPIOA, p.GPIOB, p.TIM2, clock.timer_hz)
    });
    Some(Board {
        clock,
        receiver,
        cycles,
        iwdg: p.IWDG,
        window: reset::Window::new(p.WWDG),
        timer: core.SYST,
        lock_step,
        service: Service::start(p.GPIOC),
        report,
        reset,
        sensors,
        memory: cells::start(p.FLASH).map(flash::Flash),
    })
}

/// Whether a condition comes true within `tries` looks at it. Every wait for hardware goes through
/// here, so that hardware that is broken, or not there in an emulator, cannot stop the program.
fn within(tries: u32, mut condition: impl FnMut() -> bool) -> bool {
    (0..tries).any(|_| condition())
}
