//! Error of the stiffness over cycles, by tolerance.

use crate::scenes::{self, FULL, Measured, Program, Solve, cycles, solved};
use crate::table::{markdown, thousands};
use crate::timing::Core;
use anyhow::Result;
use cli::chart::{Chart, Curve, Panel, Style};
use judge::campaign::report::{Spread, name};
use judge::cases;
use judge::compare::stiffness_error;
use judge::reference::Task;
use lab::solves::{BALLS, STARTS, Work};
use rayon::prelude::*;
use solvers::dispatch::{Attitude, Precision};
use spindle_bearing::{Bearing, Settings, Solver, Speed};

/// Tolerances besides the default one and a tick's. Tolerances below the default are left out.
const TOLERANCES: [f64; 6] = [1e-1, 1e-2, 1e-4, 1e-6, 1e-9, 1e-12];

/// The gate's programs, then the full scene in single precision on the larger core; the full scene at all tolerances.
pub fn programs() -> Vec<Program> {
    let mut programs = scenes::programs();
    programs.push(Program::new(Core::M7, Precision::F32, FULL));
    for program in programs.iter_mut().filter(|program| is_full(program)) {
        let default = program.tolerances[0];
        let others = TOLERANCES.into_iter().filter(|t| *t > default);
        program.tolerances.extend(others);
    }
    programs
}

fn is_full(program: &Program) -> bool {
    program.scene.name == FULL.name
}

/// The full scene's programs.
fn full(all: &[Measured]) -> impl Iterator<Item = &Measured> {
    all.iter().filter(|measured| is_full(&measured.program))
}

/// Stiffness of the reference build's equilibrium, cold and warm.
type Truth = [Option<[[f64; 5]; 5]>; 2];

/// Found from the solver's equilibrium in doubles.
pub fn truths(works: &[Work]) -> Result<Vec<Truth>> {
    let truth = |work: &Work| {
        let bearing = Bearing::<f64, BALLS>::new(&work.design)?;
        let mut solver = Solver::new();
        let reference = cases::reference(&work.design, BALLS);
        Ok(work.states.map(|(load, omega)| {
            let speed = Speed::rad_per_s(omega);
            let solution = solver
                .solve(&bearing, load, speed, &Settings::default())
                .ok()?;
            let centres = reference.centres(&solution.balls().collect::<Vec<_>>());
            let task = Task::new(load, omega, Attitude::Raceless);
            let truth = reference.polish_near(&task, solution.displacement, &centres);
            truth.ok().map(|truth| truth.stiffness)
        }))
    };
    works.par_iter().map(truth).collect()
}

/// Cycles and errors of a program's solves at a tolerance.
fn point(measured: &Measured, truths: &[Truth], tolerance: usize, start: usize) -> [Spread; 2] {
    let solves: &[Solve] = &measured.solves[tolerance][start];
    let errors = solved(solves).filter_map(|(solve, answer)| {
        let truth = truths[solve.case][start].as_ref()?;
        Some(stiffness_error(&answer.stiffness(), truth))
    });
    [cycles(solves), Spread::of(errors)]
}

fn of_core(measured: &Measured) -> String {
    format!(
        "{}, {}",
        measured.program.core.name(),
        name(measured.program.precision)
    )
}

/// The table of tolerances: error and cycles, cold and warm.
pub fn tolerances(all: &[Measured], truths: &[Truth]) -> String {
    let mut lines = Vec::new();
    for measured in full(all) {
        for (i, tolerance) in measured.program.tolerances.iter().enumerate() {
            let mut line = vec![format!("{}, {tolerance:.0e}", of_core(measured))];
            for start in [1, 0] {
                let [cycles, error] = point(measured, truths, i, start);
                line.push(thousands(cycles.median as u64));
                line.extend([error.median, error.most].map(|error| format!("{error:.1e}")));
            }
            lines.push(line);
        }
    }
    markdown(
        "tolerance | warm | error | 99 % | cold | error | 99 %",
        &lines,
    )
}

/// The picture: error of the stiffness over cycles, a point for every tolerance.
pub fn chart(all: &[Measured], truths: &[Truth]) -> Chart {
    let panel = |start: usize| {
        let curves = full(all).flat_map(|measured| {
            let tolerances = &measured.program.tolerances;
            let mut falling: Vec<usize> = (0..tolerances.len()).collect();
            falling.sort_by(|i, j| tolerances[*j].total_cmp(&tolerances[*i]));
            let points: Vec<[Spread; 2]> = falling
                .into_iter()
                .map(|i| point(measured, truths, i, start))
                .collect();
            let curve = |style, error: fn(&Spread) -> f64| {
                let along = points.iter().map(|[cycles, e]| (cycles.median, error(e)));
                Curve::new(&of_core(measured), style, along.collect())
            };
            [
                curve(Style::Line, |e| e.median),
                curve(Style::Dots, |e| e.median),
                curve(Style::Dashed, |e| e.most),
            ]
        });
        let mut panel = Panel::new(
            &format!("{}, by tolerance", STARTS[start]),
            "cycles of a solve, median (modelled)",
            "error of the stiffness",
            curves.collect(),
        );
        for (axis, range) in [(&mut panel.x, (1e4, 4e5)), (&mut panel.y, (1e-16, 1.0))] {
            axis.range = Some(range);
            axis.logarithmic = true;
        }
        panel
    };
    Chart::new(
        "Error of the stiffness over cycles. Lines: median; dashed: 99 % of the cases",
        2,
        [1, 0].map(panel).into(),
    )
}
