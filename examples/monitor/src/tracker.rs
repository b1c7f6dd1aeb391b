//! Follows the loads from equilibrium to equilibrium, within the time of a tick.
//!
//! A solve that was begun is finished for its own sample, over as many ticks as it takes. Then the newest sample is next.
//! Going on towards the newest loads instead, a solve would chase teeth that pass for ever. Until a solve ends there is no new
//! estimate, and the last one grows older.
//!
//! A tick may leave a pass between two rows of balls, and the next tick goes on there. A solve that is cut at every row
//! has the bits of one that is not.

use crate::plausibility::GoodSample;
use crate::settings::MonitorSettings;
use spindle_bearing::{
    Growth, RacewayControlFree, Settings, ShaftLoad, Speed, Spindle, SpindleSolution,
    SpindleSolver, Status,
};

/// Purpose of a solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Purpose {
    /// An estimate.
    Estimate,
    /// The life that the loads use up: the sample's, times this factor.
    Life(f32),
}

/// A sample to be solved.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Task<const R: usize> {
    pub(crate) sample: GoodSample,
    /// The tick of the sample.
    pub(crate) tick: u64,
    pub(crate) purpose: Purpose,
    pub(crate) growth: [Growth<f32>; R],
    /// Rows passed so far.
    pub(crate) rows: u16,
}

/// An equilibrium of the spindle.
pub(crate) type Solved<'s, const R: usize, const N: usize, const D: usize, const E: usize> =
    SpindleSolution<'s, f32, R, N, RacewayControlFree, D, E>;

/// The spindle and its solver.
#[derive(Debug)]
pub(crate) struct Tracker<const R: usize, const N: usize, const D: usize, const E: usize> {
    spindle: &'static Spindle<'static, f32, R, N, D, E>,
    solver: SpindleSolver<f32, R, N, RacewayControlFree, D, E>,
    /// The solve that has begun, and has not ended.
    begun: Option<Task<R>>,
}

impl<const R: usize, const N: usize, const D: usize, const E: usize> Tracker<R, N, D, E> {
    pub(crate) const fn new(spindle: &'static Spindle<'static, f32, R, N, D, E>) -> Self {
        Self {
            spindle,
            solver: SpindleSolver::of(),
            begun: None,
        }
    }

    /// Whether a solve has begun that another sample must wait for.
    pub(crate) const fn is_busy(&self) -> bool {
        self.begun.is_some()
    }

    /// Rows that the solve has passed so far.
    pub(crate) fn rows_passed(&self) -> u16 {
        self.begun.as_ref().map_or(0, |task| task.rows)
    }

    /// Begins with a task.
    pub(crate) const fn begin(&mut self, task: Task<R>) {
        self.begun = Some(task);
    }

    /// Goes on with the solve that has begun, for as long as there is `more_time`, which is asked after every row. At its end,
    /// the task with `see` of its equilibrium, or why there is none.
    pub(crate) fn go_on<Seen>(
        &mut self,
        settings: &MonitorSettings<R>,
        mut more_time: impl FnMut() -> bool,
        see: impl FnOnce(&Task<R>, &Solved<'_, R, N, D, E>) -> Seen,
    ) -> Option<(Task<R>, Result<Seen, Status<f32>>)> {
        let mut task = self.begun.take()?;
        let GoodSample { load, speed, .. } = task.sample;
        let acting = [ShaftLoad {
            position: settings.shaft.loads_at,
            load,
        }];
        let at = Speed::rad_per_s(speed).with_growth(task.growth);
        let effort = Settings {
            // Time is the bound, and the solver's own on an attempt.
            max_iterations: u16::MAX,
            tolerance: settings.tolerance,
        };
        let rows = &mut task.rows;
        let more = || {
            *rows = rows.saturating_add(1);
            more_time()
        };
        let solved = self
            .solver
            .solve_while(self.spindle, &acting, at, &effort, more);
        let seen = match solved {
            Ok(solution) => Ok(see(&task, &solution)),
            Err(Status::IterationLimit) => {
                self.begun = Some(task);
                return None;
            }
            Err(status) => Err(status),
        };
        Some((task, seen))
    }
}
