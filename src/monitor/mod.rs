//! From sensor to alarm: the work of a spindle's board around the solver.
//!
//! Data flows one way, a file for each step:
//!
//! | step | module | gives |
//! | --- | --- | --- |
//! | acquisition | [`loads`], [`speed`] | five loads and a speed, or why there are none |
//! | plausibility | [`plausibility`], [`temperature`] | a good sample, or the [`marks`] of its doubts |
//! | tick | [`tick`], `tracker`, [`Monitor`] | an equilibrium within the deadline |
//! | judgement | [`judgement`] | alarms that latch |
//! | life | [`life`] | rating life used up |
//! | telemetry | [`telemetry`] | frames for a host |
//! | the board | [`board`], [`self_check`] | why it started, and whether it is sound |
//! | commands | [`command`] | the host's messages besides loads |
//! | retention | [`retained`] | life used and alarms, over a power cycle |
//!
//! Read [`Monitor::tick`] first, then [`settings`], which has all that is particular to a spindle. The
//! whole of a firmware's loop:
//!
//! ```
//! use spindle_bearing::monitor::{
//!     Monitor, Readings,
//!     loads::{FramedLoads, LoadSource},
//!     settings::MonitorSettings,
//!     speed::{Edges, PulseSpeed, SpeedSettings, SpeedSource},
//!     tick::{CycleCounter, Watchdog, Widened},
//! };
//! use spindle_bearing::{Bearing, Design, Spindle};
//!
//! const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
//! static BEARING: Bearing<f32, 16> = match Bearing::<f32, 16>::new(&DESIGN) {
//!     Ok(bearing) => bearing,
//!     Err(_) => panic!("this bearing cannot be built"),
//! };
//! static SETTINGS: MonitorSettings = MonitorSettings::new(&DESIGN, 16);
//! const _: () = assert!(SETTINGS.check().is_ok());
//! const TACHOMETER: SpeedSettings = SpeedSettings {
//!     pulses_per_revolution: 4,
//!     timer_hz: 1_000_000,
//!     timer_bits: 32,
//!     counter_bits: 16,
//!     count_above: 400.0,
//!     period_below: 300.0,
//!     gate_us: 5000,
//!     standstill_us: 500_000,
//!     deceleration: 1000.0,
//! };
//! # struct Board { us: u32 }
//! # impl Board {
//! #     fn wait_for_tick(&mut self) -> u32 { self.us += 1000; self.us }
//! #     fn received(&mut self) -> Option<u8> { None }
//! #     fn send(&mut self, _: u8) -> bool { true }
//! #     fn link_is_free(&self) -> bool { true }
//! # }
//! # struct Dwt; impl CycleCounter for Dwt { fn cycles(&mut self) -> u32 { 0 } }
//! # struct Iwdg; impl Watchdog for Iwdg { fn feed(&mut self) {} }
//! # let (mut board, mut dwt, mut iwdg) = (Board { us: 0 }, Dwt, Iwdg);
//!
//! let mut monitor: Monitor<1, 16> = Monitor::new(Spindle::single(&BEARING), &SETTINGS);
//! // From nothing, a solve takes more iterations than a tick has: once, before ticks begin.
//! monitor.prepare([420.0, 0.0, 0.0, 0.0, 0.0], 0.0).expect("the preload has an equilibrium");
//! let mut loads = FramedLoads::new();
//! let mut tachometer = PulseSpeed::new(Edges::default(), TACHOMETER);
//! let mut clock = Widened::new(32, 0);
//! # for _ in 0..3 {
//! // loop {
//!     let now = board.wait_for_tick();
//!     let time_us = clock.at(now);
//!     while let Some(byte) = board.received() {
//!         loads.push(byte);
//!     }
//!     let readings = Readings {
//!         loads: loads.sample(time_us),
//!         speed: Some(tachometer.speed(now).ok().map(|speed| speed.omega)),
//!         temperatures: None,
//!     };
//!     let outcome = monitor.tick(time_us, &readings, &mut dwt, &mut iwdg);
//!     for change in &outcome.changes {
//!         // defmt::warn!("{}", change);
//!         # let _ = change;
//!     }
//!     while board.link_is_free() && let Some(byte) = monitor.outbox().next_byte() {
//!         board.send(byte);
//!     }
//! # }
//! # assert_eq!(monitor.health().ticks, 3);
//! // }
//! ```
//!
//! # What holds whatever happens
//!
//! - **No fault stops the ticks.** Nothing waits, loops are bounded, and every input ends in an answer or a
//!   mark.
//! - **No stiffness without a mark.** A doubted sample is not solved. The last good estimate stays, with its
//!   age, and goes out with the marks of the present.
//! - **No alarm is lost.** Alarms latch, and their reports are not dropped ([`telemetry`]).
//! - **No drift.** Times are 64 bits, counters are 64 bits and stop rather than wrap, sums over a life are
//!   exact.
//!
//! # Left out on purpose
//!
//! Filters before the solver (an analogue one belongs before the converter), the spectrum of vibrations,
//! and lubrication.

