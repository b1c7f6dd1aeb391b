//! An STM32H743 as the monitor needs it: a clock, a beat, serial ports, a log, and a way out of a panic. What
//! does not depend on the chip is the other board's.

#[path = "../../firmware/board/beat.rs"]
mod beat;
mod brown_out;
#[path = "../../firmware/board/bus.rs"]
mod bus;
mod cells;
mod clock;
#[path = "../../firmware/board/dog.rs"]
mod dog;
#[path = "../../firmware/board/faults.rs"]
mod faults;
#[path = "../../firmware/board/flash.rs"]
mod flash;
#[cfg_attr(not(feature = "rtt"), path = "../../firmware/board/log.rs")]
#[cfg_attr(feature = "rtt", path = "../../firmware/board/rtt.rs")]
mod log;
#[path = "../../firmware/board/memory.rs"]
mod memory;
#[path = "../../firmware/board/receiver.rs"]
mod receiver;
mod reset;
#[path = "../../firmware/board/sensors.rs"]
mod sensors;
#[cfg_attr(feature = "rtt", allow(dead_code, reason = "the log's port"))]
mod serial;
mod spi;
#[path = "../../firmware/board/strap.rs"]
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
use stm32h7::stm32h743 as pac;

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
    /// PC0 is wired to ground and PC1 to PC2: ticks are asked for over the port.
    pub lock_step: bool,
    /// Input by which somebody at the machine lets a bearing be replaced.
    pub service: Service,
    /// Report of the board on itself: why it started, and its brown-out level.
    pub report: BoardReport,
    /// Why it started.
    pub reset: ResetCause,
    /// Strain bridges and tachometer, if they are chosen.
    pub sensors: Option<Measured>,
    /// Flash for what is kept over a power cycle.
    pub memory: Option<Memory>,
}

/// Starts everything but the timer; `None` if it was started before.
pub fn start() -> Option<Board> {
    let p = pac::Peripherals::take()?;
    let mut core = cortex_m::Peripherals::take()?;
    // Flash is several cycles away from this core. Nothing here uses DMA, which the data cache would
    // have to be told of.
    core.SCB.enable_icache();
    core.SCB.enable_dcache(&mut core.CPUID);
    let reset = reset::cause(&p.RCC);
    let report = BoardReport {
        brown_out: brown_out::level(&p.FLASH),
        ..BoardReport::NONE
    };
    // Not while a debugger holds the core.
    p.DBGMCU.apb4fz1().modify(|_, w| w.dbg_iwdg1().set_bit());
    let clock = clock::start(&p.RCC, &p.PWR, &p.FLASH);
    let cycles = Cycles::start(&mut core.DCB, &mut core.DWT);
    p.RCC.ahb4enr().modify(|_, w| w.gpiocen().enabled());
    let _ = p.RCC.ahb4enr().read();
    let lock_step =
        strap::is_grounded(&p.GPIOC, clock.core_hz) && strap::is_wired(&p.GPIOC, clock.core_hz);
    let receiver = serial::start((p.USART3, p.USART2), &p.RCC, &p.GPIOD, &clock, lock_step)?;
    if SET_BROWN_OUT && report.brown_out.is_some_and(|of| of < brown_out::HIGHEST) {
        if brown_out::set(&p.FLASH) {
            defmt::warn!("brown-out level set to the highest, from the next power-on on");
        } else {
            defmt::error!("the brown-out level cannot be set");
        }
    }
    let sensors = BRIDGES.then(|| {
        p.RCC
            .ahb4enr()
            .modify(|_, w| w.gpioaen().enabled().gpioben().enabled());
        p.RCC.apb1lenr().modify(|_, w| w.tim2en().enabled());
        p.RCC.d2ccip1r().modify(|_, w| w.spi123sel().per());
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
        window: reset::Window,
        timer: core.SYST,
        lock_step,
        service: Service::start(p.GPIOC),
        report,
        reset,
        sensors,
        memory: cells::start(p.FLASH, core.SCB).map(flash::Flash),
    })
}

/// Whether a condition comes true within `tries` looks at it. Every wait for hardware goes through
/// here, so that hardware that is broken cannot stop the program.
fn within(tries: u32, mut condition: impl FnMut() -> bool) -> bool {
    (0..tries).any(|_| condition())
}
