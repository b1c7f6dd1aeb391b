//! Contact forces around the bearing.

use super::{Args, Table};
use crate::figure::{tick_label, tick_step};
use crate::svg::{GRID, Picture, Side};
use host_tests::validation::figure::{BLUE, Colour, INK, VERMILION};
use std::f64::consts::TAU;

const CELL: f64 = 760.0;
const HEADING: f64 = 110.0;
/// Radius of the largest ring.
const RADIUS: f64 = 290.0;
/// Most rows of balls of a picture.
const MOST_ROWS: usize = 64;

/// A ball: its row, azimuth, and forces at the inner and outer contact.
type Ball = (usize, f64, [f64; 2]);

pub fn draw(table: &mut Table, args: &Args) -> Result<String, String> {
    let (time, balls) = wanted(table, args.time)?;
    let most = balls.iter().flat_map(|ball| ball.2).fold(0.0, f64::max);
    if !(most > 0.0) {
        return Err(format!(
            "{}: no ball carries a force at {time} s",
            table.file
        ));
    }
    let step = tick_step(most, 4.0);
    let rim = (most / step).ceil() * step;
    let rows = balls.iter().map(|ball| ball.0).max().unwrap_or(0) + 1;
    let columns = rows.min(2);
    let down = rows.div_ceil(columns);
    let mut picture = Picture::new(CELL * columns as f64, HEADING + (CELL - 40.0) * down as f64);
    let title = args.title(|file| format!("{file}: contact forces"));
    picture.bold((28.0, 34.0), Side::Right, 26.0, INK, &title);
    picture.text(
        (28.0, 74.0),
        Side::Right,
        21.0,
        &format!("at {time} s, in N"),
    );
    for (i, (name, colour)) in [("inner race", BLUE), ("outer race", VERMILION)]
        .into_iter()
        .enumerate()
    {
        let x = 330.0 + 200.0 * i as f64;
        picture.line(&[(x, 74.0), (x + 44.0, 74.0)], colour, 3.0, dash(i));
        mark(&mut picture, (x + 22.0, 74.0), i, colour);
        picture.bold((x + 56.0, 74.0), Side::Right, 21.0, colour, name);
    }
    for row in 0..rows {
        let centre = (
            CELL * ((row % columns) as f64 + 0.5),
            HEADING + (CELL - 40.0) * ((row / columns) as f64 + 0.5) + 6.0,
        );
        let title = if rows > 1 {
            format!("row {row}")
        } else {
            String::new()
        };
        let balls: Vec<_> = balls.iter().filter(|ball| ball.0 == row).copied().collect();
        around(&mut picture, centre, &title, &balls, rim, step);
    }
    Ok(picture.finish())
}

/// Time and balls of the lines with this time, or the nearest to it; those with the largest force if none is given.
fn wanted(table: &mut Table, time: Option<f64>) -> Result<(f64, Vec<Ball>), String> {
    let columns = table.columns(["time_s", "azimuth_rad", "q_i_n", "q_o_n"])?;
    let row_column = table.find("row");
    let mut best: Option<(f64, f64, Vec<Ball>)> = None;
    let mut group: (f64, Vec<Ball>) = (f64::NAN, Vec::new());
    loop {
        let more = table.next()?;
        let numbers = if more { table.numbers(&columns)? } else { None };
        let at = numbers.map_or(f64::NAN, |numbers| numbers[0]);
        if at != group.0 && !group.1.is_empty() {
            let forces = group.1.iter().flat_map(|ball| ball.2);
            let rank = match time {
                Some(time) => -(group.0 - time).abs(),
                None => forces.fold(0.0, f64::max),
            };
            if best.as_ref().is_none_or(|best| rank > best.0) {
                best = Some((rank, group.0, std::mem::take(&mut group.1)));
            }
            group.1.clear();
        }
        if !more {
            break;
        }
        group.0 = at;
        if let Some([_, azimuth, inner, outer]) = numbers {
            let row = match row_column {
                Some(column) => table.number(column)?.unwrap_or(0.0),
                None => 0.0,
            };
            if !(0.0..MOST_ROWS as f64).contains(&row) {
                return Err(format!(
                    "{}: row {row} is none of 0 to {}",
                    table.file,
                    MOST_ROWS - 1
                ));
            }
            group.1.push((row as usize, azimuth, [inner, outer]));
        }
    }
    let file = &table.file;
    match best {
        Some((_, time, balls)) => Ok((time, balls)),
        None => Err(format!(
            "{file}: no ball has forces, nothing to draw: no row had an answer"
        )),
    }
}

fn dash(race: usize) -> f64 {
    [0.0, 10.0][race]
}

