//! The solver and the reference build against solved cases and against each other.

use host_tests::cases::{Case, public};
use host_tests::compare::{Ball, Equilibrium, Errors, worse};
use host_tests::dispatch::{self, Attitude, Precision};
use host_tests::reference::Reference;
use host_tests::tolerances::{TOLERANCES, allowed, allowed_at, allowed_of_reference};
use rayon::prelude::*;
use spindle_bearing::BallState;

const PRECISIONS: [Precision; 2] = [Precision::F64, Precision::F32];

/// What the solver finds for a case, or why it finds nothing.
struct Found {
    equilibrium: Equilibrium,
    balls: Vec<BallState<f64>>,
}

#[derive(Debug, Clone, Copy)]
enum Scene {
    Static,
    AtSpeed,
}

fn solve(case: &Case, precision: Precision, scene: Scene) -> Result<Found, String> {
    let bearing =
        dispatch::bearing(&case.design, case.balls, precision).map_err(|e| e.to_string())?;
    let mut solver = match scene {
        Scene::Static => bearing.static_solver(),
        Scene::AtSpeed => bearing.solver(case.attitude),
    };
    let mut balls = Vec::new();
    let answer = solver.solve_with_balls(case.load, case.omega, Some(&mut balls));
    let figures = answer
        .figures
        .map_err(|why| format!("{}: {why}", answer.status))?;
    Ok(Found {
        equilibrium: Equilibrium {
            displacement: figures.displacement,
            stiffness: figures.stiffness,
            balls: balls.iter().map(Ball::from).collect(),
        },
        balls,
    })
}

fn errors(found: &Equilibrium, truth: &Equilibrium, case: &Case) -> Errors {
    found.errors(truth, case.design.ball_diameter, case.pitch_radius())
}

/// The worst errors of a set of cases, and a line for every case that is further off than allowed.
#[derive(Default)]
struct Judgement {
    cases: usize,
    worst: Errors,
    failures: Vec<String>,
}

impl Judgement {
    fn add(&mut self, name: &str, errors: Errors, allowed: Errors) {
        self.cases += 1;
        self.worst = self.worst.worse(errors);
        if !errors.within(allowed) {
            self.failures.push(format!("{name}: {errors}"));
        }
    }

    fn append(&mut self, other: Self) {
        self.cases += other.cases;
        self.worst = self.worst.worse(other.worst);
        self.failures.extend(other.failures);
    }

    fn unsolved(&mut self, name: &str, why: &str) {
        self.cases += 1;
        self.failures.push(format!("{name}: {why}"));
    }

    /// Prints the worst errors; returns what there is to complain of.
    fn verdict(self, what: &str, allowed: Errors) -> String {
        println!("{what}, {} cases: {}", self.cases, self.worst);
        if self.failures.is_empty() {
            return String::new();
        }
        format!(
            "{what}: {} of {} cases fail (allowed: {allowed})\n{}\n",
            self.failures.len(),
            self.cases,
            self.failures.join("\n")
        )
    }
}

/// Fails with the complaints of all judgements, if there are any.
fn pass(verdicts: impl IntoIterator<Item = String>) {
    let complaints: String = verdicts.into_iter().collect();
    assert!(complaints.is_empty(), "\n{complaints}");
}

/// Solves a case in every scene it fits into and lets `judge` say how far off the answers are.
fn solve_and_judge(
    case: &Case,
    precision: Precision,
    judgement: &mut Judgement,
    mut judge: impl FnMut(&Found) -> Errors,
) {
    for &scene in scenes(case) {
        let name = format!("{}, {:?}, {scene:?}", case.name, case.attitude);
        match solve(case, precision, scene) {
            Ok(found) => {
                let largest = found.equilibrium.largest_displacement(case.pitch_radius());
                let allowed = allowed_at(precision, largest / case.design.centre_distance());
                judgement.add(&name, judge(&found), allowed);
            }
            Err(why) => judgement.unsolved(&name, &why),
        }
    }
}

fn scenes(case: &Case) -> &'static [Scene] {
    if case.omega == 0.0 {
        &[Scene::AtSpeed, Scene::Static]
    } else {
        &[Scene::AtSpeed]
    }
}

