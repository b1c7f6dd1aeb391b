//! Strain bridges, their converter and its bus, and the tachometer.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use embedded_hal::spi::{self, ErrorKind, Operation, SpiDevice};
use mock::rig::{IDLE, Rig, SETTINGS, SPEED, at_speed};
use spindle_file::calibration::{Loads, loads};
use spindle_firmware::bridges::{
    AdcError, Ads131m08, Ads131m08Bridges, Ads131m08Config, BridgeAdc, Calibration,
    CalibrationError, Gain, StrainBridge, TareError, TareState,
};
use spindle_firmware::bus::Bus;
use spindle_firmware::spindle::TACHOMETER;
use spindle_firmware::tachometer::{Edges, PulseSpeed, SpeedError, SpeedSource};
use spindle_monitor::loads::{LoadSample, LoadSource};
use spindle_monitor::{Alarm, AlarmState, Mark, Readings};
use std::array;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::LazyLock;

/// Counts that each load makes alone: six bridges.
const RESPONSE: [[f64; 5]; 6] = [
    [800.0, 300.0, 0.0, 0.0, 9000.0],
    [800.0, -150.0, 260.0, -7800.0, -4500.0],
    [800.0, -150.0, -260.0, 7800.0, -4500.0],
    [-350.0, 900.0, 0.0, 0.0, 2000.0],
    [-350.0, -450.0, 780.0, -1700.0, -1000.0],
    [-350.0, -450.0, -780.0, 1700.0, -1000.0],
];
static CALIBRATION: LazyLock<Calibration<6>> = LazyLock::new(|| calibrated(&RESPONSE));

fn calibrated(response: &[[f64; 5]; 6]) -> Calibration<6> {
    let Loads { by_bridge, .. } = loads(response).unwrap();
    Calibration::new(
        array::from_fn(|load| array::from_fn(|k| by_bridge[k][load] as f32)),
        response.map(|of| of.map(|count| count as f32)),
    )
}

const ZERO: [i32; 6] = [12_345, -4567, 890, 0, -33_000, 5];
/// Loads of a spindle that cuts a little.
const CUT: [f32; 5] = [420.0, 30.0, 20.0, 0.3, 0.2];

/// A converter that gives what a test says.
struct Converter {
    next: Result<Option<[i32; 6]>, AdcError>,
    noise: i32,
}

impl BridgeAdc<6> for Converter {
    const RAIL: i32 = 0x7f_ffff;
    fn read(&mut self) -> Result<Option<[i32; 6]>, AdcError> {
        self.noise = (self.noise + 1) % 3;
        let noise = self.noise - 1;
        self.next
            .map(|raw| raw.map(|raw| raw.map(|count| (count + noise).min(Self::RAIL))))
    }
}

fn counts(load: [f32; 5]) -> [i32; 6] {
    array::from_fn(|k| {
        let parts = RESPONSE[k].iter().zip(load);
        let sum: f64 = parts.map(|(c, f)| c * f64::from(f)).sum();
        ZERO[k] + sum.round() as i32
    })
}

type Bridges = StrainBridge<Converter, 6>;

fn bridges(raw: [i32; 6], calibration: Calibration<6>) -> Bridges {
    let converter = Converter {
        next: Ok(Some(raw)),
        noise: 0,
    };
    StrainBridge::new(converter, calibration, 20)
}

fn tared() -> Bridges {
    let mut bridge = bridges(ZERO, *CALIBRATION);
    bridge.set_turning(false);
    bridge.take_tare(30).unwrap();
    for time in 0..30 {
        assert_eq!(bridge.tare_state(), TareState::Running(30 - time));
        let sample = bridge.sample(time.into()).unwrap().unwrap();
        assert_eq!(sample.doubts.contains(Mark::Untared), time < 29);
    }
    assert_eq!(bridge.tare_state(), TareState::Done);
    // Noise of three counts has gone.
    assert_eq!(bridge.tare(), Some(ZERO.map(|count| count as f32)));
    bridge
}

/// The sample of these counts is this load and has no doubts.
fn assert_sample(bridge: &mut Bridges, raw: [i32; 6], load: [f32; 5]) -> LoadSample {
    bridge.adc().next = Ok(Some(raw));
    let sample = bridge.sample(0).unwrap().unwrap();
    assert!(sample.doubts.is_empty());
    for (got, truth) in sample.load.iter().zip(load) {
        assert!((got - truth).abs() < 0.02, "{got}, not {truth}");
    }
    sample
}

