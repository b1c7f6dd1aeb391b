//! A design turned into the numbers the solver works with, in units that suit single precision.
//!
//! | quantity | unit |
//! | --- | --- |
//! | length | `L0`, distance of the groove curvature centres |
//! | force | `K L0^(3/2)`, `K` the constant of both contacts in series |
//! | tilt | `L0 / Rp`, so that a tilt of 1 shifts the groove centre by `L0` |
//! | moment | force unit times `Rp` |
//!
//! The ring's displacement is taken at the plane of the inner groove's curvature centres instead of
//! the bearing centre (`vy = dy + zp tz`, `vz = dz - zp ty`). That makes the curvature centre of ball
//! `j` as simple as it can be,
//! `A = (sin alpha0 + dx + ty sin phi - tz cos phi, cos alpha0 + vy cos phi + vz sin phi)`,
//! and takes the lever arm `zp` out of every ball.

use crate::design::{Design, DesignError, check};
use crate::elementary::{cbrt, sin_cos, sin_cos_turns, sqrt};
use crate::float::Real;
use crate::hertz::HertzContact;
use crate::limits::Grooves;

/// A number and what rounding it to the working precision's coarse grid lost.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Split<T> {
    pub high: T,
    pub low: T,
}

impl<T: Real> Split<T> {
    /// 1, nothing lost.
    pub const ONE: Self = Self {
        high: T::ONE,
        low: T::ZERO,
    };
}

/// Constants of a bearing that do not depend on its balls' azimuths.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Constants<T> {
    /// `(sin alpha0, cos alpha0)`.
    pub n0: [Split<T>; 2],
    /// Groove centre distances `lo / L0` and `li / L0`; their sum is exactly 1.
    pub outer: T,
    pub inner: T,
    /// One over each.
    pub per_outer: T,
    pub per_inner: T,
    /// Their squares.
    pub outer_squared: Split<T>,
    pub inner_squared: Split<T>,
    /// Load-deflection constants of the contacts over that of both in series.
    pub ko: T,
    pub ki: T,
    /// Share of the outer contact in the deformation of a ball at rest, `(K/Ko)^(2/3)`.
    pub outer_share: T,
    /// `D / dm`.
    pub tau: T,
    /// `C (delta_o / delta_i)^2` of the raceway-control-free rule.
    pub moment_ratio: T,
    /// Moment about the groove plane of a unit friction force, `fi D / Rp`.
    pub friction_arm: T,
    /// `m dm / 2` over the force unit: centrifugal force at a cage speed of 1 rad/s.
    pub centrifugal: T,
    /// Ball count.
    pub balls: T,
    /// Axial position of the groove plane over `Rp`.
    pub plane: T,
    /// Units, SI.
    pub length: T,
    pub force: T,
    pub tilt: T,
    pub moment: T,
    /// Ball radius `D / 2`, m.
    pub ball_radius: T,
    /// What the limits are about.
    pub grooves: Grooves<T>,
}

/// Where one ball sits: cosine and sine of its azimuth, and what rounding to the coarse grid leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Azimuth<T> {
    pub cos: T,
    pub sin: T,
    pub cos_low: T,
    pub sin_low: T,
}

/// A bearing of `N` balls, ready to be solved in the precision `T`: immutable, made once, by the
/// compiler where the design is known there.
///
/// ```
/// use spindle_bearing::{Bearing, Design, FreeContact, Material};
/// const B7005C: Bearing<f32, 16> = Bearing::<f32, 16>::checked(&Design {
///     ball_diameter: 6.35e-3,
///     pitch_diameter: 36e-3,
///     inner_groove_factor: 0.515,
///     outer_groove_factor: 0.525,
///     free_contact: FreeContact::Angle(15.0 * core::f64::consts::PI / 180.0),
///     inner_shoulder_angle: Design::HIGHEST_SHOULDER,
///     outer_shoulder_angle: Design::HIGHEST_SHOULDER,
///     first_ball: 0.0,
///     ring: Material::STEEL,
///     ball: Material::STEEL,
/// });
/// assert_eq!(B7005C.ball_count(), 16);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bearing<T, const N: usize> {
    pub(crate) constants: Constants<T>,
    pub(crate) azimuths: [Azimuth<T>; N],
}

impl<T: Real, const N: usize> Bearing<T, N> {
    /// The same as the `const` constructors `Bearing::<f32, N>::new` and `Bearing::<f64, N>::new`,
    /// for code that is generic over the precision.
    ///
    /// # Errors
    ///
    /// The first quantity of the design that is out of its range.
    pub fn build(design: &Design) -> Result<Self, DesignError> {
        T::bearing(design)
    }

    /// Number of balls `N`.
    pub const fn ball_count(&self) -> usize {
        N
    }
}

