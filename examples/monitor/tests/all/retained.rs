//! Data kept by `monitor::retained`: what a record holds, when it is written, and how long the log lasts.

use super::estimator::{SETTINGS as SETTINGS_OF_PROBES, taught};
use embedded_storage::nor_flash::NorFlash;
use mock::flash::FailingFlash;
use mock::rig::{B7005C, SINGLE};
use spindle_monitor::Alarm;
use spindle_monitor::board::ResetCause;
use spindle_monitor::command::{AnswerCode, Request};
use spindle_monitor::enumset::EnumSet;
use spindle_monitor::estimator::{Constants, Estimator, Kept as KeptEstimates};
use spindle_monitor::judgement::{AlarmState, Level, Levels};
use spindle_monitor::loads::LoadSample;
use spindle_monitor::log::Log;
use spindle_monitor::retained::{Identity, LIFE_US, Past, Recovery, RetentionReport, Store};
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::telemetry::{FrameReader, Payload};
use spindle_monitor::tick::{NoCycles, NoWatchdog};
use spindle_monitor::{Judgement, Life, Marks, Monitor, Order, Readings};

static SETTINGS: MonitorSettings = {
    let mut settings = MonitorSettings::new(&B7005C, 16);
    settings.tick.deadline_cycles *= 10;
    let mut i = 0;
    while i < Alarm::COUNT {
        settings.alarms[i].hold_us = 0;
        i += 1;
    }
    settings
};
/// Worked out by the compiler, as a firmware has it.
const IDENTITY: Identity = Identity::of(7005, 25);

/// As an STM32F405 has it, with smaller sectors.
type Words = FailingFlash<4, 4096>;
/// As an STM32H743 has it.
type Wide = FailingFlash<32, 131_072>;

const IDLE: [f32; 5] = [420.0, 0.0, 0.0, 0.0, 0.0];

/// Life, and alarms that nobody has acknowledged.
type Kept = ((u64, u64), EnumSet<Alarm>);
const NOTHING: Kept = ((0, 0), EnumSet::new());

/// One power cycle of a board.
struct Board<F> {
    store: Store<F>,
    found: Past,
    judgement: Judgement,
    life: Life,
    estimates: Option<KeptEstimates>,
    time_us: u64,
}

impl<F: NorFlash> Board<F> {
    fn start(flash: F) -> Self {
        Self::start_as(flash, IDENTITY)
    }

    fn start_as(flash: F, identity: Identity) -> Self {
        let (store, found) = Store::open(flash, identity, ResetCause::PowerOn);
        let mut judgement = Judgement::default();
        judgement.latch(found.start.alarms);
        let mut life = Life::resume(found.life.0, found.life.1);
        life.set_damage(1e-3, 0.0);
        Self {
            store,
            found,
            judgement,
            life,
            estimates: found.estimates,
            time_us: 0,
        }
    }

    /// A level that raises an alarm at once.
    fn raise(&mut self, alarm: Alarm) {
        let level = Level::of(f32::INFINITY);
        let mut levels = Levels::default();
        levels.set(alarm, level);
        let _ = self
            .judgement
            .judge(self.time_us, &levels, &SETTINGS.alarms, |alarm| {
                SETTINGS.due_us(alarm)
            });
        assert_eq!(self.judgement.alarm(alarm).state(), AlarmState::Raised);
    }

    /// The shaft turns for so long, a look at every second.
    fn turn(&mut self, seconds: u64) {
        for _ in 0..seconds {
            self.turn_at_once(1);
        }
    }

    /// It turns for so long, a look at the end.
    fn turn_at_once(&mut self, seconds: u32) {
        self.life.turn(1000.0, seconds as f32, false, false);
        self.stand(seconds);
    }

    /// It stands still until the next look.
    fn stand(&mut self, seconds: u32) {
        self.time_us += 1_000_000 * u64::from(seconds);
        self.look();
        while self.store.step() {}
    }

    fn look(&mut self) {
        self.store
            .look(self.time_us, &self.judgement, &self.life, self.estimates);
    }

    fn power_fails(&mut self) -> bool {
        self.store
            .power_fails(self.time_us, &self.judgement, &self.life, self.estimates)
    }

