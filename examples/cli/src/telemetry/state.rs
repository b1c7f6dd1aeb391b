//! State of the spindle by the frames so far.

use super::decoder::{Event, Gap, Tally};
use spindle_bearing::Facing;
use spindle_monitor::Alarm;
use spindle_monitor::board::BoardReport;
use spindle_monitor::command::{Answer, Order};
use spindle_monitor::estimator::Estimate;
use spindle_monitor::framing::FrameError;
use spindle_monitor::judgement::AlarmState;
use spindle_monitor::retained::StartReport;
use spindle_monitor::telemetry::{
    AlarmReport, BallReport, BallsReport, EstimateReport, Frame, HealthReport, Payload,
    ProbesReport, RowPlace, RowReport, ShaftReport,
};
use std::collections::VecDeque;

/// Estimates that are kept for the course over time: a minute at a hundred a second.
pub const HISTORY: usize = 6000;

/// An estimate's place in the course over time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Time of the monitor, s.
    pub time: f64,
    /// Stiffness at the nose, N/m and N m/rad.
    pub stiffness: [f32; 5],
    /// Preload ([`State::preload`]).
    pub preload: Option<Estimate>,
    /// The sample behind it was good, and it was solved: the estimate is none of an earlier tick.
    pub trusted: bool,
}

/// The balls of a row as they are known.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Balls {
    /// Azimuth of ball 0, rad from +y towards +z.
    pub first_azimuth: f32,
    /// One for each ball of the row; `None` before its first report.
    pub balls: Vec<Option<BallReport>>,
}

impl Balls {
    /// Azimuth of a ball, rad from +y towards +z.
    pub fn azimuth(&self, index: usize) -> f64 {
        let turn = index as f64 / self.balls.len().max(1) as f64;
        f64::from(self.first_azimuth) + core::f64::consts::TAU * turn
    }
}

/// How a row faces.
pub const fn facing(place: &RowPlace) -> Facing {
    if place.mirrored {
        Facing::MinusX
    } else {
        Facing::PlusX
    }
}

/// Age of an estimate up to which it is fresh, in ticks: a solve may take some.
pub const FRESH: u32 = 20;

/// An order in a few words.
pub fn words(order: &Order) -> String {
    match order {
        Order::Acknowledge {
            alarm,
            start,
            raised,
        } => format!("acknowledge {alarm}, occurrence {raised} of start {start}"),
        Order::ReplaceBearing => "take the bearing for a new one".into(),
        Order::ShaftStands => "believe that the shaft stands".into(),
        Order::Commission => "count changes of the preload from now on".into(),
    }
}

/// The last report of each kind, and the course of stiffness and preload.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// Latest time of any frame, us.
    pub time_us: u64,
    /// The course of stiffness and preload.
    pub history: VecDeque<Point>,
    /// The last estimate.
    pub estimate: Option<EstimateReport>,
    /// The balls, row by row.
    pub balls: Vec<Balls>,
    /// The last report of each row; `None` before its first one.
    pub rows: Vec<Option<RowReport>>,
    /// The last report on the probes.
    pub probes: Option<ProbesReport>,
    /// The last counters.
    pub health: Option<HealthReport>,
    /// This start of the monitor.
    pub start: Option<StartReport>,
    /// The board on itself.
    pub board: Option<BoardReport>,
    /// Places of the rows and of the nose on the shaft.
    pub shaft: Option<ShaftReport>,
    /// The last report of each alarm, in the order of [`Alarm::ALL`], and the time of its last change, us.
    pub alarms: [Option<(u64, AlarmReport)>; Alarm::COUNT],
    /// The last answer to an order.
    pub answer: Option<Answer>,
    /// Counts of the decoder.
    pub tally: Tally,
    /// The last damage.
    pub last_damage: Option<FrameError>,
    /// The last frame whose number went back: the first one of a new start, if that goes on.
    pub behind: Option<Frame>,
    /// The last message to the board, or from it.
    pub said: Option<String>,
}

impl State {
    /// Takes an event and the counts after it.
    pub fn note(&mut self, event: &Event, tally: Tally) {
        self.tally = tally;
        match event {
            Event::Damaged(error) => self.last_damage = Some(*error),
            Event::Frame { frame, gap } => match gap {
                Gap::Behind => self.behind = Some(frame.clone()),
                Gap::Restart => {
                    // Time, counters and alarms begin again.
                    let before = std::mem::take(self);
                    self.tally = tally;
                    self.last_damage = before.last_damage;
                    self.said = before.said;
                    for frame in before.behind.iter().chain([frame]) {
                        self.take(frame);
                    }
                }
                Gap::None | Gap::Lost(_) => self.take(frame),
            },
        }
    }