mod availability;
pub mod board;
pub mod command;
mod cost;
pub mod judgement;
pub mod life;
pub mod loads;
pub mod marks;
pub mod plausibility;
pub mod retained;
pub mod self_check;
pub mod settings;
pub mod speed;
pub mod telemetry;
pub mod temperature;
pub mod tick;
mod tracker;

pub use board::BoardReport;
pub use command::{Command, Order};
pub use judgement::{Alarm, AlarmState, Changes, Judgement};
pub use life::Life;
pub use marks::{Mark, Marks};
pub use plausibility::{GoodSample, Readings};
pub use retained::{Identity, Past, Store};
pub use settings::{MonitorSettings, RowSettings, SettingsError, ShaftSettings};
pub use temperature::{TemperatureSettings, TemperatureSource};

use crate::growth::Growth;
use crate::real::{Float, Real};
use crate::results::life::damage_of_weight;
use crate::results::margins::{Limit, Limits};
use crate::spindle::solution::{compliances, preloads};
use crate::{Facing, Motion, RacewayControlFree, Spindle, SpindleSolution};
use availability::Availability;
use command::{Answer, AnswerCode, ORDER_EVERY, Request};
use embedded_storage::nor_flash::NorFlash;
use judgement::{AlarmChange, Findings, Level};
use loads::FrameCounts;
use plausibility::{Plausibility, seconds};
use telemetry::{
    AlarmReport, BALLS_PER_FRAME, BallReport, BallsReport, EstimateReport, HealthReport,
    HelloReport, LIFT_OFF, Outbox, Payload, ROWS_PER_FRAME, RetentionReport, RowPlace, RowReport,
    RowsReport, ShaftReport, StatusCode,
};
use temperature::Temperatures;
use tick::{CycleCounter, Ticker, Watchdog};
use tracker::Tracker;

/// Outcome of a tick.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Outcome {
    /// Doubts about the sample or the estimate.
    pub marks: Marks,
    /// Whether there is a new estimate.
    pub solved: bool,
    /// Iterations in this tick; 0 if there was nothing to solve.
    pub iterations: u16,
    /// Age of the estimate in ticks, if there is one.
    pub age: Option<u32>,
    /// Alarms that changed.
    pub changes: Changes,
    /// Whether the tick took longer than its deadline.
    pub overrun: bool,
}

/// The last good equilibrium, as a report needs it.
#[derive(Debug, Clone, Copy)]
struct Estimate<const R: usize, const N: usize> {
    time_us: u64,
    tick: u64,
    load: [f32; 5],
    speed: f32,
    displacement: [f32; 5],
    stiffness: [[f32; 5]; 5],
    iterations: u16,
    error: [f32; 3],
    limits: u8,
    /// Forces and preload of the rows, and the smallest and the largest contact force on their inner races, N.
    rows: [RowReport; R],
    /// Force and sine and cosine of the contact angle, of every ball's inner and outer contact: angles are worked
    /// out where they are reported.
    balls: [[[[f32; 3]; 2]; N]; R],
}

impl<const R: usize, const N: usize> Estimate<R, N> {
    /// To be written over.
    const NONE: Self = Self {
        time_us: 0,
        tick: 0,
        load: [0.0; 5],
        speed: 0.0,
        displacement: [0.0; 5],
        stiffness: [[0.0; 5]; 5],
        iterations: 0,
        error: [0.0; 3],
        limits: 0,
        rows: [NO_ROW; R],
        balls: [[[[0.0; 3]; 2]; N]; R],
    };

    fn report(
        &self,
        age: u32,
        marks: Marks,
        status: StatusCode,
        flexibility: &[f32; 3],
    ) -> EstimateReport {
        let k = &self.stiffness;
        let (row, column) = telemetry::strongest_coupling(k);
        let compliances = compliances(k);
        let (mut least, mut largest) = (f32::INFINITY, 0.0_f32);
        for row in &self.rows {
            least = least.at_most(row.least_force);
            largest = largest.at_least(row.largest_force);
        }
        EstimateReport {
            age,
            marks,
            load: self.load,
            speed: self.speed,
            displacement: self.displacement,
            stiffness: diagonal(k),
            nose: core::array::from_fn(|i| 1.0 / (compliances[i] + flexibility[i])),
            coupling: k[row][column],
            coupling_row: row as u8,
            coupling_column: column as u8,
            least_force: least,
            largest_force: largest,
            status,
            iterations: self.iterations,
            error: self.error,
            limits: self.limits,
        }
    }
}

/// To be written over.
const NO_ROW: RowReport = RowReport {
    axial: 0.0,
    radial: [0.0; 2],
    preload: 0.0,
    least_force: f32::INFINITY,
    largest_force: 0.0,
};

fn diagonal(k: &[[f32; 5]; 5]) -> [f32; 5] {
    core::array::from_fn(|i| k[i][i])
}

/// Solve to be made.
#[derive(Debug, Clone, Copy)]
enum Wanted {
    /// The estimate of a good sample.
    Estimate(GoodSample),
    /// Life that the loads of this sample use, times this factor.
    Wear(GoodSample, f32),
}

