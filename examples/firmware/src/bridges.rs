//! Strain bridges at a converter, as a source of loads.
//!
//! [`StrainBridge`] turns the counts of `K` bridges into five loads by a [`Calibration`], after tare and temperature.
//!
//! # The converter
//!
//! A spindle's bridges must be read at the same instant: five loads of different angles of the cutter
//! are no load that ever was. Drivers on the registry were judged:
//!
//! | driver | converter | verdict |
//! | --- | --- | --- |
//! | `ads131m08` 0.2 | 8 channels sampled together, 24 bit, gain to 128, to 32 kSPS, CRC | embedded-hal 1.0, no_std, MIT or Apache-2.0, under development: taken |
//! | `ad7124-rs` 0.4 | 8 pairs through one modulator, 24 bit | embedded-hal 1.0, no_std; a settled scan of five bridges takes longer than a tick of 1 ms |
//! | `embedded-ads1220` 0.1 | 2 pairs through one modulator, 2 kSPS | embedded-hal 1.0, one release; too few channels, one after the other |
//! | `max112x` 0.7 | one channel, 64 kSPS | one converter a bridge |
//! | `hx711`, `hx711_spi` 0.7, `loadcell` 0.3 | one channel and a half, 80 SPS | scales: too slow |
//! | `nau7802` 0.1 alpha, `ads1263` 0.1 | one modulator | embedded-hal 0.2 |
//!
//! No driver is on the registry for ADS1256, AD7190 and AD7193. [`Ads131m08Bridges`] wraps the
//! chosen driver, and does what it leaves to its caller. It checks the CRC of every conversion,
//! reads back the settings, and tells a converter that has lost them.
//! Bridges are excited by the converter's reference voltage, so that counts are ratios (V/V).
//!
//! [`BridgeAdc`] is all that another converter has to be.

use core::fmt;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use spindle_monitor::loads::{LoadSample, LoadSource};
use spindle_monitor::marks::{Mark, Marks, StuckWatch};

/// Error of a converter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(defmt::Format))]
#[non_exhaustive]
pub enum AdcError {
    /// The bus or a pin reported an error.
    Bus,
    /// The checksum says that a conversion was damaged on its way.
    Checksum,
    /// The converter was reset, and has lost its settings: start it again.
    Reset,
    /// The settings read back differ from the written ones.
    Settings,
}

impl fmt::Display for AdcError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Bus => "bus or pin error at the converter",
            Self::Checksum => "conversion damaged on its way",
            Self::Reset => "converter was reset and has lost its settings",
            Self::Settings => "converter does not keep its settings",
        })
    }
}

impl core::error::Error for AdcError {}

/// A converter that samples `K` bridges together.
pub trait BridgeAdc<const K: usize> {
    /// The count at either rail.
    const RAIL: i32;

    /// The newest conversion, if there is one since the last call. Never waits.
    ///
    /// # Errors
    ///
    /// Why there is none that could be trusted.
    fn read(&mut self) -> Result<Option<[i32; K]>, AdcError>;
}

/// Bridges at the first `K` channels of an ADS131M08.
#[derive(Debug)]
pub struct Ads131m08Bridges<D, const K: usize> {
    device: D,
    /// Counts of all channels in the last conversion that was read; none if that failed, or there was none.
    counts: Option<[i32; 8]>,
}

/// The driver's type.
pub use ads131m08::blocking::Ads131m08;
/// Its settings.
pub use ads131m08::{Config as Ads131m08Config, Gain, Osr};

/// Bits of the status word: resynchronised by itself, or a command damaged on its way.
const STATUS_FAULT: u16 = 0x5000;
const STATUS_RESET: u16 = 0x0400;

impl<SPI, DRDY, SYNC, CS, DELAY, const K: usize>
    Ads131m08Bridges<Ads131m08<SPI, DRDY, SYNC, CS, DELAY>, K>
