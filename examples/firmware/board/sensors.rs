//! Strain bridges at an ADS131M08, and a tachometer: the same on every board of this family, but for clocks
//! and the bus (`super::spi`).
//!
//! | pin | line |
//! | --- | --- |
//! | PA5, PA6, PA7 | SCLK, DOUT, DIN of the converter |
//! | PA4 | CS |
//! | PB0 | DRDY |
//! | PB1 | SYNC/RESET |
//! | PA0 | pulses of the tachometer, rising edges |

#![allow(unsafe_code, reason = "registers shared with an interrupt handler")]

use super::bus::Bus;
use super::{pac, spi};
use crate::chain::Sensors;
use crate::monitor_settings::{CALIBRATION, MONITOR, TACHOMETER, TARE_SAMPLES};
use core::cell::Cell;
use core::convert::Infallible;
use critical_section::Mutex;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use pac::{GPIOA, GPIOB, Interrupt, NVIC, TIM2, interrupt};
use spindle_monitor::loads::{
    Ads131m08, Ads131m08Bridges, Ads131m08Config, LoadSource, StrainBridge, TareState,
};
use spindle_monitor::speed::{Edges, PulseInput, PulseSpeed, Pulses, SpeedMethod, SpeedSource};
use spindle_monitor::{Mark, Readings};

/// Bridges.
pub const CHANNELS: usize = 6;

/// Waits, on the fastest clock of the core as long as is said, on slower ones longer.
#[derive(Clone, Copy)]
pub struct Delay {
    /// The fastest clock, MHz.
    pub core_mhz: u32,
}

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        let cycles = u64::from(ns) * u64::from(self.core_mhz) / 1000;
        cortex_m::asm::delay(u32::try_from(cycles).unwrap_or(u32::MAX).saturating_add(1));
    }
}

/// PB0: low when there is a conversion.
pub struct Ready(GPIOB);

/// PA4.
pub struct Select(GPIOA);

/// PB1, of a port that PB0 belongs to as well.
pub struct Reset;

impl ErrorType for Ready {
    type Error = Infallible;
}
impl InputPin for Ready {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.0.idr().read().idr0().bit_is_set())
    }
    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

impl ErrorType for Select {
    type Error = Infallible;
}
impl OutputPin for Select {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.bsrr().write(|w| w.br4().set_bit());
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.bsrr().write(|w| w.bs4().set_bit());
        Ok(())
    }
}

impl ErrorType for Reset {
    type Error = Infallible;
}
impl OutputPin for Reset {
    fn set_low(&mut self) -> Result<(), Infallible> {
        // SAFETY: a write of this register changes the pins that it names, and nobody else names this one.
        unsafe { &*GPIOB::ptr() }
            .bsrr()
            .write(|w| w.br1().set_bit());
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        // SAFETY: as above.
        unsafe { &*GPIOB::ptr() }
            .bsrr()
            .write(|w| w.bs1().set_bit());
        Ok(())
    }
}

/// Pulses so far, and the timer's time of the last one, which belong together.
static EDGES: Mutex<Cell<Pulses>> = Mutex::new(Cell::new(Pulses {
    count: 0,
    capture: 0,
}));

/// Pulses that the interrupt handler counts.
pub struct Tachometer(TIM2);

impl PulseInput for Tachometer {
    fn pulses(&mut self) -> Pulses {
        critical_section::with(|cs| EDGES.borrow(cs).get())
    }
}

#[interrupt]
fn TIM2() {
    static mut COUNTED: Option<Edges> = None;
    // SAFETY: reading the capture is what tells the timer that it was seen; nobody else reads it.
    let capture = unsafe { &*TIM2::ptr() }.ccr1().read().bits();
    let counted = COUNTED.get_or_insert_default();
    counted.edge(capture, true);
    let pulses = counted.pulses();
    critical_section::with(|cs| EDGES.borrow(cs).set(pulses));
}

