//! Several bearings on one shaft.

use super::solves::{self, ask, found, mirrored, off_mirror, vector_error};

use cli::random::Random;
use judge::cases::{B218, B7005C, Case, SKF6205, SolvedSet, elastic, rad_per_s, sets};
use judge::compare::{Equilibrium, Errors, stiffness_error, worse};
use judge::reference::{Task, spindle::Solver};
use rayon::prelude::*;
use solvers::dispatch::{Attitude, Precision};
use solvers::{Answer, AnySolver, AtEnd, Balls, Choices, with_solver};
use spindle_bearing::{Arrangement, Design, Facing, Growth, Preload, Section, Status, Support};
use spindle_file::plan::{ElasticShaft, MOST_ROWS, Plan, Question, Row};
use std::array::from_fn;
use std::f64::consts::{PI, TAU};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().map(f64::abs).fold(0.0, worse)
}

/// Closure of a row, where a spring does not make it.
fn clamped_by(row: &Row) -> Option<f64> {
    match row.preload {
        Preload::Closure(closure) => Some(closure),
        _ => None,
    }
}

/// Largest displacement of a solved set's shaft, or a row's largest closure if this is larger: an unloaded set has no
/// displacement at all.
fn size(set: &SolvedSet) -> f64 {
    let closures = set.plan.rows.iter().filter_map(clamped_by);
    let moved = solves::size(
        set.truth.displacement,
        solves::lengths(&set.plan.rows[0].design),
    );
    worse(moved, largest(closures.chain(set.spring_closure)))
}

/// Distance of a solution from a solved set, displacements over its [`size`].
fn errors(mut found: Equilibrium, set: &SolvedSet) -> Errors {
    if set.nose.is_some() {
        // The file of elastic sets has no inertia loads.
        for ball in &mut found.balls {
            (ball.centrifugal_force, ball.gyroscopic_moment) = (0.0, 0.0);
        }
    }
    let (design, truth) = (&set.plan.rows[0].design, &set.truth);
    let mut errors = found.errors(truth, design);
    errors.displacement *= truth.largest_displacement(0.5 * design.pitch_diameter) / size(set);
    errors
}

/// Errors of an answer: of rows, sleeve and nose, too.
fn errors_of_answer(found: &Answer, set: &SolvedSet) -> Errors {
    let design = &set.plan.rows[0].design;
    let (lengths, forces) = (solves::lengths(design), solves::forces(design));
    let mut errors = errors(Equilibrium::from(found), set);
    let moved = |a, b| vector_error(a, b, lengths);
    if let Some(closure) = set.spring_closure {
        let off = (found.spring_closure - closure).abs() / size(set);
        errors.displacement = worse(errors.displacement, off);
    }
    let of_rows = largest(set.rows.iter().map(|row| solves::size(row.load, forces)));
    for (found, truth) in found.rows.iter().zip(&set.rows) {
        let off = from_fn(|i| found.force[i] - truth.load[i]);
        errors.force = worse(errors.force, solves::size(off, forces) / of_rows);
        if let Some(truth) = truth.displacement {
            errors.displacement = worse(errors.displacement, moved(found.displacement, truth));
        }
    }
    if let Some(nose) = &set.nose {
        let found = &found.at[0];
        let displacement = moved(found.displacement, nose.displacement);
        errors.displacement = worse(errors.displacement, displacement);
        let compliance = stiffness_error(&found.compliance, &nose.flexibility);
        errors.stiffness = worse(errors.stiffness, compliance);
    }
    errors
}

/// A question, as the reference build is asked.
fn task(question: &Question, attitude: Attitude) -> Task {
    Task::new(question.load, question.omega, attitude)
}

/// The equilibrium that the reference build reaches from an answer of rows that have not grown.
pub fn reference_near(
    plan: &Plan,
    attitude: Attitude,
    question: &Question,
    answer: &Answer,
) -> Option<Equilibrium> {
    let reference = Solver::new(plan, &[]).unwrap();
    reference.polish(&task(question, attitude), answer).ok()
}

/// Every solved set in every scene that it fits into; the reference build of sets finds them from nothing.
#[test]
fn solved_sets_are_solved_in_both_precisions() {
    let allowed = |displacement, others, stiffness| Errors {
        displacement,
        contact_angle: others,
        force: others,
        stiffness,
    };
    let bounds = [allowed(1e-5, 1e-4, 1e-3), allowed(1e-9, 1e-10, 1e-8)];
    let of_reference = allowed(1e-10, 1e-11, 1e-10);
    let sets: Vec<_> = sets().into_iter().chain(elastic()).collect();
    sets.par_iter().for_each(|set| {
        let reference = Solver::new(&set.plan, &set.question.growth).unwrap();
        let found = reference.search(&task(&set.question, set.attitude));
        let found = found.unwrap_or_else(|e| panic!("{}: {e}", set.name));
        let errors = errors(found, set);
        assert!(errors.within(of_reference), "{}: {errors}", set.name);
        let at_rest = (set.question.omega == 0.0).then_some(Balls::Static);
        for balls in [Balls::from(set.attitude)].into_iter().chain(at_rest) {
            for (precision, allowed) in solves::PRECISIONS.into_iter().zip(bounds) {
                let found = ask(&set.plan, balls, precision, &set.question);
                let found = found.unwrap_or_else(|e| panic!("{}: {e}", set.name));
                let errors = errors_of_answer(&found, set);
                assert!(errors.within(allowed), "{}: {errors}", set.name);
            }
        }
    });
}

