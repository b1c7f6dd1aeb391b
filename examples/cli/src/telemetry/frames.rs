//! Frames of telemetry to test with, and what they amount to.

use super::decoder::Decoder;
use super::state::State;
use spindle_bearing::{Frequencies, Status};
use spindle_monitor::Alarm;
use spindle_monitor::Marks;
use spindle_monitor::TemperatureSource;
use spindle_monitor::judgement::{AlarmChange, AlarmState};
use spindle_monitor::telemetry::{
    AlarmReport, BALLS_PER_FRAME, BallReport, BallsReport, EstimateReport, Frame, HealthReport,
    HelloReport, MOST_ROWS, Payload, ROWS_PER_FRAME, RowPlace, RowReport, RowsReport, ShaftReport,
    VERSION, encode,
};

/// An estimate with this axial stiffness at the nose, N/m.
pub fn estimate(stiffness: f32) -> EstimateReport {
    EstimateReport {
        age: 0,
        marks: Marks::new(),
        load: [250.0, 120.0, -40.0, 0.2, 0.1],
        speed: 1256.6,
        displacement: [1e-5, 2e-6, -1e-6, 1e-5, -2e-5],
        stiffness: [stiffness, 0.5 * stiffness, 0.6 * stiffness, 8e3, 9e3],
        coupling: 1e6,
        coupling_row: 0,
        coupling_column: 1,
        least_force: 10.0,
        largest_force: 90.0,
        status: Status::Converged,
        iterations: 2,
        error: [1e-6, 1e-6, 1e-5],
        limits: 0,
    }
}

/// Counters after a second.
pub fn health() -> HealthReport {
    HealthReport {
        ticks: 1000,
        estimates: 990,
        ..HealthReport::default()
    }
}

/// A change of an alarm.
pub fn alarm(alarm: Alarm, change: AlarmChange, state: AlarmState) -> AlarmReport {
    AlarmReport {
        alarm,
        change,
        state,
        value: 0.25,
        limit: 0.2,
        place: None,
        start: 7,
        raised: 1,
        cleared: 0,
    }
}

/// A frame with this number.
pub fn frame(sequence: u32, payload: Payload) -> Frame {
    Frame {
        version: VERSION,
        sequence,
        time_us: u64::from(sequence) * 1000,
        payload,
    }
}

/// The bytes of frames.
pub fn stream(frames: &[Frame]) -> Vec<u8> {
    frames.iter().flat_map(encode).collect()
}

/// Takes the frames one after the other.
pub fn note(state: &mut State, decoder: &mut Decoder, frames: &[Frame]) {
    for byte in stream(frames) {
        if let Some(event) = decoder.push(byte) {
            state.note(&event, decoder.tally());
        }
    }
}

/// The state after frames with these payloads.
pub fn state_of(payloads: impl IntoIterator<Item = Payload>) -> State {
    let frames = (0..).zip(payloads);
    let frames: Vec<_> = frames.map(|(i, payload)| frame(i, payload)).collect();
    let mut state = State::default();
    note(&mut state, &mut Decoder::new(), &frames);
    assert_eq!(state.tally.frames, frames.len() as u64);
    state
}

/// The balls of a row with these forces on both races.
pub fn balls(row: u8, forces: &[f32]) -> Vec<Payload> {
    let ball = |force: &f32| BallReport {
        q_i: *force,
        q_o: *force,
        alpha_i: 0.3,
        alpha_o: 0.25,
    };
    let chunks = forces.chunks(BALLS_PER_FRAME).enumerate();
    let payloads = chunks.map(|(i, some)| {
        Payload::Balls(BallsReport {
            row,
            first: (i * BALLS_PER_FRAME) as u16,
            count: forces.len() as u16,
            first_azimuth: 0.0,
            balls: some.iter().map(ball).collect(),
        })
    });
    payloads.collect()
}

/// Rows with these axial forces, of which so much is preload.
pub fn rows(axial: &[f32], preload: f32) -> Vec<Payload> {
    let mut frequencies = Frequencies::default();
    (frequencies.cage, frequencies.ball) = (83.4, 532.0);
    (frequencies.outer_race, frequencies.inner_race) = (1334.0, 1866.0);
    let row = |axial: &f32| RowReport {
        axial: *axial,
        radial: [30.0, -40.0],
        preload,
        least_force: 12.0,
        largest_force: 95.0,
        frequencies,
    };
    let chunks = axial.chunks(ROWS_PER_FRAME).enumerate();
    let payloads = chunks.map(|(i, some)| {
        Payload::Rows(RowsReport {
            first: (i * ROWS_PER_FRAME) as u8,
            count: axial.len() as u8,
            rows: some.iter().map(row).collect(),
        })
    });
    payloads.collect()
}

/// A shaft with rows at these positions (m), some of them mirrored, and so many balls each.
pub fn shaft(places: &[(f32, bool, u16)]) -> Payload {
    let rows = places.iter().take(MOST_ROWS);
    let shaft = ShaftReport {
        nose: 0.09,
        loads_at: 0.12,
        preload: 250.0,
        count: places.len() as u8,
        rows: rows
            .map(|(position, mirrored, balls)| RowPlace {
                position: *position,
                mirrored: *mirrored,
                balls: *balls,
            })
            .collect(),
    };
    Payload::Hello(HelloReport {
        shaft,
        ..HelloReport::default()
    })
}

/// All that a pair in back-to-back arrangement says.
pub fn pair() -> Vec<Payload> {
    let force = |i: usize| 60.0 + 30.0 * (0.4 * i as f32).cos();
    let mut payloads = vec![
        shaft(&[(-0.02, false, 16), (0.02, true, 18)]),
        Payload::Estimate(estimate(6.1e7)),
        Payload::Health(HealthReport {
            temperatures: [41.2, 36.5],
            temperature_sources: [TemperatureSource::Measured, TemperatureSource::Held],
            ..health()
        }),
    ];
    payloads.extend(rows(&[412.0, 244.0], 244.0));
    payloads.extend(balls(0, &core::array::from_fn::<_, 16, _>(force)));
    payloads.extend(balls(
        1,
        &core::array::from_fn::<_, 18, _>(|i| 0.6 * force(i)),
    ));
    payloads
}
