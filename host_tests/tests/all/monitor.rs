//! The monitor under faults, and for a day.
//!
//! Three laws hold in every tick of every test here ([`Rig::tick`]): no fault stops the ticks, none yields a
//! stiffness without a mark, and no alarm is lost.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use embedded_hal::spi::{self, ErrorKind, Operation, SpiDevice};
use embedded_hal_mock::eh1::spi::{Mock as SpiMock, Transaction};
use host_tests::milling_cycle::milling_cycle;
use host_tests::telemetry::simulated::monitor_settings::MONITOR;
use host_tests::telemetry::simulated::monitored::{BEARING as PAIRED, ROWS, spindle};
use spindle_bearing::monitor::command::Answer;
use spindle_bearing::monitor::judgement::AlarmChange;
use spindle_bearing::monitor::loads::{
    AdcError, Ads131m08, Ads131m08Bridges, Ads131m08Config, BridgeAdc, Calibration,
    CalibrationError, FramedLoads, LoadSample, LoadSource, StrainBridge, TareError, TareState,
};
use spindle_bearing::monitor::settings::MonitorSettings;
use spindle_bearing::monitor::speed::{Edges, PulseSpeed, SpeedError, SpeedSettings, SpeedSource};
use spindle_bearing::monitor::telemetry::{
    BallReport, EstimateReport, FrameReader, Payload, RowReport,
};
use spindle_bearing::monitor::tick::{CycleCost, CycleCounter, Watchdog, Widened};
use spindle_bearing::monitor::{Alarm, AlarmState, Mark, Marks, Monitor, Outcome, Readings};
use spindle_bearing::record::{self, LoadRecord};
use spindle_bearing::{Bearing, Settings, ShaftEnd, Solver, Speed, Spindle, SpindleSolver};
use spindle_bearing::{Design, FreeContact, Material};
use std::convert::Infallible;

const DESIGN: Design = Design {
    ball_diameter: 6.35e-3,
    pitch_diameter: 36e-3,
    inner_groove_factor: 0.515,
    outer_groove_factor: 0.525,
    free_contact: FreeContact::Angle(15.0 * std::f64::consts::PI / 180.0),
    inner_shoulder_angle: 48.0 * std::f64::consts::PI / 180.0,
    outer_shoulder_angle: 47.5 * std::f64::consts::PI / 180.0,
    first_ball: 0.0,
    ring: Material::STEEL,
    ball: Material::STEEL,
};
pub(super) static BEARING: Bearing<f32, 16> = match Bearing::<f32, 16>::new(&DESIGN) {
    Ok(bearing) => bearing,
    Err(_) => panic!("this bearing cannot be built"),
};

/// Ten iterations fit into a tick.
pub(super) static SETTINGS: MonitorSettings = settings(10, 1);
/// One iteration fits into a tick.
static TIGHT: MonitorSettings = settings(1, 1);
/// Solved at every fifth tick.
static SELDOM: MonitorSettings = settings(10, 5);

pub(super) const fn settings(iterations: u32, solve_every: u16) -> MonitorSettings {
    let mut settings = MonitorSettings::new(&DESIGN, 16);
    let cost = CycleCost::CORTEX_M4F_SINGLE;
    settings.tick.deadline_cycles = cost.fixed + iterations * cost.iteration;
    settings.tick.solve_every = solve_every;
    settings
}
const _: () = assert!(SETTINGS.check().is_ok() && TIGHT.check().is_ok() && DAY.check().is_ok());

/// What was shipped for a single bearing: loads of its own, a solve within five iterations.
pub(super) static ON_BEARING: MonitorSettings = {
    let mut settings = settings(5, 1);
    settings.plausibility.load = [
        [-500.0, 3e3],
        [-3e3, 3e3],
        [-3e3, 3e3],
        [-60.0, 60.0],
        [-60.0, 60.0],
    ];
    settings.plausibility.load_rate = [1.2e6, 1.2e6, 1.2e6, 2e4, 2e4];
    settings.tolerance = 5e-4;
    settings
};

pub(super) const IDLE: [f32; 5] = [420.0, 5.0, -8.0, 0.05, -0.1];
/// Loads at the nose of the shipped spindle of a cutter 50 mm in front of it that puts this force (N) onto the front bearing.
pub(super) fn at_nose(force: [f64; 3]) -> [f32; 5] {
    let [x, y, z] = force.map(|force| 0.55 * force);
    [x, y, z, 0.05 * z, -0.05 * y].map(|load| load as f32)
}

pub(super) const SPEED: f32 = 1500.0;

/// Cycles as a test says.
#[derive(Default)]
struct Counter {
    now: u32,
    cost: u32,
    reads: u32,
}

impl CycleCounter for Counter {
    fn cycles(&mut self) -> u32 {
        self.reads += 1;
        if self.reads.is_multiple_of(2) {
            self.now = self.now.wrapping_add(self.cost);
        }
        self.now
    }
}

#[derive(Default)]
struct Dog {
    fed: u64,
}

impl Watchdog for Dog {
    fn feed(&mut self) {
        self.fed += 1;
    }
}

/// A monitor, and a host at the end of its link that knows what must arrive.
pub(super) struct Rig<const R: usize = 1> {
    pub(super) monitor: Monitor<R, 16>,
    /// Loads of the idling spindle.
    pub(super) idle: [f32; 5],
    counter: Counter,
    dog: Dog,
    pub(super) time_us: u64,
    ticks: u64,
    /// Bytes that the link takes in a tick.
    link: usize,
    reader: FrameReader,
    /// Marks of every tick, by its time in ms.
    marks: Vec<Marks>,
    /// What happened to alarms, and what arrived of it.
    pub(super) happened: Vec<(Alarm, AlarmChange)>,
    arrived: Vec<(Alarm, AlarmChange)>,
    /// Counts in the last report of each alarm.
    counts: [(u32, u32); Alarm::COUNT],
    stiffness: Vec<(u64, [f32; 5])>,
    /// Loads of the estimates that arrived.
    pub(super) loads: Vec<[f32; 5]>,
    /// The last report of every ball.
    balls: Vec<BallReport>,
    jitter: f32,
    /// The last estimate, and the last report of its rows.
    estimate: Option<EstimateReport>,
    rows: Vec<RowReport>,
    /// Answers that arrived.
    pub(super) answers: Vec<Answer>,
}

impl Rig {
    pub(super) fn new(settings: &'static MonitorSettings) -> Self {
        Self::of(Spindle::single(&BEARING), settings, IDLE)
    }
}

impl Rig<ROWS> {
    /// The shipped spindle.
    pub(super) fn shipped() -> Self {
        Self::of(spindle(&PAIRED).unwrap(), &MONITOR, [0.0; 5])
    }
}

impl<const R: usize> Rig<R> {
    fn of(
        spindle: Spindle<'static, f32, R, 16>,
        settings: &'static MonitorSettings<R>,
        idle: [f32; 5],
    ) -> Self {
        let mut monitor = Monitor::new(spindle, settings);
        monitor.prepare([idle[0], 0.0, 0.0, 0.0, 0.0], 0.0).unwrap();
        Self {
            monitor,
            idle,
            counter: Counter::default(),
            dog: Dog::default(),
            time_us: 0,
            ticks: 0,
            link: 4096,
            reader: FrameReader::new(),
            marks: Vec::new(),
            happened: Vec::new(),
            arrived: Vec::new(),
            counts: [(0, 0); Alarm::COUNT],
            stiffness: Vec::new(),
            loads: Vec::new(),
            balls: Vec::new(),
            jitter: 0.0,
            estimate: None,
            rows: Vec::new(),
            answers: Vec::new(),
        }
    }

