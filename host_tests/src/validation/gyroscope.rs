//! The gyroscopic moment by integrating the rotation of one ball as a rigid body on its orbit.
//!
//! Nothing here is the solver's algebra. From the solver come the contact angles, the contact forces
//! and the centrifugal force, which tells the cage speed. That the ball rolls at both contacts then
//! gives its rotation. The ball is 36 points of mass; its orientation, a quaternion, is integrated
//! over one revolution of the cage, the angular momentum of the points taken from their
//! positions by differences in time, and the couple on the ball from the angular momentum by differences
//! again. Axes: x along the shaft, y and z radial, at rest in space; the ball starts at +y.

use super::figure::{
    Axis, BLUE, Curve, Dash, Figure, GREEN, INK, Marker, Panel, Pen, Plane, VERMILION,
};
use super::scene::{Scene, solve_all};
use super::statement::{Measure, Statement, shown, thousands, with_digits};
use super::{Block, COMMAND, Chapter, Progress, Table};
use crate::cases::{B218, rad_per_s};
use crate::compare::worse;
use crate::dispatch::Attitude;
use rayon::prelude::*;
use spindle_bearing::{BallState, Design};
use std::array::from_fn;
use std::f64::consts::{PI, TAU};

type V3 = [f64; 3];

fn cross(a: V3, b: V3) -> V3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sum(a: V3, b: V3) -> V3 {
    from_fn(|i| a[i] + b[i])
}

fn times(s: f64, a: V3) -> V3 {
    a.map(|x| s * x)
}

fn length(a: V3) -> f64 {
    dot(a, a).sqrt()
}

/// A vector turned about the shaft.
fn about_shaft(a: V3, angle: f64) -> V3 {
    let (s, c) = angle.sin_cos();
    [a[0], c * a[1] - s * a[2], s * a[1] + c * a[2]]
}

/// `a b` of quaternions, real part first.
fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let (u, v) = ([a[1], a[2], a[3]], [b[1], b[2], b[3]]);
    let w = cross(u, v);
    [
        a[0] * b[0] - dot(u, v),
        a[0] * v[0] + b[0] * u[0] + w[0],
        a[0] * v[1] + b[0] * u[1] + w[1],
        a[0] * v[2] + b[0] * u[2] + w[2],
    ]
}

/// A vector turned by a unit quaternion.
fn turned(q: [f64; 4], a: V3) -> V3 {
    let back = [q[0], -q[1], -q[2], -q[3]];
    let r = product(product(q, [0.0, a[0], a[1], a[2]]), back);
    [r[1], r[2], r[3]]
}

/// The ball at +y: where it is touched, and how it moves.
pub struct Rolling {
    /// Contact points from the ball's centre, m.
    inner: V3,
    outer: V3,
    /// Cage speed, rad/s.
    pub cage: f64,
    /// Angular velocity of the ball in space, rad/s.
    pub rotation: V3,
    /// Angular velocity of ball against race along the normal of the contact, over the shaft speed.
    pub spin: [f64; 2],
}

fn mass(design: &Design) -> f64 {
    let d = design.ball_diameter;
    design.ball.density * PI * d * d * d / 6.0
}

impl Rolling {
    /// The motion of `ball` of a bearing whose shaft turns at `omega`, rad/s.
    pub fn of(design: &Design, ball: &BallState<f64>, omega: f64) -> Self {
        let radius = 0.5 * design.ball_diameter;
        let centre = [0.0, 0.5 * design.pitch_diameter, 0.0];
        // What keeps a mass on a circle: m omega_m^2 dm / 2.
        let cage = (ball.centrifugal_force / (mass(design) * centre[1])).sqrt();
        let normal = |angle: f64| [angle.sin(), angle.cos(), 0.0];
        let outer = times(radius, normal(ball.alpha_o));
        let inner = times(-radius, normal(ball.alpha_i));
        let shaft = [omega, 0.0, 0.0];
        let travel = cross([cage, 0.0, 0.0], centre);
        // Rolling: at the contacts ball and race move alike along the orbit (z), the outer race
        // not at all. Two linear equations for the rotation in the x-y plane.
        let wanted = [-travel[2], cross(shaft, sum(centre, inner))[2] - travel[2]];
        let by = |axis: V3| [cross(axis, outer)[2], cross(axis, inner)[2]];
        let (x, y) = (by([1.0, 0.0, 0.0]), by([0.0, 1.0, 0.0]));
        let det = x[0] * y[1] - y[0] * x[1];
        let rotation = [
            (wanted[0] * y[1] - y[0] * wanted[1]) / det,
            (x[0] * wanted[1] - wanted[0] * x[1]) / det,
            0.0,
        ];
        let spin = [
            dot(sum(rotation, times(-1.0, shaft)), inner) / (radius * omega),
            dot(rotation, outer) / (radius * omega),
        ];
        Self {
            inner,
            outer,
            cage,
            rotation,
            spin,
        }
    }
}

