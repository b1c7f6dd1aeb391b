//! The STM32F405.

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
pub const CORE: Core = Core::STM32F405;

/// Starts everything but the timer.
pub fn start(p: pac::Peripherals, mut core: cortex_m::Peripherals) -> Started<Stm32> {
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
    let port = pins::PortC(p.GPIOC);
    // An emulated board has no number of a chip.
    let is_emulated = p.DBGMCU.idcode().read().bits() == 0;
    let lock_step = strap::is_grounded(&port, clock.core_hz)
        && (is_emulated || strap::is_wired(&port, clock.core_hz));
    let ports = (p.USART1, p.USART2, p.DMA2);
    let receiver = serial::start(ports, &p.RCC, &p.GPIOA, &clock, lock_step);
    raise_brown_out(&p.FLASH, report.brown_out);
    let sensors = BRIDGES.then(|| {
        p.RCC.ahb1enr().modify(|_, w| w.gpioben().enabled());
        p.RCC.apb1enr().modify(|_, w| w.tim2en().enabled());
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
        watchdogs: dog::Watchdogs::new(p.IWDG, p.WWDG, &clock),
        timer: core.SYST,
        lock_step,
        wires: Wires::start(port),
        report,
        reset,
        sensors,
        cells: cells::start(p.FLASH),
    }
}
