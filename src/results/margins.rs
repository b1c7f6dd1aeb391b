//! Physical limits that an equilibrium may pass.
//!
//! The equilibrium is not changed by them. They say how far to trust the bearing, and the model, under its load.
//!
//! One pass over the balls finds the worst contact of each limit, whether it passes the limit or not.

use crate::ball::report::Kinetics;
use crate::bearing::Constants;
use crate::linalg::Pair;
use crate::real::Real;
use core::fmt;

/// Limits that the design does not give. One that is infinite, or not a number, is never passed.
///
/// See [`Balls::margins`](crate::Balls::margins) for an example.
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
pub struct Limits<T> {
    /// Peak contact pressure, Pa.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub peak_pressure: T,
    /// Friction force over contact force, `T/Q`. The friction carries the gyroscopic moment: a lubricant that cannot
    /// supply it lets the balls slip.
    #[cfg_attr(feature = "serde", serde(with = "crate::serialize::number"))]
    pub friction: T,
}

impl<T: Real> Limits<T> {
    /// Peak pressure that makes up the static load rating of ball bearings: 4.2 GPa (ISO 76:2006).
    ///
    /// It dents ball and raceway together by a ten-thousandth of the ball diameter.
    pub const STATIC_PRESSURE: T = T::STATIC_PRESSURE;
    /// Peak pressure below which bearing steel does not tire: 1.5 GPa (ISO 281:2007, fatigue load limit).
    pub const FATIGUE_PRESSURE: T = T::FATIGUE_PRESSURE;
    /// Friction that a lubricated contact can be trusted to have: 0.06.
    ///
    /// 0.06 to 0.07 suffice to prevent gyroscopic sliding in most ball bearings (Jones 1959, after Harris, Rolling
    /// Bearing Analysis).
    pub const LUBRICATED_FRICTION: T = T::LUBRICATED_FRICTION;
    /// [`Limits::STATIC_PRESSURE`] and [`Limits::LUBRICATED_FRICTION`].
    pub const DEFAULT: Self = Self {
        peak_pressure: Self::STATIC_PRESSURE,
        friction: Self::LUBRICATED_FRICTION,
    };
}

impl<T: Real> Default for Limits<T> {
    /// [`Limits::DEFAULT`].
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// One of the two rings' raceways.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Race {
    /// Raceway of the inner ring.
    Inner,
    /// Raceway of the outer ring.
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

/// Limits that an equilibrium may pass, by numbers that stay: a contact's value, and its bound. A new one takes the next number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
#[non_exhaustive]
pub enum Limit {
    /// Peak contact pressure, Pa, against [`Limits::peak_pressure`].
    PeakPressure = 0,
    /// Contact angle less the shoulder's angle, rad, against 0: past the edge of the shoulder there is no groove.
    /// A contact on the other side of the groove counts within a quarter turn of the shoulder.
    Shoulder = 1,
    /// Length that the shoulder's edge cuts off the contact ellipse, m, against 0; negative for a margin.
    /// A truncated contact has a higher pressure than the one given here. A contact past the shoulder is truncated, too.
    Truncation = 2,
    /// Sine of the angle of a contact that lies on the other side than the free contact angle, against 0.
    ///
    /// An angular contact bearing has a low shoulder there or none. Deep groove bearings carry on both sides, and
    /// their contacts are never reversed.
    Reversal = 3,
    /// Friction force over contact force, `T/Q`, against [`Limits::friction`]: gross slip is to be suspected.
    Friction = 4,
    /// Gap between the races of a ball that is off the inner one, m, against 0. A ball without a gap may be off, too.
    InnerContact = 5,
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

/// A set of limits, in a byte.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct LimitSet(u8);

impl LimitSet {
    /// One bit for each limit: two to the power of its number.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether there is none in it.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether this limit is in the set.
    pub const fn contains(self, limit: Limit) -> bool {
        self.0 & (1 << limit as u8) != 0
    }

    /// The set with this limit added.
    #[must_use]
    pub const fn with(self, limit: Limit) -> Self {
        Self(self.0 | 1 << limit as u8)
    }

    /// Limits in either set.
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
        for limit in self.iter() {
            defmt::write!(f, "{} ", limit);
        }
    }
}

/// The worst contact in view of one [`Limit`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Margin<T> {
    /// Its value, SI units: see [`Limit`].
    pub value: T,
    /// Its ball, in the order of [`Balls::balls`](crate::Balls::balls).
    pub ball: u16,
    /// Its race.
    pub race: Race,
}

