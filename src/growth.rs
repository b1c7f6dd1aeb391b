//! Growth of rings and balls by heat, rotation and fits.

use crate::design::Design;
use crate::real::Real;
use core::ops::{Add, Mul};

/// Growth of rings and balls by heat, rotation and fits, m: the three lengths that the equilibrium needs.
///
/// They come from anywhere, or from [`Growth::by_temperatures`], [`Growth::by_rotation`] and [`Growth::by_fit`]. Each of these is
/// linear: in temperature, square of the speed, or interference. So the compiler can make the growth of one unit, and
/// firmware scales it and adds it up.
///
/// Stiffness constants, masses and the pitch diameter stay the cold bearing's; their change is of the relative
/// order of 1e-4.
///
/// ```
/// use spindle_bearing::{Design, Expansion, Growth};
///
/// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// const PER_KELVIN: Growth<f32> = Growth::by_heat(&DESIGN, &Expansion::STEEL, [1.0, 0.0, 0.5]).to_f32();
/// const PER_SPEED_SQUARED: Growth<f32> = Growth::by_rotation(&DESIGN, 0.02, 1.0).to_f32();
/// let (warmer, omega) = (8.0, 2094.0);
/// let growth = PER_KELVIN * warmer + PER_SPEED_SQUARED * (omega * omega);
/// assert!(growth.radial > 1e-6 && growth.radial < 5e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Growth<T> {
    /// Axial growth `gx` of the inner groove's centre against the outer one's, m.
    pub axial: T,
    /// Radial growth `gr` of the inner groove against the outer one, m.
    pub radial: T,
    /// Growth `gD` of the ball diameter, m.
    pub ball: T,
}

impl<T: Real> Growth<T> {
    /// The cold bearing at rest.
    pub const NONE: Self = Self {
        axial: T::ZERO,
        radial: T::ZERO,
        ball: T::ZERO,
    };
}

impl<T: Real> Add for Growth<T> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            axial: self.axial + other.axial,
            radial: self.radial + other.radial,
            ball: self.ball + other.ball,
        }
    }
}

impl<T: Real> Mul<T> for Growth<T> {
    type Output = Self;

    fn mul(self, by: T) -> Self {
        Self {
            axial: self.axial * by,
            radial: self.radial * by,
            ball: self.ball * by,
        }
    }
}

/// Coefficients of thermal expansion, 1/K.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Expansion {
    /// Of the shaft.
    pub shaft: f64,
    /// Of the housing.
    pub housing: f64,
    /// Of both rings.
    pub ring: f64,
    /// Of the balls.
    pub ball: f64,
}

impl Expansion {
    /// All of bearing steel: 11.5e-6 per K.
    pub const STEEL: Self = Self {
        shaft: 11.5e-6,
        housing: 11.5e-6,
        ring: 11.5e-6,
        ball: 11.5e-6,
    };
    /// Steel with balls of silicon nitride: 3.2e-6 per K.
    pub const HYBRID: Self = Self {
        ball: 3.2e-6,
        ..Self::STEEL
    };
}

impl Design {
    /// Radius of the grooves where the balls touch them in the unloaded bearing, inner and outer, m:
    /// `dm/2 -+ (D/2) cos alpha0`.
    pub(crate) const fn groove_radii(&self) -> [f64; 2] {
        let cos = self.free_contact_cosine();
        let [middle, ball] = [0.5 * self.pitch_diameter, 0.5 * self.ball_diameter * cos];
        [middle - ball, middle + ball]
    }
}

/// A radius from 0 to below `limit`; NaN for any other.
const fn radius_below(radius: f64, limit: f64) -> f64 {
    if radius >= 0.0 && radius < limit {
        radius
    } else {
        f64::NAN
    }
}

impl Growth<f64> {
    /// Growth by heat: inner ring, outer ring and balls this much warmer (K) than where the bearing has its free contact
    /// angle.
    ///
    /// `gr = a_ring (Ti ri - To ro)` with the radii of the grooves, `gD = a_ball Tb D`. The axial growth depends on what
    /// holds the rings, and is 0 here: [`Growth::by_length`].
    pub const fn by_heat(
        design: &Design,
        expansion: &Expansion,
        [inner, outer, balls]: [f64; 3],
    ) -> Self {
        let [ri, ro] = design.groove_radii();
        Self {
            axial: 0.0,
            radial: expansion.ring * (inner * ri - outer * ro),
            ball: expansion.ball * balls * design.ball_diameter,
        }
    }

