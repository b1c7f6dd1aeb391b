//! Telemetry without a board: a recording, solved by the host's own solver and sent as a monitor would.
//!
//! The estimates and balls are real, and so are the limits that they pass. What takes a board is left at
//! zero: doubts, cycles, overruns.

use anyhow::Result;
use spindle_bearing::monitor::judgement::{Alarm, AlarmState};
use spindle_bearing::monitor::plausibility::Marks;
use spindle_bearing::monitor::telemetry::{
    AlarmChange, AlarmReport, BALLS_PER_FRAME, BallReport, BallsReport, EstimateReport,
    HealthReport, Outbox, Payload,
};
use spindle_bearing::{Bearing, Settings, Solver, Speed};
use spindle_bearing::{Design, Limit, Limits};

use crate::loads::LoadRow;

/// Ball count of the simulated bearing.
pub const BALLS: usize = 16;

/// Peak pressure that raises the alarm, and what the pressure must sink below for it to clear, Pa.
const PRESSURE: [f32; 2] = [1.6e9, 1.5e9];

/// One alarm by a limit, with hysteresis and acknowledged by nobody.
#[derive(Default)]
struct Watch {
    state: AlarmState,
    raised: u32,
    cleared: u32,
}

impl Watch {
    fn look(&mut self, value: f32, ball: u16) -> Option<AlarmReport> {
        let [raise, clear] = PRESSURE;
        let change = match self.state {
            AlarmState::Clear | AlarmState::Latched if value > raise => {
                self.state = AlarmState::Raised;
                self.raised += 1;
                AlarmChange::Raised
            }
            AlarmState::Raised if value < clear => {
                self.state = AlarmState::Latched;
                self.cleared += 1;
                AlarmChange::Cleared
            }
            _ => return None,
        };
        Some(AlarmReport {
            alarm: Alarm::PeakPressure,
            change,
            state: self.state,
            value,
            limit: raise,
            ball: Some(ball),
            raised: self.raised,
            cleared: self.cleared,
        })
    }
}

/// The bytes that a monitor would send for a recording. Estimates and balls go out for every row,
/// counters for every hundredth.
///
/// # Errors
///
/// The bearing cannot be built.
pub fn stream(design: &Design, rows: &[LoadRow]) -> Result<Vec<u8>> {
    let bearing = Bearing::<f32, BALLS>::new(design)?;
    let mut solver = Solver::new(&bearing);
    // No limit but this one, so that whatever is hardest pressed is named.
    let limits = Limits {
        peak_pressure: 0.0,
        ..Limits::default()
    };
    let allowed = Limits {
        peak_pressure: PRESSURE[0],
        ..Limits::default()
    };
    let mut outbox = Outbox::<16>::new();
    let mut bytes = Vec::new();
    let mut health = HealthReport::default();
    let mut watch = Watch::default();
    let mut turns = 0.0;
    let mut before = None;
    for row in rows {
        let time_us = (row.time_s * 1e6).round() as u64;
        let load = row.load.map(|x| x as f32);
        let speed = Speed::rpm(row.speed_rpm as f32);
        turns += row.speed_rpm / 60.0 * (row.time_s - before.unwrap_or(row.time_s));
        before = Some(row.time_s);
        health.ticks += 1;
        health.revolutions = turns as u64;
        match solver.solve(load, speed, &Settings::default()) {
            Err(_) => health.refusals += 1,
            Ok(solution) => {
                health.estimates += 1;
                let k = solution.stiffness();
                let forces = || solution.inner_forces();
                let passed = solution.exceedances(&allowed);
                let report = EstimateReport {
                    age: 0,
                    marks: Marks::NONE,
                    load,
                    speed: speed.as_rad_per_s(),
                    displacement: solution.displacement,
                    stiffness: core::array::from_fn(|i| k[i][i]),
                    coupling: k[0][1],
                    coupling_row: 0,
                    coupling_column: 1,
                    least_force: forces().fold(f32::INFINITY, f32::min),
                    largest_force: forces().fold(0.0, f32::max),
                    status: (&solution.status).into(),
                    iterations: solution.iterations,
                    error: [
                        solution.error.displacement,
                        solution.error.force,
                        solution.error.stiffness,
                    ],
                    limits: passed
                        .iter()
                        .fold(0, |bits, passed| bits | 1 << passed.limit as u8),
                };
                outbox.post(time_us, Payload::Estimate(report));
                let balls: Vec<BallReport> = solution
                    .balls()
                    .map(|ball| BallReport {
                        q_i: ball.q_i,
                        q_o: ball.q_o,
                        alpha_i: ball.alpha_i,
                        alpha_o: ball.alpha_o,
                    })
                    .collect();
                for (i, some) in balls.chunks(BALLS_PER_FRAME).enumerate() {
                    let report = BallsReport {
                        first: (i * BALLS_PER_FRAME) as u16,
                        count: BALLS as u16,
                        first_azimuth: design.first_ball as f32,
                        balls: some.iter().copied().collect(),
                    };
                    outbox.post(time_us, Payload::Balls(report));
                }
                let worst = solution.exceedances(&limits).get(Limit::PeakPressure);
                if let Some(worst) = worst
                    && let Some(report) = watch.look(worst.value, worst.ball)
                {
                    health.alarms_raised = watch.raised.into();
                    health.alarms_cleared = watch.cleared.into();
                    outbox.post(time_us, Payload::Alarm(report));
                }
            }
        }
        if health.ticks.is_multiple_of(100) {
            outbox.post(time_us, Payload::Health(health));
        }
        bytes.extend(core::iter::from_fn(|| outbox.next_byte()));
    }
    Ok(bytes)
}
