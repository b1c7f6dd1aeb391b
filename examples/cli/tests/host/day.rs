//! The monitor for a day.

use cli::milling_cycle::{Place, recorded};
use mock::rig::{Counter, Dog, SINGLE, settings};
use spindle_monitor::loads::LoadSample;
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::telemetry::{FrameReader, Payload};
use spindle_monitor::tick::Widened;
use spindle_monitor::{Marks, Monitor, Readings};

/// Sampled once a second; telemetry a little every minute.
static DAY: MonitorSettings = {
    let mut settings = settings(60);
    settings.plausibility.missing_after_us = 2_000_000;
    settings.plausibility.fresh_us = 2_000_000;
    settings.telemetry.estimate_us = 10_000_000;
    settings.telemetry.balls_us = 60_000_000;
    settings.telemetry.health_us = 60_000_000;
    settings
};
const _: () = assert!(DAY.check().is_ok());

/// 86.4 million ticks of the recorded milling cycle, over and over: 24 hours at 1 kHz. Both timers start
/// just before they wrap; the one of microseconds does so twenty times.
#[test]
fn a_day_passes_without_drift_or_overflow() {
    const TICKS: u64 = 86_400_000;
    // A sample every 10 ms, and 20 s in all: the monitor sees one of each second.
    let rows: Vec<LoadSample> = recorded(Place::Bearing)
        .iter()
        .step_by(10)
        .take(2000)
        .map(|row| LoadSample {
            time_us: 0,
            load: row.load.map(|x| x as f32),
            speed: Some(row.omega() as f32),
            residual: 0.0,
            doubts: Marks::new(),
        })
        .collect();
    let per_cycle: f64 = rows
        .iter()
        .step_by(100)
        .map(|row| f64::from(row.speed.unwrap()))
        .sum::<f64>()
        / std::f64::consts::TAU;

    let mut monitor: Monitor<1, 16> = Monitor::new(&SINGLE, &DAY);
    monitor.outbox().number_from(u32::MAX - 100);
    let (mut counter, mut dog) = (Counter::default(), Dog::default());
    let mut reader = FrameReader::new();
    let start = u32::MAX - 7_000_000;
    let mut clock = Widened::new(32, start);
    let (mut frames, mut sequence, mut last_us) = (0_u64, u32::MAX - 101, 0);
    let (mut used, mut seen): (Vec<f32>, Vec<[f32; 5]>) = (Vec::new(), Vec::new());
    let mut readings = Readings {
        loads: Ok(None),
        speed: None,
        temperatures: None,
    };
    for i in 0..TICKS {
        let time_us = clock.at(start.wrapping_add((i as u32).wrapping_mul(1000)));
        readings.loads = Ok((i % 1000 == 0).then(|| rows[(i / 10 % 2000) as usize]));
        let outcome = monitor.tick(time_us, &readings, &mut counter, &mut dog);
        if i >= 1000 {
            assert!(outcome.marks.is_empty(), "{i}: {}", outcome.marks);
        }
        while let Some(byte) = monitor.outbox().next_byte() {
            let Some(frame) = reader.push(byte) else {
                continue;
            };
            let frame = frame.unwrap();
            frames += 1;
            sequence = sequence.wrapping_add(1);
            assert_eq!(frame.sequence, sequence);
            if matches!(frame.payload, Payload::Balls(_)) {
                // A picture is sent by four balls a tick, from the sample's on.
                assert!((i - 10..=i).contains(&(frame.time_us / 1000)));
            } else {
                assert!(frame.time_us >= last_us && frame.time_us == i * 1000);
                last_us = frame.time_us;
            }
            // The same second of the cycle, once an hour.
            if let Payload::Estimate(report) = frame.payload
                && i % 3_600_000 / 10_000 == 5
            {
                seen.push(report.stiffness);
                used.push(monitor.life().used());
            }
        }
    }
    let health = monitor.health();
    assert_eq!((health.ticks, dog.fed), (TICKS, TICKS));
    assert_eq!(
        (health.overruns, health.missed_ticks, health.frames_dropped),
        (0, 0, 0)
    );
    assert_eq!((health.estimates, health.refusals), (86_400, 0));
    // Estimates and their rows come every ten seconds. A picture of four frames, a health report and a hello come every
    // minute.
    let reports = 6 * 1440;
    assert!((17_278..=17_282).contains(&(frames - reports)), "{frames}");
    // No drift: the same cycle gives the same stiffness, and takes the same part of the life.
    assert_eq!(seen.len(), 24);
    for k in &seen {
        for (k, first) in k.iter().zip(&seen[0]) {
            assert!((k / first - 1.0).abs() < 1e-5, "{seen:?}");
        }
    }
    let hour = used[1] - used[0];
    for pair in used.windows(2) {
        assert!(((pair[1] - pair[0]) / hour - 1.0).abs() < 2e-3, "{used:?}");
    }
    let revolutions = per_cycle * 4320.0;
    assert!(
        (health.revolutions as f64 / revolutions - 1.0).abs() < 1e-5,
        "{revolutions}"
    );
}
