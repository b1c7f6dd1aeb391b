//! From sensor to alarm: the work of a spindle's board around the solver.
//!
//! Data flows one way, a file for each step:
//!
//! | step | module | gives |
//! | --- | --- | --- |
//! | acquisition | [`loads`] | five loads and a speed, or why there are none |
//! | plausibility | [`plausibility`], [`temperature`] | a good sample, or the [`marks`] of its doubts |
//! | solve | [`tick`], `tracker` | an equilibrium, in the time that ticks have |
//! | levels | `watch` | a level for each alarm |
//! | probes | [`pairs`], [`revolutions`], [`blocks`], [`estimator`], [`preload`] | the preload that the spindle has, and each probe's gain |
//! | alarms | [`alarms`], [`judgement`] | their list; alarms that latch |
//! | life | [`life`] | rating life used up |
//! | reports | `reports`, [`outbox`], [`telemetry`] | frames for a host |
//! | the board | [`board`], [`self_check`] | why it started, and whether it is sound |
//! | commands | [`command`] | the host's messages besides loads |
//! | retention | [`retained`], [`log`] | life used and alarms, over a power cycle |
//!
//! Read [`Monitor::tick`] first, then [`settings`], which has all that is particular to a spindle. The
//! whole of a firmware's loop:
//!
//! ```
//! use spindle_monitor::{
//!     Monitor, Readings,
//!     loads::{FramedLoads, LoadSource},
//!     settings::MonitorSettings,
//!     tick::{CycleCounter, Watchdog, Widened},
//! };
//! use spindle_bearing::{Arrangement, Bearing, Design, Facing, Mounted, Spindle};
//!
//! const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
//! static BEARING: Bearing<f32, 16> = match Bearing::<f32, 16>::new(&DESIGN) {
//!     Ok(bearing) => bearing,
//!     Err(_) => panic!("this bearing cannot be built"),
//! };
//! static SPINDLE: Spindle<f32, 1, 16> = Spindle::<f32, 1, 16>::const_new(
//!     Arrangement::ByRows,
//!     [Mounted::new(&BEARING, 0.0, Facing::PlusX)],
//! );
//! static SETTINGS: MonitorSettings = MonitorSettings::new(&DESIGN, 16);
//! const _: () = assert!(SETTINGS.check().is_ok() && SETTINGS.tick.has_time(1, 16));
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
//! let mut monitor: Monitor<1, 16> = Monitor::new(&SPINDLE, &SETTINGS);
//! // From nothing, a solve takes some ticks: once, before ticks begin.
//! monitor.prepare([420.0, 0.0, 0.0, 0.0, 0.0]).expect("the preload has an equilibrium");
//! let mut loads = FramedLoads::new();
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
//!         // Records carry the speed.
//!         speed: None,
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
//! - **No drift.** Times are 64 bits. Counters, of 32 or 64 bits, stop rather than wrap; the frames' numbers wrap. Sums over a life
//!   carry what rounding leaves over.
//!
//! # Left out on purpose
//!
//! Filters before the solver (an analogue one belongs before the converter), the spectrum of vibrations,
//! and lubrication.

#![no_std]

#[cfg(test)]
extern crate std;

mod accuracy;
pub mod alarms;
pub mod blocks;
pub mod board;
pub mod command;
mod cost;
pub mod estimator;
pub mod framing;
mod in_place;
pub mod judgement;
pub mod life;
pub mod loads;
pub mod log;
pub mod marks;
pub mod outbox;
pub mod pairs;
pub mod plausibility;
pub mod preload;
mod probes;
pub mod record;
mod reports;
pub mod retained;
pub mod revolutions;
pub mod self_check;
pub mod settings;
pub mod telemetry;
pub mod temperature;
pub mod tick;
mod tracker;
mod watch;

pub use alarms::Alarm;
pub use board::BoardReport;
pub use command::{Command, Order};
pub use judgement::{AlarmState, Changes, Judgement};
pub use life::Life;
pub use marks::{Mark, Marks};
pub use plausibility::{GoodSample, Readings};
pub use probes::Probes;
pub use retained::{Identity, Past, Store};
pub use settings::{
    MonitorSettings, ProbeSettings, ResponseSettings, RowSettings, SettingsError, ShaftSettings,
};
pub use temperature::{TemperatureSettings, TemperatureSource};

// In signatures.
pub use {enumset, heapless};

