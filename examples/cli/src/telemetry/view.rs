//! The live view: each row with its place and its load, stiffness and preload over time, alarms and health in words. A polar picture of each
//! row shows the balls' forces.

use super::session::Session;
use super::source::Chunks;
use crate::telemetry::findings;
use crate::telemetry::health::Health;
use crate::telemetry::operator::wants_a_board;
use crate::telemetry::state::{Balls, FRESH, Point, State, facing};
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
use spindle_bearing::Frequencies;
use spindle_file::monitors::against;
use spindle_monitor::Alarm;
use spindle_monitor::estimator::{self, Estimate};
use spindle_monitor::judgement::AlarmState;
use std::ops::Range;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

/// Seconds of the course that are shown.
const WINDOW: f64 = 60.0;

/// Seconds from one bar of the preload's error to the next.
const BARS: f64 = 1.0;

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
    let alarms = alarm_lines(state);
    let probes = probe_lines(state);
    let health = health_lines(state);
    // A line more for words that do not fit at the end of one.
    let lines = health
        .iter()
        .map(|line| 1 + line.width() as u16 / area.width.max(1));
    let lines: u16 = lines.sum();
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
        Constraint::Length(alarms.len() as u16 + 2),
        Constraint::Length(lines + 3),
    ])
    .areas(area);
    // Cells are about twice as high as wide.
    let wanted = middle.height.saturating_mul(2 * count as u16);
    let [left, right] = Layout::horizontal([
        Constraint::Min(30),
        Constraint::Length(wanted.min(area.width / 2)),
    ])
    .areas(middle);
    let [linear, below_it] = Layout::vertical([Constraint::Fill(1); 2]).areas(left);
    Paragraph::new(header(state)).render(head, buffer);
    Widget::render(row_table(state), table, buffer);
    stiffness(state, "N/um", 0..3, 1e-6, linear, buffer);
    match state.preload() {
        Some(now) => preload(state, now, below_it, buffer),
        None => stiffness(state, "kN m/rad", 3..5, 1e-3, below_it, buffer),
    }
    row_pictures(state, count, right, buffer);
    Paragraph::new(probes).render(seen, buffer);
    let title = match state.unacknowledged() {
        0 => " alarms ".into(),
        count => format!(" alarms: {count} not acknowledged "),
    };
    let alarms = Paragraph::new(alarms).block(boxed(title));
    alarms.render(below, buffer);
    let mut frame = boxed(" health ");
    if let Some(said) = &state.said {
        frame = frame.title_bottom(format!(" {said} "));
    }
    let health = Paragraph::new(health).block(frame);
    health.wrap(Wrap { trim: false }).render(counters, buffer);
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

/// A curve over time.
type Curve = (Color, Vec<(f64, f64)>);

/// Times of the course that are shown, s, and its points. A doubted sample leaves a gap: its estimate is an older one.
fn shown(state: &State) -> ([f64; 2], impl Iterator<Item = &Point> + Clone) {
    let end = state.history.back().map_or(0.0, |point| point.time);
    let first = state.history.front().map_or(0.0, |point| point.time);
    let start = (end - WINDOW).max(first);
    let points = state.history.iter();
    let points = points.filter(move |point| point.trusted && point.time >= start);
    ([start, end.max(start + 1.0)], points)
}

/// Some of the stiffness at the nose over time, and the last values.
fn stiffness(
    state: &State,
    unit_name: &str,
    elements: Range<usize>,
    unit: f64,
    area: Rect,
    buffer: &mut Buffer,
) {
    let (times, points) = shown(state);
    let mut title = vec![Span::raw(" at the nose: ")];
    let mut curves = Vec::new();
    for i in elements {
        let (name, colour) = DIRECTIONS[i];
        let points = points.clone();
        let curve: Vec<_> = points
            .map(|point| (point.time, f64::from(point.stiffness[i]) * unit))
            .collect();
        let last = curve.last().map_or("?".into(), |(_, y)| format!("{y:.1}"));
        title.push(format!("{name} {last}  ").fg(colour));
        curves.push((colour, curve));
    }
    title.push(format!("{unit_name} ").into());
    let highest = curves.iter().flat_map(|(_, curve)| curve);
    let highest = highest.fold(0.0, |most, (_, y)| f64::max(most, *y));
    course(
        times,
        [0.0, round_up(highest)],
        title,
        &curves,
        area,
        buffer,
    );
}

