//! Several bearings on one shaft.

use host_tests::cases::{SolvedSet, sets};
use host_tests::compare::{stiffness_error, worse};
use host_tests::dispatch::{self, Attitude, Precision};
use host_tests::spindles::{Answer, AnySpindleSolver, Balls, Plan, Question, Row, with_solver};
use rayon::prelude::*;
use spindle_bearing::{
    Arrangement, Design, Facing, FreeContact, Growth, Material, Preload, Status,
};

/// How far an answer is off.
#[derive(Debug, Clone, Copy, Default)]
struct Off {
    /// Displacement of the shaft, over its largest component or the largest closure of a row, whichever is larger: an unloaded
    /// set has no displacement at all. Tilts times the pitch radius.
    u: f64,
    /// Closure that the spring makes, over the same.
    closure: f64,
    /// Forces of the rows and of the balls' contacts, over the largest of its kind in the set; moments over the pitch radius.
    row: f64,
    ball: f64,
    /// Contact angles, rad, where the contact carries.
    angle: f64,
    /// Stiffness, scaled by its diagonal.
    k: f64,
}

impl Off {
    fn worse(self, other: Self) -> Self {
        Self {
            u: worse(self.u, other.u),
            closure: worse(self.closure, other.closure),
            row: worse(self.row, other.row),
            ball: worse(self.ball, other.ball),
            angle: worse(self.angle, other.angle),
            k: worse(self.k, other.k),
        }
    }

    fn within(self, most: Self) -> bool {
        self.u <= most.u
            && self.closure <= most.closure
            && self.row <= most.row
            && self.ball <= most.ball
            && self.angle <= most.angle
            && self.k <= most.k
    }
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().map(f64::abs).fold(0.0, worse)
}

fn off(found: &Answer, set: &SolvedSet) -> Off {
    let radius = 0.5 * set.plan.rows[0].design.pitch_diameter;
    let lengths = |u: &[f64; 5]| [u[0], u[1], u[2], u[3] * radius, u[4] * radius];
    let forces = |f: &[f64; 5]| [f[0], f[1], f[2], f[3] / radius, f[4] / radius];
    let (u, truth) = (lengths(&found.displacement), lengths(&set.displacement));
    let closures = set.plan.rows.iter().map(|row| match row.preload {
        Preload::Closure(e) => e,
        _ => set.spring_closure.unwrap_or_default(),
    });
    let size = largest(truth.into_iter().chain(closures));
    let mut off = Off {
        u: largest(u.iter().zip(truth).map(|(a, b)| a - b)) / size,
        closure: set
            .spring_closure
            .map_or(0.0, |e| (found.spring_closure - e).abs() / size),
        k: stiffness_error(&found.stiffness, &set.stiffness),
        ..Off::default()
    };
    let of_rows = largest(set.rows.iter().flat_map(|row| forces(&row.load)));
    let of_balls = largest(set.rows.iter().flat_map(|r| r.balls.iter().map(|b| b[3])));
    for (found, truth) in found.rows.iter().zip(&set.rows) {
        let force = forces(&found.force).into_iter().zip(forces(&truth.load));
        off.row = worse(off.row, largest(force.map(|(a, b)| a - b)) / of_rows);
        assert_eq!(found.balls.len(), truth.balls.len());
        for (ball, truth) in found.balls.iter().zip(&truth.balls) {
            let [alpha_i, alpha_o, q_i, q_o, fc, _] = *truth;
            let of_ball = [ball.q_i - q_i, ball.q_o - q_o, ball.centrifugal_force - fc];
            off.ball = worse(off.ball, largest(of_ball) / of_balls);
            for (q, found, truth) in [(q_i, ball.alpha_i, alpha_i), (q_o, ball.alpha_o, alpha_o)] {
                if q > 0.0 {
                    off.angle = worse(off.angle, (found - truth).abs());
                }
            }
        }
    }
    off
}

