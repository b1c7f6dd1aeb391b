//! The bearing at rest: every ball is one spring, and the ring's displacement decides everything.
//!
//! The line of the two grooves' centres is as long as the undeformed one and the deformation `delta` of
//! both contacts, and the ball's force `Q = delta^(3/2)` (in units of the constants) is along it. The energy
//! `sum 2/5 delta+^(5/2) - F.u` is convex in the ring's displacement and its tangent the sum of the balls':
//! Newton's method on five numbers.
//!
//! A pass looks at all balls and makes one such step; a sweep is as many passes as leave next to nothing of
//! the load's balance that it began with, 16 at most, as at speed the ring balances the balls' laws within a
//! sweep. The bound on sweeps bounds them all.
//!
//! From nothing the ring starts where the balls carry the load and some preload, or, under a load that is nearly
//! radial, where it faces that.
//!
//! Two things make Newton's steps slow, or fail. Under a light load the deformation is much less than what a
//! step of the ring along the grooves adds to it, the square of the step: forces explode, and a search for
//! a step that does not explode them crawls. So deformations are unknowns of their own first: they *lead*,
//! and what geometry says beyond them, the lag, is taken out by the next step. And a contact that a step
//! closes has had no part in that step: it ends where the first one touches.
//!
//! Where that has led nowhere after some sweeps, geometry leads, the load is made so heavy that a step along
//! the grooves counts little, and is lightened whenever most of it is balanced; a step that turns the force
//! along it over, to many times what it was, is halved. As a function of the ring alone the energy is convex,
//! so that no other minimum stops this.
//!
//! After a solve the ring starts where the last tangent sees it under the new load, less what the balls' forces do
//! beyond that tangent on the way there: what is left is of the third order, and one pass is enough.
//!
//! The stiffness is the last tangent. By how much the step after it changes every ball's is known, and is what
//! is said of its error. Where rounding ends a solve, that can be far more than the tolerance, and another pass
//! takes the tangent after that step.

use super::course::{Attempt, Course, Outcome, Rounding, relative};
use super::iteration::{Given, Iteration, Task};
use super::thresholds::{self, at_rest};
use crate::ball::Share;
use crate::conditions::{Conditions, held};
use crate::constants::Split;
use crate::contact::{Contact, Pair, Reference, add, scale};
use crate::float::Real;
use crate::freedoms::{BallStore, Freedoms};
use crate::outputs::Outputs;
use crate::ring::{self, Change, Position, Sums, curvature_centre, dot5, norm, shift, side, span};
use crate::scene::Static;
use crate::status::Status;
use core::array::from_fn;

/// A ball at rest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Still<T> {
    /// The inner groove's curvature centre as seen from the outer one's, at the ring's reference.
    pub centres: Reference<T>,
    /// Direction of the line of centres.
    normal: Pair<T>,
    /// Deformation, where it leads; 0 lets geometry lead.
    delta: T,
    /// Deformation by geometry beyond that.
    lag: T,
    /// Slope of the force.
    slope: T,
}

impl<T: Real> Still<T> {
    /// By how much the force after a motion `da` of the inner groove is more than its linearisation says: along
    /// the line of centres by the law, for no more than the deformation; across it by the second-order terms.
    #[inline(always)]
    fn beyond(&self, da: Pair<T>) -> Pair<T> {
        if !(self.delta > T::ZERO) {
            return [T::ZERO; 2];
        }
        let [s, c] = self.normal;
        let along = s * da[0] + c * da[1];
        let turn = c * da[0] - s * da[1];
        let squared = T::of(0.5) * turn * turn;
        let most = self.delta;
        let more = (along + squared).at_most(most).at_least(-most);
        let to = self.delta + more;
        let (before, after) = (T::of(1.0 / 1.5) * self.slope * self.delta, to * to.sqrt());
        let along = after - before - self.slope * along - before * squared;
        let across = (after - before - before * more) * turn;
        [s * along + c * across, c * along - s * across]
    }
}

