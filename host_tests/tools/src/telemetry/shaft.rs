//! The shaft from the side: its rows, how they face, the nose, and where loads are measured.

use super::view::{FAINT, INNER, OUTER, WORST};
use host_tests::telemetry::state::{State, facing};
use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::Line;
use ratatui::widgets::canvas::{self, Canvas, Circle, Context, Points, Rectangle};
use ratatui::widgets::{Block, Widget};
use spindle_bearing::monitor::telemetry::{RowPlace, ShaftReport};

const NOSE: Color = Color::Yellow;
const LOADS: Color = Color::Magenta;

/// Tangent of the contact angle that is drawn. That of the balls is hard to see.
const SLANT: f64 = 0.8;
/// Lines of labels above the shaft, and below it.
const MOST_LINES: u16 = 2;

/// Draws the shaft.
pub(super) fn render(state: &State, shaft: &ShaftReport, area: Rect, buffer: &mut Buffer) {
    let faint = Style::new().fg(FAINT);
    let mut block = Block::bordered()
        .title(title(state, shaft))
        .border_style(faint);
    if shaft.preload > 0.0 {
        let mounted = format!(" mounted with {:.0} N ", shaft.preload);
        block = block.title_bottom(Line::from(mounted).right_aligned());
    }
    let inner = block.inner(area);
    block.render(area, buffer);
    let scale = Scale::new(shaft, inner);
    let above = arrange(row_labels(state, shaft, &scale), inner.width);
    let below = arrange(point_labels(shaft, &scale), inner.width);
    let [top, middle, bottom] = Layout::vertical([
        Constraint::Length(lines(&above)),
        Constraint::Min(4),
        Constraint::Length(lines(&below)),
    ])
    .areas(inner);
    print(above, top, buffer);
    print(below, bottom, buffer);
    let width = 2.0 * f64::from(inner.width);
    let half = 2.0 * f64::from(middle.height);
    Canvas::default()
        .marker(Marker::Braille)
        .x_bounds([0.0, width])
        .y_bounds([-half, half])
        .paint(|picture| paint(picture, state, shaft, &scale, half))
        .render(middle, buffer);
}

fn title(state: &State, shaft: &ShaftReport) -> String {
    let facings: Vec<_> = shaft.rows.iter().map(|row| facing(row).name()).collect();
    let facings = facings.join(" ");
    let preload = if state.is_opposed() {
        " and their preload"
    } else {
        ""
    };
    let (shown, all) = (shaft.rows.len(), usize::from(shaft.count));
    let part = if all > shown {
        format!("{shown} of {all} ")
    } else {
        String::new()
    };
    format!(" shaft: {part}rows {facings}{preload} ")
}

/// From positions on the shaft to dots of braille from the left.
struct Scale {
    least: f64,
    dots_per_m: f64,
    /// Dots to the left of what has a position.
    left: f64,
    width: f64,
}

impl Scale {
    fn new(shaft: &ShaftReport, area: Rect) -> Self {
        let rows = shaft.rows.iter().map(|row| row.position);
        let (first, last) = ends(rows.clone());
        let (least, most) = ends(rows.chain([shaft.nose, shaft.loads_at]));
        let width = 2.0 * f64::from(area.width);
        // A row needs room for its contact lines, a point for its name.
        let [wide, narrow] = [1.5, 1.0].map(|part| part * f64::from(area.height).min(width / 8.0));
        let left = if first > least { narrow } else { wide };
        let right = if last < most { narrow } else { wide };
        let span = if most > least { most - least } else { 1.0 };
        Self {
            least,
            dots_per_m: (width - left - right) / span,
            left,
            width,
        }
    }

    fn dots(&self, position: f32) -> f64 {
        self.left + (f64::from(position) - self.least) * self.dots_per_m
    }
}

/// The smallest and the largest one.
fn ends(positions: impl Iterator<Item = f32>) -> (f64, f64) {
    let numbers = positions.map(f64::from).filter(|x| x.is_finite());
    numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| {
        (least.min(x), most.max(x))
    })
}

/// A text, and how many cells from the left its middle should be.
struct Label {
    middle: f64,
    text: String,
    colour: Color,
}

fn row_labels(state: &State, shaft: &ShaftReport, scale: &Scale) -> Vec<Label> {
    let is_opposed = state.is_opposed();
    let places = shaft.rows.iter().map(|row| scale.dots(row.position));
    // Two dots a cell.
    let is_tight = nearest(places) < 2.0 * 14.0;
    let labels = shaft.rows.iter().enumerate().map(|(i, place)| {
        let report = state.rows.get(i).and_then(Option::as_ref);
        let text = match report {
            Some(at) if is_opposed && is_tight => format!("{i}: {:.0} N", at.report.preload),
            Some(at) if is_opposed => format!("row {i}: {:.0} N", at.report.preload),
            _ => format!("row {i}"),
        };
        Label {
            middle: 0.5 * scale.dots(place.position),
            text,
            colour: if state.is_lifted(i) {
                WORST
            } else {
                Color::Reset
            },
        }
    });
    labels.collect()
}

