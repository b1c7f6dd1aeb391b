//! The live view: each row with its place and its load, stiffness over time, alarms and counters. A polar picture of each
//! row shows the balls' forces.

use super::session::Session;
use super::source::Chunks;
use crate::telemetry::operator::wants_a_board;
use crate::telemetry::state::{Balls, FRESH, State, facing};
use anyhow::{Context, Result};
use ratatui::DefaultTerminal;
use ratatui::buffer::Buffer;
use ratatui::crossterm::event::{self, KeyCode, KeyModifiers};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{self, Canvas, Circle};
use ratatui::widgets::{Axis, Block, Chart, Dataset, Paragraph, Row, Table, Widget, Wrap};
use serde_json::{Value, json};
use spindle_bearing::Frequencies;
use spindle_file::monitors::against;
use spindle_monitor::Alarm;
use spindle_monitor::judgement::AlarmState;
use spindle_monitor::response;
use std::ops::Range;
use std::slice;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

/// Seconds of the course that are shown.
const WINDOW: f64 = 60.0;

/// Time between two pictures.
const REFRESH: Duration = Duration::from_millis(100);

const INNER: Color = Color::Green;
const OUTER: Color = Color::Blue;
const WORST: Color = Color::Red;
const UNLOADED: Color = Color::Yellow;
const FAINT: Color = Color::DarkGray;

/// Names and colours of the stiffness at the nose.
const DIRECTIONS: [(&str, Color); 5] = [
    ("Kx", Color::Yellow),
    ("Ky", Color::Cyan),
    ("Kz", Color::Magenta),
    ("Kty", Color::Cyan),
    ("Ktz", Color::Magenta),
];

/// Reach of the polar picture, in parts of its scale: room for the numbers of the balls.
const MARGIN: f64 = 1.25;

/// Rows that are shown at most.
const MOST_ROWS: usize = 8;

/// A screen of this size with what is known, cells.
pub fn screen(state: &State, width: u16, height: u16) -> Buffer {
    let mut buffer = Buffer::empty(Rect::new(0, 0, width, height));
    render(state, buffer.area, &mut buffer);
    buffer
}

/// A box with a title.
fn boxed<'a>(title: impl Into<Line<'a>>) -> Block<'a> {
    Block::bordered().title(title).border_style(FAINT)
}

/// Red, if something is amiss.
const fn flag(is_amiss: bool) -> Style {
    match is_amiss {
        true => Style::new().fg(WORST),
        false => Style::new(),
    }
}

fn render(state: &State, area: Rect, buffer: &mut Buffer) {
    let count = state.row_count().clamp(1, MOST_ROWS);
    let alarms = state.standing().count().max(1) as u16;
    let probes = probe_lines(state);
    // The loads say all of a single row.
    let rows = match count {
        1 => 0,
        _ => 1 + state.rows.len().min(MOST_ROWS) as u16,
    };
    let [head, table, middle, seen, below, counters] = Layout::vertical([
        Constraint::Length(2),
        Constraint::Length(rows),
        Constraint::Min(8),
        Constraint::Length(probes.len() as u16),
        Constraint::Length(alarms + 2),
        Constraint::Length(12),
    ])
    .areas(area);
    // Cells are about twice as high as wide.
    let wanted = middle.height.saturating_mul(2 * count as u16);
    let [left, right] = Layout::horizontal([
        Constraint::Min(30),
        Constraint::Length(wanted.min(area.width / 2)),
    ])
    .areas(middle);
    let [linear, tilting] =
        Layout::vertical([Constraint::Fill(3), Constraint::Fill(2)]).areas(left);
    Paragraph::new(header(state)).render(head, buffer);
    Widget::render(row_table(state), table, buffer);
    course(state, "N/um", 0..3, 1e-6, linear, buffer);
    course(state, "kN m/rad", 3..5, 1e-3, tilting, buffer);
    row_pictures(state, count, right, buffer);
    Paragraph::new(probes).render(seen, buffer);
    Widget::render(alarm_table(state), below, buffer);
    health(state).render(counters, buffer);
}