/// How near an equilibrium is to its limits, and which are passed: see [`Balls::margins`](crate::Balls::margins).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(
        from = "MarginsData<T>",
        into = "MarginsData<T>",
        bound(
            serialize = "T: Real + crate::serialize::Written",
            deserialize = "T: Real + crate::serialize::Read<'de>"
        )
    )
)]
pub struct Margins<T> {
    limits: Limits<T>,
    /// One for each limit, by its number; of minus infinity where there is none.
    worst: [Margin<T>; Limit::ALL.len()],
    /// Sine and cosine of the shoulder's margin: `worst` has a measure that grows with it.
    past: Pair<T>,
    /// Number of balls off the inner race.
    pub unloaded: u16,
}

/// Grows with an angle from -90 to 270 degrees, of this sine and cosine: up to 90 degrees the sine.
#[inline(always)]
fn measure<T: Real>([sin, cos]: Pair<T>) -> T {
    if cos < T::ZERO {
        T::ONE + T::ONE - sin
    } else {
        sin
    }
}

impl<T: Real> Margins<T> {
    /// The contact nearest to a limit, or farthest beyond it; `None` if none could pass it.
    pub fn get(&self, limit: Limit) -> Option<Margin<T>> {
        let margin = self.worst[limit as usize];
        let value = match limit {
            Limit::Shoulder => self.past[0].atan2(self.past[1]),
            _ => margin.value,
        };
        (margin.value > T::of(f64::NEG_INFINITY)).then_some(Margin { value, ..margin })
    }

    /// The limits whose margins are above the allowed values.
    pub fn passed(&self) -> LimitSet {
        let passed = |limit: &Limit| self.worst[*limit as usize].value > self.allowed(*limit);
        let all = Limit::ALL.into_iter().filter(passed);
        all.fold(LimitSet::default(), LimitSet::with)
    }

    fn allowed(&self, limit: Limit) -> T {
        match limit {
            Limit::PeakPressure => self.limits.peak_pressure,
            Limit::Friction => self.limits.friction,
            _ => T::ZERO,
        }
    }

    /// Margins without a ball.
    pub(crate) fn new(limits: Limits<T>) -> Self {
        let none = Margin {
            value: T::of(f64::NEG_INFINITY),
            ball: 0,
            race: Race::Inner,
        };
        Self {
            limits,
            worst: [none; Limit::ALL.len()],
            past: [T::ZERO; 2],
            unloaded: 0,
        }
    }

    /// Takes a ball.
    #[inline(always)]
    pub(crate) fn take(&mut self, c: &Constants<T>, ball: u16, kinetics: &Kinetics<T>) {
        self.contact(c, kinetics, (ball, Race::Inner));
        self.contact(c, kinetics, (ball, Race::Outer));
        if !(kinetics.inner.q > T::ZERO) {
            self.unloaded = self.unloaded.saturating_add(1);
            let depth = kinetics.inner.delta + kinetics.outer.delta.at_most(T::ZERO);
            // A gap of 0 is above the limit, too.
            let gap = (-depth * c.length).at_least(T::TINY);
            self.note(Limit::InnerContact, gap, (ball, Race::Inner));
        }
    }

    // In line, so that the race is known.
    #[inline(always)]
    fn contact(&mut self, c: &Constants<T>, kinetics: &Kinetics<T>, at: (u16, Race)) {
        let ([inner, outer], [i, o]) = (&c.grooves, kinetics.friction.map(T::abs));
        let (groove, k, friction) = match at.1 {
            Race::Inner => (inner, &kinetics.inner, i),
            Race::Outer => (outer, &kinetics.outer, o),
        };
        if !(k.q > T::ZERO) {
            return;
        }
        self.note(Limit::PeakPressure, groove.pressure * k.root, at);
        if friction > self.worst[Limit::Friction as usize].value * k.q {
            // A force that is nothing beside the friction must not make an infinity of it.
            let demand = friction / k.q.at_least(T::EPSILON * friction);
            self.note(Limit::Friction, demand, at);
        }
        let ([sin, cos], [s, r]) = (k.n, groove.shoulder);
        let side = if c.symmetric { sin.abs() } else { sin };
        let past = [side * r - cos * s, cos * r + side * s];
        let mut grown = past[0];
        if !(side > T::ZERO && cos > T::ZERO) {
            // Without an inner contact, the outer one is radial but for rounding.
            if kinetics.inner.q > T::ZERO && -side > T::of(64.0) * T::EPSILON {
                self.note(Limit::Reversal, -side, at);
            }
            if !(side > T::ZERO || past[1] > T::ZERO) {
                return;
            }
            grown = measure(past);
        }
        if self.note(Limit::Shoulder, grown, at) {
            self.past = past;
        }
        // The edge is in the contact's tangential plane, as is the ellipse.
        let end = groove.semi_major * k.root + groove.radius * grown;
        self.note(Limit::Truncation, end, at);
    }

