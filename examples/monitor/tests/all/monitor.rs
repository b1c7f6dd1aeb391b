//! The monitor under faults.

use super::shipped::{at_nose, shipped};
use super::spindle::{MONITOR, SPINDLE};
use mock::rig::{B7005C, BEARING, IDLE, Rig, SETTINGS, SINGLE, SPEED, at_speed, settings};
use spindle_bearing::{RacewayControlFree, Settings, Solver, Speed, SpindleSolver};
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::{FramedLoads, LoadSource};
use spindle_monitor::record::{self, LoadRecord};
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::{Alarm, AlarmState, Mark, Marks, Monitor, Readings};
use std::array;
use std::ops::Range;

/// One pass fits into a tick.
static TIGHT: MonitorSettings = settings(1);
const _: () = assert!(SETTINGS.check().is_ok() && TIGHT.check().is_ok());
const _: () = assert!(TIGHT.tick.has_time(1, 16));

fn assert_near(what: &str, reported: f32, own: f32, within: f32) {
    assert!(
        (reported - own).abs() < within,
        "{what}: {reported}, not {own}"
    );
}

/// Solves the loads by itself, and compares the reported stiffness.
fn assert_stiffness(reported: [f32; 5], load: [f32; 5], within: f32) {
    let mut solver = SpindleSolver::new();
    let speed = Speed::rad_per_s(SPEED);
    let own = solver
        .solve(&SINGLE, load, speed, &Settings::default())
        .unwrap();
    let compliance = own.compliance_at(0.0);
    for (i, k) in reported.iter().enumerate() {
        assert_near("stiffness", k * compliance[i][i], 1.0, within);
    }
}

/// The housing gives way: less preload is left than the rings are ground for.
#[test]
fn preloads_are_held_against_those_of_the_mounted_spindle() {
    let mut rig = shipped().run_up();
    rig.run(100, [0.0; 5]);
    let warm = rig.host.rows.iter().map(|row| row.preload);
    let warm = warm.fold(0.0, f32::max);
    let growth = rig.monitor.judgement().alarm(Alarm::PreloadGrowth);
    let growth = growth.level().value;
    let mut solver = SpindleSolver::<f32, 2, 16, RacewayControlFree, 5, 2>::of();
    let (cold, settings) = (Speed::rad_per_s(0.0), Settings::default());
    let mounted = solver.solve(&SPINDLE, [0.0; 5], cold, &settings).unwrap();
    for row in mounted.rows() {
        assert_near("cold", row.preload(), 225.0, 2.0);
        assert_near("growth", warm / row.preload() / growth, 1.0, 0.01);
    }
}

/// Warm, loaded at the nose: reports of rows and nose are as by the spindle's own solver.
#[test]
fn the_estimate_of_a_pair_is_its_spindles_own() {
    let mut rig = shipped();
    let temperatures = [31.0, 26.0];
    for ms in 0..3000 {
        let speed = SPEED * (ms as f32 / 1000.0).min(1.0);
        let ramp = ((ms as f32 - 2000.0) / 200.0).clamp(0.0, 1.0);
        let sample = rig.sample(at_nose([300.0, 400.0, -250.0]).map(|load| load * ramp));
        rig.tick(&Readings {
            loads: Ok(Some(sample)),
            speed: Some(Some(speed)),
            temperatures: Some(temperatures),
        });
    }
    let (_, report) = *rig.host.estimates.last().unwrap();
    assert_eq!(rig.host.rows.len(), 2);

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
    let mut solver = SpindleSolver::new();
    let at = Speed::rad_per_s(report.speed).with_growth(growth);
    let own = solver
        .solve(&SPINDLE, report.load, at, &Settings::default())
        .unwrap();

    let nose = own.compliance_at(0.0);
    for (i, &k) in report.stiffness.iter().enumerate() {
        assert_near("nose", k * nose[i][i], 1.0, 2e-3);
    }
    for i in 0..3 {
        let displacements = (report.displacement[i], own.displacement[i]);
        assert_near("displacement", displacements.0, displacements.1, 2e-8);
    }
    for (report, row) in rig.host.rows.iter().zip(own.rows()) {
        let size = row.force[0];
        let largest = row.inner_forces().fold(0.0, f32::max);
        let least = row.inner_forces().fold(f32::INFINITY, f32::min);
        for (what, reported, own, size) in [
            ("axial", report.axial, row.force[0], size),
            ("radial", report.radial[0], row.force[1], size),
            ("radial", report.radial[1], row.force[2], size),
            ("preload", report.preload, row.preload(), size),
            ("largest force", report.largest_force, largest, largest),
            ("least force", report.least_force, least, largest),
        ] {
            assert_near(what, reported, own, 2e-3 * size);
        }
        let (told, own) = (report.frequencies, row.frequencies());
        for (what, told, own) in [
            ("cage", told.cage, own.cage),
            ("ball", told.ball, own.ball),
            ("inner race", told.inner_race, own.inner_race),
            ("outer race", told.outer_race, own.outer_race),
        ] {
            assert_near(what, told / own, 1.0, 1e-5);
        }
    }
}

