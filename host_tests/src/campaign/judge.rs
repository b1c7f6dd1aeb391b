//! One case: solved in both precisions, and judged by the reference build.

use super::balance::residual;
use super::families::{Family, Scene, Tick, Trial};
use crate::compare::{Ball, Equilibrium};
use crate::dispatch::{self, Figures, Precision};
use crate::reference::{self, Solution, small_solve};
use spindle_bearing::BallState;
use std::f64::consts::PI;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Most iterations a solve may take: the limit of the default settings.
pub const MOST_ITERATIONS: u16 = 128;

/// Beyond this error in displacement, forces or stiffness the answer is judged from its own balls as
/// well: it may be another equilibrium than the one it was compared with.
const FAR: f64 = 1e-2;

/// Two truths whose forces or displacements differ by more are two equilibria.
const APART: f64 = 1e-6;

/// A centrifugal force that makes no difference, of the largest contact force.
const NEGLIGIBLE: f64 = 1e-16;

/// What a solve gave.
#[derive(Debug, Clone)]
pub struct Answer {
    /// How it ended, in a word: the status of the solver, or `panic`.
    pub status: &'static str,
    /// Displacement, stiffness and so on; or why there are none.
    pub figures: Result<Figures, String>,
    /// The balls, where there are figures.
    pub balls: Vec<BallState<f64>>,
}

impl Answer {
    /// Whether the solver says that this is a solution.
    pub fn is_solved(&self) -> bool {
        matches!(self.status, "converged" | "precision-limit")
    }

    fn equilibrium(&self) -> Option<Equilibrium> {
        let figures = self.figures.as_ref().ok()?;
        Some(Equilibrium {
            displacement: figures.displacement,
            stiffness: figures.stiffness,
            balls: self.balls.iter().map(Ball::from).collect(),
        })
    }

    /// What must never be, if it is.
    fn failure(&self, tick: &Tick, precision: Precision) -> Option<&'static str> {
        if self.status == "panic" {
            return Some("panic");
        }
        let seen = |x: f64| match precision {
            Precision::F32 => f64::from(x as f32),
            Precision::F64 => x,
        };
        let inputs = || tick.load.iter().chain([&tick.omega]).map(|x| seen(*x));
        let finite = inputs().all(f64::is_finite);
        if finite && self.status == "not-finite" {
            return Some("finite input refused as not finite");
        }
        // Inputs are checked in their order: one before it may be out of range.
        if !finite && !matches!(self.status, "not-finite" | "out-of-range") {
            return Some("input that is not finite was not refused");
        }
        let unloaded = tick.load.iter().all(|f| seen(*f) == 0.0);
        if unloaded && !matches!(self.status, "unloaded" | "not-finite" | "out-of-range") {
            return Some("no load, and not refused as such");
        }
        let figures = self.figures.as_ref().ok()?;
        if !matches!(self.status, "converged" | "precision-limit") {
            return Some("figures of a status that is no answer");
        }
        if figures.iterations > MOST_ITERATIONS {
            return Some("more iterations than the limit");
        }
        let balls = self.balls.iter().flat_map(|b| {
            [
                b.azimuth,
                b.alpha_i,
                b.alpha_o,
                b.q_i,
                b.q_o,
                b.delta_i,
                b.delta_o,
                b.centrifugal_force,
                b.gyroscopic_moment,
            ]
        });
        let all_finite = figures
            .displacement
            .into_iter()
            .chain(figures.stiffness.into_iter().flatten())
            .chain(balls)
            .all(f64::is_finite);
        (!all_finite).then_some("a figure is not a finite number")
    }
}