#[test]
fn one_bridge_that_is_off_shows_in_what_six_have_in_common() {
    for k in 0..6 {
        let mut bridge = tared();
        let mut raw = counts(CUT);
        raw[k] += 20_000;
        bridge.adc().next = Ok(Some(raw));
        let sample = bridge.sample(0).unwrap().unwrap();
        assert!(sample.residual > 2000.0, "bridge {k}: {}", sample.residual);
    }
}

#[test]
fn bridges_give_back_the_load_that_bent_them_warm_or_cold() {
    const LOADS: [[f32; 5]; 3] = [
        [420.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, -120.0, 75.0, 1.5, -2.5],
        [1500.0, 300.0, -200.0, 4.0, 3.0],
    ];
    let mut bridge = tared();
    for load in LOADS {
        let sample = assert_sample(&mut bridge, counts(load), load);
        // Rounding and a count of noise.
        assert!(sample.residual < 3.0, "{}", sample.residual);
    }
    let mut calibration = *CALIBRATION;
    calibration.zero_slope = [50.0, -20.0, 0.0, 10.0, 5.0, 80.0];
    calibration.gain_slope = [4e-4, -2e-4, 0.0, 1e-4, 3e-4, -1e-4];
    calibration.temperatures = [0.0, 80.0];
    assert_eq!(calibration.check(), Ok(()));
    let warm = |celsius: f32, load: [f32; 5]| -> [i32; 6] {
        let (cold, zero) = (counts(load), counts([0.0; 5]));
        let dt = celsius - 25.0;
        array::from_fn(|k| {
            let signal = (cold[k] - zero[k]) as f32 * (1.0 + calibration.gain_slope[k] * dt);
            zero[k] + (signal + calibration.zero_slope[k] * dt).round() as i32
        })
    };
    // Tared warm, used hot.
    let mut bridge = bridges(warm(35.0, [0.0; 5]), calibration);
    bridge.set_temperature(35.0);
    bridge.set_turning(false);
    bridge.take_tare(3).unwrap();
    for _ in 0..3 {
        bridge.sample(0).unwrap();
    }
    bridge.set_temperature(70.0);
    for load in LOADS {
        assert_sample(&mut bridge, warm(70.0, load), load);
    }
    for celsius in [-1.0, 81.0, f32::NAN] {
        bridge.set_temperature(celsius);
        let sample = bridge.sample(0).unwrap().unwrap();
        assert!(sample.doubts.contains(Mark::Temperature), "{celsius}");
    }
}

#[test]
fn a_tare_is_refused_while_the_shaft_turns_or_samples_are_doubted() {
    let mut bridge = bridges(ZERO, *CALIBRATION);
    // It is not known to stand.
    assert_eq!(bridge.take_tare(5), Err(TareError::Turning));
    bridge.set_turning(false);
    bridge.take_tare(5).unwrap();
    bridge.sample(0).unwrap();
    bridge.set_turning(true);
    bridge.sample(1).unwrap();
    assert_eq!(bridge.tare_state(), TareState::Refused(TareError::Turning));
    bridge.set_turning(false);
    for (next, mark) in [
        (Err(AdcError::Bus), Mark::Bus),
        (Err(AdcError::Checksum), Mark::Corrupt),
        (Ok(Some([0x7f_ffff; 6])), Mark::Saturated),
    ] {
        bridge.take_tare(5).unwrap();
        bridge.adc().next = next;
        let _ = bridge.sample(2);
        let TareState::Refused(TareError::Marked(marks)) = bridge.tare_state() else {
            panic!("{:?}", bridge.tare_state());
        };
        assert!(marks.contains(mark));
    }
    assert_eq!(bridge.tare(), None);
    bridge.set_tare([f32::NAN; 6]);
    assert_eq!(bridge.tare(), None);
}

