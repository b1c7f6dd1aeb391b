//! Spindles with an elastic shaft on elastic supports.

use super::solves::{self, vector_error};
use super::spindles::{displacement_of, largest, off_balance, random};
use super::textbook::{unbalanced, unclosed};
use files::plan::{ElasticShaft, Plan, Question};
use host_tests::cases::{B7005C, Random, SolvedElastic, elastic};
use host_tests::compare::{stiffness_error, worse};
use host_tests::dispatch::{Attitude, Precision};
use host_tests::spindles::{Answer, AnySpindleSolver, Balls, Choices, with_solver};
use rayon::prelude::*;
use spindle_bearing::{
    Arrangement, Facing, Material, Preload, Section, ShaftEnd, ShaftLoad, Support,
};
use std::array::from_fn;
use std::f64::consts::PI;

/// Errors of an answer: displacements, forces of rows, contact forces, stiffness, flexibility of the nose.
fn errors(found: &Answer, case: &SolvedElastic) -> [f64; 5] {
    let set = &case.set;
    let design = &set.plan.rows[0].design;
    let (lengths, forces) = (solves::lengths(design), solves::forces(design));
    let at = |found, truth| vector_error(found, truth, lengths);
    let mut errors = [0.0; 5];
    errors[0] = worse(
        at(found.displacement, set.displacement),
        at(found.at[0].displacement, case.at_nose.displacement),
    );
    let of_rows = set.rows.iter().map(|row| solves::size(row.load, forces));
    let of_rows = of_rows.fold(0.0, worse);
    let balls = set.rows.iter().flat_map(|r| r.balls.iter().map(|b| b[3]));
    let of_balls = balls.fold(0.0, worse);
    for (found, truth) in found.rows.iter().zip(&set.rows) {
        errors[0] = worse(errors[0], at(found.displacement, truth.displacement));
        let off = std::array::from_fn(|i| found.force[i] - truth.load[i]);
        errors[1] = worse(errors[1], solves::size(off, forces) / of_rows);
        for (ball, truth) in found.balls.iter().zip(&truth.balls) {
            let [_, _, q_i, q_o] = *truth;
            let off = (ball.q_i - q_i).abs().max((ball.q_o - q_o).abs());
            errors[2] = worse(errors[2], off / of_balls);
        }
    }
    errors[3] = stiffness_error(&found.stiffness, &set.stiffness);
    errors[4] = stiffness_error(&found.at[0].compliance, &case.at_nose.flexibility);
    errors
}

#[test]
fn solved_elastic_sets_are_solved_in_both_precisions() {
    let bounds = [
        (Precision::F64, [1e-9, 1e-9, 1e-9, 1e-8, 1e-8]),
        (Precision::F32, [1e-5, 1e-4, 1e-4, 1e-3, 1e-3]),
    ];
    elastic().par_iter().for_each(|case| {
        for (precision, bounds) in bounds {
            let ends = [ShaftEnd::rigid(case.nose)];
            let balls = Balls::Moving(case.set.attitude);
            let found = with_solver(&case.set.plan, balls, precision, |solver| {
                solver.solve(&case.set.question, &ends)
            });
            let name = &case.set.name;
            let found = found.unwrap_or_else(|e| panic!("{name}: {e}"));
            let found = found.unwrap_or_else(|e| panic!("{name} {precision:?}: {e}"));
            let errors = errors(&found, case);
            let within = errors.iter().zip(bounds).all(|(e, bound)| *e <= bound);
            assert!(within, "{name} {precision:?}: {errors:?}");
        }
    });
}

