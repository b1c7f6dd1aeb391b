//! Several bearings on one shaft.

use host_tests::campaign::balance::friction;
use host_tests::cases::{Case, Random, SKF6205, SolvedSet, sets};
use host_tests::compare::{stiffness_error, worse};
use host_tests::dispatch::{self, Attitude, Precision};
use host_tests::spindles::{Answer, AnySpindleSolver, Balls, Plan, Question, Row, with_solver};
use rayon::prelude::*;
use spindle_bearing::{
    Arrangement, BallState, Design, Facing, FreeContact, Growth, Material, Preload, ShaftEnd,
    Status,
};
use std::f64::consts::TAU;

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
    let ask = |solver: &mut dyn AnySpindleSolver| solver.solve(&set.question, &AT_0);
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

/// Where loads act.
const AT_0: ShaftEnd<f64> = ShaftEnd::rigid(0.0);
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
        solver.solve(question, &ShaftEnd::rigid(x))
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
        // Under inner race control at rest, too, where nothing turns.
        for balls in [FREE, Balls::Static, Balls::Moving(Attitude::Inner)] {
            let mut plain = match balls {
                Balls::Static => bearing.static_solver(),
                Balls::Moving(attitude) => bearing.solver(attitude),
            };
            let compare = |solver: &mut dyn AnySpindleSolver| {
                for step in 0..200 {
                    // Near loads, and far ones that are solved cold.
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
                    match (figures, solver.solve(&question, &AT_0)) {
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
    let single = clamped(&[(0.02, '+')], Preload::Closure(0.0));
    let mut deep_grooves = clamped(&[(0.0, '+'), (0.15, '-')], Preload::Closure(0.0));
    for row in &mut deep_grooves.rows {
        (row.design, row.balls) = (SKF6205, 9);
    }
    for plan in [
        sprung(),
        clamped(
            &[(0.0, '+'), (0.05, '-'), (0.2, '-')],
            Preload::Force(200.0),
        ),
        single,
        deep_grooves,
    ] {
        let mut mirrored = plan.clone();
        for row in &mut mirrored.rows {
            row.position = -row.position;
            row.facing = row.facing.opposite();
        }
        let mut question = loaded(SKEW, 9000.0);
        question.load[0] *= 4.0;
        let load = std::array::from_fn(|i| mirror[i] * question.load[i]);
        let back = Question {
            load,
            ..question.clone()
        };
        for (precision, bound) in [(Precision::F64, 1e-11), (Precision::F32, 1e-5)] {
            let [a, b] = [(&plan, &question), (&mirrored, &back)].map(|(plan, question)| {
                let ask = |solver: &mut dyn AnySpindleSolver| solver.solve(question, &AT_0);
                with_solver(plan, FREE, precision, ask).unwrap().unwrap()
            });
            let size = largest(a.displacement);
            for i in 0..5 {
                let off = (mirror[i] * b.displacement[i] - a.displacement[i]).abs() / size;
                assert!(off < bound, "{precision:?}, {i}: {off:e}");
            }
            let k = std::array::from_fn(|i| {
                std::array::from_fn(|j| mirror[i] * mirror[j] * b.stiffness[i][j])
            });
            let off = stiffness_error(&k, &a.stiffness);
            assert!(off < bound, "{precision:?}: {off:e}");
            for (a, b) in a.rows.iter().zip(&b.rows) {
                let force = a.balls.iter().fold(0.0, |m, ball| worse(m, ball.q_o));
                for (a, b) in a.balls.iter().zip(&b.balls) {
                    let off = worse((a.q_i - b.q_i).abs(), (a.q_o - b.q_o).abs()) / force;
                    assert!(off < bound, "{precision:?}: {off:e}");
                }
                let off = (a.frequencies.cage / b.frequencies.cage - 1.0).abs();
                assert!(off < bound, "{precision:?}: {off:e}");
            }
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

/// A random spindle that a designer might draw: one to four rows of one or two kinds, clamped or with a sleeve, under loads
/// about as large as its preload, grown a little.
fn random(seed: u64) -> (Plan, Attitude, Question) {
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
            x += width
                * if i == turn {
                    r.log_between(1.0, 10.0)
                } else {
                    1.0
                };
            let design = kind.design;
            let rating = 12e6 * kind.balls as f64 * design.ball_diameter.powi(2);
            preload = preload.min(rating * r.log_between(2e-3, 5e-2));
            limit = limit.min(1500.0 / design.pitch_diameter);
            let first = i < turn;
            let held = if spring && !first {
                Preload::Spring
            } else {
                // That of a force; for sets whose rows do not face each other, too.
                Preload::Closure(design.centre_distance() * r.log_between(2e-3, 5e-2))
            };
            Row {
                balls: kind.balls,
                design,
                position: x,
                facing: if first == face_to_face {
                    Facing::MinusX
                } else {
                    Facing::PlusX
                },
                preload: held,
            }
        })
        .collect();
    let rpm = if r.chance(0.2) {
        0.0
    } else {
        r.between(0.0, limit)
    };
    let (to, about) = (r.between(0.0, TAU), r.between(0.0, TAU));
    let [axial, radial, moment] = [0.5, 1.0, 0.5].map(|most| r.between(0.0, most) * preload);
    let span = 0.5 * kinds[0].design.pitch_diameter;
    let alone = rows.iter().all(|row| row.facing == rows[0].facing);
    let pressing = if alone {
        3.0 * preload * rows[0].facing.sign::<f64>()
    } else {
        0.0
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
        rows,
        arrangement: Arrangement::ByRows,
        spring: spring.then_some(preload),
    };
    (
        plan,
        kinds[0].attitude,
        Question {
            growth,
            ..loaded(load, rpm)
        },
    )
}

/// Both precisions' answers to a random spindle, unless one refuses it.
fn in_both(plan: &Plan, attitude: Attitude, question: &Question) -> Option<[Answer; 2]> {
    let [double, single] = [Precision::F64, Precision::F32].map(|precision| {
        let ask = |solver: &mut dyn AnySpindleSolver| solver.solve(question, &AT_0);
        with_solver(plan, Balls::Moving(attitude), precision, ask).unwrap_or_else(|e| panic!("{e}"))
    });
    Some([double.ok()?, single.ok()?])
}

/// Displacement of a clamped row's ring, in its own frame, for one of the shaft at `x = 0`.
fn displacement_of(row: &Row, [dx, dy, dz, ty, tz]: [f64; 5]) -> [f64; 5] {
    let (x, s) = (row.position, row.facing.sign::<f64>());
    let Preload::Closure(closure) = row.preload else {
        panic!("clamped")
    };
    [s * dx + closure, dy + x * tz, dz - x * ty, s * ty, s * tz]
}

/// Distance of the rows' forces from the reference build's law, and of the shaft from balance, over the largest force; whether
/// the law covers every row that carries. The rows are clamped and have not grown.
fn off_law(
    plan: &Plan,
    attitude: Attitude,
    question: &Question,
    answer: &Answer,
) -> ([f64; 2], bool) {
    let mut judged = true;
    let (mut law, mut sum) = (0.0, [0.0; 5]);
    let largest_force = largest(answer.rows.iter().flat_map(|row| row.force[..3].to_vec()));
    for (row, found) in plan.rows.iter().zip(&answer.rows) {
        let (x, s) = (row.position, row.facing.sign::<f64>());
        let u = displacement_of(row, answer.displacement);
        let case = Case {
            name: String::new(),
            balls: row.balls,
            design: row.design,
            attitude,
            load: found.force,
            omega: question.omega,
        };
        let reference = case.reference();
        let truth = reference.law(u, case.omega, case.reference_attitude());
        let radius = case.pitch_radius();
        let scale = [1.0, 1.0, 1.0, 1.0 / radius, 1.0 / radius];
        // It has no answer where no ball of a row carries.
        let force = truth.map_or_else(
            |_| {
                judged &= found.balls.iter().all(|ball| ball.q_i == 0.0);
                found.force
            },
            |truth| truth.force,
        );
        for i in 0..5 {
            let off = (found.force[i] - force[i]).abs();
            law = worse(law, scale[i] * off / largest_force);
        }
        let [fx, fy, fz, my, mz] = found.force;
        let on_shaft = [s * fx, fy, fz, s * my - x * fz, s * mz + x * fy];
        for (sum, f) in sum.iter_mut().zip(on_shaft) {
            *sum += f;
        }
    }
    let span =
        largest(plan.rows.iter().map(|row| row.position)) + plan.rows[0].design.pitch_diameter;
    let scale = [1.0, 1.0, 1.0, 1.0 / span, 1.0 / span];
    let balance = largest((0..5).map(|i| scale[i] * (sum[i] - question.load[i])));
    ([law, balance / largest_force], judged)
}

/// Clamped rows that face each other hold any shaft, cold from the first solve on, and each row carries what the
/// reference build says of its displacement.
#[test]
fn random_clamped_spindles_are_what_the_reference_build_says() {
    let off: Vec<[f64; 3]> = (0..600)
        .into_par_iter()
        .filter_map(|seed| {
            let (plan, attitude, question) = random(seed);
            let first = plan.rows[0].facing;
            if plan.spring.is_some() || plan.rows.iter().all(|row| row.facing == first) {
                return None;
            }
            let grown = in_both(&plan, attitude, &question);
            let cold = Question {
                growth: Vec::new(),
                ..question
            };
            let [a, b] = in_both(&plan, attitude, &cold).unwrap_or_else(|| panic!("{seed}"));
            let [c, d] = grown.unwrap_or_else(|| panic!("{seed}, grown"));
            let single = worse(
                stiffness_error(&b.stiffness, &a.stiffness),
                stiffness_error(&d.stiffness, &c.stiffness),
            );
            let ([law, balance], judged) = off_law(&plan, attitude, &cold, &a);
            assert!(judged, "{seed}");
            Some([law, balance, single])
        })
        .collect();
    let worst = off.iter().fold([0.0; 3], |worst, off| {
        std::array::from_fn(|i| worse(worst[i], off[i]))
    });
    println!(
        "{} spindles: law, balance, stiffness in single precision {worst:?}",
        off.len()
    );
    assert!(off.len() > 200);
    assert!(
        worst[0] < 1e-12 && worst[1] < 1e-13 && worst[2] < 5e-5,
        "{worst:?}"
    );
}

/// A ball that hardly presses the outer race, next to the inner one: the least force swings it through. One in thirty of these
/// loads had no answer.
#[test]
fn balls_that_swing_against_the_inner_race_find_their_place() {
    let plan = clamped(
        &[(0.0, '+'), (46.615e-3, '+'), (157.430e-3, '-')],
        Preload::Force(31.325),
    );
    let refused = |solver: &mut dyn AnySpindleSolver| {
        let mut r = Random::seeded(3);
        let mut refused = Vec::new();
        for _ in 0..500 {
            let load =
                [-1042.055, -1299.63, -2167.465, 0.0, 0.0].map(|f| f * r.between(0.95, 1.05));
            solver.reset();
            if let Err(status) = solver.solve(&loaded(load, 100.0), &AT_0) {
                refused.push((load, status));
            }
        }
        refused
    };
    let refused = with_solver(&plan, FREE, Precision::F64, refused).unwrap();
    assert!(
        refused.is_empty(),
        "{}: {:?}",
        refused.len(),
        refused.first()
    );
}

/// Whether inertia counts is for all rows together: one of small balls may come first.
#[test]
fn a_light_first_row_does_not_take_the_others_inertia() {
    let mut plan = clamped(&[(0.0, '+'), (0.1, '-')], Preload::Closure(10e-6));
    plan.rows[0].balls = 12;
    plan.rows[0].design = Design::angular_contact(1e-3, 6e-3, 15f64.to_radians());
    plan.rows[0].preload = Preload::Closure(0.5e-6);
    let question = loaded([-50.0, 40.0, 20.0, 0.0, 0.0], 150.0);
    let [single, double] = [Precision::F32, Precision::F64].map(|precision| {
        let ask = |solver: &mut dyn AnySpindleSolver| solver.solve(&question, &AT_0);
        with_solver(&plan, FREE, precision, ask).unwrap().unwrap()
    });
    for (a, b) in single.rows[1].balls.iter().zip(&double.rows[1].balls) {
        let (a, b) = (a.centrifugal_force, b.centrifugal_force);
        assert!(b > 0.0 && (a / b - 1.0).abs() < 1e-4, "{a:e} {b:e}");
    }
}

/// How far the balls of a row are from the model's equations at the displacement `u` of its ring: the triangle of the grooves'
/// and the ball's centres, over `L0`, and the balance of each ball, over the largest force.
fn off_equations(row: &Row, attitude: Attitude, u: [f64; 5], balls: &[BallState<f64>]) -> [f64; 2] {
    let d = &row.design;
    let FreeContact::Angle(alpha0) = d.free_contact else {
        panic!("angular contact")
    };
    let (l0, (sin0, cos0)) = (d.centre_distance(), alpha0.sin_cos());
    let [li, lo] =
        [d.inner_groove_factor, d.outer_groove_factor].map(|f| (f - 0.5) * d.ball_diameter);
    let (rp, zp) = (0.5 * d.pitch_diameter + li * cos0, li * sin0);
    let [dx, dy, dz, ty, tz] = u;
    let force = balls.iter().map(|b| b.q_i.max(b.q_o));
    let force = force.fold(f64::MIN_POSITIVE, f64::max);
    let mut off = [0.0; 2];
    for (j, b) in balls.iter().enumerate() {
        // Between the races at rest, a ball without force has no place of its own.
        if b.q_i == 0.0 && b.q_o == 0.0 {
            continue;
        }
        let (sin, cos) = (d.first_ball + TAU * j as f64 / row.balls as f64).sin_cos();
        let ((si, ci), (so, co)) = (b.alpha_i.sin_cos(), b.alpha_o.sin_cos());
        let [ri, ro] = [li + b.delta_i, lo + b.delta_o];
        let axial = l0 * sin0 + dx + rp * (ty * sin - tz * cos) - ri * si - ro * so;
        let radial = l0 * cos0 + (dy + zp * tz) * cos + (dz - zp * ty) * sin - ri * ci - ro * co;
        off[0] = worse(off[0], axial.hypot(radial) / l0);
        let [ti, to] = friction(b, attitude, d.ball_diameter);
        let axial = b.q_i * si - b.q_o * so + ti * ci - to * co;
        let radial = b.q_i * ci - b.q_o * co - ti * si + to * so + b.centrifugal_force;
        off[1] = worse(off[1], axial.hypot(radial) / force);
    }
    off
}

/// Rows a metre apart under ten kilonewtons and closures of a millimetre: an answer satisfies the equations, or there is none.
/// Where a ball has several places at one displacement, it is in one of them: the reference build's law may have another.
#[test]
fn answers_of_wild_spindles_satisfy_the_equations() {
    let solved: Vec<[f64; 3]> = (0..5000)
        .into_par_iter()
        .filter_map(|seed| {
            let (mut plan, attitude, question) = random(seed);
            let mut r = Random::seeded(seed ^ 0x1234);
            for (i, row) in plan.rows.iter_mut().enumerate() {
                row.position = i as f64 + r.between(-0.4, 0.4);
                let most = 0.249 * row.design.centre_distance();
                row.preload = Preload::Closure(most.min(1e-3) * r.between(-1.0, 1.0));
            }
            plan.spring = None;
            let moment = 1e4 * r.between(-1.0, 1.0);
            let load = [1e4, 1e4, 1e4, moment, moment].map(|f| f * r.between(-1.0, 1.0));
            let question = loaded(load, question.omega * 30.0 / std::f64::consts::PI);
            let ask = |solver: &mut dyn AnySpindleSolver| solver.solve(&question, &AT_0);
            let found = with_solver(&plan, Balls::Moving(attitude), Precision::F64, ask).ok()?;
            let found = found.ok()?;
            let ([_, balance], _) = off_law(&plan, attitude, &question, &found);
            let mut worst = [0.0, 0.0, balance];
            for (row, answer) in plan.rows.iter().zip(&found.rows) {
                let u = displacement_of(row, found.displacement);
                let [place, force] = off_equations(row, attitude, u, &answer.balls);
                worst = [worse(worst[0], place), worse(worst[1], force), worst[2]];
            }
            Some(worst)
        })
        .collect();
    let worst = solved.iter().fold([0.0; 3], |worst, off| {
        std::array::from_fn(|i| worse(worst[i], off[i]))
    });
    println!(
        "{} wild spindles: places, balls, shaft {worst:?}",
        solved.len()
    );
    assert!(solved.len() > 1000 && largest(worst) < 1e-9, "{worst:?}");
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
    assert!(
        asked.len() > 200 && 100 * solved.len() > 90 * asked.len(),
        "{} of {}",
        solved.len(),
        asked.len()
    );
    // Some have several equilibria, and the last of the starts may lead to another one in the other precision.
    let alike = |[a, b]: &&[Answer; 2]| stiffness_error(&b.stiffness, &a.stiffness) < 2e-4;
    let alike = solved.iter().filter(alike).count();
    assert!(
        100 * alike >= 99 * solved.len(),
        "{alike} of {}",
        solved.len()
    );
}

/// What the solver keeps from one solve to the next does not drift: after many ticks, a cold solve has the
/// same result.
#[test]
fn a_long_run_ends_where_a_cold_solve_does() {
    let pair = clamped(&[(0.0, '+'), (0.027, '-')], Preload::Force(294.0));
    for plan in [&pair, &sprung()] {
        let run = |solver: &mut dyn AnySpindleSolver| {
            let mut last = None;
            for tick in 0..20_000 {
                let phase = 0.07 * f64::from(tick);
                let part = [
                    phase.sin(),
                    phase.cos(),
                    (1.7 * phase).sin(),
                    1.0,
                    phase.cos(),
                ];
                let load = std::array::from_fn(|i| SKEW[i] * part[i]);
                let grown = 1e-6 * (1.0 + (0.003 * phase).sin());
                let growth = Growth {
                    axial: 0.0,
                    radial: grown,
                    ball: 0.0,
                };
                let question = Question {
                    growth: vec![growth; 4],
                    ..loaded(load, 8000.0 + 4000.0 * (0.01 * phase).sin())
                };
                let found = solver
                    .solve(&question, &AT_0)
                    .unwrap_or_else(|e| panic!("{tick}: {e}"));
                last = Some((question, found));
            }
            let (question, warm) = last.unwrap();
            solver.reset();
            (warm, solver.solve(&question, &AT_0).unwrap())
        };
        let (warm, cold) = with_solver(plan, FREE, Precision::F32, run).unwrap();
        assert!(stiffness_error(&warm.stiffness, &cold.stiffness) < 2e-5);
        for (warm, cold) in warm.rows.iter().zip(&cold.rows) {
            assert!(
                (warm.force[0] / cold.force[0] - 1.0).abs() < 2e-6,
                "{warm:?} {cold:?}"
            );
        }
    }
}

/// GMN's factors of arrangements against a pair of the same bearings, their catalogue p. 63.
#[test]
fn sets_of_three_and_four_have_the_makers_factors() {
    // Bearings that are ground for a pair's preload, at the contact angles of the series.
    for degrees in [15.0f64, 25.0] {
        let set = |facing: &str| {
            let layout: Vec<(f64, char)> = facing
                .chars()
                .enumerate()
                .map(|(i, c)| (0.027 * i as f64, c))
                .collect();
            let mut plan = clamped(&layout, Preload::Force(300.0));
            for row in &mut plan.rows {
                row.design.free_contact = FreeContact::Angle(degrees.to_radians());
            }
            let found = ask(&plan, Balls::Static, &loaded([0.0; 5], 0.0));
            let preload = found.rows.iter().map(|row| row.preload).sum::<f64>() / 2.0;
            [preload, found.stiffness[0][0]]
        };
        let pair = set("+-");
        for (facing, [preload, rigidity]) in [
            ("++-", [1.35, 1.45]),
            ("++--", [2.0, 2.0]),
            ("+++-", [1.6, 1.8]),
        ] {
            let found = set(facing);
            for (found, pair, maker) in
                [(found[0], pair[0], preload), (found[1], pair[1], rigidity)]
            {
                let off = found / pair / maker - 1.0;
                println!(
                    "{degrees} {facing}: {:.3}, {maker} by the maker",
                    found / pair
                );
                assert!(
                    off.abs() < 0.03,
                    "{degrees} degrees, {facing}: {:.3} instead of {maker}",
                    found / pair
                );
            }
        }
    }
}

#[test]
fn rows_that_are_no_such_set_are_refused() {
    let preload = Preload::Force(294.0);
    let refusal = |plan: &Plan| match with_solver(plan, FREE, Precision::F64, |_| ()) {
        Ok(()) => panic!("{plan:?}"),
        Err(error) => error.to_string(),
    };
    let called = |layout: &[(f64, char)], arrangement| Plan {
        arrangement,
        ..clamped(layout, preload)
    };
    let back = [(0.0, '+'), (0.027, '-')];
    let face = [(0.0, '-'), (0.027, '+')];
    for (plan, part) in [
        (
            called(&face, Arrangement::BackToBack),
            "row 1 faces +x, which is not back-to-back",
        ),
        (
            called(&back, Arrangement::FaceToFace),
            "row 1 faces -x, which is not face-to-face",
        ),
        (called(&back, Arrangement::Tandem), "which is not tandem"),
        (
            called(&[(0.0, '+'), (0.027, '+')], Arrangement::BackToBack),
            "which is not back-to-back",
        ),
        (
            called(&[(0.0, '+'), (0.0, '-')], Arrangement::BackToBack),
            "nearer than half a ball's diameter",
        ),
        (
            called(&[(0.0, '+'), (0.0059, '-')], Arrangement::BackToBack),
            "nearer than half a ball's diameter",
        ),
        (
            called(&[(0.0, '+'), (0.027, '+')], Arrangement::Tandem),
            "row 0 is preloaded, but no clamped row faces it",
        ),
        (
            called(&[(0.0, '+'), (f64::NAN, '-')], Arrangement::BackToBack),
            "row 1: position of the row from the first one (m) is NaN",
        ),
        (
            called(&[(0.0, '+'), (1e9, '-')], Arrangement::BackToBack),
            "beyond the",
        ),
        (
            clamped(&back, Preload::Force(-1.0)),
            "row 0 is preloaded by -1 N",
        ),
        (
            clamped(&back, Preload::Closure(f64::INFINITY)),
            "row 0: closure e of the row (m) is inf",
        ),
        (
            clamped(&back, Preload::Spring),
            "nothing holds the shaft along its axis",
        ),
        (
            Plan {
                spring: Some(100.0),
                ..clamped(&back, preload)
            },
            "no row slides",
        ),
        (
            Plan {
                spring: None,
                ..sprung()
            },
            "but there is no spring",
        ),
        (
            Plan {
                spring: Some(0.0),
                ..sprung()
            },
            "row 2 is preloaded by 0 N",
        ),
        (
            Plan {
                spring: Some(f64::NAN),
                ..sprung()
            },
            "row 2: force of the spring (N) is NaN",
        ),
    ] {
        let found = refusal(&plan);
        assert!(found.contains(part), "{found}\nwithout: {part}");
    }
    // Two rows in a sleeve that face the same way as the clamped ones.
    let mut plan = sprung();
    for row in &mut plan.rows {
        row.facing = Facing::PlusX;
    }
    plan.arrangement = Arrangement::ByRows;
    assert!(refusal(&plan).contains("row 2 is preloaded, but no clamped row faces it"));
}

/// Any bit pattern ends in an answer or in a refusal that names what is wrong.
#[test]
fn wild_questions_end_in_an_answer_or_a_refusal() {
    let pair = clamped(&[(0.0, '+'), (0.027, '-')], Preload::Force(294.0));
    for precision in [Precision::F32, Precision::F64] {
        for plan in [&pair, &sprung()] {
            let run = |solver: &mut dyn AnySpindleSolver| {
                let mut r = Random::seeded(7);
                for _ in 0..2000 {
                    let mut wild = |usual: f64| {
                        if r.chance(0.2) {
                            f64::from(f32::from_bits(r.bits() as u32))
                        } else {
                            usual * r.between(-1.0, 1.0)
                        }
                    };
                    let load = SKEW.map(&mut wild);
                    let growth = [0; 4].map(|_| Growth {
                        axial: wild(1e-6),
                        radial: wild(1e-6),
                        ball: wild(1e-6),
                    });
                    let question = Question {
                        growth: growth.to_vec(),
                        ..loaded(load, wild(20_000.0))
                    };
                    if let Ok(found) = solver.solve(&question, &ShaftEnd::rigid(-0.06)) {
                        let figures = found
                            .displacement
                            .into_iter()
                            .chain(found.stiffness.into_iter().flatten());
                        let rows = found.rows.iter().flat_map(|row| row.force);
                        let there = found.compliance_at.into_iter().flatten();
                        assert!(
                            figures.chain(rows).chain(there).all(f64::is_finite),
                            "{question:?}\n{found:?}"
                        );
                    }
                }
            };
            with_solver(plan, FREE, precision, run).unwrap();
        }
    }
}

/// The axial load that lifts a side off is a little more than the maker's, whose contact angle does not grow with the load.
#[test]
fn a_row_that_has_lifted_off_says_so() {
    let pair = clamped(&[(0.0, '+'), (0.027, '-')], Preload::Force(300.0));
    let preload = |factor: f64| {
        let found = ask(
            &pair,
            Balls::Static,
            &loaded([factor * 300.0, 0.0, 0.0, 0.0, 0.0], 0.0),
        );
        (
            found.rows[0].preload,
            found.rows[1].preload,
            found.rows[1].lifted_off,
        )
    };
    let (a, b, off) = preload(2.5);
    assert!(a > 5.0 && (a - b).abs() < 1e-9 && !off, "{a} {b}");
    let (a, b, off) = preload(4.0);
    assert!(a == 0.0 && b == 0.0 && off, "{a} {b}");
}