    fn now(&self) -> Kept {
        (self.life.kept(), self.judgement.unacknowledged())
    }

    fn found(&self) -> Kept {
        (self.found.life, self.found.start.alarms)
    }

    fn recovery(&self) -> Recovery {
        self.store.report().recovery
    }

    /// Records written, and copies that failed.
    fn records(&self) -> (u32, u32) {
        let report = self.store.report();
        (report.written / 2, report.failed)
    }

    fn off(self) -> F {
        self.store.into_flash()
    }
}

/// A flash that has seen an alarm and an hour of turning.
fn used<F: NorFlash>(flash: F) -> (F, Kept) {
    let mut board = Board::start(flash);
    board.raise(Alarm::Slip);
    board.turn_at_once(3600);
    assert_eq!(board.records(), (1, 0));
    let kept = board.now();
    (board.off(), kept)
}

#[test]
fn life_and_alarms_are_there_after_any_number_of_starts() {
    fn holds<F: NorFlash>(flash: F) {
        let first = Board::start(flash);
        assert_eq!(
            (first.found(), first.recovery()),
            (NOTHING, Recovery::Blank)
        );
        let (mut flash, kept) = used(first.off());
        for boots in 2..300 {
            let mut board = Board::start(flash);
            assert_eq!(
                (board.found(), board.recovery()),
                (kept, Recovery::Recovered)
            );
            assert_eq!(board.found.start.boots, boots);
            board.stand(1);
            assert_eq!(board.store.report().failed, 0);
            flash = board.off();
        }
    }
    holds(Words::new(2));
    holds(Wide::new(2));
    holds(FailingFlash::<1, 4096>::new(5));
    holds(FailingFlash::<64, 8192>::new(3));
}

#[test]
fn life_is_written_every_two_minutes_and_then_in_proportion() {
    let mut board = Board::start(Wide::new(2));
    for (turns, stands, written) in [
        (LIFE_US / 1_000_000 - 1, 0, 1),
        (1, 0, 2),
        // Nothing new.
        (0, 20_000, 2),
        // Two seconds after a long rest are worth a record.
        (2, 0, 3),
        (0, 118, 3),
    ] {
        board.turn(turns);
        board.stand(stands);
        assert_eq!(board.records(), (written, 0));
    }
    // 64 ln(4/2), 64 ln(6/4) and so on.
    for expected in [60, 44, 25, 18, 14] {
        let (before, _) = board.records();
        board.turn(7200);
        let written = board.records().0 - before;
        assert!(written.abs_diff(expected) <= 2, "{written}, not {expected}");
    }
    let lived = board.life.kept();
    let Board { found, .. } = Board::start(board.off());
    let lost = (lived.1 - found.life.1) as f64 / lived.1 as f64;
    assert!(lost < 1.0 / 64.0, "{lost}");
}

/// A crash of a minute after a week of idling: few revolutions, much life.
#[test]
fn life_that_is_used_fast_is_written_as_soon_as_revolutions() {
    let mut board = Board::start(Wide::new(2));
    board.life.set_damage(1e-6, 0.0);
    for _ in 0..7 * 24 * 60 {
        board.turn_at_once(60);
    }
    board.life.set_damage(10.0, 0.0);
    for _ in 0..2 {
        board.turn_at_once(60);
    }
    let used = board.life.kept().0;
    let Board { found, .. } = Board::start(board.off());
    assert!(used - found.life.0 <= used / 2 + used / 64);
}

#[test]
fn the_life_of_a_replaced_bearing_is_written_at_once() {
    let (flash, (_, alarms)) = used(Words::new(2));
    let mut board = Board::start(flash);
    board.life = Life::NEW;
    board.stand(1);
    assert_eq!(Board::start(board.off()).found(), ((0, 0), alarms));
}

