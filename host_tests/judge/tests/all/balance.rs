//! Balance of forces of the ring and of every ball, and what follows from it for a single ball.

use super::solves::{
    Answer, Balls, LIFTING, Question, SKEW, apart, ask, cold, forces, solver, vector_error,
};
use judge::campaign::balance::{carried, unbalanced};
use judge::campaign::families::{Family, Trial};
use judge::cases::{B218, B7005C, SKF6205, rad_per_s};
use judge::compare::Equilibrium;
use rayon::prelude::*;
use solvers::dispatch::Precision;
use spindle_bearing::Design;
use spindle_file::plan::Plan;

fn assert_balances(design: &Design, balls: Balls, load: [f64; 5], found: &Answer) {
    let of_ball = unbalanced(design, balls.rule(), &found.rows[0].balls)
        / Equilibrium::from(found).largest_force();
    let sum = carried(design, balls.rule(), &found.rows[0].balls);
    let [of_balls, said] = [sum, found.load].map(|sum| vector_error(sum, load, forces(design)));
    for left in [of_ball, of_balls, said] {
        assert!(left < 1e-12, "{balls:?}, {load:?}: {left:e}");
    }
}

#[test]
fn forces_and_moments_balance_for_the_ring_and_for_every_ball() {
    for balls in [Balls::Free, Balls::Outer, Balls::Inner, Balls::Centrifugal] {
        // One solver for all speeds, so that some answers start from the one before.
        let mut solver = solver(&B7005C, 16, Precision::F64, balls);
        for rpm in [0.0, 5_000.0, 20_000.0, 40_000.0, 41_000.0] {
            let found = solver.load(SKEW, rad_per_s(rpm)).unwrap();
            assert_balances(&B7005C, balls, SKEW, &found);
        }
    }
    let found = cold(&B7005C, 16, Balls::Static, SKEW, 0.0);
    assert_balances(&B7005C, Balls::Static, SKEW, &found);
    for rpm in [0.0, 10_000.0, 40_000.0] {
        let found = cold(&B7005C, 16, Balls::Free, LIFTING, rad_per_s(rpm));
        assert_balances(&B7005C, Balls::Free, LIFTING, &found);
    }
    let load = [17_800.0, 900.0, 0.0, 0.0, 40.0];
    let found = cold(&B218, 16, Balls::Free, load, rad_per_s(10_000.0));
    assert_balances(&B218, Balls::Free, load, &found);
}

#[test]
fn forces_of_an_answer_balance_the_load_where_the_ring_hardly_resists() {
    let solved = (0..1000)
        .into_par_iter()
        .filter(|&index| {
            let trial = Trial::new(11, Family::DeepGroove, index);
            let (case, tick) = (&trial.case, &trial.ticks[0]);
            let plan = Plan::alone(&case.design, case.balls);
            let question = Question::load(tick.load, 0.0);
            let Ok(found) = ask(&plan, Balls::Static, Precision::F32, &question) else {
                return false;
            };
            let balls = &found.rows[0].balls;
            let sum = carried(&case.design, case.attitude, balls);
            let largest = balls.iter().map(|b| b.q_i).fold(0.0, f64::max);
            for (sum, load) in sum[..3].iter().zip(tick.load) {
                let off = (sum - load).abs();
                assert!(off < 1e-3 * largest, "{}: {sum} of {load} N", case.name);
            }
            true
        })
        .count();
    assert!(solved > 900, "{solved}");
}

#[test]
fn at_rest_contacts_oppose_each_other_and_a_ball_off_both_races_carries_nothing() {
    let mixed = [500.0, 300.0, -100.0, 0.5, 1.0];
    for (design, n, load, some_are_off) in [
        (&B7005C, 16, SKEW, false),
        (&B7005C, 16, LIFTING, true),
        (&B7005C, 16, [30.0, 60.0, 0.0, 0.0, 0.0], true),
        (&B7005C, 16, mixed, false),
        (&SKF6205, 8, mixed, false),
    ] {
        let at_rest = cold(design, n, Balls::Static, load, 0.0);
        let speed_zero = cold(design, n, Balls::Free, load, 0.0);
        for found in [&at_rest, &speed_zero] {
            assert!(
                !some_are_off || Equilibrium::from(found).unloaded_balls() > 0,
                "{found:?}"
            );
            for ball in &found.rows[0].balls {
                let off = (ball.q_i - ball.q_o).abs();
                assert!(off <= 1e-12 * ball.q_o, "{ball:?}");
                let opposed = (ball.alpha_i - ball.alpha_o).abs() < 1e-13;
                assert!(ball.q_i == 0.0 || opposed, "{ball:?}");
            }
        }
        let e = apart(design, &speed_zero, &at_rest);
        assert!(e < 1e-12, "{n} balls, {load:?}: {e:.1e}");
    }
}
