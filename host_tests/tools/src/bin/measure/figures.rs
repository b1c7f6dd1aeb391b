//! The page's charts.

use crate::host::Limit;
use crate::image::name;
use crate::plan::{BALLS, CORES, TOLERANCES, USUAL};
use crate::profile::Part;
use crate::rows::{At, Rows, Start};
use anyhow::{Context, Result};
use host_tests::dispatch::Precision;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;
use tools::timing::Core;

const SIZE: (u32, u32) = (1600, 900);
// An opaque panel, so that a picture reads the same on a light and on a dark page.
const PANEL: RGBColor = RGBColor(0xF7, 0xF8, 0xFA);
const INK: RGBColor = RGBColor(0x25, 0x2B, 0x33);
const GRID: RGBColor = RGBColor(0xD5, 0xDA, 0xE1);
// Told apart by people with any colour vision (after Okabe and Ito).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x80, 0x60),
    RGBColor(0xB0, 0x4A, 0x8A),
    RGBColor(0x8A, 0x6D, 0x00),
    RGBColor(0x4D, 0xA6, 0xDB),
    RGBColor(0x70, 0x78, 0x82),
];

/// Points of one kind.
struct Curve {
    label: String,
    colour: RGBColor,
    /// Thin lines are for the 99th percentile.
    thin: bool,
    points: Vec<(f64, f64)>,
}

/// A chart with logarithmic values, over a logarithmic axis or one of whole numbers.
struct Chart<'c> {
    title: &'c str,
    x: &'c str,
    y: &'c str,
    x_is_log: bool,
    curves: Vec<Curve>,
}

fn at(core: Option<Core>, precision: Precision, balls: usize, start: Start) -> At {
    At {
        core,
        precision,
        motion: USUAL,
        balls,
        start: Some(start),
    }
}

/// Draws all charts into a folder.
pub fn draw(folder: &Path, rows: &Rows) -> Result<()> {
    let chart = |file: &str, chart: &Chart<'_>| {
        let path = folder.join(file);
        curves(&path, chart).with_context(|| format!("cannot draw {}", path.display()))
    };
    chart("report_pareto.svg", &pareto(rows))?;
    chart("report_tolerance.svg", &tolerances(rows))?;
    chart("report_balls.svg", &balls(rows))?;
    let bar = |file: &str, title: &str, unit: &str, bars: &[Bar]| {
        let path = folder.join(file);
        bars_of(&path, title, unit, bars).with_context(|| format!("cannot draw {}", path.display()))
    };
    bar(
        "report_study.svg",
        "The study's fixed-step scheme beside ours: ball passes of a cold solve",
        "passes over a ball (iterations of ours); bar: median, line: to the 99th percentile",
        &study(rows),
    )?;
    let path = folder.join("report_breakdown.svg");
    breakdown(&path, rows).with_context(|| format!("cannot draw {}", path.display()))
}

/// Tolerances, the largest first, and the default one.
fn limits() -> impl Iterator<Item = Limit> {
    let tolerances = TOLERANCES.iter().map(|t| Limit::Tolerance(*t));
    tolerances.chain([Limit::Default])
}

/// Stiffness error over cycles, a point for every tolerance.
fn pareto(rows: &Rows) -> Chart<'static> {
    let mut curves = Vec::new();
    for (i, (core, precision)) in CORES.into_iter().enumerate() {
        for (stat, thin) in [("99 %", true), ("median", false)] {
            let points = limits().filter_map(|limit| {
                let at = |core| at(core, precision, 16, Start::Warm);
                let cycles = rows.get(&at(Some(core)), &limit.metric("cycles"), "median");
                let error = rows.get(&at(None), &limit.metric("stiffness error"), stat);
                (cycles > 0.0 && error > 0.0).then_some((cycles, error))
            });
            curves.push(Curve {
                label: format!("{}, {}", name(precision), core.name()),
                colour: COLOURS[i],
                thin,
                points: points.collect(),
            });
        }
    }
    Chart {
        title: "Error of the stiffness over cycles: warm ticks of 16 balls at tolerances from 1e-1 down",
        x: "cycles of a tick, median (modelled)",
        y: "error of the stiffness, of its diagonal",
        x_is_log: true,
        curves,
    }
}