/// A unit vector whose components are rounded doubles: what each needs beyond that for a length of 1.
/// The deformation of a contact is a small difference of lengths, in which half a unit in the last place
/// counts. Products of the coarse parts are exact, and so is their sum.
const fn beyond_unit([x, y]: [f64; 2]) -> [f64; 2] {
    let (hx, hy) = (Split::<f64>::of(x, 0.0), Split::<f64>::of(y, 0.0));
    let leading = (hx.high * hx.high - 1.0) + hy.high * hy.high;
    let mixed = 2.0 * (hx.high * hx.low + hy.high * hy.low);
    let excess = leading + mixed + (hx.low * hx.low + hy.low * hy.low);
    [-0.5 * excess * x, -0.5 * excess * y]
}

/// The constants in doubles, before rounding to the working precision.
const fn in_double(design: &Design, balls: usize) -> Result<Constants<f64>, DesignError> {
    check!(design.check(balls));
    let (d, dm) = (design.ball_diameter, design.pitch_diameter);
    let (fi, fo) = (design.inner_groove_factor, design.outer_groove_factor);
    let (sin0, cos0) = design.free_contact_angle();
    let [sin_beyond, cos_beyond] = beyond_unit([sin0, cos0]);
    let l0 = design.centre_distance();
    let (li, lo) = ((fi - 0.5) * d, (fo - 0.5) * d);
    let (rp, zp) = (0.5 * dm + li * cos0, li * sin0);
    let gamma = d * cos0 / dm;
    let inner = HertzContact::of_groove(d, gamma, fi, &design.ring, &design.ball);
    let outer = HertzContact::of_groove(d, -gamma, fo, &design.ring, &design.ball);
    let (ki, ko) = (inner.load_deflection, outer.load_deflection);
    let (ci, co) = (1.0 / cbrt(ki * ki), 1.0 / cbrt(ko * ko));
    let flexibility = ci + co;
    let k = 1.0 / (flexibility * sqrt(flexibility));
    let force = k * l0 * sqrt(l0);
    let mass = design.ball.density * core::f64::consts::PI * d * d * d / 6.0;
    // The semi-axis grows with Q^(1/3), hence Q a with K^(4/3) delta^2.
    let moment_ratio = ki * cbrt(ki) * inner.semi_major * inner.elliptic_e
        / (ko * cbrt(ko) * outer.semi_major * outer.elliptic_e);
    const ZERO: Split<f64> = Split {
        high: 0.0,
        low: 0.0,
    };
    Ok(Constants {
        n0: [
            Split {
                high: sin0,
                low: sin_beyond,
            },
            Split {
                high: cos0,
                low: cos_beyond,
            },
        ],
        outer: lo / l0,
        inner: li / l0,
        per_outer: l0 / lo,
        per_inner: l0 / li,
        outer_squared: ZERO,
        inner_squared: ZERO,
        ko: ko / k,
        ki: ki / k,
        outer_share: co / flexibility,
        tau: d / dm,
        moment_ratio,
        friction_arm: fi * d / rp,
        centrifugal: 0.5 * mass * dm / force,
        balls: balls as f64,
        plane: zp / rp,
        length: l0,
        force,
        tilt: l0 / rp,
        moment: force * rp,
        ball_radius: 0.5 * d,
        grooves: Grooves::of(design, &inner, &outer, l0),
    })
}

/// Cosine and sine of every azimuth; exact at the quarters if the first ball is at 0.
const fn azimuth(first: (f64, f64), j: usize, balls: usize) -> (f64, f64) {
    let (s, c) = sin_cos_turns(j as u32, balls as u32);
    let (s0, c0) = first;
    (c * c0 - s * s0, s * c0 + c * s0)
}

