//! Reference build: the full `4 N + 5` equations of a ball bearing at speed, written the textbook way.
//!
//! Unknowns are the five ring displacements and, per ball, both contact angles and both contact
//! deformations. Every formula is written once, generic over the number type: f64 for values, dual
//! numbers for the exact Jacobian, double-double for the residual. Newton runs in two stages. The
//! first, in f64 and damped, steps the ball centres so that geometry always closes. The second
//! refines all `4 N + 5` unknowns, held as double-double, until the residual vanishes to about 20
//! digits. A deformation is a difference of lengths, and 1e-3 to 1e-7 of them: f64 alone would lose
//! that many digits.
//!
//! Physics: Jones (1960) and Harris, "Rolling Bearing Analysis"; the raceway-control-free attitude by
//! Ding (2001) and Wang et al., Mech. Mach. Theory 82 (2014).
//! It is slow, allocates, and is meant for judging other solvers.

mod ball;
mod branch;
mod hertz;
mod linear;
mod newton;
mod number;
pub mod spindle;

use super::double_double::Dd;
use crate::compare::Equilibrium;
use ball::{Station, Terms, Unknowns};
use core::array::from_fn;
use core::f64::consts::{PI, TAU};
use core::fmt;
use hertz::Hertz;
pub(crate) use linear::small_solve;
use newton::Stage;
pub use newton::Task;
use number::Scalar;
use solvers::dispatch::Attitude;
use spindle_bearing::{BallState, Design, FreeContact, Material};

/// How a solve ended without a solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Failure {
    /// An input is not finite or out of range; says which.
    Input(&'static str),
    /// No equilibrium was found for this ball.
    Ball {
        /// Index of the ball.
        index: usize,
    },
    /// A Newton matrix could not be inverted.
    Singular,
    /// Newton stopped short.
    Stalled,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::Input(what) => write!(f, "invalid input: {what}"),
            Failure::Ball { index } => write!(f, "no equilibrium found for ball {index}"),
            Failure::Singular => write!(f, "singular Newton matrix"),
            Failure::Stalled => write!(f, "Newton stopped short"),
        }
    }
}

impl core::error::Error for Failure {}

/// A bearing prepared for solving: Hertz constants, lengths, ball places.
#[derive(Debug, Clone)]
pub struct Reference {
    inner: Hertz,
    outer: Hertz,
    /// Distances of the groove curvature centres from the ball centre, unloaded.
    li: Dd,
    lo: Dd,
    /// Inner curvature centre from the outer one, unloaded.
    a0: [Dd; 2],
    tau: Dd,
    diameter: Dd,
    pitch: Dd,
    inner_groove: Dd,
    mass: Dd,
    inertia: Dd,
    stations: Vec<Station>,
}

/// A ball with these unknowns and these inner and outer contact forces, centrifugal force and gyroscopic moment.
fn ball_state(station: &Station, w: Unknowns<f64>, [q_i, q_o, fc, mg]: [f64; 4]) -> BallState<f64> {
    // Not made at once: states of the library may grow.
    let mut ball = BallState::default();
    ball.azimuth = station.azimuth;
    [ball.alpha_i, ball.alpha_o, ball.delta_i, ball.delta_o] = w;
    (ball.q_i, ball.q_o) = (q_i, q_o);
    (ball.centrifugal_force, ball.gyroscopic_moment) = (fc, mg);
    ball
}