const FREE: Balls = Balls::Free;

/// NTN's 7014C with the model's groove factors, of steel.
const D7014C: Design = Design::angular_contact(11.906e-3, 90e-3, 15.0 * PI / 180.0);

fn row(position: f64, facing: char, preload: Preload<f64>) -> Row {
    Row {
        balls: 20,
        design: D7014C,
        position,
        facing: match facing {
            '+' => Facing::PlusX,
            _ => Facing::MinusX,
        },
        preload,
    }
}

/// A set of 7014C at these positions, `+` and `-` for how they face.
fn clamped(layout: &[(f64, char)], preload: Preload<f64>) -> Plan {
    let rows = layout.iter().map(|&(x, facing)| row(x, facing, preload));
    Plan::of(rows.collect())
}

fn pair(force: f64) -> Plan {
    clamped(&[(0.0, '+'), (0.027, '-')], Preload::Force(force))
}

/// Two rows in front, and two in a sleeve at the rear.
fn sprung() -> Plan {
    let rows = vec![
        row(0.0, '+', Preload::Closure(4e-6)),
        row(0.027, '+', Preload::Closure(6e-6)),
        row(0.225, '-', Preload::Spring),
        row(0.252, '-', Preload::Spring),
    ];
    Plan {
        arrangement: Arrangement::BackToBack,
        spring: Some(600.0),
        ..Plan::of(rows)
    }
}

fn solve(plan: &Plan, balls: Balls, question: &Question) -> Answer {
    let asked = ask(plan, balls, Precision::F64, question);
    asked.unwrap_or_else(|e| panic!("{e}"))
}

fn loaded(load: [f64; 5], rpm: f64) -> Question {
    Question::load(load, rad_per_s(rpm))
}

const SKEW: [f64; 5] = [150.0, 400.0, -250.0, 3.0, 8.0];

#[test]
fn a_single_row_is_the_plain_solver_to_the_bit() {
    let mut plan = clamped(&[(0.0, '+')], Preload::Closure(0.0));
    plan.rows[0].balls = 16;
    // Under inner race control at rest, too, where nothing turns.
    for balls in [FREE, Balls::Static, Balls::Inner] {
        for precision in solves::PRECISIONS {
            let mut plain = solves::solver(&D7014C, 16, precision, balls);
            let compare = |solver: &mut dyn AnySolver| {
                for step in 0..200 {
                    // Near loads, and far ones that are solved cold.
                    let part = 1.0 + 0.01 * f64::from(step % 20) + f64::from(step / 20);
                    let [fx, fy, fz, my, mz] = SKEW.map(|load| load * part);
                    let load = [4.0 * fx, fy, fz, my, mz];
                    let omega = if balls == FREE { 300.0 * part } else { 0.0 };
                    let found = [&mut *solver, &mut *plain].map(|solver| {
                        let found = solver.load(load, omega)?;
                        let balls = found.rows[0].balls.clone();
                        Ok::<_, Status<f32>>((
                            found.displacement,
                            found.stiffness,
                            balls,
                            found.error,
                        ))
                    });
                    assert_eq!(found[0], found[1], "{step}");
                }
            };
            with_solver(&plan, balls, precision, compare).unwrap();
        }
    }
}

#[test]
fn a_mirrored_set_has_the_mirrored_result() {
    let of_three = [(0.0, '+'), (0.05, '-'), (0.2, '-')];
    let mut deep_grooves = clamped(&[(0.0, '+'), (0.15, '-')], Preload::Closure(0.0));
    for row in &mut deep_grooves.rows {
        (row.design, row.balls) = (SKF6205, 9);
    }
    let [fx, fy, fz, my, mz] = SKEW;
    let question = loaded([4.0 * fx, fy, fz, my, mz], 9000.0);
    let back = Question {
        load: mirrored(question.load),
        ..question.clone()
    };
    for plan in [
        sprung(),
        clamped(&of_three, Preload::Force(200.0)),
        clamped(&[(0.02, '+')], Preload::Closure(0.0)),
        deep_grooves,
    ] {
        let mut other = plan.clone();
        for row in &mut other.rows {
            row.position = -row.position;
            row.facing = match row.facing {
                Facing::PlusX => Facing::MinusX,
                Facing::MinusX => Facing::PlusX,
            };
        }
        for (precision, bound) in solves::PRECISIONS.into_iter().zip([1e-5, 1e-11]) {
            let [a, b] = [(&plan, &question), (&other, &back)]
                .map(|(plan, question)| ask(plan, FREE, precision, question).unwrap());
            let off = off_mirror(&a, &b, &plan.rows[0].design);
            assert!(off < bound, "{precision:?}: {off:e}");
        }
    }
}