#[test]
fn a_power_cut_every_nine_minutes_or_more_leaves_seven_eighths_of_the_life() {
    for minutes in [9, 10, 17, 31, 45, 59] {
        let mut flash = Wide::new(2);
        for _ in 0..20 {
            let mut board = Board::start(flash);
            board.turn(minutes * 60);
            flash = board.off();
        }
        let mut lived = Life::NEW;
        lived.turn(1000.0, 20.0 * 60.0 * minutes as f32, false, false);
        let kept = Board::start(flash).found.life.1 as f64 / lived.kept().1 as f64;
        assert!(kept > 0.88, "{minutes} min: {kept}");
    }
}

#[test]
fn a_board_that_is_warned_of_the_power_cut_loses_nothing() {
    fn holds<F: NorFlash>(flash: F) {
        let mut board = Board::start(used(flash).0);
        // Whatever else is being written.
        for busy in [0, 1, 2, 9, 40] {
            board.raise(Alarm::Slip);
            board.time_us += LIFE_US;
            board.life.turn(1000.0, 50.0, false, false);
            board.look();
            for _ in 0..busy {
                board.store.step();
            }
            board.life.turn(1000.0, 0.1, false, false);
            assert!(board.power_fails());
            let kept = board.now();
            board = Board::start(Board::start(board.off()).off());
            assert_eq!(board.found(), kept, "{busy}");
            assert_eq!(board.store.report().failed, 0);
        }
    }
    holds(Words::new(2));
    holds(Wide::new(2));
}

// --- starts and alarms -------------------------------------------------------------------------

#[test]
fn starts_are_counted_with_their_cause_and_a_failed_first_tick_counts_none() {
    let mut flash = Words::new(2);
    for (boots, cause) in (1..).zip(ResetCause::ALL.into_iter().cycle().take(50)) {
        let (mut store, past) = Store::open(flash, IDENTITY, cause);
        assert_eq!((past.start.boots, past.start.cause), (boots, cause));
        while store.step() {}
        // This one is over before it has written anything.
        let (store, past) = Store::open(store.into_flash(), IDENTITY, cause);
        assert_eq!(past.start.boots, boots + 1);
        flash = store.into_flash();
        let (_, payload) = Log::open(flash.clone());
        assert_eq!(payload.unwrap()[1], cause as u8);
    }
}

#[test]
fn a_power_cycle_acknowledges_no_alarm() {
    let mut board = Board::start(Words::new(2));
    for alarm in [Alarm::Overload, Alarm::LifeUsed, Alarm::Slip] {
        board.raise(alarm);
    }
    board.judgement.acknowledge(Alarm::LifeUsed);
    board.stand(1);
    let mut flash = board.off();
    for _ in 0..2 {
        let board = Board::start(flash);
        let latched: Vec<_> = board.found.start.alarms.iter().collect();
        assert_eq!(latched, [Alarm::Slip, Alarm::Overload]);
        let state = |alarm| board.judgement.alarm(alarm).state();
        assert_eq!(state(Alarm::Overload), AlarmState::Latched);
        assert_eq!(state(Alarm::LifeUsed), AlarmState::Clear);
        let raised = board.found.start.raised;
        assert_eq!(raised[Alarm::LifeUsed as usize], 1);
        assert_eq!(raised.iter().sum::<u8>(), 3);
        flash = board.off();
    }
    // Raised again, and acknowledged.
    let mut board = Board::start(flash);
    board.raise(Alarm::Overload);
    board.judgement.acknowledge(Alarm::Slip);
    board.stand(1);
    // Changes within 10 s wait.
    board.raise(Alarm::Sensor);
    board.stand(9);
    assert_eq!(board.records(), (1, 0));
    board.stand(1);
    assert_eq!(board.records(), (2, 0));
    let Board { found, .. } = Board::start(board.off());
    let latched: Vec<_> = found.start.alarms.iter().collect();
    assert_eq!(latched, [Alarm::Overload, Alarm::Sensor]);
    assert_eq!(found.start.raised[Alarm::Overload as usize], 2);
}

// --- wear --------------------------------------------------------------------------------------

