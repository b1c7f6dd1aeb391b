//! Contact angles and contact forces around a B7005C under tilting moments, at rest and at speed.

use super::figure::{BLUE, Curve, Dash, Figure, INK, Marker, Panel, Pen, Plane, VERMILION};
use super::scene::{Scene, Solved, solve_all};
use super::statement::{Measure, Statement};
use super::{Block, COMMAND, Chapter, Progress, judged};
use crate::cases::B7005C;
use crate::dispatch::Attitude;
use anyhow::{Context, anyhow};
use spindle_bearing::{BallState, Design};
use spindle_bearing::{Bearing, Given, Growth, Settings, Solver, Speed};
use std::f64::consts::TAU;

const BALLS: usize = 16;
/// Azimuths at which a curve is known, per ball.
const FINE: usize = 8;
/// The moments, N m.
const MOMENTS: [f64; 5] = [-3.0, -1.5, 0.0, 1.5, 3.0];
/// Place of the one without a moment.
const LEVEL: usize = 2;
/// Shaft speed of the second half, rpm.
const FAST: f64 = 20_000.0;

/// About which axis the bearing is tilted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tilt {
    /// `Mz` on top of `Fx` and `Fy`.
    Mz,
    /// `My` on top of `Fx` and `Fz`.
    My,
    /// `My = Mz` on top of `Fx` and `Fy = Fz`.
    Both,
}

impl Tilt {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Mz, Self::My, Self::Both];

    /// The study's load with a moment of this size, N and N m.
    pub fn load(self, moment: f64) -> [f64; 5] {
        match self {
            Self::Mz => [1000.0, 200.0, 0.0, 0.0, moment],
            Self::My => [1000.0, 0.0, 200.0, moment, 0.0],
            Self::Both => [1000.0, 200.0, 200.0, moment, moment],
        }
    }

    /// Its symbol.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Mz => "Mz",
            Self::My => "My",
            Self::Both => "My = Mz",
        }
    }
}

/// A bearing, and its balls at every azimuth.
struct Curves {
    solved: Solved,
    /// States of balls at `FINE * BALLS` azimuths, from 0 on, in the ring's position.
    fine: Vec<BallState<f64>>,
}

/// A quantity of a ball.
type Of = fn(&BallState<f64>) -> f64;

const INNER_ANGLE: Of = |b| b.alpha_i.to_degrees();
const OUTER_ANGLE: Of = |b| b.alpha_o.to_degrees();
const INNER_FORCE: Of = |b| b.q_i;
const OUTER_FORCE: Of = |b| b.q_o;

impl Curves {
    /// Contact angles are functions of the azimuth for a given position of the ring, and a bearing
    /// whose balls sit between those of the first has balls there.
    fn of(solved: Solved) -> anyhow::Result<Self> {
        let mut turned = Vec::new();
        for step in 0..FINE {
            let design = Design {
                first_ball: TAU * step as f64 / (FINE * BALLS) as f64,
                ..solved.scene.design
            };
            let bearing = Bearing::<f64, BALLS>::new(&design).map_err(|e| anyhow!("{e}"))?;
            let mut solver = Solver::new(&bearing);
            let solution = solver
                .solve_at(
                    &solved.u.map(Given::Displacement),
                    Speed::rpm(solved.scene.rpm),
                    &Growth::NONE,
                    &Settings::default(),
                )
                .map_err(|e| anyhow!("{e}"))
                .context("the balls between the balls")?;
            turned.push(solution.balls().collect::<Vec<_>>());
        }
        let fine = (0..FINE * BALLS)
            .map(|i| turned[i % FINE][i / FINE])
            .collect();
        Ok(Self { solved, fine })
    }

    fn values(&self, of: Of) -> Vec<f64> {
        self.fine.iter().map(of).collect()
    }

    fn curve(&self, pen: Pen, of: Of) -> Curve {
        let points: Vec<_> = self.fine.iter().map(of).enumerate().map(at).collect();
        Curve {
            pen,
            marks: points.iter().step_by(FINE).copied().collect(),
            line: points,
        }
    }
}

fn azimuth(i: usize) -> f64 {
    TAU * i as f64 / (FINE * BALLS) as f64
}

fn at((i, value): (usize, f64)) -> (f64, f64) {
    (azimuth(i), value)
}

