//! The equilibrium under given loads, and the bearing's own law under given displacements.
//!
//! One damped Newton on the arrow-shaped system. Each sweep linearises every ball, which eliminates
//! its own unknowns, sums what the balls hand to the ring, and takes a step of the ring and with it
//! of every ball. The tangent of the last sweep *is* the stiffness.
//!
//! What keeps the steps in hand:
//!
//! - Contact forces lead geometry while they are far apart (see the `contact` module).
//! - The ring's step is bounded by the distance over which the grooves look straight to a contact:
//!   `|du|^2 / 2` may not exceed a few deformations. A longer step is shortened by adding to the
//!   tangent's diagonal (Levenberg 1944), which turns it towards the steepest descent and also
//!   gets over a singular tangent (few loaded balls). That costs a 5x5 solve, not a sweep.
//! - A ball that is badly off by itself (just off a race, or just caught by it) repeats its own
//!   Newton step a few times within the sweep.
//!
//! Starts are tried in order, within the caller's bound on sweeps: the last solution, moved by its
//! own stiffness to the new load, if that is near; the axisymmetric state; the same with more preload.
//! A start that has not led to a solution after some sweeps makes room for the next.
//!
//! With inertia and friction forces frozen, the equilibrium minimises a convex function of ring and
//! ball positions jointly (contact energies are convex and increasing functions of distances, and the
//! groove centres move affinely with the ring), so that there is one equilibrium and no trap on the
//! way to it; the speed-dependent part is a perturbation that the exact tangent takes in.

use crate::constants::{Azimuth, Bearing, Constants};
use crate::float::Real;
use crate::ring::{self, Definite, Factors, Five, Sums, Tangent, shift};
use crate::scene::{AtSpeed, Drive, Motion, Position, curvature_centre};
use crate::status::{Quantity, Status};

/// How hard to try.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings<T> {
    /// Most sweeps over the balls, at least 1.
    pub max_sweeps: u16,
    /// Largest last step, relative to the largest contact deformation, for a solve to count as
    /// converged. The displacements are then good to its square, the stiffness to its first power.
    pub tolerance: T,
}

impl<T: Real> Default for Settings<T> {
    /// 100 sweeps; a tolerance of 1e-5 in single and 1e-12 in double precision.
    fn default() -> Self {
        Self {
            max_sweeps: 100,
            tolerance: T::TOLERANCE,
        }
    }
}

/// State of one ball, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BallState<T> {
    /// Azimuth `phi`, rad from +y towards +z.
    pub azimuth: T,
    /// Inner contact angle, rad.
    pub alpha_i: T,
    /// Outer contact angle, rad.
    pub alpha_o: T,
    /// Inner contact force, N; 0 if the ball is off the inner race.
    pub q_i: T,
    /// Outer contact force, N.
    pub q_o: T,
    /// Deformation of the inner contact, m; negative where there is a gap.
    pub delta_i: T,
    /// Deformation of the outer contact, m.
    pub delta_o: T,
    /// Centrifugal force `Fc`, N.
    pub centrifugal_force: T,
    /// Gyroscopic moment `Mg`, N m.
    pub gyroscopic_moment: T,
}

/// An equilibrium, SI units; forces and displacements refer to the bearing centre.
#[derive(Debug)]
pub struct Solution<'s, T: Real, const N: usize, M: Motion> {
    /// How the solve ended: `Converged`, `PrecisionLimit` or `SweepLimit`.
    pub status: Status<T>,
    /// Sweeps over the balls.
    pub sweeps: u16,
    /// Ball passes beyond one a ball and sweep, for balls that were badly off by themselves.
    pub repeats: u16,
    /// Load less the balls' forces in the last sweep, relative to the load (moments over `Rp`).
    pub residual: T,
    /// Displacements `dx, dy, dz` (m), `ty, tz` (rad) of the inner ring.
    pub displacement: [T; 5],
    /// Forces `Fx, Fy, Fz` (N) and moments `My, Mz` (N m) that hold the balls' forces on the ring.
    pub load: [T; 5],
    /// Stiffness: derivative of the forces (rows) by the displacements (columns) at constant speed.
    /// Not symmetric at speed.
    pub stiffness: [[T; 5]; 5],
    solver: &'s Solver<'s, T, N, M>,
}

