//! Reports to the host: when each is due, and the frames that they become.

use crate::accuracy;
use crate::alarms::{Alarm, Threshold};
use crate::board::BoardReport;
use crate::command::COMMAND_LENGTH;
use crate::judgement::{AlarmChange, Changes, Judgement, Level};
use crate::marks::Marks;
use crate::outbox::Outbox;
use crate::record;
use crate::retained::{Past, StartReport};
use crate::settings::{MonitorSettings, TelemetrySettings};
use crate::telemetry::{
    AlarmReport, BALLS_PER_FRAME, BallReport, BallsReport, EstimateReport, FRAME_LENGTH,
    HelloReport, LIFT_OFF, Payload, ROWS_PER_FRAME, RowPlace, RowReport, RowsReport, ShaftReport,
    bits_of,
};
use crate::tracker::{Solved, Task};
use core::array::from_fn;
use heapless::Vec;
use spindle_bearing::{BallState, Facing, RowSummary, Spindle, Status};

/// Time from one hello to the next, us: for hosts that join in later.
const HELLO_US: u32 = 60_000_000;

/// Something that is due now and then.
#[derive(Debug, Clone, Copy)]
struct Every {
    next_us: u64,
}

impl Every {
    fn is_due(&mut self, time_us: u64, period_us: u32) -> bool {
        if time_us < self.next_us {
            return false;
        }
        // In step with the period, unless that has been missed altogether.
        let period = u64::from(period_us);
        let next = self.next_us.saturating_add(period);
        self.next_us = if next > time_us {
            next
        } else {
            time_us.saturating_add(period)
        };
        true
    }
}

/// When each kind of report is due.
#[derive(Debug, Clone, Copy)]
struct Due {
    estimate: Every,
    balls: Every,
    health: Every,
    standing: Every,
    hello: Every,
}

/// The estimate that was taken for a report.
#[derive(Debug, Clone)]
struct Taken<const R: usize> {
    tick: u64,
    report: EstimateReport,
    rows: Vec<RowReport, R>,
    /// It has yet to be sent.
    is_new: bool,
}

/// The balls of a row at one time, on their way into the outbox.
#[derive(Debug, Clone)]
struct Picture<const N: usize> {
    time_us: u64,
    row: usize,
    first_azimuth: f32,
    balls: Vec<BallReport, N>,
    sent: usize,
}

/// Reports, and the outbox that they go into.
#[derive(Debug)]
pub(crate) struct Reports<const R: usize, const N: usize, const FRAMES: usize> {
    pub(crate) outbox: Outbox<FRAMES>,
    hello: HelloReport,
    taken: Option<Taken<R>>,
    /// Where the loads' accuracy is taken for an error at the nose ([`accuracy::place`]), m.
    place: f32,
    /// How the last solve ended.
    pub(crate) status: Status<f32>,
    picture: Option<Picture<N>>,
    /// An estimate is due, and the row whose balls are due.
    wants_estimate: bool,
    wanted_row: Option<usize>,
    due: Due,
}

impl<const R: usize, const N: usize, const FRAMES: usize> Reports<R, N, FRAMES> {
    pub(crate) fn new<const D: usize, const E: usize>(
        spindle: &Spindle<'_, f32, R, N, D, E>,
        settings: &MonitorSettings<R>,
    ) -> Self {
        // Apart, so that no tick has to report everything at once.
        let part = |of: u32| Every {
            next_us: u64::from(settings.telemetry.estimate_us) * u64::from(of) / 4,
        };
        Self {
            outbox: Outbox::new(),
            hello: HelloReport {
                start: StartReport::default(),
                board: BoardReport::NONE,
                shaft: shaft_report(spindle, settings),
            },
            taken: None,
            place: accuracy::place(&settings.shaft, spindle.positions()),
            status: Status::Converged,
            picture: None,
            wants_estimate: false,
            wanted_row: None,
            due: Due {
                estimate: part(1),
                balls: part(2),
                health: part(0),
                standing: part(3),
                hello: part(0),
            },
        }
    }

    /// Goes on with the data kept over a power cycle.
    pub(crate) fn set_past(&mut self, past: &Past) {
        self.hello.start = past.start;
    }

    /// Number of this start.
    pub(crate) const fn start(&self) -> u32 {
        self.hello.start.boots
    }

    /// Takes the rows of the mounted spindle, cold and at rest.
    pub(crate) fn mount(&mut self, rows: &[RowSummary<f32>]) {
        let preloads = rows.iter().map(|row| row.preload);
        self.hello.shaft.preload = preloads.fold(0.0, f32::max);
    }

