//! One case: solved in both precisions, and judged by the reference build.

use super::balance::residual;
use super::families::{Family, Tick, Trial};
use super::sets::Set;
use crate::compare::Equilibrium;
use crate::reference::{Failure, Task, small_solve};
use solvers::dispatch::Precision;
use solvers::{self, Balls, with_solver};
use spindle_bearing::BallState;
use spindle_file::plan::{Plan, Question};
use std::array::from_fn;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Most iterations a solve may take: the limit of the default settings.
const MOST_ITERATIONS: u16 = 100;

/// Error in displacement, forces or stiffness beyond which an answer may be another equilibrium than the
/// expected one. It is then judged from its own balls as well.
const FAR: f64 = 1e-2;

/// Two truths whose forces or displacements differ by more are two equilibria.
const APART: f64 = 1e-6;

/// An answer deceives if an error is larger than the first of these and than so many times its own estimate.
const DECEIVES: (f64, f64) = (1e-3, 30.0);

/// Errors of the reference build of sets, which works in doubles. A smaller error of a set counts as none.
const OF_SETS: f64 = 1e-10;

/// A centrifugal force that makes no difference, of the largest contact force.
const NEGLIGIBLE: f64 = 1e-16;

/// The order of everything that comes in pairs here.
pub const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F64];

/// The answer of a solver, or the status without one; that of a panic is `panic`.
pub type Answer = Result<solvers::Answer, &'static str>;

fn status(answer: &Answer) -> &'static str {
    match answer {
        Ok(figures) => figures.status.name(),
        Err(status) => status,
    }
}

/// The balls of all rows, where there are figures.
fn balls(answer: &Answer) -> Vec<BallState<f64>> {
    let rows = answer.iter().flat_map(|figures| &figures.rows);
    rows.flat_map(|row| &row.balls).copied().collect()
}

/// Fault that must never be, if the answer to this tick has one. A set may stand without a load.
fn failure(answer: &Answer, tick: &Tick, is_set: bool) -> Option<&'static str> {
    let status = status(answer);
    let is_finite = tick.load.iter().chain([&tick.omega]).all(|x| x.is_finite());
    // Inputs are checked in their order: one before the input in question may be out of range.
    let by_input = matches!(status, "not-finite" | "out-of-range");
    let iterations = answer.as_ref().map_or(0, |figures| figures.iterations);
    let failures = [
        (status == "panic", "panic"),
        (
            status == "not-finite" && is_finite,
            "finite input refused as not finite",
        ),
        (
            !by_input && !is_finite,
            "input that is not finite was not refused",
        ),
        (
            !by_input && !is_set && status != "unloaded" && tick.load == [0.0; 5],
            "no load, and not refused as such",
        ),
        (
            answer.is_ok() && !is_solution(status),
            "figures of a status that is no answer",
        ),
        (
            iterations > MOST_ITERATIONS,
            "more iterations than the limit",
        ),
        (!are_finite(answer), "a figure is not a finite number"),
    ];
    failures
        .into_iter()
        .find_map(|(is_so, text)| is_so.then_some(text))
}

fn are_finite(answer: &Answer) -> bool {
    let of_ring = answer.iter().flat_map(|figures| {
        let stiffness = figures.stiffness.as_flattened().iter();
        stiffness.chain(&figures.displacement).copied()
    });
    let of_balls = balls(answer).into_iter().flat_map(|b| {
        let contacts = [b.alpha_i, b.alpha_o, b.q_i, b.q_o, b.delta_i, b.delta_o];
        let rest = [b.azimuth, b.centrifugal_force, b.gyroscopic_moment];
        contacts.into_iter().chain(rest)
    });
    of_ring.chain(of_balls).all(f64::is_finite)
}

/// Whether a status says that there is a solution.
fn is_solution(status: &str) -> bool {
    matches!(status, "converged" | "precision-limit")
}

/// How the reference build judges a solve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// An answer, and its errors are known.
    Judged,
    /// An answer from which the reference build finds no equilibrium.
    Unjudged,
    /// No answer, and no equilibrium that the reference build knew of.
    RightlyRefused,
    /// No answer, though there is an equilibrium.
    Missed,
    /// No answer, and it takes the reference build's own search to know whether there is one.
    Undecided,
    /// A failure that must never be, in words.
    Failed(&'static str),
}

