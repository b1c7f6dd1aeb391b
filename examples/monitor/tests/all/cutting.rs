//! The monitor while it cuts: teeth that pass, overloads, crashes, and faults that leave it blind.

use super::shipped::{at_nose, shipped};
use super::spindle::MONITOR;
use mock::cuts::{Cut, TICKS, cuts, tooth};
use mock::rig::{B7005C, BEARING, IDLE, ON_BEARING, Rig, SETTINGS, SPEED, at_speed};
use spindle_bearing::{
    Arrangement, ElasticSpindle, Facing, Material, Mounted, Preload, Section, Shaft, Spindle,
    Support,
};
use spindle_monitor::board::Check;
use spindle_monitor::command::{AnswerCode, ORDER_EVERY, Order, Request};
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::{Alarm, AlarmState, BoardReport, Mark, Outcome, Readings};

/// Greatest age of the estimate under these loads, in ticks.
fn ages<const R: usize, const E: usize>(rig: Rig<R, E>, load: impl Fn(u32) -> [f32; 5]) -> u32 {
    let mut rig = rig.run_up();
    let mut oldest = 0;
    for tick in 0..TICKS {
        let outcome = rig.good(load(tick), SPEED);
        assert!(outcome.marks.is_empty(), "{}", outcome.marks);
        oldest = oldest.max(outcome.age.unwrap());
    }
    oldest
}

/// Two pairs back to back, where the shipped spindle has two bearings.
static FOUR: ElasticSpindle<'static, f32, 4, 16> = {
    const PRELOAD: Preload<f32> = Preload::Force(200.0);
    const fn row(position: f32, facing: Facing) -> Mounted<'static, f32, 16> {
        Mounted::new(&BEARING, position, facing).with(PRELOAD)
    }
    let rows = [
        row(0.03, Facing::PlusX),
        row(0.045, Facing::PlusX),
        row(0.13, Facing::MinusX),
        row(0.145, Facing::MinusX),
    ];
    static SHAFT: Shaft<f32, 1> = Shaft::<f32, 1>::const_new(
        &[Section {
            from: 0.0,
            to: 0.16,
            outer: 0.025,
            inner: 0.01,
        }],
        &Material::STEEL,
    );
    const SUPPORT: Support<f32> = Support {
        axial: 400e6,
        radial: 300e6,
        tilting: f32::INFINITY,
    };
    Spindle::<f32, 4, 16>::const_new(Arrangement::BackToBack, rows)
        .const_elastic(&SHAFT, [SUPPORT; 4])
};
static OF_FOUR: MonitorSettings<4> = {
    let mut settings = MonitorSettings::new(&B7005C, 16);
    settings.tolerance = MONITOR.tolerance;
    settings.plausibility = MONITOR.plausibility;
    assert!(settings.tick.has_time(4, 16));
    settings
};

/// Of a single bearing, of the shipped pair and of four rows, under a force on the front bearing besides the idling loads.
#[test]
fn estimates_under_passing_teeth_and_ramps_are_a_few_ticks_old_at_most() {
    // Cycles of most rows on the elastic shaft.
    fn counted<const R: usize, const E: usize>(mut rig: Rig<R, E>) -> Rig<R, E> {
        rig.counter.look = 20_000;
        rig
    }
    let old = |Cut { name, force }: Cut| {
        let on_bearing = |tick| {
            let [x, y, z] = force(tick).map(|force| force as f32);
            let [fx, fy, fz, my, mz] = IDLE;
            [fx + x, fy + y, fz + z, my, mz]
        };
        let at_nose = |tick| at_nose(force(tick));
        let oldest = [
            ages(Rig::new(&ON_BEARING), on_bearing),
            ages(counted(shipped()), at_nose),
            ages(shipped(), at_nose),
            ages(counted(Rig::of(&FOUR, &OF_FOUR, [0.0; 5])), at_nose),
        ];
        let most = [1, 3, 8, 7];
        let is_old = oldest.iter().zip(most).any(|(age, most)| *age > most);
        is_old.then_some((name, oldest))
    };
    let old: Vec<_> = cuts().into_iter().filter_map(old).collect();
    assert!(old.is_empty(), "{old:?}");
}

