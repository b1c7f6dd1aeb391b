//! What a solver remembers: the start of its next solve, and what results are worked out from.

use super::newton::{End, Task, Time};
use super::view::View;
use super::{Given, State, are_finite, input};
use crate::ball::Ball;
use crate::float::Real;
use crate::frame::{moved, refer_stiffness};
use crate::growth::Growth;
use crate::kinematics::Rule;
use crate::linalg::{Matrix, add_to, norm, product};
use crate::motion::Motion;
use crate::mounting::{Point, Speed};
use crate::ring::{Row, Sum, stiffening};
use crate::shaft::{Layout, Shaft};
use crate::status::Status;
use core::array::from_fn;
use core::marker::PhantomData;

/// Position and balls after the last solve of a shaft in `R` rows of at most `N` balls, with `D` freedoms.
#[derive(Debug, Clone, Copy)]
pub struct WarmStart<T, const R: usize, const N: usize, const D: usize> {
    pub state: State<T, D>,
    pub balls: [[Ball<T>; N]; R],
    /// Speed, growth and references of every row.
    pub points: [Point<T>; R],
    /// Axial force by which rows of either facing hold each other.
    internal: T,
    pub speed: Speed<T>,
}

/// Displacement of the shaft's centre, load that the rows carry there, and iterations so far.
pub struct Reached<T, const D: usize> {
    pub u: [T; D],
    pub load: [T; D],
    pub iterations: u16,
}

impl<T: Real, const R: usize, const N: usize, const D: usize> WarmStart<T, R, N, D> {
    /// Of a solver that has not solved yet.
    pub fn new<const SET: bool>(layout: &Layout<'_, T, R, SET>) -> Self {
        let point = |i: usize| Point::new(layout.bearings[i].c, T::ZERO, T::ZERO, Growth::NONE);
        Self {
            state: State::COLD,
            balls: [[Ball::default(); N]; R],
            points: from_fn(point),
            internal: T::ZERO,
            speed: Speed::REST,
        }
    }

    /// Has the next solve start from nothing.
    pub fn reset(&mut self) {
        self.state = State::COLD;
    }

    /// Checks the input, and turns it into the solver's units. Loads are given where `to_centre` refers them from.
    pub fn task<M: Motion, const SET: bool>(
        &mut self,
        layout: &Layout<'_, T, R, SET>,
        given: &[Given<T>; D],
        to_centre: impl FnOnce(&mut [T; D]),
        speed: Speed<T>,
        growth: &[Growth<T>; R],
        tolerance: T,
    ) -> Result<Task<T, D>, Status<T>> {
        let unit = layout.bearings[0].c;
        let mut task = Task::new(tolerance);
        for (i, given) in given.iter().enumerate() {
            match input::given(unit, i, layout.weight, *given)? {
                Given::Load(load) => task.load[i] = load,
                Given::Displacement(u) => (task.held[i], task.is_free) = (Some(u), false),
            }
        }
        to_centre(&mut task.load);
        let mut omega = T::ZERO;
        let mut grown = [Growth::NONE; R];
        for ((grown, growth), row) in grown.iter_mut().zip(growth).zip(&layout.bearings) {
            omega = input::omega(row.c, speed, M::AT_SPEED)?;
            *grown = input::growth(row.c, growth)?;
        }
        task.size = norm(&task.load).at_least(layout.held);
        // A ring that nothing presses and nothing holds floats in its clearance.
        if task.is_free && !(task.size > T::TINY.sqrt()) {
            return Err(Status::Unloaded);
        }
        let s = if M::AT_SPEED {
            input::inertia(unit, omega, layout.weight, task.size)
        } else {
            T::ZERO
        };
        let rows = layout.bearings.iter().zip(&layout.mounts);
        for ((row, mount), (point, growth)) in rows.zip(self.points.iter_mut().zip(grown)) {
            let [axial, ..] = mount.motion::<D, SET>(&self.state.u);
            let (s, size) = (s * mount.inertia, task.size / mount.force);
            if !point.set(row.c, s, size, growth, axial + mount.closure) {
                self.state.size = T::ZERO;
            }
        }
        self.speed = speed;
        Ok(task)
    }

