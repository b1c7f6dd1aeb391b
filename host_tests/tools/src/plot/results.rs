//! Stiffness over time or over speed.

use super::{Args, Over, Table};
use crate::figure::{range, ticks};
use crate::svg::{GRID, Picture, Side};
use host_tests::validation::figure::{Axis, BLUE, Colour, GREEN, INK, PURPLE, VERMILION};

const WIDTH: f64 = 1600.0;
/// Edges of the curves.
const LEFT: f64 = 112.0;
const RIGHT: f64 = WIDTH - 28.0;
const HEADING: f64 = 64.0;
/// Number of spans that a long recording is cut into, one point of each curve for each.
const SPANS: usize = 480;
/// Most curves of a panel; of more loads, every row is a dot.
const MOST_CURVES: usize = 8;
/// Most dots of a panel.
const MOST_DOTS: usize = 4000;

const COLOURS: [Colour; MOST_CURVES] = [
    BLUE,
    VERMILION,
    GREEN,
    PURPLE,
    INK,
    Colour(0x2A, 0x9F, 0xD6),
    Colour(0xB8, 0x86, 0x0B),
    Colour(0x8A, 0x5A, 0x44),
];

const LOADS: [&str; 6] = ["fx_n", "fy_n", "fz_n", "my_nm", "mz_nm", "speed_rpm"];
/// Their names and units in the picture.
const FORCES: [(&str, &str); 5] = [
    ("Fx", "N"),
    ("Fy", "N"),
    ("Fz", "N"),
    ("My", "N m"),
    ("Mz", "N m"),
];
const DIAGONAL: [&str; 5] = ["_x_x", "_y_y", "_z_z", "_ty_ty", "_tz_tz"];

/// A row of the results: time, loads and speed where the file has them, stiffness where there is an answer.
struct Row {
    time: f64,
    loads: Option<[f64; 6]>,
    stiffness: Option<[f64; 5]>,
}

/// One quantity.
struct Curve {
    label: String,
    colour: Colour,
    dash: f64,
    /// Value of each place; none where the curve is broken.
    points: Vec<(f64, Option<f64>)>,
}

/// The curves of one panel, in one unit.
struct Panel {
    title: &'static str,
    unit: &'static str,
    height: f64,
    /// The axis starts at zero rather than below the smallest value.
    from_zero: bool,
    dots: bool,
    curves: Vec<Curve>,
}

pub fn draw(table: &mut Table, args: &Args) -> Result<String, String> {
    let rows = read(table, args)?;
    match args.over {
        Over::Time => over_time(&rows, &table.file, args),
        Over::Speed => over_speed(&rows, table, args),
    }
}

fn read(table: &mut Table, args: &Args) -> Result<Vec<Row>, String> {
    let place = if args.nose { "k_nose" } else { "k" };
    let names = DIAGONAL.map(|name| format!("{place}{name}"));
    if args.nose && table.find(&names[0]).is_none() {
        return Err(format!(
            "{}: line 1: the column {} is missing; --nose is for results of a spindle with [nose]",
            table.file, names[0]
        ));
    }
    let stiffness = table.columns([0, 1, 2, 3, 4].map(|i| names[i].as_str()))?;
    let [time] = table.columns(["time_s"])?;
    let loads = match args.over {
        Over::Speed => Some(table.columns(LOADS)?),
        Over::Time => table.columns(LOADS).ok(),
    };
    let mut rows = Vec::new();
    while table.next()? {
        let Some(time) = table.number(time)? else {
            continue;
        };
        rows.push(Row {
            time,
            loads: match &loads {
                Some(loads) => table.numbers(loads)?,
                None => None,
            },
            stiffness: table.numbers(&stiffness)?,
        });
    }
    if rows.iter().filter(|row| row.stiffness.is_some()).count() < 2 {
        return Err(format!(
            "{}: fewer than two rows have an answer, nothing to draw; the column status says why",
            table.file
        ));
    }
    Ok(rows)
}

fn stiffness_panels(
    curve: impl Fn(usize, &str, Colour) -> Vec<Curve>,
    together: bool,
) -> Vec<Panel> {
    let radial = ("Radial stiffness", "N/\u{b5}m");
    let tilt = ("Tilt stiffness", "kN m/rad");
    let panel = |(title, unit), height, curves| Panel {
        title,
        unit,
        height,
        from_zero: false,
        dots: false,
        curves,
    };
    let axial = || {
        panel(
            ("Axial stiffness", "N/\u{b5}m"),
            240.0,
            curve(0, "K_xx", GREEN),
        )
    };
    if together {
        let both = |i, names: [&str; 2]| {
            let mut curves = curve(i, names[0], BLUE);
            curves.extend(curve(i + 1, names[1], VERMILION));
            curves
        };
        return vec![
            panel(radial, 300.0, both(1, ["K_yy", "K_zz"])),
            axial(),
            panel(tilt, 300.0, both(3, ["K_ty,ty", "K_tz,tz"])),
        ];
    }
    let one = |(_, unit), title, i| panel((title, unit), 260.0, curve(i, "", BLUE));
    vec![
        one(radial, "Radial stiffness K_yy", 1),
        one(radial, "Radial stiffness K_zz", 2),
        one(radial, "Axial stiffness K_xx", 0),
        one(tilt, "Tilt stiffness K_ty,ty", 3),
        one(tilt, "Tilt stiffness K_tz,tz", 4),
    ]
}

