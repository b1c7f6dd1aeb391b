//! The 218 under axial load at four speeds.

use super::figure::{
    Axis, BLUE, Curve, Dash, Figure, GREEN, INK, Marker, Panel, Pen, Plane, VERMILION,
};
use super::scene::{Scene, Solved, solve_all};
use super::statement::{Measure, Statement, thousands};
use super::{Block, COMMAND, Chapter, Progress, judged};
use crate::cases::B218;
use crate::dispatch::Attitude;

const SPEEDS: [f64; 4] = [0.0, 6_000.0, 10_000.0, 15_000.0];
const TOP: f64 = 40_000.0;
const STEPS: usize = 48;

const PENS: [(Pen, Pen); 4] = [
    (
        Pen(INK, Dash::Solid, Marker::Cross),
        Pen(INK, Dash::Solid, Marker::Cross),
    ),
    (
        Pen(BLUE, Dash::Solid, Marker::Square),
        Pen(BLUE, Dash::Long, Marker::Square),
    ),
    (
        Pen(GREEN, Dash::Solid, Marker::Disc),
        Pen(GREEN, Dash::Long, Marker::Disc),
    ),
    (
        Pen(VERMILION, Dash::Solid, Marker::Triangle),
        Pen(VERMILION, Dash::Long, Marker::Triangle),
    ),
];

/// Loads, N: closer to each other where they are light, since there the angles change fastest.
fn loads() -> impl Iterator<Item = f64> {
    (0..=STEPS).map(|i| {
        let part = i as f64 / STEPS as f64;
        // Without a load the ring floats.
        100.0 + (TOP - 100.0) * part * part
    })
}

fn panel(title: &str, y: &str, curves: Vec<Curve>) -> Panel {
    Panel {
        title: title.to_owned(),
        plane: Plane::Straight {
            x: Axis::from_zero("axial load Fx / kN"),
            y: Axis::from_zero(y),
        },
        curves,
        nodes: Vec::new(),
    }
}

fn curve(pen: Pen, run: &[Solved], of: impl Fn(&Solved) -> f64) -> Curve {
    let points = run.iter().map(|s| (s.scene.load[0] / 1e3, of(s)));
    // Loads are close together at the light end.
    let mut curve = Curve::through(pen, points.collect(), 6, 6);
    curve.marks.retain(|(x, _)| *x > 0.5);
    curve
}

fn inner(s: &Solved) -> f64 {
    s.balls[0].alpha_i.to_degrees()
}

fn outer(s: &Solved) -> f64 {
    s.balls[0].alpha_o.to_degrees()
}

fn force(s: &Solved) -> f64 {
    s.balls[0].q_i
}

/// Least and largest of `of` over pairs of neighbouring runs at the same load.
fn between(runs: &[Vec<Solved>], of: impl Fn(&Solved, &Solved) -> f64) -> (f64, f64) {
    let mut range = (f64::INFINITY, f64::NEG_INFINITY);
    for pair in runs.windows(2) {
        for (slow, fast) in pair[0].iter().zip(&pair[1]) {
            let v = of(slow, fast);
            range = (range.0.min(v), range.1.max(v));
        }
    }
    range
}

/// Least and largest of the steps of `of` along the loads.
fn along(run: &[Solved], of: impl Fn(&Solved) -> f64) -> (f64, f64) {
    let steps = run.windows(2).map(|w| of(&w[1]) - of(&w[0]));
    steps.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| {
        (l.min(s), h.max(s))
    })
}