/// The compliance is the inverse of the stiffness.
fn assert_inverse(at: &AtEnd) {
    for i in 0..5 {
        for j in 0..5 {
            let product = |l: usize| at.stiffness[i][l] * at.compliance[l][j];
            let sum: f64 = (0..5).map(product).sum();
            let unit = f64::from(u8::from(i == j));
            let scale = (at.compliance[j][j] / at.compliance[i][i]).sqrt();
            assert!((sum - unit).abs() < 1e-10 * scale, "{sum}");
        }
    }
}

/// Another point x = 0 changes the figures as it does for any rigid body.
#[test]
fn another_point_of_reference_transforms_the_result() {
    let plan = sprung();
    let d = 0.08;
    let mut moved = plan.clone();
    for row in &mut moved.rows {
        row.position -= d;
    }
    let [fx, fy, fz, my, mz] = SKEW;
    let a = solve(&plan, FREE, &loaded(SKEW, 9000.0).at(d));
    // The load about the point that is x = 0 now.
    let load = [fx, fy, fz, my + d * fz, mz - d * fy];
    let b = solve(&moved, FREE, &loaded(load, 9000.0).at(0.0));
    let [dx, dy, dz, ty, tz] = a.displacement;
    let there = [dx, dy + d * tz, dz - d * ty, ty, tz];
    assert!(vector_error(b.displacement, there, [1.0; 5]) < 1e-11);
    assert!(stiffness_error(&b.stiffness, &a.at[0].stiffness) < 1e-11);
    assert!(stiffness_error(&b.at[0].stiffness, &a.at[0].stiffness) < 1e-10);
    assert!(stiffness_error(&b.at[0].compliance, &a.at[0].compliance) < 1e-10);
    assert_inverse(&a.at[0]);
    for (a, b) in a.rows.iter().zip(&b.rows) {
        assert!((a.force[0] / b.force[0] - 1.0).abs() < 1e-11);
    }
}

/// A shaft that yields at its nose, adds its flexibility to the compliance there.
#[test]
fn the_stiffness_at_a_nose_that_yields_is_the_inverse_of_its_compliance() {
    let flexibility = [1e-9, 4e-9, 4e-9, 1.2e-6, 1.2e-6];
    let mut question = loaded(SKEW, 9000.0).at(-0.1);
    let rigid = solve(&sprung(), FREE, &question);
    question.ends[0].flexibility = flexibility;
    let yielding = solve(&sprung(), FREE, &question);
    for i in 0..5 {
        for j in 0..5 {
            let [c, of_rigid] = [&yielding, &rigid].map(|answer| answer.at[0].compliance[i][j]);
            let [ci, cj] = [i, j].map(|l| yielding.at[0].compliance[l][l]);
            let by = if i == j { flexibility[i] } else { 0.0 };
            assert!((c - of_rigid - by).abs() < 1e-12 * (ci * cj).sqrt());
        }
    }
    assert_inverse(&yielding.at[0]);
}

/// Forces of the rows on the shaft, about x = 0.
fn on_shaft(plan: &Plan, answer: &Answer) -> [f64; 5] {
    let mut sum = [0.0; 5];
    for (row, plan) in answer.rows.iter().zip(&plan.rows) {
        let (x, s) = (plan.position, plan.facing.sign::<f64>());
        let [fx, fy, fz, my, mz] = row.force;
        let row = [s * fx, fy, fz, s * my - x * fz, s * mz + x * fy];
        for (sum, f) in sum.iter_mut().zip(row) {
            *sum += f;
        }
    }
    sum
}

/// A light rear row, clamped or in a sleeve, changes most: the tilt stiffness by its distance, or its
/// sleeve's stiffness.
#[test]
fn a_set_that_tilts_states_true_errors_of_its_stiffness_the_same_about_any_axis() {
    for (preload, spring) in [
        (Preload::Closure(1e-6), None),
        (Preload::Spring, Some(20.0)),
    ] {
        let mut plan = clamped(
            &[(0.0, '-'), (0.025, '+'), (0.325, '-')],
            Preload::Closure(12e-6),
        );
        plan.spring = spring;
        plan.rows[2] = Row {
            balls: 16,
            design: B7005C,
            ..row(0.325, '-', preload)
        };
        let tilted = |axis: usize| {
            let ask = |solver: &mut dyn AnySolver, tolerance| -> Vec<Answer> {
                solver.choose(&Choices {
                    tolerance: Some(tolerance),
                    ..Choices::default()
                });
                let load = |i| {
                    let mut load = [0.0; 5];
                    load[axis] = 2.5 * f64::from(i * (i % 2));
                    load
                };
                (0..24)
                    .map(|i| solver.load(load(i), 600.0).unwrap())
                    .collect()
            };
            let [coarse, fine] = [3e-3, 3e-13].map(|tolerance| {
                with_solver(&plan, FREE, Precision::F64, |solver| ask(solver, tolerance)).unwrap()
            });
            let stated: Vec<f64> = coarse.iter().map(|answer| answer.error[2]).collect();
            let off = coarse.iter().zip(&fine);
            let off = off.map(|(a, b)| stiffness_error(&a.stiffness, &b.stiffness));
            let mut ratios: Vec<f64> = stated.iter().zip(off).map(|(a, b)| a / b).collect();
            ratios.sort_by(f64::total_cmp);
            let are_true = ratios[0] >= 1.0 && ratios[ratios.len() / 2] < 50.0;
            assert!(are_true, "{spring:?}: {ratios:?}");
            stated
        };
        for (y, z) in tilted(3).into_iter().zip(tilted(4)) {
            assert!((y / z - 1.0).abs() < 1e-9, "{spring:?}: {y:e} {z:e}");
        }
    }
}