/// What the reference build says to how a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// An answer, and its errors are known.
    Judged,
    /// The same, but it is another equilibrium than that of double precision.
    OtherBranch,
    /// An answer from which the reference build finds no equilibrium.
    Unjudged,
    /// No answer, and there is none: not that the reference build knew of.
    RightlyRefused,
    /// No answer, though there is an equilibrium.
    Missed {
        /// The contacts of every ball that carries there are within 90 degrees of each other: the races
        /// hold the balls between them.
        opposed: bool,
    },
    /// No answer, and it takes the reference build's own search to know whether there is one.
    Undecided,
    /// What must never be.
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
    /// Family and index of the case.
    pub family: Family,
    /// See there.
    pub index: usize,
    /// Number of the solve in the case.
    pub tick: usize,
    /// Precision of the solve.
    pub precision: Precision,
    /// How it ended.
    pub status: &'static str,
    /// Iterations, where there are figures.
    pub iterations: Option<u16>,
    /// The verdict.
    pub verdict: Verdict,
    /// Errors of displacement, force and stiffness.
    pub errors: Option<[f64; 3]>,
    /// The solver's own estimate of them.
    pub estimate: Option<[f64; 3]>,
    /// How far the forces of an answer are from balance: see [`residual`].
    pub residual: Option<f64>,
    /// Which equilibrium an answer is, where that was looked into.
    pub branch: Option<Branch>,
}

impl Record {
    /// Whether the solver says that this is a solution.
    pub fn is_solved(&self) -> bool {
        matches!(self.status, "converged" | "precision-limit")
    }

    /// An answer whose forces do not balance.
    pub fn is_unbalanced(&self) -> bool {
        self.residual.is_some_and(|residual| !(residual <= FAR))
    }

    /// An answer that is none: some figure is off by more than a hundredth, or its forces do not balance.
    pub fn is_far(&self) -> bool {
        self.is_unbalanced() || self.errors.is_some_and(|errors| !(largest(errors) <= FAR))
    }
}

/// A case with its answers and truths, all ticks.
#[derive(Debug)]
pub struct Judged {
    /// Answers in single and double precision, and what the reference build makes of each of them.
    pub ticks: Vec<JudgedTick>,
}

/// One solve in both precisions.
#[derive(Debug)]
pub struct JudgedTick {
    /// Single, double.
    pub answers: [Answer; 2],
    /// The equilibrium that each answer was compared with.
    pub truths: [Option<Solution>; 2],
    /// What the report takes of each.
    pub records: [Record; 2],
}

/// In the order of everything that comes in pairs here.
pub const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F64];

/// All solves of a case in a precision; `catch` turns panics into answers.
fn answers(trial: &Trial, precision: Precision) -> Vec<Answer> {
    let case = &trial.case;
    let bearing = dispatch::bearing(&case.design, case.balls, precision)
        .unwrap_or_else(|e| panic!("{}: {e}", case.name));
    let fresh = || match trial.scene {
        Scene::AtRest => bearing.static_solver(),
        Scene::AtSpeed => bearing.solver(case.attitude),
    };
    let mut solver = fresh();
    let mut found = Vec::with_capacity(trial.ticks.len());
    for tick in &trial.ticks {
        let mut balls = Vec::with_capacity(case.balls);
        let solve =
            AssertUnwindSafe(|| solver.solve_with_balls(tick.load, tick.omega, Some(&mut balls)));
        match catch_unwind(solve) {
            Ok(answer) => found.push(Answer {
                status: answer.status,
                figures: answer.figures,
                balls,
            }),
            Err(cause) => {
                let text = cause
                    .downcast_ref::<String>()
                    .cloned()
                    .or_else(|| cause.downcast_ref::<&str>().map(|s| (*s).to_owned()));
                found.push(Answer {
                    status: "panic",
                    figures: Err(text.unwrap_or_default()),
                    balls: Vec::new(),
                });
                // What a panic left of the solver is nobody's business.
                solver = fresh();
            }
        }
    }
    found
}

