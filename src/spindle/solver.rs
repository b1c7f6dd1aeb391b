//! The equilibrium of a shaft in its bearings.

use crate::ball::kinematics::{Motion, RacewayControlFree};
use crate::linalg::{moved, norm, refer, vector};
use crate::real::Real;
use crate::solver::problem::{Given, Loading, OperatingPoint, Problem, Settings, radius};
use crate::solver::state::are_finite;
use crate::solver::warm_start::WarmStart;
use crate::spindle::Spindle;
use crate::spindle::solution::SpindleSolution;
use crate::status::Status;
use core::array::from_fn;
use core::marker::PhantomData;

/// A solver for one spindle: the memory of one solve for the next, and nothing else.
///
/// `M` is how the balls move, as for [`Solver`](crate::Solver). The other types are those of the [`Spindle`], which is handed to each
/// solve. A solver that has solved another spindle starts cold. Two solvers may share a spindle. In firmware, a solver lies in a
/// static, all of its bits zero.
#[derive(Debug, Clone)]
pub struct SpindleSolver<
    T: Real,
    const R: usize,
    const N: usize,
    M: Motion = RacewayControlFree,
    const D: usize = 5,
    const E: usize = 0,
> {
    pub(crate) last: WarmStart<T, R, N, D, E>,
    motion: PhantomData<M>,
}

impl<T: Real, const R: usize, const N: usize, const D: usize, const E: usize>
    SpindleSolver<T, R, N, RacewayControlFree, D, E>
{
    /// A solver for spindles at speed, with all inertia loads, raceway-control-free.
    pub const fn new() -> Self {
        Self::of()
    }
}

impl<T: Real, const R: usize, const N: usize, M: Motion, const D: usize, const E: usize> Default
    for SpindleSolver<T, R, N, M, D, E>
{
    /// [`SpindleSolver::of`].
    fn default() -> Self {
        Self::of()
    }
}