    /// One tick, and the laws.
    pub(super) fn tick(&mut self, readings: &Readings) -> Outcome {
        let outcome = self
            .monitor
            .tick(self.time_us, readings, &mut self.counter, &mut self.dog);
        self.ticks += 1;
        // No fault stops the ticks.
        assert_eq!(
            (self.monitor.health().ticks, self.dog.fed),
            (self.ticks, self.ticks)
        );
        // What is doubted is not solved.
        assert!(!outcome.solved || outcome.marks.is_empty(), "{outcome:?}");
        assert!(!outcome.solved || outcome.iterations > 0, "{outcome:?}");
        // A sample may have waited for its solve, but not for longer than solves are apart.
        assert!(!outcome.solved || outcome.age.is_some_and(|age| age < 5));
        self.marks.push(outcome.marks);
        let changes = outcome.changes.iter();
        self.happened.extend(changes.map(|c| (c.alarm, c.change)));
        self.receive(self.link);
        self.time_us += 1000;
        outcome
    }

    fn receive(&mut self, bytes: usize) {
        for _ in 0..bytes {
            let Some(byte) = self.monitor.outbox().next_byte() else {
                break;
            };
            let Some(frame) = self.reader.push(byte) else {
                continue;
            };
            let frame = frame.unwrap();
            match frame.payload {
                Payload::Estimate(report) => {
                    // No stiffness without the marks of its tick.
                    let tick = (frame.time_us / 1000) as usize;
                    assert_eq!(report.marks, self.marks[tick]);
                    assert!(report.stiffness.iter().all(|k| k.is_finite() && *k > 0.0));
                    self.stiffness.push((frame.time_us, report.stiffness));
                    self.loads.push(report.load);
                    self.estimate = Some(report);
                }
                Payload::Alarm(report) => {
                    self.counts[report.alarm as usize] = (report.raised, report.cleared);
                    if report.change != AlarmChange::Standing {
                        self.arrived.push((report.alarm, report.change));
                    }
                }
                Payload::Balls(report) => {
                    self.balls.truncate(report.first.into());
                    self.balls.extend(report.balls);
                }
                Payload::Health(_)
                | Payload::Inputs(_)
                | Payload::Board(_)
                | Payload::Start(_)
                | Payload::Shaft(_) => {}
                Payload::Rows(report) => {
                    self.rows.truncate(report.first.into());
                    self.rows.extend(report.rows);
                }
                Payload::Answer(answer) => self.answers.push(answer),
            }
        }
    }

    /// At the end: every alarm that there was is known at the other end of the link, by its own frame or by
    /// the counts of a later one.
    pub(super) fn no_alarm_is_lost(&mut self) {
        self.receive(usize::MAX);
        assert!(self.monitor.outbox().is_empty());
        for alarm in Alarm::ALL {
            let count = |change| {
                let same = |c: &&(Alarm, AlarmChange)| **c == (alarm, change);
                self.happened.iter().filter(same).count() as u32
            };
            let happened = (count(AlarmChange::Raised), count(AlarmChange::Cleared));
            assert_eq!(self.counts[alarm as usize], happened, "{alarm}");
        }
    }

    /// A load that is never twice the same.
    fn near(&mut self, load: [f32; 5]) -> [f32; 5] {
        self.jitter = (self.jitter + 0.618_034) % 1.0;
        load.map(|x| x * (1.0 + 1e-3 * self.jitter) + 1e-3 * self.jitter)
    }

    pub(super) fn good(&mut self, load: [f32; 5], speed: f32) -> Outcome {
        let sample = self.sample(load);
        self.tick(&Readings {
            loads: Ok(Some(sample)),
            speed: Some(Some(speed)),
            temperatures: None,
        })
    }

    pub(super) fn sample(&mut self, load: [f32; 5]) -> LoadSample {
        LoadSample {
            time_us: self.time_us,
            load: self.near(load),
            speed: None,
            residual: 0.0,
            doubts: Marks::NONE,
        }
    }

    /// So many ticks do not begin.
    pub(super) fn leave_out(&mut self, ticks: usize) {
        let marks = self.marks.last().copied().unwrap_or_default();
        self.marks.resize(self.marks.len() + ticks, marks);
        self.time_us += 1000 * ticks as u64;
    }

    /// Brings the spindle to its speed, as fast as it can.
    pub(super) fn run_up(&mut self) {
        for ms in 0..1000 {
            self.good(self.idle, SPEED * ms as f32 / 1000.0);
        }
        let outcome = self.good(self.idle, SPEED);
        assert!(outcome.marks.is_empty(), "{outcome:?}");
    }

    pub(super) fn state(&mut self, alarm: Alarm) -> AlarmState {
        self.monitor.judgement().alarm(alarm).state()
    }
}

/// Warm, loaded at the nose: what is reported of rows and nose is what the spindle's own solver says.
#[test]
fn the_estimate_of_a_pair_is_its_spindles_own() {
    let mut rig = Rig::shipped();
    let temperatures = [31.0, 26.0];
    for ms in 0..3000 {
        let speed = SPEED * (ms as f32 / 1000.0).min(1.0);
        let load = if ms < 2000 {
            [0.0; 5]
        } else {
            at_nose([300.0, 400.0, -250.0])
        };
        let ramp = load.map(|x| x * ((ms as f32 - 2000.0) / 200.0).clamp(0.0, 1.0));
        let sample = rig.sample(ramp);
        rig.tick(&Readings {
            loads: Ok(Some(sample)),
            speed: Some(Some(speed)),
            temperatures: Some(temperatures),
        });
    }
    let report = rig.estimate.unwrap();
    assert_eq!(rig.rows.len(), ROWS);

    let warmer = MONITOR
        .temperatures
        .map_or([0.0; 2], |t| temperatures.map(|x| x - t.reference));
    let growth = MONITOR.rows.each_ref().map(|row| {
        row.rotation * (report.speed * report.speed)
            + row.heat[0] * warmer[0]
            + row.heat[1] * warmer[1]
    });
    // Loads are measured at x = 0, where the nose is.
    assert_eq!([MONITOR.shaft.loads_at, MONITOR.shaft.nose], [0.0; 2]);
    let mut solver = SpindleSolver::new(spindle(&PAIRED).unwrap());
    let speed = Speed::rad_per_s(report.speed);
    let own = solver
        .solve_at(report.load, speed, &growth, &Settings::default())
        .unwrap();

    let near = |what: &str, reported: f32, own: f32, size: f32| {
        assert!(
            (reported - own).abs() < 2e-3 * size,
            "{what}: {reported}, not {own}"
        );
    };
    let nose = own.compliance_at(&ShaftEnd::rigid(0.0));
    for (i, &k) in report.nose.iter().enumerate() {
        near("nose", k * nose[i][i], 1.0, 1.0);
        near(
            "displacement",
            report.displacement[i],
            own.displacement[i],
            1e-5,
        );
    }
    for (report, row) in rig.rows.iter().zip(own.rows()) {
        let size = row.force[0];
        near("axial", report.axial, row.force[0], size);
        near("radial", report.radial[0], row.force[1], size);
        near("radial", report.radial[1], row.force[2], size);
        near("preload", report.preload, row.preload(), size);
        let largest = row.inner_forces().fold(0.0, f32::max);
        let least = row.inner_forces().fold(f32::INFINITY, f32::min);
        near("largest force", report.largest_force, largest, largest);
        near("least force", report.least_force, least, largest);
    }
}