fn solve(set: &SolvedSet, balls: Balls, precision: Precision) -> Result<Answer, Status<f32>> {
    let ask = |solver: &mut dyn AnySpindleSolver| solver.solve(&set.question, 0.0);
    with_solver(&set.plan, balls, precision, ask).unwrap_or_else(|e| panic!("{}: {e}", set.name))
}

/// Every solved set in every scene that it fits into.
fn judge(precision: Precision, allowed: Off) {
    let judged: Vec<(String, Result<Off, Status<f32>>)> = sets()
        .par_iter()
        .flat_map_iter(|set| {
            let mut scenes = vec![Balls::Moving(set.attitude)];
            if set.question.omega == 0.0 {
                scenes.push(Balls::Static);
            }
            scenes.into_iter().map(move |balls| {
                let name = format!("{}, {balls:?}, {:.0} rad/s", set.name, set.question.omega);
                (
                    name,
                    solve(set, balls, precision).map(|found| off(&found, set)),
                )
            })
        })
        .collect();
    let (mut worst, mut wrong) = (Off::default(), Vec::new());
    for (name, judged) in judged {
        match judged {
            Ok(off) => {
                worst = worst.worse(off);
                if !off.within(allowed) {
                    wrong.push(format!("{name}: {off:?}"));
                }
            }
            Err(status) => wrong.push(format!("{name}: {status}")),
        }
    }
    println!("{precision:?}: {worst:?}");
    assert!(
        wrong.is_empty(),
        "allowed: {allowed:?}\n{}",
        wrong.join("\n")
    );
}

#[test]
fn solved_sets_in_double_precision() {
    judge(
        Precision::F64,
        Off {
            u: 1e-9,
            closure: 1e-9,
            row: 1e-9,
            ball: 1e-9,
            angle: 1e-9,
            k: 1e-8,
        },
    );
}

#[test]
fn solved_sets_in_single_precision() {
    judge(
        Precision::F32,
        Off {
            u: 1e-5,
            closure: 1e-5,
            row: 1e-4,
            ball: 1e-4,
            angle: 1e-4,
            k: 1e-3,
        },
    );
}

const FREE: Balls = Balls::Moving(Attitude::Raceless);

/// NTN's 7014C with the model's groove factors, of steel.
const D7014C: Design = Design {
    ball_diameter: 11.906e-3,
    pitch_diameter: 90e-3,
    inner_groove_factor: 0.515,
    outer_groove_factor: 0.525,
    free_contact: FreeContact::Angle(15.0 * std::f64::consts::PI / 180.0),
    inner_shoulder_angle: Design::HIGHEST_SHOULDER,
    outer_shoulder_angle: Design::HIGHEST_SHOULDER,
    first_ball: 0.0,
    ring: Material::STEEL,
    ball: Material::STEEL,
};

fn row(position: f64, facing: Facing, preload: Preload<f64>) -> Row {
    Row {
        balls: 20,
        design: D7014C,
        position,
        facing,
        preload,
    }
}

/// A set of 7014C at these positions, `+` and `-` for how they face.
fn clamped(layout: &[(f64, char)], preload: Preload<f64>) -> Plan {
    let rows = layout.iter().map(|(position, facing)| {
        let facing = if *facing == '+' {
            Facing::PlusX
        } else {
            Facing::MinusX
        };
        row(*position, facing, preload)
    });
    Plan {
        rows: rows.collect(),
        arrangement: Arrangement::ByRows,
        spring: None,
    }
}

/// Two rows in front, and two in a sleeve at the rear.
fn sprung() -> Plan {
    Plan {
        rows: vec![
            row(0.0, Facing::PlusX, Preload::Closure(4e-6)),
            row(0.027, Facing::PlusX, Preload::Closure(6e-6)),
            row(0.225, Facing::MinusX, Preload::Spring),
            row(0.252, Facing::MinusX, Preload::Spring),
        ],
        arrangement: Arrangement::BackToBack,
        spring: Some(600.0),
    }
}

