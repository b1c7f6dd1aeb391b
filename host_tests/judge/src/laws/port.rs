//! Any bytes at the port of a board, with ticks in between.
//!
//! No panic, every figure of the telemetry a number, a mark wherever there is no good record, counters that agree, no answer that
//! nobody has asked for, no estimate of a load that nobody has sent, or that was doubted, or without the marks of its tick, no alarm
//! lost; and what is sound again is solved again.

use crate::laws::common::{Ends, number, run_of, signed};
use arbitrary::{Arbitrary, Result, Unstructured};
use cli::random::Random;
use mock::rig::Dog;
use spindle_bearing::Status;
use spindle_firmware::chain::{self, Chain, SpindleMonitor};
use spindle_firmware::spindle::{IDLE, ROWS, monitor_settings};
use spindle_monitor::command::{
    self, Command, MOST_PROBES, ORDER_EVERY, Order, PortReader, Received, Request,
};
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::record::{self, FRAME_LENGTH, LoadRecord};
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::telemetry::{EstimateReport, FrameReader, HealthReport, Payload};
use spindle_monitor::tick::{Core, CycleCounter};
use spindle_monitor::{Alarm, Mark, Marks, Outcome, Past};
use std::collections::HashSet;

/// Steps of one run.
const MOST_STEPS: usize = 32;
/// Ticks of one step, mostly, and now and then: enough for every alarm.
const TICKS: [u16; 2] = [20, 1000];
/// Records that are damaged together.
const TOGETHER: u16 = 6;
/// Ticks in which a sender that starts is believed.
const START: u32 = 100;
/// Age of an estimate of loads that hardly change, at most.
const OLDEST: u32 = 2;

static MONITOR: MonitorSettings<ROWS> = monitor_settings(&Core::STM32F405);

/// Bytes that come in, and ticks.
#[derive(Debug)]
pub struct Run {
    /// Cycles between two looks at the counter.
    pace: u32,
    steps: Vec<Step>,
}

#[derive(Debug)]
enum Step {
    /// Bytes as they are.
    Bytes(Vec<u8>),
    /// A record of its own, with some bytes changed.
    Record(LoadRecord, Vec<(u8, u8)>),
    /// A command, while the input for service is on or off.
    Command(Command, bool),
    /// So many ticks, so many us apart, with a link that takes so many bytes in each. With a load, each has a record in order, or
    /// what damage of that seed leaves of some.
    Ticks {
        count: u16,
        apart: u32,
        room: u16,
        load: Option<[f32; 5]>,
        damage: Option<u64>,
        speed_rpm: f32,
    },
}

impl Arbitrary<'_> for Run {
    fn arbitrary(u: &mut Unstructured) -> Result<Self> {
        let pace = match u.arbitrary()? {
            0..=127_u8 => 0,
            128..=223 => u.int_in_range(0..=4000)?,
            224.. => u.arbitrary()?,
        };
        let mut steps = Vec::new();
        while steps.len() < MOST_STEPS && !u.is_empty() {
            steps.push(step(u)?);
        }
        Ok(Self { pace, steps })
    }
}

fn load(u: &mut Unstructured) -> Result<[f32; 5]> {
    let mut load = [0.0; 5];
    for (load, most) in load.iter_mut().zip([3e3, 3e3, 3e3, 100.0, 100.0]) {
        *load = signed(u, 1e-3, most)? as f32;
    }
    Ok(load)
}

