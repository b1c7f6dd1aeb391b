//! Physical limits that an equilibrium may pass.
//!
//! The equilibrium is not changed by them. They say how far to trust the bearing, and the model, under its load.
//!
//! Nothing here is computed unless [`Solution::exceedances`](crate::Solution::exceedances) or
//! [`Solution::extremes`](crate::Solution::extremes) is called. One pass over the balls
//! compares sines, roots and products; angles are worked out for the worst contact only.

use crate::design::Design;
use crate::elementary::{cbrt, sin_cos, sqrt};
use crate::float::Real;
use crate::hertz::HertzContact;
use crate::linalg::Pair;
use core::fmt;

/// Limits that the design does not give. One that is infinite, or not a number, is never passed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Limits<T> {
    /// Peak contact pressure, Pa.
    pub peak_pressure: T,
    /// Friction force over contact force, `T/Q`. The friction is what carries the gyroscopic
    /// moment; a lubricant that cannot supply it lets the balls slip.
    pub friction: T,
}

impl<T: Real> Limits<T> {
    /// Peak pressure, Pa, that makes up the static load rating of ball bearings (ISO 76:2006).
    ///
    /// 4200 MPa dent ball and raceway together by a ten-thousandth of the ball diameter.
    pub const STATIC_PRESSURE: f64 = 4.2e9;
    /// Peak pressure, Pa, below which bearing steel does not tire: 1500 MPa (ISO 281:2007, fatigue
    /// load limit).
    pub const FATIGUE_PRESSURE: f64 = 1.5e9;
    /// Friction that a lubricated contact can be trusted to have.
    ///
    /// 0.06 to 0.07 suffice to prevent gyroscopic sliding in most ball bearings (Jones 1959, after Harris, Rolling
    /// Bearing Analysis).
    pub const LUBRICATED_FRICTION: f64 = 0.06;

    /// Limits that nothing passes.
    pub(crate) fn none() -> Self {
        let infinite = T::of(f64::INFINITY);
        Self {
            peak_pressure: infinite,
            friction: infinite,
        }
    }
}

impl<T: Real> Default for Limits<T> {
    /// [`Limits::STATIC_PRESSURE`] and [`Limits::LUBRICATED_FRICTION`].
    fn default() -> Self {
        Self {
            peak_pressure: T::of(Self::STATIC_PRESSURE),
            friction: T::of(Self::LUBRICATED_FRICTION),
        }
    }
}

/// One of the two rings' raceways.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Race {
    /// That of the inner ring.
    Inner,
    /// That of the outer ring.
    Outer,
}

impl Race {
    /// `inner` or `outer`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Inner => "inner",
            Self::Outer => "outer",
        }
    }
}

/// A limit that an equilibrium may pass, the most serious first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Limit {
    /// Peak contact pressure, Pa, against [`Limits::peak_pressure`].
    PeakPressure,
    /// The centre of a contact lies past the edge of the shoulder, where there is no groove: contact
    /// angle, rad, against the shoulder's angle.
    Shoulder,
    /// The shoulder truncates a contact: contact angle of the far end of the contact ellipse, rad,
    /// against the shoulder's angle. Beyond it, the true pressure is above the one given here. A
    /// contact past the shoulder is truncated, too.
    Truncation,
    /// A contact on the other side of the groove than the free contact angle: contact angle, rad, against 0.
    ///
    /// An angular contact bearing has a low shoulder there or none. Deep groove bearings carry on both sides, and their
    /// contacts are never reversed.
    Reversal,
    /// Friction force over contact force, `T/Q`, against [`Limits::friction`]: gross slip is to be
    /// suspected.
    Friction,
    /// A ball is off the inner race: its gap between the races, m, against 0.
    InnerContact,
}

impl Limit {
    /// All limits, the most serious first.
    pub const ALL: [Self; 6] = [
        Self::PeakPressure,
        Self::Shoulder,
        Self::Truncation,
        Self::Reversal,
        Self::Friction,
        Self::InnerContact,
    ];

    /// Short name in lower case, as tables print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PeakPressure => "peak-pressure",
            Self::Shoulder => "shoulder",
            Self::Truncation => "truncation",
            Self::Reversal => "reversal",
            Self::Friction => "friction",
            Self::InnerContact => "inner-contact",
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A set of limits, in a byte.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct LimitSet(u8);

impl LimitSet {
    /// One bit for each limit, in the order of [`Limit::ALL`] from the lowest.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether there is none in it.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether this one is in it.
    pub const fn contains(self, limit: Limit) -> bool {
        self.0 & (1 << limit as u8) != 0
    }