/// Half of a half is free after a start, and `n` slots last for `128 min (64/63)^(n - 64)`.
#[test]
fn the_free_half_lasts_for_years_without_a_restart() {
    let slots = |slot: usize| 131_072 / slot;
    let years = |slot: usize| {
        let free = slots(slot) / 2;
        128.0 * (64.0_f64 / 63.0).powi(free as i32 - 64) / 60.0 / 24.0 / 365.25
    };
    assert_eq!(Log::<FailingFlash<4, 131_072>>::SLOT, 96);
    assert_eq!(slots(96), 1365);
    assert!((years(96) - 4.1).abs() < 0.1, "{}", years(96));
    // The law itself: one of these records is the start.
    let mut board = Board::start(Wide::new(2));
    let mut kept = (0, 0);
    while board.records().0 < 683 {
        let seconds = board.time_us / 1_000_000;
        board.turn_at_once((seconds / 100_000).max(1) as u32);
        let now = board.life.kept().1;
        if board.records().0 > kept.0 {
            kept = (board.records().0, now);
        }
        assert!(board.time_us < 128 * 60_000_000 || now - kept.1 <= now / 64);
    }
    let lasted = board.time_us as f64 / 1e6 / 86400.0 / 365.25;
    assert!((lasted / years(96) - 1.0).abs() < 0.03, "{lasted}");
}

/// A year of eight hours a day.
#[test]
fn daily_work_lasts_for_a_century_and_power_cuts_every_two_minutes_for_thirteen_years() {
    fn erases(starts: u32, records: u32, day: impl Fn(&mut Board<Wide>)) -> f64 {
        let mut flash = Wide::new(2);
        let mut life = (0, 0);
        for _ in 0..starts {
            let mut board = Board::start(flash);
            assert_eq!(board.found.life, life);
            day(&mut board);
            let (written, failed) = board.records();
            assert!(written.abs_diff(records) <= 2 && failed == 0, "{written}");
            flash = board.off();
            life = Board::start(flash.clone()).found.life;
        }
        assert_eq!(flash.erased[0], flash.erased[1]);
        f64::from(flash.erased[0]) / f64::from(starts)
    }
    let years = |a_day: f64| 10_000.0 / a_day / 365.25;
    let daily = erases(365, 149, |board| {
        for _ in 0..8 * 360 {
            board.turn_at_once(10);
        }
    });
    assert!((years(daily) - 130.0).abs() < 10.0, "{}", years(daily));
    let worst = erases(6000, 2, |board| {
        board.stand(1);
        board.turn_at_once(120);
    });
    let worst = years(worst * 720.0);
    assert!((worst - 13.0).abs() < 1.0, "{worst}");
}

// --- the monitor -------------------------------------------------------------------------------

/// Idling and cutting in turns.
fn readings(time_us: u64) -> Readings {
    let step = time_us / 1000;
    let cut = if step % 2000 < 1000 { 0.0 } else { 60.0 };
    Readings {
        loads: Ok(Some(LoadSample {
            time_us,
            load: [420.0, cut, -8.0, 0.05, -0.1].map(|load| load + 1e-3 * (step % 7) as f32),
            speed: Some(1500.0 + (step % 11) as f32),
            residual: 0.0,
            doubts: Marks::new(),
        })),
        speed: None,
        temperatures: None,
    }
}

fn monitor(past: &Past) -> Monitor<1, 16> {
    let mut monitor = Monitor::new(&SINGLE, &SETTINGS).with_past(past);
    monitor.prepare(IDLE).unwrap();
    monitor
}

/// A tick, and a unit written after it, as between the ticks of a board.
fn tick<F: NorFlash>(monitor: &mut Monitor<1, 16>, store: &mut Store<F>, time_us: u64) {
    monitor.tick(time_us, &readings(time_us), &mut NoCycles, &mut NoWatchdog);
    monitor.retain(time_us, store);
    store.step();
    while monitor.outbox().next_byte().is_some() {}
}