#[test]
fn a_stuck_bridge_a_rail_and_a_broken_calibration_leave_their_marks_on_the_tick() {
    type Spoil = fn(&mut Bridges);
    let cases: [(Spoil, Mark, i32); 4] = [
        (|_| {}, Mark::Stuck, 20),
        (
            |b| b.adc().next = Ok(Some([0x80_0010; 6])),
            Mark::Saturated,
            1,
        ),
        (|b| b.adc().next = Err(AdcError::Reset), Mark::Bus, 1),
        (
            |b| {
                let mut calibration = *CALIBRATION;
                calibration.loads[0][0] = f32::NAN;
                assert_eq!(calibration.check(), Err(CalibrationError::NotFinite));
                let tare = b.tare().unwrap();
                *b = bridges(counts(IDLE), calibration);
                b.set_tare(tare);
            },
            Mark::NotFinite,
            1,
        ),
    ];
    for (spoil, mark, within) in cases {
        let mut rig = Rig::new(&SETTINGS);
        let mut bridge = tared();
        bridge.adc().next = Ok(Some(counts(IDLE)));
        let mut first = None;
        for i in -50..=200 {
            if i == 0 {
                spoil(&mut bridge);
            }
            if i >= 0 && mark == Mark::Stuck {
                // A test's converter always has noise.
                bridge.adc().noise = 0;
            }
            let readings = Readings {
                speed: Some(Some(0.0)),
                ..at_speed(bridge.sample(rig.time_us))
            };
            let outcome = rig.tick(&readings);
            assert!(i >= 0 || outcome.marks.is_empty(), "{}", outcome.marks);
            if outcome.marks.contains(mark) {
                first = first.or(Some(i + 1));
                assert!(!outcome.solved);
            }
        }
        assert!(first.unwrap() <= within, "{mark}: {first:?}");
        assert_eq!(rig.state(Alarm::Sensor), AlarmState::Raised, "{mark}");
    }
}

#[test]
fn a_calibration_that_cannot_be_is_refused() {
    let mut twice = RESPONSE;
    for row in &mut twice {
        row[4] = 3.0 * row[0];
    }
    assert!(loads(&twice).is_err());
    let mut broken = RESPONSE;
    broken[2][3] = f64::NAN;
    assert!(loads(&broken).is_err());
    let mut another = *CALIBRATION;
    assert_eq!(another.check(), Ok(()));
    let blind = Calibration::<6>::new([[0.0; 6]; 5], [[0.0; 5]; 6]);
    assert_eq!(blind.check(), Err(CalibrationError::Mismatch));
    another.counts[3][1] *= 1.01;
    assert_eq!(another.check(), Err(CalibrationError::Mismatch));
    let mut cold = *CALIBRATION;
    cold.temperature = 200.0;
    assert_eq!(cold.check(), Err(CalibrationError::Temperature));
}

// --- the converter's driver on a simulated chip ---------------------------------------------------

struct Pin {
    low: bool,
}

impl ErrorType for Pin {
    type Error = Infallible;
}

impl InputPin for Pin {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(!self.low)
    }
    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(self.low)
    }
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

struct NoDelay;

impl DelayNs for NoDelay {
    fn delay_ns(&mut self, _: u32) {}
}

/// An ADS131M08: words of 16 bits until they are set to 24.
struct Chip<'a> {
    registers: [u16; 6],
    /// The register that is read next.
    asked: usize,
    /// A register that keeps its value.
    stuck: Option<usize>,
    commands: Vec<u16>,
    /// Outcome of each conversion.
    frames: &'a mut VecDeque<Result<[u8; 30], ErrorKind>>,
}

const CLOCK: usize = 3;

impl spi::ErrorType for Chip<'_> {
    type Error = ErrorKind;
}

impl SpiDevice for Chip<'_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let register = |bytes: &[u8]| usize::from(u16::from_be_bytes([bytes[0], bytes[1]]) >> 7);
        for operation in operations {
            match operation {
                Operation::Write([bytes @ .., _]) if bytes.len() == 2 => {
                    self.asked = register(bytes) - (0xa000 >> 7);
                }
                Operation::Write(bytes) => {
                    let at = register(bytes) - (0x6000 >> 7);
                    if self.stuck != Some(at) {
                        self.registers[at] = u16::from_be_bytes([bytes[3], bytes[4]]);
                    }
                }
                Operation::Read(bytes) => {
                    bytes[..2].copy_from_slice(&self.registers[self.asked].to_be_bytes());
                }
                Operation::TransferInPlace(bytes) if bytes.len() == 20 => {
                    self.commands.push(u16::from_be_bytes([bytes[0], bytes[1]]));
                }
                Operation::TransferInPlace(bytes) => {
                    // Unlocked, then woken up. All channels, ratio 512, high resolution; gains of 32; words of 24 bits.
                    assert_eq!(self.commands, [0x0655, 0, 0x0033]);
                    assert_eq!(self.registers[2..], [0x0100, 0xff0a, 0x5555, 0x5555]);
                    bytes.copy_from_slice(&self.frames.pop_front().unwrap()?);
                }
                other => panic!("{other:?}"),
            }
        }
        Ok(())
    }
}

