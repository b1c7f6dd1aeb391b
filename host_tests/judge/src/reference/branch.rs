//! The equilibrium on the branch that is connected to rest, by continuation in `omega^2`.
//!
//! At rest the bearing has one equilibrium: its energy is convex. As the speed rises, that equilibrium moves along a
//! branch. Where a load has several equilibria at speed, the one on this branch is meant.

use super::newton::{Stage, Task};
use super::{Failure, Reference};
use crate::compare::{Equilibrium, worse};
use core::array::from_fn;

/// Inertia of all balls over the load where the balls are placed first.
const FIRST: f64 = 1e-6;

/// Largest turn of an outer contact in a step, and largest one that the predictor misses, rad.
const TURN: [f64; 2] = [0.1, 0.02];

/// Largest motion of the ring in a step, and largest one that the predictor misses, of the groove centres' distance.
const MOTION: [f64; 2] = [0.1, 0.02];

/// Shortest step, of `omega^2` at the end.
const SHORTEST: f64 = 1e-7;

/// Most steps.
const STEPS: usize = 500;

/// An equilibrium on the way, at a part of `omega^2`.
struct Point {
    part: f64,
    stage: Stage,
}

impl Reference {
    /// The equilibrium that the one at rest moves to as `omega^2` rises.
    ///
    /// # Errors
    ///
    /// [`Failure::Stalled`] where the branch ends on the way, or can be followed no further.
    pub fn from_rest(&self, task: &Task) -> Result<Equilibrium, Failure> {
        task.check()?;
        let (whole, omega) = (*task, task.omega);
        let task = |part: f64| Task {
            omega: omega * part.sqrt(),
            ..whole
        };
        let rest = self.at_rest(&task(0.0))?;
        if omega == 0.0 {
            return self.refine(&rest, &task(0.0));
        }
        let inertia = self.balls() as f64 * 0.5 * (self.mass * self.pitch).hi * omega * omega;
        let first = (FIRST * self.load_size(&task(0.0)) / inertia).min(1.0);
        let mut now = [1.0, 1e-2, 1e2, 1e-4]
            .into_iter()
            .map(|factor| first * factor)
            .filter(|part| *part <= 1.0)
            .find_map(|part| self.leave(&rest.u, part, &task(part)))
            .ok_or(Failure::Singular)?;
        let mut last: Option<Point> = None;
        let mut stride = now.part;
        for _ in 0..STEPS {
            if now.part >= 1.0 {
                return self.refine(&now.stage, &task(1.0));
            }
            let part = (now.part + stride).min(1.0);
            match self.advance(last.as_ref(), &now, part, &task(part)) {
                Some((next, smooth)) => {
                    last = Some(core::mem::replace(&mut now, next));
                    if smooth {
                        stride *= 2.0;
                    }
                }
                None => stride *= 0.25,
            }
            if stride < SHORTEST * now.part {
                break;
            }
        }
        Err(Failure::Stalled)
    }

    /// The equilibrium at rest, from a ring that the axial load presses to its own side.
    fn at_rest(&self, task: &Task) -> Result<Stage, Failure> {
        let mut outcome = Err(Failure::Singular);
        let mut towards = task.load;
        towards[0] = towards[0].abs();
        for factor in [1.0, 4.0] {
            let preload = self.preload(&towards, factor);
            let mut start = *task;
            start.load = [preload, 0.0, 0.0, 0.0, 0.0];
            let Ok(mut stage) = self.preloaded(preload, &start) else {
                continue;
            };
            if task.load[0] < 0.0 {
                // Grooves are mirrored at the plane where their centres face each other.
                stage.u[0] = -2.0 * self.a0[0].hi - stage.u[0];
                start.load[0] = -preload;
                self.place(&stage.u, &start, &mut stage.x, false)?;
            }
            let mut direct = stage.clone();
            outcome = self
                .nested(&mut direct, task, 60)
                .map(|()| direct)
                .or_else(|_| self.follow(&mut stage, &start, task).map(|()| stage))
                .and_then(|mut stage| {
                    self.newton(&mut stage, task, 60)?;
                    Ok(stage)
                });
            if outcome.is_ok() {
                break;
            }
        }
        outcome
    }

    /// The first point off rest.
    fn leave(&self, rest: &[f64; 5], part: f64, task: &Task) -> Option<Point> {
        let mut stage = Stage {
            u: *rest,
            x: vec![[0.0; 2]; self.balls()],
        };
        self.place(&stage.u, task, &mut stage.x, false).ok()?;
        self.nested(&mut stage, task, 60).ok()?;
        self.newton(&mut stage, task, 40).ok()?;
        Some(Point { part, stage })
    }

    /// The next point, if it is on this branch as far as the predictor tells; and whether a longer step
    /// would have been, too.
    fn advance(
        &self,
        last: Option<&Point>,
        now: &Point,
        part: f64,
        task: &Task,
    ) -> Option<(Point, bool)> {
        let predicted = match last {
            Some(last) => self.secant(last, now, part),
            None => now.stage.clone(),
        };
        let mut stage = predicted.clone();
        if self.newton(&mut stage, task, 12).is_err() {
            stage = now.stage.clone();
            self.nested(&mut stage, task, 12).ok()?;
            self.newton(&mut stage, task, 12).ok()?;
        }
        let step = self.distance(&now.stage, &stage);
        // Without a last point there is no prediction to miss.
        let missed = last.map_or([0.0; 2], |_| self.distance(&predicted, &stage));
        let within = |factor: f64| {
            [step, missed]
                .iter()
                .zip(TURN.into_iter().zip(MOTION))
                .all(|(moved, most)| moved[0] <= factor * most.0 && moved[1] <= factor * most.1)
        };
        within(1.0).then(|| (Point { part, stage }, within(0.25)))
    }

    /// The straight line through the last two points, with every ball on the outer race.
    fn secant(&self, last: &Point, now: &Point, part: f64) -> Stage {
        let ratio = (part - now.part) / (now.part - last.part);
        let line = |a: f64, b: f64| b + ratio * (b - a);
        let centre = |a: &[f64; 2], b: &[f64; 2]| {
            let x = [line(a[0], b[0]), line(a[1], b[1])];
            let least = self.lo.hi + 0.5 * (b[0].hypot(b[1]) - self.lo.hi);
            let length = x[0].hypot(x[1]);
            let factor = (least / length).max(1.0);
            x.map(|x| x * factor)
        };
        let [a, b] = [&last.stage, &now.stage];
        Stage {
            u: from_fn(|i| line(a.u[i], b.u[i])),
            x: a.x.iter().zip(&b.x).map(|(a, b)| centre(a, b)).collect(),
        }
    }

    /// Largest turn of an outer contact, rad, and largest motion of the ring, of the groove centres' distance.
    fn distance(&self, a: &Stage, b: &Stage) -> [f64; 2] {
        let turn = |a: &[f64; 2], b: &[f64; 2]| {
            (a[0] * b[1] - a[1] * b[0])
                .atan2(a[0] * b[0] + a[1] * b[1])
                .abs()
        };
        let lever = self.pitch_radius();
        let unit = [1.0, 1.0, 1.0, lever, lever];
        let turns = a.x.iter().zip(&b.x).map(|(a, b)| turn(a, b));
        let motions = (0..5).map(|i| (a.u[i] - b.u[i]).abs() * unit[i]);
        [
            turns.fold(0.0, worse),
            motions.fold(0.0, worse) / (self.li + self.lo).hi,
        ]
    }
}
