//! The one chart: panels of curves over straight axes, with one legend, as SVG.
//!
//! A picture brings its own light background, and reads as well on a dark page.

#![expect(missing_docs, reason = "names of fields say enough")]

use anyhow::Result;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use serde::Deserialize;
use std::ops::Range;

/// A picture: panels side by side or below each other, one legend.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Chart {
    pub title: String,
    pub panels: Vec<Panel>,
    /// Panels side by side; 0 counts as 1.
    pub columns: usize,
}

/// Curves in one pair of axes.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Panel {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub curves: Vec<Curve>,
}

/// An axis of a panel.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Axis {
    pub label: String,
    /// Lowest and highest value; those of the curves, if none are given.
    pub range: Option<(f64, f64)>,
    pub logarithmic: bool,
}

/// A curve, broken where a point is not finite or outside the axes.
///
/// Curves of one name share a colour and an entry of the legend; a curve without a name has no entry.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Curve {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    pub style: Style,
}

/// The look of a curve.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Style {
    #[default]
    Line,
    Dashed,
    /// A marker at every point.
    Dots,
    /// A filled area: its points are (x, low), then (x, high) backwards.
    Band,
}

/// Steps in a pixel: plotters draws on whole numbers.
const FINE: u32 = 3;
const WIDTH: i32 = 3000;
const MARGIN: i32 = 48;
const HEADING: i32 = 124;
const LEGEND_ROW: i32 = 76;

const BACKGROUND: RGBColor = RGBColor(0xF7, 0xF8, 0xFA);
const GRID: RGBColor = RGBColor(0xD5, 0xDA, 0xE1);
const INK: RGBColor = RGBColor(0x25, 0x2B, 0x33);
/// Told apart by people with any colour vision (Okabe and Ito), and by their lightness.
const PALETTE: [RGBColor; 8] = [
    RGBColor(0x00, 0x5A, 0x9C),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x80, 0x60),
    RGBColor(0x9B, 0x3F, 0x83),
    RGBColor(0x4F, 0xA8, 0xDC),
    RGBColor(0x25, 0x2B, 0x33),
    RGBColor(0xC9, 0x8A, 0x00),
    RGBColor(0x7A, 0x4F, 0x3A),
];

/// Opacity that stands for dashes until the picture is drawn: plotters would make an element of every dash.
const DASHES: f64 = 0.99;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Pixel = (i32, i32);

/// The chart as SVG.
///
/// # Errors
///
/// It cannot be drawn.
pub fn svg(chart: &Chart) -> Result<String> {
    let mut names: Vec<&str> = Vec::new();
    for curve in chart.panels.iter().flat_map(|panel| &panel.curves) {
        if !names.contains(&curve.name.as_str()) {
            names.push(&curve.name);
        }
    }
    let mut end = (MARGIN, HEADING);
    let mut legend = Vec::new();
    for (number, name) in names
        .iter()
        .enumerate()
        .filter(|(_, name)| !name.is_empty())
    {
        let width = 190 + 25 * name.chars().count() as i32;
        if end.0 > MARGIN && end.0 + width > WIDTH - MARGIN {
            end = (MARGIN, end.1 + LEGEND_ROW);
        }
        legend.push((number, name, end));
        end.0 += width;
    }
    let top = end.1 + if legend.is_empty() { 0 } else { LEGEND_ROW };
    let columns = chart.columns.max(1);
    let rows = chart.panels.len().div_ceil(columns);
    let width = (WIDTH - 2 * MARGIN) / columns as i32;
    let height = if columns == 1 && rows > 1 {
        600
    } else {
        (width * 3 / 4).min(1200)
    };
    let size = (WIDTH as u32, (top + rows as i32 * height + MARGIN) as u32);

    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    root.fill(&BACKGROUND)?;
    root.draw(&Text::new(chart.title.as_str(), (MARGIN, 40), bold(64)))?;
    for (number, name, (x, y)) in legend {
        let curves = chart.panels.iter().flat_map(|panel| &panel.curves);
        for style in [Style::Band, Style::Line, Style::Dashed, Style::Dots] {
            if curves
                .clone()
                .any(|curve| curve.name == *name && curve.style == style)
            {
                let sample = match style {
                    Style::Band => vec![(x, y), (x + 120, y), (x + 120, y + 50), (x, y + 50)],
                    Style::Dots => vec![(x + 60, y + 25)],
                    Style::Line | Style::Dashed => vec![(x, y + 25), (x + 120, y + 25)],
                };
                draw(&root, style, number, sample)?;
                if style == Style::Line && names.len() > 1 {
                    draw(&root, Style::Dots, number, vec![(x + 60, y + 25)])?;
                }
            }
        }
        root.draw(&Text::new(*name, (x + 140, y + 4), plain()))?;
    }
    for (i, panel) in chart.panels.iter().enumerate() {
        let (column, row) = ((i % columns) as i32, (i / columns) as i32);
        let corner = (MARGIN + column * width, top + row * height);
        draw_panel(&root.clone().shrink(corner, (width, height)), panel, &names)?;
    }
    root.present()?;
    drop(root);
    let page = |(width, height): (u32, u32)| format!("width=\"{width}\" height=\"{height}\"");
    let shown = (size.0 / FINE, size.1 / FINE);
    let svg = svg.replacen(&page(size), &page(shown), 1);
    let svg = svg.replace(
        &format!("opacity=\"{DASHES}\""),
        "stroke-dasharray=\"28 16\"",
    );
    Ok(svg.replace(" opacity=\"1\"", "").replace(" \"/>", "\"/>"))
}

