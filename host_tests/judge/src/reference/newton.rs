//! The whole system: from a start to the equilibrium in two stages.

use super::ball::{Linear, Unknowns};
use super::linear::masked_solve;
use super::spindle::Solver;
use super::{Failure, Reference};
use crate::compare::Equilibrium;
use crate::double_double::Dd;
use core::array::from_fn;
use solvers::dispatch::Attitude;

/// State of the whole system in the f64 stage.
#[derive(Clone)]
pub(super) struct Stage {
    pub(super) u: [f64; 5],
    /// Ball centres from the outer curvature centre, axial and radial.
    pub(super) x: Vec<[f64; 2]>,
}

/// Loads, or displacements in their place, speed and rule of attitude.
#[derive(Debug, Clone, Copy)]
pub struct Task {
    pub(super) load: [f64; 5],
    pub(super) held: [Option<f64>; 5],
    pub(super) omega: f64,
    pub(super) attitude: Attitude,
}

impl Task {
    /// `Fx, Fy, Fz, My, Mz`, N and N m, at a speed, rad/s.
    pub fn new(load: [f64; 5], omega: f64, attitude: Attitude) -> Self {
        Self {
            load,
            held: [None; 5],
            omega,
            attitude,
        }
    }

    /// Displacements, m and rad, in the place of these loads. The stiffness is still of all five freedoms.
    #[must_use]
    pub fn holding(self, held: [Option<f64>; 5]) -> Self {
        let load = from_fn(|k| held[k].map_or(self.load[k], |_| 0.0));
        Self { load, held, ..self }
    }

    pub(super) fn check(&self) -> Result<(), Failure> {
        let held = self.held.iter().flatten();
        let mut numbers = self.load.iter().chain(held).chain([&self.omega]);
        let finite = numbers.all(|x| x.is_finite());
        finite.then_some(()).ok_or(Failure::Input("not finite"))
    }

    pub(super) fn is_free(&self, freedom: usize) -> bool {
        self.held[freedom].is_none()
    }
}

/// Newton direction of the whole system.
struct Direction {
    du: [f64; 5],
    dw: Vec<[f64; 4]>,
}

impl Reference {
    /// Places all balls for given displacements.
    pub(super) fn place(
        &self,
        u: &[f64; 5],
        task: &Task,
        x: &mut [[f64; 2]],
        warm: bool,
    ) -> Result<(), Failure> {
        for (j, x) in x.iter_mut().enumerate() {
            let centre = self.inner_centre(j, u);
            *x = self
                .ball_at(&centre, task.omega, task.attitude, warm.then_some(*x))
                .ok_or(Failure::Ball { index: j })?;
        }
        Ok(())
    }

    /// Newton direction for residuals `ball[j]` (4 each) and `ring` (target minus force), by
    /// eliminating the balls one by one.
    fn direction(
        &self,
        lin: &[Linear],
        ball: &[[f64; 4]],
        ring: &[f64; 5],
        task: &Task,
        damping: f64,
    ) -> Option<Direction> {
        let lever = self.pitch_radius();
        let unit = [1.0, 1.0, 1.0, lever, lever];
        let mut k = [[0.0; 5]; 5];
        let mut rhs = *ring;
        let mut parts = Vec::with_capacity(lin.len());
        for ((lin, r), st) in lin.iter().zip(ball).zip(&self.stations) {
            let (p, g) = lin.solve(*r)?;
            lin.add_stiffness(&mut k, &g, st);
            let mut lost = [0.0; 5];
            st.collect(&lin.ring_change(&p), &mut lost);
            for (r, l) in rhs.iter_mut().zip(lost) {
                *r -= l;
            }
            parts.push((p, g));
        }
        if damping > 0.0 {
            let stiff = (0..3).fold(0.0_f64, |s, i| s.max(k[i][i].abs()));
            for i in 0..5 {
                k[i][i] += damping * stiff * unit[i] * unit[i];
            }
        }
        let du = masked_solve(&k, &rhs, &from_fn(|k| task.is_free(k)), &unit)?;
        let dw = parts
            .iter()
            .zip(&self.stations)
            .map(|((p, g), st)| {
                let da = st.shift(&du);
                from_fn(|i| p[i] + g[i][0] * da[0] + g[i][1] * da[1])
            })
            .collect();
        Some(Direction { du, dw })
    }

    /// `K = -F_w R_w^-1 R_u`, eliminated ball by ball.
    fn stiffness(&self, lin: &[Linear]) -> Option<[[f64; 5]; 5]> {
        let mut k = [[0.0; 5]; 5];
        for (lin, st) in lin.iter().zip(&self.stations) {
            let (_, g) = lin.solve([0.0; 4])?;
            lin.add_stiffness(&mut k, &g, st);
        }
        Some(k)
    }