/// The figures of the model's page, which two other programs have found.
#[test]
fn a_pair_of_7014c_is_as_stiff_as_the_model_says() {
    let pair = |[a, b]: [char; 2]| clamped(&[(-0.0135, a), (0.0135, b)], Preload::Force(294.0));
    let (back, face) = (pair(['+', '-']), pair(['-', '+']));
    for (rpm, [axial, radial, preload]) in [
        (0.0, [92.8, 526.7, 294.0]),
        (10_000.0, [66.3, 274.7, 727.0]),
        (20_000.0, [101.7, 253.0, 1785.0]),
    ] {
        let found = solve(&back, FREE, &loaded([0.0; 5], rpm));
        for (i, expected) in [axial, radial].into_iter().enumerate() {
            let k = found.stiffness[i][i] / 1e6;
            assert!((k - expected).abs() < 0.06, "{rpm}: {k}");
        }
        for row in &found.rows {
            assert!((row.preload - preload).abs() < 0.6, "{}", row.preload);
        }
    }
    // The nose is 60 mm in front of the first row. There, the arrangement shows.
    for (plan, tilting, nose) in [(&back, 3.75e5, 61.4), (&face, 5.0e3, 0.923)] {
        let found = solve(plan, Balls::Static, &loaded([0.0; 5], 0.0).at(-0.0735));
        let tilt = found.stiffness[3][3] / tilting;
        assert!((tilt - 1.0).abs() < 0.01, "{tilt}");
        let radial = 1e-6 / found.at[0].compliance[1][1] / nose;
        assert!((radial - 1.0).abs() < 0.01, "{radial}");
    }
}

/// A random spindle that a designer might draw: one to four rows of one or two kinds, clamped or with a
/// sleeve. Its loads are about as large as its preload, and it has grown a little.
pub fn random(seed: u64) -> (Plan, Attitude, Question) {
    let mut r = Random::seeded(seed);
    let kinds = [Case::random(seed), Case::random(seed ^ 0x55)];
    // Bearings of one shaft have about one size.
    let size = kinds[0].design.ball_diameter / kinds[1].design.ball_diameter;
    let second = r.chance(0.3) && (0.5..2.0).contains(&size);
    let count = r.between(1.0, 4.99) as usize;
    let face_to_face = r.chance(0.5);
    let spring = count > 1 && r.chance(0.3);
    let width = 0.3 * kinds[0].design.pitch_diameter;
    let [mut x, mut limit, mut preload] = [-width, f64::INFINITY, f64::INFINITY];
    let turn = r.between(1.0, count as f64) as usize;
    let rows: Vec<Row> = (0..count)
        .map(|i| {
            let kind = &kinds[usize::from(second && i >= turn)];
            x += match i == turn {
                true => width * r.log_between(1.0, 10.0),
                false => width,
            };
            let design = kind.design;
            let rating = 12e6 * kind.balls as f64 * design.ball_diameter.powi(2);
            preload = preload.min(rating * r.log_between(2e-3, 5e-2));
            limit = limit.min(1500.0 / design.pitch_diameter);
            let first = i < turn;
            let preload = match spring && !first {
                true => Preload::Spring,
                // A force's closure; for sets whose rows do not face each other, too.
                false => Preload::Closure(design.centre_distance() * r.log_between(2e-3, 5e-2)),
            };
            Row {
                balls: kind.balls,
                design,
                ..row(x, if first == face_to_face { '-' } else { '+' }, preload)
            }
        })
        .collect();
    let rpm = match r.chance(0.2) {
        true => 0.0,
        false => r.between(0.0, limit),
    };
    let (to, about) = (r.between(0.0, TAU), r.between(0.0, TAU));
    let [axial, radial, moment] = [0.5, 1.0, 0.5].map(|most| r.between(0.0, most) * preload);
    let span = 0.5 * kinds[0].design.pitch_diameter;
    let alone = rows.iter().all(|row| row.facing == rows[0].facing);
    let pressing = match alone {
        true => 3.0 * preload * rows[0].facing.sign::<f64>(),
        false => 0.0,
    };
    let growth = rows.iter().map(|row| {
        let l0 = row.design.centre_distance();
        Growth {
            axial: 0.0,
            radial: l0 * r.between(0.0, 0.01),
            ball: l0 * r.between(0.0, 0.002),
        }
    });
    let growth = growth.collect();
    let load = [
        axial + pressing,
        radial * to.cos(),
        radial * to.sin(),
        moment * span * about.cos(),
        moment * span * about.sin(),
    ];
    let plan = Plan {
        spring: spring.then_some(preload),
        ..Plan::of(rows)
    };
    let question = Question {
        growth,
        ..loaded(load, rpm)
    };
    let attitude = match kinds[0].attitude {
        // Inner race control is not for loads that lift balls off, as those of many rows do.
        Attitude::Inner if count > 2 => Attitude::Raceless,
        attitude => attitude,
    };
    (plan, attitude, question)
}