fn header(state: &State) -> Vec<Line<'static>> {
    let time = format!(" {:9.2} s", state.time_us as f64 * 1e-6).bold();
    let Some(report) = &state.estimate else {
        return vec![Line::from(vec![time, "  no estimate yet".into()])];
    };
    let rpm = f64::from(report.speed) * 30.0 / core::f64::consts::PI;
    let [fx, fy, fz, my, mz] = report.load;
    let [kx, ky, kz, ..] = report.stiffness.map(|k| k * 1e-6);
    let loads = format!(
        "   {rpm:6.0} rpm   F = {fx:.0}, {fy:.0}, {fz:.0} N   M = {my:.2}, {mz:.2} N m   \
         nose {kx:.0}, {ky:.0}, {kz:.0} N/um"
    );
    let mut solve = format!(
        " estimate {}, {} iterations",
        report.status.name(),
        report.iterations,
    );
    let [displacement, force, stiffness] = report.error;
    let errors = format!(
        "; errors: displacement {displacement:.0e}; solve alone: force {force:.0e}, stiffness {stiffness:.0e}"
    );
    let mut doubts = String::new();
    let age = format!(", {} ticks old", report.age);
    match report.age {
        0 => {}
        1..=FRESH => solve += &age,
        _ => doubts += &age,
    }
    if !report.marks.is_empty() {
        doubts += &format!(", doubted: {}", report.marks);
    }
    for limit in report.passed() {
        doubts += &format!(", past a limit: {limit}");
    }
    vec![
        Line::from(vec![time, loads.into()]),
        Line::from(vec![solve.into(), doubts.fg(WORST), errors.into()]),
    ]
}

/// Frequencies at which defects of a row's parts vibrate.
fn defects(of: &Frequencies<f32>) -> String {
    format!(
        "cage {:.1}, ball {:.0}, outer {:.0}, inner {:.0} Hz",
        of.cage, of.ball, of.outer_race, of.inner_race
    )
}

/// Table of the rows: their places, loads and defect frequencies.
fn row_table(state: &State) -> Table<'static> {
    let head = ",at mm,faces,axial N,radial N,preload N,balls N";
    let about = state.shaft.as_ref().map_or(String::new(), |shaft| {
        let [nose, loads] = [shaft.nose, shaft.loads_at].map(|x| x * 1e3);
        let preload = shaft.preload;
        format!("nose at {nose:.0} mm, loads at {loads:.0} mm, mounted with {preload:.0} N")
    });
    let head = head.split(',').map(str::to_owned).chain([about]);
    let rows = state.rows.iter().enumerate().take(MOST_ROWS);
    let rows = rows.map(|(i, report)| {
        let place = state.shaft.as_ref().and_then(|shaft| shaft.rows.get(i));
        let mut cells = vec![
            format!(" row {i}"),
            place.map_or(String::new(), |of| format!("{:.0}", of.position * 1e3)),
            place.map_or(String::new(), |of| facing(of).name().to_owned()),
        ];
        let Some(report) = report else {
            cells.push("unknown".into());
            return Row::new(cells);
        };
        let [y, z] = report.radial;
        let is_lifted = state.is_lifted(i);
        cells.extend([
            format!("{:.0}", report.axial),
            format!("{:.0}", y.hypot(z)),
            match state.is_opposed() {
                true => format!("{:.0}", report.preload),
                false => String::new(),
            },
            format!("{:.0} to {:.0}", report.least_force, report.largest_force),
            if is_lifted {
                "lifted off".into()
            } else {
                defects(&report.frequencies)
            },
        ]);
        Row::new(cells).style(flag(is_lifted))
    });
    Table::new(rows, [7, 6, 6, 8, 8, 9, 14, 55]).header(Row::new(head).fg(FAINT))
}

/// A number of one digit and zeros, at or above `x`.
fn round_up(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powf(x.log10().floor());
    power * (x / power * (1.0 - 1e-12)).ceil()
}

