//! The recorded cycle, a row a tick, with the shipped settings.

use cli::milling_cycle::{CRASH, Place, recorded};
use cli::telemetry::simulated::MONITOR;
use mock::rig::Rig;
use spindle_file::loads::LoadRow;
use spindle_firmware::spindle::{ROWS, SPINDLE};
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::LoadSample;
use spindle_monitor::{Alarm, AlarmState, Mark, Marks, Outcome, Readings};

/// A tick with a row of the recording, which carries the speed.
fn tick(rig: &mut Rig<ROWS, ROWS>, row: &LoadRow) -> Outcome {
    rig.tick(&Readings {
        loads: Ok(Some(LoadSample {
            time_us: rig.time_us,
            load: row.load.map(|load| load as f32),
            speed: Some(row.omega() as f32),
            residual: 0.0,
            doubts: Marks::new(),
        })),
        speed: None,
        temperatures: row.temperatures.map(|read| read.map(|t| t as f32)),
    })
}

fn is_within(time: f64, [start, end]: [f64; 2]) -> bool {
    time >= start && time <= end
}

/// The crash is an overload and too high a pressure, and nothing else is an alarm.
#[test]
fn every_tick_of_the_cycle_has_an_estimate_of_seven_ticks_at_most_and_its_crash_is_the_only_alarm()
{
    let mut rig = Rig::of(&SPINDLE, &MONITOR, [0.0; 5]);
    let (mut stale, mut raised) = (Vec::new(), Vec::new());
    for row in recorded(Place::Nose) {
        // Somebody sees to it in the next second.
        if rig.time_us == 10_300_000 {
            for alarm in [Alarm::PeakPressure, Alarm::Overload] {
                assert_eq!(rig.state(alarm), AlarmState::Latched);
                rig.monitor.acknowledge(rig.time_us, alarm);
            }
        }
        let outcome = tick(&mut rig, &row);
        for change in &outcome.changes {
            if change.change == AlarmChange::Raised {
                assert!(is_within(row.time_s, CRASH), "{change:?} at {}", row.time_s);
                raised.push(change.alarm);
            }
        }
        let mut loads = row.load.iter().zip(&MONITOR.plausibility.load);
        if !loads.all(|(load, [low, high])| (*low..=*high).contains(&(*load as f32))) {
            assert_eq!(outcome.marks, Mark::Range);
            assert!(is_within(row.time_s, CRASH));
            continue;
        }
        // What is real is not doubted. The first estimate takes some ticks.
        if row.time_s < 0.01 && outcome.marks == Mark::NoEstimate {
            continue;
        }
        assert!(outcome.marks.is_empty(), "{}", outcome.marks);
        let is_old = outcome.age.is_none_or(|age| age > 7) && !is_within(row.time_s, CRASH);
        if is_old {
            stale.push((row.time_s, outcome.age));
        }
    }
    assert!(stale.is_empty(), "{stale:?}");
    assert_eq!(raised, [Alarm::PeakPressure, Alarm::Overload]);
    assert_eq!(rig.state(Alarm::PeakPressure), AlarmState::Clear);
}