fn plain() -> TextStyle<'static> {
    ("sans-serif", 52).into_font().color(&INK)
}

fn bold(size: i32) -> TextStyle<'static> {
    ("sans-serif", size, FontStyle::Bold)
        .into_font()
        .color(&INK)
}

fn draw_panel(area: &Area, panel: &Panel, names: &[&str]) -> Result<()> {
    let points = || panel.curves.iter().flat_map(|curve| &curve.points);
    let mut plane = ChartBuilder::on(area)
        .caption(&panel.title, bold(54))
        .margin(12)
        .margin_right(70)
        .x_label_area_size(if panel.x.label.is_empty() { 76 } else { 144 })
        .y_label_area_size(220)
        .build_cartesian_2d(
            Scale::new(&panel.x, points().map(|p| p.0), 0.0),
            Scale::new(&panel.y, points().map(|p| p.1), 0.06),
        )?;
    plane
        .configure_mesh()
        .bold_line_style(GRID.stroke_width(2))
        .light_line_style(TRANSPARENT)
        .axis_style(INK.stroke_width(4))
        .label_style(plain())
        .axis_desc_style(plain())
        .set_all_tick_mark_size(18)
        .x_labels(10)
        .y_labels(7)
        .x_desc(&panel.x.label)
        .y_desc(&panel.y.label)
        .draw()?;
    let plane = plane.plotting_area();
    let (columns, rows) = plane.get_pixel_range();
    let canvas = plane.strip_coord_spec();
    let pixel = |point: &(f64, f64)| -> Option<Pixel> {
        let (x, y) = plane.map_coordinate(point);
        let inside = point.0.is_finite()
            && point.1.is_finite()
            && (columns.start..=columns.end).contains(&x)
            && (rows.start..=rows.end).contains(&y);
        inside.then_some((x - columns.start, y - rows.start))
    };
    for style in [Style::Band, Style::Line, Style::Dashed, Style::Dots] {
        for curve in panel.curves.iter().filter(|curve| curve.style == style) {
            let number = names
                .iter()
                .position(|name| *name == curve.name)
                .unwrap_or(0);
            let pixels: Vec<_> = curve.points.iter().map(pixel).collect();
            for run in pixels.split(Option::is_none).filter(|run| !run.is_empty()) {
                let mut run: Vec<_> = run.iter().copied().flatten().collect();
                run.dedup();
                draw(&canvas, style, number, run)?;
            }
            if style == Style::Line && names.len() > 1 {
                let step = pixels.len().div_ceil(6).max(1);
                let marks = pixels.iter().skip(step * (number % 4) / 4).step_by(step);
                draw(
                    &canvas,
                    Style::Dots,
                    number,
                    marks.copied().flatten().collect(),
                )?;
            }
        }
    }
    Ok(())
}

/// Draws a run of points in the look of curve `number`.
fn draw(area: &Area, style: Style, number: usize, points: Vec<Pixel>) -> Result<()> {
    let colour = PALETTE[number % PALETTE.len()];
    match style {
        Style::Band => area.draw(&Polygon::new(points, colour.mix(0.25)))?,
        Style::Line if points.len() == 1 => {
            area.draw(&Circle::new(points[0], 6, colour.filled()))?
        }
        Style::Line => area.draw(&PathElement::new(points, colour.stroke_width(6)))?,
        Style::Dashed => area.draw(&PathElement::new(
            points,
            colour.mix(DASHES).stroke_width(6),
        ))?,
        Style::Dots => {
            for at @ (x, y) in points {
                match number % 5 {
                    0 => area.draw(&Circle::new(at, 12, colour.filled()))?,
                    1 => area.draw(&Rectangle::new(
                        [(x - 10, y - 10), (x + 10, y + 10)],
                        colour.filled(),
                    ))?,
                    2 => area.draw(&TriangleMarker::new(at, 17, colour.filled()))?,
                    3 => area.draw(&Cross::new(at, 12, colour.stroke_width(6)))?,
                    _ => area.draw(&Circle::new(at, 12, colour.stroke_width(6)))?,
                }
            }
        }
    }
    Ok(())
}

/// A straight or logarithmic scale from the least to the largest value.
struct Scale {
    least: f64,
    largest: f64,
    logarithmic: bool,
}