/// Mean, cosine and sine part of a curve, and its largest distance from the three together.
fn first_harmonic(values: &[f64]) -> ([f64; 3], f64) {
    let n = values.len() as f64;
    let part = |of: fn(f64) -> f64| {
        let sum: f64 = values
            .iter()
            .enumerate()
            .map(|(i, v)| v * of(azimuth(i)))
            .sum();
        2.0 * sum / n
    };
    let parts = [
        values.iter().sum::<f64>() / n,
        part(f64::cos),
        part(f64::sin),
    ];
    let [mean, cosine, sine] = parts;
    let rest = values.iter().enumerate().fold(0.0_f64, |m, (i, v)| {
        let wave = mean + cosine * azimuth(i).cos() + sine * azimuth(i).sin();
        m.max((v - wave).abs())
    });
    (parts, rest)
}

/// Where two curves cross: azimuth and value.
fn crossings(a: &[f64], b: &[f64]) -> Vec<(f64, f64)> {
    let n = a.len();
    let mut nodes = Vec::new();
    for i in 0..n {
        let next = (i + 1) % n;
        let (before, after) = (a[i] - b[i], a[next] - b[next]);
        if (before > 0.0) != (after > 0.0) {
            let part = before / (before - after);
            let azimuth = TAU * (i as f64 + part) / n as f64;
            nodes.push((azimuth, a[i] + part * (a[next] - a[i])));
        }
    }
    nodes
}

/// The curves of one tilt at one speed, one per moment.
struct Family {
    tilt: Tilt,
    curves: Vec<Curves>,
}

impl Family {
    /// Where the curves with a moment cross the one without: an entry per moment.
    fn nodes(&self, of: Of) -> Vec<Vec<(f64, f64)>> {
        let level = self.curves[LEVEL].values(of);
        let others = self.curves.iter().enumerate().filter(|(i, _)| *i != LEVEL);
        others
            .map(|(_, c)| crossings(&c.values(of), &level))
            .collect()
    }

    fn panel(&self, title: String, of: Of, plane: &Plane) -> Panel {
        Panel {
            title,
            plane: plane.clone(),
            curves: self
                .curves
                .iter()
                .zip(PENS)
                .map(|(c, pen)| c.curve(pen, of))
                .collect(),
            nodes: self.nodes(of).concat(),
        }
    }
}

/// One a moment.
const PENS: [Pen; 5] = [
    Pen(BLUE, Dash::Solid, Marker::Square),
    Pen(BLUE, Dash::Long, Marker::Ring),
    Pen(INK, Dash::Dots, Marker::Cross),
    Pen(VERMILION, Dash::Long, Marker::Disc),
    Pen(VERMILION, Dash::Solid, Marker::Triangle),
];

fn family(tilt: Tilt, rpm: f64, progress: &dyn Progress) -> anyhow::Result<Family> {
    let scenes = MOMENTS.map(|moment| Scene {
        name: "B7005C",
        design: B7005C,
        balls: BALLS,
        attitude: Attitude::Raceless,
        load: tilt.load(moment),
        rpm,
    });
    let solved = solve_all(scenes.into(), progress)?;
    let curves = solved
        .into_iter()
        .map(Curves::of)
        .collect::<Result<_, _>>()?;
    Ok(Family { tilt, curves })
}

/// Those of every tilt, in their order.
fn families(rpm: f64, progress: &dyn Progress) -> anyhow::Result<[Family; 3]> {
    let [mz, my, both] = Tilt::ALL.map(|tilt| family(tilt, rpm, progress));
    Ok([mz?, my?, both?])
}

/// Distance of two azimuths, degrees.
fn apart(a: f64, b: f64) -> f64 {
    let turn = (a - b).rem_euclid(TAU);
    turn.min(TAU - turn).to_degrees()
}

/// The largest distance of two nodes that belong together, degrees: each node of the first moment and, of
/// every other, the one next to it. Infinite if the curves have not two each.
fn spread(nodes: &[Vec<(f64, f64)>]) -> f64 {
    if nodes.iter().any(|n| n.len() != 2) {
        return f64::INFINITY;
    }
    let next_to = |nodes: &[(f64, f64)], place: f64| {
        let azimuths = nodes.iter().map(|(azimuth, _)| *azimuth);
        azimuths.min_by(|a, b| apart(*a, place).total_cmp(&apart(*b, place)))
    };
    let mut worst: f64 = 0.0;
    for (place, _) in &nodes[0] {
        let together: Vec<f64> = nodes.iter().filter_map(|n| next_to(n, *place)).collect();
        for a in &together {
            worst = together.iter().fold(worst, |m, b| m.max(apart(*a, *b)));
        }
    }
    worst
}

