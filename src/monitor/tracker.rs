//! Follows the loads from equilibrium to equilibrium, within the iterations of a tick.
//!
//! A solve that runs out of iterations is no answer, but the solver keeps where it got to. The next tick goes
//! on from there, towards the loads of its own sample. Until a solve ends there is no new estimate, and the mark
//! is [`Mark::Unsolved`](super::Mark::Unsolved).
//!
//! Teeth that pass take the loads to and fro. The monitor has two solvers, and the one that stands nearer takes the
//! sample: loads that come back find a solution where they were. A solver that was not the nearer one for 100
//! samples takes over the other one's state.
//!
//! After 20 solves without an answer, one starts from nothing, with
//! [`TickSettings::cold_iterations`](super::tick::TickSettings::cold_iterations). So does one where no solver has a
//! solution. If it fails, it is tried again after longer and longer pauses.

use super::plausibility::PlausibilitySettings;
use super::settings::MonitorSettings;
use super::telemetry::StatusCode;
use crate::growth::Growth;
use crate::linalg::refer;
use crate::real::{Float, Real};
use crate::status::Status;
use crate::{Motion, Settings, Speed, Spindle, SpindleSolution, SpindleSolver};

/// A solver, and where it stands.
#[derive(Debug, Clone)]
struct Follower<T: Real + 'static, const R: usize, const N: usize, M: Motion + Copy, const D: usize>
{
    solver: SpindleSolver<T, R, N, M, D>,
    /// Loads and speed of its last solve; none if it has no solution to go on from.
    at: Option<([f32; 5], f32)>,
    /// Solves since it was the nearer one.
    idle: u16,
}

/// Follows the loads from equilibrium to equilibrium.
///
/// Teeth that pass take the loads to and fro in a tick or two, which is farther than a tick's iterations reach.
/// Each end has a solver.
#[derive(Debug)]
pub(super) struct Tracker<
    T: Real + 'static,
    const R: usize,
    const N: usize,
    M: Motion + Copy,
    const D: usize,
> {
    spindle: Spindle<'static, T, R, N, D>,
    followers: [Follower<T, R, N, M, D>; 2],
    scale: Scale,
    /// Solves in a row without an answer.
    failed: u16,
    /// Solves to leave out before the next one from nothing, and how many were left out last.
    pause: u16,
    pauses: u16,
    /// Of the last solve.
    iterations: u16,
}

/// Solves in a row without an answer, after which one starts from nothing.
const PATIENCE: u16 = 20;
/// Solves after which a solver that was never the nearer one takes over the other one's state.
/// They are a tenth of a second at 1 kHz, in which several teeth pass.
const LONGEST_IDLE: u16 = 100;
/// The longest pause between solves from nothing, in solves.
const LONGEST_PAUSE: u16 = 1023;

/// The solve was refused for its input, and has left the solver as it was.
fn is_refused<T>(status: &Status<T>) -> bool {
    matches!(
        status,
        Status::NotFinite { .. } | Status::OutOfRange { .. } | Status::Unloaded
    )
}

/// Shortest times in which each load, and the speed, change by one unit, if they change as fast as is plausible: s/N,
/// s/(N m), s/(rad/s).
#[derive(Debug, Clone, Copy)]
struct Scale([f32; 5], f32);

impl Scale {
    fn of(settings: &PlausibilitySettings) -> Self {
        Self(
            settings.load_rate.map(|rate| 1.0 / rate),
            1.0 / settings.speed_rate,
        )
    }

    /// Shortest time in which loads and speed get from one place to another, s.
    fn distance(&self, (from, from_speed): &([f32; 5], f32), load: &[f32; 5], speed: f32) -> f32 {
        let mut longest = (speed - from_speed).abs() * self.1;
        for ((to, from), scale) in load.iter().zip(from).zip(&self.0) {
            longest = longest.at_least((to - from).abs() * scale);
        }
        longest
    }
}