impl<T: Real, const N: usize, M: Motion> Solution<'_, T, N, M> {
    /// States of the balls, in the order of their azimuths.
    pub fn balls(&self) -> impl ExactSizeIterator<Item = BallState<T>> + '_ {
        let c = &self.solver.bearing.constants;
        let state = &self.solver.state;
        self.solver
            .balls
            .iter()
            .zip(&self.solver.bearing.azimuths)
            .map(move |(ball, at)| {
                let a = shift(&state.position.offset, at);
                let pass = M::observe(c, state.speed_load, ball, a);
                BallState {
                    azimuth: at.sin.atan2(at.cos),
                    alpha_i: pass.inner.sin.atan2(pass.inner.cos),
                    alpha_o: pass.outer.sin.atan2(pass.outer.cos),
                    q_i: pass.inner.q * c.force,
                    q_o: pass.outer.q * c.force,
                    delta_i: pass.inner.delta * c.length,
                    delta_o: pass.outer.delta * c.length,
                    centrifugal_force: pass.loads.centrifugal * c.force,
                    gyroscopic_moment: pass.loads.friction * c.force * c.ball_radius,
                }
            })
    }

    /// Forces on the inner race alone, N, in the order of the balls: what a monitor looks at, without
    /// the cost of contact angles.
    pub fn inner_forces(&self) -> impl ExactSizeIterator<Item = T> + '_ {
        let c = &self.solver.bearing.constants;
        let state = &self.solver.state;
        self.solver
            .balls
            .iter()
            .zip(&self.solver.bearing.azimuths)
            .map(move |(ball, at)| {
                let a = shift(&state.position.offset, at);
                M::observe(c, state.speed_load, ball, a).inner.q * c.force
            })
    }

    /// The displacement as a vector of `nalgebra`.
    #[cfg(feature = "nalgebra")]
    pub fn displacement_vector(&self) -> nalgebra::SVector<T, 5>
    where
        T: nalgebra::Scalar,
    {
        nalgebra::SVector::from(self.displacement)
    }

    /// The stiffness as a matrix of `nalgebra`.
    #[cfg(feature = "nalgebra")]
    pub fn stiffness_matrix(&self) -> nalgebra::SMatrix<T, 5, 5>
    where
        T: nalgebra::Scalar,
    {
        nalgebra::SMatrix::from_fn(|i, j| self.stiffness[i][j])
    }
}

#[cfg(feature = "defmt")]
impl<T: Real, const N: usize, M: Motion> defmt::Format for Solution<'_, T, N, M> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "{} after {} sweeps, residual {}; displacement {}, load {}, stiffness {}",
            self.status,
            self.sweeps,
            self.residual,
            self.displacement,
            self.load,
            self.stiffness
        );
    }
}

/// A solver for one bearing: borrows its constants and owns the state that warm-starts the next
/// solve.
///
/// ```
/// use spindle_bearing::{Bearing, Design, FreeContact, Material, Settings, Solver};
/// let design = Design {
///     ball_diameter: 6.35e-3, pitch_diameter: 36e-3,
///     inner_groove_factor: 0.515, outer_groove_factor: 0.525,
///     free_contact: FreeContact::Angle(15f64.to_radians()), first_ball: 0.0,
///     ring: Material::STEEL, ball: Material::STEEL,
/// };
/// let bearing = Bearing::<f32, 16>::new(&design)?;
/// let mut solver = Solver::<f32, 16>::new(&bearing);
/// let speed = 20_000.0 * core::f32::consts::PI / 30.0;
/// let solution = solver.solve([1000.0, 200.0, 0.0, 0.0, 3.0], speed, &Settings::default())?;
/// let [k_x, k_y, k_z] = core::array::from_fn(|i| solution.stiffness[i][i]);
/// assert!(k_y > k_z && k_z > k_x);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Solver<'b, T: Real, const N: usize, M: Motion = AtSpeed> {
    bearing: &'b Bearing<T, N>,
    state: State<T>,
    balls: [M::Ball<T>; N],
}

/// What is kept between solves besides the balls, in the units of the constants.
#[derive(Debug, Clone, Copy, PartialEq)]
struct State<T> {
    position: Position<T>,
    tangent: Tangent<T>,
    force: Five<T>,
    /// Mean radial force and moment of the balls.
    mean: [T; 2],
    speed_load: T,
    /// Load of the last solve; its norm is 0 as long as there is none to start from.
    load: Five<T>,
}

