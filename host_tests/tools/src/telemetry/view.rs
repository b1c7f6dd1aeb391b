//! The live view: stiffness over time, the balls' forces as a polar picture of each row, the shaft with its rows, alarms
//! and counters.

use super::shaft;
use super::source::{Chunks, PortOperator};
use anyhow::Result;
use host_tests::telemetry::decoder::{Decoder, Event, Gap, Tally};
use host_tests::telemetry::operator::{wants_a_board, words};
use host_tests::telemetry::state::{At, Balls, Point, State};
use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::crossterm::event::{self, KeyCode, KeyEventKind, KeyModifiers};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{self, Canvas, Circle, Points};
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, Paragraph, Widget};
use spindle_bearing::monitor::judgement::{Alarm, AlarmState};
use spindle_bearing::monitor::learning::Learning;
use spindle_bearing::monitor::telemetry::{InputsReport, Recovery, RetentionReport};
use spindle_bearing::monitor::{BoardReport, TemperatureSource};
use std::collections::VecDeque;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

/// Seconds of the course that are shown.
pub const WINDOW: f64 = 60.0;

/// Time between two pictures.
const REFRESH: Duration = Duration::from_millis(100);

/// Names and colours of the stiffness' diagonal.
const DIRECTIONS: [(&str, Color); 5] = [
    ("Kx", Color::Yellow),
    ("Ky", Color::Cyan),
    ("Kz", Color::Magenta),
    ("Kty", Color::Cyan),
    ("Ktz", Color::Magenta),
];

pub(super) const INNER: Color = Color::Green;
pub(super) const OUTER: Color = Color::Blue;
pub(super) const WORST: Color = Color::Red;
const UNLOADED: Color = Color::Yellow;
pub(super) const FAINT: Color = Color::DarkGray;

/// What the polar picture reaches to, in parts of its scale: room for the numbers of the balls.
const MARGIN: f64 = 1.25;

/// Cells along the rim that the number of a ball needs.
const ROOM: f64 = 3.5;

/// Rows that are shown at most.
const MOST_ROWS: usize = 8;
/// Least height of a polar picture and of the shaft, cells.
const LEAST_HEIGHT: u16 = 8;

/// Draws what is known onto the whole screen.
pub fn draw(frame: &mut Frame<'_>, state: &State) {
    render(state, frame.area(), frame.buffer_mut());
}

/// What [`draw`] would draw onto a screen of this size, cells.
pub fn screen(state: &State, width: u16, height: u16) -> Buffer {
    let area = Rect::new(0, 0, width, height);
    let mut buffer = Buffer::empty(area);
    render(state, area, &mut buffer);
    buffer
}

fn render(state: &State, area: Rect, buffer: &mut Buffer) {
    let alarms = state.standing().count().max(1) as u16;
    let rows = state.row_count().clamp(1, MOST_ROWS);
    let head = header(state);
    let health = counters(state);
    let [above, middle, below, counters] = Layout::vertical([
        Constraint::Length(head.len() as u16),
        Constraint::Min(LEAST_HEIGHT),
        Constraint::Length(alarms + 2),
        Constraint::Length(10.max(health.len() as u16 + 2)),
    ])
    .areas(area);
    // Cells are about twice as high as wide.
    let wanted = middle.height.saturating_mul(2 * rows as u16);
    let [left, right] = Layout::horizontal([
        Constraint::Min(30),
        Constraint::Length(wanted.min(area.width / 2)),
    ])
    .areas(middle);
    let [linear, tilting] =
        Layout::vertical([Constraint::Ratio(3, 5), Constraint::Ratio(2, 5)]).areas(left);
    Paragraph::new(head).render(above, buffer);
    course(state, "N/um", 0..3, 1e-6, linear, buffer);
    course(state, "kN m/rad", 3..5, 1e-3, tilting, buffer);
    row_pictures(state, rows, right, buffer);
    alarm_list(state).render(below, buffer);
    Paragraph::new(health)
        .block(health_block(state))
        .render(counters, buffer);
}

