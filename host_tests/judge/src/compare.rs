//! How far two solutions of the same bearing lie apart: the one measure of error.
//!
//! | quantity | error |
//! | --- | --- |
//! | displacement | over the largest component; tilts times the pitch radius |
//! | contact angle | rad; only where the contact carries |
//! | force | over the largest contact force; centrifugal forces and `Mg / D` included |
//! | stiffness | of `K_ij`, over `sqrt(abs(K_ii K_jj))` |

use serde::{Deserialize, Deserializer};
use solvers::Answer;
use spindle_bearing::{BallState, Design};

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
    #[serde(deserialize_with = "balls")]
    pub balls: Vec<BallState<f64>>,
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

/// An answer, as far as it is compared: the balls are those of all rows.
impl From<&Answer> for Equilibrium {
    fn from(answer: &Answer) -> Self {
        let balls = answer.rows.iter().flat_map(|row| &row.balls);
        Self {
            displacement: answer.displacement,
            stiffness: answer.stiffness,
            balls: balls.copied().collect(),
        }
    }
}

impl Equilibrium {
    /// Distance of `self` from `truth`, of a bearing of this design.
    ///
    /// # Panics
    ///
    /// If they have different numbers of balls.
    pub fn errors(&self, truth: &Self, design: &Design) -> Errors {
        assert_eq!(self.balls.len(), truth.balls.len(), "number of balls");
        let mut errors = Errors::default();

        let pitch_radius = 0.5 * design.pitch_diameter;
        let unit = [1.0, 1.0, 1.0, pitch_radius, pitch_radius];
        let lengths = |u: &[f64; 5]| -> [f64; 5] { std::array::from_fn(|i| u[i] * unit[i]) };
        let (found, true_one) = (lengths(&self.displacement), lengths(&truth.displacement));
        let largest = true_one.iter().fold(0.0, |m, x| worse(m, x.abs()));
        for (a, b) in found.iter().zip(true_one) {
            errors.displacement = worse(errors.displacement, (a - b).abs() / largest);
        }

        let largest = truth.largest_force();
        for (a, b) in self.balls.iter().zip(&truth.balls) {
            for (turned, pressed, force) in [
                (a.alpha_i - b.alpha_i, b.q_i > 0.0, a.q_i - b.q_i),
                (a.alpha_o - b.alpha_o, b.q_o > 0.0, a.q_o - b.q_o),
            ] {
                if pressed {
                    errors.contact_angle = worse(errors.contact_angle, turned.abs());
                }
                errors.force = worse(errors.force, force.abs() / largest);
            }
            let centrifugal = a.centrifugal_force - b.centrifugal_force;
            let gyroscopic = (a.gyroscopic_moment - b.gyroscopic_moment) / design.ball_diameter;
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
            .fold(0.0, |m, b| worse(worse(m, b.q_i), b.q_o))
    }

    /// Balls off the inner race.
    pub fn unloaded_balls(&self) -> usize {
        self.balls.iter().filter(|b| b.q_i <= 0.0).count()
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

/// Balls as the files of solved cases have them: inner and outer contact angle, inner and outer contact force, `Fc`, `Mg`; the
/// last ones may be left out.
pub fn balls<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<BallState<f64>>, D::Error> {
    let ball = |figures: Vec<f64>| {
        let of = |i: usize| figures.get(i).copied().unwrap_or(0.0);
        // Not made at once: states of the library may grow.
        let mut ball = BallState::default();
        (ball.alpha_i, ball.alpha_o) = (of(0), of(1));
        (ball.q_i, ball.q_o) = (of(2), of(3));
        (ball.centrifugal_force, ball.gyroscopic_moment) = (of(4), of(5));
        ball
    };
    let figures: Vec<Vec<f64>> = Deserialize::deserialize(from)?;
    Ok(figures.into_iter().map(ball).collect())
}
