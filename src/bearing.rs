//! A design turned into the numbers that the solver works with.
//!
//! | quantity | unit |
//! | --- | --- |
//! | length | `L0 / 64`, `L0` the distance of the groove centres of the unloaded bearing |
//! | force | `Ko` times that length to the power 3/2 |
//! | tilt | length unit over `Rp`, so that a tilt of 1 shifts a groove centre by 1 |
//! | moment | force unit times `Rp` |
//!
//! In these units deformations are of the order of 1. Positions are multiples of 1/256, which integers hold
//! exactly, plus small offsets.

use crate::const_math::{cbrt, sin_cos, sin_cos_turns, sqrt};
use crate::design::{Design, DesignError, FreeContact, check, range};
use crate::hertz::HertzContact;
use crate::status::Quantity;

/// Distance of the groove centres, in units of length.
pub const L0: f64 = 64.0;

/// A length that is known to be a certain number of units.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Squared<T> {
    /// Its square in units of 2^-16, rounded.
    pub whole: i32,
    /// Rest that rounding cut off.
    pub rest: T,
}

/// Constants of a bearing that do not depend on its balls' azimuths.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Constants<T> {
    /// Inner groove's centre where the displacement is 0, from the outer one's, over `L0`: sine and cosine of a free contact
    /// angle, or the middle of the play.
    pub n0: [T; 2],
    /// The inner groove's centre in units of length: multiples of 2^-17, and the rest.
    pub centre: [T; 2],
    pub centre_low: [T; 2],
    /// `L0^2 (1 - |n0|^2)`: of the sign of the clearance, 0 where a contact angle is given.
    pub play: T,
    /// Sum of the contact forces without load: 0 unless the clearance is negative.
    pub preload: T,
    /// `lo` and `li`; their sum is exactly 64.
    pub lo: T,
    pub li: T,
    pub lo_squared: Squared<T>,
    pub li_squared: Squared<T>,
    /// `Ki / Ko`.
    pub ki: T,
    /// Load-deflection constant of both contacts in series over `Ko`.
    pub kn: T,
    /// Share of the outer contact in the deformation of a ball at rest, `(Kn/Ko)^(2/3)`.
    pub outer_share: T,
    /// `D / dm`.
    pub tau: T,
    /// `C (delta_o / delta_i)^2` of the raceway-control-free rule.
    pub kw: T,
    /// Moment of a unit friction force, `fi D / Rp`.
    pub friction_arm: T,
    /// `m dm / 2` over the force unit: centrifugal force at a cage speed of 1 rad/s.
    pub inertia: T,
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
    /// The inner and the outer groove, for deformations in units of length.
    pub grooves: [Groove<T>; 2],
    /// They are the same to either side of the balls.
    pub symmetric: bool,
    /// Fingerprint of this bearing: a solver that has solved another one starts cold.
    pub fingerprint: u32,
}

/// A fingerprint with a number mixed into it.
pub const fn mix(fingerprint: u32, bits: u64) -> u32 {
    let mixed = (fingerprint as u64 ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) as u32 ^ (mixed >> 32) as u32
}

/// Size and place of the contacts in a groove, for deformations in units of the solver's length.
///
/// Pressure and axes of a Hertzian contact grow with the cube root of the load. With `Q = K delta^(3/2)`, that is the
/// square root of the deformation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Groove<T> {
    /// Peak pressure over the root of the deformation, Pa.
    pub pressure: T,
    /// Semi-major axis over the root of the deformation, m.
    pub semi_major: T,
    /// Radius, m.
    pub radius: T,
    /// Sine and cosine of the shoulder's angle.
    pub shoulder: [T; 2],
}

impl Groove<f64> {
    /// The groove of a contact: unit of deformation and groove radius, m, and the shoulder's angle, rad.
    const fn of(k: &HertzContact, unit: f64, radius: f64, shoulder: f64) -> Self {
        // Load of a deformation of one unit.
        let q = k.load_deflection * unit * sqrt(unit);
        let (sin, cos) = sin_cos(shoulder);
        Self {
            pressure: k.peak_pressure(q),
            semi_major: k.semi_major * cbrt(q),
            radius,
            shoulder: [sin, cos],
        }
    }
}

/// Where a ball sits: cosine and sine of its azimuth.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Azimuth<T> {
    pub cos: T,
    pub sin: T,
}

/// A bearing of at most `N` balls, ready to be solved in the precision `T`: immutable, made once, by the compiler where
/// the design is known there.
///
/// ```
/// use spindle_bearing::{Bearing, Design};
///
/// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
/// // By the compiler, in single precision: a design that cannot be built does not compile.
/// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
/// // When the program runs, in double precision.
/// let bearing = Bearing::<f64, 15>::new(&DESIGN)?;
/// # Ok::<(), spindle_bearing::DesignError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bearing<T, const N: usize> {
    pub(crate) constants: Constants<T>,
    azimuths: [Azimuth<T>; N],
    /// Number of balls, the first of `azimuths`.
    count: u16,
}