fn ask_at(plan: &Plan, balls: Balls, question: &Question, x: f64) -> Answer {
    with_solver(plan, balls, Precision::F64, |solver| {
        solver.solve(question, x)
    })
    .unwrap_or_else(|e| panic!("{e}"))
    .unwrap_or_else(|e| panic!("{e}"))
}

fn ask(plan: &Plan, balls: Balls, question: &Question) -> Answer {
    ask_at(plan, balls, question, 0.0)
}

fn loaded(load: [f64; 5], rpm: f64) -> Question {
    Question {
        load,
        omega: rpm * std::f64::consts::PI / 30.0,
        growth: Vec::new(),
    }
}

const SKEW: [f64; 5] = [150.0, 400.0, -250.0, 3.0, 8.0];

#[test]
fn a_single_row_is_the_plain_solver_to_the_bit() {
    let plan = clamped(&[(0.0, '+')], Preload::Closure(0.0));
    for precision in [Precision::F32, Precision::F64] {
        let bearing = dispatch::bearing(&D7014C, 20, precision).unwrap();
        for balls in [FREE, Balls::Static] {
            let mut plain = match balls {
                Balls::Static => bearing.static_solver(),
                Balls::Moving(attitude) => bearing.solver(attitude),
            };
            let compare = |solver: &mut dyn AnySpindleSolver| {
                for step in 0..200 {
                    // Near loads, and far ones that are started anew.
                    let part = 1.0 + 0.01 * f64::from(step % 20) + f64::from(step / 20);
                    let load = SKEW.map(|load| load * part);
                    let load = [load[0] * 4.0, load[1], load[2], load[3], load[4]];
                    let omega = if balls == FREE { 300.0 * part } else { 0.0 };
                    let question = Question {
                        load,
                        omega,
                        growth: Vec::new(),
                    };
                    let mut states = Vec::new();
                    let figures = plain
                        .solve_with_balls(load, omega, Some(&mut states))
                        .figures;
                    match (figures, solver.solve(&question, 0.0)) {
                        (Ok(plain), Ok(found)) => {
                            assert_eq!(found.displacement, plain.displacement, "{step}");
                            assert_eq!(found.stiffness, plain.stiffness, "{step}");
                            assert_eq!(found.rows[0].balls, states, "{step}");
                            assert_eq!(Some(found.error), plain.error, "{step}");
                        }
                        (Err(plain), Err(found)) => assert_eq!(plain, found.to_string()),
                        (plain, found) => panic!("{step}: {plain:?}, {found:?}"),
                    }
                }
            };
            with_solver(&plan, balls, precision, compare).unwrap();
        }
    }
}

#[test]
fn two_pairs_in_one_are_twice_as_stiff_and_preloaded() {
    let preload = Preload::Force(294.0);
    let unloaded = loaded([0.0; 5], 0.0);
    let pair = ask(
        &clamped(&[(0.0, '+'), (0.027, '-')], preload),
        FREE,
        &unloaded,
    );
    let qbc = [(-0.0135, '+'), (0.0135, '+'), (0.0405, '-'), (0.0675, '-')];
    let qbc = ask(&clamped(&qbc, preload), FREE, &unloaded);
    for i in 0..3 {
        let factor = qbc.stiffness[i][i] / pair.stiffness[i][i];
        assert!((factor - 2.0).abs() < 1e-12, "{i}: {factor}");
    }
    let side = |answer: &Answer| answer.rows.iter().map(|row| row.preload).sum::<f64>() / 2.0;
    assert!((side(&pair) - 294.0).abs() < 1e-9, "{}", side(&pair));
    assert!((side(&qbc) - 588.0).abs() < 1e-9, "{}", side(&qbc));
}