/// Both precisions' answers to a random spindle, unless one refuses it.
fn in_both(plan: &Plan, attitude: Attitude, question: &Question) -> Option<[Answer; 2]> {
    let found = |precision| found(plan, attitude.into(), precision, question);
    Some([found(Precision::F64)?, found(Precision::F32)?])
}

/// Displacement of a row's ring, in its own frame, for one of the shaft at `x = 0`; `spring` is the closure of a sprung row.
pub fn displacement_of(row: &Row, [dx, dy, dz, ty, tz]: [f64; 5], spring: Option<f64>) -> [f64; 5] {
    let (x, s) = (row.position, row.facing.sign::<f64>());
    let closure = clamped_by(row).or(spring).expect("a closure");
    [s * dx + closure, dy + x * tz, dz - x * ty, s * ty, s * tz]
}

fn largest_force(answer: &Answer) -> f64 {
    largest(answer.rows.iter().flat_map(|row| row.force[..3].to_vec()))
}

/// Distance of the rows' forces from the reference build's law, over the largest force. The rows are clamped and have not
/// grown.
///
/// # Panics
///
/// If the law does not cover a row that carries.
fn off_law(plan: &Plan, attitude: Attitude, omega: f64, answer: &Answer) -> f64 {
    let rows = plan.rows.iter().zip(&answer.rows);
    rows.fold(0.0, |off, (row, found)| {
        let case = Case {
            name: String::new(),
            balls: row.balls,
            design: row.design,
            attitude,
            load: found.force,
            omega,
        };
        let u = displacement_of(row, answer.displacement, None);
        let Ok(truth) = case.reference().law(u, omega, attitude) else {
            assert!(found.balls.iter().all(|ball| ball.q_i == 0.0), "{plan:?}");
            return off;
        };
        let apart = from_fn(|i| found.force[i] - truth[i]);
        let of_row = solves::size(apart, solves::forces(&row.design));
        worse(off, of_row / largest_force(answer))
    })
}

/// Distance of the shaft from balance, over the largest force.
pub fn off_balance(plan: &Plan, question: &Question, answer: &Answer) -> f64 {
    let sum = on_shaft(plan, answer);
    let span =
        largest(plan.rows.iter().map(|row| row.position)) + plan.rows[0].design.pitch_diameter;
    let unit = [1.0, 1.0, 1.0, 1.0 / span, 1.0 / span];
    let left = from_fn(|i| sum[i] - question.load[i]);
    solves::size(left, unit) / largest_force(answer)
}

/// Clamped rows that face each other hold nearly any shaft, cold from the first solve on. Each row
/// carries the reference build's forces at its displacement.
#[test]
fn random_clamped_spindles_are_what_the_reference_build_says() {
    let lost = AtomicUsize::new(0);
    let judge = |seed: u64| {
        let (plan, attitude, question) = random(seed);
        let first = plan.rows[0].facing;
        if plan.spring.is_some() || plan.rows.iter().all(|row| row.facing == first) {
            return false;
        }
        let cold = Question {
            growth: Vec::new(),
            ..question.clone()
        };
        for question in [&question, &cold] {
            let Some([a, b]) = in_both(&plan, attitude, question) else {
                lost.fetch_add(1, Relaxed);
                return false;
            };
            let single = stiffness_error(&b.stiffness, &a.stiffness);
            assert!(single < 5e-5, "{seed}: {single:e}");
        }
        let found = solve(&plan, Balls::from(attitude), &cold);
        let law = off_law(&plan, attitude, cold.omega, &found);
        let balance = off_balance(&plan, &cold, &found);
        assert!(law < 1e-12, "{seed}: {law:e}");
        assert!(balance < 1e-13, "{seed}: {balance:e}");
        true
    };
    let judged = (0..600).into_par_iter().filter(|seed| judge(*seed)).count();
    assert!(judged > 200, "{judged}");
    // One of them, in which a ball swings against the inner race.
    assert!(lost.into_inner() <= 1);
}

/// A ball that hardly presses the outer race, next to the inner one: the least force swings it through. One in thirty of these
/// loads had no answer.
#[test]
fn balls_that_swing_against_the_inner_race_find_their_place() {
    let layout = [(0.0, '+'), (46.615e-3, '+'), (157.430e-3, '-')];
    let plan = clamped(&layout, Preload::Force(31.325));
    let solve = |solver: &mut dyn AnySolver| {
        let mut r = Random::seeded(3);
        for _ in 0..500 {
            let load = [-1042.055, -1299.63, -2167.465, 0.0, 0.0];
            let load = load.map(|f| f * r.between(0.95, 1.05));
            solver.reset();
            let found = solver.solve(&loaded(load, 100.0));
            assert!(found.is_ok(), "{load:?}: {found:?}");
        }
    };
    with_solver(&plan, FREE, Precision::F64, solve).unwrap();
}

