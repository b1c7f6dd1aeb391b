//! Figures of the validation book as SVG, in one style.
//!
//! A figure brings its own light background, so that it reads the same on a light and on a dark page.

use anyhow::{Context, Result};
use host_tests::validation::figure::{
    Axis, Colour, Dash, Figure, INK, Marker, Panel, Pen, Plane, Ticks,
};
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::f64::consts::TAU;
use std::path::Path;

const BACKGROUND: RGBColor = RGBColor(0xF7, 0xF8, 0xFA);
const GRID: RGBColor = RGBColor(0xD5, 0xDA, 0xE1);
const DARK: RGBColor = rgb(INK);

const MARGIN: i32 = 24;
const HEADING: u32 = 56;
const LEGEND_ROW: i32 = 36;
/// Width of a figure, px.
const WIDTH: u32 = 1500;

const fn rgb(Colour(red, green, blue): Colour) -> RGBColor {
    RGBColor(red, green, blue)
}

/// Draws a figure into `folder`.
///
/// # Errors
///
/// The file cannot be written.
pub fn draw(figure: &Figure, folder: &Path) -> Result<()> {
    let path = folder.join(format!("{}.svg", figure.name));
    std::fs::write(&path, svg(figure)?)
        .with_context(|| format!("cannot write {}; is the folder writable?", path.display()))
}

/// The figure as SVG.
///
/// # Errors
///
/// It cannot be drawn.
pub fn svg(figure: &Figure) -> Result<String> {
    let mut svg = String::new();
    draw_on(figure, SVGBackend::with_string(&mut svg, size(figure)))
        .with_context(|| format!("cannot draw the figure {}", figure.name))?;
    // The last line of a text file ends, too.
    if !svg.ends_with('\n') {
        svg.push('\n');
    }
    Ok(svg)
}

fn cell(figure: &Figure) -> (u32, u32) {
    let width = (WIDTH - 2 * MARGIN as u32) / figure.columns as u32;
    let around = matches!(
        figure.panels.first().map(|p| &p.plane),
        Some(Plane::Around { .. })
    );
    let height = if around {
        width + 10
    } else if figure.columns == 1 {
        560
    } else {
        width * 4 / 5 + 30
    };
    (width, height)
}

/// Columns of the legend, and their width.
fn legend_columns(figure: &Figure) -> (usize, i32) {
    let longest = figure.legend.iter().map(|(_, l)| l.chars().count()).max();
    let width = 100 + 12 * longest.unwrap_or(0) as i32;
    let columns = ((WIDTH as i32 - 2 * MARGIN) / width.max(1)).max(1) as usize;
    (columns, width)
}

fn size(figure: &Figure) -> (u32, u32) {
    let rows = figure.panels.len().div_ceil(figure.columns) as u32;
    let legend = figure.legend.len().div_ceil(legend_columns(figure).0) as u32;
    let height = HEADING + legend * LEGEND_ROW as u32 + rows * cell(figure).1 + MARGIN as u32;
    (WIDTH, height)
}

fn draw_on(figure: &Figure, backend: SVGBackend) -> Result<()> {
    let root = backend.into_drawing_area();
    root.fill(&BACKGROUND)?;
    root.draw(&Text::new(
        figure.title.as_str(),
        (MARGIN, 18),
        bold(26, &DARK),
    ))?;
    let (columns, width) = legend_columns(figure);
    for (i, (pen, label)) in figure.legend.iter().enumerate() {
        let x = MARGIN + (i % columns) as i32 * width;
        let y = HEADING as i32 + (i / columns) as i32 * LEGEND_ROW + 14;
        stroke(&root, pen, &[(x, y), (x + 64, y)])?;
        mark(&root, pen, (x + 32, y))?;
        root.draw(&Text::new(label.as_str(), (x + 76, y - 11), plain(20)))?;
    }
    let legend = figure.legend.len().div_ceil(columns) as i32 * LEGEND_ROW;
    let (w, h) = cell(figure);
    for (i, panel) in figure.panels.iter().enumerate() {
        let x = MARGIN + (i % figure.columns) as i32 * w as i32;
        let y = HEADING as i32 + legend + (i / figure.columns) as i32 * h as i32;
        let area = root.clone().shrink((x as u32, y as u32), (w, h));
        match &panel.plane {
            Plane::Straight { x, y } => straight(&area, panel, x, y)?,
            Plane::Around { centre, rim, step } => around(&area, panel, [*centre, *rim], *step)?,
        }
    }
    root.present()?;
    Ok(())
}

/// Length of dash and gap, pixels.
fn lengths(dash: Dash) -> Option<(u32, u32)> {
    match dash {
        Dash::Solid | Dash::None => None,
        Dash::Long => Some((18, 9)),
        Dash::Short => Some((8, 7)),
        Dash::Dots => Some((3, 6)),
    }
}