impl<T: Real> State<T> {
    const COLD: Self = Self {
        position: Position {
            reference: [T::ZERO; 5],
            offset: [T::ZERO; 5],
        },
        tangent: [[T::ZERO; 5]; 5],
        force: [T::ZERO; 5],
        mean: [T::ZERO; 2],
        speed_load: T::ZERO,
        load: [T::ZERO; 5],
    };
}

/// What is given: the load on the ring, or its displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Given<T> {
    Load(Five<T>),
    Displacement,
}

/// How sweeps ended.
struct Outcome<T> {
    status: Status<T>,
    sweeps: u16,
    repeats: u16,
    residual: T,
    /// Last sweeps in a row whose tangent left a direction undetermined.
    singular: u8,
}

impl<T: Real> Outcome<T> {
    fn new() -> Self {
        Self {
            status: Status::SweepLimit,
            sweeps: 0,
            repeats: 0,
            residual: T::ONE,
            singular: 0,
        }
    }
}

/// Where a solve starts, in the order in which starts are tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Attempt {
    /// From the last solution.
    Warm,
    /// From the axisymmetric state.
    Cold,
    /// From there with more preload.
    Preloaded,
}

impl Attempt {
    const ALL: [Self; 3] = [Self::Warm, Self::Cold, Self::Preloaded];

    /// Sweeps after which the next start is worth more than going on. From a start that is any good
    /// most solves take fewer than 10.
    const fn sweeps(self) -> u16 {
        match self {
            Self::Warm => 10,
            Self::Cold => 45,
            Self::Preloaded => u16::MAX,
        }
    }
}

fn norm<T: Real>(f: &Five<T>) -> T {
    let mut sum = T::ZERO;
    for x in f {
        sum += *x * *x;
    }
    sum.sqrt()
}

/// A bound on how far a displacement of the ring shifts any groove centre.
fn span<T: Real>(u: &Five<T>) -> T {
    let axial = u[0].abs() + (u[3] * u[3] + u[4] * u[4]).sqrt();
    let radial = (u[1] * u[1] + u[2] * u[2]).sqrt();
    axial.or_larger(radial)
}

/// One bearing's iteration: constants, azimuths, and the state it works on.
struct Iteration<'i, T: Real, M: Motion> {
    c: &'i Constants<T>,
    azimuths: &'i [Azimuth<T>],
    state: &'i mut State<T>,
    balls: &'i mut [M::Ball<T>],
}

/// What a sweep found over all balls.
#[derive(Default)]
struct Sweep<T> {
    lag: T,
    /// Largest unbalanced force of a ball, and largest force at all.
    unbalanced: T,
    largest: T,
    /// Largest deformation of an inner contact.
    depth: T,
    repeats: u16,
}