impl Reference {
    /// Prepares a bearing that the library can build, with so many balls.
    ///
    /// # Errors
    /// [`Failure::Input`] for a groove that is no wider than the ball.
    pub fn new(b: &Design, balls: usize) -> Result<Reference, Failure> {
        let one = Dd::ONE;
        let (two, half) = (Dd::of(2.0), Dd::of(0.5));
        let d = Dd::of(b.ball_diameter);
        let dm = Dd::of(b.pitch_diameter);
        let (fi, fo) = (Dd::of(b.inner_groove_factor), Dd::of(b.outer_groove_factor));
        let ((s, c), clearance) = match b.free_contact {
            FreeContact::Angle(angle) => (angle.sin_cos(), None),
            // Displacement counts from the middle of the play. The free angle only sets curvatures and radii.
            FreeContact::DiametralClearance(clearance) => {
                let versine = clearance.max(0.0) / (2.0 * b.centre_distance());
                let sine = (versine * (2.0 - versine)).sqrt();
                ((sine, 1.0 - versine), Some(clearance))
            }
        };
        let (c, s) = (Dd::of(c), Dd::of(s));
        let norm = (c * c + s * s).sqrt();
        let (c, s) = (c / norm, s / norm);
        let (li, lo) = ((fi - half) * d, (fo - half) * d);
        let l0 = li + lo;

        let soft = |m: &Material| {
            let nu = Dd::of(m.poissons_ratio);
            (one - nu * nu) / Dd::of(m.youngs_modulus)
        };
        let compliance = soft(&b.ball) + soft(&b.ring);
        let gamma = d * c / dm;
        let rx_i = two / d + two * gamma / (d * (one - gamma));
        let rx_o = two / d - two * gamma / (d * (one + gamma));
        let contact = |rx: Dd, f: Dd| {
            Hertz::new(rx, two / d - one / (f * d), compliance)
                .ok_or(Failure::Input("groove factor"))
        };

        let mass = Dd::of(b.ball.density) * Dd::PI * d * d * d / Dd::of(6.0);
        let (a0, zp) = match clearance {
            None => ([l0 * s, l0 * c], (li * s).value()),
            Some(clearance) => ([Dd::ZERO, l0 - half * Dd::of(clearance)], 0.0),
        };
        let rp = (dm * half + li * c).value();
        let stations = (0..balls)
            .map(|j| {
                let turn = two * Dd::PI * Dd::of(j as f64) / Dd::of(balls as f64);
                // The double-double series wants |x| <= pi, hence the half turn and the remainder.
                let first = b.first_ball.rem_euclid(TAU);
                let (sf, cf) = if b.first_ball.abs() <= 3.0 {
                    Dd::of(b.first_ball).sin_cos()
                } else {
                    (Dd::of(first) - Dd::PI).sin_cos()
                };
                let sign = Dd::of(if b.first_ball.abs() <= 3.0 { -1.0 } else { 1.0 });
                let (st, ct) = (turn - Dd::PI).sin_cos();
                let (sn, cs) = (sign * (sf * ct + cf * st), sign * (cf * ct - sf * st));
                let (sn, cs) = (sn.value(), cs.value());
                Station {
                    azimuth: (Dd::of(b.first_ball) + turn).value(),
                    lever: [
                        [1.0, 0.0, 0.0, rp * sn, -rp * cs],
                        [0.0, cs, sn, -zp * sn, zp * cs],
                        [0.0, 0.0, 0.0, -sn, cs],
                    ],
                }
            })
            .collect();
        Ok(Reference {
            inner: contact(rx_i, fi)?,
            outer: contact(rx_o, fo)?,
            li,
            lo,
            a0,
            tau: d / dm,
            diameter: d,
            pitch: dm,
            inner_groove: fi * d,
            mass,
            inertia: mass * d * d / Dd::of(10.0),
            stations,
        })
    }

    /// The bearing as a program sees it that gives the gyroscopic moment the wrong sign; for showing
    /// the effect. `Mg` of its balls is negative.
    #[must_use]
    pub fn with_gyroscopic_moment_reversed(mut self) -> Reference {
        self.inertia = -self.inertia;
        self
    }

    /// The bearing under centrifugal force alone: no gyroscopic moment, hence no friction.
    #[must_use]
    pub fn without_gyroscopic_moment(mut self) -> Reference {
        self.inertia = Dd::ZERO;
        self
    }

    /// The bearing as a program sees it that leaves the friction moment `mt` out of the ring's balance;
    /// for showing the effect.
    #[must_use]
    pub fn without_friction_moment(mut self) -> Reference {
        self.inner_groove = Dd::ZERO;
        self
    }

    /// The bearing as a program sees it that takes its contact constants from the fits of Brewe and
    /// Hamrock (1977); for showing their effect.
    #[must_use]
    pub fn with_fitted_contacts(mut self) -> Reference {
        self.inner = self.inner.fitted();
        self.outer = self.outer.fitted();
        self
    }

    /// Number of balls.
    pub fn balls(&self) -> usize {
        self.stations.len()
    }

    /// Inner and outer Hertz constants in N/m^1.5.
    pub fn hertz_constants(&self) -> (f64, f64) {
        (self.inner.k.value(), self.outer.k.value())
    }

