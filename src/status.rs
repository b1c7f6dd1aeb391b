//! How a solve can end, how far its figures can be off, and the names of quantities that it can complain of.

use core::fmt;

macro_rules! quantities {
    ($($quantity:ident => $name:literal,)*) => {
        /// A quantity that a design or a measurement gives, by its symbol in the model.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
        #[non_exhaustive]
        pub enum Quantity {
            $(#[doc = concat!($name, ".")] $quantity,)*
        }

        impl Quantity {
            /// Name and unit, as messages print them.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$quantity => $name,)*
                }
            }
        }
    };
}

quantities! {
    BallCount => "ball count N",
    BallDiameter => "ball diameter D (m)",
    PitchDiameter => "pitch diameter dm (m)",
    InnerGrooveFactor => "inner groove factor fi",
    OuterGrooveFactor => "outer groove factor fo",
    ContactAngle => "free contact angle alpha0 (rad)",
    DiametralClearance => "diametral clearance Pd (m)",
    InnerShoulderAngle => "inner shoulder's angle theta_i (rad)",
    OuterShoulderAngle => "outer shoulder's angle theta_o (rad)",
    FirstBall => "azimuth of the first ball phi_0 (rad)",
    RingYoungsModulus => "Young's modulus of the rings (Pa)",
    RingPoissonsRatio => "Poisson's ratio of the rings",
    BallYoungsModulus => "Young's modulus of the balls (Pa)",
    BallPoissonsRatio => "Poisson's ratio of the balls",
    BallDensity => "density of the balls (kg/m^3)",
    Speed => "speed omega (rad/s)",
    Fx => "axial load Fx (N)",
    Fy => "radial load Fy (N)",
    Fz => "radial load Fz (N)",
    My => "tilting moment My (N m)",
    Mz => "tilting moment Mz (N m)",
    Dx => "axial displacement dx (m)",
    Dy => "radial displacement dy (m)",
    Dz => "radial displacement dz (m)",
    Ty => "tilt ty (rad)",
    Tz => "tilt tz (rad)",
    AxialGrowth => "axial growth gx (m)",
    RadialGrowth => "radial growth gr (m)",
    BallGrowth => "growth of the ball diameter gD (m)",
    RowPosition => "position of the row (m)",
    RowDistance => "distance to another row (m)",
    Closure => "closure e of the row (m)",
    PreloadForce => "preload force of the pair (N)",
    SpringForce => "force of the spring (N)",
    SectionCount => "number of sections of the shaft",
    SectionStart => "start of the section (m)",
    SectionEnd => "end of the section (m)",
    OuterDiameter => "outer diameter of the section (m)",
    InnerDiameter => "inner diameter of the section (m)",
    ShaftYoungsModulus => "Young's modulus of the shaft (Pa)",
    ShaftPoissonsRatio => "Poisson's ratio of the shaft",
    AxialSupport => "axial stiffness of the support (N/m)",
    RadialSupport => "radial stiffness of the support (N/m)",
    TiltingSupport => "tilting stiffness of the support (N m/rad)",
    Tolerance => "tolerance of the stiffness",
    LoadPosition => "position of the load, from x = 0 (m)",
}

impl Quantity {
    /// Load and displacement of the five freedoms, and of a sleeve.
    pub(crate) const OF_FREEDOM: [[Self; 2]; 6] = [
        [Self::Fx, Self::Dx],
        [Self::Fy, Self::Dy],
        [Self::Fz, Self::Dz],
        [Self::My, Self::Ty],
        [Self::Mz, Self::Tz],
        [Self::SpringForce, Self::Closure],
    ];