fn step(u: &mut Unstructured) -> Result<Step> {
    Ok(match u.int_in_range(0..=7)? {
        0 => {
            let length = u.int_in_range(0..=64)?;
            let length = u.len().min(length);
            Step::Bytes(u.bytes(length)?.to_vec())
        }
        1 | 2 => {
            let [fx, fy, fz, my, mz] = load(u)?;
            let record = LoadRecord {
                sequence: u.arbitrary()?,
                time_ms: u.arbitrary()?,
                fx,
                fy,
                fz,
                my,
                mz,
                speed_rpm: signed(u, 1.0, 1e5)? as f32,
            };
            let damage = u.int_in_range(0..=2)?;
            Step::Record(record, vec![u.arbitrary()?; damage])
        }
        3 => {
            let order = match u.int_in_range(0..=4)? {
                0 => Order::ReplaceBearing,
                1 => Order::ShaftStands,
                2 => Order::Commission,
                _ => Order::Acknowledge {
                    alarm: *u.choose(&Alarm::ALL)?,
                    start: 0,
                    raised: u.int_in_range(0..=3)?,
                },
            };
            let command = match u.int_in_range(0..=4)? {
                0 => Command::Tick(u.arbitrary()?),
                2 => Command::Probes(u.arbitrary::<[u32; MOST_PROBES]>()?.map(f32::from_bits)),
                1 => {
                    let mut side = || Ok(number(u, -50.0, 150.0)? as f32);
                    Command::Temperatures([side()?, side()?])
                }
                _ => Command::Ask(Request {
                    number: u.arbitrary()?,
                    order,
                }),
            };
            Step::Command(command, u.arbitrary()?)
        }
        _ => {
            let count = match u.arbitrary()? {
                0..=247_u8 => u.int_in_range(1..=TICKS[0])?,
                248.. => u.int_in_range(1..=TICKS[1])?,
            };
            let apart = match u.arbitrary()? {
                0..=223_u8 => MONITOR.tick.period_us,
                224..=239 => u.int_in_range(0..=100_000)?,
                240.. => u.arbitrary()?,
            };
            let room = match u.arbitrary()? {
                0..=127_u8 => 92,
                128.. => u.arbitrary()?,
            };
            // Bits of one byte: whether records come, and whether they are sound.
            let how = u.arbitrary::<u8>()?;
            let damage = (how & 0x41 == 1).then(|| u.arbitrary());
            Step::Ticks {
                count,
                apart,
                room,
                damage: damage.transpose()?,
                load: (how % 2 == 1).then(|| load(u)).transpose()?,
                speed_rpm: signed(u, 1.0, 4e4)? as f32,
            }
        }
    })
}

/// Runs a kept input as its target does; the marks, answers, alarms and estimates that there were.
pub fn replay(input: &[u8]) -> Ends {
    check(&run_of(input))
}

/// Runs it; the marks, answers, alarms and estimates that there were. A law that is broken is a panic.
pub fn check(run: &Run) -> Ends {
    let mut bench = Bench::new(run.pace);
    for step in &run.steps {
        match step {
            Step::Bytes(bytes) => {
                bench.is_raw = true;
                bench.push(bytes, false);
                bench.is_raw = false;
            }
            Step::Record(record, damage) => {
                let mut frame = bench.encode(record);
                for (at, byte) in damage {
                    let at = usize::from(*at) % frame.len();
                    frame[at] = *byte;
                }
                bench.push(&frame, false);
            }
            Step::Command(command, service) => bench.push(&command::encode(*command), *service),
            Step::Ticks {
                count,
                apart,
                room,
                load,
                damage,
                speed_rpm,
            } => {
                let (mut line, mut damage) = (Vec::new(), damage.map(Random::seeded));
                for i in 0..*count {
                    bench.time_us = bench.time_us.saturating_add((*apart).into());
                    if let Some(load) = load
                        && (damage.is_none() || i % TOGETHER == 0)
                    {
                        line.extend(bench.records(load, *speed_rpm, damage.as_mut()));
                    }
                    let piece = line.len().min(FRAME_LENGTH);
                    bench.push(&line.drain(..piece).collect::<Vec<_>>(), false);
                    bench.tick(*room);
                }
            }
        }
    }
    bench.end()
}

/// Cycles of a core, so many more at each look.
struct Counter {
    pace: u32,
    cycles: u32,
}

impl CycleCounter for Counter {
    fn cycles(&mut self) -> u32 {
        self.cycles = self.cycles.wrapping_add(self.pace);
        self.cycles
    }
}