/// Some of the stiffness at the nose over time, and the last values.
fn course(
    state: &State,
    unit_name: &str,
    elements: Range<usize>,
    unit: f64,
    area: Rect,
    buffer: &mut Buffer,
) {
    let end = state.history.back().map_or(0.0, |point| point.time);
    let first = state.history.front().map_or(0.0, |point| point.time);
    let start = (end - WINDOW).max(first);
    let end = end.max(start + 1.0);
    // A doubted sample leaves a gap: its estimate is an older one.
    let points = state.history.iter();
    let points: Vec<_> = points
        .filter(|point| point.trusted && point.time >= start)
        .collect();
    let mut title = vec![Span::raw(" at the nose: ")];
    let mut highest: f64 = 0.0;
    let mut lines = Vec::new();
    for i in elements {
        let (name, colour) = DIRECTIONS[i];
        let line = points.iter();
        let line: Vec<_> = line
            .map(|point| (point.time, f64::from(point.stiffness[i]) * unit))
            .collect();
        highest = line.iter().fold(highest, |most, (_, y)| most.max(*y));
        let last = line.last().map_or("?".into(), |(_, y)| format!("{y:.1}"));
        title.push(format!("{name} {last}  ").fg(colour));
        lines.push((colour, line));
    }
    title.push(format!("{unit_name} ").into());
    let datasets = lines.iter().map(|(colour, line)| {
        let dataset = Dataset::default().marker(Marker::Braille);
        dataset.fg(*colour).data(line)
    });
    let top = round_up(highest);
    let x = [format!("{start:.0} s"), format!("{end:.0} s")];
    let y = [0.0, top / 2.0, top].map(|y| (y as f32).to_string());
    Chart::new(datasets.collect())
        .block(boxed(title))
        .x_axis(Axis::default().bounds([start, end]).style(FAINT).labels(x))
        .y_axis(Axis::default().bounds([0.0, top]).style(FAINT).labels(y))
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
    let balls = balls.balls.iter().flatten();
    let forces = balls.flat_map(|ball| [ball.q_i, ball.q_o]).map(f64::from);
    round_up(forces.filter(|q| q.is_finite()).fold(0.0, f64::max))
}

/// The balls of each row.
fn row_pictures(state: &State, rows: usize, area: Rect, buffer: &mut Buffer) {
    let unknown = Balls::default();
    let balls = |row| state.balls.get(row).unwrap_or(&unknown);
    // One for all, so that they can be compared.
    let scale = (0..rows).map(|row| scale(balls(row))).fold(0.0, f64::max);
    let columns = (rows as f64).sqrt().ceil() as usize;
    let lines = Layout::vertical(vec![Constraint::Fill(1); rows.div_ceil(columns)]).split(area);
    for row in 0..rows {
        let line = lines[row / columns];
        let cells = Layout::horizontal(vec![Constraint::Fill(1); columns]).split(line);
        let name = match rows {
            1 => " ".into(),
            _ => format!(" row {row} "),
        };
        polar(balls(row), scale, &name, cells[row % columns], buffer);
    }
}

/// Draws the balls of a row with this force (N) at the rim.
fn polar(balls: &Balls, scale: f64, name: &str, area: Rect, buffer: &mut Buffer) {
    let worst = hardest(balls);
    let title = match worst {
        None => format!("{name}no balls known "),
        Some((ball, force)) => format!("{name}ball {ball}: {force:.0} N "),
    };
    // A braille dot is as wide as high, so that a circle stays one.
    let width = f64::from(area.width.saturating_sub(2).max(1));
    let height = 2.0 * f64::from(area.height.saturating_sub(2).max(1));
    let [x, y] = [width, height].map(|size| MARGIN * size / width.min(height));
    Canvas::default()
        .block(boxed(title).title_bottom(format!(" rim {} N ", scale as f32)))
        .marker(Marker::Braille)
        .x_bounds([-x, x])
        .y_bounds([-y, y])
        .paint(|picture| {
            for radius in [0.5, 1.0] {
                picture.draw(&Circle::new(0.0, 0.0, radius, FAINT));
            }
            picture.layer();
            let count = balls.balls.len();
            let place = |i: usize| places(balls, i % count, scale);
            for i in 0..count {
                let (Some(a), Some(b)) = (place(i), place(i + 1)) else {
                    continue;
                };
                for (race, colour) in [(1, OUTER), (0, INNER)] {
                    let ((x1, y1), (x2, y2)) = (a[race], b[race]);
                    picture.draw(&canvas::Line::new(x1, y1, x2, y2, colour));
                }
            }
            picture.layer();
            let worst = worst.map(|(ball, _)| ball);
            if let Some([(x, y), _]) = worst.and_then(place) {
                picture.draw(&canvas::Line::new(0.0, 0.0, x, y, WORST));
            }
            // Eight numbers have room, and the numbers of the balls to look at.
            let step = count.div_ceil(8);
            for (i, ball) in balls.balls.iter().enumerate() {
                let colour = match ball {
                    Some(ball) if ball.q_i == 0.0 => UNLOADED,
                    _ if worst == Some(i) => WORST,
                    _ if i % step == 0 => FAINT,
                    _ => continue,
                };
                let (sin, cos) = balls.azimuth(i).sin_cos();
                picture.print(1.12 * cos, 1.12 * sin, i.to_string().fg(colour));
            }
        })
        .render(area, buffer);
}