/// The life of a monitor that was switched off goes on as that of one that was not.
#[test]
fn a_monitor_goes_on_after_a_power_cycle_with_its_life() {
    let open = |flash| Store::open(flash, IDENTITY, ResetCause::PowerOn);
    let (mut store, past) = open(Wide::new(2));
    let mut first = monitor(&past);
    for ms in 0..3000 {
        tick(&mut first, &mut store, ms * 1000);
    }
    assert!(first.power_fails(3_000_000, &mut store));
    let report = store.report();
    assert_eq!((report.written, report.failed), (4, 0));

    let (mut store, past) = open(store.into_flash());
    let mut other = monitor(&past);
    assert_eq!(other.life().kept(), past.life);
    assert!(past.life.1 > 0 && past.life == first.life().kept());
    // From there on as one that was not switched off.
    let (mut unkept, nothing) = open(Wide::new(0));
    let mut without = monitor(&nothing);
    for ms in 0..3000 {
        tick(&mut other, &mut store, ms * 1000);
        tick(&mut without, &mut unkept, ms * 1000);
    }
    let (now, lived) = (other.life().kept(), without.life().kept());
    assert_eq!((now.0 - past.life.0, now.1 - past.life.1), lived);
    assert_eq!(other.health().retention.recovery, Recovery::Recovered);

    assert!(!other.replace_bearing(3_000_000));
    for time_us in [9_999_000, 15_000_000] {
        let mut standing = readings(time_us);
        if let Ok(Some(sample)) = &mut standing.loads {
            sample.speed = Some(0.0);
        }
        other.tick(time_us, &standing, &mut NoCycles, &mut NoWatchdog);
    }
    // A standstill of long ago is none.
    assert!(!other.replace_bearing(15_100_000));
    assert!(other.replace_bearing(15_000_000));
    tick(&mut other, &mut store, 15_001_000);
    while store.step() {}
    let (_, past) = open(store.into_flash());
    // A tick after the replacement has turned a little.
    assert!(past.life.1 >> 22 <= 250, "{}", past.life.1 >> 22);
}

/// The host sees it without asking: the start by its own report, the alarm among the standing ones.
#[test]
fn a_monitor_tells_of_its_start_and_of_the_alarms_before_it() {
    let mut board = Board::start(Wide::new(2));
    board.raise(Alarm::Overload);
    board.stand(1);
    let (_, past) = Store::open(board.off(), IDENTITY, ResetCause::Watchdog);
    let mut monitor = monitor(&past);
    let mut reader = FrameReader::new();
    let (mut starts, mut states) = (Vec::new(), Vec::new());
    for ms in 0..2000 {
        let time_us = ms * 1000;
        monitor.tick(time_us, &readings(time_us), &mut NoCycles, &mut NoWatchdog);
        if ms == 1500 {
            monitor.acknowledge(time_us, Alarm::Overload);
        }
        while let Some(byte) = monitor.outbox().next_byte() {
            match reader.push(byte).map(|frame| frame.unwrap().payload) {
                Some(Payload::Hello(report)) => starts.push(report.start),
                Some(Payload::Alarm(report)) if report.alarm == Alarm::Overload => {
                    states.push(report.state);
                }
                _ => {}
            }
        }
    }
    let [start] = starts[..] else {
        panic!("{starts:?}");
    };
    assert_eq!((start.boots, start.cause), (2, ResetCause::Watchdog));
    assert_eq!(start.alarms.iter().collect::<Vec<_>>(), [Alarm::Overload]);
    assert_eq!(start.raised[Alarm::Overload as usize], 1);
    let (last, before) = states.split_last().unwrap();
    assert!(!before.is_empty() && before.iter().all(|state| *state == AlarmState::Latched));
    assert_eq!(*last, AlarmState::Clear);
}