    /// The limits in it, the most serious first.
    pub fn iter(self) -> impl Iterator<Item = Limit> {
        Limit::ALL
            .into_iter()
            .filter(move |limit| self.contains(*limit))
    }
}

impl fmt::Debug for LimitSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

/// Names, a blank between two of them.
impl fmt::Display for LimitSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, limit) in self.iter().enumerate() {
            f.write_str(if i == 0 { "" } else { " " })?;
            f.write_str(limit.name())?;
        }
        Ok(())
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for LimitSet {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "[");
        for (i, limit) in self.iter().enumerate() {
            if i > 0 {
                defmt::write!(f, ", ");
            }
            defmt::write!(f, "{}", limit);
        }
        defmt::write!(f, "]");
    }
}

/// A limit that was passed: by how many balls, and the worst of them.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Exceedance<T> {
    /// Which limit.
    pub limit: Limit,
    /// Balls past it, on either race.
    pub balls: u16,
    /// The worst ball, in the order of [`Solution::balls`](crate::Solution::balls).
    pub ball: u16,
    /// The worst ball's race.
    pub race: Race,
    /// What it has there, SI units: see [`Limit`].
    pub value: T,
    /// What is allowed there. Seldom, `value` equals it when rounded.
    pub allowed: T,
}

impl<T: Real> Exceedance<T> {
    /// The same with its numbers rounded to single precision, as reports give it.
    pub fn to_f32(self) -> Exceedance<f32> {
        Exceedance {
            limit: self.limit,
            balls: self.balls,
            ball: self.ball,
            race: self.race,
            value: self.value.to_f32(),
            allowed: self.allowed.to_f32(),
        }
    }
}

impl<T: Real> fmt::Display for Exceedance<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            ball,
            value,
            allowed,
            ..
        } = self;
        let race = self.race.name();
        match self.limit {
            Limit::PeakPressure => write!(
                f,
                "peak pressure {value:.3e} Pa at ball {ball}'s {race} race, above {allowed:.3e}"
            )?,
            Limit::Shoulder => write!(
                f,
                "contact angle {value:.4} rad at ball {ball}'s {race} race, past the shoulder at \
                 {allowed:.4}"
            )?,
            Limit::Truncation => write!(
                f,
                "contact up to {value:.4} rad at ball {ball}'s {race} race, truncated by the \
                 shoulder at {allowed:.4}"
            )?,
            Limit::Reversal => write!(
                f,
                "contact angle {value:.4} rad at ball {ball}'s {race} race, reversed"
            )?,
            Limit::Friction => write!(
                f,
                "friction demand {value:.3} of the force at ball {ball}'s {race} race, above \
                 {allowed:.3}"
            )?,
            Limit::InnerContact => write!(f, "ball {ball} off the {race} race by {value:.3e} m")?,
        }
        let plural = if self.balls == 1 { "" } else { "s" };
        write!(f, " ({} ball{plural})", self.balls)
    }
}

/// The limits that an equilibrium has passed. [`LimitSet`] is the short form.
#[derive(Clone, Copy, PartialEq)]
pub struct Exceedances<T>([Option<Exceedance<T>>; Limit::ALL.len()]);

impl<T: Copy> Exceedances<T> {
    /// Whether no limit was passed.
    pub fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }

    /// A limit's exceedance, if it was passed.
    pub fn get(&self, limit: Limit) -> Option<Exceedance<T>> {
        self.0[limit as usize]
    }

    /// The limits that were passed, the most serious first.
    pub fn iter(&self) -> impl Iterator<Item = Exceedance<T>> + '_ {
        self.0.iter().flatten().copied()
    }

    /// Which limits were passed.
    pub fn limits(&self) -> LimitSet {
        self.iter()
            .fold(LimitSet(0), |set, e| LimitSet(set.0 | (1 << e.limit as u8)))
    }
}

impl<T: Real> fmt::Debug for Exceedances<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

/// One sentence for each limit, separated by semicolons.
impl<T: Real> fmt::Display for Exceedances<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, exceedance) in self.iter().enumerate() {
            f.write_str(if i == 0 { "" } else { "; " })?;
            exceedance.fmt(f)?;
        }
        Ok(())
    }
}