/// Alarms that are about probes.
const OF_PROBES: [Alarm; 3] = [Alarm::StiffnessLoss, Alarm::StiffnessGain, Alarm::Probe];

/// Measured over computed displacement, a line a probe; none without probes.
fn probe_lines(state: &State) -> Vec<Line<'static>> {
    let Some(report) = &state.probes else {
        return Vec::new();
    };
    let probes = report.probes.iter().enumerate().map(|(i, probe)| {
        let ratio = probe.ratio.map_or("no reference yet".into(), |ratio| {
            let [value, error] = [ratio.value, ratio.error].map(|x| 100.0 * x);
            format!("compliance {value:.2} +- {error:.2} % of that at commissioning")
        });
        let (steps, age) = (probe.steps, probe.age);
        let name = probe.state.name();
        let words = format!(" probe {i} {name}: {ratio}, {steps} load steps, last {age} ticks ago");
        let is_amiss = !matches!(probe.state, response::State::Learning | response::State::Ok);
        Line::styled(words, flag(is_amiss))
    });
    let mut lines: Vec<_> = probes.collect();
    if report.aliased {
        let words = "   runout cannot be told from drift at this speed: readings are not used";
        lines.push(words.into());
    }
    lines
}

fn alarm_table(state: &State) -> Table<'static> {
    let rows = state.standing().map(|(since, report)| {
        let style = match report.state {
            AlarmState::Raised => flag(true).bold(),
            AlarmState::Latched => Style::new().fg(Color::Yellow),
            _ => Style::new().fg(FAINT),
        };
        let is_of_probes = OF_PROBES.contains(&report.alarm);
        let ball = report.place.filter(|_| !is_of_probes);
        let ball = ball.and_then(|of| state.row_and_ball(of));
        let place = match (ball, report.place) {
            (Some((row, ball)), _) if state.row_count() > 1 => format!("row {row} ball {ball}"),
            (_, Some(probe)) if is_of_probes => format!("probe {probe}"),
            (_, Some(ball)) => format!("ball {ball}"),
            (_, None) => String::new(),
        };
        let row = Row::new([
            format!(" {}", report.alarm.name()),
            report.state.name().into(),
            against(report.alarm, report.value, report.limit),
            place,
            format!("since {:.2} s", *since as f64 * 1e-6),
            format!("{} times", report.raised),
        ]);
        row.style(style)
    });
    let mut rows: Vec<_> = rows.collect();
    if rows.is_empty() {
        rows.push(Row::new([" none"]));
    }
    let title = match state.unacknowledged() {
        0 => " alarms ".into(),
        count => format!(" alarms: {count} not acknowledged "),
    };
    Table::new(rows, [16, 12, 26, 14, 18, 12]).block(boxed(title))
}

/// A number of any size in few columns.
fn short(x: f32) -> String {
    match x.abs() {
        0.0 | 1e-3..1e5 => format!("{x:.3}"),
        _ => format!("{x:.3e}"),
    }
}

