//! Frequencies at which a bearing's parts pass each other, from the speeds that its balls have under load.

use crate::ball::report::Kinetics;
use crate::bearing::Constants;
use crate::linalg::vector;
use crate::real::Real;

/// Characteristic frequencies of a bearing, Hz. A defect of one of its parts makes vibrations at these and their multiples.
///
/// They follow from the mean cage speed and rotation of the balls that the inner race touches. Formulas with the free contact
/// angle are off by as much as the angles change under load and speed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Frequencies<T> {
    /// Turns of the cage (FTF).
    pub cage: T,
    /// Balls past a point of the outer race (BPFO).
    pub outer_race: T,
    /// Balls past a point of the inner race (BPFI).
    pub inner_race: T,
    /// Turns of a ball, seen from the cage (BSF). A defect of a ball meets both races in each.
    pub ball: T,
}

/// Numbers of balls, with the sums of their cage speeds and of their rotations: of those that the inner race touches, and of all.
pub struct Turns<T>([[T; 3]; 2]);

impl<T: Real> Turns<T> {
    pub fn none() -> Self {
        Self([[T::ZERO; 3]; 2])
    }

    #[inline(always)]
    pub fn take(&mut self, c: &Constants<T>, ball: &Kinetics<T>) {
        let turns = [T::ONE, ball.mu, ball.rotation(c)];
        let carries = ball.inner.delta > T::ZERO;
        for (sums, counts) in self.0.iter_mut().zip([carries, true]) {
            if counts {
                *sums = vector(|i| sums[i] + turns[i]);
            }
        }
    }

    /// On a shaft with the speed `omega`, rad/s.
    pub fn frequencies(&self, c: &Constants<T>, omega: T) -> Frequencies<T> {
        let [held, all] = self.0;
        let [number, cage, ball] = if held[0] > T::ZERO { held } else { all };
        let per_turn = T::of(0.5 / core::f64::consts::PI);
        let hertz = omega * per_turn / number.at_least(T::ONE);
        let (cage, ball) = (cage * hertz, ball * (hertz.abs() / c.tau));
        Frequencies {
            cage,
            outer_race: c.balls * cage.abs(),
            inner_race: c.balls * (omega * per_turn - cage).abs(),
            ball,
        }
    }
}