/// A solve that counts, as far as the report needs it.
#[derive(Debug, Clone, Copy)]
pub struct Record {
    /// Family of the case.
    pub family: Family,
    /// Its number in the family.
    pub index: usize,
    /// Number of the solve in the case.
    pub tick: usize,
    /// Precision of the solve.
    pub precision: Precision,
    /// Status of the answer, in a word.
    pub status: &'static str,
    /// Iterations, where there are figures.
    pub iterations: Option<u16>,
    /// The verdict.
    pub verdict: Verdict,
    /// Errors of displacement, force and stiffness.
    pub errors: Option<[f64; 3]>,
    /// The solver's own estimate of them.
    pub estimate: Option<[f64; 3]>,
    /// Residual of the balance of ring and balls: see [`residual`].
    pub residual: Option<f64>,
    /// Whether an answer is the equilibrium on the branch from rest, where that was looked into.
    pub from_rest: Option<bool>,
}

impl Record {
    /// Whether the solver says that this is a solution.
    pub fn is_solved(&self) -> bool {
        is_solution(self.status)
    }

    /// Whether this is an answer whose forces do not balance.
    pub fn is_unbalanced(&self) -> bool {
        self.residual.is_some_and(|residual| !(residual <= FAR))
    }

    /// Whether this is an answer that is off by far more than it says.
    pub fn deceives(&self) -> bool {
        let (least, times) = DECEIVES;
        let estimates = self.estimate.iter().flatten();
        let mut errors = self.errors.iter().flatten().zip(estimates);
        errors.any(|(error, estimate)| *error > least && *error > times * estimate)
    }
}

/// One solve in both precisions: single, double.
#[derive(Debug)]
pub struct Judged {
    /// The answers.
    pub answers: [Answer; 2],
    /// The equilibrium that each answer was compared with.
    pub truths: [Option<Equilibrium>; 2],
    /// The record of each for the report.
    pub records: [Record; 2],
}

/// All solves of a case in a precision; panics become answers.
fn answers(trial: &Trial, precision: Precision) -> Vec<Answer> {
    let case = &trial.case;
    let (plan, growth, held) = match &trial.set {
        Some(set) => (set.plan.clone(), set.growth.clone(), set.held),
        None => (Plan::alone(&case.design, case.balls), Vec::new(), [None; 5]),
    };
    let balls = match trial.at_rest {
        true => Balls::Static,
        false => case.attitude.into(),
    };
    with_solver(&plan, balls, precision, |solver| {
        let mut solve = |tick: &Tick| {
            let question = Question {
                held,
                growth: growth.clone(),
                ..Question::load(tick.load, tick.omega)
            };
            let solve = AssertUnwindSafe(|| solver.solve(&question));
            match catch_unwind(solve) {
                Ok(answer) => answer.map_err(|status| status.name()),
                Err(_) => {
                    // A panic may leave the solver in any state.
                    solver.reset();
                    Err("panic")
                }
            }
        };
        trial.ticks.iter().map(&mut solve).collect()
    })
    .unwrap_or_else(|e| panic!("{}: {e}", case.name))
}

/// A tick as a precision sees it.
fn seen(tick: &Tick, precision: Precision) -> Tick {
    match precision {
        Precision::F32 => tick.rounded(),
        Precision::F64 => *tick,
    }
}

/// The question of a tick at a speed, as the reference build is asked.
fn task(trial: &Trial, tick: &Tick, omega: f64) -> Task {
    let held = trial.set.as_ref().map_or([None; 5], |set| set.held);
    Task::new(tick.load, omega, trial.case.attitude).holding(held)
}