/// Errors over the tolerance.
fn tolerances(rows: &Rows) -> Chart<'static> {
    let mut curves = Vec::new();
    let mut colours = COLOURS.iter();
    for precision in [Precision::F32, Precision::F64] {
        for what in ["displacement", "force", "stiffness"] {
            let colour = *colours.next().unwrap_or(&INK);
            for (stat, thin) in [("99 %", true), ("median", false)] {
                let points = limits().filter_map(|limit| {
                    let at = at(None, precision, 16, Start::Warm);
                    let error = rows.get(&at, &limit.metric(&format!("{what} error")), stat);
                    (error > 0.0).then_some((limit.settings(precision).0, error))
                });
                curves.push(Curve {
                    label: format!("{what}, {}", name(precision)),
                    colour,
                    thin,
                    points: points.collect(),
                });
            }
        }
    }
    Chart {
        title: "Errors over tolerance: warm ticks of 16 balls",
        x: "tolerance of the stiffness",
        y: "relative error",
        x_is_log: true,
        curves,
    }
}

/// Cycles over ball count.
fn balls(rows: &Rows) -> Chart<'static> {
    let mut curves = Vec::new();
    for (i, (core, precision)) in CORES.into_iter().enumerate() {
        for (start, thin) in [(Start::Cold, false), (Start::Warm, true)] {
            let points = BALLS.iter().filter_map(|balls| {
                let at = at(Some(core), precision, *balls, start);
                let cycles = rows.get(&at, "cycles", "median");
                (cycles > 0.0).then_some((*balls as f64, cycles))
            });
            curves.push(Curve {
                label: format!("{}, {}", name(precision), core.name()),
                colour: COLOURS[i],
                thin,
                points: points.collect(),
            });
        }
    }
    Chart {
        title: "Cycles over ball count: cold (thick) and warm (thin), medians",
        x: "balls",
        y: "cycles of a solve (modelled)",
        x_is_log: false,
        curves,
    }
}

fn font(size: u32) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&INK)
}

fn bold(size: u32, colour: &RGBColor) -> TextStyle<'static> {
    ("sans-serif", size, FontStyle::Bold)
        .into_font()
        .color(colour)
}

fn panel<'p>(path: &'p Path, title: &str) -> Result<DrawingArea<SVGBackend<'p>, Shift>> {
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&PANEL)?;
    root.draw(&Text::new(title.to_owned(), (28, 20), font(30)))?;
    Ok(root)
}

/// A power of ten, or a number; what the axis hands over is rounded.
fn tick(value: &f64) -> String {
    if *value >= 1e3 || (*value > 0.0 && *value < 0.1) {
        format!("{value:.0e}")
    } else {
        format!("{}", (value * 1e3).round() / 1e3)
    }
}