where
    SPI: SpiDevice,
    DRDY: InputPin,
    SYNC: OutputPin,
    CS: OutputPin,
    DELAY: DelayNs,
{
    /// At most the converter's eight, at least one for each load.
    const CHANNELS: () = assert!(
        K >= 5 && K <= 8,
        "an ADS131M08 has 8 channels, and 5 loads need 5"
    );

    /// Resets and sets up the converter, and reads the settings back. Takes a good tenth of a second: before
    /// the ticks begin.
    ///
    /// # Errors
    ///
    /// The converter's fault.
    pub fn start(
        mut device: Ads131m08<SPI, DRDY, SYNC, CS, DELAY>,
        config: &Ads131m08Config,
    ) -> Result<Self, AdcError> {
        use ads131m08::Register;
        let () = Self::CHANNELS;
        device.init(config).map_err(|_| AdcError::Bus)?;
        // What the driver wrote, by its own layout.
        let gains = |from: usize| {
            let mut value = 0;
            for (i, gain) in config.gain.iter().skip(from).take(4).enumerate() {
                value |= (*gain as u16) << (4 * i);
            }
            value
        };
        let clock = (u16::from(config.channels_enabled) << 8)
            | ((config.osr as u16) << 2)
            | config.power_mode as u16;
        for (register, value) in [
            (Register::Clock, clock),
            (Register::Gain1, gains(0)),
            (Register::Gain2, gains(4)),
        ] {
            if device.read_reg(register).map_err(|_| AdcError::Bus)? != value {
                return Err(AdcError::Settings);
            }
        }
        Ok(Self {
            device,
            counts: None,
        })
    }

    /// Count of a channel, such as one behind the bridges, in the conversion that was read last; none without one, and at a rail.
    pub fn count(&self, channel: usize) -> Option<i32> {
        let count = *self.counts?.get(channel)?;
        let rail = <Self as BridgeAdc<K>>::RAIL;
        (-rail < count && count < rail).then_some(count)
    }
}

impl<SPI, DRDY, SYNC, CS, DELAY, const K: usize> BridgeAdc<K>
    for Ads131m08Bridges<Ads131m08<SPI, DRDY, SYNC, CS, DELAY>, K>
where
    SPI: SpiDevice,
    DRDY: InputPin,
    SYNC: OutputPin,
    CS: OutputPin,
    DELAY: DelayNs,
{
    const RAIL: i32 = 0x7f_ffff;

    fn read(&mut self) -> Result<Option<[i32; K]>, AdcError> {
        self.counts = None;
        if !self.device.is_data_ready().map_err(|_| AdcError::Bus)? {
            return Ok(None);
        }
        let data = self.device.read_channels().map_err(|_| AdcError::Bus)?;
        // The driver hands the checksum on unchecked. It covers the words before it: status, padded to
        // three bytes, and eight channels.
        let mut words = [0; 27];
        let (status, channels) = words.split_at_mut(3);
        if let [high, low, _] = status {
            [*high, *low] = data.status.to_be_bytes();
        }
        for (bytes, value) in channels.chunks_exact_mut(3).zip(&data.channels) {
            let [_, most, middle, least] = value.to_be_bytes();
            bytes.copy_from_slice(&[most, middle, least]);
        }
        if data.crc != Some(ads131m08::calculate_crc16_ccitt(&words)) {
            return Err(AdcError::Checksum);
        }
        if data.status & STATUS_RESET != 0 {
            return Err(AdcError::Reset);
        }
        if data.status & STATUS_FAULT != 0 {
            return Err(AdcError::Bus);
        }
        self.counts = Some(data.channels);
        Ok(data.channels.first_chunk::<K>().copied())
    }
}

