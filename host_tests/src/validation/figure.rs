//! Figures in one style: panels of curves over a common legend, as SVG.
//!
//! A figure brings its own light background, so that it reads the same on a light and on a dark
//! page. Curves differ in dash and marker as well as in colour, and are told apart in black and white.

use anyhow::Context;
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::f64::consts::TAU;
use std::path::Path;

const BACKGROUND: RGBColor = RGBColor(0xF7, 0xF8, 0xFA);
const GRID: RGBColor = RGBColor(0xD5, 0xDA, 0xE1);
/// Text, axes, and the curve that others are compared with.
pub const INK: RGBColor = RGBColor(0x25, 0x2B, 0x33);
// Told apart by people with any colour vision (Okabe and Ito).
/// Blue.
pub const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xB2);
/// Vermilion.
pub const VERMILION: RGBColor = RGBColor(0xD5, 0x5E, 0x00);
/// Green.
pub const GREEN: RGBColor = RGBColor(0x00, 0x80, 0x60);
/// Purple.
pub const PURPLE: RGBColor = RGBColor(0x9B, 0x3F, 0x83);

const MARGIN: i32 = 24;
const HEADING: u32 = 56;
const LEGEND_ROW: i32 = 36;

/// How a line is broken up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// Not at all.
    Solid,
    /// Long dashes.
    Long,
    /// Short dashes.
    Short,
    /// Dots.
    Dots,
    /// No line: markers alone.
    None,
}

impl Dash {
    /// Length of dash and gap, pixels.
    fn lengths(self) -> Option<(u32, u32)> {
        match self {
            Self::Solid | Self::None => None,
            Self::Long => Some((18, 9)),
            Self::Short => Some((8, 7)),
            Self::Dots => Some((3, 6)),
        }
    }
}

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// No points.
    None,
    /// A filled circle.
    Disc,
    /// A filled square.
    Square,
    /// A filled triangle.
    Triangle,
    /// A diagonal cross.
    Cross,
    /// A circle's outline.
    Ring,
}

/// The look of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pen(pub RGBColor, pub Dash, pub Marker);

/// A curve; in a polar panel its points are (azimuth in rad, value).
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its look.
    pub pen: Pen,
    /// The line.
    pub line: Vec<(f64, f64)>,
    /// Where its markers are.
    pub marks: Vec<(f64, f64)>,
}

impl Curve {
    /// A line through `points` with about `marks` markers on it, the first of them `first` in.
    pub fn through(pen: Pen, points: Vec<(f64, f64)>, first: usize, marks: usize) -> Self {
        let step = (points.len() / marks.max(1)).max(1);
        let marks = points
            .iter()
            .skip(first % step)
            .step_by(step)
            .copied()
            .collect();
        Self {
            pen,
            line: points,
            marks,
        }
    }
}

/// A straight axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    label: String,
    /// The range includes zero.
    zero: bool,
    ticks: Ticks,
}

/// Where an axis has its ticks.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ticks {
    /// Some five of them.
    Some,
    /// This far apart.
    Every(f64),
    /// The axis holds decimal logarithms, and its numbers are those of which they are.
    Logarithmic,
}

impl Axis {
    /// As long as the curves need it.
    pub fn new(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            zero: false,
            ticks: Ticks::Some,
        }
    }

    /// With zero in its range.
    pub fn from_zero(label: impl Into<String>) -> Self {
        Self {
            zero: true,
            ..Self::new(label)
        }
    }

    /// With a tick every `step`.
    #[must_use]
    pub fn every(self, step: f64) -> Self {
        Self {
            ticks: Ticks::Every(step),
            ..self
        }
    }

    /// Of points that are given by their decimal logarithms.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self {
            ticks: Ticks::Logarithmic,
            ..Self::from_zero(label)
        }
    }

    /// Places of the ticks between `low` and `high`, and their numbers.
    fn ticks(&self, low: f64, high: f64) -> Vec<(f64, String)> {
        let step = match self.ticks {
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
}

/// What the points of a panel mean.
#[derive(Debug, Clone, PartialEq)]
pub enum Plane {
    /// Two straight axes.
    Straight {
        /// To the right.
        x: Axis,
        /// Upwards.
        y: Axis,
    },
    /// Around the bearing, seen along the shaft: +y to the right, +z upwards, the value outwards.
    Around {
        /// Value in the centre.
        centre: f64,
        /// Value at the rim.
        rim: f64,
        /// From one ring to the next.
        step: f64,
    },
}

/// One panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Its title.
    pub title: String,
    /// Its axes.
    pub plane: Plane,
    /// Its curves.
    pub curves: Vec<Curve>,
    /// Points that are ringed.
    pub nodes: Vec<(f64, f64)>,
}

/// A figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its file, without the ending.
    pub name: &'static str,
    /// Title in the figure.
    pub title: String,
    /// What the text under the figure says.
    pub caption: String,
    /// What the pens stand for.
    pub legend: Vec<(Pen, String)>,
    /// Number of panels side by side.
    pub columns: usize,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

/// Width of a figure, px.
const WIDTH: u32 = 1500;

impl Figure {
    /// Draws it into `folder`.
    ///
    /// # Errors
    ///
    /// The file cannot be written.
    pub fn draw(&self, folder: &Path) -> anyhow::Result<()> {
        let path = folder.join(format!("{}.svg", self.name));
        std::fs::write(&path, self.svg()?)
            .with_context(|| format!("cannot write {}; is the folder writable?", path.display()))
    }