fn header(state: &State) -> Vec<Line<'static>> {
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let mut first = vec![Span::styled(
        format!(" {:9.2} s", state.time_us as f64 * 1e-6),
        bold,
    )];
    let mut second = Vec::new();
    match &state.estimate {
        None => first.push(Span::raw("  no estimate yet")),
        Some(at) => {
            let report = &at.report;
            let rpm = f64::from(report.speed) * 30.0 / core::f64::consts::PI;
            let [fx, fy, fz, my, mz] = report.load;
            let [kx, ky, kz] = report.nose.map(|k| k * 1e-6);
            first.push(Span::raw(format!(
                "   {rpm:6.0} rpm   F = {fx:.0}, {fy:.0}, {fz:.0} N   M = {my:.2}, {mz:.2} N m   \
                 nose {kx:.0}, {ky:.0}, {kz:.0} N/um"
            )));
            second.push(Span::raw(format!(
                " estimate {} after {} iterations, good to {:.0e}",
                report.status.name(),
                report.iterations,
                report.error[2]
            )));
            if report.age > 0 {
                second.push(Span::styled(
                    format!(", {} ticks old", report.age),
                    warning(),
                ));
            }
            if !report.marks.is_empty() {
                second.push(Span::styled(
                    format!(", doubted: {}", report.marks),
                    warning(),
                ));
            }
            let passed: Vec<_> = report.passed().map(|limit| limit.name()).collect();
            if !passed.is_empty() {
                second.push(Span::styled(
                    format!(", past a limit: {}", passed.join(" ")),
                    warning(),
                ));
            }
        }
    }
    let mut lines = vec![Line::from(first), Line::from(second)];
    // The loads say all of a single row.
    if state.row_count() > 1 {
        let rows = (0..state.rows.len()).take(MOST_ROWS);
        lines.extend(rows.map(|row| row_line(state, row)));
    }
    lines
}

/// What a row of several carries.
fn row_line(state: &State, row: usize) -> Line<'static> {
    let Some(at) = state.rows.get(row).and_then(Option::as_ref) else {
        return Line::raw(format!(" row {row}: not known"));
    };
    let report = &at.report;
    let [y, z] = report.radial;
    let preload = if state.is_opposed() {
        format!(", preload {:5.0} N", report.preload)
    } else {
        String::new()
    };
    let (least, largest) = (report.least_force, report.largest_force);
    let text = format!(
        " row {row}: axial {:5.0} N, radial {:5.0} N{preload}, balls {least:.0} to {largest:.0} N",
        report.axial,
        y.hypot(z)
    );
    if state.is_lifted(row) {
        return Line::styled(format!("{text}, lifted off"), warning());
    }
    Line::raw(text)
}

fn warning() -> Style {
    Style::new().fg(WORST)
}

/// A round number at or above `x`.
fn round_up(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powf(x.log10().floor());
    [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0]
        .into_iter()
        .map(|step| step * power)
        .find(|round| *round >= x * (1.0 - 1e-12))
        .unwrap_or(10.0 * power)
}

/// Some elements of the stiffness over time, and their last values.
fn course(
    state: &State,
    unit_name: &str,
    elements: core::ops::Range<usize>,
    unit: f64,
    area: Rect,
    buffer: &mut Buffer,
) {
    let end = state.history.back().map_or(0.0, |point| point.time);
    let start = (end - WINDOW).max(state.history.front().map_or(0.0, |point| point.time));
    let end = end.max(start + 1.0);
    let shown = || {
        state
            .history
            .iter()
            .filter(move |point| point.time >= start)
    };
    let line = |i: usize| -> Vec<(f64, f64)> {
        // A doubted sample leaves a gap: its estimate is an older one.
        let points = shown().filter(|point| point.trusted);
        points
            .map(|point: &Point| (point.time, f64::from(point.stiffness[i]) * unit))
            .collect()
    };
    let lines: Vec<_> = elements.clone().map(|i| (DIRECTIONS[i], line(i))).collect();
    let highest = lines
        .iter()
        .flat_map(|(_, line)| line)
        .fold(0.0, |m: f64, (_, y)| m.max(*y));
    let top = round_up(highest);
    let datasets = lines
        .iter()
        .map(|((_, colour), line)| {
            Dataset::default()
                .marker(Marker::Braille)
                .graph_type(GraphType::Scatter)
                .style(Style::new().fg(*colour))
                .data(line)
        })
        .collect();
    let axis = Style::new().fg(FAINT);
    let mut title = vec![Span::raw(" ")];
    for ((name, colour), line) in &lines {
        let value = line.last().map_or("?".into(), |(_, y)| format!("{y:.1}"));
        let style = Style::new().fg(*colour);
        title.push(Span::styled(format!("{name} {value}  "), style));
    }
    title.push(Span::raw(format!("{unit_name} ")));
    Chart::new(datasets)
        .legend_position(None)
        .block(
            Block::bordered()
                .title(Line::from(title))
                .border_style(axis),
        )
        .x_axis(
            Axis::default()
                .bounds([start, end])
                .style(axis)
                .labels([format!("{start:.0} s"), format!("{end:.0} s")]),
        )
        .y_axis(Axis::default().bounds([0.0, top]).style(axis).labels([
            "0".into(),
            format!("{}", top / 2.0),
            format!("{top}"),
        ]))
        .render(area, buffer);
}

