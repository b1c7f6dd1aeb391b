//! Bearings whose rings and balls have grown.

use super::solves::{
    Balls, PRECISIONS, Question, SKEW, forces, lengths, ring_solver, solver, vector_error,
};
use super::spindles::displacement_of;
use judge::cases::{B7005C, sets};
use judge::compare::{Equilibrium, stiffness_error};
use solvers::dispatch::Precision;
use spindle_bearing::{Expansion, FreeContact, Growth, Quantity, Status};
use spindle_monitor::settings::MonitorSettings;

#[test]
fn rows_of_solved_sets_have_their_loads_and_displacements() {
    let mut judged = 0;
    for set in sets() {
        let (name, omega) = (&set.name, set.question.omega);
        let rows = set.plan.rows.iter().zip(&set.question.growth);
        for ((row, growth), solved) in rows.zip(&set.rows) {
            judged += 1;
            let design = &row.design;
            let displacement = displacement_of(row, set.truth.displacement, set.spring_closure);
            let mut solver = solver(design, row.balls, Precision::F64, set.attitude.into());
            let mut ask = |question: Question| solver.answer(&question.clone().grown(*growth));
            let by_load = ask(Question::load(solved.load, omega));
            let by_displacement =
                ask(Question::load([0.0; 5], omega).holding([true; 5], displacement));
            let u = vector_error(by_load.displacement, displacement, lengths(design));
            let load = vector_error(by_displacement.load, solved.load, forces(design));
            assert!(u < 1e-9 && load < 1e-10, "{name}: {u:e}, {load:e}");
            for found in [&by_load, &by_displacement] {
                let largest = Equilibrium::from(found).largest_force();
                for (found, truth) in found.rows[0].balls.iter().zip(&solved.balls) {
                    let (alpha_i, q_i) = (truth.alpha_i, truth.q_i);
                    let q_o = truth.q_o;
                    let force = (found.q_i - q_i).abs().max((found.q_o - q_o).abs()) / largest;
                    let angle = (found.alpha_i - alpha_i).abs();
                    assert!(force < 1e-10, "{name}: {force:e}");
                    assert!(q_i == 0.0 || angle < 1e-10, "{name}: {angle:e}");
                }
            }
        }
    }
    assert!(judged > 30, "{judged}");
}

#[test]
fn growth_of_nothing_changes_no_bit() {
    for precision in PRECISIONS {
        let [mut without, mut with] = [0; 2].map(|_| solver(&B7005C, 16, precision, Balls::Free));
        for step in 0..20 {
            let load = SKEW.map(|f| f * (1.0 + 0.01 * f64::from(step)));
            let question = Question::load(load, 2094.0);
            let none = Growth {
                axial: -0.0,
                ..Growth::NONE
            };
            assert_eq!(
                without.solve(&question),
                with.solve(&question.clone().grown(none))
            );
        }
    }
}

/// The ring makes up for growth along the axis by its displacement, and nothing else changes.
#[test]
fn axial_growth_moves_a_ring_under_its_load_back_by_as_much() {
    for freedoms in [1, 5] {
        for balls in [Balls::Static, Balls::Free] {
            let mut solver = ring_solver(&B7005C, 16, Precision::F64, balls, freedoms);
            let question = Question::load(SKEW, 2094.0);
            let cold = solver.answer(&question);
            for axial in [2e-6, -5e-6] {
                let grown = solver.answer(&question.clone().grown(Growth {
                    axial,
                    ..Growth::NONE
                }));
                let mut u = cold.displacement;
                u[0] -= axial;
                let off = vector_error(grown.displacement, u, lengths(&B7005C));
                let of_k = stiffness_error(&grown.stiffness, &cold.stiffness);
                assert!(off < 1e-11 && of_k < 1e-11, "{off:e}, {of_k:e}");
            }
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
            let question = Question::load(SKEW, 2094.0).grown(growth);
            let found = warm.answer(&question);
            let cold = solver(&B7005C, 16, Precision::F64, balls).answer(&question);
            let u = vector_error(found.displacement, cold.displacement, lengths(&B7005C));
            let k = (found.stiffness[1][1] / cold.stiffness[1][1] - 1.0).abs();
            assert!(u < 1e-11 && k < 1e-11, "{step}, {balls:?}: {u:e}, {k:e}");
        }
    }
}

