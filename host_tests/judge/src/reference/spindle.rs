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
//!
//! As for a bearing alone, Newton runs in two stages: in doubles, then with residual and unknowns in double-double. A
//! deformation of a ball is a small difference of lengths. So is the motion of a row of those that a lever makes, and the
//! stiffness at `x = 0` of a shaft that bends: its matrix is made and condensed in double-double.

use super::ball::{Linear, Station, Terms, Unknowns};
use super::linear::dense_solve;
use super::number::Scalar;
use super::{Failure, Reference, Task};
use crate::compare::{Equilibrium, worse};
use crate::double_double::Dd;
use core::array::from_fn;
use core::f64::consts::PI;
use solvers::Answer;
use spindle_bearing::{Growth, Material, Preload, Section, Support};
use spindle_file::plan::{ElasticShaft, Plan};

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
fn element(shaft: &ElasticShaft, from: f64, to: f64) -> Option<[[Dd; 5]; 5]> {
    let middle = 0.5 * (from + to);
    let mut sections = shaft.sections.iter();
    let section = sections.find(|s| s.from < middle && middle < s.to)?;
    let [tension, bending, shear] = stiffnesses(section, &shaft.material).map(Dd::of);
    let [one, four, six, twelve] = [1.0, 4.0, 6.0, 12.0].map(Dd::of);
    // Towards `to`, of either sign; an even power of it is a length's.
    let reach = Dd::of(to) - Dd::of(from);
    let square = reach * reach;
    let length = Dd::of((to - from).signum()) * reach;
    let phi = twelve * bending / (shear * square);
    let c = bending / (length * square * (one + phi));
    let (force, moment) = (twelve * c, (four + phi) * square * c);
    let cross = -six * reach * c;
    let mut k = [[Dd::ZERO; 5]; 5];
    k[0][0] = tension / length;
    // A positive tilt is dv/dx in the y plane, -dv/dx in the z plane.
    for (v, tilt, cross) in [(1, 4, cross), (2, 3, -cross)] {
        (k[v][v], k[tilt][tilt]) = (force, moment);
        (k[v][tilt], k[tilt][v]) = (cross, cross);
    }
    Some(k)
}

/// Motion (5) by unknowns, each with its index.
type Map<T> = Vec<(usize, [T; 5])>;

/// Motion by an unknown of its own.
fn unit<T: Scalar>(freedom: usize) -> [T; 5] {
    from_fn(|i| T::of(if i == freedom { Dd::ONE } else { Dd::ZERO }))
}

/// Motion by five unknowns of its own, the first of which is `first`.
fn own<T: Scalar>(first: usize) -> impl Iterator<Item = (usize, [T; 5])> {
    (0..5).map(move |i| (first + i, unit(i)))
}

fn sum<T: Scalar>(parts: impl Iterator<Item = T>) -> T {
    parts.fold(T::of(Dd::ZERO), |sum, part| sum + part)
}

fn dot<T: Scalar>(a: &[T; 5], b: &[T; 5]) -> T {
    sum(a.iter().zip(b).map(|(a, b)| *a * *b))
}

fn motion<T: Scalar>(map: &Map<T>, p: &[T]) -> [T; 5] {
    from_fn(|i| sum(map.iter().map(|(k, column)| column[i] * p[*k])))
}

/// A map in doubles.
fn rounded(map: &Map<Dd>) -> Map<f64> {
    let columns = map.iter().map(|(k, column)| (*k, column.map(Dd::value)));
    columns.collect()
}

/// A row as it is solved.
#[derive(Debug, Clone)]
struct Mounted {
    bearing: Reference,
    closure: f64,
    /// Motion of the inner ring against the outer one, in the row's own frame; rounded.
    exact: Map<Dd>,
    map: Map<f64>,
}