use command::{Answer, AnswerCode, ORDER_EVERY, Request};
use core::mem::MaybeUninit;
use embedded_storage::nor_flash::NorFlash;
use in_place::in_place;
use judgement::Levels;
use loads::FrameCounts;
use outbox::Outbox;
use plausibility::Plausibility;
use reports::Reports;
use spindle_bearing::{Growth, RatingLife, RowSummary, Spindle, Status};
use telemetry::{HealthReport, Payload, ProbesReport};
use temperature::Temperatures;
use tick::{CycleCounter, SolveTime, Ticker, Watchdog};
use tracker::{Ended, Purpose, Task, Tracker};
use watch::Watch;

/// Outcome of a tick.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Outcome {
    /// Doubts about the sample or the estimate.
    pub marks: Marks,
    /// Whether there is a new estimate.
    pub solved: bool,
    /// Rows of balls that the solve has passed in this tick; 0 if there was nothing to solve.
    pub rows: u16,
    /// Age of the estimate in ticks, if there is one.
    pub age: Option<u32>,
    /// Alarms that changed.
    pub changes: Changes,
    /// Whether the tick took longer than its deadline.
    pub overrun: bool,
    /// Outputs of the board from now on.
    pub outputs: Outputs,
}

/// Two outputs for the machine's controller, on while all is well: a wire that breaks is no good news.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Outputs {
    /// No alarm stands.
    pub no_alarm: bool,
    /// There was a fresh estimate within the last second, and no self-check has failed.
    pub monitored: bool,
}

/// Growth that is worth telling the solver of, m: a tenth of a newton of preload.
const GROWTH_STEP: f32 = 5e-9;

/// The estimate that there is.
#[derive(Debug, Clone, Copy)]
struct Estimate {
    time_us: u64,
    tick: u64,
}

/// The monitor of a spindle with at most `R` rows of at most `N` balls and with `P` probes; `D` and `E` are as for [`Spindle`].
///
/// Fixed in size, without a heap; `FRAMES` estimates and pictures of balls wait for a slow link. It solves in single
/// precision.
#[derive(Debug)]
pub struct Monitor<
    const R: usize,
    const N: usize,
    const FRAMES: usize = 12,
    const D: usize = 5,
    const E: usize = 0,
    const P: usize = 0,
> {
    settings: &'static MonitorSettings<R>,
    plausibility: Plausibility,
    temperatures: Temperatures,
    /// Growth that the solver knows.
    growth: [Growth<f32>; R],
    tracker: Tracker<R, N, D, E>,
    /// The newest sample that is still to be solved.
    waiting: Option<Task<R>>,
    estimate: Option<Estimate>,
    ticker: Ticker,
    watch: Watch<R>,
    /// None without probes, of which then nothing is in an image.
    probes: Option<&'static mut Probes<P>>,
    alarms: Judgement,
    life: Life,
    reports: Reports<R, N, FRAMES>,
    /// Requests that wait, and whether the input for service was on when they came.
    requests: heapless::Deque<(Request, bool), { Alarm::COUNT }>,
    /// Counters that are kept nowhere else.
    counts: HealthReport,
    /// The tick before this one was late.
    late: bool,
}

impl<const R: usize, const N: usize, const FRAMES: usize, const D: usize, const E: usize>
    Monitor<R, N, FRAMES, D, E>
{
    /// A monitor at its beginning, without probes: no estimate, no alarm, a new bearing.
    pub fn new(
        spindle: &'static Spindle<'static, f32, R, N, D, E>,
        settings: &'static MonitorSettings<R>,
    ) -> Self {
        in_place::value(|place| Self::make(place, spindle, settings, None))
    }
}

impl<
    const R: usize,
    const N: usize,
    const FRAMES: usize,
    const D: usize,
    const E: usize,
    const P: usize,