#[test]
fn the_estimate_is_the_solvers_own() {
    let mut rig = Rig::new(&SETTINGS);
    rig.run_up();
    for _ in 0..300 {
        let outcome = rig.good(IDLE, SPEED);
        assert!(outcome.solved && outcome.age == Some(0));
    }
    // Of the last report.
    let (time, stiffness) = *rig.stiffness.last().unwrap();
    assert!(rig.time_us - time <= 20_000);
    let mut solver = Solver::new(&BEARING);
    let own = solver
        .solve(IDLE, Speed::rad_per_s(SPEED), &Settings::default())
        .unwrap();
    for (i, k) in stiffness.iter().enumerate() {
        assert!((k / own.stiffness()[i][i] - 1.0).abs() < 1e-3, "K{i}{i}");
    }
    assert_eq!(rig.balls.len(), 16);
    for (j, (report, ball)) in rig.balls.iter().zip(own.balls()).enumerate() {
        for (what, reported, own) in [
            ("Qi", report.q_i, ball.q_i),
            ("Qo", report.q_o, ball.q_o),
            ("alpha_i", report.alpha_i, ball.alpha_i),
            ("alpha_o", report.alpha_o, ball.alpha_o),
        ] {
            let off = (reported / own - 1.0).abs();
            assert!(off < 5e-3, "{what} of ball {j}: {reported} for {own}");
        }
        // One contact would not pass for the other.
        assert!(
            ball.alpha_i > 1.01 * ball.alpha_o && ball.q_o > 1.01 * ball.q_i,
            "{ball:?}"
        );
    }
    rig.no_alarm_is_lost();
    assert!(rig.happened.is_empty(), "{:?}", rig.happened);
}

