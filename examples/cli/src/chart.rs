//! The one chart: panels of curves over straight axes, with one legend, as SVG.
//!
//! A picture brings its own light background, and reads as well on a dark page.

#![expect(missing_docs, reason = "names of fields say enough")]

use anyhow::Result;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;

/// A picture: panels side by side or below each other, one legend.
#[derive(Debug, Clone, Default)]
pub struct Chart {
    pub title: String,
    pub panels: Vec<Panel>,
    /// Panels side by side; 0 counts as 1.
    pub columns: usize,
}

impl Chart {
    /// Panels below each other, or in columns.
    pub fn new(title: &str, columns: usize, panels: Vec<Panel>) -> Self {
        Self {
            title: title.to_owned(),
            panels,
            columns,
        }
    }
}

/// Curves in one pair of axes.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub curves: Vec<Curve>,
}

impl Panel {
    /// Curves over axes of these labels.
    pub fn new(title: &str, x: &str, y: &str, curves: Vec<Curve>) -> Self {
        let title = title.to_owned();
        let [x, y] = [x, y].map(Axis::new);
        Self {
            title,
            x,
            y,
            curves,
        }
    }
}

/// An axis of a panel.
#[derive(Debug, Clone, Default)]
pub struct Axis {
    pub label: String,
    /// Lowest and highest value; the curves', if none are given.
    pub range: Option<(f64, f64)>,
    pub logarithmic: bool,
    /// Words at 0, 1, 2 and so on, in the place of numbers.
    pub words: Vec<&'static str>,
}

impl Axis {
    /// A straight one of the range of its curves.
    pub fn new(label: &str) -> Self {
        let label = label.to_owned();
        Self {
            label,
            ..Self::default()
        }
    }
}

/// A curve, broken where a point is not finite or outside the axes.
///
/// Curves of one name share a colour and an entry of the legend; a curve without a name has none, and is dark.
#[derive(Debug, Clone, Default)]
pub struct Curve {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    pub style: Style,
}

impl Curve {
    /// A curve through points.
    pub fn new(name: &str, style: Style, points: Vec<(f64, f64)>) -> Self {
        let name = name.to_owned();
        Self {
            name,
            points,
            style,
        }
    }
}

/// The look of a curve. The first of these is drawn first.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Style {
    /// A filled area: its points are (x, low), then (x, high) backwards.
    Band,
    /// With a marker here and there.
    #[default]
    Line,
    Dashed,
    /// A marker at every point.
    Dots,
}

/// Steps in a pixel: plotters draws on whole numbers.
const FINE: u32 = 3;
const WIDTH: i32 = 3000;
const MARGIN: i32 = 48;
const HEADING: i32 = 124;
const LEGEND_ROW: i32 = 76;
/// Size of most texts, of which 1.24 is the part of plotters.
const FONT: f64 = 52.0;