impl<T: Real, const R: usize, const N: usize, M: Motion, const D: usize, const E: usize>
    SpindleSolver<T, R, N, M, D, E>
{
    /// A solver for the motion that its type names.
    pub const fn of() -> Self {
        Self {
            last: WarmStart::COLD,
            motion: PhantomData,
        }
    }

    /// Has the next solve start from nothing.
    pub fn reset(&mut self) {
        self.last.reset();
    }

    /// The equilibrium at a speed, under loads or where some displacements are given in their place.
    ///
    /// `loads` are `[Fx, Fy, Fz, My, Mz]` (N, N m) on the shaft at `x = 0`, or a [`Given`] each, or
    /// [`ShaftLoad`](crate::ShaftLoad)s, each at its position. On an elastic shaft the place of a load counts: moved to `x = 0` by
    /// hand, it deflects the shaft otherwise. `at` is a [`Speed`](crate::Speed), or one with the growth of each row.
    ///
    /// The solve starts from the last solution if that is near. After [`Status::IterationLimit`] it goes on from where the
    /// last one ended, if load and speed are near. [`SpindleSolution::load`] has reactions where displacements are given.
    ///
    /// ```
    /// use spindle_bearing::{Arrangement, Bearing, Design, Given, Preload, Settings, ShaftLoad, Speed, Spindle, SpindleSolver};
    ///
    /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// static BEARING: Bearing<f64, 15> = Bearing::<f64, 15>::const_new(&DESIGN);
    /// let spindle = Spindle::pair(Arrangement::BackToBack, &BEARING, 0.1, Preload::Force(240.0))?;
    /// let (mut solver, speed, settings) = (SpindleSolver::new(), Speed::rpm(10_000.0), Settings::default());
    /// // Pushed in by 5 um without tilt, under a radial load of 50 N.
    /// let given = [
    ///     Given::Displacement(5e-6),
    ///     Given::Load(50.0),
    ///     Given::Load(0.0),
    ///     Given::Displacement(0.0),
    ///     Given::Displacement(0.0),
    /// ];
    /// let solution = solver.solve(&spindle, given, speed, &settings)?;
    /// assert!(solution.load[0] > 100.0 && solution.displacement[4] == 0.0);
    /// // Cut 60 mm in front, and a pulley behind.
    /// let loads = [
    ///     ShaftLoad { position: -0.06, load: [0.0, 120.0, 0.0, 0.0, 0.0] },
    ///     ShaftLoad { position: 0.15, load: [0.0, 0.0, -80.0, 0.0, 0.0] },
    /// ];
    /// let solution = solver.solve(&spindle, &loads, speed, &settings)?;
    /// assert!((solution.load[4] + 0.06 * 120.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// A [`Status`] that names why there is no answer. Balls are counted on from row to row.
    pub fn solve<'s>(
        &'s mut self,
        spindle: &'s Spindle<'_, T, R, N, D, E>,
        loads: impl Loading<'s, T, 5>,
        at: impl Into<OperatingPoint<T, R>>,
        settings: &Settings<T>,
    ) -> Result<SpindleSolution<'s, T, R, N, M, D, E>, Status<T>> {
        self.solve_while(spindle, loads, at, settings, || true)
    }

    /// [`SpindleSolver::solve`] for as long as there is `more_time`, as [`Solver::solve_while`](crate::Solver::solve_while).
    ///
    /// # Errors
    ///
    /// As for [`SpindleSolver::solve`].
    pub fn solve_while<'s, L: Loading<'s, T, 5>>(
        &'s mut self,
        spindle: &'s Spindle<'_, T, R, N, D, E>,
        loads: L,
        at: impl Into<OperatingPoint<T, R>>,
        settings: &Settings<T>,
        mut more_time: impl FnMut() -> bool,
    ) -> Result<SpindleSolution<'s, T, R, N, M, D, E>, Status<T>> {
        let (given, placed, at, more) = (loads.given(), loads.placed(), at.into(), &mut more_time);
        if L::GIVEN {
            return self.under_given(spindle, &given, &at, settings, more);
        }
        for load in placed {
            spindle.check_load(load)?;
        }
        let deflected;
        let (layout, fingerprint) = if spindle.layout.bends() && !placed.is_empty() {
            deflected = spindle.under_loads(placed);
            (&deflected.0, deflected.1)
        } else {
            (&spindle.layout, 0)
        };
        // The sixth freedom is the sleeve's.
        let spring = Given::Load(spindle.spring);
        let all = from_fn(|i| given.get(i).copied().unwrap_or(spring));
        let unit = layout.rows[0].bearing.c;
        let mut problem = Problem::given(layout, &all, settings.tolerance)?;
        problem.placed = fingerprint;
        // From x = 0 to the centre.
        refer(-spindle.centre * unit.tilt / unit.length, &mut problem.load);
        spindle.add_constant(&mut problem.load, spindle.centre);
        self.last.prepare::<M, _>(layout, &mut problem, &at)?;
        let most = settings.max_iterations;
        let reached = self.last.run::<M::Rule, _>(layout, &problem, most, more)?;
        let load = given.map(|given| given.load_or(T::ZERO));
        Ok(SpindleSolution::new(
            spindle, &self.last, &reached, load, placed,
        ))
    }

    /// The equilibrium where some displacements at `x = 0` are given.
    fn under_given<'s>(
        &'s mut self,
        spindle: &'s Spindle<'_, T, R, N, D, E>,
        given: &[Given<T>; 5],
        at: &OperatingPoint<T, R>,
        settings: &Settings<T>,
        more: &mut dyn FnMut() -> bool,
    ) -> Result<SpindleSolution<'s, T, R, N, M, D, E>, Status<T>> {
        // An elastic shaft has an overhang in the place of a shift.
        let bends = spindle.layout.bends();
        let point = if bends { spindle.centre } else { T::ZERO };
        let (layout, shift) = spindle.about(point);
        let overhang = spindle.overhang(given);
        let spring = Given::Load(spindle.spring);
        let all = from_fn(|i| given.get(i).copied().unwrap_or(spring));
        let mut problem = Problem::given(&layout, &all, settings.tolerance)?;
        if let Some((piece, deflection)) = overhang {
            refer(-point / radius(layout.rows[0].bearing.c), &mut problem.load);
            for (held, of_loads) in problem.prescribed.iter_mut().zip(deflection) {
                *held = held.map(|u| u - of_loads);
            }
            problem.overhang = Some(piece);
        }
        spindle.add_constant(&mut problem.load, point);
        self.last.prepare::<M, _>(&layout, &mut problem, at)?;
        let most = settings.max_iterations;
        self.last.refer(shift);
        let solved = self.last.run::<M::Rule, _>(&layout, &problem, most, more);
        self.last.refer(-shift);
        let mut reached = solved?;
        let mut load = spindle.load_at_origin(&reached.load, point);
        load = vector(|i| given[i].load_or(load[i]));
        reached.u = moved(shift, &reached.u);
        let mut solution = SpindleSolution::new(spindle, &self.last, &reached, load, &[]);
        for (u, given) in solution.displacement.iter_mut().zip(given) {
            *u = given.displacement_or(*u);
        }
        Ok(solution)
    }

    /// The last solve's answer once more, under the `loads` of that solve: for figures that are taken one after another, with
    /// other work between them.
    ///
    /// Its iterations are those of all calls that led to it. None without an answer, of another spindle, or where displacements are given.
    ///
    /// ```
    /// use spindle_bearing::{Arrangement, Bearing, Design, Preload, Settings, Speed, Spindle, SpindleSolver};
    ///
    /// let design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// let bearing = Bearing::<f64, 15>::new(&design)?;
    /// let spindle = Spindle::pair(Arrangement::BackToBack, &bearing, 0.1, Preload::Force(240.0))?;
    /// let (mut solver, speed) = (SpindleSolver::new(), Speed::rpm(10_000.0));
    /// let load = [50.0, 0.0, 0.0, 0.0, 0.0];
    /// let k = solver.solve(&spindle, load, speed, &Settings::default())?.stiffness();
    /// let again = solver.solved(&spindle, load).ok_or("no answer")?;
    /// assert_eq!(again.stiffness(), k);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn solved<'s, L: Loading<'s, T, 5>>(
        &'s self,
        spindle: &'s Spindle<'_, T, R, N, D, E>,
        loads: L,
    ) -> Option<SpindleSolution<'s, T, R, N, M, D, E>> {
        let (last, layout) = (&self.last, &spindle.layout);
        let attempt = &last.state.attempt;
        let is_solved = attempt.termination.is_solved() && last.fingerprint == layout.fingerprint;
        (is_solved && !L::GIVEN).then(|| {
            let reached = last.reached(layout, attempt.taken);
            let load = loads.given().map(|given| given.load_or(T::ZERO));
            SpindleSolution::new(spindle, last, &reached, load, loads.placed())
        })
    }

    /// The state that a solve had reached when it ended as [`Status::IterationLimit`]: as
    /// [`Solver::unfinished`](crate::Solver::unfinished).
    ///
    /// Of an elastic shaft, displacements are not known where the loads had positions: their stated error is 1 then.
    pub fn unfinished<'s>(
        &'s self,
        spindle: &'s Spindle<'_, T, R, N, D, E>,
    ) -> Option<SpindleSolution<'s, T, R, N, M, D, E>> {
        let Spindle { layout, centre, .. } = spindle;
        let reached = self.last.unfinished::<M::Rule, _>(layout)?;
        let load = spindle.load_at_origin(&reached.load, *centre);
        let mut solution = SpindleSolution::new(spindle, &self.last, &reached, load, &[]);
        if self.last.state.placed != 0 {
            (solution.error.displacement, solution.off) = (T::ONE, norm(&reached.u));
        }
        if solution.error.stiffness >= T::ONE {
            solution.error.displacement = solution.error.displacement.at_least(T::ONE);
        }
        // A sleeve that no ball holds makes the shaft's stiffness 0 / 0.
        let is_finite = solution.stiffness().iter().all(|row| are_finite(row));
        is_finite.then_some(solution)
    }
}