/// Force on the inner race that is largest, and its ball.
fn hardest(balls: &Balls) -> Option<(usize, f64)> {
    let forces = balls.balls.iter().enumerate().filter_map(|(i, ball)| {
        let force = f64::from(ball.as_ref()?.q_i);
        force.is_finite().then_some((i, force))
    });
    forces.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Where the picture shows a ball: its inner and its outer contact force, in parts of `scale` (N), along
/// its azimuth. y points to the right and z up, x at the reader.
pub fn places(balls: &Balls, index: usize, scale: f64) -> Option<[(f64, f64); 2]> {
    let ball = (*balls.balls.get(index)?)?;
    let (sin, cos) = balls.azimuth(index).sin_cos();
    let at = |force: f32| {
        let radius = f64::from(force) / scale;
        (radius * cos, radius * sin)
    };
    Some([at(ball.q_i), at(ball.q_o)])
}

/// The force at the rim of the polar picture, N.
pub fn scale(balls: &Balls) -> f64 {
    let forces = balls
        .balls
        .iter()
        .flatten()
        .flat_map(|ball| [ball.q_i, ball.q_o]);
    round_up(
        forces
            .map(f64::from)
            .filter(|q| q.is_finite())
            .fold(0.0, f64::max),
    )
}

/// The balls of each row, and below them, the shaft with its rows, if there are several.
fn row_pictures(state: &State, rows: usize, area: Rect, buffer: &mut Buffer) {
    let unknown = Balls::default();
    let balls = |row| state.balls.get(row).unwrap_or(&unknown);
    if rows == 1 {
        let scale = scale(balls(0));
        return polar(balls(0), scale, None, area, buffer);
    }
    let columns = columns(rows, area);
    let lines = rows.div_ceil(columns);
    let (mut upper, mut lower) = (area, Rect::ZERO);
    let square = area.width.saturating_mul(lines as u16) / (2 * columns as u16);
    // What the circles leave, and something more.
    let height = area.height.saturating_sub(square).max(LEAST_HEIGHT + 1);
    if state.shaft.is_some() && area.height >= height + LEAST_HEIGHT * lines as u16 {
        let parts = [Constraint::Min(0), Constraint::Length(height)];
        [upper, lower] = Layout::vertical(parts).areas(area);
    }
    // One for all, so that they can be compared.
    let scale = (0..rows).map(|row| scale(balls(row))).fold(0.0, f64::max);
    let heights = vec![Constraint::Fill(1); lines];
    let widths = vec![Constraint::Fill(1); columns];
    let places = Layout::vertical(heights).split(upper);
    let places = places.iter().flat_map(|line| {
        let cells = Layout::horizontal(&widths).split(*line);
        cells.to_vec()
    });
    for (row, place) in places.take(rows).enumerate() {
        polar(balls(row), scale, Some(row), place, buffer);
    }
    if let Some(at) = &state.shaft {
        shaft::render(state, &at.report, lower, buffer);
    }
}

/// In how many columns so many pictures are largest.
fn columns(pictures: usize, area: Rect) -> usize {
    let size = |columns: usize| {
        let width = usize::from(area.width) / columns;
        width.min(2 * usize::from(area.height) / pictures.div_ceil(columns))
    };
    let most = (1..=pictures).rev().max_by_key(|columns| size(*columns));
    most.unwrap_or(1)
}

/// Draws the balls of a row, which is named if there are several, with this force (N) at the rim.
fn polar(balls: &Balls, scale: f64, row: Option<usize>, area: Rect, buffer: &mut Buffer) {
    let worst = hardest(balls);
    let (title, below) = match (row, worst) {
        (None, None) => (" balls: none known ".into(), String::new()),
        (None, Some((ball, force))) => {
            let title = format!(" ball {ball}: {force:.0} N, rim {scale} N ");
            (title, String::new())
        }
        (Some(row), None) => (format!(" row {row}: no balls known "), String::new()),
        (Some(row), Some((ball, force))) => {
            let title = format!(" row {row} ball {ball}: {force:.0} N ");
            (title, format!(" rim {scale} N "))
        }
    };
    // A braille dot is as wide as high, so that a circle stays one.
    let (width, height) = (
        f64::from(area.width.saturating_sub(2).max(1)),
        2.0 * f64::from(area.height.saturating_sub(2).max(1)),
    );
    let least = width.min(height);
    let (x, y) = (MARGIN * width / least, MARGIN * height / least);
    Canvas::default()
        .block(
            Block::bordered()
                .title(title)
                .title_bottom(below)
                .border_style(Style::new().fg(FAINT)),
        )
        .marker(Marker::Braille)
        .x_bounds([-x, x])
        .y_bounds([-y, y])
        .paint(|picture| {
            for radius in [0.5, 1.0] {
                picture.draw(&Circle {
                    x: 0.0,
                    y: 0.0,
                    radius,
                    color: FAINT,
                });
            }
            let all: Vec<_> = (0..balls.balls.len())
                .map(|i| places(balls, i, scale))
                .collect();
            picture.layer();
            for (i, place) in all.iter().enumerate() {
                let next = all[(i + 1) % all.len()];
                if let (Some(a), Some(b)) = (place, next) {
                    for (race, colour) in [(1, OUTER), (0, INNER)] {
                        let ((x1, y1), (x2, y2)) = (a[race], b[race]);
                        picture.draw(&canvas::Line {
                            x1,
                            y1,
                            x2,
                            y2,
                            color: colour,
                        });
                    }
                }
            }
            picture.layer();
            if let Some((ball, _)) = worst
                && let Some([(x, y), _]) = places(balls, ball, scale)
            {
                picture.draw(&canvas::Line {
                    x1: 0.0,
                    y1: 0.0,
                    x2: x,
                    y2: y,
                    color: WORST,
                });
                picture.draw(&Points {
                    coords: &[(x, y)],
                    color: WORST,
                });
            }
            // The picture's radius in cells decides how many numbers have room.
            let radius = 0.5 * width / x;
            let room = core::f64::consts::TAU * radius / all.len().max(1) as f64;
            let step = (ROOM / room.max(0.1)).ceil().max(1.0) as usize;
            for i in 0..all.len() {
                let is_worst = worst.is_some_and(|(ball, _)| ball == i);
                let is_unloaded = balls.balls[i].is_some_and(|ball| ball.q_i == 0.0);
                if i % step > 0 && !is_worst && !is_unloaded {
                    continue;
                }
                let (sin, cos) = balls.azimuth(i).sin_cos();
                let colour = match worst {
                    _ if is_unloaded => UNLOADED,
                    Some(_) if is_worst => WORST,
                    _ => FAINT,
                };
                let name = Span::styled(i.to_string(), Style::new().fg(colour));
                picture.print(1.12 * cos, 1.12 * sin, Line::from(name));
            }
        })
        .render(area, buffer);
}

fn alarm_list(state: &State) -> Paragraph<'_> {
    let lines: Vec<Line<'_>> = state
        .standing()
        .map(|at| {
            let report = &at.report;
            let style = match report.state {
                AlarmState::Raised => warning().add_modifier(Modifier::BOLD),
                AlarmState::Latched => Style::new().fg(Color::Yellow),
                _ => Style::new().fg(FAINT),
            };
            let ball = match (
                report.ball,
                report.ball.and_then(|of| state.row_and_ball(of)),
            ) {
                (Some(_), Some((row, ball))) if state.row_count() > 1 => {
                    format!(", row {row} ball {ball}")
                }
                (Some(ball), _) => format!(", ball {ball}"),
                (None, _) => String::new(),
            };
            let unit = report.alarm.unit();
            Line::styled(
                format!(
                    " {:<15} {:<12} {:9.4} of {:.4}{}{}{ball}, since {:.2} s, {} times",
                    report.alarm.name(),
                    report.state.name(),
                    Short(report.value),
                    Short(report.limit),
                    if unit.is_empty() { "" } else { " " },
                    unit,
                    at.time_us as f64 * 1e-6,
                    report.raised,
                ),
                style,
            )
        })
        .collect();
    let title = match state.unacknowledged() {
        0 => " alarms ".into(),
        count => format!(" alarms: {count} not acknowledged "),
    };
    let lines = if lines.is_empty() {
        vec![Line::raw(" none")]
    } else {
        lines
    };
    Paragraph::new(lines).block(
        Block::bordered()
            .title(title)
            .border_style(Style::new().fg(FAINT)),
    )
}

