//! Follows the loads from equilibrium to equilibrium, within the time of a tick.
//!
//! A solve that was begun is finished for its own sample, over as many ticks as it takes. Then the newest sample is next.
//! Going on towards the newest loads instead, a solve would chase teeth that pass for ever. Until a solve ends there is no new
//! estimate, and the last one grows older.
//!
//! A tick may leave a pass between two rows of balls, and the next tick goes on there. A solve that is cut at every row
//! has the bits of one that is not. Levels and reports are taken of its equilibrium in turn, as ticks have the time.

use crate::in_place::in_place;
use crate::plausibility::GoodSample;
use crate::settings::MonitorSettings;
use core::mem::MaybeUninit;
use heapless::Vec;
use spindle_bearing::{
    Growth, RacewayControlFree, RowSummary, Settings, ShaftLoad, Speed, Spindle, SpindleSolution,
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
    /// The solve that has ended with an equilibrium that is still to be looked at.
    pub(crate) ended: Option<Ended<R>>,
}

/// A solve that ended with an equilibrium.
#[derive(Debug)]
pub(crate) struct Ended<const R: usize> {
    pub(crate) task: Task<R>,
    /// Rows at a glance, as far as they were looked at, and how many there are.
    pub(crate) rows: Vec<RowSummary<f32>, R>,
    pub(crate) count: usize,
}

impl<const R: usize> Ended<R> {
    /// All rows, once they were looked at.
    pub(crate) fn all(&self) -> Option<&[RowSummary<f32>]> {
        (self.rows.len() >= self.count).then_some(&self.rows)
    }
}

impl<const R: usize, const N: usize, const D: usize, const E: usize> Tracker<R, N, D, E> {
    /// Makes one in its place: its solver is the largest part of a monitor.
    pub(crate) fn make<'m>(
        place: &'m mut MaybeUninit<Self>,
        spindle: &'static Spindle<'static, f32, R, N, D, E>,
    ) -> &'m mut Self {
        in_place!(place, {}, {
            spindle: spindle,
            solver: SpindleSolver::of(),
            begun: None,
            ended: None,
        })
    }

    /// Whether there is a solve that another sample must wait for.
    pub(crate) const fn is_busy(&self) -> bool {
        self.begun.is_some() || self.ended.is_some()
    }

    /// Rows that the solve has passed so far.
    pub(crate) fn rows_passed(&self) -> u16 {
        self.begun.as_ref().map_or(0, |task| task.rows)
    }

    /// Whether a solve has begun, and not ended.
    pub(crate) const fn has_begun(&self) -> bool {
        self.begun.is_some()
    }

    /// Begins with a task.
    pub(crate) const fn begin(&mut self, task: Task<R>) {
        self.begun = Some(task);
    }

    /// Goes on with the solve that has begun, for as long as there is `more_time`, which is asked after every row.
    ///
    /// # Errors
    ///
    /// Why the solve ended without an equilibrium.
    pub(crate) fn go_on(
        &mut self,
        settings: &MonitorSettings<R>,
        mut more_time: impl FnMut() -> bool,
    ) -> Result<(), (Purpose, Status<f32>)> {
        let Some(mut task) = self.begun.take() else {
            return Ok(());
        };
        let at = Speed::rad_per_s(task.sample.speed).with_growth(task.growth);
        let effort = Settings {
            // Time is the bound, and the solver's own on an attempt.
            max_iterations: u16::MAX,
            tolerance: settings.tolerance,
        };
        let (acting, rows) = (task.acting(settings), &mut task.rows);
        let more = || {
            *rows = rows.saturating_add(1);
            more_time()
        };
        let solved = self
            .solver
            .solve_while(self.spindle, &acting, at, &effort, more);
        match solved.map(|_| ()) {
            Ok(()) => {
                self.ended = Some(Ended {
                    task,
                    rows: Vec::new(),
                    count: self.spindle.facings().len(),
                })
            }
            Err(Status::IterationLimit) => self.begun = Some(task),
            Err(status) => return Err((task.purpose, status)),
        }
        Ok(())
    }

    /// The figures that `see` takes of the equilibrium that a task has led to.
    pub(crate) fn look<Seen>(
        &self,
        task: &Task<R>,
        settings: &MonitorSettings<R>,
        see: impl FnOnce(&Solved<'_, R, N, D, E>) -> Seen,
    ) -> Option<Seen> {
        let acting = task.acting(settings);
        self.solver
            .solved(self.spindle, &acting)
            .map(|solution| see(&solution))
    }
}

impl<const R: usize> Task<R> {
    /// The load on the shaft.
    const fn acting(&self, settings: &MonitorSettings<R>) -> [ShaftLoad<f32>; 1] {
        [ShaftLoad {
            position: settings.shaft.loads_at,
            load: self.sample.load,
        }]
    }
}
