//! A monitor on simulated sensors, and a host at the end of its link.
//!
//! Three laws hold in every test with a [`Rig`]. No fault stops the ticks, none yields a stiffness without a mark, and no
//! alarm is lost.

use spindle_bearing::{Arrangement, Bearing, Design, Facing, Mounted, Spindle};
use spindle_monitor::command::Answer;
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::LoadSample;
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::telemetry::{BallReport, EstimateReport, FrameReader, Payload, RowReport};
use spindle_monitor::tick::{CycleCounter, Watchdog};
use spindle_monitor::{Alarm, AlarmState, BoardReport, Mark, Marks, Monitor, Outcome, Readings};

/// A spindle bearing, of steel throughout.
pub const B7005C: Design = Design {
    inner_shoulder_angle: 48_f64.to_radians(),
    outer_shoulder_angle: 47.5_f64.to_radians(),
    ..Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians())
};

/// The bearing of that design.
pub static BEARING: Bearing<f32, 16> = Bearing::<f32, 16>::const_new(&B7005C);

/// Ten passes over the row fit into a tick.
pub static SETTINGS: MonitorSettings = settings(10);
/// Settings for one bearing with so many passes over the row in a tick. Wide ranges: beyond them loads are no loads.
pub const fn settings(passes: u32) -> MonitorSettings {
    let mut settings = MonitorSettings::new(&B7005C, 16);
    settings.tolerance = 2e-5;
    settings.plausibility.load = [
        [-10e3, 10e3],
        [-10e3, 10e3],
        [-10e3, 10e3],
        [-200.0, 200.0],
        [-200.0, 200.0],
    ];
    settings.plausibility.load_rate = [1e6, 1e6, 1e6, 2e4, 2e4];
    settings.overload = [10e3, 10e3, 10e3, 200.0, 200.0];
    let cost = settings.tick.cost;
    let cost_of = cost.of(1, 16, 16);
    settings.tick.deadline_cycles = cost.tick
        + cost_of.open
        + cost_of.look
        + cost_of.report
        + (passes + 1) * (cost_of.step + cost_of.row);
    settings
}