impl<T, const N: usize> Bearing<T, N> {
    /// Azimuths of the balls that there are.
    pub(crate) const fn azimuths(&self) -> &[Azimuth<T>] {
        match self.azimuths.split_at_checked(self.count as usize) {
            Some((there, _)) => there,
            None => &self.azimuths,
        }
    }
}

/// `x` rounded to a multiple of `1 / per`.
const fn round(x: f64, per: f64) -> f64 {
    // 1.5 * 2^52 rounds to integers.
    ((x * per + 6_755_399_441_055_744.0) - 6_755_399_441_055_744.0) / per
}

/// Correction that gives a unit vector of rounded components a length of 1.
const fn beyond_unit([x, y]: [f64; 2]) -> [f64; 2] {
    let (hx, hy) = (round(x, 67_108_864.0), round(y, 67_108_864.0));
    let (lx, ly) = (x - hx, y - hy);
    let leading = (hx * hx - 1.0) + hy * hy;
    let excess = leading + 2.0 * (hx * lx + hy * ly) + (lx * lx + ly * ly);
    [-0.5 * excess * x, -0.5 * excess * y]
}

const fn square(x: f64) -> Squared<f64> {
    let high = round(x, 1_048_576.0);
    let low = x - high;
    let leading = high * high;
    let whole = round(leading, 65_536.0);
    Squared {
        whole: (whole * 65_536.0) as i32,
        rest: (leading - whole) + (2.0 * high * low + low * low),
    }
}

/// The constants in doubles, to be rounded to `single` or to double precision.
const fn in_doubles(
    design: &Design,
    balls: usize,
    single: bool,
) -> Result<Constants<f64>, DesignError> {
    check!(design.check(balls));
    let (d, dm) = (design.ball_diameter, design.pitch_diameter);
    let (fi, fo) = (design.inner_groove_factor, design.outer_groove_factor);
    let l0 = design.centre_distance();
    let cos0 = design.free_contact_cosine();
    // Where the inner groove's centre is, what rounding that lost, and by how much it is nearer than `L0`, or further.
    let (n0, beyond, nearer) = match design.free_contact {
        FreeContact::Angle(angle) => {
            let (sin, cos) = sin_cos(angle);
            ([sin, cos], beyond_unit([sin, cos]), 0.0)
        }
        FreeContact::DiametralClearance(clearance) => {
            let nearer = clearance / (2.0 * l0);
            let left = 1.0 - nearer;
            ([0.0, left], [0.0, (1.0 - left) - nearer], nearer)
        }
    };
    let length = l0 / L0;
    let arm = (fi - 0.5) * d;
    // The two lengths must add up to 64 exactly, or a deformation, which is the small difference of lengths, would
    // inherit their rounding.
    let (lo, li) = (L0 * (fo - 0.5) * d / l0, L0 * arm / l0);
    let (lo, li) = if lo > 0.5 * L0 {
        let lo = if single { lo as f32 as f64 } else { lo };
        (lo, L0 - lo)
    } else {
        let li = if single { li as f32 as f64 } else { li };
        (L0 - li, li)
    };
    let rp = 0.5 * dm + arm * cos0;
    let gamma = d * cos0 / dm;
    let inner = HertzContact::of_groove(d, gamma, fi, &design.ring, &design.ball);
    let outer = HertzContact::of_groove(d, -gamma, fo, &design.ring, &design.ball);
    let (ki, ko) = (inner.load_deflection, outer.load_deflection);
    let flexibility = 1.0 + cbrt(ko * ko) / cbrt(ki * ki);
    let force = ko * length * sqrt(length);
    let mass = design.ball.density * core::f64::consts::PI * d * d * d / 6.0;
    let centre = [round(L0 * n0[0], 131_072.0), round(L0 * n0[1], 131_072.0)];
    let kn = 1.0 / (flexibility * sqrt(flexibility));
    let pressed = if nearer < 0.0 { -L0 * nearer } else { 0.0 };
    let numbers = [
        d,
        dm,
        fi,
        fo,
        n0[0],
        nearer,
        ki,
        ko,
        mass,
        inner.semi_major,
        inner.elliptic_e,
        outer.semi_major,
        outer.elliptic_e,
        design.first_ball,
        balls as f64,
    ];
    let (mut fingerprint, mut i) = (0, 0);
    while i < numbers.len() {
        fingerprint = mix(fingerprint, numbers[i].to_bits());
        i += 1;
    }
    Ok(Constants {
        fingerprint,
        n0,
        play: L0 * L0 * nearer * (2.0 - nearer),
        preload: balls as f64 * kn * pressed * sqrt(pressed),
        centre,
        centre_low: [
            (L0 * n0[0] - centre[0]) + L0 * beyond[0],
            (L0 * n0[1] - centre[1]) + L0 * beyond[1],
        ],
        lo,
        li,
        lo_squared: square(lo),
        li_squared: square(li),
        ki: ki / ko,
        kn,
        outer_share: 1.0 / flexibility,
        tau: d / dm,
        // The semi-axis grows with Q^(1/3), hence Q a with K^(4/3) delta^2.
        kw: ki * cbrt(ki) * inner.semi_major * inner.elliptic_e
            / (ko * cbrt(ko) * outer.semi_major * outer.elliptic_e),
        friction_arm: fi * d / rp,
        inertia: 0.5 * mass * dm / force,
        balls: balls as f64,
        plane: arm * n0[0] / rp,
        length,
        force,
        tilt: length / rp,
        moment: force * rp,
        ball_radius: 0.5 * d,
        grooves: [
            Groove::of(&inner, length, fi * d, design.inner_shoulder_angle),
            Groove::of(&outer, length, fo * d, design.outer_shoulder_angle),
        ],
        symmetric: design.is_symmetric(),
    })
}

