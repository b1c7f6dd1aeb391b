//! A solved row of balls, to be looked at.

pub mod frequencies;
pub mod life;
pub mod margins;
pub mod snapshot;
pub mod summary;

use crate::ball::Ball;
use crate::ball::contact::Point;
use crate::ball::kinematics::{Motion, RacewayControlFree, Speed};
use crate::ball::report::{BallKinematics, BallState, Kinetics};
use crate::bearing::{Azimuth, Constants};
use crate::linalg::Matrix;
use crate::real::Real;
use crate::results::frequencies::{Frequencies, Turns};
use crate::results::life::{LifeRating, RatingLife};
use crate::results::margins::{Limits, Margins};
use crate::results::snapshot::RowSnapshot;
use crate::rows::row::{Sum, groove, stiffness_change};
use core::marker::PhantomData;

/// The balls of a solved row: what a [`Solution`](crate::Solution) and a [`RowSolution`](crate::RowSolution) say of them.
#[derive(Debug, Clone, Copy)]
pub struct Balls<'s, T: Real, M = RacewayControlFree> {
    pub(crate) c: &'s Constants<T>,
    pub(crate) p: &'s Point<T>,
    pub(crate) azimuths: &'s [Azimuth<T>],
    pub(crate) balls: &'s [Ball<T>],
    /// Offset of the groove plane from its reference position.
    pub(crate) v: [T; 5],
    pub(crate) speed: Speed<T>,
    pub(crate) motion: PhantomData<M>,
}

impl<'s, T: Real, M: Motion> Balls<'s, T, M> {
    #[inline(always)]
    fn kinetics(&self, ball: &Ball<T>, at: &Azimuth<T>) -> Kinetics<T> {
        ball.kinetics::<M::Rule>(self.c, self.p, groove(self.p, &self.v, at))
    }

    /// [`Balls::kinetics`] by a call: one for all callers but the survey.
    #[inline(never)]
    fn kinetics_by_call(&self, ball: &Ball<T>, at: &Azimuth<T>) -> Kinetics<T> {
        self.kinetics(ball, at)
    }

