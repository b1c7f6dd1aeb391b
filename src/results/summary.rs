//! A solved row at a glance.

use crate::ball::kinematics::Motion;
use crate::linalg::Pair;
use crate::real::Real;
use crate::results::Balls;
use crate::results::frequencies::{Frequencies, Turns};
use crate::results::life::LifeRating;
use crate::results::margins::{Limits, Margins};

/// Contact forces, pressures and angles of a row, its load, frequencies, margins and life, SI units: one pass over the balls.
///
/// A row's frame is its own: x points where an axial load presses its balls. See [`Solution::summary`](crate::Solution::summary)
/// for an example.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "T: Real + crate::serialize::Written",
        deserialize = "T: Real + crate::serialize::Read<'de>"
    ))
)]
#[non_exhaustive]
pub struct RowSummary<T> {
    /// Least and largest force of the inner contacts, N; 0 of a ball off the inner race.
    pub inner_force: [T; 2],
    /// Least and largest force of the outer contacts, N.
    pub outer_force: [T; 2],
    /// Largest peak pressure on the inner and on the outer race, Pa.
    pub peak_pressure: [T; 2],
    /// Least and largest angle of the inner contacts that carry, rad; 0 if none does.
    pub inner_angle: [T; 2],
    /// Least and largest angle of the outer contacts that carry, rad; 0 if none does.
    pub outer_angle: [T; 2],
    /// Axial force and radial forces along y and z of the shaft on the row, N.
    pub force: [T; 3],
    /// Part of the axial force that is preload, N: see [`RowSolution::preload`](crate::RowSolution::preload).
    pub preload: T,
    /// Part of this row in the axial forces and in the radial forces of all rows, as magnitudes. Without such forces it means
    /// nothing: rounding or 0.
    pub load_share: [T; 2],
    /// Frequencies at which damaged parts of the row are heard.
    pub frequencies: Frequencies<T>,
    /// How near the row is to its limits.
    pub margins: Margins<T>,
    /// `L10^(-10/9)`, `L10` in million revolutions: it adds up over rows. See [`RatingLife::of_weight`](crate::RatingLife::of_weight).
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub life_rate: T,
}

/// Least and largest of some numbers.
#[derive(Clone, Copy)]
struct Range<T>([T; 2]);

impl<T: Real> Range<T> {
    fn none() -> Self {
        Self([T::of(f64::INFINITY), T::of(f64::NEG_INFINITY)])
    }

    fn take(&mut self, x: T) {
        self.0 = [self.0[0].at_most(x), self.0[1].at_least(x)];
    }

    fn or_zero(self) -> [T; 2] {
        if self.0[0] <= self.0[1] {
            self.0
        } else {
            [T::ZERO; 2]
        }
    }
}

/// Directions of the least and the largest of some contact angles, as sine and cosine. They lie within half a turn, where a
/// cross product tells which is larger.
#[derive(Clone, Copy)]
struct Directions<T>(Option<[Pair<T>; 2]>);

impl<T: Real> Directions<T> {
    fn take(&mut self, n: Pair<T>) {
        let is_larger = |a: &Pair<T>, b: &Pair<T>| a[0] * b[1] > a[1] * b[0];
        let [least, largest] = self.0.get_or_insert([n; 2]);
        if is_larger(least, &n) {
            *least = n;
        }
        if is_larger(&n, largest) {
            *largest = n;
        }
    }

    fn angles_or_zero(self) -> [T; 2] {
        match self.0 {
            Some(directions) => directions.map(|[sin, cos]| sin.atan2(cos)),
            None => [T::ZERO; 2],
        }
    }
}

impl<T: Real> RowSummary<T> {
    /// Takes preload and shares of the load that the rows have together.
    pub(crate) fn share(rows: &mut [Self], preloads: &[T]) {
        let mut all = [T::TINY; 2];
        for row in rows.iter_mut() {
            let [axial, y, z] = row.force;
            row.load_share = [axial.abs(), (y * y + z * z).sqrt_abs()];
            all = [all[0] + row.load_share[0], all[1] + row.load_share[1]];
        }
        for (row, preload) in rows.iter_mut().zip(preloads) {
            row.preload = *preload;
            let [axial, radial] = row.load_share;
            row.load_share = [axial / all[0], radial / all[1]];
        }
    }

    /// A row without what it shares with other rows.
    pub(crate) fn of<M: Motion>(
        row: &Balls<'_, T, M>,
        limits: &Limits<T>,
        rating: &LifeRating<T>,
    ) -> Self {
        let c = row.c;
        let (mut forces, mut angles) = ([Range::none(); 2], [Directions(None); 2]);
        let (mut peak, mut force) = ([T::ZERO; 2], [T::ZERO; 3]);
        // Sums of the inner forces cubed and of the outer forces to 10/3, in the row's unit of force.
        let (mut inner, mut outer, mut balls) = (T::ZERO, T::ZERO, T::ZERO);
        let mut turns = Turns::none();
        let margins = row.survey(limits, |ball, kinetics| {
            let contacts = [&kinetics.inner, &kinetics.outer];
            for (race, contact) in contacts.into_iter().enumerate() {
                forces[race].take(contact.q * c.force);
                if contact.q > T::ZERO {
                    let pressure = c.grooves[race].pressure * contact.root;
                    peak[race] = peak[race].at_least(pressure);
                    angles[race].take(contact.n);
                }
            }
            let (q, [sin, cos]) = (kinetics.inner.q, kinetics.inner.n);
            inner += q * q * q;
            // In the row's units, the force is the deformation to 3/2.
            let root = kinetics.outer.q * kinetics.outer.delta;
            outer += root * root;
            balls += T::ONE;
            turns.take(c, kinetics);
            let friction = kinetics.friction[0];
            force[0] += c.force * (q * sin + friction * cos);
            if let Some(at) = row.azimuths.get(usize::from(ball)) {
                let outwards = c.force * (q * cos - friction * sin);
                force[1] += outwards * at.cos;
                force[2] += outwards * at.sin;
            }
        });
        let [inner_force, outer_force] = forces.map(Range::or_zero);
        let [inner_angle, outer_angle] = angles.map(Directions::angles_or_zero);
        Self {
            inner_force,
            outer_force,
            peak_pressure: peak,
            inner_angle,
            outer_angle,
            force,
            preload: T::ZERO,
            load_share: [T::ZERO; 2],
            frequencies: turns.frequencies(c, row.speed.as_rad_per_s()),
            margins,
            life_rate: rating.weight(c.force, inner, outer, balls),
        }
    }
}
