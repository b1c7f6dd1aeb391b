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

use super::ball::{Linear, Unknowns};
use super::linear::dense_solve;
use super::{Attitude, Bearing, Failure, Reference};
use crate::double_double::Dd;
use core::array::from_fn;
use core::f64::consts::PI;

/// Bearings on a shaft.
#[derive(Debug, Clone)]
pub struct Spindle {
    /// The rows.
    pub rows: Vec<Row>,
    /// Shaft; none is rigid.
    pub shaft: Option<Shaft>,
    /// Axial force on the rows that slide, N.
    pub spring: Option<f64>,
}

/// A row of balls.
#[derive(Debug, Clone)]
pub struct Row {
    /// Its bearing.
    pub bearing: Bearing,
    /// Position on the shaft, m.
    pub position: f64,
    /// 1, or -1 if mirrored.
    pub facing: f64,
    /// Closure, m. The sleeve's is added where the row slides.
    pub closure: f64,
    /// Axial and radial growth of the inner against the outer groove, growth of the ball diameter, m.
    pub growth: [f64; 3],
    /// True in the sleeve that the spring presses.
    pub slides: bool,
    /// Axial, radial (N/m) and tilting (N m/rad) stiffness that holds the outer ring; none is rigid.
    pub support: [Option<f64>; 3],
}

/// A straight shaft, rigid outside its sections.
#[derive(Debug, Clone)]
pub struct Shaft {
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poissons_ratio: f64,
    /// Start, end, outer and inner diameter of each section, m.
    pub sections: Vec<[f64; 4]>,
}

/// Equilibrium of a spindle.
#[derive(Debug, Clone)]
pub struct Solution {
    /// Displacement of the shaft at `x = 0`, m and rad.
    pub displacement: [f64; 5],
    /// Stiffness there, rows are forces; with the spring's force held.
    pub stiffness: [[f64; 5]; 5],
    /// Closure of the sleeve, m.
    pub sleeve: Option<f64>,
    /// The rows.
    pub rows: Vec<RowState>,
    /// The points that were asked for.
    pub points: Vec<PointState>,
    /// Newton steps.
    pub iterations: usize,
}

/// A row in equilibrium.
#[derive(Debug, Clone)]
pub struct RowState {
    /// Load on the inner ring about the row's centre, in its own frame, N and N m.
    pub force: [f64; 5],
    /// Displacement of the shaft at the row, in the shaft's frame, m and rad.
    pub displacement: [f64; 5],
    /// Per ball: inner and outer contact angle, rad, inner and outer contact force, N.
    pub balls: Vec<[f64; 4]>,
}

/// The shaft at a point.
#[derive(Debug, Clone)]
pub struct PointState {
    /// Displacement, m and rad.
    pub displacement: [f64; 5],
    /// Displacement by force, 5x5.
    pub flexibility: [[f64; 5]; 5],
}

/// Motion (5) by each unknown.
type Map = Vec<[f64; 5]>;

impl Shaft {
    /// Stiffness of a Timoshenko beam from `from` to `to` against motion of its end at `to`: a block of the consistent
    /// stiffness matrix. None where the shaft is rigid.
    fn element(&self, from: f64, to: f64) -> Option<[[f64; 5]; 5]> {
        let middle = 0.5 * (from + to);
        let mut sections = self.sections.iter();
        let [_, _, outer, inner] = sections.find(|s| s[0] < middle && middle < s[1])?;
        let (modulus, nu) = (self.youngs_modulus, self.poissons_ratio);
        let area = 0.25 * PI * (outer * outer - inner * inner);
        let second_moment = PI / 64.0 * (outer.powi(4) - inner.powi(4));
        // Cowper (1966).
        let m2 = (inner / outer).powi(2);
        let ring = (1.0 + m2).powi(2);
        let factor = 6.0 * (1.0 + nu) * ring / ((7.0 + 6.0 * nu) * ring + (20.0 + 12.0 * nu) * m2);
        let shear = factor * area * modulus / (2.0 * (1.0 + nu));
        let (length, direction) = ((to - from).abs(), (to - from).signum());
        let phi = 12.0 * modulus * second_moment / (shear * length * length);
        let c = modulus * second_moment / (length.powi(3) * (1.0 + phi));
        let (force, moment) = (12.0 * c, (4.0 + phi) * length * length * c);
        let cross = -6.0 * length * c * direction;
        let mut k = [[0.0; 5]; 5];
        k[0][0] = modulus * area / length;
        // A positive tilt is dv/dx in the y plane, -dv/dx in the z plane.
        for (v, tilt, sign) in [(1, 4, 1.0), (2, 3, -1.0)] {
            (k[v][v], k[tilt][tilt]) = (force, moment);
            (k[v][tilt], k[tilt][v]) = (sign * cross, sign * cross);
        }
        Some(k)
    }
}