    /// By the length of shaft and housing, inner and outer side this much warmer (K).
    ///
    /// `gx = reach (a_shaft Ti - a_housing To)`. `reach` (m) is the distance of the row from some point of the set, in the
    /// direction that the row faces. The point is common to all rows, such as their middle: it moves the shaft's axial
    /// displacement alone. Rows back to back have a negative reach, and lose preload when the shaft is the warmer side.
    pub const fn by_length(expansion: &Expansion, reach: f64, [inner, outer]: [f64; 2]) -> Self {
        Self {
            axial: reach * (expansion.shaft * inner - expansion.housing * outer),
            ..Self::NONE
        }
    }

    /// By the temperatures of a spindle: shaft and inner ring, housing and outer ring this much warmer (K).
    ///
    /// The sum of [`Growth::by_heat`], with balls as warm as the mean of both, and of [`Growth::by_length`].
    pub const fn by_temperatures(
        design: &Design,
        expansion: &Expansion,
        reach: f64,
        [inner, outer]: [f64; 2],
    ) -> Self {
        let balls = 0.5 * (inner + outer);
        Self::by_heat(design, expansion, [inner, outer, balls]).with(Self::by_length(
            expansion,
            reach,
            [inner, outer],
        ))
    }

    /// This and another growth together: the sum, for the compiler.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self {
            axial: self.axial + other.axial,
            radial: self.radial + other.radial,
            ball: self.ball + other.ball,
        }
    }

    /// By rotation at `omega` (rad/s) of the inner ring on a hollow shaft of the same material, whose bore has this
    /// diameter (m).
    ///
    /// Ring and shaft are one disc from the bore's radius `a` to the groove's `b`, free at both:
    /// `gr = rho omega^2 b / (4 E) [(3 + nu) a^2 + (1 - nu) b^2]`. S. P. Timoshenko and J. N. Goodier, Theory of
    /// Elasticity, rotating discs. For a solid shaft the bore is 0.
    ///
    /// A bore below 0, or one that reaches the groove, leaves no ring: the growth is NaN, which every solve and the check of
    /// a monitor's settings refuse.
    pub const fn by_rotation(design: &Design, bore_diameter: f64, omega: f64) -> Self {
        let [b, _] = design.groove_radii();
        let a = radius_below(0.5 * bore_diameter, b);
        let ring = &design.ring;
        let nu = ring.poissons_ratio;
        let form = (3.0 + nu) * a * a + (1.0 - nu) * b * b;
        Self {
            radial: ring.density * omega * omega * b / (4.0 * ring.youngs_modulus) * form,
            ..Self::NONE
        }
    }

    /// By the interference of the inner ring on a hollow shaft of the same material.
    ///
    /// Diameters are that of the shaft's `seat` under the ring, and that of its `bore`, 0 for a solid shaft (m). The
    /// `interference` is the difference of the diameters before mounting (m). Two thick-walled cylinders under the
    /// pressure between them (Lame 1852; Timoshenko, Strength of Materials II) widen the groove's radius `b` by
    /// `gr = (interference/2) (b/c) (c^2 - a^2)/(b^2 - a^2)`, with the radii `c` of the seat and `a` of the bore. The seat
    /// grows apart from the shaft at speed: the interference that remains then counts.
    ///
    /// A bore below 0, or one that reaches the seat, or a seat that reaches the groove, has the growth NaN, as in
    /// [`Growth::by_rotation`].
    pub const fn by_fit(
        design: &Design,
        seat_diameter: f64,
        bore_diameter: f64,
        interference: f64,
    ) -> Self {
        let [b, _] = design.groove_radii();
        let seat = radius_below(0.5 * seat_diameter, b);
        let bore = radius_below(0.5 * bore_diameter, seat);
        let hole = bore * bore;
        let widened = (b / seat) * ((seat * seat - hole) / (b * b - hole));
        Self {
            radial: 0.5 * interference * widened,
            ..Self::NONE
        }
    }

    /// In single precision.
    pub const fn to_f32(self) -> Growth<f32> {
        Growth {
            axial: self.axial as f32,
            radial: self.radial as f32,
            ball: self.ball as f32,
        }
    }
}