/// Stiffness number `i` in the unit of its panel.
fn shown(stiffness: &[f64; 5], i: usize) -> f64 {
    stiffness[i] / if i < 3 { 1e6 } else { 1e3 }
}

fn over_time(rows: &[Row], file: &str, args: &Args) -> Result<String, String> {
    let curve = |label: &str, colour, value: &dyn Fn(&Row) -> Option<f64>| {
        vec![Curve {
            label: label.to_owned(),
            colour,
            dash: 0.0,
            points: rows.iter().map(|row| (row.time, value(row))).collect(),
        }]
    };
    let mut panels = Vec::new();
    if rows.iter().any(|row| row.loads.is_some()) {
        let load = |label, colour, of: fn(&[f64; 6]) -> f64| {
            curve(label, colour, &move |row| row.loads.as_ref().map(of))
        };
        let panel = |title, unit, height, curves| Panel {
            title,
            unit,
            height,
            from_zero: true,
            dots: false,
            curves,
        };
        let speed = load("", INK, |l| l[5] / 1e3);
        panels.push(panel("Shaft speed", "1000 rpm", 170.0, speed));
        let mut loads = load("axial Fx", GREEN, |l| l[0]);
        loads.extend(load("radial |Fy, Fz|", VERMILION, |l| l[1].hypot(l[2])));
        panels.push(panel("Load", "N", 220.0, loads));
    }
    let stiffness = |i: usize, label: &str, colour| {
        curve(label, colour, &move |row: &Row| {
            row.stiffness.as_ref().map(|k| shown(k, i))
        })
    };
    panels.extend(stiffness_panels(stiffness, true));
    let times = rows.iter().map(|row| row.time);
    let (low, high) = range(times, false, 0.0);
    if !(high > low) {
        return Err(format!(
            "{file}: all rows have the time {low} s, nothing to draw over time"
        ));
    }
    let mut note = String::new();
    if rows.len() > 2 * SPANS {
        let width = (high - low) / SPANS as f64;
        note = format!("line: mean of {width:.2} s; band: smallest to largest");
    }
    let title = args.title(|file| format!("{file}: stiffness{} over time", at_nose(args)));
    Ok(picture(
        &title,
        &note,
        "time / s",
        (low, high),
        &panels,
        &[],
    ))
}

/// Speed in thousands of revolutions per minute, and stiffness there.
type AtSpeed = (f64, [f64; 5]);

fn over_speed(rows: &[Row], table: &Table, args: &Args) -> Result<String, String> {
    let mut groups: Vec<([f64; 5], Vec<AtSpeed>)> = Vec::new();
    let mut all = Vec::new();
    for row in rows {
        let (Some([load @ .., speed]), Some(stiffness)) = (row.loads, row.stiffness) else {
            continue;
        };
        all.push((speed / 1e3, stiffness));
        if groups.len() <= MOST_CURVES {
            match groups.iter_mut().find(|group| group.0 == load) {
                Some(group) => group.1.push((speed / 1e3, stiffness)),
                None => groups.push((load, vec![(speed / 1e3, stiffness)])),
            }
        }
    }
    let (low, high) = range(all.iter().map(|point| point.0), false, 0.0);
    if !all.iter().any(|point| point.0 != all[0].0) {
        return Err(format!(
            "{}: fewer than two speeds have an answer, nothing to draw over speed",
            table.file
        ));
    }
    let dots = groups.len() > MOST_CURVES;
    let first = groups[0].0;
    let varies = [0, 1, 2, 3, 4].map(|i| groups.iter().any(|group| group.0[i] != first[i]));
    let named = |load: &[f64; 5], varying: bool| {
        let loads = FORCES.iter().zip(load).zip(varies);
        let loads =
            loads.filter(|((_, load), varies)| *varies == varying && (varying || **load != 0.0));
        let loads = loads.map(|(((name, unit), load), _)| format!("{name} = {load} {unit}"));
        loads.collect::<Vec<_>>().join(", ")
    };
    let step = all.len().div_ceil(MOST_DOTS);
    let note = if dots && step > 1 {
        format!("each dot is a row of the file; one in {step} is drawn")
    } else if dots {
        "each dot is a row of the file".to_owned()
    } else {
        named(&first, false)
    };
    let labels: Vec<_> = groups.iter().map(|(load, _)| named(load, true)).collect();
    if dots {
        groups = vec![(first, all)];
    }
    for (_, points) in &mut groups {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let curve = |i: usize, _: &str, _: Colour| {
        let curves = groups
            .iter()
            .enumerate()
            .map(|(number, (_, points))| Curve {
                label: String::new(),
                colour: COLOURS[number],
                dash: dash(number),
                points: points
                    .iter()
                    .step_by(if dots { step } else { 1 })
                    .map(|(speed, k)| (*speed, Some(shown(k, i))))
                    .collect(),
            });
        curves.collect()
    };
    let mut panels = stiffness_panels(curve, false);
    for panel in &mut panels {
        panel.dots = dots;
    }
    let legend: Vec<_> = labels.into_iter().zip(COLOURS).collect();
    let legend = if groups.len() > 1 { &legend[..] } else { &[] };
    let title = args.title(|file| format!("{file}: stiffness{} over speed", at_nose(args)));
    Ok(picture(
        &title,
        &note,
        "shaft speed / 1000 rpm",
        (low, high),
        &panels,
        legend,
    ))
}

fn at_nose(args: &Args) -> &'static str {
    if args.nose { " at the nose" } else { "" }
}

