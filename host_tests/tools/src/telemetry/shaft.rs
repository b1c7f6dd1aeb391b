//! The shaft from the side: its rows, how they face, the nose, and where loads are measured.

use super::style::{FAINT, INNER, OUTER, WORST, boxed};
use host_tests::telemetry::state::{State, facing};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::Line;
use ratatui::widgets::Widget;
use ratatui::widgets::canvas::{self, Canvas, Circle, Context, Rectangle};
use spindle_bearing::monitor::telemetry::{RowPlace, ShaftReport};

const NOSE: Color = Color::Yellow;
const LOADS: Color = Color::Magenta;

/// Tangent of the contact angle that is drawn. That of the balls is hard to see.
const SLANT: f64 = 0.8;

/// Draws the shaft.
pub(super) fn render(state: &State, shaft: &ShaftReport, area: Rect, buffer: &mut Buffer) {
    let facings: Vec<_> = shaft.rows.iter().map(|row| facing(row).name()).collect();
    let (shown, all) = (shaft.rows.len(), usize::from(shaft.count));
    let part = match all > shown {
        true => format!("{shown} of {all} "),
        false => String::new(),
    };
    let title = format!(" shaft: {part}rows {} ", facings.join(" "));
    let mut legend = vec![" nose".fg(NOSE), " loads ".fg(LOADS)];
    if shaft.preload > 0.0 {
        legend.push(format!(" mounted with {:.0} N ", shaft.preload).into());
    }
    // Braille has two dots along the width of a cell and four along its height.
    let width = 2.0 * f64::from(area.width.saturating_sub(2));
    let half = 2.0 * f64::from(area.height.saturating_sub(2));
    Canvas::default()
        .block(boxed(title).title_bottom(Line::from(legend)))
        .marker(Marker::Braille)
        .x_bounds([0.0, width])
        .y_bounds([-half, half])
        .paint(|picture| paint(picture, state, shaft, width, half))
        .render(area, buffer);
}

/// Draws rows, nose and loads at their places along the width, and the shaft from the axis up and down to a third of
/// `half`, dots.
fn paint(picture: &mut Context<'_>, state: &State, shaft: &ShaftReport, width: f64, half: f64) {
    let rows = shaft.rows.iter().map(|row| row.position);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for position in rows.chain([shaft.nose, shaft.loads_at]).map(f64::from) {
        (least, most) = (least.min(position), most.max(position));
    }
    let x = |position: f32| {
        let part = (f64::from(position) - least) / (most - least).max(1e-9);
        // A row at an end needs room for its contact lines.
        width * (0.15 + 0.7 * part)
    };
    let bore = 0.3 * half;
    let nose = x(shaft.nose);
    // The other end is beyond all rows.
    let end = if nose < 0.5 * width { 0.95 } else { 0.05 } * width;
    picture.draw(&Rectangle {
        x: nose.min(end),
        y: -bore,
        width: (nose - end).abs(),
        height: 2.0 * bore,
        color: FAINT,
    });
    for (i, place) in shaft.rows.iter().enumerate() {
        let colour = match state.rows.get(i) {
            _ if state.is_lifted(i) => WORST,
            Some(Some(_)) => INNER,
            _ => FAINT,
        };
        row(picture, place, x(place.position), half, colour);
        let name = i.to_string().fg(Color::Reset);
        picture.print(x(place.position), half, name);
    }
    for (x, colour) in [(x(shaft.loads_at), LOADS), (nose, NOSE)] {
        picture.draw(&canvas::Line::new(x, 0.0, x, -half, colour));
        picture.draw(&Circle::new(x, 0.0, 1.5, colour));
    }
}

/// Draws a row: rings and ball above the axis and below it, and its contact lines, which meet on the axis.
fn row(picture: &mut Context<'_>, place: &RowPlace, x: f64, half: f64, colour: Color) {
    let (bore, rim) = (0.3 * half, 0.8 * half);
    let (ball, ring) = (0.5 * (bore + rim), rim - bore);
    let towards = facing(place).sign::<f64>() * SLANT;
    for side in [-1.0, 1.0] {
        picture.draw(&Rectangle {
            x: x - 0.5 * ring,
            y: side * ball - 0.5 * ring,
            width: ring,
            height: ring,
            color: OUTER,
        });
        picture.draw(&Circle::new(x, side * ball, 0.25 * ring, OUTER));
        let outer = x + towards * (half - ball);
        let apex = x - towards * ball;
        picture.draw(&canvas::Line::new(apex, 0.0, outer, side * half, colour));
    }
}