/// Displacement at the outer radius, and stress at both radii, of a disc that turns at `omega`, of the rings' material.
/// The displacement at the inner radius and its slope are given. Equilibrium of an element, integrated.
fn disc([a, b]: [f64; 2], omega: f64, mut u: f64, mut slope: f64) -> (f64, [f64; 2]) {
    const STEPS: u32 = 2000;
    let ring = &B7005C.ring;
    let nu = ring.poissons_ratio;
    let pull = (1.0 - nu * nu) * ring.density * omega * omega / ring.youngs_modulus;
    let stress =
        |r: f64, u: f64, slope: f64| ring.youngs_modulus / (1.0 - nu * nu) * (slope + nu * u / r);
    let change = |r: f64, [u, slope]: [f64; 2]| [slope, u / (r * r) - slope / r - pull * r];
    let at_bore = stress(a, u, slope);
    let h = (b - a) / f64::from(STEPS);
    for step in 0..STEPS {
        let r = a + h * f64::from(step);
        let at = |part: f64, k: [f64; 2]| {
            change(r + part * h, [u + part * h * k[0], slope + part * h * k[1]])
        };
        let k1 = at(0.0, [0.0; 2]);
        let k2 = at(0.5, k1);
        let k3 = at(0.5, k2);
        let k4 = at(1.0, k3);
        let mean = |i: usize| (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]) / 6.0;
        (u, slope) = (u + h * mean(0), slope + h * mean(1));
    }
    (u, [at_bore, stress(b, u, slope)])
}

/// Displacements at the inner and the outer radius of a disc whose rims carry these stresses: the disc is linear in what
/// it starts from.
fn displacements(radii: [f64; 2], omega: f64, [at_bore, at_rim]: [f64; 2]) -> [f64; 2] {
    let start = |u, slope| disc(radii, omega, u, slope);
    let (none, by_u, by_slope) = (start(0.0, 0.0), start(1e-6, 0.0), start(0.0, 1e-3));
    let column = |of: &(f64, [f64; 2])| [of.1[0] - none.1[0], of.1[1] - none.1[1]];
    let ([a, c], [b, d]) = (column(&by_u), column(&by_slope));
    let missing = [at_bore - none.1[0], at_rim - none.1[1]];
    let determinant = a * d - b * c;
    let x = (missing[0] * d - b * missing[1]) / determinant;
    let y = (a * missing[1] - missing[0] * c) / determinant;
    let rim = none.0 + x * (by_u.0 - none.0) + y * (by_slope.0 - none.0);
    [1e-6 * x, rim]
}

fn inner_groove() -> f64 {
    let FreeContact::Angle(angle) = B7005C.free_contact else {
        unreachable!("an angular contact bearing")
    };
    0.5 * (B7005C.pitch_diameter - B7005C.ball_diameter * angle.cos())
}

#[test]
fn a_turning_ring_grows_as_a_disc_in_equilibrium_does() {
    for (bore, rpm) in [(2e-3, 20_000.0), (10e-3, 20_000.0), (10e-3, 60_000.0)] {
        let omega = rpm * std::f64::consts::PI / 30.0;
        let [_, rim] = displacements([bore, inner_groove()], omega, [0.0; 2]);
        let found = Growth::by_rotation(&B7005C, 2.0 * bore, omega).radial;
        assert!((found / rim - 1.0).abs() < 1e-6, "{found:e} {rim:e}");
    }
}