/// A tick under the idling loads and so much more radial load.
fn pressed<const R: usize, const E: usize>(rig: &mut Rig<R, E>, radial: f32) -> Outcome {
    let readings = rig.spoilt(|sample| sample.load[1] += radial);
    rig.tick(&readings)
}

/// Whether the alarm was raised in so many ticks under the load of each.
fn raises<const R: usize, const E: usize>(
    rig: &mut Rig<R, E>,
    alarm: Alarm,
    ticks: u32,
    radial: impl Fn(u32) -> f32,
) -> bool {
    let before = rig.happened.len();
    for tick in 0..ticks {
        pressed(rig, radial(tick));
    }
    rig.happened[before..].contains(&(alarm, AlarmChange::Raised))
}

/// Pressure that every tooth brings again is one alarm, and so is a crash, however short. A load below the limit is none.
#[test]
fn a_pressure_above_the_limit_is_one_alarm() {
    type Radial<'a> = &'a dyn Fn(u32) -> f32;
    let teeth = |tick| (2500.0 * tooth(0.125 * f64::from(tick), 1.0)) as f32;
    // Loads change in several ticks, as the shaft's inertia has them.
    let crash = |tick: u32| match tick {
        0..95 => (600.0 * tick as f32).min(4500.0),
        _ => 0.0,
    };
    let cases: [(u32, Radial, AlarmState); 3] = [
        (1000, &teeth, AlarmState::Raised),
        (600, &crash, AlarmState::Latched),
        (500, &|_| 300.0, AlarmState::Clear),
    ];
    for (ticks, load, state) in cases {
        let mut rig = Rig::running(&SETTINGS);
        let is_alarm = state != AlarmState::Clear;
        assert_eq!(raises(&mut rig, Alarm::PeakPressure, ticks, load), is_alarm);
        assert_eq!(rig.state(Alarm::PeakPressure), state);
        let (raised, _) = rig.monitor.judgement().alarm(Alarm::PeakPressure).counts();
        assert_eq!(raised, u32::from(is_alarm));
    }
}

/// With the shipped settings no load is out of the range of estimates and within the alarm's.
#[test]
fn an_overload_needs_no_equilibrium_but_more_than_a_sample() {
    let bounds = MONITOR.plausibility.load.iter().zip(MONITOR.overload);
    for ([low, high], overload) in bounds {
        assert!(overload <= high.max(-low));
    }
    let mut rig = shipped().run_up();
    let sample = |tick| if tick == 3 { 2e3 } else { 0.0 };
    assert!(!raises(&mut rig, Alarm::Overload, 20, sample));
    assert!(raises(&mut rig, Alarm::Overload, 5, |_| 2e3));
    assert!(!pressed(&mut rig, 2e3).solved);
}

/// PC7 is low from the tick on that raises the alarm, with an estimate or without any, and until somebody has seen it.
#[test]
fn an_overload_takes_pc7_away_within_four_ticks_whatever_the_estimate() {
    for estimated in [true, false] {
        let mut rig = shipped();
        if estimated {
            rig = rig.run_up();
        }
        for tick in 0..10 {
            let outcome = pressed(&mut rig, 2e3);
            // The first tick ends the solve of the last idling one.
            assert!(!outcome.solved || estimated && tick == 0);
            assert_eq!(outcome.age.is_some(), estimated);
            assert_eq!(outcome.outputs.no_alarm, tick < 3, "{tick}");
        }
        for _ in 0..100 {
            assert!(!pressed(&mut rig, 0.0).outputs.no_alarm);
        }
        for alarm in Alarm::ALL {
            rig.monitor.acknowledge(rig.time_us, alarm);
        }
        assert!(pressed(&mut rig, 0.0).outputs.no_alarm);
    }
}