const BACKGROUND: RGBColor = RGBColor(0xF7, 0xF8, 0xFA);
const GRID: RGBColor = RGBColor(0xD5, 0xDA, 0xE1);
const INK: RGBColor = RGBColor(0x25, 0x2B, 0x33);
/// Told apart by people with any colour vision (Okabe and Ito), and by their lightness.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0x00, 0x5A, 0x9C),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x80, 0x60),
    RGBColor(0x9B, 0x3F, 0x83),
    RGBColor(0x4F, 0xA8, 0xDC),
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
    let curves = chart.panels.iter().flat_map(|panel| &panel.curves);
    let mut names: Vec<&str> = Vec::new();
    for curve in curves.clone().filter(|curve| !curve.name.is_empty()) {
        if !names.contains(&curve.name.as_str()) {
            names.push(&curve.name);
        }
    }
    let mut end = (MARGIN, HEADING);
    let places = names.iter().map(|name| {
        let width = 190 + 25 * name.chars().count() as i32;
        if end.0 > MARGIN && end.0 + width > WIDTH - MARGIN {
            end = (MARGIN, end.1 + LEGEND_ROW);
        }
        end.0 += width;
        (end.0 - width, end.1)
    });
    let places: Vec<_> = places.collect();
    let top = end.1 + if names.is_empty() { 0 } else { LEGEND_ROW };
    let columns = chart.columns.max(1);
    let rows = chart.panels.len().div_ceil(columns);
    let width = (WIDTH - 2 * MARGIN) / columns as i32;
    let most = if columns == 1 && rows > 1 { 600 } else { 1200 };
    let height = top + rows as i32 * most.min(width * 3 / 4) + MARGIN;
    let size = (WIDTH as u32, height as u32);

    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    root.fill(&BACKGROUND)?;
    root.draw(&Text::new(chart.title.as_str(), (MARGIN, 40), bold(64)))?;
    for (name, (x, y)) in names.iter().zip(places) {
        let of_name = curves.clone().filter(|curve| curve.name == *name);
        let mut styles: BTreeSet<_> = of_name.map(|curve| curve.style).collect();
        if styles.contains(&Style::Line) {
            styles.insert(Style::Dots);
        }
        for style in styles {
            let sample = match style {
                Style::Band => vec![(x, y), (x + 120, y), (x + 120, y + 50), (x, y + 50)],
                Style::Dots => vec![(x + 60, y + 25)],
                Style::Line | Style::Dashed => vec![(x, y + 25), (x + 120, y + 25)],
            };
            draw(&root, style, look(&names, name), sample)?;
        }
        root.draw(&Text::new(*name, (x + 140, y + 4), plain()))?;
    }
    let grid = (rows.max(1), columns);
    let areas = root.margin(top, MARGIN, MARGIN, MARGIN).split_evenly(grid);
    let has_words = chart.panels.iter().any(|panel| !panel.y.words.is_empty());
    let beside = if has_words { 420 } else { 220 };
    for (panel, area) in chart.panels.iter().zip(areas) {
        draw_panel(&root, &area, panel, (&names, beside))?;
    }
    root.present()?;
    drop(root);
    let page = |(width, height): (u32, u32)| format!("width=\"{width}\" height=\"{height}\"");
    let font = format!(" font-family=\"sans-serif\" font-size=\"{}\"", FONT / 1.24);
    let shown = page((size.0 / FINE, size.1 / FINE)) + &font;
    let dashes = format!("opacity=\"{DASHES}\"");
    let svg = svg.replace(&font, "").replacen(&page(size), &shown, 1);
    let svg = svg.replace(&dashes, "stroke-dasharray=\"28 16\"");
    Ok(svg.replace(" opacity=\"1\"", "").replace(" \"/>", "\"/>"))
}

/// Number and colour of a curve's look.
fn look(names: &[&str], name: &str) -> (usize, RGBColor) {
    let number = names.iter().position(|known| *known == name);
    number.map_or((0, INK), |number| (number, PALETTE[number % PALETTE.len()]))
}

fn plain() -> TextStyle<'static> {
    ("sans-serif", FONT).into_font().color(&INK)
}

fn bold(size: i32) -> TextStyle<'static> {
    let font = ("sans-serif", size, FontStyle::Bold);
    font.into_font().color(&INK)
}