#[cfg(feature = "defmt")]
impl<T: Real> defmt::Format for Exceedances<T> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "[");
        for (i, exceedance) in self.iter().enumerate() {
            if i > 0 {
                defmt::write!(f, ", ");
            }
            defmt::write!(f, "{}", exceedance);
        }
        defmt::write!(f, "]");
    }
}

/// The worst contact in one respect, whether it passes a limit or not.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Extreme<T> {
    /// What it has, SI units.
    pub value: T,
    /// Its ball, in the order of [`Solution::balls`](crate::Solution::balls).
    pub ball: u16,
    /// Its race.
    pub race: Race,
}

/// How near an equilibrium is to its limits: what a monitor follows. `None` where no contact carries.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Extremes<T> {
    /// Highest peak contact pressure, Pa: see [`Limit::PeakPressure`].
    pub pressure: Option<Extreme<T>>,
    /// Contact angle less that of its shoulder, rad, of the contact that is nearest to its shoulder or
    /// farthest past it: see [`Limit::Shoulder`].
    pub shoulder: Option<Extreme<T>>,
    /// Highest friction force over contact force: see [`Limit::Friction`].
    pub friction: Option<Extreme<T>>,
    /// Balls off the inner race, and one of them: see [`Limit::InnerContact`].
    pub off: (u16, Option<u16>),
}

/// Size and place of the contacts in a groove.
///
/// Pressure and axes of a Hertzian contact grow with the cube root of the load. With `Q = K delta^(3/2)`, that is the
/// square root of the deformation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Groove<T> {
    /// Peak pressure over the root of the deformation, Pa.
    pub pressure: T,
    /// Semi-major axis over groove radius and the root of the deformation.
    pub semi_major: T,
    /// Angle of the shoulder's edge, its sine and cosine.
    pub shoulder: T,
    pub shoulder_sin: T,
    pub shoulder_cos: T,
}

/// Both grooves of a bearing, for deformations in units of the solver's length.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Grooves<T> {
    pub inner: Groove<T>,
    pub outer: Groove<T>,
    /// The grooves are the same to either side of the balls.
    pub symmetric: bool,
}

impl Groove<f64> {
    /// The groove of a contact: unit of deformation and groove radius, m, and the shoulder's angle, rad.
    const fn of(contact: &HertzContact, unit: f64, radius: f64, shoulder: f64) -> Self {
        // Load of a deformation of one unit.
        let q = contact.load_deflection * unit * sqrt(unit);
        let (shoulder_sin, shoulder_cos) = sin_cos(shoulder);
        Self {
            pressure: contact.peak_pressure(q),
            semi_major: contact.semi_major * cbrt(q) / radius,
            shoulder,
            shoulder_sin,
            shoulder_cos,
        }
    }
}

impl Grooves<f64> {
    /// The grooves of a design with the contacts `inner` and `outer`, for deformations in a unit given in m.
    pub(crate) const fn of(
        design: &Design,
        inner: &HertzContact,
        outer: &HertzContact,
        unit: f64,
    ) -> Self {
        let d = design.ball_diameter;
        let (ri, ro) = (
            design.inner_groove_factor * d,
            design.outer_groove_factor * d,
        );
        Self {
            inner: Groove::of(inner, unit, ri, design.inner_shoulder_angle),
            outer: Groove::of(outer, unit, ro, design.outer_shoulder_angle),
            symmetric: design.is_symmetric(),
        }
    }
}

macro_rules! rounded {
    ($t:ident) => {
        impl Groove<$t> {
            const fn rounded(exact: &Groove<f64>) -> Self {
                Self {
                    pressure: exact.pressure as $t,
                    semi_major: exact.semi_major as $t,
                    shoulder: exact.shoulder as $t,
                    shoulder_sin: exact.shoulder_sin as $t,
                    shoulder_cos: exact.shoulder_cos as $t,
                }
            }
        }

        impl Grooves<$t> {
            /// Rounds to the working precision.
            pub(crate) const fn rounded(exact: &Grooves<f64>) -> Self {
                Self {
                    inner: Groove::<$t>::rounded(&exact.inner),
                    outer: Groove::<$t>::rounded(&exact.outer),
                    symmetric: exact.symmetric,
                }
            }
        }
    };
}

rounded!(f32);
rounded!(f64);

/// What the limits look at of a contact, in the solver's units.
#[derive(Clone, Copy)]
pub struct ContactState<T> {
    /// Sine and cosine of the contact angle.
    pub n: Pair<T>,
    /// Deformation; negative across a gap.
    pub delta: T,
    /// Contact force, 0 across a gap.
    pub q: T,
    /// Friction force on the ball.
    pub friction: T,
}