fn curves(path: &Path, chart: &Chart<'_>) -> Result<()> {
    let root = panel(path, chart.title)?;
    let points = || chart.curves.iter().flat_map(|c| c.points.iter());
    let bounds = |of: fn(&(f64, f64)) -> f64| {
        points()
            .map(of)
            .fold((f64::INFINITY, 0.0_f64), |(low, high), x| {
                (low.min(x), high.max(x))
            })
    };
    let ((left, right), (low, high)) = (bounds(|p| p.0), bounds(|p| p.1));
    if left > right {
        anyhow::bail!("nothing to draw");
    }
    let y = (low / 1.5..high * 1.5).log_scale();
    let mut builder = ChartBuilder::on(&root);
    builder
        .margin_left(16)
        .margin_right(28)
        .margin_bottom(12)
        .margin_top(130)
        .set_label_area_size(LabelAreaPosition::Left, 110)
        .set_label_area_size(LabelAreaPosition::Bottom, 64);
    macro_rules! draw {
        ($x:expr) => {{
            let mut area = builder.build_cartesian_2d($x, y)?;
            area.configure_mesh()
                .light_line_style(TRANSPARENT)
                .bold_line_style(GRID)
                .axis_style(INK)
                .label_style(font(22))
                .axis_desc_style(font(22))
                .x_desc(chart.x)
                .y_desc(chart.y)
                .x_label_formatter(&tick)
                .y_label_formatter(&tick)
                .draw()?;
            for curve in &chart.curves {
                let width = if curve.thin { 2 } else { 5 };
                area.draw_series(LineSeries::new(
                    curve.points.iter().copied(),
                    curve.colour.stroke_width(width),
                ))?;
                let size = if curve.thin { 4 } else { 8 };
                area.draw_series(
                    curve
                        .points
                        .iter()
                        .map(|point| Circle::new(*point, size, curve.colour.filled())),
                )?;
            }
        }};
    }
    if chart.x_is_log {
        draw!((left / 1.3..right * 1.3).log_scale());
    } else {
        draw!(left - 0.3..right + 0.3);
    }
    let mut labelled: Vec<&str> = Vec::new();
    for curve in &chart.curves {
        if labelled.contains(&curve.label.as_str()) || curve.points.is_empty() {
            continue;
        }
        let (column, row) = (labelled.len() % 4, labelled.len() / 4);
        let (x, y) = (40 + 380 * column as i32, 68 + 30 * row as i32);
        root.draw(&Rectangle::new(
            [(x, y + 6), (x + 34, y + 14)],
            curve.colour.filled(),
        ))?;
        root.draw(&Text::new(
            curve.label.clone(),
            (x + 44, y),
            bold(24, &curve.colour),
        ))?;
        labelled.push(&curve.label);
    }
    let note = if chart.title.contains("thick") {
        ""
    } else {
        "thick: median; thin: 99th percentile"
    };
    root.draw(&Text::new(
        note,
        (SIZE.0 as i32 - 28, 24),
        font(22).pos(Pos::new(HPos::Right, VPos::Top)),
    ))?;
    root.present()?;
    Ok(())
}

/// A bar on a logarithmic scale.
struct Bar {
    label: &'static str,
    value: f64,
    most: f64,
}

fn study(rows: &Rows) -> Vec<Bar> {
    let of = |label: &'static str, who: &str, start: &str| {
        let find = |stat: &str| {
            rows.all()
                .iter()
                .find(|r| {
                    r.core == "host"
                        && r.precision == who
                        && r.start == Some(start)
                        && r.metric == "passes a ball"
                        && r.stat == stat
                })
                .map_or(f64::NAN, |r| r.value)
        };
        Bar {
            label,
            value: find("median"),
            most: find("99 %"),
        }
    };
    vec![
        of("study's scheme, step factors 0.1", "study's scheme", "cold"),
        of("the same without step factors", "nested Newton", "cold"),
        of("ours, f64, cold", "f64", "cold"),
        of("ours, f32, cold", "f32", "cold"),
        of("ours, f32, warm", "f32", "warm"),
    ]
}

fn bars_of(path: &Path, title: &str, unit: &str, bars: &[Bar]) -> Result<()> {
    let root = panel(path, title)?;
    let most = bars.iter().fold(1.0_f64, |m, b| m.max(b.most));
    let mut area = ChartBuilder::on(&root)
        .margin_left(16)
        .margin_right(60)
        .margin_bottom(12)
        .margin_top(80)
        .set_label_area_size(LabelAreaPosition::Left, 400)
        .set_label_area_size(LabelAreaPosition::Bottom, 64)
        .build_cartesian_2d((0.5..most * 2.0).log_scale(), 0.0..bars.len() as f64)?;
    area.configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(INK)
        .label_style(font(22))
        .axis_desc_style(font(22))
        .disable_y_mesh()
        .y_labels(0)
        .x_desc(unit)
        .x_label_formatter(&tick)
        .draw()?;
    for (i, bar) in bars.iter().enumerate() {
        let middle = bars.len() as f64 - i as f64 - 0.5;
        area.draw_series([Rectangle::new(
            [(0.5, middle - 0.3), (bar.value, middle + 0.3)],
            COLOURS[i.min(COLOURS.len() - 1)].filled(),
        )])?;
        area.draw_series(LineSeries::new(
            [(bar.value, middle), (bar.most, middle)],
            INK.stroke_width(3),
        ))?;
        let (x, y) = area.backend_coord(&(0.5, middle));
        root.draw(&Text::new(
            bar.label,
            (x - 14, y),
            font(24).pos(Pos::new(HPos::Right, VPos::Center)),
        ))?;
        let (x, y) = area.backend_coord(&(bar.most, middle));
        root.draw(&Text::new(
            if bar.value < 100.0 {
                format!("{:.0}", bar.value)
            } else {
                crate::terminal::thousands(bar.value)
            },
            (x + 12, y),
            bold(24, &INK).pos(Pos::new(HPos::Left, VPos::Center)),
        ))?;
    }
    root.present()?;
    Ok(())
}