    /// Takes a frame's content.
    fn take(&mut self, frame: &Frame) {
        let time_us = frame.time_us;
        self.time_us = self.time_us.max(time_us);
        match &frame.payload {
            Payload::Estimate(report) => {
                self.estimate = Some(*report);
                if self.history.len() == HISTORY {
                    self.history.pop_front();
                }
                self.history.push_back(Point {
                    time: time_us as f64 * 1e-6,
                    stiffness: report.stiffness,
                    preload: self.preload(),
                    trusted: report.age <= FRESH && report.marks.is_empty(),
                });
            }
            Payload::Balls(report) => self.take_balls(report),
            Payload::Rows(report) => {
                self.rows.resize(report.count.into(), None);
                let places = self.rows.iter_mut().skip(report.first.into());
                for (place, report) in places.zip(&report.rows) {
                    *place = Some(*report);
                }
            }
            Payload::Alarm(report) => {
                let place = &mut self.alarms[report.alarm as usize];
                // A report that repeats how the alarm stands keeps the time of the last change.
                let since = match place {
                    Some((since, old))
                        if (old.state, old.raised) == (report.state, report.raised) =>
                    {
                        *since
                    }
                    _ => time_us,
                };
                *place = Some((since, *report));
            }
            Payload::Health(report) => self.health = Some(*report),
            Payload::Probes(report) => self.probes = Some(report.clone()),
            Payload::Answer(answer) => {
                let (order, outcome) = (words(&answer.order), answer.outcome.name());
                self.said = Some(format!("board: {order}: {outcome}"));
                self.answer = Some(*answer);
            }
            Payload::Hello(report) => {
                (self.start, self.board) = (Some(report.start), Some(report.board));
                self.shaft = Some(report.shaft.clone());
            }
        }
    }

    fn take_balls(&mut self, report: &BallsReport) {
        let (row, count) = (usize::from(report.row), usize::from(report.count));
        if self.balls.len() <= row {
            self.balls.resize_with(row + 1, Balls::default);
        }
        let known = &mut self.balls[row];
        if known.balls.len() != count {
            known.balls = vec![None; count];
        }
        known.first_azimuth = report.first_azimuth;
        let places = known.balls.iter_mut().skip(report.first.into());
        for (place, ball) in places.zip(&report.balls) {
            *place = Some(*ball);
        }
    }

    /// Number of rows, as far as it is known; 0 before the first report of any.
    pub fn row_count(&self) -> usize {
        let told = self.shaft.as_ref().map_or(0, |shaft| shaft.count.into());
        self.rows.len().max(self.balls.len()).max(told)
    }

    /// Number of the balls of a row.
    fn ball_count(&self, row: usize) -> Option<usize> {
        match self.balls.get(row).map(|row| row.balls.len()) {
            Some(count) if count > 0 => Some(count),
            _ => Some(self.shaft.as_ref()?.rows.get(row)?.balls.into()),
        }
    }

    /// Row, and ball of that row, of a ball that is counted on from row to row, as alarms do. `None` as long as too
    /// few rows are known.
    pub fn row_and_ball(&self, ball: u16) -> Option<(usize, usize)> {
        let mut rest = usize::from(ball);
        for row in 0..self.row_count() {
            let count = self.ball_count(row)?;
            if rest < count {
                return Some((row, rest));
            }
            rest -= count;
        }
        None
    }

    /// Whether rows face each other, so that they hold each other with a preload.
    pub fn is_opposed(&self) -> bool {
        let is_shared = self.rows.iter().flatten().any(|row| row.preload > 0.0);
        is_shared
            || self.shaft.as_ref().is_some_and(|shaft| {
                let mut rows = shaft.rows.iter();
                let first = rows.next();
                rows.any(|row| Some(row.mirrored) != first.map(|first| first.mirrored))
            })
    }

    /// The preload, N: as the probes have measured it; without probes as it is computed, without an error, of the row with the least. None
    /// without rows that face each other.
    pub fn preload(&self) -> Option<Estimate> {
        if let Some(report) = &self.probes {
            return report.preload;
        }
        let rows = self.rows.iter().flatten().filter(|_| self.is_opposed());
        let least = rows.map(|row| row.preload).reduce(f32::min)?;
        Some(Estimate {
            value: least,
            error: 0.0,
        })
    }

    /// Whether a row has lost the preload that it had from the others.
    pub fn is_lifted(&self, row: usize) -> bool {
        let report = self.rows.get(row).copied().flatten();
        // No number is no preload either.
        self.is_opposed() && report.is_some_and(|report| !(report.axial > 0.0))
    }

    /// Alarms that stand or want attention, with the time of their last change.
    /// Alarms that are clear, or pending for their hold time, are left out.
    pub fn standing(&self) -> impl Iterator<Item = &(u64, AlarmReport)> {
        let alarms = self.alarms.iter().flatten();
        alarms.filter(|(_, of)| !matches!(of.state, AlarmState::Clear | AlarmState::Pending))
    }

    /// Alarms that nobody has acknowledged.
    pub fn unacknowledged(&self) -> usize {
        let alarms = self.standing();
        alarms
            .filter(|(_, of)| of.state != AlarmState::Acknowledged)
            .count()
    }
}