/// Deflection of the shaft at `x` by a load at `at`, clamped at 0: the integrals of a cantilever, by two points of Gauss on each
/// part of a section, which is exact.
fn cantilever(shaft: &ElasticShaft, x: f64, at: f64, load: [f64; 5]) -> [f64; 5] {
    let end = x.abs().min(at.abs());
    if x * at <= 0.0 {
        return [0.0; 5];
    }
    let (e, nu) = (shaft.material.youngs_modulus, shaft.material.poissons_ratio);
    let mut u = [0.0; 5];
    for section in &shaft.sections {
        let ends = [section.from * x.signum(), section.to * x.signum()];
        let (from, to) = (ends[0].min(ends[1]).max(0.0), ends[0].max(ends[1]).min(end));
        if to <= from {
            continue;
        }
        let (outer, inner) = (section.outer, section.inner);
        let area = PI / 4.0 * (outer.powi(2) - inner.powi(2));
        let second = PI / 64.0 * (outer.powi(4) - inner.powi(4));
        let (m, shear) = ((inner / outer).powi(2), e / 2.0 / (1.0 + nu));
        let kappa = 6.0 * (1.0 + nu) * (1.0 + m).powi(2)
            / ((7.0 + 6.0 * nu) * (1.0 + m).powi(2) + (20.0 + 12.0 * nu) * m);
        for side in [-1.0, 1.0] {
            let xi = 0.5 * ((from + to) + side * (to - from) / 3f64.sqrt());
            let weight = 0.5 * (to - from);
            let (a, b, s) = (x.abs() - xi, at.abs() - xi, x.signum());
            let [fx, fy, fz, my, mz] = load;
            // Moments here, and what the curvature does at x.
            let (about_y, about_z) = (my - s * b * fz, mz + s * b * fy);
            let bent = weight / (e * second);
            u[0] += weight / (e * area) * fx;
            u[1] += bent * s * a * about_z + weight / (kappa * shear * area) * fy;
            u[2] += -bent * s * a * about_y + weight / (kappa * shear * area) * fz;
            u[3] += bent * about_y;
            u[4] += bent * about_z;
        }
    }
    u
}

/// How far an answer is from satisfying the equations: of balance, of every ball, of the shaft and its supports. Forces are over the
/// largest, lengths over the distance of the groove centres and the deflections that add up to a row's. Rows are clamped.
fn off_equations(
    plan: &Plan,
    attitude: Attitude,
    question: &Question,
    answer: &Answer,
) -> [f64; 4] {
    let shaft = plan.shaft.as_ref().expect("an elastic shaft");
    let forces: Vec<[f64; 5]> = plan
        .rows
        .iter()
        .zip(&answer.rows)
        .map(|(row, found)| {
            let s = row.facing.sign::<f64>();
            from_fn(|i| [s, 1.0, 1.0, s, s][i] * found.force[i])
        })
        .collect();
    let mut off = [off_balance(plan, question, answer), 0.0, 0.0, 0.0];
    for (number, (row, found)) in plan.rows.iter().zip(&answer.rows).enumerate() {
        let x = row.position;
        let [dx, dy, dz, ty, tz] = answer.displacement;
        let lengths = solves::lengths(&row.design);
        let mut u = [dx, dy + x * tz, dz - x * ty, ty, tz];
        let mut size = solves::size(u, lengths).max(row.design.centre_distance());
        for (at, force) in plan.rows.iter().zip(&forces) {
            let by_row = cantilever(shaft, x, at.position, *force);
            u = from_fn(|i| u[i] - by_row[i]);
            size += solves::size(by_row, lengths);
        }
        let apart = from_fn(|i| u[i] - found.displacement[i]);
        off[1] = worse(off[1], solves::size(apart, lengths) / size);
        let Support {
            axial,
            radial,
            tilting,
        } = shaft.supports[number];
        let stiffness = [axial, radial, radial, tilting, tilting];
        u = from_fn(|i| u[i] - forces[number][i] / stiffness[i]);
        let at_row = |u: [f64; 5]| {
            let alone = files::plan::Row {
                position: 0.0,
                ..row.clone()
            };
            displacement_of(&alone, u, Some(answer.spring_closure))
        };
        let open = unclosed(&row.design, at_row(u), &found.balls) / size;
        let force = largest(found.balls.iter().map(|ball| ball.q_i.max(ball.q_o)));
        let left = unbalanced(&row.design, attitude, &found.balls);
        off[2] = worse(off[2], open);
        off[3] = worse(off[3], left / force.max(f64::MIN_POSITIVE));
    }
    off
}

/// A random spindle on a random shaft: up to four sections, some with gaps between them; most rows on elastic supports.
pub fn random_elastic(seed: u64) -> (Plan, Attitude, Question) {
    let (mut plan, attitude, question) = random(seed);
    let mut r = Random::seeded(seed ^ 0xe1a5);
    let size = plan.rows[0].design.pitch_diameter;
    let shift = r.between(-2.0, 3.0) * size;
    for row in &mut plan.rows {
        row.position += shift;
    }
    let mut at = plan.rows[0].position.min(0.0) - size;
    let mut sections = Vec::new();
    for _ in 0..1 + r.below(4) {
        at += r.zero_or(0.7, 0.0, 0.5 * size);
        let from = at;
        at += size * r.log_between(0.3, 4.0);
        let outer = size * r.log_between(0.3, 0.9);
        let inner = outer * r.zero_or(0.5, 0.0, 0.8);
        sections.push(Section {
            from,
            to: at,
            outer,
            inner,
        });
    }
    let stiff = 1e10 * size;
    let mut one = |rigid: f64, least: f64| match r.chance(rigid) {
        true => f64::INFINITY,
        false => stiff * r.log_between(least, 10.0),
    };
    let supports = plan.rows.iter().map(|_| Support {
        axial: one(0.4, 0.05),
        radial: one(0.4, 0.05),
        tilting: one(0.6, 0.05) * size * size,
    });
    plan.shaft = Some(ElasticShaft {
        supports: supports.collect(),
        sections,
        material: Material::STEEL,
        loads: Vec::new(),
        loaded_at: 0.0,
    });
    (plan, attitude, question)
}