/// Places of the ticks between `low` and `high`, and their numbers.
pub(crate) fn ticks(axis: &Axis, low: f64, high: f64) -> Vec<(f64, String)> {
    let step = match axis.ticks {
        Ticks::Some => tick_step(high - low, 5.0),
        Ticks::Every(step) => step,
        Ticks::Logarithmic => {
            let decades = low.floor() as i32..=high.ceil() as i32;
            let numbers = decades.flat_map(|d| [1.0, 2.0, 5.0].map(|n| n * 10f64.powi(d)));
            let ticks = numbers.map(|n| (n.log10(), n.to_string()));
            return ticks.filter(|(x, _)| (low..=high).contains(x)).collect();
        }
    };
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    let values = (first..=last).map(|i| i as f64 * step);
    values.map(|v| (v, tick_label(v, step))).collect()
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn plain(size: i32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&DARK)
}

fn bold(size: i32, colour: &RGBColor) -> TextStyle<'static> {
    ("sans-serif", size, FontStyle::Bold)
        .into_font()
        .color(colour)
}

/// A line of `pen` through pixels of `area`.
fn stroke(area: &Area, pen: &Pen, points: &[(i32, i32)]) -> Result<()> {
    let Pen(colour, dash, _) = pen;
    let colour = rgb(*colour);
    let style = colour.stroke_width(3);
    match (dash, lengths(*dash)) {
        (Dash::None, _) => {}
        (_, None) => area.draw(&PathElement::new(points.to_vec(), style))?,
        (_, Some((size, gap))) => area.draw(&DashedPathElement::new(
            points.iter().copied(),
            size,
            gap,
            style,
        ))?,
    }
    Ok(())
}

/// A marker of `pen` at a pixel of `area`.
fn mark(area: &Area, pen: &Pen, at: (i32, i32)) -> Result<()> {
    let Pen(colour, _, marker) = pen;
    let colour = rgb(*colour);
    match marker {
        Marker::None => {}
        Marker::Disc => area.draw(&Circle::new(at, 6, colour.filled()))?,
        Marker::Square => area.draw(&Rectangle::new(
            [(at.0 - 5, at.1 - 5), (at.0 + 5, at.1 + 5)],
            colour.filled(),
        ))?,
        Marker::Triangle => area.draw(&TriangleMarker::new(at, 9, colour.filled()))?,
        Marker::Cross => area.draw(&Cross::new(at, 6, colour.stroke_width(3)))?,
        Marker::Ring => {
            area.draw(&Circle::new(at, 7, BACKGROUND.filled()))?;
            area.draw(&Circle::new(at, 7, colour.stroke_width(3)))?;
        }
    }
    Ok(())
}

fn ring(area: &Area, at: (i32, i32)) -> Result<()> {
    area.draw(&Circle::new(at, 10, DARK.stroke_width(2)))?;
    Ok(())
}

/// Distance of the ticks of an axis that is `span` long, for about `count` of them.
pub(crate) fn tick_step(span: f64, count: f64) -> f64 {
    let rough = span / count;
    let decade = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|s| s * decade >= rough);
    step.unwrap_or(10.0) * decade
}