/// The largest distance of the nodes of one family from those of another, degrees.
fn moved(from: &[Vec<(f64, f64)>], to: &[Vec<(f64, f64)>]) -> f64 {
    from.iter()
        .zip(to)
        .fold(0.0, |m, (a, b)| m.max(spread(&[a.clone(), b.clone()])))
}

/// Numbers of nodes of the curves, sorted.
fn counts(nodes: &[Vec<(f64, f64)>]) -> Vec<usize> {
    let mut counts: Vec<usize> = nodes.iter().map(Vec::len).collect();
    counts.sort_unstable();
    counts
}

fn legend() -> Vec<(Pen, String)> {
    let moments = PENS.iter().zip(MOMENTS);
    let mut legend: Vec<_> = moments
        .map(|(pen, m)| (*pen, format!("{}{} N m", if m > 0.0 { "+" } else { "" }, m)))
        .collect();
    legend.push((Pen(INK, Dash::None, Marker::Ring), "node".to_owned()));
    legend
}

const ANGLES: Plane = Plane::Around {
    centre: 0.0,
    rim: 30.0,
    step: 10.0,
};
const FORCES: Plane = Plane::Around {
    centre: 50.0,
    rim: 250.0,
    step: 50.0,
};

fn figure(
    name: &'static str,
    title: &str,
    caption: &str,
    families: &[Family],
    rows: &[(&str, Of)],
    plane: &Plane,
) -> Figure {
    let panels = rows.iter().flat_map(|(row, of)| {
        families
            .iter()
            .map(move |f| f.panel(format!("{row}: {}", f.tilt.symbol()), *of, plane))
    });
    Figure {
        name,
        title: format!("B7005C, Fx = 1000 N, 200 N radial: {title}"),
        caption: format!(
            "{caption} Curves: any azimuth; markers: the 16 balls; rings: where a curve with a moment \
             crosses the one without. Regenerate with `{COMMAND}`."
        ),
        legend: legend(),
        columns: 3,
        panels: panels.collect(),
    }
}

/// The bearing under `Mz` = 3 N m, at rest and at speed.
fn rest_and_speed(rest: &Family, fast: &Family) -> Figure {
    let pens = [
        Pen(INK, Dash::Dots, Marker::Cross),
        Pen(VERMILION, Dash::Solid, Marker::Triangle),
        Pen(BLUE, Dash::Long, Marker::Square),
    ];
    let last = MOMENTS.len() - 1;
    let panel = |title: &str, inner: Of, outer: Of, plane: &Plane| Panel {
        title: title.to_owned(),
        plane: plane.clone(),
        curves: vec![
            rest.curves[last].curve(pens[0], inner),
            fast.curves[last].curve(pens[1], inner),
            fast.curves[last].curve(pens[2], outer),
        ],
        nodes: Vec::new(),
    };
    let names = [
        "at rest, inner and outer",
        "20,000 rpm, inner",
        "20,000 rpm, outer",
    ];
    Figure {
        name: "rest_and_speed",
        title: "B7005C, Fx = 1000 N, Fy = 200 N, Mz = 3 N m: at rest and at 20,000 rpm".to_owned(),
        caption: format!(
            "Contact angles and contact forces under `Mz` = 3 N m, at rest and at 20,000 rpm; the \
             centre is 0\u{b0} and 50 N. Regenerate with `{COMMAND}`."
        ),
        legend: pens
            .iter()
            .zip(names)
            .map(|(p, n)| (*p, n.to_owned()))
            .collect(),
        columns: 2,
        panels: vec![
            panel("contact angles / \u{b0}", INNER_ANGLE, OUTER_ANGLE, &ANGLES),
            panel("contact forces / N", INNER_FORCE, OUTER_FORCE, &FORCES),
        ],
    }
}

/// A range of values, for a measure's label.
fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    })
}

/// Largest part of a curve that is no first harmonic, and its part a quarter turn off, over its
/// amplitude; worst of the moments, %.
fn impurity(family: &Family, quarter: usize) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    for curves in &family.curves {
        let (parts, rest) = first_harmonic(&curves.values(INNER_ANGLE));
        let main = parts[3 - quarter].abs();
        worst[0] = worst[0].max(100.0 * rest / main);
        worst[1] = worst[1].max(parts[quarter].abs() / main);
    }
    worst
}