/// Ticks of an idling spindle with a fault that leaves too few estimates.
type Blind = (u32, fn(&mut Rig, u32));

#[test]
fn a_monitor_that_is_blind_says_so() {
    let faults: [Blind; 5] = [
        // Every second sample is bad: no single age is long.
        (6000, |rig, tick| match tick % 2 {
            0 => rig.run(1, IDLE),
            _ => drop(rig.tick(&at_speed(Err(Mark::Corrupt.into())))),
        }),
        // 46 % of the samples are rejected, in no order.
        (5000, |rig, tick| {
            let rejected = tick.wrapping_mul(0x9e37_79b9) >> 16 < 30_147;
            pressed(rig, if rejected { 2e4 } else { 0.0 });
        }),
        // One record in fifty arrives: too often to be missing, too seldom to see.
        (3000, |rig, tick| match tick % 50 {
            0 => rig.run(1, IDLE),
            _ => drop(rig.tick(&at_speed(Ok(None)))),
        }),
        // A board that is kept busy leaves out four ticks of five, or all but one in 24.
        (2000, |rig, _| {
            rig.run(1, IDLE);
            rig.leave_out(4);
        }),
        (2089, |rig, _| {
            rig.run(1, IDLE);
            rig.leave_out(23);
        }),
    ];
    for (i, (ticks, blind)) in faults.into_iter().enumerate() {
        let mut rig = Rig::running(&SETTINGS);
        if i == 0 {
            rig.run(2000, IDLE);
            assert_eq!(rig.monitor.health().availability, 1.0);
        }
        for tick in 0..ticks {
            blind(&mut rig, tick);
        }
        assert_eq!(rig.state(Alarm::Availability), AlarmState::Raised, "{i}");
        let health = rig.monitor.health();
        let second = health.availability;
        match i {
            0 => assert!((second - 0.5).abs() < 0.01),
            2 => assert_eq!(rig.state(Alarm::Sensor), AlarmState::Clear),
            3 => assert!(second < 0.25, "{second}"),
            4 => assert!(health.missed_ticks >= 47_996),
            _ => {}
        }
    }
}