/// A number of any size in few columns.
struct Short(f32);

impl core::fmt::Display for Short {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let x = self.0;
        let text = if x == 0.0 || (1e-3..1e5).contains(&x.abs()) {
            format!("{x:.3}")
        } else {
            format!("{x:.3e}")
        };
        match f.width() {
            Some(width) => write!(f, "{text:>width$}"),
            None => f.write_str(&text),
        }
    }
}

/// The temperatures and where they come from; `None` if they are not in use.
fn temperatures(report: &InputsReport) -> Option<Line<'static>> {
    let sources = report.temperature_sources;
    if sources == [TemperatureSource::Unused; 2] {
        return None;
    }
    let mut spans = vec![Span::raw(" temperatures:")];
    let sides = report.temperatures.iter().zip(sources);
    for ((celsius, source), name) in sides.zip([" inner", ", outer"]) {
        let style = match source {
            TemperatureSource::Held | TemperatureSource::Assumed => warning(),
            TemperatureSource::Unused | TemperatureSource::Measured => Style::new(),
        };
        spans.push(Span::raw(name));
        spans.push(Span::styled(
            format!(" {celsius:.1} C {}", source.name()),
            style,
        ));
    }
    Some(Line::from(spans))
}

fn counters(state: &State) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    match &state.health {
        None => lines.push(Line::raw(" no counters yet")),
        Some(at) => {
            let h = &at.report;
            let late = h.overruns + h.missed_ticks;
            let mut first = vec![Span::raw(format!(" {} ticks, ", h.ticks))];
            first.push(Span::styled(
                format!("{} overruns, {} missed", h.overruns, h.missed_ticks),
                if late > 0 { warning() } else { Style::new() },
            ));
            first.push(Span::raw(format!(
                ", longest {} cycles; {} estimates, {} refusals, {} doubted",
                h.most_cycles, h.estimates, h.refusals, h.marked_samples
            )));
            lines.push(Line::from(first));
            lines.push(Line::raw(format!(
                " {} revolutions, {} of the rating life used; alarms {} raised, {} cleared; {} frames dropped",
                h.revolutions,
                Short(h.life_used),
                h.alarms_raised,
                h.alarms_cleared,
                h.frames_dropped
            )));
            let [second, minute] = h.availability.map(|share| 100.0 * share);
            lines.push(Line::styled(
                format!(
                    " fresh estimates in {second:.1} % of the ticks of the last second, {minute:.1} % of the last minute"
                ),
                if second < 90.0 { warning() } else { Style::new() },
            ));
            let learning = &h.learning;
            lines.push(Line::styled(
                format!(
                    " learning of the baseline: {}, {} bands of speed",
                    learning.state.name(),
                    learning.bands
                ),
                match learning.state {
                    Learning::TooLittle | Learning::Implausible => warning(),
                    _ => Style::new(),
                },
            ));
            if let Some(at) = &state.inputs {
                let (r, life) = (&at.report.records, at.report.life_estimated);
                let bad = r.corrupt + r.lost + r.disordered + r.late;
                lines.push(Line::styled(
                    format!(
                        " records: {} received, {} corrupt, {} lost, {} out of order, {} late; of the life {} estimated",
                        r.received, r.corrupt, r.lost, r.disordered, r.late, Short(life)
                    ),
                    if bad > 0 { warning() } else { Style::new() },
                ));
                lines.extend(temperatures(&at.report));
            }
            let r = &h.retention;
            let refused = [r.baseline, r.life]
                .iter()
                .any(|of| !matches!(of, Recovery::Blank | Recovery::Recovered));
            let kept = if *r == RetentionReport::NO_MEMORY {
                " no memory: what is learnt is lost with the power".into()
            } else {
                format!(
                    " over a power cycle: baseline {}, life {}, {} damaged pieces; {} records written, {} failed",
                    r.baseline.name(),
                    r.life.name(),
                    r.damaged,
                    r.written,
                    r.failed
                )
            };
            lines.push(Line::styled(
                kept,
                if refused || r.failed > 0 {
                    warning()
                } else {
                    Style::new()
                },
            ));
        }
    }
    if let Some(start) = &state.start {
        let report = &start.report;
        let latched: Vec<_> = report.latched().map(Alarm::name).collect();
        lines.push(Line::styled(
            format!(
                " start {}, reset by {}; alarms before {}: {}",
                report.boots,
                report.cause.name(),
                report.recovery.name(),
                if latched.is_empty() {
                    "none".into()
                } else {
                    latched.join(" ")
                }
            ),
            match report.recovery {
                Recovery::NoMemory | Recovery::Blank | Recovery::Recovered => Style::new(),
                _ => warning(),
            },
        ));
    }
    let hurt = state.tally.lost + state.tally.damaged > 0;
    let mut link = format!(" link: {}", state.tally);
    if let Some(error) = state.last_damage {
        link += &format!(", last: {error}");
    }
    lines.push(Line::styled(
        link,
        if hurt { warning() } else { Style::new() },
    ));
    lines
}

