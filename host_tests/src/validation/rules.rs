//! The 218 at speed: a third party's table, the three attitude rules, and the wrong sign of the
//! gyroscopic moment.

use super::figure::{
    Axis, BLUE, Curve, Dash, Figure, GREEN, INK, Marker, PURPLE, Panel, Pen, Plane, VERMILION,
};
use super::scene::{Scene, Solved, evenly, solve_all};
use super::statement::{Measure, Statement, shown, with_digits};
use super::{Block, COMMAND, Chapter, Progress, Table, judged};
use crate::cases::{self, B218, rad_per_s};
use crate::compare::worse;
use crate::dispatch::Attitude;
use crate::reference::{self, Reference};
use anyhow::Context;
use rayon::prelude::*;

const LOAD: [f64; 5] = [17_800.0, 0.0, 0.0, 0.0, 0.0];
const TOP: f64 = 15_000.0;
const STEPS: usize = 30;

/// What a third party's program printed (outer race control, contact constants by Brewe and Hamrock):
/// rpm; dx in mm, ai and ao in degrees, Qi and Qo in N.
pub const TABLE: [(f64, [f64; 5]); 4] = [
    (3_000.0, [0.035742, 42.3206, 40.6541, 1652.36, 1691.64]),
    (6_000.0, [0.032959, 44.7375, 38.0135, 1580.57, 1738.81]),
    (10_000.0, [0.014552, 49.9991, 31.2627, 1452.29, 1924.16]),
    (15_000.0, [-0.048691, 56.8286, 19.1170, 1329.09, 2726.81]),
];

/// A row of that table from somewhere else.
type Row = [f64; 5];

/// The largest differences from the table: of displacement (um), of angles (degrees), of
/// forces (relative).
fn differences(rows: &[Row]) -> [f64; 3] {
    let mut worst = [0.0; 3];
    for (row, (_, theirs)) in rows.iter().zip(TABLE) {
        worst[0] = worse(worst[0], 1e3 * (row[0] - theirs[0]).abs());
        for i in [1, 2] {
            worst[1] = worse(worst[1], (row[i] - theirs[i]).abs());
        }
        for i in [3, 4] {
            worst[2] = worse(worst[2], (row[i] / theirs[i] - 1.0).abs());
        }
    }
    worst
}

fn scene(attitude: Attitude, rpm: f64) -> Scene {
    Scene {
        name: "218",
        design: B218,
        balls: 16,
        attitude,
        load: LOAD,
        rpm,
    }
}

fn row(u: f64, ball: &crate::compare::Ball) -> Row {
    [
        1e3 * u,
        ball.inner.angle.to_degrees(),
        ball.outer.angle.to_degrees(),
        ball.inner.force,
        ball.outer.force,
    ]
}

/// What a variant of the reference build says of the 218 at a speed.
fn by_variant(
    variant: &Reference,
    attitude: reference::Attitude,
    rpm: f64,
) -> anyhow::Result<reference::Solution> {
    variant
        .search(LOAD, rad_per_s(rpm), attitude)
        .with_context(|| format!("a variant of the reference build, {attitude:?}, at {rpm} rpm"))
}

/// The table's rows as a rule gives them.
pub fn rows_of_table(
    attitude: Attitude,
    progress: &dyn Progress,
) -> anyhow::Result<Vec<(Row, Solved)>> {
    let scenes = TABLE.map(|(rpm, _)| scene(attitude, rpm));
    let solved = solve_all(scenes.into(), progress)?;
    Ok(solved
        .into_iter()
        .map(|s| (row(s.u[0], &(&s.balls[0]).into()), s))
        .collect())
}

/// Whether rows are the table's, but for what contact constants explain.
pub fn reproduces_the_table(rows: &[Row]) -> Statement {
    let [displacement, angle, force] = differences(rows);
    Statement::ours(
        "The third party's table is reproduced, with outer race control.",
        vec![
            Measure::at_most(
                "largest difference of a contact angle",
                angle,
                "\u{b0}",
                0.02,
            ),
            Measure::at_most("of a contact force", 100.0 * force, "%", 0.02),
            Measure::at_most("of the displacement", displacement, "\u{b5}m", 0.15),
        ],
    )
}

