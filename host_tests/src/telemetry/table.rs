//! Frames as rows of a CSV file, and rows as frames again.
//!
//! One row a frame; one a ball for the balls, and one a row of balls for these and for the shaft. What does not belong
//! to the kind of the row stays empty.
//! SI units. Sets of names have a blank between two. `lost_before` counts the frames that are missing
//! before this one.

use super::decoder::{Event, Gap};
use super::state::facing;
use anyhow::{Context, Result, anyhow, bail};
use serde::{Deserialize, Serialize};
use spindle_bearing::monitor::board::{BoardReport, Check, ResetCause};
use spindle_bearing::monitor::command::{Answer, AnswerCode, Order};
use spindle_bearing::monitor::judgement::{Alarm, AlarmChange, AlarmState};
use spindle_bearing::monitor::learning::{Learning, LearningReport};
use spindle_bearing::monitor::loads::FrameCounts;
use spindle_bearing::monitor::telemetry::{
    AlarmReport, BallReport, BallsReport, EstimateReport, Frame, HealthReport, InputsReport,
    Payload, Recovery, RetentionReport, RowPlace, RowReport, RowsReport, ShaftReport, StartReport,
    StatusCode,
};
use spindle_bearing::monitor::{Mark, Marks, TemperatureSource};
use spindle_bearing::{Facing, Limit};
use std::io::{Read, Write};

/// A row of the file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct Row {
    kind: String,
    lost_before: Option<String>,
    version: Option<u8>,
    sequence: Option<u32>,
    time_us: Option<u64>,

    age_ticks: Option<u32>,
    marks: Option<String>,
    fx_n: Option<f32>,
    fy_n: Option<f32>,
    fz_n: Option<f32>,
    my_nm: Option<f32>,
    mz_nm: Option<f32>,
    speed_rad_s: Option<f32>,
    dx_m: Option<f32>,
    dy_m: Option<f32>,
    dz_m: Option<f32>,
    ty_rad: Option<f32>,
    tz_rad: Option<f32>,
    k_x_x: Option<f32>,
    k_y_y: Option<f32>,
    k_z_z: Option<f32>,
    k_ty_ty: Option<f32>,
    k_tz_tz: Option<f32>,
    k_nose_x_n_m: Option<f32>,
    k_nose_y_n_m: Option<f32>,
    k_nose_z_n_m: Option<f32>,
    coupling: Option<f32>,
    coupling_row: Option<u8>,
    coupling_column: Option<u8>,
    least_force_n: Option<f32>,
    largest_force_n: Option<f32>,
    status: Option<String>,
    iterations: Option<u16>,
    error_displacement: Option<f32>,
    error_force: Option<f32>,
    error_stiffness: Option<f32>,
    limits: Option<String>,

    row: Option<u8>,
    first_row: Option<u8>,
    row_count: Option<u8>,
    row_axial_n: Option<f32>,
    row_fy_n: Option<f32>,
    row_fz_n: Option<f32>,
    preload_n: Option<f32>,

    nose_m: Option<f32>,
    loads_at_m: Option<f32>,
    mounted_preload_n: Option<f32>,
    position_m: Option<f32>,
    facing: Option<String>,
    balls: Option<u16>,

    first_ball: Option<u16>,
    ball_count: Option<u16>,
    first_azimuth_rad: Option<f32>,
    ball: Option<u16>,
    q_i_n: Option<f32>,
    q_o_n: Option<f32>,
    alpha_i_rad: Option<f32>,
    alpha_o_rad: Option<f32>,

    alarm: Option<String>,
    change: Option<String>,
    state: Option<String>,
    value: Option<f32>,
    limit: Option<f32>,
    alarm_ball: Option<u16>,
    raised: Option<u32>,
    cleared: Option<u32>,

    ticks: Option<u64>,
    overruns: Option<u64>,
    missed_ticks: Option<u64>,
    estimates: Option<u64>,
    refusals: Option<u64>,
    marked_samples: Option<u64>,
    alarms_raised: Option<u64>,
    alarms_cleared: Option<u64>,
    frames_dropped: Option<u64>,
    most_cycles: Option<u32>,
    revolutions: Option<u64>,
    life_used: Option<f32>,
    kept_baseline: Option<String>,
    kept_life: Option<String>,
    kept_damaged: Option<u16>,
    kept_written: Option<u32>,
    kept_failed: Option<u32>,
    available_second: Option<f32>,
    available_minute: Option<f32>,
    learning: Option<String>,
    learnt_bands: Option<u8>,

    records_received: Option<u64>,
    records_corrupt: Option<u64>,
    records_lost: Option<u64>,
    records_disordered: Option<u64>,
    records_passed_over: Option<u64>,
    records_late: Option<u64>,
    doubtful_revolutions: Option<u64>,
    life_estimated: Option<f32>,
    nonce: Option<u32>,
    t_inner_c: Option<f32>,
    t_outer_c: Option<f32>,
    t_inner_source: Option<String>,
    t_outer_source: Option<String>,

    request: Option<u16>,
    order: Option<String>,
    occurrence: Option<u32>,
    outcome: Option<String>,
    known_answer: Option<String>,
    image: Option<String>,
    unused_stack_bytes: Option<u32>,
    brown_out_level: Option<u8>,
    boots: Option<u32>,
    reset_cause: Option<String>,
    kept_alarms: Option<String>,
    alarms_before: Option<u32>,
    raised_before: Option<String>,
}