/// The preload over time, and that of now: with two standard errors, where probes have measured it.
fn preload(state: &State, now: Estimate, area: Rect, buffer: &mut Buffer) {
    let (times, points) = shown(state);
    let known = points.filter_map(|point| Some((point.time, point.preload?)));
    let known = known.map(|(time, of)| (time, [of.value, 2.0 * of.error].map(f64::from)));
    let known: Vec<_> = known
        .filter(|(_, of)| of.iter().all(|x| x.is_finite()))
        .collect();
    let ends = known
        .iter()
        .map(|(_, [value, error])| [value - error, value + error]);
    let ends = ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let [least, most] = ends.unwrap_or([0.0, 1.0]);
    // A steady preload is a line in the middle.
    let size = most.abs().max(least.abs()).max(f64::MIN_POSITIVE);
    let step = 10_f64.powf(size.log10().floor() - 1.0);
    let bottom = step * ((least - 0.1 * size).max(0.0) / step).floor();
    let top = step * ((most + 0.1 * size) / step).ceil();
    let mut curve: Vec<_> = known
        .iter()
        .map(|(time, [value, _])| (*time, *value))
        .collect();
    // A bar at times, of as many levels as there are dots.
    let dots = 4 * i32::from(area.height.max(1));
    for bar in known.chunk_by(|a, b| (a.0 / BARS).floor() == (b.0 / BARS).floor()) {
        let (time, [value, error]) = bar[0];
        let levels = (-dots..=dots).map(|i| f64::from(i) / f64::from(dots));
        curve.extend(levels.map(|part| (time, value + part * error)));
    }
    let title = match &state.probes {
        Some(_) => format!("{:.0} +- {:.0} N measured", now.value, now.error),
        None => format!("{:.0} N computed", now.value),
    };
    let title = vec![" preload: ".into(), title.fg(INNER), " ".into()];
    course(times, [bottom, top], title, &[(INNER, curve)], area, buffer);
}

/// Curves between two levels.
fn course(
    times: [f64; 2],
    [bottom, top]: [f64; 2],
    title: Vec<Span<'_>>,
    curves: &[Curve],
    area: Rect,
    buffer: &mut Buffer,
) {
    let datasets = curves.iter().map(|(colour, curve)| {
        let dataset = Dataset::default().marker(Marker::Braille);
        dataset.fg(*colour).data(curve)
    });
    let x = times.map(|time| format!("{time:.0} s"));
    let y = [bottom, 0.5 * (bottom + top), top];
    let labels = y.map(|y| (y as f32).to_string());
    Chart::new(datasets.collect())
        .block(boxed(title))
        .x_axis(Axis::default().bounds(times).style(FAINT).labels(x))
        .y_axis(
            Axis::default()
                .bounds([bottom, top])
                .style(FAINT)
                .labels(labels),
        )
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

/// How the spindle stands by its probes, and then each of them; none without probes.
fn probe_lines(state: &State) -> Vec<Line<'static>> {
    use estimator::State as S;
    let Some(report) = &state.probes else {
        return Vec::new();
    };
    let line = |name: String, of: S, words: String| {
        let is_amiss = !matches!(of, S::Learning | S::Unknown | S::Ok);
        Line::styled(format!(" {name} {}: {words}", of.name()), flag(is_amiss))
    };
    let spindle = findings::of_spindle(report);
    let mut lines = vec![line("spindle".into(), report.state, spindle)];
    for (i, probe) in report.probes.iter().enumerate() {
        let words = findings::of_probe(probe);
        lines.push(line(format!("probe {i}"), probe.state, words));
    }
    if report.aliased {
        let words = " runout cannot be told from drift at this speed: readings do not count";
        lines.push(words.into());
    }
    lines
}

/// Alarms that stand or want attention, a line each, and where to look, which the name of some does not say.
fn alarm_lines(state: &State) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    for (since, report) in state.standing() {
        let style = match report.state {
            AlarmState::Raised => flag(true).bold(),
            AlarmState::Latched => Style::new().fg(Color::Yellow),
            _ => Style::new().fg(FAINT),
        };
        let (place, look_at) = match (report.alarm, report.place) {
            (Alarm::Probe, Some(probe)) => (format!("probe {probe}"), None),
            (Alarm::StiffnessLoss | Alarm::StiffnessGain, Some(probe)) => {
                let look_at = "a support, the probe, its mount or the load cells";
                (format!("probe {probe}"), Some(look_at))
            }
            (_, Some(ball)) => match state.row_and_ball(ball) {
                Some((row, ball)) if state.row_count() > 1 => {
                    (format!("row {row} ball {ball}"), None)
                }
                _ => (format!("ball {ball}"), None),
            },
            (_, None) => (String::new(), None),
        };
        let line = format!(
            " {:<16} {:<12} {:<26} {place:<14} since {:.2} s, {} times",
            report.alarm.name(),
            report.state.name(),
            against(report.alarm, report.value, report.limit),
            *since as f64 * 1e-6,
            report.raised,
        );
        lines.push(Line::styled(line, style));
        lines.extend(look_at.map(|words| Line::styled(format!("   {words}"), style)));
    }
    if lines.is_empty() {
        lines.push(" none".into());
    }
    lines
}

/// Troubles of monitor, board and link, then their other figures.
fn health_lines(state: &State) -> Vec<Line<'static>> {
    let Health { wrong, rest } = Health::of(state);
    let lists = [(wrong, true), (rest, false)].into_iter();
    let lists = lists.filter(|(words, _)| !words.is_empty());
    let lines = lists
        .map(|(words, is_wrong)| Line::styled(format!(" {}", words.join("; ")), flag(is_wrong)));
    lines.collect()
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