/// The first of these.
fn as_many_as_fit<X, const CAP: usize>(items: impl Iterator<Item = X>) -> heapless::Vec<X, CAP> {
    let mut kept = heapless::Vec::new();
    for item in items {
        if kept.push(item).is_err() {
            break;
        }
    }
    kept
}

/// Balls that are reported in a tick: their angles cost it as much as their frame does.
const BALLS_PER_TICK: usize = 4;
const _: () = assert!(BALLS_PER_TICK <= BALLS_PER_FRAME);

/// All balls at one time, on their way into the outbox.
#[derive(Debug, Clone, Copy)]
struct Picture<const R: usize, const N: usize> {
    time_us: u64,
    /// As an [`Estimate`] has them.
    balls: [[[[f32; 3]; 2]; N]; R],
    /// The row that is on its way, and how many of its balls are reported.
    row: usize,
    reported: usize,
}

/// A ball as the telemetry has it.
fn ball_report([[q_i, sin_i, cos_i], [q_o, sin_o, cos_o]]: &[[f32; 3]; 2]) -> BallReport {
    BallReport {
        q_i: *q_i,
        q_o: *q_o,
        alpha_i: Float::atan2(*sin_i, *cos_i),
        alpha_o: Float::atan2(*sin_o, *cos_o),
    }
}

/// Growth that is worth telling the solver of, m: a tenth of a newton of preload.
const GROWTH_STEP: f32 = 5e-9;

/// Ticks in a row that may put reports off.
const LONGEST_PUT_OFF: u8 = 4;

/// Time from one hello to the next, us: for hosts that join in later.
const HELLO_US: u32 = 60_000_000;

/// Something that is due now and then.
#[derive(Debug, Clone, Copy)]
struct Every {
    next_us: u64,
}

impl Every {
    fn is_due(&mut self, time_us: u64, period_us: u32) -> bool {
        if time_us < self.next_us {
            return false;
        }
        // In step with the period, unless that has been missed altogether.
        let period = u64::from(period_us);
        let next = self.next_us.saturating_add(period);
        self.next_us = if next > time_us {
            next
        } else {
            time_us.saturating_add(period)
        };
        true
    }
}

/// The monitor of a spindle with `R` rows of at most `N` balls; `D` is as for [`Spindle`].
///
/// Fixed in size, without a heap; `FRAMES` estimates and pictures of balls wait for a slow link. The solver works
/// in `T`; measured and reported values are in single precision.
#[derive(Debug)]
pub struct Monitor<
    const R: usize,
    const N: usize,
    M: Motion + Copy = RacewayControlFree,
    const FRAMES: usize = 12,
    T: Real + 'static = f32,
    const D: usize = 5,
> {
    settings: &'static MonitorSettings<R>,
    tracker: Tracker<T, R, N, M, D>,
    plausibility: Plausibility,
    temperatures: Temperatures,
    /// Growth that the solver knows.
    growth: [Growth<f32>; R],
    ticker: Ticker,
    judgement: Judgement,
    life: Life,
    availability: Availability,
    outbox: Outbox<FRAMES>,
    estimate: Option<Estimate<R, N>>,
    picture: Option<Picture<R, N>>,
    /// How the last solve ended.
    status: StatusCode,
    /// The last solve gave no estimate.
    unsolved: bool,
    /// The newest sample that is still to be solved, and its tick.
    waiting: Option<(Wanted, u64)>,
    /// Ticks until the next solve.
    countdown: u16,
    /// The tick before this one was late.
    late: bool,
    /// When the monitor began, and when a sample was good last, us.
    began_us: Option<u64>,
    good_us: Option<u64>,
    estimates: u64,
    refusals: u64,
    marked: u64,
    /// Doubts since the last health report.
    doubts: Marks,
    retention: RetentionReport,
    records: FrameCounts,
    /// Requests that wait, and whether the input for service was on when they came.
    requests: heapless::Deque<(Request, bool), { Alarm::COUNT }>,
    hello: HelloReport,
    /// Ticks in a row that have put reports off.
    put_off: u8,
    due_estimate: Every,
    due_balls: Every,
    due_health: Every,
    due_standing: Every,
    due_hello: Every,
}