/// The last reports of monitor and board, field by field under their names in JSON, and the counts of the link.
fn health(state: &State) -> Paragraph<'static> {
    let mut lines = Vec::new();
    for (title, report) in &state.reports {
        let mut words = vec![format!(" {title}:").bold()];
        fields("", report, &mut words);
        lines.push(Line::from(words));
    }
    let mut link = format!(" {}", state.tally);
    if let Some(error) = state.last_damage {
        link += &format!(", last: {error}");
    }
    let is_hurt = state.tally.lost + state.tally.damaged > 0;
    lines.push(Line::from(vec![
        " link:".bold(),
        Span::styled(link, flag(is_hurt)),
    ]));
    let mut block = boxed(" health ");
    if let Some(said) = &state.said {
        block = block.title_bottom(format!(" {said} "));
    }
    Paragraph::new(lines)
        .block(block)
        .wrap(Wrap { trim: false })
}

/// Adds names and values of a report's fields. A blank that does not break keeps them together.
fn fields(path: &str, value: &Value, words: &mut Vec<Span<'static>>) {
    if let Value::Object(of) = value {
        for (name, value) in of {
            // Bits, and counts of a row of alarms.
            if !matches!(&**name, "alarms" | "marks" | "raised") {
                fields(&format!("{path} {name}"), value, words);
            }
        }
        return;
    }
    let path = path.trim_start();
    words.push(format!("  {}", path.replace(' ', ".")).fg(FAINT));
    let name = path.rsplit(' ').next().unwrap_or(path);
    let values = value
        .as_array()
        .map_or(slice::from_ref(value), Vec::as_slice);
    for value in values {
        let text = match value {
            Value::String(word) => word.clone(),
            Value::Number(number) if number.is_f64() => {
                short(number.as_f64().unwrap_or(f64::NAN) as f32)
            }
            _ => value.to_string(),
        };
        let style = flag(is_amiss(name, value));
        words.push(Span::styled(format!("\u{a0}{text}"), style));
    }
}

/// Whether a value tells of a fault.
fn is_amiss(name: &str, value: &Value) -> bool {
    match (name, value.as_str().unwrap_or_default()) {
        ("availability", _) => value.as_f64().is_some_and(|share| share < 0.9),
        ("corrupt" | "damaged" | "disordered" | "failed", "") => *value != json!(0),
        ("late" | "lost" | "missed_ticks" | "overruns", "") => *value != json!(0),
        (_, "assumed" | "damaged" | "failed" | "held" | "no-memory") => true,
        (_, "other-spindle" | "other-version") => true,
        _ => false,
    }
}

/// Shows a stream until its reader presses q, Esc or Ctrl-C. At the end of the stream the view stays.
///
/// # Errors
///
/// The terminal cannot be used, the stream cannot be read, or [`Session::take`] fails.
pub fn view(chunks: &Chunks, session: &mut Session) -> Result<()> {
    let mut terminal = ratatui::try_init()?;
    let shown = follow(&mut terminal, chunks, session);
    ratatui::restore();
    shown
}

fn follow(terminal: &mut DefaultTerminal, chunks: &Chunks, session: &mut Session) -> Result<()> {
    loop {
        terminal.draw(|frame| render(&session.state, frame.area(), frame.buffer_mut()))?;
        let next = Instant::now() + REFRESH;
        while let left = next.saturating_duration_since(Instant::now())
            && !left.is_zero()
        {
            match chunks.recv_timeout(left) {
                Ok(chunk) => session.take(&chunk.context("cannot read on")?)?,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => std::thread::sleep(left),
            }
        }
        while event::poll(Duration::ZERO)? {
            let Some(key) = event::read()?.as_key_press_event() else {
                continue;
            };
            match key.code {
                KeyCode::Char('q') | KeyCode::Esc => return Ok(()),
                KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => {
                    return Ok(());
                }
                KeyCode::Char(key) => press(key, session),
                _ => {}
            }
        }
    }
}

fn press(key: char, session: &mut Session) {
    let said = match &mut session.operator {
        Some(operator) => operator.press(key, &session.state),
        None => wants_a_board(key).then(|| "not from a port: there is no board to tell".into()),
    };
    session.state.said = said.or(session.state.said.take());
}
