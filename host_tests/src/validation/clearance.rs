//! The 6205 with five clearances, against speed.

use super::figure::{
    Axis, BLUE, Curve, Dash, Figure, GREEN, INK, Marker, PURPLE, Panel, Pen, Plane, VERMILION,
};
use super::scene::{Scene, Solved, evenly, solve_all};
use super::statement::{Measure, Statement, Verdict};
use super::{Block, COMMAND, Chapter, Progress, judged};
use crate::cases::SKF6205;
use crate::dispatch::Attitude;
use spindle_bearing::{Design, FreeContact};

/// Diametral clearances, um.
const CLEARANCES: [f64; 5] = [10.0, 15.0, 20.0, 25.0, 30.0];
/// Others, further apart.
const WIDER: [f64; 5] = [0.0, 10.0, 20.0, 30.0, 40.0];
const TOP: f64 = 30_000.0;
const STEPS: usize = 60;
/// Speeds that the study's claim names, rpm.
const BELOW: f64 = 12_000.0;
const ABOVE: f64 = 15_000.0;
/// Where a fall with speed is judged to, rpm.
const STUDY_TOP: f64 = 20_000.0;

const PENS: [Pen; 5] = [
    Pen(INK, Dash::Solid, Marker::Cross),
    Pen(BLUE, Dash::Long, Marker::Square),
    Pen(GREEN, Dash::Short, Marker::Disc),
    Pen(PURPLE, Dash::Long, Marker::Ring),
    Pen(VERMILION, Dash::Solid, Marker::Triangle),
];

fn kxx(s: &Solved) -> f64 {
    s.k[0][0]
}

fn kyy(s: &Solved) -> f64 {
    s.k[1][1]
}

fn panel(title: &str, runs: &[Vec<Solved>], of: fn(&Solved) -> f64) -> Panel {
    let curves = runs.iter().zip(PENS).enumerate();
    Panel {
        title: title.to_owned(),
        plane: Plane::Straight {
            x: Axis::from_zero("speed / 1000 rpm"),
            y: Axis::from_zero("stiffness / (N/\u{b5}m)"),
        },
        curves: curves
            .map(|(i, (run, pen))| {
                let points = run.iter().map(|s| (s.scene.rpm / 1e3, 1e-6 * of(s)));
                Curve::through(pen, points.collect(), 2 * i, 6)
            })
            .collect(),
        nodes: Vec::new(),
    }
}

/// Steps of the axial stiffness from a clearance to the next, over the stiffness, at a speed.
fn steps(runs: &[Vec<Solved>], i: usize) -> impl Iterator<Item = f64> {
    runs.windows(2)
        .map(move |w| kxx(&w[1][i]) / kxx(&w[0][i]) - 1.0)
}

/// Least and largest of those steps over the speeds for which `range` is true, %.
fn extremes(runs: &[Vec<Solved>], range: impl Fn(f64) -> bool) -> (f64, f64) {
    let speeds = (0..runs[0].len()).filter(|&i| range(runs[0][i].scene.rpm));
    speeds
        .flat_map(|i| steps(runs, i))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| {
            (l.min(100.0 * s), h.max(100.0 * s))
        })
}

/// The last speed up to which stiffness rises with every step of clearance, and the first from
/// which on it falls with every step.
fn turning_speeds(runs: &[Vec<Solved>]) -> (f64, f64) {
    let rpm = |i: usize| runs[0][i].scene.rpm;
    let rises = (0..=STEPS)
        .take_while(|&i| steps(runs, i).all(|s| s > 0.0))
        .last();
    let falls = (0..=STEPS)
        .rev()
        .take_while(|&i| steps(runs, i).all(|s| s < 0.0))
        .last();
    (rises.map_or(f64::NAN, rpm), falls.map_or(f64::NAN, rpm))
}

/// The largest step up along the speeds in `range`, over the stiffness at rest, %.
fn largest_rise(runs: &[Vec<Solved>], of: fn(&Solved) -> f64, range: impl Fn(f64) -> bool) -> f64 {
    let mut largest = f64::NEG_INFINITY;
    for run in runs {
        for w in run.windows(2).filter(|w| range(w[1].scene.rpm)) {
            largest = largest.max(100.0 * (of(&w[1]) - of(&w[0])) / of(&run[0]));
        }
    }
    largest
}

fn least_of_changes(runs: &[Vec<Solved>], of: fn(&Solved) -> f64) -> f64 {
    let changes = runs.iter().map(|run| {
        let end = run
            .iter()
            .rfind(|s| s.scene.rpm <= STUDY_TOP)
            .unwrap_or(&run[0]);
        100.0 * (of(end) / of(&run[0]) - 1.0)
    });
    changes.fold(f64::NEG_INFINITY, f64::max)
}