const STATUSES: [StatusCode; 9] = [
    StatusCode::Converged,
    StatusCode::PrecisionLimit,
    StatusCode::IterationLimit,
    StatusCode::Unseated,
    StatusCode::NotFinite,
    StatusCode::OutOfRange,
    StatusCode::Unloaded,
    StatusCode::Indeterminate,
    StatusCode::Diverged,
];

const STATES: [AlarmState; 5] = [
    AlarmState::Clear,
    AlarmState::Pending,
    AlarmState::Raised,
    AlarmState::Acknowledged,
    AlarmState::Latched,
];

const CHANGES: [AlarmChange; 4] = [
    AlarmChange::Raised,
    AlarmChange::Cleared,
    AlarmChange::Acknowledged,
    AlarmChange::Standing,
];

/// Short name in lower case of what an alarm report is sent for.
pub const fn change_name(change: AlarmChange) -> &'static str {
    match change {
        AlarmChange::Raised => "raised",
        AlarmChange::Cleared => "cleared",
        AlarmChange::Acknowledged => "acknowledged",
        AlarmChange::Standing => "standing",
    }
}

/// Writes the file.
pub struct Writer<W: Write>(csv::Writer<W>);

impl<W: Write> Writer<W> {
    /// A file with nothing in it yet.
    pub fn new(out: W) -> Self {
        Self(csv::Writer::from_writer(out))
    }

    /// Adds an event's row or rows.
    ///
    /// # Errors
    ///
    /// The file cannot be written.
    pub fn write(&mut self, event: &Event) -> Result<()> {
        match event {
            Event::Damaged(error) => self.0.serialize(Row {
                kind: "damaged".into(),
                status: Some(error.name().into()),
                ..Row::default()
            })?,
            Event::Frame { frame, gap } => {
                for row in rows(frame, *gap) {
                    self.0.serialize(row)?;
                }
            }
        }
        Ok(())
    }

    /// Hands on what has gathered.
    ///
    /// # Errors
    ///
    /// The file cannot be written.
    pub fn flush(&mut self) -> Result<()> {
        Ok(self.0.flush()?)
    }
}

