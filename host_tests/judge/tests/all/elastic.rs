//! Spindles with an elastic shaft on elastic supports.

use super::solves::{self, Answer, Balls, ask, found};
use super::spindles::{largest, random, reference_near};
use cli::random::Random;
use judge::cases::B7005C;
use judge::compare::Equilibrium;
use rayon::prelude::*;
use solvers::dispatch::{Attitude, Precision};
use spindle_bearing::{Arrangement, Facing, Preload, Section, ShaftLoad, Support};
use spindle_file::plan::{ElasticShaft, Plan, Question};
use std::array::from_fn;

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
    plan.shaft = Some(ElasticShaft::of(sections, supports.collect()));
    (plan, attitude, question)
}

fn solve(
    plan: &Plan,
    attitude: Attitude,
    precision: Precision,
    question: &Question,
) -> Option<Answer> {
    let nose = plan.rows[0].position - plan.rows[0].design.pitch_diameter;
    found(plan, attitude.into(), precision, &question.clone().at(nose))
}

/// Clamped rows that face each other hold nearly any shaft, cold, in both precisions.
#[test]
fn random_elastic_sets_that_are_clamped_are_solved() {
    let is_lost = |seed: &u64| {
        let (plan, attitude, question) = random_elastic(*seed);
        let facing = plan.rows[0].facing;
        let is_clamped = plan.spring.is_none() && plan.rows.iter().any(|row| row.facing != facing);
        let cold = Question {
            growth: Vec::new(),
            ..question
        };
        let mut precisions = solves::PRECISIONS.into_iter();
        is_clamped && precisions.any(|precision| solve(&plan, attitude, precision, &cold).is_none())
    };
    let lost: Vec<u64> = (0..600).into_par_iter().filter(is_lost).collect();
    assert!(lost.is_empty(), "{lost:?}");
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
    let row = |position, facing| spindle_file::plan::Row {
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
        arrangement: Arrangement::BackToBack,
        spring,
        shaft: Some(ElasticShaft {
            loads: vec![BELT, tip],
            ..ElasticShaft::of(SECTIONS.to_vec(), vec![support; 2])
        }),
        ..Plan::of(vec![row(0.02, Facing::PlusX), row(0.12, Facing::MinusX)])
    }
}

/// The flexibility at the nose is that of loads which act there, and displacements that are given have the loads' reactions.
#[test]
fn loads_at_the_nose_and_given_displacements_agree_with_the_tangent() {
    let question = Question::load([120.0, 80.0, -30.0, 0.5, 1.0], 1500.0).at(NOSE);
    let solved = |plan: &Plan, question: &Question| {
        ask(plan, Balls::Free, Precision::F64, question).unwrap()
    };
    for spring in [None, Some(200.0)] {
        let plan = pulled(spring, [0.0; 5]);
        let found = solved(&plan, &question);
        let c = found.at[0].compliance;
        for j in 0..5 {
            let step = if j < 3 { 1e-2 } else { 1e-4 };
            let moved = |step: f64| {
                let plan = pulled(spring, from_fn(|i| if i == j { step } else { 0.0 }));
                solved(&plan, &question).at[0].displacement
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
            let again = solved(&plan, &question.clone().holding(held, u));
            let apart: [f64; 5] = from_fn(|i| again.load[i] - question.load[i]);
            assert!(largest(apart) < 1e-9, "{spring:?} {held:?}: {apart:?}");
        }
    }
}

/// Shafts of a millimetre to half a metre, up to ten metres long, on supports of 1e5 to 1e15 N/m: an answer is what the reference
/// build reaches from it, or a refusal has a name. In single precision the stated error of forces covers it.
#[test]
fn answers_of_wild_shafts_are_what_the_reference_build_says() {
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
        let Some(double) = double else {
            return false;
        };
        let Some(truth) = reference_near(&plan, attitude, &question, &double) else {
            return false;
        };
        let design = &plan.rows[0].design;
        let of = |answer: &Answer| Equilibrium::from(answer).errors(&truth, design);
        let errors = of(&double);
        let is_exact =
            errors.displacement < 1e-12 && errors.force < 1e-10 && errors.stiffness < 1e-8;
        assert!(is_exact, "{seed}: {errors} {:?}", double.error);
        if let Some(single) = single {
            let errors = of(&single);
            assert!(errors.force <= single.error[1], "{seed}: {errors}");
        }
        true
    };
    let judged = (0..5000)
        .into_par_iter()
        .filter(|seed| judge(*seed))
        .count();
    assert!(judged > 3000, "{judged}");
}
