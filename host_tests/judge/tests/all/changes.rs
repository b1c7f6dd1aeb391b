//! Changes of an equilibrium by closures of its rows and by the force of a spring, against central differences of solves.

use super::bounds::{BALLS, BY_ROWS, Drawn};
use cli::random::Random;
use spindle_bearing::{Bearing, Material, Preload, Settings, Shaft, Speed, Spindle};
use spindle_file::mounting::DynSolver;
use spindle_file::plan::MOST_BALLS;
use std::array::from_fn;

const LOAD: [f64; 5] = [60.0, 90.0, -40.0, 0.8, -0.5];
/// Positions on the shaft, m: beyond the nose, and between the rows.
const PLACES: [f64; 2] = [-0.07, 0.04];

/// Figures of an equilibrium: displacement at each place, force of each row, its preload.
type Figures = [Vec<f64>; 3];

/// Of these rows, with the closures and the force of a spring in the place of their own.
struct Case<'b> {
    drawn: &'b Drawn<f64>,
    bearings: &'b [Bearing<f64, MOST_BALLS>],
    shaft: &'b Shaft<f64, 2>,
    speed: Speed<f64>,
    /// Proportions in which all rows that do not slide are closed.
    shared: &'b [f64],
}

impl Case<'_> {
    /// Figures with these closures and that force, and their changes by each closure, by all in their proportions, and by the force.
    fn figures(
        &self,
        closures: Option<&[f64]>,
        spring: Option<f64>,
    ) -> (Vec<f64>, Figures, Vec<Figures>) {
        let mut rows = self.drawn.mounted(self.bearings);
        let held = rows.iter_mut().zip(&self.drawn.places);
        for ((row, (.., held)), e) in held.zip(closures.unwrap_or_default()) {
            if *held != Preload::Spring {
                *row = row.with(Preload::Closure(*e));
            }
        }
        let supports = &self.drawn.supports;
        let spindle = Spindle::of_rows(BY_ROWS, &rows, spring, self.shaft, supports).unwrap();
        let mut solver = DynSolver::<f64>::new();
        let solution = solver.solve(&spindle, LOAD, self.speed, &Settings::DEFAULT);
        let solution = solution.unwrap();
        let at = |place: f64| solution.displacement_at(place);
        let figures = [
            PLACES.into_iter().flat_map(at).collect(),
            solution.rows().flat_map(|row| row.force).collect(),
            solution.rows().map(|row| row.preload()).collect(),
        ];
        let number = rows.len();
        let alone = (0..number).map(|row| from_fn(|i| if i == row { 1.0 } else { 0.0 }));
        let shared = from_fn(|i| self.shared.get(i).copied().unwrap_or_default());
        let closed = alone.chain([shared]).map(|by| solution.by_closures(by));
        let changes = closed.chain([solution.by_spring()]).map(|change| {
            [
                PLACES
                    .into_iter()
                    .flat_map(|x| change.displacement_at(x))
                    .collect(),
                change.forces().flatten().collect(),
                change.preloads().collect(),
            ]
        });
        (spindle.closures().collect(), figures, changes.collect())
    }
}

/// The largest deviation of a change from the difference of these figures, as a part of the largest figure of its kind; where all are
/// 0, of a thousandth of a usual one.
fn deviation(change: &Figures, [high, low]: [&Figures; 2], step: f64, usual: [f64; 3]) -> f64 {
    let mut worst = 0.0_f64;
    for (kind, found) in change.iter().enumerate() {
        let pairs = high[kind].iter().zip(&low[kind]);
        let truth: Vec<f64> = pairs
            .map(|(high, low)| (high - low) / (2.0 * step))
            .collect();
        let largest = |all: &[f64]| all.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        // Forces and moments, metres and radians apart.
        for i in 0..5 {
            let of = |all: &[f64]| -> Vec<f64> {
                let few = all.iter().skip(if kind == 2 { 0 } else { i });
                few.step_by(if kind == 2 { 1 } else { 5 })
                    .copied()
                    .collect()
            };
            let (found, truth) = (of(found), of(&truth));
            let size = largest(&truth).max(1e-3 * usual[kind]);
            for (found, truth) in found.iter().zip(&truth) {
                let off = (found - truth).abs();
                worst = worst.max(if off == 0.0 { 0.0 } else { off / size });
            }
        }
    }
    worst
}

fn check(rows: usize, is_sprung: bool, bends: bool) {
    let (mut r, mut weights) = (Random::seeded(7), Random::seeded(1));
    for number in 0..12 {
        let mut drawn = Drawn::<f64>::of(rows, is_sprung, bends, &mut r);
        // Each row has its own unit of length, which follows from its balls.
        for (design, i) in drawn.designs.iter_mut().zip(0..) {
            design.ball_diameter *= 1.0 - 0.05 * f64::from(i);
        }
        let bearings = drawn.designs.iter();
        let bearings =
            bearings.map(|of| Bearing::<f64, MOST_BALLS>::with_balls(of, BALLS).unwrap());
        let clamped = |row: &usize| drawn.places[*row].2 != Preload::Spring;
        let mut shared = vec![0.0; rows];
        for row in (0..rows).filter(clamped) {
            shared[row] = weights.between(0.0, 1.0);
        }
        let case = Case {
            drawn: &drawn,
            bearings: &bearings.collect::<Vec<_>>(),
            shaft: &Shaft::<f64, 2>::new(&drawn.sections, &Material::STEEL).unwrap(),
            speed: Speed::rpm(r.zero_or(0.2, 0.0, 20e3)),
            shared: &shared,
        };
        let (closures, _, changes) = case.figures(None, drawn.spring);
        let alone = |row| (0..rows).map(|i| f64::from(i == row)).collect();
        let each = (0..rows).filter(clamped).map(|row| (row, alone(row)));
        for (change, weights) in each.chain([(rows, shared.clone())]) {
            let step = 1e-9;
            let [high, low] = [step, -step].map(|by| {
                let moved = closures.iter().zip(&weights).map(|(e, w)| e + by * w);
                case.figures(Some(&moved.collect::<Vec<_>>()), drawn.spring)
                    .1
            });
            let off = deviation(&changes[change], [&high, &low], step, [1.0, 1e8, 1e8]);
            assert!(off < 1e-6, "{number}, {weights:?} of {rows} rows: {off}");
        }
        if let Some(force) = drawn.spring {
            let step = 1e-4 * force;
            let [high, low] = [step, -step].map(|by| case.figures(None, Some(force + by)).1);
            let off = deviation(&changes[rows + 1], [&high, &low], step, [1e-8, 1.0, 1.0]);
            assert!(off < 1e-6, "{number}, spring: {off}");
        }
    }
}

#[test]
fn changes_by_a_closure_are_central_differences_on_a_rigid_shaft() {
    check(2, false, false);
    check(4, false, false);
}

#[test]
fn changes_by_a_closure_are_central_differences_on_an_elastic_shaft() {
    check(2, false, true);
    check(4, false, true);
}

#[test]
fn changes_by_a_closure_or_the_spring_are_central_differences_with_a_sleeve() {
    check(2, true, false);
    check(3, true, true);
}