fn rows(frame: &Frame, gap: Gap) -> Vec<Row> {
    let head = Row {
        lost_before: Some(match gap {
            Gap::None => "0".into(),
            Gap::Lost(count) => count.to_string(),
            Gap::Behind => "behind".into(),
            Gap::Restart => "restart".into(),
        }),
        version: Some(frame.version),
        sequence: Some(frame.sequence),
        time_us: Some(frame.time_us),
        ..Row::default()
    };
    match &frame.payload {
        Payload::Estimate(report) => vec![estimate_row(head, report)],
        Payload::Balls(report) => balls_rows(head, report),
        Payload::Rows(report) => rows_rows(head, report),
        Payload::Shaft(report) => shaft_rows(head, report),
        Payload::Alarm(report) => vec![Row {
            kind: "alarm".into(),
            alarm: Some(report.alarm.name().into()),
            change: Some(change_name(report.change).into()),
            state: Some(report.state.name().into()),
            value: Some(report.value),
            limit: Some(report.limit),
            alarm_ball: report.ball,
            raised: Some(report.raised),
            cleared: Some(report.cleared),
            ..head
        }],
        Payload::Health(report) => vec![Row {
            kind: "health".into(),
            ticks: Some(report.ticks),
            overruns: Some(report.overruns),
            missed_ticks: Some(report.missed_ticks),
            estimates: Some(report.estimates),
            refusals: Some(report.refusals),
            marked_samples: Some(report.marked_samples),
            alarms_raised: Some(report.alarms_raised),
            alarms_cleared: Some(report.alarms_cleared),
            frames_dropped: Some(report.frames_dropped),
            most_cycles: Some(report.most_cycles),
            revolutions: Some(report.revolutions),
            life_used: Some(report.life_used),
            kept_baseline: Some(report.retention.baseline.name().into()),
            kept_life: Some(report.retention.life.name().into()),
            kept_damaged: Some(report.retention.damaged),
            kept_written: Some(report.retention.written),
            kept_failed: Some(report.retention.failed),
            available_second: Some(report.availability[0]),
            available_minute: Some(report.availability[1]),
            learning: Some(report.learning.state.name().into()),
            learnt_bands: Some(report.learning.bands),
            marks: Some(report.marks.to_string()),
            ..head
        }],
        Payload::Inputs(report) => vec![Row {
            kind: "inputs".into(),
            records_received: Some(report.records.received),
            records_corrupt: Some(report.records.corrupt),
            records_lost: Some(report.records.lost),
            records_disordered: Some(report.records.disordered),
            records_passed_over: Some(report.records.passed_over),
            records_late: Some(report.records.late),
            doubtful_revolutions: Some(report.doubtful_revolutions),
            life_estimated: Some(report.life_estimated),
            nonce: Some(report.nonce),
            t_inner_c: Some(report.temperatures[0]),
            t_outer_c: Some(report.temperatures[1]),
            t_inner_source: Some(report.temperature_sources[0].name().into()),
            t_outer_source: Some(report.temperature_sources[1].name().into()),
            ..head
        }],
        Payload::Answer(answer) => vec![Row {
            kind: "answer".into(),
            request: Some(answer.number),
            order: Some(order_name(&answer.order).into()),
            alarm: match answer.order {
                Order::Acknowledge { alarm, .. } => Some(alarm.name().into()),
                _ => None,
            },
            occurrence: match answer.order {
                Order::Acknowledge { raised, .. } => Some(raised),
                _ => None,
            },
            outcome: Some(answer.outcome.name().into()),
            nonce: Some(answer.nonce),
            ..head
        }],
        Payload::Board(report) => vec![Row {
            kind: "board".into(),
            known_answer: Some(report.known_answer.name().into()),
            image: Some(report.image.name().into()),
            unused_stack_bytes: report.unused_stack,
            brown_out_level: report.brown_out,
            ..head
        }],
        Payload::Start(report) => vec![Row {
            kind: "start".into(),
            boots: Some(report.boots),
            reset_cause: Some(report.cause.name().into()),
            kept_alarms: Some(report.recovery.name().into()),
            alarms_before: Some(report.alarms),
            raised_before: Some(report.raised.map(|count| count.to_string()).join(" ")),
            ..head
        }],
    }
}