/// The equilibrium that the reference build reaches from an answer.
fn polished(trial: &Trial, tick: &Tick, answer: &Answer) -> Option<Solution> {
    let figures = answer.figures.as_ref().ok()?;
    let design = &trial.case.design;
    let lo = (design.outer_groove_factor - 0.5) * design.ball_diameter;
    let centres: Vec<(f64, f64)> = answer
        .balls
        .iter()
        .map(|ball| {
            let (sin, cos) = ball.alpha_o.sin_cos();
            ((lo + ball.delta_o) * sin, (lo + ball.delta_o) * cos)
        })
        .collect();
    let (reference, u) = (&trial.reference, figures.displacement);
    let attitude = trial.case.reference_attitude();
    let near = |omega| {
        reference
            .polish_near(tick.load, omega, attitude, u, &centres)
            .ok()
            .filter(|truth| is_physical(trial, truth))
    };
    if let Some(truth) = near(tick.omega) {
        return Some(truth);
    }
    // A ball that is off the inner race and hardly turns is held by next to nothing, and where it is
    // makes no difference: as well judged at rest.
    let largest = |of: fn(&BallState<f64>) -> f64| answer.balls.iter().map(of).fold(0.0, f64::max);
    if largest(|b| b.centrifugal_force) <= NEGLIGIBLE * largest(|b| b.q_o) {
        return near(0.0);
    }
    // Slow, and of little use to cases that have a known equilibrium.
    if trial.known.is_some() {
        return None;
    }
    reference
        .polish(tick.load, tick.omega, attitude, u, &centres)
        .ok()
        .filter(|truth| is_physical(trial, truth))
}

/// Whether an equilibrium is one of the bearing, not just of its equations: Newton may run away to
/// contacts that are wound round the ball or deeper than the grooves' centres are apart.
fn is_physical(trial: &Trial, truth: &Solution) -> bool {
    let deepest = trial.case.design.centre_distance();
    truth.balls.iter().all(|ball| {
        [ball.alpha_i, ball.alpha_o].iter().all(|a| a.abs() <= PI)
            && [ball.delta_i, ball.delta_o].iter().all(|d| *d <= deepest)
    })
}

/// Errors of displacement, force and stiffness; what is not a number is infinite.
fn errors(trial: &Trial, found: &Equilibrium, truth: &Equilibrium) -> [f64; 3] {
    let case = &trial.case;
    let e = found.errors(truth, case.design.ball_diameter, case.pitch_radius());
    [e.displacement, e.force, e.stiffness].map(|e| if e.is_nan() { f64::INFINITY } else { e })
}

fn largest(errors: [f64; 3]) -> f64 {
    errors.into_iter().fold(0.0, f64::max)
}

/// A tick as a precision sees it.
fn seen(tick: &Tick, precision: Precision) -> Tick {
    let round = |x: f64| match precision {
        Precision::F32 => f64::from(x as f32),
        Precision::F64 => x,
    };
    Tick {
        load: tick.load.map(round),
        omega: round(tick.omega),
    }
}

/// Whether an equilibrium leaves the ring free to move in some direction, as far as this precision can
/// tell: fewer than three balls carry by more than rounding of the largest force, or the stiffness has no inverse to speak of.
fn is_indeterminate(truth: &Solution, pitch_radius: f64, precision: Precision) -> bool {
    let epsilon = match precision {
        Precision::F32 => f64::from(f32::EPSILON),
        Precision::F64 => f64::EPSILON,
    };
    let largest = truth
        .balls
        .iter()
        .fold(0.0, |m, ball| f64::max(m, ball.q_i));
    let carries = |ball: &&reference::BallState| ball.q_i > 10.0 * epsilon * largest;
    if truth.balls.iter().filter(carries).count() < 3 {
        return true;
    }
    let unit = [1.0, 1.0, 1.0, pitch_radius, pitch_radius];
    let k: [[f64; 5]; 5] =
        std::array::from_fn(|i| std::array::from_fn(|j| truth.k[i][j] / (unit[i] * unit[j])));
    let one: [[f64; 5]; 5] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let norm = |m: &[[f64; 5]; 5]| {
        m.iter()
            .map(|row| row.iter().map(|x| x.abs()).sum::<f64>())
            .fold(0.0, f64::max)
    };
    small_solve(k, one).is_none_or(|inverse| norm(&k) * norm(&inverse) * epsilon > 1e-2)
}