    /// Takes the board's report on itself. Changes, but for the stack, are reported in the next tick.
    pub(crate) fn set_board(&mut self, report: BoardReport) {
        if report.differs(&self.hello.board) {
            self.due.hello = Every { next_us: 0 };
        }
        self.hello.board = report;
    }

    /// Whether a self-check of the board has failed.
    pub(crate) fn is_board_broken(&self) -> bool {
        self.hello.board.is_broken()
    }

    /// A tick begins: what is due is taken of the next solve.
    pub(crate) fn begin(&mut self, time_us: u64, settings: &MonitorSettings<R>) {
        if self
            .due
            .estimate
            .is_due(time_us, settings.telemetry.estimate_us)
        {
            // Nothing was solved for a whole period: the last one once more.
            if self.wants_estimate
                && let Some(taken) = &mut self.taken
            {
                taken.is_new = true;
            }
            self.wants_estimate = true;
        }
        if self.due.balls.is_due(time_us, settings.telemetry.balls_us) {
            self.wanted_row = Some(0);
        }
    }

    /// Whether anything is due of the next equilibrium.
    pub(crate) const fn wants_something(&self) -> bool {
        self.wants_estimate || (self.wanted_row.is_some() && self.picture.is_none())
    }

    /// Takes what is due of an equilibrium.
    pub(crate) fn see<const D: usize, const E: usize>(
        &mut self,
        task: &Task<R>,
        solution: &Solved<'_, R, N, D, E>,
        rows: &[RowSummary<f32>],
        opposed: bool,
        settings: &MonitorSettings<R>,
    ) {
        if self.wants_estimate {
            self.wants_estimate = false;
            let report = estimate_report(task, solution, rows, opposed, self.place, settings);
            self.taken = Some(Taken {
                tick: task.tick,
                report,
                rows: as_many_as_fit(rows.iter().map(row_report)),
                is_new: true,
            });
        } else if self.picture.is_none()
            && let Some(row) = self.wanted_row
        {
            self.wanted_row = Some(row + 1).filter(|row| *row < rows.len());
            let balls = solution.rows().nth(row);
            self.picture = balls.map(|row_of_balls| Picture {
                time_us: task.sample.time_us,
                row,
                first_azimuth: row_of_balls.balls().next().map_or(0.0, |ball| ball.azimuth),
                balls: as_many_as_fit(row_of_balls.balls().map(|ball| ball_report(&ball))),
                sent: 0,
            });
        }
    }

    /// The last solve gave no estimate.
    pub(crate) const fn is_unsolved(&self) -> bool {
        !matches!(self.status, Status::Converged | Status::PrecisionLimit)
    }

    /// Whether counters are due.
    pub(crate) fn wants_health(&mut self, time_us: u64, settings: &MonitorSettings<R>) -> bool {
        self.due
            .health
            .is_due(time_us, settings.telemetry.health_us)
    }

    /// Puts due frames into the outbox, but for counters.
    pub(crate) fn send(
        &mut self,
        time_us: u64,
        (tick, marks): (u64, Marks),
        (alarms, changes): (&Judgement, &Changes),
        settings: &MonitorSettings<R>,
    ) {
        for change in changes {
            self.post_alarm(
                time_us,
                change.alarm,
                change.change,
                alarms,
                &settings.alarms,
            );
        }
        if self
            .due
            .standing
            .is_due(time_us, settings.telemetry.standing_us)
        {
            for alarm in Alarm::ALL {
                if alarms.alarm(alarm).stands() {
                    let standing = AlarmChange::Standing;
                    self.post_alarm(time_us, alarm, standing, alarms, &settings.alarms);
                }
            }
        }
        if self.due.hello.is_due(time_us, HELLO_US) {
            let hello = self.hello.clone();
            self.outbox.post(time_us, Payload::Hello(hello));
        }
        self.send_estimate(time_us, tick, marks);
        self.send_balls();
    }

    fn send_estimate(&mut self, time_us: u64, tick: u64, marks: Marks) {
        let Some(taken) = self.taken.as_mut().filter(|taken| taken.is_new) else {
            return;
        };
        taken.is_new = false;
        taken.report.age = tick.saturating_sub(taken.tick).min(u32::MAX.into()) as u32;
        (taken.report.marks, taken.report.status) = (marks, self.status);
        self.outbox.post(time_us, Payload::Estimate(taken.report));
        for (number, rows) in taken.rows.chunks(ROWS_PER_FRAME).enumerate() {
            let report = RowsReport {
                first: (number * ROWS_PER_FRAME) as u8,
                count: taken.rows.len() as u8,
                rows: as_many_as_fit(rows.iter().copied()),
            };
            self.outbox.post(time_us, Payload::Rows(report));
        }
    }