/// CRC-16/CCITT-FALSE by itself.
fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xffff, |crc, byte| {
        (0..8).fold(crc ^ (u16::from(*byte) << 8), |crc, _| {
            (crc << 1) ^ if crc & 0x8000 == 0 { 0 } else { 0x1021 }
        })
    })
}

fn conversion(status: u16, channels: [i32; 8], damage: u8) -> Result<[u8; 30], ErrorKind> {
    let mut frame = [0; 30];
    frame[..2].copy_from_slice(&status.to_be_bytes());
    for (word, count) in frame[3..27].chunks_mut(3).zip(channels) {
        word.copy_from_slice(&count.to_be_bytes()[1..]);
    }
    let sum = crc(&frame[..27]).to_be_bytes();
    frame[27..29].copy_from_slice(&sum);
    frame[10] ^= damage;
    Ok(frame)
}

type Started<'a> = Ads131m08Bridges<Ads131m08<Chip<'a>, Pin, Pin, Pin, NoDelay>, 6>;

fn started(
    frames: &mut VecDeque<Result<[u8; 30], ErrorKind>>,
    ready: bool,
    stuck: Option<usize>,
) -> Result<Started<'_>, AdcError> {
    let chip = Chip {
        registers: [0x2800, 0, 0, 0, 0, 0],
        asked: 0,
        stuck,
        commands: Vec::new(),
        frames,
    };
    let config = Ads131m08Config {
        gain: [Gain::Gain32; 8],
        ..Ads131m08Config::default()
    };
    let pin = |low| Pin { low };
    let device = Ads131m08::new(chip, pin(ready), pin(false), pin(false), NoDelay);
    Ads131m08Bridges::start(device, &config)
}

#[test]
fn the_converters_faults_come_out_by_name() {
    let channels = [1, -1, 8_388_607, -8_388_608, 70_000, -70_000, 5, 6];
    let good = Ok(Some([1, -1, 8_388_607, -8_388_608, 70_000, -70_000]));
    let (frames, expected): (VecDeque<_>, Vec<_>) = [
        (conversion(0x01ff, channels, 0), good),
        (conversion(0x01ff, channels, 0x04), Err(AdcError::Checksum)),
        (conversion(0x05ff, channels, 0), Err(AdcError::Reset)),
        (conversion(0x41ff, channels, 0), Err(AdcError::Bus)),
        (Err(ErrorKind::ModeFault), Err(AdcError::Bus)),
        (conversion(0x01ff, channels, 0), good),
    ]
    .into_iter()
    .unzip();
    let mut frames = frames;
    let mut bridges = started(&mut frames, true, None).unwrap();
    let mut free = Vec::new();
    let mut read = || {
        let read = bridges.read();
        free.push([7, 2, 8].map(|channel| bridges.count(channel)));
        read
    };
    let readings: Vec<_> = (0..6).map(|_| read()).collect();
    assert_eq!(readings, expected);
    // A channel behind the bridges, one at a rail, and one that is none.
    let none = [None; 3];
    assert_eq!(
        free,
        [
            [Some(6), None, None],
            none,
            none,
            none,
            none,
            [Some(6), None, None]
        ]
    );
}

#[test]
fn a_converter_that_does_not_keep_its_settings_is_not_used() {
    let refused = started(&mut VecDeque::new(), true, Some(CLOCK)).err();
    assert_eq!(refused, Some(AdcError::Settings));
}