#[test]
fn the_allowed_errors_are_at_most_the_promised_ones() {
    let promised = [(1e-9, 1e-5), (1e-9, 1e-4), (1e-9, 1e-4), (1e-8, 1e-3)];
    for (row, (f64, f32)) in TOLERANCES.iter().zip(promised) {
        assert!(row.f64 <= f64 && row.f32 <= f32, "{row:?}");
        assert!(
            row.reference <= 1e-12 && row.reference <= row.f64,
            "{row:?}"
        );
    }
}

#[test]
fn the_reference_build_reproduces_the_solved_cases() {
    let mut judgement = Judgement::default();
    let allowed = allowed_of_reference();
    for solved in public() {
        let case = &solved.case;
        let reference = case.reference();
        match reference.solve(case.load, case.omega, case.reference_attitude()) {
            Ok(s) => {
                let e = errors(&Equilibrium::from(&s), &solved.truth, case);
                judgement.add(&case.name, e, allowed);
                let (ki, ko) = reference.hertz_constants();
                for (k, truth) in [ki, ko].into_iter().zip(solved.hertz) {
                    assert!(
                        (k / truth - 1.0).abs() < 1e-14,
                        "{}: {k} {truth}",
                        case.name
                    );
                }
            }
            Err(why) => judgement.unsolved(&case.name, &why.to_string()),
        }
    }
    pass([judgement.verdict("reference build, solved cases", allowed)]);
}

#[test]
fn the_solved_cases_lie_on_the_branch_from_rest() {
    let mut judgement = Judgement::default();
    let allowed = allowed_of_reference();
    for solved in public() {
        let case = &solved.case;
        let found = case
            .reference()
            .from_rest(case.load, case.omega, case.reference_attitude());
        match found {
            Ok(s) => {
                let e = errors(&Equilibrium::from(&s), &solved.truth, case);
                judgement.add(&case.name, e, allowed);
            }
            Err(why) => judgement.unsolved(&case.name, &why.to_string()),
        }
    }
    pass([judgement.verdict("reference build, from rest", allowed)]);
}

#[test]
fn the_solver_reproduces_the_solved_cases() {
    pass(PRECISIONS.map(|precision| {
        let mut judgement = Judgement::default();
        for solved in public() {
            let case = &solved.case;
            solve_and_judge(case, precision, &mut judgement, |found| {
                errors(&found.equilibrium, &solved.truth, case)
            });
        }
        judgement.verdict(&format!("{precision:?}, solved cases"), allowed(precision))
    }));
}

#[test]
fn the_solver_agrees_with_the_reference_build_on_the_solved_cases() {
    pass(PRECISIONS.map(|precision| {
        let mut judgement = Judgement::default();
        for solved in public() {
            let case = &solved.case;
            let truth = case
                .reference()
                .solve(case.load, case.omega, case.reference_attitude())
                .unwrap();
            let truth = Equilibrium::from(&truth);
            solve_and_judge(case, precision, &mut judgement, |found| {
                errors(&found.equilibrium, &truth, case)
            });
        }
        judgement.verdict(
            &format!("{precision:?}, reference build"),
            allowed(precision),
        )
    }));
}

#[test]
fn deformations_are_those_that_the_solved_forces_make() {
    for solved in public() {
        let case = &solved.case;
        let Ok(found) = solve(case, Precision::F64, Scene::AtSpeed) else {
            continue; // reported by another test
        };
        let force = solved.truth.largest_force();
        let [ki, ko] = solved.hertz;
        let largest = (force / ki.min(ko)).powf(2.0 / 3.0);
        assert_eq!(found.balls.len(), solved.truth.balls.len());
        for (ball, truth) in found.balls.iter().zip(&solved.truth.balls) {
            for (delta, q, k) in [
                (ball.delta_i, truth.inner.force, ki),
                (ball.delta_o, truth.outer.force, ko),
            ] {
                let error = (delta.max(0.0) - (q / k).powf(2.0 / 3.0)).abs() / largest;
                assert!(error <= 1e-9, "{}: {error:.1e}", case.name);
            }
        }
    }
}

