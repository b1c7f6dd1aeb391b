//! One case: solved in both precisions, and judged by the reference build.

use super::balance::{centres, residual};
use super::families::{Family, Tick, Trial};
use crate::compare::{Ball, Equilibrium};
use crate::dispatch::Precision;
use crate::reference::{self, Failure, Solution, small_solve};
use crate::spindles::{self, Balls, Plan, with_solver};
use spindle_bearing::BallState;
use std::array::from_fn;
use std::f64::consts::PI;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Most iterations a solve may take: the limit of the default settings.
const MOST_ITERATIONS: u16 = 128;

/// Beyond this error in displacement, forces or stiffness, an answer may be another equilibrium than the one it was
/// compared with: it is judged from its own balls as well.
const FAR: f64 = 1e-2;

/// Two truths whose forces or displacements differ by more are two equilibria.
const APART: f64 = 1e-6;

/// An answer deceives if an error is larger than the first of these and than so many times its own estimate.
const DECEIVES: (f64, f64) = (1e-3, 30.0);

/// A centrifugal force that makes no difference, of the largest contact force.
const NEGLIGIBLE: f64 = 1e-16;

/// The order of everything that comes in pairs here.
pub const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F64];

/// The answer of a solver, or its panic, whose status is `panic`.
#[derive(Debug)]
pub struct Answer {
    /// How the solve ended.
    pub status: &'static str,
    /// The figures, where there are any.
    pub figures: Option<spindles::Answer>,
}

impl Answer {
    fn equilibrium(&self) -> Option<Equilibrium> {
        let figures = self.figures.as_ref()?;
        Some(Equilibrium {
            displacement: figures.displacement,
            stiffness: figures.stiffness,
            balls: self.balls().iter().map(Ball::from).collect(),
        })
    }

    /// The balls, where there are figures.
    fn balls(&self) -> &[BallState<f64>] {
        match &self.figures {
            Some(figures) => &figures.rows[0].balls,
            None => &[],
        }
    }

    /// Says what must never be, if the answer to this tick is that.
    fn failure(&self, tick: &Tick) -> Option<&'static str> {
        let status = self.status;
        let finite = tick.omega.is_finite() && tick.load.iter().all(|f| f.is_finite());
        let unloaded = tick.load == [0.0; 5];
        let refused = match status {
            "panic" => Some("panic"),
            "not-finite" if finite => Some("finite input refused as not finite"),
            // Inputs are checked in their order: one before it may be out of range.
            "not-finite" | "out-of-range" => None,
            _ if !finite => Some("input that is not finite was not refused"),
            "unloaded" => None,
            _ if unloaded => Some("no load, and not refused as such"),
            _ => None,
        };
        let Some(figures) = &self.figures else {
            return refused;
        };
        let of_ball = |b: &BallState<f64>| {
            let contacts = [b.alpha_i, b.alpha_o, b.q_i, b.q_o, b.delta_i, b.delta_o];
            let rest = [b.azimuth, b.centrifugal_force, b.gyroscopic_moment];
            contacts.iter().chain(&rest).all(|x| x.is_finite())
        };
        let mut of_ring = figures
            .stiffness
            .iter()
            .flatten()
            .chain(&figures.displacement);
        refused.or(if !is_solution(status) {
            Some("figures of a status that is no answer")
        } else if figures.iterations > MOST_ITERATIONS {
            Some("more iterations than the limit")
        } else if !(of_ring.all(|x| x.is_finite()) && self.balls().iter().all(of_ball)) {
            Some("a figure is not a finite number")
        } else {
            None
        })
    }
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
    /// An answer of known errors, of another equilibrium than that of double precision.
    OtherBranch,
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

/// Whether an answer is the equilibrium that is meant: where there are several, that on the branch connected to rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branch {
    /// It is.
    FromRest,
    /// It is another one.
    Other,
    /// The branch ends before this speed, or the reference build could follow it no further.
    Lost,
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
    /// Which equilibrium an answer is, where that was looked into.
    pub branch: Option<Branch>,
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
    pub truths: [Option<Solution>; 2],
    /// The record of each for the report.
    pub records: [Record; 2],
}

