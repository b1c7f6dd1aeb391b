//! The exact tangent against one that freezes inertia loads and friction forces.

use super::figure::{
    Axis, BLUE, Curve, Dash, Figure, GREEN, INK, Marker, Panel, Pen, Plane, VERMILION,
};
use super::scene::{Scene, Solved, evenly, solve_all};
use super::statement::{Measure, Statement, shown, with_digits};
use super::{Block, COMMAND, Chapter, Progress, Table, judged};
use crate::cases::{self, B218, B7005C};
use crate::compare::{stiffness_error, worse};
use crate::dispatch::{self, Attitude, Precision};
use crate::reference;
use anyhow::{Context, anyhow};
use spindle_bearing::Design;

/// A bearing, its load and a rule.
struct Series {
    name: &'static str,
    bearing: &'static str,
    design: Design,
    load: [f64; 5],
    top: f64,
    attitude: Attitude,
    pen: Pen,
}

const STEPS: usize = 30;
const B218_LOAD: [f64; 5] = [17_800.0, 0.0, 0.0, 0.0, 0.0];
/// Relative step of the load, of the differences that judge.
const STEP: f64 = 1e-4;

const SERIES: [Series; 4] = [
    Series {
        name: "218, outer race control",
        bearing: "218",
        design: B218,
        load: B218_LOAD,
        top: 15_000.0,
        attitude: Attitude::Outer,
        pen: Pen(BLUE, Dash::Long, Marker::Square),
    },
    Series {
        name: "218, raceway-control-free",
        bearing: "218",
        design: B218,
        load: B218_LOAD,
        top: 15_000.0,
        attitude: Attitude::Raceless,
        pen: Pen(INK, Dash::Solid, Marker::Disc),
    },
    Series {
        name: "218, inner race control",
        bearing: "218",
        design: B218,
        load: B218_LOAD,
        top: 15_000.0,
        attitude: Attitude::Inner,
        pen: Pen(GREEN, Dash::Short, Marker::Triangle),
    },
    Series {
        name: "B7005C, Mz = 3 N m, raceway-control-free",
        bearing: "B7005C",
        design: B7005C,
        load: [1000.0, 200.0, 0.0, 0.0, 3.0],
        top: 20_000.0,
        attitude: Attitude::Raceless,
        pen: Pen(VERMILION, Dash::Solid, Marker::Cross),
    },
];

/// A point: the exact stiffness and the frozen one.
struct Pair {
    solved: Solved,
    frozen: [[f64; 5]; 5],
}

impl Pair {
    fn of(solved: Solved) -> anyhow::Result<Self> {
        let scene = &solved.scene;
        let reference = cases::reference(&scene.design, scene.balls);
        let balls: Vec<_> = solved
            .balls
            .iter()
            .map(|b| reference::BallState {
                azimuth: b.azimuth,
                alpha_i: b.alpha_i,
                alpha_o: b.alpha_o,
                q_i: b.q_i,
                q_o: b.q_o,
                delta_i: b.delta_i,
                delta_o: b.delta_o,
                fc: b.centrifugal_force,
                mg: b.gyroscopic_moment,
            })
            .collect();
        let frozen = reference
            .frozen_stiffness(&balls, solved.omega(), scene.attitude.into())
            .context("the frozen tangent")?;
        Ok(Self { solved, frozen })
    }

    /// Error of the frozen stiffness, in units of the diagonal, %.
    fn error(&self) -> f64 {
        100.0 * stiffness_error(&self.frozen, &self.solved.k)
    }

    fn error_of(&self, i: usize) -> f64 {
        100.0 * (self.frozen[i][i] / self.solved.k[i][i] - 1.0)
    }
}

/// `d Fx / d dx` of a purely axial load by central differences of solved displacements, extrapolated
/// after Richardson.
fn differenced(scene: &Scene) -> anyhow::Result<f64> {
    let bearing = dispatch::bearing(&scene.design, scene.balls, Precision::F64)
        .map_err(|e| anyhow!("{e}"))?;
    let mut solver = bearing.solver(scene.attitude);
    let omega = cases::rad_per_s(scene.rpm);
    let mut at = |change: f64| {
        let mut load = scene.load;
        load[0] *= 1.0 + change;
        let figures = solver.solve(load, omega).figures;
        figures
            .map(|f| f.displacement[0])
            .map_err(|why| anyhow!("{why}"))
    };
    let mut compliance =
        |h: f64| Ok::<_, anyhow::Error>((at(h)? - at(-h)?) / (2.0 * h * scene.load[0]));
    let (wide, narrow) = (compliance(STEP)?, compliance(0.5 * STEP)?);
    Ok(3.0 / (4.0 * narrow - wide))
}