fn estimate_row(head: Row, report: &EstimateReport) -> Row {
    let [fx, fy, fz, my, mz] = report.load.map(Some);
    let [dx, dy, dz, ty, tz] = report.displacement.map(Some);
    let [kx, ky, kz, kty, ktz] = report.stiffness.map(Some);
    let [k_nose_x_n_m, k_nose_y_n_m, k_nose_z_n_m] = report.nose.map(Some);
    let [error_displacement, error_force, error_stiffness] = report.error.map(Some);
    let limits: Vec<_> = report.passed().map(Limit::name).collect();
    Row {
        kind: "estimate".into(),
        age_ticks: Some(report.age),
        marks: Some(report.marks.to_string()),
        fx_n: fx,
        fy_n: fy,
        fz_n: fz,
        my_nm: my,
        mz_nm: mz,
        speed_rad_s: Some(report.speed),
        dx_m: dx,
        dy_m: dy,
        dz_m: dz,
        ty_rad: ty,
        tz_rad: tz,
        k_x_x: kx,
        k_y_y: ky,
        k_z_z: kz,
        k_ty_ty: kty,
        k_tz_tz: ktz,
        k_nose_x_n_m,
        k_nose_y_n_m,
        k_nose_z_n_m,
        coupling: Some(report.coupling),
        coupling_row: Some(report.coupling_row),
        coupling_column: Some(report.coupling_column),
        least_force_n: Some(report.least_force),
        largest_force_n: Some(report.largest_force),
        status: Some(report.status.name().into()),
        iterations: Some(report.iterations),
        error_displacement,
        error_force,
        error_stiffness,
        limits: Some(limits.join(" ")),
        ..head
    }
}

/// The rows of a frame that has some of something, with what is the same in all of them; one if it has none.
fn one_each<T>(head: Row, some: &[T], row: impl Fn(Row, usize, &T) -> Row) -> Vec<Row> {
    if some.is_empty() {
        return vec![head];
    }
    let mut rows = Vec::new();
    for (i, one) in some.iter().enumerate() {
        // The gap lies before the frame, not before every row of it.
        let lost_before = match i {
            0 => head.lost_before.clone(),
            _ => Some("0".into()),
        };
        let head = Row {
            lost_before,
            ..head.clone()
        };
        rows.push(row(head, i, one));
    }
    rows
}

fn balls_rows(head: Row, report: &BallsReport) -> Vec<Row> {
    let head = Row {
        kind: "ball".into(),
        row: Some(report.row),
        first_ball: Some(report.first),
        ball_count: Some(report.count),
        first_azimuth_rad: Some(report.first_azimuth),
        ..head
    };
    one_each(head, &report.balls, |head, i, ball| Row {
        ball: Some(report.first.wrapping_add(i as u16)),
        q_i_n: Some(ball.q_i),
        q_o_n: Some(ball.q_o),
        alpha_i_rad: Some(ball.alpha_i),
        alpha_o_rad: Some(ball.alpha_o),
        ..head
    })
}

fn rows_rows(head: Row, report: &RowsReport) -> Vec<Row> {
    let head = Row {
        kind: "row".into(),
        first_row: Some(report.first),
        row_count: Some(report.count),
        ..head
    };
    one_each(head, &report.rows, |head, i, row| Row {
        row: Some(report.first.wrapping_add(i as u8)),
        row_axial_n: Some(row.axial),
        row_fy_n: Some(row.radial[0]),
        row_fz_n: Some(row.radial[1]),
        preload_n: Some(row.preload),
        least_force_n: Some(row.least_force),
        largest_force_n: Some(row.largest_force),
        ..head
    })
}

