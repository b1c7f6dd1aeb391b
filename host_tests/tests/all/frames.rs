//! Frames of telemetry to test with, and what they amount to.

use host_tests::telemetry::decoder::Decoder;
use host_tests::telemetry::state::State;
use spindle_bearing::monitor::Marks;
use spindle_bearing::monitor::TemperatureSource;
use spindle_bearing::monitor::judgement::{Alarm, AlarmChange, AlarmState};
use spindle_bearing::monitor::telemetry::{
    AlarmReport, BALLS_PER_FRAME, BallReport, BallsReport, EstimateReport, Frame, HealthReport,
    InputsReport, Payload, ROWS_PER_FRAME, RowPlace, RowReport, RowsReport, ShaftReport,
    StatusCode, VERSION, encode,
};

pub fn estimate(stiffness: f32) -> EstimateReport {
    EstimateReport {
        age: 0,
        marks: Marks::NONE,
        load: [250.0, 120.0, -40.0, 0.2, 0.1],
        speed: 1256.6,
        displacement: [1e-5, 2e-6, -1e-6, 1e-5, -2e-5],
        stiffness: [stiffness, 4.0 * stiffness, 4.5 * stiffness, 8e3, 9e3],
        nose: [stiffness, 0.5 * stiffness, 0.6 * stiffness],
        coupling: 1e6,
        coupling_row: 0,
        coupling_column: 1,
        least_force: 10.0,
        largest_force: 90.0,
        status: StatusCode::Converged,
        iterations: 2,
        error: [1e-6, 1e-6, 1e-5],
        limits: 0,
    }
}

pub fn health() -> HealthReport {
    HealthReport {
        ticks: 1000,
        estimates: 990,
        ..HealthReport::default()
    }
}

pub fn alarm(alarm: Alarm, change: AlarmChange, state: AlarmState) -> AlarmReport {
    AlarmReport {
        alarm,
        change,
        state,
        value: 0.25,
        limit: 0.2,
        ball: None,
        raised: 1,
        cleared: 0,
    }
}

pub fn frame(sequence: u32, payload: Payload) -> Frame {
    Frame {
        version: VERSION,
        sequence,
        time_us: u64::from(sequence) * 1000,
        payload,
    }
}

pub fn stream(frames: &[Frame]) -> Vec<u8> {
    frames.iter().flat_map(encode).collect()
}

pub fn state_of(payloads: impl IntoIterator<Item = Payload>) -> State {
    let frames: Vec<_> = (0..)
        .zip(payloads)
        .map(|(i, payload)| frame(i, payload))
        .collect();
    let mut decoder = Decoder::new();
    let mut state = State::default();
    for byte in stream(&frames) {
        if let Some(event) = decoder.push(byte) {
            state.note(&event, decoder.tally());
        }
    }
    assert_eq!(state.tally.frames, frames.len() as u64);
    state
}

pub fn balls(forces: &[f32]) -> Vec<Payload> {
    balls_of(0, forces)
}

pub fn balls_of(row: u8, forces: &[f32]) -> Vec<Payload> {
    let chunks = forces.chunks(BALLS_PER_FRAME).enumerate();
    let payloads = chunks.map(|(i, some)| {
        Payload::Balls(BallsReport {
            row,
            first: (i * BALLS_PER_FRAME) as u16,
            count: forces.len() as u16,
            first_azimuth: 0.0,
            balls: some
                .iter()
                .map(|q_i| BallReport {
                    q_i: *q_i,
                    q_o: *q_i,
                    alpha_i: 0.3,
                    alpha_o: 0.25,
                })
                .collect(),
        })
    });
    payloads.collect()
}

/// Rows with these axial forces, of which so much is preload.
pub fn rows(axial: &[f32], preload: f32) -> Vec<Payload> {
    let chunks = axial.chunks(ROWS_PER_FRAME).enumerate();
    let payloads = chunks.map(|(i, some)| {
        Payload::Rows(RowsReport {
            first: (i * ROWS_PER_FRAME) as u8,
            count: axial.len() as u8,
            rows: some
                .iter()
                .map(|axial| RowReport {
                    axial: *axial,
                    radial: [30.0, -40.0],
                    preload,
                    least_force: 12.0,
                    largest_force: 95.0,
                })
                .collect(),
        })
    });
    payloads.collect()
}

/// A shaft with rows at these positions (m), some of them mirrored, and so many balls each.
pub fn shaft(places: &[(f32, bool, u16)]) -> Payload {
    let rows = places.iter().take(ROWS_PER_FRAME);
    Payload::Shaft(ShaftReport {
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
    })
}

/// All that a pair in back-to-back arrangement says.
pub fn pair() -> Vec<Payload> {
    let force = |i: u16| 60.0 + 30.0 * (0.4 * f32::from(i)).cos();
    let mut payloads = vec![
        shaft(&[(-0.02, false, 16), (0.02, true, 18)]),
        Payload::Estimate(estimate(6.1e7)),
        inputs([TemperatureSource::Measured, TemperatureSource::Held]),
    ];
    payloads.extend(rows(&[412.0, 244.0], 244.0));
    payloads.extend(balls_of(
        0,
        &core::array::from_fn::<_, 16, _>(|i| force(i as u16)),
    ));
    payloads.extend(balls_of(
        1,
        &core::array::from_fn::<_, 18, _>(|i| 0.6 * force(i as u16)),
    ));
    payloads
}

pub fn inputs(temperature_sources: [TemperatureSource; 2]) -> Payload {
    Payload::Inputs(InputsReport {
        temperatures: [41.2, 36.5],
        temperature_sources,
        ..InputsReport::default()
    })
}
