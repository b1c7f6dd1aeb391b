//! What the frames so far say of the spindle.

use super::decoder::{Event, Gap, Tally};
use super::operator::answer_words;
use spindle_bearing::Facing;
use spindle_bearing::framing::FrameError;
use spindle_bearing::monitor::BoardReport;
use spindle_bearing::monitor::command::Answer;
use spindle_bearing::monitor::judgement::{Alarm, AlarmState};
use spindle_bearing::monitor::telemetry::{
    AlarmReport, BallReport, EstimateReport, Frame, HealthReport, InputsReport, Payload, RowPlace,
    RowReport, ShaftReport, StartReport,
};
use std::collections::VecDeque;

/// Estimates that are kept for the course over time: a minute at a hundred a second.
pub const HISTORY: usize = 6000;

/// An estimate's place in the course over time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Time of the monitor, s.
    pub time: f64,
    /// Diagonal of the stiffness, N/m and N m/rad.
    pub stiffness: [f32; 5],
    /// The sample behind it was good, and it was solved: the estimate is none of an earlier tick.
    pub trusted: bool,
}

/// A report and when it was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At<T> {
    /// Time of the monitor, us.
    pub time_us: u64,
    /// The report.
    pub report: T,
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

/// What is known.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// Latest time of any frame, us.
    pub time_us: u64,
    /// The course of the stiffness.
    pub history: VecDeque<Point>,
    /// The last estimate.
    pub estimate: Option<At<EstimateReport>>,
    /// The balls, row by row.
    pub balls: Vec<Balls>,
    /// The last report of each row; `None` before its first one.
    pub rows: Vec<Option<At<RowReport>>>,
    /// What stands where on the shaft.
    pub shaft: Option<At<ShaftReport>>,
    /// The last report of each alarm, in the order of [`Alarm::ALL`].
    pub alarms: [Option<At<AlarmReport>>; Alarm::COUNT],
    /// The last counters.
    pub health: Option<At<HealthReport>>,
    /// The last report of what came in.
    pub inputs: Option<At<InputsReport>>,
    /// The last answer to an order.
    pub answer: Option<At<Answer>>,
    /// The nonce that the board told last.
    pub nonce: Option<u32>,
    /// What the board last said of itself.
    pub board: Option<At<BoardReport>>,
    /// What the board says of its start.
    pub start: Option<At<StartReport>>,
    /// Counts of the decoder.
    pub tally: Tally,
    /// The last damage.
    pub last_damage: Option<FrameError>,
    /// The last frame whose number went back: the first one of a new start, if that goes on.
    pub behind: Option<Frame>,
    /// What was last said to the board, or by it.
    pub said: Option<String>,
}

impl State {
    /// Takes an event and the counts after it.
    pub fn note(&mut self, event: &Event, tally: Tally) {
        self.tally = tally;
        let (frame, gap) = match event {
            Event::Damaged(error) => {
                self.last_damage = Some(*error);
                return;
            }
            Event::Frame { frame, gap } => (frame, *gap),
        };
        if gap == Gap::Behind {
            self.behind = Some(frame.clone());
            return;
        }
        if gap == Gap::Restart {
            let first = self.behind.take();
            // Time, counters and alarms begin again.
            *self = Self {
                tally,
                last_damage: self.last_damage,
                said: self.said.take(),
                ..Self::default()
            };
            if let Some(first) = first {
                self.take(&first);
            }
        }
        self.take(frame);
    }

