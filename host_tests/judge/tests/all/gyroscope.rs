//! The gyroscopic moment, from the motion of a ball as a rigid body on its orbit.
//!
//! Nothing here is the solver's algebra. The contact angles, the contact forces and the centrifugal force come from the
//! solver. The centrifugal force gives the cage speed, and rolling at both contacts the ball's rotation. The ball is 36
//! points of mass. Differences of their places in time give the angular momentum, and its differences the couple on the
//! ball. Axes: x along the shaft, y and z radial, at rest in space; the ball starts at +y.

use super::solves::{Question, ask};
use judge::cases::{B218, rad_per_s};
use judge::compare::worse;
use solvers::dispatch::{Attitude, Precision};
use spindle_file::plan::Plan;
use std::array::from_fn;
use std::f64::consts::{PI, TAU};

type V3 = [f64; 3];

const LOAD: [f64; 5] = [17_800.0, 0.0, 0.0, 0.0, 0.0];
const SPEEDS: [f64; 3] = [6_000.0, 10_000.0, 15_000.0];
const RADIUS: f64 = 0.5 * B218.ball_diameter;
const ORBIT: V3 = [0.0, 0.5 * B218.pitch_diameter, 0.0];
const AXIS: V3 = [1.0, 0.0, 0.0];
/// Steps per revolution of the cage between places, and steps between two values of the angular momentum.
const STEPS: f64 = 8_000.0;
const STRIDE: f64 = 20.0;

fn dot(a: V3, b: V3) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross([a, b, c]: V3, [x, y, z]: V3) -> V3 {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// A sum of vectors, each with its factor.
fn sum(terms: &[(f64, V3)]) -> V3 {
    from_fn(|i| terms.iter().map(|(factor, a)| factor * a[i]).sum())
}

fn length(a: V3) -> f64 {
    dot(a, a).sqrt()
}

/// `a` turned about the unit vector `axis` (Rodrigues).
fn turned(a: V3, axis: V3, angle: f64) -> V3 {
    let (sin, cos) = angle.sin_cos();
    let along = (1.0 - cos) * dot(axis, a);
    sum(&[(cos, a), (sin, cross(axis, a)), (along, axis)])
}

/// First derivative from values at -2, -1, 1, 2 steps of `h`; exact to `h^4`.
fn slope(h: f64, value: impl Fn(f64) -> V3) -> V3 {
    let terms = [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)];
    sum(&terms.map(|(i, factor)| (factor / (12.0 * h), value(i * h))))
}

fn mass() -> f64 {
    B218.ball.density * PI * B218.ball_diameter.powi(3) / 6.0
}

/// Places and masses of points with the moments of inertia of the ball: Gauss points along radius and height, four longitudes.
fn points() -> Vec<(V3, f64)> {
    let gauss = [
        (-0.6f64.sqrt(), 5.0 / 18.0),
        (0.0, 8.0 / 18.0),
        (0.6f64.sqrt(), 5.0 / 18.0),
    ];
    let mut points = Vec::new();
    for (r, radial) in gauss {
        let part = 0.5 * (r + 1.0);
        for (height, axial) in gauss {
            let across = (1.0 - height * height).sqrt();
            for quarter in 0..4 {
                let (sin, cos) = (0.3 + TAU * f64::from(quarter) / 4.0).sin_cos();
                let place = [height, across * cos, across * sin].map(|x| x * part * RADIUS);
                // A shell's part of the volume: 3 r^2 dr of a ball of radius 1.
                points.push((place, mass() * 3.0 * part * part * radial * axial * 0.25));
            }
        }
    }
    points
}

/// A ball of the 218 at a speed.
struct Ball {
    shaft: f64,
    /// Contact angles and contact forces, inner and outer.
    angles: [f64; 2],
    forces: [f64; 2],
    centrifugal: f64,
    gyroscopic: f64,
    /// Parts of the friction at the contacts, which add up to 2.
    friction: [f64; 2],
}

impl Ball {
    fn solved(attitude: Attitude, rpm: f64) -> Self {
        let (plan, shaft) = (Plan::alone(&B218, 16), rad_per_s(rpm));
        let question = Question::load(LOAD, shaft);
        let found = ask(&plan, attitude.into(), Precision::F64, &question).unwrap();
        let ball = found.rows[0].balls[0];
        let both = ball.q_i + ball.q_o;
        Self {
            shaft,
            angles: [ball.alpha_i, ball.alpha_o],
            forces: [ball.q_i, ball.q_o],
            centrifugal: ball.centrifugal_force,
            gyroscopic: ball.gyroscopic_moment,
            friction: match attitude {
                Attitude::Outer => [0.0, 2.0],
                Attitude::Inner => [1.0, 1.0],
                Attitude::Raceless => [2.0 * ball.q_i / both, 2.0 * ball.q_o / both],
            },
        }
    }

    /// Contact points from the ball's centre, inner and outer.
    fn contacts(&self) -> [V3; 2] {
        let normal = |angle: f64, r: f64| [r * angle.sin(), r * angle.cos(), 0.0];
        [
            normal(self.angles[0], -RADIUS),
            normal(self.angles[1], RADIUS),
        ]
    }

