//! The equilibrium of a shaft in its bearings.

use crate::ball::kinematics::{Full, Motion, Speed};
use crate::growth::Growth;
use crate::linalg::{moved, refer, vector};
use crate::real::Real;
use crate::solver::problem::{Given, Settings, radius};
use crate::solver::state::are_finite;
use crate::solver::warm_start::WarmStart;
use crate::spindle::Spindle;
use crate::spindle::solution::SpindleSolution;
use crate::status::Status;
use core::array::from_fn;
use core::marker::PhantomData;

/// A solver for one spindle: owns it, borrows the bearings' constants, and keeps the state that the next solve starts from.
///
/// `M` is how the balls move, as for [`Solver`](crate::Solver). `D` is the spindle's: 6 for a sprung one, whose solver is a
/// [`SprungSolver`]. See [`Spindle`] for an example.
#[derive(Debug, Clone)]
pub struct SpindleSolver<
    'b,
    T: Real,
    const R: usize,
    const N: usize,
    M: Motion = Full,
    const D: usize = 5,
    const E: usize = 0,
> {
    pub(crate) spindle: Spindle<'b, T, R, N, D, E>,
    pub(crate) last: WarmStart<T, R, N, D, E>,
    pub(crate) motion: PhantomData<M>,
}

/// Solver of a [`SprungSpindle`](crate::SprungSpindle), of which some rows sit in a sleeve that slides under a spring.
pub type SprungSolver<'b, T, const R: usize, const N: usize, M = Full> =
    SpindleSolver<'b, T, R, N, M, 6>;

/// Solver of an [`ElasticSpindle`](crate::ElasticSpindle), whose shaft bends.
pub type ElasticSolver<'b, T, const R: usize, const N: usize, M = Full, const D: usize = 5> =
    SpindleSolver<'b, T, R, N, M, D, R>;

impl<'b, T: Real, const R: usize, const N: usize, const D: usize, const E: usize>
    SpindleSolver<'b, T, R, N, Full, D, E>
{
    /// A solver for the spindle at speed, with all inertia loads and no race in control.
    pub const fn new(spindle: Spindle<'b, T, R, N, D, E>) -> Self {
        Self::of(spindle)
    }
}

