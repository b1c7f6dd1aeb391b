//! Judges the answers of a scene by the reference build, restricted as the scene is.

use super::Ring;
use crate::solves::{self, Answer, Balls, Question, epsilon, lengths, ring_solver, rounded, size};
use ::judge::campaign::balance::{carried, unbalanced};
use ::judge::campaign::families::{Tick, Trial};
use ::judge::compare::{Equilibrium, worse};
use ::judge::reference::{Reference, Task};
use ::judge::tolerances::allowed_at;
use solvers::dispatch::{Attitude, Precision};
use spindle_bearing::Status;
use std::array::from_fn;

/// Factor on the table's errors that an answer may have: the families' cases are harder. The table's
/// own cases have errors of a third of the table.
const HARDER: f64 = 20.0;

/// The largest estimate of its own errors that excuses an answer.
const MOST: f64 = 0.05;

/// How much more than the answer says of the error of its stiffness a ring with given displacements may have. Estimates
/// need not cover every answer: of these scenes, one on three balls is off by 1.5 times what its answer says.
const HELD_RING: f64 = 2.0;

/// Whether the free freedoms are hardly determined: one is softer than the stiffest by so much that this
/// precision cannot tell. Two balls at rest leave none but a tilt undetermined. Across its own plane, a
/// ball resists by its force over the distance of the grooves' centres.
fn is_loose(truth: &Equilibrium, free: [bool; 5], lever: f64, epsilon: f64) -> bool {
    let unit = |i: usize| if i < 3 { 1.0 } else { lever };
    let places: Vec<usize> = (0..5).filter(|i| free[*i]).collect();
    let mut k: Vec<Vec<f64>> = places
        .iter()
        .map(|&i| {
            let row = places.iter();
            row.map(|&j| truth.stiffness[i][j] / (unit(i) * unit(j)))
                .collect()
        })
        .collect();
    let largest = (0..k.len()).fold(0.0, |m, i| f64::max(m, k[i][i]));
    for p in 0..k.len() {
        if !(k[p][p] > 1e3 * epsilon * largest) {
            return true;
        }
        for i in p + 1..k.len() {
            let factor = k[i][p] / k[p][p];
            for j in p..k.len() {
                let above = k[p][j];
                k[i][j] -= factor * above;
            }
        }
    }
    false
}

/// Judgement of an answer or of a refusal.
enum Verdict {
    Good,
    Wrong(String),
    /// Rightly refused, or without an equilibrium that the reference build knows of.
    Excused,
    /// Without an answer, or without a truth.
    Silent,
}

/// Verdicts on one kind of scene.
#[derive(Default)]
pub struct Tally {
    pub solves: usize,
    pub excused: usize,
    pub silent: usize,
    pub complaints: Vec<String>,
}

/// A trial of a campaign, restricted to a motion of the balls and to a ring.
pub struct Scene<'t> {
    trial: &'t Trial,
    balls: Balls,
    precision: Precision,
    /// Number of the ring's freedoms, and a flag for each that is solved for.
    freedoms: usize,
    free: [bool; 5],
    /// Displacements of freedoms that the ring has and that are not free.
    given: [f64; 5],
    /// The reference build, restricted as the motion is.
    reference: Reference,
}

impl<'t> Scene<'t> {
    pub fn new(
        trial: &'t Trial,
        balls: Balls,
        precision: Precision,
        &(_, freedoms, held): &Ring,
        given: [f64; 5],
    ) -> Self {
        let whole = trial.reference.clone();
        Self {
            trial,
            balls,
            precision,
            freedoms,
            free: from_fn(|i| i < freedoms && !held[i]),
            given,
            reference: match balls {
                Balls::Centrifugal => whole.without_gyroscopic_moment(),
                _ => whole,
            },
        }
    }

    /// Has all ticks of the trial solved, and judges the answers.
    pub fn judge(&self, tally: &mut Tally) {
        let case = &self.trial.case;
        let mut solver = ring_solver(
            &case.design,
            case.balls,
            self.precision,
            self.balls,
            self.freedoms,
        );
        for tick in &self.trial.ticks {
            let held = self.free.map(|free| !free);
            let question = Question::load(tick.load, tick.omega).holding(held, self.given);
            let verdict = match solver.solve(&question) {
                Ok(found) => self.judge_answer(tick, &found),
                Err(status) => self.judge_refusal(tick, status),
            };
            tally.solves += 1;
            match verdict {
                Verdict::Good => {}
                Verdict::Wrong(what) => {
                    let (name, precision, balls) = (&case.name, self.precision, self.balls);
                    let complaint = format!("{name} {precision:?} {balls:?}: {what}");
                    tally.complaints.push(complaint);
                }
                Verdict::Excused => tally.excused += 1,
                Verdict::Silent => tally.silent += 1,
            }
        }
    }