fn third_party(progress: &dyn Progress) -> anyhow::Result<Vec<Block>> {
    let ours = rows_of_table(Attitude::Outer, progress)?;
    let fitted = cases::reference(&B218, 16).with_fitted_contacts();
    let fitted: Vec<Row> = TABLE
        .iter()
        .map(|(rpm, _)| {
            let s = by_variant(&fitted, reference::Attitude::Outer, *rpm)?;
            Ok(row(s.u[0], &(&s.balls[0]).into()))
        })
        .collect::<anyhow::Result<_>>()?;
    let (rows, solved): (Vec<Row>, Vec<Solved>) = ours.into_iter().unzip();
    let [displacement, angle, force] = differences(&rows);
    let [fitted_displacement, fitted_angle, fitted_force] = differences(&fitted);
    let mut lines = Vec::new();
    for (((rpm, theirs), ours), fitted) in TABLE.iter().zip(&rows).zip(&fitted) {
        for (who, row) in [
            ("third party", theirs),
            ("this solver", ours),
            ("reference build with fits", fitted),
        ] {
            let digits = [6, 4, 4, 2, 2];
            let mut line = vec![shown(*rpm), who.to_owned()];
            line.extend(row.iter().zip(digits).map(|(v, d)| format!("{v:.d$}")));
            lines.push(line);
        }
        let mut line = vec![shown(*rpm), "solver less third party".to_owned()];
        let decimals = [6, 4, 4, 2, 2];
        line.extend((0..5).map(|i| format!("{:+.*}", decimals[i], ours[i] - theirs[i])));
        lines.push(line);
    }
    let table = Table {
        caption: "The 218 under 17,800 N of axial load with outer race control.".to_owned(),
        head: [
            "rpm",
            "by",
            "dx / mm",
            "ai / \u{b0}",
            "ao / \u{b0}",
            "Qi / N",
            "Qo / N",
        ]
        .map(str::to_owned)
        .into(),
        rows: lines,
    };
    Ok(vec![
        Block::Table(table),
        Block::Statements(vec![
            reproduces_the_table(&rows),
            Statement::ours(
                "Part of what is left comes from the third party's contact constants: given the fits of \
                 Brewe and Hamrock (1977), the reference build comes closer to the table, though not onto it.",
                vec![
                    Measure::within(
                        "largest difference of a contact angle",
                        fitted_angle,
                        "\u{b0}",
                        0.0,
                        angle,
                    ),
                    Measure::within(
                        "of a contact force",
                        100.0 * fitted_force,
                        "%",
                        0.0,
                        100.0 * force,
                    ),
                    Measure::within(
                        "of the displacement",
                        fitted_displacement,
                        "\u{b5}m",
                        0.0,
                        displacement,
                    ),
                ],
            ),
            judged(&solved),
        ]),
    ])
}

/// One rule over the speeds.
struct Run {
    name: &'static str,
    pen: (Pen, Pen),
    /// Speed, rpm; ai, ao in degrees; Qi, Qo in N; Kxx in N/um.
    points: Vec<[f64; 6]>,
}

impl Run {
    fn curve(&self, pen: Pen, column: usize, first: usize) -> Curve {
        let points = self.points.iter().map(|p| (p[0] / 1e3, p[column]));
        Curve::through(pen, points.collect(), first, 5)
    }

    fn at(&self, rpm: f64) -> &[f64; 6] {
        let points = self.points.iter();
        points
            .min_by(|a, b| (a[0] - rpm).abs().total_cmp(&(b[0] - rpm).abs()))
            .unwrap_or(&[f64::NAN; 6])
    }
}

fn point(rpm: f64, ball: &crate::compare::Ball, k: f64) -> [f64; 6] {
    [
        rpm,
        ball.inner.angle.to_degrees(),
        ball.outer.angle.to_degrees(),
        ball.inner.force,
        ball.outer.force,
        1e-6 * k,
    ]
}

const OUTER: usize = 0;
const FREE: usize = 1;
const INNER: usize = 2;
const WRONG_OUTER: usize = 3;
const WRONG_FREE: usize = 4;