/// Shipped settings of a single bearing: loads of its own, five passes in a tick.
pub static ON_BEARING: MonitorSettings = {
    let mut settings = settings(5);
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

/// One bearing.
pub static SINGLE: Spindle<f32, 1, 16> = Spindle::<f32, 1, 16>::const_new(
    Arrangement::ByRows,
    [Mounted::new(&BEARING, 0.0, Facing::PlusX)],
);

/// Loads of the idling spindle on its bearing, N and N m.
pub const IDLE: [f32; 5] = [420.0, 5.0, -8.0, 0.05, -0.1];
/// The tests' speed, rad/s.
pub const SPEED: f32 = 1500.0;

/// Readings of the sensors for the load, at the tests' speed.
pub fn at_speed(loads: Result<Option<LoadSample>, Marks>) -> Readings {
    Readings {
        loads,
        speed: Some(Some(SPEED)),
        temperatures: None,
    }
}

/// Cycles as a test says.
#[derive(Debug, Default)]
pub struct Counter {
    now: u32,
    /// Cycles of a tick.
    pub cost: u32,
    /// Cycles of each look.
    pub look: u32,
    /// Looks in this tick.
    reads: u32,
}

impl CycleCounter for Counter {
    fn cycles(&mut self) -> u32 {
        self.reads += 1;
        self.now = self.now.wrapping_add(self.look);
        if self.reads == 2 {
            self.now = self.now.wrapping_add(self.cost);
        }
        self.now
    }
}

/// A watchdog that counts.
#[derive(Debug, Default)]
pub struct Dog {
    /// How often it was fed.
    pub fed: u64,
}

impl Watchdog for Dog {
    fn feed(&mut self) {
        self.fed += 1;
    }
}

/// Frames that a host has received.
#[derive(Debug, Default)]
pub struct Host {
    reader: FrameReader,
    /// Counts in the last report of each alarm.
    counts: [(u32, u32); Alarm::COUNT],
    /// Estimates with their times, us.
    pub estimates: Vec<(u64, EstimateReport)>,
    /// The last report of every ball.
    pub balls: Vec<BallReport>,
    /// The last report of every row.
    pub rows: Vec<RowReport>,
    /// Answers to orders.
    pub answers: Vec<Answer>,
    /// The board's last report on itself.
    pub board: BoardReport,
}

/// A monitor, and a host at the end of its link that knows what must arrive.
#[derive(Debug)]
pub struct Rig<const R: usize = 1, const E: usize = 0> {
    /// The monitor.
    pub monitor: Monitor<R, 16, 12, 5, E>,
    /// Loads of the idling spindle.
    pub idle: [f32; 5],
    /// Its counter of cycles.
    pub counter: Counter,
    dog: Dog,
    /// Time of the next tick, us.
    pub time_us: u64,
    ticks: u64,
    /// Rows passed for the next estimate.
    rows: u16,
    /// Bytes that the link takes in a tick.
    pub link: usize,
    /// Marks of every tick, by its time in ms.
    pub marks: Vec<Marks>,
    /// Marks of every tick, one after the other.
    doubts: Vec<Marks>,
    /// Changes of alarms.
    pub happened: Vec<(Alarm, AlarmChange)>,
    /// The host.
    pub host: Host,
    jitter: f32,
}

impl Rig {
    /// A single bearing, idling.
    pub fn new(settings: &'static MonitorSettings) -> Self {
        Self::of(&SINGLE, settings, IDLE)
    }

    /// At the tests' speed.
    pub fn running(settings: &'static MonitorSettings) -> Self {
        Self::new(settings).run_up()
    }
}

impl<const R: usize, const E: usize> Rig<R, E> {
    /// A spindle with these settings and these loads when it idles.
    ///
    /// # Panics
    ///
    /// If the preload has no equilibrium.
    pub fn of(
        spindle: &'static Spindle<'static, f32, R, 16, 5, E>,
        settings: &'static MonitorSettings<R>,
        idle: [f32; 5],
    ) -> Self {
        let mut monitor = Monitor::new(spindle, settings);
        monitor.prepare([idle[0], 0.0, 0.0, 0.0, 0.0]).unwrap();
        Self {
            monitor,
            idle,
            counter: Counter::default(),
            dog: Dog::default(),
            time_us: 0,
            ticks: 0,
            rows: 0,
            link: 4096,
            marks: Vec::new(),
            doubts: Vec::new(),
            happened: Vec::new(),
            host: Host::default(),
            jitter: 0.0,
        }
    }

    /// One tick.
    ///
    /// # Panics
    ///
    /// If a law is broken.
    pub fn tick(&mut self, readings: &Readings) -> Outcome {
        self.counter.reads = 0;
        let outcome = self
            .monitor
            .tick(self.time_us, readings, &mut self.counter, &mut self.dog);
        self.ticks += 1;
        // No fault stops the ticks.
        assert_eq!(
            (self.monitor.health().ticks, self.dog.fed),
            (self.ticks, self.ticks)
        );
        self.rows += outcome.rows;
        assert!(!outcome.solved || self.rows > 0, "{outcome:?}");
        // An estimate is of a sample that was good when it came, in that many ticks before.
        self.doubts.push(outcome.marks);
        if outcome.solved {
            self.rows = outcome.rows;
            let age = outcome.age.unwrap() as usize;
            let of_sample = self.doubts[self.doubts.len() - 1 - age];
            let of_solve = Mark::Unsolved | Mark::NoEstimate;
            assert!(of_sample.is_subset(of_solve), "{age}: {of_sample}");
        }
        self.marks.push(outcome.marks);
        let changes = outcome.changes.iter();
        self.happened.extend(changes.map(|c| (c.alarm, c.change)));
        self.receive(self.link);
        self.time_us += 1000;
        outcome
    }

    fn receive(&mut self, bytes: usize) {
        let host = &mut self.host;
        for _ in 0..bytes {
            let Some(byte) = self.monitor.outbox().next_byte() else {
                break;
            };
            let Some(frame) = host.reader.push(byte) else {
                continue;
            };
            let frame = frame.unwrap();
            match frame.payload {
                Payload::Estimate(report) => {
                    // No stiffness without the marks of its tick.
                    let tick = (frame.time_us / 1000) as usize;
                    assert_eq!(report.marks, self.marks[tick]);
                    assert!(report.stiffness.iter().all(|k| k.is_finite() && *k > 0.0));
                    host.estimates.push((frame.time_us, report));
                }
                Payload::Alarm(report) => {
                    host.counts[report.alarm as usize] = (report.raised, report.cleared);
                }
                Payload::Balls(report) => {
                    host.balls.truncate(report.first.into());
                    host.balls.extend(report.balls);
                }
                Payload::Rows(report) => {
                    host.rows.truncate(report.first.into());
                    host.rows.extend(report.rows);
                }
                Payload::Answer(answer) => host.answers.push(answer),
                Payload::Hello(hello) => host.board = hello.board,
                Payload::Health(_) | Payload::Probes(_) => {}
            }
        }
    }

    /// Looks whether every alarm is known at the other end of the link, by its own frame or by the counts of a later one.
    ///
    /// # Panics
    ///
    /// If one is not.
    pub fn no_alarm_is_lost(&mut self) {
        self.receive(usize::MAX);
        assert!(self.monitor.outbox().is_empty());
        for alarm in Alarm::ALL {
            let count = |change| {
                let same = |c: &&(Alarm, AlarmChange)| **c == (alarm, change);
                self.happened.iter().filter(same).count() as u32
            };
            let happened = (count(AlarmChange::Raised), count(AlarmChange::Cleared));
            assert_eq!(self.host.counts[alarm as usize], happened, "{alarm}");
        }
    }

    /// A load that is never twice the same.
    pub fn sample(&mut self, load: [f32; 5]) -> LoadSample {
        self.jitter = (self.jitter + 0.618_034) % 1.0;
        LoadSample {
            time_us: self.time_us,
            load: load.map(|x| x * (1.0 + 1e-3 * self.jitter) + 1e-3 * self.jitter),
            speed: None,
            residual: 0.0,
            doubts: Marks::new(),
        }
    }

    /// A sample of the idling spindle with a change.
    pub fn spoilt(&mut self, spoil: impl FnOnce(&mut LoadSample)) -> Readings {
        let mut sample = self.sample(self.idle);
        spoil(&mut sample);
        at_speed(Ok(Some(sample)))
    }

    /// Readings of the idling spindle at this speed, rad/s.
    pub fn idling_at(&mut self, speed: Option<f32>) -> Readings {
        Readings {
            speed: Some(speed),
            ..self.spoilt(|_| {})
        }
    }

    /// A tick with this load at this speed.
    pub fn good(&mut self, load: [f32; 5], speed: f32) -> Outcome {
        let sample = self.sample(load);
        self.tick(&Readings {
            speed: Some(Some(speed)),
            ..at_speed(Ok(Some(sample)))
        })
    }

    /// So many ticks with this load at the tests' speed.
    pub fn run(&mut self, ticks: u32, load: [f32; 5]) {
        for _ in 0..ticks {
            self.good(load, SPEED);
        }
    }

    /// So many ticks do not begin.
    pub fn leave_out(&mut self, ticks: usize) {
        let marks = self.marks.last().copied().unwrap_or_default();
        self.marks.resize(self.marks.len() + ticks, marks);
        self.time_us += 1000 * ticks as u64;
    }

    /// Brings the spindle to its speed, as fast as it can.
    ///
    /// # Panics
    ///
    /// If a sample of it is doubted.
    #[must_use]
    pub fn run_up(mut self) -> Self {
        for ms in 0..1000 {
            self.good(self.idle, SPEED * ms as f32 / 1000.0);
        }
        let outcome = self.good(self.idle, SPEED);
        assert!(outcome.marks.is_empty(), "{outcome:?}");
        self
    }

    /// State of an alarm.
    pub fn state(&mut self, alarm: Alarm) -> AlarmState {
        self.monitor.judgement().alarm(alarm).state()
    }

    /// Stiffness of the last report.
    ///
    /// # Panics
    ///
    /// If there was none.
    pub fn stiffness(&self) -> [f32; 5] {
        self.host.estimates.last().unwrap().1.stiffness
    }
}

impl<const R: usize, const E: usize> Drop for Rig<R, E> {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.no_alarm_is_lost();
        }
    }
}