    fn rule(&self) -> Attitude {
        self.balls.rule()
    }

    /// As the solver sees it: what it is given of its freedoms, and the speed.
    fn inputs(&self, tick: &Tick) -> ([f64; 5], f64) {
        let value = |i| match self.free[i] {
            true => tick.load[i],
            false => self.given[i],
        };
        let seen = |i| match i < self.freedoms {
            true => rounded(self.precision, value(i)),
            false => 0.0,
        };
        (from_fn(seen), rounded(self.precision, tick.omega))
    }

    /// Largest difference of two loads over `size` in these freedoms, moments over the pitch radius.
    fn load_error(&self, these: [bool; 5], a: &[f64; 5], b: &[f64; 5], size: f64) -> f64 {
        let unit = lengths(&self.trial.case.design);
        let these = (0..5).filter(|i| these[*i]);
        these.fold(0.0, |error, i| {
            worse(error, (a[i] - b[i]).abs() / (size * unit[i]))
        })
    }

    fn judge_refusal(&self, tick: &Tick, status: Status<f32>) -> Verdict {
        let (values, omega) = self.inputs(tick);
        let finite = omega.is_finite() && values.iter().all(|x| x.is_finite());
        let largest = values.iter().fold(0.0, |m, x| f64::max(m, x.abs()));
        let justified = match status {
            // Zero or subnormal in the freedoms that there are.
            Status::Unloaded => finite && largest < 1e-12,
            // Beyond what the model is for.
            Status::OutOfRange { .. } => !finite || largest.max(omega.abs()) > 1e3,
            Status::NotFinite { .. } => !finite,
            _ if !finite => false,
            _ => {
                // Inner race control need not have an equilibrium.
                let task = Task::new(values, omega, self.rule());
                let task = task.holding(from_fn(|i| (!self.free[i]).then_some(values[i])));
                if self.rule() == Attitude::Inner && self.reference.solve(&task).is_err() {
                    return Verdict::Excused;
                }
                return Verdict::Silent;
            }
        };
        if justified {
            Verdict::Excused
        } else {
            Verdict::Wrong(format!("{status} of {values:?} at {omega}"))
        }
    }

