//! What a micrometre of spacer, a newton of spring and a kelvin do to a spindle.

use crate::quantities::{LOADS, OWN};
use anyhow::{Result, anyhow, ensure};
use spindle_bearing::{RacewayControlFree, Settings, Speed, SpindleChange, SpindleSolution};
use spindle_file::loads::{LoadRow, celsius};
use spindle_file::mounting::{DynSolver, DynSpindle, MOST_JOINTS, Parts, closed, growths};
use spindle_file::plan::{BuildError, MOST_BALLS, MOST_ROWS, Question};
use spindle_file::reading::short;
use spindle_file::spindles::SpindleFile;

type DynSolution<'s> =
    SpindleSolution<'s, f64, MOST_ROWS, MOST_BALLS, RacewayControlFree, 6, MOST_JOINTS>;
type DynChange<'s> = SpindleChange<'s, f64, MOST_ROWS, MOST_BALLS, 6, MOST_JOINTS>;

/// Step of a temperature to either side, K: changes are linear over it to some 1e-5.
const STEP: f64 = 0.1;
/// Smaller figures, N and um, are errors of rounding, printed as 0.
const ROUNDING: f64 = 1e-9;

/// A state in the order of [`OWN`], whose time does not count: none is idling, at rest, cold.
pub type State = [Option<f64>; OWN.len()];

fn row_of(state: State, file: &SpindleFile) -> Result<LoadRow> {
    let [_, loads @ .., speed, inner, outer] = state;
    for (value, own) in state.into_iter().zip(OWN).skip(LOADS) {
        if let Some(value) = value {
            ensure!(
                file.heat.is_some(),
                "--{} is for spindles with [heat]",
                own.name
            );
            celsius(value).map_err(|error| anyhow!("--{}: {error}", own.name))?;
        }
    }
    let idle = file.sensors.idle;
    let reference = file.heat.map(|heat| heat.reference);
    let temperatures = reference.map(|cold| [inner.unwrap_or(cold), outer.unwrap_or(cold)]);
    Ok(LoadRow {
        time_s: 0.0,
        load: std::array::from_fn(|i| loads[i].unwrap_or(idle[i].into())),
        speed_rpm: speed.unwrap_or(0.0),
        temperatures,
        probes: [None; 4],
    })
}

fn solve<'s>(
    solver: &'s mut DynSolver<f64>,
    spindle: &'s DynSpindle<'s, f64>,
    question: &Question,
) -> Result<DynSolution<'s>> {
    let at = Speed::rad_per_s(question.omega).with_growth(growths(&question.growth));
    let solved = solver.solve(spindle, question.load, at, &Settings::DEFAULT);
    solved.map_err(|status| anyhow!("{status}; --fx, --speed and others give another load"))
}

/// Changes of each row's preload, N, and of the displacement at each nose and probe, um, as CSV.
///
/// # Errors
///
/// A spindle that cannot be built, temperatures that it does not take, a state without an equilibrium.
pub fn sensitivity(file: &SpindleFile, state: State) -> Result<String> {
    let explained = |error: BuildError| file.explain(&error);
    let plan = closed(&file.plan).map_err(explained)?;
    let parts = Parts::<f64>::of(&plan).map_err(explained)?;
    let spindle = parts.spindle(&plan).map_err(explained)?;
    let row = row_of(state, file)?;
    let mut places: Vec<_> = file
        .noses
        .iter()
        .map(|nose| (nose.name.clone(), nose.end.position))
        .collect();
    places.extend(
        file.probes
            .iter()
            .map(|probe| (format!("probe_{}", probe.name), probe.position)),
    );
    if places.is_empty() {
        places.push(("origin".to_owned(), 0.0));
    }
    let from_loads = |x: f64| x - plan.loaded_at();

    // Preload of each row, N, and displacement at each place, um.
    let figures = |solution: &DynSolution<'_>, question: &Question| -> Vec<f64> {
        let preloads = solution.rows().map(|row| row.preload());
        let places = places.iter().flat_map(|(_, x)| {
            let [dx, dy, dz, ..] = solution.displacement_at(from_loads(*x));
            [dx - question.middle_growth, dy, dz].map(|u| 1e6 * u)
        });
        preloads.chain(places).collect()
    };
    let mut solver = DynSolver::<f64>::new();
    let mut heat: Vec<(String, Vec<f64>)> = Vec::new();
    if let Some(temperatures) = row.temperatures {
        for (side, name) in ["inner", "outer"].into_iter().enumerate() {
            let mut warmed = |by: f64| {
                let (mut row, mut temperatures) = (row, temperatures);
                temperatures[side] += by;
                row.temperatures = Some(temperatures);
                let question = file.question(&row);
                let solution = solve(&mut solver, &spindle, &question)?;
                anyhow::Ok(figures(&solution, &question))
            };
            let pairs = warmed(STEP)?.into_iter().zip(warmed(-STEP)?);
            let changes = pairs.map(|(high, low)| (high - low) / (2.0 * STEP));
            heat.push((format!("1 K at the {name} side"), changes.collect()));
        }
    }
    let question = file.question(&row);
    let solution = solve(&mut solver, &spindle, &question)?;
    let mut lines = vec![("as it is".to_owned(), figures(&solution, &question))];
    lines.extend(heat);
    let changes = |change: &DynChange<'_>, size: f64| -> Vec<f64> {
        let preloads = change.preloads().map(|preload| size * preload);
        let places = places.iter().flat_map(|(_, x)| {
            let [dx, dy, dz, ..] = change.displacement_at(from_loads(*x));
            [dx, dy, dz].map(|u| 1e6 * size * u)
        });
        preloads.chain(places).collect()
    };
    for row in 0..plan.rows.len() {
        let name = format!("1 um of closure of row {row}");
        let alone = std::array::from_fn(|i| if i == row { 1.0 } else { 0.0 });
        lines.push((name, changes(&solution.by_closures(alone), 1e-6)));
    }
    if plan.spring.is_some() {
        let name = "1 N of spring".to_owned();
        lines.push((name, changes(&solution.by_spring(), 1.0)));
    }
    let preloads = (0..plan.rows.len()).map(|row| format!("preload_{row}_n"));
    let of_place = |(name, _): &(String, f64)| ["dx", "dy", "dz"].map(|u| format!("{name}_{u}_um"));
    let columns: Vec<String> = preloads.chain(places.iter().flat_map(of_place)).collect();
    let mut text = format!("change,{}\n", columns.join(","));
    for (name, figures) in lines {
        let figures = figures.into_iter().map(|x| match x.abs() > ROUNDING {
            true => short(x).to_string(),
            false => "0".to_owned(),
        });
        let figures: Vec<String> = figures.collect();
        text += &format!("{name},{}\n", figures.join(","));
    }
    Ok(text)
}