    fn kinetics_of_balls(&self) -> impl ExactSizeIterator<Item = Kinetics<T>> + use<'s, T, M> {
        let (row, balls) = (*self, self.balls.iter());
        let balls = balls.zip(self.azimuths);
        balls.map(move |(ball, at)| row.kinetics_by_call(ball, at))
    }

    /// States of the balls, in the order of their azimuths.
    pub fn balls(&self) -> impl ExactSizeIterator<Item = BallState<T>> + use<'s, T, M> {
        let c = self.c;
        let balls = self.kinetics_of_balls().zip(self.azimuths);
        balls.map(|(kinetics, at)| kinetics.state(c, at))
    }

    /// A copy with the first `K` balls of a row under this force, of which so much is preload.
    pub(crate) fn copy<const K: usize>(&self, force: [T; 5], preload: T) -> RowSnapshot<T, K> {
        let (mut states, mut cage_speeds) = ([BallState::default(); K], [T::ZERO; K]);
        let copies = states.iter_mut().zip(&mut cage_speeds);
        let balls = self.kinetics_of_balls().zip(self.azimuths);
        for ((state, cage_speed), (kinetics, at)) in copies.zip(balls) {
            *state = kinetics.state(self.c, at);
            *cage_speed = kinetics.mu * self.speed.as_rad_per_s();
        }
        RowSnapshot {
            force,
            preload,
            ball_count: self.balls.len(),
            balls: states,
            cage_speeds,
        }
    }

    /// Forces on the inner and the outer contact of every ball, N.
    pub(crate) fn contact_forces(&self) -> impl ExactSizeIterator<Item = (T, T)> + use<'s, T, M> {
        let force = self.c.force;
        self.kinetics_of_balls()
            .map(move |kinetics| (kinetics.inner.q * force, kinetics.outer.q * force))
    }

    /// Forces on the inner race alone, N, in the order of the balls: without the cost of contact angles.
    pub fn inner_forces(&self) -> impl ExactSizeIterator<Item = T> + use<'s, T, M> {
        self.contact_forces().map(|(inner, _)| inner)
    }

    /// Cage speed `omega_m` of every ball about the bearing's axis, rad/s, in the order of the balls.
    ///
    /// The contact angles of a loaded bearing differ, and with them the speeds: the cage turns at about their mean. A
    /// ball without contact has the speed that its contact angles would give it.
    pub fn cage_speeds(&self) -> impl ExactSizeIterator<Item = T> + use<'s, T, M> {
        let omega = self.speed.as_rad_per_s();
        self.kinetics_of_balls()
            .map(move |kinetics| kinetics.mu * omega)
    }

    /// How every ball turns, and how its contacts are pressed, in the order of the balls.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed};
    /// let bearing = Bearing::<f64, 16>::new(&Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians()))?;
    /// let mut solver = Solver::new();
    /// let (load, speed) = ([300.0, 50.0, 0.0, 0.0, 0.0], Speed::rpm(12_000.0));
    /// let solution = solver.solve(&bearing, load, speed, &Settings::default())?;
    /// for ball in solution.kinematics() {
    ///     println!("{:.2} GPa, {:.0} rad/s", ball.inner.peak_pressure / 1e9, ball.rotation);
    /// }
    /// let frequencies = solution.frequencies();
    /// println!("a damaged outer race hums at {:.0} Hz", frequencies.outer_race);
    /// assert!((frequencies.outer_race + frequencies.inner_race - 16.0 * 200.0).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn kinematics(&self) -> impl ExactSizeIterator<Item = BallKinematics<T>> + use<'s, T, M> {
        let (c, omega) = (self.c, self.speed.as_rad_per_s());
        self.kinetics_of_balls()
            .map(move |kinetics| kinetics.turning(c, omega))
    }

    /// Frequencies at which damaged parts of the bearing are heard: see [`Balls::kinematics`].
    pub fn frequencies(&self) -> Frequencies<T> {
        let mut turns = Turns::none();
        for kinetics in self.kinetics_of_balls() {
            turns.take(self.c, &kinetics);
        }
        turns.frequencies(self.c, self.speed.as_rad_per_s())
    }

    /// Rating life under this load at this speed: see [`LifeRating`].
    pub fn rating_life(&self, rating: &LifeRating<T>) -> RatingLife<T> {
        let weight = rating.weight_of(self.contact_forces());
        RatingLife::of_weight(weight, self.speed.as_rad_per_s())
    }

    /// Looks at every ball once, and hands each on with its number.
    // In line: results of a call go through memory (+1,500 cycles).
    #[inline(always)]
    pub(crate) fn survey(
        &self,
        limits: &Limits<T>,
        mut each: impl FnMut(u16, &Kinetics<T>),
    ) -> Margins<T> {
        let mut margins = Margins::new(*limits);
        let mut number = 0_u16;
        for (ball, at) in self.balls.iter().zip(self.azimuths) {
            let kinetics = self.kinetics(ball, at);
            each(number, &kinetics);
            margins.take(self.c, number, &kinetics);
            number = number.saturating_add(1);
        }
        margins
    }

    /// How near this equilibrium is to its limits, and which limits are passed: the given ones, and the grooves' own.
    ///
    /// ```
    /// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed};
    /// use spindle_bearing::{Limit, Limits};
    /// let bearing = Bearing::<f64, 16>::new(&Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians()))?;
    /// let mut solver = Solver::new();
    /// let (load, speed) = ([6000.0, 0.0, 0.0, 0.0, 0.0], Speed::rad_per_s(2000.0));
    /// let solution = solver.solve(&bearing, load, speed, &Settings::default())?;
    /// let limits = Limits { peak_pressure: 2e9, ..Limits::default() };
    /// let margins = solution.margins(&limits);
    /// // For the worst contact of each limit that is passed, a sentence.
    /// println!("{margins}");
    /// assert!(margins.passed().contains(Limit::PeakPressure) && margins.unloaded == 0);
    /// assert!(margins.get(Limit::PeakPressure).is_some_and(|worst| worst.value > 2e9));
    /// assert!(margins.get(Limit::Shoulder).is_some_and(|worst| worst.value < 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[inline(never)]
    pub fn margins(&self, limits: &Limits<T>) -> Margins<T> {
        self.survey(limits, |_, _| ())
    }

    /// Change of the stiffness along the motion from where the balls were condensed, referred to the groove plane.
    pub(crate) fn stiffness_change(&self) -> Matrix<T, 5> {
        let change: Sum<T, 5> =
            stiffness_change::<T, M::Rule, 5>(self.p, self.balls, self.azimuths, &self.v);
        change.k
    }
}