/// A board, its host, and what is known of both.
struct Bench {
    chain: Chain<Box<SpindleMonitor>>,
    counter: Counter,
    /// A second reader of the port.
    port: PortReader,
    host: FrameReader,
    time_us: u64,
    ticks: u64,
    /// Records and damaged frames that came, and how many requests.
    received: u64,
    corrupt: u64,
    asked: u64,
    /// The last frame since the last tick that was no command was damaged.
    damaged: bool,
    /// Time of the first tick, or of the last one with a record or a damaged frame.
    heard_us: Option<u64>,
    heard: bool,
    /// There was an estimate.
    estimated: bool,
    /// Loads of the records that were sent, and of those that any bytes have made up.
    loads: HashSet<[u32; 5]>,
    /// Any bytes come.
    is_raw: bool,
    /// Times and marks of all ticks.
    looks: Vec<(u64, Marks)>,
    /// Rows passed for the next estimate.
    rows: u32,
    /// How often each alarm was raised and cleared, and what the host knows of that.
    happened: [[u32; 2]; Alarm::COUNT],
    told: [[u32; 2]; Alarm::COUNT],
    dog: Dog,
    sequence: u32,
    answered: u64,
    /// Number of the record to be sent.
    next: u32,
    ends: Ends,
}

impl Bench {
    fn new(pace: u32) -> Self {
        let probes = Box::leak(Box::new(chain::probes(&MONITOR)));
        let monitor = chain::monitor(probes, &Past::default(), &MONITOR);
        let mut chain = Chain::new(Box::new(monitor));
        chain
            .prepare()
            .expect("the idling spindle has an equilibrium");
        Self {
            chain,
            counter: Counter { pace, cycles: 0 },
            port: PortReader::new(),
            host: FrameReader::new(),
            time_us: 0,
            ticks: 0,
            received: 0,
            corrupt: 0,
            asked: 0,
            damaged: false,
            heard_us: None,
            heard: false,
            estimated: false,
            loads: HashSet::new(),
            is_raw: false,
            looks: Vec::new(),
            rows: 0,
            happened: [[0; 2]; Alarm::COUNT],
            told: [[0; 2]; Alarm::COUNT],
            dog: Dog::default(),
            sequence: 0,
            answered: 0,
            next: 0,
            ends: Ends::new(),
        }
    }

    fn push(&mut self, bytes: &[u8], service: bool) {
        for byte in bytes {
            let read = self.port.push(*byte);
            let room = self.chain.push(*byte, service);
            match read {
                None => assert_eq!(room, None),
                Some(Ok(Received::Command(Command::Tick(asked)))) => {
                    assert_eq!(room, Some(asked));
                    self.tick(asked);
                }
                Some(Ok(Received::Command(Command::Ask(_)))) => self.asked += 1,
                Some(Ok(Received::Command(Command::Temperatures(_) | Command::Probes(_)))) => {}
                Some(Ok(Received::Record(record))) => {
                    self.received += 1;
                    let load = record.load().map(f32::to_bits);
                    let is_known = !self.loads.insert(load);
                    assert!(is_known || self.is_raw, "damage has made up {record:?}");
                    (self.damaged, self.heard) = (false, true);
                }
                Some(Err(_)) => {
                    self.corrupt += 1;
                    (self.damaged, self.heard) = (true, true);
                }
            }
        }
    }

    fn encode(&mut self, record: &LoadRecord) -> Vec<u8> {
        self.loads.insert(record.load().map(f32::to_bits));
        record::encode(record).to_vec()
    }

    /// The next record in order, or what damage leaves of some, sent a ms after the other, and of orders in between.
    fn records(&mut self, load: &[f32; 5], speed_rpm: f32, damage: Option<&mut Random>) -> Vec<u8> {
        let [fx, fy, fz, my, mz] = *load;
        let mut next = |ahead_ms: u16| {
            self.next = self.next.wrapping_add(1);
            self.encode(&LoadRecord {
                sequence: self.next,
                time_ms: (self.time_us / 1000 + u64::from(ahead_ms)) as u32,
                fx,
                fy,
                fz,
                my,
                mz,
                speed_rpm,
            })
        };
        let Some(random) = damage else {
            return next(0);
        };
        let mut bytes = Vec::new();
        for ahead_ms in 0..TOGETHER {
            bytes.extend(next(ahead_ms));
            if random.chance(0.1) {
                let order = Order::ReplaceBearing;
                let request = Request { number: 1, order };
                bytes.extend(command::encode(Command::Ask(request)));
            }
        }
        random.damage(&mut bytes);
        bytes
    }

