//! Input of a solve: checked, and turned into the solver's units.

use super::Given;
use crate::constants::Constants;
use crate::float::Real;
use crate::frame::units;
use crate::growth::Growth;
use crate::mounting::Speed;
use crate::status::{Quantity, Status};

/// Refuses a value that is not finite, or larger in magnitude than `limit`.
pub fn check<T: Real>(quantity: Quantity, value: T, limit: T) -> Result<(), Status<T>> {
    if !value.is_finite() {
        return Err(Status::NotFinite { quantity, value });
    }
    if value.abs() > limit {
        return Err(Status::OutOfRange {
            quantity,
            value,
            limit,
        });
    }
    Ok(())
}

/// What is given of a freedom, in units of force or length.
///
/// Beyond the force that would press all `balls` by the whole groove distance, nothing in the model holds.
#[inline(always)]
pub fn given<T: Real>(
    c: &Constants<T>,
    freedom: usize,
    balls: T,
    given: Given<T>,
) -> Result<Given<T>, Status<T>> {
    let (force, length) = units(c, freedom);
    let [of_load, of_displacement] = Quantity::OF_FREEDOM[freedom];
    match given {
        Given::Load(load) => {
            check(of_load, load, force * balls * T::of(512.0))?;
            Ok(Given::Load(load / force))
        }
        Given::Displacement(u) => {
            check(of_displacement, u, length * T::of(128.0))?;
            Ok(Given::Displacement(u / length))
        }
    }
}

/// The speed, rad/s: at most that where a ball's centrifugal force would press it by the whole groove distance; none of
/// balls that are not `at_speed`.
#[inline(always)]
pub fn omega<T: Real>(c: &Constants<T>, speed: Speed<T>, at_speed: bool) -> Result<T, Status<T>> {
    let limit = if at_speed {
        (T::of(2048.0) / c.inertia).sqrt()
    } else {
        T::ZERO
    };
    check(Quantity::Speed, speed.0, limit)?;
    Ok(speed.0)
}

/// Growth in units of length, at most a quarter of the groove distance each.
pub fn growth<T: Real>(c: &Constants<T>, growth: &Growth<T>) -> Result<Growth<T>, Status<T>> {
    let lengths = [growth.axial, growth.radial, growth.ball];
    for (length, quantity) in lengths.into_iter().zip(Quantity::OF_GROWTH) {
        check(quantity, length, c.length * T::of(16.0))?;
    }
    let per = T::ONE / c.length;
    Ok(Growth {
        axial: growth.axial * per,
        radial: growth.radial * per,
        ball: growth.ball * per,
    })
}

/// Inertia `m dm omega^2 / 2`; 0 where the inertia of `weight` balls is below rounding of loads of the size `size`.
pub fn inertia<T: Real>(c: &Constants<T>, omega: T, weight: T, size: T) -> T {
    let s = c.inertia * omega * omega;
    if size > T::ZERO && s * weight < T::EPSILON * size {
        T::ZERO
    } else {
        s
    }
}