/// Rows 1.5 m and 10 m apart, some hundred groove radii: a shaft that only its ends hold.
#[test]
fn rows_far_apart_have_the_forces_of_the_reference_build_in_both_precisions() {
    for (first, distance) in [(0.0, 1.5), (-0.75, 1.5), (0.0, 10.0), (-60.0, 10.0)] {
        let middle = first + 0.5 * distance;
        let mut plan = clamped(
            &[(first, '+'), (first + distance, '-')],
            Preload::Closure(5e-6),
        );
        for row in &mut plan.rows {
            (row.design, row.balls) = (SKF6205, 9);
        }
        let [fy, fz] = [300.0, -120.0];
        // Forces at the middle, so that the rows share them.
        let load = [60.0, fy, fz, -middle * fz, middle * fy];
        for rpm in [0.0, 6000.0] {
            let question = loaded(load, rpm).at(middle);
            let truth = solve(&plan, FREE, &question);
            let law = off_law(&plan, Attitude::Raceless, question.omega, &truth);
            let balance = off_balance(&plan, &question, &truth);
            assert!(
                law < 1e-11 && balance < 1e-13,
                "{distance}: {law:e}, {balance:e}"
            );
            let found = ask(&plan, FREE, Precision::F32, &question).unwrap();
            let [a, b] = [&found, &truth].map(|answer| answer.at[0].compliance[1][1]);
            assert!(
                (a / b - 1.0).abs() < 1e-3,
                "{first}, {distance}, {rpm}: {a:e} {b:e}"
            );
            for (found, truth) in found.rows.iter().zip(&truth.rows) {
                let off = solves::size(
                    from_fn(|i| found.force[i] - truth.force[i]),
                    solves::forces(&SKF6205),
                );
                let size = solves::size(truth.force, solves::forces(&SKF6205));
                assert!(off < 1e-3 * size, "{first}, {distance}, {rpm}: {off:e}");
            }
        }
    }
}

/// Whether inertia counts is for all rows together: one of small balls may come first.
#[test]
fn a_light_first_row_does_not_take_the_others_inertia() {
    let mut plan = clamped(&[(0.0, '+'), (0.1, '-')], Preload::Closure(10e-6));
    plan.rows[0].balls = 12;
    plan.rows[0].design = Design::angular_contact(1e-3, 6e-3, 15f64.to_radians());
    plan.rows[0].preload = Preload::Closure(0.5e-6);
    let question = loaded([-50.0, 40.0, 20.0, 0.0, 0.0], 150.0);
    let [double, single] = in_both(&plan, Attitude::Raceless, &question).unwrap();
    for (a, b) in single.rows[1].balls.iter().zip(&double.rows[1].balls) {
        let (a, b) = (a.centrifugal_force, b.centrifugal_force);
        assert!(b > 0.0 && (a / b - 1.0).abs() < 1e-4, "{a:e} {b:e}");
    }
}

/// Rows a metre apart under ten kilonewtons and closures of a millimetre: an answer is what the reference build
/// reaches from it, or there is none.
#[test]
fn answers_of_wild_spindles_are_what_the_reference_build_says() {
    let judge = |seed: u64| {
        let (mut plan, attitude, question) = random(seed);
        let mut r = Random::seeded(seed ^ 0x1234);
        for (i, row) in plan.rows.iter_mut().enumerate() {
            row.position = i as f64 + r.between(-0.4, 0.4);
            let most = 0.249 * row.design.centre_distance();
            row.preload = Preload::Closure(most.min(1e-3) * r.between(-1.0, 1.0));
        }
        plan.spring = None;
        let moment = 1e4 * r.between(-1.0, 1.0);
        let question = Question {
            load: [1e4, 1e4, 1e4, moment, moment].map(|f| f * r.between(-1.0, 1.0)),
            growth: Vec::new(),
            ..question
        };
        let Some(found) = found(&plan, attitude.into(), Precision::F64, &question) else {
            return false;
        };
        let Some(truth) = reference_near(&plan, attitude, &question, &found) else {
            return false;
        };
        let errors = Equilibrium::from(&found).errors(&truth, &plan.rows[0].design);
        let is_exact = errors.displacement < 1e-9 && errors.force < 1e-9;
        assert!(is_exact, "{seed}: {errors}");
        true
    };
    let judged = (0..5000)
        .into_par_iter()
        .filter(|seed| judge(*seed))
        .count();
    assert!(judged > 1000, "{judged}");
}