    /// Position in m (axial, radial) of ball `j`'s inner curvature centre, from the outer one.
    pub(crate) fn inner_centre<T: Scalar>(&self, j: usize, u: &[T; 5]) -> [T; 2] {
        from_fn(|i| {
            let row = &self.stations[j].lever[i];
            let mut a = T::of(Dd::ZERO);
            for (l, u) in row.iter().zip(u) {
                if *l != 0.0 {
                    a = a + T::of(Dd::of(*l)) * *u;
                }
            }
            T::of(self.a0[i]) + a
        })
    }

    /// Half the pitch diameter in m, the length that makes tilts comparable.
    pub(crate) fn pitch_radius(&self) -> f64 {
        0.5 * self.pitch.hi
    }

    /// An axial force at least `factor` times the radial load and tilting moments.
    fn preload(&self, load: &[f64; 5], factor: f64) -> f64 {
        let [fx, fy, fz, my, mz] = *load;
        let least = 1e-9 * self.inner.k.hi * self.li.hi.powf(1.5);
        let other = fy.hypot(fz) + my.hypot(mz) / self.pitch_radius();
        fx.max(factor * other).max(least)
    }

    fn report(&self, ws: &[Unknowns<Dd>], terms: &[Terms<Dd>]) -> Vec<BallState<f64>> {
        let row = |((w, t), st): ((&Unknowns<Dd>, &Terms<Dd>), &Station)| {
            let terms = [t.q[0], t.q[1], t.fc, t.mg].map(Dd::value);
            ball_state(st, w.map(Dd::value), terms)
        };
        ws.iter().zip(terms).zip(&self.stations).map(row).collect()
    }

    /// The balls' centres, axial and radial from the outer groove's centre, m.
    pub fn centres(&self, balls: &[BallState<f64>]) -> Vec<[f64; 2]> {
        let centre = |ball: &BallState<f64>| {
            let (sin, cos) = ball.alpha_o.sin_cos();
            [sin, cos].map(|part| (self.lo.hi + ball.delta_o) * part)
        };
        balls.iter().map(centre).collect()
    }

    /// Whether these are balls of the bearing and not just of its equations. Newton may run away to contacts that are wound
    /// round the ball or deeper than the grooves' centres are apart.
    pub fn are_physical(&self, balls: &[BallState<f64>]) -> bool {
        let deepest = (self.li + self.lo).hi;
        balls.iter().all(|ball| {
            let steepest = ball.alpha_i.abs().max(ball.alpha_o.abs());
            steepest <= PI && ball.delta_i.max(ball.delta_o) <= deepest
        })
    }

    /// Equilibrium from a cold start, by one method after another.
    ///
    /// # Errors
    /// See [`Failure`].
    pub fn solve(&self, task: &Task) -> Result<Equilibrium, Failure> {
        task.check()?;
        let finish = |mut s: Stage| {
            self.newton(&mut s, task, 60)?;
            self.refine(&s, task)
        };
        let mut outcome = Err(Failure::Singular);
        // Plain Newton from a preload that keeps every ball loaded, then with balls in equilibrium
        // throughout, then along the load, then along the speed. Each goes from milder to heavier preload.
        for method in 0..4 {
            for factor in [1.0, 4.0] {
                let preload = self.preload(&task.load, factor);
                let start = Task {
                    load: [preload, 0.0, 0.0, 0.0, 0.0],
                    omega: if method == 3 { 0.0 } else { task.omega },
                    ..*task
                };
                let Ok(mut s) = self.preloaded(preload, &start) else {
                    continue;
                };
                s.u = from_fn(|k| task.held[k].unwrap_or(s.u[k]));
                outcome = match method {
                    0 => Ok(()),
                    1 => self.nested(&mut s, task, 60),
                    2 => self.follow(&mut s, &start, task),
                    _ => {
                        let rest = Task {
                            omega: 0.0,
                            ..*task
                        };
                        self.follow(&mut s, &start, &rest)
                            .and_then(|()| self.follow(&mut s, &rest, task))
                    }
                }
                .and_then(|()| finish(s));
                if outcome.is_ok() {
                    return outcome;
                }
            }
        }
        outcome
    }