fn health_block(state: &State) -> Block<'_> {
    let mut block = Block::bordered()
        .title(" health ")
        .border_style(Style::new().fg(FAINT));
    if let Some(At { report, .. }) = &state.board
        && *report != BoardReport::NONE
    {
        let text = format!(
            " known answer {}, image {} ",
            report.known_answer.name(),
            report.image.name()
        );
        let style = if report.is_broken() {
            warning()
        } else {
            Style::new()
        };
        block = block.title(Line::styled(text, style).right_aligned());
    }
    if let Some(said) = &state.said {
        block = block.title_bottom(format!(" {said} "));
    }
    block
}

/// Shows a stream until its reader presses q, Esc or Ctrl-C. At the end of the stream the view stays.
///
/// `pace` is how many times as fast as the monitor's own time the frames are shown; `None` shows them as
/// they come. `each` is called for every event, and `state` is what they say, also if there is an error. `operator`
/// is told of keys, where there is a board.
///
/// # Errors
///
/// The terminal cannot be used, the stream cannot be read, `each` failed, or the port takes no
/// bytes.
pub fn view(
    chunks: &Chunks,
    pace: Option<f64>,
    state: &mut State,
    mut each: impl FnMut(&Event) -> Result<()>,
    mut operator: Option<&mut PortOperator>,
) -> Result<()> {
    let mut terminal = ratatui::try_init()?;
    let shown = (|| {
        let mut decoder = Decoder::new();
        let mut waiting: VecDeque<(Event, Tally)> = VecDeque::new();
        let (mut start, mut open) = (None, true);
        loop {
            terminal.draw(|frame| draw(frame, state))?;
            let next = Instant::now() + REFRESH;
            loop {
                while let Some((event, tally)) = waiting.front() {
                    if let (Some(pace), Event::Frame { frame, gap }) = (pace, event) {
                        if *gap == Gap::Restart {
                            start = None;
                        }
                        let (at, first) = *start.get_or_insert((Instant::now(), frame.time_us));
                        let since = frame.time_us.saturating_sub(first) as f64 * 1e-6 / pace;
                        if at.elapsed().as_secs_f64() < since {
                            break;
                        }
                    }
                    each(event)?;
                    state.note(event, *tally);
                    waiting.pop_front();
                    if let Some(operator) = &mut operator {
                        operator.follow(state)?;
                        if let Some(order) = operator.unanswered().last() {
                            let order = words(order);
                            state.said = Some(format!("the board does not answer: {order}"));
                        }
                    }
                }
                let left = next.saturating_duration_since(Instant::now());
                if left.is_zero() {
                    break;
                }
                if !open || !waiting.is_empty() {
                    std::thread::sleep(left);
                    continue;
                }
                match chunks.recv_timeout(left) {
                    Ok(chunk) => {
                        for byte in chunk? {
                            let event = decoder.push(byte);
                            waiting.extend(event.map(|event| (event, decoder.tally())));
                        }
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => open = false,
                }
            }
            while event::poll(Duration::ZERO)? {
                let event::Event::Key(key) = event::read()? else {
                    continue;
                };
                if key.kind != KeyEventKind::Press {
                    continue;
                }
                let control = key.modifiers.contains(KeyModifiers::CONTROL);
                match key.code {
                    KeyCode::Char('q') | KeyCode::Esc => return Ok(()),
                    KeyCode::Char('c') if control => return Ok(()),
                    KeyCode::Char(other) => {
                        let said = match &mut operator {
                            Some(operator) => operator.press(other, state),
                            None => wants_a_board(other)
                                .then(|| "not from a port: there is no board to tell".into()),
                        };
                        state.said = said.or(state.said.take());
                    }
                    _ => {}
                }
            }
        }
    })();
    ratatui::restore();
    shown
}