/// All solves of a case in a precision; panics become answers.
fn answers(trial: &Trial, precision: Precision) -> Vec<Answer> {
    let case = &trial.case;
    let plan = Plan::alone(&case.design, case.balls);
    let balls = match trial.at_rest {
        true => Balls::Static,
        false => Balls::Moving(case.attitude),
    };
    with_solver(&plan, balls, precision, |solver| {
        let mut solve = |tick: &Tick| {
            let solve = AssertUnwindSafe(|| solver.load(tick.load, tick.omega));
            match catch_unwind(solve) {
                Ok(Ok(figures)) => Answer {
                    status: figures.status,
                    figures: Some(figures),
                },
                Ok(Err(status)) => Answer {
                    status: status.name(),
                    figures: None,
                },
                Err(_) => {
                    // A panic may leave the solver in any state.
                    solver.reset();
                    Answer {
                        status: "panic",
                        figures: None,
                    }
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

/// The equilibrium that the reference build reaches from an answer.
fn polished(trial: &Trial, tick: &Tick, answer: &Answer) -> Option<Solution> {
    let u = answer.figures.as_ref()?.displacement;
    let centres = centres(&trial.case.design, answer.balls());
    let (reference, attitude) = (&trial.reference, trial.case.reference_attitude());
    let near = |omega| {
        let found = reference.polish_near(tick.load, omega, attitude, u, &centres);
        physical(trial, found)
    };
    near(tick.omega).or_else(|| {
        // A ball that is off the inner race and hardly turns is held by next to nothing, and where it is
        // makes no difference: as well judged at rest.
        let largest =
            |of: fn(&BallState<f64>) -> f64| answer.balls().iter().map(of).fold(0.0, f64::max);
        if largest(|b| b.centrifugal_force) <= NEGLIGIBLE * largest(|b| b.q_o) {
            near(0.0)
        } else if trial.known.is_some() {
            // Slow, and of little use to cases that have a known equilibrium.
            None
        } else {
            physical(
                trial,
                reference.polish(tick.load, tick.omega, attitude, u, &centres),
            )
        }
    })
}

/// The equilibrium that the load was made from.
fn known(trial: &Trial, tick: &Tick) -> Option<Solution> {
    let u = trial.known?;
    let (reference, attitude) = (&trial.reference, trial.case.reference_attitude());
    let mut centres = Vec::new();
    reference
        .rough_law(u, tick.omega, attitude, &mut centres)
        .ok()?;
    let centres: Vec<(f64, f64)> = centres.iter().map(|x| (x[0], x[1])).collect();
    physical(
        trial,
        reference.polish_near(tick.load, tick.omega, attitude, u, &centres),
    )
}

/// An equilibrium, if it is one of the bearing and not just of its equations: Newton may run away to
/// contacts that are wound round the ball or deeper than the grooves' centres are apart.
fn physical(trial: &Trial, found: Result<Solution, Failure>) -> Option<Solution> {
    let deepest = trial.case.design.centre_distance();
    let truth = found.ok()?;
    let is_physical = |ball: &reference::BallState| {
        [ball.alpha_i, ball.alpha_o].iter().all(|a| a.abs() <= PI)
            && [ball.delta_i, ball.delta_o].iter().all(|d| *d <= deepest)
    };
    truth.balls.iter().all(is_physical).then_some(truth)
}

/// Errors of displacement, force and stiffness; an error that is not a number is infinite.
fn errors(trial: &Trial, found: &Equilibrium, truth: &Solution) -> [f64; 3] {
    let case = &trial.case;
    let truth = Equilibrium::from(truth);
    let e = found.errors(&truth, case.design.ball_diameter, case.pitch_radius());
    [e.displacement, e.force, e.stiffness].map(|e| if e.is_nan() { f64::INFINITY } else { e })
}

/// Whether displacements or forces of two equilibria differ by more than this.
fn differ(trial: &Trial, found: &Equilibrium, truth: &Solution, by: f64) -> bool {
    let [u, q, _] = errors(trial, found, truth);
    u.max(q) > by
}

/// Whether an equilibrium leaves the ring free to move in some direction, as far as this precision can
/// tell: fewer than three balls carry by more than rounding of the largest force, or the stiffness has no inverse.
fn is_indeterminate(truth: &Solution, pitch_radius: f64, precision: Precision) -> bool {
    let epsilon = match precision {
        Precision::F32 => f64::from(f32::EPSILON),
        Precision::F64 => f64::EPSILON,
    };
    let largest = truth.balls.iter().map(|ball| ball.q_i).fold(0.0, f64::max);
    let carries = |ball: &&reference::BallState| ball.q_i > 10.0 * epsilon * largest;
    if truth.balls.iter().filter(carries).count() < 3 {
        return true;
    }
    let unit = [1.0, 1.0, 1.0, pitch_radius, pitch_radius];
    let k: [[f64; 5]; 5] = from_fn(|i| from_fn(|j| truth.k[i][j] / (unit[i] * unit[j])));
    let one: [[f64; 5]; 5] = from_fn(|i| from_fn(|j| f64::from(u8::from(i == j))));
    let norm = |m: &[[f64; 5]; 5]| {
        let rows = m.iter().map(|row| row.iter().map(|x| x.abs()).sum());
        rows.fold(0.0, f64::max)
    };
    small_solve(k, one).is_none_or(|inverse| norm(&k) * norm(&inverse) * epsilon > 1e-2)
}

/// Verdict on a solve without an answer though there is an equilibrium.
fn refused(truth: &Solution, trial: &Trial, status: &str, precision: Precision) -> Verdict {
    if status == "indeterminate" && is_indeterminate(truth, trial.case.pitch_radius(), precision) {
        Verdict::RightlyRefused
    } else {
        Verdict::Missed
    }
}

/// Solves and judges the counted solves of a case, without the reference build's own search.
pub fn judge(trial: &Trial) -> Vec<Judged> {
    let [single, double] = PRECISIONS.map(|precision| answers(trial, precision));
    let first = trial.ticks.len() - trial.family.ticks();
    let answers = single.into_iter().zip(double).enumerate().skip(first);
    answers
        .map(|(number, (single, double))| judge_tick(trial, number, [single, double]))
        .collect()
}

fn judge_tick(trial: &Trial, number: usize, answers: [Answer; 2]) -> Judged {
    let ticks = PRECISIONS.map(|precision| seen(&trial.ticks[number], precision));
    let same = ticks[0] == ticks[1];
    let mut records = [0, 1].map(|p| {
        let figures = answers[p].figures.as_ref();
        let failure = answers[p].failure(&ticks[p]);
        Record {
            family: trial.family,
            index: trial.index,
            tick: number,
            precision: PRECISIONS[p],
            status: answers[p].status,
            iterations: figures.map(|f| f.iterations),
            verdict: failure.map_or(Verdict::Undecided, Verdict::Failed),
            errors: None,
            estimate: figures.map(|f| f.error),
            residual: figures.map(|_| residual(trial, &ticks[p], answers[p].balls())),
            branch: None,
        }
    });
    let mut truths = [None, None];

    // Double precision first: its equilibrium is the truth of both.
    for p in [1, 0] {
        let (Verdict::Undecided, Some(found)) = (records[p].verdict, answers[p].equilibrium())
        else {
            continue;
        };
        let own = || polished(trial, &ticks[p], &answers[p]);
        let shared = truths[1].clone().filter(|_| p == 0 && same);
        let (truth, verdict) = if let Some(shared) = shared {
            let far = errors(trial, &found, &shared).iter().any(|e| *e > FAR);
            let other = far.then(own).flatten();
            let apart = |own: &Solution| differ(trial, &Equilibrium::from(own), &shared, APART);
            match other.filter(apart) {
                Some(other) => (Some(other), Verdict::OtherBranch),
                None => (Some(shared), Verdict::Judged),
            }
        } else {
            match own().or_else(|| known(trial, &ticks[p])) {
                Some(truth) => (Some(truth), Verdict::Judged),
                None => (None, Verdict::Unjudged),
            }
        };
        records[p].errors = truth.as_ref().map(|truth| errors(trial, &found, truth));
        records[p].verdict = verdict;
        truths[p] = truth;
    }

    // A refusal is wrong if anyone knows of an equilibrium.
    for p in [0, 1] {
        if records[p].verdict != Verdict::Undecided {
            continue;
        }
        let status = records[p].status;
        // These were looked at before; only absurd inputs lie out of range.
        let by_rule = matches!(status, "not-finite" | "unloaded")
            || status == "out-of-range" && trial.family == Family::AnyBits;
        let shared = truths[1 - p].clone().filter(|_| same);
        records[p].verdict = if by_rule {
            Verdict::RightlyRefused
        } else if let Some(truth) = shared.or_else(|| known(trial, &ticks[p])) {
            let verdict = refused(&truth, trial, status, PRECISIONS[p]);
            truths[p] = Some(truth);
            verdict
        } else {
            Verdict::Undecided
        };
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

/// Looks into which equilibrium the answers of a cold case at speed are: the reference build follows the branch from
/// rest. Warm solves have a history, which may lead elsewhere.
pub fn follow(trial: &Trial, judged: &mut [Judged]) {
    if trial.family.is_warm() {
        return;
    }
    let attitude = trial.case.reference_attitude();
    let mut from_rest = kept(|tick| {
        trial
            .reference
            .from_rest(tick.load, tick.omega, attitude)
            .ok()
    });
    for solve in judged {
        for (p, record) in solve.records.iter_mut().enumerate() {
            let tick = seen(&trial.ticks[record.tick], record.precision);
            let (true, Some(found)) = (tick.omega != 0.0, solve.answers[p].equilibrium()) else {
                continue;
            };
            let differs = |meant: &Solution| match &solve.truths[p] {
                Some(truth) => differ(trial, &Equilibrium::from(truth), meant, APART),
                None => differ(trial, &found, meant, FAR),
            };
            record.branch = Some(match from_rest(tick) {
                None => Branch::Lost,
                Some(meant) if differs(&meant) => Branch::Other,
                Some(_) => Branch::FromRest,
            });
        }
    }
}

/// Has the reference build search for an equilibrium, wherever a solve of one case found none and nothing else decides:
/// slow. Returns the last one found.
pub fn search(trial: &Trial, records: &mut [Record]) -> Option<Solution> {
    let attitude = trial.case.reference_attitude();
    let mut search = kept(|tick| {
        physical(
            trial,
            trial.reference.search(tick.load, tick.omega, attitude),
        )
    });
    let mut found = None;
    for record in records {
        if record.verdict == Verdict::Undecided {
            let truth = search(seen(&trial.ticks[record.tick], record.precision));
            record.verdict = truth.as_ref().map_or(Verdict::RightlyRefused, |truth| {
                refused(truth, trial, record.status, record.precision)
            });
            found = truth;
        }
    }
    found
}