#[test]
fn bus_errors_do_not_stop_the_ticks_and_a_conversion_that_is_not_ready_is_no_error() {
    let mut frames = (0..100)
        .map(|i| {
            let noise = [1, -1, 1, -1, 1, -1].map(|sign| sign * (i % 2));
            let [a, b, c, d, e, f]: [i32; 6] = array::from_fn(|k| counts(IDLE)[k] + noise[k]);
            match i % 4 {
                3 => Err(ErrorKind::ModeFault),
                _ => conversion(0x01ff, [a, b, c, d, e, f, 0, 0], 0),
            }
        })
        .collect();
    let bridges = started(&mut frames, true, None).unwrap();
    let mut source = StrainBridge::new(bridges, *CALIBRATION, 20);
    source.set_tare(ZERO.map(|count| count as f32));
    let mut rig = Rig::new(&SETTINGS);
    for i in 0..100 {
        let readings = Readings {
            speed: Some(Some(0.0)),
            ..at_speed(source.sample(rig.time_us))
        };
        let outcome = rig.tick(&readings);
        assert_eq!(outcome.marks.contains(Mark::Bus), i % 4 == 3);
        assert_eq!(outcome.solved, i % 4 != 3);
    }
    assert_eq!(source.errors(), (25, Some(AdcError::Bus)));

    let mut none = VecDeque::new();
    let mut idle = started(&mut none, false, None).unwrap();
    assert_eq!(idle.read(), Ok(None));
}

#[test]
fn a_speed_signal_lost_at_full_speed_stops_estimates_and_life_goes_on_in_doubt() {
    let mut rig = Rig::running(&SETTINGS);
    let mut tachometer = PulseSpeed::new(Edges::default(), TACHOMETER);
    // 1500 rad/s are 955 pulses a second.
    let pulse = 2.0 * std::f64::consts::PI / 4.0 / f64::from(SPEED) * 1e6;
    let mut next = rig.time_us as f64;
    let mut estimates_after = 0;
    for ms in 0..5000 {
        let now = rig.time_us as u32;
        while next <= f64::from(now) {
            if ms < 1000 {
                tachometer.input().edge(next as u32, true);
            }
            next += pulse;
        }
        let speed = tachometer.speed(now);
        if ms > 1040 {
            assert_eq!(speed, Err(SpeedError::Lost));
        }
        let readings = rig.idling_at(speed.ok().map(|speed| speed.omega));
        let outcome = rig.tick(&readings);
        if (10..1000).contains(&ms) {
            assert!(outcome.solved, "{ms}: {}", outcome.marks);
        }
        estimates_after += u32::from(ms > 1000 && outcome.solved);
    }
    // Until the pulse is overdue, the speed is a bound that falls, and that faster than a shaft can.
    assert!(estimates_after <= 2, "{estimates_after}");
    assert_eq!(rig.state(Alarm::Sensor), AlarmState::Raised);
    let doubtful = rig.monitor.life().doubtful_revolutions();
    assert!((4.0 * f64::from(SPEED) / std::f64::consts::TAU - doubtful as f64).abs() < 5.0);
}

// --- the boards' bus ------------------------------------------------------------------------------

#[test]
fn a_bus_exchanges_byte_for_byte_and_one_that_is_dead_is_an_error() {
    let mut sent = Vec::new();
    let exchange = |byte: u8| {
        sent.push(byte);
        Some(!byte)
    };
    let mut bus = Bus::new(exchange, NoDelay);
    let (mut read, mut long, mut place) = ([7; 2], [7; 3], [8, 9]);
    let mut operations = [
        Operation::Write(&[1, 2]),
        Operation::Read(&mut read),
        Operation::Transfer(&mut long, &[3]),
        Operation::Transfer(&mut [], &[4, 5]),
        Operation::DelayNs(100),
        Operation::TransferInPlace(&mut place),
    ];
    assert_eq!(bus.transaction(&mut operations), Ok(()));
    assert_eq!((read, long, place), ([!0; 2], [!3, !0, !0], [!8, !9]));
    assert_eq!(sent, [1, 2, 0, 0, 3, 0, 0, 4, 5, 8, 9]);

    let mut left = 3;
    let dying = |byte| {
        left -= 1;
        (left > 0).then_some(byte)
    };
    let mut bus = Bus::new(dying, NoDelay);
    assert_eq!(bus.transfer_in_place(&mut [1, 2]), Ok(()));
    assert_eq!(bus.transfer_in_place(&mut [3, 4]), Err(ErrorKind::Other));
}
