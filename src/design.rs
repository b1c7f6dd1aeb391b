//! Design of a bearing, in SI units, and its possible errors.
//!
//! [`Bearing::new`](crate::Bearing::new) checks a [`Design`] and turns it into solver constants. It is a `const fn`: a
//! design written into firmware costs no code. With [`Bearing::const_new`](crate::Bearing::const_new), one that cannot be
//! built does not compile.

use crate::const_math::{sin_cos, sin_cos_turns};
use crate::status::Quantity;

/// Elastic constants and density of a ring or of the balls.
///
/// See [`Design`] for an example.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Young's modulus `E`, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio `nu`.
    pub poissons_ratio: f64,
    /// Density `rho`, kg/m^3. The rings' is for [`Growth::by_rotation`](crate::Growth::by_rotation) alone.
    pub density: f64,
}

impl Material {
    /// Bearing steel: 206 GPa, 0.3, 7850 kg/m^3.
    pub const STEEL: Self = Self {
        youngs_modulus: 206e9,
        poissons_ratio: 0.3,
        density: 7850.0,
    };
    /// Silicon nitride, for the balls of hybrid bearings: 310 GPa, 0.26, 3200 kg/m^3.
    pub const SILICON_NITRIDE: Self = Self {
        youngs_modulus: 310e9,
        poissons_ratio: 0.26,
        density: 3200.0,
    };

    /// `(1 - nu^2) / E`, 1/Pa.
    pub(crate) const fn compliance(&self) -> f64 {
        (1.0 - self.poissons_ratio * self.poissons_ratio) / self.youngs_modulus
    }
}

/// How ball and grooves meet in the unloaded bearing.
///
/// See [`Design`] for an example.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FreeContact {
    /// Free contact angle `alpha0`, rad, of an angular contact bearing.
    ///
    /// Its shoulders are made for a load on the side of that angle only. 0 stands for a deep groove bearing without
    /// clearance.
    Angle(f64),
    /// Diametral clearance `Pd`, m: `cos alpha0 = 1 - Pd / (2 L0)`. A deep groove bearing, with
    /// shoulders alike on both sides.
    ///
    /// Its displacement is measured from the middle of the axial play, where both grooves have one middle plane: a mirrored
    /// load has the mirrored answer. A fit that has closed the play leaves a negative clearance, under which the balls carry
    /// without a load.
    DiametralClearance(f64),
}

/// An angular contact (or deep groove) ball bearing, SI units.
///
/// ```
/// use spindle_bearing::{Design, FreeContact, Material};
///
/// // What a catalogue has ...
/// const S6005C: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// // ... and what is known besides.
/// const HYBRID: Design = Design {
///     inner_groove_factor: 0.52,
///     ball: Material::SILICON_NITRIDE,
///     ..S6005C
/// };
/// const DEEP_GROOVE: Design = Design {
///     free_contact: FreeContact::DiametralClearance(10e-6),
///     ..Design::angular_contact(7.938e-3, 39.04e-3, 0.0)
/// };
/// assert!(HYBRID.check(15).is_ok() && DEEP_GROOVE.check(9).is_ok());
/// assert!(HYBRID.check(30).is_err()); // 30 balls do not fit
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Design {
    /// Ball diameter `D`, m.
    pub ball_diameter: f64,
    /// Pitch diameter `dm`, m.
    pub pitch_diameter: f64,
    /// Inner groove radius over ball diameter `fi`.
    pub inner_groove_factor: f64,
    /// Outer groove radius over ball diameter `fo`.
    pub outer_groove_factor: f64,
    /// Free contact angle, or the clearance that decides it.
    pub free_contact: FreeContact,
    /// Inner shoulder's angle `theta_i`, rad: the contact angle at the edge between inner groove and shoulder.
    ///
    /// The shoulder is that on the side of the free contact angle. A groove is an arc of the radius `f D`. A shoulder of
    /// the height `h` above its bottom begins at `cos theta = 1 - h / (f D)`. [`Design::HIGHEST_SHOULDER`] stands for
    /// one that is not known. The angle has no part in the equilibrium, only in
    /// [`Balls::margins`](crate::Balls::margins).
    pub inner_shoulder_angle: f64,
    /// Outer shoulder's angle `theta_o`, rad, likewise.
    pub outer_shoulder_angle: f64,
    /// Azimuth `phi_0` of the first ball, rad from +y towards +z.
    pub first_ball: f64,
    /// Material of both rings.
    pub ring: Material,
    /// Material of the balls.
    pub ball: Material,
}

/// A design that cannot be built: which quantity, its value, and the range it must lie in.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DesignError {
    /// The quantity at fault.
    pub quantity: Quantity,
    /// Its value (SI; not a number stays not a number).
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub value: f64,
    /// Smallest value allowed.
    pub least: f64,
    /// Largest value allowed.
    pub most: f64,
}