#[test]
fn the_estimate_is_the_solvers_own() {
    let mut rig = Rig::running(&SETTINGS);
    for _ in 0..300 {
        let outcome = rig.good(IDLE, SPEED);
        assert!(outcome.solved && outcome.age == Some(0));
    }
    let (time, _) = *rig.host.estimates.last().unwrap();
    assert!(rig.time_us - time <= 20_000);
    assert_stiffness(rig.stiffness(), IDLE, 1e-3);
    let mut solver = Solver::new();
    let own = solver
        .solve(
            &BEARING,
            IDLE,
            Speed::rad_per_s(SPEED),
            &Settings::default(),
        )
        .unwrap();
    assert_eq!(rig.host.balls.len(), 16);
    for (report, ball) in rig.host.balls.iter().zip(own.balls()) {
        for (what, reported, own) in [
            ("Qi", report.q_i, ball.q_i),
            ("Qo", report.q_o, ball.q_o),
            ("alpha_i", report.alpha_i, ball.alpha_i),
            ("alpha_o", report.alpha_o, ball.alpha_o),
        ] {
            assert_near(what, reported / own, 1.0, 5e-3);
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
    ("bus error", |_| at_speed(Err(Mark::Bus.into())), Mark::Bus),
    ("nameless error", |_| at_speed(Err(Marks::new())), Mark::Bus),
    (
        "not a number",
        |rig| rig.spoilt(|s| s.load[2] = f32::NAN),
        Mark::NotFinite,
    ),
    (
        "infinite",
        |rig| rig.spoilt(|s| s.load[4] = f32::INFINITY),
        Mark::NotFinite,
    ),
    (
        "out of range",
        |rig| rig.spoilt(|s| s.load[0] = 1e7),
        Mark::Range,
    ),
    ("spike", |rig| rig.spoilt(|s| s.load[1] = 9e3), Mark::Rate),
    (
        "converter at its rail",
        |rig| rig.spoilt(|s| s.doubts = Mark::Saturated.into()),
        Mark::Saturated,
    ),
    ("speed lost", |rig| rig.idling_at(None), Mark::SpeedMissing),
    (
        "speed not a number",
        |rig| rig.idling_at(Some(f32::NAN)),
        Mark::SpeedMissing,
    ),
    (
        "speed jumps",
        |rig| rig.idling_at(Some(0.5 * SPEED)),
        Mark::SpeedRate,
    ),
];

#[test]
fn every_fault_has_its_mark_and_passes_and_one_that_lasts_raises_the_sensor_alarm() {
    for (name, fault, mark) in FAULTS {
        let mut rig = Rig::running(&SETTINGS);
        let before = rig.monitor.health();
        for age in 1..=5 {
            let readings = fault(&mut rig);
            let outcome = rig.tick(&readings);
            assert!(outcome.marks.contains(mark), "{name}: {}", outcome.marks);
            assert_eq!(outcome.age, Some(age), "{name}");
        }
        let outcome = rig.good(IDLE, SPEED);
        assert!(outcome.solved && outcome.marks.is_empty(), "{name}");
        let after = rig.monitor.health();
        assert_eq!(after.marked_samples - before.marked_samples, 5, "{name}");
        assert_eq!(after.estimates - before.estimates, 1, "{name}");
        assert_eq!(rig.state(Alarm::Sensor), AlarmState::Clear, "{name}");

        for _ in 0..120 {
            let readings = fault(&mut rig);
            rig.tick(&readings);
        }
        rig.run(500, IDLE);
        // These two are believed after a while: they may be true.
        if ["spike", "speed jumps"].contains(&name) {
            continue;
        }
        let raised = (Alarm::Sensor, AlarmChange::Raised);
        assert!(rig.happened.contains(&raised), "{name}");
        assert_eq!(rig.state(Alarm::Sensor), AlarmState::Latched, "{name}");
        rig.monitor.acknowledge(rig.time_us, Alarm::Sensor);
        assert_eq!(rig.state(Alarm::Sensor), AlarmState::Clear, "{name}");
    }
}

#[test]
fn silence_is_missing_after_its_time_and_only_then() {
    let mut rig = Rig::running(&SETTINGS);
    for ms in 1..200 {
        let outcome = rig.tick(&at_speed(Ok(None)));
        assert_eq!(outcome.marks.contains(Mark::Missing), ms > 50, "{ms}");
        assert_eq!(outcome.age, Some(ms));
    }
    assert_eq!(rig.state(Alarm::Sensor), AlarmState::Raised);
}

#[test]
fn two_speeds_that_disagree_are_both_doubted() {
    let mut rig = Rig::running(&SETTINGS);
    for (other, doubted) in [(SPEED, false), (SPEED + 35.0, false), (SPEED - 45.0, true)] {
        let readings = rig.spoilt(|sample| sample.speed = Some(other));
        let outcome = rig.tick(&readings);
        let disagree = outcome.marks.contains(Mark::SpeedDisagreement);
        assert_eq!((disagree, outcome.solved), (doubted, !doubted), "{other}");
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
    for settings in [&SETTINGS, &TIGHT] {
        let mut rig = Rig::new(settings);
        rig.link = 4;
        rig = rig.run_up();
        let mut lasting = None;
        for i in 0..30_000 {
            // One fault in a while lasts.
            if i % 200 == 0 {
                lasting = (random(3) == 0).then(|| random(12));
            }
            rig.counter.cost = random(2 * u64::from(settings.tick.deadline_cycles)) as u32;
            let readings = match lasting.unwrap_or(random(40)) {
                which @ 0..10 => FAULTS[which as usize].1(&mut rig),
                10 => {
                    let mut bits = || f32::from_bits(random(1 << 32) as u32);
                    let load = array::from_fn(|_| bits());
                    Readings {
                        speed: Some(Some(bits())),
                        ..rig.spoilt(|sample| sample.load = load)
                    }
                }
                11 => at_speed(Ok(None)),
                _ => rig.spoilt(|sample| {
                    sample.load[0] += random(900) as f32;
                    sample.load[1] += random(300) as f32;
                    sample.load[4] += random(3) as f32;
                }),
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
        rig.run(3000, IDLE);
        assert!(rig.good(IDLE, SPEED).solved);
    }
}

#[test]
fn a_load_step_is_doubted_then_believed_then_solved_within_the_budget_of_its_ticks() {
    let mut rig = Rig::running(&TIGHT);
    let step = [900.0, 300.0, -150.0, 1.0, 2.0];
    let solved: Vec<_> = (0..400).map(|_| rig.good(step, SPEED).solved).collect();
    let first = solved.iter().position(|solved| *solved);
    assert!(first.is_some_and(|ms| ms < 100), "{first:?}");
    assert_stiffness(rig.stiffness(), step, 2e-3);
}

/// From one end of the range to the other, at 400 half-ranges in a second. A sensor that jumps and stays is believed, too.
#[test]
fn a_jump_across_the_range_is_doubted_for_five_milliseconds_by_default() {
    static DEFAULT: MonitorSettings = MonitorSettings::new(&B7005C, 16);
    let mut rig = Rig::running(&DEFAULT);
    let [_, most] = DEFAULT.plausibility.load[1];
    let mut doubted = 0;
    for part in [-0.95, 0.95] {
        doubted = 0;
        for _ in 0..50 {
            let readings = rig.spoilt(|sample| sample.load[1] = part * most);
            let marks = rig.tick(&readings).marks;
            doubted += u32::from(marks.contains(Mark::Rate));
        }
    }
    assert!((4..=5).contains(&doubted), "{doubted}");
}

#[test]
fn loads_without_an_equilibrium_are_refused_with_a_mark_and_cost_nothing_later() {
    let mut rig = Rig::running(&TIGHT);
    let before = rig.monitor.health();
    // Without any load the ring floats.
    for _ in 0..300 {
        let readings = rig.spoilt(|sample| sample.load = [0.0; 5]);
        assert!(!rig.tick(&readings).solved);
    }
    let after = rig.monitor.health();
    assert!(after.refusals - before.refusals >= 99, "{after:?}");
    assert_eq!(after.estimates, before.estimates);
    assert!(rig.marks.last().unwrap().contains(Mark::Unsolved));
    rig.run(1000, IDLE);
    let raised = (Alarm::Availability, AlarmChange::Raised);
    assert!(rig.happened.contains(&raised));
    assert!(rig.good(IDLE, SPEED).solved);
}

#[test]
fn without_a_prepared_start_the_first_ticks_solve_from_nothing() {
    let mut rig = Rig::new(&TIGHT);
    rig.monitor = Monitor::new(&SINGLE, &TIGHT);
    let outcome = rig.tick(&at_speed(Ok(None)));
    assert!(outcome.marks.contains(Mark::NoEstimate));
    assert!(rig.host.estimates.is_empty());
    let solved = (1..=20).find(|_| rig.good(IDLE, SPEED).solved);
    assert!(solved.is_some_and(|tick| tick > 1), "{solved:?}");
    assert!(rig.good(IDLE, SPEED).marks.is_empty());
}

#[test]
fn overruns_are_counted_and_raise_their_alarm() {
    let mut rig = Rig::running(&SETTINGS);
    let deadline = SETTINGS.tick.deadline_cycles;
    for (cost, ticks) in [(deadline + 1, 12), (deadline, 3000)] {
        rig.counter.cost = cost;
        for _ in 0..ticks {
            assert_eq!(rig.good(IDLE, SPEED).overrun, cost > deadline);
        }
    }
    let health = rig.monitor.health();
    assert_eq!((health.overruns, health.most_cycles), (12, deadline + 1));
    assert_eq!(rig.state(Alarm::Deadline), AlarmState::Latched);
}

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

const fn numbered(sequence: u32, time_ms: u32) -> LoadRecord {
    LoadRecord {
        sequence,
        time_ms,
        ..RECORD
    }
}

/// Of records that arrive at these ms, this range has the mark and no other record has any. `counts`
/// are the numbers of disordered, lost and late records.
fn assert_doubted(
    records: impl Iterator<Item = (u64, LoadRecord)>,
    range: Range<usize>,
    mark: Mark,
    counts: [u64; 3],
) {
    let mut source = FramedLoads::new();
    for (i, (ms, record)) in records.enumerate() {
        for byte in record::encode(&record) {
            source.push(byte);
        }
        let marks = match source.sample(1000 * ms) {
            Ok(sample) => sample.map_or(Marks::new(), |sample| sample.doubts),
            Err(marks) => marks,
        };
        let expected = range.contains(&i).then_some(mark);
        assert_eq!(marks, expected.map_or(Marks::new(), Marks::from), "{i}");
    }
    let counted = source.counts();
    assert_eq!([counted.disordered, counted.lost, counted.late], counts);
}

/// From the tenth second on, the five seconds before it again and again, or their very records once more.
#[test]
fn a_stretch_of_records_that_comes_again_is_out_of_order_all_along() {
    let again = (10_000..30_000).map(|ms| (ms, 5000 + ms % 5000));
    let records = (0..10_000).map(|ms| (ms, ms)).chain(again);
    let records = records.map(|(ms, n)| (u64::from(ms), numbered(n, n)));
    assert_doubted(records, 10_000..30_000, Mark::Order, [20_000, 0, 0]);
}

#[test]
fn a_sender_that_begins_anew_is_believed_from_its_second_record_on() {
    // It takes a second to start, and its clock begins with it.
    let first = (0..5000).map(|ms| (u64::from(ms), numbered(700 + ms, 90_000 + ms)));
    let again = (0..5000).map(|ms| (u64::from(6000 + ms), numbered(ms, ms)));
    assert_doubted(first.chain(again), 5000..5001, Mark::Order, [1, 0, 0]);
}

/// After 35 days at a record a millisecond, the nearer way to 0 is ahead.
#[test]
fn a_sender_that_begins_anew_after_many_records_is_believed_from_its_second_record_on() {
    let first = (0..5000).map(|ms| (u64::from(ms), numbered(3_000_000_000 + ms, 90_000 + ms)));
    let again = (0..5000).map(|ms| (u64::from(6000 + ms), numbered(ms, ms)));
    assert_doubted(first.chain(again), 5000..5001, Mark::Order, [1, 0, 0]);
}

/// An old record among those of a sender without a clock is one doubt; today's numbers go on. A true restart is believed after
/// the 50 ms in which none was in order.
#[test]
fn a_sender_without_a_clock_restarts_only_where_no_record_of_it_is_in_order() {
    for old in [0, 5, 2900] {
        let records = (0..20_000).map(|ms| {
            let sequence = if ms == 3000 { old } else { ms };
            (u64::from(ms), numbered(sequence, 0))
        });
        assert_doubted(records, 3000..3001, Mark::Order, [1, 1, 0]);
    }
    let first = (0..5000).map(|ms| (u64::from(ms), numbered(ms, 0)));
    let again = (0..5000).map(|ms| (u64::from(5000 + ms), numbered(ms, 0)));
    assert_doubted(first.chain(again), 5000..5050, Mark::Order, [50, 0, 0]);
    // What was kept for a minute is no restart: no sender has got so far since.
    let first = (0..100_000).map(|ms| (u64::from(ms), numbered(ms, 0)));
    let kept = (0..1000).map(|ms| (u64::from(100_060 + ms), numbered(40_000 + ms, 0)));
    assert_doubted(
        first.chain(kept),
        100_000..101_000,
        Mark::Order,
        [1000, 0, 0],
    );
}

/// One frame of another sender, whose number is far ahead, does not shut the true one out.
#[test]
fn a_number_that_no_sender_gets_to_is_out_of_order() {
    let records = (0..3000).map(|ms| {
        let sequence = if ms == 1000 { 2_000_000_000 } else { ms };
        (u64::from(ms), numbered(sequence, ms))
    });
    assert_doubted(records, 1000..1001, Mark::Order, [1, 1, 0]);
}

/// A gateway stops for ten seconds, and then hands on what it has kept, in order and at its pace.
#[test]
fn records_that_come_ten_seconds_late_are_marked_and_counted() {
    let records = (0..10_000_u32).map(|n| {
        let late = if n < 5000 { 0 } else { 10_000 };
        (u64::from(n + late), numbered(n, n + 1))
    });
    assert_doubted(records, 5000..10_000, Mark::Late, [0, 0, 5000]);
}

/// A record of a minute later, the first, the second or any: it is late itself, and no other one but the next.
#[test]
fn one_wrong_time_makes_no_other_record_late() {
    let with_wrong = |wrong: u32| {
        (0..10_000_u32).map(move |n| {
            let ahead = if n == wrong { 60_000 } else { 0 };
            (u64::from(n), numbered(n, n + 1 + ahead))
        })
    };
    // The first one is believed, and then the other ones.
    assert_doubted(with_wrong(0), 1..2, Mark::Late, [0, 0, 1]);
    for wrong in [1, 2, 5000] {
        let range = wrong as usize..wrong as usize + 1;
        assert_doubted(with_wrong(wrong), range, Mark::Late, [0, 0, 1]);
    }
    // A clock that was set is believed after 50 ms.
    let set = (0..10_000_u32).map(|n| {
        let ahead = if n < 5000 { 0 } else { 60_000 };
        (u64::from(n), numbered(n, n + 1 + ahead))
    });
    assert_doubted(set, 5000..5050, Mark::Late, [0, 0, 50]);
}

/// An hour with clocks that part by 100 millionths, records 0 to 15 ms under way, across the wrap of the sender's clock.
#[test]
fn clocks_that_part_and_a_line_that_dawdles_make_no_record_late() {
    for drift in [-100, 0, 100] {
        let records = (0..180_000_i64).map(|n| {
            let ms = 20 * n;
            let sent = ((ms + ms * drift / 1_000_000) as u32).wrapping_sub(1_000_000);
            ((100 + ms + 7 * n % 16) as u64, numbered(n as u32, sent))
        });
        assert_doubted(records, 0..0, Mark::Late, [0; 3]);
    }
}

#[test]
fn a_speed_that_is_frozen_at_its_source_is_doubted_and_a_standstill_is_not() {
    static WATCHED: MonitorSettings = {
        let mut settings = settings(10);
        settings.plausibility.speed_stuck_after = 1000;
        settings
    };
    let mut rig = Rig::new(&WATCHED);
    for _ in 0..5000 {
        assert!(rig.good(IDLE, 0.0).marks.is_empty());
    }
    rig = rig.run_up();
    for tick in 0..5000 {
        // A tachometer's last digit moves.
        let speed = SPEED + 1e-3 * (tick % 7) as f32;
        assert!(rig.good(IDLE, speed).marks.is_empty());
    }
    rig.run(1000, IDLE);
    assert_eq!(rig.good(IDLE, SPEED).marks, Mark::SpeedStuck);
    rig.run(300, IDLE);
    assert_eq!(rig.state(Alarm::Sensor), AlarmState::Raised);
}

#[test]
fn damaged_and_lost_frames_are_counted_and_marked() {
    let mut source = FramedLoads::new();
    // Numbers wrap after the second one.
    let frame = |i: u32| record::encode(&numbered((u32::MAX - 1).wrapping_add(i), 0));
    let mut send = |bytes: &[u8], time| {
        for byte in bytes {
            source.push(*byte);
        }
        (source.sample(time), source.counts())
    };
    let (sample, _) = send(&frame(0), 1);
    assert_eq!(sample.unwrap().unwrap().load, RECORD.load());
    assert_eq!(send(&[], 2).0, Ok(None));
    // Damaged: an error, unless a good one follows in time.
    let mut damaged = frame(1).to_vec();
    damaged[5] ^= 0x10;
    assert_eq!(send(&damaged, 3).0, Err(Mark::Corrupt.into()));
    damaged.extend(frame(2));
    let (sample, counts) = send(&damaged, 4);
    assert!(sample.unwrap().unwrap().doubts.is_empty());
    // One is missing, and then two.
    assert_eq!((counts.corrupt, counts.lost, counts.disordered), (2, 1, 0));
    let (_, counts) = send(&frame(5), 5);
    assert_eq!((counts.received, counts.lost), (3, 3));
    // Twice the same, or an older one, which is no sample and no restart.
    for i in [5, 1] {
        assert_eq!(send(&frame(i), 6).0, Err(Mark::Order.into()));
    }
    let (sample, counts) = send(&frame(6), 7);
    assert!(sample.unwrap().is_some());
    let counts = (counts.disordered, counts.lost, counts.passed_over);
    assert_eq!(counts, (2, 3, 0));
}

/// Memory is what the type has: there is no other.
#[test]
fn a_monitor_is_of_a_fixed_size() {
    const SIZE: [usize; 2] = [
        size_of::<Monitor<1, 16>>(),
        size_of::<Monitor<2, 16, 12, 5, 2>>(),
    ];
    let [one, pair] = SIZE;
    assert!((8_000..17_408).contains(&one), "{one}");
    assert!((one..28_672).contains(&pair), "{pair}");
}