/// A fault of the readings, and the mark that it must make.
type Fault = (&'static str, fn(&mut Rig) -> Readings, Mark);

const FAULTS: [Fault; 10] = [
    ("bus error", |_| bad(Err(Mark::Bus.into())), Mark::Bus),
    ("nameless error", |_| bad(Err(Marks::NONE)), Mark::Bus),
    (
        "not a number",
        |rig| spoilt(rig, |s| s.load[2] = f32::NAN),
        Mark::NotFinite,
    ),
    (
        "infinite",
        |rig| spoilt(rig, |s| s.load[4] = f32::INFINITY),
        Mark::NotFinite,
    ),
    (
        "out of range",
        |rig| spoilt(rig, |s| s.load[0] = 1e7),
        Mark::Range,
    ),
    ("spike", |rig| spoilt(rig, |s| s.load[1] = 9e3), Mark::Rate),
    (
        "converter at its rail",
        |rig| spoilt(rig, |s| s.doubts = Mark::Saturated.into()),
        Mark::Saturated,
    ),
    ("speed lost", |rig| at(rig, None), Mark::SpeedMissing),
    (
        "speed not a number",
        |rig| at(rig, Some(f32::NAN)),
        Mark::SpeedMissing,
    ),
    (
        "speed jumps",
        |rig| at(rig, Some(0.5 * SPEED)),
        Mark::SpeedRate,
    ),
];

fn bad(loads: Result<Option<LoadSample>, Marks>) -> Readings {
    Readings {
        loads,
        speed: Some(Some(SPEED)),
        temperatures: None,
    }
}

fn spoilt(rig: &mut Rig, spoil: fn(&mut LoadSample)) -> Readings {
    let mut sample = rig.sample(IDLE);
    spoil(&mut sample);
    bad(Ok(Some(sample)))
}

fn at(rig: &mut Rig, speed: Option<f32>) -> Readings {
    Readings {
        loads: Ok(Some(rig.sample(IDLE))),
        speed: Some(speed),
        temperatures: None,
    }
}

#[test]
fn every_fault_has_its_mark_keeps_the_last_estimate_and_passes() {
    for (name, fault, mark) in FAULTS {
        let mut rig = Rig::new(&SETTINGS);
        rig.run_up();
        let before = rig.monitor.health();
        for age in 1..=5 {
            let readings = fault(&mut rig);
            let outcome = rig.tick(&readings);
            assert!(outcome.marks.contains(mark), "{name}: {}", outcome.marks);
            assert_eq!(outcome.age, Some(age), "{name}");
        }
        let outcome = rig.good(IDLE, SPEED);
        assert!(
            outcome.solved && outcome.marks.is_empty(),
            "{name}: {}",
            outcome.marks
        );
        let after = rig.monitor.health();
        assert_eq!(after.marked_samples - before.marked_samples, 5, "{name}");
        assert_eq!(after.estimates - before.estimates, 1, "{name}");
        assert_eq!(rig.state(Alarm::Sensor), AlarmState::Clear, "{name}");
    }
}

#[test]
fn a_fault_that_lasts_raises_the_sensor_alarm_which_stays_until_acknowledged() {
    for (name, fault, _) in FAULTS {
        let mut rig = Rig::new(&SETTINGS);
        rig.run_up();
        for _ in 0..120 {
            let readings = fault(&mut rig);
            rig.tick(&readings);
        }
        let raised = |alarm| (alarm, AlarmChange::Raised);
        // These two are believed after a while: they may be true.
        let steps = ["spike", "speed jumps"].contains(&name);
        if !steps {
            assert!(rig.happened.contains(&raised(Alarm::Sensor)), "{name}");
            assert!(
                rig.happened.contains(&raised(Alarm::StaleEstimate)),
                "{name}"
            );
        }
        for _ in 0..500 {
            rig.good(IDLE, SPEED);
        }
        if !steps {
            assert_eq!(rig.state(Alarm::Sensor), AlarmState::Latched, "{name}");
            rig.monitor.acknowledge(rig.time_us, Alarm::Sensor);
            assert_eq!(rig.state(Alarm::Sensor), AlarmState::Clear, "{name}");
        }
        rig.no_alarm_is_lost();
        assert_eq!(
            rig.arrived
                .iter()
                .filter(|(_, change)| *change == AlarmChange::Raised)
                .count(),
            rig.happened
                .iter()
                .filter(|(_, change)| *change == AlarmChange::Raised)
                .count(),
        );
    }
}

#[test]
fn silence_is_missing_after_its_time_and_only_then() {
    let mut rig = Rig::new(&SETTINGS);
    rig.run_up();
    for ms in 1..200 {
        let outcome = rig.tick(&bad(Ok(None)));
        assert_eq!(outcome.marks.contains(Mark::Missing), ms > 50, "{ms}");
        assert_eq!(outcome.age, Some(ms));
    }
    assert_eq!(rig.state(Alarm::Sensor), AlarmState::Raised);
}

#[test]
fn two_speeds_that_disagree_are_both_doubted() {
    let mut rig = Rig::new(&SETTINGS);
    rig.run_up();
    for (other, doubted) in [(SPEED, false), (SPEED + 35.0, false), (SPEED - 45.0, true)] {
        let mut sample = rig.sample(IDLE);
        sample.speed = Some(other);
        let outcome = rig.tick(&bad(Ok(Some(sample))));
        assert_eq!(
            outcome.marks.contains(Mark::SpeedDisagreement),
            doubted,
            "{other}"
        );
        assert_eq!(outcome.solved, !doubted);
    }
}

#[test]
fn any_mix_of_faults_for_a_minute_breaks_no_law() {
    let mut x = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = move |below: u64| {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        (x >> 33) % below
    };
    for settings in [&SETTINGS, &TIGHT, &SELDOM] {
        let mut rig = Rig::new(settings);
        rig.link = 4;
        rig.run_up();
        let mut lasting = None;
        for i in 0..30_000 {
            // One fault in a while lasts.
            if i % 200 == 0 {
                lasting = (random(3) == 0).then(|| random(12));
            }
            rig.counter.cost = random(2 * u64::from(settings.tick.deadline_cycles)) as u32;
            let readings = match lasting.unwrap_or(random(40)) {
                which @ 0..10 => FAULTS[which as usize].1(&mut rig),
                10 => Readings {
                    loads: Ok(Some(LoadSample {
                        load: std::array::from_fn(|_| f32::from_bits(random(1 << 32) as u32)),
                        ..rig.sample(IDLE)
                    })),
                    speed: Some(Some(f32::from_bits(random(1 << 32) as u32))),
                    temperatures: None,
                },
                11 => bad(Ok(None)),
                _ => {
                    let load = [
                        random(900) as f32,
                        random(300) as f32,
                        0.0,
                        0.0,
                        random(3) as f32,
                    ];
                    at(&mut rig, Some(SPEED)).tap(load)
                }
            };
            rig.tick(&readings);
            if random(500) == 0 {
                let alarm = Alarm::ALL[random(10) as usize];
                rig.monitor.acknowledge(rig.time_us, alarm);
            }
        }
        let health = rig.monitor.health();
        assert!(
            health.estimates > 1000 && health.overruns > 10_000,
            "{health:?}"
        );
        assert!(
            health.alarms_raised > 10 && health.frames_dropped > 100,
            "{health:?}"
        );
        rig.no_alarm_is_lost();
        // And it comes back.
        rig.counter.cost = 1000;
        for _ in 0..3000 {
            rig.good(IDLE, SPEED);
        }
        let every = usize::from(settings.tick.solve_every);
        assert!((0..every).any(|_| rig.good(IDLE, SPEED).solved));
    }
}

trait Tap {
    fn tap(self, load: [f32; 5]) -> Self;
}

impl Tap for Readings {
    /// With another load.
    fn tap(mut self, load: [f32; 5]) -> Self {
        if let Ok(Some(sample)) = &mut self.loads {
            for (to, more) in sample.load.iter_mut().zip(load) {
                *to += more;
            }
        }
        self
    }
}

#[test]
fn a_load_step_is_doubted_then_believed_then_solved_within_the_budget_of_its_ticks() {
    let mut rig = Rig::new(&TIGHT);
    rig.run_up();
    let step = [900.0, 300.0, -150.0, 1.0, 2.0];
    let mut solved = None;
    for ms in 0..400 {
        let outcome = rig.good(step, SPEED);
        if outcome.solved && solved.is_none() {
            solved = Some(ms);
        }
    }
    let solved = solved.unwrap();
    assert!(solved < 100, "{solved}");
    let mut solver = Solver::new(&BEARING);
    let own = solver
        .solve(step, Speed::rad_per_s(SPEED), &Settings::default())
        .unwrap();
    let (_, stiffness) = *rig.stiffness.last().unwrap();
    for (i, k) in stiffness.iter().enumerate() {
        assert!((k / own.stiffness()[i][i] - 1.0).abs() < 2e-3, "K{i}{i}");
    }
}

#[test]
fn loads_without_an_equilibrium_are_refused_with_a_mark_and_cost_nothing_later() {
    let mut rig = Rig::new(&TIGHT);
    rig.run_up();
    let before = rig.monitor.health();
    // Without any load the ring floats.
    for _ in 0..300 {
        let mut sample = rig.sample(IDLE);
        sample.load = [0.0; 5];
        let outcome = rig.tick(&bad(Ok(Some(sample))));
        assert!(!outcome.solved);
    }
    let after = rig.monitor.health();
    assert!(after.refusals - before.refusals >= 99, "{after:?}");
    assert_eq!(after.estimates, before.estimates);
    assert_eq!(rig.state(Alarm::StaleEstimate), AlarmState::Raised);
    assert!(rig.marks.last().unwrap().contains(Mark::Unsolved));
    for _ in 0..100 {
        rig.good(IDLE, SPEED);
    }
    assert!(rig.good(IDLE, SPEED).solved);
    rig.no_alarm_is_lost();
}

#[test]
fn without_a_prepared_start_the_first_tick_solves_from_nothing() {
    let mut rig = Rig::new(&TIGHT);
    rig.monitor = Monitor::new(Spindle::single(&BEARING), &TIGHT);
    assert!(rig.tick(&bad(Ok(None))).marks.contains(Mark::NoEstimate));
    assert!(rig.stiffness.is_empty());
    let outcome = rig.good(IDLE, SPEED);
    assert!(outcome.solved && outcome.marks.is_empty(), "{outcome:?}");
}

#[test]
fn overruns_are_counted_and_raise_their_alarm() {
    let mut rig = Rig::new(&SETTINGS);
    rig.run_up();
    rig.counter.cost = SETTINGS.tick.deadline_cycles + 1;
    for _ in 0..12 {
        assert!(rig.good(IDLE, SPEED).overrun);
    }
    rig.counter.cost -= 1;
    for _ in 0..3000 {
        assert!(!rig.good(IDLE, SPEED).overrun);
    }
    let health = rig.monitor.health();
    assert_eq!(
        (health.overruns, health.most_cycles),
        (12, SETTINGS.tick.deadline_cycles + 1)
    );
    assert_eq!(rig.state(Alarm::Deadline), AlarmState::Latched);
    rig.no_alarm_is_lost();
}

#[test]
fn a_link_that_is_shut_costs_estimates_and_no_alarm() {
    let mut rig = Rig::new(&SETTINGS);
    rig.run_up();
    rig.receive(usize::MAX);
    rig.link = 0;
    // Thirty times as many changes as the queue of alarms holds.
    for _ in 0..60 {
        for _ in 0..110 {
            rig.tick(&bad(Err(Mark::Bus.into())));
        }
        for _ in 0..10 {
            rig.good(IDLE, SPEED);
        }
    }
    let health = rig.monitor.health();
    // And one that stands: most ticks are without an estimate.
    assert_eq!((health.alarms_raised, health.alarms_cleared), (121, 120));
    assert!(health.frames_dropped > 300, "{health:?}");
    rig.no_alarm_is_lost();
    // The first ones came one by one, in their order.
    let (happened, arrived) = (rig.happened.clone(), rig.arrived.clone());
    assert!(arrived.len() >= 40 && arrived[..40] == happened[..40]);
}

#[test]
fn lost_preload_is_told_from_cutting() {
    let mut rig = Rig::new(&LEARNING);
    rig.run_up();
    rig.monitor.learn(true);
    for _ in 0..300 {
        rig.good(IDLE, SPEED);
    }
    rig.monitor.learn(false);
    // Cutting changes stiffness by more than the limit, but is not idling.
    for _ in 0..300 {
        rig.good([250.0, 200.0, 0.0, 0.0, 2.0], SPEED);
    }
    assert_eq!(rig.state(Alarm::StiffnessLoss), AlarmState::Clear);
    // Preload goes, slowly.
    let mut raised = Vec::new();
    for i in 0..6000 {
        let mut load = IDLE;
        load[0] = 420.0 * (1.0 - i as f32 / 12_000.0);
        let outcome = rig.good(load, SPEED);
        raised.extend(outcome.changes.iter().map(|c| (c.alarm, i)));
    }
    let when = |alarm| raised.iter().find(|(a, _)| *a == alarm).map(|(_, i)| *i);
    let early = when(Alarm::StiffnessTrend).unwrap();
    let late = when(Alarm::StiffnessLoss).unwrap();
    assert!(early + 500 < late, "{raised:?}");
    rig.no_alarm_is_lost();
}

/// Trends over seconds instead of hours.
static LEARNING: MonitorSettings = {
    let mut settings = settings(10, 1);
    settings.judgement.trend.span_us = 100_000;
    settings.judgement.trend.least_estimates = 50;
    settings.judgement.trend.ahead = 3.0;
    settings.judgement.thresholds[Alarm::StiffnessLoss as usize].hold_us = 100_000;
    settings
};

// --- sources ------------------------------------------------------------------------------------

const RECORD: LoadRecord = LoadRecord {
    sequence: 0,
    time_ms: 0,
    fx: 420.0,
    fy: 5.0,
    fz: -8.0,
    my: 0.05,
    mz: -0.1,
    speed_rpm: 12_000.0,
};

/// A source that gets a record in every millisecond, and the marks of what comes of it.
fn marks_of(records: impl IntoIterator<Item = (u64, LoadRecord)>) -> (Vec<Marks>, FramedLoads) {
    let mut source = FramedLoads::new();
    let marks = records.into_iter().map(|(ms, record)| {
        for byte in record::encode(&record) {
            source.push(byte);
        }
        match source.sample(1000 * ms) {
            Ok(sample) => sample.map_or(Marks::NONE, |sample| sample.doubts),
            Err(marks) => marks,
        }
    });
    (marks.collect(), source)
}

const fn numbered(sequence: u32, time_ms: u32) -> LoadRecord {
    LoadRecord {
        sequence,
        time_ms,
        ..RECORD
    }
}

/// From the tenth second on, the five seconds before it again and again, or their very records once more.
#[test]
fn a_stretch_of_records_that_comes_again_is_out_of_order_all_along() {
    let (marks, source) = marks_of((0..30_000).map(|ms| {
        let n = match ms {
            0..10_000 => ms,
            _ => 5000 + ms % 5000,
        };
        (u64::from(ms), numbered(n, n))
    }));
    assert!(marks[..10_000].iter().all(|marks| marks.is_empty()));
    let order = Marks::from(Mark::Order);
    assert!(marks[10_000..].iter().all(|marks| *marks == order));
    assert_eq!(source.counts().disordered, 20_000);
}

#[test]
fn a_sender_that_begins_anew_is_believed_from_its_second_record_on() {
    // It takes a second to start, and its clock begins with it.
    let first = (0..5000).map(|ms| (u64::from(ms), numbered(700 + ms, 90_000 + ms)));
    let again = (0..5000).map(|ms| (u64::from(6000 + ms), numbered(ms, ms)));
    let (marks, source) = marks_of(first.chain(again));
    let order = Marks::from(Mark::Order);
    let doubted: Vec<_> = (0..).zip(&marks).filter(|(_, m)| !m.is_empty()).collect();
    assert_eq!(doubted, [(5000, &order)]);
    assert_eq!((source.counts().disordered, source.counts().lost), (1, 0));
}

/// One frame of another sender, whose number is far ahead, does not shut the true one out.
#[test]
fn a_number_that_no_sender_gets_to_is_out_of_order() {
    let (marks, source) = marks_of((0..3000).map(|ms| {
        let sequence = if ms == 1000 { 2_000_000_000 } else { ms };
        (u64::from(ms), numbered(sequence, ms))
    }));
    let doubted: Vec<_> = (0..).zip(&marks).filter(|(_, m)| !m.is_empty()).collect();
    assert_eq!(doubted, [(1000, &Mark::Order.into())]);
    assert_eq!((source.counts().disordered, source.counts().lost), (1, 1));
}

#[test]
fn records_that_come_ten_seconds_late_are_marked_and_counted() {
    // A gateway stops for ten seconds, and then hands on what it has kept, in order and at its pace.
    let (marks, source) = marks_of((0..10_000_u32).map(|n| {
        let late = if n < 5000 { 0 } else { 10_000 };
        (u64::from(n + late), numbered(n, n + 1))
    }));
    assert!(marks[..5000].iter().all(|marks| marks.is_empty()));
    let late = Marks::from(Mark::Late);
    assert!(marks[5000..].iter().all(|marks| *marks == late));
    assert_eq!(source.counts().late, 5000);
}

/// An hour with clocks that part by 100 millionths, records 0 to 15 ms under way, across the wrap of the sender's clock.
#[test]
fn clocks_that_part_and_a_line_that_dawdles_make_no_record_late() {
    for drift in [-100, 0, 100] {
        let (marks, source) = marks_of((0..180_000_i64).map(|n| {
            let ms = 20 * n;
            let sent = (ms + ms * drift / 1_000_000) as u32;
            let under_way = (7 * n % 16) as u64;
            (
                100 + ms as u64 + under_way,
                numbered(n as u32, sent.wrapping_sub(1_000_000)),
            )
        }));
        assert!(marks.iter().all(|marks| marks.is_empty()), "{drift}");
        assert_eq!(source.counts().late, 0);
    }
}

#[test]
fn a_speed_that_is_frozen_at_its_source_is_doubted_and_a_standstill_is_not() {
    static WATCHED: MonitorSettings = {
        let mut settings = settings(10, 1);
        settings.plausibility.speed_stuck_after = 1000;
        settings
    };
    let mut rig = Rig::new(&WATCHED);
    for _ in 0..5000 {
        assert!(rig.good(IDLE, 0.0).marks.is_empty());
    }
    rig.run_up();
    for tick in 0..5000 {
        // A tachometer's last digit moves.
        let speed = SPEED + 1e-3 * (tick % 7) as f32;
        assert!(rig.good(IDLE, speed).marks.is_empty());
    }
    for _ in 0..1000 {
        rig.good(IDLE, SPEED);
    }
    assert_eq!(rig.good(IDLE, SPEED).marks, Mark::SpeedStuck.into());
    for _ in 0..300 {
        rig.good(IDLE, SPEED);
    }
    assert_eq!(rig.state(Alarm::Sensor), AlarmState::Raised);
    rig.no_alarm_is_lost();
}

#[test]
fn damaged_and_lost_frames_are_counted_and_marked() {
    let mut source = FramedLoads::new();
    let frame = |sequence| record::encode(&LoadRecord { sequence, ..RECORD });
    let mut send = |bytes: &[u8], time| {
        for byte in bytes {
            source.push(*byte);
        }
        (source.sample(time), source.counts())
    };
    let start = u32::MAX - 1;
    let (sample, _) = send(&frame(start), 1);
    assert_eq!(sample.unwrap().unwrap().load, RECORD.load());
    assert_eq!(send(&[], 2).0, Ok(None));
    // Damaged: an error, unless a good one follows in time.
    let mut damaged = frame(start.wrapping_add(1)).to_vec();
    damaged[5] ^= 0x10;
    assert_eq!(send(&damaged, 3).0, Err(Mark::Corrupt.into()));
    let mut both = damaged.clone();
    both.extend(frame(start.wrapping_add(2)));
    let (sample, counts) = send(&both, 4);
    assert!(sample.unwrap().unwrap().doubts.is_empty());
    // Across the wrap of the sequence: one is missing, and then two.
    assert_eq!((counts.corrupt, counts.lost, counts.disordered), (2, 1, 0));
    let (_, counts) = send(&frame(start.wrapping_add(5)), 5);
    assert_eq!((counts.received, counts.lost), (3, 3));
    // Twice the same, or an older one.
    for sequence in [start.wrapping_add(5), start.wrapping_add(1)] {
        assert_eq!(send(&frame(sequence), 6).0, Err(Mark::Order.into()));
    }
    // The sender began again from there.
    let (sample, counts) = send(&frame(start.wrapping_add(2)), 7);
    assert!(sample.unwrap().is_some());
    assert_eq!(
        (counts.disordered, counts.lost, counts.passed_over),
        (2, 3, 0)
    );
}

/// Counts that each load makes alone: six bridges.
const RESPONSE: [[f64; 5]; 6] = [
    [800.0, 300.0, 0.0, 0.0, 9000.0],
    [800.0, -150.0, 260.0, -7800.0, -4500.0],
    [800.0, -150.0, -260.0, 7800.0, -4500.0],
    [-350.0, 900.0, 0.0, 0.0, 2000.0],
    [-350.0, -450.0, 780.0, -1700.0, -1000.0],
    [-350.0, -450.0, -780.0, 1700.0, -1000.0],
];
const CALIBRATION: Calibration<6> = match Calibration::from_counts(RESPONSE) {
    Ok(calibration) => calibration,
    Err(_) => panic!("the calibration is singular"),
};
const ZERO: [i32; 6] = [12_345, -4567, 890, 0, -33_000, 5];

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
    std::array::from_fn(|k| {
        let sum: f64 = RESPONSE[k]
            .iter()
            .zip(load)
            .map(|(c, f)| c * f64::from(f))
            .sum();
        ZERO[k] + sum.round() as i32
    })
}