impl<const R: usize, const N: usize, M: Motion + Copy, const FRAMES: usize, T: Real, const D: usize>
    Monitor<R, N, M, FRAMES, T, D>
{
    /// A monitor at its beginning: no estimate, no alarm, a new bearing.
    pub fn new(
        spindle: Spindle<'static, T, R, N, D>,
        settings: &'static MonitorSettings<R>,
    ) -> Self {
        let now = Every { next_us: 0 };
        // Apart, so that no tick has to report everything at once.
        let part = |of: u32| Every {
            next_us: u64::from(settings.telemetry.estimate_us) * u64::from(of) / 4,
        };
        Self {
            settings,
            tracker: Tracker::new(spindle, settings),
            plausibility: Plausibility::new(&settings.plausibility),
            temperatures: Temperatures::new(settings.temperatures.as_ref()),
            growth: [Growth::NONE; R],
            ticker: Ticker::new(&settings.tick),
            judgement: Judgement::default(),
            life: Life::NEW,
            availability: Availability::NEW,
            outbox: Outbox::new(),
            estimate: None,
            picture: None,
            status: StatusCode::Unloaded,
            unsolved: false,
            waiting: None,
            countdown: 0,
            late: false,
            began_us: None,
            good_us: None,
            estimates: 0,
            refusals: 0,
            marked: 0,
            doubts: Marks::NONE,
            retention: RetentionReport::NO_MEMORY,
            records: FrameCounts::default(),
            requests: heapless::Deque::new(),
            hello: HelloReport {
                start: Past::NONE.report(),
                board: BoardReport::NONE,
                shaft: shaft_report(&spindle, settings),
            },
            put_off: 0,
            due_estimate: part(1),
            due_balls: part(2),
            due_health: now,
            due_standing: part(3),
            due_hello: now,
        }
    }

    /// Goes on with the data kept over a power cycle ([`retained`]). Alarms that nobody had acknowledged are latched.
    #[must_use]
    pub fn with_past(mut self, past: &Past) -> Self {
        self.judgement.latch(past.start.alarms);
        self.life = Life::resume(past.life.0, past.life.1);
        self.hello.start = past.report();
        self
    }

    /// An operator wants something. A tick carries it out, unless it is out of place, and answers in the telemetry. `service`
    /// is the board's input by which somebody at the machine lets a bearing be replaced. As long as there is no room, a
    /// request is as one that was not heard.
    pub fn ask(&mut self, request: &Request, service: bool) {
        let _ = self.requests.push_back((*request, service));
    }

    /// Carries out the order that has waited longest, within the share that orders have.
    fn serve(&mut self, time_us: u64, tick: u64) {
        if !tick.is_multiple_of(ORDER_EVERY) || self.outbox.has_answer() {
            return;
        }
        let Some((Request { number, order }, service)) = self.requests.pop_front() else {
            return;
        };
        let answer = Answer {
            number,
            order,
            outcome: self.carry_out(time_us, order, service),
        };
        self.outbox.post(time_us, Payload::Answer(answer));
    }

    fn carry_out(&mut self, time_us: u64, order: Order, service: bool) -> AnswerCode {
        match order {
            Order::Acknowledge { alarm, raised } => {
                if self.judgement.alarm(alarm).counts().0 != raised {
                    return AnswerCode::NoSuchOccurrence;
                }
                self.acknowledge(time_us, alarm);
                AnswerCode::Done
            }
            Order::ReplaceBearing if !service => AnswerCode::NotInService,
            Order::ReplaceBearing if self.replace_bearing(time_us) => AnswerCode::Done,
            Order::ReplaceBearing => AnswerCode::NotAtStandstill,
        }
    }

    /// Has a store keep new data. To be called between ticks, as often as one likes; it is the store that
    /// writes, by [`Store::step`].
    pub fn retain<F: NorFlash>(&mut self, time_us: u64, store: &mut Store<F>) {
        store.look(time_us, &self.judgement, &self.life);
        self.retention = store.report();
    }

    /// Notes the counts of the line of load records, for the telemetry.
    pub const fn note_records(&mut self, counts: FrameCounts) {
        self.records = counts;
    }

    /// Takes the board's report on itself. Changes, but for the stack, are reported in the next tick.
    pub fn set_board(&mut self, report: BoardReport) {
        if report.differs(&self.hello.board) {
            self.due_hello = Every { next_us: 0 };
        }
        self.hello.board = report;
    }

    /// Has a store keep life and alarms at once, since the supply is about to go ([`Store::power_fails`]).
    pub fn power_fails<F: NorFlash>(&self, time_us: u64, store: &mut Store<F>) -> bool {
        store.power_fails(time_us, &self.judgement, &self.life)
    }

    /// The spindle has a new bearing of the same design, with all of its life before it. Only while the shaft stands
    /// still; whether that was so.
    pub fn replace_bearing(&mut self, time_us: u64) -> bool {
        let oldest_us = self.settings.plausibility.missing_after_us;
        let stands_still = self.plausibility.stands_still(time_us, oldest_us);
        if stands_still {
            self.life = self.life.renewed();
        }
        stands_still
    }

    /// Solves a first equilibrium (loads in N, N m; speed in rad/s) to start from, before ticks begin. It may
    /// take longer than one. Gives no estimate.
    ///
    /// # Errors
    ///
    /// How the solve ended without an answer.
    pub fn prepare(&mut self, load: [f32; 5], speed: f32) -> Result<(), StatusCode> {
        let settings = self.settings;
        let growth = self.growth(speed);
        let damage = self
            .tracker
            .prepare(load, speed, &growth, settings, |solution| {
                damage(solution, settings)
            })?;
        self.life.measure(settings.plausibility.part(&load));
        self.life.set_damage(damage);
        Ok(())
    }

    /// One tick: takes the readings, doubts them, solves them if it is time, judges, counts and reports.
    /// `time_us` is the time since the start and never goes back.
    pub fn tick(
        &mut self,
        time_us: u64,
        readings: &Readings,
        counter: &mut impl CycleCounter,
        watchdog: &mut impl Watchdog,
    ) -> Outcome {
        let step_us = self.ticker.begin(time_us, counter);
        let tick = self.ticker.ticks();
        let began_us = *self.began_us.get_or_insert(time_us);
        let mut changes = Changes::new();
        let judging = &self.settings.judgement;

        if let Ok(Some(sample)) = &readings.loads {
            self.judgement
                .measured(time_us, &sample.load, judging, &mut changes);
        }
        let (doubts, good) =
            self.plausibility
                .judge(time_us, readings, &self.settings.plausibility);
        if let Some(settings) = &self.settings.temperatures {
            self.temperatures
                .judge(time_us, readings.temperatures, settings);
            let level = Level::of(self.temperatures.age(time_us));
            self.judgement
                .level(time_us, Alarm::Temperature, level, judging, &mut changes);
        }
        if let Some(sample) = good {
            self.waiting = Some((Wanted::Estimate(sample), tick));
        }
        self.serve(time_us, tick);
        let wear = self.measure(time_us, readings, doubts);
        if doubts.is_empty() {
            self.good_us = Some(time_us);
        } else {
            // A sample that was good a tick ago is not solved under the doubts of now.
            self.waiting = wear.map(|wear| (wear, tick));
            self.marked = self.marked.saturating_add(1);
        }

        let (mut solved, mut iterations) = (false, 0);
        if self.countdown > 0 {
            self.countdown -= 1;
        } else if let Some((wanted, at)) = self.waiting.take() {
            self.countdown = self.settings.tick.solve_every.saturating_sub(1);
            match wanted {
                Wanted::Estimate(sample) => solved = self.solve(&sample, at, &mut changes),
                Wanted::Wear(sample, scale) => self.wear(&sample, scale),
            }
            iterations = self.tracker.iterations();
        }

        let mut marks = doubts;
        marks.mark_if(self.unsolved, Mark::Unsolved);
        marks.mark_if(self.estimate.is_none(), Mark::NoEstimate);
        self.doubts = self.doubts.union(marks);

        let speed = self.plausibility.last_speed();
        self.life
            .turn(speed, step_us as f32 * 1e-6, !marks.is_empty());

        let good_us = self.good_us.unwrap_or(began_us);
        let estimated_us = self.estimate.as_ref().map_or(began_us, |e| e.time_us);
        for (alarm, value) in [
            (Alarm::LifeUsed, self.life.used()),
            (Alarm::Sensor, seconds(good_us, time_us)),
        ] {
            self.judgement
                .level(time_us, alarm, Level::of(value), judging, &mut changes);
        }
        let missed = self.ticker.missed();
        let apart = u32::from(self.settings.tick.solve_every) * self.settings.tick.period_us;
        let oldest = self.settings.plausibility.fresh_us.max(apart);
        let fresh = marks.is_empty() && time_us.saturating_sub(estimated_us) <= oldest.into();
        if let Some(blind) = self.availability.count(time_us, fresh, missed) {
            let level = Level::of(blind);
            self.judgement
                .level(time_us, Alarm::Availability, level, judging, &mut changes);
        }
        // A tick knows how long it took when it is over: the next one judges it.
        self.judgement
            .ticked(time_us, self.late, judging, &mut changes);

        let is_full = iterations > 1 && iterations >= self.settings.tick.max_iterations();
        self.report(time_us, tick, marks, &changes, is_full);
        let overrun = self.ticker.finish(counter, watchdog);
        self.late = overrun;
        Outcome {
            marks,
            solved,
            iterations,
            age: self.age(tick),
            changes,
            overrun,
        }
    }

    /// Age of the estimate at a tick.
    fn age(&self, tick: u64) -> Option<u32> {
        let age = |e: &Estimate<R, N>| tick.saturating_sub(e.tick).min(u32::MAX.into()) as u32;
        self.estimate.as_ref().map(age)
    }

    /// Tells the life the measured loads. Returns loads to be solved for the life alone, scaled into
    /// their range: too large or too fast ones, if nothing else speaks against them.
    fn measure(&mut self, time_us: u64, readings: &Readings, doubts: Marks) -> Option<Wanted> {
        let believed = doubts.is_within(Marks::from(Mark::Range).with(Mark::Rate));
        let Ok(Some(sample)) = &readings.loads else {
            if !believed {
                self.life.measure(0.0);
            }
            return None;
        };
        let part = self.settings.plausibility.part(&sample.load);
        let believed = believed && part <= life::LARGEST_GROWTH;
        self.life.measure(if believed { part } else { 0.0 });
        if doubts.is_empty() || !believed {
            return None;
        }
        let scale = 1.0_f32.at_least(part);
        let sample = GoodSample {
            time_us,
            load: sample.load.map(|load| load / scale),
            speed: self.plausibility.speed_of(time_us)?,
        };
        Some(Wanted::Wear(sample, scale))
    }

    /// Growth of rings and balls of each row at a speed, but for less than [`GROWTH_STEP`]. Another
    /// growth has a solver move its references, which takes some thousand cycles.
    fn growth(&mut self, speed: f32) -> [Growth<f32>; R] {
        let [inner, outer] = match &self.settings.temperatures {
            Some(settings) => self.temperatures.used().map(|t| t - settings.reference),
            None => [0.0; 2],
        };
        for (known, row) in self.growth.iter_mut().zip(&self.settings.rows) {
            let [per_inner, per_outer] = row.heat;
            let grown = row.rotation * (speed * speed) + per_inner * inner + per_outer * outer;
            let differs = |a: f32, b: f32| (a - b).abs() > GROWTH_STEP;
            if differs(grown.axial, known.axial)
                || differs(grown.radial, known.radial)
                || differs(grown.ball, known.ball)
            {
                *known = grown;
            }
        }
        self.growth
    }

    /// Solves a sample for the life alone, under so many times its loads.
    fn wear(&mut self, sample: &GoodSample, scale: f32) {
        let settings = self.settings;
        let growth = self.growth(sample.speed);
        let damage = self
            .tracker
            .solve(sample.load, sample.speed, &growth, settings, |solution| {
                damage(solution, settings)
            });
        if let Ok(damage) = damage {
            self.life.set_damage(damage * scale * scale * scale);
        }
    }

    /// Solves and judges a sample; whether there is a new estimate.
    fn solve(&mut self, sample: &GoodSample, tick: u64, changes: &mut Changes) -> bool {
        let settings = self.settings;
        let growth = self.growth(sample.speed);
        let estimate = &mut self.estimate;
        let seen = self
            .tracker
            .solve(sample.load, sample.speed, &growth, settings, |solution| {
                // Written where it stays: a copy of it takes a thousand cycles on a Cortex-M4F.
                let estimate = estimate.get_or_insert(Estimate::NONE);
                observe(solution, sample, tick, settings, estimate)
            });
        self.unsolved = seen.is_err();
        match seen {
            Ok((status, findings, damage)) => {
                self.status = status;
                self.estimates = self.estimates.saturating_add(1);
                self.life.set_damage(damage);
                self.judgement
                    .judge(sample.time_us, &findings, &settings.judgement, changes);
                true
            }
            Err(status) => {
                self.status = status;
                self.refusals = self.refusals.saturating_add(1);
                false
            }
        }
    }

    /// Puts due frames into the outbox.
    ///
    /// A tick whose solve has taken all of its iterations (`is_full`) leaves frames that can wait to the next ticks.
    fn report(&mut self, time_us: u64, tick: u64, marks: Marks, changes: &Changes, is_full: bool) {
        let every = &self.settings.telemetry;
        for change in changes {
            self.post_alarm(time_us, change.alarm, change.change);
        }
        if is_full && self.put_off < LONGEST_PUT_OFF {
            self.put_off += 1;
            return;
        }
        self.put_off = 0;
        if self.due_standing.is_due(time_us, every.standing_us) {
            for alarm in Alarm::ALL {
                if self.judgement.alarm(alarm).stands() {
                    self.post_alarm(time_us, alarm, AlarmChange::Standing);
                }
            }
        }
        if self.due_health.is_due(time_us, every.health_us) {
            let health = self.health();
            self.doubts = Marks::NONE;
            self.outbox.post(time_us, Payload::Health(health));
        }
        if self.due_hello.is_due(time_us, HELLO_US) {
            self.outbox
                .post(time_us, Payload::Hello(self.hello.clone()));
        }
        let (estimate_due, balls_due) = (
            self.due_estimate.is_due(time_us, every.estimate_us),
            self.due_balls.is_due(time_us, every.balls_us),
        );
        if estimate_due && let Some(report) = self.report_at(tick, marks) {
            self.outbox.post(time_us, Payload::Estimate(report));
            self.report_rows(time_us);
        }
        if balls_due && let Some(estimate) = &self.estimate {
            self.picture = Some(Picture {
                time_us,
                balls: estimate.balls,
                row: 0,
                reported: 0,
            });
        }
        self.report_balls();
    }

    /// Puts the rows of the estimate into the outbox.
    fn report_rows(&mut self, time_us: u64) {
        let Some(estimate) = &self.estimate else {
            return;
        };
        for (number, rows) in estimate.rows.chunks(ROWS_PER_FRAME).enumerate() {
            let report = RowsReport {
                first: (number * ROWS_PER_FRAME) as u8,
                count: R as u8,
                rows: as_many_as_fit(rows.iter().copied()),
            };
            self.outbox.post(time_us, Payload::Rows(report));
        }
    }

    /// Puts the next balls of the picture into the outbox.
    fn report_balls(&mut self) {
        let Some(picture) = &mut self.picture else {
            return;
        };
        let (Some(row), Some(balls)) = (
            self.settings.rows.get(picture.row),
            picture.balls.get(picture.row),
        ) else {
            self.picture = None;
            return;
        };
        let count = usize::from(row.balls);
        let rest = balls.iter().take(count).skip(picture.reported);
        let report = BallsReport {
            row: picture.row as u8,
            first: picture.reported as u16,
            count: row.balls,
            first_azimuth: row.first_azimuth,
            balls: as_many_as_fit(rest.take(BALLS_PER_TICK).map(ball_report)),
        };
        self.outbox.post(picture.time_us, Payload::Balls(report));
        picture.reported += BALLS_PER_TICK;
        if picture.reported >= count {
            (picture.row, picture.reported) = (picture.row + 1, 0);
        }
        if picture.row >= R {
            self.picture = None;
        }
    }

    fn post_alarm(&mut self, time_us: u64, alarm: Alarm, change: AlarmChange) {
        let machine = self.judgement.alarm(alarm);
        let (raised, cleared) = machine.counts();
        let Level { value, ball } = machine.level();
        let threshold = self.settings.judgement.of(alarm);
        let report = AlarmReport {
            alarm,
            change,
            state: machine.state(),
            value,
            limit: match change {
                AlarmChange::Cleared => threshold.clear,
                _ => threshold.raise,
            },
            ball,
            raised,
            cleared,
        };
        self.outbox.post(time_us, Payload::Alarm(report));
    }

    fn report_at(&self, tick: u64, marks: Marks) -> Option<EstimateReport> {
        let estimate = self.estimate.as_ref()?;
        let flexibility = &self.settings.shaft.flexibility;
        Some(estimate.report(self.age(tick)?, marks, self.status, flexibility))
    }

    /// Somebody has seen an alarm: it may clear. Says so in the telemetry.
    pub fn acknowledge(&mut self, time_us: u64, alarm: Alarm) {
        if let Some(change) = self.judgement.acknowledge(alarm) {
            self.post_alarm(time_us, alarm, change);
        }
    }

    /// Counters since the start.
    pub fn health(&self) -> HealthReport {
        let (alarms_raised, alarms_cleared) = self.judgement.counts();
        HealthReport {
            ticks: self.ticker.ticks(),
            overruns: self.ticker.overruns(),
            missed_ticks: self.ticker.missed(),
            estimates: self.estimates,
            refusals: self.refusals,
            marked_samples: self.marked,
            alarms_raised,
            alarms_cleared,
            frames_dropped: self.outbox.dropped(),
            most_cycles: self.ticker.most_cycles(),
            revolutions: self.life.revolutions(),
            life_used: self.life.used(),
            marks: self.doubts,
            retention: self.retention,
            availability: self.availability.share(),
            records: self.records,
            doubtful_revolutions: self.life.doubtful_revolutions(),
            life_estimated: self.life.estimated(),
            temperatures: self.temperatures.used(),
            temperature_sources: self.temperatures.sources(),
        }
    }

    /// Frames for the link.
    pub const fn outbox(&mut self) -> &mut Outbox<FRAMES> {
        &mut self.outbox
    }

    /// Alarms.
    pub const fn judgement(&mut self) -> &mut Judgement {
        &mut self.judgement
    }

    /// Life used up.
    pub const fn life(&self) -> &Life {
        &self.life
    }
}