fn shaft_rows(head: Row, report: &ShaftReport) -> Vec<Row> {
    let head = Row {
        kind: "shaft".into(),
        nose_m: Some(report.nose),
        loads_at_m: Some(report.loads_at),
        mounted_preload_n: Some(report.preload),
        row_count: Some(report.count),
        ..head
    };
    one_each(head, &report.rows, |head, i, place| Row {
        row: Some(i as u8),
        position_m: Some(place.position),
        facing: Some(facing(place).name().into()),
        balls: Some(place.balls),
        ..head
    })
}

/// Reads the frames of a file that [`Writer`] wrote; rows of damage are none.
///
/// # Errors
///
/// The number of the first row that is none of such a file, and what is wrong with it.
pub fn read(source: impl Read) -> Result<Vec<Frame>> {
    let mut frames: Vec<Frame> = Vec::new();
    let mut reader = csv::Reader::from_reader(source);
    for (i, row) in reader.deserialize::<Row>().enumerate() {
        let at = || format!("row {}", i + 1);
        let row = row.with_context(at)?;
        if row.kind == "damaged" {
            continue;
        }
        let frame = frame(&row).with_context(at)?;
        // Rows of one frame follow one another.
        if let Some(last) = frames.last_mut()
            && (last.sequence, last.time_us) == (frame.sequence, frame.time_us)
            && let Some(joined) = join(&mut last.payload, &frame.payload)
        {
            joined.with_context(at)?;
            continue;
        }
        frames.push(frame);
    }
    Ok(frames)
}

/// Adds what another row of the same frame says; `None` if it cannot be of the same one.
fn join(payload: &mut Payload, more: &Payload) -> Option<Result<()>> {
    let fits = match (payload, more) {
        (Payload::Balls(to), Payload::Balls(more)) => to.balls.extend_from_slice(&more.balls),
        (Payload::Rows(to), Payload::Rows(more)) => to.rows.extend_from_slice(&more.rows),
        (Payload::Shaft(to), Payload::Shaft(more)) => to.rows.extend_from_slice(&more.rows),
        _ => return None,
    };
    Some(fits.map_err(|_| anyhow!("more than a frame holds")))
}

fn frame(row: &Row) -> Result<Frame> {
    Ok(Frame {
        version: row.version.context("no version")?,
        sequence: row.sequence.context("no sequence")?,
        time_us: row.time_us.context("no time_us")?,
        payload: match row.kind.as_str() {
            "estimate" => Payload::Estimate(estimate(row).context("a field is missing")?),
            "ball" => Payload::Balls(balls(row).context("a field is missing")?),
            "alarm" => Payload::Alarm(alarm(row).context("a field is missing or not known")?),
            "health" => Payload::Health(health(row).context("a field is missing")?),
            "answer" => Payload::Answer(answer(row).context("a field is missing or not known")?),
            "inputs" => Payload::Inputs(inputs(row).context("a field is missing or not known")?),
            "board" => Payload::Board(board(row).context("a field is missing or not known")?),
            "row" => Payload::Rows(spindle_rows(row).context("a field is missing")?),
            "shaft" => Payload::Shaft(shaft(row).context("a field is missing or not known")?),
            "start" => Payload::Start(start(row).context("a field is missing or not known")?),
            other => bail!("no such kind of row: `{other}`"),
        },
    })
}

fn by_name<T: Copy>(all: &[T], name: impl Fn(T) -> &'static str, text: &str) -> Option<T> {
    all.iter().copied().find(|x| name(*x) == text)
}

fn marks(text: &Option<String>) -> Option<Marks> {
    // An empty field and one that is not there are the same in the file.
    let names = text.as_deref().unwrap_or_default().split_whitespace();
    names
        .map(|name| by_name(&Mark::ALL, Mark::name, name))
        .try_fold(Marks::NONE, |marks, mark| Some(marks.with(mark?)))
}

