//! The STM32H743.

pub mod brown_out;
pub mod cells;
mod clock;
pub mod dog;
mod reset;
pub mod serial;
pub mod spi;

use super::brown_out::raise_brown_out;
use super::{Stm32, pac, pins, sensors};
use crate::beat::Cycles;
use crate::board::Started;
use crate::spindle::BRIDGES;
use crate::strap::{self, Wires};
use spindle_monitor::board::BoardReport;
use spindle_monitor::tick::Core;

/// The core.
pub const CORE: Core = Core::STM32H743;

/// Starts everything but the timer.
pub fn start(p: pac::Peripherals, mut core: cortex_m::Peripherals) -> Started<Stm32> {
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
    let port = pins::PortC(p.GPIOC);
    let lock_step =
        strap::is_grounded(&port, clock.core_hz) && strap::is_wired(&port, clock.core_hz);
    let receiver = serial::start((p.USART3, p.USART2), &p.RCC, &p.GPIOD, &clock, lock_step);
    raise_brown_out(&p.FLASH, report.brown_out);
    let sensors = BRIDGES.then(|| {
        p.RCC
            .ahb4enr()
            .modify(|_, w| w.gpioaen().enabled().gpioben().enabled());
        p.RCC.apb1lenr().modify(|_, w| w.tim2en().enabled());
        p.RCC.d2ccip1r().modify(|_, w| w.spi123sel().per());
        p.RCC.apb2enr().modify(|_, w| w.spi1en().enabled());
        let _ = p.RCC.apb2enr().read();
        spi::start(&p.SPI1);
        sensors::start(&p.GPIOA, &p.GPIOB, &p.TIM2, clock.timer_hz)
    });
    Started {
        clock: clock.source,
        core_hz: clock.core_hz,
        receiver,
        cycles,
        watchdogs: dog::Watchdogs(p.IWDG),
        timer: core.SYST,
        lock_step,
        wires: Wires::start(port),
        report,
        reset,
        sensors,
        cells: cells::start(p.FLASH, core.SCB),
    }
}
