//! The recorded cycle, a row a tick, with the shipped settings.

use super::monitor::Rig;
use files::recordings::LoadRow;
use host_tests::milling_cycle::{CRASH, DRILLING, Place, recorded};
use host_tests::telemetry::simulated::monitor_settings::MONITOR;
use host_tests::telemetry::simulated::monitored::ROWS;
use spindle_bearing::monitor::baseline::BANDS;
use spindle_bearing::monitor::judgement::AlarmChange;
use spindle_bearing::monitor::learning::Learning;
use spindle_bearing::monitor::loads::LoadSample;
use spindle_bearing::monitor::{Alarm, AlarmState, Mark, Marks, Outcome, Readings};

/// A tick with a row of the recording, which carries the speed.
fn tick(rig: &mut Rig<ROWS>, row: &LoadRow) -> Outcome {
    rig.tick(&Readings {
        loads: Ok(Some(LoadSample {
            time_us: rig.time_us,
            load: row.load.map(|load| load as f32),
            speed: Some(row.omega() as f32),
            residual: 0.0,
            doubts: Marks::NONE,
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
fn nearly_every_tick_of_the_cycle_has_a_fresh_estimate_and_its_crash_is_the_only_alarm() {
    let mut rig = Rig::shipped();
    let (mut plausible, mut stale, mut raised) = (0, Vec::new(), Vec::new());
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
            assert_eq!(outcome.marks, Mark::Range.into());
            assert!(is_within(row.time_s, CRASH));
            continue;
        }
        // What is real is not doubted.
        let unsolved = Mark::Unsolved.into();
        assert!(outcome.marks.is_empty() || outcome.marks == unsolved);
        plausible += 1;
        if outcome.age != Some(0) || !outcome.marks.is_empty() {
            stale.push(row.time_s);
        }
    }
    assert!(stale.len() * 1000 <= plausible, "of {plausible}: {stale:?}");
    assert_eq!(raised, [Alarm::PeakPressure, Alarm::Overload]);
    assert_eq!(rig.state(Alarm::PeakPressure), AlarmState::Clear);
}

/// Once with the baseline being learnt, and once against it.
#[test]
fn drilling_in_the_cycle_neither_teaches_the_baseline_nor_is_lost_preload() {
    let rows = recorded(Place::Nose);
    let mut rig = Rig::shipped();
    rig.monitor.learn(true);
    let idling = &MONITOR.judgement.baseline;
    let band = |row: &LoadRow| (row.omega() as f32 / idling.band_width) as usize;
    let (mut idle, mut drilling) = ([0; BANDS], 0);
    for row in &rows {
        let outcome = tick(&mut rig, row);
        let [fx, fy, fz, my, mz] = row.load.map(|load| load as f32);
        let [low, high] = idling.idle_axial;
        let idles = (low..=high).contains(&fx)
            && fy.hypot(fz) <= idling.idle_radial
            && my.hypot(mz) <= idling.idle_moment;
        if idles && outcome.solved {
            idle[band(row)] += 1;
        }
        if is_within(row.time_s, DRILLING) && fx > 380.0 {
            assert!(outcome.solved && !idles, "{row:?}");
            drilling += 1;
        }
    }
    rig.monitor.learn(false);
    assert!(drilling > 900, "{drilling}");
    assert_eq!(rig.monitor.health().learning.state, Learning::Taken);
    let baseline = *rig.monitor.judgement().baseline();
    // Bands with too little keep what they had, nothing.
    let enough = idle.map(|count| {
        if count < idling.least_estimates {
            0
        } else {
            count
        }
    });
    assert_eq!(baseline.estimates, enough);
    let is_drilling = |row: &&LoadRow| is_within(row.time_s, DRILLING);
    assert!(
        rows.iter()
            .filter(is_drilling)
            .all(|row| enough[band(row)] > 0)
    );
    for row in &rows {
        tick(&mut rig, row);
        // The spindle without a tool has less preload, but not for long.
        let state = rig.state(Alarm::StiffnessLoss);
        let is_possible = match state {
            AlarmState::Clear => true,
            state => state == AlarmState::Pending && !is_drilling(&row),
        };
        assert!(is_possible, "{state:?} at {}", row.time_s);
    }
}
