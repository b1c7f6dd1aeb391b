//! Draws the stiffness of a bearing over a recording: `docs/stiffness_over_cycle.svg`.
//!
//! Every row of the recording is solved. What the teeth of the cutter do between two pixels is
//! drawn as a band from the smallest to the largest value, the mean as a line in it.

use anyhow::{Context, bail};
use host_tests::design_file::{DesignFile, SHIPPED};
use host_tests::dispatch::{self, Attitude, Precision};
use host_tests::loads;
use host_tests::milling_cycle::RECORD;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

const PICTURE: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../docs/stiffness_over_cycle.svg"
);

const SIZE: (u32, u32) = (1600, 1360);
/// Number of spans of time that the recording is cut into, one point of each curve for each.
const SPANS: usize = 360;

// An opaque panel, so that the picture reads the same on a light and on a dark page.
const PANEL: RGBColor = RGBColor(0xF7, 0xF8, 0xFA);
const INK: RGBColor = RGBColor(0x25, 0x2B, 0x33);
const GRID: RGBColor = RGBColor(0xD5, 0xDA, 0xE1);
// Told apart by people with any colour vision (Okabe and Ito's blue, vermilion and green).
const FIRST: RGBColor = RGBColor(0x00, 0x72, 0xB2);
const SECOND: RGBColor = RGBColor(0xD5, 0x5E, 0x00);
const THIRD: RGBColor = RGBColor(0x00, 0x80, 0x60);

/// One quantity over time.
struct Curve {
    label: &'static str,
    colour: RGBColor,
    values: Vec<f64>,
}

/// The curves of one panel, in one unit.
struct Panel {
    title: &'static str,
    unit: &'static str,
    /// The axis starts at zero rather than below the smallest value.
    from_zero: bool,
    curves: Vec<Curve>,
}

fn main() -> anyhow::Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let (bearing, record, picture) = match args.as_slice() {
        [] => (
            format!("{SHIPPED}/b7005c.toml"),
            RECORD.to_owned(),
            PICTURE.to_owned(),
        ),
        [bearing, record, picture] => (bearing.clone(), record.clone(), picture.clone()),
        _ => bail!("usage: plot_record [BEARING.toml LOADS.csv PICTURE.svg]"),
    };
    let (name, time, panels) = solve(&bearing, &record)?;
    let occasion = if record == RECORD {
        "a synthetic milling cycle"
    } else {
        record.as_str()
    };
    let title = format!("{name}: stiffness over {occasion}");
    draw(&picture, &title, &time, &panels).with_context(|| format!("cannot draw {picture}"))?;
    println!("{picture}: {} rows, {SPANS} spans", time.len());
    Ok(())
}

/// Name of the bearing, the times of the rows with an answer, and what to draw of them.
fn solve(bearing: &str, record: &str) -> anyhow::Result<(String, Vec<f64>, Vec<Panel>)> {
    let file = DesignFile::read(bearing)?;
    let built = dispatch::bearing(&file.design, file.balls, Precision::F64)
        .map_err(|error| file.explain(&error))?;
    let mut solver = built.solver(Attitude::Raceless);

    let mut time = Vec::new();
    let mut rows: [Vec<f64>; 8] = Default::default();
    for row in loads::read(record)? {
        let row = row?;
        let Ok(figures) = solver.solve(row.load, row.omega()).figures else {
            continue;
        };
        let k = figures.stiffness;
        let [fx, fy, fz, ..] = row.load;
        time.push(row.time_s);
        for (values, value) in rows.iter_mut().zip([
            row.speed_rpm / 1e3,
            fx,
            fy.hypot(fz),
            k[0][0] / 1e6,
            k[1][1] / 1e6,
            k[2][2] / 1e6,
            k[3][3] / 1e3,
            k[4][4] / 1e3,
        ]) {
            values.push(value);
        }
    }
    if time.len() < 2 {
        bail!("{record}: fewer than two rows that can be solved, nothing to draw");
    }
    let [speed, axial, radial, kxx, kyy, kzz, ktyty, ktztz] = rows;
    let curve = |label, colour, values| Curve {
        label,
        colour,
        values,
    };
    let panel = |title, unit, from_zero, curves| Panel {
        title,
        unit,
        from_zero,
        curves,
    };
    let panels = vec![
        panel("Shaft speed", "1000 rpm", true, vec![curve("", INK, speed)]),
        panel(
            "Load",
            "N",
            true,
            vec![
                curve("axial Fx", THIRD, axial),
                curve("radial |Fy, Fz|", SECOND, radial),
            ],
        ),
        panel(
            "Radial stiffness",
            "N/\u{b5}m",
            false,
            vec![curve("K_yy", FIRST, kyy), curve("K_zz", SECOND, kzz)],
        ),
        panel(
            "Axial stiffness",
            "N/\u{b5}m",
            false,
            vec![curve("K_xx", THIRD, kxx)],
        ),
        panel(
            "Tilt stiffness",
            "kN m/rad",
            false,
            vec![
                curve("K_ty,ty", FIRST, ktyty),
                curve("K_tz,tz", SECOND, ktztz),
            ],
        ),
    ];
    Ok((file.name, time, panels))
}

