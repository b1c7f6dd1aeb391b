//! Bearings whose rings and balls have grown.

use super::solves::{Balls, PRECISIONS, Question, SKEW, forces, lengths, solver, vector_error};
use host_tests::cases::{self, B7005C};
use host_tests::compare::{Errors, worse};
use host_tests::dispatch::Precision;
use spindle_bearing::Growth;

#[test]
fn rows_of_solved_sets_have_their_loads_and_displacements() {
    let mut worst = Errors::default();
    for row in cases::rows_of_sets() {
        let (design, omega) = (&row.case.design, row.case.omega);
        let balls = row.case.attitude.into();
        let mut solver = solver(design, row.case.balls, Precision::F64, balls);
        let [axial, radial, ball] = row.growth;
        let growth = Growth {
            axial,
            radial,
            ball,
        };
        let mut ask = |question: Question| {
            solver
                .ask(&Question { growth, ..question })
                .unwrap_or_else(|status| panic!("{}: {status}", row.case.name))
        };
        let (load, u) = (row.case.load, row.displacement);
        let by_load = ask(Question::load(load, omega));
        let by_displacement = ask(Question::displacement(u, omega));
        let displacement = vector_error(by_load.u, u, lengths(design));
        worst.displacement = worse(worst.displacement, displacement);
        let force = vector_error(by_displacement.load, load, forces(design));
        worst.force = worse(worst.force, force);
        for found in [&by_load, &by_displacement] {
            let largest = row.balls.iter().map(|b| b[3]).fold(0.0, f64::max);
            for (found, truth) in found.balls.iter().zip(&row.balls) {
                for (a, b) in [(found.q_i, truth[2]), (found.q_o, truth[3])] {
                    worst.force = worse(worst.force, (a - b).abs() / largest);
                }
                if truth[2] > 0.0 {
                    let angle = (found.alpha_i - truth[0]).abs();
                    worst.contact_angle = worse(worst.contact_angle, angle);
                }
            }
        }
    }
    let allowed = Errors {
        displacement: 1e-9,
        contact_angle: 1e-10,
        force: 1e-10,
        stiffness: 0.0,
    };
    assert!(worst.within(allowed), "{worst}");
}

#[test]
fn growth_of_nothing_changes_no_bit() {
    for precision in PRECISIONS {
        let [mut without, mut with] = [0; 2].map(|_| solver(&B7005C, 16, precision, Balls::Free));
        for step in 0..20 {
            let load = SKEW.map(|f| f * (1.0 + 0.01 * f64::from(step)));
            let question = Question::load(load, 2094.0);
            let grown = Question {
                growth: Growth {
                    axial: -0.0,
                    ..Growth::NONE
                },
                ..question
            };
            assert_eq!(without.ask(&question), with.ask(&grown));
        }
    }
}

#[test]
fn a_bearing_that_warms_up_is_followed() {
    for balls in [Balls::Static, Balls::Free] {
        let mut warm = solver(&B7005C, 16, Precision::F64, balls);
        for step in 0..40 {
            // Up to three times as much as balls deform, and a jump back.
            let share = f64::from(step % 30) / 30.0;
            let growth = Growth {
                axial: 2e-6 * share,
                radial: 9e-6 * share,
                ball: 1e-6 * share,
            };
            let question = Question {
                growth,
                ..Question::load(SKEW, 2094.0)
            };
            let found = warm.solve(&question);
            let cold = solver(&B7005C, 16, Precision::F64, balls).solve(&question);
            let u = vector_error(found.u, cold.u, lengths(&B7005C));
            let k = (found.k[1][1] / cold.k[1][1] - 1.0).abs();
            assert!(u < 1e-11 && k < 1e-11, "{step}, {balls:?}: {u:e}, {k:e}");
        }
    }
}