/// An overload in each of two starts, the first of each: a request that is sent again after the restart is about the other one.
#[test]
fn an_acknowledgement_of_the_start_before_is_refused() {
    fn overload(monitor: &mut Monitor<1, 16>, request: Option<Request>) -> Vec<Payload> {
        let (mut reader, mut told) = (FrameReader::new(), Vec::new());
        for ms in 0..100 {
            let time_us = ms * 1000;
            let mut readings = readings(time_us);
            if let Ok(Some(sample)) = &mut readings.loads {
                sample.load[1] = 1e6;
            }
            if ms == 50
                && let Some(request) = &request
            {
                monitor.ask(request, false);
            }
            monitor.tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
            while let Some(byte) = monitor.outbox().next_byte() {
                told.extend(reader.push(byte).map(|frame| frame.unwrap().payload));
            }
        }
        told
    }
    let of_overload = |told: &[Payload]| {
        let raised = told.iter().find_map(|payload| match payload {
            Payload::Alarm(report) if report.alarm == Alarm::Overload => Some(*report),
            _ => None,
        });
        let report = raised.expect("an overload");
        assert_eq!((report.state, report.raised), (AlarmState::Raised, 1));
        Request {
            number: 1,
            order: Order::Acknowledge {
                alarm: report.alarm,
                start: report.start,
                raised: report.raised,
            },
        }
    };
    let answer = |told: &[Payload]| {
        told.iter().find_map(|payload| match payload {
            Payload::Answer(answer) => Some(answer.outcome),
            _ => None,
        })
    };
    let start = |flash| {
        let (mut store, past) = Store::open(flash, IDENTITY, ResetCause::Watchdog);
        while store.step() {}
        (store.into_flash(), monitor(&past))
    };
    let (flash, mut first) = start(Wide::new(2));
    let seen = of_overload(&overload(&mut first, None));
    let (flash, mut second) = start(flash);
    let told = overload(&mut second, Some(seen));
    assert_eq!(answer(&told), Some(AnswerCode::NoSuchOccurrence));
    let judged = second.judgement().alarm(Alarm::Overload);
    assert_eq!(judged.state(), AlarmState::Raised);
    // What this start has told of is taken.
    let (_, mut third) = start(flash);
    let seen = Request {
        order: Order::Acknowledge {
            alarm: Alarm::Overload,
            start: 3,
            raised: 1,
        },
        ..seen
    };
    let told = overload(&mut third, Some(seen));
    assert_eq!(of_overload(&told), seen);
    assert_eq!(answer(&told), Some(AnswerCode::Done));
    let judged = third.judgement().alarm(Alarm::Overload);
    assert_eq!(judged.state(), AlarmState::Acknowledged);
}

#[test]
fn without_a_memory_the_monitor_says_so() {
    let monitor: Monitor<1, 16> = Monitor::new(&SINGLE, &SETTINGS);
    assert_eq!(monitor.health().retention, RetentionReport::default());
    let (mut store, past) = Store::open(Words::new(0), IDENTITY, ResetCause::Watchdog);
    let start = (past.start.boots, past.start.cause);
    assert_eq!(start, (0, ResetCause::Watchdog));
    assert_eq!((past.life, past.start.alarms), NOTHING);
    assert_eq!(store.report(), RetentionReport::default());
    assert!(!store.step() && !store.power_fails(0, &Judgement::default(), &Life::NEW, None));
}

#[test]
fn estimates_of_the_probes_are_kept_with_the_spindle() {
    let mut board = Board::start(Words::new(2));
    assert_eq!(board.found.estimates, None);
    assert_eq!(board.store.report().estimates, Recovery::Blank);
    board.stand(1);
    let before = board.records().0;
    let mut taught = taught();
    board.estimates = taught.kept();
    board.stand(1);
    board.stand(1);
    assert_eq!(board.records().0, before + 1);
    let board = Board::start(board.off());
    assert_eq!(board.found.estimates, taught.kept());
    assert_eq!(board.store.report().estimates, Recovery::Recovered);
    let mut found = Estimator::<2>::new(&SETTINGS_OF_PROBES, &Constants::USUAL);
    found.restore(&board.found.estimates.unwrap());
    assert!(found.is_commissioned() && found.steps() == taught.steps());
    assert!((found.preload().value - taught.preload().value).abs() < 1e-3);
    assert!((found.gain(1).value - taught.gain(1).value).abs() < 1e-3);
    // Opened as by a surprise.
    let error = found.preload_change().error;
    assert!(error > 0.15 && error < 0.16, "{error}");
    // They are the same from start to start, and not another spindle's.
    let kept = board.found.estimates;
    let mut board = board;
    board.stand(1);
    let flash = board.off();
    let board = Board::start(flash.clone());
    assert_eq!(board.found.estimates, kept);
    let other = Board::start_as(flash, Identity::of(7005, 26));
    assert_eq!(other.found.estimates, None);
    assert_eq!(other.store.report().estimates, Recovery::OtherSpindle);
}