fn solve(
    plan: &Plan,
    attitude: Attitude,
    precision: Precision,
    question: &Question,
) -> Result<Answer, String> {
    let end = ShaftEnd::rigid(plan.rows[0].position - plan.rows[0].design.pitch_diameter);
    let ask = |solver: &mut dyn AnySpindleSolver| solver.solve(question, &[end]);
    let solved = with_solver(plan, Balls::Moving(attitude), precision, ask);
    solved
        .map_err(|e| e.to_string())?
        .map_err(|e| e.to_string())
}

fn is_opposed(plan: &Plan) -> bool {
    plan.spring.is_none()
        && plan
            .rows
            .iter()
            .any(|row| row.facing != plan.rows[0].facing)
}

/// Sets that are not solved, and answers that do not satisfy the equations, of those that can be judged.
fn judged(seeds: std::ops::Range<u64>) -> [Vec<u64>; 3] {
    let outcomes: Vec<_> = seeds
        .into_par_iter()
        .filter_map(|seed| {
            let (plan, attitude, question) = random_elastic(seed);
            if !is_opposed(&plan) {
                return None;
            }
            let cold = Question {
                growth: Vec::new(),
                ..question.clone()
            };
            let double = solve(&plan, attitude, Precision::F64, &cold);
            let single = solve(&plan, attitude, Precision::F32, &cold);
            let missed = double.is_err() || single.is_err();
            let wrong = match (&double, &single) {
                (Ok(a), Ok(b)) => {
                    largest(off_equations(&plan, attitude, &cold, a)) > 1e-10
                        || stiffness_error(&b.stiffness, &a.stiffness) > 1e-4
                }
                (Ok(a), Err(_)) => largest(off_equations(&plan, attitude, &cold, a)) > 1e-10,
                _ => false,
            };
            Some((seed, missed, wrong))
        })
        .collect();
    let all = outcomes.iter().map(|(seed, ..)| *seed).collect();
    let missed = outcomes.iter().filter(|o| o.1).map(|o| o.0).collect();
    let wrong = outcomes.iter().filter(|o| o.2).map(|o| o.0).collect();
    [all, missed, wrong]
}

/// Clamped rows that face each other hold nearly any shaft, cold, in both precisions.
#[test]
fn random_elastic_sets_satisfy_the_equations() {
    let [all, missed, wrong] = judged(0..600);
    assert!(all.len() > 300, "{}", all.len());
    assert!(
        missed.is_empty() && wrong.is_empty(),
        "{missed:?} {wrong:?}"
    );
}

/// 20,000 sets and more, of two ranges of seeds.
#[test]
#[ignore = "takes a minute"]
fn elastic_sets_are_missed_once_in_a_thousand_and_never_wrong() {
    for first in [1_000_000, 2_000_000] {
        let [all, missed, wrong] = judged(first..first + 20_000);
        println!("{} sets, missed {missed:?}, wrong {wrong:?}", all.len());
        assert!(all.len() >= 10_000 && missed.len() * 1000 <= all.len() && wrong.is_empty());
    }
}

const SECTIONS: [Section; 2] = [
    Section {
        from: -0.05,
        to: 0.0,
        outer: 0.02,
        inner: 0.0,
    },
    Section {
        from: 0.01,
        to: 0.2,
        outer: 0.03,
        inner: 0.01,
    },
];
const NOSE: f64 = -0.05;
const BELT: ShaftLoad<f64> = ShaftLoad {
    position: 0.16,
    load: [0.0, -80.0, 0.0, 0.0, 0.5],
};