macro_rules! bearing {
    ($t:ident) => {
        impl Split<$t> {
            /// The double `x` and what is `beyond` it.
            const fn of(x: f64, beyond: f64) -> Self {
                let high = (x as $t + <$t as Real>::COARSE) - <$t as Real>::COARSE;
                Self {
                    high,
                    low: (x - high as f64 + beyond) as $t,
                }
            }

            /// The square of `x`, to twice the working precision.
            const fn square(x: $t) -> Self {
                let x = Self::of(x as f64, 0.0);
                let leading = Self::of((x.high * x.high) as f64, 0.0);
                Self {
                    high: leading.high,
                    low: leading.low + (2.0 * x.high * x.low + x.low * x.low),
                }
            }
        }

        impl Constants<$t> {
            /// Rounds to the working precision.
            const fn rounded(c: &Constants<f64>) -> Self {
                // The two lengths must add up to 1 exactly, or a contact deformation, which is
                // the small difference of lengths, would inherit their rounding.
                let long = c.outer > 0.5;
                let larger = if long { c.outer } else { c.inner } as $t;
                let outer = if long { larger } else { 1.0 - larger };
                let inner = if long { 1.0 - larger } else { larger };
                Self {
                    n0: [
                        Split::<$t>::of(c.n0[0].high, c.n0[0].low),
                        Split::<$t>::of(c.n0[1].high, c.n0[1].low),
                    ],
                    outer,
                    inner,
                    per_outer: 1.0 / outer,
                    per_inner: 1.0 / inner,
                    outer_squared: Split::<$t>::square(outer),
                    inner_squared: Split::<$t>::square(inner),
                    ko: c.ko as $t,
                    ki: c.ki as $t,
                    outer_share: c.outer_share as $t,
                    tau: c.tau as $t,
                    moment_ratio: c.moment_ratio as $t,
                    friction_arm: c.friction_arm as $t,
                    centrifugal: c.centrifugal as $t,
                    balls: c.balls as $t,
                    plane: c.plane as $t,
                    length: c.length as $t,
                    force: c.force as $t,
                    tilt: c.tilt as $t,
                    moment: c.moment as $t,
                    ball_radius: c.ball_radius as $t,
                    grooves: Grooves::<$t>::rounded(&c.grooves),
                }
            }
        }

        impl<const N: usize> Bearing<$t, N> {
            /// Checks the design and computes everything that does not depend on load and speed,
            /// in doubles, rounded once. A `const fn`.
            ///
            /// # Errors
            ///
            /// The first quantity of the design that is out of its range.
            pub const fn new(design: &Design) -> Result<Self, DesignError> {
                let c = check!(in_double(design, N));
                let constants = Constants::<$t>::rounded(&c);
                let mut azimuths = [Azimuth {
                    cos: 0.0,
                    sin: 0.0,
                    cos_low: 0.0,
                    sin_low: 0.0,
                }; N];
                let (s0, c0) = sin_cos(design.first_ball);
                let mut j = 0;
                while j < N {
                    let (cos, sin) = azimuth((s0, c0), j, N);
                    azimuths[j] = Azimuth {
                        cos: cos as $t,
                        sin: sin as $t,
                        cos_low: Split::<$t>::of(cos, 0.0).low,
                        sin_low: Split::<$t>::of(sin, 0.0).low,
                    };
                    j += 1;
                }
                Ok(Self {
                    constants,
                    azimuths,
                })
            }

            /// The same for a design that the compiler knows: one that cannot be built is a compile
            /// error that names the quantity. For a `const` or a `static`; elsewhere, take
            #[doc = concat!("[`Bearing::<", stringify!($t), ", N>::new`](Bearing::new).")]
            ///
            /// # Panics
            ///
            /// For a design that cannot be built, with [`DesignError::reason`].
            pub const fn checked(design: &Design) -> Self {
                match Self::new(design) {
                    Ok(bearing) => bearing,
                    Err(error) => panic!("{}", error.reason()),
                }
            }
        }
    };
}

bearing!(f32);
bearing!(f64);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Reference;
    use crate::{Design, FreeContact, Material};

    #[test]
    fn the_groove_centres_of_the_unloaded_bearing_are_one_apart_to_twice_the_precision() {
        for i in 0..200 {
            let free_contact = if i % 2 == 0 {
                FreeContact::Angle(f64::from(i) * 3.9e-3)
            } else {
                FreeContact::DiametralClearance(f64::from(i) * 2.1e-7)
            };
            let design = Design {
                ball_diameter: 7.938e-3,
                pitch_diameter: 39.04e-3,
                inner_groove_factor: 0.505 + 1.7e-4 * f64::from(i),
                outer_groove_factor: 0.52,
                free_contact,
                first_ball: 0.0,
                inner_shoulder_angle: Design::HIGHEST_SHOULDER,
                outer_shoulder_angle: Design::HIGHEST_SHOULDER,
                ring: Material::STEEL,
                ball: Material::STEEL,
            };
            let c = Bearing::<f64, 9>::new(&design)
                .expect("these can be built")
                .constants;
            let one = Split {
                high: 1.0,
                low: 0.0,
            };
            let [x, y] = c.n0;
            let centres = Reference::at([x.high, y.high], [x.low, y.low], one);
            assert!(centres.excess.abs() < 1e-22, "{:e}", centres.excess);
            for (length, squared) in [(c.outer, c.outer_squared), (c.inner, c.inner_squared)] {
                let high = length.coarse();
                let alone = Reference::at([high, 0.0], [length - high, 0.0], squared);
                assert!(alone.excess.abs() < 1e-22, "{:e}", alone.excess);
            }
        }
    }
}