/// Points and masses that have the moments of inertia of a solid ball of diameter and mass 1: Gauss
/// points along the radius and the height, four longitudes.
fn points() -> Vec<(V3, f64)> {
    const GAUSS: [(f64, f64); 3] = [
        (-0.774_596_669_241_483_4, 5.0 / 18.0),
        (0.0, 8.0 / 18.0),
        (0.774_596_669_241_483_4, 5.0 / 18.0),
    ];
    let mut points = Vec::new();
    for (r, wr) in GAUSS {
        let r = 0.25 * (r + 1.0);
        for (height, wh) in GAUSS {
            let across = (1.0 - height * height).sqrt();
            for quarter in 0..4 {
                let (s, c) = (0.3 + TAU * f64::from(quarter) / 4.0).sin_cos();
                // A shell's share of the volume: 4 pi r^2 dr over pi / 6, with dr half the weight.
                let weight = 24.0 * r * r * 0.5 * wr * wh * 0.25;
                points.push(([r * height, r * across * c, r * across * s], weight));
            }
        }
    }
    points
}

/// What the contacts must supply at an azimuth of the orbit.
#[derive(Debug, Clone, Copy)]
pub struct Supplied {
    /// Azimuth of the ball, rad.
    pub azimuth: f64,
    /// Couple about the ball's centre, N m.
    pub couple: V3,
    /// Force, N.
    pub force: V3,
}

/// Steps of the integration per revolution of the cage.
const STEPS: usize = 8_000;
/// Steps between two values of the angular momentum.
const STRIDE: usize = 20;

/// First derivative from values at -2, -1, 1, 2 steps of `h`; exact to `h^4`.
fn slope(values: [V3; 4], h: f64) -> V3 {
    let [a, b, c, d] = values;
    from_fn(|i| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * h))
}

/// Integrates one revolution of the cage.
pub fn integrate(design: &Design, rolling: &Rolling) -> Vec<Supplied> {
    let h = TAU / rolling.cage / STEPS as f64;
    let (d, m) = (design.ball_diameter, mass(design));
    let orbit = [0.0, 0.5 * design.pitch_diameter, 0.0];
    // The axis of rotation goes round with the cage.
    let rotation = |t: f64| about_shaft(rolling.rotation, rolling.cage * t);
    let change = |t: f64, q: [f64; 4]| {
        let [x, y, z] = rotation(t);
        product([0.0, x, y, z], q).map(|v| 0.5 * v)
    };
    let mut q = [1.0, 0.0, 0.0, 0.0];
    let margin = 2 * STRIDE + 2;
    let total = STEPS + 2 * margin;
    let mut orientations = Vec::with_capacity(total + 1);
    let start = -(margin as f64) * h;
    for i in 0..=total {
        orientations.push(q);
        // Runge and Kutta's classical step.
        let t = start + i as f64 * h;
        let k1 = change(t, q);
        let k2 = change(t + 0.5 * h, from_fn(|j| q[j] + 0.5 * h * k1[j]));
        let k3 = change(t + 0.5 * h, from_fn(|j| q[j] + 0.5 * h * k2[j]));
        let k4 = change(t + h, from_fn(|j| q[j] + h * k3[j]));
        q = from_fn(|j| q[j] + h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]));
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        q = q.map(|x| x / norm);
    }
    let body: Vec<(V3, f64)> = points()
        .into_iter()
        .map(|(p, w)| (times(d, p), w * m))
        .collect();
    // Angular momentum about the ball's centre, from where its points are.
    let momentum = |i: usize| {
        let around = [i - 2, i - 1, i + 1, i + 2].map(|k| orientations[k]);
        body.iter().fold([0.0; 3], |h_sum, (p, weight)| {
            let place = turned(orientations[i], *p);
            let velocity = slope(around.map(|q| turned(q, *p)), h);
            sum(h_sum, times(*weight, cross(place, velocity)))
        })
    };
    let centre = |i: usize| about_shaft(orbit, rolling.cage * (start + i as f64 * h));
    let velocity = |i: usize| slope([i - 2, i - 1, i + 1, i + 2].map(centre), h);
    let near = |i: usize| [i - 2 * STRIDE, i - STRIDE, i + STRIDE, i + 2 * STRIDE];
    (0..16)
        .map(|k| {
            let i = margin + k * STEPS / 16;
            let wide = STRIDE as f64 * h;
            Supplied {
                azimuth: TAU * k as f64 / 16.0,
                couple: slope(near(i).map(momentum), wide),
                force: times(m, slope(near(i).map(velocity), wide)),
            }
        })
        .collect()
}

