//! The loop: damped Newton of the shaft, the balls condensed.

use crate::ball::kinematics::Rule;
use crate::bearing::L0;
use crate::linalg::{moved, norm, product, refer, vector};
use crate::real::Real;
use crate::rows::row::Estimate;
use crate::rows::{Pass, Rows, Time};
use crate::solver::problem::Problem;
use crate::solver::state::{Control, State, Step, StepReport, Termination, rounding};
use crate::tuning;

impl<T: Real, const D: usize> Control<T, D> {
    /// Accepts or rejects the last step by the unbalanced force `r` it led to: the part to be taken back, if any.
    ///
    /// A residual of rounding rejects no step. `rounded(part)`: rounding, capped at this part of a ball's force, explains the
    /// residual; `enough` is a part that makes no difference.
    #[inline(always)]
    fn review(&mut self, r: &[T; D], enough: T, rounded: impl Fn(T) -> bool) -> Option<[T; D]> {
        let step = &mut self.last;
        if !(step.work > T::ZERO) {
            return None;
        }
        let work = product(r, &step.du);
        let turned = work < -step.work;
        if step.damped && rounded(enough) {
            self.least = T::of(0.5) * T::EPSILON;
            self.radius = T::of(0.5 * L0).at_most(self.radius + self.radius);
            return None;
        }
        if turned && rounded(T::ONE) {
            return None;
        }
        if work < T::of(-tuning::REJECT) * step.work {
            // Back to where the unbalanced force turned round, were it to grow with the cube.
            let part = (step.work / (step.work - work)).cbrt_or_zero();
            let part = part.at_least(T::of(0.25));
            let whole = step.du;
            step.du = whole.map(|x| part * x);
            step.work = part * step.work;
            self.radius = norm(&step.du);
            return Some(whole.map(|x| (part - T::ONE) * x));
        }
        if turned {
            self.radius = T::of(0.5) * norm(&step.du);
        } else if work > T::of(-0.5) * step.work {
            // A damped step that changes nothing was too short.
            self.least = if step.damped && work > T::of(0.5) * step.work {
                T::of(0.1) * self.least
            } else {
                T::of(tuning::DAMPING)
            };
            if norm(&step.du) > T::of(0.4) * self.radius {
                self.radius = T::of(0.5 * L0).at_most(self.radius + self.radius);
            }
        }
        None
    }
}

impl<T: Real, const D: usize> State<T, D> {
    /// Moves the ring by the step `du` of the groove plane.
    fn advance(&mut self, du: [T; D]) {
        for (v, step) in self.v.iter_mut().zip(du) {
            *v += step;
        }
    }

    /// Goes back to where the balls were condensed.
    fn stay<const R: usize, const SET: bool, const E: usize>(
        &mut self,
        rows: &mut Rows<'_, T, R, SET, E, D>,
    ) {
        self.v = self.at;
        for deflection in rows.deflections() {
            deflection.stay();
        }
    }

    /// Residual at the predicted speed: load minus the balls' forces, extrapolated by the relative change `ds` of `omega^2`. A
    /// freedom whose displacement is prescribed has none, since its support takes it.
    fn unbalanced<const E: usize>(&self, problem: &Problem<T, D>, ds: T) -> [T; D] {
        let sum = &self.sum;
        let mut r = vector(|i| problem.load[i] - sum.force[i] - ds * sum.by_speed[i]);
        if !problem.is_free {
            problem.release::<E>(&mut r);
        }
        r
    }

    /// Largest diagonal element of the tangent.
    #[inline(never)]
    pub(super) fn stiffest(&self) -> T {
        let mut largest = T::TINY;
        for i in 0..D {
            largest = largest.at_least(self.sum.k[i][i].abs());
        }
        largest
    }

    /// Factors the tangent. A given displacement stands in the place of the equation of its freedom.
    pub(super) fn factor<const E: usize>(&mut self, problem: &Problem<T, D>, damping: T) {
        if problem.is_free {
            self.factors.factor(&self.sum.k, damping);
            return;
        }
        let mut k = problem.tangent_given::<E>(&self.sum.k);
        for (i, held) in problem.prescribed.iter().enumerate() {
            if held.is_some() {
                k[i] = [T::ZERO; D];
                k[i][i] = T::ONE;
            }
        }
        self.factors.factor(&k, damping);
    }