impl DesignError {
    /// Condition that the quantity at fault must fulfil. A literal, for the compiler's error about a design in a
    /// `const`, which has no numbers.
    pub const fn reason(&self) -> &'static str {
        use Quantity as Q;
        if let Some(range) = range_in_words(self.quantity) {
            return range;
        }
        match self.quantity {
            Q::BallDiameter => {
                "ball diameter D must be 0.0001 to 0.2 metres, and the balls must have room beside each other, \
                 D <= dm sin(pi/N)"
            }
            Q::PitchDiameter => "pitch diameter dm must be 1.01 to 10000 ball diameters",
            Q::DiametralClearance => {
                "diametral clearance Pd must be -0.5 to 1.66 times the distance L0 of the groove centres"
            }
            Q::InnerShoulderAngle => {
                "inner shoulder's angle theta_i must be the free contact angle to 90 degrees"
            }
            Q::OuterShoulderAngle => {
                "outer shoulder's angle theta_o must be the free contact angle to 90 degrees"
            }
            Q::SectionCount => "more sections than the shaft has room for",
            Q::SectionStart => {
                "a section of the shaft must begin within 100 metres, and not within another section"
            }
            Q::SectionEnd => {
                "a section of the shaft must end behind its beginning, and within 100 metres"
            }
            Q::OuterDiameter => "outer diameter of a section must be 0.0001 to 2 metres",
            Q::InnerDiameter => {
                "inner diameter of a section must be 0 to 0.999 times its outer one"
            }
            // No quantity of a design.
            _ => "this bearing cannot be built",
        }
    }
}

impl core::fmt::Display for DesignError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "{} is {}, but must lie between {} and {}",
            self.quantity, self.value, self.least, self.most
        )?;
        match self.quantity {
            Quantity::BallDiameter
            | Quantity::PitchDiameter
            | Quantity::SectionStart
            | Quantity::SectionEnd
            | Quantity::OuterDiameter => f.write_str("; lengths are in metres"),
            _ => Ok(()),
        }
    }
}

impl core::error::Error for DesignError {}

/// Quantities whose range is fixed. Its numbers stand here alone: the words for the compiler are made of them.
macro_rules! ranges {
    ($($quantity:ident: $least:literal to $most:literal $unit:literal, $name:literal;)*) => {
        pub(crate) const fn range(quantity: Quantity) -> [f64; 2] {
            match quantity {
                $(Quantity::$quantity => [$least as f64, $most as f64],)*
                _ => [f64::NEG_INFINITY, f64::INFINITY],
            }
        }

        const fn range_in_words(quantity: Quantity) -> Option<&'static str> {
            match quantity {
                $(Quantity::$quantity => {
                    Some(concat!($name, " must be ", $least, " to ", $most, $unit))
                })*
                _ => None,
            }
        }
    };
}

ranges! {
    BallCount: 3 to 1000 "", "ball count N";
    InnerGrooveFactor: 0.501 to 0.7 "", "inner groove factor fi";
    OuterGrooveFactor: 0.501 to 0.7 "", "outer groove factor fo";
    ContactAngle: 0 to 1.4 " rad", "free contact angle alpha0";
    FirstBall: -7 to 7 " rad", "azimuth phi_0 of the first ball";
    RingYoungsModulus: 1e6 to 1e13 " Pa", "Young's modulus E of the rings";
    RingPoissonsRatio: 0 to 0.5 "", "Poisson's ratio nu of the rings";
    BallYoungsModulus: 1e6 to 1e13 " Pa", "Young's modulus Eb of the balls";
    BallPoissonsRatio: 0 to 0.5 "", "Poisson's ratio nub of the balls";
    BallDensity: 1 to 1e5 " kg/m^3", "density rho of the balls";
    ShaftYoungsModulus: 1e6 to 1e13 " Pa", "Young's modulus E of the shaft";
    ShaftPoissonsRatio: 0 to 0.5 "", "Poisson's ratio nu of the shaft";
}

/// [`within`] the fixed range of a quantity.
pub(crate) const fn in_range(quantity: Quantity, value: f64) -> Result<(), DesignError> {
    let [least, most] = range(quantity);
    within(quantity, value, least, most)
}

/// `Ok` if `least <= value <= most`; a value that is not a number is refused, too.
pub(crate) const fn within(
    quantity: Quantity,
    value: f64,
    least: f64,
    most: f64,
) -> Result<(), DesignError> {
    if value >= least && value <= most {
        Ok(())
    } else {
        Err(DesignError {
            quantity,
            value,
            least,
            most,
        })
    }
}

/// `?` for `const fn`.
macro_rules! check {
    ($result:expr) => {
        match $result {
            Ok(value) => value,
            Err(error) => return Err(error),
        }
    };
}
pub(crate) use check;

impl Design {
    /// The angle of a shoulder as high as the groove's radius, rad. No groove reaches further than
    /// this quarter circle. For bearings whose shoulders are not known.
    pub const HIGHEST_SHOULDER: f64 = core::f64::consts::FRAC_PI_2;