/// A spring holds its rows only as well as its force does: a light one lets the shaft's load or its speed drive balls out.
#[test]
fn most_random_sprung_spindles_are_solved() {
    let random = |seed| Some(random(seed)).filter(|(plan, ..)| plan.spring.is_some());
    let asked: Vec<_> = (0..1200).filter_map(random).collect();
    let solved: Vec<[Answer; 2]> = asked
        .par_iter()
        .filter_map(|(plan, attitude, question)| in_both(plan, *attitude, question))
        .collect();
    let (asked, count) = (asked.len(), solved.len());
    assert!(asked > 200 && count * 10 > asked * 9, "{count}");
    // Some have several equilibria, and the last of the starts may lead to another one in the other precision.
    let alike = |[a, b]: &&[Answer; 2]| stiffness_error(&b.stiffness, &a.stiffness) < 2e-4;
    let alike = solved.iter().filter(alike).count();
    assert!(100 * alike >= 99 * count, "{alike} of {count}");
}

/// The solver's memory does not drift: after many ticks, a cold solve has the result of the warm one.
#[test]
fn a_long_run_ends_where_a_cold_solve_does() {
    let at = |tick: u32| {
        let phase = 0.07 * f64::from(tick);
        let (sin, cos) = phase.sin_cos();
        let part = [sin, cos, (1.7 * phase).sin(), 1.0, cos];
        let load = from_fn(|i| SKEW[i] * part[i]);
        let growth = Growth {
            radial: 1e-6 * (1.0 + (0.003 * phase).sin()),
            ..Growth::NONE
        };
        loaded(load, 8000.0 + 4000.0 * (0.01 * phase).sin()).grown(growth)
    };
    const TICKS: u32 = 20_000;
    for plan in [&pair(294.0), &sprung()] {
        let run = |solver: &mut dyn AnySolver| {
            for tick in 0..TICKS - 1 {
                solver.solve(&at(tick)).unwrap();
            }
            let mut last = || solver.solve(&at(TICKS - 1)).unwrap();
            let warm = last();
            solver.reset();
            (warm, solver.solve(&at(TICKS - 1)).unwrap())
        };
        let (warm, cold) = with_solver(plan, FREE, Precision::F32, run).unwrap();
        assert!(stiffness_error(&warm.stiffness, &cold.stiffness) < 2e-5);
        for (warm, cold) in warm.rows.iter().zip(&cold.rows) {
            let off = (warm.force[0] / cold.force[0] - 1.0).abs();
            assert!(off < 2e-6, "{off:e}");
        }
    }
}

#[test]
fn rows_that_are_no_such_set_are_refused() {
    use Arrangement::{BackToBack, ByRows, FaceToFace, Tandem};
    let preload = Preload::Force(294.0);
    let called = |layout: [(f64, char); 2], arrangement| Plan {
        arrangement,
        ..clamped(&layout, preload)
    };
    let held = |preload| clamped(&[(0.0, '+'), (0.027, '-')], preload);
    let with_spring = |plan: Plan, spring| Plan { spring, ..plan };
    // Two rows in a sleeve that face as the clamped ones do.
    let mut one_way = sprung();
    for row in &mut one_way.rows {
        row.facing = Facing::PlusX;
    }
    one_way.arrangement = ByRows;
    let near = "mm away, nearer than half a ball's diameter, 5.953 mm";
    for (plan, part) in [
        (
            called([(0.0, '-'), (0.027, '+')], BackToBack),
            "row 1 faces +x, which is not back-to-back",
        ),
        (
            called([(0.0, '+'), (0.027, '-')], FaceToFace),
            "row 1 faces -x, which is not face-to-face",
        ),
        (
            called([(0.0, '+'), (0.027, '-')], Tandem),
            "which is not tandem",
        ),
        (
            called([(0.0, '+'), (0.027, '+')], BackToBack),
            "which is not back-to-back",
        ),
        (called([(0.0, '+'), (0.0, '-')], BackToBack), near),
        (called([(0.0, '+'), (0.0059, '-')], BackToBack), near),
        (
            called([(0.0, '+'), (0.027, '+')], Tandem),
            "row 0 is preloaded, but no clamped row faces it",
        ),
        (
            called([(0.0, '+'), (f64::NAN, '-')], BackToBack),
            "row 1: `position_mm` is NaN, but must lie within",
        ),
        (
            called([(0.0, '+'), (1e9, '-')], BackToBack),
            "row 1: `position_mm` is 1000000000000, but must lie within",
        ),
        (
            called([(1e9, '+'), (1e9 + 0.1, '-')], BackToBack),
            "row 0: `position_mm` is 1000000000000, but must lie within",
        ),
        (
            held(Preload::Force(-1.0)),
            "row 0: preload force of the pair (N) is -1, but must be above 0",
        ),
        (
            held(Preload::Closure(f64::INFINITY)),
            "row 0: closure e of the row (m) is inf",
        ),
        (
            held(Preload::Spring),
            "nothing holds the shaft along its axis",
        ),
        (with_spring(held(preload), Some(100.0)), "no row slides"),
        (with_spring(sprung(), None), "but there is no spring"),
        (
            with_spring(sprung(), Some(0.0)),
            "row 2: force of the spring (N) is 0, but must be above 0",
        ),
        (
            with_spring(sprung(), Some(f64::NAN)),
            "row 2: force of the spring (N) is NaN",
        ),
        (one_way, "row 2 is preloaded, but no clamped row faces it"),
    ] {
        let refused = with_solver(&plan, FREE, Precision::F64, |_| ());
        let told = refused.unwrap_err().to_string();
        assert!(told.contains(part), "{told}\nwithout: {part}");
    }
}