fn runs(progress: &dyn Progress) -> anyhow::Result<(Vec<Run>, Vec<Solved>)> {
    let speeds = evenly(0.0, TOP, STEPS);
    let pens = |colour, marker| {
        (
            Pen(colour, Dash::Solid, marker),
            Pen(colour, Dash::Long, marker),
        )
    };
    let rules = [
        (
            "outer race control",
            Attitude::Outer,
            pens(BLUE, Marker::Square),
        ),
        (
            "raceway-control-free",
            Attitude::Raceless,
            pens(INK, Marker::Disc),
        ),
        (
            "inner race control",
            Attitude::Inner,
            pens(GREEN, Marker::Triangle),
        ),
    ];
    let mut runs = Vec::new();
    let mut all = Vec::new();
    for (name, attitude, pen) in rules {
        let scenes = speeds.iter().map(|&rpm| scene(attitude, rpm)).collect();
        let solved = solve_all(scenes, progress)?;
        let points = solved
            .iter()
            .map(|s| point(s.scene.rpm, &(&s.balls[0]).into(), s.k[0][0]))
            .collect();
        runs.push(Run { name, pen, points });
        all.extend(solved);
    }
    let reversed = cases::reference(&B218, 16).with_gyroscopic_moment_reversed();
    for (name, attitude, colour, marker) in [
        (
            "wrong sign, outer race control",
            reference::Attitude::Outer,
            VERMILION,
            Marker::Cross,
        ),
        (
            "wrong sign, raceway-control-free",
            reference::Attitude::Raceless,
            PURPLE,
            Marker::Ring,
        ),
    ] {
        progress.expect(speeds.len());
        let points = speeds
            .par_iter()
            .map(|&rpm| {
                let s = by_variant(&reversed, attitude, rpm)?;
                progress.done(1);
                Ok(point(rpm, &(&s.balls[0]).into(), s.k[0][0]))
            })
            .collect::<anyhow::Result<_>>()?;
        let pen = (
            Pen(colour, Dash::Short, marker),
            Pen(colour, Dash::Dots, marker),
        );
        runs.push(Run { name, pen, points });
    }
    Ok((runs, all))
}

