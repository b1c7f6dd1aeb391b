//! Strain bridges at an ADS131M08, and a tachometer at the input of a timer.

use crate::bridges::{Ads131m08, Ads131m08Bridges, Ads131m08Config, StrainBridge, TareState};
use crate::bus::Bus;
use crate::chain::Sensors;
use crate::spindle::{CALIBRATION, CHANNELS, PROBE_CHANNELS, PROBES, TACHOMETER, TARE_SAMPLES};
use crate::tachometer::{Edges, PulseInput, PulseSpeed, Pulses, SpeedMethod, SpeedSource};
use core::cell::Cell;
use core::convert::Infallible;
use critical_section::Mutex;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use spindle_monitor::loads::LoadSource;
use spindle_monitor::{Mark, Readings};

/// Bus and pins of the converter, and the timer of the tachometer: all are started.
#[derive(Clone, Copy)]
pub struct Wiring {
    /// Sends a byte and returns the one that comes in meanwhile; none if the bus is dead.
    pub exchange: fn(u8) -> Option<u8>,
    /// Whether DRDY is high. It is low when there is a conversion.
    pub drdy: fn() -> bool,
    /// Sets SYNC/RESET.
    pub reset: fn(bool),
    /// Sets CS.
    pub select: fn(bool),
    /// The timer's time.
    pub now: fn() -> u32,
    /// The fastest clock of the core, MHz.
    pub core_mhz: u32,
}

/// Waits, on the fastest clock of the core as long as is said, on slower ones longer.
struct Delay {
    core_mhz: u32,
}

impl DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        let cycles = u64::from(ns) * u64::from(self.core_mhz) / 1000;
        cortex_m::asm::delay(u32::try_from(cycles).unwrap_or(u32::MAX).saturating_add(1));
    }
}

/// A pin that is read.
struct Input(fn() -> bool);

impl ErrorType for Input {
    type Error = Infallible;
}
impl InputPin for Input {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok((self.0)())
    }
    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!(self.0)())
    }
}

/// A pin that is set.
struct Output(fn(bool));

impl ErrorType for Output {
    type Error = Infallible;
}
impl OutputPin for Output {
    fn set_low(&mut self) -> Result<(), Infallible> {
        (self.0)(false);
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        (self.0)(true);
        Ok(())
    }
}

/// Pulses so far, and the timer's time of the last one, which belong together.
static EDGES: Mutex<Cell<Edges>> = Mutex::new(Cell::new(Edges::new()));

/// A rising edge of the tachometer, at this time of its timer: for the interrupt handler.
pub fn edge(capture: u32) {
    critical_section::with(|cs| {
        let mut edges = EDGES.borrow(cs).get();
        edges.edge(capture, true);
        EDGES.borrow(cs).set(edges);
    });
}

/// Pulses that the interrupt handler counts.
struct Tachometer;

impl PulseInput for Tachometer {
    fn pulses(&mut self) -> Pulses {
        critical_section::with(|cs| EDGES.borrow(cs).get()).pulses()
    }
}

/// The bus of this board.
type Exchange = Bus<fn(u8) -> Option<u8>, Delay>;
type Converter = Ads131m08Bridges<Ads131m08<Exchange, Input, Output, Output, Delay>, CHANNELS>;

/// Bridges and tachometer.
pub struct Measured {
    /// None if the converter could not be started.
    bridges: Option<StrainBridge<Converter, CHANNELS>>,
    tachometer: PulseSpeed<Tachometer>,
    now: fn() -> u32,
}

impl Measured {
    /// Starts the converter. A channel that gives the same count `stuck_after` times is stuck.
    pub fn start(wiring: &Wiring, stuck_after: u16) -> Self {
        let delay = || Delay {
            core_mhz: wiring.core_mhz,
        };
        let device = Ads131m08::new(
            Bus::new(wiring.exchange, delay()),
            Input(wiring.drdy),
            Output(wiring.reset),
            Output(wiring.select),
            delay(),
        );
        let bridges = match Ads131m08Bridges::start(device, &Ads131m08Config::default()) {
            Ok(adc) => Some(StrainBridge::new(adc, CALIBRATION, stuck_after)),
            Err(error) => {
                defmt::error!("no loads: {}", error);
                None
            }
        };
        Self {
            bridges,
            tachometer: PulseSpeed::new(Tachometer, TACHOMETER),
            now: wiring.now,
        }
    }
}

impl Sensors for Measured {
    fn readings(&mut self, time_us: u64) -> Readings {
        let speed = self.tachometer.speed((self.now)());
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

    fn displacements(&mut self) -> Option<[Option<f32>; PROBES]> {
        let channels = PROBE_CHANNELS?;
        let adc = self.bridges.as_mut()?.adc();
        Some(channels.map(|(channel, um)| Some(um * adc.count(channel)? as f32)))
    }
}