impl<'b, T: Real, const R: usize, const N: usize, M: Motion, const D: usize, const E: usize>
    SpindleSolver<'b, T, R, N, M, D, E>
{
    /// A solver for the motion that its type names.
    pub const fn of(spindle: Spindle<'b, T, R, N, D, E>) -> Self {
        Self {
            spindle,
            last: WarmStart::COLD,
            motion: PhantomData,
        }
    }

    /// Has the next solve start from nothing.
    pub fn reset(&mut self) {
        self.last.reset();
    }

    /// The equilibrium under the load `[Fx, Fy, Fz, My, Mz]` (N, N m) on the shaft at `x = 0`, at a speed, without growth.
    ///
    /// The solve starts from the last solution if that is near. After [`Status::IterationLimit`] it goes on from where the
    /// last one ended, if load and speed are near.
    ///
    /// # Errors
    ///
    /// A [`Status`] that names why there is no answer. Balls are counted on from row to row.
    pub fn solve(
        &mut self,
        load: [T; 5],
        speed: Speed<T>,
        settings: &Settings<T>,
    ) -> Result<SpindleSolution<'_, T, R, N, M, D, E>, Status<T>> {
        self.solve_while(load, speed, &[Growth::NONE; R], settings, || true)
    }

    /// The equilibrium where the rings and balls of each row have grown.
    ///
    /// # Errors
    ///
    /// As for [`SpindleSolver::solve`].
    pub fn solve_at(
        &mut self,
        load: [T; 5],
        speed: Speed<T>,
        growth: &[Growth<T>; R],
        settings: &Settings<T>,
    ) -> Result<SpindleSolution<'_, T, R, N, M, D, E>, Status<T>> {
        self.solve_while(load, speed, growth, settings, || true)
    }

    /// [`SpindleSolver::solve_at`] for as long as there is `more_time`, as [`Solver::solve_while`](crate::Solver::solve_while).
    ///
    /// # Errors
    ///
    /// As for [`SpindleSolver::solve`].
    pub fn solve_while(
        &mut self,
        load: [T; 5],
        speed: Speed<T>,
        growth: &[Growth<T>; R],
        settings: &Settings<T>,
        mut more_time: impl FnMut() -> bool,
    ) -> Result<SpindleSolution<'_, T, R, N, M, D, E>, Status<T>> {
        let Spindle {
            layout,
            spring,
            centre,
            ..
        } = &self.spindle;
        // The sixth freedom is the sleeve's.
        let given = from_fn(|i| Given::Load(load.get(i).copied().unwrap_or(*spring)));
        let unit = layout.bearings[0].c;
        // From x = 0 to the centre.
        let to_centre = |load: &mut [T; D]| {
            refer(-*centre * unit.tilt / unit.length, load);
            self.spindle.add_constant(load);
        };
        let tolerance = settings.tolerance;
        let problem = self
            .last
            .problem::<M, _>(layout, &given, to_centre, speed, growth, tolerance)?;
        let most = settings.max_iterations;
        let reached = self
            .last
            .run::<M::Rule, _>(layout, &problem, most, &mut more_time)?;
        Ok(SpindleSolution::new(
            &self.spindle,
            &self.last,
            &reached,
            load,
        ))
    }

    /// The equilibrium where some displacements of the shaft at `x = 0` are given in the place of loads: locked tilts are
    /// displacements of 0. [`SpindleSolution::load`] has the reactions.
    ///
    /// ```
    /// use spindle_bearing::{Arrangement, Bearing, Design, Given, Growth, Preload, Settings, Speed, Spindle, SpindleSolver};
    ///
    /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// static BEARING: Bearing<f64, 15> = Bearing::<f64, 15>::const_new(&DESIGN);
    /// let spindle = Spindle::pair(Arrangement::BackToBack, &BEARING, 0.1, Preload::Force(240.0))?;
    /// let mut solver = SpindleSolver::new(spindle);
    /// // Pushed in by 5 um without tilt, under a radial load of 50 N.
    /// let given = [
    ///     Given::Displacement(5e-6),
    ///     Given::Load(50.0),
    ///     Given::Load(0.0),
    ///     Given::Displacement(0.0),
    ///     Given::Displacement(0.0),
    /// ];
    /// let speed = Speed::rpm(10_000.0);
    /// let solution = solver.solve_given(&given, speed, &[Growth::NONE; 2], &Settings::default())?;
    /// assert!(solution.load[0] > 100.0 && solution.displacement[4] == 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As for [`SpindleSolver::solve`].
    pub fn solve_given(
        &mut self,
        given: &[Given<T>; 5],
        speed: Speed<T>,
        growth: &[Growth<T>; R],
        settings: &Settings<T>,
    ) -> Result<SpindleSolution<'_, T, R, N, M, D, E>, Status<T>> {
        // An elastic shaft has an overhang in the place of a shift.
        let at = if E > 0 { self.spindle.centre } else { T::ZERO };
        let (layout, shift) = self.spindle.about(at);
        let overhang = self.spindle.overhang(given);
        let spring = Given::Load(self.spindle.spring);
        let all = from_fn(|i| given.get(i).copied().unwrap_or(spring));
        let to_centre = |load: &mut [T; D]| {
            if overhang.is_some() {
                refer(-at / radius(layout.bearings[0].c), load);
            }
            self.spindle.add_constant(load);
        };
        self.last.refer(shift);
        let tolerance = settings.tolerance;
        let problem = self
            .last
            .problem::<M, _>(&layout, &all, to_centre, speed, growth, tolerance);
        let most = settings.max_iterations;
        let solved = problem.and_then(|mut problem| {
            if let Some((piece, deflection)) = overhang {
                for (held, of_loads) in problem.prescribed.iter_mut().zip(deflection) {
                    *held = held.map(|u| u - of_loads);
                }
                problem.overhang = Some(piece);
            }
            self.last
                .run::<M::Rule, _>(&layout, &problem, most, &mut || true)
        });
        self.last.refer(-shift);
        let mut reached = solved?;
        let mut load = self.spindle.load_at_origin(&reached.load, at);
        load = vector(|i| given[i].load_or(load[i]));
        reached.u = moved(shift, &reached.u);
        let mut solution = SpindleSolution::new(&self.spindle, &self.last, &reached, load);
        for (u, given) in solution.displacement.iter_mut().zip(given) {
            *u = given.displacement_or(*u);
        }
        Ok(solution)
    }

    /// The state that a solve had reached when it ended as [`Status::IterationLimit`]: as
    /// [`Solver::unfinished`](crate::Solver::unfinished).
    pub fn unfinished(&self) -> Option<SpindleSolution<'_, T, R, N, M, D, E>> {
        let Spindle { layout, centre, .. } = &self.spindle;
        let reached = self.last.unfinished::<M::Rule, _>(layout)?;
        let load = self.spindle.load_at_origin(&reached.load, *centre);
        let solution = SpindleSolution::new(&self.spindle, &self.last, &reached, load);
        // A sleeve that no ball holds makes the shaft's stiffness 0 / 0.
        let is_finite = solution.k.iter().all(|row| are_finite(row));
        is_finite.then_some(solution)
    }
}