    /// Linearises all balls at a stage; also the ring force and the largest force about.
    fn survey(&self, s: &Stage, task: &Task) -> (Vec<Linear>, [f64; 5], f64) {
        let mut force = [0.0; 5];
        let mut big = 0.0_f64;
        let mut lin = Vec::with_capacity(s.x.len());
        for (j, x) in s.x.iter().enumerate() {
            let centre = self.inner_centre(j, &s.u);
            let w = self.unknowns(x, &centre);
            let l = self.linearise(&w, &centre, task.omega, task.attitude);
            self.stations[j].collect(&l.terms.ring.map(|t| t.v), &mut force);
            big = big.max(l.terms.q[0].v).max(l.terms.q[1].v);
            lin.push(l);
        }
        (lin, force, big)
    }

    /// Norm of the ring's imbalance in units of `scale`, moments over the pitch radius.
    fn ring_size(&self, force: &[f64; 5], task: &Task, scale: f64) -> f64 {
        let lever = self.pitch_radius();
        let mut sum = 0.0;
        for (k, (f, load)) in force.iter().zip(&task.load).enumerate() {
            if task.is_free(k) {
                let unit = if k < 3 { 1.0 } else { lever };
                sum += ((f - load) / unit / scale).powi(2);
            }
        }
        sum.sqrt()
    }

    /// Magnitude of the load as a force.
    pub(super) fn load_size(&self, task: &Task) -> f64 {
        let lever = self.pitch_radius();
        (0..5).fold(0.0_f64, |s, k| {
            let unit = if k < 3 { 1.0 } else { lever };
            s.max((task.load[k] / unit).abs())
        })
    }

    /// Damped Newton on all balls and the ring together, as of a shaft with one row; leaves `s` near enough for [`Self::refine`].
    pub(super) fn newton(&self, s: &mut Stage, task: &Task, limit: usize) -> Result<(), Failure> {
        (s.u, s.x) = Solver::alone(self).near(s.u, &s.x, task, limit)?;
        Ok(())
    }

    /// Newton on the ring with every ball in equilibrium throughout, damped like Levenberg's method:
    /// slower than [`Self::newton`], much harder to lose.
    pub(super) fn nested(&self, s: &mut Stage, task: &Task, limit: usize) -> Result<(), Failure> {
        self.place(&s.u, task, &mut s.x, true)
            .or_else(|_| self.place(&s.u, task, &mut s.x, false))?;
        let mut damping = 0.0_f64;
        for _ in 0..limit {
            let (lin, force, big) = self.survey(s, task);
            let scale = self.load_size(task).max(1e-3 * big);
            let size = self.ring_size(&force, task, scale);
            if size < 1e-5 {
                return Ok(());
            }
            let ball = vec![[0.0; 4]; lin.len()];
            let ring = from_fn(|k| task.load[k] - force[k]);
            loop {
                let better = self
                    .direction(&lin, &ball, &ring, task, damping)
                    .and_then(|dir| {
                        let mut trial = s.clone();
                        for k in 0..5 {
                            trial.u[k] += dir.du[k];
                        }
                        self.place(&trial.u, task, &mut trial.x, true).ok()?;
                        let (_, force, _) = self.survey(&trial, task);
                        (self.ring_size(&force, task, scale) < (1.0 - 1e-4) * size).then_some(trial)
                    });
                if let Some(trial) = better {
                    *s = trial;
                    damping = if damping < 1e-9 { 0.0 } else { damping * 0.1 };
                    break;
                }
                damping = (damping * 8.0).max(1e-7);
                if damping > 1e4 {
                    return Err(Failure::Stalled);
                }
            }
        }
        Err(Failure::Stalled)
    }

    /// Follows the solution from `from` to `to` in growing and shrinking steps.
    pub(super) fn follow(&self, s: &mut Stage, from: &Task, to: &Task) -> Result<(), Failure> {
        let mut done = 0.0_f64;
        let mut stride = 1.0_f64;
        let (least, most, limit) = (0.01, 16, 25);
        let mut steps = 0;
        while done < 1.0 {
            steps += 1;
            let goal = (done + stride).min(1.0);
            let blend = |a: f64, b: f64| if goal < 1.0 { a + goal * (b - a) } else { b };
            let task = Task {
                load: from_fn(|k| blend(from.load[k], to.load[k])),
                // The inertia loads go with the square of the speed.
                omega: blend(from.omega.powi(2), to.omega.powi(2))
                    .sqrt()
                    .copysign(to.omega),
                ..*to
            };
            let mut trial = s.clone();
            match self.nested(&mut trial, &task, limit) {
                Ok(()) => {
                    *s = trial;
                    done = goal;
                    stride *= 2.0;
                }
                Err(e) => {
                    stride *= 0.25;
                    if stride < least || steps > most {
                        return Err(e);
                    }
                }
            }
        }
        Ok(())
    }

