//! A solved row of balls, to be looked at.

pub mod frequencies;
pub mod life;
pub mod margins;
#[cfg(feature = "serde")]
pub mod serialize;
pub mod summary;

use crate::ball::Ball;
use crate::ball::contact::Point;
use crate::ball::kinematics::{Rule, Speed};
use crate::ball::report::{BallKinematics, BallState, Kinetics};
use crate::bearing::{Azimuth, Constants};
use crate::linalg::Matrix;
use crate::real::Real;
use crate::results::frequencies::Frequencies;
use crate::results::margins::{Limits, Margins};
use crate::shaft::row::{Sum, groove, stiffness_change};
use core::marker::PhantomData;

/// The balls of a row where a solve has left them.
#[derive(Debug, Clone, Copy)]
pub struct View<'s, T: Real, R> {
    pub c: &'s Constants<T>,
    pub p: &'s Point<T>,
    pub azimuths: &'s [Azimuth<T>],
    pub balls: &'s [Ball<T>],
    /// Offset of the groove plane from its reference position.
    pub v: [T; 5],
    pub speed: Speed<T>,
    pub rule: PhantomData<R>,
}

impl<'s, T: Real, R: Rule> View<'s, T, R> {
    #[inline(always)]
    fn kinetics(&self, ball: &Ball<T>, at: &Azimuth<T>) -> Kinetics<T> {
        ball.kinetics::<R>(self.c, self.p, groove(self.p, &self.v, at))
    }

    /// [`View::kinetics`] by a call: one for all callers but the survey.
    #[inline(never)]
    fn kinetics_by_call(&self, ball: &Ball<T>, at: &Azimuth<T>) -> Kinetics<T> {
        self.kinetics(ball, at)
    }

    pub fn kinetics_of_balls(self) -> impl ExactSizeIterator<Item = Kinetics<T>> + 's {
        let balls = self.balls.iter();
        balls
            .zip(self.azimuths)
            .map(move |(ball, at)| self.kinetics_by_call(ball, at))
    }

    pub fn states(self) -> impl ExactSizeIterator<Item = BallState<T>> + 's {
        self.kinetics_of_balls()
            .zip(self.azimuths)
            .map(move |(kinetics, at)| kinetics.state(self.c, at))
    }

    /// States and cage speeds of the first `K` balls.
    pub fn copy<const K: usize>(self) -> ([BallState<T>; K], [T; K]) {
        let (mut states, mut cage_speeds) = ([BallState::default(); K], [T::ZERO; K]);
        let copies = states.iter_mut().zip(&mut cage_speeds);
        let balls = self.kinetics_of_balls().zip(self.azimuths);
        for ((state, cage_speed), (kinetics, at)) in copies.zip(balls) {
            *state = kinetics.state(self.c, at);
            *cage_speed = kinetics.mu * self.speed.as_rad_per_s();
        }
        (states, cage_speeds)
    }

    /// Forces on the inner and the outer contact of every ball, N.
    pub fn contact_forces(self) -> impl ExactSizeIterator<Item = (T, T)> + 's {
        let force = self.c.force;
        self.kinetics_of_balls()
            .map(move |kinetics| (kinetics.inner.q * force, kinetics.outer.q * force))
    }

    pub fn cage_speeds(self) -> impl ExactSizeIterator<Item = T> + 's {
        let omega = self.speed.as_rad_per_s();
        self.kinetics_of_balls()
            .map(move |kinetics| kinetics.mu * omega)
    }

    pub fn kinematics(self) -> impl ExactSizeIterator<Item = BallKinematics<T>> + 's {
        let omega = self.speed.as_rad_per_s();
        self.kinetics_of_balls()
            .map(move |kinetics| kinetics.turning(self.c, omega))
    }

    pub fn frequencies(self) -> Frequencies<T> {
        Frequencies::of(self.kinematics(), self.c.balls, self.speed.as_rad_per_s())
    }

    /// Looks at every ball once, and hands each on with its number.
    // In line: results of a call go through memory (+1,500 cycles).
    #[inline(always)]
    pub fn survey(
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

    /// The survey alone.
    #[inline(never)]
    pub fn margins(self, limits: &Limits<T>) -> Margins<T> {
        self.survey(limits, |_, _| ())
    }

    /// Change of the stiffness along the motion from where the balls were condensed, referred to the groove plane.
    pub fn stiffness_change(self) -> Matrix<T, 5> {
        let change: Sum<T, 5> =
            stiffness_change::<T, R, 5>(self.p, self.balls, self.azimuths, &self.v);
        change.k
    }
}