/// Places on the shaft, as the telemetry has them.
fn shaft_report<T: Real, const R: usize, const N: usize, const D: usize>(
    spindle: &Spindle<'_, T, R, N, D>,
    settings: &MonitorSettings<R>,
) -> ShaftReport {
    let places = spindle.positions().into_iter().zip(spindle.facings());
    let rows = places.zip(&settings.rows);
    let place = |((position, facing), row): ((T, Facing), &RowSettings)| RowPlace {
        position: position.to_f32(),
        mirrored: facing == Facing::MinusX,
        balls: row.balls,
    };
    ShaftReport {
        nose: settings.shaft.nose,
        loads_at: settings.shaft.loads_at,
        preload: settings.judgement.preload,
        count: R as u8,
        rows: as_many_as_fit(rows.map(place)),
    }
}

/// Rating life that an equilibrium uses per million revolutions, as a part of 1.
fn damage<T: Real, const R: usize, const N: usize, M: Motion, const D: usize>(
    solution: &SpindleSolution<'_, T, R, N, M, D>,
    settings: &MonitorSettings<R>,
) -> f32 {
    let mut weight = 0.0;
    for (i, row) in settings.rows.iter().enumerate() {
        let forces = solution.view(i).contact_forces();
        let forces = forces.map(|(q_i, q_o)| (q_i.to_f32(), q_o.to_f32()));
        weight += row.rating.weight_of(forces);
    }
    damage_of_weight(weight)
}