    /// Axial force at a purely axial displacement.
    fn axial_force(&self, dx: f64, task: &Task) -> Option<f64> {
        let u = [dx, 0.0, 0.0, 0.0, 0.0];
        let centre = self.inner_centre(0, &u);
        let x = self.ball_at(&centre, task.omega, task.attitude, None)?;
        let w = self.unknowns(&x, &centre);
        let t = self.evaluate(&w, &centre, task.omega, task.attitude);
        Some(self.stations.len() as f64 * t.ring[0])
    }

    /// A start with all balls loaded alike by the axial force `fx`.
    pub(super) fn preloaded(&self, fx: f64, task: &Task) -> Result<Stage, Failure> {
        let length = (self.li + self.lo).hi;
        let (mut low, mut high) = (-self.a0[0].hi - 0.5 * length, length - self.a0[0].hi);
        for _ in 0..50 {
            let mid = 0.5 * (low + high);
            // A ball that finds no equilibrium is squeezed too hard.
            if self.axial_force(mid, task).is_none_or(|f| f > fx) {
                high = mid;
            } else {
                low = mid;
            }
        }
        let u = [0.5 * (low + high), 0.0, 0.0, 0.0, 0.0];
        let mut x = vec![[0.0, 0.0]; self.stations.len()];
        self.place(&u, task, &mut x, false)?;
        Ok(Stage { u, x })
    }

    /// Second stage: Newton on all `4 N + 5` unknowns with residual and unknowns in double-double.
    pub(super) fn refine(&self, s: &Stage, task: &Task) -> Result<Equilibrium, Failure> {
        let n = self.stations.len();
        let lever = self.pitch_radius();
        let mut u = s.u.map(Dd::of);
        let mut ws: Vec<Unknowns<Dd>> = (0..n)
            .map(|j| {
                let centre = self.inner_centre(j, &s.u);
                self.unknowns(&s.x[j], &centre).map(Dd::of)
            })
            .collect();
        let mut best = f64::INFINITY;
        for round in 0..12 {
            let mut force = [Dd::ZERO; 5];
            let mut ball = Vec::with_capacity(n);
            let mut terms = Vec::with_capacity(n);
            let mut big = self.load_size(task);
            for (j, w) in ws.iter().enumerate() {
                let centre = self.inner_centre(j, &u);
                let t = self.evaluate(w, &centre, task.omega, task.attitude);
                self.stations[j].collect(&t.ring, &mut force);
                big = big.max(t.q[0].hi).max(t.q[1].hi);
                let [c0, c1] = t.closure;
                let [b0, b1] = t.balance;
                ball.push([c0, c1, b0, b1].map(Dd::value));
                terms.push(t);
            }
            let mut ring = [0.0; 5];
            let mut size = 0.0_f64;
            for k in 0..5 {
                if task.is_free(k) {
                    ring[k] = (Dd::of(task.load[k]) - force[k]).value();
                    let unit = if k < 3 { 1.0 } else { lever };
                    size = size.max((ring[k] / unit / big).abs());
                }
            }
            let thin = (big / self.outer.k.hi).powf(2.0 / 3.0);
            for r in &ball {
                size = size.max((r[0] / thin).abs()).max((r[1] / thin).abs());
                size = size.max((r[2] / big).abs()).max((r[3] / big).abs());
            }
            if !size.is_finite() {
                break;
            }
            let lin: Vec<Linear> = ws
                .iter()
                .map(|w| self.linearise(&w.map(Dd::value), &[0.0; 2], task.omega, task.attitude))
                .collect();
            let stuck = size >= 0.1 * best;
            if size <= 1e-20 || stuck && size <= 1e-15 {
                let k = self.stiffness(&lin).ok_or(Failure::Singular)?;
                return Ok(Equilibrium {
                    displacement: u.map(Dd::value),
                    stiffness: k,
                    balls: self.report(&ws, &terms),
                });
            }
            if stuck && round > 3 {
                break;
            }
            best = best.min(size);
            let dir = self
                .direction(&lin, &ball, &ring, task, 0.0)
                .ok_or(Failure::Singular)?;
            for (u, du) in u.iter_mut().zip(dir.du) {
                *u = *u + Dd::of(du);
            }
            for (w, dw) in ws.iter_mut().zip(&dir.dw) {
                for (w, dw) in w.iter_mut().zip(dw) {
                    *w = *w + Dd::of(*dw);
                }
            }
        }
        Err(Failure::Stalled)
    }
}