/// The chapter.
///
/// # Errors
///
/// A speed without a solution.
pub fn chapter(progress: &dyn Progress) -> anyhow::Result<Chapter> {
    let mut all: Vec<Vec<Pair>> = Vec::new();
    for series in &SERIES {
        let scenes = evenly(0.0, series.top, STEPS).into_iter().map(|rpm| Scene {
            name: series.bearing,
            design: series.design,
            balls: 16,
            attitude: series.attitude,
            load: series.load,
            rpm,
        });
        let solved = solve_all(scenes.collect(), progress)?;
        all.push(solved.into_iter().map(Pair::of).collect::<Result<_, _>>()?);
    }
    let panel = |title: &str, y: &str, zero, of: &dyn Fn(&Pair) -> f64| Panel {
        title: title.to_owned(),
        plane: Plane::Straight {
            x: Axis::from_zero("speed / 1000 rpm"),
            y: if zero {
                Axis::from_zero(y)
            } else {
                Axis::new(y)
            },
        },
        curves: all
            .iter()
            .zip(&SERIES)
            .enumerate()
            .map(|(i, (pairs, series))| {
                let points = pairs.iter().map(|p| (p.solved.scene.rpm / 1e3, of(p)));
                Curve::through(series.pen, points.collect(), i, 6)
            })
            .collect(),
        nodes: Vec::new(),
    };
    let figure = Figure {
        name: "frozen_tangent",
        title: "Stiffness without the derivatives of inertia loads and friction: its error"
            .to_owned(),
        caption: format!(
            "Error of a stiffness that leaves out the derivatives of centrifugal forces, gyroscopic \
             moments and friction shares: of the worst element over the root of its two diagonal elements, \
             and of the axial stiffness. Regenerate with `{COMMAND}`."
        ),
        legend: SERIES.iter().map(|s| (s.pen, s.name.to_owned())).collect(),
        columns: 2,
        panels: vec![
            panel("worst element", "error / %", true, &Pair::error),
            panel("axial stiffness Kxx", "error / %", true, &|p| p.error_of(0)),
        ],
    };
    let at = |series: usize, rpm: f64| -> &Pair {
        let pairs = &all[series];
        let nearest = pairs.iter().min_by(|a, b| {
            let off = |p: &Pair| (p.solved.scene.rpm - rpm).abs();
            off(a).total_cmp(&off(b))
        });
        nearest.unwrap_or(&pairs[0])
    };
    let mut rows = Vec::new();
    let mut worst = 0.0;
    let mut frozen_off = Vec::new();
    for (i, series) in SERIES.iter().enumerate().take(3) {
        for rpm in [6_000.0, 10_000.0, 15_000.0] {
            let pair = at(i, rpm);
            let judge = differenced(&pair.solved.scene)?;
            worst = worse(worst, (pair.solved.k[0][0] / judge - 1.0).abs());
            frozen_off.push((pair.frozen[0][0] / judge - 1.0).abs());
            rows.push(vec![
                series.name.to_owned(),
                shown(rpm),
                with_digits(1e-6 * judge, 5),
                with_digits(1e-6 * pair.solved.k[0][0], 5),
                with_digits(1e-6 * pair.frozen[0][0], 5),
                format!("{:+.2}", pair.error_of(0)),
                format!("{:.2}", pair.error()),
            ]);
        }
    }
    let table = Table {
        caption: "Axial stiffness of the 218 under 17,800 N, in N/um: by differences of displacements, exact, \
                  frozen; error of the frozen one, and of its worst element, %."
            .to_owned(),
        head: ["", "rpm", "differences", "exact", "frozen", "error of Kxx / %", "worst element / %"]
            .map(str::to_owned)
            .into(),
        rows,
    };
    let free = |rpm| at(1, rpm).error();
    let at_rest = all.iter().fold(0.0, |m, pairs| worse(m, pairs[0].error()));
    let least_frozen = frozen_off.iter().copied().fold(f64::INFINITY, f64::min);
    let statements = vec![
        Statement::ours(
            "The exact tangent is the slope of load against displacement; the frozen one is not.",
            vec![
                Measure::rounding(
                    "exact `Kxx` against differences of solved displacements, largest",
                    worst,
                    "",
                    1e-7,
                ),
                Measure::above(
                    "frozen `Kxx` against them, smallest",
                    100.0 * least_frozen,
                    "%",
                    0.05,
                ),
            ],
        ),
        Statement::ours(
            "On the 218 without race control, freezing is wrong by tenths of a percent at 6,000 rpm, by \
             percents at 10,000 rpm and by more than a quarter at 15,000 rpm.",
            vec![
                Measure::within("worst element, 6,000 rpm", free(6_000.0), "%", 0.2, 0.6),
                Measure::within("10,000 rpm", free(10_000.0), "%", 3.0, 7.0),
                Measure::within("15,000 rpm", free(15_000.0), "%", 25.0, 33.0),
            ],
        ),
        Statement::ours(
            "It is wrong with every rule.",
            vec![
                Measure::above(
                    "worst element at 15,000 rpm, outer race control",
                    at(0, 15_000.0).error(),
                    "%",
                    10.0,
                ),
                Measure::above("inner race control", at(2, 15_000.0).error(), "%", 10.0),
            ],
        ),
        Statement::ours(
            "On the smaller B7005C, whose balls are lighter and whose contact angles are flatter, it matters less.",
            vec![Measure::within(
                "worst element at 20,000 rpm",
                at(3, 20_000.0).error(),
                "%",
                0.05,
                3.0,
            )],
        ),
        Statement::ours(
            "At rest there is nothing to freeze.",
            vec![Measure::rounding("worst element", at_rest, "%", 1e-9)],
        ),
        judged(all.iter().flatten().map(|p| &p.solved)),
    ];
    Ok(Chapter {
        title: "Frozen against exact tangent",
        blocks: vec![
            Block::Text(
                "The exact stiffness (the solver's) against one that takes inertia loads and friction forces \
                 at the equilibrium for constants (reference build). 218: 17,800 N of axial load. B7005C: \
                 `Fx` = 1000 N, `Fy` = 200 N, `Mz` = 3 N m."
                    .to_owned(),
            ),
            Block::Figure(figure),
            Block::Table(table),
            Block::Statements(statements),
        ],
    })
}
