//! The monitor's chain without any hardware, from the port's bytes to the telemetry's. It is the
//! same on every board, and on the host, which holds the emulated board against it.
//!
//! Two kinds of frames come in over one port: load records, and a [`Command`] now and then, such as temperatures, or before each
//! record, with the displacements at the probes.

use crate::spindle::{BALLS, FREEDOMS, IDLE, JOINTS, PROBES, RESPONSE, ROWS, SPINDLE};
use core::array::from_fn;
use core::mem::MaybeUninit;
use core::ops::DerefMut;
use spindle_bearing::Status;
use spindle_monitor::command::{Command, PortReader, Received};
use spindle_monitor::framing::FrameError;
use spindle_monitor::loads::{FrameCounts, FramedLoads, LoadSource};
use spindle_monitor::record::LoadRecord;
use spindle_monitor::retained::NorFlash;
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::telemetry::HealthReport;
use spindle_monitor::tick::{CycleCounter, Watchdog};
use spindle_monitor::{BoardReport, Monitor, Outcome, Past, Probes, Readings, Store};

/// Estimates and pictures of balls that wait for a slow link.
const FRAMES: usize = 12;

/// Where loads and speed come from.
pub trait Sensors {
    /// A load record of the port, or a damaged frame.
    fn take(&mut self, _: Result<LoadRecord, FrameError>) {}

    /// Readings at a tick.
    fn readings(&mut self, time_us: u64) -> Readings;

    /// Displacements (um) that the probes measured with these loads; none of all where they come over the port.
    fn displacements(&mut self) -> Option<[Option<f32>; PROBES]> {
        None
    }

    /// Records that came over the port.
    fn counts(&self) -> FrameCounts {
        FrameCounts::default()
    }
}

/// Records of the port, which carry the speed.
impl Sensors for FramedLoads {
    fn take(&mut self, read: Result<LoadRecord, FrameError>) {
        Self::take(self, read);
    }

    fn readings(&mut self, time_us: u64) -> Readings {
        Readings {
            loads: self.sample(time_us),
            speed: None,
            temperatures: None,
        }
    }

    fn counts(&self) -> FrameCounts {
        Self::counts(self)
    }
}

/// The monitor of the spindle: by far the most of what a board keeps in mind.
pub type SpindleMonitor = Monitor<ROWS, BALLS, FRAMES, FREEDOMS, JOINTS, PROBES>;

/// Its probes.
pub type SpindleProbes = Probes<PROBES>;

/// The probes at their beginning.
pub fn probes(settings: &MonitorSettings<ROWS>) -> SpindleProbes {
    Probes::new(&RESPONSE, &settings.alarms, settings.tick.period_us)
}

/// The monitor at its beginning, for a host; a board's stack has no room to return it.
pub fn monitor(
    probes: &'static mut SpindleProbes,
    past: &Past,
    settings: &'static MonitorSettings<ROWS>,
) -> SpindleMonitor {
    Monitor::with_probes(&SPINDLE, settings, probes).with_past(past)
}

/// Makes the monitor in its place, with the data that was kept over a power cycle, and with probes if the spindle has some.
pub fn make<'m>(
    place: &'m mut MaybeUninit<SpindleMonitor>,
    probes: Option<&'static mut SpindleProbes>,
    past: &Past,
    settings: &'static MonitorSettings<ROWS>,
) -> &'m mut SpindleMonitor {
    let monitor = Monitor::make(place, &SPINDLE, settings, probes);
    monitor.set_past(past);
    monitor
}

/// The monitor with its sensors: a borrowed one on a board, a boxed one on a host.
pub struct Chain<M, S = FramedLoads> {
    monitor: M,
    sensors: S,
    port: PortReader,
    /// The newest temperatures of the port, until they are taken.
    temperatures: Option<[f32; 2]>,
    time_us: u64,
}

impl<M: DerefMut<Target = SpindleMonitor>> Chain<M> {
    /// With records of the port.
    pub const fn new(monitor: M) -> Self {
        Self::with(FramedLoads::new(), monitor)
    }

    /// Counts of the records that came over the port.
    pub fn counts(&self) -> FrameCounts {
        Sensors::counts(&self.sensors)
    }
}

impl<M: DerefMut<Target = SpindleMonitor>, S: Sensors> Chain<M, S> {
    /// With these sensors.
    pub const fn with(sensors: S, monitor: M) -> Self {
        Self {
            monitor,
            sensors,
            port: PortReader::new(),
            temperatures: None,
            time_us: 0,
        }
    }

    /// Solves a first equilibrium to start from, the idling spindle's.
    ///
    /// # Errors
    ///
    /// How that solve ended; the monitor goes on without it.
    pub fn prepare(&mut self) -> Result<(), Status<f32>> {
        self.monitor.prepare(IDLE)
    }

    /// Takes a byte of the port, while the input for service is on or off. Returns how many bytes the link takes if it is a
    /// tick that is asked for.
    pub fn push(&mut self, byte: u8, service: bool) -> Option<u16> {
        match self.port.push(byte)? {
            Ok(Received::Command(Command::Tick(room))) => return Some(room),
            Ok(Received::Command(Command::Ask(request))) => self.monitor.ask(&request, service),
            Ok(Received::Command(Command::Temperatures(read))) => self.temperatures = Some(read),
            Ok(Received::Command(Command::Probes(read))) => {
                let measured = from_fn(|i| read.get(i).copied());
                self.monitor.note_displacements(measured);
            }
            Ok(Received::Record(record)) => self.sensors.take(Ok(record)),
            Err(error) => self.sensors.take(Err(error)),
        }
        None
    }

    /// Takes the board's report on itself, for the telemetry.
    pub fn set_board(&mut self, report: BoardReport) {
        self.monitor.set_board(report);
    }

    /// A tick at this time.
    pub fn tick(
        &mut self,
        time_us: u64,
        counter: &mut impl CycleCounter,
        watchdog: &mut impl Watchdog,
    ) -> Outcome {
        self.time_us = time_us;
        let mut readings = self.sensors.readings(time_us);
        readings.temperatures = self.temperatures.take().or(readings.temperatures);
        if let Some(measured) = self.sensors.displacements() {
            self.monitor.note_displacements(measured);
        }
        self.monitor.note_records(self.sensors.counts());
        self.monitor.tick(time_us, &readings, counter, watchdog)
    }

    /// Has a store keep new data. Between ticks.
    pub fn retain<F: NorFlash>(&mut self, store: &mut Store<F>) {
        self.monitor.retain(self.time_us, store);
    }

    /// The next byte for the telemetry's link.
    pub fn next_byte(&mut self) -> Option<u8> {
        self.monitor.outbox().next_byte()
    }

    /// Counters of the monitor.
    pub fn health(&self) -> HealthReport {
        self.monitor.health()
    }
}
