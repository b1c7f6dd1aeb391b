//! Elastic shafts whose loads act far from their rows, and slender ones.

use super::elastic::random_elastic;
use super::solves::{Answer, found, lengths, vector_error};
use cli::random::Random;
use judge::cases::B7005C;
use judge::compare::{Equilibrium, stiffness_error, worse};
use judge::reference::Task;
use judge::reference::spindle::Solver;
use rayon::prelude::*;
use solvers::dispatch::{Attitude, Precision};
use spindle_bearing::{Arrangement, Facing, Preload, Section, ShaftLoad, Support};
use spindle_file::plan::{ElasticShaft, Plan, Question, Row};
use std::array::from_fn;

const DISTANCES: [f64; 7] = [0.125, 0.5, 1.0, 1.75, 5.0, 10.0, 30.0];

fn solve(
    plan: &Plan,
    attitude: Attitude,
    precision: Precision,
    question: &Question,
    nose: f64,
) -> Option<Answer> {
    let question = question.clone().at(nose).at(plan.loaded_at());
    found(plan, attitude.into(), precision, &question)
}

/// Differences of contact forces, over the largest.
fn off_forces(found: &Answer, truth: &Answer) -> f64 {
    let balls = |answer: &Answer| -> Vec<f64> {
        let balls = answer.rows.iter().flat_map(|row| &row.balls);
        balls.flat_map(|ball| [ball.q_i, ball.q_o]).collect()
    };
    let (found, truth) = (balls(found), balls(truth));
    let most = truth.iter().copied().fold(0.0, f64::max);
    let off = found.iter().zip(&truth).map(|(a, b)| (a - b).abs());
    off.fold(0.0, worse) / most
}

/// Errors over the stated ones: of displacements where loads act and at the nose, of forces, stiffness and compliance.
fn over_stated(found: &Answer, truth: &Answer, lengths: [f64; 5]) -> [f64; 5] {
    let [displacement, force, stiffness] = found.error;
    let ends = || found.at.iter().zip(&truth.at);
    let moved = ends().map(|(found, truth)| {
        vector_error(found.displacement, truth.displacement, lengths) / found.displacement_error
    });
    let compliance = ends().flat_map(|(found, truth)| {
        (0..5).map(|i| {
            let off = found.compliance[i][i] / truth.compliance[i][i] - 1.0;
            off.abs() / found.compliance_error[i]
        })
    });
    let ([_, here], [_, truly_here]) = (&found.at[..], &truth.at[..]) else {
        panic!("two points were asked for")
    };
    [
        vector_error(here.displacement, truly_here.displacement, lengths) / displacement,
        moved.fold(0.0, worse),
        off_forces(found, truth) / force,
        stiffness_error(&here.stiffness, &truly_here.stiffness) / stiffness,
        compliance.fold(0.0, worse),
    ]
}

/// The pair of a spindle on a shaft of 25 mm; the loads act `distance` in front of it, or behind it.
fn pair(distance: f64, to_the_end: bool) -> Plan {
    let row = |position, facing| Row {
        balls: 16,
        design: B7005C,
        position,
        facing,
        preload: Preload::Force(200.0),
    };
    let (low, high) = match to_the_end {
        true => (-distance.abs(), 0.1 + distance.abs()),
        false => (-0.03, 0.12),
    };
    let section = Section {
        from: low,
        to: high,
        outer: 0.025,
        inner: 0.0,
    };
    Plan {
        arrangement: Arrangement::BackToBack,
        shaft: Some(ElasticShaft::of(vec![section], vec![Support::RIGID; 2])),
        ..Plan::of(vec![row(0.0, Facing::PlusX), row(0.1, Facing::MinusX)])
    }
}