impl<T: Real, const R: usize, const N: usize, M: Motion + Copy, const D: usize>
    Tracker<T, R, N, M, D>
{
    pub(super) fn new(
        spindle: Spindle<'static, T, R, N, D>,
        settings: &MonitorSettings<R>,
    ) -> Self {
        let follower = Follower {
            solver: SpindleSolver::of(),
            at: None,
            idle: 0,
        };
        Self {
            spindle,
            followers: [follower.clone(), follower],
            scale: Scale::of(&settings.plausibility),
            failed: 0,
            pause: 0,
            pauses: 0,
            iterations: 0,
        }
    }

    /// Iterations of the last solve.
    pub(super) const fn iterations(&self) -> u16 {
        self.iterations
    }

    /// A solve from nothing, without a pause before it.
    pub(super) fn prepare<Seen>(
        &mut self,
        load: [f32; 5],
        speed: f32,
        growth: &[Growth<f32>; R],
        settings: &MonitorSettings<R>,
        see: impl FnOnce(&SpindleSolution<'_, T, R, N, M, D>) -> Seen,
    ) -> Result<Seen, StatusCode> {
        self.pause = 0;
        self.start(load, speed, growth, settings, see)
    }

    /// Result of `see` on the equilibrium under these loads, or how the solve ended without one.
    pub(super) fn solve<Seen>(
        &mut self,
        load: [f32; 5],
        speed: f32,
        growth: &[Growth<f32>; R],
        settings: &MonitorSettings<R>,
        see: impl FnOnce(&SpindleSolution<'_, T, R, N, M, D>) -> Seen,
    ) -> Result<Seen, StatusCode> {
        let [first, second] = &mut self.followers;
        let scale = &self.scale;
        let far = |follower: &Follower<T, R, N, M, D>| {
            let at = follower.at.as_ref();
            at.map_or(f32::INFINITY, |at| scale.distance(at, &load, speed))
        };
        let (near, other) = if far(first) <= far(second) {
            (first, second)
        } else {
            (second, first)
        };
        if near.at.is_none() {
            return self.start(load, speed, growth, settings, see);
        }
        other.idle = other.idle.saturating_add(1);
        near.idle = 0;
        let limit = settings.tick.max_iterations();
        let (seen, iterations) =
            near.solve(&self.spindle, load, speed, growth, settings, limit, see);
        self.iterations = iterations;
        // A copy takes some thousand cycles: in a tick that has them.
        if other.idle >= LONGEST_IDLE && iterations <= 1 {
            other.take_from(near);
        }
        match &seen {
            Ok(_) => self.failed = 0,
            Err(status) if is_refused(status) => {}
            Err(_) => {
                self.failed += 1;
                if self.failed >= PATIENCE {
                    (near.at, other.at) = (None, None);
                }
            }
        }
        seen.map_err(|status| StatusCode::from(&status))
    }

    /// Solves from nothing, unless the tracker is to pause.
    fn start<Seen>(
        &mut self,
        load: [f32; 5],
        speed: f32,
        growth: &[Growth<f32>; R],
        settings: &MonitorSettings<R>,
        see: impl FnOnce(&SpindleSolution<'_, T, R, N, M, D>) -> Seen,
    ) -> Result<Seen, StatusCode> {
        self.iterations = 0;
        if self.pause > 0 {
            self.pause -= 1;
            return Err(StatusCode::IterationLimit);
        }
        let [first, second] = &mut self.followers;
        first.solver.reset();
        let limit = settings.tick.cold_iterations;
        let (seen, iterations) =
            first.solve(&self.spindle, load, speed, growth, settings, limit, see);
        self.iterations = iterations;
        if seen.is_ok() {
            second.take_from(first);
            (self.failed, self.pauses) = (0, 0);
        } else {
            first.at = None;
            self.pauses = (2 * self.pauses + 1).min(LONGEST_PAUSE);
            self.pause = self.pauses;
        }
        seen.map_err(|status| StatusCode::from(&status))
    }
}

impl<T: Real, const R: usize, const N: usize, M: Motion + Copy, const D: usize>
    Follower<T, R, N, M, D>
{
    /// Stands where the other one does. Not `clone_from`, which copies number by number (57,000 cycles).
    fn take_from(&mut self, other: &Self) {
        self.solver.last = other.solver.last;
        (self.at, self.idle) = (other.at, other.idle);
    }

    /// A solve of at most `limit` iterations, and how many it took.
    #[expect(clippy::too_many_arguments, reason = "a sample and its settings")]
    fn solve<Seen>(
        &mut self,
        spindle: &Spindle<'static, T, R, N, D>,
        load: [f32; 5],
        speed: f32,
        growth: &[Growth<f32>; R],
        settings: &MonitorSettings<R>,
        limit: u16,
        see: impl FnOnce(&SpindleSolution<'_, T, R, N, M, D>) -> Seen,
    ) -> (Result<Seen, Status<T>>, u16) {
        let effort = Settings {
            max_iterations: limit,
            tolerance: T::from_f32(settings.tolerance),
        };
        let rad_per_s = Speed::rad_per_s(T::from_f32(speed));
        // From where they are measured to x = 0.
        let mut acting = load;
        refer(settings.shaft.loads_at, &mut acting);
        let acting = acting.map(T::from_f32);
        let grown = growth.each_ref().map(|of| Growth {
            axial: T::from_f32(of.axial),
            radial: T::from_f32(of.radial),
            ball: T::from_f32(of.ball),
        });
        let at = rad_per_s.with_growth(grown);
        match self.solver.solve(spindle, acting, at, &effort) {
            Ok(solution) => {
                self.at = Some((load, speed));
                (Ok(see(&solution)), solution.iterations)
            }
            Err(Status::IterationLimit) => {
                self.at = Some((load, speed));
                (Err(Status::IterationLimit), limit)
            }
            Err(status) => {
                if !is_refused(&status) {
                    self.at = None;
                }
                (Err(status), 0)
            }
        }
    }
}