    /// The step to where the tangent sees equilibrium under the unbalanced force `r`, its length, whether it is damped.
    ///
    /// It is damped where the tangent is not positive definite, or the step longer than `radius`.
    fn step<const E: usize>(
        &mut self,
        plane: T,
        problem: &Problem<T, D>,
        r: &[T; D],
        radius: T,
        least: T,
    ) -> ([T; D], T, bool) {
        let mut damping = T::ZERO;
        loop {
            if damping > T::ZERO || !(self.plain && problem.is_free) {
                self.factor::<E>(problem, damping);
            }
            let mut b = *r;
            if !problem.is_free {
                let mut u = self.displacement(plane);
                let mut force = vector(|i| self.sum.force[i] - problem.load[i]);
                problem.given_motion::<E>(&mut u, &mut force);
                if let Some(piece) = problem.overhang::<E>() {
                    refer(piece.length, &mut b);
                }
                for i in 0..D {
                    if let Some(given) = problem.prescribed[i] {
                        b[i] = (T::ONE + damping) * (given - u[i]);
                    }
                }
            }
            let mut du = self.factors.back_substitute(&b);
            let mut is_long = false;
            if let Some(piece) = problem.overhang::<E>() {
                // Back to the centre. Damping moves no displacement that is given: a step is as long as it may be.
                let k = problem.tangent_given::<E>(&self.sum.k);
                let mut force: [T; D] = vector(|i| product(&k[i], &du));
                refer(-piece.length, &mut force);
                let (at_centre, bent) = (moved(piece.length, &du), piece.deflection(&force));
                du = vector(|i| at_centre[i] - bent[i]);
                let part = (radius / norm(&du)).at_most(T::ONE);
                is_long = part < T::ONE;
                du = du.map(|u| part * u);
            }
            let length = norm(&du);
            if !(damping > T::ZERO) {
                // No solve gives the displacement of a sleeve.
                let is_missing = D == 6 && problem.prescribed[D - 1].is_some();
                self.weak = self.factors.is_weak(is_missing);
            }
            if self.factors.least > T::ZERO && (is_long || length <= radius) {
                let damped = damping > T::ZERO || is_long;
                self.plain = problem.is_free && !damped;
                return (du, length, damped);
            }
            if damping > T::ZERO {
                damping = T::of(tuning::DAMPING_GROWTH) * damping;
            } else {
                // Where no ball carries, the ring floats towards its load.
                let floating = T::of(1e-3) * norm(r) / radius;
                damping = (least * self.stiffest())
                    .at_least(floating)
                    .at_least(T::TINY);
            }
            if !(damping < T::ONE / T::TINY.sqrt_abs()) {
                return ([T::ZERO; D], T::ZERO, true);
            }
        }
    }

    /// Moves the shaft to where the last linearisation sees it under the problem's load, from where a solution or an unfinished
    /// attempt has left it.
    ///
    /// `ds` is the relative change of `omega^2`.
    pub fn predict<const R: usize, const SET: bool, const E: usize>(
        &mut self,
        rows: &mut Rows<'_, T, R, SET, E, D>,
        problem: &Problem<T, D>,
        ds: T,
    ) {
        if self.attempt.pass.is_open() {
            return;
        }
        self.attempt.pass.ds = ds;
        if self.attempt.back {
            return;
        }
        let plane = rows.layout.plane;
        self.stay(rows);
        let r = self.unbalanced::<E>(problem, ds);
        let Control { radius, least, .. } = self.attempt.control;
        let is_first = self.attempt.taken == 0;
        let radius = if is_first {
            T::ONE / T::TINY.sqrt_abs()
        } else {
            radius
        };
        let (du, _, damped) = self.step::<E>(plane, problem, &r, radius, least);
        rows.deflect(&du, ds);
        let work = product(&r, &du);
        self.attempt.control.last = Step { du, work, damped };
        if is_first || problem.overhang::<E>().is_some() {
            self.attempt.control.last.work = T::ZERO;
        }
        self.advance(moved(plane, &du));
    }