fn statements(runs: &[Vec<Solved>]) -> Vec<Statement> {
    let rest = &runs[0];
    let apart = rest
        .iter()
        .fold(0.0_f64, |m, s| m.max((inner(s) - outer(s)).abs()));
    let end = rest.len() - 1;
    let gap = |s: &Solved| inner(s) - outer(s);
    let at_speed = &runs[1..];
    let narrowing = at_speed
        .iter()
        .map(|run| along(run, gap).1)
        .fold(f64::NEG_INFINITY, f64::max);
    let outer_rise = runs
        .iter()
        .map(|r| along(r, outer).0)
        .fold(f64::INFINITY, f64::min);
    let from_rest = at_speed.iter().flat_map(|run| {
        let pairs = run.iter().zip(rest);
        pairs.map(|(s, r)| 100.0 * (force(s) / force(r) - 1.0))
    });
    let pairs = at_speed.windows(2).flat_map(|w| w[0].iter().zip(&w[1]));
    let rising = pairs
        .filter(|(slow, fast)| force(fast) > force(slow))
        .fold(0.0, |m: f64, (slow, _)| m.max(slow.scene.load[0]));
    let light = |run: &Vec<Solved>| inner(&run[0]);
    vec![
        Statement::ours(
            "At rest, both contact angles are the same and rise with the load from the free contact angle \
             of 40\u{b0}.",
            vec![
                Measure::rounding("largest |ai - ao|", apart, "\u{b0}", 1e-10),
                Measure::within("at 100 N", inner(&rest[0]), "\u{b0}", 40.0, 40.1),
                Measure::above("at 40 kN", inner(&rest[end]), "\u{b0}", 42.0),
                Measure::above("least step", along(rest, inner).0, "\u{b0}", 0.0),
            ],
        ),
        Statement::ours(
            "The higher the speed, the larger the inner and the smaller the outer contact angle, at every \
             load.",
            vec![
                Measure::above(
                    "least rise of ai from a speed to the next",
                    between(runs, |a, b| inner(b) - inner(a)).0,
                    "\u{b0}",
                    0.0,
                ),
                Measure::within(
                    "least fall of ao (as a change)",
                    between(runs, |a, b| outer(b) - outer(a)).1,
                    "\u{b0}",
                    -90.0,
                    0.0,
                ),
            ],
        ),
        Statement::ours(
            "At every load the inner contact force is smaller at speed than at rest. From one speed to a \
             higher one it is not always: under light loads it can be larger, by less than 2 %.",
            vec![
                Measure::within(
                    "least fall from rest",
                    from_rest.fold(f64::NEG_INFINITY, f64::max),
                    "%",
                    -100.0,
                    0.0,
                ),
                Measure::within(
                    "largest rise from a speed to the next",
                    between(at_speed, |a, b| 100.0 * (force(b) / force(a) - 1.0)).1,
                    "%",
                    0.0,
                    2.0,
                ),
                Measure::within("largest load with a rise", rising / 1e3, "kN", 0.0, 10.0),
            ],
        ),
        Statement::ours(
            "Under a light load at speed the ball lies nearly in the bottom of the outer groove, and the \
             inner contact angle comes close to 60\u{b0}.",
            vec![
                Measure::at_most(
                    "largest ao at 100 N",
                    at_speed.iter().map(|r| outer(&r[0])).fold(0.0, f64::max),
                    "\u{b0}",
                    1.0,
                ),
                Measure::within(
                    "ai at 100 N, 6,000 rpm",
                    light(&runs[1]),
                    "\u{b0}",
                    57.0,
                    60.0,
                ),
                Measure::within("15,000 rpm", light(&runs[3]), "\u{b0}", 57.0, 60.0),
            ],
        ),
        Statement::ours(
            "At speed, load brings the two angles together, and the outer one rises with it.",
            vec![
                Measure::within("largest step of ai - ao", narrowing, "\u{b0}", -90.0, 0.0),
                Measure::above("least step of ao", outer_rise, "\u{b0}", 0.0),
                Measure::within(
                    "ai - ao at 40 kN, 6,000 rpm",
                    gap(&runs[1][end]),
                    "\u{b0}",
                    0.0,
                    5.0,
                ),
                Measure::within("15,000 rpm", gap(&runs[3][end]), "\u{b0}", 10.0, 20.0),
            ],
        ),
        judged(runs.iter().flatten()),
    ]
}

/// The chapter.
///
/// # Errors
///
/// A load without a solution.
pub fn chapter(progress: &dyn Progress) -> anyhow::Result<Chapter> {
    let runs: Vec<Vec<Solved>> = SPEEDS
        .iter()
        .map(|&rpm| {
            let scenes = loads().map(|fx| Scene {
                name: "218",
                design: B218,
                balls: 16,
                attitude: Attitude::Raceless,
                load: [fx, 0.0, 0.0, 0.0, 0.0],
                rpm,
            });
            solve_all(scenes.collect(), progress)
        })
        .collect::<Result<_, _>>()?;
    let pairs = || runs.iter().zip(PENS);
    let mut angles: Vec<Curve> = pairs().map(|(r, (pen, _))| curve(pen, r, inner)).collect();
    angles.extend(pairs().skip(1).map(|(r, (_, pen))| curve(pen, r, outer)));
    let forces = pairs().map(|(r, (pen, _))| curve(pen, r, force)).collect();
    let mut legend = vec![(PENS[0].0, "at rest: ai = ao, Qi".to_owned())];
    for (rpm, (inner, outer)) in SPEEDS.iter().zip(PENS).skip(1) {
        legend.push((inner, format!("{} rpm: ai, Qi", thousands(*rpm))));
        legend.push((outer, format!("{} rpm: ao", thousands(*rpm))));
    }
    let figure = Figure {
        name: "b218_axial_load",
        title: "218 under axial load: contact angles, inner contact force".to_owned(),
        caption: format!(
            "Contact angles (solid: inner, dashed: outer) and inner contact force of the 218 against \
             axial load at four speeds. Regenerate with `{COMMAND}`."
        ),
        legend,
        columns: 2,
        panels: vec![
            panel("contact angles", "contact angle / \u{b0}", angles),
            panel("inner contact force", "Qi / N", forces),
        ],
    };
    Ok(Chapter {
        title: "The 218 under axial load",
        blocks: vec![
            Block::Text(
                "Axial load alone, 100 N to 40 kN (without any the ring floats), at rest and at 6,000, \
                 10,000 and 15,000 rpm. One ball stands for all. Raceway-control-free attitude. What the study \
                 says of these curves in words is not known; the statements are about what they show."
                    .to_owned(),
            ),
            Block::Figure(figure),
            Block::Statements(statements(&runs)),
        ],
    })
}
