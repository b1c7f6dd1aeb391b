//! Spindles: bearings on an elastic shaft of beam elements, with elastic supports.
//!
//! One damped Newton finds everything at once: the motion of the shaft at `x = 0` and at its nodes, of the outer
//! rings on elastic supports, of the sleeve, and both coordinates of every ball centre. It solves
//!
//! ```text
//! sum over rows of G^T F(G p + e) + S p = L
//! ```
//!
//! for the unknowns `p` of shaft, supports and sleeve: `G p` is the motion of a row's inner ring against its outer one,
//! `S` the stiffness of beam elements and supports, `L` the loads.
//!
//! The unknowns of an element are the motion of its outer node beyond the rigid continuation of its inner one, the
//! node nearer to `x = 0`. So rigid lengths have no unknowns, and a short, stiff element costs no digits.

use super::ball::{Linear, Station, Unknowns};
use super::linear::dense_solve;
use super::{Failure, Reference, Task, ball_state};
use crate::compare::Equilibrium;
use crate::double_double::Dd;
use crate::spindles::Answer;
use core::array::from_fn;
use core::f64::consts::PI;
use files::plan::{ElasticShaft, Plan};
use spindle_bearing::{Growth, Material, Preload, Section, Support};

/// `EA`, `EI` and `kappa GA` of a section, with Cowper's (1966) shear factor.
pub fn stiffnesses(section: &Section, material: &Material) -> [f64; 3] {
    let (outer, inner) = (section.outer, section.inner);
    let (modulus, nu) = (material.youngs_modulus, material.poissons_ratio);
    let area = 0.25 * PI * (outer * outer - inner * inner);
    let second_moment = PI / 64.0 * (outer.powi(4) - inner.powi(4));
    let m2 = (inner / outer).powi(2);
    let ring = (1.0 + m2).powi(2);
    let factor = 6.0 * (1.0 + nu) * ring / ((7.0 + 6.0 * nu) * ring + (20.0 + 12.0 * nu) * m2);
    let shear = factor * area * modulus / (2.0 * (1.0 + nu));
    [modulus * area, modulus * second_moment, shear]
}

/// Stiffness of a Timoshenko beam from `from` to `to` against motion of its end at `to`: a block of the consistent
/// stiffness matrix. None where the shaft is rigid.
fn element(shaft: &ElasticShaft, from: f64, to: f64) -> Option<[[f64; 5]; 5]> {
    let middle = 0.5 * (from + to);
    let mut sections = shaft.sections.iter();
    let section = sections.find(|s| s.from < middle && middle < s.to)?;
    let [tension, bending, shear] = stiffnesses(section, &shaft.material);
    let (length, direction) = ((to - from).abs(), (to - from).signum());
    let phi = 12.0 * bending / (shear * length * length);
    let c = bending / (length.powi(3) * (1.0 + phi));
    let (force, moment) = (12.0 * c, (4.0 + phi) * length * length * c);
    let cross = -6.0 * length * c * direction;
    let mut k = [[0.0; 5]; 5];
    k[0][0] = tension / length;
    // A positive tilt is dv/dx in the y plane, -dv/dx in the z plane.
    for (v, tilt, sign) in [(1, 4, 1.0), (2, 3, -1.0)] {
        (k[v][v], k[tilt][tilt]) = (force, moment);
        (k[v][tilt], k[tilt][v]) = (sign * cross, sign * cross);
    }
    Some(k)
}

/// Motion (5) by unknowns, each with its index.
type Map = Vec<(usize, [f64; 5])>;

/// Motion by five unknowns of its own, the first of which is `first`.
fn own(first: usize) -> impl Iterator<Item = (usize, [f64; 5])> {
    (0..5).map(move |i| (first + i, from_fn(|j| f64::from(u8::from(i == j)))))
}