/// What is kept of the balls past a limit.
#[derive(Clone, Copy)]
struct Worst<T> {
    balls: u16,
    /// The ball counted last, plus 1.
    counted: u16,
    ball: u16,
    race: Race,
    /// A measure that grows with the excess.
    rank: T,
    /// Sine and cosine of the contact angle, and the ellipse's half-width over the groove radius.
    contact: [T; 3],
}

impl<T: Real> Worst<T> {
    const NONE: Self = Self {
        balls: 0,
        counted: 0,
        ball: 0,
        race: Race::Inner,
        rank: T::ZERO,
        contact: [T::ZERO; 3],
    };

    fn note(&mut self, ball: u16, race: Race, rank: T, contact: [T; 3]) {
        if self.balls == 0 || rank > self.rank {
            *self = Self {
                ball,
                race,
                rank,
                contact,
                ..*self
            };
        }
        // A ball may be past a limit on both races.
        if self.counted != ball + 1 {
            self.counted = ball + 1;
            self.balls += 1;
        }
    }
}

/// A measure of the angle whose sine and cosine are given that grows with it from -90 to 270
/// degrees; its sine up to 90.
fn grown<T: Real>(sin: T, cos: T) -> T {
    if cos >= T::ZERO {
        sin
    } else {
        T::ONE + T::ONE - sin
    }
}

/// What one pass over the balls finds.
pub(crate) struct Survey<'s, T> {
    grooves: &'s Grooves<T>,
    /// Unit of deformation, m.
    length: T,
    limits: &'s Limits<T>,
    found: [Worst<T>; Limit::ALL.len()],
    /// Largest over all contacts that carry: peak pressure, friction over contact force, and the measure
    /// of the contact angle less the shoulder's, with sine and cosine of that angle.
    pressure: Option<Extreme<T>>,
    friction: Option<Extreme<T>>,
    shoulder: Option<(Extreme<T>, Pair<T>)>,
}

/// Notes what is larger than all before.
#[inline(always)]
fn raise<T: Real>(most: &mut Option<Extreme<T>>, value: T, ball: u16, race: Race) {
    if !most.is_some_and(|most| most.value >= value) {
        *most = Some(Extreme { value, ball, race });
    }
}

impl<'s, T: Real> Survey<'s, T> {
    /// Looks at every ball once, its inner and its outer contact, and hands each on with its number. `length` is the
    /// unit of deformation, m.
    #[inline(always)]
    pub(crate) fn of(
        grooves: &'s Grooves<T>,
        length: T,
        limits: &'s Limits<T>,
        balls: impl Iterator<Item = [ContactState<T>; 2]>,
        mut each: impl FnMut(u16, &[ContactState<T>; 2]),
    ) -> Self {
        let mut survey = Self {
            grooves,
            length,
            limits,
            found: [Worst::NONE; Limit::ALL.len()],
            pressure: None,
            friction: None,
            shoulder: None,
        };
        let mut ball = 0_u16;
        balls.for_each(|contacts| {
            each(ball, &contacts);
            survey.ball(ball, &contacts);
            ball = ball.saturating_add(1);
        });
        survey
    }

    #[cold]
    #[inline(never)]
    fn note(&mut self, limit: Limit, ball: u16, race: Race, rank: T, contact: [T; 3]) {
        self.found[limit as usize].note(ball, race, rank, contact);
    }

