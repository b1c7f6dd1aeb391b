//! How far two solutions of the same bearing lie apart: the one measure of error.
//!
//! | quantity | error |
//! | --- | --- |
//! | displacement | over the largest component; tilts times the pitch radius |
//! | contact angle | rad; only where the contact carries |
//! | force | over the largest contact force; centrifugal forces and `Mg / D` included |
//! | stiffness | of `K_ij`, over `sqrt(abs(K_ii K_jj))` |

use serde::Deserialize;
use spindle_bearing::BallState;

/// One contact of a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Race {
    /// Contact angle, rad.
    pub angle: f64,
    /// Contact force, N.
    pub force: f64,
}

/// A ball, as far as it is compared.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(from = "Vec<f64>")]
pub struct Ball {
    /// Contact at the inner race.
    pub inner: Race,
    /// Contact at the outer race.
    pub outer: Race,
    /// `Fc`, N.
    pub centrifugal_force: f64,
    /// `Mg`, N m.
    pub gyroscopic_moment: f64,
}

/// A solution, whoever found it; the letters are as in the files of solved cases.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Equilibrium {
    /// `dx, dy, dz, ty, tz`, m and rad.
    #[serde(rename = "u")]
    pub displacement: [f64; 5],
    /// Stiffness, SI; rows are forces.
    #[serde(rename = "K")]
    pub stiffness: [[f64; 5]; 5],
    /// The balls.
    pub balls: Vec<Ball>,
}

/// Distance of two solutions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Errors {
    /// Of the displacement.
    pub displacement: f64,
    /// Of the contact angles, rad.
    pub contact_angle: f64,
    /// Of the forces.
    pub force: f64,
    /// Of the stiffness.
    pub stiffness: f64,
}

/// The larger one; something that is not a number is larger than everything.
pub fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

impl Errors {
    /// No quantity is further off than allowed.
    pub fn within(self, allowed: Self) -> bool {
        self.displacement <= allowed.displacement
            && self.contact_angle <= allowed.contact_angle
            && self.force <= allowed.force
            && self.stiffness <= allowed.stiffness
    }

    /// All of them times `factor`.
    pub fn times(self, factor: f64) -> Self {
        Self {
            displacement: self.displacement * factor,
            contact_angle: self.contact_angle * factor,
            force: self.force * factor,
            stiffness: self.stiffness * factor,
        }
    }
}

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "displacement {:.1e}, contact angle {:.1e}, force {:.1e}, stiffness {:.1e}",
            self.displacement, self.contact_angle, self.force, self.stiffness
        )
    }
}

impl Equilibrium {
    /// Distance of `self` from `truth`, of a bearing with this ball diameter and pitch radius.
    ///
    /// # Panics
    ///
    /// If they have different numbers of balls.
    pub fn errors(&self, truth: &Self, ball_diameter: f64, pitch_radius: f64) -> Errors {
        assert_eq!(self.balls.len(), truth.balls.len(), "number of balls");
        let mut errors = Errors::default();

        let unit = [1.0, 1.0, 1.0, pitch_radius, pitch_radius];
        let lengths = |u: &[f64; 5]| -> [f64; 5] { std::array::from_fn(|i| u[i] * unit[i]) };
        let (found, true_one) = (lengths(&self.displacement), lengths(&truth.displacement));
        let largest = true_one.iter().fold(0.0, |m, x| worse(m, x.abs()));
        for (a, b) in found.iter().zip(true_one) {
            errors.displacement = worse(errors.displacement, (a - b).abs() / largest);
        }

        let largest = truth.largest_force();
        for (a, b) in self.balls.iter().zip(&truth.balls) {
            for (a, b) in [(a.inner, b.inner), (a.outer, b.outer)] {
                if b.force > 0.0 {
                    errors.contact_angle = worse(errors.contact_angle, (a.angle - b.angle).abs());
                }
                errors.force = worse(errors.force, (a.force - b.force).abs() / largest);
            }
            let centrifugal = a.centrifugal_force - b.centrifugal_force;
            let gyroscopic = (a.gyroscopic_moment - b.gyroscopic_moment) / ball_diameter;
            errors.force = worse(errors.force, centrifugal.abs() / largest);
            errors.force = worse(errors.force, gyroscopic.abs() / largest);
        }

        errors.stiffness = stiffness_error(&self.stiffness, &truth.stiffness);
        errors
    }

    /// Largest component of the displacement, m; tilts times the pitch radius.
    pub fn largest_displacement(&self, pitch_radius: f64) -> f64 {
        let unit = [1.0, 1.0, 1.0, pitch_radius, pitch_radius];
        let lengths = self.displacement.iter().zip(unit).map(|(u, r)| u.abs() * r);
        lengths.fold(0.0, worse)
    }

    /// Largest contact force, N.
    pub fn largest_force(&self) -> f64 {
        self.balls
            .iter()
            .fold(0.0, |m, b| worse(worse(m, b.inner.force), b.outer.force))
    }

    /// Balls off the inner race.
    pub fn unloaded_balls(&self) -> usize {
        self.balls.iter().filter(|b| b.inner.force <= 0.0).count()
    }
}

/// Error of a stiffness matrix, scaled by the true one's diagonal; by the largest of its kind where nothing resists.
pub fn stiffness_error(found: &[[f64; 5]; 5], truth: &[[f64; 5]; 5]) -> f64 {
    let diagonal = |i: usize| match truth[i][i].abs() {
        0.0 => {
            let kind = if i < 3 { 0..3 } else { 3..5 };
            kind.fold(0.0, |m, l| worse(m, truth[l][l].abs()))
        }
        k => k,
    };
    let mut error = 0.0;
    for i in 0..5 {
        for j in (0..5).filter(|j| found[i][*j] != truth[i][*j]) {
            let scale = (diagonal(i) * diagonal(j)).sqrt();
            error = worse(error, (found[i][j] - truth[i][j]).abs() / scale);
        }
    }
    error
}

/// The first of the six figures; the others are 0.
impl From<Vec<f64>> for Ball {
    fn from(figures: Vec<f64>) -> Self {
        Self::from(std::array::from_fn(|i| {
            figures.get(i).copied().unwrap_or(0.0)
        }))
    }
}

/// Inner and outer contact angle, inner and outer contact force, `Fc`, `Mg`.
impl From<[f64; 6]> for Ball {
    fn from([alpha_i, alpha_o, q_i, q_o, fc, mg]: [f64; 6]) -> Self {
        let race = |angle, force| Race { angle, force };
        Self {
            inner: race(alpha_i, q_i),
            outer: race(alpha_o, q_o),
            centrifugal_force: fc,
            gyroscopic_moment: mg,
        }
    }
}

impl From<&BallState<f64>> for Ball {
    fn from(b: &BallState<f64>) -> Self {
        let (fc, mg) = (b.centrifugal_force, b.gyroscopic_moment);
        Self::from([b.alpha_i, b.alpha_o, b.q_i, b.q_o, fc, mg])
    }
}