fn dot(a: &[f64; 5], b: &[f64; 5]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn motion(map: &Map, p: &[f64]) -> [f64; 5] {
    from_fn(|i| map.iter().map(|(k, column)| column[i] * p[*k]).sum())
}

/// A row as it is solved.
#[derive(Debug, Clone)]
struct Mounted {
    bearing: Reference,
    closure: f64,
    /// Motion of the inner ring against the outer one, in the row's own frame.
    map: Map,
}

impl Mounted {
    fn displacement(&self, p: &[f64]) -> [f64; 5] {
        let mut u = motion(&self.map, p);
        u[0] += self.closure;
        u
    }
}

#[derive(Clone)]
struct State {
    p: Vec<f64>,
    /// Ball centres of each row from the outer curvature centre, axial and radial.
    balls: Vec<Vec<[f64; 2]>>,
}

/// Loads by unknown, the first ones with those of the task.
#[derive(Clone)]
struct Problem {
    load: Vec<f64>,
    task: Task,
}

/// A ball's equations; its Newton step at a ring at rest, and the step's change by `A1, A2`.
struct LinearBall {
    unknowns: Unknowns<f64>,
    linear: Linear,
    step: [f64; 4],
    by_centre: [[f64; 2]; 4],
}

/// All equations, with the balls condensed: `matrix dp = right`.
struct Linearised {
    balls: Vec<Vec<LinearBall>>,
    matrix: Vec<Vec<f64>>,
    right: Vec<f64>,
    /// Norm of the residual, N.
    residual: f64,
    /// Largest force, N.
    largest: f64,
}

/// Solver of a spindle.
#[derive(Debug, Clone)]
pub struct Solver {
    rows: Vec<Mounted>,
    /// Stiffness of elements and supports: two unknowns, and an entry of `S`.
    springs: Vec<(usize, usize, f64)>,
    /// 1 for an unknown that is a length, the pitch radius for a tilt.
    units: Vec<f64>,
    /// Constant loads and the spring's force, by unknown.
    load: Vec<f64>,
    spring: Option<f64>,
}

/// Index of the sleeve's closure in the unknowns, after the motion at `x = 0`.
const SLEEVE: usize = 5;

/// Strides of a cold start from its first load to the load that is asked for, failed ones included.
const MOST_STRIDES: usize = 20;

impl Solver {
    /// Prepares a spindle. Growth is none where there are fewer than rows.
    ///
    /// # Errors
    /// [`Failure::Input`] for a bearing that cannot be built, for no bearing, and for a row preloaded by a force.
    pub fn new(spindle: &Plan, growth: &[Growth<f64>]) -> Result<Self, Failure> {
        let first = spindle.rows.first().ok_or(Failure::Input("no rows"))?;
        let lever = 0.5 * first.design.pitch_diameter;
        let shaft = spindle.shaft.as_ref();
        let rows = spindle.rows.iter().map(|row| row.position);
        let sections = shaft.iter().flat_map(|shaft| &shaft.sections);
        let ends = sections.flat_map(|section| [section.from, section.to]);
        let constant = || shaft.iter().flat_map(|shaft| &shaft.loads);
        let loads = constant().map(|load| load.position);
        let mut positions: Vec<f64> = rows.chain(loads).chain(ends).collect();
        positions.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        positions.dedup();

        let freedoms = [1.0, 1.0, 1.0, lever, lever];
        let mut units = freedoms.to_vec();
        units.extend(spindle.spring.map(|_| 1.0));
        let mut springs = Vec::new();
        let mut nodes: Vec<(f64, Map)> = vec![(0.0, own(0).collect())];
        for side in [1.0, -1.0] {
            let (mut from, mut map) = nodes[0].clone();
            for &x in positions.iter().filter(|x| side * **x > 0.0) {
                for (_, [_, dy, dz, ty, tz]) in &mut map {
                    *dy += (x - from) * *tz;
                    *dz -= (x - from) * *ty;
                }
                if let Some(k) = shaft.and_then(|shaft| element(shaft, from, x)) {
                    let n = units.len();
                    let entry = |i: usize, j: usize| (n + i, n + j, k[i][j]);
                    springs.extend((0..25).map(|ij| entry(ij / 5, ij % 5)));
                    map.extend(own(n));
                    units.extend(freedoms);
                }
                nodes.push((x, map.clone()));
                from = x;
            }
        }
        let mut mounted = Vec::with_capacity(spindle.rows.len());
        for (index, row) in spindle.rows.iter().enumerate() {
            let mut map = at(&nodes, row.position)?.clone();
            let support = shaft.and_then(|shaft| shaft.supports.get(index));
            let support = support.unwrap_or(&Support::RIGID);
            let (radial, tilting) = (support.radial, support.tilting);
            let held = [support.axial, radial, radial, tilting, tilting];
            for (i, stiffness) in held.into_iter().enumerate() {
                if stiffness.is_finite() {
                    let n = units.len();
                    springs.push((n, n, stiffness));
                    map.push((n, from_fn(|j| if i == j { -1.0 } else { 0.0 })));
                    units.push(freedoms[i]);
                }
            }
            for i in [0, 3, 4] {
                map.iter_mut()
                    .for_each(|(_, column)| column[i] *= row.facing.sign::<f64>());
            }
            let closure = match row.preload {
                Preload::Closure(closure) => closure,
                Preload::Spring => {
                    map.extend(spindle.spring.map(|_| (SLEEVE, [1.0, 0.0, 0.0, 0.0, 0.0])));
                    0.0
                }
                _ => return Err(Failure::Input("a force is no closure")),
            };
            let mut bearing = Reference::new(&row.design, row.balls)?;
            let growth = growth.get(index).unwrap_or(&Growth::NONE);
            let [axial, radial, ball] = [growth.axial, growth.radial, growth.ball].map(Dd::of);
            let half = Dd::of(0.5) * ball;
            (bearing.li, bearing.lo) = (bearing.li - half, bearing.lo - half);
            bearing.a0 = [bearing.a0[0] + axial, bearing.a0[1] + radial];
            mounted.push(Mounted {
                bearing,
                closure,
                map,
            });
        }
        let mut load = vec![0.0; units.len()];
        for at_x in constant() {
            let map = at(&nodes, at_x.position)?.iter();
            map.for_each(|(k, column)| load[*k] += dot(column, &at_x.load));
        }
        if let Some(spring) = spindle.spring {
            load[SLEEVE] += spring;
        }
        Ok(Self {
            rows: mounted,
            springs,
            units,
            load,
            spring: spindle.spring,
        })
    }

    /// A bearing as the only row.
    pub(super) fn alone(bearing: &Reference) -> Self {
        let lever = bearing.pitch_radius();
        let row = Mounted {
            bearing: bearing.clone(),
            closure: 0.0,
            map: own(0).collect(),
        };
        Self {
            rows: vec![row],
            springs: Vec::new(),
            units: vec![1.0, 1.0, 1.0, lever, lever],
            load: vec![0.0; 5],
            spring: None,
        }
    }

    /// Ring and ball centres of the only row near their equilibrium, from others.
    pub(super) fn near(
        &self,
        u: [f64; 5],
        x: &[[f64; 2]],
        task: &Task,
        limit: usize,
    ) -> Result<([f64; 5], Vec<[f64; 2]>), Failure> {
        let (p, balls) = (u.to_vec(), vec![x.to_vec()]);
        let problem = self.problem(task);
        let (found, _) = self.newton(State { p, balls }, &problem, 1e-7, limit)?;
        Ok((from_fn(|i| found.p[i]), found.balls.concat()))
    }

    fn problem(&self, task: &Task) -> Problem {
        let mut load = self.load.clone();
        for (load, (at_0, held)) in load.iter_mut().zip(task.load.iter().zip(task.held)) {
            *load = if held.is_some() { 0.0 } else { *load + at_0 };
        }
        Problem { load, task: *task }
    }

    /// Equilibrium that Newton reaches from the answer of another program.
    ///
    /// # Errors
    /// Why there is none.
    pub fn polish(&self, task: &Task, answer: &Answer) -> Result<Equilibrium, Failure> {
        let problem = self.problem(task);
        // Shaft and supports are bent as the forces of rows and loads bend them.
        let free = 5 + usize::from(self.spring.is_some());
        let mut force = self.load.clone();
        for (row, found) in self.rows.iter().zip(&answer.rows) {
            let map = row.map.iter();
            map.for_each(|(k, column)| force[*k] -= dot(column, &found.force));
        }
        let mut lines = vec![vec![0.0; force.len() - free + 1]; force.len() - free];
        for (line, force) in lines.iter_mut().zip(&force[free..]) {
            *line.last_mut().ok_or(Failure::Singular)? = *force;
        }
        for &(i, j, k) in &self.springs {
            lines[i - free][j - free] += k;
        }
        let bent = dense_solve(lines).ok_or(Failure::Singular)?.concat();
        let mut p = answer.displacement.to_vec();
        p.extend(self.spring.map(|_| answer.spring_closure));
        p.extend(bent);
        let rows = self.rows.iter().zip(&answer.rows);
        let balls = rows.map(|(row, found)| row.bearing.centres(&found.balls));
        let balls = balls.collect();
        let (state, linear) = self.newton(State { p, balls }, &problem, 1e-10, 60)?;
        self.report(&state.p, &linear)
    }

    /// Equilibrium from a cold start.
    ///
    /// # Errors
    /// Why there is none.
    pub fn search(&self, task: &Task) -> Result<Equilibrium, Failure> {
        let (state, linear) = self.cold(&self.problem(task))?;
        self.report(&state.p, &linear)
    }

    /// Linearises everything at a state; none where a turning ball is off the outer race.
    fn linearise(&self, state: &State, problem: &Problem) -> Option<Linearised> {
        let n = self.units.len();
        let mut unbalanced = problem.load.clone();
        let mut matrix = vec![vec![0.0; n]; n];
        for &(i, j, k) in &self.springs {
            unbalanced[i] -= k * state.p[j];
            matrix[i][j] += k;
        }
        let mut condensed = vec![0.0; n];
        let mut balls = Vec::new();
        let (mut squares, mut largest) = (0.0, 0.0_f64);
        for (row, centres) in self.rows.iter().zip(&state.balls) {
            let bearing = &row.bearing;
            let u = row.displacement(&state.p);
            let (mut force, mut lost, mut stiffness) = ([0.0; 5], [0.0; 5], [[0.0; 5]; 5]);
            let mut of_row = Vec::with_capacity(centres.len());
            for (j, (x, station)) in centres.iter().zip(&bearing.stations).enumerate() {
                let centre = bearing.inner_centre(j, &u);
                let unknowns = bearing.unknowns(x, &centre);
                if problem.task.omega != 0.0 && unknowns[3] <= 0.0 {
                    return None;
                }
                let linear = bearing.linearise(
                    &unknowns,
                    &centre,
                    problem.task.omega,
                    problem.task.attitude,
                );
                let terms = &linear.terms;
                let [axial, radial] = terms.balance.map(|balance| balance.v);
                let (step, by_centre) = linear.solve([0.0, 0.0, axial, radial])?;
                station.collect(&terms.ring.map(|ring| ring.v), &mut force);
                station.collect(&linear.ring_change(&step), &mut lost);
                linear.add_stiffness(&mut stiffness, &by_centre, station);
                squares += axial * axial + radial * radial;
                largest = largest.max(terms.q[0].v).max(terms.q[1].v);
                of_row.push(LinearBall {
                    unknowns,
                    linear,
                    step,
                    by_centre,
                });
            }
            for (i, by) in &row.map {
                unbalanced[*i] -= dot(by, &force);
                condensed[*i] -= dot(by, &lost);
                for (j, u) in &row.map {
                    matrix[*i][*j] += dot(by, &stiffness.map(|k| dot(&k, u)));
                }
            }
            balls.push(of_row);
        }
        for i in (0..5).filter(|i| problem.task.held[*i].is_some()) {
            (unbalanced[i], condensed[i]) = (0.0, 0.0);
        }
        for ((r, load), unit) in unbalanced.iter().zip(&problem.load).zip(&self.units) {
            squares += (r / unit).powi(2);
            largest = largest.max((load / unit).abs());
        }
        Some(Linearised {
            balls,
            matrix,
            right: unbalanced
                .iter()
                .zip(condensed)
                .map(|(a, b)| a + b)
                .collect(),
            residual: squares.sqrt(),
            largest,
        })
    }

    /// Changes of all unknowns: a Newton step.
    fn step(&self, at: &Linearised, problem: &Problem) -> Option<State> {
        let lines = at.matrix.iter().zip(&at.right);
        let lines = lines.map(|(line, right)| [&line[..], &[*right]].concat());
        let mut lines: Vec<_> = lines.collect();
        for i in (0..5).filter(|i| problem.task.held[*i].is_some()) {
            lines[i].fill(0.0);
            lines[i][i] = 1.0;
        }
        let p = dense_solve(lines)?.concat();
        let rows = self.rows.iter().zip(&at.balls).map(|(row, balls)| {
            let du = motion(&row.map, &p);
            let step = |(ball, station): (&LinearBall, &Station)| {
                let da = station.shift(&du);
                let by = |i: usize| ball.by_centre[i][0] * da[0] + ball.by_centre[i][1] * da[1];
                let dw = from_fn(|i| ball.step[i] + by(i));
                row.bearing.centre_change(&ball.unknowns, &dw)
            };
            balls.iter().zip(&row.bearing.stations).map(step).collect()
        });
        let balls = rows.collect();
        Some(State { p, balls })
    }

    /// Puts balls in equilibrium: they have a closed form at rest.
    fn place(&self, state: &mut State, problem: &Problem) -> Result<(), Failure> {
        for (row, centres) in self.rows.iter().zip(&mut state.balls) {
            let u = row.displacement(&state.p);
            row.bearing.place(&u, &problem.task, centres, false)?;
        }
        Ok(())
    }

    /// Newton on everything at once, with shorter steps where the residual does not fall. It ends where the residual, over
    /// forces, is rounding, or below `near` and falls no more.
    fn newton(
        &self,
        mut state: State,
        problem: &Problem,
        near: f64,
        limit: usize,
    ) -> Result<(State, Linearised), Failure> {
        let held = state.p.iter_mut().zip(&problem.task.held);
        held.for_each(|(p, held)| *p = held.unwrap_or(*p));
        let bearing = &self.rows[0].bearing;
        let (length, contact) = ((bearing.li + bearing.lo).hi, bearing.outer.k.hi);
        let at_rest = problem.task.omega == 0.0;
        if at_rest {
            self.place(&mut state, problem)?;
        }
        let mut at = self.linearise(&state, problem).ok_or(Failure::Stalled)?;
        let count = at.balls.iter().flatten().count() as f64;
        let mut last = f64::INFINITY;
        for _ in 0..limit {
            let size = at.residual / at.largest;
            // Rounding of lengths, of which deformations are differences.
            let rounding = length / (at.largest / contact).powf(2.0 / 3.0);
            if size <= 1e-15 * (1.0 + rounding) * count || size < near && size > 0.1 * last {
                return Ok((state, at));
            }
            last = size;
            let step = self.step(&at, problem).ok_or(Failure::Singular)?;
            let better = (0..24).find_map(|halvings| {
                let part = 0.5_f64.powi(halvings);
                let mut next = state.clone();
                let unknowns = next
                    .p
                    .iter_mut()
                    .chain(next.balls.iter_mut().flatten().flatten());
                let changes = step.p.iter().chain(step.balls.iter().flatten().flatten());
                unknowns
                    .zip(changes)
                    .for_each(|(x, change)| *x += part * change);
                if at_rest {
                    self.place(&mut next, problem).ok()?;
                }
                let found = self.linearise(&next, problem)?;
                (found.residual < (1.0 - 1e-4 * part) * at.residual).then_some((next, found))
            });
            match better {
                Some(found) => (state, at) = found,
                None if size < near => return Ok((state, at)),
                None => break,
            }
        }
        Err(Failure::Stalled)
    }

    /// A cold start from a shaft that has not moved, with the sleeve where it balances the spring; along the load where
    /// that is too far away.
    fn cold(&self, problem: &Problem) -> Result<(State, Linearised), Failure> {
        let mut state = State {
            p: vec![0.0; self.units.len()],
            balls: self
                .rows
                .iter()
                .map(|row| vec![[0.0; 2]; row.bearing.balls()])
                .collect(),
        };
        // The load that it starts from.
        let mut start = vec![0.0; self.units.len()];
        let alone = Task::new([0.0; 5], problem.task.omega, problem.task.attitude);
        let slides = |row: &&Mounted| row.map.iter().any(|(k, _)| *k == SLEEVE);
        if let (Some(spring), Some(row)) = (self.spring, self.rows.iter().find(slides)) {
            let share = spring / self.rows.iter().filter(slides).count() as f64;
            state.p[SLEEVE] = row.bearing.preloaded(share, &alone)?.u[0] - row.closure;
            start[SLEEVE] = spring;
        } else if self.rows.iter().all(|row| row.closure <= 0.0) {
            // Without preload, no row resists: press one.
            let (bearing, facing) = (&self.rows[0].bearing, self.rows[0].map[0].1[0]);
            let load = from_fn(|i| problem.load[i].abs());
            let pressed = [1.0, 4.0].into_iter().find_map(|factor| {
                let share = bearing.preload(&load, factor);
                Some((share, bearing.preloaded(share, &alone).ok()?))
            });
            let (share, pressed) = pressed.ok_or(Failure::Stalled)?;
            (state.p[0], start[0]) = (facing * pressed.u[0], facing * share);
        }
        self.place(&mut state, problem)?;
        let first = state.p.clone();
        let (mut done, mut stride) = (0.0, 1.0);
        for _ in 0..MOST_STRIDES {
            let goal = f64::min(done + stride, 1.0);
            let mut part = problem.clone();
            let loads = part.load.iter_mut().zip(&start);
            loads.for_each(|(load, start)| *load = goal * *load + (1.0 - goal) * start);
            let held = part.task.held.iter_mut().zip(&first);
            held.for_each(|(held, p)| *held = held.map(|u| goal * u + (1.0 - goal) * p));
            match self.newton(state.clone(), &part, 1e-10, 60) {
                Ok((found, linear)) => {
                    if goal == 1.0 {
                        return Ok((found, linear));
                    }
                    (state, done, stride) = (found, goal, 2.0 * stride);
                }
                Err(_) => stride *= 0.25,
            }
        }
        Err(Failure::Stalled)
    }

    /// The equilibrium, if it is one of the bearings and not of their equations alone.
    fn report(&self, p: &[f64], linear: &Linearised) -> Result<Equilibrium, Failure> {
        let matrix = &linear.matrix;
        // Everything but the motion at x = 0 is condensed.
        let rest = matrix[5..]
            .iter()
            .map(|line| [&line[5..], &line[..5]].concat());
        let follows = dense_solve(rest.collect()).ok_or(Failure::Singular)?;
        let condensed = |i: usize, j: usize| {
            let followed = matrix[i][5..].iter().zip(&follows);
            matrix[i][j] - followed.map(|(k, by)| k * by[j]).sum::<f64>()
        };
        let mut found = Vec::new();
        for (row, balls) in self.rows.iter().zip(&linear.balls) {
            let stations = row.bearing.stations.iter().zip(balls);
            let balls = stations.map(|(station, ball)| {
                let terms = &ball.linear.terms;
                let [q_i, q_o] = terms.q;
                ball_state(
                    station,
                    ball.unknowns,
                    [q_i, q_o, terms.fc, terms.mg].map(|x| x.v),
                )
            });
            let balls: Vec<_> = balls.collect();
            if !row.bearing.are_physical(&balls) {
                return Err(Failure::Stalled);
            }
            found.extend(balls);
        }
        Ok(Equilibrium {
            displacement: from_fn(|i| p[i]),
            stiffness: from_fn(|i| from_fn(|j| condensed(i, j))),
            balls: found,
        })
    }
}

/// Motion of the shaft at a node.
fn at(nodes: &[(f64, Map)], position: f64) -> Result<&Map, Failure> {
    let node = nodes.iter().find(|node| node.0 == position);
    node.map(|(_, map)| map).ok_or(Failure::Input("position"))
}