fn bridge() -> StrainBridge<Converter, 6> {
    let converter = Converter {
        next: Ok(Some(ZERO)),
        noise: 0,
    };
    StrainBridge::new(converter, CALIBRATION, 20)
}

fn tared() -> StrainBridge<Converter, 6> {
    let mut bridge = bridge();
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

#[test]
fn bridges_give_back_the_load_that_bent_them() {
    let mut bridge = tared();
    for load in [
        [420.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, -120.0, 75.0, 1.5, -2.5],
        [1500.0, 300.0, -200.0, 4.0, 3.0],
    ] {
        bridge.adc().next = Ok(Some(counts(load)));
        let sample = bridge.sample(0).unwrap().unwrap();
        assert!(sample.doubts.is_empty());
        for (got, truth) in sample.load.iter().zip(load) {
            assert!((got - truth).abs() < 0.02, "{:?}", sample.load);
        }
        // Rounding and a count of noise.
        assert!(sample.residual < 3.0, "{}", sample.residual);
    }
}

#[test]
fn one_bridge_that_is_off_shows_in_what_six_have_in_common() {
    let load = [420.0, 30.0, 20.0, 0.3, 0.2];
    for k in 0..6 {
        let mut bridge = tared();
        let mut raw = counts(load);
        raw[k] += 20_000;
        bridge.adc().next = Ok(Some(raw));
        let sample = bridge.sample(0).unwrap().unwrap();
        assert!(sample.residual > 2000.0, "bridge {k}: {}", sample.residual);
    }
}

#[test]
fn temperature_is_taken_out_and_one_beyond_the_range_is_doubted() {
    let mut calibration = CALIBRATION;
    calibration.zero_slope = [50.0, -20.0, 0.0, 10.0, 5.0, 80.0];
    calibration.gain_slope = [4e-4, -2e-4, 0.0, 1e-4, 3e-4, -1e-4];
    calibration.temperatures = [0.0, 80.0];
    assert_eq!(calibration.check(), Ok(()));
    let load = [420.0, 30.0, 20.0, 0.3, 0.2];
    let warm = |celsius: f32, load: [f32; 5]| -> [i32; 6] {
        let (cold, zero) = (counts(load), counts([0.0; 5]));
        let dt = celsius - 25.0;
        std::array::from_fn(|k| {
            let signal = (cold[k] - zero[k]) as f32 * (1.0 + calibration.gain_slope[k] * dt);
            zero[k] + (signal + calibration.zero_slope[k] * dt).round() as i32
        })
    };
    let converter = Converter {
        next: Ok(Some(warm(35.0, [0.0; 5]))),
        noise: 0,
    };
    let mut bridge = StrainBridge::new(converter, calibration, 20);
    // Tared warm, used hot.
    bridge.set_temperature(35.0);
    bridge.set_turning(false);
    bridge.take_tare(3).unwrap();
    for _ in 0..3 {
        bridge.sample(0).unwrap();
    }
    bridge.set_temperature(70.0);
    bridge.adc().next = Ok(Some(warm(70.0, load)));
    let sample = bridge.sample(0).unwrap().unwrap();
    assert!(sample.doubts.is_empty());
    for (got, truth) in sample.load.iter().zip(load) {
        assert!((got - truth).abs() < 0.02, "{:?}", sample.load);
    }
    for celsius in [-1.0, 81.0, f32::NAN] {
        bridge.set_temperature(celsius);
        let sample = bridge.sample(0).unwrap().unwrap();
        assert!(sample.doubts.contains(Mark::Temperature), "{celsius}");
    }
}

#[test]
fn a_tare_is_refused_while_the_shaft_turns_or_samples_are_doubted() {
    let mut bridge = bridge();
    // Nobody has said that it stands.
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
    type Spoil = fn(&mut StrainBridge<Converter, 6>);
    let cases: [(Spoil, Mark, u32); 4] = [
        // A test's converter always has noise: this one cancels it.
        (|b| b.adc().noise = 99, Mark::Stuck, 20),
        (
            |b| b.adc().next = Ok(Some([0x80_0010; 6])),
            Mark::Saturated,
            1,
        ),
        (|b| b.adc().next = Err(AdcError::Reset), Mark::Bus, 1),
        (
            |b| {
                let mut calibration = CALIBRATION;
                calibration.loads[0][0] = f32::NAN;
                assert_eq!(calibration.check(), Err(CalibrationError::NotFinite));
                let tare = b.tare().unwrap();
                let converter = Converter {
                    next: Ok(Some(counts(IDLE))),
                    noise: 0,
                };
                *b = StrainBridge::new(converter, calibration, 20);
                b.set_tare(tare);
            },
            Mark::NotFinite,
            1,
        ),
    ];
    for (spoil, mark, within) in cases {
        let mut rig = Rig::new(&SETTINGS);
        let mut bridge = tared();
        let run = |rig: &mut Rig, bridge: &mut StrainBridge<Converter, 6>, freeze: bool| {
            if freeze {
                bridge.adc().noise = 0;
            }
            let loads = bridge.sample(rig.time_us);
            rig.tick(&Readings {
                loads,
                speed: Some(Some(0.0)),
                temperatures: None,
            })
        };
        bridge.adc().next = Ok(Some(counts(IDLE)));
        for _ in 0..50 {
            let outcome = run(&mut rig, &mut bridge, false);
            assert!(outcome.marks.is_empty(), "{}", outcome.marks);
        }
        let freeze = mark == Mark::Stuck;
        spoil(&mut bridge);
        let mut first = None;
        for i in 1..=200 {
            let outcome = run(&mut rig, &mut bridge, freeze);
            if outcome.marks.contains(mark) {
                first = first.or(Some(i));
                assert!(!outcome.solved);
            }
        }
        assert!(first.unwrap() <= within, "{mark}: {first:?}");
        assert_eq!(rig.state(Alarm::Sensor), AlarmState::Raised, "{mark}");
        rig.no_alarm_is_lost();
    }
}

#[test]
fn a_calibration_that_cannot_be_is_refused() {
    let mut twice = RESPONSE;
    for row in &mut twice {
        row[4] = 3.0 * row[0];
    }
    assert_eq!(
        Calibration::from_counts(twice),
        Err(CalibrationError::Singular)
    );
    let mut broken = RESPONSE;
    broken[2][3] = f64::NAN;
    assert_eq!(
        Calibration::from_counts(broken),
        Err(CalibrationError::NotFinite)
    );
    let mut cold = CALIBRATION;
    cold.temperature = 200.0;
    assert_eq!(cold.check(), Err(CalibrationError::Temperature));
}

// --- the converter's driver over a mocked bus -----------------------------------------------------

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

type Bus = SpiMock<u8>;

/// The mocked bus, which fails at these of its conversions.
struct Wire {
    bus: Bus,
    transactions: usize,
    fails: fn(usize) -> bool,
}

impl spi::ErrorType for Wire {
    type Error = ErrorKind;
}

impl SpiDevice for Wire {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let conversion = self
            .transactions
            .checked_sub(set_up([0xff, 0x0a]).len() / 3);
        self.transactions += 1;
        if conversion.is_some_and(self.fails) {
            return Err(ErrorKind::ModeFault);
        }
        self.bus.transaction(operations)
    }
}