    fn groove(&self, race: Race) -> &'s Groove<T> {
        match race {
            Race::Inner => &self.grooves.inner,
            Race::Outer => &self.grooves.outer,
        }
    }

    fn ball(&mut self, ball: u16, [inner, outer]: &[ContactState<T>; 2]) {
        let held = inner.q > T::ZERO;
        if !held {
            let gap = -(inner.delta + outer.delta.at_most(T::ZERO));
            let gap = gap.at_least(T::ZERO);
            self.note(Limit::InnerContact, ball, Race::Inner, gap, [T::ZERO; 3]);
        }
        self.contact(ball, Race::Inner, inner, held);
        self.contact(ball, Race::Outer, outer, held);
    }

    // In line, so that the groove is known.
    #[inline(always)]
    fn contact(&mut self, ball: u16, race: Race, k: &ContactState<T>, held: bool) {
        if !(k.q > T::ZERO) {
            return;
        }
        let groove = self.groove(race);
        let root = k.delta.at_least(T::ZERO).sqrt();
        let pressure = groove.pressure * root;
        raise(&mut self.pressure, pressure, ball, race);
        if pressure > self.limits.peak_pressure {
            self.note(Limit::PeakPressure, ball, race, pressure, [T::ZERO; 3]);
        }

        let friction = k.friction.abs();
        // A force that is nothing beside the friction must not make an infinity of the ratio.
        let demand = friction / k.q.at_least(T::EPSILON * friction);
        raise(&mut self.friction, demand, ball, race);
        if demand > self.limits.friction {
            self.note(Limit::Friction, ball, race, demand, [T::ZERO; 3]);
        }

        // Both sides of a deep groove are the side of its shoulder.
        let [sine, cosine] = k.n;
        let side = if self.grooves.symmetric {
            sine.abs()
        } else {
            sine
        };
        let semi_major = groove.semi_major * root;
        let contact = [sine, cosine, semi_major];
        // The contact angle less the shoulder's.
        let sin = side * groove.shoulder_cos - cosine * groove.shoulder_sin;
        let cos = cosine * groove.shoulder_cos + side * groove.shoulder_sin;
        // On the other side only a contact within a quarter turn below the shoulder can reach it;
        // for the rest the sine means something else.
        if side > T::ZERO || cos > T::ZERO {
            let past = grown(sin, cos);
            if !self.shoulder.is_some_and(|(most, _)| most.value >= past) {
                let value = past;
                self.shoulder = Some((Extreme { value, ball, race }, [sin, cos]));
            }
            if past > T::ZERO {
                self.note(Limit::Shoulder, ball, race, past, contact);
            }
            // The shoulder's edge is in the contact's tangential plane, to which the ellipse belongs,
            // at that sine times the groove radius.
            if past + semi_major > T::ZERO {
                self.note(Limit::Truncation, ball, race, past + semi_major, contact);
            }
        }
        // Without an inner contact, the outer one is radial but for rounding.
        let reversed = grown(-side, cosine);
        if held && reversed > T::of(64.0) * T::EPSILON && side < T::ZERO {
            self.note(Limit::Reversal, ball, race, reversed, contact);
        }
    }

    /// The limits that were passed.
    #[cfg(feature = "monitor")]
    pub(crate) fn limits(&self) -> LimitSet {
        let passed = |limit: &Limit| self.found[*limit as usize].balls > 0;
        let bits = Limit::ALL.into_iter().filter(passed);
        LimitSet(bits.fold(0, |set, limit| set | 1 << limit as u8))
    }

    /// The worst contacts.
    pub(crate) fn extremes(&self) -> Extremes<T> {
        let off = &self.found[Limit::InnerContact as usize];
        Extremes {
            pressure: self.pressure,
            shoulder: self.shoulder.map(|(most, [sin, cos])| Extreme {
                value: sin.atan2(cos),
                ..most
            }),
            friction: self.friction,
            off: (off.balls, (off.balls > 0).then_some(off.ball)),
        }
    }

    /// The limits that were passed, and where.
    pub(crate) fn exceedances(&self) -> Exceedances<T> {
        Exceedances(Limit::ALL.map(|limit| self.exceedance(limit)))
    }

    fn exceedance(&self, limit: Limit) -> Option<Exceedance<T>> {
        let worst = &self.found[limit as usize];
        if worst.balls == 0 {
            return None;
        }
        let [sin, cos, semi_major] = worst.contact;
        let shoulder = self.groove(worst.race).shoulder;
        // A deep groove's negative angles are past its other shoulder.
        let sign = if sin < T::ZERO { -T::ONE } else { T::ONE };
        let side = if self.grooves.symmetric { sign } else { T::ONE };
        let (value, allowed) = match limit {
            Limit::PeakPressure => (worst.rank, self.limits.peak_pressure),
            Limit::Friction => (worst.rank, self.limits.friction),
            Limit::InnerContact => (worst.rank * self.length, T::ZERO),
            Limit::Reversal => (sin.atan2(cos), T::ZERO),
            Limit::Shoulder => (sin.atan2(cos), side * shoulder),
            Limit::Truncation => {
                let square = (T::ONE - semi_major * semi_major).at_least(T::ZERO);
                let reach = semi_major.atan2(square.sqrt());
                let reach = reach * side;
                (sin.atan2(cos) + reach, side * shoulder)
            }
        };
        Some(Exceedance {
            limit,
            balls: worst.balls,
            ball: worst.ball,
            race: worst.race,
            value,
            allowed,
        })
    }
}