fn estimate(row: &Row) -> Option<EstimateReport> {
    let names = row.limits.as_deref().unwrap_or_default().split_whitespace();
    let limits = names
        .map(|name| by_name(&Limit::ALL, Limit::name, name))
        .try_fold(0, |bits, limit| Some(bits | 1 << limit? as u8))?;
    Some(EstimateReport {
        age: row.age_ticks?,
        marks: marks(&row.marks)?,
        load: [row.fx_n?, row.fy_n?, row.fz_n?, row.my_nm?, row.mz_nm?],
        speed: row.speed_rad_s?,
        displacement: [row.dx_m?, row.dy_m?, row.dz_m?, row.ty_rad?, row.tz_rad?],
        stiffness: [
            row.k_x_x?,
            row.k_y_y?,
            row.k_z_z?,
            row.k_ty_ty?,
            row.k_tz_tz?,
        ],
        nose: [row.k_nose_x_n_m?, row.k_nose_y_n_m?, row.k_nose_z_n_m?],
        coupling: row.coupling?,
        coupling_row: row.coupling_row?,
        coupling_column: row.coupling_column?,
        least_force: row.least_force_n?,
        largest_force: row.largest_force_n?,
        status: by_name(&STATUSES, StatusCode::name, row.status.as_deref()?)?,
        iterations: row.iterations?,
        error: [
            row.error_displacement?,
            row.error_force?,
            row.error_stiffness?,
        ],
        limits,
    })
}

fn balls(row: &Row) -> Option<BallsReport> {
    let mut report = BallsReport {
        row: row.row?,
        first: row.first_ball?,
        count: row.ball_count?,
        first_azimuth: row.first_azimuth_rad?,
        balls: Default::default(),
    };
    if row.ball.is_some() {
        let ball = BallReport {
            q_i: row.q_i_n?,
            q_o: row.q_o_n?,
            alpha_i: row.alpha_i_rad?,
            alpha_o: row.alpha_o_rad?,
        };
        report.balls.push(ball).ok()?;
    }
    Some(report)
}

fn spindle_rows(row: &Row) -> Option<RowsReport> {
    let mut report = RowsReport {
        first: row.first_row?,
        count: row.row_count?,
        rows: Default::default(),
    };
    if row.row.is_some() {
        let of = RowReport {
            axial: row.row_axial_n?,
            radial: [row.row_fy_n?, row.row_fz_n?],
            preload: row.preload_n?,
            least_force: row.least_force_n?,
            largest_force: row.largest_force_n?,
        };
        report.rows.push(of).ok()?;
    }
    Some(report)
}

fn shaft(row: &Row) -> Option<ShaftReport> {
    let mut report = ShaftReport {
        nose: row.nose_m?,
        loads_at: row.loads_at_m?,
        preload: row.mounted_preload_n?,
        count: row.row_count?,
        rows: Default::default(),
    };
    if row.row.is_some() {
        let facings = [Facing::PlusX, Facing::MinusX];
        let facing = by_name(&facings, Facing::name, row.facing.as_deref()?)?;
        let place = RowPlace {
            position: row.position_m?,
            mirrored: facing == Facing::MinusX,
            balls: row.balls?,
        };
        report.rows.push(place).ok()?;
    }
    Some(report)
}

fn alarm(row: &Row) -> Option<AlarmReport> {
    Some(AlarmReport {
        alarm: by_name(&Alarm::ALL, Alarm::name, row.alarm.as_deref()?)?,
        change: by_name(&CHANGES, change_name, row.change.as_deref()?)?,
        state: by_name(&STATES, AlarmState::name, row.state.as_deref()?)?,
        value: row.value?,
        limit: row.limit?,
        ball: row.alarm_ball,
        raised: row.raised?,
        cleared: row.cleared?,
    })
}