/// A fault of a spindle that runs well, and the output that it takes away: of alarms, or of the monitor.
type Trip = (&'static str, fn(&mut Rig) -> Outcome, [bool; 2]);

/// Ticks of each fault. The monitor is blind after a thousand.
#[test]
fn each_fault_takes_its_output_away_and_none_comes_back_before_it_may() {
    const ALARM: [bool; 2] = [false, true];
    const BOTH: [bool; 2] = [false, false];
    let trips: [Trip; 7] = [
        ("nothing", |rig| rig.good(IDLE, SPEED), [true, true]),
        ("pressure", |rig| pressed(rig, 2500.0), ALARM),
        ("overload", |rig| pressed(rig, 2e4), BOTH),
        ("no loads", |rig| rig.tick(&at_speed(Ok(None))), BOTH),
        (
            "bus",
            |rig| rig.tick(&at_speed(Err(Mark::Bus.into()))),
            BOTH,
        ),
        (
            "no speed",
            |rig| {
                let readings = rig.spoilt(|_| ());
                rig.tick(&Readings {
                    speed: Some(None),
                    ..readings
                })
            },
            BOTH,
        ),
        (
            "floating ring",
            |rig| {
                let readings = rig.spoilt(|sample| sample.load = [0.0; 5]);
                rig.tick(&readings)
            },
            BOTH,
        ),
    ];
    let outputs = |outcome: Outcome| [outcome.outputs.no_alarm, outcome.outputs.monitored];
    for (name, trip, expected) in trips {
        let mut rig = Rig::running(&SETTINGS);
        assert_eq!(outputs(rig.good(IDLE, SPEED)), [true; 2], "{name}");
        for _ in 0..990 {
            let [_, monitored] = outputs(trip(&mut rig));
            assert!(monitored, "{name}");
        }
        for _ in 0..110 {
            trip(&mut rig);
        }
        assert_eq!(outputs(trip(&mut rig)), expected, "{name}");
        for _ in 0..3000 {
            rig.good(IDLE, SPEED);
        }
        // An alarm stands until somebody has seen it.
        assert_eq!(
            outputs(rig.good(IDLE, SPEED)),
            [expected[0], true],
            "{name}"
        );
        for alarm in Alarm::ALL {
            rig.monitor.acknowledge(rig.time_us, alarm);
        }
        assert_eq!(outputs(rig.good(IDLE, SPEED)), [true; 2], "{name}");
    }
    // Before the first estimate, and on a board that is broken.
    let mut rig = Rig::new(&SETTINGS);
    assert_eq!(outputs(rig.tick(&at_speed(Ok(None)))), [true, false]);
    let mut rig = Rig::running(&SETTINGS);
    rig.monitor.set_board(BoardReport {
        image: Check::Failed,
        ..BoardReport::NONE
    });
    assert_eq!(outputs(rig.good(IDLE, SPEED)), [true, false]);
}

/// Outcome of an order.
fn ask(rig: &mut Rig, order: Order, service: bool) -> AnswerCode {
    let request = Request { number: 7, order };
    // Asked for once more, it is answered alike.
    rig.monitor.ask(&request, service);
    rig.monitor.ask(&request, service);
    rig.run(2 * ORDER_EVERY as u32, rig.idle);
    let answers: Vec<_> = rig.host.answers.drain(..).collect();
    let [first, again] = answers[..] else {
        panic!("{answers:?}");
    };
    assert_eq!(first, again);
    assert_eq!((first.number, first.order), (7, order));
    first.outcome
}

/// Outcome of an order to take the bearing for a new one, at this speed; whether there is a new life.
fn replace(rig: &mut Rig, speed: f32, service: bool) -> (AnswerCode, bool) {
    let life = rig.monitor.life().kept();
    let outcome = order(rig, Order::ReplaceBearing, speed, service);
    (outcome, rig.monitor.life().kept() < life)
}

/// Outcome of an order at this speed.
fn order(rig: &mut Rig, order: Order, speed: f32, service: bool) -> AnswerCode {
    rig.monitor.ask(&Request { number: 1, order }, service);
    for _ in 0..ORDER_EVERY {
        rig.good(IDLE, speed);
    }
    let [answer] = rig.host.answers.drain(..).collect::<Vec<_>>()[..] else {
        panic!("one answer");
    };
    answer.outcome
}

#[test]
fn a_bearing_is_replaced_at_a_standstill_and_in_service_alone() {
    let mut rig = Rig::running(&SETTINGS);
    let turning = (AnswerCode::NotAtStandstill, false);
    assert_eq!(replace(&mut rig, SPEED, true), turning);
    for ms in 0..1000 {
        rig.good(IDLE, SPEED - SPEED * ms as f32 / 999.0);
    }
    for _ in 0..4900 {
        assert!(rig.good(IDLE, 0.0).marks.is_empty());
    }
    assert_eq!(replace(&mut rig, 0.0, true), turning);
    for _ in 0..100 {
        rig.good(IDLE, 0.0);
    }
    let afar = (AnswerCode::NotInService, false);
    assert_eq!(replace(&mut rig, 0.0, false), afar);
    assert_eq!(replace(&mut rig, 0.0, true), (AnswerCode::Done, true));
}

/// A tachometer that fails reads 0, and so does a control that lost its drive.
#[test]
fn a_speed_that_falls_to_0_faster_than_a_shaft_can_is_not_believed() {
    let mut rig = Rig::running(&SETTINGS);
    let revolutions = rig.monitor.life().revolutions();
    for _ in 0..60_000 {
        let outcome = rig.good(IDLE, 0.0);
        assert_eq!(outcome.marks, Mark::SpeedRate);
    }
    assert_eq!(rig.state(Alarm::Sensor), AlarmState::Raised);
    // The last speed counts.
    let turned = (rig.monitor.life().revolutions() - revolutions) as f32;
    assert!((turned / (60.0 * SPEED / std::f32::consts::TAU) - 1.0).abs() < 1e-3);
    let refused = (AnswerCode::NotAtStandstill, false);
    assert_eq!(replace(&mut rig, 0.0, true), refused);
    // Seen to turn, it is believed.
    rig.run(20, IDLE);
    assert!(rig.good(IDLE, SPEED).marks.is_empty());
    // Lost again, somebody says that it stands.
    rig.good(IDLE, 0.0);
    let stands = Order::ShaftStands;
    assert_eq!(
        order(&mut rig, stands, 0.0, false),
        AnswerCode::NotInService
    );
    assert_eq!(order(&mut rig, stands, 0.0, true), AnswerCode::Done);
    for _ in 0..5000 {
        assert!(rig.good(IDLE, 0.0).marks.is_empty());
    }
    assert_eq!(replace(&mut rig, 0.0, true), (AnswerCode::Done, true));
}

#[test]
fn an_acknowledgement_of_one_occurrence_is_none_of_the_next() {
    let mut rig = Rig::running(&SETTINGS);
    let occur = |rig: &mut Rig| {
        assert!(raises(rig, Alarm::PeakPressure, 300, |_| 2500.0));
        assert!(!raises(rig, Alarm::PeakPressure, 900, |_| 0.0));
        assert_eq!(rig.state(Alarm::PeakPressure), AlarmState::Latched);
    };
    occur(&mut rig);
    occur(&mut rig);
    for (raised, answer, state) in [
        (1, AnswerCode::NoSuchOccurrence, AlarmState::Latched),
        (2, AnswerCode::Done, AlarmState::Clear),
        (2, AnswerCode::Done, AlarmState::Clear),
        (3, AnswerCode::NoSuchOccurrence, AlarmState::Clear),
    ] {
        let alarm = Alarm::PeakPressure;
        let acknowledge = Order::Acknowledge {
            alarm,
            start: 0,
            raised,
        };
        assert_eq!(ask(&mut rig, acknowledge, false), answer);
        assert_eq!(rig.state(alarm), state);
    }
}

/// Orders at two a tick, and a line of 921,600 baud.
#[test]
fn orders_at_any_rate_leave_the_telemetry_its_room() {
    let mut rig = Rig::running(&SETTINGS);
    rig.link = 92;
    rig.host.estimates.clear();
    for _ in 0..4000 {
        forge(&mut rig, 2);
        rig.good(IDLE, SPEED);
    }
    assert!((999..=1001).contains(&rig.host.answers.len()));
    assert!((199..=201).contains(&rig.host.estimates.len()));
    assert_eq!(rig.monitor.health().frames_dropped, 0);
}

/// A shut link holds answers back, and orders with them: none is carried out without an answer.
#[test]
fn no_order_is_carried_out_without_an_answer() {
    let mut rig = Rig::running(&SETTINGS);
    rig.link = 0;
    forge(&mut rig, 100);
    rig.run(100, IDLE);
    rig.link = 4096;
    rig.good(IDLE, SPEED);
    assert_eq!(rig.host.answers.len(), 1);
    rig.run(100, IDLE);
    assert_eq!(rig.host.answers.len(), Alarm::COUNT);
}

/// So many orders of whoever it may be.
fn forge(rig: &mut Rig, count: u16) {
    for number in 0..count {
        let order = Order::ReplaceBearing;
        rig.monitor.ask(&Request { number, order }, true);
    }
}