    fn judge_answer(&self, tick: &Tick, found: &Answer) -> Verdict {
        let (design, balls) = (&self.trial.case.design, self.trial.case.balls as f64);
        let (rule, free) = (self.rule(), self.free);
        let (values, omega) = self.inputs(tick);
        if !omega.is_finite() || !values.iter().all(|x| x.is_finite()) {
            return Verdict::Wrong(format!("an answer to {values:?} at {omega}"));
        }
        let loaded = found.rows[0]
            .balls
            .iter()
            .filter(|ball| ball.q_i > 0.0)
            .count();
        let wrong = |what: String| Verdict::Wrong(format!("{what}; {loaded} balls loaded"));
        if free == [false; 5] && loaded == 0 {
            // Nothing holds a ring that no ball touches, and nothing pushes it.
            let own = ..self.freedoms;
            let stiff = found.stiffness[own].iter().flat_map(|row| &row[own]);
            return match found.load.iter().chain(stiff).any(|x| *x != 0.0) {
                true => wrong(format!("{found:?}")),
                false => Verdict::Good,
            };
        }
        let has: [bool; 5] = from_fn(|i| i < self.freedoms);
        let load = from_fn(|i| if free[i] { values[i] } else { 0.0 });
        let omega = if self.balls == Balls::Static {
            0.0
        } else {
            omega
        };
        let all = Equilibrium::from(found).largest_force() * balls;
        let deepest = found.rows[0]
            .balls
            .iter()
            .map(|b| b.delta_i)
            .fold(0.0, f64::max);
        let largest = size(found.displacement, lengths(design));
        let mut bounds =
            allowed_at(self.precision, largest / design.centre_distance()).times(HARDER);
        bounds.contact_angle = f64::INFINITY;
        // A hard case is one that the answer itself calls so, but not one that says nothing of itself.
        let [displacement, force, mut stiffness] = found.error.map(|error| error.min(MOST));
        if free != [true; 5] && self.freedoms == 5 {
            stiffness *= HELD_RING;
        }
        bounds.displacement = bounds.displacement.max(displacement);
        bounds.force = bounds.force.max(force);
        // Two balls hold the ring in four directions. Nothing carries a rounded load's parts in the others.
        if 2 * loaded < free.iter().filter(|free| **free).count() && self.freedoms > 1 {
            bounds.force = bounds.force.max(f64::from(f32::EPSILON));
        }

        // The balls carry the load, and what they carry is what the answer says.
        let by_balls = carried(design, rule, &found.rows[0].balls);
        let error = self.load_error(free, &load, &by_balls, all);
        let own = self.load_error(has, &found.load, &by_balls, all);
        let missed = worse(error, own);
        if !(missed <= bounds.force) {
            // Where a ball leaves the inner race, inner race control drops its friction abruptly. There may be
            // no balance to better than this friction.
            let open = found.rows[0].balls.iter().any(|ball| ball.q_i <= 0.0);
            let moments = found.rows[0]
                .balls
                .iter()
                .map(|ball| ball.gyroscopic_moment.abs());
            let friction = moments.fold(0.0, f64::max) / design.ball_diameter;
            if rule == Attitude::Inner && open && missed <= 2.0 * friction / all {
                return Verdict::Good;
            }
            let allowed = bounds.force;
            return wrong(format!(
                "the balls miss the load by {error:.1e}, the answer by {own:.1e}; allowed {allowed:.1e}"
            ));
        }
        // And every ball is in balance.
        let left = unbalanced(design, rule, &found.rows[0].balls) / all;
        if !(left <= bounds.force) {
            return wrong(format!("a ball is out of balance by {left:.1e}"));
        }

        // A displacement of many deformations has few digits left for them.
        // Single precision keeps positions in two parts.
        let epsilon = epsilon(self.precision);
        let length = match self.precision {
            Precision::F32 => largest,
            Precision::F64 => largest + design.centre_distance(),
        };
        let rounding = 32.0 * epsilon * length / deepest;
        bounds.force = bounds.force.max(rounding);
        bounds.stiffness = bounds.stiffness.max(stiffness).max(rounding);
        let mut centres = self.reference.centres(&found.rows[0].balls);
        let (task, u) = (Task::new(load, omega, rule), found.displacement);
        let task = task.holding(from_fn(|i| (!free[i]).then_some(u[i])));
        let truth = self.reference.polish(&task, u, &centres);
        let lever = self.trial.case.pitch_radius();
        // Where the ring is may be hard to tell, but there the bearing must carry the load.
        let firm = truth.as_ref().ok();
        let firm = firm.filter(|truth| !is_loose(truth, free, lever, epsilon));
        let u = firm.map_or(u, |truth| truth.displacement);
        let law = self.reference.rough_law(u, omega, rule, &mut centres);
        let Ok((force, _)) = law else {
            return Verdict::Silent;
        };
        let Some(firm) = firm else {
            let error = self.load_error(free, &load, &force, all);
            return if !(error <= bounds.force) {
                wrong(format!("the bearing misses the load by {error:.1e}"))
            } else if truth.is_ok() {
                Verdict::Good
            } else {
                Verdict::Silent
            };
        };
        let mut errors = solves::errors(found, design, firm, self.freedoms);
        // Reactions, which no displacement shows.
        let size = firm.largest_force() * balls;
        let reactions = self.load_error(has, &found.load, &force, size);
        errors.force = worse(errors.force, reactions);
        // The stiffness of a ball that is about to open goes with the root of its deformation. Of one that touches to within
        // rounding, no more is known than the answer says.
        let touches = |most: f64| {
            let mut balls = firm.balls.iter();
            balls.any(|ball| ball.delta_i.abs() < most * deepest)
        };
        if touches(1e-3) {
            bounds.stiffness = bounds.stiffness.max((4.0 * rounding).sqrt());
        }
        if touches(rounding) {
            bounds.stiffness = bounds.stiffness.max(found.error[2]);
        }
        if errors.within(bounds) {
            Verdict::Good
        } else {
            wrong(format!("{errors}; allowed {bounds}"))
        }
    }
}