    /// The figure as SVG.
    ///
    /// # Errors
    ///
    /// It cannot be drawn.
    pub fn svg(&self) -> anyhow::Result<String> {
        let mut svg = String::new();
        self.draw_on(SVGBackend::with_string(&mut svg, self.size()))
            .with_context(|| format!("cannot draw the figure {}", self.name))?;
        // The last line of a text file ends, too.
        if !svg.ends_with('\n') {
            svg.push('\n');
        }
        Ok(svg)
    }

    fn cell(&self) -> (u32, u32) {
        let width = (WIDTH - 2 * MARGIN as u32) / self.columns as u32;
        let around = matches!(
            self.panels.first().map(|p| &p.plane),
            Some(Plane::Around { .. })
        );
        let height = if around {
            width + 10
        } else if self.columns == 1 {
            560
        } else {
            width * 4 / 5 + 30
        };
        (width, height)
    }

    /// Columns of the legend, and their width.
    fn legend_columns(&self) -> (usize, i32) {
        let longest = self.legend.iter().map(|(_, l)| l.chars().count()).max();
        let width = 100 + 12 * longest.unwrap_or(0) as i32;
        let columns = ((WIDTH as i32 - 2 * MARGIN) / width.max(1)).max(1) as usize;
        (columns, width)
    }

    fn size(&self) -> (u32, u32) {
        let rows = self.panels.len().div_ceil(self.columns) as u32;
        let legend = self.legend.len().div_ceil(self.legend_columns().0) as u32;
        let height = HEADING + legend * LEGEND_ROW as u32 + rows * self.cell().1 + MARGIN as u32;
        (WIDTH, height)
    }

    fn draw_on(&self, backend: SVGBackend) -> anyhow::Result<()> {
        let root = backend.into_drawing_area();
        root.fill(&BACKGROUND)?;
        root.draw(&Text::new(
            self.title.as_str(),
            (MARGIN, 18),
            bold(26, &INK),
        ))?;
        let (columns, width) = self.legend_columns();
        for (i, (pen, label)) in self.legend.iter().enumerate() {
            let x = MARGIN + (i % columns) as i32 * width;
            let y = HEADING as i32 + (i / columns) as i32 * LEGEND_ROW + 14;
            stroke(&root, pen, &[(x, y), (x + 64, y)])?;
            mark(&root, pen, (x + 32, y))?;
            root.draw(&Text::new(label.as_str(), (x + 76, y - 11), plain(20)))?;
        }
        let legend = self.legend.len().div_ceil(columns) as i32 * LEGEND_ROW;
        let (w, h) = self.cell();
        for (i, panel) in self.panels.iter().enumerate() {
            let x = MARGIN + (i % self.columns) as i32 * w as i32;
            let y = HEADING as i32 + legend + (i / self.columns) as i32 * h as i32;
            let area = root.clone().shrink((x as u32, y as u32), (w, h));
            match &panel.plane {
                Plane::Straight { x, y } => straight(&area, panel, x, y)?,
                Plane::Around { centre, rim, step } => {
                    around(&area, panel, [*centre, *rim], *step)?
                }
            }
        }
        root.present()?;
        Ok(())
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn plain(size: i32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&INK)
}

fn bold(size: i32, colour: &RGBColor) -> TextStyle<'static> {
    ("sans-serif", size, FontStyle::Bold)
        .into_font()
        .color(colour)
}

/// A line of `pen` through pixels of `area`.
fn stroke(area: &Area, pen: &Pen, points: &[(i32, i32)]) -> anyhow::Result<()> {
    let Pen(colour, dash, _) = pen;
    let style = colour.stroke_width(3);
    match (dash, dash.lengths()) {
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
fn mark(area: &Area, pen: &Pen, at: (i32, i32)) -> anyhow::Result<()> {
    let Pen(colour, _, marker) = pen;
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

fn ring(area: &Area, at: (i32, i32)) -> anyhow::Result<()> {
    area.draw(&Circle::new(at, 10, INK.stroke_width(2)))?;
    Ok(())
}

/// Distance of the ticks of an axis that is `span` long, for about `count` of them.
fn tick_step(span: f64, count: f64) -> f64 {
    let rough = span / count;
    let decade = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|s| s * decade >= rough);
    step.unwrap_or(10.0) * decade
}

/// A number on an axis whose ticks are `step` apart.
fn tick_label(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    // A rounded negative nought.
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

/// The range of `values` with some room around.
fn range(values: impl Iterator<Item = f64>, zero: bool, room: f64) -> (f64, f64) {
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

fn straight(area: &Area, panel: &Panel, x: &Axis, y: &Axis) -> anyhow::Result<()> {
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
    area.draw(&Text::new(panel.title.as_str(), (left, 10), bold(21, &INK)))?;

    let fine = INK.stroke_width(1);
    for (value, number) in x.ticks(x0, x1) {
        let (px, _) = at((value, y0));
        area.draw(&PathElement::new(
            vec![(px, top), (px, bottom)],
            GRID.stroke_width(1),
        ))?;
        let style = plain(19).pos(Pos::new(HPos::Center, VPos::Top));
        area.draw(&Text::new(number, (px, bottom + 8), style))?;
    }
    for (value, number) in y.ticks(y0, y1) {
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
    area.draw(&PathElement::new(frame, INK.stroke_width(2)))?;
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

fn around(area: &Area, panel: &Panel, [least, most]: [f64; 2], step: f64) -> anyhow::Result<()> {
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
    let style = bold(21, &INK).pos(Pos::new(HPos::Center, VPos::Top));
    area.draw(&Text::new(panel.title.as_str(), (centre.0, 8), style))?;

    let rings = ((most - least) / step).round() as i32;
    for i in 1..=rings {
        let r = (radius * f64::from(i) / f64::from(rings)).round() as i32;
        let line = if i == rings {
            INK.stroke_width(2)
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