fn mark(picture: &mut Picture, at: (f64, f64), race: usize, colour: Colour) {
    if race == 0 {
        picture.disc(at, 6.0, colour, 1.0);
    } else {
        picture.circle(at, 7.5, colour, 2.5);
    }
}

fn around(
    picture: &mut Picture,
    (cx, cy): (f64, f64),
    title: &str,
    balls: &[Ball],
    rim: f64,
    step: f64,
) {
    // Seen along the shaft: +y to the right, +z upwards.
    let at = |azimuth: f64, value: f64| {
        let radius = RADIUS * value / rim;
        (cx + radius * azimuth.cos(), cy - radius * azimuth.sin())
    };
    picture.bold(
        (cx - CELL / 2.0 + 28.0, cy - RADIUS - 40.0),
        Side::Right,
        22.0,
        INK,
        title,
    );
    let rings = (rim / step).round() as usize;
    for i in 1..=rings {
        let (colour, width) = if i == rings { (INK, 1.5) } else { (GRID, 1.5) };
        picture.circle((cx, cy), RADIUS * i as f64 / rings as f64, colour, width);
    }
    for spoke in 0..8 {
        let azimuth = f64::from(spoke) * TAU / 8.0;
        picture.line(&[(cx, cy), at(azimuth, rim)], GRID, 1.0, 0.0);
        let label = match spoke {
            0 => "0\u{b0} +y".to_owned(),
            2 => "90\u{b0} +z".to_owned(),
            _ => format!("{}\u{b0}", 45 * spoke),
        };
        let (x, y) = at(azimuth, rim * (1.0 + 20.0 / RADIUS));
        let side = match spoke {
            0 | 1 | 7 => Side::Right,
            2 | 6 => Side::Centre,
            _ => Side::Left,
        };
        picture.text(
            (x - if spoke == 0 { 10.0 } else { 0.0 }, y),
            side,
            19.0,
            &label,
        );
    }
    for (race, colour) in [(1, VERMILION), (0, BLUE)] {
        let mut forces: Vec<(f64, f64)> = balls
            .iter()
            .map(|(_, azimuth, forces)| (azimuth.rem_euclid(TAU), forces[race]))
            .collect();
        forces.sort_by(|a, b| a.0.total_cmp(&b.0));
        let curve: Vec<_> = smooth(&forces)
            .into_iter()
            .map(|(azimuth, force)| at(azimuth, force))
            .collect();
        if race == 0 {
            picture.area(&curve, colour, 0.12);
        }
        // The outer one may lie under the inner one.
        picture.line(
            &curve,
            colour,
            if race == 0 { 3.0 } else { 5.0 },
            dash(race),
        );
        for (azimuth, force) in forces {
            mark(picture, at(azimuth, force), race, colour);
        }
    }
    // Last, so that no curve runs through a number.
    for i in 1..=rings {
        let value = step * i as f64;
        let number = tick_label(value, step);
        let (x, y) = at(-TAU / 32.0, value);
        let half = 4.0 + 5.5 * number.chars().count() as f64;
        let plate = [
            (x - half, y - 11.0),
            (x + half, y - 11.0),
            (x + half, y + 11.0),
            (x - half, y + 11.0),
        ];
        picture.area(&plate, crate::svg::BACKGROUND, 0.8);
        picture.text((x, y), Side::Centre, 18.0, &number);
    }
}

/// A closed curve through points in rising order of their azimuths that has no peaks but theirs: Hermite's, with the
/// harmonic mean of the slopes on both sides (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984).
fn smooth(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const PIECES: usize = 24;
    let count = points.len();
    if count < 3 {
        return points.iter().chain(points.first()).copied().collect();
    }
    let point = |i: usize| {
        let (azimuth, value) = points[i % count];
        (azimuth + TAU * (i / count) as f64, value)
    };
    let chord = |i: usize| {
        let (a, b) = (point(i), point(i + 1));
        let run = b.0 - a.0;
        if run > 0.0 { (b.1 - a.1) / run } else { 0.0 }
    };
    let slope = |i: usize| {
        let (before, after) = (chord(i + count - 1), chord(i));
        if before * after > 0.0 {
            2.0 * before * after / (before + after)
        } else {
            0.0
        }
    };
    let mut curve = Vec::with_capacity(count * PIECES + 1);
    for i in 0..count {
        let (a, b) = (point(i), point(i + 1));
        let run = b.0 - a.0;
        let (start, end) = (slope(i) * run, slope(i + 1) * run);
        for piece in 0..PIECES {
            let t = piece as f64 / PIECES as f64;
            let rest = 1.0 - t;
            let value = rest * rest * ((1.0 + 2.0 * t) * a.1 + t * start)
                + t * t * ((1.0 + 2.0 * rest) * b.1 - rest * end);
            curve.push((a.0 + t * run, value.max(0.0)));
        }
    }
    curve.push(point(count));
    curve
}