/// How counts of `K >= 5` bridges and loads belong together, from a calibration with known loads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration<const K: usize> {
    /// Loads by counts (rows `Fx, Fy, Fz, My, Mz`): N or N m per count.
    pub loads: [[f32; K]; 5],
    /// Counts by loads (rows the channels): counts per N or N m. Tells what the channels must
    /// have in common if there are more than five of them.
    pub counts: [[f32; 5]; K],
    /// Change of a bridge's zero with temperature, counts/K.
    pub zero_slope: [f32; K],
    /// Relative change of a bridge's sensitivity with temperature, 1/K.
    pub gain_slope: [f32; K],
    /// Temperature at which it was calibrated, degrees Celsius.
    pub temperature: f32,
    /// Lowest and highest temperature that the slopes are good for, degrees Celsius.
    pub temperatures: [f32; 2],
    /// Loads that act while the tare is taken and that bridges cannot tell from none, such as a spring
    /// preload: N, N m.
    pub standing: [f32; 5],
}

/// A calibration that cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum CalibrationError {
    /// A number is infinite or none.
    NotFinite,
    /// The two matrices do not belong together.
    Mismatch,
    /// A temperature range without its own calibration temperature, or slopes that turn a gain over.
    Temperature,
}

impl CalibrationError {
    /// Fault of the calibration, in a few words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "calibration has numbers that are none",
            Self::Mismatch => "calibration's matrices do not belong together",
            Self::Temperature => "calibration's temperature range or slopes are wrong",
        }
    }
}

impl fmt::Display for CalibrationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl core::error::Error for CalibrationError {}

impl<const K: usize> Calibration<K> {
    /// From its two matrices, which `cargo calibrate` makes of the counts that each load makes alone. No temperature slopes,
    /// from -40 to 125 degrees, nothing standing.
    pub const fn new(loads: [[f32; K]; 5], counts: [[f32; 5]; K]) -> Self {
        Self {
            loads,
            counts,
            zero_slope: [0.0; K],
            gain_slope: [0.0; K],
            temperature: 25.0,
            temperatures: [-40.0, 125.0],
            standing: [0.0; 5],
        }
    }

    /// Counts of two loads, channel by channel, multiplied and added up.
    const fn product(&self, i: usize, j: usize) -> f32 {
        let (mut sum, mut k) = (0.0, 0);
        while k < K {
            sum += self.counts[k][i] * self.counts[k][j];
            k += 1;
        }
        sum
    }

    /// Whether the loads by the counts that a load makes alone are that load, to a thousandth.
    const fn gives_back(&self, load: usize) -> bool {
        let mut i = 0;
        while i < 5 {
            let (mut error, mut k) = (if i == load { -1.0 } else { 0.0 }, 0);
            while k < K {
                error += self.loads[i][k] * self.counts[k][load];
                k += 1;
            }
            // Squares, in units of loads that make equal counts.
            let (scale, of_load) = (self.product(i, i), self.product(load, load));
            if !(scale > 0.0 && error * error * scale <= 1e-6 * of_load) {
                return false;
            }
            i += 1;
        }
        true
    }

    /// Whether every number is one, the matrices belong together, and temperatures make sense. A `const fn`, for the compiler to ask.
    ///
    /// # Errors
    ///
    /// The calibration's fault.
    pub const fn check(&self) -> Result<(), CalibrationError> {
        let [low, high] = self.temperatures;
        let mut k = 0;
        while k < K {
            let mut i = 0;
            while i < 5 {
                if !(self.loads[i][k].is_finite() && self.counts[k][i].is_finite()) {
                    return Err(CalibrationError::NotFinite);
                }
                i += 1;
            }
            if !(self.zero_slope[k].is_finite() && self.gain_slope[k].is_finite()) {
                return Err(CalibrationError::NotFinite);
            }
            let (cold, hot) = (low - self.temperature, high - self.temperature);
            if !(1.0 + self.gain_slope[k] * cold > 0.5 && 1.0 + self.gain_slope[k] * hot > 0.5) {
                return Err(CalibrationError::Temperature);
            }
            k += 1;
        }
        let mut i = 0;
        while i < 5 {
            if !self.standing[i].is_finite() {
                return Err(CalibrationError::NotFinite);
            }
            if !self.gives_back(i) {
                return Err(CalibrationError::Mismatch);
            }
            i += 1;
        }
        if !(low <= self.temperature && self.temperature <= high) {
            return Err(CalibrationError::Temperature);
        }
        Ok(())
    }
}