    /// The next balls of the picture.
    fn send_balls(&mut self) {
        let Some(picture) = &mut self.picture else {
            return;
        };
        let rest = picture.balls.iter().skip(picture.sent);
        let report = BallsReport {
            row: picture.row as u8,
            first: picture.sent as u16,
            count: picture.balls.len() as u16,
            first_azimuth: picture.first_azimuth,
            balls: as_many_as_fit(rest.copied()),
        };
        self.outbox.post(picture.time_us, Payload::Balls(report));
        picture.sent += BALLS_PER_FRAME;
        if picture.sent >= picture.balls.len() {
            self.picture = None;
        }
    }

    /// Reports a change of an alarm.
    pub(crate) fn post_alarm(
        &mut self,
        time_us: u64,
        alarm: Alarm,
        change: AlarmChange,
        alarms: &Judgement,
        thresholds: &[Threshold; Alarm::COUNT],
    ) {
        let machine = alarms.alarm(alarm);
        let (raised, cleared) = machine.counts();
        let Level { value, place } = machine.level();
        let threshold = &thresholds[alarm as usize];
        let report = AlarmReport {
            alarm,
            change,
            state: machine.state(),
            value,
            limit: match change {
                AlarmChange::Cleared => threshold.clear,
                _ => threshold.raise,
            },
            place,
            start: self.start(),
            raised,
            cleared,
        };
        self.outbox.post(time_us, Payload::Alarm(report));
    }
}

impl TelemetrySettings {
    /// Frames in ten seconds at most, of a spindle of so many rows of so many balls; alarms that change and answers besides.
    const fn frames(&self, rows: usize, balls: usize) -> u64 {
        const TIME_US: u64 = 10_000_000;
        let estimate = 1 + rows.div_ceil(ROWS_PER_FRAME);
        let picture = rows * balls.div_ceil(BALLS_PER_FRAME);
        TIME_US / self.estimate_us as u64 * estimate as u64
            + TIME_US / self.balls_us as u64 * picture as u64
            // A report on the probes goes with each on health.
            + 2 * (TIME_US / self.health_us as u64)
            + TIME_US / self.standing_us as u64 * Alarm::COUNT as u64
    }
}

impl<const R: usize> MonitorSettings<R> {
    /// Whether a port of this baud rate takes a record and a command in a tick, and three quarters of it all of the
    /// telemetry, for rows of at most so many balls: for the compiler to ask.
    pub const fn fits_port(&self, baud: u32, balls: usize) -> bool {
        // Ten bits a byte.
        let of_tick = baud as u64 / 10 * self.tick.period_us as u64 / 1_000_000;
        let record = (record::FRAME_LENGTH + COMMAND_LENGTH) as u64;
        let frames = self.telemetry.frames(R, balls) * FRAME_LENGTH as u64;
        record <= of_tick && frames <= baud as u64 * 3 / 4
    }
}

/// The first of these.
fn as_many_as_fit<X, const CAP: usize>(items: impl Iterator<Item = X>) -> Vec<X, CAP> {
    let mut kept = Vec::new();
    for item in items {
        if kept.push(item).is_err() {
            break;
        }
    }
    kept
}

/// Places on the shaft, as the telemetry has them.
fn shaft_report<const R: usize, const N: usize, const D: usize, const E: usize>(
    spindle: &Spindle<'_, f32, R, N, D, E>,
    settings: &MonitorSettings<R>,
) -> ShaftReport {
    let places = spindle.positions().zip(spindle.facings());
    let rows = places.zip(spindle.ball_counts());
    let place = |((position, facing), balls): ((f32, Facing), u16)| RowPlace {
        position,
        mirrored: facing == Facing::MinusX,
        balls,
    };
    ShaftReport {
        nose: settings.shaft.nose,
        loads_at: settings.shaft.loads_at,
        preload: 0.0,
        count: spindle.facings().len() as u8,
        rows: as_many_as_fit(rows.map(place)),
    }
}