impl Mounted {
    fn displacement<T: Scalar>(&self, map: &Map<T>, p: &[T]) -> [T; 5] {
        let mut u = motion(map, p);
        u[0] = u[0] + T::of(Dd::of(self.closure));
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
    exact: Vec<Dd>,
    task: Task,
}

/// A ball's equations; its Newton step at a ring at rest, and the step's change by `A1, A2`.
struct LinearBall {
    unknowns: Unknowns<f64>,
    linear: Linear,
    step: [f64; 4],
    by_centre: [[f64; 2]; 4],
}

impl LinearBall {
    /// Newton step of the unknowns when the inner groove's centre moves by `da`.
    fn moved(&self, da: &[f64; 2]) -> [f64; 4] {
        let by = |i: usize| self.by_centre[i][0] * da[0] + self.by_centre[i][1] * da[1];
        from_fn(|i| self.step[i] + by(i))
    }
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
    springs: Vec<(usize, usize, Dd)>,
    /// 1 for an unknown that is a length, the pitch radius for a tilt.
    units: Vec<f64>,
    /// Constant loads and the spring's force, by unknown.
    load: Vec<Dd>,
    spring: Option<f64>,
}

/// Index of the sleeve's closure in the unknowns, after the motion at `x = 0`.
const SLEEVE: usize = 5;

/// Residual, over forces, from which the second stage goes on.
const NEAR: f64 = 1e-10;

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
        let mut nodes: Vec<(f64, Map<Dd>)> = vec![(0.0, own(0).collect())];
        for side in [1.0, -1.0] {
            let (mut from, mut map) = nodes[0].clone();
            for &x in positions.iter().filter(|x| side * **x > 0.0) {
                let further = Dd::of(x) - Dd::of(from);
                for (_, [_, dy, dz, ty, tz]) in &mut map {
                    (*dy, *dz) = (*dy + further * *tz, *dz - further * *ty);
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
                    springs.push((n, n, Dd::of(stiffness)));
                    map.push((n, unit::<Dd>(i).map(|part| -part)));
                    units.push(freedoms[i]);
                }
            }
            let facing = Dd::of(row.facing.sign());
            for i in [0, 3, 4] {
                map.iter_mut()
                    .for_each(|(_, column)| column[i] = facing * column[i]);
            }
            let closure = match row.preload {
                Preload::Closure(closure) => closure,
                Preload::Spring => {
                    map.extend(spindle.spring.map(|_| (SLEEVE, unit(0))));
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
                map: rounded(&map),
                exact: map,
            });
        }
        let mut load = vec![Dd::ZERO; units.len()];
        for at_x in constant() {
            let map = at(&nodes, at_x.position)?.iter();
            let force = at_x.load.map(Dd::of);
            map.for_each(|(k, column)| load[*k] = load[*k] + dot(column, &force));
        }
        if let Some(spring) = spindle.spring {
            load[SLEEVE] = load[SLEEVE] + Dd::of(spring);
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
            exact: own(0).collect(),
            map: own(0).collect(),
        };
        Self {
            rows: vec![row],
            springs: Vec::new(),
            units: vec![1.0, 1.0, 1.0, lever, lever],
            load: vec![Dd::ZERO; 5],
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
        let found = self.newton(State { p, balls }, &problem, 1e-7, limit)?;
        Ok((from_fn(|i| found.p[i]), found.balls.concat()))
    }

    fn problem(&self, task: &Task) -> Problem {
        let mut exact = self.load.clone();
        for (load, (at_0, held)) in exact.iter_mut().zip(task.load.iter().zip(task.held)) {
            *load = held.map_or(*load + Dd::of(*at_0), |_| Dd::ZERO);
        }
        Problem {
            load: exact.iter().map(|load| load.value()).collect(),
            exact,
            task: *task,
        }
    }

    /// Equilibrium that Newton reaches from the answer of another program.
    ///
    /// # Errors
    /// Why there is none.
    pub fn polish(&self, task: &Task, answer: &Answer) -> Result<Equilibrium, Failure> {
        self.polish_from(task, answer, NEAR)
    }

    /// [`Self::polish`] where levers leave doubles no less than the residual `near`, over forces: 1e-9 of 30 m.
    ///
    /// # Errors
    /// Why there is none.
    pub fn polish_from(
        &self,
        task: &Task,
        answer: &Answer,
        near: f64,
    ) -> Result<Equilibrium, Failure> {
        let problem = self.problem(task);
        // Shaft and supports are bent as the forces of rows and loads bend them.
        let free = 5 + usize::from(self.spring.is_some());
        let mut force: Vec<f64> = self.load.iter().map(|load| load.value()).collect();
        for (row, found) in self.rows.iter().zip(&answer.rows) {
            let map = row.map.iter();
            map.for_each(|(k, column)| force[*k] -= dot(column, &found.force));
        }
        let mut lines = vec![vec![0.0; force.len() - free + 1]; force.len() - free];
        for (line, force) in lines.iter_mut().zip(&force[free..]) {
            *line.last_mut().ok_or(Failure::Singular)? = *force;
        }
        for &(i, j, k) in &self.springs {
            lines[i - free][j - free] += k.value();
        }
        let bent = dense_solve(lines).ok_or(Failure::Singular)?.concat();
        let mut p = answer.displacement.to_vec();
        p.extend(self.spring.map(|_| answer.spring_closure));
        p.extend(bent);
        let rows = self.rows.iter().zip(&answer.rows);
        let balls = rows.map(|(row, found)| row.bearing.centres(&found.balls));
        let balls = balls.collect();
        let state = self.newton(State { p, balls }, &problem, near, 60)?;
        self.refine(&state, &problem)
    }