fn exchange(operation: Transaction<u8>) -> [Transaction<u8>; 3] {
    [
        Transaction::transaction_start(),
        operation,
        Transaction::transaction_end(),
    ]
}

/// What the bus sees when the converter is set up, its clock register read back as `clock`.
fn set_up(clock: [u8; 2]) -> Vec<Transaction<u8>> {
    let command = |bytes: [u8; 2]| {
        let mut frame = vec![0; 20];
        frame[..2].copy_from_slice(&bytes);
        exchange(Transaction::transfer_in_place(frame, vec![0; 20]))
    };
    let write = |address: u8, value: [u8; 2]| {
        let bytes = vec![
            0x60 | (address >> 1),
            address << 7,
            0,
            value[0],
            value[1],
            0,
        ];
        exchange(Transaction::write_vec(bytes))
    };
    let read = |address: u8, value: [u8; 2]| {
        let mut both = exchange(Transaction::write_vec(vec![
            0xa0 | (address >> 1),
            address << 7,
            0,
        ]))
        .to_vec();
        both.extend(exchange(Transaction::read_vec(vec![value[0], value[1], 0])));
        both
    };
    let mut all = Vec::new();
    // Unlock, and a frame of nothing; wake up.
    all.extend(command([0x06, 0x55]));
    all.extend(command([0, 0]));
    all.extend(command([0x00, 0x33]));
    all.extend(read(0, [0x28, 0]));
    // Clock: all channels, ratio 512, high resolution. Gains of 32. Mode: words of 24 bits.
    all.extend(write(3, [0xff, 0x0a]));
    all.extend(write(4, [0x55, 0x55]));
    all.extend(write(5, [0x55, 0x55]));
    all.extend(write(2, [0x01, 0x00]));
    all.extend(read(3, clock));
    if clock == [0xff, 0x0a] {
        all.extend(read(4, [0x55, 0x55]));
        all.extend(read(5, [0x55, 0x55]));
    }
    all
}

