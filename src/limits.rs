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
///
/// See [`Solution::exceedances`](crate::Solution::exceedances) for an example.
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
    /// A row of a spindle has lifted off: no preload is left, and its balls carry no axial force in its direction. Of rows
    /// alone, see [`RowSolution::limits`](crate::RowSolution::limits).
    LiftOff,
}

impl Limit {
    /// All limits, the most serious first.
    pub const ALL: [Self; 7] = [
        Self::PeakPressure,
        Self::Shoulder,
        Self::Truncation,
        Self::Reversal,
        Self::Friction,
        Self::InnerContact,
        Self::LiftOff,
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
            Self::LiftOff => "lift-off",
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

    /// The same with this one in it.
    #[must_use]
    pub const fn with(self, limit: Limit) -> Self {
        Self(self.0 | 1 << limit as u8)
    }

    /// All that are in this one or in the other.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
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
            Limit::LiftOff => f.write_str("row lifted off")?,
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

/// A measure of the angle whose sine and cosine are given that grows with it from -90 to 270
/// degrees; its sine up to 90.
#[inline(always)]
fn grown<T: Real>(sin: T, cos: T) -> T {
    if cos >= T::ZERO {
        sin
    } else {
        T::ONE + T::ONE - sin
    }
}

/// Friction force over contact force. One that is nothing beside the friction must not make an infinity of it.
fn demand<T: Real>([friction, force]: Pair<T>) -> T {
    friction / force.at_least(T::EPSILON * friction)
}

impl<T: Real> Grooves<T> {
    fn of_race(&self, race: Race) -> &Groove<T> {
        match race {
            Race::Inner => &self.inner,
            Race::Outer => &self.outer,
        }
    }

    /// The sine of a contact angle as it counts towards the shoulder: both sides of a deep groove are the side of its
    /// shoulder.
    #[inline(always)]
    fn side(&self, sine: T) -> T {
        if self.symmetric { sine.abs() } else { sine }
    }
}

impl<T: Real> Groove<T> {
    /// Sine of the contact angle less the shoulder's.
    #[inline(always)]
    fn sin_past(&self, [side, cosine]: Pair<T>) -> T {
        side * self.shoulder_cos - cosine * self.shoulder_sin
    }

    /// Its cosine.
    #[inline(always)]
    fn cos_past(&self, [side, cosine]: Pair<T>) -> T {
        cosine * self.shoulder_cos + side * self.shoulder_sin
    }

    /// On the other side only a contact within a quarter turn below the shoulder can reach it; for the rest the sine
    /// means something else.
    #[inline(always)]
    fn reaches(&self, n: Pair<T>) -> bool {
        n[0] > T::ZERO || self.cos_past(n) > T::ZERO
    }
}

/// The contact is on the other side of the groove. `held` by the inner race: without that, the outer contact is radial
/// but for rounding.
#[inline(never)]
fn is_reversed<T: Real>([side, cosine]: Pair<T>, held: bool) -> bool {
    side < T::ZERO && held && grown(-side, cosine) > T::of(64.0) * T::EPSILON
}

/// What a ball off the inner race leaves between the races, in the solver's unit of length.
fn gap<T: Real>([inner, outer]: &[ContactState<T>; 2]) -> T {
    let gap = -(inner.delta + outer.delta.at_most(T::ZERO));
    gap.at_least(T::ZERO)
}

/// The worst contacts of a race, in the solver's units.
///
/// All measures of a contact in one groove grow with its deformation, its angle, or the quotient of two forces: roots and
/// quotients are worked out of the worst alone.
#[derive(Clone, Copy)]
struct Seen<T> {
    /// Largest deformation; 0 if no contact carries.
    depth: T,
    deepest: u16,
    /// Friction and contact force whose quotient is largest.
    demand: Pair<T>,
    slipping: u16,
    /// Largest contact angle, and the measure of it.
    n: Pair<T>,
    angle: T,
    steepest: u16,
}

impl<T: Real> Seen<T> {
    /// Below all that there is.
    fn none() -> Self {
        Self {
            depth: T::ZERO,
            deepest: 0,
            demand: [-T::ONE, T::ONE],
            slipping: 0,
            n: [T::ZERO; 2],
            angle: -(T::ONE + T::ONE),
            steepest: 0,
        }
    }

    /// A contact more than a quarter turn from the groove's plane.
    #[cold]
    #[inline(never)]
    fn note_beyond(&mut self, ball: u16, n: Pair<T>) {
        let angle = grown(n[0], n[1]);
        if n[0] > T::ZERO && angle > self.angle {
            (self.angle, self.n, self.steepest) = (angle, n, ball);
        }
    }
}

/// What one pass over the balls finds.
pub(crate) struct Survey<'s, T> {
    grooves: &'s Grooves<T>,
    limits: &'s Limits<T>,
    inner: Seen<T>,
    outer: Seen<T>,
    truncated: bool,
    reversed: bool,
    /// Balls off the inner race, the one with the largest gap, and that gap.
    off: (u16, u16, T),
}

impl<'s, T: Real> Survey<'s, T> {
    /// Looks at every ball once, its inner and its outer contact, and hands each on with its number.
    #[inline(always)]
    pub(crate) fn of(
        grooves: &'s Grooves<T>,
        limits: &'s Limits<T>,
        balls: impl Iterator<Item = [ContactState<T>; 2]>,
        mut each: impl FnMut(u16, &[ContactState<T>; 2]),
    ) -> Self {
        let mut survey = Self {
            grooves,
            limits,
            inner: Seen::none(),
            outer: Seen::none(),
            truncated: false,
            reversed: false,
            off: (0, 0, T::ZERO),
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
    fn off(&mut self, ball: u16, gap: T) {
        let (balls, worst, largest) = &mut self.off;
        if *balls == 0 || gap > *largest {
            (*worst, *largest) = (ball, gap);
        }
        *balls = balls.saturating_add(1);
    }

    #[inline(always)]
    fn ball(&mut self, ball: u16, contacts: &[ContactState<T>; 2]) {
        let [inner, outer] = contacts;
        let held = inner.q > T::ZERO;
        if held {
            self.contact(ball, Race::Inner, inner, held);
        } else {
            self.off(ball, gap(contacts));
        }
        if outer.q > T::ZERO {
            self.contact(ball, Race::Outer, outer, held);
        }
    }

    // In line, so that the groove is known.
    #[inline(always)]
    fn contact(&mut self, ball: u16, race: Race, k: &ContactState<T>, held: bool) {
        let groove = self.grooves.of_race(race);
        let [sine, cosine] = k.n;
        let side = self.grooves.side(sine);
        let n = [side, cosine];
        let seen = match race {
            Race::Inner => &mut self.inner,
            Race::Outer => &mut self.outer,
        };
        if k.delta > seen.depth {
            (seen.depth, seen.deepest) = (k.delta, ball);
        }
        let friction = k.friction.abs();
        let [most, of] = seen.demand;
        if friction * of > most * k.q {
            (seen.demand, seen.slipping) = ([friction, k.q], ball);
        }
        if cosine > T::ZERO {
            if side > seen.angle {
                (seen.angle, seen.n, seen.steepest) = (side, n, ball);
            }
        } else {
            seen.note_beyond(ball, n);
        }
        // Short of the shoulder, as `Worst::contact` has it, but for the root of the deformation.
        let past = groove.sin_past(n);
        let reach = groove.semi_major * groove.semi_major * k.delta;
        if reach > past * past {
            self.truncated |= groove.reaches(n);
        }
        if side < T::ZERO {
            self.reversed |= is_reversed(n, held);
        }
    }

    fn races(&self) -> [(Race, &'s Groove<T>, &Seen<T>); 2] {
        [
            (Race::Inner, &self.grooves.inner, &self.inner),
            (Race::Outer, &self.grooves.outer, &self.outer),
        ]
    }

    fn pressure(&self) -> Option<Extreme<T>> {
        larger(self.races().map(|(race, groove, seen)| {
            let value = groove.pressure * seen.depth.sqrt();
            (seen.depth > T::ZERO).then_some(Extreme {
                value,
                ball: seen.deepest,
                race,
            })
        }))
    }

    fn friction(&self) -> Option<Extreme<T>> {
        larger(self.races().map(|(race, _, seen)| {
            (seen.depth > T::ZERO).then(|| Extreme {
                value: demand(seen.demand),
                ball: seen.slipping,
                race,
            })
        }))
    }

    /// The measure of the contact angle less the shoulder's, and its sine and cosine.
    fn shoulder(&self) -> Option<(Extreme<T>, Pair<T>)> {
        let [inner, outer] = self.races().map(|(race, groove, seen)| {
            let past = [groove.sin_past(seen.n), groove.cos_past(seen.n)];
            (seen.angle >= -T::ONE && groove.reaches(seen.n)).then(|| {
                let extreme = Extreme {
                    value: grown(past[0], past[1]),
                    ball: seen.steepest,
                    race,
                };
                (extreme, past)
            })
        });
        match (inner, outer) {
            (Some(inner), Some(outer)) if outer.0.value > inner.0.value => Some(outer),
            (inner, outer) => inner.or(outer),
        }
    }

    /// The worst contacts.
    pub(crate) fn extremes(&self) -> Extremes<T> {
        let (off, ball, _) = self.off;
        Extremes {
            pressure: self.pressure(),
            shoulder: self.shoulder().map(|(most, [sin, cos])| Extreme {
                value: sin.atan2(cos),
                ..most
            }),
            friction: self.friction(),
            off: (off, (off > 0).then_some(ball)),
        }
    }

    /// The limits that were passed, by the extremes of the same survey.
    pub(crate) fn limits(&self, extremes: &Extremes<T>) -> LimitSet {
        let above = |extreme: &Option<Extreme<T>>, limit| {
            extreme
                .as_ref()
                .is_some_and(|extreme| extreme.value > limit)
        };
        let passed = |limit: Limit| match limit {
            Limit::PeakPressure => above(&extremes.pressure, self.limits.peak_pressure),
            Limit::Shoulder => above(&extremes.shoulder, T::ZERO),
            // A contact past the shoulder is truncated, too.
            Limit::Truncation => self.truncated || above(&extremes.shoulder, T::ZERO),
            Limit::Reversal => self.reversed,
            Limit::Friction => above(&extremes.friction, self.limits.friction),
            Limit::InnerContact => self.off.0 > 0,
            Limit::LiftOff => false,
        };
        let set = |set, limit| set | u8::from(passed(limit)) << limit as u8;
        LimitSet(Limit::ALL.into_iter().fold(0, set))
    }

    /// The limits that were passed, and where. The balls are those of the survey, and are looked at again only if there
    /// is such a limit. `length` is the unit of deformation, m.
    pub(crate) fn exceedances(
        &self,
        length: T,
        balls: impl Iterator<Item = [ContactState<T>; 2]>,
    ) -> Exceedances<T> {
        let extremes = self.extremes();
        if self.limits(&extremes).is_empty() {
            return Exceedances([None; Limit::ALL.len()]);
        }
        Worst::of(self.grooves, self.limits, balls).exceedances(length, &extremes)
    }
}

/// The larger one; the first of two that are the same.
fn larger<T: Real>([a, b]: [Option<Extreme<T>>; 2]) -> Option<Extreme<T>> {
    match (a, b) {
        (Some(a), Some(b)) if b.value > a.value => Some(b),
        (a, b) => a.or(b),
    }
}

/// The balls past a limit.
#[derive(Clone, Copy)]
struct Tally<T> {
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

impl<T: Real> Tally<T> {
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

/// The balls past each limit.
struct Worst<'s, T> {
    grooves: &'s Grooves<T>,
    limits: &'s Limits<T>,
    found: [Tally<T>; Limit::ALL.len()],
}

impl<'s, T: Real> Worst<'s, T> {
    #[inline(never)]
    fn of(
        grooves: &'s Grooves<T>,
        limits: &'s Limits<T>,
        balls: impl Iterator<Item = [ContactState<T>; 2]>,
    ) -> Self {
        let mut worst = Self {
            grooves,
            limits,
            found: [Tally::NONE; Limit::ALL.len()],
        };
        let mut ball = 0_u16;
        balls.for_each(|contacts| {
            let [inner, outer] = &contacts;
            let held = inner.q > T::ZERO;
            if !held {
                let gap = gap(&contacts);
                worst.note(Limit::InnerContact, ball, Race::Inner, gap, [T::ZERO; 3]);
            }
            worst.contact(ball, Race::Inner, inner, held);
            worst.contact(ball, Race::Outer, outer, held);
            ball = ball.saturating_add(1);
        });
        worst
    }

    fn note(&mut self, limit: Limit, ball: u16, race: Race, rank: T, contact: [T; 3]) {
        self.found[limit as usize].note(ball, race, rank, contact);
    }

    fn contact(&mut self, ball: u16, race: Race, k: &ContactState<T>, held: bool) {
        if !(k.q > T::ZERO) {
            return;
        }
        let groove = self.grooves.of_race(race);
        let root = k.delta.at_least(T::ZERO).sqrt();
        let pressure = groove.pressure * root;
        if pressure > self.limits.peak_pressure {
            self.note(Limit::PeakPressure, ball, race, pressure, [T::ZERO; 3]);
        }
        let demand = demand([k.friction.abs(), k.q]);
        if demand > self.limits.friction {
            self.note(Limit::Friction, ball, race, demand, [T::ZERO; 3]);
        }
        let [sine, cosine] = k.n;
        let n = [self.grooves.side(sine), cosine];
        let semi_major = groove.semi_major * root;
        let contact = [sine, cosine, semi_major];
        if groove.reaches(n) {
            let past = grown(groove.sin_past(n), groove.cos_past(n));
            if past > T::ZERO {
                self.note(Limit::Shoulder, ball, race, past, contact);
            }
            // The shoulder's edge is in the contact's tangential plane, to which the ellipse belongs,
            // at that sine times the groove radius.
            if past + semi_major > T::ZERO {
                self.note(Limit::Truncation, ball, race, past + semi_major, contact);
            }
        }
        if is_reversed(n, held) {
            let reversed = grown(-n[0], cosine);
            self.note(Limit::Reversal, ball, race, reversed, contact);
        }
    }

    fn exceedances(&self, length: T, extremes: &Extremes<T>) -> Exceedances<T> {
        Exceedances(Limit::ALL.map(|limit| self.exceedance(limit, length, extremes)))
    }

    fn exceedance(&self, limit: Limit, length: T, extremes: &Extremes<T>) -> Option<Exceedance<T>> {
        let worst = &self.found[limit as usize];
        if worst.balls == 0 {
            return None;
        }
        // Where quotients are the same but for rounding, the extremes have chosen.
        let extreme = match limit {
            Limit::PeakPressure => extremes.pressure,
            Limit::Friction => extremes.friction,
            _ => None,
        };
        let extreme = extreme.unwrap_or(Extreme {
            value: worst.rank,
            ball: worst.ball,
            race: worst.race,
        });
        let [sin, cos, semi_major] = worst.contact;
        let shoulder = self.grooves.of_race(worst.race).shoulder;
        // A deep groove's negative angles are past its other shoulder.
        let sign = if sin < T::ZERO { -T::ONE } else { T::ONE };
        let side = if self.grooves.symmetric { sign } else { T::ONE };
        let (value, allowed) = match limit {
            Limit::PeakPressure => (extreme.value, self.limits.peak_pressure),
            Limit::Friction => (extreme.value, self.limits.friction),
            Limit::InnerContact | Limit::LiftOff => (extreme.value * length, T::ZERO),
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
            ball: extreme.ball,
            race: extreme.race,
            value,
            allowed,
        })
    }
}
