//! Frequencies at which a bearing's parts pass each other, from the speeds that its balls have under load.

use crate::ball::report::BallKinematics;
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

impl<T: Real> Frequencies<T> {
    /// Of `count` balls that turn like this, on a shaft with the speed `omega`, rad/s.
    pub(crate) fn of(balls: impl Iterator<Item = BallKinematics<T>>, count: T, omega: T) -> Self {
        let (mut held, mut all) = ([T::ZERO; 3], [T::ZERO; 3]);
        for ball in balls {
            let carries = ball.inner.peak_pressure > T::ZERO;
            for (sums, counts) in [(&mut held, carries), (&mut all, true)] {
                if counts {
                    sums[0] += T::ONE;
                    sums[1] += ball.cage_speed;
                    sums[2] += ball.rotation;
                }
            }
        }
        let [number, cage, ball] = if held[0] > T::ZERO { held } else { all };
        let per_turn = T::of(0.5 / core::f64::consts::PI);
        let hertz = per_turn / number.at_least(T::ONE);
        let (cage, ball) = (cage * hertz, ball * hertz);
        Self {
            cage,
            outer_race: count * cage.abs(),
            inner_race: count * (omega * per_turn - cage).abs(),
            ball,
        }
    }
}