    /// Solves, and says where the shaft is, or why there is no answer.
    pub fn solve<A: Rule, const SET: bool>(
        &mut self,
        layout: &Layout<'_, T, R, SET>,
        task: &Task<T, D>,
        time: &mut Time<'_>,
    ) -> Result<Reached<T, D>, Status<T>> {
        let s = self.points[0].s;
        let (mut bearings, mut balls) = (layout.bearings.iter(), self.balls.iter_mut());
        let rows = self.points.each_mut().map(|p| {
            let (row, balls) = (bearings.next(), balls.next());
            let azimuths = row.map_or(&[][..], |row| row.azimuths);
            Row {
                c: row.map_or(layout.bearings[0].c, |row| row.c),
                p,
                azimuths,
                balls: balls
                    .and_then(|balls| balls.get_mut(..azimuths.len()))
                    .unwrap_or_default(),
            }
        });
        let mut shaft = Shaft {
            rows,
            layout,
            s,
            internal: &mut self.internal,
        };
        let end = self.state.solve::<A, R, SET>(&mut shaft, task, time);
        self.state.refuse::<A, R, SET>(&shaft, task, end)?;
        let reached = self.reached(layout.plane, time.taken);
        // A tangent of other than numbers makes no undamped step.
        if are_finite(&reached.u) && are_finite(&reached.load) {
            return Ok(reached);
        }
        self.state = State::COLD;
        Err(Status::Diverged { residual: T::ONE })
    }

    fn reached(&self, plane: T, iterations: u16) -> Reached<T, D> {
        let State { v, at, sum, .. } = &self.state;
        let du = moved(-plane, &from_fn(|i| v[i] - at[i]));
        Reached {
            u: self.state.displacement(plane),
            load: from_fn(|i| sum.force[i] + product(&sum.k[i], &du)),
            iterations,
        }
    }

    /// Where a solve was that ended without an answer for want of time, if all figures are finite.
    pub fn unfinished<A: Rule, const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET>,
    ) -> Option<Reached<T, D>> {
        let attempt = &self.state.attempt;
        if attempt.outcome.end != End::Unfinished {
            return None;
        }
        let reached = self.reached(layout.plane, attempt.taken);
        let inertia = self.points[0].s * layout.weight;
        let is_finite = self.state.errors(&reached.u, inertia).is_finite()
            && are_finite(&reached.u)
            && are_finite(&reached.load)
            && self
                .stiffness::<A, SET>(layout)
                .iter()
                .all(|row| are_finite(row));
        is_finite.then_some(reached)
    }

    /// The stiffness about the shaft's centre, after the last step.
    pub fn stiffness<A: Rule, const SET: bool>(
        &self,
        layout: &Layout<'_, T, R, SET>,
    ) -> Matrix<T, D> {
        let mut k = self.state.sum.k;
        if !self.state.correct {
            return k;
        }
        let mut change = Sum::NONE;
        let rows = layout.bearings.iter().zip(&layout.mounts);
        for ((row, mount), (p, balls)) in rows.zip(self.points.iter().zip(&self.balls)) {
            let balls = balls.get(..row.azimuths.len()).unwrap_or_default();
            let v = mount.motion::<D, SET>(&self.state.v);
            if SET {
                let mut own = stiffening::<T, A, 5>(p, balls, row.azimuths, &v);
                mount.assemble(&mut own, &mut change);
            } else {
                change = stiffening::<T, A, D>(p, balls, row.azimuths, &v);
                refer_stiffness(layout.plane, &mut change.k);
            }
        }
        add_to(&mut k, &change.k);
        k
    }

    /// The balls of a row.
    #[inline(always)]
    pub fn view<'s, A: Rule, const SET: bool>(
        &'s self,
        layout: &Layout<'s, T, R, SET>,
        i: usize,
    ) -> View<'s, T, A> {
        let row = &layout.bearings[i];
        View {
            c: row.c,
            p: &self.points[i],
            azimuths: row.azimuths,
            balls: self.balls[i].get(..row.azimuths.len()).unwrap_or_default(),
            v: layout.mounts[i].motion::<D, SET>(&self.state.v),
            speed: self.speed,
            rule: PhantomData,
        }
    }
}