/// Draws a panel, with so much room beside it for the labels of its axis.
fn draw_panel(
    root: &Area,
    area: &Area,
    panel: &Panel,
    (names, beside): (&[&str], u32),
) -> Result<()> {
    let points = || panel.curves.iter().flat_map(|curve| &curve.points);
    let mut plane = ChartBuilder::on(area)
        .caption(&panel.title, bold(54))
        .margin(12)
        .margin_right(70)
        .x_label_area_size(if panel.x.label.is_empty() { 76 } else { 144 })
        .y_label_area_size(beside)
        .build_cartesian_2d(
            Scale::new(&panel.x, points().map(|p| p.0), 0.0),
            Scale::new(&panel.y, points().map(|p| p.1), 0.06),
        )?;
    let words = &panel.y.words;
    let label = |y: &f64| match words.get(y.round() as usize) {
        Some(word) => (*word).to_owned(),
        None => Scale::format(y),
    };
    plane
        .configure_mesh()
        .bold_line_style(GRID.stroke_width(2))
        .light_line_style(TRANSPARENT)
        .axis_style(INK.stroke_width(4))
        .label_style(plain())
        .axis_desc_style(plain())
        .set_all_tick_mark_size(18)
        .x_labels((area.dim_in_pixel().0 / 170).min(10) as usize)
        .y_labels(7.max(words.len()))
        .y_label_formatter(&label)
        .x_desc(&panel.x.label)
        .y_desc(&panel.y.label)
        .draw()?;
    let plane = plane.plotting_area();
    let (columns, rows) = plane.get_pixel_range();
    let pixel = |point: &(f64, f64)| -> Option<Pixel> {
        let (x, y) = plane.map_coordinate(point);
        let finite = point.0.is_finite() && point.1.is_finite();
        let inside =
            (columns.start..=columns.end).contains(&x) && (rows.start..=rows.end).contains(&y);
        (finite && inside).then_some((x, y))
    };
    let mut curves: Vec<_> = panel.curves.iter().collect();
    curves.sort_by_key(|curve| curve.style);
    for curve in curves {
        let look = look(names, &curve.name);
        let pixels: Vec<_> = curve.points.iter().map(pixel).collect();
        for run in pixels.split(Option::is_none).filter(|run| !run.is_empty()) {
            let mut run: Vec<_> = run.iter().copied().flatten().collect();
            if curve.style != Style::Dots {
                // A level stretch keeps its two ends alone.
                let ends = |level: &[Pixel]| [level[0], level[level.len() - 1]];
                run = run.chunk_by(|a, b| a.1 == b.1).flat_map(ends).collect();
            }
            run.dedup();
            draw(root, curve.style, look, run)?;
        }
        if curve.style == Style::Line && !curve.name.is_empty() {
            let step = pixels.len().div_ceil(6).max(1);
            let marks = pixels.iter().skip(step * (look.0 % 4) / 4).step_by(step);
            draw(root, Style::Dots, look, marks.copied().flatten().collect())?;
        }
    }
    Ok(())
}

/// Draws a run of points.
fn draw(
    area: &Area,
    style: Style,
    (number, colour): (usize, RGBColor),
    points: Vec<Pixel>,
) -> Result<()> {
    let line = colour.stroke_width(6);
    let dashes = colour.mix(DASHES).stroke_width(6);
    match style {
        Style::Band => area.draw(&Polygon::new(points, colour.mix(0.25)))?,
        Style::Line if points.len() == 1 => {
            area.draw(&Circle::new(points[0], 6, colour.filled()))?
        }
        Style::Line => area.draw(&PathElement::new(points, line))?,
        Style::Dashed => area.draw(&PathElement::new(points, dashes))?,
        Style::Dots => {
            for at @ (x, y) in points {
                let corners = [(x - 10, y - 10), (x + 10, y + 10)];
                match number % 5 {
                    0 => area.draw(&Circle::new(at, 12, colour.filled()))?,
                    1 => area.draw(&Rectangle::new(corners, colour.filled()))?,
                    2 => area.draw(&TriangleMarker::new(at, 17, colour.filled()))?,
                    3 => area.draw(&Cross::new(at, 12, line))?,
                    _ => area.draw(&Circle::new(at, 12, line))?,
                }
            }
        }
    }
    Ok(())
}

/// A straight or logarithmic scale.
struct Scale {
    logarithmic: bool,
    /// Words along it, from 0 on.
    words: u32,
    /// Ends, as powers of ten if it is logarithmic.
    least: f64,
    largest: f64,
}

