//! An STM32F405 as the monitor needs it: a clock, serial ports, flash, watchdogs and sensors.

mod brown_out;
mod cells;
mod clock;
mod dog;
mod pins;
mod reset;
mod sensors;
mod serial;
mod spi;

use crate::MONITOR;
use spindle_firmware::beat::Cycles;
use spindle_firmware::board::{Board, SET_BROWN_OUT, Started, within};
use spindle_firmware::sensors::Measured;
use spindle_firmware::spindle::{BALLS, BRIDGES, ROWS};
use spindle_firmware::strap::{self, Wires};
use spindle_monitor::board::BoardReport;
use spindle_monitor::settings::MonitorSettings;
use stm32f4::stm32f405 as pac;

/// The board.
pub struct Stm32f405;

impl Board for Stm32f405 {
    const BAUD: u32 = serial::BAUD;
    const MONITOR: &'static MonitorSettings<ROWS> = &MONITOR;

    type Cells = cells::Memory;
    type Pins = pins::PortC;
    type Watchdogs = dog::Watchdogs;

    fn received() -> Option<u8> {
        serial::received()
    }

    fn is_free() -> bool {
        serial::is_free()
    }

    fn send(byte: u8) {
        serial::send(byte);
    }
}

const _: () = assert!(
    MONITOR.fits_port(serial::BAUD, BALLS),
    "the port is too slow for the telemetry"
);

/// Starts everything but the timer; `None` if it was started before.
pub fn start() -> Option<Started<Stm32f405>> {
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
    let port = pins::PortC(p.GPIOC);
    // An emulated board has no number of a chip.
    let is_emulated = p.DBGMCU.idcode().read().bits() == 0;
    let lock_step = strap::is_grounded(&port, clock.core_hz)
        && (is_emulated || strap::is_wired(&port, clock.core_hz));
    let ports = (p.USART1, p.USART2, p.DMA2);
    let receiver = serial::start(ports, &p.RCC, &p.GPIOA, &clock, lock_step);
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
        spi::start(&p.SPI1);
        sensors::start(&p.GPIOA, &p.GPIOB, &p.TIM2, clock.timer_hz);
        Measured::start(&sensors::WIRING, MONITOR.plausibility.stuck_after)
    });
    Some(Started {
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
    })
}
