//! The reference build of spindles on elastic shafts.

use super::solves::{self, size, vector_error};
use files::plan::Plan;
use host_tests::cases::{
    self, B7005C, SolvedElastic, elastic, public, reference_bearing, reference_spindle,
};
use host_tests::compare::{stiffness_error, worse};
use host_tests::reference::Attitude;
use host_tests::reference::spindle::{Row, Shaft, Solution, Solver, Spindle};
use std::array::from_fn;
use std::f64::consts::PI;

/// Solves cold for one load at `x = 0`.
fn solved(spindle: &Spindle, points: &[f64], case: &SolvedElastic) -> Solution {
    let question = &case.set.question;
    let solver = Solver::new(spindle, points);
    let attitude = case.set.attitude.into();
    let solution =
        solver.and_then(|mut s| s.solve(&[(0.0, question.load)], question.omega, attitude));
    solution.unwrap_or_else(|e| panic!("{}: {e}", case.set.name))
}

/// Errors of displacements, row and ball forces, contact angles, stiffness, flexibility; forces over the largest of
/// their kind in the set, displacements over the largest component.
fn errors(found: &Solution, case: &SolvedElastic) -> [f64; 5] {
    let set = &case.set;
    let design = &set.plan.rows[0].design;
    let (lengths, forces) = (solves::lengths(design), solves::forces(design));
    let (nose, at_nose) = (&found.points[0], &case.at_nose);
    let mut displacement = worse(
        vector_error(found.displacement, set.displacement, lengths),
        vector_error(nose.displacement, at_nose.displacement, lengths),
    );
    if let (Some(found), Some(closure)) = (found.sleeve, set.spring_closure) {
        displacement = worse(displacement, (found / closure - 1.0).abs());
    }
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, worse);
    let of_rows = largest(&mut set.rows.iter().map(|row| size(row.load, forces)));
    let of_balls = largest(&mut set.rows.iter().flat_map(|r| r.balls.iter().map(|b| b[3])));
    let (mut force, mut angle) = (0.0, 0.0);
    assert_eq!(found.rows.len(), set.rows.len());
    for (found, truth) in found.rows.iter().zip(&set.rows) {
        let off = from_fn(|i| found.force[i] - truth.load[i]);
        force = worse(force, size(off, forces) / of_rows);
        let moved = vector_error(found.displacement, truth.displacement, lengths);
        displacement = worse(displacement, moved);
        assert_eq!(found.balls.len(), truth.balls.len());
        for (ball, truth) in found.balls.iter().zip(&truth.balls) {
            for i in [0, 1] {
                force = worse(force, (ball[i + 2] - truth[i + 2]).abs() / of_balls);
                if truth[i + 2] > 0.0 {
                    angle = worse(angle, (ball[i] - truth[i]).abs());
                }
            }
        }
    }
    [
        displacement,
        force,
        angle,
        stiffness_error(&found.stiffness, &set.stiffness),
        stiffness_error(&nose.flexibility, &at_nose.flexibility),
    ]
}

#[test]
fn solved_cases_are_solved() {
    for case in elastic() {
        let found = solved(&case.reference(), &[case.nose], &case);
        let errors = errors(&found, &case);
        let within = errors.iter().all(|error| *error < 1e-11);
        assert!(within, "{}: {errors:?}", case.set.name);
    }
}

/// A bearing is a spindle with one row, and a set on a rigid shaft one without a shaft.
#[test]
fn rigid_cases_are_solved() {
    let check =
        |spindle: &Spindle, load, omega, attitude, u: [f64; 5], k: [[f64; 5]; 5], name: &str| {
            let found = Solver::new(spindle, &[])
                .and_then(|mut s| s.solve(&[(0.0, load)], omega, attitude));
            let found = found.unwrap_or_else(|e| panic!("{name}: {e}"));
            let radius = 0.5 * spindle.rows[0].bearing.pitch_diameter;
            let off = from_fn(|i| found.displacement[i] - u[i]);
            let lengths = [1.0, 1.0, 1.0, radius, radius];
            // An unloaded set has no displacement.
            let moved = size(off, lengths) / size(u, lengths).max(1e-9);
            let stiffness = stiffness_error(&found.stiffness, &k);
            assert!(
                moved < 1e-10 && stiffness < 1e-9,
                "{name}: {moved:e}, {stiffness:e}"
            );
        };
    // The cold start does not find number 48; `Reference::solve` does.
    let singles = public().into_iter().enumerate();
    for (_, solved) in singles.filter(|(number, _)| *number != 48) {
        let (case, truth) = (&solved.case, &solved.truth);
        let plan = Plan::alone(&case.design, case.balls);
        let spindle = reference_spindle(&plan, &[], &[], None);
        let (u, k) = (truth.displacement, truth.stiffness);
        check(
            &spindle,
            case.load,
            case.omega,
            case.reference_attitude(),
            u,
            k,
            &case.name,
        );
    }
    for set in cases::sets() {
        let (question, attitude) = (&set.question, set.attitude.into());
        let spindle = reference_spindle(&set.plan, &question.growth, &[], None);
        let (u, k) = (set.displacement, set.stiffness);
        check(
            &spindle,
            question.load,
            question.omega,
            attitude,
            u,
            k,
            &set.name,
        );
    }
}