fn statements(runs: &[Vec<Solved>]) -> Vec<Statement> {
    let (rises_to, falls_from) = turning_speeds(runs);
    let slow = extremes(runs, |rpm| rpm < rises_to);
    let near = extremes(runs, |rpm| rpm > rises_to && rpm <= BELOW);
    let between = extremes(runs, |rpm| rpm > ABOVE && rpm < falls_from);
    let fast = extremes(runs, |rpm| rpm >= falls_from);
    let within = |rpm: f64| rpm <= STUDY_TOP;
    let beyond = |rpm: f64| rpm > STUDY_TOP;
    let at_end = runs.iter().map(|run| {
        let least = run.iter().map(kxx).fold(f64::INFINITY, f64::min);
        100.0 * (kxx(&run[STEPS]) / least - 1.0)
    });
    vec![
        Statement::of(
            "item 6",
            "The axial stiffness rises with clearance below about 12,000 rpm.",
            vec![
                Measure::within("rises with every step of clearance up to", rises_to, "rpm", 11_000.0, 12_500.0),
                Measure::above("least step below that", slow.0, "%", 0.0),
                Measure::within("largest", slow.1, "%", slow.0, 30.0),
                Measure::within("least step from there to 12,000 rpm", near.0, "%", -1.0, 0.0),
            ],
        ),
        Statement::of(
            "item 6",
            "It falls with clearance above 15,000 rpm.",
            vec![
                Measure::within("falls with every step of clearance from", falls_from, "rpm", 15_500.0, 18_500.0),
                Measure::within("largest step from there on", fast.1, "%", -10.0, 0.0),
                Measure::within("largest step between 15,000 rpm and there", between.1, "%", 0.0, 6.0),
            ],
        )
        .but(
            Verdict::InPart,
            "It does so from a higher speed on. At 15,000 rpm the stiffness has its peak between the five \
             clearances: it still rises over the smaller ones and falls over the larger ones.",
        ),
        Statement::of(
            "item 6",
            "The axial stiffness falls with speed.",
            vec![
                Measure::within("largest step up to 20,000 rpm", largest_rise(runs, kxx, within), "%", -1.0, 0.0),
                Measure::within("smallest change from rest to 20,000 rpm", least_of_changes(runs, kxx), "%", -100.0, -10.0),
                Measure::within("largest step beyond, a rise", largest_rise(runs, kxx, beyond), "%", 0.0, 2.0),
                Measure::within(
                    "largest rise from its least value to 30,000 rpm",
                    at_end.fold(0.0, f64::max),
                    "%",
                    1.0,
                    30.0,
                ),
            ],
        )
        .but(
            Verdict::InPart,
            "Up to 20,000 rpm it does, for every clearance; at higher speeds it passes a minimum and \
             rises.",
        ),
        Statement::of(
            "item 6",
            "The radial stiffness falls with speed.",
            vec![
                Measure::within("largest step up to 20,000 rpm", largest_rise(runs, kyy, within), "%", -1.0, 0.0),
                Measure::within("smallest change from rest to 20,000 rpm", least_of_changes(runs, kyy), "%", -100.0, -10.0),
            ],
        ),
    ]
}

/// The same claim for clearances further apart.
fn wider(runs: &[Vec<Solved>]) -> Statement {
    let (rises_to, _) = turning_speeds(runs);
    let first = |i: usize| 100.0 * (kxx(&runs[1][i]) / kxx(&runs[0][i]) - 1.0);
    let least = (0..=STEPS).map(first).fold(f64::INFINITY, f64::min);
    let from_15000 = extremes(&runs[1..], |rpm| rpm > ABOVE);
    Statement::ours(
        "The speeds depend on the clearances: of 0, 10, 20, 30 and 40 um, the axial stiffness rises over all of \
         them up to a lower speed only, and from 0 to 10 um it rises at every speed up to 30,000 rpm.",
        vec![
            Measure::within(
                "rises with every step of clearance up to",
                rises_to,
                "rpm",
                9_000.0,
                11_000.0,
            ),
            Measure::above("least step from 0 to 10 um", least, "%", 0.0),
            Measure::within(
                "largest step over the others above 15,000 rpm",
                from_15000.1,
                "%",
                0.0,
                5.0,
            ),
        ],
    )
}

fn runs(clearances: &[f64], progress: &dyn Progress) -> anyhow::Result<Vec<Vec<Solved>>> {
    clearances
        .iter()
        .map(|clearance| {
            let design = Design {
                free_contact: FreeContact::DiametralClearance(clearance * 1e-6),
                ..SKF6205
            };
            let scenes = evenly(0.0, TOP, STEPS).into_iter().map(|rpm| Scene {
                name: "SKF 6205",
                design,
                balls: 9,
                attitude: Attitude::Raceless,
                load: [100.0, 0.0, 0.0, 0.0, 0.0],
                rpm,
            });
            solve_all(scenes.collect(), progress)
        })
        .collect()
}

/// The chapter.
///
/// # Errors
///
/// A clearance or speed without a solution.
pub fn chapter(progress: &dyn Progress) -> anyhow::Result<Chapter> {
    let wide = runs(&WIDER, progress)?;
    let runs = runs(&CLEARANCES, progress)?;
    let mut statements = statements(&runs);
    statements.push(wider(&wide));
    statements.push(judged(runs.iter().chain(&wide).flatten()));
    let figure = Figure {
        name: "clearance_6205",
        title: "SKF 6205, Fx = 100 N: stiffness against speed for five diametral clearances"
            .to_owned(),
        caption: format!(
            "Axial and radial stiffness of the 6205 under 100 N of axial load against speed, for five \
             diametral clearances. Regenerate with `{COMMAND}`."
        ),
        legend: PENS
            .iter()
            .zip(CLEARANCES)
            .map(|(p, c)| (*p, format!("Pd = {c} \u{b5}m")))
            .collect(),
        columns: 2,
        panels: vec![
            panel("axial stiffness Kxx", &runs, kxx),
            panel("radial stiffness Kyy = Kzz", &runs, kyy),
        ],
    };
    Ok(Chapter {
        title: "Clearance and speed: the 6205",
        blocks: vec![
            Block::Text(
                "100 N of axial load, diametral clearances of 10, 15, 20, 25 and 30 um (which five the study \
                 took is not known), 0 to 30,000 rpm in steps of 500 rpm. Raceway-control-free \
                 attitude. \"Step\" is the change from a clearance, or a speed, to the next."
                    .to_owned(),
            ),
            Block::Figure(figure),
            Block::Statements(statements),
        ],
    })
}