    /// A sender that starts twice, of the idling spindle: one of the last records is solved. Numbers of the first start may
    /// be in order by chance, and then its clock is not.
    fn recover(&mut self) {
        self.counter.pace = 0;
        // Time for a shaft to reach any speed.
        self.time_us += 60_000_000;
        for ms in [1..=20, 1..=START].into_iter().flatten() {
            let [fx, fy, fz, my, mz] = IDLE.map(|load| load + 1e-3 * ms as f32);
            self.time_us += u64::from(MONITOR.tick.period_us);
            let frame = self.encode(&LoadRecord {
                sequence: ms,
                time_ms: ms,
                fx,
                fy,
                fz,
                my,
                mz,
                speed_rpm: 3000.0 + 1e-2 * ms as f32,
            });
            self.push(&frame, false);
            let outcome = self.tick(u16::MAX);
            if ms == START {
                let is_new = outcome.age.is_some_and(|age| age <= OLDEST);
                assert!(is_new && outcome.marks.is_empty(), "{outcome:?}");
            }
        }
    }

    fn tick(&mut self, room: u16) -> Outcome {
        let outcome = self
            .chain
            .tick(self.time_us, &mut self.counter, &mut self.dog);
        self.ticks += 1;
        assert_eq!(self.dog.fed, self.ticks);
        self.look(&outcome);
        for _ in 0..room {
            if !self.hear() {
                break;
            }
        }
        outcome
    }

    /// Laws of a tick.
    fn look(&mut self, outcome: &Outcome) {
        let marks = outcome.marks;
        let began = *self.heard_us.get_or_insert(self.time_us);
        if std::mem::take(&mut self.heard) {
            self.heard_us = Some(self.time_us);
        } else {
            let silent = self.time_us.saturating_sub(began);
            let allowed = MONITOR.plausibility.missing_after_us.into();
            assert!(silent <= allowed || marks.contains(Mark::Missing));
        }
        if std::mem::take(&mut self.damaged) {
            assert!(marks.contains(Mark::Corrupt), "{marks}");
        }
        self.looks.push((self.time_us, marks));
        self.rows += u32::from(outcome.rows);
        if outcome.solved {
            self.estimated = true;
            self.ends.insert("estimate");
            assert!(std::mem::replace(&mut self.rows, outcome.rows.into()) > 0);
            // It is of a sample that was good when it came, in that many ticks before.
            let age = outcome.age.expect("an estimate has an age");
            let (_, of_sample) = self.looks[self.looks.len() - 1 - age as usize];
            let of_solve = Mark::Unsolved | Mark::NoEstimate;
            assert!(of_sample.is_subset(of_solve), "{age}: {of_sample}");
        }
        for change in &outcome.changes {
            let [raised, cleared] = &mut self.happened[change.alarm as usize];
            match change.change {
                AlarmChange::Raised => *raised += 1,
                AlarmChange::Cleared => *cleared += 1,
                AlarmChange::Acknowledged | AlarmChange::Standing => {}
            }
        }
        assert_eq!(outcome.age.is_some(), self.estimated);
        assert_eq!(marks.contains(Mark::NoEstimate), !self.estimated);
        assert!(!outcome.solved || self.received > 0);
        assert!(self.estimated || !outcome.outputs.monitored);
        self.ends.extend(marks.iter().map(Mark::name));
        self.ends
            .extend(outcome.changes.iter().map(|change| change.alarm.name()));
        let raised = outcome
            .changes
            .iter()
            .any(|change| change.change == AlarmChange::Raised);
        assert!(!raised || !outcome.outputs.no_alarm);
    }