/// A rule at a speed, solved and integrated.
pub struct Check {
    name: &'static str,
    rpm: f64,
    design: Design,
    ball: BallState<f64>,
    /// Shares of the friction at the contacts, which add up to 2.
    shares: [f64; 2],
    rolling: Rolling,
    supplied: Vec<Supplied>,
}

/// Unit vector along the orbit at an azimuth, `e_x x e_r`.
fn along_orbit(azimuth: f64) -> V3 {
    cross([1.0, 0.0, 0.0], [0.0, azimuth.cos(), azimuth.sin()])
}

impl Check {
    /// Integrates the motion of `ball`.
    pub fn of(
        name: &'static str,
        design: &Design,
        attitude: Attitude,
        rpm: f64,
        ball: BallState<f64>,
    ) -> Self {
        let total = ball.q_i + ball.q_o;
        let rolling = Rolling::of(design, &ball, rad_per_s(rpm));
        Self {
            name,
            rpm,
            design: *design,
            ball,
            shares: match attitude {
                Attitude::Outer => [0.0, 2.0],
                Attitude::Inner => [1.0, 1.0],
                Attitude::Raceless => [2.0 * ball.q_i / total, 2.0 * ball.q_o / total],
            },
            supplied: integrate(design, &rolling),
            rolling,
        }
    }

    /// Largest difference of the couple from `Mg e_t`, over `Mg`, along the orbit.
    pub fn couple_error(&self) -> f64 {
        let mg = self.ball.gyroscopic_moment;
        self.supplied.iter().fold(0.0, |m, s| {
            let off = sum(s.couple, times(-mg, along_orbit(s.azimuth)));
            worse(m, length(off) / mg.abs())
        })
    }

    /// Couple along the orbit over `Mg`, mean: 1 if size and sign are right.
    fn ratio(&self) -> f64 {
        let along = self
            .supplied
            .iter()
            .map(|s| dot(s.couple, along_orbit(s.azimuth)));
        along.sum::<f64>() / (self.supplied.len() as f64 * self.ball.gyroscopic_moment)
    }

    /// Friction forces on the ball at +y that make the couple `Mg e_t`, by their lever arms: across the
    /// contact normals in the x-y plane.
    fn friction(&self) -> [V3; 2] {
        [self.rolling.inner, self.rolling.outer].map(|arm| {
            let across = cross([0.0, 0.0, 1.0], arm);
            // cross(arm, across) = |arm|^2 e_t
            times(1.0 / dot(arm, arm), across)
        })
    }

    /// What is left of the ball's equations of motion with friction that turns it as integrated
    /// (`sense` 1) or the other way (-1): force over the largest contact force, and couple over `Mg`.
    pub fn motion_error(&self, sense: f64) -> [f64; 2] {
        let first = &self.supplied[0];
        let couple = dot(first.couple, along_orbit(0.0));
        let forces = self.friction();
        let contacts = [self.rolling.inner, self.rolling.outer];
        let pressed = [self.ball.q_i, self.ball.q_o];
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        for i in 0..2 {
            let arm = contacts[i];
            // Races push towards the centre.
            let push = times(-pressed[i] / length(arm), arm);
            let rub = times(sense * 0.5 * self.shares[i] * couple, forces[i]);
            force = sum(force, sum(push, rub));
            moment = sum(moment, cross(arm, sum(push, rub)));
        }
        let largest = self.ball.q_i.max(self.ball.q_o);
        [
            length(sum(first.force, times(-1.0, force))) / largest,
            length(sum(first.couple, times(-1.0, moment))) / couple.abs(),
        ]
    }
}