impl Scale {
    /// The scale of an axis; if its range is not given, of these values, with `room` beyond them.
    fn new(axis: &Axis, values: impl Iterator<Item = f64>, room: f64) -> Self {
        let logarithmic = axis.logarithmic;
        let along = |value: f64| if logarithmic { value.log10() } else { value };
        let values = values.map(along).filter(|value| value.is_finite());
        let found = values.fold(None, |found: Option<(f64, f64)>, value| {
            let (least, largest) = found.unwrap_or((value, value));
            Some((least.min(value), largest.max(value)))
        });
        let (least, largest) = found.unwrap_or((0.0, 1.0));
        let size = least.abs().max(largest.abs());
        // Rounding makes a curve of a constant.
        let beyond = if largest - least > 1e-4 * size {
            room * (largest - least)
        } else {
            0.05 * size
        };
        let beyond = if size == 0.0 { 1.0 } else { beyond };
        let back = |value: f64| {
            if logarithmic {
                10_f64.powf(value)
            } else {
                value
            }
        };
        let (least, largest) = axis
            .range
            .unwrap_or((back(least - beyond), back(largest + beyond)));
        Self {
            least,
            largest,
            logarithmic,
        }
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): Pixel) -> i32 {
        let along = |value: f64| {
            if self.logarithmic {
                value.log10()
            } else {
                value
            }
        };
        let (least, largest) = (along(self.least), along(self.largest));
        let part = (along(*value) - least) / (largest - least);
        start + (part * f64::from(end - start)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, hint: H) -> Vec<f64> {
        if !self.logarithmic {
            return RangedCoordf64::from(self.range()).key_points(hint);
        }
        let (first, last) = (
            self.least.log10().floor() as i32,
            self.largest.log10().ceil() as i32,
        );
        let step = (last - first) as usize / hint.max_num_points().max(1) + 1;
        let digits = if last - first > 3 {
            &[1.0][..]
        } else {
            &[1.0, 2.0, 5.0]
        };
        let decades = (first..=last)
            .step_by(step)
            .map(|decade| 10_f64.powi(decade));
        let points = decades.flat_map(|decade| digits.iter().map(move |digit| digit * decade));
        points
            .filter(|point| (self.least..=self.largest).contains(point))
            .collect()
    }

    fn range(&self) -> Range<f64> {
        self.least..self.largest
    }
}

impl ValueFormatter<f64> for Scale {
    fn format(value: &f64) -> String {
        // Sums of steps of a tenth miss the tenths.
        let value: f64 = format!("{value:.9e}").parse().unwrap_or(*value);
        match value.abs() {
            1e-4..1e6 => value.to_string(),
            0.0 => "0".to_owned(),
            _ => format!("{value:e}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_of_one_name_share_a_colour_and_an_entry() {
        let data = serde_json::json!({
            "title": "a < b", "columns": 2, "panels": [
                {"title": "left", "curves": [
                    {"name": "one", "points": [[0, 1], [1, 2]]},
                    {"name": "two", "points": [[0, 2], [1, 1]], "style": "dashed"}]},
                {"title": "right", "y": {"label": "force / N", "logarithmic": true}, "curves": [
                    {"name": "two", "points": [[0, 1], [1, 1000]], "style": "dots"},
                    {"name": "one", "points": [[0, 1], [1, 10], [1, 20], [0, 2]], "style": "band"}]},
            ]
        });
        let chart: Chart = serde_json::from_value(data).unwrap();
        let drawn = svg(&chart).unwrap();
        let count = |what: &str| drawn.matches(what).count();
        assert!(
            drawn.starts_with("<svg ") && drawn.ends_with("</svg>\n") && !drawn.contains("NaN")
        );
        assert!(drawn.contains("a &lt; b") && drawn.contains("force / N"));
        assert_eq!([count("\none\n"), count("\ntwo\n")], [1, 1]);
        // Line, band and two markers, and a sample of each in the legend; dashes, and theirs.
        assert_eq!([count("#005A9C"), count("stroke-dasharray")], [7, 2]);
    }

    #[test]
    fn a_curve_is_broken_where_it_leaves_the_axes_or_is_not_a_number() {
        let lines = |points: &[(f64, f64)]| {
            let curve = Curve {
                points: points.to_vec(),
                ..Curve::default()
            };
            let y = Axis {
                range: Some((0.0, 9.0)),
                ..Axis::default()
            };
            let panel = Panel {
                y,
                curves: vec![curve],
                ..Panel::default()
            };
            let chart = Chart {
                panels: vec![panel],
                ..Chart::default()
            };
            let drawn = svg(&chart).unwrap();
            drawn.matches("<polyline").count()
        };
        let whole = lines(&[(0.0, 1.0), (1.0, 1.0), (2.0, 1.0), (3.0, 1.0), (4.0, 1.0)]);
        for broken in [f64::NAN, 10.0, -1.0, f64::INFINITY] {
            assert_eq!(
                lines(&[
                    (0.0, 1.0),
                    (1.0, 1.0),
                    (2.0, broken),
                    (3.0, 1.0),
                    (4.0, 1.0)
                ]),
                whole + 1
            );
        }
    }

    #[test]
    fn numbers_on_an_axis_are_short() {
        let texts = [0.1 + 0.2, 0.0, 2e4, -1e6, 1e-16, 1.5].map(|value| Scale::format(&value));
        assert_eq!(texts, ["0.3", "0", "20000", "-1e6", "1e-16", "1.5"]);
    }
}