#[test]
fn a_mirrored_set_has_the_mirrored_result() {
    let mirror = [-1.0, 1.0, 1.0, -1.0, -1.0];
    for plan in [
        sprung(),
        clamped(
            &[(0.0, '+'), (0.05, '-'), (0.2, '-')],
            Preload::Force(200.0),
        ),
    ] {
        let mut mirrored = plan.clone();
        for row in &mut mirrored.rows {
            row.position = -row.position;
            row.facing = row.facing.opposite();
        }
        let question = loaded(SKEW, 9000.0);
        let a = ask(&plan, FREE, &question);
        let load = std::array::from_fn(|i| mirror[i] * SKEW[i]);
        let b = ask(&mirrored, FREE, &Question { load, ..question });
        let size = largest(a.displacement);
        for i in 0..5 {
            let off = (mirror[i] * b.displacement[i] - a.displacement[i]).abs() / size;
            assert!(off < 1e-11, "{i}: {off:e}");
        }
        let k = std::array::from_fn(|i| {
            std::array::from_fn(|j| mirror[i] * mirror[j] * b.stiffness[i][j])
        });
        assert!(stiffness_error(&k, &a.stiffness) < 1e-11);
        for (a, b) in a.rows.iter().zip(&b.rows) {
            assert!((a.force[0] / b.force[0] - 1.0).abs() < 1e-11);
        }
    }
}

/// Where x = 0 is on the shaft changes figures like those of any rigid body.
#[test]
fn another_point_of_reference_transforms_the_result() {
    let plan = sprung();
    let d = 0.08;
    let mut moved = plan.clone();
    for row in &mut moved.rows {
        row.position -= d;
    }
    let [fx, fy, fz, my, mz] = SKEW;
    let a = ask_at(&plan, FREE, &loaded(SKEW, 9000.0), d);
    // The same load, about the point that is x = 0 now.
    let load = [fx, fy, fz, my + d * fz, mz - d * fy];
    let b = ask_at(&moved, FREE, &loaded(load, 9000.0), 0.0);
    let [dx, dy, dz, ty, tz] = a.displacement;
    let there = [dx, dy + d * tz, dz - d * ty, ty, tz];
    let size = largest(there);
    for (a, b) in there.into_iter().zip(b.displacement) {
        assert!((a - b).abs() < 1e-11 * size, "{a:e} {b:e}");
    }
    assert!(stiffness_error(&b.stiffness, &a.stiffness_at) < 1e-11);
    for (found, truth) in [
        (&b.stiffness_at, &a.stiffness_at),
        (&b.compliance_at, &a.compliance_at),
    ] {
        assert!(stiffness_error(found, truth) < 1e-10);
    }
    // The compliance is the inverse of the stiffness.
    for i in 0..5 {
        for j in 0..5 {
            let sum: f64 = (0..5)
                .map(|l| a.compliance_at[i][l] * a.stiffness_at[l][j])
                .sum();
            let unit = if i == j { 1.0 } else { 0.0 };
            let scale = (a.stiffness_at[j][j] / a.stiffness_at[i][i]).sqrt();
            assert!(
                (sum - unit).abs() < 1e-10 * scale.max(1.0),
                "{i} {j}: {sum}"
            );
        }
    }
    for (a, b) in a.rows.iter().zip(&b.rows) {
        assert!((a.force[0] / b.force[0] - 1.0).abs() < 1e-11);
    }
}

/// The load is in balance with the rows, and the stiffness is the slope of the load by the displacement.
#[test]
fn the_tangent_is_that_of_central_differences() {
    let pair = clamped(&[(0.0, '+'), (0.027, '-')], Preload::Force(294.0));
    for (plan, rpm) in [
        (&pair, 0.0),
        (&pair, 15_000.0),
        (&sprung(), 12_000.0),
        (&sprung(), 0.0),
    ] {
        let at = ask(plan, FREE, &loaded(SKEW, rpm));
        let mut sum = [0.0; 5];
        for (row, plan) in at.rows.iter().zip(&plan.rows) {
            let (x, s) = (plan.position, plan.facing.sign::<f64>());
            let [fx, fy, fz, my, mz] = row.force;
            let on_shaft = [s * fx, fy, fz, s * my - x * fz, s * mz + x * fy];
            for (sum, f) in sum.iter_mut().zip(on_shaft) {
                *sum += f;
            }
        }
        for (sum, load) in sum.into_iter().zip(SKEW) {
            assert!((sum - load).abs() < 1e-8, "{sum} {load}");
        }
        for j in 0..5 {
            let step = if j < 3 { 0.5 } else { 0.02 };
            let [plus, minus] = [step, -step].map(|step| {
                let mut load = SKEW;
                load[j] += step;
                ask(plan, FREE, &loaded(load, rpm)).displacement
            });
            let du: [f64; 5] = std::array::from_fn(|i| (plus[i] - minus[i]) / (2.0 * step));
            for i in 0..5 {
                let force: f64 = (0..5).map(|l| at.stiffness[i][l] * du[l]).sum();
                let unit = if i == j { 1.0 } else { 0.0 };
                let scale = (at.stiffness[i][i] / at.stiffness[j][j]).sqrt();
                assert!(
                    (force - unit).abs() < 2e-6 * scale,
                    "{rpm} {i} {j}: {force}"
                );
            }
        }
    }
}