fn side_by_side(progress: &dyn Progress) -> anyhow::Result<Vec<Block>> {
    let (runs, solved) = runs(progress)?;
    let panel = |title: &str, y: &str, column: usize| Panel {
        title: title.to_owned(),
        plane: Plane::Straight {
            x: Axis::from_zero("speed / 1000 rpm"),
            y: if column == 5 {
                Axis::from_zero(y)
            } else {
                Axis::new(y)
            },
        },
        curves: runs
            .iter()
            .enumerate()
            .map(|(i, r)| r.curve(r.pen.0, column, i))
            .collect(),
        nodes: Vec::new(),
    };
    let figure = Figure {
        name: "attitude_rules",
        title: "218, Fx = 17,800 N: attitude rules, and the wrong sign of the gyroscopic moment"
            .to_owned(),
        caption: format!(
            "The three attitude rules side by side, and what a gyroscopic moment of the wrong sign makes of \
             two of them (reference build only; the solver has no such variant). \
             Regenerate with `{COMMAND}`."
        ),
        legend: runs.iter().map(|r| (r.pen.0, r.name.to_owned())).collect(),
        columns: 2,
        panels: vec![
            panel("inner contact angle", "ai / \u{b0}", 1),
            panel("outer contact angle", "ao / \u{b0}", 2),
            panel("inner contact force", "Qi / N", 3),
            panel("axial stiffness", "Kxx / (N/\u{b5}m)", 5),
        ],
    };
    let mut rows = Vec::new();
    for rpm in [3_000.0, 6_000.0, 10_000.0, 15_000.0] {
        for run in &runs {
            let p = run.at(rpm);
            rows.push(vec![
                shown(rpm),
                run.name.to_owned(),
                format!("{:.3}", p[1]),
                format!("{:.3}", p[2]),
                format!("{:.1}", p[3]),
                format!("{:.1}", p[4]),
                with_digits(p[5], 4),
            ]);
        }
    }
    let table = Table {
        caption: "The 218 under 17,800 N of axial load by rule.".to_owned(),
        head: [
            "rpm",
            "rule",
            "ai / \u{b0}",
            "ao / \u{b0}",
            "Qi / N",
            "Qo / N",
            "Kxx / (N/\u{b5}m)",
        ]
        .map(str::to_owned)
        .into(),
        rows,
    };
    let at = |run: usize, column: usize| runs[run].at(10_000.0)[column];
    let fast = |run: usize, column: usize| runs[run].at(15_000.0)[column];
    // The first speeds are too slow for the rules to differ by more than rounding.
    let pairs = |a: usize, b: usize, column: usize| {
        let pairs = runs[a].points.iter().zip(&runs[b].points).skip(1);
        pairs
            .map(|(a, b)| a[column] - b[column])
            .fold(f64::INFINITY, f64::min)
    };
    let statements = vec![
        Statement::ours(
            "With the right sign, the gyroscopic moment drives the contact angles apart, most with outer \
             race control and least with inner race control.",
            vec![
                Measure::above(
                    "ai - ao at 10,000 rpm, outer",
                    at(OUTER, 1) - at(OUTER, 2),
                    "\u{b0}",
                    at(FREE, 1) - at(FREE, 2),
                ),
                Measure::above(
                    "free",
                    at(FREE, 1) - at(FREE, 2),
                    "\u{b0}",
                    at(INNER, 1) - at(INNER, 2),
                ),
                Measure::above(
                    "inner",
                    at(INNER, 1) - at(INNER, 2),
                    "\u{b0}",
                    at(WRONG_OUTER, 1) - at(WRONG_OUTER, 2),
                ),
                Measure::above(
                    "outer, wrong sign",
                    at(WRONG_OUTER, 1) - at(WRONG_OUTER, 2),
                    "\u{b0}",
                    0.0,
                ),
            ],
        ),
        Statement::ours(
            "With the wrong sign the axial stiffness at 10,000 rpm under outer race control is twice as \
             large.",
            vec![
                Measure::within("`Kxx`", at(OUTER, 5), "N/\u{b5}m", 280.0, 295.0),
                Measure::within(
                    "`Kxx`, wrong sign",
                    at(WRONG_OUTER, 5),
                    "N/\u{b5}m",
                    580.0,
                    600.0,
                ),
                Measure::within("ratio", at(WRONG_OUTER, 5) / at(OUTER, 5), "", 1.95, 2.15),
            ],
        ),
        Statement::ours(
            "The wrong sign makes the outer contact angle and the axial stiffness too large at every speed, with \
             either rule.",
            vec![
                Measure::above(
                    "least difference of ao, outer",
                    pairs(WRONG_OUTER, OUTER, 2),
                    "\u{b0}",
                    0.0,
                ),
                Measure::above("free", pairs(WRONG_FREE, FREE, 2), "\u{b0}", 0.0),
                Measure::above(
                    "least difference of `Kxx`, outer",
                    pairs(WRONG_OUTER, OUTER, 5),
                    "N/\u{b5}m",
                    0.0,
                ),
                Measure::above("free", pairs(WRONG_FREE, FREE, 5), "N/\u{b5}m", 0.0),
            ],
        ),
        Statement::ours(
            "The rule matters, too: at 10,000 rpm the axial stiffness without race control lies between \
             those with outer and with inner race control, at 15,000 rpm below both.",
            vec![
                Measure::within(
                    "free over outer, 10,000 rpm",
                    at(FREE, 5) / at(OUTER, 5),
                    "",
                    1.0,
                    at(INNER, 5) / at(OUTER, 5),
                ),
                Measure::above("inner over outer", at(INNER, 5) / at(OUTER, 5), "", 1.0),
                Measure::within(
                    "free over outer, 15,000 rpm",
                    fast(FREE, 5) / fast(OUTER, 5),
                    "",
                    0.9,
                    1.0,
                ),
                Measure::above("inner over outer", fast(INNER, 5) / fast(OUTER, 5), "", 1.0),
            ],
        ),
        judged(&solved),
    ];
    Ok(vec![
        Block::Figure(figure),
        Block::Table(table),
        Block::Statements(statements),
    ])
}

/// The chapter.
///
/// # Errors
///
/// A rule without a solution.
pub fn chapter(progress: &dyn Progress) -> anyhow::Result<Chapter> {
    let mut blocks = vec![Block::Text(
        "16 balls, 17,800 N of axial load; one ball stands for all. The third party's program uses outer race \
         control and takes its contact constants from fits after Brewe and Hamrock; which version of them is \
         not known."
            .to_owned(),
    )];
    blocks.extend(third_party(progress)?);
    blocks.extend(side_by_side(progress)?);
    Ok(Chapter {
        title: "Against others: a third party's table, the attitude rules, the wrong sign",
        blocks,
    })
}