/// A load far in front or behind is solved in as many iterations as one at the rows, which feel its moment. So is a constant load, and
/// the reaction to the displacement that the load makes.
#[test]
fn a_load_far_away_is_its_moment_at_the_rows() {
    let free = Attitude::Raceless;
    for (distance, to_the_end) in DISTANCES.iter().flat_map(|d| [(*d, false), (*d, true)]) {
        for at in [-distance, 0.1 + distance] {
            let plan = pair(distance, to_the_end);
            // A moment of 20 N m.
            let [fy, fz] = [18.0 / distance, -9.0 / distance];
            let question = |load| Question::load(load, 1000.0);
            let load = [10.0, fy, fz, 0.1, 0.0];
            let mut there = plan.clone();
            let row = if at < 0.0 { 0.0 } else { 0.1 };
            there.shaft.as_mut().unwrap().loaded_at = row;
            let arm = at - row;
            let moment = question([10.0, fy, fz, 0.1 - arm * fz, arm * fy]);
            let mut far = plan.clone();
            far.shaft.as_mut().unwrap().loaded_at = at;
            let mut pulled = plan.clone();
            let constant = ShaftLoad { position: at, load };
            pulled.shaft.as_mut().unwrap().loads.push(constant);
            for (precision, least) in [(Precision::F64, 1e-10), (Precision::F32, 1e-3)] {
                let name = format!("{at} {to_the_end} {precision:?}");
                let solved = |plan: &Plan, question: &Question| {
                    let answer = solve(plan, free, precision, question, at);
                    answer.unwrap_or_else(|| panic!("{name}"))
                };
                let near = solved(&there, &moment);
                let found = solved(&far, &question(load));
                assert!(found.iterations <= 12, "{name}: {}", found.iterations);
                assert!(off_forces(&found, &near) < least, "{name}");
                let constant = solved(&pulled, &question([0.0; 5]));
                assert!(off_forces(&constant, &near) < least, "{name}");
                let u = found.at[0].displacement;
                let apart = vector_error(constant.at[0].displacement, u, lengths(&B7005C));
                assert!(apart < least, "{name}: {apart:e}");
                // Larger displacements are no contact's, and refused.
                if u.iter().any(|u| u.abs() > 3e-4) || precision == Precision::F32 {
                    continue;
                }
                for held in [
                    [true; 5],
                    [false, true, true, false, false],
                    [true, false, false, true, true],
                    [false, true, false, false, true],
                ] {
                    let again = solved(&far, &question(load).holding(held, u));
                    assert!(off_forces(&again, &near) < 1e-6, "{name}: {held:?}");
                    let apart: [f64; 5] = from_fn(|i| (again.load[i] - load[i]).abs());
                    let most = apart.into_iter().fold(0.0, worse);
                    assert!(most < 1e-4, "{name}: {held:?}: {apart:?}");
                }
            }
        }
    }
}

/// A single-precision solver is told the same numbers.
fn rounded(plan: &mut Plan) {
    let shaft = plan.shaft.as_mut().unwrap();
    let at = shaft.loaded_at;
    for row in &mut plan.rows {
        round(&mut row.position, at);
    }
    for section in &mut shaft.sections {
        round(&mut section.from, at);
        round(&mut section.to, at);
    }
}

fn round(x: &mut f64, origin: f64) {
    *x = f64::from((*x - origin) as f32) + origin;
}

fn question_of(question: Question) -> Question {
    Question {
        load: question.load.map(|load| f64::from(load as f32)),
        growth: Vec::new(),
        ..question
    }
}

/// A random set whose loads act far away, on a shaft that may reach there.
fn far(seed: u64) -> (Plan, Attitude, Question) {
    let (mut plan, attitude, question) = random_elastic(seed);
    let mut r = Random::seeded(seed ^ 0xfa4);
    let distance = r.log_between(0.1, 30.0);
    let size = plan.rows[0].design.pitch_diameter;
    // As far as rows may be from where loads act.
    let distance = (1024.0 * distance.min(2000.0 * size)).round() / 1024.0;
    let shaft = plan.shaft.as_mut().unwrap();
    let last = shaft.sections.last().unwrap().to;
    shaft.loaded_at = match r.chance(0.5) {
        true => -distance,
        false => distance,
    };
    if r.chance(0.5) && shaft.loaded_at > last {
        shaft.sections.push(Section {
            from: last,
            to: shaft.loaded_at,
            outer: 0.6 * size,
            inner: 0.0,
        });
    }
    rounded(&mut plan);
    let mut question = question_of(question);
    for i in [1, 2] {
        question.load[i] = f64::from((question.load[i] * size / (size + distance)) as f32);
    }
    (plan, attitude, question)
}

/// The same load, about the row that is nearest to it.
fn at_the_row(plan: &Plan, question: &Question) -> (Plan, Question) {
    let (mut there, at) = (plan.clone(), plan.loaded_at());
    let positions = plan.rows.iter().map(|row| row.position);
    let (low, high) = (
        positions.clone().fold(f64::INFINITY, f64::min),
        positions.fold(f64::NEG_INFINITY, f64::max),
    );
    let row = at.clamp(low, high);
    there.shaft.as_mut().unwrap().loaded_at = row;
    let [fx, fy, fz, my, mz] = question.load;
    let arm = at - row;
    let moment = Question {
        load: [fx, fy, fz, my - arm * fz, mz + arm * fy],
        ..question.clone()
    };
    (there, moment)
}