const LOAD: [f64; 5] = [17_800.0, 0.0, 0.0, 0.0, 0.0];
const SPEEDS: [f64; 3] = [6_000.0, 10_000.0, 15_000.0];
const RULES: [(&str, Attitude); 3] = [
    ("outer race control", Attitude::Outer),
    ("inner race control", Attitude::Inner),
    ("raceway-control-free", Attitude::Raceless),
];

/// The ball of the 218 by every rule at every speed.
///
/// # Errors
///
/// A rule without a solution.
pub fn checks(progress: &dyn Progress) -> anyhow::Result<Vec<Check>> {
    let wanted: Vec<_> = RULES
        .iter()
        .flat_map(|&(name, attitude)| SPEEDS.map(|rpm| (name, attitude, rpm)))
        .collect();
    let scenes = wanted.iter().map(|&(_, attitude, rpm)| Scene {
        name: "218",
        design: B218,
        balls: 16,
        attitude,
        load: LOAD,
        rpm,
    });
    let solved = solve_all(scenes.collect(), progress)?;
    progress.expect(solved.len());
    let checks = wanted
        .into_par_iter()
        .zip(solved)
        .map(|((name, attitude, rpm), solved)| {
            let check = Check::of(name, &B218, attitude, rpm, solved.balls[0]);
            progress.done(1);
            check
        });
    Ok(checks.collect())
}

/// What the checks show.
pub fn statements(checks: &[Check]) -> Vec<Statement> {
    let largest = |of: &dyn Fn(&Check) -> f64| checks.iter().fold(0.0, |m, c| worse(m, of(c)));
    let unlike = checks
        .iter()
        .fold(0.0, |m, c| worse(m, (c.ratio() - 1.0).abs()));
    let spin = |rule: &str, race: usize| {
        let of_rule = checks.iter().filter(|c| c.name == rule);
        of_rule.fold(0.0, |m, c| worse(m, c.rolling.spin[race].abs()))
    };
    let other_way = checks
        .iter()
        .map(|c| c.motion_error(-1.0)[0])
        .fold(f64::INFINITY, f64::min);
    vec![
        Statement::ours(
            "The couple that the contacts must supply to the ball is `+Mg e_t`, with `e_t = e_x x e_r`: in size, \
             in sign and in direction, by all three rules, all along the orbit.",
            vec![
                Measure::rounding("couple along `e_t` over `Mg`, less 1", unlike, "", 1e-7),
                Measure::rounding(
                    "largest `|couple - Mg e_t|` over `Mg`",
                    largest(&Check::couple_error),
                    "",
                    1e-7,
                ),
            ],
        ),
        Statement::ours(
            "The contact forces of the solver and friction that supplies this couple keep the ball on its \
             orbit; friction the other way would not.",
            vec![
                Measure::rounding(
                    "force left, over the largest contact force",
                    largest(&|c| c.motion_error(1.0)[0]),
                    "",
                    1e-7,
                ),
                Measure::rounding(
                    "couple left, over the couple",
                    largest(&|c| c.motion_error(1.0)[1]),
                    "",
                    1e-7,
                ),
                Measure::above(
                    "force left with friction reversed, least",
                    100.0 * other_way,
                    "%",
                    0.1,
                ),
            ],
        ),
        Statement::ours(
            "Rolling at both contacts, a ball under outer race control does not spin on the outer race, and one \
             under inner race control does not on the inner race; on the other race it does.",
            vec![
                Measure::rounding(
                    "spin at the outer race over shaft speed, outer race control",
                    spin("outer race control", 1),
                    "",
                    1e-9,
                ),
                Measure::rounding(
                    "at the inner race, inner race control",
                    spin("inner race control", 0),
                    "",
                    1e-9,
                ),
                Measure::above(
                    "at the inner race, outer race control, largest",
                    spin("outer race control", 0),
                    "",
                    0.1,
                ),
                Measure::above(
                    "at the outer race, inner race control, largest",
                    spin("inner race control", 1),
                    "",
                    0.1,
                ),
            ],
        ),
    ]
}