    /// Takes what a frame says.
    fn take(&mut self, frame: &Frame) {
        let time_us = frame.time_us;
        self.time_us = self.time_us.max(time_us);
        match &frame.payload {
            Payload::Estimate(report) => {
                let report = *report;
                self.estimate = Some(At { time_us, report });
                if self.history.len() == HISTORY {
                    self.history.pop_front();
                }
                self.history.push_back(Point {
                    time: time_us as f64 * 1e-6,
                    stiffness: report.stiffness,
                    trusted: report.age == 0 && report.marks.is_empty(),
                });
            }
            Payload::Balls(report) => {
                let (row, count) = (usize::from(report.row), usize::from(report.count));
                if self.balls.len() <= row {
                    self.balls.resize_with(row + 1, Balls::default);
                }
                let Some(known) = self.balls.get_mut(row) else {
                    return;
                };
                if known.balls.len() != count {
                    known.balls = vec![None; count];
                }
                known.first_azimuth = report.first_azimuth;
                let places = known.balls.iter_mut().skip(report.first.into());
                for (place, ball) in places.zip(&report.balls) {
                    *place = Some(*ball);
                }
            }
            Payload::Rows(report) => {
                self.rows.resize(report.count.into(), None);
                let places = self.rows.iter_mut().skip(report.first.into());
                for (place, report) in places.zip(&report.rows) {
                    let report = *report;
                    *place = Some(At { time_us, report });
                }
            }
            Payload::Shaft(report) => {
                let report = report.clone();
                self.shaft = Some(At { time_us, report });
            }
            Payload::Alarm(report) => {
                let report = *report;
                if let Some(place) = self.alarms.get_mut(report.alarm as usize) {
                    // One that only says how it stands keeps the time of the last change.
                    let since = match place {
                        Some(At {
                            time_us,
                            report: old,
                        }) if old.state == report.state && old.raised == report.raised => *time_us,
                        _ => time_us,
                    };
                    *place = Some(At {
                        time_us: since,
                        report,
                    });
                }
            }
            Payload::Health(report) => {
                let report = *report;
                self.health = Some(At { time_us, report });
            }
            Payload::Inputs(report) => {
                let report = *report;
                self.nonce = Some(report.nonce);
                self.inputs = Some(At { time_us, report });
            }
            Payload::Answer(answer) => {
                let report = *answer;
                self.nonce = Some(report.nonce);
                self.said = Some(format!("board: {}", answer_words(&report)));
                self.answer = Some(At { time_us, report });
            }
            Payload::Board(report) => {
                let report = *report;
                self.board = Some(At { time_us, report });
            }
            Payload::Start(report) => {
                let report = *report;
                self.start = Some(At { time_us, report });
            }
        }
    }

    /// Number of rows, as far as it is known; 0 before the first report of any.
    pub fn row_count(&self) -> usize {
        let told = self.shaft.as_ref().map_or(0, |at| at.report.count.into());
        self.rows.len().max(self.balls.len()).max(told)
    }

    /// Where a row is and how it faces.
    pub fn place(&self, row: usize) -> Option<&RowPlace> {
        self.shaft.as_ref()?.report.rows.get(row)
    }

    /// Number of the balls of a row.
    fn ball_count(&self, row: usize) -> Option<usize> {
        let known = self.balls.get(row).map(|row| row.balls.len());
        known
            .filter(|count| *count > 0)
            .or_else(|| Some(self.place(row)?.balls.into()))
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
        let is_shared = self.rows.iter().flatten().any(|at| at.report.preload > 0.0);
        is_shared
            || self.shaft.as_ref().is_some_and(|at| {
                let rows = &at.report.rows;
                rows.iter().any(|row| row.mirrored) && rows.iter().any(|row| !row.mirrored)
            })
    }

    /// Whether a row has lost the preload that it had from the others.
    pub fn is_lifted(&self, row: usize) -> bool {
        let report = self.rows.get(row).and_then(Option::as_ref);
        // No number is none either.
        self.is_opposed() && report.is_some_and(|at| !(at.report.axial > 0.0))
    }

    /// Alarms that want somebody's attention or stand, the most serious first: none that is clear, or
    /// pending for its hold time.
    pub fn standing(&self) -> impl Iterator<Item = &At<AlarmReport>> {
        self.alarms
            .iter()
            .flatten()
            .filter(|at| !matches!(at.report.state, AlarmState::Clear | AlarmState::Pending))
    }

    /// Alarms that nobody has acknowledged.
    pub fn unacknowledged(&self) -> usize {
        self.standing()
            .filter(|at| at.report.state != AlarmState::Acknowledged)
            .count()
    }
}