/// Whether it is not solved though it is with the moment at the rows, in how many precisions; errors over the stated ones.
fn judged(seed: u64) -> (usize, [f64; 5]) {
    let (plan, attitude, question) = far(seed);
    let (at, size) = (plan.loaded_at(), plan.rows[0].design.pitch_diameter);
    let (there, moment) = at_the_row(&plan, &question);
    let mut nose = plan.rows[0].position - size;
    round(&mut nose, at);
    let solved = |plan: &Plan, question: &Question, precision| {
        solve(plan, attitude, precision, question, nose)
    };
    let precisions = [Precision::F64, Precision::F32];
    let found = precisions.map(|precision| solved(&plan, &question, precision));
    let missed = precisions.iter().zip(&found).filter(|(precision, found)| {
        found.is_none() && solved(&there, &moment, **precision).is_some()
    });
    let over = match &found {
        [Some(truth), Some(found)] => over_stated(found, truth, lengths(&plan.rows[0].design)),
        _ => [0.0; 5],
    };
    (missed.count(), over)
}

/// Worst errors over the stated ones, seeds of those that are more than `most`, and of what is missed.
fn worst(
    seeds: std::ops::Range<u64>,
    most: f64,
    judged: impl Fn(u64) -> (usize, [f64; 5]) + Sync + Send,
) -> ([f64; 5], Vec<u64>, Vec<u64>) {
    let all: Vec<_> = seeds
        .into_par_iter()
        .map(|seed| (seed, judged(seed)))
        .collect();
    let mut largest = [0.0; 5];
    for (_, (_, over)) in &all {
        largest = from_fn(|i| worse(largest[i], over[i]));
    }
    let beyond = all
        .iter()
        .filter(|(_, (_, over))| !over.iter().all(|over| *over <= most));
    let missed = all.iter().filter(|(_, (missed, _))| *missed > 0);
    (
        largest,
        beyond.map(|(seed, _)| *seed).collect(),
        missed.map(|(seed, _)| *seed).collect(),
    )
}

#[test]
fn stated_errors_hold_far_from_the_rows() {
    let (largest, beyond, missed) = worst(0..2000, 3.0, judged);
    println!("{largest:.2?} {missed:?}");
    assert!(beyond.is_empty(), "{largest:?} {beyond:?}");
    assert!(missed.is_empty(), "{missed:?}");
}

/// Axial displacements and tilts that loads far away make are answered where they are given in the place of these loads, but for
/// three sets of 2,000. A few sets have two equilibria, and find the other one.
#[test]
fn displacements_given_far_away_are_answered() {
    let judged = |seed: u64| {
        let (plan, attitude, question) = far(seed);
        let mut r = Random::seeded(seed ^ 0x91e);
        let is_held: [bool; 5] = from_fn(|i| !matches!(i, 1 | 2) && r.chance(0.5));
        let (mut missed, mut other) = (false, false);
        for (precision, least) in [(Precision::F64, 1e-6), (Precision::F32, 0.1)] {
            let solved = |question: &Question| solve(&plan, attitude, precision, question, 0.0);
            if let Some(free) = solved(&question) {
                let u = free.at[1].displacement;
                let met = solved(&question.clone().holding(is_held, u));
                missed |= met.is_none();
                other |= met.is_some_and(|met| off_forces(&met, &free) > least);
            }
        }
        (seed, missed, other)
    };
    let all: Vec<_> = (0..2000).into_par_iter().map(judged).collect();
    let missed: Vec<u64> = all.iter().filter(|a| a.1).map(|a| a.0).collect();
    let other: Vec<u64> = all.iter().filter(|a| a.2).map(|a| a.0).collect();
    assert!(missed.len() <= 3, "{missed:?}");
    assert!(other.len() <= 15, "{other:?}");
}