#[test]
fn no_growth_changes_no_bit() {
    let question = loaded(SKEW, 9000.0);
    let none = Growth {
        axial: -0.0,
        ..Growth::NONE
    };
    let grown = Question {
        growth: vec![none; 4],
        ..question.clone()
    };
    assert_eq!(
        ask(&sprung(), FREE, &question),
        ask(&sprung(), FREE, &grown)
    );
}

/// Growth of both rings of a clamped pair makes its preload grow; that of a pair under a spring leaves it.
#[test]
fn growth_preloads_a_clamped_pair_only() {
    let grown = Question {
        growth: vec![
            Growth {
                axial: 0.0,
                radial: 3e-6,
                ball: 0.0,
            };
            4
        ],
        ..loaded([0.0; 5], 0.0)
    };
    let pair = clamped(&[(0.0, '+'), (0.027, '-')], Preload::Force(294.0));
    let found = ask(&pair, Balls::Static, &grown);
    assert!(found.rows[0].preload > 400.0, "{}", found.rows[0].preload);
    let found = ask(&sprung(), Balls::Static, &grown);
    let rear = found.rows[2].force[0] + found.rows[3].force[0];
    assert!((rear - 600.0).abs() < 1e-9, "{rear}");
}

/// The figures of the model's page, which two other programs have found.
#[test]
fn a_pair_of_7014c_is_as_stiff_as_the_model_says() {
    let pair = |facing: [char; 2]| {
        let layout = [(-0.0135, facing[0]), (0.0135, facing[1])];
        clamped(&layout, Preload::Force(294.0))
    };
    let (back, face) = (pair(['+', '-']), pair(['-', '+']));
    for (rpm, [axial, radial, preload]) in [
        (0.0, [92.8, 526.7, 294.0]),
        (10_000.0, [66.3, 274.7, 727.0]),
        (20_000.0, [101.7, 253.0, 1785.0]),
    ] {
        let found = ask(&back, FREE, &loaded([0.0; 5], rpm));
        let [kxx, kyy] = [found.stiffness[0][0] / 1e6, found.stiffness[1][1] / 1e6];
        assert!(
            (kxx - axial).abs() < 0.06 && (kyy - radial).abs() < 0.06,
            "{rpm}: {kxx} {kyy}"
        );
        for row in &found.rows {
            assert!(
                (row.preload - preload).abs() < 0.6,
                "{rpm}: {}",
                row.preload
            );
        }
    }
    // The nose is 60 mm in front of the first row. There, the arrangement shows.
    for (plan, tilting, nose) in [(&back, 3.75e5, 61.4), (&face, 5.0e3, 0.923)] {
        let found = ask_at(plan, Balls::Static, &loaded([0.0; 5], 0.0), -0.0735);
        let tilt = found.stiffness[3][3] / tilting;
        assert!((tilt - 1.0).abs() < 0.01, "{tilt}");
        let radial = 1e-6 / found.compliance_at[1][1] / nose;
        assert!((radial - 1.0).abs() < 0.01, "{radial}");
    }
}