    /// An angular contact ball bearing of steel, from a catalogue's data: ball diameter `D` and pitch
    /// diameter `dm` (m), free contact angle (rad).
    ///
    /// Groove factors of 0.515 and 0.525 are assumed, as they are common in spindle bearings, and the highest shoulders.
    /// Better known values take their place:
    ///
    /// ```
    /// use spindle_bearing::{Design, Material};
    ///
    /// const HYBRID: Design = Design {
    ///     outer_groove_factor: 0.52,
    ///     ball: Material::SILICON_NITRIDE,
    ///     ..Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians())
    /// };
    /// ```
    ///
    /// A catalogue with bore, outside diameter, width and `C` alone leaves the balls to a guess. In GMN's series S 60 with bores
    /// of 10 to 100 mm, `dm` is the mean of bore and outside diameter. `D` is 0.27 to 0.30 of their difference, by steps of 1/32
    /// inch. The count is `0.84 pi dm / D`, within one. Of several guesses, take one whose
    /// [`Design::dynamic_load_rating`] is `C` to `1.08 C`. A ball diameter that is off by 3 % puts the
    /// stiffness off by about 1 %.
    pub const fn angular_contact(ball_diameter: f64, pitch_diameter: f64, angle: f64) -> Self {
        Self {
            ball_diameter,
            pitch_diameter,
            inner_groove_factor: 0.515,
            outer_groove_factor: 0.525,
            free_contact: FreeContact::Angle(angle),
            inner_shoulder_angle: Self::HIGHEST_SHOULDER,
            outer_shoulder_angle: Self::HIGHEST_SHOULDER,
            first_ball: 0.0,
            ring: Material::STEEL,
            ball: Material::STEEL,
        }
    }

    /// Distance `L0 = (fi + fo - 1) D` of the groove curvature centres of the unloaded bearing, m.
    pub const fn centre_distance(&self) -> f64 {
        (self.inner_groove_factor + self.outer_groove_factor - 1.0) * self.ball_diameter
    }

    /// Cosine of the free contact angle; 1 where the clearance is negative.
    pub(crate) const fn free_contact_cosine(&self) -> f64 {
        match self.free_contact {
            FreeContact::Angle(angle) => sin_cos(angle).1,
            FreeContact::DiametralClearance(clearance) if clearance > 0.0 => {
                1.0 - clearance / (2.0 * self.centre_distance())
            }
            FreeContact::DiametralClearance(_) => 1.0,
        }
    }

    /// Whether the grooves are the same to either side of the balls.
    pub(crate) const fn is_symmetric(&self) -> bool {
        match self.free_contact {
            FreeContact::Angle(angle) => angle == 0.0,
            FreeContact::DiametralClearance(_) => true,
        }
    }

    /// Checks ball, pitch diameter and grooves, which balls of any number have; the free contact angle, or 0.
    pub(crate) const fn check_form(&self) -> Result<f64, DesignError> {
        use Quantity as Q;
        let (d, dm) = (self.ball_diameter, self.pitch_diameter);
        check!(within(Q::BallDiameter, d, 1e-4, 0.2));
        check!(within(Q::PitchDiameter, dm, 1.01 * d, 1e4 * d));
        let (fi, fo) = (self.inner_groove_factor, self.outer_groove_factor);
        check!(in_range(Q::InnerGrooveFactor, fi));
        check!(in_range(Q::OuterGrooveFactor, fo));
        match self.free_contact {
            FreeContact::Angle(angle) => {
                check!(in_range(Q::ContactAngle, angle));
                Ok(angle)
            }
            FreeContact::DiametralClearance(pd) => {
                // As much as a growth may close; beyond the other end the free contact angle would pass 80 degrees.
                let l0 = self.centre_distance();
                check!(within(Q::DiametralClearance, pd, -0.5 * l0, 1.66 * l0));
                Ok(0.0)
            }
        }
    }

    /// Checks everything that a bearing of `balls` balls needs to exist.
    ///
    /// # Errors
    ///
    /// The first quantity that is out of its range, with its value.
    pub const fn check(&self, balls: usize) -> Result<(), DesignError> {
        use Quantity as Q;
        check!(in_range(Q::BallCount, balls as f64));
        // The unloaded balls, at least, must lie in their grooves.
        let least = check!(self.check_form());
        // Neighbouring balls may touch but not overlap: D <= dm sin(pi/N).
        let room = self.pitch_diameter * sin_cos_turns(1, 2 * balls as u32).0;
        check!(within(Q::BallDiameter, self.ball_diameter, 1e-4, room));
        let most = Self::HIGHEST_SHOULDER;
        let (inner, outer) = (self.inner_shoulder_angle, self.outer_shoulder_angle);
        check!(within(Q::InnerShoulderAngle, inner, least, most));
        check!(within(Q::OuterShoulderAngle, outer, least, most));
        check!(in_range(Q::FirstBall, self.first_ball));
        let (ring, ball) = (&self.ring, &self.ball);
        check!(in_range(Q::RingYoungsModulus, ring.youngs_modulus));
        check!(in_range(Q::RingPoissonsRatio, ring.poissons_ratio));
        check!(in_range(Q::BallYoungsModulus, ball.youngs_modulus));
        check!(in_range(Q::BallPoissonsRatio, ball.poissons_ratio));
        in_range(Q::BallDensity, ball.density)
    }
}