    /// Takes a value if it is worse than all before.
    #[inline(always)]
    fn note(&mut self, limit: Limit, value: T, (ball, race): (u16, Race)) -> bool {
        let worst = &mut self.worst[limit as usize];
        let worse = value > worst.value;
        if worse {
            *worst = Margin { value, ball, race };
        }
        worse
    }
}

/// One sentence for each limit that is passed, separated by semicolons.
impl<T: Real> fmt::Display for Margins<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let passed = self
            .passed()
            .iter()
            .filter_map(|limit| Some((limit, self.get(limit)?)));
        for (i, (limit, Margin { value, ball, race })) in passed.enumerate() {
            let (what, unit) = match limit {
                Limit::PeakPressure => ("peak pressure", " Pa"),
                Limit::Shoulder => ("contact past the shoulder by", " rad"),
                Limit::Truncation => ("contact truncated by", " m"),
                Limit::Reversal => ("reversed contact of the sine", ""),
                Limit::Friction => ("friction demand", " of the force"),
                Limit::InnerContact => ("gap", " m"),
            };
            f.write_str(if i == 0 { "" } else { "; " })?;
            let (race, allowed) = (race.name(), self.allowed(limit));
            write!(f, "{what} {value:.3e}{unit} at ball {ball}'s {race} race")?;
            if allowed > T::ZERO {
                write!(f, ", above {allowed:.3e}")?;
            }
        }
        if self.unloaded > 0 {
            let plural = if self.unloaded == 1 { "" } else { "s" };
            write!(f, " ({} ball{plural} unloaded)", self.unloaded)?;
        }
        Ok(())
    }
}

/// [`Margins`] as `serde` data: the limits that are passed, and the worst contact of each.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(bound(
    serialize = "T: Real + crate::serialize::Written",
    deserialize = "T: Real + crate::serialize::Read<'de>"
))]
struct MarginsData<T> {
    limits: Limits<T>,
    passed: LimitSet,
    worst: Worst<T>,
    /// Sine and cosine of the shoulder's margin, which the angle has but for rounding.
    past: Pair<T>,
    unloaded: u16,
}

/// A margin for each of [`Limit::ALL`].
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Worst<T> {
    peak_pressure: Option<Margin<T>>,
    shoulder: Option<Margin<T>>,
    truncation: Option<Margin<T>>,
    reversal: Option<Margin<T>>,
    friction: Option<Margin<T>>,
    inner_contact: Option<Margin<T>>,
}

#[cfg(feature = "serde")]
impl<T: Real> From<Margins<T>> for MarginsData<T> {
    fn from(margins: Margins<T>) -> Self {
        Self {
            limits: margins.limits,
            passed: margins.passed(),
            worst: Worst {
                peak_pressure: margins.get(Limit::PeakPressure),
                shoulder: margins.get(Limit::Shoulder),
                truncation: margins.get(Limit::Truncation),
                reversal: margins.get(Limit::Reversal),
                friction: margins.get(Limit::Friction),
                inner_contact: margins.get(Limit::InnerContact),
            },
            past: margins.past,
            unloaded: margins.unloaded,
        }
    }
}

#[cfg(feature = "serde")]
impl<T: Real> From<MarginsData<T>> for Margins<T> {
    fn from(data: MarginsData<T>) -> Self {
        let mut margins = Self::new(data.limits);
        (margins.past, margins.unloaded) = (data.past, data.unloaded);
        let Worst {
            peak_pressure,
            shoulder,
            truncation,
            reversal,
            friction,
            inner_contact,
        } = data.worst;
        let all: [_; Limit::ALL.len()] = [
            peak_pressure,
            shoulder,
            truncation,
            reversal,
            friction,
            inner_contact,
        ];
        for (worst, read) in margins.worst.iter_mut().zip(all) {
            *worst = read.unwrap_or(*worst);
        }
        if shoulder.is_some() {
            margins.worst[Limit::Shoulder as usize].value = measure(data.past);
        }
        margins
    }
}

/// The names of its limits.
#[cfg(feature = "serde")]
impl serde::Serialize for LimitSet {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeSeq;
        let mut names = serializer.serialize_seq(Some(self.iter().count()))?;
        for limit in self.iter() {
            names.serialize_element(&limit)?;
        }
        names.end()
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for LimitSet {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Names;
        impl<'de> serde::de::Visitor<'de> for Names {
            type Value = LimitSet;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("names of limits")
            }

            fn visit_seq<A: serde::de::SeqAccess<'de>>(
                self,
                mut names: A,
            ) -> Result<LimitSet, A::Error> {
                let mut set = LimitSet::default();
                while let Some(limit) = names.next_element()? {
                    set = set.with(limit);
                }
                Ok(set)
            }
        }
        deserializer.deserialize_seq(Names)
    }
}