> Monitor<R, N, FRAMES, D, E, P>
{
    /// A monitor at its beginning, of a spindle with probes, whose settings have the costs of
    /// [`CycleCost::with_probes`](tick::CycleCost::with_probes).
    pub fn with_probes(
        spindle: &'static Spindle<'static, f32, R, N, D, E>,
        settings: &'static MonitorSettings<R>,
        probes: &'static mut Probes<P>,
    ) -> Self {
        in_place::value(|place| Self::make(place, spindle, settings, Some(probes)))
    }

    /// Makes [`Monitor::with_probes`] in its place.
    ///
    /// For a board: its stack has no room for a monitor of many balls.
    #[inline(never)]
    pub fn make<'m>(
        place: &'m mut MaybeUninit<Self>,
        spindle: &'static Spindle<'static, f32, R, N, D, E>,
        settings: &'static MonitorSettings<R>,
        probes: Option<&'static mut Probes<P>>,
    ) -> &'m mut Self {
        in_place!(place, { tracker <- |place| Tracker::make(place, spindle), }, {
            settings: settings,
            plausibility: Plausibility::new(&settings.plausibility),
            temperatures: Temperatures::new(settings.temperatures.as_ref()),
            growth: [Growth::NONE; R],
            ticker: Ticker::new(&settings.tick, spindle.ball_counts()),
            reports: Reports::new(spindle, settings),
            watch: Watch::new(spindle.ball_counts(), spindle.facings()),
            probes: probes,
            waiting: None,
            estimate: None,
            alarms: Judgement::default(),
            life: Life::NEW,
            requests: heapless::Deque::new(),
            counts: HealthReport::default(),
            late: false,
        })
    }

    /// [`Monitor::set_past`] of a monitor at its beginning.
    #[must_use]
    pub fn with_past(mut self, past: &Past) -> Self {
        self.set_past(past);
        self
    }

    /// Goes on with the data kept over a power cycle ([`retained`]). Alarms that nobody had acknowledged are latched.
    pub fn set_past(&mut self, past: &Past) {
        self.alarms.latch(past.start.alarms);
        self.life = Life::resume(past.life.0, past.life.1);
        self.reports.set_past(past);
        if let Some(probes) = self.probes() {
            probes.restore(past.estimates.as_ref());
        }
    }

    /// An operator wants something. A tick carries it out, unless it is out of place, and answers in the telemetry. `service`
    /// is the board's input by which somebody at the machine lets a bearing be replaced. As long as there is no room, a
    /// request is as one that was not heard.
    pub fn ask(&mut self, request: &Request, service: bool) {
        let _ = self.requests.push_back((*request, service));
    }

    /// Carries out the order that has waited longest, within the share that orders have.
    fn serve(&mut self, time_us: u64, tick: u64) {
        if !tick.is_multiple_of(ORDER_EVERY) || self.reports.outbox.has_answer() {
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
        self.reports.outbox.post(time_us, Payload::Answer(answer));
    }

    fn carry_out(&mut self, time_us: u64, order: Order, service: bool) -> AnswerCode {
        match order {
            Order::Acknowledge {
                alarm,
                start,
                raised,
            } => {
                let now = (self.reports.start(), self.alarms.alarm(alarm).counts().0);
                if now != (start, raised) {
                    return AnswerCode::NoSuchOccurrence;
                }
                self.acknowledge(time_us, alarm);
                AnswerCode::Done
            }
            _ if !service => AnswerCode::NotInService,
            Order::ShaftStands => {
                self.plausibility.stand(time_us);
                AnswerCode::Done
            }
            Order::ReplaceBearing if self.replace_bearing(time_us) => AnswerCode::Done,
            Order::ReplaceBearing => AnswerCode::NotAtStandstill,
            Order::Commission => match self.probes().is_some_and(Probes::commission) {
                true => AnswerCode::Done,
                false => AnswerCode::Learning,
            },
        }
    }

    /// Has a store keep new data. To be called between ticks, as often as one likes; it is the store that
    /// writes, by [`Store::step`].
    pub fn retain<F: NorFlash>(&mut self, time_us: u64, store: &mut Store<F>) {
        let estimates = self.seen().and_then(Probes::kept);
        store.look(time_us, &self.alarms, &self.life, estimates);
        self.counts.retention = store.report();
    }

    /// Notes the counts of the line of load records, for the telemetry.
    pub const fn note_records(&mut self, counts: FrameCounts) {
        self.counts.records = counts;
    }

    /// Notes the displacements (um) that the probes measured with the loads of the next tick; none of a probe that gave no value.
    pub fn note_displacements(&mut self, measured: [Option<f32>; P]) {
        if let Some(probes) = self.probes() {
            probes.note(measured);
        }
    }

    /// The probes; none without. The compiler knows it, too.
    fn probes(&mut self) -> Option<&mut Probes<P>> {
        self.probes.as_deref_mut().filter(|_| P > 0)
    }

    /// The probes.
    fn seen(&self) -> Option<&Probes<P>> {
        self.probes.as_deref().filter(|_| P > 0)
    }

    /// Report on the probes, as the telemetry has it; none without.
    pub fn probes_report(&self) -> Option<ProbesReport> {
        self.seen().map(|probes| probes.report(&self.alarms))
    }

    /// Whether the probes are commissioned.
    pub fn is_commissioned(&self) -> bool {
        self.seen()
            .is_some_and(|probes| probes.estimator().is_commissioned())
    }

    /// Has the probes begin from the prior, and not end commissioning before this time, us.
    pub fn learn(&mut self, not_before_us: u64) {
        let tick = self.ticker.ticks();
        if let Some(probes) = self.probes() {
            probes.forget(tick, not_before_us);
        }
    }

    /// Takes the board's report on itself. Changes, but for the stack, are reported in the next tick.
    pub fn set_board(&mut self, report: BoardReport) {
        self.reports.set_board(report);
    }

    /// Has a store keep life, alarms and references at once, since the supply is about to go ([`Store::power_fails`]).
    pub fn power_fails<F: NorFlash>(&self, time_us: u64, store: &mut Store<F>) -> bool {
        let estimates = self.seen().and_then(Probes::kept);
        store.power_fails(time_us, &self.alarms, &self.life, estimates)
    }

    /// The spindle has a new bearing of the same design, with all of its life before it, and is to be commissioned. Only while the
    /// shaft stands still; whether that was so.
    pub fn replace_bearing(&mut self, time_us: u64) -> bool {
        let oldest_us = self.settings.plausibility.missing_after_us;
        let stands_still = self.plausibility.stands_still(time_us, oldest_us);
        if stands_still {
            self.life = self.life.renewed();
            self.learn(0);
        }
        stands_still
    }

    /// Solves the spindle at rest under the loads of idling (N, N m) to start from, before ticks begin: cold, since preloads are
    /// held against those of that solve. It may take longer than a tick. Gives no estimate.
    ///
    /// # Errors
    ///
    /// How the solve ended without an answer.
    pub fn prepare(&mut self, load: [f32; 5]) -> Result<(), Status<f32>> {
        let settings = self.settings;
        let task = Task {
            sample: GoodSample {
                time_us: 0,
                load,
                speed: 0.0,
            },
            tick: 0,
            purpose: Purpose::Estimate,
            growth: settings.rows.each_ref().map(|row| row.growth),
            rows: 0,
        };
        self.tracker.begin(task);
        self.tracker
            .go_on(settings, || true)
            .map_err(|(_, status)| status)?;
        let mut ended = self.tracker.ended.take().ok_or(Status::IterationLimit)?;
        self.glance(&mut ended, || true);
        let rows = ended.all().ok_or(Status::IterationLimit)?;
        self.watch.mount(rows);
        self.reports.mount(rows);
        let square = settings.plausibility.square(&load);
        // The axial force on the rows of one side: all of it, less what the other side has in common with it.
        let forces = rows.iter().map(|row| row.force[0] - 0.5 * row.preload);
        let pressed = [forces.sum(), 0.0, 0.0, 0.0, 0.0];
        let pressed = settings.plausibility.square(&pressed);
        self.life.measure(Some(square));
        self.life.mount(damage_of(rows), square, pressed);
        Ok(())
    }

    /// One tick: takes the readings, doubts them, goes on with a solve, judges, counts and reports.
    /// `time_us` is the time since the start and never goes back.
    pub fn tick(
        &mut self,
        time_us: u64,
        readings: &Readings,
        counter: &mut impl CycleCounter,
        watchdog: &mut impl Watchdog,
    ) -> Outcome {
        let missed_before = self.ticker.missed();
        let step_us = self.ticker.begin(time_us, counter);
        let tick = self.ticker.ticks();
        let settings = self.settings;
        let mut levels = Levels::default();
        self.reports.begin(time_us, settings);
        self.serve(time_us, tick);

        let (doubts, good) = self.read(time_us, tick, readings, &mut levels);
        let passed = self.tracker.rows_passed();
        let mut time = self.ticker.solve_time(counter, passed);
        let solved = self.solve(&mut time, &mut levels);
        if let Some(probes) = self.probes.as_deref_mut().filter(|_| P > 0)
            && probes.has_step()
            && time.has_a_step()
        {
            probes.take_step(time_us, tick);
        }
        let rows = time.rows();

        let mut marks = doubts;
        marks.extend(self.reports.is_unsolved().then_some(Mark::Unsolved));
        marks.extend(self.estimate.is_none().then_some(Mark::NoEstimate));
        self.counts.marks = self.counts.marks.union(marks);
        let speed = self.plausibility.last_speed();
        let fresh = marks.is_empty() && self.is_fresh(time_us);
        let is_older = !doubts.is_empty() || self.tracker.is_busy() || self.waiting.is_some();
        let time = step_us as f32 * 1e-6;
        self.life.turn(speed, time, is_older, !marks.is_empty());
        levels.set_value(Alarm::LifeUsed, self.life.used());
        // A tick knows how long it took when it is over: the next one judges it.
        let sees = [doubts.is_empty(), fresh, self.late];
        let missed = self.ticker.missed();
        // Without a speed, blocks end: they have no gap, and no temperature that nobody measures.
        let speed = self.plausibility.undoubted_speed();
        let speed = speed.filter(|_| missed == missed_before && self.temperatures.are_measured());
        if let Some(probes) = self.probes() {
            probes.tick(tick, speed, good.map(|good| good.load), &mut levels);
        }
        self.watch.tick(time_us, sees, missed, &mut levels);

        let due_us = |alarm| settings.due_us(alarm);
        let changes = self
            .alarms
            .judge(time_us, &levels, &settings.alarms, due_us);
        if let Some(probes) = self.probes() {
            probes.keep(time_us, &changes);
        }
        let alarms = (&self.alarms, &changes);
        self.reports.send(time_us, (tick, marks), alarms, settings);
        if self.reports.wants_health(time_us, settings) {
            let health = self.health();
            self.counts.marks = Marks::new();
            self.reports.outbox.post(time_us, Payload::Health(health));
            if let Some(report) = self.probes_report() {
                self.reports.outbox.post(time_us, Payload::Probes(report));
            }
        }
        self.late = self.ticker.finish(counter, watchdog);
        Outcome {
            marks,
            solved,
            rows,
            age: self.age(tick),
            changes,
            overrun: self.late,
            outputs: Outputs {
                no_alarm: !Alarm::ALL
                    .iter()
                    .any(|alarm| self.alarms.alarm(*alarm).stands()),
                monitored: self.watch.sees(time_us) && !self.reports.is_board_broken(),
            },
        }
    }

    /// Takes the readings: a sample that nothing speaks against is next to be solved. Returns the doubts, and that sample.
    fn read(
        &mut self,
        time_us: u64,
        tick: u64,
        readings: &Readings,
        levels: &mut Levels,
    ) -> (Marks, Option<GoodSample>) {
        let settings = self.settings;
        if let Ok(Some(sample)) = &readings.loads {
            let raise = settings.alarms[Alarm::Overload as usize].raise;
            if let Some(level) = watch::overload(&sample.load, &settings.overload, raise) {
                levels.set_value(Alarm::Overload, level);
            }
        }
        let (doubts, good) = self
            .plausibility
            .judge(time_us, readings, &settings.plausibility);
        if let Some(settings) = &settings.temperatures {
            self.temperatures
                .judge(time_us, readings.temperatures, settings);
            levels.set_value(Alarm::Temperature, self.temperatures.age(time_us));
        }
        let too_large = self.measure(time_us, readings, doubts);
        if !doubts.is_empty() {
            // A sample that was good a tick ago is not solved under the doubts of now.
            self.waiting = None;
            self.counts.marked_samples = self.counts.marked_samples.saturating_add(1);
        }
        let estimated = good.map(|sample| (sample, Purpose::Estimate));
        if let Some((sample, purpose)) = estimated.or(too_large) {
            self.waiting = Some(Task {
                sample,
                tick,
                purpose,
                growth: self.growth,
                rows: 0,
            });
        }
        (doubts, good)
    }

    /// Tells the life the measured loads. Returns loads to be solved for the life alone, scaled into
    /// their range: too large or too fast ones, if nothing else speaks against them.
    fn measure(
        &mut self,
        time_us: u64,
        readings: &Readings,
        doubts: Marks,
    ) -> Option<(GoodSample, Purpose)> {
        let believed = doubts.is_subset(Mark::Range | Mark::Rate);
        let Ok(Some(sample)) = &readings.loads else {
            if !believed {
                self.life.measure(None);
            }
            return None;
        };
        let plausibility = &self.settings.plausibility;
        let part = plausibility.part(&sample.load);
        let believed = believed && part <= life::LARGEST_GROWTH;
        let square = plausibility.square(&sample.load);
        self.life.measure(believed.then_some(square));
        if doubts.is_empty() || !believed {
            return None;
        }
        let scale = part.max(1.0);
        let sample = GoodSample {
            time_us,
            load: sample.load.map(|load| load / scale),
            speed: self.plausibility.speed_of(time_us)?,
        };
        Some((sample, Purpose::Life(scale)))
    }

    /// Growth of rings and balls of each row at a speed, but for less than [`GROWTH_STEP`]. Another
    /// growth has a solver move its references, which takes some thousand cycles.
    fn growth(&mut self, speed: f32) -> [Growth<f32>; R] {
        let [inner, outer] = match &self.settings.temperatures {
            Some(settings) => self.temperatures.used().map(|t| t - settings.reference),
            None => [0.0; 2],
        };
        let probes = self.probes.as_deref().filter(|_| P > 0);
        for (i, (known, row)) in self.growth.iter_mut().zip(&self.settings.rows).enumerate() {
            let [per_inner, per_outer] = row.heat;
            let turning = row.rotation * (speed * speed);
            let mut grown = row.growth + turning + per_inner * inner + per_outer * outer;
            // A closure is a growth along the axis.
            grown.axial += probes.map_or(0.0, |probes| probes.closure(i));
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

    /// Looks at the solve that has ended, then goes on with one that has begun or begins with the newest sample; whether there is
    /// a new estimate.
    fn solve(&mut self, time: &mut SolveTime<'_, impl CycleCounter>, levels: &mut Levels) -> bool {
        let earlier = self.look(time, levels);
        let is_new = !self.tracker.is_busy() && self.waiting.is_some();
        if self.tracker.rows_passed() > 0
            || ((is_new || self.tracker.has_begun()) && time.has_a_solve())
        {
            if is_new && let Some(task) = self.waiting.take() {
                let growth = self.growth(task.sample.speed);
                self.tracker.begin(Task { growth, ..task });
            }
            match self.tracker.go_on(self.settings, || time.has_a_row_more()) {
                Err((Purpose::Estimate, status)) => {
                    self.reports.status = status;
                    self.counts.refusals = self.counts.refusals.saturating_add(1);
                }
                Err((Purpose::Life(_), _)) | Ok(()) => {}
            }
        }
        self.look(time, levels) || earlier
    }

    /// Takes levels, life and what is due for reports of the solve that has ended, for as long as there is time; whether there is
    /// a new estimate.
    fn look(&mut self, time: &mut SolveTime<'_, impl CycleCounter>, levels: &mut Levels) -> bool {
        let Some(mut ended) = self.tracker.ended.take() else {
            return false;
        };
        let mut is_new = false;
        if ended.all().is_none() {
            match self.glance(&mut ended, || time.has_a_look()) {
                None => return false,
                Some(None) => {
                    self.tracker.ended = Some(ended);
                    return false;
                }
                Some(Some((status, computed))) => {
                    if !self.see(&ended, status, computed, levels) {
                        return false;
                    }
                    is_new = true;
                }
            }
        }
        let task = &ended.task;
        let Some(rows) = ended.all() else {
            return false;
        };
        let is_estimate = matches!(task.purpose, Purpose::Estimate);
        if is_estimate
            && let Some(probes) = self.probes.as_deref_mut().filter(|_| P > 0)
            && probes.wants_look(task.tick)
        {
            if !time.has_slopes() {
                self.tracker.ended = Some(ended);
                return is_new;
            }
            let tick = task.tick;
            self.tracker
                .look(task, self.settings, |solution| probes.look(tick, solution));
        }
        if !self.reports.wants_something() {
            return is_new;
        }
        if !time.has_a_report() {
            self.tracker.ended = Some(ended);
            return is_new;
        }
        let (reports, opposed) = (&mut self.reports, self.watch.is_opposed());
        self.tracker.look(task, self.settings, |solution| {
            reports.see(task, solution, rows, opposed, self.settings);
        });
        is_new
    }

    /// Takes rows at a glance for as long as `has_time`; how the solve ended, and the displacement at each probe (um), once all are
    /// taken. None without an equilibrium.
    fn glance(
        &self,
        ended: &mut Ended<R>,
        mut has_time: impl FnMut() -> bool,
    ) -> Option<Option<(Status<f32>, [f32; P])>> {
        let (settings, Ended { task, rows, count }) = (self.settings, ended);
        let limits = settings.limits();
        self.tracker.look(task, settings, |solution| {
            while rows.len() < *count
                && let Some(row) = settings.rows.get(rows.len())
                && has_time()
            {
                let _ = rows.push(solution.row_summary(rows.len(), &limits, &row.rating));
            }
            if rows.len() < *count {
                return None;
            }
            solution.share(rows);
            let is_estimate = matches!(task.purpose, Purpose::Estimate);
            let probes = self.seen().filter(|_| is_estimate);
            let computed = probes.map(|probes| probes.computed(solution));
            Some((solution.status, computed.unwrap_or([0.0; P])))
        })
    }

    /// Takes levels and life of an equilibrium with all of its rows; whether it is an estimate, not one for the life alone.
    fn see(
        &mut self,
        ended: &Ended<R>,
        status: Status<f32>,
        computed: [f32; P],
        levels: &mut Levels,
    ) -> bool {
        let task = &ended.task;
        let Some(rows) = ended.all() else {
            return false;
        };
        let square = self.settings.plausibility.square(&task.sample.load);
        if let Purpose::Life(scale) = task.purpose {
            let damage = damage_of(rows) * scale * scale * scale;
            self.life.set_damage(damage, square * scale * scale);
            return false;
        }
        self.watch.rows(rows, levels);
        self.life.set_damage(damage_of(rows), square);
        self.counts.estimates = self.counts.estimates.saturating_add(1);
        self.reports.status = status;
        self.estimate = Some(Estimate {
            time_us: task.sample.time_us,
            tick: task.tick,
        });
        if let Some(probes) = self.probes() {
            probes.solved(task.tick, &task.sample.load, computed);
        }
        true
    }

    /// Whether the estimate is of a sample that is not too old.
    fn is_fresh(&self, time_us: u64) -> bool {
        let fresh_us = self.settings.plausibility.fresh_us.into();
        self.estimate
            .is_some_and(|estimate| time_us.saturating_sub(estimate.time_us) <= fresh_us)
    }

    /// Age of the estimate at a tick.
    fn age(&self, tick: u64) -> Option<u32> {
        let age = |e: &Estimate| tick.saturating_sub(e.tick).min(u32::MAX.into()) as u32;
        self.estimate.as_ref().map(age)
    }

    /// Somebody has seen an alarm: it may clear. Says so in the telemetry.
    pub fn acknowledge(&mut self, time_us: u64, alarm: Alarm) {
        if let Some(change) = self.alarms.acknowledge(alarm) {
            let thresholds = &self.settings.alarms;
            self.reports
                .post_alarm(time_us, alarm, change, &self.alarms, thresholds);
        }
    }

    /// Counters since the start.
    pub fn health(&self) -> HealthReport {
        let (alarms_raised, alarms_cleared) = self.alarms.counts();
        HealthReport {
            ticks: self.ticker.ticks(),
            overruns: self.ticker.overruns(),
            missed_ticks: self.ticker.missed(),
            alarms_raised,
            alarms_cleared,
            frames_dropped: self.reports.outbox.dropped(),
            most_cycles: self.ticker.most_cycles(),
            revolutions: self.life.revolutions(),
            life_used: self.life.used(),
            availability: self.watch.availability(),
            doubtful_revolutions: self.life.doubtful_revolutions(),
            life_estimated: self.life.estimated(),
            temperatures: self.temperatures.used(),
            temperature_sources: self.temperatures.sources(),
            ..self.counts
        }
    }

    /// Frames for the link.
    pub const fn outbox(&mut self) -> &mut Outbox<FRAMES> {
        &mut self.reports.outbox
    }

    /// Alarms.
    pub const fn judgement(&mut self) -> &mut Judgement {
        &mut self.alarms
    }

    /// Life used up.
    pub const fn life(&self) -> &Life {
        &self.life
    }
}

/// Rating life that an equilibrium uses per million revolutions, as a part of 1.
fn damage_of(rows: &[RowSummary<f32>]) -> f32 {
    let rate = rows.iter().map(|row| row.life_rate).sum();
    1.0 / RatingLife::of_weight(rate, 0.0).million_revolutions
}