/// What an equilibrium that is known says to a solve without an answer.
fn refused_though(truth: &Solution, trial: &Trial, status: &str, precision: Precision) -> Verdict {
    if status == "indeterminate" && is_indeterminate(truth, trial.case.pitch_radius(), precision) {
        Verdict::RightlyRefused
    } else {
        let mut carrying = truth.balls.iter().filter(|ball| ball.q_i > 0.0);
        Verdict::Missed {
            opposed: carrying.all(|ball| (ball.alpha_i - ball.alpha_o).cos() >= 0.0),
        }
    }
}

/// Solves and judges a case, without the reference build's own search.
pub fn judge(trial: &Trial) -> Judged {
    let [single, double] = PRECISIONS.map(|precision| answers(trial, precision));
    let first = trial.first_counted();
    let ticks = single
        .into_iter()
        .zip(double)
        .enumerate()
        .skip(first)
        .map(|(number, (single, double))| judge_tick(trial, number, [single, double]))
        .collect();
    Judged { ticks }
}

fn judge_tick(trial: &Trial, number: usize, answers: [Answer; 2]) -> JudgedTick {
    let tick = &trial.ticks[number];
    let ticks = PRECISIONS.map(|precision| seen(tick, precision));
    let same = ticks[0] == ticks[1];
    let mut records = [0, 1].map(|p| {
        let answer = &answers[p];
        let figures = answer.figures.as_ref().ok();
        Record {
            family: trial.family,
            index: trial.index,
            tick: number,
            precision: PRECISIONS[p],
            status: answer.status,
            iterations: figures.map(|f| f.iterations),
            verdict: match answer.failure(tick, PRECISIONS[p]) {
                Some(why) => Verdict::Failed(why),
                None => Verdict::Undecided,
            },
            errors: None,
            estimate: figures.and_then(|f| f.error),
            residual: figures.map(|_| residual(trial, &ticks[p], &answer.balls)),
            branch: None,
        }
    });
    let mut truths = [None, None];

    // Double precision first: its equilibrium is the truth of both.
    let is_answer = |p: usize| answers[p].is_solved() && records[p].verdict == Verdict::Undecided;
    let judged = [is_answer(0), is_answer(1)];
    for p in [1, 0] {
        if !judged[p] {
            continue;
        }
        let Some(found) = answers[p].equilibrium() else {
            continue;
        };
        let shared = if p == 0 && same {
            truths[1].clone()
        } else {
            None
        };
        let verdict = if let Some(truth) = shared {
            let mut e = errors(trial, &found, &Equilibrium::from(&truth));
            let mut verdict = Verdict::Judged;
            truths[0] = Some(truth);
            if largest(e) > FAR
                && let (Some(own), Some(other)) =
                    (polished(trial, &ticks[0], &answers[0]), &truths[0])
            {
                let between = errors(trial, &Equilibrium::from(&own), &Equilibrium::from(other));
                if between[0].max(between[1]) > APART {
                    e = errors(trial, &found, &Equilibrium::from(&own));
                    verdict = Verdict::OtherBranch;
                    truths[0] = Some(own);
                }
            }
            records[0].errors = Some(e);
            verdict
        } else if let Some(truth) =
            polished(trial, &ticks[p], &answers[p]).or_else(|| known(trial, &ticks[p]))
        {
            records[p].errors = Some(errors(trial, &found, &Equilibrium::from(&truth)));
            truths[p] = Some(truth);
            Verdict::Judged
        } else {
            Verdict::Unjudged
        };
        records[p].verdict = verdict;
    }

    // A refusal is wrong if anyone knows of an equilibrium.
    for p in [0, 1] {
        if records[p].verdict != Verdict::Undecided {
            continue;
        }
        let status = answers[p].status;
        // These were looked at before; only absurd inputs lie out of range.
        let by_rule = matches!(status, "not-finite" | "unloaded")
            || status == "out-of-range" && trial.family == Family::AnyBits;
        records[p].verdict = if by_rule {
            Verdict::RightlyRefused
        } else if let (true, Some(truth)) = (same, &truths[1 - p]) {
            refused_though(truth, trial, status, PRECISIONS[p])
        } else if let Some(truth) = known(trial, &ticks[p]) {
            let verdict = refused_though(&truth, trial, status, PRECISIONS[p]);
            truths[p] = Some(truth);
            verdict
        } else {
            Verdict::Undecided
        };
    }
    JudgedTick {
        answers,
        truths,
        records,
    }
}