/// A pair on a stepped shaft with a gap, clamped or under a spring, pulled by a belt; and a load that acts at the nose.
fn pulled(spring: Option<f64>, at_nose: [f64; 5]) -> Plan {
    let row = |position, facing| files::plan::Row {
        balls: 16,
        design: B7005C,
        position,
        facing,
        preload: match (spring, facing) {
            (Some(_), Facing::MinusX) => Preload::Spring,
            _ => Preload::Closure(5e-6),
        },
    };
    let support = Support {
        axial: 5e8,
        radial: 3e8,
        tilting: 1e5,
    };
    let tip = ShaftLoad {
        position: NOSE,
        load: at_nose,
    };
    Plan {
        rows: vec![row(0.02, Facing::PlusX), row(0.12, Facing::MinusX)],
        arrangement: Arrangement::BackToBack,
        spring,
        mounted_preload: None,
        shaft: Some(ElasticShaft {
            sections: SECTIONS.to_vec(),
            material: Material::STEEL,
            supports: vec![support; 2],
            loads: vec![BELT, tip],
            loaded_at: 0.0,
        }),
    }
}

/// The flexibility at the nose is that of loads which act there, and displacements that are given have the loads' reactions.
#[test]
fn loads_at_the_nose_and_given_displacements_agree_with_the_tangent() {
    let question = Question {
        load: [120.0, 80.0, -30.0, 0.5, 1.0],
        omega: 1500.0,
        growth: Vec::new(),
        middle_growth: 0.0,
    };
    let solved = |plan: &Plan, choices: &Choices| {
        let ask = |solver: &mut dyn AnySpindleSolver| {
            solver.choose(choices);
            solver.solve(&question, &[ShaftEnd::rigid(NOSE)]).unwrap()
        };
        let balls = Balls::Moving(Attitude::Raceless);
        with_solver(plan, balls, Precision::F64, ask).unwrap()
    };
    for spring in [None, Some(200.0)] {
        let plan = pulled(spring, [0.0; 5]);
        let found = solved(&plan, &Choices::default());
        let c = found.at[0].compliance;
        for j in 0..5 {
            let step = if j < 3 { 1e-2 } else { 1e-4 };
            let moved = |step: f64| {
                let plan = pulled(spring, from_fn(|i| if i == j { step } else { 0.0 }));
                solved(&plan, &Choices::default()).at[0].displacement
            };
            let (up, down) = (moved(step), moved(-step));
            for i in 0..5 {
                let slope = (up[i] - down[i]) / (2.0 * step);
                let off = (slope - c[i][j]).abs() / (c[i][i] * c[j][j]).sqrt();
                assert!(off < 1e-8, "{spring:?} {i} {j}: {off:e}");
            }
        }
        for held in [[true; 5], [false, false, false, true, true]] {
            let u = found.displacement;
            let choices = Choices {
                held: from_fn(|i| held[i].then_some(u[i])),
                ..Choices::default()
            };
            let again = solved(&plan, &choices);
            let apart: [f64; 5] = from_fn(|i| again.load[i] - question.load[i]);
            assert!(largest(apart) < 1e-9, "{spring:?} {held:?}: {apart:?}");
        }
    }
}

/// Shafts of a millimetre to half a metre, up to ten metres long, on supports of 1e5 to 1e15 N/m: an answer satisfies the equations,
/// or a refusal has a name. In single precision the stated error covers it.
#[test]
fn answers_of_wild_shafts_satisfy_the_equations() {
    let judge = |seed: u64| {
        let (mut plan, attitude, question) = random_elastic(seed);
        let mut r = Random::seeded(seed ^ 0x71d);
        let shaft = plan.shaft.as_mut().unwrap();
        let mut at = -r.log_between(0.01, 5.0);
        for section in &mut shaft.sections {
            section.from = at;
            at += r.log_between(0.01, 2.5);
            section.to = at;
            section.outer = r.log_between(1e-3, 0.5);
            section.inner = section.outer * r.zero_or(0.5, 0.0, 0.99);
        }
        for support in &mut shaft.supports {
            support.axial = r.log_between(1e5, 1e15);
            support.radial = r.log_between(1e5, 1e15);
            support.tilting = r.log_between(1.0, 1e12);
        }
        let question = Question {
            growth: Vec::new(),
            ..question
        };
        let [double, single] = [Precision::F64, Precision::F32]
            .map(|precision| solve(&plan, attitude, precision, &question));
        let Ok(double) = double else {
            return false;
        };
        let off = off_equations(&plan, attitude, &question, &double);
        let bound = if double.status == "converged" {
            1e-10
        } else {
            1e-8
        };
        assert!(largest(off) < bound, "{seed}: {off:?} {:?}", double.error);
        if let Ok(single) = single {
            let apart = stiffness_error(&single.stiffness, &double.stiffness);
            println!(
                "{seed} single {apart:e} {:?} {}",
                single.error, single.status
            );
        }
        true
    };
    let judged = (0..5000)
        .into_par_iter()
        .filter(|seed| judge(*seed))
        .count();
    assert!(judged > 3000, "{judged}");
}