fn at_rest(families: &[Family; 3]) -> Vec<Statement> {
    let [mz, my, both] = families;
    let all = || families.iter().flat_map(|f| &f.curves);
    let apart = all()
        .flat_map(|c| &c.fine)
        .fold(0.0_f64, |m, b| m.max((b.alpha_i - b.alpha_o).abs()));
    let amplitudes = |f: &Family, part: usize| -> Vec<f64> {
        let curves = f.curves.iter();
        curves
            .map(|c| first_harmonic(&c.values(INNER_ANGLE)).0[part])
            .collect()
    };
    let (cosine, sine) = (amplitudes(mz, 1), amplitudes(my, 2));
    let [cosine_rest, cosine_turned] = impurity(mz, 2);
    let [sine_rest, sine_turned] = impurity(my, 1);
    let step = |a: &[f64], i: usize| (a[i] - a[LEVEL]).abs();
    let turned = |a: &[f64]| (a[4] - a[LEVEL]) / (a[0] - a[LEVEL]);
    let nodes = |f: &Family| spread(&f.nodes(INNER_ANGLE));
    let numbers: Vec<Vec<usize>> = families
        .iter()
        .map(|f| counts(&f.nodes(INNER_FORCE)))
        .collect();
    let alone = numbers[..2].iter().filter(|n| **n == [2, 4, 4, 4]).count();
    let together = usize::from(numbers[2] == [4, 4, 4, 4]);

    vec![
        Statement::of(
            "item 1",
            "At rest, inner and outer contact angles are the same.",
            vec![Measure::rounding(
                "largest |ai - ao|, any load, any azimuth",
                apart,
                "rad",
                1e-12,
            )],
        ),
        Statement::of(
            "item 1",
            "At rest, under `Mz` with `Fy`, the contact angle is a cosine-like curve of the azimuth.",
            vec![
                Measure::at_most(
                    "largest part that is no first harmonic, over the amplitude",
                    cosine_rest,
                    "%",
                    15.0,
                ),
                Measure::rounding("sine part over cosine part", cosine_turned, "", 1e-9),
            ],
        ),
        Statement::of(
            "item 1",
            "Its amplitude grows with `Mz`.",
            vec![
                Measure::above("amplitude at 0", cosine[2].abs(), "\u{b0}", 0.0),
                Measure::above("at 1.5 N m", cosine[3].abs(), "\u{b0}", cosine[2].abs()),
                Measure::above("at 3 N m", cosine[4].abs(), "\u{b0}", cosine[3].abs()),
            ],
        ),
        Statement::of(
            "item 1",
            "With `-Mz` the deviation turns over.",
            vec![
                Measure::within(
                    "deviation of +3 N m over that of -3 N m",
                    turned(&cosine),
                    "",
                    -1.25,
                    -0.8,
                ),
                Measure::above(
                    "amplitude of the deviation at -1.5 N m",
                    step(&cosine, 1),
                    "\u{b0}",
                    0.0,
                ),
                Measure::above("at -3 N m", step(&cosine, 0), "\u{b0}", step(&cosine, 1)),
            ],
        ),
        Statement::of(
            "item 1",
            "Under `My` with `Fz` it is a sine-like curve.",
            vec![
                Measure::at_most(
                    "largest part that is no first harmonic, over the amplitude",
                    sine_rest,
                    "%",
                    15.0,
                ),
                Measure::rounding("cosine part over sine part", sine_turned, "", 1e-9),
                Measure::within(
                    "deviation of +3 N m over that of -3 N m",
                    turned(&sine),
                    "",
                    -1.25,
                    -0.8,
                ),
            ],
        ),
        Statement::ours(
            "At rest, the curves of contact angle of all moments pass through the same two nodes, nearly: \
             each crosses the curve without a moment twice, at places that shift by some degrees.",
            vec![
                Measure::within("spread of a node, `Mz`", nodes(mz), "\u{b0}", 1.0, 20.0),
                Measure::within("`My`", nodes(my), "\u{b0}", 1.0, 20.0),
                Measure::within("both", nodes(both), "\u{b0}", 1.0, 20.0),
            ],
        ),
        Statement::ours(
            "At rest, the curves of contact force have no such nodes in common: they cross the curve without a \
             moment four times, but for one moment of `Mz` and one of `My`, which do twice.",
            vec![
                Measure::count(
                    "`Mz` and `My`: families with one curve of 2 nodes and three of 4",
                    alone,
                    2,
                ),
                Measure::count("both: families with four curves of 4", together, 1),
            ],
        ),
    ]
}