/// A number on an axis whose ticks are `step` apart.
pub(crate) fn tick_label(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    // A rounded negative nought.
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

/// The range of `values` with some room around.
pub(crate) fn range(values: impl Iterator<Item = f64>, zero: bool, room: f64) -> (f64, f64) {
    let start = if zero {
        (0.0, 0.0)
    } else {
        (f64::INFINITY, f64::NEG_INFINITY)
    };
    let (low, high) = values.fold(start, |(l, h), v| (l.min(v), h.max(v)));
    let span = (high - low)
        .max(1e-6 * high.abs().max(low.abs()))
        .max(f64::MIN_POSITIVE);
    let below = if zero && low >= 0.0 { 0.0 } else { room * span };
    let above = if zero && high <= 0.0 {
        0.0
    } else {
        room * span
    };
    (low - below, high + above)
}

fn straight(area: &Area, panel: &Panel, x: &Axis, y: &Axis) -> Result<()> {
    let points = || {
        panel
            .curves
            .iter()
            .flat_map(|c| c.line.iter().chain(&c.marks))
    };
    let (x0, x1) = range(points().map(|p| p.0), x.zero, 0.0);
    let (y0, y1) = range(points().map(|p| p.1), y.zero, 0.07);
    let (w, h) = area.dim_in_pixel();
    let (left, right, top, bottom) = (92, w as i32 - 24, 44, h as i32 - 76);
    let at = |(px, py): (f64, f64)| {
        let fx = (px - x0) / (x1 - x0);
        let fy = (py - y0) / (y1 - y0);
        (
            left + (fx * f64::from(right - left)).round() as i32,
            bottom - (fy * f64::from(bottom - top)).round() as i32,
        )
    };
    area.draw(&Text::new(
        panel.title.as_str(),
        (left, 10),
        bold(21, &DARK),
    ))?;

    let fine = DARK.stroke_width(1);
    for (value, number) in ticks(x, x0, x1) {
        let (px, _) = at((value, y0));
        area.draw(&PathElement::new(
            vec![(px, top), (px, bottom)],
            GRID.stroke_width(1),
        ))?;
        let style = plain(19).pos(Pos::new(HPos::Center, VPos::Top));
        area.draw(&Text::new(number, (px, bottom + 8), style))?;
    }
    for (value, number) in ticks(y, y0, y1) {
        let (_, py) = at((x0, value));
        area.draw(&PathElement::new(
            vec![(left, py), (right, py)],
            GRID.stroke_width(1),
        ))?;
        let style = plain(19).pos(Pos::new(HPos::Right, VPos::Center));
        area.draw(&Text::new(number, (left - 8, py), style))?;
    }
    if y0 < 0.0 && y1 > 0.0 {
        let (_, py) = at((x0, 0.0));
        area.draw(&PathElement::new(vec![(left, py), (right, py)], fine))?;
    }
    let frame = vec![(left, top), (left, bottom), (right, bottom)];
    area.draw(&PathElement::new(frame, DARK.stroke_width(2)))?;
    let style = plain(20).pos(Pos::new(HPos::Center, VPos::Top));
    area.draw(&Text::new(
        x.label.as_str(),
        ((left + right) / 2, bottom + 40),
        style,
    ))?;
    let style = plain(20)
        .transform(FontTransform::Rotate270)
        .pos(Pos::new(HPos::Center, VPos::Top));
    area.draw(&Text::new(y.label.as_str(), (6, (top + bottom) / 2), style))?;

    for curve in &panel.curves {
        let line: Vec<_> = curve.line.iter().map(|p| at(*p)).collect();
        stroke(area, &curve.pen, &line)?;
    }
    for curve in &panel.curves {
        for point in &curve.marks {
            mark(area, &curve.pen, at(*point))?;
        }
    }
    for node in &panel.nodes {
        ring(area, at(*node))?;
    }
    Ok(())
}

fn around(area: &Area, panel: &Panel, [least, most]: [f64; 2], step: f64) -> Result<()> {
    let (w, h) = area.dim_in_pixel();
    let centre = (w as i32 / 2, 46 + (h as i32 - 46) / 2);
    let radius = f64::from(w) / 2.0 - 52.0;
    let at = |(azimuth, value): (f64, f64)| {
        let r = radius * (value - least) / (most - least);
        (
            centre.0 + (r * azimuth.cos()).round() as i32,
            centre.1 - (r * azimuth.sin()).round() as i32,
        )
    };
    let style = bold(21, &DARK).pos(Pos::new(HPos::Center, VPos::Top));
    area.draw(&Text::new(panel.title.as_str(), (centre.0, 8), style))?;

    let rings = ((most - least) / step).round() as i32;
    for i in 1..=rings {
        let r = (radius * f64::from(i) / f64::from(rings)).round() as i32;
        let line = if i == rings {
            DARK.stroke_width(2)
        } else {
            GRID.stroke_width(2)
        };
        area.draw(&Circle::new(centre, r, line))?;
    }
    for spoke in 0..8 {
        let azimuth = f64::from(spoke) * TAU / 8.0;
        area.draw(&PathElement::new(
            vec![centre, at((azimuth, most))],
            GRID.stroke_width(1),
        ))?;
        let text = match spoke {
            0 => "0\u{b0} +y".to_owned(),
            2 => "90\u{b0} +z".to_owned(),
            _ => format!("{}\u{b0}", 45 * spoke),
        };
        let horizontal = match spoke {
            0 | 1 | 7 => HPos::Left,
            2 | 6 => HPos::Center,
            _ => HPos::Right,
        };
        let vertical = match spoke {
            0..=3 => VPos::Bottom,
            4 => VPos::Center,
            _ => VPos::Top,
        };
        let out = most + (most - least) * 8.0 / radius;
        let mut place = at((azimuth, out));
        if spoke == 0 {
            // Beside the rim there is no room for it; on the rim nothing else stands.
            place = (w as i32 - 50, centre.1 - 6);
        }
        let style = plain(18).pos(Pos::new(horizontal, vertical));
        area.draw(&Text::new(text, place, style))?;
    }

    for curve in &panel.curves {
        let mut line: Vec<_> = curve.line.iter().map(|p| at(*p)).collect();
        line.extend(line.first().copied());
        stroke(area, &curve.pen, &line)?;
    }
    for curve in &panel.curves {
        for point in &curve.marks {
            mark(area, &curve.pen, at(*point))?;
        }
    }
    for node in &panel.nodes {
        ring(area, at(*node))?;
    }
    // Last, on plates of their own, so that no curve runs through a number.
    for i in 1..=rings {
        let value = least + step * f64::from(i);
        let (x, y) = at((-TAU / 32.0, value));
        let text = tick_label(value, step);
        let half = 6 * text.chars().count() as i32;
        area.draw(&Rectangle::new(
            [(x - half, y - 10), (x + half, y + 10)],
            BACKGROUND.mix(0.85).filled(),
        ))?;
        let style = plain(18).pos(Pos::new(HPos::Center, VPos::Center));
        area.draw(&Text::new(text, (x, y), style))?;
    }
    Ok(())
}
