//! Displacements given in the place of loads, and the reactions to them.

use super::solves::{
    AnySolver, Balls, PRECISIONS, Question, apart, forces, loads, solver, vector_error,
};
use cli::random::Random;
use judge::cases::{B7005C, rad_per_s};
use proptest::prelude::*;
use rayon::prelude::*;
use solvers::dispatch::Precision;
use solvers::with_solver;
use spindle_bearing::{Facing, Preload, Quantity, Status};
use spindle_file::plan::{Plan, Row};
use std::array::from_fn;

fn row(position: f64, facing: Facing, preload: Preload<f64>) -> Row {
    Row {
        balls: 16,
        design: B7005C,
        position,
        facing,
        preload,
    }
}

/// Of a set whose rows are away from `x = 0`, clamped and under a spring: before and after solves of loads alone.
#[test]
fn given_displacements_of_a_set_are_met_and_their_reactions_hold_it() {
    let clamped = Preload::Force(200.0);
    for (spring, front, rear) in [
        (None, clamped, clamped),
        (Some(200.0), Preload::Closure(0.0), Preload::Spring),
    ] {
        let rows = vec![
            row(0.15, Facing::PlusX, front),
            row(0.25, Facing::MinusX, rear),
        ];
        let plan = Plan {
            spring,
            ..Plan::of(rows)
        };
        for (precision, [of_u, of_load, of_k]) in
            PRECISIONS.into_iter().zip([[2e-3; 3], [1e-9, 1e-9, 1e-8]])
        {
            let check = |solver: &mut dyn AnySolver| {
                let load = [60.0, 80.0, -30.0, 2.0, 5.0];
                let question = Question::load(load, rad_per_s(12_000.0));
                let free = solver.answer(&question);
                let (u, k) = (free.displacement, free.stiffness);
                let off = |a: f64, b: f64, size: f64| (a - b).abs() / size;
                for bits in 1..32_u8 {
                    let held = from_fn(|i| bits >> i & 1 == 1);
                    let far = [load.map(|x| 1.3 * x), load][usize::from(bits % 2)];
                    solver.load(far, question.omega).unwrap();
                    let found = solver.answer(&question.clone().holding(held, u));
                    for i in 0..5 {
                        let (length, force) = if i < 3 { (1e-5, 100.0) } else { (1e-4, 10.0) };
                        assert!(
                            off(found.displacement[i], u[i], length) < of_u,
                            "{bits:b} {i}"
                        );
                        assert!(off(found.load[i], load[i], force) < of_load, "{bits:b} {i}");
                        for j in 0..5 {
                            let size = (k[i][i] * k[j][j]).abs().sqrt();
                            assert!(off(found.stiffness[i][j], k[i][j], size) < of_k);
                        }
                    }
                    // Nothing of another point of reference stays behind.
                    let again = solver.answer(&question).displacement;
                    assert!((0..5).all(|i| off(again[i], u[i], 1e-4) < of_u));
                }
            };
            with_solver(&plan, Balls::Free, precision, check).unwrap();
        }
    }
}

#[test]
fn a_ring_that_nothing_touches_is_indeterminate() {
    // Between the two sides of the grooves.
    let axially = [true, false, false, false, false];
    let question = Question::load([0.0; 5], 0.0).holding(axially, [-20e-6; 5]);
    for precision in PRECISIONS {
        let answer = solver(&B7005C, 16, precision, Balls::Static).solve(&question);
        assert_eq!(
            answer.err(),
            Some(Status::Indeterminate {
                loaded_balls: 0,
                free: Quantity::Dy
            })
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..Default::default() })]

    #[test]
    fn reactions_to_the_displacements_of_a_solution_are_its_load(
        load in loads(), rpm in 0.0..40_000.0f64,
    ) {
        let mut solver = solver(&B7005C, 16, Precision::F64, Balls::Free);
        let found = solver.load(load, rad_per_s(rpm)).unwrap();
        let back = solver.answer(&Question::load([0.0; 5], rad_per_s(rpm)).holding([true; 5], found.displacement));
        prop_assert!(vector_error(back.load, load, forces(&B7005C)) < 1e-9);
        let e = apart(&B7005C, &back, &found);
        prop_assert!(e < 1e-8, "{e:.1e}");
    }
}

/// Rows that hold each other are pressed under any load, but given displacements may be anywhere.
#[test]
fn given_displacements_are_answered_warm_as_cold() {
    let check = |seed: u64, warm: &mut dyn AnySolver| {
        let mut random = Random::seeded(seed);
        for number in 0..500 {
            let is_still = number % 3 == 0;
            let omega = if is_still {
                0.0
            } else {
                random.between(0.0, 2600.0)
            };
            let size = if is_still { 0.0 } else { 1.0 };
            let mut load = |most: [f64; 5]| most.map(|most| random.between(-most, most));
            let before = load([300.0, 300.0, 300.0, 3.0, 3.0]).map(|x| size * x);
            let loads = load([100.0, 200.0, 200.0, 2.0, 2.0]);
            let displaced = load([5e-6, 5e-6, 5e-6, 1e-4, 1e-4]);
            let far = random.log_between(0.1, 10.0);
            let held = from_fn(|_| random.chance(0.5));
            let given = Question::load(loads, omega).holding(held, displaced.map(|u| far * u));
            warm.reset();
            let cold = warm.solve(&given);
            warm.reset();
            warm.load(before, omega).unwrap();
            let warm = warm.solve(&given);
            assert_eq!(warm.is_ok(), cold.is_ok(), "{given:?}: {warm:?}, {cold:?}");
        }
    };
    let preload = Preload::Force(200.0);
    let rows = [(0.0, Facing::PlusX), (0.1, Facing::MinusX)];
    let pair = Plan::of(rows.map(|(x, facing)| row(x, facing, preload)).to_vec());
    (0..4_u64).into_par_iter().for_each(|seed| {
        for precision in PRECISIONS {
            with_solver(&pair, Balls::Free, precision, |solver| check(seed, solver)).unwrap();
        }
    });
}
