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

/// A unit. Its numbers times `times`, over `over`, plus `plus`, are numbers of the first unit of the dimension: powers of ten
/// are divided by, which rounds once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Its dimension.
    pub dimension: Dimension,
    /// Its names, the first as messages have it; compared by [`plain`].
    names: &'static str,
    times: f64,
    over: f64,
    plus: f64,
}

const fn unit(dimension: Dimension, names: &'static str, times: f64, over: f64) -> Unit {
    Unit {
        dimension,
        names,
        times,
        over,
        plus: 0.0,
    }
}

/// Pounds, inches and feet by the international agreement of 1959, the standard acceleration of 1901.
const POUND_FORCE: f64 = 0.453_592_37 * KILOPOND;
const KILOPOND: f64 = 9.806_65;

#[rustfmt::skip]
const UNITS: [Unit; 21] = [
    unit(Time, "s sec secs second seconds sek sekunde sekunden", 1.0, 1.0),
    unit(Time, "ms msec", 1.0, 1e3),
    unit(Time, "us µs μs usec", 1.0, 1e6),
    unit(Time, "min minute minutes", 60.0, 1.0),
    unit(Time, "h hour hours std", 3600.0, 1.0),
    unit(Force, "N newton newtons", 1.0, 1.0),
    unit(Force, "kN", 1e3, 1.0),
    unit(Force, "daN", 10.0, 1.0),
    unit(Force, "lbf lb lbs", POUND_FORCE, 1.0),
    unit(Force, "kgf kp", KILOPOND, 1.0),
    unit(Moment, "Nm newtonmeter", 1.0, 1.0),
    unit(Moment, "Nmm", 1.0, 1e3),
    unit(Moment, "Ncm", 1.0, 1e2),
    unit(Moment, "kNm", 1e3, 1.0),
    unit(Moment, "lbfin lbin inlb inlbf lbfinch", 0.0254 * POUND_FORCE, 1.0),
    unit(Moment, "lbfft lbft ftlb ftlbf", 0.3048 * POUND_FORCE, 1.0),
    unit(Speed, "rpm 1/min min1 u/min r/min rev/min tr/min /min rounds/min upm", 1.0, 1.0),
    unit(Speed, "Hz 1/s s1 rps rev/s r/s u/s", 60.0, 1.0),
    unit(Speed, "rad/s rads1", 30.0, std::f64::consts::PI),
    unit(Temperature, "degC c celsius", 1.0, 1.0),
    Unit { dimension: Temperature, names: "K kelvin", times: 1.0, over: 1.0, plus: -273.15 },
];

/// A unit's name without blanks, capitals, and the marks of products and powers: `N*m`, `[N m]` and `Nm` are one. None of a
/// name with other marks.
fn plain(name: &str) -> Option<String> {
    let mut plain = String::new();
    for c in name.trim_matches(['[', ']', '(', ')', '"']).chars() {
        match c {
            '¹' => plain.push('1'),
            ' ' | '*' | '·' | '⋅' | '.' | '^' | '-' | '_' | '°' | '⁻' => {}
            c if c.is_alphanumeric() || c == '/' => plain.extend(c.to_lowercase()),
            _ => return None,
        }
    }
    Some(plain)
}

impl Unit {
    /// The unit of this name. `mN` and `MN` are none: small letters and capitals are one here.
    pub fn named(name: &str) -> Option<Self> {
        let name = plain(name)?;
        let is = |one: &&str| one.to_lowercase() == name;
        let has = |unit: &&Self| unit.names.split(' ').any(|one| is(&one));
        UNITS.iter().find(has).copied()
    }

    /// The unit of the library's numbers of this dimension.
    pub fn of(dimension: Dimension) -> Self {
        let found = UNITS.iter().find(|unit| unit.dimension == dimension);
        *found.unwrap_or(&UNITS[0])
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        self.names.split(' ').next().unwrap_or_default()
    }

    /// Names of the units of a dimension.
    pub fn names(dimension: Dimension) -> String {
        let units = UNITS.iter().filter(|unit| unit.dimension == dimension);
        units.map(Self::name).collect::<Vec<_>>().join(", ")
    }

    /// The unit of which `count` are one of these.
    pub fn counted(self, count: f64) -> Self {
        Self {
            over: self.over * count,
            ..self
        }
    }

    /// A number of this unit in the library's.
    pub fn read(&self, x: f64) -> f64 {
        let scaled = x * self.times / self.over;
        // Nothing is added to a zero, which may have a sign.
        if self.plus == 0.0 {
            scaled
        } else {
            scaled + self.plus
        }
    }
}

/// Refuses a temperature that no bearing survives: mostly one in kelvin.
pub fn celsius(t: f64) -> Result<f64, String> {
    if t > 200.0 {
        return Err(format!(
            "{t} is above 200 deg C; if it is in kelvin, name the unit, such as t_inner_k"
        ));
    }
    Ok(t)
}