    /// Equilibrium from a cold start.
    ///
    /// # Errors
    /// Why there is none.
    pub fn search(&self, task: &Task) -> Result<Equilibrium, Failure> {
        let problem = self.problem(task);
        let state = self.cold(&problem)?;
        self.refine(&state, &problem)
    }

    /// Linearises everything at a state; none where a turning ball is off the outer race.
    fn linearise(&self, state: &State, problem: &Problem) -> Option<Linearised> {
        let mut unbalanced = problem.load.clone();
        for &(i, j, k) in &self.springs {
            unbalanced[i] -= k.value() * state.p[j];
        }
        let (mut squares, mut largest) = (0.0, 0.0_f64);
        let mut balls = Vec::new();
        for (row, centres) in self.rows.iter().zip(&state.balls) {
            let bearing = &row.bearing;
            let u = row.displacement(&row.map, &state.p);
            let mut force = [0.0; 5];
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
                station.collect(&terms.ring.map(|ring| ring.v), &mut force);
                squares += axial * axial + radial * radial;
                largest = largest.max(terms.q[0].v).max(terms.q[1].v);
                let (step, by_centre) = linear.solve([0.0, 0.0, axial, radial])?;
                of_row.push(LinearBall {
                    unknowns,
                    linear,
                    step,
                    by_centre,
                });
            }
            for (i, by) in &row.map {
                unbalanced[*i] -= dot(by, &force);
            }
            balls.push(of_row);
        }
        for i in (0..5).filter(|i| problem.task.held[*i].is_some()) {
            unbalanced[i] = 0.0;
        }
        for ((r, load), unit) in unbalanced.iter().zip(&problem.load).zip(&self.units) {
            squares += (r / unit).powi(2);
            largest = largest.max((load / unit).abs());
        }
        Some(Linearised {
            right: self.condensed(&balls, unbalanced, problem),
            matrix: self.matrix(&balls, |row| &row.map, Dd::value),
            balls,
            residual: squares.sqrt(),
            largest,
        })
    }

    /// Residual, less the forces that the balls' own steps take off the rings.
    fn condensed(
        &self,
        balls: &[Vec<LinearBall>],
        mut unbalanced: Vec<f64>,
        problem: &Problem,
    ) -> Vec<f64> {
        for (row, balls) in self.rows.iter().zip(balls) {
            let mut lost = [0.0; 5];
            for (ball, station) in balls.iter().zip(&row.bearing.stations) {
                station.collect(&ball.linear.ring_change(&ball.step), &mut lost);
            }
            for (i, by) in &row.map {
                unbalanced[*i] -= dot(by, &lost);
            }
        }
        for i in (0..5).filter(|i| problem.task.held[*i].is_some()) {
            unbalanced[i] = 0.0;
        }
        unbalanced
    }

    /// Stiffness by all unknowns, the balls condensed.
    fn matrix<T: Scalar>(
        &self,
        balls: &[Vec<LinearBall>],
        map: impl Fn(&Mounted) -> &Map<T>,
        spring: impl Fn(Dd) -> T,
    ) -> Vec<Vec<T>> {
        let n = self.units.len();
        let mut matrix = vec![vec![T::of(Dd::ZERO); n]; n];
        for &(i, j, k) in &self.springs {
            matrix[i][j] = matrix[i][j] + spring(k);
        }
        for (row, balls) in self.rows.iter().zip(balls) {
            let mut stiffness = [[0.0; 5]; 5];
            for (ball, station) in balls.iter().zip(&row.bearing.stations) {
                let linear = &ball.linear;
                linear.add_stiffness(&mut stiffness, &ball.by_centre, station);
            }
            let stiffness = stiffness.map(|line| line.map(|k| T::of(Dd::of(k))));
            for (j, u) in map(row) {
                let force = stiffness.map(|k| dot(&k, u));
                for (i, by) in map(row) {
                    matrix[*i][*j] = matrix[*i][*j] + dot(by, &force);
                }
            }
        }
        matrix
    }

    /// Changes of the unknowns of shaft, supports and sleeve: a Newton step.
    fn solved(&self, at: &Linearised, problem: &Problem) -> Option<Vec<f64>> {
        let lines = at.matrix.iter().zip(&at.right);
        let lines = lines.map(|(line, right)| [&line[..], &[*right]].concat());
        let mut lines: Vec<_> = lines.collect();
        for i in (0..5).filter(|i| problem.task.held[*i].is_some()) {
            lines[i].fill(0.0);
            lines[i][i] = 1.0;
        }
        Some(dense_solve(lines)?.concat())
    }

    /// Changes of all unknowns.
    fn step(&self, at: &Linearised, problem: &Problem) -> Option<State> {
        let p = self.solved(at, problem)?;
        let rows = self.rows.iter().zip(&at.balls).map(|(row, balls)| {
            let du = motion(&row.map, &p);
            let step = |(ball, station): (&LinearBall, &Station)| {
                let dw = ball.moved(&station.shift(&du));
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
            let u = row.displacement(&row.map, &state.p);
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
    ) -> Result<State, Failure> {
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
                return Ok(state);
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
                None if size < near => return Ok(state),
                None => break,
            }
        }
        Err(Failure::Stalled)
    }

    /// A cold start from a shaft that has not moved, with the sleeve where it balances the spring; along the load where
    /// that is too far away.
    fn cold(&self, problem: &Problem) -> Result<State, Failure> {
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
            match self.newton(state.clone(), &part, NEAR, 60) {
                Ok(found) if goal == 1.0 => return Ok(found),
                Ok(found) => (state, done, stride) = (found, goal, 2.0 * stride),
                Err(_) => stride *= 0.25,
            }
        }
        Err(Failure::Stalled)
    }

    /// Second stage: Newton on all unknowns of shaft and balls, with residual and unknowns in double-double. The equilibrium, if
    /// it is one of the bearings and not of their equations alone.
    fn refine(&self, state: &State, problem: &Problem) -> Result<Equilibrium, Failure> {
        let Task {
            omega, attitude, ..
        } = problem.task;
        let mut p: Vec<Dd> = state.p.iter().copied().map(Dd::of).collect();
        let rows = || self.rows.iter().zip(&state.balls);
        let mut unknowns: Vec<Vec<Unknowns<Dd>>> = rows()
            .map(|(row, centres)| {
                let u = row.displacement(&row.map, &state.p);
                let ball = |(j, x): (usize, &[f64; 2])| {
                    let bearing = &row.bearing;
                    bearing
                        .unknowns(x, &bearing.inner_centre(j, &u))
                        .map(Dd::of)
                };
                centres.iter().enumerate().map(ball).collect()
            })
            .collect();
        let mut best = f64::INFINITY;
        for round in 0..12 {
            let mut unbalanced = problem.exact.clone();
            for &(i, j, k) in &self.springs {
                unbalanced[i] = unbalanced[i] - k * p[j];
            }
            let loads = problem.load.iter().zip(&self.units);
            let mut big = loads
                .map(|(load, unit)| (load / unit).abs())
                .fold(0.0, f64::max);
            let (mut terms, mut residuals) = (Vec::new(), Vec::new());
            for (row, unknowns) in self.rows.iter().zip(&unknowns) {
                let u = row.displacement(&row.exact, &p);
                let mut force = [Dd::ZERO; 5];
                for (j, w) in unknowns.iter().enumerate() {
                    let centre = row.bearing.inner_centre(j, &u);
                    let t = row.bearing.evaluate(w, &centre, omega, attitude);
                    row.bearing.stations[j].collect(&t.ring, &mut force);
                    big = big.max(t.q[0].value()).max(t.q[1].value());
                    let ([c0, c1], [b0, b1]) = (t.closure, t.balance);
                    residuals.push([c0, c1, b0, b1].map(Dd::value));
                    terms.push(t);
                }
                for (i, by) in &row.exact {
                    unbalanced[*i] = unbalanced[*i] - dot(by, &force);
                }
            }
            for i in (0..5).filter(|i| problem.task.held[*i].is_some()) {
                unbalanced[i] = Dd::ZERO;
            }
            let unbalanced: Vec<f64> = unbalanced.into_iter().map(Dd::value).collect();
            let of_shaft = unbalanced.iter().zip(&self.units);
            let of_shaft = of_shaft.map(|(r, unit)| r / unit / big);
            let thin = (big / self.rows[0].bearing.outer.k.hi).powf(2.0 / 3.0);
            let of_balls = residuals
                .iter()
                .flat_map(|[c0, c1, b0, b1]| [c0 / thin, c1 / thin, b0 / big, b1 / big]);
            let size = of_shaft
                .chain(of_balls)
                .fold(0.0, |size, r| worse(size, r.abs()));
            if !size.is_finite() {
                break;
            }
            let mut left = residuals.iter();
            let balls = self.rows.iter().zip(&unknowns).map(|(row, unknowns)| {
                let ball = |w: &Unknowns<Dd>| {
                    let unknowns = w.map(Dd::value);
                    let bearing = &row.bearing;
                    let linear = bearing.linearise(&unknowns, &[0.0; 2], omega, attitude);
                    let (step, by_centre) = linear.solve(*left.next()?)?;
                    Some(LinearBall {
                        unknowns,
                        linear,
                        step,
                        by_centre,
                    })
                };
                unknowns.iter().map(ball).collect::<Option<Vec<_>>>()
            });
            let balls: Option<Vec<_>> = balls.collect();
            let balls = balls.ok_or(Failure::Singular)?;
            let stuck = size >= 0.1 * best;
            if size <= 1e-20 || stuck && size <= 1e-15 {
                return self.report(&p, &unknowns, &terms, &balls);
            }
            if stuck && round > 3 {
                break;
            }
            best = best.min(size);
            let at = Linearised {
                right: self.condensed(&balls, unbalanced, problem),
                matrix: self.matrix(&balls, |row| &row.map, Dd::value),
                balls,
                residual: size,
                largest: big,
            };
            let step = self.solved(&at, problem).ok_or(Failure::Singular)?;
            for (p, step) in p.iter_mut().zip(&step) {
                *p = *p + Dd::of(*step);
            }
            for ((row, unknowns), balls) in self.rows.iter().zip(&mut unknowns).zip(&at.balls) {
                let du = motion(&row.map, &step);
                let stations = balls.iter().zip(&row.bearing.stations);
                for (w, (ball, station)) in unknowns.iter_mut().zip(stations) {
                    let dw = ball.moved(&station.shift(&du));
                    *w = from_fn(|i| w[i] + Dd::of(dw[i]));
                }
            }
        }
        Err(Failure::Stalled)
    }

    fn report(
        &self,
        p: &[Dd],
        unknowns: &[Vec<Unknowns<Dd>>],
        terms: &[Terms<Dd>],
        balls: &[Vec<LinearBall>],
    ) -> Result<Equilibrium, Failure> {
        let matrix = self.matrix(balls, |row| &row.exact, |k| k);
        // Everything but the motion at x = 0 is condensed.
        let rest = matrix[5..]
            .iter()
            .map(|line| [&line[5..], &line[..5]].concat());
        let follows = dense_solve(rest.collect()).ok_or(Failure::Singular)?;
        let condensed = |i: usize, j: usize| {
            let followed = matrix[i][5..].iter().zip(&follows);
            (matrix[i][j] - sum(followed.map(|(k, by)| *k * by[j]))).value()
        };
        let (mut found, mut rest) = (Vec::new(), terms);
        for (row, unknowns) in self.rows.iter().zip(unknowns) {
            let (own, others) = rest.split_at(unknowns.len());
            let balls = row.bearing.report(unknowns, own);
            if !row.bearing.are_physical(&balls) {
                return Err(Failure::Stalled);
            }
            found.extend(balls);
            rest = others;
        }
        Ok(Equilibrium {
            displacement: from_fn(|i| p[i].value()),
            stiffness: from_fn(|i| from_fn(|j| condensed(i, j))),
            balls: found,
        })
    }
}

/// Motion of the shaft at a node.
fn at(nodes: &[(f64, Map<Dd>)], position: f64) -> Result<&Map<Dd>, Failure> {
    let node = nodes.iter().find(|node| node.0 == position);
    node.map(|(_, map)| map).ok_or(Failure::Input("position"))
}