/// The equilibrium that the reference build reaches from an answer.
fn polished(trial: &Trial, tick: &Tick, answer: &Answer) -> Option<Equilibrium> {
    let figures = answer.as_ref().ok()?;
    let (u, balls) = (figures.displacement, balls(answer));
    let centres = trial.reference.centres(&balls);
    let near = |omega| {
        let task = task(trial, tick, omega);
        match &trial.set {
            Some(set) => set.reference.polish(&task, figures).ok(),
            None => physical(trial, trial.reference.polish_near(&task, u, &centres)),
        }
    };
    near(tick.omega).or_else(|| {
        // A ball that is off the inner race and hardly turns is held by next to nothing. Its place makes
        // no difference: it may as well be judged at rest.
        let largest = |of: fn(&BallState<f64>) -> f64| balls.iter().map(of).fold(0.0, f64::max);
        if largest(|b| b.centrifugal_force) <= NEGLIGIBLE * largest(|b| b.q_o) {
            near(0.0)
        } else if trial.known.is_some() || trial.set.is_some() {
            // Slow, and of little use to cases that have a known equilibrium.
            None
        } else {
            let task = task(trial, tick, tick.omega);
            physical(trial, trial.reference.polish(&task, u, &centres))
        }
    })
}

/// The equilibrium that the load was made from.
fn known(trial: &Trial, tick: &Tick) -> Option<Equilibrium> {
    let u = trial.known?;
    let (reference, mut centres) = (&trial.reference, Vec::new());
    let law = reference.rough_law(u, tick.omega, trial.case.attitude, &mut centres);
    law.ok()?;
    let task = task(trial, tick, tick.omega);
    physical(trial, reference.polish_near(&task, u, &centres))
}

/// An equilibrium, if it is one of the bearing and not just of its equations.
fn physical(trial: &Trial, found: Result<Equilibrium, Failure>) -> Option<Equilibrium> {
    let is_physical = |truth: &Equilibrium| trial.reference.are_physical(&truth.balls);
    found.ok().filter(is_physical)
}

/// Errors of displacement, force and stiffness; an error that is not a number is infinite.
fn errors(trial: &Trial, found: &Equilibrium, truth: &Equilibrium) -> [f64; 3] {
    let e = found.errors(truth, &trial.case.design);
    [e.displacement, e.force, e.stiffness].map(|e| match e {
        e if e.is_nan() => f64::INFINITY,
        e if trial.set.is_some() && e <= OF_SETS => 0.0,
        e => e,
    })
}