impl Scale {
    /// The scale of an axis; if its range is not given, of these values, with `room` beyond them.
    fn new(axis: &Axis, values: impl Iterator<Item = f64>, room: f64) -> Self {
        let logarithmic = axis.logarithmic;
        let along = |value: f64| if logarithmic { value.log10() } else { value };
        let values = values.map(along).filter(|value| value.is_finite());
        let found = values
            .map(|value| (value, value))
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (least, largest) = found.unwrap_or((0.0, 1.0));
        let (span, size) = (largest - least, least.abs().max(largest.abs()));
        let beyond = if size == 0.0 {
            1.0
        } else if span <= 1e-3 * room * size {
            // Rounding makes a curve of a constant.
            0.05 * size
        } else {
            room * span
        };
        let found = (least - beyond, largest + beyond);
        let (least, largest) = axis
            .range
            .map_or(found, |(least, largest)| (along(least), along(largest)));
        Self {
            logarithmic,
            words: axis.words.len() as u32,
            least,
            largest,
        }
    }

    fn along(&self, value: f64) -> f64 {
        if self.logarithmic {
            value.log10()
        } else {
            value
        }
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): Pixel) -> i32 {
        let part = (self.along(*value) - self.least) / (self.largest - self.least);
        start + (part * f64::from(end - start)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, hint: H) -> Vec<f64> {
        if self.words > 0 {
            return (0..self.words).map(f64::from).collect();
        }
        if !self.logarithmic {
            return RangedCoordf64::from(self.range()).key_points(hint);
        }
        let (first, last) = (self.least.floor() as i32, self.largest.ceil() as i32);
        let step = (last - first) as usize / hint.max_num_points().max(1) + 1;
        let digits: &[f64] = if last - first > 3 {
            &[1.0]
        } else {
            &[1.0, 2.0, 5.0]
        };
        let decades = (first..=last).step_by(step).map(|power| 10_f64.powi(power));
        let mut points: Vec<_> = decades
            .flat_map(|one| digits.iter().map(move |digit| digit * one))
            .collect();
        points.retain(|point| self.range().contains(point));
        points
    }

    fn range(&self) -> Range<f64> {
        let ends = self.least..self.largest;
        if self.logarithmic {
            10_f64.powf(ends.start)..10_f64.powf(ends.end)
        } else {
            ends
        }
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
        let curve = |name, style, points: &[(f64, f64)]| Curve::new(name, style, points.to_vec());
        let left = vec![
            curve("one", Style::Line, &[(0.0, 1.0), (1.0, 2.0)]),
            curve("two", Style::Dashed, &[(0.0, 2.0), (1.0, 1.0)]),
        ];
        let area = [(0.0, 1.0), (1.0, 10.0), (1.0, 20.0), (0.0, 2.0)];
        let right = vec![
            curve("two", Style::Dots, &[(0.0, 1.0), (1.0, 1000.0)]),
            curve("one", Style::Band, &area),
        ];
        let mut panels = vec![
            Panel::new("left", "", "", left),
            Panel::new("right", "", "force / N", right),
        ];
        panels[1].y.logarithmic = true;
        let chart = Chart::new("a < b", 2, panels);
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
            let curve = Curve::new("", Style::Line, points.to_vec());
            let mut panel = Panel::new("", "", "", vec![curve]);
            panel.y.range = Some((0.0, 9.0));
            let chart = Chart::new("", 1, vec![panel]);
            let drawn = svg(&chart).unwrap();
            drawn.matches("<polyline").count()
        };
        let through = |y| lines(&[(0.0, 1.0), (1.0, 1.0), (2.0, y), (3.0, 1.0), (4.0, 1.0)]);
        let whole = through(1.0);
        for broken in [f64::NAN, 10.0, -1.0, f64::INFINITY] {
            assert_eq!(through(broken), whole + 1);
        }
    }

    #[test]
    fn numbers_on_an_axis_are_short() {
        let texts = [0.1 + 0.2, 0.0, 2e4, -1e6, 1e-16, 1.5].map(|value| Scale::format(&value));
        assert_eq!(texts, ["0.3", "0", "20000", "-1e6", "1e-16", "1.5"]);
    }
}