/// A back to back pair at `x = 0`, and a section of 30 mm from 0 to `end`.
fn overhung(end: f64) -> Spindle {
    let row = |position, facing| Row {
        bearing: reference_bearing(&B7005C, 16),
        position,
        facing,
        closure: 8e-6,
        growth: [0.0; 3],
        slides: false,
        support: [None; 3],
    };
    Spindle {
        rows: vec![row(0.0, 1.0), row(-0.02 * end.signum(), -1.0)],
        shaft: Some(Shaft {
            youngs_modulus: 206e9,
            poissons_ratio: 0.3,
            sections: vec![[end.min(0.0), end.max(0.0), 30e-3, 0.0]],
        }),
        spring: None,
    }
}

/// `P l^3 / 3 E I + P l / kappa G A` and its kin, on both sides of `x = 0`.
#[test]
fn an_overhung_end_bends_like_a_cantilever() {
    let load = [50.0, 120.0, -70.0, 3.0, -5.0];
    let [fx, fy, fz, my, mz] = load;
    let ei = 206e9 * PI / 64.0 * 30e-3_f64.powi(4);
    let ea = 206e9 * PI / 4.0 * 30e-3_f64.powi(2);
    let shear = ea * 7.8 / 8.8 / 2.6;
    for l in [0.1_f64, -0.1, 1e-3] {
        let (a, s) = (l.abs(), l.signum());
        let mut solver = Solver::new(&overhung(l), &[l]).unwrap();
        let found = solver
            .solve(&[(l, load)], 500.0, Attitude::Raceless)
            .unwrap();
        let [dx, dy, dz, ty, tz] = found.displacement;
        let carried = [dx, dy + l * tz, dz - l * ty, ty, tz];
        let end = found.points[0].displacement;
        let deflection: [f64; 5] = from_fn(|i| end[i] - carried[i]);
        let by_force = a.powi(3) / (3.0 * ei) + a / shear;
        let (cross, turn) = (s * a * a / (2.0 * ei), a / ei);
        let beam = [
            fx * a / ea,
            fy * by_force + mz * cross,
            fz * by_force - my * cross,
            my * turn - fz * cross,
            mz * turn + fy * cross,
        ];
        let error = vector_error(deflection, beam, solves::lengths(&B7005C));
        assert!(error < 1e-9, "{l}: {error:e}");
    }
}

/// However short the parts.
#[test]
fn a_split_section_changes_nothing() {
    for case in elastic() {
        let mut spindle = case.reference();
        let whole = solved(&spindle, &[case.nose], &case);
        let near = spindle.rows[0].position + 1e-9;
        if let Some(shaft) = &mut spindle.shaft {
            let split = |&[from, to, outer, inner]: &[f64; 4]| {
                let middle = 0.3 * from + 0.7 * to;
                let inside = if from < near && near < middle {
                    near
                } else {
                    from
                };
                let ends = [[from, inside], [inside, middle], [middle, to]];
                ends.map(|[from, to]| [from, to, outer, inner])
            };
            shaft.sections = shaft.sections.iter().flat_map(split).collect();
        }
        let parts = solved(&spindle, &[case.nose], &case);
        let lengths = solves::lengths(&case.set.plan.rows[0].design);
        let [a, b] = [&parts.points[0], &whole.points[0]];
        let moved = vector_error(a.displacement, b.displacement, lengths);
        let flexibility = stiffness_error(&a.flexibility, &b.flexibility);
        let name = &case.set.name;
        assert!(
            moved < 1e-11 && flexibility < 1e-11,
            "{name}: {moved:e}, {flexibility:e}"
        );
    }
}