/// Where the cycles of a solve go, as bars laid end to end.
fn breakdown(path: &Path, rows: &Rows) -> Result<()> {
    let root = panel(
        path,
        "Where the cycles go: mean of the mixed cases, 16 balls",
    )?;
    let solves = [
        (Core::M4f, Precision::F32, Start::Cold),
        (Core::M4f, Precision::F32, Start::Warm),
        (Core::M7, Precision::F64, Start::Cold),
        (Core::M7, Precision::F64, Start::Warm),
    ];
    let share = |(core, precision, start), part: Part| {
        let at = at(Some(core), precision, 16, start);
        let cycles = |part: Part| rows.get(&at, &format!("cycles of {}", part.name()), "mean");
        let total: f64 = Part::ALL.iter().map(|part| cycles(*part)).sum();
        (100.0 * cycles(part) / total, total)
    };
    let mut area = ChartBuilder::on(&root)
        .margin_left(16)
        .margin_right(60)
        .margin_bottom(12)
        .margin_top(150)
        .set_label_area_size(LabelAreaPosition::Left, 300)
        .set_label_area_size(LabelAreaPosition::Bottom, 64)
        .build_cartesian_2d(0.0..100.0, 0.0..solves.len() as f64)?;
    area.configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(INK)
        .label_style(font(22))
        .axis_desc_style(font(22))
        .disable_y_mesh()
        .y_labels(0)
        .x_desc("share of the modelled cycles, %")
        .x_label_formatter(&tick)
        .draw()?;
    for (row, solve) in solves.into_iter().enumerate() {
        let middle = solves.len() as f64 - row as f64 - 0.5;
        let mut from = 0.0;
        for (part, colour) in Part::ALL.into_iter().zip(COLOURS) {
            let (part_share, _) = share(solve, part);
            area.draw_series([Rectangle::new(
                [(from, middle - 0.3), (from + part_share, middle + 0.3)],
                colour.filled(),
            )])?;
            if part_share >= 4.0 {
                let (x, y) = area.backend_coord(&(from + 0.5 * part_share, middle));
                root.draw(&Text::new(
                    format!("{part_share:.0} %"),
                    (x, y),
                    bold(22, &WHITE).pos(Pos::new(HPos::Center, VPos::Center)),
                ))?;
            }
            from += part_share;
        }
        let (core, precision, start) = solve;
        let (x, y) = area.backend_coord(&(0.0, middle));
        let label = format!("{}, {}, {}", core.name(), name(precision), start.name());
        root.draw(&Text::new(
            label,
            (x - 14, y - 14),
            font(22).pos(Pos::new(HPos::Right, VPos::Center)),
        ))?;
        let total = crate::terminal::thousands(share(solve, Part::Start).1);
        root.draw(&Text::new(
            format!("{total} cycles"),
            (x - 14, y + 16),
            bold(22, &INK).pos(Pos::new(HPos::Right, VPos::Center)),
        ))?;
    }
    for (i, (part, colour)) in Part::ALL.into_iter().zip(COLOURS).enumerate() {
        let (x, y) = (40 + 380 * (i % 4) as i32, 74 + 34 * (i / 4) as i32);
        root.draw(&Rectangle::new(
            [(x, y + 6), (x + 34, y + 14)],
            colour.filled(),
        ))?;
        root.draw(&Text::new(part.name(), (x + 44, y), bold(24, &colour)))?;
    }
    root.present()?;
    Ok(())
}