impl<T: Real, M: Motion> Iteration<'_, T, M> {
    /// Linearises all balls at the present position.
    fn sweep(&mut self, drive: &Drive<T>) -> Sweep<T> {
        // Beyond this imbalance a ball repeats its own step, a few times at most.
        let (bad, most) = (T::of(0.1), 3);
        let mut sums = Sums::about(self.state.mean);
        let mut total = Sweep::<T>::default();
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let a = shift(&self.state.position.offset, at);
            let mut repeats = 0;
            let (share, check) = loop {
                let (share, check) = M::linearise(self.c, drive, ball, a);
                if !(check.imbalance > bad) || repeats == most {
                    break (share, check);
                }
                M::follow(self.c, drive, ball, a, [T::ZERO; 2]);
                repeats += 1;
            };
            sums.add(at, &share);
            total.lag = total.lag.or_larger(check.lag);
            total.depth = total.depth.or_larger(check.delta);
            total.unbalanced = total.unbalanced.or_larger(check.unbalanced);
            total.largest = total.largest.or_larger(check.largest);
            total.repeats = total.repeats.saturating_add(repeats);
        }
        self.state.force = sums.force();
        self.state.mean = sums.mean(self.c.balls);
        self.state.tangent = sums.tangent();
        total
    }

    /// Moves the ring by `du` and every ball with it; returns the largest step of a ball.
    fn follow(&mut self, drive: &Drive<T>, du: &Five<T>) -> T {
        let mut largest = T::ZERO;
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let a = shift(&self.state.position.offset, at);
            let step = M::follow(self.c, drive, ball, a, shift(du, at));
            largest = largest.or_larger(step);
        }
        for (offset, step) in self.state.position.offset.iter_mut().zip(du) {
            *offset += *step;
        }
        largest
    }

    /// Moves all references next to the present position.
    fn rebase(&mut self) {
        self.state.position.rebase();
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let (coarse, fine) = curvature_centre(self.c, &self.state.position.reference, at);
            M::rebase(self.c, ball, coarse, fine);
        }
    }

    /// Puts the ring at `u`, and every ball where it belongs without further knowledge.
    fn place(&mut self, u: &Five<T>, speed_load: T) {
        self.state.position = Position {
            reference: [T::ZERO; 5],
            offset: *u,
        };
        for (ball, at) in self.balls.iter_mut().zip(self.azimuths) {
            let a = shift(u, at);
            *ball = M::Ball::<T>::default();
            let centre = [self.c.n0[0].high + a[0], self.c.n0[1].high + a[1]];
            M::place(self.c, speed_load, ball, centre);
        }
        self.rebase();
    }

    /// A start from nothing: the axisymmetric state under the axial load, plus so much preload that
    /// radial load and moment do not unload balls at first sight. From above, Newton on a 3/2 law
    /// does not overshoot. `preload` multiplies it.
    fn start(&mut self, load: &Five<T>, speed_load: T, preload: T) {
        let c = self.c;
        let radial = (load[1] * load[1] + load[2] * load[2]).sqrt();
        let tilting = (load[3] * load[3] + load[4] * load[4]).sqrt();
        let q = preload * (load[0].abs() + T::of(0.5) * radial + tilting) / c.balls;
        let sign = if load[0] < T::ZERO { -T::ONE } else { T::ONE };

        // At rest: w^3 A1 / (1 + w^2) = q with w^2 the deformation of both contacts, by Newton from
        // above, where the left side is convex.
        let s0 = c.n0[0].high;
        let axial = |w2: T| (s0 * s0 + w2 * (w2 + T::ONE + T::ONE)).sqrt();
        let mut w = T::ONE;
        for _ in 0..24 {
            let w2 = w * w;
            let (a1, h) = (axial(w2), T::ONE / (T::ONE + w2));
            let value = w2 * w * a1 * h - q;
            let slope = T::of(3.0) * w2 * a1 * h
                + (w2 * w2 + w2 * w2) * (T::ONE / (a1 * h).or_larger(T::TINY) - a1 * h) * h;
            let step = value / slope.or_larger(T::TINY);
            w = (w - step).or_larger(T::of(0.1) * w);
            if step.abs() <= T::of(0.01) * w {
                break;
            }
        }
        let x = sign * axial(w * w) - s0;

        // At speed: one ball stands for all.
        if M::AT_SPEED {
            let drive = Drive {
                speed_load,
                negligible: T::EPSILON * q * c.balls,
                catch: T::of(1e-3),
            };
            let mut position = Position::default();
            position.offset[0] = x;
            position.rebase();
            let top = Azimuth {
                cos: T::ONE,
                sin: T::ZERO,
                cos_low: T::ZERO,
                sin_low: T::ZERO,
            };
            let (coarse, fine) = curvature_centre(c, &position.reference, &top);
            let mut ball = M::Ball::<T>::default();
            let mut offset = position.offset[0];
            let centre = [coarse[0] + fine[0] + offset, coarse[1] + fine[1]];
            M::place(c, speed_load, &mut ball, centre);
            M::rebase(c, &mut ball, coarse, fine);
            for _ in 0..12 {
                let (share, check) = M::linearise(c, &drive, &mut ball, [offset, T::ZERO]);
                let step =
                    (sign * q - share.force[0]) / share.stiffness[0][0].or_larger(T::of(1e-6));
                let step = step.or_smaller(T::of(0.2)).or_larger(T::of(-0.2));
                M::follow(c, &drive, &mut ball, [offset, T::ZERO], [step, T::ZERO]);
                offset += step;
                self.state.mean = [share.force[1], share.force[0] - share.couple];
                if check.imbalance < T::of(0.05) && step.abs() < T::of(0.02) * w * w {
                    break;
                }
            }
            position.offset[0] = offset;
            self.state.position = position;
            for other in self.balls.iter_mut() {
                *other = ball;
            }
            self.rebase();
        } else {
            self.state.mean = [sign * q * c.n0[1].high / (s0 + x), sign * q];
            self.place(&[x, T::ZERO, T::ZERO, T::ZERO, T::ZERO], speed_load);
        }
    }

    /// Moves a solved bearing to where its stiffness sees it under a new load.
    fn predict(&mut self, load: &Five<T>, speed_load: T) {
        let mut change = *load;
        for (new, old) in change.iter_mut().zip(&self.state.load) {
            *new -= *old;
        }
        for ball in self.balls.iter_mut() {
            M::rest(ball);
        }
        let (du, _) = self.step(&change, T::of(0.1));
        let drive = Drive {
            speed_load,
            negligible: T::EPSILON * norm(load),
            catch: T::ZERO,
        };
        self.follow(&drive, &du);
    }

    /// The step of the ring under the unbalanced load `b`, no longer than `longest`; the second value
    /// tells whether the tangent left a direction undetermined.
    fn step(&self, b: &Five<T>, longest: T) -> (Five<T>, bool) {
        let mut damping = T::ZERO;
        let mut singular = false;
        let least = T::of(8.0) * T::EPSILON;
        let mut du = [T::ZERO; 5];
        // The damping grows to more than the step bound can need.
        for attempt in 0..14 {
            let mut tangent = self.state.tangent;
            for (i, row) in tangent.iter_mut().enumerate() {
                row[i] += damping;
            }
            let (factors, definite) = Factors::of(&tangent, least);
            singular |= attempt == 0 && definite == Definite::Semi;
            du = factors.solve(b);
            if definite == Definite::Positive && span(&du) <= longest {
                break;
            }
            damping = if attempt == 0 {
                T::of(1e-4) * norm(b) / longest
            } else {
                damping * T::of(4.0)
            };
        }
        (du, singular)
    }

    /// Sweeps until converged, or until there were `until` of them.
    fn run(
        &mut self,
        outcome: &mut Outcome<T>,
        given: &Given<T>,
        speed_load: T,
        tolerance: T,
        until: u16,
    ) {
        let size = match given {
            Given::Load(load) => norm(load),
            Given::Displacement => T::ZERO,
        };
        let share = (size / self.c.balls).cbrt();
        let first = outcome.sweeps;
        outcome.status = Status::SweepLimit;
        let mut depth = share * share;
        let mut last = T::ONE;
        let mut last_residual = T::ONE;
        let mut caution = T::ONE;
        loop {
            let drive = Drive {
                speed_load,
                negligible: T::EPSILON * size,
                catch: T::of(0.01) * depth,
            };
            let sweep = self.sweep(&drive);
            outcome.sweeps += 1;
            outcome.repeats = outcome.repeats.saturating_add(sweep.repeats);
            depth = sweep.depth.or_larger(T::ZERO);

            let (mut du, mut singular) = ([T::ZERO; 5], false);
            if let Given::Load(load) = given {
                let mut b = *load;
                for (unbalanced, force) in b.iter_mut().zip(&self.state.force) {
                    *unbalanced -= *force;
                }
                outcome.residual = norm(&b) / size;
                // Sets of loaded balls that follow one another in a circle are broken by shorter
                // steps.
                if outcome.sweeps - first > 10 {
                    if outcome.residual > last_residual {
                        caution = caution * T::of(0.5);
                    } else if outcome.residual < T::of(0.5) * last_residual {
                        caution = (caution + caution).or_smaller(T::ONE);
                    }
                }
                last_residual = outcome.residual;
                let straight = (T::of(10.0) * depth.or_larger(share * share)).sqrt();
                (du, singular) = self.step(&b, caution * straight.or_smaller(T::of(0.3)));
            } else {
                outcome.residual = T::ZERO;
            }
            outcome.singular = if singular {
                outcome.singular.saturating_add(1)
            } else {
                0
            };
            let moved = self.follow(&drive, &du);
            let change = span(&du).or_larger(sweep.lag);
            if !change.is_finite() || !moved.is_finite() || !outcome.residual.is_finite() {
                outcome.status = Status::Diverged {
                    residual: outcome.residual,
                };
                return;
            }
            let enough = tolerance * depth;
            // What rounding leaves of a ball's motion along its grooves has no consequence; of the
            // ring's motion, it ends the solve once it no longer shrinks.
            let floor = T::EPSILON * T::of(4.0);
            let settled =
                sweep.unbalanced <= T::of(1e-4) * sweep.largest && moved <= enough.or_larger(floor);
            let exhausted = change <= floor && change > T::of(0.25) * last;
            if settled && (change <= enough || exhausted) {
                outcome.status = if singular {
                    Status::Indeterminate {
                        loaded_balls: self.loaded_balls(speed_load),
                    }
                } else if change <= enough {
                    Status::Converged
                } else {
                    Status::PrecisionLimit
                };
                return;
            }
            if outcome.sweeps >= until {
                return;
            }
            last = change;
            // Offsets this large would cost digits of the deformations.
            let far = T::of(2e-3);
            if span(&self.state.position.offset) > far || moved > far {
                self.rebase();
            }
        }
    }

    fn loaded_balls(&self, speed_load: T) -> u16 {
        let mut count = 0;
        for (ball, at) in self.balls.iter().zip(self.azimuths) {
            let a = shift(&self.state.position.offset, at);
            let pass = M::observe(self.c, speed_load, ball, a);
            count += u16::from(pass.inner.q > T::ZERO);
        }
        count
    }
}