/// What the reference build says to a solution of the solver's: its own solution of the case, or, if
/// that is another equilibrium than the solver's, the one it reaches from the solver's. The flag
/// says which.
fn judge(
    reference: &Reference,
    case: &Case,
    own: &Equilibrium,
    found: &Found,
    allowed: Errors,
) -> (Errors, bool) {
    let e = errors(&found.equilibrium, own, case);
    if e.within(allowed) {
        return (e, false);
    }
    let lo = (case.design.outer_groove_factor - 0.5) * case.design.ball_diameter;
    let centres: Vec<(f64, f64)> = found
        .balls
        .iter()
        .map(|ball| {
            let (sin, cos) = ball.alpha_o.sin_cos();
            ((lo + ball.delta_o) * sin, (lo + ball.delta_o) * cos)
        })
        .collect();
    let polished = reference.polish(
        case.load,
        case.omega,
        case.reference_attitude(),
        found.equilibrium.displacement,
        &centres,
    );
    match polished {
        Ok(s) => {
            let from_there = errors(&found.equilibrium, &Equilibrium::from(&s), case);
            if from_there.within(allowed) {
                (from_there, true)
            } else {
                (e, false)
            }
        }
        Err(_) => (e, false),
    }
}

/// Cases that have an ordinary solution: contact angles below 85 degrees, and no ball off the inner
/// race under inner race control, which presumes that there is none.
fn ordinary(case: &Case, truth: &Equilibrium) -> bool {
    let steepest = truth
        .balls
        .iter()
        .filter(|b| b.inner.force > 0.0)
        .fold(0.0, |m, b| worse(m, b.inner.angle.abs()));
    steepest < 85f64.to_radians()
        && (case.attitude != Attitude::Inner || truth.unloaded_balls() == 0)
}

/// What became of a random case.
struct Tried {
    unloading: bool,
    other_branch: Vec<Precision>,
    judgements: [Judgement; 2],
}

/// Solves the random case of a seed, if it has an ordinary solution that the reference build finds.
fn tried(seed: u64) -> Option<Tried> {
    let case = Case::random(seed);
    let reference = case.reference();
    let own = reference
        .solve(case.load, case.omega, case.reference_attitude())
        .ok()?;
    let own = Equilibrium::from(&own);
    if !ordinary(&case, &own) {
        return None;
    }
    let mut tried = Tried {
        unloading: own.unloaded_balls() > 0,
        other_branch: Vec::new(),
        judgements: Default::default(),
    };
    for (precision, judgement) in PRECISIONS.into_iter().zip(&mut tried.judgements) {
        solve_and_judge(&case, precision, judgement, |found| {
            let (e, other) = judge(&reference, &case, &own, found, allowed(precision));
            if other {
                tried.other_branch.push(precision);
            }
            e
        });
    }
    Some(tried)
}

#[test]
fn the_solver_agrees_with_the_reference_build_on_random_cases() {
    const WANTED: usize = 300;
    /// Cases that are tried at the same time.
    const BLOCK: u64 = 60;
    let mut judgements = [Judgement::default(), Judgement::default()];
    let (mut drawn, mut taken, mut unloading, mut other_branch) = (0, 0, 0, Vec::new());
    while taken < WANTED && drawn < 3 * WANTED as u64 {
        let block = (drawn + 1..=drawn + BLOCK).into_par_iter();
        for (seed, tried) in block.map(|seed| (seed, tried(seed))).collect::<Vec<_>>() {
            let Some(tried) = tried else {
                continue;
            };
            taken += 1;
            unloading += usize::from(tried.unloading);
            other_branch.extend(tried.other_branch.into_iter().map(|p| (seed, p)));
            for (sum, judgement) in judgements.iter_mut().zip(tried.judgements) {
                sum.append(judgement);
            }
        }
        drawn += BLOCK;
    }
    assert!(taken >= WANTED, "the reference build solves too few");
    println!(
        "{drawn} drawn, {taken} taken, {unloading} with balls off the inner race; \
         another equilibrium than the reference build's: {other_branch:?}"
    );
    pass(
        PRECISIONS
            .into_iter()
            .zip(judgements)
            .map(|(precision, judgement)| {
                judgement.verdict(&format!("{precision:?}, random cases"), allowed(precision))
            }),
    );
}