/// CRC-16/CCITT-FALSE by itself.
fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xffff, |crc, byte| {
        (0..8).fold(crc ^ (u16::from(*byte) << 8), |crc, _| {
            (crc << 1) ^ if crc & 0x8000 == 0 { 0 } else { 0x1021 }
        })
    })
}

fn conversion(status: u16, channels: [i32; 8], damage: u8) -> Transaction<u8> {
    let mut frame = status.to_be_bytes().to_vec();
    frame.push(0);
    for count in channels {
        frame.extend(&count.to_be_bytes()[1..]);
    }
    frame.extend(crc(&frame).to_be_bytes());
    frame.push(0);
    frame[10] ^= damage;
    Transaction::transfer_in_place(vec![0; 30], frame)
}

fn config() -> Ads131m08Config {
    Ads131m08Config {
        gain: [spindle_bearing::monitor::loads::Gain::Gain32; 8],
        ..Ads131m08Config::default()
    }
}

fn device(
    bus: &Bus,
    ready: bool,
    fails: fn(usize) -> bool,
) -> Ads131m08<Wire, Pin, Pin, Pin, NoDelay> {
    let pin = |low| Pin { low };
    let wire = Wire {
        bus: bus.clone(),
        transactions: 0,
        fails,
    };
    Ads131m08::new(wire, pin(ready), pin(false), pin(false), NoDelay)
}

#[test]
fn the_converters_faults_come_out_by_name() {
    let channels = [1, -1, 8_388_607, -8_388_608, 70_000, -70_000, 5, 6];
    let mut expected = set_up([0xff, 0x0a]);
    for operation in [
        conversion(0x01ff, channels, 0),
        conversion(0x01ff, channels, 0x04),
        conversion(0x05ff, channels, 0),
        conversion(0x41ff, channels, 0),
        conversion(0x01ff, channels, 0),
    ] {
        expected.extend(exchange(operation));
    }
    let mut bus = Bus::new(&expected);
    let mut bridges =
        Ads131m08Bridges::<_, 6>::start(device(&bus, true, |i| i == 4), &config()).unwrap();
    let good = Ok(Some([1, -1, 8_388_607, -8_388_608, 70_000, -70_000]));
    let readings: Vec<_> = (0..6).map(|_| bridges.read()).collect();
    let errors = [
        AdcError::Checksum,
        AdcError::Reset,
        AdcError::Bus,
        AdcError::Bus,
    ];
    assert_eq!(readings[0], good);
    for (reading, error) in readings[1..5].iter().zip(errors) {
        assert_eq!(*reading, Err(error));
    }
    assert_eq!(readings[5], good);
    bus.done();
}

#[test]
fn a_converter_that_does_not_keep_its_settings_is_not_used() {
    let mut bus = Bus::new(&set_up([0x00, 0x00]));
    let started = Ads131m08Bridges::<_, 6>::start(device(&bus, true, |_| false), &config());
    assert_eq!(started.err(), Some(AdcError::Settings));
    bus.done();
}

#[test]
fn bus_errors_do_not_stop_the_ticks_and_a_conversion_that_is_not_ready_is_no_error() {
    let mut expected = set_up([0xff, 0x0a]);
    for i in 0..100 {
        let [a, b, c, d, e, f] = counts(IDLE);
        let operation = conversion(
            0x01ff,
            [
                a + i % 2,
                b - i % 2,
                c + i % 2,
                d - i % 2,
                e + i % 2,
                f - i % 2,
                0,
                0,
            ],
            0,
        );
        if i % 4 != 3 {
            expected.extend(exchange(operation));
        }
    }
    let mut bus = Bus::new(&expected);
    let bridges =
        Ads131m08Bridges::<_, 6>::start(device(&bus, true, |i| i % 4 == 3), &config()).unwrap();
    let mut source = StrainBridge::new(bridges, CALIBRATION, 20);
    source.set_tare(ZERO.map(|count| count as f32));
    let mut rig = Rig::new(&SETTINGS);
    for i in 0..100 {
        let loads = source.sample(rig.time_us);
        let outcome = rig.tick(&Readings {
            loads,
            speed: Some(Some(0.0)),
            temperatures: None,
        });
        assert_eq!(outcome.marks.contains(Mark::Bus), i % 4 == 3);
        assert_eq!(outcome.solved, i % 4 != 3);
    }
    assert_eq!(source.errors(), (25, Some(AdcError::Bus)));
    bus.done();

    let mut bus = Bus::new(&set_up([0xff, 0x0a]));
    let mut idle =
        Ads131m08Bridges::<_, 6>::start(device(&bus, false, |_| false), &config()).unwrap();
    assert_eq!(idle.read(), Ok(None));
    bus.done();
}

