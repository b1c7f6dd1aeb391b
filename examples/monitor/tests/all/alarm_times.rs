//! Times after which alarms are raised and cleared, with levels as often as they come.

use super::shipped::shipped;
use super::spindle::MONITOR;
use mock::rig::{IDLE, Rig, at_speed, settings};
use spindle_monitor::alarms::Threshold;
use spindle_monitor::judgement::{AlarmChange, AlarmMachine, Level};
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::{Alarm, AlarmState, Mark, Readings, TemperatureSource};

/// Intervals at which levels of an alarm come, us, by the time in which the next one is due.
fn intervals(alarm: Alarm) -> &'static [u64] {
    match MONITOR.due_us(alarm) {
        // Of estimates: a solve takes a tick, or four, or nine.
        20_000 => &[1000, 4000, 9000],
        // Of samples: a sender may be slower than ticks.
        50_000 => &[1000, 10_000, 40_000],
        // Of ticks, some of which a busy board leaves out, and of seconds.
        1_000_000 => &[1000, 24_000, 1_000_000],
        // Of blocks of the probes' readings, at 1200 rpm and more, at 60 rpm, at 30 rpm.
        _ => &[50_000, 1_000_000, 2_000_000],
    }
}

#[test]
fn every_alarm_is_raised_after_its_hold_time_and_cleared_after_four_of_them() {
    for (alarm, hold_ms) in Alarm::ALL
        .into_iter()
        .flat_map(|alarm| [3, 500, 5000, 60_000].map(|hold_ms| (alarm, hold_ms)))
    {
        for interval in intervals(alarm) {
            let threshold = Threshold {
                hold_us: hold_ms * 1000,
                ..MONITOR.alarms[alarm as usize]
            };
            let hold_us = u64::from(threshold.hold_us);
            let above = Level::of(2.0 * threshold.raise - threshold.clear);
            let below = Level::of(threshold.clear);
            let mut machine = AlarmMachine::default();
            let mut time_us = 77_000;
            // Time from the first of these levels to the change.
            let mut after = |level, expected| {
                let began_us = time_us + interval;
                for _ in 0..1_000_000 {
                    time_us += interval;
                    let due_us = MONITOR.due_us(alarm);
                    if let Some(change) = machine.update(time_us, level, &threshold, due_us) {
                        assert_eq!(change, expected, "{alarm}");
                        return time_us - began_us;
                    }
                }
                panic!("{alarm} is never {expected:?}")
            };
            let raised_us = after(above, AlarmChange::Raised);
            let cleared_us = after(below, AlarmChange::Cleared);
            for (us, exact) in [(raised_us, hold_us), (cleared_us, 4 * hold_us)] {
                assert!(
                    us.abs_diff(exact) <= *interval,
                    "{alarm}, held for {hold_ms} ms, levels {interval} us apart: {us} us, not {exact}"
                );
            }
        }
    }
}

#[test]
fn a_blind_monitor_is_told_after_the_hold_time_of_availability() {
    static HELD: MonitorSettings = {
        let mut settings = settings(10);
        settings.alarms[Alarm::Availability as usize].hold_us = 5_000_000;
        settings
    };
    let mut rig = Rig::running(&HELD);
    let began_us = rig.time_us;
    while !rig
        .happened
        .contains(&(Alarm::Availability, AlarmChange::Raised))
    {
        rig.run(1, IDLE);
        rig.tick(&at_speed(Err(Mark::Corrupt.into())));
        assert!(rig.time_us - began_us < 20_000_000);
    }
    // The first whole second without estimates ends one to two seconds after they fail.
    let after_us = rig.time_us - began_us;
    assert!((5_000_000..=7_100_000).contains(&after_us), "{after_us}");
}

/// A tick of the shipped spindle with these temperatures, degrees Celsius.
fn tick(rig: &mut Rig<2, 2>, temperatures: [f32; 2]) {
    let readings = rig.spoilt(|_| ());
    rig.tick(&Readings {
        temperatures: Some(temperatures),
        ..readings
    });
}

/// The sensor of either side fails, or repeats its value while the other side warms up by 0.5 K/s.
#[test]
fn a_temperature_that_is_lost_or_stuck_raises_its_alarm() {
    for (side, is_stuck) in [(0, false), (1, false), (0, true), (1, true)] {
        let mut rig = shipped().run_up();
        let mut reading = [24.0, 22.0];
        for _ in 0..2000 {
            tick(&mut rig, reading);
        }
        let began_us = rig.time_us;
        while rig.state(Alarm::Temperature) != AlarmState::Raised {
            let seconds = (rig.time_us - began_us) as f32 * 1e-6;
            if is_stuck {
                reading[1 - side] = [24.0, 22.0][1 - side] + 0.5 * seconds;
            } else {
                reading[side] = f32::NAN;
            }
            tick(&mut rig, reading);
            assert!(seconds < 20.0, "{side} {is_stuck}");
        }
        // After 5 s without a good value, of which a stuck sensor has the first until the other side has moved by 5 K.
        let after = (rig.time_us - began_us) as f32 * 1e-6;
        let exact = if is_stuck { 15.0 } else { 5.0 };
        assert!((after - exact).abs() < 0.05, "{side} {is_stuck}: {after}");
        let health = rig.monitor.health();
        assert_eq!(health.temperature_sources[side], TemperatureSource::Held);
        assert_eq!(
            health.temperature_sources[1 - side],
            TemperatureSource::Measured
        );
        // It comes back.
        reading[side] = [24.5, 22.5][side];
        for _ in 0..100 {
            tick(&mut rig, reading);
        }
        assert_eq!(rig.state(Alarm::Temperature), AlarmState::Latched);
    }
}

/// Wrong for a tenth of a second after the start: 100 and 65 degrees Celsius on a cold spindle.
#[test]
fn temperatures_that_start_wrong_raise_no_alarm() {
    let mut rig = shipped();
    for ms in 0..3000 {
        let speed = 1500.0 * (ms as f32 / 1000.0).min(1.0);
        let readings = rig.idling_at(Some(speed));
        let reading = if ms < 100 {
            [100.0, 65.0]
        } else {
            [24.0, 22.0]
        };
        rig.tick(&Readings {
            temperatures: Some(reading),
            ..readings
        });
    }
    assert_eq!(rig.monitor.health().temperatures, [24.0, 22.0]);
    for alarm in [
        Alarm::PreloadGrowth,
        Alarm::PeakPressure,
        Alarm::Temperature,
    ] {
        assert_eq!(rig.state(alarm), AlarmState::Clear, "{alarm}");
    }
}