/// Length of the dashes of curve number `i`: told apart in black and white, too.
fn dash(i: usize) -> f64 {
    [0.0, 14.0, 7.0, 2.0][i % 4]
}

/// Smallest, mean and largest value at a place; none where the curve is broken.
type Spot = (f64, Option<[f64; 3]>);

/// The points of a curve, or those of spans if there are more than `most`.
fn spots(points: &[(f64, Option<f64>)], (low, high): (f64, f64), most: usize) -> Vec<Spot> {
    if points.len() <= most {
        let spot = |(x, value): &(f64, Option<f64>)| (*x, value.map(|value| [value; 3]));
        return points.iter().map(spot).collect();
    }
    let width = (high - low) / SPANS as f64;
    // Points without and with a value; least, sum and most.
    let mut spans = vec![(0_usize, 0_usize, [f64::INFINITY, 0.0, f64::NEG_INFINITY]); SPANS];
    for (x, value) in points {
        let (without, with, [least, sum, most]) =
            &mut spans[(((x - low) / width) as usize).min(SPANS - 1)];
        match value {
            Some(value) => {
                *with += 1;
                *least = least.min(*value);
                *sum += value;
                *most = most.max(*value);
            }
            None => *without += 1,
        }
    }
    let spans = spans.into_iter().enumerate();
    let spans = spans.filter(|(_, (without, with, _))| without + with > 0);
    spans
        .map(|(i, (_, with, [least, sum, most]))| {
            let value = (with > 0).then(|| [least, sum / with as f64, most]);
            (low + (i as f64 + 0.5) * width, value)
        })
        .collect()
}

fn picture(
    title: &str,
    note: &str,
    x_label: &str,
    x: (f64, f64),
    panels: &[Panel],
    legend: &[(String, Colour)],
) -> String {
    let columns = legend.iter().map(|(label, _)| label.chars().count()).max();
    let cell = 90.0 + 13.0 * columns.unwrap_or(0) as f64;
    let columns = ((RIGHT - LEFT) / cell).floor().max(1.0) as usize;
    let legend_height = 36.0 * legend.len().div_ceil(columns) as f64;
    let height = panels.iter().map(|panel| panel.height).sum::<f64>();
    let mut picture = Picture::new(WIDTH, HEADING + legend_height + height + 70.0);
    picture.bold((LEFT, 34.0), Side::Right, 28.0, INK, title);
    // Beside the title if there is room.
    let used = 17.0 * title.chars().count() as f64 + 11.0 * note.chars().count() as f64;
    if used < RIGHT - LEFT {
        picture.text((RIGHT, 36.0), Side::Left, 21.0, note);
    } else {
        picture.text((LEFT, 62.0), Side::Right, 19.0, note);
    }
    for (i, (label, colour)) in legend.iter().enumerate() {
        let left = LEFT + (i % columns) as f64 * cell;
        let y = HEADING + 20.0 + (i / columns) as f64 * 36.0;
        picture.line(&[(left, y), (left + 56.0, y)], *colour, 3.0, dash(i));
        picture.text((left + 66.0, y), Side::Right, 21.0, label);
    }
    let mut top = HEADING + legend_height;
    for (i, panel) in panels.iter().enumerate() {
        let last = i + 1 == panels.len();
        draw_panel(&mut picture, panel, top, x, last.then_some(x_label));
        top += panel.height;
    }
    picture.finish()
}