#[test]
fn a_speed_signal_lost_at_full_speed_stops_estimates_and_life_goes_on_in_doubt() {
    const TACHOMETER: SpeedSettings = SpeedSettings {
        pulses_per_revolution: 4,
        timer_hz: 1_000_000,
        timer_bits: 32,
        counter_bits: 16,
        count_above: 400.0,
        period_below: 300.0,
        gate_us: 5000,
        standstill_us: 500_000,
        deceleration: 1000.0,
    };
    let mut rig = Rig::new(&SETTINGS);
    rig.run_up();
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
        let loads = Ok(Some(rig.sample(IDLE)));
        let outcome = rig.tick(&Readings {
            loads,
            speed: Some(speed.ok().map(|speed| speed.omega)),
            temperatures: None,
        });
        if (10..1000).contains(&ms) {
            assert!(outcome.solved, "{ms}: {}", outcome.marks);
        }
        if ms > 1000 {
            estimates_after += u32::from(outcome.solved);
        }
    }
    // Until the pulse is overdue, the speed is a bound that falls, and that faster than a shaft can.
    assert!(estimates_after <= 2, "{estimates_after}");
    assert_eq!(rig.state(Alarm::Sensor), AlarmState::Raised);
    let life = rig.monitor.life();
    let doubtful = life.doubtful_revolutions();
    assert!((4.0 * f64::from(SPEED) / std::f64::consts::TAU - doubtful as f64).abs() < 5.0);
    rig.no_alarm_is_lost();
}

// --- the boards' bus ------------------------------------------------------------------------------

#[path = "../../../examples/firmware/board/bus.rs"]
mod bus;

#[test]
fn a_bus_exchanges_byte_for_byte_and_one_that_is_dead_is_an_error() {
    use embedded_hal::spi::{ErrorKind, Operation, SpiDevice};
    let mut sent = Vec::new();
    let exchange = |byte: u8| {
        sent.push(byte);
        Some(!byte)
    };
    let delay = embedded_hal_mock::eh1::delay::NoopDelay::new();
    let mut bus = bus::Bus::new(exchange, delay);
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
    let mut bus = bus::Bus::new(dying, embedded_hal_mock::eh1::delay::NoopDelay::new());
    assert_eq!(bus.transfer_in_place(&mut [1, 2]), Ok(()));
    assert_eq!(bus.transfer_in_place(&mut [3, 4]), Err(ErrorKind::Other));
}

// --- a day --------------------------------------------------------------------------------------

/// Solved once a second; telemetry a little every minute.
static DAY: MonitorSettings = {
    let mut settings = settings(60, 1000);
    settings.tick.cold_iterations = 100;
    settings.telemetry.estimate_us = 10_000_000;
    settings.telemetry.balls_us = 60_000_000;
    settings.telemetry.health_us = 60_000_000;
    // A day of synthetic cutting is no reason for an alarm.
    settings.judgement.thresholds[Alarm::StaleEstimate as usize].raise = 10.0;
    settings.judgement.thresholds[Alarm::StaleEstimate as usize].clear = 5.0;
    settings
};

/// 86.4 million ticks of the recorded milling cycle, over and over: 24 hours at 1 kHz. Both timers start
/// just before they wrap; the one of microseconds does so twenty times.
#[test]
fn a_day_passes_without_drift_or_overflow() {
    const TICKS: u64 = 86_400_000;
    // A sample every 10 ms, and 20 s in all.
    let rows: Vec<LoadSample> = milling_cycle()
        .iter()
        .step_by(10)
        .take(2000)
        .map(|row| LoadSample {
            time_us: 0,
            load: row.load.map(|x| x as f32),
            speed: Some((row.speed_rpm * std::f64::consts::PI / 30.0) as f32),
            residual: 0.0,
            doubts: Marks::NONE,
        })
        .collect();
    let per_cycle: f64 = rows
        .iter()
        .map(|row| f64::from(row.speed.unwrap()))
        .sum::<f64>()
        * 0.01
        / std::f64::consts::TAU;

    let mut monitor: Monitor<1, 16> = Monitor::new(Spindle::single(&BEARING), &DAY);
    monitor.outbox().number_from(u32::MAX - 100);
    let (mut counter, mut dog) = (Counter::default(), Dog::default());
    let mut reader = FrameReader::new();
    let start = u32::MAX - 7_000_000;
    let mut clock = Widened::new(32, start);
    let (mut frames, mut sequence, mut last_us) = (0_u64, u32::MAX - 101, 0);
    let (mut used, mut seen): (Vec<f32>, Vec<[f32; 5]>) = (Vec::new(), Vec::new());
    let mut readings = Readings {
        loads: Ok(None),
        speed: None,
        temperatures: None,
    };
    for i in 0..TICKS {
        let time_us = clock.at(start.wrapping_add((i as u32).wrapping_mul(1000)));
        readings.loads = Ok((i % 10 == 0).then(|| rows[(i / 10 % 2000) as usize]));
        let outcome = monitor.tick(time_us, &readings, &mut counter, &mut dog);
        if i >= 1000 {
            assert!(outcome.marks.is_empty(), "{i}: {}", outcome.marks);
        }
        while let Some(byte) = monitor.outbox().next_byte() {
            let Some(frame) = reader.push(byte) else {
                continue;
            };
            let frame = frame.unwrap();
            frames += 1;
            sequence = sequence.wrapping_add(1);
            assert_eq!(frame.sequence, sequence);
            if matches!(frame.payload, Payload::Balls(_)) {
                // A picture is sent by four balls a tick.
                assert!((i - 3..=i).contains(&(frame.time_us / 1000)));
            } else {
                assert!(frame.time_us >= last_us && frame.time_us == i * 1000);
                last_us = frame.time_us;
            }
            // The same second of the cycle, once an hour.
            if let Payload::Estimate(report) = frame.payload
                && i % 3_600_000 / 10_000 == 5
            {
                seen.push(report.stiffness);
                used.push(monitor.life().used());
            }
        }
    }
    let health = monitor.health();
    assert_eq!((health.ticks, dog.fed), (TICKS, TICKS));
    assert_eq!(
        (health.overruns, health.missed_ticks, health.frames_dropped),
        (0, 0, 0)
    );
    assert_eq!((health.estimates, health.refusals), (86_400, 0));
    // Estimates and their rows every ten seconds; a picture of four frames, two reports, the start and the shaft every
    // minute; the board's report every tenth.
    let reports = 8 * 1440 + 144;
    assert!((17_278..=17_282).contains(&(frames - reports)), "{frames}");
    // No drift: the same cycle gives the same stiffness, and takes the same part of the life.
    assert_eq!(seen.len(), 24);
    for k in &seen {
        for (k, first) in k.iter().zip(&seen[0]) {
            assert!((k / first - 1.0).abs() < 1e-5, "{seen:?}");
        }
    }
    let hour = used[1] - used[0];
    for pair in used.windows(2) {
        assert!(((pair[1] - pair[0]) / hour - 1.0).abs() < 2e-3, "{used:?}");
    }
    let revolutions = per_cycle * 4320.0;
    assert!(
        (health.revolutions as f64 / revolutions - 1.0).abs() < 1e-5,
        "{revolutions}"
    );
}

/// Memory is what the type has: there is no other.
#[test]
fn a_monitor_is_of_a_fixed_size() {
    const SIZE: [usize; 2] = [size_of::<Monitor<1, 16>>(), size_of::<Monitor<2, 16>>()];
    let [one, pair] = SIZE;
    assert!((8_000..17_408).contains(&one), "{one}");
    assert!((one..28_672).contains(&pair), "{pair}");
}