/// A pair on a shaft of 0.08 to 0.6 pitch diameters that spans 3 to 30 of them.
fn slender(seed: u64) -> (usize, [f64; 5]) {
    let (mut plan, attitude, question) = random_elastic(seed);
    let mut r = Random::seeded(seed ^ 0x51e);
    let size = plan.rows[0].design.pitch_diameter;
    let span = size * r.log_between(3.0, 30.0);
    let first = -span * r.between(-0.5, 1.5);
    let row = plan.rows[0].clone();
    plan.rows = [(first, Facing::PlusX), (first + span, Facing::MinusX)]
        .map(|(position, facing)| Row {
            position,
            facing,
            preload: Preload::Force(2e6 * row.design.ball_diameter.powi(2)),
            ..row.clone()
        })
        .to_vec();
    plan.arrangement = Arrangement::BackToBack;
    plan.spring = None;
    let shaft = plan.shaft.as_mut().unwrap();
    shaft.supports = (0..2)
        .map(|i| shaft.supports.get(i).copied().unwrap_or(Support::RIGID))
        .collect();
    shaft.sections = vec![Section {
        from: first - size,
        to: first + span + size,
        outer: size * r.log_between(0.08, 0.6),
        inner: 0.0,
    }];
    rounded(&mut plan);
    let mut question = question_of(question);
    let part = r.log_between(3e-3, 0.3);
    for load in &mut question.load {
        *load = f64::from((*load * part) as f32);
    }
    let mut nose = first - size;
    round(&mut nose, 0.0);
    let solved = |precision| solve(&plan, attitude, precision, &question, nose);
    match [Precision::F64, Precision::F32].map(solved) {
        [Some(truth), Some(found)] => (0, over_stated(&found, &truth, lengths(&row.design))),
        [Some(_), None] => (1, [0.0; 5]),
        _ => (0, [0.0; 5]),
    }
}

#[test]
fn slender_shafts_are_solved_or_refused_in_single_precision() {
    let (largest, beyond, missed) = worst(0..2000, 5.0, slender);
    println!("{largest:.2?} {missed:?}");
    assert!(beyond.is_empty(), "{largest:?} {beyond:?}");
    assert!(missed.len() <= 20, "{missed:?}");
    // A row whose stiffness is negative takes more than all of the shaft's.
    let (_, over) = slender(5442);
    assert!(over.iter().all(|over| *over <= 5.0), "{over:?}");
}

/// Positions from where loads act, as the reference build has them.
fn about_loads(mut plan: Plan) -> Plan {
    let at = plan.loaded_at();
    let shaft = plan.shaft.as_mut().unwrap();
    shaft.loaded_at = 0.0;
    for section in &mut shaft.sections {
        (section.from, section.to) = (section.from - at, section.to - at);
    }
    for row in &mut plan.rows {
        row.position -= at;
    }
    plan
}

/// Double precision against the reference build, whose residual and unknowns have twice as many digits: with the loads far from the
/// rows, and with their moment at a row.
#[test]
fn stated_errors_of_double_precision_hold_far_from_the_rows() {
    let judged = |seed: u64| {
        let (plan, attitude, question) = far(seed);
        let asked = [
            (plan.clone(), question.clone()),
            at_the_row(&plan, &question),
        ];
        let over = asked.map(|(plan, question)| {
            let plan = about_loads(plan);
            let found = solve(&plan, attitude, Precision::F64, &question, 0.0)?;
            let task = Task::new(question.load, question.omega, attitude);
            let reference = Solver::new(&plan, &[]).unwrap();
            let Ok(truth) = reference.polish_from(&task, &found, 1e-7) else {
                return Some([f64::INFINITY; 3]);
            };
            let errors = Equilibrium::from(&found).errors(&truth, &plan.rows[0].design);
            let errors = [errors.displacement, errors.force, errors.stiffness];
            Some(from_fn(|i| errors[i] / found.error[i]))
        });
        (seed, over)
    };
    let all: Vec<_> = (0..2000).into_par_iter().map(judged).collect();
    for far_or_near in 0..2 {
        let over = all
            .iter()
            .filter_map(|(seed, over)| Some((*seed, over[far_or_near]?)));
        let over: Vec<(u64, [f64; 3])> = over.collect();
        let most = over.iter().fold([0.0; 3], |most, (_, over)| {
            from_fn(|i| worse(most[i], over[i]))
        });
        let beyond: Vec<_> = over
            .iter()
            .filter(|(_, over)| !over.iter().all(|over| *over <= 3.0))
            .collect();
        println!("{} of {}: {most:.2?}", beyond.len(), over.len());
        assert!(over.len() > 1900, "{}", over.len());
        assert!(beyond.is_empty(), "{most:.2?} {beyond:.2?}");
    }
}