#[test]
fn a_bore_that_leaves_no_ring_has_no_growth() {
    let groove = 2.0 * inner_groove();
    let by_rotation = |bore| Growth::by_rotation(&B7005C, bore, 100.0).radial;
    let by_fit = |seat, bore| Growth::by_fit(&B7005C, seat, bore, 4e-6).radial;
    assert!(by_rotation(0.999 * groove) > 0.0 && by_fit(0.999 * groove, 0.0) > 0.0);
    for bore in [1.001 * groove, -1e-3, f64::NAN] {
        assert!(by_rotation(bore).is_nan() && by_fit(0.025, bore).is_nan());
    }
    assert!(by_fit(1.001 * groove, 0.0).is_nan() && by_fit(0.02, 0.021).is_nan());
    // Every solve refuses it, and so does the check of a monitor's settings.
    let none = Growth::by_rotation(&B7005C, groove * 1.001, 100.0);
    let mut solver = solver(&B7005C, 16, Precision::F64, Balls::Free);
    let refused = solver.solve(&Question::load(SKEW, 100.0).grown(none));
    let is_radial = |s| {
        matches!(
            s,
            Status::NotFinite {
                quantity: Quantity::RadialGrowth,
                ..
            }
        )
    };
    assert!(refused.is_err_and(is_radial));
    let mut settings = MonitorSettings::<1>::new(&B7005C, 16);
    settings.rows[0] = settings.rows[0].with_rotation(&B7005C, 1.001 * groove);
    assert!(settings.check().is_err());
}

#[test]
fn a_ring_on_a_shaft_grows_until_both_press_each_other_alike() {
    let (seat, groove, interference) = (12.5e-3, inner_groove(), 4e-6); // radii
    for bore in [1e-3, 6e-3, 11e-3] {
        // Under a pressure of 1 MPa, and so under any.
        let pressure = -1e6;
        let [_, shaft] = displacements([bore, seat], 0.0, [0.0, pressure]);
        let [ring, rim] = displacements([seat, groove], 0.0, [pressure, 0.0]);
        let expected = rim * interference / (ring - shaft);
        let found = Growth::by_fit(&B7005C, 2.0 * seat, 2.0 * bore, 2.0 * interference).radial;
        assert!((found / expected - 1.0).abs() < 1e-6, "{found:e}");
    }
}

#[test]
fn heat_that_is_everywhere_the_same_grows_rings_alike_and_a_hot_shaft_closes_the_bearing() {
    let even = Growth::by_heat(&B7005C, &Expansion::STEEL, [10.0; 3]);
    // Grooves and balls grow by one part, as the bearing would as a whole.
    let part = 10.0 * Expansion::STEEL.ring;
    let FreeContact::Angle(angle) = B7005C.free_contact else {
        unreachable!("an angular contact bearing")
    };
    assert!((even.ball / (part * B7005C.ball_diameter) - 1.0).abs() < 1e-12);
    let gap = -part * B7005C.ball_diameter * angle.cos();
    assert!((even.radial / gap - 1.0).abs() < 1e-9, "{even:?}");
    let hot_shaft = Growth::by_heat(&B7005C, &Expansion::HYBRID, [10.0, 0.0, 0.0]);
    assert!(hot_shaft.radial > 1e-6 && hot_shaft.ball == 0.0);
    // Linear growths add up.
    let [a, b] = [[3.0, 1.0, 2.0], [4.0, -1.0, 0.0]]
        .map(|kelvin| Growth::by_heat(&B7005C, &Expansion::HYBRID, kelvin));
    let both = Growth::by_heat(&B7005C, &Expansion::HYBRID, [10.0, 1.0, 4.0]);
    let sum = a * 2.0 + b;
    assert!((sum.radial / both.radial - 1.0).abs() < 1e-12, "{sum:?}");
    assert!((sum.ball / both.ball - 1.0).abs() < 1e-12);
}