/// Loads at `x = 0`, at the nose and at a row, and the rows' forces.
#[test]
fn forces_and_moments_balance() {
    for case in elastic() {
        let set = &case.set;
        let question = &set.question;
        let spindle = case.reference();
        let mut solver = Solver::new(&spindle, &[case.nose]).unwrap();
        let half = question.load.map(|load| 0.5 * load);
        let loads = [
            (0.0, question.load),
            (case.nose, half),
            (spindle.rows[1].position, half),
        ];
        let found = solver.solve(&loads, question.omega, set.attitude.into());
        let found = found.unwrap_or_else(|e| panic!("{}: {e}", set.name));
        let mut sum = [0.0; 5];
        let mut add = |x: f64, [fx, fy, fz, my, mz]: [f64; 5], sign: f64| {
            let about_0 = [fx, fy, fz, my - x * fz, mz + x * fy];
            sum = from_fn(|i| sum[i] + sign * about_0[i]);
        };
        loads.iter().for_each(|&(x, load)| add(x, load, 1.0));
        for (row, at) in found.rows.iter().zip(&spindle.rows) {
            let [fx, fy, fz, my, mz] = row.force;
            let s = at.facing;
            add(at.position, [s * fx, fy, fz, s * my, s * mz], -1.0);
        }
        let forces = solves::forces(&set.plan.rows[0].design);
        let rows = found.rows.iter().map(|row| size(row.force, forces));
        let error = size(sum, forces) / rows.fold(0.0, worse);
        assert!(error < 1e-11, "{}: {error:e}", set.name);
    }
}

/// Springs in series: bearing and support.
#[test]
fn a_support_adds_its_flexibility() {
    let load = [300.0, 80.0, -40.0, 0.5, 1.0];
    let [axial, radial, tilting] = [2e8, 5e8, 3e6];
    let mut spindle = overhung(0.1);
    spindle.rows.truncate(1);
    let mut solve = || {
        let mut solver = Solver::new(&spindle, &[0.0]).unwrap();
        let found = solver
            .solve(&[(0.0, load)], 1500.0, Attitude::Raceless)
            .unwrap();
        spindle.rows[0].support = [axial, radial, tilting].map(Some);
        found
    };
    let [rigid, held] = [solve(), solve()];
    for (i, k) in [axial, radial, radial, tilting, tilting]
        .into_iter()
        .enumerate()
    {
        let moved = held.displacement[i] - rigid.displacement[i];
        assert!((moved * k / load[i] - 1.0).abs() < 1e-10, "{i}: {moved:e}");
        let [a, b] = [&held, &rigid].map(|found| found.points[0].flexibility[i][i]);
        assert!(((a - b) * k - 1.0).abs() < 1e-9, "{i}: {a:e}, {b:e}");
    }
}

/// Stiffness and flexibilities are those of the load-displacement map; solves are warm.
#[test]
fn tangents_are_central_differences() {
    let cases = elastic().into_iter();
    for case in cases.filter(|case| case.set.question.omega > 0.0) {
        let (set, question) = (&case.set, &case.set.question);
        let mut solver = Solver::new(&case.reference(), &[0.0, case.nose]).unwrap();
        let forces = solves::forces(&set.plan.rows[0].design);
        let step = 1e-4 * size(question.load, forces);
        let mut moved = |column: usize, sign: f64| {
            let mut more = [0.0; 5];
            more[column] = sign * step / forces[column];
            let loads = [(0.0, question.load), (case.nose, more)];
            let found = solver.solve(&loads, question.omega, set.attitude.into());
            found.unwrap_or_else(|e| panic!("{}: {e}", set.name)).points[1].displacement
        };
        let mut columns = [[0.0; 5]; 5];
        for j in 0..5 {
            let [a, b] = [moved(j, 1.0), moved(j, -1.0)];
            columns[j] = from_fn(|i| (a[i] - b[i]) * forces[j] / (2.0 * step));
        }
        let found = solved(&case.reference(), &[0.0, case.nose], &case);
        let by_difference = from_fn(|i| from_fn(|j| columns[j][i]));
        let error = stiffness_error(&found.points[1].flexibility, &by_difference);
        assert!(error < 1e-5, "{}: {error:e}", set.name);
        // Stiffness and flexibility at x = 0 are inverse.
        let c = &found.points[0].flexibility;
        for i in 0..5 {
            for j in 0..5 {
                let product: f64 = (0..5).map(|l| found.stiffness[i][l] * c[l][j]).sum();
                let unit = f64::from(u8::from(i == j));
                let scale = (found.stiffness[i][i] / found.stiffness[j][j]).sqrt();
                assert!((product - unit).abs() < 1e-10 * scale, "{}", set.name);
            }
        }
    }
}
