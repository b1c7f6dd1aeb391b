//! An STM32H743 as the monitor needs it: a clock, serial ports, flash, watchdogs and sensors.

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
use stm32h7::stm32h743 as pac;

/// The board.
pub struct Stm32h743;

impl Board for Stm32h743 {
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
pub fn start() -> Option<Started<Stm32h743>> {
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
    let port = pins::PortC(p.GPIOC);
    let lock_step =
        strap::is_grounded(&port, clock.core_hz) && strap::is_wired(&port, clock.core_hz);
    let receiver = serial::start((p.USART3, p.USART2), &p.RCC, &p.GPIOD, &clock, lock_step);
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
        spi::start(&p.SPI1);
        sensors::start(&p.GPIOA, &p.GPIOB, &p.TIM2, clock.timer_hz);
        Measured::start(&sensors::WIRING, MONITOR.plausibility.stuck_after)
    });
    Some(Started {
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
    })
}