/// Motion at a distance `d` along a rigid shaft by each of its five freedoms.
fn carried(d: f64) -> [[f64; 5]; 5] {
    let mut columns = from_fn(|c| from_fn(|r| f64::from(u8::from(r == c))));
    (columns[3][2], columns[4][1]) = (-d, d);
    columns
}

fn dot(a: &[f64; 5], b: &[f64; 5]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn motion(map: &Map, p: &[f64]) -> [f64; 5] {
    from_fn(|i| map.iter().zip(p).map(|(column, p)| column[i] * p).sum())
}

impl Reference {
    /// The bearing after growth: axial, radial, of the ball diameter, m.
    fn grown(mut self, [axial, radial, ball]: [f64; 3]) -> Self {
        let half = Dd::of(0.5 * ball);
        (self.li, self.lo) = (self.li - half, self.lo - half);
        self.a0 = [self.a0[0] + Dd::of(axial), self.a0[1] + Dd::of(radial)];
        self
    }
}

struct Mounted {
    bearing: Reference,
    /// Motion against the outer ring in the row's own frame.
    map: Map,
    closure: f64,
    position: f64,
}

#[derive(Clone)]
struct State {
    p: Vec<f64>,
    /// Ball centres of each row from the outer curvature centre, axial and radial.
    balls: Vec<Vec<[f64; 2]>>,
}

struct Problem {
    load: Vec<f64>,
    omega: f64,
    attitude: Attitude,
}

/// Equations at a state.
struct Equations {
    rows: Vec<Vec<(Unknowns<f64>, Linear)>>,
    forces: Vec<[f64; 5]>,
    /// `L - S p - sum G^T F`.
    unbalanced: Vec<f64>,
    /// Largest contact force, N.
    largest: f64,
}

/// Equations with the balls condensed.
struct Condensed {
    matrix: Vec<Vec<f64>>,
    right: Vec<f64>,
    /// Per ball: Newton step at a ring at rest, and its change by the ring's motion.
    balls: Vec<Vec<([f64; 4], [[f64; 2]; 4])>>,
}

/// Solver of a spindle; starts from its last solution.
pub struct Solver {
    rows: Vec<Mounted>,
    /// Every node's position and the motion of the shaft there.
    nodes: Vec<(f64, Map)>,
    points: Vec<f64>,
    /// Stiffness of elements and supports.
    springs: Vec<Vec<f64>>,
    /// 1 for an unknown that is a length, the pitch radius for a tilt.
    units: Vec<f64>,
    spring: Option<f64>,
    state: Option<State>,
}

/// Index of the sleeve's closure in the unknowns, after the motion at `x = 0`.
const SLEEVE: usize = 5;

impl Solver {
    /// Prepares a spindle. `points`, m: where answers are wanted, and where loads act besides `x = 0` and the rows.
    ///
    /// # Errors
    /// [`Failure::Input`] for a bearing that cannot be built, and for no bearing.
    pub fn new(spindle: &Spindle, points: &[f64]) -> Result<Self, Failure> {
        let first = spindle.rows.first().ok_or(Failure::Input("no rows"))?;
        let lever = 0.5 * first.bearing.pitch_diameter;
        let sections = spindle.shaft.iter().flat_map(|shaft| &shaft.sections);
        let positions = spindle.rows.iter().map(|row| row.position);
        let ends = sections.flat_map(|section| [section[0], section[1]]);
        let mut positions: Vec<f64> = positions
            .chain(points.iter().copied())
            .chain(ends)
            .collect();
        positions.sort_by(f64::total_cmp);
        positions.dedup();

        let sleeve = usize::from(spindle.spring.is_some());
        let mut units = [1.0, 1.0, 1.0, lever, lever, 1.0][..SLEEVE + sleeve].to_vec();
        let mut blocks = Vec::new();
        // Every node's position, and the nodes that carry it: their position and first unknown.
        let mut nodes = vec![(0.0, vec![(0.0, 0)])];
        let outward = positions.iter().filter(|x| **x > 0.0);
        let inward = positions.iter().rev().filter(|x| **x < 0.0);
        for side in [outward.collect::<Vec<_>>(), inward.collect()] {
            let mut from = 0.0;
            let mut carriers = vec![(0.0, 0)];
            for &x in side {
                if let Some(k) = spindle.shaft.as_ref().and_then(|s| s.element(from, x)) {
                    blocks.push((units.len(), k));
                    carriers.push((x, units.len()));
                    units.extend([1.0, 1.0, 1.0, lever, lever]);
                }
                nodes.push((x, carriers.clone()));
                from = x;
            }
        }
        let mut supports = Vec::new();
        for (index, row) in spindle.rows.iter().enumerate() {
            for (i, kind) in [0, 1, 1, 2, 2].into_iter().enumerate() {
                if let Some(stiffness) = row.support[kind] {
                    supports.push((index, i, units.len(), stiffness));
                    units.push(if i < 3 { 1.0 } else { lever });
                }
            }
        }
        let n = units.len();
        let mut springs = vec![vec![0.0; n]; n];
        for (first, k) in blocks {
            for (i, row) in k.iter().enumerate() {
                springs[first + i][first..first + 5].copy_from_slice(row);
            }
        }
        for &(_, _, unknown, stiffness) in &supports {
            springs[unknown][unknown] = stiffness;
        }
        let map = |(x, carriers): (f64, Vec<(f64, usize)>)| {
            let mut map = vec![[0.0; 5]; n];
            for (from, first) in carriers {
                map[first..first + 5].copy_from_slice(&carried(x - from));
            }
            (x, map)
        };
        let nodes: Vec<(f64, Map)> = nodes.into_iter().map(map).collect();
        let mounted = |(index, row): (usize, &Row)| {
            let mut map = at(&nodes, row.position)?.clone();
            for &(_, i, unknown, _) in supports.iter().filter(|s| s.0 == index) {
                map[unknown][i] = -1.0;
            }
            for column in &mut map {
                for i in [0, 3, 4] {
                    column[i] *= row.facing;
                }
            }
            if sleeve == 1 && row.slides {
                map[SLEEVE][0] = 1.0;
            }
            Ok(Mounted {
                bearing: Reference::new(&row.bearing)?.grown(row.growth),
                map,
                closure: row.closure,
                position: row.position,
            })
        };
        let rows = spindle.rows.iter().enumerate().map(mounted);
        Ok(Self {
            rows: rows.collect::<Result<_, _>>()?,
            nodes,
            points: points.to_vec(),
            springs,
            units,
            spring: spindle.spring,
            state: None,
        })
    }

    /// Equilibrium under loads: where each acts, m, and `Fx, Fy, Fz, My, Mz`, N and N m; at `omega` rad/s.
    ///
    /// # Errors
    /// [`Failure::Input`] for a load that acts at no row, no point and not at `x = 0`; else why there is none.
    pub fn solve(
        &mut self,
        loads: &[(f64, [f64; 5])],
        omega: f64,
        attitude: Attitude,
    ) -> Result<Solution, Failure> {
        let mut load = vec![0.0; self.units.len()];
        for (x, force) in loads {
            let columns = at(&self.nodes, *x)?.iter();
            load.iter_mut()
                .zip(columns)
                .for_each(|(l, column)| *l += dot(column, force));
        }
        if let Some(spring) = self.spring {
            load[SLEEVE] = spring;
        }
        let problem = Problem {
            load,
            omega,
            attitude,
        };
        let warm = self.state.take().and_then(|mut state| {
            let outcome = self.newton(&mut state, &problem, false).ok()?;
            Some((state, outcome))
        });
        let (state, (equations, iterations)) = match warm {
            Some(found) => found,
            None => self.cold(&problem)?,
        };
        let solution = self.report(&state, &equations, iterations)?;
        self.state = Some(state);
        Ok(solution)
    }

    /// Makes the next solve a cold one.
    pub fn reset(&mut self) {
        self.state = None;
    }

    fn displacement(&self, row: &Mounted, p: &[f64]) -> [f64; 5] {
        let mut u = motion(&row.map, p);
        u[0] += row.closure;
        u
    }

    /// Gives every ball its place, from where it was if it is `warm`.
    fn place(&self, state: &mut State, problem: &Problem, warm: bool) -> Option<()> {
        for (row, balls) in self.rows.iter().zip(&mut state.balls) {
            let u = self.displacement(row, &state.p);
            for (j, x) in balls.iter_mut().enumerate() {
                let centre = row.bearing.inner_centre(j, &u);
                let from = warm.then_some(*x);
                *x = row
                    .bearing
                    .ball_at(&centre, problem.omega, problem.attitude, from)?;
            }
        }
        Some(())
    }

    /// The equations at a state; none where a turning ball is off the outer race.
    fn equations(&self, state: &State, problem: &Problem) -> Option<Equations> {
        let stretched = |row: &Vec<f64>| row.iter().zip(&state.p).map(|(k, p)| k * p).sum::<f64>();
        let springs = self.springs.iter().zip(&problem.load);
        let mut unbalanced: Vec<f64> = springs.map(|(k, load)| load - stretched(k)).collect();
        let mut largest = 0.0_f64;
        let (mut rows, mut forces) = (Vec::new(), Vec::new());
        for (row, balls) in self.rows.iter().zip(&state.balls) {
            let u = self.displacement(row, &state.p);
            let bearing = &row.bearing;
            let mut force = [0.0; 5];
            let mut linear = Vec::with_capacity(balls.len());
            for (j, x) in balls.iter().enumerate() {
                let centre = bearing.inner_centre(j, &u);
                let w = bearing.unknowns(x, &centre);
                if problem.omega != 0.0 && w[3] <= 0.0 {
                    return None;
                }
                let l = bearing.linearise(&w, &centre, problem.omega, problem.attitude);
                bearing.stations[j].collect(&l.terms.ring.map(|t| t.v), &mut force);
                largest = largest.max(l.terms.q[0].v).max(l.terms.q[1].v);
                linear.push((w, l));
            }
            let columns = unbalanced.iter_mut().zip(&row.map);
            columns.for_each(|(r, column)| *r -= dot(column, &force));
            rows.push(linear);
            forces.push(force);
        }
        Some(Equations {
            rows,
            forces,
            unbalanced,
            largest,
        })
    }

    /// Norm of all imbalances in units of a force.
    fn imbalance(&self, equations: &Equations, scale: f64) -> f64 {
        let balls = equations
            .rows
            .iter()
            .flatten()
            .flat_map(|(_, l)| l.terms.balance);
        let rest = equations
            .unbalanced
            .iter()
            .zip(&self.units)
            .map(|(r, unit)| r / unit);
        let all = balls.map(|b| b.v).chain(rest);
        all.map(|r| (r / scale).powi(2)).sum::<f64>().sqrt()
    }

    fn condense(&self, equations: &Equations) -> Option<Condensed> {
        let mut matrix = self.springs.clone();
        let mut right = equations.unbalanced.clone();
        let mut balls = Vec::with_capacity(self.rows.len());
        for (row, linear) in self.rows.iter().zip(&equations.rows) {
            let (mut k, mut lost) = ([[0.0; 5]; 5], [0.0; 5]);
            let mut parts = Vec::with_capacity(linear.len());
            for ((_, l), station) in linear.iter().zip(&row.bearing.stations) {
                let (step, by_centre) =
                    l.solve([0.0, 0.0, l.terms.balance[0].v, l.terms.balance[1].v])?;
                l.add_stiffness(&mut k, &by_centre, station);
                station.collect(&l.ring_change(&step), &mut lost);
                parts.push((step, by_centre));
            }
            balls.push(parts);
            let pushed: Map = row.map.iter().map(|u| k.map(|k| dot(&k, u))).collect();
            for ((line, right), column) in matrix.iter_mut().zip(&mut right).zip(&row.map) {
                *right -= dot(column, &lost);
                let line = line.iter_mut().zip(&pushed);
                line.for_each(|(k, pushed)| *k += dot(column, pushed));
            }
        }
        Some(Condensed {
            matrix,
            right,
            balls,
        })
    }

    /// The state after a Newton step of length `part`, damped like Levenberg's method.
    fn stepped(
        &self,
        state: &State,
        equations: &Equations,
        system: &Condensed,
        (part, damping): (f64, f64),
    ) -> Option<State> {
        let mut lines = system.matrix.clone();
        for (i, (line, right)) in lines.iter_mut().zip(&system.right).enumerate() {
            line[i] += damping * self.units[i].powi(2);
            line.push(*right);
        }
        let dp: Vec<f64> = dense_solve(lines)?.into_iter().flatten().collect();
        let mut next = state.clone();
        next.p.iter_mut().zip(&dp).for_each(|(p, d)| *p += part * d);
        for (b, row) in self.rows.iter().enumerate() {
            let du = motion(&row.map, &dp);
            for (j, station) in row.bearing.stations.iter().enumerate() {
                let (step, by_centre) = system.balls[b][j];
                let da = station.shift(&du);
                let dw = from_fn(|i| step[i] + by_centre[i][0] * da[0] + by_centre[i][1] * da[1]);
                let dx = row.bearing.centre_change(&equations.rows[b][j].0, &dw);
                next.balls[b][j] = from_fn(|i| state.balls[b][j][i] + part * dx[i]);
            }
        }
        Some(next)
    }

    /// Newton on everything at once, with shorter steps; or with every ball in its place throughout, to a millionth,
    /// with damped steps. At rest a ball has its place in closed form.
    fn newton(
        &self,
        state: &mut State,
        problem: &Problem,
        placed: bool,
    ) -> Result<(Equations, usize), Failure> {
        let first = &self.rows[0].bearing;
        let (length, contact) = ((first.li + first.lo).hi, first.outer.k.hi);
        let placed_here = placed || problem.omega == 0.0;
        if placed_here {
            self.place(state, problem, placed).ok_or(Failure::Stalled)?;
        }
        let mut equations = self.equations(state, problem).ok_or(Failure::Stalled)?;
        let count = equations.rows.iter().flatten().count() as f64;
        let mut last = f64::INFINITY;
        for iteration in 0..80 {
            let loads = problem
                .load
                .iter()
                .zip(&self.units)
                .map(|(load, unit)| (load / unit).abs());
            let scale = loads.fold(equations.largest, f64::max);
            let size = self.imbalance(&equations, scale);
            let noise = 1e-15 * (1.0 + length / (scale / contact).powf(2.0 / 3.0)) * count;
            let enough = if placed { 1e-6 } else { noise };
            if size <= enough || size < 1e-10 && size > 0.1 * last {
                return Ok((equations, iteration));
            }
            last = size;
            let system = self.condense(&equations).ok_or(Failure::Singular)?;
            let stiff = contact * (1e-3 * length).sqrt();
            let better = (0..24).find_map(|attempt| {
                let choice = match (placed, attempt) {
                    (true, 1..) => (1.0, stiff * 1e-7 * 4_f64.powi(attempt)),
                    _ => (0.5_f64.powi(attempt), 0.0),
                };
                let mut next = self.stepped(state, &equations, &system, choice)?;
                if placed_here {
                    self.place(&mut next, problem, true)?;
                }
                let equations = self.equations(&next, problem)?;
                let least = 1.0 - 1e-4 * choice.0;
                (self.imbalance(&equations, scale) < least * size).then_some((next, equations))
            });
            match better {
                Some((next, found)) => (*state, equations) = (next, found),
                None if size < 1e-10 => return Ok((equations, iteration)),
                None => return Err(Failure::Stalled),
            }
        }
        Err(Failure::Stalled)
    }

    /// A cold start from a shaft that has not moved, with the sleeve where it balances the spring.
    fn cold(&self, problem: &Problem) -> Result<(State, (Equations, usize)), Failure> {
        let mut state = State {
            p: vec![0.0; self.units.len()],
            balls: self
                .rows
                .iter()
                .map(|r| vec![[0.0; 2]; r.bearing.balls()])
                .collect(),
        };
        let sliding = |row: &&Mounted| row.map[SLEEVE][0] != 0.0;
        if let Some(spring) = self.spring
            && let Some(row) = self.rows.iter().find(sliding)
        {
            let share = spring / self.rows.iter().filter(sliding).count() as f64;
            let alone = super::Task::new([0.0; 5], problem.omega, problem.attitude);
            state.p[SLEEVE] = row.bearing.preloaded(share, &alone)?.u[0] - row.closure;
        }
        self.place(&mut state, problem, false)
            .ok_or(Failure::Stalled)?;
        let mut direct = state.clone();
        if let Ok(found) = self.newton(&mut direct, problem, false) {
            return Ok((direct, found));
        }
        self.newton(&mut state, problem, true)?;
        let found = self.newton(&mut state, problem, false)?;
        Ok((state, found))
    }

    fn report(
        &self,
        state: &State,
        equations: &Equations,
        iterations: usize,
    ) -> Result<Solution, Failure> {
        let system = self.condense(equations).ok_or(Failure::Singular)?;
        // Everything but the motion at x = 0 is condensed.
        let rest = system.matrix[5..].iter();
        let rest = rest.map(|line| [&line[5..], &line[..5]].concat()).collect();
        let follows = dense_solve(rest).ok_or(Failure::Singular)?;
        let stiffness = from_fn(|i| {
            let line = &system.matrix[i];
            let followed = |j: usize| {
                line[5..]
                    .iter()
                    .zip(&follows)
                    .map(|(k, by)| k * by[j])
                    .sum::<f64>()
            };
            from_fn(|j| line[j] - followed(j))
        });
        let rows = self.rows.iter().zip(&equations.rows).zip(&equations.forces);
        let rows = rows.map(|((row, balls), force)| {
            let ball =
                |(w, l): &(Unknowns<f64>, Linear)| [w[0], w[1], l.terms.q[0].v, l.terms.q[1].v];
            Ok(RowState {
                force: *force,
                displacement: motion(at(&self.nodes, row.position)?, &state.p),
                balls: balls.iter().map(ball).collect(),
            })
        });
        let points = self.points.iter().map(|x| {
            let map = at(&self.nodes, *x)?;
            let lines = system.matrix.iter().zip(map);
            let lines = lines.map(|(line, by)| line.iter().chain(by).copied().collect());
            let moved = dense_solve(lines.collect()).ok_or(Failure::Singular)?;
            let by_force =
                |i: usize, j: usize| map.iter().zip(&moved).map(|(a, x)| a[i] * x[j]).sum();
            Ok(PointState {
                displacement: motion(map, &state.p),
                flexibility: from_fn(|i| from_fn(|j| by_force(i, j))),
            })
        });
        Ok(Solution {
            displacement: from_fn(|i| state.p[i]),
            stiffness,
            sleeve: self.spring.map(|_| state.p[SLEEVE]),
            rows: rows.collect::<Result<_, _>>()?,
            points: points.collect::<Result<_, _>>()?,
            iterations,
        })
    }
}

/// Motion of the shaft at a node.
fn at(nodes: &[(f64, Map)], position: f64) -> Result<&Map, Failure> {
    let node = nodes.iter().find(|node| node.0 == position);
    let (_, map) = node.ok_or(Failure::Input("position"))?;
    Ok(map)
}