fn at_speed(rest: &[Family], fast: &[Family]) -> Vec<Statement> {
    let shift = |of: Of| {
        let pairs = rest.iter().zip(fast);
        pairs.fold(0.0, |m: f64, (r, f)| {
            m.max(moved(&r.nodes(of), &f.nodes(of)))
        })
    };
    let pairs = || {
        rest.iter()
            .zip(fast)
            .flat_map(|(r, f)| r.curves.iter().zip(&f.curves))
            .flat_map(|(r, f)| r.fine.iter().zip(&f.fine))
    };
    let changes = |of: Of| extremes(pairs().map(|(r, f)| of(f) - of(r)));
    let claim = |text: &str, of: Of, unit, rises: bool| {
        let (least, most) = changes(of);
        let measures = if rises {
            vec![
                Measure::above("least change", least, unit, 0.0),
                Measure::above("largest", most, unit, least),
            ]
        } else {
            vec![
                Measure::below("least change", most, unit, 0.0),
                Measure::at_most("largest", least, unit, most),
            ]
        };
        Statement::of("item 2", text, measures)
    };
    vec![
        claim(
            "At 20,000 rpm the inner contact angle is larger than at rest, at every azimuth, under all \
             15 loads.",
            INNER_ANGLE,
            "\u{b0}",
            true,
        ),
        claim(
            "The outer contact angle is smaller.",
            OUTER_ANGLE,
            "\u{b0}",
            false,
        ),
        claim(
            "The inner contact force is smaller.",
            INNER_FORCE,
            "N",
            false,
        ),
        claim("The outer contact force is larger.", OUTER_FORCE, "N", true),
        Statement::ours(
            "The nodes of the contact angles stay nearly where they are at rest.",
            vec![
                Measure::within(
                    "largest shift, inner",
                    shift(INNER_ANGLE),
                    "\u{b0}",
                    0.0,
                    5.0,
                ),
                Measure::within("outer", shift(OUTER_ANGLE), "\u{b0}", 0.0, 5.0),
            ],
        ),
    ]
}

/// The chapter.
///
/// # Errors
///
/// A load without a solution.
pub fn chapter(progress: &dyn Progress) -> anyhow::Result<Chapter> {
    let rest = families(0.0, progress)?;
    let fast = families(FAST, progress)?;
    let solved = || {
        let families = rest.iter().chain(&fast);
        families.flat_map(|f| f.curves.iter().map(|c| &c.solved))
    };
    let blocks = vec![
        Block::Text(
            "Loads: `Fx` = 1000 N with `Fy` = 200 N and `Mz`; with `Fz` = 200 N and `My`; with \
             `Fy = Fz` = 200 N and `My = Mz`; each with moments of -3, -1.5, 0, 1.5, 3 N m. \
             Raceway-control-free attitude."
                .to_owned(),
        ),
        Block::Figure(figure(
            "contact_angles_at_rest",
            "contact angle at rest",
            "Contact angle at rest (inner and outer are the same).",
            &rest,
            &[("ai = ao / \u{b0}", INNER_ANGLE)],
            &ANGLES,
        )),
        Block::Figure(figure(
            "contact_forces_at_rest",
            "contact force at rest",
            "Contact force at rest (inner and outer are the same); the centre is 50 N.",
            &rest,
            &[("Qi = Qo / N", INNER_FORCE)],
            &FORCES,
        )),
        Block::Statements(at_rest(&rest)),
        Block::Figure(figure(
            "contact_angles_at_speed",
            "contact angles at 20,000 rpm",
            "Inner (upper row) and outer (lower row) contact angle at 20,000 rpm.",
            &fast,
            &[
                ("inner, ai / \u{b0}", INNER_ANGLE),
                ("outer, ao / \u{b0}", OUTER_ANGLE),
            ],
            &ANGLES,
        )),
        Block::Figure(figure(
            "contact_forces_at_speed",
            "contact forces at 20,000 rpm",
            "Inner (upper row) and outer (lower row) contact force at 20,000 rpm; the centre is 50 N.",
            &fast,
            &[
                ("inner, Qi / N", INNER_FORCE),
                ("outer, Qo / N", OUTER_FORCE),
            ],
            &FORCES,
        )),
        Block::Figure(rest_and_speed(&rest[0], &fast[0])),
        Block::Statements(at_speed(&rest, &fast)),
        Block::Statements(vec![judged(solved())]),
    ];
    Ok(Chapter {
        title: "Contact angles and forces around the bearing",
        blocks,
    })
}