/// Smallest, mean and largest value of each span of time that has any, with the time of its middle.
fn spans(time: &[f64], values: &[f64]) -> Vec<(f64, [f64; 3])> {
    let (start, end) = (time[0], time[time.len() - 1]);
    let width = (end - start) / SPANS as f64;
    let mut spans = vec![(0usize, [f64::INFINITY, 0.0, f64::NEG_INFINITY]); SPANS];
    for (t, &value) in time.iter().zip(values) {
        let i = (((t - start) / width) as usize).min(SPANS - 1);
        let (count, [least, sum, most]) = &mut spans[i];
        *count += 1;
        *least = least.min(value);
        *sum += value;
        *most = most.max(value);
    }
    spans
        .into_iter()
        .enumerate()
        .filter(|(_, (count, _))| *count > 0)
        .map(|(i, (count, [least, sum, most]))| {
            let middle = start + (i as f64 + 0.5) * width;
            (middle, [least, sum / count as f64, most])
        })
        .collect()
}

fn draw(picture: &str, title: &str, time: &[f64], panels: &[Panel]) -> anyhow::Result<()> {
    if let Some(folder) = Path::new(picture).parent() {
        std::fs::create_dir_all(folder)?;
    }
    let root = SVGBackend::new(picture, SIZE).into_drawing_area();
    root.fill(&PANEL)?;
    let (heading, below) = root.split_vertically(64);
    heading.draw(&Text::new(
        title,
        (112, 20),
        ("sans-serif", 30).into_font().color(&INK),
    ))?;
    heading.draw(&Text::new(
        format!(
            "line: mean of {:.2} s; band: smallest to largest",
            (time[time.len() - 1] - time[0]) / SPANS as f64
        ),
        (SIZE.0 as i32 - 28, 26),
        ("sans-serif", 22)
            .into_font()
            .color(&INK)
            .pos(Pos::new(HPos::Right, VPos::Top)),
    ))?;
    // The upper two give the setting and take less height.
    let heights = [170, 220, 300, 240];
    let mut rest = below;
    for (i, panel) in panels.iter().enumerate() {
        let area = match heights.get(i) {
            Some(&height) if i + 1 < panels.len() => {
                let (area, below) = rest.split_vertically(height);
                rest = below;
                area
            }
            _ => rest.clone(),
        };
        draw_panel(&area, time, panel, i + 1 == panels.len())?;
    }
    root.present()?;
    Ok(())
}

/// A number on an axis.
fn tick(value: &f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map(str::to_owned).unwrap_or(text)
}

fn draw_panel(
    area: &DrawingArea<SVGBackend, Shift>,
    time: &[f64],
    panel: &Panel,
    last: bool,
) -> anyhow::Result<()> {
    let curves: Vec<_> = panel
        .curves
        .iter()
        .map(|curve| (curve, spans(time, &curve.values)))
        .collect();
    let all = || curves.iter().flat_map(|(_, spans)| spans);
    let most = all().fold(f64::NEG_INFINITY, |m, (_, [.., most])| m.max(*most));
    let least = all().fold(f64::INFINITY, |m, (_, [least, ..])| m.min(*least));
    let room = (most - least).max(1e-9 * most.abs()).max(f64::MIN_POSITIVE) * 0.08;
    let low = if panel.from_zero { 0.0 } else { least - room };

    let mut chart = ChartBuilder::on(area)
        .margin_left(16)
        .margin_right(28)
        .margin_bottom(if last { 8 } else { 0 })
        .set_label_area_size(LabelAreaPosition::Left, 96)
        .set_label_area_size(LabelAreaPosition::Bottom, if last { 60 } else { 14 })
        .margin_top(44)
        .build_cartesian_2d(time[0]..time[time.len() - 1], low..most + room)?;
    let text = ("sans-serif", 22).into_font().color(&INK);
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(INK)
        .label_style(text.clone())
        .axis_desc_style(text.clone())
        .y_desc(panel.unit)
        .y_labels(5)
        .y_label_formatter(&tick)
        .x_labels(15);
    if last {
        mesh.x_desc("time / s").x_label_formatter(&tick);
    } else {
        mesh.x_label_formatter(&|_| String::new());
    }
    mesh.draw()?;

    for (curve, spans) in &curves {
        let upper = spans.iter().map(|(t, [.., most])| (*t, *most));
        let lower = spans.iter().rev().map(|(t, [least, ..])| (*t, *least));
        chart.draw_series([Polygon::new(
            upper.chain(lower).collect::<Vec<_>>(),
            curve.colour.mix(0.28),
        )])?;
    }
    // Each curve is thinner than the one under it, so that none hides another.
    for (width, (curve, spans)) in (1..=curves.len() as u32).rev().zip(&curves) {
        chart.draw_series(LineSeries::new(
            spans.iter().map(|(t, [_, mean, _])| (*t, *mean)),
            curve.colour.stroke_width(2 * width),
        ))?;
    }

    // The legend stands in the title line, where no curve can run through it.
    let bold = |colour: &RGBColor| {
        ("sans-serif", 24, FontStyle::Bold)
            .into_font()
            .color(colour)
    };
    area.draw(&Text::new(panel.title, (112, 14), bold(&INK)))?;
    let mut x = 360;
    for curve in &panel.curves {
        if curve.label.is_empty() {
            continue;
        }
        area.draw(&Rectangle::new(
            [(x, 20), (x + 34, 28)],
            curve.colour.filled(),
        ))?;
        area.draw(&Text::new(curve.label, (x + 44, 14), bold(&curve.colour)))?;
        x += 240;
    }
    Ok(())
}
