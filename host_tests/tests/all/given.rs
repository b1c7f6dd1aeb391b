//! Displacements given in the place of loads, and the reactions to them.

use super::solves::{
    Balls, PRECISIONS, Question, SKEW, apart, forces, lengths, loads, solver, vector_error,
};
use host_tests::cases::{B7005C, Random, rad_per_s};
use host_tests::dispatch::Precision;
use proptest::prelude::*;
use rayon::prelude::*;
use spindle_bearing::{
    Arrangement, Bearing, Facing, Given, Mounted, Preload, Quantity, Real, Settings, Speed,
    Spindle, SpindleSolver, Status,
};
use std::array::from_fn;

#[test]
fn given_displacements_are_met_and_their_reactions_hold_the_ring() {
    for precision in PRECISIONS {
        let mut solver = solver(&B7005C, 16, precision, Balls::Free);
        let free = solver.load(SKEW, 2094.0);
        for bits in 1..32u8 {
            let held = from_fn(|i| bits >> i & 1 == 1);
            let found = solver.solve(&Question::mixed(held, free.u, SKEW, 2094.0));
            let [of_u, of_load] = match precision {
                Precision::F32 => [1e-5, 3e-4],
                Precision::F64 => [1e-12, 1e-11],
            };
            let u = vector_error(found.u, free.u, lengths(&B7005C));
            let load = vector_error(found.load, SKEW, forces(&B7005C));
            assert!(u < of_u && load < of_load, "{held:?}: {u:e}, {load:e}");
        }
    }
}

/// Of a set whose rows are away from `x = 0`, clamped and under a spring: before and after solves of loads alone.
#[test]
fn given_displacements_of_a_set_are_met_and_their_reactions_hold_it() {
    fn check<T: Real, const D: usize>(spindle: Spindle<'_, T, 2, 16, D>, tolerance: [f64; 3]) {
        let mut solver = SpindleSolver::new();
        let speed = Speed::rpm(T::of(12_000.0));
        let load = [60.0, 80.0, -30.0, 2.0, 5.0].map(T::of);
        let settings = Settings::default();
        let free = solver.solve(&spindle, load, speed, &settings).unwrap();
        let (u, k) = (free.displacement, free.stiffness());
        for bits in 1..32_u8 {
            let is_held = |i: usize| bits >> i & 1 == 1;
            let given: [_; 5] = from_fn(|i| match is_held(i) {
                true => Given::Displacement(u[i]),
                false => Given::Load(load[i]),
            });
            let off = |a: T, b: T, size: f64| (a.to_f64() - b.to_f64()).abs() / size;
            let far = [load.map(|x| T::of(1.3) * x), load][usize::from(bits % 2)];
            solver.solve(&spindle, far, speed, &settings).unwrap();
            let found = solver.solve(&spindle, given, speed, &settings).unwrap();
            for i in 0..5 {
                let (length, force) = if i < 3 { (1e-5, 100.0) } else { (1e-4, 10.0) };
                assert!(
                    off(found.displacement[i], u[i], length) < tolerance[0],
                    "{bits:b} {i}"
                );
                assert!(
                    off(found.load[i], load[i], force) < tolerance[1],
                    "{bits:b} {i}"
                );
                for j in 0..5 {
                    let size = (k[i][i] * k[j][j]).to_f64().abs().sqrt();
                    assert!(off(found.stiffness()[i][j], k[i][j], size) < tolerance[2]);
                }
            }
            // Nothing of another point of reference stays behind.
            let again = solver.solve(&spindle, load, speed, &settings).unwrap();
            assert!((0..5).all(|i| off(again.displacement[i], u[i], 1e-4) < tolerance[0]));
        }
    }
    fn both<T: Real>(bearing: &Bearing<T, 16>, tolerance: [f64; 3]) {
        let row = |x, facing| Mounted::new(bearing, T::of(x), facing);
        let rows = [row(0.15, Facing::PlusX), row(0.25, Facing::MinusX)];
        let clamped = rows.map(|row| row.with(Preload::Force(T::of(200.0))));
        check(
            Spindle::new(Arrangement::ByRows, clamped).unwrap(),
            tolerance,
        );
        let rows = [rows[0], rows[1].with(Preload::Spring)];
        check(
            Spindle::sprung(Arrangement::ByRows, rows, T::of(200.0)).unwrap(),
            tolerance,
        );
    }
    both(
        &Bearing::<f64, 16>::new(&B7005C).unwrap(),
        [1e-9, 1e-9, 1e-8],
    );
    both(
        &Bearing::<f32, 16>::new(&B7005C).unwrap(),
        [2e-3, 2e-3, 2e-3],
    );
}

#[test]
fn a_ring_that_nothing_touches_is_indeterminate() {
    // Between the two sides of the grooves.
    let axially = [true, false, false, false, false];
    let question = Question::mixed(axially, [-20e-6; 5], [0.0; 5], 0.0);
    for precision in PRECISIONS {
        let answer = solver(&B7005C, 16, precision, Balls::Static).ask(&question);
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
        let found = solver.load(load, rad_per_s(rpm));
        let back = solver.solve(&Question::displacement(found.u, rad_per_s(rpm)));
        prop_assert!(vector_error(back.load, load, forces(&B7005C)) < 1e-9);
        let e = apart(&B7005C, &back, &found);
        prop_assert!(e < 1e-8, "{e:.1e}");
    }
}

/// Rows that hold each other are pressed under any load, but given displacements may be anywhere.
#[test]
fn given_displacements_are_answered_warm_as_cold() {
    fn check<T: Real>(seed: u64) {
        let bearing = Bearing::<T, 16>::of(&B7005C).unwrap();
        let preload = Preload::Force(T::of(200.0));
        let pair = Spindle::pair(Arrangement::BackToBack, &bearing, T::of(0.1), preload).unwrap();
        let (mut warm, mut cold) = (SpindleSolver::new(), SpindleSolver::new());
        let settings = Settings::default();
        let mut random = Random::seeded(seed);
        for number in 0..500 {
            warm.reset();
            cold.reset();
            let is_still = number % 3 == 0;
            let omega = if is_still {
                0.0
            } else {
                random.between(0.0, 2600.0)
            };
            let speed = Speed::rad_per_s(T::of(omega));
            let size = if is_still { 0.0 } else { 1.0 };
            let mut load = |most: [f64; 5]| most.map(|most| T::of(random.between(-most, most)));
            let before = load([300.0, 300.0, 300.0, 3.0, 3.0]).map(|x| T::of(size) * x);
            let loads = load([100.0, 200.0, 200.0, 2.0, 2.0]);
            let displaced = load([5e-6, 5e-6, 5e-6, 1e-4, 1e-4]);
            let far = T::of(random.log_between(0.1, 10.0));
            let given: [_; 5] = from_fn(|i| match random.chance(0.5) {
                true => Given::Displacement(far * displaced[i]),
                false => Given::Load(loads[i]),
            });
            warm.solve(&pair, before, speed, &settings).unwrap();
            let warm = warm.solve(&pair, given, speed, &settings).map(|_| ());
            let cold = cold.solve(&pair, given, speed, &settings).map(|_| ());
            assert_eq!(warm.is_ok(), cold.is_ok(), "{given:?}: {warm:?}, {cold:?}");
        }
    }
    (0..4_u64).into_par_iter().for_each(|seed| {
        check::<f32>(seed);
        check::<f64>(seed);
    });
}