/// Whether an equilibrium leaves the ring free to move in some direction, as far as this precision tells.
/// Fewer than three balls carry by more than rounding of the largest force, or the stiffness has no inverse.
fn is_indeterminate(truth: &Equilibrium, pitch_radius: f64, precision: Precision) -> bool {
    let epsilon = match precision {
        Precision::F32 => f64::from(f32::EPSILON),
        Precision::F64 => f64::EPSILON,
    };
    let forces = || truth.balls.iter().map(|ball| ball.q_i);
    let largest = forces().fold(0.0, f64::max);
    let carries = |force: &f64| *force > 10.0 * epsilon * largest;
    if forces().filter(carries).count() < 3 {
        return true;
    }
    let unit = [1.0, 1.0, 1.0, pitch_radius, pitch_radius];
    let k: [[f64; 5]; 5] = from_fn(|i| from_fn(|j| truth.stiffness[i][j] / (unit[i] * unit[j])));
    let one = from_fn(|i| from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    let norm = |m: &[[f64; 5]; 5]| {
        let rows = m.map(|row| row.map(f64::abs).iter().sum());
        rows.into_iter().fold(0.0, f64::max)
    };
    small_solve(k, one).is_none_or(|inverse| norm(&k) * norm(&inverse) * epsilon > 1e-2)
}

/// Verdict on a solve without an answer though there is an equilibrium.
fn refused(truth: &Equilibrium, trial: &Trial, status: &str, precision: Precision) -> Verdict {
    if status == "indeterminate" && is_indeterminate(truth, trial.case.pitch_radius(), precision) {
        Verdict::RightlyRefused
    } else {
        Verdict::Missed
    }
}

/// Solves and judges the counted solves of a case, without the reference build's own search. If
/// `is_followed`, the reference build follows the branch from rest as well.
pub fn judge(trial: &Trial, is_followed: bool) -> Vec<Judged> {
    let [single, double] = PRECISIONS.map(|precision| answers(trial, precision));
    let first = trial.ticks.len() - trial.family.ticks();
    let answers = single.into_iter().zip(double).enumerate().skip(first);
    answers
        .map(|(number, (single, double))| judge_tick(trial, number, [single, double], is_followed))
        .collect()
}

fn judge_tick(trial: &Trial, number: usize, answers: [Answer; 2], is_followed: bool) -> Judged {
    let ticks = PRECISIONS.map(|precision| seen(&trial.ticks[number], precision));
    let same = ticks[0] == ticks[1];
    let mut records = [0, 1].map(|p| {
        let figures = answers[p].as_ref().ok();
        let failure = failure(&answers[p], &ticks[p], trial.set.is_some());
        Record {
            family: trial.family,
            index: trial.index,
            tick: number,
            precision: PRECISIONS[p],
            status: status(&answers[p]),
            iterations: figures.map(|f| f.iterations),
            verdict: failure.map_or(Verdict::Undecided, Verdict::Failed),
            errors: None,
            estimate: figures.map(|f| f.error),
            residual: figures
                .filter(|_| trial.set.is_none())
                .map(|_| residual(trial, &ticks[p], &balls(&answers[p]))),
            from_rest: None,
        }
    });
    let mut truths = [None, None];
    let mut from_rest = kept(|tick| {
        let task = task(trial, tick, tick.omega);
        trial.reference.from_rest(&task).ok()
    });

    // Double precision first: its equilibrium is the truth of both.
    for p in [1, 0] {
        let (Verdict::Undecided, Ok(found)) = (
            records[p].verdict,
            answers[p].as_ref().map(Equilibrium::from),
        ) else {
            continue;
        };
        let shared = truths[1].clone().filter(|_| same);
        let is_near = |truth: &Equilibrium| errors(trial, &found, truth).iter().all(|e| *e <= FAR);
        let near = shared.clone().filter(is_near);
        let own = near.or_else(|| polished(trial, &ticks[p], &answers[p]));
        truths[p] = own.or(shared).or_else(|| known(trial, &ticks[p]));
        let Some(truth) = &truths[p] else {
            records[p].verdict = Verdict::Unjudged;
            continue;
        };
        records[p].verdict = Verdict::Judged;
        records[p].errors = Some(errors(trial, &found, truth));
        // The one family that is promised to end there.
        let is_promised = trial.family == Family::Moderate && trial.set.is_none();
        if is_followed && is_promised && ticks[p].omega != 0.0 {
            records[p].from_rest = from_rest(ticks[p]).map(|meant| {
                let [u, q, _] = errors(trial, truth, &meant);
                u.max(q) <= APART
            });
        }
    }

    // A refusal is wrong if anyone knows of an equilibrium.
    for p in [0, 1] {
        if records[p].verdict != Verdict::Undecided {
            continue;
        }
        let status = records[p].status;
        // These were looked at before; only absurd inputs lie out of range.
        let may_be_unloaded = trial.set.as_ref().is_none_or(Set::is_loose);
        let by_rule = status == "not-finite"
            || status == "unloaded" && may_be_unloaded
            || status == "out-of-range" && trial.family == Family::AnyBits;
        let shared = truths[1 - p].clone().filter(|_| same);
        if by_rule {
            records[p].verdict = Verdict::RightlyRefused;
        } else if let Some(truth) = shared.or_else(|| known(trial, &ticks[p])) {
            records[p].verdict = refused(&truth, trial, status, PRECISIONS[p]);
            truths[p] = Some(truth);
        }
    }
    Judged {
        answers,
        truths,
        records,
    }
}

/// A function that keeps its last result: both precisions mostly see one tick.
fn kept<R: Clone>(of: impl Fn(&Tick) -> R) -> impl FnMut(Tick) -> R {
    let mut last: Option<(Tick, R)> = None;
    move |tick| match &last {
        Some((same, result)) if *same == tick => result.clone(),
        _ => last.insert((tick, of(&tick))).1.clone(),
    }
}

/// Has the reference build search for an equilibrium, wherever a solve found none and nothing else decides: slow.
pub fn search(trial: &Trial, records: &mut [Record; 2]) {
    let mut search = kept(|tick| {
        let task = task(trial, tick, tick.omega);
        match &trial.set {
            Some(set) => set.reference.search(&task).ok(),
            None => physical(trial, trial.reference.solve(&task)),
        }
    });
    for record in records {
        if record.verdict == Verdict::Undecided {
            let truth = search(seen(&trial.ticks[record.tick], record.precision));
            record.verdict = truth.map_or(Verdict::RightlyRefused, |truth| {
                refused(&truth, trial, record.status, record.precision)
            });
        }
    }
}