/// Looks into which equilibrium the answers of a cold case at speed are: the reference build follows the branch from
/// rest. Warm solves have a history, which may lead elsewhere.
pub fn follow(trial: &Trial, judged: &mut Judged) {
    if trial.family.is_warm() {
        return;
    }
    for solve in &mut judged.ticks {
        let tick = &trial.ticks[solve.records[0].tick];
        let mut last: Option<(Tick, Option<Solution>)> = None;
        for (p, record) in solve.records.iter_mut().enumerate() {
            let tick = seen(tick, record.precision);
            let (true, Some(found)) = (tick.omega != 0.0, solve.answers[p].equilibrium()) else {
                continue;
            };
            let from_rest = match last.take() {
                Some((same, solution)) if same == tick => solution,
                _ => {
                    let attitude = trial.case.reference_attitude();
                    let solution = trial.reference.from_rest(tick.load, tick.omega, attitude);
                    solution.ok()
                }
            };
            record.branch = Some(match (&from_rest, &solve.truths[p]) {
                (None, _) => Branch::Lost,
                (Some(meant), Some(truth)) => {
                    branch(trial, &Equilibrium::from(truth), meant, APART)
                }
                (Some(meant), None) => branch(trial, &found, meant, FAR),
            });
            last = Some((tick, from_rest));
        }
    }
}

fn branch(trial: &Trial, found: &Equilibrium, meant: &Solution, apart: f64) -> Branch {
    let [u, q, _] = errors(trial, found, &Equilibrium::from(meant));
    if u.max(q) > apart {
        Branch::Other
    } else {
        Branch::FromRest
    }
}

/// The equilibrium that the load was made from.
fn known(trial: &Trial, tick: &Tick) -> Option<Solution> {
    let u = trial.known?;
    let attitude = trial.case.reference_attitude();
    let mut centres = Vec::new();
    let reference = &trial.reference;
    reference
        .rough_law(u, tick.omega, attitude, &mut centres)
        .ok()?;
    let centres: Vec<(f64, f64)> = centres.iter().map(|x| (x[0], x[1])).collect();
    reference
        .polish_near(tick.load, tick.omega, attitude, u, &centres)
        .ok()
        .filter(|truth| is_physical(trial, truth))
}

/// The reference build's own search for the equilibrium of a solve that found none, in one precision
/// or both: slow. Returns it.
pub fn search(trial: &Trial, records: &mut [&mut Record]) -> Option<Solution> {
    let mut last: Option<(Tick, Option<Solution>)> = None;
    for record in records {
        let tick = seen(&trial.ticks[record.tick], record.precision);
        let truth = match last.take() {
            Some((same, truth)) if same == tick => truth,
            _ => {
                let attitude = trial.case.reference_attitude();
                let found = trial.reference.search(tick.load, tick.omega, attitude);
                found.ok().filter(|truth| is_physical(trial, truth))
            }
        };
        record.verdict = match &truth {
            Some(truth) => refused_though(truth, trial, record.status, record.precision),
            None => Verdict::RightlyRefused,
        };
        last = Some((tick, truth));
    }
    last.and_then(|(_, truth)| truth)
}