fn figure(check: &Check) -> Figure {
    let pens = [
        Pen(GREEN, Dash::Short, Marker::Disc),
        Pen(BLUE, Dash::None, Marker::Square),
        Pen(VERMILION, Dash::None, Marker::Triangle),
        Pen(INK, Dash::Solid, Marker::None),
        Pen(INK, Dash::Long, Marker::None),
    ];
    let mg = check.ball.gyroscopic_moment;
    let component = |axis: usize| -> Vec<(f64, f64)> {
        let points = check.supplied.iter();
        points
            .map(|s| (s.azimuth.to_degrees(), s.couple[axis]))
            .collect()
    };
    let wanted = |axis: usize| -> Vec<(f64, f64)> {
        let azimuths = (0..=96).map(|i| f64::from(i) * 3.75);
        azimuths
            .map(|a| (a, mg * along_orbit(a.to_radians())[axis]))
            .collect()
    };
    let curve = |pen, line: Vec<(f64, f64)>, marked: bool| Curve {
        pen,
        marks: if marked { line.clone() } else { Vec::new() },
        line,
    };
    let omega_m = check.rolling.cage * 30.0 / PI;
    Figure {
        name: "couple_on_the_orbit",
        title: format!(
            "218, {}, {} rpm: couple on a ball over one orbit",
            check.name,
            thousands(check.rpm)
        ),
        caption: format!(
            "Couple that the contacts must supply to a ball over one revolution of the cage ({} rpm), by \
             integration (markers), and `Mg e_t` (lines), in axes at rest. Regenerate with `{COMMAND}`.",
            with_digits(omega_m, 4)
        ),
        legend: [
            "along x, integrated",
            "along y, integrated",
            "along z, integrated",
            "Mg e_t along y",
            "Mg e_t along z",
        ]
        .iter()
        .zip(pens)
        .map(|(text, pen)| (pen, (*text).to_owned()))
        .collect(),
        columns: 1,
        panels: vec![Panel {
            title: String::new(),
            plane: Plane::Straight {
                x: Axis::from_zero("azimuth of the ball / \u{b0}").every(45.0),
                y: Axis::from_zero("couple / (N m)"),
            },
            curves: vec![
                curve(pens[3], wanted(1), false),
                curve(pens[4], wanted(2), false),
                curve(pens[0], component(0), true),
                curve(pens[1], component(1), true),
                curve(pens[2], component(2), true),
            ],
            nodes: Vec::new(),
        }],
    }
}

/// The chapter.
///
/// # Errors
///
/// A rule without a solution.
pub fn chapter(progress: &dyn Progress) -> anyhow::Result<Chapter> {
    let checks = checks(progress)?;
    let rows = checks.iter().map(|c| {
        let [x, y, _] = c.rolling.rotation;
        vec![
            c.name.to_owned(),
            shown(c.rpm),
            with_digits(c.rolling.cage * 30.0 / PI, 5),
            with_digits(x * 30.0 / PI, 5),
            with_digits(y * 30.0 / PI, 5),
            with_digits(dot(c.supplied[0].couple, along_orbit(0.0)), 6),
            with_digits(c.ball.gyroscopic_moment, 6),
            with_digits(
                0.1 * mass(&c.design) * c.design.ball_diameter.powi(2) * 1e9,
                5,
            ),
        ]
    });
    let table = Table {
        caption: "One ball of the 218 under 17,800 N: its motion in space when it is at +y, and the couple \
                  along the orbit."
            .to_owned(),
        head: [
            "rule",
            "rpm",
            "cage / rpm",
            "rotation along x / rpm",
            "along y / rpm",
            "couple, integrated / (N m)",
            "Mg, solver / (N m)",
            "J / (g mm2)",
        ]
        .map(str::to_owned)
        .into(),
        rows: rows.collect(),
    };
    Ok(Chapter {
        title: "The gyroscopic moment, by integrating a ball's rotation",
        blocks: vec![
            Block::Text(
                "From the solver come contact angles, contact forces and centrifugal force of a ball. The \
                 centrifugal force gives the cage speed, and rolling at both contacts the ball's rotation, \
                 without any rule for its attitude. The ball is 36 points of mass. Its orientation, a \
                 quaternion, is integrated over one orbit in 8,000 steps; positions of the points, \
                 differenced in time, give the angular momentum about the ball's centre, and its \
                 differences the couple (`host_tests/src/validation/gyroscope.rs`). 218, 17,800 N."
                    .to_owned(),
            ),
            Block::Figure(figure(&checks[1])),
            Block::Table(table),
            Block::Statements(statements(&checks)),
        ],
    })
}