fn estimate_report<const R: usize, const N: usize, const D: usize, const E: usize>(
    task: &Task<R>,
    solution: &Solved<'_, R, N, D, E>,
    rows: &[RowSummary<f32>],
    opposed: bool,
    place: f32,
    settings: &MonitorSettings<R>,
) -> EstimateReport {
    let MonitorSettings {
        shaft, accuracy, ..
    } = settings;
    let displacement = solution.displacement_at(shaft.nose);
    let (mut compliance, mut errors) = solution.compliance_with_error_at(shaft.nose);
    let at_place = if place == shaft.nose {
        compliance
    } else {
        solution.compliance_at(place)
    };
    let by_loads = accuracy::errors(&at_place, place, shaft, accuracy);
    let [x, y, z, ..] = displacement;
    let by_loads = largest(by_loads) / largest([x, y, z]).max(f32::MIN_POSITIVE);
    for (i, by) in shaft.flexibility.into_iter().enumerate() {
        let of_rows = compliance[i][i];
        compliance[i][i] += by;
        errors[i] *= of_rows / compliance[i][i];
    }
    let (row, column) = strongest_coupling(&compliance);
    let (mut least, mut largest, mut limits) = (f32::INFINITY, 0.0_f32, 0);
    for row in rows {
        least = least.min(row.inner_force[0]);
        largest = largest.max(row.inner_force[1]);
        limits |= bits_of(row.margins.passed());
        if opposed && !(row.force[0] > 0.0) {
            limits |= LIFT_OFF;
        }
    }
    EstimateReport {
        load: task.sample.load,
        speed: task.sample.speed,
        displacement,
        stiffness: from_fn(|i| 1.0 / compliance[i][i]),
        coupling: (1.0 / compliance[row][column]).clamp(f32::MIN, f32::MAX),
        coupling_row: row as u8,
        coupling_column: column as u8,
        least_force: least,
        largest_force: largest,
        iterations: task.rows.div_ceil((rows.len() as u16).max(1)),
        error: [
            solution.error.displacement + by_loads.min(1.0),
            solution.error.force,
            errors.into_iter().fold(
                0.0,
                |most, error| if error < 1.0 { error.max(most) } else { 1.0 },
            ),
        ],
        limits,
        ..EstimateReport::NONE
    }
}

fn largest(numbers: [f32; 3]) -> f32 {
    numbers.into_iter().map(f32::abs).fold(0.0, f32::max)
}

fn row_report(row: &RowSummary<f32>) -> RowReport {
    let [axial, y, z] = row.force;
    RowReport {
        axial,
        radial: [y, z],
        preload: row.preload,
        least_force: row.inner_force[0],
        largest_force: row.inner_force[1],
        frequencies: row.frequencies,
    }
}

fn ball_report(ball: &BallState<f32>) -> BallReport {
    BallReport {
        q_i: ball.q_i,
        q_o: ball.q_o,
        alpha_i: ball.alpha_i,
        alpha_o: ball.alpha_o,
    }
}

/// Factor by which `Cij^2 / |Cii Cjj|` must exceed an earlier element's: a per cent of its root.
const CLEARLY: f32 = 1.02;

/// Row and column of the off-diagonal element of a compliance that couples most; x, y if nothing couples.
fn strongest_coupling(c: &[[f32; 5]; 5]) -> (usize, usize) {
    let mut place = (0, 1);
    let mut strongest: f32 = 0.0;
    let per: [f32; 5] = from_fn(|i| 1.0 / c[i][i].abs());
    for i in 0..5 {
        for j in 0..5 {
            let ratio = (c[i][j] * per[i]) * (c[i][j] * per[j]);
            // False for 0/0, too: a direction that does not move couples with nothing.
            if i != j && ratio > CLEARLY * strongest {
                strongest = ratio;
                place = (i, j);
            }
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use spindle_bearing::{Arrangement, Bearing, Design, Mounted};

    const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 0.26);

    /// The largest spindle that a file may have.
    #[test]
    fn each_of_eight_rows_tells_its_place_its_facing_and_its_balls() {
        let bearing = Bearing::<f32, 9>::new(&DESIGN).unwrap();
        let rows: [_; 8] = from_fn(|i| {
            let facing = if i < 4 { Facing::PlusX } else { Facing::MinusX };
            Mounted::<f32, 9>::new(&bearing, 0.02 * i as f32, facing)
        });
        let spindle = Spindle::new(Arrangement::ByRows, rows).unwrap();
        let report = shaft_report(&spindle, &MonitorSettings::new(&DESIGN, 9));
        assert_eq!((report.count, report.rows.len()), (8, 8));
        for (i, row) in report.rows.iter().enumerate() {
            let place = RowPlace {
                position: 0.02 * i as f32,
                mirrored: i >= 4,
                balls: 9,
            };
            assert_eq!(*row, place);
        }
    }

    #[test]
    fn coupling_is_judged_relative_to_the_compliances_it_joins() {
        let mut c = [[0.0; 5]; 5];
        for (i, row) in c.iter_mut().enumerate() {
            row[i] = if i < 3 { 1e-8 } else { 1e-3 };
        }
        assert_eq!(strongest_coupling(&c), (0, 1));
        c[1][2] = 1e-10;
        c[4][1] = -1e-6;
        assert_eq!(strongest_coupling(&c), (4, 1));
        c[1][4] = -0.999e-6;
        assert_eq!(strongest_coupling(&c), (1, 4));
        c[4] = [0.0; 5];
        c[1][4] = 0.0;
        assert_eq!(strongest_coupling(&c), (1, 2));
    }
}
