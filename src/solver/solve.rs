//! One solve, from the input to the end of its attempts: checks, the last solution or a start, refusals.

use crate::ball::kinematics::{Motion, Rule};
use crate::growth::Growth;
use crate::linalg::{norm, vector};
use crate::real::Real;
use crate::rows::row::{Row, UNSEATED};
use crate::rows::{Layout, Placed, Rows, Time};
use crate::solver::problem::{OperatingPoint, Problem, inertia, speed_and_growth};
use crate::solver::start::start;
use crate::solver::state::{State, Termination, are_finite};
use crate::solver::warm_start::{Reached, RowState, WarmStart};
use crate::status::{Quantity, Status};

impl<T: Real, const R: usize, const N: usize, const D: usize, const E: usize>
    WarmStart<T, R, N, D, E>
{
    /// Sets size of the load, speed, growth and points of the rows. Refused input changes nothing: all checks come before the first
    /// write.
    pub fn prepare<M: Motion, const SET: bool>(
        &mut self,
        layout: &Layout<'_, T, R, SET, E>,
        problem: &mut Problem<T, D>,
        at: &OperatingPoint<T, R>,
    ) -> Result<(), Status<T>> {
        let unit = layout.rows[0].bearing.c;
        let mut omega = T::ZERO;
        let mut grown = [Growth::NONE; R];
        for ((grown, growth), row) in grown.iter_mut().zip(&at.growth).zip(layout.rows()) {
            (omega, *grown) = speed_and_growth(row.bearing.c, at.speed, M::AT_SPEED, growth)?;
        }
        problem.load_scale = norm(&problem.load).at_least(layout.preload_at_rest);
        // A ring that nothing presses and nothing holds floats in its clearance.
        if problem.is_free && !(problem.load_scale > T::TINY.sqrt_abs()) {
            return Err(Status::Unloaded);
        }
        self.turn_to(layout.fingerprint);
        let s = if M::AT_SPEED {
            inertia(unit, omega, layout.ball_count, problem.load_scale)
        } else {
            T::ZERO
        };
        let mut most = T::ZERO;
        let rows = self.rows.iter_mut().zip(grown);
        for (Placed { bearing, mount, .. }, (row, growth)) in layout.rows().iter().zip(rows) {
            let [axial, ..] = mount.motion::<D, SET>(&self.state.u);
            let (s, size) = (s * mount.inertia, problem.load_scale / mount.force);
            most = most.at_least(
                row.point
                    .set(bearing.c, s, size, growth, axial + mount.closure),
            );
        }
        self.state.turn_to(problem, s, most);
        self.omega = at.speed.as_rad_per_s();
        Ok(())
    }

    /// Solves, and says where the shaft is, or why there is no answer.
    pub fn run<A: Rule, const SET: bool>(
        &mut self,
        layout: &Layout<'_, T, R, SET, E>,
        problem: &Problem<T, D>,
        max_iterations: u16,
        more: &mut dyn FnMut() -> bool,
    ) -> Result<Reached<T, D>, Status<T>> {
        let s = self.rows[0].point.s;
        let mut placed = layout.rows.iter();
        let rows = self.rows.each_mut().map(|row| {
            let Placed { bearing, mount, .. } = placed.next().unwrap_or(&layout.rows[0]);
            let balls = row.balls.get_mut(..bearing.azimuths.len());
            Row {
                c: bearing.c,
                mount,
                p: &mut row.point,
                azimuths: bearing.azimuths,
                balls: balls.unwrap_or_default(),
            }
        });
        let mut rows = Rows {
            rows,
            layout,
            s,
            preload: &mut self.preload,
            deflections: &mut self.deflections,
        };
        let mut time = Time {
            max_iterations,
            taken: 0,
            more,
            is_up: false,
        };
        let termination = self
            .state
            .find::<A, R, SET, E>(&mut rows, problem, &mut time);
        self.state
            .refuse::<A, R, SET, E>(&rows, problem, termination)?;
        // Rounding may end a solve under a spring of next to no force, where no ball of the sleeve is pressed.
        if layout.has_sleeve::<D>() && !(self.state.sum.k[D - 1][D - 1] > T::ZERO) {
            let (loaded_balls, free) = (rows.loaded(), Quantity::Closure);
            self.state = State::COLD;
            return Err(Status::Indeterminate { loaded_balls, free });
        }
        let reached = self.reached(layout, time.taken);
        if let Some(error) = &reached.error
            && !(error.force <= T::ONE && error.stiffness <= T::ONE)
        {
            let loaded_balls = self.loaded(layout);
            let free = self.state.freest::<E>(problem);
            self.state = State::COLD;
            return Err(Status::Indeterminate { loaded_balls, free });
        }
        // Non-finite tangents never end a solve; checked once more here.
        if are_finite(&reached.u) && are_finite(&reached.load) {
            return Ok(reached);
        }
        self.state = State::COLD;
        Err(Status::Diverged { residual: T::ONE })
    }

    /// Number of balls that carry.
    #[cold]
    fn loaded<const SET: bool>(&self, layout: &Layout<'_, T, R, SET, E>) -> u16 {
        let loaded = |(row, placed): (&RowState<T, N>, &Placed<'_, T>)| {
            let balls = row.used(&placed.bearing).iter();
            balls.filter(|ball| ball.carries(&row.point)).count()
        };
        let rows = self.rows.iter().zip(layout.rows());
        rows.map(loaded).sum::<usize>() as u16
    }
}