    /// The three growths.
    pub(crate) const OF_GROWTH: [Self; 3] =
        [Self::AxialGrowth, Self::RadialGrowth, Self::BallGrowth];
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// How a solve ended.
///
/// The first two come with an answer, in [`Solution::status`](crate::Solution::status); the third with what `unfinished` returns. The rest are refusals, the `Err`
/// of a solve.
///
/// ```
/// use spindle_bearing::{Bearing, Design, Settings, Solver, Speed};
///
/// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
/// let mut solver = Solver::new();
/// let nonsense = [f32::NAN, 0.0, 0.0, 0.0, 0.0];
/// match solver.solve(&BEARING, nonsense, Speed::rpm(10_000.0), &Settings::default()) {
///     Ok(_) => unreachable!(),
///     Err(status) => println!("{status}"), // names the quantity and its value
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case"),
    serde(bound(
        serialize = "T: crate::serialize::Written",
        deserialize = "T: crate::serialize::Read<'de>"
    ))
)]
#[non_exhaustive]
pub enum Status<T> {
    /// Solved to the tolerance.
    Converged,
    /// As close as the working precision allows, but the last step was still above the tolerance.
    PrecisionLimit,
    /// The iterations, or the time, were used up first. The next solve goes on from there, and `unfinished` of the solver has the
    /// state reached.
    IterationLimit,
    /// Centrifugal force has driven a ball out of the inner groove: the load is too small for the speed.
    ///
    /// Either the start led to no equilibrium, and a ball's contacts are more than 90 degrees apart. Or an
    /// equilibrium has a ball's contacts more than 150 degrees apart, next to the pole of the cage speed. There the model
    /// has several equilibria or none.
    Unseated {
        /// Index of the worst ball; a spindle's balls are counted on from row to row.
        ball: u16,
        /// How far its contact angles are apart, `abs(ai - ao)`, rad.
        apart: T,
    },
    /// An input is not a number, or infinite.
    NotFinite {
        /// Which input.
        quantity: Quantity,
        /// Its value.
        #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
        value: T,
    },
    /// An input lies outside the range in which the model means anything.
    OutOfRange {
        /// Which input.
        quantity: Quantity,
        /// Its value.
        value: T,
        /// Largest magnitude that is accepted.
        limit: T,
    },
    /// No load on the ring, and no negative clearance: it floats, and no position is an answer.
    Unloaded,
    /// The loaded balls leave the ring free to move in some direction: position and stiffness are not determined.
    ///
    /// Mostly, fewer than three balls carry: a single row needs an axial load, or another row that faces it. Held tilts suffice
    /// where two balls carry. On an elastic shaft, the working precision may not tell, either: the estimated error of contact
    /// forces or of the stiffness passes 1.
    Indeterminate {
        /// Number of balls that carry load.
        loaded_balls: u16,
        /// Largest component of the motion that nothing holds, tilts taken at the pitch radius.
        free: Quantity,
    },
    /// No equilibrium was found. That does not prove that there is none; under a small axial load at a high speed, mostly
    /// there is none.
    ///
    /// Said of a problem that has had a start, and all iterations from there on: not where every call is asked another one.
    Diverged {
        /// Unbalanced force relative to the load; 1 where it is not known.
        residual: T,
    },
}

impl<T> Status<T> {
    /// Short name in lower case, as tables and logs print it.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::PrecisionLimit => "precision-limit",
            Self::IterationLimit => "iteration-limit",
            Self::Unseated { .. } => "unseated",
            Self::NotFinite { .. } => "not-finite",
            Self::OutOfRange { .. } => "out-of-range",
            Self::Unloaded => "unloaded",
            Self::Indeterminate { .. } => "indeterminate",
            Self::Diverged { .. } => "diverged",
        }
    }
}

impl<T: fmt::Display + fmt::LowerExp> fmt::Display for Status<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converged => f.write_str("converged"),
            Self::PrecisionLimit => f.write_str("as close as the working precision allows"),
            Self::IterationLimit => f.write_str(
                "the iterations were used up first: solve again to go on, or allow more",
            ),
            Self::Unseated { ball, apart } => write!(
                f,
                "ball {ball} is driven out of the inner groove (contact angles {apart} rad apart): \
                 more axial load or less speed"
            ),
            Self::NotFinite { quantity, value } => write!(f, "{quantity} is {value}"),
            Self::OutOfRange {
                quantity,
                value,
                limit,
            } => write!(
                f,
                "{quantity} is {value:e}, beyond the {limit:e} that the model covers"
            ),
            Self::Unloaded => f.write_str("no load on the ring, which floats in its clearance"),
            Self::Indeterminate {
                free: Quantity::Closure,
                ..
            } => f.write_str("no ball holds the sleeve: more force of the spring"),
            Self::Indeterminate { loaded_balls, free } => {
                write!(
                    f,
                    "{loaded_balls} loaded balls leave the ring free to move, above all in {free}: "
                )?;
                // One ball leaves a ring free to move sideways, too.
                if *loaded_balls > 1 && matches!(free, Quantity::Ty | Quantity::Tz) {
                    f.write_str("hold the tilts, or ")?;
                }
                f.write_str("preload it by an axial load or by a row that faces it")
            }
            Self::Diverged { residual } => write!(
                f,
                "no equilibrium found (residual {residual:e} of the load): a single angular contact row \
                 needs an axial load, more at a higher speed"
            ),
        }
    }
}

impl<T: fmt::Debug + fmt::Display + fmt::LowerExp> core::error::Error for Status<T> {}

/// Estimated errors of a solution, relative.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "T: crate::serialize::Written",
        deserialize = "T: crate::serialize::Read<'de>"
    ))
)]
#[non_exhaustive]
pub struct ErrorEstimate<T> {
    /// Of displacements: of the largest component, tilts taken at the pitch radius.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub displacement: T,
    /// Of contact forces: of the largest.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub force: T,
    /// Of the stiffness: an element's error over the root of the two diagonal elements.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub stiffness: T,
}