    /// Cage speed: a mass on a circle, `m omega_m^2 dm / 2`.
    fn cage(&self) -> f64 {
        (self.centrifugal / (mass() * ORBIT[1])).sqrt()
    }

    /// Angular velocity in space: at the contacts, ball and race move alike along the orbit.
    fn rotation(&self) -> V3 {
        let [inner, outer] = self.contacts();
        let travel = self.cage() * ORBIT[1];
        let race = self.shaft * (ORBIT[1] + inner[1]);
        // Speed along z at a contact p: travel + x p_y - y p_x; the outer race rests.
        let det = inner[1] * outer[0] - outer[1] * inner[0];
        let (a, b) = (race - travel, -travel);
        sum(&[(a / det, outer), (-b / det, inner)])
    }

    /// Spin of the ball against inner and outer race, over the shaft speed.
    fn spin(&self) -> [f64; 2] {
        let [inner, outer] = self.contacts();
        let rotation = self.rotation();
        let against_shaft = sum(&[(1.0, rotation), (-self.shaft, AXIS)]);
        [dot(against_shaft, inner), dot(rotation, outer)].map(|w| w / (RADIUS * self.shaft))
    }

    /// Couple about the ball's centre and force on it at a time after it was at +y.
    fn supplied(&self, time: f64) -> [V3; 2] {
        let cage = self.cage();
        // Seen from the cage, the ball turns about an axis at rest.
        let seen = sum(&[(1.0, self.rotation()), (-cage, AXIS)]);
        let rate = length(seen);
        let seen = seen.map(|x| x / rate);
        let place = |p: V3, t: f64| turned(turned(p, seen, rate * t), AXIS, cage * t);
        let h = TAU / cage / STEPS;
        let body = points();
        let momentum = |t: f64| {
            let of_point = |(p, mass): &(V3, f64)| {
                let velocity = slope(h, |step| place(*p, t + step));
                (*mass, cross(place(*p, t), velocity))
            };
            sum(&body.iter().map(of_point).collect::<Vec<_>>())
        };
        let couple = slope(STRIDE * h, |step| momentum(time + step));
        let centre = |t: f64| turned(ORBIT, AXIS, cage * t);
        let velocity = |t: f64| slope(h, |step| centre(t + step));
        let force = slope(STRIDE * h, |step| velocity(time + step));
        [couple, force.map(|x| x * mass())]
    }

    /// Largest difference of the couple from `Mg e_t` with `e_t = e_x x e_r`, over `Mg`, along the orbit.
    fn couple_error(&self) -> f64 {
        let mg = self.gyroscopic;
        (0..16).fold(0.0, |most, k| {
            let azimuth = TAU * f64::from(k) / 16.0;
            let [couple, _] = self.supplied(azimuth / self.cage());
            let along = cross(AXIS, [0.0, azimuth.cos(), azimuth.sin()]);
            worse(most, length(sum(&[(1.0, couple), (-mg, along)])) / mg.abs())
        })
    }

    /// Residual of the ball's equations of motion at +y under contact forces and friction: force over the largest contact
    /// force, and couple over `Mg`. Friction supplies the couple of the motion, times `sense`.
    fn motion_error(&self, sense: f64) -> [f64; 2] {
        let [couple, force] = self.supplied(0.0);
        let (mut left, mut couple_left) = (force, couple);
        for (i, arm) in self.contacts().into_iter().enumerate() {
            // `cross(arm, across)` is `e_z`, the direction of the couple.
            let across = cross([0.0, 0.0, 1.0], arm);
            let friction = 0.5 * sense * self.friction[i] * couple[2] / dot(arm, arm);
            let both = sum(&[(-self.forces[i] / RADIUS, arm), (friction, across)]);
            left = sum(&[(1.0, left), (-1.0, both)]);
            couple_left = sum(&[(1.0, couple_left), (-1.0, cross(arm, both))]);
        }
        let largest = self.forces[0].max(self.forces[1]);
        [length(left) / largest, length(couple_left) / length(couple)]
    }
}

#[test]
fn the_couple_on_a_ball_is_the_gyroscopic_moment() {
    for attitude in [Attitude::Outer, Attitude::Inner, Attitude::Raceless] {
        for rpm in SPEEDS {
            let ball = Ball::solved(attitude, rpm);
            let error = ball.couple_error();
            assert!(error < 1e-7, "{attitude:?}, {rpm} rpm: {error:e}");
            let [force, couple] = ball.motion_error(1.0);
            assert!(
                force < 1e-7 && couple < 1e-7,
                "{attitude:?}, {rpm} rpm: {force:e}, {couple:e}"
            );
            let [reversed, _] = ball.motion_error(-1.0);
            assert!(reversed > 1e-3, "{attitude:?}, {rpm} rpm: {reversed:e}");
        }
    }
}

#[test]
fn a_ball_under_race_control_does_not_spin_on_that_race() {
    for (attitude, controls) in [(Attitude::Inner, 0), (Attitude::Outer, 1)] {
        let spins = SPEEDS.map(|rpm| Ball::solved(attitude, rpm).spin());
        for spin in spins {
            assert!(spin[controls].abs() < 1e-9, "{attitude:?}: {spin:?}");
        }
        assert!(
            spins.iter().any(|spin| spin[1 - controls].abs() > 0.1),
            "{attitude:?}: {spins:?}"
        );
    }
}
