//! Units as programs write them.

use Dimension::{Force, Moment, Speed, Temperature, Time};

/// Dimension of a number, with the unit that the library has for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// Seconds.
    Time,
    /// Newtons.
    Force,
    /// Newton metres.
    Moment,
    /// Revolutions per minute.
    Speed,
    /// Degrees Celsius.
    Temperature,
}

/// A unit. Its numbers less `zero`, times `times`, over `over`, are numbers of the first unit of the dimension: powers of ten
/// are divided by, which rounds once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its dimension.
    pub dimension: Dimension,
    /// Its names, the first as messages have it; compared by [`plain`]. Behind `=`, small letters and capitals differ.
    names: &'static str,
    times: f64,
    over: f64,
    zero: f64,
}

const fn unit(dimension: Dimension, names: &'static str, times: f64, over: f64) -> Unit {
    Unit {
        dimension,
        names,
        times,
        over,
        zero: 0.0,
    }
}

/// Pounds, inches and feet by the international agreement of 1959, the standard acceleration of 1901.
const POUND_FORCE: f64 = 0.453_592_37 * KILOPOND;
const KILOPOND: f64 = 9.806_65;

#[rustfmt::skip]
const UNITS: [Unit; 30] = [
    unit(Time, "s sec secs second seconds sek sekunde sekunden", 1.0, 1.0),
    unit(Time, "ms msec", 1.0, 1e3),
    unit(Time, "us µs μs usec", 1.0, 1e6),
    unit(Time, "ns nsec", 1.0, 1e9),
    unit(Time, "min minute minutes", 60.0, 1.0),
    unit(Time, "h hour hours std", 3600.0, 1.0),
    unit(Force, "N newton newtons", 1.0, 1.0),
    unit(Force, "kN", 1e3, 1.0),
    unit(Force, "daN", 10.0, 1.0),
    unit(Force, "=mN", 1.0, 1e3),
    unit(Force, "=MN", 1e6, 1.0),
    unit(Force, "lbf lb lbs", POUND_FORCE, 1.0),
    unit(Force, "kgf kp", KILOPOND, 1.0),
    unit(Moment, "Nm newtonmeter", 1.0, 1.0),
    unit(Moment, "Nmm", 1.0, 1e3),
    unit(Moment, "Ncm", 1.0, 1e2),
    unit(Moment, "kNm", 1e3, 1.0),
    unit(Moment, "=mNm", 1.0, 1e3),
    unit(Moment, "=MNm", 1e6, 1.0),
    unit(Moment, "kgfm kpm", KILOPOND, 1.0),
    unit(Moment, "kgfcm kpcm", KILOPOND, 1e2),
    unit(Moment, "lbfin lbin inlb inlbf lbfinch", 0.0254 * POUND_FORCE, 1.0),
    unit(Moment, "lbfft lbft ftlb ftlbf", 0.3048 * POUND_FORCE, 1.0),
    unit(Speed, "rpm 1/min min1 u/min r/min rev/min tr/min giri/min ot/min /min rounds/min upm", 1.0, 1.0),
    unit(Speed, "Hz 1/s s1 rps rev/s r/s u/s", 60.0, 1.0),
    unit(Speed, "krpm", 1e3, 1.0),
    unit(Speed, "rad/s rads1 radps", 30.0, std::f64::consts::PI),
    unit(Temperature, "degC c celsius", 1.0, 1.0),
    Unit { dimension: Temperature, names: "K kelvin", times: 1.0, over: 1.0, zero: 273.15 },
    Unit { dimension: Temperature, names: "degF f fahrenheit", times: 5.0, over: 9.0, zero: 32.0 },
];

/// Units of a probe's readings, and their micrometres.
pub(crate) const LENGTHS: [(&str, f64); 5] = [
    ("um", 1.0),
    ("µm", 1.0),
    ("nm", 1e-3),
    ("mm", 1e3),
    ("m", 1e6),
];

/// A unit's name without blanks and the marks of products and powers: `N*m`, `[N m]` and `Nm` are one. None of a name with
/// other marks.
pub(crate) fn plain(name: &str) -> Option<String> {
    let mut plain = String::new();
    for c in name.trim_matches(['[', ']', '(', ')', '"', ' ']).chars() {
        match c {
            '¹' => plain.push('1'),
            ' ' | '*' | '·' | '⋅' | '.' | '^' | '-' | '_' | '°' | '⁻' | '\u{a0}' => {}
            c if c.is_alphanumeric() || c == '/' => plain.push(c),
            _ => return None,
        }
    }
    Some(plain)
}

impl Unit {
    /// The unit of this name. `mN` and `MN` differ, `mn` is none; of all others, small letters and capitals are one.
    pub fn named(name: &str) -> Option<Self> {
        let name = plain(name)?;
        let small = name.to_lowercase();
        let is = |one: &str| match one.strip_prefix('=') {
            Some(one) => one == name,
            None => one.to_lowercase() == small,
        };
        let has = |unit: &&Self| unit.names.split(' ').any(is);
        UNITS.iter().find(has).copied()
    }

    /// The unit of the library's numbers of this dimension.
    pub fn of(dimension: Dimension) -> Self {
        let found = UNITS.iter().find(|unit| unit.dimension == dimension);
        *found.unwrap_or(&UNITS[0])
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        let name = self.names.split(' ').next().unwrap_or_default();
        name.trim_start_matches('=')
    }

    /// Names of the units of a dimension.
    pub fn names(dimension: Dimension) -> String {
        let units = UNITS.iter().filter(|unit| unit.dimension == dimension);
        units.map(Self::name).collect::<Vec<_>>().join(", ")
    }

    /// A number of this unit in the library's.
    pub fn read(&self, x: f64) -> f64 {
        (x - self.zero) * self.times / self.over
    }
}