/// The worse of two levels.
fn worse(a: Level, b: Level) -> Level {
    if b.value > a.value { b } else { a }
}

/// Takes an equilibrium into the estimate. Returns how the solve ended, the findings to be judged, and
/// the life that it uses.
fn observe<T: Real, const R: usize, const N: usize, M: Motion, const D: usize>(
    solution: &SpindleSolution<'_, T, R, N, M, D>,
    sample: &GoodSample,
    tick: u64,
    settings: &MonitorSettings<R>,
    estimate: &mut Estimate<R, N>,
) -> (StatusCode, Findings, f32) {
    let limits = Limits {
        peak_pressure: T::from_f32(settings.limits.peak_pressure),
        friction: T::from_f32(settings.limits.friction),
    };
    let mut findings = Findings {
        pressure: Level::of(0.0),
        contact_angle: Level::of(f32::NEG_INFINITY),
        slip: Level::of(0.0),
        unloaded: Level::of(0.0),
        preload: None,
    };
    let (mut passed, mut weight) = (0, 0.0);
    let mut first = 0;
    let balls = settings.rows.iter().zip(&mut estimate.balls);
    for (i, ((row, balls), seen)) in balls.zip(&mut estimate.rows).enumerate() {
        let view = solution.view(i);
        let unit = view.c.force.to_f32();
        let (mut inner, mut outer) = (0.0_f32, 0.0_f32);
        // Force of the inner ring onto the balls, in units.
        let (mut axial, mut radial) = (0.0_f32, [0.0_f32; 2]);
        *seen = NO_ROW;
        let margins = view.survey(&limits, |ball, kinetics| {
            let contacts = [&kinetics.inner, &kinetics.outer];
            let force = contacts.map(|k| k.q.to_f32());
            let q = unit * force[0];
            if q < seen.least_force {
                seen.least_force = q;
            }
            if q > seen.largest_force {
                seen.largest_force = q;
            }
            let ([sin, cos], friction) = (
                kinetics.inner.n.map(T::to_f32),
                kinetics.friction[0].to_f32(),
            );
            axial += force[0] * sin + friction * cos;
            if let Some(at) = view.azimuths.get(usize::from(ball)) {
                let outwards = force[0] * cos - friction * sin;
                radial[0] += outwards * at.cos.to_f32();
                radial[1] += outwards * at.sin.to_f32();
            }
            inner += force[0] * force[0] * force[0];
            // In units, an outer contact's force is the deformation to 3/2, so that the force to 10/3 is a square.
            let root = force[1] * kinetics.outer.delta.to_f32();
            outer += root * root;
            if let Some(to) = balls.get_mut(usize::from(ball)) {
                let [i, o] = contacts.map(|k| k.n.map(T::to_f32));
                *to = [[q, i[0], i[1]], [unit * force[1], o[0], o[1]]];
            }
        });
        let level = |limit: Limit, before: Level| {
            margins.get(limit).map_or(before, |margin| {
                let value = margin.value.to_f32();
                let ball = Some(first + margin.ball);
                worse(before, Level { value, ball })
            })
        };
        findings.pressure = level(Limit::PeakPressure, findings.pressure);
        findings.contact_angle = level(Limit::Shoulder, findings.contact_angle);
        findings.slip = level(Limit::Friction, findings.slip);
        if let Some(off) = margins.get(Limit::InnerContact) {
            findings.unloaded.value += f32::from(margins.unloaded);
            findings.unloaded.ball = findings.unloaded.ball.or(Some(first + off.ball));
        }
        seen.axial = unit * axial;
        seen.radial = radial.map(|force| unit * force);
        passed |= margins.passed().bits();
        let count = view.balls.len() as u16;
        weight += row.rating.weight(unit, inner, outer, count.into());
        first += count;
    }
    estimate.time_us = sample.time_us;
    estimate.tick = tick;
    estimate.load = sample.load;
    estimate.speed = sample.speed;
    let nose = T::from_f32(settings.shaft.nose);
    estimate.displacement = solution.displacement_at(nose).map(T::to_f32);
    let stiffness = solution.stiffness_at(nose);
    estimate.stiffness = stiffness.map(|row| row.map(T::to_f32));
    estimate.iterations = solution.iterations;
    estimate.error = [
        solution.error.displacement.to_f32(),
        solution.error.force.to_f32(),
        solution.error.stiffness.to_f32(),
    ];
    estimate.limits = passed;
    let facings = solution.facings();
    findings.preload = share_preload(&mut estimate.rows, &facings, &mut estimate.limits);
    let code = StatusCode::from(&solution.status);
    (code, findings, damage_of_weight(weight))
}

/// Gives every row its preload; the smallest and the largest one, if there are rows of both facings. Rows that have lifted
/// off are a limit then.
fn share_preload<const R: usize>(
    rows: &mut [RowReport; R],
    facings: &[Facing; R],
    limits: &mut u8,
) -> Option<[f32; 2]> {
    let first = facings.first()?;
    if facings.iter().all(|facing| facing == first) {
        return None;
    }
    let axial = rows.each_ref().map(|row| row.axial);
    let mut range = [f32::INFINITY, 0.0_f32];
    for (row, preload) in rows.iter_mut().zip(preloads(&axial, facings)) {
        row.preload = preload;
        if !(row.axial > 0.0) {
            *limits |= LIFT_OFF;
        }
        range = [range[0].at_most(preload), range[1].at_least(preload)];
    }
    Some(range)
}