impl<'b, T: Real, const N: usize, M: Motion> Solver<'b, T, N, M> {
    /// A solver without history: its first solve starts from nothing.
    pub fn new(bearing: &'b Bearing<T, N>) -> Self {
        Self {
            bearing,
            state: State::COLD,
            balls: [M::Ball::<T>::default(); N],
        }
    }

    /// Forgets the last state, so that the next solve starts from nothing.
    pub fn forget(&mut self) {
        self.state = State::COLD;
    }

    /// Solves the equilibrium of the inner ring under the load `[Fx, Fy, Fz, My, Mz]` (N, N m) at
    /// the shaft speed `speed` (rad/s), starting from the last solution if that is near.
    ///
    /// The scene at rest ([`Static`](crate::Static)) takes no notice of the speed.
    ///
    /// # Errors
    ///
    /// A [`Status`] that names why there is no answer. Input that is refused leaves the solver as
    /// it was; a solve that failed makes the next one start from nothing.
    pub fn solve(
        &mut self,
        load: [T; 5],
        speed: T,
        settings: &Settings<T>,
    ) -> Result<Solution<'_, T, N, M>, Status<T>> {
        let c = &self.bearing.constants;
        // Beyond N times the force that would press a ball by the whole groove distance, nothing
        // in the model holds.
        let (force, moment) = (c.force * c.balls, c.moment * c.balls);
        check(
            &load,
            &Quantity::LOAD,
            [force, force, force, moment, moment],
        )?;
        let speed_load = self.speed_load(speed)?;
        let load = ring::load_in(c, &load);
        let size = norm(&load);
        // Squares of smaller numbers are lost.
        if !(size > T::TINY.sqrt()) {
            return Err(Status::Unloaded);
        }