/// Why no tare was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TareError {
    /// The shaft turns, or it is not known whether it does.
    Turning,
    /// A sample was doubted.
    Marked(Marks),
}

impl fmt::Display for TareError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Turning => f.write_str("no tare: the shaft turns, or may turn"),
            Self::Marked(marks) => write!(f, "no tare: samples are doubted ({marks})"),
        }
    }
}

impl core::error::Error for TareError {}

/// Where the taking of a tare stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TareState {
    /// None was asked for.
    Idle,
    /// So many samples are still to come.
    Running(u16),
    /// Taken.
    Done,
    /// Refused; the tare before it stays.
    Refused(TareError),
}

/// Strain bridges at a converter, as a source of loads.
///
/// A count becomes `(count - tare - zero_slope dT) / (1 + gain_slope dT)`, and these become loads by
/// the calibration; `dT` is the temperature less the calibration's.
#[derive(Debug)]
pub struct StrainBridge<A, const K: usize> {
    adc: A,
    calibration: Calibration<K>,
    /// Counts under no load, referred to the temperature of the calibration.
    tare: Option<[f32; K]>,
    /// Temperature less the calibration's; none if it is not to be trusted.
    warmer: Option<f32>,
    turning: bool,
    state: TareState,
    wanted: u16,
    sums: [i64; K],
    stuck: StuckWatch<K>,
    errors: u64,
    last_error: Option<AdcError>,
}

impl<A: BridgeAdc<K>, const K: usize> StrainBridge<A, K> {
    /// Bridges without a tare: every sample is doubted until one was taken or given. A channel that
    /// gives the same count `stuck_after` times is stuck.
    pub const fn new(adc: A, calibration: Calibration<K>, stuck_after: u16) -> Self {
        Self {
            adc,
            calibration,
            tare: None,
            warmer: Some(0.0),
            turning: true,
            state: TareState::Idle,
            wanted: 0,
            sums: [0; K],
            stuck: StuckWatch::new(stuck_after),
            errors: 0,
            last_error: None,
        }
    }

    /// The converter.
    pub const fn adc(&mut self) -> &mut A {
        &mut self.adc
    }

    /// The tare, counts at the temperature of the calibration: to be kept over a power cycle.
    pub const fn tare(&self) -> Option<[f32; K]> {
        self.tare
    }

    /// A tare that was kept. One that is no number is none.
    pub fn set_tare(&mut self, tare: [f32; K]) {
        let good = tare.iter().all(|count| count.is_finite());
        self.tare = good.then_some(tare);
    }

    /// Whether the shaft turns, which forbids a tare. Unless told, it may.
    pub const fn set_turning(&mut self, turning: bool) {
        self.turning = turning;
    }

    /// Temperature of the bridges, degrees Celsius. Outside the calibration's range, or not a number,
    /// it makes every sample doubtful. Unless told, it is the calibration's.
    pub fn set_temperature(&mut self, celsius: f32) {
        let [low, high] = self.calibration.temperatures;
        let known = celsius >= low && celsius <= high;
        self.warmer = known.then_some(celsius - self.calibration.temperature);
    }

    /// Asks for a tare: the mean of the next `samples` samples (at least 1). All must be free of doubt
    /// and of a shaft that stands still. Until the new tare is there, the old one holds.
    ///
    /// # Errors
    ///
    /// If the shaft turns.
    pub fn take_tare(&mut self, samples: u16) -> Result<(), TareError> {
        if self.turning {
            self.state = TareState::Refused(TareError::Turning);
            return Err(TareError::Turning);
        }
        self.wanted = samples.max(1);
        self.sums = [0; K];
        self.state = TareState::Running(self.wanted);
        Ok(())
    }

    /// Where the taking of a tare stands.
    pub const fn tare_state(&self) -> TareState {
        self.state
    }