/// The bus of this board.
type Exchange = Bus<fn(u8) -> Option<u8>, Delay>;
type Converter = Ads131m08Bridges<Ads131m08<Exchange, Ready, Reset, Select, Delay>, CHANNELS>;

/// Bridges and tachometer.
pub struct Measured {
    /// None if the converter could not be started.
    bridges: Option<StrainBridge<Converter, CHANNELS>>,
    tachometer: PulseSpeed<Tachometer>,
}

/// Starts both. Clocks of ports, bus and timer are on already; the timer counts at `timer_hz`.
pub fn start(gpioa: GPIOA, gpiob: GPIOB, tim2: TIM2, timer_hz: u32) -> Measured {
    gpioa.afrl().modify(|_, w| {
        w.afr(0).af1();
        w.afr(5).af5().afr(6).af5().afr(7).af5()
    });
    gpioa.bsrr().write(|w| w.bs4().set_bit());
    gpioa.pupdr().modify(|_, w| w.pupdr0().pull_down());
    gpioa.moder().modify(|_, w| {
        w.moder0().alternate().moder4().output();
        w.moder5()
            .alternate()
            .moder6()
            .alternate()
            .moder7()
            .alternate()
    });
    gpiob.bsrr().write(|w| w.bs1().set_bit());
    // Without a converter, there is never a conversion.
    gpiob.pupdr().modify(|_, w| w.pupdr0().pull_up());
    gpiob
        .moder()
        .modify(|_, w| w.moder0().input().moder1().output());

    let divisor = timer_hz / TACHOMETER.timer_hz;
    // SAFETY: the register holds one less than the divisor, which is some hundred at most.
    tim2.psc()
        .write(|w| unsafe { w.psc().bits(divisor.saturating_sub(1) as u16) });
    // The divisor counts from the next overflow on: this makes one.
    tim2.egr().write(|w| w.ug().set_bit());
    // An edge must last: eight looks at the timer's clock by 8.
    tim2.ccmr1_input()
        .write(|w| w.cc1s().ti1().ic1f().fdts_div8_n8());
    tim2.ccer().write(|w| w.cc1e().set_bit());
    tim2.dier().write(|w| w.cc1ie().set_bit());
    tim2.cr1().write(|w| w.cen().set_bit());
    // SAFETY: the handler shares nothing with the main program but what is behind a mutex.
    unsafe { NVIC::unmask(Interrupt::TIM2) };

    let bus: Exchange = Bus::new(spi::exchange, spi::DELAY);
    let device = Ads131m08::new(bus, Ready(gpiob), Reset, Select(gpioa), spi::DELAY);
    let stuck_after = MONITOR.plausibility.stuck_after;
    let bridges = match Ads131m08Bridges::start(device, &Ads131m08Config::default()) {
        Ok(adc) => Some(StrainBridge::new(adc, CALIBRATION, stuck_after)),
        Err(error) => {
            defmt::error!("no loads: {}", error);
            None
        }
    };
    Measured {
        bridges,
        tachometer: PulseSpeed::new(Tachometer(tim2), TACHOMETER),
    }
}

impl Sensors for Measured {
    fn readings(&mut self, time_us: u64) -> Readings {
        let now = self.tachometer.input().0.cnt().read().bits();
        let speed = self.tachometer.speed(now);
        let loads = match &mut self.bridges {
            None => Err(Mark::Bus.into()),
            Some(bridges) => {
                let standing = speed.is_ok_and(|speed| speed.method == SpeedMethod::Standstill);
                bridges.set_turning(!standing);
                // Once after every start, as soon as the shaft stands still.
                let running = matches!(bridges.tare_state(), TareState::Running(_));
                if standing && bridges.tare().is_none() && !running {
                    let _ = bridges.take_tare(TARE_SAMPLES);
                }
                bridges.sample(time_us)
            }
        };
        Readings {
            loads,
            speed: Some(speed.ok().map(|speed| speed.omega)),
            temperatures: None,
        }
    }
}