fn point_labels(shaft: &ShaftReport, scale: &Scale) -> Vec<Label> {
    let label = |text: &str, position, colour| Label {
        middle: 0.5 * scale.dots(position),
        text: text.into(),
        colour,
    };
    if shaft.nose == shaft.loads_at {
        return vec![label("nose, loads", shaft.nose, NOSE)];
    }
    vec![
        label("nose", shaft.nose, NOSE),
        label("loads", shaft.loads_at, LOADS),
    ]
}

/// Gives each label a line and a column where it covers no other one. What has no place at all is left out.
fn arrange(mut labels: Vec<Label>, width: u16) -> Vec<(u16, u16, Label)> {
    labels.sort_by(|a, b| a.middle.total_cmp(&b.middle));
    // Columns up to which each line is full.
    let mut full = [0; MOST_LINES as usize];
    let mut arranged = Vec::new();
    for label in labels {
        let length = label.text.chars().count() as u16;
        let Some(last) = width.checked_sub(length) else {
            continue;
        };
        let column = (label.middle - 0.5 * f64::from(length)).round().max(0.0) as u16;
        let column = column.min(last);
        let place = (0..).zip(&mut full).find(|(_, end)| column >= **end);
        if let Some((line, end)) = place {
            // A blank between two.
            *end = column + length + 1;
            arranged.push((line, column, label));
        }
    }
    arranged
}

fn lines(arranged: &[(u16, u16, Label)]) -> u16 {
    let last = arranged.iter().map(|(line, ..)| *line).max();
    last.map_or(0, |line| line + 1)
}

fn print(arranged: Vec<(u16, u16, Label)>, area: Rect, buffer: &mut Buffer) {
    for (line, column, label) in arranged {
        let length = label.text.chars().count() as u16;
        let place = Rect::new(area.x + column, area.y + line, length, 1);
        Line::styled(label.text, Style::new().fg(label.colour))
            .render(place.intersection(area), buffer);
    }
}

/// Draws shaft, rows and points, with y up from the axis to `half`, dots.
fn paint(picture: &mut Context<'_>, state: &State, shaft: &ShaftReport, scale: &Scale, half: f64) {
    let axis = (0_u16..).map(|i| (4.0 * f64::from(i), 0.0));
    let axis: Vec<_> = axis.take_while(|(x, _)| *x < scale.width).collect();
    picture.draw(&Points {
        coords: &axis,
        color: FAINT,
    });
    let places = || shaft.rows.iter().map(|row| scale.dots(row.position));
    let (first, last) = places().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| {
        (least.min(x), most.max(x))
    });
    let bore = 0.3 * half;
    let nose = scale.dots(shaft.nose);
    // It ends at its nose, if that is on one side of all rows.
    let left = if nose < first {
        nose
    } else {
        (first - half).max(0.0)
    };
    let right = if nose > last {
        nose
    } else {
        (last + half).min(scale.width)
    };
    picture.draw(&Rectangle {
        x: left,
        y: -bore,
        width: right - left,
        height: 2.0 * bore,
        color: FAINT,
    });
    let half_width = (0.3 * half).min(0.4 * nearest(places()));
    for (i, place) in shaft.rows.iter().enumerate() {
        let colour = match state.rows.get(i) {
            _ if state.is_lifted(i) => WORST,
            Some(Some(_)) => INNER,
            _ => FAINT,
        };
        row(
            picture,
            place,
            scale.dots(place.position),
            [bore, half, half_width],
            colour,
        );
    }
    for (position, colour) in [(shaft.loads_at, LOADS), (shaft.nose, NOSE)] {
        let x = scale.dots(position);
        picture.draw(&canvas::Line {
            x1: x,
            y1: 0.0,
            x2: x,
            y2: -half,
            color: colour,
        });
        picture.draw(&Circle {
            x,
            y: 0.0,
            radius: 1.5,
            color: colour,
        });
    }
}

/// The least distance of two neighbours.
fn nearest(places: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<_> = places.collect();
    sorted.sort_by(f64::total_cmp);
    let pairs = sorted.iter().zip(sorted.iter().skip(1));
    pairs.map(|(a, b)| b - a).fold(f64::INFINITY, f64::min)
}

/// Draws a row: rings and ball above the axis and below it, and its contact lines, which meet on the axis.
fn row(
    picture: &mut Context<'_>,
    place: &RowPlace,
    x: f64,
    [bore, half, half_width]: [f64; 3],
    colour: Color,
) {
    let rim = 0.85 * half;
    let ball = 0.5 * (bore + rim);
    let towards = facing(place).sign::<f64>() * SLANT;
    for side in [-1.0, 1.0] {
        let (low, high) = if side > 0.0 {
            (bore, rim)
        } else {
            (-rim, -bore)
        };
        picture.draw(&Rectangle {
            x: x - half_width,
            y: low,
            width: 2.0 * half_width,
            height: high - low,
            color: OUTER,
        });
        picture.draw(&Circle {
            x,
            y: side * ball,
            radius: 0.25 * (rim - bore),
            color: OUTER,
        });
        picture.draw(&canvas::Line {
            x1: x - towards * ball,
            y1: 0.0,
            x2: x + towards * (half - ball),
            y2: side * half,
            color: colour,
        });
    }
}