    /// Newton from the answer of another program, without continuation: the fast way to judge it. `centres` are those of
    /// [`Self::centres`]. A freedom that is held keeps its displacement of `u`.
    ///
    /// # Errors
    /// See [`Failure`].
    pub fn polish(
        &self,
        task: &Task,
        u: [f64; 5],
        centres: &[[f64; 2]],
    ) -> Result<Equilibrium, Failure> {
        let start = self.stage(task, u, centres)?;
        let mut s = start.clone();
        self.newton(&mut s, task, 40)
            .and_then(|()| self.refine(&s, task))
            .or_else(|_| {
                // The centres did not belong to the displacements; give every ball its place first.
                let mut s = start;
                self.nested(&mut s, task, 40)?;
                self.newton(&mut s, task, 40)?;
                self.refine(&s, task)
            })
    }

    /// Like [`Self::polish`], but gives up unless the start is near an equilibrium.
    ///
    /// # Errors
    /// See [`Failure`].
    pub fn polish_near(
        &self,
        task: &Task,
        u: [f64; 5],
        centres: &[[f64; 2]],
    ) -> Result<Equilibrium, Failure> {
        let mut s = self.stage(task, u, centres)?;
        self.newton(&mut s, task, 12)?;
        self.refine(&s, task)
    }

    /// A start from displacements and ball centres of another program.
    fn stage(&self, task: &Task, u: [f64; 5], centres: &[[f64; 2]]) -> Result<Stage, Failure> {
        task.check()?;
        Task::new(u, 0.0, task.attitude).check()?;
        if centres.len() != self.stations.len() {
            return Err(Failure::Input("number of ball centres"));
        }
        let x = centres.to_vec();
        Ok(Stage { u, x })
    }

    /// Like [`Self::law`], in f64 throughout and without the stiffness: the force on the ring and the
    /// inner deformation of every ball, good for constructing cases. `centres` of balls, if there are
    /// as many as balls, are where it starts, and become those it finds.
    ///
    /// # Errors
    /// [`Failure::Ball`] if a ball finds no equilibrium.
    pub fn rough_law(
        &self,
        u: [f64; 5],
        omega: f64,
        attitude: Attitude,
        centres: &mut Vec<[f64; 2]>,
    ) -> Result<([f64; 5], Vec<f64>), Failure> {
        Task::new(u, omega, attitude).check()?;
        let known = centres.len() == self.stations.len();
        let mut found = Vec::with_capacity(self.stations.len());
        let mut depths = Vec::with_capacity(self.stations.len());
        let mut force = [0.0; 5];
        for (index, station) in self.stations.iter().enumerate() {
            let centre = self.inner_centre(index, &u);
            let guess = known.then(|| centres[index]);
            let x = self
                .ball_at(&centre, omega, attitude, guess)
                .ok_or(Failure::Ball { index })?;
            let w = self.unknowns(&x, &centre);
            let terms = self.evaluate(&w, &centre, omega, attitude);
            station.collect(&terms.ring, &mut force);
            found.push(x);
            depths.push(w[2]);
        }
        *centres = found;
        Ok((force, depths))
    }

    /// Inner deformation of ball `index` alone at the displacements `u`, in f64.
    ///
    /// # Errors
    /// [`Failure::Ball`] if it finds no equilibrium.
    pub fn depth(
        &self,
        index: usize,
        u: [f64; 5],
        omega: f64,
        attitude: Attitude,
    ) -> Result<f64, Failure> {
        Task::new(u, omega, attitude).check()?;
        let centre = self.inner_centre(index, &u);
        let x = self
            .ball_at(&centre, omega, attitude, None)
            .ok_or(Failure::Ball { index })?;
        Ok(self.unknowns(&x, &centre)[2])
    }

    /// The load on the inner ring, N and N m, that holds it at the displacements `u`.
    ///
    /// # Errors
    /// [`Failure::Ball`] if a ball finds no equilibrium.
    pub fn law(&self, u: [f64; 5], omega: f64, attitude: Attitude) -> Result<[f64; 5], Failure> {
        Task::new(u, omega, attitude).check()?;
        let task = Task::new([0.0; 5], omega, attitude).holding(u.map(Some));
        let mut s = Stage {
            u,
            x: vec![[0.0, 0.0]; self.stations.len()],
        };
        self.place(&u, &task, &mut s.x, false)?;
        let sol = self.refine(&s, &task)?;
        let mut force = [0.0; 5];
        for (b, st) in sol.balls.iter().zip(&self.stations) {
            let w = [b.alpha_i, b.alpha_o, b.delta_i, b.delta_o];
            let t = self.evaluate(&w, &[0.0; 2], omega, attitude);
            st.collect(&t.ring, &mut force);
        }
        Ok(force)
    }
}