impl<T: Real, B, O, const D: usize> Iteration<'_, T, Static, B, O, D>
where
    Freedoms<D>: BallStore,
    B: Conditions<Freedoms<D>>,
    O: Outputs,
{
    /// How many freedoms are not held.
    const FREE: usize = {
        let (mut free, mut i) = (0, 0);
        while i < D {
            free += !B::HELD[i] as usize;
            i += 1;
        }
        free
    };

    /// Force and tangent of all balls at the present position; `leading` lets deformations lead. Returns how many
    /// carry more than `least`.
    fn evaluate(&mut self, leading: bool, least: T) -> u16 {
        let mut loaded: u16 = 0;
        let mut sums = Sums::about(self.state.mean);
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let a = shift(&self.state.position.offset, at);
            let mut contact = Contact::between(&ball.centres, a, T::ONE);
            let lead = ball.delta;
            let lag = contact.delta - lead;
            if leading && lead > T::ZERO && lag.abs() > T::of(at_rest::AGREES) * lead {
                (contact.delta, contact.lag) = (lead, lag);
            }
            contact.press(T::ONE);
            *ball = Still {
                centres: ball.centres,
                normal: contact.normal(),
                delta: contact.delta,
                lag: contact.lag,
                slope: contact.slope,
            };
            loaded += u16::from(contact.q > least);
            // H = dQ/d delta n n + Q/|A| t t.
            let across = contact.q * contact.inverse_radius;
            let twist = contact.slope - across;
            let mixed = twist * contact.sin * contact.cos;
            let share = Share {
                force: scale(contact.q + contact.slope * contact.lag, contact.normal()),
                stiffness: [
                    [across + twist * contact.sin * contact.sin, mixed],
                    [mixed, across + twist * contact.cos * contact.cos],
                ],
                ..Share::NONE
            };
            sums.add(at, &share, true);
        }
        self.state.force = sums.force();
        self.state.mean = sums.mean(ring::sharing::<T, D>(self.c));
        self.state.tangent = sums.tangent(true);
        loaded
    }

    /// Moves the ring by `du`, and deformations with it.
    fn displace(&mut self, du: &[T; D]) -> Change<T> {
        let mut all = Change::<T>::default();
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let da = shift(du, at);
            let [s, c] = ball.normal;
            let along = ball.lag + s * da[0] + c * da[1];
            let turn = c * da[0] - s * da[1];
            let to = ball.delta + along;
            let slope = T::of(1.5) * to.at_least(T::ZERO).sqrt();
            // A contact's stiffness along it changes by its slope, and what turns by the square of the turn.
            let steeper = (slope - ball.slope).abs();
            let mixed = s * c;
            let turned =
                slope.at_least(ball.slope) * turn.abs() * ((mixed + mixed).abs() + turn.abs());
            all.stiffness = add(
                all.stiffness,
                [steeper * s * s + turned, steeper * c * c + turned],
            );
            let mut led = to;
            if ball.delta > T::ZERO {
                all.hardening += T::of(6.0) * ball.slope / ball.delta;
                if along > T::of(at_rest::AGREES) * ball.delta {
                    // The force, not the deformation, grows as the linearisation says: a Pade approximant of
                    // (1 + 3/2 x)^(2/3), x the part by which the deformation grows. Where it grows by less,
                    // geometry leads.
                    led = ball.delta * (ball.delta + T::of(1.25) * along)
                        / (ball.delta + T::of(0.25) * along);
                }
            }
            (ball.delta, ball.lag) = (led, T::ZERO);
        }
        for (offset, step) in self.state.position.offset.iter_mut().zip(du) {
            *offset += *step;
        }
        all
    }

    /// The part of the step `du` after which the first contact that it closes carries no more than belongs to
    /// the deformation `most`.
    fn room(&self, du: &[T; D], most: T) -> T {
        let mut part = T::ONE;
        for (ball, at) in self.balls.iter().zip(self.azimuths) {
            let da = shift(du, at);
            let [s, c] = ball.normal;
            let along = s * da[0] + c * da[1];
            let turn = c * da[0] - s * da[1];
            let squared = turn * turn;
            let room = most - ball.delta;
            let closes = part * (along + T::of(0.5) * part * squared) > room;
            if closes && !(ball.delta > T::ZERO) {
                let root = (along * along + (squared + squared) * room).sqrt();
                part = (room + room) / (along + root);
            }
        }
        part
    }

    /// Moves the reference next to the present position.
    fn refer(&mut self) {
        self.state.position.rebase();
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let (coarse, fine) = curvature_centre(self.c, &self.state.position.reference, at);
            ball.centres = Reference::at(coarse, fine, Split::ONE);
        }
    }

    /// Puts the ring at `u`.
    fn put(&mut self, u: &[T; D]) {
        self.state.position = Position {
            reference: [T::ZERO; D],
            offset: *u,
        };
        self.refer();
    }

    /// Starts from nothing.
    fn begin(&mut self, load: &[T; D], wanted: &[T; D], attempt: Attempt) {
        if let Some(u) = self.facing(load, attempt) {
            self.state.mean = [T::ZERO; 2];
            return self.put(&u);
        }
        let n0 = &self.c.n0;
        let (q, x) = self.pressed(load, T::of(attempt.preload()));
        self.state.mean = scale(side(load) * q, [n0[1].high / (n0[0].high + x), T::ONE]);
        self.put(&self.displaced(x, wanted));
    }

    /// Moves a solved bearing to where its tangent, and what of the second order matters, see it under a new load.
    fn extrapolate(&mut self, load: &[T; D], wanted: &[T; D]) {
        let b = from_fn(|i| load[i] - self.state.force[i]);
        let du = self.extrapolation(b, wanted, |_, ball, da| ball.beyond(da));
        for (offset, step) in self.state.position.offset.iter_mut().zip(&du) {
            *offset += *step;
        }
    }

    /// Starts as an `attempt` does, and sweeps until converged, or until there were `until` sweeps.
    pub fn equilibrate(
        &mut self,
        outcome: &mut Outcome<T>,
        task: &Task<T, D>,
        attempt: Attempt,
        until: u16,
    ) {
        match &task.given {
            Given::Displacement(u) => {
                self.put(u);
                self.evaluate(false, T::ZERO);
                outcome.sweeps = 1;
                outcome.hardening = self.displace(&[T::ZERO; D]).hardening;
                (outcome.change, outcome.remainder, outcome.residual) = (T::ZERO, T::ZERO, T::ZERO);
                outcome.status = Status::Converged;
            }
            Given::Load(load) => {
                if attempt == Attempt::Warm {
                    self.extrapolate(load, &task.wanted);
                } else {
                    self.begin(load, &task.wanted, attempt);
                }
                self.run(outcome, load, task.tolerance, attempt, until);
            }
        }
    }

    /// Sweeps until `load` is balanced, or until there were `until` sweeps.
    fn run(
        &mut self,
        outcome: &mut Outcome<T>,
        load: &[T; D],
        tolerance: T,
        attempt: Attempt,
        mut until: u16,
    ) {
        let last = attempt == Attempt::Preloaded;
        if !last {
            until = until.min(outcome.sweeps.saturating_add(at_rest::LEADING));
        }
        // After a start geometry leads: as balls were left by the last solve, they would not know of it.
        let mut leading = false;
        let applied = norm(load);
        let mut size = applied;
        // The deformation up to which a step may close a contact at once.
        let touch = |size: T| {
            let root = (T::of(at_rest::CLOSES) * size).cbrt();
            root * root
        };
        let mut touching = touch(size);
        let rounding = Rounding::of(T::ZERO, size);
        let mut course = Course::<T>::new(attempt);
        outcome.status = Status::SweepLimit;
        outcome.change = T::ONE;
        let mut heavier = T::ONE;
        if last && applied > T::ZERO {
            let heavy = T::of(at_rest::HEAVY) * ring::sharing::<T, D>(self.c);
            heavier = heavier.at_least(heavy / applied.at_least(T::TINY));
        }
        // The last step, and the force along it.
        let (mut du, mut driven, mut halved) = ([T::ZERO; D], T::ZERO, 0);
        // What the sweep began with, and its passes.
        let (mut began, mut passes) = (T::ZERO, at_rest::PASSES);
        let mut ended = false;
        loop {
            let loaded = self.evaluate(leading, T::of(at_rest::NOTHING) * size);
            if ended {
                outcome.repeats = outcome.repeats.saturating_add(self.balls.len() as u16);
                return;
            }
            leading = !last;
            if B::HOLDS {
                size = size.at_least(norm(&self.state.force)).at_least(T::TINY);
                touching = touch(size);
            }
            let force = self.state.force;
            let (none, mut own) = ([T::ZERO; D], [[T::ZERO; D]; D]);
            let mut b: [T; D] = from_fn(|i| heavier * load[i] - force[i]);
            if heavier > T::ONE && norm(&b) < T::of(at_rest::LIGHTENS_AT) * heavier * size {
                heavier = T::ONE.at_least(T::of(at_rest::LIGHTENED) * heavier);
                b = from_fn(|i| heavier * load[i] - force[i]);
                driven = T::ONE / T::TINY;
            }
            let tangent = held::<T, B, D>(self.c, &none, &mut b, &self.state.tangent, &mut own);
            let turned = || -dot5(&b, &du) > T::of(at_rest::TURNED) * driven;
            let unbalanced = norm(&b);
            if unbalanced <= T::of(at_rest::LEFT) * began || passes >= at_rest::PASSES {
                if outcome.sweeps >= until {
                    return;
                }
                outcome.sweeps += 1;
                (began, passes) = (unbalanced, 0);
            } else {
                outcome.repeats = outcome.repeats.saturating_add(self.balls.len() as u16);
            }
            passes += 1;
            if last && halved < at_rest::HALVED && turned() {
                for (offset, step) in self.state.position.offset.iter_mut().zip(&mut du) {
                    *step = T::of(0.5) * *step;
                    *offset -= *step;
                }
                driven = T::of(0.5) * driven;
                halved += 1;
                continue;
            }
            let (residual, change) = (outcome.residual, outcome.change);
            outcome.residual = unbalanced / size;
            let longest = T::of(at_rest::LONGEST_STEP);
            let mut weakness;
            (du, weakness) = self.descent(&b, tangent, &none, longest, true, &mut course.rung);
            if !last && usize::from(loaded) < self.balls.len() {
                let part = self.room(&du, touching);
                for step in &mut du {
                    *step = part * *step;
                }
            }
            if last {
                (driven, halved) = (dot5(&b, &du), 0);
            }
            // A ball resists in its plane, in two directions; of more, rounding shows what is not there.
            weakness.singular |= usize::from(loaded) * 2 < Self::FREE;
            outcome.weaken(&weakness);
            let rounded_part = rounding.step / outcome.residual.at_least(rounding.step);
            let moved = self.displace(&du);
            (outcome.step, outcome.imbalance) = (span(&du), T::ZERO);
            if !(outcome.step + outcome.residual).is_finite() {
                outcome.status = Status::Diverged {
                    residual: outcome.residual,
                };
                return;
            }
            outcome.change = relative(&moved.stiffness, &self.state.tangent);
            outcome.hardening = moved.hardening;
            // The tangent is that before the step, of which the change is known ball by ball.
            outcome.remainder = T::of(0.5) * outcome.change;
            let noise = T::of(at_rest::NOISE) * T::EPSILON;
            let falls =
                outcome.residual > noise && outcome.residual < T::of(at_rest::FALLS) * residual;
            course.compare(if falls { T::ZERO } else { outcome.change }, change, false);
            let now = applied.at_least(norm(&self.state.force));
            let scale = if B::HOLDS { now } else { size };
            let balanced = outcome.residual * size <= T::of(thresholds::BALANCED) * scale
                && heavier <= T::ONE
                && (last || !weakness.singular);
            let largest = span(&self.state.position.total());
            let ending = outcome.ending(&course, &rounding, rounded_part, tolerance, largest);
            if let (true, Some(status)) = (balanced, ending) {
                // The forces, too, are those after the step.
                for (force, row) in self.state.force.iter_mut().zip(&self.state.tangent) {
                    *force += dot5(row, &du);
                }
                outcome.unknown = T::of(at_rest::HIDDEN) * T::EPSILON;
                outcome.status = if weakness.singular {
                    Status::Indeterminate {
                        loaded_balls: loaded,
                    }
                } else {
                    status
                };
                ended = outcome.status == Status::PrecisionLimit && passes < at_rest::PASSES;
                if !ended {
                    return;
                }
                // The next pass leaves nothing to correct.
                (outcome.remainder, leading) = (T::ZERO, false);
                continue;
            }
            // Offsets this large would cost digits of the deformations; of large ones they may, as long as steps
            // are long.
            let offset = span(&self.state.position.offset);
            let serves =
                outcome.step > T::of(0.5) * offset && touching > T::of(at_rest::SERVES) * offset;
            if offset > T::of(thresholds::FAR_FROM_REFERENCE) && !serves {
                self.refer();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::turning::tests::spindle;
    use crate::{All, Loads, Settings, Solver};
    use std::vec::Vec;

    type Resting<'i> = Iteration<'i, f64, Static, Loads, crate::Balls, 5>;

    /// A B7005C at rest, its ring at `u`.
    fn at<R>(u: [f64; 5], look: impl FnOnce(&mut Resting<'_>) -> R) -> R {
        let bearing = spindle();
        let mut solver = Solver::<f64, 16, Static, All>::new(&bearing);
        let mut slices = solver.slices();
        let mut run = slices.iteration();
        run.state.position.offset = u;
        run.refer();
        run.evaluate(false, 0.0);
        look(&mut run)
    }

    #[test]
    fn a_step_changes_the_tangent_as_it_says() {
        // Under load along the grooves and on a radial contact, which stiffens the axial direction by turning.
        for (u, du) in [
            ([0.02, 0.0, 0.0, 0.0, 0.0], [1e-4, 0.0, 0.0, 0.0, 0.0]),
            ([0.02, 0.001, 0.0, 0.0, 0.0], [-1e-3, 1e-4, 2e-4, 0.0, 0.0]),
            (
                [-0.258_819, 0.05, 0.0, 0.0, 0.0],
                [0.02, 0.0, 0.0, 0.0, 0.0],
            ),
        ] {
            at(u, |run| {
                let before = run.state.tangent[0][0];
                let change = run.displace(&du).stiffness[0];
                run.evaluate(false, 0.0);
                let seen = change / (run.state.tangent[0][0] - before).abs();
                assert!((0.5..2.0).contains(&seen), "{u:?}, {du:?}: {seen}");
            });
        }
    }

    #[test]
    fn what_forces_do_beyond_the_tangent_is_known_to_second_order() {
        let u = [0.02, 0.001, -0.002, 1e-3, 2e-3];
        let du = [3e-4, -2e-4, 1e-4, 2e-4, -1e-4];
        at(u, |run| {
            let (before, tangent) = (run.state.force, run.state.tangent);
            let mut beyond = [0.0; 5];
            for (ball, at) in run.balls.iter().zip(run.azimuths) {
                ring::spread(&mut beyond, at, ball.beyond(shift(&du, at)), 0.0);
            }
            for (offset, step) in run.state.position.offset.iter_mut().zip(&du) {
                *offset += *step;
            }
            run.evaluate(false, 0.0);
            for i in 0..5 {
                let linear = before[i] + dot5(&tangent[i], &du);
                let left = run.state.force[i] - linear - beyond[i];
                let second = (run.state.force[i] - linear).abs();
                assert!(left.abs() < 0.05 * second, "{i}: {left:e} of {second:e}");
            }
        });
    }

    #[test]
    fn a_drifting_load_takes_one_pass() {
        let bearing = spindle();
        let settings = Settings::default();
        let mut solver = Solver::<f32, 16, Static, All>::new(&bearing);
        let load = [1000.0, 200.0, -50.0, 1.0, 3.0];
        solver.solve(load, 0.0, &settings).unwrap();
        let drifted = [1010.0, 198.0, -50.5, 1.01, 2.97];
        let warm = solver.solve(drifted, 0.0, &settings).unwrap();
        assert_eq!((warm.sweeps, warm.repeats), (1, 0));
        let k = warm.stiffness;
        let mut other = Solver::<f32, 16, Static, All>::new(&bearing);
        let cold = other.solve(drifted, 0.0, &settings).unwrap();
        for (i, (row, of_cold)) in k.iter().zip(&cold.stiffness).enumerate() {
            for (j, (x, y)) in row.iter().zip(of_cold).enumerate() {
                assert!((x - y).abs() < 2e-5 * (k[i][i] * k[j][j]).sqrt());
            }
        }
    }

    #[test]
    fn no_force_is_taken_beyond_twice_the_deformation() {
        at([0.02, 0.0, 0.0, 0.0, 0.0], |run| {
            let ball = run.balls[0];
            let force = ball.delta * ball.delta.sqrt();
            let [s, c] = ball.normal;
            let far = 100.0 * ball.delta;
            let beyond = dot5(&ball.normal, &ball.beyond([s * far, c * far]));
            let linear = force + ball.slope * far;
            assert!((linear + beyond - 2f64.powf(1.5) * force).abs() < 1e-9 * linear);
        });
    }

    #[test]
    fn the_hardening_is_that_of_a_contact_twice_as_stiff_as_both() {
        at([0.02, 0.001, 0.0, 0.0, 0.0], |run| {
            let balls: Vec<(f64, f64)> = run.balls.iter().map(|b| (b.delta, b.slope)).collect();
            let expected: f64 = balls
                .iter()
                .filter(|(delta, _)| *delta > 0.0)
                .map(|(delta, slope)| (2.0 * slope) * (2.0 * slope) / delta.powf(1.5))
                .sum();
            let hardening = run.displace(&[0.0; 5]).hardening;
            assert!((hardening / expected - 1.0).abs() < 1e-12);
        });
    }

    #[test]
    fn a_step_is_cut_where_the_first_contact_closes() {
        let du = [0.03, 0.002, 0.0, 0.0, 0.0];
        at([-0.01, 0.0, 0.0, 0.0, 0.0], |run| {
            assert!(run.balls.iter().all(|ball| ball.delta < 0.0));
            let most = 1e-4;
            let part = run.room(&du, most);
            assert!(part > 0.1 && part < 0.9, "{part}");
            run.displace(&du.map(|step| part * step));
            run.evaluate(false, 0.0);
            let deepest = run.balls.iter().map(|b| b.delta).fold(-1.0, f64::max);
            assert!((deepest / most - 1.0).abs() < 0.1, "{deepest}");
        });
    }

    #[test]
    fn a_deformation_leads_where_geometry_is_far_from_it() {
        // A step along the grooves changes geometry by its square, many deformations.
        at([2e-4, 0.0, 0.0, 0.0, 0.0], |run| {
            let expected: Vec<f64> = run.balls.iter().map(|ball| ball.delta).collect();
            let du = [0.1 * 15f64.to_radians().cos(), 0.0, 0.0, 0.0, 0.0];
            let slide = |ball: &Still<f64>| dot5(&[ball.normal[0]], &[du[0]]);
            let along: Vec<f64> = run.balls.iter().map(slide).collect();
            run.displace(&du);
            let led: Vec<f64> = run.balls.iter().map(|ball| ball.delta).collect();
            run.evaluate(true, 0.0);
            for (j, ball) in run.balls.iter().enumerate() {
                assert_eq!(ball.delta, led[j]);
                // No more than five times at once.
                assert!(led[j] > expected[j] && led[j] < 5.0 * expected[j]);
                let geometry = expected[j] + along[j];
                assert!((ball.delta + ball.lag) / geometry > 1.0);
            }
        });
    }
}