fn draw_panel(
    picture: &mut Picture,
    panel: &Panel,
    top: f64,
    (x0, x1): (f64, f64),
    x_label: Option<&str>,
) {
    let (upper, lower) = (top + 44.0, top + panel.height - 12.0);
    let curves: Vec<_> = panel
        .curves
        .iter()
        .map(|curve| {
            // Of dots there are never too many.
            let most = if panel.dots { usize::MAX } else { 2 * SPANS };
            (curve, spots(&curve.points, (x0, x1), most))
        })
        .collect();
    let values = curves.iter().flat_map(|(_, spots)| spots);
    let values = values.filter_map(|(_, value)| *value).flatten();
    let (y0, y1) = match range(values, panel.from_zero, 0.08) {
        // What rounding makes of a constant is no curve.
        (y0, y1) if y1 - y0 < 1e-4 * y0.abs() => (y0 - 0.05 * y0.abs(), y1 + 0.05 * y1.abs()),
        (y0, y1) if y0 < y1 => (y0, y1),
        _ => (0.0, 1.0),
    };
    let at = |x: f64, y: f64| {
        (
            LEFT + (x - x0) / (x1 - x0) * (RIGHT - LEFT),
            lower - (y - y0) / (y1 - y0) * (lower - upper),
        )
    };
    for (value, number) in ticks(&Axis::new(""), y0, y1) {
        let (_, y) = at(x0, value);
        picture.line(&[(LEFT, y), (RIGHT, y)], GRID, 1.0, 0.0);
        picture.text((LEFT - 10.0, y), Side::Left, 20.0, &number);
    }
    for (value, number) in fine_ticks(x0, x1) {
        let (x, _) = at(value, y0);
        picture.line(&[(x, upper), (x, lower)], GRID, 1.0, 0.0);
        if x_label.is_some() {
            picture.text((x, lower + 22.0), Side::Centre, 20.0, &number);
        }
    }
    picture.line(
        &[(LEFT, upper), (LEFT, lower), (RIGHT, lower)],
        INK,
        1.5,
        0.0,
    );
    if let Some(label) = x_label {
        picture.text(
            ((LEFT + RIGHT) / 2.0, lower + 56.0),
            Side::Centre,
            21.0,
            label,
        );
    }
    picture.upright((24.0, (upper + lower) / 2.0), 20.0, panel.unit);

    let runs = |spots: &[Spot]| -> Vec<Vec<(f64, [f64; 3])>> {
        let runs = spots.split(|(_, value)| value.is_none());
        let runs = runs.map(|run| run.iter().filter_map(|(x, v)| Some((*x, (*v)?))).collect());
        runs.filter(|run: &Vec<_>| !run.is_empty()).collect()
    };
    if panel.dots {
        for (curve, spots) in &curves {
            for (x, value) in spots {
                if let Some([_, value, _]) = value {
                    picture.disc(at(*x, *value), 2.5, curve.colour, 0.5);
                }
            }
        }
    } else {
        for (curve, spots) in &curves {
            for run in runs(spots) {
                if run.iter().all(|(_, [least, _, most])| least == most) {
                    continue;
                }
                let above = run.iter().map(|(x, [.., most])| at(*x, *most));
                let below = run.iter().rev().map(|(x, [least, ..])| at(*x, *least));
                let points: Vec<_> = above.chain(below).collect();
                picture.area(&points, curve.colour, 0.28);
            }
        }
        // Curves that the panel names may run on each other: each is thinner than the one under it.
        let mut under = panel
            .curves
            .iter()
            .filter(|curve| !curve.label.is_empty())
            .count();
        for (curve, spots) in &curves {
            under = under.saturating_sub(1);
            for run in runs(spots) {
                let points: Vec<_> = run.iter().map(|(x, [_, mean, _])| at(*x, *mean)).collect();
                match points[..] {
                    [point] => picture.disc(point, 3.0, curve.colour, 1.0),
                    _ => picture.line(&points, curve.colour, 2.5 + 2.5 * under as f64, curve.dash),
                }
            }
        }
    }

    // The legend stands in the title line, where no curve can run through it.
    picture.bold((LEFT, top + 24.0), Side::Right, 22.0, INK, panel.title);
    let mut x = LEFT + 260.0;
    for curve in &panel.curves {
        if curve.label.is_empty() {
            continue;
        }
        let line = [(x, top + 24.0), (x + 40.0, top + 24.0)];
        picture.line(&line, curve.colour, 5.0, 0.0);
        picture.bold(
            (x + 52.0, top + 24.0),
            Side::Right,
            21.0,
            curve.colour,
            &curve.label,
        );
        x += 90.0 + 14.0 * curve.label.chars().count() as f64;
    }
}

/// Some twelve ticks.
fn fine_ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    let step = crate::figure::tick_step(high - low, 12.0);
    ticks(&Axis::new("").every(step), low, high)
}