        let warm = self.is_near(&load, speed_load);
        let given = Given::Load(load);
        let mut run = self.iteration();
        let mut outcome = Outcome::new();
        for attempt in Attempt::ALL {
            match attempt {
                Attempt::Warm if !warm => continue,
                Attempt::Warm => run.predict(&load, speed_load),
                Attempt::Cold => run.start(&load, speed_load, T::ONE),
                Attempt::Preloaded => run.start(&load, speed_load, T::of(4.0)),
            }
            let until = outcome.sweeps.saturating_add(attempt.sweeps());
            run.run(
                &mut outcome,
                &given,
                speed_load,
                settings.tolerance,
                until.min(settings.max_sweeps.max(1)),
            );
            let failed = matches!(outcome.status, Status::SweepLimit | Status::Diverged { .. });
            if !failed || outcome.sweeps >= settings.max_sweeps {
                break;
            }
        }
        self.conclude(outcome, load, speed_load)
    }

    /// The bearing's own law: forces of the balls on the inner ring, tangent, and states of the balls
    /// for the displacement `[dx, dy, dz, ty, tz]` (m, rad) of the ring at the shaft speed `speed`
    /// (rad/s). The solution's `load` is what holds them.
    ///
    /// # Errors
    ///
    /// As for [`Solver::solve`].
    pub fn law(
        &mut self,
        displacement: [T; 5],
        speed: T,
        settings: &Settings<T>,
    ) -> Result<Solution<'_, T, N, M>, Status<T>> {
        let c = &self.bearing.constants;
        let (length, tilt) = (c.length + c.length, c.tilt + c.tilt);
        check(
            &displacement,
            &Quantity::DISPLACEMENT,
            [length, length, length, tilt, tilt],
        )?;
        let speed_load = self.speed_load(speed)?;
        let u = ring::displacement_in(c, &displacement);
        let mut run = self.iteration();
        run.place(&u, speed_load);
        let mut outcome = Outcome::new();
        run.run(
            &mut outcome,
            &Given::Displacement,
            speed_load,
            settings.tolerance,
            settings.max_sweeps,
        );
        let force = self.state.force;
        self.conclude(outcome, force, speed_load)
    }

    /// Checks the speed and turns it into `m dm omega^2 / 2`.
    fn speed_load(&self, speed: T) -> Result<T, Status<T>> {
        let c = &self.bearing.constants;
        // Where a ball's centrifugal force would press it by the whole groove distance.
        let limit = (T::of(4.0) / c.centrifugal).sqrt();
        check(&[speed], &[Quantity::Speed], [limit])?;
        Ok(if M::AT_SPEED {
            c.centrifugal * speed * speed
        } else {
            T::ZERO
        })
    }

    /// Whether the last solution is a start worth having: load and speed not too far from its own.
    fn is_near(&self, load: &Five<T>, speed_load: T) -> bool {
        let last = &self.state;
        let mut change = *load;
        for (new, old) in change.iter_mut().zip(&last.load) {
            *new -= *old;
        }
        let half = T::of(0.5);
        let reference = norm(&last.load);
        norm(&change) <= half * reference
            && (speed_load - last.speed_load).abs() <= half * last.speed_load + half * reference
    }

    fn iteration(&mut self) -> Iteration<'_, T, M> {
        Iteration {
            c: &self.bearing.constants,
            azimuths: &self.bearing.azimuths,
            state: &mut self.state,
            balls: &mut self.balls,
        }
    }

    /// Keeps the state as the next solve's start, and makes the solution of it.
    fn conclude(
        &mut self,
        outcome: Outcome<T>,
        load: Five<T>,
        speed_load: T,
    ) -> Result<Solution<'_, T, N, M>, Status<T>> {
        self.state.speed_load = speed_load;
        self.state.load = load;
        match outcome.status {
            Status::Converged | Status::PrecisionLimit => {}
            // Not for want of sweeps.
            Status::SweepLimit if outcome.singular > 3 => {
                let loaded_balls = self.iteration().loaded_balls(speed_load);
                self.forget();
                return Err(Status::Indeterminate { loaded_balls });
            }
            Status::SweepLimit => self.state.load = [T::ZERO; 5],
            refusal => {
                self.forget();
                return Err(refusal);
            }
        }
        let c = &self.bearing.constants;
        let displacement = ring::displacement_out(c, &self.state.position.total());
        let load = ring::load_out(c, &self.state.force);
        let stiffness = ring::stiffness_out(c, &self.state.tangent);
        let finite = |values: &Five<T>| values.iter().all(|x| x.is_finite());
        if !(finite(&displacement) && finite(&load) && stiffness.iter().all(finite)) {
            self.forget();
            return Err(Status::Diverged {
                residual: outcome.residual,
            });
        }
        Ok(Solution {
            status: outcome.status,
            sweeps: outcome.sweeps,
            repeats: outcome.repeats,
            residual: outcome.residual,
            displacement,
            load,
            stiffness,
            solver: self,
        })
    }
}

/// Refuses the first value that is not finite, or larger in magnitude than its limit.
fn check<T: Real, const L: usize>(
    values: &[T; L],
    quantities: &[Quantity; L],
    limits: [T; L],
) -> Result<(), Status<T>> {
    for ((value, quantity), limit) in values.iter().zip(quantities).zip(limits) {
        let (value, quantity) = (*value, *quantity);
        if !value.is_finite() {
            return Err(Status::NotFinite { quantity, value });
        }
        if value.abs() > limit {
            return Err(Status::OutOfRange {
                quantity,
                value,
                limit,
            });
        }
    }
    Ok(())
}