    /// Errors of the converter so far, and the last of them.
    pub const fn errors(&self) -> (u64, Option<AdcError>) {
        (self.errors, self.last_error)
    }

    /// Adds a sample to the tare that is being taken.
    fn weigh(&mut self, raw: Option<&[i32; K]>, doubts: Marks) {
        let TareState::Running(left) = self.state else {
            return;
        };
        let refusal = if self.turning {
            Some(TareError::Turning)
        } else if doubts.is_empty() {
            None
        } else {
            Some(TareError::Marked(doubts))
        };
        if let Some(error) = refusal {
            self.state = TareState::Refused(error);
            return;
        }
        let (Some(raw), Some(warmer)) = (raw, self.warmer) else {
            return;
        };
        // 65,535 counts of 32 bits cannot overflow 64.
        for (sum, count) in self.sums.iter_mut().zip(raw) {
            *sum += i64::from(*count);
        }
        if left > 1 {
            self.state = TareState::Running(left - 1);
            return;
        }
        let mut tare = [0.0; K];
        let slopes = self.calibration.zero_slope.iter();
        for ((tare, sum), slope) in tare.iter_mut().zip(&self.sums).zip(slopes) {
            // Whole and rest apart, since a mean of 24 bits leaves a float no digits to spare.
            let wanted = i64::from(self.wanted.max(1));
            let (whole, rest) = (sum / wanted, sum % wanted);
            *tare = whole as f32 + rest as f32 / f32::from(self.wanted.max(1)) - slope * warmer;
        }
        self.tare = Some(tare);
        self.state = TareState::Done;
    }
}

impl<A: BridgeAdc<K>, const K: usize> LoadSource for StrainBridge<A, K> {
    fn sample(&mut self, time_us: u64) -> Result<Option<LoadSample>, Marks> {
        let raw = match self.adc.read() {
            Ok(Some(raw)) => raw,
            Ok(None) => return Ok(None),
            Err(error) => {
                self.errors = self.errors.saturating_add(1);
                self.last_error = Some(error);
                let doubts = match error {
                    AdcError::Checksum => Mark::Corrupt,
                    _ => Mark::Bus,
                }
                .into();
                self.weigh(None, doubts);
                return Err(doubts);
            }
        };
        let mut doubts = Marks::new();
        let railed = |count: &i32| *count >= A::RAIL || *count <= -A::RAIL;
        doubts.extend(raw.iter().any(railed).then_some(Mark::Saturated));
        doubts.extend(self.stuck.watch(raw).then_some(Mark::Stuck));
        doubts.extend(self.warmer.is_none().then_some(Mark::Temperature));
        self.weigh(Some(&raw), doubts);
        doubts.extend(self.tare.is_none().then_some(Mark::Untared));

        let warmer = self.warmer.unwrap_or(0.0);
        let tare = self.tare.unwrap_or([0.0; K]);
        let c = &self.calibration;
        let mut clean = [0.0; K];
        for (k, clean) in clean.iter_mut().enumerate() {
            let zero = tare[k] + c.zero_slope[k] * warmer;
            *clean = (raw[k] as f32 - zero) / (1.0 + c.gain_slope[k] * warmer);
        }
        let mut load = [0.0; 5];
        for (load, row) in load.iter_mut().zip(&c.loads) {
            for (count, by) in clean.iter().zip(row) {
                *load += count * by;
            }
        }
        let mut residual: f32 = 0.0;
        for (count, row) in clean.iter().zip(&c.counts) {
            let mut rest = *count;
            for (load, by) in load.iter().zip(row) {
                rest -= load * by;
            }
            // A rest that is no number is one.
            if !(rest.abs() <= residual) {
                residual = rest.abs();
            }
        }
        for (load, standing) in load.iter_mut().zip(&c.standing) {
            *load += standing;
        }
        Ok(Some(LoadSample {
            time_us,
            load,
            speed: None,
            residual,
            doubts,
        }))
    }
}