fn health(row: &Row) -> Option<HealthReport> {
    Some(HealthReport {
        ticks: row.ticks?,
        overruns: row.overruns?,
        missed_ticks: row.missed_ticks?,
        estimates: row.estimates?,
        refusals: row.refusals?,
        marked_samples: row.marked_samples?,
        alarms_raised: row.alarms_raised?,
        alarms_cleared: row.alarms_cleared?,
        frames_dropped: row.frames_dropped?,
        most_cycles: row.most_cycles?,
        revolutions: row.revolutions?,
        life_used: row.life_used?,
        marks: marks(&row.marks)?,
        retention: RetentionReport {
            baseline: recovery(&row.kept_baseline)?,
            life: recovery(&row.kept_life)?,
            damaged: row.kept_damaged?,
            written: row.kept_written?,
            failed: row.kept_failed?,
        },
        availability: [row.available_second?, row.available_minute?],
        learning: LearningReport {
            state: by_name(&Learning::ALL, |of| of.name(), row.learning.as_deref()?)?,
            bands: row.learnt_bands?,
        },
    })
}

fn inputs(row: &Row) -> Option<InputsReport> {
    let source = |name: &Option<String>| {
        by_name(
            &TemperatureSource::ALL,
            TemperatureSource::name,
            name.as_deref()?,
        )
    };
    Some(InputsReport {
        records: FrameCounts {
            received: row.records_received?,
            corrupt: row.records_corrupt?,
            lost: row.records_lost?,
            disordered: row.records_disordered?,
            passed_over: row.records_passed_over?,
            late: row.records_late?,
        },
        doubtful_revolutions: row.doubtful_revolutions?,
        life_estimated: row.life_estimated?,
        nonce: row.nonce?,
        temperatures: [row.t_inner_c?, row.t_outer_c?],
        temperature_sources: [source(&row.t_inner_source)?, source(&row.t_outer_source)?],
    })
}

/// Short name in lower case of an order.
const fn order_name(order: &Order) -> &'static str {
    match order {
        Order::Acknowledge { .. } => "acknowledge",
        Order::Learn(true) => "learn-on",
        Order::Learn(false) => "learn-off",
        Order::ReplaceBearing => "replace-bearing",
    }
}

fn answer(row: &Row) -> Option<Answer> {
    let orders = [
        Order::Learn(true),
        Order::Learn(false),
        Order::ReplaceBearing,
    ];
    let name = row.order.as_deref()?;
    let order = match orders.into_iter().find(|order| order_name(order) == name) {
        Some(order) => order,
        None if name == "acknowledge" => Order::Acknowledge {
            alarm: by_name(&Alarm::ALL, Alarm::name, row.alarm.as_deref()?)?,
            raised: row.occurrence?,
        },
        None => return None,
    };
    Some(Answer {
        number: row.request?,
        order,
        outcome: by_name(&AnswerCode::ALL, AnswerCode::name, row.outcome.as_deref()?)?,
        nonce: row.nonce?,
    })
}

fn board(row: &Row) -> Option<BoardReport> {
    let check = |name: &Option<String>| by_name(&Check::ALL, Check::name, name.as_deref()?);
    Some(BoardReport {
        known_answer: check(&row.known_answer)?,
        image: check(&row.image)?,
        unused_stack: row.unused_stack_bytes,
        brown_out: row.brown_out_level,
    })
}

fn start(row: &Row) -> Option<StartReport> {
    let counts = row.raised_before.as_deref()?.split_whitespace();
    let raised: Vec<u16> = counts
        .map(|count| count.parse().ok())
        .collect::<Option<_>>()?;
    Some(StartReport {
        boots: row.boots?,
        cause: by_name(
            &ResetCause::ALL,
            ResetCause::name,
            row.reset_cause.as_deref()?,
        )?,
        recovery: recovery(&row.kept_alarms)?,
        alarms: row.alarms_before?,
        raised: raised.try_into().ok()?,
    })
}

fn recovery(name: &Option<String>) -> Option<Recovery> {
    let name = name.as_deref()?;
    Recovery::ALL.into_iter().find(|of| of.name() == name)
}