/// With any number of rows, on a shaft that bends, too: at rest all motions have one rigidity, at speed the rows balance the load.
#[test]
fn every_motion_is_solved_for_every_number_of_rows() {
    let plans = (1..=MOST_ROWS).flat_map(|rows| {
        let layout = (0..rows).map(|i| (0.03 * i as f64, if i == 0 { '+' } else { '-' }));
        let rigid = clamped(&layout.collect::<Vec<_>>(), Preload::Closure(5e-6));
        let mut bends = rigid.clone();
        bends.shaft = Some(ElasticShaft::of(
            vec![Section {
                from: -0.1,
                to: 0.4,
                outer: 0.07,
                inner: 0.04,
            }],
            vec![
                Support {
                    radial: 3e8,
                    ..Support::RIGID
                };
                rows
            ],
        ));
        [rigid, bends]
    });
    let (load, motions) = (
        [400.0, 80.0, 0.0, 0.0, 0.0],
        [
            Balls::Static,
            Balls::Centrifugal,
            Balls::CentrifugalOuter,
            Balls::Outer,
            Balls::Inner,
        ],
    );
    for (plan, precision) in plans.flat_map(|plan| solves::PRECISIONS.map(|of| (plan.clone(), of)))
    {
        let default = ask(&plan, FREE, precision, &loaded(load, 0.0)).unwrap();
        for balls in motions {
            let [at_rest, at_speed] =
                [0.0, 8e3].map(|rpm| ask(&plan, balls, precision, &loaded(load, rpm)).unwrap());
            let off = stiffness_error(&at_rest.stiffness, &default.stiffness);
            let rows = plan.rows.iter().zip(&at_speed.rows);
            let axial = rows.map(|(row, of)| row.facing.sign::<f64>() * of.force[0]);
            let radial = at_speed.rows.iter().map(|row| row.force[1]);
            let left = [axial.sum::<f64>() - load[0], radial.sum::<f64>() - load[1]];
            assert!(off < 1e-5, "{balls:?}, {} rows: {off:e}", plan.rows.len());
            assert!(
                left.iter().all(|left| left.abs() < 0.02),
                "{balls:?}: {left:?}"
            );
        }
    }
}

/// A radial load drives the balls opposite to it out of both rows' grooves, the heavier one further.
#[test]
fn of_balls_driven_out_of_several_rows_the_one_whose_contacts_are_furthest_apart_is_named() {
    let mut heavy = B218;
    heavy.ball.density *= 1.3;
    let pair = clamped(&[(0.0, '+'), (0.1, '+')], Preload::Closure(1e-6));
    for (i, designs) in [[heavy, B218], [B218, heavy]].into_iter().enumerate() {
        let mut plan = pair.clone();
        for (row, design) in plan.rows.iter_mut().zip(designs) {
            (row.design, row.balls) = (design, 16);
        }
        for precision in solves::PRECISIONS {
            let question = Question {
                omega: 1000.0,
                ..loaded([10.0, 5500.0, 0.0, 0.0, 0.05 * 5500.0], 0.0)
            };
            match ask(&plan, FREE, precision, &question) {
                Err(Status::Unseated { ball, apart }) => {
                    assert_eq!(usize::from(ball), 16 * i + 8, "{apart}");
                }
                other => panic!("{precision:?}: {other:?}"),
            }
        }
    }
}

/// From nothing: without a load, the rows are where the closure has put them.
#[test]
fn a_pair_that_only_its_preload_presses_is_known_to_some_roundings_of_single_precision() {
    for i in 0..50 {
        let plan = pair(f64::from(0.2 * 1.15f32.powi(i)));
        let [found, truth] = [Precision::F32, Precision::F64]
            .map(|precision| ask(&plan, Balls::Static, precision, &loaded([0.0; 5], 0.0)))
            .map(Result::unwrap);
        let off = stiffness_error(&found.stiffness, &truth.stiffness);
        assert!(off < 2e-6 && off <= found.error[2], "{i}: {off:e}");
        for (found, truth) in found.rows.iter().zip(&truth.rows) {
            let off = (found.preload / truth.preload - 1.0).abs();
            assert!(off < 2e-6, "{i}: {off:e}");
        }
    }
}

/// The axial load that lifts a side off is a little more than the maker's, whose contact angle does not grow with the load.
#[test]
fn a_row_that_has_lifted_off_says_so() {
    let rows = |factor: f64| {
        let pushed = loaded([factor * 300.0, 0.0, 0.0, 0.0, 0.0], 0.0);
        let [a, b] = <[_; 2]>::try_from(solve(&pair(300.0), Balls::Static, &pushed).rows).unwrap();
        (a.preload, b.preload, b.lifted_off)
    };
    let (a, b, off) = rows(2.5);
    assert!(a > 5.0 && (a - b).abs() < 1e-9 && !off, "{a} {b}");
    assert_eq!(rows(4.0), (0.0, 0.0, true));
}