impl<T: Real, const D: usize> State<T, D> {
    /// One solve: from the last solution or an unfinished attempt, if that is near, or from a start.
    fn find<A: Rule, const R: usize, const SET: bool, const E: usize>(
        &mut self,
        rows: &mut Rows<'_, T, R, SET, E, D>,
        problem: &Problem<T, D>,
        time: &mut Time<'_>,
    ) -> Termination {
        let s = rows.s;
        let mut termination = Termination::Lost;
        if self.attempt.pass.is_open() || self.is_near(rows, problem) {
            if self.attempt.termination != Termination::Unfinished {
                self.attempt.begin(false);
            }
            let ds = if s > T::ZERO {
                s / self.s - T::ONE
            } else {
                T::ZERO
            };
            self.predict(rows, problem, ds);
            termination = self.newton::<A, R, SET, E>(rows, problem, time);
        } else {
            self.attempt.begin(false);
        }
        let mut is_over = termination.is_solved()
            || termination == Termination::Unfinished
            || self.attempt.started;
        if !is_over && !time.is_up {
            is_over = true;
            self.attempt.begin(true);
            start(self, rows, problem);
            termination = self.newton::<A, R, SET, E>(rows, problem, time);
        }
        self.attempt.termination = termination;
        (self.load, self.s) = (problem.load, s);
        if termination == Termination::Unfinished {
            (self.asked, self.placed) = (problem.load, problem.placed);
            (self.is_free, self.prescribed) = (problem.is_free, problem.prescribed);
        }
        if is_over {
            let size = problem.load_scale.at_least(norm(&self.sum.force));
            self.load_scale = size.at_least(*rows.preload);
            return termination;
        }
        // There was no time for a start: the next solve has one.
        self.load_scale = T::ZERO;
        Termination::Unfinished
    }

    /// Whether the last solve ended so near that the next one may start there. Rows that hold each other stay pressed under
    /// any load, but not by any displacement.
    fn is_near<const R: usize, const SET: bool, const E: usize>(
        &self,
        rows: &Rows<'_, T, R, SET, E, D>,
        problem: &Problem<T, D>,
    ) -> bool {
        let half = T::of(0.5);
        let (s, balls) = (rows.s, rows.layout.ball_count);
        let at = self.displacement(rows.layout.plane);
        let change: [T; D] = vector(|i| match problem.prescribed[i] {
            None => problem.load[i] - self.load[i],
            Some(u) => self.sum.k[i][i] * (u - at[i]),
        });
        let smaller = if problem.is_free {
            self.load_scale
                .at_most(problem.load_scale.at_least(*rows.preload))
        } else {
            self.load_scale
        };
        self.load_scale > T::ZERO
            && (rows.layout.fixed.opposed && problem.is_free || norm(&change) <= smaller)
            && (s - self.s).abs() * balls <= half * (self.s * balls + self.load_scale)
            && (s > T::ZERO) == (self.s > T::ZERO)
    }

    /// Freedom in which the tangent resists least: the largest component after two inverse iterations.
    #[cold]
    #[inline(never)]
    fn freest<const E: usize>(&mut self, problem: &Problem<T, D>) -> Quantity {
        let largest = self.stiffest().at_least(T::EPSILON);
        self.factor::<E>(problem, T::EPSILON.sqrt_abs() * largest);
        let free = |motion: [T; D]| {
            vector(|i| match problem.prescribed[i] {
                None => largest * motion[i],
                Some(_) => T::ZERO,
            })
        };
        let motion = self.factors.back_substitute(&free([T::ONE; D]));
        let motion = free(self.factors.back_substitute(&free(motion)));
        let mut freest = 0;
        for i in 1..D {
            if motion[i].abs() > motion[freest].abs() {
                freest = i;
            }
        }
        Quantity::OF_FREEDOM[freest][1]
    }

    /// Why there is no solution, if there is none.
    fn refuse<A: Rule, const R: usize, const SET: bool, const E: usize>(
        &mut self,
        rows: &Rows<'_, T, R, SET, E, D>,
        problem: &Problem<T, D>,
        termination: Termination,
    ) -> Result<(), Status<T>> {
        let report = self.attempt.report;
        let is_solved = termination.is_solved();
        if is_solved && report.estimate.cos >= T::of(UNSEATED) {
            return Ok(());
        }
        // Contacts more than 90 degrees apart do not hold a ball: that is why. An unfinished step says nothing of it.
        let limit = if is_solved { T::of(UNSEATED) } else { T::ZERO };
        let driven_out = rows.furthest_apart::<A>(limit);
        let status = match (termination, driven_out) {
            (Termination::Singular, _) => Status::Indeterminate {
                loaded_balls: rows.loaded(),
                free: self.freest::<E>(problem),
            },
            (Termination::Unfinished, _) => Status::IterationLimit,
            (_, Some((ball, apart))) => Status::Unseated { ball, apart },
            _ => Status::Diverged {
                residual: report.residual,
            },
        };
        if termination != Termination::Unfinished {
            *self = Self::COLD;
        }
        Err(status)
    }
}