    /// Newton's method from where ring and balls are, until an end, or until the time is up, which is asked after every row.
    pub fn newton<A: Rule, const R: usize, const SET: bool, const E: usize>(
        &mut self,
        rows: &mut Rows<'_, T, R, SET, E, D>,
        problem: &Problem<T, D>,
        time: &mut Time<'_>,
    ) -> Termination {
        let plane = rows.layout.plane;
        while !self.attempt.is_used_up(time.taken) {
            if !rows.condense::<A>(&self.v, &mut self.attempt.pass, time) {
                return Termination::Unfinished;
            }
            let near = !self.attempt.pass.far;
            self.attempt.pass = Pass::NONE;
            rows.sum::<A>(&mut self.sum);
            (self.at, self.stale, self.plain) = (self.v, false, false);
            (time.taken, self.attempt.taken) = (time.taken + 1, self.attempt.taken + 1);
            time.is_up |= time.taken >= time.max_iterations;

            let r = self.unbalanced::<E>(problem, T::ZERO);
            let mut size = problem.load_scale.at_least(*rows.preload);
            if !problem.is_free {
                size = size.at_least(norm(&self.sum.force));
            }
            let before = self.attempt.report;
            let residual = norm(&r) / size.at_least(T::TINY);
            if !residual.is_finite() {
                // No figure that is not a number is handed on.
                self.attempt.report.residual = T::ONE;
                return Termination::Lost;
            }
            self.attempt.report.residual = residual;
            let stalled = !(residual < T::of(0.5) * before.residual);
            let at = self.at;
            let rounded = |rows: &Rows<'_, T, R, SET, E, D>, most| {
                stalled && residual < before.rounding(rows, problem, &at, most)
            };
            let control = &mut self.attempt.control;
            let back = control.review(&r, problem.enough, |most| rounded(rows, most));
            let Control { radius, least, .. } = *control;
            self.attempt.back = back.is_some();
            if let Some(back) = back {
                for deflection in rows.deflections() {
                    deflection.end_step();
                }
                let planar = moved(plane, &back);
                self.advance(planar);
                if time.is_up {
                    self.estimate_change::<A, R, SET, E>(rows, &planar, false);
                    break;
                }
                continue;
            }
            let (du, length, damped) = self.step::<E>(plane, problem, &r, radius, least);
            rows.deflect(&du, T::ZERO);
            let planar = moved(plane, &du);
            self.attempt.report.step = length;
            self.advance(planar);
            // With a residual above `far`, the step changes the stiffness: no need to estimate it.
            let far = residual > problem.far;
            if !far || time.is_up {
                let may_correct = near && !damped && time.is_up;
                self.estimate_change::<A, R, SET, E>(rows, &planar, may_correct);
            }
            let work = product(&r, &du);
            if damped {
                // Balanced, and the least damping is below rounding.
                let stays = least < T::EPSILON || !(work > T::ZERO);
                if stays && self.weak && rounded(rows, problem.enough) {
                    return Termination::Singular;
                }
            } else if near && !far {
                match self.verdict(rows, problem, &before) {
                    None => {}
                    Some(Termination::Rounded) if !problem.is_held_by(rows) => {
                        return Termination::Singular;
                    }
                    _ if self.weak => return Termination::Singular,
                    Some(termination) => return termination,
                }
            }
            // A prescribed displacement does no work: do not judge this step by work.
            let led = problem.overhang::<E>().is_some();
            let work = if led { T::ZERO } else { work };
            self.attempt.control.last = Step { du, work, damped };
            if time.is_up {
                if self.stale {
                    let estimate = &mut self.attempt.report.estimate;
                    let second = rows.second_order::<A>(&planar) / estimate.largest;
                    estimate.force = estimate.force.at_least(second);
                }
                break;
            }
        }
        if self.attempt.is_used_up(time.taken) {
            Termination::Lost
        } else {
            Termination::Unfinished
        }
    }

    /// Estimates how far the step `planar` of the groove plane changes the stiffness. With `may_correct`, the stiffness is stale
    /// where its correction along the step makes it better.
    #[inline(never)]
    fn estimate_change<A: Rule, const R: usize, const SET: bool, const E: usize>(
        &mut self,
        rows: &Rows<'_, T, R, SET, E, D>,
        planar: &[T; D],
        may_correct: bool,
    ) {
        let (changes, mut estimate) = rows.changes::<A>(planar);
        // The largest quotient, with one division.
        let (mut change, mut element) = (T::ZERO, T::ONE);
        for i in 0..D {
            let diagonal = self.sum.k[i][i].abs().at_least(T::TINY);
            if changes[i] * element > change * diagonal {
                (change, element) = (changes[i], diagonal);
            }
        }
        estimate.k = T::of(3.0) * (change / element);
        estimate.force = estimate.force / estimate.largest;
        self.stale = may_correct && estimate.corrected() < estimate.k;
        self.attempt.report.estimate = estimate;
    }

    /// Whether rounding explains the residual and the error of forces. A ball that touches without force has an error of
    /// rounding^(3/2).
    #[cold]
    #[inline(never)]
    fn is_rounded<const R: usize, const SET: bool, const E: usize>(
        &self,
        rows: &Rows<'_, T, R, SET, E, D>,
        problem: &Problem<T, D>,
        report: &StepReport<T>,
    ) -> bool {
        let of_ball = rounding(report.estimate.largest, &self.at);
        let most = problem.enough.at_least(of_ball * of_ball.sqrt_abs());
        report.estimate.force <= most
            && report.residual < report.rounding(rows, problem, &self.at, T::ONE)
    }

    /// How the loop ends with the last step, if that was small enough.
    fn verdict<const R: usize, const SET: bool, const E: usize>(
        &mut self,
        rows: &mut Rows<'_, T, R, SET, E, D>,
        problem: &Problem<T, D>,
        before: &StepReport<T>,
    ) -> Option<Termination> {
        let report = self.attempt.report;
        let Estimate {
            k, relative, force, ..
        } = report.estimate;
        let enough = problem.enough;
        let half = T::of(0.5);
        let stalled = k > half * before.estimate.k && !(report.residual < half * before.residual);
        let corrected = report.estimate.corrected();
        if corrected <= problem.tolerance && force <= enough {
            self.stale = k > problem.tolerance;
            if self.stale {
                self.attempt.report.estimate.k = corrected;
            }
            Some(Termination::Converged)
        } else if stalled
            && relative < T::of(tuning::COARSE)
            && self.is_rounded(rows, problem, &report)
        {
            // Discard the step: along a weak direction it may be long. The residual was judged before it.
            self.stay(rows);
            self.stale = false;
            Some(Termination::Rounded)
        } else {
            None
        }
    }
}