    /// The host takes a byte, if there is one.
    fn hear(&mut self) -> bool {
        let Some(byte) = self.chain.next_byte() else {
            return false;
        };
        let Some(frame) = self.host.push(byte) else {
            return true;
        };
        let frame = frame.expect("a line without noise damages no frame");
        assert_eq!(frame.sequence, self.sequence);
        self.sequence += 1;
        assert!(frame.time_us <= self.time_us);
        match frame.payload {
            Payload::Estimate(report) => {
                assert!(self.estimated);
                let load = report.load.map(f32::to_bits);
                assert!(self.loads.contains(&load), "no record had {report:?}");
                let of_tick = (frame.time_us, report.marks);
                assert!(self.looks.iter().rev().any(|look| *look == of_tick));
                assert_numbers(&report);
            }
            Payload::Rows(report) => {
                for row in &report.rows {
                    let [y, z] = row.radial;
                    let forces = [row.least_force, row.largest_force];
                    let all = [row.axial, y, z, row.preload].into_iter().chain(forces);
                    assert!(all.into_iter().all(f32::is_finite), "{row:?}");
                    assert!(row.least_force >= 0.0 && row.least_force <= row.largest_force);
                }
            }
            Payload::Balls(report) => {
                for ball in &report.balls {
                    let all = [ball.q_i, ball.q_o, ball.alpha_i, ball.alpha_o];
                    assert!(all.into_iter().all(f32::is_finite), "{ball:?}");
                }
            }
            Payload::Alarm(report) => {
                assert!(
                    !report.value.is_nan() && report.limit.is_finite(),
                    "{report:?}"
                );
                assert!(report.cleared <= report.raised, "{report:?}");
                self.told[report.alarm as usize] = [report.raised, report.cleared];
            }
            Payload::Health(report) => self.count(&report),
            Payload::Answer(answer) => {
                self.answered += 1;
                self.ends.insert(answer.outcome.name());
            }
            Payload::Probes(report) => {
                let gains = report.probes.iter().map(|probe| probe.gain);
                for one in gains.chain(report.preload).chain(report.change) {
                    assert!(one.value.is_finite() && one.error >= 0.0, "{report:?}");
                }
            }
            Payload::Hello(_) => {}
        }
        true
    }

    /// Laws of the counters, as of any time up to now.
    fn count(&self, health: &HealthReport) {
        assert!(health.ticks <= self.ticks);
        let of_ticks = [health.overruns, health.marked_samples];
        assert!(
            of_ticks.into_iter().all(|count| count <= self.ticks),
            "{health:?}"
        );
        assert!(
            health.estimates + health.refusals <= health.ticks + 1,
            "{health:?}"
        );
        assert!(health.alarms_cleared <= health.alarms_raised, "{health:?}");
        assert!(
            health.doubtful_revolutions <= health.revolutions,
            "{health:?}"
        );
        assert!((0.0..=1.0).contains(&health.availability), "{health:?}");
        assert!(
            health.life_used.is_finite() && health.life_used >= 0.0,
            "{health:?}"
        );
        assert!((0.0..=1.0).contains(&health.life_estimated), "{health:?}");
        assert!(
            health.temperatures.into_iter().all(f32::is_finite),
            "{health:?}"
        );
        let records = &health.records;
        assert!(records.received <= self.received && records.corrupt <= self.corrupt);
        let used = records.disordered + records.passed_over + records.late;
        assert!(used <= 2 * records.received, "{records:?}");
    }

    /// Laws of the whole run.
    fn end(mut self) -> Ends {
        // Every request that there was room for is answered, and the link takes all there is.
        for _ in 0..ORDER_EVERY * (Alarm::COUNT as u64 + 1) {
            self.tick(u16::MAX);
        }
        self.recover();
        assert!(!self.hear(), "the link has never an end");
        assert_eq!(self.told, self.happened, "an alarm is lost");
        let health = self.chain.health();
        self.count(&health);
        assert_eq!(health.ticks, self.ticks);
        let counts = self.chain.counts();
        assert_eq!(
            (counts.received, counts.corrupt),
            (self.received, self.corrupt)
        );
        assert!(self.answered <= self.asked);
        assert_eq!(self.answered > 0, self.asked > 0);
        self.ends
    }
}

fn assert_numbers(report: &EstimateReport) {
    let figures = report
        .load
        .iter()
        .chain(&report.displacement)
        .chain(&report.stiffness);
    let single = [
        report.speed,
        report.coupling,
        report.least_force,
        report.largest_force,
    ];
    let mut all = figures.copied().chain(single).chain(report.error);
    assert!(all.all(f32::is_finite), "{report:?}");
    assert!(report.least_force >= 0.0 && report.least_force <= report.largest_force);
    assert!(
        report.error.into_iter().all(|error| error >= 0.0),
        "{report:?}"
    );
    assert!(
        report
            .stiffness
            .into_iter()
            .all(|stiffness| stiffness > 0.0),
        "{report:?}"
    );
    assert!(report.age > 0 || report.marks.is_empty(), "{report:?}");
    assert!(!matches!(report.status, Status::Unloaded) || report.marks.contains(Mark::Unsolved));
}