/// Cosine and sine of every azimuth; exact at the quarters if the first ball is at 0.
const fn azimuth(first: (f64, f64), j: usize, balls: usize) -> (f64, f64) {
    let (s, c) = sin_cos_turns(j as u32, balls as u32);
    let (s0, c0) = first;
    (c * c0 - s * s0, s * c0 + c * s0)
}

macro_rules! bearing {
    ($t:ident, $single:expr) => {
        impl<const N: usize> Bearing<$t, N> {
            /// Checks the design and computes everything that does not depend on load and speed, in doubles,
            /// rounded once, for `N` balls. A `const fn`.
            ///
            /// # Errors
            ///
            /// The first quantity of the design that is out of its range.
            pub const fn new(design: &Design) -> Result<Self, DesignError> {
                Self::made(design, N)
            }

            pub(crate) const fn made(design: &Design, balls: usize) -> Result<Self, DesignError> {
                if balls > N {
                    let (value, [least, _]) = (balls as f64, range(Quantity::BallCount));
                    let (quantity, most) = (Quantity::BallCount, N as f64);
                    return Err(DesignError {
                        quantity,
                        value,
                        least,
                        most,
                    });
                }
                let c = check!(in_doubles(design, balls, $single));
                const fn rounded(groove: &Groove<f64>) -> Groove<$t> {
                    let [sin, cos] = groove.shoulder;
                    Groove {
                        pressure: groove.pressure as $t,
                        semi_major: groove.semi_major as $t,
                        radius: groove.radius as $t,
                        shoulder: [sin as $t, cos as $t],
                    }
                }
                let constants = Constants {
                    n0: [c.n0[0] as $t, c.n0[1] as $t],
                    play: c.play as $t,
                    preload: c.preload as $t,
                    centre: [c.centre[0] as $t, c.centre[1] as $t],
                    centre_low: [c.centre_low[0] as $t, c.centre_low[1] as $t],
                    lo: c.lo as $t,
                    li: c.li as $t,
                    lo_squared: Squared {
                        whole: c.lo_squared.whole,
                        rest: c.lo_squared.rest as $t,
                    },
                    li_squared: Squared {
                        whole: c.li_squared.whole,
                        rest: c.li_squared.rest as $t,
                    },
                    ki: c.ki as $t,
                    kn: c.kn as $t,
                    outer_share: c.outer_share as $t,
                    tau: c.tau as $t,
                    kw: c.kw as $t,
                    friction_arm: c.friction_arm as $t,
                    inertia: c.inertia as $t,
                    balls: c.balls as $t,
                    plane: c.plane as $t,
                    length: c.length as $t,
                    force: c.force as $t,
                    tilt: c.tilt as $t,
                    moment: c.moment as $t,
                    ball_radius: c.ball_radius as $t,
                    grooves: [rounded(&c.grooves[0]), rounded(&c.grooves[1])],
                    symmetric: c.symmetric,
                    fingerprint: c.fingerprint,
                };
                let mut azimuths = [Azimuth { cos: 0.0, sin: 0.0 }; N];
                let (s0, c0) = sin_cos(design.first_ball);
                let mut j = 0;
                while j < balls {
                    let (cos, sin) = azimuth((s0, c0), j, balls);
                    azimuths[j] = Azimuth {
                        cos: cos as $t,
                        sin: sin as $t,
                    };
                    j += 1;
                }
                Ok(Self {
                    constants,
                    azimuths,
                    count: balls as u16,
                })
            }

            /// [`Self::new`] for a design that the compiler knows: one that cannot be built is a compile error that names
            /// the quantity.
            ///
            /// The precision is written at the call, too, since there is one such function for each:
            /// `Bearing::<f32, 15>::const_new(&DESIGN)`.
            ///
            /// # Panics
            ///
            /// For a design that cannot be built, with [`DesignError::reason`].
            pub const fn const_new(design: &Design) -> Self {
                match Self::new(design) {
                    Ok(bearing) => bearing,
                    Err(error) => panic!("{}", error.reason()),
                }
            }
        }
    };
}

bearing!(f32, true);
bearing!(f64, false);
